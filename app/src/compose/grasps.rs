//! Grasps in the view: pins for all of them, the hand, its contacts and friction cones for the one that matters, and
//! what a filter lets pass.

use std::sync::Arc;

use endcomfort_core::grasp::{ApproachCone, Grasp, HandModel, Quantity, Region};
use endcomfort_core::mesh::Mesh;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::{Composer, Content, Palette};
use crate::render::shapes::{self, ProfileVertex};
use crate::render::{ColorMap, Frame, LineDraw, MeshDraw, Scale, Surface};
use crate::viewer::{Layer, Pick};

/// Largest height of a friction cone, metres.
const CONE_M: f64 = 0.022;
/// Opacity of a friction cone.
const CONE_OPACITY: f32 = 0.30;
/// How far an approach cone reaches from the object's centre, metres.
const APPROACH_M: f64 = 0.24;
/// Vertices of the rings that outline a cone.
const RING: u32 = 48;

/// Meshes that every picture with grasps shares, so that thousands of pins are one instanced draw.
pub(super) struct Glyphs {
    pin: Arc<Mesh>,
    bead: Arc<Mesh>,
    /// The friction coefficient that the cone is made for.
    friction: f64,
    cone: Arc<Mesh>,
}

impl Glyphs {
    fn new(friction: f64) -> Self {
        Self {
            pin: Arc::new(pin()),
            bead: Arc::new(shapes::bead(0.0028)),
            friction,
            cone: Arc::new(friction_cone(friction)),
        }
    }
}

/// Colours of accepted grasps by one of their numbers.
pub fn quantity_scale(grasps: &[Grasp], quantity: Quantity) -> Scale {
    let accepted = grasps.iter().filter(|grasp| grasp.is_accepted());
    Scale::covering(ColorMap::Viridis, accepted.filter_map(|grasp| quantity.of(grasp)))
}

/// A grasp as a pin: its foot at the origin, its stem and head along -z, where the hand comes from.
///
/// One hundred triangles: there are thousands of pins, and some machines draw without a GPU.
fn pin() -> Mesh {
    let (length_m, radius_m, head_m) = (0.05, 0.0011, 0.0044);
    let vertex = |radius: f64, z: f64, normal: [f64; 2]| ProfileVertex { radius, z, normal };
    let mut profile: Vec<ProfileVertex> = (-2..=2)
        .map(|step| {
            let (sin, cos) = (f64::from(step) * std::f64::consts::FRAC_PI_4).sin_cos();
            vertex(head_m * cos.max(0.0), head_m * sin - length_m, [cos, sin])
        })
        .collect();
    profile[0].radius = 0.0;
    if let Some(neck) = profile.last_mut() {
        *neck = vertex(radius_m, neck.z, [1.0, 0.0]);
    }
    profile.push(vertex(radius_m, 0.0, [1.0, 0.0]));
    profile.push(vertex(0.0, 0.0, [0.0, 1.0]));
    shapes::revolve(&profile, 10)
}

/// Height of a friction cone, metres: its rim stays within a hand's breadth for any coefficient.
fn cone_height_m(friction: f64) -> f64 {
    CONE_M.min(0.03 / friction.max(1e-3))
}

/// A cone with its tip at the origin, open along z; its half angle is that of friction, `atan μ`.
fn friction_cone(friction: f64) -> Mesh {
    let height_m = cone_height_m(friction);
    let turned = Isometry3::from_parts(
        Translation3::new(0.0, 0.0, height_m),
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI),
    );
    shapes::cone(friction * height_m, height_m).transformed(&turned)
}

/// A rotation that brings z onto a direction.
fn along(direction: &Vector3<f64>) -> UnitQuaternion<f64> {
    let half_turn = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    UnitQuaternion::rotation_between(&Vector3::z(), direction).unwrap_or_else(half_turn)
}

impl Composer {
    pub(super) fn add_grasps(&mut self, frame: &mut Frame, input: &Content<'_>, palette: &Palette) {
        let Some(X_WO) = input.X_WO.or(input.X_WO_start) else { return };
        let Some(arm) = input.robot.arm(input.arm) else { return };
        let hand = HandModel::new(input.robot, arm);
        let scale = quantity_scale(input.grasps, input.colored_by);
        let friction = input.scene.grasp.friction;
        if self.glyphs.as_ref().is_none_or(|glyphs| glyphs.friction != friction) {
            self.glyphs = Some(Glyphs::new(friction));
        }
        let Some(pin) = self.glyphs.as_ref().map(|glyphs| glyphs.pin.clone()) else { return };
        // The pin stands on the surface and points back along the approach.
        let back = Translation3::new(0.0, 0.0, -hand.palm_depth_m().min(0.02));
        for grasp in input.grasps {
            let is_accepted = grasp.is_accepted();
            let layer = if is_accepted { Layer::Grasps } else { Layer::Rejected };
            let opacity = input.layers.opacity(layer);
            if opacity <= 0.0 {
                continue;
            }
            let mut color = match (is_accepted, input.colored_by.of(grasp)) {
                (false, _) => palette.rejected,
                (true, Some(value)) => scale.color(value),
                (true, None) => palette.unknown,
            };
            color[3] *= opacity;
            frame.meshes.push(MeshDraw {
                mesh: pin.clone(),
                X_WM: X_WO * grasp.X_OH * back,
                color,
                surface: Surface::Unlit,
                pick_id: Pick::Grasp(grasp.id).id(),
            });
        }
        let find = |id: Option<u32>| input.grasps.iter().find(|grasp| Some(grasp.id) == id);
        let selected = find(input.selected);
        if let Some(grasp) = selected {
            self.add_contacts(frame, input, &X_WO, grasp, palette);
        }
        for (grasp, usual) in [(find(input.hovered), palette.hovered_hand), (selected, palette.selected_hand)] {
            // Grasps of another hand are still there until the new ones come.
            let Some(grasp) = grasp.filter(|grasp| grasp.closed.len() == hand.open.len()) else { continue };
            let color = if grasp.is_accepted() { usual } else { palette.rejected_hand };
            self.add_hand(frame, input, &hand, &(X_WO * grasp.X_OH), &grasp.closed, color);
        }
    }

    /// A bead where the hand touches, and the cone of forces that friction allows there, into the object.
    fn add_contacts(
        &self,
        frame: &mut Frame,
        input: &Content<'_>,
        X_WO: &Isometry3<f64>,
        grasp: &Grasp,
        palette: &Palette,
    ) {
        let (opacity, Some(glyphs)) = (input.layers.opacity(Layer::Contacts), &self.glyphs) else { return };
        if opacity <= 0.0 {
            return;
        }
        for contact in &grasp.contacts {
            let inward = along(&-contact.n_O);
            let X_WM = X_WO * Isometry3::from_parts(Translation3::from(contact.p_O.coords), inward);
            for (mesh, share) in [(&glyphs.bead, 1.0), (&glyphs.cone, CONE_OPACITY)] {
                let mut color = palette.contact;
                color[3] *= opacity * share;
                frame.meshes.push(MeshDraw { mesh: mesh.clone(), X_WM, color, surface: Surface::Unlit, pick_id: 0 });
            }
            let mut color = palette.contact;
            color[3] *= opacity * 0.9;
            let height_m = cone_height_m(glyphs.friction);
            frame.lines.push(LineDraw::new(ring(&X_WM, height_m, glyphs.friction * height_m), color, 1.3));
        }
    }

    fn add_hand(
        &mut self,
        frame: &mut Frame,
        input: &Content<'_>,
        hand: &HandModel,
        X_WH: &Isometry3<f64>,
        fingers: &[f64],
        color: [f32; 4],
    ) {
        let meshes = self.link_meshes(input.robot);
        for (link, X_HL) in hand.links.iter().zip(hand.link_poses(fingers)) {
            let Some(index) = input.robot.links.iter().position(|l| l.name == link.name) else { continue };
            for (visual, mesh) in input.robot.links[index].visuals.iter().zip(&meshes[index]) {
                let X_WM = X_WH * X_HL * visual.X_LV;
                frame.meshes.push(MeshDraw { mesh: mesh.clone(), X_WM, color, surface: Surface::Ghost, pick_id: 0 });
            }
        }
    }
}

/// The ring of a radius around z at a height of M.
fn ring(X_WM: &Isometry3<f64>, height_m: f64, radius_m: f64) -> Vec<Point3<f64>> {
    let at = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k % RING) / f64::from(RING)).sin_cos();
        X_WM * Point3::new(radius_m * cos, radius_m * sin, height_m)
    };
    (0..=RING).map(at).collect()
}

/// The cone from which the hand may come and the box in which it may hold the object.
pub(super) fn add_filter(frame: &mut Frame, input: &Content<'_>, palette: &Palette) {
    let Some(filter) = input.filter else { return };
    if let (Some(cone), Some(X_WO)) = (&filter.approach, input.X_WO_start) {
        add_approach(frame, cone, &X_WO.translation.vector.into(), palette.filter);
    }
    if let Some(region) = &filter.region {
        add_region(frame, region, palette.filter);
    }
}

/// A cone around the ways to the object, open against the direction in which the hand moves; an arrow along it.
fn add_approach(frame: &mut Frame, cone: &ApproachCone, p_WO: &Point3<f64>, color: [f32; 4]) {
    let Some(axis_W) = cone.axis_W.try_normalize(1e-9) else { return };
    let X_WM = Isometry3::from_parts(Translation3::from(p_WO.coords), along(&-axis_W));
    let (sin, cos) = cone.half_angle_rad.sin_cos();
    let (height_m, radius_m) = (APPROACH_M * cos, APPROACH_M * sin);
    let rim = ring(&X_WM, height_m, radius_m);
    for vertex in rim.iter().step_by(RING as usize / 8) {
        frame.lines.push(LineDraw::new(vec![*p_WO, *vertex], [color[0], color[1], color[2], 0.35], 1.0));
    }
    frame.lines.push(LineDraw::new(rim, color, 1.6));
    let (length_m, gap_m) = (0.09, 0.13);
    let from = X_WM * Isometry3::translation(0.0, 0.0, gap_m + length_m);
    let turned = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    frame.meshes.push(MeshDraw {
        mesh: Arc::new(shapes::arrow(length_m, 0.0035)),
        X_WM: from * turned,
        color,
        surface: Surface::Unlit,
        pick_id: 0,
    });
}

/// The edges of a box with a breath of colour inside.
fn add_region(frame: &mut Frame, region: &Region, color: [f32; 4]) {
    let corner = |k: usize| {
        let side = |axis: usize| if k >> axis & 1 == 1 { region.half_m[axis] } else { -region.half_m[axis] };
        region.center_W + Vector3::new(side(0), side(1), side(2))
    };
    for from in 0..8_usize {
        for to in [1, 2, 4].map(|bit| from | bit).into_iter().filter(|&to| to != from) {
            frame.lines.push(LineDraw::new(vec![corner(from), corner(to)], color, 1.6));
        }
    }
    frame.meshes.push(MeshDraw {
        mesh: Arc::new(shapes::cuboid(2.0 * region.half_m)),
        X_WM: Isometry3::from_parts(Translation3::from(region.center_W.coords), UnitQuaternion::identity()),
        color: [color[0], color[1], color[2], 0.10],
        surface: Surface::Unlit,
        pick_id: 0,
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_friction_cone_opens_along_z_at_the_angle_of_friction() {
        for friction in [0.1, 0.5, 2.0] {
            let cone = friction_cone(friction);
            let tip = cone.positions.iter().map(|p| p.coords.norm()).fold(f64::INFINITY, f64::min);
            assert!(tip < 1e-9, "the tip is at the contact");
            for p in cone.positions.iter().filter(|p| p.xy().coords.norm() > 1e-9) {
                assert!(p.z > 0.0 && (p.xy().coords.norm() / p.z - friction).abs() < 1e-9, "{friction}: {p}");
            }
        }
    }

    #[test]
    fn any_direction_can_be_looked_along_the_one_against_z_too() {
        for direction in [Vector3::x(), Vector3::z(), -Vector3::z(), Vector3::new(0.1, -0.7, -0.7).normalize()] {
            assert!((along(&direction) * Vector3::z() - direction).norm() < 1e-6, "{direction}");
        }
    }
}
