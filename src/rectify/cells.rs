//! Faces whose surroundings differ from place to place: a face that another surface crosses, or lies on in part.
//!
//! Such a face is divided into cells, halved along their longest edges: what holds all over a cell is stored, and only in the small cells
//! at a crossing curve is a hit asked about at its own place, about those few refractors whose surfaces come near.
//! The triangles that rays meet stay as they are, so nothing can leak.

use std::sync::Arc;

use glam::DVec3;

use super::contact::{Contact, Cover, Face, Relation, is_refractor, is_stood_for};
use super::containment::{containment_beside, fills_beside, is_inside, is_inside_by_vote};
use super::surroundings::{Answer, State, Surroundings};
use super::tolerance::Tolerance;
use crate::geometry::{PrimitiveId, SurfacePoint};
use crate::scene::{ObjectId, Scene};

/// Cells get no smaller than this share of the smallest object that has to do with them.
const FINEST: f64 = 1.0 / 96.0;
/// Answers of one cell that are worked out beforehand, at the most.
const MOST_LISTED: usize = 256;
/// Halvings at the most.
const DEEPEST: u32 = 18;

/// A node of a face's division.
#[derive(Debug, Clone, PartialEq)]
pub enum Node<Known, Asked> {
    /// Two halves, at `first` and `first + 1`: the edge from corner `edge` to the next was cut in the middle, and the first half keeps
    /// its start.
    Halves { edge: u8, first: u32 },
    /// The same all over.
    Known(Known),
    /// To be asked at each point.
    Asked(Asked),
}

/// A refractor that is to be asked about at the point of a hit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    pub refractor: ObjectId,
    /// Its copies, if there are any, of which the same holds.
    pub copies: Option<Arc<[ObjectId]>>,
    /// Its primitives that coincide with the face hereabouts, and whether they look the same way.
    pub coincident: Vec<(PrimitiveId, bool)>,
}

/// A cell in which hits are asked about at their own place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ask {
    /// What holds all over the cell.
    pub base: Surroundings,
    pub members: Vec<Member>,
    /// Opaque primitives that coincide with the face hereabouts: where they cover it, they stand for it.
    pub opaque: Vec<PrimitiveId>,
    /// Whether so many surfaces meet the face that none is listed, and everything is asked about at each hit.
    pub is_crowded: bool,
}

impl Ask {
    /// How many answers there are: one for each combination of the members' states. `None` where those are too many to be listed, and an
    /// answer is worked out when it is wanted.
    fn combinations(&self) -> Option<usize> {
        if self.is_crowded {
            return None;
        }
        (self.members.iter())
            .try_fold(1, |product: usize, member| product.checked_mul(member.states()))
            .filter(|product| *product <= MOST_LISTED)
    }

    /// Every possible answer, in the order of [`Self::look`]; `None` where there are too many.
    pub fn answers<'a>(&'a self, scene: &'a Scene) -> Option<impl Iterator<Item = Answer> + 'a> {
        let combinations = self.combinations()?;
        Some((0..combinations).map(move |index| {
            let mut surroundings = self.base.clone();
            let mut rest = index;
            for member in &self.members {
                member.tell(&mut surroundings, State::ALL[rest % member.states()]);
                rest /= member.states();
            }
            surroundings.resolve(scene)
        }))
    }

    /// The answer at a point.
    pub fn answer(&self, scene: &Scene, point: &SurfacePoint) -> Answer {
        if self.is_crowded {
            return answer_anew(scene, point);
        }
        let mut surroundings = self.base.clone();
        match self.states_at(scene, point, |member, state| member.tell(&mut surroundings, state)) {
            Some(()) => surroundings.resolve(scene),
            None => Answer::MASKED,
        }
    }

    /// Which of the listed answers holds at a point; `None` where a coincident face stands for this one.
    pub fn look(&self, scene: &Scene, point: &SurfacePoint) -> Option<usize> {
        let (mut index, mut stride) = (0, 1);
        self.states_at(scene, point, |member, state| {
            index += state as usize * stride;
            stride *= member.states();
        })?;
        Some(index)
    }

    /// Asks about each member in turn; `None` where a coincident face stands for this one.
    #[inline]
    fn states_at(&self, scene: &Scene, point: &SurfacePoint, mut tell: impl FnMut(&Member, State)) -> Option<()> {
        let covers = |primitive: PrimitiveId| {
            let geometry = &*scene.geometry;
            let (own, other) = (geometry.object_of(point.primitive), geometry.object_of(primitive));
            let tolerance = Tolerance::between(geometry, own, other);
            Face::of(geometry, primitive).cover(&[point.position], tolerance) == Cover::All
        };
        if self.opaque.iter().any(|&primitive| covers(primitive)) {
            return None;
        }
        for member in &self.members {
            let state = match member.coincident.iter().find(|(primitive, _)| covers(*primitive)) {
                // Of twins, the first one stands for both.
                Some((primitive, _)) if *primitive < point.primitive => return None,
                Some(_) if scene.object(member.refractor).may_contain_itself() => {
                    state_of_parts(scene, member.refractor, self.base.subject, point)?
                }
                Some((_, same)) => State::of_coincident(*same),
                None if is_inside(scene, member.refractor, point) => State::In,
                None => State::Out,
            };
            tell(member, state);
        }
        Some(())
    }
}

/// The answer at a point, of which nothing is known beforehand.
fn answer_anew(scene: &Scene, point: &SurfacePoint) -> Answer {
    if is_stood_for(scene, point) {
        return Answer::MASKED;
    }
    let mut surroundings = Surroundings::new(ObjectId(scene.geometry.object_of(point.primitive)));
    for refractor in containment_beside(scene, point, true).refractors {
        surroundings.add(refractor, State::OuterOnly);
    }
    for refractor in containment_beside(scene, point, false).refractors {
        surroundings.add(refractor, State::InnerOnly);
    }
    surroundings.resolve(scene)
}

impl Member {
    /// Adds it and its copies.
    fn tell(&self, surroundings: &mut Surroundings, state: State) {
        surroundings.add(self.refractor, state);
        self.copies.iter().flat_map(|copies| &**copies).for_each(|&copy| surroundings.add(copy, state));
    }

    /// Without coincident faces a refractor lies on both sides or on neither.
    fn states(&self) -> usize {
        if self.coincident.is_empty() { 2 } else { 4 }
    }
}

/// How a refractor of several parts lies at a point of a surface that faces of its own coincide with: several of them may, of parts on either
/// side, and other parts may contain all of it. `None` where the refractor is the subject itself and its faces there enclose nothing between them.
fn state_of_parts(scene: &Scene, refractor: ObjectId, subject: ObjectId, point: &SurfacePoint) -> Option<State> {
    let [is_outer, is_inner] = [true, false].map(|is_outer| fills_beside(scene, refractor, point, is_outer));
    (is_inner || refractor != subject).then(|| State::of_sides(is_outer, is_inner))
}

/// A touched face, divided. Children come after their parents; a triangle has one root, a sphere one for each octant.
pub type Division = Vec<Node<Surroundings, Ask>>;

fn is_sphere(scene: &Scene, face: PrimitiveId) -> bool {
    scene.geometry.sphere(face).is_some()
}

/// The number of roots of a face's division.
pub fn roots(is_sphere: bool) -> u32 {
    if is_sphere { 8 } else { 1 }
}

/// Where in a division a point of the face lies: the root's offset, and its weights at that root's corners, up to a common factor.
#[inline]
pub fn locate(scene: &Scene, point: &SurfacePoint, barycentric: [f64; 2]) -> (u32, [f64; 3]) {
    match scene.geometry.sphere(point.primitive) {
        Some(_) => {
            let n = point.normal;
            let octant = u32::from(n.x < 0.0) | u32::from(n.y < 0.0) << 1 | u32::from(n.z < 0.0) << 2;
            (octant, n.abs().to_array())
        }
        None => (0, [1.0 - barycentric[0] - barycentric[1], barycentric[0], barycentric[1]]),
    }
}

/// Goes down from node `root` to the leaf that holds the point of those weights.
#[inline]
pub fn descend<K, A>(nodes: &[Node<K, A>], root: u32, mut weights: [f64; 3]) -> &Node<K, A> {
    let mut node = &nodes[root as usize];
    while let Node::Halves { edge, first } = node {
        let (a, b) = (*edge as usize, (*edge as usize + 1) % 3);
        let (wa, wb) = (weights[a], weights[b]);
        // The middle of the edge replaces the end of it that is farther away.
        if wa >= wb {
            (weights[a], weights[b]) = (wa - wb, 2.0 * wb);
            node = &nodes[*first as usize];
        } else {
            (weights[a], weights[b]) = (2.0 * wa, wb - wa);
            node = &nodes[*first as usize + 1];
        }
    }
    node
}

/// The objects that touch a face, in ascending order.
pub fn touching(scene: &Scene, contacts: &[Contact]) -> Vec<ObjectId> {
    let mut objects: Vec<ObjectId> =
        contacts.iter().map(|contact| ObjectId(scene.geometry.object_of(contact.primitive))).collect();
    objects.sort_unstable();
    objects.dedup();
    objects
}

/// The refractors that contain the outer side of a face all over, without asking about those that touch it.
pub fn containers(scene: &Scene, face: PrimitiveId, touching: &[ObjectId]) -> Vec<ObjectId> {
    let Some(point) = scene.geometry.sample_primitive(face, [1.0 / 3.0, 1.0 / 3.0]) else { return Vec::new() };
    let mut refractors = containment_beside(scene, &point, true).refractors;
    refractors.retain(|refractor| !touching.contains(refractor));
    refractors
}

/// The radius of the finest cells of a face; `None` where it is not divided, because nothing does more than touch its edges.
pub fn finest(scene: &Scene, face: PrimitiveId, contacts: &[Contact]) -> Option<f64> {
    let size = |object: ObjectId| {
        let (min, max) = scene.geometry.bounds_of(object.0);
        (max - min).length()
    };
    let subject = ObjectId(scene.geometry.object_of(face));
    let mut active = contacts.iter().filter(|contact| contact.relation != Relation::Touches).peekable();
    active.peek()?;
    let objects = active.map(|contact| ObjectId(scene.geometry.object_of(contact.primitive)));
    Some(objects.filter(|&object| is_refractor(scene, object)).map(size).fold(size(subject), f64::min) * FINEST)
}

/// Divides a touched face, or says that it is crowded. `containers` are the refractors that contain its outer side and do not touch it. Cells may be coarser than the
/// finest by the factor `coarseness` ≥ 1: more hits are then asked about at their own place, and the answers are the same.
pub fn divide(
    scene: &Scene,
    face: PrimitiveId,
    contacts: &[Contact],
    containers: &[ObjectId],
    coarseness: f64,
) -> Division {
    let subject = ObjectId(scene.geometry.object_of(face));
    if contacts.is_empty() {
        let (base, members, opaque) = (Surroundings::new(subject), Vec::new(), Vec::new());
        return vec![
            Node::Asked(Ask { base, members, opaque, is_crowded: true });
            roots(is_sphere(scene, face)) as usize
        ];
    }
    let shape = Face::of(&scene.geometry, face);
    let pool: Vec<(Contact, Face)> =
        contacts.iter().map(|contact| (*contact, Face::of(&scene.geometry, contact.primitive))).collect();
    let mut actives: Vec<Active> = Vec::new();
    for (index, (contact, _)) in pool.iter().enumerate() {
        if contact.relation == Relation::Touches {
            continue;
        }
        let object = ObjectId(scene.geometry.object_of(contact.primitive));
        // Contacts are in the order of primitives, and those of one object follow each other.
        let active = match actives.last_mut() {
            Some(active) if active.object == object => active,
            _ => {
                let is_refractor = is_refractor(scene, object);
                let tolerance = Tolerance::between(&scene.geometry, subject.0, object.0);
                let has_several_parts = scene.object(object).may_contain_itself();
                let (crossing, coincident) = (Vec::new(), Vec::new());
                actives.push(Active { object, is_refractor, has_several_parts, tolerance, crossing, coincident });
                actives.last_mut().expect("it has just been added")
            }
        };
        match contact.relation {
            Relation::Coincides { .. } => active.coincident.push(index as u32),
            _ => active.crossing.push(index as u32),
        }
    }
    let finest = finest(scene, face, contacts).unwrap_or_default() * coarseness;
    let mut divider = Divider { scene, face, shape, pool, finest, nodes: Vec::new() };

    let mut base = Surroundings::new(subject);
    let Some(middle) = divider.point(&divider.root_corners(0)) else {
        // Without area nothing ever meets it.
        base.is_masked = true;
        return vec![Node::Known(base)];
    };
    for &refractor in containers {
        base.add(refractor, State::In);
    }
    // What touches it at its edges only is the same all over it.
    for object in touching(scene, contacts) {
        let is_active = actives.iter().any(|active| active.object == object);
        if !is_active && is_refractor(scene, object) && is_inside_by_vote(scene, object, &middle) {
            base.add(object, State::In);
        }
    }
    let roots = roots(is_sphere(scene, face));
    divider.nodes.resize(roots as usize, Node::Known(Surroundings::new(subject)));
    for root in 0..roots {
        let corners = divider.root_corners(root);
        divider.fill(root as usize, corners, actives.clone(), base.clone(), 0);
    }
    let Divider { mut nodes, .. } = divider;
    // The same in all octants: the face is one.
    if nodes.len() > 1
        && let Node::Known(first) = &nodes[0]
        && nodes.iter().all(|node| matches!(node, Node::Known(other) if other == first))
    {
        nodes.truncate(1);
    }
    nodes
}

/// An object that may still meet a cell. Numbers are indices into [`Divider::pool`].
#[derive(Clone)]
struct Active {
    object: ObjectId,
    is_refractor: bool,
    has_several_parts: bool,
    /// Between it and the face.
    tolerance: Tolerance,
    crossing: Vec<u32>,
    coincident: Vec<u32>,
}

struct Divider<'a> {
    scene: &'a Scene,
    face: PrimitiveId,
    shape: Face,
    pool: Vec<(Contact, Face)>,
    finest: f64,
    nodes: Division,
}

impl Divider<'_> {
    /// Corners of a root: of the triangle, or of an octant's triangle in the unit octahedron.
    fn root_corners(&self, root: u32) -> [DVec3; 3] {
        match self.shape {
            Face::Triangle { corners, .. } => corners,
            Face::Sphere(_) => {
                let sign = |bit: u32| if root >> bit & 1 == 1 { -1.0 } else { 1.0 };
                [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)]
            }
        }
    }

    /// The point of the surface that a point of the cell's plane stands for.
    fn on_surface(&self, point: DVec3) -> DVec3 {
        match self.shape {
            Face::Triangle { .. } => point,
            Face::Sphere(sphere) => sphere.center + point.normalize() * sphere.radius,
        }
    }

    /// The middle of a cell; `None` for a triangle without area.
    fn point(&self, corners: &[DVec3; 3]) -> Option<SurfacePoint> {
        let position = self.on_surface((corners[0] + corners[1] + corners[2]) / 3.0);
        let normal = match self.shape {
            Face::Triangle { normal, .. } => normal,
            Face::Sphere(sphere) => (position - sphere.center) / sphere.radius,
        };
        (normal != DVec3::ZERO).then_some(SurfacePoint { position, normal, primitive: self.face })
    }

    /// Fills in a node and all below it. `base` is what is known to hold all over the cell.
    fn fill(&mut self, node: usize, corners: [DVec3; 3], actives: Vec<Active>, mut base: Surroundings, depth: u32) {
        let ends = corners.map(|corner| self.on_surface(corner));
        let Some(middle) = self.point(&corners) else { return };
        let radius = ends.iter().map(|end| end.distance(middle.position)).fold(0.0, f64::max);
        let mut remaining = Vec::with_capacity(actives.len());
        for mut active in actives {
            let mut covering: Option<u32> = None;
            let mut has_parts = false;
            active.coincident.retain(|&index| match self.pool[index as usize].1.cover(&ends, active.tolerance) {
                Cover::Nothing => false,
                Cover::Part => {
                    has_parts = true;
                    true
                }
                Cover::All => {
                    covering = covering.or(Some(index));
                    true
                }
            });
            if let Some(index) = covering.filter(|_| !active.has_several_parts) {
                let contact = self.pool[index as usize].0;
                let Relation::Coincides { same } = contact.relation else { continue };
                base.is_masked |= !active.is_refractor || contact.primitive < self.face;
                base.add(active.object, State::of_coincident(same));
                continue;
            }
            let reach = radius * (1.0 + 1e-9) + 4.0 * active.tolerance.least;
            active.crossing.retain(|&index| self.pool[index as usize].1.distance(middle.position) <= reach);
            if let Some(index) = covering.filter(|_| !has_parts && active.crossing.is_empty()) {
                // Contacts are in the order of primitives, so this is the first of the object's faces here.
                base.is_masked |= self.pool[index as usize].0.primitive < self.face;
                match state_of_parts(self.scene, active.object, base.subject, &middle) {
                    Some(state) => base.add(active.object, state),
                    None => base.is_masked = true,
                }
            } else if !active.crossing.is_empty() || !active.coincident.is_empty() {
                remaining.push(active);
            } else if active.is_refractor && is_inside_by_vote(self.scene, active.object, &middle) {
                base.add(active.object, State::In);
            }
        }
        if base.is_masked || remaining.is_empty() {
            if base.is_masked {
                // Nothing else matters, and equal ones can be told to be equal.
                base = Surroundings { is_masked: true, ..Surroundings::new(base.subject) };
            }
            self.nodes[node] = Node::Known(base);
            return;
        }
        if radius <= self.finest || depth >= DEEPEST {
            self.nodes[node] = Node::Asked(self.ask(base, &remaining));
            return;
        }
        let length = |edge: usize| ends[edge].distance_squared(ends[(edge + 1) % 3]);
        let edge = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
        let first = self.nodes.len();
        self.nodes[node] = Node::Halves { edge: edge as u8, first: first as u32 };
        let blank = Node::Known(Surroundings::new(base.subject));
        self.nodes.extend([blank.clone(), blank]);
        let cut = (corners[edge] + corners[(edge + 1) % 3]) / 2.0;
        let (mut a, mut b) = (corners, corners);
        a[(edge + 1) % 3] = cut;
        b[edge] = cut;
        self.fill(first, a, remaining.clone(), base.clone(), depth + 1);
        self.fill(first + 1, b, remaining, base, depth + 1);
    }

    fn ask(&self, base: Surroundings, actives: &[Active]) -> Ask {
        let contact = |index: &u32| self.pool[*index as usize].0;
        let (refractors, opaque): (Vec<&Active>, Vec<&Active>) = actives.iter().partition(|active| active.is_refractor);
        let members = (refractors.into_iter())
            .map(|active| Member {
                refractor: active.object,
                copies: None,
                coincident: (active.coincident.iter().map(contact))
                    .map(|c| (c.primitive, c.relation == Relation::Coincides { same: true }))
                    .collect(),
            })
            .collect();
        let opaque = opaque.into_iter().flat_map(|active| active.coincident.iter().map(contact).map(|c| c.primitive));
        Ask { base, members, opaque: opaque.collect(), is_crowded: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A division of one face into four quarters by hand, and points in each.
    #[test]
    fn points_are_found_in_their_cells() {
        let nodes: Vec<Node<u32, u32>> = vec![
            Node::Halves { edge: 0, first: 1 },
            Node::Halves { edge: 1, first: 3 },
            Node::Known(2),
            Node::Known(3),
            Node::Asked(4),
        ];
        // Corners A, B, C; the first cut halves AB at M, the second, in A M C, halves MC at N.
        assert_eq!(descend(&nodes, 0, [0.1, 0.8, 0.1]), &Node::Known(2));
        // 0.8 A + 0.1 B + 0.1 C = 0.7 A + 0.2 M + 0.1 C: nearer to M than to C.
        assert_eq!(descend(&nodes, 0, [0.8, 0.1, 0.1]), &Node::Known(3));
        assert_eq!(descend(&nodes, 0, [0.3, 0.05, 0.65]), &Node::Asked(4));
    }
}
