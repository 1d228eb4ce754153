//! The inspected path over the pictures.

use egui::{Color32, FontId, Painter, Pos2, Rect, Shape, Stroke as Pen, pos2, vec2};
use glam::DVec3;

use super::layout::{Pane, film_window, screen_from_film};
use super::sight::Sight;
use crate::app::paths::strokes::{Label, Stroke, Weight, label, place_labels, strokes};
use crate::app::paths::{Line, Traced};
use crate::app::state::{Inspection, State, modes_over};
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
/// Most width of the sentence in the picture.
const SENTENCE: f32 = 250.0;
/// What a label has around its text, both sides together.
const PADDING: egui::Vec2 = vec2(10.0, 6.0);

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
    paint_dots(painter, line, selected_vertex(state, inspection, line), &screen);
    let parting = parting(state, traced);
    if let Some(at) = parting.and_then(|parting| screen(parting.position.into())) {
        for (width, color) in [(4.5, Color32::from_black_alpha(170)), (2.0, ALERT)] {
            painter.circle_stroke(at, RING, Pen::new(width, color));
        }
    }
}

/// The vertex of `line` that is pointed out, by index.
fn selected_vertex(state: &State, inspection: &Inspection, line: &Line) -> Option<usize> {
    inspection.vertex.filter(|_| state.inspected_mode() == line.path.mode)
}

/// Where the compared paths part, once that is known.
fn parting<'a>(state: &State, traced: &'a Traced) -> Option<&'a Parting> {
    traced.parting.as_ref().filter(|_| traced.question.pair == state.compared_modes())
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

/// The labels of the inspected path over pane `index`, clear of what is `taken`: the pane's own label, its legend, and what else lies there.
pub(super) fn paint_labels(painter: &Painter, state: &State, index: usize, pane: &Pane, taken: &[Rect]) {
    let Some(inspection) = &state.inspection else { return };
    let (Some(traced), Some(sight)) = (&inspection.traced, Sight::of(state)) else { return };
    let modes = modes_drawn(state, index);
    let Some(line) = modes.first().and_then(|mode| traced.lines.get(mode)?.first()) else { return };
    let screen = projection(state, pane, &sight);
    let font = FontId::monospace(10.5);
    let room = pane.visible.shrink(4.0);
    // Texts, and whether they may stand far away.
    let mut texts = Vec::new();
    if let Some(parting) = parting(state, traced).filter(|_| index == state.view.active_pane)
        && let Some(at) = screen(parting.position.into())
    {
        let width = SENTENCE.min(room.width() - PADDING.x).max(40.0);
        texts.push((at, painter.layout(parting.heading(), FontId::proportional(12.0), ALERT, width), true));
    }
    // What is pointed out first.
    let selected = selected_vertex(state, inspection, line);
    let mut order: Vec<usize> = (0..line.path.vertices.len()).collect();
    order.sort_by_key(|&k| selected != Some(k));
    for k in order {
        let vertex = &line.path.vertices[k];
        if let (Some(text), Some(at)) = (label(vertex), screen(vertex.position.into())) {
            texts.push((at, painter.layout_no_wrap(text, font.clone(), TEXT), false));
        }
    }
    let labels: Vec<Label> = (texts.iter())
        .map(|(at, galley, goes_far)| Label { anchor: *at, size: galley.size() + PADDING, goes_far: *goes_far })
        .collect();
    for ((_, galley, _), rect) in texts.into_iter().zip(place_labels(&labels, room, taken)) {
        if let Some(rect) = rect {
            painter.rect_filled(rect, 4.0, GROUND);
            painter.galley(rect.min + 0.5 * PADDING, galley, TEXT);
        }
    }
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
