//! What is known while a pbrt scene is read.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DAffine3, DVec3};

use super::lights::Sky;
use super::materials::{Material, Texture};
use super::shapes::Found;
use super::tokens::Parameters;
use crate::formats::files::Input;
use crate::formats::importing::media::Side;
use crate::formats::importing::place::{Placed, reflected};
use crate::formats::importing::{Importer, Matter};
use crate::scene::Place;
use crate::scene::description::{CameraDescription, Light, Refractor};
use crate::scene::{Description, SceneError};

/// Of a film and a camera that give none.
const FILM: [f64; 2] = [1280.0, 720.0];
const DEFAULT_FOV: f64 = 90.0;

/// Attributes of what follows.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub matrix: DAffine3,
    pub is_reversed: bool,
    pub material: Material,
    pub light: Option<Light>,
    /// Names of the media inside and outside; empty for none.
    pub media: [String; 2],
}

pub(super) struct Reader<'a> {
    pub importer: Importer<'a>,
    pub state: State,
    /// States to go back to; of some, the transform alone.
    pub saved: Vec<(State, bool)>,
    pub coordinate_systems: HashMap<String, DAffine3>,
    pub materials: HashMap<String, Material>,
    pub textures: HashMap<String, Texture>,
    /// What media absorb.
    pub media: HashMap<String, [f64; 3]>,
    pub objects: HashMap<String, Rc<[Found]>>,
    /// The object whose shapes are listed.
    pub recording: Option<(String, Vec<Found>)>,
    pub film: [f64; 2],
    /// Of all files so far.
    pub bytes: usize,
    camera: Option<Camera>,
    /// Added when all indices are known.
    waiting: Vec<(Found, Place)>,
    lamps: Vec<Lamp>,
    pub sky: Option<Sky>,
}

/// A light without a surface, with its name and the medium that it is declared to be in.
pub(super) struct Lamp {
    pub name: &'static str,
    pub placed: Placed,
    pub light: Light,
    pub medium: String,
    pub place: Place,
}

struct Camera {
    world_from_camera: DAffine3,
    parameters: Parameters,
    medium: String,
    place: Place,
}

impl<'a> Reader<'a> {
    pub fn new(input: &'a Input<'a>) -> Self {
        let state = State {
            matrix: DAffine3::IDENTITY,
            is_reversed: false,
            material: Material::unspecified(),
            light: None,
            media: Default::default(),
        };
        Self {
            importer: Importer::new("pbrt", input),
            state,
            saved: Vec::new(),
            coordinate_systems: HashMap::new(),
            materials: HashMap::new(),
            textures: HashMap::new(),
            media: HashMap::new(),
            objects: HashMap::new(),
            recording: None,
            film: FILM,
            bytes: 0,
            camera: None,
            waiting: Vec::new(),
            lamps: Vec::new(),
            sky: None,
        }
    }

    /// Takes a shape that stands in the scene, or in the object that is listed.
    pub fn place(&mut self, found: Found, place: &Place) -> Result<(), SceneError> {
        let count = self.recording.as_ref().map_or(self.waiting.len(), |(_, shapes)| shapes.len());
        if count >= crate::formats::importing::MOST_OBJECTS {
            return Err(crate::formats::importing::at(place, "the scene has too many objects"));
        }
        match &mut self.recording {
            Some((_, shapes)) => shapes.push(found),
            None => self.waiting.push((found, place.clone())),
        }
        Ok(())
    }

    pub fn lamp(&mut self, lamp: Lamp) {
        self.lamps.push(lamp);
    }

    pub fn camera(&mut self, kind: &str, parameters: Parameters, place: &Place) {
        if kind != "perspective" {
            let message = format!("cameras of the type {kind} are taken for a perspective one");
            self.importer.note("sensor", place, message);
        }
        let world_from_camera = self.state.matrix.inverse();
        self.coordinate_systems.insert("camera".into(), world_from_camera);
        let medium = self.state.media[1].clone();
        self.camera = Some(Camera { world_from_camera, parameters, medium, place: place.clone() });
    }

    pub fn finish(mut self) -> Result<Description, SceneError> {
        let is_mirrored = self.take_camera()?;
        if let Some(sky) = self.sky.take() {
            sky.add(&mut self.importer, is_mirrored);
        }
        let indices = indices(&self.waiting);
        let waiting = std::mem::take(&mut self.waiting);
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        for (found, place) in waiting {
            let matrix = if is_mirrored { mirror * found.matrix } else { found.matrix };
            let placed = found.surface.placed(&found, &matrix);
            let [inside, outside] = [0, 1].map(|k| self.side(&found.media[k], &indices));
            let name = found.name.clone();
            if let Some(light) = found.light.clone() {
                let around = (!found.media[1].is_empty()).then_some(outside);
                let is_flipped = found.surface.is_flipped(&found, &matrix);
                let shone = crate::formats::importing::place::shining(placed, is_flipped);
                self.importer.add(&name, shone, Matter::Light { light, around }, &place)?;
                continue;
            }
            let matter = match found.material {
                Material::Dielectric { eta, is_glass, formula, refractor } => {
                    let around = outside.ior.unwrap_or(1.0);
                    // No medium begins at a thin wall.
                    let inside = if refractor.thin { Side::clear() } else { inside };
                    if is_glass && around != 1.0 {
                        let message = format!(
                            "pbrt takes the index of a glass relative to what is outside, here `{}` of {around}: if the glass itself is meant, its \
                             eta there is {:.5}",
                            outside.name,
                            eta / around
                        );
                        self.importer.note("relative_glass", &place, message);
                    }
                    if formula.is_some() && around != 1.0 && !is_glass {
                        let message = "spectra of indices relative to another medium are taken at 587.56 nm";
                        self.importer.note("dispersion_of_file", &place, message);
                    }
                    let formula = formula.filter(|_| around == 1.0);
                    let inside = Side { ior: Some(eta * around), formula, ..inside };
                    Matter::Refractor { refractor, inside, outside: Side { ior: Some(around), ..outside } }
                }
                // Around what is taken for clear there is nothing to see.
                Material::Null if !inside.absorbs_as(&outside) => {
                    let (inside, outside) = (Side { ior: None, ..inside }, Side { ior: None, ..outside });
                    Matter::Refractor { refractor: Refractor::of(""), inside, outside }
                }
                Material::Null => continue,
                Material::Solid(solid) => Matter::Solid(solid),
            };
            self.importer.add(&name, placed, matter, &place)?;
        }
        for Lamp { name, placed, light, medium, place } in std::mem::take(&mut self.lamps) {
            let around = (!medium.is_empty()).then(|| self.side(&medium, &indices));
            let placed = if is_mirrored { reflected(placed) } else { placed };
            self.importer.add(name, placed, Matter::Light { light, around }, &place)?;
        }
        self.importer.finish()
    }

    /// What is known of a medium by its name.
    fn side(&self, name: &str, indices: &HashMap<String, f64>) -> Side {
        if name.is_empty() {
            return Side::default();
        }
        let absorption = self.media.get(name).copied().unwrap_or_default();
        Side { ior: indices.get(name).copied(), absorption: Some(absorption), name: name.to_owned(), ..Side::default() }
    }

    /// Whether the scene must be mirrored in x, so that its picture is that of pbrt, whose coordinates are left-handed.
    fn take_camera(&mut self) -> Result<bool, SceneError> {
        let Some(Camera { world_from_camera, parameters, medium, place }) = self.camera.take() else {
            return Ok(false);
        };
        let axes = world_from_camera.matrix3;
        let [right, up, forward] = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::normalize_or_zero);
        if !(world_from_camera.is_finite() && forward != DVec3::ZERO) {
            return Err(crate::formats::importing::at(&place, "the camera's transform cannot be inverted"));
        }
        let is_mirrored = forward.cross(up).dot(right) < 0.0;
        let turn = |v: DVec3| if is_mirrored { DVec3::new(-v.x, v.y, v.z) } else { v };
        if is_mirrored {
            self.importer.note(
                "left_handed",
                &place,
                "pbrt's coordinates are left-handed: x is turned round, so that the picture is the same",
            );
        }
        let [width, height] = self.film;
        let aspect = parameters.number("frameaspectratio").filter(|a| *a > 0.0).unwrap_or(width / height);
        let fov = parameters.number("fov").unwrap_or(DEFAULT_FOV);
        if !(fov > 0.0 && fov < 180.0) {
            return Err(crate::formats::importing::at(&place, format!("`fov` is {fov}, must be between 0 and 180")));
        }
        // It is the angle over the shorter side.
        let over_height = (0.5 * fov.to_radians()).tan() / aspect.min(1.0);
        let lens = parameters.number("lensradius").unwrap_or(0.0).max(0.0);
        let focus = parameters.number("focaldistance").filter(|d| *d > 0.0 && lens > 0.0).unwrap_or(1.0);
        let position = turn(world_from_camera.translation);
        self.importer.camera = Some(CameraDescription {
            position,
            target: position + turn(forward) * focus,
            up: turn(up),
            vertical_fov: 2.0 * over_height.atan().to_degrees(),
            aperture_radius: lens,
            focus_distance: None,
        });
        if !medium.is_empty() {
            self.importer.camera_medium = Some(Side { ior: None, ..self.side(&medium, &HashMap::new()) });
        }
        Ok(is_mirrored)
    }
}

/// The indices of media by their names: of each the `eta` of a surface that it is inside of, times the index outside of that.
fn indices(waiting: &[(Found, Place)]) -> HashMap<String, f64> {
    let mut known: HashMap<String, f64> = HashMap::new();
    loop {
        let before = known.len();
        for (found, _) in waiting {
            let Material::Dielectric { eta, ref refractor, .. } = found.material else { continue };
            if refractor.thin {
                continue;
            }
            let [inside, outside] = &found.media;
            let around = if outside.is_empty() { Some(1.0) } else { known.get(outside).copied() };
            if let (Some(around), false) = (around, inside.is_empty() || inside == outside) {
                known.entry(inside.clone()).or_insert(eta * around);
            }
        }
        if known.len() == before {
            return known;
        }
    }
}
