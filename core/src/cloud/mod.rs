//! Point clouds: reading and writing, voxel grids and the synthetic RGB-D camera.
//!
//! [`read_cloud`] takes the bytes of a PCD, PLY or XYZ file, [`write_pcd`] and [`write_ply`] give them back.
//! [`depth_cloud`] makes a cloud of a depth image and its camera's [`Intrinsics`]. [`RgbdCamera`] sees a scene of meshes
//! as a depth sensor would: partial, noisy, quantised. What is not here: meshes as input, normals of points (the
//! segmentation and the fit need none).

mod camera;
mod depth;
mod error;
mod noise;
mod packed;
mod pcd;
mod pcd_header;
mod pcd_write;
mod ply;
mod ply_header;
mod ply_write;
mod point_cloud;
mod raster;
mod read;
mod scalar;
mod sensor;
mod voxel;
mod xyz;

pub use camera::{RgbdCamera, SeenBody, View};
pub use depth::{Intrinsics, MAX_DEPTH_SIDE, depth_cloud};
pub use error::CloudError;
pub use noise::DepthNoise;
pub use pcd_write::{PcdEncoding, write_pcd};
pub use ply_write::{PlyEncoding, write_ply};
pub use point_cloud::{PixelGrid, PointCloud};
pub use read::{MAX_COORDINATE_M, MAX_POINTS, read_cloud};
pub use voxel::voxel_centroids;
