//! The window that saves what the view shows: as a picture, as an animation, or as bodies.

use egui::{Align, Id, Modal, Rect, Role, ScrollArea, Sense, Ui, WidgetInfo, pos2, vec2};

use super::Out;
use crate::export::{AnimationFormat, Clip};
use crate::viewer::fields::{dropdown, tabs};
use crate::viewer::number::{Number, number_row};
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{
    overlay_frame, paragraph, primary_button, secondary_button, section, segmented_wide, switch, text_in, title,
};
use crate::viewer::{
    Command, Overlay, PictureCommand, PicturePage, PictureSettings, Shot, SizePreset, ViewerState, format,
};

const WIDTH: f32 = 400.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let frame = overlay_frame(tokens, 20);
    let window = ui.max_rect();
    let dark = ui.visuals().dark_mode;
    let view = View { size: window.size() * ui.pixels_per_point(), scale: ui.pixels_per_point(), dark };
    let modal = Modal::new(Id::unique("Save what you see")).frame(frame).backdrop_color(tokens.scrim);
    let modal = modal.show(ui.ctx(), |ui| {
        ui.set_width(WIDTH.min(window.width() - 60.0));
        ui.spacing_mut().item_spacing.y = 3.0;
        title(ui, "Save what you see");
        ui.add_space(4.0);
        if let Some((taken, wanted)) = state.picturing.progress {
            return under_way(ui, taken, wanted, out);
        }
        let page = state.picturing.page;
        if let Some(index) = tabs(ui, &PicturePage::ALL.map(PicturePage::title), Some(page as usize)) {
            out.push(Command::Picture(PictureCommand::Page(PicturePage::ALL[index])));
        }
        let height = (window.height() - 150.0).max(120.0);
        let area = ScrollArea::vertical().max_height(height).min_scrolled_height(height).auto_shrink([false, true]);
        area.show(ui, |ui| match page {
            PicturePage::Picture => picture(ui, state, &view, out),
            PicturePage::Animation => animation(ui, state, &view, out),
            PicturePage::Scene => scene(ui, out),
        });
    });
    if modal.should_close() {
        out.push(Command::Show(Overlay::None));
    }
}

/// The view on the screen: its size in pixels, and in which theme.
struct View {
    size: egui::Vec2,
    scale: f32,
    dark: bool,
}

impl View {
    fn shot(&self, settings: &PictureSettings) -> Shot {
        let size_px = [self.size.x, self.size.y].map(|side| side.round().max(1.0) as u32);
        settings.shot(size_px, self.scale, self.dark)
    }
}

fn picture(ui: &mut Ui, state: &ViewerState, view: &View, out: &mut Out) {
    let present = state.picturing.settings;
    let wanted = looks(ui, present, view);
    let shot = view.shot(&wanted);
    let problem = ViewerState::shot_problem(&shot);
    say_problem(ui, problem.as_deref());
    if buttons(ui, "Save the picture", problem.is_none(), out) {
        out.push(Command::Picture(PictureCommand::Take(shot)));
    }
    if wanted != present {
        out.push(Command::Picture(PictureCommand::Settings(wanted)));
    }
}

fn animation(ui: &mut Ui, state: &ViewerState, view: &View, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let present = state.picturing.settings;
    let duration_s = state.duration_s();
    if state.outputs.plan.is_none() {
        let _text = paragraph(ui, "There is no plan that could move.", BODY, tokens.secondary);
        let _never = buttons(ui, "Save the animation", false, out);
        return;
    }
    let mut wanted = present;
    let chosen = AnimationFormat::ALL.iter().position(|format| *format == present.format);
    if let Some(index) = segmented_wide(ui, "Format", &AnimationFormat::ALL.map(AnimationFormat::title), chosen) {
        wanted.format = AnimationFormat::ALL[index];
        wanted.fps = wanted.fps.min(wanted.format.max_fps());
    }
    ui.add_space(6.0);
    let tip = "Frame k shows the plan at k / fps seconds, however long it takes to draw.";
    let field = Number { name: "Frames per second", unit: "", decimals: 0, per_point: 0.1, tip };
    if let Some(fps) = number_row(ui, &field, f64::from(present.fps), "frames per second") {
        wanted.fps = fps.round().max(1.0).min(f64::from(wanted.format.max_fps())) as u32;
    }
    let part: Clip = present.clip(duration_s);
    let tip = "Where the animation starts in the plan.";
    let field = Number { name: "From, s", unit: "s", decimals: 2, per_point: 0.02, tip };
    if let Some(from_s) = number_row(ui, &field, part.from_s, "from") {
        wanted.part_s[0] = from_s.max(0.0).min(part.to_s);
    }
    let tip = "Where it ends; the end of the plan at most.";
    let field = Number { name: "To, s", unit: "s", decimals: 2, per_point: 0.02, tip };
    if let Some(to_s) = number_row(ui, &field, part.to_s, "to") {
        wanted.part_s[1] = if to_s >= duration_s { f64::MAX } else { to_s.max(part.from_s) };
    }
    wanted = looks(ui, wanted, view);
    let (shot, clip) = (view.shot(&wanted), wanted.clip(duration_s));
    let text =
        format!("{} over {}", format::plural(clip.frame_count(), "frame"), format::clock(clip.to_s - clip.from_s));
    let _text = paragraph(ui, &text, SECONDARY, tokens.secondary);
    let problem = ViewerState::shot_problem(&shot).or_else(|| clip.check(duration_s).err().map(|e| e.to_string()));
    say_problem(ui, problem.as_deref());
    if buttons(ui, "Save the animation", problem.is_none(), out) {
        out.push(Command::Picture(PictureCommand::Film(shot, clip)));
    }
    if wanted != present {
        out.push(Command::Picture(PictureCommand::Settings(wanted)));
    }
}

fn scene(ui: &mut Ui, out: &mut Out) {
    let text = "Everything that the view shows as a GLB: robot and bodies in their colours as they stand now, clouds as \
                points, paths as lines. Metres; z up is turned to the y up of glTF. The plan in motion is exported at \
                the step Plan.";
    let _text = paragraph(ui, text, BODY, Tokens::of(ui).secondary);
    if buttons(ui, "Save the scene", true, out) {
        out.push(Command::Picture(PictureCommand::SaveScene));
    }
}

/// Size, background, words and colours; gives what is wanted now.
fn looks(ui: &mut Ui, present: PictureSettings, view: &View) -> PictureSettings {
    let mut wanted = present;
    section(ui, "Size");
    let chosen = SizePreset::ALL.iter().position(|preset| *preset == present.preset);
    let titles = SizePreset::ALL.map(SizePreset::title);
    let width = ui.available_width();
    if let Some(index) = dropdown(ui, "Size", present.preset.title(), width, &titles, chosen) {
        wanted = wanted.with_preset(SizePreset::ALL[index]);
    }
    ui.add_space(4.0);
    let shot = view.shot(&wanted);
    if wanted.preset == SizePreset::Own {
        let side = |ui: &mut Ui, name: &'static str, words: &str, value: u32| {
            let field = Number { name, unit: "px", decimals: 0, per_point: 4.0, tip: "Pixels of the file." };
            let side = number_row(ui, &field, f64::from(value), words);
            side.map(|side| side.round().max(1.0).min(f64::from(u16::MAX)) as u32)
        };
        if let Some(px) = side(ui, "Width, px", "wide", wanted.size_px[0]) {
            wanted.size_px[0] = px;
        }
        if let Some(px) = side(ui, "Height, px", "high", wanted.size_px[1]) {
            wanted.size_px[1] = px;
        }
    } else {
        let [w, h] = shot.size_px;
        let text = format!("{w} × {h} pixels");
        let _text = paragraph(ui, &text, SECONDARY, Tokens::of(ui).secondary);
    }
    if wanted.preset != SizePreset::View {
        let tip = "Pixels per point: how thick lines, points and words are.";
        let field = Number { name: "Scale", unit: "×", decimals: 2, per_point: 0.02, tip };
        if let Some(scale) = number_row(ui, &field, f64::from(wanted.scale), "pixels per point") {
            wanted.scale = scale as f32;
        }
    }
    section(ui, "Looks");
    if switch(ui, "Transparent background", wanted.transparent) {
        wanted.transparent = !wanted.transparent;
    }
    if switch(ui, "Labels and legends", wanted.words) {
        wanted.words = !wanted.words;
    }
    if view.dark && switch(ui, "Light colours, for paper", wanted.light) {
        wanted.light = !wanted.light;
    }
    ui.add_space(4.0);
    wanted
}

fn say_problem(ui: &mut Ui, problem: Option<&str>) {
    if let Some(problem) = problem {
        let _text = paragraph(ui, &format!("{}.", format::title_of(problem)), SECONDARY, Tokens::of(ui).coral);
    }
}

/// The two buttons; says whether the first was clicked.
fn buttons(ui: &mut Ui, save: &str, can_save: bool, out: &mut Out) -> bool {
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        let is_saved = primary_button(ui, save, can_save).clicked() && can_save;
        if secondary_button(ui, "Close", true).clicked() {
            out.push(Command::Show(Overlay::None));
        }
        is_saved
    })
    .inner
}

/// How far the animation is, and the way to give it up.
fn under_way(ui: &mut Ui, taken: usize, wanted: usize, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 30.0), Sense::hover());
    let text = format!("{} of {} pictures", format::count(taken), format::count(wanted));
    response.widget_info(|| WidgetInfo::labeled(Role::ProgressIndicator, true, format!("Animation: {text}")));
    let line = rect.with_max_y(rect.bottom() - 9.0);
    let _text = text_in(ui, line, Align::Min, &text, font(BODY), tokens.text);
    let track = Rect::from_min_max(pos2(rect.left(), rect.bottom() - 6.0), rect.max);
    ui.painter().rect_filled(track, 3.0, tokens.well);
    let share = taken as f32 / wanted.max(1) as f32;
    ui.painter().rect_filled(track.with_max_x(track.left() + share * track.width()), 3.0, tokens.teal);
    ui.add_space(10.0);
    if secondary_button(ui, "Cancel the animation", true).clicked() {
        out.push(Command::Picture(PictureCommand::Stop));
    }
}
