//! Name, robot, demo, seed, and the few things that concern the whole page.

use egui::{Align, Layout as UiLayout, Popup, Rect, Role, Sense, TextEdit, Ui, WidgetInfo, pos2, vec2};

use super::Out;
use crate::viewer::fields::menu_row;
use crate::viewer::icons::{self, Icon};
use crate::viewer::layout::Layout;
use crate::viewer::state::{Side, ThemeChoice};
use crate::viewer::theme::{BODY, SMALL_RADIUS, TITLE, Tokens, font, strong};
use crate::viewer::widgets::{elided, focus_ring, icon_button, segmented};
use crate::viewer::{Command, Overlay, ViewerState};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, layout: &Layout, out: &mut Out) {
    ui.with_layout(UiLayout::left_to_right(Align::Center), |ui| {
        ui.spacing_mut().item_spacing.x = if layout.is_narrow { 8.0 } else { 16.0 };
        if layout.is_narrow {
            let lit = state.drawer == Some(Side::Left);
            if icon_button(ui, Icon::Steps, "Pipeline and layers", true, lit).clicked() {
                out.push(Command::ToggleDrawer(Side::Left));
            }
        }
        if !layout.is_phone {
            wordmark(ui);
            robot_switch(ui, state, out);
        }
        let right_part = match (layout.is_phone, layout.is_narrow) {
            (true, _) => 180.0,
            (_, true) => 238.0,
            _ => 334.0,
        };
        demo_menu(ui, state, (ui.available_width() - right_part).max(60.0), out);
        ui.with_layout(UiLayout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            right_part_of(ui, state, layout, out);
        });
    });
}

fn wordmark(ui: &mut Ui) {
    let tokens = Tokens::of(ui);
    let end = ui.painter().layout_no_wrap("End".to_owned(), strong(TITLE - 1.0), tokens.text);
    let comfort = ui.painter().layout_no_wrap("comfort".to_owned(), strong(TITLE - 1.0), tokens.teal_text);
    let size = vec2(end.size().x + comfort.size().x, 30.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, "Endcomfort"));
    let y = rect.center().y - 0.5 * end.size().y;
    let x = rect.left() + end.size().x;
    ui.painter().galley(pos2(rect.left(), y), end, tokens.text);
    ui.painter().galley(pos2(x, y), comfort, tokens.teal_text);
}

/// Which robot acts.
pub(super) fn robot_switch(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let titles: Vec<&str> = state.robots.iter().map(|robot| robot.title.as_str()).collect();
    let chosen = state.robots.iter().position(|robot| robot.name == state.document.scene.robot);
    if let Some(index) = segmented(ui, "Robot", &titles, chosen) {
        out.push(Command::SetRobot(state.robots[index].name.clone()));
    }
}

/// What is open, and the list of what can be opened.
fn demo_menu(ui: &mut Ui, state: &ViewerState, max_width: f32, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let open = match &state.document.cloud {
        Some(cloud) => cloud.name.clone(),
        None => state.document.scene.title.clone(),
    };
    let galley = elided(ui, &open, font(BODY), tokens.secondary, max_width - 36.0);
    let (rect, response) = ui.allocate_exact_size(vec2(galley.size().x + 36.0, 28.0), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Open a demo; now {open}")));
    let lit = response.hovered() || Popup::is_id_open(ui.ctx(), Popup::default_response_id(&response));
    if lit {
        ui.painter().rect_filled(rect, SMALL_RADIUS, tokens.hover);
    }
    let color = if lit { tokens.text } else { tokens.secondary };
    let at = pos2(rect.left() + 8.0, rect.center().y - 0.5 * galley.size().y);
    ui.painter().galley_with_override_text_color(at, galley, color);
    icons::paint(ui.painter(), Icon::Down, pos2(rect.right() - 14.0, rect.center().y), 13.0, color);
    focus_ring(ui, &response, rect);
    Popup::menu(&response).gap(6.0).width(300.0).show(|ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        for demo in &state.demos {
            if menu_row(ui, &demo.scene.title, state.demo.as_deref() == Some(&demo.name)) {
                out.push(Command::OpenDemo(demo.name.clone()));
                ui.close();
            }
        }
        crate::viewer::widgets::hairline(ui);
        // A window has no list of files of its own: there they are dropped.
        let open = cfg!(target_arch = "wasm32").then_some(("Open a file…", Command::PickFile));
        let rows = [
            ("All demos…", Command::Show(Overlay::Gallery)),
            ("Copy a link to this view", Command::Share),
            ("Save a picture or an animation…", Command::Show(Overlay::Picture)),
            ("Save the session", Command::SaveSession),
            ("Save the scene", Command::SaveScene),
        ];
        for (words, command) in rows.into_iter().chain(open) {
            if menu_row(ui, words, false) {
                out.push(command);
                ui.close();
            }
        }
    });
}

/// From right to left.
fn right_part_of(ui: &mut Ui, state: &ViewerState, layout: &Layout, out: &mut Out) {
    if layout.is_narrow {
        let lit = state.drawer == Some(Side::Right);
        if icon_button(ui, Icon::Inspector, "Inspector", true, lit).clicked() {
            out.push(Command::ToggleDrawer(Side::Right));
        }
    }
    if icon_button(ui, Icon::Help, "Keys (?)", true, state.overlay == Overlay::Help).clicked() {
        out.push(Command::Show(Overlay::Help));
    }
    let dark = ui.visuals().dark_mode;
    let (icon, name, choice) = if dark {
        (Icon::Sun, "Light theme", ThemeChoice::Light)
    } else {
        (Icon::Moon, "Dark theme", ThemeChoice::Dark)
    };
    if icon_button(ui, icon, name, true, false).clicked() {
        out.push(Command::SetTheme(choice));
    }
    let is_saving = state.overlay == Overlay::Picture;
    if !layout.is_phone
        && icon_button(ui, Icon::Camera, "Save a picture or an animation (I)", true, is_saving).clicked()
    {
        out.push(Command::Show(Overlay::Picture));
    }
    if !layout.is_phone && icon_button(ui, Icon::Link, "Copy a link to this view (Ctrl Shift S)", true, false).clicked()
    {
        out.push(Command::Share);
    }
    super::view_menu::draw(ui, state, out);
    if icon_button(ui, Icon::Redo, "Redo (Ctrl Shift Z)", state.can_redo(), false).clicked() {
        out.push(Command::Redo);
    }
    if icon_button(ui, Icon::Undo, "Undo (Ctrl Z)", state.can_undo(), false).clicked() {
        out.push(Command::Undo);
    }
    if !layout.is_narrow {
        ui.add_space(12.0);
        seed_field(ui, state.document.scene.seed, out);
    }
}

/// The seed as a field: Enter or leaving it runs the pipeline with the new seed, anything but a number is put back.
fn seed_field(ui: &mut Ui, seed: u64, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let id = ui.scope_id().with("Seed");
    let kept: Option<String> = ui.data(|data| data.get_temp(id));
    let mut text = kept.unwrap_or_else(|| seed.to_string());
    let (rect, _) = ui.allocate_exact_size(vec2(60.0, 28.0), Sense::hover());
    ui.painter().rect_filled(rect, SMALL_RADIUS, tokens.well);
    let field = TextEdit::singleline(&mut text)
        .id(id.with("field"))
        .font(font(BODY))
        .text_color(tokens.text)
        .frame(egui::Frame::NONE)
        .margin(egui::Margin::ZERO)
        .align(egui::Align2::LEFT_CENTER)
        .char_limit(20)
        .desired_width(44.0);
    let response = ui.place(Rect::from_center_size(rect.center(), vec2(44.0, 20.0)), field);
    ui.add_space(6.0);
    let name = ui.label(egui::RichText::new("seed").font(font(BODY)).color(tokens.secondary));
    let response = response.labelled_by(name.id);
    focus_ring(ui, &response, rect);
    if response.lost_focus() {
        if let Ok(wanted) = text.trim().parse::<u64>() {
            out.push(Command::SetSeed(wanted));
        }
        ui.data_mut(|data| data.remove::<String>(id));
    } else if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
    }
}
