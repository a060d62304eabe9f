//! Twin experiments: records of the model itself, with truth drawn from the prior, for tests of calibration.

use super::batch::model::Batch;
use super::record::{FlowRecord, Sample, observe};
use crate::error::FlowError;
use crate::infer::scores::unknowns_from;
use crate::infer::sensor::{Sensor, SensorKind};
use crate::tube::parameters::{UNKNOWNS, unknowns};
use crate::tube::pipe::Pipe;
use crate::tube::transient::Transient;
use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::Streams;

/// What a twin experiment is like.
#[derive(Clone, Debug, PartialEq)]
pub struct TwinOptions {
    /// Power at every sample, W.
    pub powers: Vec<f64>,
    /// Time between samples, s.
    pub interval: f64,
    /// Noise of an arrival time, s.
    pub arrival_sd: f64,
    /// Constant error of a channel, s.
    pub delay_sd: f64,
    /// Noise of the ambient thermometer, K.
    pub ambient_sd: f64,
    /// Standing sd (K) and correlation time (s) of the ambient temperature, an Ornstein-Uhlenbeck process.
    pub ambient_wander: (f64, f64),
    /// Mean ambient temperature, K.
    pub ambient: f64,
    /// Noise of the power reading, relative.
    pub power_sd: f64,
}

impl Default for TwinOptions {
    /// The paper's staircase: 0, 7, 15, 30, 50, 80, 130, 180 W for 62.5 min each, a click every 15 s, 1 us
    /// noise.
    fn default() -> Self {
        Self {
            powers: staircase(&[0.0, 7.0, 15.0, 30.0, 50.0, 80.0, 130.0, 180.0], 250),
            interval: 15.0,
            arrival_sd: 1e-6,
            delay_sd: 1e-6,
            ambient_sd: 0.1,
            ambient_wander: (0.5, 10_800.0),
            ambient: 293.15,
            power_sd: 0.005,
        }
    }
}

/// `clicks` samples at each power in turn.
#[must_use]
pub fn staircase(powers: &[f64], clicks: usize) -> Vec<f64> {
    powers.iter().flat_map(|&p| std::iter::repeat_n(p, clicks)).collect()
}

/// A record with its truth.
#[derive(Clone, Debug)]
pub struct Twin {
    /// What the instruments say.
    pub record: FlowRecord,
    /// True scores: unknowns, then constant errors.
    pub scores: Vec<f64>,
    /// True ambient temperature at every sample, K, with the thermometer's constant error taken out.
    pub ambient: Vec<f64>,
}

impl Twin {
    /// Runs `pipe` with truth and noise from `streams`. `scores` replaces the truth drawn from the prior.
    ///
    /// # Errors
    /// Those of the model.
    pub fn new(
        pipe: &Pipe,
        options: &TwinOptions,
        streams: &Streams,
        scores: Option<&[f64]>,
    ) -> Result<Self, FlowError> {
        let mut stream = streams.stream("flow/twin");
        let mut normal = move || -> f64 { StandardNormal.sample(&mut stream) };
        let channels = pipe.microphones.len();
        let drawn: Vec<f64> = (0..UNKNOWNS + channels).map(|_| normal()).collect();
        let scores = scores.map_or(drawn, <[f64]>::to_vec);
        let u = unknowns_from(&unknowns(), &scores)?;
        let sensor = |microphone| Sensor {
            kind: SensorKind::Arrival { microphone },
            sd: options.arrival_sd,
            bias_sd: options.delay_sd,
        };
        let sensors: Vec<Sensor> = (0..channels).map(sensor).collect();
        let (sd, time) = options.ambient_wander;
        let keep = (-options.interval / time).exp();
        let mut wander = sd * normal();
        let mut state = Transient::cold(pipe, &u, options.ambient + wander)?;
        let mut path = Vec::with_capacity(options.powers.len());
        let implicit = pipe.implicit(options.interval);
        let (mut times, mut seen) = (Vec::new(), Vec::new());
        let mut samples = Vec::with_capacity(options.powers.len());
        let mut ambient = options.ambient + wander;
        for &power in &options.powers {
            path.push(ambient);
            state.step(pipe, &implicit, &u, power, ambient, 1e-10)?;
            observe(pipe, &sensors, &state.gas, &u, &mut times, &mut seen);
            let readings = seen
                .iter()
                .enumerate()
                .map(|(j, t)| t + scores[UNKNOWNS + j] * options.delay_sd + options.arrival_sd * normal());
            let readings = readings.collect();
            // The record holds the indicated ambient temperature at the sample, and the power as set.
            samples.push(Sample { power, ambient: ambient + options.ambient_sd * normal(), readings });
            wander = keep * wander + sd * (1.0 - keep * keep).sqrt() * normal();
            ambient = options.ambient + wander;
        }
        let record = FlowRecord {
            interval: options.interval,
            sensors,
            ambient_sd: options.ambient_sd,
            ambient_drift: sd * (2.0 / time).sqrt(),
            power_sd: options.power_sd,
            samples,
        };
        Ok(Self { record, scores, ambient: path })
    }
}

impl Batch<'_> {
    /// The same run with the same truth, seen by other sensors with fresh noise: for twins of instruments
    /// that are not clicks. `self` must have one sample per bin.
    ///
    /// # Errors
    /// Those of the model.
    pub fn resampled(
        &self,
        sensors: &[Sensor],
        scores: &[f64],
        streams: &Streams,
    ) -> Result<FlowRecord, FlowError> {
        let mut record = FlowRecord { sensors: sensors.to_vec(), ..self.record.clone() };
        let mut other = self.clone();
        other.record = &record;
        let seen = other.run(scores)?;
        let mut stream = streams.stream("flow/twin/resampled");
        let mut samples = record.samples.clone();
        for (sample, values) in samples.iter_mut().zip(seen.chunks(sensors.len())) {
            sample.readings = (values.iter().zip(sensors))
                .map(|(v, s)| {
                    let n: f64 = StandardNormal.sample(&mut stream);
                    v + s.sd * n
                })
                .collect();
        }
        record.samples = samples;
        Ok(record)
    }
}
