//! Devices at one place of a file against products of their own matrices, in the order of the file.

use crate::common_laws::c;
use rijke_network::NetworkError;
use rijke_network::file::read;
use rijke_numerics::C64;
use std::f64::consts::PI;

const RESONATOR: &str =
    "[[element]]\ntype = 'helmholtz'\nvolume = 1e-3\nneck_area = 1e-4\nneck_length = 0.02\nresistance = 5\n";
const SCREEN: &str = "[[element]]\ntype = 'screen'\nresistance = 300\n";
const FLAME: &str = "[[element]]\ntype = 'flame'\ngain = 0.4\ndelay = 2e-3\n";

/// A tube closed in front, with `row` between a duct of 300 K and a wider one of 600 K, open behind.
fn tube(row: &[&str], flow: &str) -> String {
    let duct = |diameter: f64, temperature: f64| {
        format!(
            "[[element]]\ntype = 'duct'\nlength = 0.5\ndiameter = {diameter}\ntemperature = {temperature}\n"
        )
    };
    format!(
        "[search]\ngrowth_rate = [-300, 300]\nfrequency_hz = [20, 600]\n[upstream]\ntype = 'closed'\n[downstream]\n\
         type = 'open'\n{}{}{}{flow}",
        duct(0.05, 300.0),
        row.concat(),
        duct(0.06, 600.0)
    )
}

fn modes(text: &str) -> Vec<C64> {
    let built = read(text).unwrap();
    built.modes(&built.region).unwrap().modes.iter().map(|m| m.s).collect()
}

/// Pressure at the open end over that of the two waves behind the row, device after device.
fn end_pressure(row: &[&str], s: C64) -> f64 {
    let gas = |t: f64| ((1.4 * 287.05 * t).sqrt(), 101_325.0 / (287.05 * t));
    let ((c1, rho1), (c2, rho2)) = (gas(300.0), gas(600.0));
    let (a1, a2) = (PI * 0.05_f64.powi(2) / 4.0, PI * 0.06_f64.powi(2) / 4.0);
    // Volume velocity in place of velocity: it is what a step of area keeps. A device before the step, or at
    // it, is in the cold gas.
    let (mut p, mut q) = ((s * 0.5 / c1).cosh(), -a1 * (s * 0.5 / c1).sinh() / (rho1 * c1));
    let flame = row.iter().position(|device| *device == FLAME);
    for (k, device) in row.iter().enumerate() {
        let hot = flame.is_some_and(|flame| k > flame);
        let (rho, sound, area) = if hot { (rho2, c2, a2) } else { (rho1, c1, a1) };
        match *device {
            RESONATOR => {
                q -= p * s / (s * s * (rho * 0.02 / 1e-4) + s * (5.0 / 1e-4) + rho * sound * sound / 1e-3)
            }
            SCREEN => p -= 300.0 * q / area,
            // k_eu counts per area of the duct downstream and is of the velocity in front.
            _ => q += 0.4 * (-s * 2e-3).exp() * q / a1 * a2,
        }
    }
    let (u, k) = (q / a2, s / c2);
    let (cosh, sinh) = ((k * 0.5).cosh(), (k * 0.5).sinh());
    (p * cosh - u * rho2 * c2 * sinh).norm() / (p.norm() + (u * rho2 * c2).norm())
}

#[test]
fn oracle_devices_at_one_place_act_in_the_order_of_the_file() {
    let rows: [&[&str]; 6] = [
        &[RESONATOR, SCREEN],
        &[SCREEN, RESONATOR],
        &[RESONATOR, FLAME],
        &[FLAME, RESONATOR],
        &[SCREEN, FLAME, RESONATOR],
        &[RESONATOR, SCREEN, FLAME],
    ];
    let mut all: Vec<Vec<C64>> = Vec::new();
    for row in rows {
        let found = modes(&tube(row, ""));
        assert!(!found.is_empty());
        for s in &found {
            assert!(end_pressure(row, *s) < 2e-7, "{row:?}: {s} leaves {}", end_pressure(row, *s));
        }
        // A flow so slow changes nothing else.
        let slow = modes(&tube(row, "[flow]\nmach = 1e-7\nentropy_waves = false\n"));
        assert_eq!(slow.len(), found.len());
        for (a, b) in slow.iter().zip(&found) {
            assert!((a - b).norm() < 1e-4 * b.norm(), "{row:?}: {a} and {b}");
        }
        all.push(found);
    }
    assert!(all[0].len() != all[1].len() || (all[0][0] - all[1][0]).norm() > 30.0, "{:?}", &all[..2]);
    // Flames that follow each other are parts of one.
    let half = FLAME.replace("0.4", "0.2");
    let [two, one] = [&[&*half, &*half][..], &[FLAME]].map(|row| modes(&tube(row, "")));
    assert_eq!(two.len(), one.len());
    assert!(two.iter().zip(&one).all(|(a, b)| (a - b).norm() < 1e-9 * b.norm()), "{two:?} {one:?}");
    // What answers to nothing that the other changes is at one place, to the last digit.
    let two = [RESONATOR, RESONATOR];
    let network = read(&tube(&two, "")).unwrap().network;
    assert_eq!(network.segments().len(), 2);
    assert!(end_pressure(&[SCREEN], c(-10.0, 900.0)) > 1e-3, "no root, no zero");
}

#[test]
fn message_a_side_branch_of_a_million_modes_is_refused_before_the_search() {
    let branch = "[[element]]\ntype = 'quarter-wave'\nlength = 1e9\narea = 1e-4\n";
    for flow in ["", "[flow]\nmach = 0.01\nentropy_waves = false\n"] {
        let built = read(&tube(&[branch], flow)).unwrap();
        let found = built.modes(&built.region).err();
        let Some(NetworkError::TooLarge { modes, .. }) = found else { panic!("{found:?}") };
        assert!(modes > 1e6, "{modes}");
    }
}
