//! What another program reads back is what was written.

use nalgebra::{Isometry3, Point3, Vector3};
use serde_json::Value;
use yaml_rust2::{Yaml, YamlLoader};

use super::{ExportFormat, GraspExport, StraightWays};
use crate::grasp::{Contact, Grasp, GraspStatus, Quantity, Situated, Success};
use crate::robot::samples::crichton;

fn grasps(fingers: usize) -> Vec<Grasp> {
    let contact =
        Contact { p_O: Point3::new(0.03, 0.0, 0.01), n_O: Vector3::x(), penetration_m: 0.001, link: "thumb".into() };
    let set = Situated {
        m_g: 0.08,
        ik_count: 2,
        solutions: vec![vec![0.1; 7], vec![0.2; 7]],
        manipulability: vec![0.07, 0.09],
        ..Situated::default()
    };
    let accepted = Grasp {
        id: 17,
        part: 0,
        X_OH: Isometry3::new(Vector3::new(0.0, 0.02, 0.1), Vector3::new(0.3, 2.0, 0.4)),
        closed: vec![0.5; fingers],
        contacts: vec![contact],
        width_m: 0.06,
        epsilon: 0.2,
        volume: Some(0.01),
        success: Some(Success { held: 18, trials: 20 }),
        clearance_m: Some(0.012),
        score: None,
        start: Some(set.clone()),
        via: Vec::new(),
        goal: Some(Situated { m_g: 1e-7, ..set }),
        status: GraspStatus::Accepted,
    };
    let link = "finger, \"left\"".to_owned();
    let rejected = Grasp {
        id: 3,
        success: None,
        clearance_m: None,
        start: None,
        goal: None,
        status: GraspStatus::HitsTable { link },
        ..accepted.clone()
    };
    vec![accepted, rejected]
}

/// The grasps above, told for the left arm of Crichton.
fn told(object: &str, format: ExportFormat) -> String {
    let robot = crichton();
    let arm = robot.arm("left").unwrap();
    let grasps = grasps(arm.hand.open.len());
    let export = GraspExport {
        grasps: &grasps,
        robot: &robot,
        arm,
        object,
        X_WO_start: Isometry3::translation(0.5, 0.2, 0.8),
        X_WO_goal: Some(Isometry3::translation(0.4, 0.3, 0.8)),
        ranked_by: Some(Quantity::MgGoal),
        ways: StraightWays { approach_m: 0.09, min_approach_m: 0.03, lift_m: 0.06 },
    };
    export.text(format)
}

#[test]
fn json_holds_every_quantity_of_every_grasp() {
    let rows: Vec<Value> = serde_json::from_str(&told("jar", ExportFormat::Json)).unwrap();
    assert_eq!(rows.len(), 2);
    for quantity in Quantity::ALL {
        assert!(rows[0].get(quantity.name()).is_some(), "{}", quantity.name());
    }
    assert_eq!((&rows[0]["rank"], &rows[1]["rank"]), (&Value::from(1), &Value::Null));
    assert_eq!(rows[0]["success_probability"], 0.9);
    assert_eq!(rows[1]["success_probability"], Value::Null);
    assert_eq!(rows[0]["start"]["best_q"][0], 0.2);
    assert_eq!(rows[0]["contact_list"][0]["link"], "thumb");
    assert!((rows[0]["world_from_hand_start"]["position_m"][0].as_f64().unwrap() - 0.5).abs() < 1e-12);
    assert_eq!(rows[1]["status"], "hits_table");
}

/// A strict reader of RFC 4180, made for this test.
fn csv_cells(line: &str) -> Vec<String> {
    let (mut cells, mut cell, mut quoted) = (Vec::new(), String::new(), false);
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        match (letter, quoted) {
            ('"', true) if letters.peek() == Some(&'"') => {
                cell.push('"');
                let _second = letters.next();
            }
            ('"', _) => quoted = !quoted,
            (',', false) => cells.push(std::mem::take(&mut cell)),
            (other, _) => cell.push(other),
        }
    }
    cells.push(cell);
    cells
}

#[test]
fn csv_has_a_cell_under_every_head_and_keeps_commas_and_quotes() {
    let text = told("jar", ExportFormat::Csv);
    let rows: Vec<Vec<String>> = text.lines().map(csv_cells).collect();
    assert_eq!(rows.len(), 3);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{text}");
    let column = |name: &str| rows[0].iter().position(|head| head == name).unwrap_or_else(|| panic!("{name}"));
    assert_eq!(rows[2][column("reason")], "finger, \"left\" hits the table");
    assert_eq!(rows[1][column("m_g_start")], "0.08");
    assert_eq!(rows[2][column("m_g_start")], "");
    assert_eq!(rows[1][column("m_g_goal")].parse::<f64>(), Ok(1e-7));
    assert_eq!(rows[1][column("world_from_hand_goal_x_m")].parse::<f64>(), Ok(0.4));
}

fn real(value: &Yaml) -> f64 {
    assert!(matches!(value, Yaml::Real(_)), "{value:?} is no floating-point number");
    value.as_f64().unwrap()
}

#[test]
fn yaml_reads_back_as_moveit_messages_of_the_accepted_grasps() {
    let robot = crichton();
    let arm = robot.arm("left").unwrap();
    let messages = &YamlLoader::load_from_str(&told("jar: \"big\" #1\n", ExportFormat::Yaml)).unwrap()[0];
    let messages = messages.as_vec().unwrap();
    assert_eq!(messages.len(), 1, "the rejected one is left out");
    let message = &messages[0];
    let names: Vec<&str> = message.as_hash().unwrap().keys().map(|key| key.as_str().unwrap()).collect();
    assert_eq!(
        names,
        [
            "id",
            "pre_grasp_posture",
            "grasp_posture",
            "grasp_pose",
            "grasp_quality",
            "pre_grasp_approach",
            "post_grasp_retreat",
            "post_place_retreat",
            "max_contact_force",
            "allowed_touch_objects"
        ],
        "the fields of moveit_msgs/Grasp in their order"
    );
    assert_eq!(message["id"].as_str(), Some("jar: \"big\" #1\n 17"));
    assert_eq!(message["allowed_touch_objects"][0].as_str(), Some("jar: \"big\" #1\n"));
    assert_eq!(message["grasp_pose"]["header"]["frame_id"].as_str(), Some(robot.links[0].name.as_str()));
    for (posture, position) in [("pre_grasp_posture", arm.hand.open[0]), ("grasp_posture", 0.5)] {
        let point = &message[posture]["points"][0];
        assert_eq!(message[posture]["joint_names"].as_vec().unwrap().len(), arm.hand.open.len());
        assert_eq!(point["positions"].as_vec().unwrap().len(), arm.hand.open.len());
        assert!((real(&point["positions"][0]) - position).abs() < 1e-9);
        assert_eq!(point["time_from_start"]["nanosec"].as_i64(), Some(0));
    }
    assert!((real(&message["grasp_quality"]) - 1e-7).abs() < 1e-12);
    let approach = &message["pre_grasp_approach"];
    let hand = &robot.links[arm.hand.tcp_link].name;
    assert_eq!(approach["direction"]["header"]["frame_id"].as_str(), Some(hand.as_str()));
    assert!((real(&approach["direction"]["vector"]["z"]) - 1.0).abs() < 1e-12);
    assert!(real(&approach["min_distance"]) <= real(&approach["desired_distance"]));

    // The flange is where forward kinematics puts it when the hand is at the grasp.
    let X_WL = robot.link_poses(&vec![0.3; robot.dof_count()]);
    let X_HE = X_WL[arm.hand.tcp_link].inv_mul(&X_WL[arm.flange_link]);
    let X_WE = Isometry3::translation(0.5, 0.2, 0.8) * grasps(1)[0].X_OH * X_HE;
    let position = &message["grasp_pose"]["pose"]["position"];
    for (name, wanted) in [("x", X_WE.translation.x), ("y", X_WE.translation.y), ("z", X_WE.translation.z)] {
        assert!((real(&position[name]) - wanted).abs() < 1e-8, "{name}: {position:?} against {wanted}");
    }
}

#[test]
fn a_file_name_tells_the_format() {
    assert_eq!(ExportFormat::of_file("a.b/grasps.YML"), Some(ExportFormat::Yaml));
    assert_eq!(ExportFormat::of_file("grasps.csv"), Some(ExportFormat::Csv));
    assert_eq!(ExportFormat::of_file("grasps"), None);
}
