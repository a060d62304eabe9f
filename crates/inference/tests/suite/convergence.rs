//! A search has converged when nothing that matters is left to gain.

use crate::problems::{normal, numbers};
use rijke_inference::*;
use rijke_numerics::{Matrix, Order};

/// exp(x'a) with an error of its own that changes with every bit of `a`: the end of an iteration, say of an
/// eigenvalue.
struct Iterated {
    x: Matrix,
    error: f64,
}

impl Forward for Iterated {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let (m, p) = (self.x.rows(), self.x.columns());
        let smooth: Vec<f64> = self.x.times(a).iter().map(|v| v.exp()).collect();
        let seed = a.iter().fold(17_u64, |h, v| (h ^ v.to_bits()).wrapping_mul(0x0100_0000_01b3));
        let hash = |k: usize| {
            let mut h = seed ^ (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            h = (h ^ (h >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            ((h >> 11) as f64) / ((1_u64 << 53) as f64) - 0.5
        };
        Ok(Prediction {
            values: smooth.iter().enumerate().map(|(k, v)| v + self.error * hash(k)).collect(),
            jacobian: Matrix::from_fn(m, p, |k, i| smooth[k] * self.x[(k, i)]),
            curvature: Vec::new(),
        })
    }

    fn highest_order(&self) -> Order {
        Order::First
    }
}

#[test]
fn behaviour_many_data_with_floated_noise_converge_by_nats() {
    // As many numbers as 64 microphones give at some hundred points. The errors of the model leave about 1e-6
    // nats that no step can gain: of old the search ended with "too many evaluations" or "no shorter step
    // helps".
    let (blocks, n, p) = (300, 40, 8);
    let x = numbers("iterated/x", blocks * n * p);
    let x = Matrix::from_fn(blocks * n, p, |k, i| x[k * p + i]);
    let truth: Vec<f64> = (0..p).map(|i| 0.3 - 0.1 * i as f64).collect();
    for error in [0.0, 1e-4, 1e-3] {
        let model = Iterated { x: x.clone(), error };
        let values = model.predict(&truth, Order::Value).unwrap().values;
        let noise = numbers("iterated/y", values.len());
        let observations = (0..blocks).map(|b| {
            let values = (b * n..(b + 1) * n).map(|k| values[k] + 0.2 * noise[k]).collect();
            Observation::new(format!("{b}"), values)
                .with_independent_noise(0, &(0..2).collect::<Vec<_>>())
                .with_independent_noise(1, &(2..n).collect::<Vec<_>>())
        });
        let groups = ["frequency", "pressure"].map(|g| NoiseGroup::floated(g, "1"));
        let data = Data::new(observations.collect(), groups.to_vec()).unwrap();
        let parameters =
            Parameters::new((0..p).map(|i| normal(&format!("a{i}"), 0.0, 1.0)).collect()).unwrap();
        let posterior = Posterior::new(&model, &data, &parameters).unwrap();
        let search = TrustRegion { tolerance: 1e-10, max_evaluations: 120, ..TrustRegion::default() };
        let fit = posterior.map(&MapOptions { search, start: None }).unwrap();
        println!("{error}: {} after {:?}", fit.stop, fit.calls);
        let Stop::Converged { decrement } = fit.stop else { panic!("{error}: {}", fit.stop) };
        assert!(decrement < 1e-4 && fit.calls.total() <= 120, "{error}: {decrement} {:?}", fit.calls);
        let laplace = posterior.laplace(&fit).unwrap();
        for (i, sd) in laplace.sd().into_iter().enumerate() {
            assert!((fit.parameters[i] - truth[i]).abs() < 4.5 * sd, "{error}: {i}");
        }
    }
}

#[test]
fn behaviour_a_cap_far_from_the_maximum_is_no_convergence() {
    let (model, data, parameters) = crate::problems::ringing();
    let posterior = Posterior::new(&model, &data, &parameters).unwrap();
    let search = TrustRegion { max_evaluations: 3, ..TrustRegion::default() };
    let fit = posterior.map(&MapOptions { search, start: None }).unwrap();
    assert!(matches!(fit.stop, Stop::EvaluationCap { decrement } if decrement > 1e-4), "{:?}", fit.stop);
}

/// a^2, whose cost has a saddle at a = 0 where data ask for more than nothing.
struct Square;

impl Forward for Square {
    fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        Ok(Prediction {
            values: vec![a[0] * a[0]],
            jacobian: Matrix::from_fn(1, 1, |_, _| 2.0 * a[0]),
            curvature: vec![2.0],
        })
    }
}

/// At the centre of a symmetric prior the gradient is nothing, and Gauss and Newton's matrix sees a minimum.
#[test]
fn exact_a_search_leaves_the_saddle_at_which_it_begins() {
    let (y, sd, prior) = (0.25, 0.01, 1.0);
    let observation = Observation::new("square", vec![y]).with_independent_noise(0, &[0]);
    let data = Data::new(vec![observation], vec![NoiseGroup::fixed("noise", "1", sd)]).unwrap();
    let parameters = Parameters::new(vec![normal("a", 0.0, prior)]).unwrap();
    let fit = Posterior::new(&Square, &data, &parameters).unwrap().map(&MapOptions::default()).unwrap();
    // 2 a^2 (a^2 - y)/sd^2 + a^2/prior^2 = 0.
    let exact = (y - 0.5 * (sd / prior).powi(2)).sqrt();
    assert!(fit.stop.converged(), "{:?}", fit.stop);
    assert!((fit.parameters[0].abs() - exact).abs() < 1e-9, "{} {exact}", fit.parameters[0]);
}

/// A valley of Rosenbrock's that counts its evaluations to every order.
#[derive(Default)]
struct Counted([std::sync::atomic::AtomicUsize; 3]);

impl Objective for Counted {
    fn size(&self) -> usize {
        2
    }

    fn evaluate(&self, z: &[f64], order: Order) -> Result<Energy, InferenceError> {
        self.0[order as usize].fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let (x, y) = (z[0], z[1]);
        let off = y - x * x;
        Ok(Energy {
            value: 10.0 * off * off + (1.0 - x).powi(2),
            gradient: vec![-40.0 * x * off - 2.0 * (1.0 - x), 20.0 * off],
            hessian: Matrix::from_fn(2, 2, |i, j| match i + j {
                0 => 120.0 * x * x - 40.0 * y + 2.0,
                1 => -40.0 * x,
                _ => 20.0,
            }),
            gauss_newton: None,
        })
    }
}

#[test]
fn exact_evaluations_are_counted_by_their_order() {
    for method in [Method::Newton, Method::Bfgs] {
        let valley = Counted::default();
        let settings = TrustRegion { method, ..TrustRegion::default() };
        let found = minimise(&valley, &[-1.2, 1.0], &settings).unwrap();
        assert!(found.stop.converged() && found.z.iter().all(|z| (z - 1.0).abs() < 1e-3), "{:?}", found.z);
        let counts = valley.0.map(std::sync::atomic::AtomicUsize::into_inner);
        let Calls { value, first, second, .. } = found.calls;
        assert_eq!([value, first, second], counts, "{method:?}");
        assert!((1..found.calls.total()).contains(&found.steps), "{method:?}: {} steps", found.steps);
    }
    let mut calls = Calls::default();
    [Order::Value, Order::First, Order::First, Order::Second]
        .into_iter()
        .for_each(|order| calls.count(order));
    assert_eq!((calls.value, calls.first, calls.second, calls.failed), (1, 2, 1, 0));
}
