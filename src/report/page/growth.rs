//! Time and memory over the size of a scene, and over threads.

use maud::{Markup, html};

use super::plot::{Axis, Curve, DataPoint, Plot};
use super::words::{bytes, fixed, number, time};
use crate::export::words::grouped;
use crate::report::data::Report;
use crate::report::growth::{Exponent, Growth, GrowthPoint, Measure, Quantity};

pub fn section(report: &Report) -> Markup {
    html! {
        section id="growth" {
            h2 { "Growth" }
            p {
                "Time to build the tree and to rectify, time of a sample and memory, for scenes of rising size. An exponent of 1 says twice the size, twice the time; 0 says that size does "
                "not matter. Exponents are slopes of straight lines through the logarithms of the larger half of the sizes, counted in decades, because "
                "small scenes are decided by what does not grow; their 95 % intervals suppose that points scatter independently about the line, so that a "
                "curve that bends shows as a wide interval. Memory is by how much that of the process rose; what earlier, smaller scenes left behind is used again and not counted, "
                "so that it comes out too low, by up to half at a million triangles and by a few hundredths at ten million."
            }
            @for growth in &report.growth { (of_quantity(growth)) }
        }
    }
}

fn of_quantity(growth: &Growth) -> Markup {
    let is_threads = growth.quantity == Quantity::Threads;
    html! {
        h3 { @match growth.quantity {
            Quantity::Triangles => "Triangles", Quantity::Nesting => "Nesting", Quantity::Objects => "Objects", Quantity::Threads => "Threads",
        } }
        p { (growth.quantity.about()) }
        @if !growth.too_large.is_empty() {
            p { strong { "Not run: " } (growth.too_large.iter().map(|&size| grouped(size)).collect::<Vec<_>>().join(", ")) " would not have fitted into this machine's free memory." }
        }
        div class="plots" {
            @if is_threads { (figure("Samples a second over threads", &speed_plot(growth))) } @else {
                (figure("Time to prepare", &plot(growth, &[Measure::Build, Measure::Rectify])))
                (figure("Time of a sample of a pixel", &plot(growth, &[Measure::Sample])))
            }
        }
        div class="scroll" {
            table class="growth" {
                thead { tr {
                    th class="n" { (growth.quantity.name()) }
                    @if !is_threads { th class="n" { "build" } th class="n" { "rectify" } }
                    th class="n" { "a sample" }
                    @if is_threads { th class="n" { "speed-up" } } @else { th class="n" { "memory" } th class="n" { "at most, meanwhile" } }
                } }
                tbody {
                    @for point in &growth.points { (row(growth, point)) }
                    @if !growth.exponents.is_empty() { (exponents(growth)) }
                }
            }
        }
    }
}

fn figure(caption: &str, plot: &Plot) -> Markup {
    html! { figure { figcaption { (caption) } (plot.draw()) } }
}

fn row(growth: &Growth, point: &GrowthPoint) -> Markup {
    let is_threads = growth.quantity == Quantity::Threads;
    html! {
        tr {
            th class="n" scope="row" { (grouped(point.size)) }
            @if !is_threads { td class="n" { (time(point.build_secs)) } td class="n" { (time(point.rectify_secs)) } }
            td class="n" { (time(point.sample_secs)) }
            @if is_threads {
                td class="n" { @match growth.points.first() { Some(first) => (fixed(first.sample_secs / point.sample_secs, 2)), None => "–" } }
            } @else {
                td class="n" { @match point.memory_bytes { Some(memory) => (bytes(memory)), None => "too little to tell" } }
                td class="n" { @match point.peak_bytes { Some(peak) => (bytes(peak)), None => "–" } }
            }
        }
    }
}

fn exponents(growth: &Growth) -> Markup {
    let of = |measure| growth.exponents.iter().find(|exponent| exponent.measure == measure);
    let cell = |exponent: Option<&Exponent>| {
        html! {
            td class="n" {
                @match exponent {
                    Some(e) => { (fixed(e.exponent, 2)) " " span class="interval" { "(" (fixed(e.low, 2)) " to " (fixed(e.high, 2)) ")" } }
                    None => "–"
                }
            }
        }
    };
    html! {
        tr class="exponents" {
            th class="n" scope="row" {
                "exponent"
                @if let Some(first) = growth.exponents.first() { " from " (grouped(first.from_size)) }
            }
            @if growth.quantity == Quantity::Threads { (cell(of(Measure::Sample))) td class="n" { "" } } @else {
                @for measure in Measure::ALL { (cell(of(measure))) }
                td class="n" { "" }
            }
        }
    }
}

fn plot(growth: &Growth, measures: &[Measure]) -> Plot {
    let name = |measure: &Measure| match measure {
        Measure::Build => "build",
        Measure::Rectify => "rectify",
        Measure::Sample => "sample",
        Measure::Memory => "memory",
    };
    let curves = measures.iter().enumerate().map(|(index, measure)| Curve {
        name: name(measure).to_owned(),
        style: if *measure == Measure::Sample { 2 } else { index },
        data: (growth.points.iter())
            .filter_map(|point| Some(DataPoint::exact(point.size as f64, measure.of(point)?)))
            .collect(),
    });
    let last = growth.points.last().map_or(0, |point| point.size);
    Plot {
        about: format!("Seconds over {}, up to {}", growth.quantity.name(), number(last as f64)),
        x: Axis::log(growth.quantity.name()),
        y: Axis::log("seconds"),
        curves: curves.collect(),
        levels: Vec::new(),
    }
}

/// Samples a second, beside what as many machines of one thread would do.
fn speed_plot(growth: &Growth) -> Plot {
    let speed = |point: &GrowthPoint| 1.0 / point.sample_secs;
    let first = growth.points.first();
    let ideal = growth.points.iter().filter_map(|point| {
        let first = first?;
        Some(DataPoint::exact(point.size as f64, speed(first) * point.size as f64 / first.size as f64))
    });
    let measured = growth.points.iter().map(|point| DataPoint::exact(point.size as f64, speed(point)));
    Plot {
        about: "Samples a second over threads, and in proportion to threads".to_owned(),
        x: Axis::log("threads"),
        y: Axis::log("samples a second"),
        curves: vec![
            Curve { name: "measured".to_owned(), style: 0, data: measured.collect() },
            Curve { name: "proportional".to_owned(), style: 6, data: ideal.collect() },
        ],
        levels: Vec::new(),
    }
}
