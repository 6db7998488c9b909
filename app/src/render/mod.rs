//! One renderer for the window, the page, the figures and the tests.
//!
//! A [`Frame`] says what is to be seen and a [`View`] from where; [`Renderer::draw`] turns both into a [`Target`],
//! a gamma-space texture with premultiplied alpha that egui shows as it is. The renderer stays within the limits of
//! WebGL2: no compute, no storage buffers, instance data in vertex buffers, every intermediate picture in RGBA8.
//!
//! One picture is five passes: a shadow map (kept while nothing moves), a small picture of depths and normals, soft
//! shadow and ambient occlusion from those two, their smoothing, and the picture itself with four samples per pixel.
//! Labels and colour bars are egui's business: [`Camera::project`] and [`Scale`] say where and in which colours.

mod bounds;
mod camera;
mod colormap;
mod cut;
mod fields;
mod floor;
mod frame;
mod globals;
mod gpu;
mod lighting;
mod lines;
mod meshes;
#[cfg(not(target_arch = "wasm32"))]
mod offscreen;
mod pick;
mod points;
mod readback;
mod renderer;
pub mod shapes;
mod size;
mod target;
mod theme;
mod view;

#[cfg(test)]
#[cfg(not(target_arch = "wasm32"))]
mod tests;

pub use bounds::{Bounds, BoundsCache};
pub use camera::{Camera, Named, Projection, Ray};
pub use colormap::{ColorMap, Scale};
pub use cut::Cut;
pub use frame::{Frame, LineDraw, MeshDraw, PointsDraw, Surface, bytes_of};
#[cfg(not(target_arch = "wasm32"))]
pub use offscreen::{Offscreen, OffscreenError};
pub use pick::{Hit, Picker, pick};
pub use readback::Readback;
pub use renderer::{Quality, Renderer};
pub use size::{MAX_SIDE_PX, SizeError, check_scale, check_size};
pub use target::Target;
pub use theme::Theme;
pub use view::View;
