//! The panes for the keyboard and for screen readers: each can have the focus, says what it shows, and is turned by the arrow keys.

use egui::{Color32, EventFilter, Key, Modifiers, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo};

use super::layout::Pane;
use super::{is_slice, slice};
use crate::app::command::Command;
use crate::app::develop::About;
use crate::app::keys::pane_id;
use crate::app::state::{Motion, State};
use crate::app::theme::Palette;

/// What a press of an arrow key amounts to, as a share of the picture's height that is dragged: 5 degrees of an orbit.
const DRAG: f32 = 1.0 / 36.0;
/// What a press of an arrow key moves the inspected point by, as a share of the picture.
const STEP: f64 = 1.0 / 200.0;

/// What pane `index` shows, in words.
fn name(state: &State, about: &About, index: usize) -> String {
    let source = &about.source;
    let content = state.settings.panes[index];
    let how_far = match source.samples() {
        0 => "not rendered yet".to_owned(),
        _ if source.is_preview() => "preview".to_owned(),
        _ if source.painted.is_some() || source.slice.is_some() => {
            return format!("Picture of pane {}: {content}", index + 1);
        }
        1 => "1 sample per pixel".to_owned(),
        samples => format!("{samples} samples per pixel"),
    };
    format!("Picture of pane {}: {content}, {how_far}", index + 1)
}

/// Lets the pane have the focus, and reads its keys. `has_ring`: whether the focus is shown.
pub(super) fn pane_ui(
    ui: &Ui,
    state: &State,
    about: &About,
    index: usize,
    pane: &Pane,
    has_ring: bool,
    commands: &mut Vec<Command>,
) {
    let id = pane_id(index);
    let response = ui.interact(pane.visible, id, Sense::FOCUSABLE);
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name(state, about, index)));
    if response.gained_focus() {
        commands.push(Command::SetActivePane(index));
    }
    if !response.has_focus() {
        return;
    }
    // Escape puts away what it would without the focus.
    let filter = EventFilter { tab: false, horizontal_arrows: true, vertical_arrows: true, escape: true };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(id, filter));
    if is_slice(state, index) {
        slice::read_keys(ui, state, pane, commands);
    } else {
        read_keys(ui, state, pane, commands);
    }
    if !has_ring {
        return;
    }
    let ring = pane.visible.shrink(1.0);
    ui.painter().rect_stroke(ring, 0.0, Stroke::new(4.0, Color32::from_black_alpha(170)), StrokeKind::Inside);
    ui.painter().rect_stroke(ring.shrink(1.0), 0.0, Stroke::new(2.0, Palette::of(ui).accent), StrokeKind::Inside);
}

fn read_keys(ui: &Ui, state: &State, pane: &Pane, commands: &mut Vec<Command>) {
    let height = pane.picture.height();
    let arrows = [
        (Key::ArrowLeft, [-1.0_f32, 0.0]),
        (Key::ArrowRight, [1.0, 0.0]),
        (Key::ArrowUp, [0.0, -1.0]),
        (Key::ArrowDown, [0.0, 1.0]),
    ];
    let total = |modifiers: Modifiers| {
        let mut sum = [0.0_f32; 2];
        for (key, direction) in arrows {
            let count = ui.input_mut(|input| input.count_and_consume_key(modifiers, key)) as f32;
            sum = [sum[0] + count * direction[0], sum[1] + count * direction[1]];
        }
        (sum != [0.0; 2]).then_some(sum)
    };
    // Those with modifiers first: a key without takes any.
    if let Some([x, y]) = total(Modifiers::COMMAND) {
        let [px, py] = state.inspection.as_ref().map_or([0.5; 2], |inspection| inspection.point);
        let point = [px + STEP * f64::from(x), py + STEP * f64::from(y)].map(|x| x.clamp(0.0, 1.0 - 1e-9));
        commands.push(Command::Inspect(Some(point)));
    }
    if let Some(sum) = total(Modifiers::SHIFT) {
        commands.push(state.navigate(Motion::Pan(sum.map(|x| x * DRAG * height)), height));
    }
    if let Some(sum) = total(Modifiers::NONE) {
        commands.push(state.navigate(Motion::Orbit(sum.map(|x| x * DRAG * height)), height));
    }
    let count = |key| ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key)) as f32;
    let steps = count(Key::Plus) + count(Key::Equals) - count(Key::Minus);
    if steps != 0.0 {
        commands.push(state.navigate(Motion::Dolly(steps), height));
    }
    if count(Key::Enter) > 0.0 && state.inspection.is_none() {
        commands.push(Command::Inspect(Some([0.5; 2])));
    }
}
