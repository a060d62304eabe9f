//! Errors of one assembly of the rig that two stages have points of: the chain against all data at once.
//!
//! The rig is a tube of length L without losses, closed at one end, whose other end reflects -exp(-a - k b):
//! its growth rate is -c (a + k b)/(2 L), linear in a and b, so that everything is known in closed form.

use super::ORIGIN;
use crate::common::folder::Folder;
use rijke_engine::run::{Run, Trusted};
use rijke_numerics::{C64, Cholesky, Matrix};
use rijke_study::Study;
use std::f64::consts::PI;

const PRIORS: [[f64; 2]; 2] = [[0.1, 0.05], [0.05, 0.03]];
/// Stage, installation, k, growth rate (1/s) and its standard deviation.
const POINTS: [(&str, &str, f64, f64, f64); 7] = [
    ("first", "x", 0.0, -22.0, 1.0),
    ("first", "x", 1.0, -34.0, 1.2),
    ("first", "y", 1.0, -29.0, 1.0),
    ("first", "z", 0.5, -24.0, 0.8),
    ("second", "x", 2.0, -47.0, 1.0),
    ("second", "y", 2.5, -41.0, 1.5),
    ("second", "w", 3.0, -55.0, 1.0),
];

fn sound_speed() -> f64 {
    (1.4_f64 * 287.0 * 293.15).sqrt()
}

/// Growth rate per a.
fn rate() -> f64 {
    -sound_speed() / 1.6
}

fn folder(name: &str, noise: &str) -> Folder {
    heard(name, noise, &|_| None)
}

/// A microphone beside that at the rigid end, and the standard deviation of its relative pressure: of a mode
/// it is cosh(s x/c), as good a measurement of the growth rate as the decay.
const HEARD_AT: f64 = 0.5;
const HEARD_SD: f64 = 1e-3;

/// As [`folder`], with relative pressures of modes that grow as `growth` says of every point.
fn heard(name: &str, noise: &str, growth: &dyn Fn(usize) -> Option<f64>) -> Folder {
    let is_heard = growth(0).is_some();
    let stage = |id: &str, on: &str| {
        format!(
            "[[stage]]\nid = \"{id}\"\npoints = {{ rows = [\"{id}\"] }}\n{on}with = {{ end = \"end\" }}\nbase_errors = true\n\
             [stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n{noise}\n"
        )
    };
    let plan = format!(
        "name = \"t\"\nbase = \"rig\"\n{}{}",
        stage("first", ""),
        stage("second", "on = \"first\"\n")
    );
    let points: String = POINTS
        .iter()
        .enumerate()
        .map(|(i, (row, installation, k, ..))| format!("p{i},{row},{installation},{k}\n"))
        .collect();
    let hertz = sound_speed() / 3.2;
    let modes: String = POINTS
        .iter()
        .enumerate()
        .map(|(i, (_, _, _, rate, sd))| {
            let pressure = growth(i).map_or(String::new(), |growth| {
                let z = pressure(growth)[0];
                format!(",{},{HEARD_SD},{},{HEARD_SD}", z.re, z.im)
            });
            format!("p{i},{rate},{sd},{hertz},0.05{pressure}\n")
        })
        .collect();
    let (microphones, columns) = match is_heard {
        true => (format!("[microphones]\nat = [0, {HEARD_AT}]\n"), ",p2_re,p2_re_sd,p2_im,p2_im_sd"),
        false => (String::new(), ""),
    };
    let prior = |k: usize| format!("{{ normal = {{ mean = {}, sd = {} }} }}", PRIORS[k][0], PRIORS[k][1]);
    let candidate = format!(
        "[[candidate]]\nid = \"end\"\nrole = \"end\"\nname = \"end\"\ncite = [\"a test\"]\nparameters.a = {{ prior = {} }}\nparameters.b = {{ prior = {} }}\n\
         [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"-exp(-a - k*b)\"\n",
        prior(0),
        prior(1)
    );
    Folder::new(
        name,
        &[
            (
                "rig.toml",
                &format!(
                    "name = \"tube\"\n[gas]\ntemperature = 293.15\ngas_constant = 287.0\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"free\"\n\
                 [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = 0.8\ndiameter = 0.05\nwall = \"none\"\n{microphones}"
                ),
            ),
            ("campaign.csv", &format!("point,row,installation,k\n{points}")),
            ("candidates/end.toml", &candidate),
            ("study.toml", &plan),
            ("observations/observations.toml", ORIGIN),
            (
                "observations/modes.csv",
                &format!(
                    "point,growth_rate,growth_rate_sd,frequency [Hz],frequency_sd [Hz]{columns}\n{modes}"
                ),
            ),
        ],
    )
}

/// The relative pressure of a mode that grows so, and its slope in the growth rate.
fn pressure(growth: f64) -> [C64; 2] {
    let x = HEARD_AT / sound_speed();
    let z = C64::new(growth, 2.0 * PI * sound_speed() / 3.2) * x;
    [z.cosh(), x * z.sinh()]
}

/// ln density of the growth rates of these points, with the mean and the standard deviation of a and of b
/// after them; an installation changes its growth rates by `moves` per standard deviation.
fn by_hand(points: &[usize], moves: &dyn Fn(usize) -> f64) -> (f64, [[f64; 2]; 2]) {
    of(points, moves, &|a, b| POINTS[a].1 == POINTS[b].1)
}

/// As [`by_hand`], if an installation is another one in every stage.
fn by_hand_anew(points: &[usize], moves: &dyn Fn(usize) -> f64) -> (f64, [[f64; 2]; 2]) {
    of(points, moves, &|a, b| (POINTS[a].0, POINTS[a].1) == (POINTS[b].0, POINTS[b].1))
}

fn of(
    points: &[usize],
    moves: &dyn Fn(usize) -> f64,
    same: &dyn Fn(usize, usize) -> bool,
) -> (f64, [[f64; 2]; 2]) {
    of_numbers(&points.iter().map(|&p| (p, 1.0, POINTS[p].3, POINTS[p].4)).collect::<Vec<_>>(), moves, same)
}

/// As [`of`], of numbers that change by so much with the growth rate of a point: point, change, growth rate
/// that it says, and its own standard deviation.
fn of_numbers(
    numbers: &[(usize, f64, f64, f64)],
    moves: &dyn Fn(usize) -> f64,
    same: &dyn Fn(usize, usize) -> bool,
) -> (f64, [[f64; 2]; 2]) {
    let n = numbers.len();
    let slope = |i: usize, k: usize| numbers[i].1 * rate() * [1.0, POINTS[numbers[i].0].2][k];
    let covariance = Matrix::from_fn(n, n, |i, j| {
        let ((a, by_a, _, sd), (b, by_b, ..)) = (numbers[i], numbers[j]);
        let own = if i == j { sd * sd } else { 0.0 };
        let shared = if same(a, b) { by_a * moves(a) * by_b * moves(b) } else { 0.0 };
        own + shared + (0..2).map(|k| slope(i, k) * PRIORS[k][1].powi(2) * slope(j, k)).sum::<f64>()
    });
    let offset: Vec<f64> = (0..n)
        .map(|i| numbers[i].1 * numbers[i].2 - (0..2).map(|k| slope(i, k) * PRIORS[k][0]).sum::<f64>())
        .collect();
    let factor = Cholesky::new(&covariance).unwrap();
    let white = factor.whiten(&offset);
    let ln = -0.5 * (white.iter().map(|w| w * w).sum::<f64>() + factor.ln_det() + n as f64 * (2.0 * PI).ln());
    let after = [0, 1].map(|k| {
        let variance = PRIORS[k][1].powi(2);
        let column: Vec<f64> = (0..n).map(|i| slope(i, k) * variance).collect();
        let along = |v: &[f64]| column.iter().zip(v).map(|(c, v)| c * v).sum::<f64>();
        [PRIORS[k][0] + along(&factor.solve(&offset)), (variance - along(&factor.solve(&column))).sqrt()]
    });
    (ln, after)
}

/// The sum of ln evidences of the chain, less that of frequencies, and what it says of a and b in the end.
fn chain(folder: &Folder) -> (f64, [[f64; 2]; 2]) {
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let mut run = Run::new(study, &observations, Trusted::Laplace).unwrap();
    let first = run.next_stage().unwrap().unwrap();
    let second = run.next_stage().unwrap().unwrap();
    let of_frequencies = POINTS.len() as f64 * (-(0.05 * 2.0 * PI).ln() - 0.5 * (2.0 * PI).ln());
    let sum: f64 = [&first, &second].iter().map(|s| s.models[0].evidence.unwrap().ln_marginal).sum();
    let after = [0, 1].map(|k| [second.models[0].parameters[k].value, second.models[0].parameters[k].sd]);
    (sum - of_frequencies, after)
}

#[test]
fn oracle_an_assembly_of_two_stages_has_one_error() {
    let all: Vec<usize> = (0..POINTS.len()).collect();
    let by_k = |p: usize| 0.02 * rate() * POINTS[p].2;
    let varying = "varying = [{ parameter = \"b\", sd = 0.02 }]";
    let moves: [&dyn Fn(usize) -> f64; 2] = [&|_| 3.0, &by_k];
    let names = [("growth", "installation = [3.0, 0.0]"), ("varying", varying)];
    for ((name, noise), moves) in names.into_iter().zip(moves) {
        let (sum, after) = chain(&folder(&format!("installation-{name}"), noise));
        let (joint, wanted) = by_hand(&all, moves);
        assert!((sum - joint).abs() < 1e-6, "{name}: {sum} {joint}");
        for k in 0..2 {
            for j in 0..2 {
                assert!((after[k][j] - wanted[k][j]).abs() < 1e-7, "{name}: {after:?} {wanted:?}");
            }
        }
        // Errors that are drawn anew in the second stage: another evidence.
        let (anew, _) = by_hand_anew(&all, moves);
        assert!((sum - anew).abs() > 0.05, "{name}: {sum} {anew}");
    }
}

/// Pressures tell the growth rate of an installation as well as decays do: both are of one draw, in one stage
/// and in two.
#[test]
fn oracle_pressures_and_decays_of_an_assembly_have_one_error() {
    let by_k = |p: usize| 0.02 * rate() * POINTS[p].2;
    let growth = |p: usize| POINTS[p].3 + 0.7 * (p as f64 * 2.3).sin();
    let noise = "pressure = 0.0\nvarying = [{ parameter = \"b\", sd = 0.02 }]";
    let (sum, after) = chain(&heard("installation-heard", noise, &|p| Some(growth(p))));
    let numbers: Vec<(usize, f64, f64, f64)> = (0..POINTS.len())
        .flat_map(|p| {
            let slope = pressure(growth(p))[1];
            let heard = [slope.re, slope.im].map(|by| (p, by, growth(p), HEARD_SD));
            [(p, 1.0, POINTS[p].3, POINTS[p].4)].into_iter().chain(heard)
        })
        .collect();
    let (joint, wanted) = of_numbers(&numbers, &by_k, &|a, b| POINTS[a].1 == POINTS[b].1);
    // Pressures bend a little with the growth rate.
    assert!((sum - joint).abs() < 0.05, "{sum} {joint}");
    for k in 0..2 {
        let ([value, sd], [there, width]) = (after[k], wanted[k]);
        assert!(
            (value - there).abs() < 0.05 * width && (sd / width).ln().abs() < 0.02,
            "{after:?} {wanted:?}"
        );
    }
    // Draws of its own for every pressure would make the noise of the means too small.
    let own = of_numbers(&numbers, &by_k, &|a, b| a == b);
    assert!((own.0 - joint).abs() > 0.5, "{own:?} {joint}");
}

/// Three stages of a tube, whose length the temperature stands for, which was read once a day with an error:
/// the first and the last have points of the same day. All at once and in a chain the same is known.
#[test]
fn oracle_the_day_of_two_stages_has_one_error_of_its_temperature() {
    // Frequencies of a tube with two rigid ends: c/(2 l), c as the root of the temperature.
    let points =
        [("first", "a"), ("first", "a"), ("first", "b"), ("between", "c"), ("second", "a"), ("second", "a")];
    let heard = [0.30, 0.31, -0.02, 0.12, 0.29, 0.33];
    let (length_sd, kelvin_sd, sd) = (2e-3, 0.5, 0.02);
    let hertz = sound_speed() / 1.6;
    let row = |i: usize, last: &str| {
        let day = if points[i].0 == "second" { last } else { points[i].1 };
        format!("p{i},{},{day},293.15,{kelvin_sd}\n", points[i].0)
    };
    let modes = |i: usize| format!("p{i},{},{sd}\n", hertz + heard[i]);
    let plan = |stages: &[(&str, &str, &str)]| {
        let stage = |(id, on, rows): &(&str, &str, &str)| {
            format!(
                "[[stage]]\nid = \"{id}\"\npoints = {{ rows = {rows} }}\n{on}with = {{ tube = \"tube\" }}\nbase_errors = true\n\
                 [stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n"
            )
        };
        format!("name = \"t\"\nbase = \"ambient\"\n{}", stages.iter().map(stage).collect::<String>())
    };
    let of = |name: &str, plan: &str, last: &str| {
        let candidate = format!(
            "[[candidate]]\nid = \"tube\"\nrole = \"tube\"\nname = \"tube\"\ncite = [\"a test\"]\n\
             parameters.l = {{ unit = \"m\", prior = {{ normal = {{ mean = 0.0, sd = {length_sd} }} }} }}\n\
             [[candidate.effect]]\nacts_at = \"downstream\"\nreflection = \"exp(-2*s*l/c)\"\n"
        );
        let rig = "name = \"tube\"\n[gas]\ngas_constant = 287.0\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"free\"\n\
                   [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = 0.8\ndiameter = 0.05\nwall = \"none\"\n";
        let campaign: String = (0..6).map(|i| row(i, last)).collect();
        let modes: String = (0..6).map(modes).collect();
        let folder = Folder::new(
            name,
            &[
                ("rig.toml", rig),
                ("campaign.csv", &format!("point,row,day,T_amb [K],T_amb_sd [K]\n{campaign}")),
                ("candidates/tube.toml", &candidate),
                ("study.toml", plan),
                ("observations/observations.toml", ORIGIN),
                ("observations/modes.csv", &format!("point,frequency [Hz],frequency_sd [Hz]\n{modes}")),
            ],
        );
        let study = Study::open(&folder.0).unwrap();
        let observations = study.observations().unwrap();
        let mut run = Run::new(study, &observations, Trusted::Laplace).unwrap();
        let mut all = Vec::new();
        while let Some(stage) = run.next_stage().unwrap() {
            all.push(stage.models[0].clone());
        }
        let sum: f64 = all.iter().map(|m| m.evidence.unwrap().ln_marginal).sum();
        let last = all.last().unwrap().parameters[0].clone();
        (sum, last.value, last.sd)
    };
    let once = of("day-once", &plan(&[("all", "", "[\"first\", \"between\", \"second\"]")]), "a");
    // The stage between has no point of the day, and hands on what was learnt of it.
    let stages = plan(&[
        ("first", "", "[\"first\"]"),
        ("between", "on = \"first\"\n", "[\"between\"]"),
        ("second", "on = \"between\"\n", "[\"second\"]"),
    ]);
    let chain = of("day-chain", &stages, "a");
    // The effects of the errors are taken where each stage ends: second order, c as the root of T.
    assert!((once.0 - chain.0).abs() < 0.005, "{once:?} {chain:?}");
    let apart = (once.1 - chain.1).abs() / once.2;
    assert!(apart < 2e-3 && (chain.2 / once.2 - 1.0).abs() < 2e-3, "{once:?} {chain:?}");
    // Drawn anew, the error is worth less, and the length seems better known.
    let anew = of("day-anew", &stages, "d");
    assert!(anew.2 < 0.95 * once.2 && (anew.0 - once.0).abs() > 0.2, "{once:?} {anew:?}");
}
