//! A picture on the graphics card. Where the same is being rendered in another size, the one that is there stays until the new one is as good.

use egui::{Color32, Context, Painter, Pos2, Rect, TextureFilter, TextureHandle, TextureOptions, Vec2, pos2, vec2};

use crate::app::develop::{About, Picture, Source};
use crate::app::settings::PaneContent;

/// Samples after which a picture in a new size is shown even if the old one has more.
const ENOUGH_SAMPLES: u32 = 32;

/// Seconds in which a finer picture emerges from a coarse one.
const EMERGING: f64 = 0.12;

/// A picture and what is known of it.
pub(super) struct Shot {
    texture: TextureHandle,
    pub(super) about: About,
    /// The same in another size, with fewer samples so far. It is seen where the picture does not reach.
    next: Option<(TextureHandle, About)>,
    /// The coarser preview before it, from which it emerges, and since when, in seconds.
    before: Option<(TextureHandle, Source, f64)>,
}

impl Shot {
    pub(super) fn new(ctx: &Context, content: PaneContent, picture: Picture) -> Self {
        let options = options(&picture.about.source);
        let texture = ctx.load_texture(content.to_string(), picture.image, options);
        Self { texture, about: picture.about, next: None, before: None }
    }

    /// Shows a newer picture, or keeps it at hand. Images of epoch `picture_floor` and later show the same.
    pub(super) fn take_in(&mut self, ctx: &Context, content: PaneContent, picture: Picture, picture_floor: u64) {
        let is_current = |source: &Source| source.epochs().all(|epoch| epoch >= picture_floor);
        let source = &picture.about.source;
        if !is_current(source) && is_current(&self.about.source) {
            return;
        }
        let options = options(source);
        if is_current(&self.about.source) && is_worse(source, &self.about.source) {
            match &mut self.next {
                Some((texture, about)) => {
                    texture.set(picture.image, options);
                    *about = picture.about;
                }
                None => {
                    let texture = ctx.load_texture(format!("{content}, next"), picture.image, options);
                    self.next = Some((texture, picture.about));
                }
            }
            return;
        }
        let old = &self.about.source;
        if old.is_preview() && old.epochs().eq(source.epochs()) {
            // Out of a coarse picture the finer one emerges, so that nothing flashes.
            let texture = ctx.load_texture(content.to_string(), picture.image, options);
            let before = std::mem::replace(&mut self.texture, texture);
            self.before = Some((before, old.clone(), ctx.input(|input| input.time)));
        } else {
            self.texture.set(picture.image, options);
            self.before = None;
        }
        self.about = picture.about;
        self.next = None;
    }

    /// Paints the part `window` of a film of size `film`, which fills `picture`.
    pub(super) fn paint(&self, painter: &Painter, film: [u32; 2], picture: Rect, window: Rect) {
        let paint = |texture: &TextureHandle, source: &Source, part: f32| {
            paint(painter, texture, source, film, picture, window, Color32::from_white_alpha((255.0 * part) as u8));
        };
        if let Some((texture, about)) = &self.next {
            paint(texture, &about.source, 1.0);
        }
        let mut part = 1.0;
        if let Some((texture, source, since)) = &self.before {
            part = ((painter.ctx().input(|input| input.time) - since) / EMERGING).clamp(0.0, 1.0) as f32;
            if part < 1.0 {
                paint(texture, source, 1.0);
                painter.ctx().request_repaint();
            }
        }
        paint(&self.texture, &self.about.source, part);
    }

    /// The point of this picture that shows what the film of size `film` has at `point`.
    pub(super) fn point(&self, film: [u32; 2], point: [f64; 2]) -> [f64; 2] {
        let wider = f64::from(aspect_ratio(&self.about.source, film));
        [0.5 + (point[0] - 0.5) / wider, point[1]]
    }
}

/// Whether `new` must not take the place of `old`, which shows the same.
fn is_worse(new: &Source, old: &Source) -> bool {
    let enough = old.samples().min(ENOUGH_SAMPLES);
    !old.is_preview() && (new.is_preview() || new.samples() < enough)
}

/// How much wider a picture is than a film of the same height: the camera's angle of view is that of the height.
fn aspect_ratio(source: &Source, film: [u32; 2]) -> f32 {
    let aspect = |[width, height]: [u32; 2]| width.max(1) as f32 / height.max(1) as f32;
    source.full_size().map_or(1.0, |size| aspect(size) / aspect(film))
}

fn paint(
    painter: &Painter,
    texture: &TextureHandle,
    source: &Source,
    film: [u32; 2],
    picture: Rect,
    window: Rect,
    tint: Color32,
) {
    let wider = aspect_ratio(source, film);
    // Where the whole texture would be, in the film's units and then on the screen.
    let whole = Rect::from_center_size(Pos2::new(0.5, 0.5), vec2(wider, 1.0));
    let part = whole.intersect(window);
    if !part.is_positive() {
        return;
    }
    let on_screen = |point: Pos2| picture.min + (point - window.min) / window.size() * picture.size();
    let in_texture = |point: Pos2| {
        let Vec2 { x, y } = (point - whole.min) / whole.size();
        pos2(x, y)
    };
    let screen = Rect::from_min_max(on_screen(part.min), on_screen(part.max));
    let uv = Rect::from_min_max(in_texture(part.min), in_texture(part.max));
    painter.image(texture.id(), screen, uv, tint);
}

/// Pixels of a finished picture stay pixels when one zooms in; previews are smoothed, except those of slices, whose colours have names.
fn options(source: &Source) -> TextureOptions {
    TextureOptions {
        magnification: if source.is_preview() && source.slice.is_none() {
            TextureFilter::Linear
        } else {
            TextureFilter::Nearest
        },
        minification: TextureFilter::Linear,
        ..TextureOptions::default()
    }
}
