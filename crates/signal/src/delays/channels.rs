//! Delays and gains of the channels, from impulses that travel at a known speed.

use super::error::CalibrationError;
use super::error::plausible;
use super::left::{misfit, relative, systematic};
use super::order::{alike, in_order};
use super::place::{Placed, absolute, place};
use super::stated::ChannelPriors;
use crate::Fault;
use crate::click::ClickFit;
use crate::repeats::{Group, variances_of_means};
use rijke_numerics::{C64, Matrix};
use rijke_rig::{ChannelErrors, Click, ModeRows, Ping};

/// What the acquisition system does to each channel at one sampling rate, with its uncertainty.
///
/// The error of a calibration is common to everything that is corrected with it: average first, correct
/// afterwards.
#[derive(Clone, Debug)]
pub struct ChannelDelays {
    /// Sampling rate at which the delays hold, Hz.
    pub rate_hz: f64,
    /// Delay of each channel, s, including that of loudspeaker and trigger.
    pub delays: Vec<f64>,
    /// Gain of each channel; their mean square is 1.
    pub gains: Vec<f64>,
    /// Covariance of the delays, s^2: noise of the clicks, and the error of the known sound speed, which is
    /// common to all channels in proportion to their distance.
    pub covariance: Matrix,
    /// Covariance of the gains.
    pub gain_covariance: Matrix,
    /// Number of clicks used.
    pub clicks: usize,
    /// Sum of squared deviations of the clicks from their mean over the noise stated for them, per degree of
    /// freedom.
    pub scatter: f64,
    /// Frequencies between which the clicks tell of gains and delays, Hz; none if no click does.
    pub(crate) band_hz: Option<(f64, f64)>,
    template: Vec<C64>,
    frequencies: Vec<f64>,
}

/// How far gains may lie from their median, relative to it: probe microphones of one kind differ by a few per
/// cent.
pub(crate) const GAIN_SPREAD: f64 = 0.3;

/// One calibration click and when it should have arrived.
#[derive(Clone, Debug)]
pub struct KnownClick {
    /// The click as fitted.
    pub fit: ClickFit,
    /// Known travel time to each channel, s.
    pub expected: Vec<f64>,
    /// Clicks with the same number share one error of the known sound speed (one day's thermometer, say).
    pub group: usize,
    /// Relative standard deviation of that sound speed.
    pub speed_sd: f64,
}

impl ChannelDelays {
    /// Learns delays and gains from clicks at known sound speed. The mean waveform becomes the template from
    /// which absolute arrival times count.
    ///
    /// # Errors
    /// Fewer than two clicks, clicks that do not belong together, or delays and gains that cannot be those of
    /// channels: a negative gain, one that lies more than 30 % from the median of all, a delay (less the
    /// median) longer than sound takes between neighbouring microphones, two delays that differ by more than
    /// half of what sound takes from the one to the other (a sample, if that is more), channels that are
    /// exchanged.
    pub fn calibrate(clicks: &[KnownClick], rate_hz: f64) -> Result<Self, CalibrationError> {
        Self::calibrate_within(clicks, rate_hz, GAIN_SPREAD)
    }

    /// As [`Self::calibrate`], for channels whose gains may lie by `spread` from their median, relative to
    /// it.
    ///
    /// # Errors
    /// Those of [`Self::calibrate`].
    pub fn calibrate_within(
        clicks: &[KnownClick],
        rate_hz: f64,
        spread: f64,
    ) -> Result<Self, CalibrationError> {
        let (Some(first), count) = (clicks.first(), clicks.len()) else {
            return Err(CalibrationError::TooFew { have: 0 });
        };
        if count < 2 {
            return Err(CalibrationError::TooFew { have: count });
        }
        let channels = first.expected.len();
        for click in clicks {
            let frequencies = click.fit.frequencies.len();
            if click.fit.times.len() != channels
                || click.expected.len() != channels
                || frequencies != first.fit.frequencies.len()
            {
                return Err(CalibrationError::Mismatch {
                    channels: click.fit.times.len(),
                    frequencies,
                    expected: channels,
                });
            }
        }
        let mut template = first.fit.waveform.clone();
        // The mean waveform settles after one round: each click is placed on it with an error of second
        // order.
        for _ in 0..3 {
            let mut mean = vec![C64::ZERO; template.len()];
            for click in clicks {
                let (shift, scale) = place(&click.fit, &template)?.0;
                for ((sum, w), omega) in mean.iter_mut().zip(&click.fit.waveform).zip(&click.fit.frequencies)
                {
                    *sum += w * C64::from_polar(1.0 / (scale * count as f64), omega * shift);
                }
            }
            template = mean;
        }
        let placed: Vec<Placed> =
            clicks.iter().map(|c| absolute(&c.fit, &template)).collect::<Result<_, _>>()?;
        let mean = |value: &dyn Fn(usize, usize) -> f64, m: usize| -> f64 {
            (0..count).map(|n| value(n, m)).sum::<f64>() / count as f64
        };
        let delay = |n: usize, m: usize| placed[n].times[m] - clicks[n].expected[m];
        // Clicks are not equally loud: only ratios of gains mean anything.
        let root_mean_square =
            |gains: &[f64]| (gains.iter().map(|g| g * g).sum::<f64>() / channels as f64).sqrt();
        let loudness: Vec<f64> = placed.iter().map(|p| root_mean_square(&p.gains)).collect();
        let gain = |n: usize, m: usize| placed[n].gains[m] / loudness[n];
        let delays: Vec<f64> = (0..channels).map(|m| mean(&delay, m)).collect();
        let gains: Vec<f64> = (0..channels).map(|m| mean(&gain, m)).collect();
        let unit = root_mean_square(&gains);

        let freedom = ((count - 1) * channels) as f64;
        let squares: f64 = (0..count)
            .flat_map(|n| (0..channels).map(move |m| (n, m)))
            .map(|(n, m)| {
                (delay(n, m) - delays[m]).powi(2) / placed[n].covariance[(m, m)].max(f64::MIN_POSITIVE)
            })
            .sum();
        // The shift of the template is common to the channels of a click, which makes squares scatter more
        // than those of independent numbers do: errors are enlarged rather too often.
        let scatter = squares / freedom;
        let inflation = if scatter > 1.0 + 3.0 * (2.0 / freedom).sqrt() { scatter } else { 1.0 };
        let mut covariance = Matrix::zeros(channels, channels);
        for p in &placed {
            covariance = covariance.plus(inflation / (count * count) as f64, &p.covariance);
        }
        let leaning = leaning(clicks, channels);
        for errors in &leaning {
            covariance = covariance
                .plus(1.0, &Matrix::from_fn(channels, channels, |i, j| errors[i][0] * errors[j][0]));
        }
        for (share, sd, expected) in groups(clicks) {
            covariance = covariance.plus(
                (share * sd).powi(2),
                &Matrix::from_fn(channels, channels, |i, j| expected[i] * expected[j]),
            );
        }
        let of_clicks = (0..count).map(|n| (0..channels).map(|m| delay(n, m)).collect());
        let of_clicks: Vec<Vec<f64>> = of_clicks.collect();
        in_order(&of_clicks, &first.expected, rate_hz.recip())?;
        plausible(&delays, &gains, &first.expected, spread, &first.fit.overlapped)?;
        alike(&delays, &first.expected, rate_hz.recip())?;
        let left = misfit(&clicks.iter().map(|c| c.fit.misfit).collect::<Vec<f64>>())?;
        let [gain_variance, time_variance] = systematic(left, &template, &first.fit.frequencies);
        covariance = covariance.plus(time_variance, &Matrix::diagonal(&vec![1.0; channels]));
        // What gains scatter beyond the noise that the fits state is independent between channels. From a
        // few clicks, what one channel's gain scatters says little: all do together.
        let noise: Vec<Matrix> = clicks.iter().map(|c| relative(&c.fit)).collect();
        let groups: Vec<Group> = (0..channels)
            .map(|m| {
                let noise = |n: usize, m: usize| gain(n, m).powi(2) * noise[n][(m, m)];
                let squares = (0..count).map(|n| (gain(n, m) - gains[m]).powi(2)).sum();
                Group { within: mean(&noise, m), squares, count }
            })
            .collect();
        let mut gain_covariance = Matrix::from_fn(channels, channels, |i, j| {
            noise.iter().map(|n| n[(i, j)]).sum::<f64>() * gains[i] * gains[j] / (count * count) as f64
        });
        for (m, (variance, group)) in variances_of_means(&groups).into_iter().zip(&groups).enumerate() {
            gain_covariance[(m, m)] += (variance - group.within / count as f64).max(0.0);
            gain_covariance[(m, m)] += gain_variance * gains[m].powi(2);
        }
        for errors in &leaning {
            // Gains count from their mean square.
            let common = (0..channels).map(|m| gains[m].powi(2) * errors[m][1]).sum::<f64>()
                / (channels as f64 * unit * unit);
            let error = |m: usize| gains[m] * (errors[m][1] - common);
            gain_covariance =
                gain_covariance.plus(1.0, &Matrix::from_fn(channels, channels, |i, j| error(i) * error(j)));
        }
        let frequencies = first.fit.frequencies.clone();
        Ok(Self {
            rate_hz,
            delays,
            gain_covariance: Matrix::from_fn(channels, channels, |i, j| {
                gain_covariance[(i, j)] / (unit * unit)
            }),
            gains: gains.iter().map(|g| g / unit).collect(),
            covariance,
            clicks: count,
            scatter,
            band_hz: Some(first.fit.band_hz),
            template,
            frequencies,
        })
    }

    /// Channels of which no click tells: gains of 1 and delays of 0, as well known as stated.
    pub(crate) fn stated(channels: usize, rate_hz: f64, stated: ChannelPriors) -> Self {
        let diagonal = |sd: f64| Matrix::diagonal(&vec![sd * sd; channels]);
        Self {
            rate_hz,
            delays: vec![0.0; channels],
            gains: vec![1.0; channels],
            covariance: diagonal(stated.delay_sd),
            gain_covariance: diagonal(stated.gain_sd),
            clicks: 0,
            scatter: 0.0,
            band_hz: None,
            template: Vec::new(),
            frequencies: Vec::new(),
        }
    }

    /// The same for channels that differ, as a manifest states them.
    pub(crate) fn stated_of_each(rate_hz: f64, stated: &rijke_rig::StatedChannels) -> Self {
        let rijke_rig::StatedChannels { gains, gain_sds, delays, delay_sds } = stated;
        let squares = |values: &mut dyn Iterator<Item = f64>| {
            Matrix::diagonal(&values.map(|sd| sd * sd).collect::<Vec<_>>())
        };
        let none = ChannelPriors { gain_sd: 0.0, delay_sd: 0.0 };
        Self {
            delays: delays.clone(),
            gains: gains.clone(),
            covariance: squares(&mut delay_sds.iter().copied()),
            gain_covariance: squares(&mut gains.iter().zip(gain_sds).map(|(g, sd)| g * sd)),
            ..Self::stated(gains.len(), rate_hz, none)
        }
    }

    /// Some of the channels.
    pub(crate) fn only(&self, channels: &[usize]) -> Self {
        let of = |values: &[f64]| channels.iter().map(|m| values[*m]).collect();
        Self {
            delays: of(&self.delays),
            gains: of(&self.gains),
            covariance: self.covariance.select(channels),
            gain_covariance: self.gain_covariance.select(channels),
            ..self.clone()
        }
    }

    /// The same channels at another sampling rate: their gains are the same, their delays only equal to
    /// `delay_sd`.
    pub(crate) fn at_another_rate(&self, rate_hz: f64, delay_sd: f64) -> Self {
        let channels = self.gains.len();
        let stated = Self::stated(channels, rate_hz, ChannelPriors { gain_sd: 0.0, delay_sd });
        let (gains, gain_covariance) = (self.gains.clone(), self.gain_covariance.clone());
        Self { gains, gain_covariance, band_hz: self.band_hz, ..stated }
    }

    /// By how much a small dispersion kappa of the path ([`crate::ClickOptions::dispersion`]) delays the
    /// impulse, s per s^{1/2}: the shift that matches a phase of kappa sqrt(omega) best, weighted as arrival
    /// times are, with omega^2 |w|^2.
    pub(crate) fn delay_per_dispersion(&self) -> f64 {
        let moment = |power: f64| -> f64 {
            let terms = self.frequencies.iter().zip(&self.template);
            terms.map(|(omega, w)| omega.powf(power) * w.norm_sqr()).sum()
        };
        moment(1.5) / moment(2.0)
    }

    /// Arrival times of one click with the delays removed. Its covariance is that of the noise alone if
    /// `alone`, and includes the common error of this calibration otherwise. A channel of opposite polarity
    /// does not matter here: see [`Self::inverted`].
    ///
    /// # Errors
    /// A waveform that cannot be compared with the template.
    pub fn arrival(&self, fit: &ClickFit, alone: bool) -> Result<Click, Fault> {
        if fit.frequencies.len() != self.frequencies.len() {
            let (have, need) = (fit.frequencies.len(), self.frequencies.len());
            return Err(Fault::TooShort { what: "waveform", have, need });
        }
        let placed = absolute(fit, &self.template)?;
        Ok(Click {
            arrival_times: placed.times.iter().zip(&self.delays).map(|(t, d)| t - d).collect(),
            covariance: if alone { placed.covariance } else { placed.covariance.plus(1.0, &self.covariance) },
        })
    }

    /// The channels that have the opposite polarity in this click: their gains have not the sign that the
    /// calibration found.
    ///
    /// # Errors
    /// A waveform that cannot be compared with the template.
    pub fn inverted(&self, fit: &ClickFit) -> Result<Vec<usize>, Fault> {
        let gains = absolute(fit, &self.template)?.gains;
        Ok((0..gains.len()).filter(|&m| gains[m] * self.gains[m] < 0.0).collect())
    }

    /// Removes delays and gains from a ping. Its covariance then includes the common error of this
    /// calibration.
    #[must_use]
    pub fn correct(&self, ping: &Ping) -> Ping {
        let reference = ping.reference;
        // A record shows p(t - d): its amplitude is p e^{-s d}, times the gain.
        let factor = |m: usize| {
            (ping.s * (self.delays[m] - self.delays[reference])).exp()
                * (self.gains[reference] / self.gains[m])
        };
        let pressures: Vec<C64> = ping.pressures.iter().enumerate().map(|(m, p)| p * factor(m)).collect();
        let others: Vec<usize> = (0..pressures.len()).filter(|&m| m != reference).collect();
        let size = ModeRows::count(others.len());
        let mut map = Matrix::zeros(size, size);
        let set = |map: &mut Matrix, row: usize, column: usize, z: C64| {
            map[(row, column)] = z.re;
            map[(row, column + 1)] = -z.im;
            map[(row + 1, column)] = z.im;
            map[(row + 1, column + 1)] = z.re;
        };
        set(&mut map, 0, 0, C64::ONE);
        for (i, &m) in others.iter().enumerate() {
            let row = ModeRows::pressure(i);
            set(&mut map, row, row, factor(m));
            set(&mut map, row, 0, pressures[m] * (self.delays[m] - self.delays[reference]));
        }
        let covariance = map.product(&ping.covariance).product(&map.transpose());
        // d p_m = p_m [s (dd_m - dd_ref) - (dg_m / g_m - dg_ref / g_ref)]
        let channels = pressures.len();
        let mut common = Matrix::zeros(size, 2 * channels);
        for (i, &m) in others.iter().enumerate() {
            for (n, sign) in [(m, 1.0), (reference, -1.0)] {
                let delay = pressures[m] * ping.s * sign;
                let gain = pressures[m] * (-sign / self.gains[n]);
                for (column, z) in [(n, delay), (channels + n, gain)] {
                    common[(ModeRows::pressure(i), column)] += z.re;
                    common[(ModeRows::pressure(i) + 1, column)] += z.im;
                }
            }
        }
        let error = Matrix::from_fn(2 * channels, 2 * channels, |i, j| match (i < channels, j < channels) {
            (true, true) => self.covariance[(i, j)],
            (false, false) => self.gain_covariance[(i - channels, j - channels)],
            _ => 0.0,
        });
        let covariance = covariance.plus(1.0, &common.product(&error).product(&common.transpose()));
        Ping { s: ping.s, pressures, reference, covariance }
    }

    /// What this calibration leaves of every ping's relative pressures: the same for all.
    #[must_use]
    pub fn left_over(&self, reference: usize) -> ChannelErrors {
        let others: Vec<usize> = (0..self.gains.len()).filter(|&m| m != reference).collect();
        let against = |c: &dyn Fn(usize, usize) -> f64| {
            Matrix::from_fn(others.len(), others.len(), |i, j| {
                let (m, n) = (others[i], others[j]);
                c(m, n) - c(m, reference) - c(reference, n) + c(reference, reference)
            })
        };
        ChannelErrors {
            delays: against(&|m, n| self.covariance[(m, n)]),
            gains: against(&|m, n| self.gain_covariance[(m, n)] / (self.gains[m] * self.gains[n])),
            contained: true,
        }
    }
}

/// Mean over the clicks of how far times and gains lean on each end that the tube may have: the same in all.
fn leaning(clicks: &[KnownClick], channels: usize) -> Vec<Vec<[f64; 2]>> {
    let ends = clicks.iter().map(|c| c.fit.leaning.len()).max().unwrap_or(0);
    let mut mean = vec![vec![[0.0; 2]; channels]; ends];
    for (end, errors) in clicks.iter().flat_map(|c| c.fit.leaning.iter().enumerate()) {
        for (sum, error) in mean[end].iter_mut().zip(errors) {
            *sum = [0, 1].map(|i| sum[i] + error[i] / clicks.len() as f64);
        }
    }
    mean
}

/// Share of all clicks, sd of the sound speed, and expected times of each group.
fn groups(clicks: &[KnownClick]) -> Vec<(f64, f64, &[f64])> {
    let mut seen: Vec<(usize, f64, f64, &[f64])> = Vec::new();
    for click in clicks {
        let one = 1.0 / clicks.len() as f64;
        match seen.iter_mut().find(|g| g.0 == click.group) {
            Some(group) => group.1 += one,
            None => seen.push((click.group, one, click.speed_sd, &click.expected)),
        }
    }
    seen.into_iter().map(|(_, share, sd, expected)| (share, sd, expected)).collect()
}
