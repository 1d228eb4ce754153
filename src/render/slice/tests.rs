use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::*;
use crate::formats;
use crate::tracking::prepare;

const CAMERA: &str = "[camera]\nposition = [0, 0, 10]\ntarget = [0, 0, 0]\nvertical_fov = 40\n";
const MEDIA: [(&str, f64); 3] = [("water", 1.333), ("glass", 1.5), ("ice", 1.31)];

/// A scene of refractors: (name, medium, priority, shape).
fn scene_of(world_ior: f64, refractors: &[(&str, &str, i32, &str)], rest: &str) -> Prepared {
    let mut text = format!("{CAMERA}[world]\nior = {world_ior}\n");
    for (name, ior) in MEDIA {
        writeln!(text, "[[medium]]\nname = \"{name}\"\nior = {ior}").unwrap();
    }
    for (name, medium, priority, shape) in refractors {
        writeln!(
            text,
            "[[refractor]]\nname = \"{name}\"\nmedium = \"{medium}\"\npriority = {priority}\nshape = {shape}"
        )
        .unwrap();
    }
    text.push_str(rest);
    let description = formats::parse(&text, std::path::Path::new("slice.toml"), &formats::Disk).unwrap();
    prepare(Arc::new(description), None).unwrap()
}

fn medium(prepared: &Prepared, name: &str) -> MediumId {
    let at = prepared.scene.media.iter().position(|medium| medium.name == name).expect("the scene has this medium");
    MediumId(at as u32)
}

/// Planes across the origin along the axes and askew, and some beside it.
fn planes(height: f64) -> Vec<Plane> {
    let of = |normal: DVec3, up: DVec3, offset: f64| {
        let normal = normal.normalize();
        let right = up.cross(normal).normalize();
        Plane { center: normal * offset, right, up: normal.cross(right), height }
    };
    [0.0, 0.31]
        .into_iter()
        .flat_map(|offset| {
            [
                of(DVec3::Z, DVec3::Y, offset),
                of(DVec3::X, DVec3::Y, offset),
                of(DVec3::Y, -DVec3::Z, offset),
                of(DVec3::new(0.3, 0.5, 0.8), DVec3::Y, offset),
            ]
        })
        .collect()
}

fn cells(prepared: &Prepared, mode: Mode, plane: Plane, size: [u32; 2]) -> Vec<Cell> {
    let cut = Cut::new(prepared, mode, plane, size, &AtomicBool::new(false)).unwrap();
    (0..size[1]).flat_map(|y| cut.row(y, 1.0).collect::<Vec<_>>()).collect()
}

/// Compares every pixel with what is known of its place. `truth` gives the medium and the distance to the nearest surface.
fn require_true(
    prepared: &Prepared,
    mode: Mode,
    height: f64,
    tolerance: f64,
    truth: impl Fn(DVec3) -> (MediumId, f64),
) {
    let size = [66, 50];
    for plane in planes(height) {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        for (index, cell) in cells(prepared, mode, plane, size).into_iter().enumerate() {
            let pixel = DVec2::new((index % size[0] as usize) as f64, (index / size[0] as usize) as f64) + 0.5;
            let place = plane.place(aspect, pixel / DVec2::from(size.map(f64::from)));
            let (expected, distance) = truth(place);
            if distance > tolerance {
                assert_eq!(cell.filling, Filling::Medium(expected), "{mode} at {place} of {plane:?}");
                assert!(!cell.is_doubtful, "{mode} at {place} of {plane:?}");
            }
        }
    }
}

#[test]
fn nested_spheres_fill_rings() {
    let radii = [1.5, 1.0, 0.5];
    let shapes: Vec<String> =
        radii.iter().map(|r| format!("{{ sphere = {{ center = [0, 0, 0], radius = {r} }} }}")).collect();
    let ico: Vec<String> = radii
        .iter()
        .map(|r| format!("{{ icosphere = {{ center = [0, 0, 0], radius = {r}, subdivisions = 4 }} }}"))
        .collect();
    for shapes in [shapes, ico] {
        let refractors = [("a", "glass", 0, &*shapes[0]), ("b", "water", 0, &*shapes[1]), ("c", "ice", 0, &*shapes[2])];
        let prepared = scene_of(1.0, &refractors, "");
        let [glass, water, ice] = ["glass", "water", "ice"].map(|name| medium(&prepared, name));
        for mode in [Mode::Rectified, Mode::RectifiedObject, Mode::Reference] {
            require_true(&prepared, mode, 4.0, 0.02, |place| {
                let r = place.length();
                let distance = radii.iter().map(|radius| (radius - r).abs()).fold(f64::INFINITY, f64::min);
                (
                    if r < 0.5 {
                        ice
                    } else if r < 1.0 {
                        water
                    } else if r < 1.5 {
                        glass
                    } else {
                        MediumId::WORLD
                    },
                    distance,
                )
            });
        }
    }
}

#[test]
fn overlapping_boxes_belong_to_the_one_with_precedence() {
    let refractors = [
        ("low", "water", 0, "{ box = { min = [-1.5, -1, -1], max = [0.5, 1, 1] } }"),
        ("high", "glass", 3, "{ box = { min = [-0.5, -0.8, -0.9], max = [1.4, 0.9, 0.7] } }"),
    ];
    let prepared = scene_of(1.0, &refractors, "");
    let boxes = [
        (medium(&prepared, "glass"), DVec3::new(-0.5, -0.8, -0.9), DVec3::new(1.4, 0.9, 0.7)),
        (medium(&prepared, "water"), DVec3::new(-1.5, -1.0, -1.0), DVec3::new(0.5, 1.0, 1.0)),
    ];
    for mode in [Mode::Rectified, Mode::Reference] {
        require_true(&prepared, mode, 3.0, 5e-3, |place| {
            let inside = |(_, min, max): &&(MediumId, DVec3, DVec3)| min.cmplt(place).all() && place.cmplt(*max).all();
            let filling = boxes.iter().find(inside).map_or(MediumId::WORLD, |b| b.0);
            let sides = boxes.iter().flat_map(|(_, min, max)| [(place - *min).abs(), (place - *max).abs()]);
            (filling, sides.map(DVec3::min_element).fold(f64::INFINITY, f64::min))
        });
    }
}

#[test]
fn a_floating_ball_has_water_below_and_air_above() {
    let refractors = [
        ("pool", "water", 0, "{ box = { min = [-2, -2, -2], max = [2, 0, 2] } }"),
        ("ball", "glass", 1, "{ sphere = { center = [0, 0.1, 0], radius = 1 } }"),
    ];
    let prepared = scene_of(1.0, &refractors, "");
    let [glass, water] = ["glass", "water"].map(|name| medium(&prepared, name));
    for mode in [Mode::Rectified, Mode::Reference] {
        require_true(&prepared, mode, 5.0, 0.01, |place| {
            let ball = 1.0 - (place - DVec3::Y * 0.1).length();
            let pool = (DVec3::new(2.0, 1.0, 2.0) - (place + DVec3::Y).abs()).min_element();
            let filling = if ball > 0.0 {
                glass
            } else if pool > 0.0 {
                water
            } else {
                MediumId::WORLD
            };
            (filling, ball.abs().min(pool.abs()))
        });
    }
    // One exterior for the whole ball cannot be right on both sides of the water's surface, and naive is right nowhere around it.
    let plane = planes(5.0)[0];
    let share = |mode| {
        let slice = Slice::new(&prepared, mode, plane, [80, 60], 1.0, &AtomicBool::new(false)).unwrap();
        slice.doubtful_share()
    };
    assert_eq!(share(Mode::Rectified), 0.0);
    assert!(share(Mode::RectifiedObject) > 0.05, "{}", share(Mode::RectifiedObject));
    assert!(share(Mode::Naive) > 0.05, "{}", share(Mode::Naive));
}

#[test]
fn a_ball_without_a_piece_is_doubtful_beside_the_hole() {
    // A box without its lid.
    let obj = "v -1 -1 -1\nv 1 -1 -1\nv 1 -1 1\nv -1 -1 1\nv -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\n\
        f 1 2 3 4\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("box.obj"), obj).unwrap();
    let path = folder.path().join("box.obj");
    let shape = format!("{{ mesh = {:?} }}", path.display().to_string());
    let prepared = scene_of(1.0, &[("open", "glass", 0, &*shape)], "");
    let plane = planes(4.0)[0];
    let slice = Slice::new(&prepared, Mode::Rectified, plane, [60, 60], 1.0, &AtomicBool::new(false)).unwrap();
    assert!(slice.doubtful_share() > 0.01, "{}", slice.doubtful_share());
    let inside = probe(&prepared, Mode::Rectified, plane, [60, 60], [0.5, 0.6]).unwrap();
    assert_eq!(inside.cell.filling, Filling::Medium(medium(&prepared, "glass")));
    assert!(inside.testimonies.iter().filter(|testimony| testimony.object.is_some()).count() >= 3);
}

#[test]
fn the_world_is_where_nothing_else_is() {
    let shape = "{ sphere = { center = [0, 0, 0], radius = 1 } }";
    let prepared = scene_of(1.47, &[("ball", "glass", 0, shape)], "");
    let glass = medium(&prepared, "glass");
    let ball = |outside: MediumId| {
        move |place: DVec3| (if place.length() < 1.0 { glass } else { outside }, (place.length() - 1.0).abs())
    };
    require_true(&prepared, Mode::Rectified, 3.0, 5e-3, ball(MediumId::WORLD));
    require_true(&prepared, Mode::Naive, 3.0, 5e-3, ball(MediumId::VACUUM));
    assert_ne!(Ink::Medium(MediumId::VACUUM).color(), Ink::Medium(MediumId::WORLD).color());
    // Where the world is vacuum the two are one.
    let prepared = scene_of(1.0, &[("ball", "glass", 0, shape)], "");
    require_true(&prepared, Mode::Naive, 3.0, 5e-3, ball(MediumId::WORLD));
    // And without anything there is nothing else.
    let prepared = scene_of(1.2, &[], "");
    require_true(&prepared, Mode::Rectified, 3.0, 0.0, |_| (MediumId::WORLD, 1.0));
}

#[test]
fn solids_and_lights_lie_over_media() {
    let rest = "[[solid]]\nname = \"stone\"\nshape = { sphere = { center = [0, 0, 0], radius = 0.5 } }\ncolor = [0.5, 0.5, 0.5]\n\
        [[light]]\nname = \"lamp\"\nshape = { sphere = { center = [1, 0, 0], radius = 0.2 } }\nradiance = [1, 1, 1]\n\
        [[solid]]\nname = \"floor\"\nshape = { quad = { center = [0, -1.7, 0], edge_u = [0, 0, 4], edge_v = [4, 0, 0] } }\n\
        color = [0.5, 0.5, 0.5]\n";
    let prepared = scene_of(1.0, &[("ball", "glass", 0, "{ sphere = { center = [0, 0, 0], radius = 1.5 } }")], rest);
    let plane = planes(4.0)[0];
    let at = |x: f64, y: f64| {
        probe(&prepared, Mode::Rectified, plane, [50, 50], [0.5 + x / 4.0, 0.5 - y / 4.0]).unwrap().cell.filling
    };
    assert_eq!([at(0.0, 0.1), at(1.0, 0.1)], [Filling::Solid, Filling::Light]);
    assert_eq!(at(0.0, 1.0), Filling::Medium(medium(&prepared, "glass")));
    let cells = cells(&prepared, Mode::Rectified, plane, [50, 50]);
    let row = |y: f64| ((0.5 - y / 4.0) * 50.0) as usize;
    assert_eq!(cells[row(-1.7) * 50 + 25].edge, Some(Edge::Opaque), "the floor is a line");
    assert!(cells[row(-1.8) * 50 + 25].edge.is_none());
}

#[test]
fn every_colour_is_in_the_legend_and_every_picture_the_same() {
    let refractors = [
        ("pool", "water", 0, "{ box = { min = [-2, -2, -2], max = [2, 0, 2] } }"),
        ("ball", "glass", 1, "{ icosphere = { center = [0, 0, 0], radius = 1, subdivisions = 3 } }"),
        ("core", "ice", 2, "{ sphere = { center = [0.2, 0, 0], radius = 0.4 } }"),
    ];
    let prepared = scene_of(1.0, &refractors, "");
    for (plane, mode) in planes(5.0).into_iter().flat_map(|plane| SLICED_MODES.map(|mode| (plane, mode))) {
        let cut = || Slice::new(&prepared, mode, plane, [70, 50], 1.5, &AtomicBool::new(false)).unwrap();
        let slice = cut();
        let legend: BTreeSet<[u8; 3]> = slice.seen.iter().map(|(ink, _)| ink.color()).collect();
        assert_eq!(legend.len(), slice.seen.len(), "every entry has a colour of its own");
        assert_eq!(legend, slice.pixels.iter().copied().collect());
        assert_eq!(slice.seen.iter().map(|(_, count)| count).sum::<u64>(), 70 * 50);
        assert!(slice.seen.iter().all(|(ink, _)| !ink.label(&prepared).is_empty()));
        assert_eq!(slice, cut());
    }
}

/// What lies in the plane, and what it cuts along edges, is cut cleanly all the same.
#[test]
fn built_in_scenes_hold_no_doubt() {
    for name in ["iced-water", "half-submerged", "nested-spheres", "bubble-in-glass", "siblings", "camera-in-water"] {
        let prepared = prepare(Arc::new(formats::open(name).unwrap()), None).unwrap();
        for plane in planes(6.0) {
            let slice = Slice::new(&prepared, Mode::Rectified, plane, [90, 60], 1.0, &AtomicBool::new(false)).unwrap();
            assert!(slice.doubtful_share() < 2e-3, "{name}: {} of {plane:?}", slice.doubtful_share());
        }
    }
}

#[test]
fn a_cancelled_or_impossible_slice_is_none() {
    let prepared = scene_of(1.0, &[("ball", "glass", 0, "{ sphere = { center = [0, 0, 0], radius = 1 } }")], "");
    let plane = planes(3.0)[0];
    assert!(Slice::new(&prepared, Mode::Rectified, plane, [8, 8], 1.0, &AtomicBool::new(true)).is_none());
    for height in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let plane = Plane { height, ..plane };
        assert!(Slice::new(&prepared, Mode::Rectified, plane, [8, 8], 1.0, &AtomicBool::new(false)).is_none());
        assert!(probe(&prepared, Mode::Rectified, plane, [8, 8], [0.5; 2]).is_none());
    }
}

#[test]
fn a_place_and_its_point_in_the_picture_belong_together() {
    for plane in planes(3.0) {
        let (point, aspect) = (DVec2::new(0.3, 0.9), 1.4);
        let place = plane.place(aspect, point) + plane.normal() * 0.25;
        let (foot, distance) = plane.foot(aspect, place);
        assert!((foot - point).length() < 1e-12 && (distance - 0.25).abs() < 1e-12);
    }
}
