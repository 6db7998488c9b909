//! The command line end to end, on bundled demos and on the real clouds where they are at hand.

mod brought;
mod saved;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// The program, without a display.
fn endcomfort(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_endcomfort"))
        .args(args)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("the program starts")
}

fn lines(output: &Output) -> Vec<Value> {
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e} in {line}"))).collect()
}

fn json(args: &[&str]) -> Vec<Value> {
    let output = endcomfort(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    lines(&output)
}

/// A file of the shared data, or a word that the test is skipped.
fn data(path: &str) -> Option<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(path);
    if file.is_file() {
        return Some(file.to_string_lossy().into_owned());
    }
    println!("skipped: no data ({path})");
    None
}

fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::create_dir_all(folder).expect("a scratch folder can be made");
    folder.join(name)
}

fn has_keys(value: &Value, keys: &[&str]) {
    for key in keys {
        assert!(value.get(key).is_some(), "no {key:?} in {value}");
    }
}

#[test]
fn a_broken_link_is_refused_in_words_before_a_window_is_looked_for() {
    let output = endcomfort(&["view", "--link", "#s=what?"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("the link could not be opened: it is not base64url"), "{said}");
    let output = endcomfort(&["view", "spoon"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && said.contains("mustard"), "{said}");
}

#[test]
fn a_real_mug_on_a_table_is_one_cluster_in_both_captures() {
    for scene in ["scenes/gpd_table_mug.pcd", "scenes/pcl_table_scene_mug_stereo_textured.pcd"] {
        let Some(file) = data(scene) else { return };
        let found = &json(&["segment", &file, "--json"])[0];
        assert_eq!(found["clusters"].as_array().unwrap().len(), 1, "{scene}: {found}");
        has_keys(found, &["file", "points", "table", "fates", "segment_ms"]);
        let fates: u64 = found["fates"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum();
        assert_eq!(fates, found["points"].as_u64().unwrap(), "every point has one fate");
    }
}

#[test]
fn segment_writes_clusters_that_fit_reads() {
    let folder = scratch("clusters");
    let found = &json(&["segment", "mustard", "--json", "--out", &folder.to_string_lossy()])[0];
    let count = found["clusters"].as_array().unwrap().len();
    assert_eq!(count, 5);
    let files: Vec<String> =
        (0..count).map(|k| folder.join(format!("cluster_{k}.ply")).to_string_lossy().into_owned()).collect();
    let mut args = vec!["fit", "--json"];
    args.extend(files.iter().map(String::as_str));
    assert_eq!(json(&args).len(), count);
}

#[test]
fn fit_speaks_the_promised_json() {
    let Some(file) = data("ycb/clouds/005_tomato_soup_can.ply").or_else(|| data("ycb/clouds/056_tennis_ball.ply"))
    else {
        return;
    };
    let fit = &json(&["fit", &file, "--json", "--mirror", "off"])[0];
    has_keys(
        fit,
        &[
            "file",
            "points",
            "used_points",
            "superquadric",
            "radial_m",
            "goodness_of_fit",
            "goodness_of_fit_abs",
            "volume_m3",
            "iterations",
            "fit_ms",
        ],
    );
    let sq = &fit["superquadric"];
    has_keys(sq, &["semi_axes_m", "exponents", "translation_m", "rotation_xyzw", "taper", "bend_per_m"]);
    // A tennis ball of 33 mm radius.
    for axis in sq["semi_axes_m"].as_array().unwrap() {
        assert!((axis.as_f64().unwrap() - 0.0333).abs() < 0.002, "{sq}");
    }
    assert!(fit["radial_m"].as_f64().unwrap() < 0.001, "{fit}");
}

#[test]
fn grasps_speak_the_promised_json_best_first() {
    let rows =
        json(&["grasps", "coffee_jar", "--robot", "crichton", "--arm", "left", "--place", "0.45,0.35,0.77", "--json"]);
    for row in &rows {
        has_keys(
            row,
            &[
                "rank",
                "object_from_hand",
                "m_g_start",
                "m_g_goal",
                "ik_count_start",
                "ik_count_goal",
                "contacts",
                "epsilon",
                "width_m",
                "status",
                "reason",
                "elapsed_ms",
            ],
        );
        assert_eq!(row["object_from_hand"].as_array().unwrap().len(), 16);
        let accepted = row["status"] == "accepted";
        assert_eq!(accepted, row["rank"].is_u64());
        assert_eq!(accepted, row["reason"] == "", "{row}");
    }
    let merits: Vec<f64> =
        rows.iter().filter(|r| r["rank"].is_u64()).map(|r| r["m_g_goal"].as_f64().unwrap()).collect();
    assert!(merits.len() > 3 && merits.windows(2).all(|pair| pair[0] >= pair[1]), "{merits:?}");
    let top = json(&["grasps", "coffee_jar", "--robot", "alita", "--arm", "right", "--top", "3", "--json"]);
    assert_eq!(top.len(), 3);
}

#[test]
fn a_plan_is_the_same_text_twice_and_has_every_phase() {
    let args = ["plan", "place", "jar", "--seed", "11", "--json"];
    let (first, second) = (endcomfort(&args), endcomfort(&args));
    assert!(first.status.success() && first.stdout == second.stdout);
    let phases: Vec<String> = lines(&first).iter().map(|l| l["phase"].as_str().unwrap().to_owned()).collect();
    assert_eq!(phases, ["reach", "close", "lift", "transport", "place", "open", "retreat"]);
    let pick = json(&["plan", "pick", "mustard", "--json"]);
    assert_eq!(pick.len(), 3);
    has_keys(&pick[0], &["joint_names", "times_s", "positions", "duration_s", "start_s", "arm"]);
}

#[test]
fn the_other_robot_can_be_asked_for() {
    let crichton = json(&["plan", "pick", "mustard", "--robot", "crichton", "--json"]);
    let names = crichton[0]["joint_names"].to_string();
    assert!(names.contains("finger"), "{names}");
}

#[test]
fn a_real_dropped_cloud_is_grasped_on_the_robots_table() {
    let Some(file) = data("scenes/pcl_table_scene_mug_stereo_textured.pcd") else { return };
    let rows = json(&["grasps", &file, "--robot", "crichton", "--arm", "left", "--json"]);
    assert!(rows.len() > 50, "{} candidates", rows.len());
    assert!(rows[0]["rank"] == 1, "the mug can be grasped: {}", rows[0]);
}

#[test]
fn refusals_exit_with_1_and_name_the_place_and_bad_usage_with_2() {
    let broken = scratch("broken.pcd");
    std::fs::write(&broken, "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 10\nHEIGHT 1\nPOINTS 10\nDATA ascii\n0 0 0\n").unwrap();
    let broken = broken.to_string_lossy().into_owned();
    for args in [
        vec!["segment", &broken],
        vec!["fit", &broken],
        vec!["grasps", &broken],
        vec!["check", &broken],
        vec!["plan", "place", "no_such_demo"],
        vec!["render", "no_such_demo", "--out", "x.png"],
    ] {
        let output = endcomfort(&args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{args:?}: {said}");
        assert!(said.contains("broken.pcd") || said.contains("no_such_demo"), "{args:?}: {said}");
        assert!(!said.contains("panicked"), "{said}");
    }
    assert_eq!(endcomfort(&["fit"]).status.code(), Some(2));
    assert_eq!(endcomfort(&["plan", "dance", "jar"]).status.code(), Some(2));
    let refused = endcomfort(&["fit", &broken, "--json"]);
    assert_eq!(lines(&refused)[0]["status"], "refused");
}

#[test]
fn check_tells_what_clouds_objects_scenes_and_robots_hold() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let file = |path: &str| root.join(path).to_string_lossy().into_owned();
    let files = [file("objects/coffee_jar.json"), file("objects/scenes/jar.json"), file("robots/alita/alita.urdf")];
    let mut args = vec!["check", "--json"];
    args.extend(files.iter().map(String::as_str));
    let reports = json(&args);
    let kinds: Vec<&str> = reports.iter().map(|r| r["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["object", "scene", "robot"]);
    assert_eq!(reports[2]["arms"], serde_json::json!(["left", "right"]));
    assert_eq!(reports[2]["notes"], serde_json::json!([]), "every mesh is found");
}

/// `ik` of the left arm of a bundled robot from one of its links, with a file of poses.
fn ik<'a>(urdf: &'a str, base: &'a str, poses: &'a str) -> Vec<&'a str> {
    vec!["ik", urdf, "--base", base, "--tip", "left_tcp", "--poses", poses]
}

#[test]
fn ik_solves_poses_in_closed_form_with_a_torso_and_numerically_with_the_same_rows() {
    let crichton = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/crichton/crichton.urdf");
    let crichton = crichton.to_string_lossy().into_owned();
    // In front of the left shoulder, pointing down; then a metre beyond any arm.
    let file = |name: &str, text: &str| {
        let path = scratch(name);
        std::fs::write(&path, text).unwrap();
        path.to_string_lossy().into_owned()
    };
    let in_world = file("in_world.txt", "# x y z qx qy qz qw\n0.5 0.3 1.0 1 0 0 0\n2.5, 0.3, 1.0, 1, 0, 0, 0\n");
    let in_arm = file("in_arm.txt", "0.1 0.2 0.9 0 0 0 1\n");
    // Six joints: the second link of the arm is the base, so that no S-R-S arm is left.
    for (base, poses, joints, method) in [
        ("base", &in_world, 8, "closed form (S-R-S), first joint at"),
        ("left_arm_base", &in_arm, 7, "closed form (S-R-S)"),
        ("left_arm_1", &in_arm, 6, "numeric, since the arm is not S-R-S: 6 joints"),
    ] {
        let output = endcomfort(&[&ik(&crichton, base, poses)[..], &["--sweep", "24", "--json"]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && said.contains(method), "{base}: {said}");
        let rows = lines(&output);
        has_keys(
            &rows[0],
            &["pose", "status", "reason", "q", "error_m", "error_rad", "first_us", "solutions", "sweep_us"],
        );
        assert_eq!(rows[0]["status"], "solved", "{base}: {}", rows[0]);
        assert_eq!(rows[0]["q"].as_array().unwrap().len(), joints);
        assert!(rows[0]["error_m"].as_f64().unwrap() < 1e-9 && rows[0]["error_rad"].as_f64().unwrap() < 1e-9);
        assert!(!rows[0]["solutions"].as_array().unwrap().is_empty());
        if let Some(far) = rows.get(1) {
            assert_eq!(far["status"], "refused");
            assert!(far["reason"].as_str().unwrap().starts_with("out of reach by "), "{far}");
            assert!(said.contains("1 of 2 poses solved"), "{said}");
        }
    }
    let text = endcomfort(&ik(&crichton, "left_arm_base", &in_arm));
    assert!(text.status.success() && String::from_utf8_lossy(&text.stdout).contains("µs"));

    let short = file("short.txt", "0 0 1 0 0 0 1\n0 0 1\n");
    for (args, wanted) in [
        (ik(&crichton, "left_arm_base", &short), "short.txt: line 2: found 3 numbers, wanted 7"),
        (ik(&crichton, "no_such_link", &in_arm), "--base: found no link \"no_such_link\""),
        (ik(&crichton, "right_arm_base", &in_arm), "does not descend from"),
        (ik(&crichton, "left_arm_base", "no_such_file.txt"), "no_such_file.txt"),
        (ik("no_such.urdf", "left_arm_base", &in_arm), "no_such.urdf"),
    ] {
        let output = endcomfort(&args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{args:?}: {said}");
        assert!(said.contains(wanted), "{args:?}: {said}");
    }
}

#[test]
fn ik_reaches_all_thousand_poses_of_the_shared_workload() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/bench/arm");
    if !folder.is_dir() {
        println!("skipped: no data (bench/arm)");
        return;
    }
    let file = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let (urdf, poses) = (file("srs7.urdf"), file("ik_work.json"));
    let rows = json(&["ik", &urdf, "--base", "base", "--tip", "tcp", "--poses", &poses, "--json"]);
    assert_eq!(rows.len(), 1000);
    assert!(rows.iter().all(|row| row["status"] == "solved" && row["error_m"].as_f64().unwrap() < 1e-9));
}

#[test]
fn without_a_display_the_window_says_what_to_do_instead() {
    let output = endcomfort(&[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("cargo xtask serve") && said.contains("render"), "{said}");
}

#[test]
fn render_draws_a_demo_at_a_moment_with_the_robot_in_view() {
    let draw = |name: &str, more: &[&str]| {
        let path = scratch(name).to_string_lossy().into_owned();
        let mut args = vec!["render", "jar", "--size", "480x300", "--out", &path];
        args.extend(more);
        let output = endcomfort(&args);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        image::open(&path).unwrap().to_rgba8()
    };
    let still = draw("still.png", &["--time", "0"]);
    assert_eq!(still.dimensions(), (480, 300));
    let colors: std::collections::BTreeSet<[u8; 4]> = still.pixels().map(|p| p.0).collect();
    assert!(colors.len() > 500, "only {} colours", colors.len());
    // Pale shells of the robot: nothing else in the dark theme is that bright.
    let pale = still.pixels().filter(|p| p.0[..3].iter().all(|&c| c > 170)).count();
    assert!(pale > 480 * 300 / 200, "only {pale} pale pixels");
    let later = draw("later.png", &["--time", "11"]);
    let changed = still.pixels().zip(later.pixels()).filter(|(a, b)| a != b).count();
    assert!(changed > 480 * 300 / 100, "only {changed} pixels changed while the robot moved");
    let clear = draw("clear.png", &["--transparent"]);
    assert!(clear.pixels().any(|p| p.0[3] == 0) && clear.pixels().any(|p| p.0[3] == 255));
}

#[test]
fn render_looks_closely_at_a_robot_that_somebody_posed() {
    let draw = |name: &str, more: &[&str]| {
        let path = scratch(name).to_string_lossy().into_owned();
        let output = endcomfort(&[&["render", "jar", "--size", "480x300", "--out", &path], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        (image::open(&path).unwrap().to_rgba8(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (usual, _) = draw("usual.png", &[]);
    for (name, more) in [
        ("cut.png", &["--cut", "x<0.5"][..]),
        ("height.png", &["--color-by", "height", "--point-size", "5"]),
        ("posed.png", &["--joint", "left_joint_1=60"]),
    ] {
        let (other, said) = draw(name, more);
        let changed = usual.pixels().zip(other.pixels()).filter(|(a, b)| a != b).count();
        assert!(changed > 1500, "{more:?} changed only {changed} pixels");
        assert_eq!(said.contains("Height, viridis from"), name == "height.png", "{said}");
    }
    for (joint, said) in [("left_joint_1=999", "its limits are"), ("tail=1", "no joint \"tail\"")] {
        let output = endcomfort(&["plan", "place", "jar", "--joint", joint]);
        assert_eq!(output.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&output.stderr).contains(said), "{joint}");
    }
    assert_eq!(endcomfort(&["render", "jar", "--cut", "w<1", "--out", "x.png"]).status.code(), Some(2));
}

#[test]
fn fit_takes_every_objective_and_a_reference_and_tells_its_history() {
    let folder = scratch("fitted");
    json(&["segment", "mustard", "--json", "--out", &folder.to_string_lossy()]);
    let cloud = folder.join("cluster_0.ply").to_string_lossy().into_owned();
    for objective in ["radial", "solina", "ichim", "chevalier", "f5"] {
        let fit = &json(&["fit", &cloud, "--json", "--objective", objective, "--reference", &cloud])[0];
        assert_eq!(fit["objective"], objective);
        has_keys(fit, &["runs", "models", "parts", "rejected", "mirrored", "volume_m3", "reference_goodness_of_fit"]);
        assert_eq!(fit["reference_points"], fit["points"]);
        let runs = fit["runs"].as_array().unwrap();
        assert!(!runs.is_empty());
        has_keys(&runs[0], &["name", "points", "rms", "iterations", "stop"]);
        has_keys(&fit["superquadric"], &["taper", "bend_per_m"]);
    }
    let flags = ["--deform", "auto", "--hierarchical", "--parts", "2", "--keep-outliers", "--mirror", "off"];
    let told = endcomfort(&[&["fit", cloud.as_str()], &flags[..]].concat());
    let said = String::from_utf8_lossy(&told.stdout);
    assert!(told.status.success() && said.contains("semi-axes") && said.contains("mirroring is off"), "{said}");
    let refused = endcomfort(&["fit", &cloud, "--parts", "0"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--parts: found 0, wanted 1 or more"));
    assert_eq!(endcomfort(&["fit", &cloud, "--objective", "best"]).status.code(), Some(2));
}

#[test]
fn an_experiment_gives_the_same_rows_as_lines_as_a_table_and_as_files() {
    let (rows_csv, fits_json) = (scratch("rows.csv"), scratch("fits.json"));
    let (rows_file, fits_file) = (rows_csv.to_string_lossy().into_owned(), fits_json.to_string_lossy().into_owned());
    let args = ["experiment", "visibility", "--trials", "3", "--seed", "5", "--json"];
    let rows = json(&[&args[..], &["--out", &rows_file, "--fits", &fits_file]].concat());
    let conditions: Vec<&str> = rows.iter().map(|row| row["condition"].as_str().unwrap()).collect();
    assert_eq!(conditions, ["full", "full noisy", "partial", "partial noisy"]);
    for row in &rows {
        has_keys(row, &["experiment", "objective", "trials", "success", "recovered", "radial_mean_m", "radial_p95_m"]);
        has_keys(row, &["goodness_of_fit_mean", "goodness_of_fit_abs_mean", "volume_error_median_percent"]);
        has_keys(row, &["exponents_within_0_1_percent", "thesis_radial_mean_m"]);
        assert!(row.get("time_mean_s").is_none(), "fits ran side by side: {row}");
    }
    let again = endcomfort(&args);
    assert_eq!(lines(&again), rows, "same seed, same rows");

    let table = std::fs::read_to_string(&rows_csv).unwrap();
    let table: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let column = table[0].iter().position(|name| *name == "radial_mean_m").unwrap();
    for (line, row) in table[1..].iter().zip(&rows) {
        let number: f64 = line[column].parse().unwrap();
        assert!((number / row["radial_mean_m"].as_f64().unwrap() - 1.0).abs() < 1e-12);
    }
    let fits: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(&fits_json).unwrap()).unwrap();
    assert_eq!(fits.len(), 12);
    has_keys(&fits[0], &["trial", "radial_m", "true_a_m", "found_a_m", "exponent_error", "iterations"]);

    let timed = json(&["experiment", "peers", "--trials", "1", "--serial", "--json"]);
    assert!(timed.iter().all(|row| row["time_median_s"].as_f64().unwrap() > 0.0));
    let shown = endcomfort(&args[..6]);
    let shown = String::from_utf8_lossy(&shown.stdout).into_owned();
    assert!(shown.contains("thesis  partial noisy") && shown.contains("without times"), "{shown}");
}

#[test]
fn trials_come_from_a_file_and_a_bad_line_is_named() {
    let file = scratch("trials.txt");
    let path = file.to_string_lossy().into_owned();
    std::fs::write(&file, "# a b c e1 e2 tx ty tz gamma beta alpha\n0.1 0.1 0.1 1 1 0 0 0.8 0 0 0\n").unwrap();
    let rows = json(&["experiment", "downsampling", "--trials-file", &path, "--json"]);
    assert_eq!(rows.len(), 6);
    assert!(rows.iter().all(|row| row["trials"] == 1 && row["success"] == 1));
    std::fs::write(&file, "0.1 0.1 0.1 1 1 0 0 0.8 0 0 0\n0.1 0.1 0.1 1 9 0 0 0.8 0 0 0\n").unwrap();
    for (args, wanted) in [
        (vec!["experiment", "visibility", "--trials-file", &path], "trials.txt: line 2: exponent e2 is 9"),
        (vec!["experiment", "visibility", "--trials-file", "none.txt"], "none.txt: "),
        (vec!["experiment", "objects", "--trials-file", &path], "--trials-file: experiment objects has no use"),
        (vec!["experiment", "visibility", "--views", "."], "--views: experiment visibility has no use"),
        (vec!["experiment", "objects", "--views", "tests"], "tests"),
        (vec!["experiment", "visibility", "--out", "rows.txt"], "rows.txt: wanted a file that ends in .csv or .json"),
        (vec!["experiment", "visibility", "--trials", "0"], "found 0 trials, wanted at least 1"),
    ] {
        let output = endcomfort(&args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{args:?}: {said}");
        assert!(said.contains(wanted), "{args:?}: {said} should say {wanted}");
    }
    assert_eq!(endcomfort(&["experiment", "alchemy"]).status.code(), Some(2));
}

#[test]
fn objects_are_compared_with_and_without_mirroring() {
    let rows = json(&["experiment", "objects", "--trials", "1", "--json"]);
    assert_eq!(rows.len(), 4 + 2 * endcomfort::assets::object_names().len());
    let of = |condition: &str| rows.iter().find(|row| row["object"] == "all" && row["condition"] == condition).unwrap();
    assert!(of("mirrored")["mirrored"].as_u64().unwrap() > 6, "most objects have a plane of symmetry");
    assert_eq!(of("not mirrored")["mirrored"], 0);
    // One view of everyday things: half of the extents are right to a few millimetres.
    assert!(of("mirrored")["extent_error_median_m"].as_f64().unwrap() < 0.006);
    if let Some(view) = data("ycb/views/056_tennis_ball_view.json") {
        let folder = Path::new(&view).parent().unwrap().to_string_lossy().into_owned();
        let rows = json(&["experiment", "objects", "--views", &folder, "--json"]);
        let ball = rows.iter().find(|row| row["object"] == "056_tennis_ball").unwrap();
        assert!(ball["extent_error_max_m"].as_f64().unwrap() < 0.004, "{ball}");
    }
}

#[test]
fn grasps_are_prioritized_on_one_robot() {
    let cases = scratch("cases.csv");
    let file = cases.to_string_lossy().into_owned();
    let args = ["experiment", "prioritization", "--trials", "1", "--robot", "alita", "--json", "--cases", &file];
    let rows = json(&args);
    assert_eq!(rows.len(), 12);
    for row in &rows {
        assert_eq!((&row["robot"], &row["trials"]), (&Value::from("alita"), &Value::from(1)));
        has_keys(row, &["condition", "metric", "success", "success_percent", "success_low_percent", "tried_mean"]);
        has_keys(row, &["grasps_accepted_mean", "excluded", "excluded_path"]);
        let is_the_thesis_s = matches!(row["metric"].as_str(), Some("goal" | "start" | "mean"));
        assert_eq!(row.get("thesis_success").is_some(), is_the_thesis_s);
    }
    let cases = std::fs::read_to_string(&cases).unwrap();
    assert!(cases.lines().count() > 12 && cases.starts_with("experiment,condition,robot,case,arm,object"), "{cases}");
    for (args, wanted) in [
        (vec!["experiment", "prioritization", "--robot", "hal"], "no robot \"hal\""),
        (vec!["experiment", "prioritization", "--views", "."], "--views: experiment prioritization has no use"),
        (vec!["experiment", "visibility", "--robot", "alita"], "--robot: experiment visibility has no use"),
    ] {
        let output = endcomfort(&args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{args:?}: {said}");
        assert!(said.contains(wanted), "{args:?}: {said} should say {wanted}");
    }
}

#[test]
fn grasps_and_plans_are_made_with_a_hand_of_ones_own() {
    let hand = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/hands").join(name);
        path.to_string_lossy().into_owned()
    };
    let args = ["grasps", "tomato_soup_can", "--robot", "alita", "--arm", "right", "--json"];
    let own = json(&args);
    let told = |name: &str| json(&[&args[..], &["--hand", &hand(name)]].concat());
    let without_times = |rows: &[Value]| {
        let strip = |row: &Value| {
            let mut row = row.clone();
            row.as_object_mut().unwrap().remove("elapsed_ms");
            row
        };
        rows.iter().map(strip).collect::<Vec<_>>()
    };
    assert_eq!(without_times(&told("pg70.json")), without_times(&own), "the built-in hand, described");
    let adaptive = told("adaptive.json");
    assert!(adaptive.iter().filter(|row| row["status"] == "accepted").count() >= 10, "{adaptive:?}");
    assert_ne!(without_times(&adaptive), without_times(&own));

    // The same hand with its URDF in a file beside it, and one that is wrong.
    let mut description: Value =
        serde_json::from_str(&std::fs::read_to_string(hand("adaptive.json")).unwrap()).unwrap();
    let lines: Vec<String> = serde_json::from_value(description["urdf"].clone()).unwrap();
    let (file, urdf) = (scratch("hand.json"), scratch("hand.urdf"));
    std::fs::write(&urdf, lines.join("\n")).unwrap();
    description["urdf"] = urdf.file_name().unwrap().to_string_lossy().into_owned().into();
    std::fs::write(&file, description.to_string()).unwrap();
    let path = file.to_string_lossy().into_owned();
    let plan = json(&["plan", "pick", "mustard", "--hand", &path, "--json"]);
    assert!(!plan.is_empty());
    description["palm_link"] = "hand".into();
    std::fs::write(&file, description.to_string()).unwrap();
    let output = endcomfort(&["grasps", "mustard", "--hand", &path]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("hand.json: palm_link: the URDF has no link \"hand\"; it has adapter, palm"), "{said}");
}

#[test]
fn grasp_options_reach_the_settings_and_the_rows_tell_every_quantity() {
    let rows = json(&[
        "grasps",
        "coffee_jar",
        "--robot",
        "crichton",
        "--arm",
        "left",
        "--density",
        "8",
        "--approach",
        "0,0,-1",
        "--approach-cone",
        "25",
        "--weights",
        "m_g_start=1,epsilon=1",
        "--arm-angles",
        "12",
        "--json",
    ]);
    has_keys(&rows[0], &["id", "part", "m_g_mean", "score", "gws_volume", "success_probability", "clearance_m"]);
    let scores: Vec<f64> = rows.iter().filter(|r| r["rank"].is_u64()).map(|r| r["score"].as_f64().unwrap()).collect();
    assert!(!scores.is_empty() && scores.windows(2).all(|pair| pair[0] >= pair[1]), "{scores:?}");
    for row in rows.iter().filter(|row| row["rank"].is_u64()) {
        // z of the hand in O; the object's own z may point down, so the angle is taken with the vertical alone.
        let z = row["object_from_hand"][10].as_f64().unwrap();
        assert!(z.abs() > 25_f64.to_radians().cos() - 0.05, "{row}");
    }
}

#[test]
fn ranked_grasps_are_written_in_three_formats() {
    for (name, begins) in [("grasps.json", "[\n{"), ("grasps.csv", "rank,id,part,"), ("grasps.yaml", "# moveit_msgs")] {
        let file = scratch(name);
        let path = file.to_string_lossy().into_owned();
        let output = endcomfort(&["grasps", "coffee_jar", "--density", "6", "--out", &path]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.starts_with(begins), "{name}: {}", &text[..80.min(text.len())]);
    }
    let written: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(scratch("grasps.json")).unwrap()).unwrap();
    assert!(written.len() > 3 && written[0]["rank"] == 1);
}

#[test]
fn a_grasp_option_out_of_its_range_is_refused_with_place_found_and_wanted() {
    for (args, said) in [
        (["--density", "0"], "grasp.density: found 0.0, wanted from 1 to 80"),
        (["--friction", "9"], "grasp.friction: found 9.0, wanted from 0.01 to 5"),
        (["--approach", "0,0,0"], "grasp.filter.approach.axis_W: found 0.0, wanted a direction"),
        (["--weights", "comfort=1"], "--weights: found \"comfort=1\", wanted one of m_g_goal"),
        (["--out", "grasps.txt"], "wanted a name that ends in .json, .csv or .yaml"),
    ] {
        let output = endcomfort(&["grasps", "coffee_jar", args[0], args[1]]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(1) && error.contains(said), "{args:?}: {error}");
    }
    assert_eq!(endcomfort(&["grasps", "coffee_jar", "--rank-by", "luck"]).status.code(), Some(2));
}

#[test]
fn reach_builds_a_map_and_reads_it_again() {
    let out = scratch("alita.reach");
    let built = json(&["reach", "alita", "--voxel", "0.2", "--out", &out.to_string_lossy(), "--json"]);
    assert_eq!(built.len(), 2);
    for (row, arm) in built.iter().zip(["left", "right"]) {
        has_keys(row, &["robot", "base_link", "joints", "method", "mean_manipulability", "bytes", "build_ms"]);
        assert_eq!((row["arm"].as_str(), row["orientations"].as_u64()), (Some(arm), Some(40)));
        let file = scratch(&format!("alita_{arm}.reach")).to_string_lossy().into_owned();
        let read = &json(&["reach", &file, "--json"])[0];
        for key in ["arm", "voxels", "poses", "mean_fraction", "max_manipulability", "bytes"] {
            assert_eq!(read[key], row[key], "{key}");
        }
        has_keys(read, &["load_ms"]);
        let mut bytes = std::fs::read(&file).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        std::fs::write(&file, bytes).unwrap();
        let refused = endcomfort(&["reach", &file]);
        assert_eq!(refused.status.code(), Some(1));
        let words = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(words.contains("found") && words.contains("wanted"), "{words}");
    }
}

#[test]
fn reach_draws_samples_and_turns_the_torso() {
    let args = ["reach", "crichton", "--arm", "left", "--voxel", "0.25", "--json"];
    let with = |more: &[&str]| json(&[&args[..], more].concat()).swap_remove(0);
    let forward = with(&["--method", "forward", "--samples", "20000", "--orientations", "1", "--seed", "3"]);
    assert_eq!(forward["method"], "forward, 20000 samples, seed 3");
    assert_eq!(forward["voxels"], forward["poses"]);
    let torso = with(&["--torso"]);
    assert_eq!((torso["joints"].as_u64(), torso["method"].as_str()), (Some(8), Some("inverse, torso at 7 positions")));
    assert!(torso["voxels"].as_u64() > with(&[])["voxels"].as_u64());
    for wrong in [&["--orientations", "41"][..], &["--samples", "0"], &["--method", "inverse", "--orientations", "1"]] {
        assert_eq!(endcomfort(&[&args[..], wrong].concat()).status.code(), Some(1), "{wrong:?}");
    }
    assert_eq!(endcomfort(&["reach", "nobody"]).status.code(), Some(1));
}
