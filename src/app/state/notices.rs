//! What the window tells the user in passing.

use super::{Notice, State};
use crate::app::quotes::quoted;

/// Messages that can be read again.
const MAX_MESSAGES: usize = 200;

impl State {
    pub fn notify(&mut self, text: impl Into<String>) {
        self.push_notice(false, &text.into());
    }

    pub fn notify_error(&mut self, text: impl Into<String>) {
        self.push_notice(true, &text.into());
    }

    fn push_notice(&mut self, is_error: bool, text: &str) {
        // The same message twice is one message.
        let notice = Notice { id: self.next_notice, is_error, text: quoted(text) };
        for list in [&mut self.notices, &mut self.messages] {
            list.retain(|known| known.text != notice.text);
            list.push(notice.clone());
        }
        if self.messages.len() > MAX_MESSAGES {
            self.messages.remove(0);
        }
        self.next_notice += 1;
    }
}
