//! Media in the window: the control for an index, what objects are made of, and the world.

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use iorect::app::{App, Command, WorldPart};
use iorect::optics::{Ior, catalog};
use iorect::scene::description::Environment;

use crate::harness::{apply, choose_by_typing, has_text, type_into, until, window};

fn model(harness: &Harness<'_, App>, medium: &str) -> Ior {
    harness.state().state().document.description().medium(medium).expect("the scene has this medium").ior.clone()
}

fn medium_of(harness: &Harness<'_, App>, object: &str) -> String {
    let description = harness.state().state().document.description();
    description.objects.find(object).and_then(|object| object.refractor()).expect("a refractor").medium.clone()
}

fn selected(object: &str) -> Harness<'static, App> {
    let mut harness = window("nested-spheres");
    apply(&mut harness, Command::SelectObject(Some(object.into())));
    harness.run_steps(3);
    harness
}

/// Into the field of the card.
fn type_ior(harness: &mut Harness<'_, App>, medium: &str, text: &str) {
    let name = format!("Index of refraction of {medium}");
    harness.get_by_role_and_label(Role::TextInput, &name).focus();
    harness.run_steps(3);
    harness.event(egui::Event::Text(text.into()));
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
}

#[test]
fn numbers_calculations_and_names_are_typed() {
    let mut harness = selected("glass ball");
    for (text, wanted) in [
        ("4/3", Ior::Constant(4.0 / 3.0)),
        ("1,5", Ior::Constant(1.5)),
        ("n = sqrt(2)", Ior::Constant(2.0_f64.sqrt())),
        ("diam", Ior::Catalog(catalog::find("diamond").unwrap())),
    ] {
        type_ior(&mut harness, "glass", text);
        assert_eq!(model(&harness, "glass"), wanted, "{text}");
    }
    // Digits that were typed have not changed the number of panes, and each text is a step of its own or part of one.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_ne!(model(&harness, "glass"), Ior::Catalog(catalog::find("diamond").unwrap()));
}

#[test]
fn what_is_refused_stays_and_says_why() {
    let mut harness = selected("glass ball");
    let before = model(&harness, "glass");
    for (text, reason) in [
        ("1,5,2", "two decimal commas"),
        ("0", "0 is no index of refraction"),
        ("watr", "did you mean “water”?"),
        ("4/", "stops in the middle"),
    ] {
        type_ior(&mut harness, "glass", text);
        assert_eq!(model(&harness, "glass"), before, "{text}");
        assert!(has_text(&harness, reason), "no word of {reason}");
        assert!(harness.state().state().notices.is_empty(), "a toast for {text}");
    }
    // A text that is fine takes the reason away.
    type_ior(&mut harness, "glass", "1.6");
    assert_eq!(model(&harness, "glass"), Ior::Constant(1.6));
    assert!(!has_text(&harness, "stops in the middle"));
    assert!(!harness.state().state().document.is_dirty() || model(&harness, "glass") != before);
}

#[test]
fn keys_step_the_index_and_go_from_tick_to_tick() {
    let mut harness = selected("glass ball");
    type_ior(&mut harness, "glass", "1.5");
    harness.get_by_role_and_label(Role::Slider, "Index of refraction of glass").focus();
    harness.run_steps(3);
    let camera = harness.state().state().view.camera;
    for (modifiers, key, wanted) in [
        (Modifiers::NONE, Key::ArrowRight, 1.501),
        (Modifiers::NONE, Key::ArrowUp, 1.502),
        (Modifiers::NONE, Key::ArrowLeft, 1.501),
        (Modifiers::SHIFT, Key::ArrowRight, 1.5011),
        (Modifiers::COMMAND, Key::ArrowDown, 1.4911),
    ] {
        harness.key_press_modifiers(modifiers, key);
        harness.run_steps(3);
        assert!((model(&harness, "glass").ior() - wanted).abs() < 1e-9, "{key:?}: {:?}", model(&harness, "glass"));
    }
    harness.key_press(Key::Home);
    harness.run_steps(3);
    assert_eq!(model(&harness, "glass"), Ior::Catalog(catalog::find("pmma").unwrap()));
    harness.key_press(Key::End);
    harness.run_steps(3);
    assert_eq!(model(&harness, "glass"), Ior::Catalog(catalog::find("n-bk7").unwrap()));
    assert_eq!(harness.state().state().view.camera, camera, "Home belongs to the rail");
}

/// Presses at one place of the rail, and releases at another.
fn drag_rail(harness: &mut Harness<'_, App>, from: f32, to: f32, modifiers: Modifiers) {
    let rect = harness.get_by_role_and_label(Role::Slider, "Index of refraction of glass").rect();
    let y = rect.top() + 33.0;
    let track = rect.shrink2(egui::vec2(8.0, 0.0));
    let at = |place: f32| egui::pos2(track.left() + place * track.width(), y);
    let button =
        |pos, pressed| egui::Event::PointerButton { pos, button: egui::PointerButton::Primary, pressed, modifiers };
    harness.event(egui::Event::PointerMoved(at(from)));
    harness.run_steps(2);
    harness.event_modifiers(button(at(from), true), modifiers);
    harness.run_steps(2);
    for step in 1..=4 {
        let place = from + (to - from) * step as f32 / 4.0;
        harness.event_modifiers(egui::Event::PointerMoved(at(place)), modifiers);
        harness.run_steps(1);
    }
    harness.event_modifiers(button(at(to), false), modifiers);
    harness.run_steps(3);
}

/// Where an index stands between 1.3 and 1.6, which have the places from 0.17 to 0.72.
fn place(n: f32) -> f32 {
    0.17 + (n - 1.3) / 0.3 * 0.55
}

#[test]
fn a_drag_snaps_to_the_catalogue_and_is_one_step() {
    let mut harness = selected("glass ball");
    type_ior(&mut harness, "glass", "1.42");
    let water = Ior::Catalog(catalog::find("water").unwrap());
    drag_rail(&mut harness, place(1.42), place(1.3345), Modifiers::NONE);
    assert_eq!(model(&harness, "glass"), water, "near water it is water, dispersion and all");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(model(&harness, "glass"), Ior::Constant(1.42));

    drag_rail(&mut harness, place(1.42), place(1.3345), Modifiers::ALT);
    let Ior::Constant(n) = model(&harness, "glass") else { panic!("it has snapped") };
    assert!((n - 1.3345).abs() < 0.004, "{n}");

    // With Shift the same way is a twentieth.
    type_ior(&mut harness, "glass", "1.42");
    drag_rail(&mut harness, place(1.42), place(1.44), Modifiers::SHIFT);
    let n = model(&harness, "glass").ior();
    assert!((n - 1.421).abs() < 3e-4, "{n}");
}

/// Waits until cards say what rectification found.
fn prepared(harness: &mut Harness<'_, App>) {
    until(harness, "the edited scene is prepared", |app| {
        app.state().is_prepared() && app.state().report.as_ref().is_some_and(|report| report.problems.is_some())
    });
}

#[test]
fn objects_of_one_medium_are_linked_until_one_gets_its_own() {
    let mut harness = window("nested-spheres");
    apply(&mut harness, Command::SelectObject(Some("glass ball".into())));
    let water = medium_of(&harness, "water ball");
    let glass = medium_of(&harness, "glass ball");
    apply(
        &mut harness,
        Command::Edit(iorect::app::Edit::Media(iorect::app::MediaEdit::Assign("water ball".into(), glass.clone()))),
    );
    prepared(&mut harness);
    assert!(has_text(&harness, "Linked with water ball"));
    harness.get_by_label("Make its own").click_accesskit();
    harness.run_steps(3);
    let own = medium_of(&harness, "glass ball");
    assert!(own != glass && medium_of(&harness, "water ball") == glass, "{own}");
    assert_eq!(model(&harness, &own), model(&harness, &glass));
    // Two media of one index: nothing is to be seen between them.
    assert!(has_text(&harness, "the surface between them is invisible"));
    for wanted in [glass.clone(), glass.clone()] {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.run_steps(3);
        assert_eq!(medium_of(&harness, "glass ball"), wanted);
    }
    assert_eq!(medium_of(&harness, "water ball"), water);
    assert!(!harness.state().state().document.is_dirty());
}

#[test]
fn a_medium_of_the_catalogue_is_chosen_with_the_keyboard() {
    let mut harness = selected("glass ball");
    let count = harness.state().state().document.description().media.len();
    choose_by_typing(&mut harness, "Medium of glass ball", "sapph");
    assert_eq!(medium_of(&harness, "glass ball"), "sapphire");
    prepared(&mut harness);
    assert_eq!(model(&harness, "sapphire"), Ior::Catalog(catalog::find("sapphire").unwrap()));
    assert_eq!(harness.state().state().document.description().media.len(), count + 1);
    // It is in the scene by now: choosing it again adds nothing.
    apply(&mut harness, Command::SelectObject(Some("water ball".into())));
    prepared(&mut harness);
    choose_by_typing(&mut harness, "Medium of water ball", "sapph");
    assert_eq!(medium_of(&harness, "water ball"), "sapphire");
    assert_eq!(harness.state().state().document.description().media.len(), count + 1);
}

#[test]
fn the_view_follows_the_camera_that_is_edited() {
    let mut harness = window("nested-spheres");
    apply(&mut harness, Command::SelectWorld(WorldPart::Camera));
    harness.run_steps(3);
    let before = harness.state().state().document.description().camera;
    type_into(&mut harness, Role::SpinButton, "Focal length", "100/2");
    let state = harness.state().state();
    let camera = state.document.description().camera;
    assert!((camera.vertical_fov - 26.99).abs() < 0.01, "{}", camera.vertical_fov);
    assert_eq!(state.view.camera, camera);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(harness.state().state().view.camera, before);
}

#[test]
fn a_click_puts_the_focus_where_it_is() {
    let mut harness = window("nested-spheres");
    apply(&mut harness, Command::PickFocus(true));
    apply(&mut harness, Command::Inspect(Some([0.5, 0.5])));
    let state = harness.state().state();
    let camera = state.document.description().camera;
    let focus = camera.focus_distance.expect("a focus");
    assert!(focus > 0.0 && focus < camera.position.distance(camera.target), "in front of the middle: {focus}");
    assert!(state.inspection.is_none() && !state.is_focusing);
}

#[test]
fn an_environment_becomes_a_gradient_and_an_image() {
    let mut harness = window("nested-spheres");
    apply(&mut harness, Command::SelectWorld(WorldPart::Environment));
    harness.run_steps(3);
    harness.get_by_label("Gradient").click();
    harness.run_steps(3);
    let environment = |harness: &Harness<'_, App>| harness.state().state().document.description().environment.clone();
    assert!(matches!(environment(&harness), Environment::Gradient { .. }));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("sky.png");
    image::RgbImage::from_pixel(8, 4, image::Rgb([10, 20, 200])).save(&path).unwrap();
    apply(&mut harness, Command::ReadEnvironment(path));
    until(&mut harness, "the image is there", |app| {
        matches!(app.state().document.description().environment, Environment::Image { .. })
    });
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert!(matches!(environment(&harness), Environment::Gradient { .. }));
    // What is no image is a notice, and the environment stays.
    let path = folder.path().join("no.png");
    std::fs::write(&path, "text").unwrap();
    apply(&mut harness, Command::ReadEnvironment(path));
    until(&mut harness, "it is refused", |app| !app.state().notices.is_empty());
    assert!(matches!(environment(&harness), Environment::Gradient { .. }));
}
