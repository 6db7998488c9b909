//! What is under the pointer in the view, in words and numbers.

use egui::Ui;
use endcomfort_core::grasp::Quantity;

use super::quantities::{cell, short, unit};
use super::state::Step;
use super::theme::{BODY, SECONDARY, Tokens, font, strong};
use super::{Pick, ViewerState, format};
use crate::assets;

/// What of an accepted grasp is told.
const TOLD: [Quantity; 5] =
    [Quantity::MgGoal, Quantity::MgStart, Quantity::IkGoal, Quantity::Epsilon, Quantity::Clearance];

/// What a tip says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tip {
    pub(super) title: String,
    pub(super) lines: Vec<String>,
}

/// What there is to say of what is under the pointer.
pub(super) fn of(pick: Pick, state: &ViewerState) -> Option<Tip> {
    match pick {
        Pick::Grasp(id) => grasp(id, state),
        Pick::Cluster(cluster) | Pick::Part { cluster, .. } => body(cluster as usize, state),
        Pick::Obstacle(index) => {
            let obstacle = state.scene().obstacles.get(index as usize)?;
            let mm = 1e3 * obstacle.size_m;
            let size = format!("{:.0} × {:.0} × {:.0} mm", mm.x, mm.y, mm.z);
            Some(Tip { title: format::title_of(&obstacle.name), lines: vec![size] })
        }
        Pick::Voxel { arm, voxel } => {
            let map = state.reaching.map(arm as usize)?;
            let voxel = endcomfort_core::reach::Voxel(voxel);
            let share = format!("{:.0} % of the orientations", 100.0 * map.fraction(voxel));
            let m = format!("m {} on average", format::manipulability(map.mean_manipulability(voxel)));
            Some(Tip { title: "Voxel".to_owned(), lines: vec![share, m] })
        }
        Pick::Robot if state.selection.step == Step::Stage(endcomfort_core::job::Stage::Scene) => {
            let lines = vec!["Click to pose it".to_owned()];
            (!state.posing.is_open).then(|| Tip { title: state.robot_title(), lines })
        }
        Pick::Place(_) | Pick::Robot | Pick::Nothing => None,
    }
}

fn grasp(id: u32, state: &ViewerState) -> Option<Tip> {
    let grasp = state.outputs.candidate(id)?;
    let title = format::title_of(&state.grasp_title(id));
    if !grasp.is_accepted() {
        return Some(Tip { title, lines: vec![grasp.status.reason()] });
    }
    let line = |quantity: Quantity| {
        let value = quantity.of(grasp)?;
        let unit = unit(quantity).0;
        Some(format!("{} {} {unit}", short(quantity), cell(quantity, Some(value))).trim_end().to_owned())
    };
    Some(Tip { title, lines: TOLD.into_iter().filter_map(line).collect() })
}

fn body(cluster: usize, state: &ViewerState) -> Option<Tip> {
    let fit = state.outputs.fit.as_ref()?.fits.get(cluster)?.as_ref().ok()?;
    let placed = state.scene().object_at(&fit.superquadric.X_FS).filter(|_| state.document.cloud.is_none());
    let object = placed.and_then(|placed| assets::library().object(&placed.object).ok());
    let title = object.map_or_else(|| format!("Cluster {}", cluster + 1), |object| object.title.clone());
    let points = state.outputs.segment.as_ref().and_then(|segment| segment.clusters.get(cluster)).map(Vec::len);
    let mm = 2e3 * fit.superquadric.half_extents();
    let lines = vec![
        format!("{:.0} × {:.0} × {:.0} mm", mm.x, mm.y, mm.z),
        format!("{} points, fitted to {}", format::count(points.unwrap_or(0)), format::length(fit.radial_m)),
    ];
    Some(Tip { title, lines })
}

/// Writes it.
pub(super) fn draw(ui: &mut Ui, tip: &Tip) {
    let tokens = Tokens::of(ui);
    ui.spacing_mut().item_spacing.y = 2.0;
    ui.label(egui::RichText::new(&tip.title).font(strong(BODY)).color(tokens.text));
    for line in &tip.lines {
        ui.label(egui::RichText::new(line).font(font(SECONDARY)).color(tokens.secondary));
    }
}
