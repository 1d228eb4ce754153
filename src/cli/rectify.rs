//! `iorect rectify`: the interface table.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;

use super::arguments::{Granularity, RectifyArguments};
use super::preparation::prepare_shown;
use super::table::{Table, wrapped};
use super::{Failure, plural, print, print_json};
use crate::check::{Severity, check};
use crate::export::escape::short_name;
use crate::export::words::{brief, duration, grouped};
use crate::rectify::containment::medium_of;
use crate::rectify::progress::RectifySeconds;
use crate::rectify::{Patch, PatchKind};
use crate::scene::{MediumId, ObjectId};
use crate::tracking::Prepared;

/// Names that a list shows at the most.
const MOST_LISTED: usize = 8;

#[derive(Serialize)]
struct Report<'a> {
    scene: Cow<'a, str>,
    granularity: Granularity,
    seconds: RectifySeconds,
    patches: Vec<PatchReport<'a>>,
    /// Patches of lights, whose `refractor` is the light.
    lights: Vec<PatchReport<'a>>,
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
    crossed_by: Vec<&'a str>,
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
    let prepared = prepare_shown(Arc::new(crate::formats::open(&arguments.scene.scene)?))?;
    let table = &prepared.table;
    let mut seconds = table.seconds;
    let patches = match arguments.granularity {
        Granularity::Patch => table.patches.clone(),
        Granularity::Object => {
            let start = Instant::now();
            let patches = whole_objects(&prepared);
            seconds = RectifySeconds { pretrace: start.elapsed().as_secs_f64(), ..RectifySeconds::default() };
            patches
        }
    };
    let report = Report {
        scene: arguments.scene.scene.to_string_lossy(),
        granularity: arguments.granularity,
        seconds,
        patches: patches.iter().map(|patch| patch_report(&prepared, patch)).collect(),
        lights: table.lights.iter().map(|patch| patch_report(&prepared, patch)).collect(),
        warnings: warnings(&prepared),
    };
    if arguments.scene.json {
        print_json(&report)?;
    } else {
        print(&summary(&prepared, &report))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The source's answers, one for each object, in the form of patches.
fn whole_objects(prepared: &Prepared) -> Vec<Patch> {
    let scene = &*prepared.scene;
    (prepared.table.object_table(scene).answers.iter())
        .map(|answer| {
            let refractor = answer.refractor;
            let outside = medium_of(scene, answer.outside_refractor());
            let inside = medium_of(scene, Some(refractor));
            Patch {
                refractor,
                index: 0,
                kind: if outside == inside { PatchKind::Null } else { PatchKind::Clear },
                faces: scene.geometry.face_count(refractor.0),
                area: scene.geometry.area(refractor.0),
                outside: Some(outside),
                inside: Some(inside),
                outside_refractor: answer.outside_refractor(),
                inside_refractor: Some(refractor),
                crossed_by: Vec::new(),
                rays: answer.rays(),
                confidence: answer.confidence(),
                votes: Arc::default(),
                within: None,
            }
        })
        .collect()
}

fn patch_report<'a>(prepared: &'a Prepared, patch: &Patch) -> PatchReport<'a> {
    let scene = &prepared.scene;
    let name = |id: ObjectId| scene.object(id).name.as_str();
    let medium = |id: MediumId| scene.medium(id).name.as_str();
    PatchReport {
        refractor: name(patch.refractor),
        patch: patch.index,
        faces: patch.faces,
        area: patch.area,
        kind: patch.kind.name(),
        outside: patch.outside.map(medium),
        inside: patch.inside.map(medium),
        outside_refractor: patch.outside_refractor.map(name),
        inside_refractor: patch.inside_refractor.map(name),
        crossed_by: patch.crossed_by.iter().copied().map(name).collect(),
        rays: patch.rays,
        confidence: patch.confidence,
    }
}

/// What `check` warns of about refractors.
fn warnings(prepared: &Prepared) -> Vec<Warning> {
    let refractors: HashSet<&str> = prepared.description.objects.refractors().iter().map(|r| r.name.as_str()).collect();
    let is_refractor = |name: &str| refractors.contains(name);
    (check(prepared).into_iter())
        .filter(|problem| problem.severity != Severity::Advice && problem.place.split(", ").all(is_refractor))
        .map(|problem| Warning { refractor: problem.place, kind: problem.kind, message: problem.message })
        .collect()
}

/// Names with commas, the first few of many.
fn listed(names: &[&str]) -> String {
    let mut list: Vec<String> = names.iter().take(MOST_LISTED).map(|name| short_name(name)).collect();
    if names.len() > MOST_LISTED {
        list.push(format!("{} more", names.len() - MOST_LISTED));
    }
    list.join(", ")
}

fn summary(prepared: &Prepared, report: &Report<'_>) -> String {
    let scene = &prepared.scene;
    let mut table = Table::new("refractor,>patch,kind,outside,found in,inside,>faces,>area,>rays,>confidence");
    // Of media of one name, the first.
    let iors: HashMap<&str, f64> =
        scene.media.iter().rev().map(|medium| (medium.name.as_str(), medium.ior())).collect();
    let ior_of = |name: &str| iors.get(name).copied().unwrap_or(0.0);
    let medium =
        |name: Option<&str>| name.map_or("—".to_owned(), |name| format!("{} {:.4}", short_name(name), ior_of(name)));
    for row in &report.patches {
        let place = if row.crossed_by.is_empty() {
            row.outside_refractor.unwrap_or("—").to_owned()
        } else {
            format!("crossed by {}", listed(&row.crossed_by))
        };
        table.row([
            row.refractor.to_owned(),
            row.patch.to_string(),
            row.kind.to_owned(),
            medium(row.outside),
            place,
            medium(row.inside),
            grouped(row.faces.into()),
            brief(row.area),
            if row.rays == 0 { "—".to_owned() } else { grouped(row.rays.into()) },
            if row.rays == 0 { "—".to_owned() } else { format!("{:.1} %", 100.0 * row.confidence) },
        ]);
    }
    let rays: u64 = report.patches.iter().map(|patch| u64::from(patch.rays)).sum();
    let unit = match report.granularity {
        Granularity::Patch => "patch of surface",
        Granularity::Object => "object",
    };
    let mut text = format!("{} · one answer per {unit}\n\n", short_name(&prepared.description.name));
    text += &table.render();
    for light in &report.lights {
        let name = short_name(light.refractor);
        text += &match light.outside {
            Some(_) => format!("\n  light {name} shines into {}", medium(light.outside)),
            None if light.faces == 0 => {
                format!("\n  light {name} stands on the surface of {}", listed(&light.crossed_by))
            }
            None => format!("\n  light {name} is crossed by {}", listed(&light.crossed_by)),
        };
    }
    if !report.lights.is_empty() {
        text.push('\n');
    }
    let seconds = report.seconds;
    let times = [seconds.total(), seconds.topology, seconds.patches, seconds.pretrace, seconds.resolve];
    let [total, topology, patching, pretrace, resolve] = times.map(duration);
    let (refractors, patches, rays) = (scene.refractors().count(), report.patches.len(), grouped(rays));
    let (s, es) = (plural(refractors), if patches == 1 { "" } else { "es" });
    text += &format!("\n  {refractors} refractor{s}, {patches} patch{es}, {rays} rays, {total} ");
    text += &format!("(topology {topology} · patches {patching} · pre-trace {pretrace} · resolve {resolve})\n");
    if !report.warnings.is_empty() {
        text.push('\n');
    }
    for warning in &report.warnings {
        text += &wrapped(&format!("  warning  {}:", warning.refractor), &warning.message, 11);
    }
    text
}
