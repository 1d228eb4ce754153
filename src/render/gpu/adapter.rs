//! The graphics processors of this machine, and which of them is used.

use super::fault::one_line;

/// Storage buffers that one shader must be able to use.
const LEAST_STORAGE_BUFFERS: u32 = super::pipeline::STORAGE_BUFFERS;
/// Invocations that one workgroup must be able to have.
const LEAST_INVOCATIONS: u32 = 64;

/// What a graphics processor is called, and by what it is reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Adapter {
    /// As the driver calls it, such as `NVIDIA GeForce RTX 4070`.
    pub name: String,
    /// The interface it is reached by, such as `Vulkan`.
    pub api: &'static str,
    /// Name and version of the driver; may be empty.
    pub driver: String,
    /// Whether it is a program that computes on the CPU, such as Mesa's lavapipe.
    pub is_software: bool,
}

impl Adapter {
    pub(super) fn of(info: &wgpu::AdapterInfo) -> Self {
        Self {
            name: one_line(&info.name),
            api: match info.backend {
                wgpu::Backend::Vulkan => "Vulkan",
                wgpu::Backend::Metal => "Metal",
                wgpu::Backend::Dx12 => "Direct3D 12",
                wgpu::Backend::Gl => "OpenGL",
                wgpu::Backend::BrowserWebGpu => "WebGPU",
                wgpu::Backend::Noop => "no interface",
            },
            driver: one_line(&format!("{} {}", info.driver, info.driver_info)),
            is_software: info.device_type == wgpu::DeviceType::Cpu,
        }
    }

    /// Name and interface, as outputs and reports say it.
    pub fn label(&self) -> String {
        let software = if self.is_software { ", in software" } else { "" };
        format!("{} ({}{software})", self.name, self.api)
    }
}

/// Why there is no graphics processor to compute with, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    #[error(
        "no graphics processor was found{}; install its Vulkan driver (on Debian mesa-vulkan-drivers or nvidia-driver), or use the CPU",
        within(sought)
    )]
    NoAdapter {
        /// What the environment restricts the search to; empty: nothing.
        sought: String,
    },
    #[error(
        "{adapter} cannot compute: {missing}; update its driver, set WGPU_BACKEND to another interface, or use the CPU"
    )]
    NoCompute { adapter: String, missing: String },
    #[error("{adapter} cannot be opened ({reason}); update its driver or use the CPU")]
    NoDevice { adapter: String, reason: String },
}

fn within(sought: &str) -> String {
    if sought.is_empty() { String::new() } else { format!(" by {sought}") }
}

/// The best graphics processor of this machine that can compute: real hardware before software, of several the fastest kind. WGPU_BACKEND
/// restricts the search to interfaces, WGPU_ADAPTER_NAME to those whose name contains it.
///
/// # Errors
/// When there is none.
pub(super) fn choose() -> Result<wgpu::Adapter, GpuError> {
    let from_environment = wgpu::Backends::from_env();
    // OpenGL last: its compute shaders have narrower limits, and looking for it is slow where there is no screen.
    let interfaces = match from_environment {
        Some(asked) => vec![asked],
        None => vec![wgpu::Backends::PRIMARY, wgpu::Backends::GL],
    };
    let name = std::env::var("WGPU_ADAPTER_NAME").unwrap_or_default().to_lowercase();
    let mut refused = None;
    for backends in interfaces {
        let descriptor =
            wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle_from_env() };
        let instance = wgpu::Instance::new(descriptor);
        let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
        adapters.retain(|adapter| adapter.get_info().name.to_lowercase().contains(&name));
        adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
        for adapter in adapters {
            match missing(&adapter) {
                None => return Ok(adapter),
                Some(missing) => {
                    let adapter = Adapter::of(&adapter.get_info()).label();
                    log::info!("{adapter} cannot compute: {missing}");
                    refused.get_or_insert(GpuError::NoCompute { adapter, missing });
                }
            }
        }
    }
    let words = [("WGPU_BACKEND", from_environment.is_some()), ("WGPU_ADAPTER_NAME", !name.is_empty())];
    let value = |name: &str| format!("{name}={}", one_line(&std::env::var(name).unwrap_or_default()));
    let sought = words.iter().filter(|(_, is_set)| *is_set).map(|(name, _)| value(name)).collect::<Vec<_>>();
    Err(refused.unwrap_or_else(|| GpuError::NoAdapter { sought: sought.join(" and ") }))
}

/// The lower the better.
fn rank(kind: wgpu::DeviceType) -> u32 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::VirtualGpu => 1,
        wgpu::DeviceType::IntegratedGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// What an adapter lacks to run compute shaders; `None`: nothing.
fn missing(adapter: &wgpu::Adapter) -> Option<String> {
    lacks(adapter.get_downlevel_capabilities().flags, &adapter.limits())
}

fn lacks(flags: wgpu::DownlevelFlags, limits: &wgpu::Limits) -> Option<String> {
    // OpenGL 3.3 promises limits that it does not keep, and loses the device at once; it has no indirect execution.
    if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS | wgpu::DownlevelFlags::INDIRECT_EXECUTION) {
        return Some("it has no compute shaders".into());
    }
    let (buffers, invocations) =
        (limits.max_storage_buffers_per_shader_stage, limits.max_compute_invocations_per_workgroup);
    if buffers < LEAST_STORAGE_BUFFERS {
        return Some(format!("a shader can use {buffers} buffers, and {LEAST_STORAGE_BUFFERS} are needed"));
    }
    if invocations < LEAST_INVOCATIONS {
        return Some(format!("a workgroup has at most {invocations} threads, and {LEAST_INVOCATIONS} are needed"));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_adapter_lacks_is_told() {
        let all = wgpu::DownlevelFlags::all();
        let limits = wgpu::Limits { max_storage_buffers_per_shader_stage: 64, ..wgpu::Limits::default() };
        assert_eq!(lacks(all, &limits), None);
        let none = |flags| lacks(flags, &limits).unwrap();
        assert!(none(all - wgpu::DownlevelFlags::COMPUTE_SHADERS).contains("no compute"));
        assert!(none(all - wgpu::DownlevelFlags::INDIRECT_EXECUTION).contains("no compute"));
        let few = wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..limits.clone() };
        assert!(lacks(all, &few).unwrap().contains("4 buffers"));
        let narrow = wgpu::Limits { max_compute_invocations_per_workgroup: 32, ..limits };
        assert!(lacks(all, &narrow).unwrap().contains("32 threads"));
    }

    #[test]
    fn errors_say_what_to_do() {
        let none = GpuError::NoAdapter { sought: String::new() }.to_string();
        assert!(none.contains("was found; install") && none.contains("use the CPU"), "{none}");
        let sought = GpuError::NoAdapter { sought: "WGPU_BACKEND=gl".into() }.to_string();
        assert!(sought.contains("found by WGPU_BACKEND=gl; install"), "{sought}");
    }

    #[test]
    fn software_comes_last() {
        use wgpu::DeviceType as D;
        let mut kinds = [D::Cpu, D::Other, D::IntegratedGpu, D::DiscreteGpu, D::VirtualGpu];
        kinds.sort_by_key(|kind| rank(*kind));
        assert_eq!((kinds[0], kinds[4]), (D::DiscreteGpu, D::Cpu));
    }
}
