//! The mean over repeats: scatter within and between them, drift, outliers.

use crate::Fault;
use rijke_numerics::Matrix;

/// What the repeats of one measurement say together.
#[derive(Clone, Debug, PartialEq)]
pub struct Repeats {
    /// Mean over the accepted repeats.
    pub mean: Vec<f64>,
    /// Covariance of the mean: (within + between t) / count, where t = (count - 1)/(count - 3) is the variance of Student's
    /// t. Errors common to all repeats are not in it.
    pub covariance: Matrix,
    /// Mean over the repeats of the covariance stated for one of them.
    pub within: Matrix,
    /// Variance between repeats beyond what their noise explains, per number; zero where it is not significant (5 %).
    pub between: Vec<f64>,
    /// Drift per repeat, and its standard deviation, per number.
    pub drift: Vec<(f64, f64)>,
    /// Number of repeats accepted.
    pub count: usize,
    /// Repeats left out, by their place in the input.
    pub outliers: Vec<(usize, Fault)>,
}

/// Distance from the median, in standard deviations, beyond which a repeat is an outlier: one in 5e8 of normal numbers.
const OUTLIER: f64 = 6.0;

/// Combines repeats with equal weights. `values` holds, per repeat, its place in time (an index will do), the numbers
/// measured and their covariance; `names` says what the numbers are.
///
/// A repeat is an outlier if one of its numbers lies more than 6 standard deviations from the median, where the
/// standard deviation is the larger of the one stated and the one that the median absolute deviation implies; with
/// fewer than 3 repeats nothing is. None if there is no repeat at all.
#[must_use]
pub fn combine(values: &[(f64, Vec<f64>, Matrix)], names: &dyn Fn(usize) -> String) -> Option<Repeats> {
    let size = values.first()?.1.len();
    let mut outliers = Vec::new();
    let mut accepted: Vec<usize> = (0..values.len()).collect();
    if values.len() >= 3 {
        let typical: Vec<(f64, f64)> = (0..size)
            .map(|i| {
                let centre = median(values.iter().map(|v| v.1[i]).collect());
                (centre, 1.4826 * median(values.iter().map(|v| (v.1[i] - centre).abs()).collect()))
            })
            .collect();
        accepted.retain(|&n| {
            let (_, vector, covariance) = &values[n];
            let distance = |i: usize| {
                (vector[i] - typical[i].0).abs() / typical[i].1.max(covariance[(i, i)].max(0.0).sqrt())
            };
            let worst = (0..size).map(|i| (i, distance(i))).max_by(|a, b| a.1.total_cmp(&b.1));
            match worst {
                Some((i, distance)) if distance > OUTLIER => {
                    outliers.push((n, Fault::Outlier { quantity: names(i), distance }));
                    false
                }
                _ => true,
            }
        });
    }
    let count = accepted.len();
    let n = count as f64;
    let mean: Vec<f64> =
        (0..size).map(|i| accepted.iter().map(|&k| values[k].1[i]).sum::<f64>() / n).collect();
    let mut within = Matrix::zeros(size, size);
    for &k in &accepted {
        within = within.plus(1.0 / n, &values[k].2);
    }
    let freedom = n - 1.0;
    let between: Vec<f64> = (0..size)
        .map(|i| {
            if count < 2 {
                return 0.0;
            }
            let squares: f64 = accepted.iter().map(|&k| (values[k].1[i] - mean[i]).powi(2)).sum();
            let excess = squares / freedom - within[(i, i)];
            // 95 % point of chi-squared over its freedom, by Wilson & Hilferty 1931.
            let cube = 2.0 / (9.0 * freedom);
            let limit = (1.0 - cube + 1.645 * cube.sqrt()).powi(3);
            if squares / freedom > limit * within[(i, i)] { excess } else { 0.0 }
        })
        .collect();
    // The variance of Student's t, which a mean follows whose scatter was learnt from these few repeats.
    let student = if count > 3 { freedom / (freedom - 2.0) } else { 3.0 };
    let covariance = within.plus(student, &Matrix::diagonal(&between));
    let covariance = Matrix::from_fn(size, size, |i, j| covariance[(i, j)] / n);
    let when: Vec<f64> = accepted.iter().map(|&k| values[k].0).collect();
    let middle = when.iter().sum::<f64>() / n;
    let leverage: f64 = when.iter().map(|t| (t - middle).powi(2)).sum();
    let drift = (0..size)
        .map(|i| {
            if leverage == 0.0 {
                return (0.0, f64::INFINITY);
            }
            let slope: f64 =
                accepted.iter().map(|&k| (values[k].0 - middle) * (values[k].1[i] - mean[i])).sum::<f64>()
                    / leverage;
            (slope, ((within[(i, i)] + between[i]) / leverage).sqrt())
        })
        .collect();
    Some(Repeats { mean, covariance, within, between, drift, count, outliers })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repeats(values: &[f64], variance: f64) -> Repeats {
        let values: Vec<_> = values
            .iter()
            .enumerate()
            .map(|(n, &v)| (n as f64, vec![v], Matrix::diagonal(&[variance])))
            .collect();
        combine(&values, &|_| "growth rate".to_owned()).unwrap()
    }

    #[test]
    fn exact_scatter_within_and_between_add_up() {
        // Sample variance 2.5: with 1.0 explained by noise, 1.5 is left over (limit for 4 degrees of freedom: 2.37).
        let r = repeats(&[1.0, 2.0, 3.0, 4.0, 5.0], 1.0);
        assert!((r.mean[0] - 3.0).abs() < 1e-15 && (r.between[0] - 1.5).abs() < 1e-12);
        // Student's t with 4 degrees of freedom has the variance 2: (1.0 + 1.5 * 2)/5.
        assert!((r.covariance[(0, 0)] - 0.8).abs() < 1e-12);
        assert!((r.drift[0].0 - 1.0).abs() < 1e-12);
        // With 2.0 explained the rest is not significant.
        assert_eq!(repeats(&[1.0, 2.0, 3.0, 4.0, 5.0], 2.0).between[0], 0.0);
    }

    #[test]
    fn exact_outlier_is_named_and_left_out() {
        let r = repeats(&[1.0, 1.1, 0.9, 1.0, 9.0], 0.01);
        assert_eq!(r.count, 4);
        assert_eq!(r.outliers[0].0, 4);
        assert!(r.outliers[0].1.to_string().starts_with("growth rate lies"));
        assert!((r.mean[0] - 1.0).abs() < 1e-12);
    }
}
