//! One writer for each output: an advisory lock of the operating system, which ends with the process that
//! holds it.

use super::refused;
use crate::Failed;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// The right to write a file or folder. It ends when it is dropped, and with the process, however that ends.
pub struct Lock {
    /// The file that is locked. It stands beside what is written.
    path: PathBuf,
    file: File,
}

impl Lock {
    /// The lock of `target`. It is refused while another run holds it.
    ///
    /// # Errors
    /// The place cannot be taken.
    pub fn take(target: &Path) -> Result<Self, Failed> {
        // By whatever name it is called, such as `.` or a link.
        let real = target.canonicalize().unwrap_or_else(|_| target.to_owned());
        Self::hold(super::beside(&real, "lock"), target, File::try_lock)
    }

    /// The lock of `target`, as soon as nobody else holds it: for work of milliseconds.
    pub(super) fn wait(target: &Path) -> Result<Self, Failed> {
        Self::hold(super::beside(target, "lock"), target, |file| file.lock().map_err(TryLockError::Error))
    }

    /// The lock of all that a command writes into `folder` in several steps, each with a lock of its own.
    ///
    /// # Errors
    /// The place cannot be taken.
    pub fn within(folder: &Path) -> Result<Self, Failed> {
        Self::hold(folder.join(".lock"), folder, File::try_lock)
    }

    fn hold(
        path: PathBuf,
        target: &Path,
        lock: impl Fn(&File) -> Result<(), TryLockError>,
    ) -> Result<Self, Failed> {
        let wrong = |error: io::Error| {
            let remedy = "Give a place in which you may write, on a file system that can lock files, such as a local disk.";
            refused(target, format!("cannot be locked with {}: {error}", path.display()), remedy)
        };
        loop {
            let mut file = File::options()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&path)
                .map_err(wrong)?;
            match lock(&file) {
                Ok(()) if is_at(&file, &path).map_err(wrong)? => {
                    sign(&mut file).map_err(wrong)?;
                    return Ok(Self { path, file });
                }
                // The one before removed the file between the two calls: what was locked has no name any
                // more.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(refusal(target, &mut file)),
                Err(TryLockError::Error(error)) => return Err(wrong(error)),
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Removed while it is still locked, so that nobody can lock it in between. Where the system cannot
        // tell whether a file still has its name, it stays; a file that nobody locks is in nobody's way.
        if cfg!(unix) {
            let _ = fs::remove_file(&self.path);
        }
        let _ = self.file.unlock();
    }
}

/// Writes into the file who holds its lock.
fn sign(file: &mut File) -> io::Result<()> {
    let mut words: Vec<String> =
        std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
    if let Some(program) = words.first_mut() {
        // Its name, wherever it lies.
        *program = Path::new(&*program).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    }
    file.set_len(0)?;
    file.rewind()?;
    write!(file, "process {}, `{}`", std::process::id(), words.join(" "))
}

/// The message for those who come later.
fn refusal(target: &Path, file: &mut File) -> Failed {
    let mut holder = String::new();
    // Some systems do not let others read a locked file.
    let known = file.take(400).read_to_string(&mut holder).is_ok() && !holder.is_empty();
    let holder = if known { holder.replace(char::is_control, " ") } else { "unknown".to_owned() };
    let remedy = "Wait until that run has ended, or give another folder.";
    refused(target, format!("another run is writing it (holder: {holder})"), remedy)
}

/// Whether a path still leads to this file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let (held, named) = (file.metadata()?, fs::metadata(path));
    Ok(named.is_ok_and(|named| (held.dev(), held.ino()) == (named.dev(), named.ino())))
}

/// Whether a path still leads to this file: always, since no lock file is removed here.
#[cfg(not(unix))]
#[allow(clippy::unnecessary_wraps, reason = "as on unix")]
fn is_at(_: &File, _: &Path) -> io::Result<bool> {
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn behaviour_a_lock_has_one_holder_and_leaves_nothing() {
        let folder = std::env::temp_dir().join(format!("rijke-lock-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let target = folder.join("out");
        let held = Lock::take(&target).unwrap();
        let said = Lock::take(&target).err().unwrap().to_string();
        assert!(said.contains(&format!("process {}", std::process::id())), "{said}");
        assert!(said.contains("out: another run is writing it"), "{said}");
        drop(held);
        drop(Lock::take(&target).unwrap());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn behaviour_of_many_that_wait_one_writes_at_a_time() {
        let folder = std::env::temp_dir().join(format!("rijke-locks-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let (target, count) = (folder.join("out"), folder.join("count"));
        fs::write(&count, "0").unwrap();
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..100 {
                        let _lock = Lock::wait(&target).unwrap();
                        let seen: u32 = fs::read_to_string(&count).unwrap().parse().unwrap();
                        fs::write(&count, (seen + 1).to_string()).unwrap();
                    }
                });
            }
        });
        assert_eq!(fs::read_to_string(&count).unwrap(), "800");
        fs::remove_dir_all(&folder).unwrap();
    }
}
