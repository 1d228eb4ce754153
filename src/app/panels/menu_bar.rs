//! File, Edit, View, Render, Help, and the scene's name.

use egui::text::LayoutJob;
use egui::{Align, Atom, Button, KeyboardShortcut, Layout, MenuBar, Response, RichText, TextFormat, TextStyle, Ui};

use crate::app::build;
use crate::app::command::{Command, ExportKind};
use crate::app::edit::{Edit, ObjectEdit};
use crate::app::keys;
use crate::app::objects::Manipulation;
use crate::app::settings::{Arrangement, InterfaceScale, MAX_PANES, Preset, SidePanel, Tab, Theme};
use crate::app::state::State;
use crate::app::theme::{CHECK_MARK, Palette};
use crate::app::widgets::menu_ui;

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| menu_ui(ui, |ui| file_ui(ui, state, commands)));
        ui.menu_button("Edit", |ui| menu_ui(ui, |ui| edit_ui(ui, state, commands)));
        ui.menu_button("Add", |ui| menu_ui(ui, |ui| super::add::menu_ui(ui, state, commands)));
        ui.menu_button("View", |ui| menu_ui(ui, |ui| view_ui(ui, state, commands)));
        ui.menu_button("Render", |ui| menu_ui(ui, |ui| render_ui(ui, state, commands)));
        ui.menu_button("Help", |ui| menu_ui(ui, |ui| help_ui(ui, commands)));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let palette = Palette::of(ui);
            let is_dirty = state.document.is_dirty();
            let name = &state.document.description().name;
            let text = if is_dirty { format!("{name} •") } else { name.clone() };
            let hint = match (&state.document.path, is_dirty) {
                (Some(path), false) => path.display().to_string(),
                (Some(path), true) => format!("{}\nEdited: not saved yet.", path.display()),
                (None, is_dirty) if let Some(path) = state.document.watched_path() => {
                    let edited = if is_dirty { "Edited: not saved yet.\n" } else { "" };
                    format!("{}\n{edited}Saving makes a scene file of it.", path.display())
                }
                (None, _) if state.document.description().source.is_none() => "A new scene: not saved yet.".to_owned(),
                (None, false) => "A built-in scene.".to_owned(),
                (None, true) => "A built-in scene, edited: not saved yet.".to_owned(),
            };
            ui.add(egui::Label::new(RichText::new(text).color(palette.weak_text)).truncate()).on_hover_text(hint);
        });
    });
}

/// The keys that do the same as an entry.
type Keys = Option<KeyboardShortcut>;

/// An entry of a menu.
fn item(ui: &mut Ui, text: &str, keys: Keys, commands: &mut Vec<Command>, command: Command) {
    item_enabled(ui, true, text, keys, commands, command);
}

fn item_enabled(ui: &mut Ui, is_enabled: bool, text: &str, keys: Keys, commands: &mut Vec<Command>, command: Command) {
    if entry_ui(ui, is_enabled, false, text, keys).clicked() {
        commands.push(command);
        ui.close();
    }
}

/// An entry with a mark that says whether it is on.
fn choice(ui: &mut Ui, is_on: bool, text: &str, keys: Keys, commands: &mut Vec<Command>, command: Command) {
    let response = entry_ui(ui, true, is_on, text, keys);
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, is_on, text));
    if response.clicked() {
        commands.push(command);
        ui.close();
    }
}

/// A line of a menu: room for a mark, the text, and at the right the keys.
fn entry_ui(ui: &mut Ui, is_enabled: bool, is_on: bool, text: &str, keys: Keys) -> Response {
    debug_assert!(keys.is_none_or(|keys| keys::is_listed(&keys)), "{text} has a key that the list lacks");
    let keys = keys.map(|keys| keys::text(&keys, ui.ctx().os().is_mac())).unwrap_or_default();
    let button = Button::new((mark(ui, is_on, text), Atom::grow())).right_text(RichText::new(keys).small().weak());
    ui.add_enabled(is_enabled, button).accessible_name(text)
}

/// The text of an entry, after a mark or the room for one.
fn mark(ui: &Ui, is_on: bool, text: &str) -> LayoutJob {
    let color = if ui.is_enabled() { egui::Color32::PLACEHOLDER } else { ui.visuals().weak_text_color() };
    let mono = TextStyle::Monospace.resolve(ui.style());
    let mut job = LayoutJob::default();
    job.append(if is_on { CHECK_MARK } else { " " }, 0.0, TextFormat::simple(mono, color));
    job.append(text, 6.0, TextFormat::simple(TextStyle::Body.resolve(ui.style()), color));
    job
}

/// A menu in a menu.
fn submenu_ui(ui: &mut Ui, text: &str, contents: impl FnOnce(&mut Ui)) {
    let job = mark(ui, false, text);
    ui.menu_button(job, |ui| menu_ui(ui, contents)).response.accessible_name(text);
}

fn file_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    item(ui, "New", Some(keys::NEW), commands, Command::New);
    item(ui, "Open…", Some(keys::OPEN), commands, Command::AskOpen);
    item(ui, "Built-in scenes…", Some(keys::GALLERY), commands, Command::ShowGallery(true));
    submenu_ui(ui, "Open recent", |ui| {
        if state.settings.recent.is_empty() {
            ui.weak("No files yet");
            return;
        }
        for path in &state.settings.recent {
            if ui.add(Button::new(shortened(path)).truncate()).on_hover_text(path).clicked() {
                commands.push(Command::Open(path.into()));
                ui.close();
            }
        }
        ui.separator();
        item(ui, "Clear the list", None, commands, Command::ClearRecent);
    });
    ui.separator();
    item(ui, "Save", Some(keys::SAVE), commands, Command::Save);
    item(ui, "Save as…", Some(keys::SAVE_AS), commands, Command::AskSaveAs);
    ui.separator();
    submenu_ui(ui, "Export", |ui| {
        let all = [
            (
                "Active pane, as shown (PNG)…",
                Some(keys::EXPORT_PANE),
                ExportKind::ShownPane,
                "What the window shows, pixel by pixel: colours, range, legend, labels, zoom.",
            ),
            (
                "All panes, as shown (PNG)…",
                Some(keys::EXPORT_ALL),
                ExportKind::ShownPanes,
                "All panes as the window shows them, with the divider of a wipe.",
            ),
            (
                "Active pane, picture only (PNG)…",
                None,
                ExportKind::PanePng,
                "The whole film at its own size, with exposure and tone curve, and nothing over it.",
            ),
            (
                "Active pane, linear (EXR)…",
                None,
                ExportKind::PaneExr,
                "Radiance as 32-bit floats, without exposure or tone curve.",
            ),
            (
                "Comparison sheet (PNG)…",
                None,
                ExportKind::AllPanesPng,
                "The films of all panes in full, labelled, with measured differences below.",
            ),
        ];
        for (text, keys, kind, about) in all {
            let response = entry_ui(ui, state.report.is_some(), false, text, keys).on_hover_text(about);
            if response.clicked() {
                commands.push(Command::AskExport(kind));
                ui.close();
            }
        }
        let is_measured = state.measurement.results.curves.values().any(|curve| !curve.points.is_empty());
        let ask = Command::AskExport(ExportKind::ErrorsCsv);
        item_enabled(ui, is_measured, "Measured errors (CSV)…", None, commands, ask);
        let has_path = state.inspection.as_ref().is_some_and(|inspection| inspection.traced.is_some());
        for (text, kind) in
            [("Inspected path (SVG)…", ExportKind::PathSvg), ("Inspected path (JSON)…", ExportKind::PathJson)]
        {
            item_enabled(ui, has_path, text, None, commands, Command::AskExport(kind));
        }
    });
    submenu_ui(ui, "tev", |ui| {
        let about = "The linear radiance of every pane to the image viewer tev, where it is running.";
        let send = entry_ui(ui, state.report.is_some(), false, "Send to tev", None).on_hover_text(about);
        if send.clicked() {
            commands.push(Command::SendToTev);
            ui.close();
        }
        choice(ui, state.is_live_in_tev, "Keep tev up to date", None, commands, Command::ToggleTevLive);
        item(ui, "Address of tev…", None, commands, Command::AskTevAddress);
    });
    ui.separator();
    item(ui, "Quit", Some(keys::QUIT), commands, Command::Quit);
}

/// The end of a long path, which tells files apart.
fn shortened(path: &str) -> String {
    const MOST: usize = 48;
    let length = path.chars().count();
    if length <= MOST {
        path.to_owned()
    } else {
        format!("…{}", path.chars().skip(length - MOST).collect::<String>())
    }
}

fn edit_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let steps = [
        ("Undo", state.document.undo_label(), keys::UNDO, Command::Undo),
        ("Redo", state.document.redo_label(), keys::REDO, Command::Redo),
    ];
    for (verb, label, keys, command) in steps {
        let text = label.as_ref().map_or(verb.to_owned(), |label| format!("{verb} {label}"));
        item_enabled(ui, label.is_some(), &text, Some(keys), commands, command);
    }
    ui.separator();
    let has_images = state.report.is_some();
    item_enabled(ui, has_images, "Copy the active pane", Some(keys::COPY_PANE), commands, Command::CopyPane);
    item_enabled(ui, has_images, "Copy all panes", Some(keys::COPY_PANES), commands, Command::CopyPanes);
    item_enabled(ui, has_images, "Copy values of the pixel", Some(keys::COPY_VALUES), commands, Command::CopyValues);
    ui.separator();
    for manipulation in Manipulation::ALL {
        let is_on = state.settings.handles == Some(manipulation);
        let command = Command::SetHandles((!is_on).then_some(manipulation));
        let text = format!("{} by handles", manipulation.name());
        choice(ui, is_on, &text, Some(keys::of(manipulation)), commands, command);
    }
    ui.separator();
    let selected = state.selected_object();
    let copy = selected.and_then(|object| build::duplicate(state.document.description(), &object.name));
    let is_some = selected.is_some();
    item(ui, "Add…", Some(keys::ADD), commands, Command::ShowAdd(true));
    let duplicate = copy.map_or(Command::Nothing, Command::Edit);
    item_enabled(ui, is_some, "Duplicate", Some(keys::DUPLICATE), commands, duplicate);
    let name = selected.map(|object| object.name.clone()).unwrap_or_default();
    item_enabled(ui, is_some, "Rename", Some(keys::RENAME), commands, Command::Rename(Some(name.clone())));
    item_enabled(ui, is_some, "Delete", Some(keys::DELETE), commands, Command::Edit(Edit::Remove(name)));
    let name = selected.map(|object| object.name.clone()).unwrap_or_default();
    let visible = selected.is_none_or(|object| object.visible);
    let verb = if visible { "Hide" } else { "Show" };
    let hide = Command::object(name.clone(), ObjectEdit::Visible(!visible));
    item_enabled(ui, selected.is_some(), &format!("{verb} {name}"), Some(keys::HIDE), commands, hide);
}

fn view_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let settings = &state.settings;
    for (count, name, key) in
        [(1, "One pane", egui::Key::Num1), (2, "Two panes", egui::Key::Num2), (4, "Four panes", egui::Key::Num4)]
    {
        let keys = KeyboardShortcut::new(egui::Modifiers::NONE, key);
        choice(ui, settings.pane_count == count, name, Some(keys), commands, Command::SetPaneCount(count));
    }
    submenu_ui(ui, "Preset of panes", |ui| {
        for preset in Preset::ALL {
            let is_on = settings.pane_count == MAX_PANES && settings.panes == preset.panes();
            choice(ui, is_on, preset.name(), None, commands, Command::SetPreset(preset));
        }
    });
    let text = "Built-in scenes choose the panes";
    choice(ui, settings.has_first_panes, text, None, commands, Command::ToggleFirstPanes);
    let is_wipe = settings.arrangement == Arrangement::Wipe;
    let next = if is_wipe { Arrangement::Tiles } else { Arrangement::Wipe };
    choice(ui, is_wipe, "Wipe", Some(keys::WIPE), commands, Command::SetArrangement(next));
    ui.separator();
    item(ui, "Camera as in the scene", Some(keys::RESET_CAMERA), commands, Command::ResetCamera);
    let selected = state.selected_object().map(|object| object.name.clone());
    let to_selected = Command::FrameObject(selected.clone().unwrap_or_default());
    item_enabled(ui, selected.is_some(), "Camera to the selected object", Some(keys::FRAME), commands, to_selected);
    let has_earlier = !state.earlier_views.is_empty();
    item_enabled(ui, has_earlier, "Earlier view", Some(keys::EARLIER_VIEW), commands, Command::EarlierView);
    item(ui, "Make this view the scene's own", None, commands, Command::Edit(Edit::Camera(state.view.camera)));
    item(ui, "Whole picture", Some(keys::RESET_ZOOM), commands, Command::SetZoom(1.0, [0.5; 2]));
    ui.separator();
    let is_on = state.has_panel(SidePanel::Scene);
    choice(ui, is_on, "Scene panel", Some(keys::SCENE_PANEL), commands, Command::ToggleScenePanel);
    let is_on = state.has_panel(SidePanel::Render);
    choice(ui, is_on, "Render panel", Some(keys::RENDER_PANEL), commands, Command::ToggleRenderPanel);
    choice(ui, settings.show_problems, "Problems", None, commands, Command::ToggleProblems);
    let tabs = [
        (Tab::Rectification, "Interfaces", None),
        (Tab::Inspector, "Inspector", Some(keys::INSPECTOR)),
        (Tab::Measure, "Error against time", Some(keys::MEASURE)),
    ];
    for (tab, name, keys) in tabs {
        let is_on = state.has_panel(SidePanel::Render) && settings.tab == tab;
        choice(ui, is_on, name, keys, commands, Command::ShowTab(tab));
    }
    let values = "Values under the pointer";
    let is_on = settings.show_histogram;
    choice(ui, is_on, "Histogram", Some(keys::HISTOGRAM), commands, Command::ToggleHistogram);
    choice(ui, settings.show_values, values, Some(keys::VALUES), commands, Command::ToggleValues);
    ui.separator();
    submenu_ui(ui, "Theme", |ui| {
        for (theme, name) in [(Theme::System, "As the system"), (Theme::Dark, "Dark"), (Theme::Light, "Light")] {
            choice(ui, settings.theme == theme, name, None, commands, Command::SetTheme(theme));
        }
    });
    submenu_ui(ui, "Size of the interface", |ui| {
        let automatic = (InterfaceScale::Automatic, "Automatic".to_owned());
        let factors = InterfaceScale::FACTORS.map(|x| (InterfaceScale::Factor(x), format!("{} %", x * 100.0)));
        for (scale, name) in std::iter::once(automatic).chain(factors) {
            choice(ui, settings.interface_scale == scale, &name, None, commands, Command::SetInterfaceScale(scale));
        }
    });
}

fn render_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let name = if state.is_paused { "Go on" } else { "Pause" };
    item(ui, name, Some(keys::PAUSE), commands, Command::TogglePause);
    item(ui, "Start anew", Some(keys::RESTART), commands, Command::Restart);
}

fn help_ui(ui: &mut Ui, commands: &mut Vec<Command>) {
    item(ui, "Keyboard and mouse", Some(keys::SHORTCUTS), commands, Command::ShowShortcuts(true));
    item(ui, "Tour", None, commands, Command::ShowTour(Some(0)));
    item(ui, "Messages", None, commands, Command::ShowMessages(true));
    item(ui, "About iorect", None, commands, Command::ShowAbout(true));
}
