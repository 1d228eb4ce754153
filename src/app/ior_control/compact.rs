//! The control in a row of the tree: the name of a medium of the catalogue, the index with four decimals, and a thin rail on which the
//! scene's own media are marked.

use egui::{Align, Align2, Id, Layout, Rect, Sense, Ui, UiBuilder, pos2, vec2};

use super::field::{taken, typed_ui};
use super::rail::Rail;
use super::{Change, Drag, Subject, describe, marked, paint, rail_change, short_name, shown};
use crate::app::text_field::refusal_popup_ui;
use crate::app::theme::Palette;
use crate::optics::Ior;

/// Width that the control takes.
pub const COMPACT_WIDTH: f32 = 128.0;
const FIELD_WIDTH: f32 = 62.0;
const RAIL_HEIGHT: f32 = 3.0;

/// The control within `rect`, about 28 points high.
pub fn compact_ui(ui: &mut Ui, rect: Rect, id: Id, subject: &Subject<'_>) -> Change {
    // Rows of one medium have controls of one name: each in a part of its own.
    let ui = &mut ui.new_child(UiBuilder::new().max_rect(rect).id_salt(id));
    let lower = Rect::from_min_max(pos2(rect.left(), rect.bottom() - 11.0), rect.max);
    let track =
        Rect::from_center_size(pos2(rect.center().x, rect.bottom() - 6.0), vec2(rect.width() - 8.0, RAIL_HEIGHT));
    let response = ui.interact(lower, id.with("rail"), Sense::drag());
    let drag = ui.data(|data| data.get_temp::<Drag>(id));
    let rail = drag.map_or_else(|| Rail::around(subject.model.ior()), |drag| drag.rail);
    let change = rail_change(ui, id, &response, track, &rail, subject.model, |_| None);
    paint::thin(ui, &response, track, &rail, subject);
    let name = format!("IOR of {}", subject.name);
    describe(ui, &response, &rail, subject.model.ior(), &name);
    response.on_hover_ui(|ui| {
        ui.label(format!(
            "Index of refraction of {}. Drag; it snaps to media of the catalogue unless Ctrl or Alt is held, and moves finely with Shift.",
            subject.name
        ));
        if !subject.others.is_empty() {
            ui.label(marked(subject.others));
        }
    });

    let upper = Rect::from_min_max(rect.min, pos2(rect.right(), lower.top()));
    let layout = Layout::right_to_left(Align::Center);
    let mut upper = ui.new_child(UiBuilder::new().max_rect(upper).id_salt(id).layout(layout));
    upper.spacing_mut().interact_size.y = 16.0;
    let typed = typed_ui(&mut upper, id.with("field"), subject, &name, FIELD_WIDTH, Align::Max);
    if let Some(refusal) = &typed.refusal {
        refusal_popup_ui(&typed.response, refusal, &shown(subject.model.ior()));
    }
    if let Ior::Catalog(entry) = subject.model {
        let at = pos2(typed.response.rect.left() - 4.0, typed.response.rect.center().y);
        paint::small_text(&upper, at, Align2::RIGHT_CENTER, &short_name(entry.name), Palette::of(&upper).weak_text);
    }
    change.or(taken(typed, subject))
}
