//! All records of a campaign: calibration, pings and clicks, means over repeats. Records are read one at a
//! time and in parallel; results keep the order of the set, whatever the number of threads.

use super::calibration::{Calibrated, calibrate};
use super::contradictions::contradictions;
use super::drifts::{Learnt, drift_in_words, drifts_of, without_drift};
use super::excesses::{excess_in_words, excesses_of, without_excess};
use super::fitted::{Fitted, PingOfRecord, by_point, rejection};
use super::gains::{OfPoint, wandering};
use super::kept::Kept;
use super::left_out::{correction, in_words, settle};
use super::live::{LiveRecord, in_all, of_rig};
use super::loud::Loudest;
use super::odd::{reject_odd, usual_scatter};
use super::options::{PointScatter, ProcessError, ProcessOptions, Processed};
use super::path::{click_options, setting_covariance};
use super::rates::{of_other_rates, without_shapes};
use super::repeated::{combine_clicks, combine_pings, ping_of, turn_inverted, unrepeated};
use crate::click::fit_click;
use crate::dsp::noise::other_mains;
use crate::ping::{PingOptions, fit_majority};
use crate::repeats::{Repeats, pool};
use crate::{Channel, Fault, Trace};
use rayon::prelude::*;
use rijke_rig::{Click, Observations, Ping, PointObservations, RecordSet, RecordSource, RigError};
use std::collections::BTreeSet;

/// Processes a record set. `advance` is called once per record, from any thread.
///
/// A bad record is listed among the rejections with its reason. Means are made before channel delays are
/// removed, so that the calibration's error, which all repeats share, enters the covariance of a mean once
/// and undiminished. So do, for arrival times, the shift of the setting that the rig declares
/// ([`rijke_rig::Recording`]) and what is not known of the `way`: both are common to all records of one
/// setting, and differences within it are better than the covariance says. How much repeats scatter is learnt
/// from all points together ([`pool`]).
///
/// Growth rate and frequency need no calibration. Without calibration clicks at the pings' sampling rate mode
/// shapes stand on [`ProcessOptions::stated`], else on the gains found at the clicks' rate with delays known
/// to a sample; if there is neither, the observations hold one microphone, the reference, and no shapes.
/// Clicks without a calibration at their own rate are left out. [`Processed::notes`] says so.
///
/// # Errors
/// See [`ProcessError`].
pub fn process(
    source: &dyn RecordSource,
    options: &ProcessOptions,
    advance: &(dyn Fn() + Sync),
) -> Result<Processed, ProcessError> {
    process_again(source, options, None, advance)
}

/// As [`process`], of a set that grows: records whose fit is `kept` are not read again.
///
/// # Errors
/// See [`ProcessError`].
pub fn process_again(
    source: &dyn RecordSource,
    options: &ProcessOptions,
    kept: Option<&Kept>,
    advance: &(dyn Fn() + Sync),
) -> Result<Processed, ProcessError> {
    let set = source.set();
    let options = &ProcessOptions {
        ping: PingOptions {
            reference: set.rig.microphones.reference,
            decay_times: set.rig.recording.ping_decay_times.unwrap_or(options.ping.decay_times),
            ..options.ping.clone()
        },
        ..options.clone()
    };
    let has = |count: fn(&rijke_rig::PointRecords) -> usize| set.points.iter().any(|p| count(p) > 0);
    let calibrate = || calibrate(source, options, has(|p| p.pings.len()), has(|p| p.clicks.len()), advance);
    let found = match kept {
        Some(kept) => kept.calibrated(set, calibrate)?,
        None => calibrate()?,
    };
    let Calibrated {
        pings: ping_delays,
        at_any_rate,
        clicks: click_delays,
        click: click_options_found,
        mut notes,
        mut rejections,
        records,
    } = found;

    let jobs: Vec<(usize, usize, bool)> = set
        .points
        .iter()
        .enumerate()
        .flat_map(|(k, p)| {
            let pings = (0..p.pings.len()).map(move |n| (k, n, true));
            pings.chain((0..p.clicks.len()).map(move |n| (k, n, false)))
        })
        .collect();
    let loudest = Loudest::default();
    let fitted: Vec<Fitted> = jobs
        .par_iter()
        .map(|&(point, repeat, is_ping)| -> Result<Fitted, RigError> {
            let records = &set.points[point];
            let name = if is_ping { &records.pings[repeat] } else { &records.clicks[repeat] };
            if let Some(fitted) = kept.and_then(|kept| kept.fit(name)) {
                advance();
                return Ok(fitted);
            }
            let fitted = if is_ping {
                let record = source.ping(point, repeat)?;
                loudest.hear(name, &record, true);
                let known = LiveRecord::of(record, options.ping.reference);
                let own = PingOptions { reference: known.reference, ..options.ping.clone() };
                let trace = Trace::from(&known.record);
                let hum = other_mains(trace.channels, trace.quiet, trace.rate_hz, own.mains_hz);
                Fitted::Ping(ping_of_record(repeat, &trace, &own, &known.live), hum)
            } else if click_delays.is_none() {
                Fitted::Click(Ok(None))
            } else {
                let record = source.click(point, repeat)?;
                loudest.hear(name, &record, false);
                let click = click_options(set, records.day, Some(records), &click_options_found);
                let fit = fit_click(&Trace::from(&record), &click);
                Fitted::Click(fit.and_then(|fit| {
                    let delays = click_delays.as_ref();
                    let arrival = delays.map(|d| Ok((d.arrival(&fit, true)?, d.inverted(&fit)?)));
                    arrival.transpose()
                }))
            };
            advance();
            kept.inspect(|kept| kept.keep(name, &fitted));
            Ok(fitted)
        })
        .collect::<Result<_, _>>()?;

    notes.extend(loudest.in_words());
    let calibration_clicks = rejections.len();
    let microphones = set.rig.microphones.positions.len();
    let called = of_rig(&set.acquisition, &set.rig.microphones);
    let those = |live: &[usize]| -> Vec<Channel> { live.iter().map(|m| called[*m].clone()).collect() };
    let of_points = by_point(&jobs, &fitted, set.points.len());
    let (drifts, excesses) = (drifts_of(&of_points), excesses_of(&of_points));
    // Fits are given up as their means are made: those of a whole campaign are not held twice.
    let mut fitted = jobs.iter().zip(fitted).peekable();
    let (mut gathered, mut corrections) = (Vec::with_capacity(set.points.len()), Vec::new());
    let (mut all_left_out, mut hums) = (Vec::new(), Vec::new());
    for (k, records) in set.points.iter().enumerate() {
        let (mut pings, mut clicks) = (Vec::new(), Vec::new());
        while let Some((&(_, repeat, _), fit)) = fitted.next_if(|(job, _)| job.0 == k) {
            match fit {
                Fitted::Ping(Ok(ping), hum) => {
                    hums.extend(hum);
                    pings.push(ping);
                }
                Fitted::Ping(Err(fault), hum) => {
                    hums.extend(hum);
                    rejections.push(rejection(&records.pings[repeat], &fault.called(&called)));
                }
                Fitted::Click(Ok(Some((click, inverted)))) => {
                    // Polarity does not move an arrival.
                    corrections.extend(
                        inverted
                            .map(|channel| Fault::Inverted(channel.into()).called(&called))
                            .map(|fault| rejection(&records.clicks[repeat], &fault)),
                    );
                    clicks.push((repeat, click));
                }
                Fitted::Click(Ok(None)) => {}
                Fitted::Click(Err(fault)) => {
                    rejections.push(rejection(&records.clicks[repeat], &fault.called(&called)));
                }
            }
        }
        let left_out = settle(&records.point.id, &mut pings, &records.pings, &called, &mut rejections);
        corrections.extend(left_out.iter().map(correction));
        all_left_out.extend(left_out);
        // Repeats are compared in the microphones that all of them have.
        let live = in_all(pings.iter().map(|p| &p.live));
        let named = those(&live);
        let is_dead = |m: &usize| {
            !live.contains(m) && pings.iter().all(|p| p.left_out.iter().all(|(left, _)| left != m))
        };
        let dead: Vec<String> = (0..microphones).filter(is_dead).map(|m| called[m].to_string()).collect();
        if !named.is_empty() && !dead.is_empty() {
            let verb = if dead.len() > 1 { "are" } else { "is" };
            notes.push(format!("{}: without {}, which {verb} dead", records.point.id, dead.join(" and ")));
        }
        let (own_excess, excess) = &excesses[k];
        if own_excess.is_significant() || excess.is_significant() {
            notes.push(excess_in_words(&records.point.id, excess));
        }
        let among = |p: PingOfRecord| {
            let ping = without_excess(&p, excess);
            (p.repeat, ping.among(&p.live, microphones).only(&live), p.drift)
        };
        let pings = pings.into_iter().map(among).collect();
        let (own, (drift, of_all)) = &drifts[k];
        let mut pings = without_drift(pings, drift);
        if own.is_significant() {
            notes.push(drift_in_words(&records.point.id, drift, &pings));
        }
        corrections.extend(turn_inverted(&mut pings, &records.pings, &named));
        let ping_repeats = combine_pings(&mut pings, &records.pings, &named, &mut rejections);
        let click_repeats = combine_clicks(&mut clicks, &records.clicks, &called, &mut rejections);
        let (of_drift, of_excess) = ((*drift, *of_all), excess.variance_if_known());
        gathered.push(Gathered { pings, live, clicks, ping_repeats, click_repeats, of_drift, of_excess });
    }
    notes.extend(in_words(&all_left_out, set.points.iter().map(|p| p.pings.len()).sum()));
    let hum = hum_in_words(&hums, options.ping.mains_hz);
    notes.extend(hum.clone());
    if let Some(scatter) = usual_scatter(gathered.iter().filter_map(|g| g.ping_repeats.as_ref())) {
        for (g, records) in gathered.iter_mut().zip(&set.points) {
            if reject_odd(&mut g.pings, scatter, &records.pings, &mut rejections) {
                let named = those(&g.live);
                g.ping_repeats = combine_pings(&mut g.pings, &records.pings, &named, &mut rejections);
            }
        }
    }
    let of_pings = set.points.iter().zip(&gathered).filter_map(|(records, g)| {
        let microphones = those(&g.live);
        let reference = g.pings.first()?.1.reference;
        Some(OfPoint { point: &records.point.id, repeats: g.ping_repeats.as_ref()?, microphones, reference })
    });
    notes.extend(wandering(&of_pings.collect::<Vec<_>>()));
    notes.extend(unrepeated(gathered.iter().map(|g| g.pings.len())));
    // The same microphones at all points that are pooled, so that the same numbers meet.
    let sets: BTreeSet<Vec<usize>> = gathered.iter().map(|g| g.live.clone()).collect();
    for set in sets {
        let alike = gathered.iter_mut().filter(|g| g.live == set);
        pool(&mut alike.filter_map(|g| g.ping_repeats.as_mut()).collect::<Vec<_>>());
    }
    pool(&mut gathered.iter_mut().filter_map(|g| g.click_repeats.as_mut()).collect::<Vec<_>>());
    let of_pings = set.points.iter().zip(&gathered);
    let of_pings = of_pings.filter_map(|(r, g)| Some((r.point.id.as_str(), g.ping_repeats.as_ref()?)));
    notes.extend(contradictions(&of_pings.collect::<Vec<_>>()));
    let (mut points, mut scatter) = (Vec::new(), Vec::new());
    let shapes = ping_delays.is_some();
    let others = if at_any_rate || !shapes { Vec::new() } else { of_other_rates(set) };
    notes.extend(others.first().map(|_| without_shapes(set, &others)));
    for (k, (gathered, records)) in gathered.into_iter().zip(&set.points).enumerate() {
        let Gathered { pings, live, clicks, mut ping_repeats, click_repeats, of_drift, of_excess } = gathered;
        let (drift, of_all) = of_drift;
        // The errors of drift and excess are common to all repeats.
        let of_drift = drift.variance_if_known();
        if let Some(repeats) = &mut ping_repeats {
            repeats.covariance[(0, 0)] += of_excess;
            repeats.covariance[(1, 1)] += of_drift;
        }
        let drifting = |ping: &Ping| {
            let mut ping = ping.clone();
            ping.covariance[(0, 0)] += of_excess;
            ping.covariance[(1, 1)] += of_drift;
            ping
        };
        let calibrated = !live.is_empty() && !others.contains(&k);
        let of_the_live = ping_delays.as_ref().filter(|_| calibrated).map(|delays| delays.only(&live));
        let corrected = |ping: &Ping| match &of_the_live {
            Some(delays) => delays.correct(ping).among(&live, microphones),
            None if shapes && !live.is_empty() => {
                alone(ping).among(&live[ping.reference..=ping.reference], microphones)
            }
            None => alone(ping),
        };
        let reference = live.iter().position(|m| *m == options.ping.reference).unwrap_or(0);
        let mean_ping = ping_repeats.as_ref().map(|repeats| corrected(&ping_of(repeats, reference)));
        // Errors that all clicks of the point share: of the calibration, of the setting, of what is known of
        // the path.
        let shared = click_delays.as_ref().map(|delays| {
            let setting =
                setting_covariance(set, records.day, records.way.as_ref(), delays.delay_per_dispersion());
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
            drift_sd: if drift.sd.is_finite() { of_all * drift.moment.abs() } else { 0.0 },
            ping_count: pings.len() as u32,
            click: mean_click,
            click_count: clicks.len() as u32,
            pings: pings.iter().map(|(n, p)| (*n as u32, corrected(&drifting(p)))).collect(),
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
        let hum = hum.map_or_else(String::new, |hum| format!("; {hum}"));
        let (record, reason) = (first.record.clone(), format!("{}{hum}", first.reason));
        return Err(ProcessError::NothingUsable { count: jobs.len(), record, reason });
    }
    let records = jobs.len() + records;
    let mut rig = set.rig.clone();
    if !shapes && has(|p| p.pings.len()) {
        let position = rig.microphones.positions.get(options.ping.reference).copied();
        rig.microphones.positions = position.into_iter().collect();
        rig.microphones.names.clear();
        rig.microphones.reference = 0;
    }
    let whole = shapes || !has(|p| p.pings.len());
    let observations = Observations {
        rig,
        kind: set.kind,
        source: set.source.clone(),
        points,
        rejections,
        channels: ping_delays.as_ref().map(|delays| delays.left_over(options.ping.reference)),
    };
    let observations =
        if whole { observations.with_the_dead(&set.acquisition.removed) } else { observations };
    let (ping, click) = (options.ping.clone(), click_options_found);
    Ok(Processed {
        observations,
        ping_delays,
        click_delays,
        ping,
        click,
        notes,
        scatter,
        corrections,
        records,
    })
}

/// What is left of one operating point's records.
struct Gathered {
    pings: Vec<(usize, Ping)>,
    /// The microphones of the pings.
    live: Vec<usize>,
    clicks: Vec<(usize, Click)>,
    ping_repeats: Option<Repeats>,
    click_repeats: Option<Repeats>,
    /// What was taken out of all pings; of infinite error if nothing was.
    of_drift: Learnt,
    /// Variance of the growth rates that all pings have in common, from the excess of damping.
    of_excess: f64,
}

/// Fits a ping whose channels are the `live` microphones.
fn ping_of_record(
    repeat: usize,
    trace: &Trace<'_>,
    options: &PingOptions,
    live: &[usize],
) -> Result<PingOfRecord, Fault> {
    let found = fit_majority(trace, options).map_err(|fault| fault.within(live))?;
    Ok(PingOfRecord {
        repeat,
        ping: found.fit.ping,
        drift: found.fit.drift,
        excess: found.fit.excess,
        live: found.kept.iter().map(|place| live[*place]).collect(),
        left_out: found.left_out.into_iter().map(|(m, fault)| (live[m], fault.within(live))).collect(),
    })
}

/// What to say of pings whose silence hums with other mains than those stated.
fn hum_in_words(found: &[f64], stated: f64) -> Option<String> {
    let hz = *found.first()?;
    let count = found.iter().filter(|f| **f == hz).count();
    Some(format!(
        "the silence of {count} pings hums at {hz:.0} Hz and its multiples, and the mains are said to have {stated:.0} Hz: write `mains_hz = {hz:.0}` in the \
         manifest, or give --mains {hz:.0}"
    ))
}

/// A ping without its shape: that of the reference microphone alone.
fn alone(ping: &Ping) -> Ping {
    Ping { s: ping.s, pressures: vec![1.0.into()], reference: 0, covariance: ping.covariance.select(&[0, 1]) }
}

/// Number of records that [`process`] will read: calls of its `advance`.
#[must_use]
pub fn record_count(set: &RecordSet) -> usize {
    let points: usize = set.points.iter().map(|p| p.pings.len() + p.clicks.len()).sum();
    points + set.calibrations.iter().map(|c| c.clicks.len()).sum::<usize>()
}
