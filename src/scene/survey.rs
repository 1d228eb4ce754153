//! Works out what a scene needs.

use glam::DVec3;

use super::lights::{Emitters, EnvironmentLight};
use super::needs::SceneNeeds;
use super::scene::{Object, Scene, SceneMedium, Surface};
use crate::geometry::Geometry;

impl SceneNeeds {
    /// Works out the needs of a compiled scene. In doubt: needed.
    pub(super) fn of(
        geometry: &Geometry,
        objects: &[Object],
        media: &[SceneMedium],
        emitters: &Emitters,
        environment: &EnvironmentLight,
    ) -> Self {
        let refractors: Vec<(usize, usize)> = (objects.iter().enumerate())
            .filter_map(|(index, object)| match object.surface {
                Surface::Refractor { medium, .. } => Some((index, medium.0 as usize)),
                _ => None,
            })
            .collect();
        let mut indices: Vec<f64> = refractors.iter().map(|&(_, medium)| media[medium].ior_minus_one).collect();
        // The global medium, and the reserved one that `naive` puts outside.
        indices.push(media[0].ior_minus_one);
        if media[0].ior_minus_one != 0.0 {
            indices.push(0.0);
        }
        indices.sort_by(f64::total_cmp);
        let is_smooth = |object: &Object| {
            matches!(
                object.surface,
                Surface::Refractor { smooth: true, .. }
                    | Surface::Diffuse { smooth: true, .. }
                    | Surface::Mirror { smooth: true, .. }
            )
        };
        Self {
            nesting: media[0].ior_minus_one != 0.0
                || refractors.iter().any(|r| objects[r.0].may_contain_itself())
                || any_overlap(refractors.iter().map(|r| geometry.bounds_of(r.0 as u32)).collect()),
            absorption: refractors.iter().map(|r| r.1).chain([0]).any(|medium| !media[medium].absorption.is_black()),
            index_matching: indices.windows(2).any(|pair| pair[0] == pair[1]),
            smooth_normals: objects.iter().any(is_smooth),
            spheres: geometry.sphere_count() > 0,
            triangles: geometry.triangle_count() > 0,
            emitters: !emitters.is_empty(),
            image_environment: environment.is_image(),
            textures: objects.iter().any(Object::has_texture),
        }
    }

    /// Turns off what the scene has no data for: a picture without an environment image cannot sample one.
    pub fn without_impossible(self, scene: &Scene) -> Self {
        Self {
            image_environment: self.image_environment && scene.environment.is_image(),
            emitters: self.emitters && !scene.emitters.is_empty(),
            textures: self.textures && scene.needs.textures,
            ..self
        }
    }
}

/// Whether any two of these boxes overlap. They are halved where the fewest lie on both sides of the cut; boxes that no cut takes apart are
/// compared with each other, and where there are many of those a pair that overlaps is soon found. O(N log² N) for boxes that are apart.
fn any_overlap(mut boxes: Vec<(DVec3, DVec3)>) -> bool {
    /// So few are compared at once.
    const FEW: usize = 16;
    /// A cut that leaves more than this share on one side is not worth making.
    const WORTHWHILE: f64 = 0.9;
    if boxes.len() > FEW {
        let cut = |axis: usize| {
            let mut ends: Vec<f64> = boxes.iter().map(|(_, max)| max[axis]).collect();
            let middle = ends.len() / 2;
            let (_, plane, _) = ends.select_nth_unstable_by(middle, f64::total_cmp);
            let plane = *plane;
            let before = boxes.iter().filter(|(min, _)| min[axis] <= plane).count();
            let behind = boxes.iter().filter(|(_, max)| max[axis] >= plane).count();
            (before.max(behind), axis, plane)
        };
        let (most, axis, plane) = (0..3).map(cut).min_by_key(|(most, ..)| *most).expect("there are three axes");
        if most as f64 <= WORTHWHILE * boxes.len() as f64 {
            let before = boxes.iter().copied().filter(|(min, _)| min[axis] <= plane).collect();
            boxes.retain(|(_, max)| max[axis] >= plane);
            return any_overlap(before) || any_overlap(boxes);
        }
    }
    boxes.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    boxes.iter().enumerate().any(|(index, (min, max))| {
        (boxes[index + 1..].iter())
            .take_while(|other| other.0.x <= max.x)
            .any(|other| other.0.cmple(*max).all() && min.cmple(other.1).all())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes on a grid, in a wall and in a row are apart until one is moved.
    #[test]
    fn overlapping_boxes_are_found() {
        for sides in [[20, 20, 20], [1, 90, 90], [8000, 1, 1], [1, 1, 1]] {
            let count = sides[0] * sides[1] * sides[2];
            let corner = |k: u32| {
                DVec3::new(
                    f64::from(k % sides[0]),
                    f64::from(k / sides[0] % sides[1]),
                    f64::from(k / sides[0] / sides[1]),
                )
            };
            let mut boxes: Vec<_> = (0..count).map(|k| (corner(k), corner(k) + 0.9)).collect();
            assert!(!any_overlap(boxes.clone()));
            let added = corner(count * 2 / 3) + 0.85;
            boxes.push((added, added + 0.01));
            assert!(any_overlap(boxes));
        }
        assert!(!any_overlap(Vec::new()));
        // One around all the others.
        let boxes: Vec<_> = (1..200).map(|k| (DVec3::splat(-f64::from(k)), DVec3::splat(f64::from(k)))).collect();
        assert!(any_overlap(boxes));
    }
}
