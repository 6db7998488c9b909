//! Moving a goal in the view: its middle moves it over the table, its ring turns it, its arrow lifts it. The same gizmo
//! without an arrow moves a receiver over the floor. With Ctrl places snap to whole centimetres of the world, and turns to
//! whole multiples of 15°.
//!
//! The gizmo has the same size on the screen from near and far.

use egui::{Align2, Color32, CursorIcon, Pos2, Rect, Response, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, vec2};
use nalgebra::{Isometry3, Point2, Point3, UnitQuaternion, Vector3};

use super::theme::{SECONDARY, Tokens, font};
use super::{Command, HandoverCommand, PlaceCommand, PlanCommand, Thing, ViewerState};
use crate::render::{Camera, Ray};

/// Radius of the ring, points.
const RING: f64 = 58.0;
/// Length of the arrow, points.
const ARROW: f64 = 88.0;
/// Where the arrow begins to be grabbed, share of its length: below is the middle.
const ARROW_FOOT: f64 = 0.28;
/// How near the pointer has to be to a line, points.
const NEAR: f32 = 8.0;
/// Radius of the middle, points.
const MIDDLE: f32 = 15.0;
/// Steps of what snaps: metres and radians.
pub(super) const SNAP: (f64, f64) = (0.01, std::f64::consts::PI / 12.0);
/// Corners of the ring.
const CORNERS: u32 = 64;

/// A part of the gizmo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Handle {
    /// Moves the goal at its height.
    Middle,
    /// Turns it about the vertical.
    Ring,
    /// Moves it up and down.
    Arrow,
}

/// What the gizmo moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Subject {
    /// The goal of a step.
    Goal(usize),
    /// Who receives the object.
    Receiver,
    /// Something that stands in the scene.
    Thing(Thing),
}

impl Subject {
    fn has_arrow(self) -> bool {
        !matches!(self, Self::Receiver)
    }

    /// `the goal of step 2`
    fn words(self) -> String {
        match self {
            Self::Goal(step) => format!("the goal of step {}", step + 1),
            Self::Receiver => "the receiver".to_owned(),
            Self::Thing(Thing::Camera) => "the camera".to_owned(),
            Self::Thing(_) => "what is selected".to_owned(),
        }
    }
}

/// The gizmo and what is held of it.
#[derive(Default)]
pub(super) struct GoalGizmo {
    held: Option<Held>,
    hovered: Option<Handle>,
}

struct Held {
    handle: Handle,
    subject: Subject,
    /// Where the subject was when it was taken up.
    X_WO: Isometry3<f64>,
    /// Where the pointer took hold: a point at its height, or on the vertical through it.
    from: Point3<f64>,
    has_moved: bool,
}

/// Where the gizmo is on the screen.
struct Placed {
    X_WO: Isometry3<f64>,
    middle: Pos2,
    ring: Vec<Pos2>,
    /// Where the object's x axis points, on the ring.
    knob: Pos2,
    arrow: Option<[Pos2; 2]>,
}

/// The picture: its rectangle and how it was taken.
#[derive(Clone, Copy)]
pub(super) struct Shot<'a> {
    pub(super) rect: Rect,
    pub(super) camera: &'a Camera,
}

impl Shot<'_> {
    fn size(&self) -> [f64; 2] {
        [f64::from(self.rect.width()), f64::from(self.rect.height())]
    }

    pub(super) fn project(&self, p_W: &Point3<f64>) -> Option<Pos2> {
        let at = self.camera.project(p_W, self.size())?;
        Some(self.rect.min + vec2(at.x as f32, at.y as f32))
    }

    /// Metres at a place that are one point on the screen.
    pub(super) fn m_per_point(&self, p_W: &Point3<f64>) -> f64 {
        self.camera.m_per_px(p_W, self.size())
    }

    pub(super) fn ray(&self, at: Pos2) -> Ray {
        let at = at - self.rect.min;
        self.camera.ray(Point2::new(f64::from(at.x), f64::from(at.y)), self.size())
    }
}

impl Placed {
    fn new(shot: Shot<'_>, subject: Subject, X_WO: &Isometry3<f64>) -> Option<Self> {
        let p_WO = Point3::from(X_WO.translation.vector);
        let m_per_point = shot.m_per_point(&p_WO);
        let on_ring = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            shot.project(&(p_WO + RING * m_per_point * Vector3::new(cos, sin, 0.0)))
        };
        let corner = |k: u32| on_ring(std::f64::consts::TAU * f64::from(k) / f64::from(CORNERS));
        let up = |share: f64| shot.project(&(p_WO + share * ARROW * m_per_point * Vector3::z()));
        Some(Self {
            X_WO: *X_WO,
            middle: shot.project(&p_WO)?,
            ring: (0..=CORNERS).map(corner).collect::<Option<_>>()?,
            knob: on_ring(X_WO.rotation.euler_angles().2)?,
            arrow: if subject.has_arrow() { Some([up(ARROW_FOOT)?, up(1.0)?]) } else { None },
        })
    }

    /// The part under the pointer.
    fn hit(&self, at: Pos2) -> Option<Handle> {
        let near = |from: Pos2, to: Pos2| distance(at, from, to) < NEAR;
        // Seen from above, the arrow is a dot in the middle.
        let arrow = self.arrow.filter(|[foot, head]| (*head - *foot).length() > 2.0 * NEAR);
        if arrow.is_some_and(|[foot, head]| near(foot, head)) {
            Some(Handle::Arrow)
        } else if (at - self.middle).length() < MIDDLE {
            Some(Handle::Middle)
        } else if self.ring.windows(2).any(|ends| near(ends[0], ends[1])) {
            Some(Handle::Ring)
        } else {
            None
        }
    }
}

/// Distance of a point from a segment.
pub(super) fn distance(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let along = to - from;
    let t = ((at - from).dot(along) / along.length_sq().max(1e-9)).max(0.0).min(1.0);
    (at - (from + t * along)).length()
}

/// Where a ray passes the vertical through a point most closely; `None` if it is nearly vertical itself.
fn on_vertical(ray: &Ray, p_W: &Point3<f64>) -> Option<Point3<f64>> {
    let to_ray = ray.origin - p_W;
    let slope = ray.direction.z;
    let sideways = 1.0 - slope * slope;
    let height_m = (to_ray.z - slope * ray.direction.dot(&to_ray)) / sideways;
    (sideways > 1e-3 && height_m.is_finite()).then(|| p_W + height_m * Vector3::z())
}

/// The goal when the pointer has moved from `from` along a handle to where a ray passes.
fn moved(handle: Handle, X_WO: &Isometry3<f64>, from: &Point3<f64>, ray: &Ray, snaps: bool) -> Option<Isometry3<f64>> {
    let p_WO = Point3::from(X_WO.translation.vector);
    let snap = |value: f64, step: f64| if snaps { (value / step).round() * step } else { value };
    let mut to = *X_WO;
    match handle {
        Handle::Middle => {
            let p_W = p_WO + (ray.meet_height(p_WO.z)? - from);
            (to.translation.x, to.translation.y) = (snap(p_W.x, SNAP.0), snap(p_W.y, SNAP.0));
        }
        Handle::Arrow => to.translation.z = snap(p_WO.z + (on_vertical(ray, &p_WO)?.z - from.z), SNAP.0),
        Handle::Ring => {
            let angle = |p: &Point3<f64>| (p.y - p_WO.y).atan2(p.x - p_WO.x);
            let turn_rad = angle(&ray.meet_height(p_WO.z)?) - angle(from);
            let yaw_rad = X_WO.rotation.euler_angles().2;
            let turn_rad = snap(yaw_rad + turn_rad, SNAP.1) - yaw_rad;
            to.rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn_rad) * to.rotation;
        }
    }
    Some(to)
}

fn taken_at(handle: Handle, X_WO: &Isometry3<f64>, ray: &Ray) -> Option<Point3<f64>> {
    let p_WO = Point3::from(X_WO.translation.vector);
    match handle {
        Handle::Middle | Handle::Ring => ray.meet_height(p_WO.z),
        Handle::Arrow => on_vertical(ray, &p_WO),
    }
}

impl GoalGizmo {
    /// Whether the pointer is the gizmo's, so that it does not move the camera.
    pub(super) fn is_busy(&self) -> bool {
        self.held.is_some() || self.hovered.is_some()
    }

    /// Follows the pointer over the view.
    pub(super) fn follow(&mut self, ui: &Ui, view: &Response, shot: Shot<'_>, state: &ViewerState) -> Vec<Command> {
        let mut commands = Vec::new();
        let Some((subject, X_WO)) = subject(state) else {
            *self = Self::default();
            return commands;
        };
        let placed = Placed::new(shot, subject, &X_WO);
        let pointer = view.hover_pos().or(view.interact_pointer_pos());
        self.hovered = placed.as_ref().zip(pointer).and_then(|(placed, at)| placed.hit(at));
        let (pressed, down) = ui.input(|input| (input.pointer.primary_pressed(), input.pointer.primary_down()));
        if let (true, Some(handle), Some(at)) = (pressed && self.held.is_none(), self.hovered, pointer) {
            let from = taken_at(handle, &X_WO, &shot.ray(at));
            self.held = from.map(|from| Held { handle, subject, X_WO, from, has_moved: false });
        }
        let Some(held) = &mut self.held else { return commands };
        if held.has_moved && !state.is_dragging_goal() {
            // Esc has put the goal back; the hand has still to let go.
            self.held = None;
            return commands;
        }
        if !down {
            if held.has_moved {
                commands.push(match held.subject {
                    Subject::Goal(_) => Command::Planning(PlanCommand::EndDrag),
                    Subject::Receiver => Command::Handover(HandoverCommand::EndDrag),
                    Subject::Thing(_) => Command::Place(PlaceCommand::EndDrag),
                });
            }
            self.held = None;
            return commands;
        }
        let (at, snaps) = ui.input(|input| (input.pointer.latest_pos(), input.modifiers.command));
        let to = at.and_then(|at| moved(held.handle, &held.X_WO, &held.from, &shot.ray(at), snaps));
        if let Some(to) = to.filter(|to| differs(to, &X_WO)) {
            held.has_moved = true;
            commands.extend(drag(held.subject, to, state));
        }
        commands
    }

    /// Draws it over the picture.
    pub(super) fn paint(&self, ui: &Ui, shot: Shot<'_>, state: &ViewerState) {
        let Some((subject, X_WO)) = subject(state) else { return };
        let Some(placed) = Placed::new(shot, subject, &X_WO) else { return };
        let tokens = Tokens::of(ui);
        let lit = self.held.as_ref().map(|held| held.handle).or(self.hovered);
        // Not in the colour of goals: the path ends here in that one.
        let ink = |handle: Handle| if lit == Some(handle) { tokens.amber } else { tokens.text };
        let width = |handle: Handle| if lit == Some(handle) { 3.5 } else { 2.25 };
        let painter = ui.painter();
        // A dark or light edge keeps it apart from whatever is behind.
        let edge = |width: f32| Stroke::new(width + 2.5, tokens.view_edge.gamma_multiply(0.55));
        for behind in [true, false] {
            let stroke = |handle: Handle| {
                if behind { edge(width(handle)) } else { Stroke::new(width(handle), ink(handle)) }
            };
            painter.add(egui::Shape::line(placed.ring.clone(), stroke(Handle::Ring)));
            if let Some(arrow) = placed.arrow {
                painter.line_segment(arrow, stroke(Handle::Arrow));
            }
        }
        let knob = ink(Handle::Ring);
        painter.circle(placed.knob, 5.5, knob, Stroke::new(1.5, tokens.view_edge));
        if let Some(arrow) = placed.arrow {
            arrow_head(ui, arrow, ink(Handle::Arrow));
        }
        let fill = tokens.amber.gamma_multiply(0.75);
        painter.circle(placed.middle, 8.0, fill, Stroke::new(width(Handle::Middle), ink(Handle::Middle)));
        painter.circle_filled(placed.middle, 2.5, ink(Handle::Middle));
        let head = placed.arrow.map(|[_, head]| ("Lift", head));
        for (name, at) in [("Move", placed.middle), ("Turn", placed.knob)].into_iter().chain(head) {
            let rect = Rect::from_center_size(at, vec2(20.0, 20.0));
            let response = ui.interact(rect, ui.scope_id().with(("goal", name)), Sense::empty());
            response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{name} {}", subject.words())));
        }
        if let Some(handle) = lit {
            ui.ctx().set_cursor_icon(if self.held.is_some() { CursorIcon::Grabbing } else { CursorIcon::Grab });
            let above = placed.arrow.map_or(placed.middle - vec2(0.0, RING as f32), |[_, head]| head);
            tell(ui, above - vec2(0.0, 20.0), &said(handle, &placed.X_WO));
        }
    }
}

/// What can be moved, and where it is: what is selected in the scene, a receiver, on the floor below it, or the goal of a step.
fn subject(state: &ViewerState) -> Option<(Subject, Isometry3<f64>)> {
    if let Some(thing) = state.selected_thing().filter(|_| state.has_gizmo()) {
        return Some((Subject::Thing(thing), thing.pose(state.scene())?));
    }
    if let Some(agent) = state.movable_receiver() {
        return Some((Subject::Receiver, agent.X_WA()));
    }
    let step = state.goal_step()?;
    Some((Subject::Goal(step), state.scene().task.steps.get(step)?.X_WO_goal))
}

/// Moves it there.
fn drag(subject: Subject, to: Isometry3<f64>, state: &ViewerState) -> Option<Command> {
    Some(match subject {
        Subject::Goal(step) => Command::Planning(PlanCommand::DragGoal { step, X_WO_goal: to }),
        Subject::Thing(thing) => Command::Place(PlaceCommand::Drag(thing, to)),
        Subject::Receiver => {
            let mut agent = state.receiver()?.clone();
            agent.position_m = [to.translation.x, to.translation.y];
            agent.yaw_rad = to.rotation.euler_angles().2;
            Command::Handover(HandoverCommand::DragReceiver(Box::new(agent)))
        }
    })
}

/// Whether two poses are told apart: a tenth of a millimetre, or of a milliradian.
pub(super) fn differs(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    (a.translation.vector - b.translation.vector).norm() > 1e-4 || a.rotation.angle_to(&b.rotation) > 1e-4
}

/// What a handle changes, in words.
fn said(handle: Handle, X_WO: &Isometry3<f64>) -> String {
    let p = X_WO.translation.vector;
    match handle {
        Handle::Middle => format!("x {:.3} m, y {:.3} m", p.x, p.y).replace('-', "–"),
        Handle::Arrow => format!("z {:.3} m", p.z).replace('-', "–"),
        Handle::Ring => format!("yaw {:.0}°", X_WO.rotation.euler_angles().2.to_degrees()).replace('-', "–"),
    }
}

pub(super) fn arrow_head(ui: &Ui, [from, to]: [Pos2; 2], color: Color32) {
    let along = to - from;
    if along.length() < 1.0 {
        return;
    }
    let (along, across) = (along.normalized(), along.normalized().rot90());
    let corners = vec![to + 9.0 * along, to + 6.0 * across, to - 6.0 * across];
    ui.painter().add(egui::Shape::convex_polygon(corners, color, Stroke::NONE));
}

pub(super) fn tell(ui: &Ui, at: Pos2, text: &str) {
    let tokens = Tokens::of(ui);
    let galley = ui.painter().layout_no_wrap(text.to_owned(), font(SECONDARY), tokens.text);
    let back = Align2::CENTER_BOTTOM.anchor_size(at, galley.size() + vec2(14.0, 6.0));
    ui.painter().rect(back, 5.0, tokens.panel, Stroke::new(1.0, tokens.amber), StrokeKind::Inside);
    ui.painter().galley(back.center() - 0.5 * galley.size(), galley, tokens.text);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn goal() -> Isometry3<f64> {
        Isometry3::from_parts(
            Vector3::new(0.6, 0.2, 0.8).into(),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.3),
        )
    }

    fn shot(camera: &Camera) -> Shot<'_> {
        Shot { rect: Rect::from_min_size(Pos2::new(40.0, 30.0), vec2(900.0, 600.0)), camera }
    }

    fn camera(distance_m: f64) -> Camera {
        Camera { target: Point3::new(0.5, 0.0, 0.8), distance_m, yaw_rad: 0.6, pitch_rad: 0.5, ..Camera::default() }
    }

    #[test]
    fn the_gizmo_has_the_same_size_from_near_and_far() {
        // Not exactly: in perspective a ring is a little larger on its near side.
        let size = |distance_m: f64| {
            let camera = camera(distance_m);
            let placed = Placed::new(shot(&camera), Subject::Goal(0), &goal()).unwrap();
            let width = placed.ring.iter().map(|at| (at.x - placed.middle.x).abs()).fold(0.0, f32::max);
            [width, (placed.arrow.unwrap()[1] - placed.middle).length()]
        };
        for (near, far) in size(1.0).into_iter().zip(size(4.0)) {
            assert!((near / far - 1.0).abs() < 0.15, "{near} against {far} points");
        }
    }

    #[test]
    fn each_handle_moves_what_it_says_and_the_goal_follows_the_pointer() {
        let camera = camera(1.6);
        let (shot, X_WO) = (shot(&camera), goal());
        let drag = |handle: Handle, to: &Isometry3<f64>, from: &Point3<f64>, at: &Point3<f64>| {
            let taken = taken_at(handle, &X_WO, &shot.ray(shot.project(from).unwrap())).unwrap();
            let found = moved(handle, &X_WO, &taken, &shot.ray(shot.project(at).unwrap()), false).unwrap();
            // A point on the screen is exact to 1e-7 of its size as f32: some micrometres.
            assert!((found.translation.vector - to.translation.vector).norm() < 2e-5, "{handle:?}: {found}");
            assert!(found.rotation.angle_to(&to.rotation) < 1e-4, "{handle:?}: {found}");
        };
        let p_WO = Point3::from(X_WO.translation.vector);
        let shift = Vector3::new(-0.11, 0.07, 0.0);
        drag(Handle::Middle, &(nalgebra::Translation3::from(shift) * X_WO), &p_WO, &(p_WO + shift));
        let up = Vector3::new(0.0, 0.0, 0.13);
        let foot = p_WO + Vector3::new(0.0, 0.0, 0.05);
        drag(Handle::Arrow, &(nalgebra::Translation3::from(up) * X_WO), &foot, &(foot + up));
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 1.1);
        let rim = Vector3::new(0.1, 0.0, 0.0);
        let turned = Isometry3::from_parts(X_WO.translation, turn * X_WO.rotation);
        drag(Handle::Ring, &turned, &(p_WO + rim), &(p_WO + turn * rim));
    }

    #[test]
    fn with_ctrl_places_are_whole_centimetres_and_turns_whole_steps() {
        let camera = camera(1.6);
        let (shot, X_WO) = (shot(&camera), goal());
        let p_WO = Point3::from(X_WO.translation.vector);
        let drag = |handle: Handle, from: Point3<f64>, to: Point3<f64>| {
            let taken = taken_at(handle, &X_WO, &shot.ray(shot.project(&from).unwrap())).unwrap();
            moved(handle, &X_WO, &taken, &shot.ray(shot.project(&to).unwrap()), true).unwrap()
        };
        let moved = drag(Handle::Middle, p_WO, p_WO + Vector3::new(-0.113, 0.067, 0.0)).translation;
        assert!((moved.vector - Vector3::new(0.49, 0.27, 0.8)).norm() < 1e-12, "{moved}");
        let lifted = drag(Handle::Arrow, p_WO, p_WO + Vector3::new(0.0, 0.0, 0.128)).translation;
        assert!((lifted.vector - Vector3::new(0.6, 0.2, 0.93)).norm() < 1e-12, "{lifted}");
        // From 0.3 rad by about a right angle: 105° is the nearest step.
        let turned = drag(Handle::Ring, p_WO + 0.1 * Vector3::x(), p_WO + 0.1 * Vector3::y());
        assert!((turned.rotation.euler_angles().2.to_degrees() - 105.0).abs() < 1e-9, "{turned}");
    }

    #[test]
    fn the_pointer_finds_each_handle_and_nothing_between_them() {
        let camera = camera(1.6);
        let placed = Placed::new(shot(&camera), Subject::Goal(0), &goal()).unwrap();
        assert_eq!(placed.hit(placed.middle), Some(Handle::Middle));
        assert_eq!(placed.hit(placed.knob), Some(Handle::Ring));
        let [_, head] = placed.arrow.unwrap();
        assert_eq!(placed.hit(head), Some(Handle::Arrow));
        let on_floor = Placed::new(shot(&camera), Subject::Receiver, &goal()).unwrap();
        assert_eq!(on_floor.hit(head), None, "nobody lifts a receiver");
        let between = placed.middle + 0.6 * (placed.knob - placed.middle);
        assert_eq!(placed.hit(between), None);
    }
}
