//! Three numbers in a row, each with its letter: places and directions with x y z, colours with r g b.

use std::ops::RangeInclusive;

use egui::{DragValue, Label, RichText, Ui, vec2};
use glam::DVec3;

use super::number_within_ui;
use crate::app::theme::Palette;

/// Letters and names of coordinates and of colours.
pub const XYZ: [[&str; 2]; 3] = [["x", "x"], ["y", "y"], ["z", "z"]];
pub const RGB: [[&str; 2]; 3] = [["r", "red"], ["g", "green"], ["b", "blue"]];

const LETTER_WIDTH: f32 = 8.0;
const LETTER_GAP: f32 = 2.0;
const GAP: f32 = 5.0;

/// What three numbers are, and how they are dragged.
pub struct Triple<'a> {
    /// Letter and name of each.
    pub parts: [[&'a str; 2]; 3],
    /// What stands before the name of a part, for screen readers: "Move ball along".
    pub label: &'a str,
    pub about: &'a str,
    /// Change of each per point of a drag.
    pub speeds: [f64; 3],
    pub range: RangeInclusive<f64>,
    pub suffix: &'a str,
    /// Most decimals that are shown; what was typed is kept in full.
    pub decimals: usize,
}

impl<'a> Triple<'a> {
    /// Of any finite numbers.
    pub fn new(parts: [[&'a str; 2]; 3], label: &'a str, about: &'a str) -> Self {
        Self { parts, label, about, speeds: [0.01; 3], range: f64::MIN..=f64::MAX, suffix: "", decimals: 3 }
    }

    /// The fields over the width that is left, less `reserved` points. Returns which number has changed, and all of them.
    pub fn show(&self, ui: &mut Ui, values: [f64; 3], reserved: f32) -> Option<(usize, [f64; 3])> {
        let height = ui.spacing().interact_size.y;
        let letter = LETTER_WIDTH + LETTER_GAP;
        let width = ((ui.available_width() - reserved - 2.0 * GAP) / 3.0 - letter).max(16.0);
        let mut edited = values;
        let mut changed = None;
        let gap = std::mem::replace(&mut ui.spacing_mut().item_spacing.x, LETTER_GAP);
        let padding = std::mem::replace(&mut ui.spacing_mut().button_padding.x, 2.0);
        for (index, [letter, name]) in self.parts.into_iter().enumerate() {
            if index > 0 {
                ui.add_space(GAP - LETTER_GAP);
            }
            let text = RichText::new(letter).small().color(Palette::of(ui).weak_text);
            ui.add_sized(vec2(LETTER_WIDTH, height), Label::new(text));
            let drag = DragValue::new(&mut edited[index])
                .speed(self.speeds[index])
                .suffix(self.suffix)
                .max_decimals(self.decimals);
            let about = format!("{}\nThis one is {name}.", self.about);
            let (range, label) = (self.range.clone(), format!("{} {name}", self.label));
            if number_within_ui(ui, width, range, drag, label, about) && edited[index] != values[index] {
                changed = Some(index);
            }
        }
        ui.spacing_mut().item_spacing.x = gap;
        ui.spacing_mut().button_padding.x = padding;
        changed.map(|index| (index, edited))
    }
}

/// Three coordinates. Returns them if they have changed.
pub fn vector_ui(ui: &mut Ui, triple: &Triple<'_>, vector: DVec3) -> Option<DVec3> {
    triple.show(ui, vector.to_array(), 0.0).map(|(_, values)| values.into())
}

/// Three components of a colour. Returns them if they have changed.
pub fn color_ui(ui: &mut Ui, triple: &Triple<'_>, color: [f64; 3]) -> Option<[f64; 3]> {
    triple.show(ui, color, 0.0).map(|(_, values)| values)
}
