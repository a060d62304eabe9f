//! What must not change the evidence.

use crate::problems::{Linear, Ringing, design, normal, numbers, ringing};
use approx::assert_relative_eq;
use rijke_inference::*;
use rijke_numerics::{C64, Cholesky, Matrix, Order};

fn evidence(model: &dyn Forward, data: &Data, parameters: &Parameters) -> f64 {
    let posterior = Posterior::new(model, data, parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    assert!(fit.stop.converged(), "{:?}", fit.stop);
    posterior.laplace(&fit).unwrap().evidence.ln_marginal
}

/// The model in parameters b, with a = shift + M b.
struct Affine<'a>(&'a dyn Forward, Matrix, Vec<f64>);

impl Forward for Affine<'_> {
    fn predict(&self, b: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let p = b.len();
        let a: Vec<f64> = self.1.times(b).iter().zip(&self.2).map(|(x, s)| x + s).collect();
        let mut out = self.0.predict(&a, order)?;
        let triangle = p * (p + 1) / 2;
        let place = |i: usize, j: usize| i.max(j) * (i.max(j) + 1) / 2 + i.min(j);
        let old = out.curvature.clone();
        for row in 0..out.values.len() {
            for i in 0..p {
                for j in 0..=i {
                    let sum = (0..p)
                        .flat_map(|k| (0..p).map(move |l| (k, l)))
                        .map(|(k, l)| self.1[(k, i)] * old[row * triangle + place(k, l)] * self.1[(l, j)])
                        .sum();
                    out.curvature[row * triangle + place(i, j)] = sum;
                }
            }
        }
        out.jacobian = out.jacobian.product(&self.1);
        Ok(out)
    }
}

#[test]
fn exact_affine_change_of_parameters() {
    let (model, data, _) = ringing();
    let list = || vec![normal("a", 1.0, 0.5), normal("b", 0.5, 0.4), normal("c", 2.0, 0.3)];
    let plain = Parameters::new(list()).unwrap();
    // b = M^-1 (a - shift) with the prior transformed: mean M^-1 (mean - shift), precision M' P M.
    let m = Matrix::from_fn(3, 3, |i, j| [[2.0, 0.5, -0.3], [0.1, 0.02, 0.3], [-0.4, 1.0, 1.0]][i][j]);
    let shift = vec![0.2, -0.1, 0.4];
    let offset: Vec<f64> = [1.0, 0.5, 2.0].iter().zip(&shift).map(|(a, s)| a - s).collect();
    let mean = rijke_numerics::lu_solve(&m, &offset).unwrap();
    let precision = Matrix::diagonal(&[0.5_f64, 0.4, 0.3].map(|s| s.powi(-2)));
    let covariance = Cholesky::new(&m.transpose().product(&precision).product(&m)).unwrap().inverse();
    let moved = Parameters::new(list()).unwrap().with_joint(&["a", "b", "c"], &mean, &covariance).unwrap();
    assert_relative_eq!(
        evidence(&model, &data, &plain),
        evidence(&Affine(&model, m, shift), &data, &moved),
        epsilon = 1e-9
    );
}

/// The model with a = exp(b) for its first parameter.
struct Exponential(Ringing);

impl Forward for Exponential {
    fn predict(&self, b: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let a = b[0].exp();
        let mut out = self.0.predict(&[a, b[1], b[2]], order)?;
        for row in 0..out.values.len() {
            let h = &mut out.curvature[row * 6..row * 6 + 6];
            h[0] = a * a * h[0] + a * out.jacobian[(row, 0)];
            h[1] *= a;
            h[3] *= a;
            out.jacobian[(row, 0)] *= a;
        }
        Ok(out)
    }
}

#[test]
fn exact_exponential_change_of_parameter() {
    let (model, data, _) = ringing();
    let rest = || [normal("b", 0.5, 0.4), normal("c", 2.0, 0.3)];
    let mut direct = vec![Parameter::new("a", "a", "1", Prior::LogNormal { median: 1.2, ln_sd: 0.4 })];
    direct.extend(rest());
    let mut through_ln = vec![normal("ln a", 1.2_f64.ln(), 0.4)];
    through_ln.extend(rest());
    assert_relative_eq!(
        evidence(&model, &data, &Parameters::new(direct).unwrap()),
        evidence(&Exponential(Ringing { times: model.times }), &data, &Parameters::new(through_ln).unwrap()),
        epsilon = 1e-10
    );
}

#[test]
fn exact_an_unseen_parameter_changes_nothing() {
    let (x, y) = (design("unseen", 20, 3), numbers("unseen/y", 20));
    let observation = Observation::new("d", y).with_independent_noise(0, &(0..20).collect::<Vec<_>>());
    let data = Data::new(vec![observation], vec![NoiseGroup::floated("noise", "1")]).unwrap();
    let list = |p| Parameters::new((0..p).map(|i| normal(&format!("a{i}"), 0.1, 0.7)).collect()).unwrap();
    let wider = Matrix::from_fn(20, 4, |i, j| if j < 3 { x[(i, j)] } else { 0.0 });
    assert_relative_eq!(
        evidence(&Linear(x), &data, &list(3)),
        evidence(&Linear(wider), &data, &list(4)),
        epsilon = 1e-10
    );
}

/// The model in other units.
struct Scaled<'a>(&'a dyn Forward, f64);

impl Forward for Scaled<'_> {
    fn predict(&self, a: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let mut out = self.0.predict(a, order)?;
        out.values.iter_mut().for_each(|v| *v *= self.1);
        out.jacobian.as_mut_slice().iter_mut().for_each(|v| *v *= self.1);
        out.curvature.iter_mut().for_each(|v| *v *= self.1);
        Ok(out)
    }
}

#[test]
fn exact_units_of_the_data_shift_all_models_alike() {
    let (model, data, parameters) = ringing();
    let c = 1000.0;
    let observations = data.observations().iter().map(|o| Observation {
        values: o.values.iter().map(|v| c * v).collect(),
        floor: o.floor.as_ref().map(|f| Matrix::zeros(4, 4).plus(c * c, f)),
        ..o.clone()
    });
    let groups =
        vec![NoiseGroup::floated("in phase", "mV"), NoiseGroup::inferred("all", "mV", 0.03 * c, 0.5)];
    let scaled = Data::new(observations.collect(), groups).unwrap();
    assert_relative_eq!(
        evidence(&Scaled(&model, c), &scaled, &parameters),
        evidence(&model, &data, &parameters) - 24.0 * c.ln(),
        epsilon = 1e-9
    );
}

#[test]
fn exact_order_of_observations() {
    let (x, y) = (design("order", 12, 3), numbers("order/y", 12));
    let build = |order: Vec<usize>| {
        let observations = order
            .iter()
            .map(|&i| Observation::new(format!("{i}"), vec![y[i]]).with_independent_noise(0, &[0]));
        let data = Data::new(observations.collect(), vec![NoiseGroup::floated("noise", "1")]).unwrap();
        (Linear(Matrix::from_fn(12, 3, |k, j| x[(order[k], j)])), data)
    };
    let parameters = Parameters::new((0..3).map(|i| normal(&format!("a{i}"), 0.0, 1.0)).collect()).unwrap();
    let ((one, one_data), (two, two_data)) = (build((0..12).collect()), build((0..12).rev().collect()));
    assert_relative_eq!(
        evidence(&one, &one_data, &parameters),
        evidence(&two, &two_data, &parameters),
        epsilon = 1e-11
    );
}

#[test]
fn exact_two_batches_in_sequence() {
    let (x, y) = (design("batch", 16, 3), numbers("batch/y", 16));
    let batch = |from: usize, to: usize| {
        let observation = Observation::new("d", y[from..to].to_vec())
            .with_independent_noise(0, &(0..to - from).collect::<Vec<_>>());
        let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", 0.3)]).unwrap();
        (Linear(Matrix::from_fn(to - from, 3, |i, j| x[(from + i, j)])), data)
    };
    let prior = || Parameters::new((0..3).map(|i| normal(&format!("a{i}"), 0.2, 0.8)).collect()).unwrap();
    let ((all, all_data), (one, one_data), (two, two_data)) = (batch(0, 16), batch(0, 7), batch(7, 16));
    let first_prior = prior();
    let posterior = Posterior::new(&one, &one_data, &first_prior).unwrap();
    let first = posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap();
    let carried = prior().with_joint(&["a0", "a1", "a2"], &first.mean, &first.covariance).unwrap();
    assert_relative_eq!(
        evidence(&all, &all_data, &first_prior),
        first.evidence.ln_marginal + evidence(&two, &two_data, &carried),
        epsilon = 1e-10
    );
}

/// What an earlier stage states in physical values is the prior that its working coordinates hold, whatever
/// the coordinates are.
#[test]
fn exact_a_posterior_in_physical_values_is_the_same_prior() {
    let list = || {
        vec![
            Parameter::new("a", "a", "1", Prior::LogNormal { median: 3e-4, ln_sd: 0.8 }),
            Parameter::new("b", "b", "1", Prior::Uniform { low: -1.0, high: 3.0 }),
            normal("c", 2.0, 0.3),
        ]
    };
    let parameters = Parameters::new(list()).unwrap();
    let at = parameters.working(&[2.8e-4, 0.4, 1.7]);
    let covariance = Matrix::from_fn(3, 3, |i, j| if i == j { 0.04 } else { 0.01 });
    let slopes: Vec<f64> = list().iter().zip(&at).map(|(p, z)| p.physical(*z)[1]).collect();
    let physical = Matrix::from_fn(3, 3, |i, j| slopes[i] * slopes[j] * covariance[(i, j)]);
    let names = ["a", "b", "c"];
    let working = Parameters::new(list()).unwrap().with_joint(&names, &at, &covariance).unwrap();
    let stated = parameters.with_physical_joint(&names, &[2.8e-4, 0.4, 1.7], &physical).unwrap();
    for (a, b) in working.centre().iter().zip(stated.centre()) {
        assert_relative_eq!(*a, b, max_relative = 1e-12);
    }
    for (a, b) in working.scales().iter().zip(stated.scales()) {
        assert_relative_eq!(*a, b, max_relative = 1e-12);
    }
    assert_relative_eq!(stated.physical(&stated.centre())[0], 2.8e-4, max_relative = 1e-12);
}

/// Pressures at four places, two complex waves: p_m = a_0 e^{i m} + (a_1 + i a_2) e^{-0.4 i m}, relative to
/// one place.
struct Relative {
    reference: usize,
}

impl Relative {
    fn pressures(a: &[f64]) -> Vec<C64> {
        (0..4)
            .map(|m| {
                let m = f64::from(m);
                C64::from_polar(a[0], m) + C64::new(a[1], a[2]) * C64::from_polar(1.0, -0.4 * m)
            })
            .collect()
    }

    fn relative(&self, a: &[f64]) -> Vec<C64> {
        let p = Self::pressures(a);
        (0..4).filter(|&m| m != self.reference).map(|m| p[m] / p[self.reference]).collect()
    }
}

impl Forward for Relative {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let flat = |p: Vec<C64>| p.iter().flat_map(|p| [p.re, p.im]).collect::<Vec<f64>>();
        let values = flat(self.relative(a));
        // First derivatives by complex quotient rule; the test is of the covariance, so Gauss-Newton is
        // enough.
        let p = Self::pressures(a);
        let slopes: Vec<Vec<f64>> = (0..3)
            .map(|i| {
                let d: Vec<C64> = (0..4)
                    .map(|m| {
                        let m = f64::from(m);
                        match i {
                            0 => C64::from_polar(1.0, m),
                            1 => C64::from_polar(1.0, -0.4 * m),
                            _ => C64::I * C64::from_polar(1.0, -0.4 * m),
                        }
                    })
                    .collect();
                let r = self.reference;
                flat((0..4).filter(|&m| m != r).map(|m| (d[m] - p[m] / p[r] * d[r]) / p[r]).collect())
            })
            .collect();
        Ok(Prediction { jacobian: Matrix::from_fn(6, 3, |k, i| slopes[i][k]), values, curvature: Vec::new() })
    }

    fn highest_order(&self) -> Order {
        Order::First
    }
}

#[test]
fn exact_choice_of_reference_microphone() {
    // To first order in the noise relative pressures carry the same information whatever the reference: at
    // one and the same parameters the Gauss-Newton matrix must not change when the noise of the reference is
    // shared properly.
    let a = [0.9, 0.4, -0.3];
    let matrix = |reference: usize| {
        let model = Relative { reference };
        let p = Relative::pressures(&a);
        let structure = relative_noise(&model.relative(&a));
        let scale = p[reference].norm_sqr();
        let values = model.predict(&a, Order::First).unwrap().values;
        let observation =
            Observation::new("ping", values).with_noise(0, Matrix::zeros(6, 6).plus(1.0 / scale, &structure));
        let data = Data::new(vec![observation], vec![NoiseGroup::fixed("pressure", "Pa", 0.01)]).unwrap();
        let parameters =
            Parameters::new((0..3).map(|i| normal(&format!("a{i}"), a[i], 10.0)).collect()).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap().gauss_newton
    };
    let base = matrix(0);
    for reference in 1..4 {
        let other = matrix(reference);
        for (x, y) in base.as_slice().iter().zip(other.as_slice()) {
            assert_relative_eq!(*x, *y, max_relative = 1e-10, epsilon = 1e-7);
        }
    }
}

#[test]
fn order_choice_of_reference_microphone_with_noise_in_the_data() {
    // The covariance of relative pressures is that of the noise to first order: the posterior and the Bayes
    // factor depend on the reference by terms of the noise squared, measured in posterior sd and in nats.
    let a = [0.9, 0.4, -0.3];
    let change = |sd: f64| {
        let noise = numbers("reference", 8);
        let p: Vec<C64> = Relative::pressures(&a)
            .into_iter()
            .enumerate()
            .map(|(m, p)| p + sd * C64::new(noise[2 * m], noise[2 * m + 1]))
            .collect();
        let fits: Vec<(Vec<f64>, Vec<f64>, f64)> = (0..4)
            .map(|reference| {
                let others: Vec<C64> =
                    (0..4).filter(|&m| m != reference).map(|m| p[m] / p[reference]).collect();
                let values = others.iter().flat_map(|z| [z.re, z.im]).collect();
                let scale = 1.0 / p[reference].norm_sqr();
                let structure = Matrix::zeros(6, 6).plus(scale, &relative_noise(&others));
                let observation = Observation::new("ping", values).with_noise(0, structure);
                let data =
                    Data::new(vec![observation], vec![NoiseGroup::fixed("pressure", "Pa", sd)]).unwrap();
                let model = Relative { reference };
                let fitted = |prior_sd: f64| {
                    let list = (0..3).map(|i| normal(&format!("a{i}"), 1.1 * a[i], prior_sd));
                    let parameters = Parameters::new(list.collect()).unwrap();
                    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
                    let laplace = posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap();
                    (laplace.parameters.clone(), laplace.sd(), laplace.evidence.ln_marginal)
                };
                let (narrow, wide) = (fitted(0.3), fitted(1.0));
                (narrow.0, narrow.1, narrow.2 - wide.2)
            })
            .collect();
        let mut largest = 0.0_f64;
        for (values, _, factor) in &fits {
            for i in 0..3 {
                largest = largest.max((values[i] - fits[0].0[i]).abs() / fits[0].1[i]);
            }
            largest = largest.max((factor - fits[0].2).abs());
        }
        largest
    };
    let changes = [change(1e-2), change(1e-3), change(1e-4)];
    assert!(changes[0] < 1e-3, "{changes:?}");
    for pair in changes.windows(2) {
        let order = (pair[0] / pair[1]).log10();
        assert!((order - 2.0).abs() < 0.1, "{changes:?}");
    }
}
