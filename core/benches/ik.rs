//! Closed-form IK on the shared workload: 1 000 poses of an S-R-S arm.
//!
//! `cargo bench -p endcomfort-core --bench ik [-- FOLDER]`, FOLDER holding `srs7.urdf` and `ik_work.json`. An answer
//! counts when forward kinematics puts the hand within 0.1 mm and 1 mrad and every joint is within its limits; it is
//! checked outside the timed part, and a wrong one fails the bench. Each pose is timed over several sweeps of 36 arm
//! angles, and once more at one single arm angle. Hubo's arm of six joints is asked for all branches of the poses of 1 000
//! postures drawn with seed 5; those answers are checked to 1e-12.
#![allow(non_snake_case, reason = "frame letters")]

#[path = "common/report.rs"]
mod report;
#[path = "common/workload.rs"]
mod workload;

use std::error::Error;

use endcomfort_core::rng::Rng;
use endcomfort_core::robot::ik::{ArmIk, IkSet, IkSolution, SrsArm};
use endcomfort_core::robot::{load_robot, read_urdf};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};
use report::{Report, now_ms};

const ANGLES: usize = 36;
const REPEATS: usize = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = workload::folder("arm", "ik_work.json") else { return Ok(()) };
    let robot = read_urdf(&std::fs::read_to_string(folder.join("srs7.urdf"))?, &|_| None)?.value;
    let link = |name: &str| robot.link_index(name).ok_or_else(|| format!("no link {name:?}"));
    let (base, tip) = (link("base")?, link("tcp")?);
    let arm = SrsArm::between(&robot, base, tip)?;
    let work: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(folder.join("ik_work.json"))?)?;
    let poses: Vec<Vec<f64>> = serde_json::from_value(work["pose_p_then_R_rowmajor"].clone())?;

    let (mut sweep_us, mut single_us, mut arcs_us) = (Vec::new(), Vec::new(), Vec::new());
    let (mut reached, mut wrong, mut found, mut worst, mut outside) = (0, 0, 0, 0.0_f64, 0);
    let mut set = IkSet::default();
    for pose in &poses {
        let [x, y, z, rotation @ ..] = pose.as_slice() else { return Err("a pose is too short".into()) };
        let matrix = Matrix3::from_row_slice(rotation);
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
        // A matrix of few digits gives a quaternion that is as little off length 1.
        let rotation = UnitQuaternion::from_quaternion(rotation.into_inner());
        let X_BH = Isometry3::from_parts(Translation3::new(*x, *y, *z), rotation);
        let mut timed = |angles: usize, times_us: &mut Vec<f64>| {
            let begin_ms = now_ms();
            for _ in 0..REPEATS {
                set.clear();
                arm.sweep_into(std::hint::black_box(&X_BH), angles, &mut set);
            }
            times_us.push((now_ms() - begin_ms) * 1e3 / REPEATS as f64);
        };
        timed(1, &mut single_us);
        timed(ANGLES, &mut sweep_us);
        let begin_ms = now_ms();
        let mut arcs = Vec::new();
        for _ in 0..REPEATS {
            arcs = arm.feasible_arcs(std::hint::black_box(&X_BH));
        }
        arcs_us.push((now_ms() - begin_ms) * 1e3 / REPEATS as f64);
        let in_an_arc = |s: &&IkSolution| arcs.iter().any(|a| a.branch == s.branch && a.contains(s.arm_angle));
        outside += set.solutions.len() - set.solutions.iter().filter(in_an_arc).count();
        let right = set.solutions.iter().filter(|solution| {
            let X_WL = robot.link_poses(&solution.q);
            let error = (X_WL[base].inverse() * X_WL[tip]).inv_mul(&X_BH);
            worst = worst.max(error.translation.vector.norm()).max(2.0 * error.rotation.imag().norm());
            let limits = solution.q.iter().zip(arm.limits()).all(|(q, limit)| (limit.lower..=limit.upper).contains(q));
            error.translation.vector.norm() < 1e-4 && error.rotation.angle() < 1e-3 && limits
        });
        let right = right.count();
        wrong += set.solutions.len() - right;
        found += right;
        reached += usize::from(right > 0);
    }
    let mut report = Report::new("ik", "of the workload");
    let per_pose = found as f64 / poses.len() as f64;
    let note = format!(
        "{reached} poses reached, {per_pose:.1} solutions per pose, {wrong} wrong, worst off by {worst:.1e} m or rad"
    );
    let arcs_note = format!("{outside} solutions of the sweep outside of their branch's arcs");
    report.add("1 000 poses", "one arm angle", "µs", single_us, "");
    report.add("1 000 poses", format!("sweep of {ANGLES} arm angles"), "µs", sweep_us, note);
    report.add("1 000 poses", "feasible arcs of all branches", "µs", arcs_us, arcs_note);
    let wrong_of_six = six_joints(&mut report)?;
    report.print();
    if wrong + outside + wrong_of_six > 0 {
        return Err(format!("{} solutions and {outside} arcs are wrong", wrong + wrong_of_six).into());
    }
    Ok(())
}

/// All branches of Hubo's left arm; answers how many are wrong.
fn six_joints(report: &mut Report) -> Result<usize, Box<dyn Error>> {
    let (urdf, srdf) = (include_str!("../../robots/hubo/hubo.urdf"), include_str!("../../robots/hubo/hubo.srdf"));
    let robot = load_robot(urdf, srdf, &|_| None)?.value;
    let ik = ArmIk::of(&robot, &robot.arms[0])?;
    let mut rng = Rng::new(5, 0);
    let (mut times_us, mut found, mut wrong) = (Vec::new(), 0, 0);
    for _ in 0..1000 {
        let q: Vec<f64> = ik.limits().iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect();
        let X_BH = ik.chain().tip(&q);
        let mut postures = ik.set(&X_BH, &q, 1);
        let begin_ms = now_ms();
        for _ in 0..REPEATS {
            postures = ik.set(std::hint::black_box(&X_BH), &q, 1);
        }
        times_us.push((now_ms() - begin_ms) * 1e3 / REPEATS as f64);
        let is_wrong = |q: &&[f64]| {
            let error = ik.chain().tip(q).inv_mul(&X_BH);
            error.translation.vector.norm() > 1e-12 || 2.0 * error.rotation.imag().norm() > 1e-12
        };
        wrong += postures.iter().filter(is_wrong).count() + usize::from(postures.is_empty());
        found += postures.len();
    }
    let note = format!("{:.1} solutions per pose within the limits, {wrong} wrong", found as f64 / 1000.0);
    report.add("Hubo, 1 000 poses", "all branches of six joints", "µs", times_us, note);
    Ok(wrong)
}
