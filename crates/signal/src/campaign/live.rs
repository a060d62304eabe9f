//! Records in which a microphone is dead: the others are used, under the numbers that they have in the rig.

use crate::Fault;
use rijke_rig::Record;

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
    /// The same with a channel under the number that `numbers` has for it.
    pub(crate) fn numbered(mut self, numbers: &[usize]) -> Self {
        if let Self::UnequalChannels { channel, .. }
        | Self::NotFinite { channel, .. }
        | Self::Spike { channel, .. }
        | Self::Clipped { channel, .. }
        | Self::DeadChannel { channel, .. }
        | Self::NoSignal { channel, .. }
        | Self::NoImpulse { channel, .. }
        | Self::LongImpulse { channel, .. }
        | Self::ShortImpulse { channel, .. }
        | Self::ImpulseAtEdge { channel, .. }
        | Self::Coarse { channel, .. }
        | Self::Saturated { channel, .. }
        | Self::SteadyHum { channel, .. }
        | Self::OnlyHum { channel, .. }
        | Self::Dropout { channel, .. }
        | Self::Residual { channel, .. }
        | Self::GainDrifts { channel, .. }
        | Self::Inverted { channel } = &mut self
            && let Some(number) = numbers.get(*channel)
        {
            *channel = *number;
        }
        if let Self::GainsApart { channels, .. } = &mut self {
            channels.iter_mut().for_each(|c| *c = numbers.get(*c).copied().unwrap_or(*c));
        }
        self
    }
}

/// The microphones that are in all of several ascending lists.
pub(super) fn in_all<'a>(mut lists: impl Iterator<Item = &'a Vec<usize>>) -> Vec<usize> {
    let first = lists.next().cloned().unwrap_or_default();
    lists.fold(first, |all, list| all.into_iter().filter(|m| list.contains(m)).collect())
}
