//! Models that the tests share.

use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_inference::*;
use rijke_numerics::{Cholesky, Matrix, Order, Stream, Streams};

/// f = X a.
pub(crate) struct Linear(pub(crate) Matrix);

impl Forward for Linear {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let p = self.0.columns();
        Ok(Prediction {
            values: self.0.times(a),
            jacobian: self.0.clone(),
            curvature: vec![0.0; self.0.rows() * p * (p + 1) / 2],
        })
    }
}

/// Numbers in -1..1 from a named stream.
pub(crate) fn numbers(name: &str, n: usize) -> Vec<f64> {
    let mut stream = Streams::new(11).stream(name);
    (0..n).map(|_| stream.random_range(-1.0..1.0)).collect()
}

/// A random design of m rows and p columns.
pub(crate) fn design(name: &str, m: usize, p: usize) -> Matrix {
    let x = numbers(name, m * p);
    Matrix::from_fn(m, p, |i, j| x[i * p + j])
}

/// A damped oscillation sampled at m times: values in pairs (in phase, in quadrature), parameters amplitude,
/// rate, frequency.
pub(crate) struct Ringing {
    pub(crate) times: Vec<f64>,
}

impl Forward for Ringing {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let mut out =
            Prediction { jacobian: Matrix::zeros(2 * self.times.len(), 3), ..Prediction::default() };
        for (k, &t) in self.times.iter().enumerate() {
            let (e, c, s) = ((-a[1] * t).exp(), (a[2] * t).cos(), (a[2] * t).sin());
            for (row, f, df) in [(2 * k, c, -s), (2 * k + 1, s, c)] {
                out.values.push(a[0] * e * f);
                out.jacobian[(row, 0)] = e * f;
                out.jacobian[(row, 1)] = -t * a[0] * e * f;
                out.jacobian[(row, 2)] = t * a[0] * e * df;
                out.curvature.extend([
                    0.0,
                    -t * e * f,
                    t * t * a[0] * e * f,
                    t * e * df,
                    -t * t * a[0] * e * df,
                    -t * t * a[0] * e * f,
                ]);
            }
        }
        Ok(out)
    }
}

pub(crate) fn normal(name: &str, mean: f64, sd: f64) -> Parameter {
    Parameter::new(name, name, "1", Prior::Normal { mean, sd })
}

/// Data as the model of a posterior with these working coordinates would give them: prediction plus noise.
pub(crate) fn simulate(posterior: &Posterior, working: &[f64], stream: &mut Stream) -> Data {
    let (parameters, data) = (posterior.parameters(), posterior.data());
    let physical = parameters.physical(&working[..parameters.len()]);
    let mut predicted = posterior.predict(&physical, Order::Value).unwrap().values.into_iter();
    let sds = posterior.noise_sd(working);
    let drawn = data.observations().iter().enumerate().map(|(k, observation)| {
        let xi: Vec<f64> = observation.values.iter().map(|_| stream.sample(StandardNormal)).collect();
        let noise = Cholesky::new(&posterior.covariance(k, &sds)).unwrap().lower().times(&xi);
        let values = noise.into_iter().zip(&mut predicted).map(|(noise, f)| f + noise).collect();
        Observation { values, ..observation.clone() }
    });
    Data::new(drawn.collect(), data.groups().to_vec()).unwrap()
}

/// Data of [`Ringing`] with every kind of noise: a full floor, a floating group, an inferred group.
pub(crate) fn ringing() -> (Ringing, Data, Parameters) {
    let model = Ringing { times: (0..12).map(|k| 0.25 * f64::from(k)).collect() };
    let truth = model.predict(&[1.3, 0.4, 2.1], Order::Value).unwrap().values;
    let noise = numbers("ringing", truth.len());
    let observations = (0..6)
        .map(|b| {
            let values = (4 * b..4 * b + 4).map(|i| truth[i] + 0.05 * noise[i]).collect();
            let floor = Matrix::from_fn(4, 4, |i, j| if i == j { 4e-4 } else { 1e-4 });
            Observation::new(format!("block {b}"), values)
                .with_floor(floor)
                .with_independent_noise(0, &[0, 2])
                .with_noise(1, Matrix::from_fn(4, 4, |i, j| f64::from(u8::from(i == j)) + 0.2))
        })
        .collect();
    let groups = vec![NoiseGroup::floated("in phase", "V"), NoiseGroup::inferred("all", "V", 0.03, 0.5)];
    let parameters = Parameters::new(vec![
        Parameter::new("amplitude", "A", "V", Prior::LogNormal { median: 1.0, ln_sd: 0.5 }),
        Parameter::new("rate", "r", "1/s", Prior::Uniform { low: 0.0, high: 2.0 }),
        normal("frequency", 2.0, 0.3),
    ])
    .unwrap();
    (model, Data::new(observations, groups).unwrap(), parameters)
}

/// Real and imaginary parts of exp(-i 2 pi f tau), one pair per frequency in Hz; tau in seconds.
pub(crate) struct Echo {
    pub(crate) frequencies: Vec<f64>,
    /// Says that it repeats with the mean period.
    pub(crate) declared: bool,
}

impl Forward for Echo {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let mut out =
            Prediction { jacobian: Matrix::zeros(2 * self.frequencies.len(), 1), ..Prediction::default() };
        for (k, f) in self.frequencies.iter().enumerate() {
            let w = 2.0 * std::f64::consts::PI * f;
            let (s, c) = (w * a[0]).sin_cos();
            out.values.extend([c, -s]);
            out.jacobian[(2 * k, 0)] = -w * s;
            out.jacobian[(2 * k + 1, 0)] = -w * c;
            out.curvature.extend([-w * w * c, w * w * s]);
        }
        Ok(out)
    }

    fn aliases(&self, a: &[f64]) -> Vec<Vec<f64>> {
        let period = self.frequencies.len() as f64 / self.frequencies.iter().sum::<f64>();
        if self.declared { vec![vec![a[0] - period], vec![a[0] + period]] } else { Vec::new() }
    }
}

/// f = a^2.
pub(crate) struct Square;

impl Forward for Square {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let jacobian = Matrix::from_fn(1, 1, |_, _| 2.0 * a[0]);
        Ok(Prediction { values: vec![a[0] * a[0]], jacobian, curvature: vec![2.0] })
    }
}
