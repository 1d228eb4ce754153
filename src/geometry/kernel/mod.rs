//! The two steps that rays spend their time in, for whichever registers the processor has: opening a node (eight boxes) and testing a
//! pack (eight triangles).
//!
//! The triangle test gives the same bits with every kernel: no multiplication is fused with an addition anywhere. Boxes may be met by one
//! kernel and not by another, within the margins that `bvh` and `walk` prove wide enough; the hits are the same.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
#[cfg(test)]
mod tests;

#[cfg(target_arch = "x86_64")]
use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
use avx512::Avx512;
#[cfg(target_arch = "aarch64")]
use neon::Neon;
pub(super) use portable::Portable;

use super::bvh::Node;
use super::triangle::{PackTest, ShearedRay, TrianglePack};
use super::walk::{BoxRay, Stack, entry};

/// An implementation of both steps.
pub(super) trait Kernel {
    /// Which children's boxes `ray` meets, up to `far_limit` (≥ 0): puts all but the nearest on the stack, in no particular order, and
    /// returns the nearest; [`super::walk::NOTHING`] or more if none is met. Errs only towards meeting a box. The stack has room for eight more.
    fn open(node: &Node, ray: &BoxRay, far_limit: f32, stack: &mut Stack) -> u64;

    /// Asks for the 320 bytes from `start` on to be brought near, whether or not they exist.
    fn fetch(_start: *const u8) {}

    /// The uppermost entry on the stack that is not farther than `far_limit`, and the stack's length without it and those above it.
    #[inline(always)]
    fn top(stack: &Stack, far_limit: f32) -> (u64, usize) {
        let farthest = entry(far_limit, u32::MAX);
        let mut length = stack.length - 1;
        while stack.fixed[length] > farthest {
            length -= 1;
        }
        (stack.fixed[length], length)
    }

    /// A bit for each triangle whose interior, edges or corners the ray's line meets at a distance from `t_min` to `t_max`; fills in `test`
    /// where there is any. Triangles that are points or seen edge-on are met nowhere.
    fn meet_triangles(ray: &ShearedRay, pack: &TrianglePack, t_min: f64, t_max: f64, test: &mut PackTest) -> u32;
}

/// Work that is compiled once for each kernel. Implementations are `#[inline(always)]`, and so is all on the way from them to a kernel's methods.
/// Functions and closures that are not are compiled for any processor, and would call each vector instruction as a function: no closure calls a kernel.
pub(super) trait Task {
    fn run<K: Kernel>(self);
}

/// A quotient that is at least t is not less than t·`SHORTER` before it is rounded, and one that is at most t no more than t·`LONGER`, rounding of
/// the products included.
#[cfg(target_arch = "x86_64")]
const SHORTER: f64 = 1.0 - 4.0 * f64::EPSILON;
#[cfg(target_arch = "x86_64")]
const LONGER: f64 = 1.0 + 4.0 * f64::EPSILON;

/// Which kernel to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KernelChoice {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
}

impl KernelChoice {
    /// All that this processor can run, the fastest last.
    pub fn available() -> Vec<Self> {
        let mut all = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            if has!("avx2") && has!("fma") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt") {
                all.push(Self::Avx2);
                if has!("avx512f") && has!("avx512vl") && has!("avx512dq") {
                    all.push(Self::Avx512);
                }
            }
        }
        #[cfg(target_arch = "aarch64")]
        if std::arch::is_aarch64_feature_detected!("neon") {
            all.push(Self::Neon);
        }
        all
    }

    /// The fastest that this processor can run.
    pub(super) fn best() -> Self {
        Self::available().last().copied().unwrap_or(Self::Portable)
    }

    /// Does `task` with this kernel, which is one of those [`Self::available`].
    #[inline]
    #[allow(unsafe_code)]
    pub(super) fn run(self, task: impl Task) {
        match self {
            Self::Portable => task.run::<Portable>(),
            // SAFETY: the processor has the features that this copy of the code is compiled for, or it would not be available.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { run_avx2(task) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { run_avx512(task) },
            // SAFETY: as above.
            #[cfg(target_arch = "aarch64")]
            Self::Neon => unsafe { run_neon(task) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2(task: impl Task) {
    task.run::<Avx2>();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx512(task: impl Task) {
    task.run::<Avx512>();
}

#[cfg(target_arch = "aarch64")]
#[target_feature(enable = "neon")]
fn run_neon(task: impl Task) {
    task.run::<Neon>();
}
