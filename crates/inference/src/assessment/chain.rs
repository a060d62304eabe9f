//! Stages in a row: what each has learnt is the prior of the next, and the evidence of all of them is one
//! number.

use super::assess::Assessment;
use crate::error::InferenceError;
use crate::evidence::{Conflict, Evidence, Offset, Tension, tension};
use crate::problem::{Parameter, Parameters};
use rijke_numerics::{Cholesky, Matrix};

/// What the stages so far have learnt, the evidence of all their data, and the priors that were declared at
/// first.
///
/// P(D1, D2) = P(D1) P(D2 | D1): the ln evidences of the stages add up to that of all data under the
/// *declared* priors, however narrow the prior is that a stage has left to the next. So a penalty that an
/// early stage paid stays in the number that ranks later ones, and [`EvidenceChain::conflict`] compares what
/// is known now with what was declared, not with what the last stage left.
///
/// The posterior of a stage is carried on as the Gaussian at its best maximum, in working coordinates.
///
/// ```
/// use rijke_inference::{AssessOptions, Data, EvidenceChain, Forward, InferenceError, Parameter, assess};
/// # fn stages(tube: &dyn Forward, d1: &Data, insert: &dyn Forward, d2: &Data, eta: Parameter, alpha: Parameter) -> Result<f64, InferenceError> {
/// let chain = EvidenceChain::default();
/// let parameters = chain.parameters(vec![eta.clone()])?;
/// let found = assess(tube, d1, &parameters, &AssessOptions::default())?;
/// let chain = chain.then("empty tube", &parameters, &found)?;
/// // Now eta has the prior that the empty tube has left; alpha has its own.
/// let parameters = chain.parameters(vec![eta, alpha])?;
/// let found = assess(insert, d2, &parameters, &AssessOptions::default())?;
/// let chain = chain.then("insert", &parameters, &found)?;
/// # Ok(
/// chain.ln_marginal() // ln P(d1, d2)
/// # )}
/// ```
#[derive(Clone, Debug, Default)]
pub struct EvidenceChain {
    stages: Vec<ChainStage>,
    /// As first declared.
    declared: Vec<Parameter>,
    /// Their joint Gaussian, in working coordinates.
    mean: Vec<f64>,
    covariance: Matrix,
}

/// One stage of a [`EvidenceChain`].
#[derive(Clone, Debug, PartialEq)]
pub struct ChainStage {
    /// Its name.
    pub name: String,
    /// The evidence of its data, given those of the stages before it.
    pub evidence: Evidence,
    /// Its conflict with declared and carried priors.
    pub conflict: Conflict,
}

impl EvidenceChain {
    /// The parameters of the next stage: of those that earlier stages have met the declared prior is the one
    /// of then, and what was learnt stands in its place; the others keep their own.
    ///
    /// # Errors
    /// Those of [`Parameters::new`] and [`Parameters::with_joint`].
    pub fn parameters(&self, list: Vec<Parameter>) -> Result<Parameters, InferenceError> {
        let first = |p: Parameter| self.declared.iter().find(|d| d.name == p.name).cloned().unwrap_or(p);
        let parameters = Parameters::new(list.into_iter().map(first).collect())?;
        let (known, _) = self.shared(&parameters);
        if known.is_empty() {
            return Ok(parameters);
        }
        let names: Vec<&str> = known.iter().map(|&k| self.declared[k].name.as_str()).collect();
        let mean: Vec<f64> = known.iter().map(|&k| self.mean[k]).collect();
        parameters.with_joint(&names, &mean, &self.covariance.select(&known))
    }

    /// The chain with one stage more, whose `parameters` came from [`EvidenceChain::parameters`]. What was
    /// learnt of parameters that this stage does not have is brought up to date by their correlations with
    /// those that it has.
    ///
    /// # Errors
    /// [`InferenceError::NoStage`] if the stage has no evidence, [`InferenceError::Dense`].
    pub fn then(
        &self,
        name: &str,
        parameters: &Parameters,
        found: &Assessment,
    ) -> Result<Self, InferenceError> {
        let none =
            |reason: &String| InferenceError::NoStage { stage: name.to_owned(), reason: reason.clone() };
        let evidence = *found.evidence.as_ref().map_err(none)?;
        let laplace = found.laplace.as_ref().map_err(none)?;
        let p = parameters.len();
        // Places of the shared parameters in the chain and in the stage.
        let (known, here) = self.shared(parameters);
        let fresh: Vec<usize> = (0..p).filter(|i| !here.contains(i)).collect();
        let old = self.declared.len();
        let mut next = self.clone();
        next.declared.extend(fresh.iter().map(|&i| parameters.list()[i].clone()));
        let place = |i: usize| match here.iter().position(|&h| h == i) {
            Some(k) => known[k],
            None => old + fresh.iter().position(|&f| f == i).unwrap_or(0),
        };
        let size = next.declared.len();
        next.mean.resize(size, 0.0);
        let mut covariance = Matrix::zeros(size, size);
        for i in 0..p {
            next.mean[place(i)] = laplace.mean[i];
            for j in 0..p {
                covariance[(place(i), place(j))] = laplace.covariance[(i, j)];
            }
        }
        let absent: Vec<usize> = (0..old).filter(|k| !known.contains(k)).collect();
        if !absent.is_empty() {
            // An absent parameter is B times the known ones plus a rest that this stage says nothing of.
            let before = self.covariance.select(&known);
            let factor = Cholesky::new(&before)?;
            let b: Vec<Vec<f64>> = absent
                .iter()
                .map(|&r| factor.solve(&known.iter().map(|&k| self.covariance[(r, k)]).collect::<Vec<_>>()))
                .collect();
            let b = Matrix::from_fn(absent.len(), known.len(), |r, k| b[r][k]);
            let moved: Vec<f64> = known.iter().map(|&k| next.mean[k] - self.mean[k]).collect();
            for (&r, shift) in absent.iter().zip(b.times(&moved)) {
                next.mean[r] += shift;
            }
            let change = covariance.select(&known).plus(-1.0, &before);
            let own = b.product(&change).product(&b.transpose());
            for (r, &i) in absent.iter().enumerate() {
                for (s, &j) in absent.iter().enumerate() {
                    covariance[(i, j)] = self.covariance[(i, j)] + own[(r, s)];
                }
                for q in 0..p {
                    let with: f64 =
                        (0..known.len()).map(|k| b[(r, k)] * laplace.covariance[(here[k], q)]).sum();
                    covariance[(i, place(q))] = with;
                    covariance[(place(q), i)] = with;
                }
            }
        }
        next.covariance = covariance;
        next.stages.push(ChainStage { name: name.to_owned(), evidence, conflict: found.conflict.clone() });
        Ok(next)
    }

    /// ln of the evidence of all data so far under the declared priors, nats.
    #[must_use]
    pub fn ln_marginal(&self) -> f64 {
        self.stages.iter().map(|s| s.evidence.ln_marginal).sum()
    }

    /// The stages, in order.
    #[must_use]
    pub fn stages(&self) -> &[ChainStage] {
        &self.stages
    }

    /// Every parameter met so far, with the prior that it was declared with.
    #[must_use]
    pub fn declared(&self) -> &[Parameter] {
        &self.declared
    }

    /// What is known of them now: mean and covariance in working coordinates.
    #[must_use]
    pub fn known(&self) -> (&[f64], &Matrix) {
        (&self.mean, &self.covariance)
    }

    /// How far what is known now lies from the declared priors.
    ///
    /// # Errors
    /// [`InferenceError::Dense`] if the covariance cannot be decomposed.
    pub fn conflict(&self) -> Result<Conflict, InferenceError> {
        let scores: Vec<[f64; 2]> = self.declared.iter().zip(&self.mean).map(|(q, &z)| q.score(z)).collect();
        let offsets = self.declared.iter().zip(&self.mean).zip(&scores).map(|((q, &z), score)| Offset {
            parameter: q.name.clone(),
            unit: q.unit.clone(),
            value: q.physical(z)[0],
            sds: score[0],
            carried_sds: None,
        });
        let xi: Vec<f64> = scores.iter().map(|s| s[0]).collect();
        let slopes: Vec<f64> = scores.iter().map(|s| s[1]).collect();
        let declared = tension(&xi, &Matrix::diagonal(&slopes), &self.covariance)?;
        Ok(Conflict { offsets: offsets.collect(), declared, carried: Tension::default() })
    }

    /// The places of the parameters that both know, in the chain and in `parameters`.
    fn shared(&self, parameters: &Parameters) -> (Vec<usize>, Vec<usize>) {
        let both = parameters
            .list()
            .iter()
            .enumerate()
            .filter_map(|(i, p)| Some((self.declared.iter().position(|d| d.name == p.name)?, i)));
        both.unzip()
    }
}
