//! Refractors by priority, to be dragged: where volumes overlap, the higher one is there.

use egui::{CollapsingHeader, Key, Modifiers, Rect, Sense, Stroke, Ui, vec2};

use super::medium;
use crate::app::command::Command;
use crate::app::edit::priorities::{Level, Place, levels, moved, stepped};
use crate::app::state::State;
use crate::app::theme::Palette;
use crate::app::widgets::{note, swatch_ui, value};

/// Share of a row's height, at its top and at its bottom, where a drop goes between rows.
const BETWEEN: f32 = 0.3;

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let levels = levels(state.document.description());
    if levels.is_empty() {
        return;
    }
    CollapsingHeader::new("Priorities").id_salt("priorities").show(ui, |ui| {
        let text = "Where volumes overlap, the higher one is there. Drag a row, or press Alt + arrow on it.";
        ui.add(egui::Label::new(note(ui, text)).wrap());
        for (index, level) in levels.iter().enumerate() {
            for (row, name) in level.names.iter().enumerate() {
                row_ui(ui, state, &levels, index, level, row, name, commands);
            }
        }
    });
}

#[expect(clippy::too_many_arguments, reason = "one row of a list in a list")]
fn row_ui(
    ui: &mut Ui,
    state: &State,
    levels: &[Level],
    index: usize,
    level: &Level,
    row: usize,
    name: &str,
    commands: &mut Vec<Command>,
) {
    let palette = Palette::of(ui);
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    let rect = ui.allocate_exact_size(size, Sense::hover()).0;
    // The focus goes with the row.
    let response = ui.interact(rect, egui::Id::unique(("priority", name)), Sense::click_and_drag());
    let label = format!("Priority {} of {name}", level.priority);
    let is_selected = state.selected.as_deref() == Some(name);
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::ListItem, true, is_selected, &label));
    response.dnd_set_drag_payload(name.to_owned());
    if response.hovered() || response.has_focus() || is_selected {
        ui.painter().rect_filled(rect, 4.0, ui.visuals().widgets.inactive.weak_bg_fill.gamma_multiply(0.6));
    }
    if response.has_focus() {
        ui.painter().rect_stroke(rect, 4.0, Stroke::new(1.0, palette.accent), egui::StrokeKind::Inside);
    }
    // A line above the first of each level tells levels apart.
    if row == 0 && index > 0 {
        ui.painter().hline(rect.x_range(), rect.top() - 1.0, Stroke::new(1.0, palette.line));
    }
    contents_ui(ui, state, rect, level, row, name);
    if response.clicked() {
        response.request_focus();
        commands.push(Command::SelectObject(Some(name.to_owned())));
    }
    if response.has_focus() {
        // The arrows move the row and not the focus.
        let filter = egui::EventFilter { vertical_arrows: true, ..Default::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
        let step = ui.input_mut(|input| {
            i32::from(input.consume_key(Modifiers::ALT, Key::ArrowUp))
                - i32::from(input.consume_key(Modifiers::ALT, Key::ArrowDown))
        });
        if step != 0 {
            commands.extend(stepped(levels, name, step).map(Command::Edit));
        }
    }
    let about = "Drag it above or below another, or onto it for the same priority.";
    let response = response.on_hover_text(about);
    // Where it would be dropped.
    let Some(pointer) = ui.input(|input| input.pointer.interact_pos()).filter(|pointer| rect.contains(*pointer)) else {
        return;
    };
    if response.dnd_hover_payload::<String>().is_some_and(|dragged| *dragged != name) {
        let share = (pointer.y - rect.top()) / rect.height();
        let is_first = row == 0;
        let is_last = row + 1 == level.names.len();
        let place = match share {
            share if share < BETWEEN && is_first => Place::Above(index),
            share if share > 1.0 - BETWEEN && is_last => Place::Below(index),
            _ => Place::At(index),
        };
        let stroke = Stroke::new(2.0, palette.accent);
        match place {
            Place::Above(_) => _ = ui.painter().hline(rect.x_range(), rect.top(), stroke),
            Place::Below(_) => _ = ui.painter().hline(rect.x_range(), rect.bottom(), stroke),
            Place::At(_) => _ = ui.painter().rect_stroke(rect, 4.0, stroke, egui::StrokeKind::Inside),
        }
        if let Some(dragged) = response.dnd_release_payload::<String>() {
            commands.extend(moved(levels, &dragged, place).map(Command::Edit));
        }
    }
}

fn contents_ui(ui: &mut Ui, state: &State, rect: Rect, level: &Level, row: usize, name: &str) {
    let description = state.document.description();
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    let mut contents = ui.new_child(egui::UiBuilder::new().max_rect(rect.shrink2(vec2(4.0, 0.0))).layout(layout));
    let number = if row == 0 { level.priority.to_string() } else { "=".to_owned() };
    contents.add_sized([30.0, rect.height()], egui::Label::new(value(number)).selectable(false));
    let medium_name = description.objects.find(name).and_then(|object| object.refractor()).map_or("", |r| &*r.medium);
    let color = medium::color(&Palette::of(&contents), description, medium_name);
    swatch_ui(&mut contents, color);
    contents.add(egui::Label::new(name).truncate().selectable(false).sense(Sense::empty()));
}
