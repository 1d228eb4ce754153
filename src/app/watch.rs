//! Files that other programs may change: the scene's own, and the meshes and images that it names. They are looked at twice a second: that
//! works on every file system, also for files that are replaced as a whole.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use super::background::{Background, Bell, Desk, Repaint};
use crate::formats::texture;
use crate::scene::description::{Description, Environment, Paint, Shape, Solid};

const INTERVAL: Duration = Duration::from_millis(400);

/// What is watched.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Order {
    pub files: Vec<PathBuf>,
    /// Another number takes the files as they are then for known, such as after they were read or written.
    pub round: u64,
}

/// Whether a file has changed, and is no longer being written.
#[derive(Debug, Default)]
pub struct Report {
    pub has_changed: bool,
}

pub type Watcher = Background<Order, Report>;

/// Fails when the system refuses a thread.
pub fn start(wake: Repaint) -> std::io::Result<Watcher> {
    Background::start("watch", Bell::default(), move |desk| watch(desk, &wake))
}

fn watch(desk: &Desk<Order, Report>, wake: &Repaint) {
    let mut watched = Watched::default();
    let mut due = None;
    let mut round = 0;
    while let Some(order) = desk.wait(due) {
        if std::mem::replace(&mut round, order.round) != order.round {
            watched = Watched::default();
        }
        if watched.look(&order.files, Stamp::of) {
            desk.put(|report| report.has_changed = true);
            wake();
        }
        due = (!order.files.is_empty()).then(|| Instant::now() + INTERVAL);
    }
}

/// By what a changed file is known.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stamp {
    modified: Option<SystemTime>,
    bytes: u64,
}

impl Stamp {
    /// `None` where there is no such file, as for a moment when it is replaced.
    fn of(path: &Path) -> Option<Self> {
        let metadata = std::fs::metadata(path).ok()?;
        Some(Self { modified: metadata.modified().ok(), bytes: metadata.len() })
    }
}

/// Files as they were last read, and as they were last seen.
#[derive(Debug, Default)]
struct Watched {
    known: HashMap<PathBuf, Option<Stamp>>,
    seen: HashMap<PathBuf, Option<Stamp>>,
}

impl Watched {
    /// Whether a file is another than before, and has stayed so since the last look: one that is still being written goes on changing.
    fn look(&mut self, files: &[PathBuf], stamp_of: impl Fn(&Path) -> Option<Stamp>) -> bool {
        let mut has_changed = false;
        for path in files {
            let now = stamp_of(path);
            let seen = self.seen.insert(path.clone(), now);
            let known = self.known.entry(path.clone()).or_insert(now);
            if *known != now && now.is_some() && seen == Some(now) {
                *known = now;
                has_changed = true;
            }
        }
        has_changed
    }
}

/// The files that a scene in the file `path` depends on.
pub fn files_of(description: &Description, path: Option<&Path>) -> Vec<PathBuf> {
    let source = description.source.as_ref().filter(|source| !source.is_builtin);
    let folder = source.and_then(|source| source.path.parent());
    let import = source.and_then(|source| Some((source, source.import.as_ref()?)));
    let imported = import.map(|(source, import)| std::iter::once(&source.path).chain(&import.files).cloned());
    let mut files: Vec<PathBuf> = match path {
        Some(path) => vec![path.to_owned()],
        None => imported.into_iter().flatten().collect(),
    };
    let mut add = |named: &Path| {
        let file = match folder {
            Some(folder) => folder.join(named),
            None if named.is_absolute() => named.to_owned(),
            // What is compiled into the program does not change.
            None => return,
        };
        if !files.contains(&file) {
            files.push(file);
        }
    };
    for object in description.objects.iter() {
        if let Shape::Mesh { path, .. } = &object.shape {
            add(path);
        }
        if let Some(Solid { paint: Paint::Texture { path, .. }, .. }) = object.solid() {
            add(texture::file_of(path));
        }
    }
    if let Environment::Image { path, .. } = &description.environment {
        add(path);
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(bytes: u64) -> Option<Stamp> {
        Some(Stamp { modified: None, bytes })
    }

    /// What each look at one file says.
    fn looks(stamps: &[Option<Stamp>]) -> Vec<bool> {
        let mut watched = Watched::default();
        stamps.iter().map(|stamp| watched.look(&["a".into()], |_| *stamp)).collect()
    }

    #[test]
    fn a_change_is_told_once_when_it_is_over() {
        let [a, b, c] = [1, 2, 3].map(stamp);
        assert_eq!(looks(&[a, a, a]), [false; 3]);
        assert_eq!(looks(&[a, b, b, b]), [false, false, true, false]);
        // Still being written, then done.
        assert_eq!(looks(&[a, b, c, c, c]), [false, false, false, true, false]);
        // Replaced: it was gone in between. And gone for good: what was read stays.
        assert_eq!(looks(&[a, None, b, b]), [false, false, false, true]);
        assert_eq!(looks(&[a, None, None, None]), [false; 4]);
        assert_eq!(looks(&[a, None, a, a]), [false; 4]);
        assert_eq!(looks(&[a, b, a, a]), [false; 4]);
        // It comes to be.
        assert_eq!(looks(&[None, b, b]), [false, false, true]);
    }

    #[test]
    fn a_scene_depends_on_its_file_its_meshes_and_its_image() {
        let plain = crate::formats::open("plain-glass").unwrap();
        assert_eq!(files_of(&plain, None), Vec::<PathBuf>::new(), "it is compiled into the program");
        let text = "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n[environment]\nimage = \"sky.png\"\n\
                    [[solid]]\nname = \"s\"\nshape = { mesh = \"../m.obj\" }\n[[solid]]\nname = \"t\"\nshape = { mesh = \"../m.obj\" }\n";
        let mut sky = std::io::Cursor::new(Vec::new());
        image::RgbImage::new(2, 1).write_to(&mut sky, image::ImageFormat::Png).unwrap();
        let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec();
        let files = [("a/sky.png".into(), sky.into_inner()), ("m.obj".into(), obj)];
        let scene = crate::formats::parse(text, Path::new("a/s.toml"), &crate::formats::Memory(files.into())).unwrap();
        let expected: Vec<PathBuf> = ["a/s.toml", "a/../m.obj", "a/sky.png"].map(PathBuf::from).into();
        assert_eq!(files_of(&scene, Some(Path::new("a/s.toml"))), expected);
    }
}
