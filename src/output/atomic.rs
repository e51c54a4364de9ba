//! Files that appear whole or not at all.

use crate::error::{Error, Result};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

/// The temporary files of this process, for [`discard_pending`].
static PENDING: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A file being written under a temporary name beside its target. It takes the target's place in
/// [`PendingFile::complete`]; dropped before that, it vanishes and the target is as it was.
#[derive(Debug)]
pub struct PendingFile {
    /// As the user named it, for messages.
    path: PathBuf,
    /// Where it goes: `path`, or what `path` links to.
    target: PathBuf,
    part: PathBuf,
    file: Option<File>,
}

impl PendingFile {
    /// Opens the temporary file.
    ///
    /// # Errors
    ///
    /// [`Error::File`] if the folder is missing or not writable, or the target exists and is read-only or no regular
    /// file.
    pub fn create(path: &Path) -> Result<PendingFile> {
        let target = resolve(path)?;
        for attempt in 0.. {
            let part = part_name(&target);
            match OpenOptions::new().write(true).create_new(true).open(&part) {
                Ok(file) => {
                    lock().insert(part.clone());
                    return Ok(PendingFile { path: path.into(), target, part, file: Some(file) });
                }
                // Left over by a killed process that had our number.
                Err(error) if error.kind() == ErrorKind::AlreadyExists && attempt < 100 => {}
                Err(error) => return Err(cannot_create(path, &error)),
            }
        }
        unreachable!("the last attempt returns")
    }

    /// Lets `write` fill the file and puts it in the target's place.
    ///
    /// # Errors
    ///
    /// [`Error::Failed`] if `write` or the file system fails; the target is then as it was.
    pub fn complete(mut self, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<()> {
        let file = self.file.take().expect("a pending file is open until it is completed");
        self.fill_and_rename(file, write).map_err(|error| {
            Error::Failed(format!(
                "{}: cannot be written ({error}); see to the disk and try again",
                self.path.display()
            ))
        })
    }

    fn fill_and_rename(
        &self,
        file: File,
        write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut writer = BufWriter::with_capacity(1 << 16, file);
        write(&mut writer)?;
        writer.flush()?;
        drop(writer);
        if let Ok(replaced) = fs::metadata(&self.target) {
            fs::set_permissions(&self.part, replaced.permissions())?;
        }
        // Under the lock, so that `discard_pending` comes either before or after, never in between.
        let mut pending = lock();
        fs::rename(&self.part, &self.target)?;
        pending.remove(&self.part);
        Ok(())
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        // Some systems do not remove open files.
        self.file = None;
        if lock().remove(&self.part) {
            let _ = fs::remove_file(&self.part);
        }
    }
}

/// Removes the temporary files of all [`PendingFile`]s, for a process that is about to exit without unwinding.
pub fn discard_pending() {
    for part in std::mem::take(&mut *lock()) {
        let _ = fs::remove_file(part);
    }
}

fn lock() -> std::sync::MutexGuard<'static, BTreeSet<PathBuf>> {
    PENDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Follows links and refuses what a rename could not or should not replace.
fn resolve(path: &Path) -> Result<PathBuf> {
    let meta = match fs::metadata(path) {
        Ok(meta) => meta,
        Err(_) => return Ok(path.to_path_buf()),
    };
    if meta.is_dir() {
        return Err(Error::file(path, "this is a folder", "give a file name in it"));
    }
    if !meta.is_file() {
        return Err(Error::file(path, "this is not a regular file", "choose another name"));
    }
    if meta.permissions().readonly() {
        return Err(Error::file(path, "the file is read-only", "make it writable or choose another name"));
    }
    fs::canonicalize(path).map_err(|error| cannot_create(path, &error))
}

fn part_name(target: &Path) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let mut name = target.file_name().map_or_else(OsString::new, OsString::from);
    name.push(format!(".{}-{}.part", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
    target.with_file_name(name)
}

fn cannot_create(path: &Path, error: &io::Error) -> Error {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.exists() {
        let what = format!("the folder {} does not exist", folder.display());
        return Error::file(path, what, "create it or choose another");
    }
    Error::file(path, format!("cannot be created ({error})"), "choose another name or folder")
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn the_target_is_untouched_until_the_file_is_complete() {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let pending = PendingFile::create(&path).unwrap();
        assert_eq!(names(folder.path()).len(), 2);
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        pending.complete(|file| file.write_all(b"new")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn dropping_leaves_no_trace() {
        let folder = TempDir::new().unwrap();
        drop(PendingFile::create(&folder.path().join("a.txt")).unwrap());
        assert_eq!(names(folder.path()).len(), 0);
    }

    #[test]
    fn a_failed_write_leaves_the_target_as_it_was() {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let error = PendingFile::create(&path)
            .unwrap()
            .complete(|file| {
                file.write_all(b"half")?;
                Err(io::Error::other("disk on fire"))
            })
            .unwrap_err();
        assert_eq!(error.exit_code(), 1);
        assert!(error.to_string().contains("a.txt: cannot be written (disk on fire)"), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_missing_folder_a_folder_and_a_device_are_refused_at_once() {
        let folder = TempDir::new().unwrap();
        let missing = PendingFile::create(&folder.path().join("no/a.txt")).unwrap_err().to_string();
        assert!(missing.ends_with("does not exist; create it or choose another"), "{missing}");
        let itself = PendingFile::create(folder.path()).unwrap_err().to_string();
        assert!(itself.ends_with("this is a folder; give a file name in it"), "{itself}");
        let nameless = PendingFile::create(&folder.path().join("..")).unwrap_err().to_string();
        assert!(nameless.contains("this is a folder"), "{nameless}");
        if Path::new("/dev/null").exists() {
            let device = PendingFile::create(Path::new("/dev/null")).unwrap_err().to_string();
            assert!(device.contains("not a regular file"), "{device}");
        }
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(PendingFile::create(&file.join("a.txt")).is_err());
    }

    #[test]
    fn a_read_only_file_is_respected() {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        assert!(PendingFile::create(&path).unwrap_err().to_string().contains("read-only"));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_permissions_stay() {
        use std::os::unix::fs::PermissionsExt;
        let folder = TempDir::new().unwrap();
        let (real, link) = (folder.path().join("real.txt"), folder.path().join("link.txt"));
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o600)).unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        PendingFile::create(&link).unwrap().complete(|file| file.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "new");
        assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o600);
    }
}
