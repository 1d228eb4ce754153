//! Vertices of subpaths from lights, to be found by place.
//!
//! The radius within which they are merged grows with the distance from the camera, so that it covers as many pixels everywhere. It depends on
//! nothing but the place, as both subpaths must know it. Photons lie in grids whose cells are powers of two in size, each photon in the one
//! that suits the radius there; cells are found by hashing.

use glam::DVec3;
use rayon::prelude::*;

use super::weights::Weights;
use crate::spectrum::Spectrum;

/// The radius of merging as a function of the place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MergeRadius {
    /// The camera's position, local coordinates.
    pub center: DVec3,
    /// Radius over distance.
    pub per_distance: f64,
    /// The least radius, > 0.
    pub least: f64,
}

impl MergeRadius {
    #[inline]
    pub fn at(&self, point: DVec3) -> f64 {
        self.least.max(point.distance(self.center) * self.per_distance)
    }
}

/// Light that arrives at a place where it can be merged with a subpath from the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Photon {
    /// Local coordinates.
    pub position: DVec3,
    /// Unit, to where the light comes from.
    pub wo: DVec3,
    /// Unit, of the face, on the side of `wo`.
    pub normal: DVec3,
    /// Power.
    pub flux: Spectrum,
    pub weights: Weights,
    /// Segments of its subpath.
    pub segments: u32,
}

/// Photons in grids.
#[derive(Debug)]
pub struct PhotonMap {
    radius: MergeRadius,
    /// In the order of their cells' hashes.
    photons: Vec<Photon>,
    hashes: Vec<u64>,
    /// Where the hashes with each value of their upper bits begin.
    starts: Vec<u32>,
    /// How many bits that is.
    bits: u32,
}

impl PhotonMap {
    /// The order of `photons` decides that of equal cells, and so the order in which they are summed.
    pub fn new(radius: MergeRadius, photons: &[Photon]) -> Self {
        let mut order: Vec<(u64, u32)> = photons
            .par_iter()
            .enumerate()
            .map(|(index, photon)| (cell_of(photon.position, level(radius.at(photon.position))), index as u32))
            .collect();
        order.par_sort_unstable();
        let bits = photons.len().max(2).ilog2();
        let mut starts = vec![0_u32; (1 << bits) + 1];
        for (hash, _) in &order {
            starts[(hash >> (64 - bits)) as usize + 1] += 1;
        }
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let sorted = order.par_iter().map(|&(_, index)| photons[index as usize]).collect();
        Self { radius, photons: sorted, hashes: order.into_iter().map(|(hash, _)| hash).collect(), starts, bits }
    }

    /// The radius of merging at a place.
    pub fn radius(&self, point: DVec3) -> f64 {
        self.radius.at(point)
    }

    /// Visits the photons within the radius of merging of `point`, always in the same order.
    pub fn for_each_near(&self, point: DVec3, mut visit: impl FnMut(&Photon)) {
        let radius = self.radius(point);
        // The photons' own radii differ from this one by so much at the most.
        let spread = radius * self.radius.per_distance;
        let levels = level(radius - spread)..=level(radius + spread);
        for level in levels {
            let size = f64::from(level).exp2();
            let [first, last] = [point - radius, point + radius].map(|corner| (corner / size).floor().as_i64vec3());
            for z in first.z..=last.z {
                for y in first.y..=last.y {
                    for x in first.x..=last.x {
                        let hash = hash_of([x, y, z], level);
                        for photon in self.in_cell(hash) {
                            if photon.position.distance_squared(point) < radius * radius {
                                visit(photon);
                            }
                        }
                    }
                }
            }
        }
    }

    fn in_cell(&self, hash: u64) -> &[Photon] {
        let bucket = (hash >> (64 - self.bits)) as usize;
        let (first, last) = (self.starts[bucket] as usize, self.starts[bucket + 1] as usize);
        let hashes = &self.hashes[first..last];
        let begin = hashes.partition_point(|other| *other < hash);
        let end = begin + hashes[begin..].partition_point(|other| *other == hash);
        &self.photons[first + begin..first + end]
    }
}

/// The size of cells for a radius, as a power of two: from twice to four times the radius.
fn level(radius: f64) -> i32 {
    (2.0 * radius).max(f64::MIN_POSITIVE).log2().ceil() as i32
}

fn cell_of(point: DVec3, level: i32) -> u64 {
    hash_of((point / f64::from(level).exp2()).floor().as_i64vec3().to_array(), level)
}

/// A hash of a cell. Cells of one hash, some in 10¹⁸, are taken for one; photons of the other are too far away to be visited.
fn hash_of(cell: [i64; 3], level: i32) -> u64 {
    let mix = |hash: u64, value: u64| {
        let mut x = (hash ^ value).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        x ^= x >> 32;
        x = x.wrapping_mul(0xD6E8_FEB8_6659_FD93);
        x ^ (x >> 32)
    };
    cell.into_iter().fold(mix(0x2545_F491_4F6C_DD1D, level as u64), |hash, value| mix(hash, value as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All that are near, each once, whatever the radius, near the camera and far away.
    #[test]
    fn the_photons_near_a_place_are_found() {
        let number = |index: u32, step: f64| (f64::from(index) * step + 0.5).fract() - 0.5;
        let photons: Vec<Photon> = (0..4000)
            .map(|index| {
                let spread = 10.0_f64.powi(index as i32 % 4 - 1);
                let place = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|step| number(index, step) * spread);
                Photon {
                    position: place.into(),
                    wo: DVec3::Y,
                    normal: DVec3::Y,
                    flux: Spectrum::ONE,
                    weights: Weights::default(),
                    segments: index,
                }
            })
            .collect();
        for (per_distance, least) in [(0.1, 1e-6), (0.01, 1e-3), (0.0, 0.5), (0.5, 1e-9)] {
            let radius = MergeRadius { center: DVec3::new(0.1, 0.2, -0.1), per_distance, least };
            let map = PhotonMap::new(radius, &photons);
            let mut found = 0;
            for place in photons.iter().step_by(7).map(|photon| photon.position + DVec3::splat(0.01 * least)) {
                let mut near: Vec<u32> = Vec::new();
                map.for_each_near(place, |photon| near.push(photon.segments));
                near.sort_unstable();
                let expected: Vec<u32> = photons
                    .iter()
                    .filter(|photon| photon.position.distance_squared(place) < radius.at(place).powi(2))
                    .map(|photon| photon.segments)
                    .collect();
                assert_eq!(near, expected, "{per_distance} {least} {place}");
                found += near.len();
            }
            assert!(found > 500, "{per_distance} {least}: {found}");
        }
        let map = PhotonMap::new(MergeRadius { center: DVec3::ZERO, per_distance: 0.1, least: 1.0 }, &[]);
        map.for_each_near(DVec3::ZERO, |_| panic!("there are none"));
    }
}
