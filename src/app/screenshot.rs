//! A picture of the window itself, taken once the images are good enough: how the screenshots of the documentation are made.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::ColorImage;

use super::Screenshot;
use crate::export;

/// Frames to wait after the samples are there, so that panels have settled.
const SETTLE_FRAMES: u32 = 6;
/// A picture is taken after this long in any case.
const PATIENCE: Duration = Duration::from_secs(600);

/// Where the outcome is left for whoever opened the window.
pub type Receipt = Arc<Mutex<Option<Result<(), String>>>>;

/// Waits, takes the picture, writes it, and closes the window.
pub struct Camera {
    shot: Screenshot,
    receipt: Receipt,
    frames_ready: u32,
    start: Instant,
    is_asked: bool,
}

impl Camera {
    pub fn new(shot: Screenshot, receipt: Receipt) -> Self {
        Self { shot, receipt, frames_ready: 0, start: Instant::now(), is_asked: false }
    }

    /// To be called at the end of every frame. `samples` are those of the pane that has fewest.
    pub fn update(&mut self, ctx: &egui::Context, samples: u32) {
        if lock(&self.receipt).is_some() {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        if samples >= self.shot.samples || self.start.elapsed() > PATIENCE {
            self.frames_ready += 1;
        }
        if self.frames_ready > SETTLE_FRAMES && !self.is_asked {
            self.is_asked = true;
            let (receipt, path, again) = (Arc::clone(&self.receipt), self.shot.path.clone(), ctx.clone());
            ctx.send_viewport_cmd(egui::ViewportCommand::Screenshot(egui::ScreenshotCallback::new(move |image| {
                let outcome = export::image_png(&path, &opaque(&image), &[]).map_err(|error| error.to_string());
                *lock(&receipt) = Some(outcome);
                again.request_repaint();
            })));
        }
        // Seldom while waiting: frames cost time that the images need.
        let pause = if self.frames_ready > 0 { 20 } else { 300 };
        ctx.request_repaint_after(Duration::from_millis(pause));
    }
}

pub fn lock(receipt: &Receipt) -> std::sync::MutexGuard<'_, Option<Result<(), String>>> {
    receipt.lock().unwrap_or_else(PoisonError::into_inner)
}

fn opaque(image: &ColorImage) -> image::RgbImage {
    let [width, height] = image.size.map(|side| side as u32);
    image::RgbImage::from_fn(width, height, |x, y| {
        let color = image.pixels[(y * width + x) as usize];
        image::Rgb([color.r(), color.g(), color.b()])
    })
}
