//! Small helpers around wgpu: growing buffers, textures, pipelines.

/// Colour of our pictures: display values, since egui mixes textures as display values.
pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Depth of our pictures.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Samples per pixel of a smooth picture; every wgpu device can do four.
pub(super) const SAMPLES: u32 = 4;

/// A buffer that is written anew for every picture and grows when needed.
pub(super) struct Stream {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: Option<wgpu::Buffer>,
}

impl Stream {
    pub(super) fn new(label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { label, usage: usage | wgpu::BufferUsages::COPY_DST, buffer: None }
    }

    /// Writes the bytes from the start and gives the buffer that holds them. Returns also whether it is a new one.
    pub(super) fn write(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) -> (&wgpu::Buffer, bool) {
        let needed = (bytes.len() as u64).max(256);
        let grown = self.buffer.as_ref().is_none_or(|buffer| buffer.size() < needed);
        if grown {
            self.buffer = None;
        }
        let buffer = self.buffer.get_or_insert_with(|| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(self.label),
                size: needed.next_power_of_two(),
                usage: self.usage,
                mapped_at_creation: false,
            })
        });
        if !bytes.is_empty() {
            queue.write_buffer(buffer, 0, bytes);
        }
        (buffer, grown)
    }

    /// The buffer as last written.
    pub(super) fn buffer(&self) -> Option<&wgpu::Buffer> {
        self.buffer.as_ref()
    }
}

/// A buffer with these contents, never changed.
pub(super) fn fixed_buffer(
    device: &wgpu::Device,
    label: &str,
    usage: wgpu::BufferUsages,
    contents: &[u8],
) -> wgpu::Buffer {
    use wgpu::util::DeviceExt as _;
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
}

/// A texture that is drawn into, and its view.
pub(super) fn picture(
    device: &wgpu::Device,
    label: &str,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    samples: u32,
    usage: wgpu::TextureUsages,
) -> (wgpu::Texture, wgpu::TextureView) {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    (texture, view)
}

/// A layout of textures that fragment shaders load from, without samplers.
pub(super) fn textures_layout(device: &wgpu::Device, label: &str, count: u32) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..count)
        .map(|binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// Binds textures in order.
pub(super) fn bind_textures(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    views: &[&wgpu::TextureView],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(views)
        .map(|(binding, view)| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// What differs between our pipelines.
#[derive(Clone, Copy)]
pub(super) struct Recipe<'a> {
    pub(super) label: &'a str,
    pub(super) shader: &'a wgpu::ShaderModule,
    pub(super) vertex: &'a str,
    pub(super) fragment: &'a str,
    pub(super) layouts: &'a [&'a wgpu::BindGroupLayout],
    pub(super) buffers: &'a [wgpu::VertexBufferLayout<'a>],
    pub(super) topology: wgpu::PrimitiveTopology,
    /// Whether the colour is mixed in with premultiplied alpha, replaces what was there, or is not written.
    pub(super) color: Color,
    /// Depth comparison and whether depth is written; `None` in passes without depth.
    pub(super) depth: Option<(wgpu::CompareFunction, bool)>,
    pub(super) samples: u32,
}

/// What a pipeline does with its colour.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Color {
    Replace,
    Mix,
    Nothing,
}

/// One pipeline for smooth pictures (four samples per pixel) and one for drafts.
pub(super) struct Sampled {
    smooth: wgpu::RenderPipeline,
    draft: wgpu::RenderPipeline,
}

impl Sampled {
    pub(super) fn get(&self, smooth: bool) -> &wgpu::RenderPipeline {
        if smooth { &self.smooth } else { &self.draft }
    }
}

impl Recipe<'_> {
    /// The pipeline for smooth pictures and the one for drafts.
    pub(super) fn make_sampled(self, device: &wgpu::Device) -> Sampled {
        let draft = Recipe { samples: 1, ..self }.make(device);
        Sampled { smooth: Recipe { samples: SAMPLES, ..self }.make(device), draft }
    }

    pub(super) fn make(&self, device: &wgpu::Device) -> wgpu::RenderPipeline {
        let bind_group_layouts: Vec<_> = self.layouts.iter().map(|layout| Some(*layout)).collect();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.label),
            bind_group_layouts: &bind_group_layouts,
            immediate_size: 0,
        });
        let buffers: Vec<_> = self.buffers.iter().cloned().map(Some).collect();
        let mix = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;
        let mask = if self.color == Color::Nothing { wgpu::ColorWrites::empty() } else { wgpu::ColorWrites::ALL };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: self.shader,
                entry_point: Some(self.vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &buffers,
            },
            primitive: wgpu::PrimitiveState { topology: self.topology, ..Default::default() },
            depth_stencil: self.depth.map(|(compare, write)| wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(write),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: self.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: self.shader,
                entry_point: Some(self.fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: COLOR_FORMAT,
                    blend: (self.color == Color::Mix).then_some(mix),
                    write_mask: mask,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A shader module of several files.
pub(super) fn shader(device: &wgpu::Device, label: &str, source: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

/// A pass with one colour attachment and perhaps depth (cleared to the farthest).
pub(super) fn pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    color: &wgpu::TextureView,
    resolve: Option<&wgpu::TextureView>,
    clear: wgpu::Color,
    depth: Option<(&wgpu::TextureView, f32)>,
) -> wgpu::RenderPass<'e> {
    // The samples are not needed once they are resolved.
    let store = if resolve.is_some() { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: color,
            depth_slice: None,
            resolve_target: resolve,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store },
        })],
        depth_stencil_attachment: depth.map(|(view, farthest)| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(farthest), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
