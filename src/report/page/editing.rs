//! How soon the picture follows an edit, in the window.

use maud::{Markup, html};

use super::words::time;
use crate::render::Backend;
use crate::report::data::Report;
use crate::report::editing::{Edit, EditTimes, Editing};

/// `None` where it was not measured.
pub fn section(report: &Report) -> Option<Markup> {
    let measured = || report.scenes.iter().filter_map(|scene| Some((scene, scene.editing.as_ref()?)));
    let (_, first) = measured().next()?;
    Some(html! {
        p {
            "The threads behind the window render each scene in four panes of " (first.size[0]) "×" (first.size[1]) " pixels ("
            @for (index, mode) in first.panes.iter().enumerate() { @if index > 0 { ", " } code { (mode) } }
            ") while it is edited: the IOR of one medium after the other, the place of one dielectric after the other, the camera, each time at an irregular moment. "
            "Rectification is done again as far as an edit reaches. A first image is as fine as can be rendered in an instant, and is refined from there: "
            "its width stands beside the time."
            @if first.backend == Backend::Gpu { " Here the graphics processor renders all but " code { "reference" } "." }
        }
        div class="scroll" {
            table class="editing" {
                caption { "Median time from an edit to the first new image of every pane, and the longest" }
                thead {
                    tr {
                        th rowspan="2" { "scene" }
                        @for edit in Edit::ALL { th colspan=(if rectifies(edit) { 3 } else { 2 }) { (edit.about()) } }
                    }
                    tr {
                        @for edit in Edit::ALL {
                            @if rectifies(edit) { th class="n" { "rectified in" } }
                            th class="n" { "median" } th class="n" { "longest" }
                        }
                    }
                }
                tbody { @for (scene, found) in measured() { (row(&scene.name, found)) } }
            }
        }
    })
}

fn row(name: &str, found: &Editing) -> Markup {
    let of = |edit: Edit| found.times.iter().find(|times| times.edit == edit);
    html! { tr { th scope="row" { (name) } @for edit in Edit::ALL { (cells(edit, of(edit))) } } }
}

/// Whether the edit can change what lies on the other side of a surface.
fn rectifies(edit: Edit) -> bool {
    edit != Edit::Camera
}

fn cells(edit: Edit, times: Option<&EditTimes>) -> Markup {
    html! {
        @if rectifies(edit) {
            td class="n" { @match times.and_then(|times| times.rectify_secs) { Some(secs) => (time(secs)), None => "–" } }
        }
        @match times {
            Some(times) => {
                td class="n" { (time(times.image_secs)) " " span class="interval" { "(" (times.width) " px)" } }
                td class="n" { (time(times.worst_secs)) }
            }
            None => { td class="n" { "–" } td class="n" { "–" } }
        }
    }
}
