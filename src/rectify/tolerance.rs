//! How near two surfaces come before they are in contact.
//!
//! What is meant to touch is rarely modelled to the last bit, and vertices are stored in f32 about the middle of the refractors. So surfaces
//! are one where they are within eight roundings to f32 of each other: roundings of the smaller object's radius, or of their local coordinates
//! across the surface where those are larger. Neither changes when a scene is moved, since the local origin moves along.

use glam::DVec3;

use crate::geometry::Geometry;

/// Eight roundings to f32, as a share of the length that is rounded.
const ROUNDING: f64 = 8.0 / (1u32 << 24) as f64;
/// Share of the smaller object's radius that is allowed for where nothing is rounded to f32: between analytic spheres.
const LEAST: f64 = 1e-12;
/// Sixteen roundings to f64, of scene coordinates: transforms cost so many.
const ROUNDING_OF_F64: f64 = 16.0 / (1u64 << 53) as f64;

/// How far apart surfaces of two objects may be and still be in contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Lengths that are rounded to f32 are at least this long.
    pub length: f64,
    /// Distance that is always allowed for, in scene units: the rounding of f64.
    pub least: f64,
}

impl Tolerance {
    /// Between the surfaces of two objects, or the parts of one.
    pub fn between(geometry: &Geometry, a: u32, b: u32) -> Self {
        let radius = geometry.radius_of(a).min(geometry.radius_of(b));
        let reach = geometry.reach_of(a).max(geometry.reach_of(b));
        Self {
            // Any plane may lie half a step from the local origin, depending on where the scene stands.
            length: radius.max(geometry.step / 2.0),
            least: LEAST * radius + ROUNDING_OF_F64 * (reach + geometry.origin.abs().max_element()),
        }
    }

    /// Along the unit vector `axis`, between faces whose coordinates are no larger than `reach`.
    pub fn along(self, axis: DVec3, reach: DVec3) -> f64 {
        ROUNDING * axis.abs().dot(reach).max(self.length) + self.least
    }
}

/// Bound for the tolerance between an object and any other that reaches no farther from the local origin.
pub fn largest(geometry: &Geometry, object: u32) -> f64 {
    let (radius, reach) = (geometry.radius_of(object), geometry.reach_of(object));
    let length = (3f64.sqrt() * reach).max(radius).max(geometry.step / 2.0);
    ROUNDING * length + LEAST * radius + ROUNDING_OF_F64 * (reach + geometry.origin.abs().max_element())
}

/// For each object, how far around its faces other faces are to be looked for.
pub struct Margins {
    /// Objects with their [`largest`] tolerances, the largest first.
    by_tolerance: Vec<(f64, u32)>,
}

impl Margins {
    pub fn new(geometry: &Geometry, objects: u32) -> Self {
        let mut by_tolerance: Vec<(f64, u32)> = (0..objects)
            .filter(|&object| geometry.face_count(object) > 0)
            .map(|object| (largest(geometry, object), object))
            .collect();
        by_tolerance.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        Self { by_tolerance }
    }

    /// Covers the tolerance between `object` and every object near it.
    pub fn of(&self, geometry: &Geometry, object: u32) -> f64 {
        /// Margin in multiples of the own tolerance: only the few objects with a larger one have to be compared.
        const ROOM: f64 = 4.0;
        let own = ROOM * largest(geometry, object);
        let (min, max) = geometry.bounds_of(object);
        let is_near = |other: u32, margin: f64| {
            let (other_min, other_max) = geometry.bounds_of(other);
            (min - margin).cmple(other_max).all() && (other_min - margin).cmple(max).all()
        };
        (self.by_tolerance.iter())
            .take_while(|(tolerance, _)| *tolerance > own)
            .find(|(tolerance, other)| is_near(*other, *tolerance))
            .map_or(own, |(tolerance, _)| *tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Part;

    fn balls(balls: &[(f64, f64)]) -> Geometry {
        let part = |&(x, radius): &(f64, f64)| Part::Sphere { center: DVec3::X * x, radius };
        Geometry::build(balls.iter().map(part).collect::<Vec<_>>())
    }

    #[test]
    fn the_smaller_object_decides_and_a_third_does_not() {
        let pair = balls(&[(0.0, 1.0), (0.9, 0.2)]);
        let tolerance = Tolerance::between(&pair, 0, 1);
        assert_eq!(tolerance.length, 0.2);
        for third in [(2e12, 1.0), (0.5, 1e4), (-3.0, 1e-3)] {
            let with_third = balls(&[(0.0, 1.0), (0.9, 0.2), third]);
            let same = Tolerance::between(&with_third, 0, 1);
            assert_eq!(same.length, tolerance.length, "{third:?}");
            assert!(same.least < 1e-11, "{third:?}");
        }
    }

    #[test]
    fn moved_far_away_only_the_rounding_of_f64_is_larger() {
        let of = |x: f64| {
            let geometry = balls(&[(x, 1.0), (x + 0.5, 0.5)]);
            let tolerance = Tolerance::between(&geometry, 0, 1);
            let (axis, reach) = (DVec3::X, DVec3::splat(geometry.reach_of(0)));
            (tolerance.along(axis, reach), tolerance)
        };
        for x in [1.0, -17.3, 1e6] {
            let (moved, still) = (of(x), of(0.0));
            assert_eq!(moved.1.length, still.1.length);
            assert!(moved.0 < 1.3 * still.0 && still.0 < 1.3 * moved.0, "{x}: {moved:?}, {still:?}");
        }
    }

    #[test]
    fn margins_reach_to_what_is_large_and_near() {
        let geometry = balls(&[(0.0, 0.01), (500.0, 500.0), (2e12, 1.0)]);
        let margins = Margins::new(&geometry, 3);
        assert!(margins.of(&geometry, 0) >= largest(&geometry, 1));
        assert!(margins.of(&geometry, 0) < 1e-2);
        assert!(margins.of(&geometry, 2) > 1e4);
    }
}
