//! Materials, textures (images as they are, others by their mean colours), and what media absorb.

use glam::{DAffine2, DMat2, DVec2};

use super::state::Reader;
use super::tokens::{Parameter, Parameters};
use crate::formats::importing::{at, diffuse, indices, mirror, spectra};
use crate::optics::Ior;
use crate::optics::ior::IOR_RANGE;
use crate::scene::Place;
use crate::scene::SceneError;
use crate::scene::description::{Paint, Refractor, Solid};

/// What a surface is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Material {
    /// The index inside over that outside; `is_glass`: it was given by the name of a glass, whose own index it is.
    Dielectric {
        eta: f64,
        is_glass: bool,
        /// `eta` at all wavelengths, where it differs between them.
        formula: Option<Ior>,
        /// Its roughness, and whether it is a thin wall.
        refractor: Refractor,
    },
    /// It bends nothing: media may change there.
    Null,
    Solid(Solid),
}

impl Material {
    /// Of a shape before any material.
    pub fn unspecified() -> Self {
        Self::Solid(diffuse(Paint::Color([0.5; 3])))
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

pub(super) fn material(
    reader: &mut Reader<'_>,
    kind: &str,
    parameters: &Parameters,
    place: &Place,
) -> Result<Material, SceneError> {
    if parameters.get("displacement").is_some() || parameters.get("normalmap").is_some() {
        reader.importer.note("bump", place, "displacement and normal maps are left out");
    }
    match kind {
        "dielectric" | "thindielectric" => {
            let thin = kind == "thindielectric";
            let roughness = if thin { [0.0; 2] } else { roughness(reader, parameters, "", place)? };
            let is_glass = parameters.get("eta").is_some_and(|eta| !eta.texts.is_empty());
            let (eta, formula) = eta(reader, parameters)?;
            let refractor = Refractor { roughness, thin, ..Refractor::of("") };
            Ok(Material::Dielectric { eta, is_glass, formula, refractor })
        }
        "interface" | "" | "none" => Ok(Material::Null),
        "diffuse" | "diffusetransmission" => {
            if kind == "diffusetransmission" {
                reader.importer.note("bsdf", place, "materials that let light through diffusely are taken for diffuse");
            }
            Ok(Material::Solid(diffuse(paint(reader, parameters, "reflectance")?.unwrap_or(Paint::Color([0.5; 3])))))
        }
        "coateddiffuse" => {
            reader.importer.note(
                "plastic",
                place,
                "coated diffuse materials are taken for diffuse, without their gloss",
            );
            Ok(Material::Solid(diffuse(paint(reader, parameters, "reflectance")?.unwrap_or(Paint::Color([0.5; 3])))))
        }
        "conductor" | "coatedconductor" => {
            let message = "metals are mirrors of their reflectance at normal incidence, at every angle";
            reader.importer.note("conductor", place, message);
            let reflectance = match paint(reader, parameters, "reflectance")? {
                Some(reflectance) => reflectance,
                None => Paint::Color(metal(parameters)),
            };
            let prefix = if kind == "coatedconductor" { "conductor." } else { "" };
            let roughness = roughness(reader, parameters, prefix, place)?;
            Ok(Material::Solid(mirror(reflectance, roughness)))
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

/// α along u and v. `prefix` stands before the names of the parameters.
fn roughness(
    reader: &mut Reader<'_>,
    parameters: &Parameters,
    prefix: &str,
    place: &Place,
) -> Result<[f64; 2], SceneError> {
    let mut number = |name: &str| -> Result<Option<f64>, SceneError> {
        let found = color(reader, parameters, &format!("{prefix}{name}"))?;
        Ok(found.map(|[a, b, c]| (a + b + c) / 3.0))
    };
    let both = number("roughness")?.unwrap_or(0.0);
    let alpha = [number("uroughness")?.unwrap_or(both), number("vroughness")?.unwrap_or(both)];
    // pbrt's `RoughnessToAlpha`.
    let is_remapped = parameters.text("remaproughness") != Some("false");
    let alpha = if is_remapped { alpha.map(|x| x.max(0.0).sqrt()) } else { alpha };
    Ok(reader.importer.roughness(alpha, place))
}

/// The index of a dielectric, by number, by the name of a glass, or by wavelengths.
fn eta(reader: &mut Reader<'_>, parameters: &Parameters) -> Result<(f64, Option<Ior>), SceneError> {
    let Some(parameter) = parameters.get("eta") else { return Ok((1.5, None)) };
    let mut is_one_for_all = false;
    let (eta, formula) = match (parameter.texts.first(), &parameter.numbers[..]) {
        (Some(name), _) => {
            let eta = indices::of_pbrt(name);
            let eta = eta.ok_or_else(|| at(&parameter.place, format!("no glass is called `{name}`")))?;
            let formula = indices::formula_of_pbrt(name);
            is_one_for_all = formula.is_none();
            (eta, formula)
        }
        (None, [eta]) => (*eta, None),
        (None, numbers) => {
            let pairs: Vec<(f64, f64)> = numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
            let formula = spectra::cauchy(&pairs);
            is_one_for_all = formula.is_none() && pairs.iter().any(|(_, eta)| *eta != pairs[0].1);
            // That nearest to the d line.
            let nearest = pairs
                .into_iter()
                .min_by(|a, b| (a.0 - spectra::D_LINE_NM).abs().total_cmp(&(b.0 - spectra::D_LINE_NM).abs()));
            let nearest = nearest.map_or(1.5, |(_, eta)| eta);
            (formula.as_ref().map_or(nearest, Ior::ior), formula)
        }
    };
    if is_one_for_all {
        let message = "glasses have the index of their spectrum at 587.56 nm at all wavelengths";
        reader.importer.note("dispersion_of_file", &parameter.place, message);
    }
    match IOR_RANGE.contains(&eta) {
        true => Ok((eta, formula)),
        false => Err(at(&parameter.place, format!("`eta` is {eta}, must be from 1e-6 to 1e6"))),
    }
}

fn metal(parameters: &Parameters) -> [f64; 3] {
    let name = parameters.text("eta").or(parameters.text("conductor.eta")).unwrap_or("metal-Cu-eta");
    spectra::metal(name.trim_start_matches("metal-").trim_end_matches("-eta"))
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
            Ok(spectra::bands(pairs.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect()))
        }
        _ => Err(at(place, format!("`{}` is no colour", parameter.name))),
    }
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
