//! Devices without a flame: plates, gauzes, holes and resonators.

use super::assembly::{Assembly, Role};
use super::error::FileError;
use super::item::Item;
use super::problem::ElementProblem;
use super::schema::{Branch, Hole, Orifice, Outlet, Resonator, Screen};
use crate::chain::network::Segment;
use crate::laws::wall::Wall;
use crate::laws::{
    Behind, BiasHole, Law, Leg, SideHole, fok, inner_correction, matching_length, series_correction,
    steady_share,
};
use crate::slot::Slot;
use rijke_numerics::C64;
use std::f64::consts::PI;

/// Where a device is.
pub(super) struct Site<'a> {
    pub(super) item: &'a Item,
    pub(super) place: usize,
    /// The segments before and behind it; both are the one that there is at an end.
    around: [usize; 2],
    /// The segment before it.
    here: Segment,
}

impl<'a> Site<'a> {
    pub(super) fn of(assembly: &Assembly<'_>, item: &'a Item, place: usize) -> Self {
        let around = [place.saturating_sub(1), place.min(assembly.segments.len() - 1)];
        Self { item, place, around, here: assembly.segments[around[0].min(around[1])] }
    }

    /// What one of its laws is called.
    pub(super) fn name(&self, what: &str) -> String {
        format!("{}: {what}", self.item.place)
    }
}

impl Assembly<'_> {
    pub(super) fn orifice(&mut self, site: &Site<'_>, orifice: &Orifice) -> Result<(), FileError> {
        let (item, here) = (site.item, &site.here);
        let Orifice { diameter, thickness, drag, porosity, bias_velocity } = *orifice;
        item.positive("diameter", diameter)?;
        item.not_negative("thickness", thickness)?;
        item.not_negative("drag", drag)?;
        let part = 0.25 * PI * diameter * diameter / here.area;
        let open = porosity.map_or(Ok(part), |value| item.part("porosity", value))?;
        if part > open * (1.0 + 1e-9) {
            return Err(item.fail(ElementProblem::PartOfAHole { part, porosity: open }));
        }
        // On either side 8/(3 pi) radii (Rienstra & Hirschberg, section 4.4.3, as in the paper), less by
        // Fok's function in a tube of finite width: the duct, or for one of many holes its share of the duct
        // (Melling 1973).
        let shares = site.around.map(|i| open * here.area / self.segments[i].area);
        let [inside, outside] = [0, 1].map(|k| {
            let among = porosity.map(|_| shares[k].sqrt());
            self.relative_width(item, diameter, site.around[k], among).map(fok)
        });
        let [radius, sides] = [0.5 * diameter, inside? + outside?];
        let effective = thickness + 8.0 / (3.0 * PI) * radius * sides;
        let inertia = here.density * effective / open;
        let plain = Law::Linear { constant: C64::new(drag, 0.0), per_s: C64::new(inertia, 0.0) };
        let law = match bias_velocity {
            None => plain,
            Some(velocity) => {
                let time = radius / item.positive("bias_velocity", velocity)?;
                let steady = steady_share(shares);
                // A hole in the open has pi R/2, half of it on either side.
                let shed = here.density * 0.25 * PI * radius * sides / open;
                // A hole as wide as the duct has no edge that sheds.
                if steady > 0.0 {
                    let time = time * 0.5 * sides / steady;
                    Law::Bias(BiasHole { drag, inertia, shed, time, of: Behind::Duct })
                } else {
                    plain
                }
            }
        };
        self.add(Slot::Mu(site.place), site.name("orifice"), law, Role::Plain);
        Ok(())
    }

    pub(super) fn screen(&mut self, site: &Site<'_>, screen: &Screen) -> Result<(), FileError> {
        let item = site.item;
        let Screen { resistance, open_area, loss, effective_length } = *screen;
        item.not_negative("resistance", resistance)?;
        item.not_negative("effective_length", effective_length)?;
        let loss = match (open_area, loss) {
            (None, loss) => item.not_negative("loss", loss.unwrap_or(0.0))?,
            (Some(part), None) => {
                let part = item.part("open_area", part)?;
                // Idelchik 1986, diagram 8-6: round wires, Re above 1000.
                1.3 * (1.0 - part) + (1.0 / part - 1.0).powi(2)
            }
            (Some(_), Some(_)) => {
                return Err(item.fail(ElementProblem::OneOf { one: "open_area", other: "loss" }));
            }
        };
        self.screens.push((site.place, loss));
        let per_s = C64::new(site.here.density * effective_length, 0.0);
        let law = Law::Linear { constant: C64::new(resistance, 0.0), per_s };
        self.add(Slot::Mu(site.place), site.name("screen"), law, Role::Plain);
        Ok(())
    }

    pub(super) fn side_hole(&mut self, site: &Site<'_>, hole: &Hole) -> Result<(), FileError> {
        let ([before, after], here) = (site.around, &site.here);
        let Hole { diameter, length, outlet, wall } = *hole;
        site.item.positive("diameter", diameter)?;
        site.item.positive("length", length)?;
        let delta = self.relative_width(site.item, diameter, after, None)?;
        let radius = 0.5 * diameter;
        let sound_speed = here.sound_speed;
        let law = SideHole {
            area_ratio: PI * radius * radius / self.segments[after].area,
            length: length + radius * matching_length(delta),
            inner: radius * inner_correction(delta),
            series: radius * series_correction(delta, length / radius),
            gas: Wall { diameter, ..self.wall(here, &self.gases[before.min(after)]) },
            wall: wall.law(),
            outlet: match outlet {
                Outlet::Flanged => Law::Flanged { radius, sound_speed },
                Outlet::Unflanged => Law::Unflanged { radius, sound_speed, correction: 0.0 },
            },
            of: Leg::Ep,
        };
        for (slot, of, role) in [
            (Slot::Mu(site.place), Leg::Mu, Role::Plain),
            (Slot::Mp(site.place), Leg::Mp, Role::Plain),
            (Slot::Eu(site.place), Leg::Eu, Role::Plain),
            (Slot::Ep(site.place), Leg::Ep, Role::Branch),
        ] {
            let law = Law::SideHole(Box::new(SideHole { of, ..law.clone() }));
            self.add(slot, site.name("side hole"), law, role);
        }
        Ok(())
    }

    pub(super) fn helmholtz(&mut self, site: &Site<'_>, resonator: &Resonator) -> Result<(), FileError> {
        let (item, here) = (site.item, &site.here);
        let Resonator { volume, neck_area, neck_length, resistance, bias_velocity } = *resonator;
        item.positive("volume", volume)?;
        item.positive("neck_area", neck_area)?;
        item.positive("neck_length", neck_length)?;
        item.not_negative("resistance", resistance)?;
        let stiffness = here.density * here.sound_speed * here.sound_speed / volume;
        let duct_area = self.segments[site.around[1]].area;
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
                    time: radius / item.positive("bias_velocity", velocity)?,
                    of: Behind::Volume { stiffness: stiffness * duct_area },
                })
            }
        };
        self.add(Slot::Ep(site.place), site.name("resonator"), law, Role::Branch);
        Ok(())
    }

    pub(super) fn quarter_wave(&mut self, site: &Site<'_>, branch: &Branch) -> Result<(), FileError> {
        let Branch { length, area } = *branch;
        site.item.positive("length", length)?;
        site.item.positive("area", area)?;
        let law = Law::QuarterWave {
            area_ratio: area / self.segments[site.around[1]].area,
            length,
            sound_speed: site.here.sound_speed,
            impedance: site.here.impedance(),
        };
        self.add(Slot::Ep(site.place), site.name("side branch"), law, Role::Branch);
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
}
