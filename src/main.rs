//! The `iorect` binary: everything is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    iorect::cli::main()
}
