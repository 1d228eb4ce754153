//! The whole in a few sentences: for the top of the page, and as a file of its own to be quoted.

use super::data::{Report, SceneReport};
use super::editing::{Edit, EditTimes};
use super::experiment::{Curve, SceneErrors, Technique};
use super::growth::{GrowthPoint, Measure, Quantity};
use super::page::words::{bytes, fixed, number, time};
use crate::export::words::grouped;
use crate::measure::statistics::median;
use crate::tracking::Mode;

/// One sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// `None`: there is nothing that could be good or bad.
    pub is_good: Option<bool>,
    /// Begins with the same words in every report.
    pub what: String,
    pub details: String,
}

/// What the report has something to say of.
pub fn findings(report: &Report) -> Vec<Finding> {
    let all = [
        rectified(report),
        slopes(report),
        shipped(report),
        wrong_modes(report),
        stability(report),
        sweeps(report),
        left_out(report),
        prepared(report),
        editing(report),
        triangles(report),
        nesting(report),
        objects(report),
        exponents(report),
    ];
    all.into_iter().flatten().collect()
}

/// The findings as a list in Markdown, with where they come from.
pub fn markdown(report: &Report) -> String {
    let origin = &report.origin;
    let machine = origin.machine.cpu.as_deref().unwrap_or("unknown processor");
    let mut text = format!(
        "`{}`, {} {}, on {} threads of {}, {}:\n\n",
        origin.command,
        origin.program,
        origin.version,
        origin.threads,
        machine.trim(),
        origin.date
    );
    for finding in findings(report) {
        let colon = if finding.details.is_empty() { "" } else { ": " };
        text += &format!("- **{}**{colon}{}\n", finding.what, finding.details);
    }
    text
}

/// Names of scenes, or how many.
fn list(names: &[&str]) -> String {
    if names.len() <= 4 { names.join(", ") } else { format!("{} and {} more", names[..3].join(", "), names.len() - 3) }
}

/// `1 to 2`, or what both are.
fn span(low: f64, high: f64, show: impl Fn(f64) -> String) -> String {
    let (low, high) = (show(low), show(high));
    if low == high { low } else { format!("{low} to {high}") }
}

fn errors(report: &Report) -> impl Iterator<Item = (&SceneReport, &SceneErrors)> {
    report.scenes.iter().filter_map(|scene| Some((scene, scene.errors.as_ref()?)))
}

fn plain(found: &SceneErrors, mode: Mode) -> Option<&Curve> {
    found.curves.iter().find(|curve| curve.mode == mode && curve.technique == Technique::independent())
}

fn rectified(report: &Report) -> Option<Finding> {
    let found: Vec<_> =
        errors(report).filter_map(|(scene, found)| Some((scene, plain(found, Mode::Rectified)?))).collect();
    let biased: Vec<&str> =
        found.iter().filter(|(_, curve)| curve.bias.is_biased).map(|(scene, _)| scene.name.as_str()).collect();
    (!found.is_empty()).then(|| Finding {
        is_good: Some(biased.is_empty()),
        what: format!("rectified shows no bias in {} of {} scenes", found.len() - biased.len(), found.len()),
        details: if biased.is_empty() {
            "against two independent references each, which ask anew at every hit what contains what".to_owned()
        } else {
            format!("biased beyond chance: {}", list(&biased))
        },
    })
}

fn slopes(report: &Report) -> Option<Finding> {
    let found: Vec<_> = errors(report)
        .filter_map(|(scene, found)| Some((scene, plain(found, Mode::Rectified)?.slope.as_ref()?.trimmed)))
        .collect();
    let beside: Vec<&str> =
        found.iter().filter(|(_, slope)| !slope.contains(-1.0)).map(|(scene, _)| scene.name.as_str()).collect();
    (!found.is_empty()).then(|| Finding {
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

fn shipped(report: &Report) -> Option<Finding> {
    let found: Vec<(&str, f64)> = errors(report)
        .filter_map(|(scene, found)| {
            let is_shipped = |curve: &&Curve| curve.technique == Technique::shipped();
            let slope = found.curves.iter().find(is_shipped)?.slope.as_ref()?;
            Some((scene.name.as_str(), slope.trimmed.value))
        })
        .collect();
    let steepest = found.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let shallowest = found.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(Finding {
        is_good: None,
        what: "As shipped, with low-discrepancy samples".to_owned(),
        details: format!(
            "slopes from {} ({}) to {} ({})",
            fixed(shallowest.1, 2),
            shallowest.0,
            fixed(steepest.1, 2),
            steepest.0
        ),
    })
}

fn wrong_modes(report: &Report) -> Option<Finding> {
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
    any.then(|| Finding {
        is_good: None,
        what: if parts.is_empty() {
            "No other mode shows a bias".to_owned()
        } else {
            "Other modes are wrong".to_owned()
        },
        details: parts.join("; "),
    })
}

fn stability(report: &Report) -> Option<Finding> {
    let found = report.stability.as_ref()?;
    let [passed, failed, not_run] = found.counts();
    Some(Finding {
        is_good: Some(failed == 0),
        what: format!("{passed} of {} stiff and extreme cases pass", passed + failed),
        details: format!("{not_run} not run, for want of a capability"),
    })
}

fn sweeps(report: &Report) -> Option<Finding> {
    let found = &report.stability.as_ref()?.sweeps;
    let open: Vec<&str> = found.iter().filter(|s| !s.outcome.is_passed()).map(|s| s.name.as_str()).collect();
    (!found.is_empty()).then(|| Finding {
        is_good: None,
        what: format!("{} of {} sweeps stay within their bounds to the extreme", found.len() - open.len(), found.len()),
        details: if open.is_empty() {
            String::new()
        } else {
            format!("others give way somewhere: {}", open.join(", "))
        },
    })
}

fn left_out(report: &Report) -> Option<Finding> {
    let found: Vec<_> =
        report.scenes.iter().filter_map(|scene| Some((scene.name.as_str(), scene.left_out.as_ref()?))).collect();
    let most = found.iter().max_by(|a, b| a.1.render.median.total_cmp(&b.1.render.median))?;
    let longer = found.iter().filter(|(_, one)| one.render.low > 1.0).count();
    let shorter = found.iter().filter(|(_, one)| one.render.high < 1.0).count();
    let is_equal = found.iter().all(|(_, one)| {
        one.images_are_equal && one.tables_are_equal != Some(false) && one.each.iter().all(|each| each.images_are_equal)
    });
    Some(Finding {
        is_good: Some(is_equal),
        what: if is_equal { "What is left out changes no bit of any image" } else { "What is left out changes images" }
            .to_owned(),
        details: format!(
            "with everything put back a sample takes longer, beyond chance, in {longer} of {} scenes, and less long in {shorter}; \
             {} times as long at the most, in {}",
            found.len(),
            fixed(most.1.render.median, 3),
            most.0
        ),
    })
}

/// Scenes and times of one kind of edit.
fn edits(report: &Report, edit: Edit) -> Vec<(&str, &EditTimes)> {
    let scenes = report.scenes.iter().filter_map(|scene| Some((scene.name.as_str(), scene.editing.as_ref()?)));
    scenes.filter_map(|(name, found)| Some((name, found.times.iter().find(|times| times.edit == edit)?))).collect()
}

fn editing(report: &Report) -> Option<Finding> {
    let parts: Vec<String> = (Edit::ALL.into_iter())
        .filter_map(|edit| {
            let found = edits(report, edit);
            let by_time = |a: &&(&str, &EditTimes), b: &&(&str, &EditTimes)| a.1.image_secs.total_cmp(&b.1.image_secs);
            let (least, most) = (found.iter().min_by(by_time)?, found.iter().max_by(by_time)?);
            let range = span(least.1.image_secs, most.1.image_secs, time);
            let where_most = if found.len() > 1 { format!(" ({})", most.0) } else { String::new() };
            let rectify: Vec<f64> = found.iter().filter_map(|(_, times)| times.rectify_secs).collect();
            let rectified = median(&rectify).map_or(String::new(), |secs| {
                let of_which = if found.len() > 1 { " in the median scene" } else { "" };
                format!(", of which rectification {}{of_which}", time(secs))
            });
            Some(format!("{} {range}{where_most}{rectified}", edit.about()))
        })
        .collect();
    (!parts.is_empty()).then(|| Finding {
        is_good: None,
        what: "From an edit to a new image in each of four panes".to_owned(),
        details: parts.join("; "),
    })
}

fn prepared(report: &Report) -> Option<Finding> {
    let secs = |scene: &SceneReport| scene.build_secs + scene.rectify_secs;
    let by_time = |a: &&SceneReport, b: &&SceneReport| secs(a).total_cmp(&secs(b));
    let (least, most) = (report.scenes.iter().min_by(by_time)?, report.scenes.iter().max_by(by_time)?);
    let where_most = if report.scenes.len() > 1 { format!(", the longest in {}", most.name) } else { String::new() };
    Some(Finding {
        is_good: None,
        what: "From a scene to its first ray".to_owned(),
        details: format!("meshes, tree and rectification take {}{where_most}", span(secs(least), secs(most), time)),
    })
}

/// The greatest size that was measured.
fn largest(report: &Report, quantity: Quantity) -> Option<&GrowthPoint> {
    report.growth.iter().find(|growth| growth.quantity == quantity)?.points.last()
}

fn triangles(report: &Report) -> Option<Finding> {
    let point = largest(report, Quantity::Triangles)?;
    let a_triangle = |memory: u64| format!("{} bytes a triangle", fixed(memory as f64 / point.size as f64, 0));
    let memory = match (point.memory_bytes, point.peak_bytes) {
        (Some(memory), Some(peak)) => {
            let (kept, most) = (a_triangle(memory), a_triangle(peak));
            format!(", {} of memory ({kept}; while it is built at most {} or {most})", bytes(memory), bytes(peak))
        }
        (Some(memory), None) => format!(", {} of memory ({})", bytes(memory), a_triangle(memory)),
        _ => String::new(),
    };
    Some(Finding {
        is_good: None,
        what: format!("A scene of {} triangles", grouped(point.size)),
        details: format!(
            "meshes and tree in {}, rectification in {}, a sample in {}{memory}",
            time(point.build_secs),
            time(point.rectify_secs),
            time(point.sample_secs)
        ),
    })
}

fn nesting(report: &Report) -> Option<Finding> {
    let point = largest(report, Quantity::Nesting)?;
    Some(Finding {
        is_good: None,
        what: format!("A scene of {} nested shells", grouped(point.size)),
        details: format!("rectification in {}, a sample in {}", time(point.rectify_secs), time(point.sample_secs)),
    })
}

fn objects(report: &Report) -> Option<Finding> {
    let point = largest(report, Quantity::Objects)?;
    Some(Finding {
        is_good: None,
        what: format!("A scene of {} objects", grouped(point.size)),
        details: format!(
            "tree in {}, rectification in {}, a sample in {}",
            time(point.build_secs),
            time(point.rectify_secs),
            time(point.sample_secs)
        ),
    })
}

fn exponents(report: &Report) -> Option<Finding> {
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
    (!parts.is_empty()).then(|| Finding {
        is_good: None,
        what: "Exponents of growth".to_owned(),
        details: parts.join("; "),
    })
}
