//! Laws with a delay that the flow sets: aliases, order, what is not decided, what was not measured.

use super::{ORIGIN, parameter};
use crate::common::folder::Folder;
use rijke_engine::run::{Run, StageRecord, Trusted, forecast, modes_at};
use rijke_study::Study;
use std::path::Path;

/// A law of a gauze with a delay that the flow sets. Of six points one delay is known; its prior may lie at
/// an alias.
fn delayed(name: &str, priors: [&str; 2], modes: &str, plan: &str) -> Folder {
    let law = |id: &str, tau: &str, prior: &str| {
        format!(
            "[[candidate]]\nid = \"{id}\"\nrole = \"heat\"\nname = \"{id}\"\ncite = [\"own judgement\"]\n\
             parameters.n = {{ unit = \"1\", prior = {{ normal = {{ mean = 0.3, sd = 0.3 }} }} }}\n\
             parameters.b = {{ unit = \"s\", prior = {{ normal = {{ {prior} }} }} }}\n\
             [[candidate.effect]]\nacts_at = \"gauze\"\neu = \"-n*exp(-s*{tau})\"\n"
        )
    };
    let [by_flow, by_root] = priors;
    let candidates = law("inverse", "b*w_0/w", by_flow) + &law("root", "b*(w_0/w)^0.5", by_root);
    let rig = "name = \"tube\"\n[gas]\ntemperature = \"20 degC\"\n[search]\nfrequency_hz = [40, 140]\n[upstream]\ntype = \"closed\"\n[downstream]\n\
               type = \"unflanged\"\n[[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = \"0.9 m\"\ndiameter = \"40 mm\"\n\
               wall = \"kirchhoff\"\n[[element]]\nname = \"gauze\"\ntype = \"device\"\nat = \"0.4 m\"\n\
               numbers = { w_0 = \"0.2 m/s\" }\n";
    let rows: String = [0.15, 0.18, 0.21, 0.25, 0.29, 0.34]
        .iter()
        .enumerate()
        .map(|(k, w)| format!("p{k},{w},20\n"))
        .collect();
    let campaign = format!("point,w [m/s],T_amb [degC]\n{rows}");
    let plan = format!("name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {{}}\ncompete = \"heat\"\n{plan}");
    Folder::new(
        name,
        &[
            ("rig.toml", rig),
            ("campaign.csv", &campaign),
            ("candidates/heat.toml", &candidates),
            ("study.toml", &plan),
            ("observations/observations.toml", ORIGIN),
            ("observations/modes.csv", modes),
        ],
    )
}

/// The modes of the first law at the centres of its priors.
fn made_by_the_first(name: &str, centre: &str, sds: [f64; 2]) -> String {
    let empty = "point,growth_rate [1/s],growth_rate_sd [1/s]\np0,0,1\n";
    let folder = delayed(name, [centre, centre], empty, "");
    let study = Study::open(&folder.0).unwrap();
    let mut text = "point,growth_rate [1/s],growth_rate_sd [1/s],angular_frequency [rad/s],angular_frequency_sd [rad/s]\n".to_owned();
    for (k, point) in study.campaign.points.iter().enumerate() {
        let (_, spectrum, ..) = modes_at(&study, None, None, k, [None; 2]).unwrap();
        // A strong gauze has modes of its own, far more damped.
        let s = spectrum.modes.modes.iter().map(|m| m.s).max_by(|a, b| a.re.total_cmp(&b.re)).unwrap();
        text += &format!("{},{:.9},{},{:.9},{}\n", point.id, s.re, sds[0], s.im, sds[1]);
    }
    text
}

fn ranked(folder: &Path, trusted: Trusted) -> StageRecord {
    let study = Study::open(folder).unwrap();
    let observations = study.observations().unwrap();
    Run::new(study, &observations, trusted).unwrap().next_stage().unwrap().unwrap()
}

#[test]
fn behaviour_a_true_law_whose_prior_lies_at_an_alias_is_found_however_far_behind_its_first_fit_is() {
    let modes = made_by_the_first("alias-truth", "mean = 3e-3, sd = 1e-3", [0.002, 0.002]);
    let exact = "[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n";
    let folder = delayed("alias", ["mean = 9e-3, sd = 3e-3", "mean = 3e-3, sd = 1e-3"], &modes, exact);
    let total = |stage: &StageRecord, id: &str| {
        stage
            .models
            .iter()
            .find(|m| m.id == id)
            .unwrap()
            .evidence
            .map_or(f64::NEG_INFINITY, |e| e.ln_marginal)
    };
    // From its prior's mean the first law ends far below the second: the case of which this test is.
    let first = ranked(&folder.0, Trusted::Laplace);
    assert!(total(&first, "inverse") < total(&first, "root") - 150.0, "{:?}", first.models);
    let checked = ranked(&folder.0, Trusted::Checked);
    assert_eq!(checked.winner, "inverse");
    let [b, sd] = parameter(&checked, "b");
    assert!((b - 3e-3).abs() < 2.0 * sd && sd < 1e-4, "{b} +- {sd}");
    // The same with a length over a velocity in place of a delay.
    let path = folder.0.join("candidates/heat.toml");
    let mut text = std::fs::read_to_string(&path).unwrap();
    for (delay, length) in [
        ("unit = \"s\"", "unit = \"m\""),
        ("b*w_0/w", "b/w"),
        ("b*(w_0/w)^0.5", "b/w_0*(w_0/w)^0.5"),
        ("mean = 9e-3, sd = 3e-3", "mean = 1.8e-3, sd = 6e-4"),
        ("mean = 3e-3, sd = 1e-3", "mean = 6e-4, sd = 2e-4"),
    ] {
        assert!(text.contains(delay), "{delay}");
        text = text.replace(delay, length);
    }
    std::fs::write(&path, text).unwrap();
    let by_length = ranked(&folder.0, Trusted::Checked);
    assert_eq!(by_length.winner, "inverse");
    assert!((total(&by_length, "inverse") - total(&checked, "inverse")).abs() < 1e-4);
    let [length, of_length] = parameter(&by_length, "b");
    assert!((length / 0.2 - b).abs() < 1e-3 * sd && (of_length / 0.2 / sd - 1.0).abs() < 1e-3);
}

#[test]
fn behaviour_the_order_of_candidates_decides_nothing_unless_the_study_prefers_the_first() {
    // Growth rates and frequencies so loose that neither law is excluded.
    let modes = made_by_the_first("order-truth", "mean = 3e-3, sd = 1e-3", [40.0, 40.0]);
    let exact = "[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n";
    let priors = ["mean = 3e-3, sd = 1e-3", "mean = 3e-3, sd = 8e-4"];
    let of = |name: &str, plan: &str| ranked(&delayed(name, priors, &modes, plan).0, Trusted::Checked);
    let stage = of("order", exact);
    assert_eq!(stage.chosen, stage.winner);
    assert!(stage.assumes.is_empty());
    let first = of("order-first", &format!("prefer = \"first\"\n{exact}"));
    assert_eq!(first.chosen, "inverse");
    let on = "[[stage]]\nid = \"later\"\npoints = {}\non = \"s\"\n";
    let folder = delayed("order-on", priors, &modes, &format!("{exact}{on}"));
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Checked).unwrap();
    run.next_stage().unwrap();
    let later = run.next_stage().unwrap().unwrap();
    assert!(later.assumes.len() == 1 && later.assumes[0].contains("nats behind"), "{:?}", later.assumes);
    assert_eq!(run.saved("later").unwrap().assumes, later.assumes);
}

/// A mixture by its moments, E x and (E x^2 - (E x)^2)^(1/2), of the stage that leaves two laws open and of
/// one that stands on it.
#[test]
fn exact_predictions_average_over_laws_that_are_open_here_and_earlier() {
    let modes = made_by_the_first("average-truth", "mean = 3e-3, sd = 1e-3", [40.0, 40.0]);
    let plan = "[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n[[stage]]\nid = \"later\"\npoints = {}\non = \"s\"\n";
    let folder = delayed("average", ["mean = 3e-3, sd = 1e-3", "mean = 2e-3, sd = 8e-4"], &modes, plan);
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    let first = run.next_stage().unwrap().unwrap();
    run.next_stage().unwrap();
    let total = |chosen: bool| {
        let carried = first.carried.iter().find(|c| (c.id == first.chosen) == chosen).unwrap();
        carried.ln_evidence.unwrap()
    };
    let odds = (total(false) - total(true)).exp();
    for stage in ["s", "later"] {
        let (model, open) = (run.saved(stage).unwrap(), run.saved_open(stage).unwrap());
        assert_eq!(open.len(), 1);
        assert!((open[0].odds / odds - 1.0).abs() < 1e-9, "{stage}: {} {odds}", open[0].odds);
        assert_ne!(open[0].model.candidates, model.candidates);
        let alone = |model| forecast(&study, &observations, model, &[], &[1, 4]).unwrap().0;
        let (own, other) = (alone(&model), alone(&open[0].model));
        let all = forecast(&study, &observations, &model, &open, &[1, 4]).unwrap().0;
        for ((a, b), both) in own.iter().zip(&other).zip(&all) {
            assert!(a.averaged.is_none() && a.growth_rate == both.growth_rate);
            assert!(a.stability_sd >= a.growth_rate[2]);
            let mean = |a: f64, b: f64| (a + odds * b) / (1.0 + odds);
            let averaged = both.averaged.as_ref().unwrap();
            for ([u, v], w) in [[a.growth_rate, b.growth_rate], [a.angular_frequency, b.angular_frequency]]
                .into_iter()
                .zip([averaged.growth_rate, averaged.angular_frequency])
            {
                assert!((w[0] - mean(u[0], v[0])).abs() < 1e-9 * w[0].abs());
                for k in [1, 2] {
                    let square = mean(u[k].powi(2) + u[0].powi(2), v[k].powi(2) + v[0].powi(2));
                    assert!(
                        (w[k].powi(2) - (square - w[0].powi(2))).abs() < 1e-9 * square,
                        "{u:?} {v:?} {w:?}"
                    );
                }
            }
            assert!((averaged.unstable - mean(a.unstable, b.unstable)).abs() < 1e-12);
        }
    }
    // A stage that decides leaves nothing open.
    let decided =
        delayed("average-decided", ["mean = 3e-3, sd = 1e-3"; 2], &modes, "among = [\"inverse\"]\n");
    let study = Study::open(&decided.0).unwrap();
    let mut run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
    run.next_stage().unwrap();
    assert!(run.saved_open("s").unwrap().is_empty());
}

#[test]
fn message_a_role_that_no_stage_names_and_a_unit_with_a_prefix_are_said() {
    let none = "point,growth_rate [1/s],growth_rate_sd [1/s]\np0,0,1\n";
    let folder = delayed("role", ["mean = 3e-3, sd = 1e-3"; 2], none, "");
    let path = folder.0.join("candidates/heat.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("\"heat\"", "\"haet\"", 1)).unwrap();
    let said = Study::open(&folder.0).unwrap().unused().join("; ");
    assert!(
        said.contains("heat.toml, line 2: candidate `inverse` is not used, because no stage and no question names its role `haet`"),
        "{said}"
    );
    std::fs::write(&path, text.replacen("unit = \"s\"", "unit = \"ms\"", 1)).unwrap();
    let said = Study::open(&folder.0).unwrap_err().to_string();
    assert!(said.contains("the unit of `b` is `ms`, and formulas compute with the number"), "{said}");
}

#[test]
fn behaviour_a_noise_of_which_no_number_tells_does_not_float() {
    let modes = made_by_the_first("alone-truth", "mean = 3e-3, sd = 1e-3", [0.1, 0.1]);
    let only = |drop: [usize; 2]| -> String {
        let keep = |line: &str| {
            line.split(',')
                .enumerate()
                .filter(|(k, _)| !drop.contains(k))
                .map(|(_, c)| c)
                .collect::<Vec<_>>()
                .join(",")
        };
        modes.lines().map(|l| keep(l) + "\n").collect()
    };
    let folder = delayed("alone-frequency", ["mean = 3e-3, sd = 1e-3"; 2], &only([1, 2]), "");
    let stage = ranked(&folder.0, Trusted::Checked);
    assert!(stage.models.iter().all(|m| m.evidence.is_some()), "{:?}", stage.models);
    let [b, sd] = parameter(&stage, "b");
    assert!((b - 3e-3).abs() < 3.0 * sd, "{b} +- {sd}");
}

#[test]
fn exact_a_prediction_names_the_mode_that_was_not_measured() {
    let modes = made_by_the_first("other-truth", "mean = 3e-3, sd = 1e-3", [0.05, 0.05]);
    let folder = delayed("other", ["mean = 3e-3, sd = 1e-3"; 2], &modes, "among = [\"inverse\"]\n");
    let rig = std::fs::read_to_string(folder.0.join("rig.toml")).unwrap();
    // With the three-quarter wave in the region: the campaign trains on the quarter wave alone.
    std::fs::write(folder.0.join("rig.toml"), rig.replace("[40, 140]", "[40, 420]")).unwrap();
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    run.next_stage().unwrap();
    let model = run.saved("s").unwrap();
    let (found, _) = forecast(&study, &observations, &model, &[], &[2]).unwrap();
    let (_, spectrum, ..) = modes_at(&study, Some(&observations), Some(&model), 2, [None; 2]).unwrap();
    let measured = found[0].angular_frequency[0];
    let others = spectrum.modes.modes.iter().map(|m| m.s).filter(|s| (s.im - measured).abs() > 1.0);
    let second = others.max_by(|a, b| a.re.total_cmp(&b.re)).unwrap();
    let [growth, hertz] = found[0].other.unwrap();
    assert!((growth - second.re).abs() < 1e-6 && (hertz - second.im / std::f64::consts::TAU).abs() < 1e-6);
    assert!(measured < 900.0 && spectrum.modes.modes.len() > 1);
}
