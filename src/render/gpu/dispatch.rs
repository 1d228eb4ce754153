//! One dispatch: a part of an image is rendered, and what its samples come to is brought back.
//!
//! One kernel follows paths through all that may happen to them; those that are not at their ends after some steps are gathered, and the next dispatch goes on
//! with them side by side. That is what a wavefront of kernels (Laine, Karras and Aila 2013) gains where paths are of very different lengths, with one shader to compile and a
//! state that is written once a ray at the most. Measured on Mesa's llvmpipe, in the scene of iced water: one sample of 640 × 400 pixels takes 6.7 s where paths are gathered, and
//! 11.3 s where each stays in its place among those that have ended. A kernel for each stage, sorted by what is hit, has not been measured: what it gains depends on how
//! hardware bears branches that part and registers that are many, which software does not tell.

use glam::DVec3;

use super::device::GpuDevice;
use super::fault::GpuFault;
use super::layout::{self, PixelSums};
use super::pipeline::{Pipelines, uniform_usage};
use super::upload::SceneOnGpu;
use crate::render::film::SampleSums;
use crate::tracking::Events;

/// Threads of a workgroup along each side: `render/gpu/film.wgsl`.
pub const GROUP: u32 = 8;
/// Kinds of events that are counted, then the threads that are not at their end, then their steps.
const EVENTS: usize = 8;
/// Steps are counted in units of so many, as a dispatch can take more than fit into 32 bits.
const STEPS_UNIT: u64 = 64;
const EVENT_BYTES: u64 = (EVENTS * size_of::<u32>()) as u64;

/// Rows of an image that are rendered together.
#[derive(Debug)]
pub struct Band {
    /// Of each pixel.
    pub sums: Vec<SampleSums>,
    pub events: Events,
}

impl Band {
    pub fn new(width: u32, row_count: u32) -> Self {
        Self { sums: vec![SampleSums::default(); (width * row_count) as usize], events: Events::default() }
    }

    /// Takes everything away.
    pub fn clear(&mut self) {
        self.sums.fill(SampleSums::default());
        self.events = Events::default();
    }

    /// Samples that were taken, finite or not.
    pub fn samples(&self) -> u64 {
        self.sums.iter().map(|sums| u64::from(sums.count)).sum::<u64>() + self.events.non_finite
    }

    /// Of the paths of all samples.
    pub fn segments(&self) -> u64 {
        self.sums.iter().map(|sums| u64::from(sums.segments)).sum()
    }

    fn add_sums(&mut self, pixels: &[PixelSums]) {
        for (sums, pixel) in self.sums.iter_mut().zip(pixels) {
            sums.radiance += DVec3::from(pixel.radiance.map(f64::from));
            sums.count += pixel.count;
            sums.squares.iter_mut().zip(pixel.squares).for_each(|(sum, square)| *sum += square);
            sums.segments += pixel.segments;
        }
    }

    fn add_events(&mut self, events: &[u32]) {
        let [stack_underflow, stack_overflow, inconsistent, non_finite, crossings, mixed] =
            std::array::from_fn(|kind| events.get(kind).copied().map_or(0, u64::from));
        self.events +=
            Events { stack_underflow, stack_overflow, inconsistent, non_finite, crossings, mixed, ..Events::default() };
    }
}

/// Buffers of one dispatch, used again by the next.
#[derive(Debug)]
pub struct FilmBuffers {
    image: wgpu::Buffer,
    sums: wgpu::Buffer,
    events: wgpu::Buffer,
    /// Events or sums, as they are brought back.
    back: wgpu::Buffer,
    paths: wgpu::Buffer,
    trackers: wgpu::Buffer,
    lists: wgpu::Buffer,
    pixels: u32,
    tracker_words: u32,
}

impl FilmBuffers {
    /// Bytes that a pixel takes in the largest of them.
    pub fn bytes_per_pixel(tracker_words: u32) -> u64 {
        u64::max(size_of::<layout::Path>() as u64, 4 * u64::from(tracker_words))
    }

    /// For dispatches of up to so many pixels, and paths whose trackers keep so many words.
    ///
    /// # Errors
    /// When there is no memory left.
    pub fn new(gpu: &GpuDevice, pixels: u32, tracker_words: u32) -> Result<Self, GpuFault> {
        use wgpu::BufferUsages as Usage;
        let bytes = u64::from(pixels) * size_of::<PixelSums>() as u64;
        gpu.attempt(|device| {
            let buffer = |label, size, usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size,
                    usage,
                    mapped_at_creation: false,
                })
            };
            Self {
                image: buffer("image", size_of::<layout::Image>() as u64, uniform_usage(gpu) | Usage::COPY_DST),
                sums: buffer("sums", bytes, Usage::STORAGE | Usage::COPY_SRC),
                events: buffer("events", EVENT_BYTES, Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST),
                back: buffer("brought back", bytes.max(EVENT_BYTES), Usage::MAP_READ | Usage::COPY_DST),
                paths: buffer("paths", u64::from(pixels) * size_of::<layout::Path>() as u64, Usage::STORAGE),
                trackers: buffer("trackers", 4 * u64::from(pixels) * u64::from(tracker_words.max(1)), Usage::STORAGE),
                lists: buffer("lists", 2 * 4 * u64::from(pixels), Usage::STORAGE),
                pixels,
                tracker_words,
            }
        })
    }

    /// Whether they have room for that.
    pub fn have_room(&self, pixels: u32, tracker_words: u32) -> bool {
        self.pixels >= pixels && self.tracker_words >= tracker_words
    }
}

/// What dispatches of one pass share.
#[derive(Debug)]
pub struct Dispatcher<'a> {
    gpu: &'a GpuDevice,
    pipeline: &'a wgpu::ComputePipeline,
    buffers: &'a FilmBuffers,
    scene: wgpu::BindGroup,
    film: wgpu::BindGroup,
}

impl<'a> Dispatcher<'a> {
    /// With the samples of each pixel in `ranges`, where they differ.
    ///
    /// # Errors
    /// When there is no memory left.
    pub fn new(
        gpu: &'a GpuDevice,
        pipelines: &Pipelines,
        scene: &SceneOnGpu,
        pipeline: &'a wgpu::ComputePipeline,
        buffers: &'a FilmBuffers,
        ranges: Option<&[[u32; 2]]>,
    ) -> Result<Self, GpuFault> {
        gpu.attempt(|device| {
            let contents = bytemuck::cast_slice(ranges.unwrap_or(&[[0; 2]]));
            let ranges = gpu.filled_buffer("ranges", wgpu::BufferUsages::STORAGE, contents);
            let film = [&buffers.sums, &buffers.events, &ranges, &buffers.paths, &buffers.trackers, &buffers.lists];
            Self {
                gpu,
                pipeline,
                buffers,
                scene: scene.bind(gpu, &pipelines.scene, &buffers.image),
                film: pipelines.film.bind(device, film.into_iter()),
            }
        })
    }

    /// Renders a part of a band and waits for it. Paths that are not at their ends are put into the list at [`layout::Image::list_out`], to go on; then
    /// [`Self::bring_back`] adds what the samples come to. What happened is added to `band` here.
    ///
    /// # Errors
    /// When the device is lost or refuses.
    pub fn run(&self, part: &layout::Image, band: &mut Band) -> Result<Ran, GpuFault> {
        let Self { gpu, buffers, .. } = self;
        gpu.attempt(|device| {
            gpu.queue.write_buffer(&buffers.image, 0, bytemuck::bytes_of(part));
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.clear_buffer(&buffers.events, 0, None);
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(self.pipeline);
                pass.set_bind_group(0, &self.scene, &[]);
                pass.set_bind_group(1, &self.film, &[]);
                let [x, y] = match part.is_start {
                    0 => [part.path_count.div_ceil(GROUP * GROUP), 1],
                    _ => [part.width.div_ceil(GROUP), part.row_count.div_ceil(GROUP)],
                };
                pass.dispatch_workgroups(x, y, 1);
            }
            self.copy_back(encoder, &buffers.events, EVENT_BYTES);
        })?;
        let events: Vec<u32> = self.mapped(EVENT_BYTES, bytemuck::pod_collect_to_vec)?;
        band.add_events(&events);
        let [.., open, steps] = events[..] else { return Err(GpuFault::Refused("nothing was brought back".into())) };
        Ok(Ran { open, steps: STEPS_UNIT * u64::from(steps) })
    }

    /// Adds what the samples of a whole band come to.
    ///
    /// # Errors
    /// When the device is lost or refuses.
    pub fn bring_back(&self, band: &mut Band) -> Result<(), GpuFault> {
        let bytes = (band.sums.len() * size_of::<PixelSums>()) as u64;
        self.gpu.attempt(|device| {
            let encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.copy_back(encoder, &self.buffers.sums, bytes);
        })?;
        self.mapped(bytes, |sums| match bytemuck::try_cast_slice(sums) {
            Ok(sums) => band.add_sums(sums),
            Err(_) => band.add_sums(&bytemuck::pod_collect_to_vec::<u8, PixelSums>(sums)),
        })
    }

    /// Submits what was encoded, and a copy of the first `bytes` of a buffer.
    fn copy_back(&self, mut encoder: wgpu::CommandEncoder, from: &wgpu::Buffer, bytes: u64) {
        let back = &self.buffers.back;
        encoder.copy_buffer_to_buffer(from, 0, back, 0, bytes);
        self.gpu.queue.submit([encoder.finish()]);
        back.map_async(wgpu::MapMode::Read, ..bytes, |_| ());
    }

    /// Waits for what was submitted, and reads what was copied.
    fn mapped<T>(&self, bytes: u64, read: impl FnOnce(&[u8]) -> T) -> Result<T, GpuFault> {
        self.gpu.wait()?;
        let back = &self.buffers.back;
        let read = back.get_mapped_range(..bytes).map(|mapped| read(&mapped));
        back.unmap();
        read.map_err(|error| GpuFault::Refused(error.to_string()))
    }
}

/// How a dispatch went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ran {
    /// Paths that are not at their ends.
    pub open: u32,
    /// Turns of loops that all threads took together: nodes and triangles that rays were held against, about.
    pub steps: u64,
}
