//! Inner loops, compiled for the widest vectors that the processor has (chosen at run time by the crate
//! `pulp`). The order of every sum is written out and no product is fused with a sum, so all processors give
//! the same bits.
//!
//! A kernel is a type whose `call` is `#[inline(always)]`: a closure cannot be marked so, is compiled for the
//! least processor unless it happens to be inlined, and then takes twice as long.

use pulp::{Arch, NullaryFnOnce};
use rijke_numerics::C64;

/// Numbers that are worked on side by side.
pub(crate) const LANES: usize = 8;

/// Runs a kernel.
pub(crate) fn run<K: NullaryFnOnce>(kernel: K) -> K::Output {
    Arch::new().dispatch(kernel)
}

/// The largest distance of a sample from their mean.
pub(crate) fn peak(samples: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for y in samples.chunks(LANES) {
        y.iter().zip(&mut sums).for_each(|(y, sum)| *sum += y);
    }
    let mean = sums.iter().sum::<f64>() / samples.len().max(1) as f64;
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let mut largest = [0.0; LANES];
    for y in samples.chunks(LANES) {
        y.iter().zip(&mut largest).for_each(|(y, top)| *top = larger(*top, (y - mean).abs()));
    }
    largest.into_iter().fold(0.0, larger)
}

/// Inner product in eight independent sums.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    struct Dot<'a>(&'a [f64], &'a [f64]);
    impl NullaryFnOnce for Dot<'_> {
        type Output = f64;
        #[inline(always)]
        fn call(self) -> f64 {
            dot_inline(self.0, self.1)
        }
    }
    run(Dot(a, b))
}

/// Inner products of each of two columns with each of two others; all have the same length.
pub(crate) fn dots(left: [&[f64]; 2], right: [&[f64]; 2]) -> [[f64; 2]; 2] {
    struct Dots<'a>([&'a [f64]; 2], [&'a [f64]; 2]);
    impl NullaryFnOnce for Dots<'_> {
        type Output = [[f64; 2]; 2];
        #[inline(always)]
        fn call(self) -> [[f64; 2]; 2] {
            let columns = [self.0[0], self.0[1], self.1[0], self.1[1]];
            let [mut ac, mut ad, mut bc, mut bd] = [[0.0; LANES]; 4];
            let [a, b, c, d] = columns.map(|column| column.chunks_exact(LANES));
            let [x, y, z, w] = [&a, &b, &c, &d].map(|chunks| chunks.remainder());
            for (((a, b), c), d) in a.zip(b).zip(c).zip(d) {
                for i in 0..LANES {
                    ac[i] += a[i] * c[i];
                    ad[i] += a[i] * d[i];
                    bc[i] += b[i] * c[i];
                    bd[i] += b[i] * d[i];
                }
            }
            for i in 0..x.len() {
                ac[i] += x[i] * z[i];
                ad[i] += x[i] * w[i];
                bc[i] += y[i] * z[i];
                bd[i] += y[i] * w[i];
            }
            [[ac, ad], [bc, bd]].map(|row| row.map(|sums| sums.iter().sum()))
        }
    }
    run(Dots(left, right))
}

/// Adds `factor` times `x` to `y`.
pub(crate) fn add_scaled(y: &mut [f64], factor: f64, x: &[f64]) {
    struct AddScaled<'a>(&'a mut [f64], f64, &'a [f64]);
    impl NullaryFnOnce for AddScaled<'_> {
        type Output = ();
        #[inline(always)]
        fn call(self) {
            add_scaled_inline(self.0, self.1, self.2);
        }
    }
    run(AddScaled(y, factor, x));
}

#[inline(always)]
pub(crate) fn dot_inline(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (left, right) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = left.remainder().iter().zip(right.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in left.zip(right) {
        for i in 0..LANES {
            sums[i] += x[i] * y[i];
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Inner products of `a` with four columns; all lengths are the same multiple of [`LANES`].
#[inline(always)]
pub(crate) fn four_dots_inline(a: &[f64], columns: [&[f64]; 4]) -> [f64; 4] {
    const HALF: usize = LANES / 2;
    let [mut p, mut q, mut r, mut s] = [[0.0; HALF]; 4];
    let [b, c, d, e] = columns.map(|column| column.chunks_exact(HALF));
    for ((((a, b), c), d), e) in a.chunks_exact(HALF).zip(b).zip(c).zip(d).zip(e) {
        for i in 0..HALF {
            p[i] += a[i] * b[i];
            q[i] += a[i] * c[i];
            r[i] += a[i] * d[i];
            s[i] += a[i] * e[i];
        }
    }
    [p, q, r, s].map(|sums| (sums[0] + sums[1]) + (sums[2] + sums[3]))
}

#[inline(always)]
pub(crate) fn add_scaled_inline(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

/// Real and imaginary parts of z^n, n = 0, 1, ...
#[derive(Clone, Debug)]
pub(crate) struct Powers {
    pub(crate) re: Vec<f64>,
    pub(crate) im: Vec<f64>,
}

impl Powers {
    /// The first `count` of them, in eight chains, which do not wait for each other.
    pub(crate) fn new(z: C64, count: usize) -> Self {
        let rows = count.div_ceil(LANES) * LANES;
        let mut powers = Self { re: vec![0.0; rows], im: vec![0.0; rows] };
        let (mut first, mut turn) = ([C64::ONE; LANES], C64::ONE);
        for start in &mut first {
            *start = turn;
            turn *= z;
        }
        run(Chains { first, turn, powers: &mut powers });
        powers.re.truncate(count);
        powers.im.truncate(count);
        powers
    }
}

struct Chains<'a> {
    first: [C64; LANES],
    turn: C64,
    powers: &'a mut Powers,
}

impl NullaryFnOnce for Chains<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { first, turn, powers } = self;
        let (mut re, mut im) = (first.map(|z| z.re), first.map(|z| z.im));
        let blocks = powers.re.chunks_exact_mut(LANES).zip(powers.im.chunks_exact_mut(LANES));
        for (out_re, out_im) in blocks {
            out_re.copy_from_slice(&re);
            out_im.copy_from_slice(&im);
            for i in 0..LANES {
                (re[i], im[i]) = (re[i] * turn.re - im[i] * turn.im, re[i] * turn.im + im[i] * turn.re);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Four<'a>(&'a [f64], [&'a [f64]; 4]);
    impl NullaryFnOnce for Four<'_> {
        type Output = [f64; 4];
        #[inline(always)]
        fn call(self) -> [f64; 4] {
            four_dots_inline(self.0, self.1)
        }
    }

    #[test]
    fn exact_powers_and_inner_products_of_any_length() {
        for count in [0, 1, 7, 8, 9, 96, 100, 101] {
            let z = C64::from_polar(0.99, 0.3);
            let powers = Powers::new(z, count);
            assert_eq!((powers.re.len(), powers.im.len()), (count, count));
            let mut sum = 0.0;
            for n in 0..count {
                let exact = z.powu(n as u32);
                assert!((C64::new(powers.re[n], powers.im[n]) - exact).norm() < 1e-14);
                sum += exact.re * exact.im;
            }
            assert!((dot(&powers.re, &powers.im) - sum).abs() < 1e-13);
            if count % LANES == 0 {
                let [mixed, square, ..] =
                    run(Four(&powers.re, [&powers.im, &powers.re, &powers.im, &powers.im]));
                assert!((mixed - sum).abs() < 1e-13 && (square - dot(&powers.re, &powers.re)).abs() < 1e-13);
            }
            let four = dots([&powers.re, &powers.im], [&powers.im, &powers.re]);
            let exact = [(&powers.re, &powers.im), (&powers.re, &powers.re), (&powers.im, &powers.im)];
            let exact = exact.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>());
            for (have, exact) in four.as_flattened().iter().zip([exact[0], exact[1], exact[2], exact[0]]) {
                assert!((have - exact).abs() < 1e-12, "{count}: {have} {exact}");
            }
            let mut y = powers.re.clone();
            add_scaled(&mut y, -2.0, &powers.im);
            assert!((0..count).all(|n| y[n] == powers.re[n] - 2.0 * powers.im[n]));
        }
    }
}
