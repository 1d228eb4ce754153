//! Scenes made in memory, and ways to ask them, shared by the whole-system tests.
#![allow(dead_code)]

pub mod truth;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use iorect::estimator::trace::{Follow, TracedPath, trace};
use iorect::geometry::{Ray, uniform_direction};
use iorect::optics::{IorModel, Medium};
use iorect::render::{Film, Prepared, RenderSettings, SPLITS, accumulate, prepare};
use iorect::scene::camera::Camera;
use iorect::scene::description::{
    CameraDescription, Description, Environment, Refractor, Shape, Transform, WorldMedium,
};
use iorect::tracking::Mode;

/// A scene in a white environment, with nothing in it.
pub fn empty(world_ior: f64) -> Description {
    Description {
        name: "test".into(),
        camera: CameraDescription {
            position: DVec3::new(0.0, 0.0, 10.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: 40.0,
            aperture_radius: 0.0,
            focus_distance: None,
        },
        world: WorldMedium { ior: IorModel::Constant(world_ior), absorption: [0.0; 3] },
        environment: Environment::Color([1.0; 3]),
        media: Vec::new(),
        refractors: Vec::new(),
        solids: Vec::new(),
        lights: Vec::new(),
        source: None,
    }
}

/// Adds a refractor with a medium of its own.
pub fn add(description: &mut Description, shape: Shape, ior: f64, absorption: f64) {
    let name = format!("object {}", description.refractors.len());
    description.media.push(Medium { name: name.clone(), ior: IorModel::Constant(ior), absorption: [absorption; 3] });
    description.refractors.push(Refractor {
        medium: name.clone(),
        name,
        shape,
        priority: 0,
        smooth: false,
        visible: true,
        transform: Transform::IDENTITY,
    });
}

pub fn sphere(center: DVec3, radius: f64) -> Shape {
    Shape::Sphere { center, radius }
}

/// Concentric spheres around the origin, outermost first.
pub fn nest(world_ior: f64, shells: &[(f64, f64)]) -> Description {
    let mut description = empty(world_ior);
    for &(radius, ior) in shells {
        add(&mut description, sphere(DVec3::ZERO, radius), ior, 0.0);
    }
    description
}

pub fn ready(description: Description) -> Prepared {
    prepare(Arc::new(description), None).expect("the scene is fine")
}

/// Traces straight through from outside, travelling along +x at height `b`.
pub fn through(prepared: &Prepared, mode: Mode, b: f64) -> TracedPath {
    trace(prepared, mode, Ray::new(DVec3::new(-10.0, b, 0.0), DVec3::X), Follow::Transmit, 0, None)
}

/// Angle in degrees by which a path that set out along +x at positive height was bent towards the axis, in (−180, 180].
pub fn deflection_degrees(path: &TracedPath) -> f64 {
    let [x, y, _] = path.final_direction;
    -y.atan2(x).to_degrees()
}

/// Renders and returns the film.
pub fn render(prepared: &Prepared, mode: Mode, size: (u32, u32), spp: u32, max_depth: Option<u32>) -> Film {
    let camera = Camera::new(&prepared.description.camera).expect("the camera is fine");
    let settings = RenderSettings { mode, seed: 1, max_depth, leave_out: true, splits: SPLITS };
    let mut film = Film::new(size.0, size.1);
    assert!(accumulate(prepared, &camera, &settings, &mut film, spp, &AtomicBool::new(false)));
    film
}

/// Mean over all pixels and the standard error of that mean, of the green component.
pub fn mean(film: &Film) -> (f64, f64) {
    let values: Vec<f64> = (0..film.sums.len()).map(|i| film.mean(i).y).collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// A small generator, so that the tests use the same numbers everywhere (Knuth's MMIX constants).
pub struct Numbers(pub u64);

impl Numbers {
    /// Uniform in [0, 1).
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as f64) / (1u64 << 31) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Uniform in 0..count.
    pub fn index(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }

    /// Uniform on the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let u = [self.next(), self.next()];
        uniform_direction(u)
    }

    /// Uniform in the box from `min` to `max`.
    pub fn point(&mut self, min: DVec3, max: DVec3) -> DVec3 {
        let u = DVec3::new(self.next(), self.next(), self.next());
        min + (max - min) * u
    }
}
