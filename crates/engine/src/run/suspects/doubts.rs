//! What speaks against a model although its evidence may be the best: sentences for people.

use super::super::parameter::TrainedParameter;
use super::apart::{Apart, Common, Held, Stated, scattered_days};
use super::unexplained::unexplained;
use crate::Observed;
use crate::noise::measured_sd;
use rijke_inference::{Parameter, Prior};
use rijke_numerics::scatter_beyond;
use rijke_numerics::words::with_sd;
use rijke_study::hertz;

/// Residuals of few points, in those of all others together, that give a warning; smaller ones of two points
/// give one if the points would fit exchanged, to so many of the others' residuals.
const ALONE: f64 = 6.0;
const EXCHANGED: [f64; 2] = [4.0, 2.5];
/// Few points are one of so many, at least one and at most four.
const FEW: usize = 6;

/// Two eigenvalues that differ by less than this part of their size are one.
const ONE_MODE: f64 = 1e-7;

/// Standard deviations from zero beyond which a sign is known.
const CLEARLY: f64 = 5.0;

/// A misfit of relative pressures beyond which mode shapes do not fit.
const SHAPES: f64 = 0.1;

/// Reasons to doubt a model whose growth rates and angular frequencies at the points are `predicted`;
/// `misfit` is what it leaves of growth rate, angular frequency and pressures, and `floats` whether the first
/// two were found, not stated.
pub(in crate::run) fn doubts(
    observed: &[Observed],
    predicted: &[[f64; 2]],
    misfit: [f64; 3],
    floats: [bool; 2],
    stated: Stated,
) -> Vec<String> {
    let mut all = Vec::new();
    for (k, what) in ["growth rates", "frequencies"].into_iter().enumerate() {
        let measured = |o: &Observed| [o.mode.growth_rate, o.mode.angular_frequency][k];
        let there: Vec<Held<'_>> =
            observed.iter().zip(predicted).filter_map(|(o, p)| Some((o, measured(o)?, p[k]))).collect();
        let opposite = |t: &Held<'_>| t.1 > 0.0 && t.2 < 0.0;
        if k == 0 && there.len() > 1 && there.iter().all(opposite) {
            all.push(
                "all measured growth rates are positive and all predicted ones negative: the growth rate of a mode that decays is negative; \
                 write growth rates, if the column holds decay rates or another number of the decay"
                    .to_owned(),
            );
        }
        if there.len() < 5 {
            continue;
        }
        let sd = measured_sd(observed, k);
        let shown = |v: f64| if k == 0 { format!("{v:.2} 1/s") } else { format!("{:.2} Hz", hertz(v)) };
        if floats[k] {
            all.extend(unexplained(what, &there, misfit[k], sd, shown));
        }
        let frequencies = k == 1;
        // A temperature moves frequencies, a part at another place both.
        // Where installations are stated to vary, the one of a day is compared with the others.
        let own = |day: &Apart<'_>| !(stated.installations && day.is_one_installation());
        let day = if frequencies { Common::Day.apart(&there, sd, true, false).filter(own) } else { None };
        let installation = if day.is_some() {
            None
        } else {
            Common::Installation.apart(&there, sd, frequencies, stated.installations)
        };
        let apart: Vec<Apart<'_>> = day.into_iter().chain(installation).collect();
        // Not once more as single points.
        let of_a_group = |found: &Outlying<'_>| {
            apart.iter().any(|group| found.points.iter().all(|t| group.has(&t.0.conditions.id)))
        };
        let outlying = outlying(&there, k).filter(|found| !of_a_group(found));
        all.extend(outlying.map(|found| found.said(what, shown)));
        all.extend(apart.iter().map(|group| group.said(what, shown)));
        all.extend(scattered_days(&there, sd, &apart, stated).filter(|_| frequencies));
    }
    all.extend(one_mode_twice(observed, predicted));
    if misfit[2] > SHAPES {
        all.push(format!(
            "mode shapes do not fit (misfit {:.2} of relative pressures): check order, places and gains of the microphones",
            misfit[2]
        ));
    }
    all
}

/// Parameters that the data give another sign than their prior, most of which lies on its side of zero.
pub(in crate::run) fn other_sign(found: &[TrainedParameter], declared: &[Parameter]) -> Vec<String> {
    // A phase that is kept from its value turns the sign.
    let bounded = declared.iter().filter(|p| matches!(p.prior, Prior::Uniform { .. }));
    let bounded: Vec<&str> = bounded.map(|p| p.name.as_str()).collect();
    let checked = match &bounded[..] {
        [] => "the signs in its law and the phases of its tables".into(),
        names => format!(
            "the signs in its law, the phases of its tables, and the bounds of the prior of {}",
            names.join(" and of ")
        ),
    };
    let one = |parameter: &Parameter| {
        let Prior::Normal { mean, sd } = parameter.prior else { return None };
        let f = found.iter().find(|f| f.name == parameter.name)?;
        let other = f.value * mean < 0.0 && mean.abs() >= sd && f.value.abs() > CLEARLY * f.sd;
        other.then(|| {
            format!(
                "{} = {} has not the sign of its prior, {mean} +- {sd}: if that is impossible, check {checked}",
                f.name,
                with_sd(f.value, f.sd)
            )
        })
    };
    declared.iter().filter_map(one).collect()
}

/// Two measured modes of one point that the model has for one.
fn one_mode_twice(observed: &[Observed], predicted: &[[f64; 2]]) -> Option<String> {
    let here = |k: usize| (&observed[k].conditions.id, &observed[k].mode.label);
    let same = |&(a, b): &(usize, usize)| {
        let apart = (0..2).map(|i| (predicted[a][i] - predicted[b][i]).abs()).fold(0.0, f64::max);
        here(a).0 == here(b).0 && here(a).1 != here(b).1 && apart < ONE_MODE * predicted[a][1].abs()
    };
    let mut pairs = (0..observed.len()).flat_map(|b| (0..b).map(move |a| (a, b))).filter(same);
    let (a, b) = pairs.next()?;
    let (point, others) = (here(a).0, pairs.count());
    let more = if others > 0 { format!(", the first of {} such pairs,", others + 1) } else { String::new() };
    Some(format!(
        "the modes `{}` and `{}` of point {point}{more} are one mode of this model: if they are one, take one of them out, or give both the same \
         label; if they are two, the model lacks one",
        here(a).1,
        here(b).1
    ))
}

/// Points that lie far from a model that fits all others.
struct Outlying<'a> {
    points: Vec<Held<'a>>,
    /// The least of their residuals over what its own error and the scatter of the others explain.
    least: f64,
    exchanged: bool,
    /// Whether modes of several names were measured.
    several_modes: bool,
}

/// The fewest points whose residuals of growth rates (0) or angular frequencies (1) are far beyond their own
/// errors and what all others scatter by beyond theirs.
fn outlying<'a>(there: &[Held<'a>], k: usize) -> Option<Outlying<'a>> {
    let residual = |t: &Held<'_>| (t.1 - t.2).abs();
    let error = |t: &Held<'_>| measured_sd(std::slice::from_ref(t.0), k);
    // First those that are farthest for their error, beside the scatter of half of all.
    let mut squares: Vec<f64> = there.iter().map(|t| residual(t).powi(2) - error(t).powi(2)).collect();
    squares.sort_by(f64::total_cmp);
    let typical = squares[squares.len() / 2].max(0.0);
    let far = |t: &Held<'_>| residual(t) / (error(t).powi(2) + typical).sqrt();
    let mut order = there.to_vec();
    order.sort_by(|a, b| far(b).total_cmp(&far(a)));
    let of = |count: usize| {
        let (points, rest) = order.split_at(count);
        let each: Vec<[f64; 2]> = rest.iter().map(|t| [residual(t).powi(2), error(t).powi(2)]).collect();
        let beyond = scatter_beyond(&each);
        let allowed = |t: &Held<'_>| (error(t).powi(2) + beyond).sqrt();
        let least = points.iter().map(|t| residual(t) / allowed(t)).fold(f64::INFINITY, f64::min);
        let exchanged = match points {
            [a, b] => [(a, b), (b, a)].iter().all(|(a, b)| (a.1 - b.2).abs() < EXCHANGED[1] * allowed(a)),
            _ => false,
        };
        let far = least > ALONE || (exchanged && least > EXCHANGED[0]);
        let several_modes = there.iter().any(|t| t.0.mode.label != there[0].0.mode.label);
        far.then(|| Outlying { points: points.to_vec(), least, exchanged, several_modes })
    };
    (1..=few(there.len())).find_map(of)
}

/// How many of so many points are few.
pub(in crate::run) fn few(points: usize) -> usize {
    (points / FEW).clamp(1, 4)
}

impl Outlying<'_> {
    /// Whose assembly of the rig is to be checked with the points, if they are all of one that the campaign
    /// names.
    fn installation(&self) -> String {
        let of = |t: &Held<'_>| {
            let point = &t.0.conditions.point;
            (point.installation != point.id).then(|| point.installation.clone())
        };
        let first = self.points.first().and_then(of);
        let one = first.filter(|name| self.points.iter().all(|t| of(t).as_ref() == Some(name)));
        one.map_or_else(String::new, |name| format!(", and how installation {name} was put together"))
    }

    /// "H2 and H7 lie 4.25 and -5.31 1/s from the model".
    fn said(&self, what: &str, shown: impl Fn(f64) -> String) -> String {
        let list =
            |of: &dyn Fn(&Held<'_>) -> String| self.points.iter().map(of).collect::<Vec<_>>().join(", ");
        let (mut ids, mut twice): (Vec<&str>, bool) = (Vec::new(), false);
        for point in &self.points {
            let id = point.0.conditions.id.as_str();
            twice |= ids.contains(&id);
            ids.push(id);
        }
        let names = list(&|t| match twice || self.several_modes {
            true => format!("{} (mode {})", t.0.conditions.id, t.0.mode.label),
            false => t.0.conditions.id.clone(),
        });
        let least = self.least;
        match &self.points[..] {
            [one] => format!(
                "{names} alone lies {} from the model in its {what}, {least:.0} times what its error and the scatter of the others explain: check that \
                 point{}; if it is right, the model lacks what acts there",
                shown((one.1 - one.2).abs()),
                self.installation()
            ),
            _ => format!(
                "{names} lie {} from the model in their {what}, at least {least:.0} times what their errors and the scatter of the others explain: {}",
                list(&|t| shown(t.1 - t.2)),
                if self.exchanged {
                    "exchanged with each other they fit; check whether their rows or records were exchanged"
                        .to_owned()
                } else {
                    format!(
                        "check these points{}; if they are right, the model lacks what acts there",
                        self.installation()
                    )
                }
            ),
        }
    }
}

#[cfg(test)]
pub(in crate::run) mod tests {
    use super::{Stated, doubts};
    use crate::{Conditions, Observed};
    use rijke_numerics::{C64, Matrix};
    use rijke_study::{ObservedMode, OneTable, PointState};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    const NONE: Stated = Stated { installations: false, gas: false };
    const VARY: Stated = Stated { installations: true, gas: false };

    /// Six points whose growth rates are 0, -1, ... -5, measured to 0.1.
    pub(in crate::run) fn points() -> Vec<Observed> {
        // Tests of one process run side by side.
        static CALLS: AtomicUsize = AtomicUsize::new(0);
        let call = CALLS.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("rijke-doubts-{}-{call}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let [rig, table] = ["rig.toml", "modes.csv"].map(|f| folder.join(f));
        let tube = "name = \"tube\"\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"open\"\n\
                    [[element]]\ntype = \"duct\"\nlength = 1.0\ndiameter = 0.05\n";
        std::fs::write(&rig, tube).unwrap();
        std::fs::write(&table, "growth_rate,growth_rate_sd,frequency,frequency_sd\n-1,1,85,1\n").unwrap();
        let (study, _) = OneTable::read(&rig, &table).unwrap().study().unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        let point = study.campaign.points[0].clone();
        let layout = study.rig.at(&point, 293.15).unwrap();
        let base = PointState::of_the_rig(&study.rig, &layout, &point, [293.15, 0.0]).unwrap();
        let one = |k: usize| Observed {
            conditions: Arc::new(Conditions {
                id: format!("p{k}"),
                point: point.clone(),
                layout: layout.clone(),
                base: base.clone(),
                displaced: Vec::new(),
            }),
            mode: ObservedMode {
                point: 0,
                label: String::new(),
                growth_rate: Some(-(k as f64)),
                angular_frequency: Some(500.0 + k as f64),
                pressures: Vec::new(),
                covariance: Matrix::diagonal(&[0.01, 0.01]),
                drift_sd: 0.0,
            },
            near: C64::new(0.0, 500.0),
        };
        (0..6).map(one).collect()
    }

    /// Of growth rates that scatter by sqrt(35/12) 1/s, measured to 0.15 1/s.
    #[test]
    fn exact_a_misfit_is_doubted_from_ten_measured_deviations() {
        let mut points = points();
        points.iter_mut().for_each(|o| o.mode.covariance = Matrix::diagonal(&[0.0225, 0.01]));
        let said =
            |misfit: f64| doubts(&points, &[[-2.5, 502.5]; 6], [misfit, 0.0, 0.0], [true; 2], NONE).len();
        assert_eq!([said(1.45), said(1.55)], [0, 1]);
    }

    #[test]
    fn behaviour_a_model_is_doubted_for_what_it_does_not_explain() {
        let points = points();
        let right: Vec<[f64; 2]> = (0..6).map(|k| [0.05 - f64::from(k), 500.05 + f64::from(k)]).collect();
        assert!(doubts(&points, &right, [0.1, 0.1, 0.02], [true; 2], NONE).is_empty());
        let said = doubts(&points, &[[-2.5, 502.5]; 6], [1.7, 1.7, 0.0], [true; 2], NONE);
        assert!(doubts(&points, &[[-2.5, 502.5]; 6], [1.7, 1.7, 0.0], [false; 2], NONE).is_empty());
        assert!(
            said.len() == 2
                && said[0].contains("explains 1 % of their variance")
                && !said[0].contains("in mode"),
            "{said:?}"
        );
        let mut one_off = right.clone();
        one_off[3][1] += 4.0;
        let said = doubts(&points, &one_off, [0.1, 1.6, 0.0], [true; 2], NONE);
        assert!(said.iter().any(|s| s.starts_with("p3 alone lies 0.6")), "{said:?}");
        // Two points that were exchanged, among thirteen.
        let many: Vec<Observed> = points.iter().chain(&points).chain(&points[..1]).cloned().collect();
        let mut said_of: Vec<[f64; 2]> = right.iter().chain(&right).chain(&right[..1]).copied().collect();
        assert!(doubts(&many, &said_of, [0.1, 0.1, 0.02], [true; 2], NONE).is_empty());
        said_of.swap(1, 3);
        let said = doubts(&many, &said_of, [1.0, 1.0, 0.02], [true; 2], NONE);
        assert!(said.len() == 2 && said[0].starts_with("p3, p1 lie -2.05 1/s, 1.95 1/s from"), "{said:?}");
        assert!(said[0].contains("exchanged with each other they fit"), "{said:?}");
        // Three points of the second day, in air 4 K colder than was read.
        let of_days = |o: &Observed, k: usize| {
            let mut conditions = (*o.conditions).clone();
            conditions.point.day = if k < 3 { "2" } else { "1" }.to_owned();
            Observed { conditions: Arc::new(conditions), ..o.clone() }
        };
        let days: Vec<Observed> = many[..9].iter().enumerate().map(|(k, o)| of_days(o, k)).collect();
        let mut said_of: Vec<[f64; 2]> = right.iter().chain(&right).take(9).copied().collect();
        assert!(doubts(&days, &said_of, [0.1, 0.1, 0.02], [true; 2], NONE).is_empty());
        said_of[..3].iter_mut().for_each(|v| v[1] *= 1.0 + 2.0 / 293.15);
        let said = doubts(&days, &said_of, [0.1, 0.1, 0.02], [true; 2], NONE);
        let expected = "the frequencies of day 2 (p0, p1, p2) lie 0.7 % below the model on average, ";
        assert!(
            said.len() == 1 && said[0].starts_with(expected) && said[0].contains("air 4 K colder"),
            "{said:?}"
        );
        // Four days of eight points, of which none is far from the other three.
        let day = |k: usize| k / 8;
        let four: Vec<Observed> = (0..32)
            .map(|k| {
                let mut conditions = (*points[k % 6].conditions).clone();
                conditions.point.day = day(k).to_string();
                Observed { conditions: Arc::new(conditions), ..points[k % 6].clone() }
            })
            .collect();
        let mut said_of: Vec<[f64; 2]> = (0..32).map(|k| right[k % 6]).collect();
        assert!(doubts(&four, &said_of, [0.1, 0.1, 0.02], [true; 2], NONE).is_empty());
        for (k, v) in said_of.iter_mut().enumerate() {
            v[1] *= 1.0 + [2e-3, -2e-3][day(k) % 2];
        }
        let said = doubts(&four, &said_of, [0.1, 0.1, 0.02], [true; 2], NONE);
        let expected = "the frequencies of the 4 days scatter about the model by 0.23 % from day to day";
        assert!(said.len() == 1 && said[0].starts_with(expected) && said[0].contains("1.4 K"), "{said:?}");
        // The same three points in one installation, whose growth rates are 1 1/s too low.
        let installed: Vec<Observed> = days
            .iter()
            .map(|o| {
                let mut conditions = (*o.conditions).clone();
                let point = &mut conditions.point;
                (point.installation, point.day) = (std::mem::take(&mut point.day), String::new());
                Observed { conditions: Arc::new(conditions), ..o.clone() }
            })
            .collect();
        let mut said_of: Vec<[f64; 2]> = right.iter().chain(&right).take(9).copied().collect();
        assert!(doubts(&installed, &said_of, [0.1, 0.1, 0.02], [true; 2], NONE).is_empty());
        said_of[..3].iter_mut().for_each(|v| v[0] += 1.0);
        let said = doubts(&installed, &said_of, [0.1, 0.1, 0.02], [true; 2], NONE);
        let expected =
            "the growth rates of installation 2 (p0, p1, p2) lie 1.00 1/s below the model on average, ";
        assert!(said.len() == 1 && said[0].starts_with(expected), "{said:?}");
        // Where installations differ by a stated noise, too few others are there to compare one with.
        assert!(doubts(&installed, &said_of, [0.1, 0.1, 0.02], [true; 2], VARY).is_empty());
        let decays: Vec<Observed> = points[1..]
            .iter()
            .map(|o| Observed {
                mode: ObservedMode { growth_rate: o.mode.growth_rate.map(|g| -g), ..o.mode.clone() },
                ..o.clone()
            })
            .collect();
        let said = doubts(&decays, &right[1..], [5.0, 0.1, 0.02], [false; 2], NONE);
        assert!(said.len() == 1 && said[0].contains("another number of the decay"), "{said:?}");
        let said = doubts(&points, &right, [0.1, 0.1, 0.12], [true; 2], NONE);
        assert!(said.len() == 1 && said[0].contains("order, places and gains"), "{said:?}");
    }
}
