//! The bar at the top that offers edits that an earlier instance did not save.

use std::time::Duration;

use egui::{Align, Label, Layout, RichText, Ui};

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::theme::{ADVICE_MARK, Palette};
use crate::app::widgets::button_ui;

/// The latest ones first; the next come when these have been answered.
pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let [found, others @ ..] = &state.left_behind[..] else { return };
    let path = || found.slot.path().to_owned();
    ui.horizontal(|ui| {
        ui.label(RichText::new(ADVICE_MARK).color(Palette::of(ui).accent));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            button_ui(ui, "Later", "They are offered again at the next start.", commands, Command::PostponeEdits);
            button_ui(ui, "Discard", "They are removed.", commands, Command::DiscardEdits(path()));
            let about = match found.scene_path() {
                Some(scene) => format!("Opens the edited scene; “Save” writes to {}.", scene.display()),
                None => "Opens the edited scene, which has no file yet.".to_owned(),
            };
            button_ui(ui, "Restore", &about, commands, Command::RestoreEdits(path()));
            if !others.is_empty() {
                ui.label(RichText::new(format!("+{} more", others.len())).small());
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let text = format!("Edits of “{}” from {} were not saved.", found.name(), ago(found.age()));
                ui.add(Label::new(text).truncate());
            });
        });
    });
}

fn ago(age: Duration) -> String {
    let seconds = age.as_secs();
    let (number, unit) = match seconds {
        0..60 => return "just now".to_owned(),
        60..3600 => (seconds / 60, "minute"),
        3600..86_400 => (seconds / 3600, "hour"),
        _ => (seconds / 86_400, "day"),
    };
    format!("{number} {unit}{} ago", if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_the_largest_whole_unit() {
        let cases =
            [(0, "just now"), (59, "just now"), (60, "1 minute ago"), (7199, "1 hour ago"), (7200, "2 hours ago")];
        for (seconds, text) in cases {
            assert_eq!(ago(Duration::from_secs(seconds)), text);
        }
        assert_eq!(ago(Duration::from_secs(86_400 * 3)), "3 days ago");
    }
}
