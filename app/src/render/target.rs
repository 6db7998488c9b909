//! The textures that one picture is drawn into.

use super::gpu::{COLOR_FORMAT, DEPTH_FORMAT, SAMPLES, picture};

/// Where a picture is drawn: colour (shown by egui or read back), its samples and depth, and the light mask.
///
/// The colour texture is `Rgba8Unorm` and holds display (sRGB-encoded) values with premultiplied alpha: exactly what
/// egui expects of a user texture on every backend (`egui_wgpu::Renderer::register_native_texture`).
pub struct Target {
    size: [u32; 2],
    color: (wgpu::Texture, wgpu::TextureView),
    smooth: Option<Drawn>,
    draft: Option<Drawn>,
    masks: Option<Masks>,
}

/// What bodies are drawn into.
pub(super) struct Drawn {
    /// Samples that are resolved into the colour texture; `None` where bodies are drawn into it directly.
    pub(super) samples: Option<wgpu::TextureView>,
    pub(super) depth: wgpu::TextureView,
}

/// The small pictures behind shadow and occlusion.
pub(super) struct Masks {
    pub(super) size: [u32; 2],
    /// Depths and normals.
    pub(super) surfaces: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
    pub(super) rough: wgpu::TextureView,
    pub(super) smooth: wgpu::TextureView,
}

impl Target {
    /// Textures of this size in pixels, limited to what the device can do and to at least 1.
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let size = limited(device, size);
        let shown = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let color = picture(device, "view colour", size, COLOR_FORMAT, 1, shown);
        Self { size, color, smooth: None, draft: None, masks: None }
    }

    /// Makes the textures anew if the size differs; returns whether it did, so that egui's texture can follow.
    pub fn resize(&mut self, device: &wgpu::Device, size: [u32; 2]) -> bool {
        let differs = limited(device, size) != self.size;
        if differs {
            *self = Self::new(device, size);
        }
        differs
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The finished picture.
    pub fn color_view(&self) -> &wgpu::TextureView {
        &self.color.1
    }

    /// The finished picture, for reading back.
    pub fn color_texture(&self) -> &wgpu::Texture {
        &self.color.0
    }

    /// The colour, what is drawn into for a smooth picture or a draft, and the mask textures at this fraction of the
    /// picture's size.
    pub(super) fn parts(
        &mut self,
        device: &wgpu::Device,
        smooth: bool,
        fraction: f64,
    ) -> (&wgpu::TextureView, &Drawn, &Masks) {
        let (slot, samples) = if smooth { (&mut self.smooth, SAMPLES) } else { (&mut self.draft, 1) };
        let drawn = slot.get_or_insert_with(|| {
            let view =
                |label, format| picture(device, label, self.size, format, samples, wgpu::TextureUsages::empty()).1;
            Drawn {
                samples: smooth.then(|| view("view samples", COLOR_FORMAT)),
                depth: view("view depth", DEPTH_FORMAT),
            }
        });
        let size = self.size.map(|side| ((f64::from(side) * fraction).ceil() as u32).max(1));
        if self.masks.as_ref().is_some_and(|masks| masks.size != size) {
            self.masks = None;
        }
        let masks = self.masks.get_or_insert_with(|| {
            let loaded = wgpu::TextureUsages::TEXTURE_BINDING;
            let small = |label, format, usage| picture(device, label, size, format, 1, usage).1;
            Masks {
                size,
                surfaces: small("surfaces", COLOR_FORMAT, loaded),
                depth: small("surface depth", DEPTH_FORMAT, wgpu::TextureUsages::empty()),
                rough: small("rough mask", COLOR_FORMAT, loaded),
                smooth: small("smooth mask", COLOR_FORMAT, loaded),
            }
        });
        (&self.color.1, drawn, masks)
    }
}

fn limited(device: &wgpu::Device, size: [u32; 2]) -> [u32; 2] {
    let most = device.limits().max_texture_dimension_2d;
    size.map(|side| side.min(most).max(1))
}
