//! The bar at the top that offers a scene file which another program has changed, where loading it would replace edits.

use egui::{Align, Label, Layout, RichText, Ui};

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::theme::{Palette, WARNING_MARK};
use crate::app::widgets::button_ui;

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let path = state.document.path.as_deref();
    let name = path.and_then(|path| path.file_name()).map(|name| name.to_string_lossy()).unwrap_or_default();
    ui.horizontal(|ui| {
        ui.label(RichText::new(WARNING_MARK).color(Palette::of(ui).warning));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let about = "Your edits stay. Before they are saved over the file you are asked again.";
            button_ui(ui, "Keep mine", about, commands, Command::KeepMine);
            let about = "Shows the scene as it is on the disk now. Undo gives your edits back.";
            button_ui(ui, "Load", about, commands, Command::LoadChanged);
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let text = format!("{name} or a file that it names has changed on disk, and there are edits here.");
                ui.add(Label::new(text).truncate());
            });
        });
    });
}
