//! The scene's camera and environment as the window edits them.

use std::path::PathBuf;
use std::sync::Arc;

use super::State;
use super::view::ray_through;
use crate::app::command::Command;
use crate::app::edit::{Edit, ObjectEdit};
use crate::scene::camera::Camera;
use crate::scene::description::{CameraDescription, Environment, Paint, UvTransform};
use crate::scene::environment::EnvironmentImage;
use crate::scene::texture::TextureImage;
use crate::transport::inspect::{Follow, trace};

/// What of the world is edited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorldPart {
    /// The global medium.
    Medium,
    Environment,
    Camera,
}

impl State {
    /// The view goes along with the scene's camera where it was that camera's before an edit.
    pub(super) fn follow_camera(&mut self, before: CameraDescription) {
        let camera = self.document.description().camera;
        if self.view.camera == before && camera != before {
            self.view.camera = camera;
        }
    }

    /// Puts the focus of the scene's camera on what is seen at a point in [0, 1]² of the film.
    pub(super) fn focus_at(&mut self, point: [f64; 2], now_secs: f64) {
        self.is_focusing = false;
        let (Some(report), Ok(camera)) = (&self.report, Camera::new(&self.film_camera())) else { return };
        let ray = ray_through(&camera, self.size.film, point);
        let mode = self.settings.panes[self.view.active_pane].inspected_mode();
        let path = trace(&report.prepared, mode, ray, Follow::Transmit, 0, Some(1));
        let Some(vertex) = path.vertices.first() else {
            self.notify("There is nothing at that place to focus on.");
            return;
        };
        // What is in focus lies in a plane across the view.
        let distance = (glam::DVec3::from(vertex.position) - camera.position).dot(camera.forward);
        let focused = CameraDescription { focus_distance: Some(distance), ..self.view.camera };
        self.apply(Command::Edit(Edit::Camera(focused)), now_secs);
        self.set_camera(focused);
    }

    /// The edit that puts an image, from the file at `path`, around the scene. It is turned and scaled as the one before it.
    pub fn environment_of(&self, path: PathBuf, image: EnvironmentImage) -> Edit {
        let (rotation, scale) = match &self.document.description().environment {
            Environment::Image { rotation, scale, .. } => (*rotation, *scale),
            _ => (0.0, 1.0),
        };
        let path = self.as_named(path);
        Edit::Environment(Environment::Image { path, image: Arc::new(image), rotation, scale })
    }

    /// The edit that puts an image, from the file at `path`, on a solid; `None` where there is none of that name. It is tinted and laid on as the one before it.
    pub fn texture_of(&self, object: &str, path: PathBuf, image: TextureImage) -> Option<Edit> {
        let (tint, uv) = match self.document.description().objects.find(object)?.solid()?.paint {
            Paint::Texture { tint, uv, .. } => (tint, uv),
            _ => ([1.0; 3], UvTransform::IDENTITY),
        };
        let paint = Paint::Texture { path: self.as_named(path), image: Arc::new(image), tint, uv };
        Some(Edit::Object(object.to_owned(), ObjectEdit::Paint(paint)))
    }

    /// A file's path as the scene names it.
    fn as_named(&self, path: PathBuf) -> PathBuf {
        let description = self.document.description();
        let source = description.source.as_ref().filter(|source| !source.is_builtin);
        let folder = source.and_then(|source| std::path::absolute(source.path.parent()?).ok());
        let absolute = std::path::absolute(&path).unwrap_or(path);
        // A scene and its images are moved together.
        match folder.and_then(|folder| absolute.strip_prefix(folder).ok().map(PathBuf::from)) {
            Some(relative) => relative,
            None => absolute,
        }
    }
}
