//! Temporary files that a killed program left behind.

use std::collections::BTreeSet;
use std::fs::{self, DirEntry, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use super::temporary::{PREFIX, SUFFIX};

/// Least age at which an unlocked file is stale: a younger one may be about to be locked.
const UNLOCKED_AGE: Duration = Duration::from_secs(60);
/// Least age at which a file is stale where files cannot be locked.
const WRITING_AGE: Duration = Duration::from_secs(24 * 3600);

/// Removes temporary files from `folder` that no program writes to any more. A folder is looked through once in a process.
pub(super) fn clear_stale(folder: &Path) {
    static CLEARED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let is_new = CLEARED.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_path_buf());
    if is_new {
        clear(folder, SystemTime::now());
    }
}

fn clear(folder: &Path, now: SystemTime) {
    // A folder that cannot be listed may still be written to.
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_temporary = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        if is_temporary && is_stale(&entry, now) {
            // Another process may be clearing the same folder.
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_stale(entry: &DirEntry, now: SystemTime) -> bool {
    // The entry's own metadata: symbolic links are not followed.
    let Ok(metadata) = entry.metadata() else { return false };
    let Ok(modified) = metadata.modified() else { return false };
    let age = now.duration_since(modified).unwrap_or_default();
    if !metadata.is_file() || age < UNLOCKED_AGE {
        return false;
    }
    match OpenOptions::new().write(true).open(entry.path()).map(|file| file.try_lock()) {
        Ok(Ok(())) => true,
        Ok(Err(TryLockError::WouldBlock)) => false,
        Ok(Err(TryLockError::Error(_))) => age > WRITING_AGE,
        // Another user's file.
        Err(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    #[test]
    fn only_what_nobody_writes_to_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let make = |name: &str, age: u64| {
            let file = File::create(at(name)).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(age)).unwrap();
            file
        };
        make(".iorect-left.tmp", 3600);
        make(".iorect-fresh.tmp", 5);
        make(".iorect-other.png", 1 << 20);
        make("iorect-mine.tmp", 1 << 20);
        let busy = make(".iorect-busy.tmp", 3600);
        busy.lock().unwrap();
        fs::create_dir(at(".iorect-folder.tmp")).unwrap();
        clear(folder.path(), SystemTime::now());
        let mut names: Vec<String> =
            fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        let kept =
            [".iorect-busy.tmp", ".iorect-folder.tmp", ".iorect-fresh.tmp", ".iorect-other.png", "iorect-mine.tmp"];
        assert_eq!(names, kept);
        // The writer is gone, or a minute has passed: they go too.
        drop(busy);
        clear(folder.path(), SystemTime::now() + Duration::from_secs(120));
        assert!(!at(".iorect-busy.tmp").exists() && !at(".iorect-fresh.tmp").exists());
    }
}
