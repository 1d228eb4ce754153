//! Where light must go to make a caustic: towards what refracts and what mirrors.
//!
//! A small lamp shines all around, and the sun on everything. Of subpaths that begin as the light is spread, few meet a glass on a table. So half of
//! them are aimed at the spheres around refractors and mirrors; densities are those of both ways together, so nothing is missed.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::scatter::frame;
use crate::scene::{Scene, Surface};

/// Share of the subpaths that are aimed.
pub const SHARE: f64 = 0.5;
/// More objects than these are aimed at as one.
const MOST_SPHERES: usize = 24;

/// What is aimed at.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Aims {
    spheres: Vec<Sphere>,
    /// Of the discs as which all spheres are seen from afar, together.
    area: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Sphere {
    center: DVec3,
    radius: f64,
}

impl Aims {
    pub fn of(scene: &Scene) -> Self {
        let is_aimed_at = |surface: &Surface| matches!(surface, Surface::Refractor { .. } | Surface::Mirror { .. });
        let bounds: Vec<(DVec3, DVec3)> = (0..scene.objects.len())
            .filter(|&object| is_aimed_at(&scene.objects[object].surface))
            .map(|object| scene.geometry.bounds_of(object as u32))
            .collect();
        let around =
            |&(min, max): &(DVec3, DVec3)| Sphere { center: (min + max) / 2.0, radius: (max - min).length() / 2.0 };
        let spheres: Vec<Sphere> = if bounds.len() > MOST_SPHERES {
            let all = bounds.iter().copied().reduce(|(min, max), (a, b)| (min.min(a), max.max(b)));
            all.iter().map(around).collect()
        } else {
            bounds.iter().map(around).collect()
        };
        Self::at(spheres.into_iter().filter(|sphere| sphere.radius > 0.0 && sphere.radius.is_finite()).collect())
    }

    fn at(spheres: Vec<Sphere>) -> Self {
        let area = spheres.iter().map(|sphere| PI * sphere.radius * sphere.radius).sum();
        Self { spheres, area }
    }

    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty()
    }

    /// A direction from a place towards one of the spheres, for numbers uniform in [0, 1). `None` where the one that was chosen is around the place:
    /// then every way leads into it.
    pub fn sample_direction(&self, from: DVec3, select: f64, u: [f64; 2]) -> Option<DVec3> {
        let index = (select * self.spheres.len() as f64) as usize;
        let sphere = self.spheres.get(index.min(self.spheres.len().checked_sub(1)?))?;
        let most = sphere.one_minus_cosine(from)?;
        let one_minus_cosine = u[0] * most;
        let sine = (one_minus_cosine * (2.0 - one_minus_cosine)).sqrt();
        let axis = (sphere.center - from).normalize();
        let (tangent, bitangent) = frame(axis);
        let (sin, cos) = (TAU * u[1]).sin_cos();
        Some((axis * (1.0 - one_minus_cosine) + (tangent * cos + bitangent * sin) * sine).normalize())
    }

    /// Density per steradian of [`Self::sample_direction`], and the probability that it gives none.
    pub fn pdf_direction(&self, from: DVec3, direction: DVec3) -> (f64, f64) {
        let each = 1.0 / self.spheres.len().max(1) as f64;
        self.spheres.iter().fold((0.0, 0.0), |(density, none), sphere| match sphere.one_minus_cosine(from) {
            None => (density, none + each),
            Some(most) => {
                let cosine = direction.dot((sphere.center - from).normalize());
                let is_inside = 1.0 - cosine <= most;
                (density + if is_inside { each / (TAU * most) } else { 0.0 }, none)
            }
        })
    }

    /// A point of one of the discs as which the spheres are seen along unit `direction`, for numbers uniform in [0, 1). `None` where there are none.
    pub fn sample_place(&self, direction: DVec3, select: f64, u: [f64; 2]) -> Option<DVec3> {
        let mut left = select * self.area;
        let chosen = self.spheres.iter().find(|sphere| {
            left -= PI * sphere.radius * sphere.radius;
            left < 0.0
        });
        let Sphere { center, radius } = chosen.or(self.spheres.last())?;
        let (tangent, bitangent) = frame(direction);
        let (sin, cos) = (TAU * u[1]).sin_cos();
        Some(*center + (tangent * cos + bitangent * sin) * (radius * u[0].sqrt()))
    }

    /// Density per area across unit `direction` with which [`Self::sample_place`] gives a point of the line through `place`.
    pub fn pdf_place(&self, place: DVec3, direction: DVec3) -> f64 {
        let is_hit = |sphere: &&Sphere| {
            let to_center = sphere.center - place;
            let across = to_center - direction * to_center.dot(direction);
            across.length_squared() <= sphere.radius * sphere.radius
        };
        self.spheres.iter().filter(is_hit).count() as f64 / self.area
    }
}

impl Sphere {
    /// 1 − cos of the half angle under which it is seen, without cancellation; `None` from inside.
    fn one_minus_cosine(&self, from: DVec3) -> Option<f64> {
        let distance = self.center.distance(from);
        (distance > self.radius).then(|| {
            let sine_squared = (self.radius / distance).powi(2);
            sine_squared / (1.0 + (1.0 - sine_squared).sqrt())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::uniform_direction;

    fn aims() -> Aims {
        let sphere = |center: [f64; 3], radius| Sphere { center: center.into(), radius };
        Aims::at(vec![sphere([2.0, 0.0, 0.0], 0.7), sphere([2.5, 0.5, 0.0], 0.9), sphere([0.0, -3.0, 1.0], 1.5)])
    }

    fn numbers(index: u32) -> [f64; 3] {
        [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|step| (f64::from(index) * step + 0.5).fract())
    }

    /// Densities integrate to 1 over all that is given, and what is given has a density.
    #[test]
    fn densities_are_those_of_the_samples() {
        let aims = aims();
        let count = 400_000;
        for from in [DVec3::ZERO, DVec3::new(0.5, -2.5, 1.5), DVec3::new(2.2, 0.3, 0.0)] {
            let (mut integral, mut none, mut given) = (0.0, 0.0, 0);
            for index in 0..count {
                let [select, u, v] = numbers(index);
                let (density, of_none) = aims.pdf_direction(from, uniform_direction([u, v]));
                integral += density * 4.0 * PI / f64::from(count);
                none = of_none;
                if let Some(direction) = aims.sample_direction(from, select, [u, v]) {
                    given += 1;
                    assert!(aims.pdf_direction(from, direction * (1.0 - 1e-15)).0 > 0.0);
                }
            }
            assert!((integral + none - 1.0).abs() < 1e-2, "{from}: {integral} and {none}");
            assert!((f64::from(given) / f64::from(count) - (1.0 - none)).abs() < 1e-3, "{from}: {given}");
        }
        // Each sample's share of the density's inverse is the area that it stands for: of the discs together, without what they share.
        let direction = DVec3::new(0.3, -0.8, 0.5).normalize();
        let (mut covered, mut hit) = (0.0, 0.0);
        let (tangent, bitangent) = frame(direction);
        for index in 0..count {
            let [select, u, v] = numbers(index);
            let place = aims.sample_place(direction, select, [u, v]).unwrap() + direction * 7.0;
            covered += 1.0 / (aims.pdf_place(place, direction) * f64::from(count));
            let at = (tangent * (u - 0.5) + bitangent * (v - 0.5)) * 20.0;
            hit += if aims.pdf_place(at, direction) > 0.0 { 400.0 / f64::from(count) } else { 0.0 };
        }
        assert!((covered / hit - 1.0).abs() < 2e-2, "{covered} {hit}");
    }

    #[test]
    fn nothing_to_aim_at() {
        let aims = Aims::default();
        assert!(aims.is_empty() && aims.sample_direction(DVec3::ZERO, 0.5, [0.5; 2]).is_none());
        assert!(aims.sample_place(DVec3::Y, 0.5, [0.5; 2]).is_none());
    }
}
