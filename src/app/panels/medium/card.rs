//! A medium in the card of what is selected.

use egui::{Button, Id, Label, TextStyle, Ui, vec2};

use super::choice::{self, Choice};
use super::{absorption, matched, others, push, subject, unused, users};
use crate::app::command::{Command, MediumRef};
use crate::app::edit::{Edit, MediaEdit};
use crate::app::entry::Refusal;
use crate::app::ior_control;
use crate::app::text_field::{TextField, refusal_ui};
use crate::app::widgets::{note, row_ui, section_ui};
use crate::optics::{Ior, Medium, medium as names};
use crate::scene::Description;

/// Index of a medium that is new.
const NEW_IOR: f64 = 1.5;

/// The medium of a refractor: which it is, its index, what it absorbs, and who shares it.
pub fn object_ui(ui: &mut Ui, description: &Description, object: &str, medium: &str, commands: &mut Vec<Command>) {
    let count = users(description, medium).len();
    let detail = if count > 1 { format!("{count} objects") } else { String::new() };
    section_ui(ui, "Medium", &detail);
    let is_renaming = choice_ui(ui, description, object, medium, commands);
    if is_renaming {
        rename_ui(ui, description, medium, commands);
    }
    let medium = MediumRef::Named(medium.to_owned());
    shared_ui(ui, description, object, &medium, commands);
    optics_ui(ui, description, &medium, commands);
}

/// The global medium.
pub fn world_ui(ui: &mut Ui, description: &Description, commands: &mut Vec<Command>) {
    matched_ui(ui, description, names::WORLD);
    optics_ui(ui, description, &MediumRef::World, commands);
}

/// Index and absorption.
fn optics_ui(ui: &mut Ui, description: &Description, medium: &MediumRef, commands: &mut Vec<Command>) {
    let others = others(ui, description, medium);
    let Some(subject) = subject(ui, description, medium, &others) else { return };
    let change = ior_control::show(ui, Id::unique(("index in card", medium.name())), &subject);
    push(change, medium, commands);
    row_ui(ui, "Catalogue", "Media with measured indices of refraction.", |ui| {
        if let Some(entry) = choice::preset_ui(ui, medium.name(), subject.model) {
            commands.push(Command::set_ior(medium.clone(), Ior::Catalog(entry)));
        }
    });
    let sigma = match medium {
        MediumRef::World => description.world.absorption,
        MediumRef::Named(name) => description.medium(name).map(|m| m.absorption).unwrap_or_default(),
    };
    absorption::show(ui, medium, sigma, commands);
}

/// The list of media and what else can be done with them. Returns whether the medium is being renamed.
fn choice_ui(ui: &mut Ui, description: &Description, object: &str, medium: &str, commands: &mut Vec<Command>) -> bool {
    let renaming = Id::unique(("renaming medium", medium));
    let mut is_renaming: bool = ui.data(|data| data.get_temp(renaming)).unwrap_or(false);
    let mut edit = |edit: MediaEdit| commands.push(Command::Edit(Edit::Media(edit)));
    row_ui(ui, "Made of", "The medium inside the object.", |ui| {
        const MENU_WIDTH: f32 = 26.0;
        let width = ui.available_width() - MENU_WIDTH - ui.spacing().item_spacing.x;
        let chosen = ui
            .scope(|ui| {
                ui.set_max_width(width);
                choice::medium_ui(ui, description, object, medium)
            })
            .inner;
        match chosen {
            None => {}
            // Of the medium that it has, the edit changes nothing.
            Some(Choice::InScene(name)) => edit(MediaEdit::Assign(object.to_owned(), name)),
            Some(Choice::Catalog(entry)) => {
                let new = Medium { name: entry.name.to_owned(), ior: Ior::Catalog(entry), absorption: [0.0; 3] };
                edit(MediaEdit::Add(new, Some(object.to_owned())));
            }
        }
        let button = Button::new("…").min_size(vec2(MENU_WIDTH, ui.spacing().interact_size.y));
        let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
            let to = Some(object.to_owned());
            if ui.button("New medium").on_hover_text("Gives the object a new medium, of index 1.5.").clicked() {
                let ior = Ior::Constant(NEW_IOR);
                edit(MediaEdit::Add(Medium { name: "medium".to_owned(), ior, absorption: [0.0; 3] }, to.clone()));
            }
            let about = "Gives the object a medium of its own, a copy of this one.";
            if ui.button("Copy as its own medium").on_hover_text(about).clicked()
                && let Some(medium) = description.medium(medium)
            {
                edit(MediaEdit::Add(medium.clone(), to));
            }
            if ui.button("Rename…").clicked() {
                is_renaming = true;
            }
            let unused = unused(description);
            let text = format!("Delete unused media ({})", unused.len());
            let about = if unused.is_empty() { "Every medium is used.".to_owned() } else { unused.join(", ") };
            let response = ui.add_enabled(!unused.is_empty(), Button::new(text));
            if response.on_hover_text(&about).on_disabled_hover_text(&about).clicked() {
                edit(MediaEdit::RemoveUnused);
            }
        });
        response.accessible_name("More about media").on_hover_text("New, copy, rename, delete unused media.");
    });
    ui.data_mut(|data| data.insert_temp(renaming, is_renaming));
    is_renaming
}

fn rename_ui(ui: &mut Ui, description: &Description, medium: &str, commands: &mut Vec<Command>) {
    let renaming = Id::unique(("renaming medium", medium));
    let refusal = row_ui(ui, "New name", "Objects that are made of it stay so.", |ui| {
        let field = TextField {
            id: renaming.with("field"),
            shown: medium,
            name: format!("New name of {medium}"),
            about: "Enter renames the medium, Escape leaves its name.".to_owned(),
            width: ui.available_width(),
            align: egui::Align::Min,
            style: TextStyle::Body,
        };
        let typed = field.show(ui, |text| name(description, medium, text));
        let id = typed.response.id;
        let is_new = ui.data(|data| data.get_temp::<bool>(renaming.with("is asked"))).is_none();
        if is_new {
            ui.memory_mut(|memory| memory.request_focus(id));
            ui.data_mut(|data| data.insert_temp(renaming.with("is asked"), true));
        }
        if let Some(new) = &typed.taken {
            commands.push(Command::Edit(Edit::Media(MediaEdit::Rename(medium.to_owned(), new.clone()))));
        }
        let is_left = !is_new && typed.response.lost_focus() && typed.refusal.is_none();
        if is_left || typed.taken.is_some() {
            ui.data_mut(|data| {
                data.remove::<bool>(renaming);
                data.remove::<bool>(renaming.with("is asked"));
            });
        }
        typed.refusal
    });
    if let Some(refusal) = refusal {
        refusal_ui(ui, &refusal, medium);
    }
}

/// A name for a medium that is called `medium` now.
fn name(description: &Description, medium: &str, text: &str) -> Result<String, Refusal> {
    let text = text.trim();
    let refuse = |why: String| Err(Refusal(why));
    if text.is_empty() {
        refuse("A medium needs a name.".to_owned())
    } else if matches!(text, names::WORLD | names::VACUUM) {
        refuse(format!("“{text}” is reserved for what is around everything."))
    } else if text != medium && description.medium(text).is_some() {
        refuse(format!("There is a medium called “{text}” already."))
    } else {
        Ok(text.to_owned())
    }
}

/// Who else is made of the medium, and what has the same index.
fn shared_ui(ui: &mut Ui, description: &Description, object: &str, medium: &MediumRef, commands: &mut Vec<Command>) {
    let users = users(description, medium.name());
    if users.len() > 1 {
        ui.horizontal(|ui| {
            super::chain_ui(ui, crate::app::theme::Palette::of(ui).accent);
            let about = format!("Gives {object} a copy of {}: then the two no longer change together.", medium.name());
            let button = ui.small_button("Make its own").on_hover_text(about);
            if button.clicked()
                && let Some(medium) = description.medium(medium.name())
            {
                let edit = MediaEdit::Add(medium.clone(), Some(object.to_owned()));
                commands.push(Command::Edit(Edit::Media(edit)));
            }
            let others: Vec<&str> = users.iter().copied().filter(|user| *user != object).collect();
            let text = match others[..] {
                [other] => format!("Linked with {other}"),
                _ => format!("Linked with {} others", others.len()),
            };
            ui.add(Label::new(note(ui, text)).truncate()).on_hover_text(users.join("\n"));
        });
    }
    matched_ui(ui, description, medium.name());
}

fn matched_ui(ui: &mut Ui, description: &Description, medium: &str) {
    let matched = matched(description, medium);
    if matched.is_empty() {
        return;
    }
    let text = format!("= Same index as {}: the surface between them is invisible.", matched.join(", "));
    ui.add(Label::new(note(ui, text)).wrap());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_refused_in_words() {
        let description = crate::formats::open("nested-spheres").unwrap();
        let [first, second] = [0, 1].map(|index| description.media[index].name.clone());
        assert_eq!(name(&description, &first, "  soup "), Ok("soup".to_owned()));
        assert_eq!(name(&description, &first, &first), Ok(first.clone()));
        for (text, reason) in [("", "needs a name"), ("world", "reserved"), (second.as_str(), "already")] {
            let refusal = name(&description, &first, text).unwrap_err();
            assert!(refusal.0.contains(reason), "{refusal}");
        }
    }
}
