//! Rendering by the graphics processor, in compute shaders.

pub mod adapter;
pub mod device;
pub mod fault;

pub use adapter::{Adapter, GpuError};
pub use device::GpuDevice;
pub use fault::GpuFault;
