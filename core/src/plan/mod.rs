//! Paths between arm configurations: search, shortcutting, timing.
//!
//! [`plan_path`] grows two RRT-Connect trees with the whole IK set as goals, [`shorten`] takes the detours out of the
//! path, [`time_path`] rounds its corners and runs along it as fast as joint speeds, accelerations and jerks allow, and
//! [`follow_poses`] moves the hand along given poses. Without random numbers, [`plan_by_roadmap`] searches the joint space
//! along even configurations, and [`follow_route`] takes the hand along one of [`diverse_routes`]. Every edge is proven free, not sampled (see
//! [`ArmSpace::edge_hit`]); [`walk`] checks the result once more with kinematics and geometry of its own.

mod birrt;
mod cartesian;
mod clear;
mod edge;
mod filter;
mod following;
mod hand_edge;
mod hand_grid;
mod hand_route;
mod layers;
mod limits;
pub(crate) mod low_discrepancy;
mod queue;
mod retime;
mod roadmap;
mod roadmap_search;
mod routes;
mod shortcut;
mod smooth;
mod space;
mod steer;
mod swept;
#[cfg(test)]
pub(crate) mod testing;
mod timing;
mod trajectory;
mod tree;
mod turning;
mod upright;
mod walk;

pub use birrt::{BirrtSettings, Found, NoPath, PlanOutcome, plan_path};
pub use cartesian::{CartesianSettings, CartesianStop, NearIk, StopReason, follow_poses, straight_line};
pub use clear::{ClearPath, ClearSettings, plan_clear_path};
pub use edge::{EdgeCause, EdgeHit};
pub use following::{FollowReason, FollowSettings, FollowStop, Followed, FollowingArm, follow_hand};
pub use hand_grid::{FreeSpace, Room};
pub use hand_route::{FollowedRoute, HandRoute, follow_route};
pub use limits::{MotionLimits, MotionQuantity, Violation};
pub use roadmap::Roadmap;
pub use roadmap_search::{RoadmapSettings, plan_by_roadmap};
pub use routes::{RouteRefusal, RouteSettings, diverse_routes};
pub use shortcut::{ShortcutSettings, shorten};
pub(crate) use space::distance_rad;
pub use space::{ArmSpace, ConfigurationFault, Path};
pub use timing::{TimingError, TimingSettings, time_path};
pub use trajectory::Trajectory;
pub use upright::{Tilt, Upright, UprightError};
pub use walk::{WalkHit, walk, walk_path};
