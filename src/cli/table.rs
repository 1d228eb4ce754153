//! Plain tables for terminals: columns as wide as they need, no lines to trip over.

use crate::export::escape::elided;

/// Characters of a cell that are shown at the most: room for every kind of event.
const MOST_OF_CELL: usize = 160;

/// A table of text with a heading.
pub struct Table {
    columns: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// With the names of its columns, commas between them. `>` before a name: its cells are numbers and stand at the right.
    pub fn new(columns: &'static str) -> Self {
        Self { columns: columns.split(',').collect(), rows: Vec::new() }
    }

    /// Adds a row with one cell per column. Cells are lines: long ones are elided, and control characters in them are escaped.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let row: Vec<String> = cells.into_iter().map(|cell| elided(&cell, MOST_OF_CELL)).collect();
        debug_assert_eq!(row.len(), self.columns.len());
        self.rows.push(row);
    }

    /// The whole, each line indented by two and ended.
    pub fn render(&self) -> String {
        let heading: Vec<String> = self.columns.iter().map(|name| name.trim_start_matches('>').to_owned()).collect();
        let rows = || std::iter::once(&heading).chain(&self.rows);
        let width = |column: usize| rows().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..heading.len()).map(width).collect();
        let mut text = String::new();
        for row in rows() {
            let mut line = String::new();
            for ((cell, name), width) in row.iter().zip(&self.columns).zip(&widths) {
                let is_number = name.starts_with('>');
                line += &if is_number { format!("  {cell:>width$}") } else { format!("  {cell:<width$}") };
            }
            text += line.trim_end();
            text.push('\n');
        }
        text
    }
}

/// Columns that a line of running text may have.
const LINE: usize = 100;

/// Characters of a label, and of a text, that are shown at the most: both may hold names.
const MOST_OF_LABEL: usize = 200;
const MOST_OF_TEXT: usize = 2000;

/// `text` behind `label`, broken between words; further lines are indented by `indent`. What is very long is elided.
pub fn wrapped(label: &str, text: &str, indent: usize) -> String {
    let mut lines = elided(label, MOST_OF_LABEL);
    let text = elided(text, MOST_OF_TEXT);
    let mut used = lines.chars().count();
    for (index, word) in text.split_whitespace().enumerate() {
        let width = word.chars().count();
        if index > 0 && used + 1 + width > LINE {
            lines += &format!("\n{:indent$}{word}", "");
            used = indent + width;
        } else {
            if !lines.ends_with(' ') {
                lines.push(' ');
                used += 1;
            }
            lines += word;
            used += width;
        }
    }
    lines.push('\n');
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_broken_between_words() {
        let word = "abcdefghi";
        let text = wrapped("note:", &[word; 12].join(" "), 4);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(lines[0].starts_with("note: abc") && lines[1].starts_with("    abc"));
        assert!(lines.iter().all(|line| line.len() <= LINE && line.ends_with(word)));
        // A word that fits nowhere stands on a line of its own; nothing is lost.
        let long = "x".repeat(300);
        assert_eq!(wrapped("a", &format!("b {long} c"), 2), format!("a b\n  {long}\n  c\n"));
        let endless = wrapped(&"l".repeat(1 << 20), &"word ".repeat(1 << 20), 2);
        assert!(endless.len() < 4000 && endless.trim_end().ends_with('…'), "{} bytes", endless.len());
    }

    #[test]
    fn columns_line_up_in_characters_not_bytes() {
        let mut table = Table::new("name,>n");
        table.row(["äöü".into(), "1.5".into()]);
        table.row(["water".into(), "1".into()]);
        assert_eq!(table.render(), "  name     n\n  äöü    1.5\n  water    1\n");
    }
}
