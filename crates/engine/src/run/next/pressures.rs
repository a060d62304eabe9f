//! What is known of the errors of microphones: the noise of a visit, and what the calibration of the channels
//! leaves, which all visits share.

use super::predictive::{Numbers, Shared};
use crate::errors::ChannelsOfModes;
use crate::{EngineError, NamedGaussian, Observed};
use rijke_inference::relative_noise;
use rijke_numerics::{C64, Cholesky, Matrix};
use rijke_rig::{ChannelErrors, ModeRows};
use rijke_study::Study;
use rijke_study::plan::Stage;
use std::collections::BTreeMap;

/// Errors of relative pressures P.
pub(super) struct Listening {
    /// Measured variance of each part of the pressure of each microphone, relative to the reference's.
    own: Vec<f64>,
    /// The variance of the reference microphone, which all relative pressures have times P.
    reference: f64,
    /// Delay and gain of every microphone but the reference, where they are stated.
    channels: BTreeMap<usize, [Calibrated; 2]>,
}

/// The error of a delay or of a gain.
#[derive(Clone, Default)]
struct Calibrated {
    /// Place in what is known, and how the error goes with it.
    along: Vec<(usize, f64)>,
    /// What does not, per standard deviation of a cause.
    shared: Vec<(Shared, f64)>,
}

impl Listening {
    /// From what `trained` a model, and what that training knows; `measured` if the measured errors count
    /// beside the misfit. A microphone that was never heard has the errors of the others.
    pub(super) fn of(
        study: &Study,
        stage: &Stage,
        errors: Option<&ChannelErrors>,
        trained: &[Observed],
        known: &NamedGaussian,
        measured: bool,
    ) -> Result<Self, EngineError> {
        let instruments = &study.rig.microphones;
        let used = |m: &usize| stage.hears(&instruments.names[*m]);
        let stated = errors.map_or(0, |e| e.delays.rows() + 1);
        let channels = ChannelsOfModes::of(&study.rig, errors, &(0..stated).filter(used).collect::<Vec<_>>());
        let mut found =
            Self { own: vec![0.0; instruments.at.len()], reference: 0.0, channels: BTreeMap::new() };
        if let (Some(errors), Some(channels)) = (errors, &channels) {
            found.channels = calibrated(study, stage, errors, channels, known)?;
        }
        if measured {
            found.listen(trained, instruments.reference, channels.as_ref());
        }
        Ok(found)
    }

    /// Takes measured covariances apart into what each microphone has of its own and what it has of the
    /// reference, by least squares of what different microphones have together; the share of the channels is
    /// no noise.
    fn listen(&mut self, trained: &[Observed], reference: usize, channels: Option<&ChannelsOfModes>) {
        let all: Vec<usize> = (0..self.own.len()).collect();
        let [mut together, mut squares] = [0.0; 2];
        let mut sums = vec![[0.0; 3]; all.len()];
        for o in trained {
            let mut used = o.used(&all, reference);
            if let Some(channels) = channels {
                channels.take_from(o, &mut used);
            }
            let c = used.covariance.select(&used.of_the_pressures());
            let part = |i: usize, j: usize| {
                let re = c[(2 * i, 2 * j)] + c[(2 * i + 1, 2 * j + 1)];
                0.5 * C64::new(re, c[(2 * i + 1, 2 * j)] - c[(2 * i, 2 * j + 1)])
            };
            for (i, (m, p)) in used.others.iter().zip(&used.pressures).enumerate() {
                for (j, q) in used.pressures[..i].iter().enumerate() {
                    together += (part(i, j) * (p * q.conj()).conj()).re;
                    squares += (p * q.conj()).norm_sqr();
                }
                let [count, variance, square] = &mut sums[*m];
                (*count, *variance, *square) =
                    (*count + 1.0, *variance + part(i, i).re, *square + p.norm_sqr());
            }
        }
        self.reference = if squares > 0.0 { (together / squares).max(0.0) } else { 0.0 };
        let own = |[n, v, s]: &[f64; 3]| (*n > 0.0).then(|| ((v - self.reference * s) / n).max(0.0));
        let own: Vec<Option<f64>> = sums.iter().map(own).collect();
        let heard: Vec<f64> = own.iter().copied().flatten().collect();
        let usual = heard.iter().sum::<f64>() / heard.len().max(1) as f64;
        self.own = own.into_iter().map(|v| v.unwrap_or(usual)).collect();
    }

    /// Measured variance of each part of a relative pressure, in the mean over the microphones.
    pub(super) fn usual(&self) -> f64 {
        self.own.iter().sum::<f64>() / self.own.len().max(1) as f64 + self.reference
    }

    /// The covariance of the noise of one visit; zero but for the pressures. `misfit` is the variance of the
    /// model's at each microphone, of which `reference` is that to which pressures are relative.
    pub(super) fn noise(
        &self,
        numbers: &Numbers,
        reference: usize,
        others: &[usize],
        misfit: &dyn Fn(usize) -> f64,
    ) -> Matrix {
        let common = if others.is_empty() { 0.0 } else { misfit(reference) + self.reference };
        let own: Vec<f64> = others.iter().map(|&m| misfit(m) + self.own[m]).collect();
        let relative = relative_noise(&numbers.pressures());
        let size = numbers.values.len();
        Matrix::from_fn(size, size, |i, j| {
            let (Some(a), Some(b)) = (i.checked_sub(2), j.checked_sub(2)) else { return 0.0 };
            let diagonal = f64::from(u8::from(a == b));
            common * (relative[(a, b)] - diagonal) + own[a / 2] * diagonal
        })
    }

    /// Adds the errors of delays and gains: P (1 - s d + g) is measured.
    pub(super) fn add_channels(&self, numbers: &mut Numbers, others: &[usize]) {
        let s = C64::new(numbers.values[0], numbers.values[1]);
        let size = numbers.values.len();
        for (i, (m, p)) in others.iter().zip(numbers.pressures()).enumerate() {
            let Some(errors) = self.channels.get(m) else { continue };
            for (slope, error) in [-p * s, p].into_iter().zip(errors) {
                let add = |to: &mut Vec<f64>, factor: f64| {
                    to[ModeRows::pressure(i)] += slope.re * factor;
                    to[ModeRows::pressure(i) + 1] += slope.im * factor;
                };
                for (cause, factor) in &error.shared {
                    let to = numbers.shared.entry(cause.clone()).or_insert_with(|| vec![0.0; size]);
                    add(to, *factor);
                }
                for (place, factor) in &error.along {
                    match numbers.along.iter_mut().find(|(at, _)| at == place) {
                        Some((_, to)) => add(to, *factor),
                        None => {
                            let mut to = vec![0.0; size];
                            add(&mut to, *factor);
                            numbers.along.push((*place, to));
                        }
                    }
                }
            }
        }
    }
}

/// Delays and gains given what is known of everything else, so that what a visit tells of them is no
/// information about the model.
fn calibrated(
    study: &Study,
    stage: &Stage,
    errors: &ChannelErrors,
    channels: &ChannelsOfModes,
    known: &NamedGaussian,
) -> Result<BTreeMap<usize, [Calibrated; 2]>, EngineError> {
    let n = channels.microphones.len();
    let place = |name: &str| known.names.iter().position(|other| other == name);
    let places: Option<Vec<usize>> = channels.parameters.iter().map(|p| place(&p.name)).collect();
    let earlier = || stage.on.iter().chain(&stage.heard_through);
    let mut others = Vec::new();
    let mut regression = Matrix::zeros(2 * n, 0);
    let root = if let Some(places) = places {
        // Found with the model: the part of them that goes with its parameters, and the rest.
        others = (0..known.names.len()).filter(|k| !places.contains(k)).collect();
        let sigma = &known.covariance;
        let factor = Cholesky::new(&sigma.select(&others))?;
        let row = |p: &usize| factor.solve(&others.iter().map(|o| sigma[(*o, *p)]).collect::<Vec<_>>());
        let rows: Vec<Vec<f64>> = places.iter().map(row).collect();
        regression = Matrix::from_fn(2 * n, others.len(), |i, j| rows[i][j]);
        let told = Matrix::from_fn(others.len(), 2 * n, |i, j| sigma[(others[i], places[j])]);
        Cholesky::new(&sigma.select(&places).plus(-1.0, &regression.product(&told)))?.lower().clone()
    } else if earlier().any(|id| study.plan.stage(id).is_some_and(|(_, s)| s.channels)) {
        // Found by an earlier stage, and taken for known since.
        Matrix::zeros(2 * n, 2 * n)
    } else {
        Cholesky::new(&channels.covariance)?.lower().clone()
    };
    let in_use = |i: usize| Calibrated {
        along: others.iter().copied().zip(regression.row(i).iter().copied()).collect(),
        shared: (0..=i).map(|c| (Shared::Calibration(c), root[(i, c)])).collect(),
    };
    let in_use: Vec<Calibrated> = (0..2 * n).map(in_use).collect();
    let instruments = &study.rig.microphones;
    let row = |m: usize| m - usize::from(m > instruments.reference);
    // A microphone not in use: what its errors have in common with those in use by what is stated, and the
    // rest.
    let further = |m: usize, k: usize| -> Result<Calibrated, EngineError> {
        let stated = [&errors.delays, &errors.gains][k];
        let rows: Vec<usize> = channels.microphones.iter().map(|c| row(*c)).collect();
        let block = stated.select(&rows);
        let (variance, with) = if row(m) < stated.rows() {
            (stated[(row(m), row(m))], rows.iter().map(|r| stated[(row(m), *r)]).collect())
        } else {
            let own = (0..n).map(|i| block[(i, i)]).sum::<f64>();
            let all = block.as_slice().iter().sum::<f64>();
            (own / n as f64, vec![(all - own) / (n * n - n).max(1) as f64; n])
        };
        let weights = Cholesky::new(&block)?.solve(&with);
        let rest = variance - weights.iter().zip(&with).map(|(w, c)| w * c).sum::<f64>();
        let mut sum = Calibrated::default();
        for (weight, error) in weights.iter().zip(&in_use[k * n..]) {
            sum.along.extend(error.along.iter().map(|(place, factor)| (*place, weight * factor)));
            sum.shared.extend(error.shared.iter().map(|(cause, factor)| (cause.clone(), weight * factor)));
        }
        sum.shared.push((Shared::Microphone(m, k), rest.max(0.0).sqrt()));
        Ok(sum)
    };
    let of = |m: usize| {
        let there = channels.microphones.iter().position(|c| *c == m);
        let one = |k: usize| there.map_or_else(|| further(m, k), |i| Ok(in_use[k * n + i].clone()));
        Ok((m, [one(0)?, one(1)?]))
    };
    (0..instruments.at.len()).filter(|m| *m != instruments.reference).map(of).collect()
}
