//! Commands, where they need files, threads or the window itself; all others go on to the state.

use std::sync::Arc;

use super::App;
use super::Command;
use super::Edit;
use super::ExportKind;
use super::InterfaceScale;
use super::build;
use super::files::Purpose;

impl App {
    pub fn apply(&mut self, ctx: &egui::Context, command: Command) {
        match command {
            Command::New if self.state.document.is_dirty() => self.dialogs.leaving = Some(Command::NewAnyway),
            Command::New | Command::NewAnyway => {
                self.state.cancel_opening();
                self.state.open(build::empty_scene());
                self.viewport.forget();
            }
            Command::AskMesh => self.ask(Purpose::Mesh),
            Command::ReadMesh(path) => self.read_mesh(path),
            Command::AskOpen => self.ask(Purpose::Open),
            Command::AskSaveAs => self.ask(Purpose::SaveAs),
            Command::AskExport(kind) => self.ask(Purpose::Export(kind)),
            Command::AskEnvironmentImage => self.ask(Purpose::Environment),
            Command::ReadEnvironment(path) => self.files.read_environment(path),
            Command::AskReferenceImage => self.ask(Purpose::Reference),
            Command::ReadReferenceImage(path) => self.files.read_reference(path),
            Command::AskTexture => {
                self.state.texture_for = self.state.selected.clone();
                self.ask(Purpose::Texture);
            }
            Command::ReadTexture(path) => {
                let object = self.state.texture_for.take().or_else(|| self.state.selected.clone());
                if let Some(object) = object {
                    self.files.read_texture(object, path);
                }
            }
            Command::Open(name_or_path) if self.state.document.is_dirty() => {
                self.dialogs.leaving = Some(Command::OpenAnyway(name_or_path));
            }
            Command::Open(name_or_path) => self.open(name_or_path, false),
            Command::OpenAnyway(name_or_path) => self.open(name_or_path, true),
            Command::CancelOpening => {
                self.state.cancel_opening();
                self.open_default_instead_of_nothing();
            }
            Command::CancelPreparation => {
                if let Some(preparation) = &self.state.preparation {
                    preparation.give_up();
                }
                if self.state.last_good.is_none() && !self.state.document.is_dirty() {
                    self.open(crate::formats::builtin::DEFAULT.into(), true);
                }
            }
            Command::RestoreEdits(path) if self.state.document.is_dirty() => {
                self.dialogs.leaving = Some(Command::RestoreEditsAnyway(path));
            }
            Command::RestoreEdits(path) | Command::RestoreEditsAnyway(path) => {
                let found = self.state.left_behind.iter().find(|found| found.slot.path() == path);
                if let Some(found) = found.cloned() {
                    let id = self.state.begin_opening(found.name().into(), true);
                    self.files.restore(id, found);
                }
            }
            Command::DiscardEdits(path) => {
                for found in self.state.left_behind.extract_if(.., |found| found.slot.path() == path) {
                    self.files.discard(found);
                }
            }
            Command::Save if self.state.outside_change.is_some() && self.state.document.path.is_some() => {
                self.dialogs.is_outdated = true;
            }
            Command::LoadChanged => self.reload(),
            Command::Save | Command::SaveAnyway => match self.state.document.path.clone() {
                Some(path) => self.files.save(Arc::clone(self.state.document.description()), path),
                None => self.ask(Purpose::SaveAs),
            },
            Command::SaveAs(path) => self.files.look(Purpose::SaveAs, path),
            Command::SaveAsAnyway(path) => {
                // A new scene is called like its first file.
                if let Some(stem) = path.file_stem()
                    && self.state.document.description().name == build::UNTITLED
                {
                    self.apply(ctx, Command::Edit(Edit::Name(stem.to_string_lossy().into_owned())));
                }
                self.files.save(Arc::clone(self.state.document.description()), path);
            }
            Command::Export(kind, path) => self.files.look(Purpose::Export(kind), path),
            Command::ExportAnyway(kind @ (ExportKind::ShownPane | ExportKind::ShownPanes), path) => {
                self.begin_capture(kind == ExportKind::ShownPanes, Some(path));
            }
            Command::ExportAnyway(kind, path) => self.export(kind, path),
            Command::KeepSnapshot(id) => self.keep_snapshot(id),
            Command::SendToTev => self.tev_serial += 1,
            Command::AskTevAddress => self.dialogs.tev = Some(self.state.settings.tev_address.clone()),
            Command::CopyPane => self.begin_capture(false, None),
            Command::CopyPanes => self.begin_capture(true, None),
            Command::CopyValues => self.copy_values(ctx),
            Command::StepInterfaceScale(step) => self.step_interface_scale(ctx, step),
            Command::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            Command::QuitAnyway => {
                self.may_close = true;
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Command::Escape if self.dialogs.close() => {}
            other => self.state.apply(other, self.start.elapsed().as_secs_f64()),
        }
    }

    pub(super) fn step_interface_scale(&mut self, ctx: &egui::Context, step: i32) {
        let now = ctx.zoom_factor();
        let factors = InterfaceScale::FACTORS;
        let next = if step > 0 {
            factors.into_iter().find(|factor| *factor > now + 0.01)
        } else {
            factors.into_iter().rev().find(|factor| *factor < now - 0.01)
        };
        if let Some(factor) = next {
            self.state.apply(Command::SetInterfaceScale(InterfaceScale::Factor(factor)), 0.0);
        }
    }
}
