//! Whether a polynomial has growing roots.

/// Whether a polynomial, its coefficients ascending, has a root with a positive real part: whether the signs
/// in the first column of Routh's array (1877) change. A zero in that column, which roots on the imaginary
/// axis or in pairs about zero give, ends the search without a finding.
#[must_use]
pub fn has_growing_root(ascending: &[f64]) -> bool {
    let mut all: Vec<f64> = ascending.to_vec();
    while all.last() == Some(&0.0) {
        all.pop();
    }
    all.reverse();
    let mut rows = [0, 1].map(|first| all.iter().skip(first).step_by(2).copied().collect::<Vec<f64>>());
    loop {
        let [upper, lower] = &rows;
        let (Some(a), Some(b)) = (upper.first(), lower.first()) else { return false };
        if a * b < 0.0 {
            return true;
        }
        if *b == 0.0 {
            return false;
        }
        let of = |row: &[f64], k: usize| row.get(k).copied().unwrap_or(0.0);
        let next = (1..upper.len()).map(|k| of(upper, k) - a / b * of(lower, k)).collect();
        rows = [lower.clone(), next];
    }
}

#[cfg(test)]
mod tests {
    use super::has_growing_root as grows;

    /// The product of (s - r) over roots r, conjugate pairs given by one of them.
    fn product(roots: &[(f64, f64)]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |all, &(re, im)| {
            let factor = if im == 0.0 { vec![-re, 1.0] } else { vec![re * re + im * im, -2.0 * re, 1.0] };
            let mut out = vec![0.0; all.len() + factor.len() - 1];
            all.iter().enumerate().for_each(|(i, a)| {
                factor.iter().enumerate().for_each(|(j, b)| out[i + j] += a * b);
            });
            out
        })
    }

    #[test]
    fn exact_a_polynomial_grows_if_it_has_a_root_to_the_right() {
        for stable in
            [&[(-3.0, 0.0)][..], &[(-0.1, 40.0), (-2.0, 1.0)], &[(-1.0, 0.0), (-0.01, 9.0), (-5.0, 0.0)]]
        {
            let polynomial = product(stable);
            assert!(!grows(&polynomial) && !grows(&polynomial.iter().map(|k| -k).collect::<Vec<_>>()));
            for k in 0..stable.len() {
                let mut other = stable.to_vec();
                other[k].0 *= -1.0;
                assert!(grows(&product(&other)), "{other:?}");
            }
        }
        assert!(!grows(&[1.0]) && !grows(&[2.0, 0.0]));
    }
}
