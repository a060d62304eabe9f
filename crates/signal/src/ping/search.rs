//! Which modes a ring-down holds: a first guess by ESPRIT, refined on a decimated copy of its first part,
//! then whatever tone still stands out of what is left over, one at a time.

use super::fairest::{self, APART_HZ};
use super::options::PingOptions;
use super::ringing::Ringing;
use crate::Fault;
use crate::dsp::kernels::dot;
use crate::dsp::transform;
use crate::ringdown::pencil::{self, Decimated};
use crate::ringdown::{
    Component, Kind, MAINS, SEARCHING, Solution, White, energies, fundamental, solve, with_fundamental,
};
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// What to look for.
pub(crate) struct Search<'a> {
    pub(crate) options: &'a PingOptions,
    /// Harmonics of the mains that the record holds.
    pub(crate) harmonics: &'a [u32],
    /// Steady tones beside the mode, Hz.
    pub(crate) tones: &'a [f64],
    /// Noise that rings the mode.
    pub(crate) ringing: Ringing,
}

/// Decay rate up to which a tone at a harmonic of the mains is hum, 1/s.
pub(super) const LASTS: f64 = 1.0;
/// Most modes added after the first guess.
const MOST_ADDED: usize = 6;

impl Search<'_> {
    /// The modes that ESPRIT sees, the strongest in the band first, then the mains; and the first of them as
    /// ESPRIT has it.
    pub(crate) fn first_guess(&self, early: White<'_>) -> Result<(Vec<Component>, C64), Fault> {
        let decimated = self.decimated(early);
        let mains = TAU * self.options.mains_hz;
        let mode = |s: C64| Component::new(C64::new(s.re.min(-0.1), s.im), Kind::Mode);
        let tone = |&h: &u32| Component::new(C64::new(0.0, mains * f64::from(h)), Kind::Mains(h));
        let steady = |hz: &f64| Component::new(C64::new(0.0, TAU * hz), Kind::Tone);
        let poles = pencil::poles(&decimated)?;
        let guess_of = |is_mode: &dyn Fn(&C64) -> bool| {
            let modes = poles.iter().copied().filter(is_mode).map(mode);
            let lasting = self.harmonics.iter().map(tone).chain(self.tones.iter().map(steady));
            let mut components: Vec<Component> = modes.chain(lasting).collect();
            let strength = energies(decimated.white(), &components)?;
            self.drop_weak(&decimated, &mut components, strength).map(|()| components)
        };
        // Where no other mode is in the band, what decays beside a harmonic of the mains is one.
        let components = guess_of(&|s| self.may_be_mode(*s))
            .or_else(|fault| guess_of(&|s| self.may_be_mode(*s) || s.re < -LASTS).map_err(|_| fault))?;
        let guess = components[0].s;
        let settled = self.settled(&decimated, components)?;
        Ok((self.of_the_kind(&decimated, settled).components, guess))
    }

    /// The given components and the modes that stand out of what they leave.
    pub(crate) fn more_modes(&self, early: White<'_>, known: &[Component]) -> Result<Vec<Component>, Fault> {
        let decimated = self.decimated(early);
        let settled = self.settled(&decimated, known.to_vec())?;
        let mut solution = self.of_the_kind(&decimated, settled);
        for _ in 0..MOST_ADDED {
            let left = solution.residuals(decimated.white(), 0.0);
            let left = White { samples: &left, ..decimated.white() };
            let Some(found) = self.strongest(left, decimated.variance, &solution.components) else { break };
            let mut more = solution.components.clone();
            more.insert(modes(&more), found);
            let next = self.settled(&decimated, more)?;
            let chance = self.ringing.energy(found.s.im, left.step);
            if solution.residual - next.residual < floor(left.channels) * decimated.variance + chance {
                break;
            }
            solution = next;
        }
        Ok(solution.components)
    }

    /// The fit of the right kind: a drift of the frequency is no second mode.
    fn of_the_kind(&self, decimated: &Decimated, found: Solution) -> Solution {
        let white = decimated.white();
        let noise = self.ringing.added_to(decimated.variance, white.channels);
        if !fairest::is_doubtful(&found, noise) {
            return found;
        }
        let fit = |components| self.settled(decimated, components).ok();
        // A jump is no mode.
        fairest::fairest(white, (noise, self.ringing), found, &fit)
            .map_or_else(|jumped| jumped.1, |(fair, _)| fair)
    }

    /// Fits `white` by the given components, without the weakest neighbours of the first one if the record
    /// cannot tell them apart, and without those that are no decaying modes; `close` as in [`solve`].
    pub(crate) fn solve(
        &self,
        white: White<'_>,
        early: White<'_>,
        mut components: Vec<Component>,
        close: f64,
    ) -> Result<Solution, Fault> {
        loop {
            let count = modes(&components);
            components = self.grounded(components);
            match solve(white, &components, close) {
                // Without a drift or an excess of damping, where none is found.
                Err(Fault::Singular(_) | Fault::NotConverged { .. }) if components[0].is_curved() => {
                    let Component { s, kind, chirp, excess, .. } = components[0];
                    let chirp = if excess.is_some() { chirp } else { None };
                    components[0] = Component { chirp, ..Component::new(s, kind) };
                }
                Err(Fault::Singular(_) | Fault::NotConverged { .. }) if count > 1 => {
                    components.remove(weakest(self.decimated(early).white(), &components));
                }
                Ok(solution) => match (1..count).find(|&k| self.is_no_mode(solution.components[k].s)) {
                    Some(k) => drop(components.remove(k)),
                    None => return Ok(solution),
                },
                Err(fault) => return Err(fault),
            }
        }
    }

    /// The harmonics of the mains that are more than what noise which rings the mode may feign.
    pub(crate) fn real_harmonics(&self, found: &Solution, step: f64) -> Result<Vec<u32>, Fault> {
        if !self.ringing.is_some() {
            return Ok(self.harmonics.to_vec());
        }
        let floor = floor(found.amplitudes[0].len());
        let energies = found.energies()?;
        let of = |(c, energy): (&Component, f64)| match c.kind {
            Kind::Mains(h) if energy > floor + self.ringing.energy(c.s.im, step) => Some(h),
            _ => None,
        };
        Ok(found.components.iter().zip(energies).filter_map(of).collect())
    }

    /// Whether all neighbours are modes that decay.
    pub(crate) fn are_modes(&self, components: &[Component]) -> bool {
        (1..modes(components)).all(|k| !self.is_no_mode(components[k].s))
    }

    fn is_no_mode(&self, s: C64) -> bool {
        s.re >= 0.0 || !self.may_be_mode(s)
    }

    /// The components with mains whose frequency is next to the nominal one: an earlier fit may have moved
    /// them.
    fn grounded(&self, components: Vec<Component>) -> Vec<Component> {
        let nominal = TAU * self.options.mains_hz;
        match fundamental(&components) {
            Some(found) if (found / nominal - 1.0).abs() > MAINS => with_fundamental(components, nominal),
            _ => components,
        }
    }

    fn decimated(&self, early: White<'_>) -> Decimated {
        let factor = ((0.42 / (early.step * self.options.highest_hz)).floor() as usize).max(1);
        Decimated::new(early, factor)
    }

    fn may_be_mode(&self, s: C64) -> bool {
        let mains = TAU * self.options.mains_hz;
        let lasts = |omega: f64| (s.im - omega).abs() < 8.0 && s.re.abs() < 8.0;
        let hum = |&h: &u32| lasts(mains * f64::from(h));
        let high = s.im > TAU * self.options.highest_hz;
        let steady = self.harmonics.iter().any(hum) || self.tones.iter().any(|hz| lasts(TAU * hz));
        !steady && !high && s.re < 2.0 && s.re > -0.5 * s.im
    }

    /// The maximum of the likelihood without what turns out to be no mode, or to be no more than noise could
    /// feign. A spurious pole near a strong mode looks significant until both have settled.
    fn settled(&self, decimated: &Decimated, mut components: Vec<Component>) -> Result<Solution, Fault> {
        loop {
            let count = modes(&components);
            components = self.grounded(components);
            let solution = match solve(decimated.white(), &components, SEARCHING) {
                Err(Fault::Singular(_) | Fault::NotConverged { .. }) if count > 1 => {
                    components.remove(weakest(decimated.white(), &components));
                    continue;
                }
                other => other?,
            };
            components.clone_from(&solution.components);
            if let Some(k) = (1..count).find(|&k| !self.may_be_mode(components[k].s)) {
                components.remove(k);
            } else {
                self.drop_weak(decimated, &mut components, solution.energies()?)?;
            }
            let same = |(a, b): (&Component, &Component)| a.s == b.s;
            let kept = components.len() == solution.components.len();
            if kept && components.iter().zip(&solution.components).all(same) {
                return Ok(solution);
            }
        }
    }

    /// Drops the modes that noise alone could feign, and puts the strongest in the band first. `strength` is
    /// the energy of each.
    fn drop_weak(
        &self,
        decimated: &Decimated,
        components: &mut Vec<Component>,
        mut strength: Vec<f64>,
    ) -> Result<(), Fault> {
        let floor = floor(decimated.white().channels);
        let in_band = |s: C64| (self.options.band_hz.0..=self.options.band_hz.1).contains(&(s.im / TAU));
        loop {
            let count = modes(components);
            let step = decimated.white().step;
            let needed =
                |k: usize| floor * decimated.variance + self.ringing.energy(components[k].s.im, step);
            match (0..count).min_by(|&a, &b| (strength[a] / needed(a)).total_cmp(&(strength[b] / needed(b))))
            {
                Some(k) if strength[k] < needed(k) => {
                    components.remove(k);
                    strength = energies(decimated.white(), components)?;
                }
                _ => {
                    let main = (0..count)
                        .filter(|&k| in_band(components[k].s))
                        .max_by(|&a, &b| strength[a].total_cmp(&strength[b]))
                        .ok_or(Fault::Weak(0.0))?;
                    components.swap(0, main);
                    return Ok(());
                }
            }
        }
    }

    /// The strongest damped tone in residuals of the given variance, away from the known components; none if
    /// it could be noise. A matched filter: the transform under e^{-alpha t} with the decay of the modes
    /// found.
    fn strongest(&self, left: White<'_>, variance: f64, known: &[Component]) -> Option<Component> {
        let decays: Vec<f64> = known.iter().filter(|c| c.kind == Kind::Mode).map(|c| -c.s.re).collect();
        let alpha = 1.5 * decays.iter().sum::<f64>() / decays.len().max(1) as f64;
        let alpha = alpha.max(2.0 / (left.rows() as f64 * left.step));
        let length = (2 * left.rows()).next_power_of_two();
        let transform = transform::forward(length);
        let (mut series, mut spectrum) = (transform.make_input_vec(), transform.make_output_vec());
        let mut energy = vec![0.0; spectrum.len()];
        let weight: Vec<f64> = (0..left.rows()).map(|n| (-alpha * n as f64 * left.step).exp()).collect();
        let weights = dot(&weight, &weight);
        for m in 0..left.channels {
            series.fill(0.0);
            let channel = left.samples.iter().skip(m).step_by(left.channels);
            for ((out, y), weight) in series.iter_mut().zip(channel).zip(&weight) {
                *out = y * weight;
            }
            transform.process(&mut series, &mut spectrum).ok()?;
            for (sum, z) in energy.iter_mut().zip(&spectrum) {
                *sum += 2.0 * z.norm_sqr() / (weights * variance);
            }
        }
        let resolution = 1.0 / (length as f64 * left.step);
        let allowed = |f: f64| {
            f > self.options.band_hz.0.min(60.0)
                && f < self.options.highest_hz
                && known.iter().all(|c| (f - c.s.im / TAU).abs() > APART_HZ)
        };
        let (bin, &largest) = energy
            .iter()
            .enumerate()
            .filter(|&(k, _)| allowed(k as f64 * resolution))
            .max_by(|a, b| a.1.total_cmp(b.1))?;
        let s = C64::new(-alpha, TAU * resolution * bin as f64);
        let chance = self.ringing.energy(s.im, left.step) / variance;
        (largest > floor(left.channels) + chance).then_some(Component::new(s, Kind::Mode))
    }
}

/// Number of modes; they come before the harmonics of the mains.
fn modes(components: &[Component]) -> usize {
    components.iter().take_while(|c| c.kind == Kind::Mode).count()
}

/// The neighbour of least energy; the last found if poles are so close that not even energies can be told
/// apart.
fn weakest(white: White<'_>, components: &[Component]) -> usize {
    let count = modes(components);
    energies(white, components)
        .map_or(count - 1, |e| (1..count).min_by(|&a, &b| e[a].total_cmp(&e[b])).unwrap_or(count - 1))
}

/// A spurious pole adapts to noise: its energy is chi-squared with two degrees of freedom per channel and two
/// more.
pub(super) fn floor(channels: usize) -> f64 {
    let freedom = 2.0 * channels as f64;
    freedom + 8.0 * (2.0 * freedom).sqrt()
}
