//! Faults of a rig and of its electronics, each under its right name.

use crate::driven::Driven;
use crate::short::any;
use rayon::prelude::*;
use rijke_signal::{Channel, Fault, Mishap, TwoReadings, Unstable};
use std::f64::consts::TAU;

type Harm = fn(&Driven, &mut Vec<Vec<f64>>, f64);
type Right = fn(&Fault) -> bool;

fn largest(record: &[Vec<f64>]) -> f64 {
    record.iter().flatten().fold(0.0, |a, v| v.abs().max(a))
}

/// The loudspeaker plays on after it was switched off, so loud over the largest sample at a time after that.
fn plays_on(driven: &Driven, record: &mut [Vec<f64>], loud: impl Fn(f64) -> f64) {
    let (off, top) = (driven.switched[0].1, largest(record));
    for (m, y) in record.iter_mut().enumerate() {
        let shape = (0.5 + 0.45 * m as f64).sin();
        for (n, v) in y.iter_mut().enumerate() {
            let t = n as f64 / driven.rate_hz;
            if t > off {
                *v += loud(t - off) * top * shape * (TAU * driven.forcing_hz * t).cos();
            }
        }
    }
}

/// Name, what is done to the record with a size, the sizes, and whether a reason is the right one.
fn faults() -> Vec<(&'static str, Harm, Vec<f64>, Right)> {
    vec![
        (
            "a loudspeaker that leaks",
            |driven, record, share| {
                let growth_rate = driven.modes[0].0.re;
                plays_on(driven, record, |t| share * (1.0 - (growth_rate * t).exp()));
            },
            vec![0.01, 0.03, 0.1],
            // Two of them name two reasons, this one among them.
            |fault| {
                let names_it = matches!(fault, Fault::NotFree { .. } | Fault::SecondExcitation { .. });
                names_it || matches!(fault, Fault::StillDriven { .. })
            },
        ),
        (
            "a loudspeaker that is turned down, not off",
            |driven, record, share| plays_on(driven, record, |_| share),
            vec![0.3, 0.5, 0.8],
            |fault| {
                let names_it = matches!(fault, Fault::NotFree { .. } | Fault::SecondExcitation { .. });
                let goes_on =
                    matches!(fault, Fault::Unstable(Unstable::GoesOn { .. }) | Fault::NotDecaying(_));
                let steady = matches!(fault, Fault::Unstable(Unstable::Oscillates { .. }));
                // Some of these records end 0.1 s after the forcing.
                let short = matches!(fault, Fault::ShortDecay { .. });
                names_it || goes_on || steady || short || matches!(fault, Fault::StillDriven { .. })
            },
        ),
        (
            "saturation",
            |_, record, share| {
                let top = largest(record);
                for v in record.iter_mut().flatten() {
                    *v = share * top * (*v / (share * top)).tanh();
                }
            },
            vec![0.5, 0.8, 1.2],
            // Or as one of two causes, where the decay is slower at first.
            |fault| {
                matches!(fault, Fault::Saturated { .. } | Fault::TwoReadings(TwoReadings::SlowAtFirst(..)))
            },
        ),
        (
            "strong hum",
            |driven, record, share| {
                let top = largest(record);
                for (m, y) in record.iter_mut().enumerate() {
                    for (n, v) in y.iter_mut().enumerate() {
                        let turn = TAU * 50.02 * n as f64 / driven.rate_hz;
                        *v += share * top * ((turn + m as f64).cos() + 0.3 * (3.0 * turn).cos());
                    }
                }
            },
            vec![0.1, 0.5, 1.0, 3.0],
            |fault| matches!(fault, Fault::SteadyHum { .. }),
        ),
        (
            "a dead channel that hums",
            |driven, record, share| {
                let top = largest(record);
                let mut level = 0.37;
                let y = &mut record[1];
                for (n, v) in y.iter_mut().enumerate() {
                    level = (level * 997.0 + 0.31) % 1.0;
                    *v = share * top * (TAU * 50.02 * n as f64 / driven.rate_hz).cos() + level - 0.5;
                }
            },
            vec![0.03, 0.3],
            |fault| {
                matches!(
                    fault,
                    Fault::NoSignal { channel: Channel::Place(1), .. }
                        | Fault::OnlyHum { channel: Channel::Place(1), .. }
                )
            },
        ),
        (
            "a second mode that grows by itself",
            |driven, record, share| {
                let (off, top) = (driven.switched[0].1, largest(record));
                // By a factor of three from the end of the forcing, to `share` of the loudest sample.
                let growth = 3.0_f64.ln() / (driven.end - off);
                let hz = 1.93 * driven.forcing_hz;
                for (m, y) in record.iter_mut().enumerate() {
                    for (n, v) in y.iter_mut().enumerate() {
                        let t = n as f64 / driven.rate_hz;
                        let size = share * top * (growth * (t - driven.end)).exp();
                        *v += size * (0.4 + 0.3 * m as f64).cos() * (TAU * hz * t).cos();
                    }
                }
            },
            vec![0.1, 0.5],
            |fault| matches!(fault, Fault::Unstable(Unstable::Another { .. })),
        ),
        (
            "a limit cycle",
            |driven, record, share| {
                let top = largest(record);
                for (m, y) in record.iter_mut().enumerate() {
                    for (n, v) in y.iter_mut().enumerate() {
                        let t = n as f64 / driven.rate_hz;
                        *v += top
                            * share
                            * (0.4 + 0.3 * m as f64).cos()
                            * (TAU * 1.01 * driven.forcing_hz * t).cos();
                    }
                }
            },
            vec![0.5, 10.0],
            |fault| matches!(fault, Fault::Unstable(Unstable::Oscillates { .. })),
        ),
        (
            "the mode itself grows",
            |driven, record, share| {
                let (off, top) = (driven.switched[0].1, largest(record));
                let growth = 10.0_f64.ln() / (driven.end - off);
                for (m, y) in record.iter_mut().enumerate() {
                    for (n, v) in y.iter_mut().enumerate() {
                        let t = n as f64 / driven.rate_hz;
                        let size = share * top * (growth * (t - driven.end)).exp();
                        *v += size * (0.4 + 0.3 * m as f64).cos() * (driven.modes[0].0.im * t).cos();
                    }
                }
            },
            vec![3.0],
            |fault| matches!(fault, Fault::Unstable(Unstable::Grows { .. }) | Fault::SecondExcitation { .. }),
        ),
        (
            "dropped samples",
            |driven, record, share| {
                let from = ((driven.switched[0].1 + 0.3 / -driven.modes[0].0.re) * driven.rate_hz) as usize;
                let count = (share * driven.rate_hz / driven.forcing_hz) as usize;
                for y in record.iter_mut() {
                    y.drain(from..from + count.max(1));
                }
            },
            vec![0.25, 0.5, 3.3],
            |fault| {
                matches!(
                    fault,
                    Fault::Mishap(Mishap::LostSamples { .. } | Mishap::Jumps { .. })
                        | Fault::Residual { .. }
                        | Fault::SecondExcitation { .. }
                )
            },
        ),
    ]
}

#[test]
fn behaviour_every_fault_is_named() {
    let sound = |seed| {
        let mut driven = any(100 + seed, 5.0);
        driven.channels = driven.channels.max(2);
        driven.rate_hz = driven.rate_hz.max(5000.0);
        driven.ratio = driven.ratio.max(200.0);
        let record = driven.record(seed);
        driven.fit_of(&record).is_ok().then_some((driven, record))
    };
    let sound: Vec<(Driven, Vec<Vec<f64>>)> = (0..12).into_par_iter().filter_map(sound).collect();
    let used = sound.len();
    let mut wrong = Vec::new();
    for (name, harm, sizes, right) in faults() {
        for size in sizes {
            let harmed = |(driven, record): &(Driven, Vec<Vec<f64>>)| {
                let mut record = record.clone();
                harm(driven, &mut record, size);
                driven.fit_of(&record)
            };
            let fits: Vec<_> = sound.par_iter().map(harmed).collect();
            let (mut named, mut right_all_the_same) = (0, 0);
            let mut others = Vec::new();
            for ((driven, _), fit) in sound.iter().zip(fits) {
                match fit {
                    Err(fault) if right(&fault) => named += 1,
                    Err(fault) => others.push(fault.to_string()),
                    // What is fitted right needs no reason.
                    Ok(fit)
                        if (fit.ping.s - driven.modes[0].0).re.powi(2)
                            < 16.0 * fit.ping.covariance[(0, 0)] =>
                    {
                        right_all_the_same += 1;
                    }
                    Ok(fit) => {
                        let pull = (fit.ping.s - driven.modes[0].0).re / fit.ping.covariance[(0, 0)].sqrt();
                        others.push(format!("accepted, {pull:.1} deviations off"));
                    }
                }
            }
            println!(
                "| {name} | {size} | {named} of {used} | {right_all_the_same} | {} |",
                others.join("; ")
            );
            // A leak of a tenth may be so strong that no decay is found, and one of a hundredth so faint that
            // it shifts the fit by four deviations unseen.
            // A quarter of a period that all channels lack may pass for a drift, four deviations off.
            let allowed = match name {
                "a loudspeaker that leaks" => 2,
                // Two of these records end 0.1 s after the forcing.
                "a second mode that grows by itself" => 2,
                // One is told as a decay that is too short.
                "a limit cycle" if size > 1.0 => 1,
                // Two are told as no signal, and one as a gain that drifts.
                "a limit cycle" => 3,
                "dropped samples" if size < 0.5 => 1,
                _ => 0,
            };
            if named + right_all_the_same + allowed < used {
                wrong.push(format!("{name} {size}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn behaviour_a_mode_that_sounds_all_the_time_is_not_called_the_loudspeaker() {
    let driven = Driven { quiet: 0.1, ..Driven::tube() };
    for seed in 0..4 {
        let record = driven.record(seed);
        let sounding = |from: f64, to: f64| {
            let mut record = record.clone();
            let top = largest(&record);
            for (m, y) in record.iter_mut().enumerate() {
                for (n, v) in y.iter_mut().enumerate() {
                    let t = n as f64 / driven.rate_hz;
                    if (from..to).contains(&t) {
                        *v += 12.0 * top * (0.4 + 0.3 * m as f64).cos() * (TAU * 517.0 * t).cos();
                    }
                }
            }
            driven.fit_of(&record).expect_err("another tone")
        };
        let always = sounding(0.0, driven.end);
        assert!(
            matches!(always, Fault::Unstable(Unstable::Beside { frequency_hz, .. }) if (frequency_hz - 517.0).abs() < 1.0),
            "{always}"
        );
        let (on, off) = driven.switched[0];
        let forced = sounding(on, off);
        assert!(!matches!(forced, Fault::Unstable(Unstable::Beside { .. })), "{forced}");
    }
}
