//! Lights without a surface in the window: added, measured and turned by typing and by handles, undone, saved, chosen in the picture.

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use iorect::app::{App, Command, ObjectEdit};
use iorect::scene::description::{Light, Object, Quantity, Shape};
use iorect::scene::emission::power_of_unit;

use crate::harness::{apply, choose, click, has_notice, has_text, picture_of, press, type_into, until, window};

fn object<'a>(harness: &'a Harness<'_, App>, name: &str) -> &'a Object {
    harness.state().state().document.description().objects.find(name).expect("it is there")
}

fn light<'a>(harness: &'a Harness<'_, App>, name: &str) -> &'a Light {
    object(harness, name).light().expect("it is a light")
}

#[test]
fn lights_of_every_kind_are_added_edited_undone_and_saved() {
    let mut harness = window("nested-spheres");
    for name in ["point light", "spot light", "sun"] {
        choose(&mut harness, &["Add", &format!("Add {name}")]);
        assert_eq!(harness.state().state().selected.as_deref(), Some(name));
    }
    until(&mut harness, "their media are known", |app| {
        app.state().is_prepared() && app.state().report.as_ref().is_some_and(|r| r.prepared.table.lights.len() == 3)
    });
    assert!(has_text(&harness, "Stands in"));

    // A sun: its angle, and what it may not be.
    let angle = |harness: &Harness<'_, App>| match object(harness, "sun").shape {
        Shape::Directional { angle, .. } => angle,
        _ => panic!("it is no sun"),
    };
    type_into(&mut harness, Role::SpinButton, "Angle of sun", "2");
    assert_eq!(angle(&harness), 2.0);
    type_into(&mut harness, Role::SpinButton, "Angle of sun", "1e-7");
    assert!(has_notice(&harness, "must be 0, or from 0.001") && angle(&harness) == 2.0);
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(angle(&harness), 0.53);
    type_into(&mut harness, Role::SpinButton, "Strength of sun", "7");
    assert_eq!(light(&harness, "sun").emission.rgb[0], 7.0);

    // A spot: its angles, and its power as an intensity.
    apply(&mut harness, Command::SelectObject(Some("spot light".into())));
    type_into(&mut harness, Role::SpinButton, "Outer angle of spot light", "40");
    assert!(matches!(object(&harness, "spot light").shape, Shape::Spot { outer_angle: 40.0, .. }));
    let before = light(&harness, "spot light").clone();
    assert_eq!(before.emission.quantity, Quantity::Power);
    click(&mut harness, "Intensity");
    let after = light(&harness, "spot light").clone();
    assert_eq!(after.emission.quantity, Quantity::Intensity);
    // The same light.
    let per_unit = power_of_unit(&object(&harness, "spot light").shape, false, 0.0);
    assert!((after.emission.rgb[0] * per_unit / before.emission.rgb[0] - 1.0).abs() < 1e-9);

    // A point is moved.
    apply(&mut harness, Command::SelectObject(Some("point light".into())));
    type_into(&mut harness, Role::SpinButton, "Position of point light along y", "3.5");
    assert!(matches!(object(&harness, "point light").shape, Shape::Point { position } if position.y == 3.5));
    assert!(harness.query_by_label("Scale point light along x").is_none(), "it has no size");

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("lit.toml");
    apply(&mut harness, Command::SaveAs(path.clone()));
    until(&mut harness, "it is saved", |app| !app.state().document.is_dirty());
    let again = iorect::formats::open(&path).expect("what was saved can be read");
    assert_eq!(again.objects, harness.state().state().document.description().objects);
}

/// With Ctrl held a click on the symbol of a light selects it; nothing else can be met there.
#[test]
fn a_light_is_chosen_by_its_symbol() {
    let mut harness = window("nested-spheres");
    choose(&mut harness, &["Add", "Add point light"]);
    let camera = harness.state().state().view.camera;
    // The camera looks at it.
    let edit = ObjectEdit::Shape(Shape::Point { position: camera.target });
    apply(&mut harness, Command::object("point light", edit));
    apply(&mut harness, Command::SelectObject(None));
    let middle = picture_of(&harness).center();
    harness.event_modifiers(egui::Event::PointerMoved(middle), Modifiers::COMMAND);
    for pressed in [true, false] {
        let button = egui::Event::PointerButton {
            pos: middle,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Modifiers::COMMAND,
        };
        harness.event_modifiers(button, Modifiers::COMMAND);
        harness.run_steps(2);
    }
    assert_eq!(harness.state().state().selected.as_deref(), Some("point light"));
}
