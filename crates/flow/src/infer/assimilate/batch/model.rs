//! A whole record as one vector of averaged readings: what the model predicts of it, and its noise made
//! white.

use super::whitening::Whitening;
use crate::error::FlowError;
use crate::infer::assimilate::ambient::smooth_ambient;
use crate::infer::assimilate::record::{FlowRecord, observe};
use crate::infer::scores::unknowns_from;
use crate::number::{Dual, Number};
use crate::tube::draught::Balanced;
use crate::tube::parameters::{UNKNOWNS, Unknowns, unknowns};
use crate::tube::pipe::Pipe;
use crate::tube::transient::{TIGHT, Transient};
use rijke_inference::Parameter;

/// A record with a pipe, ready to be fitted.
///
/// Readings are averaged over `bin` samples, and so are the predictions: averaging the data but predicting
/// one instant would spoil the transients. The unknowns are the ten of [`unknowns`] and one constant error
/// per biased sensor.
#[derive(Clone, Debug)]
pub struct Batch<'a> {
    pub(crate) pipe: &'a Pipe,
    pub(crate) record: &'a FlowRecord,
    pub(crate) priors: [Parameter; UNKNOWNS],
    pub(crate) ambient: Vec<f64>,
    pub(crate) bin: usize,
    /// Samples per step of the model: 1, or more for a rough prediction.
    pub(crate) stride: usize,
    /// Mean reading of every sensor in every bin, one bin after the other.
    pub(crate) means: Vec<f64>,
    pub(crate) whitening: Whitening,
}

impl<'a> Batch<'a> {
    /// Averages over `bin` samples (10 is a good choice); `record` must have been [`FlowRecord::checked`].
    ///
    /// # Errors
    /// Those of the model at the middle of the priors, where its response to the ambient temperature is
    /// taken.
    pub fn new(pipe: &'a Pipe, record: &'a FlowRecord, bin: usize) -> Result<Self, FlowError> {
        let bin = bin.max(1);
        let smoothed = smooth_ambient(record);
        let (mut means, mut sd) = (Vec::new(), Vec::new());
        for samples in record.samples.chunks(bin) {
            let size = samples.len() as f64;
            means.extend(
                (0..record.sensors.len()).map(|j| samples.iter().map(|s| s.readings[j]).sum::<f64>() / size),
            );
            sd.extend(record.sensors.iter().map(|s| s.sd / size.sqrt()));
        }
        let (priors, ambient) = (unknowns(), smoothed.temperature.clone());
        let whitening = Whitening::new(sd.clone(), &[], &smoothed, bin)?;
        let batch = Self { pipe, record, priors, ambient, bin, stride: 1, means, whitening };
        let whitening = Whitening::new(sd, &batch.rough().responses(&[0.0; UNKNOWNS])?, &smoothed, bin)?;
        Ok(Self { whitening, ..batch })
    }

    /// Number of scores: unknowns, then constant errors.
    #[must_use]
    pub fn scores(&self) -> usize {
        UNKNOWNS + self.record.biased().count()
    }

    /// Names of the scores.
    pub(crate) fn names(&self) -> Vec<String> {
        let unknowns = self.priors.iter().map(|p| p.name.clone());
        unknowns.chain(self.record.biased().map(|(i, _)| format!("bias_{i}"))).collect()
    }

    /// Mean predicted reading of every sensor in every bin, one bin after the other. Missing scores count as
    /// zero.
    pub(crate) fn run<N: Balanced>(&self, scores: &[N]) -> Result<Vec<N>, FlowError> {
        let unknowns = unknowns_from(&self.priors, scores)?;
        let record = self.record;
        let implicit = self.pipe.implicit(record.interval * self.stride as f64);
        let mut state = Transient::cold(self.pipe, &unknowns, self.ambient[0])?;
        let (mut times, mut seen) = (Vec::new(), Vec::new());
        let mut out = Vec::with_capacity(self.means.len());
        let indexed: Vec<_> = record.samples.iter().zip(&self.ambient).collect();
        for samples in indexed.chunks(self.bin) {
            let mut sums = vec![N::constant(0.0); record.sensors.len()];
            let steps = samples.chunks(self.stride);
            let share = 1.0 / steps.len() as f64;
            for (sample, ambient) in steps.filter_map(|step| step.last()) {
                state.step(self.pipe, &implicit, &unknowns, sample.power, **ambient, TIGHT)?;
                observe(self.pipe, &record.sensors, &state.gas, &unknowns, &mut times, &mut seen);
                sums.iter_mut().zip(&seen).for_each(|(sum, &s)| *sum = *sum + s * share);
            }
            for ((bias, sd), &score) in record.biased().zip(&scores[UNKNOWNS.min(scores.len())..]) {
                sums[bias] = sums[bias] + score * sd;
            }
            out.append(&mut sums);
        }
        Ok(out)
    }

    /// The same with steps of five samples: errors of some us in the transients, a fifth of the cost. For
    /// derivatives of derivatives and to start a search.
    pub(crate) fn rough(&self) -> Self {
        Self { stride: self.bin.min(5), ..self.clone() }
    }

    /// Changes of the mean readings per kelvin of ambient temperature, first at the start (which the wall
    /// takes up), then in each bin, by forward mode. Runs start where their first change does.
    fn responses(&self, scores: &[f64]) -> Result<Vec<Vec<f64>>, FlowError> {
        const P: usize = UNKNOWNS + 1;
        let record = self.record;
        let (plain, dual) = (
            unknowns_from(&self.priors, scores)?,
            unknowns_from::<Dual<P>>(
                &self.priors,
                &scores.iter().map(|&z| Dual::constant(z)).collect::<Vec<_>>(),
            )?,
        );
        let implicit = self.pipe.implicit(record.interval * self.stride as f64);
        let indexed: Vec<_> = record.samples.iter().zip(&self.ambient).collect();
        let bins: Vec<_> = indexed.chunks(self.bin).collect();
        let sensors = record.sensors.len();
        let mut columns = vec![vec![0.0; self.means.len()]; bins.len() + 1];
        let mut state = Transient::cold(self.pipe, &plain, self.ambient[0])?;
        let (mut times, mut seen) = (Vec::new(), Vec::new());
        for first in (0..columns.len()).step_by(P) {
            // Column 0 is the start, column k the bin k - 1.
            let from = first.saturating_sub(1);
            let offset = |column: usize| {
                let seeded = (first..first + P).contains(&column);
                if seeded {
                    Dual::variable(plain.ambient_offset, column - first)
                } else {
                    dual.ambient_offset
                }
            };
            let at = |column: usize| Unknowns { ambient_offset: offset(column), ..dual };
            let mut moved =
                Transient::cold(self.pipe, &if first == 0 { at(0) } else { dual }, self.ambient[0])?;
            if first > 0 {
                moved.wall = state.wall.iter().map(|w| Dual::constant(*w)).collect();
                moved.released = Dual::constant(state.released);
                moved.ambient = Dual::constant(state.ambient);
                moved.refresh(self.pipe, &dual, TIGHT)?;
            }
            for (k, samples) in bins.iter().enumerate().skip(from) {
                let steps = samples.chunks(self.stride);
                let share = 1.0 / steps.len() as f64;
                for (sample, ambient) in steps.filter_map(|step| step.last()) {
                    let unknowns = at(k + 1);
                    moved.step(self.pipe, &implicit, &unknowns, sample.power, **ambient, TIGHT)?;
                    observe(self.pipe, &record.sensors, &moved.gas, &unknowns, &mut times, &mut seen);
                    for (j, reading) in seen.iter().enumerate() {
                        for (column, slope) in columns[first..].iter_mut().zip(reading.slopes) {
                            column[k * sensors + j] += slope * share;
                        }
                    }
                }
            }
            // On to where the next group starts.
            let next = (first + P).saturating_sub(1).min(bins.len());
            for samples in &bins[from..next] {
                for (sample, ambient) in samples.chunks(self.stride).filter_map(|step| step.last()) {
                    state.step(self.pipe, &implicit, &plain, sample.power, **ambient, TIGHT)?;
                }
            }
        }
        Ok(columns)
    }

    pub(crate) fn whitened(&self, scores: &[f64]) -> Result<Vec<f64>, FlowError> {
        Ok(self.whitening.apply(self.run(scores)?))
    }

    /// Whitened readings, and their derivatives in the scores of the unknowns.
    pub(crate) fn slopes(&self, scores: &[f64]) -> Result<(Vec<f64>, Vec<Vec<f64>>), FlowError> {
        let seed = |(k, &z): (usize, &f64)| {
            if k < UNKNOWNS { Dual::<UNKNOWNS>::variable(z, k) } else { Dual::constant(z) }
        };
        let seeds: Vec<Dual<UNKNOWNS>> = scores.iter().enumerate().map(seed).collect();
        let predicted = self.run(&seeds)?;
        let column = |k: usize| self.whitening.apply(predicted.iter().map(|p| p.slopes[k]).collect());
        let values = self.whitening.apply(predicted.iter().map(|p| p.value).collect());
        Ok((values, (0..UNKNOWNS).map(column).collect()))
    }

    /// Whitened readings per score of the constant error `sd` of `sensor`.
    pub(crate) fn by_error(&self, (sensor, sd): (usize, f64)) -> Vec<f64> {
        let sensors = self.record.sensors.len();
        let reading = |k: usize| if k % sensors == sensor { sd } else { 0.0 };
        self.whitening.apply((0..self.means.len()).map(reading).collect())
    }
}
