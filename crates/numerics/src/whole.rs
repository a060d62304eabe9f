//! Files that appear under their name only when they are complete.

use std::fs::{File, remove_file, rename};
use std::io::{BufWriter, Result, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Threads of one process may write one file at a time, each under a name of its own.
static WRITTEN: AtomicU64 = AtomicU64::new(0);

/// Writes a file in one step: a reader sees the old file or the new one, never half of it. Of several that
/// write one file at once, the last wins. Until it is whole its name is `.NAME.partial-PROCESS-COUNT`, in the
/// same folder; nothing of that name is left when writing fails.
///
/// # Errors
/// The system's.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    write_through(path, |file| file.write_all(bytes))
}

/// As [`write_whole`], piece by piece: `write` is given the file.
///
/// # Errors
/// The system's, or those of `write`.
pub fn write_through(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let count = WRITTEN.fetch_add(1, Ordering::Relaxed);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".{name}.partial-{}-{count}", std::process::id()));
    let fill = |file: File| {
        let mut file = BufWriter::new(file);
        write(&mut file).and_then(|()| file.flush())
    };
    let written = File::create(&partial).and_then(fill).and_then(|()| rename(&partial, path));
    if written.is_err() {
        let _ = remove_file(&partial);
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn behaviour_a_file_is_whole_or_as_before() {
        let folder = std::env::temp_dir().join(format!("rijke-whole-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("table.csv");
        write_whole(&path, b"old").unwrap();
        let failed = write_through(&path, |file| {
            file.write_all(b"half")?;
            Err(std::io::Error::other("the disk is full"))
        });
        assert!(failed.unwrap_err().to_string().contains("the disk is full"));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        write_whole(&path, b"new").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "nothing else is left");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
