//! Mode `declared`: both sides of each surface as the scene says, whatever is there.

use glam::DVec3;
use iorect::formats::open;
use iorect::geometry::Ray;
use iorect::rectify::containment::medium_at;
use iorect::scene::ObjectId;
use iorect::scene::description::{Description, Shape};
use iorect::tracking::{Mode, Prepared};
use iorect::transport::inspect::{Follow, trace};

use crate::common::{add, empty, ready, render};

/// The scene with everything declared as rectification found it.
fn declared_right(mut description: Description) -> Description {
    let found = ready(description.clone());
    let scene = &found.scene;
    for (index, object) in description.objects.refractors_mut().iter_mut().enumerate() {
        let patch = found.table.main_patch(ObjectId(index as u32)).expect("it has a surface");
        let outside = patch.outside.expect("one medium is outside of all of it");
        object.refractor_mut().unwrap().outside = Some(scene.medium(outside).name.clone());
    }
    let (medium, _) = medium_at(scene, description.camera.position - scene.geometry.origin);
    description.camera_medium = Some(scene.medium(medium).name.clone());
    description
}

/// With right declarations the picture is that of rectification, to the bit, and nothing is left to be said.
#[test]
fn right_declarations_give_the_right_picture() {
    for name in ["nested-spheres", "bubble-in-glass", "diamond-in-water", "world-oil", "camera-in-water"] {
        let scene = ready(declared_right(open(name).unwrap()));
        let [declared, rectified] =
            [Mode::Declared, Mode::Rectified].map(|mode| render(&scene, mode, (32, 24), 4, None));
        assert_eq!(declared.sums, rectified.sums, "{name}");
        assert_eq!(declared.events.inconsistent, 0, "{name}");
        let problems = iorect::check::check(&scene);
        assert!(problems.iter().all(|problem| !problem.kind.starts_with("declared")), "{name}: {problems:?}");
    }
}

/// The twin: each declaration that is wrong changes the picture, and is found.
#[test]
fn a_wrong_declaration_changes_the_picture_and_is_found() {
    let right = declared_right(open("nested-spheres").unwrap());
    let image = |description: &Description| render(&ready(description.clone()), Mode::Declared, (32, 24), 4, None).sums;
    let expected = image(&right);
    for index in 0..right.objects.refractors().len() {
        let mut wrong = right.clone();
        let refractor = wrong.objects.refractors_mut()[index].refractor_mut().unwrap();
        let was = refractor.outside.clone();
        // Any other medium than its own and the right one.
        let other = right
            .media
            .iter()
            .map(|medium| &medium.name)
            .find(|name| **name != refractor.medium && Some(*name) != was.as_ref());
        refractor.outside = Some(other.map_or("world", |name| name).to_owned());
        assert_ne!(image(&wrong), expected, "{index}");
        let problems = iorect::check::check(&ready(wrong.clone()));
        let name = &wrong.objects.refractors()[index].name;
        assert!(problems.iter().any(|p| p.kind == "declared_outside" && p.place == *name), "{index}: {problems:?}");
    }
}

/// The media before and behind each surface on the way of a ray.
fn sides(scene: &Prepared, ray: Ray) -> Vec<(f64, f64)> {
    let path = trace(scene, Mode::Declared, ray, Follow::Transmit, 0, None);
    let interfaces = path.vertices.iter().filter_map(|vertex| Some((vertex.ior_from?, vertex.ior_to?)));
    interfaces.collect()
}

/// A scene of interfaces: sheets, each with what is on both of its sides.
#[test]
fn open_sheets_are_followed_as_they_are_declared() {
    let mut description = empty(1.0);
    let sheet = |y: f64| Shape::Quad { center: DVec3::Y * y, edge_u: DVec3::Z * 50.0, edge_v: DVec3::X * 50.0 };
    add(&mut description, sheet(1.0), 1.5, 0.0);
    add(&mut description, sheet(0.0), 1.33, 0.0);
    let glass = description.media[0].name.clone();
    description.objects.refractors_mut()[0].refractor_mut().unwrap().outside = Some("world".into());
    description.objects.refractors_mut()[1].refractor_mut().unwrap().outside = Some(glass);
    let scene = ready(description);
    let down = DVec3::new(0.3, -1.0, 0.1).normalize();
    assert_eq!(sides(&scene, Ray::new(DVec3::Y * 2.0, down)), [(1.0, 1.5), (1.5, 1.33)]);
    assert_eq!(sides(&scene, Ray::new(DVec3::NEG_Y, -down)), [(1.33, 1.5), (1.5, 1.0)]);
}

/// Absorption begins where the camera is declared to be, and not where it is.
#[test]
fn the_declared_medium_of_the_camera_counts() {
    let mut description = empty(1.0);
    add(&mut description, Shape::Box { min: DVec3::splat(-20.0), max: DVec3::splat(20.0) }, 1.0, 0.1);
    description.camera.position = DVec3::ZERO;
    description.camera.target = DVec3::NEG_Z;
    description.camera.vertical_fov = 1.0;
    let mean = |description: &Description, mode| {
        let film = render(&ready(description.clone()), mode, (4, 4), 4, None);
        (0..16).map(|pixel| film.mean(pixel).x).sum::<f64>() / 16.0
    };
    // The index is that of the world: all that the box does is to absorb, over 20 units.
    let absorbed = (-2.0_f64).exp();
    assert!((mean(&description, Mode::Rectified) / absorbed - 1.0).abs() < 1e-3);
    assert!((mean(&description, Mode::Declared) - 1.0).abs() < 1e-9);
    description.camera_medium = Some(description.media[0].name.clone());
    assert!((mean(&description, Mode::Declared) / absorbed - 1.0).abs() < 1e-3);
}
