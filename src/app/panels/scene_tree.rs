//! The tree of what contains what, as rectification found it, with every medium's IOR; solids and lights below.

use egui::{
    Align, CollapsingHeader, Label, Layout, Rect, Response, RichText, ScrollArea, Sense, Stroke, TextEdit, Ui,
    UiBuilder, pos2, vec2,
};

use super::{medium, object, priorities, role, shape, world};
use crate::app::build;
use crate::app::command::{Command, MediumRef};
use crate::app::edit::{Edit, ObjectEdit};
use crate::app::state::{State, medium_of};
use crate::app::theme::{Palette, WARNING_MARK, opaque};
use crate::app::widgets::{button_ui, fact_ui, focus_ring, note, section_first_ui, section_ui, swatch_ui};
use crate::rectify::Patch;
use crate::scene::Description;
use crate::scene::ObjectId;
use crate::scene::description::{Object, Paint, Role, Shape, Solid};
use crate::session::SceneReport;
use crate::tracking::Prepared;

/// Indent per level, in points, while there is room.
const INDENT: f32 = 13.0;
/// Least indent per level in deep nests.
const LEAST_INDENT: f32 = 5.0;
/// Deeper rows are not indented further, or there would be no room for their names.
const MOST_INDENT: f32 = 52.0;

/// A row of the tree: a refractor by index, and how deep it is.
struct Row {
    refractor: usize,
    depth: usize,
    /// For each level above, whether a line goes on down to a later sibling.
    continues: Vec<bool>,
}

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
        area.auto_shrink([false, true]).show(ui, |ui| {
            ui.set_max_width(ui.available_width() - 4.0);
            card_ui(ui, state, description, commands);
        });
    });
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
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

/// The rows of the tree, parents before children, siblings in file order. Before the first rectification everything is at the top.
fn rows(description: &Description, report: Option<&SceneReport>) -> Vec<Row> {
    let count = description.objects.refractors().len();
    let parent = |index: usize| -> Option<usize> {
        let container = container_of(report?, &description.objects.refractors()[index].name)?.0 as usize;
        (container < count && container != index).then_some(container)
    };
    let mut children = vec![Vec::new(); count + 1];
    for index in 0..count {
        children[parent(index).map_or(0, |p| p + 1)].push(index);
    }
    let mut rows = Vec::with_capacity(count);
    let mut is_listed = vec![false; count];
    list(&children, 0, &mut Vec::new(), &mut rows, &mut is_listed);
    // Two objects that each seem to contain the other are below no root; they are shown nevertheless.
    let lost = is_listed.iter().enumerate().filter(|(_, is_listed)| !**is_listed);
    rows.extend(lost.map(|(index, _)| Row { refractor: index, depth: 1, continues: Vec::new() }));
    rows
}

fn list(children: &[Vec<usize>], of: usize, continues: &mut Vec<bool>, rows: &mut Vec<Row>, is_listed: &mut [bool]) {
    for (place, &index) in children[of].iter().enumerate() {
        if std::mem::replace(&mut is_listed[index], true) {
            continue;
        }
        continues.push(place + 1 < children[of].len());
        rows.push(Row { refractor: index, depth: continues.len(), continues: continues.clone() });
        list(children, index + 1, continues, rows, is_listed);
        continues.pop();
    }
}

/// The answer for a refractor, by name: the description may be newer than the report.
fn patch_of<'a>(report: &'a SceneReport, refractor: &str) -> Option<&'a Patch> {
    let scene = &report.prepared.scene;
    let (id, _) = scene.refractors().find(|(id, _)| scene.object(*id).name == refractor)?;
    report.prepared.table.main_patch(id)
}

/// The refractor that most of a refractor's surface lies in; `None`: the global medium, or not known yet.
fn container_of(report: &SceneReport, refractor: &str) -> Option<ObjectId> {
    let Prepared { scene, table, .. } = &report.prepared;
    let (id, _) = scene.refractors().find(|(id, _)| scene.object(*id).name == refractor)?;
    match table.known_containers() {
        Some(containers) => containers.parent_of(id),
        None => table.main_patch(id)?.outside_refractor,
    }
}

/// What the parts of a refractor's surface lie in, in words, where that is more than one thing.
fn mixture(report: &SceneReport, refractor: &str) -> Option<String> {
    let Prepared { scene, table, .. } = &report.prepared;
    let (id, _) = scene.refractors().find(|(id, _)| scene.object(*id).name == refractor)?;
    let parts = table.known_containers().filter(|containers| containers.is_mixed(id))?.parts_of(id);
    let words: Vec<String> = parts
        .iter()
        .map(|part| {
            let container = part.container.map_or(crate::optics::medium::WORLD, |id| &scene.object(id).name);
            format!("{:.0} % in {container}", part.share * 100.0)
        })
        .collect();
    Some(format!(
        "It crosses a boundary: of its surface, {}. It stands below what most of it lies in.",
        words.join(", ")
    ))
}

/// Makes a row of the panel's width that can be selected. Returns it and the part of it at the left of the controls.
pub fn selectable_row_ui(ui: &mut Ui, is_selected: bool, name: &str, height: f32) -> (Rect, Response) {
    let size = vec2(ui.available_width(), height);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::TreeItem, true, is_selected, name));
    let visuals = ui.visuals();
    if is_selected {
        // Not the colour of selections, which the sliders on it have.
        ui.painter().rect_filled(rect, 4.0, visuals.widgets.inactive.weak_bg_fill);
        let bar = Rect::from_min_size(rect.min, vec2(3.0, rect.height()));
        ui.painter().rect_filled(bar, 1.5, Palette::of(ui).accent);
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 4.0, visuals.widgets.inactive.weak_bg_fill.gamma_multiply(0.6));
    }
    focus_ring(ui, &response);
    (rect, response)
}

fn refractor_row_ui(
    ui: &mut Ui,
    state: &State,
    description: &Description,
    row: &Row,
    indent: f32,
    commands: &mut Vec<Command>,
) -> Response {
    let object = &description.objects.refractors()[row.refractor];
    let medium_name = object.refractor().map_or("", |refractor| &refractor.medium);
    let palette = Palette::of(ui);
    let is_selected = state.selected.as_deref() == Some(&object.name);
    let (rect, response) = selectable_row_ui(ui, is_selected, &object.name, medium::ROW_HEIGHT);
    if !ui.is_rect_visible(rect) {
        // A hundred shells are a long list: what is scrolled away costs nothing.
        return response;
    }
    let depth = row.depth.min((MOST_INDENT / indent) as usize);
    paint_branches(ui, rect, depth, indent, &row.continues);
    let color = medium::color(&palette, description, medium_name);
    let patch = state.report.as_deref().and_then(|report| patch_of(report, &object.name));
    let doubt = patch.filter(|patch| patch.confidence < 1.0).map(|patch| patch.confidence);
    let mixture = state.report.as_deref().and_then(|report| mixture(report, &object.name));
    let marks = |ui: &mut Ui| {
        swatch_ui(ui, color);
        medium::links_ui(ui, description, medium_name);
        if let Some(mixture) = &mixture {
            mixture_mark_ui(ui, &object.name, mixture);
        }
    };
    row_contents_ui(ui, state, rect, depth as f32 * indent, &object.name, object.visible, doubt, marks, commands);
    let medium = MediumRef::Named(medium_name.to_owned());
    medium::row_ui(ui, controls_of(rect), description, &medium, &object.name, commands);
    let response = response.on_hover_ui(|ui| {
        ui.strong(&object.name);
        ui.label(format!("medium: {medium_name}"));
        ui.label(format!("outside: {}", outside(state, &object.name)));
        mixture.iter().for_each(|mixture| _ = ui.label(mixture));
        ui.label(format!("shape: {}", shape_name(&object.shape)));
    });
    if response.clicked() {
        commands.push(Command::SelectObject((!is_selected).then(|| object.name.clone())));
    }
    row_menu_ui(&response, state, object, commands);
    response
}

/// The part of a row that the IOR's controls take.
fn controls_of(row: Rect) -> Rect {
    Rect::from_min_max(pos2(row.right() - medium::ROW_WIDTH - 4.0, row.top()), row.max - vec2(2.0, 0.0))
}

#[expect(clippy::too_many_arguments, reason = "one row, drawn in two places")]
fn row_contents_ui(
    ui: &mut Ui,
    state: &State,
    row: Rect,
    indent: f32,
    name: &str,
    visible: bool,
    doubt: Option<f64>,
    marks: impl FnOnce(&mut Ui),
    commands: &mut Vec<Command>,
) {
    let left = Rect::from_min_max(row.min + vec2(4.0 + indent, 0.0), pos2(controls_of(row).left() - 4.0, row.bottom()));
    let mut contents = ui.new_child(UiBuilder::new().max_rect(left).layout(Layout::left_to_right(Align::Center)));
    contents.spacing_mut().item_spacing.x = 3.0;
    marks(&mut contents);
    if let Some(confidence) = doubt {
        let color = Palette::of(&contents).warning;
        let tip = format!("The rays did not agree: {:.0} % for this place in the tree.", confidence * 100.0);
        contents.label(RichText::new(WARNING_MARK).small().color(color)).on_hover_text(tip);
    }
    name_ui(&mut contents, state, name, visible, commands);
}

/// The name of an object in its row, or a field to type another.
fn name_ui(ui: &mut Ui, state: &State, name: &str, visible: bool, commands: &mut Vec<Command>) {
    if state.renaming.as_deref() != Some(name) {
        ui.add(Label::new(row_name(ui, name, visible)).truncate().sense(Sense::empty()));
        return;
    }
    let id = egui::Id::unique(("renamed", name));
    let pass = ui.ctx().cumulative_pass_nr();
    // What was typed, and when the field was last there: one that comes back begins with the name.
    let known: Option<(String, u64)> = ui.data(|data| data.get_temp(id));
    let known = known.filter(|(_, last)| last + 1 >= pass).map(|(text, _)| text);
    let is_new = known.is_none();
    let mut text = known.unwrap_or_else(|| name.to_owned());
    let field = ui.add(TextEdit::singleline(&mut text).id(id.with("field")).desired_width(ui.available_width()));
    let field = field.accessible_name(format!("New name of {name}"));
    if is_new {
        field.request_focus();
    }
    ui.data_mut(|data| data.insert_temp(id, (text.clone(), pass)));
    if !is_new && !field.has_focus() {
        ui.data_mut(|data| data.remove::<(String, u64)>(id));
        let is_given_up = commands.contains(&Command::Escape) || ui.input(|input| input.key_pressed(egui::Key::Escape));
        if !is_given_up {
            commands.push(Command::object(name, ObjectEdit::Rename(text)));
        }
        commands.push(Command::Rename(None));
    }
}

/// A disc of which one half is filled.
fn mixture_mark_ui(ui: &mut Ui, name: &str, about: &str) {
    let (rect, response) = ui.allocate_exact_size(vec2(10.0, ui.spacing().interact_size.y), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("{name} is mixed")));
    let color = Palette::of(ui).weak_text;
    let (center, radius) = (rect.center(), 4.5);
    let below = (0..=16).map(|step| center + radius * egui::Vec2::angled(std::f32::consts::PI * step as f32 / 16.0));
    ui.painter().add(egui::Shape::convex_polygon(below.collect(), color, Stroke::NONE));
    ui.painter().circle_stroke(center, radius, Stroke::new(1.0, color));
    response.on_hover_text(about);
}

/// The name of an object in its row; of a hidden one in weak italics, with a word.
fn row_name(ui: &Ui, name: &str, visible: bool) -> RichText {
    if visible {
        RichText::new(name)
    } else {
        RichText::new(format!("{name} (hidden)")).italics().color(Palette::of(ui).weak_text)
    }
}

/// What a right click on a row offers, and a double click.
fn row_menu_ui(response: &Response, state: &State, object: &Object, commands: &mut Vec<Command>) {
    let (name, visible) = (&object.name, object.visible);
    if response.double_clicked() {
        commands.push(Command::Rename(Some(name.clone())));
    }
    response.context_menu(|ui| {
        let mut item = |text: &str, command: &dyn Fn() -> Option<Command>| {
            if ui.button(text).clicked() {
                commands.extend(command());
                ui.close();
            }
        };
        item("Camera to it", &|| Some(Command::FrameObject(name.clone())));
        let verb = if visible { "Hide" } else { "Show" };
        item(verb, &|| Some(Command::object(name, ObjectEdit::Visible(!visible))));
        item("Duplicate", &|| build::duplicate(state.document.description(), name).map(Command::Edit));
        item("Rename", &|| Some(Command::Rename(Some(name.clone()))));
        item("Delete", &|| Some(Command::Edit(Edit::Remove(name.clone()))));
    });
}

/// Lines from a row to its parent and past it to later siblings.
fn paint_branches(ui: &Ui, row: Rect, depth: usize, indent: f32, continues: &[bool]) {
    let stroke = Stroke::new(1.0, Palette::of(ui).line);
    let x_of = |level: usize| row.left() + 9.0 + (level as f32 - 1.0) * indent;
    let (top, bottom) = (row.top() - 2.0, row.bottom());
    for level in 1..=depth {
        let x = x_of(level);
        let goes_on = continues.get(level - 1).copied().unwrap_or(false);
        if level == depth {
            let end = if goes_on { bottom } else { row.center().y };
            ui.painter().vline(x, top..=end, stroke);
            ui.painter().hline(x..=x + (indent - 6.0).max(2.0), row.center().y, stroke);
        } else if goes_on {
            ui.painter().vline(x, top..=bottom, stroke);
        }
    }
}

/// What rectification found outside a refractor, in words: where it differs from place to place, everything.
fn outside(state: &State, refractor: &str) -> String {
    let Some(report) = state.report.as_deref() else { return "…".to_owned() };
    let scene = &report.prepared.scene;
    let Some((id, _)) = scene.refractors().find(|(id, _)| scene.object(*id).name == refractor) else {
        return "…".to_owned();
    };
    let mut found: Vec<String> = Vec::new();
    for patch in report.prepared.table.patches_of(id) {
        let Some(outside) = patch.outside else { continue };
        let medium = &scene.medium(outside).name;
        let text = match patch.outside_refractor {
            Some(container) if scene.object(container).name != *medium => {
                format!("{medium} ({})", scene.object(container).name)
            }
            _ => medium.clone(),
        };
        if !found.contains(&text) {
            found.push(text);
        }
    }
    if report.prepared.table.patches_of(id).is_empty() {
        // Hidden.
        "—".to_owned()
    } else if found.is_empty() {
        "differs from place to place".to_owned()
    } else {
        found.join(", ")
    }
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
        if let Some(patch) = state.report.as_deref().and_then(|report| patch_of(report, selected)) {
            let text = format!("{:.1} % of {} rays", patch.confidence * 100.0, patch.rays);
            fact_ui(ui, "Confidence", text, "Share of the votes that this answer got.");
        }
        return;
    }
    let role = &object.role;
    let kind = if matches!(role, Role::Solid(solid) if solid.mirror) { "mirror" } else { role.kind().name() };
    section_ui(ui, selected, kind);
    role::show(ui, object, commands);
    object::show(ui, object, commands);
    shape::show(ui, description, object, commands);
}

/// The colour of what is no refractor.
fn color_of(role: &Role) -> [f64; 3] {
    match role {
        Role::Solid(Solid { paint: Paint::Color(color), .. }) => *color,
        Role::Solid(Solid { paint: Paint::Checker { a, b, .. }, .. }) => std::array::from_fn(|i| 0.5 * (a[i] + b[i])),
        Role::Light(light) => {
            let most = light.radiance.iter().copied().fold(1e-9, f64::max);
            light.radiance.map(|x| x / most)
        }
        Role::Refractor(_) => [1.0; 3],
    }
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

fn plain_row_ui(ui: &mut Ui, state: &State, object: &Object, commands: &mut Vec<Command>) -> Response {
    let name = &object.name;
    let is_selected = state.selected.as_ref() == Some(name);
    let (rect, response) = selectable_row_ui(ui, is_selected, name, ui.spacing().interact_size.y + 2.0);
    let color = opaque(crate::render::Display::default().encode(color_of(&object.role).map(|c| c as f32)));
    let left = rect.shrink2(vec2(4.0, 0.0));
    let mut contents = ui.new_child(UiBuilder::new().max_rect(left).layout(Layout::left_to_right(Align::Center)));
    swatch_ui(&mut contents, color);
    name_ui(&mut contents, state, name, object.visible, commands);
    if response.clicked() {
        commands.push(Command::SelectObject((!is_selected).then(|| name.clone())));
    }
    row_menu_ui(&response, state, object, commands);
    response
}

fn shape_name(shape: &Shape) -> String {
    match shape {
        Shape::Sphere { radius, .. } => format!("sphere, radius {radius}"),
        Shape::Icosphere { radius, subdivisions, .. } => {
            format!("icosphere, radius {radius}, {subdivisions} subdivisions")
        }
        Shape::Box { .. } => "box".to_owned(),
        Shape::Cylinder { radius, height, .. } => format!("cylinder, radius {radius}, height {height}"),
        Shape::Torus { major, minor, .. } => format!("torus, radii {major} and {minor}"),
        Shape::Lathe { segments, .. } => format!("lathe, {segments} segments"),
        Shape::Quad { .. } => "quad".to_owned(),
        Shape::Mesh { path, mesh, .. } => format!("{} ({} triangles)", path.display(), mesh.triangles.len()),
    }
}
