//! Numbers of a file that no rig has, and that are most often in another unit.

use super::item::Item;
use super::layout::Placed;
use super::schema::{Branch, Coefficient, Duct, Element, Feedback, Gas, Orifice, Resonator, Screen};
use super::warning::Warning;
use crate::plane::region::Region;
use rijke_numerics::slips::{
    COLD, PRANDTL, PRESSURE, VISCOSITY, is_light, is_too_late, is_too_long, is_too_wide,
};
use rijke_numerics::words::{rounded, to_digits};
use std::f64::consts::{PI, TAU};

/// Longer necks, holes and plates than this, m, are none.
const THICK: f64 = 5.0;
/// Pressures below this, Pa, are most often given in bar, for no rig runs at a third of the pressure of the
/// atmosphere.
const MOST_BAR: f64 = 30.0;
/// Room temperature, K.
const ROOM: f64 = 293.15;
/// Gas constant of uranium hexafluoride, J/(kg K), and a little more than the ratio of specific heats of
/// single atoms.
const HEAVIEST: f64 = 23.0;
const ATOMS: f64 = 1.68;
/// Flows through holes are slow beside the sound, up to this Mach number.
const FAST: f64 = 0.3;
/// A neck so many times as wide as its duct is in another unit.
const NECK: f64 = 10.0;

/// What is judged by the sound that is looked for.
pub(super) struct Sizes {
    /// Highest frequency of the search, Hz.
    pub(super) highest: f64,
    /// Wavelength there in the gas of the file, m.
    pub(super) wavelength: f64,
    /// Whether its gas is a liquid where it is very cold.
    freezes: bool,
}

impl Sizes {
    pub(super) fn of(gas: &Gas, region: &Region) -> Self {
        let highest = region.omega[1] / TAU;
        let sound_speed = (gas.gamma * gas.gas_constant * gas.temperature.max(COLD)).sqrt();
        Self { highest, wavelength: sound_speed / highest, freezes: !is_light(gas.gas_constant) }
    }

    /// What is doubtful about the sizes of gas and elements.
    pub(super) fn doubtful(&self, head: &Item, gas: &Gas, placed: &[Placed]) -> Vec<Warning> {
        let mut all = self.of_gas(head, gas);
        for Placed { item, element, x, .. } in placed {
            match element {
                Element::Duct(duct) => all.extend(self.of_duct(item, duct)),
                Element::Flame(flame) => {
                    all.extend(self.late(item, flame.delay).or_else(|| self.late(item, flame.delay_end?)));
                }
                Element::Feedback(Feedback { mu, mp, eu, ep }) => {
                    let delay = |c: &Coefficient| match c {
                        Coefficient::Function(t) => self.late(item, t.delay),
                        Coefficient::Constant(_) => None,
                    };
                    all.extend([mu, mp, eu, ep].into_iter().find_map(delay));
                }
                Element::Helmholtz(resonator) => {
                    all.extend(self.of_resonator(item, resonator, area_at(placed, *x)));
                }
                Element::QuarterWave(branch) => {
                    all.extend(self.of_branch(item, branch, area_at(placed, *x)));
                }
                Element::SideHole(hole) => all.extend(thick(item, "length", hole.length)),
                Element::Orifice(orifice) => all.extend(self.of_orifice(item, orifice)),
                Element::Screen(screen) => all.extend(of_screen(item, screen)),
            }
        }
        all
    }

    fn of_gas(&self, head: &Item, gas: &Gas) -> Vec<Warning> {
        let mut all: Vec<Warning> = self.cold(head, gas.temperature).into_iter().collect();
        let [least, most] = PRESSURE;
        all.extend((gas.pressure > most).then(|| {
            let what = format!("pressure is {} Pa, and rigs have at most {most}", rounded(gas.pressure));
            Warning::range(head, what, "check the decimal point and the unit")
        }));
        all.extend((gas.pressure < least).then(|| {
            let why = "less than in any rig".to_owned();
            let (unit, pascal) = if gas.pressure < MOST_BAR { ("bar", 1e5) } else { ("kPa", 1e3) };
            let remedy = format!("if these are {unit}, write {}", to_digits(pascal * gas.pressure, 6));
            size(head, "pressure", gas.pressure, "Pa", why, remedy)
        }));
        // Of liquids, which gas constants do not describe, nothing is said.
        let viscosity = gas.viscosity / (gas.temperature / ROOM).powf(0.7);
        for (what, value, unit, [low, high]) in [
            ("prandtl", gas.prandtl, "", PRANDTL),
            ("at 20 degC the viscosity", viscosity, " Pa s", VISCOSITY),
        ] {
            if self.freezes && !(low..=high).contains(&value) {
                let what =
                    format!("{what} is {}{unit}, and gases have {low} to {high}{unit}", rounded(value));
                all.push(Warning::range(head, what, "check the decimal point and the unit"));
            }
        }
        let remedy = "gas_constant is 8.314 J/(mol K) over the molar mass, 287.05 J/(kg K) for air";
        all.extend((gas.gas_constant < HEAVIEST).then(|| {
            let what = format!(
                "gas_constant is {} J/(kg K), and the heaviest gas has {HEAVIEST}",
                rounded(gas.gas_constant)
            );
            Warning::range(head, what, remedy)
        }));
        all.extend((gas.gamma > ATOMS).then(|| {
            let what = format!("gamma is {}, and no gas has more than 5/3", rounded(gas.gamma));
            Warning::range(head, what, "write 1.4 for air; check the decimal point")
        }));
        all
    }

    fn of_duct(&self, item: &Item, duct: &Duct) -> Vec<Warning> {
        let wide = |(key, value): (&'static str, Option<f64>)| self.wide(item, key, value?);
        let widths = [("diameter", duct.diameter), ("diameter_end", duct.diameter_end)];
        let given = [duct.temperature, duct.temperature_end];
        let list = duct.temperatures.iter().flatten().copied();
        let cold = given.into_iter().flatten().chain(list).find_map(|t| self.cold(item, t));
        let all = [self.long(item, duct.length), widths.into_iter().find_map(wide), cold];
        all.into_iter().flatten().collect()
    }

    /// Of a resonator on a duct of area `duct`, m^2.
    fn of_resonator(&self, item: &Item, resonator: &Resonator, duct: Option<f64>) -> Vec<Warning> {
        let Resonator { volume, neck_area: neck, neck_length, bias_velocity, .. } = *resonator;
        let mut all: Vec<Warning> = self.not_small(item, "the cavity", volume.cbrt()).into_iter().collect();
        all.extend(self.not_small(item, "the neck", neck_length).filter(|_| neck_length <= THICK));
        all.extend(thick(item, "neck_length", neck_length));
        all.extend(self.fast(item, bias_velocity));
        let (line, place) = (item.line, item.place.clone());
        all.extend(duct.filter(|duct| neck > NECK * duct).map(|duct| Warning::Neck {
            line,
            place,
            neck,
            duct,
        }));
        let least = 0.5 * PI * (neck / PI).sqrt();
        all.extend((neck_length < least).then(|| {
            let what = format!(
                "neck_length is {:.2} mm, and even a neck without a wall moves {:.2} mm of air: neck_length counts what moves on both sides of it",
                1e3 * neck_length,
                1e3 * least
            );
            Warning::range(item, what, "add some 0.8 radii on either side to the length of the neck")
        }));
        all
    }

    /// Of a closed tube on a duct of area `duct`, m^2.
    fn of_branch(&self, item: &Item, branch: &Branch, duct: Option<f64>) -> Vec<Warning> {
        let wide = duct.filter(|duct| branch.area > NECK * duct).map(|duct| {
            let (own, duct) = (rounded(branch.area), rounded(duct));
            let what = format!("its area is {own} m^2, and that of the duct {duct} m^2");
            Warning::range(item, what, "check its unit; a wider duct is no side branch")
        });
        self.long(item, branch.length).into_iter().chain(wide).collect()
    }

    fn of_orifice(&self, item: &Item, orifice: &Orifice) -> Vec<Warning> {
        let Orifice { diameter, thickness, bias_velocity, .. } = *orifice;
        let mut all: Vec<Warning> = thick(item, "thickness", thickness).into_iter().collect();
        all.extend((bias_velocity.is_some() && thickness > 0.5 * diameter).then(|| {
            let what = "with bias_velocity the hole is taken to be thinner than its radius: in a thicker one the shear layer meets the wall again";
            Warning::range(item, what.to_owned(), "leave bias_velocity out, and give the `drag` that was measured")
        }));
        all.extend(self.fast(item, bias_velocity));
        all
    }

    /// A flow through holes that is not as slow as its formula takes it to be.
    fn fast(&self, item: &Item, value: Option<f64>) -> Option<Warning> {
        let limit = FAST * self.wavelength * self.highest;
        let value = value.filter(|v| *v > limit)?;
        let why = format!("faster than the {limit:.0} m/s up to which its formula holds");
        let remedy = format!("if these are mm/s, write {}", to_digits(1e-3 * value, 6));
        Some(size(item, "bias_velocity", value, "m/s", why, remedy))
    }

    /// A delay of too many periods.
    pub(super) fn late(&self, item: &Item, value: f64) -> Option<Warning> {
        let periods = value * self.highest;
        let why = || format!("{periods:.0} periods of the highest frequency of the search");
        let remedy = || format!("if these are ms, write {}", to_digits(1e-3 * value, 6));
        is_too_late(value, self.highest).then(|| size(item, "delay", value, "s", why(), remedy()))
    }

    /// A duct of too many wavelengths.
    fn long(&self, item: &Item, value: f64) -> Option<Warning> {
        let waves = value / self.wavelength;
        let why = || format!("{waves:.0} wavelengths at the highest frequency of the search");
        is_too_long(value, self.wavelength).then(|| millimetres(item, "length", value, why()))
    }

    /// A duct in which sound is in no plane waves.
    fn wide(&self, item: &Item, key: &'static str, value: f64) -> Option<Warning> {
        let why = || "wider than a wavelength at the highest frequency of the search".to_owned();
        self.is_too_wide(value).then(|| millimetres(item, key, value, why()))
    }

    pub(super) fn is_too_wide(&self, value: f64) -> bool {
        is_too_wide(value, self.wavelength)
    }

    /// A length across which the sound of a resonator is not one pressure or one velocity.
    fn not_small(&self, item: &Item, what: &str, length: f64) -> Option<Warning> {
        let resonance = 0.5 * self.wavelength * self.highest / length;
        (resonance < self.highest).then(|| {
            let what = format!(
                "{what} is not small beside the wavelength: half of one fits into {} m at {resonance:.0} Hz, below the {:.0} Hz where the search ends",
                rounded(length),
                self.highest
            );
            Warning::range(item, what, "search below that, or make it of ducts; check the unit")
        })
    }

    fn cold(&self, item: &Item, value: f64) -> Option<Warning> {
        let remedy = || format!("if these are degrees Celsius, write {}", to_digits(value + 273.15, 6));
        let why = || "colder than any gas of a rig".to_owned();
        (self.freezes && value < COLD).then(|| size(item, "temperature", value, "K", why(), remedy()))
    }
}

fn of_screen(item: &Item, screen: &Screen) -> Option<Warning> {
    let Screen { resistance, effective_length, open_area, loss } = *screen;
    if resistance == 0.0 && effective_length == 0.0 && open_area.is_none() && loss.is_none() {
        let what = "no key of it gives a resistance or a mass: it does nothing".to_owned();
        return Some(Warning::range(item, what, "give `resistance`, or in [flow] `open_area` or `loss`"));
    }
    thick(item, "effective_length", effective_length)
}

/// A neck, hole or plate that is too long.
fn thick(item: &Item, key: &'static str, value: f64) -> Option<Warning> {
    (value > THICK).then(|| millimetres(item, key, value, "longer than any".to_owned()))
}

fn millimetres(item: &Item, key: &'static str, value: f64, why: String) -> Warning {
    size(item, key, value, "m", why, format!("if these are mm, write {}", to_digits(1e-3 * value, 6)))
}

pub(super) fn size(
    item: &Item,
    key: &'static str,
    value: f64,
    unit: &'static str,
    why: String,
    remedy: String,
) -> Warning {
    Warning::Size { line: item.line, place: item.place.clone(), key, value, unit, why, remedy }
}

/// Area of the wider of the ducts at a place, m^2, by what the file says of their beginnings and ends.
fn area_at(placed: &[Placed], x: f64) -> Option<f64> {
    let near = |p: &Placed| match &p.element {
        Element::Duct(duct) if (p.x - 1e-9..=p.x + duct.length + 1e-9).contains(&x) => {
            let round = |d: Option<f64>| d.map(|d| 0.25 * PI * d * d);
            let areas = [duct.area, duct.area_end, round(duct.diameter), round(duct.diameter_end)];
            areas.into_iter().flatten().reduce(f64::max)
        }
        _ => None,
    };
    placed.iter().filter_map(near).reduce(f64::max)
}
