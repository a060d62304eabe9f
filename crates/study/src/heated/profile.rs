//! Gas as thermometers read it: a profile between the places of the readings of a point, and a forced flow.

use super::GasReading;
use crate::StudyProblem;
use crate::base::{BaseError, PointState};
use crate::campaign::Campaign;
use crate::cause::{Cause, Sharing};
use crate::plan::MeasuredGas;
use crate::rig::{Rig, RigAtPoint};

/// Places nearer than this part of the length are one.
const SAME: f64 = 1e-6;

/// How far above ambient gas is heated, K, in standard deviations of a reading besides.
const HEATED: [f64; 2] = [1.0, 4.0];

/// The base states of all points: the temperature is linear between the readings of a point and constant
/// beyond them. A point without readings has those of one with the same factors and the same ambient
/// temperature, else the `ambient` temperature: unless all factors that are above zero at a point of heated
/// gas are so here, for then its gas is not known. The flow is that of a factor, at the temperature of the
/// inlet.
///
/// The error of the reading at a place is one number for all points that have a reading there, and
/// `offset_sd` one for all readings.
///
/// # Errors
/// A reading beyond the ducts, two at one place, a flow without unit. A point of which no temperature is
/// known, ambient or by readings, has no state.
pub fn measured_states(
    rig: &Rig,
    campaign: &Campaign,
    plan: &MeasuredGas,
    readings: &[GasReading],
    ambient: &[Option<[f64; 2]>],
    layouts: &[Option<RigAtPoint>],
) -> Result<Vec<Option<PointState>>, StudyProblem> {
    let flow = plan.flow.as_ref().map(|name| campaign.known_factor(name)).transpose()?;
    // Thermometers, by their places.
    let mut places: Vec<f64> = readings.iter().map(|r| r.at).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() <= SAME);
    let thermometer = |at: f64| 1 + places.iter().take_while(|p| **p < at - SAME).count();
    let known = Known::of(campaign, readings, ambient);
    let one = |p: usize| -> Result<Option<PointState>, StudyProblem> {
        let (point, Some(layout)) = (&campaign.points[p], &layouts[p]) else { return Ok(None) };
        let Some(with) = known.readings_for(p) else { return Ok(None) };
        let mut read: Vec<&GasReading> = readings.iter().filter(|r| r.point == with).collect();
        read.sort_by(|a, b| a.at.total_cmp(&b.at));
        let wrong = |value: String, need| {
            Err(StudyProblem::Value { key: format!("at of {}", point.id), value, need })
        };
        if let Some(r) = read.iter().find(|r| !(0.0..=layout.length).contains(&r.at)) {
            return wrong(format!("{} m", r.at), "on the ducts, from 0 to their total length");
        }
        if let Some(w) = read.windows(2).find(|w| w[1].at - w[0].at <= SAME * layout.length) {
            return wrong(format!("{} m", w[0].at), "one reading for each place of an operating point");
        }
        let mut state = match (read.first(), read.last(), ambient[p]) {
            (Some(first), Some(last), _) => {
                let inside = read.iter().filter(|r| r.at > 0.0 && r.at < layout.length);
                let ends = |at: f64, r: &GasReading| [at, r.temperature];
                let nodes: Vec<[f64; 2]> = std::iter::once(ends(0.0, first))
                    .chain(inside.map(|r| ends(r.at, r)))
                    .chain([ends(layout.length, last)])
                    .collect();
                let mut state =
                    PointState::uniform(rig, layout.length, first.temperature, 0.0, Cause::ambient(point));
                state.places = nodes.iter().map(|n| n[0]).collect();
                state.temperature = nodes.iter().map(|n| n[1]).collect();
                state.errors = errors(&state.places, &read, plan.offset_sd, thermometer);
                state
            }
            (_, _, Some([kelvin, sd])) => {
                PointState::uniform(rig, layout.length, kelvin, sd, Cause::ambient(point))
            }
            _ => return Ok(None),
        };
        let value = flow.map_or(0.0, |k| Some(point.factors[k]).filter(|v| v.is_finite()).unwrap_or(0.0));
        let gas = rig.gas.at(state.temperature[0], rig.pressure);
        state.mass_flow = gas.density * value;
        if let Some(sd) = flow.map(|k| point.factor_sds[k]).filter(|sd| *sd > 0.0) {
            let cause = Cause::Flow(Sharing::Point(point.id.clone()));
            let temperature = vec![0.0; state.places.len()];
            let mass_flow = gas.density * sd;
            state.errors.push(BaseError { cause, mass_flow, numbers: Vec::new(), temperature });
        }
        Ok(Some(state))
    };
    (0..campaign.points.len()).map(one).collect()
}

/// At which points the gas was read, and at which of these it is heated.
struct Known<'a> {
    campaign: &'a Campaign,
    ambient: &'a [Option<[f64; 2]>],
    read: Vec<bool>,
    heated: Vec<bool>,
}

impl<'a> Known<'a> {
    fn of(campaign: &'a Campaign, readings: &[GasReading], ambient: &'a [Option<[f64; 2]>]) -> Self {
        let (mut read, mut heated) = (vec![false; ambient.len()], vec![false; ambient.len()]);
        for r in readings {
            read[r.point] = true;
            let above = HEATED[0].max(HEATED[1] * r.sd);
            heated[r.point] |= ambient[r.point].is_none_or(|[t, _]| r.temperature > t + above);
        }
        Self { campaign, ambient, read, heated }
    }

    /// The point whose readings are those of point `p`; none where the gas of `p` must be heated, and was not
    /// read.
    fn readings_for(&self, p: usize) -> Option<usize> {
        let factors = |p: usize| &self.campaign.points[p].factors;
        let same = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
        let like = |q: &usize| {
            let alike = factors(*q).iter().zip(factors(p)).all(|(a, b)| same(*a, *b));
            self.read[*q] && alike && self.ambient[*q].map(|t| t[0]) == self.ambient[p].map(|t| t[0])
        };
        let heats = |q: &usize| {
            let all = factors(*q).iter().zip(factors(p));
            self.heated[*q]
                && all.into_iter().all(|(there, here)| *here > 0.0 || there.is_nan() || *there <= 0.0)
        };
        let points = || 0..self.read.len();
        if self.read[p] {
            return Some(p);
        }
        points().find(like).or_else(|| points().find(heats).is_none().then_some(p))
    }
}

/// One of each thermometer, and what all read too much.
fn errors(
    nodes: &[f64],
    read: &[&GasReading],
    offset_sd: f64,
    thermometer: impl Fn(f64) -> usize,
) -> Vec<BaseError> {
    let error = |number, temperature| {
        let cause = Cause::Reading(number, Sharing::All);
        BaseError { cause, mass_flow: 0.0, numbers: Vec::new(), temperature }
    };
    let own = read.iter().map(|r| {
        // Beyond the outermost readings the temperature is theirs.
        let nearest = |x: &f64| {
            read.iter()
                .min_by(|a, b| (a.at - x).abs().total_cmp(&(b.at - x).abs()))
                .is_some_and(|n| n.at == r.at)
        };
        error(thermometer(r.at), nodes.iter().map(|x| if nearest(x) { r.sd } else { 0.0 }).collect())
    });
    let all = (offset_sd > 0.0).then(|| error(0, vec![offset_sd; nodes.len()]));
    own.chain(all).collect()
}

impl MeasuredGas {
    /// What is wrong with it, and the key.
    pub(crate) fn check(&self, campaign: &Campaign) -> Result<(), (&'static str, StudyProblem)> {
        if !(self.offset_sd >= 0.0 && self.offset_sd.is_finite()) {
            let (key, value) = ("base.measured.offset_sd".to_owned(), format!("{} K", self.offset_sd));
            return Err(("offset_sd", StudyProblem::Value { key, value, need: "zero or more, in K" }));
        }
        let Some(name) = &self.flow else { return Ok(()) };
        let factor = &campaign.factors[campaign.known_factor(name).map_err(|problem| ("flow", problem))?];
        let key = format!("base.measured.flow = {name}");
        if !factor.stated {
            let need = "a factor whose heading in the campaign states its unit, such as flow [L/min]";
            return Err(("flow", StudyProblem::Value { key, value: "a column without unit".into(), need }));
        }
        factor.shown.of("m^3/s").map_err(|source| ("flow", StudyProblem::Unit { key, source }))?;
        Ok(())
    }
}
