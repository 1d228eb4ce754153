//! Handles on the selected object in the picture: arrows to move it, rings to rotate it, knobs to scale it.
//!
//! The handles are those of the crate `transform-gizmo`; here they are put where the film's camera sees the object, and what they report
//! becomes a [`Transform`]. The crate works in a space whose origin is the camera and whose unit is the distance of the object, so that
//! scenes of any size and place look alike to it.

use egui::{Align2, Color32, Mesh, Painter, PointerButton, Pos2, Response, Shape as Drawing, Stroke, Ui, Vec2};
use glam::{DQuat, DVec3};
use transform_gizmo::math::{Pos2 as GizmoPos, Transform as Target};
use transform_gizmo::{
    Gizmo, GizmoConfig, GizmoInteraction, GizmoMode, GizmoOrientation, GizmoResult, GizmoVisuals, enum_set, mint,
};

use super::layout::{Pane, film_from_screen, film_window, screen_from_film};
use super::sight::Sight;
use crate::app::command::Command;
use crate::app::edit::{Edit, ObjectEdit};
use crate::app::objects::{self, Manipulation};
use crate::app::state::State;
use crate::scene::camera::Camera;
use crate::scene::description::{Object, Shape, Transform};

/// Length of an arrow, in points, where the pane is large enough.
const SIZE: f32 = 78.0;
const STROKE: f32 = 3.5;
/// Steps of rotation while Ctrl is held, in degrees.
const SNAP_DEGREES: f32 = 15.0;
const SNAP_SCALE: f32 = 0.1;
/// Rounding of angles, in degrees.
const ANGLE_STEP: f64 = 1e-3;
/// x, y and z, after Okabe and Ito (2008); letters say the same.
const AXIS_COLORS: [Color32; 3] =
    [Color32::from_rgb(0xff, 0x7a, 0x3c), Color32::from_rgb(0x2f, 0xd0, 0x9c), Color32::from_rgb(0x5c, 0xb8, 0xf5)];
const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];
const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// The handles and the drag that is under way.
#[derive(Default)]
pub(super) struct Handles {
    gizmo: Gizmo,
    grip: Option<Grip>,
    /// The pane that the crate's coordinates are of; `None` while no handles are shown.
    pane: Option<usize>,
}

/// What was there when the drag began.
struct Grip {
    object: String,
    manipulation: Manipulation,
    start: Transform,
    /// In object space.
    pivot: DVec3,
    /// Scene units per unit of the crate's space.
    unit: f64,
    /// Whether the document knows of the drag yet.
    is_known: bool,
    /// What has been done so far, in words.
    done: String,
}

/// The crate's view and projection for a camera in the origin.
fn matrices(sight: &Sight) -> [mint::RowMatrix4<f64>; 2] {
    const NEAR: f64 = 1e-3;
    const FAR: f64 = 1e3;
    let row = |v: DVec3, w: f64| [v.x, v.y, v.z, w];
    let Camera { right, up, forward, tan_half_fov, .. } = sight.camera;
    let view = [row(right, 0.0), row(up, 0.0), row(-forward, 0.0), [0.0, 0.0, 0.0, 1.0]];
    let projection = [
        [1.0 / (tan_half_fov * sight.aspect), 0.0, 0.0, 0.0],
        [0.0, 1.0 / tan_half_fov, 0.0, 0.0],
        [0.0, 0.0, (NEAR + FAR) / (NEAR - FAR), 2.0 * NEAR * FAR / (NEAR - FAR)],
        [0.0, 0.0, -1.0, 0.0],
    ];
    [view, projection].map(mint::RowMatrix4::from)
}

/// 1, 2 or 5 times a power of ten, near `size`.
fn round_step(size: f64) -> f64 {
    let decade = objects::decade(size);
    let digit = match size / decade {
        d if d < 1.5 => 1.0,
        d if d < 3.5 => 2.0,
        d if d < 7.5 => 5.0,
        _ => 10.0,
    };
    digit * decade
}

impl Handles {
    /// Whether a drag of a handle is under way.
    pub(super) fn is_held(&self) -> bool {
        self.grip.is_some()
    }

    /// Nothing can be grabbed until the next update.
    pub(super) fn put_away(&mut self) {
        self.pane = None;
    }

    /// Whether the pointer is over a handle.
    pub(super) fn is_focused(&self) -> bool {
        self.pane.is_some() && self.gizmo.is_focused()
    }

    /// Brings the handles to where the object is and reads the pointer. Returns whether a drag that starts now is theirs.
    pub(super) fn update(
        &mut self,
        ui: &Ui,
        response: &Response,
        state: &State,
        panes: &[Pane],
        commands: &mut Vec<Command>,
    ) -> bool {
        if self.grip.as_ref().is_some_and(|grip| grip.is_known && !state.document.has_gesture()) {
            // Given up with Escape, or another scene has been opened.
            self.grip = None;
            self.gizmo = Gizmo::default();
        }
        if let Some(grip) = &mut self.grip {
            grip.is_known = true;
        }
        let held = self.grip.as_ref().map(|grip| grip.manipulation);
        let wanted = held.or(state.settings.handles);
        let (Some(object), Some(sight), Some(wanted)) = (state.selected_object(), Sight::of(state), wanted) else {
            self.pane = None;
            return false;
        };
        let manipulation = possible(wanted, &object.shape);
        let pivot = objects::pivot(&object.shape);
        let place = place_of(object, &sight);
        if sight.film(place).is_none() && held.is_none() {
            self.pane = None;
            return false;
        }
        let pointer = response.interact_pointer_pos().or(response.hover_pos());
        let press = ui.input(|input| input.pointer.press_origin());
        let index = match (held, self.pane) {
            (Some(_), Some(pane)) => pane.min(panes.len() - 1),
            _ => pointer.and_then(|pos| panes.iter().position(|pane| pane.visible.contains(pos))).unwrap_or(0),
        };
        self.pane = Some(index);
        let unit = self.grip.as_ref().map_or_else(|| place.distance(sight.camera.position), |grip| grip.unit);
        let config = config(ui, state, &sight, &panes[index], manipulation, &object.shape, unit);
        self.gizmo.update_config(config);
        let target = target(object, (place - sight.camera.position) / unit);

        let starts = held.is_none() && response.drag_started_by(PointerButton::Primary);
        if starts && let Some(press) = press {
            // The handle under the place where the button went down, from which the pointer has moved away since.
            if self.gizmo.update(interaction(press, true, true, true), &[target]).is_none() && !self.gizmo.is_focused()
            {
                return false;
            }
            commands.push(Command::BeginDrag);
            self.grip = Some(Grip {
                object: object.name.clone(),
                manipulation,
                start: object.transform,
                pivot,
                unit,
                is_known: false,
                done: String::new(),
            });
        }
        let Some(grip) = &mut self.grip else {
            let is_over = response.hovered() && pointer.is_some() && !response.dragged();
            self.gizmo.update(interaction(pointer.unwrap_or_default(), is_over, false, false), &[target]);
            return false;
        };
        if response.drag_stopped() || !(response.dragged() || starts) {
            self.gizmo.update(interaction(pointer.unwrap_or_default(), false, false, false), &[target]);
            commands.push(Command::EndDrag);
            self.grip = None;
        } else if let Some(pos) = pointer
            && let Some((result, _)) = self.gizmo.update(interaction(pos, true, false, true), &[target])
        {
            let transform = grip.transform(result);
            commands.push(Command::Drag(Edit::Object(
                grip.object.clone(),
                ObjectEdit::Transform(grip.manipulation, transform),
            )));
        }
        starts
    }

    /// Paints the selected object's box and its handles over a pane.
    pub(super) fn paint(&self, painter: &Painter, state: &State, panes: &[Pane], index: usize) {
        let (Some(object), Some(sight)) = (state.selected_object(), Sight::of(state)) else { return };
        let window = film_window(state.view.zoom, state.view.zoom_center);
        let screen = |place: DVec3| Some(screen_from_film(panes[index].picture, window, sight.film(place)?));
        if object.shape.has_surface() {
            paint_box(painter, object, screen);
        }
        let Some(pane) = self.pane.filter(|pane| *pane < panes.len()) else { return };
        // All panes have one size and one camera: the handles are the same but for their place.
        let offset = panes[index].picture.min - panes[pane].picture.min;
        let drawn = self.gizmo.draw();
        let vertices = (drawn.vertices.iter().zip(&drawn.colors))
            .map(|(&[x, y], &[r, g, b, a])| egui::epaint::Vertex {
                pos: egui::pos2(x, y) + offset,
                uv: egui::epaint::WHITE_UV,
                color: egui::Rgba::from_rgba_premultiplied(r, g, b, a).into(),
            })
            .collect();
        let mesh = Mesh { indices: drawn.indices, vertices, ..Mesh::default() };
        // A dark edge around everything, so that it is seen on bright pictures too.
        for (dx, dy) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let mut shadow = mesh.clone();
            for vertex in &mut shadow.vertices {
                vertex.pos += Vec2::new(dx, dy);
                vertex.color = Color32::from_black_alpha((f32::from(vertex.color.a()) * 0.45) as u8);
            }
            painter.add(Drawing::mesh(shadow));
        }
        painter.add(Drawing::mesh(mesh));
        self.paint_letters(painter, object, &sight, screen);
        if let Some(grip) = self.grip.as_ref().filter(|grip| !grip.done.is_empty() && index == pane)
            && let Some(at) = screen(place_of(object, &sight))
        {
            super::overlay::paint_note(painter, at + Vec2::new(0.0, SIZE + 22.0), &grip.done);
        }
    }

    /// Names of the axes beyond the tips of arrows and knobs.
    fn paint_letters(&self, painter: &Painter, object: &Object, sight: &Sight, screen: impl Fn(DVec3) -> Option<Pos2>) {
        let config = self.gizmo.config();
        let has_axes = [GizmoMode::TranslateX, GizmoMode::ScaleX].into_iter().any(|mode| config.modes.contains(mode));
        if self.grip.is_some() || !has_axes {
            return;
        }
        let place = place_of(object, sight);
        let depth = (place - sight.camera.position).dot(sight.camera.forward);
        let per_point = 2.0 * depth * sight.camera.tan_half_fov / f64::from(config.viewport.height());
        let axes = match config.orientation {
            GizmoOrientation::Local => {
                let rotation = objects::rotation_of(&object.transform);
                AXES.map(|axis| rotation * axis)
            }
            GizmoOrientation::Global => AXES,
        };
        let length = per_point * f64::from(config.visuals.gizmo_size + 10.0);
        for ((axis, name), color) in axes.into_iter().zip(AXIS_NAMES).zip(AXIS_COLORS) {
            let (Some(center), Some(at)) = (screen(place), screen(place + axis * length)) else { continue };
            // An axis that points at the camera has no arrow.
            if center.distance(at) > 0.35 * SIZE.min(config.visuals.gizmo_size) {
                let font = egui::FontId::proportional(12.0);
                for shift in [Vec2::new(1.0, 1.0), Vec2::new(-1.0, -1.0)] {
                    painter.text(at + shift, Align2::CENTER_CENTER, name, font.clone(), Color32::from_black_alpha(150));
                }
                painter.text(at, Align2::CENTER_CENTER, name, font, color);
            }
        }
    }
}

/// What can be done to an object of that shape: a light at a point has no size, and one from afar no place.
fn possible(wanted: Manipulation, shape: &Shape) -> Manipulation {
    match (shape, wanted) {
        (Shape::Point { .. }, _) | (Shape::Spot { .. }, Manipulation::Scale) => Manipulation::Move,
        (Shape::Directional { .. }, _) => Manipulation::Rotate,
        _ => wanted,
    }
}

/// Where the handles are: in the middle of the object, or for a light from afar where the camera looks.
fn place_of(object: &Object, sight: &Sight) -> DVec3 {
    if let Shape::Directional { .. } = object.shape {
        return sight.camera.position + sight.camera.forward * sight.camera.focus_distance;
    }
    object.transform.matrix().transform_point3(objects::pivot(&object.shape))
}

fn interaction(pos: Pos2, hovered: bool, drag_started: bool, dragging: bool) -> GizmoInteraction {
    GizmoInteraction { cursor_pos: (pos.x, pos.y), hovered, drag_started, dragging }
}

/// The object in the crate's space.
fn target(object: &Object, place: DVec3) -> Target {
    let rotation = DQuat::from_mat3(&objects::rotation_of(&object.transform));
    Target {
        scale: mint::Vector3 { x: 1.0, y: 1.0, z: 1.0 },
        rotation: mint::Quaternion { v: mint::Vector3 { x: rotation.x, y: rotation.y, z: rotation.z }, s: rotation.w },
        translation: mint::Vector3 { x: place.x, y: place.y, z: place.z },
    }
}

fn vector(v: mint::Vector3<f64>) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}

impl Grip {
    /// The transform that a drag has led to, counted from its start, so that no errors add up.
    fn transform(&mut self, result: GizmoResult) -> Transform {
        match result {
            GizmoResult::Translation { total, .. } => {
                let step = objects::decade(1e-3 * self.unit) / 10.0;
                let total = (vector(total) * self.unit).map(|x| objects::rounded(x, step));
                self.done = AXIS_NAMES
                    .into_iter()
                    .zip(total.to_array())
                    .filter(|(_, x)| *x != 0.0)
                    .map(|(name, x)| format!("{name} {x:+}"))
                    .collect::<Vec<_>>()
                    .join("  ");
                // What does not move keeps every digit.
                let moved = |start: f64, by: f64| if by == 0.0 { start } else { objects::rounded(start + by, step) };
                let DVec3 { x, y, z } = self.start.translate;
                let translate = DVec3::new(moved(x, total.x), moved(y, total.y), moved(z, total.z));
                Transform { translate, ..self.start }
            }
            GizmoResult::Rotation { axis, total, is_view_axis, .. } => {
                let axis = vector(axis).normalize_or(DVec3::Y);
                // The crate counts the pointer's angle on the screen, where y goes down.
                let angle = -total;
                let name = AXES.iter().position(|a| *a == axis).filter(|_| !is_view_axis).map(|i| AXIS_NAMES[i]);
                let about = name.map_or_else(String::new, |name| format!(" about {name}"));
                self.done = format!("{:.1}°{about}", angle.to_degrees());
                objects::rotated_by(&self.start, DQuat::from_axis_angle(axis, angle), self.pivot, ANGLE_STEP)
            }
            GizmoResult::Scale { total } => {
                let total = vector(total);
                let step = |s: f64| objects::rounded(s, objects::decade(s) * 1e-3);
                let DVec3 { x, y, z } = total.map(step);
                self.done = if x == y && y == z { format!("× {x}") } else { format!("× {x}, {y}, {z}") };
                let keep = |start: f64, by: f64| if by == 1.0 { start } else { step(start * by) };
                let start = self.start.scale;
                let scale = DVec3::new(keep(start.x, x), keep(start.y, y), keep(start.z, z));
                objects::scaled_to(&self.start, scale, self.pivot)
            }
            // Not among the modes.
            GizmoResult::Arcball { .. } => self.start,
        }
    }
}

/// Everything that decides where the handles are and what they do.
fn config(
    ui: &Ui,
    state: &State,
    sight: &Sight,
    pane: &Pane,
    manipulation: Manipulation,
    shape: &Shape,
    unit: f64,
) -> GizmoConfig {
    let [view_matrix, projection_matrix] = matrices(sight);
    let window = film_window(state.view.zoom, state.view.zoom_center);
    // Where the whole film would be on the screen if the pane did not cut it off.
    let [min, max] = [Pos2::ZERO, egui::pos2(1.0, 1.0)]
        .map(|corner| screen_from_film(pane.picture, window, corner))
        .map(|pos| GizmoPos::new(pos.x, pos.y));
    let viewport = transform_gizmo::Rect::from_min_max(min, max);
    let room = pane.visible.width().min(pane.visible.height());
    // A step is about a fortieth of what the picture shows at the object's distance.
    let seen = 2.0 * unit * sight.camera.tan_half_fov / f64::from(state.view.zoom);
    let [x_color, y_color, z_color] = AXIS_COLORS.map(|c| transform_gizmo::Color32::from_rgb(c.r(), c.g(), c.b()));
    GizmoConfig {
        view_matrix,
        projection_matrix,
        viewport,
        modes: match manipulation {
            Manipulation::Move => GizmoMode::all_translate(),
            Manipulation::Rotate => GizmoMode::all_rotate(),
            // An analytic sphere has one handle for its scale.
            Manipulation::Scale if matches!(shape, Shape::Sphere { .. }) => enum_set!(GizmoMode::ScaleUniform),
            Manipulation::Scale => GizmoMode::all_scale(),
        },
        mode_override: None,
        // A scale comes before the rotation, and so goes along the object's own axes.
        orientation: match manipulation {
            Manipulation::Scale => GizmoOrientation::Local,
            _ => GizmoOrientation::Global,
        },
        snapping: ui.input(|input| input.modifiers.command),
        snap_angle: SNAP_DEGREES.to_radians(),
        snap_distance: (round_step(seen / 40.0) / unit) as f32,
        snap_scale: SNAP_SCALE,
        visuals: GizmoVisuals {
            x_color,
            y_color,
            z_color,
            s_color: transform_gizmo::Color32::from_rgb(0xf0, 0xf1, 0xf3),
            inactive_alpha: 0.85,
            highlight_alpha: 1.0,
            highlight_color: Some(transform_gizmo::Color32::from_rgb(0xff, 0xe3, 0x4d)),
            stroke_width: STROKE,
            gizmo_size: SIZE.min(0.24 * room),
        },
        pixels_per_point: ui.ctx().pixels_per_point(),
        ..GizmoConfig::default()
    }
}

/// The corners of an object's box in its own axes.
fn paint_box(painter: &Painter, object: &Object, screen: impl Fn(DVec3) -> Option<Pos2>) {
    /// Share of each edge that is drawn at either end.
    const PART: f64 = 0.18;
    let (min, max) = objects::bounds(&object.shape);
    let matrix = object.transform.matrix();
    let corner = |bits: usize| {
        let pick = |axis: usize| if bits & (1 << axis) == 0 { min[axis] } else { max[axis] };
        matrix.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    };
    for from in 0..8_usize {
        for axis in 0..3 {
            let (a, b) = (corner(from), corner(from ^ (1 << axis)));
            if let (Some(start), Some(end)) = (screen(a), screen(a.lerp(b, PART))) {
                for (width, color) in [(3.0, Color32::from_black_alpha(110)), (1.2, Color32::from_white_alpha(230))] {
                    painter.line_segment([start, end], Stroke::new(width, color));
                }
            }
        }
    }
}

/// The film's point under a point of the screen, for commands.
pub(super) fn film_point(state: &State, pane: &Pane, pos: Pos2) -> [f64; 2] {
    let window = film_window(state.view.zoom, state.view.zoom_center);
    let point = film_from_screen(pane.picture, window, pos);
    [f64::from(point.x), f64::from(point.y)]
}

/// Whether a point of [`film_point`] is on the film, and not beside a picture that does not fill its pane.
pub(super) fn is_on_film(point: [f64; 2]) -> bool {
    point.iter().all(|x| (0.0..=1.0).contains(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        assert_eq!([0.09, 0.11, 0.19, 0.4, 0.8].map(round_step).map(|s| (s * 1e6).round()), [1e5, 1e5, 2e5, 5e5, 1e6]);
    }
}
