//! Nested sampling (Skilling 2006): evidence without Laplace's approximation, as a sampler.

use super::sampler::{Integrated, Sampler, Target};
use crate::density::Calls;
use crate::error::InferenceError;
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_numerics::{Stream, Streams};

/// Static nested sampling with slice moves.
///
/// `live` points hold the prior above a rising likelihood threshold; each step replaces the worst. A new
/// point comes from a random other one by `moves` slice steps along random directions of the live points'
/// covariance (Neal 2003; Handley, Hobson & Lasenby 2015). Ends when the live points can add less than
/// `tolerance` nats.
///
/// Cost: about `live` (H + 3) times `moves` times 5 likelihoods, H the information in nats. The statistical
/// error of the logarithm of the evidence is about sqrt(H / live).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nested {
    /// Number of live points.
    pub live: usize,
    /// Slice steps per new point; three to five times the number of parameters.
    pub moves: usize,
    /// Remaining evidence, nats, at which to end.
    pub tolerance: f64,
    /// Likelihood evaluations after which to give up.
    pub max_evaluations: usize,
    /// Random streams.
    pub streams: Streams,
}

impl Nested {
    /// Settings for a statistical error of about `error` nats when the data carry `information` nats. An
    /// error that is not positive is one of [`Sampler::integrate`].
    #[must_use]
    pub fn with_error(error: f64, information: f64, parameters: usize, streams: Streams) -> Self {
        let live = (information.max(1.0) / (error * error)).ceil() as usize;
        Self {
            live: live.max(25),
            moves: 4 * parameters.max(1),
            tolerance: 0.1 * error,
            max_evaluations: 200_000_000,
            streams,
        }
    }
}

/// Most live points: more of them fill no memory with use.
const MOST_LIVE: usize = 10_000_000;

/// Of so many draws from the prior the model must have an answer at one.
const MOST_DRAWN: usize = 10_000;

struct Point {
    /// Standard normal coordinates of the prior.
    xi: Vec<f64>,
    ln_likelihood: f64,
}

impl Sampler for Nested {
    fn name(&self) -> &'static str {
        "nested sampling"
    }

    fn integrate(&self, target: &dyn Target) -> Result<Integrated, InferenceError> {
        let sound = self.tolerance > 0.0 && self.tolerance.is_finite();
        if !(2..=MOST_LIVE).contains(&self.live) || !sound {
            let problem = format!(
                "{} live points and a tolerance of {} nats; give 2 to {MOST_LIVE} points and a positive tolerance",
                self.live, self.tolerance
            );
            return Err(InferenceError::Sampler { sampler: "nested sampling", problem });
        }
        let mut stream = self.streams.stream("inference/nested");
        let mut calls = Calls::default();
        let Some(mut live) = self.drawn(target, &mut stream, &mut calls)? else {
            return Ok(Integrated { finished: false, calls, ..Integrated::default() });
        };
        // The share of the prior at which the model has an answer, which holds the evidence: points without
        // one are no plateau that could shrink step by step (Fowlie, Handley & Su 2021, MNRAS 503, 1199).
        let (kept, drawn) = (self.live as f64, calls.value as f64);
        let mut ln_mass = (kept / drawn).ln();
        let error_of_mass = (1.0 / kept - 1.0 / drawn).max(0.0);
        // The evidence, and the sum for the information.
        let shrink = 1.0 / self.live as f64;
        let (mut ln_evidence, mut information) = (f64::NEG_INFINITY, 0.0);
        let mut samples = Vec::new();
        let mut finished = true;
        let mut whole = directions(&live);
        for step in 0_usize.. {
            let worst = (0..self.live)
                .min_by(|&i, &j| live[i].ln_likelihood.total_cmp(&live[j].ln_likelihood))
                .unwrap_or(0);
            let best = live.iter().map(|p| p.ln_likelihood).fold(f64::NEG_INFINITY, f64::max);
            if ln_add(ln_evidence, best + ln_mass) - ln_evidence < self.tolerance {
                break;
            }
            if calls.value > self.max_evaluations {
                finished = false;
                break;
            }
            let threshold = live[worst].ln_likelihood;
            let ln_weight = threshold + ln_mass + (-(-shrink).exp_m1()).ln();
            accumulate(&mut ln_evidence, &mut information, ln_weight, threshold);
            samples.push((live[worst].xi.clone(), ln_weight));
            ln_mass -= shrink;
            if step % self.live == 0 {
                whole = directions(&live);
            }
            let mut parent = stream.random_range(0..self.live - 1);
            parent += usize::from(parent >= worst);
            let start = live[parent].xi.clone();
            live[worst] = self.moved(
                target,
                start,
                live[parent].ln_likelihood,
                threshold,
                &whole,
                &mut stream,
                &mut calls,
            )?;
        }
        for point in live {
            let ln_weight = point.ln_likelihood + ln_mass - (self.live as f64).ln();
            accumulate(&mut ln_evidence, &mut information, ln_weight, point.ln_likelihood);
            samples.push((point.xi, ln_weight));
        }
        let draws = resample(&samples, ln_evidence, self.live.max(1000), &mut stream);
        Ok(Integrated {
            ln_marginal: ln_evidence,
            standard_error: (information.max(0.0) / self.live as f64 + error_of_mass).sqrt(),
            information,
            draws: draws.iter().map(|xi| target.working(xi)).collect(),
            finished,
            calls,
        })
    }
}

impl Nested {
    /// Points drawn from the prior where the model has an answer; none where that takes too many evaluations.
    fn drawn(
        &self,
        target: &dyn Target,
        stream: &mut Stream,
        calls: &mut Calls,
    ) -> Result<Option<Vec<Point>>, InferenceError> {
        let mut live = Vec::with_capacity(self.live);
        while live.len() < self.live {
            let xi: Vec<f64> = (0..target.size()).map(|_| stream.sample(StandardNormal)).collect();
            let ln_likelihood = evaluate(target, &xi, calls)?;
            if ln_likelihood > f64::NEG_INFINITY {
                live.push(Point { xi, ln_likelihood });
            }
            if calls.value > self.max_evaluations {
                return Ok(None);
            }
            if calls.value >= MOST_DRAWN && live.len() < calls.value / MOST_DRAWN {
                let problem = format!(
                    "the model has no answer at {} of {} numbers drawn from its prior; narrow the prior",
                    calls.failed, calls.value
                );
                return Err(InferenceError::Sampler { sampler: "nested sampling", problem });
            }
        }
        Ok(Some(live))
    }

    /// A point drawn from the prior above `threshold`, by slice steps from `xi`.
    #[allow(clippy::too_many_arguments, reason = "the state of one walk, used in one place")]
    fn moved(
        &self,
        target: &dyn Target,
        mut xi: Vec<f64>,
        mut ln_likelihood: f64,
        threshold: f64,
        whole: &[Vec<f64>],
        stream: &mut Stream,
        calls: &mut Calls,
    ) -> Result<Point, InferenceError> {
        let n = xi.len();
        for _ in 0..self.moves {
            let noise: Vec<f64> = (0..n).map(|_| stream.sample(StandardNormal)).collect();
            let norm = noise.iter().map(|x| x * x).sum::<f64>().sqrt();
            let direction: Vec<f64> = (0..n)
                .map(|i| 3.0 * whole[i].iter().zip(&noise).map(|(w, x)| w * x).sum::<f64>() / norm)
                .collect();
            // The slice under the prior density as well as above the likelihood threshold.
            let height = square(&xi) - 2.0 * (1.0 - stream.random::<f64>()).ln();
            let at = |t: f64| -> Vec<f64> { xi.iter().zip(&direction).map(|(x, d)| x + t * d).collect() };
            let inside = |t: f64, calls: &mut Calls| -> Result<Option<(Vec<f64>, f64)>, InferenceError> {
                let there = at(t);
                if square(&there) > height {
                    return Ok(None);
                }
                let value = evaluate(target, &there, calls)?;
                Ok((value > threshold).then_some((there, value)))
            };
            let mut low = -stream.random::<f64>();
            let mut high = low + 1.0;
            while inside(low, calls)?.is_some() {
                low -= 1.0;
            }
            while inside(high, calls)?.is_some() {
                high += 1.0;
            }
            // Shrink towards the present point, which is inside; the cap only guards against rounding.
            let mut found = None;
            for _ in 0..200 {
                let t = low + (high - low) * stream.random::<f64>();
                found = inside(t, calls)?;
                if found.is_some() {
                    break;
                }
                if t < 0.0 { low = t } else { high = t }
            }
            if let Some((there, value)) = found {
                (xi, ln_likelihood) = (there, value);
            }
        }
        Ok(Point { xi, ln_likelihood })
    }
}

fn evaluate(target: &dyn Target, xi: &[f64], calls: &mut Calls) -> Result<f64, InferenceError> {
    calls.value += 1;
    match target.ln_likelihood(xi) {
        Ok(value) => Ok(value),
        Err(error) if error.is_recoverable() => {
            calls.failed += 1;
            Ok(f64::NEG_INFINITY)
        }
        Err(error) => Err(error),
    }
}

/// The Cholesky factor of the covariance of the live points, row by row; the identity while they are too few.
fn directions(live: &[Point]) -> Vec<Vec<f64>> {
    let n = live.first().map_or(0, |p| p.xi.len());
    let count = live.len() as f64;
    let mean: Vec<f64> = (0..n).map(|i| live.iter().map(|p| p.xi[i]).sum::<f64>() / count).collect();
    let covariance = rijke_numerics::Matrix::from_fn(n, n, |i, j| {
        live.iter().map(|p| (p.xi[i] - mean[i]) * (p.xi[j] - mean[j])).sum::<f64>() / count
    });
    let factor = rijke_numerics::Cholesky::new(&covariance)
        .map_or_else(|_| rijke_numerics::Matrix::identity(n), |f| f.lower().clone());
    (0..n).map(|i| factor.row(i).to_vec()).collect()
}

/// Adds a weight to the evidence, and keeps the information H = integral of posterior times ln(likelihood /
/// evidence).
fn accumulate(ln_evidence: &mut f64, information: &mut f64, ln_weight: f64, ln_likelihood: f64) {
    if ln_weight == f64::NEG_INFINITY {
        return;
    }
    let total = ln_add(*ln_evidence, ln_weight);
    let old = if *ln_evidence == f64::NEG_INFINITY {
        0.0
    } else {
        (*ln_evidence - total).exp() * (*information + *ln_evidence)
    };
    *information = (ln_weight - total).exp() * ln_likelihood + old - total;
    *ln_evidence = total;
}

/// Equally weighted draws by systematic resampling.
fn resample(
    samples: &[(Vec<f64>, f64)],
    ln_evidence: f64,
    count: usize,
    stream: &mut Stream,
) -> Vec<Vec<f64>> {
    let offset: f64 = stream.random();
    let (mut draws, mut sum) = (Vec::with_capacity(count), 0.0);
    for (xi, ln_weight) in samples {
        sum += (ln_weight - ln_evidence).exp();
        while draws.len() < count && (draws.len() as f64 + offset) / (count as f64) < sum {
            draws.push(xi.clone());
        }
    }
    draws
}

fn square(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum()
}

fn ln_add(a: f64, b: f64) -> f64 {
    let (high, low) = if a > b { (a, b) } else { (b, a) };
    if low == f64::NEG_INFINITY { high } else { high + (low - high).exp().ln_1p() }
}
