//! A heat transfer that differs from one constant, by another route.

use super::*;

/// Four unknowns more, against draws about what is found, weighted by the exact density of readings
/// and priors.
#[test]
fn oracle_moments_of_a_heat_transfer_that_varies() {
    let stream = &mut Streams::new(11).stream("varies");
    let mut all = drawn(8, [0.85, 6.0], 0.01, stream);
    all.points.iter_mut().flatten().enumerate().for_each(|(k, h)| {
        h.varies = Varies { by: 0.4, diameter: 0.05, doublings: [[-0.45, 0.45][k / 4 % 2], 0.0] };
        h.compare(Some([1.2 * 9.5e-4, 50.0]));
    });
    let found = fit(&all.points, &all.readings, PRIORS, 0.0).unwrap();
    let factor = Cholesky::new(&found.covariance).unwrap();
    // Student's t distribution with 4 degrees of freedom: tails longer than those of the posterior.
    let degrees = 4;
    let ln_drawn = |q: f64| 0.5 * f64::from(degrees + VALUES as i32) * (1.0 + q / f64::from(degrees)).ln();
    let (mut sum, mut squares) = (0.0, 0.0);
    let mut moments = [[0.0; 2]; VALUES];
    for _ in 0..80_000 {
        let chi = (0..degrees).map(|_| normal(stream).powi(2)).sum::<f64>() / f64::from(degrees);
        let z: [f64; VALUES] = std::array::from_fn(|_| normal(stream) / chi.sqrt());
        let by = |i: usize| (0..=i).map(|j| factor.lower()[(i, j)] * z[j]).sum::<f64>();
        let values: [f64; VALUES] = std::array::from_fn(|i| found.values[i] + by(i));
        if values[1] < 0.0 {
            continue;
        }
        // tau uniform in u, as the program has it; its prior is in the density.
        let u: f64 = rand_distr::Open01.sample(stream);
        let tau = 0.03 * (std::f64::consts::FRAC_PI_2 * u).tan();
        let jacobian = (1.0 + (tau / 0.03).powi(2)).ln() - tau.ln();
        let ln =
            density_of(&all, values, tau, 0.0) + jacobian + ln_drawn(z.iter().map(|z| z * z).sum::<f64>());
        let weight = (ln + 30.0).exp();
        sum += weight;
        squares += weight * weight;
        for (i, moment) in moments.iter_mut().enumerate() {
            let d = values[i] - found.values[i];
            *moment = [moment[0] + weight * d, moment[1] + weight * d * d];
        }
    }
    let effective = sum * sum / squares;
    assert!(effective > 1000.0, "{effective}");
    for (i, [first, second]) in moments.into_iter().enumerate() {
        let sd = found.covariance[(i, i)].sqrt();
        let (mean, variance) = (first / sum, second / sum);
        let slow = (variance - mean * mean).sqrt();
        println!("value {i}: off {:.3} sd, sd {sd:.4} of {slow:.4}", mean / sd);
        assert!(mean.abs() < 0.15 * sd && (sd / slow - 1.0).abs() < 0.12, "value {i}");
    }
}
