//! What a device does at the most, measured: how fast it copies its memory, and how fast it multiplies and adds.

use std::time::Instant;

use super::device::GpuDevice;
use super::fault::GpuFault;
use super::pipeline::compile;
use super::renderer::Gpu;

/// The limits that rendering is held against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Read and written, together.
    pub bytes_per_sec: f64,
    /// In f32; a multiplication with an addition counts as two.
    pub flops_per_sec: f64,
}

/// Sixteen independent sums a round, which stay where they began.
const ARITHMETIC: &str = "
@group(0) @binding(0) var<storage, read_write> numbers: array<vec4f>;

@compute @workgroup_size(64)
fn multiply_and_add(@builtin(global_invocation_id) id: vec3u) {
    var a = numbers[id.x];
    var b = a + 1.0;
    var c = a + 2.0;
    var d = a + 3.0;
    for (var round = 0u; round < ROUNDS; round += 1u) {
        a = fma(a, vec4f(0.999), vec4f(0.001));
        b = fma(b, vec4f(0.998), vec4f(0.002));
        c = fma(c, vec4f(0.997), vec4f(0.003));
        d = fma(d, vec4f(0.996), vec4f(0.004));
    }
    numbers[id.x] = a + b + c + d;
}
";
const ROUNDS: u32 = 1024;
const FLOPS_PER_ROUND: f64 = 32.0;
/// Time that is measured, at least, in seconds.
const LEAST_SECS: f64 = 0.1;

impl Gpu {
    /// Takes about half a second.
    ///
    /// # Errors
    /// When the device refuses or is lost.
    pub fn limits(&self) -> Result<Limits, GpuFault> {
        let gpu = &*self.device;
        let (threads, bytes): (u32, u64) =
            if gpu.adapter.is_software { (1 << 12, 32 << 20) } else { (1 << 20, 256 << 20) };
        let bytes = bytes.min(gpu.limits.max_buffer_size / 2) / 256 * 256;
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let buffer = |size| {
            gpu.attempt(|device| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: None,
                    size,
                    usage: storage,
                    mapped_at_creation: false,
                })
            })
        };
        let (from, to) = (buffer(bytes)?, buffer(bytes)?);
        let copies_per_sec = rate(gpu, |encoder| encoder.copy_buffer_to_buffer(&from, 0, &to, 0, bytes))?;
        let numbers = buffer(u64::from(threads) * 16)?;
        let (pipeline, bindings) = gpu.attempt(|device| {
            let source = format!("const ROUNDS: u32 = {ROUNDS}u;{ARITHMETIC}");
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[super::pipeline::entry(0, wgpu::BufferBindingType::Storage { read_only: false })],
            });
            let bindings = super::pipeline::bind(device, &layout, std::iter::once(&numbers));
            (compile(device, &source, "multiply_and_add", &[], &[Some(&layout)]), bindings)
        })?;
        let dispatches_per_sec = rate(gpu, |encoder| {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bindings, &[]);
            pass.dispatch_workgroups(threads / 64, 1, 1);
        })?;
        Ok(Limits {
            bytes_per_sec: 2.0 * bytes as f64 * copies_per_sec,
            flops_per_sec: f64::from(threads) * f64::from(ROUNDS) * FLOPS_PER_ROUND * dispatches_per_sec,
        })
    }
}

/// How often a second what `encode` encodes is done, after a first time that finds cold caches.
fn rate(gpu: &GpuDevice, encode: impl Fn(&mut wgpu::CommandEncoder)) -> Result<f64, GpuFault> {
    let secs = |count: u32| -> Result<f64, GpuFault> {
        let start = Instant::now();
        gpu.attempt(|device| {
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            (0..count).for_each(|_| encode(&mut encoder));
            gpu.queue.submit([encoder.finish()]);
        })?;
        gpu.wait()?;
        Ok(start.elapsed().as_secs_f64())
    };
    secs(1)?;
    let mut count = 1;
    loop {
        let took = secs(count)?;
        if took >= LEAST_SECS || count >= 1 << 12 {
            return Ok(f64::from(count) / took);
        }
        count *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::gpu::device::for_test;

    #[test]
    fn limits_are_measured_and_far_from_nothing() {
        let Some(device) = for_test() else { return };
        let limits = Gpu::new(device).limits().unwrap();
        assert!(limits.bytes_per_sec > 1e7 && limits.flops_per_sec > 1e7, "{limits:?}");
    }
}
