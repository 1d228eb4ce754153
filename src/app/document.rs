//! The scene being edited, with its history.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::edit::EditKey;
use crate::scene::Description;

/// Edits that can be undone.
const MAX_UNDO: usize = 200;
/// Edits of one value follow each other within this many seconds to count as one.
const MERGE_SECONDS: f64 = 0.8;

/// A description with a number of its own, so that "unsaved" needs no comparison of whole scenes.
#[derive(Debug, Clone)]
struct Version {
    description: Arc<Description>,
    revision: u64,
}

#[derive(Debug, Clone)]
pub struct Document {
    current: Version,
    saved_revision: u64,
    next_revision: u64,
    undo: Vec<(EditKey, Version)>,
    redo: Vec<(EditKey, Version)>,
    last_edit_secs: f64,
    /// What was there before the drag that is under way, to return to if it is given up.
    before_gesture: Option<Box<Self>>,
    /// Where "Save" writes; `None` for a built-in scene that was never saved.
    pub path: Option<PathBuf>,
}

impl Document {
    pub fn new(description: Arc<Description>) -> Self {
        let path = description.source.as_ref().filter(|source| source.is_own_file()).map(|source| source.path.clone());
        Self {
            current: Version { description, revision: 0 },
            saved_revision: 0,
            next_revision: 1,
            undo: Vec::new(),
            redo: Vec::new(),
            last_edit_secs: f64::NEG_INFINITY,
            before_gesture: None,
            path,
        }
    }

    /// A scene with edits that no file has, from an autosave; "Save" writes to `path`.
    pub fn restored(description: Arc<Description>, path: Option<PathBuf>) -> Self {
        let mut document = Self::new(description);
        document.current.revision = document.next_revision;
        document.next_revision += 1;
        document.path = path;
        document
    }

    /// The file that is read again when it has changed: the scene's own, or that of another format.
    pub fn watched_path(&self) -> Option<&Path> {
        let source = self.current.description.source.as_deref().filter(|source| source.import.is_some());
        self.path.as_deref().or_else(|| source.map(|source| &*source.path))
    }

    pub fn description(&self) -> &Arc<Description> {
        &self.current.description
    }

    /// Whether there are edits that no file has.
    pub fn is_dirty(&self) -> bool {
        self.current.revision != self.saved_revision
    }

    /// Says that the present version is in the file at `path`, which was written from `description`.
    pub fn mark_saved(&mut self, path: PathBuf, description: &Arc<Description>) {
        self.path = Some(path);
        if Arc::ptr_eq(description, &self.current.description) {
            self.saved_revision = self.current.revision;
        }
    }

    /// Replaces the scene by what its file says now; "Undo" goes back to what was there.
    pub fn reload(&mut self, description: Arc<Description>) {
        self.before_gesture = None;
        self.edit(EditKey::single("loading the changed file"), f64::NEG_INFINITY, Description::clone(&description));
        self.current.description = description;
        self.saved_revision = self.current.revision;
    }

    /// Replaces the scene by an edited one. `now_secs` is any steady clock.
    pub fn edit(&mut self, key: EditKey, now_secs: f64, description: Description) {
        let version = Version { description: Arc::new(description), revision: self.next_revision };
        self.next_revision += 1;
        let old = std::mem::replace(&mut self.current, version);
        // In a drag every edit after the first continues, however slow.
        let in_gesture = self.before_gesture.as_ref().is_some_and(|before| before.current.revision != old.revision);
        let is_same = |last: &EditKey| key.continues(last) || (in_gesture && *last == key);
        let continues = (now_secs - self.last_edit_secs < MERGE_SECONDS || in_gesture)
            && self.undo.last().is_some_and(|(last, _)| is_same(last))
            && self.redo.is_empty();
        if !continues {
            self.undo.push((key, old));
            if self.undo.len() > MAX_UNDO {
                self.undo.remove(0);
            }
        }
        self.redo.clear();
        self.last_edit_secs = now_secs;
    }

    /// From now on edits of one thing are undone as one, however slow, until [`Self::end_gesture`].
    pub fn begin_gesture(&mut self) {
        self.end_gesture();
        self.before_gesture = Some(Box::new(self.clone()));
    }

    pub fn has_gesture(&self) -> bool {
        self.before_gesture.is_some()
    }

    pub fn end_gesture(&mut self) {
        self.before_gesture = None;
        self.last_edit_secs = f64::NEG_INFINITY;
    }

    /// The drag never was; `false` when there is none.
    pub fn cancel_gesture(&mut self) -> bool {
        let Some(before) = self.before_gesture.take() else { return false };
        (self.current, self.undo, self.redo) = (before.current, before.undo, before.redo);
        self.last_edit_secs = f64::NEG_INFINITY;
        true
    }

    pub fn undo_label(&self) -> Option<&str> {
        self.undo.last().map(|(key, _)| key.label())
    }

    pub fn redo_label(&self) -> Option<&str> {
        self.redo.last().map(|(key, _)| key.label())
    }

    /// Steps back; `false` when there is nothing to undo.
    pub fn undo(&mut self) -> bool {
        let Some((key, version)) = self.undo.pop() else { return false };
        self.redo.push((key, std::mem::replace(&mut self.current, version)));
        self.last_edit_secs = f64::NEG_INFINITY;
        true
    }

    /// Steps forward; `false` when there is nothing to do again.
    pub fn redo(&mut self) -> bool {
        let Some((key, version)) = self.redo.pop() else { return false };
        self.undo.push((key, std::mem::replace(&mut self.current, version)));
        self.last_edit_secs = f64::NEG_INFINITY;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::command::MediumRef;
    use crate::app::edit::{Edit, MediumEdit};
    use crate::app::opening::no_scene;
    use crate::optics::Ior;

    fn set(document: &mut Document, now_secs: f64, ior: f64) {
        let edit = Edit::Medium(MediumRef::World, MediumEdit::Ior(Ior::Constant(ior)));
        let edited = edit.apply(document.description()).unwrap().unwrap();
        document.edit(edit.key(), now_secs, edited);
    }

    fn ior(document: &Document) -> f64 {
        document.description().world.ior.ior()
    }

    #[test]
    fn a_drag_is_undone_as_one_and_a_later_edit_on_its_own() {
        let mut document = Document::new(no_scene());
        assert!(!document.is_dirty());
        set(&mut document, 10.0, 1.1);
        set(&mut document, 10.1, 1.2);
        set(&mut document, 20.0, 1.3);
        assert!(document.is_dirty());
        assert!(document.undo());
        assert_eq!(ior(&document), 1.2);
        assert!(document.undo());
        assert_eq!(ior(&document), 1.0);
        assert!(!document.is_dirty());
        assert!(!document.undo());
        assert!(document.redo() && document.redo() && !document.redo());
        assert_eq!(ior(&document), 1.3);
    }

    #[test]
    fn what_was_restored_is_in_no_file_until_it_is_saved() {
        let mut document = Document::restored(no_scene(), Some("a.toml".into()));
        assert!(document.is_dirty() && !document.undo());
        set(&mut document, 1.0, 1.1);
        assert!(document.undo() && document.is_dirty());
        let description = Arc::clone(document.description());
        document.mark_saved("a.toml".into(), &description);
        assert!(!document.is_dirty());
    }

    #[test]
    fn an_edit_after_undo_drops_what_could_be_redone() {
        let mut document = Document::new(no_scene());
        set(&mut document, 1.0, 1.1);
        document.undo();
        set(&mut document, 1.1, 1.2);
        assert!(document.redo_label().is_none());
        document.undo();
        assert_eq!(ior(&document), 1.0);
    }

    #[test]
    fn a_drag_is_one_step_however_slow_and_can_be_given_up() {
        let mut document = Document::new(no_scene());
        set(&mut document, 1.0, 1.1);
        document.begin_gesture();
        set(&mut document, 1.1, 1.2);
        set(&mut document, 100.0, 1.3);
        document.end_gesture();
        set(&mut document, 100.1, 1.4);
        assert!(document.undo());
        assert_eq!(ior(&document), 1.3);
        assert!(document.undo());
        assert_eq!(ior(&document), 1.1, "the drag did not continue the edit before it");
        // Given up: what could be done again still can, and the version is the same one.
        let before = Arc::clone(document.description());
        document.begin_gesture();
        set(&mut document, 200.0, 1.9);
        assert!(document.cancel_gesture() && !document.cancel_gesture());
        assert!(Arc::ptr_eq(document.description(), &before));
        assert!(document.redo() && document.redo() && !document.redo());
        assert_eq!(ior(&document), 1.4);
    }

    #[test]
    fn what_a_changed_file_says_is_in_the_file_and_can_be_undone() {
        let mut document = Document::new(no_scene());
        set(&mut document, 1.0, 1.1);
        let before = Arc::clone(document.description());
        let changed = Arc::new(Description { name: "other".into(), ..(*no_scene()).clone() });
        document.reload(Arc::clone(&changed));
        assert!(!document.is_dirty() && Arc::ptr_eq(document.description(), &changed));
        assert!(document.undo() && document.is_dirty() && Arc::ptr_eq(document.description(), &before));
        assert!(document.redo() && !document.is_dirty());
    }
}
