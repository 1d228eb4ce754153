//! Tables as comma-separated values (RFC 4180).

use ::csv::{Terminator, WriterBuilder};
use serde::Serialize;

/// The names of the columns, then a line for each row. A row is a tuple, which may hold further tuples and arrays: each value in it is a cell, `None`
/// an empty one. Numbers have all their digits.
///
/// # Panics
/// When a row has not as many cells as there are columns.
pub fn text<'a>(columns: impl IntoIterator<Item = &'a str>, rows: impl IntoIterator<Item: Serialize>) -> String {
    const CELLS: &str = "writing to memory cannot fail, and a row has a cell for each column";
    let mut writer = WriterBuilder::new().has_headers(false).terminator(Terminator::CRLF).from_writer(Vec::new());
    writer.write_record(columns).expect(CELLS);
    rows.into_iter().for_each(|row| writer.serialize(row).expect(CELLS));
    String::from_utf8(writer.into_inner().expect(CELLS)).expect("cells are text")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_have_to_be_and_tuples_are_flat() {
        let rows = [("plain", [Some(0.1), None], true), ("a, \"b\"\nc", [Some(1e-300), Some(f64::NAN)], false)];
        let expected = "name,x,y,z\r\nplain,0.1,,true\r\n\"a, \"\"b\"\"\nc\",1e-300,NaN,false\r\n";
        assert_eq!(text(["name", "x", "y", "z"], rows), expected);
    }

    #[test]
    #[should_panic(expected = "a cell for each column")]
    fn a_missing_cell_is_a_mistake() {
        text(["a", "b"], [("alone",)]);
    }
}
