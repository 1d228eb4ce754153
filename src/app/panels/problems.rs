//! The strip at the bottom: what is doubtful in the scene, worst first.

use egui::{Align, CursorIcon, Label, Layout, RichText, ScrollArea, Sense, Ui};

use crate::app::command::Command;
use crate::app::edit::ObjectEdit;
use crate::app::modal;
use crate::app::quotes::quoted;
use crate::app::state::State;
use crate::app::theme::{ADVICE_MARK, ERROR_MARK, Palette, WARNING_MARK};
use crate::app::widgets::{button_ui, note};
use crate::check::{Problem, Severity};
use crate::rectify::containment::top;
use crate::scene::ObjectId;

/// Height of the opened strip, in points: the picture keeps most of the room.
const MOST_HEIGHT: f32 = 140.0;

/// A mark that says the severity without its colour, and what it means.
fn mark(severity: Severity) -> (&'static str, &'static str) {
    match severity {
        Severity::Error => (ERROR_MARK, "Error: the scene cannot be rendered like this."),
        Severity::Warning => (WARNING_MARK, "Warning: the picture may be wrong."),
        Severity::Advice => (ADVICE_MARK, "Advice: perhaps not what was meant."),
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
                    modal::scroll_to_focus(ui);
                });
            ui.data_mut(|data| data.insert_temp(height, output.inner_rect.height()));
        }
    }
    ui.data_mut(|data| data.insert_temp(id, is_open));
}

/// The objects that a problem is about: several names are separated by commas.
fn objects_of<'a>(problem: &'a Problem, state: &State) -> Vec<&'a str> {
    let description = state.document.description();
    problem.place.split(", ").filter(|place| description.objects.find(place).is_some()).collect()
}

/// What shows a problem in the picture, and what to say of that; `None` where there is nothing to see.
fn show_command(problem: &Problem, state: &State) -> Option<(&'static str, Command)> {
    if problem.place == "camera" {
        return Some(("Back to the camera as it is in the scene.", Command::ResetCamera));
    }
    let objects: Vec<String> = objects_of(problem, state).into_iter().map(str::to_owned).collect();
    (problem.spot.is_some() || !objects.is_empty()).then_some((
        "Click: the camera goes there and the object is selected. Backspace: back to the earlier view.",
        Command::ShowProblem { objects, spot: problem.spot },
    ))
}

/// The edit that solves a problem, where there is one plain answer, and what to say of it.
fn fix(problem: &Problem, state: &State) -> Option<(String, Command)> {
    if problem.kind != "overlap_tie" {
        return None;
    }
    let [a, b] = objects_of(problem, state)[..] else { return None };
    let scene = &state.report.as_ref()?.prepared.scene;
    let id = |name: &str| scene.objects.iter().position(|object| object.name == name).map(|at| ObjectId(at as u32));
    let is_second = top(scene, [id(a)?, id(b)?]) == id(b);
    let (winner, other) = if is_second { (b, a) } else { (a, b) };
    let description = state.document.description();
    let priority = description.objects.find(other)?.refractor()?.priority.checked_add(1)?;
    let tip = format!(
        "Sets the priority of {winner} to {priority}: it wins over {other}, as it does now without being told."
    );
    Some((tip, Command::object(winner.to_owned(), ObjectEdit::Priority(priority))))
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
            let show = show_command(problem, state);
            if let Some((tip, command)) = fix(problem, state) {
                button_ui(ui, "Fix", &tip, commands, command);
            }
            if let Some((tip, command)) = &show {
                button_ui(ui, "Show", tip, commands, command.clone());
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let color = palette.severity(problem.severity);
                let (mark, meaning) = mark(problem.severity);
                ui.label(RichText::new(mark).color(color)).on_hover_text(meaning);
                let mut text = egui::text::LayoutJob::default();
                let font = egui::TextStyle::Body.resolve(ui.style());
                let format = |color| egui::TextFormat::simple(font.clone(), color);
                text.append(&problem.place, 0.0, format(ui.visuals().strong_text_color()));
                text.append(&quoted(&problem.message), 8.0, format(ui.visuals().text_color()));
                let label = if is_full { Label::new(text).wrap() } else { Label::new(text).truncate() };
                match show {
                    Some((tip, command)) => {
                        let response = ui.add(label.sense(Sense::click())).on_hover_cursor(CursorIcon::PointingHand);
                        if response.on_hover_text(tip).clicked() {
                            commands.push(command);
                        }
                    }
                    None => {
                        ui.add(label);
                    }
                }
            });
        });
    });
}
