//! What can be asked of a study: a small set of questions that each exists once.

use super::{NoiseSpec, Selection};
use crate::source::listed;
use crate::{Campaign, Rig, StudyProblem};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A question, and what it is asked of.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Name of the answer.
    pub id: String,
    /// What it is called.
    pub title: String,
    /// The stage that it is asked of.
    pub stage: String,
    /// The factor along the axis, by its place in the campaign; the one with the most values if absent.
    pub over: Option<usize>,
    /// The factor that tells series apart; `row`s of the campaign if absent.
    pub series: Option<usize>,
    /// What is asked.
    pub ask: Ask,
}

/// The kinds of questions.
#[derive(Clone, Debug, PartialEq)]
pub enum Ask {
    /// Curves of a stage's competitors over a factor.
    Ranking,
    /// The posterior of the model of a stage for some sets of microphones.
    Contours {
        /// Sets of microphones, by their places; every set that holds the reference if empty.
        sets: Vec<Vec<usize>>,
    },
    /// The coefficient of one candidate, inferred at every point by itself.
    PointByPoint(Box<PointByPoint>),
    /// Predictions of the model that a stage chose.
    Prediction {
        /// The points that are predicted.
        points: Selection,
        /// The points that train; those of the stage if absent.
        trained_on: Option<Selection>,
    },
}

/// A coefficient that is free at every point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointByPoint {
    /// Role and candidate; the coefficient is the first law of the one whose role the stage's model does not
    /// have.
    pub with: BTreeMap<String, String>,
    /// Roles of the stage's model that are taken away.
    pub without: Vec<String>,
    /// Parameters held at a value.
    pub hold: BTreeMap<String, f64>,
    /// The points.
    pub points: Selection,
    /// What is assumed of the misfit.
    pub noise: NoiseSpec,
    /// Whether the errors of the base states enter.
    pub base_errors: bool,
    /// The factor by which the coefficient is divided for show.
    pub per: Option<usize>,
}

/// A question as its file has it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Asked {
    id: String,
    title: Option<String>,
    ask: String,
    stage: String,
    over: Option<String>,
    series: Option<String>,
    sets: Option<Vec<Vec<String>>>,
    with: Option<BTreeMap<String, String>>,
    without: Option<Vec<String>>,
    hold: Option<BTreeMap<String, f64>>,
    points: Option<Selection>,
    trained_on: Option<Selection>,
    noise: Option<NoiseSpec>,
    base_errors: Option<bool>,
    per: Option<String>,
}

/// For each kind the keys that it has besides those of all.
const KINDS: [(&str, &[&str]); 4] = [
    ("ranking", &[]),
    ("contours", &["sets"]),
    ("point-by-point", &["with", "without", "hold", "points", "noise", "base_errors", "per"]),
    ("prediction", &["points", "trained_on"]),
];

impl Asked {
    /// The question, every name of it checked but those of stages and candidates.
    pub(super) fn question(self, rig: &Rig, campaign: &Campaign) -> Result<Question, StudyProblem> {
        let Some((_, keys)) = KINDS.iter().find(|(kind, _)| *kind == self.ask) else {
            let known = listed(KINDS.iter().map(|(kind, _)| *kind));
            return Err(StudyProblem::Unknown { what: "kind of question", name: self.ask, known });
        };
        for (key, given) in [
            ("sets", self.sets.is_some()),
            ("with", self.with.is_some()),
            ("without", self.without.is_some()),
            ("hold", self.hold.is_some()),
            ("points", self.points.is_some()),
            ("trained_on", self.trained_on.is_some()),
            ("noise", self.noise.is_some()),
            ("base_errors", self.base_errors.is_some()),
            ("per", self.per.is_some()),
        ] {
            if given && !keys.contains(&key) {
                let name = format!("{key}` of `ask = \"{}\"", self.ask);
                return Err(StudyProblem::Unknown { what: "key", name, known: listed(keys.iter().copied()) });
            }
        }
        let factor = |name: Option<String>| name.map(|n| campaign.known_factor(&n)).transpose();
        let microphone = |name: &String| {
            let names = &rig.microphones.names;
            names.iter().position(|n| n == name).ok_or_else(|| StudyProblem::Unknown {
                what: "microphone",
                name: name.clone(),
                known: listed(names.iter().map(String::as_str)),
            })
        };
        for selection in self.points.iter().chain(&self.trained_on) {
            selection.check(campaign)?;
        }
        let ask = match self.ask.as_str() {
            "ranking" => Ask::Ranking,
            "contours" => {
                let set = |names: &Vec<String>| names.iter().map(microphone).collect::<Result<Vec<_>, _>>();
                Ask::Contours { sets: self.sets.iter().flatten().map(set).collect::<Result<_, _>>()? }
            }
            "prediction" => {
                Ask::Prediction { points: self.points.unwrap_or_default(), trained_on: self.trained_on }
            }
            _ => {
                let with = self.with.filter(|with| !with.is_empty()).ok_or(StudyProblem::Missing {
                    key: "with".into(),
                    need: "name the role and the candidate that is free at every point",
                })?;
                Ask::PointByPoint(Box::new(PointByPoint {
                    with,
                    without: self.without.unwrap_or_default(),
                    hold: self.hold.unwrap_or_default(),
                    points: self.points.unwrap_or_default(),
                    noise: self.noise.unwrap_or_default(),
                    base_errors: self.base_errors.unwrap_or_default(),
                    per: factor(self.per)?,
                }))
            }
        };
        let good = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
        if self.id.is_empty() || !self.id.chars().all(good) {
            let why = "it is also the name of files, so give letters, digits, - and _";
            return Err(StudyProblem::Name { what: "question", name: self.id, why });
        }
        Ok(Question {
            title: self.title.unwrap_or_else(|| self.id.clone()),
            id: self.id,
            stage: self.stage,
            over: factor(self.over)?,
            series: factor(self.series)?,
            ask,
        })
    }
}
