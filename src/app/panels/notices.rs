//! Messages over the pictures. They go by themselves after a time that is enough to read them, errors later, and none while the pointer is
//! over them; all of them can be read again under Help, Messages.

use std::time::Duration;

use egui::accesskit::Live;
use egui::{
    Align, Align2, Area, Color32, Context, Frame, Id, Label, Layout, Margin, Order, Rangef, Rect, RichText, ScrollArea,
    Ui, pos2,
};

use crate::app::command::Command;
use crate::app::state::{Notice, State};
use crate::app::theme::{CHECK_MARK, CLOSE_MARK, ERROR_MARK, Palette};
use crate::app::widgets::note;

const WIDTH: f32 = 440.0;
/// Distance from the edge of the pictures and from what must not be covered, in points.
const MARGIN: f32 = 12.0;
/// Most height of one message, in points: a long list of valid names must not hide the picture.
const MOST_HEIGHT: f32 = 120.0;
/// What a message needs beside its text, in points: margins, frame, and the gap to the next.
const AROUND: f32 = 24.0;
/// Room for one message of one line, and for the line that counts those that are not shown, in points.
const SHORT_HEIGHT: f32 = 22.0 + AROUND;
const COUNT_HEIGHT: f32 = 34.0;
/// Most messages that are shown at a time.
const MOST: usize = 4;

/// How long a message stays, in seconds.
fn lifetime(notice: &Notice) -> f64 {
    let letters = notice.text.chars().count() as f64;
    // Slow readers read ten letters a second.
    if notice.is_error { (15.0 + 0.1 * letters).min(60.0) } else { (3.0 + 0.1 * letters).min(20.0) }
}

/// What is known of the message's time.
#[derive(Clone, Copy)]
struct Clock {
    left: f64,
    seen: f64,
}

/// Lets time pass for all messages, except while the pointer is over them.
fn expire(ui: &Ui, state: &State, is_held: bool, commands: &mut Vec<Command>) {
    let now = ui.input(|input| input.time);
    for notice in &state.notices {
        let id = Id::unique(("notice", notice.id));
        let fresh = Clock { left: lifetime(notice), seen: now };
        let mut clock: Clock = ui.data(|data| data.get_temp(id)).unwrap_or(fresh);
        if !is_held {
            clock.left -= now - clock.seen;
        }
        clock.seen = now;
        if clock.left <= 0.0 {
            ui.data_mut(|data| data.remove::<Clock>(id));
            commands.push(Command::DismissNotice(notice.id));
        } else {
            ui.data_mut(|data| data.insert_temp(id, clock));
            if !is_held {
                ui.ctx().request_repaint_after(Duration::from_secs_f64(clock.left));
            }
        }
    }
}

/// The lowest strip of `room` that none of `labels` reaches into at `columns`, at least [`SHORT_HEIGHT`] high; all of `room` where there is
/// none.
fn free_strip(room: Rect, columns: Rangef, labels: &[Rect]) -> Rangef {
    let mut taken: Vec<Rangef> = (labels.iter())
        .filter(|label| label.right() > columns.min && label.left() < columns.max)
        .map(|label| Rangef::new(label.top() - MARGIN, label.bottom() + MARGIN))
        .collect();
    // From below.
    taken.sort_by(|a, b| b.max.total_cmp(&a.max));
    let mut bottom = room.bottom() - MARGIN;
    for range in taken {
        if bottom - range.max >= SHORT_HEIGHT {
            return Rangef::new(range.max, bottom);
        }
        bottom = bottom.min(range.min);
    }
    let top = room.top() + MARGIN;
    if bottom - top >= SHORT_HEIGHT { Rangef::new(top, bottom) } else { room.y_range() }
}

/// Shows the messages in `ui`, whose panes have their labels at `labels`.
pub fn show(ui: &Ui, state: &State, labels: &[Rect], commands: &mut Vec<Command>) {
    if state.notices.is_empty() {
        return;
    }
    let room = ui.max_rect();
    let width = WIDTH.min(room.width() - 2.0 * MARGIN);
    let columns = Rangef::point(room.center().x).expand(width / 2.0);
    let strip = free_strip(room, columns, labels);
    let id = Id::unique("notices");
    let was_at = ui.ctx().memory(|memory| memory.area_rect(id));
    let pointer = ui.input(|input| input.pointer.hover_pos());
    expire(ui, state, was_at.zip(pointer).is_some_and(|(area, pointer)| area.contains(pointer)), commands);
    // Those that have no room wait behind the latest ones.
    let has_more = state.notices.len() > MOST.min((strip.span() / SHORT_HEIGHT) as usize);
    let height = strip.span() - if has_more { COUNT_HEIGHT } else { 0.0 };
    let count = ((height / SHORT_HEIGHT) as usize).clamp(1, MOST).min(state.notices.len());
    let hidden = state.notices.len() - count;
    Area::new(id)
        .order(Order::Middle)
        .pivot(Align2::CENTER_BOTTOM)
        .fixed_pos(pos2(room.center().x, strip.max))
        .constrain_to(room)
        .show(ui.ctx(), |ui| {
            ui.set_width(width);
            let height = (height / count as f32 - AROUND).clamp(22.0, MOST_HEIGHT);
            for notice in &state.notices[hidden..] {
                notice_ui(ui, notice, height, commands);
            }
            if hidden > 0 {
                let text = format!("{hidden} more: Help, Messages");
                Frame::window(ui.style())
                    .inner_margin(Margin::symmetric(12, 3))
                    .show(ui, |ui| ui.label(note(ui, text)));
            }
        });
}

fn notice_ui(ui: &mut Ui, notice: &Notice, height: f32, commands: &mut Vec<Command>) {
    let palette = Palette::of(ui);
    let (mark, color) = if notice.is_error { (ERROR_MARK, palette.error) } else { (CHECK_MARK, palette.good) };
    let frame = Frame::window(ui.style()).inner_margin(Margin::symmetric(12, 8)).stroke(egui::Stroke::new(1.0, color));
    frame.show(ui, |ui| {
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            let close = ui.button(CLOSE_MARK).on_hover_text("Dismiss (Esc)");
            if close.accessible_name("Dismiss").clicked() {
                commands.push(Command::DismissNotice(notice.id));
            }
            ui.with_layout(Layout::left_to_right(Align::Min), |ui| {
                ui.label(RichText::new(mark).color(color));
                ScrollArea::vertical().id_salt(notice.id).max_height(height).min_scrolled_height(0.0).show(ui, |ui| {
                    let label = ui.add(Label::new(&notice.text).wrap());
                    // Screen readers say it: an error at once, the rest when they come to it.
                    let live = if notice.is_error { Live::Assertive } else { Live::Polite };
                    ui.ctx().accesskit_node_builder(label.id, |node| node.set_live(live));
                });
            });
        });
    });
}

/// While files hang over the window.
pub fn drop_hint_ui(ctx: &Context) {
    let painter = ctx.layer_painter(egui::LayerId::new(Order::Foreground, Id::unique("drop")));
    let rect = ctx.content_rect();
    painter.rect_filled(rect, 0.0, Color32::from_black_alpha(170));
    let font = egui::FontId::proportional(20.0);
    painter.text(
        rect.center(),
        Align2::CENTER_CENTER,
        "Drop a scene file to open it, a mesh or an environment image to add it",
        font,
        Color32::WHITE,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rect(x: f32, y: f32, width: f32, height: f32) -> Rect {
        Rect::from_min_size(pos2(x, y), egui::vec2(width, height))
    }

    #[test]
    fn messages_keep_off_the_labels_of_the_panes() {
        let columns = Rangef::new(100.0, 500.0);
        for height in [240.0_f32, 400.0, 900.0] {
            let room = rect(0.0, 0.0, 600.0, height);
            // Labels at the corners of four panes, and at the bottom as in a wipe.
            let four = [rect(8.0, 8.0, 180.0, 40.0), rect(308.0, height / 2.0 + 8.0, 180.0, 40.0)];
            let wipe = [rect(8.0, height - 48.0, 200.0, 40.0), rect(8.0, 8.0, 200.0, 40.0)];
            for labels in [&four[..], &wipe, &[]] {
                let strip = free_strip(room, columns, labels);
                assert!(strip.span() >= SHORT_HEIGHT && room.y_range().contains(strip.min), "{strip:?}");
                for label in labels {
                    assert!(strip.max <= label.top() || strip.min >= label.bottom(), "{height}: {strip:?}, {label:?}");
                }
            }
        }
        // Where there is no room at all they are shown nevertheless.
        let low = rect(0.0, 0.0, 600.0, 60.0);
        assert_eq!(free_strip(low, columns, &[rect(8.0, 8.0, 180.0, 40.0)]), low.y_range());
    }

    #[test]
    fn longer_messages_stay_longer_and_errors_longest() {
        let notice = |is_error, letters| Notice { id: 0, is_error, text: "x".repeat(letters) };
        let times = [notice(false, 10), notice(false, 80), notice(true, 10), notice(true, 400)].map(|n| lifetime(&n));
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{times:?}");
        assert!(lifetime(&notice(true, 100_000)) <= 60.0);
    }
}
