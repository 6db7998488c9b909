//! A fit that contradicts what the camera saw is tried again within what was seen.
//!
//! A shape may explain the points and still stand where the camera looked through: robust weights prefer one face of an
//! object that is no superquadric, and what is behind that face is then free. So the fitted surface is held against the
//! view like a mirrored cloud: outside the outline, in front of what was measured, or below the table is impossible.

use super::candidate::Candidate;
use super::prepare::Prepared;
use super::view::View;

/// A fit contradicts the view when its surface is impossible by more than this on average, metres: more than the fits of
/// solid household objects (1 to 6 mm, by the roundness of their edges), less than a box around a pair of pliers.
const ALLOWED_M: f64 = 0.010;
/// Columns and rows of the mesh whose vertices are judged, in the measure of `mesh_in_axes`.
const MESH_HALF: u32 = 4;
/// Another fit takes its place when it contradicts half as much at most…
const MUST_FALL_TO: f64 = 0.5;
/// …and its error on the points is not out of all proportion: the factor and the length by which its error may be larger, metres.
const ERROR_FACTOR: f64 = 2.5;
const ERROR_SLACK_M: f64 = 0.004;

/// Mean impossibility of a candidate's surface, metres.
pub(crate) fn contradiction_m(prepared: &Prepared, view: &View, candidate: &Candidate) -> f64 {
    let mesh = candidate.superquadric(&nalgebra::Isometry3::identity()).mesh(MESH_HALF);
    let below = |z: f64| if prepared.table.is_some() { (-z).max(0.0) } else { 0.0 };
    let sum: f64 = mesh.positions.iter().map(|p| view.impossibility(p).total_m() + below(p.z)).sum();
    sum / mesh.positions.len().max(1) as f64
}

/// Whether a fit should be tried again.
pub(crate) fn is_too_much(contradiction_m: f64) -> bool {
    contradiction_m > ALLOWED_M
}

/// Whether another fit (contradiction, error on the points, both metres) is the better answer.
pub(crate) fn is_better(other: (f64, f64), present: (f64, f64)) -> bool {
    other.0 <= MUST_FALL_TO * present.0 && other.1 <= ERROR_FACTOR * present.1 + ERROR_SLACK_M
}
