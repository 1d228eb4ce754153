//! Shaders, put together from the modules that a scene and a mode need.
//!
//! A module is a file in WGSL beside its twin in Rust. There is no linker: names are unique, and the text of a shader is that of its modules one
//! after the other, whose order does not matter in WGSL. (`wesl` and `naga_oil` bring imports and renaming for a price: a parser of their own
//! that follows naga's by months, and error messages about text that nobody wrote. Some thirty files by one author need neither.) What a
//! scene does not have is left out by `override` constants, which drivers compile away.

use crate::tracking::Mode;

/// A file in WGSL by its path below `src`, with its text.
macro_rules! modules {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_str!(concat!("../../", $path)))),*]
    };
}

/// What is in every shader.
const COMMON: &[(&str, &str)] = modules!(
    "render/gpu/numbers.wgsl",
    "render/gpu/scene.wgsl",
    "transport/sampler.wgsl",
    "optics/fresnel.wgsl",
    "scatter/frame.wgsl",
    "scatter/normals.wgsl",
    "scatter/mirror.wgsl",
    "scatter/lambert.wgsl",
    "scatter/dielectric.wgsl",
    "geometry/ray.wgsl",
    "geometry/triangle.wgsl",
    "geometry/sphere.wgsl",
    "geometry/search.wgsl",
    "geometry/surface.wgsl",
    "scene/camera.wgsl",
    "scene/scene.wgsl",
    "scene/texture.wgsl",
    "scene/lights/sample.wgsl",
    "scene/lights/environment.wgsl",
    "scene/lights/area.wgsl",
    "scene/lights/bodiless.wgsl",
    "tracking/tracker.wgsl",
    "transport/interaction.wgsl",
    "transport/direct.wgsl",
    "transport/path.wgsl",
);

/// What renders.
const FILM: &[(&str, &str)] = modules!("render/gpu/film.wgsl");

/// What makes a mode; `None`: it is rendered by the CPU only.
fn of_mode(mode: Mode) -> Option<&'static [(&'static str, &'static str)]> {
    match mode {
        Mode::Naive => Some(modules!("tracking/naive.wgsl", "tracking/stateless.wgsl", "tracking/at_once.wgsl")),
        Mode::Stack => Some(modules!("tracking/stack.wgsl", "tracking/at_once.wgsl")),
        Mode::Priority => Some(modules!("tracking/priority.wgsl", "tracking/at_once.wgsl")),
        // Their exteriors stand in the same table.
        Mode::Declared | Mode::RectifiedObject => {
            Some(modules!("tracking/rectified_object.wgsl", "tracking/stateless.wgsl", "tracking/at_once.wgsl"))
        }
        Mode::Rectified => Some(modules!("tracking/rectified.wgsl", "tracking/stateless.wgsl", "rectify/flat.wgsl")),
        Mode::Reference => None,
    }
}

/// What decides the text and the constants of a shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Variant {
    pub mode: Mode,
    /// Nodes that may wait to be visited.
    pub tree_depth: u32,
    /// Entries of a path's state, in modes that have one.
    pub tracker_room: u32,
    pub triangles: bool,
    pub spheres: bool,
    pub smooth_normals: bool,
    pub absorption: bool,
    pub masked: bool,
    pub divided_faces: bool,
    pub asked_cells: bool,
    /// Whether shadow rays may pass through refractors.
    pub can_pass: bool,
    pub emitters: bool,
    /// Whether rays that escape may see directional lights.
    pub suns: bool,
    pub sampled_environment: bool,
    /// Whether solids have images.
    pub textures: bool,
    /// 0: constant; 1: gradient; 2: image.
    pub environment_kind: u32,
    /// Whether random numbers are hashes, each for itself.
    pub independent: bool,
}

impl Variant {
    /// Whether shaders render in `mode`.
    pub fn has_mode(mode: Mode) -> bool {
        of_mode(mode).is_some()
    }

    /// Mode `rectified` with nothing left out.
    #[cfg(test)]
    pub fn with_everything() -> Self {
        Self {
            mode: Mode::Rectified,
            tree_depth: 32,
            tracker_room: 0,
            triangles: true,
            spheres: true,
            smooth_normals: true,
            absorption: true,
            masked: true,
            divided_faces: true,
            asked_cells: true,
            can_pass: true,
            emitters: true,
            suns: true,
            sampled_environment: true,
            textures: true,
            environment_kind: 2,
            independent: false,
        }
    }

    /// Whether paths carry a state.
    pub fn has_state(mode: Mode) -> bool {
        matches!(mode, Mode::Stack | Mode::Priority)
    }

    /// Words that a path's state takes in memory.
    pub fn tracker_words(&self) -> u32 {
        match self.mode {
            Mode::Stack => 1 + self.tracker_room.max(1),
            Mode::Priority => 1 + 2 * self.tracker_room.max(1),
            _ => 0,
        }
    }

    /// The text of the shader that renders.
    pub fn source(&self) -> String {
        self.library() + &text(FILM)
    }

    /// The same without its entry point.
    pub fn library(&self) -> String {
        let room = self.tracker_room.max(1);
        // A shadow ray that may not pass asks no tracker.
        let words = if self.can_pass { 2 * room } else { room };
        let kept = self.tracker_words();
        let depth = self.tree_depth.max(1);
        format!(
            "const TREE_DEPTH: u32 = {depth}u;\nconst TRACKER_ROOM: u32 = {room}u;\nconst STATE_WORDS: u32 = {words}u;\nconst TRACKER_WORDS: u32 = {kept}u;\n",
        ) + &text(COMMON)
            + &text(of_mode(self.mode).unwrap_or_default())
    }

    /// The `override` constants, by name.
    pub fn constants(&self) -> Vec<(&'static str, f64)> {
        let on = |value: bool| f64::from(u8::from(value));
        let mut constants = vec![
            ("TRIANGLES", on(self.triangles)),
            ("SPHERES", on(self.spheres)),
            ("SMOOTH_NORMALS", on(self.smooth_normals)),
            ("ABSORPTION", on(self.absorption)),
            ("MASKED", on(self.masked)),
            ("CAN_PASS", on(self.can_pass)),
            ("EMITTERS", on(self.emitters)),
            ("SUNS", on(self.suns)),
            ("SAMPLED_ENVIRONMENT", on(self.sampled_environment)),
            ("ENVIRONMENT_KIND", f64::from(self.environment_kind)),
            ("TEXTURES", on(self.textures)),
            ("INDEPENDENT", on(self.independent)),
        ];
        if self.mode == Mode::Rectified {
            constants.extend([("DIVIDED_FACES", on(self.divided_faces)), ("ASKED_CELLS", on(self.asked_cells))]);
        }
        constants
    }
}

fn text(modules: &[(&str, &str)]) -> String {
    modules.iter().map(|(path, text)| format!("// {path}\n{text}\n")).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use wgpu::naga;
    use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;

    fn validate(variant: &Variant, source: &str) -> Result<(), String> {
        let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .map_err(|error| error.emit_to_string(source))?;
        let constants = variant.constants().into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        let entry = Some((naga::ShaderStage::Compute, "render"));
        naga::back::pipeline_constants::process_overrides(&module, &info, entry, &constants)
            .map(|_| ())
            .map_err(|error| error.to_string())
    }

    /// Every mode, with each thing left out by itself, and with all left out.
    fn variants() -> Vec<Variant> {
        let mut all = Vec::new();
        for mode in Mode::ALL.into_iter().filter(|mode| Variant::has_mode(*mode)) {
            let full = Variant { mode, tracker_room: 8, ..Variant::with_everything() };
            all.push(full);
            let switches: [fn(&mut Variant); 14] = [
                |v| v.triangles = false,
                |v| v.spheres = false,
                |v| v.smooth_normals = false,
                |v| v.absorption = false,
                |v| v.masked = false,
                |v| v.divided_faces = false,
                |v| v.asked_cells = false,
                |v| v.can_pass = false,
                |v| v.emitters = false,
                |v| v.suns = false,
                |v| v.textures = false,
                |v| (v.sampled_environment, v.environment_kind) = (false, 0),
                |v| (v.sampled_environment, v.environment_kind) = (false, 1),
                |v| v.independent = true,
            ];
            for switch in switches {
                let mut variant = full;
                switch(&mut variant);
                all.push(variant);
            }
            let mut bare = full;
            switches.iter().skip(1).for_each(|switch| switch(&mut bare));
            all.push(Variant { tracker_room: 0, tree_depth: 1, ..bare });
        }
        all
    }

    #[test]
    fn every_mode_that_the_graphics_processor_renders_has_modules() {
        for mode in Mode::ALL {
            assert_eq!(Variant::has_mode(mode), crate::render::GPU_MODES.contains(&mode), "{mode}");
        }
    }

    #[test]
    fn every_variant_is_valid() {
        for variant in variants() {
            let result = validate(&variant, &variant.source());
            assert!(result.is_ok(), "{variant:?}: {}", result.unwrap_err());
        }
        // The twin: what is wrong is found.
        let variant = Variant::with_everything();
        let wrong = variant.source().replacen("fn frame(normal: vec3f)", "fn frame(normal: vec2f)", 1);
        assert!(validate(&variant, &wrong).is_err());
    }

    /// No file is forgotten.
    #[test]
    fn every_module_is_used() {
        fn collect(folder: &Path, found: &mut BTreeSet<String>) {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    collect(&path, found);
                } else if path.extension().is_some_and(|ending| ending == "wgsl") {
                    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
                    found.insert(path.strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/"));
                }
            }
        }
        let mut found = BTreeSet::new();
        collect(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
        let modes = Mode::ALL.into_iter().filter_map(of_mode).flatten();
        let used: BTreeSet<String> =
            COMMON.iter().chain(FILM).chain(modes).map(|(path, _)| (*path).to_owned()).collect();
        assert_eq!(used, found);
    }
}
