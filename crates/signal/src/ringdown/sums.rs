//! Sums over the samples of products of exponentials, powers of time and data.

use super::component::{Component, Law};
use super::white::White;
use crate::dsp::kernels::{LANES, Powers, run};
use pulp::NullaryFnOnce;
use rijke_numerics::{C64, Matrix};

/// Decay times after which a component counts as silent: what is left out of it is 1e-7 of its amplitude.
const SILENT: f64 = 16.0;

/// Least divisor of an envelope with an excess of damping, which before the start of a fit may reach zero.
const LEAST: f64 = 0.05;

/// Number of samples over which each component sounds.
pub(super) fn lengths(components: &[Component], rows: usize, step: f64) -> Vec<usize> {
    let length = |c: &Component| {
        let decay = -c.s.re * step;
        if decay * rows as f64 > SILENT { (SILENT / decay).ceil() as usize } else { rows }
    };
    components.iter().map(length).collect()
}

/// The exponential of a component at `rows` samples, of which the first is number `first` of the fit, with
/// its chirp and its excess of damping, over the plain exponential there, which comes with it.
pub(super) fn phasors(component: &Component, first: f64, rows: usize, step: f64) -> (Powers, C64) {
    let (s, t) = (component.s, first * step);
    let mut powers = Powers::new((s * step).exp(), rows);
    let mut each = |change: &mut dyn FnMut() -> C64| {
        for (re, im) in powers.re.iter_mut().zip(&mut powers.im) {
            let value = change() * C64::new(*re, *im);
            (*re, *im) = (value.re, value.im);
        }
    };
    if let Some(chirp) = component.chirp {
        // From n to n + 1 the phase grows by chirp step^2 (n + 1/2).
        let mut bend = C64::from_polar(1.0, 0.5 * chirp * t * t);
        let mut turn = C64::from_polar(1.0, chirp * step * step * (first + 0.5));
        let more = C64::from_polar(1.0, chirp * step * step);
        each(&mut || {
            let now = bend;
            bend *= turn;
            turn *= more;
            now
        });
    }
    if let Some(excess) = component.excess {
        let rate = s.re * f64::from(component.law.power());
        let (mut fallen, fall) = ((rate * t).exp(), (rate * step).exp());
        each(&mut || {
            let whole = (1.0 + excess * (1.0 - fallen)).max(LEAST).recip();
            fallen *= fall;
            C64::from(match component.law {
                Law::Linear => whole,
                Law::Square => whole.sqrt(),
            })
        });
    }
    (powers, (s * t).exp())
}

/// Sums of y e^{st} and of t y e^{st}, written to the two columns of component `k`.
pub(super) fn project(white: White<'_>, phasors: &Powers, k: usize, data: &mut Matrix, slopes: &mut Matrix) {
    for from in (0..white.channels).step_by(LANES) {
        let few = white.channels - from <= HALF;
        let of_channels = if few { Sums::<HALF>::of } else { Sums::<LANES>::of };
        for (m, [a, b, ta, tb]) in (from..).zip(of_channels(white, from, phasors)) {
            (data[(m, 2 * k)], data[(m, 2 * k + 1)]) = (a, b);
            (slopes[(m, 2 * k)], slopes[(m, 2 * k + 1)]) = (ta * white.step, tb * white.step);
        }
    }
}

/// Channels that are summed side by side where no more are left.
const HALF: usize = LANES / 2;

/// Sums of y Re z^n, -y Im z^n, n y Re z^n and -n y Im z^n for `N` channels from number `from` on; beyond the
/// last channel what comes next in the record is summed, and means nothing. The sums with n follow from the
/// sum P_l of the first l + 1 terms as (l - 1) P_{l-1} - sum of all earlier P, which spares their
/// multiplications.
struct Sums<'a, const N: usize> {
    white: White<'a>,
    from: usize,
    phasors: &'a Powers,
}

impl<const N: usize> Sums<'_, N> {
    /// The four sums of each channel from number `from` on, `N` at most.
    fn of(white: White<'_>, from: usize, phasors: &Powers) -> Vec<[f64; 4]> {
        let sums = run(Sums::<N> { white, from, phasors });
        (0..N.min(white.channels - from)).map(|i| sums.map(|sum| sum[i])).collect()
    }
}

impl<const N: usize> NullaryFnOnce for Sums<'_, N> {
    type Output = [[f64; N]; 4];

    #[inline(always)]
    fn call(self) -> [[f64; N]; 4] {
        let Self { white, from, phasors } = self;
        let [mut a, mut b, mut ta, mut tb] = [[0.0; N]; 4];
        for (n, (re, im)) in phasors.re.iter().zip(&phasors.im).enumerate() {
            let y = row::<N>(white, n, from);
            for i in 0..N {
                ta[i] += a[i];
                tb[i] += b[i];
                a[i] += y[i] * re;
                b[i] -= y[i] * im;
            }
        }
        let last = phasors.re.len().saturating_sub(1) as f64;
        for i in 0..N {
            ta[i] = last * a[i] - ta[i];
            tb[i] = last * b[i] - tb[i];
        }
        [a, b, ta, tb]
    }
}

/// `N` samples of row `n`, from channel number `from` on: beyond the last channel come those of the next row,
/// and beyond the last row zeros.
#[inline(always)]
pub(super) fn row<const N: usize>(white: White<'_>, n: usize, from: usize) -> [f64; N] {
    let rest = white.samples.get(n * white.channels + from..).unwrap_or_default();
    let padded = || std::array::from_fn(|i| rest.get(i).copied().unwrap_or(0.0));
    rest.first_chunk::<N>().copied().unwrap_or_else(padded)
}

/// Gram matrices of the columns Re(e^{s_k t}), Re(i e^{s_k t}), each over the samples on which both sound,
/// weighted with 1, t and t^2; zero where one of the two is curved.
pub(super) fn grams(components: &[Component], lengths: &[usize], step: f64) -> [Matrix; 3] {
    let size = 2 * components.len();
    let mut grams: [Matrix; 3] = std::array::from_fn(|_| Matrix::zeros(size, size));
    for (i, a) in components.iter().enumerate() {
        for (j, b) in components.iter().enumerate().take(i + 1) {
            if a.is_curved() || b.is_curved() {
                continue;
            }
            let rows = lengths[i].min(lengths[j]);
            let sums = power_sums((a.s + b.s) * step, rows);
            let differences = power_sums((a.s + b.s.conj()) * step, rows);
            let mut scale = 0.5;
            for ((gram, sum), difference) in grams.iter_mut().zip(sums).zip(differences) {
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
                scale *= step;
            }
        }
    }
    grams
}

/// Sums of n^p z^n for n from 0 to `count` - 1 and p = 0, 1, 2, where z is the exponential of `exponent`: in
/// closed form, or by doubling where z^n hardly turns or decays, and the closed form would lose digits.
fn power_sums(exponent: C64, count: usize) -> [C64; 3] {
    let half = (0.5 * exponent.im).sin();
    let growth = exponent.re.exp();
    // 1 - z without cancellation.
    let d = -C64::new(exponent.re.exp_m1() - 2.0 * growth * half * half, growth * exponent.im.sin());
    let n = count as f64;
    if d.norm_sqr() * n * n < 100.0 {
        return doubled_sums(exponent.exp(), count);
    }
    let (z, reciprocal, end) = (C64::ONE - d, d.inv(), (n * exponent).exp());
    let flat = (C64::ONE - end) * reciprocal;
    let linear = (z * flat - n * end) * reciprocal;
    [flat, linear, (z * (flat + 2.0 * linear) - n * n * end) * reciprocal]
}

/// The same by doubling: loses no digits for any z.
fn doubled_sums(z: C64, count: usize) -> [C64; 3] {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_closed_form_and_doubling_agree_with_the_sums_written_out() {
        for exponent in
            [C64::new(-1e-3, 0.2), C64::new(-2e-3, 0.0), C64::new(0.0, 0.01), C64::new(-1e-5, 1e-5)]
        {
            let count = 9000;
            let mut exact = [C64::ZERO; 3];
            for n in 0..count {
                let (t, term) = (n as f64, (exponent * n as f64).exp());
                for (p, sum) in exact.iter_mut().enumerate() {
                    *sum += t.powi(p as i32) * term;
                }
            }
            let (closed, doubled) = (power_sums(exponent, count), doubled_sums(exponent.exp(), count));
            for p in 0..3 {
                assert!(
                    (closed[p] / exact[p] - 1.0).norm() < 1e-10,
                    "{exponent} {p}: {}",
                    closed[p] / exact[p]
                );
                assert!((doubled[p] / exact[p] - 1.0).norm() < 1e-10);
            }
        }
    }

    #[test]
    fn oracle_projection_of_any_number_of_channels_is_the_sum_written_out() {
        let (rows, s, step) = (100, C64::new(-20.0, 900.0), 1e-3);
        for channels in 1..=17 {
            let samples: Vec<f64> = (0..rows * channels).map(|i| ((i * 7919) % 101) as f64 - 50.0).collect();
            let white = White { samples: &samples, channels, step };
            let (mut data, mut slopes) = (Matrix::zeros(channels, 2), Matrix::zeros(channels, 2));
            let wave = Powers::new((s * step).exp(), rows);
            project(white, &wave, 0, &mut data, &mut slopes);
            for m in 0..channels {
                let (mut flat, mut linear) = (C64::ZERO, C64::ZERO);
                for n in 0..rows {
                    let t = n as f64 * step;
                    let term = samples[n * channels + m] * (s * t).exp();
                    flat += term;
                    linear += t * term;
                }
                let have = [data[(m, 0)], -data[(m, 1)], slopes[(m, 0)], -slopes[(m, 1)]];
                for (a, b) in have.into_iter().zip([flat.re, flat.im, linear.re, linear.im]) {
                    assert!((a - b).abs() < 1e-11 * (1.0 + b.abs()), "channel {m} of {channels}: {a} {b}");
                }
            }
        }
    }
}
