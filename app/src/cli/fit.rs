//! `fit`: one superquadric per cloud.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use endcomfort_core::fit::{Fit, FitInput, FitSettings, MirrorMode, fit};
use endcomfort_core::segment::Plane;
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use serde_json::json;

use super::{Common, Failure, input};
use crate::clock::stopwatch;

#[derive(clap::Args)]
pub(super) struct Args {
    /// Clouds of one object each.
    #[arg(required = true)]
    clouds: Vec<PathBuf>,
    /// What is minimised.
    #[arg(long, value_enum, default_value = "radial")]
    objective: Objective,
    /// Edge of the voxel grid in metres; 0 takes the cloud as it is.
    #[arg(long, default_value_t = FitSettings::default().voxel_m)]
    voxel: f64,
    /// Completes the unseen side by a mirror image.
    #[arg(long, value_enum, default_value = "auto")]
    mirror: Mirror,
    /// Position of the camera in the cloud's frame: x,y,z in metres. Default: what the file says.
    #[arg(long, value_delimiter = ',', num_args = 3, allow_negative_numbers = true)]
    camera: Option<Vec<f64>>,
    /// The table, `n · p = d`: nx,ny,nz,d in metres.
    #[arg(long, value_delimiter = ',', num_args = 4, allow_negative_numbers = true)]
    table: Option<Vec<f64>>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Objective {
    /// Radial distance, equation 3.4 as corrected.
    Radial,
}

#[derive(Clone, Copy, ValueEnum)]
enum Mirror {
    Auto,
    On,
    Off,
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let Objective::Radial = args.objective;
    if !(args.voxel.is_finite() && args.voxel >= 0.0) {
        return Err(Failure::new(format!("--voxel: found {}, wanted 0 or more", args.voxel)));
    }
    let table = args.table.as_deref().map(table_plane).transpose()?;
    let mut failures = Vec::new();
    for path in &args.clouds {
        if let Err(failure) = fit_one(path, args, table, common) {
            failures.push(failure.to_string());
            if common.json && args.clouds.len() > 1 {
                println!(
                    "{}",
                    json!({ "file": path.display().to_string(), "status": "refused", "reason": failure.to_string() })
                );
            }
        }
    }
    match failures.len() {
        0 => Ok(()),
        count => {
            Err(Failure { message: format!("{count} of {} clouds not fitted", args.clouds.len()), details: failures })
        }
    }
}

fn table_plane(numbers: &[f64]) -> Result<Plane, Failure> {
    let normal = Vector3::new(numbers[0], numbers[1], numbers[2]);
    let length = normal.norm();
    let unit = Unit::try_new(normal, 1e-9)
        .ok_or_else(|| Failure::new(format!("--table: the normal {normal:?} has no direction")))?;
    Ok(Plane { normal: unit, offset_m: numbers[3] / length })
}

/// A camera at a position, looking at a point, its image upright as far as the direction allows.
fn camera_looking_at(position: Vector3<f64>, target: Vector3<f64>) -> Option<Isometry3<f64>> {
    let z = (target - position).try_normalize(1e-9)?;
    let down = if z.z.abs() < 0.99 { -Vector3::z() } else { Vector3::x() };
    let x = down.cross(&z).try_normalize(1e-9)?;
    let R = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
    Some(Isometry3::from_parts(Translation3::from(position), UnitQuaternion::from_rotation_matrix(&R)))
}

fn fit_one(path: &Path, args: &Args, table: Option<Plane>, common: &Common) -> Result<(), Failure> {
    let shown = path.display().to_string();
    let loaded = input::cloud_file(path)?;
    loaded.notes.iter().for_each(|note| eprintln!("{shown}: {note}"));
    let cloud = loaded.value;
    let centroid = cloud.points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / cloud.points.len().max(1) as f64;
    let X_FC = match &args.camera {
        Some(p) => camera_looking_at(Vector3::new(p[0], p[1], p[2]), centroid),
        None => cloud.X_FC,
    };
    let settings = FitSettings {
        voxel_m: args.voxel,
        mirror: match args.mirror {
            Mirror::Auto => MirrorMode::Auto,
            Mirror::On => MirrorMode::On,
            Mirror::Off => MirrorMode::Off,
        },
        ..FitSettings::default()
    };
    let elapsed_ms = stopwatch();
    let fitted = fit(FitInput { points: &cloud.points, X_FC, table }, &settings, Watch::idle())
        .map_err(|refusal| Failure::new(format!("{shown}: {refusal}")))?;
    let fit_ms = elapsed_ms();
    if common.json {
        println!("{}", fit_json(&shown, &fitted, fit_ms));
    } else {
        print_fit(&shown, &fitted, fit_ms);
    }
    Ok(())
}

fn fit_json(file: &str, fitted: &Fit, fit_ms: f64) -> serde_json::Value {
    let sq = &fitted.superquadric;
    let t = sq.X_FS.translation.vector;
    let r = sq.X_FS.rotation.coords;
    json!({
        "file": file, "points": fitted.points, "used_points": fitted.used_points,
        "superquadric": {
            "semi_axes_m": [sq.a, sq.b, sq.c], "exponents": [sq.e1, sq.e2],
            "translation_m": [t.x, t.y, t.z], "rotation_xyzw": [r.x, r.y, r.z, r.w],
            "taper": 0.0, "bend_per_m": 0.0,
        },
        "radial_m": fitted.radial_m, "goodness_of_fit": fitted.goodness_of_fit,
        "goodness_of_fit_abs": fitted.goodness_of_fit_abs, "volume_m3": fitted.volume_m3,
        "iterations": fitted.iterations, "fit_ms": fit_ms,
    })
}

fn print_fit(file: &str, fitted: &Fit, fit_ms: f64) {
    let sq = &fitted.superquadric;
    println!("{file}: {} points, {} used, {fit_ms:.1} ms", fitted.points, fitted.used_points);
    println!(
        "  semi-axes {:.1} × {:.1} × {:.1} mm, e1 {:.2}, e2 {:.2}",
        sq.a * 1e3,
        sq.b * 1e3,
        sq.c * 1e3,
        sq.e1,
        sq.e2
    );
    println!(
        "  E_r {:.2} mm, E_g {:.3} (as in the tables {:.3}), volume {:.0} cm³",
        fitted.radial_m * 1e3,
        fitted.goodness_of_fit,
        fitted.goodness_of_fit_abs,
        fitted.volume_m3 * 1e6
    );
    println!("  mirror: {}", fitted.mirror_note);
}
