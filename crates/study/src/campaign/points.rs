//! Operating points and their factors.

use crate::StudyProblem;
use crate::source::listed;
use rijke_numerics::words::{few, to_digits};
use rijke_rig::Unit;
use std::collections::BTreeMap;

/// A column of the campaign that is set or measured at every operating point: a position, a power, a load.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// Its name, which formulas may use.
    pub name: String,
    /// Its unit in SI, as formulas see it.
    pub unit: String,
    /// Its unit in the file, for axes and tables.
    pub shown: Unit,
    /// Whether the file states a unit; without one a formula may take the factor for any quantity in SI.
    pub stated: bool,
}

impl Factor {
    /// The unit of its numbers as a reader knows it: the file's, where one of it is one in SI, as in W; else
    /// that of formulas.
    #[must_use]
    pub fn unit_in_print(&self) -> String {
        let one = (self.shown.to_si(1.0) - 1.0).abs() < 1e-12 && self.shown.to_si(0.0).abs() < 1e-12;
        match self.unit.as_str() {
            _ if one => self.shown.to_string(),
            // The names that these have.
            "kg m^2 s^-3" => "W".to_owned(),
            "kg m^2 s^-2" => "J".to_owned(),
            "kg m^-1 s^-2" => "Pa".to_owned(),
            "kg m s^-2" => "N".to_owned(),
            base => with_a_slash(base),
        }
    }
}

/// A product of powers with the one of them that is negative behind a slash: `m^3/s` for `m^3 s^-1`.
fn with_a_slash(unit: &str) -> String {
    let (below, above): (Vec<&str>, Vec<&str>) = unit.split(' ').partition(|power| power.contains("^-"));
    let [one] = below[..] else { return unit.to_owned() };
    let above = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
    let one = one.replace("^-", "^");
    format!("{above}/{}", one.strip_suffix("^1").unwrap_or(&one))
}

impl Factor {
    /// A number of it in the unit of the file, to twelve digits: 410 of mm for 0.41.
    #[must_use]
    pub fn shown_of(&self, value: f64) -> f64 {
        to_digits((value - self.shown.offset()) / self.shown.factor(), 12)
    }

    /// Name, number and unit as the file has them: `x_g = 410 mm`.
    #[must_use]
    pub fn said(&self, value: f64) -> String {
        self.said_to(value, 12)
    }

    /// As [`Self::said`], to so many digits of the number as it is shown.
    #[must_use]
    pub fn said_to(&self, value: f64, digits: usize) -> String {
        let shown = to_digits(self.shown_of(value), digits);
        format!("{} = {shown}{}", self.name, unit_behind(self.shown.text()))
    }
}

/// A unit as it stands behind a number: a space and the unit, or nothing for `1`.
#[must_use]
pub fn unit_behind(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// One operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Unique name.
    pub id: String,
    /// Label of the series that it belongs to; empty if it has none.
    pub row: String,
    /// Value of every factor, in SI; NaN where it has none.
    pub factors: Vec<f64>,
    /// Standard deviation of every factor, in SI; 0 where it is known.
    pub factor_sds: Vec<f64>,
    /// Points of one installation share one assembly of the rig.
    pub installation: String,
    /// The day, or another label of what its readings share.
    pub day: String,
    /// Number of repeats planned or measured.
    pub repeats: u32,
    /// Ambient temperature and its standard deviation, K.
    pub ambient: Option<[f64; 2]>,
}

/// All operating points, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Campaign {
    /// The factors, in the order of the columns.
    pub factors: Vec<Factor>,
    /// The points.
    pub points: Vec<Point>,
    /// The name of the file, for what is said of it.
    pub file: String,
}

impl Campaign {
    /// The point called `id`.
    #[must_use]
    pub fn point(&self, id: &str) -> Option<(usize, &Point)> {
        self.points.iter().enumerate().find(|(_, p)| p.id == id)
    }

    /// The place of a factor among all.
    #[must_use]
    pub fn factor(&self, name: &str) -> Option<usize> {
        self.factors.iter().position(|f| f.name == name)
    }

    /// As [`Campaign::factor`].
    ///
    /// # Errors
    /// [`StudyProblem::Unknown`] with the factors that there are.
    pub fn known_factor(&self, name: &str) -> Result<usize, StudyProblem> {
        self.factor(name).ok_or_else(|| StudyProblem::Unknown {
            what: "factor",
            name: name.to_owned(),
            known: listed(self.factors.iter().map(|f| f.name.as_str())),
        })
    }

    /// Number of an operating point, from 0.
    ///
    /// # Errors
    /// [`StudyProblem::Unknown`], with some of the known names.
    pub fn known_point(&self, id: &str) -> Result<usize, StudyProblem> {
        const NAMED: usize = 8;
        let ids = || self.points.iter().map(|p| p.id.as_str()).collect::<Vec<_>>();
        self.point(id).map(|(k, _)| k).ok_or_else(|| StudyProblem::Unknown {
            what: "operating point",
            name: id.to_owned(),
            known: few(&ids(), NAMED),
        })
    }

    /// Gives points the ambient temperatures that were read with their records, by number of the point.
    pub fn take_ambient(&mut self, read: &BTreeMap<usize, [f64; 2]>) {
        for (k, ambient) in read {
            self.points[*k].ambient = Some(*ambient);
        }
    }

    /// Labels of the series, in order, each once.
    #[must_use]
    pub fn rows(&self) -> Vec<&str> {
        let mut seen = Vec::new();
        for point in &self.points {
            if !seen.contains(&point.row.as_str()) {
                seen.push(point.row.as_str());
            }
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use super::with_a_slash;

    #[test]
    fn exact_units_have_a_slash_for_one_negative_power() {
        let units = ["m^3 s^-1", "s^-1", "kg m^-2 s^-1", "m"].map(with_a_slash);
        assert_eq!(units, ["m^3/s", "1/s", "kg m^-2 s^-1", "m"]);
    }
}
