//! Four planned points beside the eight of Fig. 11: what is predicted of the points that did not train.

use crate::design_study::{Bench, EIGHT, SEEDS, hours};
use rayon::prelude::*;
use rijke_engine::run::Aim;
use rijke_numerics::median;

/// Where `next` starts: lowest and highest power at the middle of the tube.
const PILOT: [&str; 2] = ["H7-50", "H180-50"];

/// Of one layout: hours, root mean square error of the growth rates of the other points, 1/s, and what is
/// stated.
fn judged(bench: &Bench, ids: &[String]) -> [f64; 3] {
    let found = bench.measured(ids, &[1]);
    let others = bench.hot.iter().zip(&found.off).filter(|((id, _), _)| !ids.contains(id));
    let off: Vec<[f64; 3]> = others.map(|(_, off)| *off).collect();
    let rms = |k: usize| (off.iter().map(|o| o[k] * o[k]).sum::<f64>() / off.len() as f64).sqrt();
    [hours(ids), rms(0), rms(1)]
}

/// Two points of the pilot and two that `next` plans, anywhere or where the heater was not yet; the eight.
fn one_rig(seed: u64) -> Vec<(String, [f64; 3])> {
    let bench = Bench::new(&format!("few-{seed}"), seed);
    let pilot: Vec<String> = PILOT.map(String::from).to_vec();
    let found = bench.measured(&pilot, &[1]);
    let free: Vec<String> = bench.hot.iter().map(|h| h.0.clone()).filter(|id| !pilot.contains(id)).collect();
    let plan = found.next(Aim::Parameters, 2, &free, false).plan;
    let four = [pilot, plan.into_iter().map(|s| s.point).collect()].concat();
    let eight: Vec<String> = EIGHT.map(String::from).to_vec();
    let even: Vec<String> = ["H7-15", "H7-85", "H180-15", "H180-85"].map(String::from).to_vec();
    let layouts =
        [("planned, four points", four), ("the corners, four points", even), ("the paper's eight", eight)];
    layouts
        .into_iter()
        .map(|(name, ids)| (format!("{name}: {}", ids.join(" ")), judged(&bench, &ids)))
        .collect()
}

#[test]
#[ignore = "five laboratories: two minutes"]
fn coverage_of_four_planned_points_beside_the_eight_of_the_paper() {
    let rigs: Vec<Vec<(String, [f64; 3])>> = (1..=SEEDS).into_par_iter().map(one_rig).collect();
    println!(
        "| layout | hours | rms error of the others, 1/s, by rig | median | stated sd, 1/s |\n|---|---|---|---|---|"
    );
    let mut medians = Vec::new();
    for k in 0..rigs[0].len() {
        let of = |i: usize| median(rigs.iter().map(|r| r[k].1[i]).collect());
        let each: Vec<String> = rigs.iter().map(|r| format!("{:.3}", r[k].1[1])).collect();
        let names: Vec<&str> = rigs.iter().map(|r| r[k].0.as_str()).collect();
        println!("| {} | {} | {} | {:.3} | {:.3} |", names.join("; "), of(0), each.join(", "), of(1), of(2));
        medians.push(of(1));
    }
    assert!(rigs.iter().flatten().all(|(_, [_, rms, sd])| rms < &(2.0 * sd)), "errors beyond those stated");
    assert!(medians[0] < 1.5 * medians[2], "four planned points predict worse than the eight: {medians:?}");
}
