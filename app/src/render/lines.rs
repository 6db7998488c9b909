//! Polylines: one instance per segment, constant width on the picture.

use super::{
    Frame,
    globals::Stage,
    gpu::{Color, Recipe, Sampled, Stream, shader},
};
use bytemuck::{Pod, Zeroable};

/// One segment relative to the scene centre; see `Segment` in `lines.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct Segment {
    start: [f32; 3],
    end: [f32; 3],
    srgb: [f32; 4],
    /// Half width, dash length, length before the start, in pixels; unused.
    style: [f32; 4],
}

/// The segments of a frame. Vertices that are not finite interrupt their line.
fn segments(frame: &Frame, stage: &Stage<'_>) -> Vec<Segment> {
    let mut segments = Vec::new();
    for line in &frame.lines {
        let half_width = line.width_px * stage.pixels_per_point / 2.0;
        let dash = line.dash_px.filter(|d| *d > 0.0).unwrap_or(0.0) * stage.pixels_per_point;
        let mut length_px = 0.0;
        for pair in line.points.windows(2) {
            let [start, end] = [pair[0], pair[1]].map(|p| (p - stage.scene_center).map(|v| v as f32));
            if !(start.iter().chain(&end).all(|v| v.is_finite()) && half_width.is_finite()) {
                continue;
            }
            let style = [half_width, dash, length_px as f32, 0.0];
            segments.push(Segment { start: start.into(), end: end.into(), srgb: line.color, style });
            let project = |end: usize| stage.camera.project(&pair[end], stage.size);
            // Where an end is not seen, dashes may jump; nobody sees that either.
            if dash > 0.0
                && let (Some(from), Some(to)) = (project(0), project(1))
            {
                length_px = (length_px + (to - from).norm()) % f64::from(2.0 * dash);
            }
        }
    }
    segments
}

/// The segments on the GPU and their pipeline.
pub(super) struct Lines {
    segments: Stream,
    count: u32,
    pipeline: Sampled,
}

impl Lines {
    pub(super) fn new(device: &wgpu::Device, globals: &wgpu::BindGroupLayout) -> Self {
        let shader = shader(device, "lines", concat!(include_str!("globals.wgsl"), include_str!("lines.wgsl")));
        let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32x4];
        let pipeline = Recipe {
            label: "lines",
            shader: &shader,
            vertex: "vs_line",
            fragment: "fs_line",
            layouts: &[globals],
            buffers: &[wgpu::VertexBufferLayout {
                array_stride: size_of::<Segment>() as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &attributes,
            }],
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            color: Color::Mix,
            depth: Some((wgpu::CompareFunction::Greater, false)),
            samples: 1,
        }
        .make_sampled(device);
        Self { segments: Stream::new("lines", wgpu::BufferUsages::VERTEX), count: 0, pipeline }
    }

    /// Writes the picture's segments.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, frame: &Frame, stage: &Stage<'_>) {
        let segments = segments(frame, stage);
        self.count = segments.len() as u32;
        self.segments.write(device, queue, bytemuck::cast_slice(&segments));
    }

    /// Draws them.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, smooth: bool) {
        if let Some(segments) = self.segments.buffer().filter(|_| self.count > 0) {
            pass.set_pipeline(self.pipeline.get(smooth));
            pass.set_vertex_buffer(0, segments.slice(..));
            pass.draw(0..4, 0..self.count);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::render::{Camera, LineDraw};

    #[test]
    fn dashes_go_on_across_joints_and_gaps_interrupt() {
        let camera = Camera::default();
        let point = |t: f64| camera.target + camera.right() * t;
        let mut points: Vec<_> = (0..4).map(|k| point(0.01 * f64::from(k))).collect();
        points[3].x = f64::NAN;
        let frame = Frame { lines: vec![LineDraw::new(points, [1.0; 4], 2.0).dashed(50.0)], ..Frame::default() };
        let size = [1000.0, 1000.0];
        let stage = Stage { camera: &camera, scene_center: Point3::origin(), size, pixels_per_point: 2.0 };
        let made = segments(&frame, &stage);
        assert_eq!(made.len(), 2);
        assert_eq!(made[0].style[..2], [2.0, 100.0]);
        let px = 0.01 / camera.m_per_px(&camera.target, size);
        assert!((f64::from(made[1].style[2]) - px).abs() < 1e-3);
    }
}
