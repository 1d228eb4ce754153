//! Plain Rust, for every processor.

use std::array::from_fn;

use super::Kernel;
use crate::geometry::box_ray::{BoxRay, NOTHING, Stack, entry};
use crate::geometry::node::{Node, WIDTH};
use crate::geometry::triangle::{PACK, PackTest, ShearedRay, TrianglePack};

pub struct Portable;

impl Kernel for Portable {
    #[inline(always)]
    fn open(node: &Node, ray: &BoxRay, far_limit: f32, stack: &mut Stack) -> u64 {
        let mut near = [ray.near_limit; WIDTH];
        let mut far = [f32::INFINITY; WIDTH];
        for axis in 0..3 {
            let near_row = ray.near_sides[axis] as usize / WIDTH;
            let (near_row, far_row) = (&node.rows[near_row], &node.rows[near_row ^ 1]);
            for lane in 0..WIDTH {
                // Not fused: that would be slow where it is no instruction.
                let low = near_row[lane] * ray.inverse[axis] + ray.near_offset[axis];
                let high = far_row[lane] * ray.inverse[axis] + ray.far_offset[axis];
                near[lane] = if low > near[lane] { low } else { near[lane] };
                far[lane] = if high < far[lane] { high } else { far[lane] };
            }
        }
        let mut nearest = NOTHING;
        for lane in 0..WIDTH {
            if near[lane] <= far[lane] && near[lane] <= far_limit {
                let child = entry(near[lane], node.children[lane]);
                if nearest != NOTHING {
                    stack.push(nearest.max(child));
                }
                nearest = nearest.min(child);
            }
        }
        nearest
    }

    #[inline(always)]
    fn meet_triangles(ray: &ShearedRay, pack: &TrianglePack, t_min: f64, t_max: f64, test: &mut PackTest) -> u32 {
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
        let mut met = 0;
        for lane in 0..PACK {
            let [u, v, w] = edges.map(|edge| edge[lane]);
            // All of one sign, zero included: on the edge counts as inside.
            let is_met = (u >= 0.0) & (v >= 0.0) & (w >= 0.0) | (u <= 0.0) & (v <= 0.0) & (w <= 0.0);
            met |= u32::from(is_met) << lane;
        }
        if met == 0 {
            return 0;
        }
        test.edges = edges;
        let mut near_enough = 0;
        for lane in 0..PACK {
            let [u, v, w] = edges.map(|edge| edge[lane]);
            let determinant = u + v + w;
            let t = (u * depths[0][lane] + v * depths[1][lane] + w * depths[2][lane]) / determinant;
            test.determinants[lane] = determinant;
            test.distances[lane] = t;
            near_enough |= u32::from((determinant != 0.0) & (t >= t_min) & (t <= t_max)) << lane;
        }
        met & near_enough
    }
}
