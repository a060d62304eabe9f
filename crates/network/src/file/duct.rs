//! Ducts: straight or conical, uniform or with a temperature profile, with or without wall losses.

use super::assembly::{Assembly, Attached, LocalGas, Role};
use super::course::Course;
use super::error::FileError;
use super::item::Item;
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
        let Duct { length, wall, wall_factor, scheme, .. } = **duct;
        item.not_negative("wall_factor", wall_factor)?;
        if wall == WallChoice::None {
            let idle = |key| {
                Warning::idle(item, key, "the duct has no losses at its wall", "give `wall`, or leave it out")
            };
            self.warnings.extend((wall_factor != 1.0).then(|| idle("wall_factor")));
            self.warnings.extend((scheme == Scheme::Lumped).then(|| idle("scheme")));
        }
        let course = Course::of(item, duct, self.gas, &mut self.warnings)?;
        let pieces = self.pieces(item, duct, &course)?;
        let cuts: Vec<f64> = cuts.iter().map(|x| x - placed.x).collect();
        let borders = borders(&course, length, pieces, &cuts, slack);
        for (k, pair) in borders.windows(2).enumerate() {
            let [(from, jumps), (to, _)] = [pair[0], pair[1]];
            let gas = course.gas(0.5 * (from + to));
            let middle = course.segment([from, to]);
            let index = self.segments.len();
            // A mean flow has the gas and the area of the middle; slivers are short as they are.
            if course.varies() && !self.flows && to - from > 2.0 * sliver(length, slack) {
                self.segments.extend(course.halves([from, to]));
            } else {
                self.segments.push(middle);
            }
            let added = index..self.segments.len();
            self.gases.extend(added.clone().map(|_| gas));
            self.owners.extend(added.clone().map(|_| owner));
            let Some(law) = wall.law() else {
                self.walls.extend(added.map(|_| None));
                continue;
            };
            let gas = self.wall(&middle, &gas);
            if course.varies() || k == 0 {
                self.laws.push(format!("{}: viscous wall loss", item.place), Law::Viscous(law, gas));
                self.laws.push(format!("{}: thermal wall loss", item.place), Law::Thermal(law, gas));
            }
            let thermal = self.laws.laws.len() - 1;
            let line = scheme == Scheme::Line;
            let wall = line.then_some(FlowWall { law, wall: gas, factor: wall_factor });
            self.walls.extend(added.clone().map(|_| wall.clone()));
            let slots = if line {
                added.flat_map(|i| [Slot::Viscous(i), Slot::Thermal(i)]).collect()
            } else if k > 0 && jumps {
                vec![Slot::Mu(index), Slot::Ep(index)]
            } else {
                Vec::new()
            };
            let weight = if line { wall_factor } else { wall_factor * length / pieces as f64 };
            for (slot, law) in slots.into_iter().zip([thermal - 1, thermal].into_iter().cycle()) {
                self.attach.push(Attached { slot, law, weight, role: Role::Plain });
            }
        }
        Ok(())
    }

    /// Into how many pieces a duct is cut.
    fn pieces(&mut self, item: &Item, duct: &Duct, course: &Course) -> Result<usize, FileError> {
        let span = course.span();
        let beginning = self.segments.first().zip(self.gases.first());
        let beginning = beginning
            .map_or(course.beginning(), |(first, gas)| [gas.temperature, first.area, first.sound_speed]);
        let widest = course.area[0].max(course.area[1]);
        let carried = self.carried.filter(|_| course.given.is_none());
        let resolved = carried.map_or(1, |carried| carried.pieces(duct.length, span, widest, beginning));
        let usual = match (course.is_cone(), course.varies() || duct.scheme == Scheme::Lumped) {
            (true, _) if self.flows => PIECES_OF_A_CONE_IN_A_FLOW,
            (_, true) => 40,
            _ => 1,
        };
        let pieces = duct.pieces.unwrap_or(usual.max(resolved.min(MOST_BY_ITSELF)));
        if span[1] > span[0] && resolved > UNRESOLVED * pieces {
            let what = format!(
                "in {pieces} pieces the entropy waves of this slope are not resolved, so that growth rates, and which modes there are, may be wrong"
            );
            let remedy = format!(
                "write pieces = {resolved}, search to a lower frequency, or write entropy_waves = false in [flow]"
            );
            self.warnings.push(Warning::range(item, what, remedy));
        }
        if !(1..=MOST_PIECES).contains(&pieces) {
            let key = "pieces";
            return Err(item.fail(ElementProblem::Range { key, value: pieces, low: 1, high: MOST_PIECES }));
        }
        if duct.scheme == Scheme::Lumped {
            return Ok(pieces);
        }
        self.in_pieces |= course.varies();
        Ok(pieces * self.finer)
    }
}

/// Borders of the pieces of a duct, m from its beginning, and whether the lumped scheme jumps there: not at
/// `cuts`.
fn borders(course: &Course, length: f64, pieces: usize, cuts: &[f64], slack: f64) -> Vec<(f64, bool)> {
    let mut borders: Vec<(f64, bool)> =
        (0..=pieces).map(|k| (length * k as f64 / pieces as f64, true)).collect();
    let mut cut = |x: f64| {
        let next = borders.partition_point(|b| b.0 < x);
        let inside = next > 0 && next < borders.len();
        if inside && x - borders[next - 1].0 > slack && borders[next].0 - x > slack {
            borders.insert(next, (x, false));
        }
    };
    let within = |x: &f64| (slack..length - slack).contains(x);
    let inner: Vec<f64> = cuts.iter().copied().filter(within).collect();
    inner.iter().copied().for_each(&mut cut);
    if course.varies() {
        course.kinks().for_each(&mut cut);
        // Slivers of the local gas and area at both ends and beside devices, so that ends and devices refer
        // to what is there and not to the middle of a piece, which would be of first order in its length.
        let sliver = sliver(length, slack);
        let beside = inner.iter().flat_map(|x| [x - sliver, x + sliver]);
        beside.chain([sliver, length - sliver]).for_each(cut);
    }
    borders
}

/// Length of the pieces at the ends of a duct whose gas or area varies, and beside devices in it.
fn sliver(length: f64, slack: f64) -> f64 {
    (SLIVER * length).max(100.0 * slack)
}

/// The same over the length of the duct.
const SLIVER: f64 = 1e-6;

/// Pieces of a cone in a mean flow, where their error falls as the square of their number: 0.08 Hz in 626 Hz
/// with 40 of them, in a cone of 0.5 m from 0.05 to 0.12 m of diameter that cools from 600 to 400 K.
const PIECES_OF_A_CONE_IN_A_FLOW: usize = 160;

/// Most pieces that a slope in a flow gets by itself.
const MOST_BY_ITSELF: usize = 2000;
/// How many times too few pieces are said to be.
const UNRESOLVED: usize = 2;

/// More pieces than any temperature profile needs.
const MOST_PIECES: usize = 100_000;
