//! What each microphone tells, and what another at a further place would.

use super::place::{Place, Wish};
use super::predictive::Numbers;
use super::told::Aim;
use crate::run::points::ready::Known;
use crate::run::stages::average::OpenModel;
use crate::{EngineError, SavedModel};
use rayon::prelude::*;
use rijke_numerics::{C64, InOrder, Matrix};
use rijke_rig::ModeRows;
use rijke_study::{ObservedModes, RigAtPoint, Study, Value};
use serde::Serialize;

/// A microphone, and what it brings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MicrophoneChoice {
    /// Its name; that of a new one is its place.
    pub microphone: String,
    /// Where it is at the first of the points, m.
    pub at: f64,
    /// Whether the model was trained on what it heard.
    pub in_use: bool,
    /// The microphone to which pressures are relative once the reference is left out; of no other microphone.
    pub takes_its_role: Option<String>,
    /// What is lost without one in use; what another one adds. Nats.
    pub nats: f64,
}

/// What microphones tell at some points, each visited once more.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MicrophoneTable {
    /// The stage whose models are meant.
    pub stage: String,
    /// What counts.
    pub aim: Aim,
    /// The points.
    pub points: Vec<String>,
    /// What growth rates and frequencies tell alone, and with the microphones in use, nats.
    pub total: [f64; 2],
    /// Those in use, that first without which most is lost.
    pub in_use: Vec<MicrophoneChoice>,
    /// Others, the best first.
    pub further: Vec<MicrophoneChoice>,
    /// Nats below which a further one is not worth adding.
    pub worth: f64,
    /// Points that cannot be judged, and why.
    pub left_out: Vec<(String, String)>,
}

/// A tenth of a nat: all on one parameter, it makes its standard deviation a tenth smaller.
const WORTH: f64 = 0.1;
/// Into so many parts each duct is cut by the places that are tried.
const PARTS: usize = 20;

/// What each microphone tells of what is wished beyond growth rate, frequency and the other microphones, at
/// one further visit of each of the points; and what another would, at each of `places` (m) or, without any,
/// along all ducts.
///
/// # Errors
/// [`EngineError::NothingToMeasure`], [`EngineError::Damaged`], and those of the files.
pub fn microphones(
    study: &Study,
    observations: &ObservedModes,
    model: &SavedModel,
    rivals: &[OpenModel],
    wish: &Wish,
    places: &[f64],
) -> Result<MicrophoneTable, EngineError> {
    let nothing = |reason: String| EngineError::NothingToMeasure { stage: model.stage.clone(), reason };
    let places = tried(study, wish, places).map_err(nothing)?;
    let mut more = study.clone();
    for x in &places {
        more.rig.microphones.names.push(format!("{x:.3} m"));
        more.rig.microphones.at.push(Value::Number(*x));
    }
    let place = Place::new(Known::of(&more, observations)?, study.channels()?);
    let (names, reference) = (&more.rig.microphones.names, more.rig.microphones.reference);
    let heard = place.heard(model);
    let (all, others): (Vec<usize>, Vec<usize>) =
        ((0..names.len()).collect(), (0..names.len()).filter(|m| *m != reference).collect());
    let now: Vec<usize> = others.iter().copied().filter(|m| heard.contains(m)).collect();
    let Some(&second) = now.first() else {
        let text = "it was trained without mode shapes, so the errors of its microphones are not known; write relative pressures into \
                    observations/modes.csv, as p2_re, p2_re_sd, p2_im, p2_im_sd, and rank it again";
        return Err(nothing(text.into()));
    };
    let able = place.measurable(model, rivals, wish, &all)?;
    let visits: Vec<usize> = (0..able.kept.len()).collect();
    let gain = |seen: &(dyn Fn(&Numbers) -> Numbers + Sync)| able.told(seen).gain(wish.aim, &visits);
    let of = |set: &[usize]| gain(&|n: &Numbers| n.through(&rows(set, &others, n.values.len())));
    let total = [of(&[])?, of(&now)?];
    let first = &more.campaign.points[able.kept[0]].factors;
    let layout = more.rig.at_factors(first, more.rig.temperature);
    let at = layout.map(|l| l.microphones).unwrap_or_default();
    let choice = |&m: &usize| -> Result<MicrophoneChoice, EngineError> {
        let in_use = m == reference || now.contains(&m);
        let nats = if m == reference {
            total[1] - gain(&|n: &Numbers| relative_to(second, &now, &others, n))?
        } else if in_use {
            let rest: Vec<usize> = now.iter().copied().filter(|other| *other != m).collect();
            total[1] - of(&rest)?
        } else {
            of(&[&now[..], &[m]].concat())? - total[1]
        };
        Ok(MicrophoneChoice {
            microphone: names[m].clone(),
            at: at.get(m).copied().unwrap_or(f64::NAN),
            in_use,
            takes_its_role: (m == reference).then(|| names[second].clone()),
            nats,
        })
    };
    let mut found = all.par_iter().map(choice).in_order::<Result<Vec<_>, _>>()?;
    found.sort_by(|a, b| b.nats.total_cmp(&a.nats));
    let (in_use, further) = found.into_iter().partition(|m| m.in_use);
    Ok(MicrophoneTable {
        stage: model.stage.clone(),
        aim: wish.aim,
        points: able.kept.iter().map(|&k| more.campaign.points[k].id.clone()).collect(),
        total,
        in_use,
        further,
        worth: WORTH,
        left_out: able.left_out,
    })
}

/// Where further microphones are tried; each must lie on the ducts at every point.
fn tried(study: &Study, wish: &Wish, places: &[f64]) -> Result<Vec<f64>, String> {
    let at = |factors: &[f64]| study.rig.at_factors(factors, study.rig.temperature).ok();
    let points = &study.campaign.points;
    let layouts: Vec<RigAtPoint> = points.iter().filter_map(|p| at(&p.factors)).collect();
    let shortest = layouts.iter().map(|l| l.length).fold(f64::INFINITY, f64::min);
    if let Some(x) = places.iter().find(|x| !(0.0..=shortest).contains(*x)) {
        let what = format!("a microphone at {x} m is asked for, beyond the ducts");
        return Err(format!("{what}; give a place from 0 to {shortest} m, the length of the shortest rig"));
    }
    if !places.is_empty() {
        return Ok(places.to_vec());
    }
    let first = wish.candidates.first().and_then(|k| at(&points[*k].factors));
    let ducts = first.iter().flat_map(|l| &l.ducts).map(|d| d.span);
    let along = |[from, to]: [f64; 2]| (0..=PARTS).map(move |k| from + (to - from) * k as f64 / PARTS as f64);
    let mut all: Vec<f64> = ducts.flat_map(along).filter(|x| *x <= shortest).collect();
    all.dedup();
    Ok(all)
}

/// Picks growth rate, angular frequency and the pressures of `set` out of a reading of `others`.
fn rows(set: &[usize], others: &[usize], size: usize) -> Matrix {
    let places = set.iter().filter_map(|m| others.iter().position(|other| other == m));
    let keep: Vec<usize> =
        [0, 1].into_iter().chain(places.map(ModeRows::pressure).flat_map(|row| [row, row + 1])).collect();
    Matrix::from_fn(keep.len(), size, |i, j| f64::from(u8::from(keep[i] == j)))
}

/// What the microphones `now` read without the reference, relative to `second`: with R the pressure of
/// `second`, Q = P/R changes by (dP - Q dR)/R. What the noise of the reference does to P and to R cancels.
fn relative_to(second: usize, now: &[usize], others: &[usize], numbers: &Numbers) -> Numbers {
    let n = numbers.through(&rows(now, others, numbers.values.len()));
    let pressures = n.pressures();
    let Some(k) = now.iter().position(|m| *m == second) else { return n };
    let r = pressures[k];
    let kept: Vec<usize> = (0..pressures.len()).filter(|i| *i != k).collect();
    let factor = |i: usize, j: usize| match j {
        _ if kept[i] == j => 1.0 / r,
        _ if j == k => -pressures[kept[i]] / (r * r),
        _ => C64::ZERO,
    };
    let t = Matrix::from_fn(ModeRows::count(kept.len()), n.values.len(), |i, j| {
        let (Some(a), Some(b)) = (i.checked_sub(2), j.checked_sub(2)) else {
            return f64::from(u8::from(i == j));
        };
        let z = factor(a / 2, b / 2);
        match (a % 2, b % 2) {
            (0, 0) | (1, 1) => z.re,
            (0, _) => -z.im,
            _ => z.im,
        }
    });
    let mut relative = n.through(&t);
    for (i, kept) in kept.iter().enumerate() {
        let q = pressures[*kept] / r;
        let row = ModeRows::pressure(i);
        (relative.values[row], relative.values[row + 1]) = (q.re, q.im);
    }
    relative
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_inference::relative_noise;

    /// Pressures of a reference and three others that change with one parameter.
    fn raw(t: f64) -> [C64; 4] {
        [0.3, 0.8, 1.1, 1.7].map(|x: f64| C64::new((x * t).sin(), 0.2 * x * t))
    }

    fn relative(t: f64, to: usize) -> Vec<C64> {
        let p = raw(t);
        (1..4).filter(|m| *m != to).map(|m| p[m] / p[to]).collect()
    }

    /// The slope against differences; white noise of every microphone against its closed form relative to any
    /// reference.
    #[test]
    fn exact_another_microphone_takes_the_role_of_the_reference() {
        let (t, h) = (0.9, 1e-5);
        let flat = |p: &[C64]| p.iter().flat_map(|z| [z.re, z.im]).collect::<Vec<f64>>();
        let slope = |to: usize| -> Vec<f64> {
            let [a, b] = [t - h, t + h].map(|t| flat(&relative(t, to)));
            a.iter().zip(&b).map(|(a, b)| (b - a) / (2.0 * h)).collect()
        };
        let with = |p: Vec<f64>| [vec![0.0, 0.0], p].concat();
        let white = |p: &[C64]| {
            let n = relative_noise(p);
            let size = n.rows() + 2;
            Matrix::from_fn(size, size, |i, j| if i < 2 || j < 2 { 0.0 } else { n[(i - 2, j - 2)] })
        };
        let all = relative(t, 0);
        let numbers = Numbers {
            values: with(flat(&all)),
            along: vec![(0, with(slope(0)))],
            noise: white(&all),
            stays: Matrix::zeros(8, 8),
            ..Numbers::default()
        };
        let found = relative_to(2, &[1, 2, 3], &[1, 2, 3], &numbers);
        let near = |a: &[f64], b: &[f64], within: f64| {
            assert!(
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < within),
                "{a:?} {b:?}"
            );
        };
        let wanted = relative(t, 2);
        near(&found.values, &with(flat(&wanted)), 1e-14);
        near(&found.along[0].1, &with(slope(2)), 1e-8);
        // The reference, which is left out, was the unit of the noise.
        let scale = (raw(t)[0] / raw(t)[2]).norm_sqr();
        let noise: Vec<f64> = white(&wanted).as_slice().iter().map(|v| v * scale).collect();
        near(found.noise.as_slice(), &noise, 1e-13);
    }
}
