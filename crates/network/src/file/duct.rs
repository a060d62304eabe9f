//! Ducts: straight or conical, uniform or with a temperature profile, with or without wall losses.

use super::build::{Assembly, Item, Warning};
use super::schema::{Element, Scheme, WallChoice};
use super::{FileError, Problem};
use crate::chain::{Segment, Slot};
use crate::laws::Law;
use crate::wall::Wall;
use std::f64::consts::PI;

impl Assembly<'_> {
    fn wall(&self, segment: &Segment, temperature: f64) -> Wall {
        Wall {
            density: segment.density,
            sound_speed: segment.sound_speed,
            viscosity: self.gas.viscosity * (temperature / self.gas.temperature).powf(0.7),
            prandtl: self.gas.prandtl,
            gamma: self.gas.gamma,
            diameter: (4.0 * segment.area / PI).sqrt(),
        }
    }

    pub(super) fn duct(&mut self, item: &Item, element: Element) -> Result<(), FileError> {
        let Element::Duct {
            length,
            diameter,
            diameter_end,
            area,
            area_end,
            temperature,
            temperature_end,
            temperatures,
            sound_speed,
            density,
            pieces,
            wall,
            wall_factor,
            scheme,
        } = element
        else {
            return Ok(());
        };
        item.positive("length", length)?;
        item.not_negative("wall_factor", wall_factor)?;
        let disc = |d: f64| 0.25 * PI * d * d;
        let area = match (diameter, area) {
            (Some(d), None) => disc(item.positive("diameter", d)?),
            (None, Some(a)) => item.positive("area", a)?,
            _ => return Err(item.fail(Problem::OneOf { one: "diameter", other: "area" })),
        };
        let area_end = match (diameter_end, area_end) {
            (None, None) => area,
            (Some(d), None) => disc(item.positive("diameter_end", d)?),
            (None, Some(a)) => item.positive("area_end", a)?,
            _ => return Err(item.fail(Problem::OneOf { one: "diameter_end", other: "area_end" })),
        };
        let profile = match (temperature, temperature_end, temperatures) {
            (first, None, None) => vec![first.unwrap_or(self.gas.temperature)],
            (first, Some(last), None) => vec![first.unwrap_or(self.gas.temperature), last],
            (None, None, Some(list)) if !list.is_empty() => list,
            _ => return Err(item.fail(Problem::OneOf { one: "temperature", other: "temperatures" })),
        };
        for &t in &profile {
            item.positive("temperature", t)?;
        }
        let given = match (sound_speed, density) {
            (None, None) => None,
            (Some(c), Some(rho)) => Some((item.positive("sound_speed", c)?, item.positive("density", rho)?)),
            _ => return Err(item.fail(Problem::Together { one: "sound_speed", other: "density" })),
        };
        if let Some((c, rho)) = given {
            let (found, expected) = (rho * c * c / self.gas.gamma, self.gas.pressure);
            if (found / expected - 1.0).abs() > 0.01 {
                self.warnings.push(Warning::Pressure {
                    line: item.line,
                    place: item.place.clone(),
                    found,
                    expected,
                });
            }
        }
        let varies = profile.len() > 1 || area_end != area;
        let pieces =
            pieces.unwrap_or(if varies || scheme == Scheme::Lumped { 40 } else { 1 }).clamp(1, 100_000);
        let at = |fraction: f64| {
            let position = fraction * (profile.len() - 1) as f64;
            let k = (position as usize).min(profile.len().saturating_sub(2));
            let next = profile.get(k + 1).copied().unwrap_or(profile[k]);
            profile[k] + (position - k as f64) * (next - profile[k])
        };
        let radius = |fraction: f64| area.sqrt() + fraction * (area_end.sqrt() - area.sqrt());
        for k in 0..pieces {
            let middle = (k as f64 + 0.5) / pieces as f64;
            let t = given.map_or(at(middle), |(c, _)| c * c / (self.gas.gamma * self.gas.gas_constant));
            let (c, rho) = given.unwrap_or_else(|| {
                let rt = self.gas.gas_constant * t;
                ((self.gas.gamma * rt).sqrt(), self.gas.pressure / rt)
            });
            let segment = Segment::new(length / pieces as f64, radius(middle).powi(2), c, rho);
            let index = self.segments.len();
            self.segments.push(segment);
            self.temperatures.push(t);
            if let WallChoice::Law(law) = wall {
                let wall = self.wall(&segment, t);
                if varies || k == 0 {
                    self.laws.push(format!("{}: viscous wall loss", item.place), Law::Viscous(law, wall));
                    self.laws.push(format!("{}: thermal wall loss", item.place), Law::Thermal(law, wall));
                }
                let thermal = self.laws.laws.len() - 1;
                match scheme {
                    Scheme::Line => {
                        self.attach.push((Slot::Viscous(index), thermal - 1, wall_factor));
                        self.attach.push((Slot::Thermal(index), thermal, wall_factor));
                    }
                    Scheme::Lumped if k > 0 => {
                        let weight = wall_factor * length / pieces as f64;
                        self.attach.push((Slot::Mu(index), thermal - 1, weight));
                        self.attach.push((Slot::Ep(index), thermal, weight));
                    }
                    Scheme::Lumped => {}
                }
            }
        }
        Ok(())
    }
}
