//! What an object is to light: the paint of a solid, or a light.

use std::sync::Arc;

use egui::{DragValue, Label, RichText, Ui};

use super::light;
use crate::app::command::Command;
use crate::app::edit::ObjectEdit;
use crate::app::widgets::{RGB, Triple, color_ui, number_ui, number_within_ui, row_ui, segmented_row_ui};
use crate::formats::texture;
use crate::scene::description::{Object, Paint, Role, Solid};

/// Rows for a solid or a light.
pub fn show(ui: &mut Ui, object: &Object, commands: &mut Vec<Command>) {
    match &object.role {
        Role::Refractor(_) => {}
        Role::Solid(solid) => solid_ui(ui, &object.name, solid, commands),
        Role::Light(light) => light::show(ui, object, light, commands),
    }
}

/// A colour, linear RGB, to pick or to type. Gives back what is new.
pub fn color_row_ui(ui: &mut Ui, row: &str, label: &str, about: &str, color: [f64; 3]) -> Option<[f64; 3]> {
    row_ui(ui, row, about, |ui| {
        let mut picked = color.map(|x| x as f32);
        ui.spacing_mut().interact_size.x = 26.0;
        let response = ui.color_edit_button_rgb(&mut picked).accessible_name(format!("{label}: pick"));
        // Four decimals are finer than any screen.
        let short = |x: f32| (f64::from(x) * 1e4).round() / 1e4;
        let picked = (response.changed()).then(|| picked.map(short)).filter(|picked| *picked != color);
        let label = format!("{label},");
        let triple = Triple { speeds: [0.004; 3], ..Triple::new(RGB, &label, about) };
        color_ui(ui, &triple, color).or(picked)
    })
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Color,
    Checker,
    Image,
}

const KINDS: [(Kind, &str, &str); 3] = [
    (Kind::Color, "Colour", "One colour everywhere."),
    (Kind::Checker, "Checker", "Squares of two colours."),
    (Kind::Image, "Image", "An image from a file, laid on by texture coordinates."),
];

fn solid_ui(ui: &mut Ui, name: &str, solid: &Solid, commands: &mut Vec<Command>) {
    let (kind, first) = match &solid.paint {
        Paint::Color(color) => (Kind::Color, *color),
        Paint::Checker { a, .. } => (Kind::Checker, *a),
        // Four decimals are finer than any screen.
        Paint::Texture { .. } => (Kind::Image, solid.paint.mean().map(|x| (x * 1e4).round() / 1e4)),
    };
    let chosen = segmented_row_ui(ui, "Paint", "What the surface reflects.", kind, &KINDS);
    if chosen == Some(Kind::Image) && kind != Kind::Image {
        commands.push(Command::AskTexture);
    }
    let mut set = |paint| commands.push(Command::object(name, ObjectEdit::Paint(paint)));
    match chosen {
        Some(Kind::Color) if kind != Kind::Color => set(Paint::Color(first)),
        Some(Kind::Checker) if kind != Kind::Checker => {
            let darker = first.map(|x| (0.6 * x * 1e4).round() / 1e4);
            set(Paint::Checker { a: first, b: darker, size: 0.5 });
        }
        _ => {}
    }
    let about = "Share of red, green and blue that is reflected, from 0 to 1, linear.";
    match solid.paint {
        Paint::Texture { ref path, ref image, tint, uv } => {
            let about = "The image on the surface.";
            let is_asked = row_ui(ui, "File", about, |ui| {
                let is_asked = ui.button("Choose…").on_hover_text("Another image, from a file.").clicked();
                let file = texture::short_name(path);
                let text = format!("{} ({} × {})", path.display(), image.width(), image.height());
                ui.add(Label::new(RichText::new(file)).truncate()).on_hover_text(text);
                is_asked
            });
            let about = "Multiplies the image: shares of red, green and blue from 0 to 1, linear.";
            if let Some(tint) = color_row_ui(ui, "Tint", &format!("Tint of {name}"), about, tint) {
                set(Paint::Texture { path: path.clone(), image: Arc::clone(image), tint, uv });
            }
            let about = "How often the image is there along u and v; below 0 it is mirrored.";
            row_ui(ui, "Repeat", about, |ui| {
                let mut edited = uv;
                for (scale, axis) in edited.scale.iter_mut().zip(["u", "v"]) {
                    let label = format!("Repeats of {name} along {axis}");
                    let before = *scale;
                    let drag = DragValue::new(scale).speed(0.02).max_decimals(3);
                    if !number_within_ui(ui, 60.0, -1e6..=1e6, drag, label, about) {
                        *scale = before;
                    }
                }
                if edited != uv {
                    set(Paint::Texture { path: path.clone(), image: Arc::clone(image), tint, uv: edited });
                }
            });
            if is_asked {
                commands.push(Command::AskTexture);
            }
        }
        Paint::Color(color) => {
            if let Some(color) = color_row_ui(ui, "Colour", &format!("Colour of {name}"), about, color) {
                set(Paint::Color(color));
            }
        }
        Paint::Checker { a, b, size } => {
            if let Some(a) = color_row_ui(ui, "Colour 1", &format!("First colour of {name}"), about, a) {
                set(Paint::Checker { a, b, size });
            }
            if let Some(b) = color_row_ui(ui, "Colour 2", &format!("Second colour of {name}"), about, b) {
                set(Paint::Checker { a, b, size });
            }
            let about = "Side of a square in scene units.";
            row_ui(ui, "Squares", about, |ui| {
                let mut edited = size;
                let drag = DragValue::new(&mut edited).speed(0.01 * size).max_decimals(4);
                if number_ui(ui, 84.0, drag, format!("Size of squares of {name}"), about) && edited != size {
                    set(Paint::Checker { a, b, size: edited });
                }
            });
        }
    }
    let about = "A perfect mirror, tinted by its colour.";
    row_ui(ui, "Mirror", about, |ui| {
        let mut is_mirror = solid.mirror;
        let label = format!("Mirror {name}");
        if ui.checkbox(&mut is_mirror, "").accessible_name(label).on_hover_text(about).changed() {
            commands.push(Command::object(name, ObjectEdit::Mirror(is_mirror)));
        }
    });
}
