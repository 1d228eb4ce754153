//! Profiles of vessels to begin with: outlines in the (r, y) half-plane, to be revolved about the y axis.

use glam::DVec2;

use crate::app::objects::{decade, rounded};

/// Points of an arc that rounds a corner.
const ARC_STEPS: u32 = 6;

/// A vessel to begin with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vessel {
    /// Also the name of a new object.
    pub name: &'static str,
    /// (r, y) of the corners and the radius that each is rounded with; the height is about 1. From the middle of the underside around the rim
    /// to the middle of the inside.
    corners: &'static [[f64; 3]],
}

pub const TUMBLER: Vessel = Vessel {
    name: "tumbler",
    corners: &[
        [0.0, 0.0, 0.0],
        [0.4, 0.0, 0.03],
        [0.5, 1.0, 0.016],
        [0.462, 1.0, 0.016],
        [0.365, 0.1, 0.07],
        [0.0, 0.1, 0.0],
    ],
};

pub const WINE_GLASS: Vessel = Vessel {
    name: "wine glass",
    corners: &[
        [0.0, 0.0, 0.0],
        [0.3, 0.0, 0.007],
        [0.3, 0.016, 0.007],
        [0.05, 0.04, 0.05],
        [0.026, 0.12, 0.05],
        [0.026, 0.4, 0.08],
        [0.25, 0.46, 0.12],
        [0.34, 0.66, 0.2],
        [0.25, 1.0, 0.006],
        [0.235, 1.0, 0.006],
        [0.322, 0.66, 0.19],
        [0.235, 0.475, 0.11],
        [0.0, 0.425, 0.0],
    ],
};

pub const BEAKER: Vessel = Vessel {
    name: "beaker",
    corners: &[
        [0.0, 0.0, 0.0],
        [0.4, 0.0, 0.06],
        [0.4, 0.95, 0.05],
        [0.44, 0.99, 0.007],
        [0.425, 1.0, 0.007],
        [0.375, 0.95, 0.05],
        [0.375, 0.025, 0.05],
        [0.0, 0.025, 0.0],
    ],
};

pub const BOTTLE: Vessel = Vessel {
    name: "bottle",
    corners: &[
        [0.0, 0.0, 0.0],
        [0.2, 0.0, 0.03],
        [0.2, 0.58, 0.12],
        [0.07, 0.76, 0.1],
        [0.07, 1.0, 0.008],
        [0.05, 1.0, 0.008],
        [0.05, 0.754, 0.11],
        [0.18, 0.574, 0.11],
        [0.18, 0.03, 0.025],
        [0.0, 0.03, 0.0],
    ],
};

pub const BOWL: Vessel = Vessel {
    name: "bowl",
    corners: &[
        [0.0, 0.0, 0.0],
        [0.45, 0.0, 0.02],
        [0.85, 0.4, 0.35],
        [0.95, 0.9, 0.015],
        [0.912, 0.9, 0.015],
        [0.813, 0.42, 0.33],
        [0.44, 0.05, 0.3],
        [0.0, 0.05, 0.0],
    ],
};

impl Vessel {
    pub const ALL: [Self; 5] = [TUMBLER, WINE_GLASS, BEAKER, BOTTLE, BOWL];

    /// The profile of a vessel of that height, as short numbers.
    pub fn profile(&self, height: f64) -> Vec<[f64; 2]> {
        let points = self.rounded();
        let top = points.iter().fold(0.0, |top: f64, p| top.max(p.y));
        let scale = height / top;
        let step = decade(height) * 1e-4;
        let short = |x: f64| rounded(x * scale, step);
        let mut profile: Vec<[f64; 2]> = points.into_iter().map(|p| [short(p.x), short(p.y)]).collect();
        profile.dedup();
        profile
    }

    /// The outline with its corners rounded by arcs.
    fn rounded(&self) -> Vec<DVec2> {
        let at = |i: usize| DVec2::new(self.corners[i][0], self.corners[i][1]);
        let mut points = vec![at(0)];
        for i in 1..self.corners.len() - 1 {
            let (corner, radius) = (at(i), self.corners[i][2]);
            let [before, after] = [at(i - 1), at(i + 1)].map(|other| (other - corner).normalize());
            // From the corner to where the arc begins, along either side.
            let half_angle = 0.5 * before.dot(after).clamp(-1.0, 1.0).acos();
            let length = radius / half_angle.tan();
            let middle = corner + (before + after).normalize() * (radius / half_angle.sin());
            let [start, end] = [before, after].map(|side| corner + side * length - middle);
            let turn = start.angle_to(end);
            points.extend((0..=ARC_STEPS).map(|k| {
                let angle = turn * f64::from(k) / f64::from(ARC_STEPS);
                middle + DVec2::from_angle(angle).rotate(start)
            }));
        }
        points.push(at(self.corners.len() - 1));
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::Shape;
    use crate::scene::shapes::validate;

    #[test]
    fn every_vessel_is_a_solid_of_any_size() {
        for vessel in Vessel::ALL {
            for height in [0.003, 0.4, 1.0, 73.0, 1e6] {
                let profile = vessel.profile(height);
                let shape = Shape::Lathe { profile, segments: 8 };
                validate(&shape).unwrap_or_else(|fault| panic!("{} of {height}: {fault}", vessel.name));
                let (min, max) = shape.bounds();
                assert!((max.y - min.y - height).abs() < 2e-3 * height, "{} of {height}", vessel.name);
            }
        }
    }

    /// A corner is cut off and nothing else: the arc is tangent to both sides.
    #[test]
    fn corners_are_rounded_smoothly() {
        let points = TUMBLER.rounded();
        let turns = points.windows(3).map(|p| (p[1] - p[0]).angle_to(p[2] - p[1]).to_degrees().abs());
        assert!(turns.clone().all(|turn| turn < 40.0), "{:?}", turns.collect::<Vec<_>>());
    }
}
