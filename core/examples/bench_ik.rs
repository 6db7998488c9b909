//! Closed-form IK on the shared workload: 1 000 poses of an S-R-S arm.
//!
//! `cargo run --release -p endcomfort-core --example bench_ik -- URDF BASE TIP WORK.json` prints one JSON object. An
//! answer counts when forward kinematics puts the hand within 0.1 mm and 1 mrad and every joint is within its limits;
//! it is checked outside the timed part. Each pose is timed over several sweeps of 36 arm angles, and once more at one
//! single arm angle.
#![allow(non_snake_case, reason = "frame letters")]
#![expect(clippy::disallowed_methods, reason = "a bench reads the clock")]

use std::time::Instant;

use endcomfort_core::robot::ik::{IkSet, SrsArm};
use endcomfort_core::robot::read_urdf;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};

const ANGLES: usize = 36;
const REPEATS: usize = 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [urdf, base, tip, work] = arguments.as_slice() else {
        return Err("usage: bench_ik URDF BASE TIP WORK.json".into());
    };
    let robot = read_urdf(&std::fs::read_to_string(urdf)?, &|_| None)?.value;
    let link = |name: &str| robot.link_index(name).ok_or_else(|| format!("no link {name:?}"));
    let (base, tip) = (link(base)?, link(tip)?);
    let arm = SrsArm::between(&robot, base, tip)?;
    let work: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(work)?)?;
    let poses: Vec<Vec<f64>> = serde_json::from_value(work["pose_p_then_R_rowmajor"].clone())?;

    let (mut sweep_us, mut single_us, mut reached, mut wrong, mut found) = (Vec::new(), Vec::new(), 0, 0, 0);
    let mut set = IkSet::default();
    for pose in &poses {
        let [x, y, z, rotation @ ..] = pose.as_slice() else { return Err("a pose is too short".into()) };
        let matrix = Matrix3::from_row_slice(rotation);
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
        let X_BH = Isometry3::from_parts(Translation3::new(*x, *y, *z), rotation);
        let mut timed = |n: usize, times: &mut Vec<f64>| {
            let start = Instant::now();
            for _ in 0..REPEATS {
                set.clear();
                arm.sweep_into(std::hint::black_box(&X_BH), n, &mut set);
            }
            times.push(start.elapsed().as_secs_f64() * 1e6 / REPEATS as f64);
        };
        timed(1, &mut single_us);
        timed(ANGLES, &mut sweep_us);
        let right = set.solutions.iter().filter(|solution| {
            let X_WL = robot.link_poses(&solution.q);
            let error = (X_WL[base].inverse() * X_WL[tip]).inv_mul(&X_BH);
            let limits = solution.q.iter().zip(arm.limits()).all(|(q, limit)| (limit.lower..=limit.upper).contains(q));
            error.translation.vector.norm() < 1e-4 && error.rotation.angle() < 1e-3 && limits
        });
        let right = right.count();
        wrong += set.solutions.len() - right;
        found += right;
        reached += usize::from(right > 0);
    }
    let report = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        let at = |share: f64| times.get((share * times.len() as f64) as usize).copied().unwrap_or_default();
        serde_json::json!({ "median_us": at(0.5), "p75_us": at(0.75), "p95_us": at(0.95), "samples": times.len() })
    };
    let line = serde_json::json!({
        "poses": poses.len(),
        "reached": reached,
        "wrong_solutions": wrong,
        "solutions_per_pose": found as f64 / poses.len() as f64,
        "arm_angles": ANGLES,
        "sweep": report(&mut sweep_us),
        "single_arm_angle": report(&mut single_us),
    });
    println!("{line}");
    if wrong > 0 { Err("some solutions are wrong".into()) } else { Ok(()) }
}
