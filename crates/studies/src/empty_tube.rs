//! Fig. 3: what can one microphone say of the ends and the wall, and what can eight?

use crate::catalogue::{catalogue, chosen};
use crate::prongs::{EMPTY_TUBE_SD, observed, provenance};
use crate::{Case, Check, EmptyTube, ParameterName, StudyError};
use rijke_inference::{MapOptions, NoiseMode};
use rijke_lab::{Truth, radiation::OpenEnd};
use rijke_model::{Assembly, Noise, Observed, PointModel, Trained, Training, train};
use rijke_numerics::C64;
use rijke_rig::{Observations, OperatingPoint};

/// |R|, angle of R and eta of the empty tube, from the reference microphone alone and from all microphones.
///
/// As in section 6.1, sd 0.1 1/s for the growth rate and 1 rad/s for the frequency, wide priors centred on
/// Levine-Schwinger and Rayleigh. The noise of the pressures, of which the paper says nothing, floats.
/// `truth` are the values that made virtual data, if they are known.
///
/// # Errors
/// [`StudyError::NoPoint`] without an empty tube, and those of the model.
pub fn empty_tube(observations: &Observations, truth: Option<[f64; 3]>) -> Result<EmptyTube, StudyError> {
    let rig = &observations.rig;
    let all = observed(observations, is_empty_tube)?;
    let Some(empty) = all.first() else {
        return Err(StudyError::NoPoint { need: "with the empty tube".to_owned() });
    };
    let assembly = Assembly::new(rig.clone(), chosen(&catalogue()?, &["ends.free", "wall.rayleigh"])?)?;
    let count = rig.microphones.positions.len();
    let cases = [vec![rig.microphones.reference], (0..count).collect()]
        .into_iter()
        .map(|microphones| case(&assembly, empty, microphones))
        .collect::<Result<Vec<_>, StudyError>>()?;
    let reflection = PointModel::levine_schwinger(rig, &empty.conditions, empty.ping.s);
    let predicted = vec![reflection.norm(), reflection.arg(), 1.0];
    let name = |p: &rijke_inference::Parameter| ParameterName {
        name: p.name.clone(),
        symbol: p.symbol.clone(),
        unit: p.unit.clone(),
    };
    let prior = |p: &rijke_inference::Parameter| match p.prior {
        rijke_inference::Prior::Normal { mean, sd } => [mean, sd],
        _ => [f64::NAN; 2],
    };
    Ok(EmptyTube {
        provenance: provenance(observations, &all[..1]),
        point: empty.conditions.point.id.clone(),
        parameters: assembly.parameters().iter().map(name).collect(),
        prior: assembly.parameters().iter().map(prior).collect(),
        checks: checks(&cases, truth.as_ref()),
        cases,
        predicted,
        truth: truth.map(|t| t.to_vec()),
    })
}

/// |R|, its angle and eta of the virtual laboratory's empty tube at the measured s: what Fig. 3 should find. None
/// without an empty tube.
///
/// R is the mean of both ends. eta is the roughness of the wall: 1 means Kirchhoff's and Zwikker and Kosten's wall,
/// which the laboratory has, as far as the candidate's thin layers and its exponent of Pr allow.
#[must_use]
pub fn true_empty_tube(observations: &Observations, truth: &Truth) -> Option<[f64; 3]> {
    let rig = &observations.rig;
    let point = observations.points.iter().find(|p| is_empty_tube(&p.point))?;
    let gas = rig.gas.at(point.ambient.ambient_temperature, rig.pressure);
    let s = point.ping.as_ref()?.s;
    let end = |absorption| OpenEnd {
        inner_radius: rig.tube.radius(),
        outer_radius: rig.tube.radius() + rig.tube.wall_thickness,
        absorption,
    };
    let ends = [truth.ends.absorption_bottom, truth.ends.absorption_top];
    let mean = 0.5 * ends.map(|a| end(a).reflection(&gas, s)).iter().sum::<C64>();
    Some([mean.norm(), mean.arg(), truth.wall.roughness])
}

fn is_empty_tube(point: &OperatingPoint) -> bool {
    point.power == 0.0 && point.position.is_none() && !point.thermocouples
}

fn case(assembly: &Assembly, empty: &Observed, microphones: Vec<usize>) -> Result<Case, StudyError> {
    let fixed = |sd| NoiseMode::Fixed { sd };
    let training = Training {
        microphones: microphones.clone(),
        noise: Noise {
            growth_rate: fixed(EMPTY_TUBE_SD[0]),
            angular_frequency: fixed(EMPTY_TUBE_SD[1]),
            pressure: NoiseMode::Floated,
            measured: false,
        },
        known: Vec::new(),
        search: MapOptions::bfgs(),
    };
    let trained: Trained = train(assembly, std::slice::from_ref(empty), &training)?;
    let n = trained.values.len();
    let sd = trained.sd();
    let rows = |f: &dyn Fn(usize, usize) -> f64| (0..n).map(|i| (0..n).map(|j| f(i, j)).collect()).collect();
    Ok(Case {
        microphones,
        covariance: rows(&|i, j| trained.covariance[(i, j)]),
        correlation: rows(&|i, j| trained.covariance[(i, j)] / (sd[i] * sd[j])),
        mean: trained.values,
    })
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
            explanation: None,
        });
    }
    checks
}
