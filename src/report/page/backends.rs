//! What the graphics processor brings.

use maud::{Markup, html};

use super::words::{fixed, number, table};
use crate::report::data::Report;

/// `None` where it was not measured.
pub fn section(report: &Report) -> Option<Markup> {
    let measured = || report.scenes.iter().filter_map(|scene| Some((scene, scene.backends.as_ref()?)));
    let (_, first) = measured().next()?;
    Some(html! {
        p {
            "The same samples by the CPU and by " strong { (first.adapter) }
            @if first.is_software { ", which computes on the CPU itself: times say nothing about graphics processors" }
            ". Speeds are in million samples of a pixel a second, without splits, at " (first.size[0]) " × " (first.size[1]) " pixels. "
            "Both use the same random numbers: pixels that differ by more than rounding are those where a path has parted ways, by a last bit that made it hit "
            "something else or choose the other way. The two images agree in the mean all the same. Everything else in this report was rendered by the CPU."
        }
        (table(
            Some("backends"),
            "Million samples a second by both backends, and how far their images are apart",
            &[("scene", ""), ("mode", ""), ("CPU", "n"), ("GPU", "n"), ("GPU over CPU", "n"), ("parted pixels", "n"), ("mean", "n")],
            &html! { @for (scene, found) in measured() { @for one in &found.modes {
                tr {
                    th scope="row" { (scene.name) }
                    td { code { (one.mode.name()) } }
                    td class="n" { (number(one.cpu / 1e6)) }
                    td class="n" { (number(one.gpu / 1e6)) }
                    td class="n" { (number(one.gpu / one.cpu)) }
                    td class="n" { (fixed(100.0 * one.parted, 2)) " %" }
                    td class="n" { (fixed(one.mean_ratio, 4)) }
                }
            } } },
        ))
    })
}
