//! `study.toml`: the stages of a study and its questions.
//!
//! Knows the words of the file, and not what a stage finds.

mod base;
mod exact;
mod idle;
mod ids;
mod maps;
mod noise;
mod questions;
mod read;
mod select;
mod stands;
mod suits;

pub use maps::{MapGrid, MapQuestion};
pub use noise::{NoiseSpec, PlannedLawError, PlannedVarying, SdSpec};
pub use questions::{Question, fields_of};
pub use select::{Condition, Selection};

use crate::{Candidate, Catalogue};
use std::collections::{BTreeMap, BTreeSet};

/// What is asked of a rig, in which order.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What the study is called.
    pub name: String,
    /// The question that it answers.
    pub question: String,
    /// Where the state of the gas comes from.
    pub base: Base,
    /// The stages; each stands on earlier ones only.
    pub stages: Vec<Stage>,
    /// Stages that train on responses; they run before those of modes, which may stand on them.
    pub responses: Vec<crate::responses::ResponseStage>,
    /// What is asked of the stages.
    pub questions: Vec<Question>,
    /// Maps of stability that are drawn.
    pub maps: Vec<MapQuestion>,
    /// What a further measurement costs, if that is stated.
    pub cost: Option<Cost>,
    /// Factors whose errors all points share, each in proportion to its standard deviation: one meter.
    pub common_errors: Vec<String>,
}

/// Time that further measurements take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// To set, to settle and to record one operating point, s.
    pub point: f64,
    /// To mount one installation, which all its points share, s.
    pub installation: f64,
}

/// Where the state of the gas comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Base {
    /// Everywhere the ambient temperature.
    #[default]
    Ambient,
    /// The temperatures of the rig's ducts, and the ambient one where they have none.
    Rig,
    /// States that were inferred before, of these points; the others have the ambient temperature and no
    /// flow.
    States(Selection),
    /// Gas that a part heats in a forced flow, from readings of thermometers in `observations/readings.csv`.
    HeatedFlow(HeatedFlow),
    /// Gas as thermometers read it, in a forced flow or at rest.
    Measured(MeasuredGas),
}

/// Temperatures as the thermometers of `observations/readings.csv` read them, linear between their places;
/// the ambient one at points without readings.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredGas {
    /// The factor that is the volume flow from upstream, m^3/s, at the temperature of the inlet; none: at
    /// rest.
    #[serde(default)]
    pub flow: Option<String>,
    /// Standard deviation of what all thermometers read too much, K.
    #[serde(default)]
    pub offset_sd: f64,
}

/// A part that heats a forced flow.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeatedFlow {
    /// The part where the heat goes into the gas.
    pub at: String,
    /// The factor that is its power, W.
    pub power: String,
    /// The factor that is the volume flow from upstream at ambient temperature, m^3/s.
    pub flow: String,
    /// Share of the power that goes into the gas, before the readings: mean and standard deviation.
    #[serde(default = "share")]
    pub share: [f64; 2],
    /// Coefficient of heat transfer to the wall downstream of the part, W/(m^2 K), before the readings: mean
    /// and standard deviation.
    #[serde(default = "cooling")]
    pub cooling: [f64; 2],
    /// By how much, relative, the heat transfer may differ from one constant: just downstream of the part,
    /// for twice the flow, and for twice the rise of the gas. 0: one constant.
    #[serde(default = "cooling_varies")]
    pub cooling_varies: f64,
    /// Standard deviation of what all thermometers read too much, and of what each one does besides, K; as
    /// large as the stated errors of the readings, if absent.
    #[serde(default)]
    pub offset_sd: Option<f64>,
    /// Standard deviation of what all thermometers read too much as a share of the excess of the gas over the
    /// ambient temperature (radiation, conduction along the stem).
    #[serde(default)]
    pub excess_sd: f64,
}

/// Some points train some candidates.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Its name.
    pub id: String,
    /// What it is called in tables.
    pub title: String,
    /// The points that train.
    pub points: Selection,
    /// Earlier stages, of modes or of responses, whose posterior it takes for known.
    pub on: Vec<String>,
    /// Earlier stages whose delays and gains of channels are taken for known, besides those of `on`.
    pub heard_through: Vec<String>,
    /// Role and candidate: what the model consists of, besides what competes.
    pub with: BTreeMap<String, String>,
    /// Roles of earlier stages that are not part of this one.
    pub without: Vec<String>,
    /// The roles whose candidates compete, in all combinations; none for a stage that trains one model.
    pub compete: Vec<String>,
    /// Which of them, in the order of the table; all if empty.
    pub among: Vec<String>,
    /// Further rows: candidates that take the places of others together.
    pub rows: Vec<Vec<String>>,
    /// Parameters held at a value.
    pub hold: BTreeMap<String, f64>,
    /// A lead in nats below which the evidence does not decide.
    pub decides: f64,
    /// Which row goes on where it does not.
    pub prefer: Prefer,
    /// What is assumed of the misfit.
    pub noise: NoiseSpec,
    /// As `noise`, for the model that goes on: what enters predictions but must not enter a comparison.
    pub noise_of_predictions: Option<NoiseSpec>,
    /// Whether the errors of the base states enter.
    pub base_errors: bool,
    /// Whether delays and gains of the channels are found together with the model.
    pub channels: bool,
    /// Only these microphones; all if empty.
    pub microphones: Vec<String>,
}

/// Which of the rows between which the evidence does not decide goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Prefer {
    /// The one with the most evidence.
    #[default]
    Leader,
    /// The first of the table: write the simpler ones first.
    First,
}

/// Radiation and holders take a tenth or so.
fn share() -> [f64; 2] {
    [0.9, 0.15]
}

/// Laminar to mixed convection in a tube of a few centimetres.
fn cooling() -> [f64; 2] {
    [5.0, 3.0]
}

/// A laminar stream that was heated afresh loses 1.5 times as much heat 5 diameters on as 20 diameters on;
/// for twice the flow, powers of 0 to 0.8 make factors of 1 to 1.7.
fn cooling_varies() -> f64 {
    0.4
}

impl Stage {
    /// Whether the stage uses the microphone of this name.
    #[must_use]
    pub fn hears(&self, microphone: &String) -> bool {
        self.microphones.is_empty() || self.microphones.contains(microphone)
    }
}

impl Plan {
    /// The roles that stages and questions name, and the candidates that are part of no model because nothing
    /// names theirs.
    pub(crate) fn unused<'a>(&self, catalogue: &'a Catalogue) -> (BTreeSet<&str>, Vec<&'a Candidate>) {
        let mut roles: BTreeSet<&str> = BTreeSet::new();
        let mut ids: BTreeSet<&str> = BTreeSet::new();
        for stage in &self.stages {
            roles.extend(stage.with.keys().chain(&stage.compete).map(String::as_str));
            ids.extend(stage.rows.iter().flatten().map(String::as_str));
        }
        for stage in &self.responses {
            roles.extend(stage.with.keys().chain(&stage.compete).map(String::as_str));
        }
        for question in &self.questions {
            roles.extend(question.with.keys().map(String::as_str));
        }
        let used = |c: &&Candidate| roles.contains(&*c.role) || ids.contains(&*c.id);
        let unused = catalogue.candidates().iter().filter(|c| !used(c)).collect();
        (roles, unused)
    }

    /// The stages of responses on which a stage of modes stands, by itself or through others; one that is
    /// reached twice stands twice.
    #[must_use]
    pub fn grounds(&self, stage: &Stage) -> Vec<&str> {
        let below = |id: &String| match self.stage(id) {
            Some((_, other)) => self.grounds(other),
            None => self.response(id).map(|r| r.id.as_str()).into_iter().collect(),
        };
        stage.on.iter().flat_map(below).collect()
    }

    /// The stage of responses called `id`.
    #[must_use]
    pub fn response(&self, id: &str) -> Option<&crate::responses::ResponseStage> {
        self.responses.iter().find(|r| r.id == id)
    }

    /// The names of everything that has an answer: stages of modes and of responses, questions, maps.
    pub fn answers(&self) -> impl Iterator<Item = &String> {
        let (stages, questions) = (self.stages.iter(), self.questions.iter());
        let stages = stages.map(|s| &s.id).chain(self.responses.iter().map(|s| &s.id));
        stages.chain(questions.map(|q| &q.id)).chain(self.maps.iter().map(|m| &m.id))
    }

    /// Takes out the stages of modes after the one in this place, and what is asked of them.
    pub fn end_after(&mut self, place: usize) {
        self.stages.truncate(place + 1);
        let left: BTreeSet<&str> = self.stages.iter().map(|s| s.id.as_str()).collect();
        self.questions.retain(|question| left.contains(question.stage.as_str()));
        self.maps.retain(|map| left.contains(map.stage.as_str()));
    }

    /// The stage of modes called `id`, with its place.
    #[must_use]
    pub fn stage(&self, id: &str) -> Option<(usize, &Stage)> {
        self.stages.iter().enumerate().find(|(_, s)| s.id == id)
    }
}
