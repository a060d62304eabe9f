//! The base flow of operating points that were not measured, by the posterior of those that were.

use super::{readings, states};
use crate::failure::{Classify, Failure};
use crate::ui::Ui;
use rijke_flow::{BaseStates, Closures, PROFILES, Pipe, settled};
use rijke_rig::{Day, Observations, OperatingPoint, PointObservations};
use rijke_study::{Campaign, Cause, Point, PointState, Study, plan::Base, read_states};
use std::collections::BTreeMap;

/// Standard deviations of the mass flow up to which two fits of the same flow are the same: each ends a
/// seventieth of one from the most probable flow at the latest.
const SAME: f64 = 0.05;

/// Adds to the study the states of the points `places` that `base/states.json` lacks, by the fit of which
/// that file was made. Where the flow is not inferred from clicks or readings nothing is added, and the
/// points are refused later.
pub(crate) fn foresee(study: &mut Study, places: &[usize], ui: &Ui) -> Result<(), Failure> {
    let folder = study.folder.join("observations");
    let path = study.folder.join("base").join("states.json");
    let Base::States(due) = &study.plan.base else { return Ok(()) };
    if !super::is_due(study) || !path.is_file() || folder.join(PROFILES).is_file() {
        return Ok(());
    }
    let known = read_states(&path, &study.rig).or_bad_input()?;
    let lacking = |point: &&Point| due.holds(&study.campaign, point) && !known.contains_key(&point.id);
    let lacking: Vec<&Point> = places.iter().map(|k| &study.campaign.points[*k]).filter(lacking).collect();
    if lacking.is_empty() {
        return Ok(());
    }
    let mut observations = Observations::read(&folder).or_bad_input()?;
    let (_, readings) = readings(&folder, &observations)?;
    let measured =
        Measured::of(&study.campaign, &observations).map_err(|why| Failure::bad_input(why).at(&folder))?;
    let asked = lacking.iter().map(|p| measured.planned(p)).collect::<Result<Vec<_>, String>>();
    let asked = asked.map_err(|why| {
        Failure::bad_input(why).remedy("Ask for points that differ from measured ones in these two alone.")
    })?;
    observations.points.extend(asked);
    let progress = ui.progress("base flow of points that were not measured", 1);
    let make = |heater: f64| Pipe::new(&observations.rig, &Closures::default(), heater, 1);
    let runs = settled::runs(&observations, &readings, &make).or_bad_input().map_err(|f| f.at(&folder))?;
    let fit = settled::JointFit::new(&runs).map_err(super::blame)?;
    let points = fit.base_states().or_failed()?.into_iter().collect();
    drop(progress);
    let found = BaseStates { kind: observations.kind, source: observations.source.clone(), points };
    let mut all = BTreeMap::new();
    for (id, record) in states::states(&found, &observations).points {
        let state = record.state(&id, &study.rig).or_failed()?;
        all.insert(id, state);
    }
    let signs = signs(&known, &all).ok_or_else(|| {
        Failure::bad_input("base/states.json is not what the observations say of the flow today, so that nothing can be foreseen by them")
            .at(&path)
            .remedy("Run `rijke flow` without --closures and --separate, or `rijke run`, then `rijke rank`; or predict measured points.")
    })?;
    let lacking: Vec<String> = lacking.iter().map(|p| p.id.clone()).collect();
    for id in lacking {
        if let Some(mut state) = all.remove(&id) {
            let turned = state.errors.iter_mut().filter(|e| signs.get(&e.cause) == Some(&false));
            turned.for_each(|error| {
                error.mass_flow = -error.mass_flow;
                error.numbers.iter_mut().chain(&mut error.temperature).for_each(|v| *v = -*v);
            });
            study.foreseen.insert(id, state);
        }
    }
    Ok(())
}

/// Kelvin and share of the mass flow that weigh alike where changes of states are compared.
const KELVIN: f64 = 300.0;
/// Share of all changes, root of the sum of squares, by which two lists of the same causes may differ.
const CAUSES: f64 = 0.05;

/// For every cause whether it has the same sign in both; none if the states or the causes are not the same.
fn signs(
    known: &BTreeMap<String, PointState>,
    found: &BTreeMap<String, PointState>,
) -> Option<BTreeMap<Cause, bool>> {
    // Of every cause the squares of both changes, and their product.
    let mut sums: BTreeMap<Cause, [f64; 3]> = BTreeMap::new();
    for (id, old) in known {
        let new = found.get(id)?;
        let sd = old.errors.iter().map(|e| e.mass_flow.powi(2)).sum::<f64>().sqrt();
        if old.places.len() != new.places.len() || (old.mass_flow - new.mass_flow).abs() > SAME * sd {
            return None;
        }
        for error in &old.errors {
            let same = new.errors.iter().find(|e| e.cause == error.cause)?;
            let sum = sums.entry(error.cause.clone()).or_default();
            let kelvins =
                error.temperature.iter().zip(&same.temperature).map(|(a, b)| [a / KELVIN, b / KELVIN]);
            let flow = [error.mass_flow / old.mass_flow, same.mass_flow / old.mass_flow];
            for [a, b] in kelvins.chain([flow]) {
                *sum = [sum[0] + a * a, sum[1] + b * b, sum[2] + a * b];
            }
        }
    }
    let all: f64 = sums.values().map(|s| s[0]).sum();
    let apart: f64 = sums.values().map(|s| s[0] + s[1] - 2.0 * s[2].abs()).sum();
    (apart <= CAUSES.powi(2) * all).then(|| sums.into_iter().map(|(cause, s)| (cause, s[2] > 0.0)).collect())
}

/// Measured points in the words of the study and of the records.
struct Measured<'a> {
    campaign: &'a Campaign,
    pairs: Vec<(&'a Point, &'a PointObservations)>,
    /// The factors that are the place of the heater and its power.
    place: usize,
    power: usize,
}

impl<'a> Measured<'a> {
    fn of(campaign: &'a Campaign, observations: &'a Observations) -> Result<Self, String> {
        let hot = observations.points.iter().filter(|p| p.point.position.is_some() && p.point.power > 0.0);
        let pairs: Vec<_> = hot.filter_map(|o| Some((campaign.point(&o.point.id)?.1, o))).collect();
        let factor = |what: &str, of: &dyn Fn(&OperatingPoint) -> Option<f64>| {
            let fits = |k: &usize| {
                let same = |(p, o): &(&Point, &PointObservations)| {
                    of(&o.point).is_some_and(|v| (p.factors[*k] - v).abs() <= 1e-9 * v.abs())
                };
                !pairs.is_empty() && pairs.iter().all(same)
            };
            let found: Vec<usize> = (0..campaign.factors.len()).filter(fits).collect();
            match found[..] {
                [one] => Ok(one),
                _ => Err(format!(
                    "{} factors of campaign.csv are {what} of the points that were measured; to foresee the flow elsewhere it must be one",
                    found.len()
                )),
            }
        };
        let place = factor("the place of the heater", &|p| p.position)?;
        let power = factor("the power", &|p| Some(p.power))?;
        Ok(Self { campaign, pairs, place, power })
    }

    /// A point as one of the records at which nothing was measured.
    fn planned(&self, point: &Point) -> Result<PointObservations, String> {
        let differs = |p: &Point| {
            let of = |k: &usize| {
                let (a, b) = (p.factors[*k], point.factors[*k]);
                *k != self.place && *k != self.power && a != b && !(a.is_nan() && b.is_nan())
            };
            (0..self.campaign.factors.len()).find(of)
        };
        let near = |p: &Point| (p.factors[self.place] - point.factors[self.place]).abs();
        let like = self
            .pairs
            .iter()
            .filter(|(p, _)| differs(p).is_none())
            .min_by(|a, b| near(a.0).total_cmp(&near(b.0)));
        let Some((_, like)) = like else {
            let names = [self.place, self.power].map(|k| self.campaign.factors[k].name.as_str());
            let other = self
                .pairs
                .first()
                .and_then(|(p, _)| differs(p))
                .map_or("a factor", |k| &self.campaign.factors[k].name);
            return Err(format!(
                "{}: the flow is foreseen at other {} and {}, but no measured point has this `{other}`",
                point.id, names[0], names[1]
            ));
        };
        let mut ambient = like.ambient.clone();
        if let Some([kelvin, sd]) = point.ambient
            && kelvin != ambient.ambient_temperature
        {
            ambient = Day { id: point.id.clone(), ambient_temperature: kelvin, ambient_temperature_sd: sd };
        }
        let (position, power) = (Some(point.factors[self.place]), point.factors[self.power]);
        let point = OperatingPoint { id: point.id.clone(), position, power, ..like.point.clone() };
        Ok(PointObservations::unmeasured(point, ambient))
    }
}
