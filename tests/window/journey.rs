//! From an empty scene to an exported comparison: iced water is built, the stack's error is found in the picture, an overlap is mended. Once by
//! mouse and once by keyboard, in windows of several sizes, dark and light.

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use iorect::app::{App, Command, ExportKind, Settings, Theme};
use iorect::scene::description::Kind;
use iorect::tracking::Mode;

use crate::harness::{apply, every_pane_has_an_image, quick, until, window_of};

#[derive(Clone, Copy, PartialEq)]
enum By {
    Mouse,
    Keyboard,
}

struct Journey {
    harness: Harness<'static, App>,
    by: By,
}

impl Journey {
    fn begin(by: By, size: [f32; 2], theme: Theme) -> Self {
        // Larger windows have smaller film pixels per point: the path of light is the same.
        let resolution_scale = (200.0 / size[0]).min(0.25);
        let settings = Settings { theme, resolution_scale, ..quick() };
        Self { harness: window_of("nested-spheres", settings, size), by }
    }

    fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(4);
    }

    /// Clicks a control, or gives it the focus and presses Enter.
    fn use_control(&mut self, role: Role, label: &str) {
        match self.by {
            By::Mouse => self.harness.get_by_role_and_label(role, label).click(),
            By::Keyboard => {
                self.harness.get_by_role_and_label(role, label).focus();
                self.harness.run_steps(3);
                self.harness.key_press(Key::Enter);
            }
        }
        self.harness.run_steps(4);
    }

    /// An entry of a menu of the menu bar, or its key.
    fn command(&mut self, menu: &str, entry: &str, keys: (Modifiers, Key)) {
        match self.by {
            By::Mouse => {
                self.harness.get_by_label(menu).click();
                self.harness.run_steps(4);
                self.harness.get_by_label(entry).click();
                self.harness.run_steps(4);
            }
            By::Keyboard => self.press(keys.0, keys.1),
        }
    }

    /// Something that is added: from the menu, or from the window of the key.
    fn add(&mut self, entry: &str) {
        match self.by {
            By::Mouse => {
                self.harness.get_by_label("Add").click();
                self.harness.run_steps(4);
                self.harness.get_by_label(entry).click();
            }
            By::Keyboard => {
                self.press(Modifiers::SHIFT, Key::A);
                self.harness.get_by_label(entry).focus();
                self.harness.run_steps(3);
                self.harness.key_press(Key::Enter);
            }
        }
        self.harness.run_steps(4);
    }

    fn refractors(&self) -> Vec<String> {
        let objects = &self.harness.state().state().document.description().objects;
        objects.of(Kind::Refractor).iter().map(|object| object.name.clone()).collect()
    }

    fn verdict(&self, pane: usize) -> Option<String> {
        let start = format!("Verdict of pane {pane}: ");
        let found = self.harness.query_by_label_contains(&start)?.accesskit_node().label()?;
        found.strip_prefix(&start).map(str::to_owned)
    }
}

fn walk(by: By, size: [f32; 2], theme: Theme) {
    let mut journey = Journey::begin(by, size, theme);
    journey.command("File", "New", (Modifiers::COMMAND, Key::N));
    assert!(journey.refractors().is_empty(), "the new scene is empty");
    for entry in ["Add tumbler", "Add water in tumbler", "Add ice cube"] {
        journey.add(entry);
    }
    assert_eq!(journey.refractors(), ["tumbler", "water", "ice cube"]);

    // What is wrong, and why.
    until(&mut journey.harness, "the panes show the scene", every_pane_has_an_image);
    until(&mut journey.harness, "the panes are judged", |app| {
        let verdicts = &app.state().verdicts.of;
        app.state().is_prepared()
            && [Mode::Stack, Mode::Rectified].iter().all(|mode| verdicts.get(mode).is_some_and(|v| v.paths >= 1024))
    });
    assert_eq!(journey.verdict(2).as_deref(), Some("right"));
    let wrong = journey.verdict(1).expect("the stack has a verdict");
    assert!(wrong.starts_with("wrong here: forgets that "), "{wrong}");
    journey.use_control(Role::Button, &format!("Verdict of pane 1: {wrong}"));
    until(&mut journey.harness, "the path through that place is followed", |app| {
        let traced = app.state().inspection.as_ref().and_then(|inspection| inspection.traced.as_ref());
        traced.is_some_and(|traced| traced.parting.is_some())
    });
    journey.harness.run_steps(4);
    assert!(
        journey.harness.query_all_by_label_contains("fills the volume; stack takes what was entered last").count() > 0
    );
    journey.press(Modifiers::NONE, Key::Escape);

    // An overlap without an order, and its remedy.
    apply(&mut journey.harness, Command::SelectObject(Some("water".into())));
    let tumbler = journey.harness.state().state().document.description().objects.find("tumbler").unwrap();
    let priority = tumbler.refractor().unwrap().priority;
    let tied = Command::object("water", iorect::app::ObjectEdit::Priority(priority));
    apply(&mut journey.harness, tied);
    until(&mut journey.harness, "the tie is found", |app| {
        app.state().is_prepared() && app.state().problems().iter().any(|problem| problem.kind.contains("overlap"))
    });
    journey.harness.run_steps(4);
    journey.use_control(Role::Button, "Fix");
    until(&mut journey.harness, "the tie is broken", |app| {
        app.state().is_prepared() && !app.state().problems().iter().any(|problem| problem.kind.contains("overlap"))
    });

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("comparison.png");
    until(&mut journey.harness, "the panes show the scene again", every_pane_has_an_image);
    apply(&mut journey.harness, Command::Export(ExportKind::ShownPanes, path.clone()));
    until(&mut journey.harness, "the comparison is written", |app| {
        app.state().notices.iter().any(|notice| notice.text.contains("comparison.png"))
    });
    let picture = image::open(&path).expect("a picture that can be read").to_rgb8();
    let colors: std::collections::BTreeSet<_> = picture.pixels().map(|pixel| pixel.0).collect();
    assert!(colors.len() > 500, "the comparison shows something: {} colours", colors.len());
}

#[test]
fn by_mouse_in_a_dark_window() {
    walk(By::Mouse, [1280.0, 720.0], Theme::Dark);
}

#[test]
fn by_keyboard_in_a_small_light_window() {
    walk(By::Keyboard, [800.0, 600.0], Theme::Light);
}

#[test]
fn by_keyboard_in_a_large_dark_window() {
    walk(By::Keyboard, [1920.0, 1080.0], Theme::Dark);
}

#[test]
fn by_mouse_in_the_largest_light_window() {
    walk(By::Mouse, [3840.0, 2160.0], Theme::Light);
}
