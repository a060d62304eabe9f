//! The rational functions that a noisy table allows: other orders and delays, each with its probability.

use super::polish::polished;
use super::relocate::{Fractions, Samples, relocate, residues, spread, upper};
use super::rows::{TableRow, phase_slope};
use super::table::Table;
use super::table_error::TableError;
use crate::{C64, Grows, Stream, TwoPart};
use rand::RngExt;
use std::f64::consts::PI;

/// Parts of the mean delay that are taken out before a fit.
const DELAYS: [f64; 6] = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
/// By how much orders are lower and higher than that of the fit that is kept.
const BESIDE: usize = 4;
/// Steps of vector fitting from poles that are spread over the band, and from those of a fit nearby.
const STEPS: [usize; 2] = [8, 4];
/// By what differences of the criterion are divided: a bias that is too small to show on the imaginary axis
/// grows off it, so that fits which are a little less likely there must count.
const TEMPER: f64 = 3.0;

/// Root mean square deviation, of the tolerance, below which rows tell fits apart no more.
const CLOSE: f64 = 0.1;

/// Most times that a noise which grows with the gain is sought.
const ROUNDS: usize = 6;

/// The fits that a table allows, with their shares of the probability.
#[derive(Clone, Debug)]
pub struct Likely {
    omega: Vec<f64>,
    /// The standard deviation of the noise of each row over that of the noise of a fit; empty if all are
    /// one.
    sds: Vec<f64>,
    fits: Vec<(Table, f64)>,
}

impl Likely {
    /// Beside `kept`, fits of orders up to 4 lower and higher with six delays, from none to the mean delay of
    /// the table, by least squares. Each weighs exp(-AICc/6), Akaike's criterion with the noise inferred,
    /// corrected for few rows; fits with growing poles at the frequencies of the table are left out.
    ///
    /// The noise is the same for all rows, or has a part in proportion to the gain of the most probable fit,
    /// where the residuals of that ask for it ([`TwoPart`]); rows then count by it in all fits.
    #[must_use]
    pub fn of(rows: &[TableRow], kept: &Table) -> Self {
        let measured = Measured::of(rows, kept);
        let (mut sds, mut fits, mut noise) = (Vec::new(), measured.fits(&[]), TwoPart::white());
        for _ in 0..ROUNDS {
            let Some((best, _)) = fits.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            let residuals = measured.residuals(best);
            let (other, gain) = TwoPart::of(Grows::AsModulus, &residuals);
            let least = if noise == TwoPart::white() {
                TwoPart::ASKED
            } else {
                noise.gain(&residuals) + TwoPart::SETTLED
            };
            if gain < least {
                break;
            }
            noise = other;
            sds = residuals.iter().map(|[gain, ..]| noise.factor(*gain).sqrt()).collect();
            fits = measured.fits(&sds);
        }
        Self { omega: measured.omega, sds, fits }
    }

    /// A function that could as well be the one that was measured: a fit by its probability, its values with
    /// Gaussian errors of its noise, and the fit of the same order and delay to them. `None` if
    /// there is none.
    #[must_use]
    pub fn draw(&self, stream: &mut Stream) -> Option<Table> {
        let mut left: f64 = stream.random();
        let by = self.fits.iter().find(|(_, weight)| {
            left -= weight;
            left <= 0.0
        });
        let (fit, _) = by.or(self.fits.last())?;
        let mut value = |(k, w): (usize, &f64)| {
            // Box and Muller: of a complex error of mean square 1.
            let [radius, turn]: [f64; 2] = [stream.random(), stream.random()];
            let sd = fit.noise * self.sds.get(k).copied().unwrap_or(1.0);
            fit.value(C64::new(0.0, *w))
                + sd * C64::from_polar((-(1.0 - radius).ln()).sqrt(), 2.0 * PI * turn)
        };
        let values: Vec<C64> = self.omega.iter().enumerate().map(&mut value).collect();
        let poles = upper(fit.terms.iter().map(|t| t.0));
        let samples = Samples { omega: &self.omega, values: &values, sds: &self.sds };
        best(&samples, fit.delay, poles, STEPS[1]).map(|found| found.0)
    }
}

impl Table {
    /// The rational function of lowest order that meets the rows to `tolerance` of the largest gain, with the
    /// mean delay (the slope of the phase, by least squares) taken out before or not, whichever takes fewer
    /// poles; or one of nearly that order which the rows make more probable by far.
    ///
    /// The rows are met if each lies within the tolerance. They are met too if their deviations are those
    /// of noise of which the tolerance is twice the root mean square or more: complex Gaussian errors e of
    /// rms sigma have P(|e| > x) = exp(-x^2/sigma^2), so that some of many rows lie beyond 2 sigma, and a
    /// pole for each of them would be one of the noise.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn fit(rows: &[TableRow], tolerance: f64) -> Result<Self, TableError> {
        Ok(most_probable(rows, Self::lowest(rows, tolerance)?, tolerance))
    }
}

/// Of the fits near `lowest` in order that meet the rows to `tolerance`, the one of the least Bayesian
/// criterion, n ln(square/n) + parameters ln n of n numbers: a pole of the noise gains less than that
/// asks for, and a bias that a wide tolerance lets pass does not.
fn most_probable(rows: &[TableRow], lowest: Table, tolerance: f64) -> Table {
    let measured = Measured::of(rows, &lowest);
    let numbers = 2.0 * rows.len() as f64;
    let scale = measured.values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let least = 0.5 * numbers * (CLOSE * tolerance * scale).powi(2);
    let criterion = |(fit, square): &(Table, f64)| {
        let criterion = numbers * (square.max(least) / numbers).ln() + parameters(fit) * numbers.ln();
        (numbers > parameters(fit) + 1.0 && criterion.is_finite()).then_some(criterion)
    };
    if measured.square(&lowest, &[]) <= least {
        return lowest;
    }
    let candidates = measured.candidates(&[]).into_iter();
    let mut rated: Vec<(f64, Table)> = candidates.filter_map(|c| Some((criterion(&c)?, c.0))).collect();
    rated.sort_by(|a, b| a.0.total_cmp(&b.0));
    let meets = |(_, fit): (f64, Table)| Some(fit.held(rows, tolerance)).filter(|(_, meets)| *meets);
    rated.into_iter().find_map(meets).map_or(lowest, |(fit, _)| fit)
}

/// A table, its mean delay, and the fit that is kept.
struct Measured<'a> {
    omega: Vec<f64>,
    values: Vec<C64>,
    delay: f64,
    kept: &'a Table,
}

impl<'a> Measured<'a> {
    fn of(rows: &[TableRow], kept: &'a Table) -> Self {
        Self {
            omega: rows.iter().map(|row| 2.0 * PI * row.frequency).collect(),
            values: rows.iter().map(|row| C64::from_polar(row.gain, row.phase)).collect(),
            delay: -phase_slope(rows).min(0.0),
            kept,
        }
    }

    /// The gain of a fit, the square of its deviation, and the share of it that the fit leaves, of every row:
    /// the same for all.
    fn residuals(&self, fit: &Table) -> Vec<[f64; 3]> {
        let left = 1.0 - parameters(fit) / (2.0 * self.omega.len() as f64);
        let at = |(w, v): (&f64, &C64)| {
            let told = fit.value(C64::new(0.0, *w));
            [told.norm(), (told - v).norm_sqr(), left.max(0.0)]
        };
        self.omega.iter().zip(&self.values).map(at).collect()
    }

    /// The sum of the squared deviations of a fit over `sds`.
    fn square(&self, fit: &Table, sds: &[f64]) -> f64 {
        let weight = |k: usize| sds.get(k).map_or(1.0, |sd| 1.0 / (sd * sd));
        self.residuals(fit).iter().enumerate().map(|(k, [_, square, _])| weight(k) * square).sum()
    }

    /// The fit that is kept, and fits of orders up to [`BESIDE`] lower and higher with six delays, by least
    /// squares, each with the sum of its squared deviations over `sds`. Those whose poles grow at frequencies
    /// of the table are left out.
    fn candidates(&self, sds: &[f64]) -> Vec<(Table, f64)> {
        let Self { ref omega, ref values, delay: mean, kept } = *self;
        let mut found = vec![(kept.clone(), self.square(kept, sds))];
        let order = kept.terms.len();
        let samples = Samples { omega, values, sds };
        for part in if mean > 0.0 { &DELAYS[..] } else { &DELAYS[..1] } {
            for order in order.saturating_sub(BESIDE)..=order + BESIDE {
                let poles = spread(order, range(omega));
                let fit = best(&samples, part * mean, poles, STEPS[0]);
                found.extend(fit.filter(|(fit, _)| !fit.grows()));
            }
        }
        found
    }

    /// The fits with their probabilities, if the noise of the rows has standard deviations in proportion to
    /// `sds`.
    fn fits(&self, sds: &[f64]) -> Vec<(Table, f64)> {
        let found = self.candidates(sds);
        let numbers = 2.0 * self.omega.len() as f64;
        let rated = found.into_iter().filter_map(|(fit, square)| {
            let parameters = parameters(&fit);
            let free = numbers - parameters - 1.0;
            let criterion = numbers * (square / numbers).ln() + 2.0 * parameters * numbers / free;
            let noise = (2.0 * square / (free + 1.0)).sqrt();
            (free > 0.0 && criterion.is_finite()).then_some((Table { noise, ..fit }, criterion))
        });
        let rated: Vec<(Table, f64)> = rated.collect();
        let least = rated.iter().map(|f| f.1).fold(f64::INFINITY, f64::min);
        let weight = |criterion: f64| (-0.5 * (criterion - least) / TEMPER).exp();
        let total: f64 = rated.iter().map(|f| weight(f.1)).sum();
        rated.into_iter().map(|(fit, c)| (fit, weight(c) / total)).collect()
    }
}

/// The numbers of a fit: of a pair two for the pole and two for the residue.
fn parameters(fit: &Table) -> f64 {
    2.0 * fit.terms.len() as f64 + 1.0 + f64::from(fit.delay > 0.0)
}

fn range(omega: &[f64]) -> [f64; 2] {
    [omega[0], omega[omega.len() - 1]]
}

/// The best fit with a delay that some steps of vector fitting from `poles` reach, and the sum of its squared
/// deviations over `sds`.
fn best(samples: &Samples<'_>, delay: f64, poles: Vec<C64>, steps: usize) -> Option<(Table, f64)> {
    let Samples { omega, sds, .. } = *samples;
    let sd = |k: usize| sds.get(k).copied().unwrap_or(1.0);
    let values: Vec<C64> =
        omega.iter().zip(samples.values).map(|(w, v)| v * C64::from_polar(1.0, w * delay)).collect();
    let samples = Samples { omega, values: &values, sds };
    let blank =
        Table { delay, constant: 0.0, terms: Vec::new(), deviation: 0.0, noise: 0.0, range: range(omega) };
    let square = |fit: &Table| -> f64 {
        let at = |(k, w): (usize, &f64)| ((fit.rational(C64::new(0.0, *w)) - values[k]) / sd(k)).norm_sqr();
        omega.iter().enumerate().map(at).sum()
    };
    if poles.is_empty() {
        let weights = || (0..values.len()).map(|k| 1.0 / (sd(k) * sd(k)));
        let sum = weights().zip(&values).map(|(w, v)| w * v.re).sum::<f64>();
        let constant = sum / weights().sum::<f64>();
        let fit = Table { constant, ..blank };
        let square = square(&fit);
        return Some((fit, square));
    }
    let mut found: Option<(Table, f64)> = None;
    let mut poles = poles;
    for _ in 0..steps {
        if let Some(fractions) = residues(&samples, &poles) {
            let fit = Table { constant: fractions.constant, terms: fractions.terms, ..blank.clone() };
            let square = square(&fit);
            if found.as_ref().is_none_or(|f| square < f.1) {
                found = Some((fit, square));
            }
        }
        match relocate(&samples, &poles) {
            Ok(next) if !next.is_empty() => poles = next,
            _ => break,
        }
    }
    let (fit, _) = found?;
    let start = Fractions { constant: fit.constant, terms: fit.terms };
    let Fractions { constant, terms } = polished(&samples, start);
    let fit = Table { constant, terms, ..blank };
    let square = square(&fit);
    Some((fit, square))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Streams;

    const SEEDS: u64 = 30;

    fn truth(s: C64) -> C64 {
        (-s * 2e-3).exp() / (1.0 + s / 600.0).powi(2)
    }

    /// The fit of rows with these errors, a floor and a share of the gain, and the fits beside it.
    fn fitted(seed: u64, [floor, share]: [f64; 2]) -> Option<(Table, Likely)> {
        let mut stream = Streams::new(seed).stream("rows");
        let mut row = |k: i32| {
            let frequency = 10.0 * f64::from(k);
            let exact = truth(C64::new(0.0, 2.0 * PI * frequency));
            let [radius, turn]: [f64; 2] = [stream.random(), stream.random()];
            let error = C64::from_polar((-2.0 * (1.0 - radius).ln()).sqrt(), 2.0 * PI * turn);
            let value = exact + floor.hypot(share * exact.norm()) * error;
            TableRow { frequency, gain: value.norm(), phase: value.arg() }
        };
        let rows: Vec<TableRow> = (2..=40).map(&mut row).collect();
        let largest = rows.iter().map(|r| r.gain).fold(0.0, f64::max);
        let mean = rows.iter().map(|r| floor * floor + (share * r.gain).powi(2)).sum::<f64>() / 39.0;
        let kept = Table::fit(&rows, 2.0 * (2.0 * mean).sqrt() / largest).ok()?;
        let likely = Likely::of(&rows, &kept);
        Some((kept, likely))
    }

    #[test]
    fn coverage_draws_scatter_as_fits_err_whatever_the_noise() {
        for (noise, asks) in [([0.01, 0.0], false), ([0.0, 0.04], true), ([0.003, 0.04], true)] {
            // Where the gain is large, and where it is small.
            let places = [60.0, 350.0].map(|hertz| C64::new(0.0, 2.0 * PI * hertz));
            let (mut sums, mut found, mut count) = ([0.0; 2], 0, 0_i32);
            for seed in 0..SEEDS {
                // Some tables are refused: their fit would have poles that grow.
                let Some((kept, likely)) = fitted(seed, noise) else { continue };
                count += 1;
                found += i32::from(!likely.sds.is_empty());
                let mut stream = Streams::new(seed).stream("draws");
                let draws: Vec<Table> = (0..40).filter_map(|_| likely.draw(&mut stream)).collect();
                for (sum, s) in sums.iter_mut().zip(places) {
                    let moved = draws.iter().map(|draw| (draw.value(s) - kept.value(s)).norm_sqr());
                    let variance = moved.sum::<f64>() / draws.len() as f64;
                    *sum += (kept.value(s) - truth(s)).norm_sqr() / variance;
                }
            }
            let rms = sums.map(|sum| (sum / f64::from(count)).sqrt());
            assert!(count >= 25, "{noise:?}: {count}");
            assert!(rms.iter().all(|r| (0.6..1.3).contains(r)), "{noise:?}: {rms:?}");
            assert!(if asks { found >= count - 3 } else { found <= 3 }, "{noise:?}: {found}");
        }
    }
}
