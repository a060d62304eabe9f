//! Table 4: nine models of the hot heater, and candidates beyond the paper.

mod checks;

use crate::catalogue::{catalogue, chosen};
use crate::competition::{Competition, Competitor, Stage, Terms, agreement, marginal, no_winner, winner};
use crate::{HeatRelease, Hot, ProngModel, StudyError};
use rijke_candidates::{Candidate, Catalogue};
use rijke_model::{Assembly, Trained, train};

/// ln BFL, ln OF and ln ML per datapoint as printed in Table 4.
const PUBLISHED: [[f64; 3]; 9] = [
    [-4.7055, -0.1016, -4.8071],
    [-4.5805, -0.1030, -4.6836],
    [-4.6477, -0.1385, -4.7862],
    [-4.7218, -0.1058, -4.8275],
    [-4.6956, -0.1072, -4.8028],
    [-5.7721, -0.1019, -5.8741],
    [-3.4889, -0.2655, -3.7544],
    [-3.2512, -0.3964, -3.6476],
    [-3.6496, -0.3837, -4.0333],
];

/// The heater when it is hot, in place of the cold one: see [`warm`].
const WARM: &str = "warm";

/// Combinations beyond the paper: what is added to the cold model.
const BEYOND: [&[&str]; 14] = [
    &["heat-release.cylinder"],
    &["heat-release.wire"],
    &["heat-release.2", "steady-drag.quasi-steady"],
    &["heat-release.2", WARM],
    &["heat-release.2", "mean-flow.convection"],
    &["heat-release.8", "mean-flow.convection"],
    &["heat-release.6", "mean-flow.convection", "steady-drag.quasi-steady"],
    &["heat-release.wire", "mean-flow.momentum"],
    &["heat-release.wire", "mean-flow.convection"],
    &["heat-release.wire", "mean-flow.convection", "steady-drag.quasi-steady"],
    &["heat-release.wire", "mean-flow.convection", WARM],
    &["heat-release.cylinder", "mean-flow.convection", "steady-drag.quasi-steady", WARM],
    &["heat-release.wire", "mean-flow.convection", "steady-drag.quasi-steady", WARM],
    &["heat-release.wire", "mean-flow.energy", "steady-drag.quasi-steady", WARM],
];

/// What competes together with a heat release of the user's own, beside that heat release alone.
const WITH_OWN: [&str; 3] = ["mean-flow.convection", "steady-drag.quasi-steady", WARM];

/// The model with the most evidence, trained.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// Its candidates, all parameters free.
    pub assembly: Assembly,
    /// What training on all hot points found, with the error of its law inferred as well, so that its evidence is not that of
    /// the table.
    pub trained: Trained,
}

/// Trains the nine models of Table 4 on all hot points, on top of the cold model whose posterior is their prior, and the
/// candidates beyond the paper and of the user's own (`terms`); ranks them, and returns the best of all.
///
/// Noise floats, as in the paper, and with it what the points of one setting share ([`Noise::setting`]); the errors of the base
/// flow enter as a covariance that points share.
///
/// [`Noise::setting`]: rijke_model::Noise::setting
///
/// # Errors
/// [`StudyError::NoWinner`] if no model could be fitted. One model that cannot be fitted is a row without evidence.
pub fn heat_release(hot: &Hot, terms: impl Into<Terms>) -> Result<(HeatRelease, Chosen), StudyError> {
    let (catalogue, terms) = (catalogue()?, terms.into());
    let competing = competitors(hot, &catalogue, &terms)?;
    // What the checks explain is known of the project's own candidates only.
    let ours = PUBLISHED.len() + BEYOND.len();
    let assemblies =
        competing.iter().map(|c| c.assembly(&hot.rig)).collect::<Result<Vec<Assembly>, StudyError>>()?;
    let competition = Competition {
        rig: &hot.rig,
        competing,
        published: &PUBLISHED,
        depth: terms.depth,
        noise: hot.noise(),
        base_errors: true,
        varying: hot.varying(),
        channels: None,
        line: false,
        shown: &hot.points,
        trained_on: &hot.points,
    };
    let models: Vec<ProngModel> = competition.run()?.into_iter().map(|(model, _)| model).collect();
    let (_, published_best) = winner(&models).ok_or_else(|| no_winner(&models))?;
    let best = (0..models.len())
        .max_by(|&a, &b| marginal(&models[a]).total_cmp(&marginal(&models[b])))
        .ok_or_else(|| no_winner(&models))?;
    let assembly = assemblies.into_iter().nth(best).ok_or_else(|| no_winner(&models))?;
    let study = HeatRelease {
        provenance: hot.provenance.clone(),
        measured: hot.measured.clone(),
        winner: published_best.id.clone(),
        published_winner: "heat-release.8".to_owned(),
        chosen: models[best].id.clone(),
        kendall_tau: agreement(&models),
        checks: checks::checks(&models[..ours]),
        models,
    };
    let trained = train(&assembly, &hot.points, &hot.training(hot.honest_noise(), hot.known()))?;
    Ok((study, Chosen { assembly, trained }))
}

/// The candidate that is the cold model's heater when it is hot, with the same parameters and what a hot film adds.
fn warm(cold: &Stage) -> &'static str {
    let layers = cold.candidates.iter().any(|c| c.id == "heater.wires");
    if layers { "heater.hot-wires" } else { "heater.film" }
}

fn competitors(hot: &Hot, catalogue: &Catalogue, terms: &Terms) -> Result<Vec<Competitor>, StudyError> {
    let cold = &hot.cold.stage;
    let mut rows = Vec::new();
    for number in 1..=PUBLISHED.len() {
        let own = chosen(catalogue, &[&format!("heat-release.{number}")])?;
        rows.push(Competitor::new(&own[0], cold));
    }
    let combined = |ids: &[&str]| {
        let ids: Vec<&str> = ids.iter().map(|&id| if id == WARM { warm(cold) } else { id }).collect();
        chosen(catalogue, &ids)
    };
    let beyond = BEYOND.iter().map(|ids| combined(ids)).collect::<Result<Vec<_>, _>>()?;
    // The user's own: alone as in Table 4, and with what the project adds to its own best heat release.
    let added = combined(&WITH_OWN)?;
    let own =
        terms.own("heat-release").flat_map(|c| [vec![c.clone()], [vec![c.clone()], added.clone()].concat()]);
    for own in beyond.into_iter().chain(own) {
        let replaces_heater = own.iter().any(|c| c.role == "hot-heater");
        let keep = |c: &&Candidate| !(replaces_heater && c.role == "heater");
        let joined =
            |word: fn(&Candidate) -> &str, by: &str| own.iter().map(word).collect::<Vec<_>>().join(by);
        rows.push(Competitor {
            id: joined(|c| &c.id, " + "),
            label: joined(|c| &c.name, "; "),
            base: cold.candidates.iter().filter(keep).cloned().collect(),
            known: vec![cold.knowledge.clone()],
            own,
        });
    }
    Ok(rows)
}
