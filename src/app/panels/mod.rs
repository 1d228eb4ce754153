//! The panels around the pictures, one per file. They read the state and return commands.

pub mod about;
mod add;
mod backend;
mod camera;
mod declared;
pub mod dialogs;
mod environment;
mod estimator;
mod gallery;
mod histogram;
mod inspector;
mod light;
mod measure;
mod medium;
mod menu_bar;
mod messages;
mod notices;
mod object;
mod outside;
mod priorities;
mod problems;
mod range;
mod recovery;
mod rectification;
mod render;
mod role;
mod scene_tree;
mod shape;
mod shortcuts;
mod sides;
mod slice;
mod snapshots;
mod status;
mod tour;
mod world;

use egui::{CentralPanel, Frame, Margin, Panel, ScrollArea, Ui};

use self::dialogs::Dialogs;
use self::tour::Part;
use super::command::Command;
use super::modal;
use super::settings::Tab;
use super::state::{OutsideChange, State};
use super::viewport::Viewport;
use super::widgets::segmented_ui;

/// The tabs of the right panel: name and what is in it.
const TABS: [(Tab, &str, &str); 4] = [
    (Tab::Render, "Render", "Panes, display, quality, progress and events."),
    (Tab::Rectification, "Interfaces", "What rectification found on the other side of every refractor."),
    (Tab::Inspector, "Inspector", "The path of a pixel, vertex by vertex. Click a picture to choose the pixel."),
    (Tab::Measure, "Measure", "Error against time for every mode that is shown."),
];

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
    let ctx = ui.ctx().clone();
    let menus = Panel::top("menu").frame(bar).show(ui, |ui| menu_bar::show(ui, state, commands));
    tour::mark(&ctx, Part::Menus, menus.response.rect);
    let strip = Frame::new().fill(ui.visuals().faint_bg_color).inner_margin(Margin::symmetric(10, 4));
    if !state.left_behind.is_empty() {
        Panel::top("recovery").frame(strip).show(ui, |ui| recovery::show(ui, state, commands));
    }
    if state.outside_change == Some(OutsideChange::Offered) {
        Panel::top("outside").frame(strip).show(ui, |ui| outside::show(ui, state, commands));
    }
    Panel::bottom("status").frame(bar).show(ui, |ui| status::show(ui, state, viewport, commands));
    let is_pressed = ui.input(|input| input.pointer.any_down());
    if state.problem_strip(is_pressed) {
        Panel::bottom("problems").frame(strip).show(ui, |ui| problems::show(ui, state, commands));
    }
    sides::show(ui, state, viewport, commands);
    let pictures = CentralPanel::no_frame().show(ui, |ui| {
        let room = ui.max_rect();
        viewport.show(ui, state, commands);
        notices::show(ui, state, viewport.labels(), commands);
        room
    });
    sides::drawer(ui, pictures.inner, state, viewport, commands);
    tour::mark(&ctx, Part::Pictures, pictures.response.rect);
    tour::show(&ctx, state, commands);
    add::show(ui.ctx(), state, commands);
    gallery::show(ui.ctx(), state, commands);
    shortcuts::show(ui.ctx(), state, commands);
    about::show(ui.ctx(), state, commands);
    messages::show(ui.ctx(), state, commands);
    dialogs.show(ui.ctx(), state, commands);
    if ui.ctx().input(|input| !input.raw.hovered_files.is_empty()) {
        notices::drop_hint_ui(ui.ctx());
    }
}

fn tabs_ui(ui: &mut Ui, state: &State, viewport: &Viewport, commands: &mut Vec<Command>) {
    if let Some(tab) = segmented_ui(ui, state.settings.tab, &TABS) {
        commands.push(Command::ShowTab(tab));
    }
    ui.add_space(8.0);
    let area = ScrollArea::vertical().id_salt(state.settings.tab as u8).auto_shrink(false);
    modal::scroll_ui(ui, area, |ui| {
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
