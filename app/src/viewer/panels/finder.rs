//! The search of the outliner: layers and things by some letters of their names, each a click away.

use egui::{Align, Id, Rect, Role, ScrollArea, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::job::Stage;

use super::{Out, layer_list};
use crate::viewer::fields::search;
use crate::viewer::format;
use crate::viewer::icons::Icon;
use crate::viewer::theme::{BODY, SECONDARY, SMALL_RADIUS, Tokens, font};
use crate::viewer::widgets::{focus_ring, icon_button_at, paragraph, text_in};
use crate::viewer::{Command, GraspCommand, GraspPage, Layer, PlaceCommand, Step, Thing, ViewerState};

const NAME: &str = "Search what is shown";
const FIELD: &str = "Words to search for";
/// Height of a row, points.
const ROW: f32 = 24.0;
/// Most rows that are listed: of hundreds of grasps, those that fit best.
const MOST: usize = 40;

/// Something that can be found beside the layers.
struct Found {
    title: String,
    /// What it is, or how it fares.
    kind: String,
    /// What shows it.
    commands: Vec<Command>,
    /// What lights up in the view while its row is under the pointer.
    grasp: Option<u32>,
    cluster: Option<usize>,
}

/// The open search.
#[derive(Clone, Default)]
struct Search {
    words: String,
    /// Whether the field has been given the keyboard: not in the frame of the click that opens it, which takes it away.
    has_keyboard: bool,
}

/// The button beside the heading; the field beneath it while the search is open. Gives the words.
pub(super) fn draw(ui: &mut Ui, heading: Rect) -> Option<String> {
    let id = Id::unique(NAME);
    let mut open: Option<Search> = ui.data(|data| data.get_temp(id));
    let corner = Rect::from_center_size(pos2(heading.right() - 9.0, heading.center().y), vec2(24.0, 22.0));
    let (icon, name) = if open.is_some() { (Icon::Cross, "Close the search") } else { (Icon::Search, NAME) };
    if icon_button_at(ui, corner, icon, name, true).clicked() {
        open = if open.is_some() { None } else { Some(Search::default()) };
    } else if let Some(present) = &mut open {
        if !present.has_keyboard {
            let field = ui.scope_id().with(FIELD);
            ui.memory_mut(|memory| memory.request_focus(field));
            present.has_keyboard = true;
        }
        let width = ui.available_width();
        if let Some(changed) = search(ui, FIELD, "Layer, object, cluster, grasp", &present.words, width) {
            present.words = changed;
        }
        ui.add_space(4.0);
    }
    ui.data_mut(|data| {
        if let Some(open) = open.clone() {
            data.insert_temp(id, open);
        } else {
            data.remove::<Search>(id);
        }
    });
    open.map(|open| open.words).filter(|words| !words.trim().is_empty())
}

/// What has all the words in its name.
pub(super) fn list(ui: &mut Ui, state: &ViewerState, layers: &[Layer], words: &str, out: &mut Out) {
    let words: Vec<String> = words.to_lowercase().split_whitespace().map(str::to_owned).collect();
    let fits = |text: &str| {
        let text = text.to_lowercase();
        words.iter().all(|word| text.contains(word.as_str()))
    };
    let layers: Vec<Layer> = layers.iter().copied().filter(|layer| fits(&layer_list::label(state, *layer))).collect();
    let found: Vec<Found> =
        things(state).into_iter().filter(|thing| fits(&format!("{} {}", thing.title, thing.kind))).collect();
    ScrollArea::vertical().id_salt("Found").auto_shrink([false, true]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for layer in &layers {
            layer_list::row(ui, state, *layer, ROW, out);
        }
        for thing in found.iter().take(MOST) {
            row(ui, thing, out);
        }
        let tokens = Tokens::of(ui);
        if layers.is_empty() && found.is_empty() {
            let _none = paragraph(ui, "Nothing is called so.", BODY, tokens.secondary);
        } else if found.len() > MOST {
            let rest = format!("and {} more", format::count(found.len() - MOST));
            let _more = paragraph(ui, &rest, SECONDARY, tokens.secondary);
        }
    });
}

fn row(ui: &mut Ui, thing: &Found, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("{}, {}", thing.title, thing.kind)));
    if response.hovered() {
        ui.painter().rect_filled(rect, SMALL_RADIUS, tokens.hover);
        (out.grasp, out.cluster) = (thing.grasp.or(out.grasp), thing.cluster.or(out.cluster));
    }
    let middle = rect.left() + 0.52 * rect.width();
    let title = Rect::from_min_max(rect.min + vec2(4.0, 0.0), pos2(middle, rect.bottom()));
    let kind = Rect::from_min_max(pos2(middle + 6.0, rect.top()), rect.max - vec2(4.0, 0.0));
    let _title = text_in(ui, title, Align::Min, &thing.title, font(BODY), tokens.text);
    let _kind = text_in(ui, kind, Align::Max, &thing.kind, font(SECONDARY), tokens.secondary);
    focus_ring(ui, &response, rect);
    if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
        out.commands.extend(thing.commands.iter().cloned());
    }
}

/// Objects, boxes, clusters and grasps, in this order.
fn things(state: &ViewerState) -> Vec<Found> {
    let scene = state.scene();
    let place = |title: String, kind: &str, thing: Thing| Found {
        title,
        kind: kind.to_owned(),
        commands: vec![
            Command::SelectStep(Step::Stage(Stage::Scene)),
            Command::Place(PlaceCommand::Select(Some(thing))),
        ],
        grasp: None,
        cluster: None,
    };
    let mut found = Vec::new();
    if state.document.cloud.is_none() {
        for (index, placed) in scene.objects.iter().enumerate() {
            let kind = if index == scene.task.object { "object to grasp" } else { "object" };
            found.push(place(format::title_of(&placed.object), kind, Thing::Object(index)));
        }
        found.push(place("Depth camera".to_owned(), "sensor", Thing::Camera));
    }
    for (index, obstacle) in scene.obstacles.iter().enumerate() {
        found.push(place(format::title_of(&obstacle.name), "box", Thing::Obstacle(index)));
    }
    for (index, cluster) in state.outputs.segment.iter().flat_map(|segment| segment.clusters.iter().enumerate()) {
        found.push(Found {
            title: format!("Cluster {}", index + 1),
            kind: format!("{} points", format::count(cluster.len())),
            commands: vec![Command::SelectCluster(index)],
            grasp: None,
            cluster: Some(index),
        });
    }
    for grasp in state.outputs.candidates() {
        let kind = if grasp.is_accepted() { "accepted".to_owned() } else { grasp.status.reason() };
        found.push(Found {
            title: format!("Grasp {}", grasp.id),
            kind,
            commands: vec![Command::SelectGrasp(grasp.id), Command::Grasping(GraspCommand::Page(GraspPage::Grasp))],
            grasp: Some(grasp.id),
            cluster: None,
        });
    }
    found
}
