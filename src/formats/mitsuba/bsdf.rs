//! BSDFs: what a surface is to light.

use super::Reader;
use super::tree::Node;
use super::values::{color_of, number, number_of, paint_of, text_of};
use crate::formats::importing::{at, diffuse, indices, mirror, spectra};
use crate::formats::suggest::suggestion;
use crate::optics::catalog;
use crate::scene::SceneError;
use crate::scene::description::{Paint, Refractor, Solid};

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
        /// Its roughness, and whether it is a thin wall.
        refractor: Refractor,
    },
    /// It bends nothing: media may change there.
    Null,
    Solid(Solid),
}

impl Material {
    /// Of a shape that names none.
    pub fn unspecified() -> Self {
        Self::Solid(diffuse(Paint::Color([0.5; 3])))
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
        "dielectric" => dielectric(reader, node, Refractor::of("")),
        "roughdielectric" => {
            let roughness = roughness(reader, node)?;
            dielectric(reader, node, Refractor { roughness, ..Refractor::of("") })
        }
        "thindielectric" => dielectric(reader, node, Refractor { thin: true, ..Refractor::of("") }),
        "null" => Ok(Material::Null),
        "diffuse" => {
            let paint = paint_of(reader, node, "reflectance")?;
            Ok(Material::Solid(diffuse(paint.unwrap_or(Paint::Color([0.5; 3])))))
        }
        "plastic" | "roughplastic" | "pplastic" => {
            reader.importer.note("plastic", &node.place, "plastics are taken for diffuse, without their gloss");
            let paint = paint_of(reader, node, "diffuse_reflectance")?;
            Ok(Material::Solid(diffuse(paint.unwrap_or(Paint::Color([0.5; 3])))))
        }
        "conductor" => conductor(reader, node, [0.0; 2]),
        "roughconductor" => {
            let roughness = roughness(reader, node)?;
            conductor(reader, node, roughness)
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

/// α of a rough dielectric or conductor, which need not say it.
fn roughness<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<[f64; 2], SceneError> {
    const DEFAULT: f64 = 0.1;
    if text_of(node, "distribution")? != Some("ggx") {
        let message = "Beckmann's distribution of facets is kept as GGX of the same α";
        reader.importer.note("distribution", &node.place, message);
    }
    let mut number = |name: &str| -> Result<Option<f64>, SceneError> {
        Ok(color_of(reader, node, name)?.map(|[a, b, c]| (a + b + c) / 3.0))
    };
    let both = number("alpha")?.unwrap_or(DEFAULT);
    let alpha = [number("alpha_u")?.unwrap_or(both), number("alpha_v")?.unwrap_or(both)];
    Ok(reader.importer.roughness(alpha, &node.place))
}

fn dielectric<'t>(reader: &mut Reader<'_, 't>, node: &'t Node, refractor: Refractor) -> Result<Material, SceneError> {
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
    Ok(Material::Dielectric { inside, outside, name: node.id.clone(), refractor })
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

fn conductor<'t>(reader: &mut Reader<'_, 't>, node: &'t Node, roughness: [f64; 2]) -> Result<Material, SceneError> {
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
        (metal, ..) => spectra::metal(metal.and_then(|metal| metal.split('_').next()).unwrap_or_default()),
    };
    if reflectance != [1.0; 3] {
        let message = "metals are mirrors of their reflectance at normal incidence, at every angle";
        reader.importer.note("conductor", &node.place, message);
    }
    let finite = |x: f64| if x.is_finite() { x } else { 1.0 };
    Ok(Material::Solid(mirror(paint.tinted(reflectance.map(finite)), roughness)))
}

fn principled<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<Material, SceneError> {
    reader.importer.note(
        "principled",
        &node.place,
        "principled BSDFs are taken for dielectrics, mirrors or diffuse surfaces, whichever they are most",
    );
    let paint = paint_of(reader, node, "base_color")?.unwrap_or(Paint::Color([0.5; 3]));
    let number = |name: &str, otherwise: f64| number_of(node, name).map(|share| share.unwrap_or(otherwise));
    // As Mitsuba makes α of it.
    let aspect = (1.0 - 0.9 * number("anisotropic", 0.0)?).max(0.0).sqrt();
    let square = number("roughness", 0.5)?.powi(2);
    let roughness = reader.importer.roughness([square / aspect, square * aspect].map(|a| a.max(1e-3)), &node.place);
    if number("spec_trans", 0.0)? > 0.5 {
        let ior = number_of(node, "eta")?.filter(|ior| crate::optics::ior::IOR_RANGE.contains(ior)).unwrap_or(1.5);
        let side = |ior: f64| NamedIor { ior, name: String::new() };
        let refractor = Refractor { roughness, thin: node.kind == "principledthin", ..Refractor::of("") };
        return Ok(Material::Dielectric { inside: side(ior), outside: side(1.0), name: node.id.clone(), refractor });
    }
    let is_metal = number("metallic", 0.0)? > 0.5;
    Ok(Material::Solid(if is_metal { mirror(paint, roughness) } else { diffuse(paint) }))
}
