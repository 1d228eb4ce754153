//! Scenes of pbrt-v4 (`.pbrt`).
//!
//! Read is the part that scenes of nested dielectrics use: shapes and object instances with their transforms, dielectrics with the media that
//! `MediumInterface` names, opaque materials as diffuse surfaces or mirrors, lights, and the camera. The rest is approximated or left out, and said
//! once a kind.
//!
//! The index of a dielectric, `eta`, is that of its inside over that of its outside there. Media have no index of their own: it follows from the
//! `eta`s along the names of media, from outside of everything, which has 1.

mod lights;
mod materials;
mod shapes;
mod state;
#[cfg(test)]
mod tests;
mod tokens;

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use self::state::{Reader, State};
use self::tokens::{Parameters, Token, Tokens};
use super::files::Input;
use super::importing::at;
use crate::scene::Place;
use crate::scene::{Description, SceneError};

/// Most bytes of all of a scene's files of directives.
const MOST_BYTES: usize = 1 << 30;
const MOST_INCLUDES: usize = 16;
/// How deep attributes may stand in each other.
const MOST_DEPTH: usize = 4096;

pub(super) fn read(input: &Input<'_>) -> Result<Description, SceneError> {
    let mut reader = Reader::new(input);
    run(&mut reader, input.bytes, input.path, 0)?;
    reader.finish()
}

/// Follows the directives of a file.
fn run(reader: &mut Reader<'_>, bytes: &[u8], path: &Path, includes: usize) -> Result<(), SceneError> {
    reader.bytes += bytes.len();
    if reader.bytes > MOST_BYTES {
        return Err(SceneError::in_file(path, format!("with this file the scene has more than {MOST_BYTES} bytes")));
    }
    let text = str::from_utf8(bytes).map_err(|_| SceneError::in_file(path, "is not text in UTF-8"))?;
    let mut tokens = Tokens::new(text.trim_start_matches('\u{feff}'), path);
    while let Some(token) = tokens.take()? {
        let Token::Word(directive) = token else { return Err(tokens.error("a directive is needed here")) };
        let place = tokens.place();
        if !transform(reader, directive, &mut tokens, &place)? && !attribute(reader, directive, &mut tokens, &place)? {
            other(reader, directive, &mut tokens, &place, includes)?;
        }
    }
    Ok(())
}

/// Directives that change the current transform. Whether it was one.
fn transform(
    reader: &mut Reader<'_>,
    directive: &str,
    tokens: &mut Tokens<'_>,
    place: &Place,
) -> Result<bool, SceneError> {
    let before = reader.state.matrix;
    reader.state.matrix = match directive {
        "Identity" => DAffine3::IDENTITY,
        "Translate" => before * DAffine3::from_translation(tokens.numbers::<3>()?.into()),
        "Scale" => before * DAffine3::from_scale(tokens.numbers::<3>()?.into()),
        "Rotate" => {
            let [angle, x, y, z] = tokens.numbers()?;
            let axis = DVec3::new(x, y, z).try_normalize();
            let axis = axis.ok_or_else(|| at(place, "the axis of a rotation must not be 0"))?;
            before * DAffine3::from_axis_angle(axis, angle.to_radians())
        }
        "LookAt" => before * look_at(tokens.numbers()?, place)?,
        "Transform" => of_columns(reader, tokens.matrix()?, place),
        "ConcatTransform" => before * of_columns(reader, tokens.matrix()?, place),
        "CoordSysTransform" => {
            let name = tokens.quoted("the name of a coordinate system")?;
            let known = reader.coordinate_systems.get(name).copied();
            known.ok_or_else(|| at(place, format!("there is no coordinate system `{name}`")))?
        }
        "CoordinateSystem" => {
            let name = tokens.quoted("a name")?.to_owned();
            reader.coordinate_systems.insert(name, before);
            before
        }
        "ActiveTransform" => {
            tokens.take()?;
            reader.importer.note("motion", place, "what moves is taken as it is at the start");
            before
        }
        "TransformTimes" => {
            tokens.numbers::<2>()?;
            before
        }
        _ => return Ok(false),
    };
    if reader.state.matrix.is_finite() { Ok(true) } else { Err(at(place, "the transform is not finite any more")) }
}

/// A matrix by its columns. Its last row would make a perspective of it, as a translation in the wrong place does.
fn of_columns(reader: &mut Reader<'_>, m: [f64; 16], place: &Place) -> DAffine3 {
    if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
        let message =
            "of a matrix whose last row is not 0 0 0 1 the others are taken: it stands for no perspective here";
        reader.importer.note("projective", place, message);
    }
    let column = |k: usize| DVec3::new(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// The world as the camera sees it, looking along z, with x to the right.
fn look_at(numbers: [f64; 9], place: &Place) -> Result<DAffine3, SceneError> {
    let [eye, look, up] = [0, 3, 6].map(|k| DVec3::new(numbers[k], numbers[k + 1], numbers[k + 2]));
    let forward =
        (look - eye).try_normalize().ok_or_else(|| at(place, "the eye and what it looks at are one point"))?;
    let right = up.normalize_or_zero().cross(forward).try_normalize();
    let right = right.ok_or_else(|| at(place, "the upward direction lies along the view"))?;
    let camera = DAffine3 { matrix3: DMat3::from_cols(right, forward.cross(right), forward), translation: eye };
    Ok(camera.inverse())
}

/// Directives about attributes of what follows. Whether it was one.
fn attribute(
    reader: &mut Reader<'_>,
    directive: &str,
    tokens: &mut Tokens<'_>,
    place: &Place,
) -> Result<bool, SceneError> {
    match directive {
        "AttributeBegin" | "TransformBegin" => {
            if reader.saved.len() >= MOST_DEPTH {
                return Err(at(place, format!("attributes stand more than {MOST_DEPTH} deep in each other")));
            }
            let state = reader.state.clone();
            reader.saved.push((state, directive == "AttributeBegin"));
        }
        "AttributeEnd" | "TransformEnd" => {
            let Some((saved, is_whole)) = reader.saved.pop() else {
                return Err(at(place, format!("`{directive}` ends nothing that has begun")));
            };
            match is_whole {
                true => reader.state = saved,
                false => reader.state.matrix = saved.matrix,
            }
        }
        "WorldBegin" => {
            reader.state = State { matrix: DAffine3::IDENTITY, ..reader.state.clone() };
            reader.coordinate_systems.insert("world".into(), DAffine3::IDENTITY);
        }
        "ReverseOrientation" => reader.state.is_reversed = !reader.state.is_reversed,
        "MediumInterface" => {
            let inside = tokens.quoted("the name of the medium inside")?.to_owned();
            let outside = match tokens.peek()? {
                Some(Token::Quoted(_)) => tokens.quoted("")?.to_owned(),
                _ => inside.clone(),
            };
            reader.state.media = [inside, outside];
        }
        "Material" => {
            let kind = tokens.quoted("the type of a material")?.to_owned();
            let parameters = tokens.parameters()?;
            reader.state.material = materials::material(reader, &kind, &parameters, place)?;
        }
        "MakeNamedMaterial" => {
            let name = tokens.quoted("a name")?.to_owned();
            let parameters = tokens.parameters()?;
            let kind = parameters.text("type").unwrap_or("").to_owned();
            let material = materials::material(reader, &kind, &parameters, place)?;
            reader.materials.insert(name, material);
        }
        "NamedMaterial" => {
            let name = tokens.quoted("the name of a material")?;
            let known = reader.materials.get(name).cloned();
            reader.state.material = known.ok_or_else(|| at(place, format!("there is no material `{name}`")))?;
        }
        "AreaLightSource" => {
            tokens.quoted("the type of a light")?;
            let parameters = tokens.parameters()?;
            reader.state.light = Some(lights::area(reader, &parameters, place)?);
        }
        _ => return Ok(false),
    }
    Ok(true)
}

fn other(
    reader: &mut Reader<'_>,
    directive: &str,
    tokens: &mut Tokens<'_>,
    place: &Place,
    includes: usize,
) -> Result<(), SceneError> {
    let typed = |tokens: &mut Tokens<'_>| -> Result<(String, Parameters), SceneError> {
        let kind = tokens.quoted("a type")?.to_owned();
        Ok((kind, tokens.parameters()?))
    };
    match directive {
        "Include" | "Import" => {
            let name = tokens.quoted("the name of a file")?;
            if includes >= MOST_INCLUDES {
                return Err(at(place, format!("files include each other more than {MOST_INCLUDES} deep")));
            }
            let (bytes, path) = reader.importer.part_of_scene(name, place)?;
            // What is imported leaves the attributes as they are.
            let state = (directive == "Import").then(|| reader.state.clone());
            run(reader, &bytes, &path, includes + 1)?;
            if let Some(state) = state {
                reader.state = state;
            }
        }
        "Shape" => {
            let (kind, parameters) = typed(tokens)?;
            shapes::shape(reader, &kind, &parameters, place)?;
        }
        "ObjectBegin" => {
            let name = tokens.quoted("a name")?.to_owned();
            if reader.recording.is_some() {
                return Err(at(place, "objects cannot stand in each other"));
            }
            let state = reader.state.clone();
            reader.saved.push((state, true));
            reader.recording = Some((name, Vec::new()));
        }
        "ObjectEnd" => {
            let recorded = reader.recording.take();
            let (name, shapes) = recorded.ok_or_else(|| at(place, "`ObjectEnd` ends nothing that has begun"))?;
            reader.objects.insert(name, shapes.into());
            if let Some((state, _)) = reader.saved.pop() {
                reader.state = state;
            }
        }
        "ObjectInstance" => {
            let name = tokens.quoted("the name of an object")?;
            let shapes = reader.objects.get(name).cloned();
            let shapes = shapes.ok_or_else(|| at(place, format!("there is no object `{name}`")))?;
            let matrix = reader.state.matrix;
            for shape in shapes.iter() {
                reader.place(shapes::Found { matrix: matrix * shape.matrix, ..shape.clone() }, place)?;
            }
        }
        "LightSource" => {
            let (kind, parameters) = typed(tokens)?;
            lights::light(reader, &kind, &parameters, place)?;
        }
        "Camera" => {
            let (kind, parameters) = typed(tokens)?;
            reader.camera(&kind, parameters, place);
        }
        "Film" => {
            let (_, parameters) = typed(tokens)?;
            for (name, side) in [("xresolution", 0), ("yresolution", 1)] {
                reader.film[side] = parameters.number(name).filter(|n| *n >= 1.0).unwrap_or(reader.film[side]);
            }
        }
        "MakeNamedMedium" => {
            let name = tokens.quoted("a name")?.to_owned();
            let parameters = tokens.parameters()?;
            let absorption = materials::absorption(reader, &parameters, place)?;
            reader.media.insert(name, absorption);
        }
        "Texture" => {
            let name = tokens.quoted("a name")?.to_owned();
            tokens.quoted("the type of a texture")?;
            let (class, parameters) = typed(tokens)?;
            let texture = materials::texture(reader, &class, &parameters, place)?;
            reader.textures.insert(name, texture);
        }
        // How to render is not the scene's affair here.
        "Sampler" | "Integrator" | "Accelerator" | "PixelFilter" => _ = typed(tokens)?,
        "Option" => _ = tokens.parameters()?,
        "ColorSpace" => {
            tokens.quoted("the name of a colour space")?;
            reader.importer.note(
                "color_space",
                place,
                "colours are taken for sRGB's primaries, whatever the colour space",
            );
        }
        "Attribute" => {
            _ = typed(tokens)?;
            reader.importer.note("attribute", place, "default parameters of the directive Attribute are left out");
        }
        "WorldEnd" => {}
        _ => return Err(at(place, format!("there is no directive `{directive}`"))),
    }
    Ok(())
}
