//! Named obstacles that stand still.

use std::sync::{Arc, OnceLock};

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::hull::ConvexHull;
use super::model::CollisionError;
use super::solid::{Core, Solid};
use super::tree::Tree;
use super::voxels::limit;
use crate::mesh::Mesh;
use crate::scene::{Obstacle, TableTop};

/// Obstacles in the world frame W, each with the name that reasons use.
#[derive(Clone, Debug, Default)]
pub struct World {
    pub(crate) obstacles: Vec<WorldBody>,
    /// Over the obstacles' boxes; made when it is first asked for.
    tree: OnceLock<Arc<Tree>>,
}

/// One convex obstacle.
#[derive(Clone, Debug)]
pub(crate) struct WorldBody {
    pub(crate) name: String,
    pub(crate) solid_W: Solid,
    /// Corners of the axis-aligned box around it.
    pub(crate) lower: Vector3<f64>,
    pub(crate) upper: Vector3<f64>,
}

/// Triangles that a mesh may have.
pub const MOST_TRIANGLES: usize = 1 << 16;

impl World {
    /// An empty world.
    pub fn new() -> Self {
        Self::default()
    }

    /// Names of the obstacles in the order in which they were added.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.obstacles.iter().map(|obstacle| obstacle.name.as_str())
    }

    /// A box with these edge lengths, metres, its centre at `X_WB`.
    ///
    /// # Errors
    /// [`CollisionError::BadSize`] if a length is not finite or not greater than 0.
    pub fn add_box(&mut self, name: &str, size_m: Vector3<f64>, X_WB: &Isometry3<f64>) -> Result<(), CollisionError> {
        for edge in size_m.iter() {
            positive(name, "box edge", *edge)?;
        }
        self.push(name, Core::Box { half: 0.5 * size_m }, X_WB)
    }

    /// A cylinder along z of its frame, centred at `X_WB`, metres.
    ///
    /// # Errors
    /// [`CollisionError::BadSize`] if radius or length is not finite or not greater than 0.
    pub fn add_cylinder(
        &mut self,
        name: &str,
        radius_m: f64,
        length_m: f64,
        X_WB: &Isometry3<f64>,
    ) -> Result<(), CollisionError> {
        positive(name, "cylinder radius", radius_m)?;
        positive(name, "cylinder length", length_m)?;
        self.push(name, Core::Cylinder { radius: radius_m, half_length: 0.5 * length_m }, X_WB)
    }

    /// The convex hull of points given in the frame O, metres, standing at `X_WO`: a fitted superquadric's mesh, a
    /// cluster.
    ///
    /// # Errors
    /// [`CollisionError`] if a point is not finite or the points span no volume.
    pub fn add_points(
        &mut self,
        name: &str,
        points_O: &[Point3<f64>],
        X_WO: &Isometry3<f64>,
    ) -> Result<(), CollisionError> {
        self.add_hull(name, &ConvexHull::new(name, points_O)?, X_WO)
    }

    /// A hull in its frame O, standing at `X_WO`.
    ///
    /// # Errors
    /// [`CollisionError`] if the pose is not finite.
    pub fn add_hull(&mut self, name: &str, hull_O: &ConvexHull, X_WO: &Isometry3<f64>) -> Result<(), CollisionError> {
        self.push(name, Core::Hull(hull_O.clone()), X_WO)
    }

    /// A mesh in its frame O, standing at `X_WO`, as the surface that it is: each triangle is a body of its own. What is
    /// inside of a closed mesh touches nothing; no motion gets there without touching.
    ///
    /// # Errors
    /// [`CollisionError`] if a corner is missing or not finite, or there are more than [`MOST_TRIANGLES`] triangles.
    pub fn add_mesh(&mut self, name: &str, mesh_O: &Mesh, X_WO: &Isometry3<f64>) -> Result<(), CollisionError> {
        limit(name, "triangles", mesh_O.triangles.len(), MOST_TRIANGLES)?;
        if let Some(index) = mesh_O.positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(CollisionError::PointNotFinite { thing: name.to_owned(), index });
        }
        let corners = mesh_O.positions.len();
        for (triangle, names) in mesh_O.triangles.iter().enumerate() {
            if let Some(&corner) = names.iter().find(|&&corner| corner as usize >= corners) {
                return Err(CollisionError::NoSuchCorner { thing: name.to_owned(), triangle, corner, corners });
            }
        }
        for names in &mesh_O.triangles {
            let corners_O = names.map(|corner| mesh_O.positions[corner as usize].coords);
            let middle_O = corners_O.iter().sum::<Vector3<f64>>() / 3.0;
            let core = Core::Triangle { corners: corners_O.map(|corner| corner - middle_O) };
            self.push(name, core, &(X_WO * Translation3::from(middle_O)))?;
        }
        Ok(())
    }

    /// The slab of a table, named `table`.
    ///
    /// # Errors
    /// [`CollisionError::BadSize`] if an extent is not finite or not greater than 0.
    pub fn add_table(&mut self, table: &TableTop) -> Result<(), CollisionError> {
        let size_m = Vector3::new(table.size_m[0], table.size_m[1], table.thickness_m);
        let center = Vector3::new(table.center_m[0], table.center_m[1], table.height_m - 0.5 * table.thickness_m);
        self.add_box("table", size_m, &Isometry3::from_parts(Translation3::from(center), UnitQuaternion::identity()))
    }

    /// A known box of the scene.
    ///
    /// # Errors
    /// As [`World::add_box`].
    pub fn add_obstacle(&mut self, obstacle: &Obstacle) -> Result<(), CollisionError> {
        self.add_box(&obstacle.name, obstacle.size_m, &obstacle.X_WB)
    }

    /// Takes an obstacle out, for instance because it was picked up; whether there was one of this name.
    pub fn remove(&mut self, name: &str) -> bool {
        let before = self.obstacles.len();
        self.tree = OnceLock::new();
        self.obstacles.retain(|obstacle| obstacle.name != name);
        self.obstacles.len() < before
    }

    fn push(&mut self, name: &str, core: Core, X_WB: &Isometry3<f64>) -> Result<(), CollisionError> {
        if !X_WB.translation.vector.iter().chain(X_WB.rotation.coords.iter()).all(|x| x.is_finite()) {
            return Err(CollisionError::PoseNotFinite { thing: name.to_owned() });
        }
        let solid_W = Solid::new(core, 0.0, X_WB);
        let (lower, upper) = solid_W.aabb();
        self.tree = OnceLock::new();
        self.obstacles.push(WorldBody { name: name.to_owned(), solid_W, lower, upper });
        Ok(())
    }

    /// A tree over the boxes around all obstacles.
    pub(crate) fn tree(&self) -> &Arc<Tree> {
        let boxes = || self.obstacles.iter().map(|obstacle| (obstacle.lower, obstacle.upper)).collect::<Vec<_>>();
        self.tree.get_or_init(|| Arc::new(Tree::new(&boxes())))
    }
}

/// Checks that a size is finite and greater than 0.
pub(crate) fn positive(thing: &str, what: &'static str, found: f64) -> Result<(), CollisionError> {
    if found.is_finite() && found > 0.0 {
        Ok(())
    } else {
        Err(CollisionError::BadSize { thing: thing.to_owned(), what, found })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_points_that_make_no_body_are_refused_by_name() {
        let mut world = World::new();
        let here = Isometry3::identity();
        assert!(matches!(
            world.add_box("crate", Vector3::new(0.1, 0.0, 0.1), &here),
            Err(CollisionError::BadSize { thing, found: 0.0, .. }) if thing == "crate"
        ));
        assert!(world.add_cylinder("can", f64::NAN, 0.1, &here).is_err());
        let flat: Vec<_> = (0..4).map(|k| Point3::new(f64::from(k % 2), f64::from(k / 2), 0.0)).collect();
        assert!(matches!(world.add_points("leaf", &flat, &here), Err(CollisionError::NoVolume { points: 4, .. })));
        let bad = [Point3::new(0.0, f64::INFINITY, 0.0)];
        assert!(matches!(world.add_points("leaf", &bad, &here), Err(CollisionError::PointNotFinite { index: 0, .. })));
        assert_eq!(world.names().count(), 0);
    }
}
