//! Pictures of panes exactly as the window shows them. For the frames that it takes, what belongs to the pointer is left out and so is
//! everything that floats over the panes: the window draws itself, and a part of it is cut out.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::{ColorImage, Order, Rect};
use image::RgbImage;

/// A picture that has not come after this many frames and [`PATIENCE`] does not come.
const MOST_FRAMES: u32 = 30;
const PATIENCE: Duration = Duration::from_secs(3);

/// What is wanted a picture of, and where it goes.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// All panes, or the active one alone.
    pub is_all: bool,
    /// `None`: the clipboard.
    pub path: Option<PathBuf>,
    /// Text chunks of a file.
    pub text: Vec<(String, String)>,
}

/// Where the screen's pixels are left by whatever draws the window.
type Tray = Arc<Mutex<Option<Arc<ColorImage>>>>;

/// Waits for the picture of one frame.
pub struct Capture {
    pub subject: Subject,
    tray: Tray,
    /// Where it is, in points; what was drawn since it was asked for was drawn there.
    area: Option<Rect>,
    frames: u32,
    start: Instant,
}

impl Capture {
    pub fn new(subject: Subject) -> Self {
        Self { subject, tray: Tray::default(), area: None, frames: 0, start: Instant::now() }
    }

    /// To be called at the end of every frame, in which `area` (in points) is where the subject was drawn. Returns the picture or, in
    /// words, why there is none; after that nothing more comes.
    pub fn update(&mut self, ctx: &egui::Context, area: Rect) -> Option<Result<RgbImage, String>> {
        ctx.request_repaint();
        self.frames += 1;
        if let Some(image) = self.take_if_drawn(area) {
            return Some(cut(&image, area, ctx.pixels_per_point()));
        }
        if self.is_late() {
            return Some(Err("The window gave no picture of itself: nothing was exported. Try again.".to_owned()));
        }
        if self.area != Some(area) {
            // The first frame, or the window has changed: what was asked for would show another area.
            self.area = Some(area);
            self.tray = Tray::default();
            let tray = Arc::clone(&self.tray);
            ctx.send_viewport_cmd(egui::ViewportCommand::Screenshot(egui::ScreenshotCallback::new(move |image| {
                *tray.lock().unwrap_or_else(PoisonError::into_inner) = Some(image);
            })));
        }
        None
    }

    fn take_if_drawn(&self, area: Rect) -> Option<Arc<ColorImage>> {
        let image = self.tray.lock().unwrap_or_else(PoisonError::into_inner).take();
        image.filter(|_| self.area == Some(area))
    }

    fn is_late(&self) -> bool {
        self.frames > MOST_FRAMES && self.start.elapsed() > PATIENCE
    }
}

/// Takes what floats over the window (menus, notices, tips, questions) out of the frame that is being drawn.
pub fn clear_floating_layers(ctx: &egui::Context) {
    let layers: Vec<egui::LayerId> = ctx.memory(|memory| memory.layer_ids().collect());
    ctx.graphics_mut(|graphics| {
        for layer in layers.into_iter().filter(|layer| layer.order != Order::Background) {
            *graphics.entry(layer) = egui::layers::PaintList::default();
        }
    });
}

/// The pixels of `area`, which is in points, of a picture of the whole window.
fn cut(window: &ColorImage, area: Rect, pixels_per_point: f32) -> Result<RgbImage, String> {
    let pixel = |points: f32, most: usize| ((points * pixels_per_point).round().max(0.0) as usize).min(most);
    let [width, height] = window.size;
    let (left, right) = (pixel(area.left(), width), pixel(area.right(), width));
    let (top, bottom) = (pixel(area.top(), height), pixel(area.bottom(), height));
    if left >= right || top >= bottom {
        return Err("There is no pane in the window to make a picture of.".to_owned());
    }
    Ok(RgbImage::from_fn((right - left) as u32, (bottom - top) as u32, |x, y| {
        let color = window.pixels[(top + y as usize) * width + left + x as usize];
        image::Rgb([color.r(), color.g(), color.b()])
    }))
}

/// For the clipboard.
pub fn color_image(image: &RgbImage) -> ColorImage {
    ColorImage::from_rgb([image.width() as usize, image.height() as usize], image.as_raw())
}

#[cfg(test)]
mod tests {
    use egui::{Color32, pos2};

    use super::*;

    fn subject() -> Subject {
        Subject { is_all: false, path: None, text: Vec::new() }
    }

    #[test]
    fn the_pixels_of_the_area_are_cut_out_at_any_scale() {
        let pixels = (0..12 * 8).map(|i| Color32::from_rgb(i as u8, 7, 9)).collect();
        let window = ColorImage::new([12, 8], pixels);
        let area = Rect::from_min_max(pos2(2.0, 1.0), pos2(4.0, 3.0));
        for (scale, size, first) in [(1.0, (2, 2), 14), (2.0, (4, 4), 28), (1.5, (3, 3), 2 * 12 + 3)] {
            let image = cut(&window, area, scale).unwrap();
            assert_eq!((image.dimensions(), image.get_pixel(0, 0).0[0]), (size, first));
        }
        // An area that reaches beyond the window ends with it; one beside it is none.
        assert_eq!(
            cut(&window, Rect::from_min_max(pos2(10.0, 6.0), pos2(99.0, 99.0)), 1.0).unwrap().dimensions(),
            (2, 2)
        );
        assert!(cut(&window, Rect::from_min_max(pos2(50.0, 0.0), pos2(60.0, 9.0)), 1.0).is_err());
        assert!(cut(&window, Rect::NOTHING, 1.0).is_err());
    }

    #[test]
    fn a_window_that_gives_no_picture_is_an_error_after_some_frames() {
        let ctx = egui::Context::default();
        let area = Rect::from_min_max(pos2(0.0, 0.0), pos2(4.0, 4.0));
        let mut capture = Capture::new(subject());
        for _ in 0..MOST_FRAMES {
            assert!(capture.update(&ctx, area).is_none());
        }
        let Some(long_ago) = Instant::now().checked_sub(PATIENCE * 2) else { return };
        capture.start = long_ago;
        assert!(capture.update(&ctx, area).is_some_and(|outcome| outcome.unwrap_err().contains("no picture")));
    }

    #[test]
    fn a_picture_of_an_older_layout_is_not_taken() {
        let ctx = egui::Context::default();
        let [before, after] = [4.0, 2.0].map(|side| Rect::from_min_max(pos2(0.0, 0.0), pos2(side, side)));
        let mut capture = Capture::new(subject());
        assert!(capture.update(&ctx, before).is_none());
        let old = Arc::clone(&capture.tray);
        *old.lock().unwrap() = Some(Arc::new(ColorImage::filled([4, 4], Color32::RED)));
        assert!(capture.update(&ctx, after).is_none(), "it must be asked for again");
        *capture.tray.lock().unwrap() = Some(Arc::new(ColorImage::filled([4, 4], Color32::GREEN)));
        let image = capture.update(&ctx, after).unwrap().unwrap();
        assert_eq!((image.dimensions(), image.get_pixel(1, 1).0), ((2, 2), [0, 255, 0]));
    }
}
