//! What loading a file passed over without harm to what it says.

/// One kind of thing in a file that loading passed over, and how often.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct LoadNote {
    /// A stable word, such as `unknown_statement`.
    pub kind: &'static str,
    pub count: u64,
    /// The line of the first, counted from 1, in text formats.
    pub first_line: Option<usize>,
    /// What was passed over, in words for people.
    pub message: String,
}

impl LoadNote {
    /// A note that belongs to no line.
    pub fn new(kind: &'static str, count: u64, message: String) -> Self {
        Self { kind, count, first_line: None, message }
    }
}
