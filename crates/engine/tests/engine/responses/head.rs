//! The errors of the measuring head.

use super::bench::{folder, heard, model, normal, polynomials, reflection, rig, trained};
use super::slow::maximum;
use rijke_inference::complex_columns;
use rijke_numerics::{C64, Cholesky, Matrix, Streams};
use std::f64::consts::PI;

const AIR: [f64; 2] = [293.15; 2];
/// Mean and sd of the priors.
const PRIORS: [[f64; 2]; 3] = [[0.1, 0.003], [5e-3, 2e-4], [0.9, 0.05]];

/// The cost of the slow route, nats: errors of the head about the R of these very parameters.
struct Full<'a> {
    frequency_hz: &'a [f64],
    values: &'a [C64],
    terms: &'a [(i32, f64)],
    count: usize,
    noise: f64,
    /// Size and length of a misfit with a squared exponential.
    misfit: [f64; 2],
    slow: f64,
}

impl Full<'_> {
    /// At prior standard deviations from the means.
    fn cost(&self, x: [f64; 3]) -> f64 {
        let parameters = [0, 1, 2].map(|i| PRIORS[i][0] + PRIORS[i][1] * x[i]);
        let answers: Vec<C64> =
            self.frequency_hz.iter().map(|f| reflection(*f, parameters, self.slow, AIR)).collect();
        let basis = polynomials(self.frequency_hz, self.count);
        let column = |(power, sd): &(i32, f64), j: usize| -> Vec<C64> {
            answers.iter().zip(&basis).map(|(r, row)| r.powi(*power) * (sd * row[j])).collect()
        };
        let columns: Vec<Vec<C64>> =
            self.terms.iter().flat_map(|term| (0..self.count).map(move |j| column(term, j))).collect();
        let u = complex_columns(&columns);
        let n = 2 * answers.len();
        let [size, length] = self.misfit;
        let rest = Matrix::from_fn(n, n, |i, j| {
            let distance = (self.frequency_hz[i / 2] - self.frequency_hz[j / 2]) / length;
            let smooth = if i % 2 == j % 2 { size * size * (-0.5 * distance * distance).exp() } else { 0.0 };
            smooth + if i == j { self.noise * self.noise } else { 0.0 }
        });
        let factor = Cholesky::new(&u.large_product(&u.transpose()).plus(1.0, &rest)).unwrap();
        let residuals: Vec<f64> =
            self.values.iter().zip(&answers).flat_map(|(y, r)| [y.re - r.re, y.im - r.im]).collect();
        let square: f64 = factor.whiten(&residuals).iter().map(|r| r * r).sum();
        let prior = x.iter().map(|x| x * x).sum::<f64>() + 3.0 * (2.0 * PI).ln();
        0.5 * (square + factor.ln_det() + n as f64 * (2.0 * PI).ln() + prior)
    }

    /// Values and standard deviations at the maximum next to `near`, and ln of the evidence by Laplace's
    /// method.
    fn found(&self, near: [[f64; 2]; 3]) -> ([[f64; 2]; 3], f64) {
        maximum(&PRIORS, &near, &|x| self.cost(x))
    }
}

fn toml(terms: &[(i32, f64)], count: usize) -> String {
    let one = |(power, sd): &(i32, f64)| format!("{{ power = {power}, functions = {count}, sd = {sd} }}");
    format!("[{}]", terms.iter().map(one).collect::<Vec<_>>().join(", "))
}

fn truth(stream: &mut rijke_numerics::Stream) -> [f64; 3] {
    PRIORS.map(|[mean, sd]| mean + 0.7 * sd * normal(stream))
}

#[test]
fn oracle_errors_of_the_head_are_those_about_the_answer_of_the_model() {
    let frequency_hz: Vec<f64> = (0..80).map(|k| 100.0 + 36.0 * f64::from(k)).collect();
    let noise = 3e-3;
    let cases = [
        (vec![(0, 0.05), (1, 0.05)], 5, [0.0, 100.0]),
        (vec![(0, 0.05), (1, 0.05), (2, 0.05)], 5, [0.0, 100.0]),
        (vec![(0, 0.02), (1, 0.02)], 5, [4e-3, 120.0]),
        (vec![(1, 0.05)], 1, [0.0, 100.0]),
    ];
    for (k, (terms, count, misfit)) in cases.iter().enumerate() {
        let (terms, count, misfit) = (terms.as_slice(), *count, *misfit);
        for seed in 0..3 {
            let mut stream = Streams::new(seed).stream("responses/head");
            let parameters = truth(&mut stream);
            let answers: Vec<C64> =
                frequency_hz.iter().map(|f| reflection(*f, parameters, 0.0, AIR)).collect();
            let values = heard(&frequency_hz, &answers, terms, count, noise, &mut stream);
            let more = if misfit[0] > 0.0 {
                format!(
                    "noise = {noise}\nmisfit = {{ size = {}, length_hz = {}, kernel = \"squared_exponential\" }}",
                    misfit[0], misfit[1]
                )
            } else {
                format!("noise = {noise}")
            };
            let folder = folder(&format!("head-{k}"), &rig([None; 2]), "ambient", &toml(terms, count), &more);
            let stage = trained(&folder, &frequency_hz, &values).unwrap();
            let mut evidences = Vec::new();
            for (id, slow) in [("end.constant", 0.0), ("end.slow", 1e-5)] {
                let found = model(&stage, id);
                let near = ["l2", "b2", "eta"].map(|name| {
                    let p = found.parameters.iter().find(|p| p.name == name).unwrap();
                    [p.value, p.sd]
                });
                let full =
                    Full { frequency_hz: &frequency_hz, values: &values, terms, count, noise, misfit, slow };
                let (ends, evidence) = full.found(near);
                evidences.push([found.ln_evidence(), evidence]);
                for (a, b) in near.iter().zip(&ends) {
                    assert!((a[0] - b[0]).abs() < 0.02 * b[1], "case {k}, {seed}, {id}: {near:?} {ends:?}");
                    assert!((a[1] / b[1]).ln().abs() < 0.1, "case {k}, {seed}, {id}: {near:?} {ends:?}");
                }
            }
            for [found, full] in &evidences {
                assert!((found - full).abs() < 0.1, "case {k}, {seed}: {evidences:?}");
            }
        }
    }
}

#[test]
fn coverage_parameters_heard_by_a_bad_head_lie_within_their_errors() {
    let frequency_hz: Vec<f64> = (0..60).map(|k| 100.0 + 48.0 * f64::from(k)).collect();
    let terms = [(0, 0.05), (1, 0.05)];
    let more = "among = [\"end.constant\"]\nnoise = { median = 3e-3, ln_sd = 1.0 }";
    let folder = folder("coverage", &rig([None; 2]), "ambient", &toml(&terms, 6), more);
    let (mut within, mut all, mut square) = (0, 0, 0.0);
    for set in 0..200 {
        let mut stream = Streams::new(set).stream("responses/coverage");
        let parameters = PRIORS.map(|[mean, sd]| mean + sd * normal(&mut stream));
        let answers: Vec<C64> = frequency_hz.iter().map(|f| reflection(*f, parameters, 0.0, AIR)).collect();
        let values = heard(&frequency_hz, &answers, &terms, 6, 3e-3, &mut stream);
        let stage = trained(&folder, &frequency_hz, &values).unwrap();
        for (name, truth) in ["l2", "b2", "eta"].iter().zip(parameters) {
            let p = stage.models[0].parameters.iter().find(|p| p.name == *name).unwrap();
            let z = (p.value - truth) / p.sd;
            (within, all, square) = (within + usize::from(z.abs() < 2.0), all + 1, square + z * z);
        }
    }
    let (share, rms) = (f64::from(within as u32) / f64::from(all), (square / f64::from(all)).sqrt());
    assert!((0.92..0.98).contains(&share), "{within} of {all}");
    assert!((0.85..1.15).contains(&rms), "{rms}");
}
