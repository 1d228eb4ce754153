//! What is drawn over a slice, what the pointer does there, and the slice's outline in the other panes.

use egui::{
    Color32, CursorIcon, Key, Modifiers, Painter, PointerButton, Pos2, Rect, Response, Shape, Stroke, Ui, Vec2, pos2,
    vec2,
};
use glam::{DVec2, DVec3};

use super::layout::{Pane, film_window, screen_from_film};
use super::sight::Sight;
use crate::app::command::Command;
use crate::app::develop::Source;
use crate::app::settings::PaneContent;
use crate::app::slice::{Facing, Placed, SliceView, ZOOM};
use crate::app::state::State;
use crate::app::theme::over_pictures::{GROUND, TEXT, WEAK};
use crate::app::theme::{self, opaque};
use crate::render::slice::{Filling, Ink, Plane, Probe, Slice, Testimony, probe};
use crate::render::surfaces::medium_color;
use crate::scene::{ObjectId, Scene};
use crate::tracking::{Mode, Prepared};

/// Steps over the whole scene that the wheel moves the plane by.
const NOTCHES: f64 = 60.0;
/// Points of scrolling per wheel notch.
const POINTS_PER_NOTCH: f32 = 50.0;
/// A segment of a path is drawn strong where it is this near to the plane, as a part of the picture's height.
const NEAR: f64 = 0.02;
/// The color of the path.
const PATH: Color32 = Color32::from_rgb(0xff, 0xff, 0xff);
const ROW: f32 = 17.0;
const SWATCH: f32 = 10.0;
const PADDING: f32 = 8.0;
const LEGEND: &str = "Media with their IOR. Stripes: the nearest surfaces to the left, to the right, above and below name different media, of which each stripe has one. Thin dark stripes: they name the same, but fewer than nine in ten rays of the pre-trace agree.";
/// Most of a pane's height that a legend takes.
const SHARE: f32 = 0.55;

/// What a drag in a slice moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SliceDrag {
    /// The picture in its plane.
    Pan,
    /// The plane along its normal.
    Normal,
}

fn aspect(pane: &Pane) -> f64 {
    f64::from(pane.picture.width()) / f64::from(pane.picture.height().max(1.0))
}

/// The point in [0, 1]² of the slice under a point of the screen.
fn point_at(pane: &Pane, pos: Pos2) -> DVec2 {
    let share = (pos - pane.picture.min) / pane.picture.size();
    DVec2::new(f64::from(share.x), f64::from(share.y))
}

/// What the pointer does over a slice.
pub(super) fn read_pointer(
    ui: &Ui,
    response: &Response,
    state: &State,
    pane: &Pane,
    index: usize,
    drag: &mut Option<SliceDrag>,
    commands: &mut Vec<Command>,
) {
    let Some(placed) = state.placed_slice() else { return };
    let Placed { view, plane, along, range } = placed;
    let set = |view: SliceView| Command::SetSlice(view);
    let shift = ui.input(|input| input.modifiers.shift);
    if response.drag_started() {
        let is_normal = shift || !response.dragged_by(PointerButton::Primary);
        *drag = Some(if is_normal { SliceDrag::Normal } else { SliceDrag::Pan });
    }
    let delta = response.drag_delta();
    if response.dragged() && delta != Vec2::ZERO {
        let per_point = plane.height / f64::from(pane.picture.height().max(1.0));
        match *drag {
            Some(SliceDrag::Pan) => {
                let moved = plane.right * f64::from(delta.x) - plane.up * f64::from(delta.y);
                commands.push(set(SliceView { pan: view.pan - moved * per_point, ..view }));
            }
            Some(SliceDrag::Normal) => {
                // Up is away from the viewer.
                let away = f64::from(delta.y) * per_point * plane.normal().dot(along).signum();
                commands.push(set(SliceView { offset: (view.offset + away).clamp(range[0], range[1]), ..view }));
            }
            None => {}
        }
    }
    if response.drag_stopped() {
        *drag = None;
    }
    if response.clicked() {
        commands.push(Command::SetActivePane(index));
        if let Some(pos) = response.interact_pointer_pos() {
            select(state, &plane, pane, mode_of(state, index), pos, commands);
        }
    }
    if let Some(pos) = response.hover_pos() {
        let (scroll, zoom) = ui.input(|input| (input.smooth_scroll_delta().y, f64::from(input.zoom_delta())));
        if (zoom - 1.0).abs() > 1e-4 {
            let next = (view.zoom * zoom).clamp(*ZOOM.start(), *ZOOM.end());
            // The place under the pointer stays there.
            let away = plane.place(aspect(pane), point_at(pane, pos)) - plane.center;
            commands.push(set(SliceView { zoom: next, pan: view.pan + away * (1.0 - view.zoom / next), ..view }));
        } else if scroll != 0.0 {
            let away = f64::from(scroll / POINTS_PER_NOTCH) * plane.normal().dot(along).signum();
            commands.push(set(SliceView { offset: moved(view, range, -away), ..view }));
        }
        ui.set_cursor_icon(match drag {
            Some(SliceDrag::Pan) => CursorIcon::Grabbing,
            Some(SliceDrag::Normal) => CursorIcon::ResizeVertical,
            None => CursorIcon::Crosshair,
        });
    }
}

/// What the keys do in a slice that has the focus: arrows move the picture, with Shift the plane; plus and minus zoom.
pub(super) fn read_keys(ui: &Ui, state: &State, pane: &Pane, commands: &mut Vec<Command>) {
    /// What a press moves the picture by, as a part of its height.
    const STEP: f64 = 1.0 / 20.0;
    /// What a press magnifies by.
    const FACTOR: f64 = 1.25;
    let Some(Placed { view, plane, along, range }) = state.placed_slice() else { return };
    let count =
        |modifiers: Modifiers, key: Key| ui.input_mut(|input| input.count_and_consume_key(modifiers, key)) as f64;
    let pair = |modifiers: Modifiers, less: Key, more: Key| count(modifiers, more) - count(modifiers, less);
    // Those with a modifier first: a key without takes any.
    let away = pair(Modifiers::SHIFT, Key::ArrowDown, Key::ArrowUp);
    let (x, y) =
        (pair(Modifiers::NONE, Key::ArrowLeft, Key::ArrowRight), pair(Modifiers::NONE, Key::ArrowDown, Key::ArrowUp));
    let larger =
        count(Modifiers::NONE, Key::Plus) + count(Modifiers::NONE, Key::Equals) - count(Modifiers::NONE, Key::Minus);
    let next = SliceView {
        offset: if away == 0.0 { view.offset } else { moved(view, range, -away * plane.normal().dot(along).signum()) },
        pan: view.pan + (plane.right * x + plane.up * y) * (STEP * plane.height),
        zoom: (view.zoom * FACTOR.powf(larger)).clamp(*ZOOM.start(), *ZOOM.end()),
        ..view
    };
    if next != view {
        commands.push(Command::SetSlice(next));
    }
    if count(Modifiers::NONE, Key::Enter) > 0.0 {
        select(state, &plane, pane, mode_of(state, state.view.active_pane), pane.picture.center(), commands);
    }
}

/// The offset after so many steps of the wheel.
fn moved(view: SliceView, range: [f64; 2], steps: f64) -> f64 {
    (view.offset + steps * (range[1] - range[0]) / NOTCHES).clamp(range[0], range[1])
}

fn mode_of(state: &State, index: usize) -> Mode {
    state.settings.panes[index].inspected_mode()
}

/// What a mode finds at a point of the slice; `None` while that would have to be waited for.
fn ask(state: &State, prepared: &Prepared, mode: Mode, plane: Plane, point: DVec2) -> Option<Probe> {
    let must_wait = mode == Mode::Reference && prepared.bodies.get().is_none();
    if must_wait { None } else { probe(prepared, mode, plane, state.film_size(), point.to_array()) }
}

/// Selects the innermost refractor at a place, or nothing.
fn select(state: &State, plane: &Plane, pane: &Pane, mode: Mode, pos: Pos2, commands: &mut Vec<Command>) {
    let Some(report) = &state.report else { return };
    let scene = &report.prepared.scene;
    let Some(found) = ask(state, &report.prepared, mode, *plane, point_at(pane, pos)) else { return };
    let smallest = |a: &&ObjectId, b: &&ObjectId| scene.object(**a).volume.total_cmp(&scene.object(**b).volume);
    let name = found.refractors.iter().min_by(smallest).map(|id| scene.object(*id).name.clone());
    commands.push(Command::SelectObject(name));
}

/// The inspected path at its foot in the plane: strong where it lies in it, faint elsewhere.
pub(super) fn paint_path(painter: &Painter, state: &State, index: usize, pane: &Pane) {
    let (Some(inspection), Some(placed)) = (&state.inspection, state.placed_slice()) else { return };
    let Some(path) = inspection.path(mode_of(state, index)) else { return };
    let plane = placed.plane;
    let mut places = vec![DVec3::from(path.origin)];
    places.extend(path.vertices.iter().map(|vertex| DVec3::from(vertex.position)));
    if path.escaped {
        let last = places[places.len() - 1];
        places.push(last + DVec3::from(path.final_direction) * (4.0 * plane.height));
    }
    let foot = |place: DVec3| plane.foot(aspect(pane), place);
    let screen = |point: DVec2| pane.picture.min + vec2(point.x as f32, point.y as f32) * pane.picture.size();
    let near = NEAR * plane.height;
    // Faint parts first, so that strong ones lie over them.
    for is_strong in [false, true] {
        for pair in places.windows(2) {
            let (from, to) = (foot(pair[0]), foot(pair[1]));
            let line = |a: f64, b: f64, width: f32, color: Color32| {
                let at = |t: f64| screen(from.0.lerp(to.0, t));
                for (extra, color) in [(1.6, Color32::from_black_alpha(color.a() / 2 + 60)), (0.0, color)] {
                    painter.line_segment([at(a), at(b)], Stroke::new(width + extra, color));
                }
            };
            match within(from.1, to.1, near).filter(|_| is_strong) {
                Some((a, b)) => line(a, b, 2.2, PATH),
                None if !is_strong => line(0.0, 1.0, 1.0, PATH.gamma_multiply(0.35)),
                None => {}
            }
        }
    }
    for place in &places[1..] {
        let (point, distance) = foot(*place);
        if distance.abs() < near {
            painter.circle(screen(point), 3.0, PATH, Stroke::new(1.0, Color32::BLACK));
        }
    }
}

/// The part of a segment, between 0 and 1, whose distances from the plane lie within `near`, given those of its ends.
fn within(from: f64, to: f64, near: f64) -> Option<(f64, f64)> {
    if from.abs().max(to.abs()) <= near {
        return Some((0.0, 1.0));
    }
    let (a, b) = ((-near - from) / (to - from), (near - from) / (to - from));
    let (low, high) = (a.min(b).max(0.0), a.max(b).min(1.0));
    (low < high).then_some((low, high))
}

/// What the colours mean, in the lower right corner of `room`, or in the lower left one. Returns where it is, if there is room.
pub(super) fn show_legend(
    ui: &Ui,
    state: &State,
    source: &Source,
    index: usize,
    room: Rect,
    at_left: bool,
) -> Option<Rect> {
    let (Some(cut), Some(report)) = (&source.slice, &state.report) else { return None };
    if room.width() < 120.0 || room.height() < 80.0 {
        return None;
    }
    let painter = ui.painter();
    let font = egui::TextStyle::Small.resolve(ui.style());
    let slice = &cut.slice;
    let fitting = ((room.height() * SHARE - 2.0 * PADDING) / ROW).floor().max(2.0) as usize;
    let mut inks: Vec<Ink> = slice.seen.iter().map(|(ink, _)| *ink).collect();
    let more = (inks.len() + 1).saturating_sub(fitting);
    inks.truncate(inks.len() - more.min(inks.len()));
    inks.sort_unstable();
    let width = room.width() * 0.8 - 2.0 * PADDING - SWATCH - 6.0;
    let fit = |text: String| {
        let mut job = egui::text::LayoutJob::simple_singleline(text, font.clone(), TEXT);
        job.wrap = egui::text::TextWrapping::truncate_at_width(width);
        painter.layout_job(job)
    };
    let mut rows: Vec<_> = inks.iter().map(|ink| (Some(*ink), fit(label(*ink, slice, &report.prepared)))).collect();
    if more > 0 {
        rows.push((None, fit(format!("and {more} more"))));
    }
    rows.push((None, fit(slice.doubt_in_words())));
    let widest = rows.iter().map(|(_, galley)| galley.size().x).fold(0.0, f32::max);
    let size = vec2(widest + SWATCH + 6.0, rows.len() as f32 * ROW) + Vec2::splat(2.0 * PADDING);
    let frame = super::legend::in_corner(room, size, at_left);
    let words = rows.iter().map(|(_, galley)| galley.text()).collect::<Vec<_>>().join(", ");
    let response = ui.interact(frame, ui.scope_id().with(("legend", index)), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Legend: {words}")));
    response.on_hover_text(LEGEND);
    painter.rect_filled(frame, 5.0, GROUND);
    let is_striped = slice.doubtful_pixels > 0;
    let last = rows.len() - 1;
    for (row, (ink, galley)) in rows.into_iter().enumerate() {
        let center = frame.top() + PADDING + (row as f32 + 0.5) * ROW;
        let square = Rect::from_center_size(pos2(frame.left() + PADDING + SWATCH / 2.0, center), Vec2::splat(SWATCH));
        match ink {
            // Square corners, or the edge would be smoothed into other colours.
            Some(ink) => {
                _ = painter.rect(square, 0.0, opaque(ink.color()), Stroke::new(1.0, GROUND), egui::StrokeKind::Outside)
            }
            None if row == last && is_striped => paint_stripes(painter, square),
            None => {}
        }
        painter.galley(pos2(square.right() + 6.0, center - galley.size().y / 2.0), galley, TEXT);
    }
    Some(frame)
}

fn label(ink: Ink, slice: &Slice, prepared: &Prepared) -> String {
    match ink {
        Ink::Line if slice.has_null_edges => "dotted: same medium".to_owned(),
        ink => ink.label(prepared),
    }
}

fn paint_stripes(painter: &Painter, square: Rect) {
    painter.rect_filled(square, 0.0, Color32::from_gray(0x50));
    let painter = painter.with_clip_rect(square.intersect(painter.clip_rect()));
    for step in 0..4 {
        let x = square.left() + 5.0 * step as f32;
        let stroke = Stroke::new(2.0, Color32::from_gray(0xd0));
        painter.line_segment([pos2(x, square.top()), pos2(x - SWATCH, square.bottom())], stroke);
    }
}

/// What lies under the pointer, in a box beside it.
pub(super) fn show_probe(ui: &Ui, state: &State, pane: &Pane, mode: Mode, pointer: Pos2) {
    let (Some(report), Some(placed)) = (&state.report, state.placed_slice()) else { return };
    let point = point_at(pane, pointer);
    let Some(found) = ask(state, &report.prepared, mode, placed.plane, point) else { return };
    let scene = &*report.prepared.scene;
    let medium = |id| {
        let medium = scene.medium(id);
        format!("{}  {:.4}", medium.name, medium.ior())
    };
    let mut lines = Vec::new();
    let color = match found.cell.filling {
        Filling::Medium(id) => {
            lines.push(medium(id));
            medium_color(id)
        }
        Filling::Solid => {
            lines.push("solid".to_owned());
            Ink::Solid.color()
        }
        Filling::Light => {
            lines.push("light".to_owned());
            Ink::Light.color()
        }
    };
    if let Some(rival) = found.cell.rival {
        lines.push(format!("or {}", medium(rival)));
    }
    if found.cell.is_doubtful {
        lines.extend(found.testimonies.iter().map(|testimony| said(scene, testimony)));
        lines.dedup();
    }
    lines.push(if found.refractors.is_empty() {
        "in no object".to_owned()
    } else {
        let names: Vec<&str> = found.refractors.iter().map(|id| &*scene.object(*id).name).collect();
        format!("in {}", names.join(", "))
    });
    let place = placed.plane.place(aspect(pane), point);
    lines.push(format!("{:.3}  {:.3}  {:.3}", place.x, place.y, place.z));
    let painter = ui.painter().with_clip_rect(pane.visible.intersect(ui.clip_rect()));
    let galley = painter.layout_no_wrap(lines.join("\n"), theme::small_mono_style().resolve(ui.style()), TEXT);
    let size = galley.size() + vec2(2.0 * PADDING + SWATCH + 6.0, 2.0 * PADDING);
    let min = super::legend::beside(pane.visible.shrink(4.0), pointer, size);
    painter.rect_filled(Rect::from_min_size(min, size), 5.0, Color32::from_black_alpha(215));
    let square = Rect::from_min_size(min + vec2(PADDING, PADDING + 2.0), Vec2::splat(SWATCH));
    painter.rect_filled(square, 0.0, opaque(color));
    painter.galley(min + vec2(PADDING + SWATCH + 6.0, PADDING), galley, TEXT);
}

fn said(scene: &Scene, testimony: &Testimony) -> String {
    let medium = &scene.medium(testimony.medium).name;
    match testimony.object {
        Some(object) => format!("  {} says {medium}", scene.object(object).name),
        None => format!("  nothing in the way: {medium}"),
    }
}

/// The slice's rectangle where the camera sees it.
pub(super) fn paint_outline(painter: &Painter, state: &State, pane: &Pane) {
    /// Pieces of a side.
    const STEPS: u32 = 24;
    let has_slice = state.settings.shown_panes().iter().any(|content| matches!(content, PaneContent::Slice(_)));
    let (true, Some(placed), Some(sight)) = (has_slice, state.placed_slice(), Sight::of(state)) else { return };
    let plane = placed.plane;
    if plane.normal().dot(sight.camera.forward).abs() > 0.999 && matches!(placed.view.facing, Facing::Camera) {
        // It would frame the picture and say nothing.
        return;
    }
    let window = film_window(state.view.zoom, state.view.zoom_center);
    let corner = |x: f64, y: f64| plane.place(aspect(pane), DVec2::new(x, y));
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)].map(|(x, y)| corner(x, y));
    for side in corners.windows(2) {
        // In pieces, of which those behind the camera are left out.
        let seen: Vec<Option<Pos2>> =
            (0..=STEPS).map(|step| sight.film(side[0].lerp(side[1], f64::from(step) / f64::from(STEPS)))).collect();
        for piece in seen.split(Option::is_none) {
            let points: Vec<Pos2> =
                piece.iter().flatten().map(|film| screen_from_film(pane.picture, window, *film)).collect();
            if points.len() > 1 {
                painter.add(Shape::line(points.clone(), Stroke::new(2.5, Color32::from_black_alpha(90))));
                painter.extend(Shape::dashed_line(&points, Stroke::new(1.2, WEAK), 6.0, 4.0));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::within;

    #[test]
    fn the_strong_part_of_a_segment_is_that_near_the_plane() {
        assert_eq!(within(-1.0, 1.0, 0.5), Some((0.25, 0.75)));
        assert_eq!(within(1.0, -1.0, 0.5), Some((0.25, 0.75)));
        assert_eq!(within(0.1, -0.2, 0.5), Some((0.0, 1.0)));
        assert_eq!(within(2.0, 1.0, 0.5), None);
        assert_eq!(within(3.0, 3.0, 0.5), None);
        assert_eq!(within(0.0, 1.0, 0.5), Some((0.0, 0.5)));
    }
}
