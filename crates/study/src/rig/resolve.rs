//! The rig at one operating point: numbers in the place of formulas.

use super::elements::fault_of;
use super::gas::GasModel;
use super::part::{Part, Shape};
use super::whole::Rig;
use crate::law::Place;
use crate::names::{AMBIENT, LENGTH};
use crate::{Point, StudyProblem};
use rijke_numerics::words::to_digits;
use std::f64::consts::PI;

/// Places closer than this part of the length are the same.
const SAME: f64 = 1e-9;

/// Where everything is at one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct RigAtPoint {
    /// Value of every name of the scope that is the same everywhere; NaN for all others.
    pub numbers: Vec<f64>,
    /// Total length, m.
    pub length: f64,
    /// The ducts that are there, from upstream to downstream.
    pub ducts: Vec<DuctAt>,
    /// For every part, where it is.
    pub parts: Vec<PartAt>,
    /// Places of the microphones, m.
    pub microphones: Vec<f64>,
}

/// A duct at an operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct DuctAt {
    /// The part that it is.
    pub part: usize,
    /// Where it begins and ends, m.
    pub span: [f64; 2],
    /// Areas at its ends, m^2.
    pub area: [f64; 2],
    /// Temperatures at equally spaced places, K; may be empty.
    pub temperatures: Vec<f64>,
    /// Its gas, if it has another than the rig.
    pub gas: Option<GasModel>,
    /// Into how many pieces it is cut at least.
    pub pieces: usize,
}

/// A part at an operating point.
#[derive(Clone, Debug, PartialEq)]
pub enum PartAt {
    /// It is not there.
    Absent,
    /// At places, ascending in the file's order, m.
    Places(Vec<f64>),
    /// Along a stretch, m.
    Stretch([f64; 2]),
}

impl Rig {
    /// The values of all names that are the same everywhere at `point`: factors, numbers of parts, ambient
    /// temperature.
    #[must_use]
    pub fn numbers(&self, factors: &[f64], ambient: f64) -> Vec<f64> {
        let mut numbers = vec![f64::NAN; self.scope.len()];
        for (place, value) in self.factors.iter().zip(factors) {
            numbers[*place] = *value;
        }
        numbers[AMBIENT] = ambient;
        for (place, value) in &self.loose {
            numbers[*place] = value.at(&numbers);
        }
        for (place, value) in self.parts.iter().flat_map(|p| &p.numbers).chain(&self.of_ends) {
            numbers[*place] = value.at(&numbers);
        }
        numbers
    }

    /// The rig at an operating point; `ambient` in K.
    ///
    /// # Errors
    /// A length, an area or a place that is impossible there.
    pub fn at(&self, point: &Point, ambient: f64) -> Result<RigAtPoint, StudyProblem> {
        self.at_factors(&point.factors, ambient)
    }

    /// As [`Rig::at`], for any values of the factors.
    ///
    /// # Errors
    /// As [`Rig::at`].
    pub fn at_factors(&self, factors: &[f64], ambient: f64) -> Result<RigAtPoint, StudyProblem> {
        let mut numbers = self.numbers(factors, ambient);
        let wrong = |key: String, value: f64, need: &'static str| StudyProblem::Value {
            key,
            value: to_digits(value, 6).to_string(),
            need,
        };
        let mut ducts: Vec<DuctAt> = Vec::new();
        let mut end = 0.0;
        for (k, part) in self.parts.iter().enumerate() {
            let Shape::Duct(duct) = &part.shape else { continue };
            if !part.is_there(&numbers) {
                continue;
            }
            let length = duct.length.at(&numbers);
            let [area, area_end] = [0, 1].map(|i| duct.area[i].at(&numbers));
            for (key, value) in [("length", length), ("area", area), ("area_end", area_end)] {
                if !(value > 0.0 && value.is_finite()) {
                    return Err(wrong(format!("{}: {key}", part.name), value, "positive"));
                }
            }
            let temperatures: Vec<f64> = duct.temperatures.iter().map(|t| t.at(&numbers)).collect();
            if let Some(&t) = temperatures.iter().find(|t| !(**t > 0.0 && t.is_finite())) {
                return Err(wrong(format!("{}: temperature", part.name), t, "above 0 K"));
            }
            let own_gas = [0, 1].map(|k| duct.gas[k].as_ref().map(|value| value.at(&numbers)));
            for (key, value) in [("gamma", own_gas[0]), ("gas_constant", own_gas[1])] {
                let Some(value) = value else { continue };
                let fault = if value.is_finite() { fault_of(key, value) } else { Some("a number") };
                if let Some(need) = fault {
                    return Err(wrong(format!("{}: {key}", part.name), value, need));
                }
            }
            let gas = self.gas.with(own_gas).filter(|_| part.is_of_other_gas());
            let pieces = duct.pieces()[usize::from(area != area_end)];
            let span = [end, end + length];
            ducts.push(DuctAt { part: k, span, area: [area, area_end], temperatures, gas, pieces });
            end += length;
        }
        if ducts.is_empty() {
            let need = "at least one of them must be there: check the factors that their `present` names";
            return Err(StudyProblem::Empty { what: "duct at this point", need });
        }
        numbers[LENGTH] = end;
        let mut before = 0.0;
        let mut parts = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            parts.push(match &part.shape {
                _ if !part.is_there(&numbers) => PartAt::Absent,
                Shape::Duct(_) => {
                    let duct = ducts.iter().find(|d| d.part == parts.len());
                    before = duct.map_or(before, |d| d.span[1]);
                    PartAt::Stretch(duct.map_or([0.0; 2], |d| d.span))
                }
                Shape::Device(at) => {
                    let places: Vec<f64> = if at.is_empty() {
                        vec![before]
                    } else {
                        at.iter().map(|x| x.at(&numbers)).collect()
                    };
                    if places.iter().any(|x| x.is_nan()) {
                        PartAt::Absent
                    } else {
                        for &x in &places {
                            inside(&|| part.name.clone(), x, end)?;
                        }
                        PartAt::Places(places)
                    }
                }
                Shape::Insert(from, to) => {
                    let [from, to] = [from, to].map(|x| x.at(&numbers));
                    if from.is_nan() || to.is_nan() {
                        PartAt::Absent
                    } else {
                        inside(&|| part.name.clone(), from, end)?;
                        inside(&|| part.name.clone(), to, end)?;
                        PartAt::Stretch([from.min(to), from.max(to)])
                    }
                }
            });
        }
        for (name, x) in self.thermometers.names.iter().zip(&self.thermometers.at) {
            let of = || format!("{name} of [thermometers] on line {}", self.thermometers.line);
            inside(&of, x.at(&numbers), end)?;
        }
        let mut microphones = Vec::with_capacity(self.microphones.at.len());
        for (name, x) in self.microphones.names.iter().zip(&self.microphones.at) {
            let x = x.at(&numbers);
            let of = || format!("{name} of [microphones] on line {}", self.microphones.line);
            inside(&of, x, end)?;
            microphones.push(x);
        }
        let found = RigAtPoint { numbers, length: end, ducts, parts, microphones };
        self.parts.iter().zip(&found.parts).try_for_each(|(part, at)| found.holds_the_hole(part, at))?;
        Ok(found)
    }
}

fn inside(name: &dyn Fn() -> String, x: f64, length: f64) -> Result<(), StudyProblem> {
    if (-SAME * length..=length * (1.0 + SAME)).contains(&x) {
        return Ok(());
    }
    let (key, value) = (format!("{}: at", name()), format!("{} m", to_digits(x, 6)));
    Err(StudyProblem::Value { key, value, need: "on the ducts, from 0 to their total length" })
}

impl RigAtPoint {
    /// Refuses a hole wider than the duct at its places, and a plate of which one hole has more than the part
    /// that is open: their laws hold for neither.
    fn holds_the_hole(&self, part: &Part, at: &PartAt) -> Result<(), StudyProblem> {
        let (Some(hole), PartAt::Places(places)) = (part.hole, at) else { return Ok(()) };
        let diameter = self.numbers[hole.diameter];
        let porosity = hole.porosity.map(|k| self.numbers[k]);
        let wrong = |key: &str, value: String, need| {
            Err(StudyProblem::Value { key: format!("{}: {key}", part.name), value, need })
        };
        for x in places {
            let area = self.areas(*x).into_iter().fold(f64::INFINITY, f64::min);
            let taken = 0.25 * std::f64::consts::PI * diameter * diameter / area;
            if taken > 1.0 + SAME {
                return wrong("diameter", format!("{diameter} m"), "no wider than the duct there");
            }
            if let Some(open) = porosity.filter(|open| taken > *open * (1.0 + SAME)) {
                let value = format!("{open}, of which one hole has {taken:.3}");
                return wrong("porosity", value, "the area of all holes together over that of the duct");
            }
        }
        Ok(())
    }

    /// Diameter of the widest duct, m.
    pub(crate) fn widest(&self) -> f64 {
        self.ducts.iter().map(DuctAt::widest).fold(0.0, f64::max)
    }

    /// Whether two parts, by number, act at one place.
    pub(crate) fn are_at_one_place(&self, a: usize, b: usize) -> bool {
        let (PartAt::Places(a), PartAt::Places(b)) = (&self.parts[a], &self.parts[b]) else { return false };
        a.iter().any(|x| b.iter().any(|y| (x - y).abs() <= SAME * self.length))
    }

    /// The places of a kind of place, and the share of the law at each; along a stretch nothing.
    #[must_use]
    pub fn places(&self, place: &Place) -> Vec<(f64, f64)> {
        let whole = |x: f64| (x, 1.0);
        match place {
            Place::Upstream => vec![whole(0.0)],
            Place::Downstream => vec![whole(self.length)],
            Place::Ends => vec![whole(0.0), whole(self.length)],
            Place::Duct(_) | Place::Along(_) => Vec::new(),
            Place::Start(k) | Place::End(k) => match self.parts.get(*k) {
                Some(PartAt::Stretch(span)) => vec![whole(span[usize::from(matches!(place, Place::End(_)))])],
                _ => Vec::new(),
            },
            Place::Each(k) | Place::Shared(k) | Place::Middle(k) => match self.parts.get(*k) {
                Some(PartAt::Places(list)) => {
                    let n = list.len() as f64;
                    match place {
                        Place::Middle(_) => vec![whole(list.iter().sum::<f64>() / n)],
                        Place::Shared(_) => list.iter().map(|x| (*x, 1.0 / n)).collect(),
                        _ => list.iter().copied().map(whole).collect(),
                    }
                }
                _ => Vec::new(),
            },
        }
    }

    /// The stretches along which a law acts, m.
    #[must_use]
    pub fn stretches(&self, place: &Place) -> Vec<[f64; 2]> {
        match place {
            Place::Duct(None) => vec![[0.0, self.length]],
            Place::Duct(Some(k)) | Place::Along(k) => match self.parts.get(*k) {
                Some(PartAt::Stretch(span)) => vec![*span],
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    /// Area of the ducts on the upstream side of `x`, and on the downstream side, m^2.
    #[must_use]
    pub fn areas(&self, x: f64) -> [f64; 2] {
        let slack = SAME * self.length;
        let side = |duct: Option<&DuctAt>| duct.map_or(f64::NAN, |d| d.area_at(x));
        let before = self.ducts.iter().find(|d| x <= d.span[1] + slack).or(self.ducts.last());
        let after = self.ducts.iter().rfind(|d| x >= d.span[0] - slack).or(self.ducts.first());
        [side(before), side(after)]
    }
}

impl DuctAt {
    /// Area at `x` (m from the upstream end of the rig): the radius is linear along a cone.
    #[must_use]
    pub fn area_at(&self, x: f64) -> f64 {
        let share = ((x - self.span[0]) / (self.span[1] - self.span[0])).clamp(0.0, 1.0);
        let [start, end] = self.area.map(f64::sqrt);
        if start == end { self.area[0] } else { (start + share * (end - start)).powi(2) }
    }

    /// Diameter at the wider end, m.
    pub(crate) fn widest(&self) -> f64 {
        (4.0 * self.area[0].max(self.area[1]) / PI).sqrt()
    }

    /// Temperature of the file at `x`, if it says one.
    #[must_use]
    pub fn temperature_at(&self, x: f64) -> Option<f64> {
        let (&first, n) = (self.temperatures.first()?, self.temperatures.len());
        if n == 1 {
            return Some(first);
        }
        let share = ((x - self.span[0]) / (self.span[1] - self.span[0])).clamp(0.0, 1.0) * (n - 1) as f64;
        let k = (share as usize).min(n - 2);
        Some(self.temperatures[k] + (share - k as f64) * (self.temperatures[k + 1] - self.temperatures[k]))
    }
}
