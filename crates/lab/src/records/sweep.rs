//! Sweeps: a sine whose frequency rises as an exponential of time drives the bottom end, and the
//! microphones hear what the duct's own response makes of it.

use super::virtual_rig::{Kind, VirtualRig, interleave, normal};
use crate::acoustics::duct::FineTube;
use crate::truth::LabError;
use realfft::RealFftPlanner;
use rijke_numerics::C64;
use rijke_rig::{RecordSource, RigError, Samples24};
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::Path;

/// The tube rings this long, s, before the next sweep begins.
const TAIL_S: f64 = 1.0;
/// Share of a sweep in which it swells, and in which it fades (Müller & Massarani, J. Audio Eng. Soc. 49
/// (2001) 443).
const FADE: f64 = 0.05;
/// The sweep goes beyond the frequencies that are wanted by this factor, so that they are loud.
const BEYOND: f64 = 1.25;
/// What wraps around the end of the window, where the tube has rung for longer than [`TAIL_S`], is smaller by
/// e to the power of this. More would bring up what lies beyond the frequencies that are computed.
const WRAPPED: f64 = 3.0;

impl VirtualRig {
    /// Number of records that [`VirtualRig::write_sweeps`] writes.
    #[must_use]
    pub fn sweep_count(&self) -> usize {
        let points = self.set().points.iter().map(|p| p.point.repeats as usize);
        points.sum::<usize>() + self.channels.len()
    }

    /// Writes sweeps of every operating point, those of the empty tube with every microphone at its own place
    /// and with two of them switched, and, last, the manifest. The sweeps excite frequencies from `low` to
    /// `high`, Hz. `written` is told how many more have been written.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write_sweeps(
        &self,
        folder: &Path,
        [low, high]: [f64; 2],
        written: &(dyn Fn(usize) + Sync),
    ) -> Result<(), LabError> {
        let rate = self.set().ping.rate_hz;
        let mut text = format!(
            "# Sweeps from {low} to {high} Hz. Beside a study.toml, in the folder `records`, `rijke process` makes transfer functions of them.\n\
             kind = \"virtual\"\nsource = {:?}\nrate_hz = {rate}\nband_hz = [{low:?}, {high:?}]\n\n[sweep]\nresolution_hz = 2.0\n\
             polynomials = 2 # a gain and a delay for every channel\nsources = [\"upstream\"]\nstraight = \"calibration/straight.wav\"\n",
            self.set().source
        );
        let record = |name: &str, samples: Samples24| -> Result<(), RigError> {
            let path = folder.join(name);
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent)
                    .map_err(|cause| RigError::Write { path: parent.to_owned(), cause })?;
            }
            samples.write(self.channels.len() as u16, &path)?;
            written(1);
            Ok(())
        };
        let own: Vec<usize> = (0..self.channels.len()).collect();
        if let Some(empty) = self.calibrations.first() {
            let tube = (&empty.duct, empty.temperature);
            record(
                "calibration/straight.wav",
                self.sweep(tube, "calibration/straight.wav", &own, [low, high]),
            )?;
            for channel in 1..own.len() {
                let name = format!("calibration/switched-{channel}.wav");
                let mut order = own.clone();
                order.swap(0, channel);
                record(&name, self.sweep(tube, &name, &order, [low, high]))?;
                let _ = write!(text, "\n[[sweep.switched]]\nfile = \"{name}\"\nchannel = {channel}\n");
            }
        }
        text += "\n[sweep.points]\n";
        for (truth, entry) in self.points.iter().zip(&self.set().points) {
            let day = &self.set().days[entry.day];
            let _ = writeln!(
                text,
                "# {} K at the thermometer, +- {} K",
                day.ambient_temperature, day.ambient_temperature_sd
            );
            let names: Vec<String> =
                (0..entry.point.repeats).map(|k| format!("{}/sweep-{k:02}.wav", entry.point.id)).collect();
            for name in &names {
                record(name, self.sweep((&truth.duct, truth.temperature), name, &own, [low, high]))?;
            }
            let _ = writeln!(text, "{:?} = {names:?}", entry.point.id);
        }
        let path = folder.join("manifest.toml");
        Ok(std::fs::write(&path, text).map_err(|cause| RigError::Write { path, cause })?)
    }

    /// One sweep in a duct at a temperature; channel c hears what there is at microphone `order[c]`.
    fn sweep(
        &self,
        (duct, temperature): (&FineTube, f64),
        name: &str,
        order: &[usize],
        band_hz: [f64; 2],
    ) -> Samples24 {
        let (stretch, speaker) = (self.set().ping, &self.truth.loudspeaker);
        let mut stream = self.stream("event", name);
        let amplitude = 1.0 + speaker.amplitude_sd * normal(&mut stream);
        let warmth = self.warmth(temperature, &mut stream);
        let delays: Vec<f64> = self.channels.iter().map(|c| c.ping_delay).collect();
        let source = source(speaker.sweep_s, stretch.rate_hz, band_hz);
        let unit = heard(duct, &source, stretch.rate_hz, band_hz, warmth, order, &delays);
        let peak = unit.iter().flatten().fold(f64::MIN_POSITIVE, |a, p| a.max(p.abs()));
        let scale = amplitude * speaker.sweep_pa / peak;
        let channels = unit.into_iter().map(|c| c.into_iter().map(|p| scale * p).collect()).collect();
        interleave(stretch, &self.digitise(channels, Kind::Ping, stretch.rate_hz, 0.0, name, None))
    }
}

/// The source pressure: a sweep of so many seconds that swells and fades, and silence. A fifth of the sweep's
/// octaves and fades lie outside of the band.
fn source(seconds: f64, rate_hz: f64, [low, high]: [f64; 2]) -> Vec<f64> {
    let [low, high] = [low / BEYOND, high * BEYOND];
    let growth = (high / low).ln() / seconds;
    let sample = |n: usize| {
        let t = n as f64 / rate_hz;
        let near = (t.min(seconds - t) / (FADE * seconds)).clamp(0.0, 1.0);
        let phase = TAU * low * (growth * t).exp_m1() / growth;
        phase.sin() * (0.5 * PI * near).sin().powi(2)
    };
    (0..((seconds + TAIL_S) * rate_hz).round() as usize).map(sample).collect()
}

/// What the channels hear of a source pressure, in gas whose speed of sound is 1 + `warmth` times that of the
/// duct: by superposition on the line s = damping + i omega, as for clicks.
fn heard(
    duct: &FineTube,
    source: &[f64],
    rate_hz: f64,
    [low, high]: [f64; 2],
    warmth: f64,
    order: &[usize],
    delays: &[f64],
) -> Vec<Vec<f64>> {
    let window = (source.len() * 5 / 4).next_power_of_two();
    let damping = WRAPPED * rate_hz / window as f64;
    let decay = |n: usize| (-damping * n as f64 / rate_hz).exp();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, back) = (planner.plan_fft_forward(window), planner.plan_fft_inverse(window));
    let mut samples = forward.make_input_vec();
    samples.iter_mut().zip(source).enumerate().for_each(|(n, (a, b))| *a = b * decay(n));
    let mut driven = forward.make_output_vec();
    // The lengths are those of the plans, here and below.
    let _ = forward.process(&mut samples, &mut driven);
    let df = rate_hz / window as f64;
    let mut spectra = vec![back.make_input_vec(); order.len()];
    // Beyond twice the margin the source is silent.
    let bins = (low / BEYOND.powi(2) / df) as usize..((high * BEYOND.powi(2) / df) as usize).min(window / 2);
    for k in bins {
        let s = C64::new(damping, TAU * k as f64 * df);
        let response = duct.response(s / (1.0 + warmth));
        for ((spectrum, place), delay) in spectra.iter_mut().zip(order).zip(delays) {
            spectrum[k] = driven[k] * response[*place] * (-s * *delay).exp() / window as f64;
        }
    }
    let channel = |mut spectrum: Vec<C64>| -> Vec<f64> {
        let mut samples = back.make_output_vec();
        // A real signal's first bin is real.
        spectrum[0].im = 0.0;
        let _ = back.process(&mut spectrum, &mut samples);
        samples.truncate(source.len());
        samples.iter().enumerate().map(|(n, p)| p / decay(n)).collect()
    };
    spectra.into_iter().map(channel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acoustics::duct::FineMode;
    use crate::apparatus::{base::base_state, open_ends::open_ends, tube};
    use crate::truth::Truth;
    use rijke_flow::{TubeCampaign, TubeRig};

    #[test]
    fn oracle_a_sweep_is_the_convolution_of_the_modes_with_its_source() {
        // The response is the sum of its poles: every mode obeys dy/dt = s y + r x, marched sample by sample
        // with x linear between samples. The modes above the twelfth answer at once.
        let (rig, truth) = (TubeRig::juniper_yoko_2022(), Truth::standard());
        let point = TubeCampaign::juniper_yoko_2022().row("C3").next().unwrap().clone();
        let base = base_state(&rig, &truth, &point, 294.0).unwrap();
        let duct = tube::duct(&rig, &truth, &point, &base, open_ends(&rig, &truth, &point, 1));
        let modes = tube::modes(&duct, &rig, &point, &base, 12).unwrap();
        let (rate, band) = (20_000.0, [130.0, 260.0]);
        let source = source(1.5, rate, band);
        let found = heard(&duct, &source, rate, band, 0.0, &[5, 2], &[0.0; 2]);
        let dt = 1.0 / rate;
        let middle = C64::new(0.0, TAU * 185.0);
        let all = duct.response(middle);
        for (channel, place) in found.iter().zip([5, 2]) {
            let pole = |m: &FineMode| {
                m.residue[place] / (middle - m.s) + m.residue[place].conj() / (middle - m.s.conj())
            };
            let rest = (all[place] - modes.iter().map(pole).sum::<C64>()).re;
            let mut sum: Vec<f64> = source.iter().map(|x| rest * x).collect();
            for mode in &modes {
                let (step, z) = ((mode.s * dt).exp(), mode.s * dt);
                // Integrals of e^{s (dt - t)} and of that times t/dt.
                let whole = (step - 1.0) / mode.s;
                let rising = (step - 1.0 - z) / (mode.s * z);
                let mut y = C64::ZERO;
                for n in 1..source.len() {
                    y = step * y
                        + mode.residue[place] * (source[n - 1] * (whole - rising) + source[n] * rising);
                    sum[n] += 2.0 * y.re;
                }
            }
            let size = sum.iter().fold(0.0_f64, |a, p| a.max(p.abs()));
            let worst = sum.iter().zip(channel).fold(0.0_f64, |a, (x, y)| a.max((x - y).abs()));
            assert!(worst < 2e-3 * size, "{worst} of {size}");
        }
    }
}
