//! Points of surfaces and directions from them, spread evenly and the same in every check.

use glam::DVec3;

use crate::geometry::{Geometry, SurfacePoint, uniform_direction};

/// Point `index` of the additive recurrence in five dimensions: multiples of the powers of 1/φ₅, φ₅ the root of x⁶ = x + 1 (Roberts, "The
/// Unreasonable Effectiveness of Quasirandom Sequences", 2018).
fn recurrence(index: u32) -> [f64; 5] {
    const ROOT: f64 = 1.134_724_138_401_519_5;
    let mut step = 1.0;
    [(); 5].map(|()| {
        step /= ROOT;
        (0.5 + step * f64::from(index + 1)).fract()
    })
}

/// Points of an object's surface, uniform by area, each with a direction that is uniform over the sphere and has nothing to do with it.
/// None where the object has no area.
pub(super) fn of_surface(
    geometry: &Geometry,
    object: u32,
    range: std::ops::Range<u32>,
) -> impl Iterator<Item = (SurfacePoint, DVec3)> {
    range.filter_map(move |index| {
        let [a, b, c, d, e] = recurrence(index);
        Some((geometry.sample_surface(object, [a, b, c])?, uniform_direction([d, e])))
    })
}

/// Directions, uniform over the sphere.
pub(super) fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(|index| {
        let [a, b, ..] = recurrence(index);
        uniform_direction([a, b])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Part;

    #[test]
    fn the_root_is_one() {
        let x: f64 = 1.134_724_138_401_519_5;
        assert!((x.powi(6) - x - 1.0).abs() < 1e-14);
    }

    /// Means over the sphere are zero, and points and directions are not correlated.
    #[test]
    fn points_and_directions_are_even() {
        let geometry = Geometry::build(&[Part::Sphere { center: DVec3::ZERO, radius: 2.0 }]);
        let all: Vec<(SurfacePoint, DVec3)> = of_surface(&geometry, 0, 0..256).collect();
        assert_eq!(all.len(), 256);
        let mean = |f: &dyn Fn(&(SurfacePoint, DVec3)) -> DVec3| all.iter().map(f).sum::<DVec3>().length() / 256.0;
        assert!(mean(&|(point, _)| point.normal) < 0.05);
        assert!(mean(&|(_, direction)| *direction) < 0.05);
        let along = all.iter().map(|(point, direction)| point.normal.dot(*direction)).sum::<f64>() / 256.0;
        assert!(along.abs() < 0.1, "{along}");
        assert!(directions(256).sum::<DVec3>().length() / 256.0 < 0.05);
    }
}
