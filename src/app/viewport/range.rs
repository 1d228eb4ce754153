//! The legend of a difference: a bar of the map's colours with the numbers at its ends. Dragging it changes the range.

use egui::{Align2, EventFilter, Key, Rect, Sense, Ui, Vec2, vec2};

use super::legend;
use crate::app::command::Command;
use crate::app::develop::{difference_color, flip_color};
use crate::app::range::{DifferenceRange, RangeCurve, RangeEnd, Scale};
use crate::app::settings::DifferenceKind;
use crate::app::state::State;
use crate::app::theme::over_pictures::{GROUND, TEXT, WEAK};
use crate::export::words::brief;

/// Height of the legend, in points.
pub(super) const HEIGHT: f32 = 50.0;
const BAR: Vec2 = vec2(150.0, 8.0);
/// Points of a drag that double the range.
const POINTS_PER_DOUBLING: f32 = 40.0;
/// What an arrow key does to the range.
const STEP: f32 = 1.25;

/// In the lower right corner of `room`, or in the lower left one where pane `index` has its label in the way. `scale` is that of the
/// picture that is shown. Returns where it is, if there is room.
pub(super) fn show(
    ui: &Ui,
    state: &State,
    index: usize,
    scale: Option<Scale>,
    room: Rect,
    at_left: bool,
    commands: &mut Vec<Command>,
) -> Option<Rect> {
    if room.width() < BAR.x + 40.0 || room.height() < 90.0 {
        return None;
    }
    let painter = ui.painter();
    let frame = legend::in_corner(room, vec2(BAR.x + 20.0, HEIGHT), at_left);
    painter.rect_filled(frame, 5.0, GROUND);
    let bar = Rect::from_min_size(frame.min + vec2(10.0, 8.0), BAR);
    let kind = state.settings.difference;
    let is_signed = kind == DifferenceKind::Signed;
    let font = egui::FontId::monospace(10.0);
    let (labels, caption) = match scale.filter(|_| kind != DifferenceKind::Flip) {
        None => {
            legend::paint_bar(painter, bar, flip_color);
            (["0", "0.5", "1"].map(str::to_owned), "FLIP, as displayed".to_owned())
        }
        Some(scale) => {
            legend::paint_bar(painter, bar, |part| {
                let part = if is_signed { 2.0 * part - 1.0 } else { part };
                difference_color(scale.place(scale.difference_at(part)), is_signed)
            });
            (numbers(scale, is_signed), caption(scale, is_signed))
        }
    };
    let places =
        [(bar.left(), Align2::LEFT_TOP), (bar.center().x, Align2::CENTER_TOP), (bar.right(), Align2::RIGHT_TOP)];
    for ((x, align), text) in places.into_iter().zip(labels) {
        painter.text(egui::pos2(x, bar.bottom() + 3.0), align, text, font.clone(), TEXT);
    }
    painter.text(egui::pos2(bar.center().x, bar.bottom() + 16.0), Align2::CENTER_TOP, caption, font, WEAK);
    if let Some(scale) = scale.filter(|_| kind != DifferenceKind::Flip) {
        commands.extend(dragged(ui, state, index, scale, frame).map(Command::SetDifferenceRange));
    }
    Some(frame)
}

/// At the left, in the middle and at the right of the bar.
fn numbers(scale: Scale, is_signed: bool) -> [String; 3] {
    let number = |value: f32| brief(f64::from(value));
    if is_signed {
        [format!("−{}", number(scale.end)), "0".to_owned(), format!("+{}", number(scale.end))]
    } else {
        let least = scale.least();
        let least = if least > 0.0 { format!("≤{}", number(least)) } else { "0".to_owned() };
        [least, number(scale.difference_at(0.5)), number(scale.end)]
    }
}

fn caption(scale: Scale, is_signed: bool) -> String {
    let what = if is_signed { "Δ luminance" } else { "|Δ luminance|" };
    match scale.curve {
        RangeCurve::Logarithmic if is_signed => format!("{what}, log from {}", brief(f64::from(scale.least()))),
        curve => format!("{what}, {}", curve.name()),
    }
}

/// What a drag, a double click or an arrow key on the legend makes of the range.
fn dragged(ui: &Ui, state: &State, index: usize, scale: Scale, frame: Rect) -> Option<DifferenceRange> {
    let id = egui::Id::unique(("range", index));
    let response = ui.interact(frame, id, Sense::click_and_drag());
    let range = state.settings.difference_range;
    // The picture may lag behind.
    let end = if let RangeEnd::Fixed(end) = range.end { end } else { scale.end };
    let name = format!("Range of the difference in pane {}", index + 1);
    response.widget_info(|| egui::WidgetInfo::slider(true, f64::from(end), &name));
    let response = response.on_hover_cursor(egui::CursorIcon::ResizeHorizontal).on_hover_text(
        "Drag to the right for a larger range, to the left for a smaller one.\nDouble-click: as at first. The tab Render has more.",
    );
    if response.clicked() {
        response.request_focus();
    }
    if response.double_clicked() {
        return Some(DifferenceRange::default());
    }
    let mut factor = 1.0;
    if response.dragged() {
        factor *= (response.drag_delta().x / POINTS_PER_DOUBLING).exp2();
    }
    if response.has_focus() {
        let filter = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, filter));
        let stroke = egui::Stroke::new(1.0, TEXT);
        ui.painter().rect_stroke(frame, 5.0, stroke, egui::StrokeKind::Inside);
        let steps = ui.input(|input| [Key::ArrowRight, Key::ArrowLeft].map(|key| input.num_presses(key) as i32));
        factor *= STEP.powi(steps[0] - steps[1]);
    }
    (factor != 1.0).then(|| DifferenceRange { end: RangeEnd::Fixed(end * factor), ..range }.repaired())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_the_colours() {
        let root = Scale { end: 0.5, curve: RangeCurve::Root };
        assert_eq!(numbers(root, false), ["0", "0.25", "0.5"]);
        assert_eq!(numbers(root, true), ["−0.5", "0", "+0.5"]);
        let log = Scale { end: 2.0, curve: RangeCurve::Logarithmic };
        assert_eq!(numbers(log, false), ["≤2e-4", "0.02", "2"]);
        assert_eq!(caption(log, true), "Δ luminance, log from 2e-4");
    }
}
