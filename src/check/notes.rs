//! What was passed over in the files that a scene names.

use super::{Problem, Severity};
use crate::scene::LoadNote;
use crate::scene::description::Shape;
use crate::tracking::Prepared;

/// Kinds of notes that leave a mesh as its author meant it.
const ADVICE: [&str; 1] = ["degenerate_triangles"];

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let description = &*prepared.description;
    // One file with the objects that it is the shape of.
    let mut files: Vec<(&std::path::Path, &[LoadNote], Vec<&str>)> = Vec::new();
    for object in description.objects.iter() {
        let Shape::Mesh { path, notes, .. } = &object.shape else { continue };
        match files.iter_mut().find(|(known, ..)| known == path) {
            Some((.., names)) => names.push(&object.name),
            None if notes.is_empty() => {}
            None => files.push((path, notes, vec![&object.name])),
        }
    }
    let problem = |path: &std::path::Path, names: &[&str], note: &LoadNote| {
        let line = note.first_line.map(|line| format!(":{line}")).unwrap_or_default();
        let severity = if ADVICE.contains(&note.kind) { Severity::Advice } else { Severity::Warning };
        let message = format!("{}{line}: {}", path.display(), note.message);
        Problem { severity, ..Problem::warning(names.join(", "), note.kind, message) }
    };
    files.iter().flat_map(|(path, notes, names)| notes.iter().map(|note| problem(path, names, note))).collect()
}
