//! Questions: what their keys are, and what they refuse.

use super::{PLAN, closed_form, two_points};
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{Run, Trusted, keys_of_questions, open};
use rijke_numerics::C64;
use rijke_study::Study;

/// The manual shows every kind of question with every key.
#[test]
fn behaviour_the_manual_shows_every_key_of_every_question() {
    let manual = include_str!("../../../../../docs/study-folder.md");
    let section = manual.split("### Questions").nth(1).unwrap().split("\n### ").next().unwrap();
    let kinds: Vec<_> = keys_of_questions().collect();
    assert!(kinds.len() > 4, "{kinds:?}");
    for (kind, keys) in kinds {
        let shown = section.split("[[ask]]").find(|block| block.contains(&format!("ask = \"{kind}\"")));
        let shown = shown.unwrap_or_else(|| panic!("the manual does not show `{kind}`"));
        for key in keys {
            let there = shown.contains(&format!("\n{key} = ")) || shown.contains(&format!("\n[ask.{key}]"));
            assert!(there, "the manual does not show `{key}` of `{kind}`");
        }
    }
}

fn refused(name: &str, asked: &str) -> String {
    let plan = format!("{PLAN}[[ask]]\nid = \"q\"\nstage = \"s\"\n{asked}");
    let folder = two_points(name, &[("study.toml", &plan)]);
    let error = open(&folder.0).unwrap_err().to_string();
    // Whoever opens a study without looking at its questions is told before anything is trained.
    if let Ok(study) = Study::open(&folder.0) {
        let observations = study.observations().unwrap();
        let late = Run::new(study, &observations, Trusted::Laplace).err().unwrap().to_string();
        assert_eq!(late, error);
    }
    error.rsplit_once("study.toml, ").unwrap().1.to_owned()
}

#[test]
fn message_a_question_that_cannot_be_asked_names_line_and_what_is_known() {
    let cases = [
        (
            "ask = \"contour\"",
            "line 8: there is no kind of question called `contour`; did you mean `contours`? Known: ranking, contours, ",
        ),
        (
            "ask = \"ranking\"\nsets = []",
            "line 12: there is no key called `sets` of `ask = \"ranking\"`; known: none",
        ),
        (
            "ask = \"contours\"\n\nset = []",
            "line 13: there is no key called `set` of `ask = \"contours\"`; known: sets",
        ),
        ("ask = \"contours\"\nsets = [[\"p9\"]]", "line 8: there is no microphone called `p9`; known: none"),
        ("ask = \"contours\"\nsets = 3", "line 12: 3 stands where a list in brackets is needed"),
        (
            "ask = \"prediction\"\npoints = { points = [\"z\"] }",
            "line 8: there is no operating point called `z`; known: a, b",
        ),
        (
            "ask = \"point-by-point\"",
            "line 8: `with` is missing; name the role and the candidate that is free at every point",
        ),
        (
            "ask = \"point-by-point\"\nwith = { wall = \"w\" }",
            "line 8: there is no candidate called `w`; known: none",
        ),
        ("ask = \"effects\"\nof = [\"wall\"]", "line 8: there is no candidate; write the laws"),
        ("ask = \"law\"", "line 8: `role` is missing; name the role whose law is shown"),
        ("ask = \"law\"\nrole = \"wall\"", "line 8: there is no candidate; write the laws"),
        ("ask = \"ranking\"\nover = \"y\"", "line 8: there is no factor called `y`; known: x"),
    ];
    for (k, (asked, expected)) in cases.iter().enumerate() {
        let said = refused(&format!("question-{k}"), asked);
        assert!(said.starts_with(expected), "{said}");
    }
}

/// A drag along the tube, mu = k: with Z = s rho + k and Y = s/(rho c^2) the ends, which are
/// z = rho c (1 - r)/(1 + r), reflect q = (z - Z_c)/(z + Z_c), and q^2 e^{-2 gamma L} = 1.
#[test]
fn exact_the_effect_of_a_loss_is_the_closed_form() {
    const DRAG: f64 = 3.0;
    let candidate = "[[candidate]]\nid = \"drag\"\nrole = \"wall\"\nname = \"drag\"\ncite = [\"closed form\"]\n\
        [candidate.parameters.k]\nunit = \"kg/(m^3 s)\"\nprior = { normal = { mean = 3.0, sd = 0.3 } }\n\
        [[candidate.effect]]\nacts_at = \"tube\"\nmu = \"k\"\n";
    let plan = format!(
        "{PLAN}[stage.with]\nwall = \"drag\"\n[stage.hold]\nr = 0.85\n[[ask]]\nid = \"e\"\nask = \"effects\"\nstage = \"s\"\n"
    );
    let density = 101_325.0 / (287.05 * 293.15);
    let with = |length: f64, k: f64| {
        let [sigma, hertz] = closed_form(length);
        let c = speed();
        let s0 = C64::new(sigma, std::f64::consts::TAU * hertz);
        let (half, z) = (0.5 * k / density, 0.15 / 1.85);
        let mut s = s0;
        for _ in 0..50 {
            // Z_c over rho c.
            let own = (1.0 + k / (s * density)).sqrt();
            let gamma = (((own - z) / (own + z)).ln() + C64::new(0.0, std::f64::consts::PI)) / length;
            // s^2 + s k/rho = (gamma c)^2; the root of the upper half plane.
            let root = (gamma * gamma * c * c + half * half).sqrt();
            s = root * root.im.signum() - half;
        }
        s - s0
    };
    let row = |id: &str, length: f64| {
        let ([sigma, hertz], moved) = (closed_form(length), with(length, DRAG));
        let (sigma, hertz) = (sigma + moved.re, hertz + moved.im / std::f64::consts::TAU);
        format!("{id},{sigma:.12},0.1,{hertz:.12},0.05\n")
    };
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let modes = format!("{head}{}{}", row("a", 1.0), row("b", 0.8));
    let files =
        [("candidates/wall.toml", candidate), ("study.toml", &plan), ("observations/modes.csv", &modes)];
    let folder = two_points("effects", &files);
    let study = open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    let [k, k_sd] = super::parameter(&stage, "k");
    assert!((k - DRAG).abs() < 1e-6 && k_sd > 0.0, "{k} +- {k_sd}");
    let answer = run.answer(&study.plan.questions[0]).unwrap();
    let frame = &answer.frames[0];
    assert_eq!((frame.rows.len(), answer.panels.len(), frame.rows[0].series.as_str()), (2, 2, "drag"));
    for (row, length) in frame.rows.iter().zip([1.0, 0.8]) {
        let number = |name: &str| row.values[frame.column(name).unwrap()].unwrap();
        let (expected, step) = (with(length, k), 1e-4);
        let slope = (with(length, k + step) - with(length, k - step)) / (2.0 * step);
        assert!((number("growth_rate_effect") - expected.re).abs() < 1e-7, "{row:?} {expected}");
        assert!((number("angular_frequency_effect") - expected.im).abs() < 1e-7, "{row:?} {expected}");
        assert!((number("growth_rate_effect_sd") / (slope.re.abs() * k_sd) - 1.0).abs() < 1e-6, "{row:?}");
        assert!(
            (number("angular_frequency_effect_sd") / (slope.im.abs() * k_sd) - 1.0).abs() < 1e-6,
            "{row:?}"
        );
    }
}

/// An end that reflects a R_LS e^{-s tau}: modulus a |R_LS|, phase arg R_LS - omega tau, each with the
/// standard deviation of its own parameter.
#[test]
fn exact_a_law_over_frequency_is_the_closed_form() {
    let end = "type = \"constant\"\nmodulus = \"$r\"\nangle = \"180 deg\"\n[[element]]";
    let rig = TUBE.replace(end, "type = \"free\"\n[[element]]");
    let candidate = "[[candidate]]\nid = \"mouth.late\"\nrole = \"mouth\"\nname = \"late\"\ncite = [\"closed form\"]\n\
        parameters.a = { unit = \"1\", prior = { normal = { mean = 0.9, sd = 0.1 } } }\n\
        parameters.tau = { unit = \"s\", prior = { normal = { mean = 1e-4, sd = 1e-4 } } }\n\
        [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"a*R_LS*exp(-s*tau)\"\n";
    let plan = format!(
        "{PLAN}[stage.with]\nmouth = \"mouth.late\"\n[[ask]]\nid = \"l\"\nask = \"law\"\nrole = \"mouth\"\nstage = \"s\"\n\
         frequency_hz = [50, 900]\nper = \"2*A\"\n\
         [[ask]]\nid = \"m\"\nask = \"law\"\nrole = \"mouth\"\nstage = \"s\"\nfrequency_hz = [4700, 4800]\nper = \"-2*A\"\n"
    );
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let modes = format!("{head}a,-70,1,168,0.1\nb,-90,1,209,0.1\n");
    let files = [
        ("rig.toml", rig.as_str()),
        ("candidates/mouth.toml", candidate),
        ("study.toml", &plan),
        ("observations/modes.csv", &modes),
    ];
    let folder = two_points("law", &files);
    let study = open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    let ([a, a_sd], [tau, tau_sd]) = (super::parameter(&stage, "a"), super::parameter(&stage, "tau"));
    let answer = run.answer(&study.plan.questions[0]).unwrap();
    let (curve, dots) = (&answer.frames[0], &answer.frames[1]);
    // Both points have one end: one curve, and the mode of the first point on it.
    assert_eq!((curve.rows.len(), dots.rows.len(), answer.panels.len()), (201, 1, 2));
    let (diameter, c) = (0.05_f64, speed());
    let per = 2.0 * 0.25 * std::f64::consts::PI * diameter * diameter;
    for row in curve.rows.iter().chain(&dots.rows) {
        let number = |name: &str| row.values[curve.column(name).unwrap()].unwrap();
        let omega = std::f64::consts::TAU * number("frequency");
        let end = rijke_network::levine_schwinger::reflection(C64::new(0.5 * diameter * omega / c, 0.0))[0];
        let phase = (-end).arg() + std::f64::consts::PI - omega * tau;
        let near = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-9 * expected.abs(), "{row:?}: {found} {expected}");
        };
        near(number("modulus"), a * end.norm() / per);
        near(number("modulus_sd"), a_sd * end.norm() / per);
        near(number("phase").rem_euclid(std::f64::consts::TAU), phase.rem_euclid(std::f64::consts::TAU));
        near(number("phase_sd"), omega * tau_sd);
        assert!((number("phase") + omega * tau).abs() < 4.0, "a phase that jumps: {row:?}");
    }
    // The first phase of a curve lies within half a turn of zero.
    let curve = &run.answer(&study.plan.questions[1]).unwrap().frames[0];
    let phase = curve.rows[0].values[curve.column("phase").unwrap()].unwrap();
    let omega = std::f64::consts::TAU * 4700.0;
    let end = rijke_network::levine_schwinger::reflection(C64::new(0.5 * diameter * omega / c, 0.0))[0];
    let expected = (-end * C64::from_polar(1.0, -omega * tau)).arg();
    assert!((phase - expected).abs() < 1e-9 && expected < -2.5, "{phase} {expected}");
}
