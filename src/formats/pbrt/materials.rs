//! Materials, textures (images as they are, others by their mean colours), and what media absorb.

use glam::{DAffine2, DMat2, DVec2};

use super::state::Reader;
use super::tokens::{Parameter, Parameters};
use crate::formats::importing::{at, indices};
use crate::optics::ior::IOR_RANGE;
use crate::scene::Place;
use crate::scene::SceneError;
use crate::scene::description::{Paint, Solid};

/// What a surface is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Material {
    /// The index inside over that outside; `is_glass`: it was given by the name of a glass, whose own index it is.
    Dielectric {
        eta: f64,
        is_glass: bool,
    },
    /// It bends nothing: media may change there.
    Null,
    /// Light goes straight through, and no medium begins.
    Thin,
    Solid(Solid),
}

impl Material {
    /// Of a shape before any material.
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

/// A texture by its name.
#[derive(Debug, Clone)]
pub(super) struct Texture {
    /// The mean colour.
    pub mean: [f64; 3],
    /// What a surface has of it, if that is more than one colour.
    paint: Option<Paint>,
}

/// Reflectances at normal incidence of metals by pbrt's names of their spectra.
const METALS: [(&str, [f64; 3]); 6] = [
    ("Au", [1.0, 0.78, 0.34]),
    ("Ag", [0.97, 0.96, 0.91]),
    ("Al", [0.91, 0.92, 0.92]),
    ("Cu", [0.95, 0.64, 0.54]),
    ("CuZn", [0.89, 0.79, 0.43]),
    ("MgO", [0.07; 3]),
];

pub(super) fn material(
    reader: &mut Reader<'_>,
    kind: &str,
    parameters: &Parameters,
    place: &Place,
) -> Result<Material, SceneError> {
    let is_rough = ["roughness", "uroughness", "vroughness"]
        .iter()
        .any(|name| parameters.get(name).is_some_and(|p| p.kind != "float" || p.numbers.iter().any(|x| *x != 0.0)));
    if parameters.get("displacement").is_some() || parameters.get("normalmap").is_some() {
        reader.importer.note("bump", place, "displacement and normal maps are left out");
    }
    match kind {
        "dielectric" => {
            if is_rough {
                reader.importer.note("roughness", place, "rough dielectrics are taken for smooth ones");
            }
            let is_glass = parameters.get("eta").is_some_and(|eta| !eta.texts.is_empty());
            Ok(Material::Dielectric { eta: eta(reader, parameters)?, is_glass })
        }
        "thindielectric" => {
            let message = "thin dielectrics are left out: light goes through them as if they were not there";
            reader.importer.note("thin", place, message);
            Ok(Material::Thin)
        }
        "interface" | "" | "none" => Ok(Material::Null),
        "diffuse" | "diffusetransmission" => {
            if kind == "diffusetransmission" {
                reader.importer.note("bsdf", place, "materials that let light through diffusely are taken for diffuse");
            }
            Ok(Material::painted(paint(reader, parameters, "reflectance")?.unwrap_or(Paint::Color([0.5; 3])), false))
        }
        "coateddiffuse" => {
            reader.importer.note(
                "plastic",
                place,
                "coated diffuse materials are taken for diffuse, without their gloss",
            );
            Ok(Material::painted(paint(reader, parameters, "reflectance")?.unwrap_or(Paint::Color([0.5; 3])), false))
        }
        "conductor" | "coatedconductor" => {
            let message = "metals are smooth mirrors of their reflectance at normal incidence, at every angle";
            reader.importer.note("conductor", place, message);
            let reflectance = match paint(reader, parameters, "reflectance")? {
                Some(reflectance) => reflectance,
                None => Paint::Color(metal(parameters)),
            };
            Ok(Material::painted(reflectance, true))
        }
        "mix" => {
            reader.importer.note("blend", place, "of mixed materials the first is taken");
            let first = parameters.text("materials").unwrap_or_default();
            match reader.materials.get(first) {
                Some(material) => Ok(material.clone()),
                None => Err(at(place, format!("there is no material `{first}`"))),
            }
        }
        kind => {
            let message = format!("materials of the type {kind} are taken for grey and diffuse");
            reader.importer.note("bsdf", place, message);
            Ok(Material::unspecified())
        }
    }
}

/// The index of a dielectric, by number or by the name of a glass.
fn eta(reader: &mut Reader<'_>, parameters: &Parameters) -> Result<f64, SceneError> {
    let Some(parameter) = parameters.get("eta") else { return Ok(1.5) };
    let eta = match (parameter.texts.first(), &parameter.numbers[..]) {
        (Some(name), _) => {
            let message = "glasses have the index of their spectrum at 587.56 nm at all wavelengths";
            reader.importer.note("dispersion_of_file", &parameter.place, message);
            indices::of_pbrt(name).ok_or_else(|| at(&parameter.place, format!("no glass is called `{name}`")))?
        }
        (None, [eta]) => *eta,
        (None, numbers) => {
            // Wavelengths with values: that nearest to the d line.
            let pairs = numbers.chunks_exact(2).map(|pair| (pair[0], pair[1]));
            let nearest = pairs.min_by(|a, b| (a.0 - 587.56).abs().total_cmp(&(b.0 - 587.56).abs()));
            nearest.map_or(1.5, |(_, eta)| eta)
        }
    };
    match IOR_RANGE.contains(&eta) {
        true => Ok(eta),
        false => Err(at(&parameter.place, format!("`eta` is {eta}, must be from 1e-6 to 1e6"))),
    }
}

fn metal(parameters: &Parameters) -> [f64; 3] {
    let name = parameters.text("eta").unwrap_or("metal-Cu-eta");
    let element = name.trim_start_matches("metal-").trim_end_matches("-eta");
    METALS.iter().find(|(known, _)| *known == element).map_or([0.9; 3], |(_, color)| *color)
}

/// What a surface reflects by a parameter: an image, or the colour of anything else.
fn paint(reader: &mut Reader<'_>, parameters: &Parameters, name: &str) -> Result<Option<Paint>, SceneError> {
    let texture = parameters.get(name).filter(|parameter| parameter.kind == "texture");
    let named = texture.and_then(|parameter| reader.textures.get(parameter.texts.first()?));
    match named.and_then(|texture| texture.paint.clone()) {
        Some(paint) => Ok(Some(paint)),
        None => color(reader, parameters, name).map(|color| color.map(Paint::Color)),
    }
}

/// A colour parameter: numbers, a spectrum or the mean of a texture.
pub(super) fn color(
    reader: &mut Reader<'_>,
    parameters: &Parameters,
    name: &str,
) -> Result<Option<[f64; 3]>, SceneError> {
    parameters.get(name).map(|parameter| color_of(reader, parameter)).transpose()
}

fn color_of(reader: &mut Reader<'_>, parameter: &Parameter) -> Result<[f64; 3], SceneError> {
    let Parameter { kind, texts, numbers, place, .. } = parameter;
    match (kind.as_str(), texts.first(), &numbers[..]) {
        ("texture", Some(name), _) => {
            reader.importer.note("texture", place, "textures are taken by their mean colour");
            match reader.textures.get(name) {
                Some(texture) => Ok(texture.mean),
                None => Err(at(place, format!("there is no texture `{name}`"))),
            }
        }
        ("blackbody", ..) | (_, Some(_), _) => {
            reader.importer.note("spectrum", place, "spectra by name and of black bodies are taken for white");
            Ok([1.0; 3])
        }
        (_, None, [x]) => Ok([*x; 3]),
        ("rgb" | "color" | "xyz", None, [r, g, b]) => Ok([*r, *g, *b]),
        ("spectrum", None, pairs) if pairs.len() >= 2 && pairs.len().is_multiple_of(2) => {
            reader.importer.note("spectrum", place, "spectra are taken by their means over red, green and blue");
            Ok(bands(pairs))
        }
        _ => Err(at(place, format!("`{}` is no colour", parameter.name))),
    }
}

/// Means over a third each of what is seen, of wavelengths with values.
fn bands(pairs: &[f64]) -> [f64; 3] {
    let mut samples: Vec<(f64, f64)> = pairs.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at_wavelength = |nm: f64| {
        let next = samples.partition_point(|sample| sample.0 < nm);
        match (next.checked_sub(1).map(|before| samples[before]), samples.get(next)) {
            (Some(a), Some(b)) if b.0 > a.0 => a.1 + (b.1 - a.1) * (nm - a.0) / (b.0 - a.0),
            (Some(a), _) => a.1,
            (None, Some(b)) => b.1,
            (None, None) => 0.0,
        }
    };
    [600.0, 500.0, 400.0]
        .map(|from: f64| (0..10).map(|k| at_wavelength(from + 10.0 * (f64::from(k) + 0.5))).sum::<f64>() / 10.0)
}

pub(super) fn texture(
    reader: &mut Reader<'_>,
    class: &str,
    parameters: &Parameters,
    place: &Place,
) -> Result<Texture, SceneError> {
    let paint = match class {
        "imagemap" => Some(image_map(reader, parameters, place)),
        "scale" => {
            // An image and what multiplies it, in either order.
            let images = [paint(reader, parameters, "tex")?, paint(reader, parameters, "scale")?];
            match images {
                [Some(image @ Paint::Texture { .. }), by @ (None | Some(Paint::Color(_)))]
                | [by @ (None | Some(Paint::Color(_))), Some(image @ Paint::Texture { .. })] => {
                    Some(image.tinted(by.map_or([1.0; 3], |by| by.mean())))
                }
                _ => None,
            }
        }
        _ => None,
    };
    if let Some(paint) = paint {
        return Ok(Texture { mean: paint.mean(), paint: Some(paint) });
    }
    mean_of(reader, class, parameters, place).map(|mean| Texture { mean, paint: None })
}

/// A texture from a file; grey where it cannot be read.
fn image_map(reader: &mut Reader<'_>, parameters: &Parameters, place: &Place) -> Paint {
    let name = parameters.text("filename").unwrap_or_default();
    if parameters.text("encoding").is_some_and(|encoding| encoding != "sRGB") {
        reader.importer.note("texture_raw", place, "textures of raw numbers are taken for sRGB");
    }
    if parameters.text("wrap").is_some_and(|wrap| wrap != "repeat") {
        reader.importer.note(
            "texture_wrap",
            place,
            "textures that are clamped or black beyond their edges are repeated",
        );
    }
    if parameters.flag("invert") {
        reader.importer.note("texture_invert", place, "textures are taken as they are and not inverted");
    }
    let number = |name: &str, otherwise: f64| parameters.number(name).unwrap_or(otherwise);
    let uv = DAffine2 {
        matrix2: DMat2::from_diagonal(DVec2::new(number("uscale", 1.0), number("vscale", 1.0))),
        translation: DVec2::new(number("udelta", 0.0), number("vdelta", 0.0)),
    };
    let paint = reader.importer.texture(name, &uv, place).unwrap_or(Paint::Color([0.5; 3]));
    let paint = paint.tinted([number("scale", 1.0); 3]);
    if parameters.text("mapping").is_some_and(|mapping| mapping != "uv") {
        let message = "textures that are laid on by a plane, a sphere or a cylinder have their mean colour";
        reader.importer.note("texture_mapping", place, message);
        return Paint::Color(paint.mean());
    }
    paint
}

/// The mean colour of a texture.
fn mean_of(
    reader: &mut Reader<'_>,
    class: &str,
    parameters: &Parameters,
    place: &Place,
) -> Result<[f64; 3], SceneError> {
    let or = |found: Option<[f64; 3]>, otherwise: f64| found.unwrap_or([otherwise; 3]);
    let mixed = |a: [f64; 3], b: [f64; 3], share: f64| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * share);
    match class {
        "constant" => Ok(or(color(reader, parameters, "value")?, 1.0)),
        "scale" => {
            let (a, b) = (or(color(reader, parameters, "tex")?, 1.0), or(color(reader, parameters, "scale")?, 1.0));
            Ok([0, 1, 2].map(|k| a[k] * b[k]))
        }
        "mix" => {
            let (a, b) = (or(color(reader, parameters, "tex1")?, 0.0), or(color(reader, parameters, "tex2")?, 1.0));
            Ok(mixed(a, b, parameters.number("amount").unwrap_or(0.5)))
        }
        "checkerboard" | "dots" => {
            let (a, b) = (or(color(reader, parameters, "tex1")?, 1.0), or(color(reader, parameters, "tex2")?, 0.0));
            Ok(mixed(a, b, 0.5))
        }
        class => {
            let message = format!("textures of the class {class} are taken for grey");
            reader.importer.note("texture_unread", place, message);
            Ok([0.5; 3])
        }
    }
}

/// σ of a medium per scene unit.
pub(super) fn absorption(
    reader: &mut Reader<'_>,
    parameters: &Parameters,
    place: &Place,
) -> Result<[f64; 3], SceneError> {
    let kind = parameters.text("type").unwrap_or_default();
    if kind != "homogeneous" || parameters.get("preset").is_some() {
        reader.importer.note(
            "medium",
            place,
            "media that are not homogeneous, or known by a preset, are taken for clear",
        );
        return Ok([0.0; 3]);
    }
    let scale = parameters.number("scale").unwrap_or(1.0);
    let absorbs = color(reader, parameters, "sigma_a")?.unwrap_or([0.0011, 0.0024, 0.014]);
    let scatters = color(reader, parameters, "sigma_s")?.unwrap_or([2.55, 3.21, 3.77]);
    if scatters != [0.0; 3] {
        reader.importer.note("scattering", place, "media do not scatter here: they absorb what they would absorb");
    }
    if parameters.get("Le").is_some() {
        reader.importer.note("emission", place, "media do not shine here");
    }
    let fine = |x: f64| if x.is_finite() { x.max(0.0) } else { 0.0 };
    Ok(absorbs.map(|sigma| fine(sigma * scale)))
}
