//! How light is transported, chosen by the scene and by hand.

use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use iorect::app::{App, Command, Settings};
use iorect::render::{Estimator, EstimatorChoice};

use crate::harness::{apply, quick, until, window_of};

fn window(scene: &str) -> Harness<'static, App> {
    window_of(scene, Settings { pane_count: 1, sample_limit: Some(2), ..quick() }, [1280.0, 720.0])
}

/// Whether the first pane shows an image by this estimator.
fn shows(app: &App, estimator: Estimator) -> bool {
    app.state().estimator() == Some(estimator) && app.samples_shown(0) > 0
}

#[test]
fn the_scene_chooses_and_so_does_the_user() {
    let mut plain = window("plain-glass");
    until(&mut plain, "paths render", |app| shows(app, Estimator::Path));
    let mut caustic = window(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/truth/B1.toml"));
    until(&mut caustic, "caustics are merged", |app| shows(app, Estimator::Merging));
    caustic.get_by_label("Merging: paths alone would hardly find the caustics.");
    caustic.get_by_role_and_label(Role::ComboBox, "Light").click();
    caustic.run_steps(3);
    caustic.get_by_label("paths").click();
    caustic.run_steps(3);
    until(&mut caustic, "paths render", |app| shows(app, Estimator::Path));
    apply(&mut caustic, Command::SetEstimator(EstimatorChoice::Bidirectional));
    until(&mut caustic, "both ends render", |app| shows(app, Estimator::Bidirectional));
    let words = serde_json::to_string(&caustic.state().state().settings).expect("settings are written");
    assert!(words.contains(r#""estimator":"bidirectional""#), "{words}");
    apply(&mut caustic, Command::SetEstimator(EstimatorChoice::Auto));
    until(&mut caustic, "caustics are merged", |app| shows(app, Estimator::Merging));
}
