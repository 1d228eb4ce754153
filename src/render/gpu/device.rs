//! The device that everything is computed on: opened once and shared, watched for faults.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::adapter::{self, Adapter, GpuError};
use super::fault::{Faults, GpuFault, one_line};

/// Features that are used where the adapter has them. None is needed.
const USEFUL: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(wgpu::Features::SUBGROUP)
    .union(wgpu::Features::SHADER_INT64)
    .union(wgpu::Features::IMMEDIATES);

/// A device of a graphics processor, with all limits that its adapter offers.
#[derive(Debug)]
pub struct GpuDevice {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter: Adapter,
    pub limits: wgpu::Limits,
    /// Those of [`USEFUL`] that it has.
    pub features: wgpu::Features,
    faults: Faults,
}

/// The device of this process: `None` until it is asked for.
static SHARED: Mutex<Option<Result<Arc<GpuDevice>, GpuError>>> = Mutex::new(None);

impl GpuDevice {
    /// Opens a device of the best adapter. Takes from some ten milliseconds to seconds: not to be called on the window's thread.
    ///
    /// # Errors
    /// When there is no adapter that can compute, or the driver refuses.
    pub fn open() -> Result<Arc<Self>, GpuError> {
        let chosen = adapter::choose()?;
        let adapter = Adapter::of(&chosen.get_info());
        let (limits, features) = (chosen.limits(), chosen.features() & USEFUL);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("iorect"),
            required_features: features,
            required_limits: limits.clone(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(chosen.request_device(&descriptor))
            .map_err(|error| GpuError::NoDevice { adapter: adapter.label(), reason: one_line(&error.to_string()) })?;
        let faults = Faults::default();
        faults.listen(&device);
        log::info!("computing on {}, driver {}", adapter.label(), adapter.driver);
        Ok(Arc::new(Self { device, queue, adapter, limits, features, faults }))
    }

    /// The device of this process, opened when it is first asked for. After a loss it is the lost one, until [`Self::renew`].
    ///
    /// # Errors
    /// As [`Self::open`]; asked again, the same error.
    pub fn shared() -> Result<Arc<Self>, GpuError> {
        lock().get_or_insert_with(Self::open).clone()
    }

    /// Gives up the shared device if it has a fault, or could not be opened, so that the next who asks opens a new one.
    pub fn renew() {
        let mut shared = lock();
        if shared.as_ref().is_some_and(|device| device.as_ref().map_or(true, |device| device.fault().is_some())) {
            *shared = None;
        }
    }

    /// What went wrong on it, if anything has: it is then not to be used any more.
    pub fn fault(&self) -> Option<GpuFault> {
        self.faults.first()
    }

    /// Does `work`, which makes pipelines, buffers or commands, and returns its result unless the driver refuses any of them. Such
    /// a refusal is no fault of the device: it can be used for something else.
    ///
    /// # Errors
    /// What the driver refuses.
    pub fn attempt<T>(&self, work: impl FnOnce(&wgpu::Device) -> T) -> Result<T, GpuFault> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [Internal, Validation, OutOfMemory].map(|filter| self.device.push_error_scope(filter));
        let made = work(&self.device);
        // They are popped in the reverse order; the first error that is found is told.
        let mut fault = None;
        for scope in scopes.into_iter().rev() {
            let error = pollster::block_on(scope.pop()).map(GpuFault::from);
            fault = fault.or(error);
        }
        // On a lost device every call is refused.
        match self.fault().filter(|fault| matches!(fault, GpuFault::Lost(_))).or(fault) {
            Some(fault) => Err(fault),
            None => Ok(made),
        }
    }

    /// A buffer that holds `contents`, whose length is a multiple of four bytes; of one word where there are none. (wgpu's own function for it panics
    /// on a lost device.)
    pub fn filled_buffer(&self, label: &str, usage: wgpu::BufferUsages, contents: &[u8]) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: contents.len().max(4) as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    /// Does `work`; `None` if wgpu panics, as it does in places where a device is lost while it is asked for something. The device has a fault then.
    pub fn guarded<T>(&self, work: impl FnOnce() -> T) -> Option<T> {
        let outcome = catch_unwind(AssertUnwindSafe(work));
        if outcome.is_err() {
            self.faults.note(GpuFault::Refused("wgpu panicked".into()));
        }
        outcome.ok()
    }

    /// Waits until all that was submitted is done and its buffers are mapped.
    ///
    /// # Errors
    /// When the device is lost meanwhile.
    pub fn wait(&self) -> Result<(), GpuFault> {
        if let Err(error) = self.device.poll(wgpu::PollType::wait_indefinitely()) {
            self.faults.note(GpuFault::Lost(one_line(&error.to_string())));
        }
        self.fault().map_or(Ok(()), Err)
    }

    /// Takes the device away, as a driver that is reset does: for tests of what happens then.
    pub fn take_away(&self) {
        self.device.destroy();
        // The driver's word comes with the next poll, and only if there is one.
        self.faults.note(GpuFault::Lost("it was taken away".into()));
    }
}

fn lock() -> MutexGuard<'static, Option<Result<Arc<GpuDevice>, GpuError>>> {
    SHARED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A device for a test of its own. Where there is none, a test on a build server fails, and others say that they are skipped.
#[cfg(test)]
pub(crate) fn for_test() -> Option<Arc<GpuDevice>> {
    match GpuDevice::open() {
        Ok(device) => Some(device),
        Err(error) if std::env::var_os("CI").is_some() => panic!("no device to test on: {error}"),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Doubles numbers.
    const DOUBLE: &str = "
        @group(0) @binding(0) var<storage, read_write> numbers: array<u32>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {
            if id.x < arrayLength(&numbers) { numbers[id.x] = 2u * numbers[id.x]; }
        }";

    fn pipeline(device: &wgpu::Device, source: &'static str) -> wgpu::ComputePipeline {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        })
    }

    fn doubled(gpu: &GpuDevice, numbers: &[u32]) -> Result<Vec<u32>, GpuFault> {
        let bytes = size_of_val(numbers) as u64;
        let (read, pipeline, commands) = gpu.attempt(|device| {
            let pipeline = pipeline(device, DOUBLE);
            let buffer = |usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: None,
                    size: bytes,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let storage =
                buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST);
            let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
            gpu.queue.write_buffer(&storage, 0, bytemuck::cast_slice(numbers));
            let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: storage.as_entire_binding() }],
            });
            let mut encoder = device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &bindings, &[]);
                pass.dispatch_workgroups(numbers.len().div_ceil(64) as u32, 1, 1);
            }
            encoder.copy_buffer_to_buffer(&storage, 0, &read, 0, bytes);
            (read, pipeline, encoder.finish())
        })?;
        drop(pipeline);
        gpu.queue.submit([commands]);
        read.map_async(wgpu::MapMode::Read, .., |_| ());
        gpu.wait()?;
        let mapped = read.get_mapped_range(..).map_err(|error| GpuFault::Refused(error.to_string()))?;
        Ok(bytemuck::pod_collect_to_vec(&mapped))
    }

    #[test]
    fn a_device_computes_and_has_its_adapters_limits() {
        let Some(gpu) = for_test() else { return };
        assert!(!gpu.adapter.name.is_empty() && gpu.adapter.label().contains(gpu.adapter.api));
        assert!(gpu.limits.max_storage_buffer_binding_size >= 1 << 27, "{:?}", gpu.limits);
        let numbers: Vec<u32> = (0..1000).collect();
        assert_eq!(doubled(&gpu, &numbers), Ok(numbers.iter().map(|n| 2 * n).collect()));
        assert_eq!(gpu.fault(), None);
    }

    #[test]
    fn what_the_driver_refuses_is_told_and_the_rest_goes_on() {
        let Some(gpu) = for_test() else { return };
        let wrong = gpu.attempt(|device| pipeline(device, "fn main() { this is no shader }"));
        assert!(matches!(&wrong, Err(GpuFault::Refused(why)) if !why.is_empty()), "{wrong:?}");
        assert_eq!(gpu.fault(), None);
        assert_eq!(doubled(&gpu, &[3, 4]), Ok(vec![6, 8]));
        // Nobody listens here: it becomes the device's fault, and ends nothing.
        pipeline(&gpu.device, "nor is this");
        assert!(matches!(gpu.fault(), Some(GpuFault::Refused(_))), "{:?}", gpu.fault());
    }

    #[test]
    fn a_device_that_is_taken_away_is_lost_and_nothing_panics() {
        let Some(gpu) = for_test() else { return };
        gpu.take_away();
        assert!(matches!(gpu.fault(), Some(GpuFault::Lost(_))));
        assert!(matches!(doubled(&gpu, &[1, 2, 3]), Err(GpuFault::Lost(_))));
        assert!(gpu.wait().is_err());
    }

    #[test]
    fn one_device_is_shared() {
        let Ok(first) = GpuDevice::shared() else {
            assert!(GpuDevice::shared().is_err());
            return;
        };
        assert!(Arc::ptr_eq(&first, &GpuDevice::shared().unwrap()));
        // It is as good as before, so it is kept.
        GpuDevice::renew();
        assert!(first.fault().is_some() || Arc::ptr_eq(&first, &GpuDevice::shared().unwrap()));
    }
}
