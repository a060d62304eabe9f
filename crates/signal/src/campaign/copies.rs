//! Copies of one record under several names: a file that was cut, scaled, converted or saved again.
//!
//! What a fit leaves of a record is white noise, and hum of which it does not know, which records may share.
//! Second differences from row to row are free of that. Of n of them, those of independent white noise have a
//! correlation a'b/(|a| |b|) about zero with the standard deviation sqrt(1.94/n), because the correlations of
//! neighbours are -4/6 and 1/6 (Bartlett). A copy keeps its noise, whatever its scale is and where it ends.
//! The mean over a record and its copies is no better than the record.

use super::fitted::{Fitted, PingOfRecord};
use crate::click::ClickFit;
use crate::delays::KnownClick;
use rijke_numerics::words::counted;
use rijke_rig::{RecordItem, RecordSet, Rejection};

/// Correlation of noise beyond which it is the same: a file of steps of three of its deviations keeps this
/// much of it.
const SAME: f64 = 0.7;
/// The same from which coarse records are copies and not rounded alike: nothing but a copy rounds all samples
/// alike.
const COPIED: f64 = 0.99;
/// Fewest samples that tell: chance then reaches [`SAME`] in eight standard deviations.
const FEWEST: usize = 256;
/// Standard deviations by which no arrival of a copy of a click differs.
const EQUAL: f64 = 1e-4;
/// Rows by which the decay of a copy may have been found earlier or later.
const SHIFT: usize = 4;

/// Makes of every record that has the noise of an earlier one of its point a rejection, and says how many
/// there are: copies, and records that a coarse converter rounds alike.
pub(super) fn leave_out_copies(set: &RecordSet, jobs: &[RecordItem], fitted: &mut [Fitted]) -> Vec<String> {
    let mut copies: Vec<(usize, usize, Same)> = Vec::new();
    let mut first = 0;
    for same_point in jobs.chunk_by(|a, b| a.point() == b.point()) {
        let mut originals: Vec<usize> = Vec::new();
        for k in first..first + same_point.len() {
            match originals.iter().find_map(|o| Some((*o, why_same(&fitted[*o], &fitted[k])?))) {
                Some((original, why)) => copies.push((k, original, why)),
                None => originals.push(k),
            }
        }
        first += same_point.len();
    }
    let said = |rounded: bool| {
        let found: Vec<_> = copies.iter().filter(|(_, _, same)| same.rounded == rounded).collect();
        let (first, original, _) = found.first()?;
        let (name, of) = (jobs[*first].name(set), jobs[*original].name(set));
        let (one, all) = (found.len() == 1, counted(jobs.len(), "record"));
        let left = if one { "is left out" } else { "are left out" };
        Some(if rounded {
            let are = if one { "equals another one" } else { "equal others" };
            format!(
                "{} of {all} {are} of the same point after rounding to the steps of the converter, which are larger than the noise, and {left} \
                 (rejections.csv): the mean of equal records has the error of one of them. The first, {name}, equals {of}. Raise the gain before the converter, or \
                 let the loudspeaker run freely, not in step with it",
                found.len()
            )
        } else {
            let are = if one { "is a copy of another one" } else { "are copies of others" };
            format!(
                "{} of {all} {are} of the same point, and {left} (rejections.csv): the mean over copies is no better than one of them. The first, {name}, is a \
                 copy of {of}. Give the records that were meant, or delete the copies",
                found.len()
            )
        })
    };
    let notes = [false, true].into_iter().filter_map(said).collect();
    for (k, original, Same { rounded, why }) in copies {
        let as_another = if rounded { "rounded as" } else { "a copy of" };
        let reason = format!("{as_another} {}: {why}", jobs[original].name(set));
        fitted[k] = Fitted::Copy(Rejection { record: jobs[k].name(set).to_owned(), reason });
    }
    notes
}

/// Why two records have one noise.
struct Same {
    /// Whether it may be that of rounding.
    rounded: bool,
    why: String,
}

/// Moves calibration clicks, by their names, that are copies of an earlier one to the rejections, and says
/// how many there are.
pub(super) fn leave_out_copied_clicks(
    names: &mut Vec<&str>,
    clicks: &mut Vec<KnownClick>,
    rejections: &mut Vec<Rejection>,
) -> Option<String> {
    let (all, before) = (clicks.len(), rejections.len());
    let mut originals: Vec<(&str, KnownClick)> = Vec::new();
    for (name, click) in names.drain(..).zip(clicks.drain(..)) {
        match originals.iter().find(|(_, original)| is_same_click(&original.fit, &click.fit)) {
            Some((of, _)) => rejections.push(Rejection {
                record: name.to_owned(),
                reason: format!("a copy of {of}: all arrivals are the same, and so is their noise"),
            }),
            None => originals.push((name, click)),
        }
    }
    (*names, *clicks) = originals.into_iter().unzip();
    let copies = rejections.len() - before;
    (copies > 0).then(|| {
        let are = if copies == 1 { "is a copy of another one, and is" } else { "are copies of others, and are" };
        format!(
            "{copies} of {} {are} left out (rejections.csv): the mean over copies is no better than one of them. Give the records that were meant, or delete \
             the copies",
            counted(all, "calibration click")
        )
    })
}

/// Whether two clicks reach all channels one after the other at the same times: the noise of each is in them.
fn is_same_click(a: &ClickFit, b: &ClickFit) -> bool {
    let after = |fit: &ClickFit, m: usize| fit.times[m] - fit.times[fit.pivot];
    let others = || (0..a.times.len()).filter(|m| *m != a.pivot);
    let far = |m: usize| EQUAL * a.covariance[(m, m)].sqrt();
    a.pivot == b.pivot
        && a.times.len() == b.times.len()
        && others().count() > 0
        && others().all(|m| (after(a, m) - after(b, m)).abs() <= far(m))
}

/// Why one of two records has the noise of the other, if it has.
fn why_same(a: &Fitted, b: &Fitted) -> Option<Same> {
    match (a, b) {
        (Fitted::Ping(Ok(a), _), Fitted::Ping(Ok(b), _)) => {
            let r = correlation(a, b).filter(|r| *r > SAME)?;
            let rounded = a.coarse && b.coarse && r < COPIED;
            let noise = if rounded { "errors of rounding of both are" } else { "noise of both is" };
            Some(Same {
                rounded,
                why: format!("the {noise} the same (correlation {r:.3}; of independent records it is zero)"),
            })
        }
        (Fitted::Click(Ok(Some((a, _)))), Fitted::Click(Ok(Some((b, _))))) => {
            let far = |m: usize| EQUAL * a.covariance[(m, m)].sqrt();
            let times = || a.arrival_times.iter().zip(&b.arrival_times).enumerate();
            let same = times().count() > 1 && times().all(|(m, (a, b))| (a - b).abs() <= far(m));
            let why = "all arrivals are the same, and so is their noise".to_owned();
            same.then_some(Same { rounded: false, why })
        }
        _ => None,
    }
}

/// The largest correlation of the noise of two pings; none where they have other channels, or too little of
/// it.
fn correlation(a: &PingOfRecord, b: &PingOfRecord) -> Option<f64> {
    (a.live == b.live).then(|| largest(&a.noise, &b.noise, a.live.len()))?
}

/// The same of samples of so many channels, row by row.
fn largest(a: &[f32], b: &[f32], channels: usize) -> Option<f64> {
    if a.len().min(b.len()) < FEWEST + (SHIFT + 2) * channels {
        return None;
    }
    let [a, b] = [a, b].map(|x| {
        let second = |n: usize| x[n] - 2.0 * x[n + channels] + x[n + 2 * channels];
        (0..x.len() - 2 * channels).map(second).collect::<Vec<f32>>()
    });
    let shifted = |rows: usize| {
        let from = rows * channels;
        [along(&a[from..], &b), along(&a, &b[from..])]
    };
    (0..=SHIFT).flat_map(shifted).max_by(f64::total_cmp)
}

fn along(a: &[f32], b: &[f32]) -> f64 {
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b).map(|(a, b)| (f64::from(*a), f64::from(*b))) {
        (aa, bb, ab) = (aa + a * a, bb + b * b, ab + a * b);
    }
    if aa * bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rijke_numerics::{Matrix, Streams};
    use rijke_rig::Click;

    #[test]
    fn exact_the_same_noise_is_found_whatever_its_scale_and_start() {
        // And a loud hum that all records have.
        let of = |seed: u64, from: usize, scale: f32| -> Vec<f32> {
            let mut stream = Streams::new(seed).stream("copies");
            let mut normal = || -> f32 { StandardNormal.sample(&mut stream) };
            let hum = |n: usize| 3.0 * (0.05 * (n / 3) as f32).sin();
            let noise = (0..1010).map(|n| hum(n) + normal());
            noise.skip(from).take(1000).map(|v| scale * v).collect()
        };
        let a = of(1, 0, 1.0);
        for (from, scale) in [(0, 1.0), (0, 2e-3), (6, 1.0)] {
            let b = of(1, from, scale);
            assert!((largest(&a, &b, 3).unwrap() - 1.0).abs() < 1e-6);
            assert!((largest(&b, &a, 3).unwrap() - 1.0).abs() < 1e-6);
        }
        assert!(largest(&a, &of(2, 0, 1.0), 3).unwrap() < 0.3);
        // Too little of it.
        assert_eq!(largest(&a[..200], &a[..200], 3), None);
    }

    #[test]
    fn message_records_that_a_coarse_converter_rounds_alike_are_no_copies() {
        let mut stream = Streams::new(3).stream("rounded");
        let mut normal = || -> f32 { StandardNormal.sample(&mut stream) };
        let common: Vec<f32> = (0..1000).map(|_| normal()).collect();
        let own: Vec<f32> = common.iter().map(|v| v + 0.3 * normal()).collect();
        let ping = |noise: &[f32], coarse: bool| {
            Fitted::Ping(Ok(Box::new(crate::campaign::fitted::tests::ping(noise.to_vec(), coarse))), None)
        };
        let of = |a: &[f32], b: &[f32], coarse: bool| why_same(&ping(a, coarse), &ping(b, coarse)).unwrap();
        let rounded = of(&common, &own, true);
        assert!(rounded.rounded && rounded.why.starts_with("the errors of rounding of both are the same"));
        assert!(!of(&common, &own, false).rounded && !of(&common, &common, true).rounded);
    }

    #[test]
    fn exact_a_click_that_arrives_as_another_one_did_is_its_copy() {
        let click = |late: f64| {
            let arrival_times = vec![1e-3 + late, 2e-3, 3e-3];
            Fitted::Click(Ok(Some((
                Click { arrival_times, covariance: Matrix::diagonal(&[1e-14; 3]) },
                Vec::new(),
            ))))
        };
        assert!(why_same(&click(0.0), &click(0.0)).is_some());
        assert!(why_same(&click(0.0), &click(1e-9)).is_none());
    }
}
