//! Errors of a measuring head: y = R + sum of b(f) R^power, where R is what the rig does, not what was
//! measured.
//!
//! The covariance that integrating over b leaves depends on R. It is taken at the R of the last fit, R0,
//! about the most probable errors b0:
//!
//! y = R + sum of b0 (R^power - R0^power) + sum of b R0^power + noise.
//!
//! The sum with b0 belongs to the prediction, the one with b to the covariance. What is left out of y, (b -
//! b0)(R^power - R0^power), is of second order, and nothing where R = R0. The volume that the errors leave to
//! b, 1/2 ln det of the covariance, also depends on R: to first order it is a datum of its own, the tilt. The
//! fit is repeated until R0 stays.

use super::measured::{Measured, sessions};
use super::sources::{Field, fields};
use super::{LENGTH_OF_MISFIT, MISFIT, NOISE};
use crate::EngineError;
use rijke_inference::{Kernel, NoiseEstimate, Observation, complex_columns};
use rijke_numerics::{C64, Cholesky, Jet, Matrix, range, special};
use rijke_study::ErrorTerm;
use rijke_study::plan::SdSpec;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::Range;

/// The errors of a head about one answer of the rig.
#[derive(Clone, Debug)]
pub(super) struct HeardResponses {
    /// R0 of every load.
    pub(super) about: Vec<Vec<C64>>,
    /// Power of every error term, and b0 of every load.
    pub(super) terms: Vec<(i32, Vec<Vec<C64>>)>,
    /// What is known of unknown sources, by the first load of their excitation and by frequency.
    fields: BTreeMap<usize, Vec<Field>>,
    /// Slopes of 1/2 ln det of the covariance in R at every frequency of every load: it changes by the sum of
    /// Re(slope* dR).
    tilt: Vec<Vec<C64>>,
}

/// The datum of the tilt: its cost, with a standard deviation of one, is this squared over two, plus the
/// tilt, plus the tilt squared over twice this squared, which is nothing.
const LEVER: f64 = 1e3;

/// The covariance of what is not the head's, by groups of noise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest<'a> {
    pub(super) noise: &'a [NoiseEstimate],
    pub(super) kernel: Option<Kernel>,
}

impl HeardResponses {
    /// Before any fit: about the numbers that were measured, with no error known, and about the `answers` of
    /// the rig where sources are unknown.
    pub(super) fn about_data(
        measured: &[Measured],
        errors: &[ErrorTerm],
        answers: Vec<Vec<C64>>,
    ) -> Result<Self, EngineError> {
        let none = || measured.iter().map(|m| vec![C64::ZERO; m.values.len()]).collect();
        let of_sources = sessions(measured).into_iter().filter(|range| measured[range.start].sources > 0);
        let of_sources = of_sources.map(|range| Ok((range.start, fields(measured, range, &answers)?)));
        Ok(Self {
            fields: of_sources.collect::<Result<_, EngineError>>()?,
            about: measured
                .iter()
                .zip(answers)
                .map(|(m, answer)| if m.sources > 0 { answer } else { m.values.clone() })
                .collect(),
            terms: errors.iter().map(|term| (term.power, none())).collect(),
            tilt: none(),
        })
    }

    /// About the `answers` of the rig, with the errors that are most probable there.
    pub(super) fn about_answers(
        measured: &[Measured],
        errors: &[ErrorTerm],
        answers: Vec<Vec<C64>>,
        rest: Rest<'_>,
    ) -> Result<Self, EngineError> {
        let mut heard = Self { about: answers.clone(), ..Self::about_data(measured, errors, answers)? };
        if errors.is_empty() {
            return Ok(heard);
        }
        for loads in sessions(measured).into_iter().filter(|range| measured[range.start].sources == 0) {
            let (about, loads_of) = (&heard.about[loads.clone()], &measured[loads.clone()]);
            let (found, slopes) = most_probable(loads_of, about, errors, rest)?;
            let mut slopes = slopes.into_iter();
            for slope in heard.tilt[loads.clone()].iter_mut().flatten() {
                *slope = slopes.next().unwrap_or_default();
            }
            let basis = polynomials(loads_of, errors.iter().map(|t| t.functions).max().unwrap_or(0));
            let mut first = 0;
            for (term, (_, b)) in errors.iter().zip(&mut heard.terms) {
                let own = &found[first..first + term.functions];
                first += term.functions;
                let share = (1.0 / term.functions.max(1) as f64).sqrt();
                let mut rows = basis.iter();
                for value in b[loads.clone()].iter_mut().flatten() {
                    if let Some(row) = rows.next() {
                        *value = own.iter().zip(row).map(|(c, p)| c * (p * share)).sum();
                    }
                }
            }
        }
        Ok(heard)
    }

    /// Whether the likelihood is the one that a fit finds, wherever it was taken.
    pub(super) fn is_exact(&self) -> bool {
        self.terms.is_empty() && self.fields.is_empty()
    }

    /// Whether sources are unknown.
    pub(super) fn has_fields(&self) -> bool {
        !self.fields.is_empty()
    }

    /// What the data of the loads of a session are told to be, in their order.
    pub(super) fn told(&self, measured: &[Measured], range: Range<usize>, answers: &[Vec<Jet>]) -> Vec<Jet> {
        let Some(fields) = self.fields.get(&range.start) else {
            let of_load = |load: usize| {
                answers[load].iter().enumerate().map(move |(k, answer)| self.shifted(load, k, answer.clone()))
            };
            return range.flat_map(of_load).collect();
        };
        let count = answers[range.start].len() / measured[range.start].values.len().max(1);
        let first = range.start;
        let at = |(k, field): (usize, &Field)| field.told(&|m, j| &answers[first + m][k * count + j]);
        fields.iter().enumerate().flat_map(at).collect()
    }

    /// The data of the loads of an excitation.
    pub(super) fn pressures(&self, measured: &[Measured], range: Range<usize>) -> Vec<Observation> {
        let at = |(k, field): (usize, &Field)| {
            let heard: Vec<C64> = range.clone().map(|load| measured[load].values[k]).collect();
            let sds: Vec<f64> = range.clone().filter_map(|load| measured[load].sd.get(k).copied()).collect();
            let first = &measured[range.start];
            field.observation(
                format!("{} at {} Hz", first.label, first.frequency_hz[k]),
                &heard,
                &sds,
                first.factor(k),
            )
        };
        self.fields.get(&range.start).into_iter().flatten().enumerate().map(at).collect()
    }

    /// What the head adds to the answer of load `load` at its frequency `k`, as far as it is known: the sum
    /// of b0 (R^power - R0^power).
    fn shifted(&self, load: usize, k: usize, answer: Jet) -> Jet {
        let about = self.about[load][k];
        let mut sum = answer.clone();
        for (power, b) in self.terms.iter().filter(|(power, _)| *power != 0) {
            let moved = answer.powi(*power).shift(-about.powi(*power));
            sum = &sum + &moved.scale(b[load][k]);
        }
        sum
    }

    /// What the tilt predicts for its datum; nothing without errors.
    pub(super) fn tilted(&self, answers: &[Vec<Jet>]) -> Option<Jet> {
        let all = answers.iter().zip(&self.about).zip(&self.tilt);
        let all = all.flat_map(|((a, r), t)| a.iter().zip(r).zip(t));
        let one = |((answer, about), slope): ((&Jet, &C64), &C64)| {
            answer.shift(-about).scale(slope.conj() / LEVER).re()
        };
        (!self.terms.is_empty()).then(|| all.map(one).reduce(|a, b| &a + &b)).flatten()
    }

    /// The datum of the tilt.
    pub(super) fn tilt_datum(&self) -> Option<Observation> {
        let datum = || {
            Observation::new("volume of the errors of the head", vec![-LEVER]).with_floor(Matrix::identity(1))
        };
        (!self.terms.is_empty()).then(datum)
    }

    /// What the datum of the tilt takes from ln of the likelihood where R = R0.
    pub(super) fn tilt_cost(&self) -> f64 {
        if self.terms.is_empty() { 0.0 } else { 0.5 * (LEVER * LEVER + (2.0 * PI).ln()) }
    }

    /// R0 of every load; with unknown sources their most probable pressures.
    pub(super) fn answered(&self) -> Vec<Vec<C64>> {
        let mut all = self.about.clone();
        for (first, fields) in &self.fields {
            let heard: Vec<Vec<C64>> = fields.iter().map(Field::heard).collect();
            for m in 0..heard.first().map_or(0, Vec::len) {
                all[first + m] = heard.iter().map(|h| h[m]).collect();
            }
        }
        all
    }

    /// R0 with the errors: what the head hears.
    pub(super) fn heard(&self) -> Vec<Vec<C64>> {
        let about = self.answered();
        let one = |load: usize| {
            let at = |(k, r): (usize, &C64)| {
                r + self.terms.iter().map(|(power, b)| b[load][k] * r.powi(*power)).sum::<C64>()
            };
            about[load].iter().enumerate().map(at).collect()
        };
        (0..about.len()).map(one).collect()
    }
}

/// For every error term its columns at the answers `about` of the loads of a session, of unit root mean
/// square over the band.
pub(super) fn columns(loads: &[Measured], about: &[Vec<C64>], errors: &[ErrorTerm]) -> Vec<Matrix> {
    let column = |term: &ErrorTerm| complex_columns(&complex(loads, about, term));
    errors.iter().map(column).collect()
}

/// The same as complex numbers, a list for every polynomial.
fn complex(loads: &[Measured], about: &[Vec<C64>], term: &ErrorTerm) -> Vec<Vec<C64>> {
    let share = (1.0 / term.functions.max(1) as f64).sqrt();
    let basis = polynomials(loads, term.functions);
    let mut columns = vec![Vec::new(); term.functions];
    for (row, r) in basis.iter().zip(about.iter().flatten()) {
        let factor = r.powi(term.power) * share;
        for (column, p) in columns.iter_mut().zip(row) {
            column.push(factor * p);
        }
    }
    columns
}

/// The first `count` polynomials at every frequency of the loads of a session.
fn polynomials(loads: &[Measured], count: usize) -> Vec<Vec<f64>> {
    let frequencies = || loads.iter().flat_map(|m| m.frequency_hz.iter().copied());
    let [low, high] = range(frequencies());
    let place = |f: f64| if high > low { 2.0 * (f - low) / (high - low) - 1.0 } else { 0.0 };
    frequencies().map(|f| special::legendre(place(f), count)).collect()
}

/// The coefficients of all error terms that are most probable if the rig answers `about`, and the slopes of
/// the tilt.
///
/// With the columns U of coefficients of unit variance and the covariance S of noise and misfit, the
/// coefficients are M^-1 U* S^-1 r with M = U* S^-1 U + 1, and C^-1 U = S^-1 U M^-1.
fn most_probable(
    loads: &[Measured],
    about: &[Vec<C64>],
    errors: &[ErrorTerm],
    rest: Rest<'_>,
) -> Result<(Vec<C64>, Vec<C64>), EngineError> {
    let size = |term: &ErrorTerm| match &term.sd {
        SdSpec::Fixed(sd) => *sd,
        _ => rest.sd(&group_of(term)),
    };
    let sizes: Vec<f64> = errors.iter().flat_map(|t| vec![size(t); t.functions]).collect();
    let powers: Vec<i32> = errors.iter().flat_map(|t| vec![t.power; t.functions]).collect();
    let columns: Vec<Vec<C64>> = errors.iter().flat_map(|term| complex(loads, about, term)).collect();
    let columns: Vec<Vec<C64>> =
        columns.iter().zip(&sizes).map(|(column, size)| column.iter().map(|z| z * size).collect()).collect();
    let q = columns.len();
    let (mut normal, mut right) = (vec![vec![C64::ZERO; q]; q], vec![C64::ZERO; q]);
    let mut solved = vec![Vec::new(); q];
    let mut first = 0;
    for (m, r0) in loads.iter().zip(about) {
        let n = m.values.len();
        let factor = Cholesky::new(&rest.covariance(m))?;
        // S is real: both parts of a column are solved for apart.
        let solve = |z: &[C64]| -> Vec<C64> {
            let part = |of: fn(&C64) -> f64| factor.solve(&z.iter().map(of).collect::<Vec<_>>());
            let (re, im) = (part(|z| z.re), part(|z| z.im));
            re.into_iter().zip(im).map(|(re, im)| C64::new(re, im)).collect()
        };
        let own = |j: usize| &columns[j][first..first + n];
        let residual: Vec<C64> = m.values.iter().zip(r0).map(|(y, r)| y - r).collect();
        let dot = |a: &[C64], b: &[C64]| a.iter().zip(b).map(|(a, b)| a.conj() * b).sum::<C64>();
        let turned = solve(&residual);
        for j in 0..q {
            let column = solve(own(j));
            for i in 0..q {
                normal[i][j] += dot(own(i), &column);
            }
            right[j] += dot(own(j), &turned);
            solved[j].extend(column);
        }
        first += n;
    }
    // As real numbers: X + iY turns into [X, -Y; Y, X].
    let matrix = Matrix::from_fn(2 * q, 2 * q, |i, j| {
        let z = normal[i % q][j % q];
        let one = if i == j { 1.0 } else { 0.0 };
        match (i / q, j / q) {
            (0, 0) | (1, 1) => z.re + one,
            (0, _) => -z.im,
            _ => z.im,
        }
    });
    let factor = Cholesky::new(&matrix)?;
    let both: Vec<f64> = right.iter().map(|z| z.re).chain(right.iter().map(|z| z.im)).collect();
    let found = factor.solve(&both);
    let coefficients = (0..q).map(|j| C64::new(found[j], found[q + j]) * sizes[j]).collect();
    let inverse = factor.inverse();
    let inverse = |i: usize, j: usize| C64::new(inverse[(i, j)], inverse[(q + i, j)]);
    let slope = |(k, r): (usize, &C64)| {
        let of_column = |j: usize| {
            let turned: C64 = (0..q).map(|l| solved[l][k] * inverse(l, j)).sum();
            // Of U dR the derivative of R^power.
            let slope = columns[j][k] * f64::from(powers[j]) / r;
            2.0 * turned * slope.conj()
        };
        (0..q).filter(|j| powers[*j] != 0).map(of_column).sum::<C64>()
    };
    let slopes = about.iter().flatten().enumerate().map(slope).collect();
    Ok((coefficients, slopes))
}

/// The group of noise that is the size of an error term.
pub(super) fn group_of(term: &ErrorTerm) -> String {
    format!("error b{} of the head", term.power)
}

impl Rest<'_> {
    fn sd(&self, name: &str) -> f64 {
        self.noise.iter().find(|n| n.name == name).map_or(0.0, |n| n.sd)
    }

    /// The covariance of the real parts of two numbers of one load, and of the imaginary ones.
    pub(super) fn covariance_of(&self, m: &Measured, i: usize, j: usize) -> f64 {
        let own = |i: usize| self.sd(NOISE).powi(2) * m.factor(i) + m.sd.get(i).map_or(0.0, |sd| sd * sd);
        let smooth = self.kernel.map_or(0.0, |kernel| {
            let distance = m.frequency_hz[i] - m.frequency_hz[j];
            self.sd(MISFIT).powi(2) * kernel.correlation(distance, self.sd(LENGTH_OF_MISFIT))
        });
        smooth + if i == j { own(i) } else { 0.0 }
    }

    fn covariance(&self, m: &Measured) -> Matrix {
        let n = m.values.len();
        Matrix::from_fn(n, n, |i, j| self.covariance_of(m, i, j))
    }
}
