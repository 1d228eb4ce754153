//! Values on the command line: what their words mean, and why others are refused.

use glam::DVec3;

use crate::check::Severity;
use crate::export::resolved::Target;
use crate::render::{BackendChoice, EstimatorChoice, SampleRange};
use crate::scene::shapes::MAX_LENGTH;
use crate::transport::inspect::Follow;
use crate::transport::sampler::Sequence;

/// Longest side of an image.
const MOST_SIDE: u32 = 32_768;
/// Most pixels of an image: a film takes 28 bytes for each.
const MOST_PIXELS: u64 = 1 << 26;

pub fn target(text: &str) -> Result<Target, String> {
    let all = [Target::Mitsuba, Target::Pbrt, Target::Gltf, Target::Faces];
    let valid = || all.map(Target::name).join(", ");
    all.into_iter()
        .find(|target| target.name() == text)
        .ok_or_else(|| format!("unknown target `{text}`; valid: {}", valid()))
}

/// Width and height in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

/// A cap on the segments of a path; `None`: no cap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Depth(pub Option<u32>);

/// What one answer of rectification is stored for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Granularity {
    /// Each part of a surface that has the same surroundings everywhere.
    Patch,
    /// Each object.
    Object,
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Switch(pub bool);

pub fn size(text: &str) -> Result<Size, String> {
    let (width, height) =
        text.split_once(['x', 'X', '×']).ok_or("give width and height in pixels, such as 1280x720")?;
    let side = |text: &str| text.trim().parse::<u32>().map_err(|_| format!("`{text}` is not a number of pixels"));
    let (width, height) = (side(width)?, side(height)?);
    if width == 0 || height == 0 {
        return Err("an image needs at least one pixel in each direction".into());
    }
    if width > MOST_SIDE || height > MOST_SIDE || u64::from(width) * u64::from(height) > MOST_PIXELS {
        return Err(format!("at most {MOST_SIDE} pixels a side and {MOST_PIXELS} in all"));
    }
    Ok(Size { width, height })
}

pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 1e7 => Ok(seconds),
        _ => Err("give a number of seconds above 0, at most 1e7".into()),
    }
}

pub fn samples(text: &str) -> Result<SampleRange, String> {
    let index = |text: &str| text.trim().parse::<u32>().ok();
    let range = text.split_once("..").and_then(|(first, end)| Some(SampleRange(index(first)?, index(end)?)));
    match range {
        Some(range) if range.count() > 0 => Ok(range),
        _ => Err("give the first sample and the one after the last, such as 0..256, at most 4294967295".into()),
    }
}

pub fn depth(text: &str) -> Result<Depth, String> {
    match (text, text.parse::<u32>()) {
        ("none", _) => Ok(Depth(None)),
        (_, Ok(segments)) if segments > 0 => Ok(Depth(Some(segments))),
        _ => Err("give a number of segments, at least 1, or `none`".into()),
    }
}

pub fn exposure(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(stops) if stops.abs() <= 40.0 => Ok(stops),
        _ => Err("give a number of stops between -40 and 40".into()),
    }
}

pub fn on_or_off(text: &str) -> Result<Switch, String> {
    one_of(text, &[("on", Switch(true)), ("off", Switch(false))], &[])
}

pub fn backend(text: &str) -> Result<BackendChoice, String> {
    let all = [BackendChoice::Auto, BackendChoice::Cpu, BackendChoice::Gpu];
    one_of(text, &all.map(|backend| (backend.name(), backend)), &[])
}

pub fn estimator(text: &str) -> Result<EstimatorChoice, String> {
    use EstimatorChoice::{Auto, Bidirectional, Merging, Path};
    one_of(text, &[Auto, Path, Bidirectional, Merging].map(|estimator| (estimator.name(), estimator)), &[])
}

pub fn severity(text: &str) -> Result<Severity, String> {
    one_of(text, &[("warning", Severity::Warning), ("advice", Severity::Advice)], &[])
}

pub fn sequence(text: &str) -> Result<Sequence, String> {
    one_of(text, &[("sobol", Sequence::Sobol), ("independent", Sequence::Independent)], &[])
}

pub fn granularity(text: &str) -> Result<Granularity, String> {
    one_of(text, &[("patch", Granularity::Patch), ("object", Granularity::Object)], &[])
}

pub fn follow(text: &str) -> Result<Follow, String> {
    let all = [("sample", Follow::Sample), ("transmit", Follow::Transmit), ("reflect", Follow::Reflect)];
    one_of(text, &all, &[])
}

/// The value of the choice that `text` names; names in `planned` are known, but not built yet.
fn one_of<T: Copy>(text: &str, choices: &[(&str, T)], planned: &[&str]) -> Result<T, String> {
    if let Some((_, value)) = choices.iter().find(|(name, _)| *name == text) {
        return Ok(*value);
    }
    let valid = choices.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    if planned.contains(&text) {
        return Err(format!("`{text}` is not yet supported; valid: {valid}"));
    }
    Err(format!("valid: {valid}"))
}

pub fn pixel(text: &str) -> Result<[u32; 2], String> {
    let wrong = || "give column and row, such as 256,128; 0,0 is top left".to_owned();
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    Ok([x.trim().parse().map_err(|_| wrong())?, y.trim().parse().map_err(|_| wrong())?])
}

fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if DVec3::new(x, y, z).is_finite() => Ok(DVec3::new(x, y, z)),
        _ => Err("give three finite numbers, such as 0,1.5,-4".into()),
    }
}

pub fn origin(text: &str) -> Result<DVec3, String> {
    let origin = point(text)?;
    if origin.abs().max_element() <= MAX_LENGTH {
        Ok(origin)
    } else {
        Err(format!("numbers are at most {MAX_LENGTH:e}"))
    }
}

pub fn direction(text: &str) -> Result<DVec3, String> {
    let direction = point(text)?;
    // The squares of a very long or short one would not be finite or not be there.
    (direction / direction.abs().max_element()).try_normalize().ok_or_else(|| "a direction cannot be zero".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("1280x720"), Ok(Size { width: 1280, height: 720 }));
        assert_eq!(size("8192×8192"), Ok(Size { width: 8192, height: 8192 }));
        for wrong in ["0x0", "0x5", "5x0", "5", "x", "-1x5", "1e3x5", "32769x1", "8193x8192", "99999999999x1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn ranges_of_samples() {
        assert_eq!(samples("0..256"), Ok(SampleRange(0, 256)));
        assert_eq!(samples("4294967294..4294967295"), Ok(SampleRange(u32::MAX - 1, u32::MAX)));
        for wrong in ["", "5", "5..5", "6..5", "-1..5", "0..", "..4", "0...4", "0..=4", "0..4294967296", "a..b"] {
            assert!(samples(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_is_unknown_is_told_what_is_valid() {
        assert_eq!(backend("auto"), Ok(BackendChoice::Auto));
        assert_eq!(backend("gpu"), Ok(BackendChoice::Gpu));
        assert!(backend("abacus").unwrap_err().contains("auto, cpu, gpu"));
        assert_eq!(estimator("merging"), Ok(EstimatorChoice::Merging));
        assert!(estimator("photons").unwrap_err().contains("auto, path, bidirectional, merging"));
        assert_eq!(granularity("patch"), Ok(Granularity::Patch));
        assert!(granularity("face").unwrap_err().contains("patch, object"));
    }

    #[test]
    fn points_and_directions() {
        assert_eq!(point("-1, 2e1,0.5"), Ok(DVec3::new(-1.0, 20.0, 0.5)));
        assert_eq!(direction("0,0,-4"), Ok(DVec3::NEG_Z));
        assert_eq!(direction("0,1e-300,0"), Ok(DVec3::Y));
        assert_eq!(direction("1e300,0,0"), Ok(DVec3::X));
        assert_eq!(origin("1e18,0,0"), Ok(DVec3::X * 1e18));
        assert!(origin("0,-1e19,0").unwrap_err().contains("1e18"));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,nan", "1,2,inf", "a,b,c"] {
            assert!(point(wrong).is_err(), "{wrong}");
        }
        assert!(direction("0,0,0").is_err());
    }
}
