//! Where panes are, and how their pixels map to the film.

use egui::{Pos2, Rangef, Rect, Vec2, pos2, vec2};

use crate::app::settings::Arrangement;
use crate::app::state::magnification;

/// Space between tiles, in points.
const GAP: f32 = 2.0;

/// A pane on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pane {
    /// Where the whole picture would be.
    pub picture: Rect,
    /// The part of it that is seen.
    pub visible: Rect,
}

impl Pane {
    /// The same pane where a film of size `film`, in pixels, covers a picture of `pixels`: what does not fit is cut off evenly. `is_whole`: the
    /// film is shown whole, and what of the pane it leaves stays empty.
    pub fn filled_by(self, film: [u32; 2], pixels: [u32; 2], pixels_per_point: f32, is_whole: bool) -> Self {
        if film == pixels || film.contains(&0) {
            return self;
        }
        let room = self.picture.size();
        let magnification = if is_whole {
            (room.x / film[0] as f32).min(room.y / film[1] as f32)
        } else {
            magnification(film, [room.x, room.y].map(f64::from)) as f32
        };
        let size = Vec2::from(film.map(|side| side as f32)) * magnification;
        let corner = self.picture.center() - 0.5 * size;
        // Pixels of the film lie on pixels of the screen where they are of one size.
        let corner = (corner.to_vec2() * pixels_per_point).round() / pixels_per_point;
        Self { picture: Rect::from_min_size(corner.to_pos2(), size), ..self }
    }
}

/// The panes within `area`. `divider` is in [0, 1]² of it and matters to a wipe only.
pub fn panes(area: Rect, count: usize, arrangement: Arrangement, divider: [f32; 2]) -> Vec<Pane> {
    match arrangement {
        Arrangement::Wipe => {
            let cut = pos2(
                (area.left() + area.width() * divider[0]).round(),
                (area.top() + area.height() * divider[1]).round(),
            );
            let parts = |all: Rangef, cut: f32, is_cut: bool| {
                if is_cut { vec![Rangef::new(all.min, cut), Rangef::new(cut, all.max)] } else { vec![all] }
            };
            let columns = parts(area.x_range(), cut.x, count > 1);
            let rows = parts(area.y_range(), cut.y, count > 2);
            let all = rows.iter().flat_map(|row| columns.iter().map(|column| Rect::from_x_y_ranges(*column, *row)));
            all.map(|visible| Pane { picture: area, visible }).collect()
        }
        Arrangement::Tiles => {
            // Two panes lie along the longer side.
            let (columns, rows) = match count {
                1 => (1, 1),
                2 if area.width() >= area.height() => (2, 1),
                2 => (1, 2),
                _ => (2, 2),
            };
            let side =
                |length: f32, parts: usize| ((length - GAP * (parts as f32 - 1.0)) / parts as f32).floor().max(1.0);
            let size = vec2(side(area.width(), columns), side(area.height(), rows));
            (0..count)
                .map(|index| {
                    let place = vec2((index % columns) as f32, (index / columns) as f32);
                    let tile = Rect::from_min_size(area.min + place * (size + Vec2::splat(GAP)), size);
                    Pane { picture: tile, visible: tile }
                })
                .collect()
        }
    }
}

/// The part of the film that a pane shows, in [0, 1]².
pub fn film_window(zoom: f32, center: [f32; 2]) -> Rect {
    Rect::from_center_size(pos2(center[0], center[1]), Vec2::splat(1.0 / zoom))
}

/// The point of the film, in [0, 1]² where it is inside, under a point of the screen.
pub fn film_from_screen(picture: Rect, window: Rect, screen: Pos2) -> Pos2 {
    window.min + (screen - picture.min) / picture.size() * window.size()
}

/// Where a point of the film is on the screen.
pub fn screen_from_film(picture: Rect, window: Rect, film: Pos2) -> Pos2 {
    picture.min + (film - window.min) / window.size() * picture.size()
}

/// Zoom by `factor` that keeps the film's point `fixed` where it is. Returns the new zoom and center.
pub fn zoomed(zoom: f32, center: [f32; 2], factor: f32, fixed: Pos2, most: f32) -> (f32, [f32; 2]) {
    let next = (zoom * factor).clamp(1.0, most);
    let keep = zoom / next;
    (next, [fixed.x + (center[0] - fixed.x) * keep, fixed.y + (center[1] - fixed.y) * keep])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area() -> Rect {
        Rect::from_min_size(pos2(10.0, 20.0), vec2(801.0, 602.0))
    }

    #[test]
    fn tiles_have_equal_sizes_and_do_not_overlap() {
        for count in [1, 2, 4] {
            let panes = panes(area(), count, Arrangement::Tiles, [0.5; 2]);
            assert_eq!(panes.len(), count);
            for (i, a) in panes.iter().enumerate() {
                assert_eq!(a.picture.size(), panes[0].picture.size());
                assert!(area().contains_rect(a.visible));
                assert!(panes[i + 1..].iter().all(|b| !a.visible.shrink(0.1).intersects(b.visible)));
            }
        }
    }

    #[test]
    fn a_wipe_parts_one_picture() {
        let panes = panes(area(), 4, Arrangement::Wipe, [0.25, 0.5]);
        assert!(panes.iter().all(|pane| pane.picture == area()));
        let seen: f32 = panes.iter().map(|pane| pane.visible.area()).sum();
        assert!((seen - area().area()).abs() < 1.0);
    }

    #[test]
    fn a_film_of_another_size_covers_its_pane() {
        let pane = Pane { picture: area(), visible: area() };
        assert_eq!(pane.filled_by([801, 602], [801, 602], 1.0, false), pane);
        for film in [[801, 632], [1101, 602], [1602, 1204], [400, 300], [3000, 10]] {
            let filled = pane.filled_by(film, [801, 602], 1.0, false);
            assert!(filled.picture.expand(0.6).contains_rect(area()), "{film:?}: {filled:?}");
            assert_eq!(filled.visible, area());
            let [width, height] = film.map(|side| side as f32);
            let off = filled.picture.width() / filled.picture.height() - width / height;
            assert!(off.abs() < 1e-3 * width / height, "{film:?}");
        }
        // Shown whole, it touches two sides and leaves the pane nowhere.
        for film in [[801, 632], [1101, 602], [1602, 1204], [400, 300], [3000, 10]] {
            let whole = pane.filled_by(film, [801, 602], 1.0, true).picture;
            assert!(area().expand(0.6).contains_rect(whole), "{film:?}: {whole:?}");
            assert!((whole.width() - area().width()).abs() < 1.0 || (whole.height() - area().height()).abs() < 1.0);
        }
        // What fits in one direction keeps its pixels.
        assert_eq!(pane.filled_by([801, 632], [801, 602], 1.0, false).picture.size(), vec2(801.0, 632.0));
    }

    #[test]
    fn zoom_keeps_the_point_under_the_pointer() {
        let (zoom, center) = (1.0, [0.5, 0.5]);
        let pointer = pos2(200.0, 150.0);
        let fixed = film_from_screen(area(), film_window(zoom, center), pointer);
        let (zoom, center) = zoomed(zoom, center, 3.0, fixed, 64.0);
        let again = film_from_screen(area(), film_window(zoom, center), pointer);
        assert!((again - fixed).length() < 1e-5);
        let back = screen_from_film(area(), film_window(zoom, center), again);
        assert!((back - pointer).length() < 1e-2);
    }
}
