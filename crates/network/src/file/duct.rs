//! Ducts: straight or conical, uniform or with a temperature profile, with or without wall losses.

use super::assembly::{Assembly, Attached, LocalGas, Role};
use super::error::FileError;
use super::layout::Placed;
use super::problem::ElementProblem;
use super::schema::{Duct, Element, Scheme, WallChoice};
use super::warning::Warning;
use crate::chain::network::Segment;
use crate::flow_chain::FlowWall;
use crate::laws::Law;
use crate::laws::wall::Wall;
use crate::slot::Slot;
use std::f64::consts::PI;

impl Assembly<'_> {
    pub(super) fn wall(&self, segment: &Segment, gas: &LocalGas) -> Wall {
        Wall {
            density: segment.density,
            sound_speed: segment.sound_speed,
            viscosity: self.gas.viscosity * (gas.temperature / self.gas.temperature).powf(0.7),
            prandtl: self.gas.prandtl,
            gamma: gas.gamma,
            diameter: (4.0 * segment.area / PI).sqrt(),
        }
    }

    /// A duct, cut into pieces and at every position of `cuts` (m from the upstream end of the tube) that
    /// lies in it, farther than `slack` from an end of a piece.
    pub(super) fn duct(
        &mut self,
        owner: usize,
        placed: &Placed,
        cuts: &[f64],
        slack: f64,
    ) -> Result<(), FileError> {
        let item = &placed.item;
        let Element::Duct(duct) = &placed.element else {
            return Ok(());
        };
        let Duct {
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
            gamma,
            gas_constant,
            pieces,
            wall,
            wall_factor,
            scheme,
        } = *duct.clone();
        item.positive("length", length)?;
        item.not_negative("wall_factor", wall_factor)?;
        let idle = |key| {
            Warning::idle(item, key, "the duct has no losses at its wall", "give `wall`, or leave it out")
        };
        if wall == WallChoice::None {
            self.warnings.extend((wall_factor != 1.0).then(|| idle("wall_factor")));
            self.warnings.extend((scheme == Scheme::Lumped).then(|| idle("scheme")));
        }
        let disc = |d: f64| 0.25 * PI * d * d;
        let area = match (diameter, area) {
            (Some(d), None) => disc(item.positive("diameter", d)?),
            (None, Some(a)) => item.positive("area", a)?,
            _ => return Err(item.fail(ElementProblem::OneOf { one: "diameter", other: "area" })),
        };
        let area_end = match (diameter_end, area_end) {
            (None, None) => area,
            (Some(d), None) => disc(item.positive("diameter_end", d)?),
            (None, Some(a)) => item.positive("area_end", a)?,
            _ => return Err(item.fail(ElementProblem::OneOf { one: "diameter_end", other: "area_end" })),
        };
        let varied = match (temperature_end, &temperatures) {
            (Some(_), _) => Some("temperature_end"),
            (_, Some(_)) => Some("temperatures"),
            _ => temperature.map(|_| "temperature"),
        };
        let profile = match (temperature, temperature_end, temperatures) {
            (first, None, None) => vec![first.unwrap_or(self.gas.temperature)],
            (first, Some(last), None) => vec![first.unwrap_or(self.gas.temperature), last],
            (None, None, Some(list)) if !list.is_empty() => list,
            _ => return Err(item.fail(ElementProblem::OneOf { one: "temperature", other: "temperatures" })),
        };
        for &t in &profile {
            item.positive("temperature", t)?;
        }
        let gamma = item.positive("gamma", gamma.unwrap_or(self.gas.gamma))?;
        if gamma <= 1.0 {
            return Err(item.fail(ElementProblem::Gamma { value: gamma }));
        }
        let constant = item.positive("gas_constant", gas_constant.unwrap_or(self.gas.gas_constant))?;
        let given = match (sound_speed, density) {
            (None, None) => None,
            (Some(c), Some(rho)) => Some((item.positive("sound_speed", c)?, item.positive("density", rho)?)),
            _ => return Err(item.fail(ElementProblem::Together { one: "sound_speed", other: "density" })),
        };
        if let Some((c, rho)) = given {
            let why = "`sound_speed` and `density` say what the gas is";
            let idle = |key| Warning::idle(item, key, why, "leave one or the other out");
            self.warnings.extend(varied.map(idle));
            let (found, expected) = (rho * c * c / gamma, self.gas.pressure);
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
        let span = profile.iter().fold([f64::INFINITY, 0.0], |[low, high], t| [t.min(low), t.max(high)]);
        let first = self.segments.first().zip(self.gases.first()).map_or_else(
            || [profile[0], area, (gamma * constant * profile[0]).sqrt()],
            |(segment, gas)| [gas.temperature, segment.area, segment.sound_speed],
        );
        let resolved = self
            .carried
            .filter(|_| given.is_none())
            .map_or(1, |carried| carried.pieces(length, span, area.max(area_end), first));
        let usual = if area_end != area {
            PIECES_OF_A_CONE
        } else if varies || scheme == Scheme::Lumped {
            40
        } else {
            1
        };
        let pieces = pieces.unwrap_or(usual.max(resolved.min(MOST_BY_ITSELF)));
        if span[1] > span[0] && resolved > UNRESOLVED * pieces {
            let what = format!(
                "in {pieces} pieces the entropy waves of this slope turn too far from one to the next, so that growth rates, and which modes there are, may be wrong"
            );
            let remedy = format!(
                "write pieces = {resolved}, search to a lower frequency, or write entropy_waves = false in [flow]"
            );
            self.warnings.push(Warning::range(item, what, remedy));
        }
        if !(1..=MOST_PIECES).contains(&pieces) {
            return Err(item.fail(ElementProblem::Range {
                key: "pieces",
                value: pieces,
                low: 1,
                high: MOST_PIECES,
            }));
        }
        // Borders of the pieces, and whether the lumped scheme jumps there: not at cuts.
        let mut borders: Vec<(f64, bool)> =
            (0..=pieces).map(|k| (length * k as f64 / pieces as f64, true)).collect();
        for x in cuts.iter().map(|x| x - placed.x).filter(|x| (slack..length - slack).contains(x)) {
            let next = borders.partition_point(|b| b.0 < x);
            if x - borders[next - 1].0 > slack && borders[next].0 - x > slack {
                borders.insert(next, (x, false));
            }
        }
        if varies {
            // Slivers of the local gas and area at both ends and beside devices, so that ends and devices
            // refer to what is there and not to the middle of a piece, which would be of first order in its
            // length.
            let sliver = (SLIVER * length).max(100.0 * slack);
            let within = |x: f64| x > slack && x < length - slack;
            let devices = cuts.iter().map(|x| x - placed.x).filter(|x| within(*x));
            let beside = devices.flat_map(|x| [x - sliver, x + sliver]);
            for x in beside.chain([sliver, length - sliver]).collect::<Vec<_>>() {
                let next = borders.partition_point(|b| b.0 < x);
                if next > 0
                    && next < borders.len()
                    && x - borders[next - 1].0 > slack
                    && borders[next].0 - x > slack
                {
                    borders.insert(next, (x, false));
                }
            }
        }
        let at = |fraction: f64| {
            let position = fraction * (profile.len() - 1) as f64;
            let k = (position as usize).min(profile.len().saturating_sub(2));
            let next = profile.get(k + 1).copied().unwrap_or(profile[k]);
            profile[k] + (position - k as f64) * (next - profile[k])
        };
        let radius = |fraction: f64| area.sqrt() + fraction * (area_end.sqrt() - area.sqrt());
        for (k, pair) in borders.windows(2).enumerate() {
            let [(from, jumps), (to, _)] = [pair[0], pair[1]];
            let middle = 0.5 * (from + to) / length;
            let t = given.map_or(at(middle), |(c, _)| c * c / (gamma * constant));
            let gas = LocalGas { temperature: t, gamma, heat: constant * t };
            let (c, rho) = given.unwrap_or_else(|| ((gamma * gas.heat).sqrt(), self.gas.pressure / gas.heat));
            let segment = Segment::new(to - from, radius(middle).powi(2), c, rho);
            let index = self.segments.len();
            self.segments.push(segment);
            self.gases.push(gas);
            self.owners.push(owner);
            let Some(law) = wall.law() else {
                self.walls.push(None);
                continue;
            };
            let gas = self.wall(&segment, &gas);
            if varies || k == 0 {
                self.laws.push(format!("{}: viscous wall loss", item.place), Law::Viscous(law, gas));
                self.laws.push(format!("{}: thermal wall loss", item.place), Law::Thermal(law, gas));
            }
            let thermal = self.laws.laws.len() - 1;
            let slots = match scheme {
                Scheme::Line => [Slot::Viscous(index), Slot::Thermal(index)],
                Scheme::Lumped => [Slot::Mu(index), Slot::Ep(index)],
            };
            let line = scheme == Scheme::Line;
            self.walls.push(line.then_some(FlowWall { law, wall: gas, factor: wall_factor }));
            if line || (k > 0 && jumps) {
                let weight = if line { wall_factor } else { wall_factor * length / pieces as f64 };
                for (slot, law) in slots.into_iter().zip([thermal - 1, thermal]) {
                    self.attach.push(Attached { slot, law, weight, role: Role::Plain });
                }
            }
        }
        Ok(())
    }
}

/// Length of the pieces at the ends of a duct whose gas or area varies, over the length of the duct.
const SLIVER: f64 = 1e-6;

/// Pieces of a cone. Their error falls as the square of their number: 0.08 Hz in 626 Hz with 40 of them, in a
/// cone of 0.5 m from 0.05 to 0.12 m of diameter that cools from 600 to 400 K.
const PIECES_OF_A_CONE: usize = 160;

/// Most pieces that a slope in a flow gets by itself.
const MOST_BY_ITSELF: usize = 2000;
/// How many times too few pieces are said to be.
const UNRESOLVED: usize = 2;

/// More pieces than any temperature profile needs.
const MOST_PIECES: usize = 100_000;
