//! A record in a file of named arrays. Which array holds which channel is declared in the manifest.

use super::clock::Clock;
use super::layout::Layout;
use super::plan::{Numbers, Plan};
use crate::error::RigError;
use crate::formats::array::Array;
use crate::formats::arrays::{heading, read_arrays};
use crate::problem::Problem;
use crate::records::reading::Column;
use crate::records::record::Record;
use std::path::Path;

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
        let have = number(named(name)?);
        // NaN is no rate either.
        if (have - layout.rate_hz).abs() > 0.5 || have.is_nan() {
            return Err(wrong(name, Problem::WrongRate { have, need: layout.rate_hz }));
        }
    } else if let Some(rate) = contents.arrays.iter().find(|a| is_rate(a)) {
        let have = number(rate);
        let agrees = |have: f64| (have - layout.rate_hz).abs() <= 0.5;
        // It may be in kHz.
        if have > 0.0 && !agrees(have) && !agrees(1e3 * have) {
            return Err(wrong(&rate.name, Problem::WrongRate { have, need: layout.rate_hz }));
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

/// Names of the sampling rate, in lower case, behind those of structures and groups.
const RATES: [&str; 9] =
    ["fs", "fs_hz", "rate", "rate_hz", "srate", "samplerate", "sample_rate", "samplingrate", "sampling_rate"];

/// Whether an array is one number whose name says that it is the sampling rate.
fn is_rate(array: &Array) -> bool {
    let name = array.name.rsplit(['/', '.']).next().unwrap_or_default().to_ascii_lowercase();
    array.values.len() == 1 && RATES.contains(&&*name)
}

/// The first number of an array, as the file has it.
fn number(array: &Array) -> f64 {
    array.values.first().map_or(f64::NAN, |v| v * array.largest.unwrap_or(1.0))
}

/// The first sample that is not a number, if any.
fn finite(record: &Record) -> Result<(), (String, Problem)> {
    for (m, channel) in record.channels.iter().enumerate() {
        if let Some((sample, &value)) = channel.iter().enumerate().find(|(_, p)| !p.is_finite()) {
            return Err((format!("microphone {m}"), Problem::NotFinite { sample, value }));
        }
    }
    Ok(())
}
