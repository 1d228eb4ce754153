//! Panes and their modes, display, quality, progress, events.

use egui::{DragValue, RichText, Slider, Ui};

use super::{backend, estimator, histogram, range, slice, snapshots};
use crate::app::command::Command;
use crate::app::progress::Progress;
use crate::app::settings::{Arrangement, DEFAULT_NOISE_TARGET, DifferenceKind, MAX_PANES, PaneContent, Preset};
use crate::app::state::State;
use crate::app::theme::{self, DOT, Palette, WARNING_MARK};
use crate::app::viewport::{Viewport, content_menu_ui, event_meaning, event_name};
use crate::app::widgets::{
    combo_ui, note, number_within_ui, row_ui, section_first_ui, section_ui, segmented_row_ui, short_count,
    short_seconds, sized_row_ui, value, whole_ui,
};
use crate::export::words::{brief, grouped};
use crate::render::ToneCurve;

const SCALES: [(f32, &str); 5] = [(0.25, "¼"), (0.5, "½"), (1.0, "1"), (1.5, "1½"), (2.0, "2")];

pub fn show(ui: &mut Ui, state: &State, viewport: &Viewport, commands: &mut Vec<Command>) {
    section_first_ui(ui, "Panes", "");
    panes_ui(ui, state, commands);
    if slice::is_shown(state) {
        slice::show(ui, state, commands);
    }
    section_ui(ui, "Display", "");
    display_ui(ui, state, viewport, commands);
    if state.settings.show_histogram {
        section_ui(ui, "Histogram", &format!("pane {}", state.view.active_pane + 1));
        histogram::show(ui, state, viewport);
    }
    section_ui(ui, "Snapshots", "");
    snapshots::show(ui, state, commands);
    section_ui(ui, "Quality", "");
    quality_ui(ui, state, commands);
    section_ui(ui, "Progress", "");
    progress_ui(ui, state);
    section_ui(ui, "Events", "");
    events_ui(ui, state, viewport);
}

fn panes_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let settings = &state.settings;
    let counts = [(1, "1", "One pane (1)"), (2, "2", "Two panes (2)"), (4, "4", "Four panes (4)")];
    let chosen = segmented_row_ui(ui, "Number", "How many pictures are shown.", settings.pane_count, &counts);
    commands.extend(chosen.map(Command::SetPaneCount));
    let arrangements = [
        (Arrangement::Tiles, "Tiles", "Side by side (W)"),
        (Arrangement::Wipe, "Wipe", "Over each other, with a divider to drag (W)"),
    ];
    let about = "How the pictures share the room.";
    let chosen = segmented_row_ui(ui, "Arrange", about, settings.arrangement, &arrangements);
    commands.extend(chosen.map(Command::SetArrangement));
    row_ui(ui, "Compare", "Four panes that answer one question together.", |ui| {
        let is_shown = |preset: &Preset| settings.pane_count == MAX_PANES && settings.panes == preset.panes();
        let shown = Preset::ALL.into_iter().find(is_shown);
        let text = shown.map_or("custom", Preset::name);
        combo_ui(ui, "panes", text, |ui| {
            for preset in Preset::ALL {
                let response = ui.selectable_label(shown == Some(preset), preset.name());
                if response.on_hover_text(preset.about()).clicked() {
                    commands.push(Command::SetPreset(preset));
                }
            }
        });
    });
    let palette = Palette::of(ui);
    for (index, content) in settings.shown_panes().iter().enumerate() {
        let name = format!("Pane {}", index + 1);
        // Two names of modes side by side need much room.
        sized_row_ui(ui, 46.0, &name, "What this pane shows.", |ui| {
            let text = match content {
                PaneContent::Mode(mode) => RichText::new(format!("{DOT} {}", mode.name())).color(palette.mode(*mode)),
                _ => {
                    let text = content.to_string();
                    let font = egui::TextStyle::Button.resolve(ui.style());
                    let width = ui.painter().layout_no_wrap(text.clone(), font, palette.weak_text).size().x;
                    let room = ui.available_width() - ui.spacing().icon_width - 24.0;
                    if width > room { RichText::new(text).small() } else { RichText::new(text) }
                }
            };
            combo_ui(ui, ("pane", index), text, |ui| {
                commands.extend(content_menu_ui(ui, *content).map(|new| Command::SetPaneContent(index, new)));
            });
        });
    }
}

fn display_ui(ui: &mut Ui, state: &State, viewport: &Viewport, commands: &mut Vec<Command>) {
    let settings = &state.settings;
    let about =
        "Brightness in stops: radiance is multiplied by 2 to this power. Display only: exported EXR stays as it is.";
    row_ui(ui, "Exposure", about, |ui| {
        let mut exposure = settings.display.exposure;
        ui.spacing_mut().slider_width = ui.available_width() - 54.0;
        let slider = Slider::new(&mut exposure, -8.0..=8.0).clamping(egui::SliderClamping::Never).show_value(false);
        let height = std::mem::replace(&mut ui.spacing_mut().interact_size.y, 16.0);
        let is_dragged = ui.add(slider).accessible_name("Exposure").on_hover_text(about).changed();
        ui.spacing_mut().interact_size.y = height;
        let typed = DragValue::new(&mut exposure).speed(0.02).fixed_decimals(2);
        let is_typed = number_within_ui(ui, 46.0, -30.0..=30.0, typed, "Exposure", about);
        if is_dragged || is_typed {
            commands.push(Command::SetExposure(exposure));
        }
    });
    let curves = [
        (ToneCurve::Soft, "Soft", "A shoulder that keeps bright parts apart."),
        (ToneCurve::Clip, "Clip", "Cut off at white: comparable by eye with other programs' plain output."),
    ];
    let about = "How radiance above 1 is brought into the screen's range.";
    commands.extend(segmented_row_ui(ui, "Curve", about, settings.display.curve, &curves).map(Command::SetCurve));
    let about = "Smooths noise in what is displayed; the pane's label says so. Differences, figures and files stay as rendered.";
    row_ui(ui, "Denoise", about, |ui| {
        let mut is_on = settings.denoise;
        if ui.checkbox(&mut is_on, "display only").on_hover_text(about).changed() {
            commands.push(Command::SetDenoise(is_on));
        }
    });
    if settings.shown_panes().iter().any(|content| content.is_difference()) {
        let kinds = DifferenceKind::ALL.map(|kind| (kind, kind.name(), kind.about()));
        let about = "How differences are coloured.";
        let chosen = segmented_row_ui(ui, "Difference", about, settings.difference, &kinds);
        commands.extend(chosen.map(Command::SetDifference));
        range::show(ui, state, viewport, commands);
    }
}

fn quality_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    estimator::show(ui, state, commands);
    backend::show(ui, state, commands);
    let settings = &state.settings;
    let about = "Film pixels per screen pixel, each way. Smaller is faster and coarser.";
    let scales = SCALES.map(|(scale, name)| (scale, name, about));
    let chosen = segmented_row_ui(ui, "Resolution", about, settings.resolution_scale, &scales);
    commands.extend(chosen.map(Command::SetResolutionScale));
    let about =
        "Most segments of a path, the camera's first being one. A cap darkens what many interfaces lie in front of.";
    let depth = limit_ui(ui, "Depth cap", about, settings.max_depth, 64, 100_000);
    commands.extend(depth.map(Command::SetMaxDepth));
    commands.extend(noise_ui(ui, settings.noise_target).map(Command::SetNoiseTarget));
    let about = "Samples per pixel at which rendering stops in any case.";
    let limit = limit_ui(ui, "Samples", about, settings.sample_limit, 4096, 10_000_000);
    commands.extend(limit.map(Command::SetSampleLimit));
}

/// The noise at which rendering stops, in percent. Returns what it has been changed to.
fn noise_ui(ui: &mut Ui, target: Option<f64>) -> Option<Option<f64>> {
    const NAME: &str = "Stop at noise";
    let about = "Rendering stops when every picture has so little noise: the mean error of a pixel relative to its brightness, estimated while \
                 rendering. Where errors are measured it goes on.";
    row_ui(ui, NAME, about, |ui| {
        let mut is_on = target.is_some();
        let has_toggled = ui.checkbox(&mut is_on, "").accessible_name(NAME).on_hover_text(about).changed();
        let mut percent = 100.0 * target.unwrap_or(DEFAULT_NOISE_TARGET);
        let mut has_changed = false;
        if target.is_some() {
            let drag = DragValue::new(&mut percent).speed(0.01).max_decimals(2).suffix(" %");
            has_changed = number_within_ui(ui, ui.available_width(), 0.01..=50.0, drag, NAME, about);
        } else {
            ui.label(note(ui, "no target"));
        }
        (has_toggled || has_changed).then(|| is_on.then_some(percent / 100.0))
    })
}

/// A number from 1 to `most` that can be absent. Returns what it has been changed to.
fn limit_ui(ui: &mut Ui, name: &str, about: &str, limit: Option<u32>, default: u32, most: u32) -> Option<Option<u32>> {
    row_ui(ui, name, about, |ui| {
        let mut is_on = limit.is_some();
        let has_toggled = ui.checkbox(&mut is_on, "").accessible_name(name).on_hover_text(about).changed();
        let mut number = limit.unwrap_or(default);
        let mut has_changed = false;
        if limit.is_some() {
            let drag = DragValue::new(&mut number).speed(0.5);
            has_changed = whole_ui(ui, ui.available_width(), 1..=i64::from(most), drag, name, about);
        } else {
            ui.label(note(ui, "no limit"));
        }
        (has_toggled || has_changed).then(|| is_on.then_some(number))
    })
}

/// Where the columns of the progress table begin, as shares of its width: they must not move when numbers change.
const COLUMNS: [f32; 5] = [0.0, 0.34, 0.49, 0.66, 0.83];

fn progress_ui(ui: &mut Ui, state: &State) {
    let progress = Progress::of(state);
    let words = progress.words(state.is_paused);
    ui.add(egui::Label::new(value(words[..2].join(" · "))).wrap());
    let share = if progress.is_done { 1.0 } else { progress.share() };
    let bar = ui.add(egui::ProgressBar::new(share).desired_height(6.0));
    bar.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, "Samples that are taken"));
    ui.label(note(ui, words[2..].join(" · ")));
    let palette = Palette::of(ui);
    let head = |text: &str| RichText::new(text).small().color(palette.weak_text);
    let about = [
        "Modes of one lane advance in lockstep, with the same random numbers; reference beside others goes at its own pace.",
        "Samples per pixel.",
        "The mean error of a pixel relative to its brightness, estimated.",
        "Time spent rendering this image.",
        "Pixel samples per second.",
    ];
    table_row_ui(ui, &COLUMNS, ["mode", "spp", "noise", "time", "per s"].map(head), about);
    for mode in state.settings.modes() {
        let name = RichText::new(format!("{DOT} {}", mode.name())).small().color(palette.mode(mode));
        let texts = match state.films.get(&mode).filter(|film| film.epoch >= state.picture_floor()) {
            Some(film) => {
                let samples = if film.is_preview() { "…".to_owned() } else { film.samples.to_string() };
                let noise = film.noise.map_or("…".to_owned(), |noise| format!("{} %", brief(100.0 * noise)));
                [samples, noise, short_seconds(film.seconds), short_count(film.samples_per_second())]
            }
            None => ["…"; 4].map(str::to_owned),
        };
        let [samples, noise, time, speed] = texts.map(value);
        table_row_ui(ui, &COLUMNS, [name, samples, noise, time, speed], [mode.name(), "", "", "", ""]);
    }
}

/// A row of a table whose columns begin at shares of its width. `about` explains each cell.
pub(super) fn table_row_ui<const N: usize>(ui: &mut Ui, columns: &[f32; N], cells: [RichText; N], about: [&str; N]) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), 18.0), egui::Sense::hover());
    for (index, (cell, about)) in cells.into_iter().zip(about).enumerate() {
        let end = columns.get(index + 1).copied().unwrap_or(1.0);
        let x = |share: f32| rect.left() + share * rect.width();
        let room = egui::Rect::from_x_y_ranges(x(columns[index])..=x(end) - 2.0, rect.y_range());
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let mut cell_ui = ui.new_child(egui::UiBuilder::new().max_rect(room).layout(layout));
        let response = cell_ui.add(egui::Label::new(cell).truncate());
        if !about.is_empty() {
            response.on_hover_text(about);
        }
    }
}

fn events_ui(ui: &mut Ui, state: &State, viewport: &Viewport) {
    let palette = Palette::of(ui);
    let (mut has_any, mut has_samples) = (false, false);
    for mode in state.settings.modes() {
        let Some(film) = viewport.film(state, mode) else { continue };
        has_samples |= film.samples > 0;
        for (kind, count) in film.events.named().into_iter().filter(|(_, count)| *count > 0) {
            has_any = true;
            ui.horizontal(|ui| {
                ui.label(RichText::new(WARNING_MARK).color(palette.warning));
                ui.label(RichText::new(mode.name()).small().color(palette.mode(mode)));
                ui.add(egui::Label::new(RichText::new(event_name(kind)).small()).truncate());
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(RichText::new(short_count(count as f64)).text_style(theme::small_mono_style()));
                });
            })
            .response
            .on_hover_text(format!("{} {}.\n{}", grouped(count), event_name(kind), event_meaning(kind)));
        }
    }
    if !has_any {
        ui.label(note(ui, no_events_text(state.settings.modes().is_empty(), has_samples)));
    }
}

/// What stands where no event is listed.
fn no_events_text(has_no_modes: bool, has_samples: bool) -> &'static str {
    match (has_no_modes, has_samples) {
        (true, _) => "No pane shows a mode.",
        (false, false) => "Nothing rendered yet.",
        (false, true) => "None: every path left each medium that it had entered.",
    }
}

#[cfg(test)]
mod tests {
    use super::no_events_text;

    #[test]
    fn nothing_is_said_of_paths_before_there_are_any() {
        assert_eq!(no_events_text(false, false), "Nothing rendered yet.");
        assert_eq!(no_events_text(true, false), "No pane shows a mode.");
        assert!(no_events_text(false, true).starts_with("None:"));
    }
}
