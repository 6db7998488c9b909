//! `ik`: solves a file of hand poses for the joints between two links of a robot.

use std::path::{Path, PathBuf};

use endcomfort_core::robot::ik::ArmIk;
use endcomfort_core::robot::{Robot, read_urdf};
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion};
use serde_json::json;

use super::{Common, Failure, input};
use crate::clock::stopwatch;

/// Each pose is timed this often; the median counts.
const REPEATS: usize = 5;
/// A quaternion's length and a matrix's rows may be off by this much, as numbers printed with few digits are.
const ROTATION_TOLERANCE: f64 = 1e-3;
/// Key of the poses in a JSON file: position, then rotation row by row.
const JSON_KEY: &str = "pose_p_then_R_rowmajor";
/// Most arm angles of a sweep.
const MAX_SWEEP: u64 = 100_000;

#[derive(clap::Args)]
pub(super) struct Args {
    /// Robot description (URDF).
    urdf: PathBuf,
    /// Link in whose frame the poses are given; the joints from here on are solved.
    #[arg(long)]
    base: String,
    /// Link that is brought to the poses.
    #[arg(long)]
    tip: String,
    /// Poses: lines of `x y z qx qy qz qw`, or a JSON file with the key `pose_p_then_R_rowmajor`.
    #[arg(long)]
    poses: PathBuf,
    /// Also finds all branches at N arm angles over a full turn (from N starts if the arm has no closed form).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_SWEEP))]
    sweep: Option<u64>,
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let robot = robot(&args.urdf)?;
    let link = |name: &str, option: &str| {
        robot.link_index(name).ok_or_else(|| {
            let known: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
            let wanted = known.join(", ");
            Failure::new(format!("{option}: found no link {name:?} in {}, wanted one of {wanted}", args.urdf.display()))
        })
    };
    let (base, tip) = (link(&args.base, "--base")?, link(&args.tip, "--tip")?);
    let ik = ArmIk::between(&robot, base, tip)
        .map_err(|error| Failure::new(format!("{}: {error}", args.urdf.display())))?
        .with_seed(common.seed.unwrap_or(0));
    let poses = poses(&args.poses)?;
    let q_now: Vec<f64> = ik.limits().iter().map(|limit| 0.0_f64.max(limit.lower).min(limit.upper)).collect();

    let mut summary = Summary::default();
    for (index, X_BH) in poses.iter().enumerate() {
        let (first, first_us) = timed(|| ik.first(X_BH, &q_now));
        summary.first_us.push(first_us);
        let mut row = json!({ "pose": index, "status": "solved", "reason": null, "first_us": first_us });
        match &first {
            Ok(q) => {
                let (error_m, error_rad) = summary.count(&ik, X_BH, q);
                row["q"] = json!(q);
                row["error_m"] = json!(error_m);
                row["error_rad"] = json!(error_rad);
                summary.solved += 1;
            }
            Err(reject) => {
                row["status"] = json!("refused");
                row["reason"] = json!(reject.to_string());
                summary.refuse(reject.reason());
            }
        }
        if let Some(angles) = args.sweep {
            let (set, sweep_us) = timed(|| ik.set(X_BH, &q_now, angles as usize));
            set.iter().for_each(|q| _ = summary.count(&ik, X_BH, q));
            summary.sweep_us.push(sweep_us);
            summary.solutions += set.len();
            row["solutions"] = set.iter().collect();
            row["sweep_us"] = json!(sweep_us);
        }
        if common.json {
            println!("{row}");
        } else {
            print_row(&row);
        }
    }
    summary.print(&ik, poses.len(), args.sweep);
    Ok(())
}

/// What was found over all poses.
#[derive(Default)]
struct Summary {
    solved: usize,
    solutions: usize,
    first_us: Vec<f64>,
    sweep_us: Vec<f64>,
    worst_m: f64,
    worst_rad: f64,
    refused: Vec<(String, usize)>,
}

impl Summary {
    /// How far forward kinematics puts the tip from the pose, metres and radians; the worst is kept.
    fn count(&mut self, ik: &ArmIk, X_BH: &Isometry3<f64>, q: &[f64]) -> (f64, f64) {
        let off = ik.chain().tip(q).inv_mul(X_BH);
        // By the vector part, since an arc cosine of the real one is blind below 1e-8.
        let (error_m, error_rad) = (off.translation.vector.norm(), 2.0 * off.rotation.imag().norm().asin());
        self.worst_m = self.worst_m.max(error_m);
        self.worst_rad = self.worst_rad.max(error_rad);
        (error_m, error_rad)
    }

    fn refuse(&mut self, reason: String) {
        match self.refused.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, count)) => *count += 1,
            None => self.refused.push((reason, 1)),
        }
    }

    fn print(mut self, ik: &ArmIk, poses: usize, sweep: Option<u64>) {
        eprintln!("method: {}", ik.method());
        let (worst_m, worst_rad) = (self.worst_m, self.worst_rad);
        eprintln!("{} of {poses} poses solved, worst error {worst_m:.1e} m, {worst_rad:.1e} rad", self.solved);
        self.refused.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        self.refused.iter().for_each(|(reason, count)| eprintln!("  {count} × {reason}"));
        let (median, p95) = (quantile(&mut self.first_us, 0.5), quantile(&mut self.first_us, 0.95));
        eprintln!("first solution: median {median:.2} µs, 95 % {p95:.2} µs");
        if let Some(angles) = sweep {
            let per_solution_ns = 1e3 * self.sweep_us.iter().sum::<f64>() / self.solutions.max(1) as f64;
            let (median, p95) = (quantile(&mut self.sweep_us, 0.5), quantile(&mut self.sweep_us, 0.95));
            eprintln!(
                "sweep of {angles}: median {median:.2} µs, 95 % {p95:.2} µs, {} solutions, {per_solution_ns:.0} ns each",
                self.solutions
            );
        }
    }
}

fn print_row(row: &serde_json::Value) {
    let first_us = row["first_us"].as_f64().unwrap_or(0.0);
    let count = row["solutions"].as_array().map_or_else(String::new, |all| format!("  {} solutions", all.len()));
    match row["q"].as_array() {
        Some(q) => {
            let text: Vec<String> = q.iter().filter_map(|v| v.as_f64()).map(|v| format!("{v:8.4}")).collect();
            println!("{:>5}  {}  {first_us:.2} µs{count}", row["pose"], text.join(" "));
        }
        None => println!("{:>5}  {}  {first_us:.2} µs{count}", row["pose"], row["reason"].as_str().unwrap_or("")),
    }
}

/// An answer and the median time that it takes, microseconds.
fn timed<T>(mut answer: impl FnMut() -> T) -> (T, f64) {
    let mut once = || {
        let elapsed_ms = stopwatch();
        let found = answer();
        (found, elapsed_ms() * 1e3)
    };
    let mut times: Vec<f64> = (1..REPEATS).map(|_| once().1).collect();
    let (found, last) = once();
    times.push(last);
    (found, quantile(&mut times, 0.5))
}

/// The value that this share of the samples does not exceed; 0 for no sample.
fn quantile(samples: &mut [f64], share: f64) -> f64 {
    samples.sort_by(f64::total_cmp);
    let rank = (share * samples.len() as f64).ceil() as usize;
    samples.get(rank.max(1) - 1).copied().unwrap_or(0.0)
}

/// The robot without what is drawn: meshes are not looked for.
fn robot(path: &Path) -> Result<Robot, Failure> {
    let text = String::from_utf8_lossy(&input::read_file(path)?).into_owned();
    let loaded = read_urdf(&text, &|_| None).map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
    Ok(loaded.value)
}

fn poses(path: &Path) -> Result<Vec<Isometry3<f64>>, Failure> {
    let text = String::from_utf8_lossy(&input::read_file(path)?).into_owned();
    let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let poses = if is_json { poses_from_json(&text) } else { poses_from_lines(&text) };
    let poses = poses.map_err(|fault| Failure::new(format!("{}: {fault}", path.display())))?;
    if poses.is_empty() {
        return Err(Failure::new(format!("{}: found no pose, wanted at least one", path.display())));
    }
    Ok(poses)
}

/// Lines of `x y z qx qy qz qw`, by blanks or commas; `#` begins a remark.
fn poses_from_lines(text: &str) -> Result<Vec<Isometry3<f64>>, String> {
    let mut poses = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let place = format!("line {}", index + 1);
        let words = line.split('#').next().unwrap_or("").split(|c: char| c.is_whitespace() || c == ',');
        let mut numbers = Vec::new();
        for word in words.filter(|word| !word.is_empty()) {
            let number = word.parse().ok().filter(|number: &f64| number.is_finite());
            numbers.push(number.ok_or_else(|| format!("{place}: found {word:?}, wanted a finite number"))?);
        }
        match numbers[..] {
            [] => {}
            [x, y, z, qx, qy, qz, qw] => {
                let quaternion = Quaternion::new(qw, qx, qy, qz);
                let length = quaternion.norm();
                if (length - 1.0).abs() > ROTATION_TOLERANCE {
                    return Err(format!("{place}: found a quaternion of length {length:.4}, wanted 1"));
                }
                let rotation = UnitQuaternion::from_quaternion(quaternion);
                poses.push(Isometry3::from_parts(Translation3::new(x, y, z), rotation));
            }
            _ => return Err(format!("{place}: found {} numbers, wanted 7: x y z qx qy qz qw", numbers.len())),
        }
    }
    Ok(poses)
}

fn poses_from_json(text: &str) -> Result<Vec<Isometry3<f64>>, String> {
    let file: serde_json::Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let rows = file.get(JSON_KEY).ok_or_else(|| format!("found no key {JSON_KEY:?}, wanted lists of 12 numbers"))?;
    let rows: Vec<Vec<f64>> = serde_json::from_value(rows.clone()).map_err(|error| format!("{JSON_KEY}: {error}"))?;
    let pose = |(index, row): (usize, &Vec<f64>)| {
        let place = format!("{JSON_KEY}[{index}]");
        let [x, y, z, rotation @ ..] = row.as_slice() else {
            return Err(format!("{place}: found {} numbers, wanted 12", row.len()));
        };
        if rotation.len() != 9 {
            return Err(format!("{place}: found {} numbers, wanted 12", row.len()));
        }
        let matrix = Matrix3::from_row_slice(rotation);
        let off = (matrix * matrix.transpose() - Matrix3::identity()).amax();
        if !(off < ROTATION_TOLERANCE && matrix.determinant() > 0.0) {
            return Err(format!("{place}: found a matrix that is {off:.1e} off a rotation, wanted a rotation"));
        }
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
        // A matrix of few digits gives a quaternion that is as little off length 1.
        let rotation = UnitQuaternion::from_quaternion(rotation.into_inner());
        Ok(Isometry3::from_parts(Translation3::new(*x, *y, *z), rotation))
    };
    rows.iter().enumerate().map(pose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_read_from_lines_with_remarks() {
        let poses = poses_from_lines("# x y z qx qy qz qw\n0.1 0.2 0.3 0 0 0 1\n\n1,2,3, 0,0,1,0 # turned\n").unwrap();
        assert_eq!(poses.len(), 2);
        assert_eq!(poses[0], Isometry3::translation(0.1, 0.2, 0.3));
        assert!((poses[1].rotation.angle() - std::f64::consts::PI).abs() < 1e-12);
    }

    #[test]
    fn faults_of_poses_name_their_place() {
        for (text, wanted) in [
            ("0 0 0 0 0 0 1\n0 0 0 0 0 1", "line 2: found 6 numbers, wanted 7: x y z qx qy qz qw"),
            ("0 0 nan 0 0 0 1", "line 1: found \"nan\", wanted a finite number"),
            ("0 0 zero 0 0 0 1", "line 1: found \"zero\", wanted a finite number"),
            ("0 0 0 0 0 0 2", "line 1: found a quaternion of length 2.0000, wanted 1"),
        ] {
            assert_eq!(poses_from_lines(text).unwrap_err(), wanted);
        }
        for (text, wanted) in [
            ("{}", "found no key \"pose_p_then_R_rowmajor\", wanted lists of 12 numbers"),
            ("{\"pose_p_then_R_rowmajor\": [[1, 2]]}", "pose_p_then_R_rowmajor[0]: found 2 numbers, wanted 12"),
        ] {
            assert_eq!(poses_from_json(text).unwrap_err(), wanted);
        }
    }
}
