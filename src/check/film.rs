//! Surfaces of two refractors that nearly coincide: a film of another medium all round a liquid that was shrunk from its glass, and slivers
//! of gap and overlap between facets of different tessellation.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::names::{brief, rounded_up};
use super::{Problem, Spot, samples};
use crate::geometry::{Ray, SurfacePoint};
use crate::rectify::containment::medium_of;
use crate::rectify::tolerance;
use crate::rectify::{PatchKind, Progress};
use crate::scene::{MediumId, ObjectId, Scene};
use crate::tracking::Prepared;

/// Points of each refractor that are looked at first, and all of them where some of those lie near another surface.
const FIRST: u32 = 6;
const ALL: u32 = 96;
/// Points of all refractors together at the most, unless that leaves fewer than these for each; then fewer are looked at first as well.
const MOST_TOGETHER: usize = 1 << 16;
const FEWEST: u32 = 16;
/// A surface is near within this share of the object's size, the diagonal of its bounds.
const NEAR: f64 = 0.02;
/// Share of an object's surface that a film covers at the least: a liquid's wall and bottom, without its top.
const FILM: f64 = 0.4;
/// Length of the mean normal where a film lies all round: 1 would be a film on one flat side, such as between two panes.
const ALL_ROUND: f64 = 0.7;
/// Share that facets which nearly coincide cover at the least, and how near those are.
const FACETS: f64 = 0.2;
const FACETS_NEAR: f64 = 0.01;
/// Share of them that lie on the rarer side, gap or overlap: where there is less, it is a film.
const RARER: f64 = 0.05;

/// Incomplete once `progress` is cancelled.
pub(super) fn problems(prepared: &Prepared, progress: &Progress) -> Vec<Problem> {
    let scene = &*prepared.scene;
    let refractors: Vec<ObjectId> = scene.refractors().map(|(id, _)| id).collect();
    if refractors.len() < 2 {
        return Vec::new();
    }
    let points = ((MOST_TOGETHER / refractors.len()) as u32).clamp(FEWEST, ALL);
    // Refractors that cannot be seen are skipped.
    let is_seen = |id: &ObjectId| {
        let is_interface = |kind| !matches!(kind, PatchKind::Masked | PatchKind::Null);
        !progress.is_cancelled() && prepared.table.patches_of(*id).iter().any(|patch| is_interface(patch.kind))
    };
    let found: Vec<Found> =
        refractors.into_par_iter().filter(is_seen).filter_map(|id| look(prepared, id, points)).collect();
    // A pair may be found from both sides: the smaller object is the liquid.
    let mut of_pairs: BTreeMap<(ObjectId, ObjectId), Found> = BTreeMap::new();
    for found in found {
        let pair = (found.inner.min(found.outer), found.inner.max(found.outer));
        let size = |found: &Found| scene.object(found.inner).volume;
        match of_pairs.get(&pair) {
            Some(other) if size(other) <= size(&found) => {}
            _ => _ = of_pairs.insert(pair, found),
        }
    }
    of_pairs.into_values().map(|found| found.problem(scene)).collect()
}

/// A point of an object's surface beside another's.
struct Beside {
    point: SurfacePoint,
    other: ObjectId,
    /// Along the normal, > 0 for a gap, < 0 for an overlap.
    distance: f64,
}

enum Kind {
    Film(MediumId),
    Facets,
}

/// Two surfaces that nearly coincide.
struct Found {
    kind: Kind,
    /// The one that was looked at, for a film the one that it surrounds.
    inner: ObjectId,
    outer: ObjectId,
    /// Greatest and middle distance of the surfaces.
    most: f64,
    median: f64,
    spot: Spot,
}

/// Looks at so many points of a refractor.
fn look(prepared: &Prepared, id: ObjectId, points: u32) -> Option<Found> {
    let scene = &*prepared.scene;
    let geometry = &*scene.geometry;
    let (min, max) = geometry.bounds_of(id.0);
    let size = (max - min).length();
    let beside = |range| -> Vec<Beside> {
        let points = samples::of_surface(geometry, id.0, range);
        points.filter_map(|(point, _)| beside(scene, id, point, NEAR * size)).collect()
    };
    let first = FIRST.min(points / 8);
    let mut near = beside(0..first);
    if near.is_empty() {
        return None;
    }
    near.extend(beside(first..points));
    // The surface that it lies along most.
    let mut counts: BTreeMap<ObjectId, usize> = BTreeMap::new();
    near.iter().for_each(|b| *counts.entry(b.other).or_default() += 1);
    let (outer, _) = counts.into_iter().max_by_key(|&(other, count)| (count, std::cmp::Reverse(other)))?;
    near.retain(|b| b.other == outer);
    film(prepared, id, outer, points, &near).or_else(|| facets(scene, id, outer, size, points, &near))
}

/// What lies beside a point: the other surface that a ray along the normal enters, or that a ray against it leaves, within `reach`.
fn beside(scene: &Scene, id: ObjectId, point: SurfacePoint, reach: f64) -> Option<Beside> {
    let geometry = &*scene.geometry;
    // What is closer is in contact.
    let contact = tolerance::largest(geometry, id.0);
    [1.0, -1.0].into_iter().find_map(|sign| {
        let ray = Ray::leaving(point.position, point.normal * sign, point.primitive);
        let hit = geometry.closest(&ray).filter(|hit| hit.t <= reach && hit.t > contact)?;
        let other = ObjectId(geometry.object_of(hit.primitive));
        let is_meant = other != id && scene.is_refractor(other) && hit.is_front == (sign > 0.0);
        is_meant.then_some(Beside { point, other, distance: sign * hit.t })
    })
}

/// A film of what surrounds both, around most of the object.
fn film(prepared: &Prepared, inner: ObjectId, outer: ObjectId, points: u32, near: &[Beside]) -> Option<Found> {
    let scene = &*prepared.scene;
    let gaps: Vec<&Beside> = near.iter().filter(|b| b.distance > 0.0).collect();
    let overlaps = near.len() - gaps.len();
    let mean_normal = gaps.iter().map(|b| b.point.normal).sum::<DVec3>() / gaps.len().max(1) as f64;
    if (gaps.len() as f64) < FILM * f64::from(points)
        || overlaps as f64 >= RARER * near.len() as f64
        || mean_normal.length() > ALL_ROUND
    {
        return None;
    }
    // The film's medium, from a patch that no other surface crosses.
    let outside = |b: &&Beside| prepared.table.patch_of(&scene.geometry, b.point.primitive).and_then(|p| p.outside);
    let medium = gaps.iter().find_map(outside)?;
    let is_seen = [inner, outer].iter().all(|id| medium_of(scene, Some(*id)) != medium);
    is_seen.then(|| Found::new(scene, Kind::Film(medium), inner, outer, &gaps))
}

/// Gaps and overlaps by turns.
fn facets(scene: &Scene, inner: ObjectId, outer: ObjectId, size: f64, points: u32, near: &[Beside]) -> Option<Found> {
    let near: Vec<&Beside> = near.iter().filter(|b| b.distance.abs() <= FACETS_NEAR * size).collect();
    let gaps = near.iter().filter(|b| b.distance > 0.0).count();
    let rarer = gaps.min(near.len() - gaps);
    let is_so = near.len() as f64 >= FACETS * f64::from(points) && rarer as f64 >= RARER * near.len() as f64;
    let is_seen = medium_of(scene, Some(inner)) != medium_of(scene, Some(outer));
    (is_so && is_seen).then(|| Found::new(scene, Kind::Facets, inner, outer, &near))
}

impl Found {
    /// `near` is not empty.
    fn new(scene: &Scene, kind: Kind, inner: ObjectId, outer: ObjectId, near: &[&Beside]) -> Self {
        let mut distances: Vec<f64> = near.iter().map(|b| b.distance.abs()).collect();
        distances.sort_by(f64::total_cmp);
        let middle = near.iter().min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs())).unwrap_or(&near[0]);
        let (min, max) = scene.geometry.bounds_of(inner.0);
        let spot = Spot {
            center: middle.point.position + scene.geometry.origin,
            radius: (20.0 * distances[distances.len() - 1]).min((max - min).length() / 2.0),
        };
        let (most, median) = (distances[distances.len() - 1], distances[distances.len() / 2]);
        Self { kind, inner, outer, most, median, spot }
    }

    fn problem(&self, scene: &Scene) -> Problem {
        let [inner, outer] = [self.inner, self.outer].map(|id| scene.object(id).name.as_str());
        // More than was seen at some points.
        let enough = rounded_up(1.5 * self.most);
        let thick = format!("{} thick and at most {}", brief(self.median, 2), brief(self.most, 2));
        let least = scene.priority(self.inner);
        let over = if scene.priority(self.outer) > least {
            format!("`{outer}` wins there by its priority")
        } else {
            format!("give `{outer}` a priority above {least}, so that it wins there (higher wins)")
        };
        let (kind, message) = match self.kind {
            Kind::Film(medium) => (
                "thin_film",
                format!(
                    "a film of `{}` lies all round between `{inner}` and `{outer}`, {thick}. If it is not meant, let them \
                     overlap: enlarge `{inner}` by {enough} on all sides that face `{outer}`; {over}",
                    scene.medium(medium).name
                ),
            ),
            Kind::Facets => (
                "slivers",
                format!(
                    "`{inner}` and `{outer}` nearly coincide, with slivers of gap and overlap between their facets, {thick}. \
                     Let them overlap all along: enlarge `{inner}` by {enough} towards `{outer}`; {over}. Or give both the same vertices there"
                ),
            ),
        };
        Problem::advice(format!("{inner}, {outer}"), kind, message).at(self.spot.center, self.spot.radius)
    }
}
