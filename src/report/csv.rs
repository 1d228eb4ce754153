//! The report's tables as CSV, each with words about its columns.

use serde::Serialize;

use super::backends::ModeBackends;
use super::data::Report;
use super::estimators::{Level, WayErrors};
use super::growth::Exponent;
use super::stability::Measurement;
use super::timing::Ratio;
use crate::export::csv::text;
use crate::render::Estimator;

mod errors;

#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of the file, beside the page.
    pub file: &'static str,
    pub about: &'static str,
    /// Each column's name and what it holds.
    pub columns: Vec<(&'static str, &'static str)>,
    pub text: String,
}

impl Table {
    /// `None` without rows.
    fn new(
        file: &'static str,
        about: &'static str,
        columns: impl IntoIterator<Item = (&'static str, &'static str)>,
        rows: impl Iterator<Item: Serialize>,
    ) -> Option<Self> {
        let mut rows = rows.peekable();
        rows.peek()?;
        let columns = Vec::from_iter(columns);
        let text = text(columns.iter().map(|(name, _)| *name), rows);
        Some(Self { file, about, columns, text })
    }
}

pub fn tables(report: &Report) -> Vec<Table> {
    let all = [
        errors::runs(report),
        errors::points(report),
        errors::curves(report),
        errors::pairs(report),
        stability(report),
        maps(report),
        left_out(report),
        editing(report),
        first_look(report),
        estimators(report),
        backends(report),
        frames(report),
        growth(report),
        exponents(report),
    ];
    all.into_iter().flatten().collect()
}

/// The cells from `what` to `unit`; empty without a measurement.
fn cells(measurement: Option<&Measurement>) -> impl Serialize {
    let number = |of: fn(&Measurement) -> f64| measurement.map(of);
    (
        measurement.map(|m| &m.what),
        [number(|m| m.expected), number(|m| m.measured), number(|m| m.error)],
        measurement.map(|m| m.kind),
        [number(|m| m.bound), number(|m| m.noise)],
        measurement.map(|m| &m.unit),
    )
}

/// The outcome of one measurement, and why it did not pass.
fn verdict(measurement: &Measurement) -> (&str, &str) {
    if measurement.is_within_bound() { ("passed", "") } else { ("failed", measurement.limit.as_deref().unwrap_or("")) }
}

fn stability(report: &Report) -> Option<Table> {
    let found = report.stability.iter();
    let by_paths = found.clone().flat_map(|found| &found.cases).map(|case| (Estimator::Path, case));
    let by_others = (found.clone().flat_map(|found| &found.by_estimators))
        .flat_map(|by| by.cases.iter().map(|case| (by.estimator, case)));
    let cases = by_paths.chain(by_others).flat_map(|(by, case)| {
        let row =
            move |at, measurement, verdict| (("case", case.number, &case.name, by, at), cells(measurement), verdict);
        let none_measured =
            case.measurements.is_empty().then(|| row(None, None, (case.outcome.name(), case.outcome.reason())));
        case.measurements.iter().map(move |m| row(None, Some(m), verdict(m))).chain(none_measured)
    });
    let sweeps = found.flat_map(|found| &found.sweeps).flat_map(|sweep| {
        sweep.steps.iter().map(move |step| {
            let at = step.label.clone().unwrap_or_else(|| format!("{:e}", step.x));
            let measurement = &step.measurement;
            (("sweep", None, &sweep.name, Estimator::Path, Some(at)), cells(Some(measurement)), verdict(measurement))
        })
    });
    let rows = cases.chain(sweeps);
    let columns = [
        ("check", "case or sweep"),
        ("number", "number of the case; empty for those beyond the forty, and for sweeps"),
        ("name", "name of the case or sweep"),
        ("estimator", "how light is transported in its images"),
        ("at", "where in the sweep"),
        ("what", "what was measured"),
        ("expected", "the closed form's value"),
        ("measured", "what the program gave"),
        ("error", "how far apart the two are"),
        ("error_kind", "absolute or relative"),
        ("bound", "the largest error allowed, next to four times the noise"),
        ("noise", "standard error of what is random"),
        ("unit", "unit of the values"),
        ("outcome", "passed, failed or not run"),
        ("reason", "why not passed, where that is known"),
    ];
    Table::new("stability.csv", "Every measurement of the stiff and extreme cases and of the sweeps", columns, rows)
}

fn maps(report: &Report) -> Option<Table> {
    let maps = report.stability.iter().flat_map(|found| &found.maps);
    let rows = maps.flat_map(|map| {
        map.rows.iter().zip(&map.relative_errors).flat_map(move |(row, errors)| {
            let known = map.etas.iter().zip(errors).filter_map(|(eta, error)| Some((eta, (*error)?)));
            known.map(move |(eta, error)| (&map.formula, &map.quantity, eta, &map.row_parameter, row, error))
        })
    });
    let columns = [
        ("formula", "how it was computed"),
        ("quantity", "reflectance or transmittance"),
        ("eta", "index behind the interface over that before it"),
        ("row_parameter", "what the next column is"),
        ("row", "the angle, as the column before says"),
        ("relative_error", "against an evaluation with twice the digits"),
    ];
    Table::new("fresnel-maps.csv", "Relative errors of Fresnel's equations over index and angle", columns, rows)
}

fn left_out(report: &Report) -> Option<Table> {
    let measured = report.scenes.iter().filter_map(|scene| Some((&scene.name, scene.left_out.as_ref()?)));
    let rows = measured.flat_map(|(scene, found)| {
        let row = move |what: &str, task, ratio: &Ratio, is_equal: bool| {
            let Ratio { median, low, high, confidence, pairs, above_secs, below_secs } = *ratio;
            let ratio = [median, low, high, confidence, above_secs, below_secs];
            (scene, what.to_owned(), task, ratio, pairs, is_equal)
        };
        let all = row(&found.left_out.join(" "), "render", &found.render, found.images_are_equal);
        let rectify = found.rectify.as_ref().zip(found.tables_are_equal);
        let each = found.each.iter().map(move |one| row(&one.need, "render", &one.ratio, one.images_are_equal));
        let rectify = rectify.map(|(ratio, is_equal)| row("nesting", "rectify", ratio, is_equal));
        std::iter::once(all).chain(rectify).chain(each)
    });
    let columns = [
        ("scene", "name of the scene"),
        ("left_out", "what is put back, in names separated by spaces: all that the scene does not need, or one of it"),
        ("task", "render or rectify"),
        ("ratio", "time with what is left out over time without: median of the pairs' ratios"),
        ("ratio_low", "lower end of an interval for the true median, which supposes no distribution"),
        ("ratio_high", "its upper end"),
        ("confidence", "probability that the interval holds it"),
        ("with_secs", "median seconds of a slice of work with it"),
        ("without_secs", "median seconds of the same slice without"),
        ("pairs", "pairs of slices, taken by turns"),
        ("equal", "whether both ways gave the same image, or the same answers, to the last bit"),
    ];
    Table::new("left-out.csv", "What a scene does not need, and the time with it over the time without", columns, rows)
}

fn editing(report: &Report) -> Option<Table> {
    let measured = report.scenes.iter().filter_map(|scene| Some((&scene.name, scene.editing.as_ref()?)));
    let rows = measured.flat_map(|(scene, found)| {
        found.times.iter().map(move |times| {
            let seconds = (times.rectify_secs, times.image_secs, times.worst_secs);
            (scene, times.edit, times.edits, seconds, times.width, found.size)
        })
    });
    let columns = [
        ("scene", "name of the scene"),
        ("edit", "what is edited: ior, transform or camera"),
        ("edits", "how many were timed"),
        ("rectify_secs", "median seconds of rectifying the edited scene; empty where it need not be"),
        ("image_secs", "median seconds until each of four panes had a new image"),
        ("worst_secs", "the longest of those times"),
        ("first_width", "pixels across the coarsest of the first images, which are refined from there"),
        ("pane_width", "pixels across a pane"),
        ("pane_height", "pixels down a pane"),
    ];
    Table::new("editing.csv", "How long the picture takes to follow an edit", columns, rows)
}

fn estimators(report: &Report) -> Option<Table> {
    let measured = report.scenes.iter().filter_map(|scene| Some((&scene.name, scene.estimators.as_ref()?)));
    let rows = measured.flat_map(|(scene, found)| {
        let of_way = move |one: &WayErrors| {
            let (estimator, adaptive, chosen) = (one.way.estimator, one.way.adaptive, found.chosen);
            let of_level = |level: &Level| {
                (scene, estimator, adaptive, chosen, found.size, level.samples, level.secs, level.relmse, level.trimmed)
            };
            one.levels.iter().map(of_level).collect::<Vec<_>>()
        };
        found.ways.iter().flat_map(of_way).collect::<Vec<_>>()
    });
    let columns = [
        ("scene", "name of the scene"),
        ("estimator", "how light is transported"),
        ("adaptive", "whether samples go where they matter"),
        ("chosen", "the estimator that `auto` chooses, which has made the truth"),
        ("width", "pixels across"),
        ("height", "pixels down"),
        ("samples", "samples per pixel"),
        ("secs", "seconds of rendering, mean over the runs"),
        ("relmse", "mean squared error relative to radiance, mean over the runs"),
        ("relmse_trimmed", "the same without the worst 0.1 % of the pixels"),
    ];
    Table::new("estimators.csv", "Error against time of each estimator", columns, rows)
}

fn backends(report: &Report) -> Option<Table> {
    let measured = report.scenes.iter().filter_map(|scene| Some((&scene.name, scene.backends.as_ref()?)));
    let rows = measured.flat_map(|(scene, found)| {
        let row = move |one: &ModeBackends| {
            (scene, one.mode, &found.adapter, found.size, one.cpu, one.gpu, one.parted, one.mean_ratio)
        };
        found.modes.iter().map(row)
    });
    let columns = [
        ("scene", "name of the scene"),
        ("mode", "how media are tracked"),
        ("adapter", "name and interface of the graphics processor"),
        ("width", "pixels across"),
        ("height", "pixels down"),
        ("cpu_samples_per_sec", "pixel samples a second by the CPU, without splits"),
        ("gpu_samples_per_sec", "the same by the graphics processor"),
        ("parted", "share of the pixels that differ by more than rounding"),
        ("mean_ratio", "mean of the graphics processor's image over that of the CPU's"),
    ];
    Table::new(
        "backends.csv",
        "Speed of the CPU and of the graphics processor, and how far their images are apart",
        columns,
        rows,
    )
}

fn first_look(report: &Report) -> Option<Table> {
    let measured = report.scenes.iter().filter_map(|scene| Some((&scene.name, scene.first_look.as_ref()?)));
    let rows = measured.flat_map(|(scene, look)| {
        look.modes.iter().flat_map(move |mode| {
            let settings = (look.size, look.converged_samples, look.prepare_secs);
            mode.points.iter().map(move |point| {
                let clean = (mode.clean_secs, mode.clean_samples);
                (scene, mode.mode, point.samples, point.secs, point.flip, clean, settings)
            })
        })
    });
    let columns = [
        ("scene", "name of the scene"),
        ("mode", "mode of the picture"),
        ("samples", "samples per pixel"),
        ("secs", "seconds that all modes together had been rendered by then"),
        ("flip", "mean FLIP against the converged image"),
        ("clean_secs", "seconds by which FLIP was below 0.05, interpolated; empty where it was given up before"),
        ("clean_samples", "samples per pixel by then"),
        ("width", "pixels across the picture"),
        ("height", "pixels down the picture"),
        ("converged_samples", "samples per pixel of the converged image, which has another seed"),
        ("prepare_secs", "seconds of building the tree and of rectification, which come before"),
    ];
    Table::new("first-look.csv", "How soon the pictures of the first panes look clean", columns, rows)
}

fn frames(report: &Report) -> Option<Table> {
    let rows = report.frames.iter().flat_map(|frames| {
        let spreads = [("interface", Some(frames.interface)), ("whole", frames.whole)];
        spreads.into_iter().filter_map(move |(what, spread)| {
            let spread = spread?;
            let times = [spread.median_ms, spread.percentile_95_ms, spread.most_ms];
            Some((what, times, frames.frames, frames.panes, frames.window, frames.pane, frames.samples, &frames.scene))
        })
    });
    let columns = [
        ("what", "interface: panels, pictures and input; whole: with drawing"),
        ("median_ms", "median milliseconds of a frame"),
        ("percentile_95_ms", "95 of 100 frames take at most this"),
        ("most_ms", "the longest"),
        ("frames", "frames, one after the other"),
        ("panes", "panes that rendered meanwhile"),
        ("window_width", "pixels across the window"),
        ("window_height", "pixels down the window"),
        ("pane_width", "pixels across a pane"),
        ("pane_height", "pixels down a pane"),
        ("samples", "samples per pixel that were taken meanwhile"),
        ("scene", "name of the scene"),
    ];
    Table::new("frames.csv", "How long the window takes for a frame while panes render", columns, rows)
}

fn growth(report: &Report) -> Option<Table> {
    let points =
        report.growth.iter().flat_map(|growth| growth.points.iter().map(move |point| (growth.quantity, point)));
    let rows = points.map(|(quantity, point)| {
        let seconds = [point.build_secs, point.rectify_secs, point.sample_secs];
        (quantity, point.size, seconds, [point.memory_bytes, point.peak_bytes])
    });
    let columns = [
        ("quantity", "what grows: triangles, nesting, objects or threads"),
        ("size", "how many of them"),
        ("build_secs", "seconds of tessellating, analysing meshes and building the tree"),
        ("rectify_secs", "seconds of rectification"),
        ("sample_secs", "seconds of one sample of one pixel, all threads working"),
        (
            "memory_bytes",
            "by how much the process's memory rose for the prepared scene, what earlier scenes left behind not counted; empty where it is too little to tell",
        ),
        ("peak_bytes", "the same of the most that it had while the scene was being prepared"),
    ];
    Table::new("growth.csv", "Time and memory at each size", columns, rows)
}

fn exponents(report: &Report) -> Option<Table> {
    let rows = report.growth.iter().flat_map(|growth| {
        let quantity = growth.quantity;
        let row = move |e: &Exponent| (quantity, e.measure, [e.exponent, e.low, e.high], e.from_size, e.points);
        growth.exponents.iter().map(row)
    });
    let columns = [
        ("quantity", "what grows"),
        ("measure", "build, rectify, sample or memory: a column of growth.csv"),
        ("exponent", "slope of a straight line through the logarithms, by least squares"),
        ("exponent_low", "lower end of its 95 % interval, if the points scatter independently about the line"),
        ("exponent_high", "its upper end"),
        ("from_size", "the smallest size that counts: below, what does not grow decides"),
        ("points", "sizes that count"),
    ];
    Table::new("exponents.csv", "How each measure of growth.csv grows: measure ~ size^exponent", columns, rows)
}
