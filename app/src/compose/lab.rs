//! A fit under examination: its points by what became of them, its shape by lines or as a body, and its errors.

use std::collections::BTreeSet;
use std::sync::Arc;

use endcomfort_core::fit::Fit;
use endcomfort_core::mesh::Mesh;
use endcomfort_core::superquadric::Superquadric;
use nalgebra::{Isometry3, Point3};

use super::{Composer, FIT_MESH_HALF, Palette};
use crate::render::{Bounds, ColorMap, Frame, LineDraw, MeshDraw, PointsDraw, Scale, Surface, bytes_of};
use crate::viewer::{FitView, Legend, LegendRow, Mark, Pick};

/// Every so many lines of the mesh one is drawn.
const WIRE_STEP: usize = 4;
/// Diameter of an input point, metres, and between lines, which it should not cover.
const POINT_M: [f64; 2] = [0.0018, 0.0011];
/// Diameter of a mirrored point: there are many, and what was measured comes first.
const MIRRORED_M: [f64; 2] = [0.0009, 0.0007];
/// Diameter of a rejected point, metres, and when the view points at it.
const REJECTED_M: [f64; 2] = [0.0032, 0.007];
/// Share of the points whose errors the colours resolve; the few beyond take the end colours.
const RESOLVED: f64 = 0.98;

/// A fit under examination.
pub struct LabContent<'a> {
    /// Its cluster.
    pub cluster: usize,
    /// What it is called.
    pub title: String,
    /// Points of the cluster in W.
    pub points: &'a [Point3<f64>],
    /// Their signed radial distances, metres.
    pub distances_m: &'a [f64],
    /// The fit.
    pub fit: &'a Fit,
    /// The fit that a shape set by hand stands in for.
    pub automatic: Option<&'a Fit>,
    /// Another fit to compare with, and its name.
    pub trial: Option<(&'static str, &'a Fit)>,
    /// How it is drawn.
    pub view: FitView,
    /// Whether the rejected points stand out.
    pub points_out_rejected: bool,
}

impl LabContent<'_> {
    /// Colours of the signed errors, millimetres: symmetric about 0, its end a round number.
    pub fn scale(&self) -> Scale {
        let mut sizes: Vec<f64> = self.distances_m.iter().map(|d| d.abs()).filter(|d| d.is_finite()).collect();
        sizes.sort_by(f64::total_cmp);
        let resolved = ((sizes.len() as f64 * RESOLVED) as usize).min(sizes.len().saturating_sub(1));
        let end_mm = round_up(1e3 * sizes.get(resolved).copied().unwrap_or(1e-3));
        Scale { map: ColorMap::Diverging, min: -end_mm, max: end_mm, is_log: false }
    }

    /// The box around everything that is examined, with a little room.
    pub fn bounds(&self) -> Option<Bounds> {
        let rejected = self.fit.rejected.iter().map(|point| point.p_F);
        let shown: Vec<Point3<f64>> = if self.points_out_rejected && !self.fit.rejected.is_empty() {
            rejected.collect()
        } else {
            self.points.iter().chain(&self.fit.mirrored).copied().collect()
        };
        let first = shown.first()?;
        let (min, max) = shown.iter().fold((*first, *first), |(min, max), p| (min.inf(p), max.sup(p)));
        // Room for the legend and the bar; and a single rejected point should not fill the view.
        let middle = nalgebra::center(&min, &max);
        let half = (max - min).scale(0.64).map(|side| side.max(0.03));
        Some(Bounds { min: middle - half, max: middle + half })
    }

    /// What the marks mean.
    pub fn legend(&self, palette: &Palette) -> Legend {
        let mut rows = Vec::new();
        let mut add = |mark: Mark, color: [f32; 4], text: String| rows.push(LegendRow { mark, color, text });
        let count = crate::viewer::count;
        let rejected = self.fit.rejected.len();
        let inputs = count(self.points.len().saturating_sub(rejected));
        if self.view == FitView::Error {
            add(Mark::Signed, palette.cloud, format!("{inputs} input points, by their error"));
        } else {
            add(Mark::Dot, palette.cloud, format!("{inputs} input points"));
            if !self.fit.mirrored.is_empty() {
                add(Mark::Dot, palette.mirrored, format!("{} mirrored points", count(self.fit.mirrored.len())));
            }
        }
        if rejected > 0 {
            let (color, words) = match self.view {
                FitView::Error => (palette.ghost_line, "rejected points, drawn larger"),
                _ => (palette.rejected, "rejected points"),
            };
            add(Mark::Disc, color, format!("{} {words}", count(rejected)));
        }
        let body = if self.view == FitView::Wire { Mark::Line } else { Mark::Body };
        let parts = self.fit.bodies().count();
        for part in 0..parts {
            let color = self.tint(part, palette);
            let text = match (parts, part, self.automatic) {
                (1, _, None) => "fit".to_owned(),
                (1, _, Some(_)) => "shape set by hand".to_owned(),
                (_, 0, Some(_)) => "part 1, set by hand".to_owned(),
                (_, part, _) => format!("part {}", part + 1),
            };
            add(body, color, text);
        }
        if self.automatic.is_some() {
            add(Mark::Line, palette.ghost_line, "the fit".to_owned());
        }
        if let Some((name, _)) = self.trial {
            add(Mark::Line, palette.trial, name.to_owned());
        }
        Legend { title: self.title.clone(), rows }
    }

    /// Colour of a part; while errors are shown, bodies are a quiet grey.
    fn tint(&self, part: usize, palette: &Palette) -> [f32; 4] {
        if self.view == FitView::Error { palette.ghost_line } else { palette.parts[part % palette.parts.len()] }
    }
}

impl Composer {
    /// Draws the examined fit; everything else is drawn by the others.
    pub(super) fn add_lab(&mut self, frame: &mut Frame, lab: &LabContent<'_>, palette: &Palette) {
        add_points(frame, lab, palette);
        let pick_id = Pick::Cluster(lab.cluster as u32).id();
        for (part, superquadric) in lab.fit.bodies().enumerate() {
            let mesh = self.fit_mesh(superquadric);
            let mut color = lab.tint(part, palette);
            if lab.view == FitView::Wire {
                add_wire(frame, &mesh, &superquadric.X_FS, color, 1.3);
            }
            color[3] = match lab.view {
                FitView::Solid => 0.42,
                FitView::Wire => 0.05,
                FitView::Error => 0.30,
            };
            if lab.points_out_rejected {
                color[3] *= 0.5;
            }
            let X_WM = superquadric.X_FS;
            frame.meshes.push(MeshDraw { mesh, X_WM, color, surface: Surface::Satin, pick_id });
        }
        for (fit, color) in [(lab.automatic, palette.ghost_line), (lab.trial.map(|(_, fit)| fit), palette.trial)] {
            for superquadric in fit.iter().flat_map(|fit| fit.bodies()) {
                let mesh = self.fit_mesh(superquadric);
                add_wire(frame, &mesh, &superquadric.X_FS, color, 1.1);
            }
        }
    }

    pub(super) fn fit_mesh(&mut self, superquadric: &Superquadric) -> Arc<Mesh> {
        let shape = Superquadric { X_FS: Isometry3::identity(), ..*superquadric };
        if let Some((_, mesh)) = self.fits.iter().find(|(known, _)| *known == shape) {
            return mesh.clone();
        }
        if self.fits.len() > 64 {
            self.fits.clear();
        }
        let mesh = Arc::new(shape.mesh_in_axes(FIT_MESH_HALF));
        self.fits.push((shape, mesh.clone()));
        mesh
    }
}

/// Input, mirrored and rejected points.
fn add_points(frame: &mut Frame, lab: &LabContent<'_>, palette: &Palette) {
    let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(f64::to_bits);
    let left_out: BTreeSet<[u64; 3]> = lab.fit.rejected.iter().map(|point| key(&point.p_F)).collect();
    let scale = lab.scale();
    let faint = if lab.points_out_rejected { 0.25 } else { 1.0 };
    let shown = |color: [f32; 4]| bytes_of([color[0], color[1], color[2], color[3] * faint]);
    let mut add = |points: Vec<Point3<f64>>, colors: Vec<[u8; 4]>, diameter_m: f64| {
        if !points.is_empty() {
            let (points, colors) = (Arc::new(points), Arc::new(colors));
            frame.points.push(PointsDraw { points, colors, diameter_m: diameter_m as f32 });
        }
    };
    let (mut inputs, mut colors) = (Vec::new(), Vec::new());
    let (mut rejected, mut rejected_colors) = (Vec::new(), Vec::new());
    for (index, p_W) in lab.points.iter().enumerate() {
        let distance_mm = lab.distances_m.get(index).map_or(f64::NAN, |d| 1e3 * d);
        if left_out.contains(&key(p_W)) {
            let [red, green, blue, _] = palette.rejected;
            // Among errors a red of their own would read as “inside”: there they are told by their size.
            let color = if lab.view == FitView::Error { scale.color(distance_mm) } else { [red, green, blue, 1.0] };
            rejected.push(*p_W);
            rejected_colors.push(bytes_of(color));
            continue;
        }
        let color = if lab.view == FitView::Error { scale.color(distance_mm) } else { palette.cloud };
        inputs.push(*p_W);
        colors.push(shown(color));
    }
    let has_lines = lab.view == FitView::Wire || lab.automatic.is_some() || lab.trial.is_some();
    let between_lines = usize::from(has_lines);
    add(inputs, colors, POINT_M[between_lines]);
    if lab.view != FitView::Error {
        add(lab.fit.mirrored.clone(), vec![shown(palette.mirrored)], MIRRORED_M[between_lines]);
    }
    add(rejected, rejected_colors, REJECTED_M[usize::from(lab.points_out_rejected)]);
}

/// Meridians and rings of a superquadric's mesh (two poles, then rings of equal length from north to south).
fn add_wire(frame: &mut Frame, mesh: &Mesh, X_WM: &Isometry3<f64>, color: [f32; 4], width_px: f32) {
    let (columns, rings) = (8 * FIT_MESH_HALF as usize, 4 * FIT_MESH_HALF as usize - 1);
    if mesh.positions.len() != 2 + columns * rings {
        return;
    }
    let at = |index: usize| X_WM * mesh.positions[index];
    let vertex = |ring: usize, column: usize| at(2 + ring * columns + column % columns);
    for column in (0..columns).step_by(WIRE_STEP) {
        let along = (0..rings).map(|ring| vertex(ring, column));
        let line = std::iter::once(at(0)).chain(along).chain(std::iter::once(at(1))).collect();
        frame.lines.push(LineDraw::new(line, color, width_px));
    }
    for ring in (WIRE_STEP - 1..rings).step_by(WIRE_STEP) {
        let line = (0..=columns).map(|column| vertex(ring, column)).collect();
        frame.lines.push(LineDraw::new(line, color, width_px));
    }
}

/// The next larger of 1, 1.5, 2, 3, 5, 7, 10, … times a power of ten; at least 0.01.
fn round_up(value: f64) -> f64 {
    let mut decade = 0.01;
    while decade < 1e6 {
        for digit in [1.0, 1.5, 2.0, 3.0, 5.0, 7.0] {
            if digit * decade >= value {
                return digit * decade;
            }
        }
        decade *= 10.0;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_end_at_a_round_number() {
        for (value, end) in [(0.0, 0.01), (0.82, 1.0), (1.2, 1.5), (4.1, 5.0), (7.4, 10.0), (31.0, 50.0)] {
            assert!((round_up(value) - end).abs() < 1e-9, "{value}: {}", round_up(value));
        }
    }

    #[test]
    fn the_wire_lies_on_the_surface_and_closes() {
        let X_FS = Isometry3::translation(0.4, 0.1, 0.8);
        let superquadric = Superquadric::new(0.03, 0.05, 0.1, 0.3, 1.2, X_FS).unwrap();
        let mut frame = Frame::default();
        let mesh = Composer::default().fit_mesh(&superquadric);
        add_wire(&mut frame, &mesh, &X_FS, [1.0; 4], 1.0);
        let (columns, rings) = (8 * FIT_MESH_HALF as usize, 4 * FIT_MESH_HALF as usize - 1);
        assert_eq!(frame.lines.len(), columns / WIRE_STEP + rings / WIRE_STEP);
        for p_W in frame.lines.iter().flat_map(|line| &line.points) {
            assert!(superquadric.signed_radial_distance(p_W).abs() < 1e-9, "{p_W:?}");
        }
        let ring = &frame.lines.last().unwrap().points;
        assert!((ring[0] - ring[ring.len() - 1]).norm() < 1e-12);
    }
}
