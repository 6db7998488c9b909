//! What every shader knows: the uniform block behind `globals.wgsl`, filled from a view.

use bytemuck::{Pod, Zeroable};
use nalgebra::{Matrix4, Point3, Vector3};

use super::{Camera, Cut, Projection, Quality, View, lighting::Light, theme::Look};

/// The uniform block; see `globals.wgsl` for what each value means.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct Globals {
    clip_from_world: [[f32; 4]; 4],
    eye: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    forward: [f32; 4],
    size: [f32; 4],
    mask_size: [f32; 4],
    depth: [f32; 4],
    light_x: [f32; 4],
    light_y: [f32; 4],
    light_z: [f32; 4],
    light_size: [f32; 4],
    key: [f32; 4],
    fill_direction: [f32; 4],
    fill: [f32; 4],
    sky: [f32; 4],
    ground: [f32; 4],
    srgb_background_center: [f32; 4],
    srgb_background_edge: [f32; 4],
    srgb_grid: [f32; 4],
    floor: [f32; 4],
    taps: [f32; 4],
    options: [f32; 4],
    cut: [f32; 4],
}

/// How a picture's sizes on screen and in the world hang together.
pub(super) struct Stage<'a> {
    pub(super) camera: &'a Camera,
    /// What positions on the GPU are relative to.
    pub(super) scene_center: Point3<f64>,
    /// Width and height in pixels.
    pub(super) size: [f64; 2],
    pub(super) pixels_per_point: f32,
}

/// Where the bodies of a frame are, as seen from the eye.
pub(super) struct Extent {
    /// Depths between which bodies lie, metres.
    pub(super) depths_m: [f64; 2],
    /// Middle of the bodies in the world.
    pub(super) center: Point3<f64>,
    /// Radius about it, metres.
    pub(super) radius_m: f64,
}

impl Globals {
    pub(super) fn new(
        view: &View,
        look: &Look,
        light: &Light,
        scene_center: &Point3<f64>,
        extent: &Extent,
        size: [u32; 2],
        mask: Option<([u32; 2], Quality)>,
    ) -> Self {
        let camera = &view.camera;
        let size = size.map(|side| f64::from(side.max(1)));
        let clip_from_world =
            camera.clip_from_view(size) * camera.view_from_world() * Matrix4::new_translation(&scene_center.coords);
        let half_height = camera.half_height();
        let half_width = half_height * size[0] / size[1];
        let perspective = camera.projection == Projection::Perspective;
        let mask_px = mask.map_or([1, 1], |(size, _)| size).map(f64::from);
        let [blockers, shadow, occlusion] = mask.map_or([0.0; 3], |(_, quality)| quality.taps());
        // The floor around the bodies takes shadow too.
        let nearest = (extent.depths_m[0] - 0.05).max(camera.near_m());
        let farthest = (extent.depths_m[1] + 1.0 + 0.3 * extent.radius_m).max(nearest + 1.0);
        // Lines lie a thousandth nearer than they are, so that they win against the surface they lie on.
        let lift = if perspective { [1.001, 0.0] } else { [1.0, 2e-6] };
        let floor_radius = (extent.radius_m * 3.5).max(3.0).min(60.0);
        let (edge, center) = (look.background_edge, look.background_center);
        let grid = if view.grid { look.grid[3] } else { 0.0 };
        Self {
            clip_from_world: clip_from_world.map(|v| v as f32).into(),
            eye: axis(&(camera.eye() - scene_center), if perspective { 1.0 } else { 0.0 }),
            right: axis(&camera.right(), half_width),
            up: axis(&camera.up(), half_height),
            forward: axis(&-camera.backward(), f64::from(view.pixels_per_point)),
            size: [size[0], size[1], 1.0 / size[0], 1.0 / size[1]].map(|v| v as f32),
            mask_size: [mask_px[0], mask_px[1], mask_px[0] / size[0], mask_px[1] / size[1]].map(|v| v as f32),
            depth: [nearest as f32, (farthest - nearest) as f32, lift[0], lift[1]],
            light_x: axis(&light.axes[0], light.offset_m[0]),
            light_y: axis(&light.axes[1], light.offset_m[1]),
            light_z: axis(&light.axes[2], light.offset_m[2]),
            light_size: [light.extent_m[0], light.extent_m[1], light.extent_m[2], f64::from(light.side_px)]
                .map(|v| v as f32),
            key: with(look.key, 0.075),
            fill_direction: axis(&light.fill_direction, 0.0),
            fill: with(look.fill, 0.0),
            sky: with(look.sky, 0.0),
            ground: with(look.ground, 0.0),
            srgb_background_center: with(center, 1.0),
            srgb_background_edge: with(edge, 1.0),
            srgb_grid: [look.grid[0], look.grid[1], look.grid[2], grid],
            floor: [
                (extent.center.x - scene_center.x) as f32,
                (extent.center.y - scene_center.y) as f32,
                -scene_center.z as f32,
                floor_radius as f32,
            ],
            taps: [blockers, shadow, occlusion, 0.0],
            options: [
                f32::from(u8::from(view.transparent)),
                look.floor_shadow,
                (extent.radius_m * 0.075).max(0.02).min(0.12) as f32,
                f32::from(u8::from(mask.is_some())),
            ],
            cut: Cut::plane(view.cut, scene_center),
        }
    }
}

fn axis(vector: &Vector3<f64>, w: f64) -> [f32; 4] {
    [vector.x as f32, vector.y as f32, vector.z as f32, w as f32]
}

fn with(color: [f32; 3], w: f32) -> [f32; 4] {
    [color[0], color[1], color[2], w]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_block_has_the_size_that_the_shader_expects() {
        // A matrix and 23 vectors, all aligned to 16 bytes.
        assert_eq!(size_of::<Globals>(), 64 + 23 * 16);
    }
}
