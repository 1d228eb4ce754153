//! Images on solids in the window.

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use iorect::app::{App, Command};
use iorect::scene::description::Paint;

use crate::harness::{apply, has_notice, has_text, until, window};

fn paint(harness: &Harness<'_, App>, name: &str) -> Paint {
    let description = harness.state().state().document.description();
    description.objects.find(name).and_then(|object| object.solid()).expect("a solid").paint.clone()
}

#[test]
fn a_solid_gets_an_image_and_a_colour_again() {
    let mut harness = window("iced-water");
    let name = harness.state().state().document.description().objects.solids()[0].name.clone();
    let before = paint(&harness, &name);
    apply(&mut harness, Command::SelectObject(Some(name.clone())));
    harness.run_steps(3);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("oak.png");
    image::RgbImage::from_pixel(8, 4, image::Rgb([255, 0, 0])).save(&path).expect("it is written");
    apply(&mut harness, Command::ReadTexture(path.clone()));
    until(&mut harness, "the image is on it", |app| {
        let objects = &app.state().document.description().objects;
        objects.iter().any(|object| object.solid().is_some_and(|s| matches!(s.paint, Paint::Texture { .. })))
    });
    harness.run_steps(3);
    let Paint::Texture { path: named, tint, .. } = paint(&harness, &name) else { panic!("no image") };
    assert_eq!((&named, tint), (&path, [1.0; 3]));
    assert!(has_text(&harness, "oak.png") && has_text(&harness, "Tint"));
    // The mean of the image.
    harness.get_by_label("Colour").click();
    harness.run_steps(3);
    assert_eq!(paint(&harness, &name), Paint::Color([1.0, 0.0, 0.0]));
    for _ in 0..2 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.run_steps(3);
    }
    assert_eq!(paint(&harness, &name), before);
    // What is no image is a notice, and the solid stays as it is.
    let path = folder.path().join("no.png");
    std::fs::write(&path, "text").expect("it is written");
    apply(&mut harness, Command::ReadTexture(path));
    until(&mut harness, "it is refused", |app| !app.state().notices.is_empty());
    assert!(has_notice(&harness, "no image that is read"));
    assert_eq!(paint(&harness, &name), before);
}
