//! A scene that is moved, turned and scaled is the same scene: what is in contact stays in contact, what is apart stays apart, and objects elsewhere
//! have no say in it.

use crate::common::{Numbers, add, case, empty, mean, ready, render, sphere};
use glam::{DMat3, DVec3};
use iorect::check::check;
use iorect::geometry::Mesh;
use iorect::rectify::PatchKind;
use iorect::scene::description::{Description, Environment, Kind, Object, Shape, Transform};
use iorect::tracking::Mode;
use iorect::tracking::Prepared;

/// The modes that know media from geometry alone, and so find contacts.
const RIGHT: [Mode; 2] = [Mode::Rectified, Mode::Reference];

/// Reflectance at normal incidence of glass in air, and of glass on water seen through it; over a black table in the water.
const IN_CONTACT: f64 = 0.0432;
/// The same with a film of air in between, too thin to be seen as a gap.
const APART: f64 = 0.0944;

/// A motion that permutes the axes cyclically `turns` times, then scales, then moves.
#[derive(Debug, Clone, Copy)]
struct Motion {
    turns: u32,
    scale: f64,
    offset: DVec3,
}

const STILL: Motion = Motion { turns: 0, scale: 1.0, offset: DVec3::ZERO };

impl Motion {
    fn apply(&self, description: &Description) -> Description {
        let mut moved = description.clone();
        // x to y, y to z, z to x; by angles about the axes, as in a scene file.
        let rotate = [DVec3::ZERO, DVec3::new(90.0, 0.0, 90.0), DVec3::new(-90.0, -90.0, 0.0)][self.turns as usize];
        let transform = Transform { scale: DVec3::splat(self.scale), rotate, translate: self.offset };
        let matrix = transform.matrix();
        for object in moved.objects.iter_mut().filter(|object| object.light().is_none()) {
            assert_eq!(object.transform, Transform::IDENTITY, "such motions are not composed here");
            object.transform = transform;
        }
        let camera = &mut moved.camera;
        camera.position = matrix.transform_point3(camera.position);
        camera.target = matrix.transform_point3(camera.target);
        camera.up = matrix.transform_vector3(camera.up).normalize();
        moved
    }

    /// Many, of all kinds.
    fn list() -> Vec<Self> {
        let mut numbers = Numbers(71);
        let mut list = vec![STILL];
        for distance in [1.0, 1.0, 3.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6] {
            for scale in [1.0, 1e-6, 1e-3, 0.7, 1e3, 1e6] {
                let offset = numbers.direction() * distance * scale;
                list.push(Self { turns: numbers.index(3) as u32, scale, offset });
            }
        }
        // Along an axis, by numbers that people type.
        for x in [0.1, 1.0, -5.0, 100.0, 1e6] {
            list.push(Self { offset: DVec3::Y * x, ..STILL });
        }
        list
    }
}

#[test]
fn turns_permute_the_axes() {
    for turns in 0..3 {
        let description = Motion { turns, ..STILL }.apply(&two_blocks(0.0));
        let matrix = description.objects.refractors()[0].transform.matrix().matrix3;
        let mut expected = DMat3::IDENTITY;
        for _ in 0..turns {
            expected = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X) * expected;
        }
        assert!((matrix - expected).abs_diff_eq(DMat3::ZERO, 1e-15), "{turns}: {matrix}");
    }
}

/// A block of glass over water with a black table in it, `gap` apart, seen from above.
fn two_blocks(gap: f64) -> Description {
    let mut description = case("contact-depends-on-place/at0.toml");
    let Shape::Box { max, .. } = &mut description.objects.refractors_mut()[1].shape else {
        panic!("the pool is a box")
    };
    max.y = -gap;
    description
}

fn brightness(prepared: &Prepared, mode: Mode) -> f64 {
    mean(&render(prepared, mode, (8, 8), 16, None)).0
}

#[test]
fn contact_does_not_depend_on_place() {
    for name in ["at0", "at1"] {
        let prepared = ready(case(&format!("contact-depends-on-place/{name}.toml")));
        for mode in RIGHT {
            let found = brightness(&prepared, mode);
            assert!((found - IN_CONTACT).abs() < 2e-3, "{name}, {mode}: {found}");
        }
        // The twin: a mode that knows of no contacts meets both surfaces.
        let found = brightness(&prepared, Mode::Stack);
        assert!((found - IN_CONTACT).abs() > 0.02, "{name}: {found}");
    }
}

/// Gaps below 5e-7 of the smaller object's radius are closed, and gaps well above that are not, wherever the scene stands and whatever its size.
#[test]
fn what_is_in_contact_stays_so() {
    for motion in Motion::list() {
        for (gap, expected) in [(0.0, IN_CONTACT), (1e-9, IN_CONTACT), (1e-7, IN_CONTACT), (1e-5, APART), (1e-3, APART)]
        {
            let prepared = ready(motion.apply(&two_blocks(gap)));
            for mode in RIGHT {
                let found = brightness(&prepared, mode);
                assert!((found - expected).abs() < 4e-3, "gap {gap}, {motion:?}, {mode}: {found}, not {expected}");
            }
        }
    }
}

/// What the table says, but for numbers that scale.
type Row = (String, PatchKind, u32, Option<String>, Option<String>, Vec<String>);

fn rows(prepared: &Prepared) -> Vec<Row> {
    let scene = &*prepared.scene;
    let mut rows: Vec<Row> = (prepared.table.patches.iter())
        .map(|p| {
            let medium = |id| scene.medium(id).name.clone();
            let name = |id| scene.object(id).name.clone();
            let crossed_by = p.crossed_by.iter().map(|id| name(*id)).collect();
            (name(p.refractor), p.kind, p.faces, p.outside.map(medium), p.inside.map(medium), crossed_by)
        })
        .collect();
    rows.sort_by(|a, b| (&a.0, a.2, &a.3, &a.4, &a.5).cmp(&(&b.0, b.2, &b.3, &b.4, &b.5)));
    rows
}

/// Scenes whose surfaces cross, touch, coincide in part and as a whole, and come close.
fn scenes() -> Vec<(&'static str, Description)> {
    let cuboid = |min: [f64; 3], max: [f64; 3]| Shape::Box { min: min.into(), max: max.into() };
    let ball = |radius, subdivisions| Shape::Icosphere { center: DVec3::ZERO, radius, subdivisions };
    let cylinder = |y: f64| Shape::Cylinder { center: DVec3::new(0.1, y, 0.1), radius: 0.6, height: 1.0, segments: 24 };
    let of = |shapes: Vec<Shape>| {
        let mut description = empty(1.0);
        for (k, shape) in shapes.into_iter().enumerate() {
            add(&mut description, shape, 1.2 + 0.1 * k as f64, 0.0);
        }
        description.environment = Environment::Color([1.0; 3]);
        description.camera.position = DVec3::new(0.5, 2.0, 4.0);
        description.camera.target = DVec3::ZERO;
        description.camera.vertical_fov = 35.0;
        description
    };
    vec![
        ("panes and a post", case("false-coincident/scene.toml")),
        ("a cylinder on a box", of(vec![cuboid([-1.0, -1.0, -1.0], [1.0, 0.0, 1.0]), cylinder(0.5)])),
        ("a cylinder flush with a box", of(vec![cuboid([-1.0, -2.0, -1.0], [1.0, 0.0, 1.0]), cylinder(-0.5)])),
        (
            "balls half under water",
            of(vec![cuboid([-1.0, -1.0, -1.0], [1.0, 0.0, 1.0]), sphere(DVec3::splat(0.1), 0.5), ball(0.3, 1)]),
        ),
        ("thin shells", of(vec![ball(1.0, 2), ball(1.0 - 1e-5, 2), ball(0.5, 1)])),
        ("copies", of(vec![ball(1.0, 1), ball(1.0, 1), ball(1.0, 1), cuboid([-0.2, -1.5, -0.2], [0.2, 0.0, 0.2])])),
    ]
}

#[test]
fn a_moved_scene_has_the_same_table_and_image() {
    for (name, description) in scenes() {
        let still = ready(description.clone());
        let expected = rows(&still);
        let image = |prepared: &Prepared, mode| mean(&render(prepared, mode, (12, 12), 16, None)).0;
        let brightness = RIGHT.map(|mode| image(&still, mode));
        for (k, motion) in Motion::list().into_iter().enumerate() {
            let moved = ready(motion.apply(&description));
            assert_eq!(rows(&moved), expected, "{name}, {motion:?}");
            if k % 6 == 0 {
                for (mode, expected) in RIGHT.into_iter().zip(brightness) {
                    let found = image(&moved, mode);
                    assert!((found - expected).abs() < 0.01, "{name}, {motion:?}, {mode}: {found}, not {expected}");
                }
            }
        }
    }
}

/// An object elsewhere, however far, large or small, changes nothing about the others.
#[test]
fn a_bystander_changes_nothing() {
    for (name, description) in scenes() {
        let expected = rows(&ready(description.clone()));
        for (distance, radius) in [(10.0, 0.5), (1e3, 1.0), (1e6, 1e3), (2e12, 1.0), (2e12, 1e-2), (2e12, 1e11)] {
            for is_analytic in [false, true] {
                let mut more = description.clone();
                let center = DVec3::new(0.6, -0.8, 0.0) * distance;
                let shape = match is_analytic {
                    true => sphere(center, radius),
                    false => Shape::Icosphere { center, radius, subdivisions: 1 },
                };
                add(&mut more, shape, 1.9, 0.0);
                let bystander = more.objects.refractors().last().unwrap().name.clone();
                let mut found = rows(&ready(more));
                found.retain(|row| row.0 != bystander);
                assert_eq!(found, expected, "{name}, {distance}, {radius}");
            }
        }
    }
}

/// A wide floor beside small things does not take their digits either.
#[test]
fn a_wide_floor_changes_nothing() {
    for (gap, expected) in [(1e-9, IN_CONTACT), (1e-5, APART)] {
        let mut description = two_blocks(gap);
        let shape =
            Shape::Quad { center: DVec3::new(300.0, -1.5, 20.0), edge_u: DVec3::Z * 1e4, edge_v: DVec3::X * 1e4 };
        let floor = Object { name: "floor".into(), shape, ..description.objects.solids()[0].clone() };
        description.objects.push(floor);
        let prepared = ready(description);
        for mode in RIGHT {
            let found = brightness(&prepared, mode);
            assert!((found - expected).abs() < 4e-3, "gap {gap}, {mode}: {found}");
        }
    }
}

fn coincident(description: &Description) -> Vec<String> {
    let problems = check(&ready(description.clone()));
    problems.into_iter().filter(|problem| problem.kind == "coincident").map(|problem| problem.place).collect()
}

/// Two objects are said to have the same surface only if they have.
#[test]
fn copies_are_told_from_what_is_flush() {
    let panes = case("false-coincident/scene.toml");
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        let mut description = panes.clone();
        description.objects.clear(Kind::Refractor);
        order.into_iter().for_each(|k| description.objects.push(panes.objects.refractors()[k].clone()));
        for motion in [STILL, Motion { turns: 1, scale: 0.3, offset: DVec3::new(7.0, -3.0, 0.1) }] {
            assert_eq!(coincident(&motion.apply(&description)), [""; 0], "{order:?}, {motion:?}");
        }
        // The twin: with one of them twice, those two.
        let mut twice = description.clone();
        let mut copy = twice.objects.refractors()[1].clone();
        copy.name = "copy".into();
        twice.objects.push(copy);
        assert_eq!(coincident(&twice).len(), 1, "{order:?}");
    }
    // The same surface in other faces.
    let cuboid = Shape::Box { min: DVec3::splat(-1.0), max: DVec3::ONE };
    let whole = iorect::scene::shapes::tessellate(&cuboid).unwrap().unwrap();
    let mut finer = Mesh { normals: Vec::new(), triangles: Vec::new(), ..whole.clone() };
    for t in &whole.triangles {
        let corners = t.map(|i| whole.positions[i as usize]);
        // A point inside each face, nearer to one corner.
        let inner = corners[0] * 0.5 + corners[1] * 0.25 + corners[2] * 0.25;
        let k = finer.positions.len() as u32;
        finer.positions.push(inner);
        finer.triangles.extend([[t[0], t[1], k], [t[1], t[2], k], [t[2], t[0], k]]);
    }
    let mut description = empty(1.0);
    add(&mut description, cuboid, 1.5, 0.0);
    add(&mut description, Shape::mesh("made.ply", finer), 1.4, 0.0);
    assert_eq!(coincident(&description).len(), 1);
    // Larger by a tenth on one side, it is another.
    description.objects.refractors_mut()[1].transform.scale.x = 1.1;
    assert_eq!(coincident(&description), [""; 0]);
}
