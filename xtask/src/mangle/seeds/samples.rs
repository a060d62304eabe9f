//! Records that the program takes, computed and written in the formats that it reads.

use crate::mangle::stream::Stream;
use std::{f64::consts::TAU, fmt::Write as _};

/// Channels of samples.
pub(super) type Samples = Vec<Vec<f64>>;

/// Forcing of 0.2 s after 1000 quiet samples, and the decay of a mode, at three microphones; 10 kHz.
pub(super) fn ping(frequency: f64, stream: &mut Stream) -> Samples {
    let (rate, quiet, driven) = (1e4, 1000, 2000);
    let sample = |n: usize| {
        let t = n as f64 / rate - 0.3;
        let level = if t < 0.0 { 1.0 } else { (-6.0 * t).exp() };
        if n < quiet { 0.0 } else { level * (TAU * frequency * t).cos() }
    };
    let noisy = |share: f64, stream: &mut Stream| -> Vec<f64> {
        (0..quiet + driven + 4000).map(|n| share * sample(n) + 2e-3 * stream.centred()).collect()
    };
    [1.0, 0.62, -0.3].map(|share| noisy(share, stream)).to_vec()
}

/// Random tones that run along a tube and back, at `places`, m; 4096 samples at 4096 Hz.
pub(super) fn noise(places: &[f64], stream: &mut Stream) -> Samples {
    let tones: Vec<[f64; 2]> =
        (150..1000).step_by(2).map(|f| [f64::from(f) + 0.5, TAU * stream.centred()]).collect();
    let mut channels = vec![vec![0.0; 4096]; places.len()];
    for (channel, x) in channels.iter_mut().zip(places) {
        for [f, phase] in &tones {
            let k = TAU * f / 344.0;
            for (n, value) in channel.iter_mut().enumerate() {
                let turned = TAU * f * n as f64 / 4096.0 + phase;
                *value += (turned - k * x).cos() + 0.5 * (turned + k * (x - 2.0)).cos();
            }
        }
        channel.iter_mut().for_each(|v| *v += 0.05 * stream.centred());
    }
    channels
}

/// A blow, after which six modes ring; 2400 samples at 8 kHz.
pub(super) fn blow(stream: &mut Stream) -> Samples {
    let ring = |t: f64, f: f64| (-15.0 * t).exp() * (TAU * f * t + f).cos();
    let sample = |n: usize| {
        [148.0, 291.0, 445.0, 221.5, 367.0, 535.0].map(|f| ring(n as f64 / 8000.0, f)).iter().sum::<f64>()
    };
    vec![(0..2400).map(|n| sample(n) + 0.05 * stream.centred()).collect()]
}

/// 32-bit floats, or 16-bit integers of `full_scale`.
pub(super) fn wav(channels: &Samples, rate: u32, full_scale: Option<f64>) -> Vec<u8> {
    let (count, frames) = (channels.len() as u32, channels.first().map_or(0, Vec::len));
    let (tag, width) = if full_scale.is_some() { (1_u16, 2_u32) } else { (3, 4) };
    let size = frames as u32 * count * width;
    let mut bytes = b"RIFF".to_vec();
    bytes.extend((36 + size).to_le_bytes());
    bytes.extend(b"WAVEfmt \x10\0\0\0");
    bytes.extend(tag.to_le_bytes());
    bytes.extend((count as u16).to_le_bytes());
    bytes.extend(rate.to_le_bytes());
    bytes.extend((rate * count * width).to_le_bytes());
    bytes.extend(((count * width) as u16).to_le_bytes());
    bytes.extend((8 * width as u16).to_le_bytes());
    bytes.extend(b"data");
    bytes.extend(size.to_le_bytes());
    for n in 0..frames {
        for channel in channels {
            match full_scale {
                Some(full) => bytes.extend(((channel[n] / full * 32767.0) as i16).to_le_bytes()),
                None => bytes.extend((channel[n] as f32).to_le_bytes()),
            }
        }
    }
    bytes
}

/// A row per sample.
pub(super) fn csv(head: &str, channels: &Samples) -> String {
    let mut text = String::from(head);
    for n in 0..channels.first().map_or(0, Vec::len) {
        let cells: Vec<String> = channels.iter().map(|c| format!("{:.5}", c[n])).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// MATLAB 5: one array `p` of doubles, channels in rows.
pub(super) fn mat(channels: &Samples) -> Vec<u8> {
    let (rows, columns) = (channels.len() as u32, channels.first().map_or(0, Vec::len) as u32);
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend(0x0100_u16.to_le_bytes());
    bytes.extend(b"IM");
    let data = 8 * rows * columns;
    let words =
        [14, 16 + 16 + 16 + 8 + data, 6, 8, 6, 0, 5, 8, rows, columns, 1, 1, u32::from(b'p'), 0, 9, data];
    words.iter().for_each(|w| bytes.extend(w.to_le_bytes()));
    for n in 0..columns as usize {
        channels.iter().for_each(|c| bytes.extend(c[n].to_le_bytes()));
    }
    bytes
}

/// HDF5: one array `p` of doubles, channels in rows, behind `block` bytes of MATLAB's.
pub(super) fn hdf5(channels: &Samples, block: u64) -> Result<Vec<u8>, String> {
    let mut file = hdf5_pure::FileBuilder::new();
    if block > 0 {
        file.with_userblock(block);
    }
    let shape = [channels.len() as u64, channels.first().map_or(0, Vec::len) as u64];
    file.create_dataset("p").with_f64_data(&channels.concat()).with_shape(&shape);
    let mut bytes = file.finish().map_err(|e| e.to_string())?;
    if block > 0 {
        bytes.splice(..19, *b"MATLAB 7.3 MAT-file");
    }
    Ok(bytes)
}

/// MATLAB 5: columns of doubles by names of at most four letters.
pub(super) fn named_mat(columns: &[(&str, Vec<f64>)]) -> Vec<u8> {
    let mut bytes = mat(&vec![Vec::new()]);
    bytes.truncate(128);
    for (name, values) in columns {
        let (rows, data) = (values.len() as u32, 8 * values.len() as u32);
        let mut letters = [0; 4];
        letters.iter_mut().zip(name.bytes()).for_each(|(l, b)| *l = b);
        let words = [
            14,
            16 + 16 + 8 + 8 + data,
            6,
            8,
            6,
            0,
            5,
            8,
            rows,
            1,
            1 | (name.len() as u32) << 16,
            u32::from_le_bytes(letters),
            9,
            data,
        ];
        words.iter().for_each(|w| bytes.extend(w.to_le_bytes()));
        values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    bytes
}

/// HDF5: columns of doubles by name.
pub(super) fn named_hdf5(columns: &[(&str, Vec<f64>)]) -> Result<Vec<u8>, String> {
    let mut file = hdf5_pure::FileBuilder::new();
    for (name, values) in columns {
        file.create_dataset(name).with_f64_data(values).with_shape(&[values.len() as u64]);
    }
    file.finish().map_err(|e| e.to_string())
}
