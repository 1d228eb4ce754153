//! A liquid in a vessel: the part of the room inside that lies below its surface.
//!
//! Its wall reaches into the vessel's, where the vessel has the higher priority: what is hidden there is the vessel's, and no thin film of
//! air or of doubt is left between the two.

use glam::DVec2;

use crate::scene::description::Shape;
use crate::scene::shapes::validate;

/// How far the liquid reaches into the wall, as a share of the wall's least thickness.
const DEPTH_IN_WALL: f64 = 0.4;

/// The inside of a vessel, which is a lathe.
#[derive(Debug, Clone, PartialEq)]
pub struct Inside {
    /// From the axis along the inner wall to the rim.
    wall: Vec<DVec2>,
    /// From the axis along the outer wall to the rim.
    outer: Vec<DVec2>,
    segments: u32,
}

impl Inside {
    /// # Errors
    /// Says why the shape holds no liquid.
    pub fn of(shape: &Shape) -> Result<Self, String> {
        let Shape::Lathe { profile, segments } = shape else {
            return Err("only vessels made by a lathe can be filled".to_owned());
        };
        let mut points: Vec<DVec2> = profile.iter().copied().map(DVec2::from).collect();
        points.dedup();
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            return Err("the profile has no points".to_owned());
        };
        if first.x != 0.0 || last.x != 0.0 {
            return Err("the vessel has a hole in its bottom: its profile must begin and end on the axis".to_owned());
        }
        if first.y > last.y {
            points.reverse();
        }
        let rim = (points.iter().enumerate()).fold(0, |rim, (i, p)| if p.y >= points[rim].y { i } else { rim });
        // Of a flat rim, the inner edge.
        let wall: Vec<DVec2> = points[rim..].iter().rev().copied().collect();
        let outer = points[..=rim].to_vec();
        if wall.len() < 2 || wall.iter().all(|p| p.y >= wall[wall.len() - 1].y) {
            return Err("the shape has no inside: its highest point is on the axis".to_owned());
        }
        Ok(Self { wall, outer, segments: *segments })
    }

    /// The deepest point inside and the rim, as y.
    pub fn depth(&self) -> [f64; 2] {
        let deepest = self.wall.iter().fold(f64::INFINITY, |low, p| low.min(p.y));
        [deepest, self.wall[self.wall.len() - 1].y]
    }

    /// The liquid that fills a share of the depth, in (0, 1).
    ///
    /// # Errors
    /// When that is no share, or leaves nothing that has a volume.
    pub fn filled(&self, share: f64) -> Result<Shape, String> {
        if !(share > 0.0 && share < 1.0) {
            return Err(format!(
                "a vessel is filled to more than 0 % and less than 100 % of its depth, not to {} %",
                share * 100.0
            ));
        }
        let [bottom, rim] = self.depth();
        let height = bottom + share * (rim - bottom);
        let wetted = self.below(height);
        let thickness = self.thickness(&wetted);
        let mut first_fault = String::new();
        // Where the wall turns sharply, less of it may have to do.
        for part in [1.0, 0.5, 0.25, 0.1, 0.0] {
            let profile = profile(&wetted, part * DEPTH_IN_WALL * thickness, height);
            let shape = Shape::Lathe { profile, segments: self.segments };
            match validate(&shape) {
                Ok(()) => return Ok(shape),
                Err(fault) if first_fault.is_empty() => first_fault = fault.message,
                Err(_) => {}
            }
        }
        Err(first_fault)
    }

    /// To what share of the depth `liquid` fills the vessel; `None` where it is not what [`Self::filled`] makes.
    pub fn share_of(&self, liquid: &Shape) -> Option<f64> {
        let Shape::Lathe { profile, .. } = liquid else { return None };
        let [bottom, rim] = self.depth();
        let top = profile.iter().fold(f64::NEG_INFINITY, |top: f64, [_, y]| top.max(*y));
        let share = (top - bottom) / (rim - bottom);
        let Shape::Lathe { profile: expected, .. } = self.filled(share).ok()? else { return None };
        // The height is found again up to rounding.
        let is_near = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < 1e-6 * (rim - bottom);
        (profile.len() == expected.len() && profile.iter().zip(&expected).all(|(a, b)| is_near(a, b))).then_some(share)
    }

    /// The piece of the inner wall that a liquid up to `height` wets: from the axis, or where the bottom rises above the surface in the
    /// middle, from there.
    fn below(&self, height: f64) -> Vec<DVec2> {
        let mut wetted: Vec<DVec2> = Vec::new();
        if self.wall[0].y < height {
            wetted.push(self.wall[0]);
        }
        for piece in self.wall.windows(2) {
            let [a, b] = [piece[0], piece[1]];
            let crossing = || a.lerp(b, (height - a.y) / (b.y - a.y)).with_y(height);
            match (a.y < height, b.y < height) {
                (true, true) => wetted.push(b),
                (true, false) => {
                    wetted.push(crossing());
                    break;
                }
                (false, true) => wetted.extend([crossing(), b]),
                (false, false) => {}
            }
        }
        wetted
    }

    /// Least distance from a wetted point to the vessel's other side.
    fn thickness(&self, wetted: &[DVec2]) -> f64 {
        let to_outer = |p: &DVec2| {
            let pieces = self.outer.windows(2).map(|piece| distance_to_piece(*p, piece[0], piece[1]));
            pieces.fold(f64::INFINITY, f64::min)
        };
        wetted.iter().map(to_outer).fold(f64::INFINITY, f64::min)
    }
}

fn distance_to_piece(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    p.distance(a + along * t)
}

/// The outline of a liquid with its surface at `height`, whose wall is moved outward by `reach`.
fn profile(wetted: &[DVec2], reach: f64, height: f64) -> Vec<[f64; 2]> {
    let last = wetted.len() - 1;
    // To the right of the way outwards and up along the wall, which is away from the liquid.
    let away = |a: DVec2, b: DVec2| {
        let along = (b - a).normalize_or_zero();
        DVec2::new(along.y, -along.x)
    };
    let mut points: Vec<[f64; 2]> = (0..=last)
        .map(|i| {
            let before = (i > 0).then(|| away(wetted[i - 1], wetted[i]));
            let after = (i < last).then(|| away(wetted[i], wetted[i + 1]));
            let [before, after] = [before.or(after), after.or(before)].map(Option::unwrap_or_default);
            // Both sides are moved by `reach`; where they turn sharply, the corner no farther than twice that.
            let between = (before + after).normalize_or(before);
            let mut moved = wetted[i] + between * (reach / between.dot(before).max(0.5));
            let is_surface = wetted[i].y == height;
            if is_surface {
                // Along the surface.
                moved = wetted[i] + DVec2::new(reach.copysign(between.x), 0.0);
            } else if wetted[i].x == 0.0 {
                moved = wetted[i] - DVec2::Y * reach;
            }
            [moved.x.max(0.0), moved.y]
        })
        .collect();
    if wetted[0].x == 0.0 {
        points.push([0.0, height]);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::build::profiles::Vessel;

    fn vessels() -> Vec<(&'static str, Shape)> {
        let mut all: Vec<_> = (Vessel::ALL.iter())
            .map(|vessel| (vessel.name, Shape::Lathe { profile: vessel.profile(1.0), segments: 16 }))
            .collect();
        // A bottom that rises in the middle, and the same outline the other way round.
        let punt = vec![[0.0, 0.2], [0.5, 0.0], [0.6, 1.0], [0.55, 1.0], [0.5, 0.1], [0.3, 0.12], [0.0, 0.35]];
        all.push(("punt", Shape::Lathe { profile: punt.iter().rev().copied().collect(), segments: 16 }));
        all.push(("reversed punt", Shape::Lathe { profile: punt, segments: 16 }));
        all
    }

    /// Whether a point of the half-plane is in an outline that is closed along the axis.
    fn is_inside(shape: &Shape, p: DVec2) -> bool {
        let Shape::Lathe { profile, .. } = shape else { panic!("no lathe") };
        let ends = |i: usize| (DVec2::from(profile[i]), DVec2::from(profile[(i + 1) % profile.len()]));
        let crosses =
            |(a, b): (DVec2, DVec2)| (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x);
        (0..profile.len()).filter(|&i| crosses(ends(i))).count() % 2 == 1
    }

    /// Everywhere below the surface in the inside there is liquid, above none, and it stays within the vessel's outline.
    #[test]
    fn a_liquid_fills_all_that_is_below_its_surface() {
        for (name, vessel) in vessels() {
            let inside = Inside::of(&vessel).unwrap();
            let [bottom, rim] = inside.depth();
            let (_, most) = vessel.bounds();
            for share in [0.03, 0.2, 0.5, 0.8, 0.97] {
                let liquid = inside.filled(share).unwrap_or_else(|why| panic!("{name} to {share}: {why}"));
                let height = bottom + share * (rim - bottom);
                let mut count = 0;
                for i in 0..80 {
                    for j in 0..80 {
                        // Off round numbers, which the outlines have.
                        let p =
                            DVec2::new((f64::from(i) + 0.137) / 80.0 * most.x, (f64::from(j) + 0.211) / 80.0 * most.y);
                        let is_glass = is_inside(&vessel, p);
                        let is_liquid = is_inside(&liquid, p);
                        // In the room: neither above the surface, nor outside of the wall, nor below the bottom.
                        let is_room = !is_glass
                            && p.y < height
                            && p.y > bottom
                            && {
                                let outward = (0..400).map(|k| DVec2::new(p.x + f64::from(k) / 400.0 * most.x, p.y));
                                outward.into_iter().any(|q| is_inside(&vessel, q))
                            }
                            && (0..400)
                                .any(|k| is_inside(&vessel, DVec2::new(p.x, p.y - f64::from(k) / 400.0 * most.y)));
                        if is_room {
                            count += 1;
                            assert!(is_liquid, "{name} to {share}: no liquid at {p}");
                        } else if is_liquid {
                            assert!(is_glass && p.y < height, "{name} to {share}: liquid outside at {p}");
                        }
                    }
                }
                assert!(count > 0 || share < 0.1, "{name} to {share}");
                let found = inside.share_of(&liquid).unwrap_or_else(|| panic!("{name} to {share}: not known again"));
                assert!((found - share).abs() < 1e-9, "{name}: {found} for {share}");
            }
        }
    }

    #[test]
    fn what_holds_nothing_says_why() {
        let ball = Shape::Sphere { center: glam::DVec3::ZERO, radius: 1.0 };
        let pipe = Shape::Lathe { profile: vec![[0.5, 0.0], [0.6, 0.0], [0.6, 1.0], [0.5, 1.0]], segments: 8 };
        let cone = Shape::Lathe { profile: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], segments: 8 };
        for (shape, word) in [(ball, "lathe"), (pipe, "hole"), (cone, "no inside")] {
            let why = Inside::of(&shape).unwrap_err();
            assert!(why.contains(word), "{why}");
        }
        let inside = Inside::of(&vessels()[0].1).unwrap();
        for share in [0.0, 1.0, -3.0, f64::NAN, f64::INFINITY] {
            assert!(inside.filled(share).is_err());
        }
        let other = Inside::of(&vessels()[1].1).unwrap().filled(0.5).unwrap();
        assert_eq!(inside.share_of(&other), None);
    }
}
