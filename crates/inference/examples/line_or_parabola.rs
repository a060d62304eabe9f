//! Two models of the same data, compared by evidence: `cargo run --release -p rijke-inference --example
//! line_or_parabola`.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

use rijke_inference::*;
use rijke_numerics::{Matrix, Order};

const X: [f64; 6] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];

/// y = a0 + a1 x + ..., with so many coefficients.
struct Polynomial(usize);

impl Forward for Polynomial {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let power = |k: usize, i: usize| X[k].powi(i as i32);
        Ok(Prediction {
            values: (0..X.len()).map(|k| (0..self.0).map(|i| a[i] * power(k, i)).sum()).collect(),
            jacobian: Matrix::from_fn(X.len(), self.0, power),
            curvature: vec![0.0; X.len() * self.0 * (self.0 + 1) / 2], // packed triangles
        })
    }
}

fn main() -> Result<(), InferenceError> {
    let observation = Observation::new("run 1", vec![1.1, 2.9, 5.2, 6.8, 9.1, 11.2]);
    let observation = observation.with_independent_noise(0, &[0, 1, 2, 3, 4, 5]);
    let data = Data::new(vec![observation], vec![NoiseGroup::fixed("voltage", "V", 0.1)])?;
    for (name, n) in [("line", 2), ("parabola", 3)] {
        let prior = Prior::Normal { mean: 0.0, sd: 10.0 };
        let coefficients = (0..n).map(|i| Parameter::new(format!("a{i}"), format!("a{i}"), "V", prior));
        let parameters = Parameters::new(coefficients.collect())?;
        let (model, options) = (Polynomial(n), MapOptions::default());
        let posterior = Posterior::new(&model, &data, &parameters)?;
        let laplace = posterior.laplace(&posterior.map(&options)?)?;
        println!("{name}: ln evidence {:.2} nats", laplace.evidence.ln_marginal);
    }
    Ok(())
}
