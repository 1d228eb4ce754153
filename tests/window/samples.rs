//! Samples are kept: whatever is opened, closed, exchanged or undone, a picture that was there comes back as good as it was.

use egui_kittest::Harness;
use iorect::app::{App, Arrangement, Command, ObjectEdit, PaneContent, Settings, State};
use iorect::tracking::Mode;

use crate::harness::{apply, every_pane_has_an_image, quick, until, window_of};

/// Samples that every picture has before anything is changed.
const BEFORE: u32 = 4;

fn with_samples(settings: Settings, size: [f32; 2]) -> Harness<'static, App> {
    let settings = Settings { sample_limit: Some(BEFORE), ..settings };
    let mut harness = window_of("nested-spheres", settings, size);
    until(&mut harness, "every pane has its samples", all_have_them);
    harness
}

fn all_have_them(app: &App) -> bool {
    (0..app.state().settings.pane_count).all(|pane| app.samples_shown(pane) >= BEFORE)
}

/// Runs frames until `is_met`; the panes for which `is_kept` never show fewer samples than before.
fn keeping(harness: &mut Harness<'_, App>, what: &str, is_kept: impl Fn(usize) -> bool, is_met: impl Fn(&App) -> bool) {
    let check = |app: &App| {
        for pane in (0..app.state().settings.pane_count).filter(|pane| is_kept(*pane)) {
            let samples = app.samples_shown(pane);
            assert!(samples >= BEFORE, "{what}: pane {} shows {samples} samples", pane + 1);
        }
    };
    for _ in 0..40 {
        harness.step();
        check(harness.state());
    }
    until(harness, what, |app| {
        check(app);
        is_met(app)
    });
}

fn epoch_of(harness: &Harness<'_, App>) -> u64 {
    harness.state().state().epoch()
}

#[test]
fn panels_and_problems_cost_no_sample() {
    let mut harness = with_samples(quick(), [1280.0, 720.0]);
    for command in [
        Command::ToggleProblems,
        Command::ToggleProblems,
        Command::ToggleScenePanel,
        Command::ToggleBothPanels,
        Command::ToggleBothPanels,
        Command::ToggleRenderPanel,
    ] {
        let what = format!("{command:?}");
        apply(&mut harness, command);
        keeping(&mut harness, &what, |_| true, all_have_them);
    }
}

#[test]
fn the_number_of_panes_and_the_wipe_cost_no_sample() {
    let mut harness = with_samples(quick(), [1280.0, 720.0]);
    for command in [
        Command::SetPaneCount(1),
        Command::SetPaneCount(2),
        Command::SetPaneCount(4),
        Command::SetArrangement(Arrangement::Wipe),
        Command::SetArrangement(Arrangement::Tiles),
    ] {
        let what = format!("{command:?}");
        apply(&mut harness, command);
        keeping(&mut harness, &what, |_| true, all_have_them);
    }
}

#[test]
fn what_a_pane_shows_costs_the_others_no_sample_and_comes_back() {
    let settings = Settings { pane_count: 2, ..quick() };
    let mut harness = with_samples(settings, [1000.0, 600.0]);
    let epoch = epoch_of(&harness);
    let [first, second] = [0, 1].map(|pane| harness.state().state().settings.panes[pane]);
    apply(&mut harness, Command::SetPaneContent(1, PaneContent::Mode(Mode::Priority)));
    keeping(&mut harness, "another mode in the second pane", |pane| pane == 0, all_have_them);
    apply(&mut harness, Command::SetPaneContent(1, second));
    keeping(&mut harness, "the earlier mode again", |_| true, all_have_them);
    apply(&mut harness, Command::SetPaneContent(1, PaneContent::Difference(Mode::Priority, Mode::Rectified)));
    keeping(&mut harness, "a difference", |pane| pane == 0, all_have_them);
    assert_eq!(epoch_of(&harness), epoch, "it is the same picture all the time");
    assert_eq!(harness.state().state().settings.panes[0], first);
}

#[test]
fn undoing_an_edit_brings_samples_back() {
    let settings = Settings { pane_count: 2, ..quick() };
    let mut harness = with_samples(settings, [1000.0, 600.0]);
    let has_epoch = |state: &State, app: &App| app.film(Mode::Stack).is_some_and(|film| film.epoch == state.epoch());
    let name = harness.state().state().document.description().objects.refractors()[0].name.clone();
    apply(&mut harness, Command::object(name, ObjectEdit::Visible(false)));
    until(&mut harness, "the edit is shown", |app| has_epoch(app.state(), app) && every_pane_has_an_image(app));
    apply(&mut harness, Command::Undo);
    until(&mut harness, "the scene is as it was", |app| {
        let film = app.film(Mode::Stack).filter(|film| film.epoch == app.state().epoch());
        if let Some(film) = &film {
            assert!(!film.is_preview() && film.samples >= BEFORE, "{} samples", film.samples);
        }
        film.is_some()
    });
    until(&mut harness, "it is on the screen", all_have_them);
}
