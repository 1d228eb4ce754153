//! Slices, chosen, moved and exported by mouse and by keyboard.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use glam::DVec3;
use iorect::app::{App, Command, ExportKind, Facing, PaneContent, Preset, Settings, SliceView};
use iorect::render::slice::Ink;
use iorect::render::surfaces::medium_color;
use iorect::scene::MediumId;
use iorect::tracking::Mode;

use crate::harness::{apply, choose, every_pane_has_an_image, quick, type_into, until, window_of};

const SLICE: PaneContent = PaneContent::Slice(Mode::Rectified);

/// A slice alone in the window.
fn sliced(scene: &str) -> Harness<'static, App> {
    let mut settings = Settings { pane_count: 1, ..quick() };
    settings.panes[0] = SLICE;
    let mut harness = window_of(scene, settings, [1280.0, 720.0]);
    until(&mut harness, "the slice is cut", every_pane_has_an_image);
    harness
}

fn view(harness: &Harness<'_, App>) -> SliceView {
    harness.state().state().slice_view()
}

const MIDDLE: Pos2 = Pos2::new(640.0, 360.0);

fn hover(harness: &mut Harness<'_, App>, pos: Pos2) {
    harness.event(egui::Event::PointerMoved(pos));
    harness.run_steps(2);
}

fn wheel(harness: &mut Harness<'_, App>, modifiers: Modifiers) {
    let (unit, phase, source) = (egui::MouseWheelUnit::Line, egui::TouchPhase::Move, egui::MouseWheelSource::Wheel);
    let delta = egui::vec2(0.0, 1.0);
    harness.event_modifiers(egui::Event::MouseWheel { unit, delta, phase, modifiers, source }, modifiers);
    harness.run_steps(20);
}

fn drag(harness: &mut Harness<'_, App>, by: egui::Vec2, modifiers: Modifiers) {
    hover(harness, MIDDLE);
    let button =
        |pos, pressed| egui::Event::PointerButton { pos, button: egui::PointerButton::Primary, pressed, modifiers };
    harness.event_modifiers(button(MIDDLE, true), modifiers);
    harness.run_steps(1);
    for step in 1..=4 {
        harness.event_modifiers(egui::Event::PointerMoved(MIDDLE + by * (step as f32 / 4.0)), modifiers);
        harness.run_steps(1);
    }
    harness.event_modifiers(button(MIDDLE + by, false), modifiers);
    harness.run_steps(2);
}

/// Gives a control the focus, and presses a key.
fn press_on(harness: &mut Harness<'_, App>, role: Role, label: &str, key: Key) {
    harness.get_by_role_and_label(role, label).focus();
    harness.run_steps(2);
    harness.key_press(key);
    harness.run_steps(4);
}

#[test]
fn a_slice_is_chosen_by_mouse_and_by_keyboard() {
    let settings = Settings { pane_count: 2, ..quick() };
    let mut harness = window_of("half-submerged", settings, [1280.0, 720.0]);
    choose(&mut harness, &["Pane 1: stack", "slice", "slice: rectified"]);
    assert_eq!(harness.state().state().settings.panes[0], SLICE);

    press_on(&mut harness, Role::Button, "Pane 2: rectified", Key::Enter);
    press_on(&mut harness, Role::Button, "slice", Key::Enter);
    press_on(&mut harness, Role::Button, "slice: naive", Key::Enter);
    assert_eq!(harness.state().state().settings.panes[1], PaneContent::Slice(Mode::Naive));
    until(&mut harness, "both slices are cut", every_pane_has_an_image);
    // No film is wanted any more, and the legends tell the modes apart: only naive leaves doubt.
    assert!(harness.state().state().settings.modes().is_empty());
    let legends: Vec<String> = (harness.query_all_by_label_contains("Legend: "))
        .map(|node| node.accesskit_node())
        .map(|node| node.label().or(node.value()).unwrap_or_default())
        .collect();
    assert_eq!(legends.len(), 2, "{legends:?}");
    assert!(
        legends.iter().all(|legend| legend.contains("water  1.33") && legend.contains("glass  1.5")),
        "{legends:?}"
    );
    let has_doubt = |legend: &&String| legend.contains("striped");
    assert_eq!(legends.iter().filter(has_doubt).count(), 1, "{legends:?}");
}

#[test]
fn the_pointer_moves_the_plane_and_the_picture() {
    let mut harness = sliced("half-submerged");
    let epoch = harness.state().state().epoch();
    let first = view(&harness);
    assert_eq!(first.facing, Facing::Z, "the camera looks along z");
    hover(&mut harness, MIDDLE);
    wheel(&mut harness, Modifiers::NONE);
    let second = view(&harness);
    // Away from the viewer, who is on the side of larger z.
    assert!(second.offset < first.offset, "{second:?}");
    wheel(&mut harness, Modifiers::COMMAND);
    assert!(view(&harness).zoom > 1.0, "{:?}", view(&harness));
    assert_eq!(view(&harness).offset, second.offset);
    let before = view(&harness);
    drag(&mut harness, egui::vec2(60.0, 0.0), Modifiers::NONE);
    let after = view(&harness);
    // The picture follows the pointer: its middle shows what lay to the left.
    assert!(after.pan.x < before.pan.x && (after.pan.y - before.pan.y).abs() < 1e-9, "{before:?} {after:?}");
    assert_eq!(after.offset, before.offset);
    drag(&mut harness, egui::vec2(0.0, -60.0), Modifiers::SHIFT);
    assert!(view(&harness).offset < after.offset);
    assert_eq!(view(&harness).pan, after.pan);
    let camera = harness.state().state().document.description().camera;
    assert_eq!(harness.state().state().view.camera, camera, "the camera stays");
    assert_eq!(harness.state().state().epoch(), epoch, "no film begins anew");
    until(&mut harness, "the moved slice is cut", every_pane_has_an_image);
}

#[test]
fn the_plane_is_moved_by_keyboard() {
    let mut harness = sliced("half-submerged");
    let before = view(&harness).offset;
    press_on(&mut harness, Role::Slider, "Slice at z", Key::ArrowRight);
    assert!(view(&harness).offset > before);
    type_into(&mut harness, Role::SpinButton, "Slice at z", "0.25");
    assert_eq!(view(&harness).offset, 0.25);
    press_on(&mut harness, Role::Button, "Camera", Key::Enter);
    assert_eq!(view(&harness).facing, Facing::Camera);
    press_on(&mut harness, Role::Button, "Y", Key::Space);
    assert_eq!(view(&harness).facing, Facing::Y);
    assert!(!harness.state().state().is_paused, "the key meant the button");
}

#[test]
fn the_plane_goes_through_what_is_wanted() {
    let mut harness = sliced("nested-spheres");
    assert!(harness.get_by_label("Through the selected object").accesskit_node().is_disabled());
    assert!(harness.get_by_label("Through the inspected path").accesskit_node().is_disabled());
    let plan = SliceView { facing: Facing::Y, offset: 0.2, ..view(&harness) };
    apply(&mut harness, Command::SetSlice(plan));
    apply(&mut harness, Command::SelectObject(Some("water ball".into())));
    harness.get_by_label("Through the selected object").click();
    harness.run_steps(3);
    assert!((view(&harness).offset - 1.02).abs() < 1e-4, "{:?}", view(&harness));

    apply(&mut harness, Command::Inspect(Some([0.45, 0.4])));
    until(&mut harness, "the path is followed", |app| {
        app.state().inspection.as_ref().is_some_and(|inspection| inspection.path(Mode::Rectified).is_some())
    });
    harness.get_by_label("Through the inspected path").click();
    harness.run_steps(3);
    let Facing::Path { point, normal } = view(&harness).facing else { panic!("{:?}", view(&harness)) };
    let camera = harness.state().state().view.camera.position;
    assert!((camera - point).normalize().dot(normal).abs() < 1e-6, "the pixel's ray lies in the plane");
    let inspection = harness.state().state().inspection.clone().expect("a pixel is inspected");
    let path = inspection.path(Mode::Rectified).expect("the path is traced");
    assert!(path.vertices.len() > 2);
    for vertex in &path.vertices[..2] {
        // Balls around one point bend a ray within one plane.
        assert!((DVec3::from(vertex.position) - point).dot(normal).abs() < 1e-6);
    }
    // Nothing impossible is taken.
    let before = view(&harness);
    apply(&mut harness, Command::SetSlice(SliceView { offset: f64::NAN, ..before }));
    assert_eq!(view(&harness), before);
}

#[test]
fn a_click_selects_what_lies_there() {
    let mut harness = sliced("nested-spheres");
    let before = harness.state().state().inspection.is_some();
    hover(&mut harness, MIDDLE);
    harness.get_by_label_contains("Legend: ");
    drag(&mut harness, egui::Vec2::ZERO, Modifiers::NONE);
    assert_eq!(harness.state().state().selected.as_deref(), Some("air ball"));
    assert_eq!(harness.state().state().inspection.is_some(), before, "no pixel of the film is meant");
}

#[test]
fn a_slice_is_exported_with_its_legend() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut harness = sliced("half-submerged");
    let film = harness.state().state().film_size();
    let path = folder.path().join("slice.png");
    apply(&mut harness, Command::Export(ExportKind::PanePng, path.clone()));
    until(&mut harness, "the export is reported", |app| {
        app.state().notices.iter().any(|n| n.text.contains("slice.png"))
    });
    let picture = image::open(&path).expect("a picture that can be read").to_rgb8();
    assert!(picture.width() > film[0] && picture.height() > film[1], "the legend is there");
    for color in
        [medium_color(MediumId(2)), medium_color(MediumId(3)), medium_color(MediumId::WORLD), Ink::Line.color()]
    {
        assert!(picture.pixels().any(|pixel| pixel.0 == color), "{color:?} is missing");
    }
}

/// Whatever lies under labels and legend: all else in the pane has the legend's colours, exactly.
#[test]
fn slices_reach_the_screen_with_the_legends_colours() {
    let settings = Settings { panes: Preset::Slices.panes(), resolution_scale: 1.0, ..quick() };
    let description = iorect::formats::open("half-submerged").expect("a built-in scene");
    let mut harness = Harness::builder()
        .with_size([1280.0, 720.0])
        .with_step_dt(1.0 / 60.0)
        .with_render_cursor(false)
        .wgpu()
        .build_eframe(move |cc| App::new(cc, description, Some(settings)).expect("threads can be started"));
    until(&mut harness, "there are images", every_pane_has_an_image);
    let picture = harness.render().expect("software rendering works");
    let folder = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/ui-screenshots");
    std::fs::create_dir_all(&folder).expect("the build folder is writable");
    picture.save(folder.join("slices.png")).expect("the build folder is writable");
    let label = harness.get_by_label_contains("Pane 3: ").rect();
    let legend = (harness.query_all_by_label_contains("Legend: ")).map(|node| node.rect()).collect::<Vec<_>>();
    let known = [MediumId::WORLD, MediumId(2), MediumId(3)].map(medium_color);
    let known = known.into_iter().chain([Ink::Solid, Ink::Light, Ink::Line].map(Ink::color)).collect::<Vec<_>>();
    let mut seen = std::collections::BTreeSet::new();
    for y in (label.bottom() as u32 + 4)..(label.bottom() as u32 + 250) {
        for x in (label.left() as u32 + 4)..(label.left() as u32 + 300) {
            if legend.iter().any(|legend| legend.expand(4.0).contains(Pos2::new(x as f32, y as f32))) {
                continue;
            }
            let [r, g, b, _] = picture.get_pixel(x, y).0;
            assert!(known.contains(&[r, g, b]), "{:?} at {x}, {y}", [r, g, b]);
            seen.insert([r, g, b]);
        }
    }
    assert!(seen.len() >= 4, "{seen:?}");
}
