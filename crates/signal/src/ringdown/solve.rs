//! Several damped exponentials shared by all channels: maximum likelihood by variable projection.
//!
//! The model of a white multichannel record is y_m(t) = sum_k Re(b_km e^{s_k t}) + white noise. The
//! amplitudes b are linear and are eliminated (Golub & Pereyra 1973); the frequencies follow from
//! Gauss-Newton steps with Kaufman's Jacobian. Every quantity needed is a sum over samples of products of
//! exponentials, powers of time and data: those without data have a closed form, so one pass over the
//! record per step is all the cost, 8 flops per sample, channel and component that still sounds.

use super::component::{Component, Kind, fundamental, with_fundamental};
use super::curved::{self, factors};
use super::solution::{Solution, energies_of};
use super::sums::{grams, lengths, phasors, project};
use super::white::White;
use crate::Fault;
use crate::dsp::kernels::Powers;
use crate::dsp::scaled::inverse_scaled;
use rijke_numerics::{C64, Cholesky, Matrix};

/// The free frequencies: `(component, direction)` pairs, see [`Solution::free`]. The mains fundamental, if
/// any, comes last and is listed once, unless it is `held`.
fn parameters(components: &[Component], held: bool) -> Vec<(usize, usize)> {
    let mut list = Vec::new();
    for (k, component) in components.iter().enumerate() {
        match component.kind {
            Kind::Mode => {
                list.extend([(k, 0), (k, 1)]);
                list.extend(component.chirp.map(|_| (k, 2)));
                list.extend(component.excess.map(|_| (k, 3)));
            }
            Kind::Tone => list.push((k, 1)),
            Kind::Mains(_) | Kind::Known => {}
        }
    }
    if let Some(k) = components.iter().position(|c| matches!(c.kind, Kind::Mains(_))).filter(|_| !held) {
        list.push((k, 1));
    }
    list
}

/// Steps after which the iteration gives up.
const MAX_STEPS: usize = 25;
/// The iteration ends when a step is this small in standard deviations: its error is then second order.
const SMALL_STEP: f64 = 1e-3;
/// A neighbour near the noise may keep wandering: then it is enough that the first component has settled to
/// this. With a tenth a record that saturates was accepted 11 standard deviations off.
const SETTLED: f64 = 0.05;
/// After so many steps only half of each is taken: a weak neighbour may overshoot to and fro.
const HALF_STEPS: usize = 8;
/// Share by which the fundamental of the mains may move. Grids stay within it; beyond it the harmonics
/// serve a mode beside one of them, and the fit settles where neither is.
pub(crate) const MAINS: f64 = 0.01;

/// An envelope with less excess of damping than this never was one of a decay.
const LEAST_EXCESS: f64 = -0.9;

/// Length of a full step, in standard deviations, after which no other is needed. Gauss-Newton contracts by
/// the ratio of residual to signal: what is left is far below a hundredth of a standard deviation.
pub(crate) const SETTLING: f64 = 0.03;
/// The same where a better fit follows.
pub(crate) const SEARCHING: f64 = 0.3;

/// Maximises the likelihood from the given first guess, until a step is shorter than `close` standard
/// deviations.
pub(crate) fn solve(white: White<'_>, start: &[Component], close: f64) -> Result<Solution, Fault> {
    let energy = white.energy();
    let mains = fundamental(start);
    let strays = |c: &[Component]| match (mains, fundamental(c)) {
        (Some(mains), Some(now)) => (now / mains - 1.0).abs() > MAINS,
        _ => false,
    };
    let mut state = State::new(white, start.to_vec(), energy, false)?;
    let (mut last, mut previous) = (f64::INFINITY, 0.0);
    for number in 0..MAX_STEPS {
        let Step { step, length, first } = state.gauss_newton_step()?;
        last = first;
        if length < SMALL_STEP {
            return state.finish();
        }
        if strays(&state.moved(&step, 1.0)) {
            let held = with_fundamental(state.components, mains.unwrap_or_default());
            state = State::new(white, held, energy, true)?;
            continue;
        }
        let mut factor = if number < HALF_STEPS { 1.0 } else { 0.5 };
        loop {
            let moved = state.moved(&step, factor);
            match State::new(white, moved, energy, state.held) {
                // The residual is a difference of large numbers: rounding may hide its last decrease.
                Ok(next) if next.residual <= state.residual + 1e-12 * energy => {
                    state = next;
                    break;
                }
                _ if first < SETTLED => return state.finish(),
                // A full step may leave the region where two close components are told apart.
                _ if factor > 1e-3 => factor *= 0.3,
                _ => return Err(Fault::NotConverged(MAX_STEPS, first)),
            }
        }
        // Near the end a step contracts as the one before it did.
        if factor == 1.0 && (length < close || length * length < 0.1 * close * previous) {
            return state.finish();
        }
        previous = length;
    }
    if last < SETTLED { state.finish() } else { Err(Fault::NotConverged(MAX_STEPS, last)) }
}

/// Where a first guess would lead, to first order: one step, not taken.
pub(crate) struct Glance {
    /// Where the components would be.
    pub(crate) components: Vec<Component>,
    /// Variance of the growth rate of the first one, for unit noise.
    pub(crate) variance: f64,
    /// Energy that each component explains at the frequencies of the guess: see [`energies`].
    pub(crate) energies: Vec<f64>,
    /// By how much the step would lower the sum of squares left over.
    pub(crate) gain: f64,
}

/// One Gauss-Newton step from the given components: a third of the cost of a fit.
pub(crate) fn glance(white: White<'_>, start: &[Component]) -> Result<Glance, Fault> {
    let state = State::new(white, start.to_vec(), 0.0, false)?;
    let (information, gradient) = state.information();
    let covariance = inverse_scaled(&information)?;
    let step = covariance.times(&gradient);
    let gain = step.iter().zip(&gradient).map(|(a, b)| a * b).sum::<f64>().max(0.0);
    let (components, variance) = (state.moved(&step, 1.0), covariance[(0, 0)]);
    Ok(Glance { components, variance, energies: state.energies()?, gain })
}

/// Energy that each component alone explains when all are fitted with their frequencies as given: the
/// squares of its amplitudes over their variances, summed over channels.
pub(crate) fn energies(white: White<'_>, components: &[Component]) -> Result<Vec<f64>, Fault> {
    State::new(white, components.to_vec(), 0.0, false)?.energies()
}

/// A Gauss-Newton step of the free frequencies.
struct Step {
    step: Vec<f64>,
    /// Its length in standard deviations.
    length: f64,
    /// The same for the frequencies of the first component alone.
    first: f64,
}

/// Sums over the samples at one set of frequencies.
struct State {
    components: Vec<Component>,
    /// Whether the fundamental of the mains is held where it is.
    held: bool,
    free: Vec<(usize, usize)>,
    /// The component and the direction of each derivative column beside t times the exponentials.
    beside: Vec<(usize, usize)>,
    /// Linear coefficients, one row per channel.
    coefficients: Matrix,
    /// What the derivative columns see of the residual, one row per channel.
    slopes: Matrix,
    linear: Matrix,
    /// Gram of linear columns (rows) and derivative columns.
    mixed: Matrix,
    /// Gram of the derivative columns with the linear columns projected out.
    projected: Matrix,
    residual: f64,
    freedom: f64,
}

impl State {
    fn new(white: White<'_>, components: Vec<Component>, energy: f64, held: bool) -> Result<Self, Fault> {
        if components.iter().any(|c| c.excess.is_some_and(|excess| excess <= LEAST_EXCESS)) {
            return Err(Fault::NotConverged(MAX_STEPS, f64::INFINITY));
        }
        let (rows, count) = (white.rows(), components.len());
        let size = 2 * count;
        let lengths = lengths(&components, rows, white.step);
        let waves: Vec<Powers> =
            components.iter().zip(&lengths).map(|(c, n)| phasors(c, 0.0, *n, white.step).0).collect();
        let factors: Vec<Vec<(usize, Vec<f64>)>> =
            components.iter().zip(&lengths).map(|(c, n)| factors(c, *n, white.step)).collect();
        // Derivative columns: t times each column, then what the curved components have beside.
        let of = |(k, list): (usize, &Vec<(usize, Vec<f64>)>)| list.iter().map(move |f| (k, f.0)).collect();
        let beside: Vec<(usize, usize)> = factors.iter().enumerate().flat_map::<Vec<_>, _>(of).collect();
        let wide = size + 2 * beside.len();
        let [mut flat, once, twice] = grams(&components, &lengths, white.step);
        let part = |gram: &Matrix, i: usize, j: usize| if i.max(j) < size { gram[(i, j)] } else { 0.0 };
        let mut mixed = Matrix::from_fn(size, wide, |i, j| part(&once, i, j));
        let mut curved = Matrix::from_fn(wide, wide, |i, j| part(&twice, i, j));
        let mut data = Matrix::zeros(white.channels, size);
        let mut slopes = Matrix::zeros(white.channels, wide);
        for (k, wave) in waves.iter().enumerate() {
            project(white, wave, k, &mut data, &mut slopes);
        }
        if !beside.is_empty() {
            let grams = [&mut flat, &mut mixed, &mut curved];
            curved::put(white, &waves, &factors, grams, &mut slopes);
        }
        let linear = Cholesky::new(&flat)?.inverse();
        let projected = curved.plus(-1.0, &mixed.transpose().product(&linear.product(&mixed)));
        let coefficients = data.product(&linear);
        let explained: f64 = data.as_slice().iter().zip(coefficients.as_slice()).map(|(a, b)| a * b).sum();
        let slopes = slopes.plus(-1.0, &coefficients.product(&mixed));
        let free = parameters(&components, held);
        let freedom = (rows * white.channels) as f64 - (white.channels * size + free.len()) as f64;
        let residual = energy - explained;
        Ok(Self {
            components,
            held,
            free,
            beside,
            coefficients,
            slopes,
            linear,
            mixed,
            projected,
            residual,
            freedom,
        })
    }

    fn energies(&self) -> Result<Vec<f64>, Fault> {
        let amplitude = |k: usize, m: usize| {
            let c = self.coefficients.row(m);
            C64::new(c[2 * k], c[2 * k + 1])
        };
        energies_of(&self.linear, amplitude, self.coefficients.rows())
    }

    /// The derivative column of component `k` in a direction.
    fn column(&self, k: usize, direction: usize) -> usize {
        let beside = self.beside.iter().position(|b| *b == (k, direction));
        2 * beside.map_or(k, |place| self.components.len() + place)
    }

    /// Derivative of the model of channel `m` in the derivative columns: `(free frequency, column, value)`
    /// where it is not zero.
    fn directions(&self, m: usize) -> Vec<(usize, usize, f64)> {
        let c = self.coefficients.row(m);
        let mut entries = Vec::with_capacity(2 * c.len());
        for (j, &(k, direction)) in self.free.iter().enumerate() {
            let mut set = |k: usize, factor: f64| {
                // d/d sigma multiplies the amplitude by t, d/d omega by i t, d/d chi by i t^2/2.
                let (re, im) = (c[2 * k], c[2 * k + 1]);
                let (a, b) = if matches!(direction, 0 | 3) { (re, im) } else { (-im, re) };
                let column = self.column(k, direction);
                entries.extend([(j, column, factor * a), (j, column + 1, factor * b)]);
            };
            if let Kind::Mains(_) = self.components[k].kind {
                for (l, component) in self.components.iter().enumerate() {
                    if let Kind::Mains(h) = component.kind {
                        set(l, f64::from(h));
                    }
                }
            } else {
                set(k, 1.0);
            }
        }
        entries
    }

    /// Information about the free frequencies (for unit noise) and gradient.
    fn information(&self) -> (Matrix, Vec<f64>) {
        let n = self.free.len();
        let mut information = Matrix::zeros(n, n);
        let mut gradient = vec![0.0; n];
        for m in 0..self.coefficients.rows() {
            let (entries, slopes) = (self.directions(m), self.slopes.row(m));
            for &(i, row, a) in &entries {
                gradient[i] += a * slopes[row];
                let weights = self.projected.row(row);
                for &(j, column, b) in &entries {
                    information[(i, j)] += a * weights[column] * b;
                }
            }
        }
        (information, gradient)
    }

    fn gauss_newton_step(&self) -> Result<Step, Fault> {
        let (information, gradient) = self.information();
        let covariance = inverse_scaled(&information)?;
        let step = covariance.times(&gradient);
        let scale = self.freedom / self.residual.max(f64::MIN_POSITIVE);
        let decrement: f64 = step.iter().zip(&gradient).map(|(a, b)| a * b).sum();
        let first = self.free.iter().enumerate().filter(|(_, free)| free.0 == 0);
        let squares = first.map(|(j, _)| step[j].powi(2) / covariance[(j, j)] * scale);
        let first = squares.fold(0.0, f64::max).sqrt();
        Ok(Step { step, length: (decrement.max(0.0) * scale).sqrt(), first })
    }

    fn moved(&self, step: &[f64], factor: f64) -> Vec<Component> {
        let mut components = self.components.clone();
        for (&(k, direction), d) in self.free.iter().zip(step) {
            let change = factor * d;
            match components[k].kind {
                Kind::Mains(_) => {
                    for component in &mut components {
                        if let Kind::Mains(h) = component.kind {
                            component.s.im += f64::from(h) * change;
                        }
                    }
                }
                _ if direction == 0 => components[k].s.re += change,
                _ if direction == 2 => components[k].chirp = components[k].chirp.map(|chirp| chirp + change),
                _ if direction == 3 => components[k].excess = components[k].excess.map(|x| x + change),
                _ => components[k].s.im += change,
            }
        }
        components
    }

    fn finish(self) -> Result<Solution, Fault> {
        let covariance = inverse_scaled(&self.information().0)?;
        let lift = self.linear.product(&self.mixed);
        let channels = self.coefficients.rows();
        let sensitivity = (0..channels)
            .map(|m| {
                let mut sensitivity = Matrix::zeros(lift.rows(), self.free.len());
                for (j, column, value) in self.directions(m) {
                    for i in 0..lift.rows() {
                        sensitivity[(i, j)] -= lift[(i, column)] * value;
                    }
                }
                sensitivity
            })
            .collect();
        let amplitudes = (0..self.components.len())
            .map(|k| {
                let at =
                    |m: usize| C64::new(self.coefficients[(m, 2 * k)], self.coefficients[(m, 2 * k + 1)]);
                (0..channels).map(at).collect()
            })
            .collect();
        let (components, residual, freedom, linear, free) =
            (self.components, self.residual, self.freedom, self.linear, self.free);
        Ok(Solution { components, amplitudes, residual, freedom, covariance, linear, sensitivity, free })
    }
}
