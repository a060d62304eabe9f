//! Models that miss what was measured by much.

use super::super::record::{MeasuredRecord, ModelRecord};
use crate::BeyondTable;

/// A misfit of so many measured errors is said if it is also so large a share of the growth rates, or of the
/// frequencies: 0.3 % is 2 K. Where a rig comes out a little different each time it is set, errors of single
/// measurements are exceeded by any model.
const FAR: f64 = 10.0;
const LARGE: [f64; 2] = [0.1, 3e-3];

/// Frequencies of which fewer lie on one side by chance too often.
const FEWEST: usize = 5;

/// Temperature of a room, K.
const ROOM: f64 = 293.15;

/// By how much a model misses growth rates (0) and angular frequencies (1): root mean square misfit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::run) struct FarOff {
    /// Over the root mean square of what was measured.
    of_size: [f64; 2],
    /// Over that of its stated errors.
    of_errors: [f64; 2],
    /// The frequencies, if all of them lie on one side of the model.
    one_side: Option<OneSide>,
}

/// Frequencies of which all lie above, or all below the model.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OneSide {
    count: usize,
    /// By how much they are higher, as a part of the model's.
    higher: f64,
}

impl OneSide {
    /// From what was measured and what the model says; none where they scatter by more than half of what they
    /// have in common, or are too few to tell.
    fn of(pairs: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let all: Vec<f64> = pairs.map(|(measured, predicted)| measured / predicted - 1.0).collect();
        let count = all.len();
        let higher = all.iter().sum::<f64>() / count as f64;
        let squares: f64 = all.iter().map(|v| (v - higher).powi(2)).sum();
        let common = all.iter().all(|v| v * higher > 0.0) && squares < 0.25 * higher * higher * count as f64;
        (count >= FEWEST && common).then_some(Self { count, higher })
    }
}

impl FarOff {
    /// Of a model that misses the measurements by many of their errors, and by much; else none.
    pub(in crate::run) fn of(measured: &[MeasuredRecord], model: &ModelRecord) -> Option<Self> {
        let growth: Vec<[f64; 2]> = measured.iter().filter_map(|m| m.growth_rate).collect();
        let frequency: Vec<[f64; 2]> = measured.iter().filter_map(|m| m.angular_frequency).collect();
        let found = Self::by([&growth, &frequency], [model.misfit[0], model.misfit[1]])?;
        let pairs = measured.iter().zip(model.shown());
        let pairs = pairs.filter_map(|(m, shown)| Some((m.angular_frequency?[0], shown[1])));
        Some(Self { one_side: OneSide::of(pairs), ..found })
    }

    /// From values with their errors, and misfits.
    fn by(numbers: [&[[f64; 2]]; 2], misfit: [f64; 2]) -> Option<Self> {
        let over = |k: usize, i: usize| {
            let squares: f64 = numbers[k].iter().map(|v| v[i] * v[i]).sum();
            let size = (squares / numbers[k].len().max(1) as f64).sqrt();
            if size > 0.0 { misfit[k].abs() / size } else { 0.0 }
        };
        let [of_size, of_errors] = [0, 1].map(|i| [0, 1].map(|k| over(k, i)));
        let found = Self { of_size, of_errors, one_side: None };
        (0..2).any(|k| found.is_far(k)).then_some(found)
    }

    fn is_far(&self, k: usize) -> bool {
        self.of_errors[k] > FAR && self.of_size[k] > LARGE[k]
    }

    /// A sentence without its stop.
    pub(in crate::run) fn words(&self) -> String {
        let missed = |k: usize| {
            let (what, digits) = [("growth rates", 0), ("frequencies", 1)][k];
            let (size, errors) = (100.0 * self.of_size[k], self.of_errors[k]);
            self.is_far(k)
                .then(|| format!("{what} by {size:.digits$} % (rms), {errors:.0} times their stated errors"))
        };
        let all: Vec<String> = (0..2).filter_map(missed).collect();
        let all = all.join(", ");
        match self.one_side.filter(|_| self.is_far(1)) {
            Some(OneSide { count, higher }) => format!(
                "the model misses {all}; all {count} frequencies lie {} it, by {:.1} % on average: an error that all points share would do that, of the sampling rate, of a \
                 length, or of T_amb (by {:.1} K at room temperature); check these, then priors and the model",
                if higher > 0.0 { "above" } else { "below" },
                100.0 * higher.abs(),
                ROOM * ((1.0 + higher).powi(2) - 1.0).abs()
            ),
            None => format!(
                "the model misses {all}: check the sampling rate, the order of points, lengths and temperatures, then priors and the model"
            ),
        }
    }
}

/// Modes that rest on the extrapolation of a measured table.
pub(in crate::run) fn beyond_tables<'a>(
    mut all: impl Iterator<Item = (&'a str, BeyondTable)>,
) -> Option<String> {
    let (point, table) = all.next()?;
    let count = 1 + all.count();
    let modes =
        if count == 1 { "one measured mode lies".into() } else { format!("{count} measured modes lie") };
    Some(format!("{modes} beyond a table, where its fit extrapolates; at {point}: {table}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_misfit_counts_if_it_is_many_errors_and_much() {
        let growth = [[-3.0, 0.1], [4.0, 0.1]];
        let frequency = [[1000.0, 0.5], [1000.0, 0.5]];
        let of = |misfit: [f64; 2]| FarOff::by([&growth, &frequency], misfit);
        // 0.2 1/s is two errors; 2 1/s are twenty, and more than half of 12.5^(1/2).
        assert_eq!(of([0.2, 0.0]), None);
        let far = of([2.0, 0.0]).unwrap();
        assert!(
            (far.of_errors[0] - 20.0).abs() < 1e-9 && (far.of_size[0] - 2.0 / 12.5_f64.sqrt()).abs() < 1e-12
        );
        // 2.9 rad/s of 1000 are small, though six errors; 6 rad/s are twelve errors and 0.6 %.
        assert_eq!(of([0.0, 2.9]), None);
        let words = of([0.0, 6.0]).unwrap().words();
        let only = "the model misses frequencies by 0.6 % (rms), 12 times their stated errors: check";
        assert!(words.starts_with(only), "{words}");
        assert_eq!(FarOff::by([&[], &[]], [9.0, 9.0]), None);
    }

    /// A thermometer that reads 3 K too little: 0.51 % of every frequency.
    #[test]
    fn message_an_error_that_all_frequencies_share_is_named() {
        let frequency = [[1000.0, 0.5]; 6];
        let far = FarOff::by([&[], &frequency], [0.0, 6.0]).unwrap();
        let higher = (296.15_f64 / 293.15).sqrt();
        let modes = [1000.0, 1004.0, 1500.0, 2000.0, 900.0, 950.0];
        let pair = |k: usize| (modes[k] * higher * (1.0 + 1e-4 * k as f64), modes[k]);
        let words = FarOff { one_side: OneSide::of((0..6).map(pair)), ..far }.words();
        assert!(words.contains("all 6 frequencies lie above it, by 0.5 % on average"), "{words}");
        assert!(words.contains("T_amb (by 3.1 K at room temperature)"), "{words}");
        // One of the other sign, or too few, have nothing in common.
        assert_eq!(OneSide::of((0..6).map(pair).chain([(999.0, 1000.0)])), None);
        assert_eq!(OneSide::of((0..4).map(pair)), None);
    }
}
