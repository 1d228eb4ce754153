//! The scene for pbrt-v4: a text file, with its meshes and images beside it.
//!
//! pbrt's `eta` is the index inside over that outside, and every surface names the media on both of its sides.

use std::fmt::Write;

use super::files::{Bundle, exr_bytes};
use super::pieces::Piece;
use super::scene::{Frame, Lamp, ResolvedScene, TextureFiles, ThinWall, list};
use crate::formats::{PlyExtra, ply_bytes};
use crate::scene::Albedo;
use crate::scene::description::Environment;
use crate::scene::equal_area;
use crate::scene::lights::EnvironmentLight;
use crate::scene::{MediumId, ObjectId, Surface};

/// Segments of a path at the most: pbrt has no way to say that there is no cap.
const MAX_DEPTH: u32 = 10_000;
/// Side of the square image that stands for an environment that is none, in pixels.
const GRADIENT_SIDE: usize = 512;
/// The most of the side of one that is.
const MOST_SIDE: usize = 4096;

/// Wavelengths in nanometres that indices are given at: those that pbrt renders.
const SPECTRUM: std::ops::RangeInclusive<u32> = 360..=830;
const SPECTRUM_STEP: usize = 5;

pub fn write(resolved: &ResolvedScene, frame: Frame) -> Bundle {
    let (files, textures) = (Bundle::new(resolved.notes.clone()), TextureFiles::default());
    let mut writer = Writer { resolved, text: String::new(), files, textures };
    writer.scene(frame);
    let Writer { text, mut files, .. } = writer;
    files.add_main("scene.pbrt", text.into_bytes());
    files
}

struct Writer<'a> {
    resolved: &'a ResolvedScene,
    text: String,
    files: Bundle,
    textures: TextureFiles,
}

fn triple(v: impl Into<[f64; 3]>) -> String {
    let [x, y, z] = v.into();
    format!("{x:?} {y:?} {z:?}")
}

fn rgb(name: &str, value: [f64; 3]) -> String {
    format!("\"rgb {name}\" [ {} ]", triple(value))
}

impl Writer<'_> {
    fn line(&mut self, line: impl AsRef<str>) {
        let _ = writeln!(self.text, "{}", line.as_ref());
    }

    fn scene(&mut self, frame: Frame) {
        let resolved = self.resolved;
        let camera = resolved.description().camera;
        self.line("# Every interface with the media on both of its sides, as IOR rectification found them.");
        self.line("Integrator \"volpath\"");
        self.line(format!("  \"integer maxdepth\" {MAX_DEPTH}"));
        self.line(format!("Sampler \"zsobol\" \"integer pixelsamples\" {}", frame.samples));
        self.line("PixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5");
        self.line("Film \"rgb\" \"string filename\" \"scene.exr\"");
        self.line(format!("  \"integer xresolution\" {} \"integer yresolution\" {}", frame.width, frame.height));
        // Coordinates are right-handed here and left-handed there.
        self.line("Scale -1 1 1");
        let [position, target, up] = [camera.position, camera.target, camera.up].map(triple);
        self.line(format!("LookAt {position}  {target}  {up}"));
        // Media are named before the camera that stands in one.
        for id in resolved.absorbing() {
            let medium = resolved.medium(id);
            self.line(format!("# {}", comment(&medium.name)));
            self.line(format!("MakeNamedMedium \"{}\" \"string type\" \"homogeneous\"", medium_name(id)));
            self.line(format!("  {} \"rgb sigma_s\" [ 0 0 0 ]", rgb("sigma_a", medium.absorption.to_rgb())));
        }
        let around = self.medium(resolved.camera_medium);
        self.line(format!("MediumInterface \"\" {around}"));
        // The angle is that over the shorter side.
        let tangent = (0.5 * camera.vertical_fov).to_radians().tan();
        let aspect = f64::from(frame.width) / f64::from(frame.height);
        let fov = 2.0 * (tangent * aspect.min(1.0)).atan().to_degrees();
        self.line(format!("Camera \"perspective\" \"float fov\" {fov:?}"));
        if camera.aperture_radius > 0.0 {
            let focus = camera.focus_distance.unwrap_or_else(|| camera.position.distance(camera.target));
            self.line(format!("  \"float lensradius\" {:?} \"float focaldistance\" {focus:?}", camera.aperture_radius));
        }
        self.line("WorldBegin");
        self.environment();
        self.lamps();
        self.interfaces();
        self.walls();
        self.opaque();
    }

    /// The quoted name of a medium that absorbs; of another, empty.
    fn medium(&self, id: MediumId) -> String {
        if self.resolved.absorbs(id) { format!("\"{}\"", medium_name(id)) } else { "\"\"".into() }
    }

    fn environment(&mut self) {
        let resolved = self.resolved;
        match &resolved.scene().environment {
            light if light.is_black() => {}
            EnvironmentLight::Constant(color) => {
                self.line(format!("LightSource \"infinite\" {}", rgb("L", color.to_rgb())));
            }
            light => {
                let side = match &resolved.description().environment {
                    Environment::Image { image, .. } => (2 * image.height).clamp(16, MOST_SIDE),
                    _ => GRADIENT_SIDE,
                };
                let pixel = |x: usize, y: usize| {
                    let at = [x, y].map(|k| (k as f64 + 0.5) / side as f64);
                    light.radiance(equal_area::direction(at)).to_rgb().map(|c| c as f32)
                };
                self.files.add("environment.exr", exr_bytes(side, side, pixel));
                self.line("LightSource \"infinite\" \"string filename\" \"environment.exr\"");
            }
        }
    }

    fn lamps(&mut self) {
        for (object, lamp) in self.resolved.lamps() {
            let name = &self.resolved.scene().object(object).name;
            let around = self.medium(self.resolved.medium_around(object));
            self.line(format!("AttributeBegin # {}", comment(name)));
            self.line(format!("  MediumInterface \"\" {around}"));
            match lamp {
                Lamp::Point { position, intensity } => {
                    self.line(format!("  LightSource \"point\" \"point3 from\" [ {} ]", triple(position)));
                    self.line(format!("    {}", rgb("I", intensity)));
                }
                Lamp::Spot { position, axis, intensity, half_angles: [inner, outer] } => {
                    let [from, to] = [position, position + axis].map(triple);
                    self.line(format!("  LightSource \"spot\" \"point3 from\" [ {from} ] \"point3 to\" [ {to} ]"));
                    self.line(format!(
                        "    \"float coneangle\" {outer:?} \"float conedeltaangle\" {:?}",
                        outer - inner
                    ));
                    self.line(format!("    {}", rgb("I", intensity)));
                }
                Lamp::Directional { direction, irradiance, .. } => {
                    let from = triple(-direction);
                    self.line(format!("  LightSource \"distant\" \"point3 from\" [ {from} ] \"point3 to\" [ 0 0 0 ]"));
                    self.line(format!("    {}", rgb("L", irradiance)));
                }
            }
            self.line("AttributeEnd");
        }
        self.files.notes.extend(self.resolved.notes_of_lamps("pbrt", true));
    }

    fn interfaces(&mut self) {
        let resolved = self.resolved;
        for (index, interface) in resolved.interfaces.iter().enumerate() {
            let (outside, inside) = (resolved.medium(interface.outside), resolved.medium(interface.inside));
            let name = &resolved.scene().object(interface.refractor).name;
            let sides = [&outside.name, &inside.name].map(|name| comment(name)).join(" | ");
            self.line(format!("AttributeBegin # {}: {sides}", comment(name)));
            let [inner, outer] = [interface.inside, interface.outside].map(|id| self.medium(id));
            self.line(format!("  MediumInterface {inner} {outer}"));
            let eta = self.eta(interface.inside, interface.outside);
            self.line(format!("  Material \"dielectric\" {eta}"));
            self.roughness(interface.refractor);
            let file = format!("{}.{index}.ply", resolved.name(interface.refractor));
            self.shape(&interface.piece, &file, None);
            self.line("AttributeEnd");
        }
    }

    /// The index inside over that outside, of one number or by wavelengths.
    fn eta(&self, inside: MediumId, outside: MediumId) -> String {
        let ratio = self.resolved.medium(inside).ior() / self.resolved.medium(outside).ior();
        let sides = [inside, outside].map(|id| self.resolved.ior_of(id));
        let at = |nm: u32| {
            let [inside, outside] = sides.map(|index| 1.0 + index.ior_minus_one(1e-3 * f64::from(nm)));
            inside / outside
        };
        let pairs: Vec<(u32, f64)> = SPECTRUM.step_by(SPECTRUM_STEP).map(|nm| (nm, at(nm))).collect();
        let is_one = !sides.iter().any(|index| index.is_dispersive());
        // Formulas may have no answer far from where they were measured.
        if is_one || pairs.iter().any(|(_, eta)| !(eta.is_finite() && *eta > 0.0)) {
            return format!("\"float eta\" {ratio:?}");
        }
        let pairs: Vec<String> = pairs.iter().map(|(nm, eta)| format!("{nm} {eta:.8}")).collect();
        format!("\"spectrum eta\" [ {} ]", pairs.join(" "))
    }

    fn roughness(&mut self, object: ObjectId) {
        let [u, v] = self.resolved.roughness(object);
        if [u, v] == [0.0; 2] {
            return;
        }
        let alpha = match u == v {
            true => format!("\"float roughness\" {u:?}"),
            false => format!("\"float uroughness\" {u:?} \"float vroughness\" {v:?}"),
        };
        self.line(format!("    {alpha} \"bool remaproughness\" false"));
    }

    fn walls(&mut self) {
        let resolved = self.resolved;
        for ThinWall { object, piece, inside, outside } in &resolved.walls {
            self.line(format!("AttributeBegin # {}, a thin wall", comment(&resolved.scene().object(*object).name)));
            let around = self.medium(*outside);
            self.line(format!("  MediumInterface {around} {around}"));
            let eta = self.eta(*inside, *outside);
            self.line(format!("  Material \"thindielectric\" {eta}"));
            self.shape(piece, &format!("{}.ply", resolved.name(*object)), None);
            self.line("AttributeEnd");
        }
        self.files.notes.extend(resolved.notes_of_walls("pbrt"));
        let dispersive = resolved.dispersive();
        if !dispersive.is_empty() {
            self.files.notes.push(format!("{}: colours are dispersed in pbrt, and not here", list(&dispersive)));
        }
    }

    fn shape(&mut self, piece: &Piece, file: &str, object: Option<ObjectId>) {
        let is_varied = object.is_some_and(|object| self.resolved.is_varied(object));
        match piece {
            Piece::Sphere { center, radius } if !is_varied => {
                self.line(format!("  Translate {}", triple(*center)));
                self.line(format!("  Shape \"sphere\" \"float radius\" {radius:?}"));
            }
            piece => {
                let (mesh, uv) = match object {
                    Some(object) => self.resolved.mesh_with_uv(object, piece),
                    None => (piece.clone().into_mesh(), Vec::new()),
                };
                self.files.add(format!("meshes/{file}"), ply_bytes(&mesh, PlyExtra { uv: &uv, ..PlyExtra::default() }));
                self.line(format!("  Shape \"plymesh\" \"string filename\" \"meshes/{file}\""));
            }
        }
    }

    fn opaque(&mut self) {
        let resolved = self.resolved;
        for (object, piece) in &resolved.opaque {
            let name = &resolved.scene().object(*object).name;
            self.line(format!("AttributeBegin # {}", comment(name)));
            match resolved.emission(*object) {
                Some((radiance, two_sided)) => {
                    let around = self.medium(resolved.medium_around(*object));
                    self.line(format!("  MediumInterface {around} {around}"));
                    self.line("  Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]");
                    self.line(format!("  AreaLightSource \"diffuse\" {}", rgb("L", radiance)));
                    self.line(format!("    \"bool twosided\" {two_sided}"));
                }
                None => self.solid(*object),
            }
            self.shape(piece, &format!("{}.ply", resolved.name(*object)), Some(*object));
            self.line("AttributeEnd");
        }
    }

    fn solid(&mut self, object: ObjectId) {
        let resolved = self.resolved;
        let Some(albedo) = resolved.albedo(object) else { return };
        let is_mirror = matches!(self.resolved.scene().object(object).surface, Surface::Mirror { .. });
        let (material, parameter) = if is_mirror { ("conductor", "reflectance") } else { ("diffuse", "reflectance") };
        match albedo {
            Albedo::Color(color) => {
                // A conductor refuses a reflectance of 1.
                let value = color.to_rgb().map(|c| if is_mirror { c.min(0.9999) } else { c });
                self.line(format!("  Material \"{material}\" {}", rgb(parameter, value)));
            }
            Albedo::Texture(texture) => {
                let name = self.resolved.name(object);
                let path = self.textures.path(texture, name, &mut self.files);
                self.line(format!("  Texture \"image-{name}\" \"spectrum\" \"imagemap\""));
                // Without smaller copies of it, as this program looks it up.
                self.line(format!("    \"string filename\" \"{path}\" \"string filter\" \"bilinear\""));
                self.line(format!("  Material \"{material}\" \"texture {parameter}\" \"image-{name}\""));
            }
            Albedo::Checker { a, b, .. } => {
                let texture = format!("chequers-{}", self.resolved.name(object));
                self.line(format!("  Texture \"{texture}\" \"spectrum\" \"checkerboard\""));
                // Coordinates count two squares to a unit.
                self.line("    \"float uscale\" 2 \"float vscale\" 2");
                self.line(format!("    {} {}", rgb("tex1", a.to_rgb()), rgb("tex2", b.to_rgb())));
                self.line(format!("  Material \"{material}\" \"texture {parameter}\" \"{texture}\""));
            }
        }
        self.roughness(object);
    }
}

fn medium_name(medium: MediumId) -> String {
    format!("medium-{}", medium.0)
}

/// Text for a comment, which ends with its line.
fn comment(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '_' } else { c }).collect()
}
