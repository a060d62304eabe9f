//! Trained parameters against the values of the virtual laboratory, where the two mean the same thing.

use crate::empty_tube::true_empty_tube;
use crate::prongs::observed;
use crate::{Check, Chosen, Hot, StudyError, TruthRow, Truths};
use rijke_lab::{Truth, base_state};
use rijke_model::{BaseState, Conditions, Knowledge, PointModel};
use rijke_numerics::C64;
use rijke_rig::Observations;

/// The operating point at which the delay of the heat release is compared: the middle of the powers, where the thermoacoustic
/// effect is strong.
const DELAY_AT: &str = "H80-25";

/// Wall and ends after the cold stages, and what the chosen hot model shares with the laboratory's law.
///
/// # Errors
/// [`crate::StudyError::Model`] for an empty tube without a ping.
pub fn truths(
    observations: &Observations,
    truth: &Truth,
    hot: &Hot,
    best: &Chosen,
) -> Result<Truths, StudyError> {
    let cold = &hot.cold.stage.knowledge;
    let mut rows = Vec::new();
    let mut add = |quantity: &str, known: &Knowledge, name: &str, factor: f64, truth: f64| {
        if let Some(k) = known.names.iter().position(|n| n == name) {
            let (value, sd) = (factor * known.mean[k], factor * known.covariance[(k, k)].sqrt());
            rows.push(TruthRow { quantity: quantity.to_owned(), value, sd, truth });
        }
    };
    add("η of the wall", cold, "eta", 1.0, truth.wall.roughness);
    let empty = observed(observations, |p| p.power == 0.0 && p.position.is_none() && !p.thermocouples)?;
    // Every cold point is a setting of its own, so that the stages find the ends as they are on average.
    let mut average = truth.clone();
    (average.ends.absorption_sd, average.ends.extension_sd) = (0.0, 0.0);
    let ends = true_empty_tube(observations, &average);
    if let (Some([modulus, angle, _]), Some(empty)) = (ends, empty.first()) {
        let ideal = PointModel::levine_schwinger(&observations.rig, &empty.conditions, empty.ping.s);
        let k = C64::from_polar(modulus, angle) / ideal;
        add("Re k_LS of the ends", cold, "k_r", 1.0, k.re);
        add("Im k_LS of the ends", cold, "k_i", 1.0, k.im);
    }
    let trained = best.trained.knowledge();
    add("1 + K of the mouth", &trained, "entry", 1.0, 1.0 + truth.flow.closures.entrance_loss);
    let drag = truth.heater.steady_drag_share * truth.flow.parameters.heater_drag;
    add("K_h, steady drag of the heater", &trained, "loss", 1.0, drag);
    let law = |ids: &[&str]| best.assembly.candidates().iter().any(|c| ids.contains(&c.id.as_str()));
    let at_wire = law(&["heat-release.wire"]);
    let by_velocity = at_wire || law(&["heat-release.6", "heat-release.cylinder"]);
    if let Some(point) = hot.points.iter().find(|p| by_velocity && p.conditions.point.id == DELAY_AT) {
        // The wire feels the flow that is there, not the one that was inferred.
        let Conditions { point: place, base, ambient } = &point.conditions;
        let there = base_state(&observations.rig, truth, place, *ambient)?;
        let lighthill = 0.2 * observations.rig.heater.wire_diameter * 1e3;
        let x = place.position.unwrap_or(0.0);
        let speed = |state: &BaseState| if at_wire { state.velocity(x) } else { state.heater_velocity };
        let k2 = best.trained.parameters.iter().position(|p| p.name == "k2").unwrap_or(0);
        let mut row = |quantity: &str, [value, sd]: [f64; 2], truth: f64| {
            rows.push(TruthRow { quantity: format!("{quantity} at {DELAY_AT}"), value, sd, truth });
        };
        row(
            "velocity that approaches the heater, m/s,",
            best.trained.estimate(base, |_, state| state.heater_velocity),
            there.heater_velocity,
        );
        row(
            "delay of the heat release, ms,",
            best.trained.estimate(base, |values, state| values[k2] * lighthill / speed(state)),
            truth.heater.lag_factor * lighthill / (truth.heater.wire_speed_up * there.velocity(x)),
        );
    }
    Ok(Truths { checks: rows.iter().map(check).collect(), rows })
}

fn check(row: &TruthRow) -> Check {
    let off = (row.value - row.truth) / row.sd;
    Check {
        statement: format!("{}: the laboratory's value lies inside three standard deviations.", row.quantity),
        holds: off.abs() < 3.0,
        figure: format!("{:.4} +- {:.4}, true {:.4}: off by {off:.1} sd", row.value, row.sd, row.truth),
        explanation: (off.abs() >= 3.0).then(|| {
            "The standard deviation is that of a model which is taken to be right. Laws that differ from the laboratory's in \
             form put the difference into the parameters nearest to it."
                .to_owned()
        }),
    }
}
