//! Fingers of a robot's own: what moves below the end of an arm, how it opens, and where the hand frame is.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::body::{link_points, middle, moving_below, rest};
use crate::robot::{Placement, Robot};

/// The hand frame is this far from the finger tips, metres: as deep as a jaw holds well.
const BEFORE_TIPS_M: f64 = 0.02;
/// Axes within this of an axis of the tip link are taken to be meant as that axis: cosine of 8°.
const MEANT: f64 = 0.99;
/// Fingers nearer to each other than this have no closing direction, metres.
const APART_M: f64 = 1e-3;

/// What closes below the end of an arm.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fingers {
    /// Link that carries all fingers.
    pub(super) palm: usize,
    /// First joint of each finger, mimics too.
    tops: Vec<usize>,
    /// Degrees of freedom that move them, with the position in which the hand is open and where closing ends.
    pub(super) ends: Vec<(usize, f64, f64)>,
}

impl Fingers {
    /// The fingers below a tip link; `None` where nothing that has a body moves.
    pub(super) fn below(robot: &Robot, tip: usize) -> Option<Self> {
        let body = robot.body_root(tip);
        let tops = moving_below(robot, body);
        let parents: Vec<usize> = tops.iter().map(|&joint| robot.joints[joint].parent).collect();
        let carries = |link: &usize| parents.iter().all(|&parent| robot.chain(*link, parent).is_some());
        let palm = (body..robot.links.len()).rev().filter(|&link| robot.body_root(link) == body).find(carries)?;
        let mut fingers = Self { palm, tops, ends: Vec::new() };
        let links = fingers.links(robot);
        if links.iter().all(|&link| link_points(&robot.links[link]).is_empty()) || fingers.tops.is_empty() {
            return None;
        }
        let mut dofs: Vec<usize> = links.iter().filter_map(|&link| robot.moving_joint(link)?.dof).collect();
        dofs.sort_unstable();
        let q = rest(robot);
        for dof in dofs {
            let limit = robot.joints[robot.dof_joints[dof]].limit;
            let spread = |position: f64| {
                let mut q = q.clone();
                q[dof] = position;
                fingers.spread_m(robot, &q)
            };
            // Where both ends are alike, a joint closes towards its upper limit, as most drivers have it.
            let opens_up = spread(limit.upper) > spread(limit.lower) + 1e-6;
            let (open, closed) = if opens_up { (limit.upper, limit.lower) } else { (limit.lower, limit.upper) };
            fingers.ends.push((dof, open, closed));
        }
        Some(fingers)
    }

    /// All links that the fingers' joints move.
    fn links(&self, robot: &Robot) -> Vec<usize> {
        let is_below =
            |link: &usize| self.tops.iter().any(|&top| robot.chain(robot.joints[top].child, *link).is_some());
        (0..robot.links.len()).filter(is_below).collect()
    }

    /// Points of each finger in a link's frame.
    fn points(&self, robot: &Robot, q: &[f64], in_link: usize) -> Vec<Vec<Point3<f64>>> {
        let X_RL = robot.link_poses(q);
        let X_TR = X_RL[in_link].inverse();
        let of_finger = |&top: &usize| {
            let below = robot.joints[top].child;
            let links = (0..robot.links.len()).filter(|&link| robot.chain(below, link).is_some());
            links
                .flat_map(|link| {
                    let X_TL = X_TR * X_RL[link];
                    link_points(&robot.links[link]).into_iter().map(move |p| X_TL * p)
                })
                .collect()
        };
        self.tops.iter().map(of_finger).collect()
    }

    /// Sum of the distances between the middles of the fingers; of a single one its distance from the middle of the palm.
    fn spread_m(&self, robot: &Robot, q: &[f64]) -> f64 {
        let fingers = self.points(robot, q, self.palm);
        let mut middles: Vec<Point3<f64>> = fingers.iter().filter_map(|points| middle(points)).collect();
        if middles.len() == 1 {
            middles.extend(middle(&link_points(&robot.links[self.palm])));
        }
        let mut sum = 0.0;
        for (index, a) in middles.iter().enumerate() {
            sum += middles[..index].iter().map(|b| (a - b).norm()).sum::<f64>();
        }
        sum
    }

    /// The hand frame H in a tip link: x from one finger to the others, z out of the palm, between the fingers and 2 cm
    /// before their tips. `None` where the fingers do not lie apart.
    pub(super) fn frame(&self, robot: &Robot, tip: usize) -> Option<Placement> {
        let mut q = rest(robot);
        self.ends.iter().for_each(|&(dof, open, _)| q[dof] = open);
        let fingers = self.points(robot, &q, tip);
        let middles: Vec<Point3<f64>> = fingers.iter().filter_map(|points| middle(points)).collect();
        let all = middle(&middles)?;
        // Of three fingers the one that stands alone faces the others.
        let thumb = middles.iter().enumerate().max_by(|l, r| (l.1 - all).norm().total_cmp(&(r.1 - all).norm()))?.0;
        let others: Vec<Point3<f64>> =
            middles.iter().enumerate().filter(|(index, _)| *index != thumb).map(|(_, p)| *p).collect();
        let other = match middle(&others) {
            Some(other) => other,
            None => {
                let X_RL = robot.link_poses(&q);
                let X_TP = X_RL[tip].inverse() * X_RL[self.palm];
                X_TP * middle(&link_points(&robot.links[self.palm]))?
            }
        };
        let x = Unit::try_new(meant((other - middles[thumb]).try_normalize(APART_M)?), 1e-9)?;
        // Out of the palm: towards the fingers, across the closing direction.
        let X_RL = robot.link_poses(&q);
        let palm = (X_RL[tip].inverse() * X_RL[self.palm]).translation.vector;
        let middle_T = nalgebra::center(&middles[thumb], &other);
        let out = middle_T.coords - palm;
        let z = meant((out - x.into_inner() * out.dot(&x)).try_normalize(APART_M)?);
        let z = Unit::try_new(z - x.into_inner() * z.dot(&x), 1e-6)?;
        let farthest = fingers.iter().flatten().map(|p| p.coords.dot(&z)).fold(f64::NEG_INFINITY, f64::max);
        let depth = farthest - BEFORE_TIPS_M;
        let origin = middle_T.coords + z.into_inner() * (depth - middle_T.coords.dot(&z));
        Some(placement(&origin, &x, &z))
    }
}

/// An axis that is nearly one of the frame's own is taken as that one.
fn meant(axis: Vector3<f64>) -> Vector3<f64> {
    let own = [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(|own| [own, -own]);
    own.into_iter().find(|own| own.dot(&axis) > MEANT).unwrap_or(axis)
}

/// A frame by its origin and two of its axes, as URDF writes it.
pub(super) fn placement(origin: &Vector3<f64>, x: &Unit<Vector3<f64>>, z: &Unit<Vector3<f64>>) -> Placement {
    let R = Matrix3::from_columns(&[x.into_inner(), z.cross(x), z.into_inner()]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R));
    let X = Isometry3::from_parts(Translation3::from(*origin), rotation);
    Placement::of(&X)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::samples;

    #[test]
    fn the_hands_of_robots_that_are_known_are_found_as_their_srdf_has_them() {
        let alita = samples::alita();
        for arm in &alita.arms {
            let fingers = Fingers::below(&alita, arm.hand.palm_link).unwrap();
            assert_eq!(fingers.palm, arm.hand.palm_link);
            let ends: Vec<_> = fingers.ends.iter().map(|&(dof, open, closed)| (dof, open, closed)).collect();
            assert_eq!(ends, [(arm.hand.fingers[0][0], arm.hand.open[0], arm.hand.closed[0])]);
            // Its hand frame is on the same axes, 5 mm farther out than ours.
            let X_PH = fingers.frame(&alita, arm.hand.palm_link).unwrap().isometry();
            let X_RL = alita.link_poses(&rest(&alita));
            let known = X_RL[arm.hand.palm_link].inverse() * X_RL[arm.hand.tcp_link];
            let z = X_PH.rotation * Vector3::z();
            assert!((z - known.rotation * Vector3::z()).norm() < 1e-9);
            assert!((X_PH.rotation * Vector3::x()).dot(&(known.rotation * Vector3::x())).abs() > 1.0 - 1e-9);
            assert!((X_PH.translation.vector - known.translation.vector).norm() < 0.01, "{X_PH}");
        }
        let crichton = samples::crichton();
        let hand = &crichton.arms[0].hand;
        assert_eq!(Fingers::below(&crichton, hand.palm_link).unwrap().ends.len(), 6);
        let distal = *hand.fingers[0].last().unwrap();
        let finger_tip = crichton.joints[crichton.dof_joints[distal]].child;
        assert!(Fingers::below(&crichton, finger_tip).is_none(), "below a finger tip nothing closes");
    }
}
