//! Messages are written for the terminal, where names and keys stand between backticks; in the window they stand between quotes.

/// `text` with “…” instead of pairs of backticks; one without a partner is left out.
pub fn quoted(text: &str) -> String {
    let pairs = text.matches('`').count() / 2;
    let mut result = String::with_capacity(text.len() + 8);
    for (index, part) in text.split('`').enumerate() {
        if index > 0 && index <= 2 * pairs {
            result.push(if index % 2 == 1 { '“' } else { '”' });
        }
        result.push_str(part);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn pairs_become_quotes_and_none_is_left() {
        assert_eq!(quoted("`a` and `b`: 1"), "“a” and “b”: 1");
        assert_eq!(quoted("unknown key `flavour"), "unknown key flavour");
        assert_eq!(quoted("`a` and ` b"), "“a” and  b");
        for text in ["", "plain", "`", "``", "`a", "a`", "```a``", "ä`ö`ü`"] {
            let shown = quoted(text);
            assert!(!shown.contains('`'));
            assert_eq!(shown.matches('“').count(), shown.matches('”').count(), "{shown}");
            assert!(shown.replace(['“', '”'], "") == text.replace('`', ""));
        }
    }
}
