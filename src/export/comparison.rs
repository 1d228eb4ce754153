//! Several pictures of one scene in one picture: labelled panes above, and below each what it lacks or has too much against a baseline.

use image::RgbImage;

use super::canvas::{Align, Canvas, Color};
use super::color_map::{diverging, luminance, round_up_to_125};
use super::words::{brief, events_in_words};
use super::{ExportError, Picture};
use crate::measure::{Difference, difference};
use crate::render::Display;
use crate::tracking::Events;

pub(super) const SHEET: Color = [0x17, 0x18, 0x1c];
pub(super) const INK: Color = [0xf0, 0xf1, 0xf4];
pub(super) const MUTED: Color = [0x9c, 0xa2, 0xae];
const WARNING: Color = [0xf5, 0xb3, 0x4d];
/// Labels need this many pixels of width; smaller pictures are enlarged by a whole factor.
const LEAST_PANE_WIDTH: u32 = 280;
/// The colour scale ends where at most this share of the pixels goes beyond it.
const BEYOND_SCALE: f64 = 0.01;
/// Most pixels of a sheet: memory for more may not be there.
const MOST_PIXELS: u64 = 1 << 28;

/// One pane.
#[derive(Debug, Clone)]
pub struct LabelledPane<'a> {
    /// Usually the mode's name.
    pub title: String,
    /// A second line in muted ink, such as `"64 spp · 2.1 s"`.
    pub details: String,
    /// What was counted while rendering; shown in words.
    pub events: Events,
    /// All panes have the same size.
    pub picture: &'a Picture,
}

/// What stands around the panes, and what they are held against.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    /// The scene's name, in large letters.
    pub title: String,
    /// Small, at the right of the title.
    pub details: String,
    /// Exposure and tone curve of the panes; differences are those of linear luminance, multiplied by the exposure's gain.
    pub display: Display,
    /// The pane that the others are subtracted from, by index; `None` leaves the differences out.
    pub baseline: Option<usize>,
}

/// Lays `panes` out side by side.
///
/// # Errors
/// When there is no pane, a pane is empty or has another size than the first, the baseline does not exist, a pixel is not finite, or
/// the whole would be larger than 2^28 pixels.
pub fn comparison(panes: &[LabelledPane<'_>], about: &Comparison) -> Result<RgbImage, ExportError> {
    require_comparable(panes, about.baseline)?;
    let layout = Layout::new(panes, about);
    let mut canvas = Canvas::new(layout.width, layout.height, SHEET);
    draw_title(&mut canvas, &layout, about);
    for (index, pane) in panes.iter().enumerate() {
        draw_pane(&mut canvas, &layout, index, pane, &about.display);
    }
    if let Some(baseline) = about.baseline {
        draw_differences(&mut canvas, &layout, panes, baseline, &about.display)?;
    }
    Ok(canvas.image)
}

fn require_comparable(panes: &[LabelledPane<'_>], baseline: Option<usize>) -> Result<(), ExportError> {
    let Some(first) = panes.first() else {
        return Err(ExportError::BadComparison("there are no panes".into()));
    };
    for pane in panes {
        pane.picture.require_sound()?;
        if (pane.picture.width, pane.picture.height) != (first.picture.width, first.picture.height) {
            let size = |LabelledPane { title, picture: Picture { width, height, .. }, .. }: &LabelledPane<'_>| {
                format!("pane `{title}` is {width}×{height}")
            };
            return Err(ExportError::BadComparison(format!("{}, {}", size(first), size(pane))));
        }
    }
    let (width, height) = (u64::from(first.picture.width), u64::from(first.picture.height));
    let zoom = u64::from(zoom_for(first.picture.width));
    let pixels = width.saturating_mul(height).saturating_mul(zoom * zoom * 2).saturating_mul(panes.len() as u64);
    if pixels > MOST_PIXELS {
        return Err(ExportError::BadComparison(format!("the picture would have {pixels} pixels; use smaller panes")));
    }
    match baseline {
        Some(index) if index >= panes.len() => {
            Err(ExportError::BadComparison(format!("there is no pane {index} to compare with")))
        }
        _ => Ok(()),
    }
}

pub(super) fn zoom_for(picture_width: u32) -> u32 {
    LEAST_PANE_WIDTH.div_ceil(picture_width)
}

/// Where everything stands, in pixels.
struct Layout {
    width: u32,
    height: u32,
    margin: u32,
    /// Size of ordinary text.
    text: f32,
    zoom: u32,
    pane_width: u32,
    /// Whether some pane has events, which then get a line of their own in all, so that titles stand level.
    events_have_a_line: bool,
    /// Baseline of the title.
    title_y: f32,
    /// Top of the panes' pictures, and of the differences' pictures.
    panes_y: u32,
    differences_y: u32,
}

impl Layout {
    fn new(panes: &[LabelledPane<'_>], about: &Comparison) -> Self {
        let picture = panes[0].picture;
        let zoom = zoom_for(picture.width);
        let (pane_width, pane_height) = (picture.width * zoom, picture.height * zoom);
        let text = (pane_width as f32 / 27.0).clamp(13.0, 40.0);
        let margin = (text * 1.5).round() as u32;
        let line = (text * 1.45).round() as u32;
        let events_have_a_line = panes.iter().any(|pane| pane.events.total() > 0);

        let title_y = margin as f32 + text * 1.35;
        let panes_y = title_y as u32 + margin / 2 + 2 * line + u32::from(events_have_a_line) * line + line / 2;
        let below_panes = panes_y + pane_height;
        let differences_y = below_panes + margin / 2 + 2 * line + line / 2;
        let bottom = if about.baseline.is_some() { differences_y + pane_height } else { below_panes };
        Self {
            width: panes.len() as u32 * (pane_width + margin) + margin,
            height: bottom + margin,
            margin,
            text,
            zoom,
            pane_width,
            events_have_a_line,
            title_y,
            panes_y,
            differences_y,
        }
    }

    fn pane_x(&self, index: usize) -> u32 {
        self.margin + index as u32 * (self.pane_width + self.margin)
    }

    fn line(&self) -> f32 {
        self.text * 1.45
    }
}

fn draw_title(canvas: &mut Canvas, layout: &Layout, about: &Comparison) {
    let (left, right) = (layout.margin as f32, (layout.width - layout.margin) as f32);
    let size = layout.text * 1.7;
    let title = canvas.fitted(&about.title, size, right - left);
    canvas.text(&title, left, layout.title_y, Align::Left, size, INK);
    // The details are left out where they would touch the title.
    let room = right - left - canvas.text_width(&title, size) - layout.text * 2.0;
    if canvas.text_width(&about.details, layout.text) <= room {
        canvas.text(&about.details, right, layout.title_y, Align::Right, layout.text, MUTED);
    }
}

/// Lines of text that end just above `picture_y`, the first larger.
fn draw_header(canvas: &mut Canvas, layout: &Layout, x: u32, picture_y: u32, lines: &[(&str, Color)]) {
    for (index, (text, color)) in lines.iter().enumerate() {
        let below = (lines.len() - 1 - index) as f32;
        let y = picture_y as f32 - layout.text * 0.6 - below * layout.line();
        let size = if index == 0 { layout.text * 1.25 } else { layout.text };
        let text = canvas.fitted(text, size, layout.pane_width as f32);
        canvas.text(&text, x as f32, y, Align::Left, size, *color);
    }
}

fn draw_pane(canvas: &mut Canvas, layout: &Layout, index: usize, pane: &LabelledPane<'_>, display: &Display) {
    let x = layout.pane_x(index);
    let events = events_in_words(&pane.events);
    let color = if pane.events.total() > 0 { WARNING } else { MUTED };
    if layout.events_have_a_line {
        let lines = [(pane.title.as_str(), INK), (pane.details.as_str(), MUTED), (events.as_str(), color)];
        draw_header(canvas, layout, x, layout.panes_y, &lines);
    } else {
        let details = format!("{} · {events}", pane.details);
        draw_header(canvas, layout, x, layout.panes_y, &[(&pane.title, INK), (&details, MUTED)]);
    }
    let encoded = pane.picture.encode(display);
    let (width, height) = encoded.dimensions();
    canvas.paint(x, layout.panes_y, width, height, layout.zoom, |column, row| encoded.get_pixel(column, row).0);
}

fn draw_differences(
    canvas: &mut Canvas,
    layout: &Layout,
    panes: &[LabelledPane<'_>],
    baseline: usize,
    display: &Display,
) -> Result<(), ExportError> {
    let gain = display.exposure.exp2();
    let against = &panes[baseline];
    let others: Vec<usize> = (0..panes.len()).filter(|&index| index != baseline).collect();
    let mut figures: Vec<Difference> = Vec::with_capacity(others.len());
    let mut of_pane: Vec<Vec<f32>> = Vec::with_capacity(others.len());
    for &index in &others {
        figures.push(difference(&panes[index].picture.rgb, &against.picture.rgb)?);
        let pairs = panes[index].picture.rgb.iter().zip(&against.picture.rgb);
        of_pane.push(pairs.map(|(a, b)| (luminance(*a) - luminance(*b)) * gain).collect());
    }
    let scale = common_scale(&of_pane);
    for ((&index, difference), pixels) in others.iter().zip(&figures).zip(&of_pane) {
        let x = layout.pane_x(index);
        let title = format!("{} − {}", panes[index].title, against.title);
        let details = format!("relMSE {} · mean |Δ| {}", brief(difference.relmse), brief(difference.mean_abs));
        draw_header(canvas, layout, x, layout.differences_y, &[(&title, INK), (&details, MUTED)]);
        let picture = against.picture;
        canvas.paint(x, layout.differences_y, picture.width, picture.height, layout.zoom, |column, row| {
            diverging(pixels[row as usize * picture.width as usize + column as usize] / scale)
        });
    }
    if !others.is_empty() {
        draw_legend(canvas, layout, layout.pane_x(baseline), scale, &against.title);
    }
    Ok(())
}

/// One scale for all differences, so that their colours can be compared: a round number that few pixels exceed.
fn common_scale(of_pane: &[Vec<f32>]) -> f32 {
    let mut sizes: Vec<f32> = of_pane.iter().flatten().map(|d| d.abs()).collect();
    if sizes.is_empty() {
        return 1.0;
    }
    let index = ((sizes.len() - 1) as f64 * (1.0 - BEYOND_SCALE)) as usize;
    let (_, size, _) = sizes.select_nth_unstable_by(index, f32::total_cmp);
    round_up_to_125(*size)
}

/// The colour scale with its ends in numbers and in words, in the cell below the baseline pane.
fn draw_legend(canvas: &mut Canvas, layout: &Layout, x: u32, scale: f32, baseline: &str) {
    let width = layout.pane_width;
    let bar_height = (layout.text * 1.1).round() as u32;
    let (left, right, middle) = (x as f32, (x + width) as f32, x as f32 + width as f32 / 2.0);
    let mut y = layout.differences_y as f32 + layout.text;
    let heading = canvas.fitted("difference of luminance, linear", layout.text, width as f32);
    canvas.text(&heading, left, y, Align::Left, layout.text, INK);
    y += layout.line() * 0.5;
    for column in 0..width {
        let value = 2.0 * (column as f32 + 0.5) / width as f32 - 1.0;
        canvas.fill(x + column, y as u32, 1, bar_height, diverging(value));
    }
    y += bar_height as f32 + layout.line() * 0.9;
    let end = brief(f64::from(scale));
    canvas.text(&format!("−{end}"), left, y, Align::Left, layout.text, INK);
    canvas.text("0", middle, y, Align::Center, layout.text, INK);
    canvas.text(&format!("+{end}"), right, y, Align::Right, layout.text, INK);
    y += layout.line();
    let small = layout.text * 0.9;
    let half = width as f32 / 2.0 - layout.text;
    let (darker, brighter) = (format!("darker than {baseline}"), format!("brighter than {baseline}"));
    canvas.text(&canvas.fitted(&darker, small, half), left, y, Align::Left, small, MUTED);
    canvas.text(&canvas.fitted(&brighter, small, half), right, y, Align::Right, small, MUTED);
}
