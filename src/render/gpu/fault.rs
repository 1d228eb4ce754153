//! What can go wrong with a device while it works, kept until somebody asks.

use std::sync::{Arc, Mutex, PoisonError};

/// What went wrong on a device.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuFault {
    /// It does nothing any more: the driver has reset it, it was unplugged, or taken away.
    #[error("the graphics processor was lost ({0})")]
    Lost(String),
    #[error("the graphics processor has run out of memory")]
    OutOfMemory,
    /// A shader or a command that the driver does not take.
    #[error("the graphics driver refused a command ({0})")]
    Refused(String),
}

impl From<wgpu::Error> for GpuFault {
    fn from(error: wgpu::Error) -> Self {
        match error {
            wgpu::Error::OutOfMemory { .. } => Self::OutOfMemory,
            // The first line says what, the rest in which of wgpu's calls.
            error => Self::Refused(one_line(&error.to_string())),
        }
    }
}

/// The first fault of a device, shared with the functions that the driver calls.
#[derive(Debug, Clone, Default)]
pub(super) struct Faults(Arc<Mutex<Option<GpuFault>>>);

impl Faults {
    /// Takes note of what the driver tells from now on.
    pub(super) fn listen(&self, device: &wgpu::Device) {
        let heard = self.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| heard.note(error.into())));
        let heard = self.clone();
        device.set_device_lost_callback(move |reason, message| {
            let why = match reason {
                wgpu::DeviceLostReason::Destroyed => "it was taken away".to_owned(),
                wgpu::DeviceLostReason::Unknown => one_line(&message),
            };
            heard.note(GpuFault::Lost(why));
        });
    }

    /// A loss outweighs what was noted before; else the first fault is the cause of those that follow.
    pub(super) fn note(&self, fault: GpuFault) {
        log::warn!("{fault}");
        let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_worse = matches!(fault, GpuFault::Lost(_)) && !matches!(*first, Some(GpuFault::Lost(_)));
        if first.is_none() || is_worse {
            *first = Some(fault);
        }
    }

    pub(super) fn first(&self) -> Option<GpuFault> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// The lines of a message in one, without what only indents them.
pub(super) fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fault_is_kept_unless_the_device_is_lost() {
        let faults = Faults::default();
        assert_eq!(faults.first(), None);
        faults.note(GpuFault::OutOfMemory);
        faults.note(GpuFault::Refused("a buffer without memory".into()));
        assert_eq!(faults.first(), Some(GpuFault::OutOfMemory));
        faults.note(GpuFault::Lost("reset".into()));
        faults.note(GpuFault::Lost("again".into()));
        faults.note(GpuFault::OutOfMemory);
        assert_eq!(faults.first(), Some(GpuFault::Lost("reset".into())));
    }
}
