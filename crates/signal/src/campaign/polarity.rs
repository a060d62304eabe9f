//! The polarity of channels among the repeats of one operating point. Most repeats say which is right; where
//! as many say the one as the other, nobody knows.

use super::fitted::rejection;
use super::left_out::some_of;
use crate::{Channel, Fault};
use rijke_numerics::Matrix;
use rijke_rig::{ModeRows, Ping, Rejection};

/// A pressure is that of another record, or its opposite, if it lies so near to it: in standard deviations,
/// or relative to it, as gains may change.
const NEAR_SDS: f64 = 6.0;
const NEAR: f64 = 0.1;

/// A channel that has one polarity in some pings of a point and the opposite one in as many.
pub(super) struct Tie {
    /// The microphone: the reference, if all others turn together.
    microphone: Channel,
    is_reference: bool,
    point: String,
    /// Records that say the one, and the other.
    sides: [Vec<String>; 2],
}

/// What became of the polarities of a point.
pub(super) struct Polarities {
    /// Records in which a channel was turned, or goes without it.
    pub(super) corrections: Vec<Rejection>,
    pub(super) ties: Vec<Tie>,
    /// Places of the channels whose sign is not known, ascending.
    pub(super) unknown: Vec<usize>,
}

/// For every ping whether channel `m` has the pressure of the others (1), the opposite one (-1), or neither
/// (0), with respect to that ping with which most agree.
fn signs(pings: &[(usize, Ping)], m: usize, row: usize) -> Vec<i32> {
    let square = |k: usize| {
        let c = &pings[k].1.covariance;
        (c[(row, row)] + c[(row + 1, row + 1)]).max(0.0)
    };
    let with = |base: usize| -> Vec<i32> {
        let z = pings[base].1.pressures[m];
        let sign = |k: usize| {
            let own = pings[k].1.pressures[m];
            let near = (NEAR * z.norm()).max(NEAR_SDS * (square(k) + square(base)).sqrt());
            i32::from((own - z).norm() <= near) * 2 + i32::from((own + z).norm() <= near)
        };
        // What is near to both is near zero, and has no sign.
        (0..pings.len()).map(|k| [0, -1, 1, 1][sign(k) as usize]).collect()
    };
    let agree = |signs: &Vec<i32>| signs.iter().filter(|s| **s != 0).count();
    (0..pings.len()).map(with).reduce(|a, b| if agree(&b) > agree(&a) { b } else { a }).unwrap_or_default()
}

/// Turns a channel that has the opposite sign of most other repeats', and says which; a channel of which
/// there is no most is unknown.
pub(super) fn set_polarity(
    point: &str,
    pings: &mut [(usize, Ping)],
    names: &[String],
    called: &[Channel],
) -> Polarities {
    let mut found = Polarities { corrections: Vec::new(), ties: Vec::new(), unknown: Vec::new() };
    let Some((_, first)) = pings.first() else { return found };
    let reference = first.reference;
    let others: Vec<usize> = (0..first.pressures.len()).filter(|&m| m != reference).collect();
    let mut told: Vec<Vec<i32>> =
        others.iter().enumerate().map(|(i, m)| signs(pings, *m, ModeRows::pressure(i))).collect();
    let mut sides: Vec<(usize, [Vec<usize>; 2])> = Vec::new();
    for (signs, m) in told.iter_mut().zip(&others) {
        let of = |sign: i32| -> Vec<usize> { (0..signs.len()).filter(|k| signs[*k] == sign).collect() };
        let (usual, opposite) = (of(1), of(-1));
        if opposite.is_empty() || 2 * usual.len() > signs.len() {
            continue;
        }
        if 2 * opposite.len() > signs.len() {
            signs.iter_mut().for_each(|s| *s = -*s);
        } else {
            // In the order of their records, whichever is called usual.
            let mut both = [usual, opposite];
            both.sort_by_key(|side| side.first().copied());
            sides.push((*m, both));
            signs.fill(1);
        }
    }
    for (k, (repeat, ping)) in pings.iter_mut().enumerate() {
        let wrong: Vec<usize> =
            others.iter().zip(&told).filter(|(_, signs)| signs[k] < 0).map(|(m, _)| *m).collect();
        let channel = match wrong[..] {
            [channel] => channel,
            // All but the reference: it is the reference that is inverted.
            _ if wrong.len() > 1 && wrong.len() == others.len() => reference,
            _ => continue,
        };
        turn(ping, &others, &wrong);
        found.corrections.push(rejection(&names[*repeat], &Fault::Inverted(channel.into()).called(called)));
    }
    let together =
        sides.len() > 1 && sides.len() == others.len() && sides.iter().all(|(_, s)| *s == sides[0].1);
    let named = if together { &sides[..1] } else { &sides[..] };
    for (m, s) in named {
        let files = |k: &usize| names[pings[*k].0].clone();
        let tie = Tie {
            microphone: called[if together { reference } else { *m }].clone(),
            is_reference: together,
            point: point.to_owned(),
            sides: s.each_ref().map(|side| side.iter().map(files).collect()),
        };
        let reason = format!(
            "left out: {} has one polarity in some pings of this point, and the opposite one in as many",
            if together {
                format!("every pressure, because {}", tie.microphone)
            } else {
                tie.microphone.to_string()
            }
        );
        let row = |record: &String| Rejection { record: record.clone(), reason: reason.clone() };
        found.corrections.extend(tie.sides.iter().flatten().map(row));
        found.ties.push(tie);
    }
    found.unknown = sides.into_iter().map(|(m, _)| m).collect();
    found
}

/// Turns the pressures of some of the channels `others` than the reference, with their covariance.
fn turn(ping: &mut Ping, others: &[usize], wrong: &[usize]) {
    for &m in wrong {
        ping.pressures[m] = -ping.pressures[m];
    }
    let place = |i: usize| i.checked_sub(2).map(|i| others[i / 2]);
    let sign = |i: usize| if place(i).is_some_and(|m| wrong.contains(&m)) { -1.0 } else { 1.0 };
    let covariance = &ping.covariance;
    ping.covariance = Matrix::from_fn(covariance.rows(), covariance.columns(), |i, j| {
        sign(i) * sign(j) * covariance[(i, j)]
    });
}

/// A sentence for every microphone whose polarity is not known somewhere.
pub(super) fn ties_in_words(ties: &[Tie]) -> Vec<String> {
    let mut numbers: Vec<usize> = ties.iter().map(|t| t.microphone.number()).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let of = |number: usize| {
        let own: Vec<&Tie> = ties.iter().filter(|t| t.microphone.number() == number).collect();
        let Tie { microphone, is_reference, sides: [one, other], .. } = own[0];
        let points: Vec<&str> = own.iter().map(|t| t.point.as_str()).collect();
        let have = if points.len() == 1 { "has" } else { "have" };
        let (who, what) = if *is_reference {
            (
                format!("all others turn against {microphone}, the reference, which"),
                "no pressures but its own",
            )
        } else {
            (microphone.to_string(), "no pressure of it")
        };
        format!(
            "{who} has one polarity in {} and the opposite one in {}: neither is in the majority, so the sign is left as it is, and {} {have} {what} \
             (corrections.csv lists the records). Check the wiring, and leave out of `pings` the records in which it was wrong; where two \
             channels were exchanged, give the `channels` of these files in an [[exception]] of the manifest",
            some_of(one),
            some_of(other),
            some_of(&points)
        )
    };
    numbers.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::C64;

    /// Four channels, the reference is 1, some of them turned.
    fn ping(repeat: usize, turned: &[usize]) -> (usize, Ping) {
        let sign = |m: usize| if turned.contains(&m) { -1.0 } else { 1.0 };
        let pressure = |m: usize| C64::new(0.3 + 0.2 * m as f64, 0.01) * (sign(m) * sign(1));
        let mut pressures: Vec<C64> = (0..4).map(pressure).collect();
        pressures[1] = C64::ONE;
        let rows = |i: usize| if i < 2 { 1.0 } else { sign([0, 2, 3][(i - 2) / 2]) * sign(1) };
        let covariance =
            Matrix::from_fn(8, 8, |i, j| 1e-6 * rows(i) * rows(j) / (1.0 + i.abs_diff(j) as f64));
        (repeat, Ping { s: C64::new(-9.0, 1070.0), pressures, reference: 1, covariance })
    }

    fn found(turned: &[&[usize]]) -> (Vec<(usize, Ping)>, Polarities) {
        let mut pings: Vec<_> = turned.iter().enumerate().map(|(n, turned)| ping(n, turned)).collect();
        let names: Vec<String> = (0..turned.len()).map(|n| format!("ping-{n}")).collect();
        let called =
            [0, 1, 2, 3].map(|number| Channel::Microphone { number, name: format!("p{number}").into() });
        let found = set_polarity("a", &mut pings, &names, &called);
        (pings, found)
    }

    #[test]
    fn exact_an_inverted_channel_is_turned_with_its_covariance() {
        for channel in [2, 0, 1] {
            let (pings, said) = found(&[&[], &[channel], &[], &[]]);
            assert_eq!((said.corrections.len(), said.unknown.len()), (1, 0));
            assert_eq!(said.corrections[0].record, "ping-1");
            let reason = format!("microphone {channel} (p{channel}) has the opposite polarity");
            assert_eq!(said.corrections[0].reason, reason);
            assert_eq!(pings[1].1, pings[0].1);
        }
        // Most of the records are turned.
        let (pings, said) = found(&[&[], &[3], &[3]]);
        assert_eq!(said.corrections[0].record, "ping-0");
        assert_eq!(pings[0].1, pings[1].1);
    }

    #[test]
    fn behaviour_of_as_many_as_not_nothing_is_turned() {
        for (turned, unknown, named) in [
            (vec![2], vec![2], "microphone 2 (p2)"),
            (vec![0, 3], vec![0, 3], "microphone 0 (p0)"),
            (vec![1], vec![0, 2, 3], "all others turn against microphone 1 (p1), the reference, which"),
        ] {
            for records in [2, 4] {
                let of = |n: usize| if n < records / 2 { &turned[..] } else { &[] };
                let all: Vec<&[usize]> = (0..records).map(of).collect();
                let (pings, said) = found(&all);
                assert_eq!(said.unknown, unknown);
                assert!(pings.iter().enumerate().all(|(n, p)| *p == ping(n, all[n])));
                let words = ties_in_words(&said.ties);
                let start = format!("{named} has one polarity in ping-0");
                assert!(words[0].starts_with(&start), "{words:?}");
                assert!(words[0].contains(&format!("opposite one in ping-{}", records / 2)), "{words:?}");
                assert_eq!(words.len(), if turned.len() > 1 { 2 } else { 1 });
            }
        }
    }

    #[test]
    fn behaviour_another_pressure_of_the_opposite_sign_is_no_reversal() {
        let mut pings: Vec<_> = (0..4).map(|n| ping(n, &[])).collect();
        // As where it was exchanged with one whose pressure is 0.7 times as large.
        pings[0].1.pressures[2] *= -0.7;
        let before = pings.clone();
        let names: Vec<String> = (0..4).map(|n| format!("ping-{n}")).collect();
        let said = set_polarity("a", &mut pings, &names, &[0, 1, 2, 3].map(Channel::Place));
        assert!(said.corrections.is_empty() && said.unknown.is_empty() && pings == before);
    }
}
