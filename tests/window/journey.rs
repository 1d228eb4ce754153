//! From an empty scene to an exported comparison: iced water is built, the stack's error is found in the picture, an overlap is mended. Every
//! step by mouse, and every step by keyboard, in windows of four sizes, dark and light.

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use iorect::app::{App, Settings, SidePanel, Theme};
use iorect::scene::description::Kind;
use iorect::tracking::Mode;
use iorect::transport::parting::Parting;

use crate::harness::{
    choose, click, every_pane_has_an_image, has_notice, has_text, painted, press, quick, tab_to, type_over, until,
    window_of,
};

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

    /// Clicks a control, or goes to it with Tab and presses Enter.
    fn use_control(&mut self, role: Role, label: &str) {
        match self.by {
            By::Mouse => {
                self.harness.get_by_role_and_label(role, label).click();
                self.harness.run_steps(4);
            }
            By::Keyboard => {
                tab_to(&mut self.harness, role, label);
                press(&mut self.harness, Modifiers::NONE, Key::Enter);
            }
        }
    }

    /// An entry of a menu, or its key.
    fn command(&mut self, path: &[&str], modifiers: Modifiers, key: Key) {
        match self.by {
            By::Mouse => choose(&mut self.harness, path),
            By::Keyboard => press(&mut self.harness, modifiers, key),
        }
    }

    /// Something that is added: from the menu, or from the window of the key.
    fn add(&mut self, entry: &str) {
        self.command(&["Add", entry], Modifiers::SHIFT, Key::A);
        if self.by == By::Keyboard {
            self.use_control(Role::Button, entry);
        }
    }

    fn refractors(&self) -> Vec<String> {
        let objects = &self.harness.state().state().document.description().objects;
        objects.of(Kind::Refractor).iter().map(|object| object.name.clone()).collect()
    }

    fn priority(&self, name: &str) -> i32 {
        let object = self.harness.state().state().document.description().objects.find(name);
        object.and_then(|object| object.refractor()).expect("a refractor of that name").priority
    }

    fn verdict(&self, pane: usize) -> Option<String> {
        let start = format!("Verdict of pane {pane}: ");
        let found = self.harness.query_by_label_contains(&start)?.accesskit_node().label()?;
        found.strip_prefix(&start).map(str::to_owned)
    }

    fn is_inspecting(&self) -> bool {
        self.harness.state().state().inspection.is_some()
    }

    fn build_iced_water(&mut self) {
        self.command(&["File", "New"], Modifiers::COMMAND, Key::N);
        assert!(self.refractors().is_empty(), "the new scene is empty");
        for entry in ["Add tumbler", "Add water in tumbler", "Add ice cube"] {
            self.add(entry);
        }
        assert_eq!(self.refractors(), ["tumbler", "water", "ice cube"]);
    }

    /// Says what the picture itself says at the place where the paths part.
    fn find_out_why_the_stack_is_wrong(&mut self) {
        until(&mut self.harness, "the panes show the scene", every_pane_has_an_image);
        until(&mut self.harness, "the panes are judged", |app| {
            let verdicts = &app.state().verdicts.of;
            app.state().is_prepared()
                && [Mode::Stack, Mode::Rectified]
                    .iter()
                    .all(|mode| verdicts.get(mode).is_some_and(|verdict| verdict.paths >= 1024))
                // An edit's verdicts come after those of the scene before it.
                && verdicts.get(&Mode::Stack).is_some_and(|verdict| !verdict.is_right())
        });
        assert_eq!(self.verdict(2).as_deref(), Some("right"));
        let wrong = self.verdict(1).expect("the stack has a verdict");
        assert!(wrong.starts_with("wrong here: forgets that "), "{wrong}");
        self.use_control(Role::Button, &format!("Verdict of pane 1: {wrong}"));
        until(&mut self.harness, "the path through that place is followed", |app| {
            let traced = app.state().inspection.as_ref().and_then(|inspection| inspection.traced.as_ref());
            traced.is_some_and(|traced| traced.parting.is_some())
        });
        if self.by == By::Mouse {
            // Off the pictures: the numbers under the pointer take room of small panes.
            self.harness.hover_at(egui::pos2(2.0, 2.0));
        }
        self.harness.run_steps(4);
        assert!(has_text(&self.harness, "fills the volume; stack takes what was entered last"), "the panel says why");
        let inspection = self.harness.state().state().inspection.clone().expect("a pixel is inspected");
        let heading = inspection.traced.as_ref().and_then(|traced| traced.parting.as_ref()).map(Parting::heading);
        let heading = heading.expect("the paths part");
        let pane = self.harness.state().pane_place(Some(0));
        let is_said = painted(&self.harness)
            .into_iter()
            .any(|(text, _)| text.galley.text() == heading && pane.contains_rect(text.visual_bounding_rect()));
        assert!(is_said, "the picture says “{heading}”");
        match self.by {
            By::Mouse => self.use_control(Role::Button, "Close"),
            By::Keyboard => {
                // The first may put away the focus alone.
                press(&mut self.harness, Modifiers::NONE, Key::Escape);
                if self.is_inspecting() {
                    press(&mut self.harness, Modifiers::NONE, Key::Escape);
                }
            }
        }
        assert!(!self.is_inspecting());
    }

    /// Two volumes that overlap are of one priority, until the remedy that the program proposes is taken.
    fn make_and_fix_an_overlap(&mut self) {
        if !self.harness.state().state().has_panel(SidePanel::Scene) {
            match self.by {
                By::Mouse => self.use_control(Role::Button, "Scene panel"),
                By::Keyboard => press(&mut self.harness, Modifiers::NONE, Key::F1),
            }
        }
        self.use_control(Role::TreeItem, "water");
        assert_eq!(self.harness.state().state().selected.as_deref(), Some("water"));
        let wanted = self.priority("tumbler");
        match self.by {
            By::Mouse => {
                // Once more: the card gives its room to the list.
                self.use_control(Role::TreeItem, "water");
                click(&mut self.harness, "Priorities");
                self.harness.run_steps(30);
                let row = |name: &str, priority: i32| {
                    self.harness.get_by_label(&format!("Priority {priority} of {name}")).rect().center()
                };
                let (from, to) = (row("water", self.priority("water")), row("tumbler", wanted));
                drag(&mut self.harness, from, to);
            }
            By::Keyboard => {
                tab_to(&mut self.harness, Role::SpinButton, "Priority of water");
                type_over(&mut self.harness, &wanted.to_string());
            }
        }
        assert_eq!(self.priority("water"), wanted);
        let has_tie = |app: &App| app.state().problems().iter().any(|problem| problem.kind.contains("overlap"));
        until(&mut self.harness, "the tie is found", |app| app.state().is_prepared() && has_tie(app));
        self.use_control(Role::Button, "Fix");
        until(&mut self.harness, "the tie is broken", |app| app.state().is_prepared() && !has_tie(app));
    }

    fn export_the_comparison(&mut self) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        self.harness.state_mut().prompt_in(folder.path().to_owned());
        until(&mut self.harness, "the panes show the scene again", every_pane_has_an_image);
        let keys = Modifiers::COMMAND | Modifiers::SHIFT;
        self.command(&["File", "Export", "All panes, as shown (PNG)…"], keys, Key::E);
        while self.harness.query_by_role_and_label(Role::TextInput, "Path").is_none() {
            std::thread::sleep(std::time::Duration::from_millis(2));
            self.harness.step();
        }
        self.harness.run_steps(2);
        let name = match self.by {
            By::Mouse => {
                self.use_control(Role::Button, "Save");
                "scene-panes.png"
            }
            By::Keyboard => {
                let name = "comparison.png";
                type_over(&mut self.harness, folder.path().join(name).to_str().expect("a plain path"));
                name
            }
        };
        until(&mut self.harness, "the comparison is written", |app| {
            app.state().notices.iter().any(|notice| notice.is_error || notice.text.contains(name))
        });
        assert!(has_notice(&self.harness, name), "{:?}", self.harness.state().state().notices);
        let picture = image::open(folder.path().join(name)).expect("a picture that can be read").to_rgb8();
        let colors: std::collections::BTreeSet<_> = picture.pixels().map(|pixel| pixel.0).collect();
        assert!(colors.len() > 500, "the comparison shows something: {} colours", colors.len());
    }
}

/// Presses at one place, and lets go at another.
fn drag(harness: &mut Harness<'_, App>, from: egui::Pos2, to: egui::Pos2) {
    harness.hover_at(from);
    harness.drag_at(from);
    harness.run_steps(2);
    for step in 1..=6 {
        harness.hover_at(from.lerp(to, step as f32 / 6.0));
        harness.run_steps(2);
    }
    harness.drop_at(to);
    harness.run_steps(4);
}

fn walk(by: By, size: [f32; 2], theme: Theme) {
    let mut journey = Journey::begin(by, size, theme);
    journey.build_iced_water();
    journey.find_out_why_the_stack_is_wrong();
    journey.make_and_fix_an_overlap();
    journey.export_the_comparison();
}

#[test]
fn by_mouse_in_a_small_dark_window() {
    walk(By::Mouse, [800.0, 600.0], Theme::Dark);
}

#[test]
fn by_keyboard_in_a_small_light_window() {
    walk(By::Keyboard, [800.0, 600.0], Theme::Light);
}

#[test]
fn by_mouse_in_a_light_window() {
    walk(By::Mouse, [1280.0, 720.0], Theme::Light);
}

#[test]
fn by_keyboard_in_a_dark_window() {
    walk(By::Keyboard, [1280.0, 720.0], Theme::Dark);
}

#[test]
fn by_mouse_in_a_large_dark_window() {
    walk(By::Mouse, [1920.0, 1080.0], Theme::Dark);
}

#[test]
fn by_keyboard_in_a_large_light_window() {
    walk(By::Keyboard, [1920.0, 1080.0], Theme::Light);
}

#[test]
fn by_mouse_in_the_largest_light_window() {
    walk(By::Mouse, [3840.0, 2160.0], Theme::Light);
}

#[test]
fn by_keyboard_in_the_largest_dark_window() {
    walk(By::Keyboard, [3840.0, 2160.0], Theme::Dark);
}
