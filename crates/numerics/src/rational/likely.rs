//! The rational functions that a noisy table allows: other orders and delays, each with its probability.

use super::relocate::{Samples, relocate, residues, spread, upper};
use super::rows::{TableRow, phase_slope};
use super::table::Table;
use crate::{C64, Stream};
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

/// The fits that a table allows, with their shares of the probability.
#[derive(Clone, Debug)]
pub struct Likely {
    omega: Vec<f64>,
    fits: Vec<(Table, f64)>,
}

impl Likely {
    /// Beside `kept`, fits of orders up to 4 lower and higher with six delays, from none to the mean delay of
    /// the table, by least squares. Each weighs exp(-AICc/6), Akaike's criterion with the noise inferred,
    /// corrected for few rows; fits with growing poles at the frequencies of the table are left out.
    #[must_use]
    pub fn of(rows: &[TableRow], kept: &Table) -> Self {
        let omega: Vec<f64> = rows.iter().map(|row| 2.0 * PI * row.frequency).collect();
        let values: Vec<C64> = rows.iter().map(|row| C64::from_polar(row.gain, row.phase)).collect();
        let mean = -phase_slope(rows).min(0.0);
        let gap = |(w, v): (&f64, &C64)| (kept.value(C64::new(0.0, *w)) - v).norm_sqr();
        let mut found = vec![(kept.clone(), omega.iter().zip(&values).map(gap).sum())];
        let order = kept.terms.len();
        for part in if mean > 0.0 { &DELAYS[..] } else { &DELAYS[..1] } {
            for order in order.saturating_sub(BESIDE)..=order + BESIDE {
                let poles = spread(order, range(&omega));
                let fit = best(&omega, &values, part * mean, poles, STEPS[0]);
                found.extend(fit.filter(|(fit, _)| !fit.grows()));
            }
        }
        let numbers = 2.0 * rows.len() as f64;
        let rated = found.into_iter().filter_map(|(fit, square)| {
            let parameters = 2.0 * fit.terms.len() as f64 + 1.0 + f64::from(fit.delay > 0.0);
            let free = numbers - parameters - 1.0;
            let criterion = numbers * (square / numbers).ln() + 2.0 * parameters * numbers / free;
            let noise = (2.0 * square / (free + 1.0)).sqrt();
            (free > 0.0 && criterion.is_finite()).then_some((Table { noise, ..fit }, criterion))
        });
        let rated: Vec<(Table, f64)> = rated.collect();
        let least = rated.iter().map(|f| f.1).fold(f64::INFINITY, f64::min);
        let weight = |criterion: f64| (-0.5 * (criterion - least) / TEMPER).exp();
        let total: f64 = rated.iter().map(|f| weight(f.1)).sum();
        let fits = rated.into_iter().map(|(fit, c)| (fit, weight(c) / total)).collect();
        Self { omega, fits }
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
        let mut value = |w: &f64| {
            // Box and Muller: of a complex error of mean square 1.
            let [radius, turn]: [f64; 2] = [stream.random(), stream.random()];
            fit.value(C64::new(0.0, *w))
                + fit.noise * C64::from_polar((-(1.0 - radius).ln()).sqrt(), 2.0 * PI * turn)
        };
        let values: Vec<C64> = self.omega.iter().map(&mut value).collect();
        let poles = upper(fit.terms.iter().map(|t| t.0));
        best(&self.omega, &values, fit.delay, poles, STEPS[1]).map(|found| found.0)
    }
}

fn range(omega: &[f64]) -> [f64; 2] {
    [omega[0], omega[omega.len() - 1]]
}

/// The best fit that some steps of vector fitting from `poles` reach, and the sum of its squared deviations.
fn best(omega: &[f64], values: &[C64], delay: f64, poles: Vec<C64>, steps: usize) -> Option<(Table, f64)> {
    let values: Vec<C64> =
        omega.iter().zip(values).map(|(w, v)| v * C64::from_polar(1.0, w * delay)).collect();
    let samples = Samples { omega, values: &values };
    let blank =
        Table { delay, constant: 0.0, terms: Vec::new(), deviation: 0.0, noise: 0.0, range: range(omega) };
    let square = |fit: &Table| -> f64 {
        omega.iter().zip(&values).map(|(w, v)| (fit.rational(C64::new(0.0, *w)) - v).norm_sqr()).sum()
    };
    if poles.is_empty() {
        let constant = values.iter().sum::<C64>().re / values.len() as f64;
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
    found
}
