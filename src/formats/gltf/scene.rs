//! The scene of a glTF file.

use std::sync::Arc;

use glam::DVec3;

use super::build::Builder;
use super::container::Container;
use super::nodes::{Placed, placed};
use crate::formats::encoding::without_mark;
use crate::formats::files::Input;
use crate::formats::mesh::error_in;
use crate::formats::studio;
use crate::formats::tally::Tally;
use crate::optics::medium::WORLD;
use crate::scene::description::{Environment, Import, Object, Source, WorldMedium};
use crate::scene::{Description, SceneError, validate};

/// The scene of a file.
///
/// # Errors
/// When the file is damaged, needs what is not read, or has no triangles.
pub fn scene(input: &Input<'_>) -> Result<Description, SceneError> {
    let bytes = &*without_mark(input.bytes);
    let in_file = |message: String| SceneError::in_file(input.path, message);
    let container = Container::read(&Input { bytes, ..*input }).map_err(|fault| error_in(input.path, fault))?;
    let placed = placed(&container.root).map_err(|fault| error_in(input.path, fault))?;
    let mut builder = Builder::new(&container, input);
    for place in &placed {
        builder.add(place).map_err(|fault| error_in(input.path, fault))?;
    }
    let Builder { mut objects, media, mut names, mut tally, .. } = builder;
    if objects.is_empty() {
        return Err(in_file("the scene has no triangles".to_owned()));
    }
    let has_glass = !objects.refractors().is_empty();
    // What the program is about; floors and rooms may be much larger.
    let shown = if has_glass { objects.refractors() } else { &objects };
    let (min, max) = studio::bounds(shown.iter().flat_map(corners));
    let (center, radius) = ((min + max) / 2.0, (max - min).length() / 2.0);
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(in_file("the scene has no extent, or too large a one".to_owned()));
    }
    let lights = container.lights(&placed, &mut names, &mut tally).map_err(in_file)?;
    lights.into_iter().for_each(|light| objects.push(light));
    let camera = container.camera(&placed, (center, radius), &mut tally).map_err(in_file)?;
    let camera = camera.unwrap_or_else(|| {
        let shown = if has_glass { "all that is transparent" } else { "all of it" };
        tally.add("no_camera", &format!("the file has no camera: one is added that shows {shown}"), "");
        studio::camera_at(center, radius)
    });
    let environment = if objects.lights().is_empty() {
        tally.add("no_light", "the file has no light: a sky is added", "");
        studio::BRIGHT_SKY
    } else {
        Environment::DEFAULT
    };
    note_others(&container, &placed, &mut tally);
    if has_glass {
        // glTF knows no other medium around things.
        let outsides = objects.iter_mut().filter_map(Object::outside_mut);
        outsides.for_each(|outside| *outside = Some(WORLD.to_owned()));
    }
    let stem = input.path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    let import = Import { format: "glTF", notes: tally.into_notes(), files: container.files() };
    let description = Description {
        name: if stem.trim().is_empty() { "scene".into() } else { stem },
        camera,
        camera_medium: has_glass.then(|| WORLD.to_owned()),
        world: WorldMedium::DEFAULT,
        environment,
        media,
        objects,
        source: Some(Arc::new(Source::imported(input.path.to_path_buf(), import))),
    };
    // What comes out can be saved and read again.
    validate::description(&description).map_err(|fault| in_file(fault.message))?;
    Ok(description)
}

/// The corners of an object's bounds, in the world.
fn corners(object: &Object) -> impl Iterator<Item = DVec3> {
    let ((min, max), matrix) = (object.shape.bounds(), object.transform.matrix());
    let corner = move |i: u32| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
        matrix.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    };
    (0..8).map(corner)
}

/// What the file has that no scene has a place for.
fn note_others(container: &Container, placed: &[Placed], tally: &mut Tally) {
    let root = &container.root;
    if !root.animations.is_empty() {
        tally.add("animation", "animations are left out: things stand where the nodes say", "");
    }
    for place in placed {
        let node = &root.nodes[place.node];
        if node.skin.is_some() {
            tally.add("skin", "skins are left out: meshes keep the form that they are stored in", &node.name);
        }
        if node.extensions.instancing.is_some() {
            tally.add("instancing", "instances by EXT_mesh_gpu_instancing are left out", &node.name);
        }
    }
    if root.scenes.len() > 1 {
        tally.add("more_scenes", "scenes of the file other than its own are left out", "");
    }
    if root.extensions_used.iter().any(|name| name == "EXT_lights_image_based") {
        tally.add("image_light", "lights by images (EXT_lights_image_based) are left out", "");
    }
}
