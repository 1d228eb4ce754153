//! The whole in a few sentences, each with what came of it.

use maud::{Markup, html};

use super::words::{fixed, number, verdict};
use crate::report::data::{Report, SceneReport};
use crate::report::experiment::{Curve, SceneErrors, Technique};
use crate::report::growth::{Measure, Quantity};
use crate::tracking::Mode;

struct Item {
    /// `None`: there is nothing that could be good or bad.
    is_good: Option<bool>,
    what: String,
    details: String,
}

pub fn section(report: &Report) -> Markup {
    let items = [
        rectified(report),
        slopes(report),
        wrong_modes(report),
        stability(report),
        sweeps(report),
        left_out(report),
        growth(report),
    ];
    html! {
        section id="glance" {
            h2 { "At a glance" }
            ul class="glance" {
                @for item in items.into_iter().flatten() {
                    li {
                        @match item.is_good {
                            Some(true) => (verdict(Some(true), "yes")),
                            Some(false) => (verdict(Some(false), "no")),
                            None => {},
                        }
                        strong { (item.what) }
                        span class="muted" { (item.details) }
                    }
                }
            }
        }
    }
}

/// Names of scenes, or how many.
fn list(names: &[&str]) -> String {
    if names.len() <= 4 { names.join(", ") } else { format!("{} and {} more", names[..3].join(", "), names.len() - 3) }
}

fn errors(report: &Report) -> impl Iterator<Item = (&SceneReport, &SceneErrors)> {
    report.scenes.iter().filter_map(|scene| Some((scene, scene.errors.as_ref()?)))
}

fn plain(found: &SceneErrors, mode: Mode) -> Option<&Curve> {
    found.curves.iter().find(|curve| curve.mode == mode && curve.technique == Technique::independent())
}

fn rectified(report: &Report) -> Option<Item> {
    let found: Vec<_> =
        errors(report).filter_map(|(scene, found)| Some((scene, plain(found, Mode::Rectified)?))).collect();
    let biased: Vec<&str> =
        found.iter().filter(|(_, curve)| curve.bias.is_biased).map(|(scene, _)| scene.name.as_str()).collect();
    (!found.is_empty()).then(|| Item {
        is_good: Some(biased.is_empty()),
        what: format!("rectified shows no bias in {} of {} scenes", found.len() - biased.len(), found.len()),
        details: if biased.is_empty() {
            "against two independent references each, which ask anew at every hit what contains what".to_owned()
        } else {
            format!("biased beyond chance: {}", list(&biased))
        },
    })
}

fn slopes(report: &Report) -> Option<Item> {
    let found: Vec<_> = errors(report)
        .filter_map(|(scene, found)| Some((scene, plain(found, Mode::Rectified)?.slope.as_ref()?.trimmed)))
        .collect();
    let beside: Vec<&str> =
        found.iter().filter(|(_, slope)| !slope.contains(-1.0)).map(|(scene, _)| scene.name.as_str()).collect();
    (!found.is_empty()).then(|| Item {
        is_good: Some(beside.is_empty()),
        what: format!("Its error falls as 1/samples in {} of {} scenes", found.len() - beside.len(), found.len()),
        details: if beside.is_empty() {
            let widest = found.iter().map(|(_, slope)| 0.5 * (slope.high - slope.low)).fold(0.0, f64::max);
            format!(
                "the 95 % interval of the slope, with independent samples, holds −1; it is ±{} wide at the most",
                fixed(widest, 2)
            )
        } else {
            format!(
                "the 95 % interval of the slope does not hold −1 in {}; of twenty intervals one may miss by chance",
                list(&beside)
            )
        },
    })
}

fn wrong_modes(report: &Report) -> Option<Item> {
    let mut parts = Vec::new();
    let mut any = false;
    for mode in [Mode::Naive, Mode::Stack, Mode::Priority, Mode::RectifiedObject] {
        let curves: Vec<(&str, &Curve)> = errors(report)
            .filter_map(|(scene, found)| {
                let own = plain(found, mode)?;
                // What gives the same images has the same bias.
                let curve = own.equal_to.and_then(|other| plain(found, other)).unwrap_or(own);
                Some((scene.name.as_str(), curve))
            })
            .collect();
        any |= !curves.is_empty();
        let biased = curves.iter().filter(|(_, curve)| curve.bias.is_biased);
        let worst = biased.clone().max_by(|a, b| a.1.bias.squared.value.total_cmp(&b.1.bias.squared.value));
        if let Some((scene, curve)) = worst {
            let (count, bias) = (biased.count(), number(curve.bias.squared.value));
            parts.push(format!("{mode} in {count} of {} (worst {scene}, bias² {bias})", curves.len()));
        }
    }
    any.then(|| Item {
        is_good: None,
        what: if parts.is_empty() {
            "No other mode shows a bias".to_owned()
        } else {
            "Other modes are wrong".to_owned()
        },
        details: parts.join("; "),
    })
}

fn stability(report: &Report) -> Option<Item> {
    let found = report.stability.as_ref()?;
    let [passed, failed, not_run] = found.counts();
    Some(Item {
        is_good: Some(failed == 0),
        what: format!("{passed} of {} stiff and extreme cases pass", passed + failed),
        details: format!("{not_run} not run, for want of a capability"),
    })
}

fn sweeps(report: &Report) -> Option<Item> {
    let found = &report.stability.as_ref()?.sweeps;
    let open: Vec<&str> = found.iter().filter(|s| !s.outcome.is_passed()).map(|s| s.name.as_str()).collect();
    (!found.is_empty()).then(|| Item {
        is_good: None,
        what: format!("{} of {} sweeps stay within their bounds to the extreme", found.len() - open.len(), found.len()),
        details: if open.is_empty() {
            String::new()
        } else {
            format!("others give way somewhere: {}", open.join(", "))
        },
    })
}

fn left_out(report: &Report) -> Option<Item> {
    let found: Vec<_> =
        report.scenes.iter().filter_map(|scene| Some((scene.name.as_str(), scene.left_out.as_ref()?))).collect();
    let most = found.iter().max_by(|a, b| a.1.render.median.total_cmp(&b.1.render.median))?;
    let least = found.iter().min_by(|a, b| a.1.render.median.total_cmp(&b.1.render.median))?;
    let is_equal = found.iter().all(|(_, one)| {
        one.images_are_equal && one.tables_are_equal != Some(false) && one.each.iter().all(|each| each.images_are_equal)
    });
    Some(Item {
        is_good: Some(is_equal),
        what: if is_equal { "What is left out changes no bit of any image" } else { "What is left out changes images" }
            .to_owned(),
        details: format!(
            "a sample with everything put back takes {} times as long in {}, {} times in {}",
            fixed(least.1.render.median, 3),
            least.0,
            fixed(most.1.render.median, 3),
            most.0
        ),
    })
}

fn growth(report: &Report) -> Option<Item> {
    let exponent = |quantity: Quantity, measure: Measure| {
        let growth = report.growth.iter().find(|growth| growth.quantity == quantity)?;
        growth.exponents.iter().find(|exponent| exponent.measure == measure).map(|exponent| fixed(exponent.exponent, 2))
    };
    let parts: Vec<String> = [
        (Quantity::Triangles, Measure::Build, "build over triangles"),
        (Quantity::Triangles, Measure::Sample, "a sample over triangles"),
        (Quantity::Nesting, Measure::Sample, "a sample over nesting"),
        (Quantity::Objects, Measure::Rectify, "rectification over objects"),
    ]
    .into_iter()
    .filter_map(|(quantity, measure, what)| Some(format!("{what}: {}", exponent(quantity, measure)?)))
    .collect();
    (!parts.is_empty()).then(|| Item {
        is_good: None,
        what: "Exponents of growth".to_owned(),
        details: parts.join("; "),
    })
}
