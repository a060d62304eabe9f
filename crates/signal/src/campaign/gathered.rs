//! The records of one operating point: what is left of them, and what they say together.

use super::drifts::{Learnt, drift_in_words, without_drift};
use super::excesses::{excess_in_words, without_excess};
use super::fitted::{Fitted, PingOfRecord, rejection};
use super::left_out::{LeftOut, correction, settle};
use super::live::in_all;
use super::options::PointScatter;
use super::path::setting_covariance;
use super::polarity::{Tie, set_polarity};
use super::repeated::{combine_clicks, combine_pings};
use crate::delays::ChannelDelays;
use crate::ping::{Drift, Excesses};
use crate::repeats::Repeats;
use crate::{Channel, Fault};
use rijke_numerics::Matrix;
use rijke_rig::{Click, Ping, PointObservations, PointRecords, RecordSet, Rejection};

/// What is left of one operating point's records.
pub(super) struct Gathered {
    pub(super) pings: Vec<(usize, Ping)>,
    /// The microphones of the pings.
    pub(super) live: Vec<usize>,
    clicks: Vec<(usize, Click)>,
    pub(super) ping_repeats: Option<Repeats>,
    pub(super) click_repeats: Option<Repeats>,
    /// What was taken out of all pings; of infinite error if nothing was.
    drift: Drift,
    /// The part of its error that all points have in common, rad/s^2.
    drift_of_all: f64,
    /// Variance of the growth rates that all pings have in common, from the excess of damping.
    excess_variance: f64,
}

/// What is to be told of a campaign, as it is gathered.
#[derive(Default)]
pub(super) struct Said<'a> {
    pub(super) notes: Vec<String>,
    pub(super) rejections: Vec<Rejection>,
    pub(super) corrections: Vec<Rejection>,
    pub(super) left_out: Vec<LeftOut>,
    pub(super) ties: Vec<Tie>,
    /// Frequencies of mains that are not the stated ones, Hz.
    pub(super) hums: Vec<f64>,
    /// Pings of which so many seconds were left out because another mode sounds there.
    pub(super) skipped: Vec<(&'a str, f64)>,
    /// Pings with two modes that are about equally loud, and their frequencies, Hz.
    pub(super) pairs: Vec<(&'a str, [f64; 2])>,
    /// Pings of which a last part that is one number was cut off, and from when on, s.
    pub(super) padded: Vec<(&'a str, f64)>,
}

/// What is known of the channels.
#[derive(Clone, Copy)]
pub(super) struct Channels<'a> {
    /// At the rate of the pings, and of the clicks.
    pub(super) pings: Option<&'a ChannelDelays>,
    pub(super) clicks: Option<&'a ChannelDelays>,
    /// How many microphones there are, and to which pressures are relative.
    pub(super) microphones: usize,
    pub(super) reference: usize,
}

impl Gathered {
    /// From the fits of a point's records, with the drift and the excess of damping of its pings: by
    /// themselves, and given all points.
    pub(super) fn of<'a>(
        records: &'a PointRecords,
        fits: Vec<Fitted>,
        ((own_drift, (drift, drift_of_all)), (own_excess, excess)): (&(Drift, Learnt), &(Excesses, Excesses)),
        called: &[Channel],
        said: &mut Said<'a>,
    ) -> Self {
        let id = &records.point.id;
        let (mut pings, mut clicks) = sorted(records, fits, called, said);
        let left_out = settle(id, &mut pings, &records.pings, called, &mut said.rejections);
        said.corrections.extend(left_out.iter().map(correction));
        said.left_out.extend(left_out);
        // Repeats are compared in the microphones that all of them have.
        let live = in_all(pings.iter().map(|p| &p.live));
        let named: Vec<Channel> = live.iter().map(|m| called[*m].clone()).collect();
        let is_dead = |m: &usize| {
            !live.contains(m) && pings.iter().all(|p| p.left_out.iter().all(|(left, _)| left != m))
        };
        let dead: Vec<String> = (0..called.len()).filter(is_dead).map(|m| called[m].to_string()).collect();
        if !named.is_empty() && !dead.is_empty() {
            let verb = if dead.len() > 1 { "are" } else { "is" };
            said.notes.push(format!("{id}: without {}, which {verb} dead", dead.join(" and ")));
        }
        if own_excess.is_significant() || excess.is_significant() {
            said.notes.push(excess_in_words(id, excess));
        }
        let among = |p: PingOfRecord| {
            let ping = without_excess(&p, excess);
            (p.repeat, ping.among(&p.live, called.len()).only(&live), p.drift)
        };
        let pings = pings.into_iter().map(among).collect();
        let mut pings = without_drift(pings, drift);
        if own_drift.is_significant() {
            said.notes.push(drift_in_words(id, drift, &pings));
        }
        let polarities = set_polarity(id, &mut pings, &records.pings, &named);
        said.corrections.extend(polarities.corrections);
        said.ties.extend(polarities.ties);
        let (live, named) = without(&mut pings, &polarities.unknown, live, named);
        let ping_repeats = combine_pings(&mut pings, &records.pings, &named, &mut said.rejections);
        let click_repeats = combine_clicks(&mut clicks, &records.clicks, called, &mut said.rejections);
        let (drift, drift_of_all, excess_variance) = (*drift, *drift_of_all, excess.variance());
        Self { pings, live, clicks, ping_repeats, click_repeats, drift, drift_of_all, excess_variance }
    }

    /// The microphones of the pings, as `called`.
    pub(super) fn named(&self, called: &[Channel]) -> Vec<Channel> {
        self.live.iter().map(|m| called[*m].clone()).collect()
    }

    /// Adds the errors of drift and excess, which are common to all repeats.
    fn widen(&self, covariance: &mut Matrix) {
        covariance[(0, 0)] += self.excess_variance;
        covariance[(1, 1)] += self.drift.variance_if_known();
    }

    /// The observations of the point, with mode shapes if its pings are `calibrated`, and what its repeats
    /// say.
    pub(super) fn observed(
        mut self,
        set: &RecordSet,
        records: &PointRecords,
        channels: Channels<'_>,
        calibrated: bool,
    ) -> (PointObservations, PointScatter) {
        let Channels { pings: ping_delays, clicks: click_delays, microphones, reference } = channels;
        if let Some(mut repeats) = self.ping_repeats.take() {
            self.widen(&mut repeats.covariance);
            self.ping_repeats = Some(repeats);
        }
        let widened = |ping: &Ping| {
            let mut ping = ping.clone();
            self.widen(&mut ping.covariance);
            ping
        };
        let live = &self.live;
        let shapes = ping_delays.filter(|_| calibrated && !live.is_empty()).map(|delays| delays.only(live));
        let corrected = |ping: &Ping| match &shapes {
            Some(delays) => delays.correct(ping).among(live, microphones),
            None if ping_delays.is_some() && !live.is_empty() => {
                alone(ping).among(&live[ping.reference..=ping.reference], microphones)
            }
            None => alone(ping),
        };
        let reference = live.iter().position(|m| *m == reference).unwrap_or(0);
        let mean_ping = self.ping_repeats.as_ref().map(|repeats| {
            corrected(&Ping::from_vector(&repeats.mean, reference, repeats.covariance.clone()))
        });
        // Errors that all clicks of the point share: of the calibration, of the setting, of what is known of
        // the path.
        let shared = click_delays.map(|delays| {
            let setting =
                setting_covariance(set, records.day, records.way.as_ref(), delays.delay_per_dispersion());
            delays.covariance.plus(1.0, &setting)
        });
        let mean_click = self.click_repeats.as_ref().zip(shared.as_ref()).map(|(repeats, shared)| Click {
            arrival_times: repeats.mean.clone(),
            covariance: repeats.covariance.plus(1.0, shared),
        });
        let of_all = self.drift_of_all * self.drift.moment.abs();
        let point = PointObservations {
            point: records.point.clone(),
            ambient: set.days[records.day].clone(),
            ping: mean_ping,
            drift_sd: if self.drift.sd.is_finite() { of_all } else { 0.0 },
            ping_count: self.pings.len() as u32,
            click: mean_click,
            click_count: self.clicks.len() as u32,
            pings: self.pings.iter().map(|(n, p)| (*n as u32, corrected(&widened(p)))).collect(),
            clicks: match &shared {
                Some(shared) => self
                    .clicks
                    .iter()
                    .map(|(n, c)| {
                        let covariance = c.covariance.plus(1.0, shared);
                        (*n as u32, Click { arrival_times: c.arrival_times.clone(), covariance })
                    })
                    .collect(),
                None => Vec::new(),
            },
        };
        (point, PointScatter { ping: self.ping_repeats, click: self.click_repeats })
    }
}

/// The pings of a point, and its clicks by their numbers; what was refused is told.
fn sorted<'a>(
    records: &'a PointRecords,
    fits: Vec<Fitted>,
    called: &[Channel],
    said: &mut Said<'a>,
) -> (Vec<PingOfRecord>, Vec<(usize, Click)>) {
    let (mut pings, mut clicks) = (Vec::new(), Vec::new());
    let files = records.pings.iter().chain(&records.clicks).zip(0..);
    for ((file, place), fit) in files.zip(fits) {
        match fit {
            Fitted::Ping(found, hum) => {
                said.hums.extend(hum);
                match found {
                    Ok(ping) => {
                        said.skipped
                            .extend((ping.skipped_s > 0.0).then_some((file.as_str(), ping.skipped_s)));
                        said.pairs.extend(ping.pair_hz.map(|hertz| (file.as_str(), hertz)));
                        said.padded.extend(ping.padded_from_s.map(|from| (file.as_str(), from)));
                        pings.push(*ping);
                    }
                    Err(fault) => said.rejections.push(rejection(file, &fault.called(called))),
                }
            }
            Fitted::Copy(of_another) => said.rejections.push(of_another),
            Fitted::Click(Ok(Some((click, inverted)))) => {
                // Polarity does not move an arrival.
                let faults = inverted.into_iter().map(|m| Fault::Inverted(m.into()).called(called));
                said.corrections.extend(faults.map(|fault| rejection(file, &fault)));
                clicks.push((place - records.pings.len(), click));
            }
            Fitted::Click(Ok(None)) => {}
            Fitted::Click(Err(fault)) => said.rejections.push(rejection(file, &fault.called(called))),
        }
    }
    (pings, clicks)
}

/// Leaves the channels at some places out of the pings of a point, whose microphones are `live` and `named`
/// so.
fn without(
    pings: &mut [(usize, Ping)],
    unknown: &[usize],
    live: Vec<usize>,
    named: Vec<Channel>,
) -> (Vec<usize>, Vec<Channel>) {
    if unknown.is_empty() {
        return (live, named);
    }
    let kept: Vec<usize> = (0..live.len()).filter(|place| !unknown.contains(place)).collect();
    pings.iter_mut().for_each(|(_, ping)| *ping = ping.only(&kept));
    kept.iter().map(|place| (live[*place], named[*place].clone())).unzip()
}

/// A ping without its shape: that of the reference microphone alone.
fn alone(ping: &Ping) -> Ping {
    Ping { s: ping.s, pressures: vec![1.0.into()], reference: 0, covariance: ping.covariance.select(&[0, 1]) }
}
