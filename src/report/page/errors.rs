//! Error against run time of one scene: plot, what the curves come to, and how much sooner differences of modes converge.

use maud::{Markup, html};

use super::plot::{Axis, Curve as Line, DataPoint, Level, Plot, key};
use super::words::{fixed, interval, number, table, time, verdict};
use crate::measure::Interval;
use crate::report::data::{Report, SceneReport};
use crate::report::experiment::{Curve, Pair, SceneErrors, Technique};
use crate::tracking::Mode;

/// The look of each mode, everywhere on the page.
pub fn style_of(mode: Mode) -> usize {
    // Of the modes in their order.
    // `declared` is in no report.
    const STYLES: [usize; 7] = [1, 1, 3, 4, 5, 0, 6];
    STYLES[mode as usize % STYLES.len()]
}

/// The look of `rectified` as the program ships it.
const SHIPPED: usize = 2;

fn is_shipped(curve: &Curve) -> bool {
    curve.technique == Technique::shipped()
}

fn name_of(curve: &Curve) -> String {
    if is_shipped(curve) { "as shipped".to_owned() } else { curve.mode.name().to_owned() }
}

fn look_of(curve: &Curve) -> usize {
    if is_shipped(curve) { SHIPPED } else { style_of(curve.mode) }
}

/// How all of it was measured, once for all scenes.
pub fn method(report: &Report) -> Markup {
    let Some(found) = report.scenes.iter().find_map(|scene| scene.errors.as_ref()) else { return html! {} };
    let seeds = found.plan.seeds.len();
    html! {
        details open {
            summary { "How error is measured, and how to read the plots" }
            p {
                "Each mode renders the scene " (seeds) " times with different seeds, with samples that know nothing of each other and are spread evenly over the pixels; "
                "sample counts double. Error is relMSE, the mean over pixels and channels of (x − r)²/(r² + 0.01), without the worst 0.1 % of pixels (where an image has a "
                "thousand), so that a few bright ones do not decide it. The reference r is made in mode " code { "reference" }
                ", twice and independently, with other seeds; with (x − r₁)(x − r₂) for the square, the noise of the references cancels in the mean. "
                "Points are geometric means over the seeds, bars their 95 % t-intervals on the logarithm. Time is that of rendering on " (found.threads)
                " threads, with rectification's time added to the modes that need it, and without the tree's, which all need."
            }
            p {
                "An image without a bias gets better for ever: on these axes its error falls with a slope of −1 in the number of samples. That of a wrong mode falls until noise is "
                "as large as the bias and stays there: on its " em { "plateau" } ", the dotted line in the mode's colour with its 95 % band, which is computed from the mean of all seeds and "
                "not from the curve. The slope is fitted to each seed for itself, against samples, and without the same 0.1 % of pixels all along (those in which the four quarters of its samples differ the most): "
                "were they chosen anew at each number of samples, the trimmed error of an unbiased image would not fall as 1/samples. Its interval is over the seeds. “As shipped” is "
                code { "rectified" } " with the program's defaults: Sobol points, and samples spread to where they pay. It is unbiased too, and mostly falls faster."
            }
        }
    }
}

pub fn of_scene(scene: &SceneReport, found: &SceneErrors) -> Markup {
    let [width, height] = found.plan.size;
    html! {
        p class="muted" {
            "Measured at " (width) "×" (height) ", " (found.plan.spp.first().copied().unwrap_or(0)) " to " (found.plan.largest_spp())
            " samples per pixel; two references of " (found.reference.spp) " samples, whose own noise is relMSE " (number(found.reference.relmse)) "."
        }
        div class="plots" {
            figure {
                figcaption { "Error against time" }
                (error_plot(scene, found).draw())
            }
            @if let Some(plot) = pair_plot(scene, found) {
                figure {
                    figcaption { "How soon a difference of modes converges" }
                    (plot.draw())
                }
            }
        }
        (curves_table(found))
        (pairs_table(&found.pairs))
    }
}

/// Trimmed relMSE over seconds, with the plateaus.
fn error_plot(scene: &SceneReport, found: &SceneErrors) -> Plot {
    let drawn: Vec<&Curve> = found.curves.iter().filter(|curve| curve.equal_to.is_none()).collect();
    let lines = drawn.iter().map(|curve| Line {
        name: name_of(curve),
        style: look_of(curve),
        data: (curve.points.iter())
            .filter_map(|point| {
                let error = point.relmse_trimmed?;
                Some(DataPoint { x: point.secs, y: error.value, low: error.low, high: error.high })
            })
            .collect(),
    });
    let levels = drawn.iter().filter_map(|curve| {
        let plateau = curve.plateau?;
        // The interval is that of all pixels; without the brightest it is as wide for its height.
        let share = plateau.relmse_trimmed / plateau.relmse.value;
        Some(Level {
            name: format!("plateau of {}: {}", name_of(curve), number(plateau.relmse_trimmed)),
            style: look_of(curve),
            value: plateau.relmse_trimmed,
            low: plateau.relmse.low * share,
            high: plateau.relmse.high * share,
        })
    });
    Plot {
        about: format!("{}: relative error of each mode against seconds of rendering", scene.title),
        x: Axis::log("seconds"),
        y: Axis::log("relMSE, trimmed"),
        levels: levels.collect(),
        curves: lines.collect(),
    }
}

/// Variances of the pair that differs most.
fn pair_plot(scene: &SceneReport, found: &SceneErrors) -> Option<Plot> {
    let pair = found.pairs.iter().max_by(|a, b| {
        let of = |pair: &Pair| pair.points.last().map_or(0.0, |point| point.of_mode);
        of(a).total_cmp(&of(b))
    })?;
    let line = |name: String, style, value: fn(&crate::report::experiment::PairPoint) -> f64| Line {
        name,
        style,
        data: pair.points.iter().map(|point| DataPoint::exact(f64::from(point.spp), value(point))).collect(),
    };
    Some(Plot {
        about: format!("{}: variance of {}, of {}, and of their difference", scene.title, pair.mode, pair.against),
        x: Axis::log("samples per pixel"),
        y: Axis::log("relative variance"),
        curves: vec![
            line(pair.mode.name().to_owned(), style_of(pair.mode), |point| point.of_mode),
            line(pair.against.name().to_owned(), style_of(pair.against), |point| point.of_against),
            line("difference".to_owned(), 6, |point| point.of_difference),
        ],
        levels: Vec::new(),
    })
}

fn maybe(value: Option<&Interval>, show: impl Fn(f64) -> String) -> Markup {
    html! { @match value { Some(value) => (interval(value, show)), None => "–" } }
}

fn curves_table(found: &SceneErrors) -> Markup {
    table(
        Some("curves"),
        "What the curves come to. The last error is that at the greatest number of samples; of a biased mode it is also given over what bias and variance of other seeds predict.",
        &[
            ("mode", ""),
            ("slope", "n"),
            ("last error", "n"),
            ("after", "n"),
            ("FLIP", "n"),
            ("bias", ""),
            ("bias², relMSE", "n"),
            ("plateau from", "n"),
            ("over predicted", "n"),
            ("efficiency, 1/s", "n"),
        ],
        &html! { @for curve in &found.curves { (curve_row(curve)) } },
    )
}

fn curve_row(curve: &Curve) -> Markup {
    let label = html! { (key(look_of(curve))) (name_of(curve)) };
    if let Some(other) = curve.equal_to {
        return html! {
            tr { th scope="row" { (label) } td colspan="9" { "gives the images of " code { (other) } ", to the last bit: not drawn again" } }
        };
    }
    let last = curve.points.last();
    let share = |x: f64| fixed(x, 2);
    html! {
        tr {
            th scope="row" { (label) }
            td class="n" { (maybe(curve.slope.as_ref().map(|slope| &slope.trimmed), share)) }
            td class="n" { (maybe(last.and_then(|point| point.relmse_trimmed.as_ref()), number)) }
            td class="n" { @match last { Some(point) => (time(point.secs)), None => "–" } }
            td class="n" { @match last.and_then(|point| point.flip) { Some(flip) => (number(flip.value)), None => "–" } }
            td {
                @if curve.bias.is_biased { (verdict(Some(false), "biased")) } @else { (verdict(Some(true), "none seen")) }
                " " span class="interval" { (fixed(curve.bias.significance, 1)) " σ" }
            }
            td class="n" { (interval(&curve.bias.squared, number)) }
            td class="n" { @match &curve.plateau { Some(plateau) => (time(plateau.secs)), None => "–" } }
            td class="n" { (maybe(curve.plateau.as_ref().and_then(|plateau| plateau.measured_over_predicted.as_ref()), share)) }
            td class="n" { (maybe(last.and_then(|point| point.efficiency.as_ref()), number)) }
        }
    }
}

fn pairs_table(pairs: &[Pair]) -> Markup {
    if pairs.is_empty() {
        return html! {};
    }
    table(
        None,
        "Differences of modes, rendered with the same random numbers: how many times sooner the image of the difference is as exact as each image, \
         and as the difference of images with unrelated numbers.",
        &[("difference", ""), ("than the first", "n"), ("than the second", "n"), ("than unrelated", "n")],
        &html! { @for pair in pairs {
            tr {
                th scope="row" { (pair.mode) " − " (pair.against) }
                @for sooner in [pair.sooner_than_mode, pair.sooner_than_against, pair.sooner_than_unpaired] {
                    td class="n" { (maybe(sooner.as_ref(), number)) }
                }
            }
        } },
    )
}
