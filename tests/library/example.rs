//! The library used as another program would: the example gives the sides of every face.

#[path = "../../examples/rectify.rs"]
#[expect(dead_code, reason = "its `main` is a program of its own")]
mod rectify;

use self::rectify::{cuboid, sides};
use glam::DVec3;

#[test]
fn every_face_has_both_of_its_sides() {
    let meshes = [
        ("glass", cuboid(DVec3::ZERO, DVec3::splat(2.0)), 1.5),
        ("water", cuboid(DVec3::ZERO, DVec3::splat(1.0)), 1.33),
        ("ice", cuboid(DVec3::ZERO, DVec3::splat(0.5)), 1.31),
    ];
    let faces = sides(1.0, meshes).unwrap();
    assert_eq!(faces.len(), 3 * 12);
    let around =
        [("world", 1.0), ("glass", 1.5), ("water", 1.33), ("ice", 1.31)].map(|(name, ior)| (name.to_owned(), ior));
    for (index, (object, middle, found)) in faces.iter().enumerate() {
        let shell = index / 12;
        assert_eq!(*found, [around[shell].clone(), around[shell + 1].clone()], "{object}");
        assert!((middle.abs().max_element() - [2.0, 1.0, 0.5][shell]).abs() < 1e-6, "{object}: {middle}");
    }
}

/// The twin: what lies half out of the water has another side above than below.
#[test]
fn sides_are_those_of_the_place() {
    let meshes =
        [("water", cuboid(DVec3::ZERO, DVec3::splat(1.0)), 1.33), ("ice", cuboid(DVec3::Y, DVec3::splat(0.5)), 1.31)];
    for (object, middle, [outside, inside]) in sides(1.0, meshes).unwrap() {
        if object == "ice" {
            assert_eq!(
                (outside.0.as_str(), inside.0.as_str()),
                (if middle.y > 1.0 { "world" } else { "water" }, "ice")
            );
        }
    }
}
