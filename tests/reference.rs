//! Mode `reference` on the kinds of meshes that it was wrong about while it shared the analysis of the mode that it judges. Random ones of
//! the same kinds are in `random_meshes`.

mod common;

use std::path::Path;

use common::{ready, render};
use glam::DVec3;
use iorect::estimator::trace::{Follow, trace};
use iorect::geometry::Ray;
use iorect::render::Prepared;
use iorect::scene::load;
use iorect::tracking::Mode;

fn scene(name: &str) -> Prepared {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cases").join(name);
    ready(load::open(path.to_str().unwrap()).unwrap())
}

/// A lossless object in a white furnace cannot be seen; an inner surface, or one that is missing, can, and is counted.
#[test]
fn unions_in_a_furnace() {
    for name in ["parts-share-corners/scene.toml", "repeated-faces/scene.toml"] {
        let film = render(&scene(name), Mode::Reference, (48, 48), 4, None);
        assert_eq!(film.events.total(), 0, "{name}: {:?}", film.events);
        for pixel in 0..film.sums.len() {
            assert!((film.mean(pixel) - 1.0).abs().max_element() < 1e-9, "{name}, pixel {pixel}: {}", film.mean(pixel));
        }
    }
}

#[test]
fn a_ring_with_seams_in_a_ball() {
    let scene = scene("torus-seam/nested.toml");
    let ray = Ray::new(DVec3::new(1.0, 0.1, 5.0), DVec3::NEG_Z);
    let path = trace(&scene, Mode::Reference, ray, Follow::Transmit, 0, None);
    let media: Vec<(&str, &str)> =
        path.vertices.iter().map(|v| (v.from.as_deref().unwrap(), v.to.as_deref().unwrap())).collect();
    assert_eq!(media, [("world", "water"), ("water", "glass"), ("glass", "water"), ("water", "world")]);
    assert_eq!(path.events.total(), 0);
}
