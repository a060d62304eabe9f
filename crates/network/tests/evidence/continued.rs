//! What is stated of modes off the imaginary axis, by flames that were measured on it.

use crate::ghosts::modes;
use rand::RngExt;
use rayon::prelude::*;
use rijke_network::file::{read, scatter};
use rijke_numerics::{C64, Stream, Streams};
use std::f64::consts::PI;

/// A flame as it is, and its elements as in files.
struct Kind {
    name: &'static str,
    exact: fn(C64) -> C64,
    elements: &'static [&'static str],
}

const TURN: f64 = 2.0 * PI;

const KINDS: [Kind; 3] = [
    Kind {
        name: "second order",
        exact: |s| {
            0.9 * (-1.5e-3 * s).exp() / (1.0 + 0.5 * s / (TURN * 140.0) + (s / (TURN * 140.0)).powi(2))
        },
        elements: &["n = 0.9\ndelay = 1.5e-3\ndenominator = [1, 5.684105110424e-4, 1.2923620362543e-6]"],
    },
    Kind {
        name: "two delays",
        exact: |s| {
            let one = |n: f64, tau: f64, cut: f64| n * (-tau * s).exp() / (1.0 + s / (TURN * cut));
            one(1.8, 2e-3, 120.0) + one(-0.8, 5e-3, 90.0)
        },
        elements: &["n = 1.8\ndelay = 2e-3\ncutoff_hz = 120", "n = -0.8\ndelay = 5e-3\ncutoff_hz = 90"],
    },
    Kind {
        name: "gain, delay, filter",
        exact: |s| 1.2 * (-3e-3 * s).exp() / (1.0 + s / (TURN * 180.0)),
        elements: &["n = 1.2\ndelay = 3e-3\ncutoff_hz = 180"],
    },
];

/// A closed tube of 1 m, 0.08 m wide before a flame at 0.3 m and 0.1 m and hot behind it.
fn tube(flames: &[&str], growth: [f64; 2], hertz: [f64; 2]) -> String {
    let flames: String = flames.iter().map(|f| format!("[[element]]\ntype = 'flame'\n{f}\n")).collect();
    format!(
        "[search]\ngrowth_rate = {growth:?}\nfrequency_hz = {hertz:?}\n[upstream]\ntype = 'closed'\n[downstream]\n\
         type = 'unflanged'\n[[element]]\ntype = 'duct'\nlength = 0.3\ndiameter = 0.08\n{flames}\
         [[element]]\ntype = 'duct'\nlength = 0.7\ndiameter = 0.1\ntemperature = 1500\n"
    )
}

/// A complex Gaussian error of mean square 1.
fn error(stream: &mut Stream) -> C64 {
    let [radius, turn]: [f64; 2] = [stream.random(), stream.random()];
    C64::from_polar((-(1.0 - radius).ln()).sqrt(), TURN * turn)
}

/// A table from 20 to 520 Hz with additive errors of `noise` of the largest gain, and twice that as
/// tolerance.
fn table(kind: &Kind, noise: f64, seed: usize) -> String {
    let mut stream = Streams::new(5).stream(&format!("continued/{}/{noise}/{seed}", kind.name));
    let rows: Vec<(f64, C64)> =
        (2..53).map(|k| 10.0 * f64::from(k)).map(|f| (f, (kind.exact)(C64::new(0.0, TURN * f)))).collect();
    let largest = rows.iter().map(|r| r.1.norm()).fold(0.0, f64::max);
    let row = |(f, v): &(f64, C64)| {
        let v = v + noise * largest * error(&mut stream);
        format!("[{f}, {}, {}]", v.norm(), v.arg())
    };
    let rows: Vec<String> = rows.iter().map(row).collect();
    format!("n = 1\ntable = [{}]\ntolerance = {}", rows.join(", "), 2.0 * noise)
}

/// What came of one table.
#[derive(Default)]
struct Case {
    refused: bool,
    ghosts: usize,
    doubted: usize,
    pulls: Vec<f64>,
}

fn case(kind: &Kind, truth: &[C64], noise: f64, seed: usize) -> Case {
    let (mut case, mut taken) = (Case::default(), Vec::new());
    let measured = tube(&[&table(kind, noise, seed)], [-300.0, 300.0], [40.0, 480.0]);
    let Some((built, found)) = modes(&measured) else {
        return Case { refused: true, ..case };
    };
    for (s, scatter) in found.iter().zip(&scatter(&measured, &built, &found).unwrap()) {
        if scatter.is_doubtful() {
            case.doubted += 1;
            continue;
        }
        let nearest =
            (0..truth.len()).min_by(|&a, &b| (s - truth[a]).norm().total_cmp(&(s - truth[b]).norm()));
        let off = s - truth[nearest.unwrap()];
        // Two modes for one are a ghost too.
        case.ghosts += usize::from(taken.contains(&nearest));
        taken.push(nearest);
        if off.norm() > 80.0 && off.norm() > 3.0 * scatter.sd[0].hypot(scatter.sd[1]) {
            case.ghosts += 1;
        }
        case.pulls.extend([off.re / scatter.sd[0], off.im / scatter.sd[1]]);
    }
    case
}

/// Share of pulls within 2, their root mean square, modes trusted, ghosts among them, doubted, tables
/// refused.
fn study(kind: &Kind, noise: f64, tables: usize) -> (f64, f64, [usize; 4]) {
    let (_, truth) = modes(&tube(kind.elements, [-500.0, 500.0], [20.0, 520.0])).unwrap();
    let all: Vec<Case> = (0..tables).into_par_iter().map(|seed| case(kind, &truth, noise, seed)).collect();
    let pulls: Vec<f64> = all.iter().flat_map(|c| c.pulls.iter().copied()).collect();
    let within = pulls.iter().filter(|p| p.abs() < 2.0).count() as f64 / pulls.len() as f64;
    let rms = (pulls.iter().map(|p| p * p).sum::<f64>() / pulls.len() as f64).sqrt();
    let sum = |of: fn(&Case) -> usize| all.iter().map(of).sum();
    let counts =
        [pulls.len() / 2, sum(|c| c.ghosts), sum(|c| c.doubted), all.iter().filter(|c| c.refused).count()];
    (within, rms, counts)
}

#[test]
fn coverage_modes_far_from_the_axis_of_a_second_order_flame() {
    // Pulls had a root mean square of 2.6: the mode at -201 1/s lay 8 sd off where tables were drawn from the
    // fit of lowest order alone.
    let (within, rms, [trusted, ghosts, ..]) = study(&KINDS[0], 0.02, 8);
    assert!(trusted >= 12 && ghosts == 0 && within > 0.85 && rms < 1.6, "{within} {rms} {trusted} {ghosts}");
}

#[test]
fn behaviour_two_modes_of_a_fit_that_are_one_in_draws_are_doubted() {
    // One of 8 such tables had two modes, at 399.7 and 423.6 Hz, for the one at 411.2 Hz.
    let (_, _, [trusted, ghosts, ..]) = study(&KINDS[1], 0.05, 8);
    assert!(trusted >= 12 && ghosts == 0, "{trusted} {ghosts}");
}

#[test]
#[ignore = "long: 900 tables, their modes and those of forty draws of each; docs/records/network.md"]
fn coverage_modes_of_measured_flames() {
    println!("| flame | noise | within 2 sd | rms pull | modes trusted | ghosts | doubted | refused |");
    println!("|---|---|---|---|---|---|---|---|");
    for kind in &KINDS {
        for noise in [0.01, 0.02, 0.05] {
            let (within, rms, [trusted, ghosts, doubted, refused]) = study(kind, noise, 100);
            println!(
                "| {} | {noise} | {:.1} % | {rms:.2} | {trusted} | {ghosts} | {doubted} | {refused} |",
                kind.name,
                100.0 * within
            );
            assert!(within >= 0.9 && 100 * ghosts <= trusted, "{} {noise}", kind.name);
        }
    }
}

/// A Helmholtz resonance at 330 Hz behind a resistance and a mass: what a measured end may reflect.
fn reflection(s: C64) -> C64 {
    let w0 = TURN * 330.0;
    let z = 0.05 + 1e-4 * s + 0.6 / (0.5 + 3.0 * (s / w0 + w0 / s));
    (z - 1.0) / (z + 1.0)
}

/// The mode near `s` of a closed tube of 1.1 m with that end, by Newton's method with a difference quotient.
fn exact_mode(mut s: C64) -> C64 {
    let f = |s: C64| 1.0 - reflection(s) * (-2.2 * s / (1.4_f64 * 287.05 * 293.15).sqrt()).exp();
    for _ in 0..60 {
        let h = 1e-4 * C64::ONE;
        s -= f(s) * 2.0 * h / (f(s + h) - f(s - h));
    }
    s
}

/// A closed tube of 1.1 m with that end as a table of rows from 20 to 700 Hz with additive errors of `noise`.
fn end_table(rows: usize, noise: f64, tolerance: f64, seed: usize) -> String {
    let mut stream = Streams::new(6).stream(&format!("ends/{rows}/{noise}/{seed}"));
    let row = |k: usize| {
        let f = 20.0 + 680.0 * k as f64 / (rows - 1) as f64;
        let v = reflection(C64::new(0.0, TURN * f)) + noise * error(&mut stream);
        format!("[{f}, {}, {}]", v.norm(), v.arg())
    };
    let table: Vec<String> = (0..rows).map(row).collect();
    format!(
        "[search]\ngrowth_rate = [-150, 100]\nfrequency_hz = [50, 600]\n[upstream]\ntype = 'closed'\n[downstream]\n\
         type = 'table'\ntolerance = {tolerance}\ntable = [{}]\n[[element]]\ntype = 'duct'\nlength = 1.1\ndiameter = 0.05\n",
        table.join(", ")
    )
}

/// Pulls of growth rates and frequencies of all modes, tables refused, modes doubted, of so many tables.
fn of_ends(rows: usize, noise: f64, times: f64, tables: usize) -> (Vec<[f64; 2]>, usize, usize) {
    let one = |seed: usize| {
        let text = end_table(rows, noise, times * noise, seed);
        let Some((built, found)) = modes(&text) else { return (Vec::new(), 1, 0) };
        let scatter = scatter(&text, &built, &found).unwrap();
        let doubted = scatter.iter().filter(|s| s.is_doubtful()).count();
        let pulls =
            found.iter().zip(&scatter).filter(|(_, scatter)| !scatter.is_doubtful()).map(|(s, scatter)| {
                let off = s - exact_mode(*s);
                [off.re / scatter.sd[0], off.im / scatter.sd[1]]
            });
        (pulls.collect(), 0, doubted)
    };
    let all: Vec<_> = (0..tables).into_par_iter().map(one).collect();
    let pulls = all.iter().flat_map(|a| a.0.clone()).collect();
    (pulls, all.iter().map(|a| a.1).sum(), all.iter().map(|a| a.2).sum())
}

#[test]
fn behaviour_modes_of_a_measured_end_lie_where_they_are_said_to() {
    // By vector fitting alone, which settles beside the least squares, pulls had a root mean square of 1.6.
    let (pulls, refused, _) = of_ends(100, 0.05, 2.0, 8);
    let rms = |k: usize| (pulls.iter().map(|p| p[k] * p[k]).sum::<f64>() / pulls.len() as f64).sqrt();
    assert!(
        pulls.len() >= 35 && refused == 0 && rms(0) < 1.3 && rms(1) < 1.3,
        "{} {} {}",
        pulls.len(),
        rms(0),
        rms(1)
    );
}

#[test]
fn message_many_rows_of_more_noise_than_the_tolerance_say_their_noise() {
    // A pole for each pair of rows took minutes to be refused.
    let text = end_table(400, 0.005, 1e-6, 0);
    let said = read(&text).unwrap_err().to_string();
    assert!(
        said.contains("scatter about every rational function by 5.") && said.contains("tolerance = 0.01"),
        "{said}"
    );
}

#[test]
#[ignore = "long: 270 tables, their modes and those of forty draws of each; docs/records/network.md"]
fn coverage_modes_of_measured_ends() {
    println!(
        "| rows | noise | tolerance over noise | modes | tables refused | doubted | rms pull of growth | of frequency | beyond 3 sd |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (rows, noise, times) in [
        (100, 0.05, 2.0),
        (60, 0.05, 2.0),
        (100, 0.01, 2.0),
        (40, 0.02, 2.0),
        (40, 0.01, 2.0),
        (200, 0.03, 2.0),
        (100, 0.01, 4.0),
        (400, 0.01, 3.0),
        (800, 0.01, 2.2),
    ] {
        let (pulls, refused, doubted) = of_ends(rows, noise, times, 30);
        let rms = |k: usize| (pulls.iter().map(|p| p[k] * p[k]).sum::<f64>() / pulls.len() as f64).sqrt();
        let beyond = pulls.iter().flatten().filter(|p| p.abs() > 3.0).count();
        println!(
            "| {rows} | {noise} | {times} | {} | {refused} | {doubted} | {:.2} | {:.2} | {beyond} |",
            pulls.len(),
            rms(0),
            rms(1)
        );
        assert!(
            refused <= 3 && rms(0) < 1.3 && rms(1) < 1.3 && 50 * beyond <= 2 * pulls.len(),
            "{rows} {noise} {times}"
        );
    }
}
