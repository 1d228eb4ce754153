//! The tree of what contains what, as rectification found it, with every medium's IOR; solids and lights below.

mod found;
mod row;

use egui::{CollapsingHeader, ScrollArea, Ui};

use self::found::{outside, patch_of, rows, shines_into};
pub use self::row::selectable_row_ui;
use self::row::{plain_row_ui, refractor_row_ui};
use super::{declared, medium, object, priorities, role, shape, world};
use crate::app::command::Command;
use crate::app::modal;
use crate::app::state::{State, medium_of};
use crate::app::widgets::{button_ui, fact_ui, note, section_first_ui, section_ui};
use crate::scene::Description;
use crate::scene::description::{Object, Role};

/// Indent per level, in points, while there is room.
const INDENT: f32 = 13.0;
/// Least indent per level in deep nests.
const LEAST_INDENT: f32 = 5.0;
/// Deeper rows are not indented further, or there would be no room for their names.
const MOST_INDENT: f32 = 52.0;

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let description = state.document.description();
    let detail = state.report.as_ref().map_or_else(String::new, |_| {
        let count = description.objects.refractors().len();
        format!("{count} {}", if count == 1 { "refractor" } else { "refractors" })
    });
    section_first_ui(ui, "Scene", &detail);
    let about = "Add an object where the camera looks (Shift + A).";
    button_ui(ui, "Add…", about, commands, Command::ShowAdd(!state.windows.add));
    // The selected object's card stands at the bottom, where it does not move the tree.
    let most = 0.62 * ui.available_height();
    egui::Panel::bottom("card").frame(egui::Frame::new()).show_separator_line(false).show(ui, |ui| {
        let area = ScrollArea::vertical().id_salt("card").min_scrolled_height(most).max_height(most);
        modal::scroll_ui(ui, area.auto_shrink([false, true]), |ui| {
            ui.set_max_width(ui.available_width() - 4.0);
            card_ui(ui, state, description, commands);
        });
    });
    modal::scroll_ui(ui, ScrollArea::vertical().auto_shrink(false), |ui| {
        ui.set_max_width(ui.available_width() - 4.0);
        ui.spacing_mut().item_spacing.y = 2.0;
        // A row that was selected elsewhere is brought into view, once.
        let id = ui.scope_id().with("shown");
        let shown: Option<String> = ui.data(|data| data.get_temp(id)).flatten();
        let to_show = state.selected.clone().filter(|selected| shown.as_ref() != Some(selected));
        ui.data_mut(|data| data.insert_temp(id, state.selected.clone()));
        world::rows_ui(ui, state, commands);
        let rows = rows(description, state.report.as_deref());
        let deepest = rows.iter().map(|row| row.depth).max().unwrap_or(1);
        let indent = (MOST_INDENT / deepest as f32).clamp(LEAST_INDENT, INDENT);
        for row in rows {
            let response = refractor_row_ui(ui, state, description, &row, indent, commands);
            let to_show = to_show.as_ref().or(state.renaming.as_ref());
            if to_show == Some(&description.objects.refractors()[row.refractor].name) {
                response.scroll_to_me(None);
            }
        }
        if description.objects.refractors().is_empty() {
            ui.label(note(ui, "No refractors in this scene."));
        }
        ui.add_space(8.0);
        plain_rows_ui(ui, state, "Solids", description.objects.solids(), to_show.as_deref(), commands);
        plain_rows_ui(ui, state, "Lights", description.objects.lights(), to_show.as_deref(), commands);
        priorities::show(ui, state, commands);
    });
}

fn card_ui(ui: &mut Ui, state: &State, description: &Description, commands: &mut Vec<Command>) {
    let Some(selected) = &state.selected else {
        ui.add_space(4.0);
        ui.label(note(ui, "Select a row to edit it, or Ctrl + click an object."));
        return;
    };
    if selected == crate::optics::medium::WORLD {
        world::card_ui(ui, state, commands);
        return;
    }
    let Some(object) = state.selected_object() else { return };
    if let Some(medium) = medium_of(description, selected) {
        section_ui(ui, selected, medium.name());
        object::show(ui, object, commands);
        shape::show(ui, description, object, commands);
        medium::object_ui(ui, description, selected, medium.name(), commands);
        fact_ui(ui, "Outside", outside(state, selected), "The medium that rectification found on the other side.");
        declared::outside_ui(ui, description, object, commands);
        if let Some(patch) = state.report.as_deref().and_then(|report| patch_of(report, selected)) {
            let text = format!("{:.1} % of {} rays", patch.confidence * 100.0, patch.rays);
            fact_ui(ui, "Confidence", text, "Share of the votes that this answer got.");
        }
        return;
    }
    let role = &object.role;
    let kind = if matches!(role, Role::Solid(solid) if solid.mirror) { "mirror" } else { role.kind().name() };
    section_ui(ui, selected, kind);
    if let Some(media) = shines_into(state, selected) {
        fact_ui(
            ui,
            "Stands in",
            media,
            "The medium around the light, which rectification found. Its radiance or intensity is that in this medium.",
        );
    }
    if object.light().is_some() {
        declared::outside_ui(ui, description, object, commands);
    }
    role::show(ui, object, commands);
    object::show(ui, object, commands);
    shape::show(ui, description, object, commands);
}

/// Rows under a heading that opens where one of them is `to_show`.
fn plain_rows_ui(
    ui: &mut Ui,
    state: &State,
    heading: &str,
    objects: &[Object],
    to_show: Option<&str>,
    commands: &mut Vec<Command>,
) {
    if objects.is_empty() {
        return;
    }
    let to_show = to_show.or(state.renaming.as_deref());
    let is_shown = to_show.is_some_and(|to_show| objects.iter().any(|object| object.name == to_show));
    let header = CollapsingHeader::new(format!("{heading} ({})", objects.len())).id_salt(heading);
    header.open(is_shown.then_some(true)).show(ui, |ui| {
        for object in objects {
            let response = plain_row_ui(ui, state, object, commands);
            if to_show == Some(&object.name) {
                response.scroll_to_me(None);
            }
        }
    });
}
