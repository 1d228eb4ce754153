//! The controls of the slice that panes show: which way it faces, where it lies, and what it goes through.

use egui::{DragValue, Slider, SliderClamping, Ui};
use glam::DVec3;

use crate::app::command::Command;
use crate::app::settings::PaneContent;
use crate::app::slice::{Facing, Placed, SliceView};
use crate::app::state::State;
use crate::app::widgets::{note, number_ui, section_ui, segmented_row_ui};

const ABOUT_FACING: &str = "Which way the slice faces.";

/// Whether some pane shows a slice.
pub fn is_shown(state: &State) -> bool {
    state.settings.shown_panes().iter().any(|content| matches!(content, PaneContent::Slice(_)))
}

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    section_ui(ui, "Slice", "");
    let Some(placed) = state.placed_slice() else {
        ui.label(note(ui, "There is no scene to cut yet."));
        return;
    };
    let Placed { view, range, .. } = placed;
    facing_ui(ui, &placed, commands);
    offset_ui(ui, view, range, commands);
    let through = |ui: &mut Ui, text: &str, about: &str, why_not: &str, to: Option<SliceView>| {
        let button = egui::Button::new(text).min_size(egui::vec2(ui.available_width(), 0.0));
        let response = ui.add_enabled(to.is_some(), button).on_hover_text(about).on_disabled_hover_text(why_not);
        to.filter(|_| response.clicked()).map(Command::SetSlice)
    };
    commands.extend(through(
        ui,
        "Through the selected object",
        "Moves the slice to the middle of the selected object.",
        "Select an object first: in the tree, or with Ctrl + click in a picture.",
        state.slice_through_selected(),
    ));
    commands.extend(through(
        ui,
        "Through the inspected path",
        "Turns the slice so that the inspected pixel's ray lies in it, and the rest of its path as well as can be.",
        "Inspect a pixel first: click in a picture.",
        state.slice_through_path(),
    ));
    let whole = SliceView { zoom: 1.0, pan: DVec3::ZERO, ..view };
    commands.extend(through(
        ui,
        "All of it",
        "Shows all refractors again.",
        "All refractors are seen.",
        Some(whole).filter(|whole| *whole != view),
    ));
    ui.label(note(
        ui,
        "In the slice: drag to move the picture, wheel or Shift + drag to move the plane, Ctrl + wheel to zoom.",
    ));
}

fn facing_ui(ui: &mut Ui, placed: &Placed, commands: &mut Vec<Command>) {
    #[derive(Clone, Copy, PartialEq)]
    enum Choice {
        X,
        Y,
        Z,
        Camera,
        Path,
    }
    let shown = match placed.view.facing {
        Facing::X => Choice::X,
        Facing::Y => Choice::Y,
        Facing::Z => Choice::Z,
        Facing::Camera => Choice::Camera,
        Facing::Path { .. } => Choice::Path,
    };
    let choices = [
        (Choice::X, "X", "Across the x axis."),
        (Choice::Y, "Y", "Across the y axis: a plan."),
        (Choice::Z, "Z", "Across the z axis."),
        (Choice::Camera, "Camera", "Facing the camera, wherever it goes."),
    ];
    let Some(chosen) = segmented_row_ui(ui, "Facing", ABOUT_FACING, shown, &choices) else { return };
    let facing = match chosen {
        Choice::X => Facing::X,
        Choice::Y => Facing::Y,
        Choice::Z => Facing::Z,
        Choice::Camera | Choice::Path => Facing::Camera,
    };
    // Through the same place.
    let center = placed.plane.center;
    let offset = match facing {
        Facing::X => center.x,
        Facing::Y => center.y,
        Facing::Z => center.z,
        Facing::Camera | Facing::Path { .. } => 0.0,
    };
    commands.push(Command::SetSlice(SliceView { facing, offset, ..placed.view }));
}

fn offset_ui(ui: &mut Ui, view: SliceView, range: [f64; 2], commands: &mut Vec<Command>) {
    const VALUE: f32 = 64.0;
    let name = view.facing.offset_name();
    let label = format!("Slice at {name}");
    let about = match view.facing {
        Facing::X | Facing::Y | Facing::Z => format!("The slice lies where {name} is this, in scene units."),
        Facing::Camera => "Distance from what the camera looks at, in scene units, towards the camera.".to_owned(),
        Facing::Path { .. } => "Distance from the inspected path, in scene units.".to_owned(),
    };
    let (low, high) = (range[0].min(view.offset), range[1].max(view.offset));
    let mut offset = view.offset;
    ui.horizontal(|ui| {
        ui.label(name).on_hover_text(&about);
        ui.spacing_mut().slider_width = (ui.available_width() - VALUE - ui.spacing().item_spacing.x).max(40.0);
        let step = (high - low) / 200.0;
        let slider = Slider::new(&mut offset, low..=high).show_value(false).clamping(SliderClamping::Never);
        let height = std::mem::replace(&mut ui.spacing_mut().interact_size.y, 16.0);
        let is_dragged = ui.add(slider).accessible_name(&label).on_hover_text(&about).changed();
        ui.spacing_mut().interact_size.y = height;
        let typed = DragValue::new(&mut offset).speed(step).max_decimals(4);
        let is_typed = number_ui(ui, VALUE, typed, &label, &about);
        if (is_dragged || is_typed) && offset != view.offset {
            commands.push(Command::SetSlice(SliceView { offset, ..view }));
        }
    });
}
