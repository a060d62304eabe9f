//! Gains that change from record to record.

use super::left_out::some_of;
use crate::Channel;
use crate::repeats::Repeats;
use rijke_numerics::tails::chi_squared_as_normal;
use rijke_rig::Ping;

/// Scatter of a relative pressure between the repeats of a point, relative to it, that is said; and how
/// many times that of the other channels it must be.
const SAID: f64 = 0.01;
const ODD: f64 = 5.0;
/// Where all pressures scatter alike, within this factor, their reference does.
const ALIKE: f64 = 2.0;
/// Standard normal deviate beyond which repeats scatter by more than their noise: 1e-6, for the many points
/// and microphones of a campaign.
const SURELY: f64 = 4.75;

/// The pings of a point: its name, what its repeats say, its microphones, and the place of the reference
/// among them.
pub(super) struct OfPoint<'a> {
    pub(super) point: &'a str,
    pub(super) repeats: &'a Repeats,
    pub(super) microphones: Vec<Channel>,
    pub(super) reference: usize,
    /// The pings, and the files of all records of the point.
    pub(super) pings: &'a [(usize, Ping)],
    pub(super) names: &'a [String],
}

/// How the pressure of one microphone scatters between the repeats of a point; zero where noise explains it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Scatter {
    /// Relative to its mean, to the largest pressure of the point, and in standard deviations of the noise.
    pub(super) of_own: f64,
    pub(super) of_largest: f64,
    pub(super) of_noise: f64,
}

impl Scatter {
    /// Of all microphones but the reference.
    pub(super) fn of_point(of: &OfPoint<'_>) -> Vec<Self> {
        let Repeats { between, mean, squares, within, count, .. } = of.repeats;
        let freedom = *count as f64 - 1.0;
        let size = |i: usize| mean[2 + 2 * i].hypot(mean[3 + 2 * i]);
        let others = of.microphones.len() - 1;
        let largest = (0..others).map(size).fold(1.0, f64::max);
        let scatter = |i: usize| {
            let (re, im) = (2 + 2 * i, 3 + 2 * i);
            let part = |k: usize| squares[k] / within[(k, k)];
            if chi_squared_as_normal(part(re) + part(im), 2.0 * freedom) < SURELY {
                return Self::default();
            }
            let scatter = (between[re] + between[im]).sqrt();
            let of_noise = (part(re).max(part(im)) / freedom).sqrt();
            Self { of_own: scatter / size(i), of_largest: scatter / largest, of_noise }
        };
        (0..others).map(scatter).collect()
    }

    pub(super) fn is_said(&self) -> bool {
        self.of_largest > SAID
    }
}

/// The microphones whose gain changes between repeats, with the point and the relative scatter.
pub(super) fn wandering<'a>(points: &[&'a OfPoint<'a>]) -> Vec<(&'a Channel, &'a str, f64)> {
    let mut found: Vec<(&Channel, &str, f64)> = points.iter().flat_map(|of| of_point(of)).collect();
    found.sort_by_key(|f| f.0.number());
    found
}

/// A sentence for each of them.
pub(super) fn gains_in_words(found: &[(&Channel, &str, f64)]) -> Vec<String> {
    let say = |of: &[(&Channel, &str, f64)]| {
        let largest = of.iter().map(|f| f.2).fold(0.0, f64::max);
        let (microphone, points) = (of[0].0, of.iter().map(|f| f.1).collect::<Vec<_>>());
        format!(
            "the gain of {microphone} changes between the repeats of {}, by up to {:.1} %: mode shapes carry this as an error. Look \
             after it, or write `dead = [{}]` in the manifest",
            some_of(&points),
            100.0 * largest,
            microphone.number()
        )
    };
    found.chunk_by(|a, b| a.0 == b.0).map(say).collect()
}

/// Microphone, point, relative scatter.
fn of_point<'a>(of: &'a OfPoint<'a>) -> Vec<(&'a Channel, &'a str, f64)> {
    let others: Vec<&Channel> =
        (0..of.microphones.len()).filter(|m| *m != of.reference).map(|m| &of.microphones[m]).collect();
    let all: Vec<f64> = Scatter::of_point(of).iter().map(|s| s.of_own).collect();
    if all.len() < 3 {
        return Vec::new();
    }
    let mut sorted = all.clone();
    sorted.sort_by(f64::total_cmp);
    let (least, most, median) = (sorted[0], sorted[sorted.len() - 1], sorted[(sorted.len() - 1) / 2]);
    if least > SAID && most < ALIKE * least {
        return vec![(&of.microphones[of.reference], of.point, median)];
    }
    let odd = |(m, r): (&&'a Channel, &f64)| (*r > SAID && *r > ODD * median).then_some((*m, of.point, *r));
    others.iter().zip(&all).filter_map(odd).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repeats::combine;
    use rijke_numerics::Matrix;

    /// Three repeats of four microphones, of which one has a gain that grows by a share from one to the
    /// next.
    fn said(which: usize, share: f64) -> Vec<String> {
        with_noise(which, share, 1e-4)
    }

    /// The same with noise of which the fits know.
    fn with_noise(which: usize, share: f64, sd: f64) -> Vec<String> {
        let values: Vec<(f64, Vec<f64>, Matrix)> = (0..3)
            .map(|n| {
                let gain = |m: usize| 1.0 + if m == which { share * n as f64 } else { 0.0 };
                let noise = |m: usize| sd * ((7 * n + 3 * m) as f64).sin();
                let pressure = |m: usize| [(0.4 + 0.2 * m as f64) * gain(m) / gain(0) + noise(m), 0.01];
                let all: Vec<f64> = [-9.0, 1070.0].into_iter().chain((1..5).flat_map(pressure)).collect();
                (n as f64, all, Matrix::diagonal(&[sd * sd; 10]))
            })
            .collect();
        let repeats = combine(&values, &|k| k.to_string()).unwrap();
        let microphones =
            [0, 1, 2, 4, 5].map(|number| Channel::Microphone { number, name: format!("m{number}").into() });
        let microphones = microphones.to_vec();
        let of = OfPoint { point: "a", repeats: &repeats, microphones, reference: 0, pings: &[], names: &[] };
        gains_in_words(&wandering(&[&of]))
    }

    #[test]
    fn message_the_microphone_whose_gain_changes_is_named() {
        assert!(said(3, 0.0).is_empty() && said(3, 1e-3).is_empty());
        let odd = said(3, 0.05);
        assert!(odd.len() == 1 && odd[0].starts_with("the gain of microphone 4 (m4) changes"), "{odd:?}");
        assert!(odd[0].contains("`dead = [4]`"));
        // One channel of noisy ones is always the one that scatters most.
        for (which, share) in [(3, 0.0), (3, 0.01), (1, 0.015)] {
            assert!(with_noise(which, share, 0.015).is_empty(), "{which} {share}");
        }
        let reference = said(0, 0.05);
        assert!(
            reference.len() == 1 && reference[0].starts_with("the gain of microphone 0 (m0) changes"),
            "{reference:?}"
        );
    }
}
