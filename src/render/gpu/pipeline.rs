//! Compiled shaders, kept for as long as the device is.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::device::GpuDevice;
use super::fault::GpuFault;
use super::shader::Variant;

/// Buffers of group 0 that are uniform, and those after them that the shaders read.
const UNIFORM_BUFFERS: u32 = 2;
const READ_BUFFERS: u32 = 12;
/// Those of group 1.
const FILM_BUFFERS: u32 = 6;
/// Storage buffers of both groups.
pub const STORAGE_BUFFERS: u32 = READ_BUFFERS + FILM_BUFFERS;

/// Whether what is uniform is given to shaders as such. Mesa's llvmpipe makes constants of the uniform words that branches depend on and goes through
/// the whole shader again whenever they are bound, which was measured to take 15 ms for each dispatch: there they are storage like the rest.
fn has_uniforms(gpu: &GpuDevice) -> bool {
    !gpu.adapter.is_software
}

/// How a buffer is used that is uniform where [`has_uniforms`].
pub fn uniform_usage(gpu: &GpuDevice) -> wgpu::BufferUsages {
    if has_uniforms(gpu) { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE }
}

/// The bindings of group 0: `render/gpu/scene.wgsl`.
#[derive(Debug)]
pub struct SceneLayout(pub wgpu::BindGroupLayout);

impl SceneLayout {
    pub fn new(gpu: &GpuDevice) -> Self {
        let read = wgpu::BufferBindingType::Storage { read_only: true };
        let uniform = if has_uniforms(gpu) { wgpu::BufferBindingType::Uniform } else { read };
        let entries: Vec<_> = (0..UNIFORM_BUFFERS + READ_BUFFERS)
            .map(|i| entry(i, if i < UNIFORM_BUFFERS { uniform } else { read }))
            .collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some("scene"), entries: &entries };
        Self(gpu.device.create_bind_group_layout(&descriptor))
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
            entries: &(0..FILM_BUFFERS).map(|binding| storage(binding, binding == 2)).collect::<Vec<_>>(),
        }))
    }

    pub fn bind<'a>(&self, device: &wgpu::Device, buffers: impl Iterator<Item = &'a wgpu::Buffer>) -> wgpu::BindGroup {
        bind(device, &self.0, buffers)
    }
}

pub(super) fn entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

pub(super) fn bind<'a>(
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
    has_uniforms: bool,
    replacement: Option<Replacement>,
    made: Mutex<HashMap<Variant, Arc<wgpu::ComputePipeline>>>,
}

impl Pipelines {
    pub fn new(gpu: &GpuDevice, replacement: Option<Replacement>) -> Self {
        let (scene, film) = (SceneLayout::new(gpu), FilmLayout::new(&gpu.device));
        Self { scene, film, has_uniforms: has_uniforms(gpu), replacement, made: Mutex::default() }
    }

    /// The text of a shader as this device gets it, with the replacement made.
    ///
    /// # Errors
    /// When what is to be replaced is not in it, or not only once.
    pub fn text(&self, source: String) -> Result<String, GpuFault> {
        let source = if self.has_uniforms { source } else { source.replace("var<uniform>", "var<storage, read>") };
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
        let source = self.text(variant.source())?;
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
