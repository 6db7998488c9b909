//! Forward kinematics, Jacobian and manipulability of a seven-joint arm, one at a time and in batches, on one core.
//!
//! `cargo bench -p endcomfort-core --bench kinematics [-- FOLDER]`, FOLDER holding `srs7.urdf`. Configurations are
//! uniform within the limits. Every answer is compared with that of the whole robot outside the timed part, and a wrong
//! one fails the bench.
#![allow(non_snake_case, reason = "frame letters")]

#[path = "common/report.rs"]
mod report;
#[path = "common/workload.rs"]
mod workload;

use std::error::Error;
use std::hint::black_box;

use endcomfort_core::rng::Rng;
use endcomfort_core::robot::ik::SrsArm;
use endcomfort_core::robot::{Chain, Dexterity, Placed, Robot, read_urdf};
use nalgebra::{DMatrix, Vector3};
use report::{Report, now_ms};

const SEED: u64 = 1;
const CONFIGURATIONS: usize = 4096;
/// Passes over all configurations, each one a sample.
const PASSES: usize = 200;

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = workload::folder("arm", "srs7.urdf") else { return Ok(()) };
    let robot = read_urdf(&std::fs::read_to_string(folder.join("srs7.urdf"))?, &|_| None)?.value;
    let link = |name: &str| robot.link_index(name).ok_or_else(|| format!("no link {name:?}"));
    let (base, tip) = (link("base")?, link("tcp")?);
    SrsArm::between(&robot, base, tip)?;
    let chain = Chain::between(&robot, base, tip)?;
    let mut rng = Rng::new(SEED, 0);
    let draw = |_| chain.limits().iter().map(|l| rng.uniform(l.lower, l.upper)).collect::<Vec<f64>>();
    let q: Vec<f64> = (0..CONFIGURATIONS).flat_map(draw).collect();

    let mut dexterity = Dexterity::new(&chain);
    let mut placed: Vec<Placed> = Vec::with_capacity(CONFIGURATIONS);
    let (mut scalar, mut batched) = (Vec::new(), Vec::new());
    for _ in 0..PASSES {
        let begin_ms = now_ms();
        placed.clear();
        placed.extend(black_box(&q).chunks_exact(7).map(|q| dexterity.at(q)));
        scalar.push(millions_per_second(begin_ms));
        let alone = black_box(&placed).clone();
        let begin_ms = now_ms();
        dexterity.all(black_box(&q), &mut placed);
        batched.push(millions_per_second(begin_ms));
        if alone != placed {
            return Err("a batch differs from its configurations one by one".into());
        }
    }
    let worst = check(&robot, (base, tip), &chain, &q, &placed);
    let note = format!("all {CONFIGURATIONS} right, worst m off by {worst:.1e}");
    let mut report = Report::new("kinematics", SEED);
    let what = "pose, Jacobian and manipulability";
    report.add("srs7", format!("{what}, one at a time"), "M/s", scalar, &note);
    report.add("srs7", format!("{what}, in batches"), "M/s", batched, &note);
    report.print();
    if worst > 1e-7 { Err(format!("a manipulability is wrong by {worst}").into()) } else { Ok(()) }
}

fn millions_per_second(begin_ms: f64) -> f64 {
    CONFIGURATIONS as f64 / (now_ms() - begin_ms) * 1e-3
}

/// The largest error of position, metres, or manipulability against the whole robot's Jacobian.
fn check(robot: &Robot, (base, tip): (usize, usize), chain: &Chain, q: &[f64], placed: &[Placed]) -> f64 {
    let off = q.chunks_exact(7).zip(placed).map(|(q, placed)| {
        let X_WL = robot.link_poses(q);
        let X_BH = X_WL[base].inverse() * X_WL[tip];
        let mut J = DMatrix::zeros(6, 7);
        for (column, &dof) in chain.dofs().iter().enumerate() {
            let joint = &robot.joints[robot.dof_joints[dof]];
            let axis: Vector3<f64> = X_WL[joint.child].rotation * joint.axis.into_inner();
            let lever = X_WL[tip].translation.vector - X_WL[joint.child].translation.vector;
            J.fixed_view_mut::<3, 1>(0, column).copy_from(&axis);
            J.fixed_view_mut::<3, 1>(3, column).copy_from(&axis.cross(&lever));
        }
        let singular: f64 = J.singular_values().iter().product();
        let off_m = (placed.p_BH - X_BH.translation.vector).norm();
        (placed.manipulability - singular).abs().max(off_m)
    });
    off.fold(0.0, f64::max)
}
