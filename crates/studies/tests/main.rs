//! The studies on observations that a known model made, where the right answer is known.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rand::RngExt;
use rijke_inference::MapOptions;
use rijke_lab::{Truth, VirtualRig};
use rijke_model::{Assembly, Conditions, Noise, Observed, PointModel, Training, Workspace, train};
use rijke_numerics::{C64, Cholesky, Matrix, Order, Stream, Streams};
use rijke_rig::{Campaign, DataKind, Day, Observations, Ping, PointObservations, RecordSource, Rig};
use rijke_studies::{catalogue, cold_heater, empty_tube, microphones, prongs, prongs_stage, true_empty_tube};

const ALL: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Standard deviations of growth rate, frequency and pressures in the artificial observations.
const SD: [f64; 3] = [0.02, 0.05, 2e-4];

fn normal(stream: &mut Stream) -> f64 {
    // Box and Muller, good enough for a test.
    let (u, v): (f64, f64) = (stream.random(), stream.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Row C3 as the assembly of `ids` with `values` predicts it, with noise of the stream called `seed`.
fn made_by(
    ids: &[&str],
    values: &[f64],
    seed: &str,
    sd: [f64; 3],
    only: impl Fn(&str) -> bool,
) -> Observations {
    let (rig, all) = (Rig::juniper_yoko_2022(), catalogue().unwrap());
    let assembly =
        Assembly::new(rig.clone(), ids.iter().map(|id| all.get(id).unwrap().clone()).collect()).unwrap();
    let mut stream = Streams::new(7).stream(seed);
    let points = Campaign::juniper_yoko_2022().points.into_iter().filter(|p| only(&p.id));
    let points = points
        .map(|point| {
            let conditions = Conditions::cold(&rig, point.clone(), 294.0, 0.1).unwrap();
            let model = PointModel::new(&assembly, &conditions, &ALL).unwrap();
            let r = model.respond(values, Order::Value, &mut Workspace::default()).unwrap();
            let pressures: Vec<C64> = r.pressures.iter().map(|p| p.value()).collect();
            let variance: Vec<f64> = (0..16).map(|k| sd[k.min(2)].powi(2)).collect();
            let covariance = Matrix::diagonal(&variance);
            let exact = Ping { s: r.s.value(), pressures, reference: 5, covariance: covariance.clone() };
            let noisy: Vec<f64> =
                (0..16).map(|k| exact.vector()[k] + sd[k.min(2)] * normal(&mut stream)).collect();
            PointObservations {
                ambient: Day { id: "day 1".into(), ambient_temperature: 294.0, ambient_temperature_sd: 0.1 },
                ping: Some(Ping::from_vector(&noisy, 5, covariance)),
                ping_count: point.repeats,
                click: None,
                click_count: 0,
                pings: Vec::new(),
                clicks: Vec::new(),
                point,
            }
        })
        .collect();
    Observations {
        rig,
        kind: DataKind::Virtual,
        source: "test".into(),
        points,
        rejections: Vec::new(),
        channels: None,
    }
}

#[test]
fn exact_the_model_that_made_the_data_wins_table_2() {
    let observations = made_by(
        &["wall.rayleigh", "ends.calibrated", "prongs.6"],
        &[1.02, 0.998, 0.004, 0.8, 1.1],
        "prongs",
        SD,
        |id| id.starts_with("C3"),
    );
    let found = prongs(&observations).unwrap();
    assert_eq!(found.winner, "prongs.6");
    for model in &found.models {
        let e = model.evidence.unwrap();
        assert!((e.ln_marginal - e.ln_best_fit - e.ln_occam).abs() < 1e-12);
        assert_eq!((model.at_points.len(), model.line.len()), (20, 121));
    }
    let [alpha, beta] =
        ["alpha", "beta"].map(|name| found.models[5].parameters.iter().find(|p| p.name == name).unwrap());
    assert!((alpha.value - 0.8).abs() < 4.0 * alpha.sd && (beta.value - 1.1).abs() < 4.0 * beta.sd);
    assert!(found.checks[0].holds && found.checks[1].holds, "{:?}", found.checks);
}

#[test]
fn exact_one_microphone_cannot_separate_ends_and_wall_but_eight_can() {
    let truth = [0.9960, 3.0600, 1.05];
    let observations = made_by(&["ends.free", "wall.rayleigh"], &truth, "empty", SD, |id| id == "C3-E");
    let found = empty_tube(&observations, Some(truth)).unwrap();
    assert!(found.checks.iter().all(|c| c.holds), "{:?}", found.checks);
    assert_eq!(
        found.parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(),
        ["R_abs", "R_arg", "eta"]
    );
}

/// Row C3 as the laboratory's true modes, with the noise of a mean of 40 pings and the thermometer's error.
fn laboratory(seed: u64, rows: &[&str]) -> Observations {
    let (rig, campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
    let lab = VirtualRig::new(
        &rig,
        &campaign,
        &Truth::standard(),
        &rows.iter().map(|r| (*r).to_owned()).collect::<Vec<_>>(),
        Some(1),
        seed,
    )
    .unwrap();
    let set = lab.set();
    let mut stream = Streams::new(seed).stream("studies");
    let points = set.points.iter().enumerate().map(|(k, entry)| {
        let (s, pressures) = lab.true_mode(k);
        let covariance = Matrix::diagonal(&(0..16).map(|k| SD[k.min(2)].powi(2)).collect::<Vec<_>>());
        let exact = Ping { s, pressures, reference: 5, covariance: covariance.clone() };
        let noisy: Vec<f64> =
            exact.vector().iter().enumerate().map(|(k, v)| v + SD[k.min(2)] * normal(&mut stream)).collect();
        PointObservations {
            point: entry.point.clone(),
            ambient: set.days[entry.day].clone(),
            ping: Some(Ping::from_vector(&noisy, 5, covariance)),
            ping_count: 40,
            click: None,
            click_count: 0,
            pings: Vec::new(),
            clicks: Vec::new(),
        }
    });
    let (source, points) = (set.source.clone(), points.collect());
    Observations { rig, kind: DataKind::Virtual, source, points, rejections: Vec::new(), channels: None }
}

#[test]
fn lab_the_laboratory_needs_drag_and_blockage() {
    for seed in 1..4 {
        let observations = laboratory(seed, &["C3"]);
        let found = prongs(&observations).unwrap();
        // Model 6 wins on most seeds; which of 6 and 7 does is for the page to say, not for a test.
        assert!(["prongs.6", "prongs.7"].contains(&found.winner.as_str()), "{}", found.winner);
        assert!(found.checks[..3].iter().all(|c| c.holds), "{:?}", found.checks);
        let tube = empty_tube(&observations, true_empty_tube(&observations, &Truth::standard())).unwrap();
        assert!(tube.checks.iter().all(|c| c.holds), "{:?}", tube.checks);
    }
}

#[test]
fn lab_a_good_pair_of_microphones_is_nearly_as_good_as_eight() {
    let found = microphones(&laboratory(1, &["C3"]), None).unwrap();
    assert_eq!(found.sets.len(), 128);
    assert!(found.checks.iter().all(|c| c.holds), "{:?}", found.checks);
}

#[test]
fn exact_the_heater_that_made_the_data_wins_table_3() {
    let values = [1.02, 0.998, 0.004, 0.8, 1.1, 0.9, 0.06, 0.02, 0.01];
    let ids = ["wall.rayleigh", "ends.calibrated", "prongs.6", "heater.3"];
    let mut observations = made_by(&ids[..3], &values[..5], "before", SD, |id| id.starts_with("C3"));
    let heater = made_by(&ids, &values, "heater", SD, |id| id.starts_with("C1") || id.starts_with("C2"));
    observations.points.extend(heater.points);
    let (_, stage) = prongs_stage(&observations, false).unwrap();
    let (found, _) = cold_heater(&observations, &stage, false).unwrap();
    assert_eq!((found.winner.as_str(), found.measured.len()), ("heater.3", 34));
    // Those of the paper; the wires, which did not make these data, do not win.
    let (ours, paper): (Vec<_>, Vec<_>) =
        found.checks.iter().partition(|c| c.statement.starts_with("Beyond the paper"));
    assert!(paper.iter().all(|c| c.holds) && ours.iter().all(|c| !c.holds), "{:?}", found.checks);
    for (name, truth) in [("kappa", 0.9), ("drag", 0.06), ("heat_r", 0.02), ("heat_i", 0.01)] {
        let p = found.models[2].parameters.iter().find(|p| p.name == name).unwrap();
        assert!((p.value - truth).abs() < 4.0 * p.sd, "{p:?}");
    }
}

#[test]
fn lab_the_cold_heater_is_more_than_an_orifice() {
    let observations = laboratory(1, &["C3", "C1", "C2"]);
    let (_, stage) = prongs_stage(&observations, false).unwrap();
    let (found, _) = cold_heater(&observations, &stage, false).unwrap();
    // The physical statements of section 6.3; they hold without having been tuned to.
    assert!(found.checks.iter().all(|c| c.holds), "{:?}", found.checks);
    assert_ne!(found.winner, "heater.1", "{:?}", found.checks);
}

#[test]
fn exact_a_missing_point_is_named() {
    let nothing = made_by(&["ends.free", "wall.rayleigh"], &[0.996, 3.06, 1.0], "none", SD, |_| false);
    assert!(empty_tube(&nothing, None).unwrap_err().to_string().contains("empty tube"));
    let only_empty =
        made_by(&["ends.free", "wall.rayleigh"], &[0.996, 3.06, 1.0], "one", SD, |id| id == "C3-E");
    assert!(prongs(&only_empty).unwrap_err().to_string().contains("two positions"));
}

/// Issue 2: over 200 seeds, where the model is exact, eta and R lie inside two standard deviations in 92 to 98 %.
#[test]
fn exact_two_sd_of_eta_and_r_hold_over_200_seeds() {
    let (rig, all) = (Rig::juniper_yoko_2022(), catalogue().unwrap());
    let ids = ["ends.free", "wall.rayleigh"];
    let assembly = Assembly::new(rig, ids.iter().map(|id| all.get(id).unwrap().clone()).collect()).unwrap();
    let sd = [0.1, 1.0, 1e-3];
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
    let truth = [0.9975, 3.0550, 1.0];
    let mut inside = [0_u32; 3];
    let mut inside_jointly = 0_u32;
    for seed in 0..200 {
        let made = made_by(&ids, &truth, &format!("calibration/{seed}"), sd, |id| id == "C3-E");
        let point = &made.points[0];
        let observed = Observed {
            conditions: Conditions::of_the_day(&made.rig, point).unwrap(),
            ping: point.ping.clone().unwrap(),
        };
        let trained = train(&assembly, &[observed], &training).unwrap();
        let off: Vec<f64> = (0..3).map(|i| trained.values[i] - truth[i]).collect();
        for i in 0..3 {
            inside[i] += u32::from(off[i].abs() < 2.0 * trained.sd()[i]);
        }
        let white = Cholesky::new(&trained.covariance).unwrap().whiten(&off);
        // 95.45 % of a three-dimensional Gaussian lies within chi-square 8.0249.
        inside_jointly += u32::from(white.iter().map(|w| w * w).sum::<f64>() < 8.0249);
    }
    assert!(inside.iter().all(|n| (184..=196).contains(n)) && (184..=196).contains(&inside_jointly));
}
