//! What a medium absorbs: σ itself, and the colour that light has after some distance, either of which gives the other.

use egui::{Id, Rect, Sense, TextStyle, Ui, vec2};

use crate::app::command::{Command, MediumRef};
use crate::app::edit::{Edit, MediumEdit};
use crate::app::entry;
use crate::app::objects::rounded;
use crate::app::text_field::{TextField, refusal_ui};
use crate::app::theme::opaque;
use crate::app::widgets::{RGB, Triple, color_ui, note, row_ui};

/// The least that a colour lets through: σ stays finite.
const LEAST: f64 = 1e-4;
const ABOUT: &str = "Absorption σ per scene unit for red, green and blue: light falls off as exp(−σ × distance). Scenes do not say how long \
                     their unit is, so units such as /cm mean nothing here.";
const ABOUT_COLOR: &str = "The share of red, green and blue light that is left after the distance below: exp(−σ × distance). Editing it sets σ.";

/// The share of light that is left after `distance`.
pub fn transmittance(absorption: [f64; 3], distance: f64) -> [f64; 3] {
    absorption.map(|sigma| (-sigma * distance).exp())
}

/// The σ of which `color` is left after `distance`.
pub fn absorption_of(color: [f64; 3], distance: f64) -> [f64; 3] {
    color.map(|share| rounded((-share.clamp(LEAST, 1.0).ln() / distance).max(0.0), 1e-6))
}

pub fn show(ui: &mut Ui, medium: &MediumRef, absorption: [f64; 3], commands: &mut Vec<Command>) {
    let name = medium.name();
    let mut set =
        |new: [f64; 3]| commands.push(Command::Edit(Edit::Medium(medium.clone(), MediumEdit::Absorption(new))));
    row_ui(ui, "Absorption", ABOUT, |ui| {
        let label = format!("Absorption in {name} of");
        let triple = Triple { speeds: [0.002; 3], range: 0.0..=1e6, ..Triple::new(RGB, &label, ABOUT) };
        if let Some(new) = color_ui(ui, &triple, absorption) {
            set(new);
        }
    });
    let id = Id::unique(("distance of colour", name));
    let distance: f64 = ui.data(|data| data.get_temp(id)).unwrap_or(1.0);
    let color = transmittance(absorption, distance);
    row_ui(ui, "Colour", ABOUT_COLOR, |ui| {
        let label = format!("Colour through {name}:");
        let triple = Triple { speeds: [0.004; 3], range: LEAST..=1.0, ..Triple::new(RGB, &label, ABOUT_COLOR) };
        if let Some((index, new)) = triple.show(ui, color, 0.0) {
            // The others keep their digits.
            let mut edited = absorption;
            edited[index] = absorption_of(new, distance)[index];
            set(edited);
        }
    });
    let refusal = row_ui(ui, "after", "The distance, in scene units, after which light has the colour above.", |ui| {
        let shown = format!("{distance}");
        let field = TextField {
            id: id.with("field"),
            shown: &shown,
            name: format!("Distance of the colour through {name}"),
            about: "A distance in scene units: a number or a calculation.".to_owned(),
            width: 70.0,
            align: egui::Align::Min,
            style: TextStyle::Monospace,
        };
        let typed = field.show(ui, entry::distance);
        if let Some(distance) = typed.taken {
            ui.data_mut(|data| data.insert_temp(id, distance));
        }
        ui.label(note(ui, "units"));
        let (rect, _) =
            ui.allocate_exact_size(vec2(ui.available_width(), ui.spacing().interact_size.y), Sense::hover());
        paint_depth(ui, rect, absorption, distance);
        typed.refusal
    });
    if let Some(refusal) = refusal {
        refusal_ui(ui, &refusal, &format!("{distance}"));
    }
}

/// White light as it goes through the medium, from the surface at the left to `distance` at the right.
fn paint_depth(ui: &Ui, rect: Rect, absorption: [f64; 3], distance: f64) {
    const STEPS: usize = 24;
    let rect = rect.shrink2(vec2(0.0, 4.0));
    let display = crate::render::Display::default();
    for step in 0..STEPS {
        let share = step as f64 / (STEPS - 1) as f64;
        let color = opaque(display.encode(transmittance(absorption, share * distance).map(|c| c as f32)));
        let left = rect.left() + rect.width() * step as f32 / STEPS as f32;
        let right = rect.left() + rect.width() * (step + 1) as f32 / STEPS as f32;
        let piece = Rect::from_x_y_ranges(left..=right + 0.5, rect.y_range());
        ui.painter().rect_filled(piece, 0.0, color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_and_absorption_give_each_other() {
        for distance in [0.1, 1.0, 7.5] {
            let sigma = [0.0, 0.3, 2.0];
            let back = absorption_of(transmittance(sigma, distance), distance);
            // Where less is left than a colour can say, σ is the largest that it can.
            let most = -LEAST.ln() / distance;
            for (got, wanted) in back.into_iter().zip(sigma) {
                assert!((got - wanted.min(most)).abs() < 1e-6, "{got}, not {wanted}, at {distance}");
            }
        }
        // Half of the light is left after ln 2 / σ.
        assert!((transmittance([2.0; 3], 2.0_f64.ln() / 2.0)[0] - 0.5).abs() < 1e-15);
        assert!(absorption_of([0.0, -1.0, 2.0], 1.0).iter().all(|sigma| sigma.is_finite() && *sigma >= 0.0));
    }
}
