//! `iorect scenes`: the built-in scenes.

use std::process::ExitCode;

use serde::Serialize;

use super::arguments::ListArguments;
use super::table::{Align, Table};
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
        let entries: Vec<Entry> = (builtin::all().iter())
            .map(|scene| Entry {
                name: scene.name,
                about: scene.about,
                file: format!("assets/scenes/{}.toml", scene.name),
            })
            .collect();
        print_json(&entries)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut table = Table::new(&[("name", Align::Left), ("what it shows", Align::Left)]);
    for scene in builtin::all() {
        table.row([scene.name.to_owned(), scene.about.to_owned()]);
    }
    print(&format!("{}\n  Open one with `iorect NAME`; its name works wherever a file does.\n", table.render()))?;
    Ok(ExitCode::SUCCESS)
}
