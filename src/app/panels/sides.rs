//! The side panels: both beside the pictures where there is room; otherwise one at a time, and at either side a rail with a button for
//! each of them.

use egui::{Area, Frame, Id, Margin, Order, Panel, Rect, Response, Sense, Ui, Vec2, pos2, vec2};

use super::tour::{self, Part};
use super::{scene_tree, tabs_ui};
use crate::app::command::Command;
use crate::app::settings::SidePanel;
use crate::app::state::{Room, State};
use crate::app::theme::{self, Palette, RENDER_PANEL_WIDTH, SCENE_PANEL_WIDTH};
use crate::app::viewport::Viewport;
use crate::app::widgets::focus_ring;

/// Least width of the pictures beside both panels, and beside one of them and the rails, in points.
const LEAST_BESIDE_BOTH: f32 = 320.0;
const LEAST_BESIDE_ONE: f32 = 280.0;
const RAIL_WIDTH: f32 = 26.0;
/// Least width of a panel.
const LEAST_PANEL: f32 = 220.0;
/// Most height of a rail's button.
const BUTTON_HEIGHT: f32 = 84.0;

/// What room a window of so many points' width has.
fn room_of(width: f32) -> Room {
    let widest = SCENE_PANEL_WIDTH.max(RENDER_PANEL_WIDTH);
    match width {
        w if w > SCENE_PANEL_WIDTH + RENDER_PANEL_WIDTH + LEAST_BESIDE_BOTH => Room::Both,
        w if w >= widest + 2.0 * RAIL_WIDTH + LEAST_BESIDE_ONE => Room::One,
        _ => Room::Over,
    }
}

/// Shows the panels that stand beside the pictures. Those that lie over them come later, with [`drawer`].
pub fn show(ui: &mut Ui, state: &mut State, viewport: &Viewport, commands: &mut Vec<Command>) {
    let width = ui.available_width();
    state.set_room(room_of(width));
    let room = state.room();
    if room != Room::Both {
        rails_ui(ui, state, commands);
    }
    if room == Room::Over {
        return;
    }
    let most = match room {
        Room::Both => width * 0.4,
        Room::One | Room::Over => ui.available_width() - LEAST_BESIDE_ONE,
    };
    let sizes = LEAST_PANEL..=most.max(LEAST_PANEL + 1.0);
    if state.has_panel(SidePanel::Scene) {
        let panel = Panel::left("scene").frame(frame(ui)).default_size(SCENE_PANEL_WIDTH).size_range(sizes.clone());
        let shown = panel.show(ui, |ui| scene_tree::show(ui, state, commands));
        tour::mark(ui.ctx(), Part::ScenePanel, shown.response.rect);
    }
    if state.has_panel(SidePanel::Render) {
        let panel = Panel::right("render").frame(frame(ui)).default_size(RENDER_PANEL_WIDTH).size_range(sizes);
        let shown = panel.show(ui, |ui| tabs_ui(ui, state, viewport, commands));
        tour::mark(ui.ctx(), Part::RenderPanel, shown.response.rect);
    }
}

fn frame(ui: &Ui) -> Frame {
    Frame::new().fill(ui.visuals().panel_fill).inner_margin(Margin { left: 10, right: 6, top: 8, bottom: 8 })
}

/// The panel that lies over the pictures, which take all of `pictures`.
pub fn drawer(ui: &Ui, pictures: Rect, state: &State, viewport: &Viewport, commands: &mut Vec<Command>) {
    if state.room() != Room::Over {
        return;
    }
    for (panel, width) in [(SidePanel::Scene, SCENE_PANEL_WIDTH), (SidePanel::Render, RENDER_PANEL_WIDTH)] {
        if !state.has_panel(panel) {
            continue;
        }
        // A strip of the pictures stays in sight.
        let size = vec2(width.min(pictures.width() - 24.0).max(LEAST_PANEL), pictures.height());
        let corner = match panel {
            SidePanel::Scene => pictures.left_top(),
            SidePanel::Render => pos2(pictures.right() - size.x, pictures.top()),
        };
        let area = Area::new(Id::unique("drawer")).order(Order::Middle).fixed_pos(corner).constrain(false);
        area.show(ui.ctx(), |ui| {
            let frame = frame(ui).shadow(ui.visuals().window_shadow);
            frame.show(ui, |ui| {
                let inner = size - vec2(16.0, 16.0);
                ui.set_min_size(inner);
                ui.set_max_size(inner);
                match panel {
                    SidePanel::Scene => scene_tree::show(ui, state, commands),
                    SidePanel::Render => tabs_ui(ui, state, viewport, commands),
                }
            });
        });
    }
}

fn rails_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let rail = Frame::new().fill(ui.visuals().faint_bg_color).inner_margin(Margin::same(2));
    let exact = |panel: Panel| panel.frame(rail).exact_size(RAIL_WIDTH).resizable(false);
    exact(Panel::left("scene rail")).show(ui, |ui| {
        let is_shown = state.has_panel(SidePanel::Scene);
        if rail_button_ui(ui, 1, "Scene", is_shown, false).on_hover_text("The scene and its media (F1).").clicked() {
            commands.push(Command::ToggleScenePanel);
        }
    });
    exact(Panel::right("render rail")).show(ui, |ui| {
        for (tab, name, about) in super::TABS {
            let is_shown = state.has_panel(SidePanel::Render) && state.settings.tab == tab;
            if rail_button_ui(ui, super::TABS.len(), name, is_shown, true).on_hover_text(about).clicked() {
                commands.push(if is_shown { Command::ToggleRenderPanel } else { Command::ShowTab(tab) });
            }
        }
    });
}

/// One of `count` buttons, with its name along the rail: read upwards at the left, downwards at the right.
fn rail_button_ui(ui: &mut Ui, count: usize, name: &str, is_on: bool, reads_down: bool) -> Response {
    let gap = ui.spacing().item_spacing.y;
    let most = (ui.max_rect().height() - gap * (count as f32 - 1.0)) / count as f32;
    let size = vec2(ui.available_width(), most.min(BUTTON_HEIGHT));
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let label = format!("{name} panel");
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, is_on, &label));
    let visuals = if is_on { &ui.visuals().widgets.open } else { ui.style().interact(&response) };
    if is_on || response.hovered() {
        ui.painter().rect_filled(rect, 4.0, visuals.weak_bg_fill);
    }
    if is_on {
        let x = if reads_down { rect.right() - 2.0 } else { rect.left() };
        let bar = Rect::from_min_size(pos2(x, rect.top()), Vec2::new(2.0, rect.height()));
        ui.painter().rect_filled(bar, 1.0, Palette::of(ui).accent);
    }
    let font = theme::section_style().resolve(ui.style());
    let galley = ui.painter().layout_no_wrap(name.to_owned(), font, visuals.text_color());
    let turn = if reads_down { std::f32::consts::FRAC_PI_2 } else { -std::f32::consts::FRAC_PI_2 };
    // The text turns around its upper left corner.
    let half = galley.size() / 2.0;
    let to_corner = if reads_down { vec2(half.y, -half.x) } else { vec2(-half.y, half.x) };
    let shape = egui::epaint::TextShape::new(rect.center() + to_corner, galley, visuals.text_color()).with_angle(turn);
    ui.painter().add(shape);
    focus_ring(ui, &response);
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pictures_keep_their_least_width() {
        for width in 300..2000 {
            let width = width as f32;
            let left = match room_of(width) {
                Room::Both => width - SCENE_PANEL_WIDTH - RENDER_PANEL_WIDTH,
                Room::One => width - SCENE_PANEL_WIDTH - 2.0 * RAIL_WIDTH,
                Room::Over => continue,
            };
            assert!(left >= LEAST_BESIDE_ONE, "{width}");
        }
        let rooms = [1280.0, 800.0, 640.0, 500.0].map(room_of);
        assert_eq!(rooms, [Room::Both, Room::One, Room::One, Room::Over]);
    }
}
