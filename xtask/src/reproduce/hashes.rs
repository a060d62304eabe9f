//! SHA-256 of texts, files and folders.

use crate::workspace::{at, files};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::{collections::BTreeMap, fs};

pub(super) fn text(text: &str) -> String {
    hex(text.as_bytes())
}

pub(super) fn file(path: &Path) -> Result<String, String> {
    fs::read(path).map(|bytes| hex(&bytes)).map_err(at(path))
}

/// The hash of every file under a folder whose name does not start with a dot, by path from the root.
pub(super) fn folder(root: &Path, folder: &Path) -> Result<BTreeMap<String, String>, String> {
    let shown = |f: &PathBuf| !f.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
    let hash = |f: PathBuf| {
        let path = folder.join(f);
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        Ok((name, file(&path)?))
    };
    files(folder).map_err(at(folder))?.into_iter().filter(shown).map(hash).collect()
}

fn hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_hash_of_three_letters() {
        // FIPS 180-2, appendix B.1.
        assert_eq!(text("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
