//! `check`: loads any supported file and says what it found and what is wrong.

use std::path::{Path, PathBuf};

use endcomfort_core::cloud::PointCloud;
use endcomfort_core::collision::{AllowedCollisions, CollisionError};
use endcomfort_core::object::HouseholdObject;
use endcomfort_core::robot::{Robot, load_robot, read_urdf};
use endcomfort_core::scene::Scene;
use serde_json::{Value, json};

use super::{Common, Failure, input};

/// The field that only `--json` gives: too long to read.
const ALLOWED_PAIRS: &str = "allowed_pairs";

#[derive(clap::Args)]
pub(super) struct Args {
    /// Clouds (PCD, PLY, XYZ), scenes and objects (JSON), robots (URDF, with an SRDF of the same name beside it).
    #[arg(required = true)]
    files: Vec<PathBuf>,
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let mut failures = Vec::new();
    for file in &args.files {
        let report = match report(file) {
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

fn report(path: &Path) -> Result<Value, Failure> {
    let file = path.display().to_string();
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "urdf" => robot(path, &file),
        "json" => json_file(path, &file),
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

fn json_file(path: &Path, file: &str) -> Result<Value, Failure> {
    let bytes = input::read_file(path)?;
    let text = String::from_utf8_lossy(&bytes);
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

fn robot(path: &Path, file: &str) -> Result<Value, Failure> {
    let text = |path: &Path| input::read_file(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    let folder = path.parent().unwrap_or(Path::new(".")).to_path_buf();
    let resolve = |uri: &str| {
        let relative = uri.strip_prefix("package://").unwrap_or(uri);
        let inside = relative.split_once('/').map_or(relative, |(_, rest)| rest);
        // A package is rooted at some folder above the URDF: the nearest one that holds the file is taken.
        folder.ancestors().flat_map(|root| [root.join(relative), root.join(inside)]).find_map(|p| std::fs::read(p).ok())
    };
    let srdf = path.with_extension("srdf");
    let wrong = |error| Failure::new(format!("{file}: {error}"));
    let urdf = text(path)?;
    let loaded = if srdf.exists() {
        load_robot(&urdf, &text(&srdf)?, &resolve).map_err(wrong)?
    } else {
        read_urdf(&urdf, &resolve).map_err(wrong)?
    };
    let robot = loaded.value;
    let (counts, pairs) = allowed(&robot).map_err(|error| Failure::new(format!("{file}: {error}")))?;
    Ok(json!({
        "file": file, "ok": true, "kind": "robot", "name": robot.name, "links": robot.links.len(),
        "degrees_of_freedom": robot.dof_count(), "arms": robot.arms.iter().map(|a| &a.name).collect::<Vec<_>>(),
        "postures": robot.postures.iter().map(|(name, _)| name).collect::<Vec<_>>(), "notes": loaded.notes,
        "allowed": counts, ALLOWED_PAIRS: pairs,
    }))
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
