//! Folders: what they hold, and copies of them.

use std::{fs, io, path::Path};

/// Files that the program reads and never writes: linked, not copied.
pub(super) fn linked(path: &Path) -> bool {
    path.extension().and_then(|e| e.to_str()).is_some_and(|e| ["wav", "mat", "h5"].contains(&e))
}

/// Copies a folder. What is there already stays.
pub(super) fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let path = entry?.path();
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy(&path, &target)?;
        } else if !linked(&path) || fs::hard_link(&path, &target).is_err() {
            fs::copy(&path, &target)?;
        }
    }
    Ok(())
}
