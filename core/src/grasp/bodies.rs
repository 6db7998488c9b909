//! The object as a hand meets it: the union of its fitted bodies, or its points, or its mesh.

use nalgebra::{Isometry3, Point3, Vector3};

use super::surfels::Surfels;
use crate::collision::TriangleSurface;
use crate::superquadric::{DistanceField, Superquadric, SurfaceSample};

/// A sample or contact this deep inside another body is no surface of the object, metres.
const COVERED_M: f64 = 1e-6;

/// What fingers close on, in the object frame O.
pub enum Touched {
    /// The fitted bodies themselves.
    Bodies,
    /// Measured points with their normals.
    Points(Surfels),
    /// A closed mesh.
    Mesh(TriangleSurface),
}

/// Superquadrics in the object frame O that together are one object; the first is at the identity.
pub(super) struct Bodies {
    shapes: Vec<Superquadric>,
    fields: Vec<DistanceField>,
    touched: Touched,
    /// What torques are measured about and divided by: the object's centre, and half its longest edge, metres.
    pub(super) center_O: Point3<f64>,
    pub(super) size_m: f64,
}

impl Bodies {
    /// The union of these bodies; fingers close on `touched`.
    pub(super) fn new(shapes: &[Superquadric], touched: Touched) -> Self {
        let (center_O, size_m) = match shapes {
            [only] if !only.is_deformed() => {
                (Point3::from(only.X_FS.translation.vector), only.a.max(only.b).max(only.c))
            }
            _ => {
                let boxes = shapes.iter().map(|shape| shape.bounding_box_in(&Isometry3::identity()));
                let empty = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
                let (low, high) = boxes.fold(empty, |(l, h), (low, high)| (l.inf(&low.coords), h.sup(&high.coords)));
                (Point3::from((low + high) * 0.5), 0.5 * (high - low).max())
            }
        };
        Self {
            shapes: shapes.to_vec(),
            fields: shapes.iter().map(Superquadric::distance_field).collect(),
            touched,
            center_O,
            size_m,
        }
    }

    /// Number of bodies.
    pub(super) fn len(&self) -> usize {
        self.shapes.len()
    }

    /// A lower bound of the signed distance from the object, metres: that of the nearest body.
    #[inline]
    pub(super) fn signed_distance(&self, p_O: &Point3<f64>) -> f64 {
        match &self.touched {
            Touched::Bodies => self.fields.iter().map(|f| f.signed_distance(p_O)).fold(f64::INFINITY, f64::min),
            Touched::Points(surfels) => surfels.signed_distance(p_O),
            Touched::Mesh(mesh) => mesh.signed_distance(p_O),
        }
    }

    /// As [`Bodies::signed_distance`], tight where a body is near: slower, for the few points that matter.
    pub(super) fn near_distance(&self, p_O: &Point3<f64>) -> f64 {
        match &self.touched {
            Touched::Bodies => self.fields.iter().map(|f| f.near_distance(p_O)).fold(f64::INFINITY, f64::min),
            _ => self.signed_distance(p_O),
        }
    }

    /// Where a ball of this radius around a point touches the object, a point of its surface and the normal there;
    /// `None` when the place is inside another body or the ball stays more than `give_m` away.
    pub(super) fn contact(&self, p_O: &Point3<f64>, radius_m: f64, give_m: f64) -> Option<SurfaceSample> {
        let (foot, distance_m, is_covered) = match &self.touched {
            Touched::Bodies => {
                let distances = self.fields.iter().map(|field| field.near_distance(p_O));
                let (nearest, distance_m) = distances.enumerate().min_by(|l, r| l.1.total_cmp(&r.1))?;
                let foot = self.fields[nearest].foot(p_O);
                let is_covered = self.is_covered(nearest, &foot.p_F);
                (foot, distance_m, is_covered)
            }
            Touched::Points(surfels) => (surfels.foot(p_O)?, surfels.signed_distance(p_O), false),
            Touched::Mesh(mesh) => (mesh.foot(p_O), mesh.signed_distance(p_O), false),
        };
        let is_away = distance_m > 0.0 && (foot.p_F - p_O).norm() > radius_m + give_m;
        (!is_away && !is_covered).then_some(foot)
    }

    /// Surface samples of one body that are not inside another.
    pub(super) fn samples(&self, body: usize, density: u32) -> Vec<SurfaceSample> {
        let mut samples = self.shapes[body].samples(density);
        samples.retain(|sample| !self.is_covered(body, &sample.p_F));
        samples
    }

    /// The axes of a body in O with its semi-axes, the shortest first, as its bend turns them at a point.
    pub(super) fn axes_at(&self, body: usize, p_O: &Point3<f64>) -> [(f64, Vector3<f64>); 3] {
        let shape = &self.shapes[body];
        let R_OS = shape.local_axes(p_O);
        let semi_axes = shape.semi_axes();
        let mut axes = [0, 1, 2].map(|k| (semi_axes[k], R_OS.column(k).into_owned()));
        axes.sort_by(|l, r| l.0.total_cmp(&r.0));
        axes
    }

    fn is_covered(&self, body: usize, p_O: &Point3<f64>) -> bool {
        let others = self.fields.iter().enumerate().filter(|(other, _)| *other != body);
        others.into_iter().any(|(_, field)| field.signed_distance(p_O) < -COVERED_M)
    }
}
