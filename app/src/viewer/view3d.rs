//! The 3D view: the renderer's picture over the whole page, the hand on the camera, and the words on top.
//!
//! A picture is composed only when its [`ViewKey`] changed, and drawn only when it, the camera, the size or the theme
//! changed; time runs here only while the camera travels.

use egui::{Color32, PointerButton, Pos2, Rect, Response, Sense, Stroke, StrokeKind, Ui, Vec2, pos2, vec2};
use egui_wgpu::RenderState;
use endcomfort_core::job::Stage;
use nalgebra::{Matrix3, Point2, Point3};

use super::goal_gizmo::{GoalGizmo, Shot};
use super::hand_gizmo::HandGizmo;
use super::layout::Layout;
use super::region_drag::RegionDrag;
use super::state::Step;
use super::theme::{SECONDARY, Tokens, font};
use super::{
    Command, GraspCommand, HandoverCommand, Label, LookCommand, Pick, Picture, PlaceCommand, PoseCommand, ReachCommand,
    Studio, Thing, Tone, Turning, ViewCommand, ViewEffect, ViewKey, ViewerState, flying, legends, measuring, tips,
};
use crate::render::{Bounds, BoundsCache, Camera, Cut, Picker, Quality, Renderer, Target, Theme, View};

/// Radians per point of dragging: a drag over 600 points turns by half a turn.
const TURN: f64 = std::f64::consts::PI / 600.0;
/// How long everything has to be still before a draft is drawn in full, seconds.
const SETTLE_S: f64 = 0.2;
/// How long the camera travels to a named view, seconds.
const TRAVEL_S: f64 = 0.35;

/// The camera closes most of the distance to a followed object in this time, seconds.
const FOLLOW_S: f64 = 0.35;
/// As near as this it has arrived, metres.
const FOLLOWED_M: f64 = 5e-4;

/// Share of the free part of the view that a whole scene fills.
const FILLED: f64 = 0.90;

/// What is looked at alone is seen from as near as this, metres.
const CLOSE_M: f64 = 0.9;

/// An examined fit is seen from beside its sensor: what was measured, and how it goes on where nothing was.
const BESIDE_SENSOR_RAD: f64 = 0.75;
/// … and from a little above.
const LAB_PITCH_RAD: f64 = 0.38;

/// The view and everything that it keeps between frames.
pub(super) struct View3d {
    gpu: RenderState,
    renderer: Renderer,
    /// What this adapter can draw on every frame.
    while_moving: Quality,
    /// When a draft is to be drawn once more in full, if nothing moves until then.
    settles_at_s: Option<f64>,
    target: Target,
    texture: egui::TextureId,
    camera: Camera,
    travel: Option<Travel>,
    picture: Picture,
    composed: Option<ViewKey>,
    drawn: Option<Drawn>,
    picker: Picker,
    bounds: BoundsCache,
    /// The point that a drag holds.
    anchor: Option<Point3<f64>>,
    wants_frame: bool,
    was_framed: bool,
    /// The examined cluster that the camera went to, and whether it looks at its rejected points.
    examined: Option<(usize, bool)>,
    /// Where the camera stood before it went there.
    before_lab: Option<Camera>,
    /// The drag that draws a region.
    region: RegionDrag,
    /// The drag that moves a goal.
    gizmo: GoalGizmo,
    /// The drag that leads a hand.
    hands: HandGizmo,
    /// The next frame is taken from the side of this place.
    wants_side: Option<Point3<f64>>,
    /// Where the camera is put with the next picture, instead of framing anything.
    placed: Option<Camera>,
    /// Width of the part that the panels leave free, over the height of the picture.
    free_aspect: f64,
}

/// A camera on its way.
struct Travel {
    from: Camera,
    to: Camera,
    passed_s: f64,
}

/// Brings the camera so near that points fill a picture, their outline in the middle.
fn fill(camera: &mut Camera, points: &[Point3<f64>], size: [f64; 2]) {
    // In perspective each step leaves an error, smaller than the one before.
    for _ in 0..6 {
        let seen: Vec<_> = points.iter().filter_map(|point| camera.project(point, size)).collect();
        let Some((mut low, mut high)) = seen.first().map(|at| (at.coords, at.coords)) else { return };
        for at in &seen {
            (low, high) = (low.inf(&at.coords), high.sup(&at.coords));
        }
        let m_per_px = camera.m_per_px(&camera.target, size);
        let middle = 0.5 * (low + high) - nalgebra::Vector2::new(0.5 * size[0], 0.5 * size[1]);
        camera.target += m_per_px * (middle.x * camera.right() - middle.y * camera.up());
        let share = ((high.x - low.x) / size[0]).max((high.y - low.y) / size[1]);
        camera.distance_m *= (share / FILLED).max(0.5).min(2.0);
    }
}

/// Where the cloud was seen from.
fn sensor(state: &ViewerState) -> Option<Point3<f64>> {
    let X_WC = state.outputs.scene.as_ref()?.cloud.X_FC?;
    Some(X_WC.translation.vector.into())
}

/// What the texture shows.
#[derive(PartialEq)]
struct Drawn {
    camera: Camera,
    size_px: [u32; 2],
    theme: Theme,
    cut: Option<Cut>,
}

impl View3d {
    /// A view that draws with the window's or the page's device.
    pub(super) fn new(gpu: &RenderState) -> Self {
        let renderer = Renderer::new(&gpu.device, &gpu.queue);
        let target = Target::new(&gpu.device, [1, 1]);
        let texture =
            gpu.renderer.write().register_native_texture(&gpu.device, target.color_view(), wgpu::FilterMode::Linear);
        Self {
            gpu: gpu.clone(),
            renderer,
            while_moving: Quality::while_moving(&gpu.adapter.get_info()),
            settles_at_s: None,
            target,
            texture,
            camera: Camera::default(),
            travel: None,
            picture: Picture::default(),
            composed: None,
            drawn: None,
            picker: Picker::default(),
            bounds: BoundsCache::default(),
            anchor: None,
            wants_frame: true,
            was_framed: false,
            examined: None,
            before_lab: None,
            region: RegionDrag::default(),
            gizmo: GoalGizmo::default(),
            hands: HandGizmo::default(),
            wants_side: None,
            placed: None,
            free_aspect: 1.0,
        }
    }

    /// Moves the camera as it was asked for; the hand stays free to take over on the way.
    pub(super) fn go(&mut self, effect: ViewEffect) {
        let mut to = self.camera;
        match effect {
            ViewEffect::FrameAll => {
                self.wants_frame = true;
                return;
            }
            ViewEffect::FrameObject => match self.picture.object_W {
                Some(p_W) => (to.target, to.distance_m) = (p_W, to.distance_m.min(CLOSE_M)),
                None => return,
            },
            ViewEffect::Look(named) => to.look_from(named),
            ViewEffect::Level => to.roll_rad = 0.0,
            ViewEffect::GoTo(camera) => to = camera,
            // The application alone keeps views.
            ViewEffect::Keep => return,
        }
        self.travel_to(to);
    }

    /// Puts the camera there with the next picture; nothing is framed over it.
    pub(super) fn place(&mut self, camera: Camera) {
        self.placed = Some(camera);
    }

    fn travel_to(&mut self, to: Camera) {
        self.travel = Some(Travel { from: self.camera, to, passed_s: 0.0 });
    }

    /// Where the camera stands.
    pub(super) fn camera(&self) -> Camera {
        self.placed.unwrap_or(self.camera)
    }

    /// Where the camera has to stand so that a picture of another shape shows at least what is free of panels here.
    pub(super) fn camera_for(&self, [width, height]: [u32; 2]) -> Camera {
        let mut camera = self.camera();
        camera.distance_m *= (self.free_aspect * f64::from(height) / f64::from(width.max(1))).max(1.0);
        camera
    }

    /// What draws, for pictures of other sizes.
    pub(super) fn gpu_and_renderer(&mut self) -> (&RenderState, &mut Renderer) {
        (&self.gpu, &mut self.renderer)
    }

    /// Draws the view under the panels and gives what the person did in it.
    pub(super) fn show(&mut self, ui: &mut Ui, state: &ViewerState, studio: &mut dyn Studio) -> Vec<Command> {
        let layout = Layout::of(ui.max_rect(), state);
        let rect = layout.picture();
        self.free_aspect = f64::from(layout.free.width() / rect.height().max(1.0));
        let response = ui.interact(layout.window, ui.scope_id().with("View"), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, "3D view"));
        let dark = ui.visuals().dark_mode;
        let key = state.view_key(dark);
        let is_new = self.composed.as_ref() != Some(&key);
        if is_new {
            self.picture = studio.compose(&state.compose_input(dark));
            self.composed = Some(key);
        }
        self.go_to_lab(state);
        if let Some(camera) = self.placed.take() {
            (self.camera, self.travel) = (camera, None);
            (self.wants_frame, self.wants_side, self.was_framed) = (false, None, true);
        }
        if self.wants_frame {
            self.frame_picture(&layout, rect, state.presentation.is_some());
        }
        let shot = Shot { rect, camera: &self.camera };
        let mut commands = self.gizmo.follow(ui, &response, shot, state);
        commands.extend(self.hands.follow(ui, &response, shot, state));
        self.handle(ui, &response, rect, state, &mut commands);
        if flying::fly(ui, &mut self.camera) {
            self.travel = None;
            ui.ctx().request_repaint();
        }
        self.travel_on(ui);
        self.follow(ui, state);
        self.camera.projection = state.viewing.projection;
        let pixels_per_point = ui.pixels_per_point();
        let size_px = [rect.width(), rect.height()].map(|side| (side * pixels_per_point).round().max(1.0) as u32);
        let theme = if dark { Theme::Dark } else { Theme::Light };
        let wanted = Drawn { camera: self.camera, size_px, theme, cut: state.looking.cut };
        let now_s = ui.input(|input| input.time);
        if is_new || self.drawn.as_ref() != Some(&wanted) {
            self.draw(&wanted, pixels_per_point, self.while_moving);
            self.drawn = Some(wanted);
            self.settles_at_s = (self.while_moving != Quality::Live).then_some(now_s + SETTLE_S);
        } else if self.settles_at_s.is_some_and(|at_s| now_s >= at_s) {
            self.draw(&wanted, pixels_per_point, Quality::Live);
            self.settles_at_s = None;
        }
        if let Some(at_s) = self.settles_at_s {
            ui.ctx().request_repaint_after_secs((at_s - now_s).max(0.0) as f32);
        }
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        ui.painter().image(self.texture, rect, whole, Color32::WHITE);
        labels(ui, rect, &self.camera, &self.picture.labels);
        self.gizmo.paint(ui, Shot { rect, camera: &self.camera }, state);
        self.hands.paint(ui, Shot { rect, camera: &self.camera }, state);
        measuring::paint(ui, Shot { rect, camera: &self.camera }, &layout, state);
        if state.grasping.draws_region {
            self.region.hint(ui, &layout);
            commands.extend(self.region.follow(ui, &response, rect, &self.camera, state));
        } else {
            self.region = RegionDrag::default();
        }
        if state.presentation.is_some() {
            return commands;
        }
        if let Some(legend) = &self.picture.legend {
            legends::legend(ui, &layout, legend);
        }
        if let Some(bar) = &self.picture.scale {
            legends::scale_bar(ui, &layout, bar);
        }
        commands
    }

    fn draw(&mut self, wanted: &Drawn, pixels_per_point: f32, quality: Quality) {
        self.renderer.set_quality(quality);
        let gpu = &self.gpu;
        if self.target.resize(&gpu.device, wanted.size_px) {
            gpu.renderer.write().update_egui_texture_from_wgpu_texture(
                &gpu.device,
                self.target.color_view(),
                wgpu::FilterMode::Linear,
                self.texture,
            );
        }
        let mut view = View::new(wanted.camera, wanted.theme, wanted.size_px);
        view.pixels_per_point = pixels_per_point;
        view.cut = wanted.cut;
        self.renderer.draw(&gpu.device, &gpu.queue, &self.picture.frame, &view, &mut self.target);
    }

    /// Brings the picture's bounds into the part of the view that the panels leave free.
    ///
    /// * `is_alone`: no panel is in the way, so that the box may fill that part.
    fn frame_picture(&mut self, layout: &Layout, rect: Rect, is_alone: bool) {
        let everything = || Bounds::of_frame(&self.picture.frame, &mut self.bounds);
        let Some(bounds) = self.picture.bounds.or_else(everything) else { return };
        let free = layout.free.size().max(Vec2::splat(1.0));
        let mut to = self.camera;
        if let Some(side) = self.wants_side.take() {
            let towards = side - bounds.center();
            to.yaw_rad = towards.y.atan2(towards.x) + BESIDE_SENSOR_RAD;
            to.pitch_rad = LAB_PITCH_RAD;
        }
        to.frame(&bounds, [f64::from(free.x), f64::from(free.y)]);
        let outline = &self.picture.outline;
        let corners = bounds.corners();
        let points = if outline.is_empty() && is_alone { corners.as_slice() } else { outline.as_slice() };
        fill(&mut to, points, [f64::from(free.x), f64::from(free.y)]);
        // The camera's field of view spans the whole picture, of which the free part is only a piece.
        to.distance_m *= f64::from(rect.height() / free.y);
        self.wants_frame = false;
        if self.was_framed {
            self.travel_to(to);
        } else {
            self.camera = to;
            self.was_framed = true;
        }
    }

    /// The camera goes to a fit that is examined, and back when the robot is at work again.
    fn go_to_lab(&mut self, state: &ViewerState) {
        let examined = state.lab_key().map(|lab| (lab.cluster, lab.points_out_rejected));
        if examined == self.examined {
            return;
        }
        match (self.examined, examined) {
            (None, Some(_)) => {
                self.before_lab = self.was_framed.then_some(self.camera);
                self.wants_frame = true;
                self.wants_side = sensor(state);
            }
            (Some(_), Some(_)) => self.wants_frame = true,
            (_, None) => match self.before_lab.take() {
                Some(to) => self.travel_to(to),
                None => self.wants_frame = true,
            },
        }
        self.examined = examined;
    }

    fn travel_on(&mut self, ui: &Ui) {
        let Some(travel) = &mut self.travel else { return };
        travel.passed_s += f64::from(ui.input(|input| input.stable_dt)).min(0.1);
        let t = (travel.passed_s / TRAVEL_S).min(1.0);
        self.camera = travel.from.toward(&travel.to, t);
        if t >= 1.0 {
            self.travel = None;
        }
        ui.ctx().request_repaint();
    }

    /// The camera turns to where what it follows is, smoothly, unless a hand is on it.
    fn follow(&mut self, ui: &Ui, state: &ViewerState) {
        let is_free = self.travel.is_none() && self.anchor.is_none();
        let followed = state.playback.follows.filter(|_| is_free);
        let Some(p_W) = followed.and_then(|followed| self.picture.place_of(followed)) else { return };
        let away = p_W - self.camera.target;
        if away.norm() > FOLLOWED_M {
            let dt_s = f64::from(ui.input(|input| input.stable_dt)).min(0.1);
            self.camera.target += away * (1.0 - (-dt_s / FOLLOW_S).exp());
            ui.ctx().request_repaint();
        }
    }

    /// Turning, moving, zooming, pointing and clicking.
    fn handle(&mut self, ui: &Ui, response: &Response, rect: Rect, state: &ViewerState, commands: &mut Vec<Command>) {
        let size = [f64::from(rect.width()), f64::from(rect.height())];
        let in_picture = |at: Pos2| Point2::new(f64::from(at.x - rect.left()), f64::from(at.y - rect.top()));
        if let Some(touch) = ui.input(|input| input.multi_touch()).filter(|_| response.dragged() || response.hovered())
        {
            let anchor = self.point_under(in_picture(touch.center_pos), size, state);
            self.zoom(f64::from(touch.zoom_delta), &anchor);
            let to = touch.center_pos;
            self.camera.pan(&anchor, in_picture(to - touch.translation_delta), in_picture(to), size);
            self.travel = None;
            return;
        }
        if state.grasping.draws_region && !ui.input(|input| input.pointer.secondary_down()) {
            // The drag draws a frame; the other button still moves the camera.
            return;
        }
        let is_taken = self.gizmo.is_busy() || self.hands.is_busy();
        if response.drag_started()
            && !is_taken
            && let Some(pointer) = response.interact_pointer_pos()
        {
            self.anchor = Some(self.point_under(in_picture(pointer), size, state));
            self.travel = None;
        }
        if let (true, Some(pointer), Some(anchor)) = (response.dragged(), response.interact_pointer_pos(), self.anchor)
        {
            let delta = response.drag_delta();
            let shift = ui.input(|input| input.modifiers.shift);
            if response.dragged_by(PointerButton::Primary) && !shift {
                let angles = [f64::from(-delta.x) * TURN, f64::from(delta.y) * TURN];
                self.turn(state.viewing.turning, angles, &anchor);
            } else {
                self.camera.pan(&anchor, in_picture(pointer - delta), in_picture(pointer), size);
            }
        } else {
            self.anchor = None;
        }
        if !response.hovered() {
            return;
        }
        let Some(pointer) = response.hover_pos() else { return };
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        if scroll != 0.0 || pinch != 1.0 {
            let anchor = self.point_under(in_picture(pointer), size, state);
            self.zoom(f64::from(pinch) * (f64::from(scroll) / 240.0).exp(), &anchor);
            self.travel = None;
        }
        if !response.dragged() && !is_taken {
            self.point(response, in_picture(pointer), size, state, commands);
        }
    }

    /// What is under the pointer is hovered; a click selects it.
    fn point(
        &mut self,
        response: &Response,
        at: Point2<f64>,
        size: [f64; 2],
        state: &ViewerState,
        commands: &mut Vec<Command>,
    ) {
        let hit = self.picker.pick(&self.picture.frame, self.camera.ray(at, size), state.looking.cut);
        let pick = hit.as_ref().map_or(Pick::Nothing, |hit| Pick::from_id(hit.pick_id));
        let grasp = if let Pick::Grasp(id) = pick { Some(id) } else { None };
        let cluster = match pick {
            Pick::Cluster(cluster) | Pick::Part { cluster, .. } => Some(cluster as usize),
            Pick::Grasp(_) | Pick::Place(_) | Pick::Obstacle(_) | Pick::Voxel { .. } | Pick::Robot | Pick::Nothing => {
                None
            }
        };
        let place = if let Pick::Place(index) = pick { Some(index as usize) } else { None };
        if state.planning.hovered_place != place {
            commands.push(Command::Handover(HandoverCommand::HoverPlace(place)));
        }
        if state.hover.grasp != grasp {
            commands.push(Command::HoverGrasp(grasp));
        }
        if state.hover.cluster != cluster {
            commands.push(Command::HoverCluster(cluster));
        }
        if let Some(tip) = tips::of(pick, state).filter(|_| state.presentation.is_none()) {
            let _shown = response.clone().on_hover_ui_at_pointer(|ui| tips::draw(ui, &tip));
        }
        if state.looking.measured.is_some() {
            if let Some(hit) = hit.filter(|_| response.clicked()) {
                commands.push(Command::Look(LookCommand::Point(hit.point)));
            }
            return;
        }
        if response.clicked() {
            match pick {
                Pick::Grasp(id) => commands.push(Command::SelectGrasp(id)),
                Pick::Part { part, .. } if state.picks_part() => {
                    // A second click on the same part lets any part be held again.
                    let part = Some(part as usize).filter(|part| state.scene().grasp.filter.part != Some(*part));
                    commands.push(Command::Grasping(GraspCommand::SetPart(part)));
                }
                Pick::Cluster(cluster) | Pick::Part { cluster, .. } if state.selects_things() => {
                    commands.push(Command::Place(PlaceCommand::SelectCluster(cluster as usize)));
                }
                Pick::Obstacle(index) => {
                    commands.push(Command::SelectStep(Step::Stage(Stage::Scene)));
                    commands.push(Command::Place(PlaceCommand::Select(Some(Thing::Obstacle(index as usize)))));
                }
                Pick::Nothing if state.selected_thing().is_some() => {
                    commands.push(Command::Place(PlaceCommand::Select(None)));
                }
                Pick::Cluster(cluster) | Pick::Part { cluster, .. } => {
                    commands.push(Command::SelectCluster(cluster as usize));
                }
                Pick::Place(index) => {
                    commands.push(Command::Handover(HandoverCommand::ShowPlace(Some(index as usize))));
                }
                Pick::Voxel { arm, voxel } => {
                    commands.push(Command::Reach(ReachCommand::Select { arm: arm as usize, voxel }));
                }
                Pick::Robot if state.selection.step == Step::Stage(Stage::Scene) => {
                    commands.push(Command::Pose(PoseCommand::Open));
                }
                Pick::Robot | Pick::Nothing => {}
            }
        }
        if response.double_clicked() {
            match hit {
                Some(hit) => {
                    let distance_m = self.camera.distance_m.min(CLOSE_M);
                    self.travel_to(Camera { target: hit.point, distance_m, ..self.camera });
                }
                None => commands.push(Command::View(ViewCommand::FrameAll)),
            }
        }
    }

    /// The point of the scene under a pixel; without one, the point at the target's depth.
    fn point_under(&mut self, at: Point2<f64>, size: [f64; 2], state: &ViewerState) -> Point3<f64> {
        let ray = self.camera.ray(at, size);
        match self.picker.pick(&self.picture.frame, ray, state.looking.cut) {
            Some(hit) => hit.point,
            None => {
                let along = ray.direction.dot(&-self.camera.backward()).max(0.05);
                let depth_m = self.camera.depth_m(&ray.origin);
                ray.at((self.camera.distance_m - depth_m) / along)
            }
        }
    }

    /// Turns about a point that keeps its place on the picture.
    fn turn(&mut self, turning: Turning, [yaw_rad, pitch_rad]: [f64; 2], anchor: &Point3<f64>) {
        let axes = |camera: &Camera| Matrix3::from_columns(&[camera.right(), camera.up(), camera.backward()]);
        let before = axes(&self.camera);
        match turning {
            Turning::Turntable => self.camera.orbit(yaw_rad, pitch_rad),
            Turning::Free => self.camera.tumble(yaw_rad, pitch_rad),
        }
        let turned = axes(&self.camera) * before.transpose();
        self.camera.target = anchor + turned * (self.camera.target - anchor);
    }

    fn zoom(&mut self, nearer: f64, anchor: &Point3<f64>) {
        if nearer.is_finite() && nearer > 0.0 {
            self.camera.zoom(1.0 / nearer, anchor);
        }
    }
}

/// Words above their places; one that would cover another is left out.
pub(super) fn labels(ui: &Ui, rect: Rect, camera: &Camera, labels: &[Label]) {
    let tokens = Tokens::of(ui);
    let size = [f64::from(rect.width()), f64::from(rect.height())];
    let mut taken: Vec<Rect> = Vec::new();
    for label in labels {
        let Some(at) = camera.project(&label.p_W, size) else { continue };
        let at = rect.min + vec2(at.x as f32, at.y as f32);
        let color = match label.tone {
            Tone::Plain => tokens.text,
            Tone::Fit => tokens.teal_text,
            Tone::Goal => tokens.amber,
            Tone::Grasp => tokens.violet,
            Tone::Rejected => tokens.coral,
        };
        let galley = ui.painter().layout_no_wrap(label.text.clone(), font(SECONDARY), color);
        let pill = Rect::from_center_size(at - vec2(0.0, 18.0), galley.size() + vec2(14.0, 6.0));
        if taken.iter().any(|other| other.intersects(pill)) {
            continue;
        }
        let line = Stroke::new(1.0, tokens.line);
        ui.painter().line_segment([pill.center_bottom(), at], Stroke::new(1.0, color.gamma_multiply(0.6)));
        ui.painter().rect(pill, 5.0, tokens.panel, line, StrokeKind::Inside);
        ui.painter().galley(pill.center() - 0.5 * galley.size(), galley, color);
        taken.push(pill);
    }
}
