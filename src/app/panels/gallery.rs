//! The built-in scenes, each with its sentence: a grid of cards.

use egui::load::SizedTexture;
use egui::text::LayoutJob;
use egui::{
    Color32, ColorImage, Context, Grid, Id, Rect, Response, Sense, TextFormat, TextStyle, TextureHandle,
    TextureOptions, Ui, Vec2, vec2,
};

use crate::app::command::Command;
use crate::app::modal;
use crate::app::state::State;
use crate::app::theme::Palette;
use crate::app::widgets::focus_ring;
use crate::formats::builtin::{self, Builtin};

/// Sizes in points: a picture, and a card with its text.
const PICTURE: Vec2 = vec2(192.0, 144.0);
const PADDING: f32 = 8.0;
const CARD: Vec2 = vec2(PICTURE.x + 2.0 * PADDING, PICTURE.y + 2.0 * PADDING + 66.0);
const MOST_COLUMNS: usize = 4;
const GAP: f32 = 8.0;

pub fn show(ctx: &Context, state: &State, commands: &mut Vec<Command>) {
    let columns = (((ctx.content_rect().width() - 80.0) / (CARD.x + GAP)) as usize).clamp(1, MOST_COLUMNS);
    let width = columns as f32 * (CARD.x + GAP) + GAP;
    let answer = modal::titled(ctx, "Built-in scenes", state.windows.gallery, width, |ui, is_opening| {
        let mut chosen = None;
        Grid::new("cards").spacing([GAP, GAP]).show(ui, |ui| {
            for (index, scene) in builtin::all().iter().enumerate() {
                let is_shown = is_shown(state, scene.name);
                let card = card_ui(ui, scene, is_shown);
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

/// A picture of the scene, its name and its sentence; a button as a whole.
fn card_ui(ui: &mut Ui, scene: &Builtin, is_shown: bool) -> Response {
    let (rect, response) = ui.allocate_exact_size(CARD, Sense::click());
    let name = scene.name;
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, is_shown, name));
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let visuals = ui.style().interact_selectable(&response, is_shown);
    ui.painter().rect_filled(rect, 6.0, visuals.weak_bg_fill);
    let inner = rect.shrink(PADDING);
    let picture = Rect::from_min_size(inner.min, PICTURE);
    egui::Image::from_texture(SizedTexture::new(thumbnail(ui.ctx(), scene).id(), PICTURE))
        .corner_radius(4)
        .paint_at(ui, picture);
    let palette = Palette::of(ui);
    let body = TextStyle::Body.resolve(ui.style());
    let small = TextStyle::Small.resolve(ui.style());
    let (strong, weak) = (visuals.text_color(), if is_shown { visuals.text_color() } else { palette.weak_text });
    let mut text = LayoutJob::default();
    text.wrap.max_width = inner.width();
    text.append(name, 0.0, TextFormat::simple(body, strong));
    if is_shown {
        text.append("open", 8.0, TextFormat::simple(small.clone(), weak));
    }
    text.append("\n", 0.0, TextFormat::default());
    text.append(scene.about, 0.0, TextFormat::simple(small, weak));
    let galley = ui.painter().layout_job(text);
    ui.painter().with_clip_rect(inner).galley(picture.left_bottom() + vec2(0.0, 6.0), galley, strong);
    focus_ring(ui, &response);
    response.on_hover_text(scene.about)
}

/// The scene's small picture on the graphics card; it is decoded when it is first shown.
fn thumbnail(ctx: &Context, scene: &Builtin) -> TextureHandle {
    let id = Id::unique(("thumbnail", scene.name));
    if let Some(known) = ctx.data(|data| data.get_temp::<TextureHandle>(id)) {
        return known;
    }
    let picture = match image::load_from_memory(scene.thumbnail) {
        Ok(picture) => {
            let size = [picture.width() as usize, picture.height() as usize];
            ColorImage::from_rgb(size, &picture.into_rgb8())
        }
        // A test reads every one of them.
        Err(_) => ColorImage::filled([1, 1], Color32::DARK_GRAY),
    };
    let texture = ctx.load_texture(format!("thumbnail of {}", scene.name), picture, TextureOptions::LINEAR);
    ctx.data_mut(|data| data.insert_temp(id, texture.clone()));
    texture
}

/// Whether the built-in scene of that name is the one that is open.
fn is_shown(state: &State, name: &str) -> bool {
    let source = state.document.description().source.as_ref();
    source.is_some_and(|source| source.is_builtin && source.path.file_stem().is_some_and(|stem| stem == name))
}
