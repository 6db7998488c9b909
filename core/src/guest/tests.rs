//! Guests as a whole: from files to a robot that grasps.

use std::sync::Arc;

use nalgebra::Vector3;

use super::*;
use crate::job::{Output, Request, Update};
use crate::library::Library;
use crate::loaded::Loaded;
use crate::pipeline::Pipeline;
use crate::robot::ik::{ArmIk, IkMethod};
use crate::robot::{Geometry, Placement, read_urdf};
use crate::scene::{ArmChoice, Scene};
use crate::watch::Watch;

const SIX_ARM: &str = include_str!("../../../robots/examples/six_arm.urdf");

fn library() -> Arc<Library> {
    let read = |path: &str| {
        let file = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path);
        let bytes: &'static [u8] = std::fs::read(file).ok()?.leak();
        Some(bytes)
    };
    Arc::new(Library::new(Box::new(read)))
}

fn scene() -> Scene {
    Scene::parse(include_str!("../../../objects/scenes/mustard.json")).unwrap()
}

fn files(files: &[(&str, &str)]) -> Files {
    Files::new(files.iter().map(|(path, text)| ((*path).to_owned(), text.as_bytes().to_vec()))).unwrap()
}

fn proposed(files: &Files, wishes: &Wishes) -> Result<Proposal, GuestError> {
    let library = library();
    let hand = library.hand("pg70").unwrap();
    propose(files, wishes, &scene().table, &hand, &|uri: &str| library.mesh(uri))
}

fn built(proposal: &Proposal) -> BuiltGuest {
    let library = library();
    proposal.guest.build(&|uri: &str| library.mesh(uri)).unwrap()
}

#[test]
fn an_arm_without_a_hand_gets_one_stands_at_the_table_and_starts_over_it() {
    let proposal = proposed(&files(&[("six_arm.urdf", SIX_ARM)]), &Wishes::default()).unwrap();
    assert_eq!(proposal.problem, None);
    let [arm] = proposal.guest.description.arms.as_slice() else { panic!("{:?}", proposal.guest.description) };
    assert_eq!((arm.name.as_str(), arm.base_link.as_str(), arm.tip_link.as_str()), ("left", "base_link", "tool0"));
    assert!(arm.hand.is_some());
    let BuiltGuest { robot, notes, missing } = built(&proposal);
    assert!(notes.is_empty() && missing.is_empty(), "{notes:?}");
    let arm = robot.arm("left").unwrap();
    assert_eq!((arm.dofs.len(), arm.hand.fingers.len()), (6, 1));
    let ik = ArmIk::of(&robot, arm).unwrap();
    assert!(matches!(ik.method(), IkMethod::Numeric { .. }), "{}", ik.method());
    // The hand hangs 8 + 16.4 cm before the last joint, its approach along the tool's z.
    let q = robot.posture(READY).unwrap();
    let X_WL = robot.link_poses(q);
    let X_WH = X_WL[arm.hand.tcp_link];
    let tool = X_WL[robot.link_index("tool0").unwrap()];
    assert!(
        (tool.inverse_transform_point(&X_WH.translation.vector.into()).coords - Vector3::z() * 0.164).norm() < 1e-9
    );
    // Its base is as high as the table and behind it, on a column; the hand is above the table.
    let table = scene().table;
    let base = X_WL[robot.link_index("base_link").unwrap()].translation.vector;
    assert!((base.z - table.height_m).abs() < 1e-9 && base.x + 0.075 < 0.25, "{base}");
    assert!(X_WH.translation.z > table.height_m + 0.2 && X_WH.translation.x > 0.15, "{X_WH}");
    assert!((X_WH.rotation * Vector3::z()).z < -0.99, "the hand looks down");
    let stand = &robot.links[robot.link_index("stand").unwrap()];
    assert!(matches!(stand.collisions[0].geometry, Geometry::Box { size_m } if (size_m.z - 0.69).abs() < 1e-9));
}

#[test]
fn a_robot_of_the_program_comes_back_as_a_guest_with_and_without_its_srdf() {
    let urdf = include_str!("../../../robots/alita/alita.urdf");
    let srdf = include_str!("../../../robots/alita/alita.srdf");
    let with = proposed(&files(&[("a/alita.urdf", urdf), ("a/alita.srdf", srdf)]), &Wishes::default()).unwrap();
    assert!(with.guest.description.arms.is_empty(), "its own SRDF says it all");
    let robot = built(&with).robot;
    let alita = library().robot("alita").unwrap();
    assert_eq!(robot.arms.len(), 2);
    assert!(robot.posture("table_ready").is_some() && robot.posture(READY).is_some());
    // It stands on the floor, as the program has it.
    assert!(robot.links[0].collisions.is_empty());
    assert!(with.guest.description.stand.unwrap().xyz[2].abs() < 1e-3);

    // Without it: names that the program gives are taken, so they are called otherwise.
    let renamed = urdf.replace("_tcp", "_grip_frame");
    let without = proposed(&files(&[("alita.urdf", &renamed)]), &Wishes::default()).unwrap();
    let robot = built(&without).robot;
    for (arm, known) in robot.arms.iter().zip(&alita.arms) {
        assert_eq!((&arm.name, arm.dofs.len()), (&known.name, 7));
        assert_eq!((arm.hand.fingers.len(), &arm.hand.open), (1, &known.hand.open), "its own fingers close");
        assert!(ArmIk::of(&robot, arm).unwrap().closed_form().is_some(), "and its arms are still S-R-S");
    }
    let error = proposed(&files(&[("alita.urdf", urdf)]), &Wishes::default()).unwrap_err();
    assert!(matches!(&error, GuestError::NameTaken { name, .. } if name == "left_tcp"), "{error}");
}

#[test]
fn what_a_person_points_out_is_taken_and_what_is_wrong_with_it_is_said() {
    let all = files(&[("six_arm.urdf", SIX_ARM)]);
    let tcp = Placement { xyz: [0.0, 0.08, 0.0], rpy: [-std::f64::consts::FRAC_PI_2, 0.0, 0.0] };
    let wish = |base: &str, tip: &str| ArmWish { base_link: Some(base.into()), tip_link: tip.into(), tcp: Some(tcp) };
    let wishes = |wish| Wishes { arms: vec![wish], stand: None };
    let chosen = proposed(&all, &wishes(wish("base_link", "wrist_3_link"))).unwrap();
    let found = proposed(&all, &Wishes::default()).unwrap();
    let hand_at = |proposal: &Proposal| {
        let robot = built(proposal).robot;
        robot.link_poses(&vec![0.1; robot.dof_count()])[robot.arms[0].hand.tcp_link]
    };
    // The frame that was pointed out is the one of the tool.
    assert!((hand_at(&chosen).to_homogeneous() - hand_at(&found).to_homogeneous()).amax() < 2e-3);
    for (base, tip, wanted) in [
        ("base", "tool0", "arm 1: the robot has no link \"base\"; it has base_link, "),
        ("tool0", "base_link", "arm 1: link \"base_link\" does not descend from \"tool0\""),
        (
            "base_link",
            "fore_link",
            "arm 1: found 3 moving joints from \"base_link\" to \"fore_link\", wanted at least 5",
        ),
    ] {
        let error = proposed(&all, &wishes(wish(base, tip))).unwrap_err().to_string();
        assert!(error.starts_with(wanted), "{error}");
    }
}

#[test]
fn a_robot_without_an_arm_is_an_answer_with_its_problem() {
    let urdf = "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='continuous'>\
        <parent link='a'/><child link='b'/></joint></robot>";
    let proposal = proposed(&files(&[("turntable.urdf", urdf)]), &Wishes::default()).unwrap();
    assert!(proposal.problem.unwrap().starts_with("turntable.urdf names no arm"));
    assert!(proposal.notes.iter().any(|note| note.contains("1 joints, fewer than the 5")), "{:?}", proposal.notes);
}

#[test]
fn missing_meshes_are_listed_and_marked_boxes_stand_for_them() {
    let mesh = "<visual><geometry><mesh filename=\"package://six/meshes/upper.dae\"/></geometry></visual>\
        <collision><geometry><mesh filename=\"package://six/meshes/upper.stl\"/></geometry></collision>";
    let urdf = SIX_ARM.replacen("<link name=\"upper_link\">", &format!("<link name=\"upper_link\">{mesh}"), 1);
    let dae = ("six/meshes/upper.dae", "<COLLADA/>");
    let proposal = proposed(&files(&[("six/six_arm.urdf", &urdf), dae]), &Wishes::default()).unwrap();
    let BuiltGuest { robot, notes, missing } = built(&proposal);
    let files: Vec<(&str, bool)> = missing.iter().map(|m| (m.file.as_str(), m.is_visual)).collect();
    assert_eq!(files, [("package://six/meshes/upper.dae", true), ("package://six/meshes/upper.stl", false)]);
    assert!(notes[0].contains("is drawn as a marked box: meshes ending in .dae are not read"), "{notes:?}");
    assert!(notes[1].contains("is drawn as a marked box: it was not found"), "{notes:?}");
    let link = &robot.links[robot.link_index("upper_link").unwrap()];
    let marked = link.visuals.iter().find(|visual| visual.material.name == "missing").unwrap();
    // 40 cm to the elbow, 11 cm to its side, and 3 cm around.
    let Geometry::Box { size_m } = marked.geometry else { panic!("{:?}", marked.geometry) };
    assert!((size_m - Vector3::new(0.06, 0.17, 0.46)).norm() < 1e-9, "{size_m}");
    assert_eq!(link.collisions.len(), 3);
}

#[test]
fn a_moveit_srdf_says_which_chain_is_the_arm_and_how_it_rests() {
    let srdf = r#"<robot name="six_arm">
        <group name="manipulator"><chain base_link="base_link" tip_link="tool0"/></group>
        <group_state name="home" group="manipulator"><joint name="elbow" value="1.2"/></group_state>
        <disable_collisions link1="base_link" link2="upper_link" reason="Never"/></robot>"#;
    let all = files(&[("six_arm.urdf", SIX_ARM), ("config/six_arm.srdf", srdf)]);
    let proposal = proposed(&all, &Wishes::default()).unwrap();
    assert!(proposal.notes.contains(&"arms as the SRDF has them".to_owned()), "{:?}", proposal.notes);
    let robot = built(&proposal).robot;
    let elbow = robot.joints.iter().find(|joint| joint.name == "elbow").unwrap().dof.unwrap();
    assert_eq!(robot.posture("home").unwrap()[elbow], 1.2);
    let pair = ["base_link", "upper_link"].map(|name| robot.link_index(name).unwrap());
    assert!(robot.allowed_collisions.contains(&(pair[0], pair[1])));
}

#[test]
fn a_description_is_remembered_and_stands_for_what_was_found() {
    let first = proposed(&files(&[("six_arm.urdf", SIX_ARM)]), &Wishes::default()).unwrap();
    let json = serde_json::to_string_pretty(&first.guest.description).unwrap();
    let again = proposed(&files(&[("six_arm.urdf", SIX_ARM), ("six_arm.robot.json", &json)]), &Wishes::default());
    assert_eq!(again.unwrap().guest, first.guest);
    assert_eq!(first.guest.title(), "six_arm");
    let name = first.guest.name();
    assert_eq!(GuestRobot::title_of(&name), "six_arm");
    let mut other = first.guest.clone();
    other.description.posture.insert("elbow".into(), 0.0);
    assert_ne!(other.name(), name, "another choice is another robot");
    // As text and as bytes it comes back the same.
    let json = serde_json::to_string(&first.guest).unwrap();
    assert_eq!(serde_json::from_str::<GuestRobot>(&json).unwrap(), first.guest);
}

#[test]
fn a_guest_grasps_and_plans_on_the_cloud_of_a_demo() {
    let proposal = proposed(&files(&[("six_arm.urdf", SIX_ARM)]), &Wishes::default()).unwrap();
    let guest = Arc::new(proposal.guest);
    let (library, mut scene) = (library(), scene());
    scene.robot = guest.name();
    (scene.arm, scene.posture) = (ArmChoice::Left, READY.to_owned());
    // Away from the program's memory nobody knows the robot; its files travel with the request.
    let away = library.robot_of(&scene).unwrap_err().to_string();
    assert!(away.contains("\"six_arm\"") && away.contains("bring its URDF"), "{away}");
    let request = Request { robot: Some(guest), ..Request::new(scene) };
    let (mut plan, mut refused) = (None, None);
    Pipeline::new(library).run(&request, &Watch::idle(), &mut |update| match update {
        Update::Done { output, .. } => {
            if let Output::Plan(found) = *output {
                plan = Some(found);
            }
        }
        Update::Refused { refusal, stage, .. } => refused = Some((stage, refusal)),
        _ => {}
    });
    assert!(refused.is_none(), "{refused:?}");
    let plan = plan.unwrap();
    assert!(plan.duration_s() > 1.0 && plan.grasp().is_accepted());
}

#[test]
fn no_robot_text_makes_it_panic() {
    let mut rng = crate::rng::Rng::new(8, 0);
    let Loaded { value: known, .. } = read_urdf(SIX_ARM, &|_| None).unwrap();
    assert_eq!(known.dof_count(), 6);
    for _ in 0..300 {
        let mut bytes = SIX_ARM.as_bytes().to_vec();
        for _ in 0..3 {
            let at = (rng.unit() * bytes.len() as f64) as usize;
            let other = (rng.unit() * bytes.len() as f64) as usize;
            bytes[at] = bytes[other];
        }
        let text = String::from_utf8_lossy(&bytes).into_owned();
        // Only what is found out without looking for a posture, which takes time.
        let Ok(Loaded { value: robot, .. }) = read_urdf(&text, &|_| None) else { continue };
        let (arms, _) = find_arms(&robot);
        assert!(arms.len() <= 2);
    }
}
