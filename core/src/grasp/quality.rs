//! Quality of a grasp: the largest ball of wrenches that it resists (Ferrari and Canny 1992).
//!
//! The grasp wrench space is the convex hull of the unit friction-cone edges of all contacts, torques divided by the
//! object's size so that they compare with forces. Only the part of the hull that matters is built: starting from a
//! simplex, the facet nearest to the origin is pushed outwards until it lies on the hull (as in Zheng 2013), which
//! needs tens of facets instead of tens of thousands.
//!
//! Friction is Coulomb's with one coefficient for all contacts ([`GraspSettings::friction`](super::GraspSettings)).

use nalgebra::{Matrix6, Point3, SVector, Vector3};

use super::Contact;
use crate::math;

/// Edges of a linearised friction cone; eight keep at least 92 % of the cone's width.
const CONE_EDGES: usize = 8;
/// Facets after which the hull is given up; the value reached so far is then a lower bound.
const MAX_FACETS: usize = 4000;
/// A facet is on the hull when its farthest wrench is no farther than this.
const ON_HULL: f64 = 1e-9;

pub(super) type Wrench = SVector<f64, 6>;

/// ε: radius of the largest ball of wrenches around the origin that the contacts resist with unit normal forces.
///
/// Forces are in units of one contact's force, torques about `center_O` in units of that force times `size_m`.
/// 0 without force closure.
pub fn epsilon(contacts: &[Contact], friction: f64, center_O: &Point3<f64>, size_m: f64) -> f64 {
    let wrenches = wrenches(contacts, friction, center_O, size_m);
    Hull::new(&wrenches).map_or(0.0, |mut hull| hull.inner_radius())
}

/// Whether every wrench can be resisted: ε > 0, answered sooner.
pub(super) fn has_force_closure(contacts: &[Contact], friction: f64, center_O: &Point3<f64>, size_m: f64) -> bool {
    let wrenches = wrenches(contacts, friction, center_O, size_m);
    Hull::new(&wrenches).is_some_and(|mut hull| hull.holds_origin())
}

/// Wrenches `[f; τ / size]` of all cone edges.
pub(super) fn wrenches(contacts: &[Contact], friction: f64, center_O: &Point3<f64>, size_m: f64) -> Vec<Wrench> {
    let mut wrenches = Vec::with_capacity(contacts.len() * CONE_EDGES);
    for contact in contacts {
        let inward = -contact.n_O;
        let helper = if inward.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let Some(u) = inward.cross(&helper).try_normalize(1e-9) else { continue };
        let v = inward.cross(&u);
        for edge in 0..CONE_EDGES {
            let (sin, cos) = math::sin_cos(std::f64::consts::TAU * edge as f64 / CONE_EDGES as f64);
            let force = inward + friction * (u * cos + v * sin);
            let torque = (contact.p_O - center_O).cross(&force) / size_m;
            wrenches.push(Wrench::new(force.x, force.y, force.z, torque.x, torque.y, torque.z));
        }
    }
    wrenches
}

struct Facet {
    corners: [usize; 6],
    normal: Wrench,
    offset: f64,
}

struct Hull<'a> {
    points: &'a [Wrench],
    interior: Wrench,
    facets: Vec<Facet>,
}

impl<'a> Hull<'a> {
    /// A simplex of seven affinely independent points; `None` when the points span less than six dimensions.
    fn new(points: &'a [Wrench]) -> Option<Self> {
        let first = points.first()?;
        let mut corners = vec![0];
        let mut basis: Vec<Wrench> = Vec::new();
        for _ in 0..6 {
            let mut best = (1e-6, None);
            for (index, point) in points.iter().enumerate() {
                let mut rest = point - first;
                for direction in &basis {
                    rest -= direction * direction.dot(&rest);
                }
                let norm = rest.norm();
                if norm > best.0 {
                    best = (norm, Some((index, rest / norm)));
                }
            }
            let (index, direction) = best.1?;
            corners.push(index);
            basis.push(direction);
        }
        let interior = corners.iter().map(|&i| points[i]).sum::<Wrench>() / 7.0;
        let mut hull = Self { points, interior, facets: Vec::new() };
        for left_out in 0..7 {
            let mut facet = [0; 6];
            let kept = corners.iter().enumerate().filter(|(k, _)| *k != left_out).map(|(_, &c)| c);
            facet.iter_mut().zip(kept).for_each(|(slot, corner)| *slot = corner);
            hull.push_facet(facet);
        }
        Some(hull)
    }

    fn push_facet(&mut self, mut corners: [usize; 6]) {
        corners.sort_unstable();
        // The plane n · x = 1 about the interior point, which no facet contains.
        let rows = Matrix6::from_fn(|row, column| self.points[corners[row]][column] - self.interior[column]);
        let Some(solution) = rows.lu().solve(&Wrench::repeat(1.0)) else { return };
        let norm = solution.norm();
        if !norm.is_finite() || norm < 1e-12 {
            return;
        }
        let normal = solution / norm;
        self.facets.push(Facet { corners, normal, offset: 1.0 / norm + normal.dot(&self.interior) });
    }

    /// Distance from the origin to the hull's boundary; 0 when the origin is outside.
    fn inner_radius(&mut self) -> f64 {
        self.grow(|offset| offset == f64::INFINITY)
    }

    /// Whether the origin is inside: as soon as the part of the hull that is built holds it, all of the hull does.
    fn holds_origin(&mut self) -> bool {
        self.grow(|offset| offset > ON_HULL) > ON_HULL
    }

    /// Builds the hull where it is nearest to the origin until that facet is final, or its offset is enough; the
    /// offset, 0 when the origin is outside.
    fn grow(&mut self, is_enough: impl Fn(f64) -> bool) -> f64 {
        loop {
            let Some(nearest) = self.facets.iter().min_by(|a, b| a.offset.total_cmp(&b.offset)) else { return 0.0 };
            let (normal, offset) = (nearest.normal, nearest.offset);
            if is_enough(offset) {
                return offset;
            }
            let Some((farthest, reach)) =
                self.points.iter().map(|p| normal.dot(p)).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
            else {
                return 0.0;
            };
            if reach <= ON_HULL {
                return 0.0; // every wrench lies on one side of the origin
            }
            if reach <= offset + ON_HULL || self.facets.len() > MAX_FACETS {
                return offset.max(0.0);
            }
            self.expand(farthest);
        }
    }

    /// Replaces the facets that see a point by the cone from their outline to it.
    fn expand(&mut self, point: usize) {
        let p = self.points[point];
        let (visible, hidden): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.facets).into_iter().partition(|f| f.normal.dot(&p) > f.offset + 0.5 * ON_HULL);
        self.facets = hidden;
        let mut ridges: Vec<[usize; 5]> = Vec::with_capacity(visible.len() * 6);
        for facet in &visible {
            for left_out in 0..6 {
                let mut ridge = [0; 5];
                let kept = facet.corners.iter().enumerate().filter(|(k, _)| *k != left_out).map(|(_, &c)| c);
                ridge.iter_mut().zip(kept).for_each(|(slot, corner)| *slot = corner);
                ridges.push(ridge);
            }
        }
        ridges.sort_unstable();
        // A ridge that occurs once separates a visible facet from a hidden one.
        for run in ridges.chunk_by(|a, b| a == b).filter(|run| run.len() == 1) {
            let mut corners = [point; 6];
            corners[..5].copy_from_slice(&run[0]);
            self.push_facet(corners);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn contact(p: [f64; 3], n: [f64; 3]) -> Contact {
        Contact { p_O: Point3::from(p), n_O: Vector3::from(n), penetration_m: 0.0, link: String::new() }
    }

    fn six_sided() -> Vec<Contact> {
        let mut contacts = Vec::new();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut n = [0.0; 3];
                n[axis] = sign;
                let mut p = n;
                p[(axis + 1) % 3] = 0.3;
                contacts.push(contact(p, n));
            }
        }
        contacts
    }

    /// Upper bound by sampling: the hull's support in random directions is never below ε.
    fn sampled_bound(contacts: &[Contact], count: usize) -> f64 {
        let wrenches = wrenches(contacts, 0.5, &Point3::origin(), 1.0);
        let mut rng = Rng::new(3, 0);
        (0..count)
            .map(|_| {
                let u = Wrench::from_fn(|_, _| rng.normal());
                let u = u / u.norm();
                wrenches.iter().map(|w| u.dot(w)).fold(f64::NEG_INFINITY, f64::max)
            })
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn epsilon_is_below_every_sampled_support_and_close_to_the_least() {
        let contacts = six_sided();
        let exact = epsilon(&contacts, 0.5, &Point3::origin(), 1.0);
        let bound = sampled_bound(&contacts, 200_000);
        assert!(exact > 0.05 && exact <= bound + 1e-9, "{exact} against {bound}");
        // 200 000 directions on a 5-sphere come within a fifth of the least support.
        assert!(exact > 0.8 * bound, "{exact} against {bound}");
    }

    #[test]
    fn contacts_on_one_side_resist_nothing() {
        let contacts = [
            contact([0.1, 0.0, 0.0], [0.0, 0.0, 1.0]),
            contact([-0.1, 0.1, 0.0], [0.0, 0.0, 1.0]),
            contact([-0.1, -0.1, 0.0], [0.0, 0.0, 1.0]),
        ];
        assert_eq!(epsilon(&contacts, 0.5, &Point3::origin(), 0.1), 0.0);
        assert_eq!(epsilon(&[], 0.5, &Point3::origin(), 0.1), 0.0);
    }

    #[test]
    fn a_ring_of_contacts_holds_better_than_two_that_nearly_meet() {
        let narrow = [
            contact([0.04, 0.0, 0.0], [1.0, 0.0, 0.0]),
            contact([-0.04, 0.002, 0.0], [-1.0, 0.0, 0.0]),
            contact([-0.04, -0.002, 0.0], [-1.0, 0.0, 0.0]),
        ];
        let (wide, thin) =
            (epsilon(&ring(0.0), 0.5, &Point3::origin(), 0.04), epsilon(&narrow, 0.5, &Point3::origin(), 0.04));
        assert!(wide > thin && thin >= 0.0, "{wide} against {thin}");
    }

    #[test]
    fn closure_agrees_with_a_perceptron_that_looks_for_a_wrench_nothing_resists() {
        // Closure ends where the rise is friction times radius, 20 mm: exactly there the question has no answer.
        for step in 0..8 {
            let contacts = ring(0.0025 + 0.005 * f64::from(step));
            let is_closed = epsilon(&contacts, 0.5, &Point3::origin(), 0.04) > 0.0;
            assert_eq!(is_closed, !is_separable(&contacts, 0.04), "rise of {} mm", 2.5 + 5.0 * f64::from(step));
            assert_eq!(is_closed, has_force_closure(&contacts, 0.5, &Point3::origin(), 0.04));
        }
        assert!(!is_separable(&six_sided(), 1.0));
    }

    /// Whether some direction has a positive product with every wrench (Rosenblatt's perceptron finds one if there is
    /// one; the number of rounds is far beyond what these wrenches need).
    fn is_separable(contacts: &[Contact], size_m: f64) -> bool {
        let wrenches = wrenches(contacts, 0.5, &Point3::origin(), size_m);
        let mut u = Wrench::zeros();
        for _ in 0..200_000 {
            match wrenches.iter().min_by(|l, r| u.dot(l).total_cmp(&u.dot(r))) {
                Some(worst) if u.dot(worst) <= 0.0 => u += worst,
                _ => return true,
            }
        }
        false
    }

    /// Three contacts around a cylinder of 4 cm radius, each higher than the one before.
    fn ring(rise_m: f64) -> Vec<Contact> {
        (0..3)
            .map(|k| {
                let (sin, cos) = math::sin_cos(std::f64::consts::TAU * f64::from(k) / 3.0);
                contact([0.04 * cos, 0.04 * sin, rise_m * f64::from(k - 1)], [cos, sin, 0.0])
            })
            .collect()
    }
}
