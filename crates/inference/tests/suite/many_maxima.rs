//! Posteriors of dozens of equal maxima against quadrature: all are found, or a warning says that they are
//! not.

use crate::problems::normal;
use rijke_inference::*;
use rijke_numerics::{Matrix, Order};

const SD: f64 = 0.05;

/// cos(w a + k/100) for k = 0..8: two maxima in each period 2 pi/w, which 8 data hardly tell apart.
struct Wave(f64);

impl Forward for Wave {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let w = self.0;
        let phases: Vec<f64> = (0..8).map(|k| w * a[0] + 0.01 * f64::from(k)).collect();
        Ok(Prediction {
            values: phases.iter().map(|p| p.cos()).collect(),
            jacobian: Matrix::from_fn(8, 1, |k, _| -w * phases[k].sin()),
            curvature: phases.iter().map(|p| -w * w * p.cos()).collect(),
        })
    }
}

fn data(model: &Wave, truth: f64) -> Data {
    let values = model.predict(&[truth], Order::Value).unwrap().values;
    let observation = Observation::new("wave", values).with_independent_noise(0, &[0, 1, 2, 3, 4, 5, 6, 7]);
    Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", SD)]).unwrap()
}

/// ln of the evidence by quadrature over nine prior sd on either side of the prior N(mean, 1).
fn quadrature(posterior: &Posterior, mean: f64) -> f64 {
    let n = 400_000;
    let h = 18.0 / f64::from(n);
    let ln: Vec<f64> = (0..n)
        .map(|k| mean - 9.0 + (f64::from(k) + 0.5) * h)
        .map(|a| -posterior.evaluate(&[a], Order::Value).unwrap().value)
        .collect();
    let best = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    best + (ln.iter().map(|l| (l - best).exp()).sum::<f64>() * h).ln()
}

struct Found {
    ln: f64,
    exact: f64,
    importance: Importance,
    open: bool,
    words: String,
}

fn found(w: f64, mean: f64, truth: f64, alias: Option<Alias>, options: &AssessOptions) -> Found {
    let model = Wave(w);
    let data = data(&model, truth);
    let mut parameters = Parameters::new(vec![normal("a", mean, 1.0)]).unwrap();
    if let Some(alias) = alias {
        parameters = parameters.with_alias(alias).unwrap();
    }
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let exact = quadrature(&posterior, mean);
    let a = posterior.assess(options).unwrap();
    let (ln, importance) = (a.evidence.unwrap().ln_marginal, a.health.importance.unwrap());
    let words = a.health.warnings.join("; ");
    println!(
        "w {w}: ln {ln:.3} of {exact:.3}, {} maxima, {} starts, {words:.300}",
        a.maxima.len(),
        a.health.starts
    );
    let open = words.contains("the evidence may be too low");
    Found { ln, exact, importance, open, words }
}

/// What images that are left out may hold of the evidence, nats, for both maxima of a period.
const LEFT_OUT: f64 = 2e-3;

/// Laplace's own error: where the two maxima of a period lie 0.28 rad from where they meet, four of their
/// standard deviations of 0.07 rad, the well is no parabola; importance sampling mends that.
fn close(a: &Found) {
    assert!((a.ln - a.exact).abs() < 0.15, "{} of {}", a.ln, a.exact);
    let Importance { ln_marginal, standard_error, .. } = a.importance;
    assert!(
        (ln_marginal - a.exact).abs() < 4.0 * standard_error + LEFT_OUT,
        "{ln_marginal} +- {standard_error} of {}",
        a.exact
    );
}

#[test]
fn oracle_all_images_of_both_maxima_of_a_period_are_summed() {
    for (w, mean, truth) in
        [(20.0, 0.0, 0.3), (20.0, 2.0, -1.0), (20.0, 0.0, 0.08), (7.0, 0.0, 0.25), (60.0, -1.0, 0.1)]
    {
        let period = Alias::period("a", std::f64::consts::TAU / w);
        let a = found(w, mean, truth, Some(period), &AssessOptions::default());
        close(&a);
        assert!(!a.open);
    }
}

#[test]
fn behaviour_a_search_that_ran_out_of_starts_says_so() {
    let a = found(20.0, 0.0, 0.3, None, &AssessOptions::default());
    assert!(a.ln < a.exact - 0.2 && a.words.contains("32 starts are too few"), "{} of {}", a.ln, a.exact);
    // Starts that are allowed are used, beyond the first sample of the prior.
    let more = AssessOptions { most_starts: 2000, ..AssessOptions::default() };
    let a = found(20.0, 0.0, 0.3, None, &more);
    // A basin that no start fell into is left: 0.05 nats of this sum.
    assert!((a.ln - a.exact).abs() < 0.2 && !a.open, "{} of {}", a.ln, a.exact);
}

#[test]
fn behaviour_more_images_than_are_looked_at_are_said() {
    let w = 800.0;
    let a =
        found(w, 0.0, 0.3, Some(Alias::period("a", std::f64::consts::TAU / w)), &AssessOptions::default());
    assert!(a.words.contains("aliases lead to more maxima than"), "{}", a.words);
}
