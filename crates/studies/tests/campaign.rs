//! The whole chain of stages on the laboratory's true modes, with noise, and its true base flow with an invented error.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a long study prints what it measures")]

use rand::RngExt;
use rijke_lab::{Truth, VirtualRig};
use rijke_model::BaseStates;
use rijke_numerics::{Matrix, Stream, Streams};
use rijke_rig::{Campaign, DataKind, Observations, Ping, PointObservations, RecordSource, Rig};
use rijke_studies::{
    Hot, cold, cold_heater, feedback, feedback_naive, figure_8, figure_9, figure_10, figure_11, heat_release,
    prongs_and_knowledge,
};
use std::time::Instant;

const SD: [f64; 3] = [0.02, 0.05, 2e-4];

fn normal(stream: &mut Stream) -> f64 {
    let (u, v): (f64, f64) = (stream.random(), stream.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn laboratory(seed: u64) -> (Observations, BaseStates) {
    let (rig, campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
    let lab = VirtualRig::new(&rig, &campaign, &Truth::standard(), &[], Some(1), seed).unwrap();
    let set = lab.set();
    let mut stream = Streams::new(seed).stream("studies");
    let mut states = std::collections::BTreeMap::new();
    let mut points = Vec::new();
    for (k, entry) in set.points.iter().enumerate() {
        let (s, pressures) = lab.true_mode(k);
        let covariance = Matrix::diagonal(&(0..16).map(|k| SD[k.min(2)].powi(2)).collect::<Vec<_>>());
        let exact = Ping { s, pressures, reference: 5, covariance: covariance.clone() };
        let noisy: Vec<f64> =
            exact.vector().iter().enumerate().map(|(k, v)| v + SD[k.min(2)] * normal(&mut stream)).collect();
        if entry.point.power > 0.0 {
            let base = lab.true_base_state(k).clone();
            states.insert(entry.point.id.clone(), base);
        }
        points.push(PointObservations {
            point: entry.point.clone(),
            ambient: set.days[entry.day].clone(),
            ping: Some(Ping::from_vector(&noisy, 5, covariance)),
            ping_count: 40,
            click: None,
            click_count: 0,
            pings: Vec::new(),
            clicks: Vec::new(),
        });
    }
    let source = set.source.clone();
    (
        Observations { rig, kind: DataKind::Virtual, source: source.clone(), points, rejections: Vec::new() },
        BaseStates { kind: DataKind::Virtual, source, points: states },
    )
}

#[test]
#[ignore = "long: the whole chain"]
fn lab_the_whole_chain() {
    let (observations, states) = laboratory(1);
    let clock = Instant::now();
    let lap = |what: &str| println!("--- {what}: {:.2} s", clock.elapsed().as_secs_f64());
    let (prongs, known) = prongs_and_knowledge(&observations, false).unwrap();
    lap("prongs");
    let (heater, known) = cold_heater(&observations, &prongs.winner, &known, false).unwrap();
    lap("heater");
    let (figure_5, stage) = cold(&observations, &prongs.winner, &heater.winner, &known).unwrap();
    lap("cold");
    println!("noise {:?}", stage.noise);
    for p in &figure_5.parameters {
        println!("   {:10} {:12.5e} {:10.2e}", p.name, p.value, p.sd);
    }
    let hot = Hot::new(&observations, &states, stage).unwrap();
    let six = feedback(&hot).unwrap();
    lap("figure 6");
    let seven = feedback_naive(&hot, &six).unwrap();
    lap("figure 7");
    for power in [7.0, 50.0, 180.0] {
        for (a, b) in six.points.iter().zip(&seven.points).filter(|(a, _)| a.power_w == power) {
            println!(
                "{:8} U {:.3}  {:.3e} +- {:.1e}  {:6.3} +- {:.3}   naive {:.3e} +- {:.1e}  {:6.3} +- {:.3}",
                a.id,
                a.heater_velocity,
                a.modulus_per_watt,
                a.modulus_per_watt_sd,
                a.lag,
                a.lag_sd,
                b.modulus_per_watt,
                b.modulus_per_watt_sd,
                b.lag,
                b.lag_sd
            );
        }
    }
    let (table, best) = heat_release(&hot, false).unwrap();
    lap("table 4");
    for m in &table.models {
        let e = m.evidence.map_or([f64::NAN; 3], |e| [e.ln_best_fit, e.ln_occam, e.ln_marginal]);
        println!(
            "{:90} {:8.4} {:8.4} {:8.4}  noise {:.3} {:.3} {:.2e} {}",
            m.id,
            e[0],
            e[1],
            e[2],
            m.growth_rate_noise_sd,
            m.angular_frequency_noise_sd,
            m.pressure_noise_sd,
            m.remark.clone().unwrap_or_default()
        );
        let p: Vec<String> =
            m.parameters.iter().map(|p| format!("{}={:.3e}+-{:.0e}", p.name, p.value, p.sd)).collect();
        println!("      {}", p.join(" "));
    }
    println!("winner {} chosen {} tau {:.3}", table.winner, table.chosen, table.kendall_tau);
    let (f8, f9) = (figure_8(&hot).unwrap(), figure_9(&hot).unwrap());
    lap("figures 8, 9");
    let f10 = figure_10(&hot, &best).unwrap();
    let f11 = figure_11(&hot, &best, &f10).unwrap();
    lap("figures 10, 11");
    for f in [&f8, &f9, &f10, &f11] {
        println!(
            "figure {}: noise {:.3} {:.3}, coverage {:?} {:?}",
            f.figure, f.growth_rate_noise_sd, f.angular_frequency_noise_sd, f.coverage, f.coverage_elsewhere
        );
    }
    for c in [
        &heater.checks,
        &figure_5.checks,
        &six.checks,
        &seven.checks,
        &table.checks,
        &f8.checks,
        &f9.checks,
        &f10.checks,
        &f11.checks,
    ]
    .into_iter()
    .flatten()
    {
        println!("{} {} ({})", if c.holds { "holds" } else { "FAILS" }, c.statement, c.figure);
    }
}
