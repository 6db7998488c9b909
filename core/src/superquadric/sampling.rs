//! Points spread evenly over the surface, with normals: where grasps start.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use super::Superquadric;
use super::superellipse::{QuarterArc, UnitPoint, unfold};
use crate::math;

/// Steps along one quarter of a curve at most, so that a tiny spacing ends in time.
const MAX_STEPS: f64 = 2000.0;
/// Two samples are never closer than this part of the spacing: what is left of the poles, where rings meet, and of
/// the short sides of flat shapes.
const CLOSEST: f64 = 0.7;
/// The same on deformed shapes, where samples are thrown out of many: leaves one sample per spacing squared.
const CLOSEST_THROWN: f64 = 0.95;
/// Points to choose from, per spacing.
const CHOICE: f64 = 4.0;

/// A surface point with its outward normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    /// Point in F, metres.
    pub p_F: Point3<f64>,
    /// Outward unit normal in F.
    pub n_F: Vector3<f64>,
}

impl Superquadric {
    /// Evenly spread surface samples with density N (thesis 4.2): N points go once around a sphere of the same abc.
    ///
    /// The spacing is `2π ∛(abc) / N`, so the count grows with N²; see [`Superquadric::samples_spaced`].
    pub fn samples(&self, density: u32) -> Vec<SurfaceSample> {
        let radius_m = math::powf(self.a * self.b * self.c, 1.0 / 3.0);
        self.samples_spaced(std::f64::consts::TAU * radius_m / f64::from(density.max(1)))
    }

    /// Surface samples about `spacing_m` metres apart, in a fixed order from the equator to the poles.
    ///
    /// The product of two superellipses, each in equal steps (after Pilu and Fisher 1995): the profile with e1, then
    /// around each ring the section with e2, in a number of steps that fits the ring's own length. Where rings come
    /// closer than the spacing (poles, short sides of flat shapes) samples nearer than 0.7 spacings to an earlier one
    /// are left out. The set is symmetric about the three axis planes except for those left out.
    ///
    /// Taper and bend stretch a surface unevenly, so a deformed one is covered by such rings several times finer, and
    /// of their points each that is at least 0.95 spacings from all earlier ones is taken: the same order, no symmetry.
    pub fn samples_spaced(&self, spacing_m: f64) -> Vec<SurfaceSample> {
        let section = QuarterArc::new(self.a, self.b, self.e2);
        let profile = QuarterArc::new(section.largest_radius_m, self.c, self.e1);
        let shortest_m = profile.length_m().max(section.length_m()) / MAX_STEPS;
        let spacing_m = if spacing_m.is_finite() { spacing_m.max(shortest_m) } else { profile.length_m() };
        if self.is_deformed() {
            return self.thrown_samples(&section, &profile, spacing_m);
        }

        let latitudes = profile.equal_steps(steps(profile.length_m(), spacing_m));
        let mut taken = Spread::new(CLOSEST * spacing_m);
        let mut samples = Vec::new();
        for [ring, height] in latitudes {
            let around = ring_points(&section, ring, spacing_m);
            for side in if height > 0.0 { &[1.0, -1.0][..] } else { &[1.0][..] } {
                for [u, v] in &around {
                    let p_S = Point3::new(self.a * ring * u, self.b * ring * v, self.c * height * side);
                    if taken.add(&p_S) {
                        samples.push(self.sample_at(&p_S));
                    }
                }
            }
        }
        samples
    }

    /// Samples of a tapered or bent shape.
    fn thrown_samples(&self, section: &QuarterArc, profile: &QuarterArc, spacing_m: f64) -> Vec<SurfaceSample> {
        let fine_m = spacing_m / CHOICE;
        // How much longer the profile can get: wider, slanted and around the outside of the bend.
        let widest = 1.0 + self.taper.abs();
        let slanted = widest + self.taper.abs() * section.largest_radius_m / self.c;
        let stretched = slanted * (1.0 + self.bend_per_m.abs() * self.b * widest);
        let mut taken = Spread::new(CLOSEST_THROWN * spacing_m);
        let mut samples = Vec::new();
        for [ring, height] in profile.equal_steps(steps(profile.length_m() * stretched, fine_m)) {
            for side in if height > 0.0 { &[1.0, -1.0][..] } else { &[1.0][..] } {
                let scale = 1.0 + self.taper * height * side;
                for [u, v] in ring_points(section, ring, fine_m / scale) {
                    let p_0 = Point3::new(self.a * ring * u, self.b * ring * v, self.c * height * side);
                    if taken.add(&self.from_base(&p_0)) {
                        samples.push(self.sample_at(&p_0));
                    }
                }
            }
        }
        samples
    }

    /// The sample at a point of the base surface.
    fn sample_at(&self, p_0: &Point3<f64>) -> SurfaceSample {
        let n_S = self.gradient_from_base(p_0, &self.base_gauge(p_0).gradient());
        let n_F = self.X_FS.rotation * n_S.try_normalize(0.0).unwrap_or_else(Vector3::z);
        SurfaceSample { p_F: self.X_FS * self.from_base(p_0), n_F }
    }
}

/// How many steps of about `spacing_m` a quarter of this length takes.
fn steps(length_m: f64, spacing_m: f64) -> usize {
    // A cast cuts towards zero; not more than MAX_STEPS because the spacing is held above that.
    ((length_m / spacing_m + 0.5) as usize).max(1)
}

/// The points of one ring; a pole is a single point.
fn ring_points(section: &QuarterArc, ring: f64, spacing_m: f64) -> Vec<UnitPoint> {
    if ring <= 0.0 {
        return vec![[0.0, 0.0]];
    }
    unfold(&section.equal_steps(steps(section.length_m() * ring, spacing_m)))
}

/// A set of points no two of which are closer than a distance.
struct Spread {
    closest_m: f64,
    /// Looked up, never iterated, so the order of the hash does not matter.
    cells: HashMap<[i32; 3], Vec<Point3<f64>>>,
}

impl Spread {
    fn new(closest_m: f64) -> Self {
        Self { closest_m, cells: HashMap::new() }
    }

    /// Adds the point unless one that is already here is too close; says whether it was added.
    fn add(&mut self, p: &Point3<f64>) -> bool {
        let cell = [0, 1, 2].map(|i| (p[i] / self.closest_m).floor() as i32);
        for dx in -1..=1 {
            for dy in -1..=1 {
                for dz in -1..=1 {
                    let neighbour = [cell[0] + dx, cell[1] + dy, cell[2] + dz];
                    let near = |q: &Point3<f64>| (q - p).norm_squared() < self.closest_m * self.closest_m;
                    if self.cells.get(&neighbour).is_some_and(|points| points.iter().any(near)) {
                        return false;
                    }
                }
            }
        }
        self.cells.entry(cell).or_default().push(*p);
        true
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use nalgebra::{Isometry3, Translation3};

    use super::super::bend_limit_per_m;
    use super::*;
    use crate::rng::Rng;

    fn shapes() -> Vec<Superquadric> {
        let mut rng = Rng::new(21, 0);
        let mut shapes: Vec<Superquadric> = (0..20)
            .map(|_| {
                let X_FS = Isometry3::from_parts(Translation3::from(rng.direction()), rng.rotation());
                let axes = [0.0; 3].map(|_: f64| rng.uniform(0.025, 0.2));
                let (e1, e2) = (rng.uniform(0.1, 1.9), rng.uniform(0.1, 1.9));
                Superquadric::new(axes[0], axes[1], axes[2], e1, e2, X_FS).unwrap()
            })
            .collect();
        for (e1, e2) in [(0.1, 0.1), (0.1, 1.0), (1.0, 1.0), (1.9, 1.9), (0.1, 1.9)] {
            shapes.push(Superquadric::new(0.03, 0.06, 0.12, e1, e2, Isometry3::identity()).unwrap());
        }
        shapes
    }

    fn deformed_shapes() -> Vec<Superquadric> {
        let mut rng = Rng::new(23, 0);
        let deform = |plain: Superquadric, taper: f64| {
            let most = bend_limit_per_m(plain.b, plain.c, taper);
            plain.deformed(taper, 0.9 * most * rng.uniform(-1.0, 1.0)).unwrap()
        };
        shapes()
            .into_iter()
            .zip([0.0, 0.4, -0.7, 0.9].into_iter().cycle())
            .map({
                let mut deform = deform;
                move |(plain, taper)| deform(plain, taper)
            })
            .collect()
    }

    #[test]
    fn samples_lie_on_the_surface_with_outward_unit_normals() {
        for s in shapes().into_iter().chain(deformed_shapes()) {
            for q in s.samples(30) {
                assert!(s.ln_inside_outside(&s.to_axes(&q.p_F)).abs() < 1e-8, "{s:?}");
                assert!((q.n_F.norm() - 1.0).abs() < 1e-12);
                assert!(!s.contains(&(q.p_F + q.n_F * 1e-7)));
            }
        }
    }

    /// Distance of every sample from the one nearest to it, metres, in ascending order.
    fn distances_to_nearest(samples: &[SurfaceSample]) -> Vec<f64> {
        let mut nearest: Vec<f64> = samples
            .iter()
            .enumerate()
            .map(|(i, p)| {
                let others = samples.iter().enumerate().filter(|(j, _)| *j != i);
                others.map(|(_, q)| (p.p_F - q.p_F).norm()).min_by(f64::total_cmp).unwrap()
            })
            .collect();
        nearest.sort_by(f64::total_cmp);
        nearest
    }

    #[test]
    fn samples_of_deformed_shapes_are_as_evenly_spread() {
        for s in deformed_shapes() {
            let spacing_m = 0.008;
            let samples = s.samples_spaced(spacing_m);
            let nearest = distances_to_nearest(&samples);
            let quantile = |share: f64| nearest[(share * (nearest.len() - 1) as f64) as usize] / spacing_m;
            assert!(quantile(0.0) >= CLOSEST_THROWN - 1e-9, "{} {s:?}", quantile(0.0));
            assert!(quantile(0.99) <= 1.15, "{} {s:?}", quantile(0.99));
            // One sample per spacing squared of the surface, which a mesh of 3 mm measures.
            let mesh = s.mesh(24);
            let area: f64 = mesh
                .triangles
                .iter()
                .map(|t| {
                    let [p, q, r] = t.map(|i| mesh.positions[i as usize]);
                    0.5 * (q - p).cross(&(r - p)).norm()
                })
                .sum();
            let share = samples.len() as f64 * spacing_m * spacing_m / area;
            assert!((share - 1.0).abs() < 0.1, "{share} {} {s:?}", samples.len());
        }
    }

    #[test]
    fn nearest_neighbours_are_all_about_equally_far() {
        for s in shapes() {
            let spacing_m = 0.008;
            let samples = s.samples_spaced(spacing_m);
            let nearest = distances_to_nearest(&samples);
            let quantile = |share: f64| nearest[(share * (nearest.len() - 1) as f64) as usize] / spacing_m;
            assert!(quantile(0.0) >= CLOSEST - 1e-9, "{} {s:?}", quantile(0.0));
            assert!(quantile(0.99) <= 1.35, "{} {s:?}", quantile(0.99));
        }
    }

    #[test]
    fn no_part_of_the_surface_is_left_bare() {
        let mut rng = Rng::new(22, 0);
        for s in shapes().into_iter().chain(deformed_shapes()) {
            let samples = s.samples_spaced(0.01);
            for _ in 0..200 {
                let p = s.point(rng.uniform(-FRAC_PI_2, FRAC_PI_2), rng.uniform(-PI, PI));
                let nearest = samples.iter().map(|q| (q.p_F - p).norm()).min_by(f64::total_cmp).unwrap();
                // The middle of a square cell of 1.3 spacings is 0.92 of them away.
                assert!(nearest < 0.01, "{nearest} {s:?}");
            }
        }
    }

    #[test]
    fn density_is_points_around_a_sphere() {
        let s = Superquadric::new(0.05, 0.05, 0.05, 1.0, 1.0, Isometry3::identity()).unwrap();
        let samples = s.samples(40);
        let equator = samples.iter().filter(|q| q.p_F.z.abs() < 1e-9).count();
        assert_eq!(equator, 40);
        // 4π r² over spacing² is N²/π = 509; rings lose or gain a little to rounding.
        assert!((450..570).contains(&samples.len()), "{}", samples.len());
        assert_eq!(samples, s.samples(40));
        assert!(s.samples_spaced(f64::NAN).len() < 100 && !s.samples(0).is_empty());
    }
}
