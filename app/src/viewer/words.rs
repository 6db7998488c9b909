//! Words over a picture that no window shows: the same labels and legends, drawn by a small interface of its own.

use egui::{Context, FullOutput, Pos2, RawInput, Rect, Theme, Ui, ViewportId, vec2};
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};

use super::theme;
use crate::render::Target;

/// What draws words into targets.
pub(crate) struct Words {
    ctx: Context,
    renderer: Renderer,
}

impl Words {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let ctx = Context::default();
        theme::install(&ctx);
        // Colours as they are: no noise against steps, so that equal pictures are equal files.
        let options = RendererOptions { dithering: false, ..RendererOptions::default() };
        Self { ctx, renderer: Renderer::new(device, wgpu::TextureFormat::Rgba8Unorm, options) }
    }

    /// Draws what `add` puts into a `Ui` over what the target shows already; the `Ui` is as large as the target, at
    /// `scale` pixels per point.
    pub(crate) fn paint(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        target: &Target,
        (dark, scale): (bool, f32),
        add: impl FnMut(&mut Ui),
    ) {
        let size_px = target.size();
        let size = vec2(size_px[0] as f32, size_px[1] as f32) / scale;
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, size)),
            max_texture_side: Some(device.limits().max_texture_dimension_2d as usize),
            ..RawInput::default()
        };
        if let Some(window) = input.viewports.get_mut(&ViewportId::ROOT) {
            window.native_pixels_per_point = Some(scale);
        }
        self.ctx.set_theme(if dark { Theme::Dark } else { Theme::Light });
        let output = self.ctx.run_ui(input, add);
        self.draw(
            (device, queue),
            target,
            output,
            ScreenDescriptor { size_in_pixels: size_px, pixels_per_point: scale },
        );
    }

    fn draw(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        target: &Target,
        mut output: FullOutput,
        screen: ScreenDescriptor,
    ) {
        #[expect(clippy::iter_over_hash_type, reason = "each texture has its own place")]
        for (id, images) in output.textures_delta.set.drain() {
            for image in images {
                self.renderer.update_texture(device, queue, id, &image);
            }
        }
        let shapes = self.ctx.tessellate(output.shapes, screen.pixels_per_point);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("words") });
        let before = self.renderer.update_buffers(device, queue, &mut encoder, &shapes, &screen);
        let over = wgpu::RenderPassColorAttachment {
            view: target.color_view(),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        };
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("words"),
            color_attachments: &[Some(over)],
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        self.renderer.render(&mut pass.forget_lifetime(), &shapes, &screen);
        queue.submit(before.into_iter().chain([encoder.finish()]));
        #[expect(clippy::iter_over_hash_type, reason = "each texture has its own place")]
        for id in output.textures_delta.free.drain() {
            self.renderer.free_texture(&id);
        }
    }
}
