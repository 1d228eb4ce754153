//! Scenes from TOML.
//!
//! Every error names file, line and column where it has them, and all errors are found in one go. Nothing that a file asks for is ignored: an unknown key is an error
//! that lists the valid ones, a feature that is not built yet is refused as such.

use std::path::Path;
use std::sync::Arc;

use toml_edit::Document;

use super::node::{Node, Table, Text};
use super::reader::{Context, read_list, read_table};
use super::syntax::{Mistake, salvage};
use crate::formats::encoding::utf16;
use crate::formats::files::Files;
use crate::scene::SceneError;
use crate::scene::description::{CameraDescription, Description, Environment, Kind, Object, Source, WorldMedium};
use crate::scene::fields::Visitor;
use crate::scene::tables::{blank_medium, medium_fields};

/// A scene from the bytes of its file, which must be text in UTF-8.
pub fn read(bytes: &[u8], path: &Path, files: &dyn Files) -> Result<Description, SceneError> {
    if utf16(bytes).is_some() {
        return Err(SceneError::in_file(path, "is text in UTF-16: scene files are TOML in UTF-8, so save it in that"));
    }
    let text = str::from_utf8(bytes).map_err(|error| {
        let valid = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
        let (line, column) = Text { path, text: &valid }.line_column(valid.len());
        SceneError::at(path, line, column, "is not text: scene files are TOML in UTF-8")
    })?;
    parse(text, path, files)
}

/// A scene from the text of its TOML file; `path` and `files` as in [`read`].
///
/// # Errors
/// When the scene or a file that it names cannot be used.
pub fn parse(text: &str, path: &Path, files: &dyn Files) -> Result<Description, SceneError> {
    parse_with(text, path, Some(files))
}

/// A scene without the contents of its meshes and images: what its text alone says.
pub(super) fn parse_text_only(text: &str, path: &Path) -> Result<Description, SceneError> {
    parse_with(text, path, None)
}

fn parse_with(text: &str, path: &Path, files: Option<&dyn Files>) -> Result<Description, SceneError> {
    let place = Text { path, text };
    let document = Document::parse(text);
    // Of a text that is not TOML, the tables without mistakes are read.
    let salvage = document.as_ref().err().map(|error| salvage(text, error));
    let mistakes: Vec<SceneError> = (salvage.iter().flat_map(|salvage| &salvage.mistakes))
        .map(|Mistake { at, message }| match at {
            Some(at) => place.error(*at, message),
            None => SceneError::in_file(path, message),
        })
        .collect();
    let has_lost = |key| salvage.as_ref().is_some_and(|salvage| salvage.has_lost(key));
    let document = match &salvage {
        Some(salvage) => Document::parse(&*salvage.rest),
        None => document,
    };
    let document = match document {
        Ok(document) => document,
        Err(error) => {
            return Err(SceneError::all(mistakes, path).unwrap_or_else(|| SceneError::in_file(path, error.message())));
        }
    };
    let root = Table::root(&place, document.as_table());
    let stem = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    let mut context = Context::new(files, path.parent().unwrap_or(Path::new("")));
    context.errors.extend(mistakes);
    let keys = [&["name", "camera", "world", "environment", "medium"][..], &Kind::ALL.map(Kind::name)].concat();
    context.errors.extend(root.unknown(&keys));
    let media = read_list(&root, "medium", &mut context, blank_medium, medium_fields);
    context.set_media(media.as_deref().filter(|_| !has_lost("medium")));
    let mut objects = Vec::new();
    for kind in Kind::ALL {
        objects.extend(
            read_list(&root, kind.name(), &mut context, || Object::blank(kind), Object::fields).into_iter().flatten(),
        );
    }
    let name = root.read("name", stem, |node| node.words().map(str::to_owned));
    let name = name.unwrap_or_else(|error| context.report(error));
    let mut section =
        |key: &'static str, node: Result<Node<'_>, SceneError>, fields: &mut dyn FnMut(&mut dyn Visitor)| match node
            .and_then(|node| node.table())
        {
            Ok(table) => read_table(table.renamed(format!("[{key}]")), key, &mut context, true, fields),
            Err(error) => context.report(error),
        };
    let (mut camera, mut camera_medium) = (CameraDescription::blank(), None);
    if root.get("camera").is_some() || !has_lost("camera") {
        section("camera", root.need("camera"), &mut |v| camera.fields_in(&mut camera_medium, v));
    }
    let mut world = WorldMedium::DEFAULT;
    if let Some(node) = root.get("world") {
        section("world", Ok(node), &mut |v| world.fields(v));
    }
    let mut environment = Environment::DEFAULT;
    if let Some(node) = root.get("environment") {
        section("environment", Ok(node), &mut |v| environment.fields(v));
    }
    if let Some(error) = SceneError::all(context.errors, path) {
        return Err(error);
    }
    Ok(Description {
        name,
        camera,
        camera_medium,
        world,
        environment,
        media: media.unwrap_or_default(),
        objects: objects.into_iter().collect(),
        source: Some(Arc::new(Source {
            path: path.to_path_buf(),
            text: text.to_owned(),
            is_builtin: files.is_some_and(Files::is_builtin),
            import: None,
        })),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Memory;

    fn errors(text: &str) -> Vec<String> {
        let error = parse(text, Path::new("s.toml"), &Memory::default()).expect_err("the scene is broken");
        error.each().map(ToString::to_string).collect()
    }

    const HEAD: &str = "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n";

    /// One mistake of each kind, each in a place of its own: all are found, in the order of lines.
    #[test]
    fn all_mistakes_are_found_in_one_go() {
        let text = "\
colour = 1
[camera]
position = [0, 0]
target = [0, 0, 0]
vertical_fov = 200
[[medium]]
name = \"glass\"
ior = -1
[[medium]]
name = \"glass\"
ior = 1.5
[[refractor]]
name = \"a\"
medium = \"water\"
shape = { sphere = { center = [0, 0, 0], radius = 0 } }
[[refractor]]
name = \"a\"
medium = \"glass\"
priority = 1.5
shape = { mesh = \"missing.obj\" }
[[solid]]
name = \"s\"
color = [0.5, 2, 0.5]
shape = { box = { min = [0, 0, 0], max = [1, 1, 1] } }
transform = { scale = 0 }
[[light]]
name = \"l\"
shape = { torus = { center = [0, 0, 0], major = 1 } }
[environment]
color = [0, 0, 0]
image = \"x.hdr\"
";
        let found = errors(text);
        let expected = [
            ("s.toml:1:1", "colour"),
            ("s.toml:3:12", "array of 3"),
            ("s.toml:5:16", "less than 180"),
            ("s.toml:8:7", "greater than 0"),
            ("s.toml:10:8", "two media"),
            ("s.toml:14:10", "no medium"),
            ("s.toml:15", "radius"),
            ("s.toml:17:8", "already"),
            ("s.toml:19:12", "whole number"),
            ("s.toml:20", "missing.obj"),
            ("s.toml:23:9", "between 0 and 1"),
            ("s.toml:25:23", "scale"),
            ("s.toml:26:1", "radiance"),
            ("s.toml:28", "minor"),
            ("s.toml:29:1", "exactly one"),
        ];
        for ((place, word), found) in expected.iter().zip(&found) {
            assert!(found.starts_with(place) && found.contains(word), "{found:?} is not at {place} about {word}");
        }
        assert_eq!(found.len(), expected.len(), "{found:#?}");
    }

    /// Mistakes that make a text no TOML hide nothing of the tables without them.
    #[test]
    fn all_mistakes_are_found_in_a_text_that_is_not_toml() {
        let text = "\
name = \"broken
[camera]
position = [0, 0, 1
target = [0, 0, 0]
[[medium]]
name = \"glass\"
ior = 1.5.2
[[medium]]
name = \"water\"
ior = -1
[[refractor]]
name = \"a\"
medium = \"glass\"
shape = { sphere = { center = [0, 0, 0], radius = 0 } }
[[solid]]
name = \"s\"
color = 0.5, 0.5, 0.5
[solid.shape.box]
min = [0, 0, 0]
[[light]
name = \"l\"
[[light]]
name = \"l\"
name = \"m\"
[environment]
colour = [0, 0, 0]
";
        let found = errors(text);
        let expected = [
            ("s.toml:1:", "string"),
            ("s.toml:3:", "array"),
            ("s.toml:7:", ""),
            ("s.toml:10:7", "greater than 0"),
            ("s.toml:14", "radius"),
            ("s.toml:17:", ""),
            ("s.toml:20:", "]"),
            ("s.toml:24:1", "duplicate"),
            ("s.toml:26:1", "colour"),
        ];
        for ((place, word), found) in expected.iter().zip(&found) {
            assert!(found.starts_with(place) && found.contains(word), "{found:?} is not at {place} about {word}");
        }
        assert_eq!(found.len(), expected.len(), "{found:#?}");
        // The first one lists the others, too.
        assert!(found[1..].iter().all(|error| !error.contains('\n')));
    }

    /// What follows from another mistake alone is not said.
    #[test]
    fn one_mistake_is_one_error() {
        for tail in [
            "[environment]\ncolor = [1, 1, 1]\ngradient = { zenith = [1, 1, 1], horizon = [1, 1, 1], nadir = [1, 1, 1] }\n",
            "[environment]\ncolour = [1, 1, 1]\n",
            "[[light]]\nname = \"l\"\nradiance = [1, 1, 1]\nshape = { sphere = { center = [0, 0, 0], radus = 1 } }\n",
            "[[light]]\nname = \"l\"\nradiance = [1, 1, 1]\nshape = { icosphere = { center = [0, 0, 0], radius = 1, subdivisions = 99 } }\ntransform = { scale = [1, 2, 3] }\n",
            "[[light]]\nname = \"l\"\nradiance = [1, 1, 1]\nshape = { }\ntransform = { scale = [1, 2, 3] }\n",
            "[[solid]]\nname = \"s\"\ncolor = [1, 1, 1]\nchecker = { a = [1, 1, 1], b = [1, 1, 1], size = 1 }\nshape = { box = { min = [0, 0, 0], max = [1, 1, 1] } }\n",
            "[[medium]]\nname = 5\nior = 1\n[[refractor]]\nname = \"r\"\nmedium = \"water\"\nshape = { box = { min = [0, 0, 0], max = [1, 1, 1] } }\n",
            "[[refractor]]\nname = \"r\"\nmedium = \"water\"\nshape = { box = { min = [0, 0, 0], max = [1, 1, 1] } }\n[medium]\nname = \"water\"\n",
            "[[medium]]\nname = \"water\"\nior = 1.3 3\n[[refractor]]\nname = \"r\"\nmedium = \"water\"\nshape = { box = { min = [0, 0, 0], max = [1, 1, 1] } }\n",
            "[[medium]\nname = \"water\"\nior = 1.33\n[[refractor]]\nname = \"r\"\nmedium = \"water\"\nshape = { box = { min = [0, 0, 0], max = [1, 1, 1] } }\n",
            "[[solid]]\nname = \"s\"\n[solid.shape.box]\nmin = [0, 0, 0\nmax = [1, 1, 1]\n[solid.transform]\nscale = 2\n",
            "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n",
        ] {
            let found = errors(&format!("{HEAD}{tail}"));
            assert_eq!(found.len(), 1, "{tail}: {found:#?}");
        }
        assert!(parse(HEAD, Path::new("s.toml"), &Memory::default()).is_ok(), "the twin");
    }

    /// Each with one mistake, which is said once, where it is, and with what to do.
    #[test]
    fn impossible_lights_are_refused() {
        let spot = "spot = { position = [0, 3, 0], target = [0, 0, 0], inner_angle = 20, outer_angle = 30 }";
        let ball = "shape = { sphere = { center = [0, 0, 0], radius = 1 } }";
        let sun = "directional = { direction = [1, -1, 0] }";
        for (light, place, word) in [
            ("intensity = [1, 1, 1]".to_owned(), "s.toml:4:1", "shape, point, spot, directional"),
            (format!("{spot}\n{ball}\nintensity = [1, 1, 1]"), "s.toml:4:1", "shape, point, spot, directional"),
            (format!("{spot}\nradiance = [1, 1, 1]"), "s.toml:7:12", "give its `intensity`"),
            (format!("{ball}\nintensity = [1, 1, 1]"), "s.toml:7:13", "give its `radiance`"),
            (
                format!("{ball}\nradiance = [1, 1, 1]\npower = [1, 1, 1]"),
                "s.toml:8:9",
                "has both `radiance` and `power`",
            ),
            (ball.to_owned(), "s.toml:4:1", "radiance"),
            (spot.to_owned(), "s.toml:4:1", "intensity"),
            (sun.to_owned(), "s.toml:4:1", "irradiance"),
            (format!("{sun}\npower = [1, 1, 1]"), "s.toml:7:9", "give its `irradiance`"),
            (
                format!("{sun}\nirradiance = [1, 1, 1]\ntwo_sided = true"),
                "s.toml:8:13",
                "belongs to a light with a `shape`",
            ),
            (format!("{sun}\nirradiance = [1, -1, 1]"), "s.toml:7", "0 or more"),
            (format!("{spot}\npower = [1, 1, 1e101]"), "s.toml:7", "at most 1e100"),
            (format!("{}\npower = [1, 1, 1]", spot.replace("30", "10")), "s.toml:6:", "less than inner_angle"),
            (format!("{}\npower = [1, 1, 1]", spot.replace("30", "190")), "s.toml:6:", "from 0 to 180"),
            (format!("{}\npower = [1, 1, 1]", spot.replace("[0, 3, 0]", "[0, 0, 0]")), "s.toml:6:", "no direction"),
            (format!("{}\npower = [1, 1, 1]", spot.replace(", outer_angle = 30", "")), "s.toml:6", "outer_angle"),
            (format!("{}\nirradiance = [1, 1, 1]", sun.replace("[1, -1, 0]", "[0, 0, 0]")), "s.toml:6:", "no length"),
            (
                format!("{}\nirradiance = [1, 1, 1]", sun.replace(" }", ", angle = 200 }")),
                "s.toml:6:",
                "or from 0.001 to 180",
            ),
            (format!("{}\nirradiance = [1, 1, 1]", sun.replace(" }", ", angel = 1 }")), "s.toml:6", "angel"),
        ] {
            let text = format!("{HEAD}[[light]]\nname = \"l\"\n{light}\n");
            let found = errors(&text);
            assert!(found.len() == 1 && found[0].starts_with(place) && found[0].contains(word), "{light}: {found:#?}");
        }
        let wrong = format!("{HEAD}[[solid]]\nname = \"l\"\n{sun}\n");
        assert!(errors(&wrong)[0].contains("directional"), "{:?}", errors(&wrong));
    }
}
