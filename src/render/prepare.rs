//! From a description to something that can be traced, doing again only what an edit can have changed.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use crate::rectify::InterfaceTable;
use crate::scene::compile::{changed_objects, compile};
use crate::scene::{Description, SceneError, World};
use crate::tracking::reference::{Bodies, Reference};

/// A compiled and rectified scene. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Prepared {
    pub description: Arc<Description>,
    pub world: Arc<World>,
    pub table: Arc<InterfaceTable>,
    /// What mode `reference` asks, once it has been asked for.
    pub bodies: Arc<OnceLock<Bodies>>,
    pub seconds: PrepareSeconds,
}

/// Time spent on each part, in seconds; parts that were kept cost next to nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PrepareSeconds {
    /// Tessellating, transforming, building the tree.
    pub bvh: f64,
    /// Rectification as a whole.
    pub rectify: f64,
}

/// Compiles and rectifies `description`. With `previous`, only what the edit can have changed is done again: geometry and its tree are
/// kept where no shape or transform changed, and what was found about objects far from those that did.
///
/// # Errors
/// When the scene is impossible: see [`SceneError`].
pub fn prepare(description: Arc<Description>, previous: Option<&Prepared>) -> Result<Prepared, SceneError> {
    let start = Instant::now();
    let world = compile(&description, previous.map(|p| (&*p.description, &*p.world)))?;
    let bvh = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let table = match previous {
        Some(previous) => match changed_objects(&previous.description, &description) {
            Some(changed) => previous.table.updated(&world, &previous.world, &changed),
            None => InterfaceTable::new(&world),
        },
        None => InterfaceTable::new(&world),
    };
    let seconds = PrepareSeconds { bvh, rectify: start.elapsed().as_secs_f64() };
    let bodies = match previous {
        Some(previous) if Arc::ptr_eq(&previous.world.geometry, &world.geometry) => Arc::clone(&previous.bodies),
        _ => Arc::default(),
    };
    Ok(Prepared { description, world: Arc::new(world), table: Arc::new(table), bodies, seconds })
}

impl Prepared {
    /// Mode `reference` at work. The first call reads all refractors' meshes anew.
    pub fn reference(&self) -> Reference<'_> {
        let bodies = self.bodies.get_or_init(|| Bodies::new(&self.description, &self.world));
        Reference { world: &self.world, bodies }
    }
}
