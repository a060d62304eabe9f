//! How the open end of a pipe reflects.

use rijke_numerics::C64;

/// Reflection coefficient, referred to a plane 0.61 radii beyond the end, of an unflanged pipe at k a = `ka`:
/// closed approximations to Levine & Schwinger 1948 by Silva et al., J. Sound Vib. 322 (2009) 255. Below 1.5
/// the modulus is good to 0.5 % and the end correction to 1.2 %, below 3.5 to 2 and 3 %.
pub(crate) fn unflanged(ka: f64) -> C64 {
    let k = ka.min(3.8).powi(2);
    let size = (1.0 + 0.8 * k) / (1.0 + 1.3 * k + 0.266 * k * k + 0.0263 * k * k * k);
    C64::from_polar(-size, -2.0 * ka * (extension(ka) - 0.61))
}

/// The same of a pipe that ends in an infinite flange, referred to the same plane: fits of the same authors.
pub(crate) fn flanged(ka: f64) -> C64 {
    let k = ka.min(3.8).powi(2);
    let size = (1.0 + 0.73 * k) / (1.0 + 1.73 * k + 0.372 * k * k + 0.0231 * k * k * k);
    let longer = 0.8216 * (1.0 + 0.244 * k) / (1.0 + 0.723 * k - 0.0198 * k * k + 0.00366 * k * k * k);
    C64::from_polar(-size, -2.0 * ka * (longer - 0.61))
}

/// End correction over the radius, without a flange.
fn extension(ka: f64) -> f64 {
    let k = ka.min(3.8).powi(2);
    0.6133 * (1.0 + 0.0599 * k) / (1.0 + 0.238 * k - 0.0153 * k * k + 0.0015 * k * k * k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_the_exact_integrals_of_levine_and_schwinger_agree() {
        // fixtures/reference/levine_schwinger.csv, and beyond 1.5 the same integrals by mpmath: k a, |R|, end
        // correction over the radius.
        let exact = [
            (0.1, 0.995_066_698, 0.610_987_493),
            (0.5, 0.896_441_398, 0.581_836_401),
            (1.0, 0.695_102_173, 0.527_430_784),
            (1.5, 0.500_787_698, 0.471_270_05),
            (2.0, 0.346_176_048, 0.416_944_340),
            (2.5, 0.233_178_170, 0.363_612_449),
            (3.0, 0.154_328_321, 0.308_275_459),
            (3.5, 0.100_858_856, 0.242_158_439),
        ];
        for (ka, size, correction) in exact {
            let found = unflanged(ka);
            let [of_size, of_correction] = if ka > 1.5 { [0.02, 0.03] } else { [0.005, 0.012] };
            assert!((found.norm() / size - 1.0).abs() < of_size, "{ka}: {}", found.norm());
            assert!((extension(ka) / correction - 1.0).abs() < of_correction, "{ka}: {}", extension(ka));
            let angle = (-found).arg() + 2.0 * ka * (correction - 0.61);
            assert!(angle.abs() < if ka > 1.5 { 0.06 } else { 0.015 }, "{ka}: {angle}");
        }
    }
}
