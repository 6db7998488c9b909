//! Rounding the corners of a path: straight lines joined by parabolas.

use super::space::{ArmSpace, Path, distance_rad, lerp};
use crate::collision::Scratch;

/// A stretch of a smooth path, run through by a parameter s from 0 to `length`.
///
/// On a line `q' = u` is a unit vector and `q'' = 0`. On a parabola between two lines with directions u and v,
/// tangent to both at the distance `length / 2` before and after their corner, `q' = u + (v − u) s / length` and
/// `q'' = (v − u) / length`: joined at their ends, q and q' are continuous and q'' is bounded.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    pub(crate) start: Vec<f64>,
    pub(crate) length: f64,
    pub(crate) u: Vec<f64>,
    pub(crate) v: Vec<f64>,
}

impl Stretch {
    fn line(from: &[f64], to: &[f64]) -> Self {
        let length = distance_rad(from, to);
        let u: Vec<f64> = from.iter().zip(to).map(|(a, b)| (b - a) / length).collect();
        Self { start: from.to_vec(), length, v: u.clone(), u }
    }

    /// Joint positions at s.
    pub(crate) fn at(&self, s: f64) -> Vec<f64> {
        let bend = 0.5 * s * s / self.length;
        self.start.iter().zip(self.u.iter().zip(&self.v)).map(|(q, (u, v))| q + u * s + (v - u) * bend).collect()
    }

    /// First derivative of one joint at s.
    pub(crate) fn slope(&self, joint: usize, s: f64) -> f64 {
        self.u[joint] + (self.v[joint] - self.u[joint]) * (s / self.length)
    }

    /// Second derivative of one joint.
    pub(crate) fn bend(&self, joint: usize) -> f64 {
        (self.v[joint] - self.u[joint]) / self.length
    }
}

/// Two points closer than this are one point, rad.
const SAME_RAD: f64 = 1e-9;

/// A corner that cannot be rounded by this much is a stop, rad.
const SMALLEST_BLEND_RAD: f64 = 1e-4;

/// The path as runs of stretches; between two runs the arm stops.
///
/// Every corner is rounded as widely as half of its two lines and `blend_rad` allow; while that would touch
/// something, by half as much, and finally not at all. The rounding leaves the path by at most half its width.
pub(crate) fn smooth(space: &ArmSpace, scratch: &mut Scratch, path: &Path, blend_rad: f64) -> Vec<Vec<Stretch>> {
    let mut points: Vec<&Vec<f64>> = Vec::new();
    for point in &path.points {
        if points.last().is_none_or(|last| distance_rad(last, point) > SAME_RAD) {
            points.push(point);
        }
    }
    let mut runs = Vec::new();
    let Some(first) = points.first() else { return runs };
    let mut run = Vec::new();
    let mut at: Vec<f64> = (*first).clone();
    for index in 1..points.len() {
        let corner = points[index];
        let width = points.get(index + 1).and_then(|next| {
            let room = distance_rad(points[index - 1], corner).min(distance_rad(corner, next));
            widest_blend(space, scratch, [points[index - 1], corner, next], (0.5 * room).min(blend_rad))
        });
        let (Some(width), Some(next)) = (width, points.get(index + 1)) else {
            if distance_rad(&at, corner) > SAME_RAD {
                run.push(Stretch::line(&at, corner));
            }
            if !run.is_empty() {
                runs.push(std::mem::take(&mut run));
            }
            at = corner.clone();
            continue;
        };
        let (enter, leave) = blend_ends([points[index - 1], corner, next], width);
        if distance_rad(&at, &enter) > SAME_RAD {
            run.push(Stretch::line(&at, &enter));
        }
        run.push(blend([points[index - 1], corner, next], width));
        at = leave;
    }
    runs
}

/// Where a corner's parabola begins and ends.
fn blend_ends([before, corner, after]: [&Vec<f64>; 3], width: f64) -> (Vec<f64>, Vec<f64>) {
    let enter = lerp(corner, before, width / distance_rad(before, corner));
    let leave = lerp(corner, after, width / distance_rad(corner, after));
    (enter, leave)
}

fn blend(corner: [&Vec<f64>; 3], width: f64) -> Stretch {
    let (enter, _) = blend_ends(corner, width);
    let u = Stretch::line(corner[0], corner[1]).u;
    let v = Stretch::line(corner[1], corner[2]).u;
    Stretch { start: enter, length: 2.0 * width, u, v }
}

/// The widest free rounding of a corner, halving from `width`.
fn widest_blend(space: &ArmSpace, scratch: &mut Scratch, corner: [&Vec<f64>; 3], mut width: f64) -> Option<f64> {
    while width >= SMALLEST_BLEND_RAD {
        let parabola = blend(corner, width);
        // Sixteen chords leave the parabola by at most a 256th of what it leaves its corner by.
        let chords = (0..=16).map(|k| parabola.at(parabola.length * f64::from(k) / 16.0)).collect();
        if space.path_is_free(scratch, &Path { points: chords }) {
            return Some(width);
        }
        width *= 0.5;
    }
    None
}
