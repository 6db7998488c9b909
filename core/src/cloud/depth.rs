//! Depth images with the intrinsics of their camera: an organised cloud in the camera's own frame.

use nalgebra::{Isometry3, Point3};
use serde_json::Value;

use super::{CloudError, PixelGrid, PointCloud};
use crate::loaded::Loaded;
use crate::math::tan;

/// Largest side of a depth image, pixels.
pub const MAX_DEPTH_SIDE: u32 = 8192;
/// Metres per unit where nothing is said: 16-bit depth images are in millimetres.
const USUAL_SCALE_M: f64 = 1e-3;
/// Fields of view that a lens can have, radians.
const FIELD_OF_VIEW_RAD: [f64; 2] = [0.05, 2.9];
/// Focal lengths that make sense, pixels.
const FOCAL_PX: [f64; 2] = [1.0, 1e5];
/// Scales between a micrometre and 10 cm per unit.
const SCALE_M: [f64; 2] = [1e-6, 0.1];

/// A pinhole camera as drivers describe it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Columns and rows; `None` takes them from the image.
    pub size_px: Option<[u32; 2]>,
    /// Focal lengths along u and v, pixels.
    pub focal_px: [f64; 2],
    /// Principal point, pixels; (0, 0) is the middle of the first pixel.
    pub center_px: [f64; 2],
    /// Metres per unit of depth.
    pub depth_scale_m: f64,
}

impl Intrinsics {
    /// A camera of which only the horizontal field of view is known: square pixels, the principal point in the middle,
    /// depth in millimetres.
    ///
    /// # Errors
    /// [`CloudError::Intrinsics`] if the angle is none that a lens has.
    pub fn of_view(width: u32, height: u32, field_of_view_rad: f64) -> Result<Self, CloudError> {
        let [least, most] = FIELD_OF_VIEW_RAD;
        let wanted = format!("{:.0} to {:.0} degrees", least.to_degrees(), most.to_degrees());
        check("field of view", field_of_view_rad.to_degrees(), FIELD_OF_VIEW_RAD.map(f64::to_degrees), &wanted)?;
        let focal = 0.5 * f64::from(width) / tan(0.5 * field_of_view_rad);
        let center_px = [0.5 * (f64::from(width) - 1.0), 0.5 * (f64::from(height) - 1.0)];
        let size_px = Some([width, height]);
        Ok(Self { size_px, focal_px: [focal; 2], center_px, depth_scale_m: USUAL_SCALE_M })
    }

    /// Reads intrinsics from JSON: `fx`, `fy`, `cx`, `cy`, and where they are known `width`, `height`, `depth_scale`.
    ///
    /// The names of ROS `camera_info` do as well: `K` or `k` with nine numbers, `camera_matrix: {data: […]}`,
    /// `image_width`, `image_height`. A `depth_scale` above 1 is units per metre, any other metres per unit. Lens
    /// distortion is not taken out of the image; a note says so where there is some.
    ///
    /// # Errors
    /// [`CloudError::Intrinsics`] naming the field, what was found and what was wanted.
    pub fn parse(json: &str) -> Result<Loaded<Self>, CloudError> {
        let file: Value = serde_json::from_str(json).map_err(|error| CloudError::Intrinsics {
            thing: "file",
            found: error.to_string(),
            wanted: "JSON".to_owned(),
        })?;
        let number = |name: &str| file.get(name).and_then(Value::as_f64);
        let matrix = file.get("K").or_else(|| file.get("k")).or_else(|| file.get("camera_matrix"));
        let matrix = matrix.map(|matrix| matrix.get("data").unwrap_or(matrix));
        // Row by row: fx 0 cx, 0 fy cy, 0 0 1; some write the rows as lists.
        let rows: Vec<f64> = match matrix.and_then(Value::as_array) {
            Some(list) => list
                .iter()
                .flat_map(|x| x.as_array().cloned().unwrap_or_else(|| vec![x.clone()]))
                .filter_map(|x| x.as_f64())
                .collect(),
            None => Vec::new(),
        };
        let of_matrix = |index: usize| rows.get(index).copied().filter(|_| rows.len() == 9);
        let field = |thing: &'static str, index: usize, range: [f64; 2], wanted: &str| {
            let found = number(thing).or_else(|| of_matrix(index)).ok_or_else(|| CloudError::Intrinsics {
                thing,
                found: "nothing".to_owned(),
                wanted: format!("{wanted}, or K with nine numbers"),
            })?;
            check(thing, found, range, wanted).map(|()| found)
        };
        let pixels = "a focal length in pixels";
        let place = "a place in the image, pixels";
        let side = f64::from(MAX_DEPTH_SIDE);
        let focal_px = [field("fx", 0, FOCAL_PX, pixels)?, field("fy", 4, FOCAL_PX, pixels)?];
        let center_px = [field("cx", 2, [-side, 2.0 * side], place)?, field("cy", 5, [-side, 2.0 * side], place)?];
        let size = |thing: &'static str, other: &str| match number(thing).or_else(|| number(other)) {
            None => Ok(None),
            Some(found) => check(thing, found, [1.0, side], "pixels, at most 8192").map(|()| Some(found as u32)),
        };
        let size_px = size("width", "image_width")?.zip(size("height", "image_height")?).map(|(w, h)| [w, h]);
        let scale = number("depth_scale").unwrap_or(USUAL_SCALE_M);
        let depth_scale_m = if scale > 1.0 { 1.0 / scale } else { scale };
        check("depth_scale", depth_scale_m, SCALE_M, "metres per unit (0.001) or units per metre (1000)")?;
        let lens = ["D", "d", "distortion", "distortion_coefficients"].into_iter().find_map(|name| file.get(name));
        let lens = lens.map(|lens| lens.get("data").unwrap_or(lens));
        let bends =
            lens.and_then(Value::as_array).is_some_and(|d| d.iter().any(|x| x.as_f64().is_some_and(|x| x != 0.0)));
        let notes = if bends {
            vec![
                "the intrinsics name a lens distortion, which is not taken out: use a rectified depth image".to_owned(),
            ]
        } else {
            Vec::new()
        };
        Ok(Loaded { value: Self { size_px, focal_px, center_px, depth_scale_m }, notes })
    }

    /// Whether JSON is meant as intrinsics, however wrong it may be.
    pub fn is_meant_by(json: &Value) -> bool {
        ["fx", "K", "k", "camera_matrix"].into_iter().any(|name| json.get(name).is_some())
    }
}

fn check(thing: &'static str, found: f64, [least, most]: [f64; 2], wanted: &str) -> Result<(), CloudError> {
    // NaN fails as well.
    if found >= least && found <= most {
        return Ok(());
    }
    Err(CloudError::Intrinsics { thing, found: found.to_string(), wanted: wanted.to_owned() })
}

/// The organised cloud of a depth image, in the optical frame C of its camera (x right, y down, z forward), which is at the
/// origin. Pixels of depth 0 have no point.
///
/// * `depth`: row by row, in units of [`Intrinsics::depth_scale_m`].
///
/// # Errors
/// [`CloudError`] when the image has another size than the intrinsics say, or no pixel has a depth.
pub fn depth_cloud(width: u32, height: u32, depth: &[u16], camera: &Intrinsics) -> Result<PointCloud, CloudError> {
    let wanted = |size: [u32; 2]| format!("{} × {} pixels, as the intrinsics say", size[0], size[1]);
    let found = || format!("{width} × {height} pixels");
    if let Some(size) = camera.size_px.filter(|size| *size != [width, height]) {
        return Err(CloudError::Intrinsics { thing: "depth image", found: found(), wanted: wanted(size) });
    }
    if depth.len() != width as usize * height as usize || width.max(height) > MAX_DEPTH_SIDE {
        let wanted = format!("one depth per pixel, sides up to {MAX_DEPTH_SIDE}");
        return Err(CloudError::Intrinsics { thing: "depth image", found: found(), wanted });
    }
    let (mut points, mut pixels) = (Vec::new(), Vec::new());
    for (pixel, &units) in depth.iter().enumerate().filter(|(_, units)| **units > 0) {
        let (u, v) = ((pixel % width as usize) as f64, (pixel / width as usize) as f64);
        let z = f64::from(units) * camera.depth_scale_m;
        let x = (u - camera.center_px[0]) * z / camera.focal_px[0];
        let y = (v - camera.center_px[1]) * z / camera.focal_px[1];
        points.push(Point3::new(x, y, z));
        pixels.push(pixel as u32);
    }
    if points.is_empty() {
        return Err(CloudError::NoPoints { read: depth.len(), limit_m: super::MAX_COORDINATE_M as u64 });
    }
    let grid = Some(PixelGrid { width, height, pixels });
    Ok(PointCloud { points, colors: Vec::new(), grid, X_FC: Some(Isometry3::identity()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ours_and_the_names_of_camera_info_are_the_same_camera() {
        let ours =
            r#"{"fx": 525, "fy": 526, "cx": 319.5, "cy": 239.5, "width": 640, "height": 480, "depth_scale": 0.001}"#;
        let ros = r#"{"K": [525, 0, 319.5, 0, 526, 239.5, 0, 0, 1], "image_width": 640, "image_height": 480,
            "depth_scale": 1000, "D": [0, 0, 0, 0, 0]}"#;
        let yaml = r#"{"camera_matrix": {"rows": 3, "cols": 3, "data": [525, 0, 319.5, 0, 526, 239.5, 0, 0, 1]},
            "width": 640, "height": 480}"#;
        let wanted = Intrinsics {
            size_px: Some([640, 480]),
            focal_px: [525.0, 526.0],
            center_px: [319.5, 239.5],
            depth_scale_m: 0.001,
        };
        for text in [ours, ros, yaml] {
            let Loaded { value, notes } = Intrinsics::parse(text).unwrap();
            assert_eq!((value, notes.len()), (wanted, 0), "{text}");
            assert!(Intrinsics::is_meant_by(&serde_json::from_str(text).unwrap()));
        }
        let bent = ros.replace("[0, 0, 0, 0, 0]", "[0.1, 0, 0, 0, 0]");
        assert!(Intrinsics::parse(&bent).unwrap().notes[0].contains("distortion"));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, wanted) in [
            ("{", "file: found"),
            ("{\"fy\": 1}", "fx: found nothing, wanted a focal length in pixels, or K with nine numbers"),
            (r#"{"fx": -5, "fy": 5, "cx": 1, "cy": 1}"#, "fx: found -5, wanted a focal length in pixels"),
            (r#"{"fx": 5, "fy": 5, "cx": 1, "cy": 1, "depth_scale": 0.5}"#, "depth_scale: found 0.5"),
        ] {
            let error = Intrinsics::parse(text).unwrap_err().to_string();
            assert!(error.starts_with(wanted), "{error}");
        }
        assert!(Intrinsics::of_view(640, 480, 4.0).unwrap_err().to_string().contains("wanted 3 to 166 degrees"));
    }

    #[test]
    fn a_pixel_with_a_depth_is_a_point_on_its_ray() {
        let camera = Intrinsics { size_px: None, focal_px: [100.0, 50.0], center_px: [1.0, 0.0], depth_scale_m: 0.001 };
        let cloud = depth_cloud(3, 2, &[0, 1000, 0, 2000, 0, 500], &camera).unwrap();
        let wanted = [Point3::new(0.0, 0.0, 1.0), Point3::new(-0.02, 0.04, 2.0), Point3::new(0.005, 0.01, 0.5)];
        assert_eq!(cloud.points, wanted);
        assert_eq!(cloud.grid.unwrap().pixels, [1, 3, 5]);
        assert_eq!(cloud.X_FC, Some(Isometry3::identity()));
        assert!(matches!(depth_cloud(3, 2, &[0; 6], &camera), Err(CloudError::NoPoints { read: 6, .. })));
        let sized = Intrinsics { size_px: Some([4, 2]), ..camera };
        let error = depth_cloud(3, 2, &[1; 6], &sized).unwrap_err().to_string();
        assert_eq!(error, "depth image: found 3 × 2 pixels, wanted 4 × 2 pixels, as the intrinsics say");
    }

    #[test]
    fn a_field_of_view_spans_the_image() {
        let camera = Intrinsics::of_view(640, 480, std::f64::consts::FRAC_PI_2).unwrap();
        assert!((camera.focal_px[0] - 320.0).abs() < 1e-9);
    }

    #[test]
    fn no_text_makes_it_panic() {
        let good = r#"{"K": [525, 0, 319.5, 0, 526, 239.5, 0, 0, 1], "width": 640, "height": 480, "D": [0.1]}"#;
        let mut rng = crate::rng::Rng::new(3, 0);
        for _ in 0..2000 {
            let mut bytes = good.as_bytes().to_vec();
            let at = (rng.unit() * bytes.len() as f64) as usize;
            bytes[at] = (32.0 + rng.unit() * 95.0) as u8;
            let _any = Intrinsics::parse(&String::from_utf8_lossy(&bytes));
        }
    }
}
