//! What people bring on the command line: robots, meshes, depth images.

use serde_json::Value;

use super::{endcomfort, json, lines, scratch};

/// The example arm, which has no hand and whose joints are solved step by step.
fn six_arm() -> String {
    concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/examples/six_arm.urdf").to_owned()
}

#[test]
fn a_robot_of_ones_own_is_checked_grasps_plans_and_is_mapped() {
    let report = json(&["check", &six_arm(), "--json"]).swap_remove(0);
    let acting = &report["acting"];
    assert!(acting["problem"].is_null(), "{report}");
    assert_eq!(acting["arms"][0]["tip_link"], "tool0");
    assert_eq!(report["arms"].as_array().unwrap().len(), 0, "the URDF alone names none");

    let grasps = json(&["grasps", "coffee_jar", "--robot", &six_arm(), "--accepted", "--json"]);
    assert!(grasps.len() > 5 && grasps.iter().all(|grasp| grasp["status"] == "accepted"), "{}", grasps.len());
    let plan = json(&["plan", "place", "mustard", "--robot", &six_arm(), "--json"]);
    assert!(plan.len() >= 6, "{} phases", plan.len());
    assert_eq!(plan, json(&["plan", "place", "mustard", "--robot", &six_arm(), "--json"]), "the same once more");

    let args = ["reach", &six_arm(), "--samples", "20000", "--voxel", "0.2", "--json"];
    let map = json(&args).swap_remove(0);
    assert!(map["robot"].as_str().unwrap().starts_with("six_arm@") && map["voxels"].as_u64() > Some(50), "{map}");
}

#[test]
fn what_is_chosen_for_a_robot_is_remembered_beside_it() {
    let folder = scratch("own robot");
    std::fs::create_dir_all(&folder).unwrap();
    let urdf = folder.join("arm.urdf");
    std::fs::copy(six_arm(), &urdf).unwrap();
    let urdf = urdf.to_string_lossy().into_owned();
    let choice = folder.join("arm.robot.json");
    let _absent = std::fs::remove_file(&choice);
    let tcp = "0,0.08,0,-90,0,0";
    let chosen = ["--arm-base", "base_link", "--arm-tip", "wrist_3_link", "--tcp", tcp, "--stand", "-0.3,0,0.69,0"];
    let asked = [&["plan", "pick", "mustard", "--robot", &urdf, "--remember", "--json"][..], &chosen].concat();
    let first = json(&asked);
    let kept: Value = serde_json::from_str(&std::fs::read_to_string(&choice).unwrap()).unwrap();
    assert_eq!((&kept["endcomfort_robot"], &kept["arms"][0]["tip_link"]), (&1.into(), &"wrist_3_link".into()));
    assert_eq!(json(&["plan", "pick", "mustard", "--robot", &urdf, "--json"]), first);
    let file = choice.to_string_lossy().into_owned();
    assert_eq!(json(&["plan", "pick", "mustard", "--robot", &file, "--json"]), first);
}

#[test]
fn what_a_robot_lacks_is_said_with_what_to_do() {
    let folder = scratch("no robot");
    std::fs::create_dir_all(&folder).unwrap();
    let turntable = folder.join("turntable.urdf");
    let text = "<robot name='t'><link name='a'/><link name='b'/><joint name='j' type='continuous'>\
        <parent link='a'/><child link='b'/></joint></robot>";
    std::fs::write(&turntable, text).unwrap();
    let refused = |args: &[&str]| {
        let output = endcomfort(args);
        assert_eq!(output.status.code(), Some(1), "{args:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let turntable = turntable.to_string_lossy().into_owned();
    let said = refused(&["plan", "pick", "mustard", "--robot", &turntable]);
    assert!(said.contains("names no arm") && said.contains("--arm-base LINK --arm-tip LINK"), "{said}");
    let said = refused(&["plan", "pick", "mustard", "--robot", &six_arm(), "--arm-tip", "hand"]);
    assert!(said.contains("the robot has no link \"hand\"; it has base_link"), "{said}");
    let said = refused(&["plan", "pick", "mustard", "--robot", "somebody"]);
    assert!(said.contains("no robot \"somebody\"") && said.contains(".urdf"), "{said}");
    let said = refused(&["plan", "pick", "mustard", "--arm-tip", "tool0"]);
    assert!(said.contains("give it with --robot FILE.urdf"), "{said}");
}

/// A closed box as ascii STL, in millimetres.
fn box_stl(x: f64, y: f64, z: f64) -> String {
    let corner = |k: usize| {
        let side = |bit: usize, size: f64| if k >> bit & 1 == 1 { size } else { 0.0 };
        format!("vertex {} {} {}\n", side(0, x), side(1, y), side(2, z))
    };
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid box\n");
    for [a, b, c, d] in sides {
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            triangle.iter().for_each(|&k| text += &corner(k));
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid box\n"
}

#[test]
fn a_mesh_is_grasped_and_moved_and_its_unit_is_guessed_with_a_reason() {
    let file = scratch("bracket.stl");
    std::fs::write(&file, box_stl(60.0, 40.0, 120.0)).unwrap();
    let file = file.to_string_lossy().into_owned();
    let report = json(&["check", &file, "--json"]).swap_remove(0);
    assert_eq!((report["kind"].as_str(), report["triangles"].as_u64()), (Some("mesh"), Some(12)));
    let output = endcomfort(&["plan", "place", &file, "--json"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(said.contains("would be 120.0000 m, so it is taken to be in millimetres"), "{said}");
    assert!(lines(&output).len() >= 6);
    assert!(json(&["grasps", &file, "--accepted", "--json"]).len() > 3);
    let output = endcomfort(&["plan", "place", &file, "--unit", "m"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && said.contains("wanted edges of 5 mm to 2 m"), "{said}");
}

#[test]
fn a_depth_image_needs_its_camera() {
    let (depth, camera) = (scratch("depth.png"), scratch("camera.json"));
    // A table 1 m below a camera that looks straight down, and a box of 20 cm on it.
    let is_box = |u: u32, v: u32| (130..190).contains(&u) && (100..140).contains(&v);
    let image = image::ImageBuffer::<image::Luma<u16>, _>::from_fn(320, 240, |u, v| {
        image::Luma([if is_box(u, v) { 800 } else { 1000 }])
    });
    image.save(&depth).unwrap();
    std::fs::write(&camera, r#"{"K": [262, 0, 159.5, 0, 262, 119.5, 0, 0, 1], "width": 320, "height": 240}"#).unwrap();
    let (depth, camera) = (depth.to_string_lossy().into_owned(), camera.to_string_lossy().into_owned());
    let output = endcomfort(&["segment", &depth]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && said.contains("--intrinsics FILE.json, or --fov DEGREES"), "{said}");
    let found = json(&["segment", &depth, "--intrinsics", &camera, "--json"]).swap_remove(0);
    assert_eq!((found["points"].as_u64(), found["clusters"].as_array().unwrap().len()), (Some(320 * 240), 1));
    let cluster = &found["clusters"][0];
    let width = cluster["max_m"][0].as_f64().unwrap() - cluster["min_m"][0].as_f64().unwrap();
    // 59 pixels between the outer ones, at 0.8 m and f = 262 px.
    assert!((width - 59.0 * 0.8 / 262.0).abs() < 0.004, "{width}");
    // 62.8° wide is the same camera, nearly.
    assert_eq!(json(&["segment", &depth, "--fov", "62.8", "--json"])[0]["clusters"].as_array().unwrap().len(), 1);
    assert_eq!(json(&["check", &camera, "--json"])[0]["kind"], "intrinsics");
    assert_eq!(json(&["check", &depth, "--json"])[0]["measured"], 320 * 240);
}
