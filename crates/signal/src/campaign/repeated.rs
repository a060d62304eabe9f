//! The repeats of one operating point: polarity, outliers, mean.

use super::fitted::rejection;
use crate::Fault;
use crate::repeats::{Repeats, combine};
use rijke_numerics::{C64, Matrix};
use rijke_rig::{Click, Ping, Rejection};

/// Turns a channel that has the opposite sign of the other repeats', and says which, by its number in the
/// rig.
pub(super) fn turn_inverted(
    pings: &mut [(usize, Ping)],
    names: &[String],
    numbers: &[usize],
) -> Vec<Rejection> {
    if pings.len() < 3 {
        return Vec::new();
    }
    let channels = pings[0].1.pressures.len();
    let middle = |part: fn(&C64) -> f64, m: usize| {
        let mut values: Vec<f64> = pings.iter().map(|(_, p)| part(&p.pressures[m])).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let typical: Vec<C64> =
        (0..channels).map(|m| C64::new(middle(|p| p.re, m), middle(|p| p.im, m))).collect();
    let mut turned = Vec::new();
    for (repeat, ping) in pings {
        let inverted = |m: usize| (ping.pressures[m] + typical[m]).norm() < 0.3 * typical[m].norm();
        let others: Vec<usize> = (0..channels).filter(|&m| m != ping.reference).collect();
        let wrong: Vec<usize> = others.iter().copied().filter(|&m| inverted(m)).collect();
        let channel = match wrong[..] {
            [channel] => channel,
            // All but the reference: it is the reference that is inverted.
            _ if wrong.len() > 1 && wrong.len() == others.len() => ping.reference,
            _ => continue,
        };
        for &m in &wrong {
            ping.pressures[m] = -ping.pressures[m];
        }
        let place = |i: usize| i.checked_sub(2).map(|i| others[i / 2]);
        let sign = |i: usize| if place(i).is_some_and(|m| wrong.contains(&m)) { -1.0 } else { 1.0 };
        let covariance = &ping.covariance;
        ping.covariance = Matrix::from_fn(covariance.rows(), covariance.columns(), |i, j| {
            sign(i) * sign(j) * covariance[(i, j)]
        });
        turned.push(rejection(&names[*repeat], &Fault::Inverted { channel }.numbered(numbers)));
    }
    turned
}

/// Mean of the pings; outliers move to the rejections.
pub(super) fn combine_pings(
    pings: &mut Vec<(usize, Ping)>,
    names: &[String],
    numbers: &[usize],
    rejections: &mut Vec<Rejection>,
) -> Option<Repeats> {
    let reference = pings.first()?.1.reference;
    let values: Vec<(f64, Vec<f64>, Matrix)> =
        pings.iter().map(|(n, p)| (*n as f64, p.vector(), p.covariance.clone())).collect();
    let repeats = combine(&values, &|i| match i {
        0 => "growth rate".to_owned(),
        1 => "angular frequency".to_owned(),
        _ => {
            let place = (i - 2) / 2;
            let channel = numbers[place + usize::from(place >= reference)];
            format!(
                "{} part of the pressure of channel {channel}",
                if i % 2 == 0 { "real" } else { "imaginary" }
            )
        }
    })?;
    remove_outliers(pings, &repeats, names, rejections);
    Some(repeats)
}

pub(super) fn combine_clicks(
    clicks: &mut Vec<(usize, Click)>,
    names: &[String],
    numbers: &[usize],
    rejections: &mut Vec<Rejection>,
) -> Option<Repeats> {
    let values: Vec<(f64, Vec<f64>, Matrix)> =
        clicks.iter().map(|(n, c)| (*n as f64, c.arrival_times.clone(), c.covariance.clone())).collect();
    let repeats = combine(&values, &|i| format!("arrival time at channel {}", numbers[i]))?;
    remove_outliers(clicks, &repeats, names, rejections);
    Some(repeats)
}

fn remove_outliers<T>(
    items: &mut Vec<(usize, T)>,
    repeats: &Repeats,
    names: &[String],
    rejections: &mut Vec<Rejection>,
) {
    for (place, fault) in &repeats.outliers {
        rejections.push(rejection(&names[items[*place].0], fault));
    }
    let mut place = 0;
    items.retain(|_| {
        place += 1;
        !repeats.outliers.iter().any(|(n, _)| *n + 1 == place)
    });
}

/// The mean of [`Ping::vector`] back as a ping.
pub(super) fn ping_of(repeats: &Repeats, reference: usize) -> Ping {
    let mut pressures: Vec<C64> = repeats.mean[2..].chunks_exact(2).map(|p| C64::new(p[0], p[1])).collect();
    pressures.insert(reference, C64::ONE);
    Ping {
        s: C64::new(repeats.mean[0], repeats.mean[1]),
        pressures,
        reference,
        covariance: repeats.covariance.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ping(turned: &[usize]) -> (usize, Ping) {
        let sign = |m: usize| if turned.contains(&m) { -1.0 } else { 1.0 };
        let pressure = |m: usize| C64::new(0.3 + 0.2 * m as f64, 0.01) * (sign(m) * sign(1));
        let mut pressures: Vec<C64> = (0..4).map(pressure).collect();
        pressures[1] = C64::ONE;
        let rows = |i: usize| if i < 2 { 1.0 } else { sign([0, 2, 3][(i - 2) / 2]) * sign(1) };
        let covariance = Matrix::from_fn(8, 8, |i, j| rows(i) * rows(j) / (1.0 + i.abs_diff(j) as f64));
        (0, Ping { s: C64::new(-9.0, 1070.0), pressures, reference: 1, covariance })
    }

    #[test]
    fn exact_an_inverted_channel_is_turned_with_its_covariance() {
        for (turned, channel) in [(vec![2], 2), (vec![0], 0), (vec![1], 1)] {
            let mut pings = vec![ping(&[]), ping(&turned), ping(&[]), ping(&[])];
            let names: Vec<String> = (0..4).map(|n| format!("ping-{n}")).collect();
            pings.iter_mut().enumerate().for_each(|(n, p)| p.0 = n);
            let said = turn_inverted(&mut pings, &names, &[0, 1, 2, 3]);
            assert_eq!(said.len(), 1);
            assert_eq!(said[0].record, "ping-1");
            assert_eq!(said[0].reason, format!("channel {channel} has the opposite polarity"));
            assert_eq!(pings[1].1, pings[0].1);
        }
    }
}
