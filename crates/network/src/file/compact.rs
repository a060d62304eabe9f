//! Devices between ducts: what a table of each becomes, feedback, flames.

use super::assembly::{Assembly, Attached, Flame, Listener, Role};
use super::devices::Site;
use super::error::FileError;
use super::item::Item;
use super::odd::{growing, heated, large};
use super::problem::ElementProblem;
use super::schema;
use super::schema::{Coefficient, Direction, Element, Feedback, Transfer};
use super::spread::Along;
use super::warning::Warning;
use crate::flow_chain::ActionKind;
use crate::laws::{Law, Table, TableRow};
use crate::slot::Slot;
use rijke_numerics::{C64, has_growing_root};
use std::f64::consts::PI;

impl Assembly<'_> {
    /// A function of s, times `factor`.
    pub(super) fn function(&mut self, item: &Item, t: &Transfer, factor: f64) -> Result<Law, FileError> {
        item.not_negative("delay", t.delay)?;
        let gain = factor * t.gain;
        if !gain.is_finite() {
            return Err(item.fail(ElementProblem::NotFinite { key: "gain", value: gain }));
        }
        if let Some(rows) = &t.table {
            let plain = t.cutoff_hz.is_none() && t.numerator == [1.0] && t.denominator == [1.0];
            if !plain {
                return Err(item.fail(ElementProblem::OneOf {
                    one: "table",
                    other: "cutoff_hz, numerator, denominator",
                }));
            }
            let table = self.table(item, rows, t.tolerance)?.later(t.delay);
            return Ok(Law::Scaled(Box::new(Law::Table(table)), C64::new(gain, 0.0)));
        }
        let mut denominator = item.polynomial("denominator", &t.denominator)?;
        if has_growing_root(&denominator) {
            return Err(item.fail(ElementProblem::Grows { key: "denominator" }));
        }
        if let Some(f) = t.cutoff_hz {
            let time = 1.0 / (2.0 * PI * item.positive("cutoff_hz", f)?);
            denominator.push(0.0);
            for i in (1..denominator.len()).rev() {
                denominator[i] += time * denominator[i - 1];
            }
        }
        let numerator = item.polynomial("numerator", &t.numerator)?;
        Ok(Law::Transfer { gain, numerator, denominator, delay: t.delay })
    }

    fn table(&mut self, item: &Item, rows: &[[f64; 3]], tolerance: f64) -> Result<Table, FileError> {
        let rows: Vec<TableRow> = rows.iter().copied().map(TableRow::from).collect();
        let table = match &mut self.redraw {
            Some(redraw) => redraw.table(&rows, tolerance),
            None => Table::fit(&rows, tolerance),
        };
        let table = table.map_err(|error| item.fail(error.into()))?;
        self.tables.push((item.clone(), table.clone()));
        Ok(table)
    }

    pub(super) fn add(&mut self, slot: Slot, name: String, law: Law, role: Role) {
        let law = self.laws.push(name, law);
        self.attach.push(Attached { slot, law, weight: 1.0, role });
    }

    /// The element at `place`.
    pub(super) fn compact(
        &mut self,
        item: &Item,
        place: usize,
        element: &Element,
        along: Option<&Along>,
    ) -> Result<(), FileError> {
        let site = Site::of(self, item, place);
        match element {
            Element::Duct(_) => Ok(()),
            Element::Feedback(feedback) => self.feedback(&site, feedback),
            Element::Orifice(orifice) => self.orifice(&site, orifice),
            Element::Screen(screen) => self.screen(&site, screen),
            Element::SideHole(hole) => self.side_hole(&site, hole),
            Element::Flame(flame) => self.flame(item, place, flame, along),
            Element::Helmholtz(resonator) => self.helmholtz(&site, resonator),
            Element::QuarterWave(branch) => self.quarter_wave(&site, branch),
        }
    }

    fn feedback(&mut self, site: &Site<'_>, feedback: &Feedback) -> Result<(), FileError> {
        let (j, Feedback { mu, mp, eu, ep }) = (site.place, feedback);
        let slots = [Slot::Mu(j), Slot::Mp(j), Slot::Eu(j), Slot::Ep(j)];
        for (slot, coefficient) in slots.into_iter().zip([mu, mp, eu, ep]) {
            let law = match coefficient {
                Coefficient::Constant([0.0, 0.0]) => continue,
                Coefficient::Constant([re, im]) => Law::Constant(C64::new(*re, *im)),
                Coefficient::Function(t) => self.function(site.item, t, 1.0)?,
            };
            let takes = matches!((slot, &law), (Slot::Mu(_) | Slot::Ep(_), Law::Constant(k)) if k.re >= 0.0);
            self.passive &= takes;
            self.add(slot, site.name("feedback"), law, Role::Plain);
        }
        Ok(())
    }

    fn flame(
        &mut self,
        item: &Item,
        place: usize,
        flame: &schema::Flame,
        along: Option<&Along>,
    ) -> Result<(), FileError> {
        let schema::Flame {
            gain,
            n,
            delay,
            cutoff_hz,
            numerator,
            denominator,
            table,
            tolerance,
            reference,
            reference_side,
            ..
        } = flame;
        self.warnings.extend(growing(item, numerator, denominator, *cutoff_hz));
        let reference = item.not_negative("reference", *reference)?;
        let (before, after) = (place.saturating_sub(1), place.min(self.segments.len() - 1));
        let downstream = *reference_side == Direction::Downstream;
        let heard = self.reference(item, place, reference, downstream)?;
        // What Q'/Q = n F u'/U means for k_eu: the mean flow carries as much mass through the reference.
        let at = heard.unwrap_or(if downstream { after } else { before });
        let heat = |i: usize| self.gases[i].heat;
        let last = along.map_or(after, |a| a.end.min(self.segments.len() - 1));
        let mean =
            (heat(last) - heat(before)) / heat(at) * self.segments[at].area / self.segments[after].area;
        let (gain, law_of_flow) = match (gain, n) {
            (Some(gain), None) => (*gain, -*gain),
            (None, Some(n)) => (n * mean, *n),
            _ => return Err(item.fail(ElementProblem::OneOf { one: "gain", other: "n" })),
        };
        let effect = if n.is_some() { ActionKind::Flame } else { ActionKind::Eu };
        if !gain.is_finite() {
            return Err(item.fail(ElementProblem::NotFinite { key: "gain", value: gain }));
        }
        let shape = Transfer {
            gain: 1.0,
            delay: *delay,
            cutoff_hz: *cutoff_hz,
            numerator: numerator.clone(),
            denominator: denominator.clone(),
            table: table.clone(),
            tolerance: *tolerance,
        };
        self.passive &= gain == 0.0;
        let temperatures = [before, last].map(|i| self.gases[i].temperature);
        self.warnings.extend(n.filter(|n| *n != 0.0).and_then(|_| heated(item, mean, temperatures)));
        if let Some(rows) = table {
            self.warnings.extend(large(item, n.map(|n| n.abs()), rows));
            self.warnings.extend(Warning::of_table(item, rows, true));
        }
        if let Some(along) = along {
            return self.spread(item, place, &shape, gain, reference, along);
        }
        let law = self.function(item, &shape, law_of_flow)?;
        self.flames.push(Flame { place, law, effect, reference, downstream });
        let name = format!("{}: flame", item.place);
        if reference == 0.0 && !downstream {
            let law = self.function(item, &shape, -gain)?;
            self.add(Slot::Eu(place), name, law, Role::Flame);
            return Ok(());
        }
        let transfer = self.function(item, &shape, gain)?;
        let law = self.laws.push(name, transfer);
        let listener =
            Listener { item: item.clone(), place, law, distance: reference, downstream, spread: None };
        self.listeners.push(listener);
        Ok(())
    }
}
