//! The controls of one medium: an IOR to drag and to type, presets, absorption.

use egui::{Button, DragValue, Rect, RichText, Slider, SliderClamping, Ui, UiBuilder, vec2};

use crate::app::command::{Command, MediumRef};
use crate::app::edit::{Edit, MediumEdit, ior_of};
use crate::app::theme::Palette;
use crate::app::widgets::{note, number_ui, row_ui};
use crate::optics::{Ior, catalog};
use crate::scene::Description;

/// The slider's range; anything greater than 0 can be typed.
const SLIDER: std::ops::RangeInclusive<f64> = 1.0..=2.5;
const VALUE_WIDTH: f32 = 58.0;
const SLIDER_WIDTH: f32 = 60.0;

/// Width that [`ior_ui`] takes.
pub const IOR_WIDTH: f32 = VALUE_WIDTH + SLIDER_WIDTH + 6.0;

/// A slider and a typed value for an IOR, in the space at the right of `rect`. `owner` names the row, so that two objects of one
/// medium keep their controls apart.
pub fn ior_ui(
    ui: &mut Ui,
    rect: Rect,
    description: &Description,
    medium: &MediumRef,
    owner: &str,
    commands: &mut Vec<Command>,
) {
    let Some(model) = ior_of(description, medium) else { return };
    let label = format!("IOR of {}", medium.name());
    let ior = model.ior();
    let source = match model {
        Ior::Constant(_) => String::new(),
        Ior::Catalog(entry) => format!("\n{}: {}", entry.label, entry.source),
        Ior::Cauchy(_) | Ior::Sellmeier(_) | Ior::Gas(_) => {
            format!("\nFrom a {}, at 587.56 nm; dragging makes it a constant.", form(model))
        }
    };
    let tip = format!("Index of refraction of {}. Drag, or type any value above 0.{source}", medium.name());
    let layout = egui::Layout::right_to_left(egui::Align::Center);
    let ui = &mut ui.new_child(UiBuilder::new().max_rect(rect).id_salt(("ior", owner)).layout(layout));
    ui.spacing_mut().slider_width = SLIDER_WIDTH;
    let mut value = ior;
    // Four decimals tell catalogue media apart; what was typed is kept in full.
    let typed = DragValue::new(&mut value).speed(0.001).range(1e-3..=1e3).min_decimals(3).max_decimals(4);
    if number_ui(ui, VALUE_WIDTH, typed, &label, &tip) && value != ior {
        commands.push(Command::set_ior(medium.clone(), Ior::Constant(value)));
    }
    let mut value = ior;
    // A small knob leaves more of the rail to drag on.
    ui.spacing_mut().interact_size.y = 16.0;
    let slider = Slider::new(&mut value, SLIDER).show_value(false).clamping(SliderClamping::Never).step_by(0.001);
    if ui.add(slider).accessible_name(&label).on_hover_text(&tip).changed() && value != ior {
        commands.push(Command::set_ior(medium.clone(), Ior::Constant(value)));
    }
}

/// How the index is given, in words.
fn form(ior: &Ior) -> &'static str {
    match ior {
        Ior::Constant(_) => "custom",
        Ior::Cauchy(_) => "Cauchy formula",
        Ior::Sellmeier(_) => "Sellmeier formula",
        Ior::Gas(_) => "formula for gases",
        Ior::Catalog(entry) => entry.label,
    }
}

/// Preset and absorption of the selected object's medium.
pub fn details_ui(ui: &mut Ui, description: &Description, medium: &MediumRef, commands: &mut Vec<Command>) {
    let Some(model) = ior_of(description, medium) else { return };
    let shown = form(model);
    row_ui(ui, "Preset", "Media with measured indices of refraction.", |ui| {
        egui::ComboBox::from_id_salt("preset").selected_text(shown).width(ui.available_width()).height(320.0).show_ui(
            ui,
            |ui| {
                for entry in catalog::ALL {
                    let is_chosen = matches!(model, Ior::Catalog(chosen) if chosen.name == entry.name);
                    let button = Button::selectable(is_chosen, entry.label)
                        .right_text(RichText::new(format!("{:.4}", entry.ior())).monospace().small())
                        .min_size(vec2(170.0, 0.0));
                    let response = ui.add(button).accessible_name(entry.label).on_hover_text(entry.source);
                    if response.clicked() {
                        commands.push(Command::set_ior(medium.clone(), Ior::Catalog(entry)));
                    }
                }
            },
        );
    });
    let absorption = match medium {
        MediumRef::World => description.world.absorption,
        MediumRef::Named(name) => description.medium(name).map(|m| m.absorption).unwrap_or_default(),
    };
    let about = "Absorption σ per scene unit for red, green and blue: light falls off as exp(−σ × distance).";
    row_ui(ui, "Absorption", about, |ui| {
        let mut edited = absorption;
        let width = (ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0;
        let mut is_changed = false;
        for (value, color) in edited.iter_mut().zip(["red", "green", "blue"]) {
            let drag = DragValue::new(value).speed(0.002).range(0.0..=1e6).max_decimals(3);
            let label = format!("Absorption of {color} in {}", medium.name());
            is_changed |= number_ui(ui, width, drag, label, format!("{about}\nThis one is {color}."));
        }
        if is_changed && edited != absorption {
            commands.push(Command::Edit(Edit::Medium(medium.clone(), MediumEdit::Absorption(edited))));
        }
    });
    let users: Vec<&str> = match medium {
        MediumRef::World => Vec::new(),
        MediumRef::Named(name) => (description.objects.iter())
            .filter(|o| o.refractor().is_some_and(|r| r.medium == *name))
            .map(|r| r.name.as_str())
            .collect(),
    };
    if users.len() > 1 {
        let text = note(ui, format!("Shared by {} objects: {}.", users.len(), users.join(", ")));
        ui.add(egui::Label::new(text).truncate()).on_hover_text(users.join("\n"));
    }
}

/// The colour that stands for a medium.
pub fn color(palette: &Palette, description: &Description, medium: &str) -> egui::Color32 {
    match description.media.iter().position(|m| m.name == medium) {
        Some(index) => palette.medium(index),
        None => palette.world(),
    }
}
