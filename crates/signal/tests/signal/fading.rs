//! A loudspeaker that dies away slowly after it was switched off.

use crate::driven::Driven;
use rayon::prelude::*;
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// An amplifier that fades, with the frequency of the forcing: what is heard last may be the loudspeaker
/// alone.
#[test]
fn behaviour_a_loudspeaker_that_dies_away_slowly_gives_no_wrong_growth_rate() {
    let mut wrong = Vec::new();
    for (coast, growth_rate) in [(0.03, -13.0), (0.03, -28.0), (0.1, -22.0)] {
        for forcing_hz in [95.0, 95.3] {
            let driven = Driven {
                modes: vec![(C64::new(growth_rate, TAU * 95.0), 1.0)],
                forcing_hz,
                coast,
                switched: vec![(0.12, 0.8)],
                end: 1.6,
                ratio: 160.0,
                channels: 3,
                ..Driven::tube()
            };
            let fits: Vec<_> = (0..8).into_par_iter().filter_map(|seed| driven.fit(seed).ok()).collect();
            for fit in fits {
                let error = fit.ping.s.re - growth_rate;
                if error.abs() > 4.0 * fit.ping.covariance[(0, 0)].sqrt() {
                    wrong.push(format!("{coast} s, {forcing_hz} Hz, {growth_rate}: {error:.2} 1/s off"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
