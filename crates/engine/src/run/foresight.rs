//! What planned measurements would tell of the models of a study, before anything is measured.

use super::combined::{assembly_of, first_of_responses, rows_of};
use super::parameter::UNIDENTIFIED;
use super::points::inputs::{ambient_of_all, conditions_or_ambient, lacks_state, states};
use super::points::meant::GROWTH_RATE;
use crate::rows::{Choice, Row};
use crate::{Assembly, Conditions, EngineError, PointModel};
use rayon::prelude::*;
use rijke_inference::Prior;
use rijke_network::{Response, Workspace};
use rijke_numerics::{C64, InOrder, Matrix, Order, symmetric_eigen};
use rijke_study::plan::Stage;
use rijke_study::{ObservedModes, Study, hertz};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Components of a direction below this are left out of its name.
const MINOR: f64 = 0.2;
/// Two roots that are closer, relative to their size, are one mode.
const SAME_MODE: f64 = 1e-6;

/// A stage before its measurements.
#[derive(Clone, Debug, Serialize)]
pub struct StageForesight {
    /// Name of the stage.
    pub id: String,
    /// What it is called.
    pub title: String,
    /// How many operating points train it.
    pub points: usize,
    /// How many modes were observed at them, if anything was observed at all.
    pub observed: Option<usize>,
    /// At how many of them the gas is not known yet: it is taken as ambient and at rest.
    pub assumed: usize,
    /// At how many of them no mode was measured: one is judged there, the lowest in the band of
    /// `[recording]` or, if there is none, of `[search]`; where neither is stated, the one nearest to half
    /// a wavelength.
    pub alone: usize,
    /// Its models.
    pub models: Vec<Foreseen>,
}

/// What measurements would leave of the prior of a model, to first order at the centre of the prior.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Foreseen {
    /// The candidates in question, joined by ` + `.
    pub id: String,
    /// Each parameter with its standard deviation after the measurements, relative to that of the prior.
    pub widths: Vec<(String, f64)>,
    /// Combinations that keep more than 0.9 of the width of the prior: in words, and that share.
    pub unidentified: Vec<(String, f64)>,
    /// Parameters whose prior is flat. It has no centre and no width, so nothing else is foreseen.
    pub flat: Vec<String>,
    /// Operating points at which the model, at the centre of its priors, has no mode to start from.
    pub lost: Vec<String>,
    /// Ends and walls that the rig's file and a candidate both bring, in sentences.
    pub doubled: Vec<String>,
}

/// The information of a stage about parameters, by name: J' C^-1 J in prior standard deviations.
#[derive(Clone, Default)]
struct Information {
    names: Vec<String>,
    matrix: Matrix,
}

/// What each stage would tell, at the noise `sd` of growth rate (1/s), angular frequency (rad/s) and each
/// part of a relative pressure at every point. Stages stand on the first row of those before them. `ambient`
/// (K) is where no temperature is known.
///
/// The posterior width of a Gaussian with the prior's scale S, the Jacobian J at the centre and the noise C
/// is that of (1 + S J' C^-1 J S)^-1, by whose eigenvectors the parameters are told apart.
///
/// # Errors
/// Those of the files and of the models.
pub fn foresight(
    study: &Study,
    observations: Option<&ObservedModes>,
    sd: [f64; 3],
    ambient: f64,
) -> Result<Vec<StageForesight>, EngineError> {
    let known = match observations {
        Some(observations) => ambient_of_all(study, observations),
        None => study.campaign.points.iter().map(|p| p.ambient).collect(),
    };
    if let Some(observations) = observations {
        with_temperatures(study, observations, &known)?;
    }
    let known: Vec<Option<[f64; 2]>> = known.into_iter().map(|t| t.or(Some([ambient, 0.0]))).collect();
    let states = states(study, &known, observations.is_some())?;
    let grounds = first_of_responses(study);
    let mut done: BTreeMap<String, (Choice, Information)> = BTreeMap::new();
    let mut all = Vec::new();
    for stage in &study.plan.stages {
        let meant = study.campaign.points.iter().enumerate();
        let meant = meant.filter(|(_, p)| stage.points.holds(&study.campaign, p));
        let meant: Vec<_> = meant.take(stage.points.first.unwrap_or(usize::MAX)).collect();
        let assumed = meant.iter().filter(|(k, p)| lacks_state(study, p, states.get(k))).count();
        let points: Vec<Conditions> = meant
            .iter()
            .map(|(k, p)| conditions_or_ambient(study, p, states.get(k), known[*k]))
            .collect::<Result<_, _>>()?;
        if points.is_empty() {
            return Err(EngineError::no_point(study, &stage.id, &stage.points));
        }
        let modes = observations.map_or(&[][..], |o| &o.modes);
        let measured_at = |(k, _): &(usize, &rijke_study::Point)| -> Vec<C64> {
            modes.iter().filter(|m| m.point == *k).filter_map(|m| m.near(GROWTH_RATE)).collect()
        };
        let near: Vec<Vec<C64>> = meant.iter().map(measured_at).collect();
        let rows = rows_of(study, stage, &|id| {
            let stage = done.get(id).map(|(choice, _)| choice);
            stage.or(grounds.get(id)).cloned().into_iter().collect()
        });
        let before: Vec<&Information> = stage.on.iter().filter_map(|id| Some(&done.get(id)?.1)).collect();
        let one = |row: &Row| foreseen(study, stage, row, (&points, &near), &before, sd);
        let found = rows.par_iter().map(one).in_order::<Result<Vec<_>, EngineError>>()?;
        let (models, information): (Vec<Foreseen>, Vec<Information>) = found.into_iter().unzip();
        if let (Some(row), Some(first)) = (rows.into_iter().next(), information.into_iter().next()) {
            done.insert(stage.id.clone(), (row.choice, first));
        }
        let seen = |o: &ObservedModes| {
            let of = |m: &&rijke_study::ObservedMode| {
                stage.points.holds(&study.campaign, &study.campaign.points[m.point])
            };
            o.modes.iter().filter(of).count()
        };
        let observed = observations.map(seen);
        let (id, title) = (stage.id.clone(), stage.title.clone());
        let alone = near.iter().filter(|modes| modes.is_empty()).count();
        all.push(StageForesight { id, title, points: points.len(), observed, assumed, alone, models });
    }
    Ok(all)
}

/// Refuses what was observed at a point of a stage whose temperature nobody knows, as training does.
fn with_temperatures(
    study: &Study,
    observations: &ObservedModes,
    known: &[Option<[f64; 2]>],
) -> Result<(), EngineError> {
    if observations.modes.iter().all(|mode| known[mode.point].is_some()) {
        return Ok(());
    }
    let states = states(study, known, true)?;
    let lacks = |k: &usize| known[*k].is_none() && !states.contains_key(k);
    let point = |k: usize| &study.campaign.points[k];
    let wanted = |k: &usize| study.plan.stages.iter().any(|s| s.points.holds(&study.campaign, point(*k)));
    match observations.modes.iter().map(|mode| mode.point).find(|k| lacks(k) && wanted(k)) {
        Some(k) => Err(EngineError::NoTemperature { point: point(k).id.clone() }),
        None => Ok(()),
    }
}

fn foreseen(
    study: &Study,
    stage: &Stage,
    row: &Row,
    (points, near): (&[Conditions], &[Vec<C64>]),
    before: &[&Information],
    sd: [f64; 3],
) -> Result<(Foreseen, Information), EngineError> {
    let assembly = assembly_of(study, &row.choice, &stage.hold)?;
    let list = assembly.parameters();
    let flat: Vec<String> = list.iter().filter(|p| p.prior == Prior::Flat).map(|p| p.name.clone()).collect();
    if !flat.is_empty() {
        return Ok((Foreseen { id: row.id(), flat, ..Foreseen::default() }, Information::default()));
    }
    let (own, lost) = information(&assembly, (points, near), sd)?;
    let n = list.len();
    let mut total = own;
    for known in before {
        let place = |i: usize| known.names.iter().position(|name| *name == list[i].name);
        let add = |i: usize, j: usize| match (place(i), place(j)) {
            (Some(a), Some(b)) => known.matrix[(a, b)],
            _ => 0.0,
        };
        total = Matrix::from_fn(n, n, |i, j| total[(i, j)] + add(i, j));
    }
    let (values, vectors) = symmetric_eigen(&total)?;
    let left = |k: usize| 1.0 / (1.0 + values[k].max(0.0));
    let width = |i: usize| (0..n).map(|k| vectors[(i, k)].powi(2) * left(k)).sum::<f64>().sqrt();
    let in_words = |k: usize| {
        let mut parts: Vec<(f64, &str)> = (0..n).map(|i| (vectors[(i, k)], list[i].name.as_str())).collect();
        parts.retain(|(share, _)| share.abs() > MINOR);
        parts.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        match &parts[..] {
            [(_, only)] => (*only).to_owned(),
            several => several
                .iter()
                .map(|(share, name)| format!("{share:+.2} {name}"))
                .collect::<Vec<_>>()
                .join(" "),
        }
    };
    let unidentified = (0..n).map(|k| (k, left(k).sqrt())).filter(|(_, share)| *share > UNIDENTIFIED);
    let found = Foreseen {
        id: row.id(),
        widths: (0..n).map(|i| (list[i].name.clone(), width(i))).collect(),
        unidentified: unidentified.map(|(k, share)| (in_words(k), share)).collect(),
        flat,
        lost,
        doubled: doubled(study, &assembly, points)?,
    };
    Ok((found, Information { names: list.iter().map(|p| p.name.clone()).collect(), matrix: total }))
}

/// What the rig's file and candidates both bring, at the centre of the priors and in the middle of the region
/// that is searched.
fn doubled(study: &Study, assembly: &Assembly, points: &[Conditions]) -> Result<Vec<String>, EngineError> {
    let [low, high] = study.rig.search[1];
    let omega = std::f64::consts::PI * (low + high);
    let centre = assembly.centre()?;
    let mut said = BTreeSet::new();
    for conditions in points {
        said.extend(PointModel::new(assembly, conditions, &[])?.doubled(&centre, omega));
    }
    Ok(said.into_iter().collect())
}

/// The information of the points about the free parameters at the centre of their priors, by the modes that
/// were measured there or by one, and the points without a mode there.
fn information(
    assembly: &Assembly,
    (points, near): (&[Conditions], &[Vec<C64>]),
    sd: [f64; 3],
) -> Result<(Matrix, Vec<String>), EngineError> {
    let centre = assembly.centre()?;
    let n = centre.len();
    // Width of each prior in the units of its parameter.
    let scale: Vec<f64> = assembly
        .parameters()
        .iter()
        .map(|p| 0.5 * (p.prior.quantile(0.841_344_746) - p.prior.quantile(0.158_655_254)))
        .collect();
    let microphones: Vec<usize> = (0..assembly.rig.microphones.at.len()).collect();
    let one = |(c, measured): (&Conditions, &Vec<C64>)| -> Result<Option<Matrix>, EngineError> {
        let model = PointModel::new(assembly, c, &microphones)?;
        let work = &mut Workspace::default();
        let mut found: Vec<Response> = Vec::new();
        for near in measured {
            let Ok(mode) = model.respond_near(&centre, *near, Order::First, work) else { continue };
            let s = mode.s.value();
            if found.iter().all(|known| (known.s.value() - s).norm() > SAME_MODE * s.norm()) {
                found.push(mode);
            }
        }
        if measured.is_empty() {
            let rig = &assembly.rig;
            let band = rig.ping_band_hz.or(rig.search_is_stated[1].then_some(rig.search[1]));
            let inside = |s: &C64| band.is_some_and(|[low, high]| (low..=high).contains(&hertz(s.im)));
            let all = if band.is_some() { model.modes(&centre).unwrap_or_default() } else { Vec::new() };
            let lowest = all.into_iter().filter(inside).min_by(|a, b| a.im.total_cmp(&b.im));
            let first = match lowest {
                Some(s) => model.respond_near(&centre, s, Order::First, work),
                None => model.respond(&centre, Order::First, work),
            };
            let one = first.or_else(|lost| {
                // Newton's method may begin where nothing changes with s: the lowest of all modes instead.
                let all = model.spectrum(&centre, [None, None])?.1.modes.modes;
                let Some(first) = all.first() else { return Err(lost) };
                model.respond_near(&centre, first.s, Order::First, work)
            });
            found.extend(one);
        }
        if found.is_empty() {
            return Ok(None);
        }
        let mut sum = Matrix::zeros(n, n);
        for mode in &found {
            let slopes: Vec<Vec<f64>> = (0..n).map(|k| model.slope(mode, k)).collect();
            let rows = slopes.first().map_or(0, Vec::len);
            let told = |i: usize, j: usize| {
                let each = (0..rows).map(|r| slopes[i][r] * slopes[j][r] / sd[r.min(2)].powi(2));
                each.sum::<f64>() * scale[i] * scale[j]
            };
            sum = Matrix::from_fn(n, n, |i, j| sum[(i, j)] + told(i, j));
        }
        Ok(Some(sum))
    };
    let found = points.par_iter().zip(near).map(one).in_order::<Result<Vec<_>, EngineError>>()?;
    let mut total = Matrix::zeros(n, n);
    let mut lost = Vec::new();
    for (information, c) in found.into_iter().zip(points) {
        match information {
            Some(m) => total = Matrix::from_fn(n, n, |i, j| total[(i, j)] + m[(i, j)]),
            None => lost.push(c.id.clone()),
        }
    }
    Ok((total, lost))
}
