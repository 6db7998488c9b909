//! Views of real and described objects with the truth behind them.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::protocol::random_points;
use crate::cloud::{RgbdCamera, SeenBody};
use crate::math;
use crate::mesh::Mesh;
use crate::object::{HouseholdObject, box_mesh};
use crate::parallel;
use crate::rng::Rng;
use crate::segment::{Plane, SegmentSettings};

/// How far the camera is from the middle of the object, metres.
const DISTANCE_M: f64 = 0.8;
/// How far down the camera looks, degrees.
const PITCH_DEG: [f64; 2] = [35.0, 45.0];
/// The table of a rendered view, metres.
const TABLE_M: [f64; 3] = [1.6, 1.6, 0.02];
/// Points of the whole surface.
const SURFACE_POINTS: usize = 4000;
/// A body is convex when no vertex is farther than this share of its size outside the plane of any triangle.
const CONVEX_SHARE: f64 = 0.02;

/// One view of one object.
#[derive(Clone, Debug)]
pub struct ObjectView {
    /// Its name.
    pub name: String,
    /// What the camera saw of it, in F, metres.
    pub points: Vec<Point3<f64>>,
    /// Pose of the camera's optical frame in F.
    pub X_FC: Option<Isometry3<f64>>,
    /// The table, in F.
    pub table: Option<Plane>,
    /// Pose of the object's own frame O in F.
    pub X_FO: Isometry3<f64>,
    /// Extents along the axes of O, metres.
    pub extents_m: Vector3<f64>,
    /// Volume, cubic metres; `None` when it is not known.
    pub volume_m3: Option<f64>,
    /// Whether it is a vessel, whose volume is that of its wall.
    pub is_hollow: bool,
    /// Whether it has neither dents nor handles to speak of.
    pub is_convex: bool,
    /// Points of its whole surface, in F.
    pub surface: Vec<Point3<f64>>,
}

/// Views of described objects: each stands alone on a table, turned at random, and is seen by the robot's camera.
///
/// * `count`: views per object; the camera is 0.8 m away and looks 35° to 45° down.
///
/// As after segmentation, the lowest centimetre is missing.
pub fn household_views(objects: &[HouseholdObject], count: usize, seed: u64) -> Vec<ObjectView> {
    let all: Vec<(usize, usize)> = (0..objects.len()).flat_map(|k| (0..count).map(move |view| (k, view))).collect();
    parallel::map(&all, |&(k, view)| {
        let stream = (k * count + view) as u64;
        household_view(&objects[k], &mut Rng::new(seed, stream), seed.wrapping_add(stream))
    })
}

fn household_view(object: &HouseholdObject, rng: &mut Rng, noise_seed: u64) -> ObjectView {
    let mesh = object.mesh();
    let half = object.half_extents();
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rng.uniform(0.0, std::f64::consts::TAU));
    let X_WO = Isometry3::from_parts(Translation3::new(0.0, 0.0, half.z), yaw);
    let (sin, cos) = math::sin_cos(rng.uniform(PITCH_DEG[0], PITCH_DEG[1]).to_radians());
    let middle = Point3::new(0.0, 0.0, half.z);
    let eye = middle + DISTANCE_M * Vector3::new(-cos, 0.0, sin);
    let X_WC = Isometry3::face_towards(&eye, &middle, &-Vector3::z());
    let table = box_mesh(&Vector3::from(TABLE_M));
    let bodies = [
        SeenBody { mesh: &table, X_WM: Isometry3::translation(0.0, 0.0, -0.5 * TABLE_M[2]), color: [200; 3] },
        SeenBody { mesh: &mesh, X_WM: X_WO, color: object.color },
    ];
    let seen = RgbdCamera::default().render(&bodies, &X_WC, noise_seed);
    let lowest_m = SegmentSettings::default().min_height_m;
    let is_object = |(p, body): &(&Point3<f64>, &u16)| **body == 1 && p.z > lowest_m;
    let surface = random_points(&mesh, SURFACE_POINTS, rng);
    ObjectView {
        name: object.name.clone(),
        points: seen.cloud.points.iter().zip(&seen.bodies).filter(is_object).map(|(p, _)| *p).collect(),
        X_FC: Some(X_WC),
        table: Some(Plane { normal: Vector3::z_axis(), offset_m: 0.0 }),
        X_FO: X_WO,
        extents_m: 2.0 * half,
        volume_m3: Some(enclosed_m3(&mesh)),
        is_hollow: false,
        is_convex: is_convex(&mesh),
        surface: surface.iter().map(|p| X_WO * p).collect(),
    }
}

/// Volume inside a closed mesh, cubic metres.
fn enclosed_m3(mesh: &Mesh) -> f64 {
    let corner = |index: u32| mesh.positions[index as usize].coords;
    mesh.triangles.iter().map(|t| corner(t[0]).dot(&corner(t[1]).cross(&corner(t[2]))) / 6.0).sum()
}

/// Whether every vertex is behind every face.
fn is_convex(mesh: &Mesh) -> bool {
    let size_m = mesh.positions.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    mesh.triangles.iter().all(|triangle| {
        let [p, q, r] = triangle.map(|index| mesh.positions[index as usize]);
        let Some(normal) = (q - p).cross(&(r - p)).try_normalize(1e-12) else { return true };
        mesh.positions.iter().all(|other| normal.dot(&(other - p)) <= CONVEX_SHARE * size_m)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAN: &str = r#"{"name": "can", "title": "Can", "source": "test", "mass_kg": 0.3, "color": [200, 0, 0],
        "parts": [{"kind": "loft", "e2": 1.0, "sections": [[-0.05, 0.03, 0.03], [0.05, 0.03, 0.03]]}]}"#;
    const WAIST: &str = r#"{"name": "waist", "title": "Waist", "source": "test", "mass_kg": 0.3, "color": [200, 0, 0],
        "parts": [{"kind": "loft", "e2": 1.0, "sections": [[-0.05, 0.03, 0.03], [0, 0.02, 0.02], [0.05, 0.03, 0.03]]}]}"#;

    #[test]
    fn a_can_is_seen_from_the_front_above_the_table() {
        let can = HouseholdObject::parse(CAN).unwrap();
        let waist = HouseholdObject::parse(WAIST).unwrap();
        let views = household_views(&[can, waist], 2, 5);
        assert_eq!(views.len(), 4);
        assert!(views[0].is_convex && !views[2].is_convex);
        let volume_m3 = views[0].volume_m3.unwrap();
        // A polygon of 64 corners has 0.16 % less area than its circle.
        assert!((volume_m3 / (std::f64::consts::PI * 9e-5) - 1.0).abs() < 0.002, "{volume_m3}");
        for view in &views {
            let camera = view.X_FC.unwrap();
            assert!((camera.translation.vector - Vector3::new(0.0, 0.0, 0.05)).norm() - 0.8 < 1e-12);
            assert!(view.points.len() > 2000, "{}", view.points.len());
            // Noise of 1 mm and steps of 2 mm: everything seen is near the surface and above the lowest centimetre.
            let reach = view.points.iter().map(|p| p.xy().coords.norm()).fold(0.0, f64::max);
            assert!(reach < 0.045 && view.points.iter().all(|p| p.z > 0.01 && p.z < 0.12), "{reach}");
        }
        assert_ne!(views[0].points, views[1].points);
        let again = household_views(&[HouseholdObject::parse(CAN).unwrap()], 2, 5);
        assert_eq!(views[1].points, again[1].points);
    }
}
