//! Questions: a path where the system has no dialog for it, and whether to lose unsaved changes.

use std::path::Path;

use egui::{Context, Key, TextEdit, Ui};

use crate::app::command::Command;
use crate::app::files::Purpose;
use crate::app::modal;
use crate::app::state::State;
use crate::app::widgets::note;

/// The questions that are open.
#[derive(Default)]
pub struct Dialogs {
    pub prompt: Option<PathPrompt>,
    /// What the user wants to do although it loses unsaved changes.
    pub leaving: Option<Command>,
}

/// Asks for a path.
pub struct PathPrompt {
    purpose: Purpose,
    text: String,
}

impl PathPrompt {
    pub fn new(purpose: Purpose, suggestion: &Path) -> Self {
        let absolute = match std::path::absolute(suggestion) {
            Ok(path) => path,
            // Nothing was suggested: begin where the program was started.
            Err(_) => std::env::current_dir().map(|folder| folder.join("")).unwrap_or_default(),
        };
        Self { purpose, text: absolute.display().to_string() }
    }
}

impl Dialogs {
    pub fn is_open(&self) -> bool {
        self.prompt.is_some() || self.leaving.is_some()
    }

    /// Closes what is on top; `false` if nothing was open.
    pub fn close(&mut self) -> bool {
        self.leaving.take().is_some() || self.prompt.take().is_some()
    }

    pub fn show(&mut self, ctx: &Context, state: &State, commands: &mut Vec<Command>) {
        let answer = modal::show(ctx, "Path", self.prompt.is_some(), |ui, is_opening| {
            self.prompt.as_mut().is_none_or(|prompt| prompt.show(ui, is_opening, commands))
        });
        if answer.is_closed || answer.inner == Some(true) {
            self.prompt = None;
        }
        let answer = modal::show(ctx, "Question", self.leaving.is_some(), |ui, is_opening| {
            self.leaving.as_ref().is_none_or(|leaving| leaving_ui(ui, leaving, is_opening, state, commands))
        });
        if answer.is_closed || answer.inner == Some(true) {
            self.leaving = None;
        }
    }
}

impl PathPrompt {
    /// `true` when the question has been answered.
    fn show(&mut self, ui: &mut Ui, is_opening: bool, commands: &mut Vec<Command>) -> bool {
        ui.set_width((ui.ctx().content_rect().width() - 80.0).min(520.0));
        ui.heading(self.purpose.title());
        ui.label(note(ui, "This system offers no file dialog; type the path."));
        ui.add_space(6.0);
        let field = ui
            .add(TextEdit::singleline(&mut self.text).desired_width(f32::INFINITY).hint_text("Path"))
            .accessible_name("Path");
        if is_opening {
            field.request_focus();
        }
        let is_entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        ui.add_space(8.0);
        let path = self.text.trim();
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let verb = if self.purpose == Purpose::Open { "Open" } else { "Save" };
            let is_clicked = ui.add_enabled(!path.is_empty(), egui::Button::new(verb)).clicked();
            let is_given = (is_clicked || is_entered) && !path.is_empty();
            if is_given {
                commands.push(self.purpose.command(self.purpose.extended(Path::new(path))));
            }
            ui.button("Cancel").clicked() || is_given
        })
        .inner
    }
}

/// `true` when the question has been answered.
fn leaving_ui(ui: &mut Ui, leaving: &Command, is_opening: bool, state: &State, commands: &mut Vec<Command>) -> bool {
    ui.set_width((ui.ctx().content_rect().width() - 80.0).min(380.0));
    ui.heading("Unsaved changes");
    ui.label(format!("“{}” has edits that no file has.", state.document.description().name));
    ui.add_space(10.0);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let save = ui.button("Save…");
        if is_opening {
            save.request_focus();
        }
        let save = save.clicked();
        let stay = ui.button("Stay").clicked();
        let verb = match leaving {
            Command::QuitAnyway => "Quit without saving",
            Command::RestoreEditsAnyway(_) => "Restore without saving",
            _ => "Open without saving",
        };
        let lose = ui.button(verb).clicked();
        if save {
            commands.push(Command::Save);
        }
        if lose {
            commands.push(leaving.clone());
        }
        save || stay || lose
    })
    .inner
}
