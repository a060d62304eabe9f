//! The whole way from raw records of the virtual laboratory to observations, judged by the laboratory's truth.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may fail by panicking and prints its table"
)]

use rayon::prelude::*;
use rijke_lab::{Truth, VirtualRig};
use rijke_rig::{Campaign, Rig};
use rijke_signal::{ProcessOptions, process};

/// Error over stated sd of everything returned for the empty tube, by name.
fn pulls(seed: u64, repeats: u32) -> Vec<(String, f64)> {
    let rig = Rig::juniper_yoko_2022();
    let mut campaign = Campaign::juniper_yoko_2022();
    campaign.points.retain(|p| p.id == "C3-E");
    let mut truth = Truth::standard();
    // Bad records have tests of their own.
    truth.faults.pings = 0.0;
    truth.faults.clicks = 0.0;
    let lab = VirtualRig::new(&rig, &campaign, &truth, &["C3".into()], Some(repeats), seed).unwrap();
    let done = process(&lab, &ProcessOptions::default(), &|| ()).unwrap();
    let point = &done.observations.points[0];
    let (s, shape) = lab.true_mode(0);
    let mut pulls = Vec::new();

    let ping = point.ping.as_ref().unwrap();
    let sd = |k: usize| ping.covariance[(k, k)].sqrt();
    let others: Vec<usize> = (0..shape.len()).filter(|m| *m != ping.reference).collect();
    pulls.push(("growth rate".to_owned(), (ping.s.re - s.re) / sd(0)));
    pulls.push(("frequency".to_owned(), (ping.s.im - s.im) / sd(1)));
    for (k, &m) in others.iter().enumerate() {
        let error = ping.pressures[m] - shape[m];
        pulls.push((format!("Re p{}", m + 1), error.re / sd(2 + 2 * k)));
        pulls.push((format!("Im p{}", m + 1), error.im / sd(3 + 2 * k)));
    }
    let click = point.click.as_ref().unwrap();
    let c = rig.gas.at(lab.true_temperature(0), rig.pressure).sound_speed;
    for (m, x) in rig.microphones.positions.iter().enumerate() {
        let error = click.arrival_times[m] - x / c;
        pulls.push((format!("arrival {}", m + 1), error / click.covariance[(m, m)].sqrt()));
    }
    pulls
}

#[test]
#[ignore = "long: 200 seeds of raw records, a quarter of a minute on two cores"]
fn lab_stated_intervals_cover_the_truth() {
    let seeds = std::env::var("SEEDS").map_or(200, |s| s.parse().unwrap());
    let all: Vec<Vec<(String, f64)>> = (1..=seeds).into_par_iter().map(|seed| pulls(seed, 10)).collect();
    let count = all.len() as f64;
    println!("{:12} {:>8} {:>8} {:>8}", "quantity", "mean", "rms", "in 2 sd");
    for k in 0..all[0].len() {
        let values: Vec<f64> = all.iter().map(|p| p[k].1).collect();
        let mean = values.iter().sum::<f64>() / count;
        let rms = (values.iter().map(|v| v * v).sum::<f64>() / count).sqrt();
        let inside = values.iter().filter(|v| v.abs() < 2.0).count() as f64 / count;
        println!("{:12} {mean:8.3} {rms:8.3} {:7.1} %", all[0][k].0, 100.0 * inside);
        // 92 to 98 % is 95 % with twice the sd of a share of 200. The last channel's gain holds a stated systematic error.
        if all[0][k].0.starts_with("arrival") {
            // Nearly all of it is the shift between settings, declared from the paper's frequencies; at those of a click the end
            // correction is smaller, and so is the shift.
            assert!((0.75..1.0).contains(&rms), "{}: {rms}", all[0][k].0);
        } else if !all[0][k].0.contains('p') {
            assert!((0.92..=0.98).contains(&inside), "{}: {inside}", all[0][k].0);
        }
    }
}

/// Arrival times of a row against the time that sound takes in the laboratory's gas: of every channel, and less the first channel's,
/// in which the shift of a setting cancels. ROWS, SEED and REPEATS choose; every point is printed with its channels in us. Above a
/// heater the difference holds the delay of the heater itself.
#[test]
#[ignore = "long: 20 points of raw records, some ten seconds on two cores"]
fn lab_arrival_times_above_prongs() {
    let number = |name: &str, default: u32| std::env::var(name).map_or(default, |v| v.parse().unwrap());
    let rows = std::env::var("ROWS").unwrap_or_else(|_| "C3".to_owned());
    let (rig, campaign, truth) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022(), Truth::standard());
    let positions = &rig.microphones.positions;
    for row in rows.split(',').map(str::to_owned) {
        let repeats = Some(number("REPEATS", 10));
        let seed = u64::from(number("SEED", 1));
        let lab =
            VirtualRig::new(&rig, &campaign, &truth, std::slice::from_ref(&row), repeats, seed).unwrap();
        let done = process(&lab, &ProcessOptions::default(), &|| ()).unwrap();
        let (mut all, mut less) = (vec![vec![]; positions.len()], vec![vec![]; positions.len()]);
        for (k, point) in done.observations.points.iter().enumerate() {
            let Some(click) = &point.click else { continue };
            let base = lab.true_base_state(k);
            let error: Vec<f64> = positions
                .iter()
                .zip(&click.arrival_times)
                .map(|(x, t)| t - base.travel_time(0.0, *x))
                .collect();
            let shown = |v: f64| format!("{:6.2}", 1e6 * v);
            let mut line = String::new();
            for m in 0..positions.len() {
                let c = &click.covariance;
                let sd = c[(m, m)].sqrt();
                let apart = (c[(m, m)] + c[(0, 0)] - 2.0 * c[(m, 0)]).max(0.0).sqrt();
                all[m].push([error[m], error[m] / sd]);
                if m > 0 {
                    less[m].push([error[m] - error[0], (error[m] - error[0]) / apart]);
                    line += &format!(" {}({})", shown(error[m] - error[0]), shown(apart));
                }
            }
            println!("{:8} {} clicks, less the first:{line}", point.point.id, point.click_count);
        }
        for (what, all) in [("arrival time", &all), ("less the first", &less)] {
            println!("{row}, {what}: mean and rms in us, mean, rms and largest in stated sd");
            for (m, errors) in all.iter().enumerate().filter(|(_, errors)| !errors.is_empty()) {
                let count = errors.len() as f64;
                let mean = |i: usize| errors.iter().map(|e| e[i]).sum::<f64>() / count;
                let rms = |i: usize| (errors.iter().map(|e| e[i] * e[i]).sum::<f64>() / count).sqrt();
                let largest = errors.iter().fold(0.0_f64, |a, e| a.max(e[1].abs()));
                let (us, per) = ((1e6 * mean(0), 1e6 * rms(0)), (mean(1), rms(1)));
                println!(
                    "microphone {}: {:6.2} {:6.2}, {:6.2} {:6.2} {largest:6.2}",
                    m + 1,
                    us.0,
                    us.1,
                    per.0,
                    per.1
                );
                // Above a heater the delay of the heater itself is in the difference; a gain or a geometry that is wrong gives ten.
                if row == "C3" {
                    assert!(
                        per.1 < 2.0 && largest < 4.0,
                        "{what}, microphone {}: {} {largest}",
                        m + 1,
                        per.1
                    );
                }
            }
        }
    }
}
