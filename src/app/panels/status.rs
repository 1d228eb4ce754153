//! The line at the bottom: what the pointer does, and how the rendering goes.

use std::time::Duration;

use egui::{Align, Label, Layout, ProgressBar, RichText, Role, Sense, Stroke, Ui, WidgetInfo, vec2};

use crate::app::command::Command;
use crate::app::develop::Source;
use crate::app::progress::Progress;
use crate::app::state::State;
use crate::app::theme::{self, Palette};
use crate::app::viewport::{Viewport, pixel_at};
use crate::app::widgets::value;

/// The hint, longest first: the longest that fits is shown.
const HINTS: [&str; 4] = [
    "drag: orbit   ·   right drag: pan   ·   wheel: dolly   ·   Ctrl + wheel: zoom   ·   click: inspect   ·   Ctrl + click: select   ·   ?: all shortcuts",
    "drag: orbit   ·   right drag: pan   ·   wheel: dolly   ·   Ctrl + wheel: zoom   ·   click: inspect   ·   ?: all shortcuts",
    "drag: orbit   ·   right drag: pan   ·   wheel: dolly   ·   ?: all shortcuts",
    "?: shortcuts",
];

/// Space beside a separator, and the separator's width, in points.
const SPACE: f32 = 8.0;
const SEPARATOR: f32 = 1.0;

/// Share of the line's width that words about rendering may take.
const WORDS: f32 = 0.55;
/// Width of the bar beside them, in points.
const BAR: f32 = 70.0;
const PROGRESS: &str =
    "How far the images are. Noise is the mean error of a pixel relative to its brightness, estimated.";

/// A preparation that has taken so long is shown.
const PATIENCE: Duration = Duration::from_millis(500);
/// Time between two looks at it.
const INTERVAL: Duration = Duration::from_millis(100);

pub fn show(ui: &mut Ui, state: &State, viewport: &Viewport, commands: &mut Vec<Command>) {
    let palette = Palette::of(ui);
    let font = theme::small_mono_style().resolve(ui.style());
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = SPACE;
        opening_ui(ui, state, commands);
        preparation_ui(ui, state, commands);
        let measure =
            |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), palette.weak_text).size().x;
        let progress = Progress::of(state);
        let words = words(state, viewport, progress);
        let room = WORDS * ui.available_width();
        // The first words say most.
        let texts = (1..=words.len()).rev().map(|count| words[..count].join(" · "));
        let text = texts.into_iter().find(|text| measure(text) <= room).unwrap_or_else(|| words[0].clone());
        let facts = facts(state, viewport, text);
        let mut widths: Vec<f32> = facts.iter().map(|fact| measure(&fact.text)).collect();
        let has_bar = progress.wanted.is_some() && !progress.is_done && progress.samples > 0;
        if has_bar {
            widths[0] += BAR + SPACE;
        }
        let count = fitting(&widths, ui.available_width());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            // The most important one stands at the edge and is shortened where even that has no room.
            for (index, fact) in facts[..count].iter().enumerate() {
                if index > 0 {
                    separator_ui(ui);
                }
                let label = Label::new(value(fact.text.as_str()).color(palette.weak_text)).truncate();
                let response = ui.add(label);
                if !fact.about.is_empty() {
                    response.on_hover_text(fact.about);
                }
                if index == 0 && has_bar && ui.available_width() > BAR {
                    let bar = ProgressBar::new(progress.share()).desired_width(BAR).desired_height(6.0);
                    let response = ui.add(bar).on_hover_text("How much of the rendering is done.");
                    response.widget_info(|| WidgetInfo::labeled(Role::ProgressIndicator, true, "Rendering"));
                }
            }
            if count == facts.len() {
                hint_ui(ui, palette);
            }
        });
    });
}

/// Something that the line says.
struct Fact {
    text: String,
    about: &'static str,
}

/// What there is to say, the most important first.
fn facts(state: &State, viewport: &Viewport, progress: String) -> Vec<Fact> {
    let [width, height] = state.film_size();
    let mut facts = vec![Fact { text: progress, about: PROGRESS }];
    if let Some([x, y]) = viewport.pointer.and_then(|point| pixel_at([width, height], point)) {
        let about = "Under the pointer; 0, 0 is at the upper left.";
        facts.push(Fact { text: format!("pixel {x}, {y}"), about });
    }
    facts.push(Fact { text: format!("{width} × {height}"), about: "Size of each image, in pixels." });
    facts
}

/// How many of the first texts, of these widths and with separators between them, fit into `room`; one at least.
fn fitting(widths: &[f32], room: f32) -> usize {
    let mut taken = 0.0;
    let fits = |width: &&f32| {
        let gap = if taken > 0.0 { 2.0 * SPACE + SEPARATOR } else { 0.0 };
        taken += **width + gap;
        taken <= room
    };
    widths.iter().take_while(fits).count().max(1).min(widths.len())
}

fn separator_ui(ui: &mut Ui) {
    let (rect, _) = ui.allocate_exact_size(vec2(SEPARATOR, 14.0), Sense::hover());
    ui.painter().vline(rect.center().x, rect.y_range(), Stroke::new(1.0, Palette::of(ui).line));
}

/// The longest hint that has room, at the left.
fn hint_ui(ui: &mut Ui, palette: Palette) {
    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
        let room = ui.available_width() - SPACE;
        let font = egui::TextStyle::Small.resolve(ui.style());
        let fits = |text: &&str| {
            ui.painter().layout_no_wrap((*text).to_owned(), font.clone(), palette.weak_text).size().x < room
        };
        if let Some(text) = HINTS.iter().find(|text| fits(text)) {
            ui.label(RichText::new(*text).small().color(palette.weak_text));
        }
    });
}

/// The scene that is being read.
fn opening_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let Some(opening) = state.opening() else { return };
    let text = RichText::new(format!("Opening {}…", opening.short_name())).small();
    ui.scope(|ui| {
        ui.set_max_width(0.4 * ui.available_width());
        ui.add(Label::new(text).truncate()).on_hover_text(opening.name.display().to_string());
    });
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

fn words(state: &State, viewport: &Viewport, progress: Progress) -> Vec<String> {
    let is_current = |source: &Source| source.epochs().all(|epoch| epoch >= state.picture_floor());
    let mut sources = state.settings.shown_panes().iter().map(|content| viewport.source(*content));
    let is_done = sources.all(|source| source.samples() > 0 && source.is_done() && is_current(&source));
    let has_films = !state.settings.modes().is_empty();
    match () {
        () if !state.is_paused && state.report.is_none() => vec!["preparing".to_owned()],
        () if has_films => progress.words(state.is_paused),
        () if is_done => vec!["done".to_owned()],
        () if state.is_paused => vec!["paused".to_owned()],
        () => vec!["painting".to_owned()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_that_have_no_room_are_left_out_from_the_end() {
        let widths = [60.0, 80.0, 70.0];
        let gap = 2.0 * SPACE + SEPARATOR;
        for (room, count) in [(0.0, 1), (60.0, 1), (140.0, 1), (140.0 + gap, 2), (210.0 + 2.0 * gap, 3), (9e3, 3)] {
            assert_eq!(fitting(&widths, room), count, "{room}");
        }
        assert_eq!(fitting(&[], 100.0), 0);
    }
}
