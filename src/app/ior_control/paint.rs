//! How the rail is drawn: names of media above it in two rows, numbers and the scene's other media below.

use std::sync::Arc;

use egui::{Align2, Color32, FontId, Galley, Pos2, Rect, Response, Stroke, StrokeKind, Ui, pos2, vec2};

use super::rail::{Rail, Tick, ticks};
use super::{Subject, center_at, x_of};
use crate::app::theme::Palette;
use crate::optics::Ior;

const TEXT_SIZE: f32 = 10.0;
const ROW: f32 = 12.0;
const RAIL_HEIGHT: f32 = 4.0;
const KNOB: f32 = 7.0;
/// Least space between two names.
const SPACE: f32 = 4.0;
/// Height of the whole: two rows of names, the rail, marks and numbers.
pub const HEIGHT: f32 = 2.0 * ROW + 18.0 + ROW + 2.0;

/// The name of a tick, where there is room for it.
pub struct Label {
    pub tick: &'static Tick,
    pub rect: Rect,
    galley: Arc<Galley>,
}

/// The rail itself: its ends are inset by the knob's radius.
pub fn track(rect: Rect) -> Rect {
    let middle = rect.top() + 2.0 * ROW + 9.0;
    Rect::from_center_size(
        pos2(rect.center().x, middle),
        vec2((rect.width() - 2.0 * KNOB - 2.0).max(20.0), RAIL_HEIGHT),
    )
}

/// Names of ticks, the important ones first, as many as fit into two rows.
pub fn labels(ui: &Ui, rail: &Rail, track: Rect) -> Vec<Label> {
    let mut order: Vec<&'static Tick> = ticks().iter().filter(|tick| rail.range().contains(&tick.ior)).collect();
    order.sort_by_key(|tick| tick.rank);
    let mut placed: Vec<Label> = Vec::new();
    let bounds = track.x_range().expand(KNOB);
    for tick in order {
        let galley =
            ui.painter().layout_no_wrap(tick.name.clone(), FontId::proportional(TEXT_SIZE), Color32::PLACEHOLDER);
        let width = galley.size().x;
        let x =
            (x_of(track, rail.place(tick.ior)) - width / 2.0).clamp(bounds.min, (bounds.max - width).max(bounds.min));
        let fits = [1.0, 2.0].into_iter().find_map(|row| {
            let top = track.center().y - 9.0 - row * ROW;
            let rect = Rect::from_min_size(pos2(x, top), vec2(width, ROW));
            let is_free = placed.iter().all(|other| !other.rect.expand2(vec2(SPACE, -1.0)).intersects(rect));
            is_free.then_some(rect)
        });
        if let Some(rect) = fits {
            placed.push(Label { tick, rect, galley });
        }
    }
    placed
}

#[expect(clippy::too_many_arguments, reason = "each is a part of the picture")]
pub fn show(
    ui: &Ui,
    response: &Response,
    track: Rect,
    rail: &Rail,
    shown: &Ior,
    subject: &Subject<'_>,
    labels: &[Label],
    under_pointer: Option<&Tick>,
) {
    let (painter, palette) = (ui.painter(), Palette::of(ui));
    let visuals = ui.visuals();
    let text = visuals.widgets.noninteractive.fg_stroke.color;
    let n = shown.ior();
    let knob = center_at(track, rail.place(n));

    painter.rect_filled(track, 2.0, visuals.widgets.inactive.bg_fill);
    let filled = Rect::from_min_max(track.min, pos2(knob.x, track.bottom()));
    painter.rect_filled(filled, 2.0, visuals.selection.bg_fill);

    let is_here = |tick: &Tick| *shown == tick.model;
    let strength = |tick: &Tick| {
        if is_here(tick) || under_pointer == Some(tick) { text } else { palette.weak_text }
    };
    for tick in ticks().iter().filter(|tick| rail.range().contains(&tick.ior)) {
        let x = x_of(track, rail.place(tick.ior));
        let label = labels.iter().find(|label| label.tick == tick);
        // Up to its name, where it has one, but not through another.
        let own = label.map_or(f32::INFINITY, |label| label.rect.bottom());
        let is_between = |other: &&Label| other.rect.bottom() > own && other.rect.x_range().expand(1.0).contains(x);
        let end = labels.iter().find(is_between).map_or(own, |other| other.rect.bottom());
        let top = end.min(track.top() - 4.0);
        let color = strength(tick).gamma_multiply(if label.is_some() { 0.8 } else { 0.5 });
        painter.vline(x, top..=track.bottom() + 1.0, Stroke::new(1.0, color));
    }
    for label in labels {
        painter.galley_with_override_text_color(label.rect.min, Arc::clone(&label.galley), strength(label.tick));
    }
    numbers(ui, track, rail, palette.weak_text);
    for other in subject.others.iter().filter(|other| rail.range().contains(&other.ior)) {
        mark(ui, pos2(x_of(track, rail.place(other.ior)), track.bottom() + 4.0), other.color);
    }

    let widget = ui.style().interact(response);
    painter.circle(knob, KNOB, subject.color, Stroke::new(2.0, widget.fg_stroke.color));
    if response.has_focus() {
        painter.circle_stroke(knob, KNOB + 2.5, Stroke::new(1.5, palette.accent));
    }
}

/// Indices under the rail, those that do not touch.
fn numbers(ui: &Ui, track: Rect, rail: &Rail, color: Color32) {
    let mut last = f32::NEG_INFINITY;
    let mut numbers = rail.numbers();
    numbers.sort_by(f64::total_cmp);
    for n in numbers {
        let text = if (0.01..1000.0).contains(&n) { format!("{n}") } else { format!("{n:e}") };
        let text = if n.fract() == 0.0 && n < 10.0 { format!("{n:.1}") } else { text };
        let galley = ui.painter().layout_no_wrap(text, FontId::proportional(TEXT_SIZE), color);
        let width = galley.size().x;
        let x = x_of(track, rail.place(n));
        let left = (x - width / 2.0).clamp(track.left() - KNOB, track.right() + KNOB - width);
        if left < last + SPACE {
            continue;
        }
        last = left + width;
        ui.painter().galley(pos2(left, track.bottom() + 7.0), galley, color);
    }
}

/// A small triangle that points up at an index of another medium.
fn mark(ui: &Ui, tip: Pos2, color: Color32) {
    let points = vec![tip, tip + vec2(3.5, 5.0), tip + vec2(-3.5, 5.0)];
    let edge = Stroke::new(1.0, ui.visuals().panel_fill);
    ui.painter().add(egui::Shape::convex_polygon(points, color, edge));
}

/// A rail in a row of the tree: where the index lies among the scene's own.
pub fn thin(ui: &Ui, response: &Response, track: Rect, rail: &Rail, subject: &Subject<'_>) {
    let painter = ui.painter();
    let visuals = ui.visuals();
    painter.rect_filled(track, 1.5, visuals.widgets.inactive.bg_fill);
    for other in subject.others.iter().filter(|other| rail.range().contains(&other.ior)) {
        let x = x_of(track, rail.place(other.ior));
        painter.vline(x, track.y_range().expand(1.0), Stroke::new(1.5, other.color.gamma_multiply(0.75)));
    }
    let knob = center_at(track, rail.place(subject.model.ior()));
    let size = if response.hovered() || response.dragged() || response.has_focus() { 11.0 } else { 9.0 };
    let rect = Rect::from_center_size(knob, vec2(5.0, size));
    painter.rect_filled(rect, 2.0, subject.color);
    let edge =
        if response.has_focus() { Palette::of(ui).accent } else { visuals.widgets.noninteractive.fg_stroke.color };
    painter.rect_stroke(rect, 2.0, Stroke::new(1.0, edge), StrokeKind::Outside);
}

/// A short text at the left of a place.
pub fn small_text(ui: &Ui, at: Pos2, anchor: Align2, text: &str, color: Color32) -> Rect {
    ui.painter().text(at, anchor, text, FontId::proportional(TEXT_SIZE), color)
}
