//! Candidates that compete on the same points, and which of them goes on.

use super::super::course::{CONTENDS, Chosen, Found, Run, StandsOn, Trusted};
use super::super::points::inputs::selected;
use super::super::record::{CarriedOn, ModelRecord, with_later};
use super::earlier::Earlier;
use crate::EngineError;
use crate::rows::Row;
use rayon::prelude::*;
use rijke_numerics::InOrder;
use rijke_study::plan::{Prefer, Stage};

impl Run {
    /// The rows of a stage that `wanted` takes, and what training finds of each.
    pub(in crate::run) fn competed(
        &self,
        stage: &Stage,
        wanted: &dyn Fn(&Row) -> bool,
    ) -> Result<(Vec<Row>, Vec<Found>), EngineError> {
        let points = selected(&self.study, &self.observed, &stage.points);
        if points.is_empty() && self.study.plan.grounds(stage).is_empty() {
            return Err(EngineError::no_point(&self.study, &stage.id, &stage.points));
        }
        let rows: Vec<Row> = self.rows(stage).into_iter().filter(wanted).collect();
        let mut earlier = Earlier::new(self);
        let known: Vec<_> = rows
            .iter()
            .map(|row| earlier.of(stage, &row.choice, &points))
            .collect::<Result<_, EngineError>>()?;
        let trained = |row: &Row, known: &StandsOn, trusted| {
            self.once(stage, row, trusted, || self.row(stage, row, known.clone(), trusted))
        };
        let mut results: Vec<Found> = rows
            .par_iter()
            .zip(&known)
            .map(|(row, known)| trained(row, known, Trusted::Laplace))
            .in_order::<Result<_, _>>()?;
        if self.trusted != Trusted::Laplace {
            let best = best_of(&results);
            let contends =
                |m: &ModelRecord, c: &Option<Chosen>| m.ln_evidence() >= best - CONTENDS || c.is_none();
            results = results
                .into_par_iter()
                .zip(rows.par_iter().zip(&known))
                .map(|((model, chosen), (row, known))| {
                    let again = |trusted| trained(row, known, trusted);
                    if contends(&model, &chosen) {
                        return again(self.trusted);
                    }
                    let (model, chosen) = again(Trusted::Searched)?;
                    if contends(&model, &chosen) { again(self.trusted) } else { Ok((model, chosen)) }
                })
                .in_order::<Result<_, EngineError>>()?;
        }
        Ok((rows, results))
    }
}

pub(in crate::run) fn best_of(results: &[Found]) -> f64 {
    results.iter().map(|(m, _)| m.ln_evidence()).fold(f64::NEG_INFINITY, f64::max)
}

/// The rows of most evidence and that which goes on: by the evidence of this stage, or, of those that were
/// carried on, by that of later stages too.
pub(in crate::run) fn goes_on(
    stage: &Stage,
    results: &[Found],
    carried: &[CarriedOn],
) -> Result<[usize; 2], EngineError> {
    let own = |(m, c): &Found| c.as_ref().map(|_| m.ln_evidence());
    let first = |worth: &[Option<f64>], lead: f64| {
        let best = worth.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
        worth.iter().position(|w| w.is_some_and(|w| w >= best - lead))
    };
    let alone: Vec<Option<f64>> = results.iter().map(own).collect();
    let all: Vec<Option<f64>> = results.iter().map(|(m, _)| with_later(carried, &m.id)).collect();
    let lead = match stage.prefer {
        Prefer::Leader => 0.0,
        Prefer::First => stage.decides,
    };
    if let (Some(winner), Some(next)) = (first(&alone, 0.0), first(&all, lead).or(first(&alone, lead))) {
        return Ok([winner, next]);
    }
    let why = |(m, _): &Found| Some(format!("{}: {}", m.id, m.remark.clone()?));
    let remark = results.iter().filter_map(why).collect::<Vec<_>>().join("\n  ");
    Err(EngineError::NoWinner { stage: stage.id.clone(), remark })
}
