//! A click: a band-limited pulse at the bottom end as it travels up the tube and back, with the dispersion,
//! attenuation and reflections of the duct's own response.

use crate::acoustics::duct::FineTube;
use realfft::RealFftPlanner;
use rijke_numerics::C64;
use std::collections::VecDeque;
use std::f64::consts::PI;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// What the microphones hear of a click, without noise, delays of the channels included.
#[derive(Clone, Debug)]
pub(crate) struct Click {
    /// Pressure at microphone m, Pa.
    nominal: Vec<Vec<f32>>,
    /// Its derivative with respect to a relative change of the speed of sound.
    warmer: Vec<Vec<f32>>,
}

/// The clicks heard last: one takes 0.4 MB, and the records of one operating point are asked for one after
/// another.
#[derive(Default)]
pub(crate) struct Clicks(Mutex<VecDeque<((bool, usize), Place)>>);

/// Where a click is or will be.
type Place = Arc<OnceLock<Arc<Click>>>;

/// Clicks kept at a time.
const KEPT: usize = 32;

impl Clicks {
    /// The click of a number, made if it is not there. Others may be made at the same time.
    pub(crate) fn get(&self, which: (bool, usize), make: impl FnOnce() -> Click) -> Arc<Click> {
        let place = {
            let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let found = kept.iter().position(|(other, _)| *other == which);
            let entry = found.and_then(|k| kept.remove(k)).unwrap_or_else(|| (which, Arc::default()));
            let place = Arc::clone(&entry.1);
            kept.push_back(entry);
            if kept.len() > KEPT {
                kept.pop_front();
            }
            place
        };
        Arc::clone(place.get_or_init(|| Arc::new(make())))
    }
}

/// How a click is made and recorded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pulse {
    /// Peak of the source pressure, Pa.
    pub(crate) peak: f64,
    /// Centre frequency of the Ricker pulse, Hz.
    pub(crate) frequency: f64,
    /// Middle of the pulse at the bottom end, s after the first sample.
    pub(crate) time: f64,
    /// Sampling rate, Hz.
    pub(crate) rate_hz: f64,
    /// Samples of the record.
    pub(crate) length: usize,
}

/// The record is computed on a damped spectrum, s = DAMPING + i omega, and multiplied by e^{DAMPING t}: what
/// wraps around the end of the window comes back smaller by e^{-DAMPING window}, here below 1e-7. Larger
/// values would bring rounding up instead.
const DAMPING: f64 = 120.0;

impl Pulse {
    /// Laplace transform of peak (1 - 2 q) e^{-q}, q = (pi f t)^2, about t = 0: the second derivative of a
    /// Gaussian.
    fn spectrum(&self, s: C64) -> C64 {
        let a = PI * self.frequency;
        let q = s * s / (4.0 * a * a);
        -self.peak * 2.0 * PI.sqrt() / a * q * q.exp()
    }
}

impl Click {
    /// The click in `duct`, microphone m heard `delays[m]` s late.
    #[must_use]
    pub(crate) fn new(duct: &FineTube, pulse: Pulse, delays: &[f64]) -> Self {
        let window = (pulse.length * 5 / 4).next_power_of_two();
        let df = pulse.rate_hz / window as f64;
        // Above 5.5 times its centre frequency the pulse's spectrum is below 1e-11 of its peak.
        let bins = (window / 2).min((5.5 * pulse.frequency / df) as usize);
        let (mut nominal, mut warmer) = (spectra(delays.len(), window), spectra(delays.len(), window));
        for k in 0..bins {
            let s = C64::new(DAMPING, 2.0 * PI * k as f64 * df);
            let source = pulse.spectrum(s) * df;
            // A gas warmer by a relative change e of the speed of sound answers at s as this one at s/(1 +
            // e).
            let small = 1e-4;
            let (cold, warm) = (duct.response(s), duct.response(s / (1.0 + small)));
            for (m, delay) in delays.iter().enumerate() {
                let shifted = source * (-s * (pulse.time + delay)).exp();
                nominal[m][k] = shifted * cold[m];
                warmer[m][k] = shifted * (warm[m] - cold[m]) / small;
            }
        }
        let back = |spectra: Vec<Vec<C64>>| spectra.into_iter().map(|s| invert(s, window, pulse)).collect();
        Self { nominal: back(nominal), warmer: back(warmer) }
    }

    /// The record of microphone `m`, `amplitude` times, in gas whose speed of sound is 1 + `warmth` times the
    /// nominal.
    pub(crate) fn channel(&self, m: usize, amplitude: f64, warmth: f64) -> Vec<f64> {
        let pairs = self.nominal[m].iter().zip(&self.warmer[m]);
        pairs.map(|(p, d)| amplitude * (f64::from(*p) + warmth * f64::from(*d))).collect()
    }
}

fn spectra(count: usize, window: usize) -> Vec<Vec<C64>> {
    vec![vec![C64::ZERO; window / 2 + 1]; count]
}

/// From the damped spectrum to samples.
fn invert(mut spectrum: Vec<C64>, window: usize, pulse: Pulse) -> Vec<f32> {
    // A real signal's first bin is real; the damped response at omega = 0 is.
    spectrum[0].im = 0.0;
    let plan = RealFftPlanner::<f64>::new().plan_fft_inverse(window);
    let mut samples = plan.make_output_vec();
    match plan.process(&mut spectrum, &mut samples) {
        Ok(()) => {}
        // Sizes are the plan's own and the first and last bins are real, which is all that it can refuse.
        Err(_) => samples.fill(0.0),
    }
    samples.truncate(pulse.length);
    let damped = samples.iter().enumerate();
    damped.map(|(n, p)| (p * (DAMPING * n as f64 / pulse.rate_hz).exp()) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::apparatus::base::base_state;
    use crate::apparatus::tube;
    use crate::truth::Truth;
    use rijke_flow::{TubeCampaign, TubeRig};

    fn empty(temperature: f64) -> (TubeRig, FineTube) {
        let (rig, campaign) = (TubeRig::juniper_yoko_2022(), TubeCampaign::juniper_yoko_2022());
        let point = campaign.row("C3").next().unwrap().clone();
        let base = base_state(&rig, &Truth::standard(), &point, temperature).unwrap();
        let duct = {
            let truth = Truth::standard();
            tube::duct(
                &rig,
                &truth,
                &point,
                &base,
                crate::apparatus::open_ends::open_ends(&rig, &truth, &point, 1),
            )
        };
        (rig, duct)
    }

    fn pulse(time: f64) -> Pulse {
        Pulse { peak: 6.0, frequency: 1600.0, time, rate_hz: 62_500.0, length: 6250 }
    }

    #[test]
    fn exact_spectrum_is_that_of_the_ricker_pulse() {
        let (pulse, dt) = (pulse(0.0), 1e-6);
        let s = C64::new(50.0, 9000.0);
        let direct: C64 = (-3000..=3000)
            .map(|n| {
                let (t, a) = (f64::from(n) * dt, PI * pulse.frequency);
                let q = (a * t).powi(2);
                6.0 * (1.0 - 2.0 * q) * (-q).exp() * (-s * t).exp() * dt
            })
            .sum();
        assert!((pulse.spectrum(s) - direct).norm() < 1e-9 * direct.norm());
    }

    #[test]
    fn oracle_pulse_arrives_when_sound_does_and_nothing_comes_before() {
        let (rig, duct) = empty(294.0);
        let click = Click::new(&duct, pulse(0.02), &[0.0; 8]);
        let c = duct.top.gas.sound_speed;
        for (m, x) in rig.microphones.positions.iter().enumerate() {
            let channel = click.channel(m, 1.0, 0.0);
            let early = ((0.02 + x / c - 0.9e-3) * 62_500.0) as usize;
            let before = channel[..early].iter().fold(0.0_f64, |a, p| a.max(p.abs()));
            assert!(before < 1e-4, "microphone {m} hears {before} Pa before the pulse");
            let near = &channel[early..early + 60];
            let peak = (0..60).max_by(|a, b| near[*a].abs().total_cmp(&near[*b].abs())).unwrap() + early;
            // The open end differentiates the pulse and the wall delays it: within 0.15 ms of the travel
            // time.
            assert!((peak as f64 / 62_500.0 - 0.02 - x / c).abs() < 1.5e-4, "microphone {m}: {peak}");
        }
    }

    #[test]
    fn oracle_time_domain_rings_with_the_modes() {
        // Late in the record the response is a sum of modes: compare with the sum over residues.
        let (rig, duct) = empty(294.0);
        let point = TubeCampaign::juniper_yoko_2022().row("C3").next().unwrap().clone();
        let base = base_state(&rig, &Truth::standard(), &point, 294.0).unwrap();
        let modes = tube::modes(&duct, &rig, &point, &base, 12).unwrap();
        let pulse = pulse(0.02);
        let click = Click::new(&duct, pulse, &[0.0; 8]);
        let channel = click.channel(5, 1.0, 0.0);
        // Modes above the tenth are still loud at this time; the pulse must be slow enough to leave them out.
        let slow = Pulse { frequency: 500.0, ..pulse };
        let rung = Click::new(&duct, slow, &[0.0; 8]).channel(5, 1.0, 0.0);
        let (mut worst, mut size) = (0.0_f64, 0.0_f64);
        for n in 3000..6200 {
            let t = n as f64 / 62_500.0 - 0.02;
            let sum: f64 =
                modes.iter().map(|m| 2.0 * (m.residue[5] * slow.spectrum(m.s) * (m.s * t).exp()).re).sum();
            worst = worst.max((sum - rung[n]).abs());
            size = size.max(sum.abs());
        }
        assert!(worst < 1e-3 * size, "{worst} of {size}");
        assert!(channel.iter().all(|p| p.is_finite()));
    }

    #[test]
    fn oracle_warmth_is_the_derivative_with_temperature() {
        let delays = [1e-5; 8];
        let (cold, warm) = (empty(294.0).1, empty(294.1).1);
        let warmth = warm.top.gas.sound_speed / cold.top.gas.sound_speed - 1.0;
        let (a, b) = (Click::new(&cold, pulse(0.02), &delays), Click::new(&warm, pulse(0.02), &delays));
        let (linear, true_one) = (a.channel(7, 1.0, warmth), b.channel(7, 1.0, 0.0));
        let change =
            a.channel(7, 1.0, 0.0).iter().zip(&true_one).fold(0.0_f64, |w, (x, y)| w.max((x - y).abs()));
        let error = linear.iter().zip(&true_one).fold(0.0_f64, |w, (x, y)| w.max((x - y).abs()));
        // What is left is the change of the losses with temperature and the second order in 1.7e-4.
        assert!(error < 0.03 * change, "{error} of {change}");
    }
}
