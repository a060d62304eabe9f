//! Delays, of which the posterior has a maximum in every period: scanned over the prior.
//!
//! Modes of angular frequency w are moved by weights c(w) of laws n exp(-i w tau), with a lag 1/(1 + i w T)
//! or without.

use crate::problems::normal;
use approx::assert_abs_diff_eq;
use rijke_inference::*;
use rijke_numerics::{C64, Jet, JetSpace, Matrix, Order};
use std::f64::consts::TAU;

const ALL_HZ: [f64; 8] = [91.2, 89.2, 86.6, 379.3, 83.8, 336.5, 80.5, 302.9];
const HIGH_HZ: [f64; 3] = [379.3, 336.5, 302.9];
/// Standard deviation of every measured number, 1/s.
const SD: f64 = 1.0;

/// Two parameters, gain and delay, for each term; a lag of the first term comes last.
struct Modes {
    hz: Vec<f64>,
    terms: usize,
    lag: bool,
}

impl Modes {
    fn size(&self) -> usize {
        2 * self.terms + usize::from(self.lag)
    }

    /// The weight of a term: modes lie differently to it.
    fn weight(k: usize, term: usize) -> C64 {
        C64::from_polar(80.0, 0.7 * k as f64 + term as f64 * (1.0 + 0.9 * k as f64))
    }

    fn shift(&self, k: usize, a: &[Jet]) -> Jet {
        let s = C64::new(0.0, TAU * self.hz[k]);
        let term = |j: usize| {
            let law = &a[2 * j] * &a[2 * j + 1].scale(-s).exp();
            let law =
                if self.lag && j == 0 { &law / &a[self.size() - 1].scale(s).shift(C64::ONE) } else { law };
            law.scale(Self::weight(k, j))
        };
        (1..self.terms).fold(term(0), |sum, j| &sum + &term(j))
    }
}

impl Forward for Modes {
    fn predict(&self, a: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let space = JetSpace::new(a.len(), order.max(Order::First));
        let seeds: Vec<Jet> = a.iter().enumerate().map(|(i, a)| space.seed(i, C64::new(*a, 0.0))).collect();
        let all: Vec<Jet> = (0..self.hz.len()).map(|k| self.shift(k, &seeds)).collect();
        let jacobian = Matrix::from_fn(2 * all.len(), a.len(), |row, i| {
            let z = all[row / 2].gradient()[i];
            if row % 2 == 0 { z.re } else { z.im }
        });
        let packed = |z: &Jet| {
            let h = z.hessian_packed();
            h.iter().map(|h| h.re).chain(h.iter().map(|h| h.im)).collect::<Vec<_>>()
        };
        Ok(Prediction {
            values: all.iter().flat_map(|z| [z.value().re, z.value().im]).collect(),
            jacobian,
            curvature: if order == Order::Second {
                all.iter().flat_map(packed).collect()
            } else {
                Vec::new()
            },
        })
    }
}

/// Virtual data of `model` at `truth`, with errors of a fixed pattern of standard deviation 1.
fn data(model: &Modes, truth: &[f64], noise: NoiseGroup) -> Data {
    let mut values = model.predict(truth, Order::Value).unwrap().values;
    let n = values.len();
    for (k, v) in values.iter_mut().enumerate() {
        *v += SD * std::f64::consts::SQRT_2 * (2.4 * (k * k) as f64 + 0.3).sin();
    }
    let all: Vec<usize> = (0..n).collect();
    Data::new(vec![Observation::new("modes", values).with_independent_noise(0, &all)], vec![noise]).unwrap()
}

fn delay(name: &str, [mean, sd]: [f64; 2]) -> Parameter {
    Parameter::new(name, name, "s", Prior::Normal { mean, sd })
}

fn scans(names: &[&str], hz: &[f64]) -> AssessOptions {
    let step = 0.2 / hz.iter().fold(0.0, |a: f64, b| a.max(*b));
    let scans = names.iter().map(|n| Scan { parameter: (*n).to_owned(), step }).collect();
    AssessOptions { scans, draws: 0, ..AssessOptions::default() }
}

fn ln_normal(x: f64, [mean, sd]: [f64; 2]) -> f64 {
    -0.5 * ((x - mean) / sd).powi(2) - (sd * TAU.sqrt()).ln()
}

/// Priors of a delay of 3.1 ms, up to 6.9 standard deviations off, s.
const PRIORS: [[f64; 2]; 10] = [
    [7e-3, 1e-3],
    [7e-3, 2e-3],
    [8e-3, 1e-3],
    [8e-3, 2e-3],
    [9e-3, 1e-3],
    [9e-3, 2e-3],
    [9e-3, 3e-3],
    [10e-3, 1e-3],
    [10e-3, 2e-3],
    [10e-3, 3e-3],
];

#[test]
fn oracle_the_best_maximum_of_a_delay_does_not_depend_on_where_its_prior_lies() {
    // The gain enters linearly: for a delay its posterior is a normal, and the evidence one integral over the
    // delay, here of the neighbourhood of the highest place of a grid of 0.2 microseconds.
    for hz in [&ALL_HZ[..], &HIGH_HZ] {
        let model = Modes { hz: hz.to_vec(), terms: 1, lag: false };
        let fixed = data(&model, &[0.35, 3.1e-3], NoiseGroup::fixed("noise", "1/s", SD));
        let measured = &fixed.observations()[0].values;
        let ln_given = |tau: f64| {
            let unit = model.predict(&[1.0, tau], Order::Value).unwrap().values;
            let (mut aa, mut ad, mut dd) = (1.0 / 0.25, 0.5 / 0.25, 0.25 / 0.25);
            for (u, d) in unit.iter().zip(measured) {
                aa += u * u / (SD * SD);
                ad += u * d / (SD * SD);
                dd += d * d / (SD * SD);
            }
            -0.5 * (dd - ad * ad / aa)
                - 0.5 * (0.25 * aa).ln()
                - measured.len() as f64 * (SD * TAU.sqrt()).ln()
        };
        for prior in PRIORS {
            let h = 2e-7;
            let all: Vec<f64> = (0..150_000).map(|k| -8e-3 + h * f64::from(k)).collect();
            let ln: Vec<f64> = all.iter().map(|tau| ln_given(*tau) + ln_normal(*tau, prior)).collect();
            let best = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let exact = best + (ln.iter().map(|l| (l - best).exp()).sum::<f64>() * h).ln();
            let at = all[ln.iter().position(|l| *l == best).unwrap()];
            let parameters = Parameters::new(vec![normal("n", 0.5, 0.5), delay("tau", prior)]).unwrap();
            let found = assess(&model, &fixed, &parameters, &scans(&["tau"], hz)).unwrap();
            println!(
                "{} modes, {prior:?}: {:.5e} of {at:.5e}, {:.3} of {exact:.3}, {} starts, {} calls",
                hz.len(),
                found.fit.parameters[1],
                found.evidence.as_ref().unwrap().ln_marginal,
                found.health.starts,
                found.health.calls.total()
            );
            assert_abs_diff_eq!(found.fit.parameters[1], at, epsilon = 2.0 * h);
            assert_abs_diff_eq!(found.evidence.unwrap().ln_marginal, exact, epsilon = 0.02);
        }
    }
}

#[test]
fn exact_with_a_noise_that_floats_the_evidence_differs_by_the_priors_density_alone() {
    for hz in [&ALL_HZ[..], &HIGH_HZ] {
        let model = Modes { hz: hz.to_vec(), terms: 1, lag: false };
        let noise = || NoiseGroup::inferred("noise", "1/s", 1.0, 2.0);
        let data = data(&model, &[0.35, 3.1e-3], noise());
        // Beyond five standard deviations the prior outweighs three modes, and another maximum is more
        // probable.
        let weak = |[mean, sd]: &[f64; 2]| hz.len() > 3 || mean - 3.1e-3 < 5.0 * sd;
        let found: Vec<[f64; 2]> = PRIORS
            .into_iter()
            .filter(weak)
            .map(|prior| {
                let parameters = Parameters::new(vec![normal("n", 0.5, 0.5), delay("tau", prior)]).unwrap();
                let found = assess(&model, &data, &parameters, &scans(&["tau"], hz)).unwrap();
                let (tau, ln) = (found.fit.parameters[1], found.laplace.unwrap().evidence.ln_marginal);
                println!(
                    "{} modes, {prior:?}: {tau:.5e}, {ln:.3}, {} calls",
                    hz.len(),
                    found.health.calls.total()
                );
                [tau, ln - ln_normal(tau, prior)]
            })
            .collect();
        for &[tau, ln] in &found {
            assert_abs_diff_eq!(tau, 3.1e-3, epsilon = 3e-5);
            assert_abs_diff_eq!(tau, found[0][0], epsilon = 1e-6);
            assert_abs_diff_eq!(ln, found[0][1], epsilon = 0.02);
        }
    }
}

#[test]
fn behaviour_two_delays_at_once_are_found() {
    let model = Modes { hz: ALL_HZ.to_vec(), terms: 2, lag: false };
    let truth = [0.35, 3.1e-3, -0.2, 6.4e-3];
    let data = data(&model, &truth, NoiseGroup::inferred("noise", "1/s", 1.0, 2.0));
    for priors in [[[7e-3, 2e-3], [9e-3, 2e-3]], [[6e-3, 1.5e-3], [3e-3, 2e-3]], [[10e-3, 3e-3]; 2]] {
        let list = vec![
            normal("n", 0.5, 0.5),
            delay("tau", priors[0]),
            normal("m", 0.0, 0.5),
            delay("later", priors[1]),
        ];
        let parameters = Parameters::new(list).unwrap();
        let found = assess(&model, &data, &parameters, &scans(&["tau", "later"], &ALL_HZ)).unwrap();
        let (a, sd) = (&found.fit.parameters, &found.laplace.unwrap().physical_covariance);
        println!("{priors:?}: {a:?}, {} starts, {} calls", found.health.starts, found.health.calls.total());
        (0..4).for_each(|i| assert_abs_diff_eq!(a[i], truth[i], epsilon = 4.0 * sd[(i, i)].sqrt()));
        assert!(sd[(1, 1)].sqrt() < 1e-4 && sd[(3, 3)].sqrt() < 1e-4);
    }
}

#[test]
fn behaviour_a_delay_beside_a_lag_is_found() {
    let model = Modes { hz: ALL_HZ.to_vec(), terms: 1, lag: true };
    let truth = [0.6, 3.1e-3, 0.5e-3];
    let data = data(&model, &truth, NoiseGroup::inferred("noise", "1/s", 1.0, 2.0));
    for prior in [[7e-3, 2e-3], [9e-3, 3e-3], [1e-3, 1e-3]] {
        let lag = Parameter::new("lag", "T", "s", Prior::LogNormal { median: 1e-3, ln_sd: 0.7 });
        let parameters = Parameters::new(vec![normal("n", 0.5, 0.5), delay("tau", prior), lag]).unwrap();
        let found = assess(&model, &data, &parameters, &scans(&["tau"], &ALL_HZ)).unwrap();
        let (a, sd) = (&found.fit.parameters, &found.laplace.unwrap().physical_covariance);
        println!("{prior:?}: {a:?}, {} starts, {} calls", found.health.starts, found.health.calls.total());
        (0..3).for_each(|i| assert_abs_diff_eq!(a[i], truth[i], epsilon = 4.0 * sd[(i, i)].sqrt()));
        assert!(sd[(1, 1)].sqrt() < 1e-4);
    }
}
