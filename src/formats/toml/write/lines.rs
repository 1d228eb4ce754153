//! Ends of lines and byte-order marks as a file had them: the editor of TOML gives every line a line feed and no more.

const MARK: char = '\u{feff}';

/// `edited`, which was made from `source`, with the ends of lines and the mark of `source`. In a file that mixes ends of lines, and in which
/// lines come or go, those between the first and the last edited line become the more frequent kind.
pub(super) fn ends_as_in(source: &str, edited: String) -> String {
    let (mark, body) = match source.strip_prefix(MARK) {
        Some(body) => (true, body),
        None => (false, source),
    };
    let (ends, returns) = (body.matches('\n').count(), body.matches("\r\n").count());
    // White space within values keeps its own ends.
    let edited = edited.replace("\r\n", "\n");
    let edited = if returns == 0 {
        edited
    } else if returns == ends {
        edited.replace('\n', "\r\n")
    } else {
        mixed(body, &edited, if 2 * returns > ends { "\r\n" } else { "\n" })
    };
    if mark { format!("{MARK}{edited}") } else { edited }
}

fn mixed(body: &str, edited: &str, end: &str) -> String {
    fn lines(text: &str) -> Vec<&str> {
        text.split_inclusive('\n').collect()
    }
    let is_same = |(a, b): &(&&str, &&str)| a.trim_end_matches(['\r', '\n']) == b.trim_end_matches(['\r', '\n']);
    let (old, new) = (lines(body), lines(edited));
    let head = old.iter().zip(&new).take_while(is_same).count();
    let most = old.len().min(new.len()) - head;
    let tail = old.iter().rev().zip(new.iter().rev()).take(most).take_while(is_same).count();
    let (was, is) = (&old[head..old.len() - tail], &new[head..new.len() - tail]);
    // Lines that were edited in their place have their own ends; of lines that come and go nobody knows which stands for which.
    let end_of = |index: usize| match was.get(index) {
        Some(line) if was.len() == is.len() && line.ends_with("\r\n") => "\r\n",
        Some(line) if was.len() == is.len() && line.ends_with('\n') => "\n",
        _ => end,
    };
    let middle = is.iter().enumerate().map(|(index, line)| line.replace('\n', end_of(index)));
    let (first, last) = (old[..head].concat(), old[old.len() - tail..].concat());
    std::iter::once(first).chain(middle).chain([last]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_lines_stay() {
        assert_eq!(ends_as_in("a\nb\n", "a\nc\n".into()), "a\nc\n");
        assert_eq!(ends_as_in("a\r\nb", "a\nc\nd".into()), "a\r\nc\r\nd");
        assert_eq!(ends_as_in("\u{feff}a\nb\n", "a\nc\n".into()), "\u{feff}a\nc\n");
        let source = "1\r\n2\n3\r\n4\r\n5\n";
        assert_eq!(ends_as_in(source, "1\n2\nthree\n4\n5\n".into()), "1\r\n2\nthree\r\n4\r\n5\n");
        assert_eq!(ends_as_in(source, "1\ntwo\n3\n4\n5\n".into()), "1\r\ntwo\n3\r\n4\r\n5\n");
        assert_eq!(ends_as_in(source, "1\n2\n5\n".into()), "1\r\n2\n5\n");
        assert_eq!(ends_as_in(source, "1\n2\n3\n4\n5\n".into()), source);
    }
}
