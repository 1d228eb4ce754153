//! Keyboard shortcuts: one table for the keys themselves, for the menus and for the list in the help.

use egui::{Key, KeyboardShortcut, Modifiers};

use super::command::{Command, ExportKind};
use super::objects::Manipulation;
use super::settings::{Arrangement, Tab};
use super::state::State;

/// A key and what it does.
pub struct Shortcut {
    pub keys: KeyboardShortcut,
    /// For the list; empty for a second key that does the same.
    pub what: &'static str,
    /// The command, given what is shown now.
    pub command: fn(&State) -> Command,
}

/// A titled part of the list.
pub struct Group {
    pub title: &'static str,
    pub shortcuts: &'static [Shortcut],
}

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

const fn key(modifiers: Modifiers, key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(modifiers, key)
}

pub const OPEN: KeyboardShortcut = key(CTRL, Key::O);
pub const GALLERY: KeyboardShortcut = key(CTRL, Key::B);
pub const SAVE: KeyboardShortcut = key(CTRL, Key::S);
pub const SAVE_AS: KeyboardShortcut = key(CTRL_SHIFT, Key::S);
pub const EXPORT_PANE: KeyboardShortcut = key(CTRL, Key::E);
pub const EXPORT_ALL: KeyboardShortcut = key(CTRL_SHIFT, Key::E);
pub const QUIT: KeyboardShortcut = key(CTRL, Key::Q);
pub const UNDO: KeyboardShortcut = key(CTRL, Key::Z);
pub const REDO: KeyboardShortcut = key(CTRL_SHIFT, Key::Z);
pub const MOVE: KeyboardShortcut = key(NONE, Key::G);
pub const ROTATE: KeyboardShortcut = key(NONE, Key::T);
pub const SCALE: KeyboardShortcut = key(NONE, Key::S);
pub const HIDE: KeyboardShortcut = key(NONE, Key::V);
pub const FRAME: KeyboardShortcut = key(NONE, Key::F);
pub const EARLIER_VIEW: KeyboardShortcut = key(NONE, Key::Backspace);
pub const VALUES: KeyboardShortcut = key(NONE, Key::P);
pub const MEASURE: KeyboardShortcut = key(NONE, Key::M);
pub const WIPE: KeyboardShortcut = key(NONE, Key::W);
pub const RESET_CAMERA: KeyboardShortcut = key(NONE, Key::Home);
pub const RESET_ZOOM: KeyboardShortcut = key(NONE, Key::Z);
pub const SCENE_PANEL: KeyboardShortcut = key(NONE, Key::F1);
pub const RENDER_PANEL: KeyboardShortcut = key(NONE, Key::F2);
pub const BOTH_PANELS: KeyboardShortcut = key(NONE, Key::H);
pub const PAUSE: KeyboardShortcut = key(NONE, Key::Space);
pub const RESTART: KeyboardShortcut = key(NONE, Key::R);
pub const SHORTCUTS: KeyboardShortcut = key(NONE, Key::Questionmark);
pub const LARGER: KeyboardShortcut = key(CTRL, Key::Plus);
pub const SMALLER: KeyboardShortcut = key(CTRL, Key::Minus);

/// Every shortcut. Those with more modifiers come before those with fewer, or they would never be reached.
pub const GROUPS: &[Group] = &[
    Group {
        title: "Files",
        shortcuts: &[
            Shortcut { keys: OPEN, what: "Open a scene", command: |_| Command::AskOpen },
            Shortcut { keys: GALLERY, what: "Built-in scenes", command: |s| Command::ShowGallery(!s.windows.gallery) },
            Shortcut { keys: SAVE_AS, what: "Save as…", command: |_| Command::AskSaveAs },
            Shortcut { keys: SAVE, what: "Save", command: |_| Command::Save },
            Shortcut {
                keys: EXPORT_ALL,
                what: "Export all panes as PNG",
                command: |_| Command::AskExport(ExportKind::AllPanesPng),
            },
            Shortcut {
                keys: EXPORT_PANE,
                what: "Export the active pane as PNG",
                command: |_| Command::AskExport(ExportKind::PanePng),
            },
            Shortcut { keys: QUIT, what: "Quit", command: |_| Command::Quit },
        ],
    },
    Group {
        title: "Edit",
        shortcuts: &[
            Shortcut { keys: REDO, what: "Redo", command: |_| Command::Redo },
            Shortcut { keys: UNDO, what: "Undo", command: |_| Command::Undo },
            Shortcut { keys: key(CTRL, Key::Y), what: "", command: |_| Command::Redo },
            Shortcut { keys: MOVE, what: "Move the selected object", command: |s| handles(s, Manipulation::Move) },
            Shortcut { keys: ROTATE, what: "Rotate it", command: |s| handles(s, Manipulation::Rotate) },
            Shortcut { keys: SCALE, what: "Scale it", command: |s| handles(s, Manipulation::Scale) },
            Shortcut { keys: HIDE, what: "Hide or show it", command: hide },
        ],
    },
    Group {
        title: "Panes",
        shortcuts: &[
            Shortcut { keys: key(NONE, Key::Num1), what: "One pane", command: |_| Command::SetPaneCount(1) },
            Shortcut { keys: key(NONE, Key::Num2), what: "Two panes", command: |_| Command::SetPaneCount(2) },
            Shortcut { keys: key(NONE, Key::Num4), what: "Four panes", command: |_| Command::SetPaneCount(4) },
            Shortcut {
                keys: WIPE,
                what: "Wipe or side by side",
                command: |s| {
                    Command::SetArrangement(match s.settings.arrangement {
                        Arrangement::Tiles => Arrangement::Wipe,
                        Arrangement::Wipe => Arrangement::Tiles,
                    })
                },
            },
            Shortcut {
                keys: key(NONE, Key::N),
                what: "Next pane",
                command: |s| Command::SetActivePane((s.view.active_pane + 1) % s.settings.pane_count),
            },
        ],
    },
    Group {
        title: "View",
        shortcuts: &[
            Shortcut { keys: RESET_CAMERA, what: "Camera as in the scene", command: |_| Command::ResetCamera },
            Shortcut { keys: FRAME, what: "Camera to the selected object", command: frame },
            Shortcut { keys: EARLIER_VIEW, what: "Earlier view", command: |_| Command::EarlierView },
            Shortcut { keys: RESET_ZOOM, what: "Whole picture", command: |_| Command::SetZoom(1.0, [0.5; 2]) },
            Shortcut { keys: BOTH_PANELS, what: "Hide or show both panels", command: |_| Command::ToggleBothPanels },
            Shortcut { keys: SCENE_PANEL, what: "Scene panel", command: |_| Command::ToggleScenePanel },
            Shortcut { keys: RENDER_PANEL, what: "Render panel", command: |_| Command::ToggleRenderPanel },
            Shortcut { keys: key(NONE, Key::I), what: "Inspector", command: |_| Command::ShowTab(Tab::Inspector) },
            Shortcut { keys: MEASURE, what: "Error against time", command: |_| Command::ShowTab(Tab::Measure) },
            Shortcut { keys: VALUES, what: "Values under the pointer", command: |_| Command::ToggleValues },
            Shortcut { keys: LARGER, what: "Larger interface", command: |_| Command::StepInterfaceScale(1) },
            Shortcut { keys: key(CTRL, Key::Equals), what: "", command: |_| Command::StepInterfaceScale(1) },
            Shortcut { keys: SMALLER, what: "Smaller interface", command: |_| Command::StepInterfaceScale(-1) },
        ],
    },
    Group {
        title: "Render",
        shortcuts: &[
            Shortcut { keys: PAUSE, what: "Pause or go on", command: |_| Command::TogglePause },
            Shortcut { keys: RESTART, what: "Start the images anew", command: |_| Command::Restart },
            Shortcut {
                keys: key(NONE, Key::CloseBracket),
                what: "Brighter by ¼ stop",
                command: |s| Command::SetExposure(s.settings.display.exposure + 0.25),
            },
            Shortcut {
                keys: key(NONE, Key::OpenBracket),
                what: "Darker by ¼ stop",
                command: |s| Command::SetExposure(s.settings.display.exposure - 0.25),
            },
            Shortcut { keys: key(NONE, Key::Num0), what: "Exposure 0", command: |_| Command::SetExposure(0.0) },
        ],
    },
    Group {
        title: "Help",
        shortcuts: &[
            Shortcut { keys: SHORTCUTS, what: "This list", command: |s| Command::ShowShortcuts(!s.windows.shortcuts) },
            Shortcut { keys: key(NONE, Key::Escape), what: "Close what is on top", command: |_| Command::Escape },
        ],
    },
];

/// The handles for `manipulation`, or none if those are there already.
fn handles(state: &State, manipulation: Manipulation) -> Command {
    Command::SetHandles(Some(manipulation).filter(|_| state.settings.handles != Some(manipulation)))
}

fn hide(state: &State) -> Command {
    match state.selected_object() {
        Some((name, object)) => Command::SetVisible(name.to_owned(), !object.visible),
        None => Command::Nothing,
    }
}

fn frame(state: &State) -> Command {
    state.selected_object().map_or(Command::Nothing, |(name, _)| Command::FrameObject(name.to_owned()))
}

/// What the pointer does, for the list.
pub const POINTER: &[(&str, &str)] = &[
    ("drag", "orbit"),
    ("right or middle drag", "pan"),
    ("wheel", "dolly"),
    ("Ctrl + wheel", "zoom into pixels"),
    ("Ctrl + drag", "move the zoomed picture"),
    ("click", "inspect a pixel"),
    ("Ctrl + click", "select the object; again: the one behind"),
    ("drag a handle", "move, rotate or scale what is selected"),
    ("Ctrl while dragging it", "in steps; Esc gives the drag up"),
    ("double click", "look at it: orbit around the point"),
];

/// The commands of the keys that were just pressed. Keys without modifiers are left to text fields that have the focus.
pub fn pressed(ctx: &egui::Context, state: &State) -> Vec<Command> {
    let is_typing = ctx.egui_wants_keyboard_input() && ctx.text_edit_focused();
    // A control that was reached with the keyboard is pressed with the space bar.
    let has_focus = ctx.memory(|memory| memory.focused().is_some());
    let mut commands = Vec::new();
    ctx.input_mut(|input| {
        for shortcut in GROUPS.iter().flat_map(|group| group.shortcuts) {
            let is_plain = shortcut.keys.modifiers.is_none();
            if is_plain && (is_typing || (has_focus && shortcut.keys.logical_key == Key::Space)) {
                continue;
            }
            // Keyboards differ in whether a question mark needs Shift; all other plain keys are plain.
            let is_pressed = if shortcut.keys.logical_key == Key::Questionmark {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_is_given_twice() {
        let all: Vec<KeyboardShortcut> = GROUPS.iter().flat_map(|g| g.shortcuts).map(|s| s.keys).collect();
        for (index, keys) in all.iter().enumerate() {
            assert!(!all[index + 1..].contains(keys), "{keys:?} is given twice");
        }
    }
}
