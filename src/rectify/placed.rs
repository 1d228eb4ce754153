//! Lights without a surface, and the media that they stand in.

use std::sync::Arc;

use glam::DVec3;

use super::containment::{Vote, containment, medium_at, medium_of, top, votes_at};
use super::patch::{Patch, PatchKind};
use super::start::StartRegion;
use crate::scene::lights::Light;
use crate::scene::{MediumId, ObjectId, Scene};

/// A patch without faces for each, in the order of objects. A light that stands on a refractor's surface, and so in several media, has a mixed one;
/// one from afar is in the global medium.
pub(super) fn list(scene: &Scene) -> Vec<Patch> {
    (scene.emitters.iter())
        .filter_map(|(light, _)| {
            let id = light.object()?;
            match light {
                Light::Point(light) => Some(at(scene, id, light.position)),
                Light::Spot(light) => Some(at(scene, id, light.position)),
                Light::Directional(_) => Some(Patch { outside: Some(MediumId::WORLD), ..nowhere(id) }),
                Light::Area(_) | Light::Environment(_) => None,
            }
        })
        .collect()
}

fn at(scene: &Scene, light: ObjectId, position: DVec3) -> Patch {
    let region = StartRegion::by_asking(scene, position, 0.0, &|point| medium_at(scene, point));
    if region.whole().is_none() {
        let crossed_by = region.refractors(scene);
        return Patch { kind: PatchKind::Mixed, crossed_by, ..nowhere(light) };
    }
    let filler = top(scene, containment(scene, position, None).refractors);
    let votes = votes_at(scene, position);
    Patch {
        outside: Some(medium_of(scene, filler)),
        outside_refractor: filler,
        rays: votes.iter().map(|vote| vote.asked).max().unwrap_or(0),
        confidence: votes.iter().map(Vote::share).fold(1.0, f64::min),
        votes: Arc::new(votes),
        ..nowhere(light)
    }
}

fn nowhere(light: ObjectId) -> Patch {
    Patch {
        refractor: light,
        index: 0,
        kind: PatchKind::Clear,
        faces: 0,
        area: 0.0,
        outside: None,
        inside: None,
        outside_refractor: None,
        inside_refractor: None,
        crossed_by: Vec::new(),
        rays: 0,
        confidence: 1.0,
        votes: Arc::default(),
        within: None,
    }
}
