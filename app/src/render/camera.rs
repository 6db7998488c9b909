//! An orbit camera: right-handed, z up, in f64 until its matrices are written for the GPU.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use nalgebra::{Matrix4, Point2, Point3, Rotation3, Unit, Vector3};
use serde::{Deserialize, Serialize};

use super::Bounds;

/// Closest and farthest distance from the target, in metres.
const DISTANCE_RANGE_M: [f64; 2] = [0.02, 500.0];

/// How depth is put on the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Projection {
    /// Far things are smaller.
    #[default]
    Perspective,
    /// Parallels stay parallel; the picture is as high as a perspective one is at the target.
    Orthographic,
}

/// The views with names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named {
    /// Facing a robot that looks along +x: from +x, with +y to the right.
    Front,
    /// From behind the robot.
    Back,
    /// From the left-hand side of [`Named::Front`].
    Left,
    /// From the right-hand side of [`Named::Front`]: from +y, with −x to the right.
    Right,
    /// From above, up on the picture is −x, as seen from the front.
    Top,
    /// From below.
    Bottom,
    /// From a corner, so that all three axes are equally long on an orthographic picture.
    Corner,
}

impl Named {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Front, Self::Back, Self::Left, Self::Right, Self::Top, Self::Bottom, Self::Corner];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Front => "From the front",
            Self::Back => "From behind",
            Self::Left => "From the left",
            Self::Right => "From the right",
            Self::Top => "From above",
            Self::Bottom => "From below",
            Self::Corner => "From a corner",
        }
    }
}

/// A half line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, in the world.
    pub origin: Point3<f64>,
    /// Direction, in the world.
    pub direction: Unit<Vector3<f64>>,
}

impl Ray {
    /// The point at a distance in metres.
    pub fn at(&self, distance_m: f64) -> Point3<f64> {
        self.origin + *self.direction * distance_m
    }

    /// Where the ray meets the horizontal plane of height `z`, if it does, before it ends.
    pub fn meet_height(&self, z: f64) -> Option<Point3<f64>> {
        let distance_m = (z - self.origin.z) / self.direction.z;
        (distance_m.is_finite() && distance_m > 0.0).then(|| self.at(distance_m))
    }
}

/// A camera that turns about a target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// What it looks at, in the world.
    pub target: Point3<f64>,
    /// From the eye to the target, in metres.
    pub distance_m: f64,
    /// Direction from the target to the eye about z; 0 is +x, π/2 is +y.
    pub yaw_rad: f64,
    /// Height of the eye over the target's horizon, in [−π/2, π/2].
    pub pitch_rad: f64,
    /// How far the picture is turned about the line of sight; 0 keeps the horizon level. Positive turns the camera
    /// counterclockwise as seen from behind it.
    #[serde(default)]
    pub roll_rad: f64,
    /// Vertical field of view.
    pub fov_y_rad: f64,
    /// Perspective or orthographic.
    pub projection: Projection,
}

impl Default for Camera {
    /// Facing a table in front of a robot that looks along +x, from its left front.
    fn default() -> Self {
        Self {
            target: Point3::new(0.36, 0.0, 0.97),
            distance_m: 2.25,
            yaw_rad: 0.58,
            pitch_rad: 0.36,
            roll_rad: 0.0,
            fov_y_rad: 0.62,
            projection: Projection::Perspective,
        }
    }
}

impl Camera {
    /// Unit vector from the target to the eye.
    pub fn backward(&self) -> Vector3<f64> {
        let (sin_yaw, cos_yaw) = self.yaw_rad.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch_rad.sin_cos();
        Vector3::new(cos_yaw * cos_pitch, sin_yaw * cos_pitch, sin_pitch)
    }

    /// Unit vector to the right on the picture. It exists for every pitch, also straight down.
    pub fn right(&self) -> Vector3<f64> {
        let level = self.level_right();
        let (sin_roll, cos_roll) = self.roll_rad.sin_cos();
        level * cos_roll + self.backward().cross(&level) * sin_roll
    }

    /// The right of a camera without roll.
    fn level_right(&self) -> Vector3<f64> {
        let (sin_yaw, cos_yaw) = self.yaw_rad.sin_cos();
        Vector3::new(-sin_yaw, cos_yaw, 0.0)
    }

    /// Unit vector upwards on the picture.
    pub fn up(&self) -> Vector3<f64> {
        self.backward().cross(&self.right())
    }

    /// Position of the eye.
    pub fn eye(&self) -> Point3<f64> {
        self.target + self.backward() * self.distance_m
    }

    /// Turns about the target: positive yaw moves the eye to the right, positive pitch up.
    pub fn orbit(&mut self, yaw_rad: f64, pitch_rad: f64) {
        self.yaw_rad = wrap(self.yaw_rad + yaw_rad);
        self.pitch_rad = (self.pitch_rad + pitch_rad).max(-FRAC_PI_2).min(FRAC_PI_2);
    }

    /// Turns about the target and the picture's own axes, over the poles and beyond: positive yaw moves the eye to the
    /// right on the picture, positive pitch up.
    pub fn tumble(&mut self, yaw_rad: f64, pitch_rad: f64) {
        let about = |axis: Vector3<f64>, angle: f64| Rotation3::from_axis_angle(&Unit::new_unchecked(axis), angle);
        let turn = about(self.up(), yaw_rad) * about(self.right(), -pitch_rad);
        let (right, backward) = (turn * self.right(), turn * self.backward());
        self.pitch_rad = backward.z.max(-1.0).min(1.0).asin();
        // Straight above or below any yaw will do, and the roll makes up for it.
        if backward.xy().norm() > 1e-9 {
            self.yaw_rad = backward.y.atan2(backward.x);
        }
        let level = self.level_right();
        self.roll_rad = right.dot(&backward.cross(&level)).atan2(right.dot(&level));
    }

    /// Moves in the picture's plane so that `anchor`, seen at pixel `from`, is then seen at pixel `to`.
    pub fn pan(&mut self, anchor: &Point3<f64>, from: Point2<f64>, to: Point2<f64>, size: [f64; 2]) {
        let m_per_px = self.m_per_px(anchor, size);
        let moved = to - from;
        if m_per_px.is_finite() {
            self.target += (self.up() * moved.y - self.right() * moved.x) * m_per_px;
        }
    }

    /// Scales the distance by `factor` (below 1 is nearer) about `anchor`, which keeps its place on the picture.
    pub fn zoom(&mut self, factor: f64, anchor: &Point3<f64>) {
        let [least, most] = DISTANCE_RANGE_M;
        let distance_m = (self.distance_m * factor).max(least).min(most);
        let factor = distance_m / self.distance_m;
        if factor.is_finite() && factor > 0.0 {
            self.target = anchor + (self.target - anchor) * factor;
            self.distance_m = distance_m;
        }
    }

    /// Shows the whole box: same direction, new target and distance. `size` is the picture's, in any unit.
    pub fn frame(&mut self, bounds: &Bounds, size: [f64; 2]) {
        let half_fov = (self.fov_y_rad / 2.0).tan();
        let narrow = half_fov * (size[0] / size[1]).min(1.0);
        // The sphere about the box touches the cone of view where sin(half angle) = radius / distance.
        let sin_narrow = narrow / (1.0 + narrow * narrow).sqrt();
        let [least, most] = DISTANCE_RANGE_M;
        let distance_m = bounds.radius() * 1.05 / sin_narrow;
        if distance_m.is_finite() {
            self.target = bounds.center();
            self.distance_m = distance_m.max(least).min(most);
        }
    }

    /// Looks from a named side at the same target.
    pub fn look_from(&mut self, named: Named) {
        (self.yaw_rad, self.pitch_rad) = match named {
            Named::Front => (0.0, 0.0),
            Named::Back => (-PI, 0.0),
            Named::Left => (-FRAC_PI_2, 0.0),
            Named::Right => (FRAC_PI_2, 0.0),
            Named::Top => (0.0, FRAC_PI_2),
            Named::Bottom => (0.0, -FRAC_PI_2),
            Named::Corner => (FRAC_PI_4, FRAC_1_SQRT_2.atan()),
        };
        self.roll_rad = 0.0;
    }

    /// Half of the picture's height in metres at depth 1 m (perspective) or at any depth (orthographic).
    pub(super) fn half_height(&self) -> f64 {
        let tangent = (self.fov_y_rad / 2.0).tan();
        match self.projection {
            Projection::Perspective => tangent,
            Projection::Orthographic => tangent * self.distance_m,
        }
    }

    /// Depth of a point along the view, in metres from the eye.
    pub fn depth_m(&self, point: &Point3<f64>) -> f64 {
        -(point - self.eye()).dot(&self.backward())
    }

    /// How long one pixel is at the depth of a point, in metres.
    pub fn m_per_px(&self, point: &Point3<f64>, size: [f64; 2]) -> f64 {
        let half_height = match self.projection {
            Projection::Perspective => self.half_height() * self.depth_m(point).max(self.near_m()),
            Projection::Orthographic => self.half_height(),
        };
        2.0 * half_height / size[1]
    }

    /// Nearest depth that is drawn.
    pub(super) fn near_m(&self) -> f64 {
        match self.projection {
            Projection::Perspective => (self.distance_m * 0.01).max(0.001).min(0.05),
            Projection::Orthographic => self.distance_m - self.orthographic_reach_m(),
        }
    }

    /// How far before and behind the target an orthographic picture reaches.
    fn orthographic_reach_m(&self) -> f64 {
        50.0 + 4.0 * self.distance_m
    }

    /// Camera axes (x right, y up, z backward) from the world.
    pub fn view_from_world(&self) -> Matrix4<f64> {
        let (right, up, backward) = (self.right(), self.up(), self.backward());
        let eye = self.eye().coords;
        #[rustfmt::skip]
        let rows = Matrix4::new(
            right.x, right.y, right.z, -right.dot(&eye),
            up.x, up.y, up.z, -up.dot(&eye),
            backward.x, backward.y, backward.z, -backward.dot(&eye),
            0.0, 0.0, 0.0, 1.0,
        );
        rows
    }

    /// Clip space from camera axes. Depth is reversed: 1 is near, 0 is infinitely far (perspective) or far.
    pub fn clip_from_view(&self, size: [f64; 2]) -> Matrix4<f64> {
        let half_height = self.half_height();
        let half_width = half_height * size[0] / size[1];
        let mut clip_from_view = Matrix4::zeros();
        clip_from_view[(0, 0)] = 1.0 / half_width;
        clip_from_view[(1, 1)] = 1.0 / half_height;
        match self.projection {
            Projection::Perspective => {
                clip_from_view[(2, 3)] = self.near_m();
                clip_from_view[(3, 2)] = -1.0;
            }
            Projection::Orthographic => {
                // (far − depth) / (far − near) with depth = −z and far = distance + reach.
                let reach = self.orthographic_reach_m();
                clip_from_view[(2, 2)] = 0.5 / reach;
                clip_from_view[(2, 3)] = 0.5 * (self.distance_m + reach) / reach;
                clip_from_view[(3, 3)] = 1.0;
            }
        }
        clip_from_view
    }

    /// The ray through a pixel (from the top left corner, in the unit of `size`).
    pub fn ray(&self, px: Point2<f64>, size: [f64; 2]) -> Ray {
        let half_height = self.half_height();
        let x = (2.0 * px.x / size[0] - 1.0) * half_height * size[0] / size[1];
        let y = (1.0 - 2.0 * px.y / size[1]) * half_height;
        let forward = -self.backward();
        let sideways = self.right() * x + self.up() * y;
        match self.projection {
            Projection::Perspective => {
                let direction = Unit::try_new(forward + sideways, 0.0).unwrap_or(Unit::new_unchecked(forward));
                Ray { origin: self.eye(), direction }
            }
            Projection::Orthographic => {
                let origin = self.eye() + sideways + forward * self.near_m();
                Ray { origin, direction: Unit::new_unchecked(forward) }
            }
        }
    }

    /// Where a point is seen, in pixels from the top left corner (in the unit of `size`); `None` if it is behind the
    /// eye or too near. The place may lie outside the picture.
    pub fn project(&self, point: &Point3<f64>, size: [f64; 2]) -> Option<Point2<f64>> {
        let depth_m = self.depth_m(point);
        if depth_m.is_nan() || depth_m <= self.near_m() {
            return None;
        }
        let half_height = match self.projection {
            Projection::Perspective => self.half_height() * depth_m,
            Projection::Orthographic => self.half_height(),
        };
        let from_eye = point - self.eye();
        let px_per_m = size[1] / (2.0 * half_height);
        let x = size[0] / 2.0 + from_eye.dot(&self.right()) * px_per_m;
        let y = size[1] / 2.0 - from_eye.dot(&self.up()) * px_per_m;
        (x.is_finite() && y.is_finite()).then(|| Point2::new(x, y))
    }

    /// The camera at `t` in [0, 1] on the way to another one: eased, yaw the short way round, distance evenly in
    /// its logarithm. The projection changes at the end.
    pub fn toward(&self, other: &Self, t: f64) -> Self {
        if t >= 1.0 {
            return *other;
        }
        if t.is_nan() || t <= 0.0 {
            return *self;
        }
        let eased = t * t * (3.0 - 2.0 * t);
        let mix = |a: f64, b: f64| a + (b - a) * eased;
        Self {
            target: self.target + (other.target - self.target) * eased,
            distance_m: self.distance_m * (other.distance_m / self.distance_m).powf(eased),
            yaw_rad: wrap(self.yaw_rad + wrap(other.yaw_rad - self.yaw_rad) * eased),
            pitch_rad: mix(self.pitch_rad, other.pitch_rad),
            roll_rad: wrap(self.roll_rad + wrap(other.roll_rad - self.roll_rad) * eased),
            fov_y_rad: mix(self.fov_y_rad, other.fov_y_rad),
            projection: self.projection,
        }
    }
}

/// The same angle in [−π, π).
fn wrap(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [f64; 2] = [1440.0, 900.0];

    fn cameras() -> Vec<Camera> {
        let mut cameras = Vec::new();
        for projection in [Projection::Perspective, Projection::Orthographic] {
            for (yaw_rad, pitch_rad) in [(0.0, 0.0), (0.7, 0.4), (-2.5, -0.9), (1.0, FRAC_PI_2)] {
                cameras.push(Camera { yaw_rad, pitch_rad, projection, ..Camera::default() });
            }
        }
        cameras
    }

    #[test]
    fn axes_are_right_handed_and_orthonormal() {
        for camera in cameras() {
            let (right, up, backward) = (camera.right(), camera.up(), camera.backward());
            assert!((right.cross(&up) - backward).norm() < 1e-12);
            assert!((up.norm() - 1.0).abs() < 1e-12 && (right.norm() - 1.0).abs() < 1e-12);
            assert!(up.z >= -1e-12, "up is up at pitch {}", camera.pitch_rad);
        }
    }

    #[test]
    fn tumbling_turns_about_the_picture_s_own_axes_over_the_poles() {
        for mut camera in cameras() {
            for (yaw, pitch) in [(0.3, 0.0), (0.0, 0.3), (-1.1, 0.7), (0.2, 2.9), (4.0, -3.0)] {
                let (right, up, backward) = (camera.right(), camera.up(), camera.backward());
                camera.tumble(yaw, pitch);
                let tilted = backward * f64::cos(pitch) + up * f64::sin(pitch);
                let wanted = tilted * f64::cos(yaw)
                    + up.cross(&tilted) * f64::sin(yaw)
                    + up * (up.dot(&tilted) * (1.0 - f64::cos(yaw)));
                assert!((camera.backward() - wanted).norm() < 1e-9, "{camera:?}");
                let turned = right * f64::cos(yaw) - backward * f64::sin(yaw);
                assert!((camera.right() - turned).norm() < 1e-7, "{} {}", camera.right(), turned);
                assert!((camera.right().cross(&camera.up()) - camera.backward()).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn a_level_camera_that_tumbles_sideways_at_no_pitch_stays_level() {
        let mut camera = Camera { pitch_rad: 0.0, ..Camera::default() };
        let mut same = camera;
        camera.tumble(0.4, 0.0);
        same.orbit(0.4, 0.0);
        assert!((camera.yaw_rad - same.yaw_rad).abs() < 1e-12 && camera.roll_rad.abs() < 1e-12);
    }

    #[test]
    fn a_projected_point_lies_on_the_ray_through_its_pixel() {
        for camera in cameras() {
            for point in [camera.target, Point3::new(0.3, 0.2, 0.8), Point3::new(0.6, -0.3, 1.1)] {
                let px = camera.project(&point, SIZE).unwrap();
                let ray = camera.ray(px, SIZE);
                let off = (point - ray.origin).cross(&ray.direction).norm();
                assert!(off < 1e-9, "{off} m off the ray with {camera:?}");
                assert!((point - ray.origin).dot(&ray.direction) > 0.0);
            }
        }
    }

    #[test]
    fn the_matrices_agree_with_project_and_depth_is_reversed() {
        for camera in cameras() {
            let clip_from_world = camera.clip_from_view(SIZE) * camera.view_from_world();
            let point = Point3::new(0.4, 0.1, 0.9);
            let clip = clip_from_world * point.to_homogeneous();
            let ndc = clip / clip.w;
            let px = camera.project(&point, SIZE).unwrap();
            assert!((SIZE[0] * (0.5 + 0.5 * ndc.x) - px.x).abs() < 1e-9);
            assert!((SIZE[1] * (0.5 - 0.5 * ndc.y) - px.y).abs() < 1e-9);
            let farther = clip_from_world * (point - camera.backward() * 0.1).to_homogeneous();
            assert!(farther.z / farther.w < ndc.z && ndc.z < 1.0 && farther.z > 0.0);
        }
    }

    #[test]
    fn panning_carries_the_anchor_with_the_cursor() {
        for mut camera in cameras() {
            let anchor = Point3::new(0.35, 0.15, 0.8);
            let from = camera.project(&anchor, SIZE).unwrap();
            let to = from + nalgebra::Vector2::new(120.0, -45.0);
            camera.pan(&anchor, from, to, SIZE);
            assert!((camera.project(&anchor, SIZE).unwrap() - to).norm() < 1e-6);
        }
    }

    #[test]
    fn zooming_keeps_the_anchor_under_the_cursor() {
        for mut camera in cameras() {
            let anchor = Point3::new(0.35, 0.15, 0.8);
            let before = camera.project(&anchor, SIZE).unwrap();
            let distance_m = camera.distance_m;
            camera.zoom(0.5, &anchor);
            assert!((camera.project(&anchor, SIZE).unwrap() - before).norm() < 1e-6);
            assert!((camera.distance_m - distance_m / 2.0).abs() < 1e-12);
            camera.zoom(1e-9, &anchor);
            assert_eq!(camera.distance_m, DISTANCE_RANGE_M[0]);
            camera.zoom(f64::NAN, &anchor);
            assert!(camera.distance_m.is_finite());
        }
    }

    #[test]
    fn framing_shows_every_corner() {
        let bounds = Bounds { min: Point3::new(-0.4, -1.0, 0.0), max: Point3::new(1.2, 1.0, 1.7) };
        for size in [SIZE, [300.0, 900.0]] {
            for mut camera in cameras() {
                camera.frame(&bounds, size);
                for corner in 0..8 {
                    let pick = |bit: usize, lo: f64, hi: f64| if corner >> bit & 1 == 0 { lo } else { hi };
                    let corner = Point3::new(
                        pick(0, bounds.min.x, bounds.max.x),
                        pick(1, bounds.min.y, bounds.max.y),
                        pick(2, bounds.min.z, bounds.max.z),
                    );
                    let px = camera.project(&corner, size).unwrap();
                    assert!(px.x >= 0.0 && px.x <= size[0] && px.y >= 0.0 && px.y <= size[1], "{px} with {camera:?}");
                }
            }
        }
    }

    #[test]
    fn named_views_put_the_axes_where_they_say() {
        let mut camera = Camera { target: Point3::origin(), ..Camera::default() };
        let mut seen = |named, axis: Vector3<f64>| {
            camera.look_from(named);
            camera.project(&axis.into(), SIZE).unwrap() - Point2::new(SIZE[0] / 2.0, SIZE[1] / 2.0)
        };
        assert!(seen(Named::Front, Vector3::y()).x > 1.0 && seen(Named::Front, Vector3::z()).y < -1.0);
        assert!(seen(Named::Right, -Vector3::x()).x > 1.0 && seen(Named::Right, Vector3::z()).y < -1.0);
        assert!(seen(Named::Top, -Vector3::x()).y < -1.0 && seen(Named::Top, Vector3::y()).x > 1.0);
    }

    #[test]
    fn a_transition_starts_and_ends_at_its_cameras_and_turns_the_short_way() {
        let start = Camera { yaw_rad: 3.0, ..Camera::default() };
        let end = Camera { yaw_rad: -3.0, distance_m: 1.0, projection: Projection::Orthographic, ..start };
        assert_eq!(start.toward(&end, 0.0), start);
        assert_eq!(start.toward(&end, 1.0), end);
        let half = start.toward(&end, 0.5);
        assert!(half.yaw_rad.abs() > 3.1, "passes behind, not through 0: {}", half.yaw_rad);
        assert!((half.distance_m - (start.distance_m * end.distance_m).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_point_behind_the_eye_is_not_seen() {
        let camera = Camera::default();
        let behind = camera.eye() + camera.backward();
        assert_eq!(camera.project(&behind, SIZE), None);
        assert_eq!(camera.project(&Point3::new(f64::NAN, 0.0, 0.0), SIZE), None);
    }
}
