//! The buttons in the picture that choose what can be dragged on the selected object.

use egui::{Color32, Painter, Pos2, Rect, Sense, Stroke, Ui, Vec2, pos2, vec2};

use super::layout::Pane;
use crate::app::command::Command;
use crate::app::keys;
use crate::app::objects::Manipulation;
use crate::app::state::State;
use crate::app::theme::Palette;
use crate::app::theme::over_pictures::GROUND;
use crate::app::widgets::focus_ring;

const SIDE: f32 = 26.0;
const MARGIN: f32 = 8.0;
/// Room above for a pane's label and what hangs below it.
const ABOVE: f32 = 100.0;

/// A column of buttons at the left of the first pane, while an object is selected and there is room. Returns where they are.
pub(super) fn show(ui: &mut Ui, state: &State, pane: &Pane, commands: &mut Vec<Command>) -> Option<Rect> {
    let room = pane.visible;
    let size = vec2(SIDE, SIDE * Manipulation::ALL.len() as f32) + Vec2::splat(4.0);
    if state.selected_object().is_none() || room.width() < 160.0 || room.height() < ABOVE + size.y + MARGIN {
        return None;
    }
    let top = (room.center().y - size.y / 2.0).max(room.top() + ABOVE);
    let frame = Rect::from_min_size(pos2(room.left() + MARGIN, top), size);
    ui.painter().rect_filled(frame, 5.0, GROUND);
    for (index, manipulation) in Manipulation::ALL.into_iter().enumerate() {
        let min = frame.min + vec2(2.0, 2.0 + index as f32 * SIDE);
        let rect = Rect::from_min_size(min, Vec2::splat(SIDE));
        let response = ui.allocate_rect(rect, Sense::click());
        let is_on = state.settings.handles == Some(manipulation);
        let name = manipulation.name();
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::Button, true, is_on, format!("{name} in the picture"))
        });
        let what = match manipulation {
            Manipulation::Move => "Arrows, squares and a ring to move it",
            Manipulation::Rotate => "Rings to rotate it about its middle",
            Manipulation::Scale => "Knobs to scale it along its own axes; spheres have a ring for all axes",
        };
        let keys = keys::text(&keys::of(manipulation), ui.ctx().os().is_mac());
        let response = response.on_hover_text(format!(
            "{name} ({keys}): {what}.\nCtrl: in steps. Esc: give a drag up. Click again: no handles."
        ));
        let palette = Palette { is_dark: true, ..Palette::of(ui) };
        let color = if is_on { Color32::WHITE } else { Color32::from_rgb(0xb4, 0xb9, 0xc0) };
        if is_on || response.hovered() {
            let fill = if is_on { palette.accent.gamma_multiply(0.55) } else { Color32::from_white_alpha(26) };
            ui.painter().rect_filled(rect.shrink(1.0), 4.0, fill);
        }
        paint_icon(ui.painter(), manipulation, rect.center(), color);
        focus_ring(ui, &response);
        if response.clicked() {
            commands.push(Command::SetHandles((!is_on).then_some(manipulation)));
        }
    }
    Some(frame)
}

fn paint_icon(painter: &Painter, manipulation: Manipulation, center: Pos2, color: Color32) {
    let stroke = Stroke::new(1.5, color);
    let tip = |at: Pos2, direction: Vec2| {
        let side = direction.rot90();
        for way in [1.0, -1.0] {
            painter.line_segment([at, at - direction * 3.0 + side * 3.0 * way], stroke);
        }
    };
    match manipulation {
        Manipulation::Move => {
            for direction in [Vec2::X, -Vec2::X, Vec2::Y, -Vec2::Y] {
                let end = center + direction * 8.0;
                painter.line_segment([center, end], stroke);
                tip(end, direction);
            }
        }
        Manipulation::Rotate => {
            let point = |turn: f32| center + Vec2::angled(turn * std::f32::consts::TAU) * 7.0;
            let arc: Vec<Pos2> = (0..=24).map(|i| point(-0.12 + 0.78 * i as f32 / 24.0)).collect();
            let (last, before) = (arc[24], arc[22]);
            painter.add(egui::Shape::line(arc, stroke));
            tip(last, (last - before).normalized());
        }
        Manipulation::Scale => {
            let small = Rect::from_min_max(center + vec2(-8.0, 1.0), center + vec2(-1.0, 8.0));
            painter.rect_stroke(small, 1.0, stroke, egui::StrokeKind::Inside);
            let end = center + vec2(8.0, -8.0);
            painter.line_segment([center + vec2(1.0, -1.0), end], stroke);
            painter.line_segment([end, end + vec2(-5.0, 0.0)], stroke);
            painter.line_segment([end, end + vec2(0.0, 5.0)], stroke);
        }
    }
}
