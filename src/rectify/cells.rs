//! Dividing a face whose surroundings differ from point to point, because another surface crosses it or covers part of it.
//!
//! Such a face is halved along the longest edges into cells. What holds all over a cell is stored. Only in the small cells at a crossing curve is
//! each hit asked about, and only about the few refractors whose surfaces come near. The triangles that rays meet are not changed,
//! so nothing can leak.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use super::asked::{AskedCell, AskedMember};
use super::contact::Contact;
use super::containment::{containment_beside, is_inside_by_vote};
use super::face::{Cover, Face};
use super::relation::Relation;
use super::surroundings::{Membership, Surroundings, membership_of_parts};
use super::tolerance::Tolerance;
use crate::geometry::{Enclosure, PrimitiveId, SurfacePoint};
use crate::scene::{ObjectId, Scene};

/// The smallest cells, as a share of the size of the smallest object that meets the face or has it.
const FINEST: f64 = 1.0 / 96.0;
/// Halvings at the most.
const DEEPEST: u32 = 18;

/// A cell of a face's division, or two halves of one.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Two halves, at `first` and `first + 1`: the edge from corner `edge` to the next was cut in the middle, and the first half keeps
    /// its start.
    Halves { edge: u8, first: u32 },
    /// The same all over.
    Known(Surroundings),
    /// To be asked at each point.
    Asked(Arc<AskedCell>),
}

/// A touched face, divided. Halves come after what they are halves of; a triangle has one root, a sphere one for each octant.
pub type Division = Vec<Cell>;

/// The number of roots of a face's division.
fn roots(scene: &Scene, face: PrimitiveId) -> u32 {
    if scene.geometry.sphere(face).is_some() { 8 } else { 1 }
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
    Some(objects.filter(|&object| scene.is_refractor(object)).map(size).fold(size(subject), f64::min) * FINEST)
}

/// Divides a touched face; one without listed contacts is crowded. `containers` are the refractors that contain its outer side and do not touch it.
/// Cells may be coarser than the finest by the factor `coarseness` ≥ 1: more hits are then asked about one by one, and the answers are the same.
pub fn divide(
    scene: &Scene,
    face: PrimitiveId,
    contacts: &[Contact],
    containers: &[ObjectId],
    coarseness: f64,
) -> Division {
    let subject = ObjectId(scene.geometry.object_of(face));
    if contacts.is_empty() {
        let crowded = Cell::Asked(Arc::new(AskedCell::crowded(subject)));
        return vec![crowded; roots(scene, face) as usize];
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
                let is_refractor = scene.is_refractor(object);
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
    let mut divider =
        Divider { scene, face, shape, pool, finest, nodes: Vec::new(), contained_corners: HashMap::new() };

    let mut base = Surroundings::new(subject);
    let Some(middle) = divider.point(&divider.root_corners(0)) else {
        // No ray hits a face without area.
        base.is_masked = true;
        return vec![Cell::Known(base)];
    };
    for &refractor in containers {
        base.add(refractor, Membership::In);
    }
    // A refractor that touches the face at its edges only contains all of it or none.
    for object in touching(scene, contacts) {
        let is_active = actives.iter().any(|active| active.object == object);
        if !is_active && scene.is_refractor(object) && is_inside_by_vote(scene, object, &middle) {
            base.add(object, Membership::In);
        }
    }
    let roots = roots(scene, face);
    divider.nodes.resize(roots as usize, Cell::Known(Surroundings::new(subject)));
    for root in 0..roots {
        let corners = divider.root_corners(root);
        divider.fill(root as usize, corners, actives.clone(), base.clone(), 0);
    }
    let Divider { mut nodes, .. } = divider;
    // All octants agree: the sphere is not divided.
    if nodes.len() > 1
        && let Cell::Known(first) = &nodes[0]
        && nodes.iter().all(|node| matches!(node, Cell::Known(other) if other == first))
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
    /// Whether refractors contain corners of cells that their surfaces do not meet.
    contained_corners: HashMap<(ObjectId, [u64; 3]), bool>,
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
                base.add(active.object, Membership::of_coincident(same));
                continue;
            }
            let reach = radius * (1.0 + 1e-9) + 4.0 * active.tolerance.least;
            active.crossing.retain(|&index| self.pool[index as usize].1.distance(middle.position) <= reach);
            if let Some(index) = covering.filter(|_| !has_parts && active.crossing.is_empty()) {
                // Contacts are in the order of primitives, so this is the first of the object's faces here.
                base.is_masked |= self.pool[index as usize].0.primitive < self.face;
                match membership_of_parts(self.scene, active.object, base.subject, &middle) {
                    Some(membership) => base.add(active.object, membership),
                    None => base.is_masked = true,
                }
            } else if !active.crossing.is_empty() || !active.coincident.is_empty() {
                remaining.push(active);
            } else if active.is_refractor && self.is_cell_inside(active.object, &corners, &middle) {
                base.add(active.object, Membership::In);
            }
        }
        if base.is_masked || remaining.is_empty() {
            if base.is_masked {
                // Nothing else matters; without it equal cells compare as equal.
                base = Surroundings { is_masked: true, ..Surroundings::new(base.subject) };
            }
            self.nodes[node] = Cell::Known(base);
            return;
        }
        if radius <= self.finest || depth >= DEEPEST {
            self.nodes[node] = Cell::Asked(Arc::new(self.ask(base, &remaining)));
            return;
        }
        let length = |edge: usize| ends[edge].distance_squared(ends[(edge + 1) % 3]);
        let edge = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
        let first = self.nodes.len();
        self.nodes[node] = Cell::Halves { edge: edge as u8, first: first as u32 };
        let blank = Cell::Known(Surroundings::new(base.subject));
        self.nodes.extend([blank.clone(), blank]);
        let cut = (corners[edge] + corners[(edge + 1) % 3]) / 2.0;
        let (mut a, mut b) = (corners, corners);
        a[(edge + 1) % 3] = cut;
        b[edge] = cut;
        self.fill(first, a, remaining.clone(), base.clone(), depth + 1);
        self.fill(first + 1, b, remaining, base, depth + 1);
    }

    /// Whether a refractor contains a cell that its surface does not meet. It contains all of it or none, and so it does with every other such
    /// cell that has a corner in common: rays are shot for the first of them.
    fn is_cell_inside(&mut self, refractor: ObjectId, corners: &[DVec3; 3], middle: &SurfacePoint) -> bool {
        // What is enclosed by a surface with an edge may end where there is no surface.
        let is_bounded = matches!(self.scene.object(refractor).enclosure, Enclosure::Closed | Enclosure::Union);
        if !is_bounded {
            return is_inside_by_vote(self.scene, refractor, middle);
        }
        // −0.0 is 0.0 as a coordinate.
        let keys = corners.map(|corner| (refractor, (corner + 0.0).to_array().map(f64::to_bits)));
        let known = keys.iter().find_map(|key| self.contained_corners.get(key).copied());
        let is_inside = known.unwrap_or_else(|| is_inside_by_vote(self.scene, refractor, middle));
        self.contained_corners.extend(keys.map(|key| (key, is_inside)));
        is_inside
    }

    fn ask(&self, base: Surroundings, actives: &[Active]) -> AskedCell {
        let contact = |index: &u32| self.pool[*index as usize].0;
        let (refractors, opaque): (Vec<&Active>, Vec<&Active>) = actives.iter().partition(|active| active.is_refractor);
        let members = (refractors.into_iter())
            .map(|active| AskedMember {
                refractor: active.object,
                copies: None,
                coincident: (active.coincident.iter().map(contact))
                    .map(|c| (c.primitive, c.relation == Relation::Coincides { same: true }))
                    .collect(),
            })
            .collect();
        let opaque = opaque.into_iter().flat_map(|active| active.coincident.iter().map(contact).map(|c| c.primitive));
        AskedCell { base, members, opaque: opaque.collect(), is_crowded: false }
    }
}
