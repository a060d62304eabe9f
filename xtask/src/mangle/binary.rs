//! Changes of bytes: of records in WAV, MATLAB and HDF5, and now and then of text.

use super::{changed::Changed, stream::Stream};

/// Counts, offsets and sizes that readers must not believe.
const WORDS: [u64; 12] = [
    0,
    1,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0xffff_ffff_ffff_ffff,
];

/// Samples that no microphone gives.
const SAMPLES: [f64; 7] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 5e-324, 0.0];

/// Changes `bytes` at one place.
pub(super) fn change(bytes: &[u8], stream: &mut Stream) -> Changed {
    let mut out = bytes.to_vec();
    let size = bytes.len();
    // Half of the changes are in the head, where counts and offsets stand.
    let reach = if stream.chance(50) { size.min(512) } else { size };
    let at = stream.below(reach);
    let told = match stream.below(10) {
        0 => {
            let bit = stream.below(8);
            out.iter_mut().skip(at).take(1).for_each(|b| *b ^= 1 << bit);
            format!("bit {bit} of byte {at} turned")
        }
        1 => {
            let value = stream.word() as u8;
            out.iter_mut().skip(at).take(1).for_each(|b| *b = value);
            format!("byte {at} set to {value}")
        }
        2 => {
            out.truncate(at);
            format!("cut after {at} of {size} bytes")
        }
        3 => {
            let count = 1 + stream.below(64);
            let new: Vec<u8> = (0..count).map(|_| stream.word() as u8).collect();
            out.splice(at..at, new);
            format!("{count} bytes put in at {at}")
        }
        4 => {
            let end = size.min(at + 1 + stream.below(256));
            out.drain(at..end);
            format!("bytes {at} to {end} taken out")
        }
        5 => {
            let end = size.min(at + 1 + stream.below(256));
            let part = bytes.get(at..end).unwrap_or_default().to_vec();
            out.splice(at..at, part);
            format!("bytes {at} to {end} doubled")
        }
        6 => {
            let fill = if stream.chance(50) { 0 } else { 0xff };
            out.iter_mut().skip(at).for_each(|b| *b = fill);
            format!("{fill} from byte {at} on")
        }
        7 => {
            let (value, double) = (SAMPLES[stream.below(SAMPLES.len())], stream.chance(50));
            let word =
                if double { value.to_le_bytes().to_vec() } else { (value as f32).to_le_bytes().to_vec() };
            let at = at - at % 4;
            overwrite(&mut out, at, &word);
            format!("{value:e} in {} bytes at {at}", word.len())
        }
        _ => {
            let width = [1, 2, 4, 8][stream.below(4)];
            let (at, word) = (at - at % width.min(4), WORDS[stream.below(WORDS.len())]);
            overwrite(&mut out, at, word.to_le_bytes().get(..width).unwrap_or_default());
            format!("{word:#x} in {width} bytes at {at}")
        }
    };
    (out, told)
}

fn overwrite(bytes: &mut [u8], at: usize, by: &[u8]) {
    bytes.iter_mut().skip(at).zip(by).for_each(|(old, new)| *old = *new);
}
