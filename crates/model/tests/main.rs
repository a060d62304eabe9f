//! The assembled model against independent routes, and its derivatives against Taylor remainders.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_candidates::Catalogue;
use rijke_inference::MapOptions;
use rijke_model::{Assembly, Conditions, Noise, Observed, PointModel, Scheme, Training, train};
use rijke_network::{Constant, Network, Newton, Segment, Slot, Workspace, levine_schwinger, wall::Wall};
use rijke_numerics::check::{slopes_from, slopes_near};
use rijke_numerics::{C64, Matrix, Order};
use rijke_rig::{Campaign, Ping, Rig};

mod common;
mod hot;
mod shared;

const ALL: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Standard deviations of growth rate, frequency and pressures in artificial pings.
const SD: [f64; 3] = [0.1, 0.2, 1e-3];

fn catalogue() -> Catalogue {
    let read = |name: &str| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/candidates/");
        Catalogue::read(std::path::Path::new(&format!("{folder}{name}"))).unwrap()
    };
    let cold = read("tube.toml").joined(read("prongs.toml")).joined(read("heater.toml"));
    cold.joined(read("heat-release.toml")).joined(read("beyond.toml"))
}

fn assembly(ids: &[&str]) -> Assembly {
    let all = catalogue();
    Assembly::new(Rig::juniper_yoko_2022(), ids.iter().map(|id| all.get(id).unwrap().clone()).collect())
        .unwrap()
}

fn conditions(rig: &Rig, id: &str) -> Conditions {
    let point = Campaign::juniper_yoko_2022().points.into_iter().find(|p| p.id == id).unwrap();
    Conditions::cold(rig, point, 293.15, 0.0).unwrap()
}

#[test]
fn oracle_empty_tube_is_the_closed_form_of_a_lossy_line() {
    // s solves R(s)^2 = e^{2 gamma(s) L}, with R seen from the lossy impedance; here by its own Newton iteration.
    let assembly = assembly(&["wall.rayleigh", "ends.levine-schwinger"]);
    let rig = &assembly.rig;
    let model = PointModel::new(&assembly, &conditions(rig, "C3-E"), &ALL).unwrap();
    let found = model.respond(&[1.1], Order::Value, &mut Workspace::default()).unwrap().s.value();
    let air = rig.gas.at(293.15, rig.pressure);
    let defect = |s: C64| {
        let root = 1.1 * 4.0 / rig.tube.inner_diameter * (s * air.density * air.viscosity).sqrt();
        let stiffness = air.density * air.sound_speed.powi(2);
        let ep = (air.gamma - 1.0) / (air.density * air.sound_speed).powi(2) * air.prandtl.powf(-2.0 / 3.0);
        let (z, y) = (s * air.density + root, s / stiffness + root * ep);
        let r = levine_schwinger::reflection(s * rig.tube.radius() / (C64::I * air.sound_speed))[0];
        // R belongs to rho c; the line's own waves see the impedance Z_end = rho c (1 + R)/(1 - R) at either end.
        let end = air.density * air.sound_speed * (1.0 + r) / (1.0 - r) / (z.sqrt() / y.sqrt());
        let seen = (end - 1.0) / (end + 1.0);
        seen * seen * (-2.0 * z.sqrt() * y.sqrt() * rig.tube.length).exp() - 1.0
    };
    let h = 1e-4;
    let mut s = found + C64::new(3.0, -5.0);
    for _ in 0..12 {
        let slope = (defect(s + h) - defect(s - h)) / (2.0 * h);
        s -= defect(s) / slope;
    }
    assert!((s - found).norm() < 1e-8 * s.norm(), "{s} {found}");
}

#[test]
fn oracle_prongs_are_a_network_set_by_hand() {
    let assembly = assembly(&["wall.kirchhoff", "ends.free", "prongs.6"]);
    let rig = &assembly.rig;
    let model = PointModel::new(&assembly, &conditions(rig, "C3-35"), &ALL).unwrap();
    let (r, angle, alpha, beta) = (0.996, 3.06, 0.7, 1.2);
    let found =
        model.respond(&[1.0, r, angle, alpha, beta], Order::Value, &mut Workspace::default()).unwrap();

    let air = rig.gas.at(293.15, rig.pressure);
    let s = found.s.value();
    let loss = Wall {
        density: air.density,
        sound_speed: air.sound_speed,
        viscosity: air.viscosity,
        prandtl: air.prandtl,
        gamma: air.gamma,
        diameter: rig.tube.inner_diameter,
    }
    .kirchhoff(s);
    let whole = Segment::new(rig.tube.length, rig.tube.area(), air.sound_speed, air.density);
    let mut cuts = rig.microphones.positions.clone();
    cuts.push(0.35);
    let mut network = Network::cut_tube(whole, &cuts).unwrap();
    let tip = network.place_at(0.35).unwrap();
    for i in 0..network.segments().len() {
        let more = if i < tip { 1.0 + alpha * 14.0 / 47.4 } else { 1.0 };
        network.set(Slot::Viscous(i), loss.viscous[0] * more).unwrap();
        network.set(Slot::Thermal(i), loss.thermal[0] * more).unwrap();
    }
    network.set(Slot::Eu(tip), C64::new(beta * 50.0 / (47.4 * 47.4), 0.0)).unwrap();
    for end in [Slot::Upstream, Slot::Downstream] {
        network.set(end, C64::from_polar(r, angle)).unwrap();
    }
    // With the losses frozen at the eigenvalue, the eigenvalue must come back.
    let root = network.solve(&Constant, s, &Newton::default(), &mut Workspace::default()).unwrap();
    assert!((root.s - s).norm() < 1e-9 * s.norm(), "{} {s}", root.s);
    assert!((found.pressures[5].value() - 1.0).norm() < 1e-15);
}

#[test]
fn order_parameter_derivatives_have_falling_taylor_remainders() {
    for (scheme, id) in [(Scheme::Line { elements: 40 }, "C3-35"), (Scheme::Lumped { elements: 40 }, "C3-60")]
    {
        let assembly = assembly(&["wall.rayleigh", "ends.calibrated", "prongs.7"]).with_scheme(scheme);
        let model = PointModel::new(&assembly, &conditions(&assembly.rig, id), &ALL).unwrap();
        let at = [1.05, 0.999, 0.004, 0.8, 1.3, 1.1];
        let direction = [0.3, -0.006, 0.01, 0.5, -0.7, 0.4];
        let work = &mut Workspace::default();
        let centre = model.respond(&at, Order::Second, work).unwrap();
        for which in 0..9 {
            let pick = |r: &rijke_network::Response| {
                if which == 8 { r.s.clone() } else { r.pressures[which].clone() }
            };
            if which == 5 {
                continue; // the reference microphone, 1 by definition
            }
            let jet = pick(&centre);
            let (mut first, mut second) = (C64::ZERO, C64::ZERO);
            for i in 0..6 {
                first += jet.gradient()[i] * direction[i];
                for j in 0..6 {
                    second += 0.5 * jet.hessian(i, j) * direction[i] * direction[j];
                }
            }
            let change = |h: f64| {
                let moved: Vec<f64> = at.iter().zip(direction).map(|(a, d)| a + h * d).collect();
                let r = model.respond(&moved, Order::Value, &mut Workspace::default()).unwrap();
                pick(&r).value() - jet.value()
            };
            slopes_near(&slopes_from(0.2, |h| (change(h) - first * h).norm()), 2.0, 0.05);
            slopes_near(&slopes_from(0.5, |h| (change(h) - first * h - second * h * h).norm()), 3.0, 0.15);
        }
    }
}

#[test]
fn exact_training_recovers_the_parameters_that_made_the_data() {
    let assembly = assembly(&["wall.rayleigh", "ends.calibrated", "prongs.6"]);
    let truth = [1.03, 0.998, 0.006, 0.9, 1.05];
    let observed: Vec<Observed> = ["C3-E", "C3-20", "C3-35", "C3-50", "C3-70", "C3-90"]
        .iter()
        .map(|id| {
            let conditions = conditions(&assembly.rig, id);
            let model = PointModel::new(&assembly, &conditions, &ALL).unwrap();
            let r = model.respond(&truth, Order::Value, &mut Workspace::default()).unwrap();
            let pressures = r.pressures.iter().map(|p| p.value()).collect();
            let variance: Vec<f64> = (0..16).map(|k| [1e-4, 1e-2, 1e-8][k.min(2)]).collect();
            let ping =
                Ping { s: r.s.value(), pressures, reference: 5, covariance: Matrix::diagonal(&variance) };
            Observed { conditions, ping }
        })
        .collect();
    let training = Training {
        microphones: ALL.to_vec(),
        noise: Noise::MEASURED,
        known: Vec::new(),
        varying: Vec::new(),
        channels: None,
        search: MapOptions::bfgs(),
        base_errors: false,
        checks: None,
    };
    let trained = train(&assembly, &observed, &training).unwrap();
    for (k, (found, truth)) in trained.values.iter().zip(truth).enumerate() {
        // Only the prior pulls the optimum from the truth, by far less than one posterior standard deviation.
        assert!((found - truth).abs() < 0.05 * trained.sd()[k], "{k}: {found} {truth} {}", trained.sd()[k]);
    }
}
