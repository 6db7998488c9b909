//! The tour: six stops, by itself in half a minute, by its buttons, and from the keyboard.

use egui::Theme;
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::job::Stage;

use super::bench::{Bench, picture, window};
use super::page;
use crate::viewer::state::Step;
use crate::viewer::tour::{STAYS_S, Stop};
use crate::viewer::{Command, Overlay, TourCommand};

#[test]
fn the_tour_goes_on_by_itself_waits_for_readers_and_takes_half_a_minute() {
    let mut bench = Bench::until("mustard", Stage::Plan);
    bench.apply(Command::Show(Overlay::Gallery));
    bench.apply(Command::Tour(TourCommand::Start));
    assert_eq!(bench.page.state.overlay, Overlay::None);
    let mut seen = Vec::new();
    let mut passed_s = 0.0;
    while bench.page.state.tour_runs() {
        let tour = bench.page.state.tour.expect("it is under way");
        if seen.last() != Some(&tour.stop) {
            seen.push(tour.stop);
            let words = Stop::ALL[tour.stop].words(&bench.page.state);
            assert!(words.len() > 60 && !words.contains(" 0 "), "{words}");
        }
        let effects = bench.page.state.advance_tour(0.1);
        bench.carry_out(effects);
        passed_s += 0.1;
        assert!(passed_s < 40.0, "it never ends");
    }
    assert_eq!(seen, [0, 1, 2, 3, 4, 5]);
    assert!((passed_s - 6.0 * STAYS_S).abs() < 1.0, "{passed_s} s");
    assert_eq!(bench.page.state.selection.step, Step::Stage(Stage::Scene));
    bench.apply(Command::Tour(TourCommand::To(1)));
    bench.apply(Command::Tour(TourCommand::Hold(true)));
    let effects = bench.page.state.advance_tour(60.0);
    assert!(effects.is_empty());
    assert_eq!(bench.page.state.tour.map(|tour| tour.stop), Some(1), "somebody is reading");
    bench.apply(Command::Escape);
    assert_eq!(bench.page.state.tour, None);
}

#[test]
fn the_card_has_its_buttons_and_the_gallery_begins_it() {
    let mut bench = Bench::until("mustard", Stage::Fit);
    bench.apply(Command::Show(Overlay::Gallery));
    let mut harness = page(bench.page.state, [1280.0, 720.0], Theme::Dark);
    harness.run_steps(3);
    harness.get_by_label("Take the 30-second tour").click();
    harness.run_steps(3);
    let _title = harness.get_by_label(Stop::ALL[0].title());
    for stop in 1..Stop::ALL.len() {
        harness.get_by_label("Next").click();
        harness.run_steps(3);
        assert_eq!(harness.state().state.tour.map(|tour| tour.stop), Some(stop));
    }
    harness.get_by_label("Back").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state.tour.map(|tour| tour.stop), Some(4));
    harness.get_by_label("Tour: Your turn").click();
    harness.run_steps(3);
    harness.get_by_label("Done").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state.tour, None);
}

#[test]
fn every_stop_is_drawn() {
    for (size, name) in [([1280.0, 720.0], "laptop"), ([390.0, 780.0], "phone")] {
        let mut bench = Bench::until("mustard", Stage::Plan);
        bench.apply(Command::Tour(TourCommand::Start));
        let mut harness = window(bench, size, name == "laptop");
        for stop in 0..Stop::ALL.len() {
            harness.state_mut().bench.apply(Command::Tour(TourCommand::To(stop)));
            harness.state_mut().bench.apply(Command::Tour(TourCommand::Hold(true)));
            let _drawn = picture(&mut harness, &format!("tour-{name}-{stop}"));
            let _title = harness.get_by_label(Stop::ALL[stop].title());
        }
    }
}
