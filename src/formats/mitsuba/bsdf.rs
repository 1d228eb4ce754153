//! BSDFs: what a surface is to light.

use super::Reader;
use super::tree::Node;
use super::values::{color_of, number, number_of, paint_of, text_of};
use crate::formats::importing::{at, indices};
use crate::formats::suggest::suggestion;
use crate::optics::catalog;
use crate::scene::SceneError;
use crate::scene::description::{Paint, Solid};

/// Indices of a dielectric that gives none, as Mitsuba has them.
const DEFAULT_INTERIOR: f64 = 1.5046;
const DEFAULT_EXTERIOR: f64 = 1.000_277;

const MOST_DEPTH: usize = 32;

/// An index with the name that it was given by, which may be empty.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NamedIor {
    pub ior: f64,
    pub name: String,
}

/// What a surface is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Material {
    /// `name` is that of the BSDF, by which its inside may be called.
    Dielectric {
        inside: NamedIor,
        outside: NamedIor,
        name: String,
    },
    /// It bends nothing: media may change there.
    Null,
    /// Light goes straight through, and no medium begins.
    Thin,
    Solid(Solid),
}

impl Material {
    /// Of a shape that names none.
    pub fn unspecified() -> Self {
        Self::diffuse([0.5; 3])
    }

    fn diffuse(color: [f64; 3]) -> Self {
        Self::painted(Paint::Color(color), false)
    }

    fn painted(paint: Paint, mirror: bool) -> Self {
        Self::Solid(Solid { mirror, ..Solid::of(paint.tinted([1.0; 3])) })
    }
}

pub(super) fn material<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<Material, SceneError> {
    within(reader, node, 0)
}

fn within<'t>(reader: &mut Reader<'_, 't>, node: &'t Node, depth: usize) -> Result<Material, SceneError> {
    if depth > MOST_DEPTH {
        return Err(at(&node.place, "BSDFs stand too deep in each other"));
    }
    match node.kind.as_str() {
        "dielectric" => dielectric(reader, node),
        "roughdielectric" => {
            reader.importer.note("roughness", &node.place, "rough dielectrics are taken for smooth ones");
            dielectric(reader, node)
        }
        "thindielectric" => {
            let message = "thin dielectrics are left out: light goes through them as if they were not there";
            reader.importer.note("thin", &node.place, message);
            Ok(Material::Thin)
        }
        "null" => Ok(Material::Null),
        "diffuse" => {
            let paint = paint_of(reader, node, "reflectance")?;
            Ok(Material::painted(paint.unwrap_or(Paint::Color([0.5; 3])), false))
        }
        "plastic" | "roughplastic" => {
            reader.importer.note("plastic", &node.place, "plastics are taken for diffuse, without their gloss");
            let paint = paint_of(reader, node, "diffuse_reflectance")?;
            Ok(Material::painted(paint.unwrap_or(Paint::Color([0.5; 3])), false))
        }
        "conductor" => conductor(reader, node),
        "roughconductor" => {
            reader.importer.note("roughness", &node.place, "rough conductors are taken for smooth mirrors");
            conductor(reader, node)
        }
        "principled" | "principledthin" => principled(reader, node),
        "twosided" => inner(reader, node, depth),
        "mask" | "bumpmap" | "normalmap" | "blendbsdf" => {
            let message = match node.kind.as_str() {
                "mask" => "masks are taken for wholly opaque",
                "blendbsdf" => "of blended BSDFs the first is taken",
                _ => "bump and normal maps are left out",
            };
            reader.importer.note(kind_of(&node.kind), &node.place, message);
            inner(reader, node, depth)
        }
        kind => {
            let message = format!("BSDFs of the type {kind} are taken for grey and diffuse");
            reader.importer.note("bsdf", &node.place, message);
            Ok(Material::unspecified())
        }
    }
}

fn kind_of(kind: &str) -> &'static str {
    match kind {
        "mask" => "mask",
        "blendbsdf" => "blend",
        _ => "bump",
    }
}

/// The first BSDF within another.
fn inner<'t>(reader: &mut Reader<'_, 't>, node: &'t Node, depth: usize) -> Result<Material, SceneError> {
    let found = reader.children(node)?.into_iter().find(|(_, child)| child.tag == "bsdf");
    match found {
        Some((_, child)) => within(reader, child, depth + 1),
        None => Err(at(&node.place, format!("a BSDF of the type {} needs another within it", node.kind))),
    }
}

fn dielectric<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<Material, SceneError> {
    for name in ["specular_reflectance", "specular_transmittance"] {
        if let Some(color) = color_of(reader, node, name)?
            && color != [1.0; 3]
        {
            let message = "dielectrics reflect and let through what physics says: their tints are left out";
            reader.importer.note("tint", &node.place, message);
        }
    }
    let inside = index(node, "int_ior", DEFAULT_INTERIOR)?;
    let outside = index(node, "ext_ior", DEFAULT_EXTERIOR)?;
    Ok(Material::Dielectric { inside, outside, name: node.id.clone() })
}

/// An index by number or by name.
fn index(node: &Node, name: &str, otherwise: f64) -> Result<NamedIor, SceneError> {
    let Some(property) = node.property(name) else { return Ok(NamedIor { ior: otherwise, name: String::new() }) };
    if property.tag != "string" {
        let ior = number(property)?;
        return match crate::optics::ior::IOR_RANGE.contains(&ior) {
            true => Ok(NamedIor { ior, name: String::new() }),
            false => Err(at(&property.place, format!("`{name}` is {ior}, must be from 1e-6 to 1e6"))),
        };
    }
    let text = property.value()?;
    let ior = indices::of_mitsuba(text).or_else(|| catalog::find(text).map(catalog::Entry::ior)).ok_or_else(|| {
        let hint = suggestion(text, indices::mitsuba_names());
        at(&property.place, format!("no material is called `{text}`{hint}"))
    })?;
    Ok(NamedIor { ior, name: text.trim().to_lowercase() })
}

/// Reflectances at normal incidence of metals that are asked for by name.
const METALS: [(&str, [f64; 3]); 6] = [
    ("Au", [1.0, 0.78, 0.34]),
    ("Ag", [0.97, 0.96, 0.91]),
    ("Al", [0.91, 0.92, 0.92]),
    ("Cu", [0.95, 0.64, 0.54]),
    ("Cr", [0.55, 0.56, 0.55]),
    ("W", [0.5, 0.48, 0.45]),
];

fn conductor<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<Material, SceneError> {
    let paint = paint_of(reader, node, "specular_reflectance")?.unwrap_or(Paint::Color([1.0; 3]));
    let (eta, k) = (color_of(reader, node, "eta")?, color_of(reader, node, "k")?);
    let metal = text_of(node, "material")?;
    let reflectance = match (metal, eta, k) {
        (None | Some("none"), None, None) => [1.0; 3],
        (_, Some(eta), k) => {
            let k = k.unwrap_or([1.0; 3]);
            [0, 1, 2].map(|i| {
                let (n, k) = (eta[i], k[i]);
                ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k)
            })
        }
        (metal, ..) => {
            let known = METALS.iter().find(|(name, _)| Some(*name) == metal.and_then(|metal| metal.split('_').next()));
            known.map_or([0.9; 3], |(_, color)| *color)
        }
    };
    if reflectance != [1.0; 3] {
        let message = "metals are mirrors of their reflectance at normal incidence, at every angle";
        reader.importer.note("conductor", &node.place, message);
    }
    let finite = |x: f64| if x.is_finite() { x } else { 1.0 };
    Ok(Material::painted(paint.tinted(reflectance.map(finite)), true))
}

fn principled<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<Material, SceneError> {
    reader.importer.note(
        "principled",
        &node.place,
        "principled BSDFs are taken for dielectrics, mirrors or diffuse surfaces, whichever they are most",
    );
    let paint = paint_of(reader, node, "base_color")?.unwrap_or(Paint::Color([0.5; 3]));
    let share = |name: &str| number_of(node, name).map(|share| share.unwrap_or(0.0));
    if share("spec_trans")? > 0.5 {
        if node.kind == "principledthin" {
            return Ok(Material::Thin);
        }
        let ior = number_of(node, "eta")?.filter(|ior| crate::optics::ior::IOR_RANGE.contains(ior)).unwrap_or(1.5);
        let side = |ior: f64| NamedIor { ior, name: String::new() };
        return Ok(Material::Dielectric { inside: side(ior), outside: side(1.0), name: node.id.clone() });
    }
    Ok(Material::painted(paint, share("metallic")? > 0.5))
}
