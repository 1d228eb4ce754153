//! The inspected path in the pictures: it is drawn, compared, kept, pointed out and exported.

use egui::accesskit::Role;
use egui::{Key, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use iorect::app::{App, Command, ExportKind, MediumRef, ObjectEdit, PaneContent, Settings, Tab};
use iorect::optics::Ior;
use iorect::tracking::Mode;
use iorect::transport::inspect::Follow;

use crate::harness::{
    apply, click_at, every_pane_has_an_image, has_notice, painted, picture_of, quick, until, window_of,
};

/// A window with two panes, stack and rectified, and the Inspector.
fn inspector(scene: &str) -> Harness<'static, App> {
    let settings = Settings { pane_count: 2, ..quick() };
    let mut harness = window_of(scene, settings, [1280.0, 720.0]);
    apply(&mut harness, Command::SetPaneContent(0, PaneContent::Mode(Mode::Stack)));
    apply(&mut harness, Command::SetPaneContent(1, PaneContent::Mode(Mode::Rectified)));
    apply(&mut harness, Command::ShowTab(Tab::Inspector));
    harness
}

/// Clicks the first pane at a point in [0, 1]² of it, and waits for the path.
fn click(harness: &mut Harness<'_, App>, [x, y]: [f32; 2]) {
    let picture = picture_of(harness);
    let place = picture.min + picture.size() * egui::vec2(x, y);
    click_at(harness, place);
    wait(harness);
}

fn wait(harness: &mut Harness<'_, App>) {
    harness.run_steps(3);
    until(harness, "the path is followed as it is now", |app| {
        let state = app.state();
        let traced = state.inspection.as_ref().and_then(|inspection| inspection.traced.as_ref());
        state.path_question().is_some() && traced.map(|traced| &traced.question) == state.path_question().as_ref()
    });
}

fn parted_vertex(harness: &Harness<'_, App>) -> Option<usize> {
    let traced = harness.state().state().inspection.as_ref()?.traced.clone()?;
    traced.parting.as_ref().map(|parting| parting.vertex)
}

#[test]
fn a_click_says_where_and_why_the_stack_is_wrong() {
    let mut harness = inspector("camera-in-water");
    // The ball, seen from inside the water.
    click(&mut harness, [0.47, 0.55]);
    assert_eq!(parted_vertex(&harness), Some(0));
    harness.get_by_label_contains("stack took the world (IOR 1) outside ball; it is water");
    harness.get_by_label_contains("The path starts inside pool water, which stack does not know.");
    // Against nothing there is nothing to say, and the pane of the mode itself has nothing to compare.
    apply(&mut harness, Command::SetActivePane(1));
    wait(&mut harness);
    assert_eq!(parted_vertex(&harness), None);
    assert!(harness.query_by_label_contains("The path starts inside").is_none());
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.state().state().inspection.is_none());
}

#[test]
fn the_pixel_stays_through_edits_and_goes_with_the_scene() {
    let mut harness = inspector("nested-spheres");
    click(&mut harness, [0.5, 0.5]);
    let point = harness.state().state().inspection.as_ref().unwrap().point;
    let edits = [
        Command::set_ior(MediumRef::Named("glass".into()), Ior::Constant(1.7)),
        Command::SetPaneContent(0, PaneContent::Mode(Mode::Naive)),
        Command::SetPaneCount(4),
        Command::object("air ball", ObjectEdit::Visible(false)),
        Command::SetFollow(Follow::Sample),
        Command::Undo,
    ];
    for edit in edits {
        apply(&mut harness, edit.clone());
        wait(&mut harness);
        let inspection = harness.state().state().inspection.as_ref().unwrap_or_else(|| panic!("after {edit:?}"));
        assert_eq!(inspection.point, point, "after {edit:?}");
    }
    apply(&mut harness, Command::OpenAnyway("plain-glass".into()));
    until(&mut harness, "the other scene is there", |app| app.state().document.description().name == "Plain glass");
    assert!(harness.state().state().inspection.is_none());
}

#[test]
fn surfaces_are_pointed_out_by_mouse_and_keyboard() {
    let mut harness = inspector("nested-spheres");
    click(&mut harness, [0.5, 0.5]);
    let selected = |harness: &Harness<'_, App>| harness.state().state().inspection.as_ref().unwrap().vertex;
    harness.get_by_label_contains("Surface 2: ").click();
    harness.run_steps(3);
    assert_eq!(selected(&harness), Some(1));
    harness.get_by_label_contains("Surface 1: ").focus();
    harness.run_steps(3);
    assert_eq!(selected(&harness), Some(0));
    harness.key_press(Key::ArrowDown);
    harness.run_steps(3);
    assert_eq!(selected(&harness), Some(1));
    harness.key_press(Key::ArrowUp);
    harness.run_steps(3);
    assert_eq!(selected(&harness), Some(0));
}

#[test]
fn the_ray_is_kept_while_the_camera_moves_in_the_ghost_view() {
    let mut harness = inspector("nested-spheres");
    click(&mut harness, [0.5, 0.5]);
    harness.get_by_label("Ghost view").click();
    wait(&mut harness);
    let origin = |harness: &Harness<'_, App>| {
        let inspection = harness.state().state().inspection.as_ref().unwrap();
        inspection.path(Mode::Stack).unwrap().origin
    };
    let before = origin(&harness);
    let camera = harness.state().state().view.camera;
    harness.drag_at(egui::pos2(600.0, 400.0));
    harness.run_steps(2);
    harness.hover_at(egui::pos2(760.0, 430.0));
    harness.run_steps(2);
    harness.drop_at(egui::pos2(760.0, 430.0));
    wait(&mut harness);
    assert_ne!(harness.state().state().view.camera, camera);
    assert_eq!(origin(&harness), before);
    let traced = harness.state().state().inspection.as_ref().unwrap().traced.clone().unwrap();
    assert_eq!(traced.outlines.objects.len(), traced.question.report.prepared.scene.objects.len());
    // Given up, the path is that of the marked pixel again.
    harness.get_by_label("Keep this ray").click();
    wait(&mut harness);
    assert_ne!(origin(&harness), before);
}

#[test]
fn a_bundle_is_followed_and_chance_has_a_next_sample() {
    let mut harness = inspector("nested-spheres");
    click(&mut harness, [0.5, 0.4]);
    harness.get_by_label("Bundle").click();
    harness.run_steps(3);
    harness.get_by_label("Chance").click();
    wait(&mut harness);
    let ends = |harness: &Harness<'_, App>| -> Vec<[f64; 3]> {
        let traced = harness.state().state().inspection.as_ref().unwrap().traced.clone().unwrap();
        traced.lines[&Mode::Rectified].iter().map(|line| line.path.final_direction).collect()
    };
    let first = ends(&harness);
    assert_eq!(first.len(), 33);
    harness.get_by_label("Next sample").click();
    wait(&mut harness);
    assert_ne!(ends(&harness), first);
}

#[test]
fn paths_are_exported_as_drawing_and_as_numbers() {
    let mut harness = inspector("camera-in-water");
    let folder = tempfile::tempdir().unwrap();
    // Nothing to export yet.
    apply(&mut harness, Command::Export(ExportKind::PathJson, folder.path().join("none.json")));
    assert!(has_notice(&harness, "click"));
    click(&mut harness, [0.47, 0.55]);
    let [json, svg] = ["path.json", "path.svg"].map(|name| folder.path().join(name));
    apply(&mut harness, Command::Export(ExportKind::PathJson, json.clone()));
    apply(&mut harness, Command::Export(ExportKind::PathSvg, svg.clone()));
    until(&mut harness, "both files are there", |_| json.exists() && svg.exists());
    let value: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
    assert_eq!((&value["mode"], &value["against"]["mode"]), (&"stack".into(), &"rectified".into()));
    assert_eq!(value["parting"]["faults"][0]["cause"]["starts_inside"]["within"][0], "pool water");
    assert!(std::fs::read_to_string(svg).unwrap().starts_with("<svg "));
}

/// Places around a legend, where a label beside the pixel would lie on it.
#[test]
fn labels_keep_clear_of_whatever_lies_over_the_pane() {
    let mut harness = inspector("nested-spheres");
    // The ball fills the panes.
    apply(&mut harness, Command::SetZoom(5.0, [0.5, 0.5]));
    apply(&mut harness, Command::SetPaneContent(1, PaneContent::Difference(Mode::Stack, Mode::Rectified)));
    until(&mut harness, "there are images", every_pane_has_an_image);
    until(&mut harness, "the panes are judged", |app| {
        [Mode::Stack, Mode::Rectified].iter().all(|mode| app.state().verdicts.of.contains_key(mode))
    });
    let legend = harness.get_by_role_and_label(Role::Slider, "Range of the difference in pane 2").rect();
    let chip = harness.get_by_label_contains("Verdict of pane 2: ").rect();
    let pane = harness.state().pane_place(Some(1));
    let mut labels = 0;
    for place in [
        legend.left_top() + egui::vec2(-6.0, 10.0),
        legend.left_bottom() + egui::vec2(-6.0, -6.0),
        legend.center_top() + egui::vec2(0.0, -6.0),
        chip.right_bottom() + egui::vec2(4.0, 4.0),
        chip.left_bottom() + egui::vec2(10.0, 8.0),
    ] {
        click_at(&mut harness, place);
        wait(&mut harness);
        harness.run_steps(2);
        let texts: Vec<(String, Rect)> = painted(&harness)
            .into_iter()
            .map(|(text, _)| (text.galley.text().to_owned(), text.visual_bounding_rect()))
            .filter(|(_, rect)| pane.contains(rect.center()))
            .collect();
        let is_label = |text: &str| text.contains(" → ") && text.contains('°');
        for (text, rect) in texts.iter().filter(|(text, _)| is_label(text)) {
            labels += 1;
            assert!(!rect.intersects(legend), "{text} lies on the legend for {place:?}");
            for (other, taken) in texts.iter().filter(|(other, _)| !is_label(other)) {
                assert!(!rect.intersects(*taken), "{text} lies on {other} for {place:?}");
            }
        }
    }
    assert!(labels > 4, "{labels} labels were looked at");
}

/// The light of a lamp is followed as a path of a pixel is, in every mode; a click goes back to pixels.
#[test]
fn the_light_of_a_lamp_is_followed() {
    let mut harness = inspector("lamp-in-ice");
    click(&mut harness, [0.5, 0.5]);
    let lamp = harness.state().state().path_lights().remove(0);
    apply(&mut harness, Command::SetPathLight(Some(lamp.clone())));
    wait(&mut harness);
    let light_of = |harness: &Harness<'_, App>, mode: Mode| {
        let traced = harness.state().state().inspection.as_ref().unwrap().traced.clone().unwrap();
        traced.path(mode).unwrap().light.clone()
    };
    for mode in [Mode::Stack, Mode::Rectified] {
        assert_eq!(light_of(&harness, mode).as_ref(), Some(&lamp));
    }
    harness.get_by_label("PATH OF LIGHT");
    let before = harness.state().state().path_options.seed;
    harness.get_by_label("Next sample").click();
    wait(&mut harness);
    assert_ne!(harness.state().state().path_options.seed, before);
    click(&mut harness, [0.4, 0.6]);
    assert_eq!(light_of(&harness, Mode::Rectified), None);
}
