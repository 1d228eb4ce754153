//! What decides the samples of an image, as one number: scene, camera, size and settings.

use super::cpu::{RenderSettings, VarianceReduction};
use crate::scene::camera::Camera;
use crate::scene::description::Description;
use crate::scene::fingerprint::{Fingerprint, Hasher};
use crate::transport::sampler::Sequence;

/// Of an image of `size` (width, height): which sample has which radiance, but not how many are taken, nor on how many threads. `camera`
/// is in scene coordinates. The version of this program is part of it, because other code may give other samples.
///
/// Takes time in proportion to the meshes: one million triangles some 50 ms.
pub fn fingerprint(
    description: &Description,
    camera: &Camera,
    size: [u32; 2],
    settings: &RenderSettings,
) -> Fingerprint {
    let RenderSettings { mode, seed, max_depth, leave_out, variance } = *settings;
    let VarianceReduction { sequence, splits, sample_environment } = variance;
    let mut hasher = Hasher::new("iorect image 1");
    hasher.text(env!("CARGO_PKG_VERSION"));
    hasher.fingerprint(description.fingerprint());
    camera.hash_into(&mut hasher);
    size.into_iter().for_each(|side| hasher.integer(u64::from(side)));
    hasher.text(mode.name());
    hasher.integer(seed);
    hasher.flag(max_depth.is_some());
    hasher.integer(u64::from(max_depth.unwrap_or_default()));
    hasher.flag(leave_out);
    hasher.text(match sequence {
        Sequence::Sobol => "sobol",
        Sequence::Independent => "independent",
    });
    hasher.integer(u64::from(splits));
    hasher.flag(sample_environment);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::formats;
    use crate::tracking::Mode;

    #[test]
    fn every_setting_counts() {
        let scene = formats::open("plain-glass").unwrap();
        let camera = Camera::new(&scene.camera).unwrap();
        let base = RenderSettings {
            mode: Mode::Rectified,
            seed: 3,
            max_depth: None,
            leave_out: true,
            variance: VarianceReduction::default(),
        };
        let mut closer = scene.camera;
        closer.focus_distance = Some(1.5);
        let closer = Camera::new(&closer).unwrap();
        let variance = base.variance;
        let of = |camera, size, settings| fingerprint(&scene, camera, size, &settings);
        let all = [
            of(&camera, [64, 32], base),
            of(&camera, [32, 64], base),
            of(&closer, [64, 32], base),
            of(&camera, [64, 32], RenderSettings { mode: Mode::Stack, ..base }),
            of(&camera, [64, 32], RenderSettings { seed: 4, ..base }),
            of(&camera, [64, 32], RenderSettings { max_depth: Some(9), ..base }),
            of(&camera, [64, 32], RenderSettings { leave_out: false, ..base }),
            of(&camera, [64, 32], RenderSettings { variance: VarianceReduction { splits: 0, ..variance }, ..base }),
            of(
                &camera,
                [64, 32],
                RenderSettings { variance: VarianceReduction { sequence: Sequence::Independent, ..variance }, ..base },
            ),
            of(
                &camera,
                [64, 32],
                RenderSettings { variance: VarianceReduction { sample_environment: false, ..variance }, ..base },
            ),
        ];
        assert_eq!(BTreeSet::from(all).len(), all.len());
        assert_eq!(of(&camera, [64, 32], base), all[0]);
    }
}
