//! What belongs to the scene as a whole: the global medium, the environment and the camera, each with a row in the tree and a card.

use egui::{Align, Label, Layout, Rect, RichText, Sense, Ui, UiBuilder, pos2, vec2};

use super::{camera, environment, medium};
use crate::app::command::{Command, MediumRef};
use crate::app::panels::scene_tree::selectable_row_ui;
use crate::app::state::{State, WorldPart};
use crate::app::theme::{Palette, opaque};
use crate::app::widgets::{section_ui, segmented_ui, swatch_ui};
use crate::optics::medium::WORLD;
use crate::scene::description::Environment;

/// The rows of camera, environment and global medium.
pub fn rows_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let description = state.document.description();
    let lens = format!("{:.0}°", description.camera.vertical_fov);
    plain_row_ui(ui, state, WorldPart::Camera, "camera", &lens, None, commands);
    let (kind, color) = environment_in_row(&description.environment);
    plain_row_ui(ui, state, WorldPart::Environment, "environment", kind, color, commands);

    let is_selected = is_selected(state, WorldPart::Medium);
    let (rect, response) = selectable_row_ui(ui, is_selected, WORLD, medium::ROW_HEIGHT);
    let left = rect.shrink2(vec2(4.0, 0.0)).with_max_x(rect.right() - medium::ROW_WIDTH - 8.0);
    let mut contents = ui.new_child(UiBuilder::new().max_rect(left).layout(Layout::left_to_right(Align::Center)));
    swatch_ui(&mut contents, Palette::of(ui).world());
    contents.add(Label::new(WORLD).truncate().sense(Sense::empty()));
    medium::links_ui(&mut contents, description, WORLD);
    let controls =
        Rect::from_min_max(pos2(rect.right() - medium::ROW_WIDTH - 2.0, rect.top()), rect.max - vec2(2.0, 0.0));
    medium::row_ui(ui, controls, description, &MediumRef::World, WORLD, commands);
    if response.on_hover_text("The global medium: what is outside of every object.").clicked() {
        commands.push(select(is_selected, WorldPart::Medium));
    }
}

/// What a row says of the environment, and its colour where it has one.
fn environment_in_row(environment: &Environment) -> (&'static str, Option<[f64; 3]>) {
    match environment {
        Environment::Color(color) => ("colour", Some(*color)),
        Environment::Gradient { horizon, .. } => ("gradient", Some(*horizon)),
        Environment::Image { .. } => ("image", None),
    }
}

fn plain_row_ui(
    ui: &mut Ui,
    state: &State,
    part: WorldPart,
    name: &str,
    detail: &str,
    color: Option<[f64; 3]>,
    commands: &mut Vec<Command>,
) {
    let is_selected = is_selected(state, part);
    let (rect, response) = selectable_row_ui(ui, is_selected, name, ui.spacing().interact_size.y);
    let inner = rect.shrink2(vec2(4.0, 0.0));
    let mut contents = ui.new_child(UiBuilder::new().max_rect(inner).layout(Layout::left_to_right(Align::Center)));
    match color {
        Some(color) => {
            let color = crate::render::Display::default().encode(color.map(|c| c as f32));
            swatch_ui(&mut contents, opaque(color));
        }
        None => contents.add_space(10.0 + contents.spacing().item_spacing.x),
    }
    contents.add(Label::new(name).truncate().sense(Sense::empty()));
    contents.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let weak = RichText::new(detail).small().color(Palette::of(ui).weak_text);
        ui.add(Label::new(weak).truncate().sense(Sense::empty()));
    });
    let about = match part {
        WorldPart::Camera => "The scene's own camera: where it stands, its lens, what is in focus.",
        WorldPart::Environment => "The light that comes from all around.",
        WorldPart::Medium => "",
    };
    if response.on_hover_text(about).clicked() {
        commands.push(select(is_selected, part));
    }
}

fn is_selected(state: &State, part: WorldPart) -> bool {
    state.selected.as_deref() == Some(WORLD) && state.world_part == part
}

fn select(is_selected: bool, part: WorldPart) -> Command {
    if is_selected { Command::SelectObject(None) } else { Command::SelectWorld(part) }
}

pub fn card_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let description = state.document.description();
    section_ui(ui, "World", "");
    let parts = [
        (WorldPart::Medium, "Medium", "The global medium: what is outside of every object."),
        (WorldPart::Environment, "Environment", "The light that comes from all around."),
        (WorldPart::Camera, "Camera", "The scene's own camera."),
    ];
    if let Some(part) = segmented_ui(ui, state.world_part, &parts) {
        commands.push(Command::SelectWorld(part));
    }
    ui.add_space(4.0);
    match state.world_part {
        WorldPart::Medium => medium::world_ui(ui, description, commands),
        WorldPart::Environment => environment::show(ui, &description.environment, commands),
        WorldPart::Camera => camera::show(ui, state, commands),
    }
}
