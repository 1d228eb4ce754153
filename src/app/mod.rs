//! The window: panes with images of the scene in several modes, the scene's tree with its media, and everything around them.
//!
//! Panels only read the [`state::State`] and return [`command::Command`]s; `State::apply` and [`files`] are the only places that
//! act on them. Rendering is done by [`crate::render::worker`], developing by [`develop`]: nothing here waits.

mod background;
mod command;
mod develop;
mod document;
mod files;
mod keys;
mod measurement;
mod navigation;
mod objects;
mod panels;
mod screenshot;
mod settings;
mod state;
mod theme;
mod viewport;
mod widgets;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

pub use command::{Command, ExportKind, MediumRef};
pub use measurement::{Curve, ErrorAxis, ErrorMetric, Measurement, Measurements, Point, Trend};
pub use objects::Manipulation;
pub use settings::{Arrangement, DifferenceKind, InterfaceScale, PaneContent, Preset, Settings, Tab, Theme};
pub use state::State;

use self::background::Bell;
use self::develop::{Developer, Recipe};
use self::files::{ExportJob, Files, Outcome, Purpose};
use self::measurement::Measurer;
use self::measurement::measurer::Plan;
use self::panels::dialogs::{Dialogs, Leaving, PathPrompt};
use self::screenshot::Camera as WindowCamera;
use self::viewport::Viewport;
use crate::render::worker::{GroundTruthDemand, News, Snapshot, Worker};
use crate::scene;
use crate::tracking::Mode;

/// Key of the settings in the storage.
const SETTINGS_KEY: &str = "settings";

/// Passes after which a new scale has reached every size that is measured in points.
const SETTLING_PASSES: u32 = 8;

/// The window could not be shown.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// There is no display, or no way to draw on it.
    #[error("no window can be opened here ({0})")]
    NoWindow(String),
    /// The scene that was asked for cannot be shown.
    #[error(transparent)]
    Scene(#[from] scene::SceneError),
    /// The picture of the window could not be written.
    #[error("the picture of the window could not be written: {0}")]
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
    /// Settings instead of the remembered ones, which are then neither read nor written.
    pub settings: Option<Settings>,
    /// Whether to begin with a ground truth and measure.
    pub measures: bool,
}

/// A picture of the window.
#[derive(Debug, Clone)]
pub struct Screenshot {
    /// A PNG.
    pub path: PathBuf,
    /// Samples per pixel to wait for.
    pub samples: u32,
}

/// Opens the window on `scene` (a path or a built-in name; by default a built-in scene) and returns when it is closed.
///
/// # Errors
/// When there is no display or no way to draw on it, or when `scene` cannot be read.
pub fn run(scene: Option<PathBuf>) -> Result<(), RunError> {
    run_with(Launch { scene, ..Launch::default() })
}

/// [`run`], with a say in how the window starts.
///
/// # Errors
/// As [`run`], and when a screenshot was asked for and cannot be written.
pub fn run_with(launch: Launch) -> Result<(), RunError> {
    let description = scene::load::open(launch.scene.as_deref().unwrap_or(Path::new(scene::builtin::DEFAULT)))?;
    let is_scripted = launch.settings.is_some() || launch.screenshot.is_some();
    let size = launch.size.map_or([1600.0, 960.0], |size| size.map(|side| side as f32));
    let mut viewport = egui::ViewportBuilder::default()
        .with_title("iorect")
        .with_app_id("iorect")
        .with_inner_size(size)
        .with_min_inner_size([480.0, 320.0])
        .with_icon(panels::about::icon());
    if launch.size.is_some() {
        viewport = viewport.with_position([0.0, 0.0]);
    }
    let options = eframe::NativeOptions {
        viewport,
        persist_window: !is_scripted && launch.size.is_none(),
        // Pixels must reach the screen as they were developed.
        dithering: false,
        ..Default::default()
    };
    let screenshot_result = Arc::new(std::sync::Mutex::new(None));
    let result = Arc::clone(&screenshot_result);
    eframe::run_native(
        "iorect",
        options,
        Box::new(move |cc| {
            let mut app = App::new(cc, description, launch.settings.clone())?;
            app.is_scripted = is_scripted;
            if launch.measures {
                app.state.apply(Command::SetGroundTruth(GroundTruthDemand::On), 0.0);
            }
            app.window_camera = launch.screenshot.map(|shot| WindowCamera::new(shot, result));
            Ok(Box::new(app))
        }),
    )
    .map_err(|error| RunError::NoWindow(error.to_string()))?;
    let outcome = screenshot_result.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take();
    match outcome {
        Some(Err(message)) => Err(RunError::Screenshot(message)),
        Some(Ok(())) | None => Ok(()),
    }
}

/// The window's contents.
pub struct App {
    state: State,
    dialogs: Dialogs,
    viewport: Viewport,
    files: Files,
    // Dropped in this order: these two look at what the worker publishes.
    developer: Developer,
    measurer: Measurer,
    worker: Worker,
    start: Instant,
    /// Set by a screenshot or by settings from outside: nothing is remembered.
    is_scripted: bool,
    window_camera: Option<WindowCamera>,
    /// Whether the user has agreed to lose unsaved changes.
    may_close: bool,
    title: String,
    /// Passes since the scale of the interface last changed.
    passes_at_scale: u32,
}

impl App {
    /// Starts the threads and shows `description`. Without `settings`, those of the last session are used.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn new(
        cc: &eframe::CreationContext<'_>,
        description: scene::Description,
        settings: Option<Settings>,
    ) -> std::io::Result<Self> {
        theme::install(&cc.egui_ctx);
        let remembered = || cc.storage.and_then(|storage| eframe::get_value(storage, SETTINGS_KEY));
        let settings = settings.or_else(remembered).unwrap_or_default();
        let repaint = {
            let ctx = cc.egui_ctx.clone();
            Arc::new(move || ctx.request_repaint())
        };
        let (bell, measurer_bell) = (Bell::default(), Bell::default());
        let worker = {
            let (bell, measurer_bell, repaint) = (bell.clone(), measurer_bell.clone(), Arc::clone(&repaint));
            Worker::start(Arc::new(move |news| match news {
                News::Images => {
                    bell.ring();
                    measurer_bell.ring();
                }
                News::Scene => repaint(),
            }))?
        };
        let developer = {
            let repaint = Arc::clone(&repaint);
            develop::start(bell, Arc::clone(worker.board()), move || repaint())?
        };
        let measurer = {
            let repaint = Arc::clone(&repaint);
            measurement::measurer::start(measurer_bell, Arc::clone(worker.board()), move || repaint())?
        };
        Ok(Self {
            state: State::new(Arc::new(description), settings),
            dialogs: Dialogs::default(),
            viewport: Viewport::default(),
            files: Files::new(repaint),
            developer,
            measurer,
            worker,
            start: Instant::now(),
            is_scripted: false,
            window_camera: None,
            may_close: false,
            title: String::new(),
            passes_at_scale: SETTLING_PASSES,
        })
    }

    /// What is shown.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Samples per pixel of the image that pane `index` shows, at full resolution; 0 before.
    pub fn samples_shown(&self, index: usize) -> u32 {
        self.viewport.samples(self.state.settings.panes[index], &self.state)
    }

    /// What pane `index` says of the pixel under the pointer, line by line.
    pub fn values_under_pointer(&self, index: usize) -> Vec<String> {
        self.viewport.values(index, &self.state)
    }

    /// How the difference in pane `index` is coloured, and its mean; `None` where there is none, or where another kind is wanted by now.
    pub fn difference_shown(&self, index: usize) -> Option<(DifferenceKind, f64)> {
        self.viewport.difference(self.state.settings.panes[index], self.state.epoch())
    }

    /// The latest film of a mode.
    pub fn film(&self, mode: Mode) -> Option<Arc<Snapshot>> {
        self.worker.board().snapshots().remove(&mode)
    }

    /// Does what a command says.
    pub fn apply(&mut self, ctx: &egui::Context, command: Command) {
        match command {
            Command::AskOpen => self.ask(Purpose::Open),
            Command::AskSaveAs => self.ask(Purpose::SaveAs),
            Command::AskExport(kind) => self.ask(Purpose::Export(kind)),
            Command::Open(name_or_path) if self.state.document.is_dirty() => {
                self.dialogs.leaving = Some(Leaving::Open(name_or_path));
            }
            Command::Open(name_or_path) | Command::OpenAnyway(name_or_path) => self.files.open(name_or_path),
            Command::Save => match self.state.document.path.clone() {
                Some(path) => self.files.save(Arc::clone(self.state.document.description()), path),
                None => self.ask(Purpose::SaveAs),
            },
            Command::SaveAs(path) => self.files.save(Arc::clone(self.state.document.description()), path),
            Command::Export(kind, path) => self.export(kind, path),
            Command::StepInterfaceScale(step) => self.step_interface_scale(ctx, step),
            Command::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            Command::QuitAnyway => {
                self.may_close = true;
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Command::Escape if self.dialogs.close() => {}
            other => self.state.apply(other, self.start.elapsed().as_secs_f64()),
        }
    }

    fn ask(&self, purpose: Purpose) {
        let document = &self.state.document;
        let folder = document.path.as_deref().and_then(Path::parent).map(Path::to_owned).unwrap_or_default();
        let stem = match &document.description().source {
            Some(source) => source.path.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
            None => None,
        };
        let stem = stem.unwrap_or_else(|| "scene".to_owned());
        let name = match purpose {
            Purpose::Open => String::new(),
            Purpose::SaveAs => format!("{stem}.toml"),
            Purpose::Export(ExportKind::AllPanesPng) => format!("{stem}-comparison.png"),
            Purpose::Export(ExportKind::ErrorsCsv) => format!("{stem}-errors.csv"),
            Purpose::Export(_) => {
                let content = match self.state.settings.panes[self.state.view.active_pane] {
                    PaneContent::Surfaces(quantity) => quantity.name().replace(' ', "-"),
                    content => content.inspected_mode().to_string(),
                };
                format!("{stem}-{content}.{}", files::extension_of(purpose))
            }
        };
        self.files.ask(purpose, &folder.join(name));
    }

    fn export(&mut self, kind: ExportKind, path: PathBuf) {
        if kind == ExportKind::ErrorsCsv {
            let results = &self.state.measurement.results;
            if results.curves.values().all(|curve| curve.points.is_empty()) {
                self.state
                    .notify_error("Nothing has been measured yet: make a reference image in the tab Measure first.");
                return;
            }
            let table = measurement::csv::table(&self.state.document.description().name, results);
            return self.files.export_text(table, path);
        }
        let Some(report) = &self.state.report else {
            self.state.notify_error("There is no image to export yet.");
            return;
        };
        let panes = match kind {
            ExportKind::AllPanesPng => self.state.settings.shown_panes(),
            _ => std::slice::from_ref(&self.state.settings.panes[self.state.view.active_pane]),
        };
        let job = ExportJob {
            kind,
            path,
            prepared: report.prepared.clone(),
            display: self.state.settings.display,
            seed: 0,
            panes: panes.iter().map(|content| (*content, self.viewport.source(*content))).collect(),
        };
        self.files.export(job);
    }

    fn step_interface_scale(&mut self, ctx: &egui::Context, step: i32) {
        let now = ctx.zoom_factor();
        let factors = InterfaceScale::FACTORS;
        let next = if step > 0 {
            factors.into_iter().find(|factor| *factor > now + 0.01)
        } else {
            factors.into_iter().rev().find(|factor| *factor < now - 0.01)
        };
        if let Some(factor) = next {
            self.state.apply(Command::SetInterfaceScale(InterfaceScale::Factor(factor)), 0.0);
        }
    }

    /// Takes in what the threads have done.
    fn collect(&mut self, ctx: &egui::Context) {
        let board = Arc::clone(self.worker.board());
        if let Some((epoch, error)) = board.take_failure() {
            self.state.scene_failed(epoch, &error);
        }
        if let Some(report) = board.scene()
            && self.state.report.as_ref().is_none_or(|known| !Arc::ptr_eq(known, &report))
        {
            self.state.scene_ready(report);
        }
        self.state.measurement.set_truth(board.ground_truth());
        if let Some(results) = self.measurer.take_finished() {
            self.state.measurement.results = results;
        }
        self.viewport.upload(ctx, self.developer.take_finished(), self.state.epoch_floor());
        while let Some(outcome) = self.files.poll() {
            match outcome {
                Outcome::Chosen(purpose, path) => {
                    let command = command_for(purpose, path);
                    self.apply(ctx, command);
                }
                Outcome::NoDialog(purpose, suggestion) => {
                    self.dialogs.prompt = Some(PathPrompt::new(purpose, &suggestion));
                }
                Outcome::Opened(description) => {
                    self.state.open(*description);
                    self.viewport.forget();
                }
                Outcome::Saved(path, description) => {
                    self.state.document.mark_saved(path.clone(), &description);
                    self.state.settings.remember(&path);
                    self.state.notify(format!("Saved {}", path.display()));
                }
                Outcome::Exported(path) => self.state.notify(format!("Exported {}", path.display())),
                Outcome::Failed(message) => self.state.notify_error(message),
            }
        }
    }

    /// Files that were dropped on the window.
    fn dropped(&self, ctx: &egui::Context) -> Option<Command> {
        ctx.input(|input| {
            let file = input.raw.dropped_files.first()?;
            Some(Command::Open(file.path().to_owned()))
        })
    }

    fn set_window_title(&mut self, ctx: &egui::Context) {
        let mark = if self.state.document.is_dirty() { "*" } else { "" };
        let title = format!("{}{mark} — iorect", self.state.document.description().name);
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    fn set_appearance(&mut self, ctx: &egui::Context) {
        ctx.set_theme(match self.state.wants_dark() {
            None => egui::ThemePreference::System,
            Some(true) => egui::ThemePreference::Dark,
            Some(false) => egui::ThemePreference::Light,
        });
        // For some passes after a change of scale, sizes in points are still those of the old one: to believe them would change the
        // scale again and again.
        if self.passes_at_scale < SETTLING_PASSES {
            self.passes_at_scale += 1;
            return;
        }
        let native = ctx.native_pixels_per_point().unwrap_or(1.0);
        let to_native = ctx.pixels_per_point() / native;
        let window = ctx.content_rect().size() * to_native;
        let monitor = ctx.input(|input| input.viewport().monitor_size).map(|size| (size * to_native).into());
        let factor = self.state.interface_factor(window.into(), monitor);
        if (factor - ctx.zoom_factor()).abs() > 1e-3 {
            ctx.set_zoom_factor(factor);
            self.passes_at_scale = 0;
        }
    }

    /// Asks before unsaved changes are lost.
    fn guard_closing(&mut self, ctx: &egui::Context) {
        if ctx.input(|input| input.viewport().close_requested())
            && self.state.document.is_dirty()
            && !self.may_close
            && !self.is_scripted
        {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.dialogs.leaving = Some(Leaving::Quit);
        }
    }
}

/// What is to be done with a chosen path.
fn command_for(purpose: Purpose, path: PathBuf) -> Command {
    match purpose {
        Purpose::Open => Command::Open(path),
        Purpose::SaveAs => Command::SaveAs(path),
        Purpose::Export(kind) => Command::Export(kind, path),
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.set_appearance(&ctx);
        self.collect(&ctx);
        self.state.refresh_inspection();
        self.set_window_title(&ctx);
        self.guard_closing(&ctx);

        let mut commands = keys::pressed(&ctx, &self.state);
        commands.extend(self.dropped(&ctx));
        panels::show(ui, &mut self.state, &mut self.dialogs, &mut self.viewport, &mut commands);
        for command in commands {
            self.apply(&ctx, command);
        }

        let settings = &self.state.settings;
        self.developer.set_order(&Recipe {
            contents: settings.shown_panes().iter().copied().collect(),
            display: settings.display,
            difference: settings.difference,
        });
        self.measurer.set_order(&Plan {
            is_on: self.state.measurement.is_on(),
            epoch: self.state.epoch(),
            metric: settings.error_metric,
            display: settings.display,
            rectification_seconds: self.state.report.as_ref().map_or(0.0, |r| r.prepared.table.seconds.total()),
        });
        if let Some(request) = self.state.take_request() {
            self.worker.submit(request);
        }
        if let Some(camera) = &mut self.window_camera {
            let least = (0..self.state.settings.pane_count)
                .map(|pane| self.viewport.samples(self.state.settings.panes[pane], &self.state));
            let mut least = least.min().unwrap_or(0);
            if self.state.measurement.is_on() {
                least = least.min(self.state.measurement.truth.as_ref().map_or(0, |truth| truth.samples));
            }
            camera.update(&ctx, least);
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        if !self.is_scripted {
            eframe::set_value(storage, SETTINGS_KEY, &self.state.settings);
        }
    }

    fn persist_egui_memory(&self) -> bool {
        // Sizes and folds of panels; what is remembered of the application itself is in the settings.
        !self.is_scripted
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }
}

/// What the pictures on the screen were made of, by content.
type Shown<T> = BTreeMap<PaneContent, T>;
