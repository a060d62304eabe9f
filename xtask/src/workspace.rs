//! What every task needs: the folder of the workspace, its cargo, and how a task ends.

use crate::child;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{fs, io};

/// What went wrong, for the terminal.
pub(crate) type Outcome = Result<(), String>;

/// The folder of the workspace.
pub(crate) fn root() -> PathBuf {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    here.parent().map(PathBuf::from).unwrap_or(here)
}

/// The cargo that runs this task.
pub(crate) fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    command
}

/// Says at which path a call failed.
pub(crate) fn at<E: Display>(path: &Path) -> impl Fn(E) -> String {
    move |error| format!("{}: {error}", path.display())
}

/// The whole of a text file.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(at(path))
}

/// Writes a file, and the folders that it needs.
pub(crate) fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Outcome {
    path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(path, bytes)).map_err(at(path))
}

/// What stands in a folder, in order.
pub(crate) fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let all = fs::read_dir(folder).map_err(at(folder))?.map(|entry| entry.map(|e| e.path()));
    let mut all = all.collect::<io::Result<Vec<_>>>().map_err(at(folder))?;
    all.sort();
    Ok(all)
}

/// The files below a folder, relative to it, in order.
pub(crate) fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let (path, name) = entry.map(|e| (e.path(), PathBuf::from(e.file_name())))?;
        match path.is_dir() {
            true => found.extend(files(&path)?.into_iter().map(|file| name.join(file))),
            false => found.push(name),
        }
    }
    found.sort();
    Ok(found)
}

/// Where cargo puts the program.
pub(crate) fn program() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    root().join(target).join("release").join(format!("rijke{}", std::env::consts::EXE_SUFFIX))
}

/// The program `rijke`, built.
pub(crate) fn built() -> Result<PathBuf, String> {
    succeed(cargo().args(["build", "--release", "--workspace", "--bin", "rijke"]))?;
    Ok(program())
}

/// Runs a program to its end.
pub(crate) fn succeed(command: &mut Command) -> Outcome {
    let shown = || {
        let words = std::iter::once(command.get_program()).chain(command.get_args());
        words.map(|w| w.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
    };
    let shown = shown();
    match child::run(command, |_| ()) {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{shown}` ended with {status}")),
        Err(error) => Err(format!("cannot start `{shown}`: {error}")),
    }
}
