//! From the tables of a file to a network and its laws.

use super::schema::{Element, End, File, Gas};
use super::{FileError, Problem, REGION};
use crate::chain::{Network, Segment, Slot};
use crate::contour::Region;
use crate::laws::{Law, LawSet, choked_outlet, thick_wall_correction};
use rijke_numerics::C64;
use serde::Deserialize;
use std::f64::consts::PI;
use toml::Spanned;

/// A network with its laws, and where to look for modes.
#[derive(Clone, Debug, PartialEq)]
pub struct Built {
    /// What the file calls it.
    pub name: Option<String>,
    /// The chain.
    pub network: Network,
    /// Its laws.
    pub laws: LawSet,
    /// Where to look for modes.
    pub region: Region,
    /// What each place is, for tables and figures: its number and the name of the element that acts there.
    pub places: Vec<(usize, String)>,
    /// Whether nothing in it can feed energy to a mode.
    pub passive: bool,
    /// What is doubtful but possible.
    pub warnings: Vec<Warning>,
}

/// What is doubtful about a network.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Warning {
    /// Density and sound speed do not belong to the pressure.
    #[error("line {line}: {place}: rho c^2/gamma is {found:.0} Pa, but the pressure is {expected:.0} Pa")]
    Pressure {
        /// Line in the file.
        line: usize,
        /// Which element.
        place: String,
        /// rho c^2/gamma, Pa.
        found: f64,
        /// The pressure of the gas, Pa.
        expected: f64,
    },
    /// A reflection coefficient above one feeds energy.
    #[error("line {line}: {place}: |R| = {modulus} is above 1: this end feeds the modes")]
    Reflection {
        /// Line in the file.
        line: usize,
        /// Which end.
        place: String,
        /// |R|.
        modulus: f64,
    },
}

pub(super) struct Item {
    pub(super) line: usize,
    pub(super) place: String,
}

impl Item {
    pub(super) fn fail(&self, problem: Problem) -> FileError {
        FileError::Element { line: self.line, place: self.place.clone(), problem }
    }

    pub(super) fn positive(&self, key: &'static str, value: f64) -> Result<f64, FileError> {
        if value.is_finite() && value > 0.0 {
            Ok(value)
        } else {
            Err(self.fail(Problem::NotPositive { key, value }))
        }
    }

    pub(super) fn not_negative(&self, key: &'static str, value: f64) -> Result<f64, FileError> {
        if value.is_finite() && value >= 0.0 {
            Ok(value)
        } else {
            Err(self.fail(Problem::Negative { key, value }))
        }
    }

    fn polynomial(&self, key: &'static str, value: &[f64]) -> Result<Vec<f64>, FileError> {
        if value.iter().any(|k| *k != 0.0) && value.iter().all(|k| k.is_finite()) {
            Ok(value.to_vec())
        } else {
            Err(self.fail(Problem::Polynomial { key }))
        }
    }

    fn parse<'de, T: Deserialize<'de>>(&self, table: toml::Table) -> Result<T, FileError> {
        T::deserialize(toml::Value::Table(table))
            .map_err(|error| self.fail(Problem::Keys { message: error.message().to_owned() }))
    }
}

fn line_of(text: &str, offset: usize) -> usize {
    1 + text.as_bytes().iter().take(offset).filter(|b| **b == b'\n').count()
}

/// Segments so far, and what waits for the next place.
pub(super) struct Assembly<'a> {
    pub(super) gas: &'a Gas,
    pub(super) segments: Vec<Segment>,
    pub(super) temperatures: Vec<f64>,
    pub(super) laws: LawSet,
    pub(super) attach: Vec<(Slot, usize, f64)>,
    pub(super) places: Vec<(usize, String)>,
    pub(super) passive: bool,
    pub(super) warnings: Vec<Warning>,
}

pub(super) fn build(text: &str, file: &File) -> Result<Built, FileError> {
    let gas = &file.gas;
    let head = Item { line: 1, place: "[gas]".to_owned() };
    for (key, value) in [
        ("temperature", gas.temperature),
        ("pressure", gas.pressure),
        ("gamma", gas.gamma),
        ("gas_constant", gas.gas_constant),
        ("viscosity", gas.viscosity),
        ("prandtl", gas.prandtl),
    ] {
        head.positive(key, value)?;
    }
    let mut assembly = Assembly {
        gas,
        segments: Vec::new(),
        temperatures: Vec::new(),
        laws: LawSet::default(),
        attach: Vec::new(),
        places: Vec::new(),
        passive: true,
        warnings: Vec::new(),
    };
    let mut flames: Vec<(Item, usize, Element)> = Vec::new();
    for (index, element) in file.element.iter().enumerate() {
        let mut table: toml::Table = element.get_ref().clone();
        let name = match table.remove("name") {
            Some(toml::Value::String(name)) => Some(name),
            _ => None,
        };
        let kind = table.get("type").and_then(toml::Value::as_str).unwrap_or("?").to_owned();
        let called = name.as_ref().map_or(String::new(), |n| format!(" `{n}`"));
        let item = Item {
            line: line_of(text, element.span().start),
            place: format!("element {}{called} ({kind})", index + 1),
        };
        let element: Element = item.parse(table)?;
        let place = assembly.segments.len();
        match element {
            Element::Duct { .. } => assembly.duct(&item, element)?,
            // What a flame does depends on the ducts on both sides: when all are known.
            other => {
                assembly.places.push((place, name.unwrap_or(kind)));
                flames.push((item, place, other));
            }
        }
    }
    if assembly.segments.is_empty() {
        return Err(FileError::NoDuct);
    }
    for (item, place, element) in &flames {
        assembly.compact(item, *place, element)?;
    }
    let up = assembly.end(text, "[upstream]", &file.upstream, 0)?;
    let down = assembly.end(text, "[downstream]", &file.downstream, assembly.segments.len() - 1)?;
    let mut network = Network::new(assembly.segments)?;
    for (slot, law, weight) in assembly.attach {
        network.attach(slot, law, weight)?;
    }
    network.attach(Slot::Upstream, up, 1.0)?;
    network.attach(Slot::Downstream, down, 1.0)?;

    let mut region = REGION;
    let increasing = |limits: [f64; 2], key| {
        if limits[0] < limits[1] && limits.iter().all(|v| v.is_finite()) {
            Ok(limits)
        } else {
            Err(FileError::Search { key })
        }
    };
    if let Some(limits) = file.search.growth_rate {
        region.sigma = increasing(limits, "growth_rate")?;
    }
    if let Some(limits) = file.search.frequency_hz {
        region.omega = increasing(limits, "frequency_hz")?.map(|f| 2.0 * PI * f);
    }
    Ok(Built {
        name: file.name.clone(),
        network,
        laws: assembly.laws,
        region,
        places: assembly.places,
        passive: assembly.passive,
        warnings: assembly.warnings,
    })
}

impl Assembly<'_> {
    /// The element at `place`, between the segments before and after it.
    fn compact(&mut self, item: &Item, place: usize, element: &Element) -> Result<(), FileError> {
        let before = place.saturating_sub(1);
        let after = place.min(self.segments.len() - 1);
        let here = self.segments[before.min(after)];
        let complex = |v: [f64; 2]| C64::new(v[0], v[1]);
        let name = |what: &str| format!("{}: {what}", item.place);
        match element {
            Element::Duct { .. } => {}
            Element::Feedback { mu, mp, eu, ep } => {
                for (slot, value) in [
                    (Slot::Mu(place), mu),
                    (Slot::Mp(place), mp),
                    (Slot::Eu(place), eu),
                    (Slot::Ep(place), ep),
                ] {
                    if *value != [0.0; 2] {
                        let law = self.laws.push(name("feedback"), Law::Constant(complex(*value)));
                        self.attach.push((slot, law, 1.0));
                    }
                }
                self.passive &= mp == &[0.0; 2] && eu == &[0.0; 2] && mu[0] >= 0.0 && ep[0] >= 0.0;
            }
            Element::Orifice { diameter, thickness, drag } => {
                item.positive("diameter", *diameter)?;
                item.not_negative("thickness", *thickness)?;
                item.not_negative("drag", *drag)?;
                let hole = 0.25 * PI * diameter * diameter;
                // l_eff = l + 2 (8/(3 pi)) sqrt(A_d/pi): Rienstra & Hirschberg, section 4.4.3, as in the paper.
                let effective = thickness + 2.0 * (8.0 / (3.0 * PI)) * (hole / PI).sqrt();
                let inertia = here.density * effective * here.area / hole;
                let law = Law::Linear { constant: C64::new(*drag, 0.0), per_s: C64::new(inertia, 0.0) };
                let law = self.laws.push(name("orifice"), law);
                self.attach.push((Slot::Mu(place), law, 1.0));
            }
            Element::Flame { gain, n, delay, cutoff_hz, numerator, denominator, reference } => {
                item.not_negative("delay", *delay)?;
                item.not_negative("reference", *reference)?;
                let gain = match (gain, n) {
                    (Some(gain), None) => *gain,
                    (None, Some(n)) => n * (self.temperatures[after] / self.temperatures[before] - 1.0),
                    _ => return Err(item.fail(Problem::OneOf { one: "gain", other: "n" })),
                };
                let mut below = item.polynomial("denominator", denominator)?;
                if let Some(f) = cutoff_hz {
                    let time = 1.0 / (2.0 * PI * item.positive("cutoff_hz", *f)?);
                    below.push(0.0);
                    for i in (1..below.len()).rev() {
                        below[i] += time * below[i - 1];
                    }
                }
                let transfer = Law::Transfer {
                    gain: -gain,
                    numerator: item.polynomial("numerator", numerator)?,
                    denominator: below,
                    delay: *delay,
                };
                self.passive &= gain == 0.0;
                if *reference > 0.0 {
                    let duct = self.segments[before];
                    if *reference > duct.length || place == 0 {
                        let problem = Problem::ReferenceOutside { distance: *reference, length: duct.length };
                        return Err(item.fail(problem));
                    }
                    let (c, rho) = (duct.sound_speed, duct.density);
                    let eu = Law::VelocityUpstream(Box::new(transfer.clone()), *reference, c);
                    let ep = Law::PressureUpstream(Box::new(transfer), *reference, c, rho);
                    let (eu, ep) = (self.laws.push(name("flame"), eu), self.laws.push(name("flame"), ep));
                    self.attach.push((Slot::Eu(place), eu, 1.0));
                    self.attach.push((Slot::Ep(place), ep, 1.0));
                } else {
                    let law = self.laws.push(name("flame"), transfer);
                    self.attach.push((Slot::Eu(place), law, 1.0));
                }
            }
            Element::Helmholtz { volume, neck_area, neck_length, resistance } => {
                item.positive("volume", *volume)?;
                item.positive("neck_area", *neck_area)?;
                item.positive("neck_length", *neck_length)?;
                item.not_negative("resistance", *resistance)?;
                let law = Law::Helmholtz {
                    duct_area: self.segments[after].area,
                    inertance: here.density * neck_length / neck_area,
                    resistance: resistance / neck_area,
                    stiffness: here.density * here.sound_speed * here.sound_speed / volume,
                };
                let law = self.laws.push(name("resonator"), law);
                self.attach.push((Slot::Ep(place), law, 1.0));
            }
            Element::QuarterWave { length, area } => {
                item.positive("length", *length)?;
                item.positive("area", *area)?;
                let law = Law::QuarterWave {
                    area_ratio: area / self.segments[after].area,
                    length: *length,
                    sound_speed: here.sound_speed,
                    impedance: here.impedance(),
                };
                let law = self.laws.push(name("side branch"), law);
                self.attach.push((Slot::Ep(place), law, 1.0));
            }
        }
        Ok(())
    }

    /// The law of an end, which touches segment `i`.
    fn end(
        &mut self,
        text: &str,
        place: &str,
        table: &Spanned<toml::Table>,
        i: usize,
    ) -> Result<usize, FileError> {
        let item = Item { line: line_of(text, table.span().start), place: place.to_owned() };
        let segment = self.segments[i];
        let (radius, sound_speed) = ((segment.area / PI).sqrt(), segment.sound_speed);
        let constant = |r: f64| Law::Constant(C64::new(r, 0.0));
        let mut fixed = None;
        let law = match item.parse(table.get_ref().clone())? {
            End::Open => constant(-1.0),
            End::Closed => constant(1.0),
            End::Anechoic => constant(0.0),
            End::Constant { modulus, angle } => {
                fixed = Some(item.not_negative("modulus", modulus)?);
                Law::Constant(C64::from_polar(modulus, angle))
            }
            End::Delayed { factor, delay } => {
                item.not_negative("delay", delay)?;
                fixed = Some(factor.abs());
                Law::Transfer { gain: factor, numerator: vec![1.0], denominator: vec![1.0], delay }
            }
            End::Unflanged { wall_thickness, calibration } => {
                let thickness = item.not_negative("wall_thickness", wall_thickness)?;
                let correction = thick_wall_correction(radius, thickness);
                let law = Law::Unflanged { radius, sound_speed, correction };
                if let Some([modulus, angle]) = calibration {
                    item.positive("calibration", modulus)?;
                    Law::Scaled(Box::new(law), C64::from_polar(modulus, angle))
                } else {
                    law
                }
            }
            End::Flanged => Law::Flanged { radius, sound_speed },
            End::Choked { mach } => {
                item.not_negative("mach", mach)?;
                if mach >= 0.3 {
                    return Err(item.fail(Problem::TooFast { mach }));
                }
                constant(choked_outlet(self.gas.gamma, mach))
            }
            End::Impedance { numerator, denominator } => {
                let (numerator, denominator) = (
                    item.polynomial("numerator", &numerator)?,
                    item.polynomial("denominator", &denominator)?,
                );
                Law::Impedance(Box::new(Law::Transfer { gain: 1.0, numerator, denominator, delay: 0.0 }))
            }
            End::Rational { numerator, denominator, delay } => {
                item.not_negative("delay", delay)?;
                Law::Transfer {
                    gain: 1.0,
                    numerator: item.polynomial("numerator", &numerator)?,
                    denominator: item.polynomial("denominator", &denominator)?,
                    delay,
                }
            }
        };
        if let Some(modulus) = fixed.filter(|r| *r > 1.0) {
            self.passive = false;
            self.warnings.push(Warning::Reflection { line: item.line, place: item.place.clone(), modulus });
        }
        Ok(self.laws.push(place.to_owned(), law))
    }
}
