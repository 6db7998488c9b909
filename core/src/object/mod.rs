//! Household objects described from published sizes: shape, mesh, and how a camera sees them on a table.
//!
//! An object is a JSON file in `objects/`: solid parts, each a stack of superellipse sections. [`HouseholdObject::parse`]
//! refuses what cannot be a solid, so meshes and extents of a parsed object always exist. What is not here: hollow
//! objects (a glass is a closed solid) and textures.

mod brought;
mod error;
mod household;
mod loft;
mod solids;
mod view;

pub use error::ObjectError;
pub use household::{HouseholdObject, Part};
pub use solids::box_mesh;
pub use view::{SceneBody, SceneView, view_scene};
