//! The excess of damping at large amplitude, at all points of a campaign together.
//!
//! An excess too small to be seen moves a growth rate by several stated errors, as a drift does its
//! frequency. So it is free at each point, with a prior that all points teach: normal about a mean, which is
//! normal about zero; the two deviations may have any order of magnitude between 1e-6, where what is lost by
//! radiation and friction is all, and 1. Where nothing is seen, one point alone has growth rates 1.3 to 1.4
//! times less certain than a damping known to be the same at any amplitude would give; of 20 points 1.1.

use super::drifts::{Relative, given_all};
use super::fitted::{Fitted, PingOfRecord};
use crate::ping::Excess;
use rijke_rig::Ping;

/// Orders of magnitude of an excess, relative to the damping at small amplitude.
const RANGE: (f64, f64) = (1e-6, 1.0);
/// Values of each deviation that are tried.
const VALUES: usize = 41;

/// The excess of each point's pings: by themselves, and given all.
pub(super) fn excesses_of(
    jobs: &[(usize, usize, bool)],
    fitted: &[Fitted],
    points: usize,
) -> Vec<(Excess, Excess)> {
    let mut found: Vec<Vec<Excess>> = vec![Vec::new(); points];
    for ((point, _, _), fit) in jobs.iter().zip(fitted) {
        if let Fitted::Ping(Ok(ping), _) = fit {
            found[*point].push(ping.excess);
        }
    }
    let own: Vec<Excess> = found.iter().map(|x| Excess::common(x)).collect();
    let relative: Vec<Relative> =
        own.iter().map(|x| Relative { rate: x.share, sd: x.sd, common: 0.0 }).collect();
    let ratio = (RANGE.1 / RANGE.0).powf(1.0 / (VALUES - 1) as f64);
    let scales: Vec<f64> = (0..VALUES).map(|k| RANGE.0 * ratio.powi(k as i32)).collect();
    let given = given_all(&relative, &scales, &scales);
    own.iter().zip(given).map(|(x, r)| (*x, Excess { share: r.rate, sd: r.sd, ..*x })).collect()
}

/// The ping of a record with the growth rate at small amplitude, by the excess that the pings of its point
/// have in common, whose error is still to be added.
pub(super) fn without_excess(of: &PingOfRecord, common: &Excess) -> Ping {
    let mut ping = of.ping.clone();
    if common.sd.is_finite() {
        if of.excess.is_significant() {
            of.excess.put_back(&mut ping);
        }
        ping.s.re -= common.share * of.excess.moved;
    }
    ping
}

pub(super) fn excess_in_words(point: &str, excess: &Excess) -> String {
    format!(
        "{point}: the damping grows with the amplitude: at the end of the forcing it is {:.2} +- {:.2} % {} that at small amplitude; growth rates are those at small \
         amplitude, with the error that this leaves. Excite more weakly to see them directly",
        100.0 * excess.share.abs(),
        100.0 * excess.sd,
        if excess.share > 0.0 { "above" } else { "below" }
    )
}
