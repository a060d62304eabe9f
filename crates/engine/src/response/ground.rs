//! What stages of responses found, for the stages of modes that stand on them: their posteriors are priors
//! there, their evidence counts, and so does the misfit of the laws that they measured.

use super::measured::Measured;
use super::predict::Load;
use super::record::{ResponseModelRecord, ResponseStageRecord};
use super::{LENGTH_OF_MISFIT, MISFIT, NOISE};
use crate::gaussian::{LARGEST, is_covariance};
use crate::noise::{Added, LawError};
use crate::run::EvidenceRecord;
use crate::told::reasons;
use crate::{EngineError, NamedGaussian};
use rijke_inference::{Maximum, NoiseEstimate};
use rijke_numerics::Matrix;
use rijke_study::responses::ResponseKind;
use rijke_study::{Cause, Study};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The most models of a stage of responses that are carried on.
const MOST: usize = 8;
/// Maxima with less of the evidence than this share are not carried on: 12 nats.
const LEAST_SHARE: f64 = 6e-6;

/// A stage of responses that has run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Its name.
    pub id: String,
    /// What it is called.
    pub title: String,
    /// Nats below which a lead does not decide.
    pub decides: f64,
    /// Its models that could be fitted, the most evidence first; never none.
    pub models: Vec<GroundModel>,
    /// First and last frequency of the laws that it measured by themselves, Hz; none if it measured none.
    pub band_hz: Option<[f64; 2]>,
    /// What the stages of responses on which it stands took for certain, though they do not decide it.
    pub assumes: Vec<String>,
}

/// A model of such a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroundModel {
    /// As its table calls it.
    pub id: String,
    /// Role and candidate, measuring heads among them.
    pub candidates: BTreeMap<String, String>,
    /// Its evidence.
    pub evidence: EvidenceRecord,
    names: Vec<String>,
    mean: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    /// The share of the evidence that this maximum has of all, 0..1.
    #[serde(default = "all")]
    share: f64,
    /// The others that are not improbable.
    #[serde(default)]
    beside: Vec<GroundMaximum>,
    /// The misfit of a law that was measured by itself, as an error of that law.
    pub law: Option<LawError>,
    /// What was said of it where its residuals are no noise, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
    /// The share of its data that it leaves, 0..1, where it does not describe them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub undescribed: Option<f64>,
}

/// A further maximum of the posterior of such a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct GroundMaximum {
    /// Its share of the evidence of all, 0..1.
    share: f64,
    mean: Vec<f64>,
    covariance: Vec<Vec<f64>>,
}

/// What a row found that stages after it need.
pub(super) struct Learned {
    /// The best maximum of the posterior.
    pub(super) known: NamedGaussian,
    /// The causes of error among its parameters.
    pub(super) causes: Vec<Cause>,
    /// Its share of the evidence of all, 0..1.
    pub(super) share: f64,
    /// The others.
    pub(super) beside: Vec<GroundMaximum>,
    /// The misfit of its law.
    pub(super) law: Option<LawError>,
    /// The share of its data that it leaves, where it does not describe them.
    pub(super) undescribed: Option<f64>,
    /// The share of the variance of every number that the fit left to its residual, load after load; empty
    /// where no noise is asked for.
    pub(super) left: Vec<f64>,
    /// The share of the data that the residuals are, where they are small but no noise.
    pub(super) nearly_right: Option<f64>,
}

fn all() -> f64 {
    1.0
}

fn rows_of(matrix: &Matrix, n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|i| (0..n).map(|j| matrix[(i, j)]).collect()).collect()
}

impl GroundMaximum {
    /// Of a maximum that was found, unless it is improbable or has no covariance; `names` are those of the
    /// parameters.
    pub(super) fn of(names: &[String], found: &Maximum) -> Option<Self> {
        let laplace = found.laplace.as_ref().ok().filter(|_| found.share > LEAST_SHARE)?;
        let covariance = rows_of(&laplace.physical_covariance, names.len());
        Some(Self { share: found.share, mean: found.fit.parameters.clone(), covariance })
    }
}

impl Ground {
    /// Of a stage and what was learned of each of its models, in its order; `assumes` are what it stands on.
    pub(super) fn of(stage: &ResponseStageRecord, found: Vec<Option<Learned>>, assumes: Vec<String>) -> Self {
        let model = |(m, found): (&ResponseModelRecord, Option<Learned>)| {
            let Learned { known, share, beside, law, undescribed, .. } = found?;
            let n = known.names.len();
            Some(GroundModel {
                id: m.id.clone(),
                candidates: m.candidates.clone(),
                evidence: m.evidence?,
                covariance: rows_of(&known.covariance, n),
                share,
                beside,
                names: known.names,
                mean: known.mean,
                law,
                undescribed,
                doubts: reasons(&m.remark).filter(|_| m.too_sure).map(str::to_owned).collect(),
            })
        };
        let mut models: Vec<GroundModel> = stage.models.iter().zip(found).filter_map(model).collect();
        models.sort_by(|a, b| b.evidence.ln_marginal.total_cmp(&a.evidence.ln_marginal));
        let (id, title) = (stage.id.clone(), stage.title.clone());
        let laws = stage.loads.iter().filter(|l| l.what == "law");
        let ends = laws.filter_map(|l| Some([*l.frequency_hz.first()?, *l.frequency_hz.last()?]));
        let band_hz = ends.reduce(|[a, b], [low, high]| [a.min(low), b.max(high)]);
        Self { id, title, decides: stage.decides, models, band_hz, assumes }
    }

    /// The models that its evidence leaves open, the best first.
    pub(crate) fn open(&self) -> impl Iterator<Item = &GroundModel> {
        let best = self.models.first().map_or(0.0, |m| m.evidence.ln_marginal);
        self.models.iter().take_while(move |m| m.evidence.ln_marginal >= best - self.decides).take(MOST)
    }

    /// The best model that agrees with `choice` in all roles that both have.
    ///
    /// # Errors
    /// [`EngineError::Refused`] for `stage` if it trained none.
    pub(crate) fn with(
        &self,
        choice: &BTreeMap<String, String>,
        stage: &str,
    ) -> Result<&GroundModel, EngineError> {
        let agrees = |m: &&GroundModel| {
            m.candidates.iter().all(|(role, id)| choice.get(role).is_none_or(|other| other == id))
        };
        self.models.iter().find(agrees).ok_or_else(|| {
            let names = choice.values().map(String::as_str).collect::<Vec<_>>().join(" + ");
            let problem = format!(
                "it stands on `{}`, where no model of {names} could be trained: let these candidates compete there, or leave them out here",
                self.id
            );
            EngineError::Refused { stage: stage.to_owned(), problem }
        })
    }

    /// How probable other maxima of the posterior of its best model are.
    pub(crate) fn other_maxima(&self) -> Option<String> {
        let share = self.models.first().map_or(0.0, |m| m.beside.iter().map(|m| m.share).sum::<f64>());
        (share > 1e-3).then(|| {
            format!("the predictions are those of the most probable maximum of the posterior; other maxima have a probability of {share:.3}")
        })
    }

    /// That the model which agrees with `choice` does not describe the data of this stage, in a sentence
    /// without its stop; `goes_on` if its misfit is an error of a law later.
    pub(crate) fn undescribed(&self, choice: &BTreeMap<String, String>) -> Option<String> {
        let model = self.with(choice, "").ok()?;
        let share = 100.0 * model.undescribed?;
        let law = model.law.as_ref().filter(|law| choice.contains_key(&law.role));
        let goes_on = law.map_or(String::new(), |law| {
            format!("; here this misfit counts as an error of the law of `{}`, so these modes determine little of it", law.role)
        });
        Some(format!(
            "this stage stands on \"{}\", whose data {} does not describe: its residuals are {share:.0} % of them{goes_on}. Correct that stage first",
            self.title, model.id
        ))
    }

    /// What is taken for certain though its evidence does not decide it, if `chosen` goes on.
    pub(crate) fn undecided(&self, chosen: &GroundModel) -> Option<String> {
        let at = chosen.evidence.ln_marginal;
        let others = self.models.iter().filter(|m| m.id != chosen.id);
        let other = others.max_by(|a, b| a.evidence.ln_marginal.total_cmp(&b.evidence.ln_marginal))?;
        let behind = at - other.evidence.ln_marginal;
        let (only, side) = if behind < 0.0 { ("", "ahead") } else { ("only ", "behind") };
        let place = format!("{only}{:.1} nats {side}", behind.abs());
        (behind < self.decides)
            .then(|| format!("Stage \"{}\" takes {}, and {} is {place}", self.title, chosen.id, other.id))
    }
}

impl GroundModel {
    /// Its posterior: the maxima that are not improbable, the best first, each with its share.
    ///
    /// # Errors
    /// [`EngineError::Damaged`] if its lists do not fit together.
    pub(crate) fn maxima(&self, stage: &str) -> Result<Vec<(f64, NamedGaussian)>, EngineError> {
        let n = self.names.len();
        let gaussian = |share: f64, mean: &[f64], covariance: &[Vec<f64>]| {
            let whole = mean.len() == n
                && covariance.len() == n
                && mean.iter().all(|v| v.abs() <= LARGEST)
                && is_covariance(covariance);
            if !whole {
                return Err(EngineError::Damaged { stage: stage.to_owned() });
            }
            let covariance = Matrix::from_fn(n, n, |i, j| covariance[i][j]);
            Ok((share, NamedGaussian { names: self.names.clone(), mean: mean.to_vec(), covariance }))
        };
        let best = gaussian(self.share, &self.mean, &self.covariance);
        let others = self.beside.iter().map(|m| gaussian(m.share, &m.mean, &m.covariance));
        std::iter::once(best).chain(others).collect()
    }
}

/// The misfit of a law that was measured by itself, as an error that is added to that law: of every response
/// what correlates along frequency, and noise that the data chose, of which nobody said that it is the
/// measurement's, at each frequency as large as it is in `measured`. None for responses that are of no law,
/// or where there is no such misfit.
pub(super) fn law_error(
    study: &Study,
    candidates: &BTreeMap<String, String>,
    loads: &[Load<'_>],
    measured: &[Measured],
    noise: &[NoiseEstimate],
) -> Option<LawError> {
    let of_group = |name: &str| noise.iter().find(|n| n.name == name);
    let misfit = of_group(MISFIT).map_or(0.0, |n| n.sd * n.sd);
    let floated = of_group(NOISE).filter(|n| n.floats).map_or(0.0, |n| n.sd * n.sd);
    let correlated = noise.iter().find(|n| n.name == LENGTH_OF_MISFIT).map(|n| n.sd);
    let of = |(load, m): (&Load<'_>, &Measured)| {
        let ResponseKind::Law { at, coefficient, factor } = &load.what else { return None };
        let of_it = |id: &String| {
            let candidate = study.catalogue.get(id)?;
            let effect =
                candidate.effects.iter().find(|e| e.coefficient == *coefficient && e.place == *at)?;
            Some((candidate.role.clone(), effect.place_text.clone()))
        };
        let (role, place) = candidates.values().find_map(of_it)?;
        let variance: Vec<f64> = (0..m.values.len()).map(|i| misfit + floated * m.factor(i)).collect();
        let mean = variance.iter().sum::<f64>() / variance.len().max(1) as f64;
        let sd = mean.sqrt() / factor.real(&load.model.numbers).abs();
        // Of noise that does not correlate, neighbouring frequencies are apart.
        let f = &load.frequency_hz;
        let step = (f.last()? - f.first()?) / (f.len().max(2) - 1) as f64;
        let length_hz = correlated.unwrap_or(step).max(f64::MIN_POSITIVE);
        let along = f.iter().zip(&variance).map(|(f, v)| [*f, (v / mean).sqrt()]);
        let along = if m.factor.is_empty() { Vec::new() } else { along.collect() };
        let added = Added { coefficient: coefficient.name().to_owned(), place, length_hz, along };
        (sd > 0.0 && sd.is_finite()).then_some(LawError { role, sd, over: None, added: Some(added) })
    };
    loads.iter().zip(measured).filter_map(of).max_by(|a, b| a.sd.total_cmp(&b.sd))
}
