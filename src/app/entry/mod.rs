//! What a person types into a field: numbers with a decimal point or comma, small calculations, names from the catalogue. What is
//! refused comes with the reason, in a sentence for the person.

mod expression;
mod ior;
mod units;

use std::fmt;

pub use self::ior::ior;
pub use self::units::{distance, number, number_within, whole};

/// Why a text is not taken: a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal(pub String);

impl Refusal {
    fn new(sentence: impl Into<String>) -> Self {
        Self(sentence.into())
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The most of a text that a message repeats.
const QUOTED: usize = 24;

/// A text in quotation marks, its middle left out where it is long.
fn quoted(text: &str) -> String {
    let text = text.trim();
    if text.chars().count() <= QUOTED {
        return format!("“{text}”");
    }
    let head: String = text.chars().take(QUOTED - 1).collect();
    format!("“{}…”", head.trim_end())
}
