//! Long records of five microphones at 10 kHz.

use super::made::{Made, example, laboratory, rows};
use crate::workspace::{at, read, write};
use std::{fs, io::Write as _, path::Path};

const MICROPHONES: usize = 5;
const RATE: usize = 10_000;

/// A ping of the virtual laboratory that ends a record of so many `seconds`: its quiet stretch is repeated
/// before it.
pub(super) fn ping(folder: &Path, seconds: usize) -> Made {
    laboratory(folder, MICROPHONES)?;
    let records = folder.join("records");
    let path = records.join("C3-35/ping-00.wav");
    let old = fs::read(&path).map_err(at(&path))?;
    let number = |at: usize| u32::from_le_bytes([old[at], old[at + 1], old[at + 2], old[at + 3]]) as usize;
    // The header ends with the size of the data, as the laboratory writes it.
    let (frame, data) = (number(32) & 0xFFFF, 68);
    let frames = number(data - 4) / frame;
    let quiet = &old[data..data + QUIET * frame];
    let more = (seconds * RATE).saturating_sub(frames) / QUIET;
    let text = read(&records.join("manifest.toml"))?;
    let (head, _) = text.split_once("[[point]]").unwrap_or((&text, ""));
    let head = head
        .replace(&format!("quiet_samples = {QUIET}\n"), &format!("quiet_samples = {}\n", QUIET * (more + 1)));
    let point =
        "[[point]]\nid = \"C3-35\"\nday = \"C3-day-1\"\npings = [\"C3-35/ping-00.wav\"]\nclicks = []\n";
    write(&records.join("manifest.toml"), &(head + point))?;
    let added = (more * quiet.len()) as u32;
    let mut header = old[..data].to_vec();
    header[4..8].copy_from_slice(&(number(4) as u32 + added).to_le_bytes());
    header[data - 4..].copy_from_slice(&(number(data - 4) as u32 + added).to_le_bytes());
    let parts = [header.as_slice()].into_iter().chain(std::iter::repeat_n(quiet, more)).chain([&old[data..]]);
    written(&path, parts)
}

/// Random noise that all microphones hear, and a tenth that each hears alone.
pub(super) fn noise(folder: &Path, seconds: usize) -> Made {
    example(folder, &|_, text| text)?;
    let records = folder.join("records");
    fs::create_dir_all(&records).map_err(at(&records))?;
    let campaign = read(&folder.join("campaign.csv"))?;
    let point = rows(&campaign).nth(1).and_then(|row| row.split(',').next()).unwrap_or_default();
    write(
        &records.join("manifest.toml"),
        format!(
            "kind = \"virtual\"\nsource = \"cargo xtask scale\"\nrate_hz = {RATE}\nband_hz = [80, 800]\n[random]\nsegment = 4096\n[random.points]\n{point} = \"noise.wav\"\n"
        ),
    )?;
    let mut state = 1_u64;
    // Knuth's generator of 64 bits; the upper ones are good enough.
    let mut draw = |size: i64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as i64 % (2 * size + 1) - size
    };
    let mut second = || -> Vec<u8> {
        let frame = |_| {
            let all = draw(8000);
            (0..MICROPHONES).map(|_| (all + draw(800)) as i16).collect::<Vec<_>>()
        };
        (0..RATE).flat_map(frame).flat_map(i16::to_le_bytes).collect()
    };
    let frame = 2 * MICROPHONES as u32;
    let size = seconds as u32 * RATE as u32 * frame;
    let mut header = b"RIFF".to_vec();
    header.extend((36 + size).to_le_bytes());
    header.extend(b"WAVEfmt ");
    header.extend(16_u32.to_le_bytes());
    header.extend([1, MICROPHONES as u16].iter().flat_map(|n| n.to_le_bytes()));
    header.extend([RATE as u32, RATE as u32 * frame].iter().flat_map(|n| n.to_le_bytes()));
    header.extend([frame as u16, 16].iter().flat_map(|n| n.to_le_bytes()));
    header.extend(b"data");
    header.extend(size.to_le_bytes());
    let body = (0..seconds).map(|_| second());
    written(&records.join("noise.wav"), std::iter::once(header).chain(body))
}

/// Samples before the loudspeaker acts, of the laboratory's pings.
const QUIET: usize = 2000;

fn written(path: &Path, parts: impl Iterator<Item = impl AsRef<[u8]>>) -> Made {
    let fail = |e: std::io::Error| format!("{}: {e}", path.display());
    let mut file = std::io::BufWriter::new(fs::File::create(path).map_err(fail)?);
    for part in parts {
        file.write_all(part.as_ref()).map_err(fail)?;
    }
    file.flush().map_err(fail)
}
