//! The line at the bottom: what the pointer does, and how the rendering goes.

use std::time::Duration;

use egui::{Align, Layout, ProgressBar, RichText, Ui};

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::theme::Palette;
use crate::app::viewport::{Viewport, pixel_at};
use crate::app::widgets::value;

/// The hint, longest first: the longest that fits is shown.
const HINTS: [&str; 4] = [
    "drag: orbit   ·   right drag: pan   ·   wheel: dolly   ·   Ctrl + wheel: zoom   ·   click: inspect   ·   Ctrl + click: select   ·   ?: all shortcuts",
    "drag: orbit   ·   right drag: pan   ·   wheel: dolly   ·   Ctrl + wheel: zoom   ·   click: inspect   ·   ?: all shortcuts",
    "drag: orbit   ·   right drag: pan   ·   wheel: dolly   ·   ?: all shortcuts",
    "?: shortcuts",
];

/// A preparation that has taken so long is shown.
const PATIENCE: Duration = Duration::from_millis(500);
/// Time between two looks at it.
const INTERVAL: Duration = Duration::from_millis(100);

pub fn show(ui: &mut Ui, state: &State, viewport: &Viewport, commands: &mut Vec<Command>) {
    let palette = Palette::of(ui);
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let [width, height] = state.film_size();
            ui.label(value(format!("{width} × {height}")).color(palette.weak_text))
                .on_hover_text("Size of each image, in pixels.");
            if let Some([x, y]) = viewport.pointer.and_then(|point| pixel_at([width, height], point)) {
                ui.label(value(format!("pixel {x}, {y}")))
                    .on_hover_text("Under the pointer; 0, 0 is at the upper left.");
            }
            ui.label(value(progress(state, viewport)).color(palette.weak_text));
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                opening_ui(ui, state, commands);
                preparation_ui(ui, state, commands);
                let room = ui.available_width();
                let font = egui::TextStyle::Small.resolve(ui.style());
                let fits = |text: &&str| {
                    ui.painter().layout_no_wrap((*text).to_owned(), font.clone(), palette.weak_text).size().x < room
                };
                if let Some(text) = HINTS.iter().find(|text| fits(text)) {
                    ui.label(RichText::new(*text).small().color(palette.weak_text));
                }
            });
        });
    });
}

/// The scene that is being read.
fn opening_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let Some(opening) = state.opening() else { return };
    ui.label(RichText::new(format!("Opening {}…", opening.short_name())).small())
        .on_hover_text(opening.name.display().to_string());
    if ui.small_button("Cancel").on_hover_text("Stays with the scene that is shown.").clicked() {
        commands.push(Command::CancelOpening);
    }
}

/// The scene that is being prepared, once that takes long.
fn preparation_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let Some(preparation) = &state.preparation else { return };
    let taken = preparation.begun.elapsed();
    ui.ctx().request_repaint_after(if taken < PATIENCE { PATIENCE - taken } else { INTERVAL });
    if taken < PATIENCE {
        return;
    }
    let (stage, share) = preparation.state();
    let text = format!("Preparing: {}, {} s", stage.name(), taken.as_secs());
    ui.label(RichText::new(text).small()).on_hover_text("What lies on both sides of every surface is being found out.");
    ui.add(ProgressBar::new(share as f32).desired_width(90.0).desired_height(8.0));
    if ui.small_button("Cancel").on_hover_text("Goes back to the scene that was prepared last.").clicked() {
        commands.push(Command::CancelPreparation);
    }
}

fn progress(state: &State, viewport: &Viewport) -> String {
    let is_done = state.settings.shown_panes().iter().all(|content| {
        let source = viewport.source(*content);
        source.samples() > 0 && source.is_done() && source.epochs().all(|epoch| epoch == state.epoch())
    });
    match () {
        () if is_done => "done".to_owned(),
        () if state.is_paused => "paused".to_owned(),
        () if state.report.is_none() => "preparing".to_owned(),
        () => "rendering".to_owned(),
    }
}
