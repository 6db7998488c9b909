//! The panels as a person meets them: laid out by egui, found by what assistive technology reads.

mod actions;
mod behaviour;
mod bench;
mod bringing;
mod grasping;
mod handing;
mod invented;
mod lab;
mod looking;
mod panels;
mod photographs;
mod pictures;
mod placing;
mod plans;
mod posing;
mod reach;
mod saving;
mod share;
mod tasks;
mod tour;
mod view;

use egui_kittest::Harness;

use super::{Command, Effect, Tokens, ViewerState, draw_panels, theme};

/// The panels with their state and everything that was asked of the world outside.
struct Page {
    state: ViewerState,
    effects: Vec<Effect>,
    commands: Vec<Command>,
}

impl Page {
    fn show(&mut self, ui: &mut egui::Ui) {
        // The harness leaves a margin that the window does not have.
        let window = ui.ctx().content_rect();
        let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(window));
        ui.set_clip_rect(window);
        let tokens = Tokens::of(&ui);
        ui.painter().rect_filled(window, 0.0, tokens.view_centre.lerp_to_gamma(tokens.view_edge, 0.5));
        for command in draw_panels(&mut ui, &self.state) {
            self.commands.push(command.clone());
            let effects = self.state.apply(command);
            self.effects.extend(effects);
        }
    }
}

fn page(state: ViewerState, size: [f32; 2], theme: egui::Theme) -> Harness<'static, Page> {
    let page = Page { state, effects: Vec::new(), commands: Vec::new() };
    Harness::builder()
        .with_size(size)
        .with_theme(theme)
        .with_max_steps(24)
        .with_context_setup(theme::install)
        .build_ui_state(|ui, page: &mut Page| page.show(ui), page)
}
