//! Whether a mode is right in a picture, and if not, why and where that shows: paths through the whole picture are followed in the mode and in
//! mode `reference`, and where the two part, [`parting`] says which fact of the scene misleads the mode.

use glam::{DVec2, UVec2};

use crate::scene::camera::Camera;
use crate::tracking::{Mode, Prepared};
use crate::transport::inspect::{Follow, trace};
use crate::transport::parting::{Fault, parting};

/// Paths after which a verdict is final.
pub const PATHS: u32 = 1024;
/// Segments after which a path is not followed further.
const MOST_SEGMENTS: u32 = 60;

/// What is to be said of a mode in a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    pub mode: Mode,
    /// Paths that were followed, half of them through every surface and half by chance.
    pub paths: u32,
    /// Those of them that go wrong.
    pub wrong: u32,
    /// One for each cause, the one that misleads most light first.
    pub findings: Vec<Finding>,
}

/// Something that misleads a mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Where it concerns most light.
    pub fault: Fault,
    /// Paths that it misleads.
    pub paths: u32,
    /// Light that it misleads: shares of the paths' light that reach the first wrong surface, added up.
    pub light: f64,
    /// The point of the film, in [0, 1]², of the path with that fault.
    pub place: [f64; 2],
    /// How that path goes on at surfaces.
    pub follow: Follow,
    pub seed: u64,
    /// The share of that path's light that reaches the wrong surface.
    share: f64,
}

impl Verdict {
    /// Whether no path went wrong.
    pub fn is_right(&self) -> bool {
        self.wrong == 0
    }

    /// What is said of the picture in a few words: "right", "wrong here: forgets that volumes overlap".
    pub fn headline(&self) -> String {
        match self.findings.first() {
            None if self.mode == Mode::Reference => "right by definition".to_owned(),
            None => "right".to_owned(),
            Some(finding) => format!("wrong here: {}", finding.fault.cause.habit()),
        }
    }

    /// The same in whole sentences, with every cause.
    pub fn explanation(&self) -> String {
        let Self { mode, paths, wrong, findings } = self;
        if findings.is_empty() {
            return format!(
                "{paths} paths through this picture were followed: all media are those that mode reference finds."
            );
        }
        let share = 100.0 * f64::from(*wrong) / f64::from((*paths).max(1));
        let mut text = format!("{mode} goes wrong on {} of the paths through this picture.", percent(share));
        for finding in findings {
            text += &format!("\n• {}", finding.fault.sentence());
        }
        text
    }

    fn add(&mut self, fault: Fault, share: f64, place: [f64; 2], follow: Follow, seed: u64) {
        self.wrong += 1;
        let kind = fault.cause.name();
        match self.findings.iter_mut().find(|finding| finding.fault.cause.name() == kind) {
            Some(finding) => {
                finding.paths += 1;
                finding.light += share;
                // A path that goes through everything is easier to follow than one that turns by chance.
                let rank = |follow: Follow, share: f64| (follow == Follow::Transmit, share);
                if rank(follow, share) > rank(finding.follow, finding.share) {
                    *finding = Finding { fault, place, follow, seed, share, ..*finding };
                }
            }
            None => self.findings.push(Finding { fault, paths: 1, light: share, place, follow, seed, share }),
        }
        self.findings.sort_by(|a, b| b.light.total_cmp(&a.light));
    }
}

/// "12 %", "0.4 %".
fn percent(percent: f64) -> String {
    if percent < 1.0 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

/// Judges `mode` in the picture that `camera` takes on a film of `size` pixels. `publish` is given the verdict so far from time to time, and at
/// the end; it says whether to go on.
pub fn judge(
    prepared: &Prepared,
    camera: &Camera,
    size: [u32; 2],
    mode: Mode,
    mut publish: impl FnMut(&Verdict) -> bool,
) {
    let mut verdict = Verdict { mode, paths: 0, wrong: 0, findings: Vec::new() };
    let film = UVec2::from(size.map(|side| side.max(1))).as_dvec2();
    while verdict.paths < PATHS {
        let seed = u64::from(verdict.paths);
        // Every other path goes through all surfaces; both kinds are spread over the whole picture.
        let follow = if verdict.paths.is_multiple_of(2) { Follow::Transmit } else { Follow::Sample };
        let point = spread(verdict.paths / 2);
        let pixel = (film * point).floor() + 0.5;
        let place = (pixel / film).to_array();
        verdict.paths += 1;
        if mode != Mode::Reference {
            let ray = camera.ray(pixel, film, DVec2::ZERO);
            let [path, truth] =
                [mode, Mode::Reference].map(|mode| trace(prepared, mode, ray, follow, seed, Some(MOST_SEGMENTS)));
            if let Some(parting) = parting(prepared, [&path, &truth])
                && let [Some(fault), _] = parting.faults
            {
                let before = parting.vertex.checked_sub(1).and_then(|index| path.vertices.get(index));
                let share = before.map_or(1.0, |vertex| vertex.throughput.iter().sum::<f64>() / 3.0);
                verdict.add(fault, share, place, follow, seed);
            }
        }
        let is_time = verdict.paths == PATHS || (verdict.paths >= 64 && verdict.paths.is_power_of_two());
        if is_time && !publish(&verdict) {
            return;
        }
    }
}

/// The `index`th of points that are spread evenly over [0, 1)², however many there are (Roberts 2018, "The unreasonable effectiveness of
/// quasirandom sequences").
fn spread(index: u32) -> DVec2 {
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
    (DVec2::splat(0.5) + STEP * f64::from(index)).fract()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{builtin, open};
    use crate::tracking::prepare;

    fn verdicts(scene: &str, modes: &[Mode]) -> Vec<Verdict> {
        let description = std::sync::Arc::new(open(scene).unwrap());
        let camera = Camera::new(&description.camera).unwrap();
        let prepared = prepare(description, None).unwrap();
        let judged = |mode: &Mode| {
            let mut last = None;
            judge(&prepared, &camera, [160, 120], *mode, |verdict| {
                last = Some(verdict.clone());
                verdict.paths < 256
            });
            last.unwrap()
        };
        modes.iter().map(judged).collect()
    }

    #[test]
    fn each_failure_is_named_by_its_cause() {
        let cause = |scene: &str, mode| verdicts(scene, &[mode])[0].findings.first().map(|f| f.fault.cause.name());
        assert_eq!(cause("camera-in-water", Mode::Stack), Some("starts_inside"));
        assert_eq!(cause("iced-water", Mode::Stack), Some("overlap"));
        assert_eq!(cause("half-submerged", Mode::RectifiedObject), Some("one_answer_per_object"));
        assert_eq!(cause("world-oil", Mode::Naive), Some("vacuum_outside"));
        assert_eq!(cause("nested-spheres", Mode::Stack), None);
        assert_eq!(cause("plain-glass", Mode::Naive), None);
    }

    #[test]
    fn rectified_is_right_in_every_built_in_scene() {
        for scene in builtin::all() {
            for verdict in verdicts(scene.name, &[Mode::Rectified, Mode::Reference]) {
                assert!(verdict.is_right(), "{}: {}", scene.name, verdict.explanation());
            }
        }
    }

    #[test]
    fn points_are_spread_over_the_film() {
        let mut cells = [0; 16];
        for index in 0..160 {
            let point = spread(index);
            assert!(point.cmpge(DVec2::ZERO).all() && point.cmplt(DVec2::ONE).all());
            cells[(point.y * 4.0) as usize * 4 + (point.x * 4.0) as usize] += 1;
        }
        assert!(cells.iter().all(|count| (7..=13).contains(count)), "{cells:?}");
    }
}
