//! All that is wrong with a text that is not TOML: the parser stops at the first mistake, so that the text is taken apart into statements, and
//! the tables without a mistake are read on.

use std::ops::Range;

use toml_edit::{Document, TomlError};

/// Mistakes that are looked for; a text with more is hardly a scene.
const MOST_MISTAKES: usize = 200;
/// Mistakes that only whole tables have, such as keys that are there twice.
const MOST_DOUBLES: usize = 20;

/// What is wrong at a byte of the text; `None`: with the text as a whole.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mistake {
    pub at: Option<usize>,
    pub message: String,
}

impl Mistake {
    /// `start`: where the text that was parsed begins.
    pub fn new(error: &TomlError, start: usize) -> Self {
        let at = error.span().map(|span| start + span.start);
        Self { at, message: error.message().trim().replace('\n', ", ") }
    }
}

/// A text that is not TOML, and what can be read of it.
pub(super) struct Salvage {
    /// At least one.
    pub mistakes: Vec<Mistake>,
    /// The text without the tables that have mistakes. What is left is where it was.
    pub rest: String,
    /// The first keys of those tables; `None`: they could be any.
    lost: Option<Vec<String>>,
}

impl Salvage {
    /// Whether a table of that name may be among those that were left out.
    pub fn has_lost(&self, key: &str) -> bool {
        self.lost.as_ref().is_none_or(|lost| lost.iter().any(|lost| lost == key))
    }
}

/// A table with its subtables, or what stands before the first one.
#[derive(Default)]
struct Group {
    /// The first key of its headers; `None` where there is none that can be read.
    key: Option<String>,
    statements: Vec<Range<usize>>,
    is_broken: bool,
}

/// Takes `text` apart, which [`Document::parse`] refuses with `first`.
pub(super) fn salvage(text: &str, first: &TomlError) -> Salvage {
    let mut groups = groups(text);
    let mut mistakes = Vec::new();
    'all: for group in &mut groups {
        for statement in &group.statements {
            if let Err(error) = Document::parse(&text[statement.clone()]) {
                mistakes.push(Mistake::new(&error, statement.start));
                group.is_broken = true;
                if mistakes.len() == MOST_MISTAKES {
                    break 'all;
                }
            }
        }
    }
    let mut rest = without_broken(text, &groups);
    for _ in 0..MOST_DOUBLES {
        let Err(error) = Document::parse(&*rest) else { break };
        let mistake = Mistake::new(&error, 0);
        let is_in = |group: &&mut Group| {
            mistake.at.is_some_and(|at| group.statements.iter().any(|statement| statement.contains(&at)))
        };
        let Some(group) = groups.iter_mut().find(is_in).filter(|group| !group.is_broken) else { break };
        group.is_broken = true;
        mistakes.push(mistake);
        rest = without_broken(text, &groups);
    }
    if mistakes.is_empty() {
        mistakes.push(Mistake::new(first, 0));
    }
    let lost = groups.iter().filter(|group| group.is_broken).map(|group| group.key.clone()).collect();
    Salvage { mistakes, rest, lost }
}

/// `text` with spaces in the place of all that is broken.
fn without_broken(text: &str, groups: &[Group]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    let broken = groups.iter().filter(|group| group.is_broken).flat_map(|group| group.statements.iter().cloned());
    for byte in broken.flatten() {
        if !matches!(bytes[byte], b'\n' | b'\r') {
            bytes[byte] = b' ';
        }
    }
    // Whole statements were replaced, and with them whole characters.
    String::from_utf8(bytes).unwrap_or_default()
}

fn groups(text: &str) -> Vec<Group> {
    let mut groups = vec![Group::default()];
    let mut current = 0;
    for statement in statements(text) {
        let words = text[statement.clone()].trim_start_matches('\u{feff}').trim_start();
        if words.starts_with('[') {
            let header = header(words);
            let parent = header
                .filter(|header| header.is_sub)
                .and_then(|header| groups.iter().rposition(|group| group.key.as_deref() == Some(header.key)));
            current = parent.unwrap_or_else(|| {
                groups.push(Group { key: header.map(|header| header.key.to_owned()), ..Group::default() });
                groups.len() - 1
            });
        }
        groups[current].statements.push(statement);
    }
    groups
}

#[derive(Clone, Copy)]
struct Header<'a> {
    key: &'a str,
    /// Whether it goes on after that key: `[key.part]`.
    is_sub: bool,
}

/// The first key of a line that can only be a header: no element of an array looks like that.
fn header(line: &str) -> Option<Header<'_>> {
    let inside = line.strip_prefix('[')?;
    let inside = inside.strip_prefix('[').unwrap_or(inside).trim_start();
    let key = &inside[..bare_key(inside)];
    let is_value = matches!(key, "true" | "false" | "inf" | "nan");
    let after = inside[key.len()..].trim_start();
    (key.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && !is_value && after.starts_with([']', '.']))
        .then(|| Header { key, is_sub: after.starts_with('.') })
}

/// Bytes of the bare key that a text begins with.
fn bare_key(text: &str) -> usize {
    text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '-')).unwrap_or(text.len())
}

/// Whether a line begins with `key =` or `key.part =`.
fn is_assignment(line: &str) -> bool {
    let key = line.find(|c: char| !(c.is_ascii_alphanumeric() || "_-. \t".contains(c))).unwrap_or(line.len());
    line[key..].starts_with('=') && bare_key(line) > 0
}

/// Headers, and keys with their values, each up to the end of its line: all of the text. On text that is TOML this is exact.
fn statements(text: &str) -> Vec<Range<usize>> {
    let mut statements = Vec::new();
    let mut start = 0;
    while start < text.len() {
        let end = start + statement_length(&text[start..]);
        statements.push(start..end);
        start = end;
    }
    statements
}

/// Bytes of the statement that `text` begins with. A bracket that is not closed ends before the next line that can only begin another one.
fn statement_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut open: Vec<u8> = Vec::new();
    // The last byte that means something.
    let mut last = b'\n';
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            b'#' => {
                at += text[at..].find('\n').unwrap_or(text.len() - at);
                continue;
            }
            quote @ (b'"' | b'\'') => {
                at += string_length(&text[at..], quote);
                last = quote;
                continue;
            }
            b'\n' => {
                let line = text[at + 1..].lines().next().unwrap_or_default().trim_start();
                let begins_another = match open.last() {
                    None => true,
                    Some(b'[') => header(line).is_some() || is_assignment(line),
                    // In an inline table a key follows a comma.
                    Some(_) => header(line).is_some() || (is_assignment(line) && !matches!(last, b'{' | b',')),
                };
                if begins_another {
                    return at + 1;
                }
            }
            b' ' | b'\t' | b'\r' => {}
            byte => {
                match byte {
                    b'[' | b'{' => open.push(byte),
                    b']' | b'}' => _ = open.pop(),
                    _ => {}
                }
                last = byte;
            }
        }
        at += 1;
    }
    text.len()
}

/// Bytes of the string that `text` begins with; up to the end of the line where it is not closed.
fn string_length(text: &str, quote: u8) -> usize {
    let bytes = text.as_bytes();
    let is_long = bytes.len() >= 3 && bytes[..3] == [quote; 3];
    let line = text.find('\n').unwrap_or(text.len());
    let mut at = if is_long { 3 } else { 1 };
    while at < bytes.len() && (is_long || at < line) {
        match bytes[at] {
            b'\\' if quote == b'"' => at += 1,
            byte if byte == quote && !is_long => return at + 1,
            byte if byte == quote && bytes[at..].starts_with(&[quote; 3]) => {
                // Up to two more quotes belong to the string itself.
                let more = bytes[at..].iter().take_while(|byte| **byte == quote).count().min(5);
                return at + more;
            }
            _ => {}
        }
        at += 1;
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(text: &str) -> Vec<&str> {
        statements(text).into_iter().map(|range| &text[range]).collect()
    }

    #[test]
    fn statements_of_sound_text_are_sound() {
        let odd = "a = \"#[\\\"\" # [\nb = '''\n[c]\n''''\nd = { e = [\n [1, 2], # (\n [true],\n],\n f.g = 2,\n}\n\"h i\" = 'x'\n[k . l]\r\nm = \"\"\"\\\"\"\"\"\n";
        let built_in = crate::formats::builtin::all().iter().map(|scene| scene.text);
        for text in built_in.chain([odd]) {
            assert!(Document::parse(text).is_ok());
            for piece in pieces(text) {
                assert!(Document::parse(piece).is_ok(), "{piece}");
            }
            assert_eq!(pieces(text).concat(), text);
        }
        assert_eq!(pieces(odd).len(), 6, "{:#?}", pieces(odd));
    }

    #[test]
    fn what_is_not_closed_ends_before_the_next_statement() {
        let text = "a = [1,\n2\nb = { c = 1\nd = 2\ne = \"x\nf = {\n g = [\n[[h]]\n[i.j]\nk = '''\nl = 1\n";
        let expected = [
            "a = [1,\n2\n",
            "b = { c = 1\n",
            "d = 2\n",
            "e = \"x\n",
            "f = {\n g = [\n",
            "[[h]]\n",
            "[i.j]\n",
            "k = '''\n",
            "l = 1\n",
        ];
        assert_eq!(pieces(text), expected);
    }

    #[test]
    fn the_rest_is_where_it_was_and_has_no_part_of_a_broken_table() {
        let text = "name = \"ä\"\n[[solid]]\nname = \"ö\"\n[light.x]\na = 1\n[solid.shape]\nb = = 1\n[camera]\n";
        let first = Document::parse(text).unwrap_err();
        let salvage = salvage(text, &first);
        assert_eq!((salvage.mistakes.len(), salvage.rest.len()), (1, text.len()));
        assert_eq!(salvage.mistakes[0].at, text.find("= 1\n[camera]"));
        let words: Vec<&str> = salvage.rest.split_whitespace().collect();
        assert_eq!(words, ["name", "=", "\"ä\"", "[light.x]", "a", "=", "1", "[camera]"]);
        assert!(salvage.has_lost("solid") && !salvage.has_lost("camera"));
    }

    proptest::proptest! {
        #[test]
        fn no_text_is_too_much(text in "[\\[\\]{}\"'=#,.\\\\a-c1 \n\räß\u{feff}]{0,60}") {
            assert_eq!(pieces(&text).concat(), text);
            if let Err(first) = Document::parse(&*text) {
                let salvage = salvage(&text, &first);
                assert!(!salvage.mistakes.is_empty() && salvage.rest.len() == text.len());
            }
        }
    }
}
