//! Small pieces that several panels are made of.

mod vector;

use std::cell::RefCell;
use std::ops::RangeInclusive;

use egui::{
    Align, AsIdSalt, Color32, ComboBox, DragValue, Key, Layout, Response, RichText, ScrollArea, Sense, Ui, Vec2,
    WidgetText,
};

pub use self::vector::{RGB, Triple, XYZ, color_ui, vector_ui};
use super::command::Command;
use super::entry::{self, Refusal};
use super::modal;
use super::text_field::refusal_popup_ui;
use super::theme::{self, Palette, SECTION_GAP};

/// A section's title with a line under it. `detail` stands at the right.
pub fn section_ui(ui: &mut Ui, title: &str, detail: &str) {
    ui.add_space(SECTION_GAP - ui.spacing().item_spacing.y);
    section_first_ui(ui, title, detail);
}

/// [`section_ui`] without the space above.
pub fn section_first_ui(ui: &mut Ui, title: &str, detail: &str) {
    let palette = Palette::of(ui);
    ui.horizontal(|ui| {
        let text = RichText::new(title.to_uppercase()).text_style(theme::section_style()).color(palette.weak_text);
        ui.label(text.extra_letter_spacing(0.8));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.label(RichText::new(detail).text_style(theme::small_mono_style()).color(palette.weak_text));
        });
    });
    let rect = ui.allocate_exact_size(Vec2::new(ui.available_width(), 1.0), Sense::hover()).0;
    ui.painter().hline(rect.x_range(), rect.center().y, egui::Stroke::new(1.0, palette.line));
    ui.add_space(2.0);
}

/// A row with a name at the left and a control that takes the rest of the width.
pub fn row_ui<R>(ui: &mut Ui, name: &str, about: &str, add: impl FnOnce(&mut Ui) -> R) -> R {
    sized_row_ui(ui, 84.0, name, about, add)
}

/// [`row_ui`] with a width for the name.
pub fn sized_row_ui<R>(ui: &mut Ui, name_width: f32, name: &str, about: &str, add: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        let (rect, response) = ui.allocate_exact_size(Vec2::new(name_width, height), Sense::hover());
        let mut label =
            ui.new_child(egui::UiBuilder::new().max_rect(rect).layout(Layout::left_to_right(Align::Center)));
        label.add(egui::Label::new(name).truncate());
        if !about.is_empty() {
            response.on_hover_text(about);
        }
        ui.name_inputs(name, add)
    })
    .inner
}

/// Buttons of which one is chosen, joined to a bar that fills the width. Returns what was clicked.
pub fn segmented_ui<T: PartialEq + Copy>(ui: &mut Ui, chosen: T, options: &[(T, &str, &str)]) -> Option<T> {
    segmented_where_ui(ui, chosen, options, |_| true)
}

/// [`segmented_ui`] some of whose buttons cannot be clicked.
pub fn segmented_where_ui<T: PartialEq + Copy>(
    ui: &mut Ui,
    chosen: T,
    options: &[(T, &str, &str)],
    is_enabled: impl Fn(T) -> bool,
) -> Option<T> {
    let mut clicked = None;
    let gap = 2.0;
    let width = (ui.available_width() - gap * (options.len() as f32 - 1.0)) / options.len() as f32;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = gap;
        ui.spacing_mut().button_padding.x = 2.0;
        for (value, name, about) in options {
            let button = egui::Button::selectable(*value == chosen, *name)
                .frame_when_inactive(true)
                .min_size(Vec2::new(width, ui.spacing().interact_size.y));
            let add = |ui: &mut Ui| ui.add_sized([width, ui.spacing().interact_size.y], button);
            let response = ui.add_enabled_ui(is_enabled(*value), add).inner;
            let response =
                if about.is_empty() { response } else { response.on_hover_text(*about).on_disabled_hover_text(*about) };
            if response.clicked() {
                clicked = Some(*value);
            }
        }
    });
    clicked
}

/// [`segmented_ui`] in a [`row_ui`].
pub fn segmented_row_ui<T: PartialEq + Copy>(
    ui: &mut Ui,
    name: &str,
    about: &str,
    chosen: T,
    options: &[(T, &str, &str)],
) -> Option<T> {
    row_ui(ui, name, about, |ui| segmented_ui(ui, chosen, options))
}

/// A list to choose from, over the width that is left. It is as high as the window allows, and scrolls beyond.
pub fn combo_ui(ui: &mut Ui, id: impl AsIdSalt, text: impl Into<WidgetText>, contents: impl FnOnce(&mut Ui)) {
    let combo = ComboBox::from_id_salt(id).selected_text(text.into()).width(ui.available_width());
    combo.height(list_room(ui)).truncate().show_ui(ui, |ui| {
        contents(ui);
        modal::scroll_to_focus(ui);
    });
}

/// The contents of a menu: as high as the window allows, and scrolled beyond.
pub fn menu_ui(ui: &mut Ui, contents: impl FnOnce(&mut Ui)) {
    let room = list_room(ui);
    modal::scroll_ui(ui, ScrollArea::vertical().max_height(room).min_scrolled_height(room), contents);
}

/// The height of the longest list that fits into the window.
fn list_room(ui: &Ui) -> f32 {
    const MARGINS: f32 = 24.0;
    (ui.ctx().content_rect().height() - MARGINS).max(60.0)
}

/// A number to drag or to type, as a calculation too, `width` points wide. What is refused leaves the number, and a note at the field says
/// why. Returns whether it has changed.
pub fn number_ui(
    ui: &mut Ui,
    width: f32,
    drag: DragValue<'_>,
    label: impl Into<String>,
    about: impl Into<String>,
) -> bool {
    typed_ui(ui, width, drag, entry::number, label, about)
}

/// [`number_ui`] for numbers within `range`: dragging ends there, and what is typed beyond is refused.
pub fn number_within_ui(
    ui: &mut Ui,
    width: f32,
    range: RangeInclusive<f64>,
    drag: DragValue<'_>,
    label: impl Into<String>,
    about: impl Into<String>,
) -> bool {
    typed_ui(ui, width, drag.range(range.clone()), |text| entry::number_within(text, &range), label, about)
}

/// [`number_within_ui`] for whole numbers.
pub fn whole_ui(
    ui: &mut Ui,
    width: f32,
    range: RangeInclusive<i64>,
    drag: DragValue<'_>,
    label: impl Into<String>,
    about: impl Into<String>,
) -> bool {
    typed_ui(ui, width, drag.range(range.clone()), |text| entry::whole(text, &range), label, about)
}

fn typed_ui(
    ui: &mut Ui,
    width: f32,
    drag: DragValue<'_>,
    read: impl Fn(&str) -> Result<f64, Refusal>,
    label: impl Into<String>,
    about: impl Into<String>,
) -> bool {
    let refused: RefCell<Option<Refusal>> = RefCell::new(None);
    let read = |text: &str| read(text).map_err(|refusal| refused.replace(Some(refusal))).ok();
    let drag = drag.update_while_editing(false).custom_parser(read);
    let response = ui.add_sized([width, ui.spacing().interact_size.y], drag);
    // egui takes what was typed before Escape one frame later.
    let pass = ui.ctx().cumulative_pass_nr();
    let escaped = response.id.with("escaped");
    if response.lost_focus() && ui.input(|input| input.key_pressed(Key::Escape)) {
        ui.data_mut(|data| data.insert_temp(escaped, pass));
    }
    let is_given_up = ui.data(|data| data.get_temp::<u64>(escaped)).is_some_and(|at| pass <= at + 2);
    refused_ui(ui, &response, refused.take().filter(|_| !is_given_up));
    response.accessible_name(label).on_hover_text(about.into()).changed() && !is_given_up
}

/// Says at a number's field why the text was refused that was typed last, until the user goes on.
fn refused_ui(ui: &Ui, response: &Response, refused: Option<Refusal>) {
    let id = response.id.with("refused");
    if let Some(refusal) = refused {
        ui.data_mut(|data| data.insert_temp(id, refusal));
    } else if let Some(refusal) = ui.data(|data| data.get_temp::<Refusal>(id)) {
        let goes_on = ui.input(|input| input.pointer.any_pressed() || input.events.iter().any(is_key));
        if goes_on {
            ui.data_mut(|data| data.remove::<Refusal>(id));
        } else {
            refusal_popup_ui(response, &refusal, "as it was");
        }
    }
}

/// A ring around a control that paints itself, while it has the focus of the keyboard.
pub fn focus_ring(ui: &Ui, response: &Response) {
    if response.has_focus() {
        let stroke = egui::Stroke::new(1.5, Palette::of(ui).accent);
        ui.painter().rect_stroke(response.rect, 4.0, stroke, egui::StrokeKind::Inside);
    }
}

fn is_key(event: &egui::Event) -> bool {
    matches!(event, egui::Event::Key { pressed: true, .. } | egui::Event::Text(_))
}

/// A button that gives a command.
pub fn button_ui(ui: &mut Ui, text: &str, about: &str, commands: &mut Vec<Command>, command: Command) {
    if ui.button(text).on_hover_text(about).clicked() {
        commands.push(command);
    }
}

/// A small square of a medium's colour.
pub fn swatch_ui(ui: &mut Ui, color: Color32) -> Response {
    let (rect, response) = ui.allocate_exact_size(Vec2::new(10.0, ui.spacing().interact_size.y), Sense::hover());
    let square = egui::Rect::from_center_size(rect.center(), Vec2::splat(10.0));
    ui.painter().rect_filled(square, 2.5, color);
    let edge = egui::Stroke::new(1.0, Color32::from_black_alpha(70));
    ui.painter().rect_stroke(square, 2.5, edge, egui::StrokeKind::Inside);
    response
}

/// A value in monospaced digits.
pub fn value(text: impl Into<String>) -> RichText {
    RichText::new(text).text_style(theme::small_mono_style())
}

/// Secondary text.
pub fn note(ui: &Ui, text: impl Into<String>) -> RichText {
    RichText::new(text).small().color(Palette::of(ui).weak_text)
}

/// A name at the left and a value at the right, in small type.
pub fn fact_ui(ui: &mut Ui, name: &str, text: impl Into<String>, about: &str) {
    let response = ui
        .horizontal(|ui| {
            ui.label(RichText::new(name).small());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.add(egui::Label::new(value(text)).truncate()));
        })
        .response;
    if !about.is_empty() {
        response.on_hover_text(about);
    }
}

/// A count in at most four characters and a prefix: "12", "3.4 k", "1.2 M".
pub fn short_count(count: f64) -> String {
    let (size, unit) = match count {
        c if c >= 1e9 => (c / 1e9, " G"),
        c if c >= 1e6 => (c / 1e6, " M"),
        c if c >= 1e3 => (c / 1e3, " k"),
        c => return format!("{c:.0}"),
    };
    if size < 99.95 { format!("{size:.1}{unit}") } else { format!("{size:.0}{unit}") }
}

/// A duration in seconds in at most six characters.
pub fn short_seconds(seconds: f64) -> String {
    match seconds {
        s if s >= 9999.5 => format!("{:.1} h", s / 3600.0),
        s if s >= 9.95 => format!("{s:.0} s"),
        s if s >= 0.995 => format!("{s:.1} s"),
        s if s >= 9.95e-4 => format!("{:.0} ms", s * 1e3),
        s => format!("{:.0} µs", s * 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_readable() {
        assert_eq!(short_count(950.0), "950");
        assert_eq!(short_count(3_100_000.0), "3.1 M");
        assert_eq!([99_940.0, 99_960.0, 121_800.0].map(short_count), ["99.9 k", "100 k", "122 k"]);
        let short = [0.000_5, 0.012, 1.0, 9.99, 75.0, 36_000.0].map(short_seconds);
        assert_eq!(short, ["500 µs", "12 ms", "1.0 s", "10 s", "75 s", "10.0 h"]);
    }
}
