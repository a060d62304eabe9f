//! The repeats of one operating point: outliers, mean.

use super::fitted::rejection;
use crate::Channel;
use crate::repeats::{Repeats, combine};
use rijke_numerics::Matrix;
use rijke_rig::{Click, Ping, Rejection};

/// Part of their frequency by which pings of one mode never differ: the speed of sound of a point is
/// steadier.
const OTHER: f64 = 0.03;

/// Pings of other modes than most move to the rejections; all of them, where none has most.
fn leave_one_mode(pings: &mut Vec<(usize, Ping)>, names: &[String], rejections: &mut Vec<Rejection>) {
    let mut ascending: Vec<f64> = pings.iter().map(|(_, p)| p.s.im).collect();
    ascending.sort_by(f64::total_cmp);
    let groups: Vec<&[f64]> = ascending.chunk_by(|a, b| b - a < OTHER * b.abs()).collect();
    if groups.len() < 2 {
        return;
    }
    let hertz = |group: &[f64]| group[group.len() / 2] / std::f64::consts::TAU;
    let all = groups.iter().map(|g| format!("{} at {:.1} Hz", g.len(), hertz(g)));
    let all = all.collect::<Vec<_>>().join(", ");
    let most = groups.iter().find(|g| 2 * g.len() > pings.len()).map(|g| [g[0], g[g.len() - 1]]);
    let which = match most {
        Some(_) => "this is not the mode of most",
        None => "no mode has most of them",
    };
    pings.retain(|(name, ping)| {
        let keep = most.is_some_and(|[low, high]| (low..=high).contains(&ping.s.im));
        if !keep {
            rejections.push(Rejection {
                record: names[*name].clone(),
                reason: format!(
                    "{:.1} Hz: the pings of this point are of several modes ({all}), and {which}. Give the band of one mode, `band_hz` in the \
                     manifest or --band, and process the records once for each",
                    ping.s.im / std::f64::consts::TAU
                ),
            });
        }
        keep
    });
}

/// Mean of the pings; outliers and other modes move to the rejections.
pub(super) fn combine_pings(
    pings: &mut Vec<(usize, Ping)>,
    names: &[String],
    called: &[Channel],
    rejections: &mut Vec<Rejection>,
) -> Option<Repeats> {
    leave_one_mode(pings, names, rejections);
    let reference = pings.first()?.1.reference;
    let values: Vec<(f64, Vec<f64>, Matrix)> =
        pings.iter().map(|(n, p)| (*n as f64, p.vector(), p.covariance.clone())).collect();
    let repeats = combine(&values, &|i| match i {
        0 => "growth rate".to_owned(),
        1 => "angular frequency".to_owned(),
        _ => {
            let place = (i - 2) / 2;
            let channel = &called[place + usize::from(place >= reference)];
            format!("{} part of the pressure of {channel}", if i % 2 == 0 { "real" } else { "imaginary" })
        }
    })?;
    remove_outliers(pings, &repeats, names, rejections);
    Some(repeats)
}

pub(super) fn combine_clicks(
    clicks: &mut Vec<(usize, Click)>,
    names: &[String],
    called: &[Channel],
    rejections: &mut Vec<Rejection>,
) -> Option<Repeats> {
    let values: Vec<(f64, Vec<f64>, Matrix)> =
        clicks.iter().map(|(n, c)| (*n as f64, c.arrival_times.clone(), c.covariance.clone())).collect();
    let repeats = combine(&values, &|i| format!("arrival time at {}", called[i]))?;
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

/// What single pings cannot tell, in a sentence, if no point has more.
pub(super) fn unrepeated(pings: impl Iterator<Item = usize>) -> Option<String> {
    (pings.max() == Some(1)).then(|| {
        "no point has more than one ping, so the scatter between pings is not known, and the stated errors include only the noise of the \
         records; they may be many times too small. Measure some points several times, with the rig set anew in between"
            .to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::C64;

    #[test]
    fn behaviour_single_pings_everywhere_are_said() {
        let said = |pings: &[usize]| unrepeated(pings.iter().copied()).is_some();
        assert_eq!([said(&[1, 0, 1]), said(&[1, 2]), said(&[0]), said(&[])], [true, false, false, false]);
    }

    #[test]
    fn message_pings_of_two_modes_are_never_averaged() {
        let left = |hertz: &[f64]| {
            let at = |(n, hz): (usize, &f64)| {
                let s = C64::new(-9.0, hz * std::f64::consts::TAU);
                let covariance = Matrix::identity(2);
                (n, Ping { s, pressures: vec![C64::ONE], reference: 0, covariance })
            };
            let mut pings: Vec<_> = hertz.iter().enumerate().map(at).collect();
            let names: Vec<String> = (0..hertz.len()).map(|n| format!("ping-{n}")).collect();
            let mut rejections = Vec::new();
            leave_one_mode(&mut pings, &names, &mut rejections);
            (pings.iter().map(|p| p.0).collect::<Vec<_>>(), rejections)
        };
        // A degree of air is 0.2 %.
        assert_eq!(left(&[170.0, 170.9, 169.1]), (vec![0, 1, 2], Vec::new()));
        let (kept, said) = left(&[52.2, 219.2, 52.3, 52.1]);
        assert_eq!((kept, said.len(), said[0].record.as_str()), (vec![0, 2, 3], 1, "ping-1"));
        for part in ["219.2 Hz: ", "3 at 52.2 Hz, 1 at 219.2 Hz", "not the mode of most", "`band_hz`"] {
            assert!(said[0].reason.contains(part), "{}", said[0].reason);
        }
        let (kept, said) = left(&[52.2, 219.2, 52.3, 219.1]);
        assert!(
            kept.is_empty() && said.len() == 4 && said[3].reason.contains("no mode has most"),
            "{said:?}"
        );
    }
}
