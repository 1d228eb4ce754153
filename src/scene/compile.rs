//! From a description to a [`Scene`].

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

use super::declared::Declared;
use super::description::{self, Description, Emission, Environment, MAX_RADIANCE, Quantity, Role, Shape, Transform};
use super::emission;
use super::error::SceneError;
use super::lights::{Emitters, EnvironmentLight};
use super::needs::SceneNeeds;
use super::scene::{Albedo, Interfaces, MediumId, Object, ObjectId, Scene, SceneMedium, Surface};
use super::shapes::{self, MIN_LENGTH};
use super::texture::{SurfaceTexture, TextureCoordinates};
use crate::geometry::topology::MAX_FACES;
use crate::geometry::{Enclosure, Frame, Geometry, Mesh, ObjectRange, Part, Topology, WindingTree};
use crate::optics::ior::IOR_RANGE;
use crate::optics::{Ior, medium};
use crate::spectrum::{Spectrum, WAVELENGTH_D_UM};

/// Least radius of a sphere relative to a coordinate of its centre: a few roundings.
const LEAST_RADIUS: f64 = 8.0 * f64::EPSILON;

/// Compiles `description`. With `previous`, the description and scene compiled before it, geometry is kept where no shape has changed.
///
/// # Errors
/// When an IOR, an absorption or a shape is impossible, or a medium is unknown. The loader finds such things with their line; this is
/// for descriptions edited or made in memory.
pub fn compile(description: &Description, previous: Option<(&Description, &Scene)>) -> Result<Scene, SceneError> {
    require_radiances(description)?;
    let media = compile_media(description)?;
    let is_same = |before| changed_objects(before, description).is_some_and(|changed| changed.is_empty());
    let kept = previous.filter(|(before, _)| is_same(before)).map(|(_, scene)| scene);
    let (geometry, bodies, topology_secs) = match kept {
        Some(scene) => (Arc::clone(&scene.geometry), scene.objects.iter().map(Body::of_object).collect(), 0.0),
        None => {
            let start = Instant::now();
            let analyses = analyse(description, previous)?;
            let topology_secs = start.elapsed().as_secs_f64();
            let parts = parts(description, &analyses)?;
            let analyses = analyses.into_iter().chain(std::iter::repeat(None));
            let mut bodies: Vec<Body> = (description.objects.iter().zip(&parts).zip(analyses))
                .map(|((object, part), topology)| Body::new(object, part, topology))
                .collect();
            // Digits are wanted where media are told apart.
            let frame = Frame::about(&parts[..description.objects.refractors().len()]).or_else(|| Frame::about(&parts));
            let earlier = previous.map(|(_, scene)| &*scene.geometry);
            let geometry = Arc::new(Geometry::build_in(frame.unwrap_or_default(), parts, earlier));
            for (object, body) in bodies.iter_mut().enumerate().filter(|(_, body)| body.enclosure == Enclosure::Holed) {
                body.winding = Some(Arc::new(winding_tree(&geometry, object as u32)));
            }
            (geometry, bodies, topology_secs)
        }
    };
    require_distinct_spheres(description, &geometry)?;
    let known = media_by_name(description);
    let declared = Declared::new(description, |name| known.get(name).copied())?;
    let objects = objects(description, previous, &geometry, bodies, &known)?;
    let environment = match previous {
        // An image's sampling tables are worth keeping.
        Some((before, scene)) if is_same_environment(&before.environment, &description.environment) => {
            scene.environment.clone()
        }
        _ => EnvironmentLight::new(&description.environment),
    };
    let emitters = Emitters::new(&geometry, emission::emitters(description, &geometry, &objects));
    let needs = SceneNeeds::of(&geometry, &objects, &media, &emitters, &environment);
    let world_is_vacuum = media[0].ior_minus_one == 0.0 && media[0].absorption.is_black();
    let refractors_that = |enclosure: Enclosure| {
        (objects.iter().enumerate())
            .filter(|(_, o)| o.enclosure == enclosure && matches!(o.surface, Surface::Refractor { .. }))
            .map(|(index, _)| ObjectId(index as u32))
            .collect::<Vec<_>>()
    };
    let (holed, has_sheets) = (refractors_that(Enclosure::Holed), !refractors_that(Enclosure::Sheet).is_empty());
    Ok(Scene {
        geometry,
        objects,
        interfaces: Interfaces::new(&media),
        media,
        emitters,
        environment,
        needs,
        holed,
        has_sheets,
        world_is_vacuum,
        declared,
        topology_secs,
    })
}

/// Refuses radiance that sums and squares could not hold.
fn require_radiances(description: &Description) -> Result<(), SceneError> {
    let require_of = |what: &dyn Fn() -> String, quantity: Quantity, rgb: [f64; 3]| {
        if rgb.iter().all(|x| (0.0..=MAX_RADIANCE).contains(x)) {
            return Ok(());
        }
        let ([r, g, b], what, quantity) = (rgb, what(), quantity.name());
        Err(SceneError::new(format!(
            "{what} has the {quantity} [{r:e}, {g:e}, {b:e}], each must be 0 or more and at most {MAX_RADIANCE:e}"
        )))
    };
    let require = |what: &dyn Fn() -> String, rgb: [f64; 3]| require_of(what, Quantity::Radiance, rgb);
    let environment = || "the environment".to_owned();
    match &description.environment {
        Environment::Color(color) => require(&environment, *color)?,
        Environment::Gradient { zenith, horizon, nadir } => {
            [zenith, horizon, nadir].into_iter().try_for_each(|color| require(&environment, *color))?;
        }
        Environment::Image { scale, .. } => require(&environment, [scale * f64::from(f32::MAX); 3])?,
    }
    (description.objects.iter()).try_for_each(|object| match &object.role {
        Role::Light(light) => {
            let Emission { quantity, rgb } = light.emission;
            require_of(&|| format!("light `{}`", object.name), quantity, rgb)
        }
        Role::Refractor(_) | Role::Solid(_) if !object.shape.has_surface() => {
            Err(SceneError::new(format!("`{}`: a {} needs a surface", object.name, object.kind().name())))
        }
        Role::Refractor(_) | Role::Solid(_) => Ok(()),
    })
}

fn compile_media(description: &Description) -> Result<Vec<SceneMedium>, SceneError> {
    let (world, vacuum) = (&description.world, Ior::Constant(1.0));
    let reserved = [(medium::WORLD, &world.ior, world.absorption), (medium::VACUUM, &vacuum, [0.0; 3])];
    let own = description.media.iter().map(|m| (&*m.name, &m.ior, m.absorption));
    reserved.into_iter().chain(own).map(|(name, ior, absorption)| compile_medium(name, ior, absorption)).collect()
}

fn compile_medium(name: &str, ior: &Ior, absorption: [f64; 3]) -> Result<SceneMedium, SceneError> {
    let ior_minus_one = ior.ior_minus_one(WAVELENGTH_D_UM);
    let (value, [r, g, b]) = (1.0 + ior_minus_one, absorption);
    let fault = |what: String| Err(SceneError::new(format!("medium `{name}`: {what}")));
    if !IOR_RANGE.contains(&value) {
        return fault(format!("the IOR is {value}, must be greater than 0 (from 1e-6 to 1e6)"));
    }
    if !absorption.iter().all(|a| a.is_finite() && *a >= 0.0) {
        return fault(format!("the absorption is [{r}, {g}, {b}], each must be 0 or more"));
    }
    Ok(SceneMedium { name: name.into(), model: ior.clone(), ior_minus_one, absorption: Spectrum::from_rgb(absorption) })
}

/// A refractor's mesh, and what is known of it; `None` for an analytic sphere.
type Analysis = Option<Arc<Topology>>;

/// The topology of every refractor. A shape that has been analysed, for this description or for the previous one, is not again.
fn analyse(description: &Description, previous: Option<(&Description, &Scene)>) -> Result<Vec<Analysis>, SceneError> {
    let mut known = Known::default();
    if let Some((before, scene)) = previous {
        for (refractor, object) in before.objects.refractors().iter().zip(&scene.objects) {
            if let Some(topology) = &object.topology {
                known.add(&refractor.name, &refractor.shape, topology);
            }
        }
    }
    (description.objects.refractors().iter())
        .map(|refractor| {
            if !refractor.visible {
                return Ok(None);
            }
            if let Some(topology) = known.find(&refractor.name, &refractor.shape) {
                return Ok(Some(topology));
            }
            let topology = match &refractor.shape {
                Shape::Sphere { .. } => None,
                Shape::Mesh { mesh, .. } => {
                    shapes::validate(&refractor.shape)
                        .map_err(|e| of_object(&refractor.name, SceneError::new(e.message)))?;
                    Some(Topology::of_mesh(mesh))
                }
                shape => {
                    let mesh = shapes::tessellate(shape).map_err(|error| of_object(&refractor.name, error))?;
                    Some(Topology::of_shape(&mesh.unwrap_or_default()))
                }
            };
            Ok(topology.map(Arc::new).inspect(|topology| known.add(&refractor.name, &refractor.shape, topology)))
        })
        .collect()
}

/// Shapes that have been analysed. Meshes are known by their identity, whoever uses them; other shapes by the name of their object.
#[derive(Default)]
struct Known<'a> {
    meshes: HashMap<*const Mesh, Arc<Topology>>,
    shapes: HashMap<&'a str, (&'a Shape, Arc<Topology>)>,
}

impl<'a> Known<'a> {
    fn add(&mut self, name: &'a str, shape: &'a Shape, topology: &Arc<Topology>) {
        match shape {
            Shape::Mesh { mesh, .. } => _ = self.meshes.insert(Arc::as_ptr(mesh), Arc::clone(topology)),
            _ => _ = self.shapes.insert(name, (shape, Arc::clone(topology))),
        }
    }

    fn find(&self, name: &str, shape: &Shape) -> Option<Arc<Topology>> {
        match shape {
            Shape::Mesh { mesh, .. } => self.meshes.get(&Arc::as_ptr(mesh)).cloned(),
            _ => self.shapes.get(name).filter(|(known, _)| *known == shape).map(|(_, topology)| Arc::clone(topology)),
        }
    }
}

/// Every object's surface in scene coordinates, in the order of object ids.
fn parts(description: &Description, analyses: &[Analysis]) -> Result<Vec<Part>, SceneError> {
    let mut triangles = 0;
    (description.objects.iter().zip(analyses.iter().chain(std::iter::repeat(&None))))
        .map(|(object, analysis)| {
            if !object.visible {
                // It keeps its id and has no primitives.
                return Ok(Part::Mesh { mesh: Mesh::default(), smooth: false });
            }
            let name = &object.name;
            if !object.shape.has_surface() {
                return bodiless(&object.shape, &object.transform).map_err(|error| of_object(name, error));
            }
            let repaired = analysis.as_ref().and_then(|topology| topology.repaired.as_deref());
            let part = part(&object.shape, repaired, &object.transform, object.is_smooth())
                .map_err(|error| of_object(name, error))?;
            if let Part::Mesh { mesh, .. } = &part {
                triangles += mesh.triangles.len().max(mesh.positions.len());
                if triangles > MAX_FACES {
                    return Err(SceneError::new(format!(
                        "up to `{name}` the objects have {triangles} triangles or vertices; at most {MAX_FACES} are allowed in a scene"
                    )));
                }
            }
            Ok(part)
        })
        .collect()
}

fn of_object(name: &str, error: SceneError) -> SceneError {
    SceneError { message: format!("`{name}`: {}", error.message), ..error }
}

/// What a light without a surface adds to the geometry: the place that it stands at, which must be within reach.
fn bodiless(shape: &Shape, transform: &Transform) -> Result<Part, SceneError> {
    shapes::validate(shape).map_err(|fault| SceneError::new(fault.message))?;
    let (Shape::Point { position } | Shape::Spot { position, .. }) = shape else {
        return Ok(Part::Mesh { mesh: Mesh::default(), smooth: false });
    };
    let position = transform.matrix().transform_point3(*position);
    if position.is_finite() && position.abs().max_element() <= 0.5 * f64::from(f32::MAX) {
        Ok(Part::Point(position))
    } else {
        Err(SceneError::new("its position is not a finite number, or too large, after the transform"))
    }
}

/// The surface of one object; `repaired` stands for the shape's own mesh.
fn part(shape: &Shape, repaired: Option<&Mesh>, transform: &Transform, smooth: bool) -> Result<Part, SceneError> {
    let matrix = transform.matrix();
    if let Shape::Sphere { center, radius } = shape {
        let scale = transform.scale.abs();
        if scale.x != scale.y || scale.x != scale.z {
            return Err(SceneError::new(
                "an analytic sphere cannot be scaled by different amounts along its axes; use an icosphere",
            ));
        }
        let (center, radius) = (matrix.transform_point3(*center), radius * scale.x);
        if !(center.is_finite() && radius.is_finite() && radius >= MIN_LENGTH) {
            return Err(SceneError::new(format!(
                "the sphere's radius is {radius:e}, must be a finite number and at least {MIN_LENGTH:e}"
            )));
        }
        return Ok(Part::Sphere { center, radius });
    }
    // What is left of a mesh after its repair may be nothing; what is given may not.
    let mut mesh = match repaired {
        Some(mesh) => mesh.clone(),
        None => shapes::tessellate(shape)?.unwrap_or_default(),
    };
    if smooth {
        mesh.ensure_normals();
    }
    transform_mesh(&mut mesh, &matrix);
    // The difference of two such coordinates is a finite f32 too.
    let is_within_reach = |p: &DVec3| p.is_finite() && p.abs().max_element() <= 0.5 * f64::from(f32::MAX);
    if !mesh.positions.par_iter().all(is_within_reach) {
        return Err(SceneError::new("a vertex is not a finite number, or too large, after the transform"));
    }
    let bounds = mesh.positions.par_iter().map(|p| (*p, *p));
    let bounds = bounds.reduce_with(|(min, max), (low, high)| (min.min(low), max.max(high)));
    if bounds.is_some_and(|(min, max)| (max - min).max_element() < MIN_LENGTH) {
        return Err(SceneError::new(format!("the mesh is smaller than {MIN_LENGTH:e} after the transform")));
    }
    Ok(Part::Mesh { mesh, smooth })
}

fn transform_mesh(mesh: &mut Mesh, matrix: &DAffine3) {
    if *matrix == DAffine3::IDENTITY {
        return;
    }
    mesh.positions.par_iter_mut().for_each(|p| *p = matrix.transform_point3(*p));
    let determinant = matrix.matrix3.determinant();
    // Cofactors: the inverse transpose up to scale, which carries the reversal of a mirroring too.
    let columns = [matrix.matrix3.x_axis, matrix.matrix3.y_axis, matrix.matrix3.z_axis];
    let cofactors =
        DMat3::from_cols(columns[1].cross(columns[2]), columns[2].cross(columns[0]), columns[0].cross(columns[1]))
            * determinant.signum();
    mesh.normals.par_iter_mut().for_each(|n| *n = (cofactors * *n).normalize_or(DVec3::Y));
    if determinant < 0.0 {
        // A mirrored mesh keeps its outside outside. Its normals already point there.
        mesh.turn_triangles();
    }
}

/// Refuses spheres so small for their place that all their points round to their centre.
fn require_distinct_spheres(description: &Description, geometry: &Geometry) -> Result<(), SceneError> {
    for (name, object) in description.objects.iter().map(|object| &object.name).zip(0..) {
        let Some(sphere) = geometry.sphere_of(object) else { continue };
        let distance = sphere.center.abs().max_element();
        if sphere.radius < distance * LEAST_RADIUS {
            return Err(SceneError::new(format!(
                "`{name}`: the sphere's radius is {:e} at {distance:e} from the middle of the scene, where numbers do not tell its points \
                 apart; must be at least {:e}",
                sphere.radius,
                distance * LEAST_RADIUS
            )));
        }
    }
    Ok(())
}

/// What is kept of an object as long as the geometry is.
struct Body {
    volume: f64,
    enclosure: Enclosure,
    topology: Option<Arc<Topology>>,
    winding: Option<Arc<WindingTree>>,
}

impl Body {
    /// Without its winding tree.
    fn new(object: &description::Object, part: &Part, topology: Analysis) -> Self {
        let volume = match (&topology, part) {
            (Some(topology), _) => topology.volume * object.transform.matrix().matrix3.determinant().abs(),
            // A sphere, or an object whose inside nothing asks for.
            (None, Part::Sphere { radius, .. }) => 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3),
            (None, Part::Mesh { mesh, .. }) => mesh.signed_volume().abs(),
            (None, Part::Point(_)) => 0.0,
        };
        let enclosure = topology.as_ref().map_or(Enclosure::Closed, |topology| topology.enclosure);
        Self { volume: if volume > 0.0 { volume } else { f64::INFINITY }, enclosure, topology, winding: None }
    }

    fn of_object(object: &Object) -> Self {
        let (topology, winding) = (object.topology.clone(), object.winding.clone());
        Self { volume: object.volume, enclosure: object.enclosure, topology, winding }
    }
}

fn winding_tree(geometry: &Geometry, object: u32) -> WindingTree {
    let triangles: Vec<[DVec3; 3]> = match geometry.range(object) {
        ObjectRange::Triangles(range) => range.clone().map(|triangle| geometry.corners(triangle)).collect(),
        ObjectRange::Sphere(_) => Vec::new(),
    };
    WindingTree::build(&triangles)
}

fn media_by_name(description: &Description) -> HashMap<&str, MediumId> {
    // Of media of one name, which the loader refuses, the first.
    let mut media = HashMap::with_capacity(description.media.len());
    for (medium, index) in description.media.iter().zip(2..) {
        media.entry(&*medium.name).or_insert(MediumId(index));
    }
    media
}

fn objects(
    description: &Description,
    previous: Option<(&Description, &Scene)>,
    geometry: &Geometry,
    bodies: Vec<Body>,
    media: &HashMap<&str, MediumId>,
) -> Result<Vec<Object>, SceneError> {
    // There is a body for each object.
    (description.objects.iter().zip(bodies).zip(0..))
        .map(|((object, Body { volume, enclosure, topology, winding }), index)| {
            let surface = match &object.role {
                Role::Refractor(refractor) => {
                    let medium = *media.get(refractor.medium.as_str()).ok_or_else(|| {
                        let valid: Vec<&str> = description.media.iter().map(|m| m.name.as_str()).collect();
                        SceneError::new(format!(
                            "refractor `{}`: unknown medium `{}`; valid: {}",
                            object.name,
                            refractor.medium,
                            valid.join(", ")
                        ))
                    })?;
                    let (priority, smooth) = (refractor.priority, refractor.smooth);
                    Surface::Refractor { medium, priority, smooth }
                }
                Role::Solid(solid) => {
                    let albedo = albedo(&solid.paint, object, previous, geometry, index)?;
                    let smooth = solid.smooth;
                    if solid.mirror { Surface::Mirror { albedo, smooth } } else { Surface::Diffuse { albedo, smooth } }
                }
                Role::Light(light) => Surface::Light {
                    radiance: emission::surface_radiance(object, light, geometry.area(index))?,
                    two_sided: light.two_sided,
                },
            };
            Ok(Object { name: object.name.clone(), surface, volume, enclosure, topology, winding })
        })
        .collect()
}

/// Of the solid with that id.
fn albedo(
    paint: &description::Paint,
    object: &description::Object,
    previous: Option<(&Description, &Scene)>,
    geometry: &Geometry,
    id: u32,
) -> Result<Albedo, SceneError> {
    let description::Object { shape, transform, .. } = object;
    Ok(match *paint {
        description::Paint::Color(color) => Albedo::Color(Spectrum::from_rgb(color)),
        description::Paint::Checker { a, b, size } => {
            let (corner, u, v) = match shape {
                Shape::Quad { center, edge_u, edge_v } => {
                    (*center - *edge_u / 2.0 - *edge_v / 2.0, edge_u.normalize_or_zero(), edge_v.normalize_or_zero())
                }
                _ => (DVec3::ZERO, DVec3::X, DVec3::Z),
            };
            let world_from_object = transform.matrix();
            // A plane's coordinate transforms by the inverse transpose.
            let plane_from_object = world_from_object.matrix3.inverse().transpose();
            Albedo::Checker {
                a: Spectrum::from_rgb(a),
                b: Spectrum::from_rgb(b),
                origin: world_from_object.transform_point3(corner) - geometry.origin,
                u_axis: plane_from_object * u / size,
                v_axis: plane_from_object * v / size,
            }
        }
        description::Paint::Texture { ref image, tint, uv, .. } => {
            let matrix = transform.matrix().matrix3;
            let coordinates = match geometry.range(id) {
                ObjectRange::Sphere(_) => TextureCoordinates::Spherical { object_from_world: matrix.inverse() },
                ObjectRange::Triangles(range) => {
                    let mesh = match shape {
                        Shape::Mesh { mesh, .. } => Arc::clone(mesh),
                        shape => match known_coordinates(shape, previous, id) {
                            Some(known) => known,
                            None => Arc::new(shapes::tessellate_with_uvs(shape)?.unwrap_or_default()),
                        },
                    };
                    if !(range.is_empty() || mesh.has_uvs() && mesh.uvs.len() == range.len()) {
                        let message = "its mesh has no texture coordinates, so no texture can be laid on it";
                        return Err(of_object(&object.name, SceneError::new(message)));
                    }
                    let is_mirrored = matrix.determinant() < 0.0;
                    TextureCoordinates::Triangles { first: range.start, mesh, is_mirrored }
                }
            };
            Albedo::Texture(Arc::new(SurfaceTexture {
                image: Arc::clone(image),
                tint: Spectrum::from_rgb(tint),
                coordinates,
                transform: uv.matrix(),
            }))
        }
    })
}

/// The mesh with texture coordinates that the object of that id had before, if its shape is the same: others may know it.
fn known_coordinates(shape: &Shape, previous: Option<(&Description, &Scene)>, id: u32) -> Option<Arc<Mesh>> {
    let (before, scene) = previous?;
    let is_same = before.objects.get(id as usize).is_some_and(|object| object.shape == *shape);
    match &scene.albedo(ObjectId(id)).filter(|_| is_same)?.texture()?.coordinates {
        TextureCoordinates::Triangles { mesh, .. } => Some(Arc::clone(mesh)),
        TextureCoordinates::Spherical { .. } => None,
    }
}

/// The objects whose primitives differ between two descriptions, in ascending order; `None` where the objects themselves are others.
pub fn changed_objects(a: &Description, b: &Description) -> Option<Vec<ObjectId>> {
    let is_same = |a: &description::Object, b: &description::Object| -> bool {
        (a.transform, a.is_smooth(), a.visible) == (b.transform, b.is_smooth(), b.visible)
            && has_same_part(&a.shape, &b.shape)
    };
    let has_same_kinds =
        a.objects.iter().map(description::Object::kind).eq(b.objects.iter().map(description::Object::kind));
    has_same_kinds.then(|| {
        (a.objects.iter().zip(&*b.objects).zip(0..))
            .filter(|((a, b), _)| !is_same(a, b))
            .map(|(_, index)| ObjectId(index))
            .collect()
    })
}

/// Whether two scenes look the same from everywhere: all that decides an image but the camera is equal. Meshes and images that are not the
/// same allocation are taken to be different.
pub fn looks_the_same(a: &Description, b: &Description) -> bool {
    a.world == b.world
        && a.camera_medium == b.camera_medium
        && a.media == b.media
        && is_same_environment(&a.environment, &b.environment)
        && changed_objects(a, b).is_some_and(|changed| changed.is_empty())
        && a.objects.iter().zip(&*b.objects).all(|(a, b)| a.role == b.role && is_same_shape(&a.shape, &b.shape))
}

fn is_same_shape(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        // Meshes are large and shared: the same one, or taken to be different.
        (Shape::Mesh { mesh: a, .. }, Shape::Mesh { mesh: b, .. }) => Arc::ptr_eq(a, b),
        _ => a == b,
    }
}

/// Whether shapes leave the same in the geometry: a light without a surface its place and no more.
fn has_same_part(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::Spot { position: a, .. }, Shape::Spot { position: b, .. }) => a == b,
        (Shape::Directional { .. }, Shape::Directional { .. }) => true,
        _ => is_same_shape(a, b),
    }
}

fn is_same_environment(a: &Environment, b: &Environment) -> bool {
    match (a, b) {
        (
            Environment::Image { image: a, rotation: ra, scale: sa, .. },
            Environment::Image { image: b, rotation: rb, scale: sb, .. },
        ) => Arc::ptr_eq(a, b) && ra == rb && sa == sb,
        _ => a == b,
    }
}
