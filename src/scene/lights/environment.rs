//! Light from all around: constant, gradient, or an image that is importance sampled.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::directional::coming_in;
use super::sample::{DirectSample, EmittedRay, Target};
use crate::geometry::sphere::Sphere;
use crate::geometry::uniform_direction;
use crate::scene::description::Environment;
use crate::scene::environment::EnvironmentImage;
use crate::spectrum::Spectrum;

/// The environment, ready to be looked up and sampled.
#[derive(Debug, Clone)]
pub enum EnvironmentLight {
    Constant(Spectrum),
    Gradient { zenith: Spectrum, horizon: Spectrum, nadir: Spectrum },
    Image(Arc<ImageLight>),
}

/// An image environment with its sampling tables.
#[derive(Debug)]
pub struct ImageLight {
    image: Arc<EnvironmentImage>,
    /// sin and cos of the rotation about +y.
    rotation: (f64, f64),
    scale: f64,
    /// Running sums of the weights of each row's texels, each row from 0 to 1.
    columns: Vec<f32>,
    guide: Guide,
    /// Running sums of the rows' weights, from 0 to 1.
    rows: Vec<f64>,
    /// ∫ of the radiance over all directions, summed over the bands.
    total: f64,
}

/// Where in a row the search for a column begins: one cut for some columns each, so that a search touches few of the row's numbers (Chen and
/// Asau 1974, *On Generating Random Variates from an Empirical Distribution*).
#[derive(Debug)]
struct Guide {
    /// A power of two, so that its multiples are exact.
    cuts_per_row: usize,
    /// For each row, and each k from 0 to `cuts_per_row`, the first column whose running sum is above k / `cuts_per_row`.
    cuts: Vec<u32>,
}

impl Guide {
    const COLUMNS_PER_CUT: usize = 16;

    fn new(columns: &[f32], width: usize) -> Self {
        let cuts_per_row = (width / Self::COLUMNS_PER_CUT).next_power_of_two();
        let cut = |sums: &[f32], k: usize| {
            let share = k as f64 / cuts_per_row as f64;
            sums.partition_point(|&sum| f64::from(sum) <= share) as u32
        };
        let of_row = |sums| (0..=cuts_per_row).map(move |k| cut(sums, k));
        Self { cuts_per_row, cuts: columns.par_chunks(width).flat_map_iter(of_row).collect() }
    }

    /// The first column of `row`, which has these running sums, whose sum is above `u` in [0, 1); their number where there is none.
    #[inline]
    fn find(&self, row: usize, sums: &[f32], u: f64) -> usize {
        let cuts = &self.cuts[row * (self.cuts_per_row + 1)..][..=self.cuts_per_row];
        let k = (u * self.cuts_per_row as f64) as usize;
        let (first, last) = (cuts[k] as usize, cuts[k + 1] as usize);
        first + sums[first..last].partition_point(|&sum| f64::from(sum) <= u)
    }
}

impl EnvironmentLight {
    pub fn new(environment: &Environment) -> Self {
        match environment {
            Environment::Color(color) => Self::Constant(Spectrum::from_rgb(*color)),
            Environment::Gradient { zenith, horizon, nadir } => {
                let [zenith, horizon, nadir] = [zenith, horizon, nadir].map(|rgb| Spectrum::from_rgb(*rgb));
                Self::Gradient { zenith, horizon, nadir }
            }
            Environment::Image { image, rotation, scale, .. } => {
                match ImageLight::new(Arc::clone(image), rotation.to_radians(), *scale) {
                    Some(light) => Self::Image(Arc::new(light)),
                    None => Self::Constant(Spectrum::ZERO),
                }
            }
        }
    }

    /// Whether no light comes from it.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Constant(color) => color.is_black(),
            Self::Gradient { zenith, horizon, nadir } => [zenith, horizon, nadir].into_iter().all(|c| c.is_black()),
            // An image that is black is a constant.
            Self::Image(_) => false,
        }
    }

    /// Whether there is anything to gain from sampling it: an image that is not black.
    pub fn is_image(&self) -> bool {
        matches!(self, Self::Image(_))
    }

    /// The image with its sampling tables, if it is one.
    pub fn image(&self) -> Option<&Arc<ImageLight>> {
        match self {
            Self::Image(light) => Some(light),
            _ => None,
        }
    }

    /// Radiance arriving from unit `direction`.
    #[inline]
    pub fn radiance(&self, direction: DVec3) -> Spectrum {
        match self {
            Self::Constant(color) => *color,
            Self::Gradient { zenith, horizon, nadir } => {
                let (y, end) = if direction.y >= 0.0 { (direction.y, zenith) } else { (-direction.y, nadir) };
                *horizon + (*end - *horizon) * y
            }
            Self::Image(light) => light.radiance(direction),
        }
    }

    /// Probability per steradian with which [`Self::sample`] gives `direction`; 0 where there is no image.
    #[inline]
    pub fn pdf(&self, direction: DVec3) -> f64 {
        match self {
            Self::Image(light) => light.pdf(direction),
            _ => 0.0,
        }
    }

    /// A direction for `u` uniform in [0, 1)²; `None` where there is no image.
    #[inline]
    pub fn sample(&self, u: [f64; 2]) -> Option<DirectSample> {
        let (direction, pdf) = self.sample_direction(u)?;
        let radiance = self.radiance(direction);
        Some(DirectSample { direction, pdf, radiance, is_delta: false, target: Target::Environment })
    }

    /// The same without the radiance: the direction and its density per steradian.
    #[inline]
    pub fn sample_direction(&self, u: [f64; 2]) -> Option<(DVec3, f64)> {
        match self {
            Self::Image(light) => light.sample(u),
            _ => None,
        }
    }

    /// What falls into the sphere around the scene, summed over the bands.
    pub fn power(&self, bounds: &Sphere) -> f64 {
        let over_directions = match self {
            Self::Constant(color) => 4.0 * PI * color.sum(),
            // Each half is linear in y, and so has the mean of its ends.
            Self::Gradient { zenith, horizon, nadir } => PI * (zenith.sum() + 2.0 * horizon.sum() + nadir.sum()),
            Self::Image(light) => light.total,
        };
        over_directions * PI * bounds.radius * bounds.radius
    }

    /// A ray that comes in from afar and meets the scene's bounding sphere: its direction as an image is sampled, else uniform; its start
    /// uniform on a disc across it that covers the sphere.
    pub fn sample_ray(&self, bounds: &Sphere, start: [f64; 2], direction: [f64; 2]) -> Option<EmittedRay> {
        let to_light = match self {
            Self::Image(light) => light.sample(direction)?.0,
            _ => uniform_direction(direction),
        };
        let [pdf_position, pdf_direction] = self.pdf_ray(bounds, -to_light);
        Some(EmittedRay {
            ray: coming_in(bounds, start, to_light),
            radiance: self.radiance(to_light),
            cosine: 1.0,
            pdf_position,
            pdf_direction,
            start: None,
            is_front: true,
            light: None,
        })
    }

    /// Densities of [`Self::sample_ray`], per area of the disc and per steradian, for a ray along `direction`.
    pub fn pdf_ray(&self, bounds: &Sphere, direction: DVec3) -> [f64; 2] {
        let pdf_direction = match self {
            Self::Image(light) => light.pdf(-direction),
            _ => 1.0 / (4.0 * PI),
        };
        [1.0 / (PI * bounds.radius * bounds.radius), pdf_direction]
    }
}

/// What an image is looked up and sampled by, as a GPU is given it.
#[derive(Debug, Clone, Copy)]
pub struct ImageTables<'a> {
    pub image: &'a EnvironmentImage,
    /// sin and cos of the rotation about +y.
    pub rotation: (f64, f64),
    pub scale: f64,
    /// Running sums of the weights of each row's texels, each row from 0 to 1.
    pub columns: &'a [f32],
    /// Running sums of the rows' weights, from 0 to 1.
    pub rows: &'a [f64],
    pub cuts_per_row: usize,
    /// For each row, and each k from 0 to `cuts_per_row`, the first column whose running sum is above k / `cuts_per_row`.
    pub cuts: &'a [u32],
}

impl ImageLight {
    pub fn tables(&self) -> ImageTables<'_> {
        ImageTables {
            image: &self.image,
            rotation: self.rotation,
            scale: self.scale,
            columns: &self.columns,
            rows: &self.rows,
            cuts_per_row: self.guide.cuts_per_row,
            cuts: &self.guide.cuts,
        }
    }

    /// `None` when the image is black or `scale` is 0: there is nothing to look up.
    fn new(image: Arc<EnvironmentImage>, rotation: f64, scale: f64) -> Option<Self> {
        let (width, height) = (image.width, image.height);
        let mut columns = vec![0.0; width * height];
        let weights: Vec<f64> = (columns.par_chunks_mut(width).enumerate())
            .map(|(row, columns)| {
                let mut sum = 0.0;
                let sums: Vec<f64> = (0..width)
                    .map(|column| {
                        sum += mean_luminance(&image, row, column);
                        sum
                    })
                    .collect();
                if sum > 0.0 {
                    columns.iter_mut().zip(sums).for_each(|(column, s)| *column = (s / sum) as f32);
                }
                sum
            })
            .collect();
        let mut rows = Vec::with_capacity(height);
        let mut total = 0.0;
        let sine = |row: usize| (PI * (row as f64 + 0.5) / height as f64).sin();
        for (row, weight) in weights.into_iter().enumerate() {
            total += weight * sine(row);
            rows.push(total);
        }
        let of_rows: Vec<f64> = (image.pixels.par_chunks(width).enumerate())
            .map(|(row, pixels)| sine(row) * pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>())
            .collect();
        let all = scale * of_rows.iter().sum::<f64>() * 2.0 * PI * PI / (width * height) as f64;
        if total.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) || scale == 0.0 {
            return None;
        }
        rows.iter_mut().for_each(|r| *r /= total);
        let guide = Guide::new(&columns, width);
        Some(Self { image, rotation: rotation.sin_cos(), scale, columns, guide, rows, total: all })
    }

    /// (u, v) of a direction in scene coordinates.
    #[inline]
    fn uv(&self, d: DVec3) -> (f64, f64) {
        let (sin, cos) = self.rotation;
        // Back by the rotation: counter-clockwise seen from above takes +x towards −z.
        let (x, z) = (d.x * cos - d.z * sin, d.x * sin + d.z * cos);
        let u = 0.5 + x.atan2(-z) / TAU;
        let v = d.y.clamp(-1.0, 1.0).acos() / PI;
        (u, v)
    }

    /// Bilinear between texel centres; wraps around in u.
    #[inline]
    fn radiance(&self, direction: DVec3) -> Spectrum {
        let (width, height) = (self.image.width, self.image.height);
        let (u, v) = self.uv(direction);
        let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let column = |offset: i64| (x.floor() as i64 + offset).rem_euclid(width as i64) as usize;
        let row = |offset: i64| (y.floor() as i64 + offset).clamp(0, height as i64 - 1) as usize;
        let texel = |i, j| Spectrum::from_rgb(self.image.pixels[row(j) * width + column(i)].map(f64::from));
        let top = texel(0, 0) * (1.0 - fx) + texel(1, 0) * fx;
        let bottom = texel(0, 1) * (1.0 - fx) + texel(1, 1) * fx;
        (top * (1.0 - fy) + bottom * fy) * self.scale
    }

    #[inline]
    fn pdf(&self, direction: DVec3) -> f64 {
        let (width, height) = (self.image.width, self.image.height);
        let (u, v) = self.uv(direction);
        let row = ((v * height as f64) as usize).min(height - 1);
        let column = ((u * width as f64) as usize).min(width - 1);
        let sine = (1.0 - direction.y * direction.y).max(0.0).sqrt();
        if sine == 0.0 {
            return 0.0;
        }
        self.texel_probability(row, column) * (width * height) as f64 / (2.0 * PI * PI * sine)
    }

    /// Probability of a texel.
    #[inline]
    fn texel_probability(&self, row: usize, column: usize) -> f64 {
        let sums = &self.columns[row * self.image.width..][..self.image.width];
        let before = if column > 0 { sums[column - 1] } else { 0.0 };
        let row_before = if row > 0 { self.rows[row - 1] } else { 0.0 };
        f64::from(sums[column] - before) * (self.rows[row] - row_before)
    }

    #[inline]
    fn sample(&self, u: [f64; 2]) -> Option<(DVec3, f64)> {
        let (width, height) = (self.image.width, self.image.height);
        let row = self.rows.partition_point(|&sum| sum <= u[1]).min(height - 1);
        let row_before = if row > 0 { self.rows[row - 1] } else { 0.0 };
        let sums = &self.columns[row * width..][..width];
        let column = self.guide.find(row, sums, u[0]).min(width - 1);
        let before = if column > 0 { f64::from(sums[column - 1]) } else { 0.0 };
        // Where inside the texel: what is left of the random numbers.
        let dx = ((u[0] - before) / (f64::from(sums[column]) - before)).clamp(0.0, 1.0);
        let dy = ((u[1] - row_before) / (self.rows[row] - row_before)).clamp(0.0, 1.0);
        let phi = ((column as f64 + dx) / width as f64 - 0.5) * TAU;
        let theta = (row as f64 + dy) / height as f64 * PI;
        let (x, z) = (theta.sin() * phi.sin(), -theta.sin() * phi.cos());
        let (sin, cos) = self.rotation;
        let direction = DVec3::new(x * cos + z * sin, theta.cos(), z * cos - x * sin);
        let sine = theta.sin();
        let pdf = self.texel_probability(row, column) * (width * height) as f64 / (2.0 * PI * PI * sine);
        (pdf > 0.0 && pdf.is_finite()).then_some((direction, pdf))
    }
}

/// Mean luminance over a texel of the picture as it is looked up, bilinear between texel centres: next to a sun a texel has a share of
/// it, and must be sampled for that.
fn mean_luminance(image: &EnvironmentImage, row: usize, column: usize) -> f64 {
    const WEIGHTS: [f64; 3] = [1.0 / 8.0, 6.0 / 8.0, 1.0 / 8.0];
    let mut sum = 0.0;
    for (j, down) in WEIGHTS.into_iter().enumerate() {
        let row = (row + j).saturating_sub(1).min(image.height - 1);
        for (i, across) in WEIGHTS.into_iter().enumerate() {
            let column = (column + i + image.width - 1) % image.width;
            sum += down * across * luminance(image.pixels[row * image.width + column]);
        }
    }
    sum
}

fn luminance(rgb: [f32; 3]) -> f64 {
    0.2126 * f64::from(rgb[0]) + 0.7152 * f64::from(rgb[1]) + 0.0722 * f64::from(rgb[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(rotation_degrees: f64) -> ImageLight {
        // 8×4: one bright texel on a dim, uneven ground.
        let pixels = (0..32).map(|i| if i == 11 { [50.0, 40.0, 30.0] } else { [0.1 * (i % 5) as f32; 3] }).collect();
        let image = EnvironmentImage { width: 8, height: 4, pixels, notes: Vec::new() };
        ImageLight::new(Arc::new(image), rotation_degrees.to_radians(), 2.0).unwrap()
    }

    /// Also where a row is black, and where a few columns have all of its light.
    #[test]
    fn the_guide_finds_what_a_search_of_the_row_finds() {
        for width in [1, 2, 7, 64, 100] {
            let row = |weight: fn(usize) -> f32| {
                let weights: Vec<f32> = (0..width).map(weight).collect();
                let total: f32 = weights.iter().sum::<f32>().max(f32::MIN_POSITIVE);
                weights
                    .iter()
                    .scan(0.0, move |sum, weight| {
                        *sum += weight / total;
                        Some(*sum)
                    })
                    .collect::<Vec<f32>>()
            };
            let rows = [row(|_| 1.0), row(|_| 0.0), row(|i| if i == 5 { 1e6 } else { 1.0 }), row(|i| (i % 3) as f32)];
            let guide = Guide::new(&rows.concat(), width);
            for (number, sums) in rows.iter().enumerate() {
                let edges = sums.iter().map(|sum| f64::from(*sum)).flat_map(|u| [u, u.next_down(), u.next_up()]);
                for u in (0..1000).map(|i| f64::from(i) / 1000.0).chain(edges).filter(|u| (0.0..1.0).contains(u)) {
                    let expected = sums.partition_point(|&sum| f64::from(sum) <= u);
                    assert_eq!(guide.find(number, sums, u), expected, "{width} {number} {u}");
                }
            }
        }
    }

    #[test]
    fn directions_of_the_image() {
        let light = light(0.0);
        let (u, v) = light.uv(DVec3::NEG_Z);
        assert!((u - 0.5).abs() < 1e-12 && (v - 0.5).abs() < 1e-12);
        assert!((light.uv(DVec3::X).0 - 0.75).abs() < 1e-12);
        assert!(light.uv(DVec3::Y).1.abs() < 1e-12);
    }

    /// Counter-clockwise seen from above, by 90°: what stood at −z stands at −x.
    #[test]
    fn rotation_turns_the_image_about_up() {
        let turned = light(90.0);
        assert!((turned.uv(DVec3::NEG_X).0 - 0.5).abs() < 1e-12);
    }

    #[test]
    fn sampled_directions_have_the_pdf_that_is_reported_and_it_integrates_to_one() {
        let light = light(33.0);
        let count = 400;
        let mut integral = 0.0;
        for i in 0..count {
            for j in 0..count {
                let u = [(i as f64 + 0.5) / count as f64, (j as f64 + 0.5) / count as f64];
                let (direction, pdf) = light.sample(u).unwrap();
                assert!((light.pdf(direction) / pdf - 1.0).abs() < 1e-6, "{direction} {pdf}");
                // ∫ pdf over the sphere, by uniform directions.
                let z = 1.0 - 2.0 * u[0];
                let r = (1.0 - z * z).sqrt();
                let (sin, cos) = (TAU * u[1]).sin_cos();
                integral += light.pdf(DVec3::new(r * cos, z, r * sin)) * 4.0 * PI / f64::from(count * count);
            }
        }
        assert!((integral - 1.0).abs() < 2e-2, "{integral}");
    }
}
