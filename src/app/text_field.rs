//! A field for text that must mean something. What does not is refused: the value stays, and the reason is there to be shown.

use egui::text::CCursorRange;
use egui::{
    Align, Align2, Id, Key, Label, Popup, PopupCloseBehavior, Response, RichText, Stroke, TextEdit, TextStyle, Ui, vec2,
};

use super::entry::Refusal;
use super::theme::{ERROR_MARK, Palette};

/// A field for what is written as `shown`.
pub struct TextField<'a> {
    pub id: Id,
    pub shown: &'a str,
    /// For screen readers.
    pub name: String,
    pub about: String,
    pub width: f32,
    pub align: Align,
    pub style: TextStyle,
}

/// What came of a frame.
pub struct Typed<T> {
    pub response: Response,
    /// The new value, once it has been typed in full.
    pub taken: Option<T>,
    /// Why the last text was refused; until it is edited, or the value changes.
    pub refusal: Option<Refusal>,
    /// The text while it is being edited.
    pub draft: Option<String>,
}

/// What has been typed and not been taken.
#[derive(Debug, Clone)]
struct Draft {
    text: String,
    refusal: Option<Refusal>,
    /// What was shown before.
    before: String,
}

impl TextField<'_> {
    /// Enter or leaving the field takes what `read` makes of the text, Escape drops it.
    pub fn show<T>(self, ui: &mut Ui, read: impl Fn(&str) -> Result<T, Refusal>) -> Typed<T> {
        let Self { id, shown, .. } = self;
        // Where the value has changed elsewhere, what was typed is about one that is gone.
        let mut draft = ui.data(|data| data.get_temp::<Draft>(id)).filter(|draft| draft.before == shown);
        let mut text = draft.as_ref().map_or_else(|| shown.to_owned(), |draft| draft.text.clone());
        let has_fault = draft.as_ref().is_some_and(|draft| draft.refusal.is_some());
        let size = vec2(self.width, ui.spacing().interact_size.y);
        let response = ui
            .scope(|ui| {
                if has_fault {
                    let stroke = Stroke::new(1.0, Palette::of(ui).error);
                    let widgets = &mut ui.visuals_mut().widgets;
                    (widgets.inactive.bg_stroke, widgets.hovered.bg_stroke) = (stroke, stroke);
                }
                let edit =
                    TextEdit::singleline(&mut text).id(id).font(self.style).align(Align2([self.align, Align::Center]));
                ui.add_sized(size, edit.margin(vec2(4.0, 2.0)))
            })
            .inner;
        if response.gained_focus() {
            let mut state = TextEdit::load_state(ui.ctx(), id).unwrap_or_default();
            state.cursor.set_char_range(Some(CCursorRange::select_all_str(&text)));
            state.store(ui.ctx(), id);
        }
        if response.changed() {
            draft = Some(Draft { text, refusal: None, before: shown.to_owned() });
        }
        let mut taken = None;
        if response.lost_focus() && ui.input(|input| input.key_pressed(Key::Escape)) {
            draft = None;
        } else if response.lost_focus()
            && let Some(typed) = draft.take()
        {
            match read(&typed.text) {
                Ok(value) => taken = Some(value),
                Err(refusal) => draft = Some(Draft { refusal: Some(refusal), ..typed }),
            }
        }
        let refusal = draft.as_ref().and_then(|draft| draft.refusal.clone());
        let edited = draft.as_ref().filter(|draft| draft.refusal.is_none()).map(|draft| draft.text.clone());
        ui.data_mut(|data| match draft {
            Some(draft) => _ = data.insert_temp(id, draft),
            None => data.remove::<Draft>(id),
        });
        let response = response.accessible_name(self.name).on_hover_text(self.about);
        Typed { response, taken, refusal, draft: edited }
    }
}

/// Why a text was refused, under its field. `stays` is what there is still.
pub fn refusal_ui(ui: &mut Ui, refusal: &Refusal, stays: &str) {
    let palette = Palette::of(ui);
    ui.horizontal_top(|ui| {
        ui.label(RichText::new(ERROR_MARK).small().color(palette.error));
        let text = if stays.is_empty() { refusal.to_string() } else { format!("{refusal} It stays {stays}.") };
        ui.add(Label::new(RichText::new(text).small()).wrap());
    });
}

/// [`refusal_ui`] for a field with no room below it: over what is there, which can still be clicked.
pub fn refusal_popup_ui(response: &Response, refusal: &Refusal, stays: &str) {
    let popup = Popup::from_response(response).id(response.id.with("refusal")).open(true).gap(4.0);
    popup.close_behavior(PopupCloseBehavior::IgnoreClicks).interactable(false).show(|ui| {
        ui.set_max_width(240.0);
        refusal_ui(ui, refusal, stays);
    });
}
