//! Sums over the samples to which a component with a chirp or an excess of damping belongs: no closed form is
//! known. They are taken in blocks of rows, whose columns stay in the cache.

use super::component::Component;
use super::sums::row;
use super::white::White;
use crate::dsp::kernels::{LANES, Powers, dots, run};
use pulp::NullaryFnOnce;
use rijke_numerics::Matrix;

/// Rows of a block.
const BLOCK: usize = 256;

/// What a curved component has beside the columns e^{st} and t e^{st}: the direction of each, see
/// [`Solution::free`](super::Solution), and the number it is multiplied by at each sample.
pub(super) fn factors(component: &Component, rows: usize, step: f64) -> Vec<(usize, Vec<f64>)> {
    let time = |n: usize| n as f64 * step;
    let mut list = Vec::new();
    if component.chirp.is_some() {
        list.push((2, (0..rows).map(|n| 0.5 * time(n).powi(2)).collect()));
    }
    if let Some(excess) = component.excess {
        let power = f64::from(component.law.power());
        let (mut fallen, fall) = (1.0, (power * component.s.re * step).exp());
        let (mut of_growth, mut of_excess) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
        for n in 0..rows {
            let whole = (1.0 + excess * (1.0 - fallen)).recip();
            of_growth.push(time(n) * (1.0 + excess * fallen * whole));
            of_excess.push((fallen - 1.0) * whole / power);
            fallen *= fall;
        }
        list.extend([(0, of_growth), (3, of_excess)]);
    }
    list
}

/// The two columns Re z and -Im z of the exponential of a component, times numbers.
struct Pair<'a> {
    component: usize,
    wave: &'a Powers,
    times: Times<'a>,
    /// The number of its first column among the derivatives, or among the exponentials for [`Times::One`].
    column: usize,
    /// Both columns in the rows of a block in which the component sounds.
    block: [Vec<f64>; 2],
}

#[derive(Clone, Copy)]
enum Times<'a> {
    One,
    /// The time of the row.
    Time,
    /// A number for each row.
    Each(&'a [f64]),
}

impl Pair<'_> {
    fn is_derivative(&self) -> bool {
        !matches!(self.times, Times::One)
    }

    fn fill(&mut self, from: usize, to: usize, step: f64) {
        let signed = [(&self.wave.re, 1.0), (&self.wave.im, -1.0)];
        for (block, (part, sign)) in self.block.iter_mut().zip(signed) {
            let part = &part[from..to];
            block.clear();
            match self.times {
                Times::One => block.extend(part.iter().map(|z| sign * z)),
                Times::Time => {
                    block.extend(part.iter().enumerate().map(|(n, z)| sign * z * ((from + n) as f64 * step)));
                }
                Times::Each(factor) => {
                    block.extend(part.iter().zip(&factor[from..to]).map(|(z, f)| sign * z * f))
                }
            }
        }
    }
}

/// Puts the products of all columns of which one belongs to a curved component into three Gram matrices,
/// which hold zeros there: of the exponentials, of these and their derivatives, and of the derivatives. Puts
/// into `slopes` the sums of the samples times the derivatives that [`factors`] lists. In all of them the
/// columns of these derivatives come last, component after component.
pub(super) fn put(
    white: White<'_>,
    waves: &[Powers],
    factors: &[Vec<(usize, Vec<f64>)>],
    [flat, mixed, curved]: [&mut Matrix; 3],
    slopes: &mut Matrix,
) {
    let mut pairs: Vec<Pair<'_>> = Vec::new();
    let mut beside = 2 * waves.len();
    for (component, (wave, list)) in waves.iter().zip(factors).enumerate() {
        let mut add = |times, column| {
            pairs.push(Pair { component, wave, times, column, block: Default::default() });
        };
        add(Times::One, 2 * component);
        add(Times::Time, 2 * component);
        for (_, factor) in list {
            add(Times::Each(factor), beside);
            beside += 2;
        }
    }
    // Products are the same in either order.
    let of_curved =
        |i: usize, j: usize| [i, j].iter().any(|&pair: &usize| !factors[pairs[pair].component].is_empty());
    let partners = |i: usize| (0..=i).map(move |j| (i, j));
    let both: Vec<(usize, usize)> =
        (0..pairs.len()).flat_map(partners).filter(|(i, j)| of_curved(*i, *j)).collect();
    let mut products = vec![[[0.0; 2]; 2]; both.len()];
    for from in (0..white.rows()).step_by(BLOCK) {
        for pair in &mut pairs {
            let sounds = pair.wave.re.len();
            pair.fill(from.min(sounds), (from + BLOCK).min(sounds), white.step);
        }
        for ((i, j), products) in both.iter().zip(&mut products) {
            let [left, right] = [&pairs[*i].block, &pairs[*j].block];
            let rows = left[0].len().min(right[0].len());
            let [left, right] = [left, right].map(|block| [&block[0][..rows], &block[1][..rows]]);
            for (sums, more) in products.iter_mut().zip(dots(left, right)) {
                *sums = [sums[0] + more[0], sums[1] + more[1]];
            }
        }
        let block = white.slice(from, from + BLOCK);
        for pair in pairs.iter().filter(|pair| matches!(pair.times, Times::Each(_))) {
            project(block, &pair.block, pair.column, slopes);
        }
    }
    for ((i, j), products) in both.into_iter().zip(products) {
        let (left, right) = (&pairs[i], &pairs[j]);
        for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (a, b, value) = (left.column + p, right.column + q, products[p][q]);
            match (left.is_derivative(), right.is_derivative()) {
                (false, false) => (flat[(a, b)], flat[(b, a)]) = (value, value),
                (false, true) => mixed[(a, b)] = value,
                (true, false) => mixed[(b, a)] = value,
                (true, true) => (curved[(a, b)], curved[(b, a)]) = (value, value),
            }
        }
    }
}

/// Adds the sums of the samples times two columns to the columns from `column` on.
fn project(white: White<'_>, columns: &[Vec<f64>; 2], column: usize, slopes: &mut Matrix) {
    for from in (0..white.channels).step_by(LANES) {
        let sums = run(Sums { white, from, columns });
        for (m, (a, b)) in (from..white.channels).zip(sums[0].into_iter().zip(sums[1])) {
            slopes[(m, column)] += a;
            slopes[(m, column + 1)] += b;
        }
    }
}

/// Sums of the samples times two columns for [`LANES`] channels from number `from` on; beyond the last
/// channel what comes next in the record is summed, and means nothing.
struct Sums<'a> {
    white: White<'a>,
    from: usize,
    columns: &'a [Vec<f64>; 2],
}

impl NullaryFnOnce for Sums<'_> {
    type Output = [[f64; LANES]; 2];

    #[inline(always)]
    fn call(self) -> [[f64; LANES]; 2] {
        let Self { white, from, columns } = self;
        let mut sums = [[0.0; LANES]; 2];
        for (n, (a, b)) in columns[0].iter().zip(&columns[1]).enumerate() {
            let y = row::<LANES>(white, n, from);
            for i in 0..LANES {
                sums[0][i] += y[i] * a;
                sums[1][i] += y[i] * b;
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::super::component::Law;
    use super::super::sums::phasors;
    use super::*;
    use rijke_numerics::C64;

    #[test]
    fn oracle_curved_components_and_their_derivatives_are_those_written_out() {
        let (rows, step) = (400, 1e-3);
        for law in [Law::Linear, Law::Square] {
            written_out(law, rows, step);
        }
    }

    fn written_out(law: Law, rows: usize, step: f64) {
        let curved = |s: C64, chirp: f64, excess: f64| Component {
            chirp: Some(chirp),
            excess: Some(excess),
            law,
            ..Component::new(s, crate::ringdown::Kind::Mode)
        };
        let power = f64::from(law.power());
        let written = |s: C64, chirp: f64, excess: f64, t: f64| {
            let envelope = (1.0 + excess * (1.0 - (power * s.re * t).exp())).powf(power.recip());
            (s * t + C64::new(0.0, 0.5 * chirp * t * t)).exp() / envelope
        };
        let (s, chirp, excess) = (C64::new(-6.0, 500.0), 40.0, 0.7);
        let component = curved(s, chirp, excess);
        let list = factors(&component, rows, step);
        assert_eq!(list.iter().map(|f| f.0).collect::<Vec<_>>(), [2, 0, 3]);
        for first in [0.0, 37.0] {
            let (powers, start) = phasors(&component, first, rows, step);
            for n in 0..rows {
                let exact = written(s, chirp, excess, (first + n as f64) * step);
                let found = C64::new(powers.re[n], powers.im[n]) * start;
                assert!((found - exact).norm() < 1e-10, "{first} {n}: {found} {exact}");
            }
        }
        for n in (0..rows).step_by(13) {
            let t = n as f64 * step;
            let slope = |of: &dyn Fn(f64) -> C64| (of(1e-5) - of(-1e-5)) / (2e-5 * of(0.0));
            let of_chirp = slope(&|d| written(s, chirp + d, excess, t)) / C64::I;
            let of_growth = slope(&|d| written(s + d, chirp, excess, t));
            let of_excess = slope(&|d| written(s, chirp, excess + d, t));
            for ((_, factor), exact) in list.iter().zip([of_chirp, of_growth, of_excess]) {
                assert!((factor[n] - exact).norm() < 1e-6, "{n}: {} {exact}", factor[n]);
            }
        }
    }
}
