//! The command line, thin over the library.
//!
//! Results go to standard output, everything else to standard error. Exit codes: 0 fine, 1 the work failed, 2 the command or the scene
//! was wrong.

mod arguments;
mod check;
mod compare;
mod convert;
mod export;
mod image;
mod merge;
mod preparation;
mod progress;
mod rectify;
mod render;
mod report;
mod scenes;
mod table;
mod trace;
mod window;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::Parser;

use self::arguments::{Arguments, Command};
use crate::export::ExportError;
use crate::export::escape::{elided, escaped_json, escaped_lines};
use crate::render::Estimator;
use crate::scene::SceneError;
use crate::writing::clean_up_when_interrupted;

pub use arguments::WindowArguments;
pub use window::WindowError;

/// Characters of an error that are shown at the most: names and lists of them can be long.
const MOST_OF_ERROR: usize = 4000;

/// Why a command did not do what it was asked for.
#[derive(Debug)]
enum Failure {
    /// The command or the scene was wrong: exit code 2.
    Wrong(anyhow::Error),
    /// The work failed: exit code 1.
    Failed(anyhow::Error),
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Wrong(error.into())
    }
}

impl Failure {
    fn wrong(message: impl Into<String>) -> Self {
        Self::Wrong(anyhow::Error::msg(message.into()))
    }

    /// An output that can be known to be impossible before any work is done.
    fn bad_output(error: impl Into<ExportError>) -> Self {
        Self::Wrong(error.into().into())
    }

    /// An output that turned out to be impossible.
    fn output(error: ExportError) -> Self {
        Self::Failed(error.into())
    }
}

/// Runs the program. `open_window` shows the window and returns when it is closed: it is handed in by the binary, so that command line
/// and window need not know each other.
pub fn main(open_window: impl FnOnce(&WindowArguments) -> Result<(), WindowError>) -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            if error.use_stderr() {
                tell(&error.render().to_string());
            } else {
                // Help and version are no errors; neither is a reader of them that has gone.
                let _ = error.print();
            }
            return ExitCode::from(error.exit_code() as u8);
        }
    };
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("error")).init();
    if let Err(error) = clean_up_when_interrupted() {
        log::warn!("temporary files may be left behind by an interruption: {error}");
    }
    let result = match &arguments.command {
        None => window::run(&arguments.window, open_window),
        Some(Command::Render(arguments)) => render::run(arguments),
        Some(Command::Merge(arguments)) => merge::run(arguments),
        Some(Command::Compare(arguments)) => compare::run(arguments),
        Some(Command::Rectify(arguments)) => rectify::run(arguments),
        Some(Command::Trace(arguments)) => trace::run(arguments),
        Some(Command::Check(arguments)) => check::run(arguments),
        Some(Command::Convert(arguments)) => convert::run(arguments),
        Some(Command::Scenes(arguments)) => scenes::run(arguments),
        Some(Command::Report(arguments)) => report::run(arguments),
        Some(Command::Export(arguments)) => export::run(arguments),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            let (code, error) = match failure {
                Failure::Wrong(error) => (2, error),
                Failure::Failed(error) => (1, error),
            };
            // The alternate form gives the whole chain of causes in one line.
            tell(&format!("error: {}\n", elided(&format!("{error:#}"), MOST_OF_ERROR)));
            ExitCode::from(code)
        }
    }
}

/// A pool of that many threads; by default one per core.
fn pool(threads: Option<u32>) -> Result<rayon::ThreadPool, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0) as usize).build();
    pool.map_err(|error| Failure::Failed(anyhow::Error::new(error).context("the threads cannot be started")))
}

/// A word with quotation marks where a shell needs them.
fn shell_word(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// The estimator in a heading, where it is another than paths from the camera.
fn by_estimator(estimator: Estimator) -> String {
    if estimator == Estimator::Path { String::new() } else { format!(" · {}", estimator.name()) }
}

/// The ending of a noun that is counted.
fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// Writes to standard error. Nobody is left to tell if this cannot be done.
fn tell(text: &str) {
    let _ = io::stderr().write_all(escaped_lines(text).as_bytes());
}

/// Writes a result to standard output. A reader that has gone, such as `head`, is no error.
fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(escaped_lines(text).as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Failed(anyhow::Error::new(error).context("standard output cannot be written")))
        }
        _ => Ok(()),
    }
}

/// Writes a result to standard output as JSON, indented.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value).map_err(|error| Failure::Failed(error.into()))?;
    text.push('\n');
    print(&escaped_json(&text))
}
