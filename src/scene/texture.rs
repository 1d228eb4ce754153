//! Images on surfaces.
//!
//! Texture coordinates (u, v) go from 0 to 1 over an image, u to the right and v upwards: (0, 0) is its lower left corner. Beyond it the
//! image is repeated. Colours are interpolated bilinearly between the centres of texels, in linear light.

use std::sync::{Arc, LazyLock};

use glam::{DAffine2, DMat3, DVec2, DVec3};

use super::note::LoadNote;
use crate::color::{linear_from_srgb, srgb_from_linear};
use crate::geometry::{CornerUvs, Hit, Mesh, PrimitiveId};
use crate::spectrum::Spectrum;

/// Linear light by code value of sRGB.
pub static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|value| linear_from_srgb(value as f32 / 255.0)));

/// An image as it was read, for a surface: an albedo.
#[derive(Debug, Clone)]
pub struct TextureImage {
    width: usize,
    height: usize,
    /// In sRGB, row-major, the upper row first. The fourth component is 255.
    texels: Vec<[u8; 4]>,
    mean: [f64; 3],
    /// What the file held otherwise, and was replaced, converted or passed over.
    pub notes: Vec<LoadNote>,
}

impl PartialEq for TextureImage {
    /// By what is seen.
    fn eq(&self, other: &Self) -> bool {
        (self.width, self.height) == (other.width, other.height) && self.texels == other.texels
    }
}

/// Equal to itself: an [`Arc`] of one is compared by its address first.
impl Eq for TextureImage {}

impl TextureImage {
    /// `texels` in sRGB, row-major, the upper row first.
    ///
    /// # Panics
    /// Unless there are `width` × `height` of them, and at least one.
    pub fn new(width: usize, height: usize, texels: Vec<[u8; 4]>) -> Self {
        assert!(!texels.is_empty() && width.checked_mul(height) == Some(texels.len()), "one texel for each place");
        // Counted by value: exact, whatever the order.
        let mut counts = [[0_u64; 256]; 3];
        for texel in &texels {
            (0..3).for_each(|axis| counts[axis][usize::from(texel[axis])] += 1);
        }
        let mean = counts.map(|counts| {
            let sum: f64 = counts.iter().zip(&*LINEAR).map(|(count, value)| *count as f64 * f64::from(*value)).sum();
            sum / texels.len() as f64
        });
        Self { width, height, texels, mean, notes: Vec::new() }
    }

    /// One white texel.
    pub fn blank() -> Self {
        Self::new(1, 1, vec![[255; 4]])
    }

    /// The same multiplied by a colour of components from 0 to 1.
    pub fn tinted(&self, tint: [f64; 3]) -> Self {
        let light = |texel: &[u8; 4]| [0, 1, 2].map(|k| (f64::from(LINEAR[usize::from(texel[k])]) * tint[k]) as f32);
        let pixels: Vec<[f32; 3]> = self.texels.iter().map(light).collect();
        Self::from_linear(self.width, self.height, &pixels)
    }

    /// From linear light, row-major, the upper row first; what is outside of [0, 1] is clipped, and said.
    pub fn from_linear(width: usize, height: usize, pixels: &[[f32; 3]]) -> Self {
        let mut clipped = 0;
        let mut byte = |x: f32| {
            clipped += u64::from(!(0.0..=1.0).contains(&x));
            (255.0 * srgb_from_linear(if x > 0.0 { x.min(1.0) } else { 0.0 })).round() as u8
        };
        let texels = pixels.iter().map(|pixel| [byte(pixel[0]), byte(pixel[1]), byte(pixel[2]), 255]).collect();
        let mut image = Self::new(width, height, texels);
        if clipped > 0 {
            let message = format!("{clipped} components of the texture were not between 0 and 1 and have been clipped");
            image.notes.push(LoadNote::new("clipped_texels", clipped, message));
        }
        image
    }

    pub fn width(&self) -> usize {
        self.width
    }

    pub fn height(&self) -> usize {
        self.height
    }

    /// In sRGB, row-major, the upper row first.
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }

    /// The mean of all texels, in linear light.
    pub fn mean(&self) -> [f64; 3] {
        self.mean
    }

    /// The colour at texture coordinates, in linear light.
    pub fn at(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let (columns, across) = between(u, self.width);
        let (rows, down) = between(1.0 - v, self.height);
        let row = |row: usize| {
            let [left, right] = columns.map(|column| self.texels[row * self.width + column]);
            let linear = |byte: u8| f64::from(LINEAR[usize::from(byte)]);
            [0, 1, 2].map(|k| linear(left[k]) * (1.0 - across) + linear(right[k]) * across)
        };
        let [upper, lower] = rows.map(row);
        [0, 1, 2].map(|k| upper[k] * (1.0 - down) + lower[k] * down)
    }
}

/// The two texels of `count` in a row between whose centres a coordinate is, and how far it is from the first to the second.
fn between(coordinate: f64, count: usize) -> ([usize; 2], f64) {
    let place = (coordinate - coordinate.floor()) * count as f64 - 0.5;
    // A number that is none is at the first.
    let place = if place.is_finite() { place } else { 0.0 };
    let first = place.floor();
    let wrapped = |texel: i64| texel.rem_euclid(count as i64) as usize;
    ([wrapped(first as i64), wrapped(first as i64 + 1)], place - first)
}

/// Texture coordinates by direction from the middle of something round: u is ½ towards +z and grows counter-clockwise seen from +y, v is the
/// angle from −y, as a share of half a turn.
pub fn spherical(direction: DVec3) -> [f64; 2] {
    let d = direction.normalize_or(DVec3::Z);
    [0.5 + d.x.atan2(d.z) / std::f64::consts::TAU, 0.5 + d.y.clamp(-1.0, 1.0).asin() / std::f64::consts::PI]
}

/// [`spherical`] at the corners of a small triangle: those beyond the seam go on on this side of it, and a pole has the middle of the other two.
pub fn spherical_corners(directions: [DVec3; 3]) -> CornerUvs {
    let mut uvs = directions.map(spherical);
    let is_pole = directions.map(|d| d.x.hypot(d.z) < 1e-9 * d.length());
    let most = (0..3).filter(|&k| !is_pole[k]).map(|k| uvs[k][0]).fold(0.0, f64::max);
    for k in 0..3 {
        if !is_pole[k] && most - uvs[k][0] > 0.5 {
            uvs[k][0] += 1.0;
        }
    }
    if let Some(pole) = (0..3).find(|&k| is_pole[k]) {
        uvs[pole][0] = 0.5 * (uvs[(pole + 1) % 3][0] + uvs[(pole + 2) % 3][0]);
    }
    uvs.map(|uv| uv.map(|x| x as f32))
}

/// An image on the surface of one object, as tracing looks it up.
#[derive(Debug, Clone)]
pub struct SurfaceTexture {
    pub image: Arc<TextureImage>,
    /// Multiplies the image.
    pub tint: Spectrum,
    pub coordinates: TextureCoordinates,
    /// The image's coordinates from the object's.
    pub transform: DAffine2,
}

/// Where an object has its texture coordinates.
#[derive(Debug, Clone)]
pub enum TextureCoordinates {
    /// Those of `mesh`, whose first triangle is the primitive `first`.
    Triangles {
        first: PrimitiveId,
        mesh: Arc<Mesh>,
        /// Whether the second and third corner of each triangle of the object are the third and second of the mesh.
        is_mirrored: bool,
    },
    /// Those of an analytic sphere: by direction from its centre.
    Spherical { object_from_world: DMat3 },
}

impl PartialEq for SurfaceTexture {
    /// Meshes that are not the same allocation are taken to be different.
    fn eq(&self, other: &Self) -> bool {
        use TextureCoordinates::{Spherical, Triangles};
        let is_same = match (&self.coordinates, &other.coordinates) {
            (Triangles { first, mesh, is_mirrored }, Triangles { first: f, mesh: m, is_mirrored: i }) => {
                (first, is_mirrored) == (f, i) && Arc::ptr_eq(mesh, m)
            }
            (Spherical { object_from_world: a }, Spherical { object_from_world: b }) => a == b,
            _ => false,
        };
        is_same && (self.tint, self.transform) == (other.tint, other.transform) && self.image == other.image
    }
}

impl SurfaceTexture {
    /// Coordinates in the image at the corners of one of the object's triangles; `None` of a sphere.
    pub fn corner_uvs(&self, triangle: PrimitiveId) -> Option<[DVec2; 3]> {
        let TextureCoordinates::Triangles { first, mesh, is_mirrored } = &self.coordinates else { return None };
        let [a, b, c] = *mesh.uvs.get(triangle.wrapping_sub(*first) as usize)?;
        let corners = if *is_mirrored { [a, c, b] } else { [a, b, c] };
        Some(corners.map(|uv| self.transform.transform_point2(DVec2::from(uv.map(f64::from)))))
    }

    /// Coordinates in the image at a hit of the object, whose outward normal there is `normal`.
    pub fn uv(&self, hit: &Hit, normal: DVec3) -> [f64; 2] {
        if let TextureCoordinates::Spherical { object_from_world } = &self.coordinates {
            let uv = spherical(*object_from_world * normal);
            return self.transform.transform_point2(uv.into()).to_array();
        }
        let [v, w] = hit.barycentric;
        let [a, b, c] = self.corner_uvs(hit.primitive).unwrap_or_default();
        (a * (1.0 - v - w) + b * v + c * w).to_array()
    }

    /// The albedo there. Not inlined: paths of scenes without textures have nothing of it in their loop.
    #[cold]
    #[inline(never)]
    pub fn at(&self, hit: &Hit, normal: DVec3) -> Spectrum {
        self.tint * Spectrum::from_rgb(self.image.at(self.uv(hit, normal)))
    }

    /// The mean albedo of the image.
    pub fn mean(&self) -> Spectrum {
        self.tint * Spectrum::from_rgb(self.image.mean())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two by two texels: red and green above, blue and white below.
    fn four() -> TextureImage {
        TextureImage::new(2, 2, vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]])
    }

    #[test]
    fn v_goes_up_and_texels_have_their_colours_at_their_centres() {
        let image = four();
        for (uv, color) in [
            ([0.25, 0.75], [1.0, 0.0, 0.0]),
            ([0.75, 0.75], [0.0, 1.0, 0.0]),
            ([0.25, 0.25], [0.0, 0.0, 1.0]),
            ([0.75, 0.25], [1.0, 1.0, 1.0]),
        ] {
            assert_eq!(image.at(uv), color, "{uv:?}");
            // Repeated, to the left and below too.
            assert_eq!(image.at([uv[0] + 3.0, uv[1] - 2.0]), color, "{uv:?}");
        }
        // In the middle and at the corners all four meet.
        for uv in [[0.5, 0.5], [0.0, 0.0], [1.0, 1.0], [-7.0, 0.0]] {
            assert_eq!(image.at(uv), [0.5; 3], "{uv:?}");
        }
        assert_eq!(image.mean(), [0.5; 3]);
        for wrong in [f64::NAN, f64::INFINITY, 1e300] {
            assert!(image.at([wrong, 0.5]).iter().all(|x| (0.0..=1.0).contains(x)), "{wrong}");
        }
    }

    #[test]
    fn colours_are_mixed_in_linear_light() {
        let grey = TextureImage::new(2, 1, vec![[0, 0, 0, 255], [188, 188, 188, 255]]);
        // 188 is 0.5029 in linear light: IEC 61966-2-1.
        let half = grey.at([0.5, 0.3])[0];
        assert!((half - 0.5029 / 2.0).abs() < 1e-3, "{half}");
    }

    #[test]
    fn linear_light_is_encoded_and_what_is_none_is_clipped() {
        let image = TextureImage::from_linear(2, 1, &[[0.0, 0.5, 1.0], [-1.0, 7.0, f32::NAN]]);
        assert_eq!(image.texels(), [[0, 188, 255, 255], [0, 255, 0, 255]]);
        assert_eq!(image.notes[0].count, 3);
    }

    #[test]
    fn directions_on_a_sphere() {
        let near = |d: DVec3, uv: [f64; 2]| {
            let found = spherical(d);
            assert!((found[0] - uv[0]).abs() + (found[1] - uv[1]).abs() < 1e-12, "{d}: {found:?}");
        };
        near(DVec3::Z, [0.5, 0.5]);
        near(DVec3::X * 3.0, [0.75, 0.5]);
        near(DVec3::NEG_X, [0.25, 0.5]);
        assert_eq!(spherical(DVec3::Y)[1], 1.0);
        assert_eq!(spherical(DVec3::NEG_Y)[1], 0.0);
    }
}
