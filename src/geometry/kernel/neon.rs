//! NEON: boxes by fours, triangles by twos.
//!
//! Inlined like the other kernels, into a copy of the search compiled for these registers.

#![allow(unsafe_code)]

use std::arch::aarch64::*;

use super::Kernel;
use crate::geometry::bvh::{Node, WIDTH};
use crate::geometry::triangle::{PACK, PackTest, ShearedRay, TrianglePack};
use crate::geometry::walk::{BoxRay, NOTHING, Stack, entry};

/// To be used only from code compiled for `neon`, on a processor that has it.
pub struct Neon;

impl Kernel for Neon {
    #[inline(always)]
    fn open(node: &Node, ray: &BoxRay, far_limit: f32, stack: &mut Stack) -> u64 {
        let mut near = [0.0; WIDTH];
        let mut met =
            open_four::<0>(node, ray, far_limit, &mut near) | open_four::<4>(node, ray, far_limit, &mut near) << 4;
        let mut nearest = NOTHING;
        while met != 0 {
            let lane = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            let child = entry(near[lane], node.children[lane]);
            if nearest != NOTHING {
                stack.push(nearest.max(child));
            }
            nearest = nearest.min(child);
        }
        nearest
    }

    #[inline(always)]
    fn meet_triangles(ray: &ShearedRay, pack: &TrianglePack, t_min: f64, t_max: f64, test: &mut PackTest) -> u32 {
        meet_two::<0>(ray, pack, t_min, t_max, test)
            | meet_two::<2>(ray, pack, t_min, t_max, test)
            | meet_two::<4>(ray, pack, t_min, t_max, test)
            | meet_two::<6>(ray, pack, t_min, t_max, test)
    }
}

/// Entry distances of the four children from `FIRST` (0 or 4) on, and a bit for each that is met.
#[inline(always)]
fn open_four<const FIRST: usize>(node: &Node, ray: &BoxRay, far_limit: f32, distances: &mut [f32; WIDTH]) -> u32 {
    const { assert!(FIRST + 4 <= WIDTH) };
    // SAFETY: this kernel is chosen only where the feature was detected. Four numbers follow `FIRST` in arrays of eight.
    unsafe {
        let mut near = vdupq_n_f32(ray.near_limit);
        let mut far = vdupq_n_f32(far_limit);
        for axis in 0..3 {
            let inverse = vdupq_n_f32(ray.inverse[axis]);
            let (near_offset, far_offset) = (vdupq_n_f32(ray.near_offset[axis]), vdupq_n_f32(ray.far_offset[axis]));
            let row = ray.near_sides[axis] as usize / WIDTH;
            near = vmaxq_f32(near, vfmaq_f32(near_offset, vld1q_f32(node.rows[row].as_ptr().add(FIRST)), inverse));
            far = vminq_f32(far, vfmaq_f32(far_offset, vld1q_f32(node.rows[row ^ 1].as_ptr().add(FIRST)), inverse));
        }

        vst1q_f32(distances.as_mut_ptr().add(FIRST), near);
        vaddvq_u32(vandq_u32(vcleq_f32(near, far), vld1q_u32([1, 2, 4, 8].as_ptr())))
    }
}

/// Bits of the two lanes from `FIRST` (even) on.
#[inline(always)]
fn meet_two<const FIRST: usize>(
    ray: &ShearedRay,
    pack: &TrianglePack,
    t_min: f64,
    t_max: f64,
    test: &mut PackTest,
) -> u32 {
    const { assert!(FIRST + 2 <= PACK) };
    let [kx, ky, kz] = ray.axes;
    // SAFETY: as above; two numbers follow `FIRST` in arrays of eight.
    unsafe {
        let [ox, oy, oz] = ray.origin;
        let [sx, sy, sz] = ray.shear;
        let mut x = [vdupq_n_f64(0.0); 3];
        let mut y = x;
        let mut depths = x;
        for index in 0..3 {
            let corner = &pack.corners[index];
            let depth = relative::<FIRST>(&corner[kz], oz);
            x[index] = vsubq_f64(relative::<FIRST>(&corner[kx], ox), vmulq_f64(vdupq_n_f64(sx), depth));
            y[index] = vsubq_f64(relative::<FIRST>(&corner[ky], oy), vmulq_f64(vdupq_n_f64(sy), depth));
            depths[index] = depth;
        }
        let u = vsubq_f64(vmulq_f64(x[2], y[1]), vmulq_f64(y[2], x[1]));
        let v = vsubq_f64(vmulq_f64(x[0], y[2]), vmulq_f64(y[0], x[2]));
        let w = vsubq_f64(vmulq_f64(x[1], y[0]), vmulq_f64(y[1], x[0]));
        // All of one sign, zero included.
        let lowest = vminq_f64(vminq_f64(u, v), w);
        let highest = vmaxq_f64(vmaxq_f64(u, v), w);
        let is_met = vorrq_u64(vcgezq_f64(lowest), vclezq_f64(highest));
        if vaddvq_u64(vandq_u64(is_met, vdupq_n_u64(1))) == 0 {
            return 0;
        }
        let sz = vdupq_n_f64(sz);
        let determinant = vaddq_f64(vaddq_f64(u, v), w);
        let mut sum = vmulq_f64(u, vmulq_f64(sz, depths[0]));
        sum = vaddq_f64(sum, vmulq_f64(v, vmulq_f64(sz, depths[1])));
        sum = vaddq_f64(sum, vmulq_f64(w, vmulq_f64(sz, depths[2])));
        let t = vdivq_f64(sum, determinant);
        let is_near_enough = vandq_u64(vcgeq_f64(t, vdupq_n_f64(t_min)), vcleq_f64(t, vdupq_n_f64(t_max)));
        let is_edge_on = vceqzq_f64(determinant);
        let is_met = vbicq_u64(vandq_u64(is_met, is_near_enough), is_edge_on);
        vst1q_f64(test.edges[0].as_mut_ptr().add(FIRST), u);
        vst1q_f64(test.edges[1].as_mut_ptr().add(FIRST), v);
        vst1q_f64(test.edges[2].as_mut_ptr().add(FIRST), w);
        vst1q_f64(test.determinants.as_mut_ptr().add(FIRST), determinant);
        vst1q_f64(test.distances.as_mut_ptr().add(FIRST), t);
        (vaddvq_u64(vandq_u64(is_met, vld1q_u64([1, 2].as_ptr()))) as u32) << FIRST
    }
}

/// Two numbers in f64, from `FIRST` on, less `origin`.
#[inline(always)]
fn relative<const FIRST: usize>(numbers: &[f32; PACK], origin: f64) -> float64x2_t {
    const { assert!(FIRST + 2 <= PACK) };
    // SAFETY: called by this kernel, whose feature was detected.
    unsafe { vsubq_f64(vcvt_f64_f32(vld1_f32(numbers.as_ptr().add(FIRST))), vdupq_n_f64(origin)) }
}
