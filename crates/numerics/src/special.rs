//! Special functions of a complex variable, and Legendre's polynomials.

use crate::C64;
use crate::wide::Wide;
use pulp::Simd;
use pulp::bytemuck::{cast_slice, cast_slice_mut};
use std::slice::{from_mut, from_ref};

/// The first `count` Legendre polynomials at x, each of unit root mean square over -1 .. 1.
#[must_use]
pub fn legendre(x: f64, count: usize) -> Vec<f64> {
    let (mut before, mut here) = (0.0, 1.0);
    (0..count)
        .map(|n| {
            let scaled = here * ((2 * n + 1) as f64).sqrt();
            let next = ((2 * n + 1) as f64 * x * here - n as f64 * before) / (n + 1) as f64;
            (before, here) = (here, next);
            scaled
        })
        .collect()
}

/// r(z) = I1(z)/I0(z) for Re z >= 0, to rounding; r' = 1 - r/z - r^2.
#[must_use]
pub fn bessel_ratio(z: C64) -> C64 {
    let r = bessel_ratios(Wide::splat(pulp::Scalar, z));
    C64::new(r.re, r.im)
}

/// [`bessel_ratio`] of numbers side by side.
///
/// Where Re z > 18, e^(-2z) is below rounding and r is its asymptotic series in 1/z. Elsewhere I_k = (z/2)^k
/// t_k up to a common factor, where the t_k follow the recurrence of the I_k downward from an order whose I_k
/// is below rounding (Miller's algorithm, DLMF 3.6(iii)).
#[must_use]
#[inline(always)]
pub fn bessel_ratios<S: Simd>(z: Wide<S>) -> Wide<S> {
    let (simd, square) = (z.simd, z.norm_sqr());
    let far = simd.less_than_f64s(simd.splat_f64s(FAR_FROM), z.re);
    let mut found = z;
    if simd.reduce_max_f64s(z.re) > FAR_FROM {
        let none = simd.splat_f64s(f64::INFINITY);
        let nearest = simd.reduce_min_f64s(simd.select_f64s(far, square, none));
        found = z.recip().polynomial(&FAR[..far_terms(nearest)]);
    }
    let least = simd.reduce_min_f64s(z.re);
    if least > FAR_FROM {
        return found;
    }
    let distance = simd.reduce_max_f64s(simd.select_f64s(far, simd.splat_f64s(0.0), square)).sqrt();
    let near = by_recurrence(z, (13.0 + 1.4 * distance.min(NEAR_TO)) as usize);
    found.re = simd.select_f64s(far, found.re, near.re);
    found.im = simd.select_f64s(far, found.im, near.im);
    if distance > NEAR_TO {
        beyond(z, &mut found);
    }
    found
}

/// The asymptotic series begins at this Re z.
const FAR_FROM: f64 = 18.0;
/// The recurrence is used up to this |z|: beyond, where s decays much faster than it turns, the t_k become
/// too large.
const NEAR_TO: f64 = 30.0;

/// Terms of the asymptotic series, which fall like n!/(2|z|)^n: so many reach 1e-16.
fn far_terms(square: f64) -> usize {
    match square {
        square if square > 80.0 * 80.0 => 11,
        square if square > 40.0 * 40.0 => 16,
        square if square > 25.0 * 25.0 => 22,
        _ => FAR.len(),
    }
}

/// r = z t_1/t_0 with t_(k-1) = 2 k t_k + z^2 t_(k+1).
#[inline(always)]
fn by_recurrence<S: Simd>(z: Wide<S>, first: usize) -> Wide<S> {
    let simd = z.simd;
    let q = z * z;
    let (mut t, mut above) = (Wide::splat(simd, C64::ONE), Wide::splat(simd, C64::ZERO));
    for k in (1..=first).rev() {
        (t, above) = (t.scale(simd.splat_f64s(2.0 * k as f64)) + q * above, t);
    }
    z * above * t.recip()
}

/// Amos's algorithms, one number after the other.
#[cold]
fn beyond<S: Simd>(z: Wide<S>, found: &mut Wide<S>) {
    let lanes = |part: &S::f64s| cast_slice::<S::f64s, f64>(from_ref(part)).to_vec();
    let all = lanes(&z.re).into_iter().zip(lanes(&z.im)).map(|(re, im)| C64::new(re, im));
    for (i, z) in all.enumerate().filter(|(_, z)| z.re <= FAR_FROM && z.norm() > NEAR_TO) {
        let scaled = |order| complex_bessel::besseli_scaled(order, z).unwrap_or(C64::new(f64::NAN, f64::NAN));
        let r = scaled(1.0) / scaled(0.0);
        cast_slice_mut(from_mut(&mut found.re))[i] = r.re;
        cast_slice_mut(from_mut(&mut found.im))[i] = r.im;
    }
}

/// The asymptotic series I1/I0 = sum a_n z^-n. With r' = 1 - r/z - r^2: a_0 = 1 and 2 a_n = (n - 2) a_(n-1) -
/// sum_(0<i<n) a_i a_(n-i).
const FAR: [f64; 34] = {
    let mut a = [1.0; 34];
    let mut n = 1;
    while n < 34 {
        let mut twice = (n as f64 - 2.0) * a[n - 1];
        let mut i = 1;
        while i < n {
            twice -= a[i] * a[n - i];
            i += 1;
        }
        a[n] = 0.5 * twice;
        n += 1;
    }
    a
};

#[cfg(test)]
mod tests {
    use super::*;

    /// I1/I0 as the continued fraction z/(2 + z^2/(4 + z^2/(6 + ...))) (DLMF 10.33.1).
    fn continued_fraction(z: C64) -> C64 {
        let tail = (1..=600).rev().fold(C64::ZERO, |below, k| z * z / (f64::from(2 * k) + below));
        tail / z
    }

    #[test]
    fn oracle_the_ratio_agrees_with_its_continued_fraction() {
        // On both sides of every change of the series; the angle of z = R sqrt(s rho/mu) is near 45 degrees,
        // more where a mode decays.
        let moduli =
            [1e-9, 1e-3, 0.3, 2.0, 11.0, 17.9, 18.1, 24.9, 25.6, 29.9, 30.1, 39.9, 40.1, 75.0, 81.0, 150.0];
        let angles = [-0.8, 0.0, 0.4, 0.8, 1.2, 1.5];
        let all = moduli.map(|modulus| angles.map(|angle| C64::from_polar(modulus, angle)));
        let near = |ours: C64, z: C64| {
            let theirs = continued_fraction(z);
            assert!((ours - theirs).norm() <= 3e-15 * theirs.norm(), "{z}: {ours} {theirs}");
        };
        all.as_flattened().iter().for_each(|z| near(bessel_ratio(*z), *z));
        // Side by side, with neighbours on the same side of a change and on the other.
        for stride in [1, 6, 17, 35] {
            let mixed: Vec<C64> = (0..96).map(|i| all.as_flattened()[i * stride % 96]).collect();
            let [re, im] = [|z: &C64| z.re, |z: &C64| z.im].map(|part| mixed.iter().map(part).collect());
            let [re, im] = pulp::Arch::new().dispatch(SideBySide { re, im });
            for (i, z) in mixed.iter().enumerate() {
                near(C64::new(re[i], im[i]), *z);
            }
        }
    }

    struct SideBySide {
        re: Vec<f64>,
        im: Vec<f64>,
    }

    impl pulp::WithSimd for SideBySide {
        type Output = [Vec<f64>; 2];
        #[inline(always)]
        fn with_simd<S: Simd>(mut self, simd: S) -> [Vec<f64>; 2] {
            let parts = [&mut self.re, &mut self.im].map(|part| S::as_mut_simd_f64s(part));
            let [(re, []), (im, [])] = parts else { panic!("96 is no multiple of the lanes") };
            for (re, im) in re.iter_mut().zip(im) {
                let r = bessel_ratios(Wide::new(simd, *re, *im));
                (*re, *im) = (r.re, r.im);
            }
            [self.re, self.im]
        }
    }

    #[test]
    fn exact_polynomials_are_orthogonal_and_of_unit_mean_square() {
        let n = 4000;
        let at = |k: usize| -1.0 + (2 * k + 1) as f64 / n as f64;
        for (i, j) in [(0, 0), (3, 3), (7, 7), (2, 4), (0, 6)] {
            let mean = (0..n)
                .map(|k| {
                    let p = legendre(at(k), 8);
                    p[i] * p[j]
                })
                .sum::<f64>()
                / n as f64;
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!((mean - expected).abs() < 1e-4, "{i} {j}: {mean}");
        }
    }
}
