//! The window: panes with images of the scene in several modes, the scene's tree with its media, and everything around them.
//!
//! Panels only read the [`state::State`] and return [`command::Command`]s; `State::apply` and [`files`] are the only places that
//! act on them. Rendering is done by [`crate::session`], developing by [`develop`]: nothing here waits.

mod autosave;
mod background;
mod build;
mod capture;
mod command;
mod develop;
mod document;
mod edit;
mod enlarge;
mod entry;
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

use std::path::{Path, PathBuf};
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

use self::autosave::{Autosaver, Edits, Found, Slot};
use self::background::{Bell, Repaint};
use self::capture::{Capture, Subject};
use self::develop::{Developer, Recipe, Source};
use self::files::{ExportJob, Files, Outcome, Purpose};
use self::frame_clock::FrameClock;
use self::graphics::{Refusals, WindowSize};
use self::measurement::measurer::{self, Measurer, Plan};
use self::opening::{Opening, Reading};
use self::panels::dialogs::{Dialogs, PathPrompt};
use self::paths::Tracer;
use self::screenshot::Camera as WindowCamera;
use self::slicer::{Cutting, Of, Slicer};
use self::snapshots::Kept;
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

    pub fn apply(&mut self, ctx: &egui::Context, command: Command) {
        match command {
            Command::New if self.state.document.is_dirty() => self.dialogs.leaving = Some(Command::NewAnyway),
            Command::New | Command::NewAnyway => {
                self.state.cancel_opening();
                self.state.open(build::empty_scene());
                self.viewport.forget();
            }
            Command::AskMesh => self.ask(Purpose::Mesh),
            Command::ReadMesh(path) => self.read_mesh(path),
            Command::AskOpen => self.ask(Purpose::Open),
            Command::AskSaveAs => self.ask(Purpose::SaveAs),
            Command::AskExport(kind) => self.ask(Purpose::Export(kind)),
            Command::AskEnvironmentImage => self.ask(Purpose::Environment),
            Command::ReadEnvironment(path) => self.files.read_environment(path),
            Command::Open(name_or_path) if self.state.document.is_dirty() => {
                self.dialogs.leaving = Some(Command::OpenAnyway(name_or_path));
            }
            Command::Open(name_or_path) => self.open(name_or_path, false),
            Command::OpenAnyway(name_or_path) => self.open(name_or_path, true),
            Command::CancelOpening => {
                self.state.cancel_opening();
                self.open_default_instead_of_nothing();
            }
            Command::CancelPreparation => {
                if let Some(preparation) = &self.state.preparation {
                    preparation.give_up();
                }
                if self.state.last_good.is_none() && !self.state.document.is_dirty() {
                    self.open(crate::formats::builtin::DEFAULT.into(), true);
                }
            }
            Command::RestoreEdits(path) if self.state.document.is_dirty() => {
                self.dialogs.leaving = Some(Command::RestoreEditsAnyway(path));
            }
            Command::RestoreEdits(path) | Command::RestoreEditsAnyway(path) => {
                let found = self.state.left_behind.iter().find(|found| found.slot.path() == path);
                if let Some(found) = found.cloned() {
                    let id = self.state.begin_opening(found.name().into(), true);
                    self.files.restore(id, found);
                }
            }
            Command::DiscardEdits(path) => {
                for found in self.state.left_behind.extract_if(.., |found| found.slot.path() == path) {
                    self.files.discard(found);
                }
            }
            Command::Save if self.state.outside_change.is_some() && self.state.document.path.is_some() => {
                self.dialogs.is_outdated = true;
            }
            Command::LoadChanged => self.reload(),
            Command::Save | Command::SaveAnyway => match self.state.document.path.clone() {
                Some(path) => self.files.save(Arc::clone(self.state.document.description()), path),
                None => self.ask(Purpose::SaveAs),
            },
            Command::SaveAs(path) => self.files.look(Purpose::SaveAs, path),
            Command::SaveAsAnyway(path) => {
                // A new scene is called like its first file.
                if let Some(stem) = path.file_stem()
                    && self.state.document.description().name == build::UNTITLED
                {
                    self.apply(ctx, Command::Edit(Edit::Name(stem.to_string_lossy().into_owned())));
                }
                self.files.save(Arc::clone(self.state.document.description()), path);
            }
            Command::Export(kind, path) => self.files.look(Purpose::Export(kind), path),
            Command::ExportAnyway(kind @ (ExportKind::ShownPane | ExportKind::ShownPanes), path) => {
                self.begin_capture(kind == ExportKind::ShownPanes, Some(path));
            }
            Command::ExportAnyway(kind, path) => self.export(kind, path),
            Command::KeepSnapshot(id) => self.keep_snapshot(id),
            Command::SendToTev => self.tev_serial += 1,
            Command::AskTevAddress => self.dialogs.tev = Some(self.state.settings.tev_address.clone()),
            Command::CopyPane => self.begin_capture(false, None),
            Command::CopyPanes => self.begin_capture(true, None),
            Command::CopyValues => self.copy_values(ctx),
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

    /// Reads the scene's file again, which another program has changed.
    fn reload(&self) {
        if let Some(path) = self.state.document.path.clone() {
            self.files.reload(path);
        }
    }

    /// Keeps an eye on the files of the scene that is shown.
    fn watch_files(&mut self) {
        let document = &self.state.document;
        let (known, order) = &mut self.watched;
        if known.as_ref().is_none_or(|known| !Arc::ptr_eq(known, document.description())) {
            order.files = watch::files_of(document.description(), document.path.as_deref());
            *known = Some(Arc::clone(document.description()));
        }
        self.watcher.set_order(order);
    }

    /// The scene's files are as the program knows them now.
    fn trust_files(&mut self) {
        let (known, order) = &mut self.watched;
        *known = None;
        order.round += 1;
    }

    fn open(&mut self, name_or_path: PathBuf, may_lose_edits: bool) {
        let id = self.state.begin_opening(name_or_path.clone(), may_lose_edits);
        self.files.open(id, name_or_path);
    }

    /// Reads a mesh that is to become part of the scene. In the scene it goes by a path beside the scene's own file where it lies there.
    fn read_mesh(&mut self, path: PathBuf) {
        let source = self.state.document.description().source.as_ref().filter(|source| !source.is_builtin);
        let folder = source.and_then(|source| std::path::absolute(source.path.parent()?).ok());
        let Ok(path) = std::path::absolute(&path) else { return };
        let written = folder.and_then(|folder| path.strip_prefix(folder).ok()).unwrap_or(&path).to_owned();
        if written.to_str().is_none() {
            let name = path.display();
            self.state.notify_error(format!("{name}: a scene file cannot name this path, for it is not UTF-8."));
            return;
        }
        self.files.read_mesh(path, written);
    }

    /// Where the first scene cannot be shown, or is not wanted any more.
    fn open_default_instead_of_nothing(&mut self) {
        if !self.state.has_scene {
            self.open(crate::formats::builtin::DEFAULT.into(), true);
        }
    }

    /// Shows a scene that has been read, from an autosave if it comes from one.
    fn opened(&mut self, opening: &Opening, description: scene::Description, found: Option<Found>) {
        if self.state.document.is_dirty() && !opening.may_lose_edits {
            // Edited while it was read.
            self.dialogs.leaving = Some(Command::OpenAnyway(opening.name.clone()));
            return;
        }
        match found {
            None => self.state.open(description),
            Some(found) => {
                self.state.restore(description, found.scene_path().map(Path::to_owned));
                self.state.left_behind.retain(|other| other.slot != found.slot);
                self.restoring = Some((found, Arc::clone(self.state.document.description())));
            }
        }
        self.trust_files();
        self.viewport.forget();
    }

    /// Tells the thread that keeps edits what to keep.
    fn keep_edits(&mut self) {
        let Some(autosaver) = &self.autosaver else { return };
        let document = &self.state.document;
        let is_settled =
            |scene: &Arc<scene::Description>| self.state.is_prepared() || !Arc::ptr_eq(scene, document.description());
        if let Some((found, _)) = self.restoring.take_if(|(_, scene)| is_settled(scene)) {
            self.restored = Some(found.slot);
        }
        let is_kept = document.is_dirty() && !self.is_closing && self.restoring.is_none();
        let edits = || Edits { description: Arc::clone(document.description()), path: document.path.clone() };
        autosaver.set_order(&autosave::Order { edits: is_kept.then(edits), slot: self.restored.clone() });
    }

    fn ask(&self, purpose: Purpose) {
        let document = &self.state.document;
        let folder = document.path.as_deref().and_then(Path::parent).map(Path::to_owned).unwrap_or_default();
        let source = document.description().source.as_ref();
        let stem = source.and_then(|source| source.path.file_stem()).map_or("scene".into(), |s| s.to_string_lossy());
        let name = match purpose {
            Purpose::Open | Purpose::Environment | Purpose::Mesh => String::new(),
            Purpose::SaveAs => format!("{stem}.toml"),
            Purpose::Export(ExportKind::AllPanesPng) => format!("{stem}-comparison.png"),
            Purpose::Export(ExportKind::ShownPanes) => format!("{stem}-panes.png"),
            Purpose::Export(ExportKind::ErrorsCsv) => format!("{stem}-errors.csv"),
            Purpose::Export(ExportKind::PathSvg | ExportKind::PathJson) => {
                format!("{stem}-path.{}", purpose.extension())
            }
            Purpose::Export(_) => {
                let content = match self.state.settings.panes[self.state.view.active_pane] {
                    PaneContent::Surfaces(quantity) => quantity.name().replace(' ', "-"),
                    content if purpose == Purpose::Export(ExportKind::ShownPane) => {
                        content.to_string().replace(" − ", "-minus-").replace([' ', ','], "-").replace("--", "-")
                    }
                    PaneContent::Slice(mode) => format!("slice-{mode}"),
                    content => content.inspected_mode().to_string(),
                };
                format!("{stem}-{content}.{}", purpose.extension())
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
        if matches!(kind, ExportKind::PathSvg | ExportKind::PathJson) {
            return match paths::export::text_of(&self.state, kind) {
                Ok(text) => self.files.export_text(text, path),
                Err(message) => self.state.notify_error(message),
            };
        }
        let Some(report) = &self.state.report else {
            self.state.notify_error("There is no image to export yet.");
            return;
        };
        let panes = match kind {
            ExportKind::AllPanesPng => self.state.settings.shown_panes(),
            _ => std::slice::from_ref(&self.state.settings.panes[self.state.view.active_pane]),
        };
        self.files.export(ExportJob {
            kind,
            path,
            prepared: report.prepared.clone(),
            display: self.state.settings.display,
            seed: 0,
            panes: panes.iter().map(|content| self.viewport.source(*content)).collect(),
        });
    }

    /// Tells the thread that talks to tev what the panes show, and says what came of it.
    fn send_to_tev(&mut self) {
        let report = self.tev.take_finished();
        if let Some(failure) = report.failure {
            self.state.is_live_in_tev = false;
            self.state.notify_error(failure);
        }
        match report.sent {
            Some(0) => {
                self.state.notify_error("There is nothing to send to tev: surfaces are colours and no radiance.")
            }
            Some(count) => {
                let s = if count == 1 { "" } else { "s" };
                self.state.notify(format!("Sent {count} image{s} to tev"));
            }
            None => {}
        }
        let is_live = self.state.is_live_in_tev;
        if !is_live && !self.was_live_in_tev && self.tev_serial == self.tev_sent {
            return;
        }
        (self.was_live_in_tev, self.tev_sent) = (is_live, self.tev_serial);
        let scene = &self.state.document.description().name;
        let mut images: Vec<(String, Source)> = Vec::new();
        for content in self.state.settings.shown_panes() {
            let name = format!("{content} – {scene}");
            if images.iter().all(|(known, _)| *known != name) {
                images.push((name, self.viewport.source(*content)));
            }
        }
        let address = self.state.settings.tev_address.clone();
        self.tev.set_order(&tev::Order { address, is_live, serial: self.tev_serial, images });
    }

    /// Keeps the film of the active pane; of a difference, the first.
    fn keep_snapshot(&mut self, id: SnapshotId) {
        let content = self.state.settings.panes[self.state.view.active_pane];
        let Some(mode) = content.modes().next() else {
            let text = "Only the picture of a mode can be kept as a snapshot: choose a mode in the active pane.";
            return self.state.notify_error(text);
        };
        let is_current = self.viewport.samples(content, &self.state) > 0;
        let source = self.viewport.source(content);
        let Some(film) = source.films.into_iter().find(|film| is_current && film.mode == mode) else {
            return self.state.notify_error("There is no full picture to keep yet: wait for its first sample.");
        };
        let kept = Kept::new(film, Arc::clone(self.state.document.description()), self.state.view.camera);
        self.state.snapshots.set(id, Some(Arc::new(kept)));
        self.state
            .notify(format!("Kept {} as snapshot {id}. Panes can show it, or what changes from now on.", mode.name()));
    }

    /// Takes a picture of panes as they are shown, for a file or, without a path, for the clipboard.
    fn begin_capture(&mut self, is_all: bool, path: Option<PathBuf>) {
        let Some(report) = &self.state.report else {
            self.state.notify_error("There is no image to export yet.");
            return;
        };
        let settings = &self.state.settings;
        let shown = settings.shown_panes();
        let panes = if is_all { shown } else { std::slice::from_ref(&shown[self.state.view.active_pane]) };
        let modes: Vec<Mode> =
            Mode::ALL.into_iter().filter(|m| panes.iter().any(|p| p.modes().any(|n| n == *m))).collect();
        let has_samples = |content: &&PaneContent| !matches!(content, PaneContent::Slice(_));
        let counts = panes.iter().filter(has_samples).map(|content| self.viewport.source(*content).samples());
        let mut text = crate::export::metadata(&report.prepared, &modes, counts.min().unwrap_or(0), 0);
        let titles: Vec<String> = panes.iter().map(ToString::to_string).collect();
        text.push(("Panes".to_owned(), titles.join("; ")));
        for id in
            SnapshotId::ALL.into_iter().filter(|id| panes.iter().any(|content| content.snapshots().any(|s| s == *id)))
        {
            if let Some(kept) = self.state.snapshots.get(id) {
                let title = kept.title(self.state.document.description(), &self.state.view.camera);
                text.push((format!("Snapshot {id}"), title));
            }
        }
        text.push((
            "Exposure".to_owned(),
            format!("{} stops, {} curve", settings.display.exposure, settings.display.curve),
        ));
        self.capture = Some(Capture::new(Subject { is_all, path, text }));
        self.viewport.is_still = true;
    }

    /// Goes on with the picture that is being taken, at the end of a frame.
    fn go_on_with_capture(&mut self, ctx: &egui::Context) {
        // A capture that began in this frame needs one that is drawn for it.
        let Some(capture) = self.capture.as_mut().filter(|_| self.is_still_frame) else { return };
        capture::clear_floating_layers(ctx);
        let index = (!capture.subject.is_all).then_some(self.state.view.active_pane);
        let Some(outcome) = capture.update(ctx, self.viewport.place(index)) else { return };
        let subject = self.capture.take().map(|capture| capture.subject);
        self.viewport.is_still = false;
        match (outcome, subject) {
            (Ok(image), Some(Subject { path: Some(path), text, .. })) => self.files.export_image(image, text, path),
            (Ok(image), Some(Subject { is_all, .. })) => {
                ctx.copy_image(capture::color_image(&image));
                let what = if is_all { "all panes" } else { "the active pane" };
                self.state.notify(format!("Copied {what}: {} × {} pixels", image.width(), image.height()));
            }
            (Err(message), _) => self.state.notify_error(message),
            (Ok(_), None) => {}
        }
    }

    /// The numbers of the pixel under the pointer, or of the inspected one, in every pane.
    fn copy_values(&mut self, ctx: &egui::Context) {
        let point = self.viewport.pointer.or(self.state.inspection.as_ref().map(|inspection| inspection.point));
        let panes = self.state.settings.shown_panes().iter().copied();
        let texts: Vec<String> = (panes.enumerate())
            .filter_map(|(index, content)| {
                let lines = self.viewport.values_at(index, &self.state, point?);
                (!lines.is_empty()).then(|| format!("{content}\n{}", lines.join("\n")))
            })
            .collect();
        if texts.is_empty() {
            self.state.notify_error("No pixel to copy: point at a picture, or click one to inspect it.");
        } else {
            ctx.copy_text(texts.join("\n"));
            self.state.notify("Copied the values of the pixel.");
        }
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
            let is_back = self.state.scene_failed(epoch, &error);
            // The restored scene could not be shown: it is offered again.
            self.state.left_behind.extend(self.restoring.take_if(|_| is_back).map(|(found, _)| found));
        }
        if let Some(report) = board.scene()
            && self.state.report.as_ref().is_none_or(|known| !Arc::ptr_eq(known, &report))
        {
            self.state.scene_ready(report);
        }
        self.state.preparation = board.preparation();
        self.state.films = board.snapshots();
        self.state.measurement.set_truth(board.ground_truth());
        if let Some(results) = self.measurer.take_finished() {
            self.state.measurement.results = results;
        }
        if let Some(verdicts) = self.judge.take_finished() {
            self.state.verdicts = verdicts;
        }
        if let Some(report) = self.autosaver.as_ref().map(Autosaver::take_finished) {
            self.state.left_behind.extend(report.found);
            report.failure.into_iter().for_each(|failure| self.state.notify_error(failure));
        }
        if self.watcher.take_finished().has_changed {
            if self.state.document.is_dirty() {
                self.state.outside_change = Some(state::OutsideChange::Offered);
            } else {
                self.reload();
            }
        }
        if let Some(refusal) = self.refusals.take() {
            self.state.notify_error(format!("The graphics card cannot show this: {refusal}"));
        }
        let (floor, picture_floor) = (self.state.epoch_floor, self.state.picture_floor());
        self.viewport.upload(ctx, self.developer.take_finished(), floor, picture_floor);
        self.viewport.upload(ctx, self.slicer.take_finished(), floor, picture_floor);
        while let Some(outcome) = self.files.poll() {
            match outcome {
                Outcome::Chosen(purpose, path) | Outcome::IsFree(purpose, path) => {
                    self.apply(ctx, purpose.command_anyway(path));
                }
                Outcome::ChosenUnasked(purpose, path) => self.apply(ctx, purpose.command(path)),
                Outcome::IsThere(purpose, path) => self.dialogs.overwriting = Some((purpose, path)),
                Outcome::NoDialog(purpose, suggestion) => {
                    self.dialogs.prompt = Some(PathPrompt::new(purpose, &suggestion));
                }
                Outcome::Opened(id, description, found) => {
                    if let Some(opening) = self.state.end_opening(id) {
                        self.opened(&opening, *description, found);
                    }
                }
                Outcome::NotOpened(id, message) => {
                    if self.state.end_opening(id).is_some() {
                        self.state.notify_error(message);
                        self.open_default_instead_of_nothing();
                    }
                }
                Outcome::EnvironmentRead(path, image) => {
                    let command = Command::Edit(self.state.environment_of(path, image));
                    self.apply(ctx, command);
                }
                Outcome::Mesh(name, shape) => {
                    let state = &self.state;
                    let (scene, view) = (state.document.description(), &state.view.camera);
                    let edit = build::mesh_edit(scene, view, state.selected.as_deref(), &name, *shape);
                    self.apply(ctx, Command::Edit(edit));
                }
                Outcome::Reloaded(path, read) => {
                    if self.state.document.path.as_ref() == Some(&path) {
                        self.state.reload(read.map(|description| *description));
                    }
                }
                Outcome::Saved(path, description) => {
                    self.trust_files();
                    self.state.outside_change = None;
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
        let path = ctx.input(|input| Some(input.raw.dropped_files.first()?.path().to_owned()))?;
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        let is_of = |purpose: Purpose| purpose.endings().contains(&&*ending);
        Some(match () {
            () if is_of(Purpose::Mesh) => Command::ReadMesh(path),
            () if is_of(Purpose::Environment) => Command::ReadEnvironment(path),
            () => Command::Open(path),
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
            histogram_of: settings.show_histogram.then(|| settings.panes[self.state.view.active_pane]),
            denoise: settings.denoise,
        });
        self.slicer.set_order(cutting(&self.state, ctx.pixels_per_point()));
        self.measurer.set_order(&Plan {
            is_on: self.state.measurement.is_on(),
            is_paused: self.state.is_paused,
            epoch: self.state.epoch(),
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
            clock.tick(&ctx, begin.elapsed().as_secs_f64(), frame.info().cpu_usage, &self.state, samples);
        }
        if let Some(camera) = &mut self.window_camera {
            let samples = |content: &PaneContent| self.viewport.samples(*content, &self.state);
            let mut least = self.state.settings.shown_panes().iter().map(samples).min().unwrap_or(0);
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
