//! Clouds: polygons that face the eye, uploaded once per cloud.
//!
//! The vertex shader fetches its point from a texture: drawing a point as an instance of four corners costs a machine
//! without a GPU 9 µs each, a hundred times as much as the corners themselves.

use std::{
    collections::BTreeMap,
    sync::{Arc, Weak},
};

use bytemuck::{Pod, Zeroable};
use nalgebra::Point3;
use wgpu::util::DeviceExt as _;

use super::{
    Frame, PointsDraw,
    globals::Stage,
    gpu::{Color, Recipe, Sampled, Stream, bind_textures, shader},
};

/// Least diameter on the picture, in logical pixels.
const LEAST_PX: f32 = 1.5;
/// Distance between the uniform blocks of two clouds: the coarsest alignment of any device.
const BLOCK: u64 = 256;
/// Points in a row of a texture, and most rows: the largest texture that every WebGL2 device has.
const ROW: u32 = 2048;
/// Colour of points whose colour is missing.
const NO_COLOR: [u8; 4] = [128, 128, 128, 255];

/// One point relative to its cloud's centre. Here `f32` begins.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Splat {
    position: [f32; 3],
    srgb: [u8; 4],
}

/// What differs between clouds; see `Cloud` in `points.wgsl`, padded to [`BLOCK`].
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Block {
    offset: [f32; 4],
    shape: [f32; 4],
    padding: [[f32; 4]; 14],
}

/// A cloud on the GPU.
struct Uploaded {
    points: Weak<Vec<Point3<f64>>>,
    colors: Weak<Vec<[u8; 4]>>,
    center: Point3<f64>,
    /// Textures of at most [`ROW`] rows, and how many points each holds.
    splats: Vec<(wgpu::BindGroup, u32)>,
    opaque: bool,
}

impl Uploaded {
    /// Points that are not finite are left out; colours that are missing repeat the last one.
    fn new(gpu: (&wgpu::Device, &wgpu::Queue), layout: &wgpu::BindGroupLayout, draw: &PointsDraw) -> Option<Self> {
        let (points, colors) = (draw.points.as_slice(), draw.colors.as_slice());
        let center = center(points);
        let last_color = colors.last().copied().unwrap_or(NO_COLOR);
        // Plain loops here and below: the page is compiled for size, and its chains of adapters take ten times as long.
        let mut splats = vec![Splat::zeroed(); points.len()];
        let (mut count, mut least_alpha) = (0, u8::MAX);
        for index in 0..points.len() {
            let [x, y, z] = xyz(&points[index]);
            if x.is_finite() && y.is_finite() && z.is_finite() {
                let srgb = if index < colors.len() { colors[index] } else { last_color };
                let position = [(x - center.x) as f32, (y - center.y) as f32, (z - center.z) as f32];
                splats[count] = Splat { position, srgb };
                count += 1;
                least_alpha = least_alpha.min(srgb[3]);
            }
        }
        splats.truncate(count);
        let mut textures = Vec::new();
        while !splats.is_empty() {
            let rest = splats.split_off(splats.len().min((ROW * ROW) as usize));
            let count = splats.len() as u32;
            textures.push((texture(gpu, layout, splats), count));
            splats = rest;
        }
        (count > 0).then(|| Self {
            points: Arc::downgrade(&draw.points),
            colors: Arc::downgrade(&draw.colors),
            center,
            splats: textures,
            opaque: least_alpha == u8::MAX,
        })
    }
}

/// Coordinates without a call per access.
fn xyz(point: &Point3<f64>) -> [f64; 3] {
    point.coords.data.0[0]
}

/// Centre of the box around the finite points.
fn center(points: &[Point3<f64>]) -> Point3<f64> {
    let (mut least, mut most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        let p = xyz(point);
        if p[0].is_finite() && p[1].is_finite() && p[2].is_finite() {
            for axis in 0..3 {
                least[axis] = least[axis].min(p[axis]);
                most[axis] = most[axis].max(p[axis]);
            }
        }
    }
    nalgebra::center(&least.into(), &most.into())
}

/// Points row by row in a texture of four integers per texel.
fn texture(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    layout: &wgpu::BindGroupLayout,
    mut splats: Vec<Splat>,
) -> wgpu::BindGroup {
    let rows = (splats.len() as u32).div_ceil(ROW);
    splats.resize((rows * ROW) as usize, Splat::zeroed());
    let texture = device.create_texture_with_data(
        queue,
        &wgpu::TextureDescriptor {
            label: Some("points"),
            size: wgpu::Extent3d { width: ROW, height: rows, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(&splats),
    );
    bind_textures(device, layout, &[&texture.create_view(&wgpu::TextureViewDescriptor::default())])
}

/// A cloud's place among the uploaded ones: addresses of its points and colours.
type Key = (usize, usize);

fn key(draw: &PointsDraw) -> Key {
    (Arc::as_ptr(&draw.points) as usize, Arc::as_ptr(&draw.colors) as usize)
}

/// Clouds on the GPU and the pipelines that draw them.
pub(super) struct Points {
    uploaded: BTreeMap<Key, Option<Uploaded>>,
    /// What the current picture draws: cloud, uniform block, corners.
    planned: Vec<(Key, u32, u32)>,
    layout: wgpu::BindGroupLayout,
    splats_layout: wgpu::BindGroupLayout,
    blocks: Stream,
    bind_group: Option<wgpu::BindGroup>,
    solid: Sampled,
    mixed: Sampled,
}

impl Points {
    pub(super) fn new(device: &wgpu::Device, globals: &wgpu::BindGroupLayout) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("cloud"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: true,
                    min_binding_size: std::num::NonZeroU64::new(BLOCK),
                },
                count: None,
            }],
        });
        let shader = shader(device, "points", concat!(include_str!("globals.wgsl"), include_str!("points.wgsl")));
        let splats_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("points"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Uint,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            }],
        });
        let solid = Recipe {
            label: "points",
            shader: &shader,
            vertex: "vs_point",
            fragment: "fs_point",
            layouts: &[globals, &layout, &splats_layout],
            buffers: &[],
            topology: wgpu::PrimitiveTopology::TriangleList,
            color: Color::Replace,
            depth: Some((wgpu::CompareFunction::Greater, true)),
            samples: 1,
        };
        let mixed = Recipe {
            label: "clear points",
            color: Color::Mix,
            depth: Some((wgpu::CompareFunction::Greater, false)),
            ..solid
        };
        let (solid, mixed) = (solid.make_sampled(device), mixed.make_sampled(device));
        let blocks = Stream::new("clouds", wgpu::BufferUsages::UNIFORM);
        let (uploaded, planned, bind_group) = (BTreeMap::new(), Vec::new(), None);
        Self { uploaded, planned, layout, splats_layout, blocks, bind_group, solid, mixed }
    }

    /// Uploads what is new, forgets what nobody holds, plans the picture.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, frame: &Frame, stage: &Stage<'_>) {
        let used = |cloud: &Uploaded| cloud.points.strong_count() > 0 && cloud.colors.strong_count() > 0;
        self.uploaded.retain(|_, entry| entry.as_ref().is_some_and(used));
        self.planned.clear();
        let mut blocks: Vec<Block> = Vec::new();
        for draw in &frame.points {
            let key = key(draw);
            let upload = || Uploaded::new((device, queue), &self.splats_layout, draw);
            let entry = self.uploaded.entry(key).or_insert_with(upload);
            let Some(cloud) = entry.as_ref().filter(|_| draw.diameter_m.is_finite()) else { continue };
            let diameter_px = f64::from(draw.diameter_m) / stage.camera.m_per_px(&cloud.center, stage.size);
            let corners = match diameter_px {
                px if px < 2.5 => 4,
                px if px < 8.0 => 8,
                _ => 16,
            };
            let offset = (cloud.center - stage.scene_center).map(|v| v as f32);
            // A polygon of n corners has the area of its circle if its radius is a little larger.
            let angle = std::f32::consts::TAU / corners as f32;
            let even = (angle / angle.sin()).sqrt();
            blocks.push(Block {
                offset: [offset.x, offset.y, offset.z, draw.diameter_m / 2.0 * even],
                shape: [corners as f32, LEAST_PX * stage.pixels_per_point / 2.0 * even, 0.0, 0.0],
                padding: [[0.0; 4]; 14],
            });
            self.planned.push((key, (blocks.len() as u32 - 1) * BLOCK as u32, corners));
        }
        let (buffer, grown) = self.blocks.write(device, queue, bytemuck::cast_slice(&blocks));
        if grown || self.bind_group.is_none() {
            self.bind_group = Some(device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("clouds"),
                layout: &self.layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer,
                        offset: 0,
                        size: std::num::NonZeroU64::new(BLOCK),
                    }),
                }],
            }));
        }
    }

    /// Draws the clouds: opaque ones first.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, smooth: bool) {
        for (opaque, pipeline) in [(true, &self.solid), (false, &self.mixed)] {
            for (key, block, corners) in &self.planned {
                let Some(Some(cloud)) = self.uploaded.get(key) else { continue };
                if cloud.opaque == opaque {
                    pass.set_pipeline(pipeline.get(smooth));
                    pass.set_bind_group(1, &self.bind_group, &[*block]);
                    for (splats, count) in &cloud.splats {
                        pass.set_bind_group(2, splats, &[]);
                        pass.draw(0..3 * (corners - 2) * count, 0..1);
                    }
                }
            }
        }
    }
}
