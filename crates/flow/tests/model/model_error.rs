//! What happens when the tube does more than the model knows.

#![allow(clippy::print_stdout, reason = "the table is what this study is for")]

use super::{AMBIENT, pipe};
use rayon::prelude::*;
use rijke_flow::TubeRig;
use rijke_flow::assimilate::{Batch, ClosureTension, Twin, TwinOptions};
use rijke_flow::{Closures, Pipe};
use rijke_numerics::Streams;

/// Closures of a richer tube: radiation from the heater, a velocity profile, a darker wall, another entrance.
fn richer() -> [(&'static str, Closures); 5] {
    let plain = Closures::default();
    [
        ("nothing", plain.clone()),
        ("heater radiation 5 %", Closures { radiated_share: 0.05, ..plain.clone() }),
        ("velocity profile 1.2", Closures { profile_factor: 1.2, ..plain.clone() }),
        (
            "emissivity 0.45, entrance loss 0.8",
            Closures { emissivity: 0.45, entrance_loss: 0.8, ..plain.clone() },
        ),
        (
            "all of these",
            Closures {
                radiated_share: 0.05,
                profile_factor: 1.2,
                emissivity: 0.45,
                entrance_loss: 0.8,
                ..plain
            },
        ),
    ]
}

/// What the fit makes of a truth that is richer than its model.
struct Found {
    /// Relative errors of U_h and of the worst c(x).
    velocity: f64,
    sound: f64,
    chi_squared: f64,
    /// Closures that the readings ask for, and the number of warnings.
    tensions: Vec<ClosureTension>,
    warnings: usize,
}

fn errors(truth: &Pipe, model: &Pipe) -> Found {
    // Truth at the centre of the priors.
    let scores = vec![0.0; 18];
    let twin = Twin::new(truth, &TwinOptions::default(), &Streams::new(11), Some(&scores)).unwrap();
    let record = twin.record.checked(model).unwrap();
    let estimate = Batch::new(model, &record, 10).unwrap().fit().unwrap();
    let base = estimate.base_state(model, 180.0, AMBIENT).unwrap();
    let p = rijke_flow::TubeParameters {
        heater_drag: 11.5,
        outer_nusselt: 1.2,
        mount_resistance: 10.5,
        wall_share: 0.15,
        inner_nusselt: 1.5,
        jet_enhancement: 1.5,
    };
    let real = truth.steady(&p, 180.0, AMBIENT).unwrap().base_state(truth);
    let sound = (0..100).map(|k| {
        let x = 0.01 * (f64::from(k) + 0.5);
        (base.sound_speed(x) / real.sound_speed(x) - 1.0).abs()
    });
    let health = estimate.health.unwrap();
    Found {
        velocity: base.heater_velocity / real.heater_velocity - 1.0,
        sound: sound.fold(0.0, f64::max),
        chi_squared: health.chi_squared,
        warnings: health.warnings().len(),
        tensions: health.tensions,
    }
}

#[test]
#[ignore = "long: ten fits of a full staircase, half a minute of CPU"]
fn lab_model_error_stays_within_bounds() {
    println!(
        "| beyond the model | heater | error of U_h | worst error of c(x) | chi-squared | greatest tension | warnings |"
    );
    println!("|---|---|---|---|---|---|---|");
    let cases: Vec<(&str, Closures, f64)> = richer()
        .into_iter()
        .flat_map(|(name, closures)| [0.25, 0.75].map(|x| (name, closures.clone(), x)))
        .collect();
    let rows: Vec<_> = cases
        .par_iter()
        .map(|(_, closures, x)| {
            errors(&Pipe::new(&TubeRig::juniper_yoko_2022(), closures, *x, 1).unwrap(), &pipe(*x, 1))
        })
        .collect();
    let worst = |list: &[ClosureTension]| {
        let worst = list.iter().max_by(|a, b| a.z.abs().total_cmp(&b.z.abs())).unwrap();
        format!("{} {:.2} +- {:.2}, {:+.1} sd", worst.closure, worst.preferred, worst.sd, worst.z)
    };
    for ((name, _, x), f) in cases.iter().zip(&rows) {
        println!(
            "| {name} | {x} m | {:+.2} % | {:+.2} % | {:.2} | {} | {} |",
            100.0 * f.velocity,
            100.0 * f.sound,
            f.chi_squared,
            worst(&f.tensions),
            f.warnings
        );
    }
    for ((name, ..), pair) in cases.iter().step_by(2).zip(rows.chunks(2)) {
        let both = ClosureTension::together(&[&pair[0].tensions, &pair[1].tensions]);
        println!("{name}, both places: {}", worst(&both));
    }
    for ((name, _, x), f) in cases.iter().zip(&rows) {
        assert!(f.sound < 0.01, "{name}, {x} m: c(x) is off by {}", f.sound);
        assert!(f.velocity.abs() < 0.10, "{name}, {x} m: U_h is off by {}", f.velocity);
    }
}
