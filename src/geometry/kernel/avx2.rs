//! AVX2 and FMA: eight boxes at once, triangles by fours.
//!
//! All of it is inlined, without features of its own, into the copies of the search that are compiled for these registers: a function
//! apart would have its arguments passed through memory.

#![allow(unsafe_code)]

use std::arch::x86_64::*;
use std::mem::transmute;

use super::Kernel;
use crate::geometry::bvh::{Node, WIDTH};
use crate::geometry::triangle::{PACK, PackTest, ShearedRay, TrianglePack};
use crate::geometry::walk::{BoxRay, NOTHING, Stack};

/// To be used only from code compiled for `avx2,fma`, on a processor that has them.
pub struct Avx2;

impl Kernel for Avx2 {
    #[inline(always)]
    fn open(node: &Node, ray: &BoxRay, far_limit: f32, stack: &mut Stack) -> u64 {
        // SAFETY: this kernel is chosen only where the features were detected. Registers and arrays that are turned into each other are as long
        // as each other; `members` has the eight bytes that are loaded from it.
        unsafe {
            let [near, far] = distances(node, ray, far_limit);
            let is_met = _mm256_cmp_ps::<_CMP_LE_OQ>(near, far);
            let met = _mm256_movemask_ps(is_met) as u32;

            // The nearest is the smallest of the numbers made of a distance's bits and, in place of the lowest three, its lane. Distances are ≥ 0, and
            // one that loses its last bits is a little too short, which harms nothing.
            let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let keys = _mm256_or_si256(_mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(near)), lanes);
            let keys = _mm256_or_si256(keys, _mm256_andnot_si256(_mm256_castps_si256(is_met), _mm256_set1_epi32(-1)));
            let four = _mm_min_epu32(_mm256_castsi256_si128(keys), _mm256_extracti128_si256::<1>(keys));
            let two = _mm_min_epu32(four, _mm_shuffle_epi32::<0b01_00_11_10>(four));
            let smallest = _mm_cvtsi128_si32(_mm_min_epu32(two, _mm_shuffle_epi32::<0b10_11_00_01>(two))) as u32;
            let lane = (smallest & 7) as usize;

            // The others, each beside its distance.
            let others = met & !(1 << lane);
            let members = &MEMBERS[others as usize];
            let members = _mm256_cvtepu8_epi32(_mm_loadl_epi64(members.as_ptr().cast()));
            let children = _mm256_permutevar8x32_epi32(transmute::<[u32; WIDTH], __m256i>(node.children), members);
            let near = _mm256_castps_si256(_mm256_permutevar8x32_ps(near, members));
            let (low, high) = (_mm256_unpacklo_epi32(children, near), _mm256_unpackhi_epi32(children, near));
            let entries = [_mm256_permute2x128_si256::<0x20>(low, high), _mm256_permute2x128_si256::<0x31>(low, high)];
            stack.push_many(transmute::<[__m256i; 2], [u64; WIDTH]>(entries), others.count_ones());
            if met == 0 { NOTHING } else { u64::from(smallest & !7) << 32 | u64::from(node.children[lane]) }
        }
    }

    #[inline(always)]
    fn fetch(start: *const u8) {
        for line in 0..5 {
            // SAFETY: nothing is read; addresses may be any.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64 * line).cast()) };
        }
    }

    #[inline(always)]
    fn meet_triangles(ray: &ShearedRay, pack: &TrianglePack, t_min: f64, t_max: f64, test: &mut PackTest) -> u32 {
        let first = meet_four::<0>(ray, pack, t_min, t_max, test);
        first | meet_four::<4>(ray, pack, t_min, t_max, test) << 4
    }
}

/// For each set of lanes its members, in order, then zeros.
static MEMBERS: [[u8; WIDTH]; 256] = {
    let mut members = [[0; WIDTH]; 256];
    let mut set = 0;
    while set < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < WIDTH {
            if set >> lane & 1 == 1 {
                members[set][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    members
};

/// Distances to where the ray has entered the children's boxes along all axes, and to where it leaves them along any, within the limits.
#[inline(always)]
pub(super) fn distances(node: &Node, ray: &BoxRay, far_limit: f32) -> [__m256; 2] {
    // SAFETY: called by kernels whose features were detected, AVX2 and FMA among them. Each side is the beginning of one of the six rows, and so
    // is the one with its lowest bit turned; a node is aligned to a multiple of the register's length.
    unsafe {
        let mut near = [_mm256_setzero_ps(); 3];
        let mut far = near;
        let rows = node.rows.as_ptr().cast::<f32>();
        for axis in 0..3 {
            let inverse = _mm256_set1_ps(ray.inverse[axis]);
            let (near_offset, far_offset) =
                (_mm256_set1_ps(ray.near_offset[axis]), _mm256_set1_ps(ray.far_offset[axis]));
            let near_side = ray.near_sides[axis] as usize;
            near[axis] = _mm256_fmadd_ps(_mm256_load_ps(rows.add(near_side)), inverse, near_offset);
            far[axis] = _mm256_fmadd_ps(_mm256_load_ps(rows.add(near_side ^ WIDTH)), inverse, far_offset);
        }
        let far = _mm256_min_ps(_mm256_min_ps(far[0], far[1]), _mm256_min_ps(far[2], _mm256_set1_ps(far_limit)));
        let near =
            _mm256_max_ps(_mm256_max_ps(near[0], near[1]), _mm256_max_ps(near[2], _mm256_set1_ps(ray.near_limit)));
        [near, far]
    }
}

/// The four lanes from `FIRST` (0 or 4) on.
#[inline(always)]
fn meet_four<const FIRST: usize>(
    ray: &ShearedRay,
    pack: &TrianglePack,
    t_min: f64,
    t_max: f64,
    test: &mut PackTest,
) -> u32 {
    const { assert!(FIRST + 4 <= PACK) };
    let [kx, ky, kz] = ray.axes;
    let corners = &pack.corners;
    // SAFETY: the features were detected. Four numbers follow `FIRST` in arrays of eight; loads and stores need no alignment.
    unsafe {
        let [ox, oy, oz] = in_all_lanes(ray.origin);
        let [sx, sy, sz] = in_all_lanes(ray.shear);
        let mut x = [_mm256_setzero_pd(); 3];
        let mut y = x;
        let mut depths = x;
        for index in 0..3 {
            let corner = &corners[index];
            let depth = _mm256_sub_pd(widened::<FIRST>(&corner[kz]), oz);
            x[index] = _mm256_sub_pd(_mm256_sub_pd(widened::<FIRST>(&corner[kx]), ox), _mm256_mul_pd(sx, depth));
            y[index] = _mm256_sub_pd(_mm256_sub_pd(widened::<FIRST>(&corner[ky]), oy), _mm256_mul_pd(sy, depth));
            depths[index] = depth;
        }
        let u = _mm256_sub_pd(_mm256_mul_pd(x[2], y[1]), _mm256_mul_pd(y[2], x[1]));
        let v = _mm256_sub_pd(_mm256_mul_pd(x[0], y[2]), _mm256_mul_pd(y[0], x[2]));
        let w = _mm256_sub_pd(_mm256_mul_pd(x[1], y[0]), _mm256_mul_pd(y[1], x[0]));
        // All of one sign, zero included. Where one is NaN the distance is too, and is refused below.
        let zero = _mm256_setzero_pd();
        let lowest = _mm256_min_pd(_mm256_min_pd(u, v), w);
        let highest = _mm256_max_pd(_mm256_max_pd(u, v), w);
        let is_met =
            _mm256_or_pd(_mm256_cmp_pd::<_CMP_GE_OQ>(lowest, zero), _mm256_cmp_pd::<_CMP_LE_OQ>(highest, zero));
        if _mm256_movemask_pd(is_met) == 0 {
            return 0;
        }
        let determinant = _mm256_add_pd(_mm256_add_pd(u, v), w);
        let mut sum = _mm256_mul_pd(u, _mm256_mul_pd(sz, depths[0]));
        sum = _mm256_add_pd(sum, _mm256_mul_pd(v, _mm256_mul_pd(sz, depths[1])));
        sum = _mm256_add_pd(sum, _mm256_mul_pd(w, _mm256_mul_pd(sz, depths[2])));
        let t = _mm256_div_pd(sum, determinant);
        let is_near_enough = _mm256_and_pd(
            _mm256_cmp_pd::<_CMP_GE_OQ>(t, _mm256_set1_pd(t_min)),
            _mm256_cmp_pd::<_CMP_LE_OQ>(t, _mm256_set1_pd(t_max)),
        );
        let has_area = _mm256_cmp_pd::<_CMP_NEQ_OQ>(determinant, zero);
        let met = _mm256_movemask_pd(_mm256_and_pd(_mm256_and_pd(is_met, is_near_enough), has_area)) as u32;
        if met != 0 {
            _mm256_storeu_pd(test.edges[0].as_mut_ptr().add(FIRST), u);
            _mm256_storeu_pd(test.edges[1].as_mut_ptr().add(FIRST), v);
            _mm256_storeu_pd(test.edges[2].as_mut_ptr().add(FIRST), w);
            _mm256_storeu_pd(test.determinants.as_mut_ptr().add(FIRST), determinant);
            _mm256_storeu_pd(test.distances.as_mut_ptr().add(FIRST), t);
        }
        met
    }
}

/// Each number in all lanes of a register.
#[inline(always)]
fn in_all_lanes([x, y, z]: [f64; 3]) -> [__m256d; 3] {
    // SAFETY: called by this kernel, whose features were detected.
    unsafe { [_mm256_set1_pd(x), _mm256_set1_pd(y), _mm256_set1_pd(z)] }
}

/// Four numbers in f64, from `FIRST` on.
#[inline(always)]
fn widened<const FIRST: usize>(numbers: &[f32; PACK]) -> __m256d {
    const { assert!(FIRST + 4 <= PACK) };
    // SAFETY: called by this kernel, whose features were detected. The load needs no alignment.
    unsafe { _mm256_cvtps_pd(_mm_loadu_ps(numbers.as_ptr().add(FIRST))) }
}
