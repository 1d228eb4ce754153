//! The architecture as a test: who may use whom. Scans every path in `src` and fails on edges that point up.
//!
//! Modules stand in layers; code may use its own layer and those below it. A file belongs to the layer of the longest prefix of its
//! module path in [`LAYERS`], and so does what a path names.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// From the bottom up. Siblings in one row must not use each other.
const LAYERS: &[&[&str]] = &[
    &["color", "spectrum", "writing"],
    &["optics", "geometry"],
    &["scatter"],
    &["scene"],
    &["formats"],
    &["rectify"],
    &["tracking"],
    &["transport"],
    &["render"],
    &["check", "measure"],
    &["session", "export"],
    &["report"],
    &["cli", "app"],
];

/// Crates that only some modules may know.
const CRATES: &[(&[&str], &[&str])] = &[
    (
        &["egui", "eframe", "egui_wgpu", "egui_extras", "egui_plot", "egui_kittest", "winit", "rfd", "transform_gizmo"],
        &["app"],
    ),
    (&["wgpu", "naga"], &["app", "render::gpu"]),
    (&["obvhs"], &["geometry"]),
    (&["clap", "indicatif", "env_logger"], &["cli"]),
    (&["anyhow"], &["cli", "app"]),
    (&["toml_edit", "tobj", "ply_rs_bw", "gltf"], &["formats"]),
    (&["ab_glyph", "epaint_default_fonts"], &["export", "app"]),
    (&["png"], &["export", "app", "formats::image"]),
    (&["sha2"], &["scene::fingerprint"]),
    (&["exr"], &["export", "formats::image"]),
    (&["signal_hook"], &["writing"]),
    (&["statrs"], &["measure", "scatter::tests"]),
    (&["maud"], &["report"]),
];

#[test]
fn nothing_points_up() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    collect(&root, &mut files);
    assert!(files.len() > 40, "only {} files found", files.len());
    let mut problems = Vec::new();
    for file in files {
        let module = module_of(file.strip_prefix(&root).unwrap());
        problems.extend(violations(&module, &fs::read_to_string(&file).unwrap()));
    }
    assert!(problems.is_empty(), "forbidden edges:\n{}", problems.join("\n"));
}

#[test]
fn every_module_has_its_layer() {
    let library = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    for module in library.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')) {
        assert!(LAYERS.iter().any(|row| row.contains(&module)), "`{module}` is in no layer");
    }
}

/// Mode `reference` judges rectification and the analysis of meshes, so it must share none of their code.
#[test]
fn the_reference_shares_nothing_with_what_it_judges() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/tracking/reference");
    let mut files = Vec::new();
    collect(&root, &mut files);
    assert!(files.len() > 4, "only {} files found", files.len());
    for file in files {
        let shared = shared_names(&fs::read_to_string(&file).unwrap());
        assert!(shared.is_empty(), "{}: {shared:?}", file.display());
    }
    assert_eq!(shared_names("use crate::rectify::containment::top;"), ["rectify"]);
    assert_eq!(shared_names("fn f(o: &Object) { o.enclosure; o.volume } // o.winding"), ["enclosure"]);
}

/// The names in a file's code that belong to rectification, or to what is known of a mesh by its analysis.
fn shared_names(source: &str) -> Vec<&'static str> {
    const NAMES: &[&str] =
        &["rectify", "topology", "Topology", "Enclosure", "enclosure", "WindingTree", "holed", "has_sheets"];
    let code = code_only(source);
    let words: BTreeSet<&str> = code.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
    NAMES.iter().copied().filter(|name| words.contains(name)).collect()
}

/// The twin with planted errors: each must be found, and nothing else.
#[test]
fn planted_violations_are_found() {
    let found = |module: &str, source: &str| violations(module, source);
    let bad = [
        ("optics::fresnel", "use crate::scene::Scene;"),
        ("geometry::bvh", "use crate::optics::Medium;"),
        ("geometry", "fn f(x: &crate::scene::Description) {}"),
        ("scene::camera", "use crate::formats::open;"),
        ("formats::toml", "use crate::{optics, render::Film};"),
        ("formats::toml", "use crate::{\n    geometry::{Mesh, Ray},\n    rectify::{self, InterfaceTable},\n};"),
        ("tracking::stack", "use super::super::render::Film;"),
        ("render::film", "use super::super::export;"),
        ("render::cpu", "use crate::session::Worker;"),
        ("cli::render", "use crate::app::run;"),
        ("app::panels", "use crate::cli;"),
        ("app", "pub fn f() { crate::cli::main(); }"),
        ("main", "fn f() { egui::Context::default(); }"),
        ("session", "use egui::Context;"),
        ("export", "use wgpu::Device;"),
        ("render::cpu", "use wgpu as gpu;"),
        ("app::viewport", "use obvhs::Bvh;"),
        ("scene", "/* a comment */ use ::obvhs::bvh2;"),
        ("measure", "use anyhow::Result;"),
        ("transport::path", "#[cfg(test)] mod tests { use crate::render::film::Film; }"),
    ];
    for (module, source) in bad {
        assert!(!found(module, source).is_empty(), "not found in {module}: {source}");
    }
    let good = [
        ("scene::scene", "use crate::{geometry::Geometry, optics::{self, Medium}};"),
        ("tracking::stack", "use crate::tracking::Events; use super::Mode;"),
        ("session", "use crate::check::check; use super::cpu::accumulate;"),
        ("app::viewport", "use egui::Context; use wgpu::Device; use crate::session::Worker;"),
        ("render::gpu::context", "use wgpu::Device;"),
        ("geometry::bvh", "use obvhs::Bvh; // and crate::app is only mentioned"),
        (
            "optics",
            "/// [`crate::app`] and \n /* crate::cli /* egui::X */ */ const S: &str = \"crate::app::run \\\" egui::Y\";",
        ),
        ("optics", "fn f<'a>(x: &'a str) -> char { '\"' } /* crate::app */"),
        ("optics", "const R: &str = r#\"use \"egui::Z\"; \"#;"),
    ];
    for (module, source) in good {
        assert!(found(module, source).is_empty(), "in {module}: {source}: {:?}", found(module, source));
    }
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// `render/worker/lane.rs` is `session::lane`, `render/mod.rs` is `render`, `lib.rs` and `main.rs` are themselves.
fn module_of(file: &Path) -> String {
    let mut parts: Vec<_> = file.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if parts.last().is_some_and(|last| last == "mod") {
        parts.pop();
    }
    parts.join("::")
}

/// Index of the layer, and the row's member, of the longest prefix of `path`.
fn layer_of(path: &str) -> Option<(usize, &'static str)> {
    let is_prefix = |name: &str| path.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"));
    let all = LAYERS.iter().enumerate().flat_map(|(index, row)| row.iter().map(move |name| (index, *name)));
    all.filter(|(_, name)| is_prefix(name)).max_by_key(|(_, name)| name.len())
}

/// Forbidden edges of one file, each once.
fn violations(module: &str, source: &str) -> BTreeSet<String> {
    let is_binary_or_root = module == "main" || module == "lib";
    let mut problems = BTreeSet::new();
    for path in paths(&code_only(source)) {
        let target = match path[0].as_str() {
            "crate" => path[1..].to_vec(),
            "super" => {
                let mut parent: Vec<String> = module.split("::").map(str::to_owned).collect();
                let ups = path.iter().take_while(|part| *part == "super").count();
                // Inside a nested `mod tests` one `super` is the file itself; the file's own parents are then reached too early,
                // which can only make the check stricter.
                parent.truncate(parent.len().saturating_sub(ups));
                parent.into_iter().chain(path[ups..].iter().cloned()).collect()
            }
            _ => Vec::new(),
        };
        if !target.is_empty() && !is_binary_or_root {
            let target = target.join("::");
            if let (Some((from, from_name)), Some((to, to_name))) = (layer_of(module), layer_of(&target)) {
                // A module may always reach what lies within it: its own `mod` tree.
                let is_own_child = target.starts_with(&format!("{module}::")) && to_name.starts_with(module);
                if (to > from || (to == from && to_name != from_name)) && !is_own_child {
                    problems.insert(format!("{module} uses {target}: {to_name} does not stand below {from_name}"));
                }
            }
        }
        for (crates, modules) in CRATES {
            let allowed = modules.iter().any(|m| module == *m || module.starts_with(&format!("{m}::")));
            if crates.contains(&path[0].as_str()) && !allowed {
                problems.insert(format!(
                    "{module} uses the crate {}, which only {} may know",
                    path[0],
                    modules.join(", ")
                ));
            }
        }
    }
    problems
}

/// The source without comments, strings and character literals.
fn code_only(source: &str) -> String {
    let bytes: Vec<char> = source.chars().collect();
    let at = |i: usize| bytes.get(i).copied().unwrap_or('\0');
    let mut code = String::new();
    let mut i = 0;
    while i < bytes.len() {
        let previous = code.chars().last().unwrap_or(' ');
        let starts_word = !(previous.is_alphanumeric() || previous == '_');
        if at(i) == '/' && at(i + 1) == '/' {
            while i < bytes.len() && at(i) != '\n' {
                i += 1;
            }
        } else if at(i) == '/' && at(i + 1) == '*' {
            let mut depth = 0;
            loop {
                match (at(i), at(i + 1)) {
                    ('/', '*') => (depth, i) = (depth + 1, i + 2),
                    ('*', '/') => (depth, i) = (depth - 1, i + 2),
                    _ => i += 1,
                }
                if depth == 0 || i >= bytes.len() {
                    break;
                }
            }
        } else if starts_word && at(i) == 'r' && (at(i + 1) == '"' || (at(i + 1) == '#' && "#\"".contains(at(i + 2)))) {
            let hashes = (i + 1..).take_while(|&k| at(k) == '#').count();
            let end: Vec<char> = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
            i += hashes + 2;
            while i < bytes.len() && !bytes[i..].starts_with(&end) {
                i += 1;
            }
            i += end.len();
        } else if at(i) == '"' {
            i += 1;
            while i < bytes.len() && at(i) != '"' {
                i += if at(i) == '\\' { 2 } else { 1 };
            }
            i += 1;
            code.push(' ');
        } else if at(i) == '\'' && (at(i + 1) == '\\' || at(i + 2) == '\'') {
            i += if at(i + 1) == '\\' { 3 } else { 2 };
            while i < bytes.len() && at(i) != '\'' {
                i += 1;
            }
            i += 1;
        } else {
            code.push(at(i));
            i += 1;
        }
    }
    code
}

/// Every path of at least two segments, and every path of a `use`, with groups in braces written out.
fn paths(code: &str) -> Vec<Vec<String>> {
    let tokens = tokens(code);
    let mut found = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        let is_use = i > 0 && tokens[i - 1] == "use";
        if is_name(&tokens[i]) && tokens[i] != "use" {
            let before = found.len();
            i = path_at(&tokens, i, &[], &mut found);
            if !is_use {
                let kept: Vec<_> = found.drain(before..).filter(|path: &Vec<String>| path.len() > 1).collect();
                found.extend(kept);
            }
        } else {
            i += 1;
        }
        // `use ::krate::…` starts with the separator.
        if i + 1 < tokens.len() && tokens[i] == "use" && tokens[i + 1] == "::" {
            i += 2;
        }
    }
    found
}

/// Reads a path that starts at token `i`, behind `prefix`; returns where it ends.
fn path_at(tokens: &[String], mut i: usize, prefix: &[String], found: &mut Vec<Vec<String>>) -> usize {
    let mut path = prefix.to_vec();
    let get = |i: usize| tokens.get(i).map_or("", String::as_str);
    path.push(get(i).to_owned());
    i += 1;
    while get(i) == "::" {
        if is_name(get(i + 1)) {
            path.push(get(i + 1).to_owned());
            i += 2;
        } else if get(i + 1) == "{" {
            i += 2;
            while i < tokens.len() && get(i) != "}" {
                if is_name(get(i)) && get(i - 1) != "as" && get(i) != "as" {
                    i = path_at(tokens, i, &path, found);
                } else {
                    i += 1;
                }
            }
            return i + 1;
        } else {
            break;
        }
    }
    found.push(path);
    i
}

fn is_name(token: &str) -> bool {
    token.chars().next().is_some_and(|c| c.is_alphabetic() || c == '_')
}

fn tokens(code: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut characters = code.chars().peekable();
    while let Some(c) = characters.next() {
        if c.is_alphanumeric() || c == '_' {
            let mut name = String::from(c);
            while let Some(next) = characters.next_if(|c| c.is_alphanumeric() || *c == '_') {
                name.push(next);
            }
            tokens.push(name);
        } else if c == ':' && characters.peek() == Some(&':') {
            characters.next();
            tokens.push("::".into());
        } else if !c.is_whitespace() {
            tokens.push(c.into());
        }
    }
    tokens
}
