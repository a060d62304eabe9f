//! Files that somebody else gave: a regular file of a size that can be read, or a reason.

use std::fmt::{Display, Formatter};
use std::fs::{File, FileType};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Largest text that [`read_text`] takes, bytes: tables of the repeats of a large campaign have 100 MB.
pub const LARGEST_TEXT: u64 = 1 << 30;

/// Why a file is not read although it is there. The cause inside the [`std::io::Error`] of [`open_file`] and
/// its like.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unreadable {
    /// A folder, a pipe, a device: what has no end, or no samples.
    NotAFile {
        /// What it is.
        kind: &'static str,
    },
    /// More than may be read.
    TooLarge {
        /// Largest size, bytes.
        most: u64,
    },
}

impl Display for Unreadable {
    fn fmt(&self, out: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotAFile { kind } => write!(out, "it is {kind}, not a file; give a file on disk"),
            Self::TooLarge { most } => {
                write!(out, "it is larger than {} MiB, the most that is read of such a file", most >> 20)
            }
        }
    }
}

impl std::error::Error for Unreadable {}

/// Opens a regular file. A pipe would wait for a writer, and a device has no end.
///
/// # Errors
/// The system's, or [`Unreadable::NotAFile`].
pub fn open_file(path: &Path) -> Result<File> {
    let found = std::fs::metadata(path)?;
    if !found.is_file() {
        return Err(Error::new(
            ErrorKind::InvalidInput,
            Unreadable::NotAFile { kind: kind(found.file_type()) },
        ));
    }
    File::open(path)
}

/// The bytes of a regular file that holds at most `most` of them.
///
/// # Errors
/// Those of [`open_file`], or [`Unreadable::TooLarge`].
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>> {
    let file = open_file(path)?;
    let large = || Error::new(ErrorKind::FileTooLarge, Unreadable::TooLarge { most });
    let size = file.metadata()?.len();
    if size > most {
        return Err(large());
    }
    // Some files say that they are empty and are not.
    let mut bytes = Vec::with_capacity(size as usize);
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(large()) } else { Ok(bytes) }
}

/// The text of a regular file of at most [`LARGEST_TEXT`] bytes; in place of [`std::fs::read_to_string`].
///
/// # Errors
/// Those of [`read_bytes`], or that it is not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read_bytes(path, LARGEST_TEXT)?)
        .map_err(|_| Error::new(ErrorKind::InvalidData, "it is not text in UTF-8; save it so"))
}

fn kind(kind: FileType) -> &'static str {
    if kind.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    "something else"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_of_what_is_no_file() {
        let said = |path: &Path| read_text(path).unwrap_err().to_string();
        assert_eq!(said(&std::env::temp_dir()), "it is a folder, not a file; give a file on disk");
        #[cfg(unix)]
        assert_eq!(said(Path::new("/dev/zero")), "it is a device, not a file; give a file on disk");
    }

    #[test]
    fn exact_as_much_is_read_as_allowed() {
        let path = std::env::temp_dir().join(format!("rijke-files-{}", std::process::id()));
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(
            (read_bytes(&path, 5).unwrap(), read_text(&path).unwrap()),
            (b"12345".to_vec(), "12345".into())
        );
        let error = read_bytes(&path, 4).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        // A file with holes takes no room on the disk and has no end that a reader would live to see.
        File::create(&path).unwrap().set_len(LARGEST_TEXT + 1).unwrap();
        assert!(read_text(&path).unwrap_err().to_string().contains("larger than 1024 MiB"));
        std::fs::write(&path, [0xff, 0xfe]).unwrap();
        assert!(read_text(&path).unwrap_err().to_string().contains("not text in UTF-8"));
        std::fs::remove_file(path).unwrap();
    }
}
