//! `iorect render`: one image in one mode.

use std::process::ExitCode;

use super::arguments::{RenderArguments, Switch};
use super::image::{DEFAULT_SPP, ImageReport, Job, Rendered, Seconds, mega_samples_per_second, output_path};
use super::{Failure, by_estimator, plural, print, print_json};
use crate::export::escape::{short_name, shown};
use crate::export::tev::{PATIENCE, Tev};
use crate::export::words::{brief, duration, events_in_words};
use crate::export::{self, Format, Picture};
use crate::render::{Backend, ImageSettings, Partial, SampleRange};
use crate::writing::require_writable;

pub fn run(arguments: &RenderArguments) -> Result<ExitCode, Failure> {
    let image = &arguments.image;
    let ending = match arguments.samples {
        Some(SampleRange(first, end)) => format!("{}-{first}-{end}.exr", arguments.mode),
        None => format!("{}.png", arguments.mode),
    };
    let output = output_path(arguments.output.as_ref(), image.json, &image.scene, &ending);
    // Minutes of rendering are not to be lost to a typing error.
    if arguments.samples.is_some() && image.adaptive == Some(Switch(true)) {
        return Err(Failure::wrong("--samples takes the same samples of every pixel; leave out `--adaptive on`"));
    }
    if let Some(path) = &output {
        let format = Format::of(path).map_err(Failure::bad_output)?;
        if arguments.samples.is_some() && format != Format::Exr {
            let advice = "--samples writes sums to be merged; use a name that ends in `.exr`";
            return Err(Failure::wrong(format!("{}: {advice}", path.display())));
        }
        require_writable(path).map_err(Failure::bad_output)?;
    }
    if let Some(address) = &arguments.tev {
        Tev::connect(address, PATIENCE).map_err(|error| Failure::Failed(error.into()))?;
    }
    let samples = arguments.samples.map_or(image.spp.unwrap_or(DEFAULT_SPP), SampleRange::count);
    let job = Job::new(image, &[arguments.mode], samples)?;
    let rendered = match arguments.samples {
        Some(samples) => job.render_part(arguments.mode, samples),
        None => job.render(&[arguments.mode]).remove(0),
    };
    let text = if image.json { None } else { Some(summary(&job, &rendered, output.as_deref())) };
    let report = image.json.then(|| serde_json::to_value(job.report(&rendered, output.as_deref()))).transpose();
    let report = report.map_err(|error| Failure::Failed(error.into()))?;
    let to_tev = arguments.tev.as_ref().map(|address| (address, Picture::from(&rendered.film)));
    if let Some(path) = &output {
        if arguments.samples.is_some() {
            let recipe = job.recipe(&rendered);
            if let Some(partial) = Partial::of_film(rendered.film, recipe) {
                export::write_sums(path, &partial).map_err(Failure::output)?;
            }
        } else {
            let mut text = export::metadata(&job.prepared, &[arguments.mode], rendered.film.samples, image.seed);
            text.push(job.renderer(std::slice::from_ref(&rendered)));
            text.push(export::estimator(job.estimator));
            export::save(path, &Picture::from(&rendered.film), &job.display(), &text).map_err(Failure::output)?;
        }
    }
    if let Some((address, picture)) = to_tev {
        let name = format!("{} – {}", arguments.mode, job.prepared.description.name);
        let shown = Tev::connect(address, PATIENCE).and_then(|mut tev| tev.show(&name, &picture, true));
        shown.map_err(|error| Failure::Failed(error.into()))?;
    }
    match text {
        Some(text) => print(&text)?,
        None => print_json(&report)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn summary(job: &Job<'_>, rendered: &Rendered, output: Option<&std::path::Path>) -> String {
    let report = job.report(rendered, output);
    let ImageReport { width, height, spp, threads, settings: ImageSettings { mode, seed, .. }, .. } = report;
    let adapter = report.adapter.map_or_else(String::new, short_name);
    let Seconds { load, bvh, rectify, compile, render } = report.seconds;
    let speed = brief(mega_samples_per_second(&rendered.film, render));
    let [load, bvh, rectify, render] = [load, bvh, rectify, render].map(duration);
    let left_out = if report.left_out.is_empty() { "nothing".into() } else { report.left_out.join(", ") };
    let scene = short_name(&job.prepared.description.name);
    let by = by_estimator(report.settings.estimator);
    let mut text = format!("{scene} · {mode}{by} · {width}×{height} · {spp} spp · seed {seed}\n");
    let compile = report.adapter.map_or_else(String::new, |_| format!(" · compile {}", duration(compile)));
    text += &format!("  time      load {load} · tree {bvh} · rectify {rectify}{compile} · render {render}\n");
    let by = match report.settings.backend {
        Backend::Cpu => format!("{threads} thread{}", plural(threads)),
        Backend::Gpu => adapter,
        Backend::Mixed => format!("{adapter} and {threads} thread{}", plural(threads)),
    };
    text += &format!("  speed     {speed} million samples a second, {by}\n");
    text += &format!("  events    {}\n", events_in_words(&report.events));
    if let Some(share) = report.mixed_share {
        text += &format!("  mixed     {:.1} % of the crossings\n", 100.0 * share);
    }
    text += &format!("  left out  {left_out}\n");
    if let Some(path) = output {
        text += &format!("  wrote     {}\n", shown(path));
    }
    text
}
