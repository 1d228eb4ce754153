//! A report as files in a folder.

use std::path::{Path, PathBuf};

use super::csv::tables;
use super::data::{Report, SceneReport};
use super::page;
use super::pictures::Pictures;
use super::summary;
use crate::export::ExportError;
use crate::writing::{WriteError, require_writable, write_atomically};

/// # Errors
/// When `folder`, or a file in it that a report would replace, cannot be written.
pub fn require_all_writable(folder: &Path) -> Result<(), WriteError> {
    ["report.html", "report.json", "summary.md"].iter().try_for_each(|name| require_writable(&folder.join(name)))?;
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    entries.filter(|path| path.extension().is_some_and(|e| e == "csv")).try_for_each(|path| require_writable(&path))
}

/// Writes `report.html`, `report.json`, `summary.md` and the tables into `folder`; returns what was written, the page first. The page goes last, so that
/// where it stands all else does.
///
/// # Errors
/// When the folder cannot be written into.
pub fn write(report: &Report, folder: &Path) -> Result<Vec<PathBuf>, ExportError> {
    let tables = tables(report);
    let mut written = Vec::new();
    let mut put = |name: &str, text: &str| -> Result<(), ExportError> {
        let path = folder.join(name);
        write_atomically(&path, |writer| writer.write_all(text.as_bytes()))?;
        written.push(path);
        Ok(())
    };
    for table in &tables {
        put(table.file, &table.text)?;
    }
    put("summary.md", &summary::markdown(report))?;
    put("report.json", &json(report))?;
    put("report.html", &page::html(report, &tables))?;
    written.reverse();
    Ok(written)
}

/// Everything but the pictures' pixels.
pub fn json(report: &Report) -> String {
    let blind = |scene: &SceneReport| SceneReport {
        pictures: scene.pictures.as_ref().map(Pictures::without_pixels),
        ..scene.clone()
    };
    let report = Report { scenes: report.scenes.iter().map(blind).collect(), ..report.clone() };
    let mut text = serde_json::to_string_pretty(&report).expect("plain data with names for keys");
    text.push('\n');
    text
}
