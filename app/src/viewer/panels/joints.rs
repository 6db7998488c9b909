//! Joints over time: small plots of every joint, or everything of one, under the time cursor.

use egui::{Align, Align2, Color32, Pos2, Rect, Role, Sense, Shape, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::task::Plan;

use super::Out;
use super::plan::color;
use super::save_menu::save_button;
use crate::assets;
use crate::export::{PlotKind, TableKind};
use crate::viewer::fields::dropdown;
use crate::viewer::joint_curves::{ArmJoint, samples, value_at};
use crate::viewer::theme::{BODY, SECONDARY, SMALL, SMALL_RADIUS, Tokens, font, strong};
use crate::viewer::widgets::{paragraph, segmented_wide, text_in};
use crate::viewer::{Command, Curve, PlanCommand, ViewerState, format, playback};

/// Height of the plot of one among many joints, points.
const SMALL_PLOT: f32 = 28.0;
/// Height of a plot of a single joint, points.
const LARGE_PLOT: f32 = 96.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, plan: &Plan, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let Ok(robot) = assets::library().robot_of(&state.document.scene) else { return };
    let joints = ArmJoint::of(plan, &robot, &state.document.scene, state.arm_joint_count());
    if joints.is_empty() {
        let text = "This plan belongs to another robot or hand; its joints are shown again once the new plan stands.";
        let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
        return;
    }
    ui.add_space(4.0);
    let single = state.planning.joint.filter(|&joint| joint < joints.len());
    let mut rows = vec!["All joints"];
    rows.extend(joints.iter().map(|joint| joint.name.as_str()));
    let chosen = single.map_or(0, |joint| joint + 1);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        if let Some(row) = dropdown(ui, "Joint", rows[chosen], ui.available_width() - 32.0, &rows, Some(chosen)) {
            out.push(Command::Planning(PlanCommand::PlotJoint(row.checked_sub(1))));
        }
        save_button(ui, TableKind::Joints, Some(PlotKind::Joints(state.planning.curve)), out);
    });
    ui.add_space(6.0);
    let view = View { state, plan, joints: &joints };
    match single {
        Some(joint) => {
            for curve in Curve::ALL {
                view.plot(ui, joint, curve, LARGE_PLOT, curve.title(), out);
            }
        }
        None => {
            let chosen = Curve::ALL.iter().position(|&curve| curve == state.planning.curve);
            if let Some(index) = segmented_wide(ui, "Plotted", &Curve::ALL.map(Curve::title), chosen) {
                out.push(Command::Planning(PlanCommand::Plot(Curve::ALL[index])));
            }
            ui.add_space(4.0);
            for (joint, about) in joints.iter().enumerate() {
                view.plot(ui, joint, state.planning.curve, SMALL_PLOT, &about.name, out);
            }
        }
    }
    let sentence = "Coral lines are the limits, those of speed and acceleration times the plan's scale. \
                    Drag in a plot to move through time.";
    let _text = paragraph(ui, sentence, SECONDARY, tokens.secondary);
}

/// What all plots share.
struct View<'a> {
    state: &'a ViewerState,
    plan: &'a Plan,
    joints: &'a [ArmJoint],
}

impl View<'_> {
    /// A plot with its title and the value under the cursor above it.
    fn plot(&self, ui: &mut Ui, joint: usize, curve: Curve, height: f32, title: &str, out: &mut Out) {
        let tokens = Tokens::of(ui);
        let about = &self.joints[joint];
        let (unit, per_si) = about.unit(curve);
        let values = samples(self.plan, joint, curve);
        let (lower, upper) = about.limits[curve as usize];
        let now_s = self.state.playback.time_s;
        let number = |value: f64| {
            let apart = if unit == "°" { "" } else { "\u{2009}" };
            format!("{:.1}{apart}{unit}", per_si * value).replace('-', "–")
        };
        let said = value_at(&values, now_s).map_or_else(String::new, number);

        let (head, _) = ui.allocate_exact_size(vec2(ui.available_width(), 17.0), Sense::hover());
        let _text = text_in(ui, head, Align::Min, title, font(SECONDARY), tokens.secondary);
        let at = head.right_center();
        let _rect = ui.painter().text(at, Align2::RIGHT_CENTER, &said, strong(SECONDARY), tokens.text);
        let (area, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click_and_drag());
        ui.add_space(3.0);
        response.widget_info(|| {
            let limits = format!("from {} to {}", number(lower), number(upper));
            let text = format!("{} of {}: {said}, limits {limits}", curve.title(), about.name);
            WidgetInfo::labeled(Role::Label, true, text)
        });
        let [top, bottom] = self.paint(ui, area, &values, (lower, upper));
        if height > SMALL_PLOT {
            axis(ui, [(top, number(upper)), (bottom, number(lower))], tokens.secondary);
        }
        self.scrub(&response, area, out);
        if let Some(pointer) = response.hover_pos() {
            let time_s = self.time_of(area, pointer.x);
            ui.painter().vline(self.x_of(area, time_s), area.y_range(), Stroke::new(1.0, tokens.faint));
            let _tip = response.on_hover_ui_at_pointer(|ui| self.tell(ui, joint, time_s));
        }
    }

    fn x_of(&self, area: Rect, time_s: f64) -> f32 {
        let u = time_s / self.state.duration_s().max(1e-9);
        area.left() + area.width() * u.max(0.0).min(1.0) as f32
    }

    fn time_of(&self, area: Rect, x: f32) -> f64 {
        f64::from((x - area.left()) / area.width().max(1.0)).max(0.0).min(1.0) * self.state.duration_s()
    }

    fn scrub(&self, response: &egui::Response, area: Rect, out: &mut Out) {
        if (response.is_pointer_button_down_on() || response.clicked())
            && let Some(pointer) = response.interact_pointer_pos()
        {
            if self.state.playback.playing {
                out.push(Command::SetPlaying(false));
            }
            out.push(Command::Seek(self.time_of(area, pointer.x)));
        }
    }

    /// Limits, phases, the curve, the cursor; gives where the lines of the upper and the lower limit begin.
    fn paint(&self, ui: &Ui, area: Rect, values: &[(f64, f64)], (lower, upper): (f64, f64)) -> [Pos2; 2] {
        let tokens = Tokens::of(ui);
        let painter = ui.painter().with_clip_rect(area.expand(4.0));
        painter.rect(area, SMALL_RADIUS - 2, tokens.well, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
        // The limits are in the picture with a little room beyond them, and so is whatever breaks them.
        let (low, high) = values.iter().fold((lower, upper), |(low, high), &(_, v)| (low.min(v), high.max(v)));
        let room = 0.06 * (high - low).max(1e-9);
        let (low, high) = (low - room, high + room);
        let y_of = |value: f64| area.bottom() - area.height() * ((value - low) / (high - low)) as f32;
        if low < 0.0 && high > 0.0 {
            painter.hline(area.x_range(), y_of(0.0), Stroke::new(1.0, tokens.line));
        }
        for limit in [lower, upper] {
            let ends = [pos2(area.left(), y_of(limit)), pos2(area.right(), y_of(limit))];
            painter.extend(Shape::dashed_line(&ends, Stroke::new(1.0, tokens.coral), 4.0, 3.0));
        }
        for phase in &self.plan.phases {
            let ends = [phase.start_s, phase.start_s + phase.trajectory.duration_s()].map(|t| self.x_of(area, t));
            let strip = Rect::from_x_y_ranges(ends[0] + 0.5..=ends[1] - 0.5, area.bottom() + 0.5..=area.bottom() + 3.0);
            painter.rect_filled(strip, 0.0, color(phase.kind, tokens));
        }
        let is_old = self.state.is_stale(endcomfort_core::job::Stage::Plan);
        let ink = if is_old { tokens.faint } else { tokens.teal };
        let mut points: Vec<Pos2> = Vec::new();
        for &(t, value) in values {
            let point = pos2(self.x_of(area, t), y_of(value));
            // Half a pixel apart is enough, unless the value leaps.
            if points.last().is_none_or(|last| point.x - last.x >= 0.5 || (point.y - last.y).abs() >= 1.0) {
                points.push(point);
            }
        }
        painter.add(Shape::line(points, Stroke::new(1.5, ink)));
        let now_s = self.state.playback.time_s;
        let x = self.x_of(area, now_s);
        painter.vline(x, area.y_range(), Stroke::new(1.5, tokens.text));
        if let Some(value) = value_at(values, now_s) {
            painter.circle_filled(pos2(x, y_of(value)), 3.0, tokens.text);
        }
        [upper, lower].map(|limit| pos2(area.left(), y_of(limit)))
    }

    /// All numbers of a joint at a time.
    fn tell(&self, ui: &mut Ui, joint: usize, time_s: f64) {
        let tokens = Tokens::of(ui);
        let about = &self.joints[joint];
        let phase = playback::phase_at(self.plan, time_s).map_or("", |phase| phase.kind.name());
        let line = |ui: &mut Ui, text: String, ink: Color32| {
            let _text = ui.label(egui::RichText::new(text).font(font(SECONDARY)).color(ink));
        };
        let _name = ui.label(egui::RichText::new(&about.name).font(strong(BODY)).color(tokens.text));
        line(ui, format!("{} · {phase}", format::clock(time_s)), tokens.secondary);
        for curve in Curve::ALL {
            let (unit, per_si) = about.unit(curve);
            let (lower, upper) = about.limits[curve as usize];
            let value = value_at(&samples(self.plan, joint, curve), time_s).unwrap_or(f64::NAN);
            let limits = if curve == Curve::Position {
                format!("{:.0} … {:.0}", per_si * lower, per_si * upper)
            } else {
                format!("±{:.0}", per_si * upper)
            };
            let text = format!("{} {:.1} {unit} of {limits}", curve.title(), per_si * value);
            line(ui, text.replace('-', "–"), tokens.text);
        }
    }
}

/// The limits in numbers, each on the inner side of its line.
fn axis(ui: &Ui, [(top, upper), (bottom, lower)]: [(Pos2, String); 2], ink: Color32) {
    let inward = vec2(5.0, 2.0);
    let _rect = ui.painter().text(top + inward, Align2::LEFT_TOP, upper, font(SMALL), ink);
    let _rect = ui.painter().text(bottom + vec2(5.0, -2.0), Align2::LEFT_BOTTOM, lower, font(SMALL), ink);
}
