//! From bytes to a file in its place.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::WriteError;
use super::stale::clear_stale;
use super::target::{Replaced, Target, folder_of};
use super::temporary::Temporary;

/// Writes a file; see [`super`] for what becomes of the one before.
///
/// # Errors
/// When the target is none that can be written ([`WriteError`]), or `write` fails.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), WriteError> {
    write_through(path, |file| file, write)
}

/// [`write_atomically`], with what `device` makes of the file between the program and the disk: tests put a disk there that fails.
fn write_through<D: Write>(
    path: &Path,
    device: impl FnOnce(File) -> D,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    let failed = |reason| WriteError::System { path: path.to_path_buf(), reason };
    match Target::find(path)? {
        Target::Stream(stream) => {
            let file = OpenOptions::new().write(true).open(stream).map_err(failed)?;
            write_all(device(file), write).map_err(failed)
        }
        Target::File(target) => {
            target.require_replaceable(path)?;
            clear_stale(folder_of(&target.path));
            let temporary = Temporary::beside(&target).map_err(failed)?;
            target.require_owned(path, temporary.file())?;
            replace(&target, temporary, device, write).map_err(failed)
        }
    }
}

fn replace<D: Write>(
    target: &Replaced,
    temporary: Temporary,
    device: impl FnOnce(File) -> D,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    write_all(device(temporary.file().try_clone()?), write)?;
    target.hand_down_permissions(temporary.file())?;
    temporary.file().sync_all()?;
    temporary.rename(&target.path)?;
    sync_folder(folder_of(&target.path));
    Ok(())
}

fn write_all(device: impl Write, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::new(device);
    write(&mut writer)?;
    writer.flush()
}

/// Makes the new name itself outlive a power failure. The file is whole either way, so that what cannot do this (some network and
/// user-space file systems, Windows) is left alone.
fn sync_folder(folder: &Path) {
    #[cfg(unix)]
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    #[cfg(not(unix))]
    let _ = folder;
}

/// Finds out whether [`write_atomically`] would be able to write `path`, without leaving anything behind: to be asked before minutes
/// are spent on a picture that could not be kept. Only a full disk and what changes in between are not found.
///
/// # Errors
/// As [`write_atomically`].
pub fn require_writable(path: &Path) -> Result<(), WriteError> {
    match Target::find(path)? {
        // A FIFO would keep its opener waiting, and end its reader when it is closed.
        Target::Stream(_) => Ok(()),
        Target::File(target) => {
            target.require_replaceable(path)?;
            let failed = |reason| WriteError::System { path: path.to_path_buf(), reason };
            let temporary = Temporary::beside(&target).map_err(failed)?;
            target.require_owned(path, temporary.file())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// A disk that is full after some bytes.
    struct Full {
        file: File,
        left: usize,
    }

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let room = self.left.min(bytes.len());
            if room == 0 {
                return Err(io::Error::new(io::ErrorKind::StorageFull, "the disk is full"));
            }
            let written = self.file.write(&bytes[..room])?;
            self.left -= written;
            Ok(written)
        }

        fn flush(&mut self) -> io::Result<()> {
            self.file.flush()
        }
    }

    fn names_in(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect()
    }

    /// Bytes that fill the buffer several times and end within it.
    fn contents() -> Vec<u8> {
        (0..20_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect()
    }

    #[test]
    fn wherever_the_disk_is_full_the_old_file_stays_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (folder.path().join("old.png"), folder.path().join("new.png"));
        fs::write(&old, "old").unwrap();
        let contents = contents();
        let limits = (0..300).chain((300..contents.len()).step_by(97)).chain(contents.len() - 3..contents.len());
        for left in limits {
            for path in [&old, &new] {
                // In pieces that the buffer passes on at other places than they end.
                let result = write_through(
                    path,
                    |file| Full { file, left },
                    |writer| contents.chunks(123).try_for_each(|piece| writer.write_all(piece)),
                );
                let error = result.expect_err("the file does not fit").to_string();
                assert_eq!(error, format!("{}: cannot be written: the disk is full", path.display()), "after {left}");
                assert_eq!(fs::read_to_string(&old).unwrap(), "old", "after {left}");
                assert_eq!(names_in(folder.path()), ["old.png"], "after {left}");
            }
        }
        // The twin: with just enough room it is there, whole.
        let device = |file| Full { file, left: contents.len() };
        write_through(&old, device, |writer| writer.write_all(&contents)).unwrap();
        assert_eq!(fs::read(&old).unwrap(), contents);
    }

    #[test]
    fn a_target_that_turns_into_a_folder_is_an_error_in_the_users_words() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let result = write_atomically(&path, |writer| {
            fs::create_dir(&path)?;
            writer.write_all(b"late")
        });
        let error = result.unwrap_err().to_string();
        assert!(error.starts_with(&path.display().to_string()) && !error.contains(".iorect-"), "{error}");
        assert_eq!(names_in(folder.path()), ["a.png"]);
    }
}
