//! Scenes with every interface resolved: what is written for other renderers, held against containment asked anew, and against being closed.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use iorect::export::resolved::pieces::{Interface, Piece, interfaces, with_meshes};
use iorect::export::resolved::{Frame, Target, export};
use iorect::formats;
use iorect::measure::metrics::block_means;
use iorect::report::stability::scenes as made;
use iorect::scene::MediumId;
use iorect::scene::description::{Description, Object, Paint, Shape, Solid};
use iorect::tracking::{Mode, Prepared, Tracker, WithTracker};

use crate::common::{Numbers, add, empty, icosphere, ready, sphere};

const FRAME: Frame = Frame { width: 64, height: 48, samples: 16 };

fn resolved(description: Description) -> (Prepared, Vec<Interface>) {
    let (prepared, _) = with_meshes(&Arc::new(description)).unwrap();
    let interfaces = interfaces(&prepared);
    (prepared, interfaces)
}

/// Scenes in which surfaces cross, coincide, touch and lie in each other.
fn scenes() -> Vec<(String, Description)> {
    let mut scenes: Vec<(String, Description)> =
        ["iced-water", "half-submerged", "nested-spheres", "siblings", "camera-in-water", "lamp-in-ice"]
            .into_iter()
            .map(|name| (name.to_owned(), formats::open(name).unwrap()))
            .collect();
    // Boxes and balls at irregular places, through each other.
    let mut numbers = Numbers(3);
    for round in 0..4 {
        let mut description = empty(1.0);
        for index in 0..5 {
            let center = numbers.point(DVec3::splat(-0.7), DVec3::splat(0.7));
            let size = numbers.between(0.4, 1.0);
            let shape = match index % 3 {
                0 => Shape::Box { min: center - size, max: center + DVec3::new(size, 0.7 * size, 1.3 * size) },
                1 => Shape::Icosphere { center, radius: size, subdivisions: 2 },
                _ => sphere(center, size),
            };
            add(&mut description, shape, 1.1 + 0.1 * f64::from(index), 0.0);
            description.objects.refractor_roles_mut().last().unwrap().priority = index % 2;
        }
        scenes.push((format!("heap {round}"), description));
    }
    // Boxes that share parts of their faces, in other tessellations.
    let mut description = empty(1.0);
    for (min, max, ior) in [
        (DVec3::ZERO, DVec3::ONE, 1.5),
        (DVec3::new(1.0, 0.25, -0.5), DVec3::new(2.0, 0.75, 0.5), 1.3),
        (DVec3::new(0.25, 1.0, 0.25), DVec3::new(0.75, 2.0, 0.75), 1.4),
    ] {
        add(&mut description, Shape::Box { min, max }, ior, 0.0);
    }
    scenes.push(("flush boxes".into(), description));
    scenes
}

/// The medium at points (local coordinates) by winding numbers, which rectification does not use.
struct MediaAt<'a>(&'a [DVec3]);

impl WithTracker for MediaAt<'_> {
    type Output = Vec<Option<(MediumId, bool)>>;

    fn run<T: Tracker>(self, tracker: &T) -> Self::Output {
        self.0.iter().map(|point| tracker.medium_at(*point)).collect()
    }
}

/// On both sides of every piece lies what it says.
#[test]
fn pieces_have_the_media_that_are_there() {
    for (name, description) in scenes() {
        let (prepared, interfaces) = resolved(description);
        let geometry = &prepared.scene.geometry;
        let mut numbers = Numbers(1);
        let (mut points, mut expected) = (Vec::new(), Vec::new());
        for interface in &interfaces {
            assert_ne!(interface.outside, interface.inside);
            let size = geometry.radius_of(interface.refractor.0);
            let mesh = interface.piece.clone().into_mesh();
            for _ in 0..200 {
                let (middle, normal) = match &interface.piece {
                    Piece::Sphere { center, radius } => {
                        let normal = numbers.direction();
                        (*center + normal * *radius, normal)
                    }
                    Piece::Mesh(_) => {
                        let triangle = mesh.triangles[numbers.index(mesh.triangles.len())];
                        let [a, b, c] = triangle.map(|k| mesh.positions[k as usize]);
                        let normal = (b - a).cross(c - a);
                        if normal.length() < (2e-3 * size).powi(2) {
                            continue;
                        }
                        ((a + b + c) / 3.0, normal.normalize())
                    }
                };
                let (middle, beside) = (middle - geometry.origin, normal * 1e-4 * size);
                points.extend([middle + beside, middle - beside]);
                expected.extend([interface.outside, interface.inside]);
            }
        }
        assert!(points.len() > 50, "{name}: {}", points.len());
        let found = prepared.with_tracker(Mode::Reference, MediaAt(&points));
        let sure = found.iter().zip(&expected).filter_map(|(found, expected)| match found {
            Some((medium, false)) => Some(medium == expected),
            _ => None,
        });
        let (right, all) = sure.fold((0, 0), |(right, all), is_right| (right + usize::from(is_right), all + 1));
        // Beside a crossing curve the points may lie beyond another surface.
        assert!(all * 10 > points.len() * 9 && right * 100 >= all * 99, "{name}: {right} of {all} of {}", points.len());
    }
}

/// Media fill space: no piece has an edge to itself, at which one would end in another without an interface.
#[test]
fn pieces_leave_no_gap() {
    for (name, description) in scenes() {
        let (_, interfaces) = resolved(description);
        let mut edges: HashMap<[[u32; 3]; 2], u32> = HashMap::new();
        for interface in &interfaces {
            let mesh = interface.piece.clone().into_mesh();
            let corner = |k: u32| mesh.positions[k as usize].as_vec3().to_array().map(|x| (x + 0.0).to_bits());
            for triangle in &mesh.triangles {
                for k in 0..3 {
                    let mut edge = [corner(triangle[k]), corner(triangle[(k + 1) % 3])];
                    edge.sort_unstable();
                    *edges.entry(edge).or_default() += 1;
                }
            }
        }
        let open = edges.values().filter(|count| **count == 1).count();
        assert_eq!(open, 0, "{name}: of {} edges", edges.len());
    }
}

/// Of what coincides one stands for all, and what has the same medium on both sides is left out.
#[test]
fn what_is_no_interface_is_left_out() {
    let mut description = empty(1.0);
    add(&mut description, icosphere(1.0, 2), 1.5, 0.0);
    add(&mut description, icosphere(1.0, 2), 1.3, 0.0);
    add(&mut description, icosphere(0.5, 2), 1.5, 0.0);
    let medium = description.objects.refractors()[0].refractor().unwrap().medium.clone();
    description.objects.refractor_roles_mut().last().unwrap().medium = medium;
    let (prepared, found) = resolved(description);
    assert!(!found.is_empty());
    let total: usize = found.iter().map(|interface| interface.piece.clone().into_mesh().triangles.len()).sum();
    let faces = 20 * 16;
    // The second ball fills what the first does, and wins there, or loses; the small one shows only in the other's medium.
    assert!(total == faces || total == 2 * faces, "{total}");
    for interface in &found {
        assert_ne!(prepared.scene.medium(interface.outside), prepared.scene.medium(interface.inside));
    }
}

/// Every target writes files that name each other, for every built-in scene; they are the same each time.
#[test]
fn files_are_complete() {
    for scene in formats::builtin::all() {
        let description = Arc::new(formats::open(scene.name).unwrap());
        for target in [Target::Mitsuba, Target::Pbrt, Target::Gltf, Target::Faces] {
            let bundle = export(&description, target, FRAME).unwrap();
            let main = bundle.get(&bundle.main).unwrap();
            assert_eq!(bundle.paths().last(), Some(&*bundle.main), "it is written last");
            if target != Target::Gltf {
                let text = std::str::from_utf8(main).unwrap();
                for path in bundle.paths().filter(|path| *path != bundle.main) {
                    assert!(text.contains(path.to_str().unwrap()), "{}: {}", scene.name, path.display());
                }
                for part in text.split('"').filter(|part| part.ends_with(".ply") || part.ends_with("environment.exr")) {
                    assert!(bundle.get(part).is_some(), "{}: {part} is not there", scene.name);
                }
            }
            let again = export(&description, target, FRAME).unwrap();
            assert!(again.paths().all(|path| again.get(path) == bundle.get(path)), "{}", scene.name);
        }
    }
}

/// Objects whose names are alike, with and without a number, have files of their own.
#[test]
fn no_two_surfaces_share_a_file() {
    let mut description = empty(1.0);
    for (index, name) in ["ball", "Ball", "ball 0", "ball-1", "ball.2", "?"].into_iter().enumerate() {
        let min = DVec3::X * 3.0 * index as f64;
        add(&mut description, Shape::Box { min, max: min + 1.0 }, 1.5, 0.0);
        description.objects[index].name = name.to_owned();
    }
    for name in ["ball 2", "ball 3", "!"] {
        let shape = Shape::Box { min: DVec3::Y * 5.0, max: DVec3::splat(7.0) };
        description.objects.push(Object::new(name, shape, Solid::of(Paint::Color([0.5; 3]))));
    }
    let description = Arc::new(description);
    for (target, meshes) in [(Target::Mitsuba, 9), (Target::Pbrt, 9), (Target::Faces, 6)] {
        let bundle = export(&description, target, FRAME).unwrap();
        let paths: std::collections::BTreeSet<_> = bundle.paths().collect();
        assert_eq!((paths.len(), bundle.paths().count()), (meshes + 1, meshes + 1), "{}", target.name());
    }
}

/// Of glTF the volumes come back: as many refractors, with their indices, where they were.
#[test]
fn gltf_is_read_again() {
    for name in ["iced-water", "camera-in-water", "lamp-in-ice"] {
        let description = formats::open(name).unwrap();
        let bundle = export(&Arc::new(description.clone()), Target::Gltf, FRAME).unwrap();
        let again = formats::read(bundle.get("scene.glb").unwrap(), "scene.glb".as_ref(), &formats::Disk).unwrap();
        assert_eq!(again.objects.refractors().len(), description.objects.refractors().len());
        for object in description.objects.refractors() {
            let same = again.objects.refractors().iter().find(|o| o.name == object.name).unwrap();
            let ior = |d: &Description, o: &iorect::scene::description::Object| {
                let medium = d.media.iter().find(|m| m.name == o.refractor().unwrap().medium).unwrap();
                1.0 + medium.ior.ior_minus_one(iorect::spectrum::WAVELENGTH_D_UM)
            };
            assert!((ior(&description, object) - ior(&again, same)).abs() < 1e-6, "{name}: {}", object.name);
        }
        assert!(again.camera.position.distance(description.camera.position) < 1e-4);
    }
}

/// A sphere that nothing crosses stays one.
#[test]
fn spheres_stay_spheres() {
    let (_, found) = resolved(formats::open("nested-spheres").unwrap());
    assert!(found.iter().all(|interface| matches!(interface.piece, Piece::Sphere { .. })));
}

/// What is written for Mitsuba and for pbrt is read again: followed as it is declared, it looks like the scene that it was made from.
#[test]
fn what_is_written_is_read_again_as_declared() {
    let size = (48, 48);
    for name in ["half-submerged", "camera-in-water", "nested-spheres", "lamp-in-ice"] {
        let description = formats::open(name).unwrap();
        let frame = Frame { width: size.0, height: size.1, samples: 1 };
        for target in [Target::Mitsuba, Target::Pbrt] {
            let folder = tempfile::tempdir().unwrap();
            let bundle = export(&Arc::new(description.clone()), target, frame).unwrap();
            bundle.write(folder.path()).unwrap();
            let again = formats::file(&folder.path().join(&bundle.main)).unwrap();
            let films = |description: &Description, mode| {
                let prepared = ready(description.clone());
                [1, 2].map(|seed| {
                    let rgb = made::render(&prepared, mode, size, 24, seed, None).unwrap().to_rgb();
                    block_means(&rgb, size.0 as usize, size.1 as usize, 8).unwrap()
                })
            };
            let (ours, theirs) = (films(&description, Mode::Rectified), films(&again, Mode::Declared));
            let products = (ours[0].iter().zip(&ours[1]).zip(theirs[0].iter().zip(&theirs[1])))
                .flat_map(|((a, b), (c, d))| (0..3).map(move |k| [a[k], b[k], c[k], d[k]].map(f64::from)))
                .map(|[a, b, c, d]| (a - c) * (b - d) / ((a + b).powi(2) / 4.0 + 0.01));
            let products: Vec<f64> = products.collect();
            let error = products.iter().sum::<f64>() / products.len() as f64;
            assert!(error < 1e-3, "{name}, {}: {error:.2e}", target.name());
        }
    }
}
