//! How the window is opened: the scene that was asked for, the settings of the last session, and the graphics card.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::frame_clock::FrameClock;
use super::graphics::{self, WindowSize};
use super::opening::{Reading, Waited};
use super::screenshot::Camera as WindowCamera;
use super::{App, Command, Settings, autosave, panels};
use crate::scene::SceneError;
use crate::session::{GroundTruthDemand, priority};

/// A scene that is not read within this time is read while the window is open.
const PATIENCE: Duration = Duration::from_millis(500);

/// The window could not be shown.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error("no window can be opened here ({0})")]
    NoWindow(String),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("what was to be written of the window could not be: {0}")]
    Screenshot(String),
}

/// How the window starts.
#[derive(Debug, Clone, Default)]
pub struct Launch {
    /// A path or the name of a built-in scene; `None`: the default one.
    pub scene: Option<PathBuf>,
    /// Size of the window in pixels.
    pub size: Option<[u32; 2]>,
    /// Takes a picture of the window and quits.
    pub screenshot: Option<Screenshot>,
    /// Measures how long frames take while panes render, writes that as JSON to the file and quits.
    pub measure_frames: Option<PathBuf>,
    /// Settings instead of the remembered ones, which are then neither read nor written.
    pub settings: Option<Settings>,
    /// Panes that are shown, whatever the scene or the settings say: 1, 2 or 4.
    pub pane_count: Option<usize>,
    /// Whether to begin with a ground truth and measure.
    pub measures: bool,
    /// A pixel to inspect, in [0, 1]² of the film.
    pub inspect: Option<[f64; 2]>,
    /// Whether its path is shown in the ghost view, from the side.
    pub is_ghost: bool,
}

/// A picture of the window.
#[derive(Debug, Clone)]
pub struct Screenshot {
    /// A PNG.
    pub path: PathBuf,
    /// Samples per pixel to wait for.
    pub samples: u32,
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// When there is no display or no way to draw on it, when the scene cannot be read, or when a screenshot cannot be written.
pub fn run(launch: Launch) -> Result<(), RunError> {
    let is_scripted = launch.settings.is_some() || launch.screenshot.is_some() || launch.measure_frames.is_some();
    // What everything else works on, such as preparing scenes. Where there is such a pool already, it is used as it is.
    let polite = rayon::ThreadPoolBuilder::new().start_handler(|_| priority::yield_to_the_window());
    if let Err(error) = polite.build_global() {
        log::debug!("threads are as they were: {error}");
    }
    let name = launch.scene.unwrap_or_else(|| crate::formats::builtin::DEFAULT.into());
    let scene = read(&name, is_scripted)?;
    let size = launch.size.map_or([1600.0, 960.0], graphics::first_size);
    let mut viewport = egui::ViewportBuilder::default()
        .with_title("iorect")
        .with_app_id("iorect")
        .with_inner_size(size)
        .with_min_inner_size([480.0, 320.0])
        .with_icon(panels::about::icon());
    if launch.size.is_some() {
        viewport = viewport.with_position([0.0, 0.0]);
    }
    let mut options = eframe::NativeOptions {
        viewport,
        persist_window: !is_scripted && launch.size.is_none(),
        // Pixels must reach the screen as they were developed.
        dithering: false,
        ..Default::default()
    };
    graphics::configure(&mut options.wgpu_options);
    let screenshot_result = Arc::new(Mutex::new(None));
    let result = Arc::clone(&screenshot_result);
    // Taken by the window, if there is one.
    let scene = Arc::new(Mutex::new(Some(scene)));
    let scene_of_window = Arc::clone(&scene);
    let outcome = eframe::run_native(
        "iorect",
        options,
        Box::new(move |cc| {
            let settings = launch.settings.clone();
            let mut app = match take(&scene_of_window) {
                Some(Waited::Done(description)) => App::new(cc, *description?, settings)?,
                Some(Waited::NotYet(reading)) => App::reading(cc, name, reading, settings)?,
                None => return Err("the scene was taken already".into()),
            };
            app.is_scripted = is_scripted;
            app.window_size = WindowSize::new(launch.size);
            if let Some(render_state) = &cc.wgpu_render_state {
                app.refusals.listen(&render_state.device);
            }
            if let Some(folder) = autosave::folder().filter(|_| !is_scripted) {
                app.keep_edits_in(&cc.egui_ctx, folder)?;
            }
            if let Some(count) = launch.pane_count.filter(|count| [1, 2, 4].contains(count)) {
                app.state.apply(Command::SetPaneCount(count), 0.0);
            }
            if launch.measures {
                app.state.apply(Command::SetGroundTruth(GroundTruthDemand::On), 0.0);
            }
            app.frame_clock = launch.measure_frames.map(|path| FrameClock::new(path, Arc::clone(&result)));
            app.to_inspect = launch.inspect.map(|point| (point, launch.is_ghost));
            app.window_camera = launch.screenshot.map(|shot| WindowCamera::new(shot, result));
            Ok(Box::new(app))
        }),
    );
    if let Err(error) = outcome {
        if let Some(Waited::NotYet(reading)) = take(&scene) {
            // Whoever goes on without a window reads the scene again, and needs the memory.
            reading.wait()?;
        }
        return Err(RunError::NoWindow(error.to_string()));
    }
    match take(&screenshot_result) {
        Some(Err(message)) => Err(RunError::Screenshot(message)),
        Some(Ok(())) | None => Ok(()),
    }
}

/// The scene, where it is read soon enough to open the window with it; a script waits.
fn read(name_or_path: &Path, is_scripted: bool) -> Result<Waited, RunError> {
    let reading = Reading::start(name_or_path.to_owned())
        .map_err(|error| SceneError::new(format!("cannot start a thread to read the scene: {error}")))?;
    let patience = if is_scripted { Duration::MAX } else { PATIENCE };
    match reading.wait_for(patience) {
        Waited::Done(outcome) => Ok(Waited::Done(Ok(outcome?))),
        not_yet @ Waited::NotYet(_) => Ok(not_yet),
    }
}

fn take<T>(slot: &Mutex<Option<T>>) -> Option<T> {
    slot.lock().unwrap_or_else(PoisonError::into_inner).take()
}
