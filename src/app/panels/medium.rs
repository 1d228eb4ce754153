//! The controls of one medium: its index, what it absorbs, who is made of it.

mod absorption;
mod card;
mod choice;

use std::collections::HashSet;

use egui::{Color32, Id, Rect, Response, Sense, Stroke, Ui, vec2};

pub use self::card::{object_ui, world_ui};
use crate::app::command::{Command, MediumRef};
use crate::app::edit::{Edit, MediumEdit, ior_of};
use crate::app::ior_control::{self, Change, Mark, Subject};
use crate::app::theme::Palette;
use crate::optics::medium::WORLD;
use crate::scene::Description;

/// Width that [`row_ui`] takes.
pub const ROW_WIDTH: f32 = ior_control::COMPACT_WIDTH;
/// Height of a row with an index in it.
pub const ROW_HEIGHT: f32 = 30.0;

/// The index of a medium in a row of the tree, within `rect`. `owner` names the row, so that two objects of one medium keep their controls
/// apart.
pub fn row_ui(
    ui: &mut Ui,
    rect: Rect,
    description: &Description,
    medium: &MediumRef,
    owner: &str,
    commands: &mut Vec<Command>,
) {
    let others = others(ui, description, medium);
    let Some(subject) = subject(ui, description, medium, &others) else { return };
    let id = Id::unique(("index in row", owner));
    let change = ior_control::compact_ui(ui, rect, id, &subject);
    push(change, medium, commands);
}

/// What a control says about a medium; `None` if there is no such medium.
fn subject<'a>(
    ui: &Ui,
    description: &'a Description,
    medium: &'a MediumRef,
    others: &'a [Mark],
) -> Option<Subject<'a>> {
    let model = ior_of(description, medium)?;
    Some(Subject { name: medium.name(), model, color: color(&Palette::of(ui), description, medium.name()), others })
}

/// The other media of the scene, as marks on a rail; of the world only where it is no vacuum.
fn others(ui: &Ui, description: &Description, medium: &MediumRef) -> Vec<Mark> {
    let palette = Palette::of(ui);
    let world = (WORLD, &description.world.ior);
    let media = description.media.iter().map(|medium| (medium.name.as_str(), &medium.ior));
    std::iter::once(world)
        .chain(media)
        .filter(|(name, ior)| *name != medium.name() && (*name != WORLD || ior.ior() != 1.0))
        .map(|(name, ior)| Mark { name: name.to_owned(), ior: ior.ior(), color: color(&palette, description, name) })
        .collect()
}

/// The commands that a change of the control stands for.
fn push(change: Change, medium: &MediumRef, commands: &mut Vec<Command>) {
    let Change { begins, ior, ends, is_drag } = change;
    commands.extend(begins.then_some(Command::BeginDrag));
    if let Some(ior) = ior {
        let edit = Edit::Medium(medium.clone(), MediumEdit::Ior(ior));
        commands.push(if is_drag { Command::Drag(edit) } else { Command::Edit(edit) });
    }
    commands.extend(ends.then_some(Command::EndDrag));
}

/// The names of the refractors that are made of a medium.
pub fn users<'a>(description: &'a Description, medium: &str) -> Vec<&'a str> {
    let is_of = |refractor: &crate::scene::description::Refractor| refractor.medium == medium;
    let objects = description.objects.refractors().iter();
    objects.filter(|object| object.refractor().is_some_and(is_of)).map(|object| object.name.as_str()).collect()
}

/// The media, the world among them, whose index is that of `medium` to the last digit that is shown: between them nothing bends light.
pub fn matched<'a>(description: &'a Description, medium: &str) -> Vec<&'a str> {
    let world = (WORLD, &description.world.ior);
    let media = description.media.iter().map(|medium| (medium.name.as_str(), &medium.ior));
    let all: Vec<_> = std::iter::once(world).chain(media).collect();
    let Some((_, own)) = all.iter().find(|(name, _)| *name == medium) else { return Vec::new() };
    let is_same = |ior: &crate::optics::Ior| ior == *own || ior.ior() == own.ior();
    all.iter().filter(|(name, ior)| *name != medium && is_same(ior)).map(|(name, _)| *name).collect()
}

/// Marks of a row for a medium that several objects share, and for one whose index another medium has too.
pub fn links_ui(ui: &mut Ui, description: &Description, medium: &str) {
    let palette = Palette::of(ui);
    let users = users(description, medium);
    if users.len() > 1 {
        let about =
            format!("Linked: {} objects are made of {medium}, and change together: {}.", users.len(), users.join(", "));
        chain_ui(ui, palette.weak_text).on_hover_text(about);
    }
    let matched = matched(description, medium);
    if !matched.is_empty() {
        let text = egui::RichText::new("=").small().strong().color(palette.accent);
        let about = format!("The same index as {}: a surface between them bends no light.", matched.join(", "));
        ui.add(egui::Label::new(text).sense(Sense::hover())).on_hover_text(about);
    }
}

/// Two links of a chain.
fn chain_ui(ui: &mut Ui, color: Color32) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(13.0, ui.spacing().interact_size.y), Sense::hover());
    for side in [-1.0, 1.0] {
        let link = Rect::from_center_size(rect.center() + vec2(side * 2.5, 0.0), vec2(7.0, 5.0));
        ui.painter().rect_stroke(link, 2.5, Stroke::new(1.2, color), egui::StrokeKind::Middle);
    }
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Linked"));
    response
}

/// The colour that stands for a medium.
pub fn color(palette: &Palette, description: &Description, medium: &str) -> Color32 {
    match description.media.iter().position(|m| m.name == medium) {
        Some(index) => palette.medium(index),
        None => palette.world(),
    }
}

/// The media of which no object is made and in which nothing is declared to lie.
pub fn unused(description: &Description) -> Vec<&str> {
    let made_of = description.objects.refractor_roles().map(|refractor| refractor.medium.as_str());
    let used: HashSet<&str> = made_of.chain(description.declared()).collect();
    description.media.iter().map(|medium| medium.name.as_str()).filter(|name| !used.contains(name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Ior, Medium};

    #[test]
    fn media_of_one_index_are_matched_and_idle_ones_unused() {
        let mut description = crate::formats::open("nested-spheres").unwrap();
        let names: Vec<String> = description.media.iter().map(|medium| medium.name.clone()).collect();
        assert!(unused(&description).is_empty());
        assert!(names.iter().all(|name| !users(&description, name).is_empty()));
        let Medium { name, ior, absorption } = description.media[0].clone();
        description.media.push(Medium { name: "twin".into(), ior: Ior::Constant(ior.ior()), absorption });
        assert_eq!(matched(&description, "twin"), [name.as_str()]);
        assert_eq!(matched(&description, &name), ["twin"]);
        assert_eq!(unused(&description), ["twin"]);
        description.world.ior = Ior::Constant(ior.ior());
        assert_eq!(matched(&description, WORLD), [name.as_str(), "twin"]);
        assert!(matched(&description, "no such medium").is_empty());
    }
}
