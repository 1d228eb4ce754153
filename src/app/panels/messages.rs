//! Everything that was said since the start, to be read again.

use egui::{Context, Label, RichText};

use crate::app::command::Command;
use crate::app::modal;
use crate::app::state::State;
use crate::app::theme::{CHECK_MARK, ERROR_MARK, Palette};
use crate::app::widgets::note;

pub fn show(ctx: &Context, state: &State, commands: &mut Vec<Command>) {
    let answer = modal::titled(ctx, "Messages", state.windows.messages, 560.0, |ui, _| {
        ui.set_min_width(ui.available_width());
        if state.messages.is_empty() {
            ui.label(note(ui, "Nothing has been said yet."));
        }
        let palette = Palette::of(ui);
        // Latest first.
        for message in state.messages.iter().rev() {
            let (mark, color) = if message.is_error { (ERROR_MARK, palette.error) } else { (CHECK_MARK, palette.good) };
            ui.horizontal_top(|ui| {
                ui.label(RichText::new(mark).color(color));
                ui.add(Label::new(&message.text).selectable(true).wrap());
            });
        }
    });
    if answer.is_closed {
        commands.push(Command::ShowMessages(false));
    }
}
