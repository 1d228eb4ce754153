//! From a description to something that can be traced, doing again only what an edit can have changed.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use super::reference::bodies::Bodies;
use crate::rectify::{Cancelled, InterfaceTable, Progress};
use crate::scene::compile::{changed_objects, compile};
use crate::scene::{Description, Scene, SceneError};

/// A compiled and rectified scene. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Prepared {
    pub description: Arc<Description>,
    pub scene: Arc<Scene>,
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

/// Why there is no prepared scene.
#[derive(Debug, Clone, thiserror::Error)]
pub enum PrepareError {
    /// The scene is impossible.
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Compiles and rectifies `description`. With `previous`, only what the edit can have changed is done again: geometry and its tree are
/// kept where no shape or transform changed, and what was found about objects far from those that did.
///
/// # Errors
/// When the scene is impossible: see [`SceneError`].
pub fn prepare(description: Arc<Description>, previous: Option<&Prepared>) -> Result<Prepared, SceneError> {
    prepare_watched(description, previous, &Progress::new()).map_err(|error| match error {
        PrepareError::Scene(error) => error,
        PrepareError::Cancelled(_) => unreachable!("nobody else knows of its progress"),
    })
}

/// [`prepare`], watched: whoever shares `progress` sees how far it has come, and may cancel it.
///
/// # Errors
/// When the scene is impossible, and when it is cancelled.
pub fn prepare_watched(
    description: Arc<Description>,
    previous: Option<&Prepared>,
    progress: &Progress,
) -> Result<Prepared, PrepareError> {
    let start = Instant::now();
    let scene = compile(&description, previous.map(|p| (&*p.description, &*p.scene)))?;
    let bvh = start.elapsed().as_secs_f64();
    progress.go_on()?;
    let start = Instant::now();
    let changed = previous.and_then(|previous| changed_objects(&previous.description, &description));
    let table = match (previous, changed) {
        (Some(previous), Some(changed)) => {
            previous.table.updated_watched(&scene, &previous.scene, &changed, progress)?
        }
        _ => InterfaceTable::new_watched(&scene, progress)?,
    };
    let seconds = PrepareSeconds { bvh, rectify: start.elapsed().as_secs_f64() };
    let bodies = match previous {
        Some(previous) if Arc::ptr_eq(&previous.scene.geometry, &scene.geometry) => Arc::clone(&previous.bodies),
        _ => Arc::default(),
    };
    Ok(Prepared { description, scene: Arc::new(scene), table: Arc::new(table), bodies, seconds })
}

impl Prepared {
    /// What mode `reference` asks. The first call reads all refractors' meshes anew.
    pub fn bodies(&self) -> &Bodies {
        self.bodies.get_or_init(|| Bodies::new(&self.description, &self.scene))
    }
}
