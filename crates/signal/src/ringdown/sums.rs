//! Sums over the samples of products of exponentials, powers of time and data.

use super::{Component, White};
use rijke_numerics::{C64, Matrix};

/// Sums of y e^{st} and of t y e^{st} over the samples, written to the two columns of component `k`.
pub(super) fn project(white: White<'_>, s: C64, k: usize, data: &mut Matrix, slopes: &mut Matrix) {
    let turn = (s * white.step).exp();
    let mut phasor = C64::ONE;
    let mut sums = vec![[0.0_f64; 4]; white.channels];
    for (n, row) in white.samples.chunks_exact(white.channels).enumerate() {
        let t = n as f64;
        let (re, im) = (phasor.re, -phasor.im);
        let (tre, tim) = (t * re, t * im);
        for (sum, &y) in sums.iter_mut().zip(row) {
            sum[0] += y * re;
            sum[1] += y * im;
            sum[2] += y * tre;
            sum[3] += y * tim;
        }
        phasor *= turn;
    }
    for (m, sum) in sums.iter().enumerate() {
        for i in 0..2 {
            data[(m, 2 * k + i)] = sum[i];
            slopes[(m, 2 * k + i)] = sum[2 + i] * white.step;
        }
    }
}

/// Gram matrix of the columns Re(e^{s_k t}), Re(i e^{s_k t}), weighted with t^power.
pub(super) fn gram(components: &[Component], rows: usize, step: f64, power: usize) -> Matrix {
    let size = 2 * components.len();
    let scale = 0.5 * step.powi(power as i32);
    let mut gram = Matrix::zeros(size, size);
    for (i, a) in components.iter().enumerate() {
        for (j, b) in components.iter().enumerate().take(i + 1) {
            let sum = power_sums(((a.s + b.s) * step).exp(), rows)[power];
            let difference = power_sums(((a.s + b.s.conj()) * step).exp(), rows)[power];
            // Re(u) Re(v) = (Re(u v) + Re(u conj v)) / 2, with u and v the exponentials or i times them.
            let entries = [
                [sum.re + difference.re, -sum.im + difference.im],
                [-sum.im - difference.im, difference.re - sum.re],
            ];
            for (p, row) in entries.iter().enumerate() {
                for (q, value) in row.iter().enumerate() {
                    gram[(2 * i + p, 2 * j + q)] = scale * value;
                    gram[(2 * j + q, 2 * i + p)] = scale * value;
                }
            }
        }
    }
    gram
}

/// Sums of n^p z^n for n from 0 to `count` - 1 and p = 0, 1, 2, by doubling: unlike the closed form, it loses no
/// digits when z is near 1.
fn power_sums(z: C64, count: usize) -> [C64; 3] {
    let (mut s, mut done, mut factor) = ([C64::ZERO; 3], 0.0_f64, C64::ONE);
    for bit in (0..usize::BITS - count.leading_zeros()).rev() {
        let [a, b, c] = s;
        s = [
            a + factor * a,
            b + factor * (b + done * a),
            c + factor * (c + 2.0 * done * b + done * done * a),
        ];
        factor *= factor;
        done *= 2.0;
        if count >> bit & 1 == 1 {
            for (p, sum) in s.iter_mut().enumerate() {
                *sum += factor * done.powi(p as i32);
            }
            factor *= z;
            done += 1.0;
        }
    }
    s
}
