//! Which of a file's channels are the picture.

use std::collections::BTreeMap;

use exr::meta::header::Header;

use super::shown;
use crate::scene::LoadNote;

/// Channels of one part that make a picture together, by their places in its list.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Colors {
    Rgb([usize; 3]),
    Xyz([usize; 3]),
    Luminance(usize),
    /// Chroma is (R − Y) / Y and (B − Y) / Y, usually of every second pixel in every second row.
    LuminanceChroma {
        y: usize,
        ry: usize,
        by: usize,
    },
}

/// The picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layer {
    /// Index of the part (the header).
    pub part: usize,
    /// By which people know it: the part's name and what stands before the last point in those of the channels.
    name: String,
    pub colors: Colors,
}

/// Channel indices by what stands after the last point in their names, in capitals.
type Group = BTreeMap<String, usize>;

impl Layer {
    /// The first with colours: those with plain names (`R`) before those of named layers (`diffuse.R`), RGB before others. Says so when
    /// there are several. An error: no part holds a picture.
    pub fn choose(headers: &[Header]) -> Result<(Self, Option<LoadNote>), String> {
        let mut layers: Vec<(bool, Self)> = Vec::new();
        for (part, header) in headers.iter().enumerate() {
            let mut groups: BTreeMap<String, Group> = BTreeMap::new();
            for (index, channel) in header.channels.list.iter().enumerate() {
                let name = channel.name.to_string();
                let (group, last) = name.rsplit_once('.').unwrap_or(("", &name));
                groups.entry(group.to_owned()).or_default().entry(last.to_ascii_uppercase()).or_insert(index);
            }
            for (group, channels) in groups {
                let Some(colors) = colors(&channels, group.is_empty()) else { continue };
                let of_part = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
                let names = of_part.into_iter().chain([group.clone()]).filter(|name| !name.is_empty());
                let name = names.collect::<Vec<_>>().join(".");
                layers.push((!group.is_empty(), Self { part, name, colors }));
            }
        }
        // Stable: of equals, the first in the file.
        layers.sort_by_key(|(is_named, layer)| (*is_named, !matches!(layer.colors, Colors::Rgb(_))));
        let mut layers = layers.into_iter().map(|(_, layer)| layer);
        let Some(chosen) = layers.next() else {
            let channels = headers.iter().flat_map(|header| &header.channels.list);
            let names: Vec<String> = channels.map(|channel| channel.name.to_string()).collect();
            return Err(format!(
                "has no picture: it needs channels R, G and B, or Y (with or without RY and BY), or X, Y and Z, but has {}",
                shown(names.iter().map(String::as_str))
            ));
        };
        let others: Vec<Self> = layers.collect();
        let read = if chosen.name.is_empty() { "the one without a name".into() } else { shown([&*chosen.name]) };
        let rest = shown(others.iter().map(|other| if other.name.is_empty() { "(no name)" } else { &other.name }));
        let message = format!("the file holds several pictures: read {read}, passed over {rest}");
        let note = (!others.is_empty()).then(|| LoadNote::new("chosen_layer", others.len() as u64, message));
        Ok((chosen, note))
    }
}

/// XYZ only counts with plain names: those of a named layer are usually places or normals.
fn colors(channels: &Group, is_plain: bool) -> Option<Colors> {
    let at = |name: &str| channels.get(name).copied();
    if let (Some(r), Some(g), Some(b)) = (at("R"), at("G"), at("B")) {
        return Some(Colors::Rgb([r, g, b]));
    }
    if let (Some(x), Some(y), Some(z)) = (at("X"), at("Y"), at("Z")) {
        return is_plain.then_some(Colors::Xyz([x, y, z]));
    }
    match (at("Y"), at("RY"), at("BY")) {
        (Some(y), Some(ry), Some(by)) => Some(Colors::LuminanceChroma { y, ry, by }),
        (Some(y), ..) => Some(Colors::Luminance(y)),
        _ => None,
    }
}
