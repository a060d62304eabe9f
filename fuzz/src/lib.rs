//! What the fuzz targets share: files that a reader is given, the layout of a record of two microphones, and
//! a sound study.

use rijke_rig::{Arrays, Layout, Reading};
use rijke_study::Study;
use std::{fs, io, path::Path, path::PathBuf};

/// A folder of this process alone.
///
/// # Errors
/// If it cannot be made.
pub fn folder(name: &str) -> io::Result<PathBuf> {
    let folder = std::env::temp_dir().join(format!("rijke-fuzz-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// Replaces a file.
///
/// # Errors
/// If it cannot be written.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // Written over, it would go to the disk at once.
    let _ = fs::remove_file(path);
    fs::write(path, bytes)
}

/// A file with these bytes, of this process alone.
///
/// # Errors
/// If it cannot be written.
pub fn file(name: &str, bytes: &[u8]) -> io::Result<PathBuf> {
    let path = folder("file")?.join(name);
    replace(&path, bytes)?;
    Ok(path)
}

/// Channels by their place or by what `reading` says; 20 Pa, 10 kHz, two quiet samples.
pub fn layout<'a>(channels: &'a [Option<usize>], arrays: &'a Arrays, reading: &'a Reading) -> Layout<'a> {
    Layout { channels, full_scale: 20.0, rate_hz: 1e4, quiet: 2, arrays, reading }
}

/// A sound study, file by file.
const STUDY: [(&str, &str); 5] = [
    ("rig.toml", include_str!("../../crates/rijke/src/new/kundt-tube/rig.toml")),
    ("campaign.csv", include_str!("../../crates/rijke/src/new/kundt-tube/campaign.csv")),
    ("study.toml", include_str!("../../crates/rijke/src/new/kundt-tube/study.toml")),
    ("candidates/tube.toml", include_str!("../../crates/rijke/src/new/kundt-tube/candidates/tube.toml")),
    ("candidates/sample.toml", include_str!("../../crates/rijke/src/new/kundt-tube/candidates/sample.toml")),
];

/// The sound study with one file that holds `text`; none if the study cannot be read with it.
#[must_use]
pub fn study(file: &str, text: &str) -> Option<Study> {
    let folder = folder("study").ok()?;
    if !folder.join("rig.toml").exists() {
        for (name, content) in STUDY {
            let path = folder.join(name);
            fs::create_dir_all(path.parent()?).ok()?;
            replace(&path, content.as_bytes()).ok()?;
        }
        let origin = "kind = \"measured\"\nsource = \"fuzz\"\n";
        fs::create_dir_all(folder.join("observations")).ok()?;
        fs::create_dir_all(folder.join("base")).ok()?;
        replace(&folder.join("observations/observations.toml"), origin.as_bytes()).ok()?;
    }
    replace(&folder.join(file), text.as_bytes()).ok()?;
    Study::open(&folder).ok()
}
