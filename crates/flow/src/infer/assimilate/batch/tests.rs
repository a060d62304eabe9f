//! Whether the likelihood is what the data do: judged where the posterior's shape and the prior cannot blur
//! it.

use super::model::Batch;
use super::whitening::Whitening;
use crate::TubeRig;
use crate::infer::assimilate::ambient::smooth_ambient;
use crate::infer::assimilate::twin::{Twin, TwinOptions, staircase};
use crate::tube::closures::Closures;
use crate::tube::parameters::{UNKNOWNS, unknowns};
use crate::tube::pipe::Pipe;
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use rijke_inference::Forward;
use rijke_numerics::{Cholesky, Matrix, Order, Streams, symmetric_eigen};

/// A batch taken to first order at the truth.
struct Linear {
    /// Whitened readings less the model's at the truth: noise with unit covariance, if the likelihood is
    /// right.
    residual: Vec<f64>,
    across: Matrix,
    information: Matrix,
}

impl Linear {
    fn new(batch: &Batch<'_>, ambient: &[f64], truth: &[f64]) -> Self {
        let batch = Batch { ambient: ambient.to_vec(), ..batch.clone() };
        let at = batch.predict(truth, Order::First).unwrap();
        let data = batch.whitening.apply(batch.means.clone());
        let residual = data.iter().zip(&at.values).map(|(m, p)| m - p).collect();
        let across = at.jacobian.transpose();
        let information = across.product(&at.jacobian);
        Self { residual, across, information }
    }

    /// The residual along each direction of the readings that the scores can move: standard normal.
    fn directions(&self) -> Vec<f64> {
        let (values, vectors) = symmetric_eigen(&self.information).unwrap();
        let moved = vectors.transpose().times(&self.across.times(&self.residual));
        moved.iter().zip(values).map(|(m, v)| m / v.sqrt()).collect()
    }

    /// Error over sd of the unknowns in the linear model with noise `residual` and true scores `scores`.
    fn pulls(&self, residual: &[f64], scores: &[f64]) -> Vec<f64> {
        let unit = Matrix::identity(scores.len());
        let precision = Cholesky::new(&self.information.plus(1.0, &unit)).unwrap();
        let pull = self.across.times(residual);
        let pull: Vec<f64> = pull.iter().zip(scores).map(|(p, z)| p - z).collect();
        let (off, covariance) = (precision.solve(&pull), precision.inverse());
        (0..UNKNOWNS).map(|k| off[k] / covariance[(k, k)].sqrt()).collect()
    }
}

/// What is done about the error of the smoothed room temperature.
const WAYS: [&str; 3] = ["known exactly", "in the noise", "ignored"];

/// The readings of one twin in each of [`WAYS`], with its true scores.
fn linear(pipe: &Pipe, options: &TwinOptions, seed: u64) -> ([Linear; 3], Vec<f64>) {
    let twin = Twin::new(pipe, options, &Streams::new(seed), None).unwrap();
    let record = twin.record.checked(pipe).unwrap();
    let batch = Batch::new(pipe, &record, 10).unwrap();
    let sd = vec![record.sensors[0].sd / 10_f64.sqrt(); batch.means.len()];
    let plain =
        Batch { whitening: Whitening::new(sd, &[], &smooth_ambient(&record), 10).unwrap(), ..batch.clone() };
    let at = |batch: &Batch<'_>, ambient: &[f64]| Linear::new(batch, ambient, &twin.scores);
    ([at(&plain, &twin.ambient), at(&batch, &batch.ambient), at(&plain, &batch.ambient)], twin.scores)
}

fn pipe() -> Pipe {
    Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), 0.25, 1).unwrap()
}

fn mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    sum / count
}

/// 30 twins with 18 directions each: the mean of 540 squares has the sd 0.06.
#[test]
fn exact_noise_has_unit_variance_along_what_the_unknowns_move() {
    let options = TwinOptions { powers: staircase(&[0.0, 30.0, 180.0], 60), ..TwinOptions::default() };
    let runs: Vec<_> = (0..30_u64).into_par_iter().map(|seed| linear(&pipe(), &options, seed).0).collect();
    let [known, noise, ignored] =
        [0, 1, 2].map(|way| mean_square(runs.iter().flat_map(|ways| ways[way].directions())));
    assert!((0.8..1.2).contains(&known) && (0.8..1.2).contains(&noise), "{known} {noise}");
    assert!(ignored > 1.3, "{ignored}");
}

#[test]
#[ignore = "long: 100 twins, three minutes of CPU"]
#[allow(clippy::print_stdout, reason = "the table is what this study is for")]
fn lab_the_likelihood_is_what_the_data_do() {
    let seeds: u64 = std::env::var("SEEDS").map_or(100, |s| s.parse().unwrap());
    let pipe = pipe();
    // Per way: along directions, and pulls of the noise and of white noise with true scores drawn afresh or
    // as they were.
    let one = |seed| {
        let (ways, truth) = linear(&pipe, &TwinOptions::default(), seed);
        let mut stream = Streams::new(seed).stream("afresh");
        let mut draw = |n: usize| -> Vec<f64> { (0..n).map(|_| stream.sample(StandardNormal)).collect() };
        ways.map(|linear| {
            let (fresh, white) = (draw(truth.len()), draw(linear.residual.len()));
            let pulls = [(&linear.residual, &fresh), (&linear.residual, &truth), (&white, &truth)];
            (linear.directions(), pulls.map(|(residual, scores)| linear.pulls(residual, scores)))
        })
    };
    let runs: Vec<_> = (0..seeds).into_par_iter().map(one).collect();
    println!("mean squares, {seeds} twins; scores drawn afresh | as they were | and white noise");
    for (way, name) in WAYS.into_iter().enumerate() {
        let all = mean_square(runs.iter().flat_map(|r| r[way].0.clone()));
        println!("room temperature {name}: along all directions {all:.3}");
        for (k, unknown) in unknowns().iter().enumerate() {
            let square = |kind: usize| mean_square(runs.iter().map(|r| r[way].1[kind][k]));
            println!("  {} {:.2} | {:.2} | {:.2}", unknown.name, square(0), square(1), square(2));
        }
        let expected = if way == 2 { 1.3..9.0 } else { 0.9..1.1 };
        assert!(expected.contains(&all), "{name}: {all}");
    }
}
