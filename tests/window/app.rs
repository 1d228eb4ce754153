//! The window, driven without a display: every test runs the whole application, worker threads included, and acts as a person would.

use std::path::PathBuf;
use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::DVec3;
use iorect::app::{
    App, Arrangement, Command, Edit, ExportKind, Manipulation, ObjectEdit, PaneContent, Preset, Settings, Tab, Theme,
};
use iorect::render::surfaces::SurfaceQuantity;
use iorect::scene::camera::Camera;
use iorect::scene::description::{Shape, Transform};
use iorect::tracking::Mode;

use crate::harness::{
    apply, choose, choose_by_typing, drop_files, every_pane_has_an_image, picture_of, quick, type_into, until, window,
    window_of,
};

fn ior(harness: &Harness<'_, App>, medium: &str) -> f64 {
    harness.state().state().document.description().medium(medium).expect("the scene has this medium").ior.ior()
}

#[test]
fn an_ior_is_changed_by_its_slider_and_undone() {
    let mut harness = window("nested-spheres");
    until(&mut harness, "there are images", every_pane_has_an_image);
    let before = ior(&harness, "glass");
    let epoch = harness.state().state().epoch();

    harness.get_by_role_and_label(Role::Slider, "IOR of glass").set_value_accesskit(1.7);
    harness.run_steps(3);
    assert!((ior(&harness, "glass") - 1.7).abs() < 1e-9);
    assert!(harness.state().state().epoch() > epoch, "the images are out of date");
    assert!(harness.state().state().document.is_dirty());
    until(&mut harness, "the edited scene is prepared and shown", |app| {
        let report = app.state().report.as_ref();
        let is_prepared = report.is_some_and(|r| r.prepared.scene.media.iter().any(|m| (m.ior() - 1.7).abs() < 1e-9));
        is_prepared && every_pane_has_an_image(app)
    });

    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(ior(&harness, "glass"), before);
    assert!(!harness.state().state().document.is_dirty());
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    assert!((ior(&harness, "glass") - 1.7).abs() < 1e-9);
}

#[test]
fn an_ior_is_changed_by_typing() {
    let mut harness = window("nested-spheres");
    type_into(&mut harness, Role::TextInput, "IOR of glass", "2.417");
    assert_eq!(ior(&harness, "glass"), 2.417);
    // Digits that were typed must not have changed the number of panes.
    assert_eq!(harness.state().state().settings.pane_count, quick().pane_count);
}

#[test]
fn a_preset_comes_from_the_catalogue() {
    let mut harness = window("nested-spheres");
    apply(&mut harness, Command::SelectObject(Some("glass ball".into())));
    choose_by_typing(&mut harness, "Catalogue for glass", "diam");
    assert!((ior(&harness, "glass") - 2.4175).abs() < 2e-3);
}

#[test]
fn panes_and_modes_are_switched() {
    let mut harness = window("camera-in-water");
    for (key, count) in [(Key::Num1, 1), (Key::Num4, 4), (Key::Num2, 2)] {
        harness.key_press(key);
        harness.run_steps(3);
        assert_eq!(harness.state().state().settings.pane_count, count);
    }
    choose(&mut harness, &["Pane 2: rectified", "reference"]);
    assert_eq!(harness.state().state().settings.panes[1], PaneContent::Mode(Mode::Reference));
    until(&mut harness, "both panes have images", every_pane_has_an_image);
    assert!(harness.query_by_label("Pane 2: reference").is_some());
}

#[test]
fn a_difference_is_shown_and_wiped() {
    let settings = Settings { pane_count: 2, ..quick() };
    let mut harness = window_of("camera-in-water", settings, [1280.0, 720.0]);
    apply(&mut harness, Command::SetPaneContent(1, PaneContent::Difference(Mode::Naive, Mode::Rectified)));
    harness.key_press(Key::W);
    harness.run_steps(3);
    assert_eq!(harness.state().state().settings.arrangement, Arrangement::Wipe);
    // Panes of a wipe have the whole room.
    let wipe_width = harness.state().state().film_size()[0];
    harness.key_press(Key::W);
    harness.run_steps(3);
    // Tiles show a part of the same films.
    assert_eq!(harness.state().state().film_size()[0], wipe_width);
    until(&mut harness, "the difference is there", every_pane_has_an_image);
}

#[test]
fn a_bad_file_is_a_notice_and_the_scene_stays() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("broken.toml");
    std::fs::write(&path, "name = \"broken\"\n[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\nflavour = 3\n")
        .unwrap();
    let mut harness = window("nested-spheres");
    until(&mut harness, "there are images", every_pane_has_an_image);

    drop_files(&mut harness, &[&path]);
    until(&mut harness, "the notice is there", |app| !app.state().notices.is_empty());
    let text = harness.state().state().notices[0].text.clone();
    assert!(text.contains("broken.toml:5") && text.contains("flavour"), "{text}");
    assert_eq!(harness.state().state().document.description().name, "Nested spheres");
    let samples = harness.state().samples_shown(0);
    assert!(samples > 0, "the old images are still there");
    until(&mut harness, "the old scene goes on", move |app| app.samples_shown(0) > samples);

    harness.get_by_label("Dismiss").click();
    harness.run_steps(3);
    assert!(harness.state().state().notices.is_empty());
}

#[test]
fn an_impossible_ior_is_refused_in_words() {
    let mut harness = window("nested-spheres");
    let medium = iorect::app::MediumRef::Named("glass".into());
    apply(&mut harness, Command::set_ior(medium, iorect::optics::Ior::Constant(-1.0)));
    assert!(harness.state().state().notices.iter().any(|notice| notice.text.contains("greater than 0")));
    assert!(ior(&harness, "glass") > 1.0 && !harness.state().state().document.is_dirty());
}

#[test]
fn a_scene_that_can_be_read_but_not_shown_gives_way_to_the_last_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("blind.toml");
    std::fs::write(&path, "name = \"Blind\"\n[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 1]\n").unwrap();
    let mut harness = window("nested-spheres");
    until(&mut harness, "there are images", every_pane_has_an_image);
    apply(&mut harness, Command::Open(path.clone()));
    until(&mut harness, "the notice is there", |app| app.state().notices.iter().any(|n| n.text.contains("direction")));
    until(&mut harness, "the old scene is shown", |app| {
        app.state().document.description().name == "Nested spheres" && every_pane_has_an_image(app)
    });
}

#[test]
fn unsaved_changes_are_asked_about_before_another_scene_is_opened() {
    let mut harness = window("nested-spheres");
    harness.get_by_role_and_label(Role::Slider, "IOR of glass").set_value_accesskit(1.61);
    harness.run_steps(3);
    apply(&mut harness, Command::Open("plain-glass".into()));
    harness.get_by_label("Stay").click();
    harness.run_steps(3);
    assert!((ior(&harness, "glass") - 1.61).abs() < 1e-9);
    apply(&mut harness, Command::Open("plain-glass".into()));
    harness.get_by_label("Open without saving").click();
    until(&mut harness, "the other scene is open", |app| app.state().document.description().name != "Nested spheres");
}

#[test]
fn pictures_are_exported() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut harness = window("camera-in-water");
    until(&mut harness, "there are images", every_pane_has_an_image);
    let film = harness.state().state().film_size();
    for (kind, name) in
        [(ExportKind::PanePng, "pane.png"), (ExportKind::PaneExr, "pane.exr"), (ExportKind::AllPanesPng, "all.png")]
    {
        let path = folder.path().join(name);
        apply(&mut harness, Command::Export(kind, path.clone()));
        until(&mut harness, "the export is reported", |app| {
            app.state().notices.iter().any(|notice| notice.text.contains(name))
        });
        let notice = harness.state().state().notices.iter().find(|notice| notice.text.contains(name)).unwrap();
        assert!(!notice.is_error, "{}", notice.text);
        let picture = image::open(&path).expect("a picture that can be read").to_rgb32f();
        if kind == ExportKind::AllPanesPng {
            assert!(picture.width() > 2 * film[0]);
        } else {
            assert_eq!([picture.width(), picture.height()], film);
        }
        assert!(has_contrast(picture.pixels().map(|p| p.0[1])), "{name} is blank");
    }
    // A folder that does not exist is an error in words, and nothing is written.
    let nowhere = folder.path().join("no/such/folder/x.png");
    apply(&mut harness, Command::Export(ExportKind::PanePng, nowhere.clone()));
    until(&mut harness, "the failure is reported", |app| app.state().notices.iter().any(|notice| notice.is_error));
    assert!(!nowhere.exists());
}

fn has_contrast(values: impl Iterator<Item = f32>) -> bool {
    let (least, most) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    most - least > 0.1
}

#[test]
fn an_edited_scene_is_saved_and_read_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mine.toml");
    let mut harness = window("nested-spheres");
    harness.get_by_role_and_label(Role::Slider, "IOR of glass").set_value_accesskit(1.61);
    harness.run_steps(3);
    assert!(harness.state().state().document.is_dirty());
    apply(&mut harness, Command::SaveAs(path.clone()));
    until(&mut harness, "it is saved", |app| !app.state().document.is_dirty());
    let saved = iorect::formats::file(&path).expect("a scene that can be read");
    assert!((saved.medium("glass").unwrap().ior.ior() - 1.61).abs() < 1e-9);
    assert_eq!(harness.state().state().settings.recent[0], path.display().to_string());
}

#[test]
fn a_built_in_scene_is_opened_from_the_gallery() {
    let mut harness = window("nested-spheres");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::B);
    harness.run_steps(3);
    harness.get_by_label("camera-in-water").click();
    until(&mut harness, "it is open", |app| app.state().document.description().name != "Nested spheres");
    assert!(!harness.state().state().windows.gallery);
    until(&mut harness, "it is shown", every_pane_has_an_image);
}

#[test]
fn shortcuts_do_what_the_list_says() {
    let mut harness = window("nested-spheres");
    let press = |harness: &mut Harness<'_, App>, key| {
        harness.key_press(key);
        harness.run_steps(3);
    };
    press(&mut harness, Key::Space);
    assert!(harness.state().state().is_paused);
    press(&mut harness, Key::Space);
    assert!(!harness.state().state().is_paused);
    press(&mut harness, Key::CloseBracket);
    assert_eq!(harness.state().state().settings.display.exposure, 0.25);
    press(&mut harness, Key::F1);
    assert!(!harness.state().state().settings.show_scene_panel);
    assert!(harness.query_by_role_and_label(Role::Slider, "IOR of glass").is_none());
    press(&mut harness, Key::F1);
    press(&mut harness, Key::Questionmark);
    assert!(harness.query_by_label("Pause or go on").is_some());
    press(&mut harness, Key::Escape);
    assert!(harness.query_by_label("Pause or go on").is_none());
}

#[test]
fn a_click_inspects_a_path_and_shows_what_the_stack_gets_wrong() {
    let settings = Settings { pane_count: 1, ..quick() };
    let mut harness = window_of("camera-in-water", settings, [1280.0, 720.0]);
    until(&mut harness, "there are images", every_pane_has_an_image);
    apply(&mut harness, Command::ShowTab(Tab::Inspector));
    // The middle of the picture is the ball, seen by a camera inside the water.
    let picture = harness.get_by_label("Pane 1: stack").rect();
    let place = picture.min + egui::vec2(350.0, 330.0);
    harness.hover_at(place);
    harness.drag_at(place);
    harness.drop_at(place);
    harness.run_steps(3);
    until(&mut harness, "its path has been followed", |app| {
        app.state().inspection.as_ref().is_some_and(|inspection| inspection.path(Mode::Stack).is_some())
    });
    let inspection = harness.state().state().inspection.as_ref().expect("a pixel is inspected");
    let path = inspection.path(Mode::Stack).expect("its path has been traced");
    assert_eq!(path.mode, Mode::Stack);
    assert!(!path.vertices.is_empty());
    assert!(harness.query_all_by_label_contains("→").next().is_some(), "the media of a vertex are shown");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.state().state().inspection.is_none());
}

#[test]
fn dragging_orbits_and_home_returns() {
    let settings = Settings { pane_count: 1, ..quick() };
    let mut harness = window_of("nested-spheres", settings, [1280.0, 720.0]);
    let before = harness.state().state().view.camera;
    let start = egui::pos2(640.0, 360.0);
    harness.drag_at(start);
    harness.run_steps(2);
    for step in 1..=5 {
        harness.hover_at(start + egui::vec2(20.0, 4.0) * step as f32);
        harness.run_steps(1);
    }
    harness.drop_at(start + egui::vec2(100.0, 20.0));
    harness.run_steps(2);
    let after = harness.state().state().view.camera;
    assert!(after.position.distance(before.position) > 0.1);
    assert!((after.position.distance(after.target) / before.position.distance(before.target) - 1.0).abs() < 1e-9);
    assert!(!harness.state().state().document.is_dirty(), "looking around is no edit");
    harness.key_press(Key::Home);
    harness.run_steps(3);
    assert_eq!(harness.state().state().view.camera, before);
}

/// The transform of an object, by name.
fn transform_of(harness: &Harness<'_, App>, name: &str) -> Transform {
    let description = harness.state().state().document.description();
    let refractor = description.objects.refractors().iter().find(|r| r.name == name);
    refractor.expect("the scene has this refractor").transform
}

/// Where a place of the scene is on the screen, in the only pane.
fn on_screen(harness: &Harness<'_, App>, picture: egui::Rect, place: DVec3) -> egui::Pos2 {
    let [width, height] = harness.state().state().film_size().map(f64::from);
    let camera = Camera::new(&harness.state().state().film_camera()).expect("the camera is fine");
    let to = place - camera.position;
    let half = to.dot(camera.forward) * camera.tan_half_fov;
    let (x, y) = (to.dot(camera.right) / (half * width / height), to.dot(camera.up) / half);
    picture.lerp_inside(egui::vec2((0.5 + 0.5 * x) as f32, (0.5 - 0.5 * y) as f32))
}

/// Waits until the scene as it is now has been looked at: the strip of problems has come or gone, and nothing moves.
fn settle(harness: &mut Harness<'_, App>) {
    until(harness, "the edited scene is prepared and checked", |app| {
        app.state().report.as_ref().is_some_and(|report| {
            report.problems.is_some() && Arc::ptr_eq(&report.prepared.description, app.state().document.description())
        })
    });
}

fn drag(harness: &mut Harness<'_, App>, from: egui::Pos2, by: egui::Vec2) {
    harness.hover_at(from);
    harness.run_steps(2);
    harness.drag_at(from);
    harness.run_steps(2);
    for step in 1..=8 {
        harness.hover_at(from + by * (step as f32 / 8.0));
        harness.run_steps(1);
    }
}

fn drop_here(harness: &mut Harness<'_, App>, at: egui::Pos2) {
    harness.drop_at(at);
    harness.run_steps(3);
}

#[test]
fn a_handle_moves_an_object_in_one_undoable_step_and_elsewhere_one_orbits() {
    let settings = Settings { pane_count: 1, ..quick() };
    let mut harness = window_of("nested-spheres", settings, [1280.0, 720.0]);
    apply(&mut harness, Command::SelectObject(Some("water ball".into())));
    let before = harness.state().state().document.description().clone();
    let start = transform_of(&harness, "water ball");
    let picture = picture_of(&harness);
    let Shape::Sphere { center, .. } = before.objects.refractors()[1].shape else { panic!("the scene has changed") };
    // The arrow for y goes up from the middle; it is dragged up by 50 points.
    let middle = on_screen(&harness, picture, center);
    let (arrow, by) = (middle - egui::vec2(0.0, 45.0), egui::vec2(0.0, -50.0));
    let camera = harness.state().state().view.camera;
    drag(&mut harness, arrow, by);
    let moved = transform_of(&harness, "water ball");
    assert!(moved.translate.y > 0.05 && moved.translate.x == start.translate.x, "{moved:?}");
    assert_eq!((moved.rotate, moved.scale), (start.rotate, start.scale));
    // What was under the pointer stays under it.
    let there = on_screen(&harness, picture, center + moved.translate - start.translate);
    assert!((there - (middle + by)).length() < 2.5, "{there:?} for {:?}", middle + by);
    assert_eq!(harness.state().state().view.camera, camera, "the camera stands still");
    drop_here(&mut harness, arrow + by);
    assert_eq!(harness.state().state().document.undo_label(), Some("moving water ball"));
    until(&mut harness, "the moved scene is prepared", move |app| {
        app.state().report.as_ref().is_some_and(|r| r.prepared.description.objects.refractors()[1].transform == moved)
    });
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(**harness.state().state().document.description(), *before, "one step back, exactly");
    assert!(harness.state().state().document.undo_label().is_none());
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    assert_eq!(transform_of(&harness, "water ball"), moved);

    settle(&mut harness);
    let picture = picture_of(&harness);
    // Escape gives a drag up, and the rest of the movement does nothing.
    let middle = on_screen(&harness, picture, center + moved.translate);
    let arrow = middle - egui::vec2(0.0, 45.0);
    drag(&mut harness, arrow, by);
    assert_ne!(transform_of(&harness, "water ball"), moved);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert_eq!(transform_of(&harness, "water ball"), moved);
    harness.hover_at(arrow + egui::vec2(0.0, -90.0));
    harness.run_steps(2);
    drop_here(&mut harness, arrow + egui::vec2(0.0, -90.0));
    assert_eq!(transform_of(&harness, "water ball"), moved);
    assert_eq!(harness.state().state().view.camera, camera);

    // Where there is no handle, the same gesture orbits.
    let beside = picture.left_bottom() + egui::vec2(80.0, -40.0);
    drag(&mut harness, beside, egui::vec2(60.0, 0.0));
    drop_here(&mut harness, beside + egui::vec2(60.0, 0.0));
    assert_ne!(harness.state().state().view.camera, camera);
    assert_eq!(transform_of(&harness, "water ball"), moved);
}

#[test]
fn rotating_and_scaling_keep_the_middle_where_it_is() {
    let settings = Settings { pane_count: 1, ..quick() };
    let mut harness = window_of("iced-water", settings, [1280.0, 720.0]);
    apply(&mut harness, Command::SelectObject(Some("ice cube 1".into())));
    let shape = {
        let description = harness.state().state().document.description();
        description.objects.refractors().iter().find(|r| r.name == "ice cube 1").expect("there is ice").shape.clone()
    };
    let (min, max) = shape.bounds();
    let pivot = (min + max) / 2.0;
    let start = transform_of(&harness, "ice cube 1");
    let place = start.matrix().transform_point3(pivot);
    let picture = picture_of(&harness);
    let middle = on_screen(&harness, picture, place);
    // The outer ring, 86 points from the middle: a quarter turn about the view's axis.
    harness.key_press(Key::T);
    harness.run_steps(2);
    let ring = middle + egui::vec2(86.5, 0.0);
    drag(&mut harness, ring, egui::vec2(-20.0, 60.0));
    drop_here(&mut harness, ring + egui::vec2(-20.0, 60.0));
    let turned = transform_of(&harness, "ice cube 1");
    assert_ne!(turned.rotate, start.rotate);
    assert_eq!(turned.scale, start.scale);
    assert!(turned.matrix().transform_point3(pivot).distance(place) < 1e-9);
    let turn = turned.matrix().matrix3 * start.matrix().matrix3.inverse();
    let angle = ((turn.x_axis.x + turn.y_axis.y + turn.z_axis.z - 1.0) / 2.0).acos().to_degrees();
    let wanted = 60.0_f64.atan2(66.5).to_degrees();
    assert!((angle - wanted).abs() < 2.0, "turned by {angle}° for {wanted}° of the pointer");

    settle(&mut harness);
    let ring = on_screen(&harness, picture_of(&harness), place) + egui::vec2(86.5, 0.0);
    harness.key_press(Key::S);
    harness.run_steps(2);
    drag(&mut harness, ring, egui::vec2(86.5, 0.0));
    drop_here(&mut harness, ring + egui::vec2(86.5, 0.0));
    let scaled = transform_of(&harness, "ice cube 1");
    assert!((scaled.scale / turned.scale - DVec3::splat(2.0)).abs().max_element() < 0.03, "{:?}", scaled.scale);
    assert!(scaled.matrix().transform_point3(pivot).distance(place) < 1e-9);
    // The same key again puts the handles away: the gesture orbits.
    harness.key_press(Key::S);
    harness.run_steps(2);
    drag(&mut harness, ring, egui::vec2(40.0, 0.0));
    drop_here(&mut harness, ring + egui::vec2(40.0, 0.0));
    assert_eq!(transform_of(&harness, "ice cube 1"), scaled);
}

#[test]
fn an_object_is_edited_by_typing() {
    let mut harness = window("nested-spheres");
    apply(&mut harness, Command::SelectObject(Some("water ball".into())));
    let start = transform_of(&harness, "water ball");
    let type_number = |harness: &mut Harness<'_, App>, label: &str, text: &str| {
        settle(harness);
        type_into(harness, Role::SpinButton, label, text);
    };
    type_number(&mut harness, "Move water ball along x", "0.25");
    type_number(&mut harness, "Rotate water ball along y", "30");
    type_number(&mut harness, "Scale water ball", "0.5");
    type_number(&mut harness, "Priority of water ball", "3");
    let now = transform_of(&harness, "water ball");
    assert_eq!((now.rotate.y, now.scale), (30.0, DVec3::splat(0.5)));
    let center = |t: Transform| match harness.state().state().document.description().objects.refractors()[1].shape {
        Shape::Sphere { center, .. } => t.matrix().transform_point3(center),
        _ => panic!("the scene has changed"),
    };
    assert!((center(now) - center(start)).distance(DVec3::X * 0.25) < 1e-12);
    assert_eq!(harness.state().state().document.description().objects.refractors()[1].refractor().unwrap().priority, 3);
    // A scale of 0 is refused in words.
    type_number(&mut harness, "Scale water ball", "0");
    assert!(harness.state().state().notices.iter().any(|n| n.text.contains("must not be 0")));
    assert_eq!(transform_of(&harness, "water ball"), now);
    apply(&mut harness, Command::DismissNotice(0));
    // Four edits, four steps.
    for _ in 0..4 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.run_steps(2);
    }
    assert!(!harness.state().state().document.is_dirty());
    assert_eq!(transform_of(&harness, "water ball"), start);
}

#[test]
fn an_object_is_picked_hidden_framed_and_found_again() {
    let settings = Settings { pane_count: 1, ..quick() };
    let mut harness = window_of("nested-spheres", settings, [1280.0, 720.0]);
    until(&mut harness, "there are images", every_pane_has_an_image);
    let at = picture_of(&harness).center();
    let selected = |harness: &Harness<'_, App>| harness.state().state().selected.clone().unwrap_or_default();
    let mut seen = Vec::new();
    for _ in 0..4 {
        harness.event_modifiers(egui::Event::PointerMoved(at), Modifiers::COMMAND);
        for pressed in [true, false] {
            let button = egui::Event::PointerButton {
                pos: at,
                button: egui::PointerButton::Primary,
                pressed,
                modifiers: Modifiers::COMMAND,
            };
            harness.event_modifiers(button, Modifiers::COMMAND);
            harness.run_steps(1);
        }
        harness.run_steps(30);
        seen.push(selected(&harness));
    }
    assert_eq!(seen, ["glass ball", "water ball", "air ball", "plank 4"]);
    assert!(harness.state().state().inspection.is_none(), "selecting is not inspecting");

    apply(&mut harness, Command::SelectObject(Some("air ball".into())));
    let before = harness.state().state().view.camera;
    harness.key_press(Key::F);
    harness.run_steps(3);
    let framed = harness.state().state().view.camera;
    assert!(framed.position.distance(framed.target) < 0.9 * before.position.distance(before.target));
    let direction = |c: iorect::scene::description::CameraDescription| (c.target - c.position).normalize();
    assert!(direction(framed).distance(direction(before)) < 1e-12, "the view keeps its direction");
    harness.key_press(Key::Backspace);
    harness.run_steps(3);
    assert_eq!(harness.state().state().view.camera, before);

    harness.key_press(Key::V);
    harness.run_steps(3);
    assert!(!harness.state().state().document.description().objects.refractors()[2].visible);
    until(&mut harness, "it is gone", |app| {
        let report = app.state().report.as_ref();
        report.is_some_and(|r| r.prepared.scene.geometry.sphere_count() == 2) && every_pane_has_an_image(app)
    });
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert!(!harness.state().state().document.is_dirty());
}

/// A block of water and a ball of glass, half in it, of equal priority.
const TIE: &str = r#"
name = "Tie"
[camera]
position = [0, 3, 12]
target = [0, 0, 0]
[environment]
color = [1, 1, 1]
[[medium]]
name = "water"
ior = 1.333
[[medium]]
name = "glass"
ior = 1.5
[[refractor]]
name = "block"
medium = "water"
shape = { box = { min = [-3, -3, -3], max = [3, 0, 3] } }
[[refractor]]
name = "ball"
medium = "glass"
shape = { icosphere = { center = [2, 0, 0], radius = 0.5, subdivisions = 3 } }
"#;

#[test]
fn a_click_on_a_problem_shows_its_place_and_a_tie_is_fixed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("tie.toml");
    std::fs::write(&path, TIE).unwrap();
    let mut harness = window_of(path.to_str().expect("a plain path"), quick(), [1280.0, 720.0]);
    let before = harness.state().state().view.camera;
    let has_tie = |app: &App| app.state().problems().iter().any(|problem| problem.kind == "overlap_tie");
    assert!(has_tie(harness.state()), "{:?}", harness.state().state().problems());
    let all: Vec<_> = harness.query_all_by_label("Show").collect();
    all[0].click();
    drop(all);
    harness.run_steps(3);
    let after = harness.state().state().view.camera;
    assert_eq!(harness.state().state().selected.as_deref(), Some("block"));
    // Both are where the lower half of the ball is.
    assert!(after.target.distance(DVec3::new(2.0, -0.25, 0.0)) < 0.01, "{:?}", after.target);
    assert!(after.position.distance(after.target) < 4.0 && after.vertical_fov == before.vertical_fov);
    harness.key_press(Key::Backspace);
    harness.run_steps(3);
    assert_eq!(harness.state().state().view.camera, before);

    harness.get_by_label("Fix").click();
    harness.run_steps(3);
    let priorities: Vec<i32> =
        harness.state().state().document.description().objects.refractor_roles().map(|r| r.priority).collect();
    assert_eq!(priorities, [0, 1], "the smaller volume wins for certain");
    until(&mut harness, "the tie is no problem any more", move |app| !has_tie(app));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    until(&mut harness, "it is one again", move |app| has_tie(app));
}

/// A ball of glass over a pool.
const POOL: &str = r#"
name = "Pool"
[camera]
position = [0.3, 2.2, 12]
target = [0, -0.3, 0]
vertical_fov = 34
[environment]
gradient = { zenith = [0.4, 0.6, 1.0], horizon = [1.0, 0.9, 0.8], nadir = [0.5, 0.3, 0.2] }
[[medium]]
name = "water"
ior = 1.333
absorption = [0.1, 0.04, 0.02]
[[medium]]
name = "glass"
ior = 1.5
[[refractor]]
name = "pool"
medium = "water"
shape = { box = { min = [-3, -3, -3], max = [3, 0, 3] } }
[[refractor]]
name = "ball"
medium = "glass"
priority = 1
shape = { sphere = { center = [0, 0, 0], radius = 1 } }
[[solid]]
name = "floor"
shape = { quad = { center = [0, -3.5, 0], edge_u = [0, 0, 40], edge_v = [40, 0, 0] } }
checker = { a = [0.8, 0.8, 0.8], b = [0.2, 0.2, 0.3], size = 1.0 }
"#;

/// One drag from the air through the surface to the bottom, looked at on the way: the patches are right at every place, and one exterior
/// per object is wrong as long as the ball is in two media at once, and only then.
#[test]
fn a_ball_dragged_through_the_surface_of_water_stays_right() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("pool.toml");
    std::fs::write(&path, POOL).unwrap();
    let mut settings = quick();
    settings.panes = Preset::BothRectified.panes();
    settings.panes[2] = PaneContent::Mode(Mode::Reference);
    let mut harness = window_of(path.to_str().expect("a plain path"), settings, [1280.0, 720.0]);
    // One sample of every mode, taken with the same random numbers; the scene as it was read has more already.
    apply(&mut harness, Command::SetSampleLimit(Some(1)));
    apply(&mut harness, Command::SelectObject(Some("ball".into())));
    apply(&mut harness, Command::BeginDrag);
    // (height of the ball's middle, whether it is in water and air at once)
    let steps = [
        (1.5, false),
        (0.9, true),
        (0.4, true),
        (0.05, true),
        (-0.5, true),
        (-0.95, true),
        (-1.2, false),
        (-1.95, false),
    ];
    for (y, is_halfway) in steps {
        let transform = Transform { translate: DVec3::Y * y, ..Transform::IDENTITY };
        apply(
            &mut harness,
            Command::Drag(Edit::Object("ball".into(), ObjectEdit::Transform(Manipulation::Move, transform))),
        );
        let modes = [Mode::RectifiedObject, Mode::Rectified, Mode::Reference];
        until(&mut harness, "the dragged ball is shown", |app| {
            modes
                .into_iter()
                .all(|mode| app.film(mode).is_some_and(|film| film.epoch == app.state().epoch() && !film.is_preview()))
        });
        let [object, patch, reference] = modes.map(|mode| harness.state().film(mode).expect("it has just been there"));
        let differing =
            |film: &iorect::session::Snapshot| film.rgb.iter().zip(&reference.rgb).filter(|(a, b)| a != b).count();
        let pixels = reference.rgb.len();
        assert_eq!([object.samples, patch.samples, reference.samples], [1; 3]);
        // Rays within rounding of where the surfaces cross may go either way.
        assert!(differing(&patch) * 1000 <= pixels, "at {y}: {} of {pixels} pixels differ", differing(&patch));
        assert_eq!(patch.events.inconsistent, 0, "at {y}");
        let share = differing(&object) as f64 / pixels as f64;
        if is_halfway {
            assert!(
                share > 2e-4 && object.events.inconsistent > 0,
                "at {y} one exterior per object cannot be right: {share}"
            );
        } else {
            assert!(share == 0.0 && object.events.inconsistent == 0, "at {y} one exterior is enough: {share}");
        }
    }
    apply(&mut harness, Command::EndDrag);
    // All of it was one step.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert!(!harness.state().state().document.is_dirty());
}

#[test]
fn surfaces_are_painted_with_a_legend_and_exported_with_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = Settings { pane_count: 1, ..quick() };
    let mut harness = window_of("half-submerged", settings, [1280.0, 720.0]);
    until(&mut harness, "there are images", every_pane_has_an_image);
    let epoch = harness.state().state().epoch();
    choose(&mut harness, &["Pane 1: stack", "surfaces", "outside medium"]);
    assert_eq!(harness.state().state().settings.panes[0], PaneContent::Surfaces(SurfaceQuantity::Outside));
    until(&mut harness, "the surfaces are painted", every_pane_has_an_image);
    assert_eq!(harness.state().state().epoch(), epoch, "it is the same picture");
    let film = harness.state().state().film_size();
    for (kind, name) in [(ExportKind::PanePng, "pane.png"), (ExportKind::AllPanesPng, "all.png")] {
        let path = folder.path().join(name);
        apply(&mut harness, Command::Export(kind, path.clone()));
        until(&mut harness, "the export is reported", |app| app.state().notices.iter().any(|n| n.text.contains(name)));
        let picture = image::open(&path).expect("a picture that can be read").to_rgb8();
        assert!(picture.width() > film[0] && picture.height() > film[1], "the legend is there");
        // The colours of water and of the world, in the picture or in its legend, as they are.
        for color in [iorect::render::surfaces::COLORS[0], iorect::render::surfaces::WORLD_COLOR] {
            assert!(picture.pixels().any(|pixel| pixel.0 == color), "{name} lacks {color:?}");
        }
    }
    let exr = folder.path().join("pane.exr");
    apply(&mut harness, Command::Export(ExportKind::PaneExr, exr.clone()));
    until(&mut harness, "the refusal is said", |app| {
        app.state().notices.iter().any(|n| n.text.contains("no radiance"))
    });
    assert!(!exr.exists());
    // Beside a film, choosing another quantity leaves the film as it is.
    apply(&mut harness, Command::SetPaneCount(2));
    until(&mut harness, "both panes have images", every_pane_has_an_image);
    let epoch = harness.state().state().epoch();
    apply(&mut harness, Command::SetPaneContent(0, PaneContent::Surfaces(SurfaceQuantity::Class)));
    until(&mut harness, "classes are painted", every_pane_has_an_image);
    assert_eq!(harness.state().state().epoch(), epoch);
}

#[test]
fn everything_has_a_name_and_is_inside_the_window() {
    for size in [[1280.0, 720.0], [900.0, 600.0], [500.0, 340.0]] {
        let mut harness = window_of("iced-water", quick(), size);
        for tab in [Tab::Render, Tab::Rectification, Tab::Inspector, Tab::Measure] {
            // A tab brings its panel with it where there is room.
            apply(&mut harness, Command::ShowTab(tab));
            harness.check_accessibility();
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, size.into());
            for pane in 1..=4 {
                let label = harness.get_by_label_contains(&format!("Pane {pane}: ")).rect();
                assert!(screen.contains_rect(label), "the label of pane {pane} is cut off at {size:?}: {label:?}");
            }
            for menu in ["File", "Edit", "View", "Render", "Help"] {
                let mut all = harness.query_all_by_label(menu);
                assert!(all.any(|node| screen.contains_rect(node.rect())), "menu {menu} is cut off at {size:?}");
            }
        }
    }
}

#[test]
fn the_window_is_drawn_in_both_themes() {
    for (theme, name) in [(Theme::Dark, "dark"), (Theme::Light, "light")] {
        let settings = Settings { theme, ..quick() };
        let description = iorect::formats::open("camera-in-water").expect("a built-in scene");
        let mut harness = Harness::builder()
            .with_size([1280.0, 720.0])
            .with_step_dt(1.0 / 60.0)
            .with_render_cursor(false)
            .wgpu()
            .build_eframe(move |cc| App::new(cc, description, Some(settings)).expect("threads can be started"));
        until(&mut harness, "there are images", every_pane_has_an_image);
        let picture = harness.render().expect("software rendering works");
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/ui-screenshots");
        std::fs::create_dir_all(&folder).expect("the build folder is writable");
        picture.save(folder.join(format!("headless-{name}.png"))).expect("the build folder is writable");
        let green = |x: u32, y: u32| f32::from(picture.get_pixel(x, y).0[1]) / 255.0;
        let panel = green(4, 400);
        assert_eq!(theme == Theme::Dark, panel < 0.5, "the panel has the theme's brightness");
        let middle = (420..600).flat_map(|x| (150..300).map(move |y| (x, y)));
        assert!(has_contrast(middle.map(|(x, y)| green(x, y))), "the first pane is blank");
    }
}
