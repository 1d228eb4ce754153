//! What is known of the graphics processor.

use std::sync::Arc;

use super::State;
use crate::session::GraphicsStatus;

impl State {
    /// Takes in what is known now, and tells when it has failed.
    pub fn set_graphics(&mut self, graphics: Option<Arc<GraphicsStatus>>) {
        let fault_of = |status: &Option<Arc<GraphicsStatus>>| status.as_ref().and_then(|status| status.fault.clone());
        let before = fault_of(&self.graphics);
        if let Some(fault) = fault_of(&graphics).filter(|fault| before.as_ref() != Some(fault)) {
            self.notify_error(format!("{} The CPU goes on with the pictures; nothing is lost.", sentence(&fault)));
        }
        self.graphics = graphics;
    }
}

/// A message as a sentence.
pub fn sentence(text: &str) -> String {
    format!("{}.", capitalized(text))
}

pub fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::Settings;
    use crate::render::choice::KnownAdapter;

    #[test]
    fn a_fault_is_told_once() {
        let mut state = State::new(Arc::new(crate::formats::open("plain-glass").unwrap()), Settings::default());
        let adapter = Ok(KnownAdapter { label: "Card (Vulkan)".into(), is_software: false });
        let status = |fault: Option<&str>| {
            let fault = fault.map(str::to_owned);
            Some(Arc::new(GraphicsStatus { adapter: adapter.clone(), is_used: true, reason: None, fault }))
        };
        state.set_graphics(status(None));
        assert!(state.notices.is_empty());
        state.set_graphics(status(Some("the card was lost")));
        assert!(state.notices[0].text.starts_with("The card was lost. The CPU goes on"));
        state.notices.clear();
        state.set_graphics(status(Some("the card was lost")));
        assert!(state.notices.is_empty());
        // Found again, and lost again.
        state.set_graphics(status(None));
        state.set_graphics(status(Some("the card was lost")));
        assert_eq!(state.notices.len(), 1);
    }
}
