//! A ping of which one channel contradicts the others: fitted without it, if the others agree.

use super::fit::fit_ping;
use super::found::PingFit;
use super::options::PingOptions;
use crate::{Fault, Trace};

/// Variance of the residuals, over that of the noise, up to which the other channels are in order: a
/// channel is not left out to bring a record just below the limit.
const IN_ORDER: f64 = 1.08;

/// A ping, and the channels that were left out.
#[derive(Clone, Debug)]
pub struct MajorityFit {
    /// The fit of the others.
    pub fit: PingFit,
    /// Their places among the channels of the record, ascending.
    pub kept: Vec<usize>,
    /// The place of each channel that was left out, and what speaks against it.
    pub left_out: Vec<(usize, Fault)>,
}

/// Fits a ping as [`fit_ping`] does; without a channel whose gain drifts, that is clipped or that carries no
/// signal, and without one that alone keeps the others from being fitted. More than half of the channels must
/// agree, two at least, among them the reference.
///
/// # Errors
/// The [`Fault`] of the whole record, if leaving out channels is no remedy.
pub fn fit_majority(trace: &Trace<'_>, options: &PingOptions) -> Result<MajorityFit, Fault> {
    let all = trace.channels.len();
    let mut kept: Vec<usize> = (0..all).collect();
    let (mut left_out, mut found) = (Vec::new(), fit_ping(trace, options));
    loop {
        let fault = match found {
            Ok(fit) => return Ok(MajorityFit { fit, kept, left_out }),
            Err(fault) => fault,
        };
        let next = if kept.len() > 2 && 2 * (kept.len() - 1) > all {
            without_one(trace, options, &kept, &fault)
        } else {
            None
        };
        let fault = fault.within(&kept);
        let Some((place, fit)) = next else {
            return Err(left_out.into_iter().next().map_or(fault, |(_, first)| first));
        };
        left_out.push((kept.remove(place), fault));
        found = fit;
    }
}

/// The place of a channel, among those that were kept, that explains the fault, and the fit without it.
fn without_one(
    trace: &Trace<'_>,
    options: &PingOptions,
    kept: &[usize],
    fault: &Fault,
) -> Option<(usize, Result<PingFit, Fault>)> {
    let all: Vec<usize> = (0..kept.len()).filter(|p| kept[*p] != options.reference).collect();
    let fit_of = |without: &[usize]| {
        without.iter().all(|p| all.contains(p)).then(|| {
            let is_kept = |(p, m): (usize, &usize)| (!without.contains(&p)).then_some(*m);
            let others: Vec<usize> = kept.iter().enumerate().filter_map(is_kept).collect();
            let channels: Vec<Vec<f64>> = others.iter().map(|m| trace.channels[*m].clone()).collect();
            let reference = others.iter().position(|m| *m == options.reference).unwrap_or(0);
            let part = Trace { channels: &channels, ..*trace };
            fit_ping(&part, &PingOptions { reference, ..options.clone() })
        })
    };
    let fit = |place: usize| fit_of(&[place]);
    let in_order =
        |found: &Result<PingFit, Fault>| found.as_ref().is_ok_and(|fit| fit.residual_variance < IN_ORDER);
    match fault {
        Fault::GainDrifts { channel, .. }
        | Fault::NoSignal { channel, .. }
        | Fault::DeadChannel { channel, .. }
        | Fault::Clipped { channel, .. }
        | Fault::OnlyHum { channel, .. } => fit(channel.number()).map(|found| (channel.number(), found)),
        Fault::Residual { channel, .. } => {
            let found = fit(channel.number()).filter(in_order);
            found.map(|found| (channel.number(), found)).or_else(|| the_only(&all, &fit_of, &in_order))
        }
        Fault::NotFree { .. } | Fault::NotConverged { .. } | Fault::Singular(_) | Fault::HumBurst { .. } => {
            the_only(&all, &fit_of, &in_order)
        }
        _ => None,
    }
}

/// The only place without which the others are in order. What is wrong in all channels is wrong without half
/// of them, too: then none is tried alone.
fn the_only(
    places: &[usize],
    fit: &impl Fn(&[usize]) -> Option<Result<PingFit, Fault>>,
    in_order: &impl Fn(&Result<PingFit, Fault>) -> bool,
) -> Option<(usize, Result<PingFit, Fault>)> {
    let halves = places.chunks(places.len().div_ceil(2).max(1));
    let worth = |half: &&[usize]| half.len() < 2 || fit(half).is_some_and(|found| in_order(&found));
    let doubtful = halves.filter(worth).flatten();
    let mut found = doubtful.filter_map(|place| Some((*place, fit(&[*place]).filter(in_order)?)));
    let first = found.next()?;
    found.next().is_none().then_some(first)
}
