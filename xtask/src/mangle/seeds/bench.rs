//! Where seeds are made: folders, files, and the program that makes some of them.

use crate::mangle::folder::copy;
use crate::mangle::limits::{self, End, LIMITS};
pub(super) use crate::workspace::write;
use crate::workspace::{Outcome, at, read, root};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// A folder that the program takes, and the commands that read it.
pub(crate) struct Seed {
    /// Kind of input, under which its cases are counted.
    pub(crate) kind: &'static str,
    pub(crate) name: String,
    pub(crate) folder: PathBuf,
    /// Arguments of the program, which runs in the folder.
    pub(crate) commands: Vec<String>,
    /// Files and folders that are changed; all, if there are none.
    pub(crate) changed: Vec<PathBuf>,
}

impl Seed {
    pub(crate) fn new(kind: &'static str, name: &str, folder: PathBuf, commands: &[&str]) -> Self {
        let commands = commands.iter().map(|c| (*c).to_owned()).collect();
        Self { kind, name: name.to_owned(), folder, commands, changed: Vec::new() }
    }
}

/// Where seeds are made, and what is made of them so far.
pub(super) struct Bench<'a> {
    pub(super) program: &'a Path,
    pub(super) place: &'a Path,
    pub(super) seeds: Vec<Seed>,
}

impl Bench<'_> {
    /// A new folder for a seed of this kind and name.
    pub(super) fn folder(&self, kind: &str, name: &str) -> Result<PathBuf, String> {
        let folder = self.place.join(kind).join(name);
        fs::create_dir_all(&folder).map_err(at(&folder))?;
        Ok(folder)
    }

    /// Adds a seed whose files are changed below `changed` only, or everywhere.
    pub(super) fn add(&mut self, kind: &'static str, folder: PathBuf, commands: &[&str], changed: &[&str]) {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut seed = Seed::new(kind, &name, folder, commands);
        seed.changed = changed.iter().map(PathBuf::from).collect();
        self.seeds.push(seed);
    }

    /// Runs the program in a folder, to its end.
    pub(super) fn run(&self, folder: &Path, words: &str) -> Outcome {
        let words: Vec<&str> = words.split(' ').collect();
        let run = limits::run(self.program, &words, folder, &LIMITS)?;
        let told = || format!("{}: `rijke {}`: {}", folder.display(), words.join(" "), run.error);
        if run.end == End::Done { Ok(()) } else { Err(told()) }
    }

    /// A study that `rijke new` writes, with its drafts of observations in their place, if it has any.
    pub(super) fn template(&self, kind: &str, template: &str, name: &str) -> Result<PathBuf, String> {
        let folder = self.folder(kind, name)?;
        self.run(&folder, &format!("new study --template {template}"))?;
        let (study, target) = (folder.join("study"), folder.join("new"));
        from(&study, &target)?;
        let draft = study.join("draft/observations");
        if draft.is_dir() {
            from(&draft, &target.join("observations"))?;
        }
        let moved = |e: std::io::Error| format!("{}: {e}", folder.display());
        fs::remove_dir_all(target.join("draft")).map_err(moved)?;
        fs::remove_dir_all(study).map_err(moved)?;
        // One level up.
        let kept = folder.with_extension("kept");
        fs::rename(&target, &kept).and_then(|()| fs::remove_dir(&folder)).map_err(moved)?;
        fs::rename(&kept, &folder).map_err(moved)?;
        Ok(folder)
    }
}

/// Copies a folder.
pub(super) fn from(source: &Path, target: &Path) -> Outcome {
    copy(source, target).map_err(at(source))
}

/// Copies a folder or file of the repository.
pub(super) fn own(source: &str, target: &Path) -> Outcome {
    let source = root().join(source);
    if source.is_dir() {
        return from(&source, target);
    }
    fs::copy(&source, target).map(drop).map_err(at(&source))
}

/// Replaces parts of a file that must be there.
pub(super) fn edit(path: &Path, changes: &[(&str, &str)]) -> Outcome {
    let mut text = read(path)?;
    for (old, new) in changes {
        if !text.contains(old) {
            return Err(format!("{}: `{old}` is not there; the seeds of mangle expect it", path.display()));
        }
        text = text.replace(old, new);
    }
    write(path, text)
}
