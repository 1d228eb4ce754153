//! Each scene: what it looks like, what other modes make of it, and error against time.

use maud::{Markup, html};

use super::errors;
use super::words::{image, number, ramp, time};
use crate::export::words::{events_in_words, grouped};
use crate::report::data::{Report, SceneReport};
use crate::report::pictures::{OtherMode, Pictures, Sameness};

pub fn section(report: &Report) -> Markup {
    let has_errors = report.scenes.iter().any(|scene| scene.errors.is_some());
    html! {
        (modes())
        @if has_errors { (errors::method(report)) }
        @for scene in &report.scenes { (article(scene)) }
    }
}

/// What the modes are: the page is read by people who have not seen the program.
fn modes() -> Markup {
    html! {
        p {
            "Refraction depends on the indices of refraction (IORs) on both sides of a surface, but a scene gives each object only the IOR of "
            "its own inside. The modes differ in how they find the other side, and in nothing else: they share geometry, scattering and random numbers."
        }
        ul {
            @for mode in crate::tracking::Mode::ALL { li { code { (mode) } ". " (mode.about()) } }
        }
        p {
            "The first picture of each scene is in mode " code { "rectified" } ". The others show, for each mode that differs from it, where that mode is too "
            "bright (orange) or too dark (blue), in linear luminance, by the same random numbers; black is no difference. The scale is one for all modes of a scene."
        }
    }
}

fn article(scene: &SceneReport) -> Markup {
    html! {
        article id={ "scene-" (scene.name) } {
            h3 { (scene.title) }
            p {
                code { (scene.name) } ". "
                @if let Some(about) = &scene.about { (about) " " }
                (grouped(scene.refractors as u64)) " dielectric" @if scene.refractors != 1 { "s" }
                ", " (grouped(scene.triangles as u64)) " triangles, " (grouped(scene.spheres as u64)) " analytic spheres. "
                @if scene.camera_medium == "world" { "The camera is in the global medium. " } @else {
                    "The camera is inside a dielectric (" (scene.camera_medium) "). "
                }
                "Tree in " (time(scene.build_secs)) ", rectified in " (time(scene.rectify_secs)) "."
            }
            @if let Some(pictures) = &scene.pictures { (gallery(scene, pictures)) }
            @if let Some(found) = &scene.errors { (errors::of_scene(scene, found)) }
        }
    }
}

fn gallery(scene: &SceneReport, pictures: &Pictures) -> Markup {
    let image = |png: &str, about: &str| image(png, [pictures.width, pictures.height].map(|side| side as usize), about);
    let same: Vec<&OtherMode> = pictures.others.iter().filter(|other| other.difference.is_none()).collect();
    html! {
        div class="pictures" {
            figure {
                (image(&pictures.rectified, &format!("{} in mode rectified", scene.title)))
                figcaption {
                    strong { "rectified" } " · " (pictures.samples) " samples per pixel · " (events_in_words(&pictures.rectified_events))
                }
            }
            @for other in &pictures.others {
                @if let Some(difference) = &other.difference {
                    figure {
                        (image(difference, &format!("{}: {} minus rectified", scene.title, other.mode)))
                        figcaption {
                            strong { (other.mode) " − rectified" } " · relMSE " (number(other.relmse)) " · " (events_in_words(&other.events))
                        }
                    }
                }
            }
        }
        @if pictures.others.iter().any(|other| other.difference.is_some()) { (scale(pictures.scale)) }
        @for (sameness, words) in [
            (Sameness::Equal, "to the last bit"),
            (Sameness::Rounding, "but for roundings"),
        ] {
            @let modes: Vec<&str> = same.iter().filter(|o| o.sameness == sameness).map(|o| o.mode.name()).collect();
            @if !modes.is_empty() {
                p class="muted" {
                    @for (index, mode) in modes.iter().enumerate() {
                        @if index > 0 { @if index + 1 == modes.len() { " and " } @else { ", " } }
                        code { (mode) }
                    }
                    @if modes.len() == 1 { " gives the same image, " } @else { " give the same image, " } (words) "."
                }
            }
        }
    }
}

/// The colours of differences with their values; `end` is 1, 2 or 5 times a power of ten.
fn scale(end: f32) -> Markup {
    let colors = (-10..=10).map(|k| crate::export::color_map::diverging(k as f32 / 10.0));
    let words = [format!("−{end} darker"), "0".to_owned(), format!("brighter +{end}")];
    ramp(26, "Scale of the differences", colors, &words)
}
