//! What the scene itself says of a medium: outside of an object, or around its camera. Mode declared believes it, and the problems tell where it is
//! wrong.

use egui::Ui;

use crate::app::command::Command;
use crate::app::edit::{Edit, ObjectEdit};
use crate::app::widgets::{combo_ui, row_ui};
use crate::optics::medium::WORLD;
use crate::scene::Description;
use crate::scene::description::Object;

const NOTHING: &str = "nothing";

/// A row for what is declared outside of a refractor or a light.
pub fn outside_ui(ui: &mut Ui, description: &Description, object: &Object, commands: &mut Vec<Command>) {
    let about = "The medium that the scene itself declares outside, as files for other renderers do. Mode declared believes it, and takes the \
                 world where nothing is declared; rectification does not look at it.";
    let name = format!("Declared outside of {}", object.name);
    if let Some(outside) = medium_ui(ui, description, &name, about, object.outside()) {
        commands.push(Command::object(&object.name, ObjectEdit::Outside(outside)));
    }
}

/// A row for what the camera is declared to be in.
pub fn camera_ui(ui: &mut Ui, description: &Description, commands: &mut Vec<Command>) {
    let about = "The medium that the scene itself declares the camera to be in. Mode declared starts there, and in the world where nothing is \
                 declared; other modes do not look at it.";
    let declared = description.camera_medium.as_deref();
    if let Some(medium) = medium_ui(ui, description, "Declared around the camera", about, declared) {
        commands.push(Command::Edit(Edit::CameraMedium(medium)));
    }
}

/// The new declaration, if another was chosen.
fn medium_ui(
    ui: &mut Ui,
    description: &Description,
    name: &str,
    about: &str,
    declared: Option<&str>,
) -> Option<Option<String>> {
    let mut chosen = None;
    row_ui(ui, "Declared", about, |ui| {
        ui.name_inputs(name, |ui| {
            combo_ui(ui, name, declared.unwrap_or(NOTHING), |ui| {
                let media = description.media.iter().map(|medium| medium.name.as_str());
                for medium in [None, Some(WORLD)].into_iter().chain(media.map(Some)) {
                    let is_clicked = ui.selectable_label(declared == medium, medium.unwrap_or(NOTHING)).clicked();
                    if is_clicked && declared != medium {
                        chosen = Some(medium.map(str::to_owned));
                    }
                }
            });
        });
    });
    chosen
}
