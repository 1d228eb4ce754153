//! Pictures and tables that leave the window: as files, to the clipboard, to tev, and as snapshots.

use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;

use super::App;
use super::ExportKind;
use super::PaneContent;
use super::SnapshotId;
use super::capture;
use super::capture::Capture;
use super::capture::Subject;
use super::develop::Source;
use super::files::ExportJob;
use super::files::Purpose;
use super::measurement;
use super::paths;
use super::snapshots::Kept;
use super::tev;
use crate::tracking::Mode;

impl App {
    pub(super) fn ask(&self, purpose: Purpose) {
        let document = &self.state.document;
        let folder = document.watched_path().and_then(Path::parent).map(Path::to_owned).unwrap_or_default();
        let source = document.description().source.as_ref();
        let stem = source.and_then(|source| source.path.file_stem()).map_or("scene".into(), |s| s.to_string_lossy());
        let name = match purpose {
            Purpose::Open | Purpose::Environment | Purpose::Texture | Purpose::Mesh | Purpose::Reference => {
                String::new()
            }
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

    pub(super) fn export(&mut self, kind: ExportKind, path: PathBuf) {
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
    pub(super) fn send_to_tev(&mut self) {
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
    pub(super) fn keep_snapshot(&mut self, id: SnapshotId) {
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
    pub(super) fn begin_capture(&mut self, is_all: bool, path: Option<PathBuf>) {
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
        text.extend(self.state.estimator().filter(|_| !modes.is_empty()).map(crate::export::estimator));
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
    pub(super) fn go_on_with_capture(&mut self, ctx: &egui::Context) {
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
    pub(super) fn copy_values(&mut self, ctx: &egui::Context) {
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
}
