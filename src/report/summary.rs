//! The whole in a few sentences: for the top of the page, and as a file of its own to be quoted.

use super::data::{Origin, Report, SceneReport};
use super::editing::Edit;
use super::experiment::{Curve, SceneErrors, Technique};
use super::growth::{Measure, Quantity};
use super::page::words::{bytes, fixed, number, time};
use crate::export::words::grouped;
use crate::measure::statistics::median;
use crate::tracking::Mode;

#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// `None`: there is nothing that could be good or bad.
    pub is_good: Option<bool>,
    /// Begins with the same words in every report.
    pub what: String,
    pub details: String,
}

impl Finding {
    fn new(is_good: Option<bool>, what: impl Into<String>, details: impl Into<String>) -> Self {
        Self { is_good, what: what.into(), details: details.into() }
    }
}

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
        first_look(report),
        editing(report),
        largest(report, Quantity::Triangles),
        largest(report, Quantity::Nesting),
        largest(report, Quantity::Objects),
        exponents(report),
    ];
    all.into_iter().flatten().collect()
}

/// The findings as a list in Markdown, with where they come from.
pub fn markdown(report: &Report) -> String {
    let Origin { command, program, version, threads, machine, date, .. } = &report.origin;
    let cpu = machine.cpu.as_deref().unwrap_or("unknown processor").trim();
    let mut text = format!("`{command}`, {program} {version}, on {threads} threads of {cpu}, {date}:\n\n");
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

/// Names of the scenes for which it is so.
fn names<'a, T>(found: &[(&'a SceneReport, T)], is_so: impl Fn(&T) -> bool) -> Vec<&'a str> {
    found.iter().filter(|(_, one)| is_so(one)).map(|(scene, _)| scene.name.as_str()).collect()
}

/// The scenes with the least and the greatest value.
fn ends<'a, T>(found: &'a [(&SceneReport, T)], value: impl Fn(&T) -> f64) -> Option<[&'a (&'a SceneReport, T); 2]> {
    let order = |a: &&(&SceneReport, T), b: &&(&SceneReport, T)| value(&a.1).total_cmp(&value(&b.1));
    Some([found.iter().min_by(order)?, found.iter().max_by(order)?])
}

fn rectified(report: &Report) -> Option<Finding> {
    let found: Vec<_> =
        errors(report).filter_map(|(scene, found)| Some((scene, plain(found, Mode::Rectified)?))).collect();
    let biased = names(&found, |curve| curve.bias.is_biased);
    let details = if biased.is_empty() {
        "against two independent references each, which ask anew at every hit what contains what".to_owned()
    } else {
        format!("biased beyond chance: {}", list(&biased))
    };
    let what = format!("rectified shows no bias in {} of {} scenes", found.len() - biased.len(), found.len());
    (!found.is_empty()).then(|| Finding::new(Some(biased.is_empty()), what, details))
}

fn slopes(report: &Report) -> Option<Finding> {
    let found: Vec<_> = errors(report)
        .filter_map(|(scene, found)| Some((scene, plain(found, Mode::Rectified)?.slope.as_ref()?.trimmed)))
        .collect();
    let beside = names(&found, |slope| !slope.contains(-1.0));
    let details = if beside.is_empty() {
        let widest = found.iter().map(|(_, slope)| 0.5 * (slope.high - slope.low)).fold(0.0, f64::max);
        let widest = fixed(widest, 2);
        format!("the 95 % interval of the slope, with independent samples, holds −1; it is ±{widest} wide at the most")
    } else {
        let beside = list(&beside);
        format!(
            "the 95 % interval of the slope does not hold −1 in {beside}; of twenty intervals one may miss by chance"
        )
    };
    let what = format!("Its error falls as 1/samples in {} of {} scenes", found.len() - beside.len(), found.len());
    (!found.is_empty()).then(|| Finding::new(Some(beside.is_empty()), what, details))
}

fn shipped(report: &Report) -> Option<Finding> {
    let shipped = |(scene, found): (_, &SceneErrors)| {
        let is_shipped = |curve: &&Curve| curve.technique == Technique::shipped();
        Some((scene, found.curves.iter().find(is_shipped)?.slope.as_ref()?.trimmed.value))
    };
    let found: Vec<_> = errors(report).filter_map(shipped).collect();
    let [steepest, shallowest] = ends(&found, |slope| *slope)?.map(|(scene, slope)| (fixed(*slope, 2), &scene.name));
    let details = format!("slopes from {} ({}) to {} ({})", shallowest.0, shallowest.1, steepest.0, steepest.1);
    Some(Finding::new(None, "As shipped, with low-discrepancy samples", details))
}

fn wrong_modes(report: &Report) -> Option<Finding> {
    let mut parts = Vec::new();
    let mut any = false;
    for mode in Mode::ALL.into_iter().filter(|mode| *mode < Mode::Rectified) {
        let own = |(scene, found)| {
            let own = plain(found, mode)?;
            // What gives the same images has the same bias.
            Some((scene, own.equal_to.and_then(|other| plain(found, other)).unwrap_or(own)))
        };
        let curves: Vec<_> = errors(report).filter_map(own).collect();
        any |= !curves.is_empty();
        let biased: Vec<_> = curves.iter().copied().filter(|(_, curve)| curve.bias.is_biased).collect();
        if let Some([_, (scene, curve)]) = ends(&biased, |curve| curve.bias.squared.value) {
            let bias = number(curve.bias.squared.value);
            let (count, all) = (biased.len(), curves.len());
            parts.push(format!("{mode} in {count} of {all} (worst {}, bias² {bias})", scene.name));
        }
    }
    let what = if parts.is_empty() { "No other mode shows a bias" } else { "Other modes are wrong" };
    any.then(|| Finding::new(None, what, parts.join("; ")))
}

fn stability(report: &Report) -> Option<Finding> {
    let [passed, failed, not_run] = report.stability.as_ref()?.counts();
    let what = format!("{passed} of {} stiff and extreme cases pass", passed + failed);
    Some(Finding::new(Some(failed == 0), what, format!("{not_run} not run, for want of a capability")))
}

fn sweeps(report: &Report) -> Option<Finding> {
    let found = &report.stability.as_ref()?.sweeps;
    let open: Vec<&str> = found.iter().filter(|s| !s.outcome.is_passed()).map(|s| s.name.as_str()).collect();
    let passed = found.len() - open.len();
    let what = format!("{passed} of {} sweeps stay within their bounds to the extreme", found.len());
    let open = open.join(", ");
    let details = if open.is_empty() { open } else { format!("others give way somewhere: {open}") };
    (!found.is_empty()).then(|| Finding::new(None, what, details))
}

fn left_out(report: &Report) -> Option<Finding> {
    let found: Vec<_> = report.scenes.iter().filter_map(|scene| Some((scene, scene.left_out.as_ref()?))).collect();
    let [_, (scene, most)] = ends(&found, |one| one.render.median)?;
    let longer = names(&found, |one| one.render.low > 1.0).len();
    let shorter = names(&found, |one| one.render.high < 1.0).len();
    let is_equal = found.iter().all(|(_, one)| {
        one.images_are_equal && one.tables_are_equal != Some(false) && one.each.iter().all(|each| each.images_are_equal)
    });
    let what =
        if is_equal { "What is left out changes no bit of any image" } else { "What is left out changes images" };
    let details = format!(
        "with everything put back a sample takes longer, beyond chance, in {longer} of {} scenes, and less long in {shorter}; \
         {} times as long at the most, in {}",
        found.len(),
        fixed(most.render.median, 3),
        scene.name
    );
    Some(Finding::new(Some(is_equal), what, details))
}

fn editing(report: &Report) -> Option<Finding> {
    let part = |edit: Edit| {
        let of_edit =
            |scene: &SceneReport| scene.editing.as_ref()?.times.iter().find(|times| times.edit == edit).cloned();
        let found: Vec<_> = report.scenes.iter().filter_map(|scene| Some((scene, of_edit(scene)?))).collect();
        let [(_, least), (scene, most)] = ends(&found, |times| times.image_secs)?;
        let range = span(least.image_secs, most.image_secs, time);
        let where_most = if found.len() > 1 { format!(" ({})", scene.name) } else { String::new() };
        let rectify: Vec<f64> = found.iter().filter_map(|(_, times)| times.rectify_secs).collect();
        let rectified = median(&rectify).map_or(String::new(), |secs| {
            let of_which = if found.len() > 1 { " in the median scene" } else { "" };
            format!(", of which rectification {}{of_which}", time(secs))
        });
        Some(format!("{} {range}{where_most}{rectified}", edit.about()))
    };
    let parts: Vec<String> = Edit::ALL.into_iter().filter_map(part).collect();
    let what = "From an edit to a new image in each of four panes";
    (!parts.is_empty()).then(|| Finding::new(None, what, parts.join("; ")))
}

fn first_look(report: &Report) -> Option<Finding> {
    let looks: Vec<_> = report.scenes.iter().filter_map(|scene| Some((scene, scene.first_look.as_ref()?))).collect();
    let clean: Vec<_> = looks.iter().filter_map(|(scene, look)| Some((*scene, look.all_clean_secs()?))).collect();
    let [(_, least), (scene, most)] = ends(&clean, |secs| *secs)?;
    let range = span(*least, *most, time);
    let where_most = if clean.len() > 1 { format!(", the longest in {}", scene.name) } else { String::new() };
    let others = looks.len() - clean.len();
    let others = if others > 0 { format!("; {others} scenes were given up before") } else { String::new() };
    Some(Finding::new(None, "From the first ray to pictures that look clean", format!("{range}{where_most}{others}")))
}

fn prepared(report: &Report) -> Option<Finding> {
    let found: Vec<_> = report.scenes.iter().map(|scene| (scene, scene.build_secs + scene.rectify_secs)).collect();
    let [least, most] = ends(&found, |secs| *secs)?;
    let where_most = if found.len() > 1 { format!(", the longest in {}", most.0.name) } else { String::new() };
    let details = format!("meshes, tree and rectification take {}{where_most}", span(least.1, most.1, time));
    Some(Finding::new(None, "From a scene to its first ray", details))
}

/// The greatest size that was measured.
fn largest(report: &Report, quantity: Quantity) -> Option<Finding> {
    let point = report.growth.iter().find(|growth| growth.quantity == quantity)?.points.last()?;
    let (things, prepared) = match quantity {
        Quantity::Triangles => ("triangles", format!("meshes and tree in {}, ", time(point.build_secs))),
        Quantity::Nesting => ("nested shells", String::new()),
        Quantity::Objects => ("objects", format!("tree in {}, ", time(point.build_secs))),
        Quantity::Threads => return None,
    };
    let a_triangle = |memory: u64| format!("{} bytes a triangle", fixed(memory as f64 / point.size as f64, 0));
    let memory = match (point.memory_bytes, point.peak_bytes) {
        _ if quantity != Quantity::Triangles => String::new(),
        (Some(memory), Some(peak)) => {
            let (kept, most) = (a_triangle(memory), a_triangle(peak));
            format!(", {} of memory ({kept}; while it is built at most {} or {most})", bytes(memory), bytes(peak))
        }
        (Some(memory), None) => format!(", {} of memory ({})", bytes(memory), a_triangle(memory)),
        _ => String::new(),
    };
    let (rectify, sample) = (time(point.rectify_secs), time(point.sample_secs));
    let details = format!("{prepared}rectification in {rectify}, a sample in {sample}{memory}");
    Some(Finding::new(None, format!("A scene of {} {things}", grouped(point.size)), details))
}

fn exponents(report: &Report) -> Option<Finding> {
    let part = |(quantity, measure, what): (Quantity, Measure, &str)| {
        let growth = report.growth.iter().find(|growth| growth.quantity == quantity)?;
        let found = growth.exponents.iter().find(|exponent| exponent.measure == measure)?;
        Some(format!("{what}: {}", fixed(found.exponent, 2)))
    };
    let all = [
        (Quantity::Triangles, Measure::Build, "build over triangles"),
        (Quantity::Triangles, Measure::Sample, "a sample over triangles"),
        (Quantity::Nesting, Measure::Sample, "a sample over nesting"),
        (Quantity::Objects, Measure::Rectify, "rectification over objects"),
    ];
    let parts: Vec<String> = all.into_iter().filter_map(part).collect();
    (!parts.is_empty()).then(|| Finding::new(None, "Exponents of growth", parts.join("; ")))
}
