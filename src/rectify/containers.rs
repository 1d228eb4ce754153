//! Which refractors the surface of each refractor lies in, and how much of it: for a tree of what contains what.
//!
//! Where patches are mixed, points on them are asked about. A place where another refractor has precedence over the object itself is no
//! part of its surface: it does not count.

use rayon::prelude::*;

use super::containment::{containment_beside, top};
use super::patch::PatchKind;
use super::subjects::primitives_of;
use super::table::InterfaceTable;
use crate::geometry::{PrimitiveId, SurfacePoint};
use crate::scene::{ObjectId, Scene};

/// Points that are asked about in all, and the most and least of them for one object.
const POINTS: usize = 8192;
const POINTS_OF_ONE: [usize; 2] = [8, 96];
/// Smaller parts of a surface are not told of.
const LEAST_SHARE: f64 = 0.01;

/// A part of a refractor's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// The refractor that fills the outer side there; `None` is the global medium.
    pub container: Option<ObjectId>,
    /// Share of the surface's area, in [0, 1].
    pub share: f64,
}

/// The parts of every refractor's surface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Containers {
    /// By object id; parts with the largest first.
    parts: Vec<Vec<Part>>,
    /// By object id: where it stands in a tree.
    parents: Vec<Option<ObjectId>>,
}

impl Containers {
    pub(super) fn new(scene: &Scene, table: &InterfaceTable) -> Self {
        let refractors: Vec<ObjectId> = scene.refractors().map(|(id, _)| id).collect();
        let is_mixed =
            |refractor: &ObjectId| table.patches_of(*refractor).iter().any(|patch| patch.kind == PatchKind::Mixed);
        let mixed = refractors.iter().filter(|refractor| is_mixed(refractor)).count();
        let [least, most] = POINTS_OF_ONE;
        let points = (POINTS / mixed.max(1)).clamp(least, most);
        let parts: Vec<Vec<Part>> =
            refractors.par_iter().map(|refractor| parts(scene, table, *refractor, points)).collect();
        // From the largest to the smallest, and never below itself: of two objects that each lie in the other, the smaller is inside.
        let mut order = refractors;
        order.sort_by(|a, b| scene.object(*b).volume.total_cmp(&scene.object(*a).volume).then(a.cmp(b)));
        let mut parents: Vec<Option<ObjectId>> = vec![None; parts.len()];
        for refractor in order {
            let is_below_itself = |mut above: ObjectId| {
                while above != refractor {
                    match parents[above.0 as usize] {
                        Some(next) => above = next,
                        None => return false,
                    }
                }
                true
            };
            let first = parts[refractor.0 as usize]
                .iter()
                .map(|part| part.container)
                .find(|container| container.is_none_or(|above| !is_below_itself(above)));
            parents[refractor.0 as usize] = first.flatten();
        }
        Self { parts, parents }
    }

    /// The parts of a refractor's surface, the largest first. Empty where nothing of it counts.
    pub fn parts_of(&self, refractor: ObjectId) -> &[Part] {
        self.parts.get(refractor.0 as usize).map_or(&[], Vec::as_slice)
    }

    /// The refractor that most of this one's surface lies in; `None` is the global medium. Whoever follows these upwards comes to an end.
    pub fn parent_of(&self, refractor: ObjectId) -> Option<ObjectId> {
        self.parents.get(refractor.0 as usize).copied().flatten()
    }

    /// Whether the surface lies in several.
    pub fn is_mixed(&self, refractor: ObjectId) -> bool {
        self.parts_of(refractor).len() > 1
    }
}

fn parts(scene: &Scene, table: &InterfaceTable, refractor: ObjectId, points: usize) -> Vec<Part> {
    let mut areas: Vec<(Option<ObjectId>, f64)> = Vec::new();
    let mut add = |container: Option<ObjectId>, area: f64| match areas.iter_mut().find(|known| known.0 == container) {
        Some(known) => known.1 += area,
        None => areas.push((container, area)),
    };
    let mut mixed_area = 0.0;
    for patch in table.patches_of(refractor) {
        match patch.kind {
            PatchKind::Mixed => mixed_area += patch.area,
            PatchKind::Masked => {}
            PatchKind::Clear | PatchKind::Null => {
                if patch.inside_refractor == Some(refractor) && patch.outside_refractor != Some(refractor) {
                    add(patch.outside_refractor, patch.area);
                }
            }
        }
    }
    if mixed_area > 0.0 {
        let found = asked(scene, table, refractor, points);
        let each = mixed_area / found.len().max(1) as f64;
        found.into_iter().flatten().for_each(|container| add(container, each));
    }
    let whole: f64 = areas.iter().map(|(_, area)| area).sum();
    if areas.is_empty() {
        // Others have precedence everywhere: where it would be.
        let main = table.main_patch(refractor);
        return main.map(|patch| Part { container: patch.outside_refractor, share: 1.0 }).into_iter().collect();
    }
    areas.retain(|(_, area)| *area >= LEAST_SHARE * whole);
    areas.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let kept: f64 = areas.iter().map(|(_, area)| area).sum();
    areas.into_iter().map(|(container, area)| Part { container, share: area / kept.max(f64::MIN_POSITIVE) }).collect()
}

/// What fills the outer side at points that are spread over the mixed patches, evenly by area; `None` where the place does not count.
fn asked(scene: &Scene, table: &InterfaceTable, refractor: ObjectId, points: usize) -> Vec<Option<Option<ObjectId>>> {
    let geometry = &scene.geometry;
    let mixed: Vec<PrimitiveId> =
        primitives_of(geometry, refractor).filter(|primitive| table.is_mixed(refractor, *primitive)).collect();
    let mut sum = 0.0;
    let sums: Vec<f64> = mixed
        .iter()
        .map(|primitive| {
            sum += geometry.primitive_area(*primitive);
            sum
        })
        .collect();
    let point = |index: usize| -> Option<(SurfacePoint, [f64; 2])> {
        // Powers of the plastic number's reciprocal spread points evenly (Roberts 2018).
        let spread = |step: f64| (0.5 + step * (index + 1) as f64).fract();
        let along = (index as f64 + 0.5) / points as f64 * sum;
        let primitive = *mixed.get(sums.partition_point(|sum| *sum <= along).min(mixed.len().checked_sub(1)?))?;
        let u = [spread(0.754_877_666_246_692_7), spread(0.569_840_290_998_053_2)];
        let barycentric = if u[0] + u[1] > 1.0 { [1.0 - u[0], 1.0 - u[1]] } else { u };
        Some((geometry.sample_primitive(primitive, u)?, barycentric))
    };
    (0..points)
        .filter_map(point)
        .map(|(point, barycentric)| {
            if table.look(scene, refractor, &point, barycentric).is_masked() {
                return None;
            }
            let inner = containment_beside(scene, &point, false).refractors;
            if top(scene, inner.into_iter().chain([refractor])) != Some(refractor) {
                return None;
            }
            let outer = top(scene, containment_beside(scene, &point, true).refractors);
            (outer != Some(refractor)).then_some(outer)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;
    use std::path::Path;

    use super::*;
    use crate::formats;
    use crate::scene::compile::compile;

    /// (name, medium, priority, shape)
    type Refractor<'a> = (&'a str, &'a str, i32, &'a str);

    fn found(refractors: &[Refractor<'_>]) -> (Scene, Containers) {
        let mut text = "[camera]\nposition = [0, 0, 10]\ntarget = [0, 0, 0]\nvertical_fov = 40\n".to_owned();
        for (name, ior) in [("water", 1.333), ("glass", 1.5), ("air", 1.0)] {
            writeln!(text, "[[medium]]\nname = \"{name}\"\nior = {ior}").unwrap();
        }
        for (name, medium, priority, shape) in refractors {
            let head = format!("[[refractor]]\nname = \"{name}\"\nmedium = \"{medium}\"\npriority = {priority}\n");
            writeln!(text, "{head}shape = {shape}").unwrap();
        }
        let description = formats::parse(&text, Path::new("nest.toml"), &formats::Disk).unwrap();
        let scene = compile(&description, None).unwrap();
        let table = InterfaceTable::new(&scene);
        let containers = Containers::new(&scene, &table);
        (scene, containers)
    }

    /// For every refractor, what it stands below and whether it is mixed.
    fn tree(refractors: &[Refractor<'_>]) -> Vec<(String, bool)> {
        let (scene, containers) = found(refractors);
        scene
            .refractors()
            .map(|(id, _)| {
                let parent = containers.parent_of(id).map_or("world".to_owned(), |id| scene.object(id).name.clone());
                (parent, containers.is_mixed(id))
            })
            .collect()
    }

    fn ball(center: f64, radius: f64, is_mesh: bool) -> String {
        let (kind, more) = if is_mesh { ("icosphere", ", subdivisions = 3") } else { ("sphere", "") };
        format!("{{ {kind} = {{ center = [{center}, 0, 0], radius = {radius}{more} }} }}")
    }

    const POOL: &str = "{ box = { min = [-4, -4, -4], max = [4, 4, 4] } }";

    #[test]
    fn a_ball_across_a_bubble_is_in_the_water_that_both_are_in() {
        for is_mesh in [false, true] {
            let (glass, air) = (ball(0.0, 1.0, is_mesh), ball(1.2, 0.9, is_mesh));
            let shapes = [("pool", "water", 0, POOL), ("ball", "glass", 0, &*glass), ("bubble", "air", 0, &*air)];
            // The smaller bubble has precedence: where it is, the ball has no surface.
            let expected = [("world", false), ("pool", false), ("pool", true)];
            assert_eq!(tree(&shapes), expected.map(|(name, mixed)| (name.to_owned(), mixed)), "meshes: {is_mesh}");
            // With more priority the ball has its whole surface, part of it in the bubble.
            let shapes = [("pool", "water", 0, POOL), ("ball", "glass", 1, &*glass), ("bubble", "air", 0, &*air)];
            let expected = [("world", false), ("pool", true), ("pool", false)];
            assert_eq!(tree(&shapes), expected.map(|(name, mixed)| (name.to_owned(), mixed)), "meshes: {is_mesh}");
        }
    }

    #[test]
    fn what_is_half_in_something_stands_where_most_of_it_is() {
        for (height, expected, share) in [(-0.5, "pool", 0.75), (0.5, "world", 0.75), (-0.9, "pool", 0.95)] {
            for kind in ["sphere", "icosphere"] {
                let more = if kind == "icosphere" { ", subdivisions = 4" } else { "" };
                let glass = format!("{{ {kind} = {{ center = [0, {height}, 0], radius = 1{more} }} }}");
                let pool = "{ box = { min = [-4, -4, -4], max = [4, 0, 4] } }";
                let (scene, containers) = found(&[("pool", "water", 0, pool), ("ball", "glass", 1, &*glass)]);
                let parent = containers.parent_of(ObjectId(1)).map_or("world", |id| &scene.object(id).name);
                assert_eq!(parent, expected, "{kind} at {height}");
                // The area of a sphere's cap is proportional to its height.
                let parts = containers.parts_of(ObjectId(1));
                assert_eq!(parts.len(), 2, "{kind} at {height}: {parts:?}");
                assert!((parts[0].share - share).abs() < 0.06, "{kind} at {height}: {parts:?}");
                assert!((parts.iter().map(|part| part.share).sum::<f64>() - 1.0).abs() < 1e-9);
                // The ball has precedence: the water's surface within it is none.
                assert!(!containers.is_mixed(ObjectId(0)), "{:?}", containers.parts_of(ObjectId(0)));
            }
        }
    }

    #[test]
    fn what_lies_wholly_in_something_is_not_mixed() {
        let (outer, inner) = (ball(0.0, 1.0, false), ball(0.1, 0.5, true));
        let shapes = [("inner", "air", 0, &*inner), ("outer", "glass", 0, &*outer), ("pool", "water", 0, POOL)];
        let expected = [("outer", false), ("pool", false), ("world", false)];
        assert_eq!(tree(&shapes), expected.map(|(name, mixed)| (name.to_owned(), mixed)));
    }

    #[test]
    fn nobody_is_below_itself() {
        // Each has most of its surface in the other or beside it, in every order of priorities.
        for (a, b, c) in [(0, 0, 0), (2, 1, 0), (0, 1, 2), (1, 0, 1)] {
            let shapes = [ball(0.0, 1.0, true), ball(0.05, 1.0, false), ball(-0.1, 1.02, true)];
            let (scene, containers) =
                found(&[("a", "glass", a, &*shapes[0]), ("b", "air", b, &*shapes[1]), ("c", "water", c, &*shapes[2])]);
            for (id, _) in scene.refractors() {
                let steps = std::iter::successors(Some(id), |above| containers.parent_of(*above)).take(5).count();
                assert!(steps < 5, "{a} {b} {c}: {containers:?}");
            }
        }
    }
}
