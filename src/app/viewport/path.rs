//! The inspected path over the pictures.

use egui::{Color32, FontId, Painter, Pos2, Rect, Shape, Stroke as Pen, pos2, vec2};
use glam::DVec3;

use super::layout::{Pane, film_window, screen_from_film};
use super::overlay::label_corner;
use super::sight::Sight;
use crate::app::paths::strokes::{Stroke, Weight, label, place_labels, strokes};
use crate::app::paths::{Line, Traced};
use crate::app::state::{State, modes_over};
use crate::app::theme::opaque;
use crate::app::theme::over_pictures::{ALERT, GROUND, TEXT};
use crate::tracking::Mode;
use crate::transport::inspect::VertexEvent;
use crate::transport::parting::Parting;

/// Lies over the picture in a view that shows the path alone.
pub(super) const GHOST: Color32 = Color32::from_black_alpha(178);
/// Dashes and gaps of a path that is compared with, in points.
pub const DASH: [f32; 2] = [7.0, 5.0];
const DOT: f32 = 3.0;
const RING: f32 = 9.0;
/// A vertex is clicked within this many points.
const REACH: f32 = 7.0;
/// So near to the marker a click means a pixel and no vertex.
const MARKER: f32 = 14.0;
/// Width of the sentence in the picture.
const SENTENCE: f32 = 250.0;
/// The room of a pane's label.
const LABEL: egui::Vec2 = vec2(230.0, 62.0);

/// The paths over one pane: its own modes', then the one to compare with.
pub fn modes_drawn(state: &State, index: usize) -> Vec<Mode> {
    let mut modes = modes_over(state.settings.panes[index]);
    modes.extend(state.path_options.against.filter(|against| !modes.contains(against)));
    modes
}

/// Puts places of the scene on the screen.
fn projection<'a>(state: &State, pane: &Pane, sight: &'a Sight) -> impl Fn(DVec3) -> Option<Pos2> + use<'a> {
    let window = film_window(state.view.zoom, state.view.zoom_center);
    let picture = pane.picture;
    move |place| {
        let pos = screen_from_film(picture, window, sight.film(place)?);
        // Beyond this f32 and the tessellator have trouble, and nothing is seen.
        (pos.x.abs() < 1e5 && pos.y.abs() < 1e5).then_some(pos)
    }
}

/// Draws the inspected path over pane `index`.
pub(super) fn paint(painter: &Painter, state: &State, index: usize, pane: &Pane) {
    let Some(inspection) = &state.inspection else { return };
    let (Some(traced), Some(sight)) = (&inspection.traced, Sight::of(state)) else { return };
    let screen = projection(state, pane, &sight);
    if state.path_options.is_ghost {
        paint_outlines(painter, traced, &sight, &screen);
    }
    let modes = modes_drawn(state, index);
    for (rank, mode) in modes.iter().enumerate().rev() {
        let lines = traced.lines.get(mode).map(Vec::as_slice).unwrap_or_default();
        let all: Vec<Stroke> = (lines.iter().enumerate().skip(1))
            .flat_map(|(_, line)| strokes(line, Weight::Bundle, &screen))
            .chain(lines.first().into_iter().flat_map(|line| strokes(line, Weight::Main, &screen)))
            .collect();
        paint_strokes(painter, &all, rank > 0);
    }
    let Some(line) = modes.first().and_then(|mode| traced.lines.get(mode)?.first()) else { return };
    let is_listed = state.inspected_mode() == line.path.mode;
    let selected = inspection.vertex.filter(|_| is_listed);
    paint_dots(painter, line, selected, &screen);
    let parting = traced.parting.as_ref().filter(|_| traced.question.pair == state.compared_modes());
    let parted_at = parting.and_then(|parting| screen(parting.position.into()));
    if let Some(at) = parted_at {
        for (width, color) in [(4.5, Color32::from_black_alpha(170)), (2.0, ALERT)] {
            painter.circle_stroke(at, RING, Pen::new(width, color));
        }
    }
    let sentence = parting.filter(|_| index == state.view.active_pane).map(Parting::heading);
    paint_labels(painter, state, index, pane, line, selected, parted_at.zip(sentence), &screen);
}

fn paint_strokes(painter: &Painter, strokes: &[Stroke], is_dashed: bool) {
    let pass = |more: f32, color: &dyn Fn(&Stroke) -> Color32| {
        for stroke in strokes {
            let pen = Pen::new(stroke.width + more, color(stroke));
            let ends = [stroke.from, stroke.to];
            if is_dashed {
                painter.extend(Shape::dashed_line(&ends, pen, DASH[0], DASH[1]));
            } else {
                painter.line_segment(ends, pen);
            }
        }
    };
    // A dark edge below, so that it is seen on bright pictures too.
    pass(2.2, &|stroke| Color32::from_black_alpha((stroke.opacity * 150.0) as u8));
    pass(0.0, &|stroke| opaque(stroke.color).gamma_multiply(stroke.opacity));
}

fn paint_dots(painter: &Painter, line: &Line, selected: Option<usize>, screen: &impl Fn(DVec3) -> Option<Pos2>) {
    for (index, vertex) in line.path.vertices.iter().enumerate() {
        if vertex.event == VertexEvent::Skip && selected != Some(index) {
            continue;
        }
        let Some(at) = screen(vertex.position.into()) else { continue };
        let fill = if vertex.is_consistent { Color32::WHITE } else { ALERT };
        painter.circle(at, DOT, fill, Pen::new(1.2, Color32::from_black_alpha(200)));
        if selected == Some(index) {
            for (width, color) in [(4.0, Color32::from_black_alpha(170)), (1.8, Color32::WHITE)] {
                painter.circle_stroke(at, DOT + 3.5, Pen::new(width, color));
            }
        }
    }
}

#[expect(clippy::too_many_arguments, reason = "what labels say and what they must keep clear of")]
fn paint_labels(
    painter: &Painter,
    state: &State,
    index: usize,
    pane: &Pane,
    line: &Line,
    selected: Option<usize>,
    sentence: Option<(Pos2, String)>,
    screen: &impl Fn(DVec3) -> Option<Pos2>,
) {
    let font = FontId::monospace(10.5);
    let mut texts = Vec::new();
    if let Some((at, text)) = sentence {
        texts.push((at, painter.layout(text, FontId::proportional(12.0), ALERT, SENTENCE)));
    }
    // What is pointed out first.
    let mut order: Vec<usize> = (0..line.path.vertices.len()).collect();
    order.sort_by_key(|&k| selected != Some(k));
    for k in order {
        let vertex = &line.path.vertices[k];
        if let (Some(text), Some(at)) = (label(vertex), screen(vertex.position.into())) {
            texts.push((at, painter.layout_no_wrap(text, font.clone(), TEXT)));
        }
    }
    let anchors: Vec<(Pos2, egui::Vec2)> =
        texts.iter().map(|(at, galley)| (*at, galley.size() + vec2(10.0, 6.0))).collect();
    let room = pane.visible.shrink(4.0);
    let placed = place_labels(&anchors, room, &[label_room(state, index, pane)]);
    for ((_, galley), rect) in texts.into_iter().zip(placed) {
        if let Some(rect) = rect {
            painter.rect_filled(rect, 4.0, GROUND);
            painter.galley(rect.min + vec2(5.0, 3.0), galley, TEXT);
        }
    }
}

/// Where a pane's own label is.
fn label_room(state: &State, index: usize, pane: &Pane) -> Rect {
    let [to_right, to_bottom] = label_corner(state, index);
    let Rect { min, max } = pane.visible;
    let corner = pos2(if to_right { max.x - LABEL.x } else { min.x }, if to_bottom { max.y - LABEL.y } else { min.y });
    Rect::from_min_size(corner, LABEL)
}

fn paint_outlines(painter: &Painter, traced: &Traced, sight: &Sight, screen: &impl Fn(DVec3) -> Option<Pos2>) {
    let pen = Pen::new(1.0, Color32::from_white_alpha(70));
    for [from, to] in traced.outlines.seen_from(sight.camera.position) {
        if let (Some(from), Some(to)) = (screen(from), screen(to)) {
            painter.line_segment([from, to], pen);
        }
    }
}

/// The vertex of the listed path under `pos` in a pane, if a click there would not rather mean another pixel.
pub(super) fn vertex_at(state: &State, index: usize, pane: &Pane, pos: Pos2) -> Option<usize> {
    let inspection = state.inspection.as_ref()?;
    let (traced, sight) = (inspection.traced.as_ref()?, Sight::of(state)?);
    let mode = modes_over(state.settings.panes[index]).first().copied()?;
    let window = film_window(state.view.zoom, state.view.zoom_center);
    let [x, y] = inspection.point.map(|x| x as f32);
    let marker = screen_from_film(pane.picture, window, pos2(x, y));
    if state.has_path_at_pixel() && marker.distance(pos) < MARKER {
        return None;
    }
    let screen = projection(state, pane, &sight);
    let near = traced.path(mode)?.vertices.iter().enumerate().filter_map(|(k, vertex)| {
        let distance = screen(vertex.position.into())?.distance(pos);
        (distance < REACH && vertex.event != VertexEvent::Skip).then_some((k, distance))
    });
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
}
