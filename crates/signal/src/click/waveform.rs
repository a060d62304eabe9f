//! A band-limited function of time with adjustable coefficients: the unknown waveform of an impulse.

use rijke_numerics::{C64, Matrix};
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// Sum of c_k phi((t - t_k)/h), with phi a windowed sinc. Away from the first and last centres a tone at
/// 0.3/h is represented to 0.5 % of its amplitude, lower ones better; h is chosen as 0.4 over the highest
/// frequency.
#[derive(Clone, Debug)]
pub(crate) struct Waveform {
    first: f64,
    spacing: f64,
    pub(crate) coefficients: Vec<f64>,
}

/// Half length of phi in spacings, and points of its table per spacing (linear interpolation then errs by
/// 1e-6).
const REACH: usize = 6;
const FINE: usize = 400;
/// Number of phi_k that are not zero at a time between two centres.
const WIDTH: usize = 2 * REACH;

/// phi_k and its derivative in u at the times u = n / FINE after a centre: k counts from `REACH` - 1 centres
/// before that one.
static TABLE: LazyLock<Vec<[[f64; WIDTH]; 2]>> = LazyLock::new(|| {
    let phi = |u: f64| {
        let window = (0.5 * PI * u / REACH as f64).cos().powi(2);
        match u.abs() < REACH as f64 {
            true if u == 0.0 => 1.0,
            true => (PI * u).sin() / (PI * u) * window,
            false => 0.0,
        }
    };
    (0..=FINE)
        .map(|n| {
            let u = |k: usize| n as f64 / FINE as f64 + (REACH - 1) as f64 - k as f64;
            let slope = |u: f64| (phi(u + 1e-5) - phi(u - 1e-5)) / 2e-5;
            [std::array::from_fn(|k| phi(u(k))), std::array::from_fn(|k| slope(u(k)))]
        })
        .collect()
});

/// The phi_k that are not zero at some time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Basis {
    /// Number of the first coefficient.
    first: usize,
    /// Which of the values count.
    inside: (usize, usize),
    values: [f64; WIDTH],
    /// Derivatives, 1/s.
    slopes: [f64; WIDTH],
}

impl Basis {
    /// Number and value of each.
    #[inline(always)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (from, to) = self.inside;
        self.values[from..to].iter().enumerate().map(|(k, value)| (self.first + k, *value))
    }
}

impl Waveform {
    /// Covers times from `-before` to `after` for spectra up to `highest_hz`.
    pub(crate) fn new(before: f64, after: f64, highest_hz: f64) -> Self {
        let spacing = 0.4 / highest_hz;
        let (low, high) = ((before / spacing).ceil(), (after / spacing).ceil());
        Self { first: -low * spacing, spacing, coefficients: vec![0.0; (low + high) as usize + 1] }
    }

    /// The value of each phi_k at time t and its derivative.
    #[inline(always)]
    pub(crate) fn basis(&self, t: f64) -> Basis {
        let u = (t - self.first) / self.spacing;
        let before = u.floor();
        let fine = (u - before) * FINE as f64;
        let n = (fine as usize).min(FINE - 1);
        let part = fine - n as f64;
        let ([a, da], [b, db]) = (TABLE[n], TABLE[n + 1]);
        let between = |a: [f64; WIDTH], b: [f64; WIDTH], scale: f64| -> [f64; WIDTH] {
            std::array::from_fn(|k| (a[k] + (b[k] - a[k]) * part) * scale)
        };
        let low = before as i64 - (REACH as i64 - 1);
        let from = (-low).clamp(0, WIDTH as i64) as usize;
        let to = (self.coefficients.len() as i64 - low).clamp(from as i64, WIDTH as i64) as usize;
        Basis {
            first: (low + from as i64).clamp(0, self.coefficients.len() as i64) as usize,
            inside: (from, to),
            values: between(a, b, 1.0),
            slopes: between(da, db, self.spacing.recip()),
        }
    }

    /// Value and derivative at time t.
    pub(crate) fn at(&self, t: f64) -> (f64, f64) {
        self.sum(&self.basis(t))
    }

    /// Value and derivative where the phi_k are these.
    #[inline(always)]
    pub(crate) fn sum(&self, basis: &Basis) -> (f64, f64) {
        let (from, to) = basis.inside;
        let mut c = [0.0; WIDTH];
        c[from..to].copy_from_slice(&self.coefficients[basis.first..][..to - from]);
        // Four sums side by side.
        let dot = |v: &[f64; WIDTH]| {
            let mut sums = [0.0; 4];
            for k in 0..WIDTH {
                sums[k % 4] += c[k] * v[k];
            }
            (sums[0] + sums[1]) + (sums[2] + sums[3])
        };
        (dot(&basis.values), dot(&basis.slopes))
    }

    /// Replaces w(t) by w(t + `lag`).
    pub(crate) fn shift(&mut self, lag: f64) {
        let centre = |k: usize| self.first + self.spacing * k as f64;
        self.coefficients = (0..self.coefficients.len()).map(|k| self.at(centre(k) + lag).0).collect();
    }

    /// Fourier transform at the angular frequency `omega`, below the highest frequency of the waveform.
    pub(crate) fn transform(&self, omega: f64) -> C64 {
        let term = |(k, c): (usize, &f64)| {
            C64::from_polar(c * self.spacing, -omega * (self.first + self.spacing * k as f64))
        };
        self.coefficients.iter().enumerate().map(term).sum()
    }

    /// The linear map from coefficients to real and imaginary parts of the spectrum at the given frequencies,
    /// up to a real factor of each frequency that is the same for all waveforms.
    pub(crate) fn spectrum_map(&self, frequencies: &[f64]) -> Matrix {
        Matrix::from_fn(2 * frequencies.len(), self.coefficients.len(), |i, k| {
            let t = self.first + self.spacing * k as f64;
            let turn = C64::from_polar(1.0, -frequencies[i / 2] * t);
            if i % 2 == 0 { turn.re } else { turn.im }
        })
    }
}

/// Frequencies at which waveforms are compared, rad/s: inside the band, few enough that `free` coefficients
/// determine their spectrum.
pub(crate) fn comparison_frequencies((low, high): (f64, f64), free: usize) -> Vec<f64> {
    let count = (free.saturating_sub(1) / 2).clamp(2, 6);
    // In a narrow band a quarter of it from its borders.
    let margin = 0.25 * (high - low);
    let (from, to) = ((1.5 * low).min(low + margin), (0.85 * high).max(high - margin));
    (0..count).map(|k| TAU * (from + (to - from) * k as f64 / (count - 1) as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_band_limited_function_is_represented_and_differentiated() {
        for (frequency, tolerance) in [(3000.0, 5e-3), (1500.0, 1e-3)] {
            let mut waveform = Waveform::new(2e-3, 2e-3, 4000.0);
            let f = |t: f64| (TAU * frequency * t).cos() * (-(t / 6e-4_f64).powi(2)).exp();
            for k in 0..waveform.coefficients.len() {
                waveform.coefficients[k] = f(waveform.first + waveform.spacing * k as f64);
            }
            for n in -50..50 {
                let t = 1.37e-5 * f64::from(n);
                let (value, slope) = waveform.at(t);
                assert!((value - f(t)).abs() < tolerance, "{frequency} Hz, {t}: {value} {}", f(t));
                let exact = (f(t + 1e-8) - f(t - 1e-8)) / 2e-8;
                assert!((slope - exact).abs() < 3.0 * tolerance * TAU * frequency, "{t}: {slope} {exact}");
            }
        }
    }
}
