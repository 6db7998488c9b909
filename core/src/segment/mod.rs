//! From a scene cloud to a table plane and the clusters that stand on it (thesis 3.5.1).
//!
//! [`segment`] finds the largest plane, keeps what stands on it within its outline, and links points that are closer
//! than a distance into clusters; every point gets a [`PointFate`]. The answer does not depend on the order of the
//! points, on the frame that they are given in, or on whether they are organised. [`table_to_robot`] brings a cloud of
//! unknown origin onto the robot's table. One table per cloud: a second table is an object, or off the first one.

mod cluster;
mod known;
mod outline;
mod plane;
mod ransac;
mod registration;
mod settings;
mod table_top;

pub use plane::Plane;
pub use registration::{TableSpot, table_to_robot};
pub use settings::SegmentSettings;
pub use table_top::{PointFate, SegmentRefusal, Segmentation, segment};
