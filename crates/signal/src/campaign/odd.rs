//! Pings that contradict the others of their point, by the scatter that all points show.

use super::fitted::rejection;
use crate::Fault;
use crate::repeats::Repeats;
use rijke_rig::{Ping, Rejection};

/// Fewest points that say how repeats scatter.
const FEWEST: usize = 5;
/// Distance from the others of its point beyond which a ping is none of them, in standard deviations.
const ODD: f64 = 6.0;

/// How growth rate and angular frequency scatter between the repeats of a point beyond what their fits state:
/// the variance that a quarter of the points exceed. None if too few points have repeats.
pub(super) fn usual_scatter<'a>(points: impl Iterator<Item = &'a Repeats>) -> Option<[f64; 2]> {
    let repeated: Vec<&Repeats> = points.filter(|p| p.count > 1).collect();
    let upper = |i: usize| {
        let excess = |p: &&Repeats| (p.squares[i] / (p.count as f64 - 1.0) - p.within[(i, i)]).max(0.0);
        let mut all: Vec<f64> = repeated.iter().map(excess).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() - 1 - all.len() / 4]
    };
    (repeated.len() >= FEWEST).then(|| [upper(0), upper(1)])
}

/// Moves pings that contradict the others of their point to the rejections, and returns whether there were
/// any. More than half of three or more must agree; where they do not, all stay.
pub(super) fn reject_odd(
    pings: &mut Vec<(usize, Ping)>,
    scatter: [f64; 2],
    names: &[String],
    rejections: &mut Vec<Rejection>,
) -> bool {
    let mut kept: Vec<usize> = (0..pings.len()).collect();
    let mut odd = Vec::new();
    while let Some((place, fault)) = farthest(pings, &kept, scatter) {
        if kept.len() < 3 || 2 * (kept.len() - 1) <= pings.len() {
            return false;
        }
        let k = kept.remove(place);
        odd.push((k, rejection(&names[pings[k].0], &fault)));
    }
    odd.sort_by_key(|(k, _)| *k);
    let any = !odd.is_empty();
    let mut k = 0..;
    pings.retain(|_| k.next().is_some_and(|k| kept.contains(&k)));
    rejections.extend(odd.into_iter().map(|(_, rejection)| rejection));
    any
}

/// Of the pings `kept` the one that lies farthest from the others, if that is more than [`ODD`].
fn farthest(pings: &[(usize, Ping)], kept: &[usize], scatter: [f64; 2]) -> Option<(usize, Fault)> {
    let distance = |place: usize, i: usize| {
        let number = |k: usize| [pings[k].1.s.re, pings[k].1.s.im][i];
        let variance = |k: usize| pings[k].1.covariance[(i, i)] + scatter[i];
        let others = || kept.iter().copied().filter(|k| *k != kept[place]);
        let weight: f64 = others().map(|k| variance(k).recip()).sum();
        let mean = others().map(|k| number(k) / variance(k)).sum::<f64>() / weight;
        (number(kept[place]) - mean).abs() / (variance(kept[place]) + weight.recip()).sqrt()
    };
    let each = (0..kept.len()).flat_map(|k| [(k, 0), (k, 1)]).map(|(k, i)| (k, i, distance(k, i)));
    let (place, i, far) = each.filter(|e| e.2 > ODD).max_by(|a, b| a.2.total_cmp(&b.2))?;
    Some((place, Fault::Outlier(["growth rate", "angular frequency"][i].to_owned(), far)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::{C64, Matrix};

    fn ping(growth: f64, sd: f64) -> Ping {
        let covariance = Matrix::diagonal(&[sd * sd, 0.01]);
        Ping { s: C64::new(growth, 1000.0), pressures: vec![C64::ONE], reference: 0, covariance }
    }

    #[test]
    fn exact_a_ping_with_a_large_error_that_is_off_by_more_is_rejected() {
        let names: Vec<String> = (0..4).map(|k| format!("ping-{k}")).collect();
        let left = |pings: &[(f64, f64)], scatter: f64| {
            let mut rejections = Vec::new();
            let mut all: Vec<(usize, Ping)> =
                pings.iter().map(|(growth, sd)| ping(*growth, *sd)).enumerate().collect();
            let odd = reject_odd(&mut all, [scatter, 0.0], &names, &mut rejections);
            assert_eq!((odd, all.len() + rejections.len()), (!rejections.is_empty(), pings.len()));
            rejections.into_iter().map(|r| r.record).collect::<Vec<_>>()
        };
        let agreeing = [(-43.74, 0.17), (-43.86, 0.10), (-43.48, 0.26)];
        let with = |odd| [&agreeing[..], &[odd]].concat();
        assert_eq!(left(&with((-34.61, 1.38)), 0.01), ["ping-3"]);
        // An error that it states, and a scatter that all points show, are no contradiction.
        assert!(left(&with((-34.61, 3.0)), 0.01).is_empty());
        assert!(left(&with((-34.61, 1.38)), 1.5).is_empty());
        // Two against two.
        assert!(left(&[(-43.7, 0.1), (-43.8, 0.1), (-34.6, 0.1), (-34.7, 0.1)], 0.01).is_empty());
    }
}
