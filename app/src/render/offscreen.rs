//! Pictures without a window: figures, tests, the command line.

use image::RgbaImage;

use super::{Frame, Quality, Renderer, Target, View};

/// Largest width or height of a picture in pixels.
pub const MAX_SIDE_PX: u32 = 8192;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OffscreenError {
    /// No graphics driver at all.
    #[error(
        "no graphics adapter found ({cause}): install a Vulkan or OpenGL driver; on a machine without a GPU the \
         package mesa-vulkan-drivers draws in software"
    )]
    NoAdapter {
        /// What wgpu said.
        cause: String,
    },
    /// The adapter does not give a device.
    #[error("graphics adapter {adapter:?} gives no device: {cause}")]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// What wgpu said.
        cause: String,
    },
    /// A side is 0 or too long.
    #[error("picture of {width} × {height} pixels: each side must be between 1 and {limit}")]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Longest side that this adapter draws.
        limit: u32,
    },
    /// The picture was drawn but could not be read.
    #[error("the picture could not be read back from {adapter:?}: {cause}")]
    Readback {
        /// Name of the adapter.
        adapter: String,
        /// What wgpu said.
        cause: String,
    },
}

/// A renderer with its own device.
pub struct Offscreen {
    device: wgpu::Device,
    queue: wgpu::Queue,
    adapter: wgpu::AdapterInfo,
    renderer: Renderer,
    target: Option<Target>,
    limit: u32,
}

impl Offscreen {
    /// Opens the best adapter there is; a software one will do.
    ///
    /// # Errors
    /// [`OffscreenError::NoAdapter`] or [`OffscreenError::NoDevice`].
    pub fn new() -> Result<Self, OffscreenError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        }))
        .map_err(|error| OffscreenError::NoAdapter { cause: error.to_string() })?;
        let info = adapter.get_info();
        let limit = adapter.limits().max_texture_dimension_2d.min(MAX_SIDE_PX);
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("off-screen"),
            // What the browser has at least, so that what is drawn here is drawn there; only larger pictures.
            required_limits: wgpu::Limits {
                max_texture_dimension_2d: limit,
                ..wgpu::Limits::downlevel_webgl2_defaults()
            },
            ..Default::default()
        }))
        .map_err(|error| OffscreenError::NoDevice { adapter: info.name.clone(), cause: error.to_string() })?;
        let mut renderer = Renderer::new(&device, &queue);
        renderer.set_quality(Quality::Figure);
        Ok(Self { device, queue, adapter: info, renderer, target: None, limit })
    }

    /// The adapter that draws.
    pub fn adapter(&self) -> &wgpu::AdapterInfo {
        &self.adapter
    }

    /// How finely the next pictures are lit; [`Quality::Figure`] at first.
    pub fn set_quality(&mut self, quality: Quality) {
        self.renderer.set_quality(quality);
    }

    /// Draws a picture of `view.size_px`. Alpha is straight, as PNG wants it.
    ///
    /// # Errors
    /// [`OffscreenError::Size`] for a side of 0 or beyond [`MAX_SIDE_PX`] (or what the adapter can do),
    /// [`OffscreenError::Readback`] if the device is lost.
    pub fn render(&mut self, frame: &Frame, view: &View) -> Result<RgbaImage, OffscreenError> {
        let [width, height] = view.size_px;
        if !view.size_px.iter().all(|side| (1..=self.limit).contains(side)) {
            return Err(OffscreenError::Size { width, height, limit: self.limit });
        }
        let mut target = match self.target.take() {
            Some(target) if target.size() == view.size_px => target,
            _ => Target::new(&self.device, view.size_px),
        };
        self.renderer.draw(&self.device, &self.queue, frame, view, &mut target);
        let pixels = self.read(target.color_texture(), view.size_px);
        self.target = Some(target);
        let readback = |cause: String| OffscreenError::Readback { adapter: self.adapter.name.clone(), cause };
        let pixels = pixels.map_err(readback)?;
        RgbaImage::from_raw(width, height, pixels).ok_or_else(|| readback("wrong number of bytes".to_owned()))
    }

    fn read(&self, texture: &wgpu::Texture, [width, height]: [u32; 2]) -> Result<Vec<u8>, String> {
        let row = width as usize * 4;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: padded as u64 * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded as u32), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver waits below; if it is gone, so is the question.
            sender.send(result).ok();
        });
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
        receiver.recv().map_err(|error| error.to_string())?.map_err(|error| error.to_string())?;
        let mapped = buffer.get_mapped_range(..).map_err(|error| error.to_string())?;
        let mut pixels = Vec::with_capacity(row * height as usize);
        for line in mapped.chunks_exact(padded) {
            pixels.extend_from_slice(&line[..row]);
        }
        pixels.chunks_exact_mut(4).for_each(straighten);
        Ok(pixels)
    }
}

/// Straight alpha from premultiplied.
fn straighten(pixel: &mut [u8]) {
    let [color @ .., alpha] = pixel else { return };
    if !matches!(alpha, 0 | 255) {
        for channel in color {
            *channel = ((u32::from(*channel) * 255 + u32::from(*alpha) / 2) / u32::from(*alpha)).min(255) as u8;
        }
    }
}
