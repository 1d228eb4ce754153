//! The window without a display, for tests that act as a person would.

use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui::epaint::{ClippedShape, Shape, TextShape};
use egui::{Key, Modifiers, Pos2, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{By, NodeT, Queryable};
use iorect::app::{App, Command, Settings};

/// Images of a quarter of the size are enough and quick.
pub fn quick() -> Settings {
    Settings { resolution_scale: 0.25, has_first_panes: false, ..Settings::default() }
}

pub fn window_of(scene: &str, settings: Settings, size: [f32; 2]) -> Harness<'static, App> {
    let description = iorect::formats::open(scene).expect("a built-in scene");
    let mut harness = Harness::builder()
        .with_size(size)
        .with_step_dt(1.0 / 60.0)
        .build_eframe(move |cc| App::new(cc, description, Some(settings)).expect("threads can be started"));
    // The tree and the strip of problems come with the report: nothing moves under the pointer after that.
    until(&mut harness, "the scene is prepared and checked", |app| {
        app.state().report.as_ref().is_some_and(|report| report.problems.is_some())
    });
    harness
}

pub fn window(scene: &str) -> Harness<'static, App> {
    window_of(scene, quick(), [1280.0, 720.0])
}

/// Runs frames until `is_met`, and fails after a long time.
pub fn until(harness: &mut Harness<'_, App>, what: &str, is_met: impl Fn(&App) -> bool) {
    let start = Instant::now();
    while !is_met(harness.state()) {
        assert!(start.elapsed() < Duration::from_secs(120), "waited too long until {what}");
        std::thread::sleep(Duration::from_millis(5));
        harness.step();
    }
    // What was shown for it must have reached the screen.
    harness.run_steps(2);
}

pub fn apply(harness: &mut Harness<'_, App>, command: Command) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, command);
    harness.run_steps(3);
}

pub fn every_pane_has_an_image(app: &App) -> bool {
    (0..app.state().settings.pane_count).all(|pane| app.samples_shown(pane) > 0)
}

/// Where the first pane's whole picture is, between the panels.
pub fn picture_of(harness: &Harness<'_, App>) -> egui::Rect {
    harness.state().picture().expect("a pane has been shown")
}

/// Presses a key.
pub fn press(harness: &mut Harness<'_, App>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    harness.run_steps(4);
}

/// Clicks a place in the window.
pub fn click_at(harness: &mut Harness<'_, App>, place: Pos2) {
    harness.hover_at(place);
    harness.drag_at(place);
    harness.drop_at(place);
    harness.run_steps(4);
}

/// Clicks the first control of that name.
pub fn click(harness: &mut Harness<'_, App>, label: &str) {
    let place =
        harness.query_all_by_label(label).next().unwrap_or_else(|| panic!("there is no {label}")).rect().center();
    click_at(harness, place);
}

/// Clicks through a menu: what opens it, menus within it, and the entry. The pointer rests over inner menus until they open.
pub fn choose(harness: &mut Harness<'_, App>, path: &[&str]) {
    let [first, inner @ .., entry] = path else { panic!("a menu and an entry") };
    click(harness, first);
    for menu in inner {
        harness.get_by_label(menu).hover();
        harness.run_steps(10);
    }
    harness.get_by_label(entry).click();
    harness.run_steps(4);
}

/// Opens a list by the keyboard, types the beginning of an entry and takes it.
pub fn choose_by_typing(harness: &mut Harness<'_, App>, list: &str, beginning: &str) {
    harness.get_by_role_and_label(Role::ComboBox, list).focus();
    harness.run_steps(2);
    press(harness, Modifiers::NONE, Key::Enter);
    harness.event(egui::Event::Text(beginning.into()));
    harness.run_steps(2);
    press(harness, Modifiers::NONE, Key::Enter);
}

/// Types over what stands in the field that has the focus.
pub fn type_over(harness: &mut Harness<'_, App>, text: &str) {
    press(harness, Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text(text.into()));
    harness.run_steps(2);
    press(harness, Modifiers::NONE, Key::Enter);
}

/// Clicks a field and types over what stands there.
pub fn type_into(harness: &mut Harness<'_, App>, role: Role, label: &str, text: &str) {
    harness.get_by_role_and_label(role, label).click();
    harness.run_steps(3);
    type_over(harness, text);
}

/// Every text that a screen reader is told: names and values of controls, and labels.
pub fn texts(harness: &Harness<'_, App>) -> Vec<String> {
    let nodes = harness.query_all(By::new());
    nodes.flat_map(|node| [node.accesskit_node().label(), node.accesskit_node().value()]).flatten().collect()
}

pub fn has_text(harness: &Harness<'_, App>, part: &str) -> bool {
    texts(harness).iter().any(|text| text.contains(part))
}

pub fn has_notice(harness: &Harness<'_, App>, part: &str) -> bool {
    harness.state().state().notices.iter().any(|notice| notice.text.contains(part))
}

/// Role and name of the control that has the focus.
pub fn focused(harness: &Harness<'_, App>) -> Option<(Role, String)> {
    let node = harness.query_all(By::new().predicate(|node| node.is_focused() && node.label().is_some())).next()?;
    Some((node.accesskit_node().role(), node.accesskit_node().label()?))
}

/// Goes from control to control with the key Tab until that one has the focus. What has it must be in sight.
pub fn tab_to(harness: &mut Harness<'_, App>, role: Role, label: &str) {
    /// More than there are controls.
    const MOST: usize = 400;
    for _ in 0..MOST {
        harness.key_press(Key::Tab);
        harness.step();
        if focused(harness).is_some_and(|(its_role, name)| its_role == role && name == label) {
            // A list scrolls to it.
            harness.run_steps(30);
            let id = harness.ctx.memory(egui::Memory::focused).expect("it has the focus");
            let response = harness.ctx.read_response(id).expect("it is shown");
            assert!(response.interact_rect.contains(response.rect.center()), "{label} has the focus out of sight");
            return;
        }
    }
    panic!("Tab does not reach the {role:?} {label}");
}

/// The texts that were painted in the last frame, with the rectangle that they may be seen in.
pub fn painted(harness: &Harness<'_, App>) -> Vec<(TextShape, Rect)> {
    fn gather(shape: &Shape, clip: Rect, found: &mut Vec<(TextShape, Rect)>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| gather(shape, clip, found)),
            Shape::Text(text) if !text.galley.text().trim().is_empty() => found.push((text.clone(), clip)),
            _ => {}
        }
    }
    let mut found = Vec::new();
    for ClippedShape { clip_rect, shape, .. } in &harness.output().shapes {
        gather(shape, *clip_rect, &mut found);
    }
    found
}

/// Files dropped on the window together.
pub fn drop_files(harness: &mut Harness<'_, App>, paths: &[&std::path::Path]) {
    #[derive(Debug)]
    struct Dropped(std::path::PathBuf);
    impl egui::DroppedFile for Dropped {
        fn path(&self) -> &std::path::Path {
            &self.0
        }

        fn bytes(&self) -> Result<Vec<u8>, String> {
            std::fs::read(&self.0).map_err(|error| error.to_string())
        }
    }
    for path in paths {
        harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path.to_path_buf())));
    }
    harness.step();
}
