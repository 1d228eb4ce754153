//! Compiled shaders, kept for as long as the device is.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::device::GpuDevice;
use super::fault::GpuFault;
use super::shader::Variant;

/// Buffers that the shaders read, in group 0, after the two uniform ones.
const READ_BUFFERS: u32 = 12;
/// Storage buffers of both groups.
pub const STORAGE_BUFFERS: u32 = READ_BUFFERS + 5;

/// The bindings of group 0: `render/gpu/scene.wgsl`.
#[derive(Debug)]
pub struct SceneLayout(pub wgpu::BindGroupLayout);

impl SceneLayout {
    pub fn new(device: &wgpu::Device) -> Self {
        let uniform = |binding: u32| entry(binding, wgpu::BufferBindingType::Uniform);
        let read = |binding: u32| entry(binding, wgpu::BufferBindingType::Storage { read_only: true });
        let entries: Vec<_> = (0..2).map(uniform).chain((2..2 + READ_BUFFERS).map(read)).collect();
        Self(
            device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("scene"), entries: &entries }),
        )
    }

    /// `buffers` in the order of the bindings.
    pub fn bind<'a>(&self, gpu: &GpuDevice, buffers: impl Iterator<Item = &'a wgpu::Buffer>) -> wgpu::BindGroup {
        bind(&gpu.device, &self.0, buffers)
    }
}

/// The bindings of group 1: `render/gpu/film.wgsl`.
#[derive(Debug)]
pub struct FilmLayout(pub wgpu::BindGroupLayout);

impl FilmLayout {
    pub fn new(device: &wgpu::Device) -> Self {
        let storage = |binding: u32, read_only: bool| entry(binding, wgpu::BufferBindingType::Storage { read_only });
        Self(device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("film"),
            entries: &[storage(0, false), storage(1, false), storage(2, true), storage(3, false), storage(4, false)],
        }))
    }

    pub fn bind<'a>(&self, device: &wgpu::Device, buffers: impl Iterator<Item = &'a wgpu::Buffer>) -> wgpu::BindGroup {
        bind(device, &self.0, buffers)
    }
}

fn entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

fn bind<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: impl Iterator<Item = &'a wgpu::Buffer>,
) -> wgpu::BindGroup {
    let entries: Vec<_> = buffers
        .enumerate()
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding: binding as u32, resource: buffer.as_entire_binding() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// A change of the text of all shaders: for tests, which plant faults.
#[derive(Debug, Clone, Copy)]
pub struct Replacement {
    /// Stands in each shader once.
    pub from: &'static str,
    pub to: &'static str,
}

impl Replacement {
    fn apply(self, source: &str) -> Result<String, GpuFault> {
        match source.matches(self.from).count() {
            1 => Ok(source.replace(self.from, self.to)),
            count => Err(GpuFault::Refused(format!("`{}` is in the shader {count} times", self.from))),
        }
    }
}

/// The pipelines of one device.
#[derive(Debug)]
pub struct Pipelines {
    pub scene: SceneLayout,
    pub film: FilmLayout,
    replacement: Option<Replacement>,
    made: Mutex<HashMap<Variant, Arc<wgpu::ComputePipeline>>>,
}

impl Pipelines {
    pub fn new(gpu: &GpuDevice, replacement: Option<Replacement>) -> Self {
        let (scene, film) = (SceneLayout::new(&gpu.device), FilmLayout::new(&gpu.device));
        Self { scene, film, replacement, made: Mutex::default() }
    }

    /// The text of a shader with the replacement made.
    ///
    /// # Errors
    /// When what is to be replaced is not in it, or not only once.
    pub fn replaced(&self, source: String) -> Result<String, GpuFault> {
        match self.replacement {
            Some(replacement) => replacement.apply(&source),
            None => Ok(source),
        }
    }

    /// The pipeline of a variant if it has been compiled.
    pub fn ready(&self, variant: &Variant) -> Option<Arc<wgpu::ComputePipeline>> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner).get(variant).cloned()
    }

    /// The pipeline of a variant. Compiling takes from a tenth of a second to seconds.
    ///
    /// # Errors
    /// When the driver refuses it.
    pub fn get(&self, gpu: &GpuDevice, variant: &Variant) -> Result<Arc<wgpu::ComputePipeline>, GpuFault> {
        if let Some(pipeline) = self.ready(variant) {
            return Ok(pipeline);
        }
        let source = self.replaced(variant.source())?;
        let start = std::time::Instant::now();
        let pipeline = gpu.attempt(|device| {
            let layouts = [Some(&self.scene.0), Some(&self.film.0)];
            compile(device, &source, "render", &variant.constants(), &layouts)
        })?;
        log::debug!("compiled {variant:?} in {:.2} s", start.elapsed().as_secs_f64());
        let pipeline = Arc::new(pipeline);
        self.made.lock().unwrap_or_else(PoisonError::into_inner).insert(*variant, Arc::clone(&pipeline));
        Ok(pipeline)
    }
}

/// Compiles the entry point `entry` of a shader.
pub fn compile(
    device: &wgpu::Device,
    source: &str,
    entry: &str,
    constants: &[(&str, f64)],
    layouts: &[Option<&wgpu::BindGroupLayout>],
) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry),
        bind_group_layouts: layouts,
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}
