//! The application's state. Commands change it in one place, [`State::apply`]. Knows nothing of widgets.

mod apply;
mod film_size;
mod graphics;
mod inspection;
mod notices;
mod scene;
mod side_panels;
mod view;
mod world;

use std::collections::BTreeMap;
use std::sync::Arc;

use self::film_size::FilmSize;
pub use self::film_size::magnification;
pub use self::graphics::{capitalized, sentence};
pub use self::inspection::{Inspection, PathOption, PathOptions, modes_over};
pub use self::side_panels::Room;
pub use self::view::Motion;
pub use self::world::WorldPart;
use super::autosave::Found;
use super::command::MediumRef;
use super::document::Document;
use super::measurement::Measurement;
use super::opening::{Opening, no_scene};
use super::settings::Settings;
use super::slice::SliceView;
use super::snapshots::Snapshots;
use super::verdicts::Verdicts;
use crate::check::Problem;
use crate::render::{Estimator, ImageSettings};
use crate::scene::Description;
use crate::scene::description::{CameraDescription, Object};
use crate::session::{GraphicsStatus, Preparation, Request, SceneReport, Snapshot};
use crate::tracking::Mode;

/// Largest magnification of the picture.
pub const MAX_ZOOM: f32 = 64.0;

/// A message in the window.
#[derive(Debug, Clone, PartialEq)]
pub struct Notice {
    pub id: u64,
    pub is_error: bool,
    pub text: String,
}

/// The linked view of all panes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    pub camera: CameraDescription,
    /// Magnification of the picture, at least 1.
    pub zoom: f32,
    /// The point in [0, 1]² of the film that is in the middle of a pane.
    pub zoom_center: [f32; 2],
    /// Where the wipe's dividers stand, in [0, 1]².
    pub divider: [f32; 2],
    pub active_pane: usize,
}

/// Windows that are open over the main one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Windows {
    pub gallery: bool,
    pub add: bool,
    pub shortcuts: bool,
    pub about: bool,
    pub messages: bool,
}

/// What has become of a change of the scene's file by another program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutsideChange {
    /// There are edits, so the user is asked.
    Offered,
    /// The user keeps the edits.
    Declined,
}

/// Everything that the window shows, apart from images.
#[derive(Debug)]
pub struct State {
    pub document: Document,
    /// `false` while `document` is the placeholder before the first scene.
    pub has_scene: bool,
    /// The scene that is being read.
    opening: Option<Opening>,
    next_opening: u64,
    /// Edits that earlier instances did not save, latest first.
    pub left_behind: Vec<Found>,
    /// The last document that could be rendered, to return to when another cannot.
    pub last_good: Option<Document>,
    pub settings: Settings,
    pub view: View,
    pub is_paused: bool,
    pub notices: Vec<Notice>,
    /// What notices have said, also those that have gone, latest last.
    pub messages: Vec<Notice>,
    next_notice: u64,
    /// `None` as long as the scene's file is as it was read or written.
    pub outside_change: Option<OutsideChange>,
    /// The notice that the changed file cannot be read.
    broken_file: Option<u64>,
    pub windows: Windows,
    /// The step of the tour that is shown.
    pub tour: Option<usize>,
    /// The object that is highlighted in the tree, by name.
    pub selected: Option<String>,
    /// Which part of the world is shown where the world is selected.
    pub world_part: WorldPart,
    /// Whether the next click in a picture puts the focus there.
    pub is_focusing: bool,
    /// The solid that an image is being chosen for.
    pub texture_for: Option<String>,
    /// The object whose name is being typed.
    pub renaming: Option<String>,
    pub inspection: Option<Inspection>,
    pub path_options: PathOptions,
    /// Name of the light whose light is followed, instead of the marked pixel's path.
    pub path_light: Option<String>,
    /// The slice as it was chosen; `None`: as [`Self::slice_view`] proposes.
    pub(super) slice: Option<SliceView>,
    /// Where something was last selected in the picture, in [0, 1]² of the film.
    last_pick: Option<[f64; 2]>,
    /// Views before jumps of the camera, latest last.
    pub earlier_views: Vec<CameraDescription>,
    /// The scene as the worker prepared it.
    pub report: Option<Arc<SceneReport>>,
    /// The scene that the worker is preparing.
    pub preparation: Option<Arc<Preparation>>,
    /// Whether every change of the panes is sent to tev.
    pub is_live_in_tev: bool,
    /// Pictures that are kept.
    pub snapshots: Snapshots,
    /// What is known of the graphics processor; `None` until it has been looked for.
    pub graphics: Option<Arc<GraphicsStatus>>,
    /// The latest film of each mode that is rendered.
    pub films: BTreeMap<Mode, Arc<Snapshot>>,
    /// What is to be said of the modes that the panes show.
    pub verdicts: Verdicts,
    /// What is measured, and how far that is.
    pub measurement: Measurement,
    /// What is doubtful in the scene, as last found out: while an edit is being looked at, what was found before it.
    problems: Option<Arc<SceneReport>>,
    /// Whether the strip of problems is there. It comes and goes only while no button is down, so that nothing moves under the pointer.
    has_problem_strip: bool,
    /// What room the window has for side panels.
    room: Room,
    size: FilmSize,
    epoch: u64,
    /// Images of earlier epochs belong to another scene and are not shown.
    pub epoch_floor: u64,
    /// Images of this epoch and later ones show the scene as it is from where the camera is, whatever their size.
    picture_floor: u64,
    /// How often films were begun anew though nothing had changed.
    restarts: u64,
    /// How often the backend was chosen.
    backend_choices: u64,
    /// Whether the worker should be told.
    has_news: bool,
}

impl State {
    pub fn new(description: Arc<Description>, settings: Settings) -> Self {
        let camera = description.camera;
        let mut settings = settings.repaired();
        settings.take_first_panes(&description);
        Self {
            document: Document::new(description),
            has_scene: true,
            opening: None,
            next_opening: 1,
            left_behind: Vec::new(),
            last_good: None,
            tour: settings.show_tour.then_some(0),
            settings,
            view: View { camera, zoom: 1.0, zoom_center: [0.5; 2], divider: [0.5; 2], active_pane: 0 },
            is_paused: false,
            notices: Vec::new(),
            messages: Vec::new(),
            next_notice: 0,
            outside_change: None,
            broken_file: None,
            windows: Windows::default(),
            selected: None,
            world_part: WorldPart::Medium,
            is_focusing: false,
            texture_for: None,
            renaming: None,
            inspection: None,
            path_options: PathOptions::default(),
            path_light: None,
            slice: None,
            last_pick: None,
            earlier_views: Vec::new(),
            report: None,
            preparation: None,
            is_live_in_tev: false,
            snapshots: Snapshots::default(),
            graphics: None,
            films: BTreeMap::new(),
            verdicts: Verdicts::default(),
            measurement: Measurement::default(),
            problems: None,
            has_problem_strip: false,
            room: Room::default(),
            size: FilmSize::default(),
            epoch: 1,
            epoch_floor: 1,
            picture_floor: 1,
            restarts: 0,
            backend_choices: 0,
            has_news: true,
        }
    }

    /// Before the first scene has been read.
    pub fn without_scene(settings: Settings) -> Self {
        Self { has_scene: false, ..Self::new(no_scene(), settings) }
    }

    /// The present epoch: images of it show what the state says, in the size that it says.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Images of this epoch and later ones show what the state says, whatever their size.
    pub fn picture_floor(&self) -> u64 {
        self.picture_floor
    }

    /// Other images are wanted.
    fn next_epoch(&mut self) {
        self.epoch += 1;
        self.has_news = true;
    }

    /// The images are out of date.
    fn invalidate(&mut self) {
        self.next_epoch();
        self.picture_floor = self.epoch;
        self.size.begin();
    }

    /// The noise at which rendering stops. Where errors are measured it goes on to the limit of samples.
    pub fn noise_target(&self) -> Option<f64> {
        self.settings.noise_target.filter(|_| !self.measurement.is_on())
    }

    /// What renders the films that are shown, as far as is known.
    pub fn estimator(&self) -> Option<Estimator> {
        self.films.values().max_by_key(|film| film.epoch).map(|film| film.estimator)
    }

    /// A request for the worker, if anything has changed since the last one and there is room for an image.
    pub fn take_request(&mut self) -> Option<Request> {
        if !self.has_news || !self.has_scene || self.size.film.contains(&0) {
            return None;
        }
        self.has_news = false;
        Some(Request {
            epoch: self.epoch,
            restarts: self.restarts,
            description: Arc::clone(self.document.description()),
            camera: self.film_camera(),
            modes: self.settings.modes(),
            surfaces: self.settings.surfaces(),
            size: self.size.film,
            settings: ImageSettings { max_depth: self.settings.max_depth, ..ImageSettings::new(Mode::Rectified, 0) },
            estimator: self.settings.estimator,
            backend: self.settings.backend,
            backend_choices: self.backend_choices,
            sample_limit: self.settings.sample_limit,
            noise_target: self.noise_target(),
            is_paused: self.is_paused,
            ground_truth: self.measurement.demand,
        })
    }

    /// What is doubtful in the scene, worst first.
    pub fn problems(&self) -> &[Problem] {
        self.problems.as_ref().and_then(|report| report.problems.as_deref()).unwrap_or_default()
    }

    /// Whether the strip of problems is to be shown. `is_pressed`: whether a button of the pointer is down.
    pub fn problem_strip(&mut self, is_pressed: bool) -> bool {
        if !is_pressed {
            self.has_problem_strip = self.settings.show_problems && !self.problems().is_empty();
        }
        self.has_problem_strip
    }

    /// Whether the scene has been prepared as it is now.
    pub fn is_prepared(&self) -> bool {
        let description = self.document.description();
        self.report.as_ref().is_some_and(|report| Arc::ptr_eq(&report.prepared.description, description))
    }

    /// `None` if nothing or the world is selected.
    pub fn selected_object(&self) -> Option<&Object> {
        self.document.description().objects.find(self.selected.as_deref()?)
    }
}

/// Text of a comfortable size for a window of so many points at factor 1 on a screen of `monitor` points (if it is known): larger on a
/// screen with many points, never so large that the window cannot hold the panels.
pub fn automatic_factor(window: [f32; 2], monitor: Option<[f32; 2]>) -> f32 {
    let fit = |size: [f32; 2], comfortable: [f32; 2]| (size[0] / comfortable[0]).min(size[1] / comfortable[1]);
    let wanted = fit(monitor.unwrap_or(window), [1700.0, 960.0]);
    let possible = fit(window, [1500.0, 840.0]);
    let quarters = (wanted.min(possible) * 4.0).floor() / 4.0;
    quarters.clamp(1.0, 3.0)
}

/// The medium that an object of the tree is made of.
pub fn medium_of(description: &Description, object: &str) -> Option<MediumRef> {
    let refractor = description.objects.find(object)?.refractor()?;
    Some(MediumRef::Named(refractor.medium.clone()))
}

#[cfg(test)]
mod tests {
    use super::automatic_factor;

    #[test]
    fn text_grows_with_the_screen_but_the_panels_still_fit() {
        assert_eq!(automatic_factor([1280.0, 720.0], Some([1280.0, 720.0])), 1.0);
        assert_eq!(automatic_factor([1920.0, 1080.0], Some([1920.0, 1080.0])), 1.0);
        assert_eq!(automatic_factor([3840.0, 2160.0], Some([3840.0, 2160.0])), 2.25);
        assert_eq!(automatic_factor([1280.0, 720.0], Some([3840.0, 2160.0])), 1.0);
        assert_eq!(automatic_factor([1920.0, 1080.0], Some([3840.0, 2160.0])), 1.25);
        assert_eq!(automatic_factor([400.0, 300.0], None), 1.0);
    }
}
