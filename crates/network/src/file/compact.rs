//! Devices between ducts: feedback, orifices, flames, resonators.

use super::assembly::Flame;
use super::assembly::{Assembly, Attached, Role};
use super::error::FileError;
use super::item::Item;
use super::odd::{growing, heated, large};
use super::problem::ElementProblem;
use super::schema;
use super::schema::{Coefficient, Direction, Element, Outlet, Transfer};
use super::spread::Along;
use super::warning::Warning;
use crate::flow_chain::ActionKind;
use crate::laws::wall::Wall;
use crate::laws::{
    Behind, BiasHole, Law, Leg, PathDuct, Probe, Side, SideHole, SourceCoefficient, Table, TableRow, fok,
    inner_correction, matching_length, series_correction, steady_share,
};
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

    /// The element at `place`, between the segments before and after it.
    pub(super) fn compact(
        &mut self,
        item: &Item,
        place: usize,
        element: &Element,
        along: Option<&Along>,
    ) -> Result<(), FileError> {
        let before = place.saturating_sub(1);
        let after = place.min(self.segments.len() - 1);
        let here = self.segments[before.min(after)];
        let name = |what: &str| format!("{}: {what}", item.place);
        match element {
            Element::Duct(_) => {}
            Element::Feedback { mu, mp, eu, ep } => {
                let slots = [Slot::Mu(place), Slot::Mp(place), Slot::Eu(place), Slot::Ep(place)];
                for (slot, coefficient) in slots.into_iter().zip([mu, mp, eu, ep]) {
                    let law = match coefficient {
                        Coefficient::Constant([0.0, 0.0]) => continue,
                        Coefficient::Constant([re, im]) => Law::Constant(C64::new(*re, *im)),
                        Coefficient::Function(t) => self.function(item, t, 1.0)?,
                    };
                    let takes =
                        matches!((slot, &law), (Slot::Mu(_) | Slot::Ep(_), Law::Constant(k)) if k.re >= 0.0);
                    self.passive &= takes;
                    self.add(slot, name("feedback"), law, Role::Plain);
                }
            }
            Element::Orifice { diameter, thickness, drag, porosity, bias_velocity } => {
                item.positive("diameter", *diameter)?;
                item.not_negative("thickness", *thickness)?;
                item.not_negative("drag", *drag)?;
                let part = 0.25 * PI * diameter * diameter / here.area;
                let open = porosity.map_or(Ok(part), |value| item.part("porosity", value))?;
                if part > open * (1.0 + 1e-9) {
                    return Err(item.fail(ElementProblem::PartOfAHole { part, porosity: open }));
                }
                // On either side 8/(3 pi) radii (Rienstra & Hirschberg, section 4.4.3, as in the paper), less
                // by Fok's function in a tube of finite width: the duct, or for one of many holes its share
                // of the duct (Melling 1973).
                let shares = [before, after].map(|i| open * here.area / self.segments[i].area);
                let sides = [0, 1].map(|k| {
                    let (i, share) = ([before, after][k], shares[k]);
                    self.relative_width(item, *diameter, i, porosity.map(|_| share.sqrt())).map(fok)
                });
                let [inside, outside] = sides;
                let [radius, sides] = [0.5 * diameter, inside? + outside?];
                let effective = thickness + 8.0 / (3.0 * PI) * radius * sides;
                let inertia = here.density * effective / open;
                let plain = Law::Linear { constant: C64::new(*drag, 0.0), per_s: C64::new(inertia, 0.0) };
                let law = match bias_velocity {
                    None => plain,
                    Some(velocity) => {
                        let time = radius / item.positive("bias_velocity", *velocity)?;
                        let steady = steady_share(shares);
                        // A hole in the open has pi R/2, half of it on either side.
                        let shed = here.density * 0.25 * PI * radius * sides / open;
                        // A hole as wide as the duct has no edge that sheds.
                        if steady > 0.0 {
                            let time = time * 0.5 * sides / steady;
                            Law::Bias(BiasHole { drag: *drag, inertia, shed, time, of: Behind::Duct })
                        } else {
                            plain
                        }
                    }
                };
                self.add(Slot::Mu(place), name("orifice"), law, Role::Plain);
            }
            Element::Screen { resistance, open_area, loss, effective_length } => {
                item.not_negative("resistance", *resistance)?;
                item.not_negative("effective_length", *effective_length)?;
                let loss = match (open_area, loss) {
                    (None, loss) => item.not_negative("loss", loss.unwrap_or(0.0))?,
                    (Some(part), None) => {
                        let part = item.part("open_area", *part)?;
                        // Idelchik 1986, diagram 8-6: round wires, Re above 1000.
                        1.3 * (1.0 - part) + (1.0 / part - 1.0).powi(2)
                    }
                    (Some(_), Some(_)) => {
                        return Err(item.fail(ElementProblem::OneOf { one: "open_area", other: "loss" }));
                    }
                };
                self.screens.push((place, loss));
                let per_s = C64::new(here.density * effective_length, 0.0);
                let law = Law::Linear { constant: C64::new(*resistance, 0.0), per_s };
                self.add(Slot::Mu(place), name("screen"), law, Role::Plain);
            }
            Element::SideHole { diameter, length, outlet, wall } => {
                item.positive("diameter", *diameter)?;
                item.positive("length", *length)?;
                let delta = self.relative_width(item, *diameter, after, None)?;
                let radius = 0.5 * diameter;
                let sound_speed = here.sound_speed;
                let hole = SideHole {
                    area_ratio: PI * radius * radius / self.segments[after].area,
                    length: length + radius * matching_length(delta),
                    inner: radius * inner_correction(delta),
                    series: radius * series_correction(delta, length / radius),
                    gas: Wall { diameter: *diameter, ..self.wall(&here, &self.gases[before.min(after)]) },
                    wall: wall.law(),
                    outlet: match outlet {
                        Outlet::Flanged => Law::Flanged { radius, sound_speed },
                        Outlet::Unflanged => Law::Unflanged { radius, sound_speed, correction: 0.0 },
                    },
                    of: Leg::Ep,
                };
                for (slot, of, role) in [
                    (Slot::Mu(place), Leg::Mu, Role::Plain),
                    (Slot::Mp(place), Leg::Mp, Role::Plain),
                    (Slot::Eu(place), Leg::Eu, Role::Plain),
                    (Slot::Ep(place), Leg::Ep, Role::Branch),
                ] {
                    let law = Law::SideHole(Box::new(SideHole { of, ..hole.clone() }));
                    self.add(slot, name("side hole"), law, role);
                }
            }
            Element::Flame(flame) => self.flame(item, place, flame, along)?,
            Element::Helmholtz { volume, neck_area, neck_length, resistance, bias_velocity } => {
                item.positive("volume", *volume)?;
                item.positive("neck_area", *neck_area)?;
                item.positive("neck_length", *neck_length)?;
                item.not_negative("resistance", *resistance)?;
                let stiffness = here.density * here.sound_speed * here.sound_speed / volume;
                let duct_area = self.segments[after].area;
                let law = match bias_velocity {
                    None => Law::Helmholtz {
                        duct_area,
                        inertance: here.density * neck_length / neck_area,
                        resistance: resistance / neck_area,
                        stiffness,
                    },
                    Some(velocity) => {
                        let (radius, share) = ((neck_area / PI).sqrt(), duct_area / neck_area);
                        Law::Bias(BiasHole {
                            drag: resistance * share,
                            inertia: here.density * neck_length * share,
                            shed: here.density * 0.5 * PI * radius * share,
                            time: radius / item.positive("bias_velocity", *velocity)?,
                            of: Behind::Volume { stiffness: stiffness * duct_area },
                        })
                    }
                };
                self.add(Slot::Ep(place), name("resonator"), law, Role::Branch);
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
                self.add(Slot::Ep(place), name("side branch"), law, Role::Branch);
            }
        }
        Ok(())
    }

    /// Diameter of a hole over that of the duct of segment `i`, or over that of its share of the duct, which
    /// is `among` others.
    fn relative_width(
        &self,
        item: &Item,
        diameter: f64,
        i: usize,
        among: Option<f64>,
    ) -> Result<f64, FileError> {
        let tube = 2.0 * (self.segments[i].area / PI).sqrt();
        let single = diameter / tube;
        let relative = among.unwrap_or(single);
        if relative > 1.0 + 1e-9 || single > 1.0 + 1e-9 {
            let diameter = diameter.max(relative * tube);
            return Err(item.fail(ElementProblem::HoleTooWide { diameter, tube }));
        }
        Ok(relative.min(1.0))
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
        let (path, side) = self.path(item, place, reference, downstream)?;
        // What Q'/Q = n F u'/U means for k_eu: the mean flow carries as much mass through the reference.
        let at = match path.last() {
            Some((i, _)) => *i,
            None if downstream => after,
            None => before,
        };
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
        let path: Vec<PathDuct> = path.into_iter().map(|(_, stretch)| stretch).collect();
        if let Some(along) = along {
            return self.spread(item, place, &shape, gain, (reference, &path), along);
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
        for (slot, of) in
            [(Slot::Eu(place), SourceCoefficient::Velocity), (Slot::Ep(place), SourceCoefficient::Pressure)]
        {
            let probe = Probe { transfer: transfer.clone(), path: path.clone(), of, side };
            self.add(slot, name.clone(), Law::Probe(Box::new(probe)), Role::Flame);
        }
        Ok(())
    }

    /// The segments from a place over `distance` upstream or downstream.
    fn path(
        &self,
        item: &Item,
        place: usize,
        distance: f64,
        downstream: bool,
    ) -> Result<(Vec<(usize, PathDuct)>, Side), FileError> {
        let n = self.segments.len();
        let side = if downstream {
            if let Some((_, other)) =
                self.devices.iter().find(|(j, other)| *j == place && *other != item.place)
            {
                return Err(item.fail(ElementProblem::NotAlone { other: other.clone() }));
            }
            let inside = place > 0 && place < n;
            let ratio = if inside { self.segments[place - 1].area / self.segments[place].area } else { 1.0 };
            Side::Downstream { ratio }
        } else {
            Side::Upstream
        };
        let mut segments: Vec<usize> =
            if downstream { (place..n).collect() } else { (0..place).rev().collect() };
        let available: f64 = segments.iter().map(|&i| self.segments[i].length).sum();
        if distance > available * (1.0 + 1e-9) {
            return Err(item.fail(ElementProblem::ReferenceOutside { distance, length: available }));
        }
        let (mut path, mut left, mut area) = (Vec::new(), distance, None);
        for i in segments.drain(..) {
            if left <= 1e-9 * available {
                break;
            }
            if let Some(area) = area {
                let between = if downstream { i } else { i + 1 };
                if let Some((_, other)) = self.devices.iter().find(|(j, _)| *j == between) {
                    return Err(item.fail(ElementProblem::ReferenceBlocked { other: other.clone() }));
                }
                path.push((i, area / self.segments[i].area));
            } else {
                path.push((i, 1.0));
            }
            area = Some(self.segments[i].area);
            left -= self.segments[i].length;
        }
        let (last, mut rest) = (path.len().saturating_sub(1), distance);
        let stretch = |(k, &(i, ratio)): (usize, &(usize, f64))| {
            let mut segment = self.segments[i];
            if k == last {
                segment.length = rest;
            }
            rest -= segment.length;
            (i, PathDuct { segment, ratio, ..self.stretch(i) })
        };
        Ok((path.iter().enumerate().map(stretch).collect(), side))
    }

    /// Segment `i` as a duct on the way to somewhere.
    pub(super) fn stretch(&self, i: usize) -> PathDuct {
        let losses = self.walls[i].as_ref().map(|w| {
            let scaled = |law: Law| Law::Scaled(Box::new(law), C64::new(w.factor, 0.0));
            [scaled(Law::Viscous(w.law, w.wall)), scaled(Law::Thermal(w.law, w.wall))]
        });
        PathDuct { segment: self.segments[i], ratio: 1.0, losses }
    }
}
