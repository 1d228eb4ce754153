//! The pictures that are kept.

use egui::{Button, Label, RichText, Ui};

use crate::app::command::Command;
use crate::app::keys;
use crate::app::settings::PaneContent;
use crate::app::snapshots::SnapshotId;
use crate::app::state::State;
use crate::app::theme::CLOSE_MARK;
use crate::app::widgets::{note, row_ui};

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    for (id, keys) in SnapshotId::ALL.into_iter().zip([keys::KEEP_A, keys::KEEP_B]) {
        let kept = state.snapshots.get(id);
        let keys = ui.ctx().format_shortcut(&keys);
        let row = format!("Snapshot {id}");
        row_ui(ui, &row, "A picture that is kept, to be held against what comes after an edit.", |ui| {
            let about = format!("Keeps the picture of the active pane ({keys}).");
            let keep = ui.button("Keep").on_hover_text(about);
            if keep.accessible_name(format!("Keep as snapshot {id}")).clicked() {
                commands.push(Command::KeepSnapshot(id));
            }
            let Some(kept) = kept else {
                ui.label(note(ui, "empty"));
                return;
            };
            let active = state.view.active_pane;
            let name = format!("Show snapshot {id}");
            let show = ui.button("Show").on_hover_text("Shows it in the active pane.");
            if show.accessible_name(name).clicked() {
                commands.push(Command::SetPaneContent(active, PaneContent::Snapshot(id)));
            }
            let mode = kept.film.mode;
            let name = format!("Show what has changed since snapshot {id}");
            let change =
                ui.button("Δ").on_hover_text("Shows the mode as it is now less the snapshot in the active pane.");
            if change.accessible_name(name).clicked() {
                commands.push(Command::SetPaneContent(active, PaneContent::Change(mode, id)));
            }
            let close = ui.add(Button::new(CLOSE_MARK).frame(false)).on_hover_text("Drops it.");
            if close.accessible_name(format!("Drop snapshot {id}")).clicked() {
                commands.push(Command::DropSnapshot(id));
            }
        });
        if let Some(kept) = kept {
            let title = kept.title(state.document.description(), &state.view.camera);
            ui.add(Label::new(RichText::new(title).small().weak()).wrap());
        }
    }
}
