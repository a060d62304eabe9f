//! The members of an ensemble, and their forecast.

use super::moments::{centred, column_means};
use super::{EnsembleError, forcing};
use rayon::prelude::*;
use rijke_numerics::{Matrix, Stream};

/// A set of members that stands for a distribution; and those that failed on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Ensemble {
    pub(super) members: Matrix,
    failures: Vec<Failure>,
}

/// A member whose model run failed, and was replaced.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Row of the member.
    pub member: usize,
    /// Number of the forecast in which it failed, as counted by the caller.
    pub step: usize,
    /// Why, in the model's words.
    pub reason: String,
}

impl Ensemble {
    /// An ensemble of the given rows.
    ///
    /// # Errors
    /// [`EnsembleError::TooFewMembers`] below two, [`EnsembleError::NotFinite`] for a NaN or an infinity.
    pub fn new(members: Matrix) -> Result<Self, EnsembleError> {
        if members.rows() < 2 {
            return Err(EnsembleError::TooFewMembers { have: members.rows(), need: 2 });
        }
        if let Some(i) = members.as_slice().iter().position(|v| !v.is_finite()) {
            let columns = members.columns().max(1);
            return Err(EnsembleError::NotFinite { member: i / columns, variable: i % columns });
        }
        Ok(Self { members, failures: Vec::new() })
    }

    /// `members` draws of a standard normal vector, with mean and variances as drawn (not corrected).
    ///
    /// # Errors
    /// [`EnsembleError::TooFewMembers`] below two.
    pub fn standard_normal(
        members: usize,
        variables: usize,
        stream: &mut Stream,
    ) -> Result<Self, EnsembleError> {
        Self::new(forcing::normal_matrix(members, variables, stream))
    }

    /// The members, one per row.
    #[must_use]
    pub fn members(&self) -> &Matrix {
        &self.members
    }

    /// The members, to be changed in place, for instance by adding forcing to a column.
    pub fn members_mut(&mut self) -> &mut Matrix {
        &mut self.members
    }

    /// Number of members.
    #[must_use]
    pub fn size(&self) -> usize {
        self.members.rows()
    }

    /// Mean over the members.
    #[must_use]
    pub fn mean(&self) -> Vec<f64> {
        column_means(&self.members)
    }

    /// Members minus mean.
    #[must_use]
    pub fn anomalies(&self) -> Matrix {
        centred(&self.members).1
    }

    /// Sample covariance.
    #[must_use]
    pub fn covariance(&self) -> Matrix {
        let anomalies = self.anomalies();
        let scale = 1.0 / (self.size() as f64 - 1.0);
        let mut covariance = anomalies.transpose().product(&anomalies);
        covariance.as_mut_slice().iter_mut().for_each(|v| *v *= scale);
        covariance
    }

    /// Sample standard deviation of every variable.
    #[must_use]
    pub fn spread(&self) -> Vec<f64> {
        let anomalies = self.anomalies();
        let squares = (0..anomalies.columns())
            .map(|j| (0..anomalies.rows()).map(|i| anomalies[(i, j)].powi(2)).sum::<f64>());
        squares.map(|s| (s / (self.size() as f64 - 1.0)).sqrt()).collect()
    }

    /// Members that failed so far, in order.
    #[must_use]
    pub fn failures(&self) -> &[Failure] {
        &self.failures
    }

    /// Runs `model` on every member, in parallel; what it returns is collected in the order of the members,
    /// so the result does not depend on the number of threads.
    ///
    /// A member whose run fails is put back to what it was before the run and then replaced by a draw from
    /// the survivors: their mean plus a standard normal combination of their anomalies over sqrt(N - 1),
    /// which keeps mean and covariance in expectation. Its output becomes that of `model` on the replacement.
    /// The failure is recorded under `step`.
    ///
    /// # Errors
    /// [`EnsembleError::Failed`] if more than half of the members fail, or a replacement fails as well.
    pub fn forecast<T: Send, E: std::fmt::Display + Send>(
        &mut self,
        step: usize,
        stream: &mut Stream,
        model: impl Fn(usize, &mut [f64]) -> Result<T, E> + Sync,
    ) -> Result<Vec<T>, EnsembleError> {
        self.forecast_in_groups(step, stream, 1, |i, row| vec![model(i, row)])
    }

    /// As [`Ensemble::forecast`], with a model that runs up to `group` consecutive members at once: it gets
    /// the number of the first and their rows, one after the other, and returns one result per row.
    /// Replacements run one by one.
    ///
    /// # Errors
    /// Those of [`Ensemble::forecast`], and [`EnsembleError::Shape`] if the results are not as many as the
    /// members.
    pub fn forecast_in_groups<T: Send, E: std::fmt::Display + Send>(
        &mut self,
        step: usize,
        stream: &mut Stream,
        group: usize,
        model: impl Fn(usize, &mut [f64]) -> Vec<Result<T, E>> + Sync,
    ) -> Result<Vec<T>, EnsembleError> {
        let before = self.members.clone();
        let (columns, group) = (before.columns(), group.max(1));
        let sound = |row: &[f64], run: Result<T, E>| {
            let run = run.map_err(|e| e.to_string())?;
            if row.iter().all(|v| v.is_finite()) { Ok(run) } else { Err("a value is not finite".to_string()) }
        };
        let groups: Vec<Vec<Result<T, String>>> = self
            .members
            .as_mut_slice()
            .par_chunks_mut(columns * group)
            .enumerate()
            .map(|(g, rows)| {
                let runs = model(g * group, rows);
                rows.chunks(columns).zip(runs).map(|(row, run)| sound(row, run)).collect()
            })
            .collect();
        let mut runs: Vec<Result<T, String>> = groups.into_iter().flatten().collect();
        if runs.len() != before.rows() {
            let what = "results of a forecast (one per member)";
            return Err(EnsembleError::Shape { what, expected: before.rows(), got: runs.len() });
        }
        let failed: Vec<usize> = (0..runs.len()).filter(|&i| runs[i].is_err()).collect();
        if failed.len() * 2 > runs.len() {
            let reason = runs.into_iter().find_map(Result::err).unwrap_or_default();
            return Err(EnsembleError::Failed { failed: failed.len(), members: before.rows(), step, reason });
        }
        let survivors: Vec<usize> = (0..runs.len()).filter(|i| !failed.contains(i)).collect();
        for &i in &failed {
            let mut row = forcing::draw_from(&before, &survivors, stream);
            let run = model(i, &mut row).pop();
            let rerun = run.map_or_else(|| Err("no result".to_string()), |run| sound(&row, run));
            let reason = std::mem::replace(&mut runs[i], rerun).err().unwrap_or_default();
            if runs[i].is_err() {
                return Err(EnsembleError::Failed {
                    failed: failed.len(),
                    members: before.rows(),
                    step,
                    reason,
                });
            }
            self.members.as_mut_slice()[i * columns..(i + 1) * columns].copy_from_slice(&row);
            self.failures.push(Failure { member: i, step, reason });
        }
        Ok(runs.into_iter().flatten().collect())
    }
}
