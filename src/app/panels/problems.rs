//! The strip at the bottom: what is doubtful in the scene, worst first.

use egui::{Align, Layout, RichText, ScrollArea, Ui};

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::theme::{ADVICE_MARK, ERROR_MARK, Palette, WARNING_MARK};
use crate::check::{Problem, Severity};

/// Problems shown without scrolling.
const SHOWN: f32 = 4.0;

fn problems(state: &State) -> &[Problem] {
    state.report.as_ref().and_then(|report| report.problems.as_deref()).unwrap_or_default()
}

pub fn has_any(state: &State) -> bool {
    !problems(state).is_empty()
}

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
    let problems = problems(state);
    let id = ui.scope_id().with("all");
    let mut is_open = ui.data(|data| data.get_temp(id).unwrap_or(false));
    if let [only] = problems {
        row_ui(ui, only, state, commands, |_| {});
        return;
    }
    if is_open {
        let row = ui.spacing().interact_size.y + ui.spacing().item_spacing.y;
        ScrollArea::vertical().max_height(SHOWN * row).auto_shrink([false, true]).show(ui, |ui| {
            for (index, problem) in problems.iter().enumerate() {
                row_ui(ui, problem, state, commands, |ui| {
                    if index == 0 && ui.button("Less").on_hover_text("Show the worst problem only.").clicked() {
                        is_open = false;
                    }
                });
            }
        });
    } else if let Some(worst) = problems.first() {
        row_ui(ui, worst, state, commands, |ui| {
            let text = format!("+{} more", problems.len() - 1);
            if ui.button(text).on_hover_text("Show all problems.").clicked() {
                is_open = true;
            }
        });
    }
    ui.data_mut(|data| data.insert_temp(id, is_open));
}

fn row_ui(ui: &mut Ui, problem: &Problem, state: &State, commands: &mut Vec<Command>, more: impl FnOnce(&mut Ui)) {
    let palette = Palette::of(ui);
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        ui.set_height(ui.spacing().interact_size.y);
        more(ui);
        let is_object = state.document.description().object_names().any(|name| name == problem.place);
        if is_object && ui.button("Show").on_hover_text("Select it in the tree.").clicked() {
            commands.push(Command::SelectObject(Some(problem.place.clone())));
        }
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            let color = palette.severity(problem.severity);
            ui.label(RichText::new(mark(problem.severity)).color(color)).on_hover_text(word(problem.severity));
            ui.label(RichText::new(&problem.place).strong());
            ui.add(egui::Label::new(&problem.message).truncate());
        });
    });
}
