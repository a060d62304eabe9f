//! The unknowns of a click and the normal equations that the record gives for them.

use super::extent::EQUAL;
use super::options::{ClickFit, ClickOptions, Reflection};
use super::picture::ClickPicture;
use super::pulse::Located;
use super::segment::Segment;
use super::waveform::Waveform;
use crate::dsp::kernels::{LANES, dot, four_dots_inline, run};
use crate::dsp::parabola::Parabola;
use pulp::NullaryFnOnce;
use rijke_numerics::{C64, Cholesky, Matrix};

/// Taps of the reflection and their spacing, s: an open end reflects high frequencies less and a little later
/// (|R| falls from 1 to 0.5 at 3 kHz in a tube of 5 cm).
pub(super) const TAPS: usize = 5;
pub(super) const TAP_SPACING: f64 = 0.06e-3;
/// Relative weight of a prior that the waveform is zero: bounds what the samples leave open at its ends.
const RIDGE: f64 = 1e-6;
/// Coefficients at each end of the waveform that are zero: the impulse begins and ends inside its window.
const SILENT: usize = 2;

/// The unknowns.
pub(super) struct Model {
    pub(super) options: ClickOptions,
    pivot: usize,
    pub(super) times: Vec<f64>,
    pub(super) gains: Vec<f64>,
    pub(super) taps: Vec<f64>,
    /// The taps expected beforehand.
    pub(super) expected: Vec<f64>,
    /// Lag of the reflection over the lag stated, and its sd beforehand; none if the lag is known.
    pub(super) pace: f64,
    pub(super) pace_sd: Option<f64>,
    pub(super) waveform: Waveform,
}

/// First and one past the last sample of the window of each channel.
pub(super) type Rows = Vec<(usize, usize)>;

impl Model {
    pub(super) fn start(located: &Located, segment: &Segment, options: ClickOptions) -> Self {
        let channels = located.times.len();
        let needed = (0..channels).any(|m| options.overlaps(m));
        let taps = options.reflection.as_ref().filter(|_| needed).map(Reflection::taps).unwrap_or_default();
        let waveform = Waveform::new(options.window.0, options.window.1, segment.highest_hz);
        let mut model = Self {
            pivot: located.pivot,
            times: located.times.clone(),
            gains: located.gains.clone(),
            expected: taps.clone(),
            pace: 1.0,
            pace_sd: options.reflection.as_ref().map(|r| r.pace_sd).filter(|sd| needed && *sd > 0.0),
            taps,
            waveform,
            options,
        };
        // A first waveform by linear least squares, from the strongest channel alone.
        let rows = segment.windows(&model.times, &model.options);
        let size = model.waveform.coefficients.len();
        let (mut normal, mut right) = (Matrix::zeros(size, size), vec![0.0; size]);
        for n in rows[model.pivot].0..rows[model.pivot].1 {
            let basis = model.waveform.basis(segment.time(n) - model.times[model.pivot]);
            for (i, a) in basis.iter() {
                right[i] += a * segment.at(model.pivot, n);
                for (j, b) in basis.iter() {
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
        self.pace * lag + TAP_SPACING * (j as f64 - (TAPS / 2) as f64)
    }

    /// Number of unknowns of the reflection: its taps, and its pace if that is free.
    fn reflected(&self) -> usize {
        self.taps.len() + usize::from(self.pace_sd.is_some())
    }

    /// Number of coefficients of the waveform that are not held at zero.
    pub(super) fn free_coefficients(&self) -> usize {
        self.waveform.coefficients.len().saturating_sub(2 * SILENT)
    }

    /// Where the time of channel `m` sits among the unknowns; its gain follows `channels - 1` later.
    pub(super) fn free(&self, m: usize) -> Option<usize> {
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

    /// Normal matrix, gradient and sum of squares of the residuals in units of the noise, backgrounds
    /// eliminated.
    pub(super) fn linearise(&self, segment: &Segment, rows: &Rows) -> (Matrix, Vec<f64>, f64) {
        let (others, taps, size) = (self.times.len() - 1, self.reflected(), self.waveform.coefficients.len());
        let total = 2 * others + taps + size;
        let mut normal = Matrix::zeros(total, total);
        let mut gradient = vec![0.0; total];
        let mut squares = 0.0;
        for (m, &(from, to)) in rows.iter().enumerate() {
            let columns = Columns { model: self, segment, m, from, rows: to - from };
            let own = self.free(m).map_or(vec![], |free| vec![free, others + free]);
            let after = 2 * others + taps - columns.late();
            let places: Vec<usize> = own.into_iter().chain(after..total).collect();
            let weight = segment.noise[m].powi(-2);
            let products = run(columns);
            for (i, &a) in places.iter().enumerate() {
                let products: &[f64] = &products[i * (i + 1) / 2..];
                for (&b, product) in places[..=i].iter().zip(products) {
                    normal[(a, b)] += weight * product;
                    if a != b {
                        normal[(b, a)] += weight * product;
                    }
                }
            }
            let last = &products[places.len() * (places.len() + 1) / 2..];
            places.iter().zip(last).for_each(|(&a, product)| gradient[a] += weight * product);
            squares += weight * last[places.len()];
        }
        self.add_prior(2 * others, &mut normal, &mut gradient);
        (normal, gradient, squares)
    }

    /// Adds to the normal equations what is known about taps and waveform without the record. The unknown
    /// parabola of each background would leave that of the waveform open, were it not that the impulse begins
    /// and ends with zero.
    fn add_prior(&self, first: usize, normal: &mut Matrix, gradient: &mut [f64]) {
        let taps = self.reflected();
        if let Some(sd) = self.pace_sd {
            let place = first + taps - 1;
            normal[(place, place)] += sd.powi(-2);
            gradient[place] -= (self.pace - 1.0) * sd.powi(-2);
        }
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

    pub(super) fn advance(&mut self, step: &[f64]) {
        let others = self.times.len() - 1;
        for m in 0..self.times.len() {
            if let Some(i) = self.free(m) {
                // No step leaves the main lobe of the correlation.
                self.times[m] += step[i].clamp(-5e-5, 5e-5);
                self.gains[m] += step[others + i];
            }
        }
        let pace = self.pace_sd.is_some().then_some(&mut self.pace);
        let unknowns = self.taps.iter_mut().chain(pace).chain(&mut self.waveform.coefficients);
        for (value, d) in unknowns.zip(&step[2 * others..]) {
            *value += d;
        }
    }

    /// Moves the origin of the waveform to its peak, so that all clicks sit alike in their windows.
    pub(super) fn centre(&mut self) {
        let reach = ((0.5e5 * self.options.window.0.max(self.options.window.1)) as i32).max(40);
        // The impulse is band-limited: within 5 us of its peak its slope is a straight line.
        let sizes: Vec<f64> =
            (-reach..=reach).map(|k| self.waveform.at(1e-5 * f64::from(k)).0.abs()).collect();
        let top = sizes.iter().copied().fold(0.0, f64::max);
        // Of two equal lobes the first one, so that noise does not choose.
        let turns = |n: &usize| sizes[*n] >= sizes.get(n + 1).copied().unwrap_or(0.0);
        let largest =
            (0..sizes.len()).find(|n| sizes[*n] > EQUAL * top && turns(n)).unwrap_or(reach as usize);
        let mut peak = 1e-5 * (largest as f64 - f64::from(reach));
        for _ in 0..6 {
            let slope = |t: f64| self.waveform.at(t).1;
            let curvature = (slope(peak + 1e-7) - slope(peak - 1e-7)) / 2e-7;
            peak -= (slope(peak) / curvature).clamp(-5e-6, 5e-6);
        }
        self.waveform.shift(peak);
        self.times.iter_mut().for_each(|t| *t += peak);
    }

    /// Takes the lags that the pace has led to as those stated.
    pub(super) fn settle_pace(&mut self) {
        if self.pace_sd.is_some() {
            self.options.hasten(self.pace.clamp(0.8, 1.25));
            self.pace = 1.0;
        }
    }

    pub(super) fn signal_to_noise(&self, segment: &Segment, rows: &Rows) -> Vec<f64> {
        let energy = |(m, &(from, to)): (usize, &(usize, usize))| {
            let square = |n: usize| self.waveform.at(segment.time(n) - self.times[m]).0.powi(2);
            self.gains[m].abs() / segment.noise[m] * (from..to).map(square).sum::<f64>().sqrt()
        };
        rows.iter().enumerate().map(energy).collect()
    }

    /// What the fit sees of the channels and leaves of them, over their gains.
    pub(super) fn picture(&self, segment: &Segment, rows: &Rows) -> ClickPicture {
        let (mut channels, mut left) = (Vec::new(), Vec::new());
        for (m, &(from, to)) in rows.iter().enumerate() {
            let times: Vec<f64> = (from..to).map(|n| segment.time(n) - self.times[m]).collect();
            let shape: Vec<f64> = times.iter().map(|t| self.shape(m, *t).0).collect();
            let mut residual: Vec<f64> =
                (from..to).zip(&shape).map(|(n, shape)| segment.at(m, n) / self.gains[m] - shape).collect();
            Parabola::new(residual.len()).remove(&mut residual);
            let points = times.iter().zip(&shape).zip(&residual);
            channels.push(points.map(|((t, shape), residual)| [*t, shape + residual]).collect());
            left.push(times.iter().zip(&residual).map(|(t, residual)| [*t, *residual]).collect());
        }
        let (before, after) = self.options.window;
        let times = (0..=400).map(|k| (before + after) * f64::from(k) / 400.0 - before);
        ClickPicture { channels, impulse: times.map(|t| [t, self.waveform.at(t).0]).collect(), left }
    }

    pub(super) fn worst_channel(&self, segment: &Segment, rows: &Rows) -> usize {
        let squares = |m: usize| -> f64 {
            let (from, to) = rows[m];
            let mut left: Vec<f64> = (from..to)
                .map(|n| segment.at(m, n) - self.gains[m] * self.shape(m, segment.time(n) - self.times[m]).0)
                .collect();
            Parabola::new(left.len()).remove(&mut left);
            dot(&left, &left) * segment.noise[m].powi(-2)
        };
        (0..rows.len()).max_by(|&a, &b| squares(a).total_cmp(&squares(b))).unwrap_or(0)
    }

    pub(super) fn report(
        self,
        inverse: &Matrix,
        excess: f64,
        chi_squared: f64,
        signal_to_noise: Vec<f64>,
        frequencies: Vec<f64>,
    ) -> ClickFit {
        let channels = self.times.len();
        let first = 2 * (channels - 1) + self.reflected();
        let spectrum = self.waveform.spectrum_map(&frequencies);
        let others = channels - 1;
        let gain_covariance =
            Matrix::from_fn(channels, channels, |m, n| match (self.free(m), self.free(n)) {
                (Some(i), Some(j)) => excess * inverse[(others + i, others + j)],
                _ => 0.0,
            });
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
            band_hz: self.options.band_hz,
            leaning: Vec::new(),
            overlapped: (0..channels).map(|m| self.options.overlaps(m)).collect(),
            misfit: 0.0,
            covariance: Matrix::from_fn(channels, channels, |i, j| joint[(i, j)]),
            gain_covariance,
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

/// What the window of one channel says: derivatives of its record with respect to its time and gain (not the
/// pivot's), to the reflection where there is one, and to the waveform; then the residual. Backgrounds are
/// eliminated.
struct Columns<'a> {
    model: &'a Model,
    segment: &'a Segment,
    m: usize,
    from: usize,
    rows: usize,
}

impl Columns<'_> {
    /// Number of columns of the reflection.
    fn late(&self) -> usize {
        if self.model.options.overlaps(self.m) { self.model.reflected() } else { 0 }
    }
}

impl NullaryFnOnce for Columns<'_> {
    /// Inner products of all pairs of columns: the lower triangle, row by row.
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        let (late, Self { model, segment, m, from, rows }) = (self.late(), self);
        let Model { waveform, taps, .. } = model;
        let (gain, arrival) = (model.gains[m], model.times[m]);
        let own = if m == model.pivot { 0 } else { 2 };
        let first = own + late;
        let count = first + waveform.coefficients.len() + 1;
        // Zeros fill up what the last vector of a column leaves.
        let stride = rows.next_multiple_of(LANES);
        let mut columns = vec![0.0; count * stride];
        let lag = if late > 0 { model.options.lag(m).unwrap_or(0.0) } else { 0.0 };
        for n in 0..rows {
            let t = segment.time(from + n) - arrival;
            let mut add = |column: usize, value: f64| columns[column * stride + n] += value;
            let basis = waveform.basis(t);
            let (mut value, mut slope) = waveform.sum(&basis);
            basis.iter().for_each(|(k, phi)| add(first + k, gain * phi));
            if late > 0 {
                for (j, rho) in taps.iter().enumerate() {
                    let basis = waveform.basis(t - model.lag(m, j));
                    let echo = waveform.sum(&basis);
                    basis.iter().for_each(|(k, phi)| add(first + k, gain * rho * phi));
                    add(own + j, gain * echo.0);
                    if late > taps.len() {
                        add(own + taps.len(), -gain * rho * echo.1 * lag);
                    }
                    (value, slope) = (value + rho * echo.0, slope + rho * echo.1);
                }
            }
            if own > 0 {
                add(0, -gain * slope);
                add(1, value);
            }
            add(count - 1, segment.at(m, from + n) - gain * value);
        }
        let parabola = Parabola::new(rows);
        columns.chunks_exact_mut(stride).for_each(|column| parabola.remove_inline(&mut column[..rows]));
        let mut products = Vec::with_capacity(count * (count + 1) / 2);
        let column = |i: usize| &columns[i * stride..(i + 1) * stride];
        for i in 0..count {
            for j in (0..=i).step_by(4) {
                // The last of four stand in for those beyond the diagonal.
                let four = four_dots_inline(column(i), std::array::from_fn(|k| column((j + k).min(i))));
                products.extend_from_slice(&four[..(i + 1 - j).min(4)]);
            }
        }
        products
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
