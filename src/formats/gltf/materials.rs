//! What objects are made of. A material that transmits is a refractor with a medium of its own, what shines is a light, polished metal a
//! mirror; all else is diffuse.

use std::path::Path;

use super::container::Container;
use super::schema::{Material, MaterialExtensions};
use super::textures::{BaseColor, Images, of_color};
use crate::formats::tally::Tally;
use crate::optics::Ior;
use crate::optics::ior::{WAVELENGTH_C_UM, WAVELENGTH_F_UM};
use crate::scene::fields::IOR;
use crate::spectrum::WAVELENGTH_D_UM;

/// Where nothing is said.
const DEFAULT_IOR: f64 = 1.5;
/// What has no material, as the `[[solid]]` of a scene file that says no colour.
const DEFAULT_ALBEDO: [f64; 3] = [0.8; 3];
/// Least share that is taken for what passes through glass: absorption would have no number.
const LEAST_PASSING: f64 = 1e-4;
/// Emission below this share is passed over: it lights nothing, and lights are black otherwise.
const LEAST_EMISSION: f64 = 0.02;
/// Roughness up to which metal is shown as a mirror.
const MOST_POLISHED: f64 = 0.5;

/// What an object of a material is.
#[derive(Debug, Clone, PartialEq)]
pub enum Look {
    Glass {
        ior: Ior,
        absorption: [f64; 3],
        /// GGX's α.
        roughness: f64,
        /// It has no volume, and is a thin wall by the standard.
        thin: bool,
    },
    /// An image is multiplied by the colour.
    Opaque {
        color: [f64; 3],
        image: Option<BaseColor>,
        is_mirror: bool,
        /// GGX's α.
        roughness: f64,
    },
    /// Sheets of it may emit from both sides.
    Light { radiance: [f64; 3], is_double_sided: bool },
}

/// What a material is called in a scene.
pub fn name(container: &Container, index: usize) -> String {
    let name = container.root.materials.get(index).map_or("", |material| material.name.trim());
    if name.is_empty() { format!("material {index}") } else { name.to_owned() }
}

/// What the objects of a material are; `None` is where a file names no material. `file` is the name of the file.
pub fn look(
    container: &Container,
    index: Option<usize>,
    file: &Path,
    images: &mut Images,
    tally: &mut Tally,
) -> Result<Look, String> {
    let Some(index) = index else {
        return Ok(Look::Opaque { color: DEFAULT_ALBEDO, image: None, is_mirror: false, roughness: 1.0 });
    };
    let materials = &container.root.materials;
    let material =
        materials.get(index).ok_or_else(|| format!("there is no material {index}: there are {}", materials.len()))?;
    let named = name(container, index);
    note_others(material, &named, tally);
    let MaterialExtensions { transmission, specular_glossiness, .. } = &material.extensions;
    let pbr = &material.pbr_metallic_roughness;
    let (factor, texture) = match specular_glossiness {
        Some(old) => (old.diffuse_factor, of_color(material)),
        None => (pbr.base_color_factor, of_color(material)),
    };
    let [red, green, blue, alpha] = factor.unwrap_or([1.0; 4]);
    let surface = images.numbers(container, pbr.metallic_roughness_texture.as_ref(), tally);
    let metallic = match specular_glossiness {
        Some(_) => 0.0,
        None => share(pbr.metallic_factor.unwrap_or(1.0) * surface[2]),
    };
    let roughness = share(pbr.roughness_factor.unwrap_or(1.0) * surface[1]);
    if let Some(transmission) = transmission {
        let of_passing = images.numbers(container, transmission.transmission_texture.as_ref(), tally);
        let passing = share(transmission.transmission_factor * of_passing[0]) * (1.0 - metallic);
        if passing >= 0.5 {
            if passing < 0.99 {
                tally.add("part_transmission", "what transmits in part is shown as if it transmitted all", &named);
            }
            let average = images.color(container, texture, tally);
            let color = [0, 1, 2].map(|axis| share([red, green, blue][axis] * average[axis]));
            return Ok(glass(material, &named, color, alpha_of(roughness), tally));
        }
        if passing > 0.0 {
            tally.add("part_transmission", "what transmits less than half is shown as opaque", &named);
        }
    }
    let strength = material.extensions.emissive_strength.as_ref().and_then(|e| e.emissive_strength).unwrap_or(1.0);
    if material.emissive_factor.iter().any(|factor| *factor > 0.0) {
        let average = images.color(container, material.emissive_texture.as_ref(), tally);
        let radiance = [0, 1, 2].map(|axis| (material.emissive_factor[axis] * strength * average[axis]).max(0.0));
        if radiance.iter().any(|component| *component >= LEAST_EMISSION) {
            return Ok(Look::Light { radiance, is_double_sided: material.double_sided });
        }
        tally.add("weak_emission", "weak emission is left out", &named);
    }
    if alpha < 0.5 && material.alpha_mode == "BLEND" {
        let what = "what is see-through by alpha and not by transmission is shown as opaque";
        tally.add("alpha", what, &named);
    }
    let is_mirror = metallic >= 0.5 && roughness <= MOST_POLISHED;
    match (metallic >= 0.5, is_mirror) {
        (true, false) => tally.add("rough_metal", "very rough metal is shown as diffuse", &named),
        (false, _) if roughness < 0.5 => tally.add("gloss", "the gloss of diffuse surfaces is left out", &named),
        _ => {}
    }
    let image = images.base_color(container, texture, file, tally);
    if image.is_some() && material.alpha_mode == "MASK" {
        tally.add("cutout", "holes that images cut by alpha are filled", &named);
    }
    Ok(Look::Opaque { color: [red, green, blue].map(share), image, is_mirror, roughness: alpha_of(roughness) })
}

/// glTF's roughness is the root of α.
fn alpha_of(roughness: f64) -> f64 {
    roughness * roughness
}

fn glass(material: &Material, named: &str, color: [f64; 3], roughness: f64, tally: &mut Tally) -> Look {
    let MaterialExtensions { ior, volume, dispersion, specular, .. } = &material.extensions;
    let index = ior.as_ref().and_then(|extension| extension.ior).unwrap_or(DEFAULT_IOR);
    let index = if index == 0.0 || !(IOR.is_fine)(index) {
        // 0 stands for a mirror in the older way to shade.
        tally.add("ior", "an IOR that none can have is taken for 1.5", named);
        DEFAULT_IOR
    } else {
        index
    };
    let dispersion = dispersion.as_ref().map_or(0.0, |extension| extension.dispersion);
    let ior = dispersive(index, dispersion).unwrap_or(Ior::Constant(index));
    if let Some(specular) = specular
        && (specular.specular_factor.is_some_and(|factor| factor < 1.0)
            || specular.specular_color_factor.is_some_and(|color| color != [1.0; 3]))
    {
        tally.add("specular", "reflection of glass that is weaker or coloured is shown in full", named);
    }
    let thickness = volume.as_ref().map_or(0.0, |volume| volume.thickness_factor);
    let mut absorption = [0.0; 3];
    if thickness > 0.0 {
        let (distance, passing) =
            volume.as_ref().map_or((None, None), |v| (v.attenuation_distance, v.attenuation_color));
        if let Some(distance) = distance.filter(|distance| *distance > 0.0) {
            let passing = passing.unwrap_or([1.0; 3]);
            if passing.iter().any(|share| *share < LEAST_PASSING) {
                tally.add("black_volume", "a colour that is absorbed wholly passes to 0.01 % of it", named);
            }
            absorption = passing.map(|share| absorbed(share) / distance);
        }
        if color.iter().any(|share| *share < 0.999) {
            // The colour of the surface counts on the way in and on the way out.
            let of_surface = color.map(|share| 2.0 * absorbed(share) / thickness);
            absorption = [0, 1, 2].map(|axis| absorption[axis] + of_surface[axis]);
            tally.add(
                "surface_tint",
                "the colour of glass surfaces is taken for absorption within their thickness",
                named,
            );
        }
        if absorption.iter().any(|sigma| !sigma.is_finite()) {
            absorption = [0.0; 3];
        }
    } else {
        if color.iter().any(|share| *share < 0.999) {
            tally.add("thin_tint", "the colour of thin walls is left out", named);
        }
    }
    Look::Glass { ior, absorption, roughness, thin: thickness <= 0.0 }
}

/// −ln of the share that passes, at least 0.
fn absorbed(share: f64) -> f64 {
    (-share.clamp(LEAST_PASSING, 1.0).ln()).max(0.0)
}

/// Cauchy's formula with the IOR at the d line and the Abbe number that KHR_materials_dispersion gives as 20/V; `None` without dispersion.
fn dispersive(index: f64, dispersion: f64) -> Option<Ior> {
    let of = |um: f64| 1.0 / (um * um);
    let slope = (index - 1.0) * dispersion / 20.0 / (of(WAVELENGTH_F_UM) - of(WAVELENGTH_C_UM));
    let ior = Ior::Cauchy([index - slope * of(WAVELENGTH_D_UM), slope, 0.0]);
    (dispersion > 0.0 && slope > 0.0 && slope.is_finite() && (IOR.is_fine)(ior.ior())).then_some(ior)
}

fn share(number: f64) -> f64 {
    number.clamp(0.0, 1.0)
}

/// What the scene has nothing for.
fn note_others(material: &Material, named: &str, tally: &mut Tally) {
    if material.normal_texture.is_some() {
        tally.add("normal_texture", "normal maps are left out", named);
    }
    if material.extensions.specular_glossiness.is_some() {
        tally.add(
            "specular_glossiness",
            "of older materials by specular and glossiness the diffuse colour is read",
            named,
        );
    }
    let mut others: Vec<&String> =
        material.extensions.others.keys().filter(|key| key.contains("_materials_")).collect();
    others.sort();
    for other in others {
        tally.add("material_extension", &format!("extensions of materials that are left out, such as {other}"), named);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dispersion_keeps_the_index_and_gives_the_abbe_number() {
        let ior = dispersive(1.5168, 20.0 / 64.17).unwrap();
        assert!((ior.ior() - 1.5168).abs() < 1e-12);
        assert!((ior.abbe_number().unwrap() - 64.17).abs() < 1e-6);
        assert_eq!(dispersive(1.5, 0.0), None);
        assert_eq!(dispersive(0.9, 1.0), None);
    }
}
