//! What the window says to somebody who sees it for the first time.

use egui::Key;
use egui_kittest::kittest::Queryable;
use iorect::app::{App, Command, PaneContent, Settings};
use iorect::formats::builtin;
use iorect::tracking::Mode;

use crate::harness::{apply, choose, quick, until, window_of};

fn first_start() -> Settings {
    Settings { resolution_scale: 0.25, ..Settings::of_first_start() }
}

#[test]
fn the_tour_has_five_steps_and_stays_closed() {
    let mut harness = window_of("iced-water", first_start(), [1280.0, 720.0]);
    for step in 1..=5 {
        harness.get_by_label(&format!("{step} of 5"));
        let next = if step == 5 { "Done" } else { "Next" };
        harness.get_by_label(next).click();
        harness.run_steps(3);
    }
    assert_eq!(harness.state().state().tour, None);
    assert!(!harness.state().state().settings.show_tour, "it stays closed at the next start");
    assert!(harness.query_by_label("1 of 5").is_none());
    // Help > Tour shows it again.
    choose(&mut harness, &["Help", "Tour"]);
    harness.get_by_label("1 of 5");
    harness.get_by_label("Close the tour").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state().tour, None);
}

#[test]
fn the_tour_can_be_walked_by_keyboard() {
    let mut harness = window_of("iced-water", first_start(), [1280.0, 720.0]);
    harness.get_by_label("Next").focus();
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    harness.get_by_label("2 of 5");
    harness.get_by_label("Back").focus();
    harness.run_steps(2);
    harness.key_press(Key::Space);
    harness.run_steps(3);
    harness.get_by_label("1 of 5");
}

#[test]
fn built_in_scenes_choose_the_panes_unless_the_user_does() {
    let mut harness = window_of("iced-water", first_start(), [1280.0, 720.0]);
    assert_eq!(harness.state().state().settings.panes[0], PaneContent::Mode(Mode::Stack));
    let open = |harness: &mut egui_kittest::Harness<'_, App>, name: &str| {
        apply(harness, Command::Open(name.into()));
        let title = iorect::formats::open(name).unwrap().name;
        until(harness, "the scene is open", |app| app.state().document.description().name == title);
    };
    open(&mut harness, "half-submerged");
    assert_eq!(harness.state().state().settings.panes[0], PaneContent::Mode(Mode::RectifiedObject));
    apply(&mut harness, Command::ToggleFirstPanes);
    apply(&mut harness, Command::SetPaneCount(1));
    open(&mut harness, "nested-spheres");
    assert_eq!(harness.state().state().settings.pane_count, 1);
    assert_eq!(harness.state().state().settings.panes[0], PaneContent::Mode(Mode::RectifiedObject));
}

#[test]
fn every_wrong_pane_says_why_and_leads_to_the_place() {
    let mut harness = window_of("camera-in-water", Settings { has_first_panes: true, ..quick() }, [1280.0, 720.0]);
    until(&mut harness, "the panes are judged", |app| {
        let modes = app.state().settings.modes();
        modes.iter().all(|mode| app.state().verdicts.of.get(mode).is_some_and(|verdict| verdict.paths >= 256))
    });
    let verdict = harness.get_by_label("Verdict of pane 1: wrong here: does not know that it starts in pool water");
    verdict.click();
    harness.run_steps(4);
    let state = harness.state().state();
    assert_eq!(state.view.active_pane, 0);
    assert!(state.inspection.is_some(), "the place is inspected");
    harness.get_by_label("Verdict of pane 2: right");
}

#[test]
fn the_first_picture_of_a_scene_has_a_wrong_mode_and_a_right_one() {
    for scene in builtin::all().iter().filter(|scene| scene.name != "plain-glass") {
        let mut harness = window_of(scene.name, Settings { has_first_panes: true, ..quick() }, [960.0, 600.0]);
        apply(&mut harness, Command::TogglePause);
        let modes = harness.state().state().settings.modes();
        // What is found is kept: a picture of another size is judged anew.
        let found = std::cell::Cell::new([false; 2]);
        until(&mut harness, "the panes are judged", |app| {
            let verdicts = &app.state().verdicts.of;
            let is_right = |index: usize| match app.state().settings.panes[index] {
                PaneContent::Mode(mode) => verdicts.get(&mode).is_some_and(|verdict| verdict.is_right()),
                other => panic!("{}: pane {index} shows {other}", scene.name),
            };
            found.set([0, 1].map(is_right));
            modes.iter().all(|mode| verdicts.get(mode).is_some_and(|verdict| verdict.paths >= 256))
        });
        assert_eq!(found.get(), [false, true], "{}: the first pane is to be wrong and the second right", scene.name);
    }
}

/// The report measures pictures of the size that the first four panes have.
#[test]
fn the_first_panes_have_the_size_that_the_report_measures() {
    let settings = Settings { show_tour: false, ..Settings::default() };
    let harness = window_of("iced-water", settings, [1600.0, 960.0]);
    let film = harness.state().state().film_size();
    for (side, measured) in film.into_iter().zip(iorect::report::first_look::PANE) {
        assert!(side.abs_diff(measured) <= 4, "{film:?}");
    }
}
