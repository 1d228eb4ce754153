//! `iorect check`: what is wrong or doubtful in a scene.

use std::borrow::Cow;
use std::process::ExitCode;
use std::sync::Arc;

use serde::Serialize;

use super::arguments::CheckArguments;
use super::preparation::prepare_shown;
use super::table::wrapped;
use super::{Failure, plural, print, print_json};
use crate::check::{Problem, Severity, check};
use crate::export::escape::escaped;
use crate::scene::SceneError;

#[derive(Serialize)]
struct Report<'a> {
    scene: Cow<'a, str>,
    problems: Vec<Problem>,
}

/// A scene that cannot be used at all is reported like any other problem, and is the only reason for exit code 2.
pub fn run(arguments: &CheckArguments) -> Result<ExitCode, Failure> {
    let CheckArguments { scene: arguments, deny } = arguments;
    let prepared = crate::formats::open(&arguments.scene).and_then(|description| prepare_shown(Arc::new(description)));
    let problems = match &prepared {
        Ok(prepared) => check(prepared),
        Err(error) => error.each().map(|error| unusable(&arguments.scene.to_string_lossy(), error)).collect(),
    };
    let is_usable = problems.iter().all(|problem| problem.severity != Severity::Error);
    let is_denied = deny.is_some_and(|deny| problems.iter().any(|problem| problem.severity <= deny));
    let report = Report { scene: arguments.scene.to_string_lossy(), problems };
    if arguments.json {
        print_json(&report)?;
    } else {
        print(&summary(&report))?;
    }
    Ok(ExitCode::from(match (is_usable, is_denied) {
        (false, _) => 2,
        (true, true) => 1,
        (true, false) => 0,
    }))
}

fn unusable(scene: &str, error: &SceneError) -> Problem {
    Problem {
        severity: Severity::Error,
        place: error.place.as_ref().map_or_else(|| scene.to_owned(), ToString::to_string),
        kind: "unusable",
        message: error.message.clone(),
        spot: None,
    }
}

fn summary(report: &Report<'_>) -> String {
    if report.problems.is_empty() {
        return format!("{}: nothing wrong, nothing doubtful\n", escaped(&report.scene));
    }
    let mut text = String::new();
    for problem in &report.problems {
        let severity = match problem.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Advice => "advice",
        };
        text += &wrapped(&format!("{severity:<8} {}:", problem.place), &problem.message, 9);
    }
    let count = |severity| report.problems.iter().filter(|problem| problem.severity == severity).count();
    let (errors, warnings, advice) = (count(Severity::Error), count(Severity::Warning), count(Severity::Advice));
    text += &format!(
        "{}: {errors} error{}, {warnings} warning{}, {advice} piece{} of advice\n",
        escaped(&report.scene),
        plural(errors),
        plural(warnings),
        plural(advice)
    );
    text
}
