//! Which moments of a plan an animation shows, and what it is written as.

/// Most frames of an animation: a minute at 60 frames per second.
pub(super) const MAX_FRAMES: usize = 3600;
/// Largest file that is written, bytes: 512 MB.
pub(super) const MAX_BYTES: usize = 512 << 20;
/// Two moments are the same when they are less than this apart, in frames.
const SAME_FRAME: f64 = 1e-6;

/// What an animation is written as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AnimationFormat {
    /// 256 colours, understood everywhere.
    #[default]
    Gif,
    /// Animated PNG: every colour, and see-through pictures.
    Apng,
    /// One PNG for every frame, in a ZIP archive.
    Frames,
}

impl AnimationFormat {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Gif, Self::Apng, Self::Frames];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Gif => "GIF",
            Self::Apng => "Animated PNG",
            Self::Frames => "PNG frames",
        }
    }

    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Gif => "gif",
            Self::Apng => "apng",
            Self::Frames => "zip",
        }
    }

    /// The format of a file by its extension.
    pub fn of_extension(extension: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.extension().eq_ignore_ascii_case(extension))
    }

    /// Most frames per second: a GIF counts in hundredths of a second, and viewers show what is shorter than two of them
    /// slowly.
    pub fn max_fps(self) -> u32 {
        match self {
            Self::Gif => 50,
            Self::Apng | Self::Frames => 60,
        }
    }
}

/// A part of a plan as frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// What it is written as.
    pub format: AnimationFormat,
    /// Frames per second.
    pub fps: u32,
    /// Time of the first frame, seconds from the start of the plan.
    pub from_s: f64,
    /// No frame is later than this, seconds.
    pub to_s: f64,
}

/// Why an animation is not made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AnimationError {
    /// Too many frames per second, or none.
    #[error("found {found} frames per second, wanted between 1 and {most} for {}", format.title())]
    Fps {
        /// Frames per second asked for.
        found: u32,
        /// Most of them.
        most: u32,
        /// What it is written as.
        format: AnimationFormat,
    },
    /// The part is not one of the plan.
    #[error("found the part from {from_s} s to {to_s} s, wanted one within 0 s and {duration_s:.2} s")]
    Range {
        /// Start asked for, seconds.
        from_s: f64,
        /// End asked for, seconds.
        to_s: f64,
        /// Length of the plan, seconds.
        duration_s: f64,
    },
    /// Too many frames.
    #[error("found {found} frames, wanted at most {MAX_FRAMES}: fewer frames per second, or a shorter part")]
    Frames {
        /// Frames of the part.
        found: usize,
    },
    /// The file grew too large.
    #[error("the file grew beyond {} MB at frame {frame}: a smaller size, or a shorter part", MAX_BYTES >> 20)]
    Bytes {
        /// The frame with which it did, from 0.
        frame: usize,
    },
    /// A picture of another size than the first.
    #[error("frame {frame} has {found:?} pixels, wanted {wanted:?}")]
    Size {
        /// The frame, from 0.
        frame: usize,
        /// Its width and height.
        found: [u32; 2],
        /// Those of the animation.
        wanted: [u32; 2],
    },
    /// The encoder refuses it.
    #[error("the {} cannot be written: {cause}", format.title())]
    Encoder {
        /// What it was to be written as.
        format: AnimationFormat,
        /// What the encoder said.
        cause: String,
    },
}

impl Clip {
    /// How many frames there are: one at the start, and one every `1 / fps` seconds up to the end.
    pub fn frame_count(&self) -> usize {
        ((self.to_s - self.from_s).max(0.0) * f64::from(self.fps) + SAME_FRAME).floor() as usize + 1
    }

    /// The moment of a frame, seconds from the start of the plan.
    pub fn time_s(&self, frame: usize) -> f64 {
        (self.from_s + frame as f64 / f64::from(self.fps)).min(self.to_s)
    }

    /// Whether it can be made of a plan of this length.
    ///
    /// # Errors
    /// [`AnimationError::Fps`], [`AnimationError::Range`] or [`AnimationError::Frames`].
    pub fn check(&self, duration_s: f64) -> Result<(), AnimationError> {
        let &Self { format, fps, from_s, to_s } = self;
        let most = format.max_fps();
        if !(1..=most).contains(&fps) {
            return Err(AnimationError::Fps { found: fps, most, format });
        }
        // NaN is in no range.
        if !((0.0..=to_s).contains(&from_s) && (0.0..=duration_s + 1e-9).contains(&to_s)) {
            return Err(AnimationError::Range { from_s, to_s, duration_s });
        }
        match self.frame_count() {
            found if found > MAX_FRAMES => Err(AnimationError::Frames { found }),
            _ => Ok(()),
        }
    }
}
