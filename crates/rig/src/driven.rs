//! The words of a manifest for records of a rig that random noise, a sweep or a periodic sound drives.

use crate::manifest::{Channels, MicrophoneKeys};
use crate::{Problem, RigError, StatedChannels};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Records of a rig that is driven.
#[derive(Clone, Debug, PartialEq)]
pub struct Driven {
    /// How records become spectra.
    pub spectra: SpectraKind,
    /// Number of polynomials of frequency that make the gain of a channel.
    pub polynomials: usize,
    /// A record with every channel at its own place, and its repeats; none if gains are stated, or taken to
    /// be equal.
    pub straight: Vec<String>,
    /// Records in which channel 0 and another have changed places, while the sound field was that of
    /// `straight`.
    pub switched: Vec<SwitchedRecord>,
    /// Operating point, and its records.
    pub points: BTreeMap<String, Vec<String>>,
    /// Ends at which sound of unknown pressure enters, if not both: `upstream`, `downstream`.
    pub sources: Option<Vec<String>>,
    /// A specimen whose transmission loss is wanted.
    pub transmission: Option<Specimen>,
    /// What `[microphones]` states.
    pub(crate) microphones: Option<MicrophoneKeys>,
}

/// How records become spectra.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpectraKind {
    /// Steady random noise, by Welch's method.
    Segments {
        /// Samples of one segment.
        segment: usize,
    },
    /// A sweep or a periodic sound, by whole records or periods.
    Whole {
        /// Width of the bands over which neighbouring frequencies are averaged, Hz.
        resolution_hz: f64,
        /// Samples of a period; none for a sweep.
        period: Option<usize>,
        /// Frequencies of less coherence are left out.
        coherence: f64,
    },
}

/// `[random]` or `[sweep]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DrivenKeys {
    segment: Option<usize>,
    resolution_hz: Option<f64>,
    period: Option<usize>,
    coherence: Option<f64>,
    polynomials: Option<usize>,
    straight: Option<Files>,
    #[serde(default)]
    switched: Vec<SwitchedRecord>,
    points: BTreeMap<String, Files>,
    sources: Option<Vec<String>>,
    transmission: Option<Specimen>,
}

/// One file, or several.
#[derive(Deserialize)]
#[serde(untagged)]
enum Files {
    One(String),
    Several(Vec<String>),
}

impl Files {
    fn list(self) -> Vec<String> {
        match self {
            Self::One(file) => vec![file],
            Self::Several(files) => files,
        }
    }
}

/// A record in which two channels have changed places.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SwitchedRecord {
    /// The file.
    pub file: String,
    /// The channel that changed places with channel 0.
    pub channel: usize,
}

/// A specimen between microphones.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specimen {
    /// The operating points of which the loss is wanted.
    pub points: Vec<String>,
    /// Where it begins and ends, m; the same place for one that is thin.
    pub between: [f64; 2],
    /// Standard deviation of the place of every microphone, m.
    pub place_sd: f64,
    /// Relative standard deviation of the speed of sound.
    pub sound_speed_sd: f64,
    /// What the wall of the pipe takes between microphones and specimen, over what thin boundary layers on a
    /// smooth one take (Kirchhoff 1868).
    #[serde(default = "smooth")]
    pub wall_factor: f64,
    /// Its standard deviation.
    #[serde(default = "smooth_sd")]
    pub wall_factor_sd: f64,
}

/// The wall of a specimen's pipe if the manifest states none: a smooth one, to within what joints,
/// microphones and roughness add to good pipes.
fn smooth() -> f64 {
    1.0
}

/// Standard deviation of [`smooth`].
fn smooth_sd() -> f64 {
    0.2
}

/// Least coherence of the frequencies that are used, if the manifest states none: noise of an eighth of the
/// signal's power.
const COHERENCE: f64 = 0.8;

impl Driven {
    /// Gains and delays that `[microphones]` of the manifest at `path` states for `count` microphones.
    ///
    /// # Errors
    /// A unit, a number or a list that cannot be; gains or delays without their errors.
    pub fn stated(&self, count: usize, path: &Path) -> Result<Option<StatedChannels>, RigError> {
        let Some(keys) = &self.microphones else { return Ok(None) };
        let Channels { sensitivities, stated } = Channels::read(keys, count, &[], path)?;
        let Some(mut stated) = stated else {
            let what = "must state errors: `delay_sd`, and `gain_sd` or `sensitivity_sd`";
            return Err(RigError::invalid(path, "[microphones]", Problem::Keys { what }));
        };
        stated.gains.iter_mut().zip(&sensitivities).for_each(|(gain, s)| *gain *= s);
        Ok(Some(stated))
    }
}

/// What `[random]` or `[sweep]` says, called `table`.
pub(crate) fn driven(
    keys: DrivenKeys,
    table: &str,
    microphones: Option<MicrophoneKeys>,
    path: &Path,
) -> Result<Driven, RigError> {
    let wrong = |place: &str, what| Err(RigError::invalid(path, place, Problem::Keys { what }));
    let spectra = match (table, keys.segment, keys.resolution_hz) {
        ("[random]", Some(segment), None) if keys.period.is_none() && keys.coherence.is_none() => {
            SpectraKind::Segments { segment }
        }
        ("[sweep]", None, Some(resolution_hz)) => SpectraKind::Whole {
            resolution_hz,
            period: keys.period,
            coherence: keys.coherence.unwrap_or(COHERENCE),
        },
        ("[random]", ..) => {
            return wrong(table, "must have a `segment`, and no `resolution_hz`, `period` or `coherence`");
        }
        _ => return wrong(table, "must have a `resolution_hz`, and no `segment`"),
    };
    let polynomials = keys.polynomials.unwrap_or(6);
    let straight = keys.straight.map(Files::list).unwrap_or_default();
    let points: BTreeMap<_, _> =
        keys.points.into_iter().map(|(point, files)| (point, files.list())).collect();
    let none = polynomials == 0 || points.is_empty() || points.values().any(Vec::is_empty);
    match spectra {
        SpectraKind::Segments { segment } if segment < 16 || none => {
            let what = "must have a segment of 16 samples or more, a polynomial or more, and points with their records";
            return wrong(table, what);
        }
        SpectraKind::Segments { .. }
            if straight.len() > 1 || points.values().any(|files| files.len() != 1) =>
        {
            return wrong(table, "must have at most one record for `straight`, and one for every point");
        }
        SpectraKind::Whole { resolution_hz, period, coherence }
            if !(resolution_hz > 0.0 && (0.0..1.0).contains(&coherence))
                || period.is_some_and(|p| p < 16)
                || none =>
        {
            let what = "must have a resolution_hz above 0, a coherence from 0 to below 1, a period of 16 samples or more, a polynomial or more, and points with their records";
            return wrong(table, what);
        }
        _ => {}
    }
    if straight.is_empty() != keys.switched.is_empty() {
        return wrong(
            table,
            "must have `straight` and `switched` records, or none of both; `[microphones]` may state the gains in their place",
        );
    }
    if microphones.is_some() && !straight.is_empty() {
        return wrong(
            "[microphones]",
            "states gains that also follow from the `switched` records; keep one of the two",
        );
    }
    let ends = ["upstream", "downstream"];
    if keys.sources.iter().flatten().any(|end| !ends.contains(&end.as_str())) {
        return wrong(table, "`sources` names the ends at which sound enters: upstream, downstream");
    }
    let place = format!("{}.transmission]", table.trim_end_matches(']'));
    if let Some(specimen) = &keys.transmission {
        if !specimen.points.iter().all(|p| points.contains_key(p)) {
            let what = if table == "[random]" {
                "must name points that [random.points] lists"
            } else {
                "must name points that [sweep.points] lists"
            };
            return wrong(&place, what);
        }
        let [from, to] = specimen.between;
        let limits = [
            (
                0.0 <= from && from <= to && to.is_finite(),
                "`between` must have two places from 0 m on, the first not beyond the second",
            ),
            ((0.0..1.0).contains(&specimen.place_sd), "`place_sd` must lie from 0 to 1 m"),
            (
                (0.0..0.5).contains(&specimen.sound_speed_sd),
                "`sound_speed_sd` must lie from 0 to 0.5 of the speed",
            ),
            ((0.0..=10.0).contains(&specimen.wall_factor), "`wall_factor` must lie from 0 (no loss) to 10"),
            ((0.0..=10.0).contains(&specimen.wall_factor_sd), "`wall_factor_sd` must lie from 0 to 10"),
        ];
        if let Some((_, what)) = limits.iter().find(|(holds, _)| !holds) {
            return wrong(&place, what);
        }
    }
    Ok(Driven {
        spectra,
        polynomials,
        straight,
        switched: keys.switched,
        points,
        sources: keys.sources,
        transmission: keys.transmission,
        microphones,
    })
}
