//! Drawing a region in the view: a drag from corner to corner over the object.

use egui::{CursorIcon, Pos2, Rect, Response, Stroke, StrokeKind, Ui, pos2, vec2};
use nalgebra::Point2;

use super::layout::Layout;
use super::theme::{BODY, Tokens, font};
use super::{Command, GraspCommand, ViewerState};
use crate::render::Camera;

/// A shorter drag than this is a slip of the hand, points.
const SHORTEST: f32 = 6.0;

/// The drag that draws a region.
#[derive(Default)]
pub(super) struct RegionDrag {
    from: Option<Pos2>,
}

impl RegionDrag {
    /// Follows the pointer over the picture's rectangle and draws the frame; gives the command of a drag that ended.
    pub(super) fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        rect: Rect,
        camera: &Camera,
        state: &ViewerState,
    ) -> Option<Command> {
        ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
        let pointer = response.interact_pointer_pos();
        if response.drag_started() {
            // The drag is noticed some points after it began.
            self.from = ui.input(|input| input.pointer.press_origin()).or(pointer);
        }
        let (from, to) = (self.from?, pointer?);
        if response.drag_stopped() {
            self.from = None;
            if (to - from).length() < SHORTEST {
                return None;
            }
            let size = [f64::from(rect.width()), f64::from(rect.height())];
            let corners = [from, to].map(|at| Point2::new(f64::from(at.x - rect.left()), f64::from(at.y - rect.top())));
            let region = state.region_between(camera, corners, size)?;
            return Some(Command::Grasping(GraspCommand::SetRegion(region)));
        }
        let tokens = Tokens::of(ui);
        let frame = Rect::from_two_pos(from, to);
        let stroke = Stroke::new(1.5, tokens.blue);
        ui.painter().rect(frame, 2.0, tokens.blue.gamma_multiply(0.14), stroke, StrokeKind::Inside);
        None
    }

    /// What to do, high in the free part of the view.
    pub(super) fn hint(&self, ui: &Ui, layout: &Layout) {
        let tokens = Tokens::of(ui);
        let words = "Drag from corner to corner over the object. Esc leaves it.";
        let galley = ui.painter().layout_no_wrap(words.to_owned(), font(BODY), tokens.text);
        let middle = pos2(layout.free.center().x, layout.free.top() + 34.0);
        let back = Rect::from_center_size(middle, galley.size() + vec2(24.0, 14.0));
        ui.painter().rect(back, 8.0, tokens.panel, Stroke::new(1.0, tokens.blue), StrokeKind::Inside);
        ui.painter().galley(back.center() - 0.5 * galley.size(), galley, tokens.text);
    }
}
