//! What a picture shows, in words that travel with it.

use super::escape::escaped;
use crate::render::{Backend, Estimator};
use crate::scene::{MediumId, SceneMedium};
use crate::tracking::Mode;
use crate::tracking::Prepared;

/// Text chunks for a picture of `prepared`: (keyword, text), in the order in which readers should see them. `samples` are those of
/// every pixel.
pub fn metadata(prepared: &Prepared, modes: &[Mode], samples: u32, seed: u64) -> Vec<(String, String)> {
    metadata_for_media(&prepared.description.name, &prepared.scene.media, modes, samples, seed)
}

/// [`metadata`] from the parts that it is made of: `media` begins with the global medium, or is empty where they are not known.
pub fn metadata_for_media(
    scene: &str,
    media: &[SceneMedium],
    modes: &[Mode],
    samples: u32,
    seed: u64,
) -> Vec<(String, String)> {
    let modes: Vec<&str> = modes.iter().map(|mode| mode.name()).collect();
    let iors: Vec<String> = (media.iter().enumerate())
        .filter(|(index, _)| *index != MediumId::VACUUM.0 as usize)
        .map(|(_, medium)| format!("{} = {}", medium.name, short(medium.ior())))
        .collect();
    [
        ("Title", scene.to_owned()),
        ("Software", format!("iorect {}", env!("CARGO_PKG_VERSION"))),
        ("Mode", modes.join(", ")),
        ("IOR", iors.join("; ")),
        ("Samples per pixel", samples.to_string()),
        ("Seed", seed.to_string()),
    ]
    .into_iter()
    .filter(|(_, text)| !text.is_empty())
    // Readers of pictures print these as they are.
    .map(|(keyword, text)| (keyword.to_owned(), escaped(&text).into_owned()))
    .collect()
}

/// What has rendered, for [`metadata`]: the backends of the images, and the graphics processor where one was used.
pub fn renderer(backends: &[Backend], adapter: Option<&str>) -> (String, String) {
    let has = |wanted: Backend| backends.iter().any(|backend| *backend == wanted || *backend == Backend::Mixed);
    let gpu = has(Backend::Gpu).then(|| adapter.unwrap_or("graphics processor"));
    let cpu = has(Backend::Cpu).then_some("CPU");
    let words: Vec<&str> = gpu.into_iter().chain(cpu).collect();
    ("Renderer".to_owned(), escaped(&words.join(" and ")).into_owned())
}

/// How light was transported, for [`metadata`].
pub fn estimator(estimator: Estimator) -> (String, String) {
    ("Estimator".to_owned(), estimator.name().to_owned())
}

/// As few digits as tell the IOR apart from its neighbours at nine decimals: 1 + (n − 1) must not read 1.3329999999999997.
fn short(ior: f64) -> String {
    let rounded = (ior * 1e9).round() / 1e9;
    rounded.to_string()
}
