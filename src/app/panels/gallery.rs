//! The built-in scenes, each with its sentence: a grid of cards.

use egui::{Atom, Button, Context, Grid, Response, RichText, Ui, vec2};

use crate::app::command::Command;
use crate::app::modal;
use crate::app::state::State;
use crate::app::theme::Palette;
use crate::formats::builtin;

/// Width and height of a card, in points.
const CARD: [f32; 2] = [250.0, 64.0];
const MOST_COLUMNS: usize = 3;
const GAP: f32 = 8.0;

pub fn show(ctx: &Context, state: &State, commands: &mut Vec<Command>) {
    let columns = (((ctx.content_rect().width() - 80.0) / (CARD[0] + GAP)) as usize).clamp(1, MOST_COLUMNS);
    let width = columns as f32 * (CARD[0] + GAP) + GAP;
    let answer = modal::titled(ctx, "Built-in scenes", state.windows.gallery, width, |ui, is_opening| {
        let mut chosen = None;
        Grid::new("cards").spacing([GAP, GAP]).show(ui, |ui| {
            for (index, scene) in builtin::all().iter().enumerate() {
                let is_shown = is_shown(state, scene.name);
                let card = card_ui(ui, scene.name, scene.about, is_shown);
                // The scene that is open has the focus first, or the first of all.
                if is_opening && (is_shown || index == 0) {
                    card.request_focus();
                }
                if card.clicked() {
                    chosen = Some(scene.name);
                }
                if (index + 1) % columns == 0 {
                    ui.end_row();
                }
            }
        });
        chosen
    });
    let chosen = answer.inner.flatten();
    if answer.is_closed || chosen.is_some() {
        commands.push(Command::ShowGallery(false));
        commands.extend(chosen.map(|name| Command::Open(name.into())));
    }
}

fn card_ui(ui: &mut Ui, name: &str, about: &str, is_shown: bool) -> Response {
    let palette = Palette::of(ui);
    let mut text = egui::text::LayoutJob::default();
    let body = egui::TextStyle::Body.resolve(ui.style());
    let small = egui::TextStyle::Small.resolve(ui.style());
    text.append(name, 0.0, egui::TextFormat::simple(body, ui.visuals().strong_text_color()));
    text.append("\n", 0.0, egui::TextFormat::default());
    text.append(about, 0.0, egui::TextFormat::simple(small, palette.weak_text));
    let mut button = Button::selectable(is_shown, (text, Atom::grow()))
        .frame_when_inactive(true)
        .wrap()
        .min_size(vec2(CARD[0], CARD[1]));
    if is_shown {
        button = button.right_text(RichText::new("open").small());
    }
    ui.add_sized(CARD, button).accessible_name(name)
}

/// Whether the built-in scene of that name is the one that is open.
fn is_shown(state: &State, name: &str) -> bool {
    let source = state.document.description().source.as_ref();
    source.is_some_and(|source| source.is_builtin && source.path.file_stem().is_some_and(|stem| stem == name))
}
