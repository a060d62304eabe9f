//! Output that is either whole or absent.

use crate::failure::{Classify, Failure};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Writes a file that appears under its name only when it is complete.
pub(crate) fn write_whole(path: &Path, content: &[u8]) -> Result<(), Failure> {
    if path.file_name().is_none() || path.is_dir() {
        return Err(Failure::bad_input(format!("{}: not the name of a file", path.display()))
            .remedy("Name a file to be written."));
    }
    let partial = beside(path, "partial");
    fs::write(&partial, content)
        .and_then(|()| fs::rename(&partial, path))
        .or_bad_input()
        .map_err(|f| f.at(path).remedy("Give a place in which you may write."))
}

/// Ending of the name of a folder that is being replaced.
const REPLACED: &str = "replaced";

/// A folder that appears under its name only when it is complete. Until then it is written beside its place as
/// `NAME.partial`, which is removed when the command fails, and by the next run if the command was killed.
pub(crate) struct StagedFolder {
    target: PathBuf,
    partial: PathBuf,
}

impl StagedFolder {
    /// Starts writing `target`. A non-empty `target` is refused, unless `force` is given and it holds `mark`, a file
    /// that every finished folder of this kind has: a folder of anything else is never removed.
    pub(crate) fn new(target: &Path, mark: &str, force: bool) -> Result<Self, Failure> {
        let shown = target.display();
        let replaced = beside(target, REPLACED);
        if replaced.join(mark).is_file() {
            // A run was killed while it put its folder in the place of this one.
            let mended =
                if target.exists() { fs::remove_dir_all(&replaced) } else { fs::rename(&replaced, target) };
            mended.or_failed().map_err(|f| f.at(&replaced))?;
        }
        if target.file_name().is_none() {
            return Err(Failure::bad_input(format!("{shown}: not the name of a folder"))
                .remedy("Name a folder to be created, such as results."));
        }
        let occupied = match fs::read_dir(target) {
            Ok(mut entries) => entries.next().is_some(),
            Err(_) => target.exists(),
        };
        if occupied && !force {
            return Err(Failure::bad_input(format!("{shown}: exists already"))
                .remedy("Give another folder, or replace this one with --force."));
        }
        if occupied && !target.join(mark).is_file() {
            return Err(Failure::bad_input(format!(
                "{shown}: holds no {mark}, so it may hold something else"
            ))
            .remedy("Give another folder, or remove this one yourself."));
        }
        let partial = beside(target, "partial");
        if partial.exists() {
            fs::remove_dir_all(&partial).or_failed().map_err(|f| f.at(&partial))?;
        }
        fs::create_dir_all(&partial)
            .or_bad_input()
            .map_err(|f| f.at(&partial).remedy("Give a place in which you may write."))?;
        Ok(Self { target: target.to_owned(), partial })
    }

    /// Where to write for now.
    pub(crate) fn path(&self) -> &Path {
        &self.partial
    }

    /// Puts the finished folder in its place.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        let (target, old) = (&self.target, beside(&self.target, REPLACED));
        if target.is_dir() {
            fs::rename(target, &old).or_failed().map_err(|f| f.at(target))?;
        }
        fs::rename(&self.partial, target).or_failed().map_err(|f| f.at(target))?;
        if old.is_dir() {
            fs::remove_dir_all(&old).or_failed().map_err(|f| f.at(&old))?;
        }
        Ok(())
    }
}

/// `NAME.ending` in the folder of `NAME`.
fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".");
    name.push(ending);
    path.with_file_name(name)
}

impl Drop for StagedFolder {
    fn drop(&mut self) {
        // After a commit there is nothing left to remove; an error here could only hide the one that matters.
        let _ = fs::remove_dir_all(&self.partial);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_folder_is_whole_or_absent_and_foreign_ones_are_kept() {
        let target = std::env::temp_dir().join(format!("rijke-staging-{}", std::process::id())).join("out");
        let start = |force| StagedFolder::new(&target, "mark.toml", force);
        let staged = start(false).unwrap();
        fs::write(staged.path().join("mark.toml"), "").unwrap();
        assert!(!target.exists());
        staged.commit().unwrap();
        assert!(target.join("mark.toml").is_file() && !beside(&target, "partial").exists());

        // Existing: only with force, and then whole or unchanged.
        assert!(start(false).is_err());
        let staged = start(true).unwrap();
        fs::write(staged.path().join("new"), "").unwrap();
        drop(staged);
        assert!(target.join("mark.toml").is_file() && !beside(&target, "partial").exists());

        // Killed between the two renames: the old folder comes back. Killed after them: it goes.
        fs::rename(&target, beside(&target, REPLACED)).unwrap();
        assert!(start(false).is_err() && target.join("mark.toml").is_file());
        fs::create_dir(beside(&target, REPLACED)).unwrap();
        fs::write(beside(&target, REPLACED).join("mark.toml"), "").unwrap();
        assert!(start(false).is_err() && !beside(&target, REPLACED).exists());

        // Something else: never.
        fs::remove_file(target.join("mark.toml")).unwrap();
        fs::write(target.join("thesis.tex"), "").unwrap();
        assert!(start(true).is_err() && target.join("thesis.tex").is_file());
        fs::remove_dir_all(target.parent().unwrap()).unwrap();
    }
}
