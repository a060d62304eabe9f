//! What is in a file of records, before anything is known about it.

use crate::arrays::{Array, is_file_of_arrays, read_arrays};
use crate::text_record::columns;
use crate::wav::{Layout, header, read_record};
use crate::{Arrays, Problem, RigError};
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
}

/// Says what a WAV, MATLAB or HDF5 file, or text with one column per channel (.csv, .tsv, .txt), holds.
///
/// # Errors
/// The file is absent, of another format, truncated, or text with a cell that is no number.
pub fn inspect(path: &Path) -> Result<FileContents, RigError> {
    if is_file_of_arrays(path)? {
        return arrays(path);
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let (format, rate_hz, names) = match extension.as_str() {
        "csv" | "tsv" | "txt" => {
            let names = columns(path)?;
            (format!("text, {extension}"), None, names)
        }
        _ => {
            let (spec, _) = header(path)?;
            let kind = match spec.sample_format {
                hound::SampleFormat::Int => "integers",
                hound::SampleFormat::Float => "floats",
            };
            let names = vec![None; usize::from(spec.channels)];
            (format!("WAV, {} bit {kind}", spec.bits_per_sample), Some(f64::from(spec.sample_rate)), names)
        }
    };
    if names.is_empty() {
        return Err(RigError::invalid(path, "header", Problem::Empty { need: "one channel" }));
    }
    let all: Vec<Option<usize>> = (0..names.len()).map(Some).collect();
    let layout = Layout {
        channels: &all,
        full_scale: 1.0,
        rate_hz: rate_hz.unwrap_or(1.0),
        quiet: 0,
        arrays: &Arrays::default(),
    };
    let record = read_record(path, layout)?;
    let channels =
        names.into_iter().zip(&record.channels).map(|(name, c)| channel(name, c, record.full_scale));
    Ok(FileContents { format, rate_hz, channels: channels.collect(), others: Vec::new() })
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
    let finite = || samples.iter().copied().filter(|v| v.is_finite());
    let count = finite().count();
    let per = 1.0 / count.max(1) as f64;
    let mean = per * finite().sum::<f64>();
    ChannelContents {
        name,
        samples: samples.len(),
        mean,
        rms: (per * finite().map(|v| (v - mean).powi(2)).sum::<f64>()).sqrt(),
        smallest: finite().fold(f64::INFINITY, f64::min),
        largest: finite().fold(f64::NEG_INFINITY, f64::max),
        at_full_scale: finite().filter(|v| v.abs() >= full_scale * (1.0 - 1e-6)).count(),
        not_finite: samples.len() - count,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Samples24;

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
