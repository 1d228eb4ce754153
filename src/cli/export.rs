//! `iorect export`: a scene with every interface resolved, for other renderers.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use serde::Serialize;

use super::arguments::ExportArguments;
use super::{Failure, plural, print, print_json, tell};
use crate::export::escape::shown;
use crate::export::resolved::{Frame, export};
use crate::formats;

#[derive(Serialize)]
struct Report<'a> {
    scene: std::borrow::Cow<'a, str>,
    target: &'static str,
    folder: std::borrow::Cow<'a, str>,
    /// The file to open.
    main: &'a Path,
    files: Vec<&'a Path>,
    /// What is approximated, and what is left out.
    notes: &'a [String],
}

pub fn run(arguments: &ExportArguments) -> Result<ExitCode, Failure> {
    let ExportArguments { scene, to, output, size, spp } = arguments;
    if output.exists() && !output.is_dir() {
        return Err(Failure::wrong(format!("{} is a file, not a folder; choose another", shown(output))));
    }
    let description = Arc::new(formats::open(&scene.scene)?);
    let frame = Frame { width: size.width, height: size.height, samples: *spp };
    let bundle = export(&description, *to, frame)?;
    bundle.write(output).map_err(|error| Failure::Failed(error.into()))?;
    let files: Vec<&Path> = bundle.paths().collect();
    if scene.json {
        print_json(&Report {
            scene: scene.scene.to_string_lossy(),
            target: to.name(),
            folder: output.to_string_lossy(),
            main: &bundle.main,
            files,
            notes: &bundle.notes,
        })?;
        return Ok(ExitCode::SUCCESS);
    }
    print(&format!("wrote {} ({} file{})\n", shown(&output.join(&bundle.main)), files.len(), plural(files.len())))?;
    for note in &bundle.notes {
        tell(&format!("note: {note}\n"));
    }
    Ok(ExitCode::SUCCESS)
}
