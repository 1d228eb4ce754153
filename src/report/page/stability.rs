//! Stiff and extreme cases, sweeps, and maps of the optics' errors.

use std::collections::{BTreeMap, BTreeSet};

use maud::{Markup, html};

use super::map;
use super::plot::{Axis, Curve, DataPoint, Plot, STYLES, Scale, key};
use super::words::{number, table, time, verdict};
use crate::report::stability::{Case, ErrorKind, Measurement, Outcome, Stability, Step, Sweep};

pub fn section(found: &Stability) -> Markup {
    let [passed, failed, not_run] = found.counts();
    html! {
        p {
            "Stiff and extreme cases go through the code that renders, not through a model of it. Expected values are closed forms or published numbers; none comes from this program. A "
            "case passes if every one of its measurements is within its bound, and, where it is random, four standard errors. What needs a capability that "
            "the program does not have is not run, which is no pass. "
            (passed) " passed, " (failed) " failed, " (not_run) " not run."
        }
        (table(
            Some("cases"),
            "Of several measurements, the one nearest to its bound",
            &[("case", "n"), ("what", ""), ("outcome", ""), ("expected", "n"), ("measured", "n"), ("error", "n"), ("bound", "n")],
            &html! { @for case in &found.cases { (row(case)) } },
        ))
        (by_estimators(found))
        (graphics(found))
        (faults(found))
        @if !found.sweeps.is_empty() {
            h3 { "From harmless to extreme" }
            div class="plots" { @for sweep in &found.sweeps { (of_sweep(sweep)) } }
        }
        @if !found.maps.is_empty() {
            h3 { "Errors of Fresnel’s equations" }
            p { "Relative errors against an evaluation with twice the digits, over the ratio of indices and the angle." }
            (map::scale())
            div class="plots" { @for one in &found.maps { (map::figure(one)) } }
        }
    }
}

/// What the other estimators make of the cases that are measured in images.
fn by_estimators(found: &Stability) -> Markup {
    let Some(first) = found.by_estimators.first() else { return html! {} };
    let columns: Vec<(&str, &str)> = [("case", "n"), ("what", "")]
        .into_iter()
        .chain(found.by_estimators.iter().flat_map(|by| [(by.estimator.name(), ""), ("error", "n"), ("bound", "n")]))
        .collect();
    html! {
        h3 { "By other estimators" }
        p { "The cases that are measured in images, in mode rectified, with paths from lights too: against the same values within the same bounds." }
        (table(
            Some("cases-estimators"),
            "Of several measurements, the one nearest to its bound",
            &columns,
            &html! { @for (index, case) in first.cases.iter().enumerate() { tr {
                td class="n" { @match case.number { Some(number) => (number), None => "+" } }
                th scope="row" class="wide" { (case.name) }
                @for by in &found.by_estimators { @if let Some(case) = by.cases.get(index) {
                    td { (outcome(&case.outcome)) }
                    td class="n" { @match case.worst() { Some(m) => { (number(m.error)) (kind(m)) }, None => "–" } }
                    td class="n" { (bound(case.worst())) }
                } }
            } } },
        ))
    }
}

/// The largest error allowed.
fn bound(measurement: Option<&Measurement>) -> Markup {
    html! {
        @match measurement { Some(m) => { (number(m.bound)) @if m.noise > 0.0 { " + 4 × " (number(m.noise)) } }, None => "–" }
    }
}

/// What f32 makes of the cases that are measured in images.
fn graphics(found: &Stability) -> Markup {
    let Some(graphics) = &found.graphics else { return html! {} };
    let of_cpu = |case: &Case| {
        let same = found.cases.iter().find(|other| other.name == case.name)?;
        let what = &case.worst()?.what;
        same.measurements.iter().find(|m| m.what == *what).map(|m| m.error)
    };
    let reason = |case: &Case| match &case.outcome {
        Outcome::NotRun { reason } => reason.clone(),
        _ => String::new(),
    };
    html! {
        h3 { "In f32, on the graphics processor" }
        p {
            "The cases that are measured in images, rendered by " (graphics.adapter)
            @if graphics.is_software { ", which computes on the CPU itself" }
            ", beside the CPU, which computes in f64. Bounds are those of f64: what is beyond them here shows the limits of f32."
        }
        (table(
            Some("cases-gpu"),
            "Of several measurements, the one nearest to its bound on the graphics processor",
            &[("case", "n"), ("what", ""), ("error on the GPU", "n"), ("on the CPU", "n"), ("bound", "n"), ("on the GPU", "")],
            &html! { @for case in &graphics.cases { tr {
                td class="n" { @match case.number { Some(number) => (number), None => "+" } }
                th scope="row" class="wide" { (case.name) span class="source" { (case.worst().map_or_else(|| reason(case), |m| m.what.clone())) } }
                td class="n" { @match case.worst() { Some(m) => { (number(m.error)) (kind(m)) }, None => "–" } }
                td class="n" { @match of_cpu(case) { Some(error) => (number(error)), None => "–" } }
                td class="n" { (bound(case.worst())) }
                td {
                    @match &case.outcome { Outcome::NotRun { .. } => "refused", other => { @if other.is_passed() { "within" } @else { "beyond" } } }
                }
            } } },
        ))
    }
}

fn outcome(outcome: &Outcome) -> Markup {
    let is_good = if let Outcome::NotRun { .. } = outcome { None } else { Some(outcome.is_passed()) };
    verdict(is_good, outcome.name())
}

fn row(case: &Case) -> Markup {
    let worst = case.worst();
    let value = |get: fn(&Measurement) -> f64| {
        html! { td class="n" { @match worst { Some(m) => { (digits(get(m))) @if !m.unit.is_empty() { " " (m.unit) } }, None => "–" } } }
    };
    html! {
        tr {
            td class="n" { @match case.number { Some(number) => (number), None => "+" } }
            th scope="row" class="wide" {
                (case.name)
                span class="source" {
                    (case.source)
                    @if case.measurements.len() > 1 { " · " (case.measurements.len()) " measurements" }
                }
            }
            td { (outcome(&case.outcome)) }
            (value(|m| m.expected))
            (value(|m| m.measured))
            td class="n" { @match worst { Some(m) => { (number(m.error)) (kind(m)) }, None => "–" } }
            td class="n" { (bound(worst)) }
        }
    }
}

/// Nine digits: the cases are about the last ones.
fn digits(x: f64) -> String {
    let plain = x == 0.0 || (1e-3..1e6).contains(&x.abs());
    let text = if plain { format!("{x:.9}") } else { return number(x) };
    super::plot::minus(text.trim_end_matches('0').trim_end_matches('.'))
}

fn kind(measurement: &Measurement) -> &'static str {
    match measurement.kind {
        ErrorKind::Absolute => "",
        ErrorKind::Relative => " rel.",
    }
}

/// Reasons of what failed and of what was not run.
fn faults(found: &Stability) -> Markup {
    let of_cases = found.cases.iter().map(|case| (case.name.clone(), &case.outcome));
    let of_sweeps = found.sweeps.iter().map(|sweep| (sweep.name.clone(), &sweep.outcome));
    let by_others = (found.by_estimators.iter())
        .flat_map(|by| by.cases.iter().map(|case| (format!("{}, {}", case.name, by.estimator), &case.outcome)));
    let open: Vec<_> = of_cases.chain(by_others).chain(of_sweeps).filter(|(_, outcome)| !outcome.is_passed()).collect();
    if open.is_empty() {
        return html! {};
    }
    html! {
        h3 { "Why these did not pass" }
        ul { @for (name, what) in open { li { strong { (name) } ": " (outcome(what)) ". " (what.reason()) } } }
    }
}

fn of_sweep(sweep: &Sweep) -> Markup {
    // Values of different units do not go into one plot.
    let mut by_unit: BTreeMap<&str, Vec<&Step>> = BTreeMap::new();
    for step in &sweep.steps {
        by_unit.entry(&step.measurement.unit).or_default().push(step);
    }
    html! {
        figure {
            figcaption { (sweep.name) " · " (outcome(&sweep.outcome)) }
            p class="muted" { (sweep.about) " " span class="interval" { (sweep.steps.len()) " measurements in " (time(sweep.seconds)) } }
            @for (unit, steps) in by_unit { (sweep_plot(sweep, unit, &steps)) }
        }
    }
}

/// Errors smaller than any rounding that matters: such a value is as good as exact, and would make an axis of hundreds of decades.
const EXACT: f64 = 1e-20;

/// Error over the parameter; where nothing at all is off, a sentence says more than an empty plot.
fn sweep_plot(sweep: &Sweep, unit: &str, steps: &[&Step]) -> Markup {
    let mut curves: BTreeMap<&str, Vec<DataPoint>> = BTreeMap::new();
    let mut exact: BTreeSet<&str> = steps.iter().map(|step| step.measurement.what.as_str()).collect();
    let mut bounds: Vec<DataPoint> = Vec::new();
    for step in steps {
        let m = &step.measurement;
        // What could not be measured is in the table and among the reasons.
        if m.error > EXACT {
            curves.entry(&m.what).or_default().push(DataPoint::exact(step.x, m.error));
            exact.remove(m.what.as_str());
        }
        bounds.push(DataPoint::exact(step.x, m.bound));
    }
    let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
    if curves.is_empty() {
        return html! {
            p { strong { "Exact at every step" } (unit) ": " (steps.len()) " measurements, " (first_and_last(sweep)) "." }
        };
    }
    bounds.sort_by(|a, b| a.x.total_cmp(&b.x).then(b.y.total_cmp(&a.y)));
    bounds.dedup_by(|a, b| a.x == b.x);
    let has_bound = bounds.iter().any(|point| point.y > 0.0);
    let names: Vec<&str> = curves.keys().copied().collect();
    let mut lines: Vec<Curve> = (curves.into_values().enumerate())
        .map(|(index, mut data)| {
            data.sort_by(|a, b| a.x.total_cmp(&b.x));
            Curve { name: (index + 1).to_string(), style: index % (STYLES - 1), data }
        })
        .collect();
    if has_bound {
        lines.push(Curve { name: "bound".to_owned(), style: STYLES - 1, data: bounds });
    }
    let positive = || steps.iter().map(|step| step.x).filter(|x| *x > 0.0);
    let span = positive().fold(0.0, f64::max) / positive().fold(f64::INFINITY, f64::min);
    let is_log = span > 30.0;
    let at_zero =
        steps.iter().filter(|step| is_log && step.x <= 0.0).map(|step| step.measurement.error).fold(f64::NAN, f64::max);
    let plot = Plot {
        about: format!("{}: error over {}", sweep.name, sweep.parameter),
        x: Axis { label: sweep.parameter.clone(), scale: if is_log { Scale::Log } else { Scale::Linear } },
        y: Axis::log(format!("error{unit}")),
        curves: lines,
        levels: Vec::new(),
    };
    html! {
        (plot.draw())
        ol class="legend" {
            @for (index, name) in names.iter().enumerate() { li { (key(index % (STYLES - 1))) (index + 1) ": " (name) } }
        }
        p class="muted" {
            @if !exact.is_empty() { "Exact at every step, and not drawn: " (exact.into_iter().collect::<Vec<_>>().join("; ")) ". " }
            @if !has_bound { "The bound is 0. " }
            @if !at_zero.is_nan() { "The step at 0 has no place on this axis: largest error there " (number(at_zero)) "." }
        }
    }
}

fn first_and_last(sweep: &Sweep) -> String {
    let name = |step: &Step| step.label.clone().unwrap_or_else(|| number(step.x));
    match (sweep.steps.first(), sweep.steps.last()) {
        (Some(first), Some(last)) => format!("{}: {} to {}", sweep.parameter, name(first), name(last)),
        _ => String::new(),
    }
}
