//! AVX-512 (F, VL, DQ): eight boxes at once in f32, eight triangles at once in f64.
//!
//! Inlined like [`super::avx2`].

#![allow(unsafe_code)]

use std::arch::x86_64::*;
use std::mem::transmute;

use super::avx2::{Avx2, distances};
use super::{Kernel, LONGER, SHORTER};
use crate::geometry::bvh::{Node, WIDTH};
use crate::geometry::triangle::{PACK, PackTest, ShearedRay, TrianglePack};
use crate::geometry::walk::{BoxRay, Stack, entry};

/// To be used only from code compiled for `avx512f,avx512vl,avx512dq,avx2,fma`, on a processor that has them.
pub struct Avx512;

impl Kernel for Avx512 {
    #[inline(always)]
    fn open(node: &Node, ray: &BoxRay, far_limit: f32, stack: &mut Stack) -> u64 {
        // SAFETY: this kernel is chosen only where the features were detected. Registers and arrays that are turned into each other are as long
        // as each other.
        unsafe {
            let [near, far] = distances(node, ray, far_limit);
            // Each child with its distance above it, all in one register; the distances of those not met are all ones.
            let is_missed = _mm256_cmp_ps::<_CMP_NLE_UQ>(near, far);
            let distances = _mm256_castps_si256(_mm256_or_ps(near, is_missed));
            let entries = _mm512_permutex2var_epi32(
                _mm512_castsi256_si512(transmute::<[u32; WIDTH], __m256i>(node.children)),
                _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23),
                _mm512_castsi256_si512(distances),
            );
            let four = _mm256_min_epu64(_mm512_castsi512_si256(entries), _mm512_extracti64x4_epi64::<1>(entries));
            let two = _mm_min_epu64(_mm256_castsi256_si128(four), _mm256_extracti128_si256::<1>(four));
            let nearest = _mm_min_epu64(two, _mm_unpackhi_epi64(two, two));
            let others = _mm512_cmpneq_epu64_mask(entries, _mm512_broadcastq_epi64(nearest))
                & !(_mm256_movemask_ps(is_missed) as u8);
            let others_first = _mm512_maskz_compress_epi64(others, entries);
            stack.push_many(transmute::<__m512i, [u64; WIDTH]>(others_first), u32::from(others).count_ones());
            _mm_cvtsi128_si64(nearest) as u64
        }
    }

    #[inline(always)]
    fn fetch(start: *const u8) {
        Avx2::fetch(start);
    }

    #[inline(always)]
    fn top(stack: &Stack, far_limit: f32) -> (u64, usize) {
        let farthest = entry(far_limit, u32::MAX);
        let mut length = stack.length;
        loop {
            // SAFETY: the features were detected, and the array is as long as the register.
            let near_enough = unsafe {
                let entries = _mm512_loadu_epi64(stack.eight_below(length).as_ptr().cast());
                u32::from(_mm512_cmple_epu64_mask(entries, _mm512_set1_epi64(farthest as i64)))
            };
            if near_enough != 0 {
                // The last of the eight is number 0 of the leading zeros of 8 bits, that is 24 of 32.
                length = length + 23 - near_enough.leading_zeros() as usize;
                return (stack.fixed[length], length);
            }
            length -= WIDTH;
        }
    }

    #[inline(always)]
    fn meet_triangles(ray: &ShearedRay, pack: &TrianglePack, t_min: f64, t_max: f64, test: &mut PackTest) -> u32 {
        let [kx, ky, kz] = ray.axes;
        // SAFETY: as above.
        unsafe {
            let [ox, oy, oz] = in_all_lanes(ray.origin);
            let [sx, sy, sz] = in_all_lanes(ray.shear);
            let mut x = [_mm512_setzero_pd(); 3];
            let mut y = x;
            let mut depths = x;
            for index in 0..3 {
                let corner = &pack.corners[index];
                let depth = _mm512_sub_pd(widened(&corner[kz]), oz);
                x[index] = _mm512_sub_pd(_mm512_sub_pd(widened(&corner[kx]), ox), _mm512_mul_pd(sx, depth));
                y[index] = _mm512_sub_pd(_mm512_sub_pd(widened(&corner[ky]), oy), _mm512_mul_pd(sy, depth));
                depths[index] = depth;
            }
            let u = _mm512_sub_pd(_mm512_mul_pd(x[2], y[1]), _mm512_mul_pd(y[2], x[1]));
            let v = _mm512_sub_pd(_mm512_mul_pd(x[0], y[2]), _mm512_mul_pd(y[0], x[2]));
            let w = _mm512_sub_pd(_mm512_mul_pd(x[1], y[0]), _mm512_mul_pd(y[1], x[0]));
            // All of one sign, zero included. Where one is NaN the distance is too, and is refused below.
            let zero = _mm512_setzero_pd();
            let lowest = _mm512_min_pd(_mm512_min_pd(u, v), w);
            let highest = _mm512_max_pd(_mm512_max_pd(u, v), w);
            let met = _mm512_cmp_pd_mask::<_CMP_GE_OQ>(lowest, zero) | _mm512_cmp_pd_mask::<_CMP_LE_OQ>(highest, zero);
            let determinant = _mm512_add_pd(_mm512_add_pd(u, v), w);
            let mut sum = _mm512_mul_pd(u, _mm512_mul_pd(sz, depths[0]));
            sum = _mm512_add_pd(sum, _mm512_mul_pd(v, _mm512_mul_pd(sz, depths[1])));
            sum = _mm512_add_pd(sum, _mm512_mul_pd(w, _mm512_mul_pd(sz, depths[2])));
            // First without the division, erring towards meeting: it is seldom needed then.
            let size = _mm512_abs_pd(determinant);
            let sign = _mm512_and_pd(determinant, _mm512_set1_pd(-0.0));
            let signed_sum = _mm512_xor_pd(sum, sign);
            let met =
                _mm512_mask_cmp_pd_mask::<_CMP_GE_OQ>(
                    met,
                    signed_sum,
                    _mm512_mul_pd(size, _mm512_set1_pd(t_min * SHORTER)),
                ) & _mm512_cmp_pd_mask::<_CMP_LE_OQ>(signed_sum, _mm512_mul_pd(size, _mm512_set1_pd(t_max * LONGER)));
            if met == 0 {
                return 0;
            }
            let t = _mm512_div_pd(sum, determinant);
            let met = _mm512_mask_cmp_pd_mask::<_CMP_GE_OQ>(met, t, _mm512_set1_pd(t_min))
                & _mm512_cmp_pd_mask::<_CMP_LE_OQ>(t, _mm512_set1_pd(t_max))
                & _mm512_cmp_pd_mask::<_CMP_NEQ_OQ>(determinant, zero);
            test.edges = transmute::<[__m512d; 3], [[f64; PACK]; 3]>([u, v, w]);
            test.determinants = transmute::<__m512d, [f64; PACK]>(determinant);
            test.distances = transmute::<__m512d, [f64; PACK]>(t);
            u32::from(met)
        }
    }
}

/// Each number in all lanes of a register.
#[inline(always)]
fn in_all_lanes([x, y, z]: [f64; 3]) -> [__m512d; 3] {
    // SAFETY: called by this kernel, whose features were detected.
    unsafe { [_mm512_set1_pd(x), _mm512_set1_pd(y), _mm512_set1_pd(z)] }
}

/// Eight numbers in f64.
#[inline(always)]
fn widened(numbers: &[f32; PACK]) -> __m512d {
    // SAFETY: called by this kernel, whose features were detected.
    unsafe { _mm512_cvtps_pd(transmute::<[f32; PACK], __m256>(*numbers)) }
}
