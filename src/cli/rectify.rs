//! `iorect rectify`: the interface table.

use std::process::ExitCode;
use std::sync::Arc;

use serde::Serialize;

use super::arguments::{Granularity, RectifyArguments};
use super::table::{Align, Table, wrapped};
use super::{Failure, plural, print, print_json};
use crate::check::{Severity, check};
use crate::export::words::{brief, duration, grouped};
use crate::rectify::Patch;
use crate::rectify::table::RectifySeconds;
use crate::render::{Prepared, prepare};
use crate::scene;

#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    granularity: Granularity,
    seconds: RectifySeconds,
    patches: Vec<PatchReport<'a>>,
    warnings: Vec<Warning>,
}

#[derive(Serialize)]
struct PatchReport<'a> {
    refractor: &'a str,
    patch: u32,
    faces: u32,
    area: f64,
    kind: &'static str,
    outside: Option<&'a str>,
    inside: Option<&'a str>,
    outside_refractor: Option<&'a str>,
    inside_refractor: Option<&'a str>,
    rays: u32,
    confidence: f64,
}

#[derive(Serialize)]
struct Warning {
    /// One, or several with commas where they overlap.
    refractor: String,
    kind: &'static str,
    message: String,
}

pub fn run(arguments: &RectifyArguments) -> Result<ExitCode, Failure> {
    let prepared = prepare(Arc::new(scene::load::open(&arguments.scene.scene)?), None)?;
    let report = Report {
        scene: &arguments.scene.scene,
        granularity: arguments.granularity,
        seconds: prepared.table.seconds,
        patches: prepared.table.patches.iter().map(|patch| patch_report(&prepared, patch)).collect(),
        warnings: warnings(&prepared),
    };
    if arguments.scene.json {
        print_json(&report)?;
    } else {
        print(&summary(&prepared, &report))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn patch_report<'a>(prepared: &'a Prepared, patch: &Patch) -> PatchReport<'a> {
    let world = &prepared.world;
    let refractor = world.object(patch.refractor).name.as_str();
    PatchReport {
        refractor,
        patch: patch.index,
        faces: patch.faces,
        area: patch.area,
        // By identity: two media of equal IOR may absorb differently.
        kind: if patch.outside == patch.inside { "null" } else { "clear" },
        outside: Some(&world.medium(patch.outside).name),
        inside: Some(&world.medium(patch.inside).name),
        outside_refractor: patch.outside_refractor.map(|id| world.object(id).name.as_str()),
        inside_refractor: Some(refractor),
        rays: patch.rays,
        confidence: patch.confidence,
    }
}

/// What `check` warns of about refractors.
fn warnings(prepared: &Prepared) -> Vec<Warning> {
    let is_refractor = |name: &str| prepared.description.refractors.iter().any(|r| r.name == name);
    (check(prepared).into_iter())
        .filter(|problem| problem.severity != Severity::Advice && problem.place.split(", ").all(is_refractor))
        .map(|problem| Warning { refractor: problem.place, kind: problem.kind, message: problem.message })
        .collect()
}

fn summary(prepared: &Prepared, report: &Report<'_>) -> String {
    let world = &prepared.world;
    let mut table = Table::new(&[
        ("refractor", Align::Left),
        ("outside", Align::Left),
        ("found in", Align::Left),
        ("inside", Align::Left),
        ("faces", Align::Right),
        ("area", Align::Right),
        ("rays", Align::Right),
        ("confidence", Align::Right),
    ]);
    for (patch, row) in prepared.table.patches.iter().zip(&report.patches) {
        let medium = |id| {
            let medium = world.medium(id);
            format!("{} {:.4}", medium.name, medium.ior())
        };
        table.row([
            row.refractor.to_owned(),
            medium(patch.outside),
            row.outside_refractor.unwrap_or("—").to_owned(),
            medium(patch.inside),
            grouped(row.faces.into()),
            brief(row.area),
            grouped(row.rays.into()),
            format!("{:.1} %", 100.0 * row.confidence),
        ]);
    }
    let rays: u64 = report.patches.iter().map(|patch| u64::from(patch.rays)).sum();
    let unit = match report.granularity {
        Granularity::Patch => "patch",
        Granularity::Object => "object",
    };
    let mut text = format!("{} · one answer per {unit}\n\n", prepared.description.name);
    text += &table.render();
    let seconds = report.seconds;
    text += &format!(
        "\n  {} refractor{}, {} rays, {} (topology {} · pre-trace {} · resolve {})\n",
        report.patches.len(),
        plural(report.patches.len()),
        grouped(rays),
        duration(seconds.total()),
        duration(seconds.topology),
        duration(seconds.pretrace),
        duration(seconds.resolve)
    );
    if !report.warnings.is_empty() {
        text.push('\n');
    }
    for warning in &report.warnings {
        text += &wrapped(&format!("  warning  {}:", warning.refractor), &warning.message, 11);
    }
    text
}
