//! Errors of a factor that all points share, on a tube whose frequencies have a closed form.

use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{AskedPoint, Run, Trusted, with_points};
use rijke_numerics::C64;
use rijke_study::Study;
use rijke_study::plan::Selection;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

const LENGTHS: [f64; 2] = [1.0, 0.8];
/// Standard deviation of a measured frequency, Hz.
const SD: f64 = 0.05;

fn folder(name: &str, plan: &str) -> Folder {
    // One ruler, a hundredth too long; the tubes are as long as they are written.
    let row = |(id, length): (&str, f64)| format!("{id},{:.9},{SD}\n", 1.01 * 0.5 * speed() / length);
    let rows: String = [("a", LENGTHS[0]), ("b", LENGTHS[1])].map(row).concat();
    Folder::new(
        &format!("common-{name}"),
        &[
            ("rig.toml", TUBE),
            ("campaign.csv", "point,x [cm],x_sd [cm],T_amb [degC]\na,100,1,20\nb,80,0.8,20\n"),
            ("study.toml", plan),
            ("observations/observations.toml", "kind = \"virtual\"\nsource = \"closed form\"\n"),
            ("observations/modes.csv", &format!("point,frequency [Hz],frequency_sd [Hz]\n{rows}")),
        ],
    )
}

fn plan(key: &str) -> String {
    format!(
        "name = \"t\"\n{key}\n[[stage]]\nid = \"s\"\npoints = {{}}\n[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n"
    )
}

fn ln_evidence(name: &str, key: &str) -> f64 {
    let folder = folder(name, &plan(key));
    let study = Study::open(&folder.0).unwrap();
    let mut run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
    run.next_stage().unwrap().unwrap().models[0].ln_evidence()
}

/// Residuals of frequencies, rad/s, where the error of the ruler is so many of its standard deviations.
fn residuals(error: f64) -> [f64; 2] {
    LENGTHS.map(|length| PI * speed() / length * (1.01 - 1.0 / (1.0 + 0.01 * error)))
}

/// What two errors of their own, and one that both tubes share, leave of both residuals; r does not enter a
/// frequency.
#[test]
fn exact_errors_that_all_points_share() {
    let sd = TAU * SD;
    let normal = |z: f64, sd: f64| (-0.5 * (z / sd).powi(2)).exp() / (sd * TAU.sqrt());
    // By the trapezoidal rule, which is exact for what dies out at both ends.
    let step = 1e-3;
    let over_errors = |of: &dyn Fn([f64; 2]) -> f64| -> f64 {
        let errors = (-6000..=6000).map(|k| step * f64::from(k));
        errors.map(|e| step * normal(e, 1.0) * of(residuals(e).map(|r| normal(r, sd)))).sum()
    };
    let shared = over_errors(&|both| both[0] * both[1]);
    let apart = over_errors(&|both| both[0]) * over_errors(&|both| both[1]);
    for (exact, key) in [(apart, ""), (shared, "common_errors = [\"x\"]")] {
        let found = ln_evidence(&exact.to_string(), key);
        assert!((found - exact.ln()).abs() < 1e-3, "{key}: {found} {}", exact.ln());
    }
}

/// Frequencies of tubes whose length is k times what a ruler reads: they tell k (1 + 0.2 e), where e is the
/// error of the ruler, and neither alone.
#[test]
fn exact_a_product_with_a_meter_tells_neither_of_the_two() {
    let rig =
        TUBE.replace("\"x\"", "\"$k*x\"") + "[unknown.k]\nprior = { normal = { mean = 1.0, sd = 5.0 } }\n";
    let lengths: Vec<f64> = (0..12).map(|i| 0.8 + 0.05 * f64::from(i)).collect();
    let rows = |of: &dyn Fn(usize, f64) -> String| -> String {
        lengths.iter().enumerate().map(|(i, x)| of(i, *x)).collect()
    };
    let points = rows(&|i, x| format!("p{i},{x},{},20\n", 0.2 * x));
    let heard = rows(&|i, x| format!("p{i},{:.9},0.02\n", 0.5 * speed() / x));
    let folder = Folder::new(
        "common-product",
        &[
            ("rig.toml", rig.as_str()),
            ("campaign.csv", &format!("point,x [m],x_sd [m],T_amb [degC]\n{points}")),
            ("study.toml", &plan("common_errors = [\"x\"]")),
            ("observations/observations.toml", "kind = \"virtual\"\nsource = \"closed form\"\n"),
            ("observations/modes.csv", &format!("point,frequency [Hz],frequency_sd [Hz]\n{heard}")),
        ],
    );
    let study = Study::open(&folder.0).unwrap();
    let mut run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    let model = &stage.models[0];
    let k = model.parameters.iter().find(|p| p.name == "k").unwrap();
    assert!((k.value - 1.0).abs() < 0.01 && (k.sd - 0.2).abs() < 0.01, "{k:?}");
    // Nothing is told of the ruler: its error keeps its prior.
    assert_eq!(model.remark, None);
}

/// Points of one installation share the error of their ruler, in eigenvalues and in mode shapes: as an
/// unknown of the rig with the same prior.
#[test]
fn oracle_errors_of_an_installation_move_modes_and_their_shapes_together() {
    let found = |name: &str, count: usize, unknown: bool| {
        let length = if unknown { "\"x*(1 + 0.003*$e)\"" } else { "\"x\"" };
        let e = if unknown { "[unknown.e]\nprior = { normal = { mean = 0.0, sd = 1.0 } }\n" } else { "" };
        let rig = TUBE.replace("\"x\"", length).replace("modulus = \"$r\"", "modulus = \"$r*g\"");
        let rig = format!("{rig}{e}[microphones]\nat = [0.1, 0.32, 0.71]\nreference = \"p2\"\n");
        let sd = if unknown { "0" } else { "0.003" };
        let points = (0..count).map(|i| format!("p{i},1.0,{sd},{},one,20\n", 1.0 - 0.02 * i as f64));
        let folder = Folder::new(
            name,
            &[
                ("rig.toml", rig.as_str()),
                (
                    "campaign.csv",
                    &format!(
                        "point,x [m],x_sd [m],g,installation,T_amb [degC]\n{}",
                        points.collect::<String>()
                    ),
                ),
                ("study.toml", &plan("").replace("points = {}\n", "points = {}\nbase_errors = true\n")),
                ("observations/observations.toml", "kind = \"virtual\"\nsource = \"made up\"\n"),
                ("observations/modes.csv", &modes(count)),
            ],
        );
        let study = Study::open(&folder.0).unwrap();
        let mut run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
        let stage = run.next_stage().unwrap().unwrap();
        let r = stage.models[0].parameters.iter().find(|p| p.name == "r").unwrap().clone();
        (stage.models[0].ln_evidence(), r.value, r.sd)
    };
    // So few that they are one block of data, and more.
    for count in [3, 12] {
        let (evidence, value, sd) = found(&format!("joint-{count}"), count, false);
        let (slow_evidence, slow_value, slow_sd) = found(&format!("joint-slow-{count}"), count, true);
        assert!((evidence - slow_evidence).abs() < 2e-2, "{count}: {evidence} {slow_evidence}");
        let said = format!("{count}: {value} {slow_value} {sd} {slow_sd}");
        assert!((value - slow_value).abs() < 0.05 * slow_sd && (sd / slow_sd - 1.0).abs() < 0.01, "{said}");
    }
}

/// Modes of a tube 0.4 % longer than the ruler says, as a rig without errors has them, and scatter.
fn modes(count: usize) -> String {
    let mut table = String::from(
        "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz],\
         p1_re,p1_re_sd,p1_im,p1_im_sd,p3_re,p3_re_sd,p3_im,p3_im_sd\n",
    );
    for i in 0..count {
        let (length, r) = (1.004, 0.9 * (1.0 - 0.02 * i as f64));
        let s = C64::new(r.ln(), PI) * speed() / length;
        // Both ends reflect -r: p = exp(-s x/c) - r exp(s x/c).
        let pressure = |x: f64| (-s * x / speed()).exp() - r * (s * x / speed()).exp();
        let [p1, p3] = [0.1, 0.71].map(|x| pressure(x) / pressure(0.32));
        let scatter = [0.3, -0.8, 0.5][i % 3];
        table += &format!(
            "p{i},{},0.2,{},0.05,{},1e-3,{},1e-3,{},1e-3,{},1e-3\n",
            s.re + 0.2 * scatter,
            s.im / TAU - 0.05 * scatter,
            p1.re + 1e-3 * scatter,
            p1.im - 1e-3 * scatter,
            p3.re - 5e-4 * scatter,
            p3.im + 8e-4 * scatter
        );
    }
    table
}

/// Gas 30 K warmer than a thermometer of 12 K says: the error of the gas as an unknown temperature of the rig
/// with the same prior.
#[test]
fn oracle_gas_far_from_its_thermometer_as_an_unknown_temperature() {
    let found = |name: &str, unknown: bool| {
        let gas = match unknown {
            true => "temperature = \"$hot\"",
            false => "temperature = \"293.15 K\"\ntemperature_sd = \"12 K\"",
        };
        let hot = "[unknown.hot]\nunit = \"K\"\nprior = { normal = { mean = 293.15, sd = 12.0 } }\n";
        let rig = TUBE.replace("length = \"x\"", &format!("length = \"x\"\n{gas}"));
        let rig = format!("{rig}{}", if unknown { hot } else { "" });
        let speed = speed() * (323.15_f64 / 293.15).sqrt();
        let rows = |of: &dyn Fn(usize, f64) -> String| -> String {
            (0..6).map(|i| of(i, 0.8 + 0.1 * i as f64)).collect()
        };
        let heard = rows(&|i, x| {
            let scatter = [0.5, -0.7, 0.2][i % 3];
            let growth = speed * 0.9_f64.ln() / x + 0.01 * scatter;
            format!("p{i},{growth},0.01,{},0.02\n", 0.5 * speed / x - 0.02 * scatter)
        });
        let folder = Folder::new(
            name,
            &[
                ("rig.toml", rig.as_str()),
                ("campaign.csv", &format!("point,x [m]\n{}", rows(&|i, x| format!("p{i},{x}\n")))),
                (
                    "study.toml",
                    &plan("base = \"rig\"").replace("points = {}\n", "points = {}\nbase_errors = true\n"),
                ),
                ("observations/observations.toml", "kind = \"virtual\"\nsource = \"closed form\"\n"),
                (
                    "observations/modes.csv",
                    &format!(
                        "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n{heard}"
                    ),
                ),
            ],
        );
        let study = Study::open(&folder.0).unwrap();
        let mut run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
        let stage = run.next_stage().unwrap().unwrap();
        let r = stage.models[0].parameters.iter().find(|p| p.name == "r").unwrap().clone();
        (stage.models[0].ln_evidence(), r.value, r.sd)
    };
    let (evidence, value, sd) = found("far-error", false);
    let (slow_evidence, slow_value, slow_sd) = found("far-unknown", true);
    let said = format!("{evidence} {slow_evidence}, r = {value} {slow_value} +- {sd} {slow_sd}");
    assert!((evidence - slow_evidence).abs() < 0.02, "{said}");
    assert!((value - slow_value).abs() < 0.05 * slow_sd && (sd / slow_sd - 1.0).abs() < 0.01, "{said}");
}

/// A ruler that is wrong by a share of what it reads is so at lengths that no point of the campaign has.
#[test]
fn exact_a_meter_has_its_share_of_any_value() {
    for (sds, expected) in [([1.0, 0.8], [0.009, 0.012, 0.0]), ([0.5, 0.5], [0.005; 3])] {
        let folder = folder("between", &plan("common_errors = [\"x\"]"));
        let table = format!("point,x [cm],x_sd [cm],T_amb [degC]\na,100,{},20\nb,80,{},20\n", sds[0], sds[1]);
        std::fs::write(folder.0.join("campaign.csv"), table).unwrap();
        let study = Study::open(&folder.0).unwrap();
        let asked = [0.9, 1.2, 0.0].map(|x| AskedPoint::new(BTreeMap::from([("x".to_owned(), x)]), None));
        let (wider, places) = with_points(&study, &Selection::default(), &asked).unwrap();
        for (place, expected) in places.iter().zip(expected) {
            let sd = wider.campaign.points[*place].factor_sds[0];
            assert!((sd - expected).abs() < 1e-12, "{sd} {expected}");
        }
    }
}

#[test]
fn message_a_factor_without_errors_has_none_in_common() {
    let folder = folder("message", &plan("common_errors = [\"T_amb\"]"));
    let said = Study::open(&folder.0).unwrap_err().to_string();
    assert!(said.contains("study.toml, line 2") && said.contains("`T_amb`") && said.ends_with("x"), "{said}");
}
