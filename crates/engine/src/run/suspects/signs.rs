//! Whether the column of growth rates holds another number of the decay, or pressures have the other
//! convention of time: by training again with the data turned.

use super::super::course::{Chosen, Run, StandsOn, Trusted};
use super::miswired::LEADS;
use super::shapes::rms;
use crate::noise::measured_sd;
use crate::rows::Row;
use crate::{EngineError, Observed};
use rijke_numerics::{C64, Matrix};
use rijke_study::plan::Stage;
use std::f64::consts::{LN_10, PI, TAU};
use std::sync::Arc;

/// A misfit of growth rates, in measured standard deviations, that asks for the question.
const LARGE: f64 = 3.0;

/// Part of the size of growth rates by which a model misses them that does not describe them.
const MISSED: f64 = 0.25;

/// Imaginary parts of pressures, over their moduli, that say nothing of a sign.
const STANDING: f64 = 1e-3;

impl Run {
    /// What a model gains with the data turned, each in a sentence: where it misses the growth rates by far,
    /// if they are another number of the decay; where its imaginary parts of the pressures are nearer to
    /// those with the other sign, or it explains nothing of the growth rates, if they are complex conjugates.
    /// Nothing of what gains less than [`LEADS`].
    ///
    /// # Errors
    /// [`EngineError::Stopped`].
    pub(in crate::run) fn turned(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
    ) -> Result<Vec<String>, EngineError> {
        let rates: Vec<f64> = found.observed.iter().filter_map(|o| o.mode.growth_rate).collect();
        let mut said = Vec::new();
        if rates.len() > 1
            && found.misfit[0] > LARGE * measured_sd(&found.observed, 0)
            && let Some((reading, gain)) = self.read_otherwise(stage, row, found)?
        {
            said.push(reading.said(gain));
        }
        // A flexible model takes up phases of the wrong sign, at the cost of the growth rates.
        let pressures = found.observed.iter().flat_map(|o| &o.mode.pressures);
        let standing = pressures.clone().all(|(_, p)| p.im.abs() < STANDING * p.norm());
        let least = spread(&rates).max(LARGE * measured_sd(&found.observed, 0));
        let explains_none = rates.len() > 2 && found.misfit[0] > least;
        if (self.nearer_conjugated(stage, found) || explains_none && !standing)
            && let Some(gain) = self.gain(stage, row, found, &|o| {
                o.mode.pressures.iter_mut().for_each(|(_, p)| *p = p.conj());
                let n = o.mode.covariance.rows();
                let first = n - 2 * o.mode.pressures.len();
                let sign = |k: usize| if k >= first && (k - first) % 2 == 1 { -1.0 } else { 1.0 };
                scale(&mut o.mode.covariance, sign);
            })?
            && gain > LEADS
        {
            said.push(format!(
                "with the complex conjugates of all pressures this model gains {gain:.1} nats: pressures vary as exp(i omega t) here; if they were \
                 measured by exp(-i omega t), turn the signs of their imaginary parts or arguments"
            ));
        }
        Ok(said)
    }

    /// The reading of the column of growth rates with which the model gains most, and its gain, nats.
    fn read_otherwise(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
    ) -> Result<Option<(&'static Reading, f64)>, EngineError> {
        let mut best: Option<(&Reading, f64)> = None;
        let rates: Vec<f64> = found.observed.iter().filter_map(|o| o.mode.growth_rate).collect();
        for reading in READINGS.iter().filter(|r| r.may_be(&rates, found.misfit[0])) {
            let mut points = found.observed.to_vec();
            points.iter_mut().for_each(|o| reading.turn(o));
            let turned: Vec<f64> = points.iter().filter_map(|o| o.mode.growth_rate).collect();
            let Some(Again { gain, misfit }) = self.with_data(stage, row, found, points)? else { continue };
            // Not one that is wrong as well, and less so.
            if misfit[0] > MISSED * rms(turned.into_iter()) {
                continue;
            }
            // The density of the numbers in the column, not that of the growth rates made of them.
            let gain = gain + found.observed.iter().map(|o| reading.ln_slope(o)).sum::<f64>();
            if gain > best.map_or(LEADS, |(_, most)| most) {
                best = Some((reading, gain));
            }
        }
        Ok(best)
    }

    /// By how much a model gains with the data that `change` makes, nats; none where it cannot be trained.
    pub(in crate::run) fn gain(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
        change: &dyn Fn(&mut Observed),
    ) -> Result<Option<f64>, EngineError> {
        let mut points = found.observed.to_vec();
        points.iter_mut().for_each(change);
        Ok(self.with_data(stage, row, found, points)?.map(|other| other.gain))
    }

    /// The model trained again on other `points`; none where it cannot be.
    pub(in crate::run) fn with_data(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
        points: Vec<Observed>,
    ) -> Result<Option<Again>, EngineError> {
        self.go_on()?;
        let stands_on = StandsOn::one(found.known.clone(), Arc::new(points));
        let Ok(other) = self.train_row(stage, row, stands_on, Trusted::Laplace) else { return Ok(None) };
        let gain = other.trained.evidence.ln_marginal - found.trained.evidence.ln_marginal;
        Ok(Some(Again { gain, misfit: other.misfit }))
    }

    /// True if the imaginary parts that a model predicts are nearer to the measured ones with the other sign.
    fn nearer_conjugated(&self, stage: &Stage, found: &Chosen) -> bool {
        let used = found.used(&self.rig, stage);
        let (mut as_they_are, mut turned) = (0.0, 0.0);
        for ((k, row), residual) in found.rows(&used).into_iter().zip(&found.trained.linear.0.residuals) {
            if row < 2 || row % 2 == 0 {
                continue;
            }
            let imaginary = used[k].pressures[(row - 2) / 2].im;
            as_they_are += residual * residual;
            turned += (residual - 2.0 * imaginary).powi(2);
        }
        turned < as_they_are
    }
}

/// A model that was trained again on other data.
pub(in crate::run) struct Again {
    /// What it gains, nats.
    pub(in crate::run) gain: f64,
    /// Its misfit, what was measured included.
    pub(in crate::run) misfit: [f64; 3],
}

/// Another number of a decay that the column of growth rates may hold.
struct Reading {
    /// What the column holds, and what the growth rate is then.
    column: &'static str,
    growth_rate: &'static str,
    /// Its sign where all modes decay.
    sign: f64,
    /// Whether it is in proportion to the growth rate, so that it has the other sign where a mode grows.
    linear: bool,
    /// Growth rate and its derivative, from the number in the column and the angular frequency (1/s).
    read: fn(f64, f64) -> [f64; 2],
}

const READINGS: [Reading; 14] = [
    Reading {
        column: "decay rates",
        growth_rate: "minus the number",
        sign: 1.0,
        linear: true,
        read: |x, _| [-x, -1.0],
    },
    Reading {
        column: "widths at half power in Hz",
        growth_rate: "-pi times the number",
        sign: 1.0,
        linear: true,
        read: |x, _| [-PI * x, -PI],
    },
    Reading {
        column: "half of the widths at half power in Hz",
        growth_rate: "-2 pi times the number",
        sign: 1.0,
        linear: true,
        read: |x, _| [-TAU * x, -TAU],
    },
    Reading {
        column: "damping ratios",
        growth_rate: "minus the number times the angular frequency",
        sign: 1.0,
        linear: true,
        read: |x, omega| [-x * omega, -omega],
    },
    Reading {
        column: "reverberation times (60 dB) in s",
        growth_rate: "-3 ln 10 over the number",
        sign: 1.0,
        linear: false,
        read: |x, _| [-3.0 * LN_10 / x, 3.0 * LN_10 / (x * x)],
    },
    Reading {
        column: "time constants of the amplitude in s",
        growth_rate: "-1 over the number",
        sign: 1.0,
        linear: false,
        read: |x, _| [-1.0 / x, 1.0 / (x * x)],
    },
    Reading {
        column: "time constants of the amplitude in ms",
        growth_rate: "-1000 over the number",
        sign: 1.0,
        linear: false,
        read: |x, _| [-1e3 / x, 1e3 / (x * x)],
    },
    Reading {
        column: "logarithmic decrements",
        growth_rate: "minus the number times the frequency",
        sign: 1.0,
        linear: true,
        read: |x, omega| [-x * omega / TAU, -omega / TAU],
    },
    Reading {
        column: "decays of the level in dB/s",
        growth_rate: "-ln 10 / 20 times the number",
        sign: 1.0,
        linear: true,
        read: |x, _| [-LN_10 / 20.0 * x, -LN_10 / 20.0],
    },
    Reading {
        column: "changes of the level in dB/s",
        growth_rate: "ln 10 / 20 times the number",
        sign: -1.0,
        linear: true,
        read: |x, _| [LN_10 / 20.0 * x, LN_10 / 20.0],
    },
    Reading {
        column: "quality factors",
        growth_rate: "minus the angular frequency over twice the number",
        sign: 1.0,
        linear: false,
        read: |x, omega| [-0.5 * omega / x, 0.5 * omega / (x * x)],
    },
    Reading {
        column: "growth rates of the energy",
        growth_rate: "half of the number",
        sign: -1.0,
        linear: true,
        read: |x, _| [0.5 * x, 0.5],
    },
    Reading {
        column: "negative widths at half power in Hz (growth rate/pi)",
        growth_rate: "pi times the number",
        sign: -1.0,
        linear: true,
        read: |x, _| [PI * x, PI],
    },
    Reading {
        column: "growth rates over 2 pi, in Hz",
        growth_rate: "2 pi times the number",
        sign: -1.0,
        linear: true,
        read: |x, _| [TAU * x, TAU],
    },
];

impl Reading {
    /// True if all growth rates have its sign; where that is the usual one, or where some modes would decay
    /// and others grow, if also a model misses them by a fourth of their size.
    fn may_be(&self, rates: &[f64], misfit: f64) -> bool {
        let of_its_sign = rates.iter().filter(|g| self.sign * **g > 0.0).count();
        let decays = of_its_sign == rates.len();
        let mixed = self.linear && of_its_sign > 0;
        decays && self.sign > 0.0 || (decays || mixed) && misfit > MISSED * rms(rates.iter().copied())
    }

    /// Growth rate by this reading, and its derivative by the number in the column.
    fn of(&self, o: &Observed) -> Option<[f64; 2]> {
        let omega = o.mode.angular_frequency.unwrap_or(o.near.im);
        o.mode.growth_rate.map(|number| (self.read)(number, omega))
    }

    /// Logarithm of the modulus of that derivative.
    fn ln_slope(&self, o: &Observed) -> f64 {
        self.of(o).map_or(0.0, |[_, slope]| slope.abs().ln())
    }

    /// The observation as it is by this reading.
    fn turn(&self, o: &mut Observed) {
        let Some([growth_rate, slope]) = self.of(o) else { return };
        o.mode.growth_rate = Some(growth_rate);
        o.near = C64::new(growth_rate, o.near.im);
        scale(&mut o.mode.covariance, |k| if k == 0 { slope } else { 1.0 });
    }

    /// What a model gains by it, nats.
    fn said(&self, gain: f64) -> String {
        let Self { column, growth_rate, .. } = self;
        format!(
            "this model gains {gain:.1} nats if the column of growth rates holds {column}: the growth rate, which is negative where a mode decays, is then \
             {growth_rate}"
        )
    }
}

/// Standard deviation of numbers about their mean.
fn spread(all: &[f64]) -> f64 {
    let n = all.len().max(1) as f64;
    let mean = all.iter().sum::<f64>() / n;
    (all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// The covariance of numbers, each multiplied by a factor.
fn scale(covariance: &mut Matrix, factor: impl Fn(usize) -> f64) {
    let n = covariance.rows();
    *covariance = Matrix::from_fn(n, n, |i, j| factor(i) * factor(j) * covariance[(i, j)]);
}

#[cfg(test)]
mod tests {
    use super::READINGS;

    #[test]
    fn behaviour_rates_of_both_signs_may_be_turned_where_a_model_misses_them() {
        let asked = |rates: &[f64], misfit: f64| -> Vec<&str> {
            READINGS.iter().filter(|r| r.may_be(rates, misfit)).map(|r| r.column).collect()
        };
        // All positive: decay rates and the like are asked of whatever the misfit is.
        assert_eq!(asked(&[20.0, 30.0], 4.0).len(), 10);
        assert!(asked(&[-20.0, -30.0], 4.0).is_empty());
        let mixed = [20.0, -30.0, 45.0];
        assert!(asked(&mixed, 4.0).is_empty());
        let all = asked(&mixed, 100.0);
        assert!(all.contains(&"decay rates") && all.contains(&"growth rates over 2 pi, in Hz"), "{all:?}");
        assert!(!all.contains(&"quality factors") && !all.iter().any(|c| c.starts_with("reverb")), "{all:?}");
    }
}
