//! Material libraries of OBJ files (.mtl): what they say of colour, light and glass. They describe looks and not media, so that a scene made
//! of them is a start, to be gone on with.

use crate::formats::lines::Lines;

/// One material. What its library does not say is `None`.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::formats) struct Material {
    pub name: String,
    /// `Ni`, the index of refraction.
    pub ior: Option<f64>,
    /// `Tf`: how much of the light passes.
    pub filter: Option<[f64; 3]>,
    /// `d`, or 1 − `Tr`: 1 is opaque.
    pub opacity: Option<f64>,
    /// `illum`, the way in which it is shaded.
    pub illumination: Option<u32>,
    /// `Kd`, the diffuse colour.
    pub color: Option<[f64; 3]>,
    /// `Pm` (an extension): 1 is metal.
    pub metallic: Option<f64>,
    /// `Ke`, what it emits.
    pub emission: Option<[f64; 3]>,
    /// `map_Kd`, an image that is multiplied by its colour.
    pub image: Option<Image>,
}

/// An image by the name of its file.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::formats) struct Image {
    pub file: String,
    /// `-o` and `-s`: what is added to texture coordinates after they are multiplied.
    pub offset: [f64; 2],
    pub scale: [f64; 2],
    /// Whether it is said to end at its edges.
    pub is_clamped: bool,
}

/// Ways of shading that show what is behind: transparency or refraction.
const TRANSPARENT: [u32; 4] = [4, 6, 7, 9];

impl Material {
    /// Whether it lets light through. A filter of 0 or 1 says nothing: programs write both for what is opaque.
    pub fn is_glass(&self) -> bool {
        self.opacity.is_some_and(|opacity| opacity < 0.999)
            || self.tint().is_some()
            || self.illumination.is_some_and(|illumination| TRANSPARENT.contains(&illumination))
    }

    /// Which share of red, green and blue passes, where it is neither all nor nothing.
    pub fn tint(&self) -> Option<[f64; 3]> {
        self.filter.filter(|filter| filter.iter().any(|share| *share > 0.0 && *share < 1.0))
    }

    /// What it emits, if it does.
    pub fn light(&self) -> Option<[f64; 3]> {
        self.emission.filter(|emission| emission.iter().any(|component| *component > 0.0))
    }
}

/// The materials of a library, and how many of its values could not be read. Statements that say nothing of these things are passed over.
pub(in crate::formats) fn read(bytes: &[u8]) -> (Vec<Material>, u64) {
    let mut materials: Vec<Material> = Vec::new();
    let mut unread = 0;
    let mut lines = Lines::new(bytes);
    while let Some(line) = lines.next() {
        let text = String::from_utf8_lossy(line);
        let Some(word) = text.split_ascii_whitespace().next() else { continue };
        let rest = text[word.len()..].trim();
        if word == "newmtl" {
            materials.push(Material { name: rest.to_owned(), ..Material::default() });
            continue;
        }
        let Some(material) = materials.last_mut() else { continue };
        if set(material, word, rest).is_none() {
            unread += 1;
        }
    }
    (materials, unread)
}

/// `None` where the value is none.
fn set(material: &mut Material, word: &str, rest: &str) -> Option<()> {
    match word {
        "Ni" => material.ior = Some(number(rest)?),
        "Tf" => material.filter = Some(color(rest)?),
        "d" => material.opacity = Some(number(rest.trim_start_matches("-halo"))?),
        // Where both are there, `d` is the one that everybody reads alike.
        "Tr" => _ = material.opacity.get_or_insert(1.0 - number(rest)?),
        "illum" => material.illumination = Some(number(rest)? as u32),
        "Kd" => material.color = Some(color(rest)?),
        "Pm" => material.metallic = Some(number(rest)?),
        "Ke" => material.emission = Some(color(rest)?),
        "map_Kd" => material.image = Some(image(rest)?),
        _ => {}
    }
    Some(())
}

/// A file's name, which may have spaces, behind options.
fn image(text: &str) -> Option<Image> {
    let mut image = Image { file: String::new(), offset: [0.0; 2], scale: [1.0; 2], is_clamped: false };
    let mut rest = text.trim();
    let word_of = |text: &str| text.split_ascii_whitespace().next().unwrap_or_default().to_owned();
    while rest.starts_with('-') {
        let option = word_of(rest);
        let (most, are_numbers) = match option.as_str() {
            "-o" | "-s" | "-t" => (3, true),
            "-mm" => (2, true),
            "-blendu" | "-blendv" | "-boost" | "-texres" | "-clamp" | "-bm" | "-imfchan" | "-type" | "-cc" => {
                (1, false)
            }
            // A name may begin so.
            _ => break,
        };
        rest = rest[option.len()..].trim_start();
        for index in 0..most {
            let word = word_of(rest);
            let value = number(&word);
            if are_numbers && value.is_none() {
                break;
            }
            match (option.as_str(), value, index) {
                ("-o", Some(value), 0 | 1) => image.offset[index] = value,
                ("-s", Some(value), 0 | 1) => image.scale[index] = value,
                ("-clamp", ..) => image.is_clamped = word == "on",
                _ => {}
            }
            rest = rest[word.len()..].trim_start();
        }
    }
    image.file = rest.to_owned();
    (!image.file.is_empty()).then_some(image)
}

fn number(text: &str) -> Option<f64> {
    let number: f64 = text.split_ascii_whitespace().next()?.parse().ok()?;
    number.is_finite().then_some(number)
}

/// One number is that of all three components. Spectra and XYZ are not read.
fn color(text: &str) -> Option<[f64; 3]> {
    let mut words = text.split_ascii_whitespace();
    let red = number(words.next()?)?;
    match (words.next(), words.next()) {
        (None, _) => Some([red; 3]),
        (Some(green), Some(blue)) => Some([red, number(green)?, number(blue)?]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_library_says() {
        let text = "# made by hand\nKd 1 1 1\nnewmtl red wine\n  Ni 1.34\nTf 0.9 0.1 0.2\nillum 2\n\nnewmtl cup\r\nNi 1.5\r\nd -halo 0.2\r\n\
                    newmtl wood\nKd 0.5\nmap_Kd oak.png\nTf 1 1 1\nTr 0\nnewmtl lamp\nKe 2 3 4\nTf 0 0 0\nnewmtl gold\nPm 1\nKd spectral x.rfl\nNi x\n";
        let (materials, unread) = read(text.as_bytes());
        let names: Vec<&str> = materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!((names, unread), (vec!["red wine", "cup", "wood", "lamp", "gold"], 2));
        assert_eq!(materials.iter().map(Material::is_glass).collect::<Vec<_>>(), [true, true, false, false, false]);
        assert_eq!((materials[0].ior, materials[0].tint()), (Some(1.34), Some([0.9, 0.1, 0.2])));
        let file = materials[2].image.as_ref().map(|image| image.file.as_str());
        assert_eq!((materials[2].color, materials[2].opacity, file), (Some([0.5; 3]), Some(1.0), Some("oak.png")));
        assert_eq!((materials[3].light(), materials[2].light()), (Some([2.0, 3.0, 4.0]), None));
        let with = |text: &str| image(text).map(|i| (i.file, i.scale, i.offset, i.is_clamped));
        assert_eq!(
            with("-s 2 3 1 -o 0.5 -clamp on -bm 0.2 my oak.png"),
            Some(("my oak.png".into(), [2.0, 3.0], [0.5, 0.0], true))
        );
        assert_eq!(with("-odd.png").map(|found| found.0), Some("-odd.png".into()));
        assert_eq!(with("-s 1 1 1"), None);
        for illumination in 0..=10 {
            let material = Material { illumination: Some(illumination), ..Material::default() };
            assert_eq!(material.is_glass(), [4, 6, 7, 9].contains(&illumination));
        }
    }
}
