//! Pictures and animations of the view: what they shall be, and how far they are.

use super::{Effect, Overlay, ViewerState};
use crate::export::{AnimationFormat, Clip};
use crate::render::{MAX_SIDE_PX, check_scale, check_size};

/// A page of the window that saves what the view shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PicturePage {
    /// One picture.
    #[default]
    Picture,
    /// The plan, moving.
    Animation,
    /// The bodies themselves.
    Scene,
}

impl PicturePage {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Picture, Self::Animation, Self::Scene];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Picture => "Picture",
            Self::Animation => "Animation",
            Self::Scene => "3D scene",
        }
    }
}

/// A size that is often wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SizePreset {
    /// As the view is on the screen.
    #[default]
    View,
    /// 1280 × 720, for animations.
    Hd,
    /// 1920 × 1080.
    FullHd,
    /// 3840 × 2160.
    Uhd,
    /// A square for a column of a paper: 2000 × 2000, 8.5 cm at 600 dots per inch.
    Square,
    /// Whatever is typed.
    Own,
}

impl SizePreset {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::View, Self::Hd, Self::FullHd, Self::Uhd, Self::Square, Self::Own];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::View => "This view",
            Self::Hd => "1280 × 720",
            Self::FullHd => "1920 × 1080",
            Self::Uhd => "3840 × 2160",
            Self::Square => "Square, for a paper",
            Self::Own => "Own size",
        }
    }

    /// Its size in pixels and its pixels per point, at which lines and words are as thick, compared with the picture, as
    /// on a screen.
    fn size(self) -> Option<([u32; 2], f32)> {
        match self {
            Self::View | Self::Own => None,
            Self::Hd => Some(([1280, 720], 1.0)),
            Self::FullHd => Some(([1920, 1080], 1.25)),
            Self::Uhd => Some(([3840, 2160], 2.5)),
            Self::Square => Some(([2000, 2000], 2.5)),
        }
    }
}

/// What a picture shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureSettings {
    /// Where its size comes from.
    pub preset: SizePreset,
    /// Size in pixels, unless it is that of the view.
    pub size_px: [u32; 2],
    /// Pixels per point, unless it is that of the view: how thick lines, points and words are.
    pub scale: f32,
    /// No background.
    pub transparent: bool,
    /// With labels, legend and scale.
    pub words: bool,
    /// In the light theme, whatever the page is in.
    pub light: bool,
    /// What an animation is written as.
    pub format: AnimationFormat,
    /// Frames per second of an animation.
    pub fps: u32,
    /// The part of the plan that an animation shows, seconds from its start; an end behind the plan's is the plan's.
    pub part_s: [f64; 2],
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            preset: SizePreset::View,
            size_px: [1920, 1080],
            scale: 1.25,
            transparent: false,
            words: true,
            light: false,
            format: AnimationFormat::Gif,
            fps: 25,
            part_s: [0.0, f64::MAX],
        }
    }
}

impl PictureSettings {
    /// The same with another preset: its size stays as a start for an own one.
    pub(super) fn with_preset(self, preset: SizePreset) -> Self {
        match preset.size() {
            Some((size_px, scale)) => Self { preset, size_px, scale, ..self },
            None => Self { preset, ..self },
        }
    }

    /// The shot that it stands for while the view is so large and the page in this theme.
    pub(super) fn shot(&self, view_px: [u32; 2], view_scale: f32, dark: bool) -> Shot {
        let (size_px, scale) = match self.preset {
            SizePreset::View => (view_px, view_scale),
            _ => (self.size_px, self.scale),
        };
        let &Self { transparent, words, light, .. } = self;
        Shot { size_px, scale, transparent, words, dark: dark && !light }
    }

    /// The clip that it stands for, of a plan of this length.
    pub(super) fn clip(&self, duration_s: f64) -> Clip {
        let [from_s, to_s] = self.part_s.map(|time_s| time_s.max(0.0).min(duration_s));
        Clip { format: self.format, fps: self.fps, from_s, to_s }
    }
}

/// How a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Pixels per point.
    pub scale: f32,
    /// No background.
    pub transparent: bool,
    /// With labels, legend and scale.
    pub words: bool,
    /// In the dark theme.
    pub dark: bool,
}

/// Pictures: what they shall be, and the animation under way.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picturing {
    /// The page that is open.
    pub page: PicturePage,
    /// What is wanted.
    pub settings: PictureSettings,
    /// Pictures taken of the animation under way, and pictures in all.
    pub progress: Option<(usize, usize)>,
}

/// Something a person does about pictures.
#[derive(Clone, Debug, PartialEq)]
pub enum PictureCommand {
    /// Opens a page of the window.
    Page(PicturePage),
    /// Wants other pictures.
    Settings(PictureSettings),
    /// Saves a picture.
    Take(Shot),
    /// Saves an animation.
    Film(Shot, Clip),
    /// Gives the animation under way up.
    Stop,
    /// Saves the bodies, points and lines of the view as a GLB.
    SaveScene,
    /// The animation under way has come so far: what [`PictureCommand::Film`] leads to.
    Progress(Option<(usize, usize)>),
}

/// What the application has to do for pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureEffect {
    /// Take a picture.
    Take(Shot),
    /// Make an animation.
    Film(Shot, Clip),
    /// Give the animation up.
    Stop,
    /// Save the bodies, points and lines of the view.
    SaveScene,
}

impl ViewerState {
    /// Why a shot cannot be taken, if it cannot; the device's own limit is asked when it is.
    pub(super) fn shot_problem(shot: &Shot) -> Option<String> {
        let checked = check_size(shot.size_px, MAX_SIDE_PX).and_then(|()| check_scale(shot.scale));
        checked.err().map(|error| error.to_string())
    }

    pub(super) fn apply_picture(&mut self, command: PictureCommand) -> Vec<Effect> {
        let effect = match command {
            PictureCommand::Page(page) => {
                self.picturing.page = page;
                return Vec::new();
            }
            PictureCommand::Settings(settings) => {
                self.picturing.settings = settings;
                return Vec::new();
            }
            PictureCommand::Progress(progress) => {
                self.picturing.progress = progress;
                if progress.is_none() && self.overlay == Overlay::Picture {
                    self.overlay = Overlay::None;
                }
                return Vec::new();
            }
            PictureCommand::Take(shot) => {
                self.overlay = Overlay::None;
                PictureEffect::Take(shot)
            }
            PictureCommand::Film(..) if self.picturing.progress.is_some() => return Vec::new(),
            PictureCommand::Film(shot, clip) => {
                self.playback.playing = false;
                PictureEffect::Film(shot, clip)
            }
            PictureCommand::SaveScene => {
                self.overlay = Overlay::None;
                PictureEffect::SaveScene
            }
            PictureCommand::Stop => {
                self.picturing.progress = None;
                PictureEffect::Stop
            }
        };
        vec![Effect::Picture(effect)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_has_its_size_and_the_view_its_own() {
        let settings = PictureSettings::default();
        let view = settings.shot([1440, 900], 2.0, true);
        assert_eq!((view.size_px, view.scale, view.dark), ([1440, 900], 2.0, true));
        let square = PictureSettings { light: true, ..settings.with_preset(SizePreset::Square) };
        let shot = square.shot([1440, 900], 2.0, true);
        assert_eq!((shot.size_px, shot.scale, shot.dark), ([2000, 2000], 2.5, false));
        // An own size starts from what was there.
        assert_eq!(square.with_preset(SizePreset::Own).shot([1, 1], 1.0, true).size_px, [2000, 2000]);
    }

    #[test]
    fn a_part_stays_within_the_plan() {
        let settings = PictureSettings { part_s: [2.0, 99.0], ..PictureSettings::default() };
        let clip = settings.clip(7.5);
        assert_eq!((clip.from_s, clip.to_s), (2.0, 7.5));
        assert_eq!(settings.clip(1.0).frame_count(), 1);
    }

    #[test]
    fn what_is_too_large_is_told_before_it_is_drawn() {
        let shot = PictureSettings::default().shot([9000, 10], 1.0, true);
        assert!(ViewerState::shot_problem(&shot).is_some_and(|said| said.contains("9000 × 10")));
        assert_eq!(ViewerState::shot_problem(&Shot { size_px: [3840, 2160], ..shot }), None);
    }
}
