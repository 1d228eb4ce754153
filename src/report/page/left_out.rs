//! What each scene does not need, and what leaving it out saves.

use std::collections::BTreeSet;

use maud::{Markup, html};

use super::words::{fixed, table, time, verdict};
use crate::report::data::Report;
use crate::report::left_out::{LeftOut, how};
use crate::report::timing::Ratio;
use crate::scene::needs::SceneNeeds;

/// `None` where it was not measured.
pub fn section(report: &Report) -> Option<Markup> {
    let measured = || report.scenes.iter().filter_map(|scene| Some((scene, scene.left_out.as_ref()?)));
    let each: Vec<_> = measured().flat_map(|(scene, found)| found.each.iter().map(move |one| (scene, one))).collect();
    measured().next()?;
    Some(html! {
        p {
            "Before it renders, the program works out what a scene needs and does nothing else. To see what that saves, the same samples are rendered both ways, by turns: "
            "with everything put back (" code { "--leave-out off" } ") and as shipped. The ratio is the median of the pairs' ratios; 1.10 says that a sample would take 10 % longer. "
            "The interval holds the true median with the probability shown, whatever the distribution of times; one that holds 1 says that no saving was seen. Where nothing is left out, both ways are the same work, and the ratio shows how well times can be told apart. "
            "Both images must be the same to the last bit."
        }
        p {
            "Memory is the same both ways: what a scene does not have takes none in either. There are no normals without smooth objects, "
            "no nodes in a tree without primitives, no tables for an image that is not there."
        }
        (table(
            Some("left-out"),
            "Time of a sample with everything put back over that as shipped",
            &[("scene", ""), ("ratio", "n"), ("interval", "n"), ("as shipped", "n"), ("images", ""), ("left out", "wide")],
            &html! { @for (scene, found) in measured() { (row(&scene.name, found)) } },
        ))
        (rectification(report))
        @if !each.is_empty() {
            (table(
                None,
                "One piece put back at a time, where tracing has a switch for it",
                &[("scene", ""), ("put back", ""), ("ratio", "n"), ("interval", "n"), ("images", "")],
                &html! { @for (scene, one) in each {
                    tr {
                        th scope="row" { (scene.name) } td { code { (one.need) } }
                        td class="n" { (fixed(one.ratio.median, 3)) } td class="n" { (range(&one.ratio)) } td { (equality(one.images_are_equal)) }
                    }
                } },
            ))
        }
        (graphics(report))
        (pieces(report))
    })
}

fn row(name: &str, found: &LeftOut) -> Markup {
    let pixels = f64::from(found.width) * f64::from(found.height);
    // Each pair has one slice, and one was thrown away.
    let samples = pixels * f64::from(found.samples) / (found.render.pairs + 1) as f64;
    html! {
        tr {
            th scope="row" { (name) }
            td class="n" { (fixed(found.render.median, 3)) }
            td class="n" { (range(&found.render)) }
            td class="n" { (time(found.render.below_secs / samples)) " a sample" }
            td { (equality(found.images_are_equal)) }
            td class="wide" {
                @if found.left_out.is_empty() { "nothing" }
                @for (index, need) in found.left_out.iter().enumerate() { @if index > 0 { ", " } code { (need) } }
            }
        }
    }
}

fn rectification(report: &Report) -> Markup {
    let rows: Vec<_> = (report.scenes.iter())
        .filter_map(|scene| {
            let found = scene.left_out.as_ref()?;
            Some((scene, found.rectify.as_ref()?, found.tables_are_equal?))
        })
        .collect();
    if rows.is_empty() {
        return html! {};
    }
    table(
        None,
        "Time of rectification with the pre-trace that scenes without nesting do without",
        &[("scene", ""), ("ratio", "n"), ("interval", "n"), ("without", "n"), ("answers", "")],
        &html! { @for (scene, ratio, is_equal) in rows {
            tr {
                th scope="row" { (scene.name) } td class="n" { (fixed(ratio.median, 2)) } td class="n" { (range(ratio)) }
                td class="n" { (time(ratio.below_secs)) } td { (equality(is_equal)) }
            }
        } },
    )
}

/// What leaving out saves on the graphics processor.
fn graphics(report: &Report) -> Markup {
    let found = || report.scenes.iter().filter_map(|scene| Some((scene, scene.left_out.as_ref()?.graphics.as_ref()?)));
    let Some((_, first)) = found().next() else { return html! {} };
    html! {
        p {
            "On the graphics processor what a scene does not need makes its shaders shorter. Measured in the same way on " (first.adapter)
            @if first.is_software { ", which computes on the CPU itself" } ". Shaders of different length need not round alike, so that images may differ."
        }
        (table(
            None,
            "Time of a sample with everything put back over that as shipped, on the graphics processor",
            &[("scene", ""), ("put back", ""), ("ratio", "n"), ("interval", "n"), ("images", "")],
            &html! { @for (scene, found) in found() {
                tr {
                    th scope="row" { (scene.name) } td { "everything" }
                    td class="n" { (fixed(found.render.median, 3)) } td class="n" { (range(&found.render)) }
                    td { (sameness(found.images_are_equal)) }
                }
                @for one in &found.each { tr {
                    th scope="row" { (scene.name) } td { code { (one.need) } }
                    td class="n" { (fixed(one.ratio.median, 3)) } td class="n" { (range(&one.ratio)) }
                    td { (sameness(one.images_are_equal)) }
                } }
            } },
        ))
    }
}

fn sameness(is_equal: bool) -> &'static str {
    if is_equal { "equal" } else { "differ" }
}

/// What each piece is; in these scenes at least.
fn pieces(report: &Report) -> Markup {
    let found = || report.scenes.iter().filter_map(|scene| scene.left_out.as_ref());
    let names: BTreeSet<&str> = found().flat_map(|found| found.left_out.iter().map(String::as_str)).collect();
    let in_order = SceneNeeds::EVERYTHING.named().into_iter().map(|(name, _)| name).filter(|name| names.contains(name));
    table(
        None,
        "How each piece is left out",
        &[("not needed", ""), ("scenes", "n"), ("so that", "")],
        &html! { @for name in in_order {
            tr {
                th scope="row" { code { (name) } }
                td class="n" { (found().filter(|found| found.left_out.iter().any(|need| need == name)).count()) }
                td class="wide" { (how(name).unwrap_or_default()) }
            }
        } },
    )
}

fn range(ratio: &Ratio) -> Markup {
    html! {
        span class="interval" {
            (fixed(ratio.low, 3)) " to " (fixed(ratio.high, 3)) " (" (fixed(100.0 * ratio.confidence, 0)) " %)"
        }
    }
}

fn equality(is_equal: bool) -> Markup {
    if is_equal { verdict(Some(true), "equal") } else { verdict(Some(false), "different") }
}
