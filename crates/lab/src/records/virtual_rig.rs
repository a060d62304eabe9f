//! The laboratory as a source of records.

use super::click::{Click, Clicks, Pulse};
use super::faults::BadRecord;
use super::noise::{Colour, Hum};
use super::ping::{Ping, Stop};
use crate::acoustics::duct::{FineMode, FineTube};
use crate::truth::Truth;
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_flow::{BaseState, HeatedTube};
use rijke_numerics::{C64, Stream, Streams};
use rijke_rig::{Record, RecordSet, RecordSource, RecordTiming, RigError, Samples24};
use std::f64::consts::PI;
use std::sync::Arc;

/// A rig that exists only as a computation, and the acquisition system that records it.
///
/// A record depends on the seed, the truth and its own name alone: never on which records were made before,
/// on the number of threads, or on which rows of the campaign are asked for.
pub struct VirtualRig {
    pub(crate) set: RecordSet,
    pub(crate) tube: HeatedTube,
    pub(crate) truth: Truth,
    pub(crate) streams: Streams,
    pub(crate) points: Vec<PointTruth>,
    pub(crate) calibrations: Vec<CalibrationTruth>,
    pub(crate) channels: Vec<Channel>,
    pub(crate) colour: [Colour; 2],
    pub(crate) clicks: Clicks,
}

/// What is really so at an operating point.
pub(crate) struct PointTruth {
    pub(crate) duct: FineTube,
    pub(crate) base: BaseState,
    pub(crate) modes: Vec<FineMode>,
    pub(crate) ping: Ping,
    pub(crate) temperature: f64,
}

pub(crate) struct CalibrationTruth {
    pub(crate) duct: FineTube,
    pub(crate) temperature: f64,
}

/// One microphone with its amplifier and converter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Channel {
    pub(crate) gain: f64,
    pub(crate) ping_delay: f64,
    pub(crate) click_delay: f64,
}

/// The two kinds of record differ in rate, delays and noise.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Ping,
    Click,
}

impl VirtualRig {
    /// The tube, and the runs in which its points are measured.
    #[must_use]
    pub fn tube(&self) -> &HeatedTube {
        &self.tube
    }

    /// The first mode that is really there at `point` (an index), at the day's temperature: growth rate and
    /// angular frequency, and pressure at the microphones relative to the reference microphone. For tests and
    /// studies.
    #[must_use]
    pub fn true_mode(&self, point: usize) -> (C64, Vec<C64>) {
        let mode = &self.points[point].modes[0];
        let reference = mode.residue[self.set.rig.microphones.reference];
        (mode.s, mode.residue.iter().map(|p| p / reference).collect())
    }

    /// The reflection coefficients R_u and R_d of the two open ends at the true s of `point` (an index): f/g
    /// at x = 0 and g/f at x = L, with rho c of the gas and the open area there. The walls of the tube carry
    /// [`crate::WallTruth::roughness`] times the boundary layers of a smooth wall.
    #[must_use]
    pub fn true_reflections(&self, point: usize) -> [C64; 2] {
        let PointTruth { duct, modes, .. } = &self.points[point];
        [&duct.bottom, &duct.top].map(|end| {
            let specific = end.impedance(modes[0].s) * end.open_area / end.gas.density / end.gas.sound_speed;
            (specific - 1.0) / (specific + 1.0)
        })
    }

    /// The temperature that is really there at `point` (an index), K; the manifest holds a thermometer's
    /// reading.
    #[must_use]
    pub fn true_temperature(&self, point: usize) -> f64 {
        self.points[point].temperature
    }

    /// Temperature and velocity along the tube that are really there at `point` (an index).
    #[must_use]
    pub fn true_base_state(&self, point: usize) -> &BaseState {
        &self.points[point].base
    }

    /// What is wrong with a ping, if anything.
    #[must_use]
    pub fn ping_fault(&self, point: usize, repeat: usize) -> Option<BadRecord> {
        let mut stream = self.stream("fault", &self.set.points[point].pings[repeat]);
        BadRecord::of_ping(self.truth.faults.pings, self.channels.len(), &mut stream)
    }

    /// What is wrong with a click, if anything.
    #[must_use]
    pub fn click_fault(&self, point: usize, repeat: usize) -> Option<BadRecord> {
        let mut stream = self.stream("fault", &self.set.points[point].clicks[repeat]);
        BadRecord::of_click(self.truth.faults.clicks, self.channels.len(), &mut stream)
    }

    /// The samples of a ping as the converter delivers them.
    #[must_use]
    pub fn ping_samples(&self, point: usize, repeat: usize) -> Samples24 {
        interleave(self.set.ping, &self.ping_steps(point, repeat))
    }

    /// Each channel of a ping in steps of the converter.
    fn ping_steps(&self, point: usize, repeat: usize) -> Vec<Vec<i32>> {
        let name = &self.set.points[point].pings[repeat];
        let (truth, recorder) = (&self.points[point], &self.truth.recorder);
        let mut stream = self.stream("event", name);
        let dt = 1.0 / self.set.ping.rate_hz;
        let length = (recorder.ping_s * self.set.ping.rate_hz).round() as usize;
        let speaker = &self.truth.loudspeaker;
        let stop = Stop {
            time: recorder.ping_quiet_s + recorder.ping_forced_s + speaker.stop_sd_s * normal(&mut stream),
            angle: stream.random_range(-PI..PI),
            amplitude: 1.0 + speaker.amplitude_sd * normal(&mut stream),
            warmth: self.warmth(truth.temperature, &mut stream),
        };
        let fault = self.ping_fault(point, repeat);
        let delays: Vec<f64> = self.channels.iter().map(|c| c.ping_delay).collect();
        let mut channels = vec![vec![0.0; length]; self.channels.len()];
        truth.ping.add(&mut channels, self.set.ping.quiet, dt, &delays, stop);
        if let Some(BadRecord::DoubleTrigger(after)) = fault {
            // Forcing again is forcing without an end, less the ring-down that its missing past would have
            // left.
            let again = ((stop.time + after) / dt) as usize;
            let endless = Stop { time: 1e3, ..stop };
            truth.ping.add(&mut channels, again.min(length), dt, &delays, endless);
        }
        self.digitise(channels, Kind::Ping, self.set.ping.rate_hz, stop.time, name, fault)
    }

    /// The samples of a click as the converter delivers them.
    #[must_use]
    pub fn click_samples(&self, point: usize, repeat: usize) -> Samples24 {
        interleave(self.set.click, &self.click_steps(point, repeat))
    }

    fn click_steps(&self, point: usize, repeat: usize) -> Vec<Vec<i32>> {
        let (name, truth) = (&self.set.points[point].clicks[repeat], &self.points[point]);
        let click = self.click_of((false, point), &truth.duct, self.set.click, Kind::Click);
        let fault = self.click_fault(point, repeat);
        self.click_record(&click, truth.temperature, self.set.click, Kind::Click, name, fault)
    }

    /// The samples of a calibration click as the converter delivers them.
    #[must_use]
    pub fn calibration_samples(&self, which: usize, repeat: usize) -> Samples24 {
        interleave(self.set.calibrations[which].stretch, &self.calibration_steps(which, repeat))
    }

    fn calibration_steps(&self, which: usize, repeat: usize) -> Vec<Vec<i32>> {
        let (entry, truth) = (&self.set.calibrations[which], &self.calibrations[which]);
        let kind = if entry.stretch.rate_hz == self.set.ping.rate_hz { Kind::Ping } else { Kind::Click };
        let click = self.click_of((true, which), &truth.duct, entry.stretch, kind);
        self.click_record(&click, truth.temperature, entry.stretch, kind, &entry.clicks[repeat], None)
    }

    /// What is heard of the clicks in `duct`: those of a calibration (true) or of an operating point, by
    /// number.
    fn click_of(
        &self,
        which: (bool, usize),
        duct: &FineTube,
        stretch: RecordTiming,
        kind: Kind,
    ) -> Arc<Click> {
        let speaker = &self.truth.loudspeaker;
        let delays: Vec<f64> = self.channels.iter().map(|c| c.delay(kind)).collect();
        let pulse = Pulse {
            peak: speaker.click_pa,
            frequency: speaker.click_hz,
            time: stretch.quiet as f64 / stretch.rate_hz + speaker.latency_s,
            rate_hz: stretch.rate_hz,
            length: (self.truth.recorder.click_s * stretch.rate_hz).round() as usize,
        };
        self.clicks.get(which, || Click::new(duct, pulse, &delays))
    }

    fn click_record(
        &self,
        click: &Click,
        temperature: f64,
        stretch: RecordTiming,
        kind: Kind,
        name: &str,
        fault: Option<BadRecord>,
    ) -> Vec<Vec<i32>> {
        let mut stream = self.stream("event", name);
        let amplitude = 1.0 + self.truth.loudspeaker.amplitude_sd * normal(&mut stream);
        let warmth = self.warmth(temperature, &mut stream);
        let channels = (0..self.channels.len()).map(|m| click.channel(m, amplitude, warmth)).collect();
        let event = stretch.quiet as f64 / stretch.rate_hz;
        self.digitise(channels, kind, stretch.rate_hz, event, name, fault)
    }

    /// Relative change of the speed of sound from record to record.
    pub(crate) fn warmth(&self, temperature: f64, stream: &mut Stream) -> f64 {
        0.5 * self.truth.ambient.record_sd_k / temperature * normal(stream)
    }

    /// Gains, noise, hum, what is wrong, and the converter.
    pub(crate) fn digitise(
        &self,
        mut channels: Vec<Vec<f64>>,
        kind: Kind,
        rate_hz: f64,
        event: f64,
        name: &str,
        fault: Option<BadRecord>,
    ) -> Vec<Vec<i32>> {
        let hum = Hum::new(&self.truth.noise, rate_hz, &mut self.stream("hum", name));
        let colour = &self.colour[usize::from(kind == Kind::Click)];
        // All channels hear the same hum.
        let mut heard = vec![0.0; channels.first().map_or(0, Vec::len)];
        hum.add(&mut heard, 0, 1.0);
        for (m, samples) in channels.iter_mut().enumerate() {
            colour.add(samples, &mut self.stream(&format!("noise-{m}"), name));
            let gain = self.channels[m].gain;
            samples.iter_mut().zip(&heard).for_each(|(p, hum)| *p = (*p + hum) * gain);
        }
        let full_scale = self.set.full_scale;
        if let Some(fault) = fault {
            fault.apply(&mut channels, 1.0 / rate_hz, event, full_scale, &hum);
        }
        let convert =
            |channel: &Vec<f64>| channel.iter().map(|p| Samples24::quantise(p / full_scale)).collect();
        channels.iter().map(convert).collect()
    }

    /// The record that reading the file of these steps would give, bit for bit.
    fn record(&self, stretch: RecordTiming, steps: &[Vec<i32>]) -> Record {
        let unit = Samples24::unit(self.set.full_scale);
        let pressures = |steps: &Vec<i32>| steps.iter().map(|n| f64::from(*n) * unit).collect();
        let RecordTiming { rate_hz, quiet } = stretch;
        let channels = steps.iter().map(pressures).collect();
        Record { rate_hz, quiet, full_scale: self.set.full_scale, channels }
    }

    /// The random stream of one purpose and one record.
    pub(crate) fn stream(&self, purpose: &str, record: &str) -> Stream {
        self.streams.stream(&format!("lab/{purpose}/{record}"))
    }
}

/// The channels as a file holds them.
pub(crate) fn interleave(stretch: RecordTiming, steps: &[Vec<i32>]) -> Samples24 {
    let length = steps.first().map_or(0, Vec::len);
    let interleaved = (0..length).flat_map(|n| steps.iter().map(move |channel| channel[n])).collect();
    Samples24 { rate_hz: stretch.rate_hz as u32, interleaved }
}

impl RecordSource for VirtualRig {
    fn set(&self) -> &RecordSet {
        &self.set
    }

    fn ping(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        Ok(self.record(self.set.ping, &self.ping_steps(point, repeat)))
    }

    fn click(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        Ok(self.record(self.set.click, &self.click_steps(point, repeat)))
    }

    fn calibration(&self, which: usize, repeat: usize) -> Result<Record, RigError> {
        let stretch = self.set.calibrations[which].stretch;
        Ok(self.record(stretch, &self.calibration_steps(which, repeat)))
    }
}

impl Channel {
    fn delay(&self, kind: Kind) -> f64 {
        match kind {
            Kind::Ping => self.ping_delay,
            Kind::Click => self.click_delay,
        }
    }
}

pub(crate) fn normal(stream: &mut Stream) -> f64 {
    stream.sample(StandardNormal)
}
