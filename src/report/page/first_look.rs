//! How soon a picture looks clean, and whether the window keeps answering meanwhile.

use maud::{Markup, html};

use super::words::{fixed, time};
use crate::report::data::Report;
use crate::report::first_look::{CLEAN, FirstLook, ModeLook};
use crate::report::frame_times::{FrameTimes, Spread};
use crate::tracking::Mode;

/// `None` where nothing of it was measured.
pub fn section(report: &Report) -> Option<Markup> {
    let measured: Vec<_> =
        report.scenes.iter().filter_map(|scene| Some((&scene.name, scene.first_look.as_ref()?))).collect();
    let frames = report.frames.as_ref();
    (!measured.is_empty() || frames.is_some()).then(|| {
        html! {
            @if let Some((_, first)) = measured.first() { (clean(&measured, first)) }
            @if let Some(frames) = frames { (window(frames)) }
        }
    })
}

fn clean(measured: &[(&String, &FirstLook)], first: &FirstLook) -> Markup {
    // Not every scene is opened with the same modes.
    let has = |mode: Mode| measured.iter().any(|(_, look)| look.modes.iter().any(|look| look.mode == mode));
    let modes: Vec<Mode> = Mode::ALL.into_iter().filter(|mode| has(*mode)).collect();
    html! {
        p {
            "Each scene is rendered as the first panes of the window are, " (first.size[0]) "×" (first.size[1])
            " pixels each: all modes in turns, with the same random numbers. A picture looks clean once its mean FLIP against a converged image of the same mode ("
            (first.converged_samples) " samples per pixel, another seed) is below " (fixed(CLEAN, 2))
            ", at the usual exposure. Seconds are those of rendering all modes until then; preparing the scene comes before. "
            "Between doublings of the samples they are interpolated."
        }
        div class="scroll" {
            table class="first-look" {
                caption { "Time until the picture of each mode looks clean, and samples per pixel by then" }
                thead {
                    tr {
                        th { "scene" } th class="n" { "prepared in" }
                        @for mode in &modes { th class="n" { code { (mode) } } }
                        th class="n" { "all clean" }
                    }
                }
                tbody {
                    @for (name, look) in measured {
                        tr {
                            th scope="row" { (name) }
                            td class="n" { (time(look.prepare_secs)) }
                            @for mode in &modes { td class="n" { (clean_mode(look.modes.iter().find(|look| look.mode == *mode))) } }
                            td class="n" { @match look.all_clean_secs() { Some(secs) => (time(secs)), None => "–" } }
                        }
                    }
                }
            }
        }
    }
}

/// When a mode's picture is clean; a dash where the scene is not opened with that mode.
fn clean_mode(look: Option<&ModeLook>) -> Markup {
    let interval = |text: String| html! { " " span class="interval" { "(" (text) ")" } };
    match look.map(|look| (look.clean_secs, look.clean_samples, look.points.last())) {
        Some((Some(secs), Some(samples), _)) => html! { (time(secs)) (interval(format!("{} spp", fixed(samples, 0)))) },
        Some((.., Some(last))) => {
            html! { "more than " (time(last.secs)) (interval(format!("FLIP {}", fixed(last.flip, 3)))) }
        }
        _ => html! { "–" },
    }
}

fn window(frames: &FrameTimes) -> Markup {
    let row = |what: &str, Spread { median_ms, percentile_95_ms, most_ms }: Spread| {
        html! {
            tr {
                th scope="row" { (what) }
                @for ms in [median_ms, percentile_95_ms, most_ms] { td class="n" { (fixed(ms, 1)) " ms" } }
            }
        }
    };
    let machine = &frames.machine;
    html! {
        p {
            "While " (frames.panes) " panes of " code { (frames.scene) } " rendered (" (frames.pane[0]) "×" (frames.pane[1]) " pixels each, "
            (frames.samples) " samples meanwhile), the window of " (frames.window[0]) "×" (frames.window[1]) " pixels drew " (frames.frames)
            " frames one after the other. Threads that render have a lower priority than the window's. Measured by " code { "iorect --measure-frames" }
            " on " (machine.cpu.clone().unwrap_or_else(|| "an unknown processor".to_owned())) ", " (machine.cores) " hardware threads, "
            @if let Some(card) = &frames.drawn_by { "drawn by " (card) ", " }
            (frames.date)
            @if !frames.is_optimized { ", " strong { "built without optimisation" } } "."
        }
        div class="scroll" {
            table class="frames" {
                caption { "Time that the window takes for a frame while panes render" }
                thead { tr { th { } th class="n" { "median" } th class="n" { "95 of 100 below" } th class="n" { "longest" } } }
                tbody {
                    (row("panels, pictures and input", frames.interface))
                    @if let Some(whole) = frames.whole { (row("with drawing", whole)) }
                    @if let Some(interval) = frames.interval { (row("from frame to frame", interval)) }
                }
            }
        }
    }
}
