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

/// A corner that had to give way although it is narrower than this becomes a stop, rad.
const NARROW_BLEND_RAD: f64 = 0.01;

/// A path without repeated points, and how widely each of its corners is rounded.
#[derive(Clone, Debug)]
pub(crate) struct Rounded {
    points: Vec<Vec<f64>>,
    corners: Vec<Corner>,
}

/// How the motion passes an inner point of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Corner {
    /// On a parabola that begins and ends this far from the point, rad.
    Blend(f64),
    /// Through rest.
    Stop,
    /// Through rest that lasts until nothing done before it has an effect on what follows.
    Pause,
}

impl Rounded {
    /// Every corner is rounded as widely as half of its two lines and `blend_rad` allow; while that would touch
    /// something, by half as much, and finally not at all. The rounding leaves the path by at most half its width.
    pub(crate) fn new(space: &ArmSpace, scratch: &mut Scratch, path: &Path, blend_rad: f64) -> Self {
        let mut points: Vec<Vec<f64>> = Vec::new();
        for point in &path.points {
            if points.last().is_none_or(|last| distance_rad(last, point) > SAME_RAD) {
                points.push(point.clone());
            }
        }
        let corners = points.windows(3).map(|corner| widest_blend(space, scratch, corner, blend_rad)).collect();
        Self { points, corners }
    }

    /// Lets the corners nearest to some configurations give way: a narrower blend, then a stop, then a pause.
    ///
    /// The answer is whether any corner still could.
    pub(crate) fn give_way(&mut self, blocked: &[Vec<f64>]) -> bool {
        let mut nearest: Vec<usize> = Vec::new();
        for q in blocked {
            let movable = self.corners.iter().enumerate().filter(|(_, corner)| **corner != Corner::Pause);
            let distance = |index: usize| distance_rad(q, &self.points[index + 1]);
            nearest.extend(movable.map(|(k, _)| k).min_by(|a, b| distance(*a).total_cmp(&distance(*b))));
        }
        nearest.sort_unstable();
        nearest.dedup();
        for &index in &nearest {
            self.corners[index] = match self.corners[index] {
                Corner::Blend(width) if width > NARROW_BLEND_RAD => Corner::Blend(0.25 * width),
                Corner::Blend(_) => Corner::Stop,
                Corner::Stop | Corner::Pause => Corner::Pause,
            };
        }
        !nearest.is_empty()
    }

    /// The path as runs of stretches from rest to rest, each with whether a pause follows it.
    pub(crate) fn runs(&self) -> Vec<(Vec<Stretch>, bool)> {
        let mut runs = Vec::new();
        let Some(mut at) = self.points.first().cloned() else { return runs };
        let mut run = Vec::new();
        for index in 1..self.points.len() {
            let point = &self.points[index];
            match self.corners.get(index - 1).unwrap_or(&Corner::Stop) {
                Corner::Blend(width) => {
                    let corner = &self.points[index - 1..=index + 1];
                    let (enter, leave) = blend_ends(corner, *width);
                    if distance_rad(&at, &enter) > SAME_RAD {
                        run.push(Stretch::line(&at, &enter));
                    }
                    run.push(blend(corner, *width));
                    at = leave;
                }
                stop => {
                    if distance_rad(&at, point) > SAME_RAD {
                        run.push(Stretch::line(&at, point));
                    }
                    if !run.is_empty() {
                        runs.push((std::mem::take(&mut run), *stop == Corner::Pause));
                    }
                    at.clone_from(point);
                }
            }
        }
        runs
    }
}

/// Where a corner's parabola begins and ends.
fn blend_ends(corner: &[Vec<f64>], width: f64) -> (Vec<f64>, Vec<f64>) {
    let enter = lerp(&corner[1], &corner[0], width / distance_rad(&corner[0], &corner[1]));
    let leave = lerp(&corner[1], &corner[2], width / distance_rad(&corner[1], &corner[2]));
    (enter, leave)
}

fn blend(corner: &[Vec<f64>], width: f64) -> Stretch {
    let (enter, _) = blend_ends(corner, width);
    let u = Stretch::line(&corner[0], &corner[1]).u;
    let v = Stretch::line(&corner[1], &corner[2]).u;
    Stretch { start: enter, length: 2.0 * width, u, v }
}

/// The widest free rounding of a corner, halving from `blend_rad`.
fn widest_blend(space: &ArmSpace, scratch: &mut Scratch, corner: &[Vec<f64>], blend_rad: f64) -> Corner {
    let room = distance_rad(&corner[0], &corner[1]).min(distance_rad(&corner[1], &corner[2]));
    let mut width = (0.5 * room).min(blend_rad);
    while width >= SMALLEST_BLEND_RAD {
        let parabola = blend(corner, width);
        // Sixteen chords leave the parabola by at most a 256th of what it leaves its corner by.
        let chords: Vec<Vec<f64>> = (0..=16).map(|k| parabola.at(parabola.length * f64::from(k) / 16.0)).collect();
        if space.blocked_motion(scratch, &chords).is_none() {
            return Corner::Blend(width);
        }
        width *= 0.5;
    }
    Corner::Stop
}
