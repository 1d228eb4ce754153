//! Scenes that are opened, watched and kept.

use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;

use super::App;
use super::Command;
use super::autosave;
use super::autosave::Edits;
use super::autosave::Found;
use super::opening::Opening;
use super::watch;
use crate::scene;

impl App {
    /// Reads the scene's file again, which another program has changed.
    pub(super) fn reload(&self) {
        if let Some(path) = self.state.document.watched_path() {
            self.files.reload(path.to_owned());
        }
    }

    /// Keeps an eye on the files of the scene that is shown.
    pub(super) fn watch_files(&mut self) {
        let document = &self.state.document;
        let (known, order) = &mut self.watched;
        if known.as_ref().is_none_or(|known| !Arc::ptr_eq(known, document.description())) {
            order.files = watch::files_of(document.description(), document.path.as_deref());
            *known = Some(Arc::clone(document.description()));
        }
        self.watcher.set_order(order);
    }

    /// The scene's files are as the program knows them now.
    pub(super) fn trust_files(&mut self) {
        let (known, order) = &mut self.watched;
        *known = None;
        order.round += 1;
    }

    pub(super) fn open(&mut self, name_or_path: PathBuf, may_lose_edits: bool) {
        let id = self.state.begin_opening(name_or_path.clone(), may_lose_edits);
        self.files.open(id, name_or_path);
    }

    /// Reads a mesh that is to become part of the scene. In the scene it goes by a path beside the scene's own file where it lies there.
    pub(super) fn read_mesh(&mut self, path: PathBuf) {
        let source = self.state.document.description().source.as_ref().filter(|source| !source.is_builtin);
        let folder = source.and_then(|source| std::path::absolute(source.path.parent()?).ok());
        let Ok(path) = std::path::absolute(&path) else { return };
        let written = folder.and_then(|folder| path.strip_prefix(folder).ok()).unwrap_or(&path).to_owned();
        if written.to_str().is_none() {
            let name = path.display();
            self.state.notify_error(format!("{name}: a scene file cannot name this path, for it is not UTF-8."));
            return;
        }
        self.files.read_mesh(path, written);
    }

    /// Where the first scene cannot be shown, or is not wanted any more.
    pub(super) fn open_default_instead_of_nothing(&mut self) {
        if !self.state.has_scene {
            self.open(crate::formats::builtin::DEFAULT.into(), true);
        }
    }

    /// Shows a scene that has been read, from an autosave if it comes from one.
    pub(super) fn opened(&mut self, opening: &Opening, description: scene::Description, found: Option<Found>) {
        if self.state.document.is_dirty() && !opening.may_lose_edits {
            // Edited while it was read.
            self.dialogs.leaving = Some(Command::OpenAnyway(opening.name.clone()));
            return;
        }
        match found {
            None => self.state.open(description),
            Some(found) => {
                self.state.restore(description, found.scene_path().map(Path::to_owned));
                self.state.left_behind.retain(|other| other.slot != found.slot);
                self.restoring = Some((found, Arc::clone(self.state.document.description())));
            }
        }
        self.trust_files();
        self.viewport.forget();
    }

    /// Tells the thread that keeps edits what to keep.
    pub(super) fn keep_edits(&mut self) {
        let Some(autosaver) = &self.autosaver else { return };
        let document = &self.state.document;
        let is_settled =
            |scene: &Arc<scene::Description>| self.state.is_prepared() || !Arc::ptr_eq(scene, document.description());
        if let Some((found, _)) = self.restoring.take_if(|(_, scene)| is_settled(scene)) {
            self.restored = Some(found.slot);
        }
        let is_kept = document.is_dirty() && !self.is_closing && self.restoring.is_none();
        let edits = || Edits { description: Arc::clone(document.description()), path: document.path.clone() };
        autosaver.set_order(&autosave::Order { edits: is_kept.then(edits), slot: self.restored.clone() });
    }
}
