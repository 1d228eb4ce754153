//! The renderer on the shared device, made when it is first asked for.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{Gpu, GpuDevice, GpuError, GpuFault};
use crate::render::film::Film;
use crate::render::renderer::{RenderTask, Renderer, Unsupported};
use crate::render::settings::Backend;

/// Renders on [`GpuDevice::shared`].
#[derive(Debug, Clone, Copy, Default)]
pub struct SharedGpu;

static RENDERER: Mutex<Option<Arc<Gpu>>> = Mutex::new(None);

fn lock() -> MutexGuard<'static, Option<Arc<Gpu>>> {
    RENDERER.lock().unwrap_or_else(PoisonError::into_inner)
}

impl SharedGpu {
    /// The renderer on the device that is shared now.
    ///
    /// # Errors
    /// As [`GpuDevice::shared`].
    pub fn get() -> Result<Arc<Gpu>, GpuError> {
        let device = GpuDevice::shared()?;
        let mut renderer = lock();
        Ok(match &*renderer {
            Some(gpu) if Arc::ptr_eq(&gpu.device, &device) => Arc::clone(gpu),
            _ => Arc::clone(renderer.insert(Arc::new(Gpu::new(device)))),
        })
    }

    /// What went wrong, if it has been used and something has.
    pub fn fault() -> Option<GpuFault> {
        lock().as_ref().and_then(|gpu| gpu.fault())
    }

    /// Gives up a renderer and a device that have failed, so that the next who asks gets new ones.
    pub fn renew() {
        lock().take_if(|gpu| gpu.fault().is_some());
        GpuDevice::renew();
    }
}

impl Renderer for SharedGpu {
    fn require(&self, task: &RenderTask<'_>) -> Result<(), Unsupported> {
        renderer()?.require(task)
    }

    fn is_ready(&self, task: &RenderTask<'_>) -> bool {
        renderer().is_ok_and(|gpu| gpu.is_ready(task))
    }

    fn make_ready(&self, task: &RenderTask<'_>) -> Result<(), Unsupported> {
        let gpu = renderer()?;
        let failed = || Unsupported {
            what: "anything any more".into(),
            backend: Backend::Gpu,
            instead: gpu.fault().map_or_else(|| "use the CPU".into(), |fault| fault.to_string()),
        };
        gpu.device.guarded(|| gpu.make_ready(task)).unwrap_or_else(|| Err(failed()))
    }

    fn pass(&self, task: &RenderTask<'_>, film: &mut Film, samples: u32, cancel: &AtomicBool) -> bool {
        let renderer = renderer();
        renderer.is_ok_and(|gpu| gpu.device.guarded(|| gpu.pass(task, film, samples, cancel)).unwrap_or(false))
    }
}

fn renderer() -> Result<Arc<Gpu>, Unsupported> {
    SharedGpu::get().map_err(|error| Unsupported {
        what: "anything".into(),
        backend: Backend::Gpu,
        instead: error.to_string(),
    })
}
