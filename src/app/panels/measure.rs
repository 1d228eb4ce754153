//! Error against time: the reference that it is measured by, the plot, and the figures in a table.

mod plot;
mod ticks;

use egui::{RichText, Ui};

use super::render::table_row_ui;
use crate::app::command::{Command, ExportKind};
use crate::app::measurement::{Curve, ErrorAxis, ErrorMetric, Given, GivenImage, Point};
use crate::app::state::State;
use crate::app::theme::{Palette, WARNING_MARK};
use crate::app::widgets::{
    button_ui, combo_ui, fact_ui, note, row_ui, section_first_ui, section_ui, segmented_row_ui, short_seconds, value,
};
use crate::export::words::{duration, grouped};
use crate::session::GroundTruthDemand;
use crate::tracking::Mode;

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    section_first_ui(ui, "Reference image", "");
    reference_ui(ui, state, commands);
    section_ui(ui, "Error", "");
    choices_ui(ui, state, commands);
    let curves = curves(state);
    if curves.iter().all(|(_, curve)| curve.points.is_empty()) {
        ui.label(note(ui, waiting_text(state)));
        return;
    }
    plot::show(ui, state, &curves);
    table_ui(ui, state, &curves);
    bias_ui(ui, state, &curves);
    ui.add_space(6.0);
    let about = "Every point of the plot, in every metric, as a table for other programs.";
    button_ui(ui, "Export as CSV…", about, commands, Command::AskExport(ExportKind::ErrorsCsv));
}

fn reference_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let measurement = &state.measurement;
    let mut button = |ui: &mut Ui, text: &str, about: &str, demand: GroundTruthDemand| {
        button_ui(ui, text, about, commands, Command::SetGroundTruth(demand));
    };
    let drop = "Lets the reference image go, and the errors with it.";
    if let Some(image) = &measurement.given.0 {
        return given_ui(ui, image, drop, commands);
    }
    match measurement.demand {
        GroundTruthDemand::Off => {
            let about = "Renders this picture with mode reference, twice and with random numbers of its own, in the background.";
            button(ui, "Make a reference image", about, GroundTruthDemand::On);
            ui.add_space(2.0);
            let about =
                "A picture of this scene from this view in linear light (EXR or HDR), of another renderer perhaps.";
            button_ui(ui, "Open an image…", about, commands, Command::AskReferenceImage);
            let text = "To measure every pane against: the picture again in mode reference, in the background, in two halves \
                        whose noise cancels. Or a picture of another renderer.";
            ui.label(note(ui, text));
            return;
        }
        GroundTruthDemand::On => ui.horizontal(|ui| {
            button(ui, "Pause", "Keeps the reference image as it is.", GroundTruthDemand::Paused);
            button(ui, "Drop", drop, GroundTruthDemand::Off);
        }),
        GroundTruthDemand::Paused => ui.horizontal(|ui| {
            button(ui, "Go on", "Takes more samples.", GroundTruthDemand::On);
            button(ui, "Drop", drop, GroundTruthDemand::Off);
        }),
    };
    let truth = measurement.truth.as_ref();
    let samples = truth.map_or(0, |truth| truth.samples);
    let progress = match (measurement.demand, truth.is_some_and(|truth| truth.is_done)) {
        (_, true) => "done",
        (GroundTruthDemand::Paused, _) => "paused",
        _ if samples == 0 => "waiting",
        _ => "rendering",
    };
    let samples =
        if samples == 0 { progress.to_owned() } else { format!("2 × {}, {progress}", grouped(samples.into())) };
    let about = "Of each half. It takes cores that the panes leave, and all of them once they are done.";
    fact_ui(ui, "Samples per pixel", samples, about);
    if let Some(truth) = truth.filter(|truth| truth.samples > 0) {
        fact_ui(ui, "Time", duration(truth.seconds), "Spent on rendering the reference image.");
    }
    let noise = measurement.results.truth_noise.filter(|_| is_current(state));
    let about = "relMSE that noise in the mean of both halves amounts to. It cancels in relMSE and MSE; FLIP and sMAPE cannot see below it.";
    fact_ui(ui, "Noise", noise.map_or_else(|| "…".to_owned(), |noise| format!("{noise:.1e}")), about);
    if measurement.has_begun_anew {
        let palette = Palette::of(ui);
        let text = "The picture has changed: the reference image begins anew.";
        ui.label(RichText::new(text).small().color(palette.warning));
    }
}

/// An image from a file.
fn given_ui(ui: &mut Ui, image: &GivenImage, drop: &str, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        button_ui(ui, "Open another…", "Measures against another image.", commands, Command::AskReferenceImage);
        button_ui(ui, "Drop", drop, commands, Command::SetReferenceImage(Given::default()));
    });
    fact_ui(ui, "File", image.name(), &image.path.display().to_string());
    let [width, height] = image.size();
    fact_ui(
        ui,
        "Size",
        format!("{width} × {height}"),
        "In pixels. Every pane has it while this image is measured against.",
    );
    let text = "Panes have the size of the image. Its noise is unknown, and no error falls below it.";
    ui.label(note(ui, text));
}

fn choices_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let metric = state.settings.error_metric;
    row_ui(ui, "Metric", metric.about(), |ui| {
        combo_ui(ui, "metric", metric.name(), |ui| {
            for choice in ErrorMetric::ALL {
                if ui.selectable_label(choice == metric, choice.name()).on_hover_text(choice.about()).clicked() {
                    commands.push(Command::SetErrorMetric(choice));
                }
            }
        });
    });
    let axes = [
        (ErrorAxis::Time, "Time", "Time spent on each film, and on rectification where the mode needs it."),
        (ErrorAxis::Samples, "Samples", "Samples per pixel."),
    ];
    let about = "What the plot has to the right.";
    let chosen = segmented_row_ui(ui, "Against", about, state.settings.error_axis, &axes);
    commands.extend(chosen.map(Command::SetErrorAxis));
}

/// Whether what has been measured is of the picture that is shown.
fn is_current(state: &State) -> bool {
    state.measurement.is_on() && state.measurement.results.epoch == state.epoch()
}

/// The curves of the modes that panes show.
fn curves(state: &State) -> Vec<(Mode, &Curve)> {
    if !is_current(state) {
        return Vec::new();
    }
    let curves = &state.measurement.results.curves;
    state.settings.modes().into_iter().filter_map(|mode| Some((mode, curves.get(&mode)?))).collect()
}

fn waiting_text(state: &State) -> &'static str {
    match () {
        () if !state.measurement.is_on() => "Errors appear here once there is a reference image.",
        () if state.settings.modes().is_empty() => "No pane shows a mode.",
        () => "Waiting for the reference image and the panes…",
    }
}

/// Where the columns of the table begin, as shares of its width.
const COLUMNS: [f32; 6] = [0.0, 0.07, 0.43, 0.54, 0.69, 0.86];

fn table_ui(ui: &mut Ui, state: &State, curves: &[(Mode, &Curve)]) {
    let palette = Palette::of(ui);
    let metric = state.settings.error_metric;
    ui.add_space(4.0);
    let head = |text: &str| RichText::new(text).small().color(palette.weak_text);
    let about = [
        "Panes that show the mode.",
        "",
        "Samples per pixel.",
        "Time spent on this film, rectification included where the mode needs it. While the reference image is made, the panes have \
         fewer cores and need longer.",
        metric.about(),
        "The power of time by which the error falls: −1 for squared errors without bias, −0.5 for others.",
    ];
    table_row_ui(ui, &COLUMNS, ["", "mode", "spp", "time", "error", "slope"].map(head), about);
    for (mode, curve) in curves {
        let Some(latest) = curve.latest() else { continue };
        let panes: Vec<String> = (state.settings.shown_panes().iter().enumerate())
            .filter(|(_, content)| content.modes().any(|shown| shown == *mode))
            .map(|(index, _)| (index + 1).to_string())
            .collect();
        let trend = curve.trend(metric);
        let slope = match (trend.bias, trend.slope) {
            (Some(_), _) => RichText::new(format!("{WARNING_MARK}bias")).small().color(palette.warning),
            (None, Some(slope)) => value(signed(slope)),
            (None, None) => value("…"),
        };
        let name = format!("{} {}", plot::look(*mode).0, mode.name());
        let cells = [
            RichText::new(panes.join(" ")).small().color(palette.weak_text),
            RichText::new(name).small().color(palette.mode(*mode)),
            value(latest.samples.to_string()),
            value(short_seconds(latest.seconds)),
            value(error_text(latest, metric)),
            slope,
        ];
        let shown = format!("In pane {}.", panes.join(", "));
        table_row_ui(ui, &COLUMNS, cells, [&shown, mode.name(), "", "", "", ""]);
    }
}

/// What is wrong with modes whose errors have stopped falling.
fn bias_ui(ui: &mut Ui, state: &State, curves: &[(Mode, &Curve)]) {
    let palette = Palette::of(ui);
    let metric = state.settings.error_metric;
    for (mode, curve) in curves {
        let trend = curve.trend(metric);
        let Some(bias) = trend.bias else { continue };
        let above = trend.slope.map(|slope| format!(", slope {} above it", signed(slope))).unwrap_or_default();
        let text = match &state.measurement.given.0 {
            None => format!("{WARNING_MARK} {} is biased: its error stays at {bias:.1e}{above}.", mode.name()),
            Some(image) => format!(
                "{WARNING_MARK} {} stays {bias:.1e} from {}{above}: that is bias, or the image's own noise, or it shows something else.",
                mode.name(),
                image.name()
            ),
        };
        ui.label(RichText::new(text).small().color(palette.warning));
    }
}

fn error_text(point: &Point, metric: ErrorMetric) -> String {
    match point.error(metric) {
        Some(error) if error > 0.0 => format!("{error:.1e}"),
        // Chance, where the error is smaller than what the noise of both halves leaves.
        Some(_) => "≈ 0".to_owned(),
        None => "…".to_owned(),
    }
}

fn signed(x: f64) -> String {
    if x < 0.0 { format!("−{:.2}", -x) } else { format!("{x:.2}") }
}
