//! Text from files made harmless: what a terminal would obey and a reader would not see is written out instead.
//!
//! Names of scenes and objects, keys, tokens of meshes and paths may hold any character. Escape sequences can recolour and overwrite a
//! terminal or send it commands; controls of direction can make a line read as another.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::Path;

/// Characters of a name that are shown at the most.
const MOST_OF_NAME: usize = 100;

/// As one line: control characters and controls of direction as in `\u{1b}` and `\n`.
pub fn escaped(text: &str) -> Cow<'_, str> {
    replaced(text, is_harmful, |c, out| out.extend(c.escape_default()))
}

/// [`escaped`], but for the ends of lines.
pub fn escaped_lines(text: &str) -> Cow<'_, str> {
    replaced(text, |c| c != '\n' && is_harmful(c), |c, out| out.extend(c.escape_default()))
}

/// What is left to escape in JSON, where every character that may stand between strings is kept: JSON itself asks only for those below
/// U+0020.
pub fn escaped_json(json: &str) -> Cow<'_, str> {
    replaced(
        json,
        |c| c != '\n' && is_harmful(c),
        |c, out| {
            let _ = write!(out, "\\u{:04x}", c as u32);
        },
    )
}

/// A name as a short line.
pub fn short_name(name: &str) -> String {
    elided(name, MOST_OF_NAME)
}

/// The beginning of `text` as a line of at most so many characters (escapes may add some), with an ellipsis where it is longer.
pub fn elided(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        None => escaped(text).into_owned(),
        Some(_) => {
            let end = text.char_indices().nth(most - 1).map_or(0, |(at, _)| at);
            escaped(&text[..end]).trim_end().to_owned() + "…"
        }
    }
}

/// A path, whole, as a line; what is no Unicode in it is replaced.
pub fn shown(path: &Path) -> String {
    escaped(&path.to_string_lossy()).into_owned()
}

/// Control characters (C0, DEL, C1), line and paragraph separators, and marks, embeddings, overrides and isolates of direction. All are
/// of the basic plane.
fn is_harmful(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

fn replaced(text: &str, is_bad: impl Fn(char) -> bool, write: impl Fn(char, &mut String)) -> Cow<'_, str> {
    let Some(first) = text.find(&is_bad) else { return Cow::Borrowed(text) };
    let mut out = String::with_capacity(text.len() + 16);
    out.push_str(&text[..first]);
    for c in text[first..].chars() {
        if is_bad(c) { write(c, &mut out) } else { out.push(c) }
    }
    Cow::Owned(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_written_out() {
        assert_eq!(escaped("red\u{1b}[31m\u{7f}\u{9b}2J"), "red\\u{1b}[31m\\u{7f}\\u{9b}2J");
        assert_eq!(escaped("a\nb\tc\rd\0"), "a\\nb\\tc\\rd\\u{0}");
        assert_eq!(escaped("\u{202e}gnp.exe\u{2066}\u{2029}"), "\\u{202e}gnp.exe\\u{2066}\\u{2029}");
        assert_eq!(escaped_lines("one\ntwo\u{7}\n"), "one\ntwo\\u{7}\n");
        // Letters of every script, signs and emoji stay, and so does what is harmless already.
        let harmless = "Wasserglas – näher · שלום 水 👓 \\u{1b}";
        assert!(matches!(escaped(harmless), Cow::Borrowed(text) if text == harmless));
    }

    #[test]
    fn every_control_character_is_harmful() {
        let harmful: Vec<u32> = (0..=0x10_ffff).filter(|&c| char::from_u32(c).is_some_and(is_harmful)).collect();
        let expected: Vec<u32> = (0..0x20)
            .chain(0x7f..=0x9f)
            .chain([0x61c, 0x200e, 0x200f])
            .chain(0x2028..=0x202e)
            .chain(0x2066..=0x2069)
            .collect();
        assert_eq!(harmful, expected);
    }

    #[test]
    fn escaped_json_says_the_same() {
        let text = "a\u{9b}\u{7f}\u{202e}\u{1b}\n\"é";
        let json = serde_json::to_string_pretty(&[text]).unwrap();
        let harmless = escaped_json(&json);
        assert!(harmless.chars().all(|c| c == '\n' || !is_harmful(c)), "{harmless}");
        assert_eq!(serde_json::from_str::<Vec<String>>(&harmless).unwrap(), [text]);
    }

    #[test]
    fn long_names_are_elided() {
        assert_eq!(elided("water", 5), "water");
        assert_eq!(elided("waters", 5), "wate…");
        assert_eq!(elided("äöü  ßx", 6), "äöü…");
        assert_eq!(elided("\u{1b}\u{1b}\u{1b}", 2), "\\u{1b}…");
        assert_eq!(short_name(&"x".repeat(1 << 20)).chars().count(), MOST_OF_NAME);
    }
}
