//! Paths on the screen: where their legs are, how wide and how bright, and where labels have room.

use egui::{Pos2, Rect, Vec2, vec2};
use glam::DVec3;

use super::line::{Leg, Line, PIECES};
use crate::render::surfaces::medium_color;
use crate::transport::inspect::{Vertex, VertexEvent};

/// Widths of a leg without light and with all of it, in points.
const WIDTHS: [f32; 2] = [1.2, 4.2];
/// The same of a bundle's rays.
const BUNDLE_WIDTHS: [f32; 2] = [0.5, 1.3];
/// Opacity of what is hidden, relative to what is seen.
const HIDDEN: f32 = 0.3;
/// Opacity that is left where all light has been absorbed.
const LEAST_OPACITY: f32 = 0.22;
/// Legs of light whose two ends differ by more than this fade piece by piece.
const FADES: f64 = 0.04;
/// Labels at the most.
const MOST_LABELS: usize = 10;
/// A vertex nearer than this to one with a label, in points, has none.
const CROWDED: f32 = 16.0;

/// A straight line on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    pub from: Pos2,
    pub to: Pos2,
    /// In points.
    pub width: f32,
    /// sRGB.
    pub color: [u8; 3],
    /// In [0, 1].
    pub opacity: f32,
    pub is_hidden: bool,
}

/// How much is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// The path through the pixel's middle.
    Main,
    /// One of a bundle.
    Bundle,
}

/// The legs of a path, where `screen` puts places of the scene (`None` behind the camera). Width tells Fresnel's shares, opacity what absorption
/// has left.
pub fn strokes(line: &Line, weight: Weight, screen: impl Fn(DVec3) -> Option<Pos2>) -> Vec<Stroke> {
    line.legs.iter().flat_map(|leg| strokes_of_leg(leg, weight, &screen)).collect()
}

fn strokes_of_leg(leg: &Leg, weight: Weight, screen: &impl Fn(DVec3) -> Option<Pos2>) -> Vec<Stroke> {
    let [least, most] = if weight == Weight::Main { WIDTHS } else { BUNDLE_WIDTHS };
    let width = least + (most - least) * (leg.share.clamp(0.0, 1.0) as f32).sqrt();
    let fades = (leg.light[0] - leg.light[1]).abs() > FADES;
    let mut strokes: Vec<Stroke> = Vec::new();
    let mut is_joined = false;
    for piece in 0..PIECES {
        let [start, end] = [piece, piece + 1].map(|k| k as f64 / PIECES as f64);
        let (Some(from), Some(to)) = (screen(leg.at(start)), screen(leg.at(end))) else {
            is_joined = false;
            continue;
        };
        let is_hidden = leg.is_hidden(piece);
        let light = leg.light[0] + (leg.light[1] - leg.light[0]) * 0.5 * (start + end);
        let mut opacity = LEAST_OPACITY + (1.0 - LEAST_OPACITY) * (light.clamp(0.0, 1.0) as f32).sqrt();
        opacity *= if is_hidden { HIDDEN } else { 1.0 };
        opacity *= if weight == Weight::Bundle { 0.6 } else { 1.0 };
        match strokes.last_mut().filter(|last| is_joined && !fades && last.is_hidden == is_hidden) {
            // A straight line in space is one on the screen.
            Some(last) => last.to = to,
            None => strokes.push(Stroke { from, to, width, color: medium_color(leg.medium), opacity, is_hidden }),
        }
        is_joined = true;
    }
    strokes
}

/// What is said at a vertex: indices and angles. `None` where light is not bent.
pub fn label(vertex: &Vertex) -> Option<String> {
    let (from, to) = (vertex.ior_from?, vertex.ior_to?);
    let number = |x: f64| {
        let text = format!("{x:.3}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    let angle = vertex.angle_in?;
    let angles = match (vertex.event, vertex.angle_out) {
        (VertexEvent::TotalReflection, _) => format!("{angle:.0}° total"),
        (VertexEvent::Transmit, Some(out)) => format!("{angle:.0}° → {out:.0}°"),
        (VertexEvent::Reflect, Some(_)) => format!("{angle:.0}° back"),
        _ => return None,
    };
    Some(format!("{} → {}, {angles}", number(from), number(to)))
}

/// A label that wants a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Label {
    /// What it is about.
    pub anchor: Pos2,
    pub size: Vec2,
    /// Whether another place will do where there is no room beside the anchor, and over other anchors where there is none else.
    pub goes_far: bool,
}

/// Finds room for labels beside their anchors: inside `room`, apart from each other and from what is `taken`. Those that come first are served
/// first; one whose vertex stands too close to that of another label, or that finds no room, has none.
pub fn place_labels(labels: &[Label], room: Rect, taken: &[Rect]) -> Vec<Option<Rect>> {
    const AWAY: f32 = 11.0;
    let mut placed: Vec<(Pos2, Rect)> = Vec::new();
    labels
        .iter()
        .map(|&Label { anchor, size, goes_far }| {
            let is_crowded = placed.iter().any(|(other, _)| other.distance(anchor) < CROWDED);
            if placed.len() >= MOST_LABELS || is_crowded || !room.contains(anchor) {
                return None;
            }
            let sides =
                [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, -1.0), (0.0, 1.0)];
            let beside = sides.iter().map(|&(x, y)| {
                let half = size / 2.0;
                Rect::from_center_size(anchor + vec2(x * (half.x + AWAY), y * (half.y + AWAY)), size)
            });
            let is_apart = |rect: &Rect| {
                let others = placed.iter().map(|(_, rect)| rect).chain(taken);
                let grown = rect.expand(2.0);
                room.contains_rect(*rect)
                    && !grown.contains(anchor)
                    && others.into_iter().all(|other| !grown.intersects(*other))
            };
            let is_free =
                |rect: &Rect| is_apart(rect) && labels.iter().all(|other| !rect.expand(2.0).contains(other.anchor));
            let anywhere = || nearest(anchor, size, room, is_free).or_else(|| nearest(anchor, size, room, is_apart));
            let found = beside.into_iter().find(is_free).or_else(|| goes_far.then(anywhere).flatten())?;
            placed.push((anchor, found));
            Some(found)
        })
        .collect()
}

/// The free place in `room` that is nearest to `anchor`, of some.
fn nearest(anchor: Pos2, size: Vec2, room: Rect, is_free: impl Fn(&Rect) -> bool) -> Option<Rect> {
    const STEPS: u8 = 12;
    let play = room.size() - size;
    let steps = || (0..=STEPS).map(|step| f32::from(step) / f32::from(STEPS));
    let places = steps().flat_map(|y| steps().map(move |x| Rect::from_min_size(room.min + play * vec2(x, y), size)));
    let distance = |rect: &Rect| rect.distance_sq_to_pos(anchor);
    places.filter(is_free).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;
    use crate::scene::MediumId;
    use crate::tracking::{Events, Mode};
    use crate::transport::inspect::TracedPath;

    fn line(legs: Vec<Leg>) -> Line {
        let path = TracedPath {
            light: None,
            mode: Mode::Rectified,
            origin: [0.0; 3],
            camera_medium: String::new(),
            vertices: Vec::new(),
            escaped: true,
            final_direction: [1.0, 0.0, 0.0],
            final_medium: String::new(),
            final_medium_id: MediumId::WORLD,
            events: Events::default(),
        };
        Line { path, legs }
    }

    fn leg(share: f64, light: [f64; 2], hidden: u32) -> Leg {
        Leg { from: DVec3::ZERO, to: DVec3::X * 24.0, medium: MediumId(2), share, light, hidden }
    }

    fn flat(place: DVec3) -> Option<Pos2> {
        Some(pos2(place.x as f32, place.y as f32))
    }

    #[test]
    fn a_leg_is_one_stroke_unless_something_changes_along_it() {
        let whole = strokes(&line(vec![leg(1.0, [1.0; 2], 0)]), Weight::Main, flat);
        assert_eq!(whole.len(), 1);
        assert_eq!((whole[0].from, whole[0].to), (pos2(0.0, 0.0), pos2(24.0, 0.0)));
        assert_eq!((whole[0].width, whole[0].opacity, whole[0].color), (WIDTHS[1], 1.0, medium_color(MediumId(2))));
        // The middle third is hidden.
        let parts = strokes(&line(vec![leg(1.0, [1.0; 2], 0xff << 8)]), Weight::Main, flat);
        let shown: Vec<(f32, f32, bool)> = parts.iter().map(|s| (s.from.x, s.to.x, s.is_hidden)).collect();
        assert_eq!(shown, [(0.0, 8.0, false), (8.0, 16.0, true), (16.0, 24.0, false)]);
        assert!(parts[1].opacity < 0.5 * parts[0].opacity);
    }

    #[test]
    fn width_tells_shares_and_opacity_tells_absorption() {
        let thin = strokes(&line(vec![leg(0.04, [1.0; 2], 0)]), Weight::Main, flat)[0].width;
        let thick = strokes(&line(vec![leg(0.96, [1.0; 2], 0)]), Weight::Main, flat)[0].width;
        assert!(thin > WIDTHS[0] && thick > 2.0 * thin);
        let fading = strokes(&line(vec![leg(1.0, [1.0, 0.0], 0)]), Weight::Main, flat);
        assert_eq!(fading.len(), PIECES);
        assert!(fading.windows(2).all(|pair| pair[0].opacity > pair[1].opacity && pair[0].to == pair[1].from));
        assert!(fading[PIECES - 1].opacity >= LEAST_OPACITY);
    }

    #[test]
    fn what_is_behind_the_camera_is_left_out() {
        let screen = |place: DVec3| (place.x >= 12.0).then(|| pos2(place.x as f32, 0.0));
        let cut = strokes(&line(vec![leg(1.0, [1.0; 2], 0)]), Weight::Main, screen);
        assert_eq!((cut.len(), cut[0].from.x, cut[0].to.x), (1, 12.0, 24.0));
    }

    #[test]
    fn labels_stay_apart_and_are_dropped_where_there_is_no_room() {
        let room = Rect::from_min_size(pos2(0.0, 0.0), vec2(300.0, 200.0));
        let size = vec2(60.0, 14.0);
        let label = |x: f32| Label { anchor: pos2(x, 100.0), size, goes_far: false };
        let labels: Vec<Label> = (0..12).map(|k| label(60.0 + 18.0 * k as f32)).collect();
        let taken = [Rect::from_min_size(pos2(0.0, 0.0), vec2(300.0, 70.0))];
        let placed = place_labels(&labels, room, &taken);
        let found: Vec<Rect> = placed.iter().flatten().copied().collect();
        assert!(placed[0].is_some() && found.len() >= 3 && found.len() < labels.len(), "{found:?}");
        for (index, rect) in found.iter().enumerate() {
            assert!(room.contains_rect(*rect) && !rect.intersects(taken[0]));
            assert!(found[index + 1..].iter().all(|other| !rect.intersects(*other)));
        }
        // At one place one label is enough.
        let same = vec![label(150.0); 5];
        assert_eq!(place_labels(&same, room, &[]).iter().flatten().count(), 1);
        assert_eq!(place_labels(&[label(900.0)], room, &[]), [None]);
        // Where all sides are taken, only what may go far has a place, and that as near as it can be.
        let around = [Rect::from_center_size(pos2(150.0, 100.0), vec2(290.0, 90.0))];
        assert_eq!(place_labels(&[label(150.0)], room, &around), [None]);
        let far = place_labels(&[Label { goes_far: true, ..label(150.0) }], room, &around)[0].unwrap();
        assert!(room.contains_rect(far) && !far.intersects(around[0]));
        assert!(far.distance_to_pos(pos2(150.0, 100.0)) < 60.0, "{far:?}");
        // Over other anchors, if it must be.
        let more = [Rect::from_center_size(pos2(150.0, 100.0), vec2(290.0, 150.0))];
        let far = Label { goes_far: true, ..label(150.0) };
        let row = |y: f32| (0..60).map(move |k| Label { anchor: pos2(5.0 * k as f32, y), ..far });
        let crowd: Vec<Label> = [far].into_iter().chain(row(10.0)).chain(row(188.0)).collect();
        let over = place_labels(&crowd, room, &more)[0].unwrap();
        assert!(room.contains_rect(over) && !over.intersects(more[0]), "{over:?}");
    }
}
