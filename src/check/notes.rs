//! What was passed over in the files that a scene names.

use std::path::Path;

use super::{Problem, Severity};
use crate::scene::LoadNote;
use crate::scene::description::Shape;
use crate::tracking::Prepared;

/// Kinds of notes that leave a mesh as its author meant it.
const ADVICE: [&str; 7] =
    ["degenerate_triangles", "material_library", "material_values", "no_glass", "filter", "texture", "part"];

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let description = &*prepared.description;
    // One note of a file with the objects that have their shapes from it.
    let mut found: Vec<(&Path, &LoadNote, Vec<&str>)> = Vec::new();
    for object in description.objects.iter() {
        let Shape::Mesh { path, notes, .. } = &object.shape else { continue };
        for note in notes {
            match found.iter_mut().find(|(file, known, _)| file == path && *known == note) {
                Some((.., names)) => names.push(&object.name),
                None => found.push((path, note, vec![&object.name])),
            }
        }
    }
    let problem = |path: &Path, names: &[&str], note: &LoadNote| {
        let line = note.first_line.map(|line| format!(":{line}")).unwrap_or_default();
        let severity = if ADVICE.contains(&note.kind) { Severity::Advice } else { Severity::Warning };
        let message = format!("{}{line}: {}", path.display(), note.message);
        Problem { severity, ..Problem::warning(names.join(", "), note.kind, message) }
    };
    let import = description.source.as_ref().and_then(|source| Some((source, source.import.as_ref()?)));
    let of_scene = import.iter().flat_map(|(source, import)| import.notes.iter().map(|note| (&*source.path, note)));
    let of_scene = of_scene.map(|(path, note)| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let line = note.first_line.map(|line| format!("line {line}: ")).unwrap_or_default();
        Problem { severity: Severity::Advice, ..Problem::warning(name, note.kind, line + &note.message) }
    });
    of_scene.chain(found.iter().map(|(path, note, names)| problem(path, names, note))).collect()
}
