//! `iorect compare`: several modes of one scene in one picture, and their differences in figures.

use std::borrow::Cow;
use std::path::Path;
use std::process::ExitCode;

use serde::Serialize;

use super::arguments::CompareArguments;
use super::image::{DEFAULT_SPP, ImageReport, Job, Rendered, mega_samples_per_second, output_path};
use super::table::Table;
use super::{Failure, by_estimator, print, print_json};
use crate::export::escape::{short_name, shown};
use crate::export::words::{brief, duration, events_in_words};
use crate::export::{self, Comparison, Format, LabelledPane, Picture};
use crate::measure::{Difference, MetricError, difference, flip};
use crate::render::Display;
use crate::tracking::Mode;
use crate::writing::require_writable;

#[derive(Serialize)]
struct Report<'a> {
    scene: Cow<'a, str>,
    panes: Vec<ImageReport<'a>>,
    differences: Vec<PairDifference>,
}

/// `a` held against `b`.
#[derive(Serialize)]
struct PairDifference {
    a: Mode,
    b: Mode,
    #[serde(flatten)]
    figures: Difference,
    /// Mean FLIP of the two as the picture shows them.
    flip: f64,
}

pub fn run(arguments: &CompareArguments) -> Result<ExitCode, Failure> {
    let image = &arguments.image;
    let output = output_path(arguments.output.as_ref(), image.json, &image.scene, "comparison.png");
    require_distinct(&arguments.modes)?;
    if let Some(path) = &output {
        if Format::of(path).map_err(Failure::bad_output)? != Format::Png {
            let advice = "a comparison is a picture to look at; use a name that ends in `.png`";
            return Err(Failure::wrong(format!("{}: {advice}", path.display())));
        }
        require_writable(path).map_err(Failure::bad_output)?;
    }
    let job = Job::new(image, &arguments.modes, image.spp.unwrap_or(DEFAULT_SPP))?;
    let rendered = job.render(&arguments.modes);
    let pictures: Vec<Picture> = rendered.iter().map(|image| Picture::from(&image.film)).collect();
    let differences = job.on_threads(|| differences(&rendered, &pictures, job.display()));
    let differences = differences.map_err(|error| Failure::Failed(error.into()))?;
    if let Some(path) = &output {
        write_picture(path, &job, &rendered, &pictures, image.seed)?;
    }
    if image.json {
        let panes = rendered.iter().map(|image| job.report(image, output.as_deref())).collect();
        print_json(&Report { scene: image.scene.to_string_lossy(), panes, differences })?;
    } else {
        print(&summary(&job, &rendered, &differences, output.as_deref()))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn require_distinct(modes: &[Mode]) -> Result<(), Failure> {
    match modes.iter().enumerate().find(|(index, mode)| modes[..*index].contains(mode)) {
        Some((_, mode)) => Err(Failure::wrong(format!("--modes lists `{mode}` twice"))),
        None => Ok(()),
    }
}

/// Modes are declared in the order in which they deserve trust.
fn most_trusted(rendered: &[Rendered]) -> Option<usize> {
    (0..rendered.len()).max_by_key(|&index| rendered[index].mode)
}

/// Every pair once, the less trusted mode against the more trusted one.
fn differences(
    rendered: &[Rendered],
    pictures: &[Picture],
    display: Display,
) -> Result<Vec<PairDifference>, MetricError> {
    let mut pairs = Vec::new();
    for (b, Picture { width, height, rgb: reference }) in pictures.iter().enumerate() {
        let mut others = (0..rendered.len()).filter(|&a| rendered[a].mode < rendered[b].mode).peekable();
        if others.peek().is_none() {
            continue;
        }
        // One at a time: made ready, a picture takes nearly the memory of a film.
        let (width, height) = (*width as usize, *height as usize);
        let seen = flip::Reference::displayed(reference, width, height, flip::DEFAULT_PIXELS_PER_DEGREE, display)?;
        for a in others {
            let image = &pictures[a].rgb;
            let (figures, flip) = (difference(image, reference)?, seen.flip(image)?.mean());
            pairs.push(PairDifference { a: rendered[a].mode, b: rendered[b].mode, figures, flip });
        }
    }
    pairs.sort_by_key(|pair| (std::cmp::Reverse(pair.b), pair.a));
    Ok(pairs)
}

fn write_picture(
    path: &Path,
    job: &Job<'_>,
    rendered: &[Rendered],
    pictures: &[Picture],
    seed: u64,
) -> Result<(), Failure> {
    let panes: Vec<LabelledPane<'_>> = (rendered.iter().zip(pictures))
        .map(|(image, picture)| LabelledPane {
            title: image.mode.to_string(),
            details: format!("{} spp · {}", image.film.samples, duration(image.seconds)),
            events: image.film.events,
            picture,
        })
        .collect();
    let Picture { width, height, .. } = pictures[0];
    let about = Comparison {
        title: job.prepared.description.name.clone(),
        details: format!("{width}×{height} · seed {seed}{} · iorect {}", by(job, rendered), env!("CARGO_PKG_VERSION")),
        display: job.display(),
        baseline: most_trusted(rendered).filter(|_| rendered.len() > 1),
    };
    let sheet = export::comparison(&panes, &about).map_err(Failure::output)?;
    let modes: Vec<Mode> = rendered.iter().map(|image| image.mode).collect();
    let mut text = export::metadata(&job.prepared, &modes, rendered[0].film.samples, seed);
    text.push(job.renderer(rendered));
    text.push(export::estimator(job.estimator));
    export::image_png(path, &sheet, &text).map_err(Failure::output)
}

/// The estimator, where it is no usual one, and the graphics processor, where one was used.
fn by(job: &Job<'_>, rendered: &[Rendered]) -> String {
    let adapter = job.adapter(rendered).map_or_else(String::new, |adapter| format!(" · {}", short_name(adapter)));
    by_estimator(job.estimator) + &adapter
}

fn summary(job: &Job<'_>, rendered: &[Rendered], differences: &[PairDifference], output: Option<&Path>) -> String {
    let film = &rendered[0].film;
    let name = short_name(&job.prepared.description.name);
    let by = by(job, rendered);
    let mut text = format!("{name} · {}×{} · {} spp{by}\n\n", film.width, film.height, film.samples);
    let mut modes = Table::new("mode,>time,>Msamples/s,events");
    for image in rendered {
        modes.row([
            image.mode.to_string(),
            duration(image.seconds),
            brief(mega_samples_per_second(&image.film, image.seconds)),
            events_in_words(&image.film.events),
        ]);
    }
    text += &modes.render();
    if !differences.is_empty() {
        let mut table = Table::new("difference,>MSE,>relMSE,>mean |Δ|,>FLIP");
        for pair in differences {
            let figures = pair.figures;
            table.row([
                format!("{} − {}", pair.a, pair.b),
                brief(figures.mse),
                brief(figures.relmse),
                brief(figures.mean_abs),
                brief(pair.flip),
            ]);
        }
        text += "\n";
        text += &table.render();
    }
    if let Some(path) = output {
        text += &format!("\n  wrote {}\n", shown(path));
    }
    text
}
