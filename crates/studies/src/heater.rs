//! Table 3: which drag and blockage does the cold heater have?

use crate::catalogue::catalogue;
use crate::competition::{
    Competition, Competitor, DECIDES, Stage, Terms, agreement, marginal, measured, no_winner, winner,
};
use crate::prongs::{observed, provenance};
use crate::setting;
use crate::{Check, ProngModel, Prongs, StudyError};
use rijke_model::Observed;
use rijke_rig::{Observations, Rig};

/// ln BFL, ln OF and ln ML per datapoint as printed in Table 3.
const PUBLISHED: [[f64; 3]; 3] =
    [[-3.7472, -0.0949, -3.8420], [-1.6648, -0.1947, -1.8595], [0.4209, -0.4047, 0.0162]];

/// Trains the three models of the heater on the points with a cold heater and no thermocouples (rows C1 and C2), on top
/// of the stage `before` (from [`crate::prongs_stage`]). Returns what the next stage starts from as well: a candidate of the
/// user's own in `terms` takes the place of the table's best where it leads by more than 3 nats.
///
/// # Errors
/// [`StudyError::NoPoint`] without such points; [`StudyError::NoWinner`] if no model could be fitted.
pub fn cold_heater(
    observations: &Observations,
    before: &Stage,
    terms: impl Into<Terms>,
) -> Result<(Prongs, Stage), StudyError> {
    let (rig, terms) = (&observations.rig, terms.into());
    let all: Vec<Observed> = observed(observations, |p| p.heater && p.power == 0.0 && !p.thermocouples)?;
    if all.len() < 2 {
        return Err(StudyError::NoPoint {
            need: "with the heater cold and without thermocouples, at two positions".into(),
        });
    }
    let catalogue = catalogue()?;
    let of_the_project = catalogue.competing("heater");
    let competing = of_the_project
        .iter()
        .copied()
        .chain(terms.own("heater"))
        .map(|c| Competitor::new(c, before))
        .collect();
    let competition = Competition {
        rig,
        competing,
        published: &PUBLISHED,
        depth: terms.depth,
        noise: setting::NOISE,
        base_errors: false,
        varying: setting::ends_inferred(),
        channels: observations.channels.as_ref(),
        line: true,
        shown: &all,
        trained_on: &all,
    };
    let (models, trained): (Vec<ProngModel>, Vec<_>) = competition.run()?.into_iter().unzip();
    let (best, id) = winner(&models).map(|(k, m)| (k, m.id.clone())).ok_or_else(|| no_winner(&models))?;
    // A candidate of the user's own goes on only where the evidence decides for it.
    let next = leader(&models, best, all.len());
    let stage = trained[next]
        .as_ref()
        .map(|t| competition.competing[next].stage(t))
        .ok_or_else(|| no_winner(&models))?;
    let study = Prongs {
        provenance: provenance(observations, &all),
        measured: all.iter().map(measured).collect(),
        winner: id,
        published_winner: "heater.3".to_owned(),
        kendall_tau: agreement(&models),
        checks: checks(&models[..of_the_project.len()], rig, &all),
        models,
    };
    Ok((study, stage))
}

/// The row with the most evidence on `points` points if it leads the table's `best` by more than [`DECIDES`], else that.
fn leader(models: &[ProngModel], best: usize, points: usize) -> usize {
    let lead = |k: usize| (marginal(&models[k]) - marginal(&models[best])) * points as f64;
    let first = (0..models.len()).max_by(|&a, &b| lead(a).total_cmp(&lead(b)));
    first.filter(|&k| lead(k) > DECIDES).unwrap_or(best)
}

/// The physical statements of section 6.3.
fn checks(models: &[ProngModel], rig: &Rig, all: &[Observed]) -> Vec<Check> {
    let [one, two, three, ..] = models else { return Vec::new() };
    let growth = [one, two, three].map(|m| m.growth_rate_noise_sd);
    let value = |name: &str| three.parameters.iter().find(|p| p.name == name).map_or(f64::NAN, |p| p.value);
    let plate = rig.heater.plate_thickness
        + 16.0 / (3.0 * std::f64::consts::PI) * (rig.heater.open_area() / std::f64::consts::PI).sqrt();
    let omega = all.iter().map(|o| o.ping.s.im).sum::<f64>() / all.len().max(1) as f64;
    let sound_speed = all.first().map_or(f64::NAN, |o| o.conditions.base.sound_speed(0.0));
    let inertia =
        value("kappa") * 2.0 * omega * plate * rig.tube.area() / rig.heater.open_area() / sound_speed;
    let ratio = inertia / value("drag");
    let mut list = vec![
        Check {
            statement: "Model 1, the orifice alone, cannot match the growth rate.".into(),
            holds: growth[0] > 3.0 * growth[2],
            figure: format!("misfit of the growth rate {:.4} 1/s, against {:.4} 1/s for model 3", growth[0], growth[2]),
            explanation: None,
        },
        Check {
            statement: "Model 2, without thermal drag, fits the growth rate worse than model 3.".into(),
            holds: growth[1] > growth[2],
            figure: format!("misfit of the growth rate {:.4} 1/s, against {:.4} 1/s for model 3", growth[1], growth[2]),
            explanation: None,
        },
        Check {
            statement: "Model 3, orifice with viscous and thermal drag, has the highest marginal likelihood.".into(),
            holds: marginal(three) > marginal(one).max(marginal(two)),
            figure: format!("{:.4}, {:.4}, {:.4} nats per datapoint", marginal(one), marginal(two), marginal(three)),
            explanation: None,
        },
        Check {
            statement: "The imaginary part of k_mu, the orifice, is several times its real part, the drag; the paper finds six.".into(),
            holds: ratio > 3.0,
            figure: format!("{ratio:.1}"),
            explanation: None,
        },
    ];
    list.extend(models.iter().find(|m| m.id == "heater.wires").map(|wires| Check {
        statement: "Beyond the paper: boundary layers on wires, which have inertia as well as drag, explain the cold heater better than constant drags."
            .into(),
        holds: marginal(wires) > marginal(three),
        figure: format!("{:.4} against {:.4} nats per datapoint for model 3", marginal(wires), marginal(three)),
        explanation: None,
    }));
    list
}
