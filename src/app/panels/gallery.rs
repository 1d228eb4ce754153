//! The built-in scenes, each with its sentence.

use egui::{Button, Context, RichText, vec2};

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::theme::Palette;
use crate::app::widgets::centered_ui;
use crate::formats::builtin;

pub fn show(ctx: &Context, state: &State, commands: &mut Vec<Command>) {
    let mut chosen = None;
    let is_closed = centered_ui(ctx, "Built-in scenes", state.windows.gallery, 560.0, |ui| {
        let palette = Palette::of(ui);
        for scene in builtin::all() {
            let mut text = egui::text::LayoutJob::default();
            let body = egui::TextStyle::Body.resolve(ui.style());
            let small = egui::TextStyle::Small.resolve(ui.style());
            let strong = ui.visuals().strong_text_color();
            text.append(scene.name, 0.0, egui::TextFormat::simple(body, strong));
            text.append("\n", 0.0, egui::TextFormat::default());
            text.append(scene.about, 0.0, egui::TextFormat::simple(small, palette.weak_text));
            let is_shown = is_shown(state, scene.name);
            let mut button = Button::selectable(is_shown, text).wrap().min_size(vec2(ui.available_width(), 44.0));
            if is_shown {
                button = button.right_text(RichText::new("open").small());
            }
            if ui.add(button).accessible_name(scene.name).clicked() {
                chosen = Some(scene.name);
            }
        }
    });
    if is_closed || chosen.is_some() {
        commands.extend(chosen.map(|name| Command::Open(name.into())));
        commands.push(Command::ShowGallery(false));
    }
}

/// Whether the built-in scene of that name is the one that is open.
fn is_shown(state: &State, name: &str) -> bool {
    let source = state.document.description().source.as_ref();
    source.is_some_and(|source| source.is_builtin && source.path.file_stem().is_some_and(|stem| stem == name))
}
