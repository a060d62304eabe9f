//! Output that is either whole or absent, written by one run at a time.

mod lock;

use crate::{Classify, Failed};
pub use lock::Lock;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// What to do where the system lets nobody write.
const ELSEWHERE: &str = "Give a place in which you may write.";

/// A folder that appears under its name only when it is complete. Until then it is written beside its place
/// under a name of this process, which is removed when it is dropped, and by the next process if this one was
/// killed.
pub struct StagedFolder {
    target: PathBuf,
    partial: PathBuf,
    /// The names that are written; others in `target` are kept. None if all of it is.
    own: Option<&'static [&'static str]>,
    /// How many folders of runs that were killed were removed.
    left: usize,
    /// The right to write `target`; the last field, because it must outlive the others.
    _lock: Lock,
}

/// Ending of the name of a folder that is being replaced.
const REPLACED: &str = "replaced";

impl StagedFolder {
    /// Starts writing `target`. A non-empty `target` is refused, unless `force` is given and it holds `mark`,
    /// a file that every finished folder of this kind has: a folder of anything else is never removed. It is
    /// refused too while another run writes it.
    ///
    /// # Errors
    /// The place cannot be taken.
    pub fn new(target: &Path, mark: &str, force: bool) -> Result<Self, Failed> {
        Self::start(target, mark, None, force)
    }

    /// As [`Self::new`], for a folder in which the user may keep files: all but those with the names `own`
    /// stay, and a folder that holds none of `own` counts as empty.
    ///
    /// # Errors
    /// The place cannot be taken.
    pub fn beside_others(
        target: &Path,
        mark: &str,
        own: &'static [&'static str],
        force: bool,
    ) -> Result<Self, Failed> {
        Self::start(target, mark, Some(own), force)
    }

    fn start(
        target: &Path,
        mark: &str,
        own: Option<&'static [&'static str]>,
        force: bool,
    ) -> Result<Self, Failed> {
        if target.file_name().is_none() {
            let remedy = "Name a folder to be created, such as results.";
            return Err(refused(target, "not the name of a folder", remedy));
        }
        let given = target;
        // A link is followed, so that its folder has one lock whatever it is called.
        let target = target.canonicalize().unwrap_or_else(|_| target.to_owned());
        if let Some(parent) = target.parent() {
            fs::create_dir_all(parent).map_err(|e| refused(parent, e, ELSEWHERE))?;
        }
        let lock = Lock::take(&target)?;
        let replaced = replaced(&target);
        if replaced.join(mark).is_file() {
            // A run was killed while it put its folder in the place of this one.
            let mended =
                if target.exists() { fs::remove_dir_all(&replaced) } else { fs::rename(&replaced, &target) };
            mended.map_err(failed(&replaced))?;
        }
        let occupied = match fs::read_dir(&target) {
            Ok(mut entries) => match own {
                Some(own) => own.iter().any(|name| target.join(name).exists()),
                None => entries.next().is_some(),
            },
            Err(_) => target.exists(),
        };
        if occupied && !force {
            let remedy = match target.join(mark).is_file() {
                true => "Give another name, or --force, which replaces what stands there.",
                false => "Move it away, or give another name.",
            };
            return Err(refused(given, "exists already", remedy));
        }
        if occupied && !target.join(mark).is_file() {
            let what = format!("holds no {mark}, so it may hold something else");
            return Err(refused(given, what, "Give another folder, or remove this one yourself."));
        }
        let (partial, left) = start_afresh(&target).map_err(failed(&target))?;
        fs::create_dir(&partial).map_err(|e| refused(&partial, e, ELSEWHERE))?;
        Ok(Self { target, partial, own, left, _lock: lock })
    }

    /// Where a run before this one was killed, the folder beside which what it left unfinished was removed.
    #[must_use]
    pub fn after_killed_run(&self) -> Option<&Path> {
        (self.left > 0).then_some(&self.target)
    }

    /// Where to write for now.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Puts the finished folder in its place.
    ///
    /// # Errors
    /// The system's.
    pub fn commit(self) -> Result<(), Failed> {
        let (target, old) = (&self.target, replaced(&self.target));
        if let Some(own) = self.own.filter(|_| target.is_dir()) {
            keep_others(target, &self.partial, own).map_err(failed(target))?;
        }
        if target.is_dir() {
            fs::rename(target, &old).map_err(failed(target))?;
        }
        fs::rename(&self.partial, target).map_err(failed(target))?;
        if old.is_dir() {
            fs::remove_dir_all(&old).map_err(failed(&old))?;
        }
        Ok(())
    }
}

impl Drop for StagedFolder {
    fn drop(&mut self) {
        // After a commit there is nothing left to remove; an error here could only hide the one that matters.
        let _ = fs::remove_dir_all(&self.partial);
    }
}

/// Copies what a folder holds beside files of the names `own`.
///
/// # Errors
/// The system's.
pub fn keep_others(from: &Path, to: &Path, own: &[&str]) -> io::Result<()> {
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let name = entry.file_name();
        if own.iter().any(|own| name == *own) {
            continue;
        }
        let place = to.join(&name);
        if entry.path().is_dir() {
            fs::create_dir_all(&place)?;
            keep_others(&entry.path(), &place, &[])?;
        } else {
            fs::copy(entry.path(), place)?;
        }
    }
    Ok(())
}

/// Writes a file, and the folders above it, into a folder that nobody else reads yet.
///
/// # Errors
/// The system's, with the file.
pub fn write_within(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> Result<(), Failed> {
    let path = folder.join(name);
    let made = path.parent().map_or(Ok(()), fs::create_dir_all);
    made.and_then(|()| fs::write(&path, content)).or_failed().map_err(|f| f.at(&path))
}

/// As [`write_whole`](crate::write_whole), for a place that a user names: a link is followed, what is no
/// regular file (a pipe, a device) is written to as it is, and what killed runs left beside it is removed.
///
/// # Errors
/// The place cannot be taken.
pub fn write_output(path: &Path, content: &[u8]) -> Result<(), Failed> {
    if path.file_name().is_none() || path.is_dir() {
        return Err(refused(path, "not the name of a file", "Name a file to be written."));
    }
    let fault = |error: io::Error| refused(path, error, ELSEWHERE);
    if path.exists() && !path.is_file() {
        return fs::write(path, content).map_err(fault);
    }
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if target.parent().is_some_and(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
        return Err(refused(path, "its folder does not exist", ELSEWHERE));
    }
    let _lock = Lock::wait(&target)?;
    start_afresh(&target).and_then(|_| crate::write_whole(&target, content)).map_err(fault)
}

/// A place that cannot be taken.
fn refused(path: &Path, what: impl std::fmt::Display, remedy: &'static str) -> Failed {
    Failed::bad_input(format!("{}: {what}", path.display())).remedy(remedy)
}

/// Writing failed although the place could be taken.
fn failed(path: &Path) -> impl FnOnce(io::Error) -> Failed {
    move |error| Failed::of_work(format!("{}: {error}", path.display()))
}

/// The name under which this process writes `target` until it is whole. Removes what earlier runs left under
/// such names: only the holder of the lock of `target` writes there, so they have ended.
fn start_afresh(target: &Path) -> io::Result<(PathBuf, usize)> {
    let prefix = beside(target, "partial-");
    let prefix = prefix.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut left = 0;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let process = name.to_str().and_then(|name| name.strip_prefix(&*prefix));
        if process.is_none_or(|id| id.is_empty() || !id.bytes().all(|b| b.is_ascii_digit() || b == b'-')) {
            continue;
        }
        left += 1;
        if entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        } else {
            fs::remove_file(entry.path())?;
        }
    }
    Ok((target.with_file_name(format!("{prefix}{}", std::process::id())), left))
}

/// `NAME.replaced` in the folder of `NAME`: what stood there before.
fn replaced(target: &Path) -> PathBuf {
    let mut name = target.file_name().unwrap_or_default().to_owned();
    name.push(".");
    name.push(REPLACED);
    target.with_file_name(name)
}

/// `.NAME.ending` in the folder of `NAME`: a hidden file or folder of the program's own.
fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".");
    name.push(ending);
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scratch(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("rijke-staging-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    /// Names of all that stands in a folder.
    fn names(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    #[test]
    fn behaviour_a_folder_is_whole_or_absent_and_foreign_ones_are_kept() {
        let folder = scratch("folder");
        let target = folder.join("out");
        let start = |force| StagedFolder::new(&target, "mark.toml", force);
        let staged = start(false).unwrap();
        fs::write(staged.path().join("mark.toml"), "").unwrap();
        assert!(!target.exists());
        staged.commit().unwrap();
        assert!(target.join("mark.toml").is_file());
        assert_eq!(names(&folder), ["out"]);

        // Existing: only with force, and then whole or unchanged.
        assert!(start(false).is_err());
        let staged = start(true).unwrap();
        fs::write(staged.path().join("new"), "").unwrap();
        drop(staged);
        assert!(target.join("mark.toml").is_file());
        assert_eq!(names(&folder), ["out"]);

        // What the user keeps there stays, and counts as nothing of ours.
        let kept = folder.join("kept");
        fs::create_dir_all(kept.join("notes")).unwrap();
        fs::write(kept.join("readings.csv"), "mine").unwrap();
        fs::write(kept.join("notes/one"), "mine").unwrap();
        for force in [false, true] {
            let staged = StagedFolder::beside_others(&kept, "mark.toml", &["mark.toml"], force).unwrap();
            fs::write(staged.path().join("mark.toml"), "").unwrap();
            staged.commit().unwrap();
            assert_eq!(names(&kept), ["mark.toml", "notes", "readings.csv"]);
            assert_eq!(fs::read_to_string(kept.join("notes/one")).unwrap(), "mine");
        }
        assert!(StagedFolder::beside_others(&kept, "mark.toml", &["mark.toml"], false).is_err());
        fs::remove_dir_all(&kept).unwrap();

        // Killed between the two renames: the old folder comes back. Killed after them: it goes.
        fs::rename(&target, replaced(&target)).unwrap();
        assert!(start(false).is_err() && target.join("mark.toml").is_file());
        fs::create_dir(replaced(&target)).unwrap();
        fs::write(replaced(&target).join("mark.toml"), "").unwrap();
        assert!(start(false).is_err() && !replaced(&target).exists());

        // Something else: never.
        fs::remove_file(target.join("mark.toml")).unwrap();
        fs::write(target.join("thesis.tex"), "").unwrap();
        assert!(start(true).is_err() && target.join("thesis.tex").is_file());
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn behaviour_what_a_killed_run_left_is_removed_and_nothing_else() {
        let folder = scratch("left");
        // A lock file that nobody holds and the staging folder of a process that has ended.
        fs::write(folder.join(".out.lock"), "process 1").unwrap();
        fs::create_dir(folder.join(".out.partial-4000000001")).unwrap();
        fs::write(folder.join(".out.partial-4000000001/half"), "").unwrap();
        fs::write(folder.join(".out.partial-mine"), "").unwrap();
        fs::create_dir(folder.join(".other.partial-1")).unwrap();
        let staged = StagedFolder::new(&folder.join("out"), "mark.toml", false).unwrap();
        assert_eq!(staged.left, 1);
        drop(staged);
        assert_eq!(names(&folder), [".other.partial-1", ".out.partial-mine"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn behaviour_a_folder_has_one_writer() {
        let folder = scratch("writer");
        let held = StagedFolder::new(&folder.join("out"), "mark.toml", true).unwrap();
        let said = StagedFolder::new(&folder.join("out"), "mark.toml", true).err().unwrap().to_string();
        assert!(said.contains("another run is writing it"), "{said}");
        assert!(held.path().is_dir(), "the second leaves the first alone");
        drop(held);
        assert!(names(&folder).is_empty());
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    #[cfg(unix)]
    fn behaviour_a_file_is_whole_and_a_link_or_device_stays_what_it_is() {
        let folder = scratch("file");
        fs::write(folder.join("real.csv"), "old").unwrap();
        fs::write(folder.join(".real.csv.partial-4000000001"), "half").unwrap();
        std::os::unix::fs::symlink("real.csv", folder.join("link.csv")).unwrap();
        write_output(&folder.join("link.csv"), b"new").unwrap();
        assert_eq!(fs::read_to_string(folder.join("real.csv")).unwrap(), "new");
        assert_eq!(names(&folder), ["link.csv", "real.csv"]);
        assert!(folder.join("link.csv").is_symlink());
        write_output(Path::new("/dev/null"), b"gone").unwrap();
        assert!(!Path::new("/dev/null").is_file());
        fs::remove_dir_all(folder).unwrap();
    }
}
