//! The window without a display, for tests that act as a person would.

use std::time::{Duration, Instant};

use egui_kittest::Harness;
use iorect::app::{App, Command, Settings};

/// Images of a quarter of the size are enough and quick.
pub fn quick() -> Settings {
    Settings { resolution_scale: 0.25, has_first_panes: false, ..Settings::default() }
}

pub fn window_of(scene: &str, settings: Settings, size: [f32; 2]) -> Harness<'static, App> {
    let description = iorect::formats::open(scene).expect("a built-in scene");
    let mut harness = Harness::builder()
        .with_size(size)
        .with_step_dt(1.0 / 60.0)
        .build_eframe(move |cc| App::new(cc, description, Some(settings)).expect("threads can be started"));
    // The tree and the strip of problems come with the report: nothing moves under the pointer after that.
    until(&mut harness, "the scene is prepared and checked", |app| {
        app.state().report.as_ref().is_some_and(|report| report.problems.is_some())
    });
    harness
}

pub fn window(scene: &str) -> Harness<'static, App> {
    window_of(scene, quick(), [1280.0, 720.0])
}

/// Runs frames until `is_met`, and fails after a long time.
pub fn until(harness: &mut Harness<'_, App>, what: &str, is_met: impl Fn(&App) -> bool) {
    let start = Instant::now();
    while !is_met(harness.state()) {
        assert!(start.elapsed() < Duration::from_secs(120), "waited too long until {what}");
        std::thread::sleep(Duration::from_millis(5));
        harness.step();
    }
    // What was shown for it must have reached the screen.
    harness.run_steps(2);
}

pub fn apply(harness: &mut Harness<'_, App>, command: Command) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, command);
    harness.run_steps(3);
}

pub fn every_pane_has_an_image(app: &App) -> bool {
    (0..app.state().settings.pane_count).all(|pane| app.samples_shown(pane) > 0)
}

/// Where the first pane's whole picture is, between the panels.
pub fn picture_of(harness: &Harness<'_, App>) -> egui::Rect {
    harness.state().picture().expect("a pane has been shown")
}
