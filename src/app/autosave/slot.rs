//! One instance's autosave on disk: the edited scene, and beside it a lock that the instance holds while it runs. The system lets go of the
//! lock however the instance ends: an autosave that can be locked was left behind.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::Edits;
use crate::formats::{BuiltIn, Disk, Files};
use crate::scene::{Description, SceneError};
use crate::writing::write_atomically;

/// How the first line begins, a comment to TOML; JSON follows.
const HEAD: &str = "# iorect autosave ";
/// Of this description; files of another are left alone.
const FORMAT: u32 = 1;
/// Most bytes of an autosave.
const MAX_BYTES: u64 = 64 << 20;
/// Most autosaves that are looked at.
const MAX_FOUND: usize = 100;
/// Names to try until one is free.
const MAX_NAMES: u32 = 1000;

/// A place for one autosave, that nobody else uses while this value lives.
#[derive(Debug)]
pub struct Slot {
    path: PathBuf,
    lock_path: PathBuf,
    /// Unlocked when it is closed.
    _lock: File,
}

impl PartialEq for Slot {
    fn eq(&self, other: &Self) -> bool {
        self.path == other.path
    }
}

/// What an autosave says of itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Head {
    format: u32,
    /// Of the scene.
    name: String,
    /// The scene file's path as it is known to the description: relative paths in the text are relative to its folder.
    source: PathBuf,
    is_builtin: bool,
    /// Where "Save" writes.
    path: Option<PathBuf>,
    /// Seconds since 1970.
    saved_at: u64,
}

/// An autosave whose instance has gone.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    pub slot: Arc<Slot>,
    head: Head,
    text: String,
}

impl Slot {
    /// A free place in `folder`, which is made if it is not there. Fails where it cannot be made or written, or has no locks.
    pub fn claim(folder: &Path) -> io::Result<Self> {
        let mut builder = fs::DirBuilder::new();
        builder.recursive(true);
        // A scene may be its owner's alone; its autosave is no less so.
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(folder)?;
        // The number of the process is enough on one machine; other numbers for machines that share a home.
        let process = std::process::id();
        for number in 0..MAX_NAMES {
            let name = if number == 0 { process.to_string() } else { format!("{process}-{number}") };
            let path = folder.join(name).with_extension("toml");
            // One that is there was left behind, and is not to be lost.
            if !path.exists()
                && let Some(slot) = Self::locked(path)?
            {
                return Ok(slot);
            }
        }
        Err(io::Error::new(io::ErrorKind::AlreadyExists, "there are too many autosaves"))
    }

    /// The place at `path`, unless somebody has it.
    fn locked(path: PathBuf) -> io::Result<Option<Self>> {
        let lock_path = path.with_extension("lock");
        let lock = File::options().create(true).truncate(false).write(true).open(&lock_path)?;
        match lock.try_lock() {
            Ok(()) => Ok(Some(Self { path, lock_path, _lock: lock })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(error)) => Err(error),
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes `edits`, in place of what was there, or says in words why they cannot be kept.
    pub fn write(&self, edits: &Edits) -> Result<(), String> {
        let description = &edits.description;
        let (source, is_builtin) = match description.source.as_deref() {
            Some(source) => (source.path.clone(), source.is_builtin),
            None => (PathBuf::from("scene.toml"), false),
        };
        // Whoever restores it may stand in another folder.
        let absolute = |path: &Path| std::path::absolute(path).map_err(|error| error.to_string());
        let head = Head {
            format: FORMAT,
            name: description.name.clone(),
            source: if is_builtin { source } else { absolute(&source)? },
            is_builtin,
            path: edits.path.as_deref().map(absolute).transpose()?,
            saved_at: SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs(),
        };
        let head = serde_json::to_string(&head).map_err(|error| error.to_string())?;
        let text = format!("{HEAD}{head}\n{}", crate::formats::to_text(description));
        if text.len() as u64 > MAX_BYTES {
            return Err(format!("its text has {} bytes; at most {MAX_BYTES} are kept", text.len()));
        }
        write_atomically(&self.path, |file| file.write_all(text.as_bytes())).map_err(|error| error.to_string())
    }

    /// Removes the autosave, if there is one, and the lock's file. What comes later needs another place.
    pub fn remove(&self) {
        // What is not there, or cannot be removed, is offered once more at worst.
        let _ = fs::remove_file(&self.path);
        let _ = fs::remove_file(&self.lock_path);
    }
}

impl Found {
    /// The autosaves in `folder` whose instances have gone, latest first. They stay this instance's until they are dropped.
    pub fn all(folder: &Path) -> Vec<Self> {
        let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
        let paths = entries.flatten().map(|entry| entry.path());
        let paths = paths.filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
        let mut found: Vec<Self> = paths.take(MAX_FOUND).filter_map(Self::read).collect();
        found.sort_by_key(|found| std::cmp::Reverse(found.head.saved_at));
        found
    }

    /// `None` where an instance has it, and for files that are no autosaves: beside those no lock is made.
    fn read(path: PathBuf) -> Option<Self> {
        read_autosave(&path)?;
        let slot = Slot::locked(path).ok()??;
        // Only now is nobody writing it.
        let (head, text) = read_autosave(&slot.path)?;
        Some(Self { slot: Arc::new(slot), head, text })
    }

    pub fn name(&self) -> &str {
        &self.head.name
    }

    /// Where "Save" writes.
    pub fn scene_path(&self) -> Option<&Path> {
        self.head.path.as_deref()
    }

    /// How long ago it was written.
    pub fn age(&self) -> Duration {
        let saved_at = UNIX_EPOCH + Duration::from_secs(self.head.saved_at);
        // A clock that was set back makes it new.
        SystemTime::now().duration_since(saved_at).unwrap_or_default()
    }

    /// The edited scene, with the files that it names.
    pub fn description(&self) -> Result<Description, SceneError> {
        let files: &dyn Files = if self.head.is_builtin { &BuiltIn } else { &Disk };
        crate::formats::parse(&self.text, &self.head.source, files)
    }
}

fn read_autosave(path: &Path) -> Option<(Head, String)> {
    if !fs::metadata(path).ok()?.is_file() {
        return None;
    }
    let mut bytes = Vec::new();
    File::open(path).ok()?.take(MAX_BYTES + 1).read_to_end(&mut bytes).ok()?;
    let whole = String::from_utf8(bytes).ok().filter(|whole| whole.len() as u64 <= MAX_BYTES)?;
    let (first, text) = whole.split_once('\n')?;
    let head: Head = serde_json::from_str(first.strip_prefix(HEAD)?).ok()?;
    (head.format == FORMAT).then(|| (head, text.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edits(name: &str, path: Option<&Path>) -> Edits {
        let mut description = crate::formats::open("nested-spheres").unwrap();
        description.name = name.to_owned();
        Edits { description: Arc::new(description), path: path.map(Path::to_owned) }
    }

    #[test]
    fn an_autosave_is_found_once_its_instance_has_gone() {
        let folder = tempfile::tempdir().unwrap();
        let slot = Slot::claim(&folder.path().join("made")).unwrap();
        let folder = folder.path().join("made");
        let path = std::path::absolute("somewhere/else.toml").unwrap();
        let edits = edits("three\nlines\u{1b}[1m \u{7f}", Some(&path));
        slot.write(&edits).unwrap();
        assert_eq!(Found::all(&folder), [], "it still runs");
        drop(slot);
        let found = Found::all(&folder);
        let [one] = &found[..] else { panic!("{found:?}") };
        assert_eq!((one.name(), one.scene_path()), (edits.description.name.as_str(), Some(&*path)));
        assert!(one.age() < Duration::from_secs(600));
        let restored = one.description().unwrap();
        assert_eq!(restored.fingerprint(), edits.description.fingerprint());
        assert_eq!(restored.name, edits.description.name);
        assert_eq!(restored.source.as_ref().unwrap().path, edits.description.source.as_ref().unwrap().path);
        // It is this instance's now, until it is let go or removed.
        assert_eq!(Found::all(&folder), []);
        drop(found);
        let found = Found::all(&folder);
        found[0].slot.remove();
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
    }

    #[test]
    fn instances_do_not_take_each_others_places() {
        let folder = tempfile::tempdir().unwrap();
        let slots = [(); 3].map(|()| Slot::claim(folder.path()).unwrap());
        for (index, slot) in slots.iter().enumerate() {
            slot.write(&edits(&index.to_string(), None)).unwrap();
        }
        let [first, second, third] = slots;
        assert!(first != second && second != third && first != third);
        // The place of one that crashed is not free either: what is there may still be wanted.
        let path = first.path().to_owned();
        drop(first);
        assert_ne!(Slot::claim(folder.path()).unwrap().path(), path);
        drop([second, third]);
        let mut names: Vec<String> = Found::all(folder.path()).iter().map(|found| found.name().to_owned()).collect();
        names.sort();
        assert_eq!(names, ["0", "1", "2"]);
    }

    #[test]
    fn other_files_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let files = [
            ("empty.toml", String::new()),
            ("scene.toml", "name = \"a\"\n".to_owned()),
            ("later.toml", format!("{HEAD}{{\"format\":2}}\n")),
            ("damaged.toml", format!("{HEAD}{{\"format\":1,\n")),
            ("notes.txt", "…".to_owned()),
        ];
        for (name, text) in &files {
            fs::write(folder.path().join(name), text).unwrap();
        }
        fs::create_dir(folder.path().join("folder.toml")).unwrap();
        assert_eq!(Found::all(folder.path()), []);
        for (name, text) in &files {
            assert_eq!(fs::read_to_string(folder.path().join(name)).unwrap(), *text);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), files.len() + 1, "nothing was added");
        assert_eq!(Found::all(&folder.path().join("missing")), []);
    }

    #[test]
    fn what_cannot_be_written_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(Slot::claim(&file).is_err());
        let slot = Slot::claim(folder.path()).unwrap();
        fs::create_dir(slot.path()).unwrap();
        assert!(!slot.write(&edits("a", None)).unwrap_err().is_empty());
    }
}
