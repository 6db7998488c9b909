//! Takes the pictures of a clip one by one, in the order in which it asks for them.

use image::RgbaImage;

use super::apng::Apng;
use super::clip::MAX_BYTES;
use super::gif::Gif;
use super::zip::Zip;
use super::{AnimationError, AnimationFormat, Clip};
use crate::export::png_bytes;

/// Pictures from which a format that learns its colours learns them.
const LEARNED_PICTURES: usize = 9;

/// A format's writer.
pub(super) trait FrameSink {
    /// Whether it wants to see pictures of the whole clip before the first frame.
    fn learns(&self) -> bool {
        false
    }

    /// Learns from a picture.
    fn look_at(&mut self, _picture: &RgbaImage) {}

    /// Writes the next frame and gives the size of the file so far, bytes.
    fn push(&mut self, picture: &RgbaImage) -> Result<usize, AnimationError>;

    /// The finished file.
    fn finish(self: Box<Self>) -> Result<Vec<u8>, AnimationError>;
}

/// An animation under way.
pub struct Recorder {
    clip: Clip,
    size_px: [u32; 2],
    sink: Box<dyn FrameSink>,
    /// Pictures that are to be learned from before the first frame.
    learned: usize,
    /// Pictures taken so far, those that were learned from included.
    taken: usize,
}

impl Recorder {
    /// An animation without a frame yet.
    ///
    /// * `duration_s`: length of the plan, seconds.
    /// * `is_clear`: whether the pictures have a see-through background.
    ///
    /// # Errors
    /// [`AnimationError`] when the clip is no part of the plan, too long, or too large for its format.
    pub fn new(clip: Clip, duration_s: f64, size_px: [u32; 2], is_clear: bool) -> Result<Self, AnimationError> {
        clip.check(duration_s)?;
        let sink: Box<dyn FrameSink> = match clip.format {
            AnimationFormat::Gif => Box::new(Gif::new(size_px, clip.fps, is_clear)?),
            AnimationFormat::Apng => Box::new(Apng::new(size_px, clip.fps, clip.frame_count(), is_clear)?),
            AnimationFormat::Frames => Box::new(Frames::default()),
        };
        let learned = if sink.learns() { LEARNED_PICTURES.min(clip.frame_count()) } else { 0 };
        Ok(Self { clip, size_px, sink, learned, taken: 0 })
    }

    /// The moment of the picture that comes next, seconds from the start of the plan; `None` when all are there.
    pub fn wanted_s(&self) -> Option<f64> {
        let count = self.clip.frame_count();
        if self.taken < self.learned {
            // The first frame, the last one, and evenly between.
            let frame = self.taken * (count - 1) / (self.learned - 1).max(1);
            return Some(self.clip.time_s(frame));
        }
        let frame = self.taken - self.learned;
        (frame < count).then(|| self.clip.time_s(frame))
    }

    /// Takes the picture of the moment that was wanted.
    ///
    /// # Errors
    /// [`AnimationError::Size`], [`AnimationError::Bytes`] or [`AnimationError::Encoder`].
    pub fn take(&mut self, picture: &RgbaImage) -> Result<(), AnimationError> {
        let (frame, found) = (self.taken.saturating_sub(self.learned), [picture.width(), picture.height()]);
        if found != self.size_px {
            return Err(AnimationError::Size { frame, found, wanted: self.size_px });
        }
        if self.taken < self.learned {
            self.sink.look_at(picture);
        } else if self.sink.push(picture)? > MAX_BYTES {
            return Err(AnimationError::Bytes { frame });
        }
        self.taken += 1;
        Ok(())
    }

    /// Pictures taken, and pictures wanted in all.
    pub fn progress(&self) -> (usize, usize) {
        (self.taken, self.learned + self.clip.frame_count())
    }

    /// The finished file.
    ///
    /// # Errors
    /// [`AnimationError::Encoder`], also when frames are missing.
    pub fn finish(self) -> Result<Vec<u8>, AnimationError> {
        if let Some(time_s) = self.wanted_s() {
            let cause = format!("the frame at {time_s:.2} s is missing");
            return Err(AnimationError::Encoder { format: self.clip.format, cause });
        }
        self.sink.finish()
    }
}

/// One PNG for every frame.
#[derive(Default)]
struct Frames {
    archive: Zip,
    count: usize,
}

impl FrameSink for Frames {
    fn push(&mut self, picture: &RgbaImage) -> Result<usize, AnimationError> {
        let png =
            png_bytes(picture).map_err(|cause| AnimationError::Encoder { format: AnimationFormat::Frames, cause })?;
        self.archive.add(&format!("frame_{:04}.png", self.count), &png);
        self.count += 1;
        Ok(self.archive.len())
    }

    fn finish(self: Box<Self>) -> Result<Vec<u8>, AnimationError> {
        Ok(self.archive.finish())
    }
}
