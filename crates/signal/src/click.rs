//! Arrival time of one impulse at every channel: all channels brought optimally in phase.
//!
//! The impulse has the same, unknown, band-limited waveform w in every channel. In a window that follows it,
//!
//! y_m(t) = a_m [w(t - t_m) + sum_j rho_j w(t - t_m - gap_m - j h)] + slow background + noise,
//!
//! with real gains a_m (negative: inverted) and a reflection of a few real taps rho_j where it overlaps the direct
//! impulse; elsewhere the window ends before the reflection begins. The background is a parabola: over a millisecond
//! that is all hum and drift can be. The known dispersion of the path is undone beforehand. Maximum likelihood over
//! times, gains, taps, waveform and backgrounds together is the weighted sum of all pairwise cross-correlations at its
//! maximum, interpolated without error between samples.

use crate::pulse::Located;
use crate::segment::Segment;
use crate::waveform::{Waveform, comparison_frequencies};
use crate::{Fault, Trace};
use rijke_numerics::{C64, Cholesky, Matrix};

/// What the fit may assume.
#[derive(Clone, Debug, PartialEq)]
pub struct ClickOptions {
    /// Frequencies that the impulse holds, Hz. For a tube the upper one stays below the cut-on of its first transverse
    /// mode.
    pub band_hz: (f64, f64),
    /// How long before and after its peak the record is used, s. The impulse itself is zero in the last eighth at each
    /// end.
    pub window: (f64, f64),
    /// Dispersion kappa of the path to each channel, s^{1/2}: the path multiplies the spectrum with
    /// e^{-(1+i) kappa sqrt(omega)}. Empty for none. In a tube of radius a, with kinematic viscosity nu,
    /// kappa = x / (a c) sqrt(nu / 2) (1 + (gamma - 1) / sqrt(Pr)) (Kirchhoff 1868).
    pub dispersion: Vec<f64>,
    /// The first reflection, if there is one that may overlap the impulse.
    pub reflection: Option<Reflection>,
}

/// What is known beforehand about the first reflection, such as that at the far end of a tube.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflection {
    /// Lag behind the direct impulse at each channel, s.
    pub lags: Vec<f64>,
    /// Reflection coefficient at low frequency, -1 for an open end.
    pub strength: f64,
    /// Standard deviation of the Gaussian that smooths the impulse in the reflection, s. An open end of radius a
    /// reflects as 1 - (k a)^2 / 2 (Levine & Schwinger 1948): a / c.
    pub smoothing: f64,
    /// Standard deviation of each tap about that expectation, relative to `strength`.
    pub tolerance: f64,
}

impl Default for ClickOptions {
    /// For a tube of 5 cm: 300 Hz to 4 kHz, an impulse that is over within 0.7 ms of its peak.
    fn default() -> Self {
        Self { band_hz: (300.0, 4000.0), window: (0.8e-3, 0.8e-3), dispersion: Vec::new(), reflection: None }
    }
}

/// One impulse, fitted. Times count from the end of the quiet part (the trigger) and contain channel delays and an
/// origin of the waveform that is arbitrary until a calibration fixes it: see [`crate::ChannelDelays`].
#[derive(Clone, Debug)]
pub struct ClickFit {
    /// Arrival times, s; that of channel `pivot` is exact by definition, its error sits in the waveform.
    pub times: Vec<f64>,
    /// Gain of each channel relative to channel `pivot`; negative if inverted.
    pub gains: Vec<f64>,
    /// Covariance of `times`, s^2, relative to `pivot` (whose row is zero).
    pub covariance: Matrix,
    /// The strongest channel.
    pub pivot: usize,
    /// Angular frequencies of the waveform, rad/s.
    pub frequencies: Vec<f64>,
    /// Spectrum of the waveform at these, in the gain of the pivot channel and an arbitrary unit per frequency.
    pub waveform: Vec<C64>,
    /// Taps of the reflection; empty if none was fitted.
    pub reflection: Vec<f64>,
    /// Root of (energy over noise energy) per channel: the amplitude that a matched filter sees.
    pub signal_to_noise: Vec<f64>,
    /// Sum of squared residuals over its number of degrees of freedom.
    pub chi_squared: f64,
    /// Covariance of times, then of real and imaginary parts of the waveform.
    pub(crate) joint: Matrix,
}

/// Taps of the reflection and their spacing, s: an open end reflects high frequencies less and a little later (|R|
/// falls from 1 to 0.5 at 3 kHz in a tube of 5 cm).
const TAPS: usize = 5;
const TAP_SPACING: f64 = 0.06e-3;
/// Gauss-Newton steps before giving up, and the step (in sd) at which it ends.
const MAX_STEPS: usize = 20;
const SMALL_STEP: f64 = 1e-2;
/// Windows follow the impulse during the first steps and stay from then on, so that the sum of squares is smooth.
const MOVING_STEPS: usize = 3;
/// Relative weight of a prior that the waveform is zero: bounds what the samples leave open at its ends.
const RIDGE: f64 = 1e-6;
/// Coefficients at each end of the waveform that are zero: the impulse begins and ends inside its window.
const SILENT: usize = 2;
/// Residual energy over impulse energy above which the channels do not show the same impulse.
const MISFIT: f64 = 0.05;

/// Fits one impulse by maximum likelihood. Cost: of the order of ten milliseconds for 8 channels of 6250 samples.
///
/// The covariance is the inverse Fisher information for white noise as measured in the quiet part; if residuals exceed
/// it significantly (a waveform that changes along the path, say), it is scaled up with them.
///
/// # Errors
/// A [`Fault`] that says why the record must not be used.
pub fn fit_click(trace: &Trace<'_>, options: &ClickOptions) -> Result<ClickFit, Fault> {
    let located = Located::find(trace, options)?;
    let segment = Segment::new(trace, &located.times, options)?;
    let mut fit = Model::start(&located, &segment, options);
    let mut rows = segment.windows(&fit.times, options);
    let mut last = f64::INFINITY;
    for step_number in 0..MAX_STEPS {
        if step_number <= MOVING_STEPS {
            rows = segment.windows(&fit.times, options);
        }
        let (normal, gradient, _) = fit.linearise(&segment, &rows);
        let step = solve_scaled(&normal, &gradient)?;
        let length = step.iter().zip(&gradient).map(|(a, b)| a * b).sum::<f64>().max(0.0).sqrt();
        fit.advance(&step);
        if step_number <= MOVING_STEPS {
            fit.centre();
        }
        last = length;
        if length < SMALL_STEP && step_number > MOVING_STEPS {
            break;
        }
    }
    if last > 0.1 {
        return Err(Fault::NotConverged { steps: MAX_STEPS, step: last });
    }
    let (normal, _, squares) = fit.linearise(&segment, &rows);
    let samples: usize = rows.iter().map(|r| r.1 - r.0).sum();
    let unknowns = normal.rows() + 3 * rows.len();
    let freedom = samples.saturating_sub(unknowns).max(1) as f64;
    let chi_squared = squares / freedom;
    let signal_to_noise = fit.signal_to_noise(&segment, &rows);
    let energy: f64 = signal_to_noise.iter().map(|v| v * v).sum();
    if squares - freedom > MISFIT * energy && chi_squared > 1.0 + 5.0 * (2.0 / freedom).sqrt() {
        let channel = fit.worst_channel(&segment, &rows);
        let at = trace.quiet.min(trace.len()) as f64 / trace.rate_hz + fit.times[channel];
        return Err(Fault::Residual { at, channel, ratio: chi_squared, frequency_hz: options.band_hz.0 });
    }
    let significant = chi_squared > 1.0 + 3.0 * (2.0 / freedom).sqrt();
    let excess = if significant || !segment.noise_known { chi_squared } else { 1.0 };
    let frequencies = comparison_frequencies(options.band_hz);
    Ok(fit.report(&inverse_scaled(&normal)?, excess, chi_squared, signal_to_noise, frequencies))
}

/// The unknowns.
struct Model<'a> {
    options: &'a ClickOptions,
    pivot: usize,
    times: Vec<f64>,
    gains: Vec<f64>,
    taps: Vec<f64>,
    /// The taps expected beforehand.
    expected: Vec<f64>,
    waveform: Waveform,
}

/// First and one past the last sample of the window of each channel.
type Rows = Vec<(usize, usize)>;

impl<'a> Model<'a> {
    fn start(located: &Located, segment: &Segment, options: &'a ClickOptions) -> Self {
        let channels = located.times.len();
        let needed = (0..channels).any(|m| options.overlaps(m));
        let taps = options.reflection.as_ref().filter(|_| needed).map(Reflection::taps).unwrap_or_default();
        let waveform = Waveform::new(options.window.0, options.window.1, segment.highest_hz);
        let mut model = Self {
            options,
            pivot: located.pivot,
            times: located.times.clone(),
            gains: located.gains.clone(),
            expected: taps.clone(),
            taps,
            waveform,
        };
        // A first waveform by linear least squares, from the strongest channel alone.
        let rows = segment.windows(&model.times, options);
        let size = model.waveform.coefficients.len();
        let (mut normal, mut right) = (Matrix::zeros(size, size), vec![0.0; size]);
        for n in rows[model.pivot].0..rows[model.pivot].1 {
            let basis: Vec<_> = model.waveform.basis(segment.time(n) - model.times[model.pivot]).collect();
            for &(i, a, _) in &basis {
                right[i] += a * segment.at(model.pivot, n);
                for &(j, b, _) in &basis {
                    normal[(i, j)] += a * b;
                }
            }
        }
        for i in 0..size {
            normal[(i, i)] += 1e-3;
        }
        if let Ok(factor) = Cholesky::new(&normal) {
            model.waveform.coefficients = factor.solve(&right);
        }
        model
    }

    /// Lag of tap `j` behind the direct impulse at channel `m`.
    fn lag(&self, m: usize, j: usize) -> f64 {
        let lag = self.options.reflection.as_ref().map_or(0.0, |r| r.lags[m]);
        lag + TAP_SPACING * (j as f64 - (TAPS / 2) as f64)
    }

    /// Where the time of channel `m` sits among the unknowns; its gain follows `channels - 1` later.
    fn free(&self, m: usize) -> Option<usize> {
        match m.cmp(&self.pivot) {
            std::cmp::Ordering::Less => Some(m),
            std::cmp::Ordering::Equal => None,
            std::cmp::Ordering::Greater => Some(m - 1),
        }
    }

    /// Impulse with reflection at one time after t_m: value and slope, for unit gain.
    fn shape(&self, m: usize, t: f64) -> (f64, f64) {
        let mut sum = self.waveform.at(t);
        if self.options.overlaps(m) {
            for (j, rho) in self.taps.iter().enumerate() {
                let (value, slope) = self.waveform.at(t - self.lag(m, j));
                sum = (sum.0 + rho * value, sum.1 + rho * slope);
            }
        }
        sum
    }

    /// Normal matrix, gradient and sum of squares of the residuals in units of the noise, backgrounds eliminated.
    fn linearise(&self, segment: &Segment, rows: &Rows) -> (Matrix, Vec<f64>, f64) {
        let (others, taps, size) = (self.times.len() - 1, self.taps.len(), self.waveform.coefficients.len());
        let total = 2 * others + taps + size;
        let mut normal = Matrix::zeros(total, total);
        let mut gradient = vec![0.0; total];
        let mut squares = 0.0;
        for (m, &(from, to)) in rows.iter().enumerate() {
            let (gain, reflected) = (self.gains[m], self.options.overlaps(m));
            let place = |i: usize| match (i, self.free(m)) {
                (0, Some(free)) => Some(free),
                (1, Some(free)) => Some(others + free),
                (0 | 1, None) => None,
                _ if i < 2 + taps => reflected.then_some(2 * others + i - 2),
                _ => Some(2 * others + i - 2),
            };
            let width = 2 + taps + size;
            // Columns side by side, the residual last.
            let mut design = vec![vec![0.0; to - from]; width + 1];
            for n in from..to {
                let t = segment.time(n) - self.times[m];
                let (value, slope) = self.shape(m, t);
                design[0][n - from] = -gain * slope;
                design[1][n - from] = value;
                design[width][n - from] = segment.at(m, n) - gain * value;
                for (k, phi, _) in self.waveform.basis(t) {
                    design[2 + taps + k][n - from] += gain * phi;
                }
                if reflected {
                    for (j, rho) in self.taps.iter().enumerate() {
                        let late = t - self.lag(m, j);
                        design[2 + j][n - from] = gain * self.waveform.at(late).0;
                        for (k, phi, _) in self.waveform.basis(late) {
                            design[2 + taps + k][n - from] += gain * rho * phi;
                        }
                    }
                }
            }
            let weight = segment.noise[m].recip();
            for column in &mut design {
                remove_parabola(column, weight);
            }
            for i in 0..width {
                let Some(a) = place(i) else { continue };
                gradient[a] += dot(&design[i], &design[width]);
                for j in 0..=i {
                    let Some(b) = place(j) else { continue };
                    let value = dot(&design[i], &design[j]);
                    normal[(a, b)] += value;
                    if a != b {
                        normal[(b, a)] += value;
                    }
                }
            }
            squares += dot(&design[width], &design[width]);
        }
        self.add_prior(2 * others, &mut normal, &mut gradient);
        (normal, gradient, squares)
    }

    /// Adds to the normal equations what is known about taps and waveform without the record. The unknown parabola of
    /// each background would leave that of the waveform open, were it not that the impulse begins and ends with zero.
    fn add_prior(&self, first: usize, normal: &mut Matrix, gradient: &mut [f64]) {
        let taps = self.taps.len();
        if let Some(reflection) = &self.options.reflection {
            let weight = (reflection.tolerance * reflection.strength).powi(-2);
            for (j, (tap, expected)) in self.taps.iter().zip(&self.expected).enumerate() {
                normal[(first + j, first + j)] += weight;
                gradient[first + j] -= weight * (tap - expected);
            }
        }
        let (start, size) = (first + taps, self.waveform.coefficients.len());
        let largest = (start..start + size).map(|i| normal[(i, i)]).fold(0.0, f64::max);
        for (k, c) in self.waveform.coefficients.iter().enumerate() {
            let end = k < SILENT || k + SILENT >= size;
            let weight = largest * if end { 1.0 } else { RIDGE };
            normal[(start + k, start + k)] += weight;
            gradient[start + k] -= weight * c;
        }
    }

    fn advance(&mut self, step: &[f64]) {
        let others = self.times.len() - 1;
        for m in 0..self.times.len() {
            if let Some(i) = self.free(m) {
                // No step leaves the main lobe of the correlation.
                self.times[m] += step[i].clamp(-5e-5, 5e-5);
                self.gains[m] += step[others + i];
            }
        }
        let unknowns = self.taps.iter_mut().chain(&mut self.waveform.coefficients);
        for (value, d) in unknowns.zip(&step[2 * others..]) {
            *value += d;
        }
    }

    /// Moves the origin of the waveform to its peak, so that all clicks sit alike in their windows.
    fn centre(&mut self) {
        let grid = (-400..=400).map(|k| 1e-6 * f64::from(k));
        let mut peak = grid
            .max_by(|a, b| self.waveform.at(*a).0.abs().total_cmp(&self.waveform.at(*b).0.abs()))
            .unwrap_or(0.0);
        // Newton's method on the slope, which the grid has brought within its reach.
        for _ in 0..4 {
            let slope = |t: f64| self.waveform.at(t).1;
            let curvature = (slope(peak + 1e-7) - slope(peak - 1e-7)) / 2e-7;
            peak -= (slope(peak) / curvature).clamp(-1e-6, 1e-6);
        }
        self.waveform.shift(peak);
        self.times.iter_mut().for_each(|t| *t += peak);
    }

    fn signal_to_noise(&self, segment: &Segment, rows: &Rows) -> Vec<f64> {
        let energy = |(m, &(from, to)): (usize, &(usize, usize))| {
            let square = |n: usize| self.waveform.at(segment.time(n) - self.times[m]).0.powi(2);
            self.gains[m].abs() / segment.noise[m] * (from..to).map(square).sum::<f64>().sqrt()
        };
        rows.iter().enumerate().map(energy).collect()
    }

    fn worst_channel(&self, segment: &Segment, rows: &Rows) -> usize {
        let squares = |m: usize| -> f64 {
            let (from, to) = rows[m];
            let mut left: Vec<f64> = (from..to)
                .map(|n| segment.at(m, n) - self.gains[m] * self.shape(m, segment.time(n) - self.times[m]).0)
                .collect();
            remove_parabola(&mut left, segment.noise[m].recip());
            dot(&left, &left)
        };
        (0..rows.len()).max_by(|&a, &b| squares(a).total_cmp(&squares(b))).unwrap_or(0)
    }

    fn report(
        self,
        inverse: &Matrix,
        excess: f64,
        chi_squared: f64,
        signal_to_noise: Vec<f64>,
        frequencies: Vec<f64>,
    ) -> ClickFit {
        let channels = self.times.len();
        let first = 2 * (channels - 1) + self.taps.len();
        let spectrum = self.waveform.spectrum_map(&frequencies);
        let mut map = Matrix::zeros(channels + spectrum.rows(), inverse.rows());
        for m in 0..channels {
            if let Some(i) = self.free(m) {
                map[(m, i)] = 1.0;
            }
        }
        for i in 0..spectrum.rows() {
            for k in 0..spectrum.columns() {
                map[(channels + i, first + k)] = spectrum[(i, k)];
            }
        }
        let joint = map.product(inverse).product(&map.transpose());
        let joint = Matrix::from_fn(joint.rows(), joint.rows(), |i, j| excess * joint[(i, j)]);
        let values = spectrum.times(&self.waveform.coefficients);
        ClickFit {
            covariance: Matrix::from_fn(channels, channels, |i, j| joint[(i, j)]),
            times: self.times,
            gains: self.gains,
            pivot: self.pivot,
            frequencies,
            waveform: values.chunks_exact(2).map(|p| C64::new(p[0], p[1])).collect(),
            reflection: self.taps,
            signal_to_noise,
            chi_squared,
            joint,
        }
    }
}

impl ClickOptions {
    /// Whether the reflection at channel `m` overlaps the centre of the direct impulse, so that the window cannot end
    /// before it.
    pub(crate) fn overlaps(&self, m: usize) -> bool {
        self.lag(m).is_some_and(|lag| lag - self.window.0 < 0.4 * self.window.1)
    }

    /// End of the window of channel `m` after the impulse's centre, s.
    pub(crate) fn end(&self, m: usize) -> f64 {
        match self.lag(m) {
            Some(lag) if !self.overlaps(m) => self.window.1.min(lag - self.window.0),
            _ => self.window.1,
        }
    }

    fn lag(&self, m: usize) -> Option<f64> {
        self.reflection.as_ref().and_then(|r| r.lags.get(m).copied())
    }
}

impl Reflection {
    /// The smoothing kernel at the taps.
    fn taps(&self) -> Vec<f64> {
        let middle = (TAPS / 2) as f64;
        let kernel: Vec<f64> = (0..TAPS)
            .map(|j| (-0.5 * ((j as f64 - middle) * TAP_SPACING / self.smoothing.max(1e-9)).powi(2)).exp())
            .collect();
        let sum: f64 = kernel.iter().sum();
        kernel.into_iter().map(|v| self.strength * v / sum).collect()
    }
}

/// Subtracts from a column its least-squares parabola and multiplies with `weight`.
pub(crate) fn remove_parabola(column: &mut [f64], weight: f64) {
    let n = column.len() as f64;
    let half = 0.5 * (n - 1.0);
    // Gram's orthogonal polynomials: 1, u, u^2 - (n^2 - 1)/12.
    let shift = (n * n - 1.0) / 12.0;
    let norms = [n, n * shift, n * shift * (n * n - 4.0) / 15.0];
    let mut sums = [0.0; 3];
    for (i, v) in column.iter().enumerate() {
        let u = i as f64 - half;
        sums[0] += v;
        sums[1] += v * u;
        sums[2] += v * (u * u - shift);
    }
    for (i, v) in column.iter_mut().enumerate() {
        let u = i as f64 - half;
        *v -= sums[0] / norms[0] + sums[1] / norms[1] * u + sums[2] / norms[2] * (u * u - shift);
        *v *= weight;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Solution of A x = b for a positive definite A whose rows differ in scale.
fn solve_scaled(a: &Matrix, b: &[f64]) -> Result<Vec<f64>, Fault> {
    let n = a.rows();
    let scale: Vec<f64> = (0..n).map(|i| a[(i, i)].sqrt().recip()).collect();
    let factor = Cholesky::new(&Matrix::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]))?;
    let scaled: Vec<f64> = b.iter().zip(&scale).map(|(v, s)| v * s).collect();
    Ok(factor.solve(&scaled).iter().zip(&scale).map(|(v, s)| v * s).collect())
}

/// Inverse of a positive definite matrix whose rows differ in scale (seconds, gains, pressures).
pub(crate) fn inverse_scaled(a: &Matrix) -> Result<Matrix, Fault> {
    let n = a.rows();
    let scale: Vec<f64> = (0..n).map(|i| a[(i, i)].sqrt().recip()).collect();
    let inverse = Cholesky::new(&Matrix::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]))?.inverse();
    Ok(Matrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}
