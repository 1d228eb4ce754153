//! The window renders by the graphics processor, in software where there is no other.

use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, MutexGuard, PoisonError};

use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use iorect::app::{App, Command, PaneContent, Settings, Tab};
use iorect::render::{Backend, BackendChoice, Film, ImageSettings, RenderTask, choice};
use iorect::scene::camera::Camera;
use iorect::session::Snapshot;
use iorect::tracking::Mode;

use crate::harness::{apply, quick, until, window_of};

/// One device is shared by all windows of a process: tests that take it away must not meet.
static DEVICE: Mutex<()> = Mutex::new(());

/// `None` where this machine has no graphics processor, not even one in software: on a build server that is a failure.
#[allow(clippy::print_stderr, reason = "it says why tests are skipped")]
fn device() -> Option<MutexGuard<'static, ()>> {
    let guard = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
    choice::renew();
    match choice::adapter() {
        Ok(_) => Some(guard),
        Err(why) => {
            assert!(std::env::var_os("CI").is_none(), "{why}");
            eprintln!("skipped: {why}");
            None
        }
    }
}

/// A window with two modes, rendered by the graphics processor.
fn window(backend: BackendChoice) -> Harness<'static, App> {
    let mut settings =
        Settings { pane_count: 2, backend, tab: Tab::Render, noise_target: None, sample_limit: None, ..quick() };
    settings.panes[..2].copy_from_slice(&[PaneContent::Mode(Mode::Rectified), PaneContent::Mode(Mode::Reference)]);
    window_of("nested-spheres", settings, [1280.0, 720.0])
}

fn film(app: &App, mode: Mode) -> Option<&Snapshot> {
    let film = app.state().films.get(&mode)?;
    (film.epoch == app.state().epoch() && !film.is_preview()).then_some(&**film)
}

fn is_by(app: &App, backend: Backend) -> bool {
    film(app, Mode::Rectified).is_some_and(|film| film.backend == backend && film.samples > 0)
}

/// Lets the film come to an end at which no row is ahead of the others, as the pass may be that a message interrupts.
fn finish(harness: &mut Harness<'_, App>) {
    let samples = film(harness.state(), Mode::Rectified).map_or(0, |film| film.samples);
    apply(harness, Command::SetSampleLimit(Some(samples + 40)));
    until(harness, "it is done", |app| film(app, Mode::Rectified).is_some_and(|film| film.is_done));
}

/// Whether the film is the image of the CPU with as many samples, but for rounding and the few paths that part ways.
fn assert_is_right(app: &App) {
    let film = film(app, Mode::Rectified).expect("there is a film");
    let report = app.state().report.as_ref().expect("the scene is prepared");
    let camera = Camera::new(&app.state().film_camera()).expect("the camera is sound");
    let settings = ImageSettings { splits: 0, ..ImageSettings::new(Mode::Rectified, 0) };
    let mut by_cpu = Film::new(film.size[0], film.size[1]);
    let task = RenderTask { prepared: &report.prepared, camera: &camera, settings: &settings };
    assert!(task.pass(&mut by_cpu, film.samples, &AtomicBool::new(false)));
    let (parted, ratio) = iorect::report::backends::apart(&by_cpu.to_rgb(), &film.rgb);
    assert!(parted < 0.2 && (ratio - 1.0).abs() < 0.01, "{parted} of the pixels are apart, the mean by {ratio}");
}

#[test]
fn panes_are_rendered_by_it_and_the_reference_by_the_cpu() {
    let Some(_device) = device() else { return };
    let mut harness = window(BackendChoice::Gpu);
    until(&mut harness, "the graphics processor renders", |app| is_by(app, Backend::Gpu));
    let label = choice::adapter().expect("it was found").label;
    harness.get_by_label(&format!("{label} renders."));
    finish(&mut harness);
    assert_is_right(harness.state());
    until(&mut harness, "the reference is there", |app| film(app, Mode::Reference).is_some());
    assert_eq!(film(harness.state(), Mode::Reference).map(|film| film.backend), Some(Backend::Cpu));
    // An edit is followed.
    apply(&mut harness, Command::SetSampleLimit(None));
    harness.get_by_role_and_label(Role::Slider, "IOR of glass").set_value_accesskit(1.7);
    harness.run_steps(3);
    until(&mut harness, "the edited scene is rendered by it", |app| is_by(app, Backend::Gpu));
    finish(&mut harness);
    assert_is_right(harness.state());
}

#[test]
fn the_choice_is_a_control_and_is_remembered() {
    let Some(_device) = device() else { return };
    let mut harness = window(BackendChoice::Cpu);
    until(&mut harness, "the CPU renders", |app| is_by(app, Backend::Cpu));
    harness.get_by_label("The CPU renders.");
    harness.get_by_label("GPU").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state().settings.backend, BackendChoice::Gpu);
    until(&mut harness, "the graphics processor renders", |app| is_by(app, Backend::Gpu));
    harness.get_by_label("CPU").click();
    harness.run_steps(3);
    until(&mut harness, "the CPU renders again", |app| is_by(app, Backend::Cpu));
    let words = serde_json::to_string(&harness.state().state().settings).expect("settings are written");
    assert!(words.contains(r#""backend":"cpu""#), "{words}");
    // By itself it never takes one in software.
    apply(&mut harness, Command::SetBackend(BackendChoice::Auto));
    if choice::adapter().is_ok_and(|adapter| adapter.is_software) {
        until(&mut harness, "there is an image", |app| film(app, Mode::Rectified).is_some());
        finish(&mut harness);
        assert!(is_by(harness.state(), Backend::Cpu));
    }
}

#[test]
fn the_cpu_goes_on_where_it_is_taken_away() {
    let Some(_device) = device() else { return };
    let mut harness = window(BackendChoice::Gpu);
    until(&mut harness, "the graphics processor renders", |app| is_by(app, Backend::Gpu));
    let before = film(harness.state(), Mode::Rectified).map_or(0, |film| film.samples);
    choice::take_gpu_away();
    until(&mut harness, "it is told", |app| {
        app.state().notices.iter().any(|notice| notice.is_error && notice.text.contains("The CPU goes on"))
    });
    until(&mut harness, "the CPU has gone on", |app| {
        film(app, Mode::Rectified).is_some_and(|film| film.backend == Backend::Mixed && film.samples > before)
    });
    // Nothing is lost, and the image is right.
    finish(&mut harness);
    assert_is_right(harness.state());
    apply(&mut harness, Command::SetSampleLimit(None));
    // An edit is rendered by the CPU from the start.
    harness.get_by_role_and_label(Role::Slider, "IOR of glass").set_value_accesskit(1.7);
    harness.run_steps(3);
    until(&mut harness, "the CPU renders the edited scene", |app| is_by(app, Backend::Cpu));
    // Who chooses anew tries again.
    harness.get_by_label("GPU").click();
    harness.run_steps(3);
    until(&mut harness, "the graphics processor renders again", |app| is_by(app, Backend::Gpu));
}

#[test]
fn where_there_is_none_the_control_says_so() {
    let _device = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut harness = window(BackendChoice::Auto);
    until(&mut harness, "it has been looked for", |app| app.state().graphics.is_some());
    let is_missing = harness.state().state().graphics.as_ref().is_some_and(|status| status.adapter.is_err());
    assert_eq!(harness.get_by_label("GPU").accesskit_node().is_disabled(), is_missing);
    let begins = harness.query_all_by_label_contains("The CPU renders").next().is_some();
    let is_used = harness.state().state().graphics.as_ref().is_some_and(|status| status.is_used);
    assert!(begins || is_used);
}
