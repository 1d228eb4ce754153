//! The controls of one object: whether it is shown, its priority, and where it stands.

use egui::{DragValue, Ui};

use crate::app::command::Command;
use crate::app::edit::ObjectEdit;
use crate::app::objects::{self, Manipulation};
use crate::app::widgets::{Triple, XYZ, note, number_ui, row_ui, vector_ui, whole_ui};
use crate::scene::description::{Object, Shape, Transform};

/// Decimals that are shown; what was typed is kept in full.
const DECIMALS: usize = 3;

/// Rows for everything about an object that is not its medium or its colour.
pub fn show(ui: &mut Ui, object: &Object, commands: &mut Vec<Command>) {
    let name = &object.name;
    let about = "Whether it is there at all: a hidden object is hit by nothing and contains nothing (V).";
    row_ui(ui, "Shown", about, |ui| {
        let mut visible = object.visible;
        let label = format!("Show {name}");
        if ui.checkbox(&mut visible, "").accessible_name(label).on_hover_text(about).changed() {
            commands.push(Command::object(name.to_owned(), ObjectEdit::Visible(visible)));
        }
        if !object.visible {
            ui.label(note(ui, "hidden"));
        }
    });
    if let Some(priority) = object.refractor().map(|refractor| refractor.priority) {
        let about = "Which refractor's medium is there where volumes overlap: the one with the higher number. Any whole number; where \
                     two are equal the smaller volume wins.";
        row_ui(ui, "Priority", about, |ui| {
            let mut edited = priority;
            let drag = DragValue::new(&mut edited).speed(0.05);
            let range = i64::from(i32::MIN)..=i64::from(i32::MAX);
            if whole_ui(ui, 64.0, range, drag, format!("Priority of {name}"), about) && edited != priority {
                commands.push(Command::object(name.to_owned(), ObjectEdit::Priority(edited)));
            }
            ui.label(note(ui, "higher wins"));
        });
    }
    transform_ui(ui, object, commands);
}

fn transform_ui(ui: &mut Ui, object: &Object, commands: &mut Vec<Command>) {
    let Object { name, shape, transform, .. } = object;
    let transform = *transform;
    let pivot = objects::pivot(shape);
    let (min, max) = objects::bounds(shape);
    // A light without a surface has no size; one from afar has no place either.
    let has_surface = shape.has_surface();
    let place = transform.matrix().transform_point3(pivot);
    let size = if has_surface { ((max - min) * transform.scale).length() } else { place.length().max(1.0) };
    let mut set = |manipulation, transform: Transform| {
        commands.push(Command::object(name.to_owned(), ObjectEdit::Transform(manipulation, transform)));
    };
    let about = "Translation in scene units; it comes after scale and rotation.";
    let label = format!("Move {name} along");
    let triple = Triple { speeds: [0.004 * size.max(1e-9); 3], ..Triple::new(XYZ, &label, about) };
    if !matches!(shape, Shape::Directional { .. }) {
        row_ui(ui, "Move", about, |ui| {
            if let Some(translate) = vector_ui(ui, &triple, transform.translate) {
                set(Manipulation::Move, Transform { translate, ..transform });
            }
        });
    }
    let about = "Degrees about the fixed axes x, y and z, in this order. The middle of the object stays where it is.";
    let label = format!("Rotate {name} along");
    let triple = Triple { speeds: [0.5; 3], suffix: "°", ..Triple::new(XYZ, &label, about) };
    row_ui(ui, "Rotate", about, |ui| {
        if let Some(rotate) = vector_ui(ui, &triple, transform.rotate) {
            set(Manipulation::Rotate, objects::rotated_to(&transform, rotate, pivot));
        }
    });
    if !has_surface {
        return;
    }
    if matches!(shape, Shape::Sphere { .. }) {
        let about = "Factor of size, not 0. A sphere is analytic and keeps its shape: one factor for all axes. An icosphere can be stretched.";
        row_ui(ui, "Scale", about, |ui| {
            let before = transform.scale.abs().x;
            let mut factor = before;
            let drag = scale_drag(&mut factor, before);
            if number_ui(ui, 64.0, drag, format!("Scale {name}"), about) && factor != before {
                // Mirrored axes stay mirrored; a typed sign turns all of them over.
                let scale = transform.scale.signum() * factor;
                set(Manipulation::Scale, objects::scaled_to(&transform, scale, pivot));
            }
            ui.label(note(ui, "all axes"));
        });
        return;
    }
    let about = "Factors along the object's own axes, not 0; a negative one mirrors. The middle of the object stays where it is.";
    let id = ui.scope_id().with("linked");
    let mut is_linked = ui.data(|data| data.get_temp(id)).unwrap_or(false);
    row_ui(ui, "Scale", about, |ui| {
        let button = egui::Button::selectable(is_linked, "=").frame_when_inactive(true);
        let label = format!("Scale {name} along");
        // Dragged by parts of themselves, and so never through 0.
        let speeds = transform.scale.to_array().map(|factor| 0.005 * factor.abs().max(1e-6));
        let triple = Triple { speeds, ..Triple::new(XYZ, &label, about) };
        let reserved = 22.0 + ui.spacing().item_spacing.x;
        let changed = triple.show(ui, transform.scale.to_array(), reserved);
        let tip = "Keep the proportions: a change of one factor changes all three alike.";
        let response = ui.add_sized([22.0, ui.spacing().interact_size.y], button);
        if response.accessible_name("Keep the proportions").on_hover_text(tip).clicked() {
            is_linked = !is_linked;
        }
        if let Some((axis, edited)) = changed {
            let scale = if is_linked {
                let mut all = transform.scale * (edited[axis] / transform.scale[axis]);
                all[axis] = edited[axis];
                all
            } else {
                edited.into()
            };
            set(Manipulation::Scale, objects::scaled_to(&transform, scale, pivot));
        }
    });
    ui.data_mut(|data| data.insert_temp(id, is_linked));
}

/// A factor that is dragged by parts of itself, and so never through 0.
fn scale_drag(factor: &mut f64, before: f64) -> DragValue<'_> {
    let speed = 0.005 * before.abs().max(1e-6);
    // Typed, any sign will do; dragging stops short of 0.
    DragValue::new(factor).speed(speed).max_decimals(DECIMALS)
}
