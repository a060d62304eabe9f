//! The mean over repeats: scatter within and between them, drift, outliers.

use super::pool::{Group, variances_of_means};
use crate::Fault;
use rayon::prelude::*;
use rijke_numerics::tails::{chi_squared_of, student_of};
use rijke_numerics::{Matrix, median};

/// What the repeats of one measurement say together.
#[derive(Clone, Debug, PartialEq)]
pub struct Repeats {
    /// Mean over the accepted repeats.
    pub mean: Vec<f64>,
    /// Covariance of the mean: within / count, and on the diagonal what else the repeats' scatter calls for,
    /// such that two standard deviations hold the truth in 95 % of all cases whatever the number of repeats
    /// ([`pool`] learns the scatter from several points). Errors common to all repeats are not in it.
    pub covariance: Matrix,
    /// Mean over the repeats of the covariance stated for one of them.
    pub within: Matrix,
    /// Variance between repeats beyond what their noise explains, per number; zero where it is not
    /// significant (5 %).
    pub between: Vec<f64>,
    /// Drift per repeat, and its standard deviation, per number.
    pub drift: Vec<(f64, f64)>,
    /// Sum of squared deviations from the mean, per number.
    pub squares: Vec<f64>,
    /// Number of repeats accepted.
    pub count: usize,
    /// Repeats left out, by their place in the input.
    pub outliers: Vec<(usize, Fault)>,
}

/// Distance from the median, in stated standard deviations, within which no repeat is an outlier.
const OUTLIER: f64 = 6.0;
/// Normal deviate whose probability is that of a false outlier by the scatter of the repeats: 1e-5.
const RARE: f64 = 4.417;
/// Normal deviate that is exceeded with a probability of 5 %.
const ONE_IN_20: f64 = 1.645;

/// Combines repeats with equal weights. `values` holds, per repeat, its place in time (an index will do), the
/// numbers measured and their covariance; `names` says what the numbers are.
///
/// A repeat is an outlier if one of its numbers lies more than 6 stated standard deviations from the median,
/// and so far in terms of the median absolute deviation that few repeats would show it once in 1e5. From
/// three repeats almost nothing is an outlier, from 40 what lies beyond 6.6. None if there is no repeat at
/// all.
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
            let limit = rare_deviate(values.len());
            let distance = |i: usize| {
                let stated = covariance[(i, i)].max(0.0).sqrt();
                OUTLIER * (vector[i] - typical[i].0).abs() / (limit * typical[i].1).max(OUTLIER * stated)
            };
            let worst = (0..size).map(|i| (i, distance(i))).max_by(|a, b| a.1.total_cmp(&b.1));
            match worst {
                Some((i, distance)) if distance > OUTLIER => {
                    let sd = typical[i].1.max(covariance[(i, i)].max(0.0).sqrt());
                    let sds = (vector[i] - typical[i].0).abs() / sd;
                    outliers.push((n, Fault::Outlier(names(i), sds)));
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
    let square = |i: usize| accepted.iter().map(|&k| (values[k].1[i] - mean[i]).powi(2)).sum::<f64>();
    let squares: Vec<f64> = (0..size).map(square).collect();
    let between: Vec<f64> = (0..size)
        .map(|i| {
            if count < 2 {
                return 0.0;
            }
            let excess = squares[i] / freedom - within[(i, i)];
            if squares[i] > chi_squared_of(ONE_IN_20, freedom) * within[(i, i)] { excess } else { 0.0 }
        })
        .collect();
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
    let covariance = Matrix::zeros(size, size);
    let mut repeats = Repeats { mean, covariance, within, between, drift, squares, count, outliers };
    pool(&mut [&mut repeats]);
    Some(repeats)
}

/// Learns the scatter between repeats from several points together, and states the covariance of each mean
/// accordingly. All points hold the same numbers; how much repeats scatter may differ from point to point,
/// but is no surprise at any: the logarithm of the variance is taken as normal over the points. For one point
/// as [`combine`] has it already.
pub fn pool(points: &mut [&mut Repeats]) {
    let size = points.iter().map(|p| p.mean.len()).min().unwrap_or(0);
    for point in points.iter_mut() {
        point.covariance = Matrix::from_fn(point.within.rows(), point.within.columns(), |i, j| {
            point.within[(i, j)] / point.count as f64
        });
    }
    let groups = |i: usize| -> Vec<Group> {
        let group =
            |p: &&mut Repeats| Group { within: p.within[(i, i)], squares: p.squares[i], count: p.count };
        points.iter().map(group).collect()
    };
    let groups: Vec<Vec<Group>> = (0..size).map(groups).collect();
    let variances: Vec<Vec<f64>> = groups.par_iter().map(|g| variances_of_means(g)).collect();
    for (i, variances) in variances.into_iter().enumerate() {
        for (point, variance) in points.iter_mut().zip(variances) {
            point.covariance[(i, i)] = variance.max(point.covariance[(i, i)]);
        }
    }
}

/// Distance from the median, in standard deviations estimated by the median absolute deviation of `count`
/// normal numbers, that is exceeded once in 1e5: Student's t. That estimate is as certain as a standard
/// deviation with 0.37 times the degrees of freedom.
fn rare_deviate(count: usize) -> f64 {
    student_of(RARE, 0.37 * (count as f64 - 1.0))
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
        // Sample variance 2.5: with 1.0 explained by noise, 1.5 is left over (limit for 4 degrees of freedom:
        // 2.37).
        let r = repeats(&[1.0, 2.0, 3.0, 4.0, 5.0], 1.0);
        assert!((r.mean[0] - 3.0).abs() < 1e-15 && (r.between[0] - 1.5).abs() < 1e-12);
        assert!((r.drift[0].0 - 1.0).abs() < 1e-12 && (r.squares[0] - 10.0).abs() < 1e-12);
        // With 2.0 explained the rest is not significant.
        assert_eq!(repeats(&[1.0, 2.0, 3.0, 4.0, 5.0], 2.0).between[0], 0.0);
    }

    #[test]
    fn regress_three_repeats_that_happen_to_agree_are_not_believed() {
        // What another rig gave: 0.06 rad/s from draughts at every point, fits good to 0.001 rad/s.
        let point = |a: f64, b: f64, c: f64| repeats(&[a, b, c], 1e-6);
        let mut lucky = point(0.031, 0.033, 0.032);
        let alone = lucky.covariance[(0, 0)].sqrt();
        let mut others: Vec<Repeats> = (0..12)
            .map(|k| {
                let turn = |n: i32| 0.06 * 1.41 * f64::from(n * 7 + k * 3).sin();
                point(turn(1), turn(2), turn(3))
            })
            .collect();
        let mut points: Vec<&mut Repeats> = others.iter_mut().collect();
        points.push(&mut lucky);
        pool(&mut points);
        // 0.06/sqrt(3) is 0.035; alone, the three repeats said 0.0013.
        let pooled = lucky.covariance[(0, 0)].sqrt();
        assert!(alone < 0.003 && (0.01..0.05).contains(&pooled), "alone {alone}, pooled {pooled}");
    }

    #[test]
    fn exact_outlier_is_named_and_left_out() {
        let mut values: Vec<f64> = (0..20).map(|n| 1.0 + 0.01 * f64::from(n * 7 % 20)).collect();
        values[4] = 9.0;
        let r = repeats(&values, 0.01);
        assert_eq!(r.count, 19);
        assert_eq!(r.outliers[0].0, 4);
        assert!(r.outliers[0].1.to_string().starts_with("growth rate lies"));
        assert!((r.mean[0] - 1.1).abs() < 0.01);
        // Two of three repeats may agree by chance: the third is no outlier for that.
        assert!(repeats(&[1.0, 1.001, 1.5], 1e-4).outliers.is_empty());
    }
}
