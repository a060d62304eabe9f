//! Elements and ends that are at odds with themselves or with each other.

use super::item::Item;
use super::layout::{Placed, SAME};
use super::schema::{Element, Hole, Screen};
use super::warning::Warning;
use rijke_numerics::slips::FLAME_GAINS;
use rijke_numerics::words::{rounded, to_digits};

/// Walls of a mouth thicker than so many of its radii are in another unit: beyond ten, thickness changes
/// nothing any more.
const THICK_WALL: f64 = 50.0;
/// A calibration that turns R by more than this, rad, is no correction of it.
const TURNED: f64 = 1.0;

/// A warning of every resonator that equals one before it at its place. Their admittances have one pole, of
/// which only one state answers to the pressure in the duct.
pub(super) fn twins(devices: &[Placed], length: f64) -> Vec<Warning> {
    let rings = |p: &Placed| matches!(p.element, Element::Helmholtz(_) | Element::QuarterWave(_));
    let twin = |(k, p): (usize, &Placed)| {
        let same = |o: &&Placed| rings(o) && (o.x - p.x).abs() <= SAME * length && o.element == p.element;
        let other = devices[..k].iter().rev().find(same)?;
        let (line, place) = (p.item.line, p.item.place.clone());
        Some(Warning::Twin { line, place, other: other.item.place.clone() })
    };
    devices.iter().enumerate().filter(|(_, p)| rings(p)).filter_map(twin).collect()
}

/// Keys of gauzes that only a mean flow gives an effect, in a file without one.
pub(super) fn at_rest(placed: &[Placed]) -> impl Iterator<Item = Warning> {
    placed.iter().filter_map(|Placed { item, element, .. }| {
        let (key, why) = match element {
            Element::Screen(Screen { loss: Some(_), .. }) => ("loss", "it is the loss of a mean flow"),
            Element::Screen(Screen { open_area: Some(_), .. }) => {
                ("open_area", "it gives the loss of a mean flow")
            }
            _ => return None,
        };
        Some(Warning::idle(item, key, why, "the file has no [flow]: give it, or `resistance`"))
    })
}

/// A warning of every side hole that overlaps one before it, on whatever side of the tube: each hears the
/// other's near field, which no formula of one hole has.
pub(super) fn overlapping(devices: &[Placed]) -> Vec<Warning> {
    let holes = || {
        devices.iter().filter_map(|p| match p.element {
            Element::SideHole(Hole { diameter, .. }) => Some((p, diameter)),
            _ => None,
        })
    };
    let near = |(k, (p, wide)): (usize, (&Placed, f64))| {
        let touches = |o: &(&Placed, f64)| (p.x - o.0.x).abs() < 0.5 * (wide + o.1);
        let (other, _) = holes().take(k).find(touches)?;
        let what = format!(
            "it is {} m from {}, less than the sum of their radii: the formula is that of one hole with the tube to itself",
            rounded((p.x - other.x).abs()),
            other.item.place
        );
        let remedy =
            "check `at` and `diameter`; holes at one place may be written as one of the same open area";
        Some(Warning::range(&p.item, what, remedy))
    };
    holes().enumerate().filter_map(near).collect()
}

/// A flame of which `n` is a part of the mean heat, in proportion to `mean`, between gas of two temperatures
/// (K), if that heat is none or is taken out.
pub(super) fn heated(item: &Item, mean: f64, [before, behind]: [f64; 2]) -> Option<Warning> {
    let none = mean.abs() < 1e-12;
    if none {
        let why = "the heat that fluctuates is a part of the heat that warms the gas, and the gas is no warmer behind the flame";
        let remedy = "give the ducts their temperatures, or write `gain`";
        return Some(Warning::idle(item, "n", why, remedy));
    }
    (mean < 0.0 && behind < before).then(|| {
        let what = format!(
            "the gas is colder behind the flame, {} K after {} K: the heat that fluctuates is `n` of a heat that is taken out, and acts with the opposite sign",
            to_digits(behind, 6),
            to_digits(before, 6)
        );
        Warning::range(item, what, "check whether two ducts, or their temperatures, were exchanged; the flow is from upstream to downstream")
    })
}

/// Gain of a flame above which it is most often in per cent where `gain` includes the ratio of temperatures.
const WITH_RATIO: f64 = 100.0;

/// The table of a flame with a gain that no flame has; `n` if that is its factor.
pub(super) fn large(item: &Item, n: Option<f64>, rows: &[[f64; 3]]) -> Option<Warning> {
    let largest = n.unwrap_or(1.0) * rows.iter().fold(0.0, |most: f64, row| most.max(row[1].abs()));
    (largest > if n.is_some() { FLAME_GAINS[1] } else { WITH_RATIO }).then(|| {
        let what = format!("its largest gain is {}, and a flame answers with about 1", rounded(largest));
        Warning::range(item, what, "if the table is in per cent, divide its gains by 100")
    })
}

/// A response whose modulus grows without end with the frequency, as that of no flame and no passive end
/// does.
pub(super) fn growing(
    item: &Item,
    numerator: &[f64],
    denominator: &[f64],
    cutoff_hz: Option<f64>,
) -> Option<Warning> {
    let degree = |list: &[f64]| list.iter().rposition(|k| *k != 0.0).unwrap_or(0);
    let (top, bottom) = (degree(numerator), degree(denominator) + usize::from(cutoff_hz.is_some()));
    (top > bottom).then(|| {
        let what = format!(
            "its numerator is of degree {top} in s and its denominator of degree {bottom}: it grows without end with the frequency"
        );
        let remedy = "both are lists of ascending powers of s, constant first; give the denominator its higher powers";
        Warning::range(item, what, remedy)
    })
}

/// An impedance of no keys.
pub(super) fn matched(item: &Item) -> Warning {
    let what = "no key of it says an impedance: it is that of the gas, and reflects nothing".to_owned();
    Warning::range(item, what, "give `numerator` or `table`, or write `anechoic`")
}

/// A wall (m) too thick for a mouth of this radius (m).
pub(super) fn thick_wall(item: &Item, thickness: f64, radius: f64) -> Option<Warning> {
    (thickness > THICK_WALL * radius).then(|| {
        let what = format!(
            "wall_thickness is {} m, {} radii of the mouth",
            rounded(thickness),
            rounded(thickness / radius)
        );
        Warning::range(
            item,
            what,
            format!("if these are mm, write {}; a wide flange is `flanged`", 1e-3 * thickness),
        )
    })
}

/// A calibration that is no small correction.
pub(super) fn turned(item: &Item, angle: f64) -> Option<Warning> {
    (angle.abs() > TURNED).then(|| {
        let what = format!(
            "calibration multiplies R by [modulus, angle], and turns it by {} rad, which is no correction",
            rounded(angle)
        );
        let remedy =
            format!("if these are degrees, write {}; R itself is `constant`", rounded(angle.to_radians()));
        Warning::range(item, what, remedy)
    })
}
