//! `iorect report`: measurements of scenes as a page, tables and JSON.

use std::collections::HashSet;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use super::arguments::ReportArguments;
use super::progress::bar;
use super::{Failure, pool, print, shell_word};
use crate::export::ExportError;
use crate::export::escape::{escaped_json, short_name, shown};
use crate::export::words::duration;
use crate::formats::{self, builtin};
use crate::render::BackendChoice;
use crate::render::choice::{self, KnownAdapter};
use crate::report::data::Report;
use crate::report::extent::Extent;
use crate::report::frame_times::FrameTimes;
use crate::report::make::{Part, ReportError, Request, Subject, make};
use crate::report::progress::Progress;
use crate::report::store::Store;
use crate::report::write::{json, require_all_writable, write};

/// Steps of the progress bar.
const STEPS: u64 = 10_000;

pub fn run(arguments: &ReportArguments) -> Result<ExitCode, Failure> {
    let subjects = subjects(&arguments.scenes)?;
    // An hour of work is not to be lost to a folder that cannot be written into.
    let unwritable = |error: ExportError| {
        let advice = "the folder for the report cannot be used; choose another with `-o DIR`";
        Failure::Wrong(anyhow::Error::new(error).context(advice))
    };
    let store = Store::open(&arguments.output.join("cache")).map_err(unwritable)?;
    require_all_writable(&arguments.output).map_err(|error| unwritable(error.into()))?;
    let pool = pool(arguments.threads)?;
    let threads = pool.current_num_threads();
    let mut extent = match arguments {
        ReportArguments { tiny: true, .. } => Extent::tiny(arguments.seed, threads),
        ReportArguments { quick: true, .. } => Extent::quick(arguments.seed, threads),
        _ => Extent::full(arguments.seed, threads),
    };
    if arguments.backend == BackendChoice::Gpu {
        extent.editing.backend = BackendChoice::Gpu;
    }
    let parts = if arguments.only.is_empty() { Part::ALL.to_vec() } else { arguments.only.clone() };
    let frames = arguments.frames.as_deref().map(FrameTimes::read).transpose();
    let frames = frames.map_err(|error| Failure::wrong(error.to_string()))?;
    let by_gpu = [Part::Backends, Part::Stability, Part::LeftOut];
    let adapter = if by_gpu.iter().any(|part| parts.contains(part)) { adapter(arguments.backend)? } else { None };
    let request = Request { subjects, parts, extent, seed: arguments.seed, command: command_line(), frames, adapter };
    let bar = bar(STEPS, "{bar:30.cyan/dim} {percent:>3} % · {elapsed}, {eta} left · {wide_msg}");
    bar.enable_steady_tick(Duration::from_millis(250));
    let tell = |what: &str, part: f64| {
        bar.set_position((part * STEPS as f64) as u64);
        bar.set_message(short_name(what));
    };
    // An interruption ends the process: every finished piece is a file by then.
    let progress = Progress { cancel: &AtomicBool::new(false), tell: &tell };
    let report = pool.install(|| make(&request, &store, &progress)).map_err(failure)?;
    bar.finish_and_clear();
    let written = write(&report, &arguments.output).map_err(Failure::output)?;
    print(&if arguments.json { escaped_json(&json(&report)).into_owned() } else { summary(&report, &written) })?;
    Ok(ExitCode::SUCCESS)
}

/// The graphics processor to measure.
fn adapter(asked: BackendChoice) -> Result<Option<KnownAdapter>, Failure> {
    match asked {
        BackendChoice::Cpu => Ok(None),
        BackendChoice::Auto => Ok(choice::hardware().ok()),
        BackendChoice::Gpu => choice::adapter().map(Some).map_err(|error| Failure::Failed(error.into())),
    }
}

fn failure(error: ReportError) -> Failure {
    match error {
        ReportError::Scene(error) => error.into(),
        ReportError::Output(error) => Failure::output(error),
        error => Failure::Failed(error.into()),
    }
}

/// The scenes that are asked for, under names that tell them apart.
fn subjects(names: &[PathBuf]) -> Result<Vec<Subject>, Failure> {
    let all: Vec<PathBuf> = builtin::all().iter().map(|scene| scene.name.into()).collect();
    let mut taken = HashSet::new();
    (if names.is_empty() { &all } else { names })
        .iter()
        .map(|name| {
            let description = Arc::new(formats::open(name)?);
            let stem = name.file_stem().unwrap_or(name.as_os_str()).to_string_lossy().into_owned();
            if !taken.insert(stem.clone()) {
                let advice = "give each once, or copy one under another name";
                return Err(Failure::wrong(format!("two of the scenes are called `{stem}`; {advice}")));
            }
            Ok(Subject { name: stem, description })
        })
        .collect()
}

/// What was typed, with quotation marks where a shell needs them.
fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| shell_word(&word.to_string_lossy()));
    std::iter::once("iorect".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

fn summary(report: &Report, written: &[PathBuf]) -> String {
    let origin = &report.origin;
    let mut text = format!("{} scenes in {}", report.scenes.len(), duration(origin.seconds));
    if origin.pieces_reused > 0 {
        text +=
            &format!(", {} of {} pieces from before", origin.pieces_reused, origin.pieces_reused + origin.pieces_made);
    }
    text.push('\n');
    if let Some(stability) = &report.stability {
        let [passed, failed, not_run] = stability.counts();
        text += &format!("  stability {passed} passed, {failed} failed, {not_run} not run\n");
    }
    for path in written {
        text += &format!("  wrote     {}\n", shown(path));
    }
    text
}
