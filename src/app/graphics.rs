//! The graphics card's limits, and what keeps the window within them.
//!
//! A window, like every texture, has at most as many pixels a side as the card's textures: wgpu refuses a larger surface, and that ends the
//! program unless somebody listens.

use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup};
use eframe::wgpu;

/// Pixels a side that a window has at most before the card is known; most cards have twice as many.
const FIRST_SIDE: u32 = 8192;
/// Most pixels of a film. (As of an image that is rendered without a window.)
const MOST_FILM_PIXELS: f32 = (1_u32 << 26) as f32;

/// Asks for the largest textures that the card has, where egui asks for 8192 pixels a side.
pub fn configure(configuration: &mut WgpuConfiguration) {
    let WgpuSetup::CreateNew(setup) = &mut configuration.wgpu_setup else { return };
    let usual = Arc::clone(&setup.device_descriptor);
    setup.device_descriptor = Arc::new(move |adapter| {
        let usual = usual(adapter);
        // A picture of the window takes a buffer of its size.
        let wgpu::Limits { max_texture_dimension_2d, max_buffer_size, .. } = adapter.limits();
        let required_limits =
            wgpu::Limits { max_texture_dimension_2d, max_buffer_size, ..usual.required_limits.clone() };
        wgpu::DeviceDescriptor { required_limits, ..usual }
    });
}

/// The size in pixels to open a window with: the wanted one as far as any card can show it. [`WindowSize`] enlarges it once the card is known.
pub fn first_size(wanted: [u32; 2]) -> [f32; 2] {
    wanted.map(|side| side.min(FIRST_SIDE) as f32)
}

/// Keeps the window's size within what the card can show.
#[derive(Debug, Default)]
pub struct WindowSize {
    /// In pixels, where it could not be opened with the size that was asked for.
    wanted: Option<[u32; 2]>,
    is_limited: bool,
}

impl WindowSize {
    /// Of a window that was asked for with that many pixels, or without any number.
    pub fn new(asked: Option<[u32; 2]>) -> Self {
        Self { wanted: asked.filter(|size| size.iter().any(|side| *side > FIRST_SIDE)), is_limited: false }
    }

    /// To be called in every frame; acts in the first one, when the card is known.
    pub fn update(&mut self, ctx: &egui::Context) {
        if self.is_limited {
            return;
        }
        self.is_limited = true;
        let most = ctx.input(|input| input.max_texture_side) as f32;
        let points = |pixels: [f32; 2]| egui::Vec2::from(pixels) / ctx.pixels_per_point();
        ctx.send_viewport_cmd(egui::ViewportCommand::MaxInnerSize(points([most; 2])));
        if let Some(wanted) = self.wanted.take() {
            let size = points(wanted.map(|side| (side as f32).min(most)));
            ctx.send_viewport_cmd(egui::ViewportCommand::InnerSize(size));
        }
    }
}

/// Pixels of a film for `pixels` of the screen, where a texture has at most `most_side` a side. One factor for both sides keeps the
/// picture's proportions.
pub fn film_size(pixels: [f32; 2], most_side: usize) -> [u32; 2] {
    let [width, height] = pixels;
    let fit = (most_side as f32 / width.max(height)).min((MOST_FILM_PIXELS / (width * height)).sqrt()).min(1.0);
    // Rounding up must not pass the limit.
    [width, height].map(|side| ((side * fit).round() as u32).clamp(1, (most_side as u32).max(1)))
}

/// What the card has refused since it was last asked. Without a listener wgpu ends the program.
#[derive(Debug, Clone, Default)]
pub struct Refusals(Arc<Mutex<Option<String>>>);

impl Refusals {
    /// Listens from now on.
    pub fn listen(&self, device: &wgpu::Device) {
        let heard = Arc::clone(&self.0);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            log::error!("the graphics card refuses: {error}");
            *heard.lock().unwrap_or_else(PoisonError::into_inner) = Some(error.to_string());
        }));
    }

    /// The last one, told once.
    pub fn take(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_fit_into_textures_and_keep_their_proportions() {
        assert_eq!(film_size([1280.0, 720.0], 8192), [1280, 720]);
        assert_eq!(film_size([10_000.0, 400.0], 8192), [8192, 328]);
        assert_eq!(film_size([400.0, 10_000.0], 2048), [82, 2048]);
        assert_eq!(film_size([0.2, 50_000.0], 2048), [1, 2048]);
        // Large textures on a card that has them, but not both sides at once.
        assert_eq!(film_size([16_000.0, 1000.0], 16_384), [16_000, 1000]);
        assert_eq!(film_size([16_384.0, 16_384.0], 16_384), [8192, 8192]);
    }

    #[test]
    fn a_window_opens_no_larger_than_any_card_allows() {
        assert_eq!(first_size([10_000, 400]), [8192.0, 400.0]);
        assert!(WindowSize::new(Some([8192, 400])).wanted.is_none());
        assert_eq!(WindowSize::new(Some([10_000, 400])).wanted, Some([10_000, 400]));
    }
}
