//! Which components of one surface lie inside which, and which of them look the wrong way.
//!
//! From the top of each component, in one fixed direction, a ray goes up. The first face of another component that it meets says all: met
//! from inside, that component is the container; met from outside, both lie in the same container. Every component so met reaches higher
//! than the one below it, so the answers can be worked out from the top down.
//!
//! Components that cross contain each other not at all. Of components that touch, the top of one may lie on the other: there the winding
//! numbers around the middles of some faces tell.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::hierarchy::Hierarchy;
use crate::geometry::winding::solid_angle;

/// A component that encloses something.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    /// Enclosed, > 0 where the faces look outward.
    pub volume: f64,
    /// The highest vertex along [`UP`], and its height.
    pub top: DVec3,
    pub height: f64,
}

/// What is decided about a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Verdict {
    /// It must be turned over.
    pub is_turned: bool,
    /// How many times its inside is enclosed, itself counted: 1 for an ordinary body, 0 for a cavity.
    pub winding: i32,
    /// The same just outside of it.
    pub winding_outside: i32,
}

/// A direction that meshes have no reason to be aligned with.
pub(super) const UP: DVec3 = DVec3::new(0.237_114, 0.353_571, 0.904_853);

/// Judges every component; those that enclose nothing (`None`) contain nothing, and are turned over only if all outermost ones are.
///
/// - A component that lies in no other and looks inward is turned over; if all that lie in it alternate with it, they are turned with it: the
///   whole body was inside out.
/// - A component in which the surface would be wound less than zero times is turned over.
/// - A component that touches the one that it lies in, and looks the same way, is turned as that is: a part of the same solid.
/// - An inward component within an outward one is a cavity and stays; an outward one within an outward one stays too: a union.
pub(super) fn judge(
    bodies: &[Option<Body>],
    tree: &Hierarchy,
    faces: &[[u32; 3]],
    component_of_face: &[u32],
    positions: &[DVec3],
    meetings: &BTreeMap<(u32, u32), bool>,
) -> Vec<Verdict> {
    let neighbourhood = Neighbourhood::new(bodies, faces, component_of_face, positions, meetings);
    // The first face above each component: its component, and whether it is met from outside.
    let first_above = |(index, body): (usize, &Option<Body>)| {
        let body = (*body)?;
        let is_asked = |face: u32| {
            let component = component_of_face[face as usize] as usize;
            component != index && bodies[component].is_some() && !neighbourhood.meet(index as u32, component as u32)
        };
        let (face, is_front) = first_above(tree, faces, positions, body.top, is_asked)?;
        let component = component_of_face[face as usize];
        let is_outward = bodies[component as usize].is_some_and(|b| b.volume > 0.0);
        Some((component, is_front == is_outward))
    };
    let above: Vec<Option<(u32, bool)>> = if bodies.iter().flatten().nth(1).is_some() {
        bodies.par_iter().enumerate().map(first_above).collect()
    } else {
        vec![None; bodies.len()]
    };
    let mut order: Vec<u32> = (0..bodies.len() as u32).filter(|&c| bodies[c as usize].is_some()).collect();
    let height = |c: u32| bodies[c as usize].map_or(f64::NEG_INFINITY, |b| b.height);
    let size = |c: u32| bodies[c as usize].map_or(0.0, |b| b.volume.abs());
    order.sort_by(|&a, &b| height(b).total_cmp(&height(a)).then(size(b).total_cmp(&size(a))).then(a.cmp(&b)));

    let mut parents: Vec<Option<u32>> = vec![None; bodies.len()];
    // (outermost container, how deep within it)
    let mut places: Vec<(u32, u32)> = (0..bodies.len() as u32).map(|c| (c, 0)).collect();
    let mut is_known = vec![false; bodies.len()];
    let is_outward = |c: u32| bodies[c as usize].is_none_or(|b| b.volume > 0.0);
    // Whether all within an outermost component look exactly the opposite of what they should.
    let mut is_inverted = vec![true; bodies.len()];
    for &c in &order {
        // What is not known yet reaches no higher: the surfaces cross, and who contains whom is no question.
        let mut parent = (above[c as usize].filter(|&(other, _)| is_known[other as usize]))
            .and_then(|(other, from_outside)| if from_outside { parents[other as usize] } else { Some(other) });
        // What it meets may contain what is above it, and not contain it.
        while let Some(met) = parent.filter(|&p| neighbourhood.meet(c, p)) {
            parent = parents[met as usize];
        }
        if let Some(touched) = neighbourhood.container(c).filter(|&p| is_known[p as usize]) {
            parent = Some(touched);
        }
        parents[c as usize] = parent;
        if let Some(parent) = parent {
            let (root, depth) = places[parent as usize];
            places[c as usize] = (root, depth + 1);
        }
        is_known[c as usize] = true;
        let (root, depth) = places[c as usize];
        is_inverted[root as usize] &= is_outward(c) == (depth % 2 == 1);
    }

    let mut verdicts = vec![Verdict::default(); bodies.len()];
    for &c in &order {
        let root = places[c as usize].0;
        let winding_outside = parents[c as usize].map_or(0, |parent| verdicts[parent as usize].winding);
        // A part that touches what it lies in and looks the same way is no cavity, whichever way that is.
        let like =
            neighbourhood.container(c).filter(|&p| parents[c as usize] == Some(p) && is_outward(p) == is_outward(c));
        let mut is_turned = like.map_or(is_inverted[root as usize], |container| verdicts[container as usize].is_turned);
        let mut winding = winding_outside + if is_outward(c) != is_turned { 1 } else { -1 };
        if winding < 0 {
            is_turned = !is_turned;
            winding = winding_outside + 1;
        }
        verdicts[c as usize] = Verdict { is_turned, winding, winding_outside };
    }
    // Scraps of a surface that was inside out as a whole.
    let mut outermost = order.iter().filter(|&&c| parents[c as usize].is_none()).peekable();
    if outermost.peek().is_some() && outermost.all(|&c| verdicts[c as usize].is_turned) {
        for (verdict, _) in verdicts.iter_mut().zip(bodies).filter(|(_, body)| body.is_none()) {
            verdict.is_turned = true;
        }
    }
    verdicts
}

/// Which components meet, and which of those that only touch lie in which.
struct Neighbourhood {
    /// By component, in ascending order.
    met: BTreeMap<u32, Vec<u32>>,
    /// The smallest of the components that contain one and touch it.
    containers: BTreeMap<u32, u32>,
}

impl Neighbourhood {
    fn new(
        bodies: &[Option<Body>],
        faces: &[[u32; 3]],
        component_of_face: &[u32],
        positions: &[DVec3],
        meetings: &BTreeMap<(u32, u32), bool>,
    ) -> Self {
        let mut found = Self { met: BTreeMap::new(), containers: BTreeMap::new() };
        if meetings.is_empty() {
            return found;
        }
        for &(a, b) in meetings.keys() {
            found.met.entry(a).or_default().push(b);
            found.met.entry(b).or_default().push(a);
        }
        found.met.values_mut().for_each(|others| others.sort_unstable());
        let mut faces_of: BTreeMap<u32, Vec<[DVec3; 3]>> = BTreeMap::new();
        for (face, component) in faces.iter().zip(component_of_face).filter(|(_, c)| found.met.contains_key(c)) {
            faces_of.entry(*component).or_default().push(face.map(|v| positions[v as usize]));
        }
        let volume = |c: u32| bodies[c as usize].map_or(0.0, |body| body.volume.abs());
        let touching: Vec<(u32, u32)> = (meetings.iter())
            .filter(|(_, crosses)| !**crosses)
            .map(|(&(a, b), _)| if volume(a) < volume(b) { (a, b) } else { (b, a) })
            .filter(|&(inner, outer)| bodies[inner as usize].is_some() && bodies[outer as usize].is_some())
            .collect();
        let inside: Vec<(u32, u32)> =
            touching.into_par_iter().filter(|(inner, outer)| lies_in(&faces_of[inner], &faces_of[outer])).collect();
        for (inner, outer) in inside {
            let smallest = found.containers.entry(inner).or_insert(outer);
            if volume(outer) < volume(*smallest) {
                *smallest = outer;
            }
        }
        found
    }

    fn meet(&self, a: u32, b: u32) -> bool {
        self.met.get(&a).is_some_and(|others| others.binary_search(&b).is_ok())
    }

    fn container(&self, c: u32) -> Option<u32> {
        self.containers.get(&c).copied()
    }
}

/// Whether most of some faces' middles lie within what other faces enclose; those on its surface do not count.
fn lies_in(inner: &[[DVec3; 3]], outer: &[[DVec3; 3]]) -> bool {
    const MOST_ASKED: usize = 15;
    let asked = inner.iter().step_by(inner.len().div_ceil(MOST_ASKED));
    let windings = asked.map(|[a, b, c]| {
        let middle = (a + b + c) / 3.0;
        let angle: f64 = outer.iter().map(|corners| solid_angle(corners.map(|p| p - middle))).sum();
        (angle / (4.0 * std::f64::consts::PI)).abs()
    });
    let (mut within, mut beyond) = (0, 0);
    for winding in windings {
        within += usize::from(winding > 0.75);
        beyond += usize::from(winding < 0.25);
    }
    within > beyond
}

/// The first face above `origin` for which `is_asked`, and whether it is met from the side that it looks to.
fn first_above(
    tree: &Hierarchy,
    faces: &[[u32; 3]],
    positions: &[DVec3],
    origin: DVec3,
    is_asked: impl Fn(u32) -> bool,
) -> Option<(u32, bool)> {
    // Sheared so that the ray runs along z (Woop, Benthin and Wald 2013): an edge then gives both of its faces the same number.
    let shear = |p: DVec3| {
        let p = p - origin;
        DVec3::new(p.x - p.z * (UP.x / UP.z), p.y - p.z * (UP.y / UP.z), p.z)
    };
    let top = tree.levels.len().checked_sub(1)?;
    let mut best: Option<(f64, u32, bool)> = None;
    let mut open = vec![(top, 0)];
    while let Some((level, index)) = open.pop() {
        let bounds = &tree.levels[level][index];
        let nearest = best.map_or(f64::INFINITY, |(z, ..)| z);
        if bounds.max.z < origin.z || bounds.min.z - origin.z > nearest || !is_below(bounds.min, bounds.max, origin) {
            continue;
        }
        if level > 0 {
            open.extend(tree.children(level, index).map(|child| (level - 1, child)));
            continue;
        }
        for &face in tree.leaf(index).iter().filter(|&&face| is_asked(face)) {
            let [a, b, c] = faces[face as usize].map(|v| shear(positions[v as usize]));
            let edge = |p: DVec3, q: DVec3| p.x * q.y - p.y * q.x;
            let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
            let is_met = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
            let sum = u + v + w;
            if !is_met || sum == 0.0 {
                continue;
            }
            let z = (u * a.z + v * b.z + w * c.z) / sum;
            if z > 0.0 && best.is_none_or(|(nearest, other, _)| (z, face) < (nearest, other)) {
                // Counter-clockwise seen along +z is seen from behind.
                best = Some((z, face, sum < 0.0));
            }
        }
    }
    best.map(|(_, face, is_front)| (face, is_front))
}

/// Whether the line through `origin` along [`UP`] comes near the box; errs towards yes.
fn is_below(min: DVec3, max: DVec3, origin: DVec3) -> bool {
    let (low, high) = ((min - origin) / UP, (max - origin) / UP);
    let room = 1e-12 * (low.abs().max(high.abs()).max_element() + origin.abs().max_element());
    low.max_element() <= high.min_element() + room
}
