//! How far a render is: a bar on a terminal; elsewhere, where it is wanted, a line now and then.

use std::cell::Cell;
use std::io::{self, IsTerminal};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::tell;
use crate::export::words::duration;

/// Steps of the bar.
const STEPS: u64 = 10_000;
/// Time between two lines.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// Draws on standard error, and only if that is a terminal.
pub fn bar(steps: u64, template: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(steps).with_style(style.progress_chars("━━─"))
}

/// Gone from the terminal when dropped.
pub struct Progress {
    bar: ProgressBar,
    /// When the next line is due; `None` where none is told.
    next_line: Cell<Option<Duration>>,
}

impl Progress {
    /// With `tells_lines`, a standard error that is no terminal gets lines.
    pub fn new(tells_lines: bool) -> Self {
        let bar = bar(STEPS, "{bar:40.cyan/dim} {percent:>3} % · {elapsed}, {eta} left");
        let is_told = tells_lines && !io::stderr().is_terminal();
        Self { bar, next_line: Cell::new(is_told.then_some(BETWEEN_LINES)) }
    }

    /// `part` of the work is done, from 0 to 1.
    pub fn tell(&self, part: f64, elapsed: Duration) {
        self.bar.set_position((part * STEPS as f64) as u64);
        if self.next_line.get().is_some_and(|due| elapsed >= due) && part > 0.0 {
            self.next_line.set(Some(elapsed + BETWEEN_LINES));
            let secs = elapsed.as_secs_f64();
            let left = secs * (1.0 - part) / part;
            tell(&format!("{:.0} % in {}, about {} left\n", 100.0 * part, duration(secs), duration(left)));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
