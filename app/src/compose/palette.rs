//! Colours of the view, by theme (tokens of the look).

use endcomfort_core::robot::Material;
use endcomfort_core::scene::Scene;
use endcomfort_core::segment::PointFate;
use endcomfort_core::task::PhaseKind;
use nalgebra::Isometry3;

use crate::assets;
use crate::render::{Surface, Theme};

/// How much of its own colour a neighbour keeps: the rest is a quiet grey, so that data colours stand out.
const CALM: f32 = 0.45;

/// Colours of everything in the view, sRGB and opacity.
pub struct Palette {
    pub table: [f32; 4],
    pub obstacle: [f32; 4],
    pub target: [f32; 4],
    pub goal: [f32; 4],
    pub cloud: [f32; 4],
    /// Points that mirroring added.
    pub mirrored: [f32; 4],
    /// A fit that another one is compared with.
    pub trial: [f32; 4],
    /// Quiet lines: a fit that a shape set by hand stands in for.
    pub ghost_line: [f32; 4],
    /// The parts of an examined fit.
    pub parts: [[f32; 4]; 4],
    pub rejected: [f32; 4],
    pub hovered_hand: [f32; 4],
    pub selected_hand: [f32; 4],
    /// The hand of a selected grasp that was rejected.
    pub rejected_hand: [f32; 4],
    /// An accepted grasp without the number that colours the others.
    pub unknown: [f32; 4],
    /// Contacts and friction cones.
    pub contact: [f32; 4],
    /// What a filter lets pass.
    pub filter: [f32; 4],
    pub reach: [f32; 4],
    pub transport: [f32; 4],
    pub retreat: [f32; 4],
    /// A plan that is no longer that of the scene.
    pub stale: [f32; 4],
    /// A plan that others are compared with.
    pub kept: [f32; 4],
    /// The space that the arm sweeps.
    pub swept: [f32; 4],
    /// Where an object changes hands.
    pub handover: [f32; 4],
    /// The chosen voxel, and the hand that the robot shows there.
    pub chosen: [f32; 4],
    /// The other hands that reach it.
    pub other_hands: [f32; 4],
    /// What stood in the way.
    pub culprit: [f32; 4],
    /// Routes of the hand.
    routes: [[f32; 4]; 6],
    shell: [f32; 4],
    joint: [f32; 4],
    accent: [f32; 4],
    neighbour: [f32; 4],
    faint: [f32; 4],
    clusters: [[f32; 4]; 5],
}

const fn rgb(hex: u32) -> [f32; 4] {
    rgba(hex, 1.0)
}

const fn rgba(hex: u32, opacity: f32) -> [f32; 4] {
    [((hex >> 16) & 255) as f32 / 255.0, ((hex >> 8) & 255) as f32 / 255.0, (hex & 255) as f32 / 255.0, opacity]
}

impl Palette {
    /// The palette of a theme.
    pub fn of(theme: Theme) -> Self {
        match theme {
            Theme::Dark => Self {
                table: rgb(0x4a4540),
                obstacle: rgb(0x9a7b5c),
                target: rgba(0x3ec6b0, 0.62),
                goal: rgba(0xf0b34a, 0.55),
                cloud: rgb(0x6ca9ff),
                mirrored: rgb(0xb08cff),
                trial: rgb(0xf0b34a),
                ghost_line: rgba(0x9aa6b2, 0.8),
                parts: [rgb(0x3ec6b0), rgb(0xf0b34a), rgb(0x8fd36b), rgb(0xe58fc0)],
                rejected: rgba(0xee6a5c, 0.8),
                hovered_hand: rgba(0xe7eaed, 0.55),
                selected_hand: rgba(0xb08cff, 0.6),
                rejected_hand: rgba(0xee6a5c, 0.6),
                unknown: rgb(0x8a96a3),
                contact: rgb(0xfff3d6),
                filter: rgb(0x6ca9ff),
                reach: rgb(0x6ca9ff),
                transport: rgb(0xf0b34a),
                retreat: rgb(0x8a96a3),
                stale: rgba(0x8a96a3, 0.55),
                kept: rgba(0xe7eaed, 0.85),
                swept: rgb(0x8ca0ff),
                handover: rgb(0xd67fb0),
                chosen: rgb(0xff8a3d),
                other_hands: rgba(0xe7eaed, 0.75),
                culprit: rgb(0xee6a5c),
                routes: [rgb(0xf0b34a), rgb(0x6ca9ff), rgb(0xb08cff), rgb(0x3ec6b0), rgb(0xe58fc0), rgb(0x8fd36b)],
                shell: rgb(0xd4d6d6),
                joint: rgb(0x1c1f23),
                accent: rgb(0x3ec6b0),
                neighbour: rgb(0x7d8894),
                faint: rgba(0x8a96a3, 0.05),
                clusters: [rgb(0x6ca9ff), rgb(0xb08cff), rgb(0xf0b34a), rgb(0x8fd36b), rgb(0xe58fc0)],
            },
            Theme::Light => Self {
                table: rgb(0xd9d4cd),
                obstacle: rgb(0xc7a884),
                target: rgba(0x0d9a85, 0.62),
                goal: rgba(0xc98208, 0.5),
                cloud: rgb(0x2f74d8),
                mirrored: rgb(0x7d56d6),
                trial: rgb(0xc98208),
                ghost_line: rgba(0x5f6973, 0.8),
                parts: [rgb(0x0d9a85), rgb(0xc98208), rgb(0x4b9a2f), rgb(0xb84d8a)],
                rejected: rgba(0xd2483a, 0.8),
                hovered_hand: rgba(0x1d2329, 0.45),
                selected_hand: rgba(0x7d56d6, 0.55),
                rejected_hand: rgba(0xd2483a, 0.55),
                unknown: rgb(0x9aa4ad),
                contact: rgb(0x23201a),
                filter: rgb(0x2f74d8),
                reach: rgb(0x2f74d8),
                transport: rgb(0xc98208),
                retreat: rgb(0x69737d),
                stale: rgba(0x69737d, 0.55),
                kept: rgba(0x1d2329, 0.85),
                swept: rgb(0x5566d6),
                handover: rgb(0xa84f88),
                chosen: rgb(0xd2560a),
                other_hands: rgba(0x2b3138, 0.75),
                culprit: rgb(0xd2483a),
                routes: [rgb(0xc98208), rgb(0x2f74d8), rgb(0x7d56d6), rgb(0x0d9a85), rgb(0xb84d8a), rgb(0x4b9a2f)],
                shell: rgb(0xe6e7e6),
                joint: rgb(0x24282d),
                accent: rgb(0x0d9a85),
                neighbour: rgb(0x9aa4ad),
                faint: rgba(0x69737d, 0.07),
                clusters: [rgb(0x2f74d8), rgb(0x7d56d6), rgb(0xc98208), rgb(0x4b9a2f), rgb(0xb84d8a)],
            },
        }
    }

    /// Colour of a phase; grey when its plan is out of date.
    pub fn phase(&self, kind: PhaseKind, is_stale: bool) -> [f32; 4] {
        match kind {
            _ if is_stale => self.stale,
            PhaseKind::Reach => self.reach,
            PhaseKind::Retreat => self.retreat,
            PhaseKind::Close | PhaseKind::Open => self.accent,
            _ => self.transport,
        }
    }

    /// Colour of a route by its place in the list.
    pub fn route(&self, index: usize) -> [f32; 4] {
        self.routes[index % self.routes.len()]
    }

    /// A colour of the robot while it shows a plan that is out of date: half of it is a quiet grey.
    pub fn greyed(&self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        let level = 0.3 * r + 0.59 * g + 0.11 * b;
        let quiet = |grey: f32| 0.45 * level + 0.55 * grey;
        [quiet(self.neighbour[0]), quiet(self.neighbour[1]), quiet(self.neighbour[2]), a]
    }

    /// Colour and surface of a robot's material; machines have two greys and one accent.
    pub fn material(&self, material: &Material, opacity: f32) -> ([f32; 4], Surface) {
        let (mut color, surface) = match material.name.as_str() {
            "shell" => (self.shell, Surface::Satin),
            "joint" => (self.joint, Surface::Satin),
            "accent" => (self.accent, Surface::Satin),
            "rubber" | "cloth" | "skin" | "dark" => (material.rgba, Surface::Matte),
            "metal" => (material.rgba, Surface::Gloss),
            _ => (material.rgba, Surface::Satin),
        };
        color[3] *= opacity;
        (color, surface)
    }

    /// Colour of a point by what became of it; the target cluster is teal, a hidden one is not seen.
    /// Around an examined cluster all points are quiet.
    pub fn fate(&self, fate: PointFate, target: Option<usize>, hidden: Option<usize>, is_quiet: bool) -> [f32; 4] {
        match fate {
            PointFate::Cluster(index) if Some(usize::from(index)) == hidden => [0.0; 4],
            PointFate::Cluster(_) | PointFate::SmallCluster if is_quiet => {
                [self.neighbour[0], self.neighbour[1], self.neighbour[2], 0.35]
            }
            // Seen from so near, even faint points would lie on the table like sand.
            _ if is_quiet => [0.0; 4],
            PointFate::Cluster(index) if Some(usize::from(index)) == target => self.accent,
            PointFate::Cluster(index) => self.clusters[usize::from(index) % self.clusters.len()],
            PointFate::SmallCluster => self.rejected,
            _ => self.faint,
        }
    }

    /// Colour of a fit that is not grasped: that of the described object which stands there, or a quiet grey.
    pub fn neighbour(&self, scene: &Scene, X_WS: &Isometry3<f64>) -> [f32; 4] {
        scene.object_at(X_WS).and_then(|placed| assets::library().object(&placed.object).ok()).map_or(
            self.neighbour,
            |object| {
                let [r, g, b] = object.color.map(|c| f32::from(c) / 255.0);
                let calm = |c: f32, quiet: f32| quiet + CALM * (c - quiet);
                let [quiet_r, quiet_g, quiet_b, _] = self.neighbour;
                [calm(r, quiet_r), calm(g, quiet_g), calm(b, quiet_b), 1.0]
            },
        )
    }
}
