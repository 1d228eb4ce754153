//! Lines of text as files have them: ended by LF, CRLF or CR, and padded with NUL bytes.

/// Goes through the lines of a file.
#[derive(Debug, Clone)]
pub(super) struct Lines<'a> {
    /// What is still to come.
    pub rest: &'a [u8],
    /// Number of the last line that was given, from 1.
    pub number: usize,
    /// NUL bytes at the ends of lines so far, which stand for nothing.
    pub padding: Padding,
}

/// NUL bytes that were passed over.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Padding {
    pub bytes: u64,
    pub first_line: usize,
}

impl<'a> Lines<'a> {
    pub fn new(rest: &'a [u8]) -> Self {
        Self { rest, number: 0, padding: Padding::default() }
    }

    /// The next line without what ends it, and without white space and NUL bytes around it.
    #[inline]
    pub fn next(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let is_end = |&byte: &u8| byte == b'\n' || byte == b'\r';
        let length = self.rest.iter().position(is_end).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(length);
        self.rest = match rest {
            [b'\r', b'\n', rest @ ..] | [_, rest @ ..] => rest,
            [] => rest,
        };
        self.number += 1;
        let line = line.trim_ascii();
        if let [0, ..] | [.., 0] = line { Some(self.without_padding(line)) } else { Some(line) }
    }

    #[cold]
    fn without_padding(&mut self, line: &'a [u8]) -> &'a [u8] {
        let is_padding = |byte: &u8| *byte == 0 || byte.is_ascii_whitespace();
        let start = line.iter().position(|byte| !is_padding(byte)).unwrap_or(line.len());
        let end = line.iter().rposition(|byte| !is_padding(byte)).map_or(start, |last| last + 1);
        let outside = line[..start].iter().chain(&line[end..]);
        if self.padding.bytes == 0 {
            self.padding.first_line = self.number;
        }
        self.padding.bytes += outside.filter(|byte| **byte == 0).count() as u64;
        &line[start..end]
    }
}

/// A number as text. Those that are none come in several spellings, such as `nan`, `-nan(ind)` and `1.#QNAN`.
#[inline]
pub(super) fn number(word: &str) -> Result<f64, String> {
    word.parse().or_else(|_| {
        let lower = word.to_ascii_lowercase();
        if ["nan(", "#ind", "#qnan", "#snan", "#inf"].iter().any(|mark| lower.contains(mark)) {
            Ok(f64::NAN)
        } else {
            Err(format!("{} is not a number", shown(word.as_bytes())))
        }
    })
}

/// A word of a file as errors show it: no longer than a few words, and without what a terminal would obey.
pub(super) fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let cut = &word[..word.len().min(LONGEST)];
    let text = String::from_utf8_lossy(cut).escape_debug().to_string();
    if cut.len() < word.len() { format!("`{text}…`") } else { format!("`{text}`") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> (Vec<(usize, &[u8])>, Padding) {
        let mut lines = Lines::new(bytes);
        let mut all = Vec::new();
        while let Some(line) = lines.next() {
            all.push((lines.number, line));
        }
        (all, lines.padding)
    }

    #[test]
    fn every_kind_of_line_end() {
        let expected: Vec<(usize, &[u8])> = vec![(1, b"a b"), (2, b""), (3, b"c"), (4, b"d")];
        for text in ["a b\n\nc\nd", " a b\r\n\r\nc\r\nd\r\n", "a b\r\rc\rd\r", "a b\t\n\r\nc\rd"] {
            assert_eq!(all(text.as_bytes()), (expected.clone(), Padding::default()), "{text:?}");
        }
        assert_eq!(all(b"").0, []);
    }

    #[test]
    fn padding_is_taken_off_and_counted() {
        let (lines, padding) = all(b"a\n\0b\0\0 \0\nc\0d\n\0\0\0");
        assert_eq!(lines, [(1, &b"a"[..]), (2, b"b"), (3, b"c\0d"), (4, b"")]);
        assert_eq!(padding, Padding { bytes: 7, first_line: 2 });
    }

    #[test]
    fn numbers_that_are_none() {
        for word in ["nan", "-NaN", "-nan(ind)", "NAN(0x7)", "1.#QNAN", "-1.#IND00", "1.#INF"] {
            assert!(number(word).unwrap().is_nan(), "{word}");
        }
        assert_eq!((number("-1e3"), number("inf")), (Ok(-1000.0), Ok(f64::INFINITY)));
        assert_eq!(number("1,5"), Err("`1,5` is not a number".into()));
    }

    #[test]
    fn words_for_errors_are_short_and_plain() {
        assert_eq!(shown(b"vw"), "`vw`");
        assert_eq!(shown(b"\x1b[31mred\xff"), "`\\u{1b}[31mred\u{fffd}`");
        assert_eq!(shown(&[b'x'; 1000]).len(), 40 + "`…`".len());
    }
}
