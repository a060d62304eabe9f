//! All records of a campaign: calibration, pings and clicks, means over repeats. Records are read one at a time and
//! in parallel; results keep the order of the set, whatever the number of threads.

mod path;
mod repeated;

use crate::click::{ClickFit, ClickOptions, fit_click};
use crate::delays::{CalibrationError, ChannelDelays, KnownClick};
use crate::ping::{PingOptions, fit_ping};
use crate::repeats::Repeats;
use crate::{Fault, Trace};
pub use path::click_options;
use path::setting_covariance;
use rayon::prelude::*;
use repeated::{combine_clicks, combine_pings, ping_of, turn_inverted};
use rijke_rig::{
    Click, Observations, Ping, PointObservations, Record, RecordSet, RecordSource, Rejection, RigError,
};

/// How a campaign is processed. Microphone positions, reference, gas and geometry come from the rig of the record set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProcessOptions {
    /// Fit of the pings; the reference microphone is replaced by the rig's.
    pub ping: PingOptions,
    /// Fit of the clicks; dispersion and reflection are replaced by the rig's.
    pub click: ClickOptions,
}

/// What processing made of a record set.
#[derive(Clone, Debug)]
pub struct Processed {
    /// What was measured, for inference.
    pub observations: Observations,
    /// Delays and gains at the pings' sampling rate; none if the set holds no ping.
    pub ping_delays: Option<ChannelDelays>,
    /// The same at the clicks' sampling rate.
    pub click_delays: Option<ChannelDelays>,
    /// Scatter and drift of each operating point's pings and clicks, before correction.
    pub scatter: Vec<PointScatter>,
    /// Records in which something was put right, and what: a channel of opposite polarity.
    pub corrections: Vec<Rejection>,
    /// Number of records read, calibration included.
    pub records: usize,
}

/// How the repeats of one operating point agree.
#[derive(Clone, Debug)]
pub struct PointScatter {
    /// Of growth rate, frequency and relative pressures.
    pub ping: Option<Repeats>,
    /// Of the arrival times.
    pub click: Option<Repeats>,
}

/// Why a record set cannot be processed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProcessError {
    /// A record cannot be read.
    #[error(transparent)]
    Record(#[from] RigError),
    /// There are no calibration clicks at a sampling rate.
    #[error(
        "no calibration clicks at {rate_hz} Hz: record a few clicks in the empty tube at ambient temperature at that rate, and list them as a [[calibration]] in the manifest"
    )]
    NoCalibration {
        /// The sampling rate, Hz.
        rate_hz: f64,
    },
    /// The calibration clicks cannot be used.
    #[error("calibration at {rate_hz} Hz: {cause}{}", first_rejection.as_deref().map(|r| format!("; first rejected record: {r}")).unwrap_or_default())]
    Calibration {
        /// The sampling rate, Hz.
        rate_hz: f64,
        /// The reason.
        cause: CalibrationError,
        /// Why the first of the rejected records was rejected.
        first_rejection: Option<String>,
    },
    /// Every record was rejected.
    #[error("all {count} records were rejected; the first, {record}: {reason}")]
    NothingUsable {
        /// Number of records.
        count: usize,
        /// The first of them.
        record: String,
        /// Why it was rejected.
        reason: String,
    },
}

/// Processes a record set. `advance` is called once per record, from any thread.
///
/// A bad record is listed among the rejections with its reason. Means are made before channel delays are removed, so
/// that the calibration's error, which all repeats share, enters the covariance of a mean once and undiminished. So do, for
/// arrival times, the shift of the setting that the rig declares ([`rijke_rig::Recording`]) and what is not known of the prongs'
/// surface: both are common to all records of one setting, and differences within it are better than the covariance says.
///
/// # Errors
/// See [`ProcessError`].
pub fn process(
    source: &dyn RecordSource,
    options: &ProcessOptions,
    advance: &(dyn Fn() + Sync),
) -> Result<Processed, ProcessError> {
    let set = source.set();
    let mut rejections = Vec::new();
    let options = &ProcessOptions {
        ping: PingOptions { reference: set.rig.microphones.reference, ..options.ping.clone() },
        click: options.click.clone(),
    };
    let has = |count: fn(&rijke_rig::PointRecords) -> usize| set.points.iter().any(|p| count(p) > 0);
    let mut calibrate = |needed: bool, rate_hz: f64| -> Result<Option<ChannelDelays>, ProcessError> {
        needed.then(|| calibrate(source, options, rate_hz, advance, &mut rejections)).transpose()
    };
    let ping_delays = calibrate(has(|p| p.pings.len()), set.ping.rate_hz)?;
    let click_delays = calibrate(has(|p| p.clicks.len()), set.click.rate_hz)?;

    let jobs: Vec<(usize, usize, bool)> = set
        .points
        .iter()
        .enumerate()
        .flat_map(|(k, p)| {
            let pings = (0..p.pings.len()).map(move |n| (k, n, true));
            pings.chain((0..p.clicks.len()).map(move |n| (k, n, false)))
        })
        .collect();
    let fitted: Vec<Fitted> = jobs
        .par_iter()
        .map(|&(point, repeat, is_ping)| -> Result<Fitted, RigError> {
            let fitted = if is_ping {
                let record = source.ping(point, repeat)?;
                Fitted::Ping(fit_ping(&Trace::from(&record), &options.ping).map(|fit| fit.ping))
            } else {
                let record = source.click(point, repeat)?;
                let records = &set.points[point];
                let click = click_options(set, records.day, Some(&records.point), &options.click);
                let fit = fit_click(&Trace::from(&record), &click);
                Fitted::Click(fit.and_then(|fit| {
                    let delays = click_delays.as_ref();
                    let arrival = delays.map(|d| Ok((d.arrival(&fit, true)?, d.inverted(&fit)?)));
                    arrival.transpose()
                }))
            };
            advance();
            Ok(fitted)
        })
        .collect::<Result<_, _>>()?;

    let calibration_clicks = rejections.len();
    // Fits are given up as their means are made: those of a whole campaign are not held twice.
    let mut fitted = jobs.iter().zip(fitted).peekable();
    let (mut points, mut scatter, mut corrections) = (Vec::new(), Vec::new(), Vec::new());
    for (k, records) in set.points.iter().enumerate() {
        let mut pings = Vec::new();
        let mut clicks = Vec::new();
        while let Some((&(_, repeat, _), fit)) = fitted.next_if(|(job, _)| job.0 == k) {
            match fit {
                Fitted::Ping(Ok(ping)) => pings.push((repeat, ping)),
                Fitted::Ping(Err(fault)) => rejections.push(rejection(&records.pings[repeat], &fault)),
                Fitted::Click(Ok(Some((click, inverted)))) => {
                    // Polarity does not move an arrival.
                    corrections.extend(
                        inverted
                            .map(|channel| rejection(&records.clicks[repeat], &Fault::Inverted { channel })),
                    );
                    clicks.push((repeat, click));
                }
                Fitted::Click(Ok(None)) => {}
                Fitted::Click(Err(fault)) => rejections.push(rejection(&records.clicks[repeat], &fault)),
            }
        }
        corrections.extend(turn_inverted(&mut pings, &records.pings));
        let ping_repeats = combine_pings(&mut pings, &records.pings, &mut rejections);
        let click_repeats = combine_clicks(&mut clicks, &records.clicks, &mut rejections);
        let mean_ping = ping_repeats
            .as_ref()
            .zip(ping_delays.as_ref())
            .map(|(repeats, delays)| delays.correct(&ping_of(repeats, options.ping.reference), false));
        // Errors that all clicks of the point share: of the calibration, of the setting, of what is known of the path.
        let shared = click_delays.as_ref().map(|delays| {
            let setting = setting_covariance(set, records.day, &records.point, delays.delay_per_dispersion());
            delays.covariance.plus(1.0, &setting)
        });
        let mean_click = click_repeats.as_ref().zip(shared.as_ref()).map(|(repeats, shared)| Click {
            arrival_times: repeats.mean.clone(),
            covariance: repeats.covariance.plus(1.0, shared),
        });
        points.push(PointObservations {
            point: records.point.clone(),
            ambient: set.days[records.day].clone(),
            ping: mean_ping,
            ping_count: pings.len() as u32,
            click: mean_click,
            click_count: clicks.len() as u32,
            pings: match &ping_delays {
                Some(delays) => pings.iter().map(|(n, p)| (*n as u32, delays.correct(p, false))).collect(),
                None => Vec::new(),
            },
            clicks: match &shared {
                Some(shared) => clicks
                    .into_iter()
                    .map(|(n, c)| (n as u32, Click { covariance: c.covariance.plus(1.0, shared), ..c }))
                    .collect(),
                None => Vec::new(),
            },
        });
        scatter.push(PointScatter { ping: ping_repeats, click: click_repeats });
    }
    if points.iter().all(|p| p.ping.is_none() && p.click.is_none())
        && let Some(first) = rejections.get(calibration_clicks)
    {
        let (record, reason) = (first.record.clone(), first.reason.clone());
        return Err(ProcessError::NothingUsable { count: jobs.len(), record, reason });
    }
    let records = jobs.len()
        + ping_delays.as_ref().map_or(0, |d| d.clicks)
        + click_delays.as_ref().map_or(0, |d| d.clicks);
    let observations = Observations {
        rig: set.rig.clone(),
        kind: set.kind,
        source: set.source.clone(),
        points,
        rejections,
        channels: ping_delays.as_ref().map(|delays| delays.left_over(options.ping.reference)),
    };
    Ok(Processed { observations, ping_delays, click_delays, scatter, corrections, records })
}

enum Fitted {
    Ping(Result<Ping, Fault>),
    /// Arrival times and the channel of opposite polarity, if any; none without a calibration.
    Click(Result<Option<(Click, Option<usize>)>, Fault>),
}

/// Number of records that [`process`] will read: calls of its `advance`.
#[must_use]
pub fn record_count(set: &RecordSet) -> usize {
    let points: usize = set.points.iter().map(|p| p.pings.len() + p.clicks.len()).sum();
    points + set.calibrations.iter().map(|c| c.clicks.len()).sum::<usize>()
}

impl<'a> From<&'a Record> for Trace<'a> {
    fn from(record: &'a Record) -> Self {
        Self {
            channels: &record.channels,
            rate_hz: record.rate_hz,
            quiet: record.quiet,
            full_scale: record.full_scale,
        }
    }
}

fn rejection(record: &str, fault: &Fault) -> Rejection {
    Rejection { record: record.to_owned(), reason: fault.to_string() }
}

fn calibrate(
    source: &dyn RecordSource,
    options: &ProcessOptions,
    rate_hz: f64,
    advance: &(dyn Fn() + Sync),
    rejections: &mut Vec<Rejection>,
) -> Result<ChannelDelays, ProcessError> {
    let set = source.set();
    let jobs: Vec<(usize, usize)> = set
        .calibrations
        .iter()
        .enumerate()
        .filter(|(_, c)| (c.stretch.rate_hz - rate_hz).abs() < 1e-6 * rate_hz)
        .flat_map(|(k, c)| (0..c.clicks.len()).map(move |n| (k, n)))
        .collect();
    if jobs.is_empty() {
        return Err(ProcessError::NoCalibration { rate_hz });
    }
    let fits: Vec<Result<ClickFit, Fault>> = jobs
        .par_iter()
        .map(|&(which, repeat)| -> Result<_, RigError> {
            let record = source.calibration(which, repeat)?;
            let click = click_options(set, set.calibrations[which].day, None, &options.click);
            let fit = fit_click(&Trace::from(&record), &click);
            advance();
            Ok(fit)
        })
        .collect::<Result<_, _>>()?;
    let mut clicks = Vec::new();
    for (&(which, repeat), fit) in jobs.iter().zip(fits) {
        let calibration = &set.calibrations[which];
        let day = &set.days[calibration.day];
        match fit {
            Ok(fit) => {
                let speed = set.rig.gas.at(day.ambient_temperature, set.rig.pressure).sound_speed;
                clicks.push(KnownClick {
                    fit,
                    expected: set.rig.microphones.positions.iter().map(|x| x / speed).collect(),
                    group: calibration.day,
                    // c goes as the square root of the temperature.
                    speed_sd: 0.5 * day.ambient_temperature_sd / day.ambient_temperature,
                });
            }
            Err(fault) => rejections.push(rejection(&calibration.clicks[repeat], &fault)),
        }
    }
    ChannelDelays::calibrate(&clicks, rate_hz).map_err(|cause| ProcessError::Calibration {
        rate_hz,
        cause,
        first_rejection: rejections.first().map(|r| format!("{}: {}", r.record, r.reason)),
    })
}
