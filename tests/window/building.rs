//! Scenes that are built in the window: new, added to, renamed, saved, and changed from outside.

use std::path::Path;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use iorect::app::{Addition, App, Body, Command, MediumRef, Vessel, WorldPart};
use iorect::optics::Ior;
use iorect::scene::Description;
use iorect::scene::description::{Kind, Shape};

use crate::harness::{
    apply, choose, has_notice, has_text, press, quick, tab_to, type_into, type_over, until, window, window_of,
};

fn scene<'a>(harness: &'a Harness<'_, App>) -> &'a Description {
    harness.state().state().document.description()
}

fn names(harness: &Harness<'_, App>, kind: Kind) -> Vec<String> {
    scene(harness).objects.of(kind).iter().map(|object| object.name.clone()).collect()
}

fn selected<'a>(harness: &'a Harness<'_, App>) -> Option<&'a str> {
    harness.state().state().selected.as_deref()
}

/// An empty scene in the window.
fn new_scene() -> Harness<'static, App> {
    let mut harness = window("nested-spheres");
    press(&mut harness, Modifiers::COMMAND, Key::N);
    assert!(scene(&harness).objects.refractors().is_empty() && scene(&harness).name == "Untitled");
    harness
}

#[test]
fn iced_water_is_built_from_an_empty_scene_and_saved() {
    let mut harness = new_scene();
    // By the menu.
    choose(&mut harness, &["Add", "Add tumbler"]);
    assert_eq!((names(&harness, Kind::Refractor), selected(&harness)), (vec!["tumbler".into()], Some("tumbler")));
    // By the window of the key.
    press(&mut harness, Modifiers::SHIFT, Key::A);
    harness.get_by_label("Add water in tumbler").click();
    harness.run_steps(3);
    assert_eq!(selected(&harness), Some("water"));
    assert!(!harness.state().state().windows.add, "the window closes");
    // By the keyboard alone.
    for expected in ["ice cube", "ice cube 2"] {
        press(&mut harness, Modifiers::SHIFT, Key::A);
        tab_to(&mut harness, Role::Button, "Add ice cube");
        press(&mut harness, Modifiers::NONE, Key::Enter);
        assert_eq!(selected(&harness), Some(expected));
    }
    let all = ["tumbler", "water", "ice cube", "ice cube 2"];
    assert_eq!(names(&harness, Kind::Refractor), all);
    until(&mut harness, "it is rectified", |app| app.state().is_prepared());

    // Renamed, refused, undone, done again.
    press(&mut harness, Modifiers::NONE, Key::F2);
    type_over(&mut harness, "floe");
    assert_eq!((names(&harness, Kind::Refractor)[3].as_str(), selected(&harness)), ("floe", Some("floe")));
    for (name, why) in [("floor", "already"), ("world", "reserved"), ("  ", "empty")] {
        press(&mut harness, Modifiers::NONE, Key::F2);
        type_over(&mut harness, name);
        assert!(has_notice(&harness, why), "{name}: {:?}", harness.state().state().notices);
        assert_eq!(names(&harness, Kind::Refractor)[3], "floe");
    }
    press(&mut harness, Modifiers::NONE, Key::F2);
    harness.event(egui::Event::Text("given up".into()));
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(names(&harness, Kind::Refractor)[3] == "floe" && harness.state().state().renaming.is_none());
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(names(&harness, Kind::Refractor), all);
    press(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(names(&harness, Kind::Refractor)[3], "floe");

    // Duplicated and deleted.
    apply(&mut harness, Command::SelectObject(Some("floe".into())));
    press(&mut harness, Modifiers::COMMAND, Key::D);
    assert_eq!(selected(&harness), Some("floe 2"));
    press(&mut harness, Modifiers::NONE, Key::Delete);
    assert!(selected(&harness).is_none() && names(&harness, Kind::Refractor).len() == 4);

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("iced.toml");
    apply(&mut harness, Command::SaveAs(path.clone()));
    until(&mut harness, "it is saved", |app| !app.state().document.is_dirty());
    assert_eq!(scene(&harness).name, "iced", "it is called like its file");
    let again = iorect::formats::open(&path).expect("what was saved can be read");
    assert_eq!(Description { source: None, ..again }, Description { source: None, ..scene(&harness).clone() });
}

#[test]
fn a_new_scene_asks_before_edits_are_lost() {
    let mut harness = window("nested-spheres");
    apply(&mut harness, Command::set_ior(MediumRef::World, Ior::Constant(1.1)));
    press(&mut harness, Modifiers::COMMAND, Key::N);
    assert_ne!(scene(&harness).name, "Untitled");
    harness.get_by_label("New without saving").click();
    harness.run_steps(3);
    assert_eq!(scene(&harness).name, "Untitled");
}

/// What may not be is refused in words, and the card shows the fields of every shape.
#[test]
fn shapes_and_lights_are_edited_by_typing() {
    let mut harness = new_scene();
    apply(&mut harness, Command::Add(Addition::Refractor(Body::Sphere)));
    let radius = |harness: &Harness<'_, App>| match scene(harness).objects.find("sphere").map(|o| &o.shape) {
        Some(Shape::Sphere { radius, .. }) => *radius,
        _ => panic!("there is no sphere"),
    };
    let before = radius(&harness);
    for (text, expected) in [("-1", before), ("0.25", 0.25)] {
        type_into(&mut harness, Role::SpinButton, "Radius of sphere", text);
        assert_eq!(radius(&harness), expected);
    }
    assert!(has_notice(&harness, "must be greater than 0"));
    let all = Body::ALL.map(Addition::Refractor).into_iter().chain(Vessel::ALL.map(Addition::Vessel));
    let solids = Body::ALL.map(Addition::Solid).into_iter().chain([Addition::Floor, Addition::PanelLight]);
    for addition in all.chain(solids) {
        apply(&mut harness, Command::Add(addition.clone()));
        let name = selected(&harness).expect("it is selected").to_owned();
        assert!(harness.query_by_label(&format!("Move {name} along z")).is_some(), "{name} has a card");
    }
    apply(&mut harness, Command::Add(Addition::BallLight));
    // Its card has a line more once it is known what the light stands in.
    until(&mut harness, "the scene is prepared", |app| app.state().is_prepared());
    type_into(&mut harness, Role::SpinButton, "Strength of ball light", "7");
    let radiance =
        |harness: &Harness<'_, App>| scene(harness).objects.find("ball light").unwrap().light().unwrap().emission.rgb;
    assert_eq!(radiance(&harness), [7.0; 3]);
}

#[test]
fn a_filled_vessel_is_filled_higher() {
    let mut harness = new_scene();
    apply(&mut harness, Command::Add(Addition::Vessel(Vessel::ALL[1])));
    harness.get_by_label("Fill with water").click();
    harness.run_steps(3);
    let top = |harness: &Harness<'_, App>| scene(harness).objects.find("water").unwrap().shape.bounds().1.y;
    let before = top(&harness);
    harness.get_by_role_and_label(Role::Slider, "Fill height of water").set_value_accesskit(90.0);
    harness.run_steps(3);
    assert!(top(&harness) > before);
    assert!(
        harness.query_by_role_and_label(Role::Slider, "Fill height of water").is_some(),
        "it is still that vessel's"
    );
}

#[test]
fn priorities_are_moved_by_keys() {
    let mut harness = new_scene();
    for body in [Body::Sphere, Body::Box] {
        apply(&mut harness, Command::Add(Addition::Refractor(body)));
    }
    harness.get_by_label("Priorities").click();
    harness.run_steps(3);
    harness.get_by_label("Priority 0 of sphere").focus();
    harness.run_steps(3);
    let priority = |harness: &Harness<'_, App>, name: &str| {
        scene(harness).objects.find(name).unwrap().refractor().unwrap().priority
    };
    press(&mut harness, Modifiers::ALT, Key::ArrowUp);
    assert!(priority(&harness, "sphere") > priority(&harness, "box"));
    press(&mut harness, Modifiers::ALT, Key::ArrowDown);
    assert_eq!(priority(&harness, "sphere"), priority(&harness, "box"));
}

fn text_of(name: &str) -> String {
    format!(
        "name = \"{name}\"\n[camera]\nposition = [0, 1, 5]\ntarget = [0, 0, 0]\n[environment]\ncolor = [1, 1, 1]\n\
         [[medium]]\nname = \"glass\"\nior = 1.5\n[[refractor]]\nname = \"ball\"\nmedium = \"glass\"\n\
         shape = {{ sphere = {{ center = [0, 0, 0], radius = 1 }} }}\n"
    )
}

fn write(path: &Path, text: &str) {
    std::fs::write(path, text).expect("the folder can be written to");
}

/// Changed from outside: at once without edits, offered where there are some, refused in full where it is broken, and never overwritten
/// without asking.
#[test]
fn a_file_that_changes_on_disk_is_shown_or_offered() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("watched.toml");
    write(&path, &text_of("one"));
    let mut harness = window_of(path.to_str().expect("a plain path"), quick(), [1280.0, 720.0]);
    until(&mut harness, "the files are known", |_| true);
    std::thread::sleep(std::time::Duration::from_millis(600));
    write(&path, &text_of("two"));
    until(&mut harness, "the changed scene is shown", |app| app.state().document.description().name == "two");
    assert!(!harness.state().state().document.is_dirty());

    // Broken: all that is wrong, and the last good scene stays.
    write(&path, &text_of("three").replace("radius = 1", "radius = -1").replace("ior = 1.5", "ior = 0"));
    until(&mut harness, "the errors are told", |app| app.state().notices.iter().any(|notice| notice.is_error));
    assert!(
        has_notice(&harness, "watched.toml:9:7") && has_notice(&harness, "radius is -1"),
        "{:?}",
        harness.state().state().notices
    );
    assert_eq!(scene(&harness).name, "two");
    write(&path, &text_of("four"));
    until(&mut harness, "the mended scene is shown", |app| app.state().document.description().name == "four");
    assert!(harness.state().state().notices.iter().all(|notice| !notice.is_error), "the errors are gone");

    // With edits: offered. Loading it can be undone.
    apply(&mut harness, Command::set_ior(MediumRef::World, Ior::Constant(1.1)));
    write(&path, &text_of("five"));
    until(&mut harness, "it is offered", |app| app.state().outside_change.is_some());
    assert_eq!(scene(&harness).name, "four");
    harness.get_by_label("Load").click();
    until(&mut harness, "it is loaded", |app| app.state().document.description().name == "five");
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert!(scene(&harness).name == "four" && scene(&harness).world.ior.ior() == 1.1);
    press(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert!(scene(&harness).name == "five" && !harness.state().state().document.is_dirty());

    // Kept, and asked again before the file is overwritten.
    apply(&mut harness, Command::set_ior(MediumRef::World, Ior::Constant(1.2)));
    write(&path, &text_of("sixth"));
    until(&mut harness, "it is offered again", |app| app.state().outside_change.is_some());
    harness.get_by_label("Keep mine").click();
    harness.run_steps(3);
    assert!(harness.query_by_label("Keep mine").is_none());
    press(&mut harness, Modifiers::COMMAND, Key::S);
    harness.get_by_label("Cancel").click();
    harness.run_steps(3);
    assert!(std::fs::read_to_string(&path).unwrap().contains("sixth"));
    press(&mut harness, Modifiers::COMMAND, Key::S);
    harness.get_by_label("Overwrite").click();
    until(&mut harness, "it is saved", |app| !app.state().document.is_dirty());
    assert!(std::fs::read_to_string(&path).unwrap().contains("five"));
    // Its own writing is no change from outside.
    let before = harness.state().state().document.description().clone();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    harness.run_steps(3);
    assert!(std::sync::Arc::ptr_eq(&before, harness.state().state().document.description()));
}

/// Numbers beyond what a field takes are refused, with the reason at the field.
#[test]
fn numbers_out_of_range_are_refused_and_say_why() {
    let mut harness = new_scene();
    apply(&mut harness, Command::SelectWorld(WorldPart::Camera));
    let before = scene(&harness).camera;
    for (field, text, reason) in [
        ("Vertical field of view", "200", "200 is too large: at most 179."),
        ("Vertical field of view", "-5", "-5 is too small: at least 0.01."),
        ("Radius of the lens", "-1", "-1 is too small: at least 0."),
    ] {
        type_into(&mut harness, Role::SpinButton, field, text);
        assert!(has_text(&harness, reason), "{field}: no word of “{reason}”");
        assert_eq!(scene(&harness).camera, before, "{field}");
    }
    type_into(&mut harness, Role::SpinButton, "Vertical field of view", "30*2");
    assert_eq!(scene(&harness).camera.vertical_fov, 60.0);
    assert!(!has_text(&harness, "is too large"), "the reason goes");
    apply(&mut harness, Command::Add(Addition::Refractor(Body::Cylinder)));
    for (field, text, reason) in [
        ("Priority of cylinder", "0.5", "0.5 is no whole number."),
        ("Priority of cylinder", "3000000000", "at most 2147483647."),
        ("Segments of cylinder", "2", "2 is too small: at least 3."),
    ] {
        let before = scene(&harness).objects.find("cylinder").cloned();
        type_into(&mut harness, Role::SpinButton, field, text);
        assert!(has_text(&harness, reason), "{field}: no word of “{reason}”");
        assert_eq!(scene(&harness).objects.find("cylinder").cloned(), before, "{field}");
    }
}

/// A scene that had no file yet, and a mesh beside the file that it gets: both can be moved together.
#[test]
fn a_mesh_in_a_new_scene_goes_by_a_path_beside_its_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [mesh, path] = ["tetrahedron.obj", "mine.toml"].map(|name| folder.path().join(name));
    write(&mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    let mut harness = new_scene();
    apply(&mut harness, Command::ReadMesh(mesh));
    until(&mut harness, "the mesh is there", |app| !app.state().document.description().objects.refractors().is_empty());
    apply(&mut harness, Command::SaveAs(path.clone()));
    until(&mut harness, "it is saved", |app| !app.state().document.is_dirty());
    let text = std::fs::read_to_string(&path).expect("it was written");
    assert!(text.contains("mesh = \"tetrahedron.obj\""), "{text}");
    assert!(iorect::formats::open(&path).is_ok());
}
