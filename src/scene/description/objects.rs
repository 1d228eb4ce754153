//! The objects of a scene: what all have in common, and what each role adds.

use std::ops::{Deref, DerefMut};
use std::path::PathBuf;
use std::sync::Arc;

use glam::DAffine2;

use super::shape::{Shape, Transform};
use crate::scene::texture::TextureImage;

/// An object of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    pub name: String,
    pub shape: Shape,
    pub transform: Transform,
    /// An invisible object is not there at all: nothing hits it, and it contains nothing.
    pub visible: bool,
    pub role: Role,
}

/// What an object is to light.
#[derive(Debug, Clone, PartialEq)]
pub enum Role {
    Refractor(Refractor),
    Solid(Solid),
    Light(Light),
}

/// A dielectric.
#[derive(Debug, Clone, PartialEq)]
pub struct Refractor {
    /// Name of the medium inside.
    pub medium: String,
    /// Higher wins where volumes overlap.
    pub priority: i32,
    /// Whether normals are interpolated over faces.
    pub smooth: bool,
    /// GGX's α along u and v, in [0, 1]; 0 is smooth. Kept for other renderers: it is rendered as smooth.
    pub roughness: [f64; 2],
    /// A wall without an inside, such as a pane of one sheet. Kept for other renderers: it is rendered as a body of its medium, or is hidden.
    pub thin: bool,
    /// What the scene declares to lie outside: a medium's name, or `world`. `None` says nothing. Only mode `declared` and `check` ask.
    pub outside: Option<String>,
}

/// Opaque and two-sided.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    pub paint: Paint,
    /// A perfect mirror, tinted by `paint`.
    pub mirror: bool,
    /// Of a mirror, as [`Refractor::roughness`].
    pub roughness: [f64; 2],
    /// Whether normals are interpolated over faces.
    pub smooth: bool,
}

/// Emitting: a surface, which is black and opaque, from its outward side, or a shape without a surface, which nothing meets.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    pub emission: Emission,
    /// Whether a surface emits from its inward side too.
    pub two_sided: bool,
    /// What the scene declares to lie around it, as in [`Refractor::outside`].
    pub outside: Option<String>,
}

/// How much a light emits, in the words of its author: in linear RGB, and in the medium that surrounds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission {
    pub quantity: Quantity,
    pub rgb: [f64; 3],
}

named! {
    /// What a light's numbers measure. Their names stand in scene files too.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Quantity {
        /// Of a surface, equal in all directions: W/(sr·m²) where the scene's unit of length is the metre.
        Radiance = "radiance",
        /// Of a point in all directions, or of a spot along its axis, in W/sr.
        Intensity = "intensity",
        /// Of a directional light, across its direction: W/m² likewise.
        Irradiance = "irradiance",
        /// All that a surface, a point or a spot emits, in W.
        Power = "power",
    }
}

/// Albedo of a solid, each component in [0, 1].
#[derive(Debug, Clone, PartialEq)]
pub enum Paint {
    Color([f64; 3]),
    /// Squares of side `size`: on quads by lengths along u and v from the corner, on other shapes by object x and z.
    Checker {
        a: [f64; 3],
        b: [f64; 3],
        size: f64,
    },
    /// An image by texture coordinates: those of a mesh, or of the shape (see [`crate::scene::shapes`]).
    Texture {
        /// As written in the file. `FILE#/images/N` is an image within a glTF file.
        path: PathBuf,
        image: Arc<TextureImage>,
        /// Multiplies the image.
        tint: [f64; 3],
        uv: UvTransform,
    },
}

/// What becomes of texture coordinates before an image is looked up: they are scaled, then turned about (0, 0), then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UvTransform {
    /// How often the image is there over the length of 1, along u and v; negative: mirrored.
    pub scale: [f64; 2],
    /// Degrees, counter-clockwise.
    pub rotate: f64,
    pub offset: [f64; 2],
}

impl UvTransform {
    pub const IDENTITY: Self = Self { scale: [1.0; 2], rotate: 0.0, offset: [0.0; 2] };

    /// The image's coordinates from the surface's.
    pub fn matrix(&self) -> DAffine2 {
        DAffine2::from_scale_angle_translation(self.scale.into(), self.rotate.to_radians(), self.offset.into())
    }

    /// What does the same as a matrix; `None` where it shears or flattens.
    pub fn of_matrix(matrix: &DAffine2) -> Option<Self> {
        let [x, y] = [matrix.matrix2.x_axis, matrix.matrix2.y_axis];
        let width = x.length();
        let height = matrix.matrix2.determinant() / width;
        let is_square = x.dot(y).abs() <= 1e-6 * width * y.length();
        let transform =
            Self { scale: [width, height], rotate: x.y.atan2(x.x).to_degrees(), offset: matrix.translation.to_array() };
        (width > 0.0 && height != 0.0 && is_square && matrix.is_finite()).then_some(transform)
    }
}

impl Paint {
    /// An image as it is.
    pub fn texture(path: impl Into<PathBuf>, image: Arc<TextureImage>) -> Self {
        Self::Texture { path: path.into(), image, tint: [1.0; 3], uv: UvTransform::IDENTITY }
    }

    /// The same multiplied by a colour, each component clipped to [0, 1].
    pub fn tinted(self, by: [f64; 3]) -> Self {
        let product = |color: [f64; 3]| [0, 1, 2].map(|k| (color[k] * by[k]).clamp(0.0, 1.0));
        match self {
            Self::Color(color) => Self::Color(product(color)),
            Self::Checker { a, b, size } => Self::Checker { a: product(a), b: product(b), size },
            Self::Texture { path, image, tint, uv } => Self::Texture { path, image, tint: product(tint), uv },
        }
    }

    /// Its colour, the mean where it has several.
    pub fn mean(&self) -> [f64; 3] {
        match self {
            Self::Color(color) => *color,
            Self::Checker { a, b, .. } => [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])),
            Self::Texture { image, tint, .. } => {
                let mean = image.mean();
                [0, 1, 2].map(|k| tint[k] * mean[k])
            }
        }
    }
}

named! {
    /// The roles without what they hold, in the order of object ids. Their names stand in scene files too.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Kind {
        Refractor = "refractor",
        Solid = "solid",
        Light = "light",
    }
}

impl Kind {
    pub const ALL: [Self; 3] = [Self::Refractor, Self::Solid, Self::Light];
}

impl Role {
    pub fn kind(&self) -> Kind {
        match self {
            Self::Refractor(_) => Kind::Refractor,
            Self::Solid(_) => Kind::Solid,
            Self::Light(_) => Kind::Light,
        }
    }
}

/// What each role gives to roles, objects and lists of objects alike.
macro_rules! roles {
    ($($role:ident: $one:ident, $one_mut:ident, $all:ident, $all_mut:ident;)*) => {
        $(
            impl From<$role> for Role {
                fn from(role: $role) -> Self {
                    Self::$role(role)
                }
            }

            impl Object {
                pub fn $one(&self) -> Option<&$role> {
                    if let Role::$role(role) = &self.role { Some(role) } else { None }
                }

                pub fn $one_mut(&mut self) -> Option<&mut $role> {
                    if let Role::$role(role) = &mut self.role { Some(role) } else { None }
                }
            }

            impl Objects {
                pub fn $all(&self) -> &[Object] {
                    self.of(Kind::$role)
                }

                pub fn $all_mut(&mut self) -> &mut [Object] {
                    let range = self.range(Kind::$role);
                    &mut self.0[range]
                }
            }
        )*
    };
}

roles! {
    Refractor: refractor, refractor_mut, refractors, refractors_mut;
    Solid: solid, solid_mut, solids, solids_mut;
    Light: light, light_mut, lights, lights_mut;
}

impl Refractor {
    /// Of priority 0, smooth, with flat faces, and with nothing said about its outside.
    pub fn of(medium: impl Into<String>) -> Self {
        Self { medium: medium.into(), priority: 0, smooth: false, roughness: [0.0; 2], thin: false, outside: None }
    }
}

impl Light {
    /// One-sided.
    pub fn of(quantity: Quantity, rgb: [f64; 3]) -> Self {
        Self { emission: Emission { quantity, rgb }, two_sided: false, outside: None }
    }

    /// One-sided, of that radiance.
    pub fn of_radiance(rgb: [f64; 3]) -> Self {
        Self::of(Quantity::Radiance, rgb)
    }

    /// Whether it emits nothing.
    pub fn is_black(&self) -> bool {
        self.emission.rgb == [0.0; 3]
    }
}

impl Solid {
    /// Diffuse and with flat faces.
    pub fn of(paint: Paint) -> Self {
        Self { paint, mirror: false, roughness: [0.0; 2], smooth: false }
    }
}

impl Object {
    /// A visible object where its shape stands.
    pub fn new(name: impl Into<String>, shape: Shape, role: impl Into<Role>) -> Self {
        Self { name: name.into(), shape, transform: Transform::IDENTITY, visible: true, role: role.into() }
    }

    pub fn kind(&self) -> Kind {
        self.role.kind()
    }

    /// GGX's α along u and v.
    pub fn roughness(&self) -> [f64; 2] {
        match &self.role {
            Role::Refractor(refractor) => refractor.roughness,
            Role::Solid(solid) if solid.mirror => solid.roughness,
            Role::Solid(_) | Role::Light(_) => [0.0; 2],
        }
    }

    /// What the scene declares to lie outside.
    pub fn outside(&self) -> Option<&str> {
        match &self.role {
            Role::Refractor(Refractor { outside, .. }) | Role::Light(Light { outside, .. }) => outside.as_deref(),
            Role::Solid(_) => None,
        }
    }

    /// Where that is said; `None` of an object that has no say.
    pub fn outside_mut(&mut self) -> Option<&mut Option<String>> {
        match &mut self.role {
            Role::Refractor(Refractor { outside, .. }) | Role::Light(Light { outside, .. }) => Some(outside),
            Role::Solid(_) => None,
        }
    }

    /// Whether normals are interpolated over faces.
    pub fn is_smooth(&self) -> bool {
        match &self.role {
            Role::Refractor(refractor) => refractor.smooth,
            Role::Solid(solid) => solid.smooth,
            Role::Light(_) => false,
        }
    }
}

/// All objects of a scene, in the order of object ids: by role, and of one role in file order, which breaks ties between overlapping
/// volumes. An object's role may be edited in its place, but not become another.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Objects(Vec<Object>);

impl Objects {
    /// Adds an object behind the others of its role.
    pub fn push(&mut self, object: Object) {
        let end = self.0.partition_point(|o| o.kind() <= object.kind());
        self.0.insert(end, object);
    }

    pub fn remove(&mut self, index: usize) -> Object {
        self.0.remove(index)
    }

    pub fn retain(&mut self, is_kept: impl FnMut(&Object) -> bool) {
        self.0.retain(is_kept);
    }

    /// Removes all objects of one role.
    pub fn clear(&mut self, kind: Kind) {
        self.retain(|object| object.kind() != kind);
    }

    pub fn of(&self, kind: Kind) -> &[Object] {
        &self.0[self.range(kind)]
    }

    fn range(&self, kind: Kind) -> std::ops::Range<usize> {
        self.0.partition_point(|o| o.kind() < kind)..self.0.partition_point(|o| o.kind() <= kind)
    }

    /// What makes the refractors refractors, in their order.
    pub fn refractor_roles(&self) -> impl DoubleEndedIterator<Item = &Refractor> {
        self.iter().filter_map(Object::refractor)
    }

    pub fn refractor_roles_mut(&mut self) -> impl DoubleEndedIterator<Item = &mut Refractor> {
        self.iter_mut().filter_map(Object::refractor_mut)
    }

    pub fn find(&self, name: &str) -> Option<&Object> {
        self.iter().find(|object| object.name == name)
    }

    pub fn find_mut(&mut self, name: &str) -> Option<&mut Object> {
        self.iter_mut().find(|object| object.name == name)
    }
}

impl Deref for Objects {
    type Target = [Object];

    fn deref(&self) -> &[Object] {
        &self.0
    }
}

impl DerefMut for Objects {
    fn deref_mut(&mut self) -> &mut [Object] {
        &mut self.0
    }
}

impl FromIterator<Object> for Objects {
    /// Those of one role stay in their order.
    fn from_iter<I: IntoIterator<Item = Object>>(objects: I) -> Self {
        let mut objects: Vec<Object> = objects.into_iter().collect();
        objects.sort_by_key(Object::kind);
        Self(objects)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    #[test]
    fn a_transform_of_texture_coordinates_is_that_of_its_matrix() {
        for scale in [[1.0, 1.0], [2.0, -3.0], [0.5, 4.0]] {
            for rotate in [0.0, 90.0, -30.0] {
                let made = UvTransform { scale, rotate, offset: [0.25, -2.0] };
                let again = UvTransform::of_matrix(&made.matrix()).unwrap().matrix();
                assert!(again.abs_diff_eq(made.matrix(), 1e-12), "{made:?}");
            }
        }
        let quarter = UvTransform { scale: [2.0, 1.0], rotate: 90.0, offset: [0.5, 0.0] };
        assert!(quarter.matrix().transform_point2(DVec2::new(1.0, 0.0)).abs_diff_eq(DVec2::new(0.5, 2.0), 1e-12));
        let shear = glam::DMat2::from_cols(DVec2::X, DVec2::ONE);
        assert_eq!(UvTransform::of_matrix(&DAffine2::from_mat2(shear)), None);
    }

    #[test]
    fn objects_stand_by_role_and_in_their_order() {
        let shape = Shape::Sphere { center: DVec3::ZERO, radius: 1.0 };
        let light = |name: &str| Object::new(name, shape.clone(), Light::of_radiance([1.0; 3]));
        let solid = |name: &str| Object::new(name, shape.clone(), Solid::of(Paint::Color([0.5; 3])));
        let refractor = |name: &str| Object::new(name, shape.clone(), Refractor::of("glass"));
        let names = |objects: &[Object]| objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>().join(" ");
        let all = || [light("a"), refractor("b"), solid("c"), light("d"), refractor("e")];
        let mut objects = Objects::default();
        all().into_iter().for_each(|object| objects.push(object));
        assert_eq!(objects, all().into_iter().collect());
        assert_eq!(names(&objects), "b e c a d");
        assert_eq!(names(objects.refractors()), "b e");
        assert_eq!(names(objects.solids()), "c");
        assert_eq!(names(objects.lights()), "a d");
        objects.clear(Kind::Solid);
        assert_eq!((names(&objects).as_str(), objects.solids().len()), ("b e a d", 0));
        assert_eq!(objects.find("d").map(Object::kind), Some(Kind::Light));
    }
}
