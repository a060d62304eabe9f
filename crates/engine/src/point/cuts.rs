//! Where the ducts are cut into segments, and the gas of each.

use super::spread::flames;
use crate::assembly::Assembly;
use crate::conditions::Conditions;
use rijke_network::Segment;
use rijke_rig::GasState;
use rijke_study::{GasStretch, PointState};

/// A segment of the network, where it lies, and its gas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) segment: Segment,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) gas: GasState,
}

/// Number of equal elements along the rig where the gas is not the same everywhere.
const ELEMENTS: usize = 10;

/// Distances from a zone of fast change at which elements end, m: the slope of the temperature jumps at its
/// borders, and downstream of it the gas cools fastest.
const BESIDE: [f64; 3] = [0.0, 0.02, 0.06];

/// Length of the elements at the ends, m: a reflection coefficient refers to the wave impedance of the gas at
/// the end.
const AT_END: f64 = 1e-3;

/// Every place where the chain is cut: instruments, devices, borders of ducts and of inserts, and, where the
/// gas varies, the elements.
pub(super) fn all(
    assembly: &Assembly,
    conditions: &Conditions,
    instruments: impl Iterator<Item = f64>,
) -> Vec<f64> {
    let Conditions { layout, base, .. } = conditions;
    let effects = || assembly.candidates().iter().flat_map(|c| &c.effects);
    let devices = effects().flat_map(|e| layout.places(&e.place)).map(|(x, _)| x);
    let spread = effects().flat_map(|e| flames(e, layout)).flat_map(|flame| flame.cuts().collect::<Vec<_>>());
    let inserts = effects().flat_map(|e| layout.stretches(&e.place)).flatten();
    let mut cuts: Vec<f64> = instruments.chain(devices).chain(spread).chain(inserts).collect();
    for duct in &layout.ducts {
        let [from, to] = duct.span;
        cuts.extend((0..=duct.pieces).map(|k| from + (to - from) * k as f64 / duct.pieces as f64));
    }
    if !base.is_uniform() {
        let length = layout.length;
        cuts.extend((1..ELEMENTS).map(|k| length * k as f64 / ELEMENTS as f64));
        cuts.extend([AT_END, length - AT_END]);
        for [from, to] in &base.kinks {
            cuts.extend(BESIDE.iter().flat_map(|d| [from - d, to + d]));
        }
        // A step of the temperature is a border.
        cuts.extend(base.places.windows(2).filter(|w| w[0] == w[1]).map(|w| w[0]));
    }
    edges(layout.length, cuts)
}

/// Ends and every cut between, ascending, without doubles.
fn edges(length: f64, cuts: Vec<f64>) -> Vec<f64> {
    let mut all: Vec<f64> =
        [0.0, length].into_iter().chain(cuts.into_iter().filter(|x| *x > 0.0 && *x < length)).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * length);
    // The last cut may have been kept in the place of the end.
    if let Some(last) = all.last_mut() {
        *last = length;
    }
    all
}

/// The segments between neighbouring `edges`, of which there are two for every element where the gas varies.
pub(super) fn segments(conditions: &Conditions, edges: &[f64]) -> Vec<Piece> {
    let Conditions { layout, base, .. } = conditions;
    let stretches: Vec<GasStretch> = if base.is_uniform() {
        edges.windows(2).map(|w| base.stretch(w[0], w[1])).collect()
    } else {
        edges.windows(2).flat_map(|w| halves(base, w[0], w[1])).collect()
    };
    let piece = |s: &GasStretch| {
        let area = layout.areas(0.5 * (s.from + s.to))[0];
        let segment = Segment::new(s.to - s.from, area, s.sound_speed, s.density);
        Piece { segment, from: s.from, to: s.to, gas: s.gas }
    };
    stretches.iter().map(piece).collect()
}

/// Two halves of an element, of the element's gas, which have the first moments of the gas along it as well
/// as its means ([`Segment::with_first_moment`]; the area cancels).
fn halves(base: &PointState, from: f64, to: f64) -> [GasStretch; 2] {
    let middle = 0.5 * (from + to);
    let parts = [base.stretch(from, middle), base.stretch(middle, to)];
    let mean = 0.5 * (parts[0].density + parts[1].density);
    let gas = base.gas_beside(middle, 0);
    let gas = gas.at(base.pressure / (gas.constant() * mean), base.pressure);
    let halves = parts.map(|part| Segment::new(part.to - part.from, 1.0, part.sound_speed, part.density));
    let halves = Segment::with_first_moment(halves);
    std::array::from_fn(|k| {
        let Segment { density, sound_speed, .. } = halves[k];
        GasStretch { density, sound_speed, gas, ..parts[k] }
    })
}

#[cfg(test)]
mod tests {
    use super::super::given;
    use super::*;

    #[test]
    fn exact_a_cone_behind_another_duct_is_cut_where_it_lies() {
        let ends = "name = 'horn'\n[upstream]\ntype = 'closed'\n[downstream]\ntype = 'open'\n";
        let duct = "[[element]]\ntype = 'duct'\nlength = 0.4\ndiameter = 0.04\n";
        let cone =
            "[[element]]\ntype = 'duct'\nlength = 0.6\ndiameter = 0.04\ndiameter_end = 0.08\npieces = 3\n";
        let (assembly, conditions) = given::at_one_point(&[ends, duct, cone].concat());
        let edges = all(&assembly, &conditions, std::iter::once(0.1));
        let expected = [0.0, 0.1, 0.4, 0.6, 0.8, 1.0];
        assert_eq!(edges.len(), expected.len(), "{edges:?}");
        assert!(edges.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{edges:?}");
        // Each piece has the area of its middle.
        let pieces = segments(&conditions, &edges);
        let areas = pieces.iter().map(|p| p.segment.area / conditions.layout.areas(0.1)[0]);
        for (found, width) in areas.zip([1.0, 1.0, 7.0 / 6.0, 1.5, 11.0 / 6.0_f64]) {
            assert!((found - width.powi(2)).abs() < 1e-9, "{found} {width}");
        }
    }
}
