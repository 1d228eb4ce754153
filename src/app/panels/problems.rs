//! The strip at the bottom: what is doubtful in the scene, worst first.

use egui::{Align, Label, Layout, RichText, ScrollArea, Ui};

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::theme::{ADVICE_MARK, ERROR_MARK, Palette, WARNING_MARK};
use crate::app::widgets::note;
use crate::check::{Problem, Severity};

/// Height of the opened strip, in points: the picture keeps most of the room.
const MOST_HEIGHT: f32 = 140.0;

/// A mark that says the severity without its colour.
fn mark(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => ERROR_MARK,
        Severity::Warning => WARNING_MARK,
        Severity::Advice => ADVICE_MARK,
    }
}

fn word(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "Error: the scene cannot be rendered like this.",
        Severity::Warning => "Warning: the picture may be wrong.",
        Severity::Advice => "Advice: perhaps not what was meant.",
    }
}

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let problems = state.problems();
    let id = ui.scope_id().with("all");
    let mut is_open = ui.data(|data| data.get_temp(id).unwrap_or(false));
    match problems {
        // All solved while a button is down: the strip goes when it is released.
        [] => {
            ui.label(note(ui, "No problems left."));
        }
        [only] => row_ui(ui, only, false, state, commands, |_| {}),
        [worst, ..] if !is_open => row_ui(ui, worst, false, state, commands, |ui| {
            let text = format!("+{} more", problems.len() - 1);
            if ui.button(text).on_hover_text("Show all problems.").clicked() {
                is_open = true;
            }
        }),
        [worst, others @ ..] => {
            // While a button is down nothing may move under the pointer.
            let height = id.with("height");
            let is_pressed = ui.input(|input| input.pointer.any_down());
            let kept: Option<f32> = ui.data(|data| data.get_temp(height)).filter(|_| is_pressed);
            let output = ScrollArea::vertical()
                .min_scrolled_height(kept.unwrap_or(MOST_HEIGHT))
                .max_height(kept.unwrap_or(MOST_HEIGHT))
                .auto_shrink([false, kept.is_none()])
                .show(ui, |ui| {
                    row_ui(ui, worst, true, state, commands, |ui| {
                        if ui.button("Less").on_hover_text("Show the worst problem only.").clicked() {
                            is_open = false;
                        }
                    });
                    for problem in others {
                        row_ui(ui, problem, true, state, commands, |_| {});
                    }
                });
            ui.data_mut(|data| data.insert_temp(height, output.inner_rect.height()));
        }
    }
    ui.data_mut(|data| data.insert_temp(id, is_open));
}

/// One problem, on one line or, `is_full`, on as many as it needs. `more` adds buttons at the right.
fn row_ui(
    ui: &mut Ui,
    problem: &Problem,
    is_full: bool,
    state: &State,
    commands: &mut Vec<Command>,
    more: impl FnOnce(&mut Ui),
) {
    let palette = Palette::of(ui);
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            more(ui);
            let description = state.document.description();
            // A problem between two objects names both; the first is shown.
            let object = problem.place.split(", ").find(|place| description.object_names().any(|name| name == *place));
            if let Some(object) = object
                && ui.button("Show").on_hover_text("Select it in the tree.").clicked()
            {
                commands.push(Command::SelectObject(Some(object.to_owned())));
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let color = palette.severity(problem.severity);
                ui.label(RichText::new(mark(problem.severity)).color(color)).on_hover_text(word(problem.severity));
                let mut text = egui::text::LayoutJob::default();
                let font = egui::TextStyle::Body.resolve(ui.style());
                text.append(
                    &problem.place,
                    0.0,
                    egui::TextFormat::simple(font.clone(), ui.visuals().strong_text_color()),
                );
                text.append(&problem.message, 8.0, egui::TextFormat::simple(font, ui.visuals().text_color()));
                let label = Label::new(text);
                ui.add(if is_full { label.wrap() } else { label.truncate() });
            });
        });
    });
}
