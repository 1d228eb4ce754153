//! A scene that is being read: on a thread, because meshes and images may take long.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use glam::DVec3;

use crate::optics::Ior;
use crate::scene::description::{CameraDescription, Environment, Objects, WorldMedium};
use crate::scene::{self, Description, SceneError};

/// Reads a scene from now on.
pub struct Reading {
    outcome: Receiver<Result<Description, SceneError>>,
}

/// The scene that is being opened, as the state knows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Opening {
    /// Different for each: what comes of one that was given up is ignored.
    pub id: u64,
    /// As asked for: a path or a name.
    pub name: PathBuf,
    /// Whether the user has agreed to lose unsaved changes.
    pub may_lose_edits: bool,
}

impl Opening {
    /// For people: the file without its folder.
    pub fn short_name(&self) -> String {
        self.name.file_name().unwrap_or(self.name.as_os_str()).to_string_lossy().into_owned()
    }
}

/// What came of a wait.
pub enum Waited {
    Done(Result<Box<Description>, SceneError>),
    /// It takes longer.
    NotYet(Reading),
}

impl Reading {
    /// Of a path or a built-in name. Fails when the system refuses a thread.
    pub fn start(name_or_path: PathBuf) -> std::io::Result<Self> {
        let (sender, outcome) = channel();
        std::thread::Builder::new().name("open".into()).spawn(move || {
            // Nobody waits any more for a scene whose opening was given up.
            let _ = sender.send(crate::formats::open(&name_or_path));
        })?;
        Ok(Self { outcome })
    }

    /// Waits for so long.
    pub fn wait_for(self, patience: Duration) -> Waited {
        match self.outcome.recv_timeout(patience) {
            Ok(outcome) => Waited::Done(outcome.map(Box::new)),
            Err(RecvTimeoutError::Timeout) => Waited::NotYet(self),
            Err(RecvTimeoutError::Disconnected) => Waited::Done(Err(Self::broken())),
        }
    }

    /// Waits until it is done.
    pub fn wait(self) -> Result<Description, SceneError> {
        self.outcome.recv().unwrap_or_else(|_| Err(Self::broken()))
    }

    /// The thread has panicked.
    fn broken() -> SceneError {
        SceneError::new("an internal error while the scene was read, please report it")
    }
}

/// What stands in for a scene until the first one has been read: nothing is rendered of it.
pub fn no_scene() -> Arc<Description> {
    Arc::new(Description {
        name: "iorect".to_owned(),
        camera: CameraDescription {
            position: DVec3::Z,
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: scene::tables::DEFAULT_VERTICAL_FOV,
            aperture_radius: 0.0,
            focus_distance: None,
        },
        camera_medium: None,
        world: WorldMedium { ior: Ior::Constant(1.0), absorption: [0.0; 3] },
        environment: Environment::Color([0.0; 3]),
        media: Vec::new(),
        objects: Objects::default(),
        source: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_read_on_a_thread() {
        let reading = Reading::start("nested-spheres".into()).unwrap();
        assert_eq!(reading.wait().unwrap().name, crate::formats::open("nested-spheres").unwrap().name);
        match Reading::start("no-such-scene".into()).unwrap().wait_for(Duration::from_secs(60)) {
            Waited::Done(outcome) => assert!(outcome.unwrap_err().message.contains("no-such-scene")),
            Waited::NotYet(_) => panic!("a minute was not enough"),
        }
    }

    #[test]
    fn one_that_takes_longer_can_be_waited_for_again() {
        let (sender, outcome) = channel();
        let Waited::NotYet(reading) = (Reading { outcome }).wait_for(Duration::from_millis(5)) else {
            panic!("nothing was sent")
        };
        sender.send(crate::formats::open("nested-spheres")).unwrap();
        assert!(reading.wait().is_ok());
        // The thread has panicked.
        let (sender, outcome) = channel();
        drop(sender);
        assert!(Reading { outcome }.wait().unwrap_err().message.contains("internal error"));
    }

    #[test]
    fn people_read_the_file_without_its_folder() {
        let opening = |name: &str| Opening { id: 1, name: name.into(), may_lose_edits: false };
        assert_eq!(opening("a/b/scene.toml").short_name(), "scene.toml");
        assert_eq!(opening("nested-spheres").short_name(), "nested-spheres");
    }
}
