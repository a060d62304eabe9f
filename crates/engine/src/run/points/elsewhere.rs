//! Conditions that are asked for, measured or not, as points beside those of the campaign.

use crate::EngineError;
use rijke_numerics::range;
use rijke_numerics::words::to_digits;
use rijke_rig::Day;
use rijke_study::plan::{Base, MapGrid, Selection};
use rijke_study::{Campaign, Factor, Point, SURROUNDINGS, Study};
use std::collections::BTreeMap;

/// How far beyond the campaign a factor may be asked for, in its range or its largest value.
const FARTHEST: f64 = 5.0;

/// What the ambient temperature of a point and its standard deviation are called beside its factors, K.
pub(in crate::run) const T_AMB: &str = "T_amb";
const T_AMB_SD: &str = "T_amb_sd";

/// A condition that is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AskedPoint {
    /// Values of factors, SI, with `X_sd` the standard deviation of a factor X, and of `T_amb` and
    /// `T_amb_sd`, K.
    pub values: BTreeMap<String, f64>,
    /// The day whose error of T_amb it shares; without one it has an error of its own.
    pub day: Option<String>,
    /// The place in the campaign of the point of which it has all else; without one the nearest.
    like: Option<usize>,
}

impl From<BTreeMap<String, f64>> for AskedPoint {
    fn from(values: BTreeMap<String, f64>) -> Self {
        Self { values, ..Self::default() }
    }
}

impl AskedPoint {
    /// Of these values, with the error of T_amb of a day if one is named.
    #[must_use]
    pub fn new(values: BTreeMap<String, f64>, day: Option<String>) -> Self {
        Self { values, day, like: None }
    }

    fn name(&self) -> String {
        let values = self.values.iter().map(|(name, value)| format!("{name}={}", as_typed(*value)));
        values.chain(self.day.iter().map(|day| format!("day={day}"))).collect::<Vec<_>>().join(" ")
    }
}

/// A number as somebody typed it; one that was computed, as nodes of grids are, to six digits.
fn as_typed(value: f64) -> String {
    const TYPED: usize = 9;
    let all = value.to_string();
    if all.len() <= TYPED { all } else { to_digits(value, 6).to_string() }
}

/// The nodes of a map, row after row of its vertical factor. All else is the same at every node: what `at`
/// says, else what the point of the campaign has, by preference one of `among`, that is nearest to that and
/// to the middle of the map.
///
/// # Errors
/// [`EngineError::Factors`], also for a factor of `at` that is on an axis.
pub fn over_map(
    study: &Study,
    among: &Selection,
    grid: &MapGrid,
    at: &AskedPoint,
) -> Result<Vec<AskedPoint>, EngineError> {
    let campaign = &study.campaign;
    let names = grid.factors.map(|k| campaign.factors[k].name.clone());
    if let Some(name) = names.iter().find(|name| at.values.contains_key(*name)) {
        return Err(failed(campaign, format!("`{name}` is on an axis of the map and cannot be held")));
    }
    let node = |x: f64, y: f64| {
        let mut node = at.clone();
        node.values.extend(names.iter().cloned().zip([x, y]));
        node
    };
    let middle = |k: usize| {
        let values = &grid.values[k];
        0.5 * (values.first().unwrap_or(&f64::NAN) + values.last().unwrap_or(&f64::NAN))
    };
    let (_, like) = given_and_like(study, among, &node(middle(0), middle(1)))?;
    let row = |y: &f64| {
        let of = |x: &f64| AskedPoint { like: Some(like), ..node(*x, *y) };
        grid.values[0].iter().map(of).collect::<Vec<_>>()
    };
    Ok(grid.values[1].iter().flat_map(row).collect())
}

/// The operating points of the campaign with others, and where these are. Each is given by the factors in
/// which it differs from the point of the campaign that is nearest in them: one of those that `among` means,
/// or any if none of these has a value of every factor.
///
/// A condition that is no point of the campaign has factors as they are set, unless it states a deviation
/// `X_sd`, or all points share the error of X. It has an error of its ambient temperature of its own, of the
/// standard deviation `T_amb_sd`, or of that of the point that it is like; it shares that of a day if it
/// names one.
///
/// # Errors
/// [`EngineError::Factors`].
pub fn with_points<A: Clone + Into<AskedPoint>>(
    study: &Study,
    among: &Selection,
    asked: &[A],
) -> Result<(Study, Vec<usize>), EngineError> {
    let campaign = &study.campaign;
    let mut wider = study.clone();
    let mut places = Vec::new();
    for asked in asked {
        let asked: AskedPoint = asked.clone().into();
        let (given, like) = given_and_like(study, among, &asked)?;
        let like = &campaign.points[like];
        let name = asked.name();
        let mut point = Point {
            id: name.clone(),
            installation: name.clone(),
            factor_sds: sds_of(study, like, &asked),
            day: asked.day.clone().unwrap_or_default(),
            ..like.clone()
        };
        given.iter().for_each(|(k, value)| point.factors[*k] = *value);
        let [ambient, sd] = [T_AMB, T_AMB_SD].map(|name| asked.values.get(name).copied());
        if let Some(kelvin) = ambient.or(point.ambient.map(|[kelvin, _]| kelvin)) {
            point.ambient = Some([kelvin, sd.or(point.ambient.map(|[_, sd]| sd)).unwrap_or(0.0)]);
        } else if sd.is_some() {
            return Err(failed(campaign, format!("{T_AMB_SD} is given, but no {T_AMB}")));
        }
        // A point of the campaign is itself, unless its surroundings are asked for too: what is known of its
        // gas is known.
        let itself = |p: &Point| {
            let mut factors = p.factors.iter().zip(&point.factors);
            let day = asked.day.as_ref().is_none_or(|day| *day == p.day);
            let as_set = campaign.factors.iter().all(|f| !asked.values.contains_key(&sd_of(&f.name)));
            ambient.or(sd).is_none()
                && as_set
                && asked.like.is_none()
                && day
                && p.row == like.row
                && factors.all(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
        };
        let before = wider.campaign.points.iter().skip(campaign.points.len()).position(|p| p.id == name);
        let there = campaign.points.iter().position(itself);
        if let Some(known) = there.or(before.map(|k| campaign.points.len() + k)) {
            places.push(known);
            continue;
        }
        if matches!(&study.plan.base, Base::States(due) if due.points.contains(&like.id)) {
            let what = format!(
                "the gas at {name} is that of its clicks, and `points` of [base.states] names the points with such gas one by one; name their `rows`, \
                 or factors that only they have, so that it can be predicted"
            );
            return Err(failed(campaign, what));
        }
        places.push(wider.campaign.points.len());
        wider.campaign.points.push(point);
    }
    Ok((wider, places))
}

/// Standard deviations of the factors of a condition: what is asked is what is set, but where a meter has an
/// error that all points share it reads wrongly here too, and where the condition states a deviation.
fn sds_of(study: &Study, like: &Point, asked: &AskedPoint) -> Vec<f64> {
    let one = |(k, factor): (usize, &Factor)| {
        if let Some(stated) = asked.values.get(&sd_of(&factor.name)) {
            return *stated;
        }
        if !study.plan.common_errors.contains(&factor.name) {
            return 0.0;
        }
        asked.values.get(&factor.name).map_or(like.factor_sds[k], |value| sd_at(&study.campaign, k, *value))
    };
    study.campaign.factors.iter().enumerate().map(one).collect()
}

/// The standard deviation of factor `k` at another value: that of the campaign on straight lines between its
/// values, and beyond them. So that of a meter may be one number, or a share of what it reads.
fn sd_at(campaign: &Campaign, k: usize, value: f64) -> f64 {
    let stated = campaign.points.iter().map(|p| (p.factors[k], p.factor_sds[k]));
    let mut known: Vec<(f64, f64)> = stated.filter(|(v, sd)| v.is_finite() && sd.is_finite()).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    known.dedup_by_key(|(v, _)| *v);
    let last = known.len().saturating_sub(1);
    let upper = known.partition_point(|(v, _)| *v < value).clamp(1, last.max(1));
    match (known.get(upper - 1), known.get(upper)) {
        (Some((v0, sd0)), Some((v1, sd1))) => (sd0 + (sd1 - sd0) * (value - v0) / (v1 - v0)).max(0.0),
        (Some((_, sd)), None) => *sd,
        (None, _) => 0.0,
    }
}

/// What the standard deviation of a factor is called beside it.
fn sd_of(factor: &str) -> String {
    format!("{factor}_sd")
}

/// The point of the campaign of which a condition has all that it does not say.
///
/// # Errors
/// [`EngineError::Factors`].
pub fn nearest<'a>(
    study: &'a Study,
    among: &Selection,
    asked: &AskedPoint,
) -> Result<&'a Point, EngineError> {
    given_and_like(study, among, asked).map(|(_, like)| &study.campaign.points[like])
}

fn failed(campaign: &Campaign, what: String) -> EngineError {
    let known = campaign.factors.iter().map(|f| f.name.as_str()).collect::<Vec<_>>().join(", ");
    EngineError::Factors { what, known }
}

/// The factors that a condition gives, by their places, and the place of the point of which it has all else.
fn given_and_like(
    study: &Study,
    among: &Selection,
    asked: &AskedPoint,
) -> Result<(Vec<(usize, f64)>, usize), EngineError> {
    let Study { campaign, rig, .. } = study;
    let fail = |what: String| Err(failed(campaign, what));
    let mut given = Vec::new();
    for (name, value) in &asked.values {
        if name == T_AMB {
            let [coldest, hottest] = SURROUNDINGS;
            if !(coldest..=hottest).contains(value) {
                let range = format!("an ambient temperature lies from {coldest} to {hottest} K");
                return fail(format!("{name} = {value}: {range}"));
            }
            continue;
        }
        if name == T_AMB_SD {
            let widest = Day::LARGEST_SD;
            if !(0.0..=widest).contains(value) {
                return fail(format!("{name} = {value}: a standard deviation lies from 0 to {widest} K"));
            }
            continue;
        }
        if campaign.factor(name).is_none() && campaign.factors.iter().any(|f| sd_of(&f.name) == *name) {
            if !(*value >= 0.0 && value.is_finite()) {
                return fail(format!("{name} = {value}: a standard deviation is zero or more"));
            }
            continue;
        }
        let Some(k) = campaign.factor(name) else {
            return fail(format!("there is no factor called `{name}`"));
        };
        let [low, high] = range_of(campaign, k);
        // A unit of another size is further away than any sound extrapolation.
        let reach = FARTHEST * (high - low).max(low.abs()).max(high.abs());
        // A part that no point has, or all have, may be put in or taken out.
        let switches = rig.parts.iter().any(|part| rig.presence(part) == Some(k));
        if !(switches && [0.0, 1.0].contains(value)) && (*value < low - reach || *value > high + reach) {
            let unit = campaign.factors[k].unit_in_print();
            return fail(format!(
                "{name} = {value} {unit} is far from every point of the campaign ({low} to {high} {unit}): numbers are in SI units; if it is meant, write it as a row of campaign.csv \
                 without a measurement, and predict that point"
            ));
        }
        given.push((k, *value));
    }
    if let Some(day) = &asked.day
        && !campaign.points.iter().any(|p| p.day == *day)
    {
        let mut days: Vec<&str> =
            campaign.points.iter().map(|p| p.day.as_str()).filter(|day| !day.is_empty()).collect();
        days.sort_unstable();
        days.dedup();
        let known = if days.is_empty() { "it names none".to_owned() } else { days.join(", ") };
        return fail(format!("the campaign has no day `{day}` ({known})"));
    }
    if let Some(like) = asked.like {
        return Ok((given, like));
    }
    let has = |p: &Point| given.iter().all(|(k, _)| p.factors[*k].is_finite());
    // As like it as possible in what was asked: what is not asked is taken from there.
    let scale = |k: usize| {
        let [low, high] = range_of(campaign, k);
        if high > low { high - low } else { 1.0 }
    };
    let distance =
        |p: &Point| given.iter().map(|(k, v)| ((p.factors[*k] - v) / scale(*k)).powi(2)).sum::<f64>();
    let another = |p: &Point| asked.day.as_ref().is_some_and(|day| *day != p.day);
    let rank = |p: &Point| (another(p), !among.holds(campaign, p));
    let order = |a: &Point, b: &Point| rank(a).cmp(&rank(b)).then(distance(a).total_cmp(&distance(b)));
    let all = campaign.points.iter().enumerate().filter(|(_, p)| has(p));
    match all.min_by(|a, b| order(a.1, b.1)) {
        Some((like, _)) => Ok((given, like)),
        None => fail("no point of the campaign has a value of all these factors".to_owned()),
    }
}

/// The lowest and the highest value of a factor in the campaign.
fn range_of(campaign: &Campaign, k: usize) -> [f64; 2] {
    range(campaign.points.iter().map(|p| p.factors[k]).filter(|v| v.is_finite()))
}
