//! Gas that a part heats and the wall cools, in a forced flow that is a factor: the base states of all
//! points from readings of thermometers.
//!
//! Upstream of the part the gas has the ambient temperature. There its enthalpy rises by eta Q/m, and behind
//! it m c_p dT/dx = -h P (T - T_amb): a plug of gas in a duct of perimeter P whose wall stays at the ambient
//! temperature (Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, section 8.3), with the c_p of the
//! rig's gas at every temperature. eta and h are one number each for all points, with the priors of
//! `study.toml`; their error is shared by all. No heat transfer is one constant: how h differs behind the
//! part, with flow and with the rise is inferred along ([`gas::Varies`]). What the
//! readings of a point differ by from that, beyond their own errors, is an error of its rise: that of
//! meters of power and flow, and of gas that is not mixed. Its size is inferred too.
//!
//! Knows temperatures and flow. Knows no sound and no observation of it.

mod compared;
mod fit;
mod gas;
mod profile;
#[cfg(test)]
mod tests;

pub use compared::HeatedFit;
pub use gas::GasReading;
pub use profile::measured_states;

use crate::Point;
use crate::base::{BaseError, PointState, STEP};
use crate::campaign::{COLDEST, Campaign};
use crate::cause::Cause;
use crate::names::LENGTH;
use crate::plan::HeatedFlow;
use crate::rig::{PartAt, Rig, RigAtPoint};
use crate::source::Source;
use crate::{StudyError, StudyProblem};
use gas::{Heated, VALUES, Varies};
use rijke_numerics::{Matrix, symmetric_eigen};
use rijke_rig::{Heading, Unit};
use std::collections::BTreeSet;
use std::path::Path;

/// Part of the length within which a reading is one of a thermometer.
const NEAR: f64 = 5e-3;

/// No gas of a rig is hotter, K.
const HOTTEST: f64 = 3000.0;

/// Nodes of the profile downstream of the part.
const NODES: usize = 16;

/// Reads `readings.csv`: columns `point`, `at [m]`, `temperature [K]`, `sd [K]`; with `thermometer`, a
/// name, if it is there.
///
/// # Errors
/// File, line and remedy.
pub fn read_readings(path: &Path, campaign: &Campaign, rig: &Rig) -> Result<Vec<GasReading>, StudyError> {
    let source = Source::read_table(path)?;
    let mut reader = source.table();
    let wrong = |error: csv::Error| source.csv(&error);
    let header = reader.headers().map_err(wrong)?.clone();
    let find = |name: &str, unit: &str| -> Result<(usize, Unit), StudyError> {
        for (k, text) in header.iter().enumerate() {
            let heading = Heading::parse(text).map_err(|e| {
                source.at_line(source.header_line(), StudyProblem::Unit { key: text.to_owned(), source: e })
            })?;
            if heading.name == name {
                let unit = heading.of(unit).map_err(|e| {
                    source.at_line(source.header_line(), StudyProblem::Unit { key: name.into(), source: e })
                })?;
                return Ok((k, unit));
            }
        }
        let need = "columns point, at [m], temperature [K], sd [K]";
        Err(source.at_line(source.header_line(), StudyProblem::Missing { key: name.to_owned(), need }))
    };
    let [point, at, temperature, sd] =
        [find("point", "1")?, find("at", "m")?, find("temperature", "K")?, find("sd", "K")?];
    let name = header.iter().position(|text| text.trim() == "thermometer");
    let mut readings = Vec::new();
    for record in reader.records() {
        let record = record.map_err(wrong)?;
        let line = source.line_of(&record);
        if let Some(name) = name.and_then(|k| record.get(k)).map(str::trim).filter(|name| !name.is_empty())
            && !rig.thermometers.names.iter().any(|known| known == name)
        {
            let (name, known) =
                (name.to_owned(), crate::source::listed(rig.thermometers.names.iter().map(String::as_str)));
            return Err(source.at_line(line, StudyProblem::Unknown { what: "thermometer", name, known }));
        }
        let id = record.get(point.0).unwrap_or_default();
        let found = campaign.known_point(id).map_err(|problem| source.at_line(line, problem))?;
        let number = |k: usize, key: &str| -> Result<f64, StudyError> {
            let text = record.get(k).unwrap_or_default();
            text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
                let (key, value) = (key.to_owned(), text.to_owned());
                source.at_line(
                    line,
                    StudyProblem::Value { key, value, need: "a finite number with a decimal point" },
                )
            })
        };
        let read = GasReading {
            point: found,
            at: at.1.to_si(number(at.0, "at")?),
            temperature: temperature.1.to_si(number(temperature.0, "temperature")?),
            sd: sd.1.difference_to_si(number(sd.0, "sd")?),
        };
        if !(read.sd > 0.0 && read.temperature > COLDEST) {
            let (key, value) = ("sd, temperature".to_owned(), format!("{}, {}", read.sd, read.temperature));
            return Err(source.at_line(
                line,
                StudyProblem::Value {
                    key,
                    value,
                    need: "a positive sd and a temperature above 100 K; a heading without a unit is in K: say another, as in temperature [degC]",
                },
            ));
        }
        readings.push(read);
    }
    Ok(readings)
}

/// The base states of all points of a campaign whose ambient temperature is known; `ambient` by point.
///
/// # Errors
/// A reading beyond the ducts. A point whose flow is negative, or that has power without flow, has no
/// state.
pub fn heated_states(
    rig: &Rig,
    campaign: &Campaign,
    plan: &HeatedFlow,
    readings: &[GasReading],
    ambient: &[Option<[f64; 2]>],
    layouts: &[Option<RigAtPoint>],
) -> Result<(Vec<Option<PointState>>, HeatedFit), StudyProblem> {
    let (power, flow) = (campaign.known_factor(&plan.power)?, campaign.known_factor(&plan.flow)?);
    let heating = Heating { rig, plan, power, flow, part: rig.part(&plan.at).map(|(k, _)| k) };
    let heated = |p: usize| match (ambient[p], &layouts[p]) {
        (Some(ambient), Some(layout)) => heating.heated(&campaign.points[p], ambient, layout),
        _ => Ok(None),
    };
    readings.iter().try_for_each(|r| {
        let on = |layout| on_the_ducts(rig, r, &campaign.points[r.point].id, layout);
        layouts[r.point].as_ref().map_or(Ok(()), on)
    })?;
    let mut all = (0..campaign.points.len()).map(heated).collect::<Result<Vec<_>, _>>()?;
    let typical_flow = typical_flow(&all, readings);
    all.iter_mut().flatten().for_each(|heated| heated.compare(typical_flow));
    let prior = [plan.share, plan.cooling];
    let offset_sd = plan.offset_sd.unwrap_or_else(|| typical(readings));
    let [share, cooling] = prior;
    let z = [0.0, 1.0];
    let found = fit::fit(&all, readings, [share, cooling, z, z, z, z], [offset_sd, plan.excess_sd])?;
    let count = if plan.cooling_varies > 0.0 { VALUES } else { 2 };
    let (values, shared) = (found.values, components(&found.covariance, count)?);
    let read = !readings.is_empty();
    // What the readings say of eta and h stays where a factor is another within its error.
    let moved = |point: &Point, k: usize, ambient: [f64; 2]| {
        let mut moved = point.clone();
        moved.factors[k] += STEP * point.factor_sds[k];
        let layout = rig.at(&moved, ambient[0]).ok()?;
        let mut heated = heating.heated(&moved, ambient, &layout).ok()??;
        heated.compare(typical_flow);
        Some((k, state(rig, &moved.id, &heated, layout.length, values, &shared, found.scatter)))
    };
    let state = |(p, heated): (usize, &Option<Heated>)| {
        let (point, heated, layout) = (&campaign.points[p], heated.as_ref()?, layouts[p].as_ref()?);
        let state = state(rig, &point.id, heated, layout.length, values, &shared, found.scatter);
        let uncertain = (0..point.factor_sds.len()).filter(|k| point.factor_sds[*k] > 0.0);
        let with = |k: usize| {
            let (k, moved) = moved(point, k, heated.ambient)?;
            // Of errors of power and flow the readings know what they do to the temperature.
            let by_readings = read && (k == power || k == flow);
            let kept = || PointState { mass_flow: moved.mass_flow, ..state.clone() };
            Some((k, if by_readings { kept() } else { moved }))
        };
        let moved = uncertain.filter_map(with).collect();
        Some(PointState { moved, ..state })
    };
    let states = all.iter().enumerate().map(state).collect();
    let against = |r: &GasReading| {
        let heated = all.get(r.point)?.as_ref()?;
        Some([r.temperature - heated.temperature(r.at, values).0, heated.ambient[1]])
    };
    let cold = |r: &GasReading| all.get(r.point).and_then(Option::as_ref).is_some_and(|h| h.rise == 0.0);
    let (sds, id) = ([offset_sd, plan.cooling_varies], |p: usize| campaign.points[p].id.as_str());
    Ok((states, HeatedFit::new(&found, prior, readings, against, cold, sds, id)))
}

/// What heats the gas of a rig: the factors that are its power and the flow, and its part.
struct Heating<'a> {
    rig: &'a Rig,
    plan: &'a HeatedFlow,
    power: usize,
    flow: usize,
    part: Option<usize>,
}

impl Heating<'_> {
    /// The heated gas of a point; none of one that has no state.
    fn heated(
        &self,
        point: &Point,
        ambient: [f64; 2],
        layout: &RigAtPoint,
    ) -> Result<Option<Heated>, StudyProblem> {
        let Self { rig, plan, .. } = *self;
        let value = |k: usize| Some(point.factors[k]).filter(|v| !v.is_nan()).unwrap_or(0.0);
        let (power, flow) = (value(self.power), value(self.flow));
        let gas = rig.gas.at(ambient[0], rig.pressure);
        let mass_flow = gas.density * flow;
        let at = match self.part.and_then(|k| layout.parts.get(k)) {
            Some(PartAt::Places(places)) => places.iter().sum::<f64>() / places.len() as f64,
            _ => layout.numbers[LENGTH],
        };
        let watts = if at < layout.length { power } else { 0.0 };
        // Of such a point no state is known, which matters if it is asked for.
        if power < 0.0 {
            let (key, value) = (format!("{} of {}", plan.power, point.id), format!("{power} W"));
            return Err(StudyProblem::Value { key, value, need: "zero or more: it heats the gas" });
        }
        if mass_flow < 0.0 || (watts > 0.0 && mass_flow <= 0.0) {
            return Ok(None);
        }
        let expected = plan.share[0] * watts / (mass_flow * gas.specific_heat);
        if watts > 0.0 && ambient[0] + expected > HOTTEST {
            let key = format!("{} and {} of {}", plan.power, plan.flow, point.id);
            let value = format!("{watts} W into {flow} m^3/s, which is {:.0} K", ambient[0] + expected);
            return Err(StudyProblem::Value { key, value, need: "gas below 3000 K: check both units" });
        }
        let diameter = 2.0 * (layout.areas(at)[1] / std::f64::consts::PI).sqrt();
        let perimeter = std::f64::consts::PI * diameter;
        let capacity = mass_flow * gas.specific_heat;
        let (rise, cooling) = if watts > 0.0 { (watts / capacity, perimeter / capacity) } else { (0.0, 0.0) };
        let cause = Cause::ambient(point);
        let growth = rig.gas.growth_of_heat_capacity(ambient[0]);
        let varies = Varies { by: plan.cooling_varies, diameter, doublings: [0.0; 2] };
        Ok(Some(Heated { ambient, cause, mass_flow, rise, at, cooling, growth, varies }))
    }
}

/// Refuses a reading of the point `id` beyond the ducts, or where no thermometer is.
fn on_the_ducts(rig: &Rig, r: &GasReading, id: &str, layout: &RigAtPoint) -> Result<(), StudyProblem> {
    if !(0.0..=layout.length).contains(&r.at) {
        let (key, value) = (format!("at of {id}"), format!("{} m", r.at));
        return Err(StudyProblem::Value { key, value, need: "on the ducts, from 0 to their total length" });
    }
    let places = || rig.thermometers.at.iter().map(|at| at.at(&layout.numbers));
    if rig.thermometers.at.is_empty() || places().any(|at| (at - r.at).abs() <= NEAR * layout.length) {
        return Ok(());
    }
    let one = |(name, at): (&String, f64)| format!("{name} at {at:.4} m");
    let known: Vec<String> = rig.thermometers.names.iter().zip(places()).map(one).collect();
    let known = crate::source::listed(known.iter().map(String::as_str));
    let name = format!("{} m, at {id}", r.at);
    Err(StudyProblem::Unknown { what: "place of a thermometer", name, known })
}

/// Root mean square of the stated errors of readings, K: what calibration makes of it is common to many.
fn typical(readings: &[GasReading]) -> f64 {
    (readings.iter().map(|r| r.sd * r.sd).sum::<f64>() / readings.len().max(1) as f64).sqrt()
}

/// Geometric means of the flow and of the rise over the points with readings behind heat; none without any.
fn typical_flow(all: &[Option<Heated>], readings: &[GasReading]) -> Option<[f64; 2]> {
    let read: BTreeSet<usize> = readings.iter().map(|r| r.point).collect();
    let hot = read.iter().filter_map(|p| all.get(*p)?.as_ref()).filter(|h| h.rise > 0.0);
    let (mut count, mut sum) = (0.0, [0.0; 2]);
    for h in hot {
        count += 1.0;
        sum = [sum[0] + h.mass_flow.ln(), sum[1] + h.rise.ln()];
    }
    (count > 0.0).then(|| sum.map(|s| (s / count).exp()))
}

/// Independent directions of the error of the first `count` values, one standard deviation each.
fn components(covariance: &Matrix, count: usize) -> Result<Vec<[f64; VALUES]>, StudyProblem> {
    let symmetric = Matrix::from_fn(count, count, |i, j| 0.5 * (covariance[(i, j)] + covariance[(j, i)]));
    let (values, vectors) = symmetric_eigen(&symmetric).map_err(|_| StudyProblem::Unexplained)?;
    let direction = |k: usize| {
        let sd = values[k].max(0.0).sqrt();
        std::array::from_fn(|i| if i < count { vectors[(i, k)] * sd } else { 0.0 })
    };
    Ok((0..count).map(direction).collect())
}

fn state(
    rig: &Rig,
    point: &str,
    heated: &Heated,
    length: f64,
    values: [f64; VALUES],
    shared: &[[f64; VALUES]],
    scatter: f64,
) -> PointState {
    let mut state =
        PointState::uniform(rig, length, heated.ambient[0], heated.ambient[1], heated.cause.clone());
    state.mass_flow = heated.mass_flow;
    if heated.rise == 0.0 || heated.at >= length {
        return state;
    }
    // Closer nodes where the gas cools fastest.
    let behind = |k: usize| heated.at + (length - heated.at) * (k as f64 / (NODES - 1) as f64).powf(1.5);
    state.places = [0.0, heated.at].into_iter().chain((0..NODES).map(behind)).collect();
    let at = |k: usize, x: f64| {
        if k < 2 {
            (heated.ambient[0], [0.0; VALUES])
        } else {
            heated.temperature(x.max(heated.at + 1e-12), values)
        }
    };
    let nodes: Vec<(f64, [f64; VALUES])> = state.places.iter().enumerate().map(|(k, x)| at(k, *x)).collect();
    state.temperature = nodes.iter().map(|t| t.0).collect();
    state.kinks = vec![[heated.at, heated.at]];
    for error in &mut state.errors {
        error.temperature = vec![heated.ambient[1]; nodes.len()];
    }
    let error = |of: &str, temperature| {
        let cause = Cause::Inferred(format!("the temperature behind heat ({of})"));
        BaseError { cause, mass_flow: 0.0, numbers: Vec::new(), temperature }
    };
    for (k, direction) in shared.iter().enumerate() {
        let along = |slopes: &[f64; VALUES]| slopes.iter().zip(direction).map(|(t, d)| t * d).sum();
        let change = nodes.iter().map(|t| along(&t.1)).collect();
        state.errors.push(error(&format!("all points, principal error {}", k + 1), change));
    }
    let change = nodes.iter().map(|t| scatter * (t.0 - heated.ambient[0])).collect();
    state.errors.push(error(point, change));
    state
}
