//! Table 2 and Fig. 4: which drag and blockage do the prongs have?

use crate::catalogue::{catalogue, chosen};
use crate::{
    Check, CurvePoint, DataKind, Evidence, MeasuredPoint, ParameterValue, ProngModel, Prongs, Provenance,
    RejectedRecord, StudyError,
};
use rayon::prelude::*;
use rijke_candidates::Candidate;
use rijke_inference::{MapOptions, NoiseMode};
use rijke_model::{
    Assembly, Conditions, Knowledge, ModelError, Noise, Observed, PointModel, Trained, Training, Workspace,
    train,
};
use rijke_numerics::Order;
use rijke_rig::{Observations, OperatingPoint, Rig};

/// ln BFL, ln OF and ln ML per datapoint as printed in Table 2.
const PUBLISHED: [[f64; 3]; 7] = [
    [-0.3635, -0.3561, -0.7197],
    [-0.3575, -0.5567, -0.9141],
    [-0.3552, -0.4151, -0.7702],
    [0.9452, -1.2319, -0.2867],
    [-3.7064, -0.1736, -3.8799],
    [0.6705, -0.5767, 0.0938],
    [0.7010, -0.8191, -0.1181],
];

/// Standard deviations that the paper assumes for the empty tube, 1/s and rad/s (section 6.1).
pub(crate) const EMPTY_TUBE_SD: [f64; 2] = [0.1, 1.0];

/// Number of positions at which the lines of Fig. 4 are computed.
const LINE_POINTS: usize = 121;

/// Trains the seven models on the prong-only points (row C3) and ranks them.
///
/// The empty tube is a stage of its own: its posterior of eta and k_LS is the joint prior of the seven fits, which
/// therefore do not use it a second time. Noise floats, as in section 6.2.
///
/// # Errors
/// [`StudyError::NoPoint`] without an empty tube or prong-only points. A model that cannot be fitted is a row
/// without evidence, not an error.
pub fn prongs(observations: &Observations) -> Result<Prongs, StudyError> {
    let rig = &observations.rig;
    let all = observed(observations, |p| p.power == 0.0 && !p.heater && !p.thermocouples)?;
    let need = |need: &str| StudyError::NoPoint { need: need.to_owned() };
    let empty = all
        .iter()
        .find(|o| o.conditions.point.position.is_none())
        .ok_or_else(|| need("with the empty tube"))?;
    let inserted: Vec<Observed> =
        all.iter().filter(|o| o.conditions.point.position.is_some()).cloned().collect();
    if inserted.len() < 2 {
        return Err(need("with prongs alone at two positions at least"));
    }
    let ends = empty_tube_stage(rig, empty)?;
    let catalogue = catalogue()?;
    let competing: Vec<Candidate> = catalogue.competing("prongs").into_iter().cloned().collect();
    let models = competing
        .par_iter()
        .enumerate()
        .map(|(k, candidate)| model(rig, candidate, k, &ends, empty, &all, &inserted))
        .collect::<Result<Vec<_>, StudyError>>()?;

    let evidence = |m: &ProngModel| m.evidence.map_or(f64::NEG_INFINITY, |e| e.ln_marginal);
    let best = models.iter().max_by(|a, b| evidence(a).total_cmp(&evidence(b)));
    let ours: Vec<f64> = models.iter().filter(|m| m.published.is_some()).map(evidence).collect();
    let theirs: Vec<f64> = models.iter().filter_map(|m| m.published).map(|e| e.ln_marginal).collect();
    Ok(Prongs {
        provenance: provenance(observations, &all),
        measured: all.iter().map(measured).collect(),
        winner: best.map(|m| m.id.clone()).unwrap_or_default(),
        published_winner: "prongs.6".to_owned(),
        kendall_tau: kendall_tau(&ours, &theirs),
        checks: checks(&models),
        models,
    })
}

/// The measured pings of the points that `wanted` accepts, in the order of the campaign.
pub(crate) fn observed(
    observations: &Observations,
    wanted: impl Fn(&OperatingPoint) -> bool,
) -> Result<Vec<Observed>, StudyError> {
    let mut all = Vec::new();
    for point in observations.points.iter().filter(|p| wanted(&p.point)) {
        let Some(ping) = point.ping.clone() else {
            return Err(ModelError::NoPing { point: point.point.id.clone() }.into());
        };
        all.push(Observed { conditions: Conditions::of_the_day(&observations.rig, point)?, ping });
    }
    Ok(all)
}

pub(crate) fn provenance(observations: &Observations, used: &[Observed]) -> Provenance {
    let id = |o: &Observed| o.conditions.point.id.clone();
    let ids: Vec<String> = used.iter().map(id).collect();
    let points = observations.points.iter().filter(|p| ids.contains(&p.point.id));
    Provenance {
        data: match observations.kind {
            rijke_rig::DataKind::Measured => DataKind::Measured,
            rijke_rig::DataKind::Virtual => DataKind::Virtual,
        },
        rig: observations.rig.name.clone(),
        source: observations.source.clone(),
        points: used.len(),
        pings: points.map(|p| u64::from(p.ping_count)).sum(),
        rejected: observations
            .rejections
            .iter()
            .map(|r| RejectedRecord { record: r.record.clone(), reason: r.reason.clone() })
            .collect(),
    }
}

/// eta and k_LS from the empty tube and all microphones.
pub(crate) fn empty_tube_stage(rig: &Rig, empty: &Observed) -> Result<Knowledge, StudyError> {
    let assembly = Assembly::new(rig.clone(), chosen(&catalogue()?, &["wall.rayleigh", "ends.calibrated"])?)?;
    let fixed = |sd| NoiseMode::Fixed { sd };
    let training = Training {
        microphones: (0..rig.microphones.positions.len()).collect(),
        noise: Noise {
            growth_rate: fixed(EMPTY_TUBE_SD[0]),
            angular_frequency: fixed(EMPTY_TUBE_SD[1]),
            pressure: NoiseMode::Floated,
            measured: false,
        },
        known: Vec::new(),
        search: MapOptions::bfgs(),
    };
    Ok(train(&assembly, std::slice::from_ref(empty), &training)?.knowledge())
}

fn model(
    rig: &Rig,
    candidate: &Candidate,
    index: usize,
    ends: &Knowledge,
    empty: &Observed,
    all: &[Observed],
    inserted: &[Observed],
) -> Result<ProngModel, StudyError> {
    let mut parts = chosen(&catalogue()?, &["wall.rayleigh", "ends.calibrated"])?;
    parts.push(candidate.clone());
    let assembly = Assembly::new(rig.clone(), parts)?;
    let training = Training {
        microphones: (0..rig.microphones.positions.len()).collect(),
        noise: Noise::FLOATED,
        known: vec![ends.clone()],
        search: MapOptions::bfgs(),
    };
    let number = u32::try_from(index + 1).ok().filter(|_| index < PUBLISHED.len());
    let laws =
        candidate.effects.iter().map(|e| (format!("{:?} at {:?}", e.coefficient, e.place), e.law.text()));
    let mut row = ProngModel {
        id: candidate.id.clone(),
        number,
        label: candidate.name.clone(),
        laws: laws.collect(),
        parameters: Vec::new(),
        growth_rate_noise_sd: 0.0,
        angular_frequency_noise_sd: 0.0,
        pressure_noise_sd: 0.0,
        at_points: Vec::new(),
        line: Vec::new(),
        evidence: None,
        remark: None,
        published: number.map(|_| evidence_of(PUBLISHED[index])),
    };
    let trained = match train(&assembly, inserted, &training) {
        Ok(trained) => trained,
        Err(error) => {
            row.remark = Some(error.to_string());
            return Ok(row);
        }
    };
    row.evidence = Some(evidence_of(trained.evidence.per_datapoint()));
    row.parameters = parameter_values(&trained);
    [row.growth_rate_noise_sd, row.angular_frequency_noise_sd, row.pressure_noise_sd] =
        std::array::from_fn(|g| trained.noise[g].sd);
    let curve = |conditions: &Conditions, start| -> Result<CurvePoint, StudyError> {
        let point =
            PointModel::new(&assembly, conditions, &[rig.microphones.reference])?.starting_from(start);
        let s = point.respond(&trained.values, Order::Value, &mut Workspace::default())?.s.value();
        let position_m = conditions.point.position.unwrap_or(0.0);
        Ok(CurvePoint { position_m, growth_rate: s.re, angular_frequency: s.im })
    };
    row.at_points = all.iter().map(|o| curve(&o.conditions, o.ping.s)).collect::<Result<_, _>>()?;
    for k in 0..LINE_POINTS {
        #[allow(clippy::cast_precision_loss, reason = "small numbers")]
        let x = rig.tube.length * k as f64 / (LINE_POINTS - 1) as f64;
        let mut conditions =
            Conditions::cold(rig, empty.conditions.point.clone(), temperature_at(all, x), 0.0)?;
        conditions.point.position = Some(x).filter(|x| *x > 0.0 && *x < rig.tube.length);
        let mut point = curve(&conditions, empty.ping.s)?;
        point.position_m = x;
        row.line.push(point);
    }
    Ok(row)
}

/// Ambient temperature at prong position `x`, K, between those of the neighbouring points, which may have been measured
/// on different days.
fn temperature_at(all: &[Observed], x: f64) -> f64 {
    let mut known: Vec<[f64; 2]> =
        all.iter().map(|o| [o.conditions.point.position.unwrap_or(0.0), o.conditions.ambient]).collect();
    known.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let after = known.iter().position(|[at, _]| *at >= x);
    match after {
        Some(0) => known[0][1],
        Some(k) => {
            let ([x0, t0], [x1, t1]) = (known[k - 1], known[k]);
            t0 + (t1 - t0) * (x - x0) / (x1 - x0)
        }
        None => known.last().map_or(f64::NAN, |[_, t]| *t),
    }
}

fn measured(observed: &Observed) -> MeasuredPoint {
    let Observed { conditions, ping } = observed;
    MeasuredPoint {
        id: conditions.point.id.clone(),
        position_m: conditions.point.position.unwrap_or(0.0),
        growth_rate: ping.s.re,
        growth_rate_sd: ping.covariance[(0, 0)].sqrt(),
        angular_frequency: ping.s.im,
        angular_frequency_sd: ping.covariance[(1, 1)].sqrt(),
        ambient_temperature: conditions.ambient,
    }
}

pub(crate) fn parameter_values(trained: &Trained) -> Vec<ParameterValue> {
    let numbers = trained.values.iter().zip(trained.sd());
    let value = |(p, (&value, sd)): (&rijke_inference::Parameter, (&f64, f64))| ParameterValue {
        name: p.name.clone(),
        symbol: p.symbol.clone(),
        unit: p.unit.clone(),
        value,
        sd,
    };
    trained.parameters.iter().zip(numbers).map(value).collect()
}

fn evidence_of([ln_best_fit, ln_occam, ln_marginal]: [f64; 3]) -> Evidence {
    Evidence { ln_best_fit, ln_occam, ln_marginal }
}

/// Kendall's tau-a: pairs in the same order less pairs in opposite order, over all pairs.
pub(crate) fn kendall_tau(a: &[f64], b: &[f64]) -> f64 {
    let pairs = (0..a.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let signs: Vec<f64> = pairs
        .map(|(i, j)| {
            a[i].partial_cmp(&a[j]).map_or(0.0, |o| f64::from(o as i8))
                * f64::from(b[i].total_cmp(&b[j]) as i8)
        })
        .collect();
    if signs.is_empty() { 1.0 } else { signs.iter().sum::<f64>() / signs.len() as f64 }
}

/// The physical statements of section 6.2.
fn checks(models: &[ProngModel]) -> Vec<Check> {
    let Some([one, two, three, four, five, six, seven]) = models.first_chunk() else { return Vec::new() };
    let occam = |m: &ProngModel| m.evidence.map_or(f64::NAN, |e| e.ln_occam);
    let fit = |m: &ProngModel| m.evidence.map_or(f64::NAN, |e| e.ln_best_fit);
    let marginal = |m: &ProngModel| m.evidence.map_or(f64::NAN, |e| e.ln_marginal);
    let frequency = [one, two, three, six].map(|m| m.angular_frequency_noise_sd);
    let growth = [five, six].map(|m| m.growth_rate_noise_sd);
    let good = [four, six, seven].map(fit).into_iter().fold(f64::INFINITY, f64::min);
    let poor = [one, two, three, five].map(fit).into_iter().fold(f64::NEG_INFINITY, f64::max);
    let runner_up =
        [one, two, three, four, five, seven].map(marginal).into_iter().fold(f64::NEG_INFINITY, f64::max);
    let why = |holds: bool, text: &str| (!holds).then(|| text.to_owned());
    // A model misses a quantity if the misfit that it needs is at least three times that of the published winner.
    let misses = 3.0;
    vec![
        Check {
            statement: "Models 1, 2 and 3, without blockage, cannot match the measured frequency.".into(),
            holds: frequency[..3].iter().all(|sd| *sd > misses * frequency[3]),
            figure: format!(
                "misfit of the frequency {:.3}, {:.3}, {:.3} rad/s, against {:.3} rad/s for model 6",
                frequency[0], frequency[1], frequency[2], frequency[3]
            ),
            explanation: None,
        },
        Check {
            statement: "Model 5, without drag, cannot match the measured growth rate.".into(),
            holds: growth[0] > misses * growth[1],
            figure: format!(
                "misfit of the growth rate {:.4} 1/s, against {:.4} 1/s for model 6",
                growth[0], growth[1]
            ),
            explanation: None,
        },
        Check {
            statement: "Models 4, 6 and 7 fit the data better than all others.".into(),
            holds: good > poor,
            figure: format!("worst of the three {good:.4}, best of the others {poor:.4} nats per datapoint"),
            explanation: None,
        },
        Check {
            statement: "The Occam factor penalises models 4 and 7 against model 6.".into(),
            holds: occam(four) < occam(six) && occam(seven) < occam(six),
            figure: format!(
                "{:.4} and {:.4}, against {:.4} nats per datapoint",
                occam(four),
                occam(seven),
                occam(six)
            ),
            explanation: why(
                occam(four) < occam(six) && occam(seven) < occam(six),
                "The Occam factor also holds the shift of eta and k_LS within their joint prior, which a model that \
                 fits badly may need more than one that fits well.",
            ),
        },
        Check {
            statement: "Model 6, one drag and one blockage, has the highest marginal likelihood.".into(),
            holds: marginal(six) > runner_up,
            figure: format!("{:.4}, best of the others {runner_up:.4} nats per datapoint", marginal(six)),
            explanation: why(
                marginal(six) > runner_up,
                "The virtual rig has a true area change, wires rougher than rods and a Bessel wall, which no candidate has \
                 exactly; a candidate with more freedom can absorb part of that.",
            ),
        },
    ]
}
