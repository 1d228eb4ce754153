//! Which vertices of a mesh are one: those a few roundings apart, as exporters repeat them at seams and poles.

use std::collections::HashMap;

use glam::DVec3;

/// Roundings of the largest coordinate up to which vertices are one.
const ROUNDINGS: f64 = 16.0;
/// Share of the shortest edge at a vertex up to which another vertex may be the same: no noise comes near it.
const SHARE_OF_EDGE: f64 = 1e-3;

/// For each vertex the first of those that are one with it. Only vertices that triangles use are looked at.
pub(super) fn clustered(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut first_of: Vec<u32> = (0..positions.len() as u32).collect();
    let mut shortest = vec![f64::INFINITY; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        for (k, edges) in [[a - b, a - c], [b - a, b - c], [c - a, c - b]].into_iter().enumerate() {
            // An edge without length joins what is one anyway.
            for length in edges.map(DVec3::length).into_iter().filter(|length| *length > 0.0) {
                let least = &mut shortest[triangle[k] as usize];
                *least = least.min(length);
            }
        }
    }
    let used: Vec<u32> = (0..positions.len() as u32).filter(|&i| shortest[i as usize] < f64::INFINITY).collect();
    let largest = used.iter().map(|&i| positions[i as usize].abs().max_element()).fold(0.0, f64::max);
    let reach = (ROUNDINGS * f64::EPSILON * largest).max(f64::MIN_POSITIVE);
    // Cells twice as wide as the reach: what is near stands in the same cell or in one of seven others.
    let cell_of = |p: DVec3| (p / (2.0 * reach)).floor().to_array().map(|x| x as i64);
    let mut in_cell: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(used.len());
    for &index in &used {
        let position = positions[index as usize];
        let own = shortest[index as usize];
        let is_one = |&other: &u32| {
            let distance = positions[other as usize].distance(position);
            distance == 0.0 || distance <= reach && distance <= SHARE_OF_EDGE * own.min(shortest[other as usize])
        };
        let [low, high] = [cell_of(position - reach), cell_of(position + reach)];
        let mut found = None;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let here = in_cell.get(&[x, y, z]).into_iter().flatten().copied().find(|i| is_one(i));
                    found = found.or(here);
                }
            }
        }
        match found {
            Some(first) => {
                first_of[index as usize] = first;
                // It may stand next to a finer part of the mesh than the first one does.
                let least = shortest[first as usize].min(own);
                shortest[first as usize] = least;
            }
            None => in_cell.entry(cell_of(position)).or_default().push(index),
        }
    }
    first_of
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first_of(positions: &[DVec3]) -> Vec<u32> {
        // Each vertex with two far ones.
        let count = positions.len() as u32;
        let all: Vec<DVec3> = positions.iter().copied().chain([DVec3::X * 3.0, DVec3::Y * 3.0]).collect();
        let triangles: Vec<[u32; 3]> = (0..count).map(|i| [i, count, count + 1]).collect();
        clustered(&all, &triangles)[..positions.len()].to_vec()
    }

    #[test]
    fn noise_is_one_and_what_is_thin_is_not() {
        let p = DVec3::new(1.0, 0.0, 0.5);
        let near = [p, p + DVec3::Y * 2.4e-16, p + DVec3::Y * 1e-33, p - DVec3::Y * 1e-33, p.with_x(1.0_f64.next_up())];
        assert_eq!(first_of(&near), [0; 5]);
        assert_eq!(first_of(&[p, p + DVec3::Y * 1e-12]), [0, 1]);
        // On either side of a cell's wall.
        for k in 0..200 {
            let p = DVec3::new(0.01 * f64::from(k), 1.0 - 0.003 * f64::from(k), -0.7);
            assert_eq!(first_of(&[p, p + DVec3::new(2e-16, -2e-16, 2e-16)]), [0, 0], "{k}");
        }
    }

    #[test]
    fn far_vertices_do_not_make_small_ones_one() {
        let small =
            [DVec3::ZERO, DVec3::X * 1e-9, DVec3::Y * 1e-9, DVec3::splat(1e9), DVec3::splat(2e9), DVec3::X * 1e9];
        assert_eq!(clustered(&small, &[[0, 1, 2], [3, 4, 5]]), [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn all_at_one_place() {
        assert_eq!(clustered(&[DVec3::ZERO; 3], &[[0, 1, 2]]), [0, 1, 2]);
    }
}
