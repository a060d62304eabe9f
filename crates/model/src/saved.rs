//! A trained model on disk: everything that a prediction needs.

use crate::{Assembly, Conditions, Knowledge, ModelError, PointPrediction, Scheme, Trained};
use rijke_candidates::{Candidate, Coefficient, Effect, Formula, Place, Scope};
use rijke_inference::{Evidence, NoiseEstimate, Parameter};
use rijke_numerics::Matrix;
use rijke_rig::{DataKind, Rig};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

/// A trained model: rig, candidates with their laws, parameters with covariance, evidence, and where it comes from.
///
/// Predicts growth rate, frequency and mode shape with their uncertainty at any operating point whose base flow is known
/// ([`SavedModel::predict`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedModel {
    /// Whether the data that trained it were measured.
    pub kind: DataKind,
    /// What the records say of their own origin.
    pub source: String,
    /// Operating points of the last stage of training.
    pub trained_on: Vec<String>,
    /// The rig.
    pub rig: Rig,
    /// How losses along the tube are discretised.
    pub scheme: Scheme,
    /// One candidate per role.
    pub candidates: Vec<SavedCandidate>,
    /// Parameters held at a value.
    pub fixed: Vec<(String, f64)>,
    /// Names of the free parameters.
    pub names: Vec<String>,
    /// Their most probable values.
    pub mean: Vec<f64>,
    /// Their covariance, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// Noise and model error of growth rate, angular frequency and relative pressures, and what the points of one setting of the
    /// rig share ([`crate::Misfit`] joins them).
    pub noise: Vec<NoiseEstimate>,
    /// Evidence of the last stage, nats.
    pub evidence: Evidence,
}

/// A candidate whose laws are text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedCandidate {
    /// Unique name.
    pub id: String,
    /// The component that it models.
    pub role: String,
    /// What it is called.
    pub name: String,
    /// Where it comes from.
    pub cite: Vec<String>,
    /// Anything else.
    pub note: String,
    /// Parameters with the priors of the catalogue.
    pub parameters: Vec<Parameter>,
    /// Place, coefficient, formula.
    pub effects: Vec<(Place, Coefficient, String)>,
}

impl SavedModel {
    /// The model `assembly` as `trained` on the points `trained_on`.
    #[must_use]
    pub fn new(
        assembly: &Assembly,
        trained: &Trained,
        trained_on: Vec<String>,
        kind: DataKind,
        source: String,
    ) -> Self {
        let Knowledge { mut names, mut mean, covariance } = trained.knowledge();
        names.truncate(trained.own);
        mean.truncate(trained.own);
        let effect = |e: &Effect| (e.place, e.coefficient, e.law.text());
        let saved = |c: &Candidate| SavedCandidate {
            id: c.id.clone(),
            role: c.role.clone(),
            name: c.name.clone(),
            cite: c.cite.clone(),
            note: c.note.clone(),
            parameters: c.parameters.clone(),
            effects: c.effects.iter().map(effect).collect(),
        };
        Self {
            kind,
            source,
            trained_on,
            rig: assembly.rig.clone(),
            scheme: assembly.scheme,
            candidates: assembly.candidates().iter().map(saved).collect(),
            fixed: assembly.held(),
            names,
            mean,
            covariance: (0..trained.own).map(|i| covariance.row(i)[..trained.own].to_vec()).collect(),
            noise: trained.noise.clone(),
            evidence: trained.evidence,
        }
    }

    /// Reads the file that [`SavedModel::write`] wrote.
    ///
    /// # Errors
    /// [`ModelError::File`] with the file and what is wrong in it; a formula that is not one is found here, not later.
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        let problem =
            |e: &dyn std::fmt::Display| ModelError::File { file: path.to_path_buf(), problem: e.to_string() };
        let text = std::fs::read_to_string(path).map_err(|e| problem(&e))?;
        let saved: Self = serde_json::from_str(&text).map_err(|e| problem(&e))?;
        saved.assembly().map_err(|e| problem(&e))?;
        let n = saved.names.len();
        if saved.mean.len() != n
            || saved.covariance.len() != n
            || saved.covariance.iter().any(|r| r.len() != n)
        {
            return Err(problem(&format!("{n} names, but another number of means or covariances")));
        }
        Ok(saved)
    }

    /// Writes the model as JSON.
    ///
    /// # Errors
    /// [`ModelError::File`].
    pub fn write(&self, path: &Path) -> Result<(), ModelError> {
        let problem =
            |e: &dyn std::fmt::Display| ModelError::File { file: path.to_path_buf(), problem: e.to_string() };
        let text = serde_json::to_string_pretty(self).map_err(|e| problem(&e))?;
        std::fs::write(path, text + "\n").map_err(|e| problem(&e))
    }

    /// The model with its laws.
    ///
    /// # Errors
    /// [`ModelError::Formula`] and those of [`Assembly::new`].
    pub fn assembly(&self) -> Result<Assembly, ModelError> {
        let candidates = self.candidates.iter().map(SavedCandidate::candidate).collect::<Result<_, _>>()?;
        let assembly = Assembly::new(self.rig.clone(), candidates)?.with_scheme(self.scheme);
        self.fixed.iter().try_fold(assembly, |a, (name, value)| a.fixed(name, *value))
    }

    /// What is known of the free parameters.
    #[must_use]
    pub fn knowledge(&self) -> Knowledge {
        let n = self.names.len();
        Knowledge {
            names: self.names.clone(),
            mean: self.mean.clone(),
            covariance: Matrix::from_fn(n, n, |i, j| self.covariance[i][j]),
        }
    }

    /// Growth rate, angular frequency and relative pressures of `microphones` (the reference among them) at an operating
    /// point, in a new setting of the rig, with the covariances that parameters and base flow cause.
    ///
    /// # Errors
    /// Those of the model.
    pub fn predict(
        &self,
        conditions: &Conditions,
        microphones: &[usize],
    ) -> Result<PointPrediction, ModelError> {
        self.knowledge().at_a_new_setting(&self.noise).predict(
            &self.assembly()?,
            conditions,
            microphones,
            None,
        )
    }
}

impl SavedCandidate {
    fn candidate(&self) -> Result<Candidate, ModelError> {
        let names: Vec<String> = self.parameters.iter().map(|p| p.name.clone()).collect();
        let effect = |(place, coefficient, text): &(Place, Coefficient, String)| {
            let (place, coefficient) = (*place, *coefficient);
            let formula = Formula::parse(text, &Scope { parameters: &names, place, coefficient })?;
            Ok(Effect { place, coefficient, law: Arc::new(formula) })
        };
        let effects =
            self.effects.iter().map(effect).collect::<Result<Vec<_>, rijke_candidates::FormulaError>>();
        Ok(Candidate {
            id: self.id.clone(),
            role: self.role.clone(),
            name: self.name.clone(),
            cite: self.cite.clone(),
            note: self.note.clone(),
            parameters: self.parameters.clone(),
            effects: effects.map_err(|source| ModelError::Formula {
                candidate: self.id.clone(),
                source: Box::new(source),
            })?,
        })
    }
}
