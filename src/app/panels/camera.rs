//! The scene's own camera: where it stands, its field of view, its lens and what is in focus.

use egui::{Button, DragValue, Label, Ui};

use super::declared;
use crate::app::command::Command;
use crate::app::edit::Edit;
use crate::app::state::State;
use crate::app::widgets::{Triple, XYZ, note, number_within_ui, row_ui, vector_ui};
use crate::scene::description::CameraDescription;

/// Height of the sensor that focal lengths are given for: that of 35 mm film, in mm.
const SENSOR_HEIGHT: f64 = 24.0;
const FIELD: f32 = 74.0;

/// Focal length in mm of a lens with that vertical field of view, in degrees, on a sensor 24 mm high.
pub fn focal_length(vertical_fov: f64) -> f64 {
    0.5 * SENSOR_HEIGHT / (0.5 * vertical_fov).to_radians().tan()
}

/// The inverse of [`focal_length`].
pub fn vertical_fov(focal_length: f64) -> f64 {
    2.0 * (0.5 * SENSOR_HEIGHT / focal_length).atan().to_degrees()
}

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let camera = state.document.description().camera;
    let mut edited = camera;
    let distance = camera.position.distance(camera.target);
    let has_moved = state.view.camera != camera;
    place_ui(ui, &mut edited, distance);
    lens_ui(ui, state, &mut edited, distance, commands);
    declared::camera_ui(ui, state.document.description(), commands);
    if edited != camera {
        if has_moved {
            // What is edited is to be seen.
            commands.push(Command::ResetCamera);
        }
        commands.push(Command::Edit(Edit::Camera(edited)));
    }
    ui.add_space(2.0);
    ui.horizontal(|ui| {
        let about = "Makes the present view the scene's own camera.";
        if ui.add_enabled(has_moved, Button::new("Keep this view")).on_hover_text(about).clicked() {
            commands.push(Command::Edit(Edit::Camera(state.view.camera)));
        }
        let about = "Back to the scene's own camera.";
        if ui.add_enabled(has_moved, Button::new("Back to the camera")).on_hover_text(about).clicked() {
            commands.push(Command::ResetCamera);
        }
    });
    let text = if has_moved { "The view has moved away from the camera." } else { "The view is that of the camera." };
    ui.add(Label::new(note(ui, text)).truncate());
}

/// Position, target and up.
fn place_ui(ui: &mut Ui, camera: &mut CameraDescription, distance: f64) {
    let speed = 0.004 * distance.max(1e-9);
    let rows = [
        ("Position", "Where the camera stands.", &mut camera.position, speed),
        ("Target", "What it looks at, and orbits around.", &mut camera.target, speed),
        ("Up", "The direction that is upwards in the picture.", &mut camera.up, 0.01),
    ];
    for (name, about, vector, speed) in rows {
        row_ui(ui, name, about, |ui| {
            let label = format!("{name} of the camera,");
            let triple = Triple { speeds: [speed; 3], ..Triple::new(XYZ, &label, about) };
            if let Some(new) = vector_ui(ui, &triple, *vector) {
                *vector = new;
            }
        });
    }
}

fn lens_ui(ui: &mut Ui, state: &State, camera: &mut CameraDescription, distance: f64, commands: &mut Vec<Command>) {
    let about = "Vertical field of view, and the focal length that has it on film 24 mm high.";
    row_ui(ui, "View", about, |ui| {
        let mut fov = camera.vertical_fov;
        let drag = DragValue::new(&mut fov).speed(0.1).suffix("°").max_decimals(2);
        let about = "Degrees over the height of the picture.";
        if number_within_ui(ui, FIELD, 0.01..=179.0, drag, "Vertical field of view", about) {
            camera.vertical_fov = fov;
        }
        let before = focal_length(camera.vertical_fov);
        let mut length = before;
        let drag = DragValue::new(&mut length).speed(0.2).suffix(" mm").max_decimals(1);
        let about = "Focal length on film 24 mm high.";
        let is_changed = number_within_ui(ui, FIELD, 0.2..=60_000.0, drag, "Focal length", about);
        if is_changed && length != before {
            camera.vertical_fov = vertical_fov(length);
        }
    });
    let about = "Radius of the lens in scene units. 0 is a pinhole: everything is sharp.";
    row_ui(ui, "Lens radius", about, |ui| {
        let speed = (0.01 * camera.aperture_radius).max(1e-4 * distance);
        let mut radius = camera.aperture_radius;
        let drag = DragValue::new(&mut radius).speed(speed).max_decimals(4);
        if number_within_ui(ui, FIELD, 0.0..=1e9, drag, "Radius of the lens", about) {
            camera.aperture_radius = radius;
        }
        if camera.aperture_radius == 0.0 {
            ui.label(note(ui, "pinhole"));
        }
    });
    let about = "Distance from the lens to the plane that is sharp, in scene units.";
    row_ui(ui, "Focus at", about, |ui| {
        let mut focus = camera.focus_distance.unwrap_or(distance);
        let speed = 0.004 * focus.max(1e-6);
        let drag = DragValue::new(&mut focus).speed(speed).max_decimals(4);
        if number_within_ui(ui, FIELD, 1e-6..=1e9, drag, "Focus distance", about) {
            camera.focus_distance = Some(focus);
        }
        let mut is_on_target = camera.focus_distance.is_none();
        if ui.checkbox(&mut is_on_target, "target").on_hover_text("Keep the target in focus.").changed() {
            camera.focus_distance = if is_on_target { None } else { Some(distance) };
        }
    });
    row_ui(ui, "", "", |ui| {
        let button = Button::selectable(state.is_focusing, "Focus on what I click").frame_when_inactive(true);
        let about = "The next click in a picture puts the focus on what is there. Escape gives it up.";
        if ui.add(button).on_hover_text(about).clicked() {
            commands.push(Command::PickFocus(!state.is_focusing));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn focal_lengths_and_fields_of_view() {
        // A 50 mm lens on 36 mm × 24 mm film sees 27° over the height.
        assert!((vertical_fov(50.0) - 26.99).abs() < 0.01);
        for fov in [1.0, 40.0, 120.0, 179.0] {
            assert!((vertical_fov(focal_length(fov)) - fov).abs() < 1e-9);
        }
    }
}
