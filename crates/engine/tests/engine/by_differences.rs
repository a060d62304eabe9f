//! A study of one stage against the same by differences through the text of its network file.

use crate::differences;
use rijke_engine::run::{Run, Trusted};
use rijke_inference::{
    Data, Forward, MapOptions, NoiseGroup, Observation, Parameter, Parameters, Posterior, Prediction,
};
use rijke_numerics::{Matrix, Order};
use rijke_study::OneTable;
use std::f64::consts::TAU;
use std::path::Path;

#[test]
fn oracle_a_ducted_flame_has_the_fit_that_differences_give() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/ducted-flame");
    let table = OneTable::read(&folder.join("second-order.toml"), &folder.join("modes.csv")).unwrap();
    let (study, observations) = table.study().unwrap();
    let priors: Vec<Parameter> = study.rig.own.parameters.clone();
    let stage = Run::new(study, &observations, Trusted::Laplace).unwrap().next_stage().unwrap().unwrap();
    let ours = &stage.models[0];

    let slow = differences::ducted_flame();
    let rows = slow.modes.iter().map(|(_, length, mode)| {
        Observation::new(format!("{length} m"), mode.to_vec())
            .with_floor(Matrix::diagonal(&[1.0, (TAU * 0.2).powi(2)]))
            .with_independent_noise(0, &[0])
            .with_independent_noise(1, &[1])
    });
    let groups = vec![NoiseGroup::floated("growth rate", "1/s"), NoiseGroup::floated("frequency", "rad/s")];
    let data = Data::new(rows.collect(), groups).unwrap();
    let of_name = |(name, _): &(String, f64)| priors.iter().find(|p| p.name == *name).unwrap().clone();
    let parameters = Parameters::new(slow.unknowns.iter().map(of_name).collect()).unwrap();
    let posterior = Posterior::new(&slow, &data, &parameters).unwrap();
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let laplace = posterior.laplace(&fit).unwrap();
    let theirs = laplace.evidence;
    let found = ours.evidence.unwrap();
    assert!((found.ln_best_fit - theirs.ln_best_fit).abs() < 1e-6, "{found:?} {theirs:?}");
    for ((name, _), (value, sd)) in slow.unknowns.iter().zip(fit.parameters.iter().zip(laplace.sd())) {
        let here = ours.parameters.iter().find(|p| p.name == *name).unwrap();
        assert!((here.value - value).abs() < 1e-3 * sd, "{name}: {} {value}", here.value);
    }

    // The Occam factor needs the curvature of the model, here by differences of differences.
    let curved = Curved(&slow);
    let curved = Posterior::new(&curved, &data, &parameters).unwrap();
    let theirs = curved.laplace(&curved.map(&MapOptions::default()).unwrap()).unwrap().evidence;
    assert!((found.ln_marginal - theirs.ln_marginal).abs() < 1e-3, "{found:?} {theirs:?}");
}

/// With second derivatives too.
struct Curved<'a>(&'a differences::ByDifferences);

impl Forward for Curved<'_> {
    fn predict(&self, at: &[f64], order: Order) -> Result<Prediction, rijke_inference::ForwardError> {
        let mut found = self.0.predict(at, order)?;
        if order == Order::Second {
            let n = found.values.len();
            let columns = self.0.unknowns.iter().enumerate().map(|(i, (_, step))| {
                let wide = 20.0 * step;
                let side = |sign: f64| {
                    let mut moved = at.to_vec();
                    moved[i] += sign * wide;
                    self.0.predict(&moved, Order::First)
                };
                let (up, down) = (side(1.0)?.jacobian, side(-1.0)?.jacobian);
                Ok(Matrix::from_fn(n, at.len(), |row, j| (up[(row, j)] - down[(row, j)]) / (2.0 * wide)))
            });
            let columns = columns.collect::<Result<Vec<_>, rijke_inference::ForwardError>>()?;
            for row in 0..n {
                for i in 0..at.len() {
                    for j in 0..=i {
                        found.curvature.push(0.5 * (columns[i][(row, j)] + columns[j][(row, i)]));
                    }
                }
            }
        }
        Ok(found)
    }

    fn highest_order(&self) -> Order {
        Order::Second
    }
}
