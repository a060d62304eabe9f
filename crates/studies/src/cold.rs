//! Fig. 5: thermocouples, the last cold component; and all cold experiments against the model of them all.

use crate::catalogue::{catalogue, chosen};
use crate::competition::{Stage, gauss_newton, measured, parameter_values, position};
use crate::prongs::{observed, provenance};
use crate::setting;
use crate::{Check, Cold, ColdSeries, PredictedPoint, StudyError};
use rayon::prelude::*;
use rijke_model::{Assembly, Knowledge, Misfit, ModelError, Observed, PointPrediction, Training, train};
use rijke_rig::{Observations, OperatingPoint};

/// What all cold stages together hand to the hot ones.
#[derive(Clone, Debug)]
pub struct ColdStage {
    /// Wall, ends, prongs, heater, thermocouples.
    pub stage: Stage,
    /// Misfit of growth rate (1/s), angular frequency (rad/s) and relative pressures that row H0 chose, what was measured included.
    pub noise: [f64; 3],
    /// The first two at a new setting of the rig, with the scatter of its ends.
    pub new_setting: [f64; 2],
    /// Scatter of Re and Im k_LS between settings of the rig that row H0 chose.
    pub ends_sd: [f64; 2],
}

/// Trains the thermocouples on the cold points that have them (row H0), on top of the stage `before` (from
/// [`crate::cold_heater`]); then predicts every cold experiment.
///
/// # Errors
/// [`StudyError::NoPoint`] without such points, and those of the model.
pub fn cold(observations: &Observations, before: &Stage) -> Result<(Cold, ColdStage), StudyError> {
    let rig = &observations.rig;
    let trained_on = observed(observations, |p| p.thermocouples && p.power == 0.0)?;
    if trained_on.len() < 2 {
        return Err(StudyError::NoPoint { need: "with thermocouples and cold, at two positions".into() });
    }
    let mut candidates = before.candidates.clone();
    candidates.extend(chosen(&catalogue()?, &["thermocouples.paper"])?);
    let assembly = Assembly::new(rig.clone(), candidates.clone())?;
    let training = Training {
        microphones: (0..rig.microphones.positions.len()).collect(),
        noise: setting::NOISE,
        known: vec![before.knowledge.clone()],
        search: gauss_newton(),
        base_errors: false,
        varying: setting::ends_inferred(),
        channels: observations.channels.clone(),
        checks: None,
    };
    let trained = train(&assembly, &trained_on, &training)?;
    let misfit = Misfit::of(&trained.noise);

    let all = observed(observations, |p| p.power == 0.0)?;
    let knowledge = trained.knowledge();
    let new_setting = knowledge.at_a_new_setting(&trained.noise);
    let predicted = predicted_points(&assembly, &new_setting, misfit, &all)?;
    // What a measurement scatters by beyond what is not known of the parameters.
    let known = predicted_points(&assembly, &knowledge, Misfit::default(), &all)?;
    let beyond = |sd: fn(&PredictedPoint) -> f64| {
        let square = |(new, known): (&PredictedPoint, &PredictedPoint)| sd(new).powi(2) - sd(known).powi(2);
        (predicted.iter().zip(&known).map(square).sum::<f64>() / all.len() as f64).sqrt()
    };
    let stage = ColdStage {
        stage: Stage { candidates, knowledge },
        noise: [0, 1, 2].map(|k| misfit.measured[k].hypot(measured_sd(&trained_on, k))),
        new_setting: [beyond(|p| p.growth_rate_sd), beyond(|p| p.angular_frequency_sd)],
        ends_sd: setting::ends_sd(&trained.noise),
    };
    let series: Vec<ColdSeries> = [
        ("C3", "prongs alone"),
        ("C1", "heater"),
        ("C2", "heater, another day"),
        ("H0", "heater and thermocouples"),
    ]
    .into_iter()
    .filter_map(|(row, label)| series(row, label, &all, &predicted))
    .collect();
    let study = Cold {
        provenance: provenance(observations, &all),
        candidates: stage.stage.candidates.iter().map(|c| c.id.clone()).collect(),
        parameters: parameter_values(&trained),
        checks: checks(&series),
        series,
    };
    Ok((study, stage))
}

/// Root mean square of the measured standard deviations of number `k` of the pings.
fn measured_sd(points: &[Observed], k: usize) -> f64 {
    let sum: f64 = points.iter().map(|o| o.ping.covariance[(k, k)]).sum();
    (sum / points.len().max(1) as f64).sqrt()
}

fn series(row: &str, label: &str, all: &[Observed], predicted: &[PredictedPoint]) -> Option<ColdSeries> {
    let of_row = |p: &OperatingPoint| p.row == row;
    let mut both: Vec<(&Observed, PredictedPoint)> = all
        .iter()
        .zip(predicted)
        .filter(|(o, _)| of_row(&o.conditions.point))
        .map(|(o, p)| (o, *p))
        .collect();
    both.sort_by(|a, b| position(a.0).total_cmp(&position(b.0)));
    let (measured_points, predicted) = both.into_iter().map(|(o, p)| (measured(o), p)).unzip();
    let series = ColdSeries { row: row.into(), label: label.into(), measured: measured_points, predicted };
    (!series.measured.is_empty()).then_some(series)
}

fn predicted_points(
    assembly: &Assembly,
    knowledge: &Knowledge,
    misfit: Misfit,
    points: &[Observed],
) -> Result<Vec<PredictedPoint>, StudyError> {
    let microphones = [assembly.rig.microphones.reference];
    predictions(misfit, points, |o| knowledge.predict(assembly, &o.conditions, &microphones, Some(o.ping.s)))
}

/// What `predict` says at the conditions of many points, with the sd of a new measurement there.
pub(crate) fn predictions(
    misfit: Misfit,
    points: &[Observed],
    predict: impl Fn(&Observed) -> Result<PointPrediction, ModelError> + Sync,
) -> Result<Vec<PredictedPoint>, StudyError> {
    let at = |o: &Observed| -> Result<PredictedPoint, StudyError> {
        let p = predict(o)?;
        Ok(PredictedPoint {
            growth_rate: p.values[0],
            growth_rate_sd: p.sd(0, &misfit),
            angular_frequency: p.values[1],
            angular_frequency_sd: p.sd(1, &misfit),
        })
    };
    points.par_iter().map(at).collect()
}

/// The statements of section 6.3 about thermocouples.
fn checks(series: &[ColdSeries]) -> Vec<Check> {
    let of = |row: &str| series.iter().find(|s| s.row == row);
    let (Some(with), Some(without)) = (of("H0"), of("C1")) else { return Vec::new() };
    // Mean over common positions of measured minus predicted-without-them: days differ in temperature, so compare each row's
    // distance from the mean frequency of its day's gas through sqrt(T).
    let pairs: Vec<[f64; 2]> = with
        .measured
        .iter()
        .filter_map(|a| {
            let b = without.measured.iter().find(|b| (b.position_m - a.position_m).abs() < 1e-9)?;
            let warmer = (a.ambient_temperature / b.ambient_temperature).sqrt();
            Some([a.growth_rate - b.growth_rate, a.angular_frequency / warmer - b.angular_frequency])
        })
        .collect();
    let mean = |k: usize| pairs.iter().map(|p| p[k]).sum::<f64>() / pairs.len().max(1) as f64;
    let relative =
        [mean(0) / mean_of(without, |m| m.growth_rate), mean(1) / mean_of(without, |m| m.angular_frequency)];
    let all: Vec<[f64; 2]> = series
        .iter()
        .flat_map(|s| s.measured.iter().zip(&s.predicted))
        .map(|(m, p)| [m.growth_rate - p.growth_rate, m.angular_frequency - p.angular_frequency])
        .collect();
    let rms = |k: usize| (all.iter().map(|r| r[k] * r[k]).sum::<f64>() / all.len().max(1) as f64).sqrt();
    let swing = |k: fn(&crate::MeasuredPoint) -> f64| {
        let values = || series.iter().flat_map(|s| &s.measured).map(k);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let share = [rms(0) / swing(|m| m.growth_rate), rms(1) / swing(|m| m.angular_frequency)];
    vec![
        Check {
            statement: "Thermocouples affect the growth rate significantly and the frequency slightly."
                .into(),
            holds: relative[0] > 3.0 * relative[1].abs(),
            figure: format!(
                "row H0 minus row C1: {:+.3} 1/s ({:+.1} %) and {:+.2} rad/s at equal temperature ({:+.2} %)",
                mean(0),
                100.0 * relative[0],
                mean(1),
                100.0 * relative[1]
            ),
            explanation: None,
        },
        Check {
            statement:
                "One model matches all cold experiments: misfit below 5 % of the range of the measurements."
                    .into(),
            holds: share.iter().all(|s| *s < 0.05),
            figure: format!(
                "rms misfit {:.3} 1/s ({:.1} % of the range) and {:.2} rad/s ({:.1} %) over {} points",
                rms(0),
                100.0 * share[0],
                rms(1),
                100.0 * share[1],
                all.len()
            ),
            explanation: None,
        },
    ]
}

fn mean_of(series: &ColdSeries, number: impl Fn(&crate::MeasuredPoint) -> f64) -> f64 {
    series.measured.iter().map(number).sum::<f64>() / series.measured.len().max(1) as f64
}
