//! The list of media to choose from: those of the scene, and the catalogue.

use egui::{Id, Ui};

use super::{color, users};
use crate::app::picker::{Item, picker_ui};
use crate::app::theme::Palette;
use crate::optics::{Ior, catalog};
use crate::scene::Description;

/// What has been chosen.
pub enum Choice {
    /// A medium of the scene, by name.
    InScene(String),
    Catalog(&'static catalog::Entry),
}

const IN_SCENE: &str = "In this scene";
const GROUPS: [&str; 5] = ["Gases", "Water, ice and other liquids", "Glasses", "Plastics", "Crystals"];

/// The part of the catalogue that an entry stands in.
fn group(entry: &catalog::Entry) -> &'static str {
    GROUPS[match entry.name {
        "air" => 0,
        "pmma" | "acrylic" => 3,
        "sapphire" | "diamond" => 4,
        _ if matches!(entry.model, Ior::Gas(_)) => 0,
        "ice" | "water" | "ethanol" | "glycerol" => 1,
        _ => 2,
    }]
}

/// The index and, where there is one, Abbe's number.
fn detail(ior: &Ior) -> String {
    match ior.abbe_number() {
        Some(abbe) => format!("{:.4}  V {abbe:4.1}", ior.ior()),
        None => format!("{:.4}        ", ior.ior()),
    }
}

fn of_catalog(entry: &'static catalog::Entry, is_chosen: bool) -> Item {
    Item {
        group: group(entry),
        name: entry.label.to_owned(),
        detail: detail(&entry.model),
        color: None,
        about: entry.source.to_owned(),
        words: entry.name.to_owned(),
        is_chosen,
    }
}

/// The catalogue's entries, those of one group together.
fn catalog_in_groups() -> impl Iterator<Item = &'static catalog::Entry> {
    GROUPS.into_iter().flat_map(|wanted| catalog::ALL.iter().filter(move |entry| group(entry) == wanted))
}

/// A list of the scene's media, then the catalogue: what an object is made of. Those of the catalogue that the scene has already stand
/// among the scene's.
pub fn medium_ui(ui: &mut Ui, description: &Description, object: &str, medium: &str) -> Option<Choice> {
    let palette = Palette::of(ui);
    let about = "What the object is made of. A medium of the catalogue is added to the scene.";
    let has = |entry: &catalog::Entry| {
        description.media.iter().any(|medium| matches!(medium.ior, Ior::Catalog(known) if known.name == entry.name))
    };
    let index =
        picker_ui(ui, Id::unique(("medium of", object)), medium, &format!("Medium of {object}"), about, || {
            let of_scene = description.media.iter().map(|known| {
                let users = users(description, &known.name);
                Item {
                    group: IN_SCENE,
                    name: known.name.clone(),
                    detail: detail(&known.ior),
                    color: Some(color(&palette, description, &known.name)),
                    about: if users.is_empty() { "No object is made of it.".to_owned() } else { users.join(", ") },
                    words: if let Ior::Catalog(entry) = &known.ior { entry.label.to_owned() } else { String::new() },
                    is_chosen: known.name == medium,
                }
            });
            of_scene
                .chain(catalog_in_groups().filter(|entry| !has(entry)).map(|entry| of_catalog(entry, false)))
                .collect()
        })?;
    match description.media.get(index) {
        Some(known) => Some(Choice::InScene(known.name.clone())),
        None => {
            let mut rest = catalog_in_groups().filter(|entry| !has(entry));
            rest.nth(index - description.media.len()).map(Choice::Catalog)
        }
    }
}

/// The catalogue alone: the index that a medium is to have.
pub fn preset_ui(ui: &mut Ui, medium: &str, model: &Ior) -> Option<&'static catalog::Entry> {
    let text = if let Ior::Catalog(entry) = model { entry.label } else { "Not from the catalogue" };
    let about = "Media with measured indices of refraction, with their dispersion.";
    let name = format!("Catalogue for {medium}");
    let index = picker_ui(ui, Id::unique(("catalogue for", medium)), text, &name, about, || {
        let is_chosen = |entry: &catalog::Entry| matches!(model, Ior::Catalog(chosen) if chosen.name == entry.name);
        catalog_in_groups().map(|entry| of_catalog(entry, is_chosen(entry))).collect()
    })?;
    catalog_in_groups().nth(index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_stands_in_one_group() {
        let mut names: Vec<&str> = catalog_in_groups().map(|entry| entry.name).collect();
        assert_eq!(names.len(), catalog::ALL.len());
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), catalog::ALL.len());
        assert_eq!(group(catalog::find("water").unwrap()), "Water, ice and other liquids");
        assert_eq!(group(catalog::find("sf11").unwrap()), "Glasses");
    }
}
