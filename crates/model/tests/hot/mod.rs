//! Hot gas: mean flow, errors of the base state, microphones near the heater, models on disk.

use super::{ALL, SD, catalogue};
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_inference::{Evidence, MapOptions, NoiseMode};
use rijke_model::{
    Assembly, BaseErrors, BaseState, Conditions, Misfit, Noise, Observed, PointModel, SavedModel, Training,
    Workspace, train,
};
use rijke_numerics::{C64, Matrix, Order, Streams};
use rijke_rig::{Campaign, DataKind, Ping, Rig};

fn assembly(ids: &[&str]) -> Assembly {
    let all = catalogue();
    Assembly::new(Rig::juniper_yoko_2022(), ids.iter().map(|id| all.get(id).unwrap().clone()).collect())
        .unwrap()
}

/// A hot point whose gas warms from 294 to 420 K over 2 cm at the heater and cools above it; two causes of error, the first
/// shared by all points of one position.
fn conditions(id: &str) -> Conditions {
    let point = Campaign::juniper_yoko_2022().points.into_iter().find(|p| p.id == id).unwrap();
    let rig = Rig::juniper_yoko_2022();
    let x = point.position.unwrap();
    let mut base = BaseState::uniform(&rig.gas, rig.pressure, rig.tube.length, 294.0, 0.1).unwrap();
    base.places = vec![0.0, x - 0.01, x + 0.01, 1.0];
    base.temperature = vec![294.0, 294.0, 420.0, 360.0];
    (base.mass_flux, base.heater_velocity) = (0.5, 0.42);
    base.errors[0].temperature = vec![0.1; 4];
    base.errors[0].cause = "ambient".into();
    let mut second = base.errors[0].clone();
    second.cause = format!("wall at {x}");
    second.temperature = vec![0.0, 0.0, 4.0, 2.0];
    second.heater_velocity = 0.02;
    base.errors.push(second);
    Conditions { point, base: base.checked().unwrap(), ambient: 294.0 }
}

/// The ping that a model makes at `conditions`, with covariance `SD`.
fn observed(assembly: &Assembly, conditions: Conditions, values: &[f64]) -> Observed {
    let model = PointModel::new(assembly, &conditions, &ALL).unwrap();
    let r = model.respond(values, Order::Value, &mut Workspace::default()).unwrap();
    let pressures = r.pressures.iter().map(|p| p.value()).collect();
    let variance: Vec<f64> = (0..16).map(|k| SD[k.min(2)].powi(2)).collect();
    let ping = Ping { s: r.s.value(), pressures, reference: 5, covariance: Matrix::diagonal(&variance) };
    Observed { conditions, ping }
}

fn training(base_errors: bool) -> Training {
    Training {
        microphones: ALL.to_vec(),
        noise: Noise::MEASURED,
        known: Vec::new(),
        varying: Vec::new(),
        channels: None,
        search: MapOptions::default(),
        base_errors,
        checks: None,
    }
}

/// To first order in the Mach number p and u with flow are e^{s G x/(gamma p_0)} times those without: the eigenvalue stays,
/// relative pressures turn by that factor.
#[test]
fn oracle_waves_carried_along_turn_the_mode_shape_and_leave_the_eigenvalue() {
    let ids = ["wall.rayleigh", "ends.levine-schwinger", "heat-release.cylinder"];
    let values = [1.0, 0.5, 2.0, 1.75];
    let conditions = conditions("H180-25");
    let respond = |ids: &[&str], values: &[f64]| {
        let assembly = assembly(ids);
        let model = PointModel::new(&assembly, &conditions, &ALL).unwrap();
        let r = model.respond(values, Order::Value, &mut Workspace::default()).unwrap();
        (r.s.value(), r.pressures.iter().map(|p| p.value()).collect::<Vec<C64>>())
    };
    let (s, still) = respond(&[&ids[..], &["mean-flow.momentum"]].concat(), &values);
    let (moved, carried) = respond(&[&ids[..], &["mean-flow.convection"]].concat(), &values);
    // The second order in M = 1.3e-3 is 2e-6; the tube's losses and the heater's jump see the factor to first order in it.
    assert!((moved - s).norm() < 0.02, "{s} {moved}");
    let rig = Rig::juniper_yoko_2022();
    let gas = conditions.base.at(0.5);
    let per_metre = s * conditions.base.mass_flux / (gas.gamma * rig.pressure);
    for m in 0..8 {
        let turned = (per_metre * (rig.microphones.positions[m] - 0.75)).exp();
        let (exact, without) = ((carried[m] / still[m] - turned).norm(), (turned - 1.0).norm());
        assert!(exact < 0.05 * without + 2e-5, "{m}: {exact} of {without}");
    }
}

/// Ten elements against three hundred and twenty, where the gas varies most: a tenth of what the microphones hear.
#[test]
fn order_ten_elements_are_enough_and_their_error_falls_faster_than_the_square() {
    use rijke_model::Scheme;
    let plain = assembly(&["wall.rayleigh", "ends.levine-schwinger"]);
    for id in ["H180-25", "H180-60"] {
        let conditions = conditions(id);
        let at = |elements: usize| {
            let assembly = plain.clone().with_scheme(Scheme::Line { elements });
            let model = PointModel::new(&assembly, &conditions, &ALL).unwrap();
            let r = model.respond(&[1.0], Order::Value, &mut Workspace::default()).unwrap();
            let pressures: Vec<C64> = r.pressures.iter().map(|p| p.value()).collect();
            (r.s.value(), pressures)
        };
        let (s, pressures) = at(320);
        let error = |elements: usize| {
            let (found, heard) = at(elements);
            let worst = heard.iter().zip(&pressures).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            [(found - s).norm(), worst]
        };
        let ten = error(10);
        assert!(ten[0] < 2e-3 && ten[1] < 5e-6, "{id}: {ten:?}");
        // A quarter of the length: of second order 16 times less, of fourth 256, but for the wall's loss, which has one gas per element, and
        // for the kinks of this profile.
        let (coarse, fine) = (error(20), error(80));
        assert!(fine[1] < coarse[1] / 25.0, "{id}: {coarse:?} {fine:?}");
    }
}

#[test]
fn oracle_base_errors_are_slopes_and_points_that_share_a_cause_stay_together() {
    let assembly = assembly(&["wall.rayleigh", "ends.levine-schwinger", "heat-release.2"]);
    let values = [1.0, 8e-4, 4e-4];
    let mut points: Vec<Observed> = ["H50-25", "H180-25", "H180-60"]
        .iter()
        .map(|id| observed(&assembly, conditions(id), &values))
        .collect();
    let errors = BaseErrors::new(&assembly, &points, &ALL, &values).unwrap();
    assert_eq!(errors.together(|_, _| false), [vec![0, 1, 2]], "all share the ambient temperature");
    // A fiftieth of the displacement gives the same slopes: the errors act linearly.
    let whole = errors.covariance(&[0, 1], &[0, 1]);
    for point in &mut points {
        for error in &mut point.conditions.base.errors {
            error.heater_velocity *= 0.02;
            error.temperature.iter_mut().for_each(|t| *t *= 0.02);
        }
        point.conditions.base.errors.remove(0);
    }
    let small = BaseErrors::new(&assembly, &points, &ALL, &values).unwrap();
    assert_eq!(
        small.together(|_, _| false),
        [vec![0, 1], vec![2]],
        "only those of one position share the wall"
    );
    let wall = small.covariance(&[0, 1], &[0, 1]);
    for i in 0..4 {
        for j in 0..4 {
            // What is missing is the ambient temperature: 0.18 rad/s and 0.001 1/s.
            let rest = whole[(i, j)] - 2500.0 * wall[(i, j)];
            let ambient = [0.003, 0.19][i % 2] * [0.003, 0.19][j % 2];
            assert!(rest.abs() < ambient + 2e-3 * whole[(i, i)].max(whole[(j, j)]), "{i} {j}: {rest}");
        }
    }
    assert!(whole[(1, 3)] > 0.9 * (whole[(1, 1)] * whole[(3, 3)]).sqrt(), "they move together");
}

/// The slow way: every cause by itself.
#[test]
fn oracle_principal_errors_do_what_the_causes_do() {
    let assembly = assembly(&["wall.rayleigh", "ends.levine-schwinger", "heat-release.2"]);
    let values = [1.0, 8e-4, 4e-4];
    let mut conditions = conditions("H180-25");
    for k in 0..12 {
        let mut error = conditions.base.errors[1].clone();
        error.cause = format!("cause {k}");
        let x = f64::from(k);
        (error.heater_velocity, error.mass_flux) = (4e-3 * (x - 4.0), 1e-3 * (3.0 - x));
        error.temperature = vec![0.0, 0.02 * x, 0.1 * (x - 6.0), 0.3 - 0.01 * x * x];
        conditions.base.errors.push(error);
    }
    let point = observed(&assembly, conditions.clone(), &values);
    let all: Vec<usize> = (0..16).collect();
    let fast = BaseErrors::new(&assembly, std::slice::from_ref(&point), &ALL, &values)
        .unwrap()
        .covariance(&[0], &all);
    let mut slow = Matrix::zeros(16, 16);
    for error in &conditions.base.errors {
        let [up, down] = [0.1, -0.1].map(|sds| {
            let base = conditions.base.displaced_along(&error.cause, sds);
            observed(&assembly, Conditions { base, ..conditions.clone() }, &values).ping.vector()
        });
        slow.add_outer(&up.iter().zip(&down).map(|(u, d)| (u - d) / 0.2).collect::<Vec<_>>());
    }
    for i in 0..16 {
        for j in 0..16 {
            let scale = (slow[(i, i)] * slow[(j, j)]).sqrt();
            let miss = (fast[(i, j)] - slow[(i, j)]).abs() / scale;
            assert!(miss < 2e-3, "{i} {j}: {} {}", fast[(i, j)], slow[(i, j)]);
        }
    }
}

#[test]
fn exact_errors_of_the_base_state_widen_the_posterior_and_are_not_fitted() {
    let ids = ["wall.rayleigh", "ends.levine-schwinger", "heat-release.2"];
    let assembly = assembly(&ids).fixed("eta", 1.0).unwrap();
    let truth = [8e-4, 4e-4];
    let points: Vec<Observed> = ["H50-25", "H180-25", "H180-60"]
        .iter()
        .map(|id| observed(&assembly, conditions(id), &truth))
        .collect();
    let sd = |base_errors| {
        let trained = train(&assembly, &points, &training(base_errors)).unwrap();
        for (value, (truth, sd)) in trained.values.iter().zip(truth.iter().zip(trained.sd())) {
            assert!((value - truth).abs() < 0.1 * sd, "{value} {truth} {sd}");
        }
        trained.sd()
    };
    let (without, with) = (sd(false), sd(true));
    // 4 K of 420 K move the frequency by 3 rad/s, against an sd of 0.2; mode shapes still tell what they told.
    assert!((0..2).all(|i| with[i] > 1.5 * without[i]), "{without:?} {with:?}");
}

/// Two causes of error make a covariance of rank two, which may explain the whole misfit and yet cannot stand alone.
#[test]
fn exact_floating_noise_stays_where_the_errors_of_the_base_state_are_of_low_rank() {
    let ids = ["wall.rayleigh", "ends.levine-schwinger", "heat-release.2"];
    let assembly = assembly(&ids).fixed("eta", 1.0).unwrap();
    let truth = [8e-4, 4e-4];
    let sd = 1e-4;
    let points: Vec<Observed> = ["H50-25", "H180-25", "H180-60", "H180-75"]
        .iter()
        .map(|id| {
            let mut point = observed(&assembly, conditions(id), &truth);
            let mut draws = Streams::new(1).stream(id);
            let mut draw = |scale: f64| scale * draws.sample::<f64, _>(StandardNormal);
            point.ping.s += C64::new(draw(0.2), draw(0.2));
            for pressure in &mut point.ping.pressures {
                *pressure += C64::new(draw(sd), draw(sd));
            }
            point
        })
        .collect();
    let floated = Training { noise: Noise::FLOATED, ..training(true) };
    let trained = train(&assembly, &points, &floated).unwrap();
    let found = trained.noise.iter().find(|n| n.name == "relative pressure").unwrap();
    assert!(found.floats && (0.5 * sd..2.0 * sd).contains(&found.sd), "{found:?}");
    for (value, (truth, sd)) in trained.values.iter().zip(truth.iter().zip(trained.sd())) {
        assert!((value - truth).abs() < 4.0 * sd, "{value} {truth} {sd}");
    }
}

/// The rig is set once for all powers at a position: what the points share is found as such, and not taken for noise of each.
#[test]
fn exact_what_the_points_of_one_setting_share_is_told_from_their_own_noise() {
    let ids = ["wall.rayleigh", "ends.levine-schwinger", "heat-release.2"];
    let assembly = assembly(&ids).fixed("eta", 1.0).unwrap();
    let truth = [8e-4, 4e-4];
    let (own, setting) = (0.05, 1.0);
    let mut points = Vec::new();
    for x in [15, 20, 25, 30, 35, 40, 60, 65, 70, 75, 80, 85] {
        let mut offset = Streams::new(2).stream(&format!("{x}"));
        let shared = C64::new(offset.sample(StandardNormal), offset.sample(StandardNormal)) * setting;
        for power in [30, 80, 180] {
            let mut point = observed(&assembly, conditions(&format!("H{power}-{x}")), &truth);
            let mut draw = |sd: f64| {
                C64::new(offset.sample(StandardNormal), offset.sample::<f64, _>(StandardNormal)) * sd
            };
            point.ping.s += shared + draw(own);
            for pressure in &mut point.ping.pressures {
                *pressure += draw(1e-4);
            }
            points.push(point);
        }
    }
    let inferred = NoiseMode::Inferred { median: 1.0, ln_sd: 1.0 };
    let noise = Noise { setting: [inferred; 2], ..Noise::FLOATED };
    let with = train(&assembly, &points, &Training { noise, ..training(true) }).unwrap();
    let without = train(&assembly, &points, &Training { noise: Noise::FLOATED, ..training(true) }).unwrap();
    let sd = |name: &str| with.noise.iter().find(|n| n.name == name).unwrap().sd;
    for quantity in ["growth rate", "angular frequency"] {
        let found = [sd(quantity), sd(&format!("{quantity}, between settings"))];
        // Twelve settings know their scatter to a fifth, 24 differences within them their noise to a seventh.
        assert!((0.4 * setting..2.5 * setting).contains(&found[1]), "{quantity}: {found:?}");
        assert!((0.4 * own..2.5 * own).contains(&found[0]), "{quantity}: {found:?}");
    }
    let whole = Misfit::of(&with.noise).measured;
    assert!((whole[0] - sd("growth rate").hypot(sd("growth rate, between settings"))).abs() < 1e-12);
    let gain = with.evidence.ln_marginal - without.evidence.ln_marginal;
    assert!(gain > 30.0, "{gain}");
    for (value, (truth, sd)) in with.values.iter().zip(truth.iter().zip(with.sd())) {
        assert!((value - truth).abs() < 3.0 * sd, "{value} {truth} {sd}");
    }
}

#[test]
fn exact_a_microphone_in_the_near_field_of_the_heater_is_not_believed() {
    let assembly =
        assembly(&["wall.rayleigh", "ends.levine-schwinger", "heat-release.2"]).fixed("eta", 1.0).unwrap();
    let truth = [8e-4, 4e-4];
    let mut point = observed(&assembly, conditions("H180-25"), &truth);
    let right = train(&assembly, std::slice::from_ref(&point), &training(false)).unwrap();
    point.ping.pressures[0] *= 1.02;
    let wrong = train(&assembly, std::slice::from_ref(&point), &training(false)).unwrap();
    for i in 0..2 {
        let shift = (wrong.values[i] - right.values[i]).abs() / right.sd()[i];
        assert!(shift < 0.05, "{i}: {shift}");
    }
    point.ping.pressures[1] *= 1.02;
    let far = train(&assembly, std::slice::from_ref(&point), &training(false)).unwrap();
    assert!((far.values[0] - right.values[0]).abs() > right.sd()[0], "the next microphone is believed");
}

#[test]
fn exact_a_saved_model_predicts_as_before() {
    let assembly = assembly(&[
        "wall.rayleigh",
        "ends.levine-schwinger",
        "heat-release.cylinder",
        "mean-flow.convection",
    ])
    .fixed("eta", 1.02)
    .unwrap();
    let point = observed(&assembly, conditions("H180-25"), &[0.5, 2.0, 1.7]);
    let trained = train(&assembly, std::slice::from_ref(&point), &training(true)).unwrap();
    let saved =
        SavedModel::new(&assembly, &trained, vec!["H180-25".into()], DataKind::Virtual, "test".into());
    let path = std::env::temp_dir().join(format!("rijke-model-{}.json", std::process::id()));
    saved.write(&path).unwrap();
    let read = SavedModel::read(&path).unwrap();
    assert_eq!((&read, read.assembly().unwrap().held()), (&saved, vec![("eta".to_owned(), 1.02)]));
    let there = conditions("H130-60");
    let before = trained.knowledge().predict(&assembly, &there, &ALL, None).unwrap();
    let after = read.predict(&there, &ALL).unwrap();
    assert_eq!(before, after);
    assert!(after.sd(0, &Misfit::default()) > 0.0 && after.base[(1, 1)] > 0.0);
    let Evidence { ln_best_fit, ln_occam, ln_marginal, datapoints } = read.evidence;
    assert!((ln_marginal - ln_best_fit - ln_occam).abs() < 1e-9 && datapoints == 1);

    let broken = std::fs::read_to_string(&path).unwrap().replace("-k1*(gamma", "-k1*(gama");
    std::fs::write(&path, broken).unwrap();
    let word = SavedModel::read(&path).unwrap_err().to_string();
    std::fs::remove_file(&path).unwrap();
    assert!(word.contains("heat-release.cylinder") && word.contains("gamma"), "{word}");
}
