//! Where to look for a place: voxels that both hands reach, in the order in which they promise most.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::PlaceChoice;
use super::effort::Effort;
use super::side::Side;

/// Rolls of the receiver's hand about its approach.
const ROLLS: u32 = 8;
/// Turns about the vertical of the object's pose on its way from start to goal, rad.
const TURNS: [f64; 4] = [0.0, std::f64::consts::FRAC_PI_2, std::f64::consts::PI, -std::f64::consts::FRAC_PI_2];

/// A pose to look at.
#[derive(Clone, Debug)]
pub(super) struct Spot {
    /// Centre of its voxel.
    pub(super) voxel: Point3<f64>,
    /// Distance of the voxel from the way of the object, metres.
    pub(super) off_way_m: f64,
    pub(super) pose: SpotPose,
}

/// What is given at a spot.
#[derive(Clone, Debug)]
pub(super) enum SpotPose {
    /// The object; the hands follow from their grasps.
    Object(Isometry3<f64>),
    /// The receiver's hand; the object follows from its grasp.
    ReceiverHand(Isometry3<f64>),
}

/// The segment from the object's start to its goal.
pub(super) struct Way {
    pub(super) X_WO_start: Isometry3<f64>,
    pub(super) X_WO_goal: Isometry3<f64>,
}

impl Way {
    /// Distance of a point from the segment, metres, and how far along the nearest point of it is, in [0, 1].
    fn nearest(&self, p: &Point3<f64>) -> (f64, f64) {
        let (a, b) = (self.X_WO_start.translation.vector, self.X_WO_goal.translation.vector);
        let along = b - a;
        let t = ((p.coords - a).dot(&along) / along.norm_squared().max(1e-12)).max(0.0).min(1.0);
        ((p.coords - a - along * t).norm(), t)
    }
}

/// Spots in the order in which they are looked at, and the number of voxels that both hands reach well enough.
///
/// With the receiver first: by the receiver's share of its best manipulability, its hand along the line from its shoulder
/// to the giver's (6.2). Otherwise by the distance to the way, the object turned as far as it is along (6.1).
pub(super) fn spots(
    [giver, receiver]: [&Side<'_>; 2],
    way: &Way,
    choice: &PlaceChoice,
    effort: Effort,
) -> (Vec<Spot>, usize) {
    let mut voxels: Vec<(f64, Point3<f64>)> = Vec::new();
    let map = receiver.map;
    for center in map.into_iter().flat_map(|map| map.voxels().map(|voxel| map.center(voxel))) {
        let center = receiver.X_WB * center;
        let shares = [giver.share(&center), receiver.share(&center)];
        if shares.iter().all(|share| *share >= choice.threshold) {
            let order = if choice.receiver_first { -shares[1] } else { way.nearest(&center).0 };
            voxels.push((order, center));
        }
    }
    // A stable sort: equal ones stay in the order of the map.
    voxels.sort_by(|l, r| l.0.total_cmp(&r.0));
    let count = voxels.len();
    let rotations = along_shoulders(&(giver.shoulder() - receiver.shoulder()), effort.tilts());
    let spots = voxels.into_iter().flat_map(|(_, voxel)| {
        let (off_way_m, t) = way.nearest(&voxel);
        let at = Translation3::from(voxel.coords);
        let poses: Vec<SpotPose> = if choice.receiver_first {
            let hand = |R: &UnitQuaternion<f64>| SpotPose::ReceiverHand(Isometry3::from_parts(at, *R));
            rotations.iter().map(hand).collect()
        } else {
            let between = between(&way.X_WO_start.rotation, &way.X_WO_goal.rotation, t);
            let turned = |turn: &f64| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *turn) * between;
            let tilts = effort.object_tilts().iter().map(tilted);
            let rotations = tilts.flat_map(|tilt| TURNS.iter().map(move |turn| tilt * turned(turn)));
            rotations.map(|R| SpotPose::Object(Isometry3::from_parts(at, R))).collect()
        };
        poses.into_iter().map(move |pose| Spot { voxel, off_way_m, pose })
    });
    (spots.collect(), count)
}

/// The rotation a share of the way from one to the other; half turns have no shortest way, any will do.
fn between(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>, t: f64) -> UnitQuaternion<f64> {
    from.try_slerp(to, t, 1e-9).unwrap_or(if t < 0.5 { *from } else { *to })
}

/// A tilt about the x and the y axis, rad.
fn tilted([about_x, about_y]: &[f64; 2]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), *about_x)
        * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), *about_y)
}

/// Rotations of a hand whose approach (z) goes along a direction of the world or nearly so; those along it first.
fn along_shoulders(direction: &Vector3<f64>, tilts: &[[f64; 2]]) -> Vec<UnitQuaternion<f64>> {
    let along = Rotation3::rotation_between(&Vector3::z(), direction).unwrap_or_else(Rotation3::identity);
    let along = UnitQuaternion::from_rotation_matrix(&along);
    let mut rotations = Vec::new();
    for tilt in tilts.iter().map(tilted) {
        for roll in 0..ROLLS {
            let angle = std::f64::consts::TAU * f64::from(roll) / f64::from(ROLLS);
            rotations.push(along * tilt * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle));
        }
    }
    rotations
}
