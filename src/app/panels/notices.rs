//! Messages over the pictures. Errors stay until they are dismissed.

use egui::{
    Align, Align2, Area, Color32, Context, Frame, Id, Label, Layout, Margin, Order, RichText, ScrollArea, Ui, vec2,
};

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::theme::{CHECK_MARK, CLOSE_MARK, ERROR_MARK, Palette};

const WIDTH: f32 = 440.0;
/// Good news goes by itself after this time, in seconds; errors stay.
const LIFETIME_SECS: f64 = 8.0;

pub fn show(ui: &Ui, state: &State, commands: &mut Vec<Command>) {
    if state.notices.is_empty() {
        return;
    }
    let now = ui.input(|input| input.time);
    for notice in state.notices.iter().filter(|notice| !notice.is_error) {
        let born: f64 = ui.data_mut(|data| *data.get_temp_mut_or(Id::unique(("notice", notice.id)), now));
        let left = born + LIFETIME_SECS - now;
        if left <= 0.0 {
            commands.push(Command::DismissNotice(notice.id));
        } else {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(left));
        }
    }
    let room = ui.max_rect();
    let width = WIDTH.min(room.width() - 24.0);
    Area::new(Id::unique("notices"))
        .order(Order::Middle)
        .pivot(Align2::CENTER_BOTTOM)
        .fixed_pos(room.center_bottom() - vec2(0.0, 14.0))
        .constrain_to(room)
        .show(ui.ctx(), |ui| {
            ui.set_width(width);
            for notice in &state.notices {
                let palette = Palette::of(ui);
                let (mark, color) =
                    if notice.is_error { (ERROR_MARK, palette.error) } else { (CHECK_MARK, palette.good) };
                Frame::window(ui.style())
                    .inner_margin(Margin::symmetric(12, 8))
                    .stroke(egui::Stroke::new(1.0, color))
                    .show(ui, |ui| {
                        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
                            let close = ui.button(CLOSE_MARK).on_hover_text("Dismiss (Esc)");
                            if close.accessible_name("Dismiss").clicked() {
                                commands.push(Command::DismissNotice(notice.id));
                            }
                            ui.with_layout(Layout::left_to_right(Align::Min), |ui| {
                                ui.label(RichText::new(mark).color(color));
                                // A long list of valid names must not hide the picture.
                                ScrollArea::vertical().id_salt(notice.id).max_height(120.0).show(ui, |ui| {
                                    ui.add(Label::new(&notice.text).wrap());
                                });
                            });
                        });
                    });
            }
        });
}

/// While files hang over the window.
pub fn drop_hint_ui(ctx: &Context) {
    let painter = ctx.layer_painter(egui::LayerId::new(Order::Foreground, Id::unique("drop")));
    let rect = ctx.content_rect();
    painter.rect_filled(rect, 0.0, Color32::from_black_alpha(170));
    let font = egui::FontId::proportional(20.0);
    painter.text(rect.center(), Align2::CENTER_CENTER, "Drop a scene to open it", font, Color32::WHITE);
}
