//! Decays whose damping grows with the amplitude: growth rates are those at small amplitude.

use crate::chirping::{study, tube};
use crate::driven::Driven;
use rayon::prelude::*;
use rijke_signal::PingFit;

#[test]
fn coverage_of_dampings_that_grow_with_the_amplitude() {
    check(16);
}

#[test]
#[ignore = "long: 200 records of each of 12 kinds"]
fn coverage_of_dampings_that_grow_with_the_amplitude_over_200_seeds() {
    check(200);
}

fn check(count: u64) {
    check_law(count, 1);
}

#[test]
fn coverage_of_dampings_that_grow_as_the_square_of_the_amplitude() {
    check_law(16, 2);
}

#[test]
#[ignore = "long: 200 records of each of 12 kinds"]
fn coverage_of_dampings_that_grow_as_the_square_over_200_seeds() {
    check_law(200, 2);
}

/// Damping with an excess that grows as a power of the amplitude.
fn check_law(count: u64, power: i32) {
    let mut wrong = Vec::new();
    for excess in [1.0, 0.3, 0.1, 0.03] {
        for ratio in [2000.0, 200.0, 20.0] {
            let name = format!("excess {excess} of power {power}, amplitude {ratio}");
            let tally = study(&name, count, |seed| Driven { excess, power, ..tube(seed, ratio) });
            if tally.used as u64 * 10 < 9 * count
                || tally.worst > 4.5
                || tally.inside.iter().any(|v| *v < 0.75)
            {
                wrong.push(name);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Of plain exponentials: how often an excess is seen, and whether the errors of excesses are as stated.
fn plain(count: u64) -> (usize, f64, usize) {
    let fit = |seed| tube(seed, [2000.0, 200.0, 20.0][seed as usize % 3]).fit(seed).ok();
    let fits: Vec<PingFit> = (0..count).into_par_iter().filter_map(fit).collect();
    let seen = fits.iter().filter(|f| f.excess.is_significant()).count();
    let squares: f64 = fits.iter().map(|f| (f.excess.linear.share / f.excess.linear.sd).powi(2)).sum();
    (seen, (squares / fits.len() as f64).sqrt(), fits.len())
}

#[test]
fn coverage_of_excesses_of_plain_decays() {
    let (seen, rms, used) = plain(60);
    println!("plain: {seen} of {used} seen, rms of excess over deviation {rms:.2}");
    assert!(seen == 0 && (0.75..1.3).contains(&rms) && used > 57, "{seen} {rms} {used}");
}

#[test]
#[ignore = "long: 200 records"]
fn coverage_of_excesses_of_plain_decays_over_200_seeds() {
    let (seen, rms, used) = plain(200);
    println!("plain: {seen} of {used} seen, rms of excess over deviation {rms:.2}");
    assert!(seen == 0 && (0.85..1.15).contains(&rms) && used > 195, "{seen} {rms} {used}");
}
