//! The path of a pixel, vertex by vertex, in the active pane's mode.

use egui::{EventFilter, Id, Key, Label, Response, RichText, Sense, Ui};

use crate::app::command::{Command, ExportKind};
use crate::app::state::{PathOption, State};
use crate::app::theme::{DOT, Palette, WARNING_MARK, opaque};
use crate::app::widgets::{
    button_ui, combo_ui, fact_ui, note, row_ui, section_first_ui, section_ui, segmented_row_ui, value,
};
use crate::render::surfaces::medium_color;
use crate::tracking::Mode;
use crate::transport::inspect::{Follow, TracedPath, Vertex, VertexEvent};

/// Vertices that are shown; a trapped path has many alike.
const MOST_SHOWN: usize = 120;

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let Some(inspection) = &state.inspection else {
        let text = "Click a picture: the path through that pixel is drawn there and listed here, surface by surface.";
        ui.label(note(ui, text));
        return;
    };
    let palette = Palette::of(ui);
    let mode = state.inspected_mode();
    let [width, height] = state.film_size();
    let at = |x: f64, side: u32| ((x * f64::from(side)) as u32).min(side.saturating_sub(1));
    let pixel = format!("{}, {}", at(inspection.point[0], width), at(inspection.point[1], height));
    match &state.path_light {
        Some(light) => section_first_ui(ui, "Path of light", light),
        None => section_first_ui(ui, "Path of a pixel", &pixel),
    }
    row_ui(ui, "Mode", "The mode of the active pane: click another pane to see its path.", |ui| {
        ui.label(RichText::new(format!("{DOT} {}", mode.name())).color(palette.mode(mode)));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            button_ui(ui, "Close", "Puts the path away (Esc).", commands, Command::Inspect(None));
        });
    });
    options_ui(ui, state, commands);
    match inspection.path(mode) {
        Some(path) => {
            parting_ui(ui, state, path, commands);
            path_ui(ui, state, path, commands);
            row_ui(ui, "Export", "The paths over the active pane, as files.", |ui| {
                let about = "A vector drawing of the paths, with a legend of the media.";
                button_ui(ui, "SVG…", about, commands, Command::AskExport(ExportKind::PathSvg));
                let about = "Every vertex of both paths, and where they part.";
                button_ui(ui, "JSON…", about, commands, Command::AskExport(ExportKind::PathJson));
            });
        }
        None => {
            ui.label(note(ui, "…"));
        }
    }
}

/// How the path is followed and shown.
fn options_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let options = state.path_options;
    let lights = state.path_lights();
    if !lights.is_empty() {
        let shown = state.path_light.as_deref().filter(|name| lights.iter().any(|light| light == name));
        let about = "Whose path it is: the marked pixel's, or that of light which leaves a light, in a direction taken by chance.";
        row_ui(ui, "From", about, |ui| {
            combo_ui(ui, "path from", shown.unwrap_or("the pixel"), |ui| {
                for light in [None].into_iter().chain(lights.iter().map(Some)) {
                    let name = light.map_or("the pixel", String::as_str);
                    if ui.selectable_label(shown == light.map(String::as_str), name).clicked() {
                        commands.push(Command::SetPathLight(light.cloned()));
                    }
                }
            });
        });
    }
    let follows = [
        (Follow::Transmit, "Through", "Through every interface, except where reflection is total."),
        (Follow::Reflect, "Back", "Reflected at every interface."),
        (Follow::Sample, "Chance", "By chance, as the renderer does."),
    ];
    let about = "Which way the path goes at interfaces.";
    commands.extend(segmented_row_ui(ui, "Follow", about, options.follow, &follows).map(Command::SetFollow));
    let rays = [
        (false, "One", "The ray through the middle of the pixel and of the lens."),
        (true, "Bundle", "32 rays more, spread over the pixel and the lens; by chance, each has its own."),
    ];
    let about = "How many rays are followed.";
    let chosen = segmented_row_ui(ui, "Rays", about, options.has_bundle, &rays);
    commands.extend(chosen.map(|is_on| Command::SetPathOption(PathOption::Bundle(is_on))));
    if options.follow == Follow::Sample || state.path_light.is_some() {
        row_ui(ui, "", "", |ui| {
            let about = "Other random numbers: another way that light may take.";
            button_ui(ui, "Next sample", about, commands, Command::SetPathOption(PathOption::NextSample));
        });
    }
    let about = "Another mode, whose path is drawn dashed; where the two part is marked with a ring.";
    row_ui(ui, "Against", about, |ui| {
        combo_ui(ui, "against", options.against.map_or("none", Mode::name), |ui| {
            for against in [None].into_iter().chain(Mode::ALL.map(Some)) {
                let response = ui.selectable_label(options.against == against, against.map_or("none", Mode::name));
                let response = against.map_or(response.clone(), |mode| response.on_hover_text(mode.about()));
                if response.clicked() {
                    commands.push(Command::SetPathOption(PathOption::Against(against)));
                }
            }
        });
    });
    let toggles = [
        (
            options.keeps_ray,
            "Keep this ray",
            "The path stays where it is while the camera moves; otherwise it is always that of the marked pixel.",
            PathOption::KeepRay(!options.keeps_ray),
        ),
        (
            options.is_ghost,
            "Ghost view",
            "Shows everything but the path faintly. Drag the picture to look at the path from anywhere.",
            PathOption::Ghost(!options.is_ghost),
        ),
    ];
    ui.horizontal_wrapped(|ui| {
        for (is_on, name, about, option) in toggles {
            if ui.checkbox(&mut is_on.clone(), name).on_hover_text(about).clicked() {
                commands.push(Command::SetPathOption(option));
            }
        }
    });
}

/// Where two modes part, and why.
fn parting_ui(ui: &mut Ui, state: &State, path: &TracedPath, commands: &mut Vec<Command>) {
    let palette = Palette::of(ui);
    let traced = state.inspection.as_ref().and_then(|inspection| inspection.traced.as_ref());
    let (Some(pair), Some(traced)) = (state.compared_modes(), traced) else { return };
    if traced.question.pair != Some(pair) {
        return;
    }
    let [a, b] = pair.map(Mode::name);
    let Some(parting) = &traced.parting else {
        ui.add(Label::new(note(ui, format!("{a} and {b} agree about this path."))).wrap());
        return;
    };
    section_ui(ui, "Where they part", &format!("surface {}", parting.vertex + 1));
    for fault in parting.faults.iter().flatten() {
        ui.add(Label::new(RichText::new(fault.what()).color(palette.warning)).wrap());
        ui.add(Label::new(RichText::new(fault.why())).wrap());
    }
    if parting.faults.iter().all(Option::is_none) {
        ui.add(Label::new(parting.sentence()).wrap());
    }
    if parting.vertex < path.vertices.len() {
        let about = "Points out the surface in the picture and in the list.";
        button_ui(ui, "Show it", about, commands, Command::SelectVertex(Some(parting.vertex)));
    }
}

fn path_ui(ui: &mut Ui, state: &State, path: &TracedPath, commands: &mut Vec<Command>) {
    let faults = faults(path);
    let palette = Palette::of(ui);
    let count = faults.iter().flatten().count();
    section_ui(ui, "Surfaces", &path.vertices.len().to_string());
    if count > 0 {
        let times = if count == 1 { "once".to_owned() } else { format!("{count} times") };
        let text = format!("{WARNING_MARK} The path leaves another medium than the one it was in, {times}.");
        ui.add(Label::new(RichText::new(text).small().color(palette.warning)).wrap())
            .on_hover_text("The mode is wrong there, or at the surface before.");
    }
    fact_ui(ui, "Starts in", path.camera_medium.clone(), "The medium that contains the camera.");
    let selected = state.inspection.as_ref().and_then(|inspection| inspection.vertex);
    let count = path.vertices.len().min(MOST_SHOWN);
    let list = ui.scope_id();
    for (index, vertex) in path.vertices.iter().take(count).enumerate() {
        let response = vertex_ui(ui, list, index, vertex, faults[index].as_deref(), selected == Some(index), commands);
        if response.has_focus() {
            step_with_arrows(ui, list, index, count, commands);
        }
    }
    if path.vertices.len() > MOST_SHOWN {
        ui.label(note(ui, format!("… and {} more", path.vertices.len() - MOST_SHOWN)));
    }
    let [x, y, z] = path.final_direction;
    let end = if path.escaped { "escapes to the environment" } else { "ends" };
    fact_ui(ui, "Then", end, "");
    fact_ui(ui, "Direction", format!("{x:.4} {y:.4} {z:.4}"), "Of the last segment.");
    let most = state.settings.max_depth.unwrap_or(crate::app::paths::tracer::MOST_SEGMENTS);
    if !path.escaped && path.vertices.len() as u32 >= most {
        ui.label(note(ui, "The path was not followed further."));
    }
}

/// For each vertex the medium that the path was in, where that is not the one which the vertex says is left.
fn faults(path: &TracedPath) -> Vec<Option<String>> {
    let mut register = path.camera_medium.clone();
    (path.vertices.iter())
        .map(|vertex| {
            let (Some(from), Some(to)) = (&vertex.from, &vertex.to) else { return None };
            let fault = (!vertex.is_consistent).then(|| register.clone());
            match vertex.event {
                VertexEvent::Transmit => register.clone_from(to),
                VertexEvent::Reflect | VertexEvent::TotalReflection => register.clone_from(from),
                VertexEvent::Skip | VertexEvent::Scatter | VertexEvent::Emit => {}
            }
            fault
        })
        .collect()
}

/// The widget of a surface of the list.
fn id_of(list: Id, index: usize) -> Id {
    list.with(("vertex", index))
}

/// Moves the focus, which is on surface `index`, to the next one or the one before, and points that out.
fn step_with_arrows(ui: &Ui, list: Id, index: usize, count: usize, commands: &mut Vec<Command>) {
    let filter = EventFilter { vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(id_of(list, index), filter));
    let [up, down] =
        [Key::ArrowUp, Key::ArrowDown].map(|key| ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, key)));
    let next = match (up, down) {
        (true, false) => index.checked_sub(1),
        (false, true) => Some(index + 1).filter(|next| *next < count),
        _ => None,
    };
    if let Some(next) = next {
        ui.memory_mut(|memory| memory.request_focus(id_of(list, next)));
        commands.push(Command::SelectVertex(Some(next)));
    }
}

/// One surface of the list. It has the focus like a button, and where it gets it, it is pointed out in the picture.
fn vertex_ui(
    ui: &mut Ui,
    list: Id,
    index: usize,
    vertex: &Vertex,
    was_in: Option<&str>,
    is_selected: bool,
    commands: &mut Vec<Command>,
) -> Response {
    let palette = Palette::of(ui);
    let fill = if is_selected { ui.visuals().selection.bg_fill } else { ui.visuals().faint_bg_color };
    let stroke = was_in.map_or(egui::Stroke::NONE, |_| egui::Stroke::new(1.0, palette.warning));
    let frame =
        egui::Frame::new().fill(fill).stroke(stroke).corner_radius(4).inner_margin(egui::Margin::symmetric(8, 4));
    let name = vertex.refractor.as_deref().or(vertex.solid.as_deref()).unwrap_or("?");
    let response = frame
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            ui.horizontal(|ui| {
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(RichText::new(event_text(vertex.event)).small().color(palette.weak_text));
                    ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                        ui.label(value(format!("{:>2}", index + 1)).color(palette.weak_text));
                        ui.add(Label::new(RichText::new(name).strong()).truncate());
                    });
                });
            });
            sides_ui(ui, vertex);
            if let Some(text) = numbers_of(vertex) {
                ui.label(value(text).color(palette.weak_text));
            }
            if let Some(was_in) = was_in {
                let text = format!("{WARNING_MARK} the path was in {was_in}");
                ui.label(RichText::new(text).small().color(palette.warning));
            }
            ui.set_width(ui.available_width());
        })
        .response;
    let response = ui.interact(response.rect, id_of(list, index), Sense::click());
    if response.has_focus() {
        let ring = egui::Stroke::new(1.0, palette.accent);
        ui.painter().rect_stroke(response.rect, 4.0, ring, egui::StrokeKind::Inside);
    }
    let label = format!("Surface {}: {name}, {}", index + 1, event_text(vertex.event));
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, is_selected, &label));
    if response.clicked() {
        commands.push(Command::SelectVertex((!is_selected).then_some(index)));
    } else if response.gained_focus() {
        response.scroll_to_me(None);
        commands.push(Command::SelectVertex(Some(index)));
    }
    response.on_hover_text(details_of(vertex))
}

/// The media on both sides, with their colours.
fn sides_ui(ui: &mut Ui, vertex: &Vertex) {
    let (Some(from), Some(to), Some(sides)) = (&vertex.from, &vertex.to, vertex.ids.sides) else { return };
    let font = crate::app::theme::small_mono_style().resolve(ui.style());
    let mut job = egui::text::LayoutJob::default();
    let text = egui::TextFormat::simple(font.clone(), ui.visuals().text_color());
    let dot = |color: [u8; 3]| egui::TextFormat::simple(font.clone(), opaque(color));
    for (name, ior, id, gap) in [(from, vertex.ior_from, sides.from, ""), (to, vertex.ior_to, sides.to, " → ")] {
        job.append(gap, 0.0, text.clone());
        job.append(DOT, 0.0, dot(medium_color(id)));
        let ior = ior.map_or(String::new(), |ior| format!(" {ior:.4}"));
        job.append(&format!("{name}{ior}"), 4.0, text.clone());
    }
    ui.add(Label::new(job).truncate());
}

/// Reflectance, angles, and the share of the light that goes on.
fn numbers_of(vertex: &Vertex) -> Option<String> {
    let fresnel = vertex.fresnel?;
    if vertex.event == VertexEvent::Skip {
        return None;
    }
    let angles = match (vertex.angle_in, vertex.angle_out) {
        (Some(before), Some(behind)) => format!("  {before:.1}° → {behind:.1}°"),
        _ => String::new(),
    };
    let share = vertex.throughput.iter().sum::<f64>() / 3.0;
    Some(format!("R {fresnel:.4}{angles}  {} left", percent(share)))
}

/// "96 %", "0.4 %".
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 9.95 || percent == 0.0 { format!("{percent:.0} %") } else { format!("{percent:.2} %") }
}

fn details_of(vertex: &Vertex) -> String {
    let [x, y, z] = vertex.position;
    let [nx, ny, nz] = vertex.normal;
    let let_through = vertex.transmittance.map(percent).join(", ");
    format!(
        "At {x:.5}, {y:.5}, {z:.5}; normal {nx:.4}, {ny:.4}, {nz:.4}.\n\
         Before: {:.4} units of {}, which let through {let_through} (red, green, blue).\n\
         R: Fresnel's reflectance, unpolarised. Left: share of the light of the whole path that goes on from here.",
        vertex.distance, vertex.medium
    )
}

fn event_text(event: VertexEvent) -> &'static str {
    match event {
        VertexEvent::Transmit => "transmitted",
        VertexEvent::Reflect => "reflected",
        VertexEvent::TotalReflection => "total reflection",
        VertexEvent::Skip => "skipped",
        VertexEvent::Scatter => "scattered",
        VertexEvent::Emit => "light",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MediumId;
    use crate::tracking::Events;
    use crate::transport::inspect::VertexIds;

    fn vertex(from: &str, to: &str, event: VertexEvent, is_consistent: bool) -> Vertex {
        Vertex {
            position: [0.0; 3],
            refractor: Some("ball".into()),
            patch: Some(0),
            solid: None,
            from: Some(from.into()),
            to: Some(to.into()),
            ior_from: Some(1.0),
            ior_to: Some(1.5),
            fresnel: Some(0.04),
            event,
            medium: String::new(),
            distance: 1.0,
            transmittance: [1.0; 3],
            normal: [0.0, 0.0, 1.0],
            angle_in: Some(30.0),
            angle_out: Some(19.5),
            throughput: [0.96; 3],
            ids: VertexIds::default(),
            is_consistent,
        }
    }

    #[test]
    fn a_medium_that_was_never_entered_is_a_fault() {
        let path = TracedPath {
            light: None,
            mode: Mode::Stack,
            origin: [0.0; 3],
            camera_medium: "water".into(),
            vertices: vec![
                vertex("world", "glass", VertexEvent::Transmit, false),
                vertex("glass", "world", VertexEvent::TotalReflection, true),
                vertex("glass", "world", VertexEvent::Transmit, true),
                vertex("water", "world", VertexEvent::Transmit, false),
            ],
            escaped: true,
            final_direction: [0.0, 0.0, 1.0],
            final_medium: "world".into(),
            final_medium_id: MediumId::WORLD,
            events: Events::default(),
        };
        assert_eq!(faults(&path), [Some("water".to_owned()), None, None, Some("world".to_owned())]);
    }
}
