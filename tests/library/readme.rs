//! The README does not promise what is not there: its example scene loads, its lists are complete, its pictures are made by the
//! command that it names.

use std::fs;
use std::path::Path;

use iorect::formats::{self, builtin};

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

#[test]
fn the_example_scene_can_be_rendered() {
    let readme = read("README.md");
    let start = readme.find("```toml\n").unwrap() + "```toml\n".len();
    let text = &readme[start..start + readme[start..].find("```").unwrap()];
    let description =
        formats::parse(text, Path::new("example.toml"), &formats::Disk).unwrap_or_else(|error| panic!("{error}"));
    let prepared = iorect::tracking::prepare(description.into(), None).unwrap_or_else(|error| panic!("{error}"));
    // Closed, and facing outward, or its surroundings could not be found.
    assert_eq!(prepared.table.patches[0].confidence, 1.0);
}

#[test]
fn every_built_in_scene_is_listed_as_the_program_lists_it() {
    let readme = read("README.md");
    for scene in builtin::all() {
        let row = format!("| `{}` | {} |", scene.name, scene.about);
        assert!(readme.contains(&row), "missing: {row}");
    }
}

#[test]
fn every_picture_is_made_by_the_command_for_pictures() {
    let (readme, make) = (read("README.md"), read("screenshots/make"));
    let pictures: Vec<&str> =
        readme.split("(screenshots/").skip(1).map(|rest| &rest[..rest.find(".png)").expect("a PNG")]).collect();
    assert!(pictures.len() >= 3);
    for picture in pictures {
        let is_made = ["compare ", "window "]
            .iter()
            .any(|how| make.lines().any(|line| line.starts_with(&format!("{how}{picture}"))));
        assert!(is_made, "screenshots/make does not make {picture}.png");
    }
}
