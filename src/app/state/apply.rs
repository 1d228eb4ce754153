//! Commands, one by one.

use super::{MAX_ZOOM, OutsideChange, Room, State, Windows};
use crate::app::command::Command;
use crate::app::edit::Edit;
use crate::app::measurement::Given;
use crate::app::settings::{MAX_PANES, PaneContent, Settings, SidePanel};
use crate::optics::medium;
use crate::session::GroundTruthDemand;

impl State {
    /// Applies a command; commands that need files or the window itself are not for here. `now_secs` is a steady clock.
    pub fn apply(&mut self, command: Command, now_secs: f64) {
        match command {
            Command::Edit(edit) => self.edit(&edit, now_secs),
            Command::Add(addition) => {
                let scene = self.document.description();
                match addition.edit(scene, &self.view.camera, self.selected.as_deref()) {
                    Ok(edit) => self.edit(&edit, now_secs),
                    Err(why) => self.notify_error(why),
                }
                self.windows.add = false;
            }
            Command::Rename(name) => {
                self.settings.show_scene_panel |= name.is_some();
                self.selected = name.clone().or_else(|| self.selected.take());
                self.renaming = name;
            }
            Command::BeginDrag => self.document.begin_gesture(),
            Command::Drag(edit) if self.document.has_gesture() => self.edit(&edit, now_secs),
            Command::EndDrag => self.document.end_gesture(),
            Command::Undo => {
                let camera = self.document.description().camera;
                if self.document.cancel_gesture() || self.document.undo() {
                    self.follow_camera(camera);
                    self.after_history();
                }
            }
            Command::Redo => {
                let camera = self.document.description().camera;
                if self.document.redo() {
                    self.follow_camera(camera);
                    self.after_history();
                }
            }
            Command::SetCamera(camera) => self.set_camera(camera),
            Command::ResetCamera => self.jump_to(self.document.description().camera),
            Command::FrameObject(object) => self.frame_object(&object),
            Command::ShowProblem { objects, spot } => self.show_problem(&objects, spot),
            Command::EarlierView => {
                if let Some(camera) = self.earlier_views.pop() {
                    self.set_camera(camera);
                }
            }
            Command::SetPaneCount(count) => self.change_panes(|settings| settings.pane_count = count),
            Command::SetPaneContent(pane, content) if pane < MAX_PANES => {
                self.change_panes(|settings| settings.panes[pane] = content);
                if matches!(content, PaneContent::Error(_)) && !self.measurement.is_on() {
                    self.demand_ground_truth(GroundTruthDemand::On);
                }
            }
            Command::SetPreset(preset) => self.change_panes(|settings| {
                settings.pane_count = MAX_PANES;
                settings.panes = preset.panes();
            }),
            Command::SetActivePane(pane) => self.view.active_pane = pane.min(self.settings.pane_count - 1),
            Command::SetArrangement(arrangement) => self.settings.arrangement = arrangement,
            Command::SetDivider(divider) => self.view.divider = divider.map(|x| x.clamp(0.02, 0.98)),
            Command::SetZoom(zoom, center) => {
                self.view.zoom = zoom.clamp(1.0, MAX_ZOOM);
                let margin = 0.5 / self.view.zoom;
                self.view.zoom_center = center.map(|x| x.clamp(margin, 1.0 - margin));
            }
            Command::Inspect(Some(point)) if self.is_focusing => self.focus_at(point, now_secs),
            Command::Inspect(point) => self.inspect(point),
            Command::LookAt(point) => self.look_at(point),
            Command::SelectAt(point) => self.select_at(point),
            Command::SetHandles(handles) => self.settings.handles = handles,
            Command::SetFollow(follow) => self.path_options.follow = follow,
            Command::SetPathOption(option) => self.set_path_option(option),
            Command::SetPathLight(light) => self.path_light = light,
            Command::SelectVertex(vertex) => self.select_vertex(vertex),
            Command::SetSlice(view) => self.slice = view.sound().or(self.slice),
            Command::SetExposure(exposure) if exposure.is_finite() => self.settings.display.exposure = exposure,
            Command::SetCurve(curve) => self.settings.display.curve = curve,
            Command::SetDifference(kind) => self.settings.difference = kind,
            Command::SetDifferenceRange(range) => self.settings.difference_range = range.repaired(),
            Command::ToggleTevLive => self.is_live_in_tev ^= true,
            Command::SetTevAddress(address) => self.settings.tev_address = address.trim().to_owned(),
            Command::DropSnapshot(id) => {
                self.snapshots.set(id, None);
                self.change_panes(|settings| {
                    for content in &mut settings.panes {
                        if content.snapshots().any(|shown| shown == id) {
                            *content = content.without_snapshots();
                        }
                    }
                });
            }
            Command::ToggleHistogram => self.settings.show_histogram ^= true,
            Command::ToggleValues => self.settings.show_values ^= true,
            Command::SetGroundTruth(demand) => self.demand_ground_truth(demand),
            Command::SetReferenceImage(given) => self.set_reference_image(given),
            Command::SetErrorMetric(metric) => self.settings.error_metric = metric,
            Command::SetErrorAxis(axis) => self.settings.error_axis = axis,
            Command::SetResolutionScale(scale) => {
                self.settings.resolution_scale = scale.clamp(0.1, 4.0);
                // Films of the new size begin at once, even where the old ones would do.
                self.size.fit();
            }
            Command::SetMaxDepth(depth) => {
                self.settings.max_depth = depth.map(|depth| depth.max(1));
                self.invalidate();
            }
            Command::SetSampleLimit(limit) => {
                self.settings.sample_limit = limit.map(|limit| limit.max(1));
                self.has_news = true;
            }
            Command::SetNoiseTarget(target) => {
                self.settings.noise_target = target.filter(|target| target.is_finite() && *target > 0.0);
                self.has_news = true;
            }
            Command::SetDenoise(is_on) => self.settings.denoise = is_on,
            Command::SetEstimator(estimator) => {
                self.settings.estimator = estimator;
                self.invalidate();
            }
            Command::SetBackend(backend) => {
                self.settings.backend = backend;
                self.backend_choices += 1;
                self.invalidate();
            }
            Command::TogglePause => {
                self.is_paused = !self.is_paused;
                self.has_news = true;
            }
            Command::Restart => {
                self.is_paused = false;
                self.restarts += 1;
                self.invalidate();
            }
            Command::KeepMine => {
                if self.outside_change.is_some() {
                    self.outside_change = Some(OutsideChange::Declined);
                }
            }
            Command::ClearRecent => self.settings.recent.clear(),
            Command::PostponeEdits => self.left_behind.clear(),
            Command::ToggleScenePanel => self.toggle_panel(SidePanel::Scene),
            Command::ToggleRenderPanel => self.toggle_panel(SidePanel::Render),
            Command::ToggleBothPanels => self.toggle_panels(),
            Command::ToggleProblems => self.settings.show_problems ^= true,
            Command::ShowTab(tab) => self.show_tab(tab),
            Command::SetTheme(theme) => self.settings.theme = theme,
            Command::SetInterfaceScale(scale) => self.settings.interface_scale = scale,
            Command::SelectObject(object) => self.selected = object,
            Command::SelectWorld(part) => {
                self.selected = Some(crate::optics::medium::WORLD.to_owned());
                self.world_part = part;
            }
            Command::PickFocus(is_focusing) => self.is_focusing = is_focusing,
            Command::ShowGallery(show) => self.windows = Windows { gallery: show, ..Windows::default() },
            Command::ShowAdd(show) => self.windows = Windows { add: show, ..Windows::default() },
            Command::ShowShortcuts(show) => self.windows = Windows { shortcuts: show, ..Windows::default() },
            Command::ShowAbout(show) => self.windows = Windows { about: show, ..Windows::default() },
            Command::ShowMessages(show) => self.windows = Windows { messages: show, ..Windows::default() },
            Command::ShowTour(step) => {
                self.tour = step;
                self.settings.show_tour = step.is_some();
            }
            Command::ToggleFirstPanes => self.settings.has_first_panes ^= true,
            Command::DismissNotice(id) => self.notices.retain(|notice| notice.id != id),
            Command::Escape => self.escape(),
            Command::SetPaneContent(..)
            | Command::SetExposure(_)
            | Command::Drag(_)
            | Command::Nothing
            | Command::StepInterfaceScale(_)
            | Command::New
            | Command::NewAnyway
            | Command::AskMesh
            | Command::ReadMesh(_)
            | Command::AskOpen
            | Command::AskEnvironmentImage
            | Command::AskTexture
            | Command::ReadTexture(_)
            | Command::ReadEnvironment(_)
            | Command::AskReferenceImage
            | Command::ReadReferenceImage(_)
            | Command::CancelOpening
            | Command::CancelPreparation
            | Command::RestoreEdits(_)
            | Command::RestoreEditsAnyway(_)
            | Command::DiscardEdits(_)
            | Command::Open(_)
            | Command::OpenAnyway(_)
            | Command::Save
            | Command::SaveAnyway
            | Command::LoadChanged
            | Command::AskSaveAs
            | Command::SaveAs(_)
            | Command::SaveAsAnyway(_)
            | Command::AskExport(_)
            | Command::Export(..)
            | Command::ExportAnyway(..)
            | Command::KeepSnapshot(_)
            | Command::SendToTev
            | Command::AskTevAddress
            | Command::CopyPane
            | Command::CopyPanes
            | Command::CopyValues
            | Command::Quit
            | Command::QuitAnyway => {}
        }
    }

    fn edit(&mut self, edit: &Edit, now_secs: f64) {
        match edit.apply(self.document.description()) {
            Ok(None) => {}
            Ok(Some(edited)) => {
                let camera = self.document.description().camera;
                self.document.edit(edit.key(), now_secs, edited);
                self.follow_camera(camera);
                self.selected = edit.selection(self.selected.as_deref());
                self.invalidate();
            }
            Err(why) => self.notify_error(why),
        }
    }

    /// The scene is an earlier or a later one.
    pub(super) fn after_history(&mut self) {
        self.invalidate();
        // What was selected may not be there.
        let objects = &self.document.description().objects;
        self.selected.take_if(|name| name != medium::WORLD && objects.find(name).is_none());
    }

    /// Changes what the panes show; films of modes that stay go on.
    fn change_panes(&mut self, change: impl FnOnce(&mut Settings)) {
        let (before, surfaces) = (self.settings.modes(), self.settings.surfaces());
        change(&mut self.settings);
        self.view.active_pane = self.view.active_pane.min(self.settings.pane_count - 1);
        self.has_news |= self.settings.modes() != before || self.settings.surfaces() != surfaces;
    }

    fn demand_ground_truth(&mut self, demand: GroundTruthDemand) {
        self.set_reference_image(Given::default());
        self.measurement.demand = demand;
        self.has_news = true;
    }

    /// An image from a file shows one scene, and another one is coming.
    pub(super) fn forget_reference_image(&mut self) {
        if self.measurement.given.0.is_some() {
            self.set_reference_image(Given::default());
        }
    }

    /// Films have the size of a reference image from a file: that of the panes is for them otherwise.
    fn set_reference_image(&mut self, given: Given) {
        let size = given.0.as_ref().map(|image| image.size());
        self.measurement.given = given;
        self.measurement.demand = GroundTruthDemand::Off;
        self.has_news = true;
        self.fix_film_size(size);
    }

    fn escape(&mut self) {
        if self.renaming.take().is_some() {
            // The name stays as it was.
        } else if self.document.cancel_gesture() {
            self.invalidate();
        } else if self.windows != Windows::default() {
            self.windows = Windows::default();
        } else if self.is_focusing {
            self.is_focusing = false;
        } else if self.room() == Room::Over && self.settings.has_narrow_panel {
            self.settings.has_narrow_panel = false;
        } else if self.notices.pop().is_some() {
            // The latest one.
        } else if self.inspection.is_some() {
            self.inspection = None;
        } else if self.view.zoom > 1.0 {
            self.view.zoom = 1.0;
        }
    }
}
