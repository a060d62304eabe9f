//! Base states that `rijke flow` made of the virtual laboratory's clicks, judged by the laboratory's truth.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a long study prints what it measures")]

use rijke_lab::{Truth, VirtualRig};
use rijke_model::BaseStates;
use rijke_numerics::{Matrix, symmetric_eigen};
use rijke_rig::{Campaign, RecordSource, Rig};
use std::path::Path;

/// One point: power, place, and for U_h and the mean speed of sound error and sd in per cent.
struct Row {
    id: String,
    power: f64,
    velocity: [f64; 2],
    sound: [f64; 2],
    worst: f64,
    moves: Vec<(String, f64)>,
}

fn mean_sound(state: &rijke_model::BaseState) -> f64 {
    let n = 400;
    let slowness = (0..n).map(|k| 1.0 / state.sound_speed((f64::from(k) + 0.5) / f64::from(n)));
    f64::from(n) / slowness.sum::<f64>()
}

#[test]
#[ignore = "long: reads FOLDER/F1, F2, ... that `rijke flow` wrote for virtual rigs of seeds 1, 2, ..."]
fn lab_base_states_cover_the_laboratory() {
    let folder = std::env::var("FOLDER").unwrap();
    let (rig, campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
    let rows: Vec<String> = ["H7", "H15", "H30", "H50", "H80", "H130", "H180"].map(String::from).into();
    for seed in 1.. {
        let path = Path::new(&folder).join(format!("F{seed}"));
        if !path.is_dir() {
            break;
        }
        let states = BaseStates::read(&path).unwrap();
        let mut all = vec!["H0".to_string()];
        all.extend(rows.clone());
        let lab = VirtualRig::new(&rig, &campaign, &Truth::standard(), &all, Some(1), seed).unwrap();
        let mut list = Vec::new();
        for (k, entry) in lab.set().points.iter().enumerate() {
            let Some(state) = states.points.get(&entry.point.id) else { continue };
            if entry.point.power == 0.0 {
                continue;
            }
            let truth = lab.true_base_state(k);
            let (mean, real) = (mean_sound(state), mean_sound(truth));
            let moves: Vec<(String, f64)> = state
                .errors
                .iter()
                .enumerate()
                .map(|(n, e)| {
                    let mut z = vec![0.0; n + 1];
                    z[n] = 1.0;
                    (e.cause.clone(), 100.0 * (mean_sound(&state.displaced(&z)) / mean - 1.0))
                })
                .collect();
            let sd = moves.iter().map(|m| m.1 * m.1).sum::<f64>().sqrt();
            let heater = entry.point.position.unwrap();
            let worst = (0..100)
                .map(|k| 0.01 * (f64::from(k) + 0.5))
                .filter(|x| (x - heater).abs() > 0.012)
                .map(|x| {
                    let c = state.sound_speed_covariance(&[x])[(0, 0)].sqrt();
                    (state.sound_speed(x) - truth.sound_speed(x)) / c
                })
                .fold(0.0_f64, |m, z| if z.abs() > m.abs() { z } else { m });
            list.push(Row {
                id: entry.point.id.clone(),
                power: entry.point.power,
                velocity: [
                    100.0 * (state.heater_velocity / truth.heater_velocity - 1.0),
                    100.0 * state.heater_velocity_sd() / state.heater_velocity,
                ],
                sound: [100.0 * (mean / real - 1.0), sd],
                worst,
                moves,
            });
        }
        println!("## seed {seed}");
        for r in &list {
            println!(
                "{} U {:+.2} sd {:.2} z {:+.2}  c {:+.3} sd {:.3} z {:+.2}  worst z {:+.2}",
                r.id,
                r.velocity[0],
                r.velocity[1],
                r.velocity[0] / r.velocity[1],
                r.sound[0],
                r.sound[1],
                r.sound[0] / r.sound[1],
                r.worst
            );
        }
        for power in [7.0, 15.0, 30.0, 50.0, 80.0, 130.0, 180.0] {
            let mine: Vec<&Row> = list.iter().filter(|r| r.power == power).collect();
            let rms = |f: &dyn Fn(&Row) -> f64| {
                (mine.iter().map(|r| f(r).powi(2)).sum::<f64>() / mine.len() as f64).sqrt()
            };
            println!(
                "power {power}: rms error of mean c {:.3} %, rms sd {:.3} %, rms z {:.2}, inside 2 sd {}/{}",
                rms(&|r| r.sound[0]),
                rms(&|r| r.sound[1]),
                rms(&|r| r.sound[0] / r.sound[1]),
                mine.iter().filter(|r| (r.sound[0] / r.sound[1]).abs() < 2.0).count(),
                mine.len()
            );
        }
        // Principal directions of the stated covariance of all mean speeds.
        let n = list.len();
        let c = Matrix::from_fn(n, n, |i, j| {
            list[i]
                .moves
                .iter()
                .map(|(cause, m)| m * list[j].moves.iter().find(|o| o.0 == *cause).map_or(0.0, |o| o.1))
                .sum()
        });
        let (values, vectors) = symmetric_eigen(&c).unwrap();
        for k in (n - 12..n).rev() {
            let along: f64 = (0..n).map(|i| vectors[(i, k)] * list[i].sound[0]).sum();
            println!(
                "direction {}: sd {:.4} %, error {along:+.4} %, z {:+.2}",
                n - k,
                values[k].sqrt(),
                along / values[k].sqrt()
            );
        }
        let left = |count: usize| -> (f64, f64) {
            let along = |k: usize| (0..n).map(|i| vectors[(i, k)] * list[i].sound[0]).sum::<f64>();
            (
                (0..n - count).map(|k| along(k).powi(2)).sum::<f64>().sqrt(),
                (0..n - count).map(|k| values[k]).sum::<f64>().sqrt(),
            )
        };
        for count in [12, 20, 30, 50] {
            println!(
                "beyond {count} directions: error {:.4} %, stated {:.4} %",
                left(count).0,
                left(count).1
            );
        }
    }
}
