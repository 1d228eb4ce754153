//! The choice of how light is transported.

use egui::Ui;

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::widgets::{combo_ui, note, row_ui};
use crate::render::{Estimator, EstimatorChoice};

const NAME: &str = "Light";
const ABOUT: &str = "How light finds its way between the lights and the camera.";

const OPTIONS: [(EstimatorChoice, &str, &str); 4] = [
    (
        EstimatorChoice::Auto,
        "automatic",
        "Merging where caustics of small lights would be too noisy for paths from the camera, else those.",
    ),
    (EstimatorChoice::Path, "paths", "Paths from the camera, which look for lights where they scatter."),
    (
        EstimatorChoice::Bidirectional,
        "Bidir.",
        "Bidirectional: paths from the lights too, joined with those from the camera.",
    ),
    (
        EstimatorChoice::Merging,
        "merging",
        "Bidirectional, and light that has come to places nearby: for caustics seen through glass or water. Caustics are a little blurred at \
         first, less with every sample.",
    ),
];

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let chosen = state.settings.estimator;
    let name = OPTIONS.iter().find(|(choice, ..)| *choice == chosen).map_or("", |(_, name, _)| name);
    row_ui(ui, NAME, ABOUT, |ui| {
        combo_ui(ui, "light", name, |ui| {
            for (choice, name, about) in OPTIONS {
                if ui.selectable_label(choice == chosen, name).on_hover_text(about).clicked() {
                    commands.push(Command::SetEstimator(choice));
                }
            }
        });
    });
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
