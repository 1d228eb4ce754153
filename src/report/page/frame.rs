//! The page's head, its beginning and its end.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::words::{bytes, fixed, time};
use super::{backends, editing, estimators, files, first_look, growth, left_out, scenes, stability, summary};
use crate::report::csv::Table;
use crate::report::data::{Origin, Report};

const STYLE: &str = include_str!("style.css");

/// The page of a report whose tables lie beside it.
pub fn html(report: &Report, tables: &[Table]) -> String {
    let has_errors = report.scenes.iter().any(|scene| scene.errors.is_some());
    let scenes_title = if has_errors { "Scenes: error against time" } else { "Scenes" };
    let sections = [
        ("glance", "At a glance", Some(summary::section(report))),
        ("scenes", scenes_title, Some(scenes::section(report))),
        ("stability", "Stability", report.stability.as_ref().map(stability::section)),
        ("left-out", "What was left out", left_out::section(report)),
        ("first-look", "First look", first_look::section(report)),
        ("editing", "From an edit to the picture", editing::section(report)),
        ("estimators", "Estimators", estimators::section(report)),
        ("backends", "CPU and graphics processor", backends::section(report)),
        ("growth", "Growth", (!report.growth.is_empty()).then(|| growth::section(report))),
        ("files", "Files, and how to make them again", Some(files::section(report, tables))),
    ];
    let sections = || sections.iter().filter_map(|(id, title, section)| Some((id, title, section.as_ref()?)));
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content={ (report.origin.program) " " (report.origin.version) };
                title { "iorect report, " (report.origin.date) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "iorect: measured" }
                    p class="lead" {
                        "iorect renders scenes in which dielectrics sit inside dielectrics. This page says how fast its images converge and to what, "
                        "how it fares where numbers get stiff, what it leaves out of the work, how soon pictures follow edits, and how time and memory grow."
                    }
                    (origin(&report.origin))
                    nav aria-label="Contents" { ul { @for (id, title, _) in sections() { li { a href={ "#" (id) } { (title) } } } } }
                }
                main {
                    @for (id, title, section) in sections() {
                        section id=(id) {
                            h2 { @if *id == "stability" { "Numerical stability" } @else { (title) } }
                            (section)
                        }
                    }
                }
                footer {
                    p { "Made by " (report.origin.program) " " (report.origin.version) " on " (report.origin.date) "." }
                }
            }
        }
    };
    page.into_string()
}

fn origin(origin: &Origin) -> Markup {
    let machine = &origin.machine;
    let unknown = || "unknown processor".to_owned();
    let load = origin.load_before.map(|load| {
        let share = fixed(load, 2);
        if load < 0.25 {
            format!("quiet (load {share})")
        } else {
            format!("others were using it (load {share}): times are longer than they need to be")
        }
    });
    html! {
        dl class="origin" {
            dt { "Program" }
            dd {
                (origin.program) " " (origin.version)
                @if !origin.is_optimized { ", " strong { "built without optimisation: times mean little" } }
            }
            dt { "Date" } dd { (origin.date) }
            dt { "Machine" }
            dd {
                (machine.cpu.clone().unwrap_or_else(unknown)) ", " (machine.cores) " hardware threads"
                @if let Some(memory) = machine.memory_bytes { ", " (bytes(memory)) }
                "; " (machine.system)
            }
            @if let Some(adapter) = &origin.adapter { dt { "Graphics processor" } dd { (adapter) } }
            @if let Some(load) = load { dt { "At the start" } dd { (load) } }
            dt { "Threads" } dd { (origin.threads) }
            dt { "Seed" } dd { (origin.seed) }
            dt { "Extent" }
            dd {
                @if origin.is_quick { "quick: small images, few runs" } @else { "full" }
                ", " (time(origin.seconds))
                @if origin.pieces_reused > 0 {
                    "; " (origin.pieces_reused) " of " (origin.pieces_reused + origin.pieces_made)
                    " pieces were taken over from an earlier run of the same program on this machine"
                }
            }
            dt { "Command" } dd { code { (origin.command) } }
        }
    }
}
