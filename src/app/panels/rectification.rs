//! What rectification found: per refractor the media on both sides, votes, confidence; and how long it took.

use egui::{Label, RichText, Ui};

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::theme::{Palette, WARNING_MARK};
use crate::app::widgets::{fact_ui, focus_ring, note, section_first_ui, section_ui, value};
use crate::export::words::{duration, grouped};
use crate::rectify::{Patch, PatchKind};
use crate::scene::Scene;

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let Some(report) = &state.report else {
        ui.label(note(ui, "Preparing the scene…"));
        return;
    };
    let (scene, table) = (&report.prepared.scene, &report.prepared.table);
    let seconds = table.seconds;
    section_first_ui(ui, "Rectification", &duration(seconds.total()));
    let least = table.patches.iter().map(|patch| patch.confidence).fold(1.0, f64::min);
    let refractors = scene.refractors().count();
    fact_ui(ui, "Refractors", refractors.to_string(), "Objects that light goes through.");
    let about =
        "Parts of their surfaces: each with the same surroundings everywhere, or crossed by the same other surfaces.";
    fact_ui(ui, "Patches", grouped(table.patches.len() as u64), about);
    for kind in PatchKind::ALL.into_iter().filter(|kind| *kind != PatchKind::Clear) {
        let count = table.patches.iter().filter(|patch| patch.kind == kind).count();
        if count > 0 {
            fact_ui(ui, &format!("  of these {}", kind.name()), grouped(count as u64), about_kind(kind));
        }
    }
    fact_ui(ui, "Rays", grouped(table.rays()), "Shot outward from the patches, over all runs on this geometry.");
    fact_ui(ui, "Least confidence", format!("{:.1} %", least * 100.0), "The patch whose rays agreed least.");
    if seconds.topology > 0.0 {
        fact_ui(ui, "Topology", duration(seconds.topology), "Looking at the meshes; once per geometry.");
    }
    if seconds.patches > 0.0 {
        let about = "Finding where surfaces meet and what parts that makes; once per geometry.";
        fact_ui(ui, "Contacts, patches", duration(seconds.patches), about);
    }
    fact_ui(ui, "Pre-trace", duration(seconds.pretrace), "Shooting the rays; once per geometry.");
    fact_ui(ui, "Resolve", duration(seconds.resolve), "From votes to media; done again at every edit.");
    let about = "Tessellating, transforming, building the tree; 0 when kept.";
    fact_ui(ui, "Geometry and tree", duration(report.prepared.seconds.bvh), about);

    section_ui(ui, "Interfaces", "outside | inside");
    let mut height = None;
    for patch in &table.patches {
        // All have the same height: those that are scrolled away need no more than their room.
        let top = ui.cursor().min;
        let room = height.map(|height| egui::Rect::from_min_size(top, egui::vec2(ui.available_width(), height)));
        match room {
            Some(room) if !ui.is_rect_visible(room) => {
                ui.allocate_rect(room, egui::Sense::hover());
            }
            _ => {
                patch_ui(ui, state, scene, patch, commands);
                height = Some(ui.min_rect().bottom() - top.y);
            }
        }
    }
    if table.patches.is_empty() {
        ui.label(note(ui, "No refractors in this scene."));
    }
    let left_out = scene.needs.left_out();
    if !left_out.is_empty() {
        section_ui(ui, "Left out", "");
        ui.add(Label::new(note(ui, left_out.join(", ").replace('_', " "))).wrap())
            .on_hover_text("Work that this scene does not need and the renderer does not do.");
    }
}

fn patch_ui(ui: &mut Ui, state: &State, scene: &Scene, patch: &Patch, commands: &mut Vec<Command>) {
    let palette = Palette::of(ui);
    let name = &scene.object(patch.refractor).name;
    let is_selected = state.selected.as_deref() == Some(name);
    let fill = if is_selected { ui.visuals().selection.bg_fill } else { ui.visuals().faint_bg_color };
    let frame = egui::Frame::new().fill(fill).corner_radius(4).inner_margin(egui::Margin::symmetric(8, 4));
    let response = frame
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            ui.horizontal(|ui| {
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let color = if patch.confidence < 1.0 { palette.warning } else { palette.weak_text };
                    let mark = if patch.confidence < 1.0 { WARNING_MARK } else { "" };
                    ui.label(value(format!("{mark} {:.0} %", patch.confidence * 100.0)).color(color));
                    ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                        ui.add(Label::new(RichText::new(format!("{name} {}", patch.index)).strong()).truncate());
                    });
                });
            });
            ui.add(Label::new(value(sides(scene, patch))).truncate());
        })
        .response
        .interact(egui::Sense::click());
    let label = format!("{name}, patch {}", patch.index);
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, is_selected, &label));
    focus_ring(ui, &response);
    let response = response.on_hover_ui(|ui| {
        ui.strong(format!("{name}, patch {}: {}", patch.index, patch.kind.name()));
        ui.label(sides(scene, patch));
        ui.label(about_kind(patch.kind));
        ui.label(format!("{} rays, {} faces", grouped(u64::from(patch.rays)), grouped(u64::from(patch.faces))));
        for vote in &*patch.votes {
            ui.label(format!("{} of {} votes: inside {}", vote.inside, vote.asked, scene.object(vote.refractor).name));
        }
        if let Some(container) = patch.within {
            ui.label(format!("and inside all that contains {}", scene.object(container).name));
        }
    });
    if response.clicked() {
        commands.push(Command::SelectObject((!is_selected).then(|| name.clone())));
    }
}

/// What lies on both sides of a patch, or what keeps that from being one answer.
fn sides(scene: &Scene, patch: &Patch) -> String {
    match (patch.outside, patch.inside) {
        (Some(outside), Some(inside)) => {
            let (outside, inside) = (scene.medium(outside), scene.medium(inside));
            format!("{} {:.4} | {} {:.4}", outside.name, outside.ior(), inside.name, inside.ior())
        }
        _ if patch.crossed_by.is_empty() => patch.kind.name().to_owned(),
        _ => {
            let others: Vec<&str> = patch.crossed_by.iter().map(|id| scene.object(*id).name.as_str()).collect();
            format!("crossed by {}", others.join(", "))
        }
    }
}

/// What a kind of patch is.
fn about_kind(kind: PatchKind) -> &'static str {
    match kind {
        PatchKind::Clear => "One medium outside, another inside.",
        PatchKind::Null => "The same medium on both sides: nothing is to be seen there.",
        PatchKind::Mixed => "Other surfaces cross it: the answer is looked up place by place.",
        PatchKind::Masked => "It coincides with another surface, which stands for both.",
    }
}
