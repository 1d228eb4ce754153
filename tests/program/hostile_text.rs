//! Text from files never reaches a terminal as anything but text: every command, on scenes whose names, keys and files are full of escape
//! sequences, control characters and controls of direction.

use std::process::Output;

use crate::desk::{Desk, text};
use serde_json::Value;

/// Recolours, clears the screen by the one-byte form, deletes, and reads backwards; with a line that could pass for ours.
const HOSTILE: &str = "\\u001b[31m\\u009b2J\\u007f\\u202egnp\\u2066\\n  wrote     nothing.png\\r\\t";

fn scene() -> String {
    format!(
        r#"
name = "{HOSTILE}scene"
[camera]
position = [0, 0, 5]
target = [0, 0, 0]
vertical_fov = 30
[environment]
color = [1, 1, 1]
[[medium]]
name = "{HOSTILE}glass"
ior = 1.5
[[medium]]
name = "{HOSTILE}water"
ior = 1.333
[[refractor]]
name = "{HOSTILE}shell"
medium = "{HOSTILE}glass"
shape = {{ sphere = {{ center = [0, 0, 0], radius = 1 }} }}
[[refractor]]
name = "{HOSTILE}other"
medium = "{HOSTILE}water"
shape = {{ sphere = {{ center = [0.5, 0, 0], radius = 1 }} }}
[[solid]]
name = "{HOSTILE}solid"
shape = {{ sphere = {{ center = [0, 0, 0], radius = 0.2 }} }}
[[light]]
name = "{HOSTILE}lamp"
radiance = [1, 1, 1]
shape = {{ sphere = {{ center = [1.2, 0.6, 0], radius = 0.5 }} }}
"#
    )
}

fn assert_harmless(said: &str, of: &str) {
    let is_harmful = |c: char| {
        (c.is_control() && c != '\n')
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if let Some(at) = said.find(is_harmful) {
        panic!("{of} prints {:?}: {said:?}", said[at..].chars().next());
    }
    let pretends = |line: &str| line.trim_start().starts_with("wrote     nothing.png");
    assert!(!said.lines().any(pretends), "{of} prints a line that is a name's: {said}");
}

fn harmless(desk: &Desk, line: &str) -> (Output, String) {
    let output = desk.run(line);
    let said = text(&output.stdout) + &text(&output.stderr);
    assert_harmless(&said, line);
    (output, said)
}

#[test]
fn names_are_shown_and_obeyed_by_no_command() {
    let desk = Desk::with("s.toml", &scene());
    for line in [
        "render s.toml --size 8x8 --spp 1",
        "compare s.toml --size 8x8 --spp 1",
        "rectify s.toml",
        "rectify s.toml --granularity object",
        "trace s.toml --pixel 256,256",
        "check s.toml",
        "render s.toml --size 8x8 --samples 0..1 -o part.exr",
        "merge part.exr",
        "s.toml",
    ] {
        let (output, said) = harmless(&desk, line);
        assert!(output.status.success(), "{line}: {said}");
        // Where there is a name, it is seen.
        if line != "s.toml" && !line.starts_with("check") {
            assert!(said.contains("\\u{1b}[31m\\u{9b}2J\\u{7f}\\u{202e}gnp\\u{2066}\\n  wrote"), "{line}: {said}");
        }
    }
    // JSON is harmless to print, and says the same as ever.
    for line in
        ["rectify s.toml --json", "check s.toml --json", "trace s.toml --pixel 256,256 --json", "merge part.exr --json"]
    {
        let (_, said) = harmless(&desk, line);
        let json: Value = serde_json::from_str(&said).unwrap_or_else(|error| panic!("{line}: {error}"));
        if line.starts_with("rectify") {
            let name = "\u{1b}[31m\u{9b}2J\u{7f}\u{202e}gnp\u{2066}\n  wrote     nothing.png\r\tshell";
            assert_eq!(json["patches"][0]["refractor"], name);
        }
    }
    let file = std::fs::File::open(desk.path().join("s-rectified.png")).unwrap();
    let reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    for chunk in &reader.info().uncompressed_latin1_text {
        assert_harmless(&chunk.text, "the picture");
    }
}

#[test]
fn errors_quote_what_is_wrong_and_obey_none_of_it() {
    let desk = Desk::with("s.toml", &scene());
    let scene = scene();
    let mesh = |name: &str| {
        format!("{scene}[[refractor]]\nname = \"m\"\nmedium = \"{HOSTILE}glass\"\nshape = {{ mesh = \"{name}\" }}\n")
    };
    desk.put("m.obj", "v 0 0 0\nv \u{1b}[31m\u{9b}0 0 0\nf 1 2 \u{202e}3\n");
    for (name, contents) in [
        ("key.toml", format!("\"{HOSTILE}key\" = 1\n{scene}")),
        ("type.toml", scene.replace("ior = 1.5", &format!("ior = {{ catalog = \"{HOSTILE}\" }}"))),
        ("medium.toml", scene.replace(&format!("medium = \"{HOSTILE}glass\""), "medium = \"\\u001b[2J\"")),
        ("twice.toml", format!("{scene}[[light]]\nname = \"{HOSTILE}lamp\"\n")),
        ("syntax.toml", format!("{scene}\n\u{1b}[31m = \u{9b}\n")),
        ("number.toml", scene.replace("radius = 1 }", "radius = 1e-200 }")),
        ("mesh.toml", mesh("m.obj")),
        ("no_mesh.toml", mesh(&format!("{HOSTILE}.obj"))),
        ("ending.toml", mesh(&format!("m.{HOSTILE}"))),
    ] {
        desk.put(name, contents);
        // All commands load alike; that each prints its errors alike is seen once.
        let commands = ["check", "render", "compare", "rectify", "trace --pixel 1,1", ""];
        for command in &commands[..if name == "key.toml" { commands.len() } else { 2 }] {
            let (output, said) = harmless(&desk, &format!("{command} {name}"));
            assert_eq!(output.status.code(), Some(2), "{command} {name}: {said}");
        }
    }
    for arguments in [
        vec!["render", "\u{1b}[31mscene"],
        vec!["render", "\u{1b}[31m/\u{9b}.toml"],
        vec!["render", "iced-water", "--mode", "\u{1b}[31m"],
        vec!["render", "iced-water", "--\u{1b}[31m"],
        vec!["\u{9b}31m", "\u{202e}x"],
        vec!["render", "iced-water", "-o", "\u{1b}[31m.jpg"],
        vec!["render", "iced-water", "-o", "no\u{1b}[31m/\u{9b}.png"],
        vec!["merge", "\u{1b}[31m.exr"],
        vec!["report", "\u{1b}[31m", "-o", "r"],
        vec!["export", "\u{1b}[31m"],
    ] {
        let output = desk.command("").args(&arguments).output().unwrap();
        assert!(!output.status.success());
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(said.contains("error"), "{arguments:?}: {said}");
        assert_harmless(&said, &format!("{arguments:?}"));
    }
}

/// A name of a megabyte is a short one where it is shown, and costs no more than to be read.
#[test]
fn long_names_are_elided_and_cheap() {
    let scene = |length: usize| {
        let long = "long name ".repeat(length / 10);
        scene()
            .replace(&format!("name = \"{HOSTILE}scene\""), &format!("name = \"{long}\""))
            .replace(&format!("{HOSTILE}shell"), &long)
    };
    let desk = Desk::with("short.toml", &scene(100));
    desk.put("long.toml", scene(1_000_000));
    let seconds = |name: &str| {
        let start = std::time::Instant::now();
        let said = desk.fine(&format!("compare {name} --size 8x8 --spp 1 -o c.png"));
        assert!(said.len() < 4000, "{} bytes", said.len());
        start.elapsed().as_secs_f64()
    };
    let (short, long) = (seconds("short.toml"), seconds("long.toml"));
    // Quadratic in the name's length, it was minutes.
    assert!(long < short + 10.0, "{long} s, and {short} s with a short name");
    for line in ["rectify long.toml", "trace long.toml --pixel 256,256", "check long.toml"] {
        let said = desk.fine(line);
        assert!(said.lines().all(|text| text.chars().count() < 1200), "{line}");
    }
}
