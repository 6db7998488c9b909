//! A folder of views with their truth: `NAME_view.json` beside the cloud it names.

use std::path::Path;

use endcomfort_core::experiment::ObjectView;
use endcomfort_core::segment::Plane;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use serde::Deserialize;

use super::{Failure, input};

/// A body that fills at least this share of its convex hull counts as convex: scans of boxes and cans fill 92 %.
const CONVEX_SHARE: f64 = 0.9;
/// How far a rotation may be from orthonormal: six printed digits.
const RIGID: f64 = 1e-5;

/// What is read of a truth file; other keys are ignored. Metres, camera's optical frame C.
#[derive(Deserialize)]
struct TruthFile {
    /// File of the view, beside the truth file.
    cloud: String,
    T_camera_object: [[f64; 4]; 4],
    /// `n · p + d = 0`, n upwards.
    table_plane_camera: Option<[f64; 4]>,
    full_extents_object_m: [f64; 3],
    #[serde(default)]
    mesh_watertight: bool,
    mesh_volume_m3: Option<f64>,
    convex_hull_volume_m3: Option<f64>,
    #[serde(default)]
    hollow: bool,
    /// File of the whole surface in the object's frame, relative to the folder above.
    full_cloud: Option<String>,
}

/// The views of a folder, by name, and notes on what is missing.
///
/// # Errors
/// [`Failure`] names the file that cannot be read, or says that the folder holds no view.
pub(super) fn read_views(folder: &Path) -> Result<(Vec<ObjectView>, Vec<String>), Failure> {
    let shown = folder.display();
    let entries = std::fs::read_dir(folder).map_err(|error| Failure::new(format!("{shown}: {error}")))?;
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|n| n.ends_with("_view.json"))
        .collect();
    names.sort_unstable();
    if names.is_empty() {
        return Err(Failure::new(format!("{shown}: found no file that ends in _view.json")));
    }
    let mut notes = Vec::new();
    let views = names.iter().map(|name| read_view(folder, name, &mut notes)).collect::<Result<_, _>>()?;
    Ok((views, notes))
}

fn read_view(folder: &Path, name: &str, notes: &mut Vec<String>) -> Result<ObjectView, Failure> {
    let path = folder.join(name);
    let wrong = |what: String| Failure::new(format!("{}: {what}", path.display()));
    let bytes = input::read_file(&path)?;
    let truth: TruthFile = serde_json::from_slice(&bytes).map_err(|error| wrong(error.to_string()))?;
    let X_CO = pose(&truth.T_camera_object).map_err(|found| wrong(format!("T_camera_object: {found}")))?;
    let table = truth.table_plane_camera.map(|[x, y, z, d]| -> Result<Plane, Failure> {
        let normal = Unit::try_new_and_get(Vector3::new(x, y, z), 1e-9);
        let (normal, length) = normal.ok_or_else(|| wrong("table_plane_camera: its normal has no direction".into()))?;
        Ok(Plane { normal, offset_m: -d / length })
    });
    let seen = input::cloud_file(&folder.join(&truth.cloud))?.value;
    let surface = truth.full_cloud.as_ref().map(|file| folder.join("..").join(file)).filter(|file| file.is_file());
    let surface = match surface {
        Some(file) => input::cloud_file(&file)?.value.points.iter().map(|p| X_CO * p).collect(),
        None => {
            notes.push(format!("{name}: no cloud of the whole surface, errors are on the view"));
            seen.points.clone()
        }
    };
    let volume_m3 = truth.mesh_volume_m3.filter(|_| truth.mesh_watertight);
    let fills = volume_m3.zip(truth.convex_hull_volume_m3).map(|(volume, hull)| volume / hull);
    Ok(ObjectView {
        name: name.trim_end_matches("_view.json").to_owned(),
        points: seen.points,
        X_FC: Some(Isometry3::identity()),
        table: table.transpose()?,
        X_FO: X_CO,
        extents_m: truth.full_extents_object_m.into(),
        volume_m3,
        is_hollow: truth.hollow,
        is_convex: fills.is_some_and(|share| share >= CONVEX_SHARE),
        surface,
    })
}

/// A rigid motion written as rows.
fn pose(rows: &[[f64; 4]; 4]) -> Result<Isometry3<f64>, String> {
    let R = Matrix3::from_fn(|i, j| rows[i][j]);
    let off = (R * R.transpose() - Matrix3::identity()).amax();
    // NaN fails as well.
    if !(off < RIGID && R.determinant() > 0.0) {
        return Err(format!("found a matrix that is {off:.2e} from a rotation, wanted at most {RIGID:.0e}"));
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R));
    Ok(Isometry3::from_parts(Translation3::new(rows[0][3], rows[1][3], rows[2][3]), rotation))
}
