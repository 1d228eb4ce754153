//! How the film's camera sees the scene: where its points are on the film.

use egui::Pos2;
use glam::DVec3;

use crate::app::state::State;
use crate::scene::camera::Camera;

/// What is closer to the camera's plane than this share of its distance is not seen.
const LEAST_DEPTH: f64 = 0.05;

/// The camera of the panes.
#[derive(Debug, Clone)]
pub struct Sight {
    pub camera: Camera,
    /// Width over height of the film.
    pub aspect: f64,
}

impl Sight {
    /// `None` before the first pane has a size.
    pub fn of(state: &State) -> Option<Self> {
        let [width, height] = state.film_size().map(f64::from);
        let camera = Camera::new(&state.film_camera()).ok().filter(|_| width > 0.0 && height > 0.0)?;
        Some(Self { camera, aspect: width / height })
    }

    /// The point of the film, in [0, 1]² where it is inside, at which `place` is seen; `None` behind the camera.
    pub fn film(&self, place: DVec3) -> Option<Pos2> {
        let to = place - self.camera.position;
        let depth = to.dot(self.camera.forward);
        (depth > LEAST_DEPTH * to.length()).then(|| {
            let half = depth * self.camera.tan_half_fov;
            let x = to.dot(self.camera.right) / (half * self.aspect);
            let y = to.dot(self.camera.up) / half;
            egui::pos2((0.5 + 0.5 * x) as f32, (0.5 - 0.5 * y) as f32)
        })
    }
}
