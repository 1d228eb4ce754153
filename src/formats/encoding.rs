//! What text files may be written in: UTF-8, with or without a byte-order mark, and UTF-16.

use std::borrow::Cow;

/// What joins the bytes of text in UTF-16, by the byte-order mark or, where there is none, because two characters of ASCII in a row begin it.
pub(super) fn utf16(bytes: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    match bytes {
        [0xff, 0xfe, ..] | [1..=255, 0, 1..=255, 0, ..] => Some(u16::from_le_bytes),
        [0xfe, 0xff, ..] | [0, 1..=255, 0, 1..=255, ..] => Some(u16::from_be_bytes),
        _ => None,
    }
}

/// Text or data without its byte-order mark; UTF-16 as UTF-8.
pub(super) fn without_mark(bytes: &[u8]) -> Cow<'_, [u8]> {
    let Some(join) = utf16(bytes) else {
        return Cow::Borrowed(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    };
    let mut units = bytes.chunks_exact(2).map(|pair| join([pair[0], pair[1]])).peekable();
    units.next_if_eq(&0xfeff);
    // What cannot be decoded is wrong where it stands in a number, and no matter in a name.
    let text: String = char::decode_utf16(units).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    Cow::Owned(text.into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(text: &str, bytes: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn marks_are_taken_off_and_utf16_is_decoded() {
        let text = "v 1 2 3 # caf\u{e9} \u{1f37a}\n";
        assert_eq!(without_mark(text.as_bytes()), text.as_bytes());
        assert_eq!(without_mark(format!("\u{feff}{text}").as_bytes()), text.as_bytes());
        for with_mark in [text.to_owned(), format!("\u{feff}{text}")] {
            assert_eq!(without_mark(&encoded(&with_mark, u16::to_le_bytes)), text.as_bytes());
            assert_eq!(without_mark(&encoded(&with_mark, u16::to_be_bytes)), text.as_bytes());
        }
        // Cut within a character, and half of a pair.
        assert_eq!(without_mark(b"a\0b\0\0"), &b"ab"[..]);
        assert_eq!(without_mark(b"\xff\xfe\x00\xd8a\0"), "\u{fffd}a".as_bytes());
    }

    #[test]
    fn what_is_no_utf16_is_left_alone() {
        for bytes in [&b""[..], b"v", b"v ", b"v 0 0", b"\0\0\0\0", b"ply\n", b"v\0\0\0"] {
            assert!(utf16(bytes).is_none());
            assert_eq!(without_mark(bytes), bytes);
        }
    }
}
