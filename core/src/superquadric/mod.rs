//! Superquadrics: implicit and explicit form, normals, distance, volume, uniform sampling, meshing (thesis 3.1, 4.2).
//!
//! Everything rests on the gauge `ρ(p) = f(p)^(e1/2)`, which is positively homogeneous (`ρ(s p) = s ρ(p)`), 1 on the
//! surface, and convex for exponents up to 2. It is computed in logarithms ([`gauge`](self)), where an exponent of
//! 0.01 and a point on an axis plane are ordinary inputs. Tapered and bent shapes are this base shape seen through
//! [`deformation`](self): every question about a point is asked at its base point.
//!
//! Not here: concave (`e > 2`) shapes.

mod bend;
mod bent_box;
mod deformation;
mod deformed_distance;
mod distance;
mod explicit;
mod foot;
mod gauge;
mod implicit;
mod kernels;
mod mesh;
mod ray;
mod sampling;
mod shape;
mod superellipse;
mod support;
mod taper;
mod volume;

#[allow(unused_imports, reason = "the fit takes it from here")]
pub(crate) use deformation::{Deformation, Undeformed};
pub use distance::DistanceField;
pub(crate) use gauge::AxesGauge;
pub(crate) use kernels::fast_exp;
pub use ray::RayHit;
pub use sampling::SurfaceSample;
pub use shape::{EXPONENT_MAX, EXPONENT_MIN, Superquadric, SuperquadricError, TAPER_MAX, bend_limit_per_m};
