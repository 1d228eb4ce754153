//! What text files may be written in: UTF-8, with or without a byte-order mark, and UTF-16.

use std::borrow::Cow;

const UTF8_MARK: &[u8] = b"\xef\xbb\xbf";

/// The byte order of text in UTF-16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Utf16 {
    Little,
    Big,
}

impl Utf16 {
    /// By the byte-order mark or, where there is none, because two characters of ASCII in a row begin the text.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0xff, 0xfe, ..] | [1..=255, 0, 1..=255, 0, ..] => Some(Self::Little),
            [0xfe, 0xff, ..] | [0, 1..=255, 0, 1..=255, ..] => Some(Self::Big),
            _ => None,
        }
    }
}

/// Text or data without its byte-order mark; UTF-16 as UTF-8.
pub(super) fn without_mark(bytes: &[u8]) -> Cow<'_, [u8]> {
    let Some(order) = Utf16::of(bytes) else {
        return Cow::Borrowed(bytes.strip_prefix(UTF8_MARK).unwrap_or(bytes));
    };
    let mark = if order == Utf16::Little { b"\xff\xfe" } else { b"\xfe\xff" };
    let units = bytes.strip_prefix(mark).unwrap_or(bytes).chunks_exact(2).map(|pair| match order {
        Utf16::Little => u16::from_le_bytes([pair[0], pair[1]]),
        Utf16::Big => u16::from_be_bytes([pair[0], pair[1]]),
    });
    // What cannot be decoded is wrong where it stands in a number, and no matter in a name.
    let text: String = char::decode_utf16(units).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    Cow::Owned(text.into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utf16(text: &str, bytes: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn marks_are_taken_off_and_utf16_is_decoded() {
        let text = "v 1 2 3 # caf\u{e9} \u{1f37a}\n";
        assert_eq!(without_mark(text.as_bytes()), text.as_bytes());
        assert_eq!(without_mark(format!("\u{feff}{text}").as_bytes()), text.as_bytes());
        for with_mark in [text.to_owned(), format!("\u{feff}{text}")] {
            assert_eq!(without_mark(&utf16(&with_mark, u16::to_le_bytes)), text.as_bytes());
            assert_eq!(without_mark(&utf16(&with_mark, u16::to_be_bytes)), text.as_bytes());
        }
        // Cut within a character, and half of a pair.
        assert_eq!(without_mark(b"a\0b\0\0"), &b"ab"[..]);
        assert_eq!(without_mark(b"\xff\xfe\x00\xd8a\0"), "\u{fffd}a".as_bytes());
    }

    #[test]
    fn what_is_no_utf16_is_left_alone() {
        for bytes in [&b""[..], b"v", b"v ", b"v 0 0", b"\0\0\0\0", b"ply\n", b"v\0\0\0"] {
            assert_eq!(Utf16::of(bytes), None);
            assert_eq!(without_mark(bytes), bytes);
        }
    }
}
