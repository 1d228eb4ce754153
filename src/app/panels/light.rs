//! The colour and the strength of a light.

use egui::{DragValue, Ui};

use super::role::color_row_ui;
use crate::app::command::Command;
use crate::app::edit::ObjectEdit;
use crate::app::widgets::{fact_ui, number_within_ui, row_ui, segmented_row_ui};
use crate::scene::description::{Emission, Light, Object, Quantity, Shape};
use crate::scene::emission::{area, power_of_unit};

/// Rows for a light.
pub fn show(ui: &mut Ui, object: &Object, light: &Light, commands: &mut Vec<Command>) {
    let name = &object.name;
    let Emission { quantity, rgb } = light.emission;
    let strength = rgb.into_iter().fold(0.0, f64::max);
    // A light that is off has no colour; it comes back white.
    let color = if strength > 0.0 { rgb.map(|x| x / strength) } else { [1.0; 3] };
    let mut set = |emission| commands.push(Command::object(name, ObjectEdit::Emission(emission)));
    let about = "Colour of the light, linear; the strongest of the three is 1.";
    let shown = color.map(|x| (x * 1e6).round() / 1e6);
    if let Some(new) = color_row_ui(ui, "Colour", &format!("Colour of {name}"), about, shown)
        && new.iter().any(|x| *x > 0.0)
    {
        let most = new.into_iter().fold(0.0, f64::max);
        set(Emission { quantity, rgb: new.map(|x| x / most * strength) });
    }
    let own = object.shape.quantity();
    if own != Quantity::Irradiance {
        let about = "What the strength says. The other one follows from the light's size and shape.";
        let kinds = [(own, word(own), tip(own)), (Quantity::Power, word(Quantity::Power), tip(Quantity::Power))];
        if let Some(chosen) = segmented_row_ui(ui, "Given by", about, quantity, &kinds)
            && chosen != quantity
        {
            set(converted(object, light, chosen));
        }
    }
    row_ui(ui, "Strength", tip(quantity), |ui| {
        let mut edited = strength;
        let drag = DragValue::new(&mut edited).speed((0.01 * strength).max(0.01)).max_decimals(4);
        let label = format!("Strength of {name}");
        if number_within_ui(ui, 84.0, 0.0..=1e100, drag, label, tip(quantity)) && edited != strength {
            set(Emission { quantity, rgb: color.map(|x| x * edited) });
        }
        ui.label(crate::app::widgets::note(ui, unit(quantity)));
    });
    if object.shape.has_surface() {
        let about = "Whether it emits from its inward side too, such as both sides of a quad.";
        row_ui(ui, "Two sides", about, |ui| {
            let mut two_sided = light.two_sided;
            let label = format!("Two sides of {name}");
            if ui.checkbox(&mut two_sided, "").accessible_name(label).on_hover_text(about).changed() {
                commands.push(Command::object(name, ObjectEdit::TwoSided(two_sided)));
            }
        });
    }
    let is_quick = !object.shape.has_surface() || matches!(object.shape, Shape::Sphere { .. } | Shape::Quad { .. });
    if own != Quantity::Irradiance && is_quick {
        let other = if quantity == Quantity::Power { own } else { Quantity::Power };
        let values = converted(object, light, other).rgb.map(short).join(" · ");
        fact_ui(ui, word(other), format!("{values} {}", unit(other)), tip(other));
    }
}

/// The same light measured by another quantity; where it has no area the numbers stay.
fn converted(object: &Object, light: &Light, to: Quantity) -> Emission {
    let Emission { quantity, rgb } = light.emission;
    let per_unit = power_of_unit(&object.shape, light.two_sided, area(object));
    let factor = match (quantity, to) {
        (Quantity::Power, Quantity::Power) => 1.0,
        (Quantity::Power, _) => 1.0 / per_unit,
        (_, Quantity::Power) => per_unit,
        _ => 1.0,
    };
    let factor = if factor.is_finite() && factor > 0.0 { factor } else { 1.0 };
    Emission { quantity: to, rgb: rgb.map(|x| x * factor) }
}

fn word(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Radiance => "Radiance",
        Quantity::Intensity => "Intensity",
        Quantity::Irradiance => "Irradiance",
        Quantity::Power => "Power",
    }
}

fn unit(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Radiance => "W/(m² sr)",
        Quantity::Intensity => "W/sr",
        Quantity::Irradiance => "W/m²",
        Quantity::Power => "W",
    }
}

fn tip(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Radiance => {
            "Radiance for red, green and blue, in the medium around the light: colour times strength. In W/(m² sr) where a scene unit is a metre."
        }
        Quantity::Intensity => {
            "Intensity for red, green and blue, of a spot along its axis: colour times strength, in W/sr."
        }
        Quantity::Irradiance => {
            "Irradiance for red, green and blue across the light's direction, in the world's medium: colour times strength. In W/m² where a scene unit is a metre."
        }
        Quantity::Power => {
            "All that is emitted for red, green and blue, in W: colour times strength. π × area × radiance of a surface, 4π × intensity of a point."
        }
    }
}

fn short(x: f64) -> String {
    if x == 0.0 || (0.01..1e5).contains(&x) { format!("{x:.2}") } else { format!("{x:.2e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_light_can_be_measured_by_either_quantity() {
        let quad = Shape::Quad { center: DVec3::ONE, edge_u: DVec3::X, edge_v: DVec3::Z * 3.0 };
        let spot = Shape::Spot { position: DVec3::Y, target: DVec3::ZERO, inner_angle: 10.0, outer_angle: 30.0 };
        for shape in [quad, spot, Shape::Point { position: DVec3::ONE }] {
            let own = shape.quantity();
            let mut object = Object::new("l", shape, Light::of(own, [1.0, 2.0, 3.0]));
            let light = object.light().unwrap().clone();
            let power = converted(&object, &light, Quantity::Power);
            assert!(power.quantity == Quantity::Power && power.rgb != light.emission.rgb);
            object.light_mut().unwrap().emission = power;
            let back = converted(&object, object.light().unwrap(), own);
            assert!(back.quantity == own && (back.rgb[2] - 3.0).abs() < 1e-12);
        }
        assert_eq!([0.0, 12.345, 1.5e7].map(short), ["0.00", "12.35", "1.50e7"]);
    }
}
