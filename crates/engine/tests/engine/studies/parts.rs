//! Questions about the posterior of a stage: a coefficient at every point by itself, and sets of microphones.

use super::{ORIGIN, PLAN, parameter, two_points};
use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{Answer, Run, StageRecord, Trusted};
use rijke_numerics::{Cholesky, Matrix};
use rijke_study::Study;

const HEAD: &str = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";

/// The first stage, and the answer to the first question.
fn answered(folder: &Folder) -> (StageRecord, Answer) {
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    (stage, run.answer(&study.plan.questions[0]).unwrap())
}

/// Between -q and -b a tube of length L has s = c (ln(q b)/2 + i pi)/L, so that a growth rate that is known
/// to an sd tells b to 2 L b/c of it. At every point b is another, and the b of the stage is taken away.
#[test]
fn exact_a_coefficient_at_every_point_is_that_of_the_point_alone() {
    let (q, free) = (0.85_f64, [0.8, 0.7]);
    let end = "type = \"constant\"\nmodulus = \"$r\"\nangle = \"180 deg\"\n[[element]]";
    let rig = TUBE.replace(end, "type = \"free\"\n[[element]]").replace("\"$r\"", "0.85");
    let rig = rig.split("[unknown.r]").next().unwrap();
    let candidate = |role: &str| {
        format!(
            "[[candidate]]\nid = \"{role}.b\"\nrole = \"{role}\"\nname = \"b\"\ncite = [\"closed form\"]\n\
             parameters.b_{role} = {{ prior = {{ normal = {{ mean = 0.75, sd = 0.2 }} }} }}\n\
             [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"-b_{role}\"\n"
        )
    };
    let plan = format!(
        "{PLAN}[stage.with]\nmouth = \"mouth.b\"\n[[ask]]\nid = \"b\"\nask = \"point-by-point\"\nstage = \"s\"\n\
         with = {{ other = \"other.b\" }}\nwithout = [\"mouth\"]\nnoise = {{ growth_rate = 0.0, angular_frequency = 0.0 }}\n"
    );
    let row = |(id, length, b): (&str, f64, f64)| {
        let (sigma, hertz) = (0.5 * speed() * (q * b).ln() / length, 0.5 * speed() / length);
        format!("{id},{sigma:.12},0.1,{hertz:.12},0.05\n")
    };
    let modes = HEAD.to_owned() + &[("a", 1.0, free[0]), ("b", 0.8, free[1])].map(row).concat();
    let candidates = candidate("mouth") + &candidate("other");
    let files = [
        ("rig.toml", rig),
        ("candidates/ends.toml", &candidates),
        ("study.toml", &plan),
        ("observations/modes.csv", &modes),
    ];
    let (_, answer) = answered(&two_points("by-point", &files));
    let frame = &answer.frames[0];
    assert_eq!(frame.rows.len(), 2);
    for ((row, length), b) in frame.rows.iter().zip([1.0, 0.8]).zip(free) {
        let number = |name: &str| row.values[frame.column(name).unwrap()].unwrap();
        let sd = 0.1 * 2.0 * length * b / speed();
        // The prior pulls by a share of (sd/0.2)^2.
        assert!((number("modulus") - b).abs() < 0.01 * sd, "{row:?} {b}");
        assert!((number("modulus_sd") / sd - 1.0).abs() < 1e-3, "{row:?} {sd}");
        assert!((number("real") + b).abs() < 0.01 * sd && number("imaginary").abs() < 1e-9, "{row:?}");
    }
}

/// Of two ends the growth rates tell ln(q r)/2 alone: precisions add up, of the prior and of c/(2 L r) of
/// every point. The ellipse that is drawn takes its numbers from these columns.
#[test]
fn exact_contours_have_the_covariance_of_two_ends() {
    let two = TUBE.replacen("\"$r\"", "\"$q\"", 1);
    let two = format!("{two}[unknown.q]\nprior = {{ normal = {{ mean = 0.9, sd = 0.2 }} }}\n");
    let plan = format!("{PLAN}[[ask]]\nid = \"c\"\nask = \"contours\"\nstage = \"s\"\nsets = [[]]\n");
    let row = |(id, length): (&str, f64)| {
        format!("{id},{:.12},0.1,{:.12},0.05\n", speed() * 0.9_f64.ln() / length, 0.5 * speed() / length)
    };
    let modes = HEAD.to_owned() + &[("a", 1.0), ("b", 0.8)].map(row).concat();
    let files = [
        ("rig.toml", two.as_str()),
        ("study.toml", &plan),
        ("observations/modes.csv", &modes),
        ("observations/observations.toml", ORIGIN),
    ];
    let (stage, answer) = answered(&two_points("contours", &files));
    let told: f64 = [1.0, 0.8].map(|length: f64| (speed() / (2.0 * length * 0.9) / 0.1).powi(2)).iter().sum();
    let precision = Matrix::from_fn(2, 2, |i, j| told + if i == j { 25.0 } else { 0.0 });
    let covariance = Cholesky::new(&precision).unwrap().inverse();
    let layer = &answer.panels[0].layers[0];
    let values = &answer.frames[layer.frame].rows[0].values;
    for (place, expected) in [
        (layer.x, 0.9),
        (layer.y, 0.9),
        (layer.x + 1, covariance[(0, 0)].sqrt()),
        (layer.y + 1, covariance[(1, 1)].sqrt()),
        (layer.sd.unwrap(), covariance[(0, 1)]),
    ] {
        let found = values[place].unwrap();
        assert!((found / expected - 1.0).abs() < 2e-3, "{place}: {found} {expected}");
    }
    assert!((parameter(&stage, "q")[1] / covariance[(0, 0)].sqrt() - 1.0).abs() < 2e-3);
}
