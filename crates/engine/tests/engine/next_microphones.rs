//! What microphones tell, on a tube whose modes have a closed form, against trainings on the data that they
//! would bring.

use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{MicrophoneTable, Run, Trusted, Wish, microphones};
use rijke_engine::{Conditions, NamedGaussian, Observed};
use rijke_numerics::{C64, Matrix};
use rijke_study::{ObservedMode, ObservedModes, PointState, Study};
use std::sync::Arc;

/// What is true, and what the prior is about, so that curvature of the model does not enter.
const R: f64 = 0.85;
/// Lengths of the tube at the points, m; the last two are the visits that are to be judged.
const LENGTHS: [f64; 4] = [1.0, 0.8, 1.0, 0.8];
/// Where the reference and the other microphones stand, m; the last is the one that may be added.
const AT: [f64; 4] = [0.1, 0.3, 0.45, 0.7];
/// Noise of the reference's and of the others' pressures, relative to the reference's.
const NOISE: [f64; 2] = [0.03, 0.02];
/// Variances of gains and of delays (s^2), and the share of each that two microphones have in common.
const CHANNELS: [[f64; 2]; 2] = [[9e-4, 3e-4], [1e-8, 4e-9]];

fn eigenvalue(length: f64) -> C64 {
    speed() / length * C64::new(R.ln(), std::f64::consts::PI)
}

/// Between ends that reflect -r, p is e^(s x/c) - r e^(-s x/c), relative to the reference.
fn pressure(length: f64, m: usize) -> C64 {
    let p = |x: f64| {
        let z = (eigenvalue(length) * x / speed()).exp();
        z - R / z
    };
    p(AT[m]) / p(AT[0])
}

/// What a visit reads of these microphones; the covariance counts what the calibration leaves.
fn visit(point: usize, heard: &[usize], calibrated: bool) -> ObservedMode {
    let (length, n) = (LENGTHS[point], heard.len());
    let s = eigenvalue(length);
    let p: Vec<C64> = heard.iter().map(|m| pressure(length, *m)).collect();
    let part = |i: usize, j: usize| {
        let own = if i == j { NOISE[1].powi(2) } else { 0.0 };
        p[i] * p[j].conj() * NOISE[0].powi(2) + own
    };
    let covariance = Matrix::from_fn(2 + 2 * n, 2 + 2 * n, |row, column| {
        if row < 2 || column < 2 {
            return if row == column { [1600.0, 0.1][row] } else { 0.0 };
        }
        let (i, j) = ((row - 2) / 2, (column - 2) / 2);
        let k = part(i, j);
        let noise = match (row % 2, column % 2) {
            (0, 0) | (1, 1) => k.re,
            (0, _) => -k.im,
            _ => k.im,
        };
        // The errors of channels are real: they move each pressure along one line.
        let along = |z: C64, row: usize| [z.re, z.im][row % 2];
        let share =
            |c: [f64; 2], a: C64, b: C64| along(a, row) * along(b, column) * if i == j { c[0] } else { c[1] };
        let shared = share(CHANNELS[0], p[i], p[j]) + share(CHANNELS[1], p[i] * s, p[j] * s);
        noise + if calibrated { shared } else { 0.0 }
    });
    ObservedMode {
        point,
        label: String::new(),
        growth_rate: Some(s.re),
        angular_frequency: Some(s.im),
        pressures: heard.iter().copied().zip(p).collect(),
        covariance,
        drift_sd: 0.0,
    }
}

/// A rig with the first `count` microphones, and visits with what was heard at each.
fn study(
    name: &str,
    count: usize,
    visits: &[(usize, &[usize])],
    calibrated: bool,
) -> (Folder, Study, ObservedModes) {
    let list = |of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<Vec<_>>().join(", ");
    let rig = TUBE.replace("mean = 0.9", "mean = 0.85").replace(
        "[upstream]",
        &format!(
            "[microphones]\nat = [{}]\nnames = [{}]\nreference = \"m0\"\n[upstream]",
            list(&|m| format!("\"{} m\"", AT[m])),
            list(&|m| format!("\"m{m}\""))
        ),
    );
    let matrix = |[own, shared]: [f64; 2]| {
        let row = |i: usize| {
            let one = |j: usize| if i == j { own } else { shared }.to_string();
            format!("[{}]", (1..count).map(one).collect::<Vec<_>>().join(", "))
        };
        format!("[{}]", (1..count).map(row).collect::<Vec<_>>().join(", "))
    };
    let stated =
        format!("delay_covariance_s2 = {}\ngain_covariance = {}\n", matrix(CHANNELS[1]), matrix(CHANNELS[0]));
    let plan = format!(
        "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {{}}\nchannels = {calibrated}\n[stage.noise]\ngrowth_rate = 0.0\n\
         angular_frequency = 0.0\npressure = 0.0\n"
    );
    let campaign = "point,x [cm],T_amb [degC]\na,100,20\nb,80,20\na2,100,20\nb2,80,20\n";
    let mut files = vec![
        ("rig.toml", rig.as_str()),
        ("campaign.csv", campaign),
        ("study.toml", plan.as_str()),
        ("observations/observations.toml", "kind = \"virtual\"\nsource = \"closed form\"\n"),
        ("observations/modes.csv", "point,growth_rate [1/s],growth_rate_sd [1/s]\na,-50,40\n"),
    ];
    if calibrated {
        files.push(("observations/channels.toml", stated.as_str()));
    }
    let folder = Folder::new(&format!("microphones-{name}-{calibrated}"), &files);
    let study = Study::open(&folder.0).unwrap();
    let mut observations = study.observations().unwrap();
    observations.modes = visits.iter().map(|(k, heard)| visit(*k, heard, calibrated)).collect();
    (folder, study, observations)
}

fn trained(study: &Study, observations: &ObservedModes) -> (Run, f64) {
    let mut run = Run::new(study.clone(), observations, Trusted::Laplace).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    let sd = stage.models[0].parameters[0].sd;
    (run, sd)
}

fn judged(calibrated: bool, visits: &[usize]) -> (MicrophoneTable, f64) {
    let (_folder, study, observations) =
        study(&format!("judged-{}", visits.len()), 3, &[(0, &[1, 2]), (1, &[1, 2])], calibrated);
    let (run, sd) = trained(&study, &observations);
    let wish = Wish { candidates: visits.to_vec(), ..Wish::default() };
    let model = run.saved("s").unwrap();
    (microphones(&study, &observations, &model, &[], &wish, &AT[3..]).unwrap(), sd)
}

/// No derivative of a prediction and no formula for information: sd of the parameter after a training on all
/// data. With errors of channels these are parameters of the training, as many as there are microphones.
#[test]
fn oracle_what_microphones_tell_against_trainings_with_and_without_them() {
    for calibrated in [false, true] {
        let (found, before) = judged(calibrated, &[2, 3]);
        let told = |name: &str, heard: &[usize]| {
            let visits = [(0, [1, 2].as_slice()), (1, &[1, 2]), (2, heard), (3, heard)];
            let (_folder, study, observations) = study(name, 4, &visits, calibrated);
            (before / trained(&study, &observations).1).ln()
        };
        let all = told("all", &[1, 2]);
        let near = |what: &str, found: f64, oracle: f64| {
            assert!((found - oracle).abs() < 1e-5, "{what}, channels {calibrated}: {found} {oracle}");
        };
        near("no pressures", found.total[0], told("none", &[]));
        near("all", found.total[1], all);
        for m in &found.in_use {
            match m.microphone.as_str() {
                "m1" => near("m1", m.nats, all - told("m1", &[2])),
                "m2" => near("m2", m.nats, all - told("m2", &[1])),
                _ => assert!(m.nats > 0.0 && m.takes_its_role.as_deref() == Some("m1")),
            }
        }
        let [added] = &found.further[..] else { panic!("{found:?}") };
        near("added", added.nats, told("added", &[1, 2, 3]) - all);
        assert!(added.nats > 1e-3 && found.in_use.windows(2).all(|w| w[0].nats >= w[1].nats), "{found:?}");
    }
}

/// Growth rates tell more with every visit. So do pressures beside them if their errors are noise; at one
/// point a delay and a gain move a pressure as anything else can, and do not average out.
#[test]
fn behaviour_more_visits_do_not_help_a_microphone_whose_gain_is_not_known() {
    let beside = |calibrated: bool, times: usize| {
        let [bare, all] = judged(calibrated, &vec![2; times]).0.total;
        all - bare
    };
    let [clear, shared] = [false, true].map(|calibrated| [beside(calibrated, 1), beside(calibrated, 100)]);
    assert!(clear[1] > clear[0] && shared[1] < 0.5 * shared[0], "{clear:?} {shared:?}");
}

#[test]
fn message_microphones_that_cannot_be_judged() {
    let (_folder, study, mut observations) = study("message", 3, &[(0, &[1, 2]), (1, &[1, 2])], false);
    let (run, _) = trained(&study, &observations);
    let model = run.saved("s").unwrap();
    let wish = Wish { candidates: vec![0, 1], ..Wish::default() };
    let grid = microphones(&study, &observations, &model, &[], &wish, &[]).unwrap();
    // Every twentieth of the longer tube that is in the shorter one too.
    assert_eq!(grid.further.len(), 17);
    let said = |observations: &ObservedModes, x: f64| {
        microphones(&study, observations, &model, &[], &wish, &[x]).unwrap_err().to_string()
    };
    let beyond = said(&observations, 0.9);
    assert!(beyond.contains("at 0.9 m") && beyond.contains("from 0 to 0.8 m"), "{beyond}");
    observations.modes.iter_mut().for_each(|mode| {
        mode.pressures.clear();
        mode.covariance = mode.covariance.select(&[0, 1]);
    });
    let none = said(&observations, 0.5);
    assert!(none.contains("trained without mode shapes") && none.contains("p2_re_sd"), "{none}");
}

/// P (1 - s d + g) was heard.
#[test]
fn exact_delays_and_gains_that_were_found_are_undone() {
    let (_folder, study, observations) = study("undone", 3, &[(0, &[1, 2])], false);
    let (point, clear) = (study.campaign.points[0].clone(), observations.modes[0].clone());
    let layout = study.rig.at(&point, 293.15).unwrap();
    let base = PointState::of_the_rig(&study.rig, &layout, &point, [293.15, 0.0]).unwrap();
    let conditions = Conditions { id: point.id.clone(), point, layout, base, displaced: Vec::new() };
    let (s, errors) = (eigenvalue(LENGTHS[0]), [[3e-5, 0.04], [-2e-5, 0.07]]);
    let mut mode = clear.clone();
    for ((_, p), [delay, gain]) in mode.pressures.iter_mut().zip(errors) {
        *p *= 1.0 - s * delay + gain;
    }
    let names = ["delay of m1", "delay of m2", "gain of m1", "gain of m2"].map(str::to_owned).to_vec();
    let mean = vec![errors[0][0], errors[1][0], errors[0][1], errors[1][1]];
    let known = NamedGaussian { names, mean, covariance: Matrix::zeros(4, 4) };
    let found =
        known.without_channels(&study.rig, &Observed { conditions: Arc::new(conditions), mode, near: s });
    for ((m, p), (of, expected)) in found.mode.pressures.iter().zip(&clear.pressures) {
        assert!(m == of && (p - expected).norm() < 1e-12 * expected.norm(), "{m}: {p} {expected}");
    }
}

/// A microphone beside a part errs by the near field as by noise of its own that was measured; the reference
/// by noise that all pressures have in proportion to themselves.
#[test]
fn oracle_a_near_field_is_noise_of_the_microphone_beside_the_part() {
    const SD: f64 = 0.04;
    let trained = |name: &str, part: Option<f64>, own: [f64; 2]| {
        let visits: [(usize, &[usize]); 2] = [(0, &[1, 2]), (2, &[1, 2])];
        let (folder, _, mut observations) = study(name, 3, &visits, false);
        if let Some(x) = part {
            let rig = std::fs::read_to_string(folder.0.join("rig.toml")).unwrap();
            let device = format!(
                "[[element]]\nname = \"part\"\ntype = \"device\"\nat = \"{x} m\"\nnear_field = {SD}\n[unknown.r]"
            );
            std::fs::write(folder.0.join("rig.toml"), rig.replace("[unknown.r]", &device)).unwrap();
        }
        for mode in &mut observations.modes {
            let p: Vec<C64> = mode.pressures.iter().map(|(_, p)| *p).collect();
            let [reference, first] = own.map(|sd| sd * sd);
            mode.covariance = Matrix::from_fn(6, 6, |i, j| {
                let old = mode.covariance[(i, j)];
                let (Some(a), Some(b)) = (i.checked_sub(2), j.checked_sub(2)) else { return old };
                let common = p[a / 2] * p[b / 2].conj() * reference;
                let shared = match (a % 2, b % 2) {
                    (0, 0) | (1, 1) => common.re,
                    (0, _) => -common.im,
                    _ => common.im,
                };
                old + shared + if a == b && a < 2 { first } else { 0.0 }
            });
        }
        let study = Study::open(&folder.0).unwrap();
        let (run, sd) = trained(&study, &observations);
        drop(run);
        sd
    };
    let alone = trained("near-none", None, [0.0; 2]);
    for (name, x, own) in [("near-first", 0.31, [0.0, SD]), ("near-reference", 0.09, [SD, 0.0])] {
        let [found, slow] = [trained(name, Some(x), [0.0; 2]), trained(&format!("{name}-slow"), None, own)];
        assert!((found / slow - 1.0).abs() < 1e-6 && found > 1.002 * alone, "{name}: {found} {slow} {alone}");
    }
}
