//! Stiff and extreme cases, sweeps, and maps of the optics' errors.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::map;
use super::plot::{Axis, Curve, Place, Plot, STYLES, Scale};
use super::words::{number, time, verdict};
use crate::report::stability::{Case, ErrorKind, Measurement, Outcome, Stability, Sweep};

pub fn section(found: &Stability) -> Markup {
    let [passed, failed, not_run] = found.counts();
    html! {
        section id="stability" {
            h2 { "Numerical stability" }
            p {
                "Stiff and extreme cases go through the code that renders, not through a model of it. Expected values are closed forms or published numbers; none comes from this program. A "
                "case passes if every one of its measurements is within its bound, and, where it is random, four standard errors. What needs a capability that "
                "the program does not have is not run, which is no pass. "
                (passed) " passed, " (failed) " failed, " (not_run) " not run."
            }
            div class="scroll" {
                table class="cases" {
                    caption { "Of several measurements, the one nearest to its bound" }
                    thead { tr {
                        th class="n" { "case" } th { "what" } th { "outcome" } th class="n" { "expected" } th class="n" { "measured" } th class="n" { "error" } th class="n" { "bound" }
                        th { "by" }
                    } }
                    tbody { @for case in &found.cases { (row(case)) } }
                }
            }
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
}

fn outcome(outcome: &Outcome) -> Markup {
    match outcome {
        Outcome::Passed => verdict(Some(true), "passed"),
        Outcome::Failed { .. } => verdict(Some(false), "failed"),
        Outcome::NotRun { .. } => verdict(None, "not run"),
    }
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
                @if case.measurements.len() > 1 { span class="interval" { " " (case.measurements.len()) " measurements" } }
            }
            td { (outcome(&case.outcome)) }
            (value(|m| m.expected))
            (value(|m| m.measured))
            td class="n" { @match worst { Some(m) => { (number(m.error)) (kind(m)) }, None => "–" } }
            td class="n" {
                @match worst { Some(m) => { (number(m.bound)) @if m.noise > 0.0 { " + 4 × " (number(m.noise)) } }, None => "–" }
            }
            td class="wide muted" { (case.source) }
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
    let of_cases = found.cases.iter().map(|case| (case.name.as_str(), &case.outcome));
    let of_sweeps = found.sweeps.iter().map(|sweep| (sweep.name.as_str(), &sweep.outcome));
    let open: Vec<_> = of_cases.chain(of_sweeps).filter(|(_, outcome)| !outcome.is_passed()).collect();
    if open.is_empty() {
        return html! {};
    }
    html! {
        h3 { "Why these did not pass" }
        ul { @for (name, what) in open { li { strong { (name) } ": " (outcome(what)) ". " (what.reason()) } } }
    }
}

fn of_sweep(sweep: &Sweep) -> Markup {
    html! {
        figure {
            figcaption { (sweep.name) " · " (outcome(&sweep.outcome)) }
            (sweep_plot(sweep))
            figcaption { (sweep.about) " " span class="interval" { (sweep.steps.len()) " steps in " (time(sweep.seconds)) } }
        }
    }
}

/// Error over the parameter; where nothing at all is off, a sentence says more than an empty plot.
fn sweep_plot(sweep: &Sweep) -> Markup {
    let mut curves: BTreeMap<&str, Vec<Place>> = BTreeMap::new();
    let mut bounds: Vec<Place> = Vec::new();
    for step in &sweep.steps {
        let m = &step.measurement;
        curves.entry(&m.what).or_default().push(Place::exact(step.x, m.error));
        bounds.push(Place::exact(step.x, m.bound));
    }
    let is_log = sweep.steps.iter().all(|step| step.x > 0.0);
    let has_errors = sweep.steps.iter().any(|step| step.measurement.error > 0.0);
    if !has_errors {
        return html! { p { strong { "Exact at every step: " } (sweep.steps.len()) " measurements, from " (first_and_last(sweep)) "." } };
    }
    bounds.sort_by(|a, b| a.x.total_cmp(&b.x).then(b.y.total_cmp(&a.y)));
    bounds.dedup_by(|a, b| a.x == b.x);
    let mut lines: Vec<Curve> = (curves.into_iter().enumerate())
        .map(|(index, (what, mut places))| {
            places.sort_by(|a, b| a.x.total_cmp(&b.x));
            Curve { name: short(what), style: index % (STYLES - 1), places }
        })
        .collect();
    lines.push(Curve { name: "bound".to_owned(), style: STYLES - 1, places: bounds });
    let plot = Plot {
        about: format!("{}: error over {}", sweep.name, sweep.parameter),
        x: Axis { label: sweep.parameter.clone(), scale: if is_log { Scale::Log } else { Scale::Linear } },
        y: Axis::log("error"),
        curves: lines,
        levels: Vec::new(),
    };
    html! { (plot.draw()) }
}

/// As much of a name as has room beside a plot.
fn short(name: &str) -> String {
    const MOST: usize = 15;
    if name.chars().count() <= MOST { name.to_owned() } else { name.chars().take(MOST - 1).collect::<String>() + "…" }
}

fn first_and_last(sweep: &Sweep) -> String {
    let name = |step: &crate::report::stability::Step| step.label.clone().unwrap_or_else(|| number(step.x));
    match (sweep.steps.first(), sweep.steps.last()) {
        (Some(first), Some(last)) => format!("{} {} to {}", sweep.parameter, name(first), name(last)),
        _ => String::new(),
    }
}
