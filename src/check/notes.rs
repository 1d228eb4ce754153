//! What was passed over in the files that a scene names.

use std::collections::HashMap;
use std::path::Path;

use super::{Problem, Severity};
use crate::scene::LoadNote;
use crate::scene::description::Shape;
use crate::tracking::Prepared;

/// Kinds of notes that leave a mesh as its author meant it.
const ADVICE: [&str; 7] =
    ["degenerate_triangles", "material_library", "material_values", "no_glass", "filter", "texture", "part"];

/// Most files of which one kind of note is given for each.
const MOST_ALIKE: usize = 4;

/// A note of a file, with the objects that have their shapes from it.
struct Found<'a> {
    path: &'a Path,
    note: &'a LoadNote,
    names: Vec<&'a str>,
}

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let description = &*prepared.description;
    let mut found: Vec<Found<'_>> = Vec::new();
    let mut places: HashMap<(&Path, &LoadNote), usize> = HashMap::new();
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for object in description.objects.iter() {
        let Shape::Mesh { path, notes, .. } = &object.shape else { continue };
        for note in notes {
            let place = *places.entry((path, note)).or_insert(found.len());
            match found.get_mut(place) {
                Some(known) => known.names.push(&object.name),
                None => {
                    *counts.entry(note.kind).or_default() += 1;
                    found.push(Found { path, note, names: vec![&object.name] });
                }
            }
        }
    }
    // What many files have alike is said once.
    let mut together: Vec<Vec<Found<'_>>> = Vec::new();
    for one in found {
        let alike = |group: &&mut Vec<Found<'_>>| group[0].note.kind == one.note.kind;
        match together.iter_mut().find(alike).filter(|_| counts[one.note.kind] > MOST_ALIKE) {
            Some(group) => group.push(one),
            None => together.push(vec![one]),
        }
    }
    let problem = |found: &[Found<'_>]| {
        let Found { path, note, names } = &found[0];
        let line = note.first_line.map(|line| format!(":{line}")).unwrap_or_default();
        let severity = if ADVICE.contains(&note.kind) { Severity::Advice } else { Severity::Warning };
        let mut message = format!("{}{line}: {}", path.display(), note.message);
        let mut names = names.join(", ");
        if let [_, _, ..] = found {
            let others = &found[1..];
            message += &format!("; likewise {} other files", others.len());
            names += &format!(" and {} more", others.iter().map(|found| found.names.len()).sum::<usize>());
        }
        Problem { severity, ..Problem::warning(names, note.kind, message) }
    };
    let import = description.source.as_ref().and_then(|source| Some((source, source.import.as_ref()?)));
    let of_scene = import.iter().flat_map(|(source, import)| import.notes.iter().map(|note| (&*source.path, note)));
    let of_scene = of_scene.map(|(path, note)| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let line = note.first_line.map(|line| format!("line {line}: ")).unwrap_or_default();
        Problem { severity: Severity::Advice, ..Problem::warning(name, note.kind, line + &note.message) }
    });
    of_scene.chain(together.iter().map(|found| problem(found))).collect()
}
