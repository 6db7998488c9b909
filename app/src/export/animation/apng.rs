//! Frames as an animated PNG: of every frame only what changed, and that without loss.

use std::io::Write;
use std::sync::{Arc, Mutex, PoisonError};

use image::RgbaImage;
use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, Encoder, Writer};

use super::changes::Area;
use super::recorder::FrameSink;
use super::{AnimationError, AnimationFormat};

/// Bytes that the writer, which keeps its file to itself, and its owner both see.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl Shared {
    fn with<T>(&self, act: impl FnOnce(&mut Vec<u8>) -> T) -> T {
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.with(|file| file.extend_from_slice(bytes));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// An animated PNG that grows.
pub(super) struct Apng {
    width: usize,
    height: usize,
    /// Whether frames have see-through parts: then what changed replaces what was there.
    is_clear: bool,
    file: Shared,
    writer: Writer<Shared>,
    before: Vec<[u8; 4]>,
}

fn refused(error: png::EncodingError) -> AnimationError {
    AnimationError::Encoder { format: AnimationFormat::Apng, cause: error.to_string() }
}

impl Apng {
    pub(super) fn new(
        [width, height]: [u32; 2],
        fps: u32,
        frames: usize,
        is_clear: bool,
    ) -> Result<Self, AnimationError> {
        let file = Shared::default();
        let mut encoder = Encoder::new(file.clone(), width, height);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Fast);
        encoder.set_animated(frames as u32, 0).map_err(refused)?;
        encoder.set_frame_delay(1, fps as u16).map_err(refused)?;
        encoder.set_dispose_op(DisposeOp::None).map_err(refused)?;
        encoder.set_blend_op(BlendOp::Source).map_err(refused)?;
        encoder.validate_sequence(true);
        let writer = encoder.write_header().map_err(refused)?;
        let (width, height) = (width as usize, height as usize);
        Ok(Self { width, height, is_clear, file, writer, before: Vec::new() })
    }

    fn write(&mut self, area: Area, blend: BlendOp, pixels: &[[u8; 4]]) -> Result<(), png::EncodingError> {
        // A smaller area fits only after the place is back at the corner.
        self.writer.reset_frame_position()?;
        self.writer.set_frame_dimension(area.width as u32, area.height as u32)?;
        self.writer.set_frame_position(area.left as u32, area.top as u32)?;
        self.writer.set_blend_op(blend)?;
        self.writer.write_image_data(pixels.as_flattened())
    }
}

impl FrameSink for Apng {
    fn push(&mut self, picture: &RgbaImage) -> Result<usize, AnimationError> {
        let now: Vec<[u8; 4]> = picture.pixels().map(|pixel| pixel.0).collect();
        let is_first = self.before.is_empty();
        let area = if is_first {
            Area::whole(self.width, self.height)
        } else {
            Area::of_changes(&self.before, &now, self.width)
        };
        let blend = if is_first || self.is_clear { BlendOp::Source } else { BlendOp::Over };
        let kept = |index: usize| matches!(blend, BlendOp::Over) && self.before[index] == now[index];
        let pixels: Vec<[u8; 4]> =
            area.indices(self.width).map(|index| if kept(index) { [0; 4] } else { now[index] }).collect();
        self.write(area, blend, &pixels).map_err(refused)?;
        self.before = now;
        Ok(self.file.with(|file| file.len()))
    }

    fn finish(self: Box<Self>) -> Result<Vec<u8>, AnimationError> {
        let Self { file, writer, .. } = *self;
        writer.finish().map_err(refused)?;
        Ok(file.with(std::mem::take))
    }
}
