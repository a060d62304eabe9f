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

    /// All files of a folder of records but observations in it, texts and pictures about them.
    ///
    /// # Errors
    /// The system's.
    pub fn records(folder: &Path) -> io::Result<Self> {
        let of_records = |path: &str| !path.starts_with("observations/") && !is_one_of(path, &ABOUT);
        Self::of(folder, listed(folder, &of_records)?)
    }

    /// The same with ambient temperatures that the campaign of the study gave.
    #[must_use]
    pub fn with_temperatures_of_campaign(mut self) -> Self {
        self.0.insert(TEMPERATURES.to_owned(), "given".to_owned());
        self
    }

    /// What a ranking reads of the study in `dir`: its files, and the tables that these name. Neither records
    /// nor results, nor what lies beside.
    ///
    /// # Errors
    /// The system's.
    pub fn study(dir: &Path) -> io::Result<Self> {
        let read = |path: &str| {
            let outside = ["records/", "results/"].iter().all(|made| !path.starts_with(made));
            outside && is_one_of(path, &["toml", "csv", "json"]) && !path.ends_with(Self::FILE)
        };
        let mut all = listed(dir, &read)?;
        let known = |path: &str| FILES.contains(&path) || FOLDERS.iter().any(|f| path.starts_with(f));
        let texts: Vec<String> = all
            .iter()
            .filter(|path| known(path) && is_one_of(path, &["toml"]))
            .filter_map(|path| rijke_numerics::read_text(&dir.join(path)).ok())
            .collect();
        let named = |path: &str| texts.iter().any(|t| t.contains(path.rsplit('/').next().unwrap_or(path)));
        all.retain(|path| known(path) || named(path));
        Self::of(dir, all)
    }

    /// The digests of files in a folder.
    fn of(folder: &Path, paths: Vec<String>) -> io::Result<Self> {
        let digest = |path: String| {
            let mut hasher = Sha256::new();
            io::copy(&mut rijke_numerics::open_file(&folder.join(&path))?, &mut hasher)?;
            let digest = hasher.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
            Ok((path, digest))
        };
        paths.into_iter().map(digest).collect::<io::Result<_>>().map(Self)
    }

    /// Says in the folder `made` that it was made of these.
    ///
    /// # Errors
    /// The system's.
    pub fn write(&self, made: &Path) -> io::Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        rijke_numerics::write_whole(&made.join(Self::FILE), text.as_bytes())
    }

    /// What the folder `made` says of it; none where it says nothing that can be read.
    fn read(made: &Path) -> Option<Self> {
        let text = rijke_numerics::read_text(&made.join(Self::FILE)).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// The files that are not what they were, those that came and those that went; none where nothing says
    /// what `made` was made of.
    fn changed(made: &Path, now: impl Fn() -> io::Result<Self>) -> Vec<String> {
        let Some(Self(before)) = Self::read(made).filter(|_| made.is_dir()) else { return Vec::new() };
        let Ok(Self(now)) = now() else { return Vec::new() };
        let names: BTreeSet<&String> =
            before.keys().chain(now.keys()).filter(|name| *name != TEMPERATURES).collect();
        names.into_iter().filter(|name| before.get(*name) != now.get(*name)).cloned().collect()
    }
}

/// Stands among the files of records whose ambient temperatures the campaign gave.
const TEMPERATURES: &str = "T_amb of campaign.csv";

/// Whether the ambient temperatures in a folder of observations are those that the campaign had when its
/// records were processed.
pub(crate) fn has_temperatures_of_campaign(observations: &Path) -> bool {
    MadeOf::read(observations).is_some_and(|of| of.0.contains_key(TEMPERATURES))
}

/// What a study is made of, wherever it comes from.
const FILES: [&str; 6] =
    ["study.toml", "rig.toml", "campaign.toml", "campaign.csv", "readings.csv", "paper.toml"];
const FOLDERS: [&str; 3] = ["candidates/", "observations/", "base/"];

/// Endings of what lies beside records and is none.
const ABOUT: [&str; 8] = ["md", "pdf", "html", "png", "jpg", "jpeg", "svg", "log"];

fn is_one_of(path: &str, endings: &[&str]) -> bool {
    Path::new(path).extension().is_some_and(|e| endings.iter().any(|ending| e.eq_ignore_ascii_case(ending)))
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

/// The files in a folder and below whose path from it on is `wanted`, but hidden ones.
fn listed(folder: &Path, wanted: &dyn Fn(&str) -> bool) -> io::Result<Vec<String>> {
    let mut all = Vec::new();
    add(folder, "", wanted, &mut all)?;
    Ok(all)
}

fn add(folder: &Path, below: &str, wanted: &dyn Fn(&str) -> bool, all: &mut Vec<String>) -> io::Result<()> {
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
            all.push(shown);
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
        write("budget.csv", "not read");
        write("records/README.md", "no record");
        assert_eq!(changed_records(&dir), ["a/0.wav", "a/1.wav", "b.wav"]);
        write("results/page.csv", "made");
        write("records/a/1.wav", "5");
        assert!(changed_study(&dir).is_empty());
        write("candidates/wall.toml", "20");
        write("observations/modes.csv", "30");
        assert_eq!(changed_study(&dir), ["candidates/wall.toml", "observations/modes.csv"]);
        write("rig.toml", "table = \"budget.csv\"");
        let changed = ["budget.csv", "candidates/wall.toml", "observations/modes.csv", "rig.toml"];
        assert_eq!(changed_study(&dir), changed);
        fs::remove_dir_all(&dir).unwrap();
    }
}
