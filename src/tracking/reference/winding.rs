//! How often triangles wind around a point: the sum of the solid angles under which they are seen, over 4π, faces seen from behind counted
//! positive (Jacobson, Kavan and Sorkine-Hornung 2013). Near triangles are asked one by one (van Oosterom and Strackee 1983), far groups by
//! the first two terms of the Taylor series of x/|x|³ about their middle.
//!
//! At a point *on* a surface the sum is not defined: a face through the point is seen under +2π from one side and −2π from the other. So
//! faces that lie at the point, in the plane that is asked about, are told apart from the rest: their share on either side follows
//! from which way they look, however rounding has placed them.

use std::cell::Cell;
use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};

use super::boxes::{Below, Bounds, Tree};

/// Groups that are farther from the point than this many times their radius are expanded; the error is then below 2 % of a whole turn.
const FAR: f64 = 4.0;
/// Cosine of the angle between planes up to which faces count as lying in one.
const PARALLEL: f64 = 0.9;

/// Eight roundings to f32, as a share of what is rounded.
const ROUNDING: f64 = 8.0 / (1u32 << 24) as f64;

/// A point on a surface, and the plane across which it is asked about.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointInPlane {
    pub point: DVec3,
    /// Unit.
    pub normal: DVec3,
    /// Largest magnitudes of the coordinates of the face there that were rounded to f32.
    pub reach: DVec3,
    /// Two unit vectors across the normal.
    axes: [DVec3; 2],
}

/// How far off the plane faces lie in it all the same: what rounding to f32 and modelling leave between surfaces that are meant to touch, eight
/// roundings of coordinates across the plane, or of a length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Allowed {
    pub length: f64,
    /// Whether the face belongs to the same simple surface. Then no more than roundings to f64 are allowed where it looks the other way: it
    /// is the other side of something thin.
    pub is_of_one_surface: bool,
}

impl PointInPlane {
    pub fn new(point: DVec3, normal: DVec3, reach: DVec3) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        Self { point, normal, reach, axes: [u, v] }
    }

    /// How far off a face may lie whose coordinates are no larger than `reach`.
    pub fn allowance(&self, length: f64, reach: DVec3) -> f64 {
        ROUNDING * self.normal.abs().dot(self.reach.max(reach)).max(length) + self.exact_allowance(reach)
    }

    /// The same if nothing but f64 has rounded.
    fn exact_allowance(&self, reach: DVec3) -> f64 {
        64.0 * f64::EPSILON * self.point.abs().max(reach).max_element()
    }

    /// Whether a triangle lies at the point, in the plane, no farther off than allowed; if so, whether it looks along the normal.
    #[inline]
    pub fn is_covered_by(&self, corners: &[DVec3; 3], allowed: Allowed) -> Option<bool> {
        let reach = corners[0].abs().max(corners[1].abs()).max(corners[2].abs());
        let most = self.allowance(allowed.length, reach);
        let [a, b, c] = corners.map(|p| p - self.point);
        // Quick: most triangles lie beside.
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        if low.cmpgt(DVec3::splat(most)).any() || high.cmplt(DVec3::splat(-most)).any() {
            return None;
        }
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let cos = normal.dot(self.normal);
        let most = if allowed.is_of_one_surface && cos < 0.0 { self.exact_allowance(reach) } else { most };
        if cos.abs() < PARALLEL || normal.dot(a).abs() > most {
            return None;
        }
        let [p, q, r] = [a, b, c].map(|p| DVec2::new(p.dot(self.axes[0]), p.dot(self.axes[1])));
        let is_left = |p: DVec2, q: DVec2| {
            let area = p.x * q.y - p.y * q.x;
            // On the line itself the point counts as moved by a little along x, and by less along y: then exactly one of two neighbours has it.
            if area != 0.0 {
                area > 0.0
            } else if p.y != q.y {
                p.y > q.y
            } else {
                p.x < q.x
            }
        };
        let sides = [is_left(p, q), is_left(q, r), is_left(r, p)];
        (sides[0] == sides[1] && sides[1] == sides[2]).then_some(cos > 0.0)
    }
}

/// The faces of a body, ready to be asked.
#[derive(Debug)]
pub(super) struct Winding {
    tree: Tree,
    /// By node.
    groups: Vec<Group>,
    /// In the order of the tree.
    triangles: Vec<[DVec3; 3]>,
    pub parts: Vec<u32>,
}

/// What stands for the triangles below a node. With area vectors A and centroids x:
#[derive(Debug, Clone, Copy)]
struct Group {
    /// The mean of x by area, p.
    center: DVec3,
    /// Square of FAR times the radius of a ball around the centre that holds all.
    far_squared: f64,
    area: f64,
    /// Σ A.
    sum: DVec3,
    /// Σ A (x − p)ᵀ.
    moment: DMat3,
}

/// The winding numbers around a place on a surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct WindingSides {
    /// On the side that the place's normal points to, and on the other.
    pub front: f64,
    pub back: f64,
}

impl Winding {
    /// Over triangles, each with the number of its part.
    pub fn build(triangles: &[[DVec3; 3]], parts: &[u32]) -> Self {
        let boxes: Vec<Bounds> = triangles.iter().map(|t| Bounds::of(*t)).collect();
        let tree = Tree::build(&boxes);
        let parts = tree.order.iter().map(|&item| parts[item as usize]).collect();
        let triangles: Vec<[DVec3; 3]> = tree.order.iter().map(|&item| triangles[item as usize]).collect();
        // Those below a node stand behind it.
        let mut groups = vec![Group::NOTHING; tree.nodes.len()];
        for index in (0..tree.nodes.len()).rev() {
            let node = &tree.nodes[index];
            let mut group = match node.below {
                Below::Nodes(second) => Group::joined(&[groups[index + 1], groups[second as usize]]),
                Below::Items { first, count } => {
                    let own: Vec<Group> =
                        triangles[first as usize..(first + count) as usize].iter().map(Group::of_triangle).collect();
                    Group::joined(&own)
                }
            };
            let reach = (node.bounds.max - group.center).max(group.center - node.bounds.min);
            group.far_squared = FAR * FAR * reach.length_squared();
            groups[index] = group;
        }
        Self { tree, groups, triangles, parts }
    }

    pub fn bounds(&self) -> Bounds {
        self.tree.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds)
    }

    /// The winding number around a point off the surface.
    pub fn around(&self, point: DVec3) -> f64 {
        self.sum(point, |corners, _| solid_angle(corners.map(|p| p - point)))
    }

    /// The winding numbers on both sides of a place; how far off faces may lie there depends on their part.
    pub fn beside(&self, place: &PointInPlane, allowed: impl Fn(u32) -> Allowed) -> WindingSides {
        let mut facing = 0;
        let rest = self.sum(place.point, |corners, part| match place.is_covered_by(corners, allowed(part)) {
            Some(looks_along) => {
                facing += if looks_along { 1 } else { -1 };
                0.0
            }
            None => solid_angle(corners.map(|p| p - place.point)),
        });
        let half = 0.5 * f64::from(facing);
        WindingSides { front: rest - half, back: rest + half }
    }

    /// The sum in a register: through [`Tree::walk`], whose two closures would share it, it took 6 % longer.
    #[inline]
    fn sum(&self, point: DVec3, mut of_triangle: impl FnMut(&[DVec3; 3], u32) -> f64) -> f64 {
        let mut sum = 0.0;
        let mut open = [0_u32; 64];
        let mut count = usize::from(!self.groups.is_empty());
        while count > 0 {
            count -= 1;
            let index = open[count] as usize;
            let group = &self.groups[index];
            let r = group.center - point;
            let distance_squared = r.length_squared();
            if distance_squared > group.far_squared {
                sum += group.seen_along(r, distance_squared);
                continue;
            }
            match self.tree.nodes[index].below {
                Below::Nodes(second) => {
                    (open[count], open[count + 1]) = (second, index as u32 + 1);
                    count += 2;
                }
                Below::Items { first, count } => {
                    for item in first as usize..(first + count) as usize {
                        sum += of_triangle(&self.triangles[item], self.parts[item]);
                    }
                }
            }
        }
        sum / (4.0 * PI)
    }

    /// Distance to the first face that a ray meets, and whether from behind.
    pub fn first_met(&self, origin: DVec3, direction: DVec3) -> Option<(f64, bool)> {
        let inverse = direction.recip();
        let nearest = Cell::new(f64::INFINITY);
        let mut is_from_behind = false;
        let is_met = |bounds: &Bounds| {
            let (a, b) = ((bounds.min - origin) * inverse, (bounds.max - origin) * inverse);
            // A NaN, of a ray in the plane of a side, is no bound.
            let enter = a.min(b).to_array().into_iter().fold(0.0, f64::max);
            let leave = a.max(b).to_array().into_iter().fold(nearest.get(), f64::min);
            enter <= leave * (1.0 + 1e-12)
        };
        self.tree.walk(is_met, |place| {
            if let Some((t, from_behind)) = meet(origin, direction, &self.triangles[place])
                && t > 0.0
                && t < nearest.get()
            {
                nearest.set(t);
                is_from_behind = from_behind;
            }
        });
        (nearest.get() < f64::INFINITY).then(|| (nearest.get(), is_from_behind))
    }
}

impl Group {
    const NOTHING: Self =
        Self { center: DVec3::ZERO, far_squared: 0.0, area: 0.0, sum: DVec3::ZERO, moment: DMat3::ZERO };

    fn of_triangle(&[a, b, c]: &[DVec3; 3]) -> Self {
        let sum = (b - a).cross(c - a) / 2.0;
        Self { center: (a + b + c) / 3.0, area: sum.length(), sum, ..Self::NOTHING }
    }

    fn joined(groups: &[Self]) -> Self {
        let area: f64 = groups.iter().map(|g| g.area).sum();
        // Without area, any point that is near.
        let center =
            if area > 0.0 { groups.iter().map(|g| g.center * (g.area / area)).sum() } else { groups[0].center };
        let sum = groups.iter().map(|g| g.sum).sum();
        let moment = groups.iter().fold(DMat3::ZERO, |moment, g| {
            let x = g.center - center;
            moment + g.moment + DMat3::from_cols(g.sum * x.x, g.sum * x.y, g.sum * x.z)
        });
        Self { center, area, sum, moment, ..Self::NOTHING }
    }

    /// Σ A · f(x) for f(x) = x/|x|³ about the centre, which is seen at `r`: f(r) and its derivative 1/|r|³ − 3 r rᵀ/|r|⁵.
    #[inline]
    fn seen_along(&self, r: DVec3, distance_squared: f64) -> f64 {
        let m = &self.moment;
        let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
        let along = r.dot(*m * r) / distance_squared;
        (self.sum.dot(r) + trace - 3.0 * along) / (distance_squared * distance_squared.sqrt())
    }
}

/// Solid angle of a triangle seen from the origin, positive from behind.
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let [la, lb, lc] = [a.length(), b.length(), c.length()];
    let volume = a.dot(b.cross(c));
    // In the triangle's plane it is seen edge-on, and on it from both sides at once.
    if volume == 0.0 {
        return 0.0;
    }
    2.0 * volume.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

/// Distance along the ray at which it meets a triangle, and whether from behind (Möller and Trumbore 1997).
fn meet(origin: DVec3, direction: DVec3, &[a, b, c]: &[DVec3; 3]) -> Option<(f64, bool)> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    let from_a = origin - a;
    let q = from_a.cross(ab);
    let (u, v) = (from_a.dot(p) / determinant, direction.dot(q) / determinant);
    // False for a ray in the plane, where these are not numbers.
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| (ac.dot(q) / determinant, determinant < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of 8 · 4⁵ triangles, from an octahedron.
    fn ball() -> Vec<[DVec3; 3]> {
        let corners = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        let mut triangles: Vec<[DVec3; 3]> = (0..4)
            .flat_map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 4]);
                [[a, b, DVec3::Z], [b, a, DVec3::NEG_Z]]
            })
            .collect();
        for _ in 0..5 {
            triangles = (triangles.into_iter())
                .flat_map(|[a, b, c]| {
                    let [p, q, r] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                    [[a, p, r], [b, q, p], [c, r, q], [p, q, r]]
                })
                .collect();
        }
        triangles
    }

    fn winding(triangles: &[[DVec3; 3]]) -> Winding {
        Winding::build(triangles, &vec![0; triangles.len()])
    }

    #[test]
    fn near_to_the_sum_over_all_triangles() {
        let mut triangles = ball();
        // With holes.
        triangles.retain(|t| (t[0].x * 7.0).sin() < 0.9);
        let tree = winding(&triangles);
        for k in 0..500 {
            let t = f64::from(k);
            let point =
                DVec3::new((t * 0.754_877).fract(), (t * 0.569_840).fract(), (t * 0.430_159).fract()) * 2.4 - 1.2;
            let sum: f64 = triangles.iter().map(|t| solid_angle(t.map(|p| p - point))).sum::<f64>() / (4.0 * PI);
            assert!((tree.around(point) - sum).abs() < 0.02, "{point}: {} and {sum}", tree.around(point));
        }
    }

    #[test]
    fn both_sides_of_every_face() {
        let triangles = ball();
        let tree = winding(&triangles);
        for corners in triangles.iter().step_by(37) {
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            // Off the plane by less than is allowed, to either side.
            for off in [-1e-9, 0.0, 1e-9] {
                for share in [0.1, 0.5] {
                    let point = corners[0].lerp(corners[1], share).lerp(corners[2], 0.4) + normal * off;
                    let allowed = |_| Allowed { length: 0.1, is_of_one_surface: true };
                    let sides = tree.beside(&PointInPlane::new(point, normal, DVec3::ZERO), allowed);
                    assert!(sides.front.abs() < 0.01 && (sides.back - 1.0).abs() < 0.01, "{sides:?}");
                    // Asked about by another surface, which looks the other way.
                    let allowed = |_| Allowed { length: 0.1, is_of_one_surface: false };
                    let turned = tree.beside(&PointInPlane::new(point, -normal, DVec3::ZERO), allowed);
                    assert!(turned.back.abs() < 0.01 && (turned.front - 1.0).abs() < 0.01, "{turned:?}");
                }
            }
        }
    }

    /// A point on the common edge of two faces in one plane lies on exactly one of them.
    #[test]
    fn on_an_edge_in_the_plane() {
        let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.3));
        let allowed = Allowed { length: 1.0, is_of_one_surface: false };
        for normal in [DVec3::Z, DVec3::NEG_Z] {
            for share in [0.25, 0.5, 0.7] {
                let place = PointInPlane::new(a.lerp(c, share), normal, DVec3::ONE);
                let covers = [[a, b, c], [a, c, d]].map(|t| place.is_covered_by(&t, allowed).is_some());
                assert_ne!(covers[0], covers[1], "{share}");
            }
        }
    }

    /// A plate thinner than contact is a plate; two bodies that near are one.
    #[test]
    fn the_other_side_of_something_thin() {
        let under = [DVec3::ZERO, DVec3::Y, DVec3::X].map(|p| p - DVec3::Z * 1e-8);
        let place = PointInPlane::new(DVec3::new(0.2, 0.2, 0.0), DVec3::Z, DVec3::ZERO);
        let covers = |is_of_one_surface| place.is_covered_by(&under, Allowed { length: 1.0, is_of_one_surface });
        assert_eq!([covers(false), covers(true)], [Some(false), None]);
    }

    #[test]
    fn rays_meet_the_near_side_first() {
        let tree = winding(&ball());
        for k in 0..50 {
            let t = f64::from(k);
            let direction = DVec3::new(t.sin(), (1.3 * t).cos(), (0.7 * t).sin() + 0.1).normalize();
            let (t, from_behind) = tree.first_met(DVec3::ZERO, direction).unwrap();
            assert!(from_behind && (0.99..=1.0).contains(&t));
            let (t, from_behind) = tree.first_met(direction * -3.0, direction).unwrap();
            assert!(!from_behind && (2.0..2.01).contains(&t));
            assert_eq!(tree.first_met(direction * 3.0, direction), None);
        }
    }
}
