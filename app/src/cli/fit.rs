//! `fit`: one superquadric per cloud.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use endcomfort_core::fit::{
    DeformMode, Fit, FitErrors, FitInput, FitSettings, MirrorMode, ObjectiveKind, fit, fit_errors,
};
use endcomfort_core::segment::Plane;
use endcomfort_core::superquadric::Superquadric;
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use serde_json::{Value, json};

use super::table::Table;
use super::{Common, Failure, input};
use crate::clock::stopwatch;
use crate::export::fit_svgs;

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
    /// Deformations that the shape may have.
    #[arg(long, value_enum, default_value = "none")]
    deform: Deform,
    /// From coarse voxels (0.03 m) to fine ones (0.005 m), each level starting from the last.
    #[arg(long)]
    hierarchical: bool,
    /// Superquadrics that the object may be split into.
    #[arg(long, default_value_t = FitSettings::default().max_parts)]
    parts: usize,
    /// Fits all points, also those that no superquadric near the others explains.
    #[arg(long)]
    keep_outliers: bool,
    /// Position of the camera in the cloud's frame: x,y,z in metres. Default: what the file says.
    #[arg(long, value_parser = input::numbers::<3>, allow_hyphen_values = true)]
    camera: Option<[f64; 3]>,
    /// The table, `n · p = d`: nx,ny,nz,d in metres.
    #[arg(long, value_parser = input::numbers::<4>, allow_hyphen_values = true)]
    table: Option<[f64; 4]>,
    /// A full clean cloud in the same frame, on which the errors are evaluated as well.
    #[arg(long)]
    reference: Option<PathBuf>,
    /// Folder that receives two plots of each fit: NAME_cost.svg and NAME_residuals.svg.
    #[arg(long)]
    plots: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Objective {
    /// Radial distance, equation 3.4 as corrected, metres.
    Radial,
    /// Solina and Bajcsy, equation 3.5.
    Solina,
    /// Ichim, equation 3.7 as its author computes it: exponent e1, not e1/2.
    Ichim,
    /// Chevalier, equation 3.6, metres.
    Chevalier,
    /// The fifth objective, equation 3.8.
    F5,
}

impl From<Objective> for ObjectiveKind {
    fn from(objective: Objective) -> Self {
        match objective {
            Objective::Radial => Self::Radial,
            Objective::Solina => Self::Solina,
            Objective::Ichim => Self::Ichim,
            Objective::Chevalier => Self::Chevalier,
            Objective::F5 => Self::F5,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum Deform {
    /// None.
    None,
    /// Taper along z.
    Taper,
    /// Bend in the y-z plane.
    Bend,
    /// Taper, then bend.
    Both,
    /// Whatever the cloud speaks for, none if nothing does.
    Auto,
}

impl From<Deform> for DeformMode {
    fn from(deform: Deform) -> Self {
        match deform {
            Deform::None => Self::None,
            Deform::Taper => Self::Taper,
            Deform::Bend => Self::Bend,
            Deform::Both => Self::Both,
            Deform::Auto => Self::Auto,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum Mirror {
    /// When camera and table are known and a plane of symmetry passes the test.
    Auto,
    /// As auto, and a cloud without a plane of symmetry is refused.
    On,
    /// Never.
    Off,
}

impl From<Mirror> for MirrorMode {
    fn from(mirror: Mirror) -> Self {
        match mirror {
            Mirror::Auto => Self::Auto,
            Mirror::On => Self::On,
            Mirror::Off => Self::Off,
        }
    }
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    if !(args.voxel.is_finite() && args.voxel >= 0.0) {
        return Err(Failure::new(format!("--voxel: found {}, wanted 0 or more", args.voxel)));
    }
    if args.parts == 0 {
        return Err(Failure::new("--parts: found 0, wanted 1 or more"));
    }
    let table = args.table.as_ref().map(table_plane).transpose()?;
    let reference = args.reference.as_deref().map(input::cloud_file).transpose()?;
    let reference = reference.map(|loaded| loaded.value.points);
    let mut failures = Vec::new();
    for path in &args.clouds {
        if let Err(failure) = fit_one(path, args, table, reference.as_deref(), common) {
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
            Err(Failure::new(format!("{count} of {} clouds not fitted", args.clouds.len())).with_details(failures))
        }
    }
}

fn table_plane(numbers: &[f64; 4]) -> Result<Plane, Failure> {
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

fn fit_one(
    path: &Path,
    args: &Args,
    table: Option<Plane>,
    reference: Option<&[Point3<f64>]>,
    common: &Common,
) -> Result<(), Failure> {
    let shown = path.display().to_string();
    let loaded = input::cloud_file(path)?;
    loaded.notes.iter().for_each(|note| eprintln!("{shown}: {note}"));
    let cloud = loaded.value;
    let centroid = cloud.points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / cloud.points.len().max(1) as f64;
    let X_FC = match &args.camera {
        Some(position) => camera_looking_at(Vector3::from(*position), centroid),
        None => cloud.X_FC,
    };
    let settings = FitSettings {
        voxel_m: args.voxel,
        objective: args.objective.into(),
        mirror: args.mirror.into(),
        deform: args.deform.into(),
        hierarchical: args.hierarchical,
        reject_outliers: !args.keep_outliers,
        max_parts: args.parts,
        ..FitSettings::default()
    };
    let elapsed_ms = stopwatch();
    let fitted = fit(FitInput { points: &cloud.points, X_FC, table }, &settings, Watch::idle())
        .map_err(|refusal| Failure::new(format!("{shown}: {refusal}")))?;
    let fit_ms = elapsed_ms();
    if let Some(folder) = &args.plots {
        write_plots(folder, path, &fitted, &cloud.points, settings.objective)?;
    }
    let told = Told {
        file: &shown,
        fitted: &fitted,
        objective: settings.objective,
        fit_ms,
        reference: reference.map(|points| (points.len(), fit_errors(&fitted.superquadric, points))),
    };
    if common.json {
        println!("{}", told.json());
    } else {
        told.print();
    }
    Ok(())
}

/// Writes the cost of every run and the distances of the points as SVG.
fn write_plots(
    folder: &Path,
    cloud: &Path,
    fitted: &Fit,
    points: &[Point3<f64>],
    objective: ObjectiveKind,
) -> Result<(), Failure> {
    let refuse = |path: &Path, cause: String| Failure::new(format!("{}: {cause}", path.display()));
    let nearest = |p: &Point3<f64>| fitted.bodies().map(|body| body.signed_radial_distance(p)).min_by(f64::total_cmp);
    let distances_m: Vec<f64> = points.iter().filter_map(nearest).collect();
    let stem = cloud.file_stem().unwrap_or_default().to_string_lossy();
    let plots = fit_svgs(fitted, &distances_m, objective, &stem).map_err(|cause| refuse(cloud, cause))?;
    std::fs::create_dir_all(folder).map_err(|error| refuse(folder, error.to_string()))?;
    for (kind, text) in plots {
        let file = folder.join(format!("{stem}_{}.svg", kind.name()));
        std::fs::write(&file, text).map_err(|error| refuse(&file, error.to_string()))?;
        eprintln!("wrote {}", file.display());
    }
    Ok(())
}

/// What is told about a fit.
struct Told<'a> {
    file: &'a str,
    fitted: &'a Fit,
    objective: ObjectiveKind,
    fit_ms: f64,
    /// Points of the reference cloud and the errors of the (largest) superquadric on them.
    reference: Option<(usize, FitErrors)>,
}

impl Told<'_> {
    fn json(&self) -> Value {
        let fitted = self.fitted;
        let parts: Vec<Value> = fitted
            .others
            .iter()
            .map(|part| {
                json!({
                    "superquadric": shape_json(&part.superquadric), "points": part.points, "radial_m": part.radial_m,
                })
            })
            .collect();
        let mut value = json!({
            "file": self.file, "points": fitted.points, "used_points": fitted.used_points,
            "superquadric": shape_json(&fitted.superquadric), "objective": self.objective.name(),
            "radial_m": fitted.radial_m, "goodness_of_fit": fitted.goodness_of_fit,
            "goodness_of_fit_abs": fitted.goodness_of_fit_abs, "volume_m3": fitted.volume_m3,
            "iterations": fitted.iterations, "fit_ms": self.fit_ms,
            "mirrored": { "points": fitted.mirrored.len(), "note": fitted.mirror_note },
            "rejected": {
                "points": fitted.rejected.len(), "limit_m": fitted.rejected.first().map(|point| point.limit_m),
            },
            "runs": fitted.runs, "models": fitted.models, "parts": parts,
        });
        if let (Some((points, errors)), Some(object)) = (self.reference, value.as_object_mut()) {
            object.insert("reference_points".into(), json!(points));
            object.insert("reference_radial_m".into(), json!(errors.radial_m));
            object.insert("reference_goodness_of_fit".into(), json!(errors.goodness_of_fit));
            object.insert("reference_goodness_of_fit_abs".into(), json!(errors.goodness_of_fit_abs));
        }
        value
    }

    fn print(&self) {
        let fitted = self.fitted;
        println!("{}: {} points, {} used, {:.1} ms", self.file, fitted.points, fitted.used_points, self.fit_ms);
        let mut lines = Table::new(2, vec!["", ""]);
        let mut line = |name: &str, text: String| lines.push(vec![format!("  {name}"), text]);
        line("shape", shape_text(&fitted.superquadric));
        for part in &fitted.others {
            let of = format!("{} points, E_r {:.2} mm", part.points, part.radial_m * 1e3);
            line("and", format!("{}; {of}", shape_text(&part.superquadric)));
        }
        line("volume", format!("{:.1} cm³", fitted.volume_m3 * 1e6));
        let errors = |radial_m: f64, printed: f64, abs: f64| {
            format!("E_r {:.2} mm, E_g {printed:.3} as printed, {abs:.3} as in the tables", radial_m * 1e3)
        };
        line("errors", errors(fitted.radial_m, fitted.goodness_of_fit, fitted.goodness_of_fit_abs));
        if let Some((points, e)) = &self.reference {
            let text = errors(e.radial_m, e.goodness_of_fit, e.goodness_of_fit_abs);
            line("reference", format!("{text}; {points} points"));
        }
        line("mirror", fitted.mirror_note.clone());
        if let Some(first) = fitted.rejected.first() {
            let limit_mm = first.limit_m * 1e3;
            line("left out", format!("{} points more than {limit_mm:.1} mm away", fitted.rejected.len()));
        }
        for model in &fitted.models {
            let mark = if model.is_chosen { "taken" } else { "compared" };
            let rms_mm = model.rms_m * 1e3;
            line(mark, format!("{}, criterion {:.1}, rms {rms_mm:.2} mm", model.name, model.criterion));
        }
        let runs = format!("{} runs, {} evaluations", fitted.runs.len(), fitted.iterations);
        let last = fitted.runs.last().map(|run| format!("; the last, {}: {}", run.name, run.stop));
        line("search", format!("{}, {runs}{}", self.objective.name(), last.unwrap_or_default()));
        print!("{lines}");
    }
}

fn shape_json(sq: &Superquadric) -> Value {
    let t = sq.X_FS.translation.vector;
    let r = sq.X_FS.rotation.coords;
    json!({
        "semi_axes_m": [sq.a, sq.b, sq.c], "exponents": [sq.e1, sq.e2],
        "translation_m": [t.x, t.y, t.z], "rotation_xyzw": [r.x, r.y, r.z, r.w],
        "taper": sq.taper, "bend_per_m": sq.bend_per_m,
    })
}

fn shape_text(sq: &Superquadric) -> String {
    let [a, b, c] = [sq.a, sq.b, sq.c].map(|m| m * 1e3);
    let t = sq.X_FS.translation.vector;
    let mut text = format!("semi-axes {a:.1} × {b:.1} × {c:.1} mm, e1 {:.2}, e2 {:.2}", sq.e1, sq.e2);
    if sq.taper != 0.0 {
        text += &format!(", taper {:.2}", sq.taper);
    }
    if sq.bend_per_m != 0.0 {
        text += &format!(", bend {:.2} per m", sq.bend_per_m);
    }
    text + &format!(", at ({:.3}, {:.3}, {:.3}) m", t.x, t.y, t.z)
}
