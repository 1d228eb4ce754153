//! What lies over the pictures: each pane's label, the inspected pixel, the legend of a difference.

use egui::text::LayoutJob;
use egui::{Button, Color32, Painter, Pos2, Rect, Stroke, TextFormat, Ui, UiBuilder, Vec2, pos2, vec2};

use super::layout::{Pane, film_window, screen_from_film};
use super::{legend, range, slice, snapshots, verdict};
use crate::app::command::Command;
use crate::app::develop::About;
use crate::app::settings::{Arrangement, DifferenceKind, PaneContent};
use crate::app::state::State;
use crate::app::theme::over_pictures::{GROUND, TEXT, WEAK};
use crate::app::theme::{self, DOT, Palette};
use crate::app::widgets::menu_ui;
use crate::render::Estimator;
use crate::render::slice::SLICED_MODES;
use crate::render::surfaces::SurfaceQuantity;
use crate::tracking::Mode;

const MARGIN: f32 = 8.0;
/// What is to be said of every painted surface.
const LAYERS: &str = "Each pixel shows the innermost surface on its way, in a shade of a colour of the legend; dark lines are outlines of everything in front and behind.";
/// What is to be said of every slice.
const SLICE: &str = "A plane through the scene, filled with the medium that the mode finds at each place. Striped: the surfaces around the place do not agree.";

/// A pane's label, with the menu that chooses what it shows, and its legend. Returns where the label and the legend are; where there is no
/// room, they are not shown.
pub(super) fn pane_ui(
    ui: &mut Ui,
    state: &State,
    about: &About,
    index: usize,
    pane: Pane,
    commands: &mut Vec<Command>,
) -> [Option<Rect>; 2] {
    let room = pane.visible.shrink(MARGIN);
    if room.width() < 40.0 || room.height() < 30.0 {
        return [None; 2];
    }
    // In a wipe the labels go to the outer corners, where the divider reaches them last.
    let [to_right, to_bottom] = label_corner(state, index);
    let align = if to_right { egui::Align::Max } else { egui::Align::Min };
    let layout = if to_bottom { egui::Layout::bottom_up(align) } else { egui::Layout::top_down(align) };
    let mut child = ui.new_child(UiBuilder::new().max_rect(room).layout(layout).id_salt(("label", index)));
    child.set_clip_rect(pane.visible.intersect(ui.clip_rect()));
    label_ui(&mut child, state, about, index, commands);

    let legend = match state.settings.panes[index] {
        PaneContent::Difference(..)
        | PaneContent::Error(_)
        | PaneContent::Change(..)
        | PaneContent::SnapshotDifference => {
            range::show(ui, state, index, about.scale, room, to_right && to_bottom, commands)
        }
        PaneContent::Surfaces(quantity) => {
            legend::show(ui, state, &about.source, quantity, room, to_right && to_bottom)
        }
        PaneContent::Slice(_) => slice::show_legend(ui, state, &about.source, index, room, to_right && to_bottom),
        PaneContent::Mode(_) | PaneContent::Snapshot(_) => None,
    };
    [Some(child.min_rect()), legend]
}

/// Whether a pane's label is at the right, and at the bottom.
pub(super) fn label_corner(state: &State, index: usize) -> [bool; 2] {
    let is_wipe = state.settings.arrangement == Arrangement::Wipe && state.settings.pane_count > 1;
    [is_wipe && index % 2 == 1, is_wipe && index >= 2]
}

fn label_ui(ui: &mut Ui, state: &State, about: &About, index: usize, commands: &mut Vec<Command>) {
    let mean_difference = &about.mean_difference;
    let content = state.settings.panes[index];
    let room = ui.available_width() - 2.0 * ui.spacing().button_padding.x;
    let fits = |job: &LayoutJob| ui.painter().layout_job(job.clone()).size().x <= room;
    let text = |detail| label_text(ui, state, about, content, detail);
    let job = Detail::ALL.into_iter().map(text).find(fits).unwrap_or_else(|| text(Detail::Names));
    let button =
        Button::new(job).fill(GROUND).stroke(Stroke::NONE).corner_radius(5).min_size(vec2(0.0, 24.0)).truncate();
    let name = format!("Pane {}: {content}", index + 1);
    let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
        menu_ui(ui, |ui| {
            commands.extend(content_menu_ui(ui, content).map(|new| Command::SetPaneContent(index, new)));
            snapshots::keep_ui(ui, state, index, commands);
        });
    });
    let hint = match content {
        PaneContent::Mode(mode) => mode.about().to_owned(),
        PaneContent::Difference(a, b) => {
            let [a, b] = [a, b].map(Mode::name);
            format!("The luminance of {a} less that of {b}.")
        }
        PaneContent::Error(mode) => {
            let mode = mode.name();
            format!("The luminance of {mode} less that of the reference image.")
        }
        PaneContent::Surfaces(quantity) => format!("{}\n{LAYERS}", quantity.about()),
        PaneContent::Slice(mode) => format!("{SLICE}\n{}", mode.about()),
        PaneContent::Snapshot(_) | PaneContent::Change(..) | PaneContent::SnapshotDifference => {
            snapshots::about(state, content)
        }
    };
    response.accessible_name(name).on_hover_text(format!("{hint}\nClick to show something else in this pane."));
    verdict::show(ui, state, index, commands);
    if let Some((kind, mean)) = *mean_difference {
        let text = if mean == 0.0 { "identical".to_owned() } else { format!("mean {mean:.3e}") };
        let text = egui::RichText::new(text).text_style(theme::small_mono_style()).color(WEAK);
        let chip = Button::new(text).fill(GROUND).stroke(Stroke::NONE).corner_radius(5).min_size(Vec2::ZERO).truncate();
        let tip = match kind {
            DifferenceKind::Flip => "The mean of FLIP over all pixels: 0 looks the same, 1 is as different as can be.",
            _ => "The mean over all pixels of the absolute difference in linear luminance, noise included.",
        };
        ui.add(chip.sense(egui::Sense::hover())).on_hover_text(tip);
    }
    if state.is_paused && index == 0 {
        let text = egui::RichText::new("paused").text_style(egui::TextStyle::Small).color(TEXT);
        let chip = Button::new(text).fill(GROUND).stroke(Stroke::NONE).corner_radius(5).min_size(Vec2::ZERO);
        if ui.add(chip).on_hover_text("Click to go on (Space).").clicked() {
            commands.push(Command::TogglePause);
        }
    }
}

/// How much a pane's label says.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Detail {
    /// With the number of samples.
    All,
    Content,
    /// Without the word "difference".
    Names,
}

impl Detail {
    const ALL: [Self; 3] = [Self::All, Self::Content, Self::Names];
}

fn label_text(ui: &Ui, state: &State, about: &About, content: PaneContent, detail: Detail) -> LayoutJob {
    let source = &about.source;
    let palette = Palette { is_dark: true, ..Palette::of(ui) };
    let body = egui::TextStyle::Body.resolve(ui.style());
    let mono = theme::small_mono_style().resolve(ui.style());
    let mut job = LayoutJob::default();
    let mut dot = |mode: Mode, space: f32| {
        job.append(DOT, space, TextFormat::simple(egui::FontId::proportional(11.0), palette.mode(mode)));
        job.append(mode.name(), 5.0, TextFormat::simple(body.clone(), TEXT));
    };
    match content {
        PaneContent::Mode(mode) => dot(mode, 0.0),
        PaneContent::Difference(a, b) => {
            dot(a, 0.0);
            dot(b, 9.0);
            if detail < Detail::Names {
                job.append("difference", 9.0, TextFormat::simple(body, TEXT));
            }
        }
        PaneContent::Error(mode) => {
            dot(mode, 0.0);
            job.append("error", 9.0, TextFormat::simple(body, TEXT));
        }
        PaneContent::Surfaces(quantity) => job.append(quantity.name(), 0.0, TextFormat::simple(body, TEXT)),
        PaneContent::Slice(mode) => {
            dot(mode, 0.0);
            job.append("slice", 9.0, TextFormat::simple(body, TEXT));
        }
        PaneContent::Snapshot(_) | PaneContent::Change(..) | PaneContent::SnapshotDifference => {
            snapshots::append_label(ui, state, content, &mut job);
        }
    }
    let status = match source.samples() {
        0 => "…".to_owned(),
        _ if source.is_preview() => "preview".to_owned(),
        // A painted picture is soon done, and no noise is left in it.
        _ if source.painted.is_some() || source.slice.is_some() => String::new(),
        samples if about.is_denoised => format!("{samples} spp, denoised"),
        samples => format!("{samples} spp"),
    };
    let estimator = source.films.first().map(|film| film.estimator).filter(|_| matches!(content, PaneContent::Mode(_)));
    let status = match estimator {
        Some(estimator @ (Estimator::Bidirectional | Estimator::Merging)) => format!("{}, {status}", estimator.name()),
        Some(Estimator::Path) | None => status,
    };
    if !status.is_empty() && detail == Detail::All {
        job.append(&status, 9.0, TextFormat::simple(mono, WEAK));
    }
    job
}

/// A menu in a menu, which scrolls where the window is too low for it.
fn submenu_ui(ui: &mut Ui, name: &str, contents: impl FnOnce(&mut Ui)) {
    ui.menu_button(name, |ui| menu_ui(ui, contents));
}

/// The entries that choose what a pane shows.
pub fn content_menu_ui(ui: &mut Ui, shown: PaneContent) -> Option<PaneContent> {
    let mut chosen = None;
    let mut entry = |response: egui::Response, content: PaneContent| {
        if response.clicked() {
            chosen = Some(content);
        }
    };
    let palette = Palette::of(ui);
    for mode in Mode::ALL {
        let content = PaneContent::Mode(mode);
        let mut job = LayoutJob::default();
        let body = egui::TextStyle::Body.resolve(ui.style());
        job.append(DOT, 0.0, TextFormat::simple(body.clone(), palette.mode(mode)));
        job.append(mode.name(), 6.0, TextFormat::simple(body, ui.visuals().text_color()));
        let response = ui.add(Button::selectable(shown == content, job).min_size(vec2(130.0, 0.0)));
        entry(response.accessible_name(mode.name()).on_hover_text(mode.about()), content);
    }
    ui.separator();
    submenu_ui(ui, "surfaces", |ui| {
        for quantity in SurfaceQuantity::ALL {
            let content = PaneContent::Surfaces(quantity);
            let response = ui.selectable_label(shown == content, quantity.name());
            entry(response.on_hover_text(quantity.about()), content);
        }
    });
    submenu_ui(ui, "slice", |ui| {
        for mode in SLICED_MODES {
            let content = PaneContent::Slice(mode);
            let response = ui.selectable_label(shown == content, content.to_string());
            entry(response.on_hover_text(format!("{SLICE}\n{}", mode.about())), content);
        }
    });
    submenu_ui(ui, "difference", |ui| {
        for content in PaneContent::differences() {
            entry(ui.selectable_label(shown == content, content.to_string()), content);
        }
    });
    submenu_ui(ui, "error", |ui| {
        for mode in Mode::ALL {
            let content = PaneContent::Error(mode);
            let response = ui.selectable_label(shown == content, content.to_string());
            let hint =
                "Against a reference image, which is made in the background if there is none yet: see the tab Measure.";
            entry(response.on_hover_text(hint), content);
        }
    });
    ui.menu_button("snapshots", |ui| snapshots::entries_ui(ui, shown, &mut entry));
    if chosen.is_some() {
        ui.close();
    }
    chosen
}

/// What an event is called on the screen.
pub fn event_name(kind: &str) -> String {
    match kind {
        "inconsistent" => "inconsistent crossings".to_owned(),
        "stack_underflow" => "exits without entry".to_owned(),
        "stack_overflow" => "stack overflows".to_owned(),
        "ambiguous" => "ambiguous answers".to_owned(),
        "non_finite" => "samples not finite".to_owned(),
        "radiance_overflow" => "samples too bright".to_owned(),
        other => other.replace('_', " "),
    }
}

/// What an event means.
pub fn event_meaning(kind: &str) -> &'static str {
    match kind {
        "inconsistent" => {
            "A path leaves another medium than the one it was in: the mode was wrong here or at the interface before."
        }
        "stack_underflow" => {
            "A path left a medium that it never entered, because it started inside: the stack had nothing to pop."
        }
        "stack_overflow" => "More media inside each other than the stack can hold.",
        "ambiguous" => "The rays that ask what contains a point did not agree.",
        "non_finite" => "Samples that came out infinite or not a number; they are left out of the mean.",
        "radiance_overflow" => {
            "Samples of more radiance than pictures and EXR files hold; pixels are capped at 3.4e38."
        }
        _ => "",
    }
}

/// A ring around the inspected pixel.
pub(super) fn paint_marker(painter: &Painter, state: &State, picture: Rect) {
    let Some(inspection) = &state.inspection else { return };
    let window = film_window(state.view.zoom, state.view.zoom_center);
    let film = pos2(inspection.point[0] as f32, inspection.point[1] as f32);
    let center = screen_from_film(picture, window, film);
    for (width, color) in [(3.5, Color32::from_black_alpha(170)), (1.5, Color32::WHITE)] {
        let stroke = Stroke::new(width, color);
        painter.circle_stroke(center, 7.0, stroke);
        for direction in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
            painter.line_segment([center + direction * 7.0, center + direction * 12.0], stroke);
        }
    }
}

/// A word in the picture, around `center`.
pub(super) fn paint_note(painter: &Painter, center: Pos2, text: &str) {
    let galley = painter.layout_no_wrap(text.to_owned(), egui::FontId::monospace(12.0), TEXT);
    let frame = Rect::from_center_size(center, galley.size() + vec2(14.0, 8.0));
    painter.rect_filled(frame, 5.0, GROUND);
    painter.galley(frame.min + vec2(7.0, 4.0), galley, TEXT);
}

/// The knob of a wipe.
pub(super) fn paint_handle(painter: &Painter, center: Pos2) {
    painter.circle(center, 9.0, Color32::from_white_alpha(235), Stroke::new(1.0, Color32::from_black_alpha(140)));
    for side in [-1.0, 1.0] {
        let tip = center + vec2(side * 6.0, 0.0);
        let stroke = Stroke::new(1.5, Color32::from_gray(50));
        painter.line_segment([tip, tip + vec2(-side * 3.0, -3.0)], stroke);
        painter.line_segment([tip, tip + vec2(-side * 3.0, 3.0)], stroke);
    }
}

/// The magnification, in a corner of all panes together. Returns where it is, if the picture is magnified.
pub(super) fn zoom_ui(ui: &Ui, state: &State, area: Rect) -> Option<Rect> {
    (state.view.zoom > 1.0).then(|| {
        let text = format!("{:.0} %   Z: whole picture", state.view.zoom * 100.0);
        let font = theme::small_mono_style().resolve(ui.style());
        let galley = ui.painter().layout_no_wrap(text, font, TEXT);
        let corner = area.left_bottom() + vec2(MARGIN, -MARGIN - galley.size().y - 8.0);
        let frame = Rect::from_min_size(corner, galley.size() + vec2(16.0, 8.0));
        ui.painter().rect_filled(frame, 5.0, GROUND);
        ui.painter().galley(frame.min + vec2(8.0, 4.0), galley, TEXT);
        frame
    })
}
