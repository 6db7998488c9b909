//! Leading the hands of a posed robot in the view: a dot at every hand, and at the chosen one arrows and rings as well.
//!
//! The dot moves a hand across the view, an arrow along an axis, a ring turns it about one. With Ctrl a hand snaps to
//! centimetres and to 15°. All of it has the same size on the screen from near and far.

use egui::{Color32, CursorIcon, Pos2, Rect, Response, Role, Sense, Shape, Stroke, Ui, WidgetInfo, vec2};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::goal_gizmo::{SNAP, Shot, arrow_head, differs, distance, tell};
use super::theme::{SMALL, Tokens, font};
use super::{Command, LedHand, PoseCommand, ViewerState};
use crate::render::Ray;

/// Radius of the rings, points.
const RING: f64 = 62.0;
/// Where an arrow begins and ends, points from the hand.
const ARROW: [f64; 2] = [20.0, 96.0];
/// How near the pointer has to be to an arrow, and to a ring, points.
const NEAR: [f32; 2] = [8.0, 6.0];
/// Radius within which a dot is grabbed, points.
const DOT: f32 = 15.0;
/// Corners of a ring.
const CORNERS: u32 = 64;
/// A ring seen so nearly from its edge that the pointer cannot turn it: cosine.
const EDGE_ON: f64 = 0.12;
/// What a person calls the axes.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// A part of the gizmo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Handle {
    /// Moves the hand across the view.
    Dot,
    /// Moves it along an axis.
    Arrow(usize),
    /// Turns it about an axis.
    Ring(usize),
}

/// The gizmo and what is held of it.
#[derive(Default)]
pub(super) struct HandGizmo {
    held: Option<Held>,
    hovered: Option<(usize, Handle)>,
}

struct Held {
    arm: usize,
    handle: Handle,
    /// Where the handle was when it was taken up, and its axes.
    X_WH: Isometry3<f64>,
    axes: [Vector3<f64>; 3],
    from: Point3<f64>,
    has_moved: bool,
}

/// Where a hand's gizmo is on the screen.
struct Placed {
    dot: Pos2,
    arrows: [Option<[Pos2; 2]>; 3],
    rings: [Vec<Pos2>; 3],
}

/// Axes along which a hand is moved, in the world.
fn axes(state: &ViewerState, X_WH: &Isometry3<f64>) -> [Vector3<f64>; 3] {
    let own = [Vector3::x(), Vector3::y(), Vector3::z()];
    if state.posing.along_hand { own.map(|axis| X_WH.rotation * axis) } else { own }
}

impl Placed {
    /// * `is_whole`: with arrows and rings.
    fn new(shot: Shot<'_>, X_WH: &Isometry3<f64>, axes: &[Vector3<f64>; 3], is_whole: bool) -> Option<Self> {
        let p_W = Point3::from(X_WH.translation.vector);
        let dot = shot.project(&p_W)?;
        if !is_whole {
            return Some(Self { dot, arrows: [None; 3], rings: Default::default() });
        }
        let m_per_point = shot.m_per_point(&p_W);
        let along = |axis: &Vector3<f64>, points: f64| shot.project(&(p_W + points * m_per_point * axis));
        let arrow = |axis: &Vector3<f64>| Some([along(axis, ARROW[0])?, along(axis, ARROW[1])?]);
        let ring = |k: usize| {
            let (u, v) = (axes[(k + 1) % 3], axes[(k + 2) % 3]);
            let corner = |corner: u32| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(corner) / f64::from(CORNERS)).sin_cos();
                shot.project(&(p_W + RING * m_per_point * (cos * u + sin * v)))
            };
            (0..=CORNERS).map(corner).collect::<Option<Vec<_>>>().unwrap_or_default()
        };
        // An arrow that points at the eye is a dot, and lies over the dot.
        let arrows = [0, 1, 2].map(|k| arrow(&axes[k]).filter(|[from, to]| (*to - *from).length() > 18.0));
        Some(Self { dot, arrows, rings: [0, 1, 2].map(ring) })
    }

    /// The part under the pointer.
    fn hit(&self, at: Pos2) -> Option<Handle> {
        if (at - self.dot).length() < DOT {
            return Some(Handle::Dot);
        }
        let arrows = self.arrows.iter().enumerate().filter_map(|(k, arrow)| {
            let [from, to] = (*arrow)?;
            Some((distance(at, from, to) / NEAR[0], Handle::Arrow(k)))
        });
        let rings = self.rings.iter().enumerate().filter_map(|(k, ring)| {
            let least = ring.windows(2).map(|ends| distance(at, ends[0], ends[1])).min_by(f32::total_cmp)?;
            Some((least / NEAR[1], Handle::Ring(k)))
        });
        let near = arrows.chain(rings).filter(|(share, _)| *share < 1.0);
        near.min_by(|l, r| l.0.total_cmp(&r.0)).map(|(_, handle)| handle)
    }
}

/// Where the pointer takes hold of a handle, or has brought it: a point on the handle's plane or line.
fn taken_at(
    handle: Handle,
    X_WH: &Isometry3<f64>,
    axes: &[Vector3<f64>; 3],
    shot: Shot<'_>,
    ray: &Ray,
) -> Option<Point3<f64>> {
    let p_W = Point3::from(X_WH.translation.vector);
    match handle {
        Handle::Dot => meet_plane(ray, &p_W, &shot.camera.backward(), 0.05),
        Handle::Arrow(k) => on_line(ray, &p_W, &axes[k]),
        Handle::Ring(k) => meet_plane(ray, &p_W, &axes[k], EDGE_ON),
    }
}

/// Where a ray meets the plane through a point; `None` if it runs along it, the sine between them below `least`.
fn meet_plane(ray: &Ray, p_W: &Point3<f64>, normal: &Vector3<f64>, least: f64) -> Option<Point3<f64>> {
    let slope = ray.direction.dot(normal);
    let along = (p_W - ray.origin).dot(normal) / slope;
    (slope.abs() > least && along.is_finite()).then(|| ray.at(along))
}

/// Where a ray passes a line most closely; `None` if they run side by side.
fn on_line(ray: &Ray, p_W: &Point3<f64>, axis: &Vector3<f64>) -> Option<Point3<f64>> {
    let to_ray = ray.origin - p_W;
    let slope = ray.direction.dot(axis);
    let sideways = 1.0 - slope * slope;
    let along = (to_ray.dot(axis) - slope * ray.direction.dot(&to_ray)) / sideways;
    (sideways > 1e-3 && along.is_finite()).then(|| p_W + along * axis)
}

impl Held {
    /// The pose of the hand when the pointer has come to `to`.
    fn moved(&self, to: &Point3<f64>, snaps: bool) -> Isometry3<f64> {
        let snap = |value: f64, step: f64| if snaps { (value / step).round() * step } else { value };
        match self.handle {
            Handle::Dot => {
                let shift = (to - self.from).map(|value| snap(value, SNAP.0));
                Translation3::from(shift) * self.X_WH
            }
            Handle::Arrow(k) => {
                let along = snap((to - self.from).dot(&self.axes[k]), SNAP.0);
                Translation3::from(along * self.axes[k]) * self.X_WH
            }
            Handle::Ring(k) => {
                let (u, v) = (self.axes[(k + 1) % 3], self.axes[(k + 2) % 3]);
                let center = Point3::from(self.X_WH.translation.vector);
                let angle = |p: &Point3<f64>| (p - center).dot(&v).atan2((p - center).dot(&u));
                let turn = UnitQuaternion::new(snap(angle(to) - angle(&self.from), SNAP.1) * self.axes[k]);
                Isometry3::from_parts(self.X_WH.translation, turn * self.X_WH.rotation)
            }
        }
    }
}

impl HandGizmo {
    /// Whether the pointer is the gizmo's, so that it does not move the camera.
    pub(super) fn is_busy(&self) -> bool {
        self.held.is_some() || self.hovered.is_some()
    }

    /// Follows the pointer over the view.
    pub(super) fn follow(&mut self, ui: &Ui, view: &Response, shot: Shot<'_>, state: &ViewerState) -> Vec<Command> {
        let hands = state.led_hands();
        if hands.is_empty() {
            *self = Self::default();
            return Vec::new();
        }
        let pointer = view.hover_pos().or(view.interact_pointer_pos());
        // The chosen hand lies on top.
        let on_top = |hand: &&LedHand| hand.arm != state.posing.arm;
        let mut order: Vec<&LedHand> = hands.iter().collect();
        order.sort_by_key(on_top);
        self.hovered = order.iter().find_map(|hand| {
            let placed = placed(shot, hand, state)?;
            Some((hand.arm, placed.hit(pointer?)?))
        });
        let (pressed, down) = ui.input(|input| (input.pointer.primary_pressed(), input.pointer.primary_down()));
        let mut commands = Vec::new();
        if let (true, Some((arm, handle)), Some(at)) = (pressed && self.held.is_none(), self.hovered, pointer)
            && let Some(hand) = hands.iter().find(|hand| hand.arm == arm)
        {
            let X_WH = hand.handle();
            let axes = axes(state, &X_WH);
            let from = taken_at(handle, &X_WH, &axes, shot, &shot.ray(at));
            self.held = from.map(|from| Held { arm, handle, X_WH, axes, from, has_moved: false });
            commands.push(Command::Pose(PoseCommand::Arm(arm)));
        }
        let Some(held) = &mut self.held else { return commands };
        if held.has_moved && !state.is_dragging_goal() {
            // Esc has put the hand back; the pointer has still to let go.
            self.held = None;
            return commands;
        }
        if !down {
            if held.has_moved {
                commands.push(Command::Pose(PoseCommand::EndDrag));
            }
            self.held = None;
            return commands;
        }
        let (at, snaps) = ui.input(|input| (input.pointer.latest_pos(), input.modifiers.command));
        let to = at.and_then(|at| taken_at(held.handle, &held.X_WH, &held.axes, shot, &shot.ray(at)));
        let now = hands.iter().find(|hand| hand.arm == held.arm).map(LedHand::handle);
        let to = to.map(|to| held.moved(&to, snaps));
        if let (Some(to), Some(now)) = (to, now)
            && differs(&to, &now)
        {
            held.has_moved = true;
            commands.push(Command::Pose(PoseCommand::Lead(held.arm, to)));
        }
        commands
    }

    /// Draws it over the picture.
    pub(super) fn paint(&self, ui: &Ui, shot: Shot<'_>, state: &ViewerState) {
        let lit = self.held.as_ref().map(|held| (held.arm, held.handle)).or(self.hovered);
        let hands = state.led_hands();
        let placed: Vec<_> = hands.iter().filter_map(|hand| Some((hand, placed(shot, hand, state)?))).collect();
        let lit_of = |hand: &LedHand| lit.filter(|(arm, _)| *arm == hand.arm).map(|(_, handle)| handle);
        for (hand, placed) in &placed {
            paint_one(ui, hand, placed, lit_of(hand));
        }
        if lit.is_some() {
            ui.ctx().set_cursor_icon(if self.held.is_some() { CursorIcon::Grabbing } else { CursorIcon::Grab });
        }
        // Over the gizmos of both hands.
        for (hand, placed) in &placed {
            if let Some(handle) = lit_of(hand) {
                tell(ui, placed.dot - vec2(0.0, ARROW[1] as f32 + 16.0), &said(hand, handle));
            }
        }
    }
}

fn placed(shot: Shot<'_>, hand: &LedHand, state: &ViewerState) -> Option<Placed> {
    let X_WH = hand.handle();
    Placed::new(shot, &X_WH, &axes(state, &X_WH), hand.arm == state.posing.arm)
}

/// What a handle does and where the hand is, in words.
fn said(hand: &LedHand, handle: Handle) -> String {
    let p = hand.handle().translation.vector;
    let place = format!("{:.3}, {:.3}, {:.3} m", p.x, p.y, p.z).replace('-', "–");
    let what = match handle {
        Handle::Dot => "move".to_owned(),
        Handle::Arrow(k) => format!("move along {}", AXES[k]),
        Handle::Ring(k) => format!("turn about {}", AXES[k]),
    };
    match &hand.target {
        Some(target) => format!("{} hand: {}", hand.name, target.reason),
        None => format!("{} hand, {what}: {place}", hand.name),
    }
}

fn paint_one(ui: &Ui, hand: &LedHand, placed: &Placed, lit: Option<Handle>) {
    let tokens = Tokens::of(ui);
    let painter = ui.painter();
    let own = [tokens.coral, tokens.teal, tokens.blue];
    let ink = |handle: Handle, own: Color32| if lit == Some(handle) { tokens.amber } else { own };
    let width = |handle: Handle| if lit == Some(handle) { 3.5 } else { 2.0 };
    let edge = |width: f32| Stroke::new(width + 2.5, tokens.view_edge.gamma_multiply(0.5));
    for (k, ring) in placed.rings.iter().enumerate() {
        let handle = Handle::Ring(k);
        painter.add(Shape::line(ring.clone(), edge(width(handle))));
        let soft = if lit == Some(handle) { 1.0 } else { 0.8 };
        painter.add(Shape::line(ring.clone(), Stroke::new(width(handle), ink(handle, own[k]).gamma_multiply(soft))));
    }
    for (k, arrow) in placed.arrows.iter().enumerate() {
        let (handle, Some(arrow)) = (Handle::Arrow(k), *arrow) else { continue };
        painter.line_segment(arrow, edge(width(handle)));
        painter.line_segment(arrow, Stroke::new(width(handle), ink(handle, own[k])));
        arrow_head(ui, arrow, ink(handle, own[k]));
        let beyond = arrow[1] + 12.0 * (arrow[1] - arrow[0]).normalized();
        let _rect = painter.text(beyond, egui::Align2::CENTER_CENTER, AXES[k], font(SMALL), ink(handle, own[k]));
    }
    let fill = if hand.target.is_some() { tokens.coral } else { tokens.amber };
    let radius = if lit == Some(Handle::Dot) { 9.5 } else { 8.0 };
    painter.circle(placed.dot, radius, fill.gamma_multiply(0.8), Stroke::new(2.0, tokens.text));
    let rect = Rect::from_center_size(placed.dot, vec2(22.0, 22.0));
    let response = ui.interact(rect, ui.scope_id().with(("hand", hand.arm)), Sense::empty());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("Lead the {} hand", hand.name)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Camera;

    fn held(handle: Handle) -> Held {
        let X_WH = Isometry3::from_parts(
            Vector3::new(0.5, 0.1, 0.9).into(),
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.4),
        );
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        Held { arm: 0, handle, X_WH, axes, from: Point3::new(0.5, 0.1, 0.9), has_moved: false }
    }

    #[test]
    fn each_handle_moves_along_or_about_its_own_axis_and_snaps_when_asked_to() {
        let mut arrow = held(Handle::Arrow(2));
        let to = Point3::new(0.62, 0.3, 0.974);
        let moved = arrow.moved(&to, false).translation.vector - arrow.X_WH.translation.vector;
        assert!((moved - Vector3::new(0.0, 0.0, 0.074)).norm() < 1e-12, "{moved}");
        let snapped = arrow.moved(&to, true).translation.vector - arrow.X_WH.translation.vector;
        assert!((snapped - Vector3::new(0.0, 0.0, 0.07)).norm() < 1e-12, "{snapped}");
        arrow.handle = Handle::Ring(1);
        arrow.from = Point3::new(0.6, 0.1, 0.9);
        // From x towards z is a turn about minus y.
        let turned = arrow.moved(&Point3::new(0.5, 0.1, 1.0), false);
        let turn = turned.rotation * arrow.X_WH.rotation.inverse();
        let wanted = UnitQuaternion::new(Vector3::new(0.0, -std::f64::consts::FRAC_PI_2, 0.0));
        assert!(turn.angle_to(&wanted) < 1e-9, "{turn}");
        assert_eq!(turned.translation, arrow.X_WH.translation);
    }

    #[test]
    fn the_pointer_finds_dot_arrows_and_rings_and_the_dot_alone_of_a_hand_that_is_not_chosen() {
        let camera = Camera {
            target: Point3::new(0.5, 0.0, 0.9),
            distance_m: 1.6,
            yaw_rad: 0.6,
            pitch_rad: 0.5,
            ..Camera::default()
        };
        let shot = Shot { rect: Rect::from_min_size(Pos2::new(40.0, 30.0), vec2(900.0, 600.0)), camera: &camera };
        let hand = held(Handle::Dot);
        let whole = Placed::new(shot, &hand.X_WH, &hand.axes, true).unwrap();
        assert_eq!(whole.hit(whole.dot), Some(Handle::Dot));
        for k in 0..3 {
            let [_, head] = whole.arrows[k].unwrap();
            assert_eq!(whole.hit(head), Some(Handle::Arrow(k)));
            let on_ring = whole.rings[k].iter().filter(|at| whole.hit(**at) == Some(Handle::Ring(k)));
            assert!(on_ring.count() > 24, "ring {k} can hardly be found");
        }
        let alone = Placed::new(shot, &hand.X_WH, &hand.axes, false).unwrap();
        let [_, head] = whole.arrows[0].unwrap();
        assert_eq!((alone.hit(alone.dot), alone.hit(head)), (Some(Handle::Dot), None));
    }
}
