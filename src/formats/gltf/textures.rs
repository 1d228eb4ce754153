//! Images stand for their average: iorect has no textures yet.

use std::collections::HashMap;

use super::container::Container;
use super::schema::TextureReference;
use crate::color::srgb_from_linear;
use crate::formats::image::bitmap;
use crate::formats::tally::Tally;

/// Most bytes of images that are decoded.
const MAX_BYTES: usize = 1 << 30;

/// What an image is on average.
#[derive(Debug, Clone, Copy)]
struct Average {
    /// Of its pixels in linear light.
    linear: [f64; 3],
    /// Of its numbers as they stand in the file, from 0 to 1.
    plain: [f64; 3],
}

/// The averages of the images that have been asked for.
#[derive(Debug, Default)]
pub struct Averages {
    known: HashMap<usize, Option<Average>>,
    bytes: usize,
}

impl Averages {
    /// Of a colour; 1 where there is no image, or none that can be read.
    pub fn color(&mut self, container: &Container, texture: Option<&TextureReference>, tally: &mut Tally) -> [f64; 3] {
        self.of(container, texture, tally).map_or([1.0; 3], |average| average.linear)
    }

    /// Of numbers.
    pub fn numbers(
        &mut self,
        container: &Container,
        texture: Option<&TextureReference>,
        tally: &mut Tally,
    ) -> [f64; 3] {
        self.of(container, texture, tally).map_or([1.0; 3], |average| average.plain)
    }

    fn of(&mut self, container: &Container, texture: Option<&TextureReference>, tally: &mut Tally) -> Option<Average> {
        let texture = texture?.index;
        let image = container.root.textures.get(texture).and_then(|texture| texture.source);
        let Some(image) = image else {
            tally.add("image", "images that are not PNG or JPEG are left out", &format!("texture {texture}"));
            return None;
        };
        if let Some(known) = self.known.get(&image) {
            return *known;
        }
        let read = container.image(image).and_then(|bytes| self.average(&bytes));
        let average = match read {
            Ok(average) => {
                tally.add("texture", "images stand for their average colour", &format!("image {image}"));
                Some(average)
            }
            Err(why) => {
                tally.add(
                    "image",
                    &format!("images that cannot be read are left out (the first {why})"),
                    &format!("image {image}"),
                );
                None
            }
        };
        self.known.insert(image, average);
        average
    }

    fn average(&mut self, bytes: &[u8]) -> Result<Average, String> {
        let decoded = match bytes {
            [0x89, b'P', b'N', b'G', ..] => bitmap::png(bytes),
            [0xff, 0xd8, ..] => bitmap::jpeg(bytes),
            _ => Err("is neither PNG nor JPEG".to_owned()),
        }?;
        self.bytes = self.bytes.saturating_add(decoded.pixels.len() * 3);
        if self.bytes > MAX_BYTES {
            return Err("is one too many".to_owned());
        }
        let (mut linear, mut plain) = ([0.0; 3], [0.0; 3]);
        for pixel in &decoded.pixels {
            for axis in 0..3 {
                linear[axis] += f64::from(pixel[axis]);
                plain[axis] += f64::from(srgb_from_linear(pixel[axis]));
            }
        }
        let count = decoded.pixels.len().max(1) as f64;
        Ok(Average { linear: linear.map(|sum| sum / count), plain: plain.map(|sum| sum / count) })
    }
}
