//! Open surfaces whose rims are joined to those of others: bodies that are modelled by their interfaces, such as a glass of wine as
//! glass–air, glass–wine and wine–air.

use std::collections::{BTreeMap, HashMap};

use super::distinct;
use crate::geometry::Enclosure;
use crate::geometry::topology::NONE;
use crate::rectify::subjects::primitives_of;
use crate::scene::{ObjectId, Scene};
use crate::tracking::Prepared;

/// Share of a rim's vertices that others must have.
const JOINED: f64 = 0.5;

/// By object, the others that its rim is joined to.
pub(super) type Rims = BTreeMap<ObjectId, Vec<ObjectId>>;

/// For each refractor that is not closed and whose rim is for the most part that of others: those others, in ascending order.
pub(super) fn joined(prepared: &Prepared) -> Rims {
    let scene = &*prepared.scene;
    let is_open = |id: &ObjectId| matches!(scene.object(*id).enclosure, Enclosure::Sheet | Enclosure::Holed);
    let open: Vec<ObjectId> = scene.refractors().map(|(id, _)| id).filter(is_open).collect();
    if open.len() < 2 {
        return BTreeMap::new();
    }
    let rims: Vec<Vec<[u64; 3]>> = open.iter().map(|&id| rim(prepared, scene, id)).collect();
    let mut owners: HashMap<[u64; 3], Vec<ObjectId>> = HashMap::new();
    for (id, rim) in open.iter().zip(&rims) {
        rim.iter().for_each(|vertex| owners.entry(*vertex).or_default().push(*id));
    }
    (open.iter().zip(&rims))
        .filter_map(|(&id, rim)| {
            let is_joined = |vertex: &&[u64; 3]| owners[*vertex].len() > 1;
            let shared: Vec<&[u64; 3]> = rim.iter().filter(is_joined).collect();
            let owners = shared.iter().flat_map(|vertex| &owners[*vertex]).copied();
            let others = distinct(owners.filter(|other| *other != id));
            let is_most = !shared.is_empty() && shared.len() as f64 >= JOINED * rim.len() as f64;
            is_most.then_some((id, others))
        })
        .collect()
}

/// The places of the vertices at which a surface ends, each once.
fn rim(prepared: &Prepared, scene: &Scene, id: ObjectId) -> Vec<[u64; 3]> {
    let Some(topology) = &scene.object(id).topology else { return Vec::new() };
    // Refractors are the first objects.
    let is_mirrored = prepared.description.objects.refractors()[id.0 as usize].transform.scale.element_product() < 0.0;
    let mut vertices = Vec::new();
    for (face, across) in primitives_of(&scene.geometry, id).zip(&topology.neighbours) {
        for (edge, _) in across.iter().enumerate().filter(|(_, other)| **other == NONE) {
            let corners = scene.geometry.corners(face);
            let edge = if is_mirrored { 2 - edge } else { edge };
            // Without the sign of a zero.
            vertices.extend([corners[edge], corners[(edge + 1) % 3]].map(|p| (p + 0.0).to_array().map(f64::to_bits)));
        }
    }
    distinct(vertices)
}
