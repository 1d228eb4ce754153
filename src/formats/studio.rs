//! A scene around a mesh that comes alone: the mesh, in glass where nothing else is said of it, on a floor and lit from above.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::files::Input;
use super::mesh::{self, MeshFile};
use super::names::Names;
use super::pieces::{Piece, pieces};
use crate::geometry::Mesh;
use crate::optics::Medium;
use crate::scene::description::{
    CameraDescription, Environment, Light, Object, Objects, Paint, Shape, Solid, WorldMedium,
};
use crate::scene::{Description, SceneError, validate};

/// Where the camera looks from, as the mesh sees it.
const VIEW: DVec3 = DVec3::new(0.55, 0.5, 1.0);
const VERTICAL_FOV: f64 = 34.0;

/// What surrounds scenes that bring no light of their own.
pub(super) const SKY: Environment =
    Environment::Gradient { zenith: [0.5, 0.54, 0.6], horizon: [0.22, 0.23, 0.25], nadir: [0.1; 3] };

/// What surrounds whole scenes that bring no light: it alone lights them.
pub(super) const BRIGHT_SKY: Environment =
    Environment::Gradient { zenith: [1.3, 1.36, 1.45], horizon: [0.85, 0.87, 0.9], nadir: [0.4; 3] };

/// The scene around the mesh in a file: each of its materials, or else of its groups, is an object.
///
/// # Errors
/// When the file holds no mesh, or one that has no extent or too large a one.
pub(super) fn open(input: &Input<'_>) -> Result<Description, SceneError> {
    let path = input.path;
    let (stem, pieces) = read(input)?;
    let description = around(path, &stem, pieces)?;
    // What comes out can be saved and read again.
    validate::description(&description).map_err(|fault| SceneError::in_file(path, fault.message))?;
    Ok(description)
}

/// What a mesh's file is called, and the pieces in it.
fn read(input: &Input<'_>) -> Result<(String, Vec<Piece>), SceneError> {
    let path = input.path;
    let format = mesh::format_of(path).map_err(|message| SceneError::in_file(path, message))?;
    let file = MeshFile::read(input, format).map_err(|fault| mesh::error_in(path, fault))?;
    let stem = path.file_stem().map_or_else(|| "mesh".into(), |stem| stem.to_string_lossy().into_owned());
    let pieces = pieces(file, &stem, input)?;
    Ok((stem, pieces))
}

/// The objects of the mesh in a file, which they name as `written`, each with the medium that it is made of.
///
/// # Errors
/// When the file holds no mesh.
pub(super) fn objects(input: &Input<'_>, written: &Path) -> Result<Vec<(Object, Option<Medium>)>, SceneError> {
    let (_, pieces) = read(input)?;
    Ok(pieces.into_iter().map(|piece| object(piece, written)).collect())
}

fn object(piece: Piece, path: &Path) -> (Object, Option<Medium>) {
    let Piece { name, part, mesh, notes, role, medium } = piece;
    let shape = Shape::Mesh { path: path.to_owned(), part, mesh: Arc::new(mesh), notes };
    (Object::new(name, shape, role), medium)
}

/// The scene around pieces of a file. All lengths are in proportion to them together.
fn around(path: &Path, stem: &str, pieces: Vec<Piece>) -> Result<Description, SceneError> {
    let used = |mesh: &Mesh| bounds(mesh.triangles.iter().flatten().map(|&corner| mesh.positions[corner as usize]));
    let corners = pieces.iter().map(|piece| used(&piece.mesh)).flat_map(|(min, max)| [min, max]);
    let (min, max) = bounds(corners);
    let (center, radius) = ((min + max) / 2.0, (max - min).length() / 2.0);
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(SceneError::in_file(path, "the mesh has no extent"));
    }
    // Saved elsewhere, the scene must still find its mesh.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (mut objects, mut media, mut names) = (Objects::default(), Vec::new(), Names::default());
    for piece in pieces {
        let (mut object, medium) = object(piece, &path);
        object.name = names.give(&object.name, stem);
        objects.push(object);
        media.extend(medium);
    }
    // Not flush with it: what touches the floor is in optical contact.
    let floor = center.with_y(min.y - 1e-3 * radius);
    let quad = |center: DVec3, edge_u: DVec3, edge_v: DVec3| Shape::Quad { center, edge_u, edge_v };
    let checker = Paint::Checker { a: [0.42; 3], b: [0.3; 3], size: 0.5 * radius };
    let reach = 40.0 * radius;
    let floor = quad(floor, DVec3::Z * reach, DVec3::X * reach);
    objects.push(Object::new(names.give("floor", ""), floor, Solid::of(checker)));
    let softbox = center + DVec3::new(-1.6, 2.6, 1.2) * radius;
    let away = (softbox - center).normalize();
    let across = DVec3::Y.cross(away).normalize();
    let sheet = quad(softbox, away.cross(across) * 1.6 * radius, across * 2.2 * radius);
    objects.push(Object::new(names.give("softbox", ""), sheet, Light::of_radiance([8.0, 7.7, 7.2])));
    Ok(Description {
        name: stem.to_owned(),
        camera: camera_at(center, radius),
        camera_medium: None,
        world: WorldMedium::DEFAULT,
        environment: SKY,
        media,
        objects,
        source: None,
    })
}

/// The lowest and the highest coordinates.
pub(super) fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
}

/// A camera that sees a whole ball, from in front and above.
pub(super) fn camera_at(center: DVec3, radius: f64) -> CameraDescription {
    let distance = 1.1 * radius / (VERTICAL_FOV.to_radians() / 2.0).sin();
    CameraDescription {
        position: center + VIEW.normalize() * distance,
        target: center,
        vertical_fov: VERTICAL_FOV,
        ..CameraDescription::blank()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Memory;
    use crate::optics::Ior;
    use crate::scene::compile::compile;
    use crate::scene::description::{MeshPart, Refractor};
    use crate::scene::shapes::tessellate;
    use crate::scene::texture::TextureImage;

    fn alone(mesh: Mesh) -> Piece {
        let medium = Medium { name: "floor".into(), ior: Ior::Constant(1.5), absorption: [0.0; 3] };
        let (part, notes, role) = (MeshPart::default(), Vec::new(), Refractor::of("floor").into());
        Piece { name: "floor".into(), part, mesh, notes, role, medium: Some(medium) }
    }

    /// Whatever its size and place, the mesh is in the middle of the picture, and its light faces it.
    #[test]
    fn any_mesh_is_framed() {
        for (scale, offset) in [(1e-6, 0.0), (1.0, 100.0), (1e6, -1e7)] {
            let center = DVec3::splat(offset);
            let shape = Shape::Box { min: center - scale, max: center + DVec3::new(1.0, 3.0, 0.2) * scale };
            let mesh = tessellate(&shape).unwrap().unwrap();
            let scene = around(Path::new("a/floor.stl"), "floor", vec![alone(mesh)]).unwrap();
            let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
            assert_eq!((scene.name.as_str(), names.len()), ("floor", 3));
            assert!(names.contains(&"floor 2"), "{names:?}");
            let compiled = compile(&scene, None).unwrap();
            assert_eq!(compiled.refractors().count(), 1);
            let light = &scene.objects.of(crate::scene::description::Kind::Light)[0];
            let Shape::Quad { center, edge_u, edge_v } = light.shape else { panic!("a sheet") };
            assert!(edge_u.cross(edge_v).dot(scene.camera.target - center) > 0.0);
        }
        let flat =
            Mesh { positions: vec![DVec3::ONE; 3], normals: Vec::new(), triangles: vec![[0, 1, 2]], uvs: Vec::new() };
        assert!(around(Path::new("a.stl"), "a", vec![alone(flat)]).is_err());
    }

    /// Four tetrahedra, each with a statement before it.
    fn obj(statements: [&str; 4]) -> String {
        let mut text = "mtllib table set.mtl\n".to_owned();
        for (number, statement) in statements.iter().enumerate() {
            let x = 2 * number;
            text += &format!("{statement}\nv {x} 0 0\nv {} 0 0\nv {x} 1 0\nv {x} 0 1\n", x + 1);
            text += "f -4 -2 -3\nf -4 -1 -2\nf -4 -3 -1\nf -3 -2 -1\n";
        }
        text
    }

    fn opened(text: &str, library: Option<&str>) -> Description {
        let files = Memory(library.map(|text| ("a/table set.mtl".into(), text.into())).into_iter().collect());
        open(&Input { bytes: text.as_bytes(), path: Path::new("a/set.obj"), files: &files }).unwrap()
    }

    fn media(scene: &Description) -> Vec<(&str, f64)> {
        scene.media.iter().map(|medium| (medium.name.as_str(), medium.ior.ior())).collect()
    }

    fn notes(scene: &Description) -> Vec<&str> {
        let Shape::Mesh { notes, .. } = &scene.objects[0].shape else { panic!("a mesh") };
        notes.iter().map(|note| note.kind).collect()
    }

    #[test]
    fn each_material_of_a_file_is_an_object_with_its_medium() {
        let text = obj(["usemtl cup", "usemtl wine", "usemtl table", "usemtl lamp"]);
        let library = "newmtl cup\nNi 1.46\nd 0.1\nnewmtl wine\nNi 1.36\nTf 0.5 0.1 0.1\nillum 6\nnewmtl table\nKd 0.3 0.2 0.1\n\
                       newmtl lamp\nKe 3 3 2\n";
        let scene = opened(&text, Some(library));
        assert_eq!(media(&scene), [("cup", 1.46), ("wine", 1.36)]);
        let names = |objects: &[Object]| objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>().join(" ");
        assert_eq!(names(scene.objects.refractors()), "cup wine");
        assert_eq!(names(scene.objects.solids()), "table floor");
        assert_eq!(names(scene.objects.lights()), "lamp softbox");
        assert_eq!(scene.objects.solids()[0].solid().unwrap().paint, Paint::Color([0.3, 0.2, 0.1]));
        assert_eq!(scene.objects.lights()[0].light().unwrap().emission.rgb, [3.0, 3.0, 2.0]);
        // Of red half passes through a length of 1.
        assert!((scene.media[1].absorption[0] - 2_f64.ln()).abs() < 1e-12 && scene.media[0].absorption == [0.0; 3]);
        let Shape::Mesh { path, part, mesh, .. } = &scene.objects.refractors()[1].shape else { panic!("a mesh") };
        assert!(path.is_absolute() && path.ends_with("a/set.obj"));
        assert_eq!((part, mesh.triangles.len()), (&MeshPart::of_material("wine"), 4));
        // Saved, it names the parts.
        let text = crate::formats::to_text(&scene);
        assert!(text.contains("material = \"wine\""), "{text}");
        assert_eq!(compile(&scene, None).unwrap().refractors().count(), 2);
    }

    #[test]
    fn without_materials_groups_are_objects() {
        let scene = opened(&obj(["o ball", "o ball", "o cube", "o world"]), None);
        assert_eq!(media(&scene).iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["ball", "cube", "world 2"]);
        assert_eq!(notes(&scene), ["material_library"; 2], "two words could be two names");
        // Faces that are of two groups cannot be told apart by them.
        assert_eq!(media(&opened(&obj(["g a b", "g b", "g c", "g d"]), None)).len(), 1);
        assert_eq!(media(&opened(&obj(["", "", "", ""]), None)).len(), 1);
    }

    #[test]
    fn where_no_material_is_glass_all_are() {
        let text = obj(["usemtl a", "usemtl b", "usemtl a", "usemtl lamp"]);
        let scene = opened(&text, Some("newmtl a\nKd 1 0 0\nNi 1.7\nnewmtl b\nnewmtl lamp\nKe 1 1 1\n"));
        assert_eq!(media(&scene).iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["a", "b"]);
        assert_eq!((scene.media[0].ior.ior(), notes(&scene)), (1.7, vec!["no_glass"]));
        // A mesh of one material is glass, whatever that says, and of its IOR if it gives one.
        let single = opened(&obj(["usemtl a"; 4]), Some("newmtl a\nNi 1.7\nKe 1 1 1\n"));
        assert_eq!((media(&single), notes(&single)), (vec![("set", 1.7)], vec![]));
    }

    #[test]
    fn a_part_with_an_image_is_a_solid_that_has_it() {
        let image = TextureImage::new(1, 2, vec![[255, 0, 0, 255], [0, 0, 255, 255]]);
        let faces = "f 1/1 3/3 2/2\nf 1/1 2/2 4/3\nf 1/1 4/3 3/2\nf 2/1 3/2 4/3\n";
        let text =
            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl oak\n".to_owned() + faces;
        let opened = |text: &str, library: &str| {
            let png = crate::formats::texture::to_png(&image);
            let files = Memory([("a/a.mtl".into(), library.into()), ("a/my oak.png".into(), png)].into());
            open(&Input { bytes: text.as_bytes(), path: Path::new("a/set.obj"), files: &files }).unwrap()
        };
        let library = "newmtl oak\nKd 0.5 1 1\nmap_Kd -s 2 3 my oak.png\n";
        let scene = opened(&text, library);
        let solid = |scene: &Description| scene.objects.solids()[0].solid().unwrap().paint.clone();
        let Paint::Texture { path, image: read, tint, uv } = solid(&scene) else { panic!("no texture") };
        assert!(path.is_absolute() && path.ends_with("a/my oak.png"));
        assert_eq!((&*read, tint, uv.scale), (&image, [0.5, 1.0, 1.0], [2.0, 3.0]));
        let Shape::Mesh { mesh, .. } = &scene.objects.solids()[0].shape else { panic!("a mesh") };
        assert_eq!(mesh.uvs[0], [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        assert_eq!(compile(&scene, None).unwrap().refractors().count(), 0);
        // Black beside an image means nothing; and a mesh without coordinates has the mean colour.
        let black = opened(&text, "newmtl oak\nKd 0 0 0\nmap_Kd my oak.png\n");
        assert!(matches!(solid(&black), Paint::Texture { tint: [1.0, 1.0, 1.0], .. }));
        let bare = text.replace("/1", "").replace("/2", "").replace("/3", "");
        let bare = opened(&bare, library);
        assert_eq!(solid(&bare), Paint::Color([0.25, 0.0, 0.5]));
        // What light goes through is glass, with or without an image; what cannot be read is told.
        assert_eq!(opened(&text, &format!("{library}d 0.5\n")).objects.refractors().len(), 1);
        let gone = opened(&text, "newmtl oak\nKd 0.5 1 1\nmap_Kd gone.png\n");
        assert_eq!(solid(&gone), Paint::Color([0.5, 1.0, 1.0]));
        let Shape::Mesh { notes, .. } = &gone.objects.solids()[0].shape else { panic!("a mesh") };
        assert!(notes[0].message.contains("gone.png"), "{notes:?}");
    }
}
