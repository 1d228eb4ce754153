//! What decides the samples of an image, as one number: scene, camera, size and settings.

use super::settings::ImageSettings;
use crate::scene::camera::Camera;
use crate::scene::description::Description;
use crate::scene::fingerprint::{Fingerprint, Hasher};

/// Of an image of `size` (width, height): which sample has which radiance, but not how many are taken, nor on how many threads. `camera`
/// is in scene coordinates. The version of this program is part of it, because other code may give other samples.
///
/// Takes time in proportion to the meshes: one million triangles some 50 ms.
pub fn fingerprint(
    description: &Description,
    camera: &Camera,
    size: [u32; 2],
    settings: &ImageSettings,
) -> Fingerprint {
    let mut hasher = Hasher::new("iorect image 2");
    hasher.text(env!("CARGO_PKG_VERSION"));
    hasher.fingerprint(description.fingerprint());
    camera.hash_into(&mut hasher);
    size.into_iter().for_each(|side| hasher.integer(u64::from(side)));
    for (name, value) in settings.named() {
        hasher.text(name);
        hasher.text(&value);
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::formats;
    use crate::render::settings::Backend;
    use crate::tracking::Mode;
    use crate::transport::sampler::Sequence;

    #[test]
    fn every_setting_counts() {
        let scene = formats::open("plain-glass").unwrap();
        let camera = Camera::new(&scene.camera).unwrap();
        let base = ImageSettings::new(Mode::Rectified, 3);
        let mut closer = scene.camera;
        closer.focus_distance = Some(1.5);
        let closer = Camera::new(&closer).unwrap();
        let of = |camera, size, settings| fingerprint(&scene, camera, size, &settings);
        let all = [
            of(&camera, [64, 32], base),
            of(&camera, [32, 64], base),
            of(&closer, [64, 32], base),
            of(&camera, [64, 32], ImageSettings { mode: Mode::Stack, ..base }),
            of(&camera, [64, 32], ImageSettings { seed: 4, ..base }),
            of(&camera, [64, 32], ImageSettings { backend: Backend::Gpu, ..base }),
            of(&camera, [64, 32], ImageSettings { max_depth: Some(9), ..base }),
            of(&camera, [64, 32], ImageSettings { leave_out: false, ..base }),
            of(&camera, [64, 32], ImageSettings { splits: 0, ..base }),
            of(&camera, [64, 32], ImageSettings { sampler: Sequence::Independent, ..base }),
            of(&camera, [64, 32], ImageSettings { sample_environment: false, ..base }),
        ];
        assert_eq!(BTreeSet::from(all).len(), all.len());
        assert_eq!(of(&camera, [64, 32], base), all[0]);
    }
}
