//! `priority`: a list of the refractors entered so far; where volumes overlap, the highest priority fills them. Schmidt and Budge,
//! "Simple Nested Dielectrics in Ray Traced Images", Journal of Graphics Tools 7(2), 2002 (their *interior list*).
//!
//! As in the renderers that use the method, the list starts empty wherever a path starts, so a camera inside a refractor is wrong. Unlike
//! there, the list has no limit (they hold 2 to 8 entries) and priorities are whole numbers of any sign.
//!
//! - Of refractors of equal priority the one entered last is the current one. An interface between them is then met where the later one is
//!   entered, and again where it is left; the far side of the earlier one, met inside the later one, is skipped. So which of the two
//!   fills the overlap depends on the side that a path comes from: the paper asks for distinct priorities, and scenes that lack them look as
//!   they do in other renderers.
//! - A refractor in the list is entered again (a part of a mesh that intersects itself) and left again without effect, until it has been left
//!   as often as it was entered.
//! - An exit from what is not in the list is counted and changes nothing. The path must have started inside, before everything in the
//!   list was entered, so the crossing is an interface if nothing in the list has at least this priority.

use super::events::Events;
use super::prepare::Prepared;
use super::tracker::{Crossing, Sides, Tracker, TrackingMode};
use crate::scene::{MediumId, ObjectId, Scene};

#[derive(Debug, Clone, Copy)]
pub struct Priority<'a> {
    pub scene: &'a Scene,
}

/// A refractor that the path is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    refractor: ObjectId,
    interior: MediumId,
    priority: i32,
    /// Entries less exits, at least 1.
    depth: u32,
}

/// The refractor's place in the list. What was entered last is usually left first.
#[inline]
fn position(list: &[Entry], refractor: ObjectId) -> Option<usize> {
    list.iter().rposition(|entry| entry.refractor == refractor)
}

impl<'a> TrackingMode<'a> for Priority<'a> {
    const NAME: &'static str = "priority";
    const ABOUT: &'static str = "Carries the refractors entered so far and lets the highest priority win: right where volumes overlap, wrong when the path starts inside a dielectric.";

    fn of(prepared: &'a Prepared) -> Self {
        Self { scene: &prepared.scene }
    }
}

impl Tracker for Priority<'_> {
    /// By ascending priority, and by the order of entry among equals: the last one is current. Each refractor stands in it once.
    type State = Vec<Entry>;

    #[inline]
    fn can_skip(&self) -> bool {
        true
    }

    #[inline]
    fn sides(&self, state: &Self::State, crossing: &Crossing, events: &mut Events) -> Option<Sides> {
        let medium = |entry: Option<&Entry>| entry.map_or(MediumId::WORLD, |entry| entry.interior);
        let current = state.last();
        let place = position(state, crossing.refractor);
        if crossing.is_entering {
            let is_current = place.is_none()
                && current.is_none_or(|entry| entry.priority <= self.scene.priority(crossing.refractor));
            return is_current.then(|| Sides { from: medium(current), to: crossing.interior });
        }
        let Some(place) = place else {
            events.stack_underflow += 1;
            let was_current = current.is_none_or(|entry| entry.priority < self.scene.priority(crossing.refractor));
            return was_current.then(|| Sides { from: crossing.interior, to: medium(current) });
        };
        let was_current = place + 1 == state.len() && state[place].depth == 1;
        was_current
            .then(|| Sides { from: crossing.interior, to: medium(place.checked_sub(1).map(|below| &state[below])) })
    }

    fn transmit(&self, state: &mut Self::State, crossing: &Crossing) {
        match (position(state, crossing.refractor), crossing.is_entering) {
            (Some(place), true) => state[place].depth += 1,
            (None, true) => {
                let priority = self.scene.priority(crossing.refractor);
                let place = state.partition_point(|entry| entry.priority <= priority);
                let (refractor, interior) = (crossing.refractor, crossing.interior);
                state.insert(place, Entry { refractor, interior, priority, depth: 1 });
            }
            (Some(place), false) => {
                state[place].depth -= 1;
                if state[place].depth == 0 {
                    state.remove(place);
                }
            }
            (None, false) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;
    use std::path::Path;

    use glam::DVec3;

    use super::*;
    use crate::formats;
    use crate::geometry::{Ray, SurfacePoint};
    use crate::scene::compile::compile;

    /// A scene of refractors `0, 1, …`, each with its own medium, a shape in the words of a scene file, and a priority.
    fn scene(refractors: &[(&str, i32)]) -> Scene {
        let mut text = String::from("[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n");
        for (index, (shape, priority)) in refractors.iter().enumerate() {
            let ior = 1.1 + 0.001 * index as f64;
            write!(text, "[[medium]]\nname = \"m{index}\"\nior = {ior}\n").unwrap();
            let head = format!("[[refractor]]\nname = \"r{index}\"\nmedium = \"m{index}\"\npriority = {priority}");
            write!(text, "{head}\nshape = {{ {shape} }}\n").unwrap();
        }
        compile(&formats::parse(&text, Path::new("test.toml"), &formats::Disk).unwrap(), None).unwrap()
    }

    /// The same, where only the priorities matter.
    fn prioritized(priorities: &[i32]) -> Scene {
        let shape = "sphere = { center = [0, 0, 0], radius = 1 }";
        scene(&priorities.iter().map(|&priority| (shape, priority)).collect::<Vec<_>>())
    }

    /// What lies on the two sides: refractors by number, −1 the global medium. `None`: skipped.
    type Sight = Option<(i32, i32)>;

    struct Walk<'a> {
        tracker: Priority<'a>,
        list: Vec<Entry>,
        events: Events,
    }

    impl<'a> Walk<'a> {
        fn new(scene: &'a Scene) -> Self {
            Self { tracker: Priority { scene }, list: Vec::new(), events: Events::default() }
        }

        fn cross(&mut self, refractor: u32, is_entering: bool) -> Sight {
            let point = SurfacePoint { position: DVec3::ZERO, normal: DVec3::Y, primitive: 0 };
            let interior = MediumId(refractor + 2);
            let crossing =
                Crossing { refractor: ObjectId(refractor), interior, is_entering, point, barycentric: [0.0; 2] };
            let sides = self.tracker.sides(&self.list, &crossing, &mut self.events);
            self.tracker.transmit(&mut self.list, &crossing);
            let number = |medium: MediumId| if medium == MediumId::WORLD { -1 } else { medium.0 as i32 - 2 };
            sides.map(|sides| (number(sides.from), number(sides.to)))
        }

        fn enter(&mut self, refractor: u32) -> Sight {
            self.cross(refractor, true)
        }

        fn leave(&mut self, refractor: u32) -> Sight {
            self.cross(refractor, false)
        }

        /// Straight through everything along `ray`.
        fn along(scene: &'a Scene, ray: &Ray) -> (Vec<Sight>, Self) {
            let mut walk = Self::new(scene);
            let ray = Ray::new(ray.origin - scene.geometry.origin, ray.direction);
            let hits = scene.geometry.all_hits(&ray).into_iter();
            let sights = hits.map(|hit| walk.cross(scene.geometry.object_of(hit.primitive), hit.is_front)).collect();
            (sights, walk)
        }
    }

    const GLASS: i32 = 0;
    const WATER: i32 = 1;

    /// Water that reaches into the wall and the bottom of its tumbler; its top meets the air.
    fn tumbler(glass: i32, water: i32) -> Scene {
        scene(&[
            ("lathe = { profile = [[0, 0], [1, 0], [1, 3], [0.8, 3], [0.8, 0.2], [0, 0.2]] }", glass),
            ("cylinder = { center = [0, 1.1, 0], radius = 0.9, height = 2 }", water),
        ])
    }

    /// The higher priority wins, whichever it is. Of equals the one entered last is current: the water's own boundary on the way in, the
    /// glass's on the way out.
    #[test]
    fn water_that_overlaps_its_glass() {
        let [in_glass, in_water] = [(-1, GLASS), (GLASS, WATER)].map(Some);
        let [out_of_glass, out_of_water] = [(GLASS, -1), (WATER, GLASS)].map(Some);
        for (priorities, expected) in [
            ((1, 0), [in_glass, None, in_water, out_of_water, None, out_of_glass]),
            ((-7, -2), [in_glass, in_water, None, None, out_of_water, out_of_glass]),
            ((3, 3), [in_glass, in_water, None, out_of_water, None, out_of_glass]),
        ] {
            let scene = tumbler(priorities.0, priorities.1);
            let (sights, walk) = Walk::along(&scene, &Ray::new(DVec3::new(-5.0, 1.0, 0.013), DVec3::X));
            assert_eq!(sights, expected, "{priorities:?}");
            assert!(walk.list.is_empty() && walk.events == Events::default());
        }
        // From above, through the water's surface and the bottom.
        let scene = tumbler(1, 0);
        let (sights, _) = Walk::along(&scene, &Ray::new(DVec3::new(0.03, 5.0, 0.02), DVec3::NEG_Y));
        assert_eq!(sights, [Some((-1, WATER)), out_of_water, None, out_of_glass]);
    }

    #[test]
    fn three_that_overlap() {
        let interval = |min: f64, max: f64| format!("box = {{ min = [{min}, -1, -1], max = [{max}, 1, 1] }}");
        let (a, b, c) = (interval(0.0, 10.0), interval(2.0, 6.0), interval(4.0, 12.0));
        let ray = Ray::new(DVec3::new(-1.0, 0.3, 0.1), DVec3::X);
        // Ends in order: 0 a, 2 b, 4 c, 6 b, 10 a, 12 c.
        for (priorities, expected) in [
            ([0, 5, -3], [Some((-1, 0)), Some((0, 1)), None, Some((1, 0)), Some((0, 2)), Some((2, -1))]),
            ([20, 5, 30], [Some((-1, 0)), None, Some((0, 2)), None, None, Some((2, -1))]),
            ([0, 0, 0], [Some((-1, 0)), Some((0, 1)), Some((1, 2)), None, None, Some((2, -1))]),
            ([1, 0, 1], [Some((-1, 0)), None, Some((0, 2)), None, None, Some((2, -1))]),
        ] {
            let scene = scene(&[(&a, priorities[0]), (&b, priorities[1]), (&c, priorities[2])]);
            let (sights, walk) = Walk::along(&scene, &ray);
            assert_eq!(sights, expected, "{priorities:?}");
            assert!(walk.list.is_empty() && walk.events == Events::default());
        }
    }

    /// Concentric spheres with as many levels of priority, half of them negative, rising inwards: every surface counts. Falling inwards:
    /// none but the outermost does, and hundreds are skipped on one path.
    #[test]
    fn deep_nests_with_as_many_priorities() {
        for depth in [33, 256] {
            let shapes: Vec<String> = (0..depth)
                .map(|k| format!("sphere = {{ center = [0, 0, 0], radius = {} }}", 1.0 - f64::from(k) / 300.0))
                .collect();
            let nest = |sign: i32| {
                let priorities = (0..depth).map(|k| sign * (k - depth / 2));
                scene(&shapes.iter().map(String::as_str).zip(priorities).collect::<Vec<_>>())
            };
            let ray = Ray::new(DVec3::new(-2.0, 0.01, 0.02), DVec3::X);
            let rising = nest(1);
            let (sights, walk) = Walk::along(&rising, &ray);
            let inwards = (0..depth).map(|k| Some((k - 1, k)));
            let outwards = (0..depth).rev().map(|k| Some((k, k - 1)));
            assert_eq!(sights, inwards.chain(outwards).collect::<Vec<_>>());
            assert!(walk.list.is_empty() && walk.events == Events::default());

            let falling = nest(-1);
            let (sights, walk) = Walk::along(&falling, &ray);
            assert_eq!(sights.len() as i32, 2 * depth);
            assert_eq!((sights[0], sights[sights.len() - 1]), (Some((-1, 0)), Some((0, -1))));
            assert!(sights[1..sights.len() - 1].iter().all(Option::is_none));
            assert!(walk.list.is_empty() && walk.events == Events::default());
        }
    }

    /// A torus is left and entered again; a mesh that intersects itself is entered twice at once.
    #[test]
    fn what_is_entered_again() {
        let scene = prioritized(&[0, 1]);
        let mut walk = Walk::new(&scene);
        assert_eq!([walk.enter(0), walk.enter(1), walk.leave(1)], [Some((-1, 0)), Some((0, 1)), Some((1, 0))]);
        assert_eq!([walk.enter(1), walk.enter(1), walk.enter(0)], [Some((0, 1)), None, None]);
        // Half of the double entries are left: the path is still in both.
        assert_eq!([walk.leave(0), walk.leave(1)], [None, None]);
        assert_eq!([walk.leave(1), walk.leave(0)], [Some((1, 0)), Some((0, -1))]);
        assert!(walk.list.is_empty() && walk.events == Events::default());
    }

    /// A path that starts inside: its first exit is counted and the rest of the list is as it was.
    #[test]
    fn an_exit_without_an_entry_is_counted_and_corrupts_nothing() {
        let scene = prioritized(&[0, 0, 5, -5]);
        let mut walk = Walk::new(&scene);
        assert_eq!(walk.leave(0), Some((0, -1)));
        assert_eq!((walk.events.stack_underflow, walk.list.len()), (1, 0));
        assert_eq!(walk.enter(1), Some((-1, 1)));
        let before = walk.list.clone();
        // One that everything in the list beats, one that was there before an equal, and one that beats everything.
        assert_eq!([walk.leave(3), walk.leave(0), walk.leave(2)], [None, None, Some((2, 1))]);
        assert_eq!(walk.list, before);
        assert_eq!(walk.leave(1), Some((1, -1)));
        assert_eq!(walk.events, Events { stack_underflow: 4, ..Events::default() });
        // The next path knows nothing of it.
        walk.enter(2);
        walk.tracker.start(&mut walk.list);
        assert!(walk.list.is_empty());
    }

    /// Against the rule written down directly: at each place the highest priority of what spans it, of equals what begins last.
    #[test]
    fn random_overlaps_are_resolved_by_the_rule() {
        let mut seed = 1_u64;
        let mut random = |below: u64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % below
        };
        let mut skipped = 0;
        for _ in 0..400 {
            let count = 2 + random(11) as usize;
            let levels = 1 + random(6);
            let priorities: Vec<i32> = (0..count).map(|_| random(levels) as i32 - 3).collect();
            let scene = prioritized(&priorities);
            for _ in 0..5 {
                // Distinct places, two for each refractor.
                let mut places: Vec<usize> = (0..2 * count).collect();
                for index in (1..places.len()).rev() {
                    places.swap(index, random(index as u64 + 1) as usize);
                }
                let spans: Vec<(usize, usize)> =
                    places.chunks(2).map(|pair| (pair[0].min(pair[1]), pair[0].max(pair[1]))).collect();
                let filling = |place: usize| {
                    let present = (0..count).filter(|&k| spans[k].0 < place && place <= spans[k].1);
                    present.max_by_key(|&k| (priorities[k], spans[k].0)).map_or(-1, |k| k as i32)
                };
                let mut walk = Walk::new(&scene);
                for place in 0..2 * count {
                    let refractor = spans.iter().position(|span| span.0 == place || span.1 == place).unwrap();
                    let (before, after) = (filling(place), filling(place + 1));
                    let sight = walk.cross(refractor as u32, spans[refractor].0 == place);
                    assert_eq!(sight, (before != after).then_some((before, after)), "{priorities:?} {spans:?} {place}");
                    skipped += u32::from(sight.is_none());
                }
                assert!(walk.list.is_empty() && walk.events == Events::default());
            }
        }
        assert!(skipped > 1000, "{skipped}");
    }
}
