//! Tables of error against run time.

use serde::Serialize;

use super::Table;
use crate::measure::Interval;
use crate::report::data::Report;
use crate::report::experiment::{Curve, Technique};

/// Every curve with its scene's name.
fn all(report: &Report) -> impl Iterator<Item = (&str, &Curve)> {
    report
        .scenes
        .iter()
        .filter_map(|scene| Some((scene.name.as_str(), scene.errors.as_ref()?)))
        .flat_map(|(name, found)| found.curves.iter().map(move |curve| (name, curve)))
}

/// Scene, mode and technique, which every table begins with.
fn start<'a>(scene: &'a str, curve: &Curve) -> impl Serialize + use<'a> {
    (scene, curve.mode, technique(curve.technique))
}

const START: [(&str, &str); 3] = [
    ("scene", "name of the scene"),
    ("mode", "how media are tracked"),
    (
        "technique",
        "independent: samples that know nothing of each other, evenly spread; shipped: the program's defaults",
    ),
];

fn technique(technique: Technique) -> &'static str {
    if technique == Technique::shipped() { "shipped" } else { "independent" }
}

/// Value, lower and upper end; empty where there is none.
fn bounds(interval: Option<Interval>) -> [Option<f64>; 3] {
    [interval.map(|i| i.value), interval.map(|i| i.low), interval.map(|i| i.high)]
}

/// Every run at every number of samples.
pub fn runs(report: &Report) -> Option<Table> {
    let points = all(report).flat_map(|(scene, curve)| curve.points.iter().map(move |point| (scene, curve, point)));
    let rows = points.flat_map(|(scene, curve, point)| {
        point.runs.iter().map(move |run| {
            let secs = [run.render_secs, curve.secs_before];
            let figures = [run.relmse, run.relmse_trimmed, run.relmse_steady, run.mse, run.smape];
            (start(scene, curve), run.seed, point.spp, secs, figures, run.flip)
        })
    });
    let columns = [
        ("seed", "seed of the run"),
        ("spp", "samples per pixel"),
        ("render_secs", "seconds of rendering so far"),
        ("secs_before", "seconds before the first sample: rectification, of modes that need it"),
        ("relmse", "mean of (x − r₁)(x − r₂)/(r² + 0.01); can be below 0 by chance"),
        ("relmse_trimmed", "the same without the worst 0.1 % of pixels"),
        (
            "relmse_steady",
            "relmse without the 0.1 % of pixels in which the run's four quarters differ the most, at every number of samples the same; slopes are of this",
        ),
        ("mse", "mean of (x − r₁)(x − r₂)"),
        ("smape", "mean of 2|x − r|/(|x| + |r| + 0.01)"),
        ("flip", "mean HDR-FLIP; empty where it was not taken"),
    ];
    Table::new(
        "error-runs.csv",
        "Error of every run at every number of samples",
        START.into_iter().chain(columns),
        rows,
    )
}

/// Means over the runs.
pub fn points(report: &Report) -> Option<Table> {
    let points = all(report).flat_map(|(scene, curve)| curve.points.iter().map(move |point| (scene, curve, point)));
    let rows = points.map(|(scene, curve, point)| {
        let figures = [point.relmse, point.relmse_trimmed, point.mse, point.smape, point.flip, point.efficiency];
        (start(scene, curve), point.spp, point.secs, figures.map(bounds), point.variance, point.bias_squared)
    });
    let columns = [
        ("spp", "samples per pixel"),
        ("secs", "geometric mean of the seconds, those before the first sample included"),
        ("relmse", "geometric mean over the seeds"),
        ("relmse_low", "lower end of its 95 % t-interval on the logarithm"),
        ("relmse_high", "its upper end"),
        ("relmse_trimmed", "the same without the worst 0.1 % of pixels"),
        ("relmse_trimmed_low", "lower end"),
        ("relmse_trimmed_high", "upper end"),
        ("mse", "mean squared error"),
        ("mse_low", "lower end"),
        ("mse_high", "upper end"),
        ("smape", "symmetric mean absolute percentage error, as a fraction"),
        ("smape_low", "lower end"),
        ("smape_high", "upper end"),
        ("flip", "mean HDR-FLIP"),
        ("flip_low", "lower end"),
        ("flip_high", "upper end"),
        ("efficiency", "1/(relMSE · seconds of rendering)"),
        ("efficiency_low", "lower end"),
        ("efficiency_high", "upper end"),
        ("variance", "of one run, in relMSE"),
        ("bias_squared", "what all seeds share, in relMSE; scatters about 0 without a bias"),
    ];
    Table::new(
        "error-points.csv",
        "Error against time: means over the seeds with their intervals",
        START.into_iter().chain(columns),
        rows,
    )
}

/// What the curves come to.
pub fn curves(report: &Report) -> Option<Table> {
    let rows = all(report).map(|(scene, curve)| {
        let (slope, bias, plateau) = (curve.slope, curve.bias, curve.plateau);
        let slope = (bounds(slope.map(|s| s.trimmed)), slope.map(|s| s.from_spp), slope.map(|s| s.to_spp));
        let bias = (bounds(Some(bias.squared)), bias.significance, bias.brightness, bias.is_biased);
        let plateau = (
            bounds(plateau.map(|p| p.relmse)),
            plateau.map(|p| p.spp),
            plateau.map(|p| p.secs),
            bounds(plateau.and_then(|p| p.measured_over_predicted)),
        );
        (start(scene, curve), curve.equal_to, slope, bias, plateau)
    });
    let columns = [
        (
            "equal_to",
            "the mode whose images these equal, to the last bit, and whose numbers these are, times too; empty for none",
        ),
        ("slope", "relmse_steady ~ samples^slope, fitted to each seed of error-runs.csv for itself: mean"),
        ("slope_low", "lower end of its 95 % t-interval over the seeds"),
        ("slope_high", "its upper end"),
        ("slope_from_spp", "the first number of samples that the line goes through"),
        ("slope_to_spp", "the last"),
        ("bias_squared", "in relMSE, from the mean over the seeds"),
        ("bias_squared_low", "lower end of its 95 % interval"),
        ("bias_squared_high", "its upper end"),
        ("significance", "bias_squared in standard deviations of what chance does"),
        ("brightness", "mean of image − reference over the reference's mean"),
        ("is_biased", "whether the significance is beyond 4"),
        ("plateau", "where the relMSE of a biased mode stays"),
        ("plateau_low", "lower end"),
        ("plateau_high", "upper end"),
        ("plateau_spp", "samples per pixel at which noise is as large as bias"),
        ("plateau_secs", "seconds at which it is"),
        ("measured_over_predicted", "last relMSE over what bias and variance of other seeds predict"),
        ("measured_over_predicted_low", "lower end"),
        ("measured_over_predicted_high", "upper end"),
    ];
    Table::new("error-curves.csv", "Slope, bias and plateau of each mode", START.into_iter().chain(columns), rows)
}

/// Differences of modes.
pub fn pairs(report: &Report) -> Option<Table> {
    let scenes = report.scenes.iter().filter_map(|scene| Some((&scene.name, scene.errors.as_ref()?)));
    let pairs = scenes.flat_map(|(scene, found)| found.pairs.iter().map(move |pair| (scene, pair)));
    let rows = pairs.flat_map(|(scene, pair)| {
        pair.points.iter().map(move |point| {
            let variances = [point.of_mode, point.of_against, point.of_difference];
            (scene, pair.mode, pair.against, technique(pair.technique), point.spp, variances)
        })
    });
    let columns = [
        ("scene", "name of the scene"),
        ("mode", "the first mode"),
        ("against", "the second"),
        ("technique", "as in the other tables"),
        ("spp", "samples per pixel"),
        ("of_mode", "variance of the first mode's image, over the reference's square plus 0.01"),
        ("of_against", "of the second's"),
        ("of_difference", "of their difference"),
    ];
    let about = "Variances of two modes' images and of their difference, by the same random numbers";
    Table::new("error-pairs.csv", about, columns, rows)
}
