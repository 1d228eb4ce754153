//! The numbers of the pixel under the pointer, in every pane at once.

use egui::{Color32, Painter, Pos2, Rect, Stroke, Ui, Vec2, pos2, vec2};

use super::layout::{Pane, film_window, screen_from_film};
use crate::app::develop::About;
use crate::app::settings::{DifferenceKind, PaneContent};
use crate::app::state::State;
use crate::app::theme;
use crate::app::theme::over_pictures::{GROUND, TEXT};
use crate::export::color_map::luminance;

const PADDING: Vec2 = vec2(8.0, 4.0);
/// Panes with less room show no numbers.
const LEAST: Vec2 = vec2(150.0, 110.0);

/// The index of the pixel at `point`, in [0, 1]², of an image of `size`; `None` outside.
pub fn pixel_at(size: [u32; 2], point: [f64; 2]) -> Option<[u32; 2]> {
    let pixel: [f64; 2] = std::array::from_fn(|i| (point[i] * f64::from(size[i])).floor());
    (0..2).all(|i| pixel[i] >= 0.0 && pixel[i] < f64::from(size[i])).then(|| pixel.map(|x| x as u32))
}

/// The lines that say what a picture shows at `point`; none for surfaces, before there is an image, and outside of it.
pub fn lines(content: PaneContent, about: &About, kind: DifferenceKind, point: [f64; 2]) -> Vec<String> {
    let source = &about.source;
    let Some(film) = source.images().next() else { return Vec::new() };
    let Some([x, y]) = pixel_at(film.size, point) else { return Vec::new() };
    let index = y as usize * film.size[0] as usize + x as usize;
    let rgb_text = |rgb: [f32; 3], is_signed: bool| rgb.map(|x| number(x, is_signed)).join(" ");
    if !content.is_difference() {
        let Some(rgb) = film.rgb.get(index) else { return Vec::new() };
        return vec![format!("RGB {}", rgb_text(*rgb, false)), format!("Y   {}", number(luminance(*rgb), false))];
    }
    let Some([a, b]) = source.pair() else { return Vec::new() };
    let (Some(a), Some(b)) = (a.get(index), b.get(index)) else { return Vec::new() };
    let difference: [f32; 3] = std::array::from_fn(|channel| a[channel] - b[channel]);
    let mut last = format!("ΔY   {}", number(luminance(difference), true));
    // Nobody knows the noise of an image from a file.
    if let Some(truth) = source.truth.as_ref().filter(|truth| truth.file.is_none())
        && let (Some(a), Some(b)) = (truth.rgb[0].get(index), truth.rgb[1].get(index))
    {
        // Half of the halves' difference is as large as the noise of their mean.
        last += &format!(" ± {}", number(0.5 * (luminance(*a) - luminance(*b)).abs(), false).trim_start());
    }
    if kind == DifferenceKind::Flip
        && let Some(flip) = about.flip.as_ref().and_then(|flip| flip.get(index))
    {
        last += &format!("  FLIP {flip:.3}");
    }
    vec![format!("ΔRGB {}", rgb_text(difference, true)), last]
}

/// Four significant digits, of one width for what is usual.
fn number(x: f32, is_signed: bool) -> String {
    let size = x.abs();
    let text = match size {
        _ if !size.is_finite() => return x.to_string(),
        0.0 => "0.0000".to_owned(),
        s if !(1e-3..1e5).contains(&s) => format!("{size:.1e}"),
        s if s >= 1000.0 => format!("{size:.1}"),
        s if s >= 100.0 => format!("{size:.2}"),
        s if s >= 10.0 => format!("{size:.3}"),
        _ => format!("{size:.4}"),
    };
    match (x < 0.0, is_signed && x > 0.0) {
        (true, _) => format!("−{text}"),
        (_, true) => format!("+{text}"),
        _ => text,
    }
}

/// A pane's numbers in its lower left corner, or the upper one where its label is below. `lift`: room to leave below, in points. Returns where
/// they are, if there is room.
pub(super) fn show(ui: &Ui, lines: &[String], pane: &Pane, is_label_below: bool, lift: f32) -> Option<Rect> {
    let room = pane.visible.shrink(8.0);
    if lines.is_empty() || room.width() < LEAST.x || room.height() < LEAST.y {
        return None;
    }
    let painter = ui.painter().with_clip_rect(pane.visible.intersect(ui.clip_rect()));
    let font = theme::small_mono_style().resolve(ui.style());
    let galley = painter.layout_no_wrap(lines.join("\n"), font, TEXT);
    let size = galley.size() + 2.0 * PADDING;
    let top = if is_label_below { room.top() } else { room.bottom() - size.y - lift };
    let frame = Rect::from_min_size(pos2(room.left(), top), size);
    painter.rect_filled(frame, 5.0, GROUND);
    painter.galley(frame.min + PADDING, galley, TEXT);
    Some(frame)
}

/// A cross at the pointer's place in a pane where the pointer is not.
pub(super) fn paint_cross(painter: &Painter, state: &State, picture: Rect, point: [f64; 2]) {
    let window = film_window(state.view.zoom, state.view.zoom_center);
    let center: Pos2 = screen_from_film(picture, window, pos2(point[0] as f32, point[1] as f32));
    for (width, color) in [(3.0, Color32::from_black_alpha(130)), (1.0, Color32::from_white_alpha(220))] {
        for direction in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
            painter.line_segment([center + direction * 3.0, center + direction * 8.0], Stroke::new(width, color));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::develop::Source;
    use crate::session::{Halves, Snapshot};
    use crate::tracking::Mode;

    #[test]
    fn the_numbers_are_those_of_the_pixel() {
        let black = [0.0; 3];
        let a = Snapshot::of(Mode::Stack, [2, 2], vec![black, black, [0.5, 0.25, 0.125], black]);
        let b = Snapshot::of(Mode::Rectified, [2, 2], vec![black, black, [0.5; 3], black]);
        let below_left = [0.2, 0.7];
        let about = |source: Source| About { source, ..About::default() };
        let source = about(Source { films: vec![Arc::clone(&a)], ..Source::default() });
        let texts = lines(PaneContent::Mode(Mode::Stack), &source, DifferenceKind::Signed, below_left);
        assert_eq!(texts, ["RGB 0.5000 0.2500 0.1250", "Y   0.2941"]);
        let mut pair = about(Source { films: vec![Arc::clone(&a), b], ..Source::default() });
        pair.flip = Some(Arc::new(vec![0.0, 0.0, 0.75, 0.0]));
        let content = PaneContent::Difference(Mode::Stack, Mode::Rectified);
        let texts = lines(content, &pair, DifferenceKind::Flip, below_left);
        assert_eq!(texts, ["ΔRGB 0.0000 −0.2500 −0.3750", "ΔY   −0.2059  FLIP 0.750"]);
        let halves = [vec![black, black, [0.4; 3], black], vec![black, black, [0.6; 3], black]];
        let truth =
            Halves { size: [2, 2], samples: 1, file: None, rgb: halves, mean: vec![black, black, [0.5; 3], black] };
        let error = about(Source { films: vec![a], truth: Some(Arc::new(truth)), ..Source::default() });
        let texts = lines(PaneContent::Error(Mode::Stack), &error, DifferenceKind::Signed, below_left);
        assert_eq!(texts[1], "ΔY   −0.2059 ± 0.1000");
        assert!(lines(PaneContent::Mode(Mode::Stack), &source, DifferenceKind::Signed, [1.0, 0.5]).is_empty());
    }

    #[test]
    fn numbers_are_short_whatever_their_size() {
        for x in [0.0, 1e-9, 4.5e-4, 0.02, 3.0, 77.7, 512.25, 9_999.0, 3e7, -0.5, f32::NAN, f32::INFINITY] {
            assert!(number(x, true).chars().count() <= 7, "{}", number(x, true));
        }
        assert_eq!(number(-0.25, false), "−0.2500");
    }
}
