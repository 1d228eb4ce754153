//! Questions: a path where the system has no dialog for it, whether to write over a file, and whether to lose unsaved changes.

use std::path::{Path, PathBuf};

use egui::{Context, Key, TextEdit, Ui};

use crate::app::command::Command;
use crate::app::files::Purpose;
use crate::app::modal;
use crate::app::state::State;
use crate::app::widgets::note;
use crate::export::tev::DEFAULT_ADDRESS;

/// The questions that are open.
#[derive(Default)]
pub struct Dialogs {
    pub prompt: Option<PathPrompt>,
    /// What the user wants to do although it loses unsaved changes.
    pub leaving: Option<Command>,
    /// What would be written over a file, and which.
    pub overwriting: Option<(Purpose, PathBuf)>,
    /// Where tev listens, being typed.
    pub tev: Option<String>,
    /// Whether to save over a file that another program has changed is asked.
    pub is_outdated: bool,
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
        self.is_outdated
            || self.prompt.is_some()
            || self.leaving.is_some()
            || self.overwriting.is_some()
            || self.tev.is_some()
    }

    /// Closes what is on top; `false` if nothing was open.
    pub fn close(&mut self) -> bool {
        std::mem::take(&mut self.is_outdated)
            || self.overwriting.take().is_some()
            || self.leaving.take().is_some()
            || self.tev.take().is_some()
            || self.prompt.take().is_some()
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
        let answer = modal::show(ctx, "Address of tev", self.tev.is_some(), |ui, is_opening| {
            self.tev.as_mut().is_none_or(|address| tev_ui(ui, address, is_opening, commands))
        });
        if answer.is_closed || answer.inner == Some(true) {
            self.tev = None;
        }
        let answer = modal::show(ctx, "Replace a file", self.overwriting.is_some(), |ui, is_opening| {
            let asked = self.overwriting.as_ref();
            asked.is_none_or(|(purpose, path)| overwriting_ui(ui, *purpose, path, is_opening, commands))
        });
        if answer.is_closed || answer.inner == Some(true) {
            self.overwriting = None;
        }
        let answer = modal::show(ctx, "File has changed", self.is_outdated, |ui, is_opening| {
            outdated_ui(ui, is_opening, state, commands)
        });
        if answer.is_closed || answer.inner == Some(true) {
            self.is_outdated = false;
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
            let verb = if self.purpose.is_reading() { "Open" } else { "Save" };
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
fn outdated_ui(ui: &mut Ui, is_opening: bool, state: &State, commands: &mut Vec<Command>) -> bool {
    ui.set_width((ui.ctx().content_rect().width() - 80.0).min(420.0));
    ui.heading("The file has changed on disk");
    let path = state.document.path.as_deref().unwrap_or(Path::new("")).display();
    ui.label(format!("Another program has written to {path} since it was read. Saving replaces what it wrote."));
    ui.add_space(10.0);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let save_as = ui.button("Save as…").clicked();
        let stay = ui.button("Cancel");
        if is_opening {
            stay.request_focus();
        }
        let stay = stay.clicked();
        let overwrite = ui.button("Overwrite").clicked();
        if save_as {
            commands.push(Command::AskSaveAs);
        }
        if overwrite {
            commands.push(Command::SaveAnyway);
        }
        save_as || stay || overwrite
    })
    .inner
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
            Command::NewAnyway => "New without saving",
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

/// `true` when the question has been answered.
fn overwriting_ui(ui: &mut Ui, purpose: Purpose, path: &Path, is_opening: bool, commands: &mut Vec<Command>) -> bool {
    ui.set_width((ui.ctx().content_rect().width() - 80.0).min(420.0));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    ui.heading(format!("Replace “{name}”?"));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let place = folder.map_or("here".to_owned(), |folder| format!("in {}", folder.display()));
    ui.label(format!("There is a file of that name {place}. Its contents would be lost."));
    ui.add_space(10.0);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let keep = ui.button("Cancel");
        if is_opening {
            keep.request_focus();
        }
        let keep = keep.clicked();
        let other = ui.button("Other name…").clicked();
        let replace = ui.button("Replace").clicked();
        if replace {
            commands.push(purpose.command_anyway(path.to_owned()));
        }
        if other {
            commands.push(purpose.question());
        }
        keep || other || replace
    })
    .inner
}

/// `true` when the question has been answered.
fn tev_ui(ui: &mut Ui, address: &mut String, is_opening: bool, commands: &mut Vec<Command>) -> bool {
    ui.set_width((ui.ctx().content_rect().width() - 80.0).min(360.0));
    ui.heading("Where tev listens");
    ui.label(note(ui, "HOST:PORT, as tev was started with --host. Empty: the usual address."));
    ui.add_space(6.0);
    let field = TextEdit::singleline(address).desired_width(f32::INFINITY).hint_text(DEFAULT_ADDRESS);
    let field = ui.add(field).accessible_name("Address of tev");
    if is_opening {
        field.request_focus();
    }
    let is_entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    ui.add_space(8.0);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let is_given = ui.button("Use it").clicked() || is_entered;
        if is_given {
            commands.push(Command::SetTevAddress(address.clone()));
        }
        ui.button("Cancel").clicked() || is_given
    })
    .inner
}
