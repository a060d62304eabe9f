//! Output that is either whole or absent.

#![allow(dead_code, reason = "used by the subcommands that follow")]

use crate::failure::{Classify, Failure};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// A folder that appears under its name only when it is complete. Until then it is written beside its place as
/// `NAME.partial`, which is removed when the command fails, and by the next run if the command was killed.
pub(crate) struct StagedFolder {
    target: PathBuf,
    partial: PathBuf,
}

impl StagedFolder {
    /// Starts writing `target`. An existing, non-empty `target` is refused unless `force`, and is replaced only by
    /// [`StagedFolder::commit`].
    pub(crate) fn new(target: &Path, force: bool) -> Result<Self, Failure> {
        let name = target.file_name().ok_or_else(|| {
            Failure::bad_input(format!("{}: not the name of a folder", target.display()))
                .remedy("Name a folder to be created, such as results.")
        })?;
        let occupied = match fs::read_dir(target) {
            Ok(mut entries) => entries.next().is_some(),
            Err(_) => target.exists(),
        };
        if occupied && !force {
            return Err(Failure::bad_input(format!("{}: exists already", target.display()))
                .remedy("Give another folder with --out, or replace this one with --force."));
        }
        let partial = target.with_file_name(format!("{}.partial", name.to_string_lossy()));
        if partial.exists() {
            fs::remove_dir_all(&partial).or_failed().map_err(|f| f.at(&partial))?;
        }
        fs::create_dir_all(&partial)
            .or_bad_input()
            .map_err(|f| f.at(&partial).remedy("Give a place in which you may write with --out."))?;
        Ok(Self { target: target.to_owned(), partial })
    }

    /// Where to write for now.
    pub(crate) fn path(&self) -> &Path {
        &self.partial
    }

    /// Puts the finished folder in its place.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        if self.target.is_dir() {
            fs::remove_dir_all(&self.target).or_failed().map_err(|f| f.at(&self.target))?;
        }
        fs::rename(&self.partial, &self.target).or_failed().map_err(|f| f.at(&self.target))
    }
}

impl Drop for StagedFolder {
    fn drop(&mut self) {
        // After a commit there is nothing left to remove; an error here could only hide the one that matters.
        let _ = fs::remove_dir_all(&self.partial);
    }
}
