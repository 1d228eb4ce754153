//! Numbers, vectors and colours of properties.

use glam::{DAffine2, DMat2, DVec2, DVec3};

use super::Reader;
use super::transform::transform_of;
use super::tree::Node;
use crate::formats::importing::{at, spectra};
use crate::scene::SceneError;
use crate::scene::description::Paint;

/// Mitsuba counts v from the upper row of an image.
pub(super) const UPSIDE_DOWN: DAffine2 =
    DAffine2 { matrix2: DMat2::from_cols(DVec2::X, DVec2::NEG_Y), translation: DVec2::Y };

/// All numbers of a text, parted by commas or spaces.
pub(super) fn numbers(node: &Node, text: &str) -> Result<Vec<f64>, SceneError> {
    let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
    words.map(|word| finite(node, word)).collect()
}

fn finite(node: &Node, word: &str) -> Result<f64, SceneError> {
    let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| at(&node.place, format!("`{word}` is no number")))
}

/// A number, given by `value`.
pub(super) fn number(node: &Node) -> Result<f64, SceneError> {
    finite(node, node.value()?.trim())
}

/// The number that is a property; `None` where it is not there or is an object of its own, such as a texture.
pub(super) fn number_of(node: &Node, name: &str) -> Result<Option<f64>, SceneError> {
    match node.property(name) {
        Some(property) if matches!(property.tag.as_str(), "float" | "integer") => number(property).map(Some),
        _ => Ok(None),
    }
}

pub(super) fn flag_of(node: &Node, name: &str) -> Result<bool, SceneError> {
    match node.property(name) {
        Some(property) if property.tag == "boolean" => match property.value()?.trim() {
            "true" | "True" | "1" => Ok(true),
            "false" | "False" | "0" => Ok(false),
            other => Err(at(&property.place, format!("`{other}` is neither true nor false"))),
        },
        _ => Ok(false),
    }
}

pub(super) fn text_of<'n>(node: &'n Node, name: &str) -> Result<Option<&'n str>, SceneError> {
    match node.property(name) {
        Some(property) if matches!(property.tag.as_str(), "string" | "path") => property.value().map(Some),
        _ => Ok(None),
    }
}

/// A point or a vector, by `value` or by `x`, `y` and `z`, of which those that are left out are `otherwise`.
pub(super) fn vector(node: &Node, otherwise: f64) -> Result<DVec3, SceneError> {
    if let Some(text) = node.attribute("value") {
        return match numbers(node, text)?[..] {
            [x] => Ok(DVec3::splat(x)),
            [x, y, z] => Ok(DVec3::new(x, y, z)),
            _ => Err(at(&node.place, "three numbers are needed")),
        };
    }
    let component = |name: &str| node.attribute(name).map_or(Ok(otherwise), |text| finite(node, text.trim()));
    Ok(DVec3::new(component("x")?, component("y")?, component("z")?))
}

/// A vector from an attribute, such as `origin="1, 2, 3"`.
pub(super) fn attribute_vector(node: &Node, name: &str) -> Result<Option<DVec3>, SceneError> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    match numbers(node, text)?[..] {
        [x, y, z] => Ok(Some(DVec3::new(x, y, z))),
        _ => Err(at(&node.place, format!("`{name}` needs three numbers"))),
    }
}

/// The colour of a property: a number for all, a colour, a spectrum or a texture, of which the mean is taken.
pub(super) fn color_of<'t>(
    reader: &mut Reader<'_, 't>,
    node: &'t Node,
    name: &str,
) -> Result<Option<[f64; 3]>, SceneError> {
    let Some(property) = node.property(name) else { return Ok(None) };
    let property = reader.resolved(property)?;
    color(reader, property).map(Some)
}

/// What a surface reflects by a property: an image, or the colour of anything else.
pub(super) fn paint_of<'t>(
    reader: &mut Reader<'_, 't>,
    node: &'t Node,
    name: &str,
) -> Result<Option<Paint>, SceneError> {
    let Some(property) = node.property(name) else { return Ok(None) };
    let property = reader.resolved(property)?;
    if property.tag == "texture" && property.kind == "bitmap" {
        return bitmap(reader, property).map(Some);
    }
    color(reader, property).map(|color| Some(Paint::Color(color.map(|x| x.clamp(0.0, 1.0)))))
}

fn bitmap<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<Paint, SceneError> {
    let grey = Paint::Color([0.5; 3]);
    let Some(name) = text_of(node, "filename")?.map(str::to_owned) else { return Ok(grey) };
    if flag_of(node, "raw")? {
        reader.importer.note("texture_raw", &node.place, "textures of raw numbers are taken for sRGB");
    }
    if text_of(node, "wrap_mode")?.is_some_and(|mode| mode != "repeat") {
        let message = "textures that are mirrored or clamped beyond their edges are repeated";
        reader.importer.note("texture_wrap", &node.place, message);
    }
    if text_of(node, "filter_type")?.is_some_and(|filter| filter != "bilinear") {
        reader.importer.note("texture_filter", &node.place, "texels are interpolated");
    }
    let matrix = transform_of(node, "to_uv")?;
    let [x, y] = [matrix.matrix3.x_axis, matrix.matrix3.y_axis].map(DVec3::truncate);
    let to_uv = DAffine2 { matrix2: DMat2::from_cols(x, y), translation: matrix.translation.truncate() };
    Ok(reader.importer.texture(&name, &(UPSIDE_DOWN * to_uv), &node.place).unwrap_or(grey))
}

/// How deep textures may stand in each other.
const MOST_DEPTH: usize = 12;

pub(super) fn color<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<[f64; 3], SceneError> {
    if reader.colors >= MOST_DEPTH {
        return Err(at(&node.place, format!("textures stand more than {MOST_DEPTH} deep in each other")));
    }
    reader.colors += 1;
    let color = one_color(reader, node);
    reader.colors -= 1;
    color
}

fn one_color<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<[f64; 3], SceneError> {
    match node.tag.as_str() {
        "float" | "integer" => number(node).map(|x| [x; 3]),
        "rgb" | "srgb" => rgb(node, node.value()?),
        "spectrum" | "blackbody" => spectrum(reader, node),
        "texture" => texture(reader, node),
        "volume" if node.kind == "constvolume" => Ok(color_of(reader, node, "value")?.unwrap_or([1.0; 3])),
        "volume" => {
            reader.importer.note(
                "volume",
                &node.place,
                "what differs from place to place within a medium is taken for 0.5",
            );
            Ok([0.5; 3])
        }
        tag => Err(at(&node.place, format!("<{tag}> is no colour"))),
    }
}

fn rgb(node: &Node, text: &str) -> Result<[f64; 3], SceneError> {
    let text = text.trim();
    if let Some(digits) = text.strip_prefix('#') {
        let value = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
        let value = value.ok_or_else(|| at(&node.place, format!("`{text}` is no colour")))?;
        return Ok([16, 8, 0].map(|shift| f64::from(value >> shift & 255) / 255.0));
    }
    match numbers(node, text)?[..] {
        [x] => Ok([x; 3]),
        [r, g, b] => Ok([r, g, b]),
        _ => Err(at(&node.place, "a colour needs three numbers")),
    }
}

/// One number for all wavelengths, or `wavelength:value` pairs, of which red, green and blue are means over a third of what is seen each.
fn spectrum(reader: &mut Reader<'_, '_>, node: &Node) -> Result<[f64; 3], SceneError> {
    let Some(text) = node.attribute("value") else {
        reader.importer.note("spectrum", &node.place, "spectra from files and of black bodies are taken for white");
        return Ok([1.0; 3]);
    };
    if !text.contains(':') {
        return rgb(node, text);
    }
    let mut samples = Vec::new();
    for pair in text.split(',').filter(|pair| !pair.trim().is_empty()) {
        let (wavelength, value) = pair
            .split_once(':')
            .ok_or_else(|| at(&node.place, format!("`{}` is no wavelength with its value", pair.trim())))?;
        samples.push((finite(node, wavelength.trim())?, finite(node, value.trim())?));
    }
    reader.importer.note("spectrum", &node.place, "spectra are taken by their means over red, green and blue");
    Ok(spectra::bands(samples))
}

fn texture<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<[f64; 3], SceneError> {
    match node.kind.as_str() {
        "bitmap" => {
            reader.importer.note("texture", &node.place, "textures are taken by their mean colour");
            let name = text_of(node, "filename")?.map(str::to_owned);
            Ok(name.and_then(|name| reader.importer.mean_color(&name, &node.place)).unwrap_or([0.5; 3]))
        }
        "checkerboard" => {
            reader.importer.note("texture", &node.place, "textures are taken by their mean colour");
            let [a, b] = [("color0", 0.4), ("color1", 0.2)]
                .map(|(name, otherwise)| color_of(reader, node, name).map(|found| found.unwrap_or([otherwise; 3])));
            let (a, b) = (a?, b?);
            Ok([0, 1, 2].map(|k| 0.5 * (a[k] + b[k])))
        }
        kind => {
            let message = format!("textures of the type {kind} are taken for grey");
            reader.importer.note("texture", &node.place, message);
            Ok([0.5; 3])
        }
    }
}
