//! Records in which a microphone is dead: the others are used, under the numbers that they have in the rig.

use crate::{Channel, Fault};
use rijke_rig::{Acquisition, Microphones, Record};

/// A record without the channels that hold nothing.
#[derive(Clone, Debug)]
pub struct LiveRecord {
    /// The rest of the record.
    pub record: Record,
    /// The microphones of its channels, ascending.
    pub live: Vec<usize>,
    /// The place of the reference microphone among them; the first if it is dead.
    pub reference: usize,
}

impl LiveRecord {
    /// Leaves out the channels without samples.
    #[must_use]
    pub fn of(mut record: Record, reference: usize) -> Self {
        let live: Vec<usize> =
            (0..record.channels.len()).filter(|m| !record.channels[*m].is_empty()).collect();
        record.channels.retain(|channel| !channel.is_empty());
        let reference = live.iter().position(|m| *m == reference).unwrap_or(0);
        Self { record, live, reference }
    }
}

impl Fault {
    /// The fault of a record of which it saw the channels at `places` alone.
    pub(crate) fn within(self, places: &[usize]) -> Self {
        self.called(&places.iter().copied().map(Channel::Place).collect::<Vec<_>>())
    }

    /// The same with its channels called as `others` call those at their places.
    #[must_use]
    pub fn called(mut self, others: &[Channel]) -> Self {
        if let Self::UnequalChannels { channel, .. }
        | Self::NotFinite { channel, .. }
        | Self::Spike { channel, .. }
        | Self::Clipped { channel, .. }
        | Self::DeadChannel { channel, .. }
        | Self::NoSignal { channel, .. }
        | Self::NoImpulse { channel, .. }
        | Self::LongImpulse { channel, .. }
        | Self::StrangeReflection(channel, ..)
        | Self::LoudHum(channel, ..)
        | Self::ShortImpulse { channel, .. }
        | Self::ImpulseAtEdge { channel, .. }
        | Self::Coarse { channel, .. }
        | Self::Saturated { channel, .. }
        | Self::SteadyHum { channel, .. }
        | Self::OnlyHum { channel, .. }
        | Self::Dropout { channel, .. }
        | Self::Residual { channel, .. }
        | Self::GainDrifts { channel, .. }
        | Self::Inverted(channel) = &mut self
        {
            channel.call(others);
        }
        if let Self::GainsApart { channels, .. } = &mut self {
            channels.iter_mut().for_each(|channel| channel.call(others));
        }
        if let Self::SameChannels(first, second) = &mut self {
            first.call(others);
            second.call(others);
        }
        if let Self::OutOfOrder(found) = &mut self {
            found.call(others);
        }
        self
    }
}

/// The microphones of a set of records, as the rig calls them.
pub(super) fn of_rig(acquisition: &Acquisition, microphones: &Microphones) -> Vec<Channel> {
    let count = microphones.positions.len();
    let names = [&microphones.names, &acquisition.reading.microphones].into_iter().find(|n| n.len() == count);
    let by_number = Microphones::by_number(count + acquisition.removed.len());
    let name = |place: usize, number: usize| names.map_or(&by_number[number], |names| &names[place]);
    let numbers = acquisition.numbers(count).into_iter().enumerate();
    numbers
        .map(|(place, number)| Channel::Microphone { number, name: name(place, number).as_str().into() })
        .collect()
}

/// The microphones that are in all of several ascending lists.
pub(super) fn in_all<'a>(mut lists: impl Iterator<Item = &'a Vec<usize>>) -> Vec<usize> {
    let first = lists.next().cloned().unwrap_or_default();
    lists.fold(first, |all, list| all.into_iter().filter(|m| list.contains(m)).collect())
}
