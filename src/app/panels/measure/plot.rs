//! Errors on log–log axes. Modes differ in colour, marker and kind of line.

use egui::{Ui, Vec2b, vec2};
use egui_plot::{
    AxisHints, GridInput, GridMark, HoverPosition, Line, LineStyle, MarkerShape, Plot, PlotPoints, Points,
};

use super::ticks;
use crate::app::measurement::{Curve, ErrorAxis, Point};
use crate::app::state::State;
use crate::app::theme::Palette;
use crate::export::words::duration;
use crate::tracking::Mode;

/// Width over height.
const ASPECT: f32 = 1.25;
/// Room for one number at the axis to the right and at the one upwards, in points.
const X_ROOM: f32 = 56.0;
const Y_ROOM: f32 = 26.0;

/// Markers, as characters and in the plot, and lines of the modes in their order; the last are for modes to come.
const LOOKS: [(&str, MarkerShape, LineStyle); 8] = [
    ("●", MarkerShape::Circle, LineStyle::Dashed { length: 8.0 }),
    ("▲", MarkerShape::Up, LineStyle::Dashed { length: 6.0 }),
    ("■", MarkerShape::Square, LineStyle::Dashed { length: 4.0 }),
    ("◆", MarkerShape::Diamond, LineStyle::Dotted { spacing: 5.0 }),
    ("+", MarkerShape::Plus, LineStyle::Dashed { length: 12.0 }),
    ("×", MarkerShape::Cross, LineStyle::Solid),
    ("*", MarkerShape::Asterisk, LineStyle::Dotted { spacing: 8.0 }),
    ("▼", MarkerShape::Down, LineStyle::Dotted { spacing: 3.0 }),
];

/// The look of a mode.
pub fn look(mode: Mode) -> (&'static str, MarkerShape, LineStyle) {
    LOOKS[mode as usize % LOOKS.len()]
}

/// The points of a curve that a logarithm has, as powers of ten.
pub fn logarithms(curve: &Curve, state: &State) -> Vec<[f64; 2]> {
    let x = |point: &Point| match state.settings.error_axis {
        ErrorAxis::Time => point.seconds,
        ErrorAxis::Samples => f64::from(point.samples),
    };
    (curve.points.iter())
        .filter_map(|point| Some([x(point), point.error(state.settings.error_metric)?]))
        .filter(|point| point.iter().all(|x| *x > 0.0 && x.is_finite()))
        .map(|point| point.map(f64::log10))
        .collect()
}

pub fn show(ui: &mut Ui, state: &State, curves: &[(Mode, &Curve)]) {
    let palette = Palette::of(ui);
    let (metric, axis) = (state.settings.error_metric, state.settings.error_axis);
    let x_axis = AxisHints::new_x().formatter(move |mark, _| number(mark, |x| ticks::text(axis, x)));
    let y_axis = AxisHints::new_y().min_thickness(34.0).formatter(|mark, _| number(mark, |x| format!("{x:.0e}")));
    let all: Vec<[f64; 2]> = curves.iter().flat_map(|(_, curve)| logarithms(curve, state)).collect();
    let [x_range, y_range] = [0, 1].map(|side| at_least_a_decade(all.iter().map(|point| point[side])));
    let size = vec2(ui.available_width(), ui.available_width() / ASPECT);
    Plot::new("errors")
        .width(size.x)
        .height(size.y)
        .custom_x_axes(vec![x_axis])
        .custom_y_axes(vec![y_axis])
        .grid_color(palette.weak_text.gamma_multiply(0.6))
        .x_grid_spacer(move |input| marks(input, (size.x / X_ROOM) as usize))
        .y_grid_spacer(move |input| marks(input, (size.y / Y_ROOM) as usize))
        .auto_bounds(Vec2b::TRUE)
        .include_x(x_range[0])
        .include_x(x_range[1])
        .include_y(y_range[0])
        .include_y(y_range[1])
        .set_margin_fraction(vec2(0.06, 0.08))
        // The wheel scrolls the panel; a plot that moves away would have to be brought back.
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .show_crosshair(false)
        .label_formatter(move |hovered| match hovered {
            HoverPosition::NearDataPoint { plot_name, position, .. } => {
                let x = 10_f64.powf(position.x);
                let x = match axis {
                    ErrorAxis::Time => duration(x),
                    ErrorAxis::Samples => format!("{x:.0} spp"),
                };
                Some(format!("{plot_name}\n{x}: {} {:.2e}", metric.name(), 10_f64.powf(position.y)))
            }
            HoverPosition::Elsewhere { .. } => None,
        })
        .show(ui, |plot| {
            for (mode, curve) in curves {
                let points = logarithms(curve, state);
                let color = palette.mode(*mode);
                let (_, shape, style) = look(*mode);
                let name = mode.name();
                if let (Some(bias), [first, .., last]) = (curve.trend(metric).bias, &points[..]) {
                    let level = vec![[first[0], bias.log10()], [last[0], bias.log10()]];
                    let line = Line::new(format!("bias of {name}"), PlotPoints::from(level)).width(1.0);
                    plot.line(line.color(color.gamma_multiply(0.7)).style(LineStyle::Dotted { spacing: 4.0 }));
                }
                plot.line(Line::new(name, PlotPoints::from(points.clone())).color(color).style(style).width(1.5));
                plot.points(Points::new(name, PlotPoints::from(points)).color(color).shape(shape).radius(3.5));
            }
        });
}

/// The range of `logarithms`, widened on both sides where less than a decade would be seen: two marks at least can then be read.
fn at_least_a_decade(logarithms: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = logarithms.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    if low > high {
        return [0.0, 1.0];
    }
    let missing = (1.0 - (high - low)).max(0.0);
    [low - missing / 2.0, high + missing / 2.0]
}

/// Powers of ten, and between them 2 and 5, as far as the plot goes: marks beyond would have their texts in what lies around it. At most
/// `most` of them have a number.
fn marks(input: GridInput, most: usize) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let span = high - low;
    let numbered = ticks::numbered(low, high, most);
    let (first, last) = (low.floor() as i32, high.ceil() as i32);
    let factors: &[f64] = if span > 6.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let all = (first..=last).flat_map(|decade| factors.iter().map(move |factor| f64::from(decade) + factor.log10()));
    let is_numbered = |value: f64| numbered.iter().any(|other| (other - value).abs() < 1e-6);
    let plain = all.filter(|value| (low..=high).contains(value) && !is_numbered(*value));
    let mut marks: Vec<GridMark> = plain.map(|value| GridMark { value, step_size: 0.3 }).collect();
    // Numbers are shown whatever the distance of their marks, for which there is room.
    marks.extend(numbered.iter().map(|&value| GridMark { value, step_size: span.max(1.0) }));
    marks
}

/// The number at a mark, if it has one.
fn number(mark: GridMark, text: impl Fn(f64) -> String) -> String {
    if mark.step_size >= 1.0 { text(10_f64.powf(mark.value)) } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decade_is_seen_at_least() {
        let seen = |logarithms: &[f64]| at_least_a_decade(logarithms.iter().copied());
        assert_eq!(seen(&[2.0]), [1.5, 2.5]);
        assert_eq!(seen(&[0.25, -0.25]), [-0.5, 0.5]);
        assert_eq!(seen(&[-3.0, 1.0]), [-3.0, 1.0]);
        assert_eq!(seen(&[]), [0.0, 1.0]);
    }

    #[test]
    fn marks_are_at_1_2_5() {
        let marks = marks(GridInput { bounds: (-1.2, 0.3), base_step_size: 0.1 }, 9);
        let mut values: Vec<f64> = marks.iter().map(|mark| 10_f64.powf(mark.value)).collect();
        values.sort_by(f64::total_cmp);
        let expected = [0.1, 0.2, 0.5, 1.0];
        assert!(
            values.len() == 4 && values.iter().zip(expected).all(|(x, e)| (x / e - 1.0).abs() < 1e-9),
            "{values:?}"
        );
    }

    #[test]
    fn two_marks_have_a_number_whatever_was_measured() {
        let width = 220.0_f64;
        for data in [vec![0.37], vec![-3.1, -3.0], vec![-0.4, 0.9], vec![-5.2, 4.9], vec![-0.02, 1.28], vec![0.0, 2.1]]
        {
            let [low, high] = at_least_a_decade(data.iter().copied());
            let margin = 0.06 * (high - low);
            let bounds = (low - margin, high + margin);
            for room in [f64::from(X_ROOM), f64::from(Y_ROOM)] {
                let marks = marks(GridInput { bounds, base_step_size: 0.1 }, (width / room) as usize);
                let texts: Vec<String> = marks.into_iter().map(|m| number(m, |x| format!("{x:.0e}"))).collect();
                assert!(texts.iter().filter(|text| !text.is_empty()).count() >= 2, "{data:?}");
            }
        }
    }

    #[test]
    fn modes_look_different() {
        for (index, a) in Mode::ALL.into_iter().enumerate() {
            assert!(Mode::ALL[index + 1..].iter().all(|b| look(a).0 != look(*b).0 && look(a).1 != look(*b).1));
        }
    }
}
