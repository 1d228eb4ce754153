//! The graphics processor on the command line, in software where there is no other.

use std::fs;

use serde_json::{Value, json};

use crate::desk::{Desk, text};
use crate::merge::SCENE;

/// `None` where this machine has no graphics processor, not even one in software: on a build server that is a failure.
#[allow(clippy::print_stderr, reason = "it says why tests are skipped")]
fn with_gpu() -> Option<Desk> {
    let desk = Desk::with("ball.toml", SCENE);
    let output = desk.run("render ball.toml --backend gpu --size 1x1 --spp 1 --json");
    if output.status.code() == Some(0) {
        return Some(desk);
    }
    let why = text(&output.stderr);
    assert!(why.contains("graphics processor") && std::env::var_os("CI").is_none(), "{why}");
    eprintln!("skipped: {why}");
    None
}

/// The mean of all pixels, and the share of pixels that are apart by more than rounding.
fn apart(desk: &Desk, a: &str, b: &str) -> (f64, f64) {
    let [a, b] = [a, b].map(|name| desk.picture(name));
    let mean = |picture: &[f32]| picture.iter().map(|x| f64::from(*x)).sum::<f64>() / picture.len() as f64;
    let others = a.iter().zip(&b).filter(|(a, b)| (*a - *b).abs() > 1e-3 * (a.abs() + 1e-3)).count();
    ((mean(&b) / mean(&a) - 1.0).abs(), others as f64 / a.len() as f64)
}

#[test]
fn it_renders_the_image_of_the_cpu_and_says_that_it_did() {
    let Some(desk) = with_gpu() else { return };
    let image = "render ball.toml --size 40x30 --spp 16 --adaptive off --json";
    let by_gpu = desk.json(&format!("{image} --backend gpu -o gpu.exr"));
    let by_cpu = desk.json(&format!("{image} --backend cpu --splits 0 -o cpu.exr"));
    assert_eq!((&by_gpu["backend"], &by_gpu["splits"], &by_gpu["notice"]), (&json!("gpu"), &json!(0), &Value::Null));
    assert_eq!((&by_cpu["backend"], &by_cpu["adapter"]), (&json!("cpu"), &Value::Null));
    let adapter = by_gpu["adapter"].as_str().expect("it has a name");
    let (mean, others) = apart(&desk, "cpu.exr", "gpu.exr");
    assert!(mean < 0.01 && others < 0.1, "{mean}, {others}");
    // The twin: other samples are apart.
    desk.json(&format!("{image} --backend gpu --seed 1 -o other.exr"));
    assert!(apart(&desk, "cpu.exr", "other.exr").1 > 0.5);
    // Pictures name what has rendered them.
    desk.fine("render ball.toml --backend gpu --size 8x6 --spp 1 -o ball.png");
    for name in ["ball.png", "gpu.exr"] {
        let bytes = desk.get(name);
        assert!(
            bytes.windows(adapter.len()).any(|window| window == adapter.as_bytes()),
            "{name} does not say {adapter}"
        );
    }
    let said = desk.fine("render ball.toml --backend gpu --size 8x6 --spp 1 -o ball.png");
    assert!(said.contains(adapter), "{said}");
}

#[test]
fn the_reference_stays_on_the_cpu() {
    let Some(desk) = with_gpu() else { return };
    let line = "compare ball.toml --modes rectified,reference --backend gpu --size 12x9 --spp 4 --json";
    let compared = desk.json(line);
    let of = |pane: usize, key: &str| compared["panes"][pane][key].clone();
    assert_eq!((of(0, "backend"), of(1, "backend")), (json!("gpu"), json!("cpu")));
    // Both take the same samples: neither splits.
    assert_eq!((of(0, "splits"), of(1, "splits")), (json!(0), json!(0)));
    assert!(of(1, "adapter").is_null());
    // By itself it is not what was asked for, which is told.
    let output = desk.run("render ball.toml --mode reference --backend gpu --size 4x3 --spp 1 --json");
    let said = text(&output.stderr);
    assert!(
        output.status.success() && said.contains("mode reference is computed in f64; the CPU renders it"),
        "{said}"
    );
}

#[test]
fn parts_of_both_are_merged_only_if_told_to() {
    let Some(desk) = with_gpu() else { return };
    let part = |backend: &str, samples: &str, name: &str| {
        desk.fine(&format!("render ball.toml --size 10x8 --samples {samples} {backend} -o {name}"));
    };
    part("--backend gpu", "0..8", "gpu.exr");
    part("--backend gpu", "8..12", "more.exr");
    part("--backend cpu --splits 0", "12..16", "cpu.exr");
    part("--backend cpu", "16..20", "splits.exr");
    let of_gpu = desk.json("merge gpu.exr more.exr --json");
    assert_eq!((&of_gpu["backend"], &of_gpu["samples"]), (&json!("gpu"), &json!([[0, 12]])));
    let refused = desk.run("merge gpu.exr cpu.exr -o all.exr");
    let why = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{why}");
    assert!(why.contains("the backend differs: cpu here, gpu there") && why.contains("--mix-backends"), "{why}");
    let mixed = desk.json("merge gpu.exr cpu.exr --mix-backends -o all.exr -o all.png --json");
    assert_eq!((&mixed["backend"], &mixed["samples"]), (&json!("mixed"), &json!([[0, 8], [12, 16]])));
    assert_eq!(mixed["adapter"], of_gpu["adapter"]);
    // It is a part like any other, and goes with further ones.
    desk.fine("merge all.exr more.exr --mix-backends -o whole.exr");
    // Nothing else may differ.
    let refused = desk.run("merge gpu.exr splits.exr --mix-backends -o all.exr");
    assert!(text(&refused.stderr).contains("--splits differs"), "{}", text(&refused.stderr));
}

#[test]
fn the_cpu_goes_on_where_it_is_lost() {
    let Some(desk) = with_gpu() else { return };
    let image = "render ball.toml --size 40x30 --spp 32 --adaptive off --json";
    desk.json(&format!("{image} --backend cpu --splits 0 -o cpu.exr"));
    let output = desk.run(&format!("{image} --backend gpu --lose-gpu-after 1 -o lost.exr"));
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("lost") && said.contains("the CPU took the others"), "{said}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["backend"], &report["spp"]), (&json!("mixed"), &json!(32)));
    assert!(report["notice"].as_str().unwrap().contains("the CPU took the others"));
    let (mean, others) = apart(&desk, "cpu.exr", "lost.exr");
    assert!(mean < 0.01 && others < 0.1, "{mean}, {others}");
}

#[test]
fn where_there_is_none_it_is_said_what_to_do() {
    let desk = Desk::with("ball.toml", SCENE);
    // This machine may have one; through an interface of other systems it does not.
    let interface = if cfg!(target_os = "macos") { "dx12" } else { "metal" };
    let run = |backend: &str| {
        let line = format!("render ball.toml --size 80x60 --spp 64 --backend {backend} --json");
        desk.command(&line).env("WGPU_BACKEND", interface).output().unwrap()
    };
    let output = run("gpu");
    let why = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{why}");
    assert!(why.contains("no graphics processor was found") && why.contains("CPU"), "{why}");
    let output = run("auto");
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["backend"], &report["adapter"]), (&json!("cpu"), &Value::Null));
    // What contradicts itself is told before any work.
    let contradiction = desk.run("render ball.toml --backend gpu --splits 2");
    assert_eq!(contradiction.status.code(), Some(2));
    assert!(text(&contradiction.stderr).contains("--splits"));
    assert!(fs::read_dir(desk.path()).unwrap().count() == 1, "nothing is written");
}
