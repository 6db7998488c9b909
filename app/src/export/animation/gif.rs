//! Frames as a GIF: one palette for all, and of every frame only what changed.

use gif::{DisposalMethod, Encoder, Frame, Repeat};
use image::RgbaImage;

use super::changes::Area;
use super::palette::{Learner, Palette};
use super::recorder::FrameSink;
use super::{AnimationError, AnimationFormat};

/// A GIF that grows.
pub(super) struct Gif {
    size: [u16; 2],
    fps: u32,
    /// Whether frames have see-through parts: then each replaces the one before it as a whole.
    is_clear: bool,
    stage: Stage,
    /// Colours of the last frame.
    before: Vec<u8>,
    frames: u64,
}

enum Stage {
    Learning(Learner),
    Writing { palette: Box<Palette>, encoder: Encoder<Vec<u8>> },
}

fn refused(error: &gif::EncodingError) -> AnimationError {
    AnimationError::Encoder { format: AnimationFormat::Gif, cause: error.to_string() }
}

impl Gif {
    pub(super) fn new([width, height]: [u32; 2], fps: u32, is_clear: bool) -> Result<Self, AnimationError> {
        let side = |side: u32| {
            let cause = format!("found a side of {side} pixels, wanted at most {}", u16::MAX);
            u16::try_from(side).map_err(|_| AnimationError::Encoder { format: AnimationFormat::Gif, cause })
        };
        let stage = Stage::Learning(Learner::default());
        Ok(Self { size: [side(width)?, side(height)?], fps, is_clear, stage, before: Vec::new(), frames: 0 })
    }

    /// Hundredths of a second for which the next frame is shown; over many frames the error does not add up.
    fn delay(&self) -> u16 {
        let end = |frames: u64| (100 * frames + u64::from(self.fps) / 2) / u64::from(self.fps);
        (end(self.frames + 1) - end(self.frames)) as u16
    }
}

impl FrameSink for Gif {
    fn learns(&self) -> bool {
        true
    }

    fn look_at(&mut self, picture: &RgbaImage) {
        if let Stage::Learning(learner) = &mut self.stage {
            learner.look_at(picture);
        }
    }

    fn push(&mut self, picture: &RgbaImage) -> Result<usize, AnimationError> {
        if let Stage::Learning(learner) = &mut self.stage {
            let palette = std::mem::take(learner).learn();
            let [width, height] = self.size;
            let mut encoder = Encoder::new(Vec::new(), width, height, &palette.bytes()).map_err(|e| refused(&e))?;
            encoder.set_repeat(Repeat::Infinite).map_err(|e| refused(&e))?;
            self.stage = Stage::Writing { palette: Box::new(palette), encoder };
        }
        let delay = self.delay();
        let Stage::Writing { palette, encoder } = &mut self.stage else { return Ok(0) };
        let now: Vec<u8> = picture.pixels().map(|pixel| palette.index_of(pixel.0)).collect();
        let [width, height] = self.size.map(usize::from);
        let is_whole = self.is_clear || self.before.is_empty();
        let area = if is_whole { Area::whole(width, height) } else { Area::of_changes(&self.before, &now, width) };
        let kept = |index: usize| !is_whole && self.before[index] == now[index];
        let pixels: Vec<u8> =
            area.indices(width).map(|index| if kept(index) { Palette::CLEAR } else { now[index] }).collect();
        let frame = Frame {
            delay,
            dispose: if self.is_clear { DisposalMethod::Background } else { DisposalMethod::Keep },
            transparent: Some(Palette::CLEAR),
            left: area.left as u16,
            top: area.top as u16,
            width: area.width as u16,
            height: area.height as u16,
            buffer: pixels.into(),
            ..Frame::default()
        };
        encoder.write_frame(&frame).map_err(|e| refused(&e))?;
        self.before = now;
        self.frames += 1;
        Ok(encoder.get_ref().len())
    }

    fn finish(self: Box<Self>) -> Result<Vec<u8>, AnimationError> {
        match self.stage {
            Stage::Learning(_) => Ok(Vec::new()),
            Stage::Writing { encoder, .. } => encoder
                .into_inner()
                .map_err(|error| AnimationError::Encoder { format: AnimationFormat::Gif, cause: error.to_string() }),
        }
    }
}
