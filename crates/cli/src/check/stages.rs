//! What a campaign can teach, stage by stage, as `rijke rank` will go through it.

use crate::failure::{Classify, Failure};
use rijke_candidates::Candidate;
use rijke_flow::{Closures, Parameters, Pipe};
use rijke_model::{Assembly, Conditions};
use rijke_rig::{OperatingPoint, Rig};
use rijke_studies::{catalogue, chosen};

/// One stage: candidates of one role on top of what stands for the stages before it.
pub(crate) struct Stage {
    /// The role, `"prongs"`.
    pub(crate) role: &'static str,
    /// The models that compete: the id of the candidate in question, and all candidates of the model.
    pub(crate) models: Vec<(String, Assembly)>,
    /// The points of this stage.
    pub(crate) points: Vec<Conditions>,
    /// What stands for the earlier stages, and the points that teach it.
    pub(crate) earlier: (Assembly, Vec<Conditions>),
}

/// A stage of `rijke rank`: its role, which points it adds, in words too, and which candidate stands for it in later stages.
/// The evidence has not spoken yet, so these are the paper's choices.
struct Plan {
    role: &'static str,
    needs: &'static str,
    adds: fn(&OperatingPoint) -> bool,
    stands: &'static [&'static str],
}

const PLAN: [Plan; 4] = [
    Plan {
        role: "prongs",
        needs: "the empty tube and prongs alone at two positions",
        adds: |p| p.power == 0.0 && !p.heater && !p.thermocouples,
        stands: &["prongs.6"],
    },
    Plan {
        role: "heater",
        needs: "a cold heater without thermocouples at two positions",
        adds: |p| p.power == 0.0 && p.heater && !p.thermocouples,
        stands: &["heater.3"],
    },
    Plan {
        role: "thermocouples",
        needs: "thermocouples, cold, at two positions",
        adds: |p| p.power == 0.0 && p.thermocouples,
        stands: &["thermocouples.paper"],
    },
    Plan {
        role: "heat-release",
        needs: "the heater switched on at two points",
        adds: |p| p.power > 0.0,
        stands: &[],
    },
];

/// Wall and ends, which the empty tube teaches.
const TUBE: [&str; 2] = ["wall.rayleigh", "ends.calibrated"];

/// The stages for which `points` (each with its ambient temperature, K) suffice, and what the first one that is left out needs.
pub(crate) fn stages(
    rig: &Rig,
    points: &[(OperatingPoint, f64)],
    own: &[Candidate],
) -> Result<(Vec<Stage>, Option<String>), Failure> {
    let catalogue = catalogue().or_failed()?;
    let mut stands = chosen(&catalogue, &TUBE).or_failed()?;
    let (mut stages, mut learnt): (Vec<Stage>, Vec<Conditions>) = (Vec::new(), Vec::new());
    for plan in &PLAN {
        let added: Vec<_> = points.iter().filter(|(p, _)| (plan.adds)(p)).collect();
        let conditions = added.iter().map(|(p, ambient)| conditions(rig, p, *ambient));
        let (placed, empty): (Vec<Conditions>, Vec<Conditions>) =
            conditions.collect::<Result<Vec<_>, _>>()?.into_iter().partition(|c| c.point.position.is_some());
        learnt.extend(empty);
        if learnt.is_empty() || placed.len() < 2 {
            return Ok((stages, Some(format!("{}: needs {}", plan.role, plan.needs))));
        }
        let competing = catalogue.competing(plan.role).into_iter();
        let model = |c: &Candidate| {
            let all = stands.iter().cloned().chain([c.clone()]).collect();
            Ok((c.id.clone(), Assembly::new(rig.clone(), all).or_bad_input()?))
        };
        let models = competing
            .chain(own.iter().filter(|c| c.role == plan.role))
            .map(model)
            .collect::<Result<_, Failure>>()?;
        let standing = Assembly::new(rig.clone(), stands.clone()).or_bad_input()?;
        stages.push(Stage {
            role: plan.role,
            models,
            points: placed.clone(),
            earlier: (standing, learnt.clone()),
        });
        learnt.extend(placed);
        stands.extend(chosen(&catalogue, plan.stands).or_failed()?);
    }
    Ok((stages, None))
}

/// Whether a point is of the stage in which candidates of `role` compete.
pub(crate) fn teaches(role: &str, point: &OperatingPoint) -> bool {
    PLAN.iter().any(|plan| plan.role == role && (plan.adds)(point))
}

/// The state of the gas as far as it is known before any record: cold gas at the ambient temperature; with power, the steady flow at
/// the middle of what geometry and handbooks suggest for its parameters.
fn conditions(rig: &Rig, point: &OperatingPoint, ambient: f64) -> Result<Conditions, Failure> {
    let wrong = |f: Failure| {
        f.at(std::path::Path::new(&point.id))
            .remedy("Check position and power in the campaign against the rig.")
    };
    let (Some(heater), true) = (point.position, point.power > 0.0) else {
        return Conditions::cold(rig, point.clone(), ambient, 0.0).or_bad_input().map_err(wrong);
    };
    let pipe = Pipe::new(rig, &Closures::default(), heater, 1).or_bad_input().map_err(wrong)?;
    let flow = pipe.steady(&Parameters::default(), point.power, ambient).or_bad_input().map_err(wrong)?;
    let base = flow.base_state(&pipe).checked().or_bad_input().map_err(wrong)?;
    Ok(Conditions { point: point.clone(), base, ambient })
}
