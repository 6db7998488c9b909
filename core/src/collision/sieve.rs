//! A sieve before the exact checker: many configurations side by side, each answered by "surely free" or "unknown".
//!
//! Bodies that move count as the capsules that hold them ([`super::cover`]); what stands still counts as a box, a cylinder
//! or a capsule around it. A pair is apart when a plane keeps it apart: any direction n with
//! `min_A n·x − max_B n·x > margin ‖n‖` proves it, however n was found, so neither the search for n nor its round-off can
//! make an answer wrong. Intended contacts are looked at as if they were none: while they last, the exact checker answers.
//!
//! The sieve computes in `f32`. Its round-off and the tolerance of the exact checker's GJK are added to the margin
//! ([`Sieve::slack_m`]), so that what passes the sieve is certain to be accepted by the exact checker.

use nalgebra::{Matrix3, Unit, UnitQuaternion, Vector3};

use super::checker::{Checker, Cluster, Fixed, Obstacles};
use super::cover::{Capsule, box_around, capsules};
use super::frames::{MovingFrame, Rigid};
use super::solid::Core;
use crate::robot::JointKind;

/// By how much the exact checker's GJK may take bodies for closer than they are, metres: it stalls up to 5e-5 m away from
/// the closest points of curved shapes.
const GJK_M: f64 = 1e-4;
/// Half a unit in the last place of `f32`, relative.
const EPSILON: f64 = 5.960_464_477_539_063e-8;
/// Round-offs of that size in a coordinate, per joint before it and at the end of the chain: a frame's pose takes the sine,
/// a product of matrices and a sum; a gap takes five products and their sum.
const PER_JOINT: f64 = 24.0;
const AT_THE_END: f64 = 96.0;
/// A joint beyond this many radians is not looked at: reducing the angle would cost digits.
const MOST_RAD: f32 = 1000.0;

/// What is precomputed for a checker.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sieve {
    pub(super) columns: usize,
    pub(super) joints: Vec<Joint>,
    pub(super) capsules: Vec<Moving>,
    pub(super) groups: Vec<Group>,
    pub(super) boxes: Vec<Placed<[f32; 3]>>,
    pub(super) cylinders: Vec<Placed<[f32; 2]>>,
    pub(super) rods: Vec<Rod>,
    pub(super) pairs: Vec<Pair>,
    /// Where each fixed body of the checker stands in the lists above.
    pub(super) places: Vec<Place>,
    pub(super) tree: Option<Obstacles>,
    /// Round-off of a coordinate, metres.
    round_off_m: f64,
}

/// A joint and the frame that it moves, turned so that the joint's axis is z. Entry 0 is the first moving frame.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    /// Index of the parent frame, 0 for the world.
    pub(super) parent: usize,
    pub(super) R: [f32; 9],
    pub(super) t: [f32; 3],
    pub(super) slides: bool,
    pub(super) column: usize,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
    /// Positions farther from 0 are not looked at.
    pub(super) most: f32,
}

/// A capsule in its frame.
#[derive(Clone, Debug)]
pub(super) struct Moving {
    pub(super) frame: usize,
    pub(super) a: [f32; 3],
    /// From one end of its axis to the other.
    pub(super) d: [f32; 3],
    pub(super) radius: f32,
    /// Half of the length of its axis.
    pub(super) half: f32,
    /// `1 / ‖d‖²`, 0 for a ball.
    pub(super) inverse: f32,
    /// How far each end moves per unit of each column of `q`.
    levers: [Vec<f64>; 2],
}

/// The capsules of one cluster and what they may meet that stands still.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) frame: usize,
    pub(super) center: [f32; 3],
    pub(super) radius: f32,
    pub(super) begin: usize,
    pub(super) end: usize,
    /// Fixed bodies that it may meet and that are not in the tree.
    pub(super) against: Vec<usize>,
    /// One bit for each fixed body of the tree: whether it may meet that.
    pub(super) in_tree: Vec<u64>,
}

/// Something that stands still, with the axis-aligned box around it.
#[derive(Clone, Debug)]
pub(super) struct Placed<S> {
    /// Half edge lengths of a box; radius and half length of a cylinder along z.
    pub(super) size: S,
    /// Rotation into its frame, row by row; `None` where that is the world's.
    pub(super) turned: Option<[f32; 9]>,
    pub(super) center: [f32; 3],
    pub(super) lower: [f32; 3],
    pub(super) upper: [f32; 3],
}

/// A capsule that stands still.
#[derive(Clone, Debug)]
pub(super) struct Rod {
    pub(super) a: [f32; 3],
    pub(super) d: [f32; 3],
    pub(super) inverse: f32,
    pub(super) radius: f32,
    pub(super) lower: [f32; 3],
    pub(super) upper: [f32; 3],
}

/// Two groups that move relative to each other.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub(super) a: usize,
    pub(super) b: usize,
    /// Whether only the travel of `b` counts.
    pub(super) only_b: bool,
}

impl Sieve {
    /// For the frames, bodies and pairs of a checker.
    pub(super) fn new(checker: &Checker) -> Self {
        let turns: Vec<Matrix3<f64>> = checker.frames.iter().map(z_to_axis).collect();
        let joints = checker.frames.iter().enumerate().skip(1).map(|(index, frame)| {
            let R = turns[frame.parent].transpose() * frame.X_PJ.R * turns[index];
            Joint {
                parent: frame.parent,
                R: rows(&R),
                t: single(&turns[frame.parent].tr_mul(&frame.X_PJ.t)),
                slides: frame.kind == JointKind::Prismatic,
                column: frame.column,
                multiplier: frame.multiplier,
                offset: frame.offset,
                most: if frame.kind == JointKind::Prismatic { above(frame.slide_m) } else { MOST_RAD },
            }
        });
        let mut sieve = Self { columns: checker.dofs.len(), joints: joints.collect(), ..Self::default() };
        sieve.places = checker.fixed.iter().map(|fixed| sieve.stand(fixed)).collect();
        sieve.tree.clone_from(&checker.tree);
        let mut scale: f64 =
            checker.fixed.iter().map(|f| f.lower.abs().max().max(f.upper.abs().max())).fold(0.0, f64::max);
        for cluster in &checker.clusters {
            scale = scale.max(farthest(&checker.frames, cluster));
            sieve.join(checker, cluster, &turns[cluster.frame]);
        }
        let pairs = checker.pairs.iter();
        sieve.pairs = pairs.map(|pair| Pair { a: pair.a, b: pair.b, only_b: pair.b_hangs_on_a }).collect();
        sieve.round_off_m = (PER_JOINT * sieve.joints.len() as f64 + AT_THE_END) * EPSILON * scale;
        sieve
    }

    /// What is added to all radii so that gaps of the sieve are more than gaps of the exact checker, metres.
    pub(super) fn slack_m(&self, margin_m: f64) -> f32 {
        above(margin_m + GJK_M + self.round_off_m)
    }

    /// Upper bounds of the distance that the ends of each capsule travel along half of the straight motion, metres.
    ///
    /// A point of the axis is a mean of the ends, and so is its way at most; a point of the body stays within the radius
    /// of a point of the axis. The radius itself adds nothing to the travel.
    pub(super) fn half_travel(&self, from: &[f64], to: &[f64], travel: &mut Vec<[f32; 2]>) {
        travel.clear();
        travel.extend(self.capsules.iter().map(|capsule| {
            capsule.levers.each_ref().map(|levers| {
                let ways = levers.iter().zip(from.iter().zip(to)).map(|(lever, (a, b))| lever * (b - a).abs());
                above(0.5 * ways.sum::<f64>())
            })
        }));
    }

    fn stand(&mut self, fixed: &Fixed) -> Place {
        let (lower, upper) = (single(&fixed.lower), single(&fixed.upper));
        let solid = &fixed.solid;
        match &solid.core {
            Core::Segment { a, b } => {
                let d = b - a;
                self.rods.push(Rod {
                    a: single(a),
                    d: single(&d),
                    inverse: inverse(&d),
                    radius: above(solid.radius),
                    lower,
                    upper,
                });
                Place::Rod(self.rods.len() - 1)
            }
            Core::Cylinder { radius, half_length } => {
                let (turned, center) = turned(&solid.X_FB);
                let size = [above(radius + solid.radius), above(half_length + solid.radius)];
                self.cylinders.push(Placed { size, turned, center, lower, upper });
                Place::Cylinder(self.cylinders.len() - 1)
            }
            Core::Box { half } => self.stand_box(&solid.X_FB, half, solid.radius, (lower, upper)),
            Core::Hull(hull) => {
                let around = hull.box_around();
                self.stand_box(&solid.X_FB.then(&around.X_FB), &around.half, solid.radius, (lower, upper))
            }
            Core::Triangle { corners } => {
                let around = box_around(corners);
                self.stand_box(&solid.X_FB.then(&around.X_FB), &around.half, solid.radius, (lower, upper))
            }
        }
    }

    fn stand_box(&mut self, X: &Rigid, half: &Vector3<f64>, radius: f64, around: ([f32; 3], [f32; 3])) -> Place {
        let (turned, center) = turned(X);
        let size = std::array::from_fn(|i| above(half[i] + radius));
        self.boxes.push(Placed { size, turned, center, lower: around.0, upper: around.1 });
        Place::Box(self.boxes.len() - 1)
    }

    fn join(&mut self, checker: &Checker, cluster: &Cluster, turn: &Matrix3<f64>) {
        let begin = self.capsules.len();
        let covers = cluster.solids.iter().flat_map(capsules);
        self.capsules.extend(covers.map(|capsule| moving(checker, cluster.frame, &capsule, turn)));
        let lower =
            |k: usize| self.capsules[begin..].iter().map(|c| c.a[k].min(c.a[k] + c.d[k])).fold(f32::MAX, f32::min);
        let upper =
            |k: usize| self.capsules[begin..].iter().map(|c| c.a[k].max(c.a[k] + c.d[k])).fold(f32::MIN, f32::max);
        let center: [f32; 3] = std::array::from_fn(|k| 0.5 * (lower(k) + upper(k)));
        let reach = |c: &Moving| {
            let from = |s: f32, k: usize| c.a[k] + s * c.d[k] - center[k];
            let end = |s: f32| (0..3).map(|k| from(s, k) * from(s, k)).sum::<f32>().sqrt();
            end(0.0).max(end(1.0)) + c.radius
        };
        let radius = above(f64::from(self.capsules[begin..].iter().map(reach).fold(0.0, f32::max)));
        let in_tree = self.tree.as_ref().map_or(0, |tree| tree.count);
        let mut group = Group {
            frame: cluster.frame,
            center,
            radius,
            begin,
            end: self.capsules.len(),
            against: Vec::new(),
            in_tree: vec![0; in_tree.div_ceil(64)],
        };
        for &(fixed, _) in &cluster.against {
            match group.in_tree.get_mut(fixed / 64).filter(|_| fixed < in_tree) {
                Some(bits) => *bits |= 1 << (fixed % 64),
                None => group.against.push(fixed),
            }
        }
        self.groups.push(group);
    }
}

/// Where a fixed body stands in the sieve's lists.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    Box(usize),
    Cylinder(usize),
    Rod(usize),
}

/// The rotation into a frame, unless it is none, and its origin.
fn turned(X: &Rigid) -> (Option<[f32; 9]>, [f32; 3]) {
    let is_straight = (X.R - Matrix3::identity()).abs().max() == 0.0;
    ((!is_straight).then(|| rows(&X.R.transpose())), single(&X.t))
}

fn moving(checker: &Checker, frame: usize, capsule: &Capsule, turn: &Matrix3<f64>) -> Moving {
    let d = capsule.b - capsule.a;
    Moving {
        frame,
        a: single(&turn.tr_mul(&capsule.a)),
        d: single(&turn.tr_mul(&d)),
        radius: above(capsule.radius),
        half: above(0.5 * d.norm()),
        inverse: inverse(&d),
        levers: [&capsule.a, &capsule.b].map(|p| levers(&checker.frames, frame, p, checker.dofs.len())),
    }
}

/// For each column of `q` the largest distance of a point of a frame to the joint's axis over all configurations, m/rad,
/// or 1 for a prismatic joint; see [`Checker::displacement_m`].
fn levers(frames: &[MovingFrame], frame: usize, p_F: &Vector3<f64>, columns: usize) -> Vec<f64> {
    let mut levers = vec![0.0; columns];
    let perpendicular = |p: &Vector3<f64>, axis: &Vector3<f64>| (p - axis * p.dot(axis)).norm();
    let mut ball = p_F.norm();
    let mut lever = perpendicular(p_F, &frames[frame].axis);
    let mut at = frame;
    loop {
        let joint = &frames[at];
        let per_unit = if joint.kind == JointKind::Prismatic { 1.0 } else { lever };
        levers[joint.column] += per_unit * joint.multiplier.abs();
        if joint.parent == 0 {
            return levers;
        }
        ball += joint.slide_m;
        lever = perpendicular(&joint.X_PJ.t, &frames[joint.parent].axis) + ball;
        ball += joint.X_PJ.t.norm();
        at = joint.parent;
    }
}

/// No coordinate of the cluster's points is ever larger, metres.
fn farthest(frames: &[MovingFrame], cluster: &Cluster) -> f64 {
    let mut radius = cluster.center.norm() + 2.0 * cluster.bound;
    let mut frame = cluster.frame;
    while frame != 0 {
        radius += frames[frame].slide_m + frames[frame].X_PJ.t.norm();
        frame = frames[frame].parent;
    }
    radius
}

/// A rotation that takes z to the joint's axis.
fn z_to_axis(frame: &MovingFrame) -> Matrix3<f64> {
    let axis = Unit::new_unchecked(frame.axis);
    let half_turn = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &axis)
        .unwrap_or_else(half_turn)
        .to_rotation_matrix()
        .into_inner()
}

/// Row by row; round-off of right angles becomes an exact 0, which costs no time later.
fn rows(R: &Matrix3<f64>) -> [f32; 9] {
    std::array::from_fn(|entry| R[(entry / 3, entry % 3)] as f32).map(|x: f32| if x.abs() < 1e-9 { 0.0 } else { x })
}

pub(super) fn single(v: &Vector3<f64>) -> [f32; 3] {
    std::array::from_fn(|k| v[k] as f32)
}

/// The number in single precision, rather too large than too small.
fn above(x: f64) -> f32 {
    (x * (1.0 + 4.0 * EPSILON)) as f32
}

fn inverse(d: &Vector3<f64>) -> f32 {
    // Below this squared length (1e-6 m) an axis is a point.
    if d.norm_squared() > 1e-12 { (1.0 / d.norm_squared()) as f32 } else { 0.0 }
}
