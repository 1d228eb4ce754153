//! Rendering by the graphics processor, in compute shaders.

pub mod adapter;
pub mod device;
mod dispatch;
pub mod fault;
mod layout;
pub mod limits;
mod pace;
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
pub use limits::Limits;
pub use pace::Tally;
pub use pipeline::Replacement;
pub use renderer::Gpu;
pub use shared::SharedGpu;
