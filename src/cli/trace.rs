//! `iorect trace`: one path, vertex by vertex.

use std::process::ExitCode;
use std::sync::Arc;

use glam::{DVec2, DVec3, UVec2};

use super::arguments::{Size, TraceArguments};
use super::preparation::prepare_shown;
use super::table::Table;
use super::{Failure, print, print_json};
use crate::export::escape::{elided, short_name};
use crate::export::words::{brief, events_in_words};
use crate::geometry::Ray;
use crate::scene::ObjectId;
use crate::scene::camera::Camera;
use crate::tracking::Prepared;
use crate::transport::inspect::{PathStart, TracedPath, VertexEvent, trace};
use crate::transport::parting::{Compared, compare};

/// Characters of a line about a parting, in which names of any length stand.
const MOST_OF_LINE: usize = 400;

pub fn run(arguments: &TraceArguments) -> Result<ExitCode, Failure> {
    let description = Arc::new(crate::formats::open(&arguments.scene.scene)?);
    let camera = Camera::new(&description.camera)?;
    let ray = if arguments.from_light.is_none() { Some(first_ray(arguments, &camera)?) } else { None };
    let prepared = prepare_shown(Arc::clone(&description))?;
    let start = match (ray, &arguments.from_light) {
        (Some(ray), _) => PathStart::Ray(ray),
        (None, name) => PathStart::Light(light(&prepared, name.as_deref().unwrap_or_default())?),
    };
    let TraceArguments { mode, follow, seed, max_depth, .. } = *arguments;
    if let Some(against) = arguments.against {
        let compared = compare(&prepared, [mode, against], start, follow, seed, max_depth.0);
        if arguments.scene.json {
            print_json(&compared)?;
        } else {
            let [path, other] = [&compared.path, &compared.against].map(|path| summary(&description.name, path));
            print(&format!("{path}\n{other}\n{}", parting_in_words(&compared)))?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let path = trace(&prepared, mode, start, follow, seed, max_depth.0);
    if arguments.scene.json {
        print_json(&path)?;
    } else {
        print(&summary(&description.name, &path))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The light of that name.
fn light(prepared: &Prepared, name: &str) -> Result<ObjectId, Failure> {
    let scene = &prepared.scene;
    let lights =
        || scene.emitters.iter().filter_map(|(light, _)| light.object()).map(|id| (id, &scene.object(id).name));
    let found = lights().find(|(_, other)| *other == name);
    found.map(|(id, _)| id).ok_or_else(|| {
        let names: Vec<String> = lights().map(|(_, name)| short_name(name)).collect();
        let valid = if names.is_empty() { "the scene has none that emits".to_owned() } else { names.join(", ") };
        Failure::wrong(format!("there is no light `{}`; valid: {valid}", short_name(name)))
    })
}

fn first_ray(arguments: &TraceArguments, camera: &Camera) -> Result<Ray, Failure> {
    if let (Some(origin), Some(direction)) = (arguments.origin, arguments.direction) {
        return Ok(Ray::new(origin, direction));
    }
    let Some([x, y]) = arguments.pixel else {
        return Err(Failure::wrong(
            "which path? give --pixel X,Y, or --from-light NAME, or --origin X,Y,Z with --direction X,Y,Z",
        ));
    };
    let Size { width, height } = arguments.size;
    if x >= width || y >= height {
        let range = format!("columns go from 0 to {}, rows from 0 to {}", width - 1, height - 1);
        return Err(Failure::wrong(format!("pixel {x},{y} is outside the image of {width}×{height}; {range}")));
    }
    Ok(camera.ray(UVec2::new(x, y).as_dvec2() + 0.5, UVec2::new(width, height).as_dvec2(), DVec2::ZERO))
}

fn summary(scene: &str, path: &TracedPath) -> String {
    let from = path.light.as_ref().map_or_else(String::new, |light| format!("from {} · ", short_name(light)));
    let start = short_name(&path.camera_medium);
    let mut text = format!("{} · {} · {from}starts in {start}\n\n", short_name(scene), path.mode);
    let mut table = Table::new(">#,event,surface,from,,to,>Fresnel R,>x,>y,>z,");
    for (index, vertex) in path.vertices.iter().enumerate() {
        let (from, to) = (medium(&vertex.from, vertex.ior_from), medium(&vertex.to, vertex.ior_to));
        let arrow = if vertex.to.is_some() { "→" } else { "" };
        let [x, y, z] = vertex.position.map(|c| format!("{c:.4}"));
        table.row([
            (index + 1).to_string(),
            event_in_words(vertex.event).to_owned(),
            vertex.refractor.clone().or(vertex.solid.clone()).unwrap_or_default(),
            from,
            arrow.to_owned(),
            to,
            vertex.fresnel.map_or(String::new(), brief),
            x,
            y,
            z,
            if vertex.is_consistent { "" } else { "inconsistent: the path is in another medium" }.to_owned(),
        ]);
    }
    if path.vertices.is_empty() {
        text += "  the path meets nothing\n";
    } else {
        text += &table.render();
    }
    let DVec3 { x, y, z } = DVec3::from(path.final_direction);
    let end = if path.escaped { "leaves the scene along" } else { "ends; its last direction is" };
    text += &format!("\n  {end} ({x:.6}, {y:.6}, {z:.6})\n");
    text += &format!("  {}\n", events_in_words(&path.events));
    text
}

fn parting_in_words(compared: &Compared) -> String {
    let Compared { path, against, parting } = compared;
    let Some(parting) = parting else {
        return format!("{} and {} agree about this path.\n", path.mode, against.mode);
    };
    let (number, refractor) = (parting.vertex + 1, short_name(&parting.refractor));
    let heading = format!("{} and {} part at surface {number}, {refractor}:", path.mode, against.mode);
    let [a, b] = &parting.claims;
    let claims = [format!("{}: {a}", a.mode), format!("{}: {b}", b.mode), format!("truth: {}", parting.truth)];
    let faults = parting.faults.iter().flatten().flat_map(|fault| [fault.what(), fault.why()]);
    let lines = claims.into_iter().chain(faults);
    lines.fold(heading + "\n", |text, line| text + "  " + &elided(&line, MOST_OF_LINE) + "\n")
}

fn medium(name: &Option<String>, ior: Option<f64>) -> String {
    match (name, ior) {
        (Some(name), Some(ior)) => format!("{name} {ior:.4}"),
        (Some(name), None) => name.clone(),
        _ => String::new(),
    }
}

fn event_in_words(event: VertexEvent) -> &'static str {
    match event {
        VertexEvent::Transmit => "transmit",
        VertexEvent::Reflect => "reflect",
        VertexEvent::TotalReflection => "total reflection",
        VertexEvent::Skip => "skip",
        VertexEvent::Scatter => "scatter",
        VertexEvent::Emit => "emit",
    }
}
