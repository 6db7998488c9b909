//! Objects whose shape the robot knows, and the scene that they stand in.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::GraspExperimentSettings;
use crate::experiment::ExperimentRefusal;
use crate::experiment::protocol::random_points;
use crate::fit::{Fit, FitInput, FitSettings, Part, fit};
use crate::job::FitOutput;
use crate::library::Library;
use crate::parallel;
use crate::rng::Rng;
use crate::scene::{ArmChoice, PlacedObject, SCENE_VERSION, Scene, TableTop, Task};
use crate::segment::Plane;
use crate::watch::Watch;

/// Points of the whole surface that an object is fitted to.
const SURFACE_POINTS: usize = 4000;
/// Stream of the surface points.
const SURFACE_STREAM: u64 = 0x7375_7266;
/// The table of the bundled scenes.
pub(super) const TABLE: TableTop =
    TableTop { center_m: [0.625, 0.0], size_m: [0.75, 1.5], height_m: 0.69, thickness_m: 0.04 };
/// Posture of the bundled scenes: hands above the table.
const POSTURE: &str = "table_ready";

/// An object with its fit in its own frame O.
pub(super) struct KnownObject {
    /// Name of the object's file.
    pub(super) name: String,
    /// Half the extents of its bounding box, metres.
    pub(super) half_m: Vector3<f64>,
    fit_O: Fit,
}

impl KnownObject {
    /// The object of this name, fitted to points that the seed and the number draw.
    pub(super) fn new(
        library: &Library,
        name: &str,
        settings: &FitSettings,
        seed: u64,
        number: u64,
    ) -> Result<Self, ExperimentRefusal> {
        let setup = |reason: String| ExperimentRefusal::Setup { reason };
        let object = library.object(name).map_err(|error| setup(error.to_string()))?;
        let rng = &mut Rng::new(seed, SURFACE_STREAM + number);
        let points = random_points(&object.mesh(), SURFACE_POINTS, rng);
        let table = Plane { normal: Vector3::z_axis(), offset_m: -object.half_extents().z };
        let input = FitInput { points: &points, X_FC: None, table: Some(table) };
        let found = fit(input, settings, Watch::idle()).map_err(|refusal| setup(format!("{name}: {refusal}")))?;
        // Points stay with the fit in O: nothing here asks for them.
        let fit_O = Fit { mirrored: Vec::new(), rejected: Vec::new(), runs: Vec::new(), ..found };
        Ok(Self { name: name.to_owned(), half_m: object.half_extents(), fit_O })
    }

    /// Pose of O when it stands on the table as it usually does, turned by `yaw_rad` about the table's normal.
    pub(super) fn standing(&self, [x, y]: [f64; 2], yaw_rad: f64) -> Isometry3<f64> {
        let position = Translation3::new(x, y, TABLE.height_m + self.half_m.z);
        Isometry3::from_parts(position, turn(yaw_rad))
    }

    /// Radius of the circle around it on the table, metres.
    pub(super) fn radius_m(&self) -> f64 {
        self.half_m.xy().norm()
    }

    /// Its fit where it stands.
    pub(super) fn fit(&self, X_WO: &Isometry3<f64>) -> Fit {
        let at = &self.fit_O;
        Fit {
            superquadric: at.superquadric.transformed(X_WO),
            others: at
                .others
                .iter()
                .map(|part| Part { superquadric: part.superquadric.transformed(X_WO), ..part.clone() })
                .collect(),
            ..at.clone()
        }
    }

    /// What the pipeline's own fit would say of it where it stands.
    pub(super) fn fits(&self, X_WO: &Isometry3<f64>) -> FitOutput {
        FitOutput { fits: vec![Ok(self.fit(X_WO))], target: 0, distances_m: vec![Vec::new()], automatic: None }
    }
}

/// Rotation about the table's normal.
pub(super) fn turn(yaw_rad: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = crate::math::sin_cos(0.5 * yaw_rad);
    UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(cos, 0.0, 0.0, sin))
}

/// All objects of the settings, fitted.
pub(super) fn known_objects(settings: &GraspExperimentSettings) -> Result<Vec<KnownObject>, ExperimentRefusal> {
    let numbered: Vec<(u64, &String)> = (0..).zip(&settings.objects).collect();
    let known = parallel::map(&numbered, |(index, name)| {
        KnownObject::new(&settings.library, name, &FitSettings::default(), settings.seed, *index)
    });
    known.into_iter().collect()
}

/// The object alone on the robot's table.
pub(super) fn scene(robot: &str, arm: ArmChoice, object: &KnownObject, X_WO: Isometry3<f64>, seed: u64) -> Scene {
    Scene {
        version: SCENE_VERSION,
        name: object.name.clone(),
        title: object.name.clone(),
        summary: String::new(),
        robot: robot.to_owned(),
        arm,
        posture: POSTURE.to_owned(),
        joints: BTreeMap::new(),
        table: TABLE,
        objects: vec![PlacedObject { object: object.name.clone(), X_WO }],
        obstacles: Vec::new(),
        // Nothing is looked at: the shape is known.
        X_WC: Isometry3::identity(),
        task: Task::pick(0),
        seed,
        segment: Default::default(),
        fit: Default::default(),
        grasp: Default::default(),
        motion: Default::default(),
        rank: Default::default(),
        torso: false,
        handover: None,
        hand: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::grasping::testing::settings;

    #[test]
    fn a_known_object_has_its_published_size_and_stands_on_the_table() {
        for object in known_objects(&settings(&["tomato_soup_can", "cracker_box", "mustard_bottle"])).unwrap() {
            let X_WO = object.standing([0.5, -0.2], 0.7);
            let fits = object.fits(&X_WO);
            let fit = fits.fits[0].as_ref().unwrap();
            let boxes = fit.bodies().map(|body| body.bounding_box_in(&X_WO.inverse()));
            let far = Vector3::repeat(f64::INFINITY);
            let (low, high) = boxes.fold((far, -far), |(l, h), (low, high)| (l.inf(&low.coords), h.sup(&high.coords)));
            // Corners of a box are rounder in the fit: a few millimetres. One superquadric leaves the narrow cap of a
            // bottle out.
            let cap_m = if object.name == "mustard_bottle" { 0.020 } else { 0.0 };
            let over = high - object.half_m;
            assert!(over.xy().amax() < 0.006 && over.z.abs() < 0.006 + cap_m, "{}: {high}", object.name);
            assert!((low + object.half_m).amax() < 0.006, "{}: {low}", object.name);
            assert!((X_WO.translation.z + low.z - TABLE.height_m).abs() < 0.006);
        }
    }

    #[test]
    fn an_object_that_does_not_exist_is_named() {
        let refusal = known_objects(&settings(&["unicorn"])).err().unwrap();
        assert_eq!(refusal.to_string(), "there is no object named \"unicorn\"");
    }
}
