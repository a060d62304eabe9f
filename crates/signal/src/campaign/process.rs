//! All records of a campaign: calibration, pings and clicks, means over repeats. Records are read one at a
//! time and in parallel; results keep the order of the set, whatever the number of threads.

use super::calibration::{Calibrated, calibrate};
use super::contradictions::contradictions;
use super::copies::leave_out_copies;
use super::disagreeing::apart;
use super::drifts::drifts_of;
use super::excesses::excesses_of;
use super::extrapolated::extrapolated;
use super::fitted::{
    Fitted, PingOfRecord, by_point, padded_in_words, pair, pairs_in_words, skipped_in_words,
};
use super::gains::OfPoint;
use super::gathered::{Channels, Gathered, Said};
use super::kept::Kept;
use super::left_out::in_words;
use super::live::{LiveRecord, of_rig};
use super::loud::{Loudest, loudness};
use super::odd::{reject_odd, usual_scatter};
use super::options::{ProcessError, ProcessOptions, Processed};
use super::path::click_options;
use super::polarity::ties_in_words;
use super::rates::{of_other_rates, without_shapes};
use super::repeated::{combine_pings, unrepeated};
use super::travel;
use crate::click::{ClickOptions, fit_click};
use crate::delays::ChannelDelays;
use crate::dsp::noise::other_mains;
use crate::ping::{PingOptions, fit_majority};
use crate::repeats::pool;
use crate::{Fault, Trace};
use rayon::prelude::*;
use rijke_numerics::InOrder;
use rijke_rig::{Observations, RecordItem, RecordSet, RecordSource, RigError};
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
        click,
        notes,
        rejections,
        records,
    } = found;
    let mut said = Said { notes, rejections, ..Said::default() };

    let of_calibration = |item: &RecordItem| matches!(item, RecordItem::Calibration(..));
    let jobs: Vec<RecordItem> = set.items().into_iter().filter(|item| !of_calibration(item)).collect();
    let fitted = fit_all(source, options, &jobs, (click_delays.as_ref(), &click), kept, advance)?;
    let (mut fitted, loudest) = fitted;
    said.notes.extend(loudest.in_words());
    said.notes.extend(leave_out_copies(set, &jobs, &mut fitted));
    let calibration_clicks = said.rejections.len();
    let microphones = set.rig.microphones.positions.len();
    let called = &of_rig(&set.acquisition, &set.rig.microphones);
    let of_points = by_point(&jobs, &fitted, set.points.len());
    let (drifts, excesses) = (drifts_of(&of_points), excesses_of(&of_points));
    // Fits are given up as their means are made: those of a whole campaign are not held twice.
    let mut fitted = jobs.iter().zip(fitted).peekable();
    let mut gathered = Vec::with_capacity(set.points.len());
    for (k, records) in set.points.iter().enumerate() {
        let mut own = Vec::new();
        while let Some((_, fit)) = fitted.next_if(|(job, _)| job.point() == Some(k)) {
            own.push(fit);
        }
        gathered.push(Gathered::of(records, own, (&drifts[k], &excesses[k]), called, &mut said));
    }
    let count = set.points.iter().map(|p| p.pings.len()).sum();
    said.notes.extend(in_words(&said.left_out, count));
    said.notes.extend(ties_in_words(&said.ties));
    said.notes.extend(skipped_in_words(&said.skipped));
    said.notes.extend(pairs_in_words(&said.pairs));
    said.notes.extend(padded_in_words(&said.padded));
    let hum = hum_in_words(&said.hums, options.ping.mains_hz);
    said.notes.extend(hum.clone());
    reconsider(set, &mut gathered, &mut said);

    let modes: Vec<f64> = gathered.iter().filter_map(|g| Some(g.ping_repeats.as_ref()?.mean[1])).collect();
    said.notes.extend(extrapolated(set.kind, &modes, ping_delays.as_ref()));
    let shapes = ping_delays.is_some();
    let others = if at_any_rate || !shapes { Vec::new() } else { of_other_rates(set) };
    said.notes.extend(others.first().map(|_| without_shapes(set, &others)));
    let channels = Channels {
        pings: ping_delays.as_ref(),
        clicks: click_delays.as_ref(),
        microphones,
        reference: options.ping.reference,
    };
    let (mut points, mut scatter) = (Vec::new(), Vec::new());
    for (k, (gathered, records)) in gathered.into_iter().zip(&set.points).enumerate() {
        let (point, of_repeats) = gathered.observed(set, records, channels, !others.contains(&k));
        points.push(point);
        scatter.push(of_repeats);
    }
    let Said { notes, rejections, corrections, .. } = said;
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
    let ping = options.ping.clone();
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

/// Fits of some records, or those that were kept, and the loudest of the records.
fn fit_all(
    source: &dyn RecordSource,
    options: &ProcessOptions,
    jobs: &[RecordItem],
    (click_delays, click): (Option<&ChannelDelays>, &ClickOptions),
    kept: Option<&Kept>,
    advance: &(dyn Fn() + Sync),
) -> Result<(Vec<Fitted>, Loudest), RigError> {
    let (set, loudest) = (source.set(), Loudest::default());
    let fit_of = |item: RecordItem| -> Result<(Fitted, f64), RigError> {
        match item {
            RecordItem::Ping(_, repeat) => {
                let record = item.read(source)?;
                let peak = loudness(&record);
                let known = LiveRecord::of(record, options.ping.reference);
                let own = PingOptions { reference: known.reference, ..options.ping.clone() };
                let trace = Trace::from(&known.record);
                let hum = other_mains(trace.channels, trace.quiet, trace.rate_hz, own.mains_hz);
                Ok((Fitted::Ping(ping_of_record(repeat, &trace, &own, &known.live), hum), peak))
            }
            RecordItem::Click(point, _) | RecordItem::Calibration(point, _) => {
                let Some(delays) = click_delays else { return Ok((Fitted::Click(Ok(None)), 0.0)) };
                let record = item.read(source)?;
                let peak = loudness(&record);
                let records = &set.points[point];
                let own = click_options(set, records.day, Some(records), click);
                let arrival = fit_click(&Trace::from(&record), &own).and_then(|fit| {
                    let arrival = delays.arrival(&fit, true)?;
                    travel::check(set, &arrival, &delays.covariance)?;
                    Ok(Some((arrival, delays.inverted(&fit)?)))
                });
                Ok((Fitted::Click(arrival), peak))
            }
        }
    };
    let one = |item: &RecordItem| -> Result<Fitted, RigError> {
        let name = item.name(set);
        let (fitted, peak) = match kept.and_then(|kept| kept.fit(name)) {
            Some(known) => known,
            None => {
                let (fitted, peak) = fit_of(*item)?;
                kept.inspect(|kept| kept.keep(name, &fitted, peak));
                (fitted, peak)
            }
        };
        loudest.hear(name, peak, matches!(item, RecordItem::Ping(..)));
        advance();
        Ok(fitted)
    };
    Ok((jobs.par_iter().map(one).in_order::<Result<_, _>>()?, loudest))
}

/// What all points together say of the repeats of each: what is odd among them, and how much they scatter.
fn reconsider(set: &RecordSet, gathered: &mut [Gathered], said: &mut Said<'_>) {
    let called = of_rig(&set.acquisition, &set.rig.microphones);
    if let Some(scatter) = usual_scatter(gathered.iter().filter_map(|g| g.ping_repeats.as_ref())) {
        for (g, records) in gathered.iter_mut().zip(&set.points) {
            if reject_odd(&mut g.pings, scatter, &records.pings, &mut said.rejections) {
                let named = g.named(&called);
                g.ping_repeats = combine_pings(&mut g.pings, &records.pings, &named, &mut said.rejections);
            }
        }
    }
    let of_pings = set.points.iter().zip(&*gathered).filter_map(|(records, g)| {
        let microphones = g.named(&called);
        let reference = g.pings.first()?.1.reference;
        let (pings, names) = (&g.pings, &records.pings);
        let (point, repeats) = (&records.point.id, g.ping_repeats.as_ref()?);
        Some(OfPoint { point, repeats, microphones, reference, pings, names })
    });
    said.notes.extend(apart(&of_pings.collect::<Vec<_>>()));
    said.notes.extend(unrepeated(gathered.iter().map(|g| g.pings.len())));
    // The same microphones at all points that are pooled, so that the same numbers meet.
    let sets: BTreeSet<Vec<usize>> = gathered.iter().map(|g| g.live.clone()).collect();
    for live in sets {
        let alike = gathered.iter_mut().filter(|g| g.live == live);
        pool(&mut alike.filter_map(|g| g.ping_repeats.as_mut()).collect::<Vec<_>>());
    }
    pool(&mut gathered.iter_mut().filter_map(|g| g.click_repeats.as_mut()).collect::<Vec<_>>());
    let of_pings = set.points.iter().zip(&*gathered);
    let of_pings = of_pings.filter_map(|(r, g)| Some((r.point.id.as_str(), g.ping_repeats.as_ref()?)));
    said.notes.extend(contradictions(&of_pings.collect::<Vec<_>>()));
}

/// Fits a ping whose channels are the `live` microphones.
fn ping_of_record(
    repeat: usize,
    trace: &Trace<'_>,
    options: &PingOptions,
    live: &[usize],
) -> Result<Box<PingOfRecord>, Fault> {
    let found = fit_majority(trace, options).map_err(|fault| fault.within(live))?;
    Ok(Box::new(PingOfRecord {
        repeat,
        pair_hz: pair(&found.fit),
        ping: found.fit.ping,
        drift: found.fit.drift,
        excess: found.fit.excess,
        noise: found.fit.noise,
        skipped_s: found.fit.skipped_s,
        padded_from_s: trace.padded_from().map(|from| from as f64 / trace.rate_hz),
        coarse: trace.coarse_steps().iter().any(|step| *step > 0.0),
        live: found.kept.iter().map(|place| live[*place]).collect(),
        left_out: found.left_out.into_iter().map(|(m, fault)| (live[m], fault.within(live))).collect(),
    }))
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

/// Number of records that [`process`] will read: calls of its `advance`.
#[must_use]
pub fn record_count(set: &RecordSet) -> usize {
    let points: usize = set.points.iter().map(|p| p.pings.len() + p.clicks.len()).sum();
    points + set.calibrations.iter().map(|c| c.clicks.len()).sum::<usize>()
}
