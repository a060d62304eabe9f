//! What a stage hands on whose posterior is no Gaussian: every maximum of it, and a word where one is bent.

use super::{ORIGIN, PLAN, two_points};
use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{Run, StageRecord, Trusted, foresight};
use rijke_study::Study;
use std::f64::consts::PI;

const RIG: &str = "name = 't'\n[gas]\ntemperature = 293.15\n[search]\ngrowth_rate = [-400, 400]\nfrequency_hz = [10, 1500]\n\
                   [upstream]\ntype = 'free'\n[downstream]\ntype = 'free'\n[[element]]\nname = 'tube'\ntype = 'duct'\nlength = 1.0\ndiameter = 0.05\n";

const STAGES: &str = "name = 't'\nbase = 'ambient'\n\
                      [[stage]]\nid = 'cold'\npoints = { rows = ['cold'] }\ncompete = 'e'\nwith = { x = 'x.none' }\nNOISE\
                      [[stage]]\nid = 'hot'\npoints = { rows = ['hot'] }\non = 'cold'\ncompete = 'x'\nNOISE";

/// A mouth of which the first stage knows the size of `law` only, and an inlet that may take something where
/// sw is not 0.
fn candidates(parameters: &str, law: &str) -> String {
    format!(
        "[[candidate]]\nid = 'e.1'\nrole = 'e'\nname = 'mouth'\ncite = ['none']\n{parameters}\
         [[candidate.effect]]\nacts_at = 'downstream'\nreflection = '-(1 - ({law}))'\n\
         [[candidate]]\nid = 'x.none'\nrole = 'x'\nname = 'rigid'\ncite = ['none']\n\
         [[candidate.effect]]\nacts_at = 'upstream'\nreflection = '1'\n\
         [[candidate]]\nid = 'x.loss'\nrole = 'x'\nname = 'lossy'\ncite = ['none']\n\
         parameters.y = {{ symbol = 'y', unit = '1', prior = {{ normal = {{ mean = 0.0, sd = 0.05 }} }} }}\n\
         [[candidate.effect]]\nacts_at = 'upstream'\nreflection = '1 - 10*sw*y'\n"
    )
}

fn parameter(name: &str, mean: f64, sd: f64) -> String {
    format!(
        "parameters.{name} = {{ symbol = '{name}', unit = '1', prior = {{ normal = {{ mean = {mean}, sd = {sd} }} }} }}\n"
    )
}

/// Growth rates at sw = 0 and 0.1 with their standard deviations, and a frequency that tells nothing.
fn folder(name: &str, candidates: &str, growth: [[f64; 2]; 2]) -> Folder {
    let hertz = speed() / 4.0;
    let row = |(id, [g, sd]): (&str, [f64; 2])| format!("{id},{g:.12},{sd},{hertz:.9},5\n");
    let rows: String = ["c1", "h1"].into_iter().zip(growth).map(row).collect();
    let noise = "[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\npressure = 0.0\n";
    Folder::new(
        name,
        &[
            ("rig.toml", RIG),
            ("campaign.csv", "point,row,sw,T_amb [K]\nc1,cold,0,293.15\nh1,hot,0.1,293.15\n"),
            ("candidates/all.toml", candidates),
            ("study.toml", &STAGES.replace("NOISE", noise)),
            ("observations/observations.toml", ORIGIN),
            (
                "observations/modes.csv",
                &format!(
                    "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n{rows}"
                ),
            ),
        ],
    )
}

/// The stages, with all maxima looked for.
fn ranked(folder: &Folder) -> [StageRecord; 2] {
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Checked).unwrap();
    [0, 1].map(|_| run.next_stage().unwrap().unwrap())
}

/// ln of the modulus of both reflections makes the growth rate of a tube of one metre.
fn growth(ln_reflections: f64) -> f64 {
    0.5 * speed() * ln_reflections
}

/// The first stage knows b^2, which has two signs of b; the second b^2 + b/10. Against a sum over b and y.
#[test]
fn oracle_both_signs_of_a_parameter_go_on_to_the_next_stage() {
    let sds = [0.3, 1.3];
    let measured = [growth((1.0_f64 - 0.04).ln()), growth((1.0_f64 - 0.06).ln())];
    let law = candidates(&parameter("b", -0.05, 0.3), "b^2 + sw*b");
    let stages = ranked(&folder("two-signs", &law, [0, 1].map(|k| [measured[k], sds[k]])));
    let ln = |id: &str| stages[1].models.iter().find(|m| m.id == id).unwrap().evidence.unwrap().ln_marginal;
    let normal = |x: f64, sd: f64| -0.5 * (x / sd).powi(2) - (sd * (2.0 * PI).sqrt()).ln();
    // Less what the frequencies have in common.
    let sum = |loss: bool| -> f64 {
        let (steps, mut all) = (4000, 0.0);
        for i in 0..steps {
            let b = -0.8 + 1.5 * f64::from(i) / f64::from(steps);
            let first = normal(growth((1.0 - b * b).ln()) - measured[0], sds[0]) + normal(b + 0.05, 0.3);
            if first < -60.0 {
                continue;
            }
            let here = |y: f64| {
                let ln = (1.0 - b * b - 0.1 * b).ln() + (1.0 - y).ln();
                (first + normal(growth(ln) - measured[1], sds[1])).exp()
            };
            let over = |y: f64| here(y) * normal(y, 0.05).exp() * 1e-3;
            all += if loss { (-250..250).map(|k| over(1e-3 * f64::from(k))).sum() } else { here(0.0) };
        }
        all.ln()
    };
    let (found, exact) = (ln("x.none") - ln("x.loss"), sum(false) - sum(true));
    assert!(exact > 0.8 && (found - exact).abs() < 0.3, "{found} {exact}");
    let none = stages[1].models.iter().find(|m| m.id == "x.none").unwrap();
    let b = none.parameters.iter().find(|p| p.name == "b").unwrap();
    assert!((b.value - 0.2).abs() < 0.02, "{b:?}");
}

/// The first stage knows the product of two parameters, the second one of them: along the hyperbola the
/// Gaussian of the first is not valid.
#[test]
fn message_a_bent_posterior_that_was_handed_on_is_said() {
    let both = parameter("a", 1.0, 0.45) + &parameter("b", 0.05, 0.03);
    let growth = [[growth((1.0_f64 - 0.05).ln()), 0.1], [growth((1.0_f64 - 0.009).ln()), 0.02]];
    let law = candidates(&both, "a*b*(1 - 10*sw) + sw*b");
    let stages = ranked(&folder("bent", &law, growth));
    let row = stages[1].models.iter().find(|m| m.id == "x.none").unwrap();
    let said = row.remark.clone().unwrap_or_default();
    assert!(said.contains("the Gaussian posterior of stage `cold` is not valid"), "{said}");
    assert!(!stages[0].models[0].remark.clone().unwrap_or_default().contains("the Gaussian posterior"));
}

/// The first stage knows the sum of two positive parameters, the second one of them. The sum is straight in
/// both, and bent in their logarithms, in which the Gaussian is one.
#[test]
fn message_a_posterior_that_is_bent_in_the_coordinates_of_its_priors_is_said() {
    let positive = |name: &str| {
        format!(
            "parameters.{name} = {{ symbol = '{name}', unit = '1', prior = {{ log_normal = {{ median = 0.03, ln_sd = 0.7 }} }} }}\n"
        )
    };
    let both = positive("a") + &positive("b");
    let remark = |name: &str, measured: f64| {
        let growth = [[growth((1.0_f64 - 0.06).ln()), 0.1], [growth((1.0_f64 - measured).ln()), 0.02]];
        let stages = ranked(&folder(name, &candidates(&both, "a*(1 - 10*sw) + b"), growth));
        let row = stages[1].models.iter().find(|m| m.id == "x.none").unwrap();
        row.remark.clone().unwrap_or_default()
    };
    let said = remark("bent-in-logarithms", 0.004);
    assert!(said.contains("the Gaussian posterior of stage `cold` is not valid"), "{said}");
    let said = remark("straight-in-logarithms", 0.03);
    assert!(!said.contains("the Gaussian posterior"), "{said}");
}

/// Growth rates tell r by c/(L r) at each of two points; a second stage with as many adds as much.
#[test]
fn exact_foresight_adds_what_earlier_stages_tell() {
    let stage = "[[stage]]\nid = \"t\"\npoints = {}\non = \"s\"\n[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n";
    let folder = two_points("foresight-on", &[("study.toml", &format!("{PLAN}{stage}"))]);
    let study = Study::open(&folder.0).unwrap();
    let found = foresight(&study, None, [4.0, 1.0, 1e-3], 293.15).unwrap();
    let told: f64 = [1.0, 0.8].iter().map(|length| (speed() / (length * 0.9) * 0.2 / 4.0).powi(2)).sum();
    for (stage, times) in found.iter().zip([1.0, 2.0]) {
        let [(_, width)] = &stage.models[0].widths[..] else { panic!("{:?}", stage.models) };
        let exact = (1.0 + times * told).sqrt().recip();
        assert!((width / exact - 1.0).abs() < 1e-6, "{}: {width} {exact}", stage.id);
    }
    assert_eq!(found.len(), 2);
}

#[test]
fn message_a_parameter_held_far_from_what_was_found_is_said() {
    let law = candidates(&parameter("b", 0.05, 0.3), "b");
    let measured = [growth((1.0_f64 - 0.04).ln()), growth((1.0_f64 - 0.2).ln())];
    let said = |name: &str, held: f64| {
        let folder = folder(name, &law, measured.map(|g| [g, 0.3]));
        let path = folder.0.join("study.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        let text = text.replace("on = 'cold'", &format!("on = 'cold'\nhold = {{ b = {held} }}"));
        std::fs::write(&path, text).unwrap();
        ranked(&folder)[1].doubts_of_data().into_iter().filter(|said| said.contains("holds `b`")).collect()
    };
    let far: Vec<String> = said("held-far", 0.2);
    assert!(far.len() == 1 && far[0].contains("at 0.2") && far[0].contains("0.0400 +- 0.0017"), "{far:?}");
    // Growth rates know it to 0.3/(c/2).
    let deviations = 0.16 / (0.3 / (0.5 * speed()) * 0.96);
    assert!(far[0].contains(&format!("{deviations:.0} standard deviations")), "{far:?}");
    assert_eq!(said("held-near", 0.041), Vec::<String>::new());
}

#[test]
fn exact_foresight_knows_what_frequencies_cannot_tell() {
    let two = TUBE.replace(
        "[upstream]\ntype = \"constant\"\nmodulus = \"$r\"",
        "[upstream]\ntype = \"constant\"\nmodulus = \"$q\"",
    );
    let two = format!("{two}[unknown.q]\nprior = {{ normal = {{ mean = 0.9, sd = 0.2 }} }}\n");
    let folder = two_points("foresight", &[("rig.toml", &two)]);
    let study = Study::open(&folder.0).unwrap();
    let found = foresight(&study, None, [0.1, 1.0, 1e-3], 293.15).unwrap();
    let model = &found[0].models[0];
    // Only the product of both ends enters s: r + q is found, r - q keeps all of its prior.
    let [(words, share)] = &model.unidentified[..] else { panic!("{model:?}") };
    assert!((share - 1.0).abs() < 1e-6 && words.contains("0.71 q") && words.contains("0.71 r"), "{words}");
    assert!(model.widths.iter().all(|(_, w)| (w - 0.5_f64.sqrt()).abs() < 1e-3), "{model:?}");
    // By growth rates that are hardly known, one number keeps nearly all of its width: of a single parameter
    // the share is its width.
    let folder = two_points("foresight-coarse", &[]);
    let found = foresight(&Study::open(&folder.0).unwrap(), None, [385.0, 1e4, 1.0], 293.15).unwrap();
    let model = &found[0].models[0];
    let ([(_, share)], [(_, width)]) = (&model.unidentified[..], &model.widths[..]) else {
        panic!("{model:?}")
    };
    assert!((0.9..0.98).contains(width) && (share - width).abs() < 1e-12, "{share} {width}");
}
