//! What can be added to a scene: in the menu bar, and in a window that opens by its key.

use egui::{Context, RichText, Ui};

use crate::app::build::liquid::Inside;
use crate::app::build::profiles::Vessel;
use crate::app::build::{Addition, Body, DEFAULT_FILL, vessel_of};
use crate::app::command::Command;
use crate::app::modal;
use crate::app::state::{State, capitalized};
use crate::app::theme::Palette;
use crate::scene::Description;
use crate::scene::description::Object;

/// An entry: its text, what it does in a sentence, and the command; `None` where it is not possible now.
struct Entry {
    text: String,
    about: String,
    command: Option<Command>,
}

/// The entries by groups.
fn groups(state: &State) -> Vec<(&'static str, Vec<Entry>)> {
    let entry = |text: &str, about: &str, addition: Addition| Entry {
        text: capitalized(text),
        about: about.to_owned(),
        command: Some(Command::Add(addition)),
    };
    let refractor = |body: Body| {
        entry(body.name(), "A refractor of the selected object's medium, or of glass.", Addition::Refractor(body))
    };
    let vessel =
        |vessel: Vessel| entry(vessel.name, "A vessel of glass, which can be filled.", Addition::Vessel(vessel));
    let solid = |body: Body| entry(body.name(), "An opaque object.", Addition::Solid(body));
    let file = |text: &str, about: &str, command| Entry {
        text: text.to_owned(),
        about: about.to_owned(),
        command: Some(command),
    };
    let ice = "A cube that floats in the water, with a tenth of it above the surface.";
    vec![
        ("Refractors", Body::ALL.map(refractor).into()),
        ("Vessels", Vessel::ALL.map(vessel).into()),
        ("Contents", vec![water(state), entry("ice cube", ice, Addition::IceCube)]),
        (
            "Solids",
            [entry("floor", "A large plane to stand on.", Addition::Floor)]
                .into_iter()
                .chain(Body::ALL.map(solid))
                .collect(),
        ),
        (
            "Lights",
            vec![
                entry("ball light", "A glowing ball.", Addition::BallLight),
                entry("panel light", "A rectangle above that shines down.", Addition::PanelLight),
                entry(
                    "point light",
                    "A point above that shines all around; nothing sees it itself.",
                    Addition::PointLight,
                ),
                entry("spot light", "A cone of light from above, with a smooth edge.", Addition::SpotLight),
                entry("sun", "Light from afar, from a disc of half a degree.", Addition::Sun),
            ],
        ),
        (
            "From a file",
            vec![
                file("Mesh…", "A refractor's surface from an OBJ or PLY file.", Command::AskMesh),
                file(
                    "Environment image…",
                    "A latitude–longitude image around the scene, from HDR, EXR, PNG or JPEG.",
                    Command::AskEnvironmentImage,
                ),
            ],
        ),
    ]
}

/// Fills the selected vessel, or the last one that is empty.
fn water(state: &State) -> Entry {
    let description = state.document.description();
    let vessel = state.selected_object().filter(|object| is_vessel(object)).or_else(|| last_empty_vessel(description));
    Entry {
        text: vessel.map_or("Water in a vessel".to_owned(), |vessel| format!("Water in {}", vessel.name)),
        about: match vessel {
            Some(_) => "Fills it to two thirds. The height can be changed then.".to_owned(),
            None => "There is no vessel to fill: add one first.".to_owned(),
        },
        command: vessel.map(|vessel| Command::Add(Addition::Liquid(vessel.name.clone(), DEFAULT_FILL))),
    }
}

fn is_vessel(object: &Object) -> bool {
    object.refractor().is_some() && Inside::of(&object.shape).is_ok()
}

fn last_empty_vessel(description: &Description) -> Option<&Object> {
    let refractors = description.objects.refractors();
    let is_full = |vessel: &Object| {
        refractors.iter().any(|liquid| vessel_of(description, liquid).is_some_and(|(of, _, _)| of.name == vessel.name))
    };
    refractors.iter().rev().find(|object| is_vessel(object) && !is_full(object))
}

/// In the menu bar.
pub fn menu_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    for (title, entries) in groups(state) {
        heading_ui(ui, title);
        for entry in entries {
            if button_ui(ui, &entry, title, commands).clicked() {
                ui.close();
            }
        }
    }
}

/// The window of the key.
pub fn show(ctx: &Context, state: &State, commands: &mut Vec<Command>) {
    let answer = modal::titled(ctx, "Add an object", state.windows.add, 380.0, |ui, is_opening| {
        let mut is_first = is_opening;
        for (title, entries) in groups(state) {
            heading_ui(ui, title);
            ui.horizontal_wrapped(|ui| {
                for entry in entries {
                    let response = button_ui(ui, &entry, title, commands);
                    // The first entry has the focus when the window opens.
                    if std::mem::take(&mut is_first) {
                        response.request_focus();
                    }
                    if response.clicked() {
                        commands.push(Command::ShowAdd(false));
                    }
                }
            });
        }
    });
    if answer.is_closed {
        commands.push(Command::ShowAdd(false));
    }
}

fn heading_ui(ui: &mut Ui, title: &str) {
    ui.label(RichText::new(title).small().color(Palette::of(ui).weak_text));
}

fn button_ui(ui: &mut Ui, entry: &Entry, group: &str, commands: &mut Vec<Command>) -> egui::Response {
    // Solids and refractors have some names in common.
    let name = match group {
        "Solids" => format!("Add solid {}", entry.text.to_lowercase()),
        "From a file" => format!("Add {}", entry.text),
        _ => format!("Add {}", entry.text.to_lowercase()),
    };
    let response = ui.add_enabled(entry.command.is_some(), egui::Button::new(&entry.text));
    let response = response.accessible_name(name).on_hover_text(&entry.about).on_disabled_hover_text(&entry.about);
    if response.clicked() {
        commands.extend(entry.command.clone());
    }
    response
}
