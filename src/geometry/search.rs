//! Questions along rays: the first hit, every hit, whether there is any; one ray at a time and many.

use super::beam::{GATHERED, Gathered};
use super::geometry::{Geometry, Mask};
use super::kernel::{Kernel, Task};
use super::ray::{Hit, PrimitiveId, Ray};
use super::triangle::{PackTest, ShearedRay, TriangleHit};
use super::walk::{BoxRay, Stack};

impl Geometry {
    /// The first hit in the order (distance, primitive).
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut search = Closest { best: None };
        self.search(ray, f64::INFINITY, &mut search);
        search.best
    }

    /// The first hit, as if the primitives of `mask` were not there.
    #[inline]
    pub fn closest_but(&self, ray: &Ray, mask: &Mask) -> Option<Hit> {
        let mut search = But { mask, search: Closest { best: None } };
        self.search(ray, f64::INFINITY, &mut search);
        search.search.best
    }

    /// The first hit of each ray, as [`Self::closest`] finds it, in less time if there are some dozens at least. `hits` is as long as `rays`.
    pub fn closest_many(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.search_many(rays, |_| f64::INFINITY, || Closest { best: None }, |index, search| hits[index] = search.best);
    }

    /// The first hit of each ray, as [`Self::closest_but`] finds it.
    pub fn closest_many_but(&self, rays: &[Ray], mask: &Mask, hits: &mut [Option<Hit>]) {
        let start = || But { mask, search: Closest { best: None } };
        self.search_many(rays, |_| f64::INFINITY, start, |index, search| hits[index] = search.search.best);
    }

    /// Whether anything lies along each ray nearer than its reach, as [`Self::is_occluded`] finds it.
    pub fn is_occluded_many(&self, rays: &[Ray], reaches: &[f64], occluded: &mut [bool]) {
        let start = || Any { found: false };
        self.search_many(rays, |index| reaches[index], start, |index, search| occluded[index] = search.found);
    }

    /// Whether anything lies along each ray nearer than its reach, as [`Self::is_occluded_but`] finds it.
    pub fn is_occluded_many_but(&self, rays: &[Ray], reaches: &[f64], mask: &Mask, occluded: &mut [bool]) {
        let start = || But { mask, search: Any { found: false } };
        self.search_many(rays, |index| reaches[index], start, |index, search| occluded[index] = search.search.found);
    }

    /// Whether anything lies nearer than `t_max`, as if the primitives of `mask` were not there.
    #[inline]
    pub fn is_occluded_but(&self, ray: &Ray, t_max: f64, mask: &Mask) -> bool {
        let mut search = But { mask, search: Any { found: false } };
        self.search(ray, t_max, &mut search);
        search.search.found
    }

    /// Whether anything lies nearer than `t_max`.
    #[inline]
    pub fn is_occluded(&self, ray: &Ray, t_max: f64) -> bool {
        let mut search = Any { found: false };
        self.search(ray, t_max, &mut search);
        search.found
    }

    /// Calls `visit` for every hit, in no particular order.
    pub fn for_each_hit(&self, ray: &Ray, visit: impl FnMut(Hit)) {
        self.search(ray, f64::INFINITY, &mut All { visit });
    }

    /// The first hit of one object, as if it were alone.
    pub fn closest_of(&self, ray: &Ray, object: u32) -> Option<Hit> {
        let mut search =
            ClosestOf { object, object_of_primitive: &self.object_of_primitive, closest: Closest { best: None } };
        self.search(ray, f64::INFINITY, &mut search);
        search.closest.best
    }

    /// Every hit, in the order (distance, primitive).
    pub fn all_hits(&self, ray: &Ray) -> Vec<Hit> {
        let mut hits = Vec::new();
        self.for_each_hit(ray, |hit| hits.push(hit));
        hits.sort_by(|a, b| (a.t, a.primitive).partial_cmp(&(b.t, b.primitive)).expect("distances are numbers"));
        hits
    }

    #[inline]
    fn search(&self, ray: &Ray, t_max: f64, search: &mut impl Search) {
        self.kernel.run(One { geometry: self, ray, t_max, search });
    }

    #[inline(always)]
    fn search_with<K: Kernel>(&self, ray: &Ray, mut t_max: f64, search: &mut impl Search) {
        if !self.packs.is_empty() {
            let tree = &self.triangle_tree;
            let (boxes, sheared) = (BoxRay::new(ray, tree.center, tree.radius), ShearedRay::new(ray));
            let (mut stack, mut test) = (Stack::at_root(), PackTest::EMPTY);
            while let Some(slot) = tree.next_leaf::<K>(&boxes, t_max, &mut stack, Some(&self.packs)) {
                if self.test_pack::<K>(slot, ray, &sheared, &mut t_max, &mut test, search) {
                    return;
                }
            }
        }
        self.search_spheres::<K>(ray, t_max, search);
    }

    /// Tests the triangles of a pack; returns whether the search is over.
    #[inline(always)]
    pub(super) fn test_pack<K: Kernel>(
        &self,
        slot: u32,
        ray: &Ray,
        sheared: &ShearedRay,
        t_max: &mut f64,
        test: &mut PackTest,
        search: &mut impl Search,
    ) -> bool {
        let pack = &self.packs[slot as usize];
        let met = K::meet_triangles(sheared, pack, ray.t_min, *t_max, test);
        let mut done = false;
        test.for_each(met, sheared, pack, |primitive, hit| {
            if primitive != ray.from && is_behind(ray, hit.t, primitive) && hit.t <= *t_max {
                let TriangleHit { t, barycentric, is_front } = hit;
                done |= search.found(Hit { t, primitive, barycentric, is_front }, t_max);
            }
        });
        done
    }

    #[inline(always)]
    pub(super) fn search_spheres<K: Kernel>(&self, ray: &Ray, mut t_max: f64, search: &mut impl Search) {
        if self.spheres.is_empty() {
            return;
        }
        let tree = &self.sphere_tree;
        let boxes = BoxRay::new(ray, tree.center, tree.radius);
        let mut stack = Stack::at_root();
        while let Some(slot) = tree.next_leaf::<K>(&boxes, t_max, &mut stack, None) {
            let index = self.sphere_slots[slot as usize];
            let primitive = index + self.triangles.len() as u32;
            let [enter, leave] = self.spheres[index as usize].intersect(ray, primitive == ray.from);
            // Both hits of one sphere carry the same id: the second lies behind the first unless they coincide.
            let is_over = meet_sphere(ray, primitive, enter, true, &mut t_max, search);
            if meet_sphere(ray, primitive, leave, false, &mut t_max, search) || is_over {
                return;
            }
        }
    }

    #[inline]
    fn search_many<S: Search>(
        &self,
        rays: &[Ray],
        t_max: impl Fn(usize) -> f64,
        start: impl Fn() -> S,
        finish: impl FnMut(usize, &mut S),
    ) {
        self.kernel.run(Many { geometry: self, rays, t_max, start, finish });
    }

    #[inline(always)]
    fn search_many_with<K: Kernel, S: Search>(
        &self,
        rays: &[Ray],
        t_max: impl Fn(usize) -> f64,
        start: impl Fn() -> S,
        mut finish: impl FnMut(usize, &mut S),
    ) {
        if self.packs.is_empty() {
            for (index, ray) in rays.iter().enumerate() {
                let mut search = start();
                self.search_spheres::<K>(ray, t_max(index), &mut search);
                finish(index, &mut search);
            }
            return;
        }
        for (chunk, rays) in rays.chunks(GATHERED).enumerate() {
            let t_max = |index: usize| t_max(chunk * GATHERED + index);
            let mut finish = |index: usize, search: &mut S| finish(chunk * GATHERED + index, search);
            let gathered = Gathered::new(&self.triangle_tree, rays);
            for beam in gathered.beams() {
                self.search_beam::<K, S>(rays, beam, t_max, &start, &mut finish);
            }
            self.search_others::<K, S>(rays, gathered.others(), t_max, &start, &mut finish);
        }
    }
}

/// A search along one ray.
struct One<'a, S> {
    geometry: &'a Geometry,
    ray: &'a Ray,
    t_max: f64,
    search: &'a mut S,
}

impl<S: Search> Task for One<'_, S> {
    #[inline(always)]
    fn run<K: Kernel>(self) {
        self.geometry.search_with::<K>(self.ray, self.t_max, self.search);
    }
}

/// Searches along many rays.
struct Many<'a, D, B, F> {
    geometry: &'a Geometry,
    rays: &'a [Ray],
    t_max: D,
    start: B,
    finish: F,
}

impl<D: Fn(usize) -> f64, B: Fn() -> S, F: FnMut(usize, &mut S), S: Search> Task for Many<'_, D, B, F> {
    #[inline(always)]
    fn run<K: Kernel>(self) {
        self.geometry.search_many_with::<K, S>(self.rays, self.t_max, self.start, self.finish);
    }
}

/// Reports where a ray enters or leaves a sphere, if it does; returns whether the search is over.
#[inline(always)]
fn meet_sphere(
    ray: &Ray,
    primitive: PrimitiveId,
    t: Option<f64>,
    is_front: bool,
    t_max: &mut f64,
    search: &mut impl Search,
) -> bool {
    let Some(t) = t else { return false };
    is_behind(ray, t, primitive)
        && t <= *t_max
        && search.found(Hit { t, primitive, barycentric: [0.0; 2], is_front }, t_max)
}

/// Whether a hit comes after the ray's start in the order (distance, primitive).
#[inline(always)]
fn is_behind(ray: &Ray, t: f64, primitive: PrimitiveId) -> bool {
    t > ray.t_min || (t == ray.t_min && primitive > ray.after)
}

/// What to do with a hit. Returns whether the search is over.
pub(super) trait Search {
    fn found(&mut self, hit: Hit, t_max: &mut f64) -> bool;
}

struct Closest {
    best: Option<Hit>,
}

impl Search for Closest {
    #[inline(always)]
    fn found(&mut self, hit: Hit, t_max: &mut f64) -> bool {
        // Hits at equal distance go to the smaller id, whatever the order of the walk.
        if self.best.is_none_or(|best| (hit.t, hit.primitive) < (best.t, best.primitive)) {
            self.best = Some(hit);
            *t_max = hit.t;
        }
        false
    }
}

/// Another search that passes over some primitives.
struct But<'a, S> {
    mask: &'a Mask,
    search: S,
}

impl<S: Search> Search for But<'_, S> {
    #[inline(always)]
    fn found(&mut self, hit: Hit, t_max: &mut f64) -> bool {
        !self.mask.contains(hit.primitive) && self.search.found(hit, t_max)
    }
}

struct ClosestOf<'a> {
    object: u32,
    object_of_primitive: &'a [u32],
    closest: Closest,
}

impl Search for ClosestOf<'_> {
    #[inline(always)]
    fn found(&mut self, hit: Hit, t_max: &mut f64) -> bool {
        self.object_of_primitive[hit.primitive as usize] == self.object && self.closest.found(hit, t_max)
    }
}

struct Any {
    found: bool,
}

impl Search for Any {
    #[inline(always)]
    fn found(&mut self, hit: Hit, t_max: &mut f64) -> bool {
        self.found |= hit.t < *t_max;
        self.found
    }
}

struct All<F> {
    visit: F,
}

impl<F: FnMut(Hit)> Search for All<F> {
    #[inline(always)]
    fn found(&mut self, hit: Hit, _: &mut f64) -> bool {
        (self.visit)(hit);
        false
    }
}
