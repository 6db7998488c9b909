//! The key light's shadow map, and the mask of soft shadow and ambient occlusion made from it.

use nalgebra::{Point3, Vector3};

use super::{
    gpu::{self, COLOR_FORMAT, Color, DEPTH_FORMAT, Recipe},
    target::Masks,
};

/// Side of the shadow map in texels: the most that every WebGL2 device has.
const SHADOW_SIDE: u32 = 2048;

/// From the bodies to the key light: above, before and to the left of a robot that looks along +x.
const TO_KEY: [f64; 3] = [0.42, -0.46, 1.0];
/// From the bodies to the fill light.
const TO_FILL: [f64; 3] = [-0.15, 0.85, 0.5];

/// The key light, fitted to what casts shadow, relative to the scene centre.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Light {
    /// Across, along and away from the light.
    pub(super) axes: [Vector3<f64>; 3],
    /// Added to the coordinates along the axes, so that the fitted volume starts at 0.
    pub(super) offset_m: [f64; 3],
    /// Size of the fitted volume.
    pub(super) extent_m: [f64; 3],
    /// Side of the map in texels.
    pub(super) side_px: u32,
    /// Towards the fill light.
    pub(super) fill_direction: Vector3<f64>,
}

impl Light {
    /// A light whose map just holds these spheres (centre relative to the scene centre, radius in metres). The volume
    /// grows in steps of a quarter metre, so that shadow edges keep still while a robot moves.
    pub(super) fn fitted(spheres: impl Iterator<Item = (Point3<f64>, f64)>) -> Self {
        let z = -unit(TO_KEY);
        let x = unit([-z.y, z.x, 0.0]);
        let axes = [x, z.cross(&x), z];
        let (mut least, mut most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (center, radius) in spheres {
            for (k, axis) in axes.iter().enumerate() {
                let along = axis.dot(&center.coords);
                least[k] = least[k].min(along - radius);
                most[k] = most[k].max(along + radius);
            }
        }
        if least[0] > most[0] {
            (least, most) = ([-0.5; 3], [0.5; 3]);
        }
        let step = 0.25;
        let start = least.map(|v| ((v - 0.01) / step).floor() * step);
        let end = most.map(|v| ((v + 0.01) / step).ceil() * step);
        Self {
            axes,
            offset_m: start.map(|v| -v),
            extent_m: [end[0] - start[0], end[1] - start[1], end[2] - start[2]],
            side_px: SHADOW_SIDE,
            fill_direction: unit(TO_FILL),
        }
    }
}

fn unit(direction: [f64; 3]) -> Vector3<f64> {
    let vector = Vector3::from(direction);
    vector / vector.norm()
}

/// Textures and pipelines of shadow and mask. The bodies themselves are drawn by their own pipelines.
pub(super) struct Lighting {
    shadow: wgpu::TextureView,
    shadow_depth: wgpu::TextureView,
    layout: wgpu::BindGroupLayout,
    mask: wgpu::RenderPipeline,
    smooth: wgpu::RenderPipeline,
}

impl Lighting {
    pub(super) fn new(device: &wgpu::Device, globals: &wgpu::BindGroupLayout) -> Self {
        let layout = gpu::textures_layout(device, "mask inputs", 2);
        let source = concat!(include_str!("globals.wgsl"), include_str!("lighting.wgsl"));
        let shader = gpu::shader(device, "lighting", source);
        let recipe = Recipe {
            label: "mask",
            shader: &shader,
            vertex: "vs_screen",
            fragment: "fs_mask",
            layouts: &[globals, &layout],
            buffers: &[],
            topology: wgpu::PrimitiveTopology::TriangleList,
            color: Color::Replace,
            depth: None,
            samples: 1,
        };
        let mask = recipe.make(device);
        let smooth = Recipe { label: "smooth mask", fragment: "fs_smooth", ..recipe }.make(device);
        let size = [SHADOW_SIDE; 2];
        let loaded = wgpu::TextureUsages::TEXTURE_BINDING;
        let none = wgpu::TextureUsages::empty();
        let shadow = gpu::picture(device, "shadow", size, COLOR_FORMAT, 1, loaded).1;
        let shadow_depth = gpu::picture(device, "shadow depth", size, DEPTH_FORMAT, 1, none).1;
        Self { shadow, shadow_depth, layout, mask, smooth }
    }

    /// The shadow map: depth from the light in three bytes, alpha 1 where nothing is.
    pub(super) fn shadow(&self) -> &wgpu::TextureView {
        &self.shadow
    }

    /// The pass into which casters are drawn.
    pub(super) fn shadow_pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        gpu::pass(encoder, "shadow", &self.shadow, None, wgpu::Color::WHITE, Some((&self.shadow_depth, 1.0)))
    }

    /// Makes the mask from the surfaces and the shadow map.
    pub(super) fn draw_mask(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        globals: &wgpu::BindGroup,
        masks: &Masks,
    ) {
        let steps = [
            (&self.mask, &masks.surfaces, &masks.rough, "mask"),
            (&self.smooth, &masks.rough, &masks.smooth, "smooth mask"),
        ];
        for (pipeline, from, to, label) in steps {
            let textures = gpu::bind_textures(device, &self.layout, &[from, &self.shadow]);
            let mut pass = gpu::pass(encoder, label, to, None, wgpu::Color::WHITE, None);
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, globals, &[]);
            pass.set_bind_group(1, &textures, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fitted_volume_holds_every_sphere() {
        let spheres = [(Point3::new(0.3, 0.2, 0.7), 0.4), (Point3::new(-1.0, 2.0, 0.1), 0.05)];
        let light = Light::fitted(spheres.into_iter());
        for (center, radius) in spheres {
            for k in 0..3 {
                let along = light.axes[k].dot(&center.coords) + light.offset_m[k];
                assert!(along - radius >= 0.0 && along + radius <= light.extent_m[k]);
            }
        }
        assert!(light.axes[2].z < 0.0, "light falls");
        assert!((light.axes[0].cross(&light.axes[1]) - light.axes[2]).norm() < 1e-12);
    }

    #[test]
    fn without_casters_the_volume_is_still_a_volume() {
        let light = Light::fitted(std::iter::empty());
        assert!(light.extent_m.iter().all(|&e| e > 0.0 && e.is_finite()));
    }
}
