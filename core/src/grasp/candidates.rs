//! Candidate grasps from uniform surface samples (thesis 4.2).

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::{Contact, Grasp, GraspStatus, HandModel, close, quality};
use crate::parallel;
use crate::superquadric::{DistanceField, Superquadric, SurfaceSample};

/// Settings of the grasp synthesis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct GraspSettings {
    /// Density N of the surface samples from which candidates start (about N²/π of them); each gives up to four.
    pub density: u32,
    /// Gap left between the palm and the object in a power grasp, metres.
    pub palm_gap_m: f64,
    /// How far the TCP dips below the surface in a fingertip grasp, metres.
    pub fingertip_depth_m: f64,
    /// A grasp needs at least this many contacts (3 in the thesis).
    pub min_contacts: usize,
}

impl Default for GraspSettings {
    fn default() -> Self {
        Self { density: 14, palm_gap_m: 0.008, fingertip_depth_m: 0.010, min_contacts: 3 }
    }
}

/// What the hand alone meets in the scene: link, and what it meets (`table` or a neighbour's name).
pub struct HandHit {
    /// Link of the hand.
    pub link: String,
    /// The other thing's name.
    pub other: String,
}

/// Says what the hand alone meets at a pose `X_OH` with these finger positions.
pub type HandHits<'a> = dyn Fn(&Isometry3<f64>, &[f64]) -> Option<HandHit> + Sync + 'a;

/// Density of the samples from which widths are read: about 900 over the object.
const WIDTH_DENSITY: u32 = 53;
/// Half thickness of the slice in which the width across the fingers is read, metres: half a three-finger hand.
const SLICE_HALF_M: f64 = 0.045;
/// An open hand may dip this far into the fitted surface, metres: below what a fit can be trusted.
const OPEN_DIP_M: f64 = 0.001;

/// All candidates for an object whose frame O is its superquadric's axes, in order of generation.
///
/// Around each surface sample the approach z_H is against the normal and x_H along the object's smallest principal
/// axis that is not parallel to it, in both senses; the palm close to the surface (power grasp) or the fingertips at
/// it. The hand is then moved along x_H until the object is centred between the fingers, and closed. `hand_hit` says
/// what the hand would meet besides the object, with the given finger positions, at the object's start pose.
pub fn candidates(
    hand: &HandModel,
    object: &Superquadric,
    settings: &GraspSettings,
    hand_hit: &HandHits<'_>,
) -> Vec<Grasp> {
    let object = &Superquadric { X_FS: Isometry3::identity(), ..*object };
    let dense = object.samples(WIDTH_DENSITY);
    let shape = Shape {
        object,
        surface: object.distance_field(),
        dense: &dense,
        reach_m: reach_m(hand),
        opening_m: hand.opening_m(),
        palm_depth_m: hand.palm_depth_m(),
    };
    let poses: Vec<Isometry3<f64>> =
        object.samples(settings.density).iter().flat_map(|sample| poses_at(sample, &shape, settings)).collect();
    let numbered: Vec<(u32, Isometry3<f64>)> = (0..).zip(poses).collect();
    parallel::map(&numbered, |(id, X_OH)| judge(*id, X_OH, hand, &shape, settings, hand_hit))
}

struct Shape<'a> {
    object: &'a Superquadric,
    surface: DistanceField,
    dense: &'a [SurfaceSample],
    opening_m: f64,
    palm_depth_m: f64,
    reach_m: f64,
}

/// Up to four hand poses at a sample: two senses of x_H, two depths.
fn poses_at(sample: &SurfaceSample, shape: &Shape<'_>, settings: &GraspSettings) -> Vec<Isometry3<f64>> {
    let z_H = -sample.n_F;
    let object = shape.object;
    let mut axes = [(object.a, Vector3::x()), (object.b, Vector3::y()), (object.c, Vector3::z())];
    axes.sort_by(|l, r| l.0.total_cmp(&r.0));
    let Some(x_H) = axes.iter().map(|(_, axis)| axis - z_H * z_H.dot(axis)).find(|x| x.norm() > 0.3) else {
        return Vec::new();
    };
    let Some(x_H) = x_H.try_normalize(1e-9) else { return Vec::new() };
    let power = settings.palm_gap_m - shape.palm_depth_m;
    let fingertip = -settings.fingertip_depth_m;
    let mut poses = Vec::with_capacity(4);
    for offset in [power, fingertip] {
        for sense in [1.0, -1.0] {
            let x = x_H * sense;
            let R = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z_H.cross(&x), z_H]));
            let p = sample.p_F + sample.n_F * offset;
            poses.push(Isometry3::from_parts(Translation3::from(p), UnitQuaternion::from_rotation_matrix(&R)));
        }
    }
    poses
}

fn judge(
    id: u32,
    X_OH: &Isometry3<f64>,
    hand: &HandModel,
    shape: &Shape<'_>,
    settings: &GraspSettings,
    hand_hit: &HandHits<'_>,
) -> Grasp {
    let (X_OH, width_m) = centred(X_OH, shape);
    let mut grasp = Grasp {
        id,
        X_OH,
        closed: hand.open.clone(),
        contacts: Vec::new(),
        width_m,
        epsilon: 0.0,
        start: None,
        goal: None,
        status: GraspStatus::Accepted,
    };
    if width_m > shape.opening_m {
        grasp.status = GraspStatus::TooWide { width_m, opening_m: shape.opening_m };
        return grasp;
    }
    let (link, depth_m) = close::deepest(hand, &hand.link_poses(&hand.open), &X_OH, &shape.surface, |_| true);
    if depth_m > OPEN_DIP_M {
        grasp.status = GraspStatus::HandInObject { link: hand.links[link].name.clone(), depth_m };
        return grasp;
    }
    if let Some(hit) = hand_hit(&X_OH, &hand.open) {
        grasp.status = status_of(hit);
        return grasp;
    }
    grasp.closed = close::close(hand, &X_OH, &shape.surface);
    grasp.contacts = close::contacts(hand, &grasp.closed, &X_OH, &shape.surface);
    if let Some(width_m) = contact_width(&grasp.contacts, &X_OH) {
        grasp.width_m = width_m;
    }
    if grasp.contacts.len() < settings.min_contacts {
        grasp.status = GraspStatus::TooFewContacts { found: grasp.contacts.len(), wanted: settings.min_contacts };
        return grasp;
    }
    if !opposed(&grasp.contacts, &X_OH) {
        grasp.status = GraspStatus::OneSided { link: grasp.contacts[0].link.clone() };
        return grasp;
    }
    if let Some(hit) = hand_hit(&X_OH, &grasp.closed) {
        grasp.status = status_of(hit);
        return grasp;
    }
    let size_m = shape.object.a.max(shape.object.b).max(shape.object.c);
    grasp.epsilon = quality::epsilon(&grasp.contacts, &Point3::origin(), size_m);
    grasp
}

fn status_of(hit: HandHit) -> GraspStatus {
    if hit.other == "table" {
        GraspStatus::HitsTable { link: hit.link }
    } else {
        GraspStatus::HitsNeighbour { link: hit.link, neighbour: hit.other }
    }
}

/// How far the open fingers reach beyond the TCP, metres.
fn reach_m(hand: &HandModel) -> f64 {
    let X_HL = hand.link_poses(&hand.open);
    let ends = X_HL.iter().zip(&hand.links).flat_map(|(X, link)| link.spheres.iter().map(move |(c, r)| (X * c).z + r));
    ends.fold(f64::NEG_INFINITY, f64::max)
}

/// The hand moved along x_H until the object is centred between the fingers, and the object's width there.
fn centred(X_OH: &Isometry3<f64>, shape: &Shape<'_>) -> (Isometry3<f64>, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for sample in shape.dense {
        let p_H = X_OH.inverse_transform_point(&sample.p_F);
        if p_H.y.abs() < SLICE_HALF_M && p_H.z > -shape.palm_depth_m && p_H.z < shape.reach_m {
            low = low.min(p_H.x);
            high = high.max(p_H.x);
        }
    }
    if low > high {
        return (*X_OH, 0.0);
    }
    (X_OH * Translation3::new(0.5 * (low + high), 0.0, 0.0), high - low)
}

/// Whether some contact pushes along +x_H and another along -x_H.
fn opposed(contacts: &[Contact], X_OH: &Isometry3<f64>) -> bool {
    let x_O = X_OH.rotation * Vector3::x();
    let pushes = |sense: f64| contacts.iter().any(|c| sense * x_O.dot(&c.n_O) > 0.3);
    pushes(1.0) && pushes(-1.0)
}

/// Distance between the outermost contacts along x_H, metres.
fn contact_width(contacts: &[Contact], X_OH: &Isometry3<f64>) -> Option<f64> {
    let along = contacts.iter().map(|c| X_OH.inverse_transform_point(&c.p_O).x);
    let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
    (low <= high).then_some(high - low)
}
