//! The state as JSON, for the page's test interface and for people who script the page.

use endcomfort_core::job::{ObjectiveFit, Stage};
use endcomfort_core::task::plan_json_lines;
use serde_json::{Value, json};

use super::reach::ARMS;
use super::state::StageState;
use super::{Layer, MapSource, Overlay, Slot, ViewerState};
use crate::assets;

impl ViewerState {
    /// What stands on the screen, as one JSON object.
    pub fn status(&self) -> Value {
        let stages: Vec<Value> = Stage::ALL.into_iter().map(|stage| self.stage_status(stage)).collect();
        let outputs = &self.outputs;
        let fit = outputs.fit.as_ref().and_then(|fit| fit.fits.get(fit.target)).and_then(|fit| fit.as_ref().ok());
        json!({
            "scene": self.document.scene.name,
            "robot": self.document.scene.robot,
            "demo": self.demo,
            "file": self.document.cloud.as_ref().map(|cloud| &cloud.name),
            "seed": self.document.scene.seed,
            "revision": self.revision,
            "running": self.running,
            "stages": stages,
            "points": outputs.scene.as_ref().map(|scene| scene.cloud.points.len()),
            "clusters": outputs.segment.as_ref().map(|segment| segment.clusters.len()),
            "fit_radial_m": fit.map(|fit| fit.radial_m),
            "fit": self.fit_status(),
            "objectives": self.comparison().map_or_else(Vec::new, |comparison| comparison.rows.iter().map(objective_status).collect()),
            "step": self.selection.step.title().to_lowercase(),
            "candidates": outputs.candidates().len(),
            "accepted": outputs.rank.as_ref().map(|rank| rank.accepted),
            "ranked_by": self.document.scene.rank.by,
            "colored_by": self.shown_quantity(),
            "selected_grasp": self.selection.grasp,
            "planned_grasp": outputs.plan.as_ref().map(|plan| plan.grasp().id),
            "planner": self.document.scene.motion.planner,
            "steps": self.document.scene.task.steps.len(),
            "legs": outputs.plan.as_ref().map(|plan| plan.legs.len()),
            "tries": self.tries().len(),
            "routes": outputs.plan.as_ref().map(|plan| plan.routes.len()),
            "reach": self.reach_status(),
            "kept": self.planning.kept.as_ref().map(|kept| &kept.title),
            "duration_s": self.duration_s(),
            "time_s": self.playback.time_s,
            "playing": self.playback.playing,
            "overlay": match self.overlay {
                Overlay::None => Value::Null,
                Overlay::Gallery => json!("gallery"),
                Overlay::Help => json!("help"),
                Overlay::Palette => json!("palette"),
                Overlay::Picture => json!("picture"),
            },
            "messages": self.messages.iter().map(|message| &message.text).collect::<Vec<_>>(),
        })
    }

    /// The fit that the inspector shows.
    fn fit_status(&self) -> Value {
        let (Some(fit), Some(cluster)) = (self.examined_fit(), self.examined_cluster()) else { return Value::Null };
        json!({
            "cluster": cluster,
            "superquadric": fit.superquadric,
            "radial_m": fit.radial_m,
            "goodness_of_fit": fit.goodness_of_fit,
            "goodness_of_fit_abs": fit.goodness_of_fit_abs,
            "volume_m3": fit.volume_m3,
            "parts": fit.bodies().count(),
            "mirrored": fit.mirrored.len(),
            "rejected": fit.rejected.len(),
            "objective": self.document.scene.fit.objective,
            "by_hand": self.automatic_fit().is_some(),
        })
    }

    /// The maps that are shown: by arm their voxels, and the chosen voxel's place, arm and number of orientations.
    fn reach_status(&self) -> Value {
        if !self.layers.get(Layer::Reach).visible {
            return Value::Null;
        }
        let maps: Vec<Value> = (0..2)
            .map(|arm| match self.reaching.slot(arm) {
                Slot::Empty => Value::Null,
                Slot::Awaited(_) => json!({ "arm": ARMS[arm], "state": "awaited" }),
                Slot::Missing(reason) => json!({ "arm": ARMS[arm], "state": "missing", "reason": reason }),
                Slot::Here(shown) => json!({
                    "arm": ARMS[arm],
                    "state": "here",
                    "voxels": shown.map.voxels().count(),
                    "poses": shown.map.reached_poses(),
                    "bytes": shown.bytes.len(),
                    "built": matches!(shown.source, MapSource::Built { .. }),
                }),
            })
            .collect();
        let chosen = self.shown_voxel().and_then(|chosen| {
            let p_W = self.voxel_place(chosen.arm, chosen.voxel)?;
            let reached = self.reaching.orientations(chosen.arm, chosen.voxel).len();
            Some(json!({ "arm": ARMS[chosen.arm], "p_W": [p_W.x, p_W.y, p_W.z], "reached": reached }))
        });
        json!({ "maps": maps, "chosen": chosen, "building": self.map_under_way().map(|(fraction, _)| fraction) })
    }

    pub(super) fn stage_status(&self, stage: Stage) -> Value {
        match self.stage(stage) {
            StageState::Waiting => json!({ "stage": stage, "state": "waiting" }),
            StageState::Stale => json!({ "stage": stage, "state": "stale" }),
            StageState::Running { fraction, note } => {
                json!({ "stage": stage, "state": "running", "fraction": fraction, "note": note })
            }
            StageState::Done { elapsed_ms } => json!({ "stage": stage, "state": "done", "elapsed_ms": elapsed_ms }),
            StageState::Refused(refusal) => {
                json!({ "stage": stage, "state": "refused", "reason": refusal.message, "details": refusal.details })
            }
        }
    }

    /// The plan as `endcomfort plan --json` prints it, one line per phase; `None` while there is none for the present
    /// scene.
    pub fn plan_json(&self) -> Option<String> {
        let plan = self.outputs.plan.as_ref().filter(|plan| plan.revision == self.revision)?;
        let robot = assets::library().robot_of(&self.document.scene).ok()?;
        let lines: Vec<String> = plan_json_lines(&plan.value, &robot).iter().map(Value::to_string).collect();
        Some(lines.join("\n"))
    }
}

fn objective_status((elapsed_ms, row): &(f64, ObjectiveFit)) -> Value {
    match &row.fit {
        Ok(fit) => json!({
            "objective": row.objective,
            "radial_m": fit.radial_m,
            "goodness_of_fit": fit.goodness_of_fit,
            "volume_m3": fit.volume_m3,
            "iterations": fit.iterations,
            "fit_ms": elapsed_ms,
        }),
        Err(reason) => json!({ "objective": row.objective, "reason": reason, "fit_ms": elapsed_ms }),
    }
}
