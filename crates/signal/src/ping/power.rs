//! The power of noise that rings a mode, by restricted maximum likelihood (Patterson & Thompson, Biometrika
//! 58 (1971) 545).
//!
//! The record is projected on the mode's shape, turned back by its frequency, and averaged over stretches of
//! a quarter of a decay time. These means hold white noise of the variance w, and means of an
//! Ornstein-Uhlenbeck process of the power R: their covariance is V = R C + w 1. The columns that a fit has
//! taken out of the decay (the mode, its slopes, its neighbours) are projected out. Differences of
//! neighbouring stretches alone would tell of R only where it is many times w.

use crate::ringdown::{Kind, Solution, White};
use rijke_numerics::{C64, Cholesky, Matrix};
use std::f64::consts::TAU;

/// Share of the decay time of a stretch, fewest stretches, and most that are correlated with each other.
const STRETCH: f64 = 0.25;
const FEWEST: usize = 6;
const MOST: usize = 64;
/// Powers that are tried, over the variance of a stretch's white noise: from the first on, each this many
/// times the one before.
const LEAST: f64 = 1e-2;
const TIMES: f64 = 1.5;
const TRIED: i32 = 40;
/// Nats by which noise of the mode must be more likely than none.
const CLEAR: f64 = 3.0;
/// Distance from the mode, in the larger of the two decay rates, up to which a neighbour in the fit takes
/// noise of the mode with it.
const BESIDE: f64 = 10.0;
/// Share of a column's energy below which the columns before it explain it.
const NOTHING: f64 = 1e-9;

/// Power of narrow noise as stretches of white noise show it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Power {
    pub(crate) value: f64,
    pub(crate) sd: f64,
    /// Degrees of freedom of a sum of squares that would be as uncertain.
    pub(crate) freedom: f64,
    /// Whether it is more than chance.
    pub(crate) clear: bool,
}

/// Means over stretches, and the columns that a fit took out of them.
type Run = (Vec<C64>, Vec<Vec<C64>>);

/// Power of the noise that rings the first mode of `found`, as whitened samples show it: those of a
/// `silence`, and what the fit has `left`, from its first row on. None if they are too short.
pub(crate) fn power(found: &Solution, silence: White<'_>, left: Option<White<'_>>) -> Option<Power> {
    let (s, shape, step) = (found.components[0].s, &found.amplitudes[0], silence.step);
    let a = -s.re;
    let period = TAU / (s.im * step);
    let span = ((STRETCH / (a * step) / period).round().max(1.0) * period).round().max(2.0) as usize;
    let mut runs: Vec<Run> = Vec::new();
    let all = [(silence, false)].into_iter().chain(left.map(|left| (left, true)));
    for (run, fitted) in all {
        let means = means(run, s, shape, span);
        for (k, part) in means.chunks(MOST).enumerate() {
            // The fit takes nothing out of what comes 16 decay times after its start.
            let columns =
                if fitted && k == 0 { taken_out(found, part.len(), span, step) } else { Vec::new() };
            runs.push((part.to_vec(), columns));
        }
    }
    most_likely(&runs, 4.0 / span as f64, a * span as f64 * step)
}

/// The power that makes the runs most likely, of white noise of the variance `white`; a stretch lasts `u`
/// decay times. None if there are too few stretches.
fn most_likely(runs: &[Run], white: f64, u: f64) -> Option<Power> {
    let count: usize = runs.iter().map(|(z, _)| z.len()).sum();
    if count < FEWEST {
        return None;
    }
    let likelihood = |power: f64| runs.iter().map(|(z, b)| ln_likelihood(z, b, power, white, u)).sum::<f64>();
    let none = likelihood(0.0);
    let tried = |k: f64| LEAST * white * TIMES.powf(k);
    let values: Vec<f64> = (0..TRIED).map(|k| likelihood(tried(f64::from(k)))).collect();
    let best = (0..values.len()).max_by(|i, j| values[*i].total_cmp(&values[*j]))?;
    // A parabola in the logarithm of the power through the best and its neighbours.
    let middle = best.clamp(1, values.len() - 2);
    let [below, here, above] = [values[middle - 1], values[middle], values[middle + 1]];
    let bend = (2.0 * here - below - above).max(f64::MIN_POSITIVE);
    let shift = (0.5 * (above - below) / bend).clamp(-1.0, 1.0);
    let value = tried(middle as f64 + shift);
    let relative = TIMES.ln() / bend.sqrt();
    let freedom = (2.0 / (relative * relative)).clamp(4.0, 2.0 * count as f64);
    let clear = values[best] - none > CLEAR;
    let value = if values[best] > none { value } else { 0.0 };
    Some(Power { value, sd: value * relative.min(1.0), freedom, clear })
}

/// Means over stretches along the mode's shape and turn: of the amplitude, if its shape has the norm 1.
fn means(run: White<'_>, s: C64, shape: &[C64], span: usize) -> Vec<C64> {
    let size = shape.iter().map(C64::norm_sqr).sum::<f64>().sqrt();
    let (turn, mut phasor) = (C64::from_polar(1.0, -s.im * run.step), C64::ONE);
    let of = |part: &[f64]| {
        let mut mean = C64::ZERO;
        for row in part.chunks_exact(run.channels) {
            let along: C64 = row.iter().zip(shape).map(|(y, b)| b.conj() * y).sum();
            mean += along * phasor;
            phasor *= turn;
        }
        mean * (2.0 / (span as f64 * size))
    };
    run.samples.chunks_exact(span * run.channels).map(of).collect()
}

/// What a fit takes out of the stretches, as columns: the mode, its slopes, and neighbours.
fn taken_out(found: &Solution, count: usize, span: usize, step: f64) -> Vec<Vec<C64>> {
    let mode = found.components[0];
    let time = |j: usize| (j as f64 + 0.5) * span as f64 * step;
    let column = |s: C64, power: i32| -> Vec<C64> {
        (0..count).map(|j| (s * time(j)).exp() * (time(j) * -mode.s.re).powi(power)).collect()
    };
    let own = C64::new(mode.s.re, 0.0);
    let mut columns = vec![column(own, 0), column(own, 1)];
    if mode.chirp.is_some() {
        columns.push(column(own, 2));
    }
    if mode.excess.is_some() {
        columns.push(column(own * f64::from(1 + mode.law.power()), 0));
    }
    for other in found.components.iter().skip(1).filter(|c| matches!(c.kind, Kind::Mode | Kind::Tone)) {
        let beside = C64::new(other.s.re, other.s.im - mode.s.im);
        if beside.im.abs() < BESIDE * mode.s.re.abs().max(other.s.re.abs()) {
            columns.extend([column(beside, 0), column(beside, 1)]);
        }
    }
    columns
}

/// ln of the restricted likelihood of one run.
fn ln_likelihood(z: &[C64], columns: &[Vec<C64>], power: f64, white: f64, u: f64) -> f64 {
    let keep = (-u).exp();
    let (own, next) = (2.0 * (u - 1.0 + keep) / (u * u), ((1.0 - keep) / u).powi(2));
    let of_power: Vec<f64> =
        (0..z.len()).map(|k| if k == 0 { own } else { next * keep.powi(k as i32 - 1) }).collect();
    let covariance = Matrix::from_fn(z.len(), z.len(), |i, j| {
        power * of_power[i.abs_diff(j)] + if i == j { white } else { 0.0 }
    });
    let Ok(factor) = Cholesky::new(&covariance) else { return f64::NEG_INFINITY };
    let whiten = |v: &[C64]| -> Vec<C64> {
        let part = |of: fn(&C64) -> f64| factor.whiten(&v.iter().map(of).collect::<Vec<_>>());
        part(|z| z.re).into_iter().zip(part(|z| z.im)).map(|(re, im)| C64::new(re, im)).collect()
    };
    let mut left = whiten(z);
    let mut ln = -factor.ln_det();
    let mut basis: Vec<Vec<C64>> = Vec::new();
    for column in columns {
        let mut rest = whiten(column);
        let whole: f64 = rest.iter().map(C64::norm_sqr).sum();
        basis.iter().for_each(|unit| take_out(&mut rest, unit));
        let square: f64 = rest.iter().map(C64::norm_sqr).sum();
        if square > NOTHING * whole {
            ln -= square.ln();
            rest.iter_mut().for_each(|v| *v /= square.sqrt());
            take_out(&mut left, &rest);
            basis.push(rest);
        }
    }
    ln - left.iter().map(C64::norm_sqr).sum::<f64>()
}

/// Takes a unit vector out of another one.
fn take_out(v: &mut [C64], unit: &[C64]) {
    let along: C64 = unit.iter().zip(&*v).map(|(u, v)| u.conj() * v).sum();
    v.iter_mut().zip(unit).for_each(|(v, u)| *v -= along * u);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rijke_numerics::Streams;

    const U: f64 = 0.25;

    /// Means of an Ornstein-Uhlenbeck process of the power `power`, step by step, in white noise of variance
    /// 1, from which a decay and its slope are taken out by least squares.
    fn run(seed: u64, power: f64, count: usize) -> Run {
        const FINE: usize = 50;
        let mut stream = Streams::new(seed).stream("power");
        let mut normal = || -> C64 {
            let mut one = || -> f64 { StandardNormal.sample(&mut stream) };
            C64::new(one(), one()) * 0.5_f64.sqrt()
        };
        let keep = (-U / FINE as f64).exp();
        let mut now = normal() * power.sqrt();
        let mut z: Vec<C64> = (0..count)
            .map(|_| {
                let mut sum = C64::ZERO;
                for _ in 0..FINE {
                    sum += now;
                    now = now * keep + normal() * (power * (1.0 - keep * keep)).sqrt();
                }
                sum / FINE as f64 + normal()
            })
            .collect();
        let time = |j: usize| (j as f64 + 0.5) * U;
        let columns: Vec<Vec<C64>> = [0, 1]
            .map(|k| (0..count).map(|j| C64::from(time(j).powi(k) * (-time(j)).exp())).collect())
            .into();
        let mut basis: Vec<Vec<C64>> = Vec::new();
        for mut column in columns.clone() {
            basis.iter().for_each(|unit| take_out(&mut column, unit));
            let size = column.iter().map(C64::norm_sqr).sum::<f64>().sqrt();
            column.iter_mut().for_each(|v| *v /= size);
            take_out(&mut z, &column);
            basis.push(column);
        }
        (z, columns)
    }

    #[test]
    fn coverage_of_the_power_of_noise_beside_a_decay_that_was_fitted() {
        const SEEDS: u64 = 200;
        for (power, clear) in [(0.0, 0..=4), (0.3, 60..=200), (3.0, 198..=200)] {
            let found: Vec<Power> =
                (0..SEEDS).map(|seed| most_likely(&[run(seed, power, 50)], 1.0, U).unwrap()).collect();
            let mean = found.iter().map(|p| p.value).sum::<f64>() / SEEDS as f64;
            let seen = found.iter().filter(|p| p.clear).count();
            println!("power {power}: mean {mean:.3}, clear {seen} of {SEEDS}");
            assert!(clear.contains(&seen), "{power}: {seen}");
            let scatter = found.iter().map(|p| (p.value - power).powi(2)).sum::<f64>() / SEEDS as f64;
            let error = (scatter / SEEDS as f64).sqrt();
            assert!(power == 0.0 || (mean - power).abs() < 4.0 * error + 0.05 * power, "{power}: {mean}");
            let stated = found.iter().map(|p| p.sd * p.sd).sum::<f64>() / SEEDS as f64;
            assert!(power < 1.0 || (0.6..1.6).contains(&(stated / scatter)), "{power}: {stated} {scatter}");
        }
    }

    #[test]
    fn exact_the_likelihood_is_that_of_what_is_at_right_angles_to_the_columns() {
        // In an orthonormal basis K of what is at right angles to B, K* z has the covariance K* V K.
        let (z, columns) = run(7, 1.0, 12);
        let both: Vec<f64> = [0.1, 2.0].map(|power| ln_likelihood(&z, &columns, power, 1.0, U)).into();
        let mut basis: Vec<Vec<C64>> = Vec::new();
        let units = (0..12).map(|k| (0..12).map(|j| C64::from(f64::from(u8::from(j == k)))).collect());
        for mut v in columns.iter().cloned().chain(units) {
            basis.iter().for_each(|unit| take_out(&mut v, unit));
            let size = v.iter().map(C64::norm_sqr).sum::<f64>().sqrt();
            if size > 1e-6 {
                v.iter_mut().for_each(|v| *v /= size);
                basis.push(v);
            }
        }
        let inner = |a: &[C64], b: &[C64]| a.iter().zip(b).map(|(a, b)| (a.conj() * b).re).sum::<f64>();
        let rest = &basis[2..];
        assert_eq!(rest.len(), 10);
        let direct = |power: f64| {
            let keep = (-U).exp();
            let (own, next) = (2.0 * (U - 1.0 + keep) / (U * U), ((1.0 - keep) / U).powi(2));
            let v = |i: usize, j: usize| match i.abs_diff(j) {
                0 => power * own + 1.0,
                apart => power * next * keep.powi(apart as i32 - 1),
            };
            let through =
                |b: &[C64]| -> Vec<C64> { (0..12).map(|i| (0..12).map(|j| b[j] * v(i, j)).sum()).collect() };
            let covariance = Matrix::from_fn(10, 10, |i, j| inner(&rest[i], &through(&rest[j])));
            let factor = Cholesky::new(&covariance).unwrap();
            let [re, im] = [|z: &C64| z.re, |z: &C64| z.im].map(|of| {
                let part: Vec<f64> =
                    rest.iter().map(|k| k.iter().zip(&z).map(|(k, z)| k.re * of(z)).sum()).collect();
                factor.whiten(&part).iter().map(|v| v * v).sum::<f64>()
            });
            -factor.ln_det() - re - im
        };
        assert!(((both[1] - both[0]) - (direct(2.0) - direct(0.1))).abs() < 1e-9);
    }
}
