//! What a scene declares, in the window.

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use iorect::app::{App, Command, Edit, MediaEdit, WorldPart};
use iorect::formats::to_text;

use crate::harness::{apply, click_at, press, until, window};

fn outside<'a>(harness: &'a Harness<'_, App>, object: &str) -> Option<&'a str> {
    harness.state().state().document.description().objects.find(object).and_then(|object| object.outside())
}

fn choose_in(harness: &mut Harness<'_, App>, list: &str, entry: &str) {
    // What has the focus is scrolled to.
    harness.get_by_role_and_label(Role::ComboBox, list).focus();
    harness.run_steps(20);
    let combo = harness.get_by_role_and_label(Role::ComboBox, list).rect().center();
    press(harness, Modifiers::NONE, Key::Enter);
    harness.run_steps(4);
    // Rows of the tree may be called the same.
    let places = harness.query_all_by_role_and_label(Role::Button, entry).map(|node| node.rect().center());
    let nearest = places.min_by(|a, b| a.distance(combo).total_cmp(&b.distance(combo)));
    click_at(harness, nearest.unwrap_or_else(|| panic!("there is no {entry}")));
    harness.run_steps(4);
}

#[test]
fn a_declaration_is_chosen_checked_and_undone() {
    let mut harness = window("nested-spheres");
    let description = harness.state().state().document.description().clone();
    let [outer, inner] = [0, 1].map(|index| description.objects.refractors()[index].name.clone());
    let around = description.objects.refractors()[0].refractor().unwrap().medium.clone();
    apply(&mut harness, Command::SelectObject(Some(inner.clone())));
    harness.run_steps(3);
    let list = format!("Declared outside of {inner}");
    assert_eq!(outside(&harness, &inner), None);
    choose_in(&mut harness, &list, "world");
    assert_eq!(outside(&harness, &inner), Some("world"));
    until(&mut harness, "it is found wrong", |app| {
        app.state().problems().iter().any(|problem| problem.kind == "declared_outside" && problem.place == inner)
    });
    choose_in(&mut harness, &list, &around);
    assert_eq!(outside(&harness, &inner), Some(&*around));
    // A medium that is renamed is still the one that is declared.
    let renamed = MediaEdit::Rename(around.clone(), "soup".into());
    apply(&mut harness, Command::Edit(Edit::Media(renamed)));
    assert_eq!(outside(&harness, &inner), Some("soup"));
    assert!(to_text(harness.state().state().document.description()).contains("outside = \"soup\""));
    for _ in 0..3 {
        press(&mut harness, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(outside(&harness, &inner), None);
    assert_eq!(outside(&harness, &outer), None);
}

#[test]
fn the_camera_has_a_declared_medium() {
    let mut harness = window("camera-in-water");
    let medium = harness.state().state().document.description().media[0].name.clone();
    apply(&mut harness, Command::SelectWorld(WorldPart::Camera));
    harness.run_steps(3);
    choose_in(&mut harness, "Declared around the camera", &medium);
    assert_eq!(harness.state().state().document.description().camera_medium, Some(medium));
}
