//! `check`: loads any supported file and says what it found and what is wrong.

use std::path::{Path, PathBuf};

use endcomfort_core::cloud::{Intrinsics, PointCloud};
use endcomfort_core::collision::{AllowedCollisions, CollisionError};
use endcomfort_core::guest::{Files, Proposal, RobotDescription};
use endcomfort_core::loaded::Loaded;
use endcomfort_core::mesh_file;
use endcomfort_core::object::HouseholdObject;
use endcomfort_core::robot::{Robot, load_robot, read_urdf};
use endcomfort_core::scene::Scene;
use serde_json::{Value, json};

use super::robot_options::ArmOptions;
use super::{Common, Failure, input};
use crate::{assets, brought};

/// The field that only `--json` gives: too long to read.
const ALLOWED_PAIRS: &str = "allowed_pairs";

#[derive(clap::Args)]
pub(super) struct Args {
    /// Clouds (PCD, PLY, XYZ), depth images (PNG) and intrinsics (JSON), meshes (OBJ, STL, GLB), scenes and objects (JSON), robots (URDF, with an SRDF of the same name beside it; a folder,
    /// a .zip or a .robot.json).
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    arms: ArmOptions,
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let mut failures = Vec::new();
    for file in &args.files {
        let report = match report(file, &args.arms) {
            Ok(report) => report,
            Err(failure) => {
                failures.push(failure.to_string());
                json!({ "file": file.display().to_string(), "ok": false, "error": failure.to_string() })
            }
        };
        if common.json {
            println!("{report}");
        } else {
            print_report(&report);
        }
    }
    if failures.is_empty() {
        return Ok(());
    }
    let message = format!("{} of {} files cannot be used", failures.len(), args.files.len());
    Err(Failure::new(message).with_details(failures))
}

fn print_report(report: &Value) {
    let Some(fields) = report.as_object() else { return };
    for (name, value) in fields.iter().filter(|(name, _)| *name != ALLOWED_PAIRS) {
        match value {
            Value::String(text) => println!("{name}: {text}"),
            Value::Array(lines) if lines.iter().all(Value::is_string) => {
                lines.iter().filter_map(Value::as_str).for_each(|line| println!("{name}: {line}"));
            }
            other => println!("{name}: {other}"),
        }
    }
    println!();
}

fn report(path: &Path, arms: &ArmOptions) -> Result<Value, Failure> {
    let file = path.display().to_string();
    if brought::disk::is_robot(path) {
        return robot(path, &file, arms);
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "json" => json_file(path, &file),
        "png" => depth_image(path, &file),
        extension if mesh_file::ENDINGS.contains(&extension) => mesh(path, &file),
        _ => {
            let loaded = input::cloud_file(path)?;
            Ok(cloud(&file, &loaded.value, &loaded.notes))
        }
    }
}

fn cloud(file: &str, cloud: &PointCloud, notes: &[String]) -> Value {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in &cloud.points {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    json!({
        "file": file, "ok": true, "kind": "cloud", "points": cloud.points.len(),
        "organised": cloud.grid.as_ref().map(|g| json!([g.width, g.height])),
        "colors": !cloud.colors.is_empty(), "sensor_known": cloud.X_FC.is_some(),
        "min_m": (!cloud.points.is_empty()).then_some(low), "max_m": (!cloud.points.is_empty()).then_some(high),
        "notes": notes,
    })
}

fn depth_image(path: &Path, file: &str) -> Result<Value, Failure> {
    let image = brought::DepthImage::read(file, &input::read_file(path)?).map_err(Failure::new)?;
    let measured = image.depth.iter().filter(|&&depth| depth > 0);
    Ok(json!({
        "file": file, "ok": true, "kind": "depth image", "width": image.width, "height": image.height,
        "measured": measured.clone().count(), "min": measured.clone().min(), "max": measured.max(), "notes": [],
    }))
}

fn mesh(path: &Path, file: &str) -> Result<Value, Failure> {
    let wrong = |error: mesh_file::MeshError| Failure::new(format!("{file}: {error}"));
    let mesh = mesh_file::read_mesh(file, &input::read_file(path)?).map_err(wrong)?;
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in &mesh.positions {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    let (unit, reason) = mesh_file::guess_unit(file, &mesh);
    Ok(json!({
        "file": file, "ok": true, "kind": "mesh", "triangles": mesh.triangles.len(), "vertices": mesh.positions.len(),
        "min": low, "max": high, "unit": unit.symbol(), "notes": [reason],
    }))
}

fn json_file(path: &Path, file: &str) -> Result<Value, Failure> {
    let bytes = input::read_file(path)?;
    let text = String::from_utf8_lossy(&bytes);
    let json = serde_json::from_str::<Value>(&text);
    if json.as_ref().is_ok_and(Intrinsics::is_meant_by) {
        let Loaded { value, notes } =
            Intrinsics::parse(&text).map_err(|error| Failure::new(format!("{file}: {error}")))?;
        return Ok(json!({
            "file": file, "ok": true, "kind": "intrinsics", "focal_px": value.focal_px, "center_px": value.center_px,
            "size_px": value.size_px, "depth_scale_m": value.depth_scale_m, "notes": notes,
        }));
    }
    let is_object = serde_json::from_str::<Value>(&text).is_ok_and(|value| value.get("parts").is_some());
    if is_object {
        let object = HouseholdObject::parse(&text).map_err(|error| Failure::new(format!("{file}: {error}")))?;
        return Ok(json!({
            "file": file, "ok": true, "kind": "object", "title": object.title, "source": object.source,
            "parts": object.parts.len(), "notes": [],
        }));
    }
    let scene = Scene::parse(&text).map_err(|error| Failure::new(format!("{file}: {error}")))?;
    Ok(json!({
        "file": file, "ok": true, "kind": "scene", "title": scene.title, "robot": scene.robot,
        "objects": scene.objects.len(), "obstacles": scene.obstacles.len(), "notes": [],
    }))
}

/// A robot as its files have it, and what would be made of it here.
fn robot(path: &Path, file: &str, arms: &ArmOptions) -> Result<Value, Failure> {
    let files = brought::disk::robot_files(path).map_err(Failure::new)?;
    let wrong = |error: &dyn std::fmt::Display| Failure::new(format!("{file}: {error}"));
    let (robot, notes) = as_it_is(&files, &wrong)?;
    let (counts, pairs) = allowed(&robot).map_err(|error| wrong(&error))?;
    let table = assets::demo(assets::DEMOS[0]).ok_or_else(|| Failure::new("the first demo is missing"))?.table;
    let Proposal { guest, notes: found, problem } = match arms.proposal(path, &table) {
        Ok(proposal) => proposal,
        // What the program cannot use may still be right as a URDF.
        Err(failure) => {
            return Ok(robot_json(file, &robot, &notes, counts, pairs, &json!({ "problem": failure.to_string() })));
        }
    };
    let RobotDescription { arms, stand, .. } = &guest.description;
    let arms: Vec<Value> = arms
        .iter()
        .map(|arm| {
            let hand = arm.hand.as_ref().map_or("its own", |hand| &hand.name);
            json!({ "name": arm.name, "base_link": arm.base_link, "tip_link": arm.tip_link, "tcp": arm.tcp, "hand": hand })
        })
        .collect();
    let acting = json!({ "arms": arms, "stand": stand, "found": found, "problem": problem });
    Ok(robot_json(file, &robot, &notes, counts, pairs, &acting))
}

/// The robot of the URDF and SRDF alone, and the notes of their readers.
fn as_it_is(files: &Files, wrong: &dyn Fn(&dyn std::fmt::Display) -> Failure) -> Result<(Robot, Vec<String>), Failure> {
    let description = files.description().map_err(|error| wrong(&error))?;
    let named = description.as_ref().map(|(_, description)| description.urdf.as_str());
    let urdf = files.urdf(named).map_err(|error| wrong(&error))?;
    let text = |path: &str| String::from_utf8_lossy(files.get(path).unwrap_or_default()).into_owned();
    let resolve = |uri: &str| files.resolve(urdf, uri).map(<[u8]>::to_vec);
    let alone = || read_urdf(&text(urdf), &resolve).map_err(|error| wrong(&error));
    let loaded = match files.srdf_beside(urdf) {
        None => alone()?,
        Some(srdf) => match load_robot(&text(urdf), &text(srdf), &resolve) {
            Ok(loaded) => loaded,
            // SRDFs of other programs name hands in other ways.
            Err(error) => {
                let mut loaded = alone()?;
                loaded.notes.push(format!("{srdf}: {error}"));
                loaded
            }
        },
    };
    Ok((loaded.value, loaded.notes))
}

fn robot_json(file: &str, robot: &Robot, notes: &[String], counts: Value, pairs: Vec<Value>, acting: &Value) -> Value {
    json!({
        "file": file, "ok": true, "kind": "robot", "name": robot.name, "links": robot.links.len(),
        "degrees_of_freedom": robot.dof_count(), "arms": robot.arms.iter().map(|a| &a.name).collect::<Vec<_>>(),
        "postures": robot.postures.iter().map(|(name, _)| name).collect::<Vec<_>>(), "notes": notes,
        "acting": acting, "allowed": counts, ALLOWED_PAIRS: pairs,
    })
}

/// How many pairs of links may touch or cannot, by reason, and all of them; `srdf` are those that only the SRDF names.
fn allowed(robot: &Robot) -> Result<(Value, Vec<Value>), CollisionError> {
    let computed = AllowedCollisions::compute(robot, AllowedCollisions::SEED)?;
    let mut counts = serde_json::Map::new();
    let mut pairs = Vec::new();
    let mut add = |a: usize, b: usize, reason: &str| {
        let count = counts.get(reason).and_then(Value::as_u64).unwrap_or(0);
        counts.insert(reason.to_owned(), json!(count + 1));
        pairs.push(json!({ "a": robot.links[a].name, "b": robot.links[b].name, "reason": reason }));
    };
    for pair in &computed.pairs {
        add(pair.a, pair.b, pair.reason.name());
    }
    for &(a, b) in robot.allowed_collisions.iter().filter(|(a, b)| computed.reason(*a, *b).is_none()) {
        add(a, b, "srdf");
    }
    Ok((Value::Object(counts), pairs))
}
