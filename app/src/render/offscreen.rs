//! Pictures without a window: figures, tests, the command line.

use image::RgbaImage;

use super::{Frame, MAX_SIDE_PX, Quality, Readback, Renderer, SizeError, Target, View, check_scale, check_size};

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
    /// The picture is too large, or nothing.
    #[error(transparent)]
    Size(#[from] SizeError),
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
    /// [`OffscreenError::Size`] for a size beyond [`check_size`] or a scale beyond [`check_scale`],
    /// [`OffscreenError::Readback`] if the device is lost.
    pub fn render(&mut self, frame: &Frame, view: &View) -> Result<RgbaImage, OffscreenError> {
        self.render_with(frame, view, |_, _| ())
    }

    /// As [`Self::render`]; `over` draws over the finished picture.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn render_with(
        &mut self,
        frame: &Frame,
        view: &View,
        over: impl FnOnce((&wgpu::Device, &wgpu::Queue), &Target),
    ) -> Result<RgbaImage, OffscreenError> {
        check_size(view.size_px, self.limit)?;
        check_scale(view.pixels_per_point)?;
        let mut target = match self.target.take() {
            Some(target) if target.size() == view.size_px => target,
            _ => Target::new(&self.device, view.size_px),
        };
        self.renderer.draw(&self.device, &self.queue, frame, view, &mut target);
        over((&self.device, &self.queue), &target);
        let picture = self.read(&target);
        self.target = Some(target);
        picture.map_err(|cause| OffscreenError::Readback { adapter: self.adapter.name.clone(), cause })
    }

    fn read(&self, target: &Target) -> Result<RgbaImage, String> {
        let readback = Readback::start(&self.device, &self.queue, target, || {});
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
        readback.take(&self.device).unwrap_or_else(|| Err("it never arrived".to_owned()))
    }
}
