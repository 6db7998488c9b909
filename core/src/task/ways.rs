//! The ways that allow the least: straight ones away from a grasp, up and down with the object, along the table, and
//! the turn that pours. They are found first; what is left between them is searched.

use nalgebra::{Isometry3, Translation3};

use super::motion::{Mover, reversed};
use super::setback::{Blocked, Setback};
use super::{PhaseKind, Planner};
use crate::grasp::Situated;
use crate::plan::{ArmSpace, Path, distance_rad};

/// Configurations of an IK set whose ways are looked for when the hand shall follow a route.
const TRIED_FOR_ROUTES: usize = 48;
/// Configurations of an IK set whose ways are looked for because they are near.
const TRIED_NEAREST: usize = 6;

/// The ways from one configuration that holds the object.
pub(super) struct Ways {
    /// Where the hand holds the object at its place.
    pub(super) held: Vec<f64>,
    /// Backwards along the approach, with open fingers; empty where the object stays in the hand.
    pub(super) back: Path,
    /// With the object: up from its place, back along the table to where it stood, or upright again.
    pub(super) with_object: Path,
}

/// The space and the phase in which a way is gone.
pub(super) type In<'a> = (PhaseKind, &'a ArmSpace);

/// Ways in and up from configurations of an IK set; `near` is where the arm comes from.
pub(super) fn picks(
    mover: &Mover<'_>,
    set: &Situated,
    X_WH: &Isometry3<f64>,
    open: In<'_>,
    carrying: In<'_>,
    near: Option<&[f64]>,
) -> Result<Vec<Ways>, Setback> {
    collect(mover, set, near, |q| {
        let back = mover.back_off(open.1, q, X_WH).map_err(|blocked| blocked.in_phase(open.0, false))?;
        let rise = mover.rise(carrying.1, q, X_WH).map_err(|blocked| blocked.in_phase(carrying.0, true))?;
        Ok(Ways { held: q.to_vec(), back, with_object: rise })
    })
}

/// Ways along the table: from the start's configurations the object is pushed to its goal, and left there.
pub(super) fn slides(
    mover: &Mover<'_>,
    set: &Situated,
    X_OH: &Isometry3<f64>,
    [X_WO_start, X_WO_end]: [&Isometry3<f64>; 2],
    [approaching, sliding, leaving]: [&ArmSpace; 3],
) -> Result<Vec<(Ways, Path)>, Setback> {
    let (X_WH_start, X_WH_end) = (X_WO_start * X_OH, X_WO_end * X_OH);
    collect(mover, set, None, |q| {
        let fail = |phase, carries| move |blocked: Blocked| blocked.in_phase(phase, carries);
        let back = mover.back_off(approaching, q, &X_WH_start).map_err(fail(PhaseKind::Reach, false))?;
        let along = mover.straight(sliding, q, &X_WH_start, &X_WH_end).map_err(fail(PhaseKind::Slide, true))?;
        let end = along.points.last().map_or(q, Vec::as_slice);
        let leave = mover.back_off(leaving, end, &X_WH_end).map_err(fail(PhaseKind::Retreat, false))?;
        Ok((Ways { held: q.to_vec(), back, with_object: along }, leave))
    })
}

/// Ways from the configurations that tilt the object to those that hold it upright at the same spot.
pub(super) fn pours(
    mover: &Mover<'_>,
    set: &Situated,
    X_OH: &Isometry3<f64>,
    X_WO_upright: &Isometry3<f64>,
    carrying: &ArmSpace,
    near: Option<&[f64]>,
) -> Result<Vec<Ways>, Setback> {
    let (X_WH, X_WH_upright) = (set.X_WO * X_OH, X_WO_upright * X_OH);
    collect(mover, set, near, |q| {
        let tilt_back = mover.straight(carrying, q, &X_WH, &X_WH_upright);
        let with_object = tilt_back.map_err(|blocked| blocked.in_phase(PhaseKind::Pour, true))?;
        Ok(Ways { held: q.to_vec(), back: Path::default(), with_object })
    })
}

/// The ways of all configurations that have them; the first one's setback if none has.
fn collect<T>(
    mover: &Mover<'_>,
    set: &Situated,
    near: Option<&[f64]>,
    mut ways: impl FnMut(&[f64]) -> Result<T, Setback>,
) -> Result<Vec<T>, Setback> {
    let mut found = Vec::new();
    let mut first: Option<Setback> = None;
    for index in tried(mover, set, near) {
        match ways(&set.solutions[index]) {
            Ok(ways) => found.push(ways),
            Err(setback) => first = first.or(Some(setback)),
        }
    }
    match first.filter(|_| found.is_empty()) {
        Some(mut setback) => {
            setback.blocked.reason = format!("no straight way: {}", setback.blocked.reason);
            Err(setback)
        }
        None if found.is_empty() => {
            Err(Blocked::because("no configuration of the arm").in_phase(PhaseKind::Reach, false))
        }
        None => Ok(found),
    }
}

/// Configurations whose ways are looked for: those that promise them, and those nearest to where the arm comes from,
/// because these make for short ways. A hand that follows a route can hardly change the branch of its arm: for the
/// planner of routes, others evenly over the set.
fn tried(mover: &Mover<'_>, set: &Situated, near: Option<&[f64]>) -> Vec<usize> {
    let mut tried = set.with_ways.clone();
    let solutions = &set.solutions;
    match near {
        _ if mover.settings.planner == Planner::Routes => {
            let stride = solutions.len().div_ceil(TRIED_FOR_ROUTES).max(1);
            tried.extend((0..solutions.len()).step_by(stride));
        }
        Some(q) => {
            let mut nearest: Vec<(f64, usize)> =
                solutions.iter().enumerate().map(|(index, to)| (distance_rad(q, to), index)).collect();
            nearest.sort_by(|l, r| l.0.total_cmp(&r.0).then(l.1.cmp(&r.1)));
            tried.extend(nearest.into_iter().take(TRIED_NEAREST).map(|(_, index)| index));
        }
        None => {}
    }
    let mut known = vec![false; solutions.len()];
    tried.retain(|&index| !std::mem::replace(&mut known[index], true));
    tried
}

impl Ways {
    /// Where a way to this place ends: above it, or upright beside it.
    pub(super) fn entry(&self) -> &[f64] {
        self.with_object.points.last().map_or(&self.held, Vec::as_slice)
    }

    /// The way in, with the object.
    pub(super) fn inwards(&self) -> Path {
        reversed(&self.with_object)
    }
}

/// The pose from which a pour tilts the object and to which it turns it back: the same spot, the axis that was upright
/// at `X_WO_start` upright again, turned by the smallest angle.
pub(crate) fn upright_again(X_WO: &Isometry3<f64>, X_WO_start: &Isometry3<f64>) -> Isometry3<f64> {
    let up_O = X_WO_start.rotation.inverse() * nalgebra::Vector3::z();
    let tilted = X_WO.rotation * up_O;
    // Upside down has no smallest turn: any horizontal axis does.
    let righted = nalgebra::UnitQuaternion::rotation_between(&tilted, &nalgebra::Vector3::z()).unwrap_or_else(|| {
        nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::x_axis(), std::f64::consts::PI)
    });
    Isometry3::from_parts(Translation3::from(X_WO.translation.vector), righted * X_WO.rotation)
}
