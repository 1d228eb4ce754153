//! The fields of every table of a scene: keys, defaults and limits. See [`super::fields`].

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

use super::camera::Camera;
use super::description::{
    CameraDescription, Environment, Kind, Light, MAX_RADIANCE, Object, Paint, Quantity, Refractor, Role, Shape, Solid,
    Transform, UvTransform, WorldMedium,
};
use super::environment::EnvironmentImage;
use super::error::Fault;
use super::fields::{ANY, Field, Limits, NON_NEGATIVE, POSITIVE, SHARE, Slot, Visitor};
use super::shapes::{self, DEFAULT_RINGS, DEFAULT_SEGMENTS, MAX_LENGTH, MIN_LENGTH};
use super::texture::TextureImage;
use crate::optics::{Ior, Medium};

/// Vertical field of view of a camera that gives none, in degrees.
pub const DEFAULT_VERTICAL_FOV: f64 = 40.0;
/// Albedo of a solid that gives none.
const DEFAULT_ALBEDO: [f64; 3] = [0.8; 3];

const RADIANCE: Limits =
    Limits { must: "0 or more, and at most 1e100", is_fine: |x| (0.0..=MAX_RADIANCE).contains(&x) };
/// Of texture coordinates: beyond it single precision knows no place within an image.
const UV: Limits = Limits { must: "between -1e6 and 1e6", is_fine: |x| x.abs() <= 1e6 };
const FIELD_OF_VIEW: Limits =
    Limits { must: "greater than 0 and less than 180 degrees", is_fine: |x| x > 0.0 && x < 180.0 };
/// Of an image: its brightest pixel, of f32, then stays below [`MAX_RADIANCE`].
const IMAGE_SCALE: Limits = Limits { must: "0 or more, and at most 1e60", is_fine: |x| (0.0..=1e60).contains(&x) };

impl CameraDescription {
    /// What a reader fills in.
    pub fn blank() -> Self {
        Self {
            position: DVec3::Z,
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: DEFAULT_VERTICAL_FOV,
            aperture_radius: 0.0,
            focus_distance: None,
        }
    }

    pub fn fields(&mut self, v: &mut dyn Visitor) {
        let Self { position, target, up, vertical_fov, aperture_radius, focus_distance } = self;
        v.need("position", position, ANY);
        v.need("target", target, ANY);
        v.optional("up", up, DVec3::Y, ANY);
        v.optional("vertical_fov", vertical_fov, DEFAULT_VERTICAL_FOV, FIELD_OF_VIEW);
        v.optional("aperture_radius", aperture_radius, 0.0, NON_NEGATIVE);
        v.optional("focus_distance", focus_distance, None, POSITIVE);
        v.check(&|| {
            Camera::new(self).map(|_| ()).map_err(|error| Fault { key: self.key_to_blame(), message: error.message })
        });
    }

    /// With what the scene declares the camera to be in.
    pub fn fields_in(&mut self, medium: &mut Option<String>, v: &mut dyn Visitor) {
        self.fields(v);
        v.maybe_medium("medium", medium);
    }

    /// Where it has no direction, or an `up` along it, or is too large.
    fn key_to_blame(&self) -> &'static str {
        let is_far = |point: DVec3| point.abs().max_element() > MAX_LENGTH;
        match *self {
            Self { position, .. } if is_far(position) => "position",
            Self { position, target, .. } if is_far(target) || position == target => "target",
            Self { aperture_radius, .. } if aperture_radius > MAX_LENGTH => "aperture_radius",
            Self { focus_distance: Some(distance), .. } if !(MIN_LENGTH..=MAX_LENGTH).contains(&distance) => {
                "focus_distance"
            }
            _ => "up",
        }
    }
}

impl WorldMedium {
    /// Of a scene that says nothing of it.
    pub const DEFAULT: Self = Self { ior: Ior::Constant(1.0), absorption: [0.0; 3] };

    pub fn fields(&mut self, v: &mut dyn Visitor) {
        let Self { ior, absorption } = self;
        v.optional("ior", ior, Ior::Constant(1.0), ANY);
        v.optional("absorption", absorption, [0.0; 3], NON_NEGATIVE);
    }
}

/// What a reader fills in.
pub fn blank_medium() -> Medium {
    Medium { name: String::new(), ior: Ior::Constant(1.0), absorption: [0.0; 3] }
}

pub fn medium_fields(medium: &mut Medium, v: &mut dyn Visitor) {
    let Medium { name, ior, absorption } = medium;
    v.slot("name", Slot::Name(name));
    v.need("ior", ior, ANY);
    v.optional("absorption", absorption, [0.0; 3], NON_NEGATIVE);
}

impl Environment {
    /// Of a scene that says nothing of it.
    pub const DEFAULT: Self = Self::Color([0.0; 3]);

    fn form(&self) -> &'static str {
        match self {
            Self::Color(_) => "color",
            Self::Gradient { .. } => "gradient",
            Self::Image { .. } => "image",
        }
    }

    fn blank(form: &str) -> Self {
        let black = EnvironmentImage { width: 1, height: 1, pixels: vec![[0.0; 3]], notes: Vec::new() };
        match form {
            "gradient" => Self::Gradient { zenith: [0.0; 3], horizon: [0.0; 3], nadir: [0.0; 3] },
            "image" => Self::Image { path: PathBuf::new(), image: Arc::new(black), rotation: 0.0, scale: 1.0 },
            _ => Self::DEFAULT,
        }
    }

    pub fn fields(&mut self, v: &mut dyn Visitor) {
        let form = v.form(&["color", "gradient", "image"], self.form(), None);
        if form != self.form() {
            *self = Self::blank(form);
        }
        match self {
            Self::Color(color) => _ = v.need("color", color, RADIANCE),
            Self::Gradient { zenith, horizon, nadir } => {
                v.table("gradient", |v| {
                    v.need("zenith", zenith, RADIANCE)
                        .need("horizon", horizon, RADIANCE)
                        .need("nadir", nadir, RADIANCE);
                });
            }
            Self::Image { path, image, rotation, scale } => {
                v.slot("image", Slot::Image { path, image });
                v.optional("rotation", rotation, 0.0, ANY).optional("scale", scale, 1.0, IMAGE_SCALE);
                return;
            }
        }
        for key in ["rotation", "scale"] {
            v.refuse(key, &format!("`{key}` belongs to an `image`, but this environment has a `{form}`"));
        }
    }
}

impl Object {
    /// What a reader fills in.
    pub fn blank(kind: Kind) -> Self {
        let role: Role = match kind {
            Kind::Refractor => Refractor::of("").into(),
            Kind::Solid => Solid::of(Paint::Color(DEFAULT_ALBEDO)).into(),
            Kind::Light => Light::of_radiance([0.0; 3]).into(),
        };
        Self::new("", Shape::blank("sphere"), role)
    }

    pub fn fields(&mut self, v: &mut dyn Visitor) {
        let kind = self.kind();
        let Self { name, shape, transform, visible, role } = self;
        v.slot("name", Slot::Name(name));
        match role {
            Role::Refractor(Refractor { medium, priority, smooth, roughness, thin, outside }) => {
                v.slot("medium", Slot::Medium(medium));
                v.optional("priority", priority, 0, ANY);
                v.roughness(roughness);
                v.optional("smooth", smooth, false, ANY);
                v.optional("thin", thin, false, ANY);
                v.maybe_medium("outside", outside);
            }
            Role::Solid(Solid { paint, mirror, roughness, smooth }) => {
                paint.fields(v);
                v.optional("mirror", mirror, false, ANY);
                if *mirror {
                    v.roughness(roughness);
                } else {
                    v.refuse("roughness", "`roughness` belongs to a mirror; set `mirror` to true or remove it");
                }
                v.optional("smooth", smooth, false, ANY);
            }
            Role::Light(light) => light.fields(shape, v),
        }
        match shape.light_form() {
            "shape" => _ = v.table("shape", |v| shape.fields(v)),
            form => {
                v.table(form, |v| shape.form_fields(v));
                v.check(&|| match kind {
                    Kind::Light => Ok(()),
                    _ => Fault::at("shape", format!("a {} needs a `shape`", kind.name())),
                });
            }
        }
        if let Role::Solid(Solid { paint, .. }) = &*role {
            v.check(&|| paint.validate(shape));
        }
        v.optional("visible", visible, true, ANY);
        let is_default = Some(*transform == Transform::IDENTITY);
        let slot = Slot::Table(&mut |v| transform.fields(v, shape));
        v.field(Field { key: "transform", slot, is_default });
    }
}

impl Light {
    /// Of a light of that shape, whose form is found out here.
    fn fields(&mut self, shape: &mut Shape, v: &mut dyn Visitor) {
        let form = v.form(&Shape::LIGHT_FORMS, shape.light_form(), None);
        let Self { emission, two_sided, outside } = self;
        if form != shape.light_form() {
            *shape = Shape::blank(form);
            emission.quantity = shape.quantity();
        }
        let own = shape.quantity();
        for other in [Quantity::Radiance, Quantity::Intensity, Quantity::Irradiance].into_iter().filter(|q| *q != own) {
            v.refuse(
                other.name(),
                &format!("`{}` is not what a `{form}` has; give its `{}`", other.name(), own.name()),
            );
        }
        if form == "directional" {
            v.refuse("power", "a `directional` light has no `power` of its own; give its `irradiance`");
        }
        let choice = [own.name(), Quantity::Power.name()];
        let forms = if form == "directional" { &choice[..1] } else { &choice[..] };
        emission.quantity = match v.form(forms, emission.quantity.name(), Some(own.name())) {
            "power" => Quantity::Power,
            _ if emission.quantity == Quantity::Power => own,
            _ => emission.quantity,
        };
        let quantity = emission.quantity;
        v.need(quantity.name(), &mut emission.rgb, RADIANCE);
        v.check(&|| match forms.contains(&quantity.name()) {
            true => Ok(()),
            false => Fault::at(
                quantity.name(),
                format!("a `{form}` has no `{}`; give its `{}`", quantity.name(), own.name()),
            ),
        });
        if form == "shape" {
            v.optional("two_sided", two_sided, false, ANY);
        } else {
            v.refuse(
                "two_sided",
                &format!("`two_sided` belongs to a light with a `shape`, but this one is a `{form}`"),
            );
        }
        v.maybe_medium("outside", outside);
    }
}

impl Paint {
    fn form(&self) -> &'static str {
        match self {
            Self::Color(_) => "color",
            Self::Checker { .. } => "checker",
            Self::Texture { .. } => "texture",
        }
    }

    /// # Errors
    /// When an image is laid on a shape that has no texture coordinates.
    fn validate(&self, shape: &Shape) -> Result<(), Fault> {
        match (self, shape) {
            (Self::Texture { .. }, Shape::Mesh { path, mesh, .. }) if !mesh.has_uvs() => Fault::at(
                "texture",
                format!(
                    "the mesh {} has no texture coordinates: export it with them (they are called UVs too), or give a `color`",
                    path.display()
                ),
            ),
            _ => Ok(()),
        }
    }

    fn fields(&mut self, v: &mut dyn Visitor) {
        let form = v.form(&["color", "checker", "texture"], self.form(), Some("color"));
        if form != self.form() {
            *self = match form {
                "checker" => Self::Checker { a: [0.0; 3], b: [0.0; 3], size: 1.0 },
                "texture" => Self::texture(PathBuf::new(), Arc::new(TextureImage::blank())),
                _ => Self::Color(DEFAULT_ALBEDO),
            };
        }
        match self {
            Self::Color(color) => _ = v.optional("color", color, DEFAULT_ALBEDO, SHARE),
            Self::Checker { a, b, size } => {
                v.table("checker", |v| {
                    v.need("a", a, SHARE).need("b", b, SHARE).need("size", size, POSITIVE);
                });
            }
            Self::Texture { path, image, tint, uv } => {
                v.slot("texture", Slot::Texture { path, image }).optional("tint", tint, [1.0; 3], SHARE);
                let is_default = Some(*uv == UvTransform::IDENTITY);
                v.field(Field { key: "uv", slot: Slot::Table(&mut |v| uv.fields(v)), is_default });
                return;
            }
        }
        v.refuse("tint", "`tint` multiplies a `texture`, which this solid does not have; give its `color` instead");
        v.refuse("uv", "`uv` says how a `texture` is laid on, which this solid does not have");
    }
}

impl UvTransform {
    fn fields(&mut self, v: &mut dyn Visitor) {
        let Self { scale, rotate, offset } = self;
        v.optional("scale", scale, [1.0; 2], UV).optional("rotate", rotate, 0.0, UV);
        v.optional("offset", offset, [0.0; 2], UV);
    }
}

impl Transform {
    /// # Errors
    /// When `shape` cannot be transformed like this.
    pub fn validate(&self, shape: &Shape) -> Result<(), Fault> {
        let size = self.scale.abs();
        for (key, vector) in [("scale", self.scale), ("translate", self.translate)] {
            if !(vector.abs().max_element() <= MAX_LENGTH && vector.is_finite()) {
                return Fault::at(key, format!("`{key}` is too large, must be at most {MAX_LENGTH:e}"));
            }
        }
        if !self.rotate.is_finite() {
            Fault::at("rotate", "`rotate` must be finite")
        } else if size.min_element() == 0.0 {
            Fault::at("scale", "`scale` must not be 0")
        } else if size.min_element() < MIN_LENGTH {
            Fault::at("scale", format!("`scale` is too small, must be at least {MIN_LENGTH:e}"))
        } else if matches!(shape, Shape::Sphere { .. }) && (size.x != size.y || size.y != size.z) {
            Fault::at("", "a `sphere` is analytic and cannot be scaled differently along its axes; use an `icosphere`")
        } else {
            Ok(())
        }
    }

    /// Of an object of that shape.
    fn fields(&mut self, v: &mut dyn Visitor, shape: &Shape) {
        let Self { scale, rotate, translate } = self;
        let is_default = Some(*scale == DVec3::ONE);
        v.field(Field { key: "scale", slot: Slot::Scale(scale), is_default });
        v.optional("rotate", rotate, DVec3::ZERO, ANY);
        v.optional("translate", translate, DVec3::ZERO, ANY);
        v.check(&|| self.validate(shape));
    }
}

impl Shape {
    const FORMS: [&str; 8] = ["sphere", "icosphere", "box", "cylinder", "torus", "lathe", "quad", "mesh"];

    /// The keys of a light that say where it is.
    const LIGHT_FORMS: [&str; 4] = ["shape", "point", "spot", "directional"];

    fn light_form(&self) -> &'static str {
        if self.has_surface() { "shape" } else { self.form() }
    }

    fn form(&self) -> &'static str {
        match self {
            Self::Point { .. } => "point",
            Self::Spot { .. } => "spot",
            Self::Directional { .. } => "directional",
            Self::Sphere { .. } => "sphere",
            Self::Icosphere { .. } => "icosphere",
            Self::Box { .. } => "box",
            Self::Cylinder { .. } => "cylinder",
            Self::Torus { .. } => "torus",
            Self::Lathe { .. } => "lathe",
            Self::Quad { .. } => "quad",
            Self::Mesh { .. } => "mesh",
        }
    }

    fn blank(form: &str) -> Self {
        let (center, radius, height) = (DVec3::ZERO, 1.0, 1.0);
        let (segments, rings) = (DEFAULT_SEGMENTS, DEFAULT_RINGS);
        match form {
            "icosphere" => Self::Icosphere { center, radius, subdivisions: 0 },
            "box" => Self::Box { min: DVec3::ZERO, max: DVec3::ONE },
            "cylinder" => Self::Cylinder { center, radius, height, segments },
            "torus" => Self::Torus { center, major: 1.0, minor: 0.5, segments, rings },
            "lathe" => Self::Lathe { profile: Vec::new(), segments },
            "quad" => Self::Quad { center, edge_u: DVec3::X, edge_v: DVec3::Z },
            "mesh" => Self::mesh(PathBuf::new(), Arc::default()),
            "point" => Self::Point { position: center },
            "spot" => Self::Spot { position: DVec3::Y, target: center, inner_angle: 20.0, outer_angle: 30.0 },
            "directional" => Self::Directional { direction: DVec3::NEG_Y, angle: 0.0 },
            _ => Self::Sphere { center, radius },
        }
    }

    fn fields(&mut self, v: &mut dyn Visitor) {
        let form = v.form(&Self::FORMS, self.form(), None);
        if form != self.form() {
            *self = Self::blank(form);
        }
        if let Self::Mesh { path, part, mesh, notes } = self {
            v.slot("mesh", Slot::Mesh { path, part, mesh, notes });
            v.optional("group", &mut part.group, None, ANY).optional("material", &mut part.material, None, ANY);
            return v.check(&|| shapes::validate(self).map_err(|fault| Fault { key: "mesh", ..fault }));
        }
        v.table(form, |v| self.form_fields(v));
    }

    /// Of a shape that is given by numbers.
    fn form_fields(&mut self, v: &mut dyn Visitor) {
        self.number_fields(v);
        v.check(&|| shapes::validate(self));
    }

    fn number_fields(&mut self, v: &mut dyn Visitor) {
        match self {
            Self::Sphere { center, radius } => v.need("center", center, ANY).need("radius", radius, ANY),
            Self::Icosphere { center, radius, subdivisions: n } => {
                v.need("center", center, ANY).need("radius", radius, ANY).need("subdivisions", n, ANY)
            }
            Self::Box { min, max } => v.need("min", min, ANY).need("max", max, ANY),
            Self::Cylinder { center, radius, height, segments } => {
                v.need("center", center, ANY).need("radius", radius, ANY).need("height", height, ANY);
                v.optional("segments", segments, DEFAULT_SEGMENTS, ANY)
            }
            Self::Torus { center, major, minor, segments, rings } => {
                v.need("center", center, ANY).need("major", major, ANY).need("minor", minor, ANY);
                v.optional("segments", segments, DEFAULT_SEGMENTS, ANY).optional("rings", rings, DEFAULT_RINGS, ANY)
            }
            Self::Lathe { profile, segments } => {
                v.need("profile", profile, ANY).optional("segments", segments, DEFAULT_SEGMENTS, ANY)
            }
            Self::Quad { center, edge_u, edge_v } => {
                v.need("center", center, ANY).need("edge_u", edge_u, ANY).need("edge_v", edge_v, ANY)
            }
            Self::Mesh { .. } => v,
            Self::Point { position } => v.need("position", position, ANY),
            Self::Spot { position, target, inner_angle, outer_angle } => {
                v.need("position", position, ANY).need("target", target, ANY);
                v.need("inner_angle", inner_angle, ANY).need("outer_angle", outer_angle, ANY)
            }
            Self::Directional { direction, angle } => {
                v.need("direction", direction, ANY).optional("angle", angle, 0.0, ANY)
            }
        };
    }
}
