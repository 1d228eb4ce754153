//! Which scene is shown: it is opened, loaded anew, and given up where it cannot be rendered.

use std::path::PathBuf;
use std::sync::Arc;

use super::{State, View};
use crate::app::document::Document;
use crate::app::opening::Opening;
use crate::scene::camera::Camera;
use crate::scene::{Description, SceneError};
use crate::session::SceneReport;

impl State {
    pub fn opening(&self) -> Option<&Opening> {
        self.opening.as_ref()
    }

    /// A scene is being read from now on, instead of any other. Returns the number by which [`Self::end_opening`] knows it.
    pub fn begin_opening(&mut self, name: PathBuf, may_lose_edits: bool) -> u64 {
        let id = self.next_opening;
        self.next_opening += 1;
        self.opening = Some(Opening { id, name, may_lose_edits });
        id
    }

    /// That scene has been read; `None` where it is not wanted any more.
    pub fn end_opening(&mut self, id: u64) -> Option<Opening> {
        self.opening.take_if(|opening| opening.id == id)
    }

    /// No scene is wanted but the one that is there.
    pub fn cancel_opening(&mut self) {
        self.opening = None;
    }

    pub fn open(&mut self, description: Description) {
        if let Some(source) = &description.source
            && !source.is_builtin
        {
            self.settings.remember(&source.path);
        }
        self.settings.take_first_panes(&description);
        self.view.active_pane = 0;
        self.show_document(Document::new(Arc::new(description)));
    }

    /// Shows a scene from an autosave, which is in no file as it is; "Save" writes to `path`.
    pub fn restore(&mut self, description: Description, path: Option<PathBuf>) {
        self.show_document(Document::restored(Arc::new(description), path));
    }

    fn show_document(&mut self, document: Document) {
        let camera = document.description().camera;
        self.view = View { camera, zoom: 1.0, zoom_center: [0.5; 2], ..self.view };
        self.document = document;
        self.has_scene = true;
        self.outside_change = None;
        self.selected = None;
        self.renaming = None;
        self.inspection = None;
        self.slice = None;
        self.last_pick = None;
        self.earlier_views.clear();
        self.problems = None;
        self.forget_reference_image();
        self.invalidate();
        self.epoch_floor = self.epoch;
    }

    /// Shows the scene as its file says now; `Err` where the file is broken: then the scene stays as it is.
    pub fn reload(&mut self, read: Result<Description, String>) {
        if let Some(id) = self.broken_file.take() {
            self.notices.retain(|notice| notice.id != id);
        }
        let description = match read {
            Ok(description) => Arc::new(description),
            Err(why) => {
                self.broken_file = Some(self.next_notice);
                return self.notify_error(why);
            }
        };
        // A view that was not moved goes along with the scene's own.
        if self.view.camera == self.document.description().camera {
            self.view.camera = description.camera;
        }
        self.document.reload(description);
        self.outside_change = None;
        self.renaming = None;
        self.after_history();
    }

    pub fn scene_ready(&mut self, report: Arc<SceneReport>) {
        if Arc::ptr_eq(&report.prepared.description, self.document.description()) {
            self.last_good = Some(self.document.clone());
        }
        if report.epoch >= self.epoch_floor {
            if report.problems.is_some() {
                self.problems = Some(Arc::clone(&report));
            }
            // More rays, shot in the background, may have found another answer: what was rendered with the old one is out of date.
            let is_other = self.report.as_ref().is_some_and(|known| {
                Arc::ptr_eq(&known.prepared.scene, &report.prepared.scene)
                    && !known.prepared.table.says_the_same(&report.prepared.table)
            });
            self.report = Some(report);
            if is_other {
                self.notify("More rays have changed what rectification found. The images begin anew.");
                self.invalidate();
            }
        }
    }

    /// A request could not be served: says so and returns to what can be shown. Answers whether it did.
    pub fn scene_failed(&mut self, epoch: u64, error: &SceneError) -> bool {
        self.notify_error(error.to_string());
        // A later edit may have mended it already.
        if epoch == self.epoch
            && let Some(good) = self.last_good.clone()
            && !Arc::ptr_eq(good.description(), self.document.description())
        {
            let is_same_file = good.path == self.document.path;
            if !is_same_file || Camera::new(&self.view.camera).is_err() {
                self.view.camera = good.description().camera;
            }
            self.document = good;
            self.invalidate();
            return true;
        }
        false
    }
}
