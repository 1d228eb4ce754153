//! All shortcuts: one table for the keys themselves, for the menus and for the list in the help.

use egui::{Key, KeyboardShortcut, Modifiers};

use crate::app::build;
use crate::app::command::{Command, ExportKind};
use crate::app::edit::{Edit, ObjectEdit};
use crate::app::objects::Manipulation;
use crate::app::settings::{Arrangement, Tab};
use crate::app::snapshots::SnapshotId;
use crate::app::state::State;

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
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

pub const fn key(modifiers: Modifiers, key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(modifiers, key)
}

const fn on(keys: KeyboardShortcut, what: &'static str, command: fn(&State) -> Command) -> Shortcut {
    Shortcut { keys, what, command }
}

pub const NEW: KeyboardShortcut = key(CTRL, Key::N);
pub const OPEN: KeyboardShortcut = key(CTRL, Key::O);
pub const GALLERY: KeyboardShortcut = key(CTRL, Key::B);
pub const SAVE: KeyboardShortcut = key(CTRL, Key::S);
pub const SAVE_AS: KeyboardShortcut = key(CTRL_SHIFT, Key::S);
pub const EXPORT_PANE: KeyboardShortcut = key(CTRL, Key::E);
pub const EXPORT_ALL: KeyboardShortcut = key(CTRL_SHIFT, Key::E);
pub const COPY_PANE: KeyboardShortcut = key(CTRL, Key::C);
pub const COPY_PANES: KeyboardShortcut = key(CTRL_SHIFT, Key::C);
pub const COPY_VALUES: KeyboardShortcut = key(SHIFT, Key::C);
pub const KEEP_A: KeyboardShortcut = key(NONE, Key::K);
pub const KEEP_B: KeyboardShortcut = key(SHIFT, Key::K);
pub const QUIT: KeyboardShortcut = key(CTRL, Key::Q);
pub const UNDO: KeyboardShortcut = key(CTRL, Key::Z);
pub const REDO: KeyboardShortcut = key(CTRL_SHIFT, Key::Z);
pub const ADD: KeyboardShortcut = key(Modifiers::SHIFT, Key::A);
pub const DUPLICATE: KeyboardShortcut = key(CTRL, Key::D);
pub const DELETE: KeyboardShortcut = key(NONE, Key::Delete);
pub const RENAME: KeyboardShortcut = key(NONE, Key::F2);
const MOVE: KeyboardShortcut = key(NONE, Key::G);
const ROTATE: KeyboardShortcut = key(NONE, Key::T);
const SCALE: KeyboardShortcut = key(NONE, Key::S);
pub const HIDE: KeyboardShortcut = key(NONE, Key::V);
pub const FRAME: KeyboardShortcut = key(NONE, Key::F);
pub const EARLIER_VIEW: KeyboardShortcut = key(NONE, Key::Backspace);
pub const VALUES: KeyboardShortcut = key(NONE, Key::P);
pub const HISTOGRAM: KeyboardShortcut = key(SHIFT, Key::H);
pub const MEASURE: KeyboardShortcut = key(NONE, Key::M);
pub const INSPECTOR: KeyboardShortcut = key(NONE, Key::I);
pub const WIPE: KeyboardShortcut = key(NONE, Key::W);
pub const RESET_CAMERA: KeyboardShortcut = key(NONE, Key::Home);
pub const RESET_ZOOM: KeyboardShortcut = key(NONE, Key::Z);
pub const SCENE_PANEL: KeyboardShortcut = key(NONE, Key::F1);
pub const RENDER_PANEL: KeyboardShortcut = key(NONE, Key::F3);
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
            on(NEW, "New scene", |_| Command::New),
            on(OPEN, "Open a scene", |_| Command::AskOpen),
            on(GALLERY, "Built-in scenes", |s| Command::ShowGallery(!s.windows.gallery)),
            on(SAVE_AS, "Save as…", |_| Command::AskSaveAs),
            on(SAVE, "Save", |_| Command::Save),
            on(EXPORT_ALL, "Export all panes as shown", |_| Command::AskExport(ExportKind::ShownPanes)),
            on(EXPORT_PANE, "Export the active pane as shown", |_| Command::AskExport(ExportKind::ShownPane)),
            on(QUIT, "Quit", |_| Command::Quit),
        ],
    },
    Group {
        title: "Edit",
        shortcuts: &[
            on(REDO, "Redo", |_| Command::Redo),
            on(UNDO, "Undo", |_| Command::Undo),
            on(key(CTRL, Key::Y), "", |_| Command::Redo),
            on(ADD, "Add an object", |s| Command::ShowAdd(!s.windows.add)),
            on(DUPLICATE, "Duplicate the selected object", duplicate),
            on(DELETE, "Delete it", delete),
            on(RENAME, "Rename it", rename),
            on(COPY_PANES, "Copy all panes as pictures", |_| Command::CopyPanes),
            on(COPY_PANE, "Copy the active pane as a picture", |_| Command::CopyPane),
            on(COPY_VALUES, "Copy the values of the pixel", |_| Command::CopyValues),
            on(MOVE, "Move the selected object", |s| handles(s, Manipulation::Move)),
            on(ROTATE, "Rotate it", |s| handles(s, Manipulation::Rotate)),
            on(SCALE, "Scale it", |s| handles(s, Manipulation::Scale)),
            on(HIDE, "Hide or show it", hide),
        ],
    },
    Group {
        title: "Panes",
        shortcuts: &[
            on(key(NONE, Key::Num1), "One pane", |_| Command::SetPaneCount(1)),
            on(key(NONE, Key::Num2), "Two panes", |_| Command::SetPaneCount(2)),
            on(key(NONE, Key::Num4), "Four panes", |_| Command::SetPaneCount(4)),
            on(WIPE, "Wipe or side by side", |s| {
                let is_wipe = s.settings.arrangement == Arrangement::Wipe;
                Command::SetArrangement(if is_wipe { Arrangement::Tiles } else { Arrangement::Wipe })
            }),
            on(KEEP_B, "Keep its picture as snapshot B", |_| Command::KeepSnapshot(SnapshotId::B)),
            on(KEEP_A, "Keep the active pane's picture as snapshot A", |_| Command::KeepSnapshot(SnapshotId::A)),
            on(key(NONE, Key::N), "Next pane", |s| {
                Command::SetActivePane((s.view.active_pane + 1) % s.settings.pane_count)
            }),
        ],
    },
    Group {
        title: "View",
        shortcuts: &[
            on(RESET_CAMERA, "Camera as in the scene", |_| Command::ResetCamera),
            on(FRAME, "Camera to the selected object", frame),
            on(EARLIER_VIEW, "Earlier view", |_| Command::EarlierView),
            on(RESET_ZOOM, "Whole picture", |_| Command::SetZoom(1.0, [0.5; 2])),
            on(HISTOGRAM, "Histogram of the active pane", |_| Command::ToggleHistogram),
            on(BOTH_PANELS, "Hide or show both panels", |_| Command::ToggleBothPanels),
            on(SCENE_PANEL, "Scene panel", |_| Command::ToggleScenePanel),
            on(RENDER_PANEL, "Render panel", |_| Command::ToggleRenderPanel),
            on(INSPECTOR, "Inspector", |_| Command::ShowTab(Tab::Inspector)),
            on(MEASURE, "Error against time", |_| Command::ShowTab(Tab::Measure)),
            on(VALUES, "Values under the pointer", |_| Command::ToggleValues),
            on(LARGER, "Larger interface", |_| Command::StepInterfaceScale(1)),
            on(key(CTRL, Key::Equals), "", |_| Command::StepInterfaceScale(1)),
            on(SMALLER, "Smaller interface", |_| Command::StepInterfaceScale(-1)),
        ],
    },
    Group {
        title: "Render",
        shortcuts: &[
            on(PAUSE, "Pause or go on", |_| Command::TogglePause),
            on(RESTART, "Start the images anew", |_| Command::Restart),
            on(key(NONE, Key::CloseBracket), "Brighter by ¼ stop", |s| {
                Command::SetExposure(s.settings.display.exposure + 0.25)
            }),
            on(key(NONE, Key::OpenBracket), "Darker by ¼ stop", |s| {
                Command::SetExposure(s.settings.display.exposure - 0.25)
            }),
            on(key(NONE, Key::Num0), "Exposure 0", |_| Command::SetExposure(0.0)),
        ],
    },
    Group {
        title: "Help",
        shortcuts: &[
            on(SHORTCUTS, "This list", |s| Command::ShowShortcuts(!s.windows.shortcuts)),
            on(key(NONE, Key::Escape), "Close what is on top", |_| Command::Escape),
        ],
    },
];

/// Whether keys are in the list.
pub fn is_listed(keys: &KeyboardShortcut) -> bool {
    GROUPS.iter().flat_map(|group| group.shortcuts).any(|shortcut| shortcut.keys == *keys)
}

/// The key of a manipulation by handles.
pub fn of(manipulation: Manipulation) -> KeyboardShortcut {
    match manipulation {
        Manipulation::Move => MOVE,
        Manipulation::Rotate => ROTATE,
        Manipulation::Scale => SCALE,
    }
}

/// The handles for `manipulation`, or none if those are there already.
fn handles(state: &State, manipulation: Manipulation) -> Command {
    Command::SetHandles(Some(manipulation).filter(|_| state.settings.handles != Some(manipulation)))
}

fn hide(state: &State) -> Command {
    state
        .selected_object()
        .map_or(Command::Nothing, |o| Command::object(o.name.clone(), ObjectEdit::Visible(!o.visible)))
}

fn duplicate(state: &State) -> Command {
    let edit = state.selected.as_deref().and_then(|name| build::duplicate(state.document.description(), name));
    edit.map_or(Command::Nothing, Command::Edit)
}

fn delete(state: &State) -> Command {
    state.selected_object().map_or(Command::Nothing, |object| Command::Edit(Edit::Remove(object.name.clone())))
}

fn rename(state: &State) -> Command {
    state.selected_object().map_or(Command::Nothing, |object| Command::Rename(Some(object.name.clone())))
}

fn frame(state: &State) -> Command {
    state.selected_object().map_or(Command::Nothing, |object| Command::FrameObject(object.name.clone()))
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

/// What keys do in a picture that has the focus, for the list.
pub const IN_PICTURE: &[(&str, &str)] = &[
    ("Tab", "next picture or control"),
    ("arrow keys", "orbit"),
    ("Shift+arrow keys", "pan"),
    ("plus, minus", "dolly"),
    ("Enter", "inspect the middle pixel"),
    ("Ctrl+arrow keys", "move the inspected pixel"),
];
