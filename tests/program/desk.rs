//! The real binary, run as its users run it, in a folder of one's own.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// A folder to run the program in. Command lines are split at spaces, without quotes.
pub struct Desk(tempfile::TempDir);

impl Desk {
    /// With one scene in it.
    pub fn with(name: &str, scene: &str) -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        desk.put(name, scene);
        desk
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn put(&self, name: &str, contents: impl AsRef<[u8]>) {
        fs::write(self.path().join(name), contents).unwrap();
    }

    pub fn get(&self, name: &str) -> Vec<u8> {
        fs::read(self.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_iorect"));
        command.current_dir(self.path()).args(line.split_whitespace()).stdin(Stdio::null());
        // Else Mesa's Vulkan complains on standard error where nobody has logged in to a desktop.
        command.env("NODEVICE_SELECT", "1");
        for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET", "RUST_LOG"] {
            command.env_remove(variable);
        }
        command
    }

    pub fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    /// Standard output of a run that must end well and say nothing on standard error.
    pub fn fine(&self, line: &str) -> String {
        let output = self.run(line);
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(0), "{line}: {err}");
        assert_eq!(err, "", "{line}: no progress without a terminal");
        out
    }

    pub fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.fine(line)).unwrap_or_else(|e| panic!("{line}: {e}"))
    }

    /// Standard error of a run that must end with that code and one clear message, and change nothing.
    pub fn refused(&self, line: &str, code: i32) -> String {
        let before = self.files();
        let output = self.run(line);
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(code), "{line}: {out}{err}");
        assert!(err.starts_with("error: "), "{line}: {err}");
        assert!(!err.contains("panicked"), "{line}: {err}");
        assert_eq!(out, "", "{line}");
        assert_eq!(self.files(), before, "{line}: nothing is left behind");
        err
    }

    /// Standard error of a run that must be refused for what was asked.
    pub fn wrong(&self, line: &str) -> String {
        self.refused(line, 2)
    }

    /// The picture in an EXR file, as other programs see it.
    pub fn picture(&self, name: &str) -> Vec<f32> {
        image::open(self.path().join(name)).unwrap().into_rgb32f().into_raw()
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}
