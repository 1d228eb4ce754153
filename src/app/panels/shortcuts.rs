//! The list of keys and of what the pointer does.

use egui::{Align, Context, Label, Layout, RichText, TextStyle, Ui, vec2};

use crate::app::command::Command;
use crate::app::keys::{self, GROUPS, IN_PICTURE, POINTER};
use crate::app::modal;
use crate::app::state::State;
use crate::app::theme;
use crate::app::widgets::{section_first_ui, section_ui};

/// Width of the list in one column and in two, in points.
const WIDTHS: [f32; 2] = [360.0, 720.0];
/// Groups of keys in the left one of two columns, below the pointer.
const LEFT: usize = 2;

pub fn show(ctx: &Context, state: &State, commands: &mut Vec<Command>) {
    let has_two = ctx.content_rect().width() > WIDTHS[1] + 60.0;
    let width = WIDTHS[usize::from(has_two)];
    let answer = modal::titled(ctx, "Keyboard and mouse", state.windows.shortcuts, width, |ui, _| {
        if has_two {
            ui.spacing_mut().item_spacing.x = 24.0;
            ui.columns(2, |columns| {
                if let [left, right] = columns {
                    part_ui(left, 0..LEFT, true);
                    part_ui(right, LEFT..GROUPS.len(), false);
                }
            });
        } else {
            part_ui(ui, 0..GROUPS.len(), true);
        }
    });
    if answer.is_closed {
        commands.push(Command::ShowShortcuts(false));
    }
}

/// Some of the groups, below the pointer where that is wanted.
fn part_ui(ui: &mut Ui, groups: std::ops::Range<usize>, has_pointer: bool) {
    let mut is_first = true;
    let mut title_ui = |ui: &mut Ui, title: &str| {
        if std::mem::take(&mut is_first) { section_first_ui(ui, title, "") } else { section_ui(ui, title, "") }
    };
    if has_pointer {
        title_ui(ui, "Mouse");
        rows_ui(ui, POINTER.iter().map(|(what, does)| ((*what).to_owned(), *does)).collect());
    }
    if has_pointer {
        title_ui(ui, "In a picture that has the focus");
        rows_ui(ui, IN_PICTURE.iter().map(|(keys, does)| ((*keys).to_owned(), *does)).collect());
    }
    let is_mac = ui.ctx().os().is_mac();
    for group in &GROUPS[groups] {
        title_ui(ui, group.title);
        let listed = group.shortcuts.iter().filter(|shortcut| !shortcut.what.is_empty());
        rows_ui(ui, listed.map(|shortcut| (keys::text(&shortcut.keys, is_mac), shortcut.what)).collect());
    }
}

/// Keys at the left, as wide as the widest of them needs, and what they do in the room that is left, in several lines where it must be.
fn rows_ui(ui: &mut Ui, rows: Vec<(String, &str)>) {
    let font = theme::small_mono_style().resolve(ui.style());
    let color = ui.visuals().text_color();
    let width_of = |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), color).size().x;
    let widest = rows.iter().map(|(keys, _)| width_of(keys)).fold(0.0, f32::max).ceil();
    let height = ui.text_style_height(&TextStyle::Body);
    ui.spacing_mut().item_spacing = vec2(16.0, 4.0);
    for (keys, what) in rows {
        ui.horizontal_top(|ui| {
            ui.allocate_ui_with_layout(vec2(widest, height), Layout::left_to_right(Align::Center), |ui| {
                ui.set_min_width(widest);
                ui.label(RichText::new(keys).text_style(theme::small_mono_style()));
            });
            ui.add(Label::new(what).wrap());
        });
    }
}
