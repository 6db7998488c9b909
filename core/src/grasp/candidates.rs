//! Candidate grasps from uniform surface samples (thesis 4.2).

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::bodies::{Bodies, Touched};
use super::{Contact, Grasp, GraspSettings, GraspStatus, HandModel, Unwanted, close, quality};
use crate::math;
use crate::parallel;
use crate::superquadric::{Superquadric, SurfaceSample};

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

/// All candidates for an object, in order of generation: body by body, each from its surface samples.
///
/// `bodies_O` are the object's superquadrics in its frame O, which is the first one's axes, and fingers close on
/// `touched`. Around each sample that no other body covers, the approach z_H is against the normal and x_H along the
/// body's smallest principal axis that is not parallel to it, turned by the rolls that are asked for, at depths from the
/// palm at the surface (power grasp) to the fingertips at it. The hand is then moved along x_H until the body, or else
/// the whole object, is centred between the fingers, and closed on whatever it meets first. `hand_hit` says what the
/// hand would meet besides the object, with the given finger positions, at the object's start pose `X_WO`, where the
/// filters look at it too.
pub fn candidates(
    hand: &HandModel,
    bodies_O: &[Superquadric],
    touched: Touched,
    settings: &GraspSettings,
    X_WO: &Isometry3<f64>,
    hand_hit: &HandHits<'_>,
) -> Vec<Grasp> {
    let bodies = Bodies::new(bodies_O, touched);
    let dense = (0..bodies.len()).map(|part| bodies.samples(part, WIDTH_DENSITY)).collect();
    let shape =
        Shape { bodies, dense, reach_m: reach_m(hand), opening_m: hand.opening_m(), palm_depth_m: hand.palm_depth_m() };
    let at_part = |part: usize| {
        let samples = shape.bodies.samples(part, settings.density);
        let poses = samples.iter().flat_map(|sample| poses_at(part, sample, &shape, settings)).collect::<Vec<_>>();
        poses.into_iter().map(move |X_OH| (part, X_OH))
    };
    let numbered: Vec<(u32, (usize, Isometry3<f64>))> = (0..).zip((0..shape.bodies.len()).flat_map(at_part)).collect();
    let judge = Judge { hand, shape: &shape, settings, X_WO, hand_hit };
    parallel::map(&numbered, |(id, (part, X_OH))| judge.grasp(*id, *part, X_OH))
}

struct Shape {
    bodies: Bodies,
    /// For each body, many samples of its free surface.
    dense: Vec<Vec<SurfaceSample>>,
    opening_m: f64,
    palm_depth_m: f64,
    reach_m: f64,
}

/// The hand poses at a sample: every depth with every roll in both senses of x_H.
fn poses_at(part: usize, sample: &SurfaceSample, shape: &Shape, settings: &GraspSettings) -> Vec<Isometry3<f64>> {
    let z_H = -sample.n_F;
    let axes = shape.bodies.axes_at(part, &sample.p_F);
    let Some(x_H) = axes.iter().map(|(_, axis)| axis - z_H * z_H.dot(axis)).find(|x| x.norm() > 0.3) else {
        return Vec::new();
    };
    let Some(x_H) = x_H.try_normalize(1e-9) else { return Vec::new() };
    let power = settings.palm_gap_m - shape.palm_depth_m;
    let fingertip = (shape.reach_m - settings.fingertip_depth_m).max(power);
    let rolls = settings.rolls.max(1);
    let depths = settings.depths.max(1);
    let mut poses = Vec::with_capacity(2 * (rolls * depths) as usize);
    for depth in 0..depths {
        let share = if depths > 1 { f64::from(depth) / f64::from(depths - 1) } else { 0.0 };
        let offset = power + share * (fingertip - power);
        for roll in 0..2 * rolls {
            // Every roll is followed by its opposite: half a turn swaps the fingers.
            let half_turn = if roll % 2 == 0 { 1.0 } else { -1.0 };
            let (sin, cos) = math::sin_cos(std::f64::consts::PI * f64::from(roll / 2) / f64::from(rolls));
            let x = (x_H * cos + z_H.cross(&x_H) * sin) * half_turn;
            let R = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z_H.cross(&x), z_H]));
            let p = sample.p_F + sample.n_F * offset;
            poses.push(Isometry3::from_parts(Translation3::from(p), UnitQuaternion::from_rotation_matrix(&R)));
        }
    }
    poses
}

/// What every candidate is judged by.
struct Judge<'a> {
    hand: &'a HandModel,
    shape: &'a Shape,
    settings: &'a GraspSettings,
    X_WO: &'a Isometry3<f64>,
    hand_hit: &'a HandHits<'a>,
}

impl Judge<'_> {
    /// A candidate with the hand centred on its own body, or, where that fails, on all of the object between the
    /// fingers: two bodies side by side are held together.
    fn grasp(&self, id: u32, part: usize, X_OH: &Isometry3<f64>) -> Grasp {
        let own = self.attempt(id, part, X_OH, &self.shape.dense[part..=part]);
        if own.is_accepted() || self.shape.bodies.len() == 1 {
            return own;
        }
        let whole = self.attempt(id, part, X_OH, &self.shape.dense);
        if whole.is_accepted() { whole } else { own }
    }

    fn attempt(&self, id: u32, part: usize, X_OH: &Isometry3<f64>, around: &[Vec<SurfaceSample>]) -> Grasp {
        let (X_OH, width_m) = centred(X_OH, around, self.shape);
        let mut grasp = Grasp {
            id,
            part,
            X_OH,
            closed: self.hand.open.clone(),
            contacts: Vec::new(),
            width_m,
            epsilon: 0.0,
            volume: None,
            success: None,
            clearance_m: None,
            score: None,
            start: None,
            via: Vec::new(),
            goal: None,
            status: GraspStatus::Accepted,
        };
        grasp.status = self.unwanted_pose(&grasp).unwrap_or_else(|| self.close_hand(&mut grasp));
        grasp
    }

    /// The filters that need no closed hand.
    fn unwanted_pose(&self, grasp: &Grasp) -> Option<GraspStatus> {
        let filter = &self.settings.filter;
        if let Some(wanted) = filter.part.filter(|&wanted| wanted != grasp.part) {
            return Some(GraspStatus::Unwanted { wish: Unwanted::Part { part: grasp.part, wanted } });
        }
        let cone = filter.approach?;
        let axis_W = cone.axis_W.try_normalize(1e-9)?;
        let approach_W = self.X_WO * (grasp.X_OH * Vector3::z());
        let angle_rad = math::acos(approach_W.dot(&axis_W).max(-1.0).min(1.0));
        let limit_rad = cone.half_angle_rad;
        let wish = Unwanted::Approach { angle_rad, limit_rad };
        (angle_rad > limit_rad).then_some(GraspStatus::Unwanted { wish })
    }

    /// Whether it holds the object outside the wanted region: where the middle of its contacts is.
    fn unwanted_place(&self, grasp: &Grasp) -> Option<GraspStatus> {
        let region = self.settings.filter.region?;
        let sum: Vector3<f64> = grasp.contacts.iter().map(|contact| contact.p_O.coords).sum();
        let p_W = self.X_WO * Point3::from(sum / grasp.contacts.len().max(1) as f64);
        let wish = Unwanted::Region { p_W };
        (!region.contains(&p_W)).then_some(GraspStatus::Unwanted { wish })
    }

    /// Closes the hand at the grasp's pose and fills in what comes of it; gives the status.
    fn close_hand(&self, grasp: &mut Grasp) -> GraspStatus {
        let Self { hand, shape, settings, hand_hit, .. } = self;
        let X_OH = grasp.X_OH;
        if grasp.width_m > shape.opening_m {
            return GraspStatus::TooWide { width_m: grasp.width_m, opening_m: shape.opening_m };
        }
        let open = hand.link_poses(&hand.open);
        let (link, depth_m) = close::deepest(hand, &open, &X_OH, &shape.bodies, OPEN_DIP_M, |_| true);
        if depth_m > OPEN_DIP_M {
            return GraspStatus::HandInObject { link: hand.links[link].name.clone(), depth_m };
        }
        if let Some(hit) = hand_hit(&X_OH, &hand.open) {
            return status_of(hit);
        }
        grasp.closed = close::close(hand, &X_OH, &shape.bodies);
        grasp.contacts = close::contacts(hand, &grasp.closed, &X_OH, &shape.bodies);
        if let Some(width_m) = contact_width(&grasp.contacts, &X_OH) {
            grasp.width_m = width_m;
        }
        if grasp.contacts.len() < settings.min_contacts {
            return GraspStatus::TooFewContacts { found: grasp.contacts.len(), wanted: settings.min_contacts };
        }
        if !is_opposed(&grasp.contacts, &X_OH) {
            return GraspStatus::OneSided { link: grasp.contacts[0].link.clone() };
        }
        if let Some(status) = self.unwanted_place(grasp) {
            return status;
        }
        if let Some(hit) = hand_hit(&X_OH, &grasp.closed) {
            return status_of(hit);
        }
        let Bodies { center_O, size_m, .. } = &shape.bodies;
        grasp.epsilon = quality::epsilon(&grasp.contacts, settings.friction, center_O, *size_m);
        GraspStatus::Accepted
    }
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
    let ends = X_HL.iter().zip(&hand.links).flat_map(|(X, link)| link.spheres().map(move |(c, r)| (X * c).z + r));
    ends.fold(f64::NEG_INFINITY, f64::max)
}

/// The hand moved along x_H until these samples are centred between the fingers, and their width there.
fn centred(X_OH: &Isometry3<f64>, around: &[Vec<SurfaceSample>], shape: &Shape) -> (Isometry3<f64>, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for sample in around.iter().flatten() {
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
pub(super) fn is_opposed(contacts: &[Contact], X_OH: &Isometry3<f64>) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::{CollisionModel, HandChecker, World};
    use crate::robot::Robot;
    use crate::robot::samples::{alita, crichton};

    /// A shape in O: semi-axes and exponents, x and z axis, centre.
    fn body(axes: [f64; 3], e: [f64; 2], x: Vector3<f64>, z: Vector3<f64>, center: [f64; 3]) -> Superquadric {
        let R = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
        let X_OS = Isometry3::from_parts(Translation3::from(center), UnitQuaternion::from_rotation_matrix(&R));
        Superquadric::new(axes[0], axes[1], axes[2], e[0], e[1], X_OS).unwrap()
    }

    /// A cylinder of 80 mm with a handle of 12 mm, a half circle of 34 mm radius that ends in its wall.
    fn mug() -> Vec<Superquadric> {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let handle = body([0.006, 0.006, 0.053], [0.3, 1.0], y, z, [0.073, 0.0, 0.0]);
        vec![body([0.04, 0.04, 0.05], [0.1, 1.0], x, z, [0.0; 3]), handle.deformed(0.0, 1.0 / 0.034).unwrap()]
    }

    /// A handle of 260 mm, tapered, with a head across it.
    fn hammer() -> Vec<Superquadric> {
        let (x, z) = (Vector3::x(), Vector3::z());
        let handle = body([0.012, 0.015, 0.13], [0.2, 0.9], x, z, [0.0; 3]).deformed(-0.2, 0.0).unwrap();
        vec![handle, body([0.014, 0.014, 0.05], [0.1, 1.0], z, x, [0.0, 0.0, 0.13])]
    }

    fn grasps(robot: &Robot, bodies: &[Superquadric]) -> Vec<Grasp> {
        let hand = HandModel::new(robot, &robot.arms[0]);
        let settings = GraspSettings { density: 10, ..GraspSettings::default() };
        candidates(&hand, bodies, Touched::Bodies, &settings, &Isometry3::identity(), &|_, _| None)
    }

    /// Each accepted grasp, checked against convex pieces with the collision room's own geometry.
    fn assert_open_hands_are_clear(robot: &Robot, bodies: &[Superquadric], grasps: &[Grasp]) {
        let model = CollisionModel::new(robot).unwrap();
        let mut world = World::new();
        for piece in bodies.iter().flat_map(|b| b.convex_pieces_in_axes(6).into_iter().map(move |p| (p, b.X_FS))) {
            world.add_points("object", &piece.0, &piece.1).unwrap();
        }
        let open = HandModel::new(robot, &robot.arms[0]).open;
        let checker = HandChecker::new(&model, &world, &[], 0, &open).unwrap();
        for grasp in grasps.iter().filter(|grasp| grasp.is_accepted()) {
            let gap_m = checker.distance(&grasp.X_OH).distance_m;
            // 1 mm is allowed into the fit, and the spheres on a link leave up to another one between them.
            assert!(gap_m > -0.0025, "grasp {} is {gap_m} m from the object", grasp.id);
        }
    }

    #[test]
    fn a_mug_can_be_grasped_at_its_handle_and_at_its_body() {
        for robot in [alita(), crichton()] {
            let bodies = mug();
            let found = grasps(&robot, &bodies);
            for part in [0, 1] {
                let of_part: Vec<&Grasp> = found.iter().filter(|g| g.part == part).collect();
                let accepted = of_part.iter().filter(|grasp| grasp.is_accepted()).count();
                assert!(accepted > 0, "{} at part {part}", robot.name);
            }
            assert_open_hands_are_clear(&robot, &bodies, &found);
        }
    }

    #[test]
    fn a_hammer_can_be_grasped_by_its_handle() {
        for robot in [alita(), crichton()] {
            let bodies = hammer();
            let found = grasps(&robot, &bodies);
            assert!(found.iter().any(|grasp| grasp.part == 0 && grasp.is_accepted() && grasp.epsilon > 0.0));
            assert_open_hands_are_clear(&robot, &bodies, &found);
        }
    }

    #[test]
    fn contacts_lie_on_the_free_surface_with_its_normal_within_reach_of_their_link() {
        let robot = crichton();
        let hand = HandModel::new(&robot, &robot.arms[0]);
        let brick = vec![body([0.02, 0.03, 0.08], [0.1, 0.1], Vector3::x(), Vector3::z(), [0.0; 3])];
        for bodies in [brick, mug(), hammer()] {
            let mut contacts = 0;
            for grasp in grasps(&robot, &bodies).iter().filter(|grasp| grasp.is_accepted()) {
                let X_HL = hand.link_poses(&grasp.closed);
                for contact in &grasp.contacts {
                    let depth = |body: &Superquadric| body.ln_inside_outside(&body.to_axes(&contact.p_O));
                    let body = bodies.iter().min_by(|l, r| depth(l).abs().total_cmp(&depth(r).abs())).unwrap();
                    assert!(depth(body).abs() < 1e-8 && bodies.iter().all(|body| depth(body) > -1e-3));
                    assert!(body.normal_at(&contact.p_O).dot(&contact.n_O) > 1.0 - 1e-6);
                    let link = hand.links.iter().position(|link| link.name == contact.link).unwrap();
                    let X_OL = grasp.X_OH * X_HL[link];
                    let gap = |(center, radius): &(Point3<f64>, f64)| (X_OL * center - contact.p_O).norm() - radius;
                    let gap_m = hand.links[link].spheres().map(gap).fold(f64::INFINITY, f64::min);
                    assert!(gap_m <= close::PAD_GIVE_M + 1e-9, "{gap_m} at grasp {}", grasp.id);
                    contacts += 1;
                }
            }
            assert!(contacts > 100, "{contacts}");
        }
    }

    #[test]
    fn candidates_start_from_what_no_other_body_covers() {
        for bodies in [mug(), hammer()] {
            let union = Bodies::new(&bodies, Touched::Bodies);
            for part in 0..2 {
                let samples = union.samples(part, 60);
                assert!(!samples.is_empty() && samples.len() < bodies[part].samples(60).len());
                let other = &bodies[1 - part];
                assert!(samples.iter().all(|sample| other.signed_distance(&sample.p_F) > -2e-6));
            }
        }
    }

    #[test]
    fn two_halves_side_by_side_are_grasped_around_both() {
        let (x, z) = (Vector3::x(), Vector3::z());
        let half = |at: f64| body([0.01, 0.03, 0.08], [0.1, 0.1], x, z, [at, 0.0, 0.0]);
        let found = grasps(&alita(), &[half(-0.01), half(0.01)]);
        // Centred on one half, a finger would be inside the other: the whole is 40 mm wide.
        let around_both = |grasp: &&Grasp| grasp.is_accepted() && (grasp.width_m - 0.04).abs() < 0.001;
        assert!(found.iter().filter(around_both).count() > 20);
    }
}
