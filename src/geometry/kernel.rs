//! The two tests that rays spend their time in, for whichever registers the processor has: eight boxes, four triangles.
//!
//! The triangle test gives the same bits with every kernel: no multiplication is fused with an addition anywhere.

use std::array::from_fn;

use glam::Vec3;

use super::bvh::{DISTANCE_MARGIN, Node, WIDTH};
use super::triangle::{PACK, PackTest, ShearedRay, TrianglePack};

/// Far sides are grown by this factor: it covers the rounding of both distances that are compared.
const FAR_GROWTH: f32 = 1.0 + 2.0 * DISTANCE_MARGIN;

/// An implementation of both tests.
pub trait Kernel {
    /// Entry distances of a node's children, and a bit for each child whose box is met between `near_limit` (≥ 0) and `far_limit`.
    /// Errs only towards meeting a box.
    fn meet_boxes(node: &Node, origin: Vec3, inverse: Vec3, near_limit: f32, far_limit: f32) -> ([f32; WIDTH], u32);

    /// Tests the triangles of a pack against the ray's line.
    fn meet_triangles(ray: &ShearedRay, pack: &TrianglePack) -> PackTest;
}

/// Plain Rust, for every processor.
pub struct Portable;

impl Kernel for Portable {
    #[inline(always)]
    fn meet_boxes(node: &Node, origin: Vec3, inverse: Vec3, near_limit: f32, far_limit: f32) -> ([f32; WIDTH], u32) {
        let mut near = [near_limit; WIDTH];
        let mut far = [far_limit; WIDTH];
        for axis in 0..3 {
            for lane in 0..WIDTH {
                let a = (node.min[axis][lane] - origin[axis]) * inverse[axis];
                let b = (node.max[axis][lane] - origin[axis]) * inverse[axis];
                // Sorted by value, whatever the sign of the direction, −0 included.
                let (low, high) = if a < b { (a, b) } else { (b, a) };
                let high = high * FAR_GROWTH;
                near[lane] = if low > near[lane] { low } else { near[lane] };
                far[lane] = if high < far[lane] { high } else { far[lane] };
            }
        }
        let met = (0..WIDTH).fold(0, |met, lane| met | u32::from(near[lane] <= far[lane]) << lane);
        (near, met & node.used)
    }

    #[inline(always)]
    fn meet_triangles(ray: &ShearedRay, pack: &TrianglePack) -> PackTest {
        let [kx, ky, kz] = ray.axes;
        // Corners relative to the ray's origin, sheared: [corner][lane].
        let mut x = [[0.0; PACK]; 3];
        let mut y = [[0.0; PACK]; 3];
        let mut depths = [[0.0; PACK]; 3];
        for corner in 0..3 {
            let c = &pack.corners[corner];
            for lane in 0..PACK {
                let depth = f64::from(c[kz][lane]) - ray.origin[2];
                x[corner][lane] = (f64::from(c[kx][lane]) - ray.origin[0]) - ray.shear[0] * depth;
                y[corner][lane] = (f64::from(c[ky][lane]) - ray.origin[1]) - ray.shear[1] * depth;
                depths[corner][lane] = ray.shear[2] * depth;
            }
        }
        let edge = |a: usize, b: usize| from_fn(|lane| x[a][lane] * y[b][lane] - y[a][lane] * x[b][lane]);
        let edges: [[f64; PACK]; 3] = [edge(2, 1), edge(0, 2), edge(1, 0)];
        let met = (0..PACK).fold(0, |met, lane| {
            let lane_edges = edges.map(|edge| edge[lane]);
            // All of one sign, zero included: on the edge counts as inside.
            let is_met = lane_edges.iter().all(|&e| e >= 0.0) || lane_edges.iter().all(|&e| e <= 0.0);
            met | u32::from(is_met) << lane
        });
        PackTest { edges, depths, met }
    }
}

/// AVX2. To be used only from code compiled for it, on a processor that has it.
#[cfg(target_arch = "x86_64")]
pub struct Avx2;

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
impl Kernel for Avx2 {
    #[inline(always)]
    fn meet_boxes(node: &Node, origin: Vec3, inverse: Vec3, near_limit: f32, far_limit: f32) -> ([f32; WIDTH], u32) {
        // SAFETY: this kernel is chosen only where the feature was detected.
        unsafe { avx2::meet_boxes(node, origin, inverse, near_limit, far_limit) }
    }

    #[inline(always)]
    fn meet_triangles(ray: &ShearedRay, pack: &TrianglePack) -> PackTest {
        // SAFETY: as above.
        unsafe { avx2::meet_triangles(ray, pack) }
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod avx2 {
    use std::arch::x86_64::*;

    use super::*;

    /// Eight numbers into a register.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn load(numbers: &[f32; WIDTH]) -> __m256 {
        // SAFETY: the array is as long as the register, and the load needs no alignment.
        unsafe { _mm256_loadu_ps(numbers.as_ptr()) }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    pub fn meet_boxes(
        node: &Node,
        origin: Vec3,
        inverse: Vec3,
        near_limit: f32,
        far_limit: f32,
    ) -> ([f32; WIDTH], u32) {
        let mut near = _mm256_set1_ps(near_limit);
        let mut far = _mm256_set1_ps(far_limit);
        let growth = _mm256_set1_ps(FAR_GROWTH);
        for axis in 0..3 {
            let (o, i) = (_mm256_set1_ps(origin[axis]), _mm256_set1_ps(inverse[axis]));
            let a = _mm256_mul_ps(_mm256_sub_ps(load(&node.min[axis]), o), i);
            let b = _mm256_mul_ps(_mm256_sub_ps(load(&node.max[axis]), o), i);
            // These return their second operand where one is NaN: such an axis does not count.
            near = _mm256_max_ps(_mm256_min_ps(a, b), near);
            far = _mm256_min_ps(_mm256_mul_ps(_mm256_max_ps(a, b), growth), far);
        }
        let met = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32;
        let mut distances = [0.0; WIDTH];
        // SAFETY: the array is as long as the register, and the store needs no alignment.
        unsafe { _mm256_storeu_ps(distances.as_mut_ptr(), near) };
        (distances, met & node.used)
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    pub fn meet_triangles(ray: &ShearedRay, pack: &TrianglePack) -> PackTest {
        let [kx, ky, kz] = ray.axes;
        let [ox, oy, oz] = ray.origin.map(|o| _mm256_set1_pd(o));
        let [sx, sy, sz] = ray.shear.map(|s| _mm256_set1_pd(s));
        // SAFETY: each array holds four f32, as the load reads; it needs no alignment.
        let corner =
            |index: usize, axis: usize| unsafe { _mm256_cvtps_pd(_mm_loadu_ps(pack.corners[index][axis].as_ptr())) };
        let mut x = [_mm256_setzero_pd(); 3];
        let mut y = x;
        let mut depths = x;
        for index in 0..3 {
            let depth = _mm256_sub_pd(corner(index, kz), oz);
            x[index] = _mm256_sub_pd(_mm256_sub_pd(corner(index, kx), ox), _mm256_mul_pd(sx, depth));
            y[index] = _mm256_sub_pd(_mm256_sub_pd(corner(index, ky), oy), _mm256_mul_pd(sy, depth));
            depths[index] = _mm256_mul_pd(sz, depth);
        }
        let edge = |a: usize, b: usize| _mm256_sub_pd(_mm256_mul_pd(x[a], y[b]), _mm256_mul_pd(y[a], x[b]));
        let edges = [edge(2, 1), edge(0, 2), edge(1, 0)];
        let zero = _mm256_setzero_pd();
        let [up, down] =
            [edges.map(|e| _mm256_cmp_pd::<_CMP_GE_OQ>(e, zero)), edges.map(|e| _mm256_cmp_pd::<_CMP_LE_OQ>(e, zero))]
                .map(|[u, v, w]| _mm256_and_pd(_mm256_and_pd(u, v), w));
        let met = _mm256_movemask_pd(_mm256_or_pd(up, down)) as u32;
        let store = |register: __m256d| {
            let mut numbers = [0.0; PACK];
            // SAFETY: the array is as long as the register, and the store needs no alignment.
            unsafe { _mm256_storeu_pd(numbers.as_mut_ptr(), register) };
            numbers
        };
        PackTest { edges: edges.map(store), depths: depths.map(store), met }
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::Ray;

    /// Both kernels find the same triangles at the same bits.
    #[test]
    fn kernels_agree() {
        if !std::arch::is_x86_feature_detected!("avx2") {
            return; // Nothing to compare on this processor.
        }
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 31) * 2.0 - 1.0
        };
        let mut met = 0;
        for _ in 0..10_000 {
            let mut pack = TrianglePack::EMPTY;
            for lane in 0..3 {
                let corner = |next: &mut dyn FnMut() -> f64| DVec3::new(next(), next(), next()).as_vec3();
                pack.set(lane, lane as u32, [corner(&mut next), corner(&mut next), corner(&mut next)]);
            }
            let direction = DVec3::new(next(), next(), next()).normalize();
            let ray = ShearedRay::new(&Ray::new(DVec3::new(next(), next(), next()) * 2.0, direction));
            let (a, b) = (Portable::meet_triangles(&ray, &pack), Avx2::meet_triangles(&ray, &pack));
            assert_eq!(a, b);
            met += (a.met & 7).count_ones();
        }
        assert!(met > 500, "{met}");
    }
}
