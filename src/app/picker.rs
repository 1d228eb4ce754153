//! A list to choose from with a field to search it, behind a button. With the keyboard alone: Enter opens it, typing searches, arrow keys
//! move, Enter chooses, Escape closes.

use egui::{
    Atom, AtomExt, Button, Color32, Id, Key, Label, Modifiers, Popup, PopupCloseBehavior, Response, RichText,
    ScrollArea, TextEdit, Ui, UiBuilder, vec2,
};

use super::theme::Palette;
use super::widgets::{note, swatch_ui};

const HEIGHT: f32 = 300.0;

/// Something that can be chosen.
pub struct Item {
    /// What it stands under. Items of one group follow each other.
    pub group: &'static str,
    pub name: String,
    /// At the right, in digits.
    pub detail: String,
    pub color: Option<Color32>,
    pub about: String,
    /// Other words by which it is found.
    pub words: String,
    pub is_chosen: bool,
}

/// What is kept while the list is open.
#[derive(Debug, Clone, Default)]
struct Search {
    text: String,
    /// Among the items that are found.
    at: usize,
    is_open: bool,
}

/// A button over the width that is left, with `text` on it; `name` is for screen readers. Returns the index of what has been chosen.
pub fn picker_ui(
    ui: &mut Ui,
    id: Id,
    text: &str,
    name: &str,
    about: &str,
    items: impl FnOnce() -> Vec<Item>,
) -> Option<usize> {
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    let arrow = RichText::new("▼").size(8.0).color(Palette::of(ui).weak_text);
    let label: Atom<'_> = RichText::new(text).atom_shrink(true);
    let button = Button::new(label).right_text(arrow).min_size(size).truncate();
    // The focus stays although rows above come and go.
    let place = UiBuilder::new().scope_id(id.with("button"));
    let response = ui.scope_builder(place, |ui| ui.add_sized(size, button)).inner.on_hover_text(about);
    response.widget_info(|| {
        let mut info = egui::WidgetInfo::labeled(egui::Role::ComboBox, ui.is_enabled(), name);
        info.current_text_value = Some(text.to_owned());
        info
    });
    let mut chosen = None;
    let mut search: Search = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let popup = Popup::from_toggle_button_response(&response).id(id.with("popup"));
    let is_open = Popup::is_id_open(ui.ctx(), id.with("popup")) || response.clicked();
    popup.close_behavior(PopupCloseBehavior::CloseOnClickOutside).width(response.rect.width().max(230.0)).show(|ui| {
        let items = items();
        if !search.is_open {
            search = Search { is_open: true, ..Search::default() };
            let found = found(&items, "");
            search.at = found.iter().position(|&index| items[index].is_chosen).unwrap_or(0);
        }
        chosen = list_ui(ui, id, &items, &mut search);
        if chosen.is_some() {
            ui.close();
        }
    });
    if !is_open && search.is_open {
        search.is_open = false;
    }
    if chosen.is_some() {
        search.is_open = false;
        response.request_focus();
    }
    ui.data_mut(|data| data.insert_temp(id, search));
    chosen
}

fn list_ui(ui: &mut Ui, id: Id, items: &[Item], search: &mut Search) -> Option<usize> {
    let search_id = id.with("search");
    let steps = ui.input_mut(|input| {
        let mut count = |key| input.count_and_consume_key(Modifiers::NONE, key) as isize;
        count(Key::ArrowDown) - count(Key::ArrowUp) + 8 * (count(Key::PageDown) - count(Key::PageUp))
    });
    let is_new = ui.memory(egui::Memory::focused) != Some(search_id);
    let edit = TextEdit::singleline(&mut search.text).id(search_id).hint_text("Search").desired_width(f32::INFINITY);
    let response = ui.add(edit).accessible_name("Search");
    let is_entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    if is_new && !is_entered {
        response.request_focus();
    }
    if response.changed() {
        search.at = 0;
    }
    let found = found(items, &search.text);
    let last = found.len().saturating_sub(1);
    search.at = search.at.saturating_add_signed(steps).min(last);
    if is_entered {
        return found.get(search.at).copied();
    }
    let mut chosen = None;
    ScrollArea::vertical().max_height(HEIGHT).auto_shrink([false, true]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        let mut group = "";
        for (place, &index) in found.iter().enumerate() {
            let item = &items[index];
            if item.group != group {
                group = item.group;
                ui.add_space(3.0);
                ui.add(Label::new(note(ui, group)));
            }
            let response = item_ui(ui, item, place == search.at);
            if place == search.at && (steps != 0 || response_is_first(ui, id)) {
                response.scroll_to_me(None);
            }
            if response.clicked() {
                chosen = Some(index);
            }
        }
        if found.is_empty() {
            ui.label(note(ui, "Nothing is called so."));
        }
    });
    chosen
}

/// Whether the list is shown for the first time since it was opened.
fn response_is_first(ui: &Ui, id: Id) -> bool {
    let frame = ui.ctx().cumulative_frame_nr();
    let key = id.with("last frame");
    let last = ui.data(|data| data.get_temp::<u64>(key));
    ui.data_mut(|data| data.insert_temp(key, frame));
    last.is_none_or(|last| last + 1 < frame)
}

fn item_ui(ui: &mut Ui, item: &Item, is_at: bool) -> Response {
    let palette = Palette::of(ui);
    ui.horizontal(|ui| {
        match item.color {
            Some(color) => _ = swatch_ui(ui, color),
            None => ui.add_space(16.0),
        }
        let detail = RichText::new(&item.detail).monospace().small().color(palette.weak_text);
        let text = RichText::new(&item.name);
        let text = if item.is_chosen { text.color(palette.accent) } else { text };
        let button = Button::selectable(is_at, text.atom_shrink(true)).right_text(detail).truncate();
        let response = ui.add_sized(vec2(ui.available_width(), ui.spacing().interact_size.y), button);
        response.widget_info(|| egui::WidgetInfo::selected(egui::Role::ListItem, true, item.is_chosen, &item.name));
        if item.about.is_empty() { response } else { response.on_hover_text(&item.about) }
    })
    .inner
}

/// The items whose name, group or other words contain every word of the text.
fn found(items: &[Item], text: &str) -> Vec<usize> {
    let wanted: Vec<String> = text.to_lowercase().split_whitespace().map(str::to_owned).collect();
    let fits = |item: &Item| {
        let all = format!("{} {} {}", item.name, item.group, item.words).to_lowercase();
        wanted.iter().all(|word| all.contains(word.as_str()))
    };
    (0..items.len()).filter(|&index| fits(&items[index])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_must_be_found() {
        let item = |group, name: &str, words: &str| Item {
            group,
            name: name.to_owned(),
            detail: String::new(),
            color: None,
            about: String::new(),
            words: words.to_owned(),
            is_chosen: false,
        };
        let items = [
            item("Glasses", "Crown glass N-BK7", "n-bk7"),
            item("Liquids", "Water", "water"),
            item("Glasses", "SF11", ""),
        ];
        assert_eq!(found(&items, ""), [0, 1, 2]);
        assert_eq!(found(&items, "bk7"), [0]);
        assert_eq!(found(&items, "  GLASS sf"), [2]);
        assert_eq!(found(&items, "glass"), [0, 2]);
        assert!(found(&items, "glass water").is_empty());
    }
}
