//! A robot that is posed by hand: where a hand was wanted but cannot be, as a ghost at the end of a tether.

use nalgebra::Point3;

use super::{Composer, Content, Palette};
use crate::render::{Frame, LineDraw, MeshDraw, Surface};
use crate::viewer::LedHand;

/// Opacity of the ghost of a hand.
const GHOST: f32 = 0.5;

impl Composer {
    /// Tethers and ghosts of the hands that are not where they were led to.
    pub(super) fn add_posing(&mut self, frame: &mut Frame, input: &Content<'_>, palette: &Palette) {
        let short = input.hands.iter().filter_map(|hand| Some((hand, hand.target.as_ref()?)));
        let short: Vec<(&LedHand, _)> = short.collect();
        if short.is_empty() {
            return;
        }
        let X_WL = input.robot.link_poses(input.q);
        let meshes = self.link_meshes(input.robot);
        for (hand, target) in short {
            let Some(arm) = input.robot.arms.get(hand.arm) else { continue };
            let mut color = palette.goal;
            color[3] = GHOST;
            let moved = target.X_WH * hand.X_WH.inverse();
            for &index in &arm.hand.links {
                for (visual, mesh) in input.robot.links[index].visuals.iter().zip(&meshes[index]) {
                    let X_WM = moved * X_WL[index] * visual.X_LV;
                    frame.meshes.push(MeshDraw {
                        mesh: mesh.clone(),
                        X_WM,
                        color,
                        surface: Surface::Ghost,
                        pick_id: 0,
                    });
                }
            }
            let ends: Vec<Point3<f64>> = [hand.X_WH, target.X_WH].iter().map(|X| X.translation.vector.into()).collect();
            frame.lines.push(LineDraw::new(ends, palette.culprit, 2.5).dashed(6.0));
        }
    }
}
