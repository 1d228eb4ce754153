//! The `iorect` binary: hands the window to the command line, and nothing else. Only here do the two meet.

use std::process::ExitCode;

use iorect::cli::{self, WindowError, WindowRequest};

fn main() -> ExitCode {
    cli::main(open_window)
}

fn open_window(_request: WindowRequest) -> Result<(), WindowError> {
    Err(WindowError::NoWindow("the window is not part of this build".into()))
}
