//! Scenes made in memory, and ways to ask them.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use crate::geometry::{Mesh, Ray, uniform_direction};
use crate::measure::statistics::{self, variance};
use crate::optics::{Ior, Medium};
use crate::render::{Estimator, Film, ImageSettings, RenderTask};
use crate::scene::SceneError;
use crate::scene::camera::Camera;
use crate::scene::description::{
    CameraDescription, Description, Environment, Light, Object, Objects, Refractor, Shape, WorldMedium,
};
use crate::scene::shapes::tessellate;
use crate::tracking::{Mode, Prepared, prepare};
use crate::transport::inspect::{Follow, TracedPath, trace};

/// A scene in a white environment, with nothing in it.
pub fn empty(world_ior: f64) -> Description {
    Description {
        name: "case".into(),
        camera: CameraDescription {
            position: DVec3::new(0.0, 0.0, 10.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: 40.0,
            aperture_radius: 0.0,
            focus_distance: None,
        },
        camera_medium: None,
        world: WorldMedium { ior: Ior::Constant(world_ior), absorption: [0.0; 3] },
        environment: Environment::Color([1.0; 3]),
        media: Vec::new(),
        objects: Objects::default(),
        source: None,
    }
}

/// Adds a refractor `object N` with a medium of its own, of the same name.
pub fn add(description: &mut Description, shape: Shape, ior: f64, absorption: f64) {
    let name = format!("object {}", description.objects.refractors().len());
    description.media.push(Medium { name: name.clone(), ior: Ior::Constant(ior), absorption: [absorption; 3] });
    description.objects.push(Object::new(name.clone(), shape, Refractor::of(name)));
}

pub fn sphere(center: DVec3, radius: f64) -> Shape {
    Shape::Sphere { center, radius }
}

/// Around the origin.
pub fn icosphere(radius: f64, subdivisions: u32) -> Shape {
    Shape::Icosphere { center: DVec3::ZERO, radius, subdivisions }
}

pub fn mesh_shape(mesh: Mesh) -> Shape {
    Shape::mesh("made.ply", Arc::new(mesh))
}

/// The triangles of a shape.
///
/// # Errors
/// When the shape is impossible. A sphere has no triangles.
pub fn mesh_of(shape: &Shape) -> Result<Mesh, SceneError> {
    let mesh = tessellate(shape)?.unwrap_or_default();
    Ok(Mesh { normals: Vec::new(), ..mesh })
}

/// Concentric spheres (radius, index) around the origin, outermost first.
pub fn nest(world_ior: f64, shells: &[(f64, f64)]) -> Description {
    let mut description = empty(world_ior);
    for &(radius, ior) in shells {
        add(&mut description, sphere(DVec3::ZERO, radius), ior, 0.0);
    }
    description
}

/// Wide boxes (top, bottom, index, absorption), each inside the one before or apart from it, outermost first; seen from above, in one
/// direction `degrees` from the vertical, over a lamp of radiance 1 in the dark: the image is the transmittance.
pub fn layers(boxes: &[(f64, f64, f64, f64)], degrees: f64) -> Description {
    let mut description = empty(1.0);
    for (index, &(top, bottom, ior, absorption)) in boxes.iter().enumerate() {
        let half = 1e5 - 100.0 * index as f64;
        let (min, max) = (DVec3::new(-half, bottom, -half), DVec3::new(half, top, half));
        add(&mut description, Shape::Box { min, max }, ior, absorption);
    }
    description.environment = Environment::Color([0.0; 3]);
    description.objects.push(level_lamp(-1000.0));
    let angle = degrees.to_radians();
    description.camera.position = DVec3::new(-angle.sin(), angle.cos(), 0.0) * 10.0;
    description.camera.up = DVec3::Z;
    description.camera.vertical_fov = 1e-6;
    description
}

/// A block below y = 0.
pub fn block(world_ior: f64, ior: f64) -> Description {
    let mut description = empty(world_ior);
    let (min, max) = (DVec3::new(-1.0, -2.0, -1.0), DVec3::new(1.0, 0.0, 1.0));
    add(&mut description, Shape::Box { min, max }, ior, 0.0);
    description
}

/// A ray that meets a [`block`] at the origin at cosine `c`, from far enough away that its start is not on the surface.
pub fn onto_block(c: f64) -> Ray {
    let direction = DVec3::new((1.0 - c * c).sqrt(), -c, 0.0).normalize();
    Ray::new(direction * -(1e-3 / c).max(10.0), direction)
}

/// A wide lamp of radiance 1 at this height, which shines towards height 0.
pub fn level_lamp(height: f64) -> Object {
    let (edge_u, edge_v) = (DVec3::Z * 4e5, DVec3::X * 4e5 * -height.signum());
    let shape = Shape::Quad { center: DVec3::Y * height, edge_u, edge_v };
    Object::new("lamp", shape, Light::of_radiance([1.0; 3]))
}

/// # Errors
/// When the scene is impossible.
pub fn ready(description: Description) -> Result<Prepared, SceneError> {
    prepare(Arc::new(description), None)
}

/// Traces straight through from outside, travelling along +x at height `b`; reflected only where reflection is total.
pub fn through(scene: &Prepared, mode: Mode, b: f64) -> TracedPath {
    trace(scene, mode, Ray::new(DVec3::new(-10.0, b, 0.0), DVec3::X), Follow::Transmit, 0, None)
}

/// Angle in degrees by which a path that set out along +x at positive height was bent towards the axis, in (−180, 180].
pub fn deflection_degrees(path: &TracedPath) -> f64 {
    let [x, y, _] = path.final_direction;
    -y.atan2(x).to_degrees()
}

/// Of `count` rays spread evenly over the disc of a unit ball, number `k`, along +x.
pub fn onto_disc(k: u32, count: u32) -> Ray {
    let b = ((f64::from(k) + 0.5) / f64::from(count)).sqrt();
    Ray::new(DVec3::new(-10.0, b, 0.0), DVec3::X)
}

/// A ray that meets the plane y = 0 at the origin, from above, at so many degrees.
pub fn downwards(degrees: f64) -> Ray {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Ray::new(DVec3::new(-sin, cos, 0.0), DVec3::new(sin, -cos, 0.0))
}

/// The interfaces of a path: names of the media before and after.
pub fn interfaces(path: &TracedPath) -> Vec<(&str, &str)> {
    (path.vertices.iter())
        .filter(|v| v.from != v.to)
        .map(|v| (v.from.as_deref().unwrap_or("nothing"), v.to.as_deref().unwrap_or("nothing")))
        .collect()
}

/// Renders by the scene's camera, on the CPU.
///
/// # Errors
/// When the camera is impossible.
pub fn render(
    scene: &Prepared,
    mode: Mode,
    size: (u32, u32),
    samples: u32,
    seed: u64,
    max_depth: Option<u32>,
) -> Result<Film, SceneError> {
    render_by(scene, Estimator::Path, mode, size, samples, seed, max_depth)
}

/// The same by any estimator.
///
/// # Errors
/// When the camera is impossible.
pub fn render_by(
    scene: &Prepared,
    estimator: Estimator,
    mode: Mode,
    size: (u32, u32),
    samples: u32,
    seed: u64,
    max_depth: Option<u32>,
) -> Result<Film, SceneError> {
    let camera = Camera::new(&scene.description.camera)?;
    let settings = ImageSettings { estimator, max_depth, ..ImageSettings::new(mode, seed) };
    let mut film = Film::new(size.0, size.1);
    let task = RenderTask { prepared: scene, camera: &camera, settings: &settings };
    // Never cancelled: these films take a fraction of a second.
    task.pass(&mut film, samples, &AtomicBool::new(false));
    Ok(film)
}

/// Samples for a mode: [`Mode::Reference`] asks for containment at every hit, which takes an order of magnitude longer.
pub fn samples_of(mode: Mode, samples: u32) -> u32 {
    if mode == Mode::Reference { samples.div_ceil(8) } else { samples }
}

/// Mean and its standard error of values that are independent.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let variance = variance(values).unwrap_or(f64::NAN);
    (statistics::mean(values).unwrap_or(f64::NAN), (variance / values.len() as f64).sqrt())
}

/// Mean over all pixels and its standard error, of the green component. For images whose pixels show the same: any structure counts as
/// noise.
pub fn mean(film: &Film) -> (f64, f64) {
    let values: Vec<f64> = (0..film.sums.len()).map(|pixel| film.mean(pixel).y).collect();
    mean_and_error(&values)
}

/// A small generator of numbers that are the same everywhere (Knuth's MMIX constants).
#[derive(Debug, Clone)]
pub struct Numbers(pub u64);

impl Numbers {
    /// Uniform in [0, 1).
    #[expect(clippy::should_implement_trait, reason = "numbers are drawn one at a time, not iterated over")]
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as f64) / (1u64 << 31) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    pub fn index(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }

    pub fn direction(&mut self) -> DVec3 {
        let u = [self.next(), self.next()];
        uniform_direction(u)
    }

    pub fn point(&mut self, min: DVec3, max: DVec3) -> DVec3 {
        let u = DVec3::new(self.next(), self.next(), self.next());
        min + (max - min) * u
    }
}
