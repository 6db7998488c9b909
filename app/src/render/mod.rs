//! One renderer for the window, the page, the figures and the tests.

mod frame;

pub use frame::{Frame, LineDraw, MeshDraw, PointsDraw, Surface};
