//! What the pointer does over the panes.

use egui::{CursorIcon, PointerButton, Pos2, Response, Ui};

use super::handles::{film_point, is_on_film};
use super::layout::{Pane, film_from_screen, film_window, zoomed};
use super::path::vertex_at;
use super::{Viewport, is_slice, lights, slice};
use crate::app::command::Command;
use crate::app::settings::Arrangement;
use crate::app::state::{MAX_ZOOM, Motion, State};

/// A divider is grabbed within this many points.
const GRAB: f32 = 7.0;
/// Points of scrolling per wheel notch.
const POINTS_PER_NOTCH: f32 = 50.0;

/// What a drag does, decided where it starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Drag {
    Orbit,
    Pan,
    /// Moves the zoomed picture.
    Picture,
    /// Moves the vertical divider, the horizontal one, or both.
    Divider(bool, bool),
    /// A handle of the selected object; [`super::handles`] knows which.
    Handle,
}

impl Viewport {
    pub(super) fn read_pointer(
        &mut self,
        ui: &Ui,
        response: &Response,
        state: &State,
        panes: &[Pane],
        commands: &mut Vec<Command>,
    ) {
        let window = film_window(state.view.zoom, state.view.zoom_center);
        let pane_at = |pos: Pos2| panes.iter().position(|pane| pane.visible.contains(pos));
        let area = response.rect;
        let (modifiers, press_origin) = ui.input(|input| (input.modifiers, input.pointer.press_origin()));

        // A slice has a plane of its own to move in; a drag stays where it began.
        let at = press_origin.filter(|_| response.is_pointer_button_down_on()).or(response.hover_pos());
        let in_slice = at.filter(|pos| divider_at(state, panes, *pos).is_none()).and_then(pane_at);
        let in_slice = in_slice.filter(|index| is_slice(state, *index)).filter(|_| !self.handles.is_held());
        if let Some(index) = in_slice.filter(|_| self.drag.is_none()) {
            self.handles.put_away();
            slice::read_pointer(ui, response, state, &panes[index], index, &mut self.slice_drag, commands);
            return;
        }
        self.slice_drag = None;

        let is_handle = self.handles.update(ui, response, state, panes, commands);
        if response.drag_started() {
            let origin = press_origin.unwrap_or(area.center());
            self.drag = Some(if response.dragged_by(PointerButton::Primary) {
                match divider_at(state, panes, origin) {
                    _ if is_handle => Drag::Handle,
                    Some((x, y)) => Drag::Divider(x, y),
                    None if modifiers.command => Drag::Picture,
                    None if modifiers.shift => Drag::Pan,
                    None => Drag::Orbit,
                }
            } else {
                Drag::Pan
            });
        }
        if response.dragged()
            && let Some(drag) = self.drag
        {
            let delta = response.drag_delta();
            let height = panes[0].picture.height();
            if delta != egui::Vec2::ZERO && drag != Drag::Handle {
                commands.push(match drag {
                    Drag::Orbit => state.navigate(Motion::Orbit(delta.into()), height),
                    Drag::Pan => state.navigate(Motion::Pan(delta.into()), height),
                    Drag::Picture => {
                        let moved = delta / panes[0].picture.size() / state.view.zoom;
                        let center = state.view.zoom_center;
                        Command::SetZoom(state.view.zoom, [center[0] - moved.x, center[1] - moved.y])
                    }
                    Drag::Divider(x, y) => {
                        let pos = response.interact_pointer_pos().unwrap_or(area.center());
                        let at = (pos - area.min) / area.size();
                        let [old_x, old_y] = state.view.divider;
                        Command::SetDivider([if x { at.x } else { old_x }, if y { at.y } else { old_y }])
                    }
                    Drag::Handle => Command::Nothing,
                });
            }
        }
        if response.drag_stopped() {
            self.drag = None;
        }

        if let Some(pos) = response.interact_pointer_pos()
            && let Some(index) = pane_at(pos)
            && (response.clicked() || response.double_clicked())
        {
            commands.push(Command::SetActivePane(index));
            let point = film_point(state, &panes[index], pos);
            let light = lights::at(state, &panes[index], pos).filter(|_| modifiers.command);
            commands.push(if let Some(light) = light {
                Command::SelectObject(Some(light.to_owned()))
            } else if !is_on_film(point) {
                Command::Nothing
            } else if modifiers.command {
                Command::SelectAt(point)
            } else if response.double_clicked() {
                Command::LookAt(point)
            } else {
                match vertex_at(state, index, &panes[index], pos) {
                    Some(vertex) => Command::SelectVertex(Some(vertex)),
                    None => Command::Inspect(Some(point)),
                }
            });
        }

        if let Some(pos) = response.hover_pos() {
            let (scroll, zoom) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            if let Some(pane) = pane_at(pos).map(|index| panes[index])
                && (zoom - 1.0).abs() > 1e-4
            {
                let fixed = film_from_screen(pane.picture, window, pos);
                let (zoom, center) = zoomed(state.view.zoom, state.view.zoom_center, zoom, fixed, MAX_ZOOM);
                commands.push(Command::SetZoom(zoom, center));
            } else if scroll != 0.0 && !self.handles.is_held() {
                commands.push(state.navigate(Motion::Dolly(scroll / POINTS_PER_NOTCH), panes[0].picture.height()));
            }
            let over = self.drag.map_or_else(
                || divider_at(state, panes, pos),
                |drag| if let Drag::Divider(x, y) = drag { Some((x, y)) } else { None },
            );
            match over {
                _ if self.handles.is_held() => ui.set_cursor_icon(CursorIcon::Grabbing),
                _ if self.drag.is_none() && self.handles.is_focused() => ui.set_cursor_icon(CursorIcon::Grab),
                Some((true, true)) => ui.set_cursor_icon(CursorIcon::Move),
                Some((true, false)) => ui.set_cursor_icon(CursorIcon::ResizeHorizontal),
                Some(_) => ui.set_cursor_icon(CursorIcon::ResizeVertical),
                None if matches!(self.drag, Some(Drag::Orbit | Drag::Pan | Drag::Picture)) => {
                    ui.set_cursor_icon(CursorIcon::Grabbing);
                }
                None => {}
            }
        }
    }
}

/// The dividers within reach of `pos`: (vertical, horizontal).
fn divider_at(state: &State, panes: &[Pane], pos: Pos2) -> Option<(bool, bool)> {
    if state.settings.arrangement == Arrangement::Tiles || panes.len() < 2 {
        return None;
    }
    let corner = panes[0].visible.right_bottom();
    let vertical = (pos.x - corner.x).abs() < GRAB;
    let horizontal = panes.len() == 4 && (pos.y - corner.y).abs() < GRAB;
    (vertical || horizontal).then_some((vertical, horizontal))
}
