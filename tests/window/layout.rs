//! What lies where, what is on top, and where the focus is.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use iorect::app::{App, Command, Settings, SidePanel, Tab};

use crate::harness::{apply, click_at, press, quick, window, window_of};

const SIZES: [[f32; 2]; 4] = [[1280.0, 720.0], [800.0, 600.0], [640.0, 480.0], [500.0, 340.0]];

fn screen(harness: &Harness<'_, App>) -> Rect {
    harness.ctx.content_rect()
}

/// The panels that are to be seen, and whether what is in them is inside the window.
fn shown(harness: &Harness<'_, App>) -> [bool; 2] {
    let screen = screen(harness);
    let is_seen = |label: &str| harness.query_all_by_label(label).any(|node| screen.contains_rect(node.rect()));
    // The bar of tabs at the top of the right panel.
    [is_seen("SCENE"), is_seen("Interfaces")]
}

#[test]
fn every_panel_is_reached_at_every_size_by_keys() {
    for size in SIZES {
        let mut harness = window_of("plain-glass", quick(), size);
        for (panel, key) in [(SidePanel::Scene, Key::F1), (SidePanel::Render, Key::F3)] {
            if harness.state().state().has_panel(panel) {
                press(&mut harness, Modifiers::NONE, key);
            }
            assert!(!shown(&harness)[panel as usize], "{panel:?} has been put away at {size:?}");
            press(&mut harness, Modifiers::NONE, key);
            assert!(shown(&harness)[panel as usize], "{panel:?} is shown at {size:?}");
        }
        for (key, tab) in [(Key::I, Tab::Inspector), (Key::M, Tab::Measure)] {
            press(&mut harness, Modifiers::NONE, key);
            assert_eq!(harness.state().state().settings.tab, tab);
            assert!(shown(&harness)[1], "{tab:?} is shown at {size:?}");
        }
    }
}

#[test]
fn every_panel_of_a_narrow_window_is_reached_by_its_button() {
    for size in &SIZES[1..] {
        let mut harness = window_of("plain-glass", quick(), *size);
        for (name, index, tab) in [
            ("Render panel", 1, Some(Tab::Render)),
            ("Interfaces panel", 1, Some(Tab::Rectification)),
            ("Inspector panel", 1, Some(Tab::Inspector)),
            ("Measure panel", 1, Some(Tab::Measure)),
            ("Scene panel", 0, None),
        ] {
            if harness.state().state().has_panel([SidePanel::Scene, SidePanel::Render][index]) && tab.is_none() {
                apply(&mut harness, Command::ToggleScenePanel);
            }
            harness.get_by_role_and_label(Role::Button, name).click();
            harness.run_steps(4);
            assert!(shown(&harness)[index], "{name} at {size:?}");
            assert!(tab.is_none_or(|tab| harness.state().state().settings.tab == tab));
            let button = harness.get_by_role_and_label(Role::Button, name).rect();
            assert!(screen(&harness).contains_rect(button), "{name} stays in reach at {size:?}");
        }
        // The same button puts the panel away again.
        harness.get_by_role_and_label(Role::Button, "Scene panel").click();
        harness.run_steps(4);
        assert_eq!(shown(&harness), [false; 2]);
    }
}

/// The name of the control that has the focus.
fn focused(harness: &Harness<'_, App>) -> Option<String> {
    crate::harness::focused(harness).map(|(_, name)| name)
}

fn has_popup(harness: &Harness<'_, App>) -> bool {
    egui::Popup::is_any_open(&harness.ctx)
}

/// Inspects a pixel and shows its path: what Escape would put away if it went past a menu.
fn inspecting(size: [f32; 2]) -> Harness<'static, App> {
    let mut harness = window_of("plain-glass", Settings { tab: Tab::Render, ..quick() }, size);
    apply(&mut harness, Command::Inspect(Some([0.5, 0.5])));
    harness
}

fn escape(harness: &mut Harness<'_, App>) {
    press(harness, Modifiers::NONE, Key::Escape);
}

#[test]
fn escape_closes_menus_and_lists_and_nothing_else() {
    let mut harness = inspecting([1280.0, 720.0]);
    let mut buttons: Vec<(Role, &str)> =
        ["File", "Edit", "View", "Render", "Help"].map(|menu| (Role::Button, menu)).into();
    buttons.extend([(Role::Button, "Pane 1: stack"), (Role::ComboBox, "Compare"), (Role::ComboBox, "Pane 3")]);
    for (role, name) in buttons {
        // The tab "Render" has the name of a menu, which comes first.
        let place = harness.query_all_by_role_and_label(role, name).next().expect(name).rect().center();
        click_at(&mut harness, place);
        assert!(has_popup(&harness), "{name} opens");
        escape(&mut harness);
        assert!(!has_popup(&harness), "Escape closes {name}");
        assert!(harness.state().state().inspection.is_some(), "Escape only closes {name}");
    }
    harness.get_by_role_and_label(Role::TreeItem, "world").click();
    harness.run_steps(3);
    harness.query_all_by_role(Role::TreeItem).nth(3).expect("there is a refractor").click_secondary();
    harness.run_steps(4);
    assert!(has_popup(&harness), "a right click opens a menu");
    escape(&mut harness);
    assert!(!has_popup(&harness));
    assert!(harness.state().state().inspection.is_some());
    escape(&mut harness);
    assert!(harness.state().state().inspection.is_none(), "the path is what was left to be put away");
}

fn has_dialog(harness: &Harness<'_, App>, title: &str) -> bool {
    harness.query_by_role_and_label(Role::Dialog, title).is_some()
}

#[test]
fn escape_closes_windows_and_questions_one_by_one() {
    let mut harness = inspecting([1280.0, 720.0]);
    for (command, title) in [
        (Command::ShowGallery(true), "Built-in scenes"),
        (Command::ShowShortcuts(true), "Keyboard and mouse"),
        (Command::ShowAbout(true), "About iorect"),
    ] {
        apply(&mut harness, command);
        assert!(has_dialog(&harness, title));
        escape(&mut harness);
        assert!(!has_dialog(&harness, title), "Escape closes {title}");
        assert!(harness.state().state().inspection.is_some(), "and only that");
    }
    // A question over a window.
    harness.get_by_role_and_label(Role::Slider, "IOR of world").set_value_accesskit(1.1);
    harness.run_steps(3);
    apply(&mut harness, Command::ShowAbout(true));
    apply(&mut harness, Command::Open("siblings".into()));
    assert!(has_dialog(&harness, "Question"));
    escape(&mut harness);
    assert!(!has_dialog(&harness, "Question"));
    assert!(has_dialog(&harness, "About iorect"), "the question was on top");
    escape(&mut harness);
    assert!(!has_dialog(&harness, "About iorect"));
    assert!(harness.state().state().inspection.is_some());
}

#[test]
fn escape_gives_up_typing_a_number_and_nothing_else() {
    let mut harness = inspecting([1280.0, 720.0]);
    harness.get_by_role_and_label(Role::TextInput, "IOR of world").click();
    harness.run_steps(3);
    harness.event(egui::Event::Text("1.25".into()));
    harness.run_steps(2);
    escape(&mut harness);
    let state = harness.state().state();
    assert!(!state.document.is_dirty(), "the number is as it was");
    assert!(state.inspection.is_some());
}

#[test]
fn the_gallery_is_used_by_keyboard() {
    let mut harness = window("nested-spheres");
    // The focus comes back to where it was.
    harness.get_by_role_and_label(Role::Slider, "IOR of glass").focus();
    harness.run_steps(3);
    assert_eq!(focused(&harness).as_deref(), Some("IOR of glass"));
    press(&mut harness, Modifiers::COMMAND, Key::B);
    assert_eq!(focused(&harness).as_deref(), Some("nested-spheres"), "the scene that is open has the focus");
    let names: Vec<String> = iorect::formats::builtin::all().iter().map(|scene| scene.name.to_owned()).collect();
    let is_inside = |name: &Option<String>| name.as_ref().is_some_and(|name| names.contains(name) || name == "Close");
    for (modifiers, key) in [
        (Modifiers::NONE, Key::Tab),
        (Modifiers::SHIFT, Key::Tab),
        (Modifiers::NONE, Key::ArrowUp),
        (Modifiers::NONE, Key::ArrowDown),
        (Modifiers::NONE, Key::ArrowLeft),
        (Modifiers::NONE, Key::ArrowRight),
    ] {
        for step in 0..names.len() + 3 {
            press(&mut harness, modifiers, key);
            let now = focused(&harness);
            assert!(is_inside(&now), "{key:?}, {step}: the focus went to {now:?}");
        }
    }
    escape(&mut harness);
    assert!(!harness.state().state().windows.gallery);
    assert_eq!(focused(&harness).as_deref(), Some("IOR of glass"));

    press(&mut harness, Modifiers::COMMAND, Key::B);
    press(&mut harness, Modifiers::NONE, Key::ArrowLeft);
    let chosen = focused(&harness).filter(|name| names.contains(name)).unwrap_or_else(|| {
        press(&mut harness, Modifiers::NONE, Key::Tab);
        focused(&harness).expect("an entry has the focus")
    });
    press(&mut harness, Modifiers::NONE, Key::Enter);
    assert!(!harness.state().state().windows.gallery, "Enter opens what has the focus");
    crate::harness::until(&mut harness, "the scene is open", move |app| {
        let source = app.state().document.description().source.as_ref();
        source.is_some_and(|source| source.path.file_stem().is_some_and(|stem| *stem == *chosen))
    });
}

#[test]
fn every_window_takes_the_focus_keeps_it_and_gives_it_back() {
    let mut harness = window("nested-spheres");
    for command in [Command::ShowShortcuts(true), Command::ShowAbout(true), Command::ShowGallery(true)] {
        harness.get_by_role_and_label(Role::Slider, "IOR of glass").focus();
        harness.run_steps(3);
        apply(&mut harness, command.clone());
        let first = focused(&harness).expect("something in the window has the focus");
        assert_ne!(first, "IOR of glass");
        for key in [Key::Tab, Key::ArrowLeft, Key::ArrowDown, Key::Tab] {
            press(&mut harness, Modifiers::NONE, key);
            assert_ne!(focused(&harness).as_deref(), Some("IOR of glass"), "{command:?}");
            assert!(focused(&harness).is_some(), "{command:?}");
        }
        escape(&mut harness);
        assert_eq!(focused(&harness).as_deref(), Some("IOR of glass"), "{command:?}");
    }
}

/// Labels in the window that is on top, which lies in the middle.
fn labels_of(harness: &Harness<'_, App>, names: &[&str]) -> Vec<(String, Rect)> {
    names
        .iter()
        .flat_map(|name| harness.query_all_by_role_and_label(Role::Label, name))
        .map(|node| (node.accesskit_node().value().or(node.accesskit_node().label()).unwrap_or_default(), node.rect()))
        .collect()
}

#[test]
fn the_list_of_keys_has_columns_that_do_not_overlap() {
    for size in [[1280.0, 720.0], [820.0, 600.0], [640.0, 480.0], [480.0, 320.0]] {
        let mut harness = window_of("plain-glass", quick(), size);
        press(&mut harness, Modifiers::NONE, Key::Questionmark);
        let keys = ["drag", "right or middle drag", "Ctrl while dragging it", "Ctrl+Shift+S", "Esc", "?", "Backspace"];
        let what = [
            "orbit",
            "pan",
            "in steps; Esc gives the drag up",
            "Save as…",
            "Close what is on top",
            "This list",
            "Earlier view",
        ];
        let labels = labels_of(&harness, &[&keys[..], &what[..]].concat());
        assert!(labels.len() >= keys.len() + what.len(), "{} labels at {size:?}", labels.len());
        for (index, (name, rect)) in labels.iter().enumerate() {
            for (other, other_rect) in &labels[index + 1..] {
                assert!(!rect.shrink(0.5).intersects(*other_rect), "{name} and {other} overlap at {size:?}");
            }
            assert!(rect.left() >= 0.0 && rect.right() <= size[0], "{name} is cut off at {size:?}: {rect:?}");
        }
    }
}

#[test]
fn every_menu_and_list_is_inside_the_window() {
    for size in [[1280.0, 720.0], [800.0, 600.0], [640.0, 480.0]] {
        let mut harness = window_of("plain-glass", Settings { narrow_panel: SidePanel::Render, ..quick() }, size);
        let buttons = ["File", "Edit", "View", "Help", "Pane 1: stack"].map(|name| (Role::Button, name));
        for (role, name) in buttons.into_iter().chain([(Role::ComboBox, "Pane 4"), (Role::ComboBox, "Compare")]) {
            let place = harness.query_all_by_role_and_label(role, name).next().expect(name).rect().center();
            click_at(&mut harness, place);
            harness.run_steps(2);
            assert!(has_popup(&harness), "{name} opens");
            let popups: Vec<Rect> = harness.ctx.memory(|memory| {
                memory
                    .layer_ids()
                    .filter(|layer| layer.order == egui::Order::Foreground)
                    .filter_map(|layer| memory.area_rect(layer.id))
                    .collect()
            });
            for popup in popups {
                assert!(screen(&harness).expand(1.0).contains_rect(popup), "{name} at {size:?}: {popup:?}");
            }
            escape(&mut harness);
        }
    }
}
