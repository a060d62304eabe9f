//! `cargo xtask tidy`: what the compiler does not check. Each rule is a function from text to complaints, so
//! that its tests can show it failing.

mod arrows;
mod assertions;
mod circles;
mod code;
mod file;
mod names;
mod sources;
mod texts;

use crate::workspace::{Outcome, at, entries};
use file::File;
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Applies every rule; fails with all complaints.
pub(crate) fn run(root: &Path) -> Outcome {
    let files = read(root)?;
    let mut complaints = arrows::check(&files);
    complaints.extend(sources::check(&files));
    complaints.extend(texts::check(&files));
    complaints.extend(assertions::check(&files));
    complaints.extend(circles::check(&files));
    complaints.extend(names::check(&files));
    complaints.sort();
    if complaints.is_empty() {
        let median = sources::median_lines(&files);
        println!("tidy: {} files in order, half of the sources below {median} lines", files.len());
        return Ok(());
    }
    Err(format!("tidy has {} complaints\n  {}", complaints.len(), complaints.join("\n  ")))
}

/// The manifests, sources and pages of the repository, sorted by path.
fn read(root: &Path) -> Result<Vec<File>, String> {
    let mut folders = vec![root.to_owned()];
    let mut paths: Vec<PathBuf> = Vec::new();
    while let Some(folder) = folders.pop() {
        for path in entries(&folder)? {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let left_out = name.starts_with('.') || ["results", "virtual-rig"].contains(&&*name);
            if name == "target" || (left_out && folder == root) {
                continue;
            }
            match path.extension().and_then(|e| e.to_str()) {
                _ if path.is_dir() => folders.push(path),
                Some("rs" | "md" | "toml") => paths.push(path),
                _ => {}
            }
        }
    }
    paths.sort();
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).map_err(at(&path))?;
        let path = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        Ok(File { path, text })
    };
    paths.into_iter().map(read).collect()
}
