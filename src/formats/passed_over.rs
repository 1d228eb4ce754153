//! What a mesh's file holds beside its surface, or that is of no use: counted by kind while it is passed over.

use super::lines::shown;
use crate::scene::LoadNote;
use crate::scene::shapes::MAX_LENGTH;

named! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub(super) enum Kind {
        UnknownStatement = "unknown_statement",
        UnknownHeaderLine = "unknown_header_line",
        ShortFaces = "short_faces",
        DegenerateTriangles = "degenerate_triangles",
        MissingNormals = "missing_normals",
        PartialNormals = "partial_normals",
        UnusableNormals = "unusable_normals",
        UnusableVertices = "unusable_vertices",
        VertexWeights = "vertex_weights",
        ExtraValues = "extra_values",
        TrailingBytes = "trailing_bytes",
        NulBytes = "nul_bytes",
    }
}

#[derive(Debug, Clone)]
struct Entry {
    kind: Kind,
    count: u64,
    first_line: Option<usize>,
    /// The first, where it has a name.
    example: String,
}

/// In the order in which they were met, each kind once.
#[derive(Debug, Clone, Default)]
pub(super) struct PassedOver(Vec<Entry>);

impl PassedOver {
    /// Counts one, at its line in text formats.
    pub fn add(&mut self, kind: Kind, line: Option<usize>) {
        self.add_many(kind, 1, line);
    }

    /// Counts `count`, the first at that line.
    pub fn add_many(&mut self, kind: Kind, count: u64, first_line: Option<usize>) {
        self.count(kind, count, first_line, "");
    }

    /// Counts one that has a name.
    pub fn add_named(&mut self, kind: Kind, name: &str, line: usize) {
        self.count(kind, 1, Some(line), name);
    }

    fn count(&mut self, kind: Kind, count: u64, first_line: Option<usize>, name: &str) {
        if count == 0 {
            return;
        }
        match self.0.iter_mut().find(|entry| entry.kind == kind) {
            Some(entry) => entry.count += count,
            None => {
                let example = if name.is_empty() { String::new() } else { shown(name.as_bytes()) };
                self.0.push(Entry { kind, count, first_line, example });
            }
        }
    }

    /// How many of a kind, with the line and the name of the first.
    pub fn first(&self, kind: Kind) -> Option<(u64, Option<usize>, &str)> {
        let entry = self.0.iter().find(|entry| entry.kind == kind)?;
        Some((entry.count, entry.first_line, &entry.example))
    }

    pub fn into_notes(self) -> Vec<LoadNote> {
        let note = |entry: Entry| LoadNote {
            kind: entry.kind.name(),
            count: entry.count,
            first_line: entry.first_line,
            message: entry.kind.message(entry.count, &entry.example),
        };
        self.0.into_iter().map(note).collect()
    }
}

impl Kind {
    fn message(self, count: u64, example: &str) -> String {
        let of = |one: &str, many: &str| format!("{count} {}", if count == 1 { one } else { many });
        match self {
            Self::UnknownStatement => of(
                &format!("statement, {example}, is none of OBJ and was passed over"),
                &format!("statements, the first {example}, are none of OBJ and were passed over"),
            ),
            Self::UnknownHeaderLine => of(
                &format!("line of the header, {example}, is none of PLY and was passed over"),
                &format!("lines of the header, the first {example}, are none of PLY and were passed over"),
            ),
            Self::ShortFaces => of(
                "face has fewer than three corners and was left out",
                "faces have fewer than three corners and were left out",
            ),
            Self::DegenerateTriangles => {
                of("triangle has no area and was left out", "triangles have no area and were left out")
            }
            Self::MissingNormals => {
                of("corner names a normal", "corners name normals")
                    + " that the file does not have, so none of its normals is used: `smooth` computes its own"
            }
            Self::PartialNormals => {
                of("corner has no normal", "corners have no normal")
                    + " where others have one, so none of the file's normals is used: `smooth` computes its own"
            }
            Self::UnusableNormals => {
                of("normal has no direction", "normals have no direction")
                    + ", so none of the file's normals is used: `smooth` computes its own"
            }
            Self::UnusableVertices => {
                let what = of("vertex is", "vertices are");
                format!("{what} not finite or beyond {MAX_LENGTH:e}; no face uses them, and they were left out")
            }
            Self::VertexWeights => {
                of("vertex has a weight", "vertices have weights")
                    + " other than 1, which free-form surfaces alone would need, and which was passed over"
            }
            Self::ExtraValues => {
                of("row has", "rows have") + " more values than the header names; what is too much was passed over"
            }
            Self::TrailingBytes => {
                of("byte after the last element was passed over", "bytes after the last element were passed over")
            }
            Self::NulBytes => of("NUL byte was passed over", "NUL bytes were passed over"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_note_a_kind_with_the_first() {
        let mut passed_over = PassedOver::default();
        passed_over.add_named(Kind::UnknownStatement, "vw", 7);
        passed_over.add(Kind::ShortFaces, Some(8));
        passed_over.add_named(Kind::UnknownStatement, "zz", 9);
        passed_over.add_many(Kind::TrailingBytes, 0, None);
        assert_eq!(passed_over.first(Kind::UnknownStatement), Some((2, Some(7), "`vw`")));
        let notes = passed_over.into_notes();
        let facts: Vec<_> = notes.iter().map(|n| (n.kind, n.count, n.first_line)).collect();
        assert_eq!(facts, [("unknown_statement", 2, Some(7)), ("short_faces", 1, Some(8))]);
        assert_eq!(notes[0].message, "2 statements, the first `vw`, are none of OBJ and were passed over");
        assert_eq!(notes[1].message, "1 face has fewer than three corners and was left out");
    }
}
