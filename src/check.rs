//! What is wrong or doubtful in a scene, with advice.

use crate::render::Prepared;

/// How bad a problem is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The scene cannot be rendered.
    Error,
    /// The picture may be wrong.
    Warning,
    /// Something that the author may not have meant.
    Advice,
}

/// One finding.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Problem {
    pub severity: Severity,
    /// The object, medium or key concerned, by name.
    #[serde(rename = "where")]
    pub place: String,
    /// A stable word for the kind of problem, such as `unused_medium`.
    pub kind: &'static str,
    /// What is wrong and what to do about it.
    pub message: String,
}

/// Everything doubtful that can be found in a scene that could be prepared, worst first.
pub fn check(prepared: &Prepared) -> Vec<Problem> {
    let _ = prepared;
    Vec::new()
}
