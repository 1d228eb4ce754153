//! What a screen reader is told, and what the keyboard reaches.

use std::collections::BTreeMap;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{By, NodeT, Queryable};
use iorect::app::{App, Command, Preset, Settings, Tab};
use iorect::tracking::Mode;

use crate::harness::{apply, every_pane_has_an_image, press, quick, texts, until, window_of};

const TABS: [Tab; 4] = [Tab::Render, Tab::Rectification, Tab::Inspector, Tab::Measure];

/// Roles that somebody acts on.
fn is_interactive(role: Role) -> bool {
    matches!(
        role,
        Role::Button
            | Role::CheckBox
            | Role::RadioButton
            | Role::Slider
            | Role::SpinButton
            | Role::ComboBox
            | Role::TextInput
            | Role::TreeItem
            | Role::Link
            | Role::Image
            | Role::ColorWell
            | Role::DisclosureTriangle
    )
}

fn assert_named(harness: &Harness<'_, App>, place: &str) {
    let mut seen: BTreeMap<(String, String, String), usize> = BTreeMap::new();
    for node in harness.query_all(By::new()) {
        let node = node.accesskit_node();
        if !is_interactive(node.role()) {
            continue;
        }
        let name = node.label().unwrap_or_default();
        assert!(!name.trim().is_empty(), "{place}: a {:?} without a name at {:?}", node.role(), node.raw_bounds());
        let parent = node.parent().map(|parent| format!("{:?}", parent.id())).unwrap_or_default();
        *seen.entry((parent, format!("{:?}", node.role()), name)).or_default() += 1;
    }
    for ((_, role, name), count) in seen {
        assert_eq!(count, 1, "{place}: {count} of role {role} side by side are called “{name}”");
    }
    for text in texts(harness) {
        assert!(!text.contains('`'), "{place}: backticks in “{text}”");
    }
}

#[test]
fn everything_has_a_name_of_its_own() {
    for scene in ["iced-water", "camera-in-water"] {
        let mut harness = window_of(scene, quick(), [1280.0, 720.0]);
        until(&mut harness, "there are images", every_pane_has_an_image);
        let first = harness.state().state().document.description().objects.refractors()[0].name.clone();
        apply(&mut harness, Command::SelectObject(Some(first)));
        apply(&mut harness, Command::Inspect(Some([0.5, 0.5])));
        for tab in TABS {
            apply(&mut harness, Command::ShowTab(tab));
            assert_named(&harness, &format!("{scene}, {tab:?}"));
        }
        for (command, name) in [
            (Command::ShowGallery(true), "gallery"),
            (Command::ShowShortcuts(true), "keys"),
            (Command::ShowAbout(true), "about"),
            (Command::ShowMessages(true), "messages"),
        ] {
            apply(&mut harness, command);
            assert_named(&harness, name);
        }
    }
}

/// A lamp that shines into a wall, overlaps without priorities, a camera inside: several kinds of problems.
const DOUBTFUL: &str = r#"
name = "Doubtful"
[camera]
position = [0.0, 0.0, 0.9]
target = [0, 0, 0]
[environment]
color = [1, 1, 1]
[[medium]]
name = "glass"
ior = 1.5
[[medium]]
name = "water"
ior = 1.333
[[refractor]]
name = "ball"
medium = "glass"
shape = { sphere = { center = [0, 0, 0], radius = 1 } }
[[refractor]]
name = "drop"
medium = "water"
shape = { sphere = { center = [0.7, 0, 0], radius = 0.6 } }
[[solid]]
name = "wall"
shape = { box = { min = [-3, -3, -3], max = [3, 3, -2] } }
color = [0.5, 0.5, 0.5]
"#;

#[test]
fn problems_and_refusals_are_shown_with_quotes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("doubtful.toml");
    std::fs::write(&path, DOUBTFUL).unwrap();
    let mut harness = window_of(path.to_str().expect("a plain path"), quick(), [1280.0, 720.0]);
    let problems = harness.state().state().problems().to_vec();
    assert!(problems.len() > 1 && problems.iter().any(|problem| problem.message.contains('`')));
    if let Some(more) = harness.query_by_label(&format!("+{} more", problems.len() - 1)) {
        more.click();
    }
    harness.run_steps(4);
    assert!(texts(&harness).iter().any(|text| text.contains('“')), "names stand between quotes");
    assert_named(&harness, "problems");

    let broken = folder.path().join("broken.toml");
    std::fs::write(&broken, "name = \"x\"\nflavour = 3\n").unwrap();
    apply(&mut harness, Command::Open(broken));
    until(&mut harness, "the refusal is there", |app| !app.state().notices.is_empty());
    assert!(texts(&harness).iter().any(|text| text.contains("“flavour”")));
    assert_named(&harness, "a refusal");
}

#[test]
fn a_mode_has_one_name() {
    let others = ["per object", "per-object", "rectified object", "rectified, object", "patch against object"];
    for preset in Preset::ALL {
        let settings = Settings { panes: preset.panes(), ..quick() };
        let mut harness = window_of("plain-glass", settings, [1280.0, 720.0]);
        for tab in TABS {
            apply(&mut harness, Command::ShowTab(tab));
            let all: Vec<String> = texts(&harness).into_iter().map(|text| text.to_lowercase()).collect();
            for other in others {
                assert!(!all.iter().any(|text| text.contains(other)), "{preset:?}, {tab:?}: “{other}”");
            }
        }
        for content in preset.panes() {
            for mode in content.modes() {
                assert!(content.to_string().contains(mode.name()), "{content} names {mode}");
            }
        }
    }
    assert!(Mode::ALL.iter().all(|mode| mode.name().chars().all(|c| c.is_ascii_lowercase() || c == '-')));
}

#[test]
fn pictures_are_named_and_turned_by_keyboard() {
    let mut harness = window_of("plain-glass", Settings { pane_count: 2, ..quick() }, [1280.0, 720.0]);
    until(&mut harness, "there are images", every_pane_has_an_image);
    for (pane, mode) in [(1, "stack"), (2, "rectified")] {
        let name = format!("Picture of pane {pane}: {mode}, ");
        let node = harness.get_by(move |node| {
            node.role() == Role::Image && node.label().is_some_and(|label| label.starts_with(&name))
        });
        let name = node.accesskit_node().label().unwrap_or_default();
        assert!(name.contains("per pixel") || name.contains("preview"), "{name}");
    }
    harness.get_by(|node| node.label().is_some_and(|label| label.starts_with("Picture of pane 2"))).focus();
    harness.run_steps(3);
    assert_eq!(harness.state().state().view.active_pane, 1, "the pane that has the focus is the active one");
    let camera = |harness: &Harness<'_, App>| harness.state().state().view.camera;
    let before = camera(&harness);
    let distance = before.position.distance(before.target);
    for (key, back) in [(Key::ArrowLeft, Key::ArrowRight), (Key::ArrowUp, Key::ArrowDown)] {
        let start = camera(&harness);
        press(&mut harness, Modifiers::NONE, key);
        let now = camera(&harness);
        assert_ne!(now.position, start.position, "{key:?} orbits");
        assert_eq!(now.target, start.target);
        assert!((now.position.distance(now.target) - distance).abs() < 1e-9);
        press(&mut harness, Modifiers::NONE, back);
        assert!(camera(&harness).position.distance(start.position) < 1e-6, "{back:?} goes back");
    }
    press(&mut harness, Modifiers::SHIFT, Key::ArrowRight);
    assert_ne!(camera(&harness).target, before.target, "Shift pans");
    let far = camera(&harness);
    press(&mut harness, Modifiers::NONE, Key::Plus);
    let near = camera(&harness);
    assert!(near.position.distance(near.target) < far.position.distance(far.target), "plus goes nearer");
    press(&mut harness, Modifiers::NONE, Key::Minus);
    press(&mut harness, Modifiers::NONE, Key::Minus);
    assert!(camera(&harness).position.distance(near.target) > near.position.distance(near.target));
    press(&mut harness, Modifiers::NONE, Key::Enter);
    let point = harness.state().state().inspection.as_ref().expect("Enter inspects").point;
    press(&mut harness, Modifiers::COMMAND, Key::ArrowRight);
    assert!(harness.state().state().inspection.as_ref().expect("still").point[0] > point[0]);
    // The space bar pauses, also here; Escape puts the path away, and the focus stays.
    press(&mut harness, Modifiers::NONE, Key::Space);
    assert!(harness.state().state().is_paused);
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(harness.state().state().inspection.is_none());
    let before = camera(&harness);
    press(&mut harness, Modifiers::NONE, Key::ArrowLeft);
    assert_ne!(camera(&harness).position, before.position, "the picture still has the focus");
}

#[test]
fn tab_reaches_every_picture() {
    let mut harness = window_of("plain-glass", quick(), [1280.0, 720.0]);
    let mut reached = std::collections::BTreeSet::new();
    for _ in 0..150 {
        press(&mut harness, Modifiers::NONE, Key::Tab);
        for node in harness.query_all(By::new().predicate(|node| node.is_focused() && node.label().is_some())) {
            let name = node.accesskit_node().label().unwrap_or_default();
            reached.extend(name.strip_prefix("Picture of pane ").and_then(|rest| rest.chars().next()));
        }
        if reached.len() == 4 {
            return;
        }
    }
    panic!("only {reached:?} were reached");
}
