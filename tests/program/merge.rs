//! Parts of an image rendered apart and put together, by the real binary: `render --samples` and `merge`.

use std::fs;

use crate::desk::{Desk, text};
use serde_json::{Value, json};

/// A ball of glass around one of water, a lamp and a sky: noise in every pixel.
pub const SCENE: &str = r#"
name = "Kugel in Öl — 球"
[camera]
position = [0.0, 0.5, 6.0]
target = [0.0, 0.0, 0.0]
vertical_fov = 30.0
[world]
ior = 1.1
[environment]
gradient = { zenith = [0.3, 0.5, 1.0], horizon = [1.0, 0.9, 0.8], nadir = [0.1, 0.2, 0.1] }
[[medium]]
name = "glass"
ior = 1.5
absorption = [0.3, 0.1, 0.2]
[[medium]]
name = "water"
ior = 1.333
[[refractor]]
name = "shell"
medium = "glass"
shape = { sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 } }
[[refractor]]
name = "middle"
medium = "water"
shape = { sphere = { center = [0.0, 0.0, 0.0], radius = 0.7 } }
[[solid]]
name = "floor"
shape = { quad = { center = [0, -1.2, 0], edge_u = [0, 0, 8], edge_v = [8, 0, 0] } }
checker = { a = [0.8, 0.8, 0.8], b = [0.1, 0.2, 0.4], size = 0.5 }
[[light]]
name = "lamp"
shape = { sphere = { center = [1.0, 2.0, 1.0], radius = 0.2 } }
radiance = [40.0, 38.0, 34.0]
"#;

fn with_ball() -> Desk {
    Desk::with("ball.toml", SCENE)
}

/// Renders samples of the scene into a file.
fn render_part(desk: &Desk, samples: &str, name: &str) {
    desk.fine(&format!("render ball.toml --size 20x14 --samples {samples} -o {name}"));
}

#[test]
fn parts_are_the_whole_to_the_bit() {
    let desk = with_ball();
    render_part(&desk, "0..24", "whole.exr");
    for (samples, name) in [("0..5", "a.exr"), ("5..6", "b.exr"), ("6..16", "c.exr"), ("16..24", "d.exr")] {
        render_part(&desk, samples, name);
    }
    desk.fine("merge a.exr b.exr c.exr d.exr -o forwards.exr");
    desk.fine("merge d.exr b.exr a.exr c.exr -o mixed.exr");
    // In groups, one of them with a gap.
    desk.fine("merge d.exr a.exr -o outer.exr");
    desk.fine("merge c.exr b.exr -o inner.exr");
    desk.fine("merge inner.exr outer.exr -o grouped.exr");
    let whole = desk.get("whole.exr");
    for name in ["forwards.exr", "mixed.exr", "grouped.exr"] {
        assert!(desk.get(name) == whole, "{name} is not the whole");
    }
    // Nor do threads matter.
    desk.fine("render ball.toml --size 20x14 --samples 0..24 --threads 1 -o alone.exr");
    assert!(desk.get("alone.exr") == whole);
    // The twin: a sample less is another picture.
    desk.fine("merge a.exr c.exr d.exr -o less.exr");
    assert!(desk.picture("less.exr") != desk.picture("whole.exr"));
    assert!(desk.picture("forwards.exr") == desk.picture("whole.exr"));
}

#[test]
fn sums_are_those_of_an_ordinary_render() {
    let desk = with_ball();
    let as_ever = "render ball.toml --size 20x14 --adaptive off --spp 24";
    let expected = desk.json(&format!("{as_ever} -o ordinary.exr --json"));
    let part = desk.json("render ball.toml --size 20x14 --samples 0..24 -o part.exr --json");
    for field in ["spp", "adaptive", "events", "mixed_share", "mode", "seed"] {
        assert_eq!(part[field], expected[field], "{field}");
    }
    assert_eq!((&part["samples"], &expected["samples"]), (&json!([0, 24]), &Value::Null));
    let worst = |other: &str| {
        let pairs = desk.picture("part.exr").into_iter().zip(desk.picture(other));
        pairs.map(|(a, b)| (a - b).abs() / b.abs().max(1e-3)).fold(0.0, f32::max)
    };
    // Equal but for the last bit of the f32.
    assert!(worst("ordinary.exr") < 3e-7, "{}", worst("ordinary.exr"));
    // The twin: other samples differ.
    render_part(&desk, "24..48", "others.exr");
    assert!(worst("others.exr") > 1e-2);
}

/// Meshes, overlapping objects, image environments: the scenes as they are shipped.
#[test]
fn parts_of_built_in_scenes() {
    let desk = with_ball();
    for (scene, mode) in [("iced-water", "rectified"), ("siblings", "stack"), ("lamp-in-ice", "reference")] {
        let part = |samples: &str, name: &str| {
            desk.fine(&format!("render {scene} --mode {mode} --size 12x8 --samples {samples} -o {name}"))
        };
        part("0..12", "whole.exr");
        part("0..7", "a.exr");
        part("7..12", "b.exr");
        let merged = desk.json("merge b.exr a.exr -o merged.exr --json");
        assert!(desk.get("merged.exr") == desk.get("whole.exr"), "{scene}");
        assert_eq!((&merged["mode"], &merged["samples"]), (&json!(mode), &json!([[0, 12]])));
    }
}

#[test]
fn what_was_merged_is_said() {
    let desk = with_ball();
    render_part(&desk, "0..4", "a.exr");
    render_part(&desk, "8..12", "b.exr");
    let said = desk.fine("merge b.exr a.exr -o all.exr -o all.png");
    for expected in ["Kugel in Öl — 球", "8 spp from 2 files", "0..4, 8..12", "missing   4..8", "all.exr", "all.png"]
    {
        assert!(said.contains(expected), "`{expected}` is missing in {said}");
    }
    let merged = desk.json("merge b.exr a.exr --json");
    assert_eq!(merged["scene"], "Kugel in Öl — 球");
    assert_eq!(merged["mode"], "rectified");
    assert_eq!(merged["samples"], json!([[0, 4], [8, 12]]));
    assert_eq!(merged["gaps"], json!([[4, 8]]));
    assert_eq!((&merged["spp"], &merged["files"], &merged["outputs"]), (&json!(8), &json!(2), &json!([])));
    assert_eq!(merged["events"]["non_finite"], 0);
    // The PNG says what it shows.
    let png = desk.get("all.png");
    let has = |text: &str| png.windows(text.len()).any(|window| window == text.as_bytes());
    assert!(has("Kugel in Öl") && has("Samples per pixel") && !has("IOR"));
    // Without -o, the name says which samples these are; with --json nothing is written.
    desk.fine("render ball.toml --size 4x4 --samples 3..5");
    assert!(desk.path().join("ball-rectified-3-5.exr").exists());
    let before = desk.files();
    desk.fine("render ball.toml --size 4x4 --samples 3..5 --json");
    assert_eq!(desk.files(), before);
}

#[test]
fn what_does_not_match_is_refused() {
    let desk = with_ball();
    render_part(&desk, "0..2", "a.exr");
    let edits = [
        ("--seed 1", "the seed differs: 1 here, 0 there"),
        ("--mode naive", "the mode differs: naive here, rectified there"),
        ("--size 14x20", "the size differs: 14×20 here, 20×14 there"),
        ("--max-depth 9", "--max-depth differs: 9 here, none there"),
        ("--splits 0", "--splits differs"),
        ("--sampler independent", "--sampler differs: independent here, sobol there"),
        ("--sample-environment off", "--sample-environment differs"),
        ("--leave-out off", "--leave-out differs"),
    ];
    for (flags, expected) in edits {
        let size = if flags.starts_with("--size") { "" } else { "--size 20x14" };
        desk.fine(&format!("render ball.toml --samples 2..4 {size} {flags} -o b.exr"));
        let error = desk.wrong("merge a.exr b.exr -o c.exr");
        assert!(error.contains(expected) && error.contains("b.exr cannot be merged with a.exr"), "{flags}: {error}");
    }
    let other = "render other.toml --size 20x14 --samples 2..4 -o b.exr";
    for (from, to, expected) in [
        ("ior = 1.333", "ior = 1.334", "the scene's content differs"),
        ("radius = 0.7", "radius = 0.71", "the scene's content differs"),
        ("vertical_fov = 30.0", "vertical_fov = 31.0", "the camera differs"),
    ] {
        desk.put("other.toml", SCENE.replace(from, to));
        desk.fine(other);
        let error = desk.wrong("merge a.exr b.exr -o c.exr");
        assert!(error.contains(expected), "{to}: {error}");
    }
    // The twin: other names and comments are no other scene.
    desk.put("other.toml", SCENE.replace("Kugel", "Ball").replace("\"shell\"", "\"outer\"") + "# all the same");
    desk.fine(other);
    assert!(desk.fine("merge b.exr a.exr -o c.exr").contains("Kugel"), "the earlier samples name it");
}

#[test]
fn no_sample_counts_twice() {
    let desk = with_ball();
    render_part(&desk, "0..4", "a.exr");
    render_part(&desk, "3..6", "b.exr");
    render_part(&desk, "8..9", "c.exr");
    let error = desk.wrong("merge c.exr a.exr b.exr -o all.exr");
    assert!(error.contains("b.exr cannot be merged with a.exr: the samples 3..4 are in both"), "{error}");
    assert!(desk.wrong("merge a.exr ./a.exr -o all.exr").contains("0..4 are in both"));
    desk.fine("merge a.exr c.exr -o all.exr");
    assert!(desk.wrong("merge all.exr c.exr -o more.exr").contains("8..9 are in both"));
}

#[test]
fn damaged_files_are_refused() {
    let desk = with_ball();
    render_part(&desk, "0..2", "a.exr");
    render_part(&desk, "2..4", "b.exr");
    let good = desk.get("b.exr");
    // The twin: untouched, it is taken.
    desk.fine("merge a.exr b.exr --json");
    for length in [0, 3, 100, good.len() / 2, good.len() - 1] {
        desk.put("bad.exr", &good[..length]);
        let error = desk.wrong("merge a.exr bad.exr -o c.exr");
        assert!(error.contains("bad.exr"), "{error}");
    }
    // A bit here and there, in the head as in the pixels.
    for position in (8..good.len()).step_by(good.len() / 24) {
        let mut bad = good.clone();
        bad[position] ^= 0x10;
        desk.put("bad.exr", &bad);
        let output = desk.run("merge a.exr bad.exr -o c.exr");
        let error = text(&output.stderr);
        assert!(!error.contains("panicked"), "byte {position}: {error}");
        // Some bytes decide nothing, such as attributes that no one reads; then the result must be right.
        if output.status.success() {
            desk.fine("merge a.exr b.exr -o expected.exr");
            assert!(desk.get("c.exr") == desk.get("expected.exr"), "byte {position} was taken");
            fs::remove_file(desk.path().join("c.exr")).unwrap();
        }
    }
    // Edited by hand: the samples are claimed to be others.
    let position = good.windows(5).position(|window| window == b"[2,4]").unwrap();
    let mut edited = good.clone();
    edited[position + 1] = b'3';
    desk.put("bad.exr", &edited);
    assert!(desk.wrong("merge a.exr bad.exr -o c.exr").contains("damaged or edited"));
    let position = good.windows(10).position(|window| window == b"\"format\":3").unwrap();
    edited = good;
    edited[position + 9] = b'7';
    desk.put("bad.exr", &edited);
    assert!(desk.wrong("merge a.exr bad.exr -o c.exr").contains("format 7"));
}

#[test]
fn files_of_another_kind_are_refused() {
    let desk = with_ball();
    render_part(&desk, "0..2", "a.exr");
    desk.fine("render ball.toml --size 20x14 --spp 2 -o plain.exr");
    desk.fine("render ball.toml --size 20x14 --spp 2 -o plain.png");
    assert!(desk.wrong("merge a.exr plain.exr -o c.exr").contains("plain.exr: holds no sums"));
    assert!(desk.wrong("merge plain.png a.exr -o c.exr").contains("plain.png: is no OpenEXR file"));
    assert!(desk.wrong("merge ball.toml -o c.exr").contains("ball.toml"));
    assert!(desk.refused("merge a.exr gone.exr -o c.exr", 1).contains("gone.exr: cannot be read"));
    assert!(desk.wrong("merge a.exr -o c.tiff").contains("c.tiff"));
    assert!(desk.wrong("merge a.exr -o nowhere/c.exr").contains("nowhere"));
    assert!(desk.wrong("merge -o c.exr").contains("FILE"));
}

#[test]
fn flags_that_contradict_are_refused() {
    let desk = with_ball();
    let render = "render ball.toml --size 4x4 --samples 0..2";
    assert!(desk.wrong(&format!("{render} --adaptive on")).contains("leave out `--adaptive on`"));
    assert!(desk.wrong(&format!("{render} --spp 2")).contains("--spp"));
    assert!(desk.wrong(&format!("{render} --time 1")).contains("--time"));
    assert!(desk.wrong(&format!("{render} -o sums.png")).contains("`.exr`"));
    assert!(desk.wrong("render ball.toml --samples 5..5").contains("0..256"));
    assert!(desk.wrong("compare ball.toml --samples 0..5").contains("--samples"));
    desk.fine(&format!("{render} --adaptive off -o last.exr"));
    desk.fine("render ball.toml --size 4x4 --samples 4294967293..4294967295 -o end.exr");
}
