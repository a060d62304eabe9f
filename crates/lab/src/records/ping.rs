//! A ping: the forced oscillation and the ring-down of several modes after the loudspeaker stops.

use crate::acoustics::duct::FineMode;
use rijke_numerics::C64;

/// What a loudspeaker that pulls at one frequency and then stops makes the microphones hear.
///
/// The response to Re(e^{i omega t}) for t < 0 and nothing after is, with poles s_n and residues r_n, Re(a
/// e^{i omega t}) before and the sum of Re(b_n e^{s_n t}) after, b_n = r_n (e^{i theta}/(i omega - s_n) +
/// e^{-i theta}/(-i omega - s_n)): exact for a response that is the sum of its poles, and continuous at t
/// = 0.
#[derive(Clone, Debug)]
pub(crate) struct Ping {
    modes: Vec<FineMode>,
    /// Forcing frequency, rad/s.
    omega: f64,
    /// Source pressure that gives the wanted amplitude at the reference microphone, Pa.
    source: f64,
}

/// One stop of the loudspeaker.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    /// When, s after the first sample.
    pub(crate) time: f64,
    /// Angle of the source at that moment, rad.
    pub(crate) angle: f64,
    /// Amplitude relative to the nominal one.
    pub(crate) amplitude: f64,
    /// Relative change of all frequencies: the gas is a little warmer or colder.
    pub(crate) warmth: f64,
}

impl Ping {
    /// From the modes of an operating point: forcing `detuning` off resonance, amplitude `wanted` Pa at
    /// `reference`.
    #[must_use]
    pub(crate) fn new(modes: Vec<FineMode>, detuning: f64, reference: usize, wanted: f64) -> Self {
        let omega = modes[0].s.im * (1.0 + detuning);
        let unit = Self { modes, omega, source: 1.0 };
        let source = wanted / unit.forced(reference, 1.0).norm();
        Self { source, ..unit }
    }

    /// The amplitude of the forced oscillation at microphone `m`.
    fn forced(&self, m: usize, stretch: f64) -> C64 {
        let frequency = C64::new(0.0, self.omega);
        let pole = |mode: &FineMode| {
            let (s, r) = (mode.s * stretch, mode.residue[m] * stretch);
            r / (frequency - s) + (r.conj()) / (frequency - s.conj())
        };
        self.source * self.modes.iter().map(pole).sum::<C64>()
    }

    /// Adds the ping to every channel: `channels[m]` sampled every `dt` s from sample `first` on, microphone
    /// m heard `delays[m]` s late.
    pub(crate) fn add(&self, channels: &mut [Vec<f64>], first: usize, dt: f64, delays: &[f64], stop: Stop) {
        let stretch = 1.0 + stop.warmth;
        let length = channels.first().map_or(0, Vec::len);
        let end = |delay: f64| (((stop.time + delay) / dt).ceil().max(0.0) as usize).clamp(first, length);
        let base = delays.iter().map(|d| end(*d)).min().unwrap_or(first);
        let decays: Vec<Decay> =
            self.modes.iter().map(|mode| Decay::new(mode.s * stretch * dt, length - base)).collect();
        let turn = C64::from_polar(1.0, stop.angle);
        for (m, channel) in channels.iter_mut().enumerate() {
            let (delay, last) = (delays[m], end(delays[m]));
            let before = first as f64 * dt - stop.time - delay;
            let start = stop.amplitude * self.forced(m, stretch) * turn;
            let mut phasor = start * C64::from_polar(1.0, self.omega * before);
            let step = C64::from_polar(1.0, self.omega * dt);
            for sample in &mut channel[first..last] {
                *sample += phasor.re;
                phasor *= step;
            }
            for (mode, decay) in self.modes.iter().zip(&decays) {
                let (s, r) = (mode.s * stretch, mode.residue[m] * stretch);
                let frequency = C64::new(0.0, self.omega);
                let b = stop.amplitude
                    * self.source
                    * r
                    * (turn / (frequency - s) + turn.conj() / (-frequency - s));
                decay.add(
                    &mut channel[last..],
                    last - base,
                    b * (s * (base as f64 * dt - stop.time - delay)).exp(),
                );
            }
        }
    }
}

/// e^{s dt k}, k = 0, 1, ...: computed once and shared by the channels.
struct Decay {
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Decay {
    fn new(exponent: C64, length: usize) -> Self {
        let (step, mut z) = (exponent.exp(), C64::ONE);
        let (mut re, mut im) = (Vec::with_capacity(length), Vec::with_capacity(length));
        for _ in 0..length {
            re.push(z.re);
            im.push(z.im);
            z *= step;
            if z.norm_sqr() < 1e-20 {
                break;
            }
        }
        Self { re, im }
    }

    /// Adds Re(b e^{s dt (k + skip)}) to sample k; what has decayed below 1e-10 is left out.
    fn add(&self, samples: &mut [f64], skip: usize, b: C64) {
        let skip = skip.min(self.re.len());
        for ((sample, re), im) in samples.iter_mut().zip(&self.re[skip..]).zip(&self.im[skip..]) {
            *sample += b.re * re - b.im * im;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ping() -> Ping {
        let mode = |s: C64, r: f64| FineMode { s, residue: vec![C64::new(r, 0.3 * r), C64::new(-r, r)] };
        let modes = vec![mode(C64::new(-10.0, 1060.0), 40.0), mode(C64::new(-16.0, 2125.0), 70.0)];
        Ping::new(modes, 0.004, 0, 8.0)
    }

    #[test]
    fn oracle_ring_down_against_the_convolution_with_the_forcing() {
        // p(t) = integral of h(t - t') Re(e^{i(omega t' + theta)}) dt' over t' < 0, h(t) = 2 sum Re(r
        // e^{st}), by Simpson.
        let ping = ping();
        let stop = Stop { time: 0.0, angle: 0.7, amplitude: 1.0, warmth: 0.0 };
        let mut channels = vec![vec![0.0; 200], vec![0.0; 200]];
        ping.add(&mut channels, 0, 1e-4, &[0.0, 0.0], stop);
        let (n, h) = (400_000, 1e-5);
        for k in [0, 37, 150] {
            let t = k as f64 * 1e-4;
            let integrand = |j: usize| {
                let past = j as f64 * h;
                let impulse: f64 =
                    ping.modes.iter().map(|m| 2.0 * (m.residue[1] * (m.s * (t + past)).exp()).re).sum();
                impulse * ping.source * (0.7 - ping.omega * past).cos()
            };
            let inner: f64 = (1..n).map(|j| if j % 2 == 1 { 4.0 } else { 2.0 } * integrand(j)).sum();
            let convolution = (integrand(0) + inner + integrand(n)) * h / 3.0;
            let found = channels[1][k];
            assert!((found - convolution).abs() < 1e-6 * 8.0, "t = {t}: {found} against {convolution}");
        }
    }

    #[test]
    fn exact_delays_shift_and_the_amplitude_is_as_wanted() {
        let stop = |time| Stop { time, angle: 0.2, amplitude: 1.0, warmth: 0.0 };
        let record = |delays: [f64; 2], time| {
            let mut channels = vec![vec![0.0; 4000], vec![0.0; 4000]];
            ping().add(&mut channels, 100, 1e-4, &delays, stop(time));
            channels
        };
        let (plain, late) = (record([0.0; 2], 0.2), record([3e-4; 2], 0.2));
        for n in 110..3990 {
            assert!((plain[0][n] - late[0][n + 3]).abs() < 1e-9, "{n}");
        }
        assert_eq!(plain[0][..100], vec![0.0; 100]);
        let peak = plain[0][1000..1900].iter().fold(0.0_f64, |a, p| a.max(p.abs()));
        assert!((peak / 8.0 - 1.0).abs() < 0.01, "{peak}");
    }
}
