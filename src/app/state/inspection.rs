//! The path under a pixel.

use super::State;
use super::view::ray_through;
use crate::scene::camera::Camera;
use crate::scene::description::CameraDescription;
use crate::tracking::Mode;
use crate::transport::inspect::{Follow, TracedPath, trace};

/// Segments after which the inspector stops following a path.
const INSPECTOR_DEPTH: u32 = 200;

/// The path that the inspector shows.
#[derive(Debug, Clone)]
pub struct Inspection {
    /// In [0, 1]² of the film, y down.
    pub point: [f64; 2],
    pub follow: Follow,
    pub path: Option<TracedPath>,
    /// What `path` was traced for.
    key: Option<Key>,
}

/// The scene's epoch, rays of its pre-trace (more of them may have changed an answer), and how the path begins and goes on.
type Key = (u64, u64, CameraDescription, Mode, [u32; 2], Follow);

impl State {
    /// The path under the inspected pixel in the active pane's mode, traced again when anything it depends on has changed.
    pub fn refresh_inspection(&mut self) {
        let mode = self.settings.panes[self.view.active_pane].inspected_mode();
        let film_camera = self.film_camera();
        let (Some(inspection), Some(report)) = (&mut self.inspection, &self.report) else { return };
        let rays = report.prepared.table.rays();
        let key = Some((report.epoch, rays, film_camera, mode, self.size.film, inspection.follow));
        if std::mem::replace(&mut inspection.key, key) == key {
            return;
        }
        inspection.path = Camera::new(&film_camera).ok().map(|camera| {
            let ray = ray_through(&camera, self.size.film, inspection.point);
            let depth = self.settings.max_depth.unwrap_or(INSPECTOR_DEPTH).min(INSPECTOR_DEPTH);
            trace(&report.prepared, mode, ray, inspection.follow, 0, Some(depth))
        });
    }

    pub(super) fn inspect(&mut self, point: Option<[f64; 2]>) {
        let follow = self.inspection.as_ref().map_or(Follow::Transmit, |inspection| inspection.follow);
        self.inspection =
            point.map(|p| Inspection { point: p.map(|x| x.clamp(0.0, 1.0)), follow, path: None, key: None });
    }
}
