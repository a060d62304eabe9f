//! Delays that frequencies at equal steps cannot tell from others.

use super::predict::Responses;
use crate::EngineError;
use rijke_inference::{Alias, InferenceError, Parameters};
use rijke_numerics::{C64, Jet, Order};
use std::collections::BTreeSet;

/// Answers that differ by less than this share are the same to a search.
const SAME: f64 = 0.2;
/// The prior is taken to reach from this quantile to its mirror: three standard deviations.
const REACH: f64 = 0.001_35;
/// Most starts of a search over one period.
const MOST: f64 = 24.0;
/// Most steps of frequency after which phases of all frequencies agree again.
const TURNS: usize = 4;

/// A delay of which the prior admits several values with the same answers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Aliased {
    /// Its parameter.
    name: String,
    /// Between values with the same answers, s.
    period: f64,
    /// Between frequencies, Hz.
    step_hz: f64,
    /// The least and the largest value that its prior admits, s.
    reach: [f64; 2],
    /// Points from which a search finds all maxima of one period.
    pub(super) starts: Vec<Vec<f64>>,
}

/// The parameters in seconds that may grow by the period of the steps of frequency, or by a few of them, and
/// change no answer, where the prior reaches over such a period; none of those in `told`, whose prior is
/// another one.
///
/// # Errors
/// Those of the model.
pub(super) fn aliased(
    responses: &Responses<'_>,
    parameters: &Parameters,
    told: &BTreeSet<&str>,
) -> Result<Vec<Aliased>, EngineError> {
    let steps = responses.loads.iter().flat_map(|load| load.frequency_hz.windows(2).map(|f| f[1] - f[0]));
    let mut steps: Vec<f64> = steps.collect();
    steps.sort_by(f64::total_cmp);
    let Some(step_hz) = steps.get(steps.len() / 2).copied().filter(|step| *step > 0.0) else {
        return Ok(Vec::new());
    };
    let list = parameters.list();
    let middle: Vec<f64> = list.iter().map(|p| p.prior.quantile(0.5)).collect();
    if middle.iter().any(|v| !v.is_finite()) {
        return Ok(Vec::new());
    }
    let answers = |values: &[f64]| -> Result<Vec<C64>, EngineError> {
        let answers = responses.answers(values, Order::Value)?;
        Ok(answers.iter().flatten().map(Jet::value).collect())
    };
    let mut found = Vec::new();
    for (i, p) in list.iter().enumerate().take(responses.own) {
        let reach = [REACH, 1.0 - REACH].map(|q| p.prior.quantile(q));
        let wide = reach[1] - reach[0];
        if p.unit != "s" || told.contains(p.name.as_str()) || !(wide.is_finite() && wide * step_hz > 1.0) {
            continue;
        }
        let moved = |by: f64| {
            let mut values = middle.clone();
            values[i] += by;
            answers(&values)
        };
        let here = moved(0.0)?;
        let size = |z: &mut dyn Iterator<Item = C64>| z.map(|z| z.norm_sqr()).sum::<f64>().sqrt();
        let all = size(&mut here.iter().copied());
        let differ = |by: f64| -> Result<f64, EngineError> {
            let there = moved(by)?;
            Ok(size(&mut here.iter().zip(there).map(|(a, b)| b - a)) / all)
        };
        for turns in 1..=TURNS {
            let period = turns as f64 / step_hz;
            // A third of a period is told, if the parameter is a delay at all.
            if period < wide && differ(period)? < SAME && differ(period / 3.0)? > 2.0 * SAME {
                let name = p.name.clone();
                let starts = starts(&middle, i, (period, reach), responses);
                found.push(Aliased { name, period, step_hz, reach, starts });
                break;
            }
        }
    }
    Ok(found)
}

/// Values of parameter `i` over one period about the middle of its prior, so near that a search from the
/// nearest ends at the maximum: about half of 1/B apart, where B is the width of the band (Hz).
fn starts(middle: &[f64], i: usize, (period, reach): (f64, [f64; 2]), of: &Responses<'_>) -> Vec<Vec<f64>> {
    let ends = of.loads.iter().filter_map(|l| Some(l.frequency_hz.last()? - l.frequency_hz.first()?));
    let width = ends.fold(0.0, f64::max);
    let count = (2.0 * period * width).ceil().clamp(4.0, MOST) as usize;
    let low = (middle[i] - 0.5 * period).max(reach[0]);
    let at = |k: usize| {
        let mut start = middle.to_vec();
        start[i] = low + period * k as f64 / count as f64;
        start
    };
    (0..count).map(at).filter(|start| start[i] <= reach[1]).collect()
}

/// The parameters, with what repeats itself.
///
/// # Errors
/// None for parameters of which these are.
pub(super) fn with_aliases(parameters: Parameters, all: &[Aliased]) -> Result<Parameters, InferenceError> {
    all.iter().try_fold(parameters, |p, a| p.with_alias(Alias::period(a.name.clone(), a.period)))
}

impl std::fmt::Display for Aliased {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, period, step_hz, reach: [low, high], .. } = self;
        write!(
            f,
            "frequencies {step_hz:.4} Hz apart cannot distinguish {name} from a delay that is {:.2} ms longer or shorter, and its prior allows both \
             ({:.2} to {:.2} ms): give finer frequencies, or a narrower prior",
            1e3 * period,
            1e3 * low,
            1e3 * high
        )
    }
}
