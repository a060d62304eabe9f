//! Devices that the file puts at one place act one behind the other, in the order of the file.
//!
//! All that a chain has at one place answers to the state in front of it. That is what a row of devices does
//! only as long as none of them answers to what one before it changes: resonators take mass and leave the
//! pressure that the others answer to. A screen behind a resonator answers to the velocity that the resonator
//! leaves. It gets a place of its own, a few billionths of the length downstream. Flames that follow each
//! other are parts of one flame, and all answer to the velocity in front of it.

use super::layout::{Placed, SAME};
use super::schema::{Coefficient, Direction, Element, Feedback, Flame};

/// Distance from place to place in a row, over the length of the network: no longer than it takes to be two
/// places.
const APART: f64 = 4.0 * SAME;

/// Whether pressure and velocity.
#[derive(Clone, Copy, Default, PartialEq, Debug)]
struct Of {
    pressure: bool,
    velocity: bool,
}

/// What a device changes, and what in front of it that depends on.
#[derive(Clone, Copy, Default)]
struct Acts {
    answers_to: Of,
    changes: Of,
}

/// Moves apart what stands at one place, where it has to be. `devices` come in the order of their places,
/// then of the file.
pub(super) fn in_a_row(devices: &mut [Placed], length: f64) {
    for row in devices.chunk_by_mut(|a, b| b.x - a.x <= SAME * length) {
        apart(row, length);
    }
}

fn apart(row: &mut [Placed], length: f64) {
    let x = row[0].x;
    // One that hears from behind stands alone or is refused.
    if row.iter().any(|p| matches!(&p.element, Element::Flame(f) if hears_downstream(f))) {
        return;
    }
    let mut changed = Of::default();
    let mut number = 0;
    let mut numbers = Vec::new();
    let mut behind_a_flame = false;
    for device in row.iter() {
        let Acts { answers_to, changes } = acts(&device.element);
        let is_flame = matches!(device.element, Element::Flame(_));
        let in_common = |one: Of, other: Of| one.pressure && other.pressure || one.velocity && other.velocity;
        // What follows a flame stands in the gas behind it.
        let next = if behind_a_flame { !is_flame } else { in_common(answers_to, changed) };
        behind_a_flame = is_flame;
        if next {
            (number, changed) = (number + 1, Of::default());
        }
        changed.pressure |= changes.pressure;
        changed.velocity |= changes.velocity;
        numbers.push(number);
    }
    // A flame stays where the gas gets hot, a plate where the duct gets wide, and what precedes it stands in
    // the duct before. Without either all are in the gas upstream.
    let flame = row.iter().position(|p| matches!(p.element, Element::Flame(_)));
    let plate = || row.iter().position(|p| matches!(p.element, Element::Orifice(_)));
    let mut stays = flame.or_else(plate).map_or(number, |k| numbers[k]);
    if x <= SAME * length {
        stays = 0;
    } else if x >= length - SAME * length {
        stays = number;
    }
    for (device, number) in row.iter_mut().zip(numbers) {
        device.x = x + APART * length * (f64::from(number) - f64::from(stays));
    }
}

fn hears_downstream(flame: &Flame) -> bool {
    flame.reference_side == Direction::Downstream
}

fn acts(element: &Element) -> Acts {
    const PRESSURE: Of = Of { pressure: true, velocity: false };
    const VELOCITY: Of = Of { pressure: false, velocity: true };
    const BOTH: Of = Of { pressure: true, velocity: true };
    match element {
        Element::Duct(_) => Acts::default(),
        Element::Orifice(_) | Element::Screen(_) => Acts { answers_to: VELOCITY, changes: PRESSURE },
        Element::Helmholtz(_) | Element::QuarterWave(_) => Acts { answers_to: PRESSURE, changes: VELOCITY },
        Element::SideHole(_) => Acts { answers_to: BOTH, changes: BOTH },
        // From the state in front of the row it is carried back to a reference upstream.
        Element::Flame(flame) => {
            let answers_to = if flame.reference == 0.0 { VELOCITY } else { Of::default() };
            Acts { answers_to, changes: VELOCITY }
        }
        Element::Feedback(Feedback { mu, mp, eu, ep }) => {
            let [mu, mp, eu, ep] = [mu, mp, eu, ep].map(|k| !matches!(k, Coefficient::Constant([0.0, 0.0])));
            Acts {
                answers_to: Of { pressure: mp || ep, velocity: mu || eu },
                changes: Of { pressure: mu || mp, velocity: eu || ep },
            }
        }
    }
}
