//! The choice of how light is transported.

use egui::Ui;

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::widgets::{note, row_ui, segmented_where_ui};
use crate::render::{Estimator, EstimatorChoice};

const NAME: &str = "Light";
const ABOUT: &str = "How light finds its way between the lights and the camera.";

const OPTIONS: [(EstimatorChoice, &str, &str); 4] = [
    (
        EstimatorChoice::Auto,
        "Auto",
        "Merging where caustics of small lights would be too noisy for paths from the camera, else those.",
    ),
    (EstimatorChoice::Path, "Path", "Paths from the camera, which look for lights where they scatter."),
    (
        EstimatorChoice::Bidirectional,
        "Bidir.",
        "Bidirectional: paths from the lights too, joined with those from the camera.",
    ),
    (
        EstimatorChoice::Merging,
        "Merging",
        "Bidirectional, and light that has come to places nearby: for caustics seen through glass or water. Caustics are a little blurred at \
         first, less with every sample.",
    ),
];

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let chosen = state.settings.estimator;
    let clicked = row_ui(ui, NAME, ABOUT, |ui| segmented_where_ui(ui, chosen, &OPTIONS, |_| true));
    commands.extend(clicked.map(Command::SetEstimator));
    if chosen == EstimatorChoice::Auto
        && let Some(estimator) = state.estimator()
    {
        ui.add(egui::Label::new(note(ui, words(estimator))).wrap());
    }
}

/// What was chosen, and why.
fn words(estimator: Estimator) -> &'static str {
    match estimator {
        Estimator::Path => "Paths: no caustics here that they cannot find.",
        Estimator::Bidirectional => "Bidirectional.",
        Estimator::Merging => "Merging: paths alone would hardly find the caustics.",
    }
}
