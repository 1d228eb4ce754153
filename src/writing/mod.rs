//! Files that are either whole or not there, whatever happens while they are written.
//!
//! A file is written beside its target under a temporary name, flushed to the disk and renamed into place; then its folder is flushed
//! too. What stood at the target stays until that moment. What becomes of each kind of target:
//!
//! | target | |
//! |---|---|
//! | nothing yet | made, as readable as the umask says |
//! | a file | replaced; permissions stay, and so do owner and group where the system allows. Access lists and extended attributes do not |
//! | a file with several hard links | replaced under this name; the other names keep the old contents |
//! | a read-only file, or one that may not be written to | refused |
//! | a symbolic link | the file that it points to is replaced, or made where it points nowhere; the link stays |
//! | a FIFO or a character device | written in sequence; opening a FIFO waits for its reader |
//! | a folder, a socket, a disk | refused |
//!
//! Temporary files are called `.iorect-….tmp`. They go when writing fails, and when the program is interrupted
//! ([`clean_up_when_interrupted`]). Those of a program that was killed are removed when something is next written into their folder.

mod atomic;
mod error;
mod interrupt;
mod stale;
mod target;
mod temporary;

pub use atomic::{require_writable, write_atomically};
pub use error::WriteError;
pub use interrupt::clean_up_when_interrupted;
