//! The whole chain of stages on the laboratory's true modes, with the noise of a mean of 40 pings, and its true base flow.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a long study prints what it measures")]

use rand::RngExt;
use rijke_lab::{Truth, VirtualRig};
use rijke_model::BaseStates;
use rijke_numerics::{Matrix, Stream, Streams};
use rijke_rig::{Campaign, DataKind, Observations, Ping, PointObservations, RecordSource, Rig};
use rijke_studies::{
    Check, Cold, Feedback, HeatRelease, Hot, HotPredictions, Prongs, cold, cold_heater, feedback,
    feedback_naive, figure_8, figure_9, figure_10, figure_11, heat_release, prongs_stage,
};
use std::time::Instant;

const SD: [f64; 3] = [0.02, 0.05, 2e-4];

fn normal(stream: &mut Stream) -> f64 {
    let (u, v): (f64, f64) = (stream.random(), stream.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn laboratory(seed: u64, wanted: impl Fn(&str) -> bool) -> (Observations, BaseStates) {
    let (rig, mut campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
    campaign.points.retain(|p| wanted(&p.id));
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
            states.insert(entry.point.id.clone(), lab.true_base_state(k).clone());
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
        Observations {
            rig,
            kind: DataKind::Virtual,
            source: source.clone(),
            points,
            rejections: Vec::new(),
            channels: None,
        },
        BaseStates { kind: DataKind::Virtual, source, points: states },
    )
}

/// All stages on one campaign.
struct Chain {
    table_2: Prongs,
    table_3: Prongs,
    figure_5: Cold,
    figure_6: Feedback,
    figure_7: Feedback,
    table_4: HeatRelease,
    figures: Vec<HotPredictions>,
}

fn chain(observations: &Observations, states: &BaseStates) -> Chain {
    let (table_2, stage) = prongs_stage(observations, false).unwrap();
    let (table_3, stage) = cold_heater(observations, &stage, false).unwrap();
    let (figure_5, stage) = cold(observations, &stage).unwrap();
    let hot = Hot::new(observations, states, stage).unwrap();
    let figure_6 = feedback(&hot).unwrap();
    let figure_7 = feedback_naive(&hot, &figure_6).unwrap();
    let (table_4, best) = heat_release(&hot, false).unwrap();
    let full = figure_10(&hot, &best).unwrap();
    let eight = figure_11(&hot, &best, &full).unwrap();
    let figures = vec![figure_8(&hot).unwrap(), figure_9(&hot).unwrap(), full, eight];
    Chain { table_2, table_3, figure_5, figure_6, figure_7, table_4, figures }
}

/// What must come out of any seed: the physics of the stages, not the order of models that the data hardly tell apart.
fn holds(checks: &[Check], part: &str) {
    let check = checks.iter().find(|c| c.statement.contains(part)).unwrap();
    assert!(check.holds, "{check:?}");
}

#[test]
fn lab_the_hot_stages_find_the_physics_of_the_laboratory() {
    // Three powers of seven, and every second position.
    let few = |id: &str| {
        let hot = ["H15-", "H50-", "H180-"].iter().any(|row| id.starts_with(row));
        let even = ["15", "25", "35", "45", "50", "55", "65", "75", "85"].iter().any(|x| id.ends_with(x));
        id.starts_with('C') || id.starts_with("H0") || (hot && even) || id == "H7-15" || id == "H7-85"
    };
    let (observations, states) = laboratory(1, few);
    let chain = chain(&observations, &states);
    holds(&chain.table_3.checks, "Model 3, orifice");
    holds(&chain.figure_5.checks, "Thermocouples affect");
    holds(&chain.figure_6.checks, "The standard deviation of k_eu");
    holds(&chain.figure_7.checks, "the angle of k_eu jumps");
    let [eight, nine, ten, eleven] = chain.figures.as_slice() else { panic!() };
    holds(&eight.checks, "over-predicts");
    holds(&nine.checks, "eta is well above 1");
    assert!(
        ten.coverage.iter().chain(&eleven.coverage_elsewhere.unwrap()).all(|c| *c > 0.85),
        "{:?} {:?}",
        ten.coverage,
        eleven.coverage_elsewhere
    );
    // The laboratory's wire lags as a hot cylinder does, in a mean flow that enters through a mouth.
    assert!(chain.table_4.chosen.contains("mean-flow"), "{}", chain.table_4.chosen);
}

#[test]
#[ignore = "long: the whole campaign, five seeds"]
fn lab_five_seeds_of_the_whole_campaign() {
    for seed in 1..=5 {
        let (observations, states) = laboratory(seed, |_| true);
        let clock = Instant::now();
        let chain = chain(&observations, &states);
        println!("=== seed {seed}, {:.1} s", clock.elapsed().as_secs_f64());
        let tables = [
            (&chain.table_2.models, &chain.table_2.winner, chain.table_2.kendall_tau),
            (&chain.table_3.models, &chain.table_3.winner, chain.table_3.kendall_tau),
            (&chain.table_4.models, &chain.table_4.winner, chain.table_4.kendall_tau),
        ];
        for (models, winner, tau) in tables {
            println!("winner {winner}, Kendall's tau {tau:.3}");
            for m in models {
                let e = m.evidence.map_or([f64::NAN; 3], |e| [e.ln_best_fit, e.ln_occam, e.ln_marginal]);
                println!(
                    "  {:86} {:8.4} {:8.4} {:8.4}  misfit {:.3} {:.3} {:.1e} {}",
                    m.id,
                    e[0],
                    e[1],
                    e[2],
                    m.growth_rate_noise_sd,
                    m.angular_frequency_noise_sd,
                    m.pressure_noise_sd,
                    m.remark.clone().unwrap_or_default()
                );
            }
        }
        println!("chosen {}; after the cold stages:", chain.table_4.chosen);
        for p in chain.figure_5.parameters.iter().chain(&chain.figures[2].parameters) {
            println!("  {:10} {:12.5e} +- {:.1e}", p.name, p.value, p.sd);
        }
        for p in &chain.figure_6.points {
            println!(
                "  {:8} {:.3e} +- {:.1e}  {:6.3} +- {:.3}",
                p.id, p.modulus_per_watt, p.modulus_per_watt_sd, p.lag, p.lag_sd
            );
        }
        let checks =
            [&chain.table_2.checks, &chain.table_3.checks, &chain.figure_5.checks, &chain.figure_6.checks]
                .into_iter()
                .chain([&chain.figure_7.checks, &chain.table_4.checks])
                .chain(chain.figures.iter().map(|f| &f.checks));
        for c in checks.flatten() {
            println!("{}: {} ({})", if c.holds { "holds" } else { "FAILS" }, c.statement, c.figure);
        }
    }
}
