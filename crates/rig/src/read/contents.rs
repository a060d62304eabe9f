//! What is in a file of records, before anything is known about it.

use super::blocks::{Blocks, is_text};
use super::plan::time_column;
use crate::error::RigError;
use crate::formats::array::Array;
use crate::formats::arrays::{is_file_of_arrays, read_arrays};
use crate::formats::riff::header;
use crate::problem::Problem;
use crate::records::reading::Reading;
use std::path::Path;

/// What a file of records holds.
#[derive(Clone, Debug, PartialEq)]
pub struct FileContents {
    /// The format, in words: `WAV, 24 bit integers`.
    pub format: String,
    /// Sampling rate, Hz; none where the file does not carry one.
    pub rate_hz: Option<f64>,
    /// The channels in the order of the file.
    pub channels: Vec<ChannelContents>,
    /// What else is in the file, in words: single numbers with their value, and what is no numeric array.
    pub others: Vec<String>,
}

/// One channel of a file. Signed integers are given as a fraction of full scale, floats and text as they are.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelContents {
    /// Its name, where the file has names; `p[3]` is the fourth channel of the array `p`.
    pub name: Option<String>,
    /// Number of samples.
    pub samples: usize,
    /// Mean.
    pub mean: f64,
    /// Root mean square about the mean.
    pub rms: f64,
    /// Smallest value.
    pub smallest: f64,
    /// Largest value.
    pub largest: f64,
    /// Number of samples at full scale: the channel is clipped there.
    pub at_full_scale: usize,
    /// Number of samples that are no number; the other figures leave them out.
    pub not_finite: usize,
    /// Whether its name says that it is the column of time, which the list `channels` of a manifest may leave
    /// out.
    pub is_time: bool,
}

/// Says what a WAV, MATLAB or HDF5 file, or text with one column per channel (.csv, .tsv, .txt), holds.
///
/// # Errors
/// The file is absent, of another format, truncated, or text with a cell that is no number.
pub fn inspect(path: &Path) -> Result<FileContents, RigError> {
    if is_file_of_arrays(path)? {
        return arrays(path);
    }
    let (format, rate_hz) = if is_text(path) {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        (format!("text, {extension}"), None)
    } else {
        let spec = header(path)?.spec;
        let kind = match spec.sample_format {
            hound::SampleFormat::Int => "integers",
            hound::SampleFormat::Float => "floats",
        };
        (format!("WAV, {} bit {kind}", spec.bits_per_sample), Some(f64::from(spec.sample_rate)))
    };
    // A file may be larger than memory: one block is held at a time.
    let ((mut blocks, names), mut block) = (Blocks::raw(path)?, Vec::new());
    if blocks.width == 0 {
        return Err(RigError::invalid(path, "samples", Problem::TooShort { have: 0, quiet: 0 }));
    }
    let mut channels: Vec<Sums> = (0..blocks.width).map(|_| Sums::default()).collect();
    while blocks.next(&mut block)? > 0 {
        for (c, sums) in channels.iter_mut().enumerate() {
            let scale = blocks.plan.takes[c].scale;
            let column: Vec<f64> = block.iter().skip(c).step_by(blocks.width).map(|v| v * scale).collect();
            sums.add(&column, blocks.full_scale);
        }
    }
    if channels.iter().any(|c| c.samples == 0) {
        return Err(RigError::invalid(path, "samples", Problem::TooShort { have: 0, quiet: 0 }));
    }
    let time = time_column(&Reading::default(), &names, blocks.width).ok().flatten();
    let described = |(k, sums): (usize, Sums)| ChannelContents {
        is_time: time == Some(k),
        ..sums.contents(names.get(k).cloned())
    };
    let channels = channels.into_iter().enumerate().map(described).collect();
    Ok(FileContents { format, rate_hz, channels, others: Vec::new() })
}

/// What a file of named arrays holds.
fn arrays(path: &Path) -> Result<FileContents, RigError> {
    let contents = read_arrays(path)?;
    let (mut channels, mut others) = (Vec::new(), Vec::new());
    for array in contents.arrays {
        match (array.samples(), array.values.first()) {
            (2.., _) => channels.extend((0..array.channels()).map(|c| of_array(&array, c))),
            (_, Some(value)) => others.push(format!("{} = {value}", array.name)),
            (_, None) => others.push(format!("{} is empty", array.name)),
        }
    }
    others.extend(contents.others);
    Ok(FileContents { format: contents.format.to_owned(), rate_hz: None, channels, others })
}

fn of_array(array: &Array, c: usize) -> ChannelContents {
    let name = if array.channels() > 1 { format!("{}[{c}]", array.name) } else { array.name.clone() };
    let unit = array.largest.map_or(1.0, |largest| 1.0 / largest);
    let samples: Vec<f64> = (0..array.samples()).map(|n| array.at(c, n) * unit).collect();
    channel(Some(name), &samples, array.largest.map_or(f64::INFINITY, |_| 1.0))
}

fn channel(name: Option<String>, samples: &[f64], full_scale: f64) -> ChannelContents {
    let mut sums = Sums::default();
    sums.add(samples, full_scale);
    sums.contents(name)
}

/// What is known of the samples seen so far.
struct Sums {
    samples: usize,
    finite: usize,
    mean: f64,
    /// Sum of the squares about the mean.
    squares: f64,
    smallest: f64,
    largest: f64,
    at_full_scale: usize,
}

impl Default for Sums {
    fn default() -> Self {
        let (smallest, largest) = (f64::INFINITY, f64::NEG_INFINITY);
        Self { samples: 0, finite: 0, mean: 0.0, squares: 0.0, smallest, largest, at_full_scale: 0 }
    }
}

impl Sums {
    /// Adds samples. Means and squares of two parts combine by Chan, Golub & LeVeque 1983.
    fn add(&mut self, samples: &[f64], full_scale: f64) {
        let finite = || samples.iter().copied().filter(|v| v.is_finite());
        self.samples += samples.len();
        let count = finite().count();
        if count == 0 {
            return;
        }
        let (before, after) = (self.finite as f64, (self.finite + count) as f64);
        let mean = finite().sum::<f64>() / count as f64;
        let squares = finite().map(|v| (v - mean).powi(2)).sum::<f64>();
        let apart = mean - self.mean;
        self.squares += squares + apart * apart * before * count as f64 / after;
        self.mean += apart * count as f64 / after;
        self.finite += count;
        self.smallest = finite().fold(self.smallest, f64::min);
        self.largest = finite().fold(self.largest, f64::max);
        self.at_full_scale += finite().filter(|v| v.abs() >= full_scale * (1.0 - 1e-6)).count();
    }

    fn contents(self, name: Option<String>) -> ChannelContents {
        ChannelContents {
            name,
            samples: self.samples,
            mean: self.mean,
            rms: (self.squares / self.finite.max(1) as f64).sqrt(),
            smallest: self.smallest,
            largest: self.largest,
            at_full_scale: self.at_full_scale,
            not_finite: self.samples - self.finite,
            is_time: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::wav::Samples24;

    #[test]
    fn exact_a_file_is_described_channel_by_channel() {
        let folder = std::env::temp_dir().join(format!("rijke-inspect-{}", std::process::id()));
        let wav = folder.join("two.wav");
        std::fs::create_dir_all(&folder).unwrap();
        let interleaved = vec![0, 8_388_607, 4_194_304, 0, -4_194_304, 0, 0, 0];
        Samples24 { rate_hz: 10_000, interleaved }.write(2, &wav).unwrap();
        let found = inspect(&wav).unwrap();
        assert_eq!(
            (&*found.format, found.rate_hz, found.channels.len()),
            ("WAV, 24 bit integers", Some(1e4), 2)
        );
        let first = &found.channels[0];
        assert_eq!((first.samples, first.mean, first.smallest, first.largest), (4, 0.0, -0.5, 0.5));
        assert_eq!([first.at_full_scale, found.channels[1].at_full_scale], [0, 1]);

        let text = folder.join("two.csv");
        std::fs::write(&text, "top,bottom\n1,2\n3,2\n").unwrap();
        let found = inspect(&text).unwrap();
        let names: Vec<_> = found.channels.iter().map(|c| c.name.as_deref().unwrap()).collect();
        assert_eq!((names, found.channels[0].rms, found.rate_hz), (vec!["top", "bottom"], 1.0, None));
        assert!(inspect(&folder.join("absent.wav")).unwrap_err().to_string().contains("absent.wav"));
        std::fs::remove_dir_all(folder).unwrap();
    }
}
