//! The line at the bottom: what the pointer does, and how the rendering goes.

use egui::{Align, Layout, RichText, Ui};

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

pub fn show(ui: &mut Ui, state: &State, viewport: &Viewport) {
    let palette = Palette::of(ui);
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let [width, height] = state.film_size();
            ui.label(value(format!("{width} × {height}")).color(palette.weak_text))
                .on_hover_text("Size of each image, in pixels.");
            if let Some([x, y]) = viewport.pointer().and_then(|point| pixel_at([width, height], point)) {
                ui.label(value(format!("pixel {x}, {y}")))
                    .on_hover_text("Under the pointer; 0, 0 is at the upper left.");
            }
            ui.label(value(progress(state, viewport)).color(palette.weak_text));
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
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
