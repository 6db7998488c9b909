//! One view of an object with its fits side by side: what was seen, the whole surface, the fitted shapes.

use std::sync::Arc;

use endcomfort_core::experiment::ObjectView;
use endcomfort_core::superquadric::Superquadric;
use image::{RgbaImage, imageops};
use nalgebra::{Isometry3, Point3};

use crate::compose::Palette;
use crate::render::{
    Bounds, Camera, Frame, MeshDraw, Offscreen, OffscreenError, PointsDraw, Surface, Theme, View, bytes_of,
};

/// Size of one of the two pictures, pixels.
const TILE_PX: [u32; 2] = [480, 400];
/// Opacity of a fitted shape: the points behind it still show.
const FIT_OPACITY: f32 = 0.45;
/// Diameter of a point, metres.
const POINT_M: f32 = 0.0016;

/// Draws the fits of one view beside each other, upright as the object stands; a missing fit shows the points alone.
///
/// The points that the camera saw have the colour of clouds, the object's whole surface the colour of goals.
///
/// # Errors
/// [`OffscreenError`] when the picture cannot be drawn.
pub fn draw_fits(
    offscreen: &mut Offscreen,
    view: &ObjectView,
    fits: &[Option<Superquadric>],
    theme: Theme,
) -> Result<RgbaImage, OffscreenError> {
    let palette = Palette::of(theme);
    let X_OF = view.X_FO.inverse();
    let in_object = |points: &[Point3<f64>]| Arc::new(points.iter().map(|p| X_OF * p).collect::<Vec<_>>());
    let (seen, surface) = (in_object(&view.points), in_object(&view.surface));
    let Some(first) = surface.first() else { return Ok(RgbaImage::new(1, 1)) };
    let (min, max) = surface.iter().fold((*first, *first), |(min, max), p| (min.inf(p), max.sup(p)));
    let mut camera = Camera { yaw_rad: 0.9, pitch_rad: 0.45, ..Camera::default() };
    camera.frame(&Bounds { min, max }, TILE_PX.map(f64::from));

    let mut picture = RgbaImage::new(TILE_PX[0] * fits.len() as u32, TILE_PX[1]);
    for (column, fit) in (0..).zip(fits) {
        let mut frame = Frame::default();
        for (points, color) in [(&surface, palette.goal), (&seen, palette.cloud)] {
            let colors = Arc::new(vec![bytes_of(color)]);
            frame.points.push(PointsDraw { points: points.clone(), colors, diameter_m: POINT_M });
        }
        if let Some(fit) = fit {
            let [red, green, blue, _] = palette.target;
            frame.meshes.push(MeshDraw {
                mesh: Arc::new(fit.transformed(&X_OF).mesh(12)),
                X_WM: Isometry3::identity(),
                color: [red, green, blue, FIT_OPACITY],
                surface: Surface::Satin,
                pick_id: 0,
            });
        }
        let tile = offscreen.render(&frame, &View::new(camera, theme, TILE_PX))?;
        imageops::replace(&mut picture, &tile, i64::from(column * TILE_PX[0]), 0);
    }
    Ok(picture)
}
