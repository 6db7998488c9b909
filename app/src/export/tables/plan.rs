//! The plan: its phases, what was tried, the routes of the hand, and the places of a handover.

use endcomfort_core::experiment::Cell;
use endcomfort_core::handover::{HandoverReport, Place};
use endcomfort_core::task::{Phase, Plan, Route, Try};

use super::Row;

/// The least of the finite numbers, if there is one.
fn least(values: &[f64]) -> Option<f64> {
    values.iter().copied().filter(|value| value.is_finite()).min_by(f64::total_cmp)
}

/// A number, or nothing where nobody measured it.
fn measured(value: f64) -> Cell {
    Cell::from(Some(value).filter(|value| value.is_finite()))
}

/// Every phase in the order of time.
pub(super) fn phases(plan: &Plan) -> Vec<Row> {
    let row = |(number, phase): (usize, &Phase)| {
        let leg = plan.legs.get(phase.leg);
        let [a, b] = &phase.closest;
        let count = phase.manipulability.len();
        let mean = (count > 0).then(|| phase.manipulability.iter().sum::<f64>() / count as f64);
        Row(vec![
            ("phase", number.into()),
            ("kind", phase.kind.name().into()),
            ("leg", phase.leg.into()),
            ("arm", leg.map(|leg| leg.arm.clone()).into()),
            ("grasp", leg.map(|leg| leg.grasp.id as usize).into()),
            ("start_s", phase.start_s.into()),
            ("duration_s", phase.trajectory.duration_s().into()),
            ("samples", phase.trajectory.times_s.len().into()),
            ("carries_object", phase.carries.into()),
            ("clearance_m", least(&phase.clearance_m).into()),
            ("closest_a", a.clone().into()),
            ("closest_b", b.clone().into()),
            ("manipulability_min", least(&phase.manipulability).into()),
            ("manipulability_mean", mean.into()),
        ])
    };
    plan.phases.iter().enumerate().map(row).collect()
}

/// Everything that was tried in vain, in its order.
pub(super) fn tried(tries: &[Try]) -> Vec<Row> {
    let row = |(number, tried): (usize, &Try)| {
        let q: Vec<String> = tried.q.iter().map(f64::to_string).collect();
        Row(vec![
            ("try", number.into()),
            ("grasp", tried.grasp.map(|grasp| grasp as usize).into()),
            ("arm", tried.arm.clone().into()),
            ("phase", tried.phase.map(|phase| phase.name()).into()),
            ("reason", tried.reason.clone().into()),
            ("culprits", tried.culprits.join("; ").into()),
            ("carries_object", tried.carries.into()),
            ("q_rad", q.join(" ").into()),
        ])
    };
    tries.iter().enumerate().map(row).collect()
}

/// Every route that was looked at.
pub(super) fn routes(plan: &Plan) -> Vec<Row> {
    let row = |(number, route): (usize, &Route)| {
        Row(vec![
            ("route", number.into()),
            ("is_chosen", route.chosen.into()),
            ("length_m", route.length_m.into()),
            ("clearance_m", measured(route.clearance_m)),
            ("duration_s", route.duration_s.into()),
            ("corners", route.points_W.len().into()),
            ("refused", route.refused.clone().into()),
        ])
    };
    plan.routes.iter().enumerate().map(row).collect()
}

/// Every place for a handover, best first.
pub(super) fn places(report: &HandoverReport) -> Vec<Row> {
    let row = |(number, place): (usize, &Place)| {
        let (p, q) = (place.X_WO.translation, place.X_WO.rotation);
        Row(vec![
            ("place", number.into()),
            ("is_chosen", (number == report.chosen).into()),
            ("score", measured(place.score)),
            ("x_m", p.x.into()),
            ("y_m", p.y.into()),
            ("z_m", p.z.into()),
            ("qx", q.i.into()),
            ("qy", q.j.into()),
            ("qz", q.k.into()),
            ("qw", q.w.into()),
            ("giver_grasp", (place.grasps[0] as usize).into()),
            ("receiver_grasp", (place.grasps[1] as usize).into()),
            ("giver_m_g", place.m_g[0].into()),
            ("receiver_m_g", place.m_g[1].into()),
            ("off_line_rad", place.off_line_rad.into()),
            ("off_way_m", place.off_way_m.into()),
            ("by_handle", place.by_handle.into()),
            ("discomfort", place.comfort.map(|comfort| comfort.total).into()),
            ("refused", place.refused.clone().into()),
        ])
    };
    report.places.iter().enumerate().map(row).collect()
}
