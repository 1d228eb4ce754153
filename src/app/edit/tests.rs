//! Whatever is edited can be saved and read again, and what a file may not say is refused in the reader's words.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::{Edit, MediumEdit, ObjectEdit};
use crate::app::build::profiles::Vessel;
use crate::app::build::{Addition, Body, duplicate, empty_scene, mesh_edit};
use crate::app::command::MediumRef;
use crate::app::document::Document;
use crate::app::objects::Manipulation;
use crate::formats::{Memory, mesh_from_bytes, parse, to_text};
use crate::optics::{Ior, Medium, catalog};
use crate::scene::description::{
    Description, Emission, Environment, Kind, Object, Paint, Quantity, Refractor, Shape, Solid, Transform,
};
use crate::scene::{SceneError, validate};

const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fn read_again(description: &Description) -> Result<Description, SceneError> {
    let files = Memory([("s/m.obj".into(), OBJ.to_vec())].into());
    parse(&to_text(description), Path::new("s/s.toml"), &files).map(|d| Description { source: None, ..d })
}

/// Numbers in [0, 1), always the same.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.number() * count as f64) as usize
    }

    fn pick<T: Clone>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())].clone()
    }

    /// Ordinary ones, and now and then one that hardly anything may have.
    fn any(&mut self) -> f64 {
        let odd = [0.0, -1.0, 1e-120, 1e30, 1e200, f64::NAN, f64::INFINITY, -0.0];
        if self.below(12) == 0 { self.pick(&odd) } else { self.number() * 3.0 - 0.3 }
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.any(), self.any(), self.any())
    }

    fn rgb(&mut self) -> [f64; 3] {
        self.vector().to_array()
    }
}

fn random_shape(random: &mut Random) -> Shape {
    let [center, other] = [random.vector(), random.vector()];
    let [a, b] = [random.any(), random.any()];
    let segments = random.pick(&[0, 3, 17, 128, 10_000]);
    match random.below(7) {
        0 => Shape::Sphere { center, radius: a },
        1 => Shape::Icosphere { center, radius: a, subdivisions: random.pick(&[0, 2, 20]) },
        2 => Shape::Box { min: center, max: center + other },
        3 => Shape::Cylinder { center, radius: a, height: b, segments },
        4 => Shape::Torus { center, major: a, minor: b, segments, rings: segments },
        5 => Shape::Quad { center, edge_u: other, edge_v: random.vector() },
        _ => Shape::Lathe { profile: (0..random.below(6)).map(|_| [random.any(), random.any()]).collect(), segments },
    }
}

fn random_edit(random: &mut Random, scene: &Description) -> Edit {
    let names: Vec<String> = scene.objects.iter().map(|object| object.name.clone()).collect();
    let name = if names.is_empty() || random.below(20) == 0 { "nobody".to_owned() } else { random.pick(&names) };
    let media: Vec<MediumRef> = (scene.media.iter().map(|medium| MediumRef::Named(medium.name.clone())))
        .chain([MediumRef::World, MediumRef::Named("soup".into())])
        .collect();
    let object = |edit| Edit::Object(name.clone(), edit);
    let added = |addition: Addition| addition.edit(scene, &scene.camera, Some(&name)).ok();
    let kept = Edit::Camera(scene.camera);
    match random.below(20) {
        0 => added(Addition::Refractor(random.pick(&Body::ALL))).unwrap_or(kept),
        1 => added(Addition::Vessel(random.pick(&Vessel::ALL))).unwrap_or(kept),
        2 => added(Addition::Liquid(name.clone(), random.number())).unwrap_or(kept),
        3 => added(random.pick(&[
            Addition::IceCube,
            Addition::Floor,
            Addition::BallLight,
            Addition::PanelLight,
            Addition::PointLight,
            Addition::SpotLight,
            Addition::Sun,
        ]))
        .unwrap_or(kept),
        4 => added(Addition::Solid(random.pick(&Body::ALL))).unwrap_or(kept),
        5 => {
            let mesh = Arc::new(mesh_from_bytes(OBJ, Path::new("m.obj")).unwrap());
            let shape = Shape::mesh("m.obj", mesh);
            let glass = |name: &str| {
                let medium = Medium { name: name.to_owned(), ior: Ior::Constant(1.5), absorption: [0.0; 3] };
                (Object::new(name, shape.clone(), Refractor::of(name)), Some(medium))
            };
            let mut pieces = vec![glass("m")];
            if random.below(2) == 0 {
                pieces.push((Object::new("m", shape.clone(), Solid::of(Paint::Color([0.5; 3]))), None));
                pieces.push(glass("world"));
            }
            mesh_edit(scene, &scene.camera, Some(&name), pieces)
        }
        6 => duplicate(scene, &name).unwrap_or(kept),
        7 => Edit::Remove(name),
        8 => {
            let new = ["a", " b ", "c, d", "", "world", "„ö“ \"'\\ \n\t#=[", "floor", "window"];
            object(ObjectEdit::Rename(random.pick(&new).to_owned()))
        }
        9 => object(ObjectEdit::Priority(random.pick(&[i32::MIN, -1, 0, 1, i32::MAX]))),
        10 => object(ObjectEdit::Visible(random.below(2) == 0)),
        11 => {
            let scale = if random.below(2) == 0 { DVec3::splat(random.any()) } else { random.vector() };
            let transform = Transform { scale, rotate: random.vector() * 100.0, translate: random.vector() };
            object(ObjectEdit::Transform(random.pick(&Manipulation::ALL), transform))
        }
        12 | 13 => object(ObjectEdit::Shape(random_shape(random))),
        14 => object(ObjectEdit::Smooth(random.below(2) == 0)),
        15 => object(ObjectEdit::Paint(match random.below(2) {
            0 => Paint::Color(random.rgb()),
            _ => Paint::Checker { a: random.rgb(), b: [0.5; 3], size: random.any() },
        })),
        16 => object(if random.below(2) == 0 {
            ObjectEdit::Emission(Emission { quantity: Quantity::Radiance, rgb: random.rgb() })
        } else {
            ObjectEdit::Mirror(random.below(2) == 0)
        }),
        17 => Edit::Priorities(vec![(name, random.pick(&[-3, 7]))]),
        18 => {
            let medium = random.pick(&media);
            Edit::Medium(
                medium,
                match random.below(3) {
                    0 => MediumEdit::Ior(Ior::Constant(random.any())),
                    1 => MediumEdit::Ior(Ior::Catalog(&catalog::ALL[random.below(catalog::ALL.len())])),
                    _ => MediumEdit::Absorption(random.rgb()),
                },
            )
        }
        _ => Edit::Environment(Environment::Color(random.rgb())),
    }
}

/// Sequences of edits, sound ones and impossible ones: the scene stays sound, is the same when it is saved and read, and undoing all of
/// them gives the first scene back, doing them again the last.
#[test]
fn every_edited_scene_can_be_saved_and_read_again() {
    let (mut refused, mut done) = (0, 0);
    for seed in 0..12 {
        let mut random = Random(seed);
        let first = Arc::new(empty_scene());
        let mut document = Document::new(Arc::clone(&first));
        let mut history = vec![Arc::clone(&first)];
        for step in 0..60 {
            let edit = random_edit(&mut random, document.description());
            match edit.apply(document.description()) {
                Err(why) => {
                    assert!(!why.is_empty());
                    refused += 1;
                }
                Ok(None) => {}
                Ok(Some(edited)) => {
                    validate::description(&edited).unwrap_or_else(|fault| panic!("{seed}, {step}: {edit:?}: {fault}"));
                    let again = read_again(&edited).unwrap_or_else(|error| panic!("{seed}, {step}: {edit:?}: {error}"));
                    assert_eq!(again, edited, "{seed}, {step}: {edit:?}");
                    // Far enough apart to be undone one by one.
                    document.edit(edit.key(), f64::from(step) * 100.0, edited);
                    history.push(Arc::clone(document.description()));
                    done += 1;
                }
            }
        }
        for scene in history.iter().rev().skip(1) {
            assert!(document.undo() && Arc::ptr_eq(document.description(), scene));
        }
        assert!(!document.undo() && !document.is_dirty());
        while document.redo() {}
        assert!(Arc::ptr_eq(document.description(), history.last().unwrap()));
    }
    assert!(refused > 50 && done > 200, "{refused} refused, {done} done");
}

/// A scene with one of each that can be edited wrongly.
fn scene() -> Description {
    let mut scene = empty_scene();
    for addition in [Addition::Refractor(Body::Sphere), Addition::Vessel(Vessel::ALL[0]), Addition::BallLight] {
        let edit = addition.edit(&scene, &scene.camera, None).unwrap();
        scene = edit.apply(&scene).unwrap().unwrap();
    }
    scene
}

/// Each impossible edit is refused with what a file that says the same is refused with.
#[test]
fn the_editor_refuses_what_the_reader_refuses_in_its_words() {
    let object = |name: &str, edit: ObjectEdit| Edit::Object(name.to_owned(), edit);
    let glass = || MediumRef::Named("glass".to_owned());
    let moved = |transform: Transform| ObjectEdit::Transform(Manipulation::Scale, transform);
    let scaled = |scale: DVec3| moved(Transform { scale, ..Transform::IDENTITY });
    type Spoil = fn(&mut Description);
    let camera = Edit::Camera(crate::scene::description::CameraDescription {
        target: DVec3::ONE,
        position: DVec3::ONE,
        ..empty_scene().camera
    });
    let cases: Vec<(Edit, Spoil)> = vec![
        (object("sphere", ObjectEdit::Rename("floor".into())), |d| {
            d.objects.find_mut("sphere").unwrap().name = "floor".into()
        }),
        (object("sphere", ObjectEdit::Rename("world".into())), |d| {
            d.objects.find_mut("sphere").unwrap().name = "world".into()
        }),
        (object("sphere", ObjectEdit::Rename("  ".into())), |d| {
            d.objects.find_mut("sphere").unwrap().name = String::new()
        }),
        (object("sphere", ObjectEdit::Shape(Shape::Sphere { center: DVec3::ZERO, radius: -1.0 })), |d| {
            d.objects.find_mut("sphere").unwrap().shape = Shape::Sphere { center: DVec3::ZERO, radius: -1.0 };
        }),
        (object("sphere", ObjectEdit::Shape(Shape::Sphere { center: DVec3::NAN, radius: 1.0 })), |d| {
            d.objects.find_mut("sphere").unwrap().shape = Shape::Sphere { center: DVec3::NAN, radius: 1.0 };
        }),
        (
            object(
                "tumbler",
                ObjectEdit::Shape(Shape::Lathe { profile: vec![[0.0, 0.0], [1.0, f64::INFINITY]], segments: 9 }),
            ),
            |d| {
                d.objects.find_mut("tumbler").unwrap().shape =
                    Shape::Lathe { profile: vec![[0.0, 0.0], [1.0, f64::INFINITY]], segments: 9 };
            },
        ),
        (
            object("tumbler", ObjectEdit::Shape(Shape::Lathe { profile: vec![[0.0, 0.0], [1.0, 1.0]], segments: 9 })),
            |d| {
                d.objects.find_mut("tumbler").unwrap().shape =
                    Shape::Lathe { profile: vec![[0.0, 0.0], [1.0, 1.0]], segments: 9 };
            },
        ),
        (object("sphere", scaled(DVec3::new(1.0, 2.0, 1.0))), |d| {
            d.objects.find_mut("sphere").unwrap().transform =
                Transform { scale: DVec3::new(1.0, 2.0, 1.0), ..Transform::IDENTITY };
        }),
        (object("tumbler", scaled(DVec3::new(0.0, 2.0, 1.0))), |d| {
            d.objects.find_mut("tumbler").unwrap().transform =
                Transform { scale: DVec3::new(0.0, 2.0, 1.0), ..Transform::IDENTITY };
        }),
        (object("floor", ObjectEdit::Paint(Paint::Color([0.0, 1.5, 0.0]))), |d| {
            d.objects.find_mut("floor").unwrap().solid_mut().unwrap().paint = Paint::Color([0.0, 1.5, 0.0]);
        }),
        (object("floor", ObjectEdit::Paint(Paint::Checker { a: [0.0; 3], b: [1.0; 3], size: 0.0 })), |d| {
            d.objects.find_mut("floor").unwrap().solid_mut().unwrap().paint =
                Paint::Checker { a: [0.0; 3], b: [1.0; 3], size: 0.0 };
        }),
        (
            object(
                "ball light",
                ObjectEdit::Emission(Emission { quantity: Quantity::Radiance, rgb: [1.0, 1.0, -2.0] }),
            ),
            |d| {
                d.objects.find_mut("ball light").unwrap().light_mut().unwrap().emission.rgb = [1.0, 1.0, -2.0];
            },
        ),
        (Edit::Medium(glass(), MediumEdit::Ior(Ior::Constant(-1.0))), |d| d.media[0].ior = Ior::Constant(-1.0)),
        (Edit::Medium(glass(), MediumEdit::Ior(Ior::Cauchy([-3.0, 0.0, 0.0]))), |d| {
            d.media[0].ior = Ior::Cauchy([-3.0, 0.0, 0.0])
        }),
        (Edit::Medium(glass(), MediumEdit::Absorption([0.0, f64::NAN, 0.0])), |d| d.media[0].absorption[1] = f64::NAN),
        (Edit::Medium(MediumRef::World, MediumEdit::Absorption([-1.0, 0.0, 0.0])), |d| d.world.absorption[0] = -1.0),
        (camera, |d| (d.camera.target, d.camera.position) = (DVec3::ONE, DVec3::ONE)),
        (Edit::Environment(Environment::Color([0.0, 1e101, 0.0])), |d| {
            d.environment = Environment::Color([0.0, 1e101, 0.0])
        }),
    ];
    for (edit, spoil) in cases {
        let why = edit.apply(&scene()).expect_err("this is impossible");
        let mut spoiled = scene();
        spoil(&mut spoiled);
        assert_eq!(why, read_again(&spoiled).unwrap_err().message, "{edit:?}");
    }
    assert!(scene().objects.of(Kind::Refractor).len() == 2 && read_again(&scene()).unwrap() == scene(), "the twin");
}
