//! Holes and necks with a bias flow.

use rijke_network::file::read;
use rijke_network::laws::{fok, steady_share};
use rijke_numerics::{C64, howe};
use std::f64::consts::PI;

const C: f64 = 343.2;
const RHO: f64 = 1.2041;
const DUCT: &str = "type = 'duct'\ndiameter = 0.05\nsound_speed = 343.2\ndensity = 1.2041\n";

fn modes(device: &str) -> Vec<C64> {
    let built = read(&tube(device)).unwrap();
    let region = built.region;
    built.modes(&region).unwrap().modes.iter().map(|m| m.s).collect()
}

/// A tube closed upstream, R = 0.9 e^{3i} downstream, cut at 0.4 m of 1 m by a device.
fn tube(device: &str) -> String {
    format!(
        "[search]\nfrequency_hz = [20, 900]\ngrowth_rate = [-250, 20]\n[upstream]\ntype = 'closed'\n[downstream]\n\
         type = 'constant'\nmodulus = 0.9\nangle = 3.0\n[[element]]\n{DUCT}length = 0.4\n[[element]]\n{device}\n\
         [[element]]\n{DUCT}length = 0.6\n"
    )
}

/// g - R f behind an impedance z in the tube and an admittance y beside it.
fn by_hand(s: C64, z: C64, y: C64) -> C64 {
    let k = s / C;
    let (p1, u1) = ((k * 0.4).cosh(), -(k * 0.4).sinh() / (RHO * C));
    let (p, u) = (p1 - z * u1, u1 - y * p1);
    let (f, g) = (0.5 * (p + RHO * C * u), 0.5 * (p - RHO * C * u));
    g * (k * 0.6).exp() - C64::from_polar(0.9, 3.0) * f * (-k * 0.6).exp()
}

fn all_are_zeros(found: &[C64], f: &dyn Fn(C64) -> C64) {
    assert!(found.len() >= 3, "{found:?}");
    for s in found {
        let off = (f(*s) * 2e-3 / (f(s + 1e-3) - f(s - 1e-3))).norm();
        assert!(off < 1e-6, "{s}: {off}");
    }
}

#[test]
fn exact_plates_and_necks_with_bias_flow_have_howes_conductivity() {
    let (radius, velocity) = (0.004, 6.0);
    let more = |s: C64, r: f64| 0.5 * PI * r * (howe(s * r / velocity)[0].inv() - 1.0);
    let left = fok(radius / 0.025);
    let part = (radius / 0.025_f64).powi(2);
    let steady = ((0.707 * (1.0 - part).sqrt() + 1.0 - part) / 1.707).powi(2);
    let plate = |s: C64| {
        let shed = 0.5 * PI * radius * left * (howe(s * radius * left / steady / velocity)[0].inv() - 1.0);
        let length = 0.002 + 16.0 / (3.0 * PI) * radius * left + shed;
        by_hand(s, s * RHO * length * (0.025 / radius).powi(2) + 3.0, C64::ZERO)
    };
    let orifice = "type = 'orifice'\ndiameter = 0.008\nthickness = 0.002\ndrag = 3";
    all_are_zeros(&modes(&format!("{orifice}\nbias_velocity = 6")), &plate);
    let neck_radius = (1e-4 / PI).sqrt();
    let resonator = |s: C64| {
        let z = s * RHO * (0.02 + more(s, neck_radius)) + 10.0;
        let velocity = s / (s * z + RHO * C * C * 1e-4 / 2e-4);
        by_hand(s, C64::ZERO, velocity * 1e-4 / (PI * 0.025 * 0.025))
    };
    let neck = "type = 'helmholtz'\nvolume = 2e-4\nneck_area = 1e-4\nneck_length = 0.02\nresistance = 10";
    all_are_zeros(&modes(&format!("{neck}\nbias_velocity = 6")), &resonator);
    // Without flow nothing is shed.
    for device in [orifice, neck] {
        let (still, slow) = (modes(device), modes(&format!("{device}\nbias_velocity = 1e-4")));
        assert_eq!(still.len(), slow.len());
        assert!(still.iter().zip(&slow).all(|(a, b)| (a - b).norm() < 5e-3), "{still:?} {slow:?}");
    }
}

#[test]
fn exact_fast_bias_flow_resists_and_moves_no_air() {
    // At small Strouhal numbers the hole resists with 2 rho U, its end corrections in the open are those of a
    // piston less those of a hole.
    let velocity = 60.0;
    let (radius, left) = (0.001, fok(0.04));
    let steady = steady_share([0.04 * 0.04; 2]);
    let quasi_steady = |s: C64| {
        let length = 0.002 + (16.0 / (3.0 * PI) - 0.5 * PI) * radius * left;
        by_hand(s, (s * RHO * length + 2.0 * RHO * velocity * steady) * 625.0, C64::ZERO)
    };
    let text = format!("type = 'orifice'\ndiameter = 0.002\nthickness = 0.002\nbias_velocity = {velocity}");
    let found = modes(&text);
    let still = modes(text.split("bias").next().unwrap());
    assert!(found.len() >= 3);
    for (s, still) in found.iter().zip(&still) {
        let f = quasi_steady;
        let off = (f(*s) * 2e-3 / (f(s + 1e-3) - f(s - 1e-3))).norm();
        assert!(off < 0.01 * (s - still).norm(), "{s}: {off} {still}");
    }
}

#[test]
fn behaviour_walls_leave_jets_their_steady_loss() {
    // Fok's function of a plate of which holes take a tenth leaves half of the attached mass; the jets lose
    // their momentum all the same: by Borda and Carnot behind a jet that contracts by sqrt 2, (1 - 0.1/sqrt
    // 2)^2.
    for share in [0.02, 0.1, 0.3, 0.64] {
        let contracted = (1.0 - share / 2.0_f64.sqrt()).powi(2);
        let found = steady_share([share; 2]);
        assert!(found < contracted && found > (1.0 - share).powi(2), "{share}: {found} {contracted}");
        assert!(found > fok(share.sqrt()), "{share}: {found}");
    }
    assert_eq!((steady_share([0.0; 2]), steady_share([1.0; 2])), (1.0, 0.0));
    // At 2 Hz, 20 m/s and a porosity of 10 % the plate resists with 2 rho U q over its open part.
    let text = format!(
        "[upstream]\ntype = 'closed'\n[downstream]\ntype = 'anechoic'\n[[element]]\n{DUCT}length = 1e-4\n[[element]]\n\
         type = 'orifice'\nname = 'plate'\ndiameter = 0.002\nthickness = 0.0005\nporosity = 0.1\nbias_velocity = 20\n\
         [[element]]\n{DUCT}length = 1e-4\n"
    );
    let built = read(&text).unwrap();
    let port = built.driven(&rijke_network::file::DrivenQuantity::Port("upstream".into()), &[2.0]).unwrap();
    let resistance = port.iter().find(|(name, _)| name.starts_with('Z')).unwrap().1[0].re - 1.0;
    let expected = 2.0 * 20.0 / C * steady_share([0.1; 2]) / 0.1;
    assert!((resistance / expected - 1.0).abs() < 2e-3, "{resistance} {expected}");
}

#[test]
fn behaviour_bias_flow_that_is_none_is_refused() {
    for device in [
        "type = 'orifice'\ndiameter = 0.008\nthickness = 0.002\nbias_velocity = 0",
        "type = 'helmholtz'\nvolume = 2e-4\nneck_area = 1e-4\nneck_length = 0.02\nbias_velocity = 0",
    ] {
        let said = read(&tube(device)).unwrap_err().to_string();
        assert!(said.ends_with("bias_velocity is 0, but must be positive and finite"), "{said}");
        assert!(said.starts_with("line 16: element 2 ("), "{said}");
    }
}
