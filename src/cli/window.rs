//! `iorect [SCENE]`: the window, or, where none can be opened, a comparison as a file.

use std::ffi::OsStr;
use std::path::Path;
use std::process::ExitCode;

use clap::Parser;

use super::arguments::{Arguments, Command, WindowArguments};
use super::image::DEFAULT_SPP;
use super::{Failure, compare, shell_word, tell};
use crate::formats::builtin;
use crate::scene::SceneError;

/// What is written where no window can be opened.
const FALLBACK_PICTURE: &str = "iorect-comparison.png";
/// Seconds after which its rendering stops; with preparation it takes less than half a minute.
const FALLBACK_SECS: f64 = 20.0;

/// Why the window did not do what it was asked for.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    #[error("no window can be opened: {0}")]
    NoWindow(String),
    #[error(
        "this iorect was built without its window: build it with the default features (`cargo build --release`), or use \
         `iorect render` or `iorect compare`"
    )]
    NotBuilt,
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("{0}")]
    Other(String),
}

pub fn run(
    arguments: &WindowArguments,
    open_window: impl FnOnce(&WindowArguments) -> Result<(), WindowError>,
) -> Result<ExitCode, Failure> {
    match open_window(arguments) {
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(WindowError::Scene(error)) => Err(error.into()),
        Err(error @ WindowError::NoWindow(_)) if arguments.screenshot.is_none() => {
            compare_instead(arguments.scene.as_deref().unwrap_or(Path::new(builtin::DEFAULT)), &error)
        }
        Err(error) => Err(Failure::Failed(error.into())),
    }
}

/// The windowing crate begins its message with the place in its own source that it comes from: `… at …/mod.rs:765: no display`.
fn without_source_place(message: &str) -> String {
    let from_start = message.find(": ");
    let reason = message.rfind(".rs:").and_then(|at| message[at..].find(": ").map(|colon| &message[at + colon..]));
    match (from_start, reason) {
        (Some(start), Some(reason)) => format!("{}{reason}", &message[..start]),
        _ => message.to_owned(),
    }
}

fn compare_instead(scene: &Path, error: &WindowError) -> Result<ExitCode, Failure> {
    let error = without_source_place(&error.to_string());
    // `--` keeps a scene whose name begins with a dash a scene.
    let words = ["iorect", "compare", "-o", FALLBACK_PICTURE, "--"].map(OsStr::new);
    let words = words.into_iter().chain([scene.as_os_str()]);
    let mut arguments = match Arguments::try_parse_from(words).map(|arguments| arguments.command) {
        Ok(Some(Command::Compare(arguments))) => arguments,
        other => return Err(Failure::Failed(anyhow::anyhow!("the comparison could not be started: {other:?}"))),
    };
    let image = &mut arguments.image;
    (image.spp, image.time, image.tells_progress) = (Some(DEFAULT_SPP), Some(FALLBACK_SECS), true);
    tell(&format!(
        "{error}\nInstead, {} are compared in {FALLBACK_PICTURE}: {DEFAULT_SPP} samples per pixel, or as many as {FALLBACK_SECS} s allow.\n",
        arguments.modes.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
    ));
    let code = compare::run(&arguments)?;
    let finer = finer_command(&scene.to_string_lossy());
    tell(&format!("A finer picture: {finer}\n`iorect --help` lists what else needs no display.\n"));
    Ok(code)
}

/// What to type for a picture with less noise.
fn finer_command(scene: &str) -> String {
    // A file whose name begins with a dash is a file still.
    let scene = if scene.starts_with('-') { format!("./{scene}") } else { scene.to_owned() };
    format!("iorect compare {} --spp {} -o {FALLBACK_PICTURE}", shell_word(&scene), 16 * DEFAULT_SPP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_finer_command_can_be_typed() {
        assert_eq!(finer_command("iced-water"), "iorect compare iced-water --spp 1024 -o iorect-comparison.png");
        assert!(finer_command("my scene's.toml").starts_with("iorect compare 'my scene'\\''s.toml' --spp"));
        assert!(finer_command("-x.toml").starts_with("iorect compare ./-x.toml --spp"));
    }

    #[test]
    fn reasons_lose_the_place_in_somebody_elses_source() {
        let long = "no window can be opened: EventLoopError: os error at a/b/mod.rs:765: DISPLAY is not set";
        assert_eq!(without_source_place(long), "no window can be opened: DISPLAY is not set");
        assert_eq!(without_source_place("no window can be opened: no GPU"), "no window can be opened: no GPU");
        assert_eq!(without_source_place(""), "");
    }
}
