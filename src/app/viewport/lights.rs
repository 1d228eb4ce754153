//! Lights that no picture shows: symbols where they stand, while objects are being selected or edited.

use egui::{Color32, Painter, Pos2, Stroke, Vec2};
use glam::DVec3;

use super::layout::{Pane, film_window, screen_from_film};
use super::sight::Sight;
use crate::app::state::State;
use crate::scene::description::{Object, Shape};

/// Radius of a symbol, in points.
const RADIUS: f32 = 5.0;
/// A click this near to the middle of a symbol is on it.
const GRAB: f32 = 10.0;
/// Lines from a spot along the edge of its cone.
const EDGES: u32 = 8;

/// Paints the symbols over a pane. `is_choosing`: whether a click would select, so that all are shown, as they are while something is selected.
pub(super) fn paint(painter: &Painter, state: &State, pane: &Pane, is_choosing: bool) {
    if !is_choosing && state.selected.is_none() {
        return;
    }
    let Some(sight) = Sight::of(state) else { return };
    let window = film_window(state.view.zoom, state.view.zoom_center);
    let screen = |place: DVec3| Some(screen_from_film(pane.picture, window, sight.film(place)?));
    for object in state.document.description().objects.lights().iter().filter(|object| object.visible) {
        let is_selected = state.selected.as_deref() == Some(&object.name);
        match object.shape {
            Shape::Directional { .. } if is_selected => paint_directional(painter, &sight, object, screen),
            Shape::Point { .. } => paint_bulb(painter, place_of(object).and_then(screen), is_selected),
            Shape::Spot { .. } => {
                if is_selected {
                    paint_cone(painter, object, screen);
                }
                paint_bulb(painter, place_of(object).and_then(screen), is_selected);
            }
            _ => {}
        }
    }
}

/// The light whose symbol is at `pos`, by name; of several the nearest one.
pub(super) fn at<'a>(state: &'a State, pane: &Pane, pos: Pos2) -> Option<&'a str> {
    let sight = Sight::of(state)?;
    let window = film_window(state.view.zoom, state.view.zoom_center);
    let lights = state.document.description().objects.lights().iter().filter(|object| object.visible);
    lights
        .filter_map(|object| {
            let center = screen_from_film(pane.picture, window, sight.film(place_of(object)?)?);
            Some((center.distance(pos), &*object.name))
        })
        .filter(|(distance, _)| *distance < GRAB)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// Where a light without a surface stands in the scene, if anywhere.
fn place_of(object: &Object) -> Option<DVec3> {
    match object.shape {
        Shape::Point { position } | Shape::Spot { position, .. } => {
            Some(object.transform.matrix().transform_point3(position))
        }
        _ => None,
    }
}

/// Strokes from dark to bright, seen on any picture.
fn strokes(is_selected: bool) -> [Stroke; 2] {
    let color = if is_selected { Color32::from_rgb(0xff, 0xe3, 0x4d) } else { Color32::from_white_alpha(230) };
    [Stroke::new(3.2, Color32::from_black_alpha(130)), Stroke::new(1.4, color)]
}

/// A ring with rays.
fn paint_bulb(painter: &Painter, center: Option<Pos2>, is_selected: bool) {
    let Some(center) = center else { return };
    for stroke in strokes(is_selected) {
        painter.circle_stroke(center, RADIUS, stroke);
        for turn in 0..8_u8 {
            let way = Vec2::angled(std::f32::consts::TAU * f32::from(turn) / 8.0);
            painter.line_segment([center + way * (RADIUS + 2.5), center + way * (RADIUS + 6.0)], stroke);
        }
    }
}

/// The cone's axis up to the target, and its outer edge there.
fn paint_cone(painter: &Painter, object: &Object, screen: impl Fn(DVec3) -> Option<Pos2>) {
    let Shape::Spot { position, target, outer_angle, .. } = object.shape else { return };
    let matrix = object.transform.matrix();
    let [position, target] = [position, target].map(|place| matrix.transform_point3(place));
    let axis = target - position;
    let length = axis.length();
    let (Some(axis), Some(start)) = (axis.try_normalize(), screen(position)) else { return };
    // A wide cone is shown where it is still a cone.
    let (sin, cos) = outer_angle.min(80.0).to_radians().sin_cos();
    let (u, v) = axis.any_orthonormal_pair();
    let rim = |turn: u32| {
        let (s, c) = (std::f64::consts::TAU * f64::from(turn) / f64::from(4 * EDGES)).sin_cos();
        screen(position + (axis * cos + (u * c + v * s) * sin) * length)
    };
    for stroke in strokes(true).map(|stroke| Stroke::new(0.7 * stroke.width, stroke.color)) {
        if let Some(end) = screen(target) {
            painter.line_segment([start, end], stroke);
        }
        for turn in 0..4 * EDGES {
            if let (Some(a), Some(b)) = (rim(turn), rim(turn + 1)) {
                painter.line_segment([a, b], stroke);
            }
            if let Some(end) = rim(turn).filter(|_| turn % EDGES == 0) {
                painter.line_segment([start, end], stroke);
            }
        }
    }
}

/// Arrows side by side through the place that the camera looks at.
fn paint_directional(painter: &Painter, sight: &Sight, object: &Object, screen: impl Fn(DVec3) -> Option<Pos2>) {
    let Shape::Directional { direction, .. } = object.shape else { return };
    let Some(way) = object.transform.matrix().transform_vector3(direction).try_normalize() else { return };
    let camera = &sight.camera;
    let middle = camera.position + camera.forward * camera.focus_distance;
    let size = camera.focus_distance * camera.tan_half_fov;
    let (u, v) = way.any_orthonormal_pair();
    for (across, up) in [(0.0, 0.0), (0.22, 0.0), (-0.22, 0.0), (0.0, 0.22), (0.0, -0.22)] {
        let tip = middle + (u * across + v * up) * size;
        let (Some(from), Some(to)) = (screen(tip - way * (0.6 * size)), screen(tip)) else { continue };
        let back = (from - to).normalized() * 8.0;
        for stroke in strokes(true) {
            painter.line_segment([from, to], stroke);
            if from.distance(to) > 12.0 {
                for side in [back.rot90(), -back.rot90()] {
                    painter.line_segment([to, to + back + 0.5 * side], stroke);
                }
            }
        }
    }
}
