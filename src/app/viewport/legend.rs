//! What the colours of painted surfaces mean, and what is under the pointer.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Ui, Vec2, pos2, vec2};

use super::layout::Pane;
use crate::app::develop::Source;
use crate::app::state::State;
use crate::app::theme::over_pictures::{GROUND, TEXT, WEAK};
use crate::app::theme::{self, opaque};
use crate::render::surfaces::{SurfaceQuantity, Tint, confidence_color, faces_along};
use crate::scene::camera::Camera;

const ROW: f32 = 17.0;
const SWATCH: f32 = 10.0;
const PADDING: f32 = 8.0;
/// Most of a pane's height and width that a legend takes.
const SHARE: Vec2 = vec2(0.6, 0.5);
/// Lines of what is under the pointer.
const MOST_FACES: usize = 8;

/// In the lower right corner of `room`, or in the lower left one where the pane's label is in the way. Returns where it is, if there is room.
pub(super) fn show(
    ui: &Ui,
    state: &State,
    source: &Source,
    quantity: SurfaceQuantity,
    room: Rect,
    at_left: bool,
) -> Option<Rect> {
    let (Some(painted), Some(report)) = (&source.painted, &state.report) else { return None };
    if room.width() < 120.0 || room.height() < 80.0 {
        return None;
    }
    let painter = ui.painter();
    if quantity == SurfaceQuantity::Confidence {
        let least = painted.painting.seen.iter().filter_map(|(tint, _)| match tint {
            Tint::Confidence(percent) => Some(*percent),
            _ => None,
        });
        let frame = in_corner(room, vec2(210.0f32.min(room.width()), 38.0), at_left);
        paint_scale(painter, frame, least.min());
        return Some(frame);
    }
    let font = egui::TextStyle::Small.resolve(ui.style());
    // As many as there is room for, most seen first; then in their own order.
    let fitting = ((room.height() * SHARE.y - 2.0 * PADDING) / ROW).floor().max(1.0) as usize;
    let all = &painted.painting.seen;
    let count = if all.len() > fitting { fitting.saturating_sub(1).max(1) } else { all.len() };
    let mut tints: Vec<Tint> = all.iter().take(count).map(|(tint, _)| *tint).collect();
    tints.sort_unstable();
    let width = room.width() * SHARE.x - 2.0 * PADDING - SWATCH - 6.0;
    let fit = |text: String| {
        let mut job = egui::text::LayoutJob::simple_singleline(text, font.clone(), TEXT);
        job.wrap = egui::text::TextWrapping::truncate_at_width(width);
        painter.layout_job(job)
    };
    let mut rows: Vec<_> =
        tints.iter().map(|tint| (Some(opaque(tint.color())), fit(tint.label(&report.prepared)))).collect();
    if all.len() > count {
        rows.push((None, fit(format!("and {} more", all.len() - count))));
    }
    if rows.is_empty() {
        rows.push((None, fit("no refractor in sight".to_owned())));
    }
    let widest = rows.iter().map(|(_, galley)| galley.size().x).fold(0.0, f32::max);
    let size = vec2(widest + SWATCH + 6.0, rows.len() as f32 * ROW) + Vec2::splat(2.0 * PADDING);
    let frame = in_corner(room, size, at_left);
    painter.rect_filled(frame, 5.0, GROUND);
    for (index, (color, galley)) in rows.into_iter().enumerate() {
        let center = frame.top() + PADDING + (index as f32 + 0.5) * ROW;
        let left = frame.left() + PADDING;
        if let Some(color) = color {
            let square = Rect::from_center_size(pos2(left + SWATCH / 2.0, center), Vec2::splat(SWATCH));
            painter.rect_filled(square, 2.5, color);
        }
        painter.galley(pos2(left + SWATCH + 6.0, center - galley.size().y / 2.0), galley, TEXT);
    }
    Some(frame)
}

/// `size` in the lower right corner of `room`, or in the lower left one.
pub(super) fn in_corner(room: Rect, size: Vec2, at_left: bool) -> Rect {
    let left = if at_left { room.left() } else { room.right() - size.x };
    Rect::from_min_size(pos2(left, room.bottom() - size.y), size)
}

/// A scale of colours, from 0 at the left to 1 at the right.
pub(super) fn paint_bar(painter: &Painter, bar: Rect, color: impl Fn(f32) -> Color32) {
    for step in 0..60 {
        let x = bar.left() + bar.width() * step as f32 / 60.0;
        let slice = Rect::from_min_size(pos2(x, bar.top()), vec2(bar.width() / 60.0 + 0.5, bar.height()));
        painter.rect_filled(slice, 0.0, color(step as f32 / 59.0));
    }
}

/// From "half of the rays agree" to "all do", with a mark at the least that is in sight.
fn paint_scale(painter: &Painter, frame: Rect, least: Option<u8>) {
    painter.rect_filled(frame, 5.0, GROUND);
    let bar = Rect::from_min_size(frame.min + vec2(10.0, 9.0), vec2(frame.width() - 20.0, 8.0));
    paint_bar(painter, bar, |part| opaque(confidence_color(part)));
    let font = FontId::monospace(10.0);
    let ends = [(bar.left(), Align2::LEFT_TOP, "50 %"), (bar.right(), Align2::RIGHT_TOP, "100 %")];
    for (x, align, text) in ends {
        painter.text(pos2(x, bar.bottom() + 3.0), align, text, font.clone(), WEAK);
    }
    if let Some(least) = least {
        let x = bar.left() + bar.width() * (f32::from(least) - 50.0) / 50.0;
        for (width, color) in [(4.0, Color32::BLACK), (2.0, Color32::WHITE)] {
            painter.vline(x, bar.y_range().expand(2.0), egui::Stroke::new(width, color));
        }
        let below = pos2(bar.center().x, bar.bottom() + 3.0);
        painter.text(below, Align2::CENTER_TOP, format!("least {least} %"), font, TEXT);
    }
}

/// The corner of a box beside the pointer, on whichever side there is room.
pub(super) fn beside(room: Rect, pointer: Pos2, size: Vec2) -> Pos2 {
    let beyond =
        |at: f32, length: f32, end: f32| if at + 14.0 + length <= end { at + 14.0 } else { at - 14.0 - length };
    pos2(
        beyond(pointer.x, size.x, room.right()).clamp(room.left(), (room.right() - size.x).max(room.left())),
        beyond(pointer.y, size.y, room.bottom()).clamp(room.top(), (room.bottom() - size.y).max(room.top())),
    )
}

/// The surfaces under the pointer, front to back, in a box beside it.
pub(super) fn show_faces(ui: &Ui, state: &State, pane: &Pane, pointer: Pos2, point: [f64; 2]) {
    let (Some(report), Ok(camera)) = (&state.report, Camera::new(&state.film_camera())) else { return };
    let prepared = &report.prepared;
    let faces = faces_along(prepared, &camera, state.film_size(), point);
    if faces.is_empty() {
        return;
    }
    let scene = &prepared.scene;
    let mut lines: Vec<String> = (faces.iter().take(MOST_FACES))
        .map(|face| {
            let name = &scene.object(face.refractor).name;
            let sides = match face.sides {
                Some(sides) => format!("{} | {}", scene.medium(sides.outside).name, scene.medium(sides.inside).name),
                None => "no interface".to_owned(),
            };
            let kind = face.patch.kind.name();
            format!("{name} {}: {sides}  {kind} {:.0} %", face.patch.index, 100.0 * face.patch.confidence)
        })
        .collect();
    if faces.len() > MOST_FACES {
        lines.push(format!("and {} more behind", faces.len() - MOST_FACES));
    }
    let painter = ui.painter();
    let galley = painter.layout_no_wrap(lines.join("\n"), theme::small_mono_style().resolve(ui.style()), TEXT);
    let size = galley.size() + Vec2::splat(2.0 * PADDING);
    let min = beside(pane.visible.shrink(4.0), pointer, size);
    let painter = painter.with_clip_rect(pane.visible.intersect(ui.clip_rect()));
    painter.rect_filled(Rect::from_min_size(min, size), 5.0, Color32::from_black_alpha(215));
    painter.galley(min + Vec2::splat(PADDING), galley, TEXT);
}
