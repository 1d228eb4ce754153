//! `iorect render`: one image in one mode.

use std::process::ExitCode;

use super::arguments::RenderArguments;
use super::image::{Job, Rendered, mega_samples_per_second, output_path};
use super::{Failure, plural, print, print_json};
use crate::export::words::{brief, duration, events_in_words};
use crate::export::{self, Format, Picture};

pub fn run(arguments: &RenderArguments) -> Result<ExitCode, Failure> {
    let image = &arguments.image;
    let output = output_path(arguments.output.as_ref(), image.json, &image.scene, arguments.mode.name());
    // Minutes of rendering are not to be lost to a typing error.
    if let Some(path) = &output {
        Format::of(path).map_err(Failure::bad_output)?;
        export::require_writable(path).map_err(Failure::bad_output)?;
    }
    let job = Job::new(image)?;
    let rendered = job.render(&[arguments.mode]).remove(0);
    if let Some(path) = &output {
        let text = export::metadata(&job.prepared, &[arguments.mode], rendered.film.samples, image.seed);
        export::save(path, &Picture::from(&rendered.film), &job.display(), &text).map_err(Failure::output)?;
    }
    if image.json {
        print_json(&job.report(&rendered, output.as_deref()))?;
    } else {
        print(&summary(&job, &rendered, output.as_deref()))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn summary(job: &Job<'_>, rendered: &Rendered, output: Option<&std::path::Path>) -> String {
    let report = job.report(rendered, output);
    let seconds = report.seconds;
    let left_out = if report.left_out.is_empty() { "nothing".into() } else { report.left_out.join(", ") };
    let mut text = format!(
        "{} · {} · {}×{} · {} spp · seed {}\n",
        job.prepared.description.name, report.mode, report.width, report.height, report.spp, report.seed
    );
    text += &format!(
        "  time      load {} · tree {} · rectify {} · render {}\n",
        duration(seconds.load),
        duration(seconds.bvh),
        duration(seconds.rectify),
        duration(seconds.render)
    );
    text += &format!(
        "  speed     {} million samples a second, {} thread{}\n",
        brief(mega_samples_per_second(&rendered.film, seconds.render)),
        report.threads,
        plural(report.threads)
    );
    text += &format!("  events    {}\n", events_in_words(&report.events));
    if let Some(share) = report.mixed_share {
        text += &format!("  mixed     {:.1} % of the crossings\n", 100.0 * share);
    }
    text += &format!("  left out  {left_out}\n");
    if let Some(path) = output {
        text += &format!("  wrote     {}\n", path.display());
    }
    text
}
