//! The panels around the pictures, one per file. They read the state and return commands.

pub mod about;
pub mod dialogs;
mod gallery;
mod inspector;
mod measure;
mod medium;
mod menu_bar;
mod notices;
mod object;
mod problems;
mod recovery;
mod rectification;
mod render;
mod scene_tree;
mod shortcuts;
mod status;

use egui::{CentralPanel, Frame, Margin, Panel, ScrollArea, Ui};

use self::dialogs::Dialogs;
use super::command::Command;
use super::settings::Tab;
use super::state::State;
use super::theme::{RENDER_PANEL_WIDTH, SCENE_PANEL_WIDTH};
use super::viewport::Viewport;
use super::widgets::segmented_ui;

/// A side panel is left out where the pictures would have less than this width, in points.
const LEAST_VIEWPORT: f32 = 320.0;

/// The whole window.
pub fn show(
    ui: &mut Ui,
    state: &mut State,
    dialogs: &mut Dialogs,
    viewport: &mut Viewport,
    commands: &mut Vec<Command>,
) {
    let fill = ui.visuals().panel_fill;
    let bar = Frame::new().fill(fill).inner_margin(Margin::symmetric(8, 3));
    Panel::top("menu").frame(bar).show(ui, |ui| menu_bar::show(ui, state, commands));
    let strip = Frame::new().fill(ui.visuals().faint_bg_color).inner_margin(Margin::symmetric(10, 4));
    if !state.left_behind.is_empty() {
        Panel::top("recovery").frame(strip).show(ui, |ui| recovery::show(ui, state, commands));
    }
    Panel::bottom("status").frame(bar).show(ui, |ui| status::show(ui, state, viewport, commands));
    let is_pressed = ui.input(|input| input.pointer.any_down());
    if state.problem_strip(is_pressed) {
        Panel::bottom("problems").frame(strip).show(ui, |ui| problems::show(ui, state, commands));
    }
    let width = ui.available_width();
    let has_scene = state.settings.show_scene_panel && width > SCENE_PANEL_WIDTH + LEAST_VIEWPORT;
    let left = if has_scene { SCENE_PANEL_WIDTH } else { 0.0 };
    let has_render = state.settings.show_render_panel && width > left + RENDER_PANEL_WIDTH + LEAST_VIEWPORT;
    let side = Frame::new().fill(fill).inner_margin(Margin { left: 10, right: 6, top: 8, bottom: 8 });
    let sizes = 220.0..=(width * 0.4).max(221.0);
    if has_scene {
        let panel = Panel::left("scene").frame(side).default_size(SCENE_PANEL_WIDTH).size_range(sizes.clone());
        panel.show(ui, |ui| scene_tree::show(ui, state, commands));
    }
    if has_render {
        let panel = Panel::right("render").frame(side).default_size(RENDER_PANEL_WIDTH).size_range(sizes);
        panel.show(ui, |ui| tabs_ui(ui, state, viewport, commands));
    }
    CentralPanel::no_frame().show(ui, |ui| {
        viewport.show(ui, state, commands);
        notices::show(ui, state, commands);
    });
    gallery::show(ui.ctx(), state, commands);
    shortcuts::show(ui.ctx(), state, commands);
    about::show(ui.ctx(), state, commands);
    dialogs.show(ui.ctx(), state, commands);
    if ui.ctx().input(|input| !input.raw.hovered_files.is_empty()) {
        notices::drop_hint_ui(ui.ctx());
    }
}

fn tabs_ui(ui: &mut Ui, state: &State, viewport: &Viewport, commands: &mut Vec<Command>) {
    let tabs = [
        (Tab::Render, "Render", "Panes, display, quality, progress and events."),
        (Tab::Rectification, "Interfaces", "What rectification found on the other side of every refractor."),
        (Tab::Inspector, "Inspector", "The path of a pixel, vertex by vertex. Click a picture to choose the pixel."),
        (Tab::Measure, "Measure", "Error against time for every mode that is shown."),
    ];
    if let Some(tab) = segmented_ui(ui, state.settings.tab, &tabs) {
        commands.push(Command::ShowTab(tab));
    }
    ui.add_space(8.0);
    ScrollArea::vertical().id_salt(state.settings.tab as u8).auto_shrink(false).show(ui, |ui| {
        // Room for the scroll bar.
        ui.set_max_width(ui.available_width() - 4.0);
        match state.settings.tab {
            Tab::Render => render::show(ui, state, viewport, commands),
            Tab::Rectification => rectification::show(ui, state, commands),
            Tab::Inspector => inspector::show(ui, state, commands),
            Tab::Measure => measure::show(ui, state, commands),
        }
    });
}
