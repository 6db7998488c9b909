//! The synthetic trials of the thesis (3.3.1, Table 3.1): random superquadrics and the four clouds made of each.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::math;
use crate::mesh::Mesh;
use crate::rng::Rng;
use crate::superquadric::{Superquadric, SuperquadricError};

/// Semi-axes of Table 3.1, metres.
const AXES_M: [f64; 2] = [0.025, 0.4];
/// Largest |t_x| and |t_y| of Table 3.1, metres.
const SIDEWAYS_M: f64 = 0.8;
/// t_z of Table 3.1, metres.
const AHEAD_M: [f64; 2] = [0.35, 1.4];
/// Exponents of Table 3.1.
const EXPONENTS: [f64; 2] = [0.1, 1.9];
/// Noise of Table 3.3 on each coordinate, metres.
pub const NOISE_M: f64 = 0.0025;
/// Points of a thesis cloud, about: its sampler with N = 50 gave 9 800 to 11 200.
pub const THESIS_POINTS: usize = 10_000;
/// A cloud whose count is farther off than this share is drawn again with a better spacing.
const COUNT_TOLERANCE: f64 = 0.05;
/// Fineness of the mesh that areas and random points are taken from: 192 columns, 96 rows.
const MESH_HALF: u32 = 24;

/// What is seen of a shape, and how well (3.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visibility {
    /// The whole surface, exactly.
    Full,
    /// The whole surface with noise.
    FullNoisy,
    /// The half that faces the origin, exactly.
    Partial,
    /// The half that faces the origin, with noise.
    PartialNoisy,
}

impl Visibility {
    /// All four, in the order of Table 3.3.
    pub const ALL: [Self; 4] = [Self::Full, Self::FullNoisy, Self::Partial, Self::PartialNoisy];

    /// The name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::FullNoisy => "full noisy",
            Self::Partial => "partial",
            Self::PartialNoisy => "partial noisy",
        }
    }

    fn is_noisy(self) -> bool {
        matches!(self, Self::FullNoisy | Self::PartialNoisy)
    }

    fn is_partial(self) -> bool {
        matches!(self, Self::Partial | Self::PartialNoisy)
    }
}

/// A superquadric with all eleven parameters uniform in the ranges of Table 3.1 as printed.
///
/// The rotation is `Rz(α) Ry(β) Rx(γ)` of three uniform angles, as in the thesis, not a uniform rotation.
///
/// # Errors
/// None in practice: every draw is within the limits of [`Superquadric::new`].
pub fn draw_shape(rng: &mut Rng) -> Result<Superquadric, SuperquadricError> {
    let [a, b, c] = [0.0; 3].map(|_: f64| rng.uniform(AXES_M[0], AXES_M[1]));
    let [e1, e2] = [0.0; 2].map(|_: f64| rng.uniform(EXPONENTS[0], EXPONENTS[1]));
    let [x, y] = [0.0; 2].map(|_: f64| rng.uniform(-SIDEWAYS_M, SIDEWAYS_M));
    let z = rng.uniform(AHEAD_M[0], AHEAD_M[1]);
    let [gamma, beta, alpha] = [0.0; 3].map(|_: f64| rng.uniform(-std::f64::consts::PI, std::f64::consts::PI));
    Superquadric::new(a, b, c, e1, e2, posed([x, y, z], gamma, beta, alpha))
}

/// The pose with translation t, metres, and rotation `Rz(α) Ry(β) Rx(γ)`, radians.
pub(super) fn posed(t: [f64; 3], gamma: f64, beta: f64, alpha: f64) -> Isometry3<f64> {
    let about = |axis: Vector3<f64>, angle: f64| {
        let (sin, cos) = math::sin_cos(0.5 * angle);
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::from_parts(cos, axis * sin))
    };
    let R = about(Vector3::z(), alpha) * about(Vector3::y(), beta) * about(Vector3::x(), gamma);
    Isometry3::from_parts(Translation3::new(t[0], t[1], t[2]), R)
}

/// The clouds of one trial: one noise and one cut, so that the four conditions differ in nothing else.
#[derive(Clone, Debug)]
pub struct Clouds {
    /// The whole surface without noise; all errors are evaluated on it.
    pub full: Vec<Point3<f64>>,
    noise: Vec<Vector3<f64>>,
    is_facing: Vec<bool>,
}

impl Clouds {
    /// Noise of [`NOISE_M`] on every coordinate of every point, and the cut: the plane through the centroid,
    /// perpendicular to the line from the origin to it; the points on the origin's side face it.
    pub fn new(full: Vec<Point3<f64>>, rng: &mut Rng) -> Self {
        let noise = full.iter().map(|_| Vector3::from([0.0; 3].map(|_: f64| NOISE_M * rng.normal()))).collect();
        let centroid = full.iter().map(|p| p.coords).sum::<Vector3<f64>>() / full.len().max(1) as f64;
        let is_facing = full.iter().map(|p| (p.coords - centroid).dot(&centroid) <= 0.0).collect();
        Self { full, noise, is_facing }
    }

    /// The cloud under a condition.
    pub fn seen(&self, visibility: Visibility) -> Vec<Point3<f64>> {
        let all = self.full.iter().zip(&self.noise).zip(&self.is_facing);
        all.filter(|(_, is_facing)| **is_facing || !visibility.is_partial())
            .map(|((p, noise), _)| if visibility.is_noisy() { p + noise } else { *p })
            .collect()
    }
}

/// About `count` points, evenly spread over the surface: the spacing is found from the area.
pub fn even_cloud(shape: &Superquadric, count: usize) -> Vec<Point3<f64>> {
    let wanted = count.max(1) as f64;
    let spacing_m = (area_m2(&shape.mesh(MESH_HALF)) / wanted).sqrt();
    let mut samples = shape.samples_spaced(spacing_m);
    // Rings meet closer than the spacing near poles and on short sides, so the first count is a little off.
    let share = samples.len() as f64 / wanted;
    if (share - 1.0).abs() > COUNT_TOLERANCE {
        samples = shape.samples_spaced(spacing_m * share.sqrt());
    }
    samples.into_iter().map(|q| q.p_F).collect()
}

/// Points drawn at random from the surface, uniform by area: one per square of `spacing_m`, between the two `counts`.
///
/// * `spacing_m`: side of the square, metres.
pub fn random_cloud(shape: &Superquadric, spacing_m: f64, counts: [usize; 2], rng: &mut Rng) -> Vec<Point3<f64>> {
    let mesh = shape.mesh(MESH_HALF);
    let count = (area_m2(&mesh) / (spacing_m * spacing_m)) as usize;
    let points = random_points(&mesh, count.max(counts[0]).min(counts[1]), rng);
    if shape.is_deformed() {
        return points;
    }
    // The chords of the mesh lie up to a thousandth of a semi-axis inside; along the ray they meet the surface.
    let on_surface = |p_S: Point3<f64>| Point3::from(p_S.coords * math::exp(-ln_gauge(shape, &p_S)));
    points.iter().map(|p| shape.X_FS * on_surface(shape.to_axes(p))).collect()
}

/// `ln ρ` at a point of the axes S, 0 on the surface: how far out the point is, as a factor of the radius.
pub(super) fn ln_gauge(shape: &Superquadric, p_S: &Point3<f64>) -> f64 {
    0.5 * shape.e1 * shape.ln_inside_outside(p_S)
}

/// Points drawn from a mesh, uniform by area.
pub(super) fn random_points(mesh: &Mesh, count: usize, rng: &mut Rng) -> Vec<Point3<f64>> {
    let mut sum = 0.0;
    let up_to: Vec<f64> = mesh
        .triangles
        .iter()
        .map(|triangle| {
            sum += triangle_area_m2(mesh, triangle);
            sum
        })
        .collect();
    let last = mesh.triangles.len().saturating_sub(1);
    (0..count)
        .filter_map(|_| {
            let wanted = rng.uniform(0.0, sum);
            let triangle = mesh.triangles.get(up_to.partition_point(|area| *area <= wanted).min(last))?;
            let [p, q, r] = triangle.map(|index| mesh.positions[index as usize]);
            // The upper half of the parallelogram is folded onto the triangle.
            let (u, v) = (rng.unit(), rng.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            Some(p + (q - p) * u + (r - p) * v)
        })
        .collect()
}

fn triangle_area_m2(mesh: &Mesh, triangle: &[u32; 3]) -> f64 {
    let [p, q, r] = triangle.map(|index| mesh.positions[index as usize]);
    0.5 * (q - p).cross(&(r - p)).norm()
}

fn area_m2(mesh: &Mesh) -> f64 {
    mesh.triangles.iter().map(|triangle| triangle_area_m2(mesh, triangle)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes(count: u64) -> Vec<Superquadric> {
        (0..count).map(|k| draw_shape(&mut Rng::new(31, k)).unwrap()).collect()
    }

    #[test]
    fn draws_stay_in_table_3_1_and_fill_it() {
        let shapes = shapes(2000);
        let fills = |of: fn(&Superquadric) -> f64, [least, most]: [f64; 2]| {
            let values: Vec<f64> = shapes.iter().map(of).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
            let width = most - least;
            // Of 2000 uniform values the mean is within 4 σ = 0.026 widths, the extremes within 0.5 % of the ends.
            assert!(low >= least && high <= most && low < least + 0.005 * width && high > most - 0.005 * width);
            assert!((mean - 0.5 * (least + most)).abs() < 0.026 * width, "{mean}");
        };
        fills(|s| s.a, [0.025, 0.4]);
        fills(|s| s.c, [0.025, 0.4]);
        fills(|s| s.e1, [0.1, 1.9]);
        fills(|s| s.e2, [0.1, 1.9]);
        fills(|s| s.X_FS.translation.x, [-0.8, 0.8]);
        fills(|s| s.X_FS.translation.z, [0.35, 1.4]);
    }

    #[test]
    fn angles_turn_about_x_then_y_then_z() {
        let X = posed([0.0; 3], 0.3, -0.5, 1.1);
        let R = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), 1.1)
            * nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), -0.5)
            * nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), 0.3);
        assert!((X.rotation.to_rotation_matrix().matrix() - R.matrix()).norm() < 1e-14);
    }

    #[test]
    fn an_even_cloud_has_about_the_points_that_are_asked_for() {
        for shape in shapes(25) {
            let count = even_cloud(&shape, THESIS_POINTS).len();
            assert!((9_000..=11_200).contains(&count), "{count} {shape:?}");
        }
    }

    #[test]
    fn a_random_cloud_lies_on_the_surface_and_is_as_dense_as_asked() {
        let sphere = Superquadric::new(0.2, 0.2, 0.2, 1.0, 1.0, Isometry3::translation(0.0, 0.5, 1.0)).unwrap();
        let points = random_cloud(&sphere, 0.004, [100, 50_000], &mut Rng::new(3, 0));
        // 4π r² over 16 mm² is 31 416; chords of the mesh lose less than 0.1 %.
        assert!((31_300..=31_416).contains(&points.len()), "{}", points.len());
        assert!(points.iter().all(|p| ln_gauge(&sphere, &sphere.to_axes(p)).abs() < 1e-12));
        // By area, the height on a sphere is uniform: a quarter of the points lies above half the radius, σ = 0.0024.
        let high = points.iter().filter(|p| p.z > 1.1).count() as f64 / points.len() as f64;
        assert!((high - 0.25).abs() < 0.01, "{high}");
        assert_eq!(random_cloud(&sphere, 0.004, [100, 5000], &mut Rng::new(3, 0)).len(), 5000);
    }

    #[test]
    fn the_four_clouds_have_the_stated_cut_and_noise() {
        for (k, shape) in shapes(10).iter().enumerate() {
            let clouds = Clouds::new(even_cloud(shape, 4000), &mut Rng::new(32, k as u64));
            let [full, noisy, partial, partial_noisy] = Visibility::ALL.map(|v| clouds.seen(v));
            assert_eq!(full, clouds.full);
            assert_eq!((noisy.len(), partial_noisy.len()), (full.len(), partial.len()));
            // The shapes are symmetric about their centre, where the plane passes.
            let share = partial.len() as f64 / full.len() as f64;
            assert!((share - 0.5).abs() < 0.03, "{share}");
            let center = shape.X_FS.translation.vector;
            // Evenly spread samples have their centroid within a fraction of their spacing of the centre.
            assert!(partial.iter().all(|p| (p.coords - center).dot(&center) < 0.004 * center.norm()));
            for (clean, noisy) in [(&full, &noisy), (&partial, &partial_noisy)] {
                for axis in 0..3 {
                    let squares: f64 = clean.iter().zip(noisy).map(|(p, q)| (q[axis] - p[axis]).powi(2)).sum();
                    let deviation_m = (squares / clean.len() as f64).sqrt();
                    // Standard error of a deviation is σ/√(2n) = 0.04 mm for 2000 points: four of them.
                    assert!((deviation_m - NOISE_M).abs() < 0.00016, "{deviation_m}");
                }
            }
        }
    }
}
