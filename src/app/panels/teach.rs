//! What is said of each picture: whether it is right, and if not, why and where that shows.

use crate::app::command::Command;
use crate::app::state::State;

/// Shows the first place where a picture is wrong; nothing where none is.
pub fn show_first_wrong(_state: &State) -> Vec<Command> {
    Vec::new()
}
