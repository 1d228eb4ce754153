//! The window: panes with images of the scene in several modes, the scene's tree with its media, and everything around them.
//!
//! Panels only read the [`state::State`] and return [`command::Command`]s; [`dispatch`] acts on those that need files, threads or the
//! window, `State::apply` on all others. What the threads have done is taken in by [`collect`]. Rendering is done by [`crate::session`],
//! developing by [`develop`]: nothing here waits.

mod autosave;
mod background;
mod build;
mod capture;
mod collect;
mod command;
mod develop;
mod dispatch;
mod document;
mod documents;
mod edit;
mod enlarge;
mod entry;
mod exporting;
mod files;
mod first_panes;
mod frame_clock;
mod graphics;
mod histogram;
mod ior_control;
mod keys;
mod launch;
mod measurement;
mod modal;
mod navigation;
mod objects;
mod opening;
mod panels;
mod paths;
mod picker;
mod progress;
mod quotes;
mod range;
mod screenshot;
mod settings;
mod slice;
mod slicer;
mod snapshots;
mod state;
mod tev;
mod text_field;
mod theme;
mod verdicts;
mod viewport;
mod watch;
mod widgets;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

pub use build::profiles::Vessel;
pub use build::{Addition, Body};
pub use command::{Command, ExportKind, MediumRef};
pub use edit::{Edit, EditKey, MediaEdit, MediumEdit, ObjectEdit};
pub use launch::{Launch, RunError, Screenshot, run};
pub use measurement::{Curve, ErrorAxis, ErrorMetric, Measurement, Measurements, Point, Trend};
pub use objects::Manipulation;
pub use range::{DifferenceRange, RangeCurve, RangeEnd, Scale};
pub use settings::{Arrangement, DifferenceKind, InterfaceScale, PaneContent, Preset, Settings, SidePanel, Tab, Theme};
pub use slice::{Facing, SliceView};
pub use snapshots::SnapshotId;
pub use state::{State, WorldPart};

use self::autosave::{Autosaver, Found, Slot};
use self::background::{Bell, Repaint};
use self::capture::Capture;
use self::develop::{Developer, Recipe};
use self::files::Files;
use self::frame_clock::FrameClock;
use self::graphics::{Refusals, WindowSize};
use self::measurement::measurer::{self, Measurer, Plan};
use self::opening::Reading;
use self::panels::dialogs::Dialogs;
use self::paths::Tracer;
use self::screenshot::Camera as WindowCamera;
use self::slicer::{Cutting, Of, Slicer};
use self::verdicts::Judge;
use self::viewport::Viewport;
use crate::scene;
use crate::session::{News, Snapshot, Worker};
use crate::tracking::Mode;

/// Key of the settings in the storage.
const SETTINGS_KEY: &str = "settings";

/// Passes after which a new scale has reached every size that is measured in points.
const SETTLING_PASSES: u32 = 8;

pub struct App {
    state: State,
    dialogs: Dialogs,
    viewport: Viewport,
    files: Files,
    // Dropped in this order: these two look at what the worker publishes.
    developer: Developer,
    measurer: Measurer,
    tracer: Tracer,
    slicer: Slicer,
    worker: Worker,
    tev: tev::Link,
    /// Counts what was sent to tev once.
    tev_serial: u64,
    /// Of these, what the thread knows.
    tev_sent: u64,
    was_live_in_tev: bool,
    judge: Judge,
    watcher: watch::Watcher,
    /// The scene whose files are watched, and what of them.
    watched: (Option<Arc<scene::Description>>, watch::Order),
    /// `None` where edits are not kept: in scripts and tests.
    autosaver: Option<Autosaver>,
    /// The place of the edits that were restored.
    restored: Option<Arc<Slot>>,
    /// Edits that are shown but not prepared yet, and their scene: until then they stay where they are.
    restoring: Option<(Found, Arc<scene::Description>)>,
    window_size: WindowSize,
    refusals: Refusals,
    start: Instant,
    /// Set by a screenshot or by settings from outside: nothing is remembered.
    is_scripted: bool,
    /// A pixel to inspect as soon as there are films, and whether in the ghost view.
    to_inspect: Option<([f64; 2], bool)>,
    window_camera: Option<WindowCamera>,
    /// The picture of panes that is being taken.
    capture: Option<Capture>,
    /// Whether the present frame is drawn for it.
    is_still_frame: bool,
    frame_clock: Option<FrameClock>,
    /// Whether the user has agreed to lose unsaved changes.
    may_close: bool,
    /// Whether the window is being closed, and nothing is to be kept that no file has.
    is_closing: bool,
    title: String,
    /// Passes since the scale of the interface last changed.
    passes_at_scale: u32,
    /// The control that had the focus at the end of the last frame.
    focused: Option<egui::Id>,
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
        let settings = settings.or_else(|| remembered(cc)).unwrap_or_else(Settings::of_first_start);
        Self::with_state(cc, State::new(Arc::new(description), settings))
    }

    /// [`Self::new`] for a scene that is still being read; until then there is none.
    fn reading(
        cc: &eframe::CreationContext<'_>,
        name_or_path: PathBuf,
        reading: Reading,
        settings: Option<Settings>,
    ) -> std::io::Result<Self> {
        let settings = settings.or_else(|| remembered(cc)).unwrap_or_else(Settings::of_first_start);
        let mut app = Self::with_state(cc, State::without_scene(settings))?;
        let id = app.state.begin_opening(name_or_path, true);
        app.files.finish(id, reading);
        Ok(app)
    }

    fn with_state(cc: &eframe::CreationContext<'_>, state: State) -> std::io::Result<Self> {
        theme::install(&cc.egui_ctx);
        let repaint = repaint_of(&cc.egui_ctx);
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
        let developer = develop::start(bell, Arc::clone(worker.board()), Arc::clone(&repaint))?;
        let judge = verdicts::start(Arc::clone(&repaint))?;
        let measurer = measurer::start(measurer_bell, Arc::clone(worker.board()), Arc::clone(&repaint))?;
        let tracer = paths::tracer::start(Arc::clone(&repaint))?;
        let slicer = Slicer::start(Arc::clone(&repaint))?;
        Ok(Self {
            state,
            dialogs: Dialogs::default(),
            viewport: Viewport::default(),
            tev: tev::start(Arc::clone(&repaint))?,
            tev_serial: 0,
            tev_sent: 0,
            was_live_in_tev: false,
            watcher: watch::start(Arc::clone(&repaint))?,
            watched: (None, watch::Order::default()),
            files: Files::new(repaint),
            developer,
            measurer,
            tracer,
            slicer,
            worker,
            judge,
            autosaver: None,
            restored: None,
            restoring: None,
            window_size: WindowSize::default(),
            refusals: Refusals::default(),
            start: Instant::now(),
            is_scripted: false,
            to_inspect: None,
            window_camera: None,
            capture: None,
            is_still_frame: false,
            frame_clock: None,
            may_close: false,
            is_closing: false,
            title: String::new(),
            passes_at_scale: SETTLING_PASSES,
            focused: None,
        })
    }

    /// Keeps edits that no file has in `folder`, and offers those that earlier instances left there.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn keep_edits_in(&mut self, ctx: &egui::Context, folder: PathBuf) -> std::io::Result<()> {
        self.autosaver = Some(autosave::start(folder, repaint_of(ctx))?);
        Ok(())
    }

    /// Paths are asked for in the window from now on, and not by dialogs of the system; they are proposed in `folder`.
    pub fn prompt_in(&mut self, folder: PathBuf) {
        self.files.prompt_in(folder);
    }

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
        self.viewport.difference(self.state.settings.panes[index], self.state.picture_floor())
    }

    /// Where the whole picture of the first pane is on the screen, in points; parts of it may lie outside of the pane.
    pub fn picture(&self) -> Option<egui::Rect> {
        self.viewport.picture
    }

    /// The scale of the colours of the difference in pane `index`; `None` for anything else, and for FLIP.
    pub fn scale_shown(&self, index: usize) -> Option<Scale> {
        self.viewport.scale(self.state.settings.panes[index])
    }

    /// Where pane `index` is in the window, in points; without an index, where all panes are.
    pub fn pane_place(&self, index: Option<usize>) -> egui::Rect {
        self.viewport.place(index)
    }

    /// The latest film of a mode.
    pub fn film(&self, mode: Mode) -> Option<Arc<Snapshot>> {
        self.worker.board().snapshots().remove(&mode)
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
        ctx.set_theme(match self.state.settings.theme {
            Theme::System => egui::ThemePreference::System,
            Theme::Dark => egui::ThemePreference::Dark,
            Theme::Light => egui::ThemePreference::Light,
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
        let factor = match self.state.settings.interface_scale {
            InterfaceScale::Factor(factor) => factor,
            InterfaceScale::Automatic => state::automatic_factor(window.into(), monitor),
        };
        if (factor - ctx.zoom_factor()).abs() > 1e-3 {
            ctx.set_zoom_factor(factor);
            self.passes_at_scale = 0;
        }
    }

    /// Asks before unsaved changes are lost.
    fn guard_closing(&mut self, ctx: &egui::Context) {
        if !ctx.input(|input| input.viewport().close_requested()) {
            return;
        }
        self.is_closing = !self.state.document.is_dirty() || self.may_close || self.is_scripted;
        if !self.is_closing {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.dialogs.leaving = Some(Command::QuitAnyway);
        }
    }
}

/// The slices that the panes need.
fn cutting(state: &State, pixels_per_point: f32) -> Cutting {
    let modes = state.settings.slices();
    let (Some(report), Some(placed), false) = (&state.report, state.placed_slice(), modes.is_empty()) else {
        return Cutting::default();
    };
    let line_width = f64::from(pixels_per_point * state.settings.resolution_scale).max(1.0);
    let (epoch, prepared) = (report.epoch, report.prepared.clone());
    Cutting { of: Some(Of { epoch, prepared, plane: placed.plane, size: state.film_size(), line_width }), modes }
}

fn repaint_of(ctx: &egui::Context) -> Repaint {
    let ctx = ctx.clone();
    Arc::new(move || ctx.request_repaint())
}

/// The settings of the last session.
fn remembered(cc: &eframe::CreationContext<'_>) -> Option<Settings> {
    cc.storage.and_then(|storage| eframe::get_value(storage, SETTINGS_KEY))
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        let begin = Instant::now();
        let ctx = ui.ctx().clone();
        self.set_appearance(&ctx);
        self.collect(&ctx);
        if let Some(traced) = self.tracer.take_finished() {
            self.state.paths_traced(traced);
        }
        self.set_window_title(&ctx);
        self.guard_closing(&ctx);
        self.window_size.update(&ctx);

        self.is_still_frame = self.capture.is_some();
        let above = keys::Above { has_dialog: self.dialogs.is_open(), focused: self.focused };
        let mut commands = keys::pressed(&ctx, &self.state, above);
        modal::remember_focus(&ctx);
        commands.extend(self.dropped(&ctx));
        panels::show(ui, &mut self.state, &mut self.dialogs, &mut self.viewport, &mut commands);
        self.go_on_with_capture(&ctx);
        for command in commands {
            self.apply(&ctx, command);
        }
        self.focused = ctx.memory(egui::Memory::focused);

        if !self.state.film_size().contains(&0)
            && let Some((point, is_ghost)) = self.to_inspect.take()
        {
            self.apply(&ctx, Command::Inspect(Some(point)));
            if is_ghost {
                self.apply(&ctx, Command::SetPathOption(state::PathOption::Ghost(true)));
                self.apply(&ctx, self.state.navigate(state::Motion::Orbit([-0.28, 0.05]), 1.0));
            }
        }
        self.tracer.set_order(&self.state.path_question());
        let settings = &self.state.settings;
        self.developer.set_order(&Recipe {
            contents: settings.shown_panes().iter().copied().collect(),
            display: settings.display,
            difference: settings.difference,
            range: settings.difference_range,
            snapshots: self.state.snapshots.clone(),
            given: self.state.measurement.given.clone(),
            histogram_of: settings.show_histogram.then(|| settings.panes[self.state.view.active_pane]),
            denoise: settings.denoise,
        });
        self.slicer.set_order(cutting(&self.state, ctx.pixels_per_point()));
        self.measurer.set_order(&Plan {
            is_on: self.state.measurement.is_on(),
            is_paused: self.state.is_paused,
            epoch: self.state.epoch(),
            given: self.state.measurement.given.clone(),
            metric: settings.error_metric,
            display: settings.display,
            rectification_seconds: self.state.report.as_ref().map_or(0.0, |r| r.prepared.table.seconds.total()),
        });
        self.send_to_tev();
        self.judge.set_order(&verdicts::Order {
            report: self.state.report.clone().filter(|_| self.state.is_prepared()),
            camera: Some(self.state.film_camera()),
            size: self.state.film_size(),
            modes: self.state.settings.modes(),
        });
        self.keep_edits();
        self.watch_files();
        if let Some(request) = self.state.take_request() {
            self.worker.submit(request);
        }
        if let Some(clock) = &mut self.frame_clock {
            let samples = |content: &PaneContent| self.viewport.samples(*content, &self.state);
            let samples = self.state.settings.shown_panes().iter().map(samples).min().unwrap_or(0);
            clock.tick(&ctx, begin.elapsed().as_secs_f64(), frame, &self.state, samples);
        }
        if let Some(camera) = &mut self.window_camera {
            let samples = |content: &PaneContent| self.viewport.samples(*content, &self.state);
            let mut least = self.state.settings.shown_panes().iter().map(samples).min().unwrap_or(0);
            if self.state.measurement.is_rendered() {
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
