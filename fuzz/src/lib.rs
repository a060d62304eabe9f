//! What the fuzz targets share: files that a reader is given, and the layout of a record of two microphones.

use rijke_rig::{Arrays, Layout, Reading};
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
