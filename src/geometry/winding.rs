//! The generalised winding number of a surface around a point (Jacobson, Kavan and Sorkine-Hornung 2013): the solid angle under which the
//! surface is seen, over 4π, faces seen from behind counted positive. 1 inside a closed outward surface, 0 outside, and in between where
//! there are holes: inside is where it is more than ½.
//!
//! The fast form (Barill, Dickson, Schmidt, Levin and Jacobson 2018): far groups of triangles are replaced by the first two terms of their
//! expansion around their middle, near triangles are asked exactly (van Oosterom and Strackee 1983).

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use super::hierarchy::Hierarchy;
use super::triangle::area_vector;

/// Groups farther away than this many times their radius are expanded.
const ACCURACY: f64 = 4.0;

/// Triangles, ready to be asked.
#[derive(Debug, Clone, PartialEq)]
pub struct WindingTree {
    hierarchy: Hierarchy,
    /// In the order of the hierarchy.
    triangles: Vec<[DVec3; 3]>,
    /// As the hierarchy's levels.
    groups: Vec<Vec<Group>>,
}

/// What stands for the triangles of a node. With area vectors A and centroids x:
#[derive(Debug, Clone, Copy, PartialEq)]
struct Group {
    /// The mean of x by area, p.
    center: DVec3,
    /// Of a sphere around `center` that holds all.
    radius: f64,
    area: f64,
    /// Σ A.
    dipole: DVec3,
    /// Σ A (x − p)ᵀ.
    quadrupole: DMat3,
}

impl WindingTree {
    /// Over triangles given by their corners.
    pub fn build(triangles: &[[DVec3; 3]]) -> Self {
        let hierarchy = Hierarchy::build(triangles.len(), |face| triangles[face as usize]);
        let triangles: Vec<[DVec3; 3]> = hierarchy.order.iter().map(|&face| triangles[face as usize]).collect();
        let mut groups: Vec<Vec<Group>> = Vec::with_capacity(hierarchy.levels.len());
        for (level, boxes) in hierarchy.levels.iter().enumerate() {
            let of_node = |index: usize| match level {
                0 => Group::of_triangles(&triangles[hierarchy.leaf_range(index)]),
                _ => Group::of_groups(&groups[level - 1][hierarchy.children(level, index)]),
            };
            let made = (0..boxes.len())
                .map(|index| {
                    let mut group = of_node(index);
                    let bounds = &boxes[index];
                    group.radius = (bounds.max - group.center).max(group.center - bounds.min).length();
                    group
                })
                .collect();
            groups.push(made);
        }
        Self { hierarchy, triangles, groups }
    }

    /// The winding number around `point`, within 0.01 of the exact one. On the surface itself it lies between those of its two
    /// sides.
    pub fn winding(&self, point: DVec3) -> f64 {
        let Some(top) = self.groups.len().checked_sub(1) else { return 0.0 };
        let mut sum = 0.0;
        let mut open = vec![(top, 0)];
        while let Some((level, index)) = open.pop() {
            let group = &self.groups[level][index];
            let from_point = group.center - point;
            if from_point.length_squared() > (ACCURACY * group.radius).powi(2) {
                sum += group.seen_from(from_point);
            } else if level > 0 {
                open.extend(self.hierarchy.children(level, index).map(|child| (level - 1, child)));
            } else {
                sum += self.triangles[self.hierarchy.leaf_range(index)]
                    .iter()
                    .map(|corners| solid_angle(corners.map(|p| p - point)))
                    .sum::<f64>();
            }
        }
        sum / (4.0 * PI)
    }
}

impl Group {
    fn of_triangles(triangles: &[[DVec3; 3]]) -> Self {
        let centroid = |[a, b, c]: [DVec3; 3]| (a + b + c) / 3.0;
        let parts = triangles.iter().map(|&t| {
            let dipole = area_vector(t) / 2.0;
            Self { center: centroid(t), radius: 0.0, area: dipole.length(), dipole, quadrupole: DMat3::ZERO }
        });
        Self::joined(parts)
    }

    fn of_groups(groups: &[Self]) -> Self {
        Self::joined(groups.iter().copied())
    }

    fn joined(parts: impl Iterator<Item = Self> + Clone) -> Self {
        let area: f64 = parts.clone().map(|part| part.area).sum();
        let count = parts.clone().count().max(1) as f64;
        let center = if area > 0.0 {
            parts.clone().map(|part| part.center * (part.area / area)).sum()
        } else {
            parts.clone().map(|part| part.center / count).sum()
        };
        let nothing = Self { center, radius: 0.0, area, dipole: DVec3::ZERO, quadrupole: DMat3::ZERO };
        parts.fold(nothing, |all, part| Self {
            dipole: all.dipole + part.dipole,
            quadrupole: all.quadrupole + part.quadrupole + outer(part.dipole, part.center - center),
            ..all
        })
    }

    /// Solid angle of the group whose centre is at `r` from the point: Σ A · f(x) with f(x) = x/|x|³, expanded around r.
    fn seen_from(&self, r: DVec3) -> f64 {
        let distance = r.length();
        let cubed = distance.powi(3);
        let trace = self.quadrupole.x_axis.x + self.quadrupole.y_axis.y + self.quadrupole.z_axis.z;
        let along = r.dot(self.quadrupole * r) / (distance * distance);
        (self.dipole.dot(r) + trace - 3.0 * along) / cubed
    }
}

/// a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Solid angle of a triangle seen from the origin, positive from behind.
pub(super) fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let determinant = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    let angle = 2.0 * determinant.atan2(denominator);
    // In the triangle's own plane, inside of it, both sides are equally near.
    if angle.abs() >= TAU { 0.0 } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brute_force(triangles: &[[DVec3; 3]], point: DVec3) -> f64 {
        triangles.iter().map(|t| solid_angle(t.map(|p| p - point))).sum::<f64>() / (4.0 * PI)
    }

    /// A sphere of longitudes and latitudes, with some share of its triangles missing.
    fn sphere(missing: f64) -> Vec<[DVec3; 3]> {
        let (rows, columns) = (24, 48);
        let at = |row: u32, column: u32| {
            let (sin_theta, cos_theta) = (PI * f64::from(row) / f64::from(rows)).sin_cos();
            let (sin_phi, cos_phi) = (TAU * f64::from(column % columns) / f64::from(columns)).sin_cos();
            DVec3::new(sin_theta * cos_phi, cos_theta, -sin_theta * sin_phi)
        };
        let mut triangles = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let corners = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
                for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                    triangles.push([corners[a], corners[b], corners[c]]);
                }
            }
        }
        let mut index = 0.0_f64;
        triangles.retain(|_| {
            index += 0.618_033_988_749_895;
            index.fract() >= missing
        });
        triangles
    }

    fn points() -> impl Iterator<Item = DVec3> {
        (0..2000).map(|i| {
            let t = f64::from(i);
            DVec3::new((t * 0.754_877).fract(), (t * 0.569_840).fract(), (t * 0.430_159).fract()) * 3.0 - 1.5
        })
    }

    #[test]
    fn one_octant_and_signs() {
        let triangle = [DVec3::X, DVec3::Y, DVec3::Z];
        assert!((solid_angle(triangle) - PI / 2.0).abs() < 1e-15, "seen from behind, an eighth of all");
        let closed = sphere(0.0);
        let tree = WindingTree::build(&closed);
        for point in points().filter(|p| (p.length() - 1.0).abs() > 0.02) {
            let expected = if point.length() < 1.0 { 1.0 } else { 0.0 };
            assert!((tree.winding(point) - expected).abs() < 0.01, "{point}: {}", tree.winding(point));
        }
    }

    #[test]
    fn near_to_brute_force_with_holes_and_close_to_the_surface() {
        for missing in [0.0, 0.05, 0.2] {
            let triangles = sphere(missing);
            let tree = WindingTree::build(&triangles);
            let mut worst: f64 = 0.0;
            for (index, point) in points().enumerate() {
                // Half of them next to the surface.
                let point = if index % 2 == 0 { point } else { point.normalize() * (0.98 + 0.02 * point.x) };
                worst = worst.max((tree.winding(point) - brute_force(&triangles, point)).abs());
            }
            assert!(worst < 0.01, "{missing}: {worst}");
        }
    }

    #[test]
    fn nothing_winds_around_nothing_and_points_on_the_surface_have_a_number() {
        assert_eq!(WindingTree::build(&[]).winding(DVec3::ZERO), 0.0);
        let flat = [[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::ZERO; 3]];
        let tree = WindingTree::build(&flat);
        for point in
            [DVec3::ZERO, DVec3::X * 0.5, DVec3::new(0.2, 0.2, 0.0), DVec3::X * 2.0, DVec3::new(0.2, 0.2, 1e-300)]
        {
            assert!(tree.winding(point).abs() <= 0.5, "{point}");
        }
    }
}
