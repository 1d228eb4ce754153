//! `iorect convert`: scenes from one format to another.

use std::path::Path;
use std::process::ExitCode;

use super::arguments::ConvertArguments;
use super::{Failure, print};
use crate::export::escape::shown;
use crate::formats;
use crate::writing::require_writable;

pub fn run(arguments: &ConvertArguments) -> Result<ExitCode, Failure> {
    let ConvertArguments { from, to } = arguments;
    if !to.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        let advice = "scenes are written as `.toml` so far";
        return Err(Failure::wrong(format!("{}: {advice}; give the file that ending", to.display())));
    }
    require_writable(to).map_err(|error| Failure::Wrong(error.into()))?;
    let description = formats::open(from)?;
    formats::save(&description, to).map_err(|error| Failure::Failed(error.into()))?;
    let objects = description.objects.iter().count();
    print(&format!("wrote {}: {objects} object{}\n", shown(Path::new(to)), super::plural(objects)))?;
    Ok(ExitCode::SUCCESS)
}
