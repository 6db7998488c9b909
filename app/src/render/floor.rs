//! The background and the floor: a radial gradient, a fading grid, and the shadow that falls on z = 0.

use super::gpu::{Color, Recipe, Sampled, shader};

/// Pipelines of background and floor.
pub(super) struct Floor {
    background: Sampled,
    surface: wgpu::RenderPipeline,
    visible: Sampled,
}

impl Floor {
    pub(super) fn new(device: &wgpu::Device, globals: &wgpu::BindGroupLayout, light: &wgpu::BindGroupLayout) -> Self {
        let source = concat!(include_str!("globals.wgsl"), include_str!("shading.wgsl"), include_str!("floor.wgsl"));
        let shader = shader(device, "floor", source);
        let surface = Recipe {
            label: "floor surface",
            shader: &shader,
            vertex: "vs_floor",
            fragment: "fs_floor_depth",
            layouts: &[globals],
            buffers: &[],
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            color: Color::Replace,
            depth: Some((wgpu::CompareFunction::Greater, true)),
            samples: 1,
        };
        let visible = Recipe {
            label: "floor",
            fragment: "fs_floor",
            layouts: &[globals, light],
            color: Color::Mix,
            depth: Some((wgpu::CompareFunction::Greater, false)),
            ..surface
        };
        let background = Recipe {
            label: "background",
            vertex: "vs_background",
            fragment: "fs_background",
            color: Color::Replace,
            depth: Some((wgpu::CompareFunction::Always, false)),
            topology: wgpu::PrimitiveTopology::TriangleList,
            ..visible
        };
        Self {
            background: background.make_sampled(device),
            surface: surface.make(device),
            visible: visible.make_sampled(device),
        }
    }

    /// Fills the picture.
    pub(super) fn draw_background(&self, pass: &mut wgpu::RenderPass<'_>, smooth: bool) {
        pass.set_pipeline(self.background.get(smooth));
        pass.draw(0..3, 0..1);
    }

    /// Puts the floor among the surfaces that take shadow.
    pub(super) fn draw_surface(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.surface);
        pass.draw(0..4, 0..1);
    }

    /// Draws shadow and grid over what is there.
    pub(super) fn draw_visible(&self, pass: &mut wgpu::RenderPass<'_>, smooth: bool) {
        pass.set_pipeline(self.visible.get(smooth));
        pass.draw(0..4, 0..1);
    }
}
