//! What people bring: files that were dropped, opened or named, sorted by what they are.

mod depth;
#[cfg(not(target_arch = "wasm32"))]
pub mod disk;
mod mesh;
mod robot;

pub use depth::{DepthImage, is_png};
pub use mesh::{BroughtMesh, alone, is_mesh};
pub use robot::{DEFAULT_HAND, proposed, settled};
