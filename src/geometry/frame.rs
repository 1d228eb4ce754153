//! Where a scene's local coordinates have their origin. Vertices are stored in f32 about it, so what lies near it keeps most digits.

use glam::DVec3;
use rayon::prelude::*;

use super::part::Part;

/// Objects that are tried as the middle of the frame, at the most.
const CANDIDATES: usize = 16;
/// Vertices that one thread looks at.
const CHUNK: usize = 1 << 14;
/// The origin is moved in steps of at most this share of the radius of the object in the middle, and so lies at most half a step from its
/// center along each axis.
const STEP: f64 = 0.25;

/// The origin of local coordinates, a multiple of a power of two: coordinates of few digits stay exact, and a scene that is moved by a multiple
/// of it keeps every bit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Frame {
    pub origin: DVec3,
    /// That power of two; 0 where there is nothing.
    pub step: f64,
}

impl Frame {
    /// The frame about one of `parts`: the one that costs all of them the fewest digits, each measured by its own size. A part that is far from
    /// all others thus loses its own digits and not theirs. `None` where nothing has a size.
    pub fn about<'a>(parts: impl IntoIterator<Item = &'a Part>) -> Option<Self> {
        let parts: Vec<&Part> = parts.into_iter().collect();
        let balls: Vec<(DVec3, f64)> = parts.into_par_iter().filter_map(ball).collect();
        let stride = balls.len().div_ceil(CANDIDATES).max(1);
        let candidates: Vec<(DVec3, f64)> = balls.iter().step_by(stride).copied().collect();
        let costs: Vec<f64> = (candidates.par_iter())
            .map(|&(middle, _)| {
                balls.iter().map(|&(center, radius)| (1.0 + middle.distance(center) / radius).ln()).sum()
            })
            .collect();
        let mut best: Option<usize> = None;
        for (index, cost) in costs.iter().enumerate() {
            // Equal but for rounding: the first, or else it would depend on where the scene stands.
            if best.is_none_or(|best| *cost < costs[best] * (1.0 - 1e-6)) {
                best = Some(index);
            }
        }
        let (center, radius) = candidates[best?];
        let step = power_of_two(STEP * radius);
        Some(Self { origin: (center / step).round() * step + 0.0, step })
    }
}

/// The middle of a part's box, and half of its longest side; `None` where it has no size.
fn ball(part: &Part) -> Option<(DVec3, f64)> {
    match part {
        Part::Mesh { mesh, .. } => {
            const NOTHING: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let (min, max) = (mesh.positions.par_chunks(CHUNK))
                .map(|chunk| chunk.iter().fold(NOTHING, |(min, max), p| (min.min(*p), max.max(*p))))
                .reduce(|| NOTHING, |a, b| (a.0.min(b.0), a.1.max(b.1)));
            let radius = (max - min).max_element() / 2.0;
            (radius > 0.0).then_some(((min + max) / 2.0, radius))
        }
        Part::Sphere { center, radius } => Some((*center, *radius)),
        Part::Point(_) => None,
    }
}

/// The largest power of two that is not above `x` > 0.
fn power_of_two(x: f64) -> f64 {
    // Of numbers too small to have one as a normal number, any will do.
    f64::from_bits(x.max(f64::MIN_POSITIVE).to_bits() & (0x7ff << 52))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere(center: DVec3, radius: f64) -> Part {
        Part::Sphere { center, radius }
    }

    #[test]
    fn a_power_of_two() {
        for (x, expected) in [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (0.3, 0.25), (3e-5, 2f64.powi(-16))] {
            assert_eq!(power_of_two(x), expected);
        }
    }

    /// A part that stands alone, near or far, large or small, does not take the origin away from those that stand together.
    #[test]
    fn the_origin_is_where_most_digits_are_needed() {
        let together = [sphere(DVec3::ZERO, 1.0), sphere(DVec3::new(0.3, 0.1, 0.2), 0.01)];
        for (distance, radius) in [(10.0, 1.0), (2e12, 1.0), (2e12, 1e-3), (1e4, 1e4), (2e6, 100.0)] {
            let alone = sphere(DVec3::new(0.6, -0.8, 0.0) * distance, radius);
            let frame = Frame::about(together.iter().chain([&alone])).unwrap();
            assert!(frame.origin.length() < 0.5, "{distance}, {radius}: {}", frame.origin);
            let frame = Frame::about([&alone].into_iter().chain(&together)).unwrap();
            assert!(frame.origin.length() < 0.5, "{distance}, {radius}: {}", frame.origin);
        }
    }

    /// A scene that is moved takes its origin along, to within a step.
    #[test]
    fn the_origin_moves_with_the_scene() {
        let scene = |by: DVec3| {
            let parts = [
                sphere(by + DVec3::new(0.1, 0.2, 0.3), 0.7),
                sphere(by + DVec3::new(-0.4, 0.9, 0.0), 0.7),
                sphere(by + DVec3::new(5.0, 0.1, 0.3), 9.0),
            ];
            Frame::about(&parts).unwrap()
        };
        let still = scene(DVec3::ZERO);
        assert_eq!(still.step, 0.125);
        assert_eq!(scene(DVec3::splat(1024.0)).origin, still.origin + DVec3::splat(1024.0));
        for by in [DVec3::new(1.7, -0.3, 12.0), DVec3::new(1e6, -3e5, 7.77)] {
            let moved = scene(by);
            assert_eq!(moved.step, still.step);
            assert!((moved.origin - by - still.origin).abs().max_element() <= still.step * 1.0001);
        }
    }

    #[test]
    fn of_nothing() {
        assert_eq!(Frame::about(&[]), None);
        let point = Part::Mesh { mesh: super::super::Mesh::default(), smooth: false };
        assert_eq!(Frame::about(&[point]), None);
    }
}
