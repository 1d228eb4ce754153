//! The path under a pixel.

use std::sync::Arc;

use super::State;
use crate::app::paths::tracer::MOST_SEGMENTS;
use crate::app::paths::{Question, Traced, Viewpoint};
use crate::app::settings::PaneContent;
use crate::tracking::Mode;
use crate::transport::inspect::{Follow, TracedPath};

/// How paths are followed and shown; kept from pixel to pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathOptions {
    pub follow: Follow,
    /// Of the random numbers where chance is followed.
    pub seed: u64,
    /// Whether rays around the pixel's middle are followed too.
    pub has_bundle: bool,
    /// The mode whose path is shown beside each pane's own.
    pub against: Option<Mode>,
    /// Whether the path stays that of the camera from which it was inspected.
    pub keeps_ray: bool,
    /// Whether everything but the path is shown faintly.
    pub is_ghost: bool,
}

impl Default for PathOptions {
    fn default() -> Self {
        let (follow, against) = (Follow::Transmit, Some(Mode::Rectified));
        Self { follow, seed: 0, has_bundle: false, against, keeps_ray: false, is_ghost: false }
    }
}

/// A change of [`PathOptions`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathOption {
    Against(Option<Mode>),
    Bundle(bool),
    KeepRay(bool),
    /// Turned on, it keeps the ray too: one orbits to see it.
    Ghost(bool),
    /// Other random numbers.
    NextSample,
    /// These random numbers.
    Seed(u64),
}

/// The pixel that is inspected.
#[derive(Debug, Clone)]
pub struct Inspection {
    /// In [0, 1]² of the film, y down.
    pub point: [f64; 2],
    /// The pixel and camera that the path stays that of; `None`: the panes' camera.
    pub kept: Option<Viewpoint>,
    /// The vertex that is pointed out.
    pub vertex: Option<usize>,
    /// What was found last; an edit may have changed it since.
    pub traced: Option<Arc<Traced>>,
}

impl Inspection {
    /// A mode's path, if it has been followed.
    pub fn path(&self, mode: Mode) -> Option<&TracedPath> {
        self.traced.as_ref()?.path(mode)
    }
}

/// The modes whose paths are drawn over a pane that shows `content`.
pub fn modes_over(content: PaneContent) -> Vec<Mode> {
    let modes: Vec<Mode> = content.modes().collect();
    if modes.is_empty() { vec![content.inspected_mode()] } else { modes }
}

impl State {
    /// The mode whose path the Inspector lists: the active pane's.
    pub fn inspected_mode(&self) -> Mode {
        self.settings.panes[self.view.active_pane].inspected_mode()
    }

    /// The modes that are compared in the active pane: its own and the one to compare with, or those of a difference.
    pub fn compared_modes(&self) -> Option<[Mode; 2]> {
        let content = self.settings.panes[self.view.active_pane];
        let own = content.inspected_mode();
        match (self.path_options.against, content) {
            (Some(against), _) if against != own => Some([own, against]),
            (_, PaneContent::Difference(a, b)) => Some([a, b]),
            _ => None,
        }
    }

    /// Names of the lights whose light can be followed.
    pub fn path_lights(&self) -> Vec<String> {
        let Some(report) = &self.report else { return Vec::new() };
        let scene = &report.prepared.scene;
        scene.emitters.iter().filter_map(|(light, _)| light.object()).map(|id| scene.object(id).name.clone()).collect()
    }

    /// Where the panes' camera sees a pixel.
    fn viewpoint(&self, point: [f64; 2]) -> Viewpoint {
        Viewpoint { camera: self.film_camera(), film_size: self.size.film, point }
    }

    /// Whether the path is still the one under the marked pixel.
    pub fn has_path_at_pixel(&self) -> bool {
        let camera = self.film_camera();
        self.inspection.as_ref().is_some_and(|it| it.kept.is_none_or(|kept| kept.camera == camera))
    }

    /// What is to be followed now.
    pub fn path_question(&self) -> Option<Question> {
        let (inspection, report) = (self.inspection.as_ref()?, self.report.as_ref()?);
        if report.epoch < self.epoch_floor || self.size.film.contains(&0) {
            return None;
        }
        let options = self.path_options;
        let pair = self.compared_modes();
        let scene = &report.prepared.scene;
        let light = self.path_light.as_ref().and_then(|name| {
            let lights = scene.emitters.iter().filter_map(|(light, _)| light.object());
            lights.into_iter().find(|id| scene.object(*id).name == *name)
        });
        let mut modes: Vec<Mode> =
            self.settings.shown_panes().iter().flat_map(|&content| modes_over(content)).collect();
        modes.extend(pair.into_iter().flatten().chain(options.against));
        modes.sort_unstable();
        modes.dedup();
        Some(Question {
            report: Arc::clone(report),
            viewpoint: inspection.kept.unwrap_or_else(|| self.viewpoint(inspection.point)),
            light,
            follow: options.follow,
            seed: options.seed,
            has_bundle: options.has_bundle,
            modes,
            pair,
            max_depth: self.settings.max_depth.unwrap_or(MOST_SEGMENTS).min(MOST_SEGMENTS),
            eye: self.view.camera.position,
            has_outlines: options.is_ghost,
        })
    }

    /// Takes what was found, unless it is of another pixel or scene.
    pub fn paths_traced(&mut self, traced: Arc<Traced>) {
        let floor = self.epoch_floor;
        if let Some(inspection) = &mut self.inspection
            && traced.question.viewpoint.point == inspection.point
            && traced.question.report.epoch >= floor
        {
            inspection.traced = Some(traced);
        }
    }

    pub(super) fn inspect(&mut self, point: Option<[f64; 2]>) {
        self.path_light = None;
        self.inspection = point.map(|point| {
            let point = point.map(|x| x.clamp(0.0, 1.0));
            let kept = self.path_options.keeps_ray.then(|| self.viewpoint(point));
            Inspection { point, kept, vertex: None, traced: None }
        });
    }

    pub(super) fn set_path_option(&mut self, option: PathOption) {
        let before = self.path_options;
        let options = &mut self.path_options;
        match option {
            PathOption::Against(mode) => options.against = mode,
            PathOption::Bundle(is_on) => options.has_bundle = is_on,
            PathOption::KeepRay(is_on) => options.keeps_ray = is_on,
            PathOption::Ghost(is_on) => {
                options.is_ghost = is_on;
                options.keeps_ray |= is_on;
            }
            PathOption::NextSample => options.seed = options.seed.wrapping_add(1),
            PathOption::Seed(seed) => options.seed = seed,
        }
        let keeps_ray = options.keeps_ray;
        if keeps_ray != before.keeps_ray
            && let Some(point) = self.inspection.as_ref().map(|inspection| inspection.point)
        {
            let kept = keeps_ray.then(|| self.viewpoint(point));
            if let Some(inspection) = &mut self.inspection {
                inspection.kept = kept;
            }
        }
    }

    pub(super) fn select_vertex(&mut self, vertex: Option<usize>) {
        if let Some(inspection) = &mut self.inspection {
            inspection.vertex = vertex;
        }
    }
}
