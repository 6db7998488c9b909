//! From where and how a frame is looked at.

use super::{Camera, Cut, Theme};

/// Everything about a picture that is not its content.
#[derive(Clone, Debug)]
pub struct View {
    /// The eye.
    pub camera: Camera,
    /// Background, floor and light.
    pub theme: Theme,
    /// Width and height of the picture in physical pixels.
    pub size_px: [u32; 2],
    /// Physical pixels per logical pixel: line widths and the least point size follow it.
    pub pixels_per_point: f32,
    /// Leave the background clear (alpha 0), for figures; the floor then shows only its shadow and its grid.
    pub transparent: bool,
    /// Draw the floor's grid.
    pub grid: bool,
    /// What lies on one side of it is not drawn.
    pub cut: Option<Cut>,
}

impl View {
    /// An opaque view with the grid, at one physical pixel per logical pixel.
    pub fn new(camera: Camera, theme: Theme, size_px: [u32; 2]) -> Self {
        Self { camera, theme, size_px, pixels_per_point: 1.0, transparent: false, grid: true, cut: None }
    }
}
