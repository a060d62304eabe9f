//! Channels that the others of their record contradict: a point goes without them, or without the records.

use super::fitted::{PingOfRecord, rejection};
use crate::{Channel, Fault};
use rijke_rig::Rejection;

/// A point keeps a channel that was left out of one of so many of its pings, and goes without these pings; of
/// a channel that carries no signal, as a loose plug does, in one of so many.
const FEW: usize = 5;
const FEW_SILENT: usize = 2;
/// Points and records that a sentence names.
const NAMED: usize = 3;

/// A channel that was left out of a record.
pub(super) struct LeftOut {
    microphone: Channel,
    point: String,
    record: String,
    reason: String,
}

/// Decides for the pings of one point, whose files have the given names: rejects the pings without a channel
/// that nearly all others have, and says what was left out of those that stay.
pub(super) fn settle(
    point: &str,
    pings: &mut Vec<PingOfRecord>,
    names: &[String],
    called: &[Channel],
    rejections: &mut Vec<Rejection>,
) -> Vec<LeftOut> {
    let mut channels: Vec<usize> = pings.iter().flat_map(|p| p.left_out.iter().map(|l| l.0)).collect();
    channels.sort_unstable();
    channels.dedup();
    for channel in channels {
        let without = |p: &PingOfRecord| p.left_out.iter().find(|l| l.0 == channel).map(|l| l.1.clone());
        let count = pings.iter().filter(|p| without(p).is_some()).count();
        let silent = |fault: &Fault| {
            matches!(fault, Fault::NoSignal { .. } | Fault::DeadChannel { .. } | Fault::OnlyHum { .. })
        };
        let few = if pings.iter().filter_map(without).all(|f| silent(&f)) { FEW_SILENT } else { FEW };
        if few * count > pings.len() {
            continue;
        }
        pings.retain(|p| {
            let fault = without(p).map(|fault| fault.called(called));
            rejections.extend(fault.as_ref().map(|fault| rejection(&names[p.repeat], fault)));
            fault.is_none()
        });
    }
    let of = |p: &PingOfRecord| -> Vec<LeftOut> {
        let said = |(channel, fault): &(usize, Fault)| LeftOut {
            microphone: called[*channel].clone(),
            point: point.to_owned(),
            record: names[p.repeat].clone(),
            reason: fault.clone().called(called).to_string(),
        };
        p.left_out.iter().map(said).collect()
    };
    pings.iter().flat_map(of).collect()
}

/// The first few of some names, and how many more there are.
pub(super) fn some_of<T: AsRef<str>>(names: &[T]) -> String {
    let first: Vec<&str> = names.iter().take(NAMED).map(AsRef::as_ref).collect();
    let more = names.len() - first.len();
    let and = if more > 0 { format!(" and {more} more") } else { String::new() };
    first.join(", ") + &and
}

/// A row of the table of what was put right.
pub(super) fn correction(left: &LeftOut) -> Rejection {
    let LeftOut { record, reason, .. } = left;
    Rejection { record: record.clone(), reason: format!("left out: {reason}") }
}

/// A sentence for every channel that was left out of some of `count` pings.
pub(super) fn in_words(all: &[LeftOut], count: usize) -> Vec<String> {
    let mut numbers: Vec<usize> = all.iter().map(|l| l.microphone.number()).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let of = |number: usize| {
        let own: Vec<&LeftOut> = all.iter().filter(|l| l.microphone.number() == number).collect();
        let mut points: Vec<&str> = own.iter().map(|l| l.point.as_str()).collect();
        points.dedup();
        let trust = format!("`dead = [{number}]`");
        let remedy = if own[0].reason.contains(&trust) {
            String::new()
        } else {
            format!(". If it cannot be trusted, write {trust} in the manifest")
        };
        format!(
            "{} was left out of {} of {count} pings, which the others fit without it: {} have no pressure there (corrections.csv \
             lists the records). The first, {}: {}{remedy}",
            own[0].microphone,
            own.len(),
            some_of(&points),
            own[0].record,
            own[0].reason
        )
    };
    numbers.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ping::{Drift, Excesses};
    use rijke_numerics::{C64, Matrix};
    use rijke_rig::Ping;

    fn pings(count: usize, without: usize, fault: &Fault) -> Vec<PingOfRecord> {
        let ping = Ping {
            s: C64::new(-9.0, 1070.0),
            pressures: vec![C64::ONE; 3],
            reference: 0,
            covariance: Matrix::identity(6),
        };
        let of = |repeat: usize| PingOfRecord {
            skipped_s: 0.0,
            pair_hz: None,
            padded_from_s: None,
            coarse: false,
            repeat,
            ping: ping.clone(),
            drift: Drift::default(),
            excess: Excesses::default(),
            noise: Vec::new(),
            live: if repeat < without { vec![0, 1] } else { vec![0, 1, 2] },
            left_out: if repeat < without { vec![(2, fault.clone())] } else { Vec::new() },
        };
        (0..count).map(of).collect()
    }

    #[test]
    fn behaviour_few_records_go_and_of_many_the_channel_does() {
        let names: Vec<String> = (0..10).map(|n| format!("ping-{n}")).collect();
        // Microphone 2 of the records is number 3 of the rig, because 1 is dead.
        let called =
            [0, 2, 3].map(|number| Channel::Microphone { number, name: format!("p{}", number + 1).into() });
        let drifts =
            Fault::GainDrifts { channel: 2.into(), growth_rates: [-8.9, -9.0], sd: 0.01, distance: 10.0 };
        let silent = Fault::NoSignal { channel: 2.into(), ratio: 0.01, median: 900.0 };
        for (fault, count, without, rejected, left) in [
            (&drifts, 10, 1, 1, 0),
            (&drifts, 10, 2, 2, 0),
            (&drifts, 10, 3, 0, 3),
            (&drifts, 3, 1, 0, 1),
            (&drifts, 1, 1, 0, 1),
            (&silent, 10, 5, 5, 0),
            (&silent, 10, 6, 0, 6),
            (&silent, 3, 1, 1, 0),
            (&silent, 3, 3, 0, 3),
        ] {
            let (mut all, mut rejections) = (pings(count, without, fault), Vec::new());
            let said = settle("a", &mut all, &names, &called, &mut rejections);
            assert_eq!((rejections.len(), said.len(), all.len()), (rejected, left, count - rejected));
            let words = in_words(&said, count);
            assert_eq!(words.len(), usize::from(left > 0));
            if let Some(first) = words.first() {
                let start = format!("microphone 3 (p4) was left out of {left} of {count} pings");
                assert!(first.starts_with(&start) && first.contains("`dead = [3]`"), "{first}");
                let reason = correction(&said[0]).reason;
                assert!(reason.starts_with("left out: ") && reason.contains("microphone 3 (p4)"), "{reason}");
            }
        }
    }
}
