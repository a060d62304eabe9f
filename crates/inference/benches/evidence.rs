//! What an evidence costs by Laplace's method, with its checks, and by nested sampling to 0.5 nat.

#![allow(clippy::unwrap_used, missing_docs, reason = "a bench; its macros make undocumented functions")]

use criterion::{Criterion, criterion_group, criterion_main};
use rand::RngExt;
use rijke_inference::*;
use rijke_numerics::{Matrix, Order, Streams};

/// 105 blocks of 16 data, six parameters: the size of Table 4. f = exp(x'a).
struct Regression {
    x: Matrix,
}

impl Forward for Regression {
    fn predict(&self, a: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let (m, p) = (self.x.rows(), self.x.columns());
        let values: Vec<f64> = self.x.times(a).iter().map(|v| v.exp()).collect();
        if order == Order::Value {
            return Ok(Prediction { values, ..Prediction::default() });
        }
        let jacobian = Matrix::from_fn(m, p, |k, i| values[k] * self.x[(k, i)]);
        let mut curvature = Vec::new();
        if order == Order::Second {
            curvature.reserve(m * p * (p + 1) / 2);
            for k in 0..m {
                for i in 0..p {
                    for j in 0..=i {
                        curvature.push(values[k] * self.x[(k, i)] * self.x[(k, j)]);
                    }
                }
            }
        }
        Ok(Prediction { values, jacobian, curvature })
    }
}

fn problem() -> (Regression, Data, Parameters) {
    let (blocks, n, p) = (105, 16, 6);
    let mut stream = Streams::new(1).stream("bench");
    let x: Vec<f64> = (0..blocks * n * p).map(|_| stream.random_range(-1.0..1.0)).collect();
    let model = Regression { x: Matrix::from_fn(blocks * n, p, |k, i| x[k * p + i]) };
    let truth = model.predict(&[0.5, -0.3, 0.2, 0.1, -0.6, 0.4], Order::Value).unwrap().values;
    let noise: Vec<f64> = truth.iter().map(|_| stream.random_range(-0.1..0.1)).collect();
    let observations = (0..blocks).map(|b| {
        let values = (b * n..(b + 1) * n).map(|k| truth[k] + noise[k]).collect();
        Observation::new(format!("{b}"), values)
            .with_independent_noise(0, &[0])
            .with_independent_noise(1, &[1])
            .with_independent_noise(2, &(2..n).collect::<Vec<_>>())
    });
    let groups = ["growth rate", "frequency", "pressure"].map(|g| NoiseGroup::floated(g, "1"));
    let data = Data::new(observations.collect(), groups.to_vec()).unwrap();
    let normal = |i: usize| Parameter::new(format!("a{i}"), "a", "1", Prior::Normal { mean: 0.0, sd: 1.0 });
    (model, data, Parameters::new((0..p).map(normal).collect()).unwrap())
}

fn evidence(c: &mut Criterion) {
    let (model, data, parameters) = problem();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let mut group = c.benchmark_group("evidence of a model of Table 4's size");
    group.sample_size(10);
    group.bench_function("MAP by BFGS, Laplace", |b| {
        b.iter(|| posterior.laplace(&posterior.map(&MapOptions::bfgs()).unwrap()).unwrap().evidence)
    });
    group.bench_function("MAP by Newton, Laplace", |b| {
        b.iter(|| posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap().evidence)
    });
    group.bench_function("with all checks", |b| {
        b.iter(|| posterior.assess(&AssessOptions::default()).unwrap().health)
    });
    group.finish();

    // A small problem, on which the sampler ends within seconds.
    let few =
        Data::new(data.observations()[..2].to_vec(), vec![NoiseGroup::fixed("noise", "1", 0.2); 3]).unwrap();
    let small = Regression { x: Matrix::from_fn(32, 6, |k, i| model.x[(k, i)]) };
    let posterior = Posterior::new(&small, &few, &parameters).unwrap();
    let mut group = c.benchmark_group("evidence of a small model");
    group.sample_size(10);
    group.bench_function("Laplace", |b| {
        b.iter(|| posterior.laplace(&posterior.map(&MapOptions::default()).unwrap()).unwrap().evidence)
    });
    let fit = posterior.map(&MapOptions::default()).unwrap();
    let information = -posterior.laplace(&fit).unwrap().evidence.ln_occam;
    let target = LikelihoodTarget::new(&posterior, &fit).unwrap();
    let nested = Nested::with_error(0.5, information, target.size(), Streams::new(1));
    group.bench_function("nested sampling to 0.5 nat", |b| b.iter(|| nested.integrate(&target).unwrap()));
    group.finish();
}

/// Cost, gradient and Hessian of one block of 112 numbers and 20 parameters with four floated noises: of 8
/// numbers each, of 96, and along one direction of all; and with noises that are nearly the same but act on
/// every pair of numbers along every direction.
fn installation(c: &mut Criterion) {
    let (n, p) = (112, 20);
    let mut stream = Streams::new(2).stream("installation");
    let mut random = |rows: usize, columns: usize| {
        let all: Vec<f64> = (0..rows * columns).map(|_| stream.random_range(-1.0..1.0)).collect();
        Matrix::from_fn(rows, columns, |i, j| all[i * columns + j])
    };
    let model = Regression { x: random(n, p) };
    let direction = random(n, 1);
    let everywhere = random(n, n);
    let everywhere = everywhere.product(&everywhere.transpose());
    let of = |from: usize, to: usize| {
        let one = |i: usize| f64::from(u8::from((from..to).contains(&i)));
        Matrix::diagonal(&(0..n).map(one).collect::<Vec<_>>())
    };
    let noises = [of(0, 8), of(8, 16), of(16, n), direction.product(&direction.transpose())];
    let groups = ["growth rate", "frequency", "pressure", "varying"].map(|g| NoiseGroup::floated(g, "1"));
    let normal = |i: usize| Parameter::new(format!("a{i}"), "a", "1", Prior::Normal { mean: 0.0, sd: 1.0 });
    let parameters = Parameters::new((0..p).map(normal).collect()).unwrap();
    let mut group = c.benchmark_group("a block of 112 numbers");
    for (name, share) in [("noises of few numbers or directions", 0.0), ("noises of all", 1e-9)] {
        let block = Observation::new("installation", vec![1.0; n]).with_floor(Matrix::identity(n));
        let noises = noises.iter().map(|s| s.plus(share, &everywhere));
        let block = noises.enumerate().fold(block, |block, (g, s)| block.with_noise(g, s));
        let data = Data::new(vec![block], groups.to_vec()).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let z = [vec![0.1; p], vec![-0.5; 4]].concat();
        group.bench_function(name, |b| b.iter(|| posterior.evaluate(&z, Order::Second).unwrap()));
    }
    group.finish();
}

criterion_group!(benches, evidence, installation);
criterion_main!(benches);
