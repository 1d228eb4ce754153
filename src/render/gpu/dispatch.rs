//! One dispatch: a part of an image is rendered, and what its samples come to is brought back.

use glam::DVec3;

use super::device::GpuDevice;
use super::fault::GpuFault;
use super::layout::{self, PixelSums};
use super::pipeline::Pipelines;
use super::upload::SceneOnGpu;
use crate::render::film::SampleSums;
use crate::tracking::Events;

/// Threads of a workgroup along each side: `render/gpu/film.wgsl`.
pub const GROUP: u32 = 8;
/// Kinds of events that are counted, and the threads that are not at their end.
const EVENTS: usize = 7;
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
    /// Sums, then events, as they are brought back.
    back: wgpu::Buffer,
    paths: wgpu::Buffer,
    trackers: wgpu::Buffer,
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
                image: buffer("image", size_of::<layout::Image>() as u64, Usage::UNIFORM | Usage::COPY_DST),
                sums: buffer("sums", bytes, Usage::STORAGE | Usage::COPY_SRC),
                events: buffer("events", EVENT_BYTES, Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST),
                back: buffer("sums and events", bytes + EVENT_BYTES, Usage::MAP_READ | Usage::COPY_DST),
                paths: buffer("paths", u64::from(pixels) * size_of::<layout::Path>() as u64, Usage::STORAGE),
                trackers: buffer("trackers", 4 * u64::from(pixels) * u64::from(tracker_words.max(1)), Usage::STORAGE),
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
            let film = [&buffers.sums, &buffers.events, &ranges, &buffers.paths, &buffers.trackers].into_iter();
            Self {
                gpu,
                pipeline,
                buffers,
                scene: scene.bind(gpu, &pipelines.scene, &buffers.image),
                film: pipelines.film.bind(device, film),
            }
        })
    }

    /// Renders a part of an image and waits for it. Returns whether all paths are at their ends; if not, it has to go on, with
    /// [`layout::Image::is_start`] 0. At the end, what the samples come to is added to `band`; events always.
    ///
    /// # Errors
    /// When the device is lost or refuses.
    pub fn run(&self, part: &layout::Image, band: &mut Band) -> Result<bool, GpuFault> {
        let Self { gpu, buffers, .. } = self;
        let sum_bytes = u64::from(part.width * part.row_count) * size_of::<PixelSums>() as u64;
        gpu.attempt(|device| {
            gpu.queue.write_buffer(&buffers.image, 0, bytemuck::bytes_of(part));
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.clear_buffer(&buffers.events, 0, None);
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(self.pipeline);
                pass.set_bind_group(0, &self.scene, &[]);
                pass.set_bind_group(1, &self.film, &[]);
                pass.dispatch_workgroups(part.width.div_ceil(GROUP), part.row_count.div_ceil(GROUP), 1);
            }
            encoder.copy_buffer_to_buffer(&buffers.events, 0, &buffers.back, 0, EVENT_BYTES);
            encoder.copy_buffer_to_buffer(&buffers.sums, 0, &buffers.back, EVENT_BYTES, sum_bytes);
            gpu.queue.submit([encoder.finish()]);
            buffers.back.map_async(wgpu::MapMode::Read, ..sum_bytes + EVENT_BYTES, |_| ());
        })?;
        gpu.wait()?;
        let is_at_end = {
            let mapped = buffers
                .back
                .get_mapped_range(..sum_bytes + EVENT_BYTES)
                .map_err(|error| GpuFault::Refused(error.to_string()))?;
            let (events, sums) = mapped.split_at(EVENT_BYTES as usize);
            let events: Vec<u32> = bytemuck::pod_collect_to_vec(events);
            let is_at_end = events.last() == Some(&0);
            band.add_events(&events);
            if is_at_end {
                match bytemuck::try_cast_slice(sums) {
                    Ok(sums) => band.add_sums(sums),
                    Err(_) => band.add_sums(&bytemuck::pod_collect_to_vec::<u8, PixelSums>(sums)),
                }
            }
            is_at_end
        };
        buffers.back.unmap();
        Ok(is_at_end)
    }
}
