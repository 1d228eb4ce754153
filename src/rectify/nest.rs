//! Deep nests. An object that no surface touches, inside another that none touches, is contained by that one and by its containers. So only the
//! innermost container is asked for and listed: N nested shells take N questions instead of N².

use super::containment::{outward_ray, top};
use super::object_table::container_along;
use super::random::Random;
use super::site::{Faces, Site, SiteVotes};
use super::surroundings::Fillers;
use crate::geometry::Enclosure;
use crate::scene::{ObjectId, Scene};

/// Containers are inherited in scenes of at least this many refractors. In smaller ones every patch is asked about all of them, which finds more
/// doubtful answers.
const MANY: usize = 256;
/// Rays that must find the same container.
pub const RAYS: u32 = 3;

/// The refractors that others may inherit from: closed ones in one piece that no other surface touches.
#[derive(Debug, Clone, Default)]
pub struct Nest {
    /// By object; empty where nothing is inherited.
    is_whole: Vec<bool>,
}

impl Nest {
    /// Of a scene in which `is_untouched` says of every closed refractor of one component whether no surface touches it.
    pub fn new(scene: &Scene, is_untouched: impl Fn(ObjectId) -> bool) -> Self {
        let refractors = || scene.refractors().map(|(refractor, _)| refractor);
        // The first hit along a ray tells containment for closed surfaces only.
        let is_simple = refractors().all(|refractor| scene.object(refractor).enclosure == Enclosure::Closed);
        if !is_simple || refractors().count() < MANY {
            return Self::default();
        }
        let mut is_whole = vec![false; scene.objects.len()];
        for refractor in refractors() {
            let is_one =
                scene.geometry.face_count(refractor.0) > 0 && !scene.object(refractor).has_several_components();
            is_whole[refractor.0 as usize] = is_one && is_untouched(refractor);
        }
        Self { is_whole }
    }

    /// Of a scene that has been laid out into `sites`.
    pub fn of_sites(scene: &Scene, sites: &[Site]) -> Self {
        let whole = whole_sites(scene, sites);
        Self::new(scene, |refractor| whole[refractor.0 as usize].is_some_and(|number| can_inherit(&sites[number])))
    }

    /// Asks for the innermost container of a site. `None` where that does not tell all of them; `Some(None)` where there is none.
    pub fn container(&self, scene: &Scene, site: &Site, random: &mut Random) -> Option<Option<ObjectId>> {
        if self.is_whole.is_empty() || !can_inherit(site) {
            return None;
        }
        let mut found: Option<Option<ObjectId>> = None;
        for _ in 0..RAYS {
            let point = site.sample(&scene.geometry, [random.next(), random.next(), random.next()])?;
            let container = container_along(scene, outward_ray(&point, random), site.subject);
            if found.is_some_and(|found| found != container) {
                return None;
            }
            found = Some(container);
        }
        let is_larger = |container: ObjectId| {
            !scene.is_refractor(site.subject) || scene.object(container).volume > scene.object(site.subject).volume
        };
        found.filter(|found| found.is_none_or(|found| self.is_whole[found.0 as usize] && is_larger(found)))
    }
}

/// Whether a site is all of an object, and nothing coincides with it.
fn can_inherit(site: &Site) -> bool {
    site.faces == Faces::Whole && site.settled.is_empty() && !site.fixed.is_masked
}

/// The number of the site that is all of an object, by object; `None` where the object has several.
fn whole_sites(scene: &Scene, sites: &[Site]) -> Vec<Option<usize>> {
    let mut whole = vec![None; scene.objects.len()];
    for (number, site) in sites.iter().enumerate().filter(|(_, site)| site.faces == Faces::Whole) {
        whole[site.subject.0 as usize] = Some(number);
    }
    whole
}

/// What fills the two sides of every site, by priority and volume.
pub fn fillers(scene: &Scene, sites: &[Site], votes: &[SiteVotes]) -> Vec<Fillers> {
    let whole = whole_sites(scene, sites);
    let of_listed =
        |(site, votes): (&Site, &SiteVotes)| votes.within.is_none().then(|| votes.surroundings(site).fillers(scene));
    let mut fillers: Vec<Option<Fillers>> = sites.iter().zip(votes).map(of_listed).collect();
    for first in 0..fillers.len() {
        // Follow containers outwards to a resolved site, then resolve back inwards.
        let mut ways = Vec::new();
        let mut at = first;
        while let (None, Some(container)) = (fillers[at], votes[at].within) {
            let around = whole[container.0 as usize].expect("only objects of one site are inherited from");
            ways.push((at, container, around));
            at = around;
        }
        for (site, container, around) in ways.into_iter().rev() {
            let outer = top(scene, fillers[around].and_then(|around| around.outer).into_iter().chain([container]));
            let inner = top(scene, outer.into_iter().chain([sites[site].subject]));
            fillers[site] = Some(Fillers { outer, inner });
        }
    }
    fillers.into_iter().map(|fillers| fillers.unwrap_or(Fillers { outer: None, inner: None })).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::formats;
    use crate::rectify::InterfaceTable;
    use crate::rectify::pretrace::vote;
    use crate::scene::compile::{changed_objects, compile};
    use crate::scene::description::{Description, Shape};

    /// Balls and meshes of balls in each other, in three heaps, and some beside them; those of the first heap have priorities.
    fn heaps(count: u32) -> Description {
        let mut text = String::from("[camera]\nposition = [0, 0, 99]\ntarget = [0, 0, 0]\n");
        for k in 0..7 {
            text += &format!("[[medium]]\nname = \"m{k}\"\nior = {}\n", 1.1 + 0.1 * f64::from(k));
        }
        for k in 0..count {
            let (heap, level) = (f64::from(k % 3), f64::from(k / 3));
            let size = 0.97_f64.powf(level);
            let x = 4.0 * heap + 0.01 * size;
            let shape = match k % 5 {
                0 => format!("icosphere = {{ center = [{x}, 0, 0], radius = {size}, subdivisions = 2 }}"),
                // Beside the others.
                1 => format!("sphere = {{ center = [{x}, {}, 2], radius = 0.001 }}", 0.003 * level),
                _ => format!("sphere = {{ center = [{x}, 0, 0], radius = {size} }}"),
            };
            text += &format!(
                "[[refractor]]\nname = \"r{k}\"\nmedium = \"m{}\"\npriority = {}\nshape = {{ {shape} }}\n",
                k % 7,
                if k % 3 == 0 { k % 4 } else { 0 }
            );
        }
        let light = "[[light]]\nname = \"lamp\"\nradiance = [1, 1, 1]\nshape = { sphere = { center = [0, 0, 0], radius = 0.001 } }\n";
        formats::parse(&(text + light), "heaps.toml".as_ref(), &formats::Disk).unwrap()
    }

    #[test]
    fn what_is_inherited_is_what_would_be_found() {
        let scene = compile(&heaps(400), None).unwrap();
        let table = InterfaceTable::new(&scene);
        let (layout, votes) = (&table.layout, &table.votes);
        let inherited = votes.iter().filter(|votes| votes.within.is_some()).count();
        assert!(inherited > 100, "{inherited}");
        let fillers = fillers(&scene, &layout.sites, votes);
        for (number, site) in layout.sites.iter().enumerate() {
            let all = vote(&scene, site, &Nest::default(), SiteVotes::default()).surroundings(site);
            assert_eq!(fillers[number], all.fillers(&scene), "{}", scene.object(site.subject).name);
        }
        assert!(table.repeated(&scene).says_the_same(&table));
    }

    /// A ball beside the heaps is moved across the outermost shell of one, far from all that lies deeper, and away again.
    #[test]
    fn an_edit_of_a_shell_finds_what_inherits_from_it_anew() {
        let mut description = heaps(400);
        let mut scene = compile(&description, None).unwrap();
        let mut table = InterfaceTable::new(&scene);
        let mover = 31;
        assert_eq!(mover % 5, 1);
        let Shape::Sphere { center, .. } = description.objects[mover].shape else { panic!("it is a ball") };
        let across = DVec3::new(0.0097, 0.0, 0.97);
        for to in [across, DVec3::new(0.0, 9.0, 0.0), across * 1.0001, DVec3::new(0.5, 0.5, 2.0)] {
            let before = description.clone();
            description.objects[mover].transform.translate = to - center;
            let moved = compile(&description, Some((&before, &scene))).unwrap();
            let changed = changed_objects(&before, &description).unwrap();
            let after = table.updated(&moved, &scene, &changed);
            assert!(after.says_the_same(&InterfaceTable::new(&moved)), "{to}");
            (scene, table) = (moved, after);
        }
    }
}
