//! A trained model point by point: how well it foresees each from all others, and whether the residuals are
//! as large as its noise says.

use super::course::{Chosen, Run};
use super::found::{Checks, PointCheck, SumCheck};
use crate::EngineError;
use rayon::prelude::*;
use rijke_numerics::Streams;
use rijke_study::plan::Stage;

/// Shift of the parameters from which on a linearised density is doubted.
const FAR: f64 = 1.0;

/// Data sets that are drawn.
const DRAWS: usize = 1000;

/// A number of the data that trained a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datum {
    /// Which of the observations that trained.
    pub observation: usize,
    /// Its row in the prediction of that observation: 0 growth rate, 1 angular frequency, then real and
    /// imaginary parts of relative pressures.
    pub row: usize,
}

impl Chosen {
    /// ln of the density of each number of the data ([`Run::data_of`]) given all others and these physical
    /// parameters, errors of base states and channels among them: for leave-one-out by draws. Errors that
    /// data share count; noise is as fitted, and the prediction linear about the fit. None where a parameter
    /// lies at or beyond its bound.
    #[must_use]
    pub fn ln_densities(&self, values: &[f64]) -> Option<Vec<f64>> {
        let trained = &self.trained;
        if values.len() != trained.parameters.len() {
            return None;
        }
        let fit = trained.values.iter().zip(values);
        let moved: Vec<f64> =
            trained.parameters.iter().zip(fit).map(|(p, (at, v))| p.working(*v) - p.working(*at)).collect();
        moved.iter().all(|m| m.is_finite()).then(|| trained.linear.0.ln_densities(&moved))
    }
}

impl Run {
    /// What the numbers of the data are that trained `chosen` in the stage called `id`, in the order of
    /// [`Chosen::ln_densities`]; none without such a stage.
    #[must_use]
    pub fn data_of(&self, id: &str, chosen: &Chosen) -> Option<Vec<Datum>> {
        let stage = self.study.plan.stages.iter().find(|s| s.id == id)?;
        let rows = chosen.rows(&chosen.used(&self.rig, stage));
        Some(rows.into_iter().map(|(observation, row)| Datum { observation, row }).collect())
    }

    /// The checks of the model that goes on, and of its rival.
    ///
    /// # Errors
    /// Those of the inference.
    pub(super) fn checks(
        &self,
        stage: &Stage,
        chosen: &Chosen,
        rival: Option<(&str, &Chosen)>,
    ) -> Result<Checks, EngineError> {
        let rows_of = |chosen: &Chosen| chosen.rows(&chosen.used(&self.rig, stage));
        let rows = rows_of(chosen);
        let others = rival.map(|(_, rival)| (rival, rows_of(rival)));
        let linear = &chosen.trained.linear.0;
        let mut residuals = vec![[None; 2]; chosen.observed.len()];
        let mut points: Vec<PointCheck> = Vec::new();
        let mut ids: Vec<&String> = Vec::new();
        for observed in chosen.observed.iter() {
            // The modes of a point may stand anywhere among those of others.
            let id = &observed.conditions.id;
            if ids.contains(&id) {
                continue;
            }
            ids.push(id);
            let of = |chosen: &Chosen, rows: &[(usize, usize)]| -> Vec<usize> {
                let own = |i: &usize| chosen.observed[rows[*i].0].conditions.id == *id;
                (0..rows.len()).filter(own).collect()
            };
            let own = of(chosen, &rows);
            // A point that alone decides a parameter cannot be foreseen by the others.
            let found = linear.left_out(&own).ok();
            let other = others
                .as_ref()
                .and_then(|(rival, rows)| rival.trained.linear.0.left_out(&of(rival, rows)).ok());
            if let Some(found) = &found {
                for (k, &i) in own.iter().enumerate().filter(|(_, i)| rows[**i].1 < 2) {
                    residuals[rows[i].0][rows[i].1] = Some(found.residuals[k] / found.sds[k]);
                }
            }
            let shift = found.as_ref().map_or(f64::MAX, |f| f.shift);
            points.push(PointCheck {
                point: id.clone(),
                ln_left_out: found.as_ref().map(|f| f.ln_density),
                ahead: found.as_ref().zip(other.as_ref()).map(|(a, b)| a.ln_density - b.ln_density),
                shift,
                doubtful: shift.max(other.map_or(0.0, |o| o.shift)) > FAR,
            });
        }
        let streams = Streams::new(u64::from_le_bytes(*b"checks\0\0"));
        let draw = |k: usize| linear.draw(&mut streams.stream(&format!("engine/checks/{k}"))).pulls;
        let draws: Vec<Vec<f64>> = (0..DRAWS).into_par_iter().map(draw).collect();
        let kinds = [
            ("growth rates", [0, 1]),
            ("angular frequencies", [1, 2]),
            ("relative pressures", [2, usize::MAX]),
        ];
        let law = self.law_of(stage, &stage.noise, &chosen.choice())?;
        let law = law.filter(|law| law.added.is_some()).map(|law| law.role);
        let sum = |(what, [from, to]): (&str, [usize; 2])| {
            let places: Vec<usize> = (0..rows.len()).filter(|&i| (from..to).contains(&rows[i].1)).collect();
            let chi_squared = linear.squares(linear.pulls(), &places);
            let floats = places.iter().map(|&i| linear.floats(i)).sum::<f64>() / places.len() as f64;
            let above = || draws.iter().filter(|d| linear.squares(d, &places) >= chi_squared).count();
            (!places.is_empty()).then(|| SumCheck {
                what: what.to_owned(),
                count: places.len(),
                chi_squared,
                law: law.clone(),
                probability: (floats < 0.5).then(|| (1.0 + above() as f64) / (1.0 + DRAWS as f64)),
            })
        };
        Ok(Checks {
            rival: rival.map(|(id, _)| id.to_owned()),
            points,
            residuals,
            sums: kinds.into_iter().filter_map(sum).collect(),
        })
    }
}
