//! Operating points of a heated tube: its factors by their names, and what they say.

use rijke_rig::{FactorValue, OperatingPoint, Problem, Unit};
use std::collections::BTreeMap;

/// Factor: where the insert ends and the plates sit, m from x = 0; absent in the empty tube.
pub const POSITION: &str = "X_h";
/// Factor: 1 where the plates are in the tube.
pub const PLATES: &str = "heater";
/// Factor: 1 where the thermometers are in the tube.
pub const THERMOMETERS: &str = "thermometers";
/// Factor: electrical power of the plates, W.
pub const POWER: &str = "Q_h";

/// One configuration of the tube at one power.
#[derive(Clone, Debug, PartialEq)]
pub struct TubePoint {
    /// Unique name, also a folder name: row and position in cm, `"C3-E"`, `"C3-05"`, `"H180-25"`.
    pub id: String,
    /// Row of the campaign, `"C3"`.
    pub row: String,
    /// Where the insert ends and the plates (if attached) sit, m from x = 0; none for the empty tube.
    pub position: Option<f64>,
    /// Whether the plates are attached to the insert.
    pub plates: bool,
    /// Whether the thermometers are in place.
    pub thermometers: bool,
    /// Electrical power of the plates, W.
    pub power: f64,
    /// Number of repeats measured.
    pub repeats: u32,
}

impl TubePoint {
    /// What the factors of a point say. Plates, thermometers and power are absent where the point does not
    /// have them.
    ///
    /// # Errors
    /// The factor that has another unit, or a value that it cannot have.
    pub fn of(point: &OperatingPoint) -> Result<Self, (String, Problem)> {
        let number = |name: &str, unit: &str| -> Result<Option<f64>, (String, Problem)> {
            let Some(factor) = point.factors.get(name) else { return Ok(None) };
            let at = || format!("point `{}`: `{name}`", point.id);
            let own = Unit::parse(&factor.unit).and_then(|own| own.of(unit));
            own.map_err(|error| (at(), Problem::Unit(error)))?;
            Ok(Some(factor.value))
        };
        let flag = |name: &str| match number(name, "1")? {
            None => Ok(false),
            Some(0.0) => Ok(false),
            Some(1.0) => Ok(true),
            Some(value) => {
                let problem = Problem::BadCell { text: value.to_string(), expected: "0 or 1" };
                Err((format!("point `{}`: `{name}`", point.id), problem))
            }
        };
        let power = number(POWER, "W")?.unwrap_or(0.0);
        if !(0.0..=1e6).contains(&power) {
            let problem = Problem::OutOfRange { value: power, low: 0.0, high: 1e6, unit: "W" };
            return Err((format!("point `{}`: `{POWER}`", point.id), problem));
        }
        Ok(Self {
            id: point.id.clone(),
            row: point.row.clone(),
            position: number(POSITION, "m")?,
            plates: flag(PLATES)?,
            thermometers: flag(THERMOMETERS)?,
            power,
            repeats: point.repeats,
        })
    }
}

impl From<&TubePoint> for OperatingPoint {
    fn from(point: &TubePoint) -> Self {
        let factor = |name: &str, value: f64, unit: &str| {
            (name.to_owned(), FactorValue { value, unit: unit.to_owned() })
        };
        let mut factors = BTreeMap::from([
            factor(PLATES, f64::from(u8::from(point.plates)), "1"),
            factor(THERMOMETERS, f64::from(u8::from(point.thermometers)), "1"),
            factor(POWER, point.power, "W"),
        ]);
        factors.extend(point.position.map(|x| factor(POSITION, x, "m")));
        Self { id: point.id.clone(), row: point.row.clone(), repeats: point.repeats, factors }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_point_is_known_by_its_factors() {
        for point in crate::TubeCampaign::juniper_yoko_2022().points {
            assert_eq!(TubePoint::of(&OperatingPoint::from(&point)).unwrap(), point);
        }
        let point = &crate::TubeCampaign::juniper_yoko_2022().points[0];
        let refused = |name: &str, value: f64, unit: &str, says: &str| {
            let mut other = OperatingPoint::from(point);
            other.factors.insert(name.into(), FactorValue { value, unit: unit.into() });
            let (place, problem) = TubePoint::of(&other).unwrap_err();
            let said = format!("{place}: {problem}");
            assert!(said.contains(says) && said.contains(name), "{said}");
        };
        refused(POSITION, 0.2, "s", "`s` is not a unit of this quantity, which is in m");
        refused(PLATES, 0.5, "1", "`0.5` is not 0 or 1");
        refused(POWER, -3.0, "W", "-3 W is outside 0 to 1000000 W");
        let power = FactorValue { value: 3.0, unit: "kg m^2 s^-3".into() };
        let mut other = OperatingPoint::from(point);
        other.factors.insert(POWER.into(), power);
        assert_eq!(TubePoint::of(&other).unwrap().power, 3.0);
    }
}
