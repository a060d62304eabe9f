//! Beside the resonance of a branch the mode that is found is the nearest one.

use super::{CLOSED, assembly, conditions, study};
use rijke_engine::PointModel;
use rijke_network::Workspace;
use rijke_numerics::{C64, Order};
use std::f64::consts::TAU;

/// A tube with a Helmholtz resonator, open at its end.
const RIG: &str = "name = 'tube'\n[search]\nfrequency_hz = [40, 700]\ngrowth_rate = [-300, 100]\n[upstream]\nTYPE\n\
    [downstream]\ntype = 'constant'\nmodulus = 0.97\nangle = 3.0\n[[element]]\ntype = 'duct'\nlength = 0.5\ndiameter = 0.08\n\
    [[element]]\ntype = 'helmholtz'\nneck_length = 0.05\nneck_area = 3e-4\nvolume = 2.5e-4\n\
    [[element]]\ntype = 'duct'\nlength = 0.9\ndiameter = 0.08\n[microphones]\nat = [0.1]\n";

#[test]
fn exact_beside_a_resonator_the_nearest_mode_is_followed() {
    let study = study("nearest", &RIG.replace("TYPE", CLOSED)).unwrap();
    let (assembly, conditions) = (assembly(&study), conditions(&study));
    let model = || PointModel::new(&assembly, &conditions, &[]).unwrap();
    let (_, spectrum) = model().spectrum(&[], [None, None]).unwrap();
    let modes: Vec<C64> = spectrum.modes.modes.iter().map(|m| m.s).collect();
    let spacing = TAU * 343.0 / 2.8;
    let (mut tried, mut wrong) = (0, Vec::new());
    for (i, j) in (0..40).flat_map(|i| (0..8).map(move |j| (i, j))) {
        let guess = C64::new(-5.0 - 15.0 * f64::from(j), TAU * (120.0 + 5.0 * f64::from(i)));
        let distance = |s: &C64| (s - guess).norm();
        let mut near: Vec<C64> = modes.clone();
        near.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        // Where two are as near as one another either is right.
        if distance(&near[0]) > 0.35 * spacing || distance(&near[1]) < 1.2 * distance(&near[0]) {
            continue;
        }
        tried += 1;
        let found = model().starting_from(guess).respond(&[], Order::Value, &mut Workspace::default());
        let found = found.unwrap().s.value();
        if (found - near[0]).norm() > 1e-6 * found.norm() {
            wrong.push(format!("from {guess:.1}: {found:.1} for {:.1}", near[0]));
        }
    }
    assert!(tried > 150, "{tried}");
    assert!(wrong.is_empty(), "{} of {tried}: {}", wrong.len(), wrong.join("\n"));
}
