//! A control for an index of refraction, as wide as its panel: a rail on which the media of the catalogue are marked, and a field that
//! reads numbers, calculations and names. In the rows of the tree it is a field with a thin rail under it.

mod compact;
mod field;
mod paint;
mod rail;

use egui::{Color32, EventFilter, Id, Key, Modifiers, Rect, Response, Sense, Ui, pos2, vec2};

pub use self::compact::{COMPACT_WIDTH, compact_ui};
pub use self::field::field_ui;
pub use self::rail::short_name;
use self::rail::{Rail, Tick, next_tick, tick_near, ticks};
use crate::app::keys;
use crate::app::objects::rounded;
use crate::optics::Ior;
use crate::optics::ior::IOR_RANGE;

/// Distance to a tick, in points, within which it is taken.
const SNAP: f32 = 5.0;
/// Distance to the knob, in points, within which pressing takes hold of it where it stands.
const GRIP: f32 = 9.0;
/// How much slower the knob moves with Shift.
const FINE: f64 = 20.0;
/// Steps of the arrow keys: alone, with Shift, with Ctrl.
const KEY_STEPS: [f64; 3] = [0.001, 0.0001, 0.01];

/// An index that stands on the rail besides the one that is edited: that of another medium of the scene.
pub struct Mark {
    pub name: String,
    pub ior: f64,
    pub color: Color32,
}

/// What the control is about.
pub struct Subject<'a> {
    /// Of the medium.
    pub name: &'a str,
    pub model: &'a Ior,
    pub color: Color32,
    pub others: &'a [Mark],
}

/// What came of a frame.
#[derive(Debug, Default, PartialEq)]
pub struct Change {
    /// A drag begins, before the new index.
    pub begins: bool,
    pub ior: Option<Ior>,
    /// Whether the index is part of a drag.
    pub is_drag: bool,
    /// A drag has ended, after the new index.
    pub ends: bool,
}

impl Change {
    fn to(ior: Ior) -> Self {
        Self { ior: Some(ior), ..Self::default() }
    }

    /// Both, where only one of the parts of a control can have changed.
    fn or(self, other: Self) -> Self {
        Self {
            begins: self.begins | other.begins,
            ior: self.ior.or(other.ior),
            is_drag: self.is_drag | other.is_drag,
            ends: self.ends | other.ends,
        }
    }
}

/// A drag that is under way. The rail stays as it was at its beginning, and the place moves with the pointer, beyond the ends too.
#[derive(Debug, Clone, Copy)]
struct Drag {
    rail: Rail,
    place: f64,
}

/// The rail with everything that is written on it, over the width that is left, and the field with a line of words under it.
pub fn show(ui: &mut Ui, id: Id, subject: &Subject<'_>) -> Change {
    let size = vec2(ui.available_width(), paint::HEIGHT);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let track = paint::track(rect);
    let response = ui.interact(rect, id.with("rail"), Sense::drag());
    let drag = ui.data(|data| data.get_temp::<Drag>(id));
    let rail = drag.map_or_else(|| Rail::around(subject.model.ior()), |drag| drag.rail);
    let labels = paint::labels(ui, &rail, track);
    let pressed_label = |at: egui::Pos2| {
        labels.iter().find(|label| label.rect.expand2(vec2(2.0, 1.0)).contains(at)).map(|label| label.tick)
    };
    let change = rail_change(ui, id, &response, track, &rail, subject.model, pressed_label);
    let shown = change.ior.as_ref().unwrap_or(subject.model);
    let hovered = response.hover_pos().filter(|_| !response.dragged());
    let under_pointer =
        hovered.and_then(|at| pressed_label(at).or_else(|| tick_near(&rail, place_of(track, at.x), reach(track))));
    paint::show(ui, &response, track, &rail, shown, subject, &labels, under_pointer);
    describe(ui, &response, &rail, shown.ior(), &format!("Index of refraction of {}", subject.name));
    response.on_hover_ui(|ui| {
        if let Some(tick) = under_pointer {
            ui.label(format!("{}, {:.4}: click to take it.", tick.label, tick.ior));
            return;
        }
        ui.label(format!(
            "Index of refraction of {}. Drag: ticks are media of the catalogue. Ctrl or Alt passes them by, Shift is {FINE} times finer.",
            subject.name
        ));
        ui.label("Arrow keys step by 0.001 (Shift 0.0001, Ctrl 0.01), Home and End go to the next tick.");
        if !subject.others.is_empty() {
            ui.label(marked(subject.others));
        }
    });
    change.or(field_ui(ui, id.with("field"), subject))
}

/// What the pointer, the keys and a screen reader do to a rail.
fn rail_change(
    ui: &Ui,
    id: Id,
    response: &Response,
    track: Rect,
    rail: &Rail,
    model: &Ior,
    pressed_label: impl Fn(egui::Pos2) -> Option<&'static Tick>,
) -> Change {
    let changed = |ior: Ior| (ior != *model).then_some(ior);
    let mut change = Change::default();
    if response.drag_started()
        && let Some(at) = response.interact_pointer_pos()
    {
        response.request_focus();
        let knob = x_of(track, rail.place(model.ior()));
        let mut place = place_of(track, at.x);
        change.begins = true;
        if let Some(tick) = pressed_label(at) {
            place = rail.place(tick.ior);
            change.ior = changed(tick.model.clone());
        } else if (at.x - knob).abs() <= GRIP {
            place = rail.place(model.ior());
        } else {
            change.ior = changed(dragged_to(ui, rail, track, place));
        }
        ui.data_mut(|data| data.insert_temp(id, Drag { rail: *rail, place }));
    } else if response.dragged()
        && let Some(mut drag) = ui.data(|data| data.get_temp::<Drag>(id))
    {
        let delta = f64::from(response.drag_delta().x / track.width());
        if delta != 0.0 {
            drag.place += if ui.input(|input| input.modifiers.shift) { delta / FINE } else { delta };
            change.ior = changed(dragged_to(ui, rail, track, drag.place));
            ui.data_mut(|data| data.insert_temp(id, drag));
        }
    }
    change.is_drag = change.ior.is_some();
    if response.drag_stopped() {
        change.ends = true;
        ui.data_mut(|data| data.remove::<Drag>(id));
    }
    change.or(key_change(ui, response, model))
}

/// What a drag to a place makes of the medium: a tick that is near, unless it is passed by.
fn dragged_to(ui: &Ui, rail: &Rail, track: Rect, place: f64) -> Ior {
    let Modifiers { alt, ctrl, shift, command, .. } = ui.input(|input| input.modifiers);
    let is_free = alt || ctrl || command || shift;
    if let Some(tick) = tick_near(rail, place, reach(track)).filter(|_| !is_free) {
        return tick.model.clone();
    }
    let points = if shift { FINE } else { 1.0 };
    Ior::Constant(rail.rounded_ior_at(place, 1.0 / (f64::from(track.width()) * points)))
}

/// Arrow keys, Home and End, and what a screen reader asks for.
fn key_change(ui: &Ui, response: &Response, model: &Ior) -> Change {
    use egui::accesskit::{Action, ActionData};
    let n = model.ior();
    if response.has_focus() {
        let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
        keys::keep_home_and_end(ui.ctx(), response.id);
    }
    let stepped = |steps: f64, step: f64| {
        let stepped = rounded(n + steps * step, (step / 10.0).min(1e-4));
        // A step from near 0 would leave what an index can be.
        Ior::Constant(if stepped > 0.0 { stepped.clamp(*IOR_RANGE.start(), *IOR_RANGE.end()) } else { n })
    };
    let asked = ui.input(|input| {
        let value =
            input.accesskit_action_requests(response.id, Action::SetValue).filter_map(|request| match request.data {
                Some(ActionData::NumericValue(value)) if IOR_RANGE.contains(&value) => Some(Ior::Constant(value)),
                _ => None,
            });
        let count = |action| input.num_accesskit_action_requests(response.id, action) as f64;
        let steps = count(Action::Increment) - count(Action::Decrement);
        value.last().or_else(|| (steps != 0.0).then(|| stepped(steps, KEY_STEPS[0])))
    });
    let pressed = || {
        ui.input(|input| {
            let Modifiers { ctrl, command, shift, .. } = input.modifiers;
            let step = KEY_STEPS[if shift {
                1
            } else if ctrl || command {
                2
            } else {
                0
            }];
            let count = |keys: [Key; 2]| keys.iter().map(|key| input.num_presses(*key)).sum::<usize>() as f64;
            let steps = count([Key::ArrowRight, Key::ArrowUp]) - count([Key::ArrowLeft, Key::ArrowDown]);
            if steps != 0.0 {
                return Some(stepped(steps, step));
            }
            let jumps = [(Key::Home, false), (Key::End, true)];
            let is_above = jumps.into_iter().find(|(key, _)| input.key_pressed(*key))?.1;
            next_tick(n, is_above).map(|tick| tick.model.clone())
        })
    };
    let ior = asked.or_else(|| response.has_focus().then(pressed).flatten());
    ior.filter(|ior| ior != model).map_or_else(Change::default, Change::to)
}

/// What a screen reader says.
fn describe(ui: &Ui, response: &Response, rail: &Rail, n: f64, name: &str) {
    use egui::accesskit::Action;
    response.widget_info(|| egui::WidgetInfo::slider(ui.is_enabled(), n, name));
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_min_numeric_value(*rail.range().start());
        node.set_max_numeric_value(*rail.range().end());
        node.set_numeric_value_step(KEY_STEPS[0]);
        [Action::SetValue, Action::Increment, Action::Decrement].into_iter().for_each(|action| node.add_action(action));
    });
}

/// The other media of the scene, in words.
fn marked(others: &[Mark]) -> String {
    const MOST: usize = 8;
    let mut words: Vec<String> =
        others.iter().take(MOST).map(|other| format!("{} {}", other.name, shown(other.ior))).collect();
    if others.len() > MOST {
        words.push(format!("{} more", others.len() - MOST));
    }
    format!("Marked: {}.", words.join(", "))
}

/// How an index is written: with four decimals, which tell the media of the catalogue apart, or more where it has been typed so.
pub fn shown(n: f64) -> String {
    if !(1e-3..1e4).contains(&n) {
        return format!("{n:.4e}");
    }
    let (short, long) = (format!("{n:.4}"), n.to_string());
    if long.len() > short.len() && long.len() <= short.len() + 2 { long } else { short }
}

/// What an index is, in a few words: the medium of the catalogue, or between which two it lies.
pub fn in_words(model: &Ior) -> String {
    let n = model.ior();
    let dispersion = model.abbe_number().map_or_else(String::new, |abbe| format!(", Abbe {abbe:.1}"));
    match model {
        Ior::Catalog(entry) => format!("{}{dispersion}", entry.label),
        Ior::Cauchy(_) => format!("Cauchy formula{dispersion}"),
        Ior::Sellmeier(_) => format!("Sellmeier formula{dispersion}"),
        Ior::Gas(_) => format!("Formula for gases{dispersion}"),
        Ior::Constant(_) if n == 1.0 => "Vacuum".to_owned(),
        Ior::Constant(_) => match ticks().iter().find(|tick| (tick.ior - n).abs() < 5e-5) {
            Some(tick) if tick.model.is_dispersive() => format!("As {}, without dispersion", tick.name),
            Some(tick) => format!("As {}", tick.name),
            None => match (next_tick(n, false), next_tick(n, true)) {
                (Some(below), Some(above)) => format!("Between {} and {}", below.name, above.name),
                (None, _) => "Below vacuum".to_owned(),
                (_, None) => "Above diamond".to_owned(),
            },
        },
    }
}

fn reach(track: Rect) -> f64 {
    f64::from(SNAP / track.width())
}

fn place_of(track: Rect, x: f32) -> f64 {
    f64::from((x - track.left()) / track.width())
}

fn x_of(track: Rect, place: f64) -> f32 {
    track.left() + place as f32 * track.width()
}

fn center_at(track: Rect, place: f64) -> egui::Pos2 {
    pos2(x_of(track, place), track.center().y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::catalog;

    #[test]
    fn four_decimals_or_as_typed() {
        let texts = [1.5, 1.333_403_3, 1.000_277, 1.333_35, 4.0 / 3.0, 1e-5, 1e6].map(shown);
        assert_eq!(texts, ["1.5000", "1.3334", "1.000277", "1.33335", "1.3333", "1.0000e-5", "1.0000e6"]);
    }

    #[test]
    fn every_index_has_words() {
        let words = |n: f64| in_words(&Ior::Constant(n));
        assert_eq!(words(1.0), "Vacuum");
        assert_eq!(words(1.32), "Between ice and water");
        assert_eq!(words(1.3334), "As water, without dispersion");
        assert_eq!(words(1.3097), "As ice");
        assert_eq!(words(0.5), "Below vacuum");
        assert_eq!(words(5.0), "Above diamond");
        assert_eq!(in_words(&Ior::Catalog(catalog::find("water").unwrap())), "Water, Abbe 55.8");
        for entry in catalog::ALL {
            assert!(in_words(&Ior::Catalog(entry)).starts_with(entry.label));
        }
    }
}
