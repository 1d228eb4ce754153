//! Single functions of the shaders, called with given numbers: for tests, which compare them with their twins in Rust.

use super::fault::GpuFault;
use super::layout;
use super::pipeline::{compile, uniform_usage};
use super::renderer::{Gpu, image, variant};
use super::upload::CannotUpload;
use crate::render::film::Film;
use crate::render::renderer::RenderTask;

/// What a probe is put around: it reads and writes words, and calls functions of the shader of a scene and a mode.
const FRAME: &str = "
@group(1) @binding(0) var<storage, read_write> probe_out: array<u32>;
@group(1) @binding(2) var<storage, read> probe_in: array<u32>;
@group(1) @binding(4) var<storage, read_write> tracker_states: array<u32>;

fn number(index: u32) -> f32 { return bitcast<f32>(probe_in[index]); }
fn vector(index: u32) -> vec3f { return vec3f(number(index), number(index + 1u), number(index + 2u)); }
fn put(index: u32, value: f32) { probe_out[index] = bitcast<u32>(value); }
fn put_vector(index: u32, value: vec3f) { put(index, value.x); put(index + 1u, value.y); put(index + 2u, value.z); }

@compute @workgroup_size(64)
fn call_probe(@builtin(global_invocation_id) id: vec3u) {
    if id.x < PROBES { probe(id.x); }
}
";

impl Gpu {
    /// Runs `body`, WGSL that defines `fn probe(index: u32)`, for each index below `count`, in the shader and with the tables of `task`, whose image has
    /// that `size`. It reads `input` by `probe_in`, `number` or `vector`, and writes as many words as `output` says for each index by `probe_out`, `put` or
    /// `put_vector`.
    ///
    /// # Errors
    /// When the device cannot, or refuses the shader.
    pub fn probe(
        &self,
        task: &RenderTask<'_>,
        size: [u32; 2],
        body: &str,
        input: &[u32],
        count: u32,
        output: usize,
    ) -> Result<Vec<u32>, GpuFault> {
        let gpu = &*self.device;
        let scene = self.scene(task).map_err(|error| match error {
            CannotUpload::DoesNotFit(what) => GpuFault::Refused(format!("{what} does not fit")),
            CannotUpload::Fault(fault) => fault,
        })?;
        let variant = variant(task, scene.tree_depth());
        let library = self.pipelines.text(variant.library())?;
        let source = format!("{library}\nconst PROBES: u32 = {count}u;\n{FRAME}\n{body}");
        let (image, _) = image(task, &Film::new(size[0], size[1]));
        let bytes = (count as usize * output * size_of::<u32>()) as u64;
        let back = gpu.attempt(|device| {
            let layouts = [Some(&self.pipelines.scene.0), Some(&self.pipelines.film.0)];
            let pipeline = compile(device, &source, "call_probe", &variant.constants(), &layouts);
            let empty = |size, usage| {
                device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
            };
            let image = gpu.filled_buffer("image", uniform_usage(gpu), bytemuck::bytes_of(&image));
            let given = gpu.filled_buffer("input", wgpu::BufferUsages::STORAGE, bytemuck::cast_slice(input));
            let out = empty(bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
            let unused = [(); 4].map(|()| empty(size_of::<layout::Path>() as u64, wgpu::BufferUsages::STORAGE));
            let back = empty(bytes, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
            let scene = scene.bind(gpu, &self.pipelines.scene, &image);
            let film = [&out, &unused[0], &given, &unused[1], &unused[2], &unused[3]].into_iter();
            let film = self.pipelines.film.bind(device, film);
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &scene, &[]);
                pass.set_bind_group(1, &film, &[]);
                pass.dispatch_workgroups(count.div_ceil(64), 1, 1);
            }
            encoder.copy_buffer_to_buffer(&out, 0, &back, 0, bytes);
            gpu.queue.submit([encoder.finish()]);
            back.map_async(wgpu::MapMode::Read, .., |_| ());
            back
        })?;
        gpu.wait()?;
        let mapped = back.get_mapped_range(..).map_err(|error| GpuFault::Refused(error.to_string()))?;
        Ok(bytemuck::pod_collect_to_vec(&mapped))
    }
}
