//! Mode `reference` on the kinds of meshes that it was wrong about while it shared the analysis of the mode that it judges. Random ones of
//! the same kinds are in `random_meshes`.

use crate::common::{add, case, empty, mean, ready, render};
use glam::DVec3;
use iorect::scene::description::Shape;
use iorect::tracking::Mode;

/// The unions are cubes: the same paths go through a plain one. In a white furnace, a lossless one cannot be seen but for the noise of paths that
/// are caught in it.
#[test]
fn unions_that_are_cubes() {
    let mut cube = empty(1.0);
    add(&mut cube, Shape::Box { min: DVec3::ZERO, max: DVec3::ONE }, 1.5, 0.0);
    for name in ["parts-share-corners/scene.toml", "repeated-faces/scene.toml"] {
        let scene = ready(case(name));
        cube.camera = scene.description.camera;
        let plain = render(&ready(cube.clone()), Mode::Reference, (48, 48), 4, None);
        let film = render(&scene, Mode::Reference, (48, 48), 4, None);
        assert_eq!(film.events.total(), 0, "{name}: {:?}", film.events);
        let differs = |pixel: &usize| film.mean(*pixel).distance(plain.mean(*pixel)) > 1e-9;
        let differing = (0..film.sums.len()).filter(differs).count();
        assert_eq!(differing, 0, "{name}: of {} pixels", film.sums.len());
        let (mean, error) = mean(&film);
        assert!((mean - 1.0).abs() < 4.0 * error + 1e-9, "{name}: {mean} ± {error}");
    }
}
