//! `iorect scenes`: the built-in scenes.

use std::process::ExitCode;

use serde::Serialize;

use super::arguments::ListArguments;
use super::table::Table;
use super::{Failure, print, print_json};
use crate::formats::builtin;

#[derive(Serialize)]
struct Entry {
    name: &'static str,
    about: &'static str,
    /// Where the scene stands in the source tree.
    file: String,
}

pub fn run(arguments: &ListArguments) -> Result<ExitCode, Failure> {
    if arguments.json {
        let file = |name| format!("assets/scenes/{name}.toml");
        let entries = builtin::all().iter().map(|s| Entry { name: s.name, about: s.about, file: file(s.name) });
        print_json(&entries.collect::<Vec<_>>())?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut table = Table::new("name,what it shows");
    for scene in builtin::all() {
        table.row([scene.name.to_owned(), scene.about.to_owned()]);
    }
    print(&format!("{}\n  Open one with `iorect NAME`; its name works wherever a file does.\n", table.render()))?;
    Ok(ExitCode::SUCCESS)
}
