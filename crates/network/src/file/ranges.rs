//! Where the formulas of a network do not hold: ducts too wide for plane waves or too narrow for a thin layer
//! at the wall, and what a mean flow does to plates, gauzes and mouths.

use super::assembly::Assembly;
use super::item::Item;
use super::layout::Placed;
use super::schema::{Duct, Element, Orifice};
use super::sizes::{Sizes, size};
use super::warning::Warning;
use crate::flow_chain::FlowChain;
use crate::laws::WallLaw;
use rijke_numerics::slips::cut_on;
use std::f64::consts::{PI, TAU};

/// Radius over sqrt(mu/(omega rho)) below which a layer at the wall is not thin: one part in twenty of the
/// loss is missing there.
const THIN_LAYER: f64 = 20.0;
/// What a thin layer leaves out of the loss, times that number.
const LEFT_OUT: f64 = 1.1;
/// Part of its pressure that a gas may lose at a gauze before its mean state changes.
const SMALL_DROP: f64 = 0.02;
/// Periods of the highest frequency beyond which no entropy wave crosses a duct unmixed.
const MIXED: f64 = 50.0;

impl Assembly<'_> {
    /// The frequency from which on a higher mode is cut on in some duct, Hz, and what is doubtful about ducts
    /// at the frequencies of the search.
    pub(super) fn ducts_in_range(&self, sizes: &Sizes, placed: &[Placed]) -> (f64, Vec<Warning>) {
        let width = |k: usize| 2.0 * (self.segments[k].area / PI).sqrt();
        let cut_on = |k: usize| cut_on(width(k), self.segments[k].sound_speed);
        let first = (0..self.segments.len()).min_by(|a, b| cut_on(*a).total_cmp(&cut_on(*b)));
        let plane_below_hz = first.map_or(f64::INFINITY, cut_on);
        let mut all = Vec::new();
        // Of a slip of the unit another warning speaks.
        let slip = |k: &usize| match widest(&placed[self.owners[*k]].element) {
            Some((_, value, "m")) => sizes.is_too_wide(value),
            _ => false,
        };
        if let Some(k) = first.filter(|k| plane_below_hz < sizes.highest && !slip(k)) {
            let Placed { item, element, .. } = &placed[self.owners[k]];
            let (key, value, unit) = widest(element).unwrap_or(("diameter", width(k), "m"));
            let why = format!("so wide that a higher mode is cut on at {plane_below_hz:.0} Hz");
            let remedy =
                format!("search below {plane_below_hz:.0} Hz: above, the sound is not in plane waves alone");
            all.push(size(item, key, value, unit, why, remedy));
        }
        // One warning a duct, of its narrowest piece.
        let layer = |k: usize| {
            let wall = self.walls[k].as_ref().filter(|w| w.law != WallLaw::ZwikkerKosten)?.wall;
            let viscous = (TAU * sizes.highest * wall.density / wall.viscosity).sqrt();
            Some((0.5 * wall.diameter * viscous, k)).filter(|(z, _)| *z < THIN_LAYER)
        };
        for owner in 0..placed.len() {
            let own = (0..self.segments.len()).filter(|k| self.owners[*k] == owner).filter_map(layer);
            if let Some((z, _)) = own.min_by(|a, b| a.0.total_cmp(&b.0)) {
                let what = format!(
                    "the layer at the wall is not thin beside the radius, which is {z:.1} sqrt(mu/(omega rho)) at the {:.0} Hz where the search ends: \
                     `wall` leaves about {:.0} % of the loss out there, and more below",
                    sizes.highest,
                    100.0 * LEFT_OUT / z
                );
                all.push(Warning::range(&placed[owner].item, what, "write wall = \"zwikker-kosten\""));
            }
        }
        (plane_below_hz, all)
    }

    /// What is doubtful about elements in a mean flow.
    pub(super) fn flow_in_range(&self, chain: &FlowChain, sizes: &Sizes, placed: &[Placed]) -> Vec<Warning> {
        let mut all = Vec::new();
        let item = |place: &str| placed.iter().find(|p| p.item.place == place);
        for (place, name) in &self.devices {
            let (Some(Placed { item, element, .. }), Some(before)) =
                (item(name), place.checked_sub(1).map(|k| chain.states()[k]))
            else {
                continue;
            };
            if let Element::Orifice(Orifice { diameter, porosity, drag, bias_velocity, .. }) = element {
                let open =
                    porosity.unwrap_or(0.25 * PI * diameter * diameter / self.segments[place - 1].area);
                let velocity = before.velocity / open;
                if bias_velocity.is_none() && *drag == 0.0 {
                    let what = format!(
                        "the mean flow passes at {velocity:.1} m/s through this plate and loses nothing there: what it sheds would damp the waves"
                    );
                    let remedy = "put a `screen` with the `open_area` of the plate beside it, or give the plate its `drag`, K rho U with the U of the duct";
                    all.push(Warning::range(item, what, remedy));
                }
            }
            let loss = self.screens.iter().find(|(at, _)| at == place).map_or(0.0, |screen| screen.1);
            let drop = 0.5 * loss * before.density * before.velocity.powi(2) / before.pressure;
            if matches!(element, Element::Screen(_)) && drop > SMALL_DROP {
                let what = format!(
                    "the mean flow loses {:.0} % of its pressure here, which the mean state behind it leaves out",
                    100.0 * drop
                );
                all.push(Warning::range(item, what, "take a slower flow or a more open screen"));
            }
        }
        if chain.carries_entropy_waves() {
            let periods = |k: usize| sizes.highest * self.segments[k].length / chain.states()[k].velocity;
            let longest = (0..self.segments.len()).max_by(|a, b| periods(*a).total_cmp(&periods(*b)));
            if let Some(k) = longest.filter(|k| periods(*k) > MIXED) {
                let what = format!(
                    "an entropy wave takes {:.0} periods of the highest frequency to cross it, and is mixed away before; unmixed it makes a mode for each of them",
                    periods(k)
                );
                all.push(Warning::range(
                    &placed[self.owners[k]].item,
                    what,
                    "write entropy_waves = false in [flow]",
                ));
            }
        }
        all
    }
}

/// The widest width that a duct is given, by its key and unit.
fn widest(element: &Element) -> Option<(&'static str, f64, &'static str)> {
    let Element::Duct(duct) = element else { return None };
    let Duct { diameter, diameter_end, area, area_end, .. } = &**duct;
    let lengths = [("diameter", diameter), ("diameter_end", diameter_end)].map(|(key, v)| (key, *v, "m"));
    let areas = [("area", area), ("area_end", area_end)].map(|(key, v)| (key, *v, "m^2"));
    let given = lengths.into_iter().chain(areas).filter_map(|(key, v, unit)| Some((key, v?, unit)));
    let round = |(_, v, unit): &(&str, f64, &str)| if *unit == "m" { 0.25 * PI * v * v } else { *v };
    given.max_by(|a, b| round(a).total_cmp(&round(b)))
}

/// What a mouth of |R| near 1 does where a mean flow of this Mach number is drawn in.
pub(super) fn drawn_in(item: &Item, mach: f64) -> Warning {
    let (kept, fed) = ((1.0 - mach) / (1.0 + mach), 4.0 * mach / (1.0 - mach).powi(2));
    let what = format!(
        "gas is drawn in here, and R = -1 of an open end feeds the modes with {:.2} % of the energy that meets it: gas drawn from rest keeps its total pressure, \
         R = -(1 - M)/(1 + M)",
        100.0 * fed
    );
    let remedy = format!(
        "write `constant` with modulus {kept:.4} and angle 3.14159265, or `unflanged` with calibration = [{kept:.4}, 0]"
    );
    Warning::range(item, what, remedy)
}

/// What a closed end does through which a mean flow of this Mach number enters (upstream, end 0) or leaves.
pub(super) fn blown_through(item: &Item, mach: f64, end: usize) -> Warning {
    let kept = (1.0 - mach) / (1.0 + mach);
    let (enters, does, formula, modulus) = match end {
        0 => ("enters", "feeds the modes with", "(1 - M)/(1 + M)", kept),
        _ => ("leaves", "takes from the modes", "(1 + M)/(1 - M)", kept.recip()),
    };
    let share = if end == 0 { kept.powi(-2) - 1.0 } else { 1.0 - kept.powi(2) };
    let what = format!(
        "gas {enters} here, and R = 1 of a closed end {does} {:.2} % of the energy that meets it: where it {enters} at a constant rate, R = {formula}",
        100.0 * share
    );
    Warning::range(item, what, format!("write `choked`, or `constant` with modulus {modulus:.4} and angle 0"))
}
