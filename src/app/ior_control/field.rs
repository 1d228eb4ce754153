//! A field for an index, as a number, a calculation or a name.

use egui::{Align, Id, Label, RichText, TextStyle, Ui};

use super::{Change, Subject, in_words, shown};
use crate::app::entry;
use crate::app::text_field::{TextField, Typed, refusal_ui};
use crate::app::theme::Palette;
use crate::app::widgets::note;
use crate::optics::Ior;

const WIDTH: f32 = 92.0;

/// The field with words at its right, what the index is, and a line under it while something is typed or has been refused.
pub fn field_ui(ui: &mut Ui, id: Id, subject: &Subject<'_>) -> Change {
    let typed = ui
        .horizontal(|ui| {
            let name = format!("Index of refraction of {}", subject.name);
            let typed = typed_ui(ui, id, subject, &name, WIDTH, Align::Min);
            let words = in_words(subject.model);
            if let Ior::Catalog(entry) = subject.model {
                let about = format!("{words}\n{}", entry.source);
                ui.add(Label::new(words).truncate()).on_hover_text(about);
            } else {
                let weak = RichText::new(words).color(Palette::of(ui).weak_text);
                ui.add(Label::new(weak).truncate()).on_hover_text("What this index of refraction is.");
            }
            typed
        })
        .inner;
    if let Some(refusal) = &typed.refusal {
        refusal_ui(ui, refusal, &shown(subject.model.ior()));
    } else if let Some(text) = &typed.draft {
        // What it would become.
        let text = match entry::ior(text) {
            Ok(ior) => format!("= {}  ·  {}", shown(ior.ior()), in_words(&ior)),
            Err(_) => "A number, a calculation such as 4/3, or a name such as water".to_owned(),
        };
        ui.add(Label::new(note(ui, text)).truncate());
    }
    taken(typed, subject)
}

/// The field alone; `name` is for screen readers.
pub fn typed_ui(ui: &mut Ui, id: Id, subject: &Subject<'_>, name: &str, width: f32, align: Align) -> Typed<Ior> {
    let about = format!(
        "Index of refraction of {}: a number (1.333 or 1,333), a calculation (4/3, sqrt(2)), a name (water, BK7), or an index with \
         Abbe's number (1.5168 V 64.2).",
        subject.name
    );
    let shown = shown(subject.model.ior());
    let name = name.to_owned();
    TextField { id, shown: &shown, name, about, width, align, style: TextStyle::Monospace }.show(ui, entry::ior)
}

pub fn taken(typed: Typed<Ior>, subject: &Subject<'_>) -> Change {
    typed.taken.filter(|ior| ior != subject.model).map_or_else(Change::default, Change::to)
}
