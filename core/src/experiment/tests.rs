//! Experiments with few trials, from beginning to end.

use super::*;
use crate::fit::ObjectiveKind;
use crate::object::HouseholdObject;
use crate::parallel;
use crate::watch::Watch;

fn settings(trials: usize) -> ExperimentSettings {
    ExperimentSettings { trials, seed: 7, shapes: None, is_serial: false, views: Vec::new() }
}

fn text(outcome: &Outcome) -> String {
    csv(&outcome.rows) + &csv(&outcome.trials)
}

#[test]
fn the_outcome_is_the_same_with_one_thread_and_with_many() {
    for experiment in [Experiment::Visibility, Experiment::Peers, Experiment::Outliers] {
        let run = || run_experiment(experiment, &settings(3), Watch::idle()).unwrap();
        let many = text(&run());
        assert_eq!(many, text(&parallel::on_one_thread(run)), "{experiment:?}");
        assert_eq!(many, text(&run()), "{experiment:?}");
    }
}

#[test]
fn every_table_has_its_rows() {
    for (experiment, rows) in [
        (Experiment::Downsampling, 6),
        (Experiment::Visibility, 4),
        (Experiment::Objectives, 20),
        (Experiment::Peers, 4),
        (Experiment::Outliers, 6),
        (Experiment::Deformations, 8),
    ] {
        let outcome = run_experiment(experiment, &settings(2), Watch::idle()).unwrap();
        assert_eq!(outcome.rows.len(), rows, "{experiment:?}");
        assert_eq!(outcome.trials.len(), 2 * rows, "{experiment:?}");
        for row in &outcome.rows {
            assert_eq!((row.trials, row.success), (2, 2), "{row:?}");
            assert!(row.radial_m.is_some_and(|e| e.mean.is_finite()) && row.time_s.is_none(), "{row:?}");
            let has_thesis =
                matches!(experiment, Experiment::Downsampling | Experiment::Visibility | Experiment::Objectives);
            assert_eq!(row.thesis.is_some(), has_thesis, "{row:?}");
        }
    }
}

#[test]
fn rows_and_trials_can_be_read_back() {
    let outcome = run_experiment(Experiment::Visibility, &settings(2), Watch::idle()).unwrap();
    for row in &outcome.rows {
        let value: serde_json::Value = serde_json::from_str(&row.json()).unwrap();
        assert_eq!(value["experiment"], "visibility");
        assert_eq!(value["condition"], row.condition.as_str());
        // The reader of JSON is exact but for the last bit.
        let near = |name: &str, wanted: f64| (value[name].as_f64().unwrap() / wanted - 1.0).abs() < 1e-15;
        assert!(near("radial_mean_m", row.radial_m.unwrap().mean));
        assert!(near("thesis_radial_mean_m", row.thesis.unwrap().radial_mean_m));
        assert!(value.get("time_mean_s").is_none());
    }
    let table = csv(&outcome.trials);
    let lines: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), 1 + outcome.trials.len());
    let column = |name: &str| lines[0].iter().position(|found| *found == name).unwrap();
    for (line, trial) in lines[1..].iter().zip(&outcome.trials) {
        assert_eq!(line.len(), lines[0].len());
        let answer = trial.answer.as_ref().unwrap();
        assert_eq!(line[column("radial_m")].parse(), Ok(answer.errors.radial_m));
        assert_eq!(line[column("found_a_m")].parse(), Ok(answer.found.a));
    }
}

#[test]
fn given_shapes_take_the_place_of_random_ones() {
    let shapes = read_trials("0.1 0.1 0.1 1 1 0 0 0.8 0 0 0").unwrap();
    let given = ExperimentSettings { shapes: Some(shapes), ..settings(50) };
    let outcome = run_experiment(Experiment::Visibility, &given, Watch::idle()).unwrap();
    assert_eq!(outcome.trials.len(), 4);
    // A ball of 10 cm: voxel centroids of 15 mm lie a third of a millimetre inside it.
    let full = &outcome.rows[0];
    assert!(full.radial_m.unwrap().mean < 0.001 && full.volume_error_percent.unwrap().mean < 1.5, "{full:?}");
    assert_eq!((full.recovered, full.exponents_within), (1, Some(1)));
}

#[test]
fn objects_are_reported_worst_first_with_and_without_mirroring() {
    let object = |name: &str, radius: f64| {
        let sections = format!("[[-0.05, {radius}, {radius}], [0.05, {radius}, {radius}]]");
        let json = format!(
            r#"{{"name": "{name}", "title": "", "source": "", "mass_kg": 0.3, "color": [200, 0, 0],
            "parts": [{{"kind": "loft", "e2": 1.0, "sections": {sections}}}]}}"#
        );
        HouseholdObject::parse(&json).unwrap()
    };
    let views = household_views(&[object("wide", 0.05), object("slim", 0.02)], 1, 3);
    let given = ExperimentSettings { views, ..settings(1) };
    let outcome = run_experiment(Experiment::Objects, &given, Watch::idle()).unwrap();
    assert_eq!(outcome.rows.len(), 8);
    let worst: Vec<f64> = outcome.rows[4..].iter().step_by(2).map(|row| row.extent_error_m.unwrap().mean).collect();
    assert!(worst[0] >= worst[1], "{worst:?}");
    assert_eq!(outcome.rows[0].object.as_deref(), Some("all"));
    assert_eq!(outcome.rows[2].trials, 2, "both cans are convex and solid");
    // Two cans seen from one side are found to a few millimetres.
    assert!(outcome.rows[0].extent_error_m.unwrap().median < 0.006, "{:?}", outcome.rows[0]);
    let figure = run_experiment(Experiment::Objectives, &given, Watch::idle()).unwrap();
    let on_objects = figure.rows.iter().filter(|row| row.condition == "objects");
    assert_eq!(on_objects.map(|row| row.objective).collect::<Vec<_>>(), ObjectiveKind::ALL);
}

#[test]
fn an_experiment_can_be_stopped_and_says_when_there_is_nothing_to_do() {
    let stopping = Watch::new(&|| true, &|_, _| (), &|| 0.0);
    let stopped = run_experiment(Experiment::Downsampling, &settings(2), stopping);
    assert!(matches!(stopped, Err(ExperimentRefusal::Stopped)));
    let nothing = run_experiment(Experiment::Downsampling, &settings(0), Watch::idle()).unwrap_err();
    assert_eq!(nothing.to_string(), "experiment downsampling: found 0 trials, wanted at least 1");
    let nothing = run_experiment(Experiment::Objects, &settings(2), Watch::idle()).unwrap_err();
    assert_eq!(nothing.to_string(), "experiment objects: found 0 views, wanted at least 1");
}

#[test]
fn times_are_given_only_when_fits_ran_one_after_the_other() {
    let ticks = std::sync::atomic::AtomicU32::new(0);
    // A clock that moves on by one millisecond whenever it is read.
    let clock = || f64::from(ticks.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
    let watch = Watch::new(&|| false, &|_, _| (), &clock);
    let serial = ExperimentSettings { is_serial: true, ..settings(2) };
    let outcome = run_experiment(Experiment::Visibility, &serial, watch).unwrap();
    assert!(outcome.rows.iter().all(|row| row.time_s.is_some_and(|time_s| time_s.mean >= 0.001)));
}
