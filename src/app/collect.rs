//! What the threads have done, taken in once a frame.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::App;
use super::Command;
use super::autosave::Autosaver;
use super::build;
use super::files::Outcome;
use super::files::Purpose;
use super::measurement::Given;
use super::panels::dialogs::PathPrompt;
use super::state;
use crate::formats::{MESH_ENDINGS, SCENE_ENDINGS};

impl App {
    /// Takes in what the threads have done.
    pub(super) fn collect(&mut self, ctx: &egui::Context) {
        let board = Arc::clone(self.worker.board());
        if let Some((epoch, error)) = board.take_failure() {
            let is_back = self.state.scene_failed(epoch, &error);
            // The restored scene could not be shown: it is offered again.
            self.state.left_behind.extend(self.restoring.take_if(|_| is_back).map(|(found, _)| found));
        }
        if let Some(report) = board.scene()
            && self.state.report.as_ref().is_none_or(|known| !Arc::ptr_eq(known, &report))
        {
            self.state.scene_ready(report);
        }
        self.state.preparation = board.preparation();
        self.state.set_graphics(board.graphics());
        self.state.films = board.snapshots();
        self.state.measurement.set_truth(board.ground_truth());
        if let Some(results) = self.measurer.take_finished() {
            self.state.measurement.results = results;
        }
        if let Some(verdicts) = self.judge.take_finished() {
            self.state.verdicts = verdicts;
        }
        if let Some(report) = self.autosaver.as_ref().map(Autosaver::take_finished) {
            self.state.left_behind.extend(report.found);
            report.failure.into_iter().for_each(|failure| self.state.notify_error(failure));
        }
        if self.watcher.take_finished().has_changed {
            if self.state.document.is_dirty() {
                self.state.outside_change = Some(state::OutsideChange::Offered);
            } else {
                self.reload();
            }
        }
        if let Some(refusal) = self.refusals.take() {
            self.state.notify_error(format!("The graphics card cannot show this: {refusal}"));
        }
        let (floor, picture_floor) = (self.state.epoch_floor, self.state.picture_floor());
        self.viewport.upload(ctx, self.developer.take_finished(), floor, picture_floor);
        self.viewport.upload(ctx, self.slicer.take_finished(), floor, picture_floor);
        while let Some(outcome) = self.files.poll() {
            match outcome {
                Outcome::Chosen(purpose, path) | Outcome::IsFree(purpose, path) => {
                    self.apply(ctx, purpose.command_anyway(path));
                }
                Outcome::ChosenUnasked(purpose, path) => self.apply(ctx, purpose.command(path)),
                Outcome::IsThere(purpose, path) => self.dialogs.overwriting = Some((purpose, path)),
                Outcome::NoDialog(purpose, suggestion) => {
                    self.dialogs.prompt = Some(PathPrompt::new(purpose, &suggestion));
                }
                Outcome::Opened(id, description, found) => {
                    if let Some(opening) = self.state.end_opening(id) {
                        self.opened(&opening, *description, found);
                    }
                }
                Outcome::NotOpened(id, message) => {
                    if self.state.end_opening(id).is_some() {
                        self.state.notify_error(message);
                        self.open_default_instead_of_nothing();
                    }
                }
                Outcome::EnvironmentRead(path, image) => {
                    let command = Command::Edit(self.state.environment_of(path, image));
                    self.apply(ctx, command);
                }
                Outcome::ReferenceRead(image) => {
                    image
                        .notes
                        .iter()
                        .for_each(|note| self.state.notify(format!("{}: {}", image.name(), note.message)));
                    self.apply(ctx, Command::SetReferenceImage(Given(Some(image))));
                }
                Outcome::TextureRead(object, path, image) => {
                    if let Some(edit) = self.state.texture_of(&object, path, image) {
                        self.apply(ctx, Command::Edit(edit));
                    }
                }
                Outcome::Mesh(objects) => {
                    let state = &self.state;
                    let (scene, view) = (state.document.description(), &state.view.camera);
                    let edit = build::mesh_edit(scene, view, state.selected.as_deref(), objects);
                    self.apply(ctx, Command::Edit(edit));
                }
                Outcome::Reloaded(path, read) => {
                    if self.state.document.watched_path() == Some(&path) {
                        self.state.reload(read.map(|description| *description));
                    }
                }
                Outcome::Saved(path, description) => {
                    self.trust_files();
                    self.state.outside_change = None;
                    self.state.document.mark_saved(path.clone(), &description);
                    self.state.settings.remember(&path);
                    self.state.notify(format!("Saved {}", path.display()));
                }
                Outcome::Exported(path) => self.state.notify(format!("Exported {}", path.display())),
                Outcome::Failed(message) => self.state.notify_error(message),
            }
        }
    }

    /// Files that were dropped on the window: of several, that which others belong to.
    pub(super) fn dropped(&self, ctx: &egui::Context) -> Option<Command> {
        let paths: Vec<PathBuf> =
            ctx.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        let is_of = |path: &Path, endings: &[&str]| {
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
            endings.contains(&&*ending)
        };
        let first = |endings: &[&str]| paths.iter().find(|path| is_of(path, endings)).cloned();
        let image = Purpose::Environment.endings();
        (first(SCENE_ENDINGS).map(Command::Open))
            .or_else(|| first(MESH_ENDINGS).map(Command::ReadMesh))
            .or_else(|| first(image).map(Command::ReadEnvironment))
            .or_else(|| paths.first().cloned().map(Command::Open))
    }
}
