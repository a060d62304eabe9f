//! Of which files a folder of results was made, and which of them are others now.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::{fs, io};

/// The digest of each file, by its path below the folder that holds them all: SHA-256, of which the first
/// 64 bits are kept.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct MadeOf(BTreeMap<String, String>);

impl MadeOf {
    /// Name of the file that says so, in the folder that was made.
    pub const FILE: &str = "made_of.json";

    /// All files of a folder of records but observations in it.
    ///
    /// # Errors
    /// The system's.
    pub fn records(folder: &Path) -> io::Result<Self> {
        Self::of(folder, &|path| !path.starts_with("observations/"))
    }

    /// What a ranking reads of the study in `dir`: every table and TOML file, but no records and no results.
    ///
    /// # Errors
    /// The system's.
    pub fn study(dir: &Path) -> io::Result<Self> {
        Self::of(dir, &|path| {
            let outside = ["records/", "results/"].iter().all(|made| !path.starts_with(made));
            let read = ["toml", "csv", "json"].iter().any(|ending| path.ends_with(&format!(".{ending}")));
            outside && read && !path.ends_with(Self::FILE)
        })
    }

    fn of(folder: &Path, wanted: &dyn Fn(&str) -> bool) -> io::Result<Self> {
        let mut all = BTreeMap::new();
        add(folder, "", wanted, &mut all)?;
        Ok(Self(all))
    }

    /// Says in the folder `made` that it was made of these.
    ///
    /// # Errors
    /// The system's.
    pub fn write(&self, made: &Path) -> io::Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        rijke_numerics::write_whole(&made.join(Self::FILE), text.as_bytes())
    }

    /// The files that are not what they were, those that came and those that went; none where nothing says
    /// what `made` was made of.
    fn changed(made: &Path, now: impl Fn() -> io::Result<Self>) -> Vec<String> {
        let before = rijke_numerics::read_text(&made.join(Self::FILE)).ok();
        let before = before.and_then(|text| serde_json::from_str::<Self>(&text).ok());
        let (Some(Self(before)), Ok(Self(now))) = (before.filter(|_| made.is_dir()), now()) else {
            return Vec::new();
        };
        let names: BTreeSet<&String> = before.keys().chain(now.keys()).collect();
        names.into_iter().filter(|name| before.get(*name) != now.get(*name)).cloned().collect()
    }
}

/// The records that changed since DIR/observations was made of DIR/records.
#[must_use]
pub fn changed_records(dir: &Path) -> Vec<String> {
    let records = dir.join("records");
    if !records.is_dir() {
        return Vec::new();
    }
    MadeOf::changed(&dir.join("observations"), || MadeOf::records(&records))
}

/// The files of a study that changed since DIR/results was made of it.
#[must_use]
pub fn changed_study(dir: &Path) -> Vec<String> {
    MadeOf::changed(&dir.join("results"), || MadeOf::study(dir))
}

/// Adds the files of a folder whose path below the first one is `wanted`, but hidden ones.
fn add(
    folder: &Path,
    below: &str,
    wanted: &dyn Fn(&str) -> bool,
    all: &mut BTreeMap<String, String>,
) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with('.') {
            continue;
        }
        let (path, shown) = (entry.path(), format!("{below}{name}"));
        let kind = fs::metadata(&path)?;
        if kind.is_dir() && wanted(&format!("{shown}/x.csv")) {
            add(&path, &format!("{shown}/"), wanted, all)?;
        } else if kind.is_file() && wanted(&shown) {
            let mut hasher = Sha256::new();
            io::copy(&mut rijke_numerics::open_file(&path)?, &mut hasher)?;
            let digest = hasher.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
            all.insert(shown, digest);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_files_that_changed_came_or_went_are_named() {
        let dir = std::env::temp_dir().join(format!("rijke-made-of-{}", std::process::id()));
        let _ = fs::remove_dir_all(&dir);
        for folder in ["records/a", "observations", "results", "candidates"] {
            fs::create_dir_all(dir.join(folder)).unwrap();
        }
        let write = |name: &str, text: &str| fs::write(dir.join(name), text).unwrap();
        write("records/a/0.wav", "1");
        write("records/a/1.wav", "2");
        assert!(changed_records(&dir).is_empty(), "nothing says what they were made of");
        MadeOf::records(&dir.join("records")).unwrap().write(&dir.join("observations")).unwrap();
        assert!(changed_records(&dir).is_empty());
        write("records/a/1.wav", "3");
        write("records/b.wav", "4");
        fs::remove_file(dir.join("records/a/0.wav")).unwrap();
        assert_eq!(changed_records(&dir), ["a/0.wav", "a/1.wav", "b.wav"]);

        write("rig.toml", "1");
        write("candidates/wall.toml", "2");
        write("observations/modes.csv", "3");
        MadeOf::study(&dir).unwrap().write(&dir.join("results")).unwrap();
        write("notes.md", "not read");
        write("results/page.csv", "made");
        write("records/a/1.wav", "5");
        assert!(changed_study(&dir).is_empty());
        write("candidates/wall.toml", "20");
        write("observations/modes.csv", "30");
        assert_eq!(changed_study(&dir), ["candidates/wall.toml", "observations/modes.csv"]);
        fs::remove_dir_all(&dir).unwrap();
    }
}
