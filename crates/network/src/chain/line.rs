//! The two entire functions of which every segment is made, and their derivatives.
//!
//! Over a segment with P = l (s rho + kappa_mu) and Q = l (s/(rho c^2) + kappa_ep), the state (p, u) is
//! multiplied by [[C, -P S], [-Q S, C]] with C = cosh w, S = sinh(w)/w, w^2 = P Q. Both are entire functions
//! of q = P Q: there is no square root, hence no branch to choose, and a short segment needs a few terms of a
//! series only.

use rijke_numerics::C64;

/// C(q) = cosh sqrt q, S(q) = sinh(sqrt q)/sqrt q and the first two derivatives of S. C' = S/2, C'' = S'/2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) c: C64,
    pub(crate) s: C64,
    pub(crate) s1: C64,
}

/// Below this |q| five terms suffice: the sixth is under 1e-16 of the first. Segments of a tube cut in fifty
/// are here.
pub(crate) const SHORT: f64 = 0.01;
/// Below this |q| the long series is used, because S' and S'' lose digits in the closed form.
pub(crate) const MEDIUM: f64 = 2.0;

/// C, S and S' at q.
#[inline]
pub(crate) fn line(q: C64) -> Line {
    if q.re.abs() + q.im.abs() < SHORT { short_line(q) } else { long_line(q) }
}

/// C, S and S' at a q below [`SHORT`].
#[inline(always)]
pub(crate) fn short_line(q: C64) -> Line {
    // Pairs of terms first: the products then do not wait for each other.
    let q2 = q * q;
    let pair = |k: &[f64; TERMS], i: usize| C64::new(k[i] + k[i + 1] * q.re, k[i + 1] * q.im);
    let five = |k: &[f64; TERMS]| pair(k, 0) + q2 * (pair(k, 2) + q2 * k[4]);
    Line { c: five(&COSH), s: five(&SINH), s1: pair(&SINH1, 0) + q2 * pair(&SINH1, 2) }
}

/// Terms of C and S alone that suffice for |Re q| + |Im q| = `size` below [`MEDIUM`].
pub(crate) fn terms(size: f64) -> usize {
    match size {
        size if size < SHORT => 5,
        size if size < 0.1 => 7,
        size if size < 0.5 => 9,
        _ => TERMS,
    }
}

fn long_line(q: C64) -> Line {
    let size = q.re.abs() + q.im.abs();
    if size < 0.1 {
        Line { c: series(q, &COSH[..7]), s: series(q, &SINH[..7]), s1: series(q, &SINH1[..7]) }
    } else if size < MEDIUM {
        Line { c: series(q, &COSH), s: series(q, &SINH), s1: series(q, &SINH1) }
    } else {
        let w = root(q);
        let grow = w.exp();
        let decay = grow.inv();
        let (c, s) = (0.5 * (grow + decay), 0.5 * (grow - decay) / w);
        Line { c, s, s1: 0.5 * (c - s) / q }
    }
}

/// sqrt q without an angle.
fn root(q: C64) -> C64 {
    let large = (0.5 * (q.norm_sqr().sqrt() + q.re.abs())).sqrt();
    let small = 0.5 * q.im.abs() / large;
    let (re, im) = if q.re < 0.0 { (small, large) } else { (large, small) };
    C64::new(re, im.copysign(q.im))
}

/// S'' at q, given S and S' there: 4 q S'' + 6 S' = S.
pub(crate) fn curvature(q: C64, line: &Line) -> C64 {
    if q.re.abs() + q.im.abs() < MEDIUM { series(q, &SINH2) } else { (line.s - 6.0 * line.s1) / (4.0 * q) }
}

#[inline]
fn series(q: C64, coefficients: &[f64]) -> C64 {
    let mut sum = C64::ZERO;
    for &k in coefficients.iter().rev() {
        sum = C64::new(sum.re * q.re - sum.im * q.im + k, sum.re * q.im + sum.im * q.re);
    }
    sum
}

/// Number of terms of the long series: 2^13/27! is below 1e-24.
const TERMS: usize = 13;
pub(crate) const COSH: [f64; TERMS] = taylor(0, 0);
pub(crate) const SINH: [f64; TERMS] = taylor(1, 0);
const SINH1: [f64; TERMS] = taylor(1, 1);
const SINH2: [f64; TERMS] = taylor(1, 2);

/// Coefficients of the `derivative`-th derivative of sum_k q^k / (2k + shift)!.
const fn taylor(shift: usize, derivative: usize) -> [f64; TERMS] {
    let mut out = [0.0; TERMS];
    let mut k = 0;
    while k < TERMS {
        let power = k + derivative;
        let mut value = 1.0;
        let mut factor = 2;
        while factor <= 2 * power + shift {
            value /= factor as f64;
            factor += 1;
        }
        let mut fall = 0;
        while fall < derivative {
            value *= (power - fall) as f64;
            fall += 1;
        }
        out[k] = value;
        k += 1;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_series_and_closed_form_agree() {
        for radius in [1e-6_f64, 7e-3, 0.011, 0.07, 0.11, 0.5, 1.4, 2.1, 30.0] {
            for turn in 0..8 {
                let q = C64::from_polar(radius, f64::from(turn) * 0.785 + 0.1);
                let w = q.sqrt();
                let got = line(q);
                let s = w.sinh() / w;
                assert!((got.c - w.cosh()).norm() < 4e-15 * w.cosh().norm().max(1.0), "C at {q}");
                assert!((got.s - s).norm() < 4e-15 * s.norm().max(1.0), "S at {q}");
                // The closed forms of the derivatives cancel for small q; compare where they do not.
                if radius > 0.4 {
                    let s1 = 0.5 * (w.cosh() - s) / q;
                    assert!((got.s1 - s1).norm() < 1e-13 * s1.norm().max(1.0), "S' at {q}");
                    let s2 = (s - 6.0 * s1) / (4.0 * q);
                    assert!((curvature(q, &got) - s2).norm() < 1e-12 * s2.norm().max(1.0), "S'' at {q}");
                }
            }
        }
    }
}
