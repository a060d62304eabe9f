//! Which operating points are meant.

use crate::source::listed;
use crate::{Campaign, Point, StudyProblem};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A choice of operating points: those that meet every condition.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Selection {
    /// Labels of series; any if empty.
    pub rows: Vec<String>,
    /// Names of points; any if empty.
    pub points: Vec<String>,
    /// Conditions on factors.
    #[serde(rename = "where")]
    pub factors: BTreeMap<String, Condition>,
    /// At most so many, the first of the campaign; all if absent.
    pub first: Option<usize>,
}

/// A condition on a factor, in SI.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// It has this value.
    Equals(f64),
    /// It has one of these values.
    AnyOf(Vec<f64>),
    /// It has a value.
    Given,
    /// It has none.
    Absent,
    /// It is above.
    Above(f64),
    /// It is below.
    Below(f64),
}

impl<'de> Deserialize<'de> for Condition {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let value = toml::Value::deserialize(from)?;
        let number = |v: &toml::Value| match v {
            toml::Value::Float(v) => Some(*v),
            toml::Value::Integer(v) => Some(*v as f64),
            toml::Value::Boolean(v) => Some(f64::from(u8::from(*v))),
            _ => None,
        };
        let found = match &value {
            toml::Value::String(text) if text == "given" => Some(Self::Given),
            toml::Value::String(text) if text == "absent" => Some(Self::Absent),
            toml::Value::Array(list) => list.iter().map(number).collect::<Option<Vec<_>>>().map(Self::AnyOf),
            toml::Value::Table(table) if table.len() == 1 => match table.iter().next() {
                Some((key, v)) if key == "above" => number(v).map(Self::Above),
                Some((key, v)) if key == "below" => number(v).map(Self::Below),
                _ => None,
            },
            other => number(other).map(Self::Equals),
        };
        found.ok_or_else(|| {
            serde::de::Error::custom(format!(
                "{value} is no condition; give a number, true, false, a list of numbers, \"given\", \"absent\", {{ above = number }} or \
                 {{ below = number }}"
            ))
        })
    }
}

impl Condition {
    /// Whether a value, NaN for none, meets it.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        let same = |a: f64| (value - a).abs() <= 1e-9 * (1.0 + a.abs());
        match self {
            Self::Equals(a) => same(*a),
            Self::AnyOf(list) => list.iter().any(|a| same(*a)),
            Self::Given => !value.is_nan(),
            Self::Absent => value.is_nan(),
            Self::Above(a) => value > *a,
            Self::Below(a) => value < *a,
        }
    }
}

impl Selection {
    /// The places in the campaign of the points that it means.
    #[must_use]
    pub fn places(&self, campaign: &Campaign) -> Vec<usize> {
        let points = &campaign.points;
        (0..points.len()).filter(|k| self.holds(campaign, &points[*k])).collect()
    }

    /// Checks that everything it names exists.
    ///
    /// # Errors
    /// [`StudyProblem::Unknown`].
    pub fn check(&self, campaign: &Campaign) -> Result<(), StudyProblem> {
        for name in self.factors.keys() {
            campaign.known_factor(name)?;
        }
        let rows = campaign.rows();
        for row in &self.rows {
            if !rows.contains(&row.as_str()) {
                let known = listed(rows.iter().copied());
                return Err(StudyProblem::Unknown { what: "row of the campaign", name: row.clone(), known });
            }
        }
        for id in &self.points {
            campaign.known_point(id)?;
        }
        Ok(())
    }

    /// Whether a point is meant.
    #[must_use]
    pub fn holds(&self, campaign: &Campaign, point: &Point) -> bool {
        let before = || campaign.points.iter().take_while(|p| p.id != point.id);
        self.meets(campaign, point)
            && self.first.is_none_or(|n| before().filter(|p| self.meets(campaign, p)).count() < n)
    }

    /// Whether a point meets every condition.
    fn meets(&self, campaign: &Campaign, point: &Point) -> bool {
        let row = self.rows.is_empty() || self.rows.contains(&point.row);
        let id = self.points.is_empty() || self.points.contains(&point.id);
        let factor = |(name, condition): (&String, &Condition)| {
            campaign.factor(name).is_some_and(|k| condition.holds(point.factors[k]))
        };
        row && id && self.factors.iter().all(factor)
    }
}
