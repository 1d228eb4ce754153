//! The real binary, run as its users run it: what it prints, what it writes, and how it ends.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::desk::{Desk, text};
use iorect::measure::flip;
use serde_json::Value;

/// Two concentric balls in a white room without walls: cheap, and with known answers (a furnace; Bouguer's formula).
const NEST: &str = r#"
name = "A nest"
[camera]
position = [0.0, 0.0, 6.0]
target = [0.0, 0.0, 0.0]
vertical_fov = 24.0
[environment]
color = [1.0, 1.0, 1.0]
[[medium]]
name = "glass"
ior = 1.5
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
[[refractor]]
name = "core"
medium = "glass"
shape = { sphere = { center = [0.0, 0.0, 0.0], radius = 0.5 } }
"#;

fn with_nest() -> Desk {
    Desk::with("nest.toml", NEST)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

fn assert_has(value: &Value, expected: &[&str]) {
    let keys = keys(value);
    for key in expected {
        assert!(keys.contains(key), "`{key}` is missing among {keys:?}");
    }
}

const IMAGE_KEYS: [&str; 15] = [
    "scene",
    "mode",
    "backend",
    "adapter",
    "notice",
    "estimator",
    "width",
    "height",
    "spp",
    "seed",
    "threads",
    "seconds",
    "events",
    "left_out",
    "output",
];
const EVENT_KEYS: [&str; 8] = [
    "stack_underflow",
    "stack_overflow",
    "ambiguous",
    "inconsistent",
    "non_finite",
    "radiance_overflow",
    "crossings",
    "mixed",
];

#[test]
fn help_names_every_command_and_every_flag() {
    let desk = with_nest();
    let help = desk.fine("--help");
    for word in ["render", "compare", "rectify", "trace", "check", "scenes", "[SCENE]", "Examples:", "Exit codes:"] {
        assert!(help.contains(word), "`{word}` is missing in: {help}");
    }
    let render = desk.fine("render --help");
    for flag in [
        "--mode",
        "--spp",
        "--time",
        "--size",
        "--seed",
        "--max-depth",
        "--backend",
        "--estimator",
        "--output",
        "--threads",
        "--exposure",
        "--curve",
        "--leave-out",
        "--json",
    ] {
        assert!(render.contains(flag), "`{flag}` is missing in: {render}");
    }
    assert!(desk.fine("--version").starts_with("iorect "));
}

#[test]
fn scenes_are_listed_with_a_sentence_each() {
    let desk = with_nest();
    let listed = desk.json("scenes --json");
    let listed = listed.as_array().unwrap();
    assert!(!listed.is_empty());
    let table = desk.fine("scenes");
    for scene in listed {
        assert_has(scene, &["name", "about", "file"]);
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(scene["file"].as_str().unwrap());
        assert!(file.is_file(), "{} does not exist", file.display());
        assert!(table.contains(scene["name"].as_str().unwrap()));
    }
}

#[test]
fn render_writes_a_picture_that_says_what_it_is() {
    let desk = with_nest();
    let said = desk.fine("render nest.toml --size 24x16 --spp 4 --seed 9");
    assert!(said.contains("wrote     nest-rectified.png") && said.contains("no events"), "{said}");
    assert_eq!(desk.files(), ["nest-rectified.png", "nest.toml"]);
    let file = fs::File::open(desk.path().join("nest-rectified.png")).unwrap();
    let reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let info = reader.info();
    assert_eq!((info.width, info.height), (24, 16));
    let get = |keyword: &str| {
        let chunks = &info.uncompressed_latin1_text;
        chunks.iter().find(|chunk| chunk.keyword == keyword).map(|chunk| chunk.text.clone())
    };
    assert_eq!(get("Title").unwrap(), "A nest");
    assert_eq!(get("Mode").unwrap(), "rectified");
    assert_eq!(get("IOR").unwrap(), "world = 1; glass = 1.5; water = 1.333");
    assert_eq!(get("Samples per pixel").unwrap(), "4");
    assert_eq!(get("Seed").unwrap(), "9");
    assert!(get("Software").unwrap().starts_with("iorect "));
}

#[test]
fn render_json_has_the_documented_fields_and_writes_nothing_unasked() {
    let desk = with_nest();
    let report = desk.json("render nest.toml --size 8x4 --spp 2 --threads 2 --mode stack --json");
    assert_has(&report, &IMAGE_KEYS);
    assert_has(&report["seconds"], &["load", "bvh", "rectify", "compile", "render"]);
    assert_has(&report["events"], &EVENT_KEYS);
    assert_eq!(report["mode"], "stack");
    assert_eq!((&report["backend"], &report["estimator"]), (&"cpu".into(), &"path".into()));
    assert_eq!((&report["width"], &report["height"], &report["spp"]), (&8.into(), &4.into(), &2.into()));
    assert_eq!((&report["seed"], &report["threads"]), (&0.into(), &2.into()));
    assert!(number(&report["seconds"]["render"]) > 0.0);
    assert!(report["left_out"].as_array().unwrap().contains(&"absorption".into()));
    assert!(report["output"].is_null());
    assert_eq!(desk.files(), ["nest.toml"]);
    let everything = desk.json("render nest.toml --size 8x4 --spp 1 --leave-out off --json");
    assert_eq!(everything["left_out"], Value::Array(vec![]));
    // What lowers the noise, by default and off.
    let keys = ["adaptive", "splits", "sampler", "sample_environment"];
    assert_eq!(keys.map(|key| report[key].clone()), [true.into(), 2.into(), "sobol".into(), Value::Bool(true)]);
    let off = "render nest.toml --size 8x4 --spp 1 --json --adaptive off --splits 0 --sampler independent --sample-environment off";
    let plain = desk.json(off);
    assert_eq!(keys.map(|key| plain[key].clone()), [false.into(), 0.into(), "independent".into(), Value::Bool(false)]);
}

/// Whatever a lossless nest does to the paths, a white environment seen through it stays white: exactly where every path keeps all of its
/// light, in the mean where small branches of paths are followed by chance.
#[test]
fn a_furnace_stays_white_in_the_exr() {
    let desk = with_nest();
    for splits in ["0", "2"] {
        desk.fine(&format!("render nest.toml --size 20x20 --spp 16 --splits {splits} -o white.exr"));
        let image = image::open(desk.path().join("white.exr")).unwrap().into_rgb32f();
        assert_eq!(image.dimensions(), (20, 20));
        let errors = || image.as_raw().iter().map(|x| f64::from(x - 1.0));
        let furthest = errors().fold(0.0, |most: f64, x| most.max(x.abs()));
        let mean = errors().sum::<f64>() / 1200.0;
        let (most, least) = if splits == "0" { (1e-5, 1e-5) } else { (0.3, 0.005) };
        assert!(furthest < most && mean.abs() < least, "{splits}: {furthest}, {mean}");
    }
}

#[test]
fn the_image_is_a_function_of_the_seed_and_not_of_the_threads() {
    let desk = with_nest();
    let render = |name: &str, more: &str| {
        desk.fine(&format!("render camera-in-water --size 16x12 --spp 3 -o {name} {more}"));
        desk.get(name)
    };
    let one = render("one.exr", "--threads 1");
    assert!(one == render("three.exr", "--threads 3"));
    assert!(one != render("other.exr", "--seed 1"));
}

#[test]
fn time_is_kept_and_gives_one_sample_at_least() {
    let desk = with_nest();
    let spp = |time: &str| {
        let report = desk.json(&format!("render nest.toml --size 32x32 --time {time} --json"));
        (report["spp"].as_u64().unwrap(), number(&report["seconds"]["render"]))
    };
    assert_eq!(spp("1e-9").0, 1);
    let (samples, seconds) = spp("0.4");
    // Generous above: the machine may be busy.
    assert!(samples > 1 && (0.2..5.0).contains(&seconds), "{samples} samples in {seconds} s");
}

#[test]
fn compare_draws_panes_and_measures_every_pair() {
    let desk = with_nest();
    let report = desk.json("compare nest.toml --size 24x24 --spp 4 --json -o c.png");
    assert_has(&report, &["scene", "panes", "differences"]);
    let panes = report["panes"].as_array().unwrap();
    assert_eq!(
        panes.iter().map(|pane| pane["mode"].as_str().unwrap()).collect::<Vec<_>>(),
        ["naive", "stack", "rectified"]
    );
    panes.iter().for_each(|pane| assert_has(pane, &IMAGE_KEYS));
    let differences = report["differences"].as_array().unwrap();
    assert_eq!(differences.len(), 3);
    for difference in differences {
        assert_has(difference, &["a", "b", "mse", "relmse", "mean_abs", "flip"]);
    }
    let of = |a: &str, b: &str| differences.iter().find(|d| d["a"] == a && d["b"] == b).unwrap();
    // From outside a clean nest the stack finds the same media, with the same random numbers: no difference at all.
    assert_eq!(number(&of("stack", "rectified")["mse"]), 0.0);
    assert_eq!(number(&of("stack", "rectified")["flip"]), 0.0);
    let (width, height) = image::image_dimensions(desk.path().join("c.png")).unwrap();
    assert!(width > 3 * 280 && height > 2 * 280);

    // Naive is a furnace too; with something to see it must differ.
    let seen = desk.json("compare nested-spheres --size 24x24 --spp 4 --modes rectified,naive --json");
    let difference = &seen["differences"][0];
    assert_eq!((&difference["a"], &difference["b"]), (&"naive".into(), &"rectified".into()));
    assert!(number(&difference["relmse"]) > 0.01, "{difference}");
    assert_eq!(desk.files(), ["c.png", "nest.toml"]);
}

/// By the library, from the pictures of the modes as `render` writes them.
#[test]
fn compare_gives_the_flip_of_what_the_picture_shows() {
    const SIDE: usize = 24;
    let desk = with_nest();
    let image = |display: &str| format!("nested-spheres --size {SIDE}x{SIDE} --spp 4 --adaptive off {display}");
    let run = |command: String| desk.fine(&command);
    let shown = |mode: &str, display: &str| -> Vec<[f32; 3]> {
        run(format!("render {} --mode {mode} -o {mode}.png", image(display)));
        let png = image::open(desk.path().join(format!("{mode}.png"))).unwrap().into_rgb8();
        png.pixels().map(|pixel| pixel.0.map(|byte| f32::from(byte) / 255.0)).collect()
    };
    let flips = ["--exposure 0", "--exposure -1.5", "--curve clip"].map(|display| {
        let report = run(format!("compare {} --modes rectified,naive,priority --json", image(display)));
        let report: Value = serde_json::from_str(&report).unwrap();
        let pairs = report["differences"].as_array().unwrap();
        assert_eq!(pairs.len(), 3);
        let of_pair = |pair: &Value| {
            let [a, b] = ["a", "b"].map(|which| shown(pair[which].as_str().unwrap(), display));
            let reference = flip::Reference::ldr(&b, SIDE, SIDE, flip::DEFAULT_PIXELS_PER_DEGREE).unwrap();
            let (got, expected) = (number(&pair["flip"]), reference.flip(&a).unwrap().mean());
            assert!((got - expected).abs() < 1e-12, "{expected}, but {pair}");
            got
        };
        let naive = pairs.iter().position(|pair| pair["a"] == "naive" && pair["b"] == "rectified").unwrap();
        pairs.iter().map(of_pair).collect::<Vec<_>>()[naive]
    });
    // The twins: a picture shown otherwise has another figure, so the tests above would find it out.
    assert!(flips[0] > 0.05, "{flips:?}");
    assert!(flips[1..].iter().all(|flip| (flip - flips[0]).abs() > 1e-4), "{flips:?}");
    let said = run(format!("compare {} -o c.png", image("")));
    let heading = said.lines().find(|line| line.contains("relMSE")).unwrap();
    assert!(heading.ends_with("FLIP"), "{said}");
}

#[test]
fn rectify_finds_what_contains_what() {
    let desk = with_nest();
    let report = desk.json("rectify nest.toml --json");
    assert_has(&report, &["scene", "granularity", "seconds", "patches", "warnings"]);
    assert_has(&report["seconds"], &["topology", "patches", "pretrace", "resolve"]);
    assert_eq!(report["granularity"], "patch");
    let patches = report["patches"].as_array().unwrap();
    let found: Vec<_> = (patches.iter())
        .map(|p| {
            assert_has(
                p,
                &[
                    "refractor",
                    "patch",
                    "faces",
                    "area",
                    "kind",
                    "outside",
                    "inside",
                    "outside_refractor",
                    "inside_refractor",
                    "rays",
                    "confidence",
                ],
            );
            assert_eq!((&p["kind"], number(&p["confidence"])), (&"clear".into(), 1.0));
            ["refractor", "outside", "inside"].map(|key| p[key].as_str().unwrap())
        })
        .collect();
    assert_eq!(found, [["shell", "world", "glass"], ["middle", "glass", "water"], ["core", "water", "glass"]]);
    assert_eq!(patches[0]["outside_refractor"], Value::Null);
    assert_eq!(patches[2]["outside_refractor"], "middle");
    let area = number(&patches[0]["area"]);
    assert!((area - 4.0 * std::f64::consts::PI).abs() < 1e-9, "{area}");

    let table = desk.fine("rectify nest.toml --granularity object");
    assert!(table.contains("glass 1.5000") && table.contains("3 refractors"), "{table}");
}

/// Deflection of a ray at impact parameter 0.5 by the shells 1, 0.7 and 0.5 of 1.5, 1.333 and 1.5, by Bouguer's formula: 26.72105044°.
#[test]
fn trace_follows_a_ray_through_the_nest() {
    let desk = with_nest();
    let trace =
        |mode: &str| desk.json(&format!("trace nest.toml --origin -0.5,0,3 --direction 0,0,-2 --mode {mode} --json"));
    let deflection = |path: &Value| {
        let direction: Vec<f64> = path["final_direction"].as_array().unwrap().iter().map(number).collect();
        direction[0].atan2(-direction[2]).to_degrees().abs()
    };
    let rectified = trace("rectified");
    assert_has(&rectified, &["mode", "camera_medium", "vertices", "escaped", "final_direction"]);
    assert_eq!((&rectified["camera_medium"], &rectified["escaped"]), (&"world".into(), &true.into()));
    assert!((deflection(&rectified) - 26.721_050_44).abs() < 1e-4, "{}", deflection(&rectified));
    for mode in ["stack", "priority", "rectified-object", "reference"] {
        let path = trace(mode);
        assert_eq!(path["mode"], mode);
        assert!((deflection(&path) - 26.721_050_44).abs() < 1e-4, "{mode}: {}", deflection(&path));
    }
    assert!((deflection(&trace("naive")) - 26.721_050_44).abs() > 1.0);

    let vertices = rectified["vertices"].as_array().unwrap();
    for vertex in vertices {
        assert_has(
            vertex,
            &["position", "refractor", "patch", "solid", "from", "to", "ior_from", "ior_to", "fresnel", "event"],
        );
        assert!(vertex["solid"].is_null());
        assert_eq!(vertex["event"], "transmit");
    }
    // Where a medium ends the next begins.
    for pair in vertices.windows(2) {
        assert_eq!(pair[0]["to"], pair[1]["from"]);
    }
    assert_eq!(
        (&vertices[0]["refractor"], &vertices[0]["to"], number(&vertices[0]["ior_to"])),
        (&"shell".into(), &"glass".into(), 1.5)
    );

    // The centre of the image looks straight at the centre of the nest; an odd size has a pixel there.
    let straight = desk.json("trace nest.toml --pixel 16,16 --size 33x33 --json");
    assert!(deflection(&straight) < 1e-9);
    assert_eq!(straight["vertices"].as_array().unwrap().len(), 6);
    assert!((number(&straight["vertices"][0]["fresnel"]) - 0.04).abs() < 1e-9);
    let back = desk.json("trace nest.toml --pixel 16,16 --size 33x33 --follow reflect --json");
    assert_eq!((&back["vertices"][0]["event"], back["vertices"].as_array().unwrap().len()), (&"reflect".into(), 1));
    // Naive parts from the others where the second surface is met: inside the shell is no vacuum.
    let both = desk.json("trace nest.toml --pixel 16,16 --size 33x33 --mode naive --against rectified --json");
    assert_eq!((&both["mode"], &both["against"]["mode"]), (&"naive".into(), &"rectified".into()));
    let parting = &both["parting"];
    assert_has(parting, &["vertex", "position", "refractor", "is_entering", "claims", "truth", "faults"]);
    assert_eq!((number(&parting["vertex"]), &parting["faults"][0]["cause"]), (1.0, &"vacuum_outside".into()));
    assert!(parting["faults"][1].is_null());
    let words = desk.fine("trace nest.toml --pixel 16,16 --size 33x33 --mode naive --against rectified");
    assert!(words.contains("naive and rectified part at surface 2"), "{words}");
    let same = desk.fine("trace nest.toml --pixel 16,16 --size 33x33 --mode stack --against rectified");
    assert!(same.contains("stack and rectified agree about this path."), "{same}");
    let table = desk.fine("trace nest.toml --pixel 16,16 --size 33x33");
    assert!(table.contains("starts in world") && table.contains("leaves the scene"), "{table}");
}

#[test]
fn check_reports_what_is_wrong_and_where() {
    let desk = with_nest();
    let fine = desk.json("check nest.toml --json");
    assert_has(&fine, &["scene", "problems"]);
    assert_eq!(fine["problems"], Value::Array(vec![]));

    desk.put("advice.toml", format!("{NEST}\n[[medium]]\nname = \"honey\"\nior = 1.49\n"));
    let advice = desk.json("check advice.toml --json");
    let problem = &advice["problems"][0];
    assert_has(problem, &["severity", "where", "kind", "message"]);
    assert_eq!((&problem["severity"], &problem["where"]), (&"advice".into(), &"honey".into()));
    assert!(desk.fine("check advice.toml").contains("honey"));
    // Whoever wants to can be told by the exit code.
    for (deny, code) in [("", 0), ("--deny warning", 0), ("--deny advice", 1)] {
        assert_eq!(desk.run(&format!("check advice.toml {deny}")).status.code(), Some(code), "{deny}");
    }

    desk.put("wrong.toml", NEST.replace("radius = 0.7", "radius = 0.0"));
    let output = desk.run("check wrong.toml --json");
    assert_eq!(output.status.code(), Some(2));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["problems"][0]["severity"], "error");
    assert!(report["problems"][0]["where"].as_str().unwrap().contains("wrong.toml:"), "{report}");
}

#[test]
fn wrong_scenes_are_refused_with_file_line_and_column() {
    let desk = with_nest();
    let cases = [
        ("ior = 1.333", "ior = 0.0", "0"),
        ("ior = 1.333", "ior = -1.3", "-1.3"),
        ("ior = 1.333", "ior = nan", "NaN"),
        ("ior = 1.333", "ior = inf", "inf"),
        ("radius = 0.7", "radius = 0", "radius"),
        ("radius = 0.7", "radius = -1.0", "radius"),
        ("medium = \"water\"", "medium = \"watr\"", "water"),
        ("radius = 0.7 }", "raduis = 0.7 }", "radius"),
        ("name = \"middle\"", "name = \"shell\"", "shell"),
        ("[environment]", "[environment", ""),
        ("target = [0.0, 0.0, 0.0]", "target = [0.0, 0.0, 6.0]", "direction"),
        ("vertical_fov = 24.0", "vertical_fov = 180.0", "vertical_fov"),
        ("medium = \"water\"", "medium = \"water\"\nroughness = 1.2", "between 0 and 1"),
    ];
    for (from, to, hint) in cases {
        assert!(NEST.contains(from));
        desk.put("bad.toml", NEST.replacen(from, to, 1));
        let message = desk.wrong("render bad.toml --size 4x4 --spp 1 --json");
        assert!(message.contains("bad.toml"), "{to}: {message}");
        assert!(message.to_lowercase().contains(&hint.to_lowercase()), "{to}: `{hint}` is missing in: {message}");
    }
    // With the place, for what stands in a line.
    desk.put("bad.toml", NEST.replacen("ior = 1.333", "ior = 0.0", 1));
    let line = NEST.lines().position(|line| line == "ior = 1.333").unwrap() + 1;
    assert!(desk.wrong("rectify bad.toml").contains(&format!("bad.toml:{line}:")));

    desk.put(
        "mesh.toml",
        NEST.replacen("{ sphere = { center = [0.0, 0.0, 0.0], radius = 0.7 } }", "{ mesh = \"none.obj\" }", 1),
    );
    assert!(desk.wrong("check-nothing").contains("check-nothing"));
    assert!(desk.wrong("trace mesh.toml --pixel 0,0").contains("none.obj"));
    desk.put("empty.toml", "");
    assert!(desk.wrong("render empty.toml").contains("camera"));
    fs::write(desk.path().join("binary.toml"), [0xff, 0xfe, 0x00, 0x01]).unwrap();
    assert!(desk.wrong("render binary.toml").contains("binary.toml"));
}

#[test]
fn wrong_commands_are_refused_before_any_work() {
    let desk = with_nest();
    let cases = [
        ("render missing.toml", "missing.toml"),
        ("render camera-in-watr", "camera-in-water"),
        ("render", "SCENE"),
        ("render nest.toml --size 0x0", "at least one pixel"),
        ("render nest.toml --size 512", "1280x720"),
        ("render nest.toml --size 100000x100000", "at most"),
        ("render nest.toml --size -5x5", "not a number of pixels"),
        ("render nest.toml --spp 0", "--spp"),
        ("render nest.toml --spp -3", "--spp"),
        ("render nest.toml --spp 4 --time 1", "--time"),
        ("render nest.toml --time -1", "seconds"),
        ("render nest.toml --time nan", "seconds"),
        ("render nest.toml --max-depth 0", "at least 1"),
        ("render nest.toml --threads 0", "--threads"),
        ("render nest.toml --exposure inf", "stops"),
        ("render nest.toml --curve film", "clip, soft"),
        ("render nest.toml --leave-out maybe", "on, off"),
        ("render nest.toml --mode fast", "naive, declared, stack, priority, rectified-object, rectified, reference"),
        ("render nest.toml --backend abacus", "auto, cpu, gpu"),
        ("render nest.toml --backend gpu --splits 1", "--splits"),
        ("render nest.toml --estimator photons", "auto, path, bidirectional, merging"),
        ("render nest.toml --estimator merging --adaptive on", "leave out `--adaptive on`"),
        ("render nest.toml --estimator merging --splits 1", "leave out --splits"),
        ("rectify nest.toml --granularity face", "patch, object"),
        ("report nest.toml", "--output"),
        ("report missing.toml -o out", "missing.toml"),
        ("report nest.toml nest.toml -o out", "called `nest`"),
        ("report nest.toml -o out --only speed", "left-out"),
        ("report nest.toml -o nest.toml", "choose another"),
        ("report nest.toml -o nest.toml/out --quick", "choose another"),
        ("export nest.toml --to blender -o out", "mitsuba, pbrt, gltf, faces"),
        ("export nest.toml --to faces", "--output"),
        ("export nest.toml --to faces -o nest.toml", "choose another"),
        ("export missing.toml --to faces -o out", "missing.toml"),
        ("render nest.toml -o missing/folder/a.png", "no folder"),
        ("render nest.toml -o a.jpg", "`.png` or `.exr`"),
        ("render nest.toml -o a", "`.png` or `.exr`"),
        ("render nest.toml -o nest.toml/a.png", "no folder"),
        ("compare nest.toml -o a.exr", "`.png`"),
        ("compare nest.toml --modes naive,naive", "twice"),
        ("compare nest.toml --modes naive,fast", "unknown mode"),
        ("compare nest.toml --modes=", "unknown mode"),
        ("trace nest.toml", "--pixel"),
        ("trace nest.toml --pixel 512,0", "outside the image"),
        ("trace nest.toml --pixel 0,99 --size 100x99", "rows from 0 to 98"),
        ("trace nest.toml --pixel 1.5,2", "column and row"),
        ("trace nest.toml --origin 0,0,0", "--direction"),
        ("trace nest.toml --origin 0,0,0 --direction 0,0,0", "cannot be zero"),
        ("trace nest.toml --origin 0,0,nan --direction 0,0,1", "finite"),
        ("trace nest.toml --pixel 1,1 --follow light", "sample, transmit, reflect"),
        ("nest.toml extra", "extra"),
        ("missing.toml", "missing.toml"),
        ("--no-such-flag", "--no-such-flag"),
    ];
    for (line, hint) in cases {
        let message = desk.wrong(line);
        assert!(message.contains(hint), "{line}: `{hint}` is missing in: {message}");
    }
    // No folder to write into, even for the superuser.
    #[cfg(target_os = "linux")]
    {
        assert!(desk.wrong("render nest.toml -o /proc/a.png").contains("/proc/a.png"));
        assert!(desk.wrong("report nest.toml -o /proc/report").contains("/proc/report"));
    }
}

/// Where there is no display, the window's scene is compared in a file. The camera looks away from everything, to be quick.
#[cfg(target_os = "linux")]
#[test]
fn without_a_display_the_comparison_is_written() {
    let desk = with_nest();
    desk.put("away.toml", NEST.replace("target = [0.0, 0.0, 0.0]", "target = [0.0, 0.0, 9.0]"));
    let output = desk.run("away.toml");
    let err = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{err}");
    assert!(err.contains("no window can be opened") && err.contains("iorect-comparison.png"), "{err}");
    assert!(!err.contains(".rs:"), "{err}");
    assert!(err.contains("64 samples per pixel, or as many as 20 s allow"), "{err}");
    assert!(err.contains("iorect compare away.toml --spp 1024 -o iorect-comparison.png"), "{err}");
    assert_eq!(desk.files(), ["away.toml", "iorect-comparison.png", "nest.toml"]);
    assert!(image::open(desk.path().join("iorect-comparison.png")).is_ok());
    // But a picture of the window cannot be had.
    let output = desk.run("away.toml --screenshot window.png");
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("no window"));
}

#[cfg(unix)]
#[test]
fn an_interruption_leaves_nothing_half_written() {
    let desk = with_nest();
    desk.put("old.png", "old");
    let mut child = desk
        .command("render nest.toml --size 2048x2048 --spp 100000 -o old.png")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(700));
    assert!(child.try_wait().unwrap().is_none(), "still rendering");
    // Not -INT, which a shell has its background jobs ignore, and their children with them.
    let sent = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert!(!child.wait().unwrap().success());
    assert_eq!(desk.files(), ["nest.toml", "old.png"]);
    assert_eq!(fs::read_to_string(desk.path().join("old.png")).unwrap(), "old");
}

/// `iorect scenes | head -0`: the reader is gone before anything is written.
#[cfg(unix)]
#[test]
fn a_reader_that_has_gone_is_no_error() {
    let desk = with_nest();
    let mut child = desk.command("scenes").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
}

/// A pyramid, as a 3D printer takes it.
const PYRAMID: &str = "solid pyramid
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 1
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 0 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 1 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 1 0 0
vertex 0 1 0
vertex 0 0 1
endloop
endfacet
endsolid
";

#[test]
fn a_mesh_alone_is_a_scene_and_becomes_a_scene_file() {
    let desk = Desk::with("pyramid.stl", PYRAMID);
    let patches = desk.json("rectify pyramid.stl --json");
    assert_eq!(patches["patches"][0]["refractor"], "pyramid");
    assert_eq!(desk.json("check pyramid.stl --json")["problems"], Value::Array(vec![]));
    let alone = desk.json("render pyramid.stl --spp 2 --size 16x12 --json");
    assert_eq!(alone["spp"], 2);
    assert!(desk.fine("convert pyramid.stl made.toml").contains("3 objects"));
    let again = desk.json("rectify made.toml --json");
    assert_eq!(again["patches"], patches["patches"]);
    // What a built-in scene names comes with it.
    desk.fine("convert plain-glass glass.toml");
    assert_eq!(desk.json("check glass.toml --json")["problems"], Value::Array(vec![]));
    for wrong in ["convert pyramid.stl pyramid.obj", "convert missing.stl new.toml"] {
        assert_eq!(desk.run(wrong).status.code(), Some(2), "{wrong}");
    }
}

/// A pane of glass and a sheet of light, by hand.
const SHEETS: &str = r#"{"asset": {"version": "2.0"},
"nodes": [{"mesh": 0, "name": "pane"}, {"mesh": 1, "name": "lamp", "translation": [0, 0, 2]}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
    {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 1}]}],
"materials": [{"name": "glass", "pbrMetallicRoughness": {"roughnessFactor": 0, "metallicFactor": 0},
    "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}, {"emissiveFactor": [1, 1, 1]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
    {"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
"buffers": [{"byteLength": 42, "uri": "sheets.bin"}]}"#;

#[test]
fn a_gltf_file_is_a_scene_and_becomes_a_scene_file() {
    let desk = Desk::with("sheets.gltf", SHEETS);
    let missing = desk.run("check sheets.gltf --json");
    assert_eq!(missing.status.code(), Some(2));
    let text = String::from_utf8(missing.stdout).unwrap();
    assert!(text.contains("buffer 0") && text.contains("sheets.bin cannot be read: there is no such file"), "{text}");
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).chain([0, 1, 2, 0, 2, 1]).collect();
    desk.put("sheets.bin", bytes);
    let problems = desk.json("check sheets.gltf --json")["problems"].clone();
    let kinds: Vec<&str> = problems.as_array().unwrap().iter().filter_map(|problem| problem["kind"].as_str()).collect();
    assert!(kinds.contains(&"thin_as_body") && kinds.contains(&"no_camera"), "{kinds:?}");
    assert!(desk.fine("convert sheets.gltf made.toml").contains("2 objects"));
    assert!(desk.path().join("made-meshes/pane.ply").is_file());
    assert_eq!(desk.json("rectify made.toml --json")["patches"], desk.json("rectify sheets.gltf --json")["patches"]);
}
