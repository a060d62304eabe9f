//! Fig. 3: what can one microphone say of the ends and the wall, and what can eight?

use crate::catalogue::{catalogue, chosen};
use crate::prongs::{EMPTY_TUBE_SD, observed, provenance};
use crate::{Case, Check, EmptyTube, ParameterName, Provenance, StudyError};
use rijke_inference::{MapOptions, NoiseMode, Parameter};
use rijke_lab::Truth;
use rijke_model::{Assembly, Noise, Observed, PointModel, Trained, Training, train};
use rijke_numerics::C64;
use rijke_rig::{Observations, OperatingPoint, Rig};

/// What a model of the empty tube misses of the relative pressures, on top of what is measured: about 1e-3, within a
/// factor of e either way, as a judgement. One ping cannot tell a small model error from none, so that a floated noise
/// would have no best value.
pub(crate) const PRESSURE_MODEL_ERROR: NoiseMode = NoiseMode::Inferred { median: 1e-3, ln_sd: 1.0 };

/// |R|, angle of R and eta of the empty tube, from the reference microphone alone and from all microphones.
///
/// As in section 6.1, sd 0.1 1/s for the growth rate and 1 rad/s for the frequency, wide priors centred on
/// Levine-Schwinger and Rayleigh. The noise of the pressures, of which the paper says nothing, is the measured
/// one plus a model error of about 1e-3, inferred with it.
/// `truth` are the values that made virtual data, if they are known.
///
/// # Errors
/// [`StudyError::NoPoint`] without an empty tube, and those of the model.
pub fn empty_tube(observations: &Observations, truth: Option<[f64; 3]>) -> Result<EmptyTube, StudyError> {
    let Setting { assembly, empty, provenance } = setting(observations)?;
    let rig = &observations.rig;
    let cases = [vec![rig.microphones.reference], (0..rig.microphones.positions.len()).collect()]
        .into_iter()
        .map(|microphones| Ok(case(&assembly, &empty, microphones, PRESSURE_MODEL_ERROR)?.0))
        .collect::<Result<Vec<_>, StudyError>>()?;
    let prior = |p: &Parameter| match p.prior {
        rijke_inference::Prior::Normal { mean, sd } => [mean, sd],
        _ => [f64::NAN; 2],
    };
    Ok(EmptyTube {
        provenance,
        point: empty.conditions.point.id.clone(),
        parameters: names(&assembly),
        prior: assembly.parameters().iter().map(prior).collect(),
        checks: checks(&cases, truth.as_ref()),
        cases,
        predicted: predicted(rig, &empty),
        truth: truth.map(|t| t.to_vec()),
    })
}

/// What the studies of the empty tube start from.
pub(crate) struct Setting {
    pub(crate) assembly: Assembly,
    pub(crate) empty: Observed,
    pub(crate) provenance: Provenance,
}

pub(crate) fn setting(observations: &Observations) -> Result<Setting, StudyError> {
    let mut all = observed(observations, is_empty_tube)?;
    if all.is_empty() {
        return Err(StudyError::NoPoint { need: "with the empty tube".to_owned() });
    }
    all.truncate(1);
    let provenance = provenance(observations, &all);
    let candidates = chosen(&catalogue()?, &["ends.free", "wall.rayleigh"])?;
    let assembly = Assembly::new(observations.rig.clone(), candidates)?;
    Ok(Setting { assembly, empty: all.remove(0), provenance })
}

pub(crate) fn names(assembly: &Assembly) -> Vec<ParameterName> {
    let name = |p: &Parameter| ParameterName {
        name: p.name.clone(),
        symbol: p.symbol.clone(),
        unit: p.unit.clone(),
    };
    assembly.parameters().iter().map(name).collect()
}

/// Levine and Schwinger's |R| and angle at the measured s, and Rayleigh's eta.
pub(crate) fn predicted(rig: &Rig, empty: &Observed) -> Vec<f64> {
    let reflection = PointModel::levine_schwinger(rig, &empty.conditions, empty.ping.s);
    vec![reflection.norm(), reflection.arg(), 1.0]
}

/// |R|, its angle and eta of the virtual laboratory's empty tube at the measured s: what Fig. 3 should find. None
/// without an empty tube, and for records that do not name the laboratory's seed.
///
/// R is the mean of both ends. eta is the roughness of the wall: 1 means Kirchhoff's and Zwikker and Kosten's wall,
/// which the laboratory has, as far as the candidate's thin layers and its exponent of Pr allow.
#[must_use]
pub fn true_empty_tube(observations: &Observations, truth: &Truth) -> Option<[f64; 3]> {
    let rig = &observations.rig;
    let point = observations.points.iter().find(|p| is_empty_tube(&p.point))?;
    let gas = rig.gas.at(point.ambient.ambient_temperature, rig.pressure);
    let s = point.ping.as_ref()?.s;
    let ends = rijke_lab::mouths(rig, truth, &point.point, rijke_lab::seed_of(&observations.source)?);
    let mean = 0.5 * ends.map(|end| end.reflection(&gas, s)).iter().sum::<C64>();
    Some([mean.norm(), mean.arg(), truth.wall.roughness])
}

fn is_empty_tube(point: &OperatingPoint) -> bool {
    point.power == 0.0 && point.position.is_none() && !point.thermocouples
}

/// The posterior of one set of microphones, and the noise of relative pressures that was assumed or chosen.
pub(crate) fn case(
    assembly: &Assembly,
    empty: &Observed,
    microphones: Vec<usize>,
    pressure: NoiseMode,
) -> Result<(Case, f64), StudyError> {
    let fixed = |sd| NoiseMode::Fixed { sd };
    let training = Training {
        microphones: microphones.clone(),
        noise: Noise {
            growth_rate: fixed(EMPTY_TUBE_SD[0]),
            angular_frequency: fixed(EMPTY_TUBE_SD[1]),
            pressure,
            ..Noise::MEASURED
        },
        known: Vec::new(),
        varying: Vec::new(),
        channels: None,
        search: MapOptions::bfgs(),
        base_errors: false,
        checks: None,
    };
    let trained: Trained = train(assembly, std::slice::from_ref(empty), &training)?;
    let (n, sd) = (trained.values.len(), trained.sd());
    let rows = |f: &dyn Fn(usize, usize) -> f64| (0..n).map(|i| (0..n).map(|j| f(i, j)).collect()).collect();
    let case = Case {
        microphones,
        covariance: rows(&|i, j| trained.covariance[(i, j)]),
        correlation: rows(&|i, j| trained.covariance[(i, j)] / (sd[i] * sd[j])),
        mean: trained.values,
    };
    Ok((case, trained.noise.get(2).map_or(0.0, |n| n.sd)))
}

/// The statements of section 6.1 about Fig. 3.
fn checks(cases: &[Case], truth: Option<&[f64; 3]>) -> Vec<Check> {
    let [one, all] = cases else { return Vec::new() };
    let sd = |c: &Case, i: usize| c.covariance[i][i].sqrt();
    let narrowing = sd(one, 2) / sd(all, 2);
    let mut checks = vec![
        Check {
            statement: "With one microphone |R| and eta are correlated above 0.95 in absolute value.".into(),
            holds: one.correlation[0][2].abs() > 0.95,
            figure: format!("correlation {:.5}", one.correlation[0][2]),
            explanation: None,
        },
        Check {
            statement: "With eight microphones |R| and eta are separated: their posterior standard deviations shrink at least fivefold."
                .into(),
            holds: narrowing > 5.0 && sd(one, 0) / sd(all, 0) > 5.0,
            figure: format!(
                "sd of |R| {:.2e} to {:.2e}, of eta {:.3} to {:.3}; correlation {:.3}",
                sd(one, 0),
                sd(all, 0),
                sd(one, 2),
                sd(all, 2),
                all.correlation[0][2]
            ),
            explanation: None,
        },
        Check {
            statement: "The angle of R is inferred well even with one microphone.".into(),
            holds: sd(one, 1) < 0.02,
            figure: format!("sd {:.4} rad with one, {:.4} rad with all", sd(one, 1), sd(all, 1)),
            explanation: None,
        },
    ];
    if let Some(truth) = truth {
        let distance: Vec<f64> = (0..3).map(|i| (all.mean[i] - truth[i]) / sd(all, i)).collect();
        checks.push(Check {
            statement: "With eight microphones the truth lies inside three standard deviations.".into(),
            holds: distance.iter().all(|d| d.abs() < 3.0),
            figure: format!(
                "|R| off by {:.2} sd, its angle by {:.2} sd, eta by {:.2} sd",
                distance[0], distance[1], distance[2]
            ),
            explanation: distance.iter().any(|d| d.abs() >= 3.0).then(|| {
                "The standard deviations hold random errors. Errors that all repeats share, above all what the click \
                 calibration leaves of the channels' gains, and the exponent of Pr, in which the candidate differs from the \
                 laboratory's wall, come on top."
                    .to_owned()
            }),
        });
    }
    checks
}
