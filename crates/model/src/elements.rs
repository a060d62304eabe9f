//! Where the tube is cut into elements, and their gas.

use crate::{BaseState, Scheme};
use rijke_flow::Stretch;
use rijke_rig::{OperatingPoint, Rig};

/// The gas between the mouths and every one of `cuts`, upwards.
///
/// Where it is not uniform it is cut beside the heater and in the mouths as well, and every element is two halves.
pub(crate) fn between(
    cuts: impl Iterator<Item = f64>,
    rig: &Rig,
    point: &OperatingPoint,
    base: &BaseState,
) -> Vec<Stretch> {
    let length = rig.tube.length;
    if is_uniform(base) {
        return base.stretches(&edges(length, cuts));
    }
    let half = 0.5 * rig.heater.length();
    let beside = |x: f64| BESIDE.into_iter().flat_map(move |d| [x - half - d, x + half + d]);
    let more = point.position.into_iter().flat_map(beside).chain([MOUTH, length - MOUTH]);
    halves(base, &edges(length, cuts.chain(more)))
}

/// The cuts of a scheme, none of which a line in uniform gas needs.
pub(crate) fn grid(scheme: Scheme, base: &BaseState, length: f64) -> Vec<f64> {
    let elements = match scheme {
        Scheme::Line { .. } if is_uniform(base) => 1,
        Scheme::Line { elements } | Scheme::Lumped { elements } => elements,
    };
    #[allow(clippy::cast_precision_loss, reason = "element numbers are small")]
    let at = |k: usize| length * k as f64 / elements as f64;
    (1..elements).map(at).collect()
}

/// Middles of the heater's two plates, which act alike; empty without a heater.
///
/// The paper has one jump at X_h. A microphone at X_h, and there is one at every second position, would then read the pressure
/// on one side of the whole jump, where on the rig it sits between the plates.
pub(crate) fn plates(rig: &Rig, point: &OperatingPoint) -> Vec<f64> {
    let half = 0.5 * (rig.heater.plate_thickness + rig.heater.plate_gap);
    let at = point.position.filter(|_| point.heater);
    at.map_or_else(Vec::new, |x| vec![x - half, x + half])
}

/// Distances from the heater's faces at which elements end, m. Between the faces the gas becomes hot, so that the slope of its
/// temperature jumps there; above them it cools fastest.
const BESIDE: [f64; 3] = [0.0, 0.02, 0.06];

/// Length of the elements at the mouths, m: a reflection coefficient refers to the wave impedance of the gas in the mouth.
const MOUTH: f64 = 1e-3;

/// Two halves of every element between neighbouring `edges`, of the element's gas, whose densities have the first moment of the gas
/// along the element as well as its mean.
///
/// With one density an element is of second order in its length: what is left out is the commutator of its ends, that is the first
/// moment of the density, as the compressibility hardly varies at uniform pressure. The density of two halves that differ by D has a
/// moment of D h^2/8, a linear profile whose halves differ by D one of D h^2/6: hence 4/3 of the difference, and fourth order. It
/// stays positive where the halves differ by less than a factor of seven.
fn halves(base: &BaseState, edges: &[f64]) -> Vec<Stretch> {
    let half = |w: &[f64]| {
        let middle = 0.5 * (w[0] + w[1]);
        let [lower, upper] = [base.stretch(w[0], middle), base.stretch(middle, w[1])];
        let mean = 0.5 * (lower.density + upper.density);
        let gas = base.gas.at(base.pressure / (base.gas.constant() * mean), base.pressure);
        let apart = 2.0 / 3.0 * (upper.density - lower.density);
        [(lower, -apart), (upper, apart)].map(|(part, apart)| {
            let density = mean + apart;
            let compliance = 1.0 / (part.density * part.sound_speed.powi(2));
            Stretch { density, sound_speed: (density * compliance).sqrt().recip(), gas, ..part }
        })
    };
    edges.windows(2).flat_map(half).collect()
}

fn is_uniform(base: &BaseState) -> bool {
    base.temperature.iter().all(|t| *t == base.temperature[0])
}

/// Ends of the tube and every cut between, ascending, without doubles.
fn edges(length: f64, cuts: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> =
        [0.0, length].into_iter().chain(cuts.filter(|x| *x > 0.0 && *x < length)).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * length);
    all
}
