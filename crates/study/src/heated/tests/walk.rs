//! Moments of a heat transfer that is not one constant, by a long random walk.

use super::*;
use rand_distr::Open01;

/// Share, heat transfer, how that varies, and ln tau.
const SIZE: usize = VALUES + 1;

/// Metropolis's random walk through the density of readings with its dense covariance. Its steps have the
/// covariance that `fit` states, times 2.4^2/n (Gelman, Roberts & Gilks 1996), so that it finds its way;
/// where it goes, the density alone decides.
#[test]
fn oracle_moments_of_a_heat_transfer_that_varies_by_a_long_walk() {
    let stream = &mut Streams::new(11).stream("heated/varies");
    let mut all = drawn(8, [0.85, 6.0], 0.01, stream);
    for h in all.points.iter_mut().flatten() {
        h.varies.by = 0.4;
        h.compare(Some([9.5e-4, 60.0]));
    }
    let truth = [0.85, 6.0, 0.8, 0.3, 1.0, -0.5];
    for r in &mut all.readings {
        let h = all.points[r.point].as_ref().unwrap();
        let moved = h.temperature(r.at, truth).0 - h.temperature(r.at, constant([0.85, 6.0])).0;
        r.temperature += moved;
    }
    let found = fit(&all.points, &all.readings, PRIORS, [0.4, 0.0]).unwrap();

    let factor = Cholesky::new(&found.covariance).unwrap();
    let ln = |at: &[f64; SIZE]| {
        let values: [f64; VALUES] = std::array::from_fn(|i| at[i]);
        let inside = values[1] >= 0.0 && values[0] > 0.0;
        if inside { density(&all, values, at[VALUES].exp(), [0.4, 0.0]) } else { f64::NEG_INFINITY }
    };
    let mut at: [f64; SIZE] =
        std::array::from_fn(|i| if i < VALUES { found.values[i] } else { found.scatter.ln() });
    let mut here = ln(&at);
    let (steps, scale) = (80_000, 2.4 / (SIZE as f64).sqrt());
    let (mut sum, mut square, mut tau, mut taken) = ([0.0; VALUES], Matrix::zeros(VALUES, VALUES), 0.0, 0);
    for _ in 0..steps {
        let draws: [f64; SIZE] = std::array::from_fn(|_| scale * normal(stream));
        let step = factor.lower().times(&draws[..VALUES]);
        let to: [f64; SIZE] =
            std::array::from_fn(|i| at[i] + if i < VALUES { step[i] } else { draws[VALUES] });
        let there = ln(&to);
        if Distribution::<f64>::sample(&Open01, stream).ln() < there - here {
            (at, here, taken) = (to, there, taken + 1);
        }
        let d: [f64; VALUES] = std::array::from_fn(|i| at[i] - found.values[i]);
        for i in 0..VALUES {
            sum[i] += d[i] / f64::from(steps);
            (0..VALUES).for_each(|j| square[(i, j)] += d[i] * d[j] / f64::from(steps));
        }
        tau += (2.0 * at[VALUES]).exp() / f64::from(steps);
    }
    let share = f64::from(taken) / f64::from(steps);
    println!("{share:.3} of the steps taken, scatter {:.5} of {:.5}", found.scatter, tau.sqrt());
    for i in 0..VALUES {
        let sd = found.covariance[(i, i)].sqrt();
        let slow = (square[(i, i)] - sum[i] * sum[i]).sqrt();
        println!("value {i}: {:.4}, off {:.3} sd, sd {sd:.4} of {slow:.4}", found.values[i], sum[i] / sd);
        // The heat transfer is skewed: its mean lies 0.14 sd above its most probable value (300 000 steps).
        assert!(sum[i].abs() < 0.2 * sd);
        assert!((sd / slow - 1.0).abs() < 0.1);
    }
    assert!((found.scatter / tau.sqrt() - 1.0).abs() < 0.1);
}
