//! Repeats whose pressures disagree by far more than their noise: channels that were exchanged in some of
//! them, or something that no gain explains alone.

use super::gains::{OfPoint, Scatter, gains_in_words, wandering};
use super::left_out::some_of;
use crate::Channel;
use rijke_numerics::C64;
use rijke_rig::{ModeRows, Ping};

/// Two pressures agree that differ by so little: relative to the largest of the point, or in standard
/// deviations.
const AGREE: f64 = 0.02;
const AGREE_SDS: f64 = 6.0;
/// Two pressures whose exchange would be seen differ by this, relative to the larger one.
const DIFFER: f64 = 0.1;

/// Says in which repeats channels were exchanged, which microphones have a gain that changes between them,
/// and of which else the pressure does.
pub(super) fn apart(points: &[OfPoint<'_>]) -> Vec<String> {
    let (mut exchanges, mut others) = (Vec::new(), Vec::new());
    for point in points {
        match Exchange::of(point) {
            Some(exchange) => exchanges.push(exchange),
            None => others.push(point),
        }
    }
    let mut said = Exchange::in_words(&mut exchanges);
    let found = wandering(&others);
    said.extend(gains_in_words(&found));
    let found: Vec<(usize, &str)> = found.iter().map(|f| (f.0.number(), f.1)).collect();
    said.extend(disagreeing(&others, &found));
    said
}

/// Two channels that were exchanged in some pings of a point, which then all agree.
struct Exchange<'a> {
    channels: [&'a Channel; 2],
    point: &'a str,
    /// The records that say the one, and the other; the fewer first.
    sides: [Vec<&'a str>; 2],
}

impl<'a> Exchange<'a> {
    /// The exchange that explains why the pings of a point disagree, if there is one.
    fn of(of: &'a OfPoint<'a>) -> Option<Self> {
        let count = of.microphones.len();
        if Scatter::of_point(of).iter().all(|s| s.of_largest < AGREE) {
            return None;
        }
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
        let (_, first) = of.pings.first()?;
        let differ = |[a, b]: &[usize; 2]| {
            let apart = (first.pressures[*a] - first.pressures[*b]).norm();
            apart > DIFFER * first.pressures[*a].norm().max(first.pressures[*b].norm())
        };
        pairs.filter(differ).find_map(|[a, b]| {
            let exchanged = |ping: &Ping| {
                let mut pressures = ping.pressures.clone();
                pressures.swap(a, b);
                let base = pressures[ping.reference];
                pressures.iter().map(|p| p / base).collect::<Vec<C64>>()
            };
            let near = |ping: &Ping, pressures: &[C64]| {
                let largest = pressures.iter().chain(&first.pressures).map(|p| p.norm()).fold(1.0, f64::max);
                let near = (AGREE * largest).max(AGREE_SDS * largest * error(ping).max(error(first)));
                pressures.iter().zip(&first.pressures).all(|(p, q)| (p - q).norm() <= near)
            };
            let mut sides = [Vec::new(), Vec::new()];
            for (repeat, ping) in of.pings {
                let side = if near(ping, &ping.pressures) {
                    0
                } else if near(ping, &exchanged(ping)) {
                    1
                } else {
                    return None;
                };
                sides[side].push(of.names[*repeat].as_str());
            }
            sides.sort_by_key(Vec::len);
            let channels = [&of.microphones[a], &of.microphones[b]];
            (!sides[0].is_empty()).then_some(Self { channels, point: of.point, sides })
        })
    }

    /// A sentence for every pair of channels.
    fn in_words(all: &mut [Self]) -> Vec<String> {
        let numbers = |e: &Self| e.channels.map(Channel::number);
        all.sort_by_key(numbers);
        let of = |own: &[Self]| {
            let Self { channels: [a, b], sides: [one, other], .. } = &own[0];
            let points: Vec<&str> = own.iter().map(|e| e.point).collect();
            format!(
                "{a} and {b} are exchanged in {} against {}: if they are exchanged back in the ones or in the others, all repeats agree. So it is at {}, \
                 whose mean pressures mix the two and have large errors. Check the wiring, and give the right `channels` of the wrong \
                 files in an [[exception]] of the manifest",
                some_of(one),
                some_of(other),
                some_of(&points)
            )
        };
        all.chunk_by(|a, b| numbers(a) == numbers(b)).map(of).collect()
    }
}

/// The largest standard deviation among the pressures of a ping.
fn error(ping: &Ping) -> f64 {
    (ModeRows::pressure(0)..ping.covariance.rows())
        .map(|i| ping.covariance[(i, i)])
        .fold(0.0, f64::max)
        .sqrt()
}

/// Says of which microphones the pressure differs between repeats, where nothing else was said of it.
fn disagreeing(points: &[&OfPoint<'_>], said: &[(usize, &str)]) -> Vec<String> {
    let mut found: Vec<(&Channel, &str, Scatter)> = Vec::new();
    for of in points {
        // Where the reference was named, it explains them all.
        if said.contains(&(of.microphones[of.reference].number(), of.point)) {
            continue;
        }
        let others = of.microphones.iter().enumerate().filter(|(m, _)| *m != of.reference).map(|(_, c)| c);
        for (microphone, scatter) in others.zip(Scatter::of_point(of)) {
            if scatter.is_said() && !said.contains(&(microphone.number(), of.point)) {
                found.push((microphone, of.point, scatter));
            }
        }
    }
    found.sort_by_key(|f| f.0.number());
    let say = |of: &[(&Channel, &str, Scatter)]| {
        let points: Vec<&str> = of.iter().map(|f| f.1).collect();
        let most = |size: fn(&Scatter) -> f64| of.iter().map(|f| size(&f.2)).fold(0.0, f64::max);
        format!(
            "the pressure of {} differs between the repeats of {} by up to {:.0} times what their noise explains ({:.1} % of the largest pressure \
             there): mode shapes carry this as an error. Look at it in ping-repeats.csv: a plug may have been moved, a gain changed, or a \
             record may be of another point",
            of[0].0,
            some_of(&points),
            most(|s| s.of_noise),
            100.0 * most(|s| s.of_largest)
        )
    };
    found.chunk_by(|a, b| a.0 == b.0).map(say).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repeats::combine;
    use rijke_numerics::Matrix;

    /// What is said of four repeats of four microphones, whose pressures the function changes.
    fn said(change: impl Fn(usize, &mut Vec<C64>)) -> (Vec<String>, Vec<String>) {
        let sd = 1e-4;
        let ping = |n: usize| {
            let noise = |m: usize| sd * C64::new(((7 * n + 3 * m) as f64).sin(), ((5 * n + m) as f64).cos());
            let mut pressures: Vec<C64> =
                [1.0, 0.62, -0.45, 0.8].iter().enumerate().map(|(m, p)| p + noise(m)).collect();
            change(n, &mut pressures);
            let base = pressures[0];
            let pressures = pressures.iter().map(|p| p / base).collect();
            (
                n,
                Ping {
                    s: C64::new(-9.0, 1e3),
                    pressures,
                    reference: 0,
                    covariance: Matrix::diagonal(&[sd * sd; 8]),
                },
            )
        };
        let pings: Vec<(usize, Ping)> = (0..4).map(ping).collect();
        let values: Vec<_> =
            pings.iter().map(|(n, p)| (*n as f64, p.vector(), p.covariance.clone())).collect();
        let repeats = combine(&values, &|k| k.to_string()).unwrap();
        let names: Vec<String> = (0..4).map(|n| format!("ping-{n}")).collect();
        let microphones: Vec<Channel> =
            (0..4).map(|number| Channel::Microphone { number, name: format!("m{number}").into() }).collect();
        let of = OfPoint {
            point: "a",
            repeats: &repeats,
            microphones,
            reference: 0,
            pings: &pings,
            names: &names,
        };
        let mut exchanges: Vec<Exchange<'_>> = Exchange::of(&of).into_iter().collect();
        (Exchange::in_words(&mut exchanges), disagreeing(&[&of], &[]))
    }

    #[test]
    fn message_channels_that_are_exchanged_in_some_repeats_are_named() {
        assert_eq!(said(|_, _| ()), (Vec::new(), Vec::new()));
        for (pair, few) in [([1, 2], 2), ([0, 1], 2), ([2, 3], 1)] {
            let (exchanged, apart) = said(|n, p| {
                if n < few {
                    p.swap(pair[0], pair[1])
                }
            });
            let start = format!(
                "microphone {0} (m{0}) and microphone {1} (m{1}) are exchanged in ping-0",
                pair[0], pair[1]
            );
            assert!(exchanged.len() == 1 && exchanged[0].starts_with(&start), "{exchanged:?}");
            assert!(exchanged[0].contains("[[exception]]") && !apart.is_empty(), "{exchanged:?}");
        }
    }

    #[test]
    fn message_repeats_that_disagree_are_said_once_for_a_channel() {
        let (exchanged, apart) = said(|n, p| p[2] *= 1.0 + 0.1 * n as f64);
        assert!(exchanged.is_empty() && apart.len() == 1, "{exchanged:?} {apart:?}");
        assert!(
            apart[0]
                .starts_with("the pressure of microphone 2 (m2) differs between the repeats of a by up to")
        );
        assert!(said(|n, p| p[2] *= 1.0 + 1e-3 * n as f64).1.is_empty());
    }
}
