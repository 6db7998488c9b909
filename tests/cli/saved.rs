//! What is written to files: pictures, animations, bodies, tables, plots.

use serde_json::Value;

use super::{endcomfort, has_keys, json, scratch};

#[test]
fn a_picture_has_its_size_and_scale_and_a_clear_corner_and_what_cannot_be_is_refused() {
    let file = |name: &str| scratch(name).to_string_lossy().into_owned();
    let draw = |name: &str, more: &[&str]| {
        let path = file(name);
        let args = ["render", "jar", "--size", "320x200", "--time", "3", "--transparent", "--out", &path];
        let output = endcomfort(&[&args[..], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        image::open(&path).unwrap().to_rgba8()
    };
    let (thin, thick) = (draw("thin.png", &[]), draw("thick.png", &["--scale", "4"]));
    assert_eq!((thin.dimensions(), thick.dimensions()), ((320, 200), (320, 200)));
    assert_eq!(thin.get_pixel(0, 0).0[3], 0, "no background");
    let told = draw("told.png", &["--words"]);
    let words = told.pixels().zip(thin.pixels()).filter(|(a, b)| a != b).count();
    assert!((500..20_000).contains(&words), "{words} pixels of labels");
    // The path of the hand is amber, as nothing else is.
    let is_amber = |[r, g, b, _]: [u8; 4]| r > 220 && (120..200).contains(&g) && b < 110;
    let amber = |picture: &image::RgbaImage| picture.pixels().filter(|pixel| is_amber(pixel.0)).count();
    let (thin, thick) = (amber(&thin), amber(&thick));
    assert!(thin > 20 && thick > 2 * thin, "lines are four times as thick: {thin} and {thick} pixels");
    let png = file("never.png");
    for (args, code, wanted) in [
        (vec!["--size", "9000x10", "--out", &png], 1, "--size: picture of 9000 × 10 pixels"),
        (vec!["--size", "8192x8192", "--out", &png], 1, "found 67.1 million pixels, wanted at most 33.2 million"),
        (vec!["--scale", "99", "--out", &png], 1, "--scale: found 99 pixels per point"),
        (vec!["--out", "picture.bmp"], 2, "wanted a file that ends in .png or .glb"),
        (vec!["--size", "320x200"], 2, "--out"),
        (vec!["--words", "--reach", "both", "--out", &png], 2, "cannot be used with"),
        (vec!["--animation", "never.gif", "--time", "1"], 2, "cannot be used with"),
        (vec!["--animation", "never.gif", "--fps", "60"], 1, "found 60 frames per second, wanted between 1 and 50"),
        (vec!["--animation", "never.apng", "--from", "3", "--to", "2"], 1, "found the part from 3 s to 2 s"),
    ] {
        let output = endcomfort(&[&["render", "jar"], &args[..]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(code) && said.contains(wanted), "{args:?}: {said}");
    }
    assert!(!scratch("never.png").exists());
}

#[test]
fn an_animation_has_a_frame_for_every_step_the_same_as_single_pictures() {
    let args = ["render", "jar", "--size", "96x64", "--fps", "2", "--from", "4", "--to", "6"];
    let record = |name: &str| {
        let path = scratch(name);
        let shown = path.to_string_lossy().into_owned();
        let output = endcomfort(&[&args[..], &["--animation", &shown]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && said.contains("(5 frames of 96 × 64 pixels, 2 per second)"), "{said}");
        path
    };
    let folder = record("frames");
    let frames: Vec<image::RgbaImage> = (0..5)
        .map(|frame| image::open(folder.join(format!("frame_{frame:04}.png"))).expect("a frame").to_rgba8())
        .collect();
    assert!(frames.windows(2).all(|pair| pair[0] != pair[1]), "the arm moves from frame to frame");
    // An animated PNG is a PNG whose picture is the first frame.
    let apng = std::fs::read(record("moving.apng")).unwrap();
    assert_eq!(image::load_from_memory_with_format(&apng, image::ImageFormat::Png).unwrap().to_rgba8(), frames[0]);
    assert!(apng.windows(4).filter(|window| *window == b"fcTL").count() == 5, "one control chunk for each frame");
    let gif = std::fs::read(record("moving.gif")).unwrap();
    assert!(gif.starts_with(b"GIF89a") && gif[6..10] == [96, 0, 64, 0] && gif.ends_with(&[0x3b]));
    let zip = std::fs::read(record("moving.zip")).unwrap();
    assert!(zip.starts_with(b"PK") && zip.windows(4).filter(|window| *window == b"PK\x01\x02").count() == 5);
    assert_eq!(zip, std::fs::read(record("again.zip")).unwrap(), "equal pictures, equal files");
}

#[test]
fn everything_in_the_picture_is_written_as_a_glb() {
    let path = scratch("scene.glb");
    let shown = path.to_string_lossy().into_owned();
    let output = endcomfort(&["render", "jar", "--time", "3", "--out", &shown]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let bytes = std::fs::read(&path).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], &bytes[16..20]), (&b"glTF"[..], &b"JSON"[..]));
    let root: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let count = |mode: Option<u64>| {
        let meshes = root["meshes"].as_array().unwrap().iter();
        meshes.filter(|mesh| mesh["primitives"][0]["mode"].as_u64() == mode).count()
    };
    assert!(count(None) > 20, "bodies of the robot and of what stands there");
    assert!(count(Some(0)) == 1 && count(Some(3)) > 0, "the cloud as points, paths as lines");
    let points = root["meshes"].as_array().unwrap().iter().find(|mesh| mesh["primitives"][0]["mode"] == 0).unwrap();
    let colors = points["primitives"][0]["attributes"]["COLOR_0"].as_u64().unwrap() as usize;
    assert!(root["accessors"][colors]["count"].as_u64().unwrap() > 10_000);
    assert!(root.get("animations").is_none());
}

#[test]
fn tables_come_as_csv_json_and_lines_and_agree() {
    let lines = json(&["table", "phases", "jar", "--json"]);
    assert_eq!(lines.len(), 7);
    has_keys(&lines[0], &["phase", "kind", "arm", "start_s", "duration_s", "clearance_m", "manipulability_mean"]);
    let (csv, file) = (scratch("phases.csv"), scratch("phases.json"));
    for path in [&csv, &file] {
        let output = endcomfort(&["table", "phases", "jar", "--out", &path.to_string_lossy()]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let rows: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    assert_eq!(rows, lines);
    let text = std::fs::read_to_string(&csv).unwrap();
    let heads: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let start = heads.iter().position(|head| *head == "start_s").unwrap();
    for (line, row) in text.lines().skip(1).zip(&rows) {
        assert_eq!(line.split(',').nth(start).unwrap().parse::<f64>().ok(), row["start_s"].as_f64());
    }
    for (name, keys) in [
        ("fates", &["fate", "points", "share"][..]),
        ("clusters", &["cluster", "points", "is_target", "size_z_m"]),
        ("fits", &["a_m", "e1", "qw", "radial_m", "volume_m3"]),
        ("runs", &["run", "name", "rms_last", "stop"]),
        ("objectives", &["objective", "radial_m", "time_s"]),
        ("voxels", &["arm", "x_m", "fraction", "manipulability_mean"]),
    ] {
        let rows = json(&["table", name, "jar", "--json"]);
        assert!(!rows.is_empty(), "{name}");
        has_keys(&rows[0], keys);
    }
    let empty = endcomfort(&["table", "places", "jar"]);
    let said = String::from_utf8_lossy(&empty.stderr).into_owned();
    assert!(empty.status.code() == Some(1) && said.contains("\"places\" has no row here"), "{said}");
    assert_eq!(endcomfort(&["table", "chairs", "jar"]).status.code(), Some(2));
    assert_eq!(endcomfort(&["table", "phases", "jar", "--out", "phases.txt"]).status.code(), Some(2));
}

#[test]
fn plots_are_written_as_svg() {
    let path = scratch("timeline.svg");
    let output = endcomfort(&["plot", "timeline", "jar", "--out", &path.to_string_lossy()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("<svg ") && text.matches("<polyline ").count() == 2 && text.contains("time, s"), "{text}");
    let cost = endcomfort(&["plot", "cost", "jar"]);
    assert!(String::from_utf8_lossy(&cost.stdout).contains("rms of the residuals, mm"));
    let clusters = scratch("plotted");
    json(&["segment", "mustard", "--json", "--out", &clusters.to_string_lossy()]);
    let cloud = clusters.join("cluster_2.ply").to_string_lossy().into_owned();
    let fitted = endcomfort(&["fit", &cloud, "--plots", &clusters.to_string_lossy()]);
    assert!(fitted.status.success(), "{}", String::from_utf8_lossy(&fitted.stderr));
    let read = |name: &str| std::fs::read_to_string(clusters.join(name)).expect("the plot was written");
    assert!(read("cluster_2_cost.svg").contains("runs on cluster_2"));
    assert!(read("cluster_2_residuals.svg").contains("95 % within"));
    let none = endcomfort(&["plot", "cost", "jar", "--cluster", "99"]);
    assert!(String::from_utf8_lossy(&none.stderr).contains("there is no cluster 99"));
    assert_eq!(endcomfort(&["plot", "weather", "jar"]).status.code(), Some(2));
}
