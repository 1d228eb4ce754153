//! The scene for Mitsuba 3: an XML file, with its meshes and images beside it.
//!
//! Every interface is a `dielectric` with both of its indices, and the media that absorb are `homogeneous` ones on both of its sides. Mitsuba
//! scales radiance by n² as this program does.

use std::fmt::Write;

use super::files::{Bundle, environment_exr};
use super::pieces::Piece;
use super::scene::{Frame, Lamp, ResolvedScene, TextureFiles, ThinWall, list};
use crate::formats::{PlyExtra, ply_bytes};
use crate::scene::Albedo;
use crate::scene::lights::EnvironmentLight;
use crate::scene::{MediumId, ObjectId, Surface};

/// Segments of a path at the most: Mitsuba has no cap with −1.
const NO_CAP: i32 = -1;

pub fn write(resolved: &ResolvedScene, frame: Frame) -> Bundle {
    let (files, textures) = (Bundle::new(resolved.notes.clone()), TextureFiles::default());
    let mut writer = Writer { resolved, text: String::new(), files, textures };
    writer.scene(frame);
    let Writer { text, mut files, .. } = writer;
    files.add_main("scene.xml", text.into_bytes());
    files
}

struct Writer<'a> {
    resolved: &'a ResolvedScene,
    text: String,
    files: Bundle,
    textures: TextureFiles,
}

/// A vector as Mitsuba reads it.
fn triple(v: impl Into<[f64; 3]>) -> String {
    let [x, y, z] = v.into();
    format!("{x:?}, {y:?}, {z:?}")
}

fn rgb(name: &str, value: [f64; 3]) -> String {
    format!("<rgb name=\"{name}\" value=\"{}\"/>", triple(value))
}

impl Writer<'_> {
    fn line(&mut self, depth: usize, line: impl AsRef<str>) {
        let _ = writeln!(self.text, "{:depth$}{}", "", line.as_ref(), depth = 2 * depth);
    }

    fn scene(&mut self, frame: Frame) {
        let resolved = self.resolved;
        let absorbing = resolved.absorbing();
        self.line(0, "<?xml version=\"1.0\" encoding=\"utf-8\"?>");
        self.line(0, "<!-- Every interface with the media on both of its sides, as IOR rectification found them. -->");
        self.line(0, "<scene version=\"3.0.0\">");
        // Colours that are absorbed by different amounts want weights over all of them.
        let is_coloured = absorbing.iter().any(|id| {
            let [r, g, b] = resolved.medium(*id).absorption.to_rgb();
            r != g || g != b
        });
        let integrator = if absorbing.is_empty() {
            "path"
        } else if is_coloured {
            "volpathmis"
        } else {
            "volpath"
        };
        self.line(1, format!("<integrator type=\"{integrator}\">"));
        self.line(2, format!("<integer name=\"max_depth\" value=\"{NO_CAP}\"/>"));
        self.line(1, "</integrator>");
        for id in absorbing {
            let medium = resolved.medium(id);
            self.line(1, format!("<medium type=\"homogeneous\" id=\"{}\">", medium_id(id)));
            self.line(2, format!("<!-- {} -->", comment(&medium.name)));
            self.line(2, rgb("albedo", [0.0; 3]));
            self.line(2, rgb("sigma_t", medium.absorption.to_rgb()));
            self.line(1, "</medium>");
        }
        self.sensor(frame);
        self.environment();
        self.lamps();
        self.interfaces();
        self.walls();
        self.opaque();
        self.line(0, "</scene>");
    }

    fn sensor(&mut self, frame: Frame) {
        let resolved = self.resolved;
        let camera = resolved.description().camera;
        let is_lens = camera.aperture_radius > 0.0;
        self.line(1, format!("<sensor type=\"{}\">", if is_lens { "thinlens" } else { "perspective" }));
        self.line(2, "<string name=\"fov_axis\" value=\"y\"/>");
        self.line(2, format!("<float name=\"fov\" value=\"{:?}\"/>", camera.vertical_fov));
        let reach = resolved.reach();
        self.line(2, format!("<float name=\"near_clip\" value=\"{:?}\"/>", 1e-4 * reach));
        self.line(2, format!("<float name=\"far_clip\" value=\"{:?}\"/>", 1e4 * reach));
        if is_lens {
            let focus = camera.focus_distance.unwrap_or_else(|| camera.position.distance(camera.target));
            self.line(2, format!("<float name=\"aperture_radius\" value=\"{:?}\"/>", camera.aperture_radius));
            self.line(2, format!("<float name=\"focus_distance\" value=\"{focus:?}\"/>"));
        }
        self.line(2, "<transform name=\"to_world\">");
        let [origin, target, up] = [camera.position, camera.target, camera.up].map(triple);
        self.line(3, format!("<lookat origin=\"{origin}\" target=\"{target}\" up=\"{up}\"/>"));
        self.line(2, "</transform>");
        self.line(2, "<film type=\"hdrfilm\">");
        self.line(3, format!("<integer name=\"width\" value=\"{}\"/>", frame.width));
        self.line(3, format!("<integer name=\"height\" value=\"{}\"/>", frame.height));
        self.line(3, "<string name=\"pixel_format\" value=\"rgb\"/>");
        self.line(3, "<string name=\"component_format\" value=\"float32\"/>");
        self.line(3, "<rfilter type=\"box\"/>");
        self.line(2, "</film>");
        self.line(2, "<sampler type=\"independent\">");
        self.line(3, format!("<integer name=\"sample_count\" value=\"{}\"/>", frame.samples));
        self.line(2, "</sampler>");
        if resolved.absorbs(resolved.camera_medium) {
            self.line(2, format!("<ref id=\"{}\"/>", medium_id(resolved.camera_medium)));
        }
        self.line(1, "</sensor>");
    }

    fn environment(&mut self) {
        match &self.resolved.scene().environment {
            light if light.is_black() => {}
            EnvironmentLight::Constant(color) => {
                self.line(1, "<emitter type=\"constant\">");
                self.line(2, rgb("radiance", color.to_rgb()));
                self.line(1, "</emitter>");
            }
            light => {
                let (rotation, bytes) = environment_exr(self.resolved, light);
                self.files.add("environment.exr", bytes);
                self.line(1, "<emitter type=\"envmap\">");
                self.line(2, "<string name=\"filename\" value=\"environment.exr\"/>");
                // Its images begin half a turn away from ours.
                self.line(2, "<transform name=\"to_world\">");
                self.line(3, format!("<rotate y=\"1\" angle=\"{:?}\"/>", rotation + 180.0));
                self.line(2, "</transform>");
                self.line(1, "</emitter>");
            }
        }
    }

    fn lamps(&mut self) {
        for (object, lamp) in self.resolved.lamps() {
            match lamp {
                Lamp::Point { position, intensity } => {
                    self.line(1, "<emitter type=\"point\">");
                    self.line(2, format!("<point name=\"position\" value=\"{}\"/>", triple(position)));
                    self.line(2, rgb("intensity", intensity));
                }
                Lamp::Spot { position, axis, intensity, half_angles: [inner, outer] } => {
                    self.line(1, "<emitter type=\"spot\">");
                    let up = axis.any_orthonormal_vector();
                    let [from, to, up] = [position, position + axis, up].map(triple);
                    self.line(2, "<transform name=\"to_world\">");
                    self.line(3, format!("<lookat origin=\"{from}\" target=\"{to}\" up=\"{up}\"/>"));
                    self.line(2, "</transform>");
                    self.line(2, rgb("intensity", intensity));
                    self.line(2, format!("<float name=\"cutoff_angle\" value=\"{outer:?}\"/>"));
                    self.line(2, format!("<float name=\"beam_width\" value=\"{:?}\"/>", inner.min(0.999 * outer)));
                }
                Lamp::Directional { direction, irradiance, .. } => {
                    self.line(1, "<emitter type=\"directional\">");
                    self.line(2, format!("<vector name=\"direction\" value=\"{}\"/>", triple(direction)));
                    self.line(2, rgb("irradiance", irradiance));
                }
            }
            let medium = self.resolved.medium_around(object);
            if self.resolved.absorbs(medium) && !matches!(lamp, Lamp::Directional { .. }) {
                self.line(2, format!("<ref id=\"{}\"/>", medium_id(medium)));
            }
            self.line(1, "</emitter>");
        }
        self.files.notes.extend(self.resolved.notes_of_lamps("Mitsuba", true));
    }

    fn interfaces(&mut self) {
        let resolved = self.resolved;
        for (index, interface) in resolved.interfaces.iter().enumerate() {
            let (outside, inside) = (resolved.medium(interface.outside), resolved.medium(interface.inside));
            let name = &resolved.scene().object(interface.refractor).name;
            self.line(1, format!("<!-- {}: {} | {} -->", comment(name), comment(&outside.name), comment(&inside.name)));
            let file = format!("{}.{index}.ply", resolved.name(interface.refractor));
            let is_smooth = self.shape(&interface.piece, &file, None);
            // Mitsuba refuses rough ones between equal indices.
            let roughness = resolved.roughness(interface.refractor);
            let is_rough = roughness != [0.0; 2] && inside.ior() != outside.ior();
            self.dielectric(
                if is_rough { "roughdielectric" } else { "dielectric" },
                interface.inside,
                interface.outside,
            );
            if is_rough {
                self.alpha(3, roughness);
            }
            self.line(2, "</bsdf>");
            for (side, medium) in [("interior", interface.inside), ("exterior", interface.outside)] {
                if resolved.absorbs(medium) {
                    self.line(2, format!("<ref name=\"{side}\" id=\"{}\"/>", medium_id(medium)));
                }
            }
            self.end_of_shape(is_smooth);
        }
    }

    /// Begins the BSDF of a dielectric.
    fn dielectric(&mut self, kind: &str, inside: MediumId, outside: MediumId) {
        let [inside, outside] = [inside, outside].map(|id| self.resolved.medium(id).ior());
        self.line(2, format!("<bsdf type=\"{kind}\">"));
        self.line(3, format!("<float name=\"int_ior\" value=\"{inside:?}\"/>"));
        self.line(3, format!("<float name=\"ext_ior\" value=\"{outside:?}\"/>"));
    }

    fn alpha(&mut self, depth: usize, [u, v]: [f64; 2]) {
        self.line(depth, "<string name=\"distribution\" value=\"ggx\"/>");
        if u == v {
            self.line(depth, format!("<float name=\"alpha\" value=\"{u:?}\"/>"));
        } else {
            self.line(depth, format!("<float name=\"alpha_u\" value=\"{u:?}\"/>"));
            self.line(depth, format!("<float name=\"alpha_v\" value=\"{v:?}\"/>"));
        }
    }

    fn walls(&mut self) {
        let resolved = self.resolved;
        for ThinWall { object, piece, inside, outside } in &resolved.walls {
            let name = &resolved.scene().object(*object).name;
            self.line(1, format!("<!-- {}, a thin wall -->", comment(name)));
            let is_smooth = self.shape(piece, &format!("{}.ply", resolved.name(*object)), None);
            self.dielectric("thindielectric", *inside, *outside);
            self.line(2, "</bsdf>");
            self.end_of_shape(is_smooth);
        }
        self.files.notes.extend(resolved.notes_of_walls("Mitsuba"));
        let dispersive = resolved.dispersive();
        if !dispersive.is_empty() {
            let what = "dielectrics of Mitsuba do not disperse: all colours get the IOR at 587.56 nm";
            self.files.notes.push(format!("{}: {what}", list(&dispersive)));
        }
    }

    /// Begins a shape; says whether it has normals of its own, or needs none.
    fn shape(&mut self, piece: &Piece, file: &str, object: Option<ObjectId>) -> bool {
        match piece {
            Piece::Sphere { center, radius } if object.is_none_or(|object| !self.resolved.is_varied(object)) => {
                self.line(1, "<shape type=\"sphere\">");
                self.line(2, format!("<point name=\"center\" value=\"{}\"/>", triple(*center)));
                self.line(2, format!("<float name=\"radius\" value=\"{radius:?}\"/>"));
                true
            }
            piece => {
                let (mesh, uv) = match object {
                    Some(object) => self.resolved.mesh_with_uv(object, piece),
                    None => (piece.clone().into_mesh(), Vec::new()),
                };
                // Mitsuba counts v from the upper row of an image.
                let has_image = object.is_some_and(|o| matches!(self.resolved.albedo(o), Some(Albedo::Texture(_))));
                let uv: Vec<[f64; 2]> =
                    if has_image { uv.into_iter().map(|[u, v]| [u, 1.0 - v]).collect() } else { uv };
                self.files.add(format!("meshes/{file}"), ply_bytes(&mesh, PlyExtra { uv: &uv, ..PlyExtra::default() }));
                self.line(1, "<shape type=\"ply\">");
                self.line(2, format!("<string name=\"filename\" value=\"meshes/{file}\"/>"));
                !mesh.normals.is_empty()
            }
        }
    }

    fn end_of_shape(&mut self, is_smooth: bool) {
        if !is_smooth {
            self.line(2, "<boolean name=\"face_normals\" value=\"true\"/>");
        }
        self.line(1, "</shape>");
    }

    fn opaque(&mut self) {
        let resolved = self.resolved;
        for (object, piece) in &resolved.opaque {
            let name = &resolved.scene().object(*object).name;
            self.line(1, format!("<!-- {} -->", comment(name)));
            let is_smooth = self.shape(piece, &format!("{}.ply", resolved.name(*object)), Some(*object));
            match resolved.emission(*object) {
                Some((radiance, two_sided)) => {
                    self.line(2, "<bsdf type=\"diffuse\">");
                    self.line(3, rgb("reflectance", [0.0; 3]));
                    self.line(2, "</bsdf>");
                    self.line(2, "<emitter type=\"area\">");
                    self.line(3, rgb("radiance", radiance));
                    self.line(2, "</emitter>");
                    let around = resolved.medium_around(*object);
                    if resolved.absorbs(around) {
                        self.line(2, format!("<ref name=\"exterior\" id=\"{}\"/>", medium_id(around)));
                    }
                    self.end_of_shape(is_smooth);
                    if two_sided {
                        self.back_of_light(*object, piece, radiance);
                    }
                }
                None => {
                    self.solid(*object);
                    self.end_of_shape(is_smooth);
                }
            }
        }
    }

    /// The other side of a light with two, turned over.
    fn back_of_light(&mut self, object: ObjectId, piece: &Piece, radiance: [f64; 3]) {
        let file = format!("{}.ply", self.resolved.name(object));
        match piece {
            // Nothing is seen of the inward side of a closed surface from outside; from inside it is the same light.
            Piece::Sphere { .. } => _ = self.shape(piece, &file, Some(object)),
            Piece::Mesh(_) => {
                self.line(1, "<shape type=\"ply\">");
                self.line(2, format!("<string name=\"filename\" value=\"meshes/{file}\"/>"));
            }
        }
        self.line(2, "<boolean name=\"flip_normals\" value=\"true\"/>");
        self.line(2, "<bsdf type=\"diffuse\">");
        self.line(3, rgb("reflectance", [0.0; 3]));
        self.line(2, "</bsdf>");
        self.line(2, "<emitter type=\"area\">");
        self.line(3, rgb("radiance", radiance));
        self.line(2, "</emitter>");
        self.end_of_shape(matches!(piece, Piece::Sphere { .. }));
    }

    fn solid(&mut self, object: ObjectId) {
        let resolved = self.resolved;
        let Some(albedo) = resolved.albedo(object) else { return };
        let is_mirror = matches!(self.resolved.scene().object(object).surface, Surface::Mirror { .. });
        self.line(2, "<bsdf type=\"twosided\">");
        let roughness = self.resolved.roughness(object);
        let (kind, parameter) = match is_mirror {
            true if roughness != [0.0; 2] => ("roughconductor", "specular_reflectance"),
            true => ("conductor", "specular_reflectance"),
            false => ("diffuse", "reflectance"),
        };
        self.line(3, format!("<bsdf type=\"{kind}\">"));
        if is_mirror {
            self.line(4, "<string name=\"material\" value=\"none\"/>");
        }
        if kind == "roughconductor" {
            self.alpha(4, roughness);
        }
        match albedo {
            Albedo::Color(color) => self.line(4, rgb(parameter, color.to_rgb())),
            Albedo::Texture(texture) => {
                let name = self.resolved.name(object);
                let path = self.textures.path(texture, name, &mut self.files);
                self.line(4, format!("<texture type=\"bitmap\" name=\"{parameter}\">"));
                self.line(5, format!("<string name=\"filename\" value=\"{path}\"/>"));
                self.line(4, "</texture>");
            }
            Albedo::Checker { a, b, .. } => {
                self.line(4, format!("<texture type=\"checkerboard\" name=\"{parameter}\">"));
                self.line(5, rgb("color0", a.to_rgb()));
                self.line(5, rgb("color1", b.to_rgb()));
                self.line(4, "</texture>");
            }
        }
        self.line(3, "</bsdf>");
        self.line(2, "</bsdf>");
    }
}

fn medium_id(medium: MediumId) -> String {
    format!("medium-{}", medium.0)
}

/// Text for a comment, which must not hold two dashes.
fn comment(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '-' | '<' | '>' | '&') { '_' } else { c }).collect()
}
