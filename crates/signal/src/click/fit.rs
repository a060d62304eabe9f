//! Arrival time of one impulse at every channel: all channels brought optimally in phase.
//!
//! The impulse has the same, unknown, band-limited waveform w in every channel. In a window that follows it,
//!
//! y_m(t) = a_m [w(t - t_m) + sum_j rho_j w(t - t_m - gap_m - j h)] + slow background + noise,
//!
//! with real gains a_m (negative: inverted) and a reflection of a few real taps rho_j where it overlaps the
//! direct impulse; elsewhere the window ends before the reflection begins. The background is a parabola: over
//! a millisecond that is all hum and drift can be. The known dispersion of the path is undone beforehand.
//! Maximum likelihood over times, gains, taps, waveform and backgrounds together is the weighted sum of all
//! pairwise cross-correlations at its maximum, interpolated without error between samples.

use super::hum::loud_hum;
use super::model::{Model, Rows};
use super::options::{ClickFit, ClickOptions};
use super::picture::ClickPicture;
use super::pulse::{Bursts, Located};
use super::segment::Segment;
use super::steps::Steps;
use super::waveform::comparison_frequencies;
use crate::dsp::scaled::{inverse_scaled, solve_scaled};
use crate::{Fault, Trace};
use rijke_numerics::Matrix;

/// Gauss-Newton steps before giving up, and the step (in sd) at which it ends.
const MAX_STEPS: usize = 40;
const SMALL_STEP: f64 = 1e-2;
/// The step after which windows may be placed anew.
const NEAR: f64 = 0.5;
/// The step that must do after all of them.
const SETTLED: f64 = 0.1;
/// Windows follow the impulse during the first steps and stay from then on, so that the sum of squares is
/// smooth.
const MOVING_STEPS: usize = 2;
/// Times at most that windows are placed anew, and the relative change of a lag that needs none: 20 us of 1
/// ms.
const PACES: usize = 2;
const SAME_PACE: f64 = 0.02;
/// Lags to try when those stated lead nowhere: gas at 450 K instead of 293 K.
const EARLIER: f64 = 0.8;
/// Step (in sd) below which the record is first rid of what the taps do not reflect, and how often at most.
const RID: f64 = 0.5;
const RIDS: usize = 6;
/// Distance from where sound arrives, in periods of the highest frequency, beyond which another place is
/// tried.
const FAR: f64 = 0.4;
/// Waves in the window below which a frequency is the background's.
const WAVES: f64 = 0.47;
/// Sum of squared deviations of the taps of a known end from what is expected of them, in their standard
/// deviations, from which impulse and reflection have been mistaken for one another: five taps come to this
/// once in 1e7.
const STRANGE: f64 = 40.0;
/// Residual energy over impulse energy above which the channels do not show the same impulse.
const MISFIT: f64 = 0.05;

/// Fits one impulse by maximum likelihood. Cost: see `benches/records.rs`.
///
/// The covariance is the inverse Fisher information for white noise as measured in the quiet part; if
/// residuals exceed it significantly (a waveform that changes along the path, say), it is scaled up with
/// them.
///
/// # Errors
/// A [`Fault`] that says why the record must not be used.
pub fn fit_click(trace: &Trace<'_>, options: &ClickOptions) -> Result<ClickFit, Fault> {
    fitted(trace, options)?.report()
}

/// Fits as [`fit_click`] does, and returns the numbers of a picture of it.
///
/// # Errors
/// Those of [`fit_click`].
pub fn picture_click(trace: &Trace<'_>, options: &ClickOptions) -> Result<ClickPicture, Fault> {
    let Fitting { model, segment, rows, .. } = fitted(trace, options)?;
    Ok(model.picture(&segment, &rows))
}

fn fitted(trace: &Trace<'_>, options: &ClickOptions) -> Result<Fitting, Fault> {
    trace.screen(2)?;
    options.check(trace)?;
    loud_hum(trace, options.mains_hz)?;
    let bursts = Bursts::find(trace, options)?;
    let mut placed = options.clone();
    if options.free() {
        placed.hasten(bursts.locate(options).pace(options));
    }
    let first = bursts.locate(&placed);
    let result = Fitting::from(trace, &first, placed);
    // At an operating point parts of the rig reflect, too.
    let doubtful = options.leaning && result.as_ref().map_or(true, Fitting::is_strange);
    let far = if doubtful { 0.0 } else { FAR / options.band_hz.1 };
    if let Some(elsewhere) = bursts.expected(&first, options, far) {
        let other = Fitting::from(trace, &elsewhere, options.clone());
        let better = match (result, other) {
            (Ok(first), Ok(other)) => {
                let rank = |fit: &Fitting| (options.leaning && fit.is_strange(), fit.squares);
                if rank(&other) < rank(&first) { other } else { first }
            }
            (Err(_), Ok(other)) => other,
            (first, _) => first?,
        };
        return if options.leaning { better.credible() } else { Ok(better) };
    }
    match result {
        // Far too late a reflection is heard where none is expected: start from an earlier one.
        Err(_) if options.free() => {
            let mut placed = options.clone();
            placed.hasten(EARLIER);
            Fitting::from(trace, &bursts.locate(&placed), placed)
        }
        result => result,
    }
}

/// A fit on its way.
struct Fitting {
    model: Model,
    segment: Segment,
    rows: Rows,
    normal: Matrix,
    /// Sum of squared residuals in units of the noise, and its number of degrees of freedom.
    squares: f64,
    freedom: f64,
}

impl Fitting {
    /// Fits, from these places and the stated lags.
    fn from(trace: &Trace<'_>, located: &Located, options: ClickOptions) -> Result<Self, Fault> {
        let segment = Segment::new(trace, &located.times, &options)?;
        let model = Model::start(located, &segment, options);
        let (rows, normal) = (Rows::new(), Matrix::zeros(0, 0));
        Self { model, segment, rows, normal, squares: 0.0, freedom: 1.0 }.settled(trace)
    }

    /// Takes Gauss-Newton steps to the maximum of the likelihood. Windows move during the first of them, and
    /// once more if the reflection then does not come when they expect it.
    fn settled(mut self, trace: &Trace<'_>) -> Result<Self, Fault> {
        let Self { model, segment, .. } = &mut self;
        let mut rows = segment.windows(&model.times, &model.options);
        let (mut settled, mut length, mut paces) = (None, f64::INFINITY, 0);
        let (raw, mut rids, mut since) = (segment.clone(), 0, 0);
        let mut steps = Steps::default();
        for step_number in 0..MAX_STEPS {
            let moving = step_number < MOVING_STEPS;
            if moving {
                rows = segment.windows(&model.times, &model.options);
            }
            let (normal, gradient, squares) = model.linearise(segment, &rows);
            let step = solve_scaled(&normal, &gradient)?;
            let gain = step.iter().zip(&gradient).map(|(a, b)| a * b).sum::<f64>().max(0.0);
            length = gain.sqrt();
            model.advance(&steps.next(step, &gradient));
            since += 1;
            let rid = match rids {
                0 => !moving && length < RID,
                _ => rids < RIDS && length < SMALL_STEP && since > 1,
            };
            if let Some(changed) = if rid { model.without_rest(&raw, &rows) } else { None } {
                *segment = changed;
                (rids, since) = (rids + 1, 0);
                steps.restart();
                continue;
            }
            if moving {
                model.centre();
                model.settle_pace();
                steps.restart();
            } else if length < NEAR && (model.pace - 1.0).abs() > SAME_PACE && paces < PACES {
                paces += 1;
                model.settle_pace();
                rows = segment.windows(&model.times, &model.options);
                steps.restart();
            } else if length < SMALL_STEP || (step_number + 1 == MAX_STEPS && length < SETTLED) {
                // After so small a step the same normal equations hold, and the sum of squares is less by
                // what the step gained.
                settled = Some((normal, squares - gain));
                break;
            }
        }
        let Some((normal, squares)) = settled else {
            return Err(Fault::NotConverged(MAX_STEPS, length));
        };
        let samples: usize = rows.iter().map(|r| r.1 - r.0).sum();
        let unknowns = normal.rows() + 3 * rows.len();
        (self.squares, self.freedom) = (squares, samples.saturating_sub(unknowns).max(1) as f64);
        (self.rows, self.normal) = (rows, normal);
        if self.exceeds(5.0) {
            self.misfit(trace)?;
        }
        Ok(self)
    }

    /// Whether the taps of a known end are none of an open end.
    fn is_strange(&self) -> bool {
        self.model.strangeness() > STRANGE
    }

    /// Refuses a reflection that is none of an open end.
    fn credible(self) -> Result<Self, Fault> {
        let Self { model: Model { options, times, .. }, .. } = &self;
        let lag = |m: &usize| options.lag(*m).unwrap_or(f64::INFINITY);
        let near = (0..times.len()).min_by(|a, b| lag(a).total_cmp(&lag(b)));
        match near.filter(|_| self.is_strange()) {
            Some(channel) => {
                let (window, lag) = (options.window, lag(&channel));
                let closed = self.model.taps.iter().sum::<f64>() > 0.0;
                Err(Fault::StrangeReflection(channel.into(), window, lag, closed))
            }
            None => Ok(self),
        }
    }

    /// Whether residuals are larger than the noise by so many standard deviations.
    fn exceeds(&self, deviations: f64) -> bool {
        self.squares / self.freedom > 1.0 + deviations * (2.0 / self.freedom).sqrt()
    }

    /// Refuses channels that do not show the same impulse.
    fn misfit(&self, trace: &Trace<'_>) -> Result<(), Fault> {
        let Self { model, segment, rows, .. } = self;
        let energy: f64 = model.signal_to_noise(segment, rows).iter().map(|v| v * v).sum();
        if self.squares - self.freedom <= MISFIT * energy {
            return Ok(());
        }
        let channel = model.worst_channel(segment, rows);
        let at = trace.quiet.min(trace.len()) as f64 / trace.rate_hz + model.times[channel];
        let ratio = self.squares / self.freedom;
        Err(Fault::Residual { at, channel: channel.into(), ratio, frequency_hz: model.options.band_hz.0 })
    }

    fn report(self) -> Result<ClickFit, Fault> {
        let chi_squared = self.squares / self.freedom;
        let excess = if self.exceeds(3.0) || !self.segment.noise_known { chi_squared } else { 1.0 };
        let signal_to_noise = self.model.signal_to_noise(&self.segment, &self.rows);
        let (before, after) = self.model.options.window;
        let low = self.model.options.band_hz.0.max(WAVES / (before + after));
        let band_hz = (low, self.segment.highest_hz);
        let frequencies = comparison_frequencies(band_hz, self.model.free_coefficients());
        let inverse = inverse_scaled(&self.normal)?;
        let leaning = self.model.leaning(&self.segment, &self.rows, &inverse);
        let energy: f64 = signal_to_noise.iter().map(|v| v * v).sum();
        let misfit = if self.segment.noise_known { (self.squares - self.freedom) / energy } else { 0.0 };
        let fit = self.model.report(&inverse, excess, chi_squared, signal_to_noise, frequencies);
        Ok(ClickFit { leaning, misfit, band_hz, ..fit })
    }
}
