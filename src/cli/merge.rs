//! `iorect merge`: parts of an image, rendered by many machines, put together.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;

use super::arguments::MergeArguments;
use super::{Failure, plural, print, print_json};
use crate::export::escape::{short_name, shown};
use crate::export::words::events_in_words;
use crate::export::{self, Format, Head, Picture, SumsError};
use crate::render::{Backend, CannotMerge, Display, ImageSettings, Partial, Recipe, SampleRange};
use crate::tracking::Events;
use crate::tracking::Mode;
use crate::writing::require_writable;

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    recipe: &'a Recipe,
    files: usize,
    samples: &'a [SampleRange],
    gaps: Vec<SampleRange>,
    spp: u32,
    events: Events,
    mixed_share: Option<f64>,
    /// What is no Unicode in them is replaced.
    outputs: Vec<Cow<'a, str>>,
}

pub fn run(arguments: &MergeArguments) -> Result<ExitCode, Failure> {
    for path in &arguments.outputs {
        Format::of(path).map_err(Failure::bad_output)?;
        require_writable(path).map_err(Failure::bad_output)?;
    }
    let merged = merge(&arguments.files, arguments.mix_backends)?;
    for path in &arguments.outputs {
        write(path, &merged, &Display { exposure: arguments.exposure, curve: arguments.curve })?;
    }
    if arguments.json {
        let is_rectified = merged.recipe.settings.mode == Mode::Rectified;
        print_json(&Report {
            recipe: &merged.recipe,
            files: arguments.files.len(),
            samples: &merged.ranges,
            gaps: merged.gaps(),
            spp: merged.samples(),
            events: merged.events,
            mixed_share: merged.events.mixed_share().filter(|_| is_rectified),
            outputs: arguments.outputs.iter().map(|path| path.to_string_lossy()).collect(),
        })?;
    } else {
        print(&summary(arguments, &merged))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// All files in one. Heads are compared before any pixels are read, which can take minutes.
fn merge(files: &[PathBuf], mixes_backends: bool) -> Result<Partial, Failure> {
    let wrong = |error: SumsError| match error {
        SumsError::Read { .. } => Failure::Failed(error.into()),
        _ => Failure::Wrong(error.into()),
    };
    let mut heads =
        files.iter().map(|path| export::read_sums_head(path)).collect::<Result<Vec<_>, _>>().map_err(wrong)?;
    let backend = heads.iter().map(|head| head.recipe.settings.backend).reduce(Backend::and);
    // Parts that may be mixed are all taken for what they come to.
    let as_mixed = |recipe: &mut Recipe| {
        if let Some(backend) = backend.filter(|_| mixes_backends) {
            recipe.settings.backend = backend;
        }
    };
    heads.iter_mut().for_each(|head| as_mixed(&mut head.recipe));
    require_mergeable(files, &heads)?;
    let adapters: BTreeSet<&str> = heads.iter().filter_map(|head| head.recipe.adapter.as_deref()).collect();
    let adapter = adapters.into_iter().map(str::to_owned).reduce(|all, adapter| format!("{all}, {adapter}"));
    let mut merged: Option<Partial> = None;
    for path in files {
        let mut part = export::read_sums(path).map_err(wrong)?;
        as_mixed(&mut part.recipe);
        part.recipe.adapter.clone_from(&adapter);
        match &mut merged {
            None => merged = Some(part),
            Some(merged) => merged.add(&part).map_err(|reason| {
                Failure::Failed(anyhow::anyhow!("{} changed while it was read: {reason}", path.display()))
            })?,
        }
    }
    merged.ok_or_else(|| Failure::wrong("there is no file to merge"))
}

fn require_mergeable(files: &[PathBuf], heads: &[Head]) -> Result<(), Failure> {
    let refused = |path: &Path, earlier: &Path, reason: CannotMerge| {
        let (path, earlier) = (path.display(), earlier.display());
        let advice = match reason {
            CannotMerge::Differs { field: ImageSettings::BACKEND, .. } => "; `--mix-backends` merges them all the same",
            _ => "",
        };
        Failure::wrong(format!("{path} cannot be merged with {earlier}: {reason}{advice}"))
    };
    for (path, head) in files.iter().zip(heads).skip(1) {
        head.recipe.require_same_image(&heads[0].recipe).map_err(|reason| refused(path, &files[0], reason))?;
    }
    // In ascending order, what overlaps at all overlaps its neighbour.
    let mut ranges: Vec<(SampleRange, &PathBuf)> =
        files.iter().zip(heads).flat_map(|(path, head)| head.samples.iter().map(move |range| (*range, path))).collect();
    ranges.sort();
    for pair in ranges.windows(2) {
        let [(a, earlier), (b, path)] = [pair[0], pair[1]];
        if b.0 < a.1 {
            return Err(refused(path, earlier, CannotMerge::Overlap(SampleRange(b.0, a.1.min(b.1)))));
        }
    }
    Ok(())
}

fn write(path: &Path, merged: &Partial, display: &Display) -> Result<(), Failure> {
    match Format::of(path).map_err(Failure::bad_output)? {
        Format::Exr => export::write_sums(path, merged),
        Format::Png => {
            let recipe = &merged.recipe;
            let picture = Picture { width: recipe.width, height: recipe.height, rgb: merged.to_rgb() };
            let ImageSettings { mode, backend, estimator, seed, .. } = recipe.settings;
            let mut text = export::metadata_for_media(&recipe.scene, &[], &[mode], merged.samples(), seed);
            text.push(export::renderer(&[backend], recipe.adapter.as_deref()));
            text.push(export::estimator(estimator));
            export::png(path, &picture, display, &text)
        }
    }
    .map_err(Failure::output)
}

fn summary(arguments: &MergeArguments, merged: &Partial) -> String {
    let recipe = &merged.recipe;
    let files = arguments.files.len();
    let ranges = |ranges: &[SampleRange]| ranges.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let Recipe { width, height, settings: ImageSettings { mode, seed, .. }, .. } = recipe;
    let (scene, samples) = (short_name(&recipe.scene), merged.samples());
    let from = format!("{samples} spp from {files} file{}", plural(files));
    let mut text = format!("{scene} · {mode} · {width}×{height} · {from} · seed {seed}\n");
    text += &format!("  samples   {}\n", ranges(&merged.ranges));
    if let Some(adapter) = &recipe.adapter {
        text += &format!("  by        {}\n", short_name(adapter));
    }
    let gaps = merged.gaps();
    if !gaps.is_empty() {
        text += &format!("  missing   {}\n", ranges(&gaps));
    }
    text += &format!("  events    {}\n", events_in_words(&merged.events));
    for path in &arguments.outputs {
        text += &format!("  wrote     {}\n", shown(path));
    }
    text
}
