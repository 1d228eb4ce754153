//! The histogram of the active pane.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

use crate::app::develop::{difference_color, flip_color};
use crate::app::histogram::{BINS_PER_STOP, Difference, Histogram, Radiance, STOPS};
use crate::app::range::Scale;
use crate::app::settings::DifferenceKind;
use crate::app::state::State;
use crate::app::theme::Palette;
use crate::app::viewport::Viewport;
use crate::app::widgets::note;
use crate::export::words::brief;

const HEIGHT: f32 = 64.0;
/// Stops below and above white that are shown.
const BELOW: i32 = 12;
const ABOVE: i32 = 4;

pub fn show(ui: &mut Ui, state: &State, viewport: &Viewport) {
    let content = state.settings.panes[state.view.active_pane];
    let Some(histogram) = viewport.histogram(content) else {
        ui.label(note(ui, "Nothing to count in the active pane yet."));
        return;
    };
    let (room, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT + 16.0), Sense::hover());
    let plot = Rect::from_min_size(room.min, vec2(room.width(), HEIGHT));
    let painter = ui.painter().with_clip_rect(room.expand(1.0));
    painter.rect_filled(plot, 2.0, ui.visuals().extreme_bg_color);
    let (text, about) = match histogram {
        Histogram::Radiance(radiance) => {
            let exposure = state.settings.display.exposure;
            paint_radiance(ui, &painter, plot, radiance, exposure);
            let share = 100.0 * radiance.clipped_share(exposure);
            let about = "Pixels by radiance, in stops from white at the present exposure; counts are logarithmic. White: luminance.";
            (format!("{} % of the pixels above white", brief(share)), about)
        }
        Histogram::Difference(difference) => {
            paint_difference(ui, &painter, plot, difference, viewport.scale(content));
            let share = 100.0 * f64::from(difference.beyond) / f64::from(difference.pixels.max(1));
            let about = "Pixels by difference, each in its colour; counts are logarithmic.";
            (format!("{} % of the pixels beyond the range", brief(share)), about)
        }
    };
    let name = format!("Histogram of {content}: {text}");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &name));
    response.on_hover_text(about);
    ui.label(note(ui, text));
}

/// Height of a bar, from 0 to 1: counts differ by orders of magnitude.
fn height(count: u32, most: u32) -> f32 {
    (f64::from(count).ln_1p() / f64::from(most.max(1)).ln_1p()) as f32
}

fn paint_radiance(ui: &Ui, painter: &Painter, plot: Rect, radiance: &Radiance, exposure: f32) {
    let palette = Palette::of(ui);
    let x_of = |stop: f32| plot.left() + plot.width() * (stop + BELOW as f32) / (BELOW + ABOVE) as f32;
    // The stop, from white, at which a bin begins.
    let start_of = |bin: usize| STOPS.start as f32 + bin as f32 / BINS_PER_STOP as f32 + exposure;
    let is_shown = |bin: usize| (-BELOW as f32 - 0.3..=ABOVE as f32).contains(&start_of(bin));
    let most = radiance.counts.iter().flatten().copied().max().unwrap_or(1);
    let light = if palette.is_dark { Color32::from_gray(225) } else { Color32::from_gray(40) };
    let colors =
        [light, Color32::from_rgb(235, 80, 70), Color32::from_rgb(60, 190, 90), Color32::from_rgb(80, 130, 250)];
    for (counts, color) in radiance.counts.iter().zip(colors).rev() {
        let mut line = Vec::new();
        for (bin, count) in counts.iter().enumerate().filter(|(bin, _)| is_shown(*bin)) {
            let y = plot.bottom() - (plot.height() - 2.0) * height(*count, most);
            line.push(pos2(x_of(start_of(bin)), y));
            line.push(pos2(x_of(start_of(bin + 1)), y));
        }
        painter.with_clip_rect(plot).add(Shape::line(line, Stroke::new(1.2, color)));
    }
    painter.vline(x_of(0.0), plot.y_range(), Stroke::new(1.0, palette.warning));
    let labels =
        [(-BELOW, Align2::LEFT_TOP), (-8, Align2::CENTER_TOP), (-4, Align2::CENTER_TOP), (ABOVE, Align2::RIGHT_TOP)];
    for (stop, align) in labels {
        label(
            painter,
            pos2(x_of(stop as f32), plot.bottom() + 2.0),
            align,
            &format!("{stop:+}").replace('-', "−"),
            palette.weak_text,
        );
    }
    label(painter, pos2(x_of(0.0), plot.bottom() + 2.0), Align2::CENTER_TOP, "white", palette.weak_text);
}

fn paint_difference(ui: &Ui, painter: &Painter, plot: Rect, difference: &Difference, scale: Option<Scale>) {
    let palette = Palette::of(ui);
    let is_signed = difference.kind == DifferenceKind::Signed;
    let bins = difference.counts.len() as f32;
    let most = difference.counts.iter().copied().max().unwrap_or(1);
    for (bin, count) in difference.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let part = (bin as f32 + 0.5) / bins;
        let color = match difference.kind {
            DifferenceKind::Flip => flip_color(part),
            DifferenceKind::Signed => difference_color(2.0 * part - 1.0, true),
            DifferenceKind::Absolute => difference_color(part, false),
        };
        let left = plot.left() + plot.width() * bin as f32 / bins;
        let top = plot.bottom() - (plot.height() - 2.0) * height(*count, most);
        let bar = Rect::from_min_max(pos2(left, top), pos2(left + plot.width() / bins, plot.bottom()));
        painter.rect_filled(bar, 0.0, color);
        // Dark colours are seen by their edge.
        painter.hline(bar.x_range(), top, Stroke::new(1.0, palette.weak_text));
    }
    let end = scale.map_or("1".to_owned(), |scale| brief(f64::from(scale.end)));
    let bottom = plot.bottom() + 2.0;
    let (first, last) = if is_signed { (format!("−{end}"), format!("+{end}")) } else { ("0".to_owned(), end) };
    label(painter, pos2(plot.left(), bottom), Align2::LEFT_TOP, &first, palette.weak_text);
    label(painter, pos2(plot.right(), bottom), Align2::RIGHT_TOP, &last, palette.weak_text);
    let middle = scale.map_or(0.5, |scale| scale.size_at(0.5));
    let middle = if is_signed { "0".to_owned() } else { brief(f64::from(middle)) };
    label(painter, pos2(plot.center().x, bottom), Align2::CENTER_TOP, &middle, palette.weak_text);
}

fn label(painter: &Painter, at: Pos2, align: Align2, text: &str, color: Color32) {
    painter.text(at, align, text, FontId::monospace(10.0), color);
}
