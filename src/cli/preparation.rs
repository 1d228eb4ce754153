//! Preparing a scene, with a line on the terminal while that takes long. Nothing is half-written meanwhile, so Ctrl-C may end it at once.

use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use indicatif::ProgressBar;

use super::progress;
use crate::rectify::Progress;
use crate::scene::{Description, SceneError};
use crate::tracking::{PrepareError, Prepared, prepare, prepare_watched};

/// Preparations that are done sooner show nothing.
const PATIENCE: Duration = Duration::from_millis(500);
/// Time between two looks at the progress.
const INTERVAL: Duration = Duration::from_millis(100);

/// Compiles and rectifies `description`, and shows on standard error, if that is a terminal, how far this has come.
pub fn prepare_shown(description: Arc<Description>) -> Result<Prepared, SceneError> {
    if !io::stderr().is_terminal() {
        return prepare(description, None);
    }
    let progress = &Progress::new();
    let (finished, is_finished) = channel::<()>();
    let outcome = std::thread::scope(|scope| {
        scope.spawn(move || {
            let mut wait = PATIENCE;
            let mut bar: Option<ProgressBar> = None;
            // The sender is dropped when the work is over, however it ends.
            while is_finished.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                wait = INTERVAL;
                let (stage, share) = progress.state();
                let bar = bar.get_or_insert_with(line);
                bar.set_message(stage.name());
                bar.set_position((share * 100.0) as u64);
            }
            if let Some(bar) = bar {
                bar.finish_and_clear();
            }
        });
        let outcome = prepare_watched(description, None, progress);
        drop(finished);
        outcome
    });
    outcome.map_err(|error| match error {
        PrepareError::Scene(error) => error,
        PrepareError::Cancelled(cancelled) => SceneError::new(cancelled.to_string()),
    })
}

fn line() -> ProgressBar {
    progress::bar(100, "preparing: {msg} {bar:30.cyan/dim} {percent:>3} % · {elapsed}")
}
