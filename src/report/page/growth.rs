//! Time and memory over the size of a scene, and over threads.

use maud::{Markup, html};

use super::plot::{Axis, Curve, DataPoint, Plot};
use super::words::{bytes, fixed, interval, number, time};
use crate::export::words::grouped;
use crate::measure::Interval;
use crate::report::data::Report;
use crate::report::growth::{Exponent, Growth, GrowthPoint, Measure, Quantity};

pub fn section(report: &Report) -> Markup {
    html! {
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

fn of_quantity(growth: &Growth) -> Markup {
    let is_threads = growth.quantity == Quantity::Threads;
    let columns = if is_threads { &OF_THREADS[..] } else { &OF_SIZES };
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
                (figure("Time to prepare", &plot(growth, &[("build", Measure::Build), ("rectify", Measure::Rectify)])))
                (figure("Time of a sample of a pixel", &plot(growth, &[("sample", Measure::Sample)])))
            }
        }
        div class="scroll" {
            table class="growth" {
                thead { tr { th class="n" { (growth.quantity.name()) } @for (heading, ..) in columns { th class="n" { (heading) } } } }
                tbody {
                    @for point in &growth.points {
                        tr {
                            th class="n" scope="row" { (grouped(point.size)) }
                            @for (_, _, show) in columns { td class="n" { (show(growth, point)) } }
                        }
                    }
                    @if let Some(first) = growth.exponents.first() {
                        tr class="exponents" {
                            th class="n" scope="row" { "exponent from " (grouped(first.from_size)) }
                            @for (_, measure, _) in columns { td class="n" { @if let Some(measure) = measure { (exponent(growth, *measure)) } } }
                        }
                    }
                }
            }
        }
    }
}

fn exponent(growth: &Growth, measure: Measure) -> Markup {
    let Some(found) = growth.exponents.iter().find(|exponent| exponent.measure == measure) else {
        return html! { "–" };
    };
    let Exponent { exponent: value, low, high, .. } = *found;
    interval(&Interval { value, low, high }, |x| fixed(x, 2))
}

/// Heading, the measure whose exponent stands below, and what is shown of a point.
type Column = (&'static str, Option<Measure>, fn(&Growth, &GrowthPoint) -> String);

const OF_SIZES: [Column; 5] = [
    ("build", Some(Measure::Build), |_, point| time(point.build_secs)),
    ("rectify", Some(Measure::Rectify), |_, point| time(point.rectify_secs)),
    ("a sample", Some(Measure::Sample), |_, point| time(point.sample_secs)),
    ("memory", Some(Measure::Memory), |_, point| point.memory_bytes.map_or("too little to tell".to_owned(), bytes)),
    ("at most, meanwhile", None, |_, point| point.peak_bytes.map_or("–".to_owned(), bytes)),
];

const OF_THREADS: [Column; 2] =
    [OF_SIZES[2], ("speed-up", None, |growth, point| fixed(growth.points[0].sample_secs / point.sample_secs, 2))];

fn figure(caption: &str, plot: &Plot) -> Markup {
    html! { figure { figcaption { (caption) } (plot.draw()) } }
}

fn plot(growth: &Growth, measures: &[(&str, Measure)]) -> Plot {
    let curves = measures.iter().enumerate().map(|(index, (name, measure))| Curve {
        name: (*name).to_owned(),
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
