//! Two gases in one chain: jump conditions by hand, files, what is refused.

use crate::mean_flow::{GAMMA, delayed, end, inlet, modes};
use rijke_network::Region;
use rijke_network::file::read;
use rijke_network::flow_chain::{Action, ActionKind, FlowChain, FlowDuct, Reference};
use rijke_numerics::C64;

/// The determinant of a matrix, by elimination with pivots.
fn determinant(mut a: Vec<Vec<C64>>) -> C64 {
    let n = a.len();
    let mut product = C64::ONE;
    for k in 0..n {
        let pivot = (k..n).max_by(|i, j| a[*i][k].norm().total_cmp(&a[*j][k].norm())).unwrap();
        a.swap(k, pivot);
        product *= if pivot == k { a[k][k] } else { -a[k][k] };
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                let v = a[k][j];
                a[i][j] -= factor * v;
            }
        }
    }
    product
}

/// A flame between a tube of fresh gas and one of burnt gas: mass, momentum and energy of waves f, g on both
/// sides and an entropy wave behind, with Q'/Q = n e^{-s delay} u'/U just before it. Enthalpy counts from
/// that of the fresh gas turned to burnt gas at its pressure and density.
#[test]
fn oracle_a_flame_between_two_gases_by_its_determinant() {
    let (velocity, ratio, hot, n, delay) = (25.0, 5.0, 1.27, 0.8, 2.5e-3);
    let lengths = [0.5, 0.8];
    let fresh = inlet(340.0, velocity);
    let ducts = vec![
        FlowDuct::new(lengths[0], 1e-3),
        FlowDuct {
            actions: vec![Action {
                effect: ActionKind::Flame,
                law: delayed(n, delay),
                reference: Reference::Upstream(0.0),
            }],
            ..FlowDuct::new(lengths[1], 1e-3).heated(ratio).of_gas(hot)
        },
    ];
    let chain = FlowChain::new(GAMMA, fresh, ducts, [end(0.9), end(-0.8)]).unwrap();
    // The mean flow behind: mass and thrust, and p_2/rho_2 = ratio p_1/rho_1.
    let [p1, rho1, u1] = [fresh.pressure, fresh.density, velocity];
    let (mass, thrust) = (rho1 * u1, p1 + rho1 * u1 * u1);
    let mut p2 = p1;
    for _ in 0..200 {
        p2 = thrust - mass * mass * ratio * p1 / rho1 / p2;
    }
    let rho2 = p2 / (ratio * p1 / rho1);
    let u2 = mass / rho2;
    let [c1, c2] = [GAMMA * p1 / rho1, hot * p2 / rho2].map(f64::sqrt);
    let [k1, k2] = [GAMMA / (GAMMA - 1.0), hot / (hot - 1.0)];
    let of_fresh = k2 * p1 / rho1 + 0.5 * u1 * u1;
    let of_burnt = k2 * p2 / rho2 + 0.5 * u2 * u2;
    let heat = mass * (of_burnt - of_fresh);
    let by_hand = |s: C64| {
        // What unit p, u, rho change of mass, momentum and energy flux.
        let rows = |[p, u, rho]: [C64; 3], [mean_p, mean_rho, mean_u, k, total]: [f64; 5]| {
            let mass = rho * mean_u + mean_rho * u;
            let momentum = p + rho * mean_u * mean_u + 2.0 * mean_rho * mean_u * u;
            let enthalpy = k * (p / mean_rho - mean_p / (mean_rho * mean_rho) * rho) + mean_u * u;
            [mass, momentum, mass * total + mean_rho * mean_u * enthalpy]
        };
        let before = [p1, rho1, u1, k1, of_fresh];
        let behind = [p2, rho2, u2, k2, of_burnt];
        let wave =
            |sign: f64, rho: f64, c: f64| [C64::ONE, C64::ONE * (sign / (rho * c)), C64::ONE / (c * c)];
        let columns = [
            rows(wave(1.0, rho1, c1), before),
            rows(wave(-1.0, rho1, c1), before),
            rows(wave(1.0, rho2, c2), behind),
            rows(wave(-1.0, rho2, c2), behind),
            rows([C64::ZERO, C64::ZERO, C64::ONE], behind),
        ];
        let gain = heat * n * (-s * delay).exp() / u1;
        let flame = [gain / (rho1 * c1), -gain / (rho1 * c1)];
        let mut a = vec![vec![C64::ZERO; 5]; 5];
        for row in 0..3 {
            for k in 0..5 {
                a[row][k] = columns[k][row] * if k < 2 { 1.0 } else { -1.0 };
            }
        }
        a[2][0] += flame[0];
        a[2][1] += flame[1];
        // f = 0.9 g at the inlet, from the waves at the flame; g = -0.8 f at the outlet.
        let run = |length: f64, speed: f64| (-s * length / speed).exp();
        a[3][0] = C64::ONE;
        a[3][1] = -0.9 * run(lengths[0], c1 + u1) * run(lengths[0], c1 - u1);
        a[4][3] = C64::ONE;
        a[4][2] = 0.8 * run(lengths[1], c2 + u2) * run(lengths[1], c2 - u2);
        // Rows of one size.
        a[1].iter_mut().for_each(|v| *v *= 1.0 / u1);
        a[2].iter_mut().for_each(|v| *v *= 1.0 / of_fresh);
        determinant(a)
    };
    let found = modes(&chain, &Region { sigma: [-300.0, 300.0], omega: [200.0, 6000.0] });
    assert!(found.len() >= 4, "{found:?}");
    for s in found {
        let slope = (by_hand(s + 0.01) - by_hand(s - 0.01)) / 0.02;
        let off = (by_hand(s) / slope).norm();
        assert!(off < 1e-7 * s.norm(), "{s}: {off}");
    }
}

fn tube(burnt: &str, flow: &str) -> String {
    format!(
        "[search]\nfrequency_hz = [30, 900]\ngrowth_rate = [-200, 300]\n[upstream]\ntype = 'closed'\n\
         [downstream]\ntype = 'constant'\nmodulus = 0.9\nangle = 3.1\n{flow}\
         [[element]]\ntype = 'duct'\nlength = 0.5\ndiameter = 0.1\ntemperature = 300\n\
         [[element]]\ntype = 'flame'\nn = 0.7\ndelay = 2e-3\n\
         [[element]]\ntype = 'duct'\nlength = 0.8\ndiameter = 0.12\ntemperature = 1500\n{burnt}\n"
    )
}

fn of_file(text: &str) -> Vec<C64> {
    let built = read(text).unwrap();
    let region = built.region;
    built.modes(&region).unwrap().modes.iter().map(|m| m.s).collect()
}

#[test]
fn exact_a_duct_of_other_gas_is_one_of_its_sound_speed_and_density() {
    let (gamma, constant) = (1.25, 296.0);
    let c_hot = (gamma * constant * 1500.0_f64).sqrt();
    let rho = 101_325.0 / (constant * 1500.0);
    let by_gas = of_file(&tube(&format!("gamma = {gamma}\ngas_constant = {constant}"), ""));
    // u_2 A_2 = u_1 A_1 (1 + n (R_2 T_2/(R_1 T_1) - 1) e^{-s delay}), p_2 = p_1; by hand.
    let (air, cold) = ((1.4 * 287.05 * 300.0_f64).sqrt(), 101_325.0 / (287.05 * 300.0));
    let by_hand = |s: C64| {
        let (p, u) = ((s * 0.5 / air).cosh(), -(s * 0.5 / air).sinh() / (cold * air));
        let rise = constant * 1500.0 / (287.05 * 300.0) - 1.0;
        let u = u / 1.44 * (1.0 + 0.7 * rise * (-s * 2e-3).exp());
        let (f, g) = (0.5 * (p + rho * c_hot * u), 0.5 * (p - rho * c_hot * u));
        g * (s * 0.8 / c_hot).exp() - C64::from_polar(0.9, 3.1) * f * (-s * 0.8 / c_hot).exp()
    };
    assert!(by_gas.len() >= 4);
    for s in &by_gas {
        let slope = (by_hand(s + 0.01) - by_hand(s - 0.01)) / 0.02;
        assert!((by_hand(*s) / slope).norm() < 1e-8 * s.norm(), "{s}");
    }
    // In a slow flow the same, to first order in M, and the budget closes.
    let gas = format!("gamma = {gamma}\ngas_constant = {constant}");
    let gap = |mach: f64| {
        let flow = of_file(&tube(&gas, &format!("[flow]\nmach = {mach}\nentropy_waves = false\n")));
        assert_eq!(flow.len(), by_gas.len());
        flow.iter().zip(&by_gas).map(|(a, b)| (a - b).norm()).collect::<Vec<_>>()
    };
    for (one, half) in gap(2e-4).into_iter().zip(gap(1e-4)) {
        let order = (one / half).log2();
        assert!((order - 1.0).abs() < 0.05, "order {order} from {one}");
    }
    // What it was to take one gas for both: some per cent.
    let one_gas = of_file(&tube("", ""));
    assert!(one_gas.iter().zip(&by_gas).any(|(a, b)| (a - b).norm() > 0.01 * b.norm()));
}

#[test]
fn behaviour_gas_that_no_gas_is_is_refused() {
    for (keys, said) in [
        ("gamma = 1.0", "line 19: element 3 (duct): gamma is 1, but must be above 1"),
        ("gamma = -2", "line 19: element 3 (duct): gamma is -2, but must be positive and finite"),
        ("gas_constant = 0", "line 19: element 3 (duct): gas_constant is 0, but must be positive and finite"),
    ] {
        assert_eq!(read(&tube(keys, "")).unwrap_err().to_string(), said);
    }
}
