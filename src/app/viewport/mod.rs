//! The middle of the window: one, two or four linked pictures.

mod handles;
mod input;
mod keyboard;
mod layout;
mod legend;
mod lights;
mod overlay;
mod path;
mod range;
mod shot;
pub mod sight;
mod slice;
mod snapshots;
mod tools;
mod values;
mod verdict;

use std::collections::BTreeMap;
use std::sync::Arc;

use egui::{Color32, Rect, Sense, Ui, Vec2};

use self::layout::{Pane, film_window, panes};
pub use self::overlay::{content_menu_ui, event_meaning, event_name};
pub use self::path::modes_drawn;
use self::shot::Shot;
pub use self::values::pixel_at;
pub use self::verdict::show_first_wrong;
use super::command::Command;
use super::develop::{About, Picture, Source};
use super::graphics::film_size;
use super::histogram::Histogram;
use super::range::Scale;
use super::settings::{Arrangement, DifferenceKind, PaneContent};
use super::state::State;
use super::theme::Palette;
use crate::session::Snapshot;
use crate::tracking::Mode;

/// Pictures that are kept though no pane shows them.
const MOST_HIDDEN: usize = 8;

/// The pictures on the graphics card.
#[derive(Default)]
pub struct Viewport {
    shown: BTreeMap<PaneContent, Shot>,
    drag: Option<input::Drag>,
    slice_drag: Option<slice::SliceDrag>,
    handles: handles::Handles,
    /// Where the pointer is over a pane, in [0, 1]² of the film.
    pub pointer: Option<[f64; 2]>,
    /// Where the panes' labels are, with what hangs below them.
    labels: Vec<Rect>,
    /// Where each pane was last shown, in points.
    places: Vec<Rect>,
    /// Whether what belongs to the pointer and to editing is left out: a picture of the panes is being taken.
    pub is_still: bool,
    /// Where the whole film of the first pane is on the screen.
    pub picture: Option<Rect>,
}

impl Viewport {
    /// Uploads new pictures. Those of epochs before `floor` belong to another scene and are dropped; those of `picture_floor` and later show
    /// one picture, perhaps in several sizes.
    pub fn upload(
        &mut self,
        ctx: &egui::Context,
        pictures: BTreeMap<PaneContent, Picture>,
        floor: u64,
        picture_floor: u64,
    ) {
        for (content, picture) in pictures {
            let slice = picture.about.source.slice.iter().map(|slice| slice.epoch);
            if picture.about.source.epochs().chain(slice).any(|epoch| epoch < floor) {
                continue;
            }
            match self.shown.get_mut(&content) {
                // A slice that is dragged is coarse at times: no finer one of another plane stands for it.
                Some(shot) if picture.about.source.slice.is_none() => {
                    shot.take_in(ctx, content, picture, picture_floor);
                }
                _ => {
                    self.shown.insert(content, Shot::new(ctx, content, picture));
                }
            }
        }
    }

    /// Where the panes' labels are, with what hangs below them.
    pub fn labels(&self) -> &[Rect] {
        &self.labels
    }

    /// Where pane `index` was last shown, in points; without an index, where all were.
    pub fn place(&self, index: Option<usize>) -> Rect {
        match index {
            Some(index) => self.places.get(index).copied().unwrap_or(Rect::NOTHING),
            None => self.places.iter().fold(Rect::NOTHING, |all, place| all.union(*place)),
        }
    }

    /// Lets go of pictures that are neither shown nor up to date, of all but a few that are not shown, and of errors of another picture: the
    /// next reference image takes a while.
    fn drop_stale(&mut self, state: &State) {
        let floor = state.picture_floor();
        let is_measured = state.measurement.is_on();
        let shown_panes = state.settings.shown_panes();
        let is_past = |shot: &Shot| shot.about.source.epochs().any(|epoch| epoch < floor);
        self.shown.retain(|content, shot| {
            let is_error = matches!(content, PaneContent::Error(_));
            let is_stale = is_error && (!is_measured || is_past(shot));
            let is_impossible = state.snapshots.obstacle(*content, state.film_size()).is_some();
            !is_stale && !is_impossible && (shown_panes.contains(content) || !is_past(shot))
        });
        let hidden: Vec<PaneContent> =
            self.shown.keys().copied().filter(|content| !shown_panes.contains(content)).collect();
        let surplus = hidden.len().saturating_sub(MOST_HIDDEN);
        hidden[..surplus].iter().for_each(|content| drop(self.shown.remove(content)));
    }

    /// Drops every picture: another scene is coming.
    pub fn forget(&mut self) {
        self.shown.clear();
    }

    /// What the picture of `content` was made from; empty before the first one.
    pub fn source(&self, content: PaneContent) -> Source {
        self.shown.get(&content).map(|shot| shot.about.source.clone()).unwrap_or_default()
    }

    /// The film of a mode in the first picture that was made from one.
    pub fn film(&self, state: &State, mode: Mode) -> Option<&Arc<Snapshot>> {
        let shots = state.settings.shown_panes().iter().filter_map(|content| self.shown.get(content));
        shots.flat_map(|shot| &shot.about.source.films).find(|film| film.mode == mode)
    }

    /// How the difference that `content` shows is coloured, and its mean; `None` where there is none of epoch `floor` or later.
    pub fn difference(&self, content: PaneContent, floor: u64) -> Option<(DifferenceKind, f64)> {
        let shot = self.shown.get(&content)?;
        shot.about.mean_difference.filter(|_| shot.about.source.epochs().all(|shown| shown >= floor))
    }

    /// The scale of the colours of the picture of `content`, if it shows a difference in luminance.
    pub fn scale(&self, content: PaneContent) -> Option<Scale> {
        self.shown.get(&content)?.about.scale
    }

    /// The histogram of the picture of `content`, where one was asked for.
    pub fn histogram(&self, content: PaneContent) -> Option<&Histogram> {
        self.shown.get(&content)?.about.histogram.as_deref()
    }

    /// What is said of the pixel under the pointer in pane `index`, line by line.
    pub fn values(&self, index: usize, state: &State) -> Vec<String> {
        self.pointer.map_or_else(Vec::new, |point| self.values_at(index, state, point))
    }

    /// What is said of the pixel at `point`, in [0, 1]² of the film, in pane `index`.
    pub fn values_at(&self, index: usize, state: &State, point: [f64; 2]) -> Vec<String> {
        let content = state.settings.panes[index];
        let is_framed = content.snapshots().filter_map(|id| state.snapshots.get(id)).any(|kept| {
            let [film, kept] =
                [state.film_size(), kept.film.size].map(|[width, height]| Vec2::new(width as f32, height as f32));
            let room = Rect::from_min_size(egui::Pos2::ZERO, film);
            fitted(room, kept) != room
        });
        // A picture of another shape does not fill its pane.
        let shot = self.shown.get(&content).filter(|_| !is_framed);
        shot.map_or_else(Vec::new, |shot| {
            let point = shot.point(state.film_size(), point);
            values::lines(content, &shot.about, state.settings.difference, point)
        })
    }

    /// Samples per pixel of an up-to-date picture at full resolution; 0 before.
    pub fn samples(&self, content: PaneContent, state: &State) -> u32 {
        let source = self.source(content);
        let is_current = source.epochs().all(|epoch| epoch >= state.picture_floor()) && !source.is_preview();
        if is_current { source.samples() } else { 0 }
    }

    /// Shows the panes in all the room that is left, and reads the pointer.
    pub fn show(&mut self, ui: &mut Ui, state: &mut State, commands: &mut Vec<Command>) {
        let area = ui.available_rect_before_wrap();
        self.places.clear();
        if self.is_still {
            // Labels look as if the pointer were elsewhere.
            let widgets = &mut ui.visuals_mut().widgets;
            (widgets.hovered, widgets.active, widgets.open) = (widgets.inactive, widgets.inactive, widgets.inactive);
        }
        // The focus goes to one pane or another, not to all of them.
        let response = ui.allocate_rect(area, Sense::CLICK | Sense::DRAG);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Group, true, "Pictures"));
        let palette = Palette::of(ui);
        ui.painter().rect_filled(area, 0.0, palette.canvas);
        if area.width() < 8.0 || area.height() < 8.0 {
            return;
        }
        let settings = &state.settings;
        let panes = panes(area, settings.pane_count, settings.arrangement, state.view.divider);
        let pixels = panes[0].picture.size() * ui.ctx().pixels_per_point() * settings.resolution_scale;
        self.places.extend(panes.iter().map(|pane| pane.visible));
        let pixels = film_size(pixels.into(), ui.input(|input| input.max_texture_side));
        if let Some(rest) = state.set_pane_size(pixels, ui.input(|input| input.time)) {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(rest));
        }
        let (film, is_whole) = (state.film_size(), state.has_fixed_film_size());
        let panes: Vec<Pane> =
            panes.into_iter().map(|pane| pane.filled_by(film, pixels, ui.pixels_per_point(), is_whole)).collect();
        self.drop_stale(state);
        self.picture = Some(panes[0].picture);

        self.read_pointer(ui, &response, state, &panes, commands);
        for (index, pane) in panes.iter().enumerate() {
            self.paint_picture(ui, state, index, *pane);
            let painter = ui.painter().with_clip_rect(pane.visible.intersect(ui.clip_rect()));
            if is_slice(state, index) {
                slice::paint_path(&painter, state, index, pane);
                continue;
            }
            path::paint(&painter, state, index, pane);
            slice::paint_outline(&painter, state, pane);
            if !self.is_still {
                let is_choosing = ui.input(|input| input.modifiers.command) && pane_is_hovered(&response, pane);
                lights::paint(&painter, state, pane, is_choosing);
                self.handles.paint(&painter, state, &panes, index);
            }
        }
        self.paint_dividers(ui, state, &panes);
        self.labels.clear();
        // What the labels of a path keep clear of.
        let mut taken = Vec::new();
        let nothing = About::default();
        for (index, pane) in panes.iter().enumerate() {
            let about = self.shown.get(&state.settings.panes[index]).map_or(&nothing, |shot| &shot.about);
            keyboard::pane_ui(ui, state, about, index, pane, !self.is_still, commands);
            let [label, legend] = overlay::pane_ui(ui, state, about, index, *pane, commands);
            self.labels.extend(label);
            taken.extend(label.into_iter().chain(legend));
        }
        taken.extend(overlay::zoom_ui(ui, state, area));
        if !self.is_still {
            taken.extend(tools::show(ui, state, &panes[0], commands));
            taken.extend(self.values_ui(ui, &response, state, &panes));
        }
        for (index, pane) in panes.iter().enumerate().filter(|(index, _)| !is_slice(state, *index)) {
            let painter = ui.painter().with_clip_rect(pane.visible.intersect(ui.clip_rect()));
            path::paint_labels(&painter, state, index, pane, &taken);
        }
        if self.is_still {
            return;
        }
        if let Some(pos) = response.hover_pos().filter(|_| self.drag.is_none() && self.slice_drag.is_none())
            && let Some(index) = panes.iter().position(|pane| pane.visible.contains(pos))
        {
            match state.settings.panes[index] {
                PaneContent::Surfaces(_) => {
                    let point = handles::film_point(state, &panes[index], pos);
                    if handles::is_on_film(point) {
                        legend::show_faces(ui, state, &panes[index], pos, point);
                    }
                }
                PaneContent::Slice(mode) if state.settings.show_values => {
                    slice::show_probe(ui, state, &panes[index], mode, pos);
                }
                _ => {}
            }
        }
    }

    /// The numbers under the pointer, and in the other panes where that is. Returns where the numbers are.
    fn values_ui(&mut self, ui: &Ui, response: &egui::Response, state: &State, panes: &[Pane]) -> Vec<Rect> {
        let hovered = response.hover_pos().filter(|_| self.drag.is_none());
        let over = hovered.and_then(|pos| Some((pos, panes.iter().position(|pane| pane.visible.contains(pos))?)));
        // A point of a slice is none of the film.
        let over = over.filter(|(_, index)| !is_slice(state, *index));
        self.pointer = (over.map(|(pos, index)| handles::film_point(state, &panes[index], pos)))
            .filter(|point| handles::is_on_film(*point));
        let (Some(point), Some((_, over))) = (self.pointer.filter(|_| state.settings.show_values), over) else {
            return Vec::new();
        };
        let mut places = Vec::new();
        for (index, pane) in panes.iter().enumerate() {
            let content = state.settings.panes[index];
            if is_slice(state, index) {
                continue;
            }
            if index != over && state.settings.arrangement == Arrangement::Tiles {
                let painter = ui.painter().with_clip_rect(pane.visible.intersect(ui.clip_rect()));
                values::paint_cross(&painter, state, pane.picture, point);
            }
            let [to_right, to_bottom] = overlay::label_corner(state, index);
            // Above what else may be in that corner or reach into it.
            let has_zoom = state.view.zoom > 1.0 && pane.visible.left() <= response.rect.left() + 1.0;
            let is_lowest = pane.visible.bottom() >= response.rect.bottom() - 4.0;
            let mut lift: f32 = if has_zoom && is_lowest { 30.0 } else { 0.0 };
            if content.is_difference() && (pane.visible.width() < 390.0 || (to_right && to_bottom)) {
                lift = lift.max(range::HEIGHT + 6.0);
            }
            places.extend(values::show(ui, &self.values(index, state), pane, to_bottom, lift));
        }
        places
    }

    fn paint_picture(&self, ui: &Ui, state: &State, index: usize, pane: Pane) {
        let painter = ui.painter().with_clip_rect(pane.visible.intersect(ui.clip_rect()));
        if let Some(shot) = self.shown.get(&state.settings.panes[index]) {
            // A slice has a magnification of its own.
            let is_slice = is_slice(state, index);
            let zoom = if is_slice { 1.0 } else { state.view.zoom };
            let center = if is_slice { [0.5; 2] } else { state.view.zoom_center };
            let window = film_window(zoom, center);
            let is_kept = matches!(state.settings.panes[index], PaneContent::Snapshot(_));
            if let Some(size) = shot.about.source.full_size().filter(|_| is_kept) {
                let place = fitted(pane.picture, Vec2::new(size[0] as f32, size[1] as f32));
                shot.paint(&painter, size, place, window);
            } else {
                shot.paint(&painter, state.film_size(), pane.picture, window);
            }
            if state.path_options.is_ghost && state.inspection.is_some() {
                painter.rect_filled(pane.visible, 0.0, path::GHOST);
            }
        } else if let Some(text) = state.snapshots.obstacle(state.settings.panes[index], state.film_size()) {
            let palette = Palette::of(ui);
            let font = egui::TextStyle::Body.resolve(ui.style());
            let width = (pane.visible.width() - 40.0).max(60.0);
            let mut job = egui::text::LayoutJob::simple(text, font, palette.weak_text, width);
            job.halign = egui::Align::Center;
            let galley = painter.layout_job(job);
            let top = pane.visible.center() - Vec2::new(0.0, galley.size().y / 2.0);
            painter.galley(top, galley, palette.weak_text);
        } else {
            let palette = Palette::of(ui);
            let is_error = matches!(state.settings.panes[index], PaneContent::Error(_));
            let text = match () {
                () if !state.has_scene => "Opening the scene…",
                () if state.report.is_none() => "Preparing the scene…",
                () if is_error && !state.measurement.is_on() => "No reference image: make one in the tab Measure",
                () if is_error => "Waiting for the reference image…",
                () if is_slice(state, index) => "Cutting…",
                () => "Rendering…",
            };
            let font = egui::TextStyle::Body.resolve(ui.style());
            painter.text(pane.visible.center(), egui::Align2::CENTER_CENTER, text, font, palette.weak_text);
        }
        if state.has_path_at_pixel() && !is_slice(state, index) {
            overlay::paint_marker(&painter, state, pane.picture);
        }
        if state.settings.pane_count > 1 && index == state.view.active_pane && !self.is_still {
            let stroke = egui::Stroke::new(1.5, Palette::of(ui).accent);
            painter.rect_stroke(pane.visible, 0.0, stroke, egui::StrokeKind::Inside);
        }
    }

    fn paint_dividers(&self, ui: &Ui, state: &State, panes: &[Pane]) {
        if state.settings.arrangement == Arrangement::Tiles || panes.len() < 2 {
            return;
        }
        let area = panes[0].picture;
        let first = panes[0].visible;
        let line = |rect: Rect| {
            ui.painter().rect_filled(rect.expand(1.0), 0.0, Color32::from_black_alpha(120));
            ui.painter().rect_filled(rect, 0.0, Color32::from_white_alpha(230));
        };
        line(Rect::from_center_size(egui::pos2(first.right(), area.center().y), Vec2::new(1.0, area.height())));
        let mut handle = egui::pos2(first.right(), area.center().y);
        if panes.len() == 4 {
            line(Rect::from_center_size(egui::pos2(area.center().x, first.bottom()), Vec2::new(area.width(), 1.0)));
            handle.y = first.bottom();
        }
        overlay::paint_handle(ui.painter(), handle);
    }
}

/// The largest rectangle in `room` that has the shape of an image of `size`; all of it where the shapes are nearly the same.
fn fitted(room: Rect, size: Vec2) -> Rect {
    let scale = (room.width() / size.x).min(room.height() / size.y);
    let fitted = size * scale;
    let is_same = (room.size() - fitted).max_elem() <= 0.01 * room.size().max_elem();
    if is_same { room } else { Rect::from_center_size(room.center(), fitted) }
}

fn pane_is_hovered(response: &egui::Response, pane: &Pane) -> bool {
    response.hover_pos().is_some_and(|pos| pane.visible.contains(pos))
}

fn is_slice(state: &State, index: usize) -> bool {
    matches!(state.settings.panes[index], PaneContent::Slice(_))
}
