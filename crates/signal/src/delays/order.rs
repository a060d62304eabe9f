//! Whether delays are those of channels, or those of channels that were exchanged.
//!
//! Two channels a travel time T apart that are exchanged have delays that differ by 2T, and none otherwise:
//! what lies below T/2 is no exchange, and T is where sound would come to the farther one first. A converter
//! that takes its channels one after the other does so within one sample, which may be more than T/2.

use super::error::CalibrationError;
use crate::order::{ChannelExchange, by_arrival};

/// Share of the travel time between two channels by which their delays may differ.
const HALF: f64 = 0.5;
/// How far the slope of times over those expected may be from -1 where sound runs the other way, and the
/// share of their variance beside the line: an impulse is heard first some tenths of its length early or
/// late.
const BACK: f64 = 0.25;

/// Two channels whose delays differ by more than those of channels do.
struct Apart {
    /// The second has the larger delay.
    channels: [usize; 2],
    difference: f64,
    travel: f64,
}

/// The two channels, `step` the time between two samples, of which that is most so.
fn apart(delays: &[f64], expected: &[f64], step: f64) -> Option<Apart> {
    let count = delays.len();
    let pairs = (0..count).flat_map(|a| (0..count).map(move |b| [a, b]));
    let of = |channels: [usize; 2]| {
        let [a, b] = channels;
        let travel = (expected[b] - expected[a]).abs();
        Apart { channels, difference: delays[b] - delays[a], travel }
    };
    let limit = |p: &Apart| (HALF * p.travel).max(step).min(p.travel);
    let beyond = pairs.map(of).filter(|p| p.travel > 0.0 && p.difference > limit(p));
    beyond.max_by(|p, q| (p.difference / limit(p)).total_cmp(&(q.difference / limit(q))))
}

/// The exchange that makes delays those of channels where they are not; how far the delays of its two
/// outermost channels are apart, as they are and exchanged back; and the travel time between these.
fn exchange(delays: &[f64], expected: &[f64], step: f64) -> Option<(ChannelExchange, [f64; 2], f64)> {
    apart(delays, expected, step)?;
    let times: Vec<f64> = delays.iter().zip(expected).map(|(d, x)| d + x).collect();
    let order = by_arrival(expected, &times);
    let back: Vec<f64> = order.iter().zip(expected).map(|(m, x)| times[*m] - x).collect();
    let exchange = ChannelExchange::of(&order, expected)?;
    let [a, b] = [exchange.channels.first()?.number(), exchange.channels.last()?.number()];
    let between = |values: &[f64]| (values[b] - values[a]).abs();
    let found = (exchange, [between(delays), between(&back)], between(expected));
    apart(&back, expected, step).is_none().then_some(found)
}

/// Refuses channels that are exchanged in any click.
pub(super) fn in_order(clicks: &[Vec<f64>], expected: &[f64], step: f64) -> Result<(), CalibrationError> {
    let found: Vec<_> = clicks.iter().map(|delays| exchange(delays, expected, step)).collect();
    let Some(click) = found.iter().position(Option::is_some) else { return Ok(()) };
    let Some((exchange, delays, travel)) = &found[click] else { return Ok(()) };
    let same =
        |other: &&Option<(ChannelExchange, [f64; 2], f64)>| matches!(other, Some((e, ..)) if e == exchange);
    Err(CalibrationError::Exchanged {
        exchange: exchange.clone(),
        clicks: found.iter().filter(same).count(),
        of: clicks.len(),
        click,
        first: None,
        delays: *delays,
        travel: *travel,
    })
}

/// Whether sound runs the other way: the times at which channels hear it, over those at which they should,
/// are a straight line that falls as sound would rise it. Two channels would look the same if exchanged.
fn comes_back(heard: &[f64], expected: &[f64]) -> bool {
    let n = heard.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let (x, y) = (mean(expected), mean(heard));
    let product =
        |a: &[f64], x: f64, b: &[f64], y: f64| a.iter().zip(b).map(|(a, b)| (a - x) * (b - y)).sum::<f64>();
    let (xx, yy) = (product(expected, x, expected, x), product(heard, y, heard, y));
    let xy = product(expected, x, heard, y);
    heard.len() > 2 && (xy / xx + 1.0).abs() < BACK && xy * xy > (1.0 - BACK) * xx * yy
}

/// Refuses channels that are exchanged in half of the clicks or more, by the times at which they are first
/// `heard`, to a sample or two.
pub(crate) fn exchanged(heard: &[Vec<f64>], expected: &[f64], rate_hz: f64) -> Result<(), CalibrationError> {
    let late = |times: &Vec<f64>| times.iter().zip(expected).map(|(t, x)| t - x).collect::<Vec<f64>>();
    let fitting: Vec<&Vec<f64>> = heard.iter().filter(|times| times.len() == expected.len()).collect();
    let back = fitting.iter().filter(|times| comes_back(times, expected)).count();
    if back > 0 && 2 * back >= fitting.len() {
        let by_place = |a: &usize, b: &usize| expected[*a].total_cmp(&expected[*b]);
        let channels = || 0..expected.len();
        let ends = [channels().max_by(by_place), channels().min_by(by_place)].map(Option::unwrap_or_default);
        return Err(CalibrationError::OtherEnd {
            ends: ends.map(Into::into),
            clicks: back,
            of: fitting.len(),
        });
    }
    match in_order(&fitting.into_iter().map(late).collect::<Vec<_>>(), expected, 2.0 / rate_hz) {
        Err(CalibrationError::Exchanged { clicks, of, .. }) if 2 * clicks < of => Ok(()),
        found => found,
    }
}

/// Refuses delays of which two differ by more than those of channels do.
pub(super) fn alike(delays: &[f64], expected: &[f64], step: f64) -> Result<(), CalibrationError> {
    match apart(delays, expected, step) {
        Some(Apart { channels, difference, travel }) => {
            Err(CalibrationError::UnequalDelays { channels: channels.map(Into::into), difference, travel })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Travel times to five microphones, of which two are near each other, s.
    const EXPECTED: [f64; 5] = [437e-6, 787e-6, 1515e-6, 1748e-6, 2418e-6];
    const STEP: f64 = 1.0 / 51_200.0;

    #[test]
    fn exact_every_exchange_is_told_from_delays_of_channels() {
        let own = [0.0, -8e-6, 5e-6, 3e-6, -1e-6];
        let both = |delays: &[f64], step: f64| {
            in_order(&[delays.to_vec(), delays.to_vec()], &EXPECTED, step)
                .and_then(|()| alike(delays, &EXPECTED, step))
        };
        let of = |delays: &[f64]| both(delays, STEP);
        assert_eq!(of(&own), Ok(()));
        for a in 0..5 {
            for b in a + 1..5 {
                let mut times: Vec<f64> = own.iter().zip(EXPECTED).map(|(d, x)| d + x).collect();
                times.swap(a, b);
                let delays: Vec<f64> = times.iter().zip(EXPECTED).map(|(t, x)| t - x).collect();
                let said = of(&delays).unwrap_err().to_string();
                let named = format!("channel {a} and channel {b} are exchanged in 2 of 2 calibration clicks");
                assert!(said.starts_with(&named), "{said}");
            }
        }
        // A converter of 8 kHz that takes one channel after the other, and a delay that none has.
        let slow = |delays: &[f64]| both(delays, 1.0 / 8e3);
        assert_eq!(slow(&[0.0, 25e-6, 50e-6, 75e-6, 100e-6]), Ok(()));
        assert_eq!(slow(&[0.0, 0.0, 124e-6, 0.0, 0.0]), Ok(()));
        let said = of(&[0.0, 0.0, 0.0, 0.0, 400e-6]).unwrap_err().to_string();
        assert!(
            said.starts_with("the clicks arrive 400 us later at channel 4, relative to channel 3,"),
            "{said}"
        );
    }

    #[test]
    fn behaviour_a_click_at_the_other_end_is_told_from_an_exchange() {
        let heard: Vec<f64> = EXPECTED.iter().map(|t| 3e-3 - t).collect();
        let said = exchanged(&[heard.clone(), heard], &EXPECTED, 51_200.0).unwrap_err().to_string();
        assert!(
            said.starts_with("sound comes to channel 4 first and to channel 0 last in 2 of 2 "),
            "{said}"
        );
        assert_eq!(exchanged(&[EXPECTED.to_vec(), EXPECTED.to_vec()], &EXPECTED, 51_200.0), Ok(()));
    }

    #[test]
    fn message_an_exchange_in_some_clicks_names_the_first_of_them() {
        let wrong = [0.0, 0.0, 233e-6, -233e-6, 0.0].to_vec();
        let clicks = [vec![0.0; 5], wrong.clone(), vec![0.0; 5], wrong];
        let fault = in_order(&clicks, &EXPECTED, STEP).unwrap_err();
        let said = fault.with_names(&["a", "b", "c", "d"]).to_string();
        let start = "channel 2 and channel 3 are exchanged in 2 of 4 calibration clicks, the first of them b. \
                     Their delays differ by 466 us, and by 0 us if they are exchanged back; sound takes 233 us";
        assert!(said.starts_with(start), "{said}");
    }
}
