//! Images: those of base colours become textures of solids, all others stand for their average.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::container::Container;
use super::schema::{Material, Primitive, TextureReference};
use crate::formats::tally::Tally;
use crate::formats::texture;
use crate::scene::texture::TextureImage;

/// Most texels of all images together.
const MAX_TEXELS: usize = 1 << 28;
/// How the edges of an image are treated: it is repeated.
const REPEAT: u32 = 10497;

/// What an image is on average.
#[derive(Debug, Clone, Copy)]
struct Average {
    /// Of its pixels in linear light.
    linear: [f64; 3],
    /// Of its numbers as they stand in the file, from 0 to 1.
    plain: [f64; 3],
}

impl Average {
    fn of(image: &TextureImage) -> Self {
        let mut sums = [0_u64; 3];
        image.texels().iter().for_each(|texel| (0..3).for_each(|k| sums[k] += u64::from(texel[k])));
        let count = 255.0 * image.texels().len().max(1) as f64;
        Self { linear: image.mean(), plain: sums.map(|sum| sum as f64 / count) }
    }
}

/// The images that have been asked for.
#[derive(Debug, Default)]
pub struct Images {
    /// `None`: it cannot be read.
    known: HashMap<usize, Option<(Arc<TextureImage>, Average)>>,
    texels: usize,
}

/// The image of a base colour.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseColor {
    /// As scenes in the file's folder name it.
    pub path: PathBuf,
    pub image: Arc<TextureImage>,
    /// Whether it is repeated beyond its edges.
    pub is_repeated: bool,
}

impl Images {
    /// The average of a colour; 1 where there is no image, or none that can be read.
    pub fn color(&mut self, container: &Container, texture: Option<&TextureReference>, tally: &mut Tally) -> [f64; 3] {
        self.average(container, texture, tally).map_or([1.0; 3], |average| average.linear)
    }

    /// The average of numbers.
    pub fn numbers(
        &mut self,
        container: &Container,
        texture: Option<&TextureReference>,
        tally: &mut Tally,
    ) -> [f64; 3] {
        self.average(container, texture, tally).map_or([1.0; 3], |average| average.plain)
    }

    fn average(
        &mut self,
        container: &Container,
        texture: Option<&TextureReference>,
        tally: &mut Tally,
    ) -> Option<Average> {
        let (index, _, average) = self.of(container, texture, tally)?;
        let what = "images of other things than the colour of solids stand for their average";
        tally.add("texture", what, &format!("image {index}"));
        Some(average)
    }

    /// The image of a base colour; `file` is the name of the file that it may be embedded in.
    pub fn base_color(
        &mut self,
        container: &Container,
        texture: Option<&TextureReference>,
        file: &std::path::Path,
        tally: &mut Tally,
    ) -> Option<BaseColor> {
        let (index, image, _) = self.of(container, texture, tally)?;
        let path = container.image_path(index).unwrap_or_else(|| texture::within(file, index));
        let sampler = container.root.textures.get(texture?.index).and_then(|texture| texture.sampler);
        let sampler = sampler.and_then(|sampler| container.root.samplers.get(sampler));
        let is_repeated = sampler
            .is_none_or(|sampler| [sampler.wrap_s, sampler.wrap_t].iter().all(|wrap| wrap.unwrap_or(REPEAT) == REPEAT));
        Some(BaseColor { path, image, is_repeated })
    }

    fn of(
        &mut self,
        container: &Container,
        texture: Option<&TextureReference>,
        tally: &mut Tally,
    ) -> Option<(usize, Arc<TextureImage>, Average)> {
        let texture = texture?.index;
        let image = container.root.textures.get(texture).and_then(|texture| texture.source);
        let Some(index) = image else {
            tally.add("image", "images that are not PNG or JPEG are left out", &format!("texture {texture}"));
            return None;
        };
        if let Some(known) = self.known.get(&index) {
            return known.clone().map(|(image, average)| (index, image, average));
        }
        let read = container.image(index).and_then(|bytes| self.read(&bytes));
        let found = match read {
            Ok(image) => {
                let average = Average::of(&image);
                Some((Arc::new(image), average))
            }
            Err(why) => {
                tally.add(
                    "image",
                    &format!("images that cannot be read are left out (the first {why})"),
                    &format!("image {index}"),
                );
                None
            }
        };
        self.known.insert(index, found.clone());
        found.map(|(image, average)| (index, image, average))
    }

    fn read(&mut self, bytes: &[u8]) -> Result<TextureImage, String> {
        let image = match bytes {
            [0x89, b'P', b'N', b'G', ..] | [0xff, 0xd8, ..] => texture::decode(bytes),
            _ => Err("is neither PNG nor JPEG".to_owned()),
        }?;
        self.texels = self.texels.saturating_add(image.texels().len());
        if self.texels > MAX_TEXELS {
            return Err("is one too many".to_owned());
        }
        Ok(image)
    }
}

/// The texture of a material's colour.
pub fn of_color(material: &Material) -> Option<&TextureReference> {
    match &material.extensions.specular_glossiness {
        Some(old) => old.diffuse_texture.as_ref(),
        None => material.pbr_metallic_roughness.base_color_texture.as_ref(),
    }
}

/// Where a primitive has the texture coordinates of its material's colour, and what makes them coordinates in the image with v upwards. Without a
/// texture they are the first; what is transparent needs none.
pub fn coordinates<'a>(
    container: &'a Container,
    primitive: &Primitive,
) -> Option<(usize, impl Fn([f64; 2]) -> [f64; 2] + use<'a>)> {
    let material = primitive.material.and_then(|index| container.root.materials.get(index));
    if material.is_some_and(|material| material.extensions.transmission.is_some()) {
        return None;
    }
    let texture = material.and_then(of_color);
    let transform = texture.and_then(|texture| texture.extensions.transform.as_ref());
    let set = transform.and_then(|transform| transform.tex_coord).or(texture.map(|texture| texture.tex_coord));
    let accessor = *primitive.attributes.get(&format!("TEXCOORD_{}", set.unwrap_or(0)))?;
    Some((accessor, move |[u, v]: [f64; 2]| {
        // glTF has v downwards. KHR_texture_transform turns counter-clockwise as images are seen.
        let [u, v] = match transform {
            Some(transform) => {
                let [x, y] = transform.scale.unwrap_or([1.0; 2]);
                let (sin, cos) = transform.rotation.sin_cos();
                let [right, down] = transform.offset;
                [cos * x * u + sin * y * v + right, cos * y * v - sin * x * u + down]
            }
            None => [u, v],
        };
        [u, 1.0 - v]
    }))
}
