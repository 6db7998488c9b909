//! Half a minute for newcomers: six stops that say what the robot decides, each shown where it happens.

use endcomfort_core::job::Stage;

use super::state::{Side, Step};
use super::{Command, Effect, Overlay, ViewerState, format};

/// How long the tour stays at a stop, seconds; six of them make the half minute.
pub(super) const STAYS_S: f64 = 5.0;

/// What a person does with the tour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TourCommand {
    /// Begins it.
    Start,
    /// Goes to a stop; behind the last one the tour ends.
    To(usize),
    /// Stays at the stop, or goes on by itself again.
    Hold(bool),
    /// Ends it.
    End,
}

/// The tour under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tour {
    /// The stop, an index into [`Stop::ALL`].
    pub stop: usize,
    /// How long it has been there, seconds.
    pub shown_s: f64,
    /// Whether it stays there: the pointer reads along.
    pub is_held: bool,
}

/// A place of the page where something is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    Cloud,
    Fit,
    Grasps,
    Comfort,
    Motion,
    Yours,
}

/// What a stop points at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// The middle of the view.
    View,
    /// The pipeline on the left.
    Left,
    /// The inspector on the right.
    Right,
    /// The timeline.
    Timeline,
}

impl Stop {
    pub(super) const ALL: [Self; 6] = [Self::Cloud, Self::Fit, Self::Grasps, Self::Comfort, Self::Motion, Self::Yours];

    pub(super) fn target(self) -> Target {
        match self {
            Self::Cloud | Self::Fit => Target::View,
            Self::Grasps | Self::Comfort => Target::Right,
            Self::Motion => Target::Timeline,
            Self::Yours => Target::Left,
        }
    }

    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Cloud => "What the camera saw",
            Self::Fit => "A shape for every cluster",
            Self::Grasps => "Hundreds of grasps",
            Self::Comfort => "The comfortable end decides",
            Self::Motion => "A motion, proven free",
            Self::Yours => "Your turn",
        }
    }

    /// The step whose answer is shown there.
    fn step(self) -> Step {
        match self {
            Self::Cloud | Self::Yours => Step::Stage(Stage::Scene),
            Self::Fit => Step::Stage(Stage::Fit),
            Self::Grasps => Step::Stage(Stage::Grasps),
            Self::Comfort => Step::Stage(Stage::Rank),
            Self::Motion => Step::Play,
        }
    }

    /// What is decided there, with the numbers of this very scene.
    pub(super) fn words(self, state: &ViewerState) -> String {
        let robot = state.robot_title();
        match self {
            Self::Cloud => {
                let points = state.outputs.scene.as_ref().map_or(0, |scene| scene.cloud.points.len());
                format!(
                    "A depth camera looks at the table once: {} points, and nothing else is known.",
                    format::count(points)
                )
            }
            Self::Fit => {
                "Each cluster gets a superquadric: eleven numbers that say where the object is, how big, and how it \
                          goes on where nobody looked."
                    .to_owned()
            }
            Self::Grasps => {
                let count = state.outputs.candidates().len();
                let accepted = state.outputs.candidates().iter().filter(|grasp| grasp.is_accepted()).count();
                format!(
                    "{} ways to take hold were tried on it; {} remain. Every other one says why it was turned away.",
                    format::count(count),
                    format::count(accepted)
                )
            }
            Self::Comfort => format!(
                "People grasp so that the arm is comfortable in the end. So {robot} ranks by how freely its arm moves \
                 where the object is put down, not where it is picked up."
            ),
            Self::Motion => {
                let duration_s = state.duration_s();
                let length = if duration_s > 0.0 { format!("{duration_s:.1} seconds long, ") } else { String::new() };
                format!(
                    "The first grasp that works becomes a motion: {length}within every joint's limits, touching nothing."
                )
            }
            Self::Yours => {
                "Drag an object, the goal or a hand of the robot, and everything follows. Drop a cloud of your own. \
                            Ctrl K finds the rest."
                    .to_owned()
            }
        }
    }
}

impl ViewerState {
    pub(super) fn apply_tour(&mut self, command: TourCommand) -> Vec<Effect> {
        match command {
            TourCommand::Start => {
                self.overlay = Overlay::None;
                self.tour = Some(Tour { stop: 0, shown_s: 0.0, is_held: false });
                self.arrive()
            }
            TourCommand::To(stop) if self.tour.is_some() && stop < Stop::ALL.len() => {
                self.tour = Some(Tour { stop, shown_s: 0.0, is_held: false });
                self.arrive()
            }
            TourCommand::Hold(is_held) => {
                if let Some(tour) = &mut self.tour {
                    tour.is_held = is_held;
                }
                Vec::new()
            }
            TourCommand::To(_) | TourCommand::End => {
                self.tour = None;
                self.drawer = None;
                Vec::new()
            }
        }
    }

    /// Brings the page to where the stop points.
    fn arrive(&mut self) -> Vec<Effect> {
        let Some(stop) = self.tour.and_then(|tour| Stop::ALL.get(tour.stop).copied()) else { return Vec::new() };
        // What is shown is the moment before anything moves.
        let mut effects = self.apply(Command::SetPlaying(false));
        effects.extend(self.apply(Command::Seek(0.0)));
        effects.extend(self.apply(Command::SelectStep(stop.step())));
        self.drawer = match stop.target() {
            Target::Right => Some(Side::Right),
            Target::Left => Some(Side::Left),
            Target::View | Target::Timeline => None,
        };
        if stop == Stop::Motion && self.outputs.plan.is_some() {
            effects.extend(self.apply(Command::SetPlaying(true)));
        }
        effects.push(Effect::Announce(format!("{}. {}", stop.title(), stop.words(self))));
        effects
    }

    /// Lets the tour go on by itself; at the last stop it waits.
    pub(super) fn advance_tour(&mut self, dt_s: f64) -> Vec<Effect> {
        let Some(tour) = self.tour.as_mut().filter(|tour| !tour.is_held && self.overlay == Overlay::None) else {
            return Vec::new();
        };
        tour.shown_s = (tour.shown_s + dt_s).min(STAYS_S);
        let next = tour.stop + 1;
        if tour.shown_s >= STAYS_S && next < Stop::ALL.len() {
            return self.apply_tour(TourCommand::To(next));
        }
        Vec::new()
    }

    /// Whether the tour's clock runs.
    pub(super) fn tour_runs(&self) -> bool {
        let goes_on = |tour: &Tour| !tour.is_held && tour.shown_s < STAYS_S;
        self.overlay == Overlay::None && self.tour.as_ref().is_some_and(goes_on)
    }
}
