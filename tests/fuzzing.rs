//! Every reader of files over a small corpus (`tests/fuzz/corpus`) and over damaged copies of it: each input is answered, without a panic and
//! without much memory. The same functions are fuzzed by cargo-fuzz, see `tests/fuzz/Cargo.toml`.
//!
//! The damage is random, but the same in every run. More of it: `IORECT_FUZZ_ROUNDS=100000 cargo test --test fuzzing`.

#[path = "fuzz/corpus.rs"]
mod corpus;
#[path = "fuzz/damage.rs"]
mod damage;
#[path = "fuzz/gltf.rs"]
mod gltf;
#[path = "fuzz/targets.rs"]
mod targets;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use damage::Damage;

/// Damaged copies of each file of the corpus.
const ROUNDS: u64 = 250;
/// Most bytes that the process may have had at once, with all targets running beside each other.
#[cfg(target_os = "linux")]
const MOST_MEMORY: u64 = 4 << 30;

type Target = fn(&[u8]) -> bool;

fn folder(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(target)
}

/// The files of a target's corpus, by name.
fn files(target: &str) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder(target)).expect("the corpus is there");
    let paths = entries.map(|entry| entry.expect("a folder can be listed").path());
    let read = |path: PathBuf| {
        let name = path.file_name().expect("it was listed").to_string_lossy().into_owned();
        (name, fs::read(&path).expect("a file can be read"))
    };
    let mut files: Vec<_> = paths.map(read).collect();
    files.sort();
    files
}

/// Runs `target` over its corpus, where every file must be accepted, and over damaged copies.
fn run(name: &str, target: Target) {
    let files = files(name);
    assert!(files.len() >= 2, "the corpus of {name} is too small");
    let rounds = std::env::var("IORECT_FUZZ_ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(ROUNDS);
    let (mut accepted, mut refused) = (0, 0);
    for (index, (file, bytes)) in files.iter().enumerate() {
        assert!(target(bytes), "{name}/{file} is not accepted");
        for round in 0..rounds {
            let mut damage = Damage::new((index as u64) << 32 | round);
            let others: Vec<&[u8]> = files.iter().map(|(_, bytes)| &bytes[..]).collect();
            let damaged = damage.apply(bytes, &others);
            match catch_unwind(AssertUnwindSafe(|| target(&damaged))) {
                Ok(true) => accepted += 1,
                Ok(false) => refused += 1,
                Err(_) => {
                    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{round}-{file}"));
                    fs::write(&path, &damaged).expect("the build folder is writable");
                    panic!("{name}/{file}, damaged in round {round}: the bytes are in {}", path.display());
                }
            }
        }
    }
    // Damage that never, or always, ruins a file would test nothing.
    assert!(accepted > 0 && refused > 0, "{name}: {accepted} accepted, {refused} refused");
    #[cfg(target_os = "linux")]
    {
        let status = fs::read_to_string("/proc/self/status").expect("Linux tells");
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("it says how much was used");
        let most: u64 = line.trim().trim_end_matches(" kB").parse().expect("a number of kilobytes");
        assert!(most << 10 < MOST_MEMORY, "{name}: {most} kB were used");
    }
}

#[test]
fn damaged_scenes_are_answered() {
    run("scene", targets::scene);
}

#[test]
fn damaged_obj_meshes_are_answered() {
    run("obj", targets::obj);
}

#[test]
fn damaged_materials_are_answered() {
    run("mtl", targets::mtl);
}

#[test]
fn damaged_ply_meshes_are_answered() {
    run("ply", targets::ply);
}

#[test]
fn damaged_gltf_scenes_are_answered() {
    run("gltf", targets::gltf);
}

/// Damage at random seldom leaves JSON whole. Here each number in turn is another.
#[test]
fn every_number_of_a_gltf_file_may_be_wrong() {
    let numbers = serde_json::json!([
        0,
        1,
        2,
        3,
        7,
        255,
        5121,
        5126,
        65535,
        65536,
        4_294_967_295_u32,
        1_u64 << 40,
        u64::MAX,
        -1,
        0.5,
        1e-300,
        1e38,
        1e300,
        -1e300
    ]);
    let places = gltf::numbers(&gltf::table().0);
    let (mut accepted, mut refused) = (0, 0);
    for place in &places {
        for number in numbers.as_array().expect("a list") {
            let bytes = gltf::with_number(place, number);
            match catch_unwind(AssertUnwindSafe(|| targets::gltf(&bytes))) {
                Ok(true) => accepted += 1,
                Ok(false) => refused += 1,
                Err(_) => panic!("{place} = {number}"),
            }
        }
    }
    assert!(places.len() > 100 && accepted > 100 && refused > 100, "{accepted} accepted, {refused} refused");
}

#[test]
fn damaged_hdr_images_are_answered() {
    run("hdr", targets::hdr);
}

#[test]
fn damaged_exr_images_are_answered() {
    run("exr", targets::exr);
}

#[test]
fn damaged_png_images_are_answered() {
    run("png", targets::png);
}

#[test]
fn damaged_jpeg_images_are_answered() {
    run("jpeg", targets::jpeg);
}

#[test]
fn damaged_sums_are_answered() {
    run("sums", targets::sums);
}

/// Each target has a program for cargo-fuzz, which is named in its manifest.
#[test]
fn every_target_can_be_fuzzed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz");
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    let mut targets: Vec<String> =
        fs::read_dir(folder.join("corpus")).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    targets.retain(|name| folder.join("corpus").join(name).is_dir());
    assert_eq!(targets.len(), 10);
    for target in targets {
        let program = fs::read_to_string(folder.join(format!("fuzz_targets/{target}.rs"))).unwrap();
        assert!(program.contains(&format!("targets::{target}(bytes)")), "{target}");
        assert!(manifest.contains(&format!("path = \"fuzz_targets/{target}.rs\"")), "{target}");
    }
}

/// Writes the corpus anew: `cargo test --test fuzzing write_the_corpus -- --ignored`.
#[test]
#[ignore = "writes into the source tree"]
fn write_the_corpus() {
    for (target, name, bytes) in corpus::all() {
        fs::create_dir_all(folder(target)).unwrap();
        fs::write(folder(target).join(name), bytes).unwrap();
    }
}
