//! A static problem: the filter that takes the data bit by bit against one batch fit of all of them.

use super::*;
use crate::{
    Data, Forward, ForwardError, MapOptions, NoiseGroup, Observation, Parameter, Parameters, Posterior,
    Prediction, Prior,
};
use rijke_numerics::{Matrix, Order, Streams};

/// y = a e^{-b t}.
struct Decay(Vec<f64>);

impl Forward for Decay {
    fn predict(&self, p: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let e: Vec<f64> = self.0.iter().map(|t| (-p[1] * t).exp()).collect();
        Ok(Prediction {
            values: e.iter().map(|e| p[0] * e).collect(),
            jacobian: Matrix::from_fn(
                e.len(),
                2,
                |k, i| if i == 0 { e[k] } else { -self.0[k] * p[0] * e[k] },
            ),
            curvature: (0..e.len())
                .flat_map(|k| {
                    let t = self.0[k];
                    [0.0, -t * e[k], t * t * p[0] * e[k]]
                })
                .collect(),
        })
    }
}

#[test]
fn oracle_filter_of_a_static_problem_is_the_batch_fit() {
    const SD: f64 = 0.05;
    let priors = [(1.0, 0.3), (0.8, 0.3)];
    let model = Decay((0..60).map(|k| 0.05 * f64::from(k)).collect());
    let (mut ratios, mut misses) = (Vec::new(), Vec::new());
    for seed in 0..10 {
        let mut stream = Streams::new(seed).stream("static");
        let noise = forcing::normal_matrix(1, 60, &mut stream);
        let truth = model.predict(&[1.2, 0.6], Order::Value).unwrap().values;
        let measured: Vec<f64> = truth.iter().zip(noise.row(0)).map(|(y, n)| y + SD * n).collect();

        let list = ["a", "b"]
            .iter()
            .zip(priors)
            .map(|(name, (mean, sd))| Parameter::new(*name, *name, "1", Prior::Normal { mean, sd }));
        let parameters = Parameters::new(list.collect()).unwrap();
        let all: Vec<usize> = (0..60).collect();
        let observation = Observation::new("all", measured.clone()).with_independent_noise(0, &all);
        let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", SD)]).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let batch = posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap();

        let members = 100;
        let unit = forcing::normal_matrix(members, 2, &mut stream);
        let rows = Matrix::from_fn(members, 2, |i, j| priors[j].0 + priors[j].1 * unit[(i, j)]);
        let mut ensemble = Ensemble::new(rows).unwrap();
        for first in (0..60).step_by(3) {
            let bit = Decay(model.0[first..first + 3].to_vec());
            let rows: Vec<Vec<f64>> = (0..members)
                .map(|i| bit.predict(ensemble.members().row(i), Order::Value).unwrap().values)
                .collect();
            let predicted = Matrix::from_fn(members, 3, |i, j| rows[i][j]);
            let noise = NoiseCovariance::Independent(vec![SD * SD; 3]);
            let observed =
                EnsembleData { predicted: &predicted, measured: &measured[first..first + 3], noise: &noise };
            ensemble.analyse(&observed, Scheme::SquareRoot, &mut stream).unwrap();
        }
        for i in 0..2 {
            ratios.push(ensemble.spread()[i] / batch.sd()[i]);
            misses.push((ensemble.mean()[i] - batch.parameters[i]) / ensemble.spread()[i]);
        }
    }
    println!("filter sd / batch sd {ratios:.3?}\nfilter - batch in filter sd {misses:.3?}");
    assert!(misses.iter().all(|m| m.abs() < 0.3), "{misses:?}");
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!((0.95..1.1).contains(&mean), "{mean} {ratios:?}");
}
