//! Plots as SVG inside the page: lines with markers, intervals and levels on linear or logarithmic axes.
//!
//! Drawn here and not by a library so that the page's style sheet decides colours (light, dark, print) and every curve differs from the
//! others in three ways that need no colour: its dashes, its markers and its name at its end.

use maud::{Markup, html};

/// Size of the drawing in its own units, which are pixels where the page is wide enough.
const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 330.0;
/// Room around the plotting area: for numbers at the left and below, for the curves' names at the right.
const LEFT: f64 = 70.0;
const RIGHT: f64 = 116.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 46.0;
/// Distance between the names at the curves' ends, at least.
const LINE: f64 = 14.0;
/// Curves that look different from each other.
pub const STYLES: usize = 7;

/// How values become places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// Values that are not positive are left out.
    Log,
}

impl Scale {
    /// The value, or its decimal logarithm; not finite for what the scale cannot show.
    fn of(self, value: f64) -> f64 {
        if self == Self::Log { value.max(0.0).log10() } else { value }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub label: String,
    pub scale: Scale,
}

impl Axis {
    pub fn log(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log }
    }
}

/// A point on a curve; `low` and `high` bound y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataPoint {
    pub x: f64,
    pub y: f64,
    pub low: f64,
    pub high: f64,
}

impl DataPoint {
    /// Without an interval.
    pub fn exact(x: f64, y: f64) -> Self {
        Self { x, y, low: y, high: y }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    pub name: String,
    /// Which of [`STYLES`] it has.
    pub style: usize,
    pub data: Vec<DataPoint>,
}

/// A horizontal line in the style of a curve, with the interval of its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// What a pointer over it is told.
    pub name: String,
    pub style: usize,
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// For those who cannot see it: what it shows, in one sentence.
    pub about: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve>,
    pub levels: Vec<Level>,
}

/// Values to places along one axis.
struct Ruler {
    scale: Scale,
    /// Ends of the axis, in values or, of a logarithmic one, their decimal logarithms.
    low: f64,
    high: f64,
    /// The same in the drawing.
    from: f64,
    to: f64,
}

impl Ruler {
    /// An axis that holds all `values` that it can show; `None` if there is none.
    fn new(scale: Scale, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Option<Self> {
        let shown = values.map(|x| scale.of(x)).filter(|x| x.is_finite());
        let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        if low > high {
            return None;
        }
        let span = high - low;
        let margin = match scale {
            Scale::Linear if span == 0.0 => low.abs().max(1.0) * 0.5,
            // Half a decade at least: equal values are not to look like noise.
            Scale::Log => (0.04 * span).max(0.5 * (0.5 - span)),
            Scale::Linear => 0.04 * span,
        };
        Some(Self { scale, low: low - margin, high: high + margin, from, to })
    }

    /// Where a value lies; values beyond an end, and those that a logarithmic axis has no place for, at the end.
    fn at(&self, value: f64) -> f64 {
        let part = ((self.scale.of(value) - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        self.from + (self.to - self.from) * part
    }

    /// Values with a line across and a number each, at most `most`.
    fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Log => {
                let (first, last) = (self.low.ceil() as i32, self.high.floor() as i32);
                let decades = (last - first + 1).max(0) as usize;
                if decades < 2 {
                    // Digits between where there are no two powers of ten.
                    let digits: &[f64] =
                        if self.high - self.low < 0.8 { &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0] } else { &[1.0, 2.0, 5.0] };
                    let range = self.low.floor() as i32..=self.high.floor() as i32;
                    return range
                        .flat_map(|k| digits.iter().map(move |&digit| (digit, k)))
                        .map(|(digit, k)| (digit * 10_f64.powi(k), scientific(digit, k)))
                        .filter(|(value, _)| (self.low..=self.high).contains(&value.log10()))
                        .collect();
                }
                let step = decades.div_ceil(most).max(1);
                (first..=last).step_by(step).map(|k| (10_f64.powi(k), scientific(1.0, k))).collect()
            }
            Scale::Linear => {
                let rough = (self.high - self.low) / most as f64;
                let decade = 10_f64.powf(rough.log10().floor());
                let steps = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0].map(|factor| factor * decade);
                let coarsest = steps.iter().position(|step| *step >= rough).unwrap_or(steps.len() - 1);
                // One number says nothing of the scale.
                let has_two = |step: &&f64| (self.high / *step).floor() - (self.low / *step).ceil() >= 1.0;
                let step = *steps[..=coarsest].iter().rev().find(has_two).unwrap_or(&steps[0]);
                let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
                let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
                (first..=last).map(|k| (k as f64 * step, minus(&format!("{:.decimals$}", k as f64 * step)))).collect()
            }
        }
    }

    /// Values between the numbered ones of a logarithmic axis of few decades.
    fn small_ticks(&self) -> Vec<f64> {
        if self.scale == Scale::Linear || self.high - self.low > 5.0 {
            return Vec::new();
        }
        let decades = self.low.floor() as i32..=self.high.floor() as i32;
        let values = decades.flat_map(|k| (2..10).map(move |digit| f64::from(digit) * 10_f64.powi(k)));
        values.filter(|value| (self.low..=self.high).contains(&value.log10())).collect()
    }
}

/// `5·10⁻³`, `10⁴`, and plain numbers from 0.1 to 100.
fn scientific(digit: f64, exponent: i32) -> String {
    match exponent {
        -1 => format!("{:.2}", digit / 10.0).trim_end_matches('0').to_owned(),
        0..=2 => format!("{}", digit * 10_f64.powi(exponent)),
        _ if digit == 1.0 => format!("10{}", superscript(exponent)),
        _ => format!("{digit}·10{}", superscript(exponent)),
    }
}

/// An integer in raised digits.
pub fn superscript(number: i32) -> String {
    let raise = |c: char| match c {
        '-' => '⁻',
        digit => digit.to_digit(10).map_or(c, |k| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][k as usize]),
    };
    number.to_string().chars().map(raise).collect()
}

/// With a true minus sign.
pub fn minus(text: &str) -> String {
    text.replacen('-', "−", 1)
}

/// A marker around the origin as a path.
fn marker(style: usize) -> &'static str {
    match style % STYLES {
        0 => "M-3.4,0a3.4,3.4 0 1,0 6.8,0a3.4,3.4 0 1,0 -6.8,0z",
        1 => "M-3.1,-3.1h6.2v6.2h-6.2z",
        2 => "M0,-4.1L3.9,2.8H-3.9z",
        3 => "M0,-4.4L4.4,0L0,4.4L-4.4,0z",
        4 => "M0,4.1L3.9,-2.8H-3.9z",
        5 => "M-3.4,-1.2h2.2v-2.2h2.4v2.2h2.2v2.4h-2.2v2.2h-2.4v-2.2h-2.2z",
        _ => {
            "M-2.6,-4l2.6,2.6l2.6,-2.6l1.4,1.4l-2.6,2.6l2.6,2.6l-1.4,1.4l-2.6,-2.6l-2.6,2.6l-1.4,-1.4l2.6,-2.6l-2.6,-2.6z"
        }
    }
}

/// Line and marker of a style, for tables that explain a plot.
pub fn key(style: usize) -> Markup {
    let style = style % STYLES;
    html! {
        svg class="key" viewBox="0 0 36 12" width="36" height="12" aria-hidden="true" {
            g class={ "s" (style) } {
                path class="line" d="M1,6H35" {}
                path class="mark" d=(marker(style)) transform="translate(18 6)" {}
            }
        }
    }
}

impl Plot {
    /// The drawing; nothing but a sentence where there is nothing to draw.
    pub fn draw(&self) -> Markup {
        let data = || self.curves.iter().flat_map(|curve| &curve.data);
        let values = data().flat_map(|point| [point.y, point.low, point.high]);
        let levels = self.levels.iter().flat_map(|level| [level.value, level.high]);
        let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);
        let x = Ruler::new(self.x.scale, data().map(|point| point.x), LEFT, right);
        let y = Ruler::new(self.y.scale, self.sensible(values).into_iter().chain(levels), bottom, TOP);
        let (Some(x), Some(y)) = (x, y) else {
            return html! { p class="none" { "Nothing to draw: no value is positive." } };
        };
        html! {
            svg class="plot" viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" aria-label=(self.about) {
                title { (self.about) }
                g class="grid" {
                    @for value in x.small_ticks() { path class="small" d={ "M" (r(x.at(value))) "," (bottom) "v4" } {} }
                    @for value in y.small_ticks() { path class="small" d={ "M" (LEFT) "," (r(y.at(value))) "h-4" } {} }
                    @for (value, text) in x.ticks(7) {
                        path d={ "M" (r(x.at(value))) "," (TOP) "V" (bottom) } {}
                        text x=(r(x.at(value))) y=(bottom + 17.0) text-anchor="middle" { (text) }
                    }
                    @for (value, text) in y.ticks(8) {
                        path d={ "M" (LEFT) "," (r(y.at(value))) "H" (right) } {}
                        text x=(LEFT - 7.0) y=(r(y.at(value) + 4.0)) text-anchor="end" { (text) }
                    }
                }
                path class="frame" d={ "M" (LEFT) "," (TOP) "V" (bottom) "H" (right) } {}
                text class="axis" x=(r((LEFT + right) / 2.0)) y=(HEIGHT - 8.0) text-anchor="middle" { (self.x.label) }
                text class="axis" transform={ "translate(15 " (r((TOP + bottom) / 2.0)) ") rotate(-90)" } text-anchor="middle" {
                    (self.y.label)
                }
                @for level in &self.levels { (draw_level(level, &y, right)) }
                @for curve in &self.curves { (draw_curve(curve, &x, &y)) }
                (self.names(&y, right))
            }
        }
    }

    /// Bounds that reach more than two decades below every value, as those of noise do, are drawn to the edge only.
    fn sensible(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let values: Vec<f64> = values.filter(|y| y.is_finite()).collect();
        if self.y.scale == Scale::Linear {
            return values;
        }
        let ys = self.curves.iter().flat_map(|curve| &curve.data).map(|point| point.y);
        let least = ys.filter(|y| *y > 0.0 && y.is_finite()).fold(f64::INFINITY, f64::min);
        values.into_iter().filter(|y| *y >= 0.01 * least).collect()
    }

    /// The name of each curve at the right, at the height of its end, as far as other names leave room.
    fn names(&self, y: &Ruler, right: f64) -> Markup {
        let mut ends: Vec<(f64, usize)> = (self.curves.iter().enumerate())
            .filter_map(|(index, curve)| {
                let end = curve.data.iter().rev().find(|point| y.scale.of(point.y).is_finite())?;
                Some((y.at(end.y), index))
            })
            .collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut heights: Vec<f64> = ends.iter().map(|end| end.0).collect();
        for k in 1..heights.len() {
            heights[k] = heights[k].max(heights[k - 1] + LINE);
        }
        // What was pushed out at the bottom goes back up.
        let mut most = HEIGHT - BOTTOM;
        for height in heights.iter_mut().rev() {
            *height = height.min(most);
            most = *height - LINE;
        }
        html! {
            g class="names" {
                @for (&(end, index), height) in ends.iter().zip(&heights) {
                    g class={ "s" (self.curves[index].style % STYLES) } {
                        path class="leader" d={ "M" (r(right + 2.0)) "," (r(end)) "L" (r(right + 10.0)) "," (r(*height)) } {}
                        text x=(r(right + 13.0)) y=(r(height + 4.0)) { (self.curves[index].name) }
                    }
                }
            }
        }
    }
}

fn draw_level(level: &Level, y: &Ruler, right: f64) -> Markup {
    let (top, bottom) = (y.at(level.high), y.at(level.low));
    html! {
        g class={ "level s" (level.style % STYLES) } {
            title { (level.name) }
            rect x=(LEFT) y=(r(top)) width=(r(right - LEFT)) height=(r((bottom - top).max(0.0))) {}
            path d={ "M" (LEFT) "," (r(y.at(level.value))) "H" (right) } {}
        }
    }
}

fn draw_curve(curve: &Curve, x: &Ruler, y: &Ruler) -> Markup {
    let is_shown = |point: &&DataPoint| x.scale.of(point.x).is_finite() && y.scale.of(point.y).is_finite();
    let data: Vec<&DataPoint> = curve.data.iter().filter(is_shown).collect();
    let pixels: Vec<(f64, f64)> = data.iter().map(|point| (x.at(point.x), y.at(point.y))).collect();
    let has_band = data.iter().any(|point| point.low < point.y || point.high > point.y);
    let line: String = (pixels.iter().enumerate())
        .map(|(k, (px, py))| format!("{}{:.1},{:.1}", if k == 0 { 'M' } else { 'L' }, px, py))
        .collect();
    html! {
        g class={ "s" (curve.style % STYLES) } {
            title { (curve.name) }
            @if has_band {
                g class="bars" {
                    @for (point, (px, _)) in data.iter().zip(&pixels) {
                        path d={ "M" (r(*px)) "," (r(y.at(point.low))) "V" (r(y.at(point.high))) } {}
                    }
                }
            }
            path class="line" d=(line) {}
            @for (px, py) in &pixels {
                path class="mark" d=(marker(curve.style)) transform={ "translate(" (r(*px)) " " (r(*py)) ")" } {}
            }
        }
    }
}

/// To a tenth of a pixel.
fn r(x: f64) -> String {
    format!("{x:.1}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ruler(scale: Scale, values: &[f64]) -> Ruler {
        Ruler::new(scale, values.iter().copied(), 0.0, 100.0).unwrap()
    }

    #[test]
    fn axes_hold_all_values_and_are_numbered_sensibly() {
        let log = ruler(Scale::Log, &[1e-4, 0.3, 0.0, -2.0, f64::NAN]);
        assert!(log.at(1e-4) > 0.0 && log.at(0.3) < 100.0 && log.at(0.0) == 0.0);
        let texts = |ruler: &Ruler| ruler.ticks(7).into_iter().map(|tick| tick.1).collect::<Vec<_>>();
        assert_eq!(texts(&log), ["10⁻⁴", "10⁻³", "0.01", "0.1"].map(|t| t.replace("0.01", "10⁻²")));
        assert_eq!(texts(&ruler(Scale::Log, &[0.3, 0.8])), ["0.3", "0.5", "0.7"]);
        assert_eq!(texts(&ruler(Scale::Log, &[3.0, 30.0])), ["5", "10", "20"]);
        assert_eq!(texts(&ruler(Scale::Linear, &[-1.0, 2.0])), ["−1.0", "−0.5", "0.0", "0.5", "1.0", "1.5", "2.0"]);
        let many = ruler(Scale::Log, &[1e-12, 1e12]);
        assert!((3..=8).contains(&many.ticks(7).len()));
        // One value, and none.
        assert!(ruler(Scale::Linear, &[0.0]).ticks(7).len() > 1);
        assert!(Ruler::new(Scale::Log, [0.0, f64::NAN].into_iter(), 0.0, 1.0).is_none());
    }

    #[test]
    fn every_axis_has_two_different_numbers_at_least() {
        for exponent in -24..=24 {
            let low = 10_f64.powf(f64::from(exponent) * 0.29);
            for ratio in [1.0, 1.02, 1.3, 2.0, 3.3, 9.0, 11.0, 60.0, 1e3, 1e7, 1e20] {
                for scale in [Scale::Log, Scale::Linear] {
                    for most in [2, 4, 7, 8] {
                        let ruler = ruler(scale, &[low, low * ratio]);
                        let texts: Vec<String> = ruler.ticks(most).into_iter().map(|tick| tick.1).collect();
                        assert!(texts.len() >= 2, "{scale:?}, {low} to {}, {most}: {texts:?}", low * ratio);
                        for (index, text) in texts.iter().enumerate() {
                            assert!(!texts[index + 1..].contains(text), "{scale:?}: {texts:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn places_are_those_of_the_values() {
        let x = Ruler { scale: Scale::Log, low: 0.0, high: 2.0, from: 10.0, to: 210.0 };
        assert_eq!([1.0, 10.0, 100.0, 1e9].map(|value| x.at(value)), [10.0, 110.0, 210.0, 210.0]);
        let y = Ruler { scale: Scale::Linear, low: 0.0, high: 4.0, from: 100.0, to: 0.0 };
        assert_eq!([0.0, 1.0, 4.0].map(|value| y.at(value)), [100.0, 75.0, 0.0]);
    }

    #[test]
    fn curves_are_told_apart_without_colour() {
        let markers: std::collections::HashSet<_> = (0..STYLES).map(marker).collect();
        assert_eq!(markers.len(), STYLES);
        let curve = |name: &str, style| Curve {
            name: name.into(),
            style,
            data: vec![DataPoint::exact(1.0, 1.0), DataPoint { x: 2.0, y: 0.5, low: 0.4, high: 0.6 }],
        };
        let plot = Plot {
            about: "two <curves>".into(),
            x: Axis::log("seconds"),
            y: Axis::log("error"),
            curves: vec![curve("first & best", 0), curve("second", 1)],
            levels: vec![Level { name: "bias".into(), style: 1, value: 0.45, low: 0.44, high: 0.46 }],
        };
        let svg = plot.draw().into_string();
        assert!(svg.contains("first &amp; best") && svg.contains("two &lt;curves&gt;") && !svg.contains("NaN"));
        // Names that would lie on each other are apart.
        let start = format!("<text x=\"{:.1}\" y=\"", WIDTH - RIGHT + 13.0);
        let heights: Vec<f64> = (svg.split("class=\"names\"").nth(1).unwrap().split(&start).skip(1))
            .map(|rest| rest[..rest.find('"').unwrap()].parse().unwrap())
            .collect();
        assert!(heights.len() == 2 && (heights[1] - heights[0]).abs() >= LINE, "{heights:?}");
        let empty = Plot { curves: Vec::new(), levels: Vec::new(), ..plot };
        assert!(empty.draw().into_string().contains("Nothing to draw"));
    }
}
