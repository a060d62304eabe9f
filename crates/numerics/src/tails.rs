//! Approximations of distributions that compare a variance with a stated one, or a mean with a variance of
//! few numbers.

/// Share of a chi-squared's cube root: its variance (Wilson & Hilferty, Proc. Natl. Acad. Sci. 17 (1931)
/// 684).
fn spread(freedom: f64) -> f64 {
    2.0 / (9.0 * freedom)
}

/// The standard normal number that is exceeded as rarely as a chi-squared of so many degrees of freedom: its
/// cube root is nearly normal (Wilson & Hilferty 1931). From two degrees of freedom on it is good to 0.05 in
/// the upper tail down to a probability of 0.001; far down in the lower tail of few degrees it is not.
#[must_use]
pub fn chi_squared_as_normal(chi_squared: f64, freedom: f64) -> f64 {
    ((chi_squared / freedom).cbrt() - (1.0 - spread(freedom))) / spread(freedom).sqrt()
}

/// The reverse: the chi-squared that is exceeded as rarely as a standard normal number.
#[must_use]
pub fn chi_squared_of(normal: f64, freedom: f64) -> f64 {
    freedom * (1.0 - spread(freedom) + normal * spread(freedom).sqrt()).powi(3)
}

/// The standard normal number that is exceeded as rarely as a ratio of two variances of so many degrees of
/// freedom each, Fisher's F (Paulson, Ann. Math. Stat. 13 (1942) 233). Of at least three below the line it is
/// good to 0.05 in the upper tail.
#[must_use]
pub fn f_as_normal(ratio: f64, [above, below]: [f64; 2]) -> f64 {
    let root = ratio.cbrt();
    let mean = (1.0 - spread(below)) * root - (1.0 - spread(above));
    mean / (spread(below) * root * root + spread(above)).sqrt()
}

/// The value of Student's t with so many degrees of freedom that is exceeded, on either side, as rarely as a
/// standard normal number (Wallace, Ann. Math. Stat. 30 (1959) 1124). For two standard deviations 1 % too
/// large at 3 degrees of freedom, 4 % at 2.
#[must_use]
pub fn student_of(normal: f64, freedom: f64) -> f64 {
    let z = normal * (8.0 * freedom + 3.0) / (8.0 * freedom + 1.0);
    (freedom * (z * z / freedom).exp_m1()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_tables_of_chi_squared_and_student() {
        // Abramowitz & Stegun, table 26.8, with the normal numbers of the same probabilities.
        for (freedom, chi_squared, normal) in
            [(2.0, 5.991, 1.645), (4.0, 9.488, 1.645), (10.0, 29.588, 3.090), (30.0, 18.493, -1.645)]
        {
            assert!((chi_squared_as_normal(chi_squared, freedom) - normal).abs() < 0.03, "{freedom}");
            let there = chi_squared_of(normal, freedom);
            assert!((there / chi_squared - 1.0).abs() < 0.01, "{freedom}: {there}");
            assert!((chi_squared_as_normal(there, freedom) - normal).abs() < 1e-12);
        }
        // Table 26.9: F that is exceeded with the probabilities 0.05, 0.01 and 0.001.
        for (ratio, freedom, normal) in [
            (3.098, [3.0, 20.0], 1.645),
            (2.753, [10.0, 12.0], 1.645),
            (4.938, [3.0, 20.0], 2.326),
            (3.895, [5.0, 24.0], 2.326),
            (8.098, [3.0, 20.0], 3.090),
            (7.292, [10.0, 12.0], 3.090),
        ] {
            assert!((f_as_normal(ratio, freedom) - normal).abs() < 0.05, "{ratio}");
        }
        // Table 26.10: exceeded on either side with probability 0.05.
        for (freedom, t, within) in [(2.0, 4.303, 0.041), (3.0, 3.182, 0.015), (10.0, 2.228, 0.002)] {
            assert!((student_of(1.959_964, freedom) / t - 1.0).abs() < within, "{freedom}");
        }
    }
}
