//! The chunks of a WAV file, none of which is believed to be longer than the file.

use crate::error::RigError;
use crate::problem::Problem;
use hound::{WavReader, WavSpec};
use rijke_numerics::open_file;
use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

/// Longest `fmt ` chunk that is looked at, bytes: those in use have 16, 18 or 40.
const LONGEST_FORMAT: u32 = 1024;
/// A recorder that writes as it goes leaves one of these as the length of `data` until it has finished.
const UNFINISHED: [u32; 2] = [0, u32::MAX];

/// What the samples of a WAV file are.
pub(crate) struct WavHeader {
    pub(crate) spec: WavSpec,
    /// Frames announced; the file may be truncated and hold fewer.
    pub(crate) frames: usize,
    /// The file, at its first sample.
    pub(crate) samples: BufReader<File>,
}

/// Reads chunks up to the samples. Other chunks than `fmt ` and `data` are passed over, whatever they are.
///
/// # Errors
/// The file is absent, not a WAV file, of a kind that is not supported, has a chunk that cannot be, or was
/// not finished by the recorder.
pub(crate) fn header(path: &Path) -> Result<WavHeader, RigError> {
    let wrong = |problem| RigError::invalid(path, "header", problem);
    let unreadable = |reason: String| wrong(Problem::BadWav { reason });
    let file = open_file(path).map_err(RigError::read(path))?;
    let size = file.metadata().map_err(RigError::read(path))?.len();
    let mut file = BufReader::new(file);
    let mut read = |at: u64, count: u64| -> Result<Vec<u8>, RigError> {
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(at)).map_err(RigError::read(path))?;
        file.by_ref().take(count).read_to_end(&mut bytes).map_err(RigError::read(path))?;
        Ok(bytes)
    };
    let first = read(0, 12)?;
    if first.starts_with(b"TDSm") {
        return Err(wrong(Problem::Tdms));
    }
    if first.len() < 12 || !first.starts_with(b"RIFF") || !first.ends_with(b"WAVE") {
        return Err(unreadable("it does not begin with RIFF and WAVE".into()));
    }
    // What the decoder of headers is shown: the same without chunks that it need not know.
    let mut shown = first;
    let mut at = 12;
    let length = loop {
        let head = read(at, 8)?;
        let [a, b, c, d, n0, n1, n2, n3] = head[..] else {
            return Err(unreadable(format!("it ends at byte {size} without a chunk `data`")));
        };
        let (stated, left) = (u32::from_le_bytes([n0, n1, n2, n3]), size.saturating_sub(at + 8));
        let name = [a, b, c, d];
        if &name == b"data" {
            if UNFINISHED.contains(&stated) && left > 0 {
                return Err(wrong(Problem::Unfinished { at, stated, left }));
            }
            shown.extend(head);
            break stated;
        }
        if u64::from(stated) > left {
            let name = name.escape_ascii().to_string();
            return Err(wrong(Problem::LongChunk { name, at, stated, left }));
        }
        if &name == b"fmt " {
            if stated > LONGEST_FORMAT {
                return Err(unreadable(format!("its chunk `fmt ` has {stated} bytes")));
            }
            shown.extend(head);
            shown.extend(read(at + 8, stated.into())?);
        }
        // Chunks begin at even bytes.
        at += 8 + u64::from(stated) + u64::from(stated % 2);
    };
    let reader = WavReader::new(Cursor::new(shown)).map_err(|error| unreadable(error.to_string()))?;
    let (spec, frames) = (reader.spec(), reader.duration());
    let (frame, samples) = (u64::from(length), u64::from(frames) * u64::from(spec.channels));
    let bytes = u64::from(spec.bits_per_sample / 8);
    if samples * bytes != frame {
        let have = frame / samples.max(1);
        return Err(unreadable(format!("{} bit samples in {have} bytes each", spec.bits_per_sample)));
    }
    file.seek(SeekFrom::Start(at + 8)).map_err(RigError::read(path))?;
    Ok(WavHeader { spec, frames: frames as usize, samples: file })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// A WAV file with chunks before and after its samples: two channels of 16 bits at 10 kHz.
    fn file(name: &str, chunks: &[(&[u8; 4], u32, &[u8])]) -> PathBuf {
        let mut bytes = b"RIFF\0\0\0\0WAVE".to_vec();
        for (name, stated, content) in chunks {
            bytes.extend(*name);
            bytes.extend(stated.to_le_bytes());
            bytes.extend(*content);
        }
        let path = std::env::temp_dir().join(format!("rijke-riff-{name}-{}.wav", std::process::id()));
        std::fs::write(&path, bytes).unwrap();
        path
    }

    const FORMAT: (&[u8; 4], u32, &[u8]) =
        (b"fmt ", 16, &[1, 0, 2, 0, 0x10, 0x27, 0, 0, 0x40, 0x9c, 0, 0, 4, 0, 16, 0]);
    const SAMPLES: [u8; 8] = [1, 2, 3, 4, 5, 6, 7, 8];

    #[test]
    fn exact_chunks_of_any_kind_and_parity_are_passed_over() {
        let data = (b"data", 8, &SAMPLES[..]);
        let list = (b"LIST", 3, &b"abc\0"[..]);
        // `fact` with more than the one number that it must have; the last chunk lacks its padding.
        let fact = (b"fact", 6, &[0; 6][..]);
        for chunks in [
            &[FORMAT, data][..],
            &[list, FORMAT, fact, list, data, (b"id3 ", 3, b"abc")],
            &[FORMAT, list, data, list],
        ] {
            let path = file("passed", chunks);
            let mut header = header(&path).unwrap();
            let mut first = [0; 4];
            header.samples.read_exact(&mut first).unwrap();
            assert_eq!((header.spec.channels, header.spec.sample_rate, header.frames), (2, 10_000, 2));
            assert_eq!(first, SAMPLES[..4]);
            std::fs::remove_file(path).unwrap();
        }
    }

    #[test]
    fn exact_messages_of_chunks_that_cannot_be() {
        let refused = |chunks: &[(&[u8; 4], u32, &[u8])], message: &str| {
            let path = file("refused", chunks);
            let text = header(&path).map(|h| h.frames).unwrap_err().to_string();
            assert!(text.contains(message), "{text}");
            std::fs::remove_file(path).unwrap();
        };
        let data = (b"data", 8, &SAMPLES[..]);
        refused(
            &[FORMAT, (b"LI\xffT", 0xffff_fff0, b"ab"), data],
            "header: chunk `LI\\xffT` at byte 36 should have 4294967280 bytes, 18 are left in the file; it is damaged or truncated: \
             copy or record it again",
        );
        refused(
            &[FORMAT, (b"data", u32::MAX, &SAMPLES)],
            "header: the length of `data` at byte 36 is 4294967295 and 8 bytes follow: the recorder did not finish the file; have the \
             length written (`sox --ignore-length in.wav out.wav`), or record again",
        );
        refused(&[FORMAT, (b"data", 0, &SAMPLES)], "`data` at byte 36 is 0 and 8 bytes follow");
        refused(&[FORMAT], "ends at byte 36 without a chunk `data`");
        refused(&[data, FORMAT], "missing fmt chunk");
        refused(&[(b"fmt ", 2000, &[0; 2000]), data], "its chunk `fmt ` has 2000 bytes");
        let mut wide = FORMAT.2.to_vec();
        (wide[8], wide[9], wide[10], wide[12], wide[14]) = (0x80, 0x38, 1, 8, 24);
        refused(&[(b"fmt ", 16, &wide), data], "24 bit samples in 4 bytes each");
    }
}
