//! Rendering by the graphics processor, in compute shaders.

pub mod adapter;
pub mod device;
mod dispatch;
pub mod fault;
mod layout;
mod pipeline;
pub mod probe;
pub mod renderer;
mod shader;
pub mod shared;
mod tables;
mod upload;

pub use adapter::{Adapter, GpuError};
pub use device::GpuDevice;
pub use fault::GpuFault;
pub use pipeline::Replacement;
pub use renderer::Gpu;
pub use shared::SharedGpu;
