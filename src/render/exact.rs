//! Sums of samples that do not depend on the order in which they are added, nor on how they are divided among machines.
//!
//! Sums of floating-point numbers depend on both, by rounding. Here each sample is rounded once, to a multiple of a unit that the scene
//! decides, and multiples are added as integers of 128 bits: addition is exact, so it is associative. The unit is 2⁻⁶⁴ of about the brightest
//! radiance that the scene emits, some 5e-20 of it, far below what f64 holds of it; above are 2³¹ times that radiance for
//! each of 2³² samples, more than any path carries. A sample beyond that is counted as not finite.

use glam::DVec3;

use crate::scene::Description;
use crate::scene::description::{Environment, Light, MAX_RADIANCE, Object, Quantity, Shape};

/// The unit stands so many powers of two below the brightest radiance.
const BELOW_BRIGHTEST: i32 = 64;
/// A sample has fewer units than two to the power of this.
pub const MOST_BITS: i32 = 95;
/// Radiance of 2 to the power of this is taken for the dimmest that a scene can emit, so that units and their inverses are normal numbers.
const DIMMEST: i32 = -900;

/// Sums of radiance per pixel, linear RGB.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactSums {
    /// The unit is 2 to the power of this.
    pub unit_exponent: i32,
    /// In units.
    pub sums: Vec<[i128; 3]>,
}

/// The exponent of the unit for sums of a scene's samples.
pub fn unit_exponent(description: &Description) -> i32 {
    let mut brightest = 0.0_f64;
    let mut see = |rgb: [f64; 3]| brightest = rgb.into_iter().fold(brightest, f64::max);
    match &description.environment {
        Environment::Color(color) => see(*color),
        Environment::Gradient { zenith, horizon, nadir } => [zenith, horizon, nadir].into_iter().for_each(|c| see(*c)),
        Environment::Image { image, scale, .. } => {
            image.pixels.iter().for_each(|pixel| see(pixel.map(|component| f64::from(component) * scale)));
        }
    }
    let lights = || description.objects.iter().filter_map(|object| Some((object, object.light()?)));
    let is_plain = |light: &Light| light.emission.quantity == Quantity::Radiance;
    // What a light at a point makes of the nearest things can only be guessed at: they may be as near to it as the smallest object is large.
    let nearest = if lights().all(|(_, light)| is_plain(light)) { 1.0 } else { smallest(description) };
    for (object, light) in lights() {
        let factor = per_radiance(object, light.emission.quantity, nearest);
        see(light.emission.rgb.map(|x| (x * factor).min(MAX_RADIANCE)));
    }
    // The exponent field of an f64, which is exact where a logarithm rounds.
    let exponent = ((brightest.to_bits() >> 52) & 0x7FF) as i32 - 1023;
    let exponent = if brightest == 0.0 { 0 } else { exponent };
    exponent.clamp(DIMMEST, 1023) - BELOW_BRIGHTEST
}

/// By what to multiply what a light is measured by to have about the radiance that it makes. By multiplications and divisions alone, which round alike
/// everywhere.
fn per_radiance(object: &Object, quantity: Quantity, nearest: f64) -> f64 {
    let half_angle = |degrees: f64| degrees * (std::f64::consts::PI / 180.0);
    let squared = |x: f64| x * x;
    match (quantity, &object.shape) {
        (Quantity::Irradiance, Shape::Directional { angle, .. }) if *angle > 0.0 => {
            1.0 / squared(half_angle(0.5 * angle))
        }
        (Quantity::Intensity, _) => 1.0 / squared(nearest),
        (Quantity::Power, Shape::Spot { outer_angle, .. }) => 1.0 / squared(half_angle(*outer_angle) * nearest),
        (Quantity::Power, Shape::Point { .. }) => 1.0 / squared(nearest),
        (Quantity::Power, _) => 1.0 / squared(size(object)),
        (Quantity::Radiance | Quantity::Irradiance, _) => 1.0,
    }
}

/// The longest side of an object's box before it is turned; some length where it has none.
fn size(object: &Object) -> f64 {
    let (min, max) = object.shape.bounds();
    let size = (max - min).abs().max_element() * object.transform.scale.abs().max_element();
    if size > 0.0 && size.is_finite() { size } else { 1.0 }
}

/// The least size of an object that can be met.
fn smallest(description: &Description) -> f64 {
    let solid = description.objects.iter().filter(|object| object.visible && object.shape.has_surface());
    solid.map(size).reduce(f64::min).unwrap_or(1.0)
}

/// 2 to that power, from −1022 to 1023, by its bits: library functions may round.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023).clamp(0, 2046) as u64) << 52)
}

impl ExactSums {
    pub fn new(pixels: usize, unit_exponent: i32) -> Self {
        Self { unit_exponent, sums: vec![[0; 3]; pixels] }
    }

    /// Adds a sample to a pixel, unless it is not finite or too large: then nothing happens and the answer is `false`.
    pub(super) fn add(&mut self, pixel: usize, radiance: DVec3) -> bool {
        ExactRow { per_unit: power_of_two(-self.unit_exponent), sums: &mut self.sums }.add(pixel, radiance)
    }

    /// Rows of an image of that width.
    pub(super) fn rows(&mut self, width: usize) -> impl Iterator<Item = ExactRow<'_>> {
        let per_unit = power_of_two(-self.unit_exponent);
        self.sums.chunks_mut(width).map(move |sums| ExactRow { per_unit, sums })
    }

    /// Mean radiance of a pixel of `count` samples; black where there are none.
    pub fn mean(&self, pixel: usize, count: u32) -> [f64; 3] {
        let unit = power_of_two(self.unit_exponent);
        self.sums[pixel].map(|sum| sum as f64 * unit / f64::from(count.max(1)))
    }
}

/// A row of an image, to be added to.
pub(super) struct ExactRow<'a> {
    per_unit: f64,
    sums: &'a mut [[i128; 3]],
}

impl ExactRow<'_> {
    /// Adds a sample, unless it is not finite or too large: then nothing happens and the answer is `false`.
    #[inline]
    pub fn add(&mut self, column: usize, radiance: DVec3) -> bool {
        let units = radiance * self.per_unit;
        // False for NaN too.
        let can_be_added = units.abs().max_element() < power_of_two(MOST_BITS) && units.is_finite();
        if can_be_added {
            let sums = &mut self.sums[column];
            for (sum, units) in sums.iter_mut().zip(units.to_array()) {
                *sum += units.round_ties_even() as i128;
            }
        }
        can_be_added
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats;

    fn total(unit_exponent: i32, samples: impl Iterator<Item = f64>) -> i128 {
        let mut sums = ExactSums::new(1, unit_exponent);
        for sample in samples {
            assert!(sums.rows(1).next().unwrap().add(0, DVec3::splat(sample)));
        }
        sums.sums[0][1]
    }

    /// Eighteen decades of radiance, in which a sum in f64 depends on the order.
    fn samples() -> Vec<f64> {
        (0..1000_u32).map(|i| f64::from(i.wrapping_mul(2_654_435_761) % 1000) * 0.1_f64.powi(i as i32 % 18)).collect()
    }

    #[test]
    fn the_order_does_not_matter() {
        let samples = samples();
        let forwards = total(-64, samples.iter().copied());
        let backwards = total(-64, samples.iter().rev().copied());
        let in_parts = samples.chunks(7).rev().map(|part| total(-64, part.iter().copied())).sum::<i128>();
        assert_eq!([backwards, in_parts], [forwards; 2]);
        let in_floats: f64 = samples.iter().sum();
        assert!((forwards as f64 * power_of_two(-64) / in_floats - 1.0).abs() < 1e-13);
        // The twin: in f64 it does.
        assert_ne!(in_floats, samples.iter().rev().sum::<f64>());
    }

    #[test]
    fn what_cannot_be_added_is_left_out() {
        let mut sums = ExactSums::new(2, -64);
        let mut row = sums.rows(2).next().unwrap();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0_f64.powi(31), f64::MAX] {
            assert!(!row.add(1, DVec3::new(1.0, bad, 1.0)), "{bad}");
        }
        assert!(row.add(1, DVec3::splat(2.0_f64.powi(31).next_down())));
        assert!(row.add(0, DVec3::new(0.25, 0.0, 3.0)));
        assert_eq!(sums.mean(0, 2), [0.125, 0.0, 1.5]);
        assert_eq!(sums.mean(0, 0), [0.25, 0.0, 3.0]);
    }

    #[test]
    fn the_unit_follows_the_brightest_light() {
        let mut scene = formats::open("plain-glass").unwrap();
        scene.objects.clear(crate::scene::description::Kind::Light);
        for (brightest, exponent) in [(1.0, 0), (1.99, 0), (2.0, 1), (1e6, 19), (0.3, -2), (0.0, 0), (1e-320, -900)] {
            scene.environment = Environment::Color([0.0, brightest, 0.0]);
            assert_eq!(unit_exponent(&scene), exponent - 64, "{brightest}");
        }
        // A light at a point may light something as near as the smallest object is large; a sun is as bright as its disc is small; power is
        // spread over a surface.
        scene.environment = Environment::Color([0.0; 3]);
        scene.objects.clear(crate::scene::description::Kind::Refractor);
        let shape = Shape::Sphere { center: glam::DVec3::ZERO, radius: 0.125 };
        let solid = crate::scene::description::Solid::of(crate::scene::description::Paint::Color([0.5; 3]));
        scene.objects.clear(crate::scene::description::Kind::Solid);
        scene.objects.push(Object::new("ball", shape.clone(), solid));
        let sun = |angle| Shape::Directional { direction: glam::DVec3::NEG_Y, angle };
        for (shape, quantity, least, most) in [
            (Shape::Point { position: glam::DVec3::Y }, Quantity::Intensity, 4, 4),
            (Shape::Point { position: glam::DVec3::Y }, Quantity::Power, 4, 4),
            (sun(0.0), Quantity::Irradiance, 0, 0),
            (sun(0.53), Quantity::Irradiance, 13, 16),
            (shape, Quantity::Power, 3, 5),
        ] {
            scene.objects.clear(crate::scene::description::Kind::Light);
            scene.objects.push(Object::new("lamp", shape, Light::of(quantity, [1.0; 3])));
            let exponent = unit_exponent(&scene) + 64;
            assert!((least..=most).contains(&exponent), "{quantity:?}: {exponent}");
        }
        for exponent in [unit_exponent(&scene), 959] {
            assert!(power_of_two(exponent).is_normal() && power_of_two(-exponent).is_normal());
        }
    }
}
