//! Measured functions of frequency: a rational function of lowest order near a table of gain and phase, kept
//! as partial fractions. The AAA algorithm (Nakatsukasa, Sete & Trefethen 2018) finds poles, least squares
//! better ones and the residues.

use super::aaa::fractions;
use super::relocate::{Samples, relocate, residues, spread, upper};
use super::rows::{COARSE, Doubt, TableRow, doubt, phase_slope};
use super::table_error::TableError;
use crate::words::to_digits;
use crate::{C64, Jet, JetSpace};
use std::f64::consts::PI;

/// A tolerance of a measurement is two to three times the root mean square of its errors.
const OF_NOISE: f64 = 0.5;
/// Pairs of poles over which the noise about a fit must fall, and to what part of it; else it is the noise of
/// the rows.
const ALIKE: (usize, f64) = (6, 0.8);
/// By how many of its errors the root mean square may be larger by chance.
const LEEWAY: f64 = 3.0;
/// The chance that one of all rows is further off by noise than a fit may be.
const OUTLYING: f64 = 1e-3;

/// e^{-s delay} (constant + sum of residue/(s - pole)), fitted to values on the imaginary axis; real for real
/// s.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Delay taken out before the fit, s.
    pub delay: f64,
    /// Value at infinity, without the delay.
    pub constant: f64,
    /// Poles and residues; with every pole its conjugate.
    pub terms: Vec<(C64, C64)>,
    /// Largest deviation from the table over its largest value.
    pub deviation: f64,
    /// Root mean square of an error of a row over the largest value, from the deviations of the rows and the
    /// numbers that were fitted to them.
    pub noise: f64,
    /// Limits of the table, rad/s: outside, the fit extrapolates.
    pub range: [f64; 2],
}

/// Largest value of a table, and the tolerance, of it, to which a fit is to meet the rows.
struct Goal {
    scale: f64,
    tolerance: f64,
}

/// The values of the rows, earlier by `delay` (s), and the largest modulus.
fn earlier(rows: &[TableRow], omega: &[f64], delay: f64) -> (Vec<C64>, f64) {
    let value = |(e, w): (&TableRow, &f64)| C64::from_polar(e.gain, e.phase + w * delay);
    let values: Vec<C64> = rows.iter().zip(omega).map(value).collect();
    let scale = values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    (values, scale)
}

/// A fit, and by how much it misses the rows: 1 and less meets them.
struct Held {
    fit: Table,
    misses: f64,
}

impl Table {
    /// The function of lowest order of [`Table::fit`].
    ///
    /// # Errors
    /// [`TableError`].
    pub(super) fn lowest(rows: &[TableRow], tolerance: f64) -> Result<Self, TableError> {
        if !(tolerance > 0.0 && tolerance <= COARSE) {
            return Err(TableError::Tolerance { value: tolerance });
        }
        if rows.len() < 3 {
            return Err(TableError::Short { rows: rows.len() });
        }
        let mut last = 0.0;
        for (index, e) in rows.iter().enumerate() {
            let what = match e {
                e if ![e.frequency, e.gain, e.phase].iter().all(|v| v.is_finite()) => {
                    "a number is not finite"
                }
                e if e.frequency <= 0.0 => "its frequency is not above zero; leave the row out",
                e if e.frequency <= last => {
                    "its frequency is not above that of the row before; sort the rows, one for each frequency"
                }
                e if e.gain < 0.0 => {
                    "its gain is negative; if it is a level, write `gain [dB]` in the heading, and if gain and phase were exchanged, correct the heading"
                }
                _ => {
                    last = e.frequency;
                    continue;
                }
            };
            return Err(TableError::Row { row: index + 1, what });
        }
        let first = C64::from_polar(rows[0].gain, rows[0].phase);
        let same = |e: &TableRow| (C64::from_polar(e.gain, e.phase) - first).norm() <= 1e-9 * first.norm();
        if first.im.abs() > tolerance * first.norm() && rows.iter().all(same) {
            return Err(TableError::OneNumber { phase: first.arg() });
        }
        let omega: Vec<f64> = rows.iter().map(|e| 2.0 * PI * e.frequency).collect();
        let delay = -phase_slope(rows).min(0.0);
        // Of degrees no other fault says anything.
        let in_degrees = |error: TableError| match doubt(rows) {
            Some(Doubt::Degrees { step }) => TableError::Degrees { step },
            _ => error,
        };
        let plain = Self::with_delay(rows, &omega, 0.0, tolerance);
        if delay == 0.0 {
            return plain.map_err(in_degrees);
        }
        match (plain, Self::with_delay(rows, &omega, delay, tolerance)) {
            (Ok(plain), Ok(delayed)) => {
                Ok(if plain.terms.len() <= delayed.terms.len() { plain } else { delayed })
            }
            (Ok(fit), _) | (_, Ok(fit)) => Ok(fit),
            (_, Err(error)) => Err(in_degrees(error)),
        }
    }

    /// The same function held against the rows of a table: its deviations, and whether it meets them.
    pub(super) fn held(self, rows: &[TableRow], tolerance: f64) -> (Self, bool) {
        let omega: Vec<f64> = rows.iter().map(|e| 2.0 * PI * e.frequency).collect();
        let (values, scale) = earlier(rows, &omega, self.delay);
        let samples = Samples { omega: &omega, values: &values, sds: &[] };
        let held = self.held_against(&samples, &Goal { scale, tolerance });
        (held.fit, held.misses <= 1.0)
    }

    fn with_delay(rows: &[TableRow], omega: &[f64], delay: f64, tolerance: f64) -> Result<Self, TableError> {
        let (values, scale) = earlier(rows, omega, delay);
        let range = [omega[0], omega[omega.len() - 1]];
        if scale == 0.0 {
            return Ok(Self {
                delay: 0.0,
                constant: 0.0,
                terms: Vec::new(),
                deviation: 0.0,
                noise: 0.0,
                range,
            });
        }
        let samples = Samples { omega, values: &values, sds: &[] };
        let goal = Goal { scale, tolerance };
        let mean = values.iter().sum::<C64>().re / values.len() as f64;
        let (unknown, none) = (f64::INFINITY, Vec::new());
        let fit = Self { delay, constant: mean, terms: none, deviation: unknown, noise: unknown, range };
        let mut fit = fit.held_against(&samples, &goal);
        let mut supports: Vec<usize> = Vec::new();
        // A pair of conjugate supports at a time; no more unknowns than equations.
        let most = (rows.len() - 1) / 2;
        let mut reached = fit.fit.deviation;
        // The least noise about a fit so far, for every number of pairs.
        let mut noises = vec![fit.fit.noise];
        while fit.misses > 1.0 {
            let noise = noises[supports.len()];
            let before = supports.len().checked_sub(ALIKE.0).map(|k| noises[k]);
            if before.is_some_and(|before| noise > ALIKE.1 * before) {
                let remedy = to_digits(2.5 * noise, 2);
                return Err(TableError::Noisy { noise, tolerance, remedy });
            }
            if supports.len() == most {
                let (rows, order) = (rows.len(), 2 * most);
                return Err(TableError::NoFit { rows, order, tolerance, reached });
            }
            let gap = |k: usize| (fit.fit.rational(C64::new(0.0, omega[k])) - values[k]).norm();
            let free = (0..rows.len()).filter(|k| !supports.contains(k));
            let Some(worst) = free.max_by(|&a, &b| gap(a).total_cmp(&gap(b))) else { break };
            supports.push(worst);
            let found = fractions(omega, &values, &supports, range[1])?;
            let (constant, terms) = (found.constant, found.terms);
            let aaa = Self { delay, constant, terms, deviation: unknown, noise: unknown, range };
            let order = aaa.terms.len();
            let mut noise = noise;
            // One order less first, which AAA cannot have: it counts in pairs of supports.
            for poles in [spread(order - 1, range), upper(aaa.terms.iter().map(|t| t.0))] {
                let better = aaa.with_poles(&samples, poles, &goal);
                noise = noise.min(better.fit.noise);
                if better.misses < fit.misses {
                    fit = better;
                }
                if fit.misses <= 1.0 {
                    break;
                }
            }
            if fit.misses > 1.0 {
                let shorter = fit.fit.terms.len() + 1 < order;
                let aaa = aaa.held_against(&samples, &goal);
                if aaa.misses < fit.misses || shorter {
                    fit = aaa;
                }
            }
            noises.push(noise);
            reached = reached.min(fit.fit.deviation);
        }
        fit.fit.settled(&samples, &goal)
    }

    /// With its deviations, and how far they are from what the goal allows.
    fn held_against(self, samples: &Samples<'_>, goal: &Goal) -> Held {
        let gap = |(w, v): (&f64, &C64)| (self.rational(C64::new(0.0, *w)) - v).norm() / goal.scale;
        let gaps = || samples.omega.iter().zip(samples.values).map(gap);
        // NaN counts as infinite.
        let worst = gaps().fold(0.0, |worst, gap| if gap.is_nan() { f64::INFINITY } else { gap.max(worst) });
        let rows = samples.omega.len() as f64;
        let square = gaps().map(|g| g * g).sum::<f64>();
        // Of a pair two numbers for the pole and two for the residue.
        let fitted = 1.0 + 2.0 * self.terms.len() as f64;
        let free = (2.0 * rows - fitted).max(1.0);
        let noise = (2.0 * square / free).sqrt();
        let noise = if noise.is_nan() { f64::INFINITY } else { noise };
        // Of Gaussian errors the estimate of their root mean square has the relative error 1/sqrt(2 free).
        let sigma = OF_NOISE * goal.tolerance * (1.0 + LEEWAY / (2.0 * free).sqrt());
        let furthest = sigma * (rows / OUTLYING).ln().sqrt();
        let misses = (worst / goal.tolerance).min((noise / sigma).max(worst / furthest));
        Held { fit: Self { deviation: worst, noise, ..self }, misses }
    }

    /// The best fit that least squares reach from these poles, in a few steps.
    fn with_poles(&self, samples: &Samples<'_>, poles: Vec<C64>, goal: &Goal) -> Held {
        const STEPS: usize = 8;
        let mut best = Held { fit: self.clone(), misses: f64::INFINITY };
        let mut poles = poles;
        for _ in 0..STEPS {
            if let Some(found) = residues(samples, &poles) {
                let fit = Self { constant: found.constant, terms: found.terms, ..self.clone() };
                let fit = fit.held_against(samples, goal);
                if fit.misses < best.misses {
                    best = fit;
                }
            }
            match relocate(samples, &poles) {
                Ok(next) if !next.is_empty() => poles = next,
                _ => break,
            }
        }
        best
    }

    /// Without the poles that the data do not ask for, and with none that grows: a growing pole that the
    /// noise made is mirrored, if the table stays met.
    fn settled(self, samples: &Samples<'_>, goal: &Goal) -> Result<Self, TableError> {
        let mut fit = self;
        let again = |fit: &Self, poles: &[C64]| {
            let found = residues(samples, poles)?;
            let next = Self { constant: found.constant, terms: found.terms, ..fit.clone() };
            let next = next.held_against(samples, goal);
            (next.misses <= 1.0).then_some(next.fit)
        };
        // The pole that shows least at the frequencies of the table, as long as one can go.
        loop {
            let poles = upper(fit.terms.iter().map(|t| t.0));
            let shows = |pole: &C64| {
                let residue =
                    fit.terms.iter().find(|t| (t.0 - pole).norm() <= 1e-9 * pole.norm()).map(|t| t.1.norm());
                let nearest = samples
                    .omega
                    .iter()
                    .map(|w| (C64::new(0.0, *w) - pole).norm())
                    .fold(f64::INFINITY, f64::min);
                residue.unwrap_or(0.0) / nearest
            };
            let least = (0..poles.len()).min_by(|&a, &b| shows(&poles[a]).total_cmp(&shows(&poles[b])));
            let shorter = least.filter(|_| poles.len() > 1).and_then(|k| {
                let rest: Vec<C64> =
                    poles.iter().enumerate().filter(|(i, _)| *i != k).map(|p| *p.1).collect();
                again(&fit, &rest)
            });
            match shorter {
                Some(next) => fit = next,
                None => break,
            }
        }
        let Some(&(at, _)) = fit.terms.iter().find(|(pole, _)| fit.is_near(*pole)) else { return Ok(fit) };
        let mirrored = upper(fit.terms.iter().map(|t| t.0))
            .into_iter()
            .map(|p| if fit.is_near(p) { C64::new(-p.re, p.im) } else { p })
            .collect::<Vec<_>>();
        again(&fit, &mirrored).ok_or(TableError::Unstable { at })
    }

    /// The same, later by `delay` (s).
    #[must_use]
    pub fn later(self, delay: f64) -> Self {
        Self { delay: self.delay + delay, ..self }
    }

    /// The fit at s.
    pub(super) fn value(&self, s: C64) -> C64 {
        self.rational(s) * (-s * self.delay).exp()
    }

    /// Growing poles far beyond the table are harmless: no search comes near them.
    fn is_near(&self, pole: C64) -> bool {
        pole.re > 0.0 && pole.re < self.range[1] && pole.im.abs() < 1.5 * self.range[1]
    }

    /// Whether a pole at frequencies of the table grows.
    pub(super) fn grows(&self) -> bool {
        self.terms.iter().any(|(pole, _)| self.is_near(*pole))
    }

    /// Without the delay.
    pub(super) fn rational(&self, s: C64) -> C64 {
        self.terms.iter().map(|(pole, residue)| residue / (s - pole)).sum::<C64>() + self.constant
    }

    /// The fit at s, given as a jet.
    #[must_use]
    pub fn at(&self, s: &Jet, space: JetSpace) -> Jet {
        let mut sum = space.real(self.constant);
        for (pole, residue) in &self.terms {
            sum = &sum + &s.shift(-pole).recip().scale(*residue);
        }
        &sum * &s.scale(C64::new(-self.delay, 0.0)).exp()
    }
}
