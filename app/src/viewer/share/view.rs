//! How somebody looks at a document: camera, moment, step, selection, layers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::ShareError;
use crate::render::{Camera, Cut};
use crate::viewer::state::Step;
use crate::viewer::viewing::MOST_KEPT;
use crate::viewer::{CloudLook, Layer, LayerView, Layers, ViewerState};

/// Lengths and angles of a camera are shared to this fraction of a metre or a radian: far below a pixel.
const CAMERA_STEPS: f64 = 1e6;
/// Times are shared to this fraction of a second.
const TIME_STEPS: f64 = 1e4;
/// Nobody looks from farther away than this, metres.
const MAX_DISTANCE_M: f64 = 500.0;
/// The longest moment that is sought, seconds.
const MAX_TIME_S: f64 = 1e6;
/// Diameters of points, metres.
const DIAMETER_M: [f64; 2] = [1e-4, 0.05];
/// Fields of view that draw something, rad.
const FIELD_RAD: [f64; 2] = [0.01, 3.0];

/// How somebody looks at a document. The theme is everybody's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SharedView {
    /// Where the camera stands; `None` frames everything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// Moment of the plan, seconds.
    pub time_s: f64,
    /// The step whose question the inspector answers, in lower case; `None` leaves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<String>,
    /// The selected grasp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<u32>,
    /// The selected cluster.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cluster: Option<usize>,
    /// Layers that are shown otherwise than at first.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub layers: BTreeMap<Layer, LayerView>,
    /// How points are drawn, if otherwise than at first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<CloudLook>,
    /// What is taken away.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut: Option<Cut>,
    /// Views that were kept.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub kept: Vec<Camera>,
}

impl SharedView {
    /// How a state is looked at.
    pub(super) fn of(state: &ViewerState, camera: Option<Camera>) -> Self {
        let usual = Layers::default();
        let layers = Layer::ALL.into_iter().map(|layer| (layer, state.layers.get(layer)));
        Self {
            camera: camera.map(rounded),
            time_s: (state.playback.time_s * TIME_STEPS).round() / TIME_STEPS,
            step: Some(state.selection.step.title().to_lowercase()),
            grasp: state.selection.grasp,
            cluster: state.selection.cluster,
            layers: layers.filter(|(layer, view)| usual.get(*layer) != *view).collect(),
            points: Some(state.looking.cloud).filter(|look| *look != CloudLook::default()),
            cut: state.looking.cut,
            kept: state.viewing.kept.iter().map(|kept| rounded(kept.camera)).collect(),
        }
    }

    /// The step that it names.
    pub(super) fn step(&self) -> Option<Step> {
        self.step.as_deref().and_then(Step::named)
    }

    /// How the layers are shown.
    pub(super) fn layers(&self) -> Layers {
        let mut layers = Layers::default();
        for (&layer, &view) in &self.layers {
            *layers.get_mut(layer) = LayerView { opacity: view.opacity.max(0.05).min(1.0), ..view };
        }
        layers
    }

    /// The view, if its numbers can be looked at.
    ///
    /// # Errors
    /// [`ShareError::Value`] names the number.
    pub(super) fn checked(mut self) -> Result<Self, ShareError> {
        let range = |place: &str, value: f64, [low, high]: [f64; 2]| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(ShareError::Value {
                place: format!("view.{place}"),
                found: value.to_string(),
                wanted: format!("from {low} to {high}"),
            })
        };
        range("time_s", self.time_s, [0.0, MAX_TIME_S])?;
        if let Some(step) = self.step.as_ref().filter(|step| Step::named(step).is_none()) {
            return Err(ShareError::Value {
                place: "view.step".to_owned(),
                found: format!("{step:?}"),
                wanted: Step::ALL.map(Step::title).join(", ").to_lowercase(),
            });
        }
        if let Some(points) = &self.points {
            range("points.diameter_m", f64::from(points.diameter_m), DIAMETER_M)?;
        }
        if let Some(cut) = &self.cut {
            range("cut.axis", cut.axis as f64, [0.0, 2.0])?;
            range("cut.at_m", cut.at_m, [-MAX_DISTANCE_M, MAX_DISTANCE_M])?;
        }
        range("kept", self.kept.len() as f64, [0.0, MOST_KEPT as f64])?;
        for camera in self.camera.iter_mut().chain(&mut self.kept) {
            for (index, at) in camera.target.iter().enumerate() {
                range(&format!("camera.target[{index}]"), *at, [-MAX_DISTANCE_M, MAX_DISTANCE_M])?;
            }
            let turn = std::f64::consts::TAU;
            range("camera.distance_m", camera.distance_m, [1e-3, MAX_DISTANCE_M])?;
            range("camera.yaw_rad", camera.yaw_rad, [-turn, turn])?;
            range("camera.pitch_rad", camera.pitch_rad, [-0.5 * turn, 0.5 * turn])?;
            range("camera.roll_rad", camera.roll_rad, [-turn, turn])?;
            range("camera.fov_y_rad", camera.fov_y_rad, FIELD_RAD)?;
            // Rounded digits may lie a little beyond the pole.
            camera.pitch_rad = camera.pitch_rad.max(-0.25 * turn).min(0.25 * turn);
        }
        Ok(self)
    }
}

fn rounded(camera: Camera) -> Camera {
    let round = |value: f64| (value * CAMERA_STEPS).round() / CAMERA_STEPS;
    Camera {
        target: camera.target.map(round),
        distance_m: round(camera.distance_m),
        yaw_rad: round(camera.yaw_rad),
        pitch_rad: round(camera.pitch_rad),
        roll_rad: round(camera.roll_rad),
        fov_y_rad: round(camera.fov_y_rad),
        projection: camera.projection,
    }
}
