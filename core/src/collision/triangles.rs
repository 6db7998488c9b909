//! A closed triangle mesh as a surface: signed distance and nearest point, through parry's bounding-volume tree.

use nalgebra::{Point3, Vector3};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

use super::model::CollisionError;
use super::parry::{from_parry, to_parry};
use crate::mesh::Mesh;
use crate::superquadric::SurfaceSample;

/// A closed mesh in its frame O; normals point out of it.
pub struct TriangleSurface {
    mesh: TriMesh,
}

impl TriangleSurface {
    /// From a mesh whose triangles turn counter-clockwise seen from outside; equal corners are merged.
    ///
    /// # Errors
    /// [`CollisionError`] when a corner is not finite or there is no triangle.
    pub fn new(thing: &str, mesh: &Mesh) -> Result<Self, CollisionError> {
        if let Some(index) = mesh.positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(CollisionError::PointNotFinite { thing: thing.to_owned(), index });
        }
        let corners = mesh.positions.iter().map(|p| to_parry(&p.coords)).collect();
        let triangles = mesh.triangles.clone();
        let flags = TriMeshFlags::ORIENTED | TriMeshFlags::MERGE_DUPLICATE_VERTICES;
        let no_volume = |_| CollisionError::NoVolume { thing: thing.to_owned(), points: mesh.positions.len() };
        Ok(Self { mesh: TriMesh::with_flags(corners, triangles, flags).map_err(no_volume)? })
    }

    /// Signed distance of a point, metres; negative inside.
    pub(crate) fn signed_distance(&self, p_O: &Point3<f64>) -> f64 {
        let found = self.mesh.project_local_point(to_parry(&p_O.coords), false);
        let distance = (p_O.coords - from_parry(found.point)).norm();
        if found.is_inside { -distance } else { distance }
    }

    /// The nearest point of the surface and the outward normal there.
    pub(crate) fn foot(&self, p_O: &Point3<f64>) -> SurfaceSample {
        let (found, feature) = self.mesh.project_local_point_and_get_feature(to_parry(&p_O.coords));
        let foot = from_parry(found.point);
        let away = if found.is_inside { foot - p_O.coords } else { p_O.coords - foot };
        // On the surface itself the triangle speaks.
        let normal = away.try_normalize(1e-7).unwrap_or_else(|| {
            let face = match feature {
                parry3d_f64::shape::FeatureId::Face(face) => face as usize % self.mesh.indices().len(),
                _ => 0,
            };
            let normal = self.mesh.triangle(face as u32).normal();
            normal.map_or_else(Vector3::z, from_parry)
        });
        SurfaceSample { p_F: Point3::from(foot), n_F: normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::box_mesh;
    use crate::rng::Rng;

    #[test]
    fn a_box_has_the_distances_of_a_box_inside_and_outside() {
        let half = Vector3::new(0.03, 0.05, 0.1);
        let surface = TriangleSurface::new("box", &box_mesh(&(2.0 * half))).unwrap();
        let mut rng = Rng::new(1, 0);
        for _ in 0..2000 {
            let p = Point3::from(Vector3::from_fn(|_, _| rng.uniform(-0.15, 0.15)));
            let over = p.coords.abs() - half;
            let truth = over.sup(&Vector3::zeros()).norm() + over.max().min(0.0);
            let found = surface.signed_distance(&p);
            assert!((found - truth).abs() < 1e-9, "{found} against {truth} at {p}");
            let foot = surface.foot(&p);
            assert!(((foot.p_F - p).norm() - truth.abs()).abs() < 1e-9);
            assert!((p - foot.p_F).dot(&foot.n_F) * truth.signum() > -1e-9);
        }
    }
}
