//! What a model says together of numbers that could be measured, and what measuring some would tell.
//!
//! With y the numbers, J their derivatives in what is known to Sigma (parameters, and errors that the
//! training found), E the errors that points share and N the noise of each visit, y has the covariance V = J
//! Sigma J' + E + N. Whatever is chosen to be measured is a selection of rows, so that what points share is
//! counted once.

use crate::EngineError;
use rijke_numerics::{C64, Cholesky, Matrix, dot};
use rijke_study::Cause;
use std::collections::BTreeMap;

/// Who shares an error.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Shared {
    /// All points that name the cause.
    Cause(Cause),
    /// No visit: an error of what is wanted, drawn anew.
    Anew(Cause),
    /// The points of one installation: growth rate (0) or angular frequency (1).
    Installation(usize, String),
    /// The points of one installation: a parameter that differs from installation to installation.
    Varying(String, String),
    /// All points: the errors of calibration that the microphones in use have together.
    Calibration(usize),
    /// All points: what a further microphone has of its own in delay (0) or gain (1).
    Microphone(usize, usize),
}

/// The numbers of one visit, or of one of its modes, to first order.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    /// Place in what is known, and the derivative in it.
    pub(super) along: Vec<(usize, Vec<f64>)>,
    /// The change per sd of each error that points share.
    pub(super) shared: BTreeMap<Shared, Vec<f64>>,
    /// Covariance of the noise of one visit; zero for a quantity that is wanted and not measured.
    pub(super) noise: Matrix,
    /// Its part that comes again at every visit: the misfit.
    pub(super) stays: Matrix,
}

impl Numbers {
    /// The relative pressures of one mode, which stand after growth rate and angular frequency.
    pub(super) fn pressures(&self) -> Vec<C64> {
        self.values[2..].chunks_exact(2).map(|z| C64::new(z[0], z[1])).collect()
    }

    /// What is read if the rows of `t` say how numbers combine.
    pub(super) fn through(&self, t: &Matrix) -> Self {
        Self {
            values: t.times(&self.values),
            along: self.along.iter().map(|(place, slope)| (*place, t.times(slope))).collect(),
            shared: self.shared.iter().map(|(cause, slope)| (cause.clone(), t.times(slope))).collect(),
            noise: t.product(&self.noise).product(&t.transpose()),
            stays: t.product(&self.stays).product(&t.transpose()),
        }
    }

    /// What a repeat will read, given that an earlier visit read `residual` more than the model at these
    /// rows: the misfit stays, so that the repeat tells only what the other errors of that visit hid. What
    /// installations differ by is drawn anew.
    pub(super) fn repeated(mut self, rows: &[usize], residual: &[f64]) -> Result<Self, EngineError> {
        let anew = |cause: &Shared| matches!(cause, Shared::Installation(..) | Shared::Varying(..));
        let mut first = self.noise.clone();
        self.shared.iter().filter(|(cause, _)| anew(cause)).for_each(|(_, slope)| first.add_outer(slope));
        let read = |m: &Matrix| Matrix::from_fn(rows.len(), m.columns(), |i, j| m[(rows[i], j)]);
        let stays = read(&self.stays);
        let share = Cholesky::new(&first.select(rows))?.inverse().product(&stays).transpose();
        let less = |slope: &mut Vec<f64>| {
            let told = share.times(&rows.iter().map(|r| slope[*r]).collect::<Vec<_>>());
            slope.iter_mut().zip(told).for_each(|(s, t)| *s -= t);
        };
        self.along.iter_mut().for_each(|(_, slope)| less(slope));
        self.shared.iter_mut().filter(|(cause, _)| !anew(cause)).for_each(|(_, slope)| less(slope));
        self.values.iter_mut().zip(share.times(residual)).for_each(|(v, r)| *v += r);
        let told = share.product(&stays);
        (self.noise, self.stays) = (self.noise.plus(-1.0, &told), self.stays.plus(-1.0, &told));
        Ok(self)
    }
}

/// The joint predictive of operating points by one model.
#[derive(Clone, Debug)]
pub(super) struct Predictive {
    points: Vec<Numbers>,
    /// Where the rows of each point start.
    starts: Vec<usize>,
    /// J Sigma J'.
    signal: Matrix,
    /// E.
    shared: Matrix,
}

impl Predictive {
    /// From the points and the covariance of what is known.
    pub(super) fn new(points: Vec<Numbers>, covariance: &Matrix) -> Self {
        let starts: Vec<usize> = points
            .iter()
            .scan(0, |next, p| {
                let start = *next;
                *next += p.values.len();
                Some(start)
            })
            .collect();
        let rows: usize = points.iter().map(|p| p.values.len()).sum();
        let mut jacobian = Matrix::zeros(rows, covariance.rows());
        for (point, start) in points.iter().zip(&starts) {
            for (place, slope) in &point.along {
                slope.iter().enumerate().for_each(|(row, d)| jacobian[(start + row, *place)] += d);
            }
        }
        let signal = jacobian.product(covariance).product(&jacobian.transpose());
        let mut shared = Matrix::zeros(rows, rows);
        for (a, from) in points.iter().zip(&starts) {
            for (b, to) in points.iter().zip(&starts) {
                for (cause, slope) in &a.shared {
                    let Some(other) = b.shared.get(cause) else { continue };
                    for (i, x) in slope.iter().enumerate() {
                        other.iter().enumerate().for_each(|(j, y)| shared[(from + i, to + j)] += x * y);
                    }
                }
            }
        }
        Self { points, starts, signal, shared }
    }

    /// The rows of the visits `set`, each with the visit that it belongs to.
    fn rows(&self, set: &[usize]) -> Vec<(usize, usize)> {
        let of = |(visit, &k): (usize, &usize)| {
            (0..self.points[k].values.len()).map(move |i| (visit, self.starts[k] + i))
        };
        set.iter().enumerate().flat_map(of).collect()
    }

    /// The covariance of what the visits would bring if all parameters were known: a repeat has measured
    /// errors of its own, the same misfit and the same shared errors.
    fn errors(&self, set: &[usize]) -> Matrix {
        let rows = self.rows(set);
        Matrix::from_fn(rows.len(), rows.len(), |i, j| {
            let ((visit, a), (other, b)) = (rows[i], rows[j]);
            let k = set[visit];
            let of = |m: &Matrix| m[(a - self.starts[k], b - self.starts[k])];
            let noise = match (visit == other, k == set[other]) {
                (true, _) => of(&self.points[k].noise),
                (false, true) => of(&self.points[k].stays),
                (false, false) => 0.0,
            };
            self.shared[(a, b)] + noise
        })
    }

    pub(super) fn covariance(&self, set: &[usize]) -> Matrix {
        let rows = self.rows(set);
        let mut v = self.errors(set);
        for (i, (_, a)) in rows.iter().enumerate() {
            rows.iter().enumerate().for_each(|(j, (_, b))| v[(i, j)] += self.signal[(*a, *b)]);
        }
        v
    }

    fn mean(&self, set: &[usize]) -> Vec<f64> {
        set.iter().flat_map(|&k| self.points[k].values.iter().copied()).collect()
    }

    /// What the visits `set` would tell of the parameters, nats: the expected Kullback-Leibler divergence of
    /// posterior from prior, which is (1/2) ln det (E + N)^-1 V (Lindley 1956; with the derivatives of the
    /// adjoint, Yoko & Juniper 2024).
    pub(super) fn information(&self, set: &[usize]) -> Result<f64, EngineError> {
        let (v, e) = (Cholesky::new(&self.covariance(set))?, Cholesky::new(&self.errors(set))?);
        Ok(0.5 * (v.ln_det() - e.ln_det()))
    }

    /// Variance of the first number of point `quantity` before, and after the visits `set`.
    pub(super) fn variances(&self, quantity: usize, set: &[usize]) -> Result<[f64; 2], EngineError> {
        let q = self.starts[quantity];
        let before = self.signal[(q, q)] + self.shared[(q, q)];
        let with: Vec<f64> =
            self.rows(set).iter().map(|(_, a)| self.signal[(*a, q)] + self.shared[(*a, q)]).collect();
        let v = Cholesky::new(&self.covariance(set))?;
        let told: f64 = v.whiten(&with).iter().map(|w| w * w).sum();
        Ok([before, before - told])
    }

    /// The expected logarithm of the Bayes factor for `self` against `other` by the visits `set` if `self` is
    /// right, nats: the Kullback-Leibler divergence of the two predictives.
    pub(super) fn divergence(&self, other: &Self, set: &[usize]) -> Result<f64, EngineError> {
        let (mine, theirs) = (self.covariance(set), other.covariance(set));
        let (own, their) = (Cholesky::new(&mine)?, Cholesky::new(&theirs)?);
        let squared = |v: &[f64]| their.whiten(v).iter().map(|w| w * w).sum::<f64>();
        // tr(B^-1 A) with A = L L' is the sum over the columns of L.
        let l = own.lower();
        let n = l.rows();
        let trace: f64 = (0..n).map(|j| squared(&(0..n).map(|i| l[(i, j)]).collect::<Vec<_>>())).sum();
        let apart: Vec<f64> = self.mean(set).iter().zip(other.mean(set)).map(|(a, b)| a - b).collect();
        Ok(0.5 * (trace - n as f64 + squared(&apart) + their.ln_det() - own.ln_det()))
    }

    /// The standard deviation of that logarithm if `self` is right. With z standard normal it is b'z + (1/2)
    /// z'(M - 1)z and a constant, M = L' V_B^-1 L, V_A = L L', b = L' V_B^-1 (m_A - m_B), whose variance is
    /// b'b + (1/2) tr (M - 1)^2.
    pub(super) fn spread(&self, other: &Self, set: &[usize]) -> Result<f64, EngineError> {
        let (own, their) = (Cholesky::new(&self.covariance(set))?, Cholesky::new(&other.covariance(set))?);
        let columns = own.lower().transpose();
        let white: Vec<Vec<f64>> = (0..columns.rows()).map(|j| their.whiten(columns.row(j))).collect();
        let apart: Vec<f64> = self.mean(set).iter().zip(other.mean(set)).map(|(a, b)| a - b).collect();
        let apart = their.whiten(&apart);
        let mut variance: f64 = white.iter().map(|w| dot(w, &apart).powi(2)).sum();
        for (i, a) in white.iter().enumerate() {
            for (j, b) in white.iter().enumerate() {
                variance += 0.5 * (dot(a, b) - f64::from(u8::from(i == j))).powi(2);
            }
        }
        Ok(variance.sqrt())
    }
}

/// What some visits would read, by one model.
pub(super) struct Seen {
    mean: Vec<f64>,
    covariance: Matrix,
    ln_det: f64,
}

impl Predictive {
    pub(super) fn seen(&self, set: &[usize]) -> Result<Seen, EngineError> {
        let covariance = self.covariance(set);
        let ln_det = Cholesky::new(&covariance)?.ln_det();
        Ok(Seen { mean: self.mean(set), covariance, ln_det })
    }
}

impl Seen {
    /// Bhattacharyya's distance of two Gaussians: (1/8) d' V^-1 d + (1/2) ln (det V / (det V_A det V_B)^1/2),
    /// V = (V_A + V_B)/2 (Kailath 1967).
    pub(super) fn distance(&self, other: &Self) -> Result<f64, EngineError> {
        let sum = self.covariance.plus(1.0, &other.covariance);
        let middle = Cholesky::new(&Matrix::from_fn(sum.rows(), sum.rows(), |i, j| 0.5 * sum[(i, j)]))?;
        let apart: Vec<f64> = self.mean.iter().zip(&other.mean).map(|(a, b)| a - b).collect();
        let square: f64 = middle.whiten(&apart).iter().map(|w| w * w).sum();
        Ok(0.125 * square + 0.5 * (middle.ln_det() - 0.5 * (self.ln_det + other.ln_det)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rijke_numerics::{Stream, Streams};

    /// Three points of one number, two parameters; the first two are of one installation.
    const SLOPES: [[f64; 2]; 3] = [[1.0, 0.4], [0.3, -0.8], [-0.5, 0.9]];
    const SHARED: f64 = 0.7;
    const NOISE: f64 = 0.5;

    fn sigma() -> Matrix {
        Matrix::from_fn(2, 2, |i, j| [[1.0, 0.3], [0.3, 0.6]][i][j])
    }

    fn predictive(offset: f64, scale: f64) -> Predictive {
        let point = |k: usize| Numbers {
            values: vec![offset * k as f64],
            along: (0..2).map(|i| (i, vec![scale * SLOPES[k][i]])).collect(),
            shared: BTreeMap::from([(
                Shared::Installation(0, if k < 2 { "a" } else { "b" }.to_owned()),
                vec![SHARED],
            )]),
            noise: Matrix::diagonal(&[NOISE * NOISE]),
            stays: Matrix::zeros(1, 1),
        };
        Predictive::new((0..3).map(point).collect(), &sigma())
    }

    fn draw(stream: &mut Stream) -> f64 {
        StandardNormal.sample(stream)
    }

    /// A draw of the parameters, by the factor of `sigma`.
    fn parameters(stream: &mut Stream) -> [f64; 2] {
        let (a, b) = (draw(stream), draw(stream));
        [a, 0.3 * a + 0.51_f64.sqrt() * b]
    }

    /// What the first two points read, but for noise.
    fn clean(offset: f64, scale: f64, [a, b]: [f64; 2], shared: f64) -> [f64; 2] {
        [0, 1].map(|k| offset * k as f64 + scale * (SLOPES[k][0] * a + SLOPES[k][1] * b) + SHARED * shared)
    }

    /// ln of the mean of the density of `y` over clean readings.
    fn ln_density(y: [f64; 2], of: &[[f64; 2]]) -> f64 {
        let one =
            |m: &[f64; 2]| (-0.5 * ((y[0] - m[0]).powi(2) + (y[1] - m[1]).powi(2)) / (NOISE * NOISE)).exp();
        (of.iter().map(one).sum::<f64>() / of.len() as f64).ln()
    }

    /// Nested Monte Carlo over parameters, the error of the installation and the noise, without any formula
    /// for Gaussians.
    #[test]
    fn oracle_information_and_bayes_factor_against_nested_monte_carlo() {
        let (outer, inner) = (3000, 3000);
        let (a, b) = (predictive(0.0, 1.0), predictive(1.2, 0.6));
        let mut stream = Streams::new(11).stream("next/oracle");
        let mut cloud = |offset: f64, scale: f64| -> Vec<[f64; 2]> {
            (0..inner).map(|_| clean(offset, scale, parameters(&mut stream), draw(&mut stream))).collect()
        };
        let (of_a, of_b) = (cloud(0.0, 1.0), cloud(1.2, 0.6));
        let errors: Vec<f64> = (0..300).map(|_| draw(&mut stream)).collect();
        let [mut information, mut factor, mut square] = [0.0; 3];
        for _ in 0..outer {
            let p = parameters(&mut stream);
            let truth = clean(0.0, 1.0, p, draw(&mut stream));
            let y = truth.map(|m| m + NOISE * draw(&mut stream));
            let known: Vec<[f64; 2]> = errors.iter().map(|e| clean(0.0, 1.0, p, *e)).collect();
            let marginal = ln_density(y, &of_a);
            information += (ln_density(y, &known) - marginal) / f64::from(outer);
            let ln = marginal - ln_density(y, &of_b);
            factor += ln / f64::from(outer);
            square += ln * ln / f64::from(outer);
        }
        for (formula, sampled) in [
            (a.information(&[0, 1]).unwrap(), information),
            (a.divergence(&b, &[0, 1]).unwrap(), factor),
            (a.spread(&b, &[0, 1]).unwrap(), (square - factor * factor).sqrt()),
        ] {
            assert!((formula / sampled - 1.0).abs() < 0.1 && formula > 0.2, "{formula} {sampled}");
        }
    }

    #[test]
    fn exact_information_of_visits_one_after_another_adds_up() {
        let all = predictive(0.0, 1.0);
        let set = [0, 2, 1, 0];
        let joint = all.information(&set).unwrap();
        // The other way: parameters and the two errors of installations as one state, updated visit by visit
        // (Kalman 1960); what is told of the parameters is the change of the determinant of their block.
        let mut state = Matrix::from_fn(4, 4, |i, j| match (i, j) {
            (0 | 1, 0 | 1) => sigma()[(i, j)],
            _ => f64::from(u8::from(i == j)),
        });
        let ln_det = |m: &Matrix| Cholesky::new(&m.select(&[0, 1])).unwrap().ln_det();
        let mut told = 0.0;
        for k in set {
            let own = if k < 2 { 2 } else { 3 };
            let mut row = [SLOPES[k][0], SLOPES[k][1], 0.0, 0.0];
            row[own] = SHARED;
            let gain = state.times(&row);
            let variance = NOISE * NOISE + row.iter().zip(&gain).map(|(a, b)| a * b).sum::<f64>();
            let before = ln_det(&state);
            state = Matrix::from_fn(4, 4, |i, j| state[(i, j)] - gain[i] * gain[j] / variance);
            told += 0.5 * (before - ln_det(&state));
        }
        assert!((told - joint).abs() < 1e-12, "{told} {joint}");
        // A wanted quantity: the variance of the first parameter by the same update.
        let wanted = Numbers {
            values: vec![0.0],
            along: vec![(0, vec![1.0])],
            noise: Matrix::zeros(1, 1),
            stays: Matrix::zeros(1, 1),
            ..Numbers::default()
        };
        let points = all.points.iter().cloned().chain([wanted]).collect();
        let [before, after] = Predictive::new(points, &sigma()).variances(3, &set).unwrap();
        assert!((before - 1.0).abs() < 1e-12 && (after - state[(0, 0)]).abs() < 1e-12, "{before} {after}");
    }

    /// A repeat after a visit that trained, and twice in a plan, against one state of parameter, misfit and
    /// nothing else, updated reading by reading (Kalman 1960).
    #[test]
    fn exact_the_misfit_of_a_point_comes_again() {
        let (misfit, error, slope, prior) = (0.8_f64.powi(2), 0.3_f64.powi(2), 1.7, 0.5);
        let update = |mut state: [[f64; 2]; 2]| {
            let gain: Vec<f64> = (0..2).map(|i| state[i][0] * slope + state[i][1]).collect();
            let variance = error + gain[0] * slope + gain[1];
            let old = state;
            (0..2).for_each(|i| (0..2).for_each(|j| state[i][j] = old[i][j] - gain[i] * gain[j] / variance));
            state
        };
        let once = update([[prior, 0.0], [0.0, misfit]]);
        let thrice = update(update(once));
        let visit = Numbers {
            values: vec![0.2],
            along: vec![(0, vec![slope])],
            noise: Matrix::diagonal(&[misfit + error]),
            stays: Matrix::diagonal(&[misfit]),
            ..Numbers::default()
        };
        let repeat = visit.repeated(&[0], &[1.0]).unwrap();
        assert!((repeat.values[0] - 0.2 - misfit / (misfit + error)).abs() < 1e-12);
        let told = Predictive::new(vec![repeat], &Matrix::diagonal(&[once[0][0]])).information(&[0, 0]);
        let exact = 0.5 * (once[0][0] / thrice[0][0]).ln();
        assert!((told.unwrap() / exact - 1.0).abs() < 1e-12 && exact > 0.0, "{exact}");
    }

    #[test]
    fn exact_a_model_cannot_be_told_from_itself() {
        let a = predictive(0.4, 1.0);
        assert!(a.divergence(&a, &[0, 1, 1, 2]).unwrap().abs() < 1e-12);
    }
}
