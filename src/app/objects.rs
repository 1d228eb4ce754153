//! Objects of the scene as the window edits them: refractors, solids and lights alike, by name.

use std::cell::RefCell;
use std::sync::{Arc, Weak};

use glam::{DMat3, DQuat, DVec3, EulerRot};
use serde::{Deserialize, Serialize};

use crate::geometry::Mesh;
use crate::scene::description::{Object, Shape, Transform};

/// What a drag in the picture, or a row of typed numbers, changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Manipulation {
    Move,
    Rotate,
    Scale,
}

impl Manipulation {
    pub const ALL: [Self; 3] = [Self::Move, Self::Rotate, Self::Scale];

    /// On buttons.
    pub fn name(self) -> &'static str {
        match self {
            Self::Move => "Move",
            Self::Rotate => "Rotate",
            Self::Scale => "Scale",
        }
    }

    /// In the menu, after "Undo".
    pub fn doing(self) -> &'static str {
        match self {
            Self::Move => "moving",
            Self::Rotate => "rotating",
            Self::Scale => "scaling",
        }
    }
}

/// Whether the value was another.
pub fn replaced<T: PartialEq>(value: &mut T, new: T) -> bool {
    std::mem::replace(value, new) != *value
}

/// Lowest and highest coordinates.
type Bounds = (DVec3, DVec3);

thread_local! {
    /// The mesh whose bounds were last asked for, and they: the window asks several times for every frame, and meshes can be large.
    static LAST_MESH: RefCell<Option<(Weak<Mesh>, Bounds)>> = const { RefCell::new(None) };
}

/// [`Shape::bounds`]; those of the last mesh are remembered.
pub fn bounds(shape: &Shape) -> Bounds {
    let Shape::Mesh { mesh, .. } = shape else { return shape.bounds() };
    LAST_MESH.with_borrow_mut(|last| match last {
        Some((known, bounds)) if known.upgrade().is_some_and(|known| Arc::ptr_eq(&known, mesh)) => *bounds,
        _ => last.insert((Arc::downgrade(mesh), shape.bounds())).1,
    })
}

/// The point that stays where it is when an object is rotated or scaled, in object space: the middle of its bounds there, which does
/// not wander when the object turns.
pub fn pivot(shape: &Shape) -> DVec3 {
    let (min, max) = bounds(shape);
    (min + max) / 2.0
}

/// The lowest and highest scene coordinates of an object's box.
pub fn scene_bounds(object: &Object) -> Bounds {
    let (min, max) = bounds(&object.shape);
    let matrix = object.transform.matrix();
    if let Shape::Sphere { center, radius } | Shape::Icosphere { center, radius, .. } = object.shape {
        // Scaling may be uneven; rotating a ball's box would enlarge it.
        let (center, radius) = (matrix.transform_point3(center), radius * object.transform.scale.abs().max_element());
        return (center - radius, center + radius);
    }
    (0..8_u32).fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), bits| {
        let pick = |axis: usize| if bits & (1 << axis) == 0 { min[axis] } else { max[axis] };
        let corner = matrix.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
        (low.min(corner), high.max(corner))
    })
}

/// The transform that keeps the object-space point `pivot` where `before` put it.
fn about_pivot(before: &Transform, after: Transform, pivot: DVec3) -> Transform {
    let place = before.matrix().transform_point3(pivot);
    Transform { translate: place - after.matrix().matrix3 * pivot, ..after }
}

/// `before` with other angles, in degrees, about the object's pivot.
pub fn rotated_to(before: &Transform, rotate: DVec3, pivot: DVec3) -> Transform {
    about_pivot(before, Transform { rotate, ..*before }, pivot)
}

/// `before` with another scale, about the object's pivot.
pub fn scaled_to(before: &Transform, scale: DVec3, pivot: DVec3) -> Transform {
    about_pivot(before, Transform { scale, ..*before }, pivot)
}

/// `before` turned further by `rotation`, about the pivot; angles are rounded to `step` degrees.
pub fn rotated_by(before: &Transform, rotation: DQuat, pivot: DVec3, step: f64) -> Transform {
    let turned = DMat3::from_quat(rotation) * rotation_of(before);
    let (z, y, x) = DQuat::from_mat3(&turned).to_euler(EulerRot::ZYX);
    let first = DVec3::new(x, y, z).map(f64::to_degrees);
    // The same rotation in other words; of the two, the one nearer to what was there is what one expects to read.
    let second = DVec3::new(first.x + 180.0, 180.0 - first.y, first.z + 180.0);
    let near = |angles: DVec3| {
        // Each angle within half a turn of the one before.
        let turns = ((angles - before.rotate) / 360.0).round();
        angles - turns * 360.0
    };
    let distance = |angles: DVec3| (angles - before.rotate).abs().element_sum();
    let [first, second] = [near(first), near(second)];
    let chosen = if distance(second) < distance(first) { second } else { first };
    rotated_to(before, chosen.map(|angle| rounded(angle, step)), pivot)
}

/// Rotation alone.
pub fn rotation_of(transform: &Transform) -> DMat3 {
    Transform { scale: DVec3::ONE, ..*transform }.matrix().matrix3
}

/// The nearest multiple of `step`, a power of ten, with no digits beyond it.
pub fn rounded(value: f64, step: f64) -> f64 {
    // Dividing by a whole number gives the double nearest to the decimal, multiplying by its inverse does not.
    let result = if step < 1.0 { (value / step).round() / (1.0 / step).round() } else { (value / step).round() * step };
    // A step so small that its inverse leaves the numbers: nothing to round. And −0 reads badly.
    if result.is_finite() { result + 0.0 } else { value }
}

/// The power of ten at or below `size`, for [`rounded`].
pub fn decade(size: f64) -> f64 {
    10_f64.powf(size.abs().max(1e-300).log10().floor())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transform() -> Transform {
        Transform {
            scale: DVec3::new(2.0, -1.0, 0.5),
            rotate: DVec3::new(20.0, -70.0, 130.0),
            translate: DVec3::new(1.0, 2.0, 3.0),
        }
    }

    #[test]
    fn the_pivot_stays_where_it_is() {
        let pivot = DVec3::new(0.3, -4.0, 2.0);
        let before = transform();
        let place = before.matrix().transform_point3(pivot);
        for after in [
            rotated_to(&before, DVec3::new(5.0, 6.0, 7.0), pivot),
            scaled_to(&before, DVec3::new(3.0, 1.0, -1.0), pivot),
            rotated_by(&before, DQuat::from_axis_angle(DVec3::ONE.normalize(), 1.1), pivot, 1e-4),
        ] {
            assert!(after.matrix().transform_point3(pivot).distance(place) < 1e-12);
        }
    }

    #[test]
    fn turning_is_found_again_in_the_angles() {
        let before = transform();
        for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, -2.0) / 3.0] {
            for angle in [-3.0, -0.5, 0.01, 1.57, 2.9] {
                let rotation = DQuat::from_axis_angle(axis, angle);
                let after = rotated_by(&before, rotation, DVec3::ZERO, 1e-9);
                let wanted = DMat3::from_quat(rotation) * rotation_of(&before);
                assert!(rotation_of(&after).abs_diff_eq(wanted, 1e-9), "{axis} {angle}");
            }
        }
    }

    #[test]
    fn bounds_of_the_last_mesh_are_those_of_the_mesh() {
        let mesh = |x: f64| {
            Shape::mesh(
                "m.obj",
                Arc::new(Mesh { positions: vec![DVec3::ZERO, DVec3::X * x, DVec3::Y], ..Mesh::default() }),
            )
        };
        let (a, b) = (mesh(2.0), mesh(3.0));
        for shape in [&a, &a, &b, &b, &a] {
            assert_eq!(bounds(shape), shape.bounds());
        }
        assert_eq!(bounds(&b).1, DVec3::new(3.0, 1.0, 0.0));
    }

    #[test]
    fn rounded_numbers_are_short() {
        assert_eq!(rounded(0.1 + 0.2, 1e-4), 0.3);
        assert_eq!(rounded(29.999_999_7, 1e-4), 30.0);
        assert_eq!(rounded(-0.000_01, 1e-4).to_bits(), 0.0_f64.to_bits());
        assert_eq!(rounded(1234.0, 100.0), 1200.0);
        assert_eq!((decade(0.034), decade(700.0), decade(1.0)), (0.01, 100.0, 1.0));
    }
}
