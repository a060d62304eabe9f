//! Errors that all points of one installation share: in training a covariance, in predictions as the data
//! tell of them.

use super::ORIGIN;
use crate::common::folder::Folder;
use rijke_engine::run::{AskedPoint, Run, Trusted, forecast, modes_at, with_points};
use rijke_study::Study;
use rijke_study::plan::Selection;
use std::f64::consts::TAU;

/// Lengths of a tube with two rigid ends, m, and what was heard more than from gas of 293.15 K, Hz.
const POINTS: [(f64, f64); 5] = [(0.8, 0.52), (0.9, 0.43), (1.0, 0.44), (1.1, 0.31), (1.2, 0.33)];
const LENGTH_SD: f64 = 2e-3;
const KELVIN_SD: f64 = 0.5;
const HERTZ_SD: f64 = 0.05;

/// The thermometer of the only day of one installation errs by [`KELVIN_SD`]: an error of the gas, or, the
/// slow way, an unknown of the model that does the same to first order.
fn folder(name: &str, unknown: bool) -> Folder {
    let speed = (1.4_f64 * 287.0 * 293.15).sqrt();
    let rows = POINTS.iter().enumerate();
    let sd = if unknown { 0.0 } else { KELVIN_SD };
    let points: String = rows.clone().map(|(i, (x, _))| format!("p{i},{x},one,one,293.15,{sd}\n")).collect();
    let heard = |x: f64, more: f64| speed / (2.0 * x) + more;
    let modes: String =
        rows.map(|(i, (x, more))| format!("p{i},{},{HERTZ_SD}\n", heard(*x, *more))).collect();
    let law = if unknown { "exp(-2*s*(l - x*t/(2*T))/c)" } else { "exp(-2*s*l/c)" };
    let prior = |sd: f64| format!("prior = {{ normal = {{ mean = 0.0, sd = {sd} }} }}");
    let t = if unknown {
        format!("parameters.t = {{ unit = \"K\", {} }}\n", prior(KELVIN_SD))
    } else {
        String::new()
    };
    let candidate = format!(
        "[[candidate]]\nid = \"tube\"\nrole = \"tube\"\nname = \"tube\"\ncite = [\"a test\"]\n\
         parameters.l = {{ unit = \"m\", {} }}\n{t}\
         [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"{law}\"\n",
        prior(LENGTH_SD)
    );
    let rig = "name = \"tube\"\n[gas]\ngas_constant = 287.0\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"free\"\n\
               [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = \"x\"\ndiameter = 0.05\nwall = \"none\"\n";
    let plan = "name = \"t\"\nbase = \"ambient\"\n[[stage]]\nid = \"s\"\npoints = {}\nwith = { tube = \"tube\" }\nbase_errors = true\n\
                [stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n\
                [[ask]]\nid = \"q\"\nstage = \"s\"\nask = \"prediction\"\npoints = {}\n";
    Folder::new(
        name,
        &[
            ("rig.toml", rig),
            ("campaign.csv", &format!("point,x [m],installation,day,T_amb [K],T_amb_sd [K]\n{points}")),
            ("candidates/tube.toml", &candidate),
            ("study.toml", plan),
            ("observations/observations.toml", ORIGIN),
            ("observations/modes.csv", &format!("point,frequency [Hz],frequency_sd [Hz]\n{modes}")),
        ],
    )
}

/// Frequency and its standard deviation, Hz, at every point and at one between that was not measured; ln
/// evidence; the temperature in use at the first point.
fn predicted(folder: &Folder) -> (Vec<[f64; 2]>, f64, f64) {
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    let model = run.saved("s").unwrap();
    let between = AskedPoint::new([("x".to_owned(), 0.95)].into(), Some("one".to_owned()));
    let (wider, new) = with_points(&study, &Selection::default(), &[between]).unwrap();
    let places: Vec<usize> = (0..POINTS.len()).chain(new).collect();
    let (found, lost) = forecast(&wider, &observations, &model, &[], &places).unwrap();
    assert!(lost.is_empty(), "{lost:?}");
    let hertz = found.iter().map(|f| [f.angular_frequency[0] / TAU, f.angular_frequency[2] / TAU]).collect();
    let (.., [_, kelvin]) = modes_at(&study, Some(&observations), Some(&model), 0, [None; 2]).unwrap();
    let unknown = stage.models[0].parameters.iter().find(|p| p.name == "t");
    let kelvin = unknown.map_or(kelvin, |t| 293.15 + t.value);
    // What the figure shows is the same to the last digit.
    let answer = run.answer(&run.study.plan.questions[0].clone()).unwrap();
    let table = &answer.frames[0];
    let column = |name: &str| table.columns.iter().position(|c| c.name == name).unwrap();
    for (row, f) in table.rows.iter().zip(&found) {
        let shown = ["predicted_angular_frequency", "model_angular_frequency_sd"]
            .map(|name| row.values[column(name)].unwrap());
        assert_eq!(format!("{shown:?}"), format!("{:?}", [f.angular_frequency[0], f.angular_frequency[2]]));
    }
    (hertz, stage.models[0].evidence.unwrap().ln_marginal, kelvin)
}

#[test]
fn oracle_predictions_have_what_one_day_tells_of_its_thermometer() {
    let (found, evidence, kelvin) = predicted(&folder("together-covariance", false));
    let (slow, slow_evidence, slow_kelvin) = predicted(&folder("together-unknown", true));
    assert!((evidence - slow_evidence).abs() < 1e-2, "{evidence} {slow_evidence}");
    assert_eq!(found.len(), POINTS.len() + 1);
    for ([value, sd], [wanted, wanted_sd]) in found.iter().zip(&slow) {
        assert!((value - wanted).abs() < 1e-2 * wanted_sd, "{found:?} {slow:?}");
        assert!((sd / wanted_sd - 1.0).abs() < 1e-2, "{found:?} {slow:?}");
        // The thermometer alone would leave ten times as much open.
        assert!(*sd < 0.06, "{found:?}");
    }
    assert!(
        (kelvin - slow_kelvin).abs() < 1e-2 * KELVIN_SD && kelvin > 293.15 + KELVIN_SD,
        "{kelvin} {slow_kelvin}"
    );
}
