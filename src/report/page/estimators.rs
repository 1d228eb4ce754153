//! What each estimator needs to converge.

use maud::{Markup, html};

use super::words::{number, table, time};
use crate::report::data::Report;
use crate::report::estimators::{GOAL, Way};

/// `None` where it was not measured.
pub fn section(report: &Report) -> Option<Markup> {
    let measured = || report.scenes.iter().filter_map(|scene| Some((scene, scene.estimators.as_ref()?)));
    let (_, first) = measured().next()?;
    Some(html! {
        p {
            "The same scene in mode " code { "rectified" } " by paths from the camera, with and without samples that go where they matter, by paths from both "
            "ends, and with merging, at " (first.size[0]) " × " (first.size[1]) " pixels. Errors are relMSE against a truth that the estimator has made that "
            code { "auto" } " chooses (●), with many times the samples. The slope is the exponent of samples that the error follows; the square of the "
            "bias is told from noise by pairs of runs, and what is not above its noise may be below 0. Merging is biased where there are caustics, by less with "
            "every sample. Seconds to " (number(GOAL)) " are on the line through the last levels where it is not reached; where that is flat, none are told."
        }
        (table(
            Some("estimators"),
            "Error against time of each estimator",
            &[
                ("scene", ""), ("estimator", ""), ("samples", "n"), ("time", "n"), ("relMSE", "n"), ("without 0.1 %", "n"), ("slope", "n"),
                ("bias²", "n"), ("time to the goal", "n"),
            ],
            &html! { @for (scene, found) in measured() { @for one in &found.ways { @if let Some(last) = one.levels.last() {
                tr {
                    th scope="row" { (scene.name) }
                    td { (words(one.way)) @if one.way.estimator == found.chosen && !one.way.adaptive { " ●" } }
                    td class="n" { (last.samples) }
                    td class="n" { (time(last.secs)) }
                    td class="n" { (number(last.relmse)) }
                    td class="n" { (number(last.trimmed)) }
                    td class="n" { (one.slope.map_or_else(|| "–".to_owned(), number)) }
                    td class="n" { (number(one.bias_squared)) }
                    td class="n" { (one.secs_to_goal.map_or_else(|| "–".to_owned(), time)) }
                }
            } } } },
        ))
    })
}

/// `path, adaptive`.
pub fn words(way: Way) -> String {
    let name = way.estimator.name();
    if way.adaptive { format!("{name}, adaptive") } else { name.to_owned() }
}
