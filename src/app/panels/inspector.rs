//! The path of a pixel, vertex by vertex, in the active pane's mode.

use egui::{Label, RichText, Ui};

use crate::app::command::Command;
use crate::app::state::{Inspection, State};
use crate::app::theme::{DOT, Palette, WARNING_MARK};
use crate::app::widgets::{button_ui, fact_ui, note, row_ui, section_first_ui, section_ui, segmented_row_ui, value};
use crate::transport::inspect::{Follow, TracedPath, Vertex, VertexEvent};

/// Vertices that are shown; a trapped path has many alike.
const MOST_SHOWN: usize = 120;

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let Some(inspection) = &state.inspection else {
        ui.label(note(ui, "Click a picture: the path through that pixel is shown here, interface by interface."));
        return;
    };
    let palette = Palette::of(ui);
    let content = state.settings.panes[state.view.active_pane];
    let mode = content.inspected_mode();
    let [width, height] = state.film_size();
    let at = |x: f64, side: u32| ((x * f64::from(side)) as u32).min(side.saturating_sub(1));
    let pixel = format!("{}, {}", at(inspection.point[0], width), at(inspection.point[1], height));
    section_first_ui(ui, "Path of a pixel", &pixel);
    row_ui(ui, "Mode", "The mode of the active pane: click another pane to see its path.", |ui| {
        ui.label(RichText::new(format!("{DOT} {}", mode.name())).color(palette.mode(mode)));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            button_ui(ui, "Close", "Puts the marker away (Esc).", commands, Command::Inspect(None));
        });
    });
    let follows = [
        (Follow::Transmit, "Through", "Through every interface, except where reflection is total."),
        (Follow::Reflect, "Back", "Reflected at every interface."),
        (Follow::Sample, "Chance", "By chance, as the renderer does."),
    ];
    let about = "Which way the path goes at interfaces.";
    commands.extend(segmented_row_ui(ui, "Follow", about, inspection.follow, &follows).map(Command::SetFollow));
    match &inspection.path {
        Some(path) => path_ui(ui, state, inspection, path),
        None => {
            ui.label(note(ui, "…"));
        }
    }
}

fn path_ui(ui: &mut Ui, state: &State, inspection: &Inspection, path: &TracedPath) {
    let faults = faults(path);
    let palette = Palette::of(ui);
    let count = faults.iter().flatten().count();
    section_ui(ui, "Vertices", &path.vertices.len().to_string());
    if count > 0 {
        let text = format!("{WARNING_MARK} {count} inconsistent: the medium left is not the one that the path was in.");
        ui.add(Label::new(RichText::new(text).small().color(palette.warning)).wrap());
    }
    fact_ui(ui, "Starts in", path.camera_medium.clone(), "The medium that contains the camera.");
    for (index, vertex) in path.vertices.iter().take(MOST_SHOWN).enumerate() {
        vertex_ui(ui, index, vertex, faults[index].as_deref());
    }
    if path.vertices.len() > MOST_SHOWN {
        ui.label(note(ui, format!("… and {} more", path.vertices.len() - MOST_SHOWN)));
    }
    let [x, y, z] = path.final_direction;
    let end = if path.escaped { "escapes to the environment" } else { "ends" };
    fact_ui(ui, "Then", end, "");
    fact_ui(ui, "Direction", format!("{x:.4} {y:.4} {z:.4}"), "Of the last segment.");
    if inspection.follow == Follow::Transmit && path.vertices.len() as u32 >= state.settings.max_depth.unwrap_or(200) {
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

fn vertex_ui(ui: &mut Ui, index: usize, vertex: &Vertex, was_in: Option<&str>) {
    let palette = Palette::of(ui);
    let fill = ui.visuals().faint_bg_color;
    let stroke = was_in.map_or(egui::Stroke::NONE, |_| egui::Stroke::new(1.0, palette.warning));
    let frame =
        egui::Frame::new().fill(fill).stroke(stroke).corner_radius(4).inner_margin(egui::Margin::symmetric(8, 4));
    let response = frame
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            let name = vertex.refractor.as_deref().or(vertex.solid.as_deref()).unwrap_or("?");
            ui.horizontal(|ui| {
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(RichText::new(event_text(vertex.event)).small().color(palette.weak_text));
                    ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                        ui.label(value(format!("{:>2}", index + 1)).color(palette.weak_text));
                        ui.add(Label::new(RichText::new(name).strong()).truncate());
                    });
                });
            });
            if let (Some(from), Some(to)) = (&vertex.from, &vertex.to) {
                let side = |name: &str, ior: Option<f64>| match ior {
                    Some(ior) => format!("{name} {ior:.4}"),
                    None => name.to_owned(),
                };
                let text = format!("{} → {}", side(from, vertex.ior_from), side(to, vertex.ior_to));
                ui.add(Label::new(value(text)).truncate());
            }
            if let Some(fresnel) = vertex.fresnel {
                ui.label(value(format!("R {fresnel:.5}")).color(palette.weak_text))
                    .on_hover_text("Fresnel's reflectance, unpolarised: the share of the light that is reflected.");
            }
            if let Some(was_in) = was_in {
                let text = format!("{WARNING_MARK} the path was in {was_in}");
                ui.label(RichText::new(text).small().color(palette.warning));
            }
            ui.set_width(ui.available_width());
        })
        .response;
    let [x, y, z] = vertex.position;
    response.on_hover_text(format!("at {x:.5}, {y:.5}, {z:.5}"));
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
    use crate::tracking::Events;
    use crate::tracking::Mode;

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
            is_consistent,
        }
    }

    #[test]
    fn a_medium_that_was_never_entered_is_a_fault() {
        let path = TracedPath {
            mode: Mode::Stack,
            camera_medium: "water".into(),
            vertices: vec![
                vertex("world", "glass", VertexEvent::Transmit, false),
                vertex("glass", "world", VertexEvent::TotalReflection, true),
                vertex("glass", "world", VertexEvent::Transmit, true),
                vertex("water", "world", VertexEvent::Transmit, false),
            ],
            escaped: true,
            final_direction: [0.0, 0.0, 1.0],
            events: Events::default(),
        };
        assert_eq!(faults(&path), [Some("water".to_owned()), None, None, Some("world".to_owned())]);
    }
}
