//! What reading a scene of another format approximates or leaves out: told once a kind.

use crate::scene::LoadNote;

/// Most names that a note lists.
const MOST_NAMES: usize = 3;

#[derive(Debug)]
struct Entry {
    kind: &'static str,
    what: String,
    count: u64,
    /// The first of those concerned.
    names: Vec<String>,
}

/// In the order in which they were met, each kind once.
#[derive(Debug, Default)]
pub(super) struct Tally(Vec<Entry>);

impl Tally {
    /// Counts one. `what` says what became of it, in words that a list of names follows; `name` is empty where it has none.
    pub fn add(&mut self, kind: &'static str, what: &str, name: &str) {
        let entry = match self.0.iter_mut().position(|entry| entry.kind == kind) {
            Some(index) => &mut self.0[index],
            None => {
                self.0.push(Entry { kind, what: what.to_owned(), count: 0, names: Vec::new() });
                self.0.last_mut().expect("it was just added")
            }
        };
        entry.count += 1;
        if entry.names.len() < MOST_NAMES && !name.is_empty() && !entry.names.iter().any(|known| known == name) {
            entry.names.push(name.to_owned());
        }
    }

    pub fn into_notes(self) -> Vec<LoadNote> {
        let note = |Entry { kind, what, count, names }: Entry| {
            let more = count - names.len() as u64;
            let list = names.join(", ");
            let message = match (names.is_empty(), more) {
                (true, _) if count > 1 => format!("{what} ({count} of them)"),
                (true, _) => what,
                (false, 0) => format!("{what}: {list}"),
                (false, more) => format!("{what}: {list} and {more} more"),
            };
            LoadNote::new(kind, count, message)
        };
        self.0.into_iter().map(note).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_note_a_kind_with_the_first_names() {
        let mut tally = Tally::default();
        ["a", "b", "a", "c", "d"].iter().for_each(|name| tally.add("rough", "rough glass is shown as smooth", name));
        tally.add("lines", "lines are left out", "");
        tally.add("one", "this is so", "x");
        let notes = tally.into_notes();
        let texts: Vec<(&str, u64, &str)> = notes.iter().map(|n| (n.kind, n.count, n.message.as_str())).collect();
        assert_eq!(
            texts,
            [
                ("rough", 5, "rough glass is shown as smooth: a, b, c and 2 more"),
                ("lines", 1, "lines are left out"),
                ("one", 1, "this is so: x")
            ]
        );
    }
}
