//! Pictures that were kept, in panes: labels, and the entries of a pane's menu.

use egui::text::LayoutJob;
use egui::{Button, Response, TextFormat, Ui};

use crate::app::command::Command;
use crate::app::keys;
use crate::app::settings::PaneContent;
use crate::app::snapshots::SnapshotId;
use crate::app::state::State;
use crate::app::theme::over_pictures::{TEXT, WEAK};
use crate::app::theme::{self, DOT, Palette};
use crate::tracking::Mode;

/// The entries that choose a kept picture, or a difference to one.
pub(super) fn entries_ui(ui: &mut Ui, shown: PaneContent, entry: &mut impl FnMut(Response, PaneContent)) {
    let kept = SnapshotId::ALL.map(PaneContent::Snapshot).into_iter().chain([PaneContent::SnapshotDifference]);
    let mut add = |ui: &mut Ui, content: PaneContent| {
        entry(ui.selectable_label(shown == content, content.to_string()), content);
    };
    kept.for_each(|content| add(ui, content));
    for id in SnapshotId::ALL {
        ui.separator();
        Mode::ALL.into_iter().for_each(|mode| add(ui, PaneContent::Change(mode, id)));
    }
}

/// The entries that keep what pane `index` shows.
pub(super) fn keep_ui(ui: &mut Ui, state: &State, index: usize, commands: &mut Vec<Command>) {
    ui.separator();
    let has_film = state.settings.panes[index].modes().next().is_some();
    for (id, keys) in SnapshotId::ALL.into_iter().zip([keys::KEEP_A, keys::KEEP_B]) {
        let text = format!("Keep as snapshot {id}");
        let keys = egui::RichText::new(ui.ctx().format_shortcut(&keys)).small().weak();
        let button = Button::new(&text).right_text(keys);
        let about = "Keeps this picture, to be held against what comes after an edit.";
        let response = ui.add_enabled(has_film, button).accessible_name(&text).on_hover_text(about);
        if response.on_disabled_hover_text("Only the picture of a mode can be kept.").clicked() {
            commands.push(Command::SetActivePane(index));
            commands.push(Command::KeepSnapshot(id));
            ui.close();
        }
    }
}

/// For the tip of a pane's label.
pub(super) fn about(state: &State, content: PaneContent) -> String {
    let mut lines = vec![match content {
        PaneContent::Change(mode, id) => {
            format!("The luminance of {} as it is now less that of snapshot {id}.", mode.name())
        }
        PaneContent::SnapshotDifference => "The luminance of snapshot A less that of snapshot B.".to_owned(),
        _ => "A picture that was kept.".to_owned(),
    }];
    for id in content.snapshots() {
        if let Some(kept) = state.snapshots.get(id) {
            let title = kept.title(state.document.description(), &state.view.camera);
            lines.push(format!("Snapshot {id}: {title}, {} × {} pixels.", kept.film.size[0], kept.film.size[1]));
        }
    }
    lines.join("\n")
}

/// What the label says before the number of samples.
pub(super) fn append_label(ui: &Ui, state: &State, content: PaneContent, job: &mut LayoutJob) {
    let palette = Palette { is_dark: true, ..Palette::of(ui) };
    let body = egui::TextStyle::Body.resolve(ui.style());
    let small = theme::small_mono_style().resolve(ui.style());
    let dot = |job: &mut LayoutJob, mode: Mode, space: f32| {
        job.append(DOT, space, TextFormat::simple(egui::FontId::proportional(11.0), palette.mode(mode)));
    };
    let changes = |job: &mut LayoutJob, id: SnapshotId| {
        if let Some(kept) = state.snapshots.get(id) {
            let changes = kept.changes(state.document.description(), &state.view.camera);
            if !changes.is_empty() {
                job.append(&changes.join(", "), 8.0, TextFormat::simple(small.clone(), WEAK));
            }
        }
    };
    match content {
        PaneContent::Snapshot(id) => {
            job.append(&id.to_string(), 0.0, TextFormat::simple(body.clone(), TEXT));
            if let Some(kept) = state.snapshots.get(id) {
                dot(job, kept.film.mode, 8.0);
                job.append(kept.film.mode.name(), 5.0, TextFormat::simple(body, TEXT));
            }
            changes(job, id);
        }
        PaneContent::Change(mode, id) => {
            dot(job, mode, 0.0);
            let text = format!("{} − {id}", mode.name());
            job.append(&text, 5.0, TextFormat::simple(body, TEXT));
            changes(job, id);
        }
        _ => job.append("A − B", 0.0, TextFormat::simple(body, TEXT)),
    }
}
