//! The light from all around: one colour, a gradient, or an image.

use egui::{DragValue, Label, RichText, Ui};

use crate::app::command::Command;
use crate::app::edit::Edit;
use crate::app::theme::opaque;
use crate::app::widgets::{
    RGB, Triple, color_ui, note, number_ui, number_within_ui, row_ui, segmented_row_ui, swatch_ui,
};
use crate::scene::description::Environment;

/// Radiance of a colour where there was an image.
const GREY: [f64; 3] = [0.5; 3];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Color,
    Gradient,
    Image,
}

pub fn show(ui: &mut Ui, environment: &Environment, commands: &mut Vec<Command>) {
    let kind = match environment {
        Environment::Color(_) => Kind::Color,
        Environment::Gradient { .. } => Kind::Gradient,
        Environment::Image { .. } => Kind::Image,
    };
    let kinds = [
        (Kind::Color, "Colour", "The same light from everywhere."),
        (Kind::Gradient, "Gradient", "Three colours: above, at the horizon, below."),
        (Kind::Image, "Image", "A latitude-longitude image (EXR, HDR, PNG or JPEG) from a file."),
    ];
    let mut set = |environment: Environment| commands.push(Command::Edit(Edit::Environment(environment)));
    match segmented_row_ui(ui, "Kind", "What surrounds the scene.", kind, &kinds).filter(|chosen| *chosen != kind) {
        None => {}
        Some(Kind::Color) => set(Environment::Color(near_horizon(environment))),
        Some(Kind::Gradient) => {
            let horizon = near_horizon(environment);
            set(Environment::Gradient { zenith: horizon, horizon, nadir: horizon });
        }
        Some(Kind::Image) => commands.push(Command::AskEnvironmentImage),
    }
    match environment {
        Environment::Color(color) => {
            let about = "Radiance of the environment, linear RGB.";
            if let Some(color) = radiance_ui(ui, "Radiance", "Radiance of the environment,", about, *color) {
                commands.push(Command::Edit(Edit::Environment(Environment::Color(color))));
            }
        }
        Environment::Gradient { zenith, horizon, nadir } => {
            let mut edited = [*zenith, *horizon, *nadir];
            let mut is_changed = false;
            let rows = [("Above", "at the zenith"), ("Horizon", "at the horizon"), ("Below", "at the nadir")];
            for (color, (name, place)) in edited.iter_mut().zip(rows) {
                let about = format!("Radiance {place}, linear RGB.");
                if let Some(new) = radiance_ui(ui, name, &format!("Radiance {place},"), &about, *color) {
                    *color = new;
                    is_changed = true;
                }
            }
            if is_changed {
                let [zenith, horizon, nadir] = edited;
                commands.push(Command::Edit(Edit::Environment(Environment::Gradient { zenith, horizon, nadir })));
            }
        }
        Environment::Image { .. } => image_ui(ui, environment, commands),
    }
}

fn image_ui(ui: &mut Ui, environment: &Environment, commands: &mut Vec<Command>) {
    let Environment::Image { path, image, rotation, scale } = environment else { return };
    row_ui(ui, "File", "The image that surrounds the scene.", |ui| {
        if ui.button("Choose…").on_hover_text("Another image, from a file.").clicked() {
            commands.push(Command::AskEnvironmentImage);
        }
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let text = format!("{} ({} × {})", path.display(), image.width, image.height);
        ui.add(Label::new(RichText::new(name)).truncate()).on_hover_text(text);
    });
    let (mut new_rotation, mut new_scale) = (*rotation, *scale);
    let about = "Degrees about the vertical axis, counter-clockwise seen from above.";
    row_ui(ui, "Rotation", about, |ui| {
        let drag = DragValue::new(&mut new_rotation).speed(0.5).suffix("°").max_decimals(2);
        if !number_ui(ui, 72.0, drag, "Rotation of the environment", about) {
            new_rotation = *rotation;
        }
    });
    let about = "Multiplies the image's radiance.";
    row_ui(ui, "Scale", about, |ui| {
        let speed = (0.01 * *scale).max(0.001);
        let drag = DragValue::new(&mut new_scale).speed(speed).max_decimals(4);
        if !number_within_ui(ui, 72.0, 0.0..=1e60, drag, "Scale of the environment", about) {
            new_scale = *scale;
        }
    });
    if (new_rotation, new_scale) != (*rotation, *scale) {
        let (path, image) = (path.clone(), std::sync::Arc::clone(image));
        let edited = Environment::Image { path, image, rotation: new_rotation, scale: new_scale };
        commands.push(Command::Edit(Edit::Environment(edited)));
    }
    if !image.notes.is_empty() {
        let notes: Vec<String> = image.notes.iter().map(|note| note.message.clone()).collect();
        ui.add(Label::new(note(ui, notes.join("\n"))).wrap());
    }
}

/// A radiance, with its colour after it.
fn radiance_ui(ui: &mut Ui, name: &str, label: &str, about: &str, color: [f64; 3]) -> Option<[f64; 3]> {
    row_ui(ui, name, about, |ui| {
        let shown = opaque(crate::render::Display::default().encode(color.map(|c| c as f32)));
        swatch_ui(ui, shown);
        let triple = Triple { range: 0.0..=1e6, ..Triple::new(RGB, label, about) };
        color_ui(ui, &triple, color)
    })
}

/// A colour that an environment of another kind begins with.
fn near_horizon(environment: &Environment) -> [f64; 3] {
    match environment {
        Environment::Color(color) => *color,
        Environment::Gradient { horizon, .. } => *horizon,
        Environment::Image { .. } => GREY,
    }
}
