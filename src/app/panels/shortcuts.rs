//! The list of keys and of what the pointer does.

use egui::{Context, Grid, RichText};

use crate::app::command::Command;
use crate::app::keys::{GROUPS, POINTER};
use crate::app::state::State;
use crate::app::widgets::{centered_ui, section_first_ui, section_ui};

pub fn show(ctx: &Context, state: &State, commands: &mut Vec<Command>) {
    let is_closed = centered_ui(ctx, "Keyboard and mouse", state.windows.shortcuts, 620.0, |ui| {
        ui.columns(2, |columns| {
            let [left, right] = columns else { return };
            section_first_ui(left, "Mouse", "");
            Grid::new("pointer").num_columns(2).spacing([16.0, 4.0]).show(left, |ui| {
                for (what, does) in POINTER {
                    ui.label(RichText::new(*what).monospace().small());
                    ui.label(*does);
                    ui.end_row();
                }
            });
            for (index, group) in GROUPS.iter().enumerate() {
                let ui = if index < 3 { &mut *left } else { &mut *right };
                if index == 3 {
                    section_first_ui(ui, group.title, "");
                } else {
                    section_ui(ui, group.title, "");
                }
                Grid::new(group.title).num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
                    for shortcut in group.shortcuts.iter().filter(|shortcut| !shortcut.what.is_empty()) {
                        ui.label(RichText::new(ui.ctx().format_shortcut(&shortcut.keys)).monospace().small());
                        ui.label(shortcut.what);
                        ui.end_row();
                    }
                });
            }
        });
    });
    if is_closed {
        commands.push(Command::ShowShortcuts(false));
    }
}
