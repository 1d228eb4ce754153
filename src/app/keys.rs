//! Keyboard shortcuts: what keys are called, and what they do now.

mod list;

use egui::{Key, KeyboardShortcut, Modifiers};

pub use self::list::*;
use super::command::Command;
use super::settings::MAX_PANES;
use super::state::{State, Windows};

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;

/// Keys as people name them: "Ctrl+Shift+S", "Esc", "?".
pub fn text(keys: &KeyboardShortcut, is_mac: bool) -> String {
    let modifiers = keys.modifiers;
    let command = if is_mac { "Cmd" } else { "Ctrl" };
    let names = [
        (modifiers.ctrl && !modifiers.command, "Ctrl"),
        (modifiers.command, command),
        (modifiers.alt, "Alt"),
        (modifiers.shift, "Shift"),
    ];
    let names = names.into_iter().filter(|(is_held, _)| *is_held).map(|(_, name)| name);
    names.chain([key_name(keys.logical_key)]).collect::<Vec<_>>().join("+")
}

fn key_name(key: Key) -> &'static str {
    match key {
        Key::Escape => "Esc",
        Key::Plus => "plus",
        Key::Minus => "minus",
        Key::ArrowUp | Key::ArrowDown | Key::ArrowLeft | Key::ArrowRight => key.name(),
        other => other.symbol_or_name(),
    }
}

/// Home and End belong to a control while it has the focus.
pub fn keep_home_and_end(ctx: &egui::Context, control: egui::Id) {
    ctx.data_mut(|data| data.insert_temp(keeper(), control));
}

/// Where the control that keeps Home and End is noted.
fn keeper() -> egui::Id {
    egui::Id::unique("keeps Home and End")
}

/// What stands over the panes and wants keys for itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Above {
    /// A question is open.
    pub has_dialog: bool,
    /// The control that had the focus at the end of the last frame.
    pub focused: Option<egui::Id>,
}

/// The commands of the keys that were just pressed. Keys without modifiers are left to text fields that have the focus, and under a window
/// that wants an answer only those keys work that concern it.
pub fn pressed(ctx: &egui::Context, state: &State, above: Above) -> Vec<Command> {
    let is_typing = ctx.egui_wants_keyboard_input() && ctx.text_edit_focused();
    let focused = ctx.memory(egui::Memory::focused);
    // A control that was reached with the keyboard is pressed with the space bar; a picture is not.
    let has_focus = focused.is_some_and(|id| !is_pane(id));
    let is_covered = above.has_dialog || state.windows != Windows::default();
    let has_popup = egui::Popup::is_any_open(ctx);
    // The focus itself is what Escape puts away where nothing lies over the panes.
    let has_lost_focus = above.focused.is_some() && focused.is_none();
    let is_escape_taken = has_popup || (has_lost_focus && !is_covered && !state.document.has_gesture());
    let keeper: Option<egui::Id> = ctx.data(|data| data.get_temp(keeper()));
    let keeps_home = keeper.is_some() && focused == keeper;
    let mut commands = Vec::new();
    // What is selected on a label is copied as text, by the label.
    let has_text = ctx.plugin::<egui::text_selection::LabelSelectionState>().lock().has_selection();
    ctx.input_mut(|input| {
        // Systems with a clipboard turn Ctrl+C into an event of its own.
        let has_copied = input.events.iter().any(|event| matches!(event, egui::Event::Copy));
        if has_copied && !is_typing && !has_text && !is_covered {
            commands.push(Command::CopyPane);
        }
        for shortcut in GROUPS.iter().flat_map(|group| group.shortcuts) {
            let is_plain = matches!(shortcut.keys.modifiers, NONE | SHIFT);
            let key = shortcut.keys.logical_key;
            if key == Key::Escape {
                if is_escape_taken {
                    continue;
                }
            } else if (keeps_home && matches!(key, Key::Home | Key::End))
                || (is_covered && !WHILE_COVERED.contains(&shortcut.keys))
                || (above.has_dialog && shortcut.keys != QUIT)
                || (is_plain && (is_typing || (has_focus && key == Key::Space)))
            {
                continue;
            }
            if is_typing && shortcut.keys == COPY_PANE {
                continue;
            }
            // Keyboards differ in whether a question mark needs Shift; all other plain keys are plain.
            let is_pressed = if key == Key::Questionmark {
                input.consume_key(Modifiers::SHIFT, Key::Questionmark) || input.consume_key(NONE, Key::Questionmark)
            } else {
                input.consume_shortcut(&shortcut.keys)
            };
            if is_pressed {
                commands.push((shortcut.command)(state));
            }
        }
    });
    commands
}

/// What works while a window lies over the panes.
const WHILE_COVERED: [KeyboardShortcut; 5] = [GALLERY, SHORTCUTS, QUIT, LARGER, SMALLER];

/// The identity of a pane's picture, which can have the focus.
pub fn pane_id(index: usize) -> egui::Id {
    egui::Id::unique(("picture of pane", index))
}

pub fn is_pane(id: egui::Id) -> bool {
    (0..MAX_PANES).any(|index| pane_id(index) == id)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::settings::Settings;

    fn all() -> impl Iterator<Item = &'static Shortcut> {
        GROUPS.iter().flat_map(|group| group.shortcuts)
    }

    #[test]
    fn no_key_is_given_twice() {
        let all: Vec<KeyboardShortcut> = all().map(|shortcut| shortcut.keys).collect();
        for (index, keys) in all.iter().enumerate() {
            assert!(!all[index + 1..].contains(keys), "{keys:?} is given twice");
        }
    }

    #[test]
    fn keys_have_the_names_that_people_know() {
        let texts =
            [SAVE_AS, SHORTCUTS, WIPE, key(NONE, Key::Escape), key(NONE, Key::Num4), LARGER].map(|k| text(&k, false));
        assert_eq!(texts, ["Ctrl+Shift+S", "?", "W", "Esc", "4", "Ctrl+plus"]);
        assert_eq!(text(&OPEN, true), "Cmd+O");
        for shortcut in all() {
            let text = text(&shortcut.keys, false);
            let is_known = |part: &str| {
                part.chars().count() == 1
                    || ["Ctrl", "Shift", "Alt", "Esc", "Home", "Space", "Backspace", "Delete", "plus", "minus"]
                        .contains(&part)
                    || part.strip_prefix('F').is_some_and(|number| number.parse::<u8>().is_ok())
            };
            assert!(text.split('+').all(is_known), "{text}");
        }
    }

    /// The commands of one press of `keys`.
    fn press(keys: KeyboardShortcut, state: &State, above: Above) -> Vec<Command> {
        let ctx = egui::Context::default();
        let event = egui::Event::Key {
            key: keys.logical_key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: keys.modifiers,
        };
        let input = egui::RawInput { events: vec![event], ..Default::default() };
        let mut commands = Vec::new();
        let mut output = ctx.run_ui(input, |ui| commands = pressed(ui.ctx(), state, above));
        output.textures_delta.clear();
        commands
    }

    fn state() -> State {
        let scene = crate::formats::open(crate::formats::builtin::DEFAULT).expect("a built-in scene");
        State::new(Arc::new(scene), Settings::default())
    }

    #[test]
    fn every_listed_key_gives_its_own_command_and_no_other() {
        let state = state();
        for shortcut in all() {
            let given = press(shortcut.keys, &state, Above::default());
            assert_eq!(given, [(shortcut.command)(&state)], "{}", text(&shortcut.keys, false));
        }
    }

    #[test]
    fn nothing_reaches_the_panes_under_a_window_or_a_question() {
        let mut covered = state();
        covered.windows.about = true;
        for shortcut in all() {
            let is_escape = shortcut.keys.logical_key == Key::Escape;
            let is_given = |above| !press(shortcut.keys, &covered, above).is_empty();
            let name = text(&shortcut.keys, false);
            assert_eq!(is_given(Above::default()), is_escape || WHILE_COVERED.contains(&shortcut.keys), "{name}");
            let under_question = Above { has_dialog: true, focused: None };
            assert_eq!(is_given(under_question), is_escape || shortcut.keys == QUIT, "{name}");
        }
    }
}
