//! A surface with smooth normals, and how it is written as OBJ.

use std::fmt::Write as _;

/// A point or direction.
pub(super) type V3 = [f64; 3];

/// Vertices with normals, and faces of three or four corners, counter-clockwise seen from outside. Metres.
#[derive(Clone, Default)]
pub(super) struct Surface {
    pub(super) points: Vec<V3>,
    pub(super) normals: Vec<V3>,
    pub(super) faces: Vec<Vec<usize>>,
}

pub(super) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The vector at length 1; z where it has none.
pub(super) fn unit(v: V3) -> V3 {
    let norm = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    if norm > 1e-12 { v.map(|x| x / norm) } else { [0.0, 0.0, 1.0] }
}

impl Surface {
    /// Everything of another surface as well.
    pub(super) fn with(mut self, other: Self) -> Self {
        let base = self.points.len();
        self.points.extend(other.points);
        self.normals.extend(other.normals);
        self.faces.extend(other.faces.into_iter().map(|face| face.into_iter().map(|i| i + base).collect()));
        self
    }

    /// Moved.
    pub(super) fn at(mut self, x: f64, y: f64, z: f64) -> Self {
        for p in &mut self.points {
            *p = [p[0] + x, p[1] + y, p[2] + z];
        }
        self
    }

    /// What lay along z lies along y: (x, y, z) → (x, z, -y).
    pub(super) fn z_to_y(self) -> Self {
        self.map(|[x, y, z]| [x, z, -y])
    }

    /// What lay along z lies along x: (x, y, z) → (z, y, -x).
    pub(super) fn z_to_x(self) -> Self {
        self.map(|[x, y, z]| [z, y, -x])
    }

    /// Turned about z by an angle in radians.
    pub(super) fn turned(self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        self.map(|[x, y, z]| [cos * x - sin * y, sin * x + cos * y, z])
    }

    /// Points and normals through a rotation.
    fn map(mut self, rotate: impl Fn(V3) -> V3) -> Self {
        self.points.iter_mut().for_each(|p| *p = rotate(*p));
        self.normals.iter_mut().for_each(|n| *n = rotate(*n));
        self
    }

    /// A grid of points, row by row upwards, closed around each row; normals from the neighbours along and across, and
    /// along z where a row has shrunk to a pole.
    pub(super) fn closed_rows(rows: &[Vec<V3>]) -> Self {
        let mut surface = Self::default();
        for (i, row) in rows.iter().enumerate() {
            let (below, above) = (&rows[i.saturating_sub(1)], &rows[(i + 1).min(rows.len() - 1)]);
            let n = row.len();
            for j in 0..n {
                let around = sub(row[(j + 1) % n], row[(j + n - 1) % n]);
                let normal = cross(around, sub(above[j], below[j]));
                let at_pole = around.iter().all(|x| x.abs() < 1e-9);
                surface.points.push(row[j]);
                surface.normals.push(if at_pole { [0.0, 0.0, if i == 0 { -1.0 } else { 1.0 }] } else { unit(normal) });
            }
        }
        surface.stitch(rows.len(), rows.first().map_or(0, Vec::len));
        surface
    }

    /// Faces between the rows of a grid that is closed around each row.
    pub(super) fn stitch(&mut self, rows: usize, n: usize) {
        for i in 1..rows {
            for j in 0..n {
                let next = (j + 1) % n;
                let (low, high) = ((i - 1) * n, i * n);
                let corners = [low + j, low + next, high + next, high + j];
                let mut face: Vec<usize> = Vec::with_capacity(4);
                for corner in corners {
                    let p = self.points[corner];
                    if !face.iter().any(|&other| {
                        let d = sub(self.points[other], p);
                        d.iter().all(|x| x.abs() < 1e-7)
                    }) {
                        face.push(corner);
                    }
                }
                if face.len() >= 3 {
                    self.faces.push(face);
                }
            }
        }
    }

    /// OBJ text: 0.1 mm and a thousandth of a normal, equal rows written once.
    pub(super) fn to_obj(&self, title: &str) -> String {
        let mut written = String::new();
        let mut indices = |values: &[V3], decimals: usize, key: &str| -> Vec<usize> {
            let mut known = std::collections::BTreeMap::new();
            let mut index = |&value: &V3| {
                let row = number_row(value, decimals);
                let next = known.len() + 1;
                *known.entry(row).or_insert_with_key(|row| {
                    let _ = writeln!(written, "{key} {row}");
                    next
                })
            };
            values.iter().map(&mut index).collect()
        };
        let points = indices(&self.points, 4, "v");
        let normals = indices(&self.normals, 3, "vn");
        let mut obj = format!("# {title}; written by `cargo xtask robots`, metres\n");
        obj += &written;
        for face in &self.faces {
            let mut corners: Vec<(usize, usize)> = face.iter().map(|&i| (points[i], normals[i])).collect();
            corners.dedup_by_key(|corner| corner.0);
            if corners.len() > 3 && corners.first().map(|c| c.0) == corners.last().map(|c| c.0) {
                corners.pop();
            }
            if corners.len() >= 3 {
                obj.push('f');
                for (point, normal) in corners {
                    let _ = write!(obj, " {point}//{normal}");
                }
                obj.push('\n');
            }
        }
        obj
    }
}

/// Three numbers with as few characters as possible: `.0512 0 -.98`.
fn number_row(v: V3, decimals: usize) -> String {
    let short = |x: f64| {
        let text = format!("{x:.decimals$}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        match text.strip_prefix("-0").or_else(|| text.strip_prefix('0')) {
            Some("") => "0".to_owned(),
            Some(fraction) if text.starts_with('-') => format!("-{fraction}"),
            Some(fraction) => fraction.to_owned(),
            None => text.to_owned(),
        }
    };
    v.map(short).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_short_and_exact() {
        assert_eq!(number_row([0.05120, -0.00004, -0.98], 4), ".0512 0 -.98");
        assert_eq!(number_row([10.5, -1.0, 0.5], 3), "10.5 -1 .5");
    }
}
