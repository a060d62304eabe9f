//! Whether sound takes times from microphone to microphone that a gas can give it.

use crate::Fault;
use crate::order::{ChannelExchange, OutOfOrder, by_arrival};
use rijke_numerics::Matrix;
use rijke_rig::{Click, Gas, RecordSet};

/// Temperatures between which the gas of a rig is, K: from cold vapour of nitrogen to a flame.
const TEMPERATURES: [f64; 2] = [150.0, 4000.0];
/// Speed of a mean flow that a rig has at most, m/s.
const FLOW: f64 = 50.0;
/// Standard deviations that a time may be beyond what is possible.
const BEYOND: f64 = 5.0;

/// Two neighbours along the tube, and the time from the first to the second.
struct Stretch {
    pair: [usize; 2],
    travel: f64,
    between: [f64; 2],
    error: f64,
}

impl Stretch {
    fn is_possible(&self) -> bool {
        let slack = BEYOND * self.error;
        self.travel > self.between[0] - slack && self.travel < self.between[1] + slack
    }
}

/// Refuses a click of which the arrival times are none of a sound that travels along the tube. `calibration`
/// is the covariance of the delays, which the click does not have.
pub(super) fn check(set: &RecordSet, click: &Click, calibration: &Matrix) -> Result<(), Fault> {
    let covariance = click.covariance.plus(1.0, calibration);
    let speeds = speeds(&set.rig.gas, set.rig.pressure);
    among(&set.rig.microphones.positions, click, &covariance, speeds).map_err(Fault::from)
}

/// The slowest and the fastest sound of a gas, m/s. The law of its heat capacity holds from 250 to 1500 K;
/// beyond, the ratio of specific heats stays as it is there.
fn speeds(gas: &Gas, pressure: f64) -> [f64; 2] {
    let speed = |t: f64| {
        let held = gas.at(t.clamp(250.0, 1500.0), pressure);
        held.sound_speed * (t / held.temperature).sqrt()
    };
    [speed(TEMPERATURES[0]) - FLOW, speed(TEMPERATURES[1]) + FLOW]
}

fn among(
    places: &[f64],
    click: &Click,
    covariance: &Matrix,
    [slowest, fastest]: [f64; 2],
) -> Result<(), OutOfOrder> {
    let times = &click.arrival_times;
    let mut along: Vec<usize> = (0..places.len()).collect();
    along.sort_by(|a, b| places[*a].total_cmp(&places[*b]));
    let error = |a: usize, b: usize| {
        (covariance[(a, a)] + covariance[(b, b)] - 2.0 * covariance[(a, b)]).max(0.0).sqrt()
    };
    // The channel whose record counts at each place is `heard`.
    let stretches = |heard: &dyn Fn(usize) -> usize| -> Vec<Stretch> {
        let of = |pair: &[usize]| {
            let [a, b] = [heard(pair[0]), heard(pair[1])];
            let length = places[pair[1]] - places[pair[0]];
            Stretch {
                pair: [pair[0], pair[1]],
                travel: times[b] - times[a],
                between: [length / fastest, length / slowest],
                error: error(a, b),
            }
        };
        along.windows(2).map(of).collect()
    };
    let all = stretches(&|m| m);
    let Some(wrong) = all.iter().find(|s| !s.is_possible()) else { return Ok(()) };
    let order = by_arrival(places, times);
    let back = stretches(&|m| order[m]);
    let moved = ChannelExchange::of(&order, places).filter(|_| back.iter().all(Stretch::is_possible));
    let backwards = all.iter().find(|s| s.travel < 0.0);
    Err(match (moved, backwards) {
        (Some(exchange), Some(Stretch { pair, travel, .. })) => {
            OutOfOrder::Exchanged { exchange, pair: pair.map(Into::into), early: -travel }
        }
        _ => OutOfOrder::Travel {
            pair: wrong.pair.map(Into::into),
            travel: wrong.travel,
            between: wrong.between,
            temperatures: TEMPERATURES,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACES: [f64; 5] = [0.15, 0.27, 0.52, 0.6, 0.83];

    fn of(speed: f64, order: [usize; 5], sd: f64) -> Result<(), OutOfOrder> {
        let arrival_times = order.iter().map(|m| 2e-3 + PLACES[*m] / speed).collect();
        let covariance = Matrix::diagonal(&[sd * sd; 5]);
        among(&PLACES, &Click { arrival_times, covariance: covariance.clone() }, &covariance, [195.0, 1280.0])
    }

    /// A cubic of the heat capacity of air with a tenth of carbon dioxide is below zero at 4000 K.
    #[test]
    fn exact_a_hot_gas_beyond_the_law_of_its_heat_capacity_has_a_speed_of_sound() {
        let heat_capacity = [27.525, 7.7513e-3, 8.208e-7, -1.023e-9];
        let mixed = Gas { molar_mass: 30.474e-3, heat_capacity, ..Gas::air() };
        assert!(!mixed.at(4000.0, 101_325.0).sound_speed.is_finite());
        // gamma is 1.30 at 1500 K, and 1.41 at 250 K.
        for (gas, molar_mass) in [(mixed, 30.474e-3), (Gas::air(), 28.97e-3)] {
            let [slowest, fastest] = speeds(&gas, 101_325.0);
            let c = |gamma: f64, t: f64| (gamma * 8.314_46 / molar_mass * t).sqrt();
            assert!((slowest - (c(1.40, 150.0) - FLOW)).abs() < 3.0, "{slowest}");
            assert!((fastest - (c(1.305, 4000.0) + FLOW)).abs() < 15.0, "{fastest}");
        }
    }

    #[test]
    fn exact_sound_of_any_gas_passes_and_channels_that_were_exchanged_are_named() {
        let right = [0, 1, 2, 3, 4];
        for speed in [246.0, 343.0, 700.0, 1230.0] {
            assert_eq!(of(speed, right, 1e-6), Ok(()));
        }
        for (a, b) in [(0, 1), (1, 2), (2, 3), (0, 4), (1, 4)] {
            let mut order = right;
            order.swap(a, b);
            let said = of(343.0, order, 1e-6).unwrap_err().to_string();
            assert!(said.starts_with(&format!("channel {a} and channel {b} are exchanged: ")), "{said}");
        }
        // Nothing is said of what noise can do.
        assert_eq!(of(343.0, [0, 1, 3, 2, 4], 1e-4), Ok(()));
        let said = of(3e3, right, 1e-6).unwrap_err().to_string();
        assert!(
            said.starts_with("sound takes 40 us from channel 0 to channel 1, and it takes 94 to "),
            "{said}"
        );
    }
}
