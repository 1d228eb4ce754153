//! The rows of the tree: an object's name, its marks, and what a right click offers.

use egui::{Align, Label, Layout, Rect, Response, RichText, Sense, Stroke, TextEdit, Ui, UiBuilder, pos2, vec2};

use super::MOST_INDENT;
use super::found::{Row, mixture, outside, patch_of, shines_into};
use crate::app::build;
use crate::app::command::{Command, MediumRef};
use crate::app::edit::{Edit, ObjectEdit};
use crate::app::panels::medium;
use crate::app::state::State;
use crate::app::theme::{Palette, WARNING_MARK, opaque};
use crate::app::widgets::{focus_ring, swatch_ui};
use crate::scene::Description;
use crate::scene::description::{Object, Role, Shape, Solid};

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

pub fn refractor_row_ui(
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

pub fn plain_row_ui(ui: &mut Ui, state: &State, object: &Object, commands: &mut Vec<Command>) -> Response {
    let name = &object.name;
    let is_selected = state.selected.as_ref() == Some(name);
    let (rect, response) = selectable_row_ui(ui, is_selected, name, ui.spacing().interact_size.y + 2.0);
    let color = opaque(crate::render::Display::default().encode(color_of(&object.role).map(|c| c as f32)));
    let left = rect.shrink2(vec2(4.0, 0.0));
    let mut contents = ui.new_child(UiBuilder::new().max_rect(left).layout(Layout::left_to_right(Align::Center)));
    swatch_ui(&mut contents, color);
    name_ui(&mut contents, state, name, object.visible, commands);
    let media = object.light().and_then(|_| shines_into(state, name));
    let response = response.on_hover_ui(|ui| {
        ui.strong(name);
        media.iter().for_each(|media| _ = ui.label(format!("stands in: {media}")));
        ui.label(format!("shape: {}", shape_name(&object.shape)));
    });
    if response.clicked() {
        commands.push(Command::SelectObject((!is_selected).then(|| name.clone())));
    }
    row_menu_ui(&response, state, object, commands);
    response
}

/// The colour of what is no refractor.
fn color_of(role: &Role) -> [f64; 3] {
    match role {
        Role::Solid(Solid { paint, .. }) => paint.mean(),
        Role::Light(light) => {
            let most = light.emission.rgb.iter().copied().fold(1e-9, f64::max);
            light.emission.rgb.map(|x| x / most)
        }
        Role::Refractor(_) => [1.0; 3],
    }
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
        Shape::Point { .. } => "point".to_owned(),
        Shape::Spot { outer_angle, .. } => format!("spot, {outer_angle}° from its axis"),
        Shape::Directional { angle: 0.0, .. } => "directional".to_owned(),
        Shape::Directional { angle, .. } => format!("directional, {angle}° across"),
        Shape::Mesh { path, part, mesh, .. } => {
            let names: String = part.group.iter().chain(&part.material).map(|name| format!(", {name}")).collect();
            format!("{}{names} ({} triangles)", path.display(), mesh.triangles.len())
        }
    }
}
