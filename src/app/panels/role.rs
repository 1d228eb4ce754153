//! What an object is to light: the paint of a solid, the colour and strength of a light.

use egui::{DragValue, Ui};

use crate::app::command::Command;
use crate::app::edit::ObjectEdit;
use crate::app::widgets::{RGB, Triple, color_ui, fact_ui, number_ui, number_within_ui, row_ui, segmented_row_ui};
use crate::scene::description::{Light, Object, Paint, Role, Shape, Solid};

/// Rows for a solid or a light.
pub fn show(ui: &mut Ui, object: &Object, commands: &mut Vec<Command>) {
    match &object.role {
        Role::Refractor(_) => {}
        Role::Solid(solid) => solid_ui(ui, &object.name, solid, commands),
        Role::Light(light) => light_ui(ui, object, light, commands),
    }
}

/// A colour, linear RGB, to pick or to type. Gives back what is new.
fn color_row_ui(ui: &mut Ui, row: &str, label: &str, about: &str, color: [f64; 3]) -> Option<[f64; 3]> {
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

fn solid_ui(ui: &mut Ui, name: &str, solid: &Solid, commands: &mut Vec<Command>) {
    let mut set = |paint| commands.push(Command::object(name, ObjectEdit::Paint(paint)));
    let (plain, first) = match solid.paint {
        Paint::Color(color) => (true, color),
        Paint::Checker { a, .. } => (false, a),
    };
    let kinds = [(true, "Colour", "One colour everywhere."), (false, "Checker", "Squares of two colours.")];
    if let Some(is_plain) = segmented_row_ui(ui, "Paint", "What the surface reflects.", plain, &kinds)
        && is_plain != plain
    {
        let darker = first.map(|x| (0.6 * x * 1e4).round() / 1e4);
        set(if is_plain { Paint::Color(first) } else { Paint::Checker { a: first, b: darker, size: 0.5 } });
    }
    let about = "Share of red, green and blue that is reflected, from 0 to 1, linear.";
    match solid.paint {
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

fn light_ui(ui: &mut Ui, object: &Object, light: &Light, commands: &mut Vec<Command>) {
    let name = &object.name;
    let strength = light.radiance.into_iter().fold(0.0, f64::max);
    // A light that is off has no colour; it comes back white.
    let color = if strength > 0.0 { light.radiance.map(|x| x / strength) } else { [1.0; 3] };
    let mut set = |radiance| commands.push(Command::object(name, ObjectEdit::Radiance(radiance)));
    let about = "Colour of the light, linear; the strongest of the three is 1.";
    let shown = color.map(|x| (x * 1e6).round() / 1e6);
    if let Some(new) = color_row_ui(ui, "Colour", &format!("Colour of {name}"), about, shown)
        && new.iter().any(|x| *x > 0.0)
    {
        let most = new.into_iter().fold(0.0, f64::max);
        set(new.map(|x| x / most * strength));
    }
    let about = "Radiance of the strongest colour. Radiance is colour times strength.";
    row_ui(ui, "Strength", about, |ui| {
        let mut edited = strength;
        let drag = DragValue::new(&mut edited).speed((0.01 * strength).max(0.01)).max_decimals(4);
        let label = format!("Strength of {name}");
        if number_within_ui(ui, 84.0, 0.0..=1e100, drag, label, about) && edited != strength {
            set(color.map(|x| x * edited));
        }
    });
    if let Some(area) = area(object) {
        let power = light.radiance.map(|l| std::f64::consts::PI * area * l);
        let about = "Emitted power for red, green and blue: π × area × radiance, in W where a scene unit is a metre and radiance is in W/(m² sr).";
        fact_ui(ui, "Power", power.map(short).join(" · "), about);
    }
}

fn short(x: f64) -> String {
    if x == 0.0 || (0.01..1e5).contains(&x) { format!("{x:.2}") } else { format!("{x:.2e}") }
}

/// The surface that emits, in square scene units, where that is a formula.
fn area(object: &Object) -> Option<f64> {
    let transform = &object.transform;
    match object.shape {
        Shape::Sphere { radius, .. } => {
            let radius = radius * transform.scale.abs().x;
            Some(4.0 * std::f64::consts::PI * radius * radius)
        }
        Shape::Quad { edge_u, edge_v, .. } => {
            let matrix = transform.matrix().matrix3;
            Some((matrix * edge_u).cross(matrix * edge_v).length())
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::Transform;
    use glam::DVec3;

    #[test]
    fn areas_follow_the_scale() {
        let light = |shape, scale| {
            let mut object = Object::new("l", shape, Light { radiance: [1.0; 3] });
            object.transform = Transform { scale, rotate: DVec3::new(10.0, 20.0, 30.0), ..Transform::IDENTITY };
            area(&object)
        };
        let ball = light(Shape::Sphere { center: DVec3::ONE, radius: 0.5 }, DVec3::splat(2.0)).unwrap();
        assert!((ball - 4.0 * std::f64::consts::PI).abs() < 1e-12);
        let quad = Shape::Quad { center: DVec3::ONE, edge_u: DVec3::X, edge_v: DVec3::Z * 3.0 };
        assert!((light(quad, DVec3::new(2.0, 9.0, 5.0)).unwrap() - 30.0).abs() < 1e-12);
        assert_eq!([0.0, 12.345, 1.5e7].map(short), ["0.00", "12.35", "1.50e7"]);
    }
}
