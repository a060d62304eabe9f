//! What errors of points do to predictions: a systematic covariance of what the points share. They are errors
//! of base states, of factors, of pings that drift, and of laws.

use super::principal::Principal;
use crate::observed::{Observed, Used};
use crate::point::parts;
use crate::{Assembly, Conditions, Displaced, EngineError, PointModel};
use rayon::prelude::*;
use rijke_network::Workspace;
use rijke_numerics::{C64, InOrder, Matrix, Order};
use rijke_study::{Cause, PointState, STEP};
use std::collections::{BTreeMap, BTreeSet};

/// Causes of error of a point, and the change of its prediction per standard deviation of each.
pub(crate) type Changes = Vec<(Cause, Vec<f64>)>;

/// For each operating point, the change of its prediction per standard deviation of each cause of error.
///
/// Points that name the same cause share it: it is one random number.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PointErrors {
    points: Vec<Changes>,
}

impl PointErrors {
    /// The changes by errors of the base states at the parameter values `values`: slopes along the principal
    /// errors of each base state, by a small step.
    ///
    /// Cost: a value of the model per point and principal error, of which fifty causes have about seven; in
    /// parallel over points.
    ///
    /// # Errors
    /// Those of the model at a displaced state.
    pub(crate) fn new(
        assembly: &Assembly,
        observed: &[Observed],
        used: &[Used],
        values: &[f64],
    ) -> Result<Self, EngineError> {
        let at = |(o, u): (&Observed, &Used)| {
            changes(assembly, &o.conditions, o.near, &u.microphones, values, None)
        };
        Ok(Self { points: observed.par_iter().zip(used).map(at).in_order::<Result<_, _>>()? })
    }

    /// No error at any of so many points.
    pub(crate) fn none(points: usize) -> Self {
        Self { points: vec![Vec::new(); points] }
    }

    /// Whether there is no error at any point.
    pub(crate) fn is_none(&self) -> bool {
        self.points.iter().all(Vec::is_empty)
    }

    /// With more causes of error, for each point.
    pub(crate) fn and(mut self, more: Vec<Changes>) -> Self {
        self.points.iter_mut().zip(more).for_each(|(list, more)| list.extend(more));
        self
    }

    /// With other errors of the same points.
    pub(crate) fn beside(self, others: Self) -> Self {
        self.and(others.points)
    }

    /// What errors of these sizes, in their standard deviations, do to all numbers, point after point.
    pub(crate) fn effect(&self, used: &[Used], sizes: &BTreeMap<Cause, f64>) -> Vec<f64> {
        let mut all = Vec::with_capacity(used.iter().map(Used::size).sum());
        for (list, u) in self.points.iter().zip(used) {
            let mut sum = vec![0.0; u.size()];
            for (cause, change) in list {
                if let Some(size) = sizes.get(cause) {
                    sum.iter_mut().zip(change).for_each(|(s, c)| *s += size * c);
                }
            }
            all.extend(sum);
        }
        all
    }

    /// The mean of each cause that is part of the covariance of the data, in its standard deviations, as the
    /// first numbers of each point tell it, `most` of each: S'C^-1 r. `pulls` are C^-1 r of the data, each a
    /// number of the prediction by its `order`.
    pub(crate) fn told(
        &self,
        used: &[Used],
        order: &[usize],
        pulls: &[f64],
        most: impl Fn(usize) -> usize,
    ) -> BTreeMap<Cause, f64> {
        let mut placed = vec![0.0; used.iter().map(Used::size).sum()];
        order.iter().zip(pulls).for_each(|(&place, pull)| placed[place] = *pull);
        let (mut all, mut offset) = (BTreeMap::new(), 0);
        for (p, (list, u)) in self.points.iter().zip(used).enumerate() {
            let own = &placed[offset..offset + u.size().min(most(p))];
            for (cause, change) in list {
                let sum: &mut f64 = all.entry(cause.clone()).or_default();
                *sum += own.iter().zip(change).map(|(pull, c)| pull * c).sum::<f64>();
            }
            offset += u.size();
        }
        all
    }

    /// The causes that points of different installations share (`same` tells whether two are of one), or
    /// would share if there were such points, and those that go on from stage to stage; what each does to all
    /// numbers, point after point, `sizes` of each; and the errors without them.
    pub(crate) fn apart(
        self,
        sizes: &[usize],
        same: impl Fn(usize, usize) -> bool,
        goes_on: impl Fn(&Cause) -> bool,
    ) -> (Vec<Cause>, Vec<Vec<f64>>, Self) {
        let mut first: BTreeMap<&Cause, (usize, bool)> = BTreeMap::new();
        for (p, list) in self.points.iter().enumerate() {
            for (cause, _) in list {
                let (other, apart) = first.entry(cause).or_insert((p, false));
                *apart |= !same(*other, p);
            }
        }
        let shared =
            |(cause, (_, apart)): &(&&Cause, &(usize, bool))| *apart || cause.is_of_many() || goes_on(cause);
        let causes: Vec<Cause> = first.iter().filter(shared).map(|(cause, _)| (*cause).clone()).collect();
        let mut columns = vec![vec![0.0; sizes.iter().sum()]; causes.len()];
        let mut rest = Self { points: vec![Vec::new(); self.points.len()] };
        let mut offset = 0;
        for (p, list) in self.points.into_iter().enumerate() {
            for (cause, change) in list {
                match causes.binary_search(&cause) {
                    Ok(j) => columns[j][offset..offset + sizes[p]].copy_from_slice(&change),
                    Err(_) => rest.points[p].push((cause, change)),
                }
            }
            offset += sizes[p];
        }
        (causes, columns, rest)
    }

    /// Whether factors have errors at any point.
    pub(crate) fn are_of_factors(&self) -> bool {
        (0..self.points.len()).any(|p| self.of_factors_at(p).next().is_some())
    }

    /// The causes at a point that are errors of factors.
    pub(crate) fn of_factors_at(&self, point: usize) -> impl Iterator<Item = &Cause> {
        self.points[point].iter().map(|(cause, _)| cause).filter(|c| c.factor().is_some())
    }

    /// Points that share a cause, or are `linked`, directly or through others: each list ascends, and every
    /// point is in exactly one.
    pub(crate) fn together(&self, linked: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
        let shares = |a: usize, b: usize| {
            linked(a, b)
                || self.points[a]
                    .iter()
                    .any(|(cause, _)| self.points[b].iter().any(|(other, _)| other == cause))
        };
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for point in 0..self.points.len() {
            let (mut with, without): (Vec<_>, Vec<_>) =
                groups.into_iter().partition(|g| g.iter().any(|&other| shares(point, other)));
            with.push(vec![point]);
            groups = without;
            let mut merged = with.concat();
            merged.sort_unstable();
            groups.push(merged);
        }
        groups.sort();
        groups
    }

    /// The causes of error of base states and laws that move the predictions of several points in their first
    /// numbers, `most` of each, and what each does to these of the data, each a number of the prediction.
    pub(crate) fn of_several(
        &self,
        observed: &[Observed],
        used: &[Used],
        data: &[usize],
        most: impl Fn(usize) -> usize,
    ) -> (Vec<Cause>, Vec<Vec<f64>>) {
        let mut place = vec![None; used.iter().map(Used::size).sum()];
        data.iter().enumerate().for_each(|(datum, &number)| place[number] = Some(datum));
        let mut all: BTreeMap<&Cause, (BTreeSet<&str>, Vec<f64>)> = BTreeMap::new();
        let mut offset = 0;
        for (p, ((list, o), u)) in self.points.iter().zip(observed).zip(used).enumerate() {
            let measured = (0..u.size().min(most(p))).filter_map(|row| Some((row, place[offset + row]?)));
            let measured: Vec<(usize, usize)> = measured.collect();
            offset += u.size();
            for (cause, change) in list.iter().filter(|(cause, _)| cause.factor().is_none()) {
                if measured.iter().any(|(row, _)| change[*row] != 0.0) {
                    let (points, column) =
                        all.entry(cause).or_insert_with(|| (BTreeSet::new(), vec![0.0; data.len()]));
                    points.insert(&o.conditions.id);
                    measured.iter().for_each(|(row, datum)| column[*datum] = change[*row]);
                }
            }
        }
        let several = all.into_iter().filter(|(_, (points, _))| points.len() > 1);
        several.map(|(cause, (_, column))| (cause.clone(), column)).unzip()
    }

    /// Covariance of numbers, each a point and a row of its prediction: the sum over causes of j j'.
    pub(crate) fn covariance(&self, numbers: &[(usize, usize)]) -> Matrix {
        let mut covariance = Matrix::zeros(numbers.len(), numbers.len());
        let mut points: Vec<usize> = numbers.iter().map(|(p, _)| *p).collect();
        points.dedup();
        let mut causes: Vec<&Cause> = points.iter().flat_map(|&p| &self.points[p]).map(|(c, _)| c).collect();
        causes.sort_unstable();
        causes.dedup();
        for cause in causes {
            let mut j = vec![0.0; numbers.len()];
            for (to, (point, row)) in j.iter_mut().zip(numbers) {
                if let Some((_, change)) = self.points[*point].iter().find(|(c, _)| c == cause) {
                    *to = change[*row];
                }
            }
            covariance.add_outer(&j);
        }
        covariance
    }
}

/// What is not known of a drift that all decays have in common, for each point.
pub(crate) fn of_drift(observed: &[Observed], used: &[Used]) -> Vec<Changes> {
    let change = |(o, u): (&Observed, &Used)| {
        let mut change = vec![0.0; u.size()];
        change[1] = o.mode.drift_sd;
        let heard = o.mode.drift_sd > 0.0 && u.rows.contains(&1);
        heard.then_some((Cause::Drift, change)).into_iter().collect()
    };
    observed.iter().zip(used).map(change).collect()
}

/// For each operating point, [`changes_by_factors`].
///
/// # Errors
/// Those of the model at a displaced factor.
pub(crate) fn changes_by_factors_of(
    assembly: &Assembly,
    observed: &[Observed],
    used: &[Used],
    values: &[f64],
) -> Result<Vec<Changes>, EngineError> {
    let at = |(o, u): (&Observed, &Used)| {
        changes_by_factors(assembly, &o.conditions, o.near, &u.microphones, values)
    };
    observed.par_iter().zip(used).map(at).in_order()
}

/// The change of the prediction of one point per standard deviation of each factor that is not known exactly.
/// `near` is a guess of the root.
pub(crate) fn changes_by_factors(
    assembly: &Assembly,
    conditions: &Conditions,
    near: C64,
    microphones: &[usize],
    values: &[f64],
) -> Result<Changes, EngineError> {
    if conditions.displaced.is_empty() {
        return Ok(Vec::new());
    }
    let work = &mut Workspace::default();
    let mut predicted =
        |conditions: &Conditions, near| predicted(assembly, conditions, near, microphones, values, work);
    let here = predicted(conditions, near)?;
    let near = C64::new(here[0], here[1]);
    let change = |moved: &Displaced| {
        let there = predicted(&moved.near, near)?;
        Ok((moved.cause.clone(), there.iter().zip(&here).map(|(t, h)| (t - h) / STEP).collect()))
    };
    conditions.displaced.iter().map(change).collect()
}

/// The change of the prediction of one point per standard deviation of each cause of error of its base state,
/// by way of the state's [`Principal`] errors. `here` is the prediction itself, if it is known, and
/// `near` then its root.
pub(crate) fn changes(
    assembly: &Assembly,
    conditions: &Conditions,
    near: C64,
    microphones: &[usize],
    values: &[f64],
    here: Option<&[f64]>,
) -> Result<Changes, EngineError> {
    let work = &mut Workspace::default();
    let mut predicted = |base: PointState, near| {
        let moved = Conditions { base, ..conditions.clone() };
        predicted(assembly, &moved, near, microphones, values, work)
    };
    let principal = Principal::of(&conditions.base)?;
    let mut along = Vec::with_capacity(principal.states.len());
    if !principal.states.is_empty() {
        let here = match here {
            Some(here) => here.to_vec(),
            None => predicted(conditions.base.clone(), near)?,
        };
        // So near that Newton's steps are one or two.
        let near = C64::new(here[0], here[1]);
        for moved in principal.states {
            let moved = predicted(moved, near)?;
            along.push(moved.iter().zip(&here).map(|(m, h)| (m - h) / STEP).collect::<Vec<f64>>());
        }
    }
    let size = 2 * microphones.len().max(1);
    let change = |(cause, shares): (Cause, Vec<f64>)| {
        let mut change = vec![0.0; size];
        for (share, along) in shares.iter().zip(&along) {
            change.iter_mut().zip(along).for_each(|(c, a)| *c += share * a);
        }
        (cause, change)
    };
    Ok(principal.causes.into_iter().map(change).collect())
}

/// Growth rate, angular frequency and pressures of the mode near `near`, as a prediction has them.
fn predicted(
    assembly: &Assembly,
    conditions: &Conditions,
    near: C64,
    microphones: &[usize],
    values: &[f64],
    work: &mut Workspace,
) -> Result<Vec<f64>, EngineError> {
    let model = PointModel::new(assembly, conditions, microphones)?.starting_from(near);
    let response = model.respond(values, Order::Value, work)?;
    Ok(parts(model.numbers(&response).map(|z| z.value())))
}
