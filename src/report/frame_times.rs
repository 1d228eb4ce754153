//! How long the window takes for a frame while panes render. Measured by the window itself, which leaves what it found in a file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::machine::Machine;
use crate::writing::{WriteError, write_atomically};

/// Milliseconds of many frames.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    pub median_ms: f64,
    /// 95 of 100 frames take at most this.
    pub percentile_95_ms: f64,
    pub most_ms: f64,
}

impl Spread {
    /// `None` without frames.
    pub fn of(mut seconds: Vec<f64>) -> Option<Self> {
        seconds.sort_by(f64::total_cmp);
        let last = seconds.len().checked_sub(1)?;
        let at = |part: f64| 1e3 * seconds[(part * last as f64).ceil() as usize];
        Some(Self { median_ms: at(0.5), percentile_95_ms: at(0.95), most_ms: at(1.0) })
    }
}

/// What the window has measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameTimes {
    pub machine: Machine,
    pub version: String,
    pub is_optimized: bool,
    pub date: String,
    pub scene: String,
    /// Of the window, in pixels.
    pub window: [u32; 2],
    pub panes: usize,
    /// Of each film.
    pub pane: [u32; 2],
    pub frames: usize,
    /// Samples per pixel that were taken meanwhile: the panes did render.
    pub samples: u32,
    /// What the program itself does for a frame: panels, pictures, input.
    pub interface: Spread,
    /// The whole of the processor's work for a frame: that, making triangles of it, and handing them to the graphics card, which a
    /// processor may stand in for. `None` where the system does not tell.
    pub whole: Option<Spread>,
    /// From the beginning of one frame to that of the next, the graphics card's work and the wait for the screen included.
    #[serde(default)]
    pub interval: Option<Spread>,
    /// The graphics card, or what stands in for it.
    #[serde(default)]
    pub drawn_by: Option<String>,
}

/// That file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum FrameTimesError {
    #[error("{path}: {reason}")]
    Unreadable { path: String, reason: String },
    #[error(transparent)]
    NotWritten(#[from] WriteError),
}

impl FrameTimes {
    /// # Errors
    /// When the file cannot be read, or is none of these.
    pub fn read(path: &Path) -> Result<Self, FrameTimesError> {
        let unreadable = |reason: String| FrameTimesError::Unreadable { path: path.display().to_string(), reason };
        let text = std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string()))?;
        serde_json::from_str(&text)
            .map_err(|error| unreadable(format!("not what iorect --measure-frames writes: {error}")))
    }

    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FrameTimesError> {
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        write_atomically(path, |file| std::io::Write::write_all(file, text.as_bytes()))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_of_all_frames() {
        let spread = Spread::of((1..=100).rev().map(|ms| f64::from(ms) * 1e-3).collect()).unwrap();
        assert!((spread.median_ms - 51.0).abs() < 1e-9 && (spread.percentile_95_ms - 96.0).abs() < 1e-9);
        assert!((spread.most_ms - 100.0).abs() < 1e-9);
        assert_eq!(Spread::of(Vec::new()), None);
    }

    #[test]
    fn what_is_written_is_read_and_nothing_else() {
        let spread = Spread { median_ms: 1.0, percentile_95_ms: 2.0, most_ms: 3.0 };
        let times = FrameTimes {
            machine: Machine::here(),
            version: "0".into(),
            is_optimized: false,
            date: "now".into(),
            scene: "plain-glass".into(),
            window: [1920, 1080],
            panes: 4,
            pane: [640, 480],
            frames: 10,
            samples: 3,
            interface: spread,
            whole: None,
            interval: Some(spread),
            drawn_by: Some("a card".into()),
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frames.json");
        times.write(&path).unwrap();
        assert_eq!(FrameTimes::read(&path).unwrap(), times);
        std::fs::write(&path, "{}").unwrap();
        assert!(FrameTimes::read(&path).unwrap_err().to_string().contains("frames.json"));
        assert!(FrameTimes::read(&folder.path().join("none.json")).is_err());
    }
}
