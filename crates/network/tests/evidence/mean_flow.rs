//! Chains with mean flow against closed forms.

use crate::common_laws::c;
use crate::eigenvalues::eigenvalues;
use rijke_network::file::{OscilosError, OscilosTexts, read_oscilos};
use rijke_network::flow_chain::{FlowChain, FlowDuct, FlowState, Source};
use rijke_network::laws::Law;
use rijke_network::{Network, NetworkError, Region, Segment, Slot, Workspace};
use rijke_numerics::C64;

fn end(r: f64) -> Law {
    Law::Constant(c(r, 0.0))
}

fn duct(length: f64, area: f64, source: Source) -> FlowDuct {
    FlowDuct { length, area, source }
}

fn inlet(sound_speed: f64, velocity: f64) -> FlowState {
    let pressure = 101_325.0;
    FlowState { pressure, density: 1.4 * pressure / (sound_speed * sound_speed), velocity }
}

const REGION: Region = Region { sigma: [-100.0, 50.0], omega: [200.0, 5600.0] };

#[test]
fn exact_uniform_tube_with_flow() {
    let reference = eigenvalues("uniform_open_open_R095_M001");
    let state = inlet(343.24614995, 3.4324615);
    for pieces in [1, 4] {
        let ducts = vec![duct(1.0 / f64::from(pieces), 1.0, Source::None); pieces as usize];
        let chain = FlowChain::new(1.4, state, ducts, end(-0.95), end(-0.95)).unwrap();
        let found = chain.modes(&REGION).unwrap();
        assert_eq!(found.counted, reference.len());
        for (mode, expected) in found.modes.iter().zip(&reference) {
            assert!((mode.s - expected).norm() < 1e-12 * expected.norm(), "{} against {expected}", mode.s);
        }
    }
    // And to any Mach number: s = c (1 - M^2)/(2L) (ln(R_u R_d) + 2 i pi n).
    let fast =
        FlowChain::new(1.4, inlet(340.0, 85.0), vec![duct(1.0, 1.0, Source::None)], end(-0.9), end(-0.8))
            .unwrap();
    for (k, mode) in fast.modes(&REGION).unwrap().modes.iter().enumerate() {
        let pace = 0.5 * 340.0 * (1.0 - 0.0625);
        let exact = c(pace * (0.72_f64).ln(), 2.0 * std::f64::consts::PI * pace * (k + 1) as f64);
        assert!((mode.s - exact).norm() < 1e-12 * exact.norm(), "{} against {exact}", mode.s);
    }
}

#[test]
fn order_slow_flow_tends_to_no_flow() {
    // Area changes and a flame: as the velocity falls, the chain tends to the one without flow, first order in M.
    let (speed, ratio) = (340.0, 2.5);
    let ducts = vec![
        duct(0.3, 1.0e-3, Source::None),
        duct(0.2, 1.6e-3, Source::None),
        duct(0.4, 1.6e-3, Source::Flame { ratio, gain: 0.4, delay: 2e-3 }),
        duct(0.2, 0.9e-3, Source::None),
    ];
    let gamma_p = 1.4 * 101_325.0;
    let segment = |d: &FlowDuct, c: f64| Segment::new(d.length, d.area, c, gamma_p / (c * c));
    let hot = speed * f64::sqrt(ratio);
    let speeds = [speed, speed, hot, hot];
    let mut still = Network::new(ducts.iter().zip(speeds).map(|(d, c)| segment(d, c)).collect()).unwrap();
    still.set(Slot::Upstream, c(0.95, 0.0)).unwrap();
    still.set(Slot::Downstream, c(-0.95, 0.0)).unwrap();
    let flame = crate::common_laws::given(0, 1, move |at, laws| {
        laws.set(0, &at.s_jet().scale(c(-2e-3, 0.0)).exp().scale(c(-0.4 * (ratio - 1.0), 0.0)));
    });
    still.attach(Slot::Eu(2), 0, 1.0).unwrap();
    let region = Region { sigma: [-200.0, 200.0], omega: [300.0, 3000.0] };
    let exact = still.modes(&flame, &region, &mut Workspace::default()).unwrap();
    let gap = |velocity: f64| -> Vec<f64> {
        let chain =
            FlowChain::new(1.4, inlet(speed, velocity), ducts.clone(), end(0.95), end(-0.95)).unwrap();
        // Without its entropy wave the count is the same; positive growth keeps that wave small.
        let found = chain.modes(&Region { sigma: [-20.0, 200.0], ..region });
        let Ok(found) = found else { return Vec::new() };
        let near = |s: C64| exact.modes.iter().map(|m| (m.s - s).norm()).fold(f64::INFINITY, f64::min);
        found.modes.iter().filter(|m| m.s.re > 0.0).map(|m| near(m.s)).collect()
    };
    let (one, half) = (gap(2.0), gap(1.0));
    assert!(!one.is_empty() && one.len() == half.len(), "{one:?} {half:?}");
    for (a, b) in one.iter().zip(&half) {
        let order = (a / b).log2();
        assert!((order - 1.0).abs() < 0.15, "order {order} from {a} and {b}");
    }
}

#[test]
fn exact_mean_states_conserve() {
    let ducts = vec![
        duct(0.3, 1.0e-3, Source::None),
        duct(0.2, 1.9e-3, Source::None),
        duct(0.4, 1.2e-3, Source::Steady { ratio: 3.0 }),
    ];
    let chain = FlowChain::new(1.4, inlet(340.0, 30.0), ducts.clone(), end(1.0), end(-1.0)).unwrap();
    let mass: Vec<f64> =
        chain.states().iter().zip(&ducts).map(|(s, d)| s.density * s.velocity * d.area).collect();
    assert!(mass.iter().all(|m| (m / mass[0] - 1.0).abs() < 1e-13), "{mass:?}");
    let temperature = |s: &FlowState| s.pressure / s.density;
    let [first, second, third] = [0, 1, 2].map(|i| chain.states()[i]);
    let enthalpy = |s: &FlowState| 3.5 * temperature(s) + 0.5 * s.velocity * s.velocity;
    assert!((enthalpy(&second) / enthalpy(&first) - 1.0).abs() < 1e-13);
    assert!(third.pressure < second.pressure && temperature(&third) > 2.9 * temperature(&second));
    let fast = FlowChain::new(1.4, inlet(340.0, 110.0), ducts, end(1.0), end(-1.0));
    assert!(matches!(fast, Err(NetworkError::TooFast { index: 0, .. })));
}

fn texts() -> OscilosTexts {
    OscilosTexts {
        geometry: "x[m] r[m] SectionIndex TubeIndex\n0 0.01 0 0\n1 0.01 0 0\n2 0.01 0 0\n".to_owned(),
        mean_flow: "P1 T1 choice M1 gamma dT\n101325.0 293.0 1 0.001 1 1\n".to_owned(),
        flame: None,
        inlet: "Type Param_1 Param_2 Param_3\n2 - - -\n".to_owned(),
        outlet: "Type Param_1 Param_2 Param_3\n1 - - -\n".to_owned(),
        scan_range: "f f n g g n\n0 1000 50 -200 200 50\n".to_owned(),
    }
}

#[test]
fn exact_oscilos_inputs() {
    // A closed-open duct of 2 m at M = 0.001: f = c (1 - M^2)/(4 L) (2k + 1).
    let (chain, region) = read_oscilos(&texts()).unwrap();
    let found = chain.modes(&region).unwrap();
    let speed = (1.4 * 8.3145 / 28.96512 * 1000.0 * 293.0_f64).sqrt();
    let first = 0.5 * std::f64::consts::PI * speed * (1.0 - 1e-6) / 2.0;
    assert_eq!(found.counted, 12);
    for (k, mode) in found.modes.iter().enumerate() {
        let exact = c(0.0, first * (2 * k + 1) as f64);
        assert!((mode.s - exact).norm() < 1e-12 * exact.norm(), "{} against {exact}", mode.s);
    }
    // A cone is a staircase; a flame needs its file; what is not read is named.
    let cone =
        OscilosTexts { geometry: "x r s t\n0 0.01 0 1\n1 0.03 0 0\n2 0.03 0 0\n".to_owned(), ..texts() };
    assert_eq!(read_oscilos(&cone).unwrap().0.states().len(), 50);
    let flame =
        OscilosTexts { geometry: "x r s t\n0 0.01 0 0\n1 0.01 11 0\n2 0.01 0 0\n".to_owned(), ..texts() };
    assert_eq!(read_oscilos(&flame).unwrap_err(), OscilosError::NoFlame);
    let lit = OscilosTexts { flame: Some("t a b\n1 0.3 2.1".to_owned()), ..flame };
    let modes = read_oscilos(&lit).map(|(chain, region)| chain.modes(&region).unwrap()).unwrap();
    assert!(modes.counted >= 8);
    let choked = OscilosTexts { outlet: "t a b c\n3 - - -\n".to_owned(), ..texts() };
    let said = read_oscilos(&choked).unwrap_err().to_string();
    assert_eq!(said, "Outlet.txt: Type 3 is not supported; supported are 1, 2, 4, 5, 11 and 12");
    let broken = OscilosTexts { scan_range: "f f n g g n\n0 many 50\n".to_owned(), ..texts() };
    let said = read_oscilos(&broken).unwrap_err().to_string();
    assert_eq!(said, "Scan_range.txt, line 2: 6 numbers are needed, found `0 many 50`");
}
