//! Formats by the endings of files' names.

use std::path::Path;

/// A format that is read.
#[derive(Debug)]
pub(super) struct Format<R> {
    /// In lower case, the usual one first.
    pub endings: &'static [&'static str],
    /// The function that reads it.
    pub read: R,
}

/// The format that a file's ending names.
pub(super) fn by_ending<R>(formats: &'static [Format<R>], path: &Path) -> Option<&'static Format<R>> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    formats.iter().find(|format| format.endings.contains(&&*ending))
}

/// `.exr, .hdr or .png`.
pub(super) fn list<R>(formats: &[Format<R>]) -> String {
    let endings: Vec<String> = formats.iter().map(|format| format!(".{}", format.endings[0])).collect();
    match endings.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => endings.concat(),
    }
}
