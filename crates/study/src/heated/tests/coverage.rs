//! How often stated errors of the gas hold what is true.

use super::*;

/// The share of so many draws whose gas lies within 1.96 sd, at a point with readings and at one without.
fn coverage(count: usize, scatter: Option<f64>, draws: u64) -> [f64; 2] {
    let mut held = [0.0; 2];
    for seed in 0..draws {
        let stream = &mut Streams::new(seed).stream(&format!("heated/{count}/{scatter:?}"));
        let student: f64 = StudentT::new(4.0).unwrap().sample(stream);
        let truth = [0, 1].map(|i| (PRIOR[i][0] + PRIOR[i][1] * normal(stream)).max(0.1));
        let all = drawn(count, truth, scatter.unwrap_or(0.03 * student.abs()), stream);
        let found = fit(&all.points, &all.readings, PRIORS, [0.0; 2]).unwrap();
        for (held, point) in held.iter_mut().zip([0, count]) {
            *held += f64::from(u8::from(off(&found, &all, truth, point).abs() < 1.96)) / draws as f64;
        }
    }
    println!("{count} points, scatter {scatter:?}: {held:?}");
    held
}

#[test]
fn coverage_of_the_gas_at_old_and_new_points() {
    gas_is_covered(100, 0.035);
}

#[test]
#[ignore = "long: 400 draws of each of 8 kinds"]
fn coverage_of_the_gas_at_old_and_new_points_over_400_draws() {
    gas_is_covered(400, 0.0);
}

/// Holds the shares of so many draws to bounds for 400; `slack` widens these by what three standard errors
/// of fewer draws are more.
fn gas_is_covered(draws: u64, slack: f64) {
    for count in [3, 20] {
        // Scatter as its prior has it, then the same in all draws: what is not excluded counts, so that none
        // is covered too often.
        for (scatter, least, most) in
            [(None, 0.92, 0.98), (Some(0.0), 0.95, 1.0), (Some(0.01), 0.92, 1.0), (Some(0.03), 0.92, 0.98)]
        {
            let (least, most) = (least - slack, most + slack);
            let [old, new] = coverage(count, scatter, draws);
            assert!((least..=most).contains(&new), "{count} points, scatter {scatter:?}: {new}");
            // The mean of few points is drawn to each of them.
            assert!(old >= least, "{count} points, scatter {scatter:?}: {old}");
        }
    }
}

/// Errors that all thermometers share, and each one's own, in hot points alone and beside cold ones, which
/// tell them.
#[test]
fn coverage_of_thermometers_that_read_too_much() {
    for cold in [0, 6] {
        let (mut held, mut sds, mut of_offset) = (0.0, 0.0, 0.0);
        for seed in 0..300 {
            let stream = &mut Streams::new(seed).stream(&format!("heated/offset/{cold}"));
            let truth = [0, 1].map(|i| (PRIOR[i][0] + PRIOR[i][1] * normal(stream)).max(0.1));
            let mut all = drawn(8, truth, 0.01, stream);
            for point in 0..cold {
                let h = Heated { rise: 0.0, ..heated(0.0, 1e-3, ["one", "two"][point % 2]) };
                // The error of the day is one of those that the hot points have.
                let error = all.errors[point % 2];
                for at in [0.35, 0.5, 0.7] {
                    let temperature = gas(&h, at, truth, error) + 0.5 * normal(stream);
                    all.readings.push(GasReading { point: all.points.len(), at, temperature, sd: 0.5 });
                }
                all.points.push(Some(h));
            }
            let common = 1.5 * normal(stream);
            let each = [0, 1, 2].map(|_| 1.5 * normal(stream));
            for r in &mut all.readings {
                r.temperature += common + each[[0.35, 0.5, 0.7].iter().position(|at| *at == r.at).unwrap()];
            }
            let found = fit(&all.points, &all.readings, PRIORS, [1.5, 0.0]).unwrap();
            held += f64::from(u8::from(off(&found, &all, truth, 8).abs() < 1.96)) / 300.0;
            sds += found.covariance[(0, 0)].sqrt() / 300.0;
            let [offset, sd] = found.offset;
            of_offset += f64::from(u8::from((offset - common).abs() < 1.96 * sd)) / 300.0;
        }
        println!("{cold} cold points: {held:.3} held, share to {sds:.4}, offset {of_offset:.3} held");
        assert!((0.91..=0.99).contains(&of_offset), "{cold} cold points: {of_offset}");
        // Three standard errors below 95 %; what scatter is not excluded counts, so that none is covered too
        // often.
        assert!((0.91..=1.0).contains(&held), "{cold} cold points: {held}");
    }
}
