//! Records in files of named arrays: MATLAB, HDF5. Which array holds which channel is declared in the
//! manifest.

use crate::reading::{Clock, Column, Numbers, Plan};
use crate::wav::{Layout, finite};
use crate::{Problem, Record, RigError, mat5};
use rijke_numerics::{open_file, read_bytes};
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::Path;

/// Which arrays of a MATLAB or HDF5 file hold the record.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arrays {
    /// Names of the arrays, `p` or `run/p` or `data.p`. Their channels are counted through in this order.
    /// Empty: the file has one array that is longer than one sample, and it holds all channels.
    #[serde(default)]
    pub names: Vec<String>,
    /// Name of the array that holds the sampling rate in Hz, to be compared with the manifest's; none if the
    /// file has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<String>,
}

/// A numeric array with at most two dimensions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Array {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    /// Column by column.
    pub(crate) values: Vec<f64>,
    /// 2^(bits - 1) for signed integers, which are fractions of full scale; none for all others, which are in
    /// Pa.
    pub(crate) largest: Option<f64>,
}

/// What a file of arrays holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Contents {
    /// The format, in words.
    pub(crate) format: &'static str,
    /// The numeric arrays.
    pub(crate) arrays: Vec<Array>,
    /// Names and kinds of what is no numeric array of at most two dimensions.
    pub(crate) others: Vec<String>,
}

impl Array {
    /// Time runs along the longer dimension, so that a record and its transpose are the same.
    pub(crate) fn samples(&self) -> usize {
        self.rows.max(self.columns)
    }

    pub(crate) fn channels(&self) -> usize {
        self.rows.min(self.columns)
    }

    pub(crate) fn at(&self, channel: usize, sample: usize) -> f64 {
        let (row, column) = if self.rows >= self.columns { (sample, channel) } else { (channel, sample) };
        self.values[row + column * self.rows]
    }

    /// `p (15000 x 8)`.
    pub(crate) fn described(&self) -> String {
        format!("{} ({} x {})", self.name, self.rows, self.columns)
    }
}

/// Whether the file holds arrays; told by its first bytes, since both kinds of MATLAB file end in `.mat`.
pub(crate) fn is_file_of_arrays(path: &Path) -> Result<bool, RigError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let mut head = [0; 8];
    let mut file = open_file(path).map_err(RigError::read(path))?;
    let signed = file.read_exact(&mut head).is_ok() && (head == *HDF5 || head.starts_with(b"MATLAB"));
    Ok(signed || matches!(extension.as_str(), "mat" | "h5" | "hdf5" | "hdf"))
}

/// First bytes of an HDF5 file; in a MATLAB 7.3 file they come after 512 bytes of MATLAB's.
const HDF5: &[u8; 8] = b"\x89HDF\r\n\x1a\n";

/// Largest file of arrays that is read, bytes. All of it is held; a longer record goes into WAV or text,
/// which are read a block at a time.
pub(crate) const LARGEST: u64 = 1 << 30;

/// Reads all arrays of a file.
pub(crate) fn read_arrays(path: &Path) -> Result<Contents, RigError> {
    let bytes = read_bytes(path, LARGEST).map_err(RigError::read(path))?;
    let bad = |reason: String| RigError::invalid(path, "contents", Problem::BadArrays { reason });
    if bytes.starts_with(HDF5) || bytes.get(512..520) == Some(HDF5) {
        #[cfg(feature = "hdf5")]
        return crate::hdf5::read(bytes).map_err(bad);
        #[cfg(not(feature = "hdf5"))]
        return Err(bad("this program was built without the feature hdf5".into()));
    }
    mat5::read(&bytes).map_err(bad)
}

/// All vectors of a MATLAB or HDF5 file with their names; of a matrix `m` those are `m[0]`, `m[1]`.
///
/// # Errors
/// [`RigError`] for a file that cannot be read or is of neither format.
pub fn named_columns(path: &Path) -> Result<Vec<(String, Vec<f64>)>, RigError> {
    let contents = read_arrays(path)?;
    let vectors = contents.arrays.iter().flat_map(|a| (0..a.channels()).map(move |c| (a, c)));
    Ok(vectors.map(|(a, c)| (heading((a, c)), (0..a.samples()).map(|n| a.at(c, n)).collect())).collect())
}

/// Name of one channel of an array.
fn heading((array, channel): (&Array, usize)) -> String {
    if array.channels() > 1 { format!("{}[{channel}]", array.name) } else { array.name.clone() }
}

/// Reads one record.
///
/// # Errors
/// The file is absent, not of a known format or truncated; an array is missing, not numeric, of another
/// length than the others or has too few channels; another sampling rate; NaN.
pub(crate) fn read_array_record(path: &Path, layout: Layout<'_>) -> Result<Record, RigError> {
    let contents = read_arrays(path)?;
    let wrong = |place: &str, problem| RigError::invalid(path, place, problem);
    let known =
        || contents.arrays.iter().map(Array::described).chain(contents.others.iter().cloned()).collect();
    let named = |name: &String| {
        let found = contents.arrays.iter().find(|a| a.name == *name);
        found.ok_or_else(|| wrong("arrays", Problem::NoSuchArray { name: name.clone(), known: known() }))
    };
    if let Some(name) = &layout.arrays.rate {
        let have = named(name)?.values.first().copied().unwrap_or(f64::NAN);
        // NaN is no rate either.
        if (have - layout.rate_hz).abs() > 0.5 || have.is_nan() {
            return Err(wrong(name, Problem::WrongRate { have, need: layout.rate_hz }));
        }
    }
    let long: Vec<&Array> = contents.arrays.iter().filter(|a| a.samples() > 1).collect();
    // Channels by name say which arrays there must be; of one matrix the names are p[0], p[1].
    let by_name =
        || long.iter().copied().filter(|a| (0..a.channels()).any(|c| layout.reading.lists(&heading((a, c)))));
    let used = match (layout.arrays.names.as_slice(), long.as_slice()) {
        ([], _) if by_name().next().is_some() => by_name().collect(),
        ([], [one]) => vec![*one],
        ([], _) => return Err(wrong("arrays", Problem::WhichArray { known: known() })),
        (names, _) => names.iter().map(named).collect::<Result<Vec<_>, _>>()?,
    };
    let mut sources: Vec<(&Array, usize)> =
        used.iter().flat_map(|a| (0..a.channels()).map(move |c| (*a, c))).collect();
    // Time may be an array of its own that `names` does not list.
    if let Some(Column::Name(name)) = &layout.reading.time
        && !sources.iter().any(|s| heading(*s) == *name)
    {
        sources.push((named(name)?, 0));
    }
    let frames = sources[0].0.samples();
    if let Some((other, _)) = sources.iter().find(|s| s.0.samples() != frames) {
        return Err(wrong(&other.name, Problem::Uneven { have: other.samples(), need: frames }));
    }
    if layout.full_scale.is_infinite() && used.iter().any(|a| a.largest.is_some()) {
        return Err(wrong("arrays", Problem::NoFullScale));
    }
    let headings: Vec<String> = sources.iter().map(|s| heading(*s)).collect();
    let numbers = |column: usize| Numbers::of(sources[column].0.largest, layout.full_scale);
    let plan = Plan::of(layout, &headings, sources.len(), numbers)
        .map_err(|(place, problem)| wrong(&place, problem))?;
    if frames <= layout.quiet {
        return Err(wrong("samples", Problem::TooShort { have: frames, quiet: layout.quiet }));
    }
    let column = |k: usize| (0..frames).map(move |n| (n, k)).map(|(n, k)| sources[k].0.at(sources[k].1, n));
    if let Some((k, unit)) = &plan.time {
        let mut clock = Clock::new(unit.clone(), layout.rate_hz);
        column(*k)
            .try_for_each(|t| clock.see(t))
            .and_then(|()| clock.end())
            .map_err(|problem| wrong("time", problem))?;
    }
    let mut channels = vec![Vec::new(); layout.microphones()];
    for take in &plan.takes {
        channels[take.microphone] = column(take.column).map(|p| p * take.scale).collect();
    }
    let Layout { rate_hz, quiet, .. } = layout;
    let record = Record { rate_hz, quiet, full_scale: plan.full_scale(), channels };
    finite(&record).map_err(|(place, problem)| wrong(&place, problem))?;
    Ok(record)
}
