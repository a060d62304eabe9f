//! A trained model point by point: how well it foresees each from all others, and whether the residuals are
//! as large as its noise says.

use super::course::{Chosen, Run};
use super::found::{Checks, NoiseCheck, PointCheck, SumCheck};
use crate::EngineError;
use crate::noise::MEASURED;
use crate::observed::Used;
use rayon::prelude::*;
use rijke_inference::relative_noise;
use rijke_numerics::{Matrix, Streams};
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
        let noise = OwnNoise::of(chosen, &chosen.used(&self.rig, stage), &rows, stage.noise.measured);
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
            let of_noise = (noise.floats(&places) < 0.5).then(|| {
                let own = noise.sum(linear.pulls(), &places);
                let drawn: Vec<f64> = draws.iter().map(|d| noise.sum(d, &places)).collect();
                let below = drawn.iter().filter(|d| **d <= own).count();
                NoiseCheck {
                    chi_squared: own,
                    expected: drawn.iter().sum::<f64>() / DRAWS as f64,
                    probability: (1.0 + below as f64) / (1.0 + DRAWS as f64),
                }
            });
            let above = || draws.iter().filter(|d| linear.squares(d, &places) >= chi_squared).count();
            (!places.is_empty()).then(|| SumCheck {
                what: what.to_owned(),
                count: places.len(),
                chi_squared,
                law: law.clone(),
                of_noise,
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

/// The noise that each datum has apart from the errors that data share.
struct OwnNoise {
    /// Its covariance with data of the same observation, by their places.
    rows: Vec<Vec<(usize, f64)>>,
    /// Variance of each, and what of it the data chose.
    variances: Vec<[f64; 2]>,
}

impl OwnNoise {
    /// That of the data at `rows`, with what was measured of it or without.
    fn of(chosen: &Chosen, used: &[Used], rows: &[(usize, usize)], measured: bool) -> Self {
        let sums = |floating: bool| {
            MEASURED.map(|name| -> f64 {
                let own = chosen.trained.noise.iter().filter(|n| n.name == name);
                own.filter(|n| n.floats || !floating).map(|n| n.sd * n.sd).sum()
            })
        };
        let [all, chosen_here] = [sums(false), sums(true)];
        let kind = |row: usize| row.min(2);
        let (mut list, mut variances) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
        let shapes: Vec<Matrix> = used.iter().map(|u| relative_noise(&u.pressures)).collect();
        let mut of_observation = vec![Vec::new(); used.len()];
        rows.iter().enumerate().for_each(|(j, (p, _))| of_observation[*p].push(j));
        for &(p, row) in rows {
            let u = &used[p];
            let place = |row: usize| u.rows.iter().position(|r| *r == row);
            let covariance = |other: usize| -> f64 {
                let stated = match (place(row), place(other)) {
                    (Some(a), Some(b)) if measured => u.covariance[(a, b)],
                    _ => 0.0,
                };
                stated
                    + match (row.checked_sub(2), other.checked_sub(2)) {
                        (Some(a), Some(b)) => all[2] * shapes[p][(a, b)],
                        _ if row == other => all[kind(row)],
                        _ => 0.0,
                    }
            };
            list.push(of_observation[p].iter().map(|&j| (j, covariance(rows[j].1))).collect());
            let shape = row.checked_sub(2).map_or(1.0, |k| shapes[p][(k, k)]);
            variances.push([covariance(row), chosen_here[kind(row)] * shape]);
        }
        Self { rows: list, variances }
    }

    /// The sum of squares of what the noise of the data at `places` most probably was, R C^-1 r, in its
    /// standard deviations; `pulls` are C^-1 r of all data.
    fn sum(&self, pulls: &[f64], places: &[usize]) -> f64 {
        let one = |&i: &usize| {
            let was: f64 = self.rows[i].iter().map(|(j, c)| c * pulls[*j]).sum();
            if self.variances[i][0] > 0.0 { was * was / self.variances[i][0] } else { 0.0 }
        };
        places.iter().map(one).sum()
    }

    /// The mean share of it that the data chose.
    fn floats(&self, places: &[usize]) -> f64 {
        let one = |&i: &usize| match self.variances[i] {
            [whole, chosen] if whole > 0.0 => chosen / whole,
            _ => 1.0,
        };
        places.iter().map(one).sum::<f64>() / places.len() as f64
    }
}
